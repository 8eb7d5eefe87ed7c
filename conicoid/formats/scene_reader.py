"""The sections of a scene file, from nodes to the parts of a scene."""

from __future__ import annotations

from collections.abc import Callable, Mapping, Sequence
from dataclasses import dataclass
from typing import Any, TypeAlias

from ..shapes import REGISTRY
from ..shapes.animation import BodyTrack, LightTrack
from ..shapes.base import Solid
from ..shapes.body import Body
from ..shapes.material import Material, renamed
from ..shapes.suggestion import known_names
from .alike import Alike, Bodies, Item
from .alike_bodies import Made, made_together
from .bulk_nodes import read_index
from .expansion import Allowance
from .fields import MaterialKind
from .kinds import Integer, Text
from .nodes import Listing, Node, Scalar, Table, is_nothing, is_null, is_text, shortened, shown
from .plain_bodies import PlainBodies
from .reading import BAD, Bad, Reader
from .sections import BODY, SECTIONS, VERSION, BackgroundKind, CameraKind, animation_kind, light_kind, material_kind
from .shape_nodes import ShapeReader

Progress: TypeAlias = Callable[[int, int], Any]
"""Is called with how much is done, and of how much."""


_STEP = 500
"""Bodies from one report of progress to the next."""
_AT_ONCE = 8192
"""Bodies that are looked at together."""


@dataclass(frozen=True)
class Parts:
    """What a scene file holds."""

    bodies: tuple[Body, ...]
    lights: tuple[Any, ...] = ()
    camera: Any = None
    background: Any = None
    domain: Any = None
    animation: tuple[Any, ...] = ()


class SceneReader:
    """Reads the sections of one file; on mistakes it goes on, and what it returns is not used."""

    progress: Progress | None = None
    """Of the bodies."""

    def __init__(self, reader: Reader, found: Bodies) -> None:
        self.reader = reader
        self.values = found.distinct
        self.items = found.bodies
        self.body_names: dict[str, int] = {}
        self.unnamed: dict[int, Body] = {}
        self.written: list[Node] = []

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
        items: Sequence[Item] = node.items if self.items is None else self.items
        ready: dict[int, Made] = {}
        for i, item in enumerate(items):
            if self.progress is not None and i % _STEP == 0:
                self.progress(i, len(items))
            if i % _AT_ONCE == 0:
                ready = made_together(i, items[i : i + _AT_ONCE], plain)
            made = ready.get(i)
            if made is not None and plain.accepts(made.body.name, made.name_line, made.steps, made.parts):
                bodies.append(made.body)
                continue
            body = self._alike(item, i, plain, shapes) if type(item) is Alike else self._item(item, i, plain, shapes)
            if isinstance(body, Body):
                shapes.charge_body(item, f"bodies[{i}]", body.shape)
                bodies.append(body)
        return tuple(bodies)

    def _alike(self, item: Alike, i: int, plain: PlainBodies, shapes: ShapeReader) -> Body | Bad:
        """A body that is written as others are; one that is not plainly well is read as if it were alone."""
        body = plain.read_alike(item)
        if body is not None:
            return body
        written = item.written()
        self.written.append(written)  # what is known of nodes is known by their ids
        return self._item(written, i, plain, shapes)

    def _item(self, node: Any, i: int, plain: PlainBodies, shapes: ShapeReader) -> Body | Bad:
        body = self.unnamed.get(id(node)) or plain.read(node) or self._body(node, f"bodies[{i}]", shapes)
        if isinstance(body, Body) and body.name is None:
            self.unnamed[id(node)] = body  # an alias stands for the same body
        return body

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


class _Elsewhere(dict[str, str]):
    """What is no entry of a body, and where it stands. Shapes are asked for only where there is a mistake."""

    def get(self, name: str, default: Any = None) -> Any:
        if name not in self and name in REGISTRY:
            return "known: material, move, name, shape; write {shape: {Name: {...}}}"
        return super().get(name, default)


_IN_BODIES = _Elsewhere(
    {
        **dict.fromkeys(("color", "colour"), "its material may be a colour"),
        **dict.fromkeys(
            ("type", "kind", "radius", "center"),
            "known: material, move, name, shape; write {shape: {Sphere: {radius: 2}}}",
        ),
        **dict.fromkeys(
            ("translate", "rotate", "scale", "transform", "position", "rotation", "translation"),
            "motions are a list: {move: [{translate: [0, 0, 1]}]}",
        ),
    }
)
