"""Shapes in a scene file: ``{ClassName: {fields}, move: [...]}``, Booleans of them, and references.

{Sphere: {radius: 2}, move: [{translate: [0, 0, 1]}]}
{Difference: [{Box: {}}, {Sphere: {radius: 1.2}}]}
wheel                                   # a name under `shapes`
{shape: wheel, move: [{scale: 2}]}
"""

from __future__ import annotations

import functools
import operator
from typing import Any

from ..shapes import REGISTRY, Shape, Sheet
from ..shapes.about import about
from ..shapes.bulk import Bulk
from ..shapes.elsewhere import CLASSES
from ..shapes.motion import AXES, STILL, Motion
from ..shapes.region import Difference, Intersection
from .bulk_nodes import read_many
from .expansion import MAX_PARTS, PARTS, Allowance, Sizes
from .fields import Arguments, ShapeKind, fields_of
from .kinds import Choice, Fixed, Kind, Number, OneOf, Several
from .nodes import Listing, Node, Scalar, Standing, Table, is_text
from .reading import BAD, Bad, Reader, TooManyProblems

MAX_LEVELS = 100
MAX_STEPS = 1000

VECTOR = Fixed(Number(), 3)


class AxisKind(OneOf):
    """A direction, or the name of an axis."""

    def __init__(self) -> None:
        super().__init__((VECTOR, Choice(tuple(AXES))))
        self.phrase = "3 numbers, or one of x, y, z, -x, -y, -z"

    def read(self, node: Node, reader: Reader, where: str) -> Any:
        if isinstance(node, Scalar) and is_text(node) and node.text not in AXES:
            return reader.expected(node, where, self.phrase)
        return super().read(node, reader, where)


AXIS = AxisKind()
MOVES: dict[str, Kind] = {
    "translate": VECTOR,
    "scale": OneOf((Number(), VECTOR)),
    "transform": Fixed(Fixed(Number(), 4), 4),
}


ROTATION: dict[str, Kind] = {"axis": AXIS, "degrees": Number(), "about": VECTOR}


