"""Read and write scene files: YAML 1.2, with JSON as a part of it. `docs/files.md` describes the format.

`SceneReader` turns nodes into the parts of a scene; `read_scene`, `parse_scene` and `write_scene` are the entry points.
They work on `SceneParts`: `Scene` itself belongs to a layer above.
"""

from __future__ import annotations

import contextlib
import os
import re
from collections.abc import Callable, Iterable, Mapping, Sequence
from itertools import repeat
from pathlib import Path
from typing import Any, Protocol, TypeAlias

from ..._util.arrays import FloatArray
from ..._util.files import Problem, SceneFileError, resolve_links, write_text
from ..._util.process import pause_gc
from ..._util.records import construct_many, dataclass
from ..._util.text import describe_names
from ...geometry.body import Body, check_materials
from ...geometry.entries import LENGTH_UNITS
from ...geometry.instances import InstanceList
from ...geometry.shape import Shape, Solid
from ...geometry.tracks import BodyTrack, LightTrack
from ...materials.material import Material, rename_material
from ..npz import array_file_name, save_array_once
from . import yaml_parser, yaml_parser as scene_text
from .body_patterns import DocumentItem, GroupBody, PatternDocument, PatternItem, build_groups, parse_patterned_document
from .fields import (
    BODY_KEYS,
    SCENE_VERSION,
    SECTIONS,
    BackgroundType,
    CameraType,
    MaterialType,
    animation_type,
    light_type,
    material_type,
)
from .nodes import (
    BAD,
    BadValue,
    IntegerType,
    MappingNode,
    Node,
    NodeReader,
    ScalarNode,
    SequenceNode,
    TextType,
    TooManyProblems,
    describe_node,
    is_empty_node,
    is_null,
    is_text,
    shorten,
)
from .shape_reader import MAX_PARTS, PARTS_PHRASE, PartBudget, ShapeReader, count_parts, part_limit, read_index
from .template import Template, read_columns, read_shapes
from .writer import ShapeWriter, body_data, dump_json, dump_yaml
from .yaml_parser import YamlError

# From nodes to the parts of a scene.

SceneProgress: TypeAlias = Callable[[int, int], Any]
"""A function that is called as progress(done, count)."""


_PROGRESS_STEP = 500
"""Bodies between two reports of progress."""
_BODY_BATCH = 8192
"""Bodies in which `build_groups` looks for groups at once."""


@dataclass(frozen=True)
class SceneParts:
    """The contents of a scene file."""

    bodies: tuple[Body, ...]
    lights: tuple[Any, ...] = ()
    camera: Any = None
    background: Any = None
    domain: Any = None
    animation: tuple[Any, ...] = ()
    unit: str | None = None


