"""Scene files: YAML 1.2, of which JSON is a part. See docs/files.md for what they say.

`read` and `write` speak of the parts of a scene; the scene itself is put together above this layer.
"""

from __future__ import annotations

import contextlib
import os
import re
from collections.abc import Mapping, Sequence
from pathlib import Path
from typing import Any, Protocol

from ..collector import without_collector
from ..shapes.base import Shape
from ..shapes.body import Body
from ..shapes.material import Material
from ..shapes.repeated import Repeated
from ..shapes.vector import FloatArray
from . import scene_text, yaml_parser
from .alike import document
from .atomic import real_path, write_text
from .data_files import array_name, keep_array
from .errors import Problem, SceneFileError
from .expansion import MAX_PARTS, PARTS, expanded_parts, most_parts
from .nodes import is_null
from .plain import ShapeWriter, body_data
from .reading import Reader, TooManyProblems
from .scene_reader import Parts, Progress, SceneReader
from .sections import VERSION
from .yaml_parser import Unreadable
from .yaml_writer import dump, json_text

__all__ = ["SUFFIXES", "Parts", "Progress", "SceneLike", "parsed", "read", "scene_data", "write"]


class SceneLike(Protocol):
    """What can be written: a scene, or its parts."""

    @property
    def bodies(self) -> Sequence[Body]: ...
    @property
    def lights(self) -> Sequence[Any]: ...
    @property
    def camera(self) -> Any: ...
    @property
    def background(self) -> Any: ...
    @property
    def domain(self) -> Any: ...


_XML = re.compile(r"\s*<(?:\?xml|!--|geometry|model|materials)")


def read(path: str | os.PathLike[str], progress: Progress | None = None, outside: bool = False) -> Parts:
    """The parts of the scene in a file; progress(done, count) is called now and then, half of it for the letters.

    outside: may pictures of textures lie outside of the file's folder?
    Raises SceneFileError with every mistake found.
    """
    text = scene_text.read_text(path)
    if _XML.match(text):
        found = (
            "is XML; scene files are YAML or JSON, and `conicoid import`, or co.load_openmc, reads OpenMC's geometries"
        )
        raise SceneFileError(path, [Problem(0, 0, "", found)])
    return parsed(text, path, progress, outside)


def parsed(text: str, path: str | os.PathLike[str], progress: Progress | None = None, outside: bool = False) -> Parts:
    """The parts of the scene in a text, which `path` holds. Raises SceneFileError with every mistake found."""
    with without_collector():
        return _parsed(text, path, progress, outside)


