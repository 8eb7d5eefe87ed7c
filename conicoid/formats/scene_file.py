"""Scene files: YAML 1.2, of which JSON is a part. See docs/files.md for what they say.

`read` and `write` speak of the parts of a scene; the scene itself is put together above this layer.
"""

from __future__ import annotations

import contextlib
import os
import re
from collections.abc import Callable, Mapping, Sequence
from dataclasses import dataclass
from pathlib import Path
from typing import Any, Protocol, TypeAlias

from ..shapes import REGISTRY
from ..shapes.animation import BodyTrack, LightTrack
from ..shapes.base import Shape, Solid
from ..shapes.body import Body
from ..shapes.material import Material, renamed
from ..shapes.suggestion import known_names
from ..shapes.vector import FloatArray
from . import scene_text, yaml_parser
from .atomic import real_path, write_text
from .bulk_nodes import read_index
from .collector import without_collector
from .data_files import array_name, keep_array
from .errors import Problem, SceneFileError
from .expansion import PARTS, Allowance, expanded_parts, most_parts
from .fields import MaterialKind
from .kinds import Integer, Text
from .nodes import Listing, Node, Scalar, Table, is_nothing, is_null, is_text, shortened, shown
from .plain import ShapeWriter, body_data
from .plain_bodies import PlainBodies
from .reading import BAD, Bad, Reader, TooManyProblems
from .sections import BODY, SECTIONS, VERSION, BackgroundKind, CameraKind, animation_kind, light_kind, material_kind
from .shape_nodes import ShapeReader
from .yaml_parser import Unreadable, document
from .yaml_writer import dump, json_text


@dataclass(frozen=True)
class Parts:
    """What a scene file holds."""

    bodies: tuple[Body, ...]
    lights: tuple[Any, ...] = ()
    camera: Any = None
    background: Any = None
    domain: Any = None
    animation: tuple[Any, ...] = ()


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


_STEP = 500
"""Bodies from one report of progress to the next."""
_XML = re.compile(r"\s*<(?:\?xml|!--|geometry|model|materials)")