class SceneReader:
    """Reads the sections of one file. It continues after problems; callers then ignore the result."""

    progress: SceneProgress | None = None
    """Called with numbers of bodies."""

    def __init__(self, reader: NodeReader, document: PatternDocument) -> None:
        self.reader = reader
        self.values = document.distinct
        self.items = document.bodies
        self.material_type = MaterialType()
        self.body_names: dict[str, int] = {}  # name -> line
        self.unnamed_bodies: dict[int, Body] = {}  # by id of the node

    def read(self, root: Node) -> SceneParts:
        """Return the parts of the scene at the root; problems are in `reader.problems`."""
        if not isinstance(root, MappingNode):
            self.reader.report_mismatch(root, "scene", f"a mapping with {', '.join(SECTIONS)}")
            return SceneParts(())
        self.reader.entries(root, "scene", SECTIONS, ("bodies",))
        # `background: null` is an answer, no sky; any other empty section is as if it were missing
        sections = {name: node for name, node in root.entries.items() if not is_null(node) or name == "background"}
        self._version(sections.get("conicoid"))
        camera = CameraType().read(sections["camera"], self.reader, "camera") if "camera" in sections else None
        lights = light_type().read(sections["lights"], self.reader, "lights") if "lights" in sections else ()
        background = (
            BackgroundType().read(sections["background"], self.reader, "background")
            if "background" in sections
            else None
        )
        self._read_materials(sections.get("materials"))
        shapes = ShapeReader(self.reader, self._read_section(sections.get("shapes"), "shapes"), PartBudget(self.values))
        shapes.read_named()
        bodies = self._bodies(root.entries.get("bodies"), shapes)
        domain = shapes.read(sections["domain"], "domain", Solid) if "domain" in sections else None
        if isinstance(domain, Solid):
            shapes.charge_body(sections["domain"], "domain", domain)
        animation = self._animation(sections["animation"], bodies, lights) if "animation" in sections else ()
        unit = self._unit(sections["unit"]) if "unit" in sections else None
        return SceneParts(bodies, () if lights is BAD else lights, camera, background, domain, animation, unit)

    def _unit(self, node: Node) -> str | None:
        unit = TextType().read(node, self.reader, "unit")
        if unit is BAD or unit in LENGTH_UNITS:
            return None if unit is BAD else str(unit)
        self.reader.report_mismatch(node, "unit", f"one of {', '.join(LENGTH_UNITS)}")
        return None

    def _animation(self, node: Node, bodies: tuple[Body, ...], lights: Any) -> Any:
        """Return the tracks of existing bodies and lights; report the others."""
        tracks = animation_type().read(node, self.reader, "animation")
        for i, track in enumerate(() if tracks is BAD else tracks):
            # Here, where there is a line number; the scene would refuse the track without one
            if isinstance(track, BodyTrack) and all(body.name != track.body for body in bodies):
                names = sorted(body.name for body in bodies if body.name)
                message = f"unknown body {shorten(track.body)!r}; {describe_names(track.body, 'named bodies', names)}"
                self.reader.report(node, f"animation[{i}]", message)
            if isinstance(track, LightTrack) and lights is not BAD and track.light >= len(lights):
                message = f"unknown light {track.light}; there are {len(lights)}, from 0 on"
                self.reader.report(node, f"animation[{i}]", message)
        return () if tracks is BAD else tracks

    def _version(self, node: Node | None) -> None:
        if node is not None and IntegerType().read(node, self.reader, "conicoid") not in (SCENE_VERSION, BAD):
            self.reader.report_mismatch(
                node, "conicoid", f"{SCENE_VERSION}, the version of the format that this program reads"
            )

    def _read_section(self, node: Node | None, where: str) -> dict[str, Node]:
        """Return the entries of a section of named values; report names that are no texts."""
        if node is None:
            return {}
        if not isinstance(node, MappingNode):
            self.reader.report_mismatch(node, where, "a mapping from names to " + where)
            return {}
        for name, key in node.keys.items():
            if not name or not is_text(key):
                self.reader.report(key, where, f"a name must be a text, got {shorten(name) or 'nothing'} (quote it)")
        return node.entries

    def _read_materials(self, node: Node | None) -> None:
        kind = material_type()
        for name, item in self._read_section(node, "materials").items():
            material = kind.read(item, self.reader, f'material "{shorten(name)}"')
            # The key is the name of the material, so that `spans.lengths("material")` and pictures show it
            nameless = name and isinstance(material, Material) and not _has_name_argument(item)
            self.reader.materials[name] = rename_material(material, name) if nameless else material

    def _bodies(self, node: Node | None, shapes: ShapeReader) -> tuple[Body, ...]:
        """Return the bodies; problems are reported."""
        if node is None:
            return ()
        if not isinstance(node, SequenceNode):
            none = "; of no bodies at all: `bodies: []`" if is_null(node) else ""
            message = f"must be a list of bodies, each with a shape, got {describe_node(node)}{none}"
            self.reader.report(node, "bodies", message)
            return ()
        bodies: list[Body] = []
        items: Sequence[DocumentItem] = node.items if self.items is None else self.items
        ready: dict[int, GroupBody] = {}
        for i, item in enumerate(items):
            if self.progress is not None and i % _PROGRESS_STEP == 0:
                self.progress(i, len(items))
            if i % _BODY_BATCH == 0:
                ready = build_groups(items[i : i + _BODY_BATCH], shapes)
            fast = ready.get(i % _BODY_BATCH)
            if fast is not None and self._accepts(*fast[:3], item.line + fast[3], shapes):
                bodies.append(fast[0])
            elif type(item) is PatternItem:
                with shapes.pause_cache():
                    bodies += self._item(item.parsed(), f"bodies[{i}]", shapes)
            else:
                assert not isinstance(item, PatternItem)
                body = self.unnamed_bodies.get(id(item))
                if body is not None:
                    shapes.charge_body(item, f"bodies[{i}]", body.shape)
                found = [body] if body is not None else self._item(item, f"bodies[{i}]", shapes)
                if len(found) == 1 and found[0].name is None:
                    self.unnamed_bodies[id(item)] = found[0]  # an alias stands for the same body
                bodies += found
        return tuple(bodies)

    def _accepts(self, body: Body, parts: int, steps: int, name_line: int, shapes: ShapeReader) -> bool:
        """Count the parts, steps and name of a body; return False, and count nothing, if it has a problem."""
        if body.name in self.body_names:
            return False
        if not shapes.allowance.take(parts, steps):
            # The slow reader counts it again, and reports
            shapes.allowance.take(-parts, -steps)
            return False
        if body.name is not None:
            self.body_names[body.name] = name_line
        return True

    def _item(self, node: Node, where: str, shapes: ShapeReader) -> list[Body]:
        """Return the body of an item, or of each row of its columns; none after reports."""
        if isinstance(node, MappingNode) and "columns" in node.entries:
            return self._row_bodies(node, where, shapes)
        body = self._body(node, where, shapes)
        if isinstance(body, BadValue):
            return []
        shapes.charge_body(node, where, body.shape)
        return [body]

    def _body(self, node: Node, where: str, shapes: ShapeReader) -> Body | BadValue:
        """Return a body, or BAD after a report of each problem in it."""
        name = node.entries.get("name") if isinstance(node, MappingNode) else None
        if isinstance(name, ScalarNode) and is_text(name):
            where = f'body "{shorten(name.text)}"'
        self.reader.entries(node, where, BODY_KEYS, ("shape",))
        if not isinstance(node, MappingNode) or "shape" not in node.entries:
            return BAD
        entries = node.entries
        named = None if name is None or _is_null(name) else self._name(name, where)
        shape = shapes.moved(shapes.read(entries["shape"], where), entries.get("move"), where)
        material = self._material(entries["material"], f"{where}: material") if "material" in entries else None
        several = self._several(entries, where)
        if any(isinstance(part, BadValue) for part in (shape, material, named, *several)):
            return BAD
        materials, index = several
        return self.reader.build(
            node, where, lambda: Body(shape, material, named, materials=materials, material_index=index)
        )

    def _row_bodies(self, node: MappingNode, where: str, shapes: ShapeReader) -> list[Body]:
        """Return a body for each row of `columns`; none after a report of each problem."""
        entries = self.reader.entries(node, where, BODY_KEYS[1:], ("shape",))
        if "shape" not in node.entries:
            return []
        template = self.reader.build(node, where, lambda: Template(node))
        if isinstance(template, BadValue):
            return []
        material = (
            self._material(node.entries["material"], f"{where}: material") if "material" in node.entries else None
        )
        materials, index = self._several(node.entries, where)
        columns = read_columns(node.entries["columns"], template, self.reader, f"{where}: columns")
        if isinstance(columns, BadValue) or BAD in (entries, material, materials) or index is BAD:
            return []
        found = read_shapes(template, columns, shapes, where)
        if isinstance(found, BadValue):
            return []
        if materials is None and index is None:
            each: Iterable[Any] = repeat(material)
        else:
            checked = self.reader.build(node, where, lambda: check_materials(len(found), material, materials, index))
            if isinstance(checked, BadValue):
                return []
            each = map(checked[0].__getitem__, checked[1].tolist())
        return construct_many(
            Body, len(found), shape=found, material=each, name=repeat(None), materials=repeat(None),
            material_index=repeat(None),
        )  # fmt: skip

    def _several(self, entries: Mapping[str, Node], where: str) -> tuple[Any, Any]:
        """Return `materials` and `material_index` of many bodies in one entry; None if missing, BAD if bad."""
        materials, index = entries.get("materials"), entries.get("material_index")
        read: Any = None
        if isinstance(materials, SequenceNode):
            read = [self._material(item, f"{where}: materials[{i}]") for i, item in enumerate(materials.items)]
            read = BAD if any(isinstance(item, BadValue) for item in read) else read
        elif materials is not None:
            read = self.reader.report_mismatch(materials, f"{where}: materials", "a list of materials")
        return read, None if index is None else read_index(index, self.reader, f"{where}: material_index")

    def _name(self, node: Node, where: str) -> Any:
        """Return the name of a body, or BAD after a report, also of a name that another body has."""
        name = TextType().read(node, self.reader, f"{where}: name")
        if name is not BAD:
            if name in self.body_names:
                line = self.body_names[name]
                return self.reader.report(node, where, f"name {shorten(name)!r} is taken by the body in line {line}")
            self.body_names[name] = node.line
        return name

    def _material(self, node: Node, where: str) -> Any:
        return None if _is_null(node) else self.material_type.read(node, self.reader, where)