def _parsed(text: str, path: str | os.PathLike[str], progress: Progress | None, outside: bool) -> Parts:
    size = len(text)
    try:
        found = document(text, progress and (lambda done: progress(done, 2 * size)))
    except Unreadable as error:
        raise SceneFileError(path, [error.problem]) from None
    root = found.root
    if root is None or is_null(root):
        raise SceneFileError(path, [*found.problems, Problem(0, 0, "", "is empty, a scene file has at least `bodies`")])
    reader = Reader(Path(path).resolve().parent)
    reader.takes_any_file = outside
    reader.problems.extend(found.problems)
    parts = Parts(())
    with contextlib.suppress(TooManyProblems):
        scene = SceneReader(reader, found)
        scene.progress = progress and (lambda done, count: progress(size + size * done // count, 2 * size))
        parts = scene.read(root)
    if reader.problems:
        raise SceneFileError(path, reader.problems)
    return parts


_TOLD = 256  # bodies between two words of progress
SUFFIXES = (".yaml", ".yml", ".json")
"""Of files that scenes are saved to."""


def write(
    scene: SceneLike, path: str | os.PathLike[str], material_names: Mapping[Material, str] | None = None,
    progress: Progress | None = None,
) -> None:  # fmt: skip
    """Write a scene so that reading gives an equal one: floats to the last bit, motions step by step.

    Materials stand under the names given for them, others under letters. progress(done, count) is called with numbers
    of bodies.

    More than 100 balls of a `Spheres` go to a .npy file beside the scene, named after it and after its content:
    no file of balls is ever overwritten or removed, so that whatever refers to one keeps what it had. They are
    written first and the scene last. Files appear whole or not at all. Raises OSError where they cannot be
    written, ValueError for what a file cannot say, and for another suffix than .yaml, .yml or .json: a geometry.xml
    that a scene was imported from is not to become a scene file.
    """
    if not os.fspath(path).lower().endswith(SUFFIXES):
        ending = os.path.splitext(path)[1]
        hint = "" if len(ending) > 1 else f": {os.fspath(path).rstrip('.')}.yaml, say"
        raise ValueError(f"{os.fspath(path)}: scenes are saved as .yaml or .json{hint}")
    final = real_path(path)
    with without_collector():
        _write(scene, path, final, material_names, progress)


def _write(
    scene: SceneLike, path: str | os.PathLike[str], final: Path, material_names: Mapping[Material, str] | None,
    progress: Progress | None,
) -> None:  # fmt: skip
    about = _parts_of_repeated(scene.bodies)
    if about > MAX_PARTS:
        raise ValueError(f"{final}: a scene file may have {MAX_PARTS:,} {PARTS} this scene has about {about:,}")
    stem = re.sub(r"[^\w.-]", "_", final.stem)[:40]
    bulk: dict[str, FloatArray] = {}

    def keep(of: str, table: FloatArray) -> str:
        name = array_name(final.parent, f"{stem}-{of}", table)
        bulk[name] = table
        return name

    data = scene_data(scene, keep, material_names=material_names, folder=final.parent, progress=progress)
    count = _values(data)
    parts, most = expanded_parts(_shapes(scene)), most_parts(count)
    if parts > most:
        found = f"a scene file of this size may have {most:,} {PARTS} this scene has {parts:,}"
        raise ValueError(f"{final}: {found}")
    if count > yaml_parser.MAX_NODES:
        found = f"a scene file holds at most {yaml_parser.MAX_NODES:,} values, this scene takes {count:,}"
        raise ValueError(f"{final}: {found}: write bodies apart, or balls as one Spheres")
    text = json_text(data) if Path(path).suffix.lower() == ".json" else dump(data)
    size = len(text.encode())
    if size > scene_text.MAX_BYTES:
        found = f"a scene file has at most {scene_text.MAX_BYTES >> 20} MB, this scene takes {size >> 20} MB"
        raise ValueError(f"{final}: {found}: write bodies apart, or balls as one Spheres")
    for name, table in bulk.items():
        keep_array(final.with_name(name), table)
    write_text(path, text)


def _parts_of_repeated(bodies: Sequence[Body]) -> int:
    """About how many parts bodies have that are others moved: that of the first of a kind for each; 0 for others."""
    if not isinstance(bodies, Repeated):
        return 0
    firsts = (bodies.shape(int(numbers[0])) for numbers in bodies.members if len(numbers))
    counts = (len(numbers) for numbers in bodies.members if len(numbers))
    return sum(count * expanded_parts([shape]) for shape, count in zip(firsts, counts, strict=True))


def _values(data: Any) -> int:
    """How many values a scene file has, as its parser counts them."""
    count, pending = 0, [data]
    while pending:
        value = pending.pop()
        count += 1
        if isinstance(value, dict):
            count += len(value)
            pending += value.values()
        elif isinstance(value, (list, tuple)):
            pending += value
    return count


def scene_data(
    scene: SceneLike, keep: Any, defaults: bool = False, material_names: Mapping[Material, str] | None = None,
    folder: Path | None = None, progress: Progress | None = None,
) -> dict[str, Any]:  # fmt: skip
    """The sections of a scene file, those that say nothing left out; with `defaults` not so a record's fields."""
    writer = ShapeWriter(_shapes(scene), keep, defaults, material_names, folder)
    domain = {} if scene.domain is None else {"domain": writer.data(scene.domain)}
    bodies = []
    for number, body in enumerate(scene.bodies):
        if progress is not None and number % _TOLD == 0:
            progress(number, len(scene.bodies))
        bodies.append(body_data(body, writer))
    sections: dict[str, Any] = {"conicoid": VERSION}
    if scene.camera is not None:
        tagged = writer.value(scene.camera)
        sections["camera"] = tagged.get("Camera", tagged)
    if scene.background is not None:
        sections["background"] = writer.value(scene.background)
    sections |= {"lights": [writer.value(light) for light in scene.lights]} if scene.lights else {}
    tracks = getattr(scene, "animation", ())  # imported models have none
    animation = {"animation": [writer.value(track) for track in tracks]} if tracks else {}
    sections |= {"materials": writer.materials} if writer.materials else {}
    sections |= {"shapes": writer.named} if writer.named else {}
    return sections | domain | {"bodies": bodies} | animation


def _shapes(scene: SceneLike) -> list[Shape]:
    """The shapes of the bodies, and the domain."""
    return [body.shape for body in scene.bodies] + ([] if scene.domain is None else [scene.domain])