Progress: TypeAlias = Callable[[int, int], Any]
"""Is called with how much is done, and of how much."""


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
        scene = _SceneReader(reader, found.distinct)
        scene.progress = progress and (lambda done, count: progress(size + size * done // count, 2 * size))
        parts = scene.read(root)
    if reader.problems:
        raise SceneFileError(path, reader.problems)
    return parts


class _SceneReader:
    """Reads the sections of one file; on mistakes it goes on, and what it returns is not used."""

    progress: Progress | None = None
    """Of the bodies."""

    def __init__(self, reader: Reader, values: int) -> None:
        self.reader = reader
        self.values = values
        self.body_names: dict[str, int] = {}
        self.unnamed: dict[int, Body] = {}

    def read(self, root: Node) -> Parts:
        if not isinstance(root, Table):
            self.reader.expected(root, "scene", f"a mapping with {', '.join(SECTIONS)}")
            return Parts(())
        self.reader.entries(root, "scene", SECTIONS, ("bodies",))
        given = {name: node for name, node in root.entries.items() if not is_null(node) or name == "background"}
        self._version(given.get("conicoid"))
        camera = CameraKind().read(given["camera"], self.reader, "camera") if "camera" in given else None
        lights = light_kind().read(given["lights"], self.reader, "lights") if "lights" in given else ()
        background = (
            BackgroundKind().read(given["background"], self.reader, "background") if "background" in given else None
        )
        self._read_materials(given.get("materials"))
        shapes = ShapeReader(self.reader, self._named(given.get("shapes"), "shapes"), Allowance(self.values))
        shapes.read_named()
        bodies = self._bodies(root.entries.get("bodies"), shapes)
        domain = shapes.read(given["domain"], "domain", Solid) if "domain" in given else None
        if isinstance(domain, Solid):
            shapes.charge_body(given["domain"], "domain", domain)
        animation = self._animation(given["animation"], bodies, lights) if "animation" in given else ()
        return Parts(bodies, () if lights is BAD else lights, camera, background, domain, animation)

    def _animation(self, node: Node, bodies: tuple[Body, ...], lights: Any) -> Any:
        """Tracks, of bodies and lights that there are."""
        tracks = animation_kind().read(node, self.reader, "animation")
        for i, track in enumerate(() if tracks is BAD else tracks):
            if isinstance(track, BodyTrack) and all(body.name != track.body for body in bodies):
                names = sorted(body.name for body in bodies if body.name)
                told = f"unknown body {shortened(track.body)!r}; {known_names(track.body, 'named bodies', names)}"
                self.reader.report(node, f"animation[{i}]", told)
            if isinstance(track, LightTrack) and lights is not BAD and track.light >= len(lights):
                told = f"unknown light {track.light}; there are {len(lights)}, from 0 on"
                self.reader.report(node, f"animation[{i}]", told)
        return () if tracks is BAD else tracks

    def _version(self, node: Node | None) -> None:
        if node is not None and Integer().read(node, self.reader, "conicoid") not in (VERSION, BAD):
            self.reader.expected(node, "conicoid", f"{VERSION}, the version of the format that this program reads")

    def _named(self, node: Node | None, where: str) -> dict[str, Node]:
        """A section of named things."""
        if node is None:
            return {}
        if not isinstance(node, Table):
            self.reader.expected(node, where, "a mapping from names to " + where)
            return {}
        for name, key in node.keys.items():
            if not name or not is_text(key):
                self.reader.report(key, where, f"a name must be a text, got {shortened(name) or 'nothing'} (quote it)")
        return node.entries

    def _read_materials(self, node: Node | None) -> None:
        kind = material_kind()
        for name, item in self._named(node, "materials").items():
            made = kind.read(item, self.reader, f'material "{shortened(name)}"')
            nameless = name and isinstance(made, Material) and not _says_name(item)
            self.reader.materials[name] = renamed(made, name) if nameless else made

    def _bodies(self, node: Node | None, shapes: ShapeReader) -> tuple[Body, ...]:
        if node is None:
            return ()
        if not isinstance(node, Listing):
            none = "; of no bodies at all: `bodies: []`" if is_null(node) else ""
            found = f"must be a list of bodies, each with a shape, got {shown(node)}{none}"
            self.reader.report(node, "bodies", found)
            return ()
        bodies, plain = [], PlainBodies(shapes, self.reader.materials, self.body_names)
        for i, item in enumerate(node.items):
            where = f"bodies[{i}]"
            if self.progress is not None and i % _STEP == 0:
                self.progress(i, len(node.items))
            body = self.unnamed.get(id(item)) or plain.read(item) or self._body(item, where, shapes)
            if isinstance(body, Body):
                shapes.charge_body(item, where, body.shape)
                bodies.append(body)
                if body.name is None:
                    self.unnamed[id(item)] = body  # an alias stands for the same body
        return tuple(bodies)

    def _body(self, node: Node, where: str, shapes: ShapeReader) -> Body | Bad:
        name = node.entries.get("name") if isinstance(node, Table) else None
        if isinstance(name, Scalar) and is_text(name):
            where = f'body "{shortened(name.text)}"'
        self.reader.entries(node, where, BODY, ("shape",), _IN_BODIES)
        if not isinstance(node, Table) or "shape" not in node.entries:
            return BAD
        entries = node.entries
        named = None if name is None or _is_null(name) else self._name(name, where)
        shape = shapes.moved(shapes.read(entries["shape"], where), entries.get("move"), where)
        material = self._material(entries["material"], f"{where}: material") if "material" in entries else None
        several = self._several(entries, where)
        if any(isinstance(part, Bad) for part in (shape, material, named, *several)):
            return BAD
        materials, index = several
        body: Body | Bad = self.reader.made(
            node, where, lambda: Body(shape, material, named, materials=materials, material_index=index)
        )
        return body

    def _several(self, entries: Mapping[str, Node], where: str) -> tuple[Any, Any]:
        """Materials of many bodies in one entry, and which each has."""
        materials, index = entries.get("materials"), entries.get("material_index")
        found: Any = None
        if isinstance(materials, Listing):
            found = [self._material(item, f"{where}: materials[{i}]") for i, item in enumerate(materials.items)]
            found = BAD if any(isinstance(item, Bad) for item in found) else found
        elif materials is not None:
            found = self.reader.expected(materials, f"{where}: materials", "a list of materials")
        return found, None if index is None else read_index(index, self.reader, f"{where}: material_index")

    def _name(self, node: Node, where: str) -> Any:
        name = Text().read(node, self.reader, f"{where}: name")
        if name is not BAD:
            if name in self.body_names:
                line = self.body_names[name]
                return self.reader.report(node, where, f"name {shortened(name)!r} is taken by the body in line {line}")
            self.body_names[name] = node.line
        return name

    def _material(self, node: Node, where: str) -> Any:
        return None if _is_null(node) else MaterialKind().read(node, self.reader, where)


def _says_name(material: Node) -> bool:
    """Whether a material under a key has an argument `name`, if only null; else the key is its name."""
    arguments = next(iter(material.entries.values()), None) if isinstance(material, Table) else None
    return isinstance(arguments, Table) and "name" in arguments.entries


def _is_null(node: Node) -> bool:
    """Whether null is written, and not just nothing."""
    return is_null(node) and not is_nothing(node)


_IN_BODIES = {
    **dict.fromkeys(("color", "colour"), "its material may be a colour"),
    **dict.fromkeys(REGISTRY, "known: material, move, name, shape; write {shape: {Name: {...}}}"),
    **dict.fromkeys(
        ("type", "kind", "radius", "center"), "known: material, move, name, shape; write {shape: {Sphere: {radius: 2}}}"
    ),
    **dict.fromkeys(
        ("translate", "rotate", "scale", "transform", "position", "rotation", "translation"),
        "motions are a list: {move: [{translate: [0, 0, 1]}]}",
    ),
}
"""What is no entry of a body."""
SUFFIXES = (".yaml", ".yml", ".json")
"""Of files that scenes are saved to."""


def write(scene: SceneLike, path: str | os.PathLike[str], material_names: Mapping[Material, str] | None = None) -> None:
    """Write a scene so that reading gives an equal one: floats to the last bit, motions step by step.

    Materials stand under the names given for them, others under letters.

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
        _write(scene, path, final, material_names)


def _write(
    scene: SceneLike, path: str | os.PathLike[str], final: Path, material_names: Mapping[Material, str] | None
) -> None:
    stem = re.sub(r"[^\w.-]", "_", final.stem)[:40]
    bulk: dict[str, FloatArray] = {}

    def keep(of: str, table: FloatArray) -> str:
        name = array_name(final.parent, f"{stem}-{of}", table)
        bulk[name] = table
        return name

    data = scene_data(scene, keep, material_names=material_names, folder=final.parent)
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
    folder: Path | None = None,
) -> dict[str, Any]:  # fmt: skip
    """The sections of a scene file, those that say nothing left out; with `defaults` not so a record's fields."""
    writer = ShapeWriter(_shapes(scene), keep, defaults, material_names, folder)
    domain = {} if scene.domain is None else {"domain": writer.data(scene.domain)}
    bodies = [body_data(body, writer) for body in scene.bodies]
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