def _has_name_argument(material: Node) -> bool:
    """Return True if a material under a key has an argument `name`, even null; otherwise the key is its name."""
    arguments = next(iter(material.entries.values()), None) if isinstance(material, MappingNode) else None
    return isinstance(arguments, MappingNode) and "name" in arguments.entries


def _is_null(node: Node) -> bool:
    """Return True if null is written; an empty place does not count."""
    return is_null(node) and not is_empty_node(node)


# From files to parts of a scene, and back.


class WritableScene(Protocol):
    """A scene or its parts, for writing."""

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
    @property
    def unit(self) -> str | None: ...


_XML = re.compile(r"\s*<(?:\?xml|!--|geometry|model|materials)")


def read_scene(
    path: str | os.PathLike[str], progress: SceneProgress | None = None, outside: bool = False
) -> SceneParts:
    """Read the parts of the scene in a file.

    Parameters
    ----------
    path
        The file.
    progress
        Function that is called as progress(done, count) now and then; the first half is the parsing of the text.
    outside
        True if images of textures may lie outside of the file's folder.

    Raises
    ------
    SceneFileError
        With every problem that was found.
    """
    # Before the text is read, which is UTF-16 in many catalogues
    if os.fspath(path).lower().endswith(".agf") and os.path.isfile(path):
        message = "is a catalogue of glasses, no scene: co.optics.load_agf reads it, and glasses= of co.load takes it"
        raise SceneFileError(path, [Problem(0, 0, "", message)])
    text = scene_text.read_scene_text(path)
    # A frequent mistake: OpenMC's geometry in place of a scene
    if _XML.match(text):
        message = (
            "is XML; scene files are YAML or JSON, and `conicoid import`, or co.load_openmc, reads OpenMC's geometries"
        )
        raise SceneFileError(path, [Problem(0, 0, "", message)])
    return parse_scene(text, path, progress, outside)