class ShapeReader:
    """Reads shapes of one scene; knows the named ones and how large each is, fully written out."""

    def __init__(self, reader: Reader, named: dict[str, Node], allowance: Allowance) -> None:
        self.reader = reader
        self.named = named
        self.built: dict[str, Shape | Bad] = {}
        self.open: list[str] = []
        self.level = 0
        self.allowance = allowance
        self.size = Sizes()
        self.read_nodes: dict[int, Any] = {}  # by id: what was read, for the aliases of the node
        self.motions: dict[int, Motion | Bad] = {}
        reader.shape = self.read

    def read_named(self) -> None:
        """Read all named shapes, used or not."""
        for name in self.named:
            self._resolve(name)

    def read(self, node: Node, where: str, base: type = Shape) -> Any:
        """The shape at a node, or BAD after a report; it must be of class `base`."""
        if self.level >= MAX_LEVELS:
            return self.reader.report(
                node, where, f"nested deeper than {MAX_LEVELS} levels (put parts under `shapes`, each before its use)"
            )
        self.level += 1
        try:
            if is_text(node):
                shape = self._reference(node, where)
            elif (shape := self.read_nodes.get(id(node))) is None:
                shape = self.read_nodes[id(node)] = self._written(node, where)
        finally:
            self.level -= 1
        if shape is BAD or isinstance(shape, base):
            return shape
        found = f"{type(shape).__name__}, a {'sheet' if shape.is_sheet else 'solid'}"
        return self.reader.report(node, where, f"must be {ShapeKind(base).phrase}, got {found}")

    def check_size(self, node: Node, where: str, shape: Shape) -> Shape | Bad:
        """Refuse what references would blow up to more primitives than any scene needs."""
        if self.size(shape) > MAX_PARTS:
            return self.reader.report(node, where, f"has more than {MAX_PARTS:,} parts, references written out")
        return shape

    def charge_body(self, node: Standing, where: str, shape: Shape) -> None:
        """Count the parts of a body, and stop reading where the file has more than its length accounts for."""
        self._charge(node, where, self.allowance.take(parts=1 + self.size(shape)))

    def _charge(self, node: Standing, where: str, borne: bool) -> None:
        if not borne:
            grown = (
                f"here the file has grown to more than {self.allowance.most:,} {PARTS} which is too much for its length"
            )
            self.reader.report(node, where, grown)
            raise TooManyProblems

    def _reference(self, node: Node, where: str) -> Any:
        name = node.text if isinstance(node, Scalar) else ""
        if name in self.named:
            if name in self.open:
                circle = " → ".join([*self.open[self.open.index(name) :], name])
                return self.reader.report(node, where, f"shapes refer to each other in a circle: {circle}")
            return self._resolve(name)
        if name in REGISTRY:
            return self.reader.report(
                node, where, f"must be a mapping, {{{name}: {{...}}}}, got the bare word {name!r}"
            )
        return self.reader.unknown(node, where, "shape", name, self.named)

    def _resolve(self, name: str) -> Shape | Bad:
        if name not in self.built:
            self.open.append(name)
            node, where = self.named[name], f'shape "{name}"'
            shape = self.read(node, where)
            self.built[name] = shape if isinstance(shape, Bad) else self.check_size(node, where, shape)
            self.open.pop()
        return self.built[name]

    def _written(self, node: Node, where: str) -> Any:
        if not isinstance(node, Table):
            example = "a shape, a mapping such as {Sphere: {radius: 1}}, or the name of one under `shapes`"
            return self.reader.expected(node, where, example)
        heads = [key for key in node.heads if key.text != "move"]
        if len(heads) != 1:
            found = f"{len(heads)}: {', '.join(key.text for key in heads[:4])}" if heads else "none"
            beside = [key.text for key in heads if key.text in ("name", "material", "materials", "material_index")]
            hint = f"; {' and '.join(beside)} of a body stand beside `shape:`, not in it" if beside else ""
            return self.reader.report(
                node, where, f"must have one shape as its key (and `move` beside it), got {found}{hint}"
            )
        shape = self._head(heads[0], node.entries[heads[0].text], where)
        return self.moved(shape, node.entries.get("move"), where)

    def _head(self, key: Scalar, value: Node, where: str) -> Any:
        if key.text == "shape":
            return self.read(value, where)
        if key.text not in REGISTRY:
            return self._unknown(key, where)
        cls = REGISTRY[key.text]
        if issubclass(cls, Bulk):
            return read_many(cls, value, self.reader, f"{where}: {cls.__name__}")
        if (field := operand_field(cls)) is None:
            return Arguments(cls).read(value, self.reader, where)
        where = f"{where}: {cls.__name__}"
        operands = self._operands(value, where, isinstance(field, Several))
        return operands if operands is BAD else self.reader.made(value, where, lambda: combined(cls, operands))

    def _unknown(self, key: Scalar, where: str) -> Bad:
        """Report a name that no shape has: a motion, one that has another name here, or a typo."""
        if key.text.lower() in ("translate", "rotate", "scale", "transform"):
            found = f"unknown shape {key.text!r}: motions stand beside a shape, move: [{{{key.text.lower()}: ...}}]"
            return self.reader.report(key, where, found)
        if (meant := CLASSES.get(key.text, "")) in REGISTRY:
            return self.reader.report(key, where, f"unknown shape {key.text!r} (did you mean {meant!r}?)")
        if key.text in ("Torus", "Obj", "Stl", "STL", "OBJ"):
            told = f"unknown shape {key.text!r}: bodies are of planes and quadrics; "
            told += "a mesh is {Mesh: ...} or {Triangles: ...}"
            return self.reader.report(key, where, told)
        return self.reader.unknown(key, where, "shape", key.text, [*REGISTRY, "shape"])

    def _operands(self, value: Node, where: str, several: bool) -> Any:
        if not several:
            return self.read(value, where)
        if not isinstance(value, Listing) or not value.items:
            return self.reader.expected(value, where, "a list of at least one solid")
        shapes = []
        for i, item in enumerate(value.items):
            shapes.append(self.read(item, f"{where}[{i}]"))
        return BAD if BAD in shapes else tuple(shapes)

    def moved(self, shape: Any, moves: Node | None, where: str) -> Any:
        """The shape after the steps of a `move` list; mistakes are reported for a BAD shape too."""
        if moves is None:
            return shape
        where = f"{where}: move"
        if not isinstance(moves, Listing):
            return self.reader.expected(moves, where, "a list of steps such as [{translate: [0, 0, 1]}]")
        if len(moves.items) > MAX_STEPS:
            return self.reader.report(moves, where, f"must have at most {MAX_STEPS} steps, got {len(moves.items)}")
        if (motion := self.motions.get(id(moves))) is None:
            motion = self.motions[id(moves)] = self._motion(moves, where)
        if shape is BAD or isinstance(motion, Bad):
            return BAD
        self._charge(moves, where, self.allowance.take(steps=len(shape.motion.steps) + len(motion.steps)))
        return self.reader.made(moves, where, lambda: moved_by(shape, motion))

    def _motion(self, moves: Listing, where: str) -> Motion | Bad:
        """All steps of a list, which an alias may stand for again."""
        motion, good = STILL, True
        for i, step in enumerate(moves.items):
            moved = self._step(motion, step, f"{where}[{i}]")
            motion, good = (motion, False) if isinstance(moved, Bad) else (moved, good)
        return motion if good else BAD

    def _step(self, motion: Motion, step: Node, where: str) -> Any:
        """The motion followed by one more step."""
        entry = self.reader.only_entry(step)
        verbs = ("translate", "rotate", "scale", "transform")
        if entry is None:
            return self.reader.expected(step, where, f"one of {', '.join(verbs)}, such as {{translate: [0, 0, 1]}}")
        verb, key, value = entry
        if verb not in verbs:
            return self.reader.unknown(key, where, "step", verb, verbs)
        where = f"{where}: {verb}"
        if verb == "rotate":
            return self._rotated(motion, value, where)
        argument = MOVES[verb].read(value, self.reader, where)
        return BAD if argument is BAD else self.reader.made(value, where, lambda: getattr(motion, verb)(argument))

    def _rotated(self, motion: Motion, value: Node, where: str) -> Any:
        entries = self.reader.entries(value, where, ROTATION, ("axis", "degrees"))
        given = value.entries if isinstance(value, Table) else {}
        found = {
            name: kind.read(given[name], self.reader, f"{where}: {name}")
            for name, kind in ROTATION.items()
            if name in given
        }
        if isinstance(entries, Bad) or BAD in found.values():
            return BAD
        point, axis, degrees = found.get("about"), found["axis"], found["degrees"]
        return self.reader.made(
            value, where, lambda: about("rotate", motion, point, lambda still: still.rotate(axis, degrees))
        )


def combined(cls: Any, operands: Any) -> Any:
    """A Boolean of shapes; with a sheet, what `sheet - solid` and `sheet & solid` are."""
    sheets = [part for part in operands if isinstance(part, Sheet)] if isinstance(operands, tuple) else []
    if len(sheets) == 1 and cls is Difference and operands[0] is sheets[0]:
        return functools.reduce(operator.sub, operands)
    if len(sheets) == 1 and cls is Intersection:
        return functools.reduce(operator.and_, (part for part in operands if part is not sheets[0]), sheets[0])
    return cls(operands)


def moved_by(shape: Shape, motion: Motion) -> Shape:
    """The shape after all steps of a motion, checked once."""
    return shape._moved(shape.motion.then(motion))


def operand_field(cls: type[Shape]) -> Kind | None:
    """The kind of a class's only field if that holds shapes: Booleans take them without naming the field."""
    kinds = [field.kind for field in fields_of(cls).values()]
    inner = kinds[0].item if len(kinds) == 1 and isinstance(kinds[0], Several) else kinds[0] if kinds else None
    return kinds[0] if len(kinds) == 1 and isinstance(inner, ShapeKind) else None