def parse_scene(
    text: str, path: str | os.PathLike[str], progress: SceneProgress | None = None, outside: bool = False
) -> SceneParts:
    """Return the parts of the scene in a text; `path` names it in messages, and its folder holds other files.

    Raise SceneFileError with every problem that was found.
    """
    with pause_gc():  # millions of nodes and bodies, none of them garbage
        return _parse_parts(text, path, progress, outside)


def _parse_parts(text: str, path: str | os.PathLike[str], progress: SceneProgress | None, outside: bool) -> SceneParts:
    size = len(text)
    try:
        document = parse_patterned_document(text, progress and (lambda done: progress(done, 2 * size)))
    except YamlError as error:
        raise SceneFileError(path, [error.problem]) from None
    root = document.root
    if root is None or is_null(root):
        empty = Problem(0, 0, "", "is empty, a scene file has at least `bodies`")
        raise SceneFileError(path, [*document.problems, empty])
    reader = NodeReader(Path(path).resolve().parent)
    reader.takes_any_file = outside
    reader.problems.extend(document.problems)
    parts = SceneParts(())
    with contextlib.suppress(TooManyProblems):
        scene = SceneReader(reader, document)
        scene.progress = progress and (lambda done, count: progress(size + size * done // count, 2 * size))
        parts = scene.read(root)
    if reader.problems:
        raise SceneFileError(path, reader.problems)
    return parts


_WRITE_PROGRESS_STEP = 256  # bodies between two reports of progress
SCENE_SUFFIXES = (".yaml", ".yml", ".json")
"""Suffixes of the files that scenes are saved to."""


def write_scene(
    scene: WritableScene, path: str | os.PathLike[str], material_names: Mapping[Material, str] | None = None,
    progress: SceneProgress | None = None,
) -> None:  # fmt: skip
    """Write a scene so that reading gives an equal one: floats to the last bit, motions step by step.

    More than 100 balls of a `Spheres` go to a .npy file beside the scene, named after the scene and after its content.
    No file of balls is ever overwritten or removed, so that anything that refers to one keeps its balls. They are
    written first and the scene last. Files appear whole or not at all.

    Parameters
    ----------
    scene
        The scene or its parts.
    path
        The file, with suffix .yaml, .yml or .json.
    material_names
        Names of materials in the file; others get their own name, or letters.
    progress
        Function that is called as progress(done, count) with numbers of bodies.

    Raises
    ------
    OSError
        If a file cannot be written.
    ValueError
        For a scene that a file cannot hold, and for another suffix: a geometry.xml that a scene was imported from must
        not become a scene file.
    """
    if not os.fspath(path).lower().endswith(SCENE_SUFFIXES):
        raise ValueError(f"{os.fspath(path)}: scenes are saved as .yaml or .json")
    final = resolve_links(path)
    with pause_gc():
        _write(scene, path, final, material_names, progress)


def _write(
    scene: WritableScene, path: str | os.PathLike[str], final: Path, material_names: Mapping[Material, str] | None,
    progress: SceneProgress | None,
) -> None:  # fmt: skip
    """Check the size of a scene before and after it becomes data, then write it."""
    about = _count_repeated_parts(scene.bodies)
    if about > MAX_PARTS:
        raise ValueError(f"{final}: a scene file may have {MAX_PARTS:,} {PARTS_PHRASE} this scene has about {about:,}")
    stem = re.sub(r"[^\w.-]", "_", final.stem)[:40]
    bulk: dict[str, FloatArray] = {}

    def keep(of: str, table: FloatArray) -> str:
        name = array_file_name(final.parent, f"{stem}-{of}", table)
        bulk[name] = table
        return name

    data = scene_data(scene, keep, material_names=material_names, folder=final.parent, progress=progress)
    count = _count_values(data)
    parts, most = count_parts(_scene_shapes(scene)), part_limit(count)
    if parts > most:
        reason = f"a scene file of this size may have {most:,} {PARTS_PHRASE} this scene has {parts:,}"
        raise ValueError(f"{final}: {reason}")
    if count > yaml_parser.MAX_NODES:
        reason = f"a scene file holds at most {yaml_parser.MAX_NODES:,} values, this scene takes {count:,}"
        raise ValueError(f"{final}: {reason}: write bodies apart, or balls as one Spheres")
    text = dump_json(data) if Path(path).suffix.lower() == ".json" else dump_yaml(data)
    size = len(text.encode())
    if size > scene_text.MAX_SCENE_BYTES:
        reason = f"a scene file has at most {scene_text.MAX_SCENE_BYTES >> 20} MB, this scene takes {size >> 20} MB"
        raise ValueError(f"{final}: {reason}: write bodies apart, or balls as one Spheres")
    # Tables first: a scene whose balls are missing cannot be read, balls without a scene do no harm
    for name, table in bulk.items():
        save_array_once(final.with_name(name), table)
    write_text(path, text)


def _count_repeated_parts(bodies: Sequence[Body]) -> int:
    """Return about how many parts the bodies of an `InstanceList` have, by the first body of each group; else 0.

    This is cheap, as it makes no bodies but the first of each group.
    """
    if not isinstance(bodies, InstanceList):
        return 0
    firsts = (bodies.shape(int(numbers[0])) for numbers in bodies.members if len(numbers))
    counts = (len(numbers) for numbers in bodies.members if len(numbers))
    return sum(count * count_parts([shape]) for shape, count in zip(firsts, counts, strict=True))


def _count_values(data: Any) -> int:
    """Return the number of values of a scene file, as the parser counts them."""
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
    scene: WritableScene, keep: Any, material_names: Mapping[Material, str] | None = None,
    folder: Path | None = None, progress: SceneProgress | None = None,
) -> dict[str, Any]:  # fmt: skip
    """Return the sections of a scene file without empty ones.

    `keep` writes a table and returns the name of its file.
    `folder` is that of the file; without it images are replaced by their mean colours, and environments by their
    pixels.
    """
    writer = ShapeWriter(_scene_shapes(scene), keep, material_names, folder)
    domain = {} if scene.domain is None else {"domain": writer.data(scene.domain)}
    bodies = []
    for number, body in enumerate(scene.bodies):
        if progress is not None and number % _WRITE_PROGRESS_STEP == 0:
            progress(number, len(scene.bodies))
        bodies.append(body_data(body, writer))
    sections: dict[str, Any] = {"conicoid": SCENE_VERSION}
    sections |= {"unit": scene.unit} if scene.unit else {}
    if scene.camera is not None:
        tagged = writer.value(scene.camera)
        sections["camera"] = tagged.get("Camera", tagged)
    if scene.background is not None:
        sections["background"] = writer.value(scene.background)
    sections |= {"lights": [writer.value(light) for light in scene.lights]} if scene.lights else {}
    tracks = getattr(scene, "animation", ())  # imported models have none
    animation = {"animation": [writer.value(track) for track in tracks]} if tracks else {}
    sections |= {"materials": writer.materials} if writer.materials else {}
    sections |= {"shapes": writer.named_nodes} if writer.named_nodes else {}
    return sections | domain | {"bodies": bodies} | animation


def _scene_shapes(scene: WritableScene) -> list[Shape]:
    """Return the shapes of the bodies, and the domain."""
    return [body.shape for body in scene.bodies] + ([] if scene.domain is None else [scene.domain])
