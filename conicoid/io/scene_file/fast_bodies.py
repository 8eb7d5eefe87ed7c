"""Fast readers of plain bodies, which nearly all bodies of files are; unusual ones are left to `SceneReader`.

`PlainBodyReader` reads one body from its nodes. `build_alike_bodies` builds bodies that match one pattern together, in
columns. Neither reports problems, and both count a body (names, parts, steps) only after all of it is read. A
`QuickReader` reads a node of one type; it raises `UnusualNode` unless the node is plainly of that type.
"""

from __future__ import annotations

import functools
import re
from collections.abc import Callable, Iterable, Iterator, Sequence
from dataclasses import dataclass, field
from functools import cache
from itertools import repeat
from operator import itemgetter
from typing import Any, NamedTuple, TypeAlias

from ..._util.pickling import construct_many, pickle_state
from ..._util.user_warnings import SuppressedWarning, raise_warnings
from ...geometry.body import Body
from ...geometry.bulk import Bulk
from ...geometry.registry import REGISTRY
from ...geometry.shape import Shape
from ...geometry.transform import AXES, IDENTITY_MOTION, IDENTITY_REACH, Motion
from ...geometry.transform_columns import (
    StepColumn,
    compose_motions,
    repeat_step,
    rotate_column,
    scale_column,
    transform_column,
    translate_column,
)
from ...materials.material import Material
from ...materials.presets import as_material
from .fast_text import DocumentItem, PatternItem, TextPattern
from .fields import argument_fields
from .nodes import DECIMAL, MappingNode, Node, ScalarNode, SequenceNode, is_text
from .shape_reader import MAX_STEPS, ShapeReader, apply_motion, operand_field
from .value_types import BadValue, FixedListType, ListType, NumberType, OptionalType, ValueType

# Single bodies.

QuickReader: TypeAlias = Callable[[Node], Any]

_NUMBER = re.compile(DECIMAL)
MAX_PLAIN_DEPTH = 20
"""Most levels of shapes within shapes of a plain body."""


class UnusualNode(Exception):
    """Raised for a node that the fast readers leave to `SceneReader`."""


@dataclass
class PlainBodyReader:
    """Reads plain bodies of one file. It shares named shapes, nodes and the budget with the reader of its shapes."""

    shapes: ShapeReader
    materials: dict[str, Any]
    names: dict[str, int]
    """The names of the bodies so far, with their lines."""
    steps: int = 0
    """The number of steps in the motions of the current body."""
    colors: dict[str, Material] = field(default_factory=dict)
    lasting: bool = True
    """True if the current nodes do not change, so that results may be stored by their ids."""

    def read_alike(self, item: PatternItem) -> Body | None:
        """Return the body of an item that matches a pattern, or None; nothing is stored by the ids of its nodes.

        No alias refers to them.
        """
        self.lasting = False
        try:
            return self.read(item.read())
        finally:
            self.lasting = True

    def read(self, node: Node) -> Body | None:
        """Return the body at a node; None for one that is unusual or has a problem."""
        self.steps = 0
        try:
            return self._body(node)
        except (UnusualNode, ValueError, TypeError, ArithmeticError):
            return None

    def _body(self, node: Node) -> Body:
        if type(node) is not MappingNode:
            raise UnusualNode
        name: str | None = None
        shape: Shape | None = None
        material: Material | None = None
        for key, value in node.entries.items():
            if key == "shape":
                shape = self.shape(value, 0)
            elif key == "name":
                name = plain_text(value)
            elif key == "material":
                material = self.material(value)
            elif key != "move":
                raise UnusualNode
        if shape is None or name in self.names:
            raise UnusualNode
        if "move" in node.entries:
            shape = self._moved(shape, node.entries["move"])
        body = Body(shape, material, name)
        if not self.accepts(name, 0 if name is None else node.entries["name"].line, self.steps):
            raise UnusualNode
        return body

    def accepts(self, name: str | None, line: int, steps: int, parts: int = 0) -> bool:
        """Count the parts, steps and name of a body; return False, and count nothing, if it cannot be accepted."""
        if name in self.names:
            return False
        if not self.shapes.allowance.take(parts, steps):
            self.shapes.allowance.take(-parts, -steps)
            return False
        if name is not None:
            self.names[name] = line
        return True

    def material(self, node: Node) -> Material:
        """Return a material by its name, or a matte one by its colour."""
        name = plain_text(node)
        known = self.materials.get(name) or self.colors.get(name)
        if isinstance(known, Material):
            return known
        if name in self.materials:
            raise UnusualNode
        material = self.colors[name] = as_material("matte", name)
        return material

    def shape(self, node: Node, depth: int) -> Shape:
        """Return the shape at a node, `depth` levels within that of the body."""
        known = self.shapes.read_nodes.get(id(node)) if self.lasting else None
        if known is not None:
            if isinstance(known, BadValue):
                raise UnusualNode
            shape: Shape = known
            return shape
        if type(node) is ScalarNode:
            return self._named(node)
        if (
            type(node) is not MappingNode
            or len(node.entries) - ("move" in node.entries) != 1
            or depth > MAX_PLAIN_DEPTH
        ):
            raise UnusualNode
        head = next(name for name in node.entries if name != "move")
        value = node.entries[head]
        if head == "shape":
            shape = self.shape(value, depth + 1)
        else:
            constructor = find_constructor(head)
            if constructor is None:
                raise UnusualNode
            shape = self.build(constructor, value, depth)
        if "move" in node.entries:
            shape = self._moved(shape, node.entries["move"])
        if self.lasting:
            self.shapes.read_nodes[id(node)] = shape
        return shape

    def _named(self, node: Node) -> Shape:
        """Return a named shape that was read without problems."""
        shape = self.shapes.built.get(plain_text(node))
        if shape is None or isinstance(shape, BadValue):
            raise UnusualNode
        return shape

    def build(self, constructor: ShapeConstructor, node: Node, depth: int) -> Shape:
        """Return a primitive by its fields, or a combination of its operands."""
        if constructor.fields:
            return constructor.make(**self.values(constructor, node))
        if not constructor.several:
            return constructor.make(self.shape(node, depth + 1))
        if type(node) is not SequenceNode or not node.items:
            raise UnusualNode
        return constructor.make(tuple([self.shape(item, depth + 1) for item in node.items]))

    def values(self, constructor: ShapeConstructor, node: Node) -> dict[str, Any]:
        """Return the values of a primitive's fields."""
        if type(node) is not MappingNode:
            raise UnusualNode
        fields, values = constructor.fields, {}
        for name, value in node.entries.items():
            if name not in fields:
                raise UnusualNode
            values[name] = fields[name](value)
        for name in constructor.required:
            if name not in values:
                raise UnusualNode
        return values

    def _moved(self, shape: Shape, node: Node) -> Shape:
        """Return a shape after the steps of a `move` list."""
        if type(node) is not SequenceNode or len(node.items) > MAX_STEPS:
            raise UnusualNode
        motion = self.shapes.motions.get(id(node)) if self.lasting else None
        if motion is None:
            motion = IDENTITY_MOTION
            for step in node.items:
                motion = append_step(motion, step)
            if self.lasting:
                self.shapes.motions[id(node)] = motion
        if isinstance(motion, BadValue):
            raise UnusualNode
        self.steps += len(shape.motion.steps) + len(motion.steps)
        return apply_motion(shape, motion)


@dataclass(frozen=True)
class ShapeConstructor:
    """The way to construct a class: from fields by name, or, if it has none, from one operand or several."""

    make: Callable[..., Shape]
    fields: dict[str, QuickReader]
    required: tuple[str, ...]
    several: bool = False


def find_constructor(name: str) -> ShapeConstructor | None:
    """Return the constructor of a class by name; None for other names and for bulk shapes."""
    cls = REGISTRY.get(name)
    return None if cls is None or issubclass(cls, Bulk) else _constructor(cls)


@cache
def _constructor(cls: type[Shape]) -> ShapeConstructor:
    """Return the constructor of a class, cached."""
    operand = operand_field(cls)
    if operand is not None:
        return ShapeConstructor(cls, {}, (), isinstance(operand, ListType))
    fields = argument_fields(cls)
    return ShapeConstructor(
        cls,
        {name: _quick_reader(field.kind) for name, field in fields.items()},
        tuple(name for name, field in fields.items() if field.required),
    )


def _quick_reader(kind: ValueType) -> QuickReader:
    """Return the reader of plain nodes of a type: numbers and lists of them; all other types are unusual."""
    if type(kind) is NumberType:
        return plain_number
    if type(kind) is FixedListType or type(kind) is ListType:
        return _list(_quick_reader(kind.item), kind.count if isinstance(kind, FixedListType) else None)
    return _quick_reader(kind.item) if type(kind) is OptionalType else _unusual


def _unusual(_: Node) -> Any:
    raise UnusualNode


def _list(item: QuickReader, count: int | None) -> QuickReader:
    """Return a reader of lists of `count` items, or of any length for None."""

    def read(node: Node) -> tuple[Any, ...]:
        if type(node) is not SequenceNode or (count is not None and len(node.items) != count):
            raise UnusualNode
        return tuple([item(each) for each in node.items])

    return read


def plain_number(node: Node) -> float:
    """Return a plain decimal number."""
    if type(node) is not ScalarNode or not node.plain or not _NUMBER.fullmatch(node.text):
        raise UnusualNode
    return float(node.text)


plain_vector = _list(plain_number, 3)
plain_matrix = _list(_list(plain_number, 4), 4)


def plain_text(node: Node) -> str:
    """Return a text that is not empty."""
    if type(node) is not ScalarNode or not is_text(node) or not node.text:
        raise UnusualNode
    return node.text


def append_step(motion: Motion, step: Node) -> Motion:
    """Return the motion followed by one more step."""
    if type(step) is not MappingNode or len(step.entries) != 1:
        raise UnusualNode
    ((verb, value),) = step.entries.items()
    if verb == "translate":
        return motion.translate(plain_vector(value))
    if verb == "scale":
        return motion.scale(plain_number(value) if type(value) is ScalarNode else plain_vector(value))
    if verb == "transform":
        return motion.transform(plain_matrix(value))
    if verb != "rotate" or type(value) is not MappingNode or value.entries.keys() != {"axis", "degrees"}:
        raise UnusualNode
    axis = value.entries["axis"]
    direction = axis.text if type(axis) is ScalarNode and axis.text in AXES and is_text(axis) else plain_vector(axis)
    return motion.rotate(direction, plain_number(value.entries["degrees"]))


# Bodies of one pattern, built together: their common parts are read once, their numbers in columns.
#
# The nodes of all bodies of a pattern are equally plain, and checks of numbers run on whole columns. Nothing is
# reported or counted here. A body in doubt is left to `PlainBodyReader`; so are all bodies of a group if one raises a
# warning, or if the pattern is not plain.

_MIN_GROUP = 8
"""Least bodies of a group that is worth building together."""
_DOUBT = (UnusualNode, SuppressedWarning, ValueError, TypeError, ArithmeticError)
_DOUBTFUL: Any = object()  # in place of a name or material that is in doubt


class FastBody(NamedTuple):
    """A body, and the numbers that `PlainBodyReader.accepts` counts."""

    body: Body
    parts: int
    steps: int
    """The number of steps in its motions."""
    name_line: int


@dataclass
class _SharedShape:
    """One shape for all bodies of a group."""

    shape: Shape


_Shapes: TypeAlias = _SharedShape | list[Shape | None]
"""One shape for all bodies, or the shape of each, None for one in doubt."""


def build_alike_bodies(first: int, items: Sequence[DocumentItem], plain: PlainBodyReader) -> dict[int, FastBody]:
    """Return the bodies that could be built in groups, by their numbers; `first` is the number of the first item."""
    groups: dict[Any, list[int]] = {}
    words_of: dict[int, _SlotWords] = {}
    for place, item in enumerate(items):
        if type(item) is PatternItem:
            words = words_of.get(id(item.pattern))
            if words is None:
                words = words_of[id(item.pattern)] = _SlotWords(item.pattern)
            groups.setdefault((words, words.key(item.words)), []).append(place)
    bodies: dict[int, FastBody] = {}
    for (words, _), places in groups.items():
        if len(places) >= _MIN_GROUP:
            group = _BodyGroup(words, [items[place] for place in places], plain)  # type: ignore[misc]
            bodies.update((first + places[k], body) for k, body in group.build())
    return bodies


class _SlotWords:
    """The kinds of slots of a pattern: numbers, the name and material of the body, and others.

    `key` returns the words in the other slots, such as names of axes and shapes; bodies of a group share them.
    """

    def __init__(self, pattern: TextPattern) -> None:
        self.pattern = pattern
        own = [id(pattern.item.entries.get(name)) for name in ("name", "material")]
        self.numbers = [k for k, is_number in enumerate(pattern.is_number) if is_number]
        others = [k for k, place in enumerate(pattern.places) if id(place.node) not in own and not pattern.is_number[k]]
        self.key: Callable[[Sequence[str]], Any] = itemgetter(*others) if others else _no_key


def _no_key(_: Sequence[str]) -> None:
    """Return the key of bodies that differ in numbers, names and materials alone."""


class _BodyGroup:
    """Bodies of one pattern that share all words except numbers, names and materials."""

    def __init__(self, words: _SlotWords, items: Sequence[PatternItem], plain: PlainBodyReader) -> None:
        self.pattern, self.items, self.plain, self.count = words.pattern, items, plain, len(items)
        self.columns = list(zip(*[item.words for item in items], strict=True))
        places = self.pattern.places
        self.numbers = {
            id(places[k].node): self.columns[k]
            for k in words.numbers
            if self.columns[k].count(self.columns[k][0]) < self.count
        }
        """By id of the node: the words of numbers that differ between bodies."""
        self.varied: dict[int, bool] = {}
        self.steps = 0

    def build(self) -> Iterator[tuple[int, FastBody]]:
        """Yield the bodies with their numbers in the group, without those in doubt; none if all are."""
        plain, first = self.plain, self.items[0]
        self.pattern.fill(first.words, first.line)
        plain.lasting, plain.steps = False, 0
        try:
            with raise_warnings():
                bodies = self._bodies()
        except _DOUBT:
            return
        finally:
            plain.lasting = True
        steps, entries = self.steps + plain.steps, self.pattern.item.entries
        row = self.pattern.row_of[self._place_of(entries["name"])] if "name" in entries else 0
        parts = 0
        for k, (item, body) in enumerate(zip(self.items, bodies, strict=True)):
            if body.shape is not None and body.name is not _DOUBTFUL and body.material is not _DOUBTFUL:
                parts = parts or 1 + plain.shapes.size(body.shape)  # all bodies have the same number of parts
                yield k, FastBody(body, parts, steps, item.line + row)

    def _bodies(self) -> list[Body]:
        """Return all bodies, as `PlainBodyReader.read` reads one."""
        entries = self.pattern.item.entries
        if "shape" not in entries or not entries.keys() <= {"shape", "name", "material", "move"}:
            raise UnusualNode
        shapes = self._shapes(entries["shape"], 0)
        names = self._words(entries["name"], str) if "name" in entries else repeat(None)
        materials = self._words(entries["material"], self._material) if "material" in entries else repeat(None)
        if "move" in entries:
            shapes = self._moved(shapes, entries["move"])
        each: Iterable[Shape | None]
        if isinstance(shapes, _SharedShape):
            is_named = any(shapes.shape is named for named in self.plain.shapes.built.values())
            # As without groups: bodies share a named shape, but equal shapes that are written out are objects of their
            # own.
            each = [shapes.shape] * self.count if is_named else self._copies(shapes.shape, repeat(shapes.shape.motion))
        else:
            each = shapes
        return construct_many(
            Body, self.count, shape=each, material=materials, name=names, materials=repeat(None),
            material_index=repeat(None),
        )  # fmt: skip

    def _material(self, word: str) -> Any:
        """Return the material of a word."""
        return self.plain.material(ScalarNode(0, 0, word, False))

    def _words(self, node: Node, meaning: Callable[[str], Any]) -> list[Any]:
        """Return the meanings of the words at a node for all bodies, `_DOUBTFUL` for words that are no texts."""
        plain_text(node)
        words, meanings = self.columns[self._place_of(node)], dict[str, Any]()
        for word in dict.fromkeys(words):
            try:
                meanings[word] = meaning(plain_text(ScalarNode(0, 0, word, node.plain)))  # type: ignore[union-attr]
            except _DOUBT:
                meanings[word] = _DOUBTFUL
        return list(map(meanings.__getitem__, words))

    def _place_of(self, node: Node) -> int:
        """Return the number of the slot at a node. Raise UnusualNode if there is none."""
        place = self.pattern.number_of.get(id(node))
        if place is None:
            raise UnusualNode
        return place

    def _varies(self, node: Node) -> bool:
        """Return True if a number at a node, or below it, differs between bodies."""
        if type(node) is ScalarNode:
            return id(node) in self.numbers
        known = self.varied.get(id(node))
        if known is None:
            below = node.items if isinstance(node, SequenceNode) else node.entries.values()  # type: ignore[union-attr]
            known = self.varied[id(node)] = any(self._varies(each) for each in below)
        return known

    def _values(self, node: Node) -> list[Any]:
        """Return the value at a node for each body: a number, or a tuple of the values below."""
        if isinstance(node, SequenceNode):
            return list(zip(*map(self._values, node.items), strict=True)) or [()] * self.count
        words = self.numbers.get(id(node))
        return [plain_number(node)] * self.count if words is None else list(map(float, words))

    def _shapes(self, node: Node, depth: int) -> _Shapes:
        """Return the shapes at a node, as `PlainBodyReader.shape` reads one."""
        if not self._varies(node):
            return _SharedShape(self.plain.shape(node, depth))
        if (
            type(node) is not MappingNode
            or len(node.entries) - ("move" in node.entries) != 1
            or depth > MAX_PLAIN_DEPTH
        ):
            raise UnusualNode
        head = next(name for name in node.entries if name != "move")
        value = node.entries[head]
        shapes = (
            self._shapes(value, depth + 1) if head == "shape" else self._build(find_constructor(head), value, depth)
        )
        return self._moved(shapes, node.entries["move"]) if "move" in node.entries else shapes

    def _build(self, constructor: ShapeConstructor | None, node: Node, depth: int) -> _Shapes:
        """Return primitives by their fields, or combinations of their operands."""
        if constructor is None:
            raise UnusualNode
        if not self._varies(node):
            return _SharedShape(self.plain.build(constructor, node, depth))
        if constructor.fields:
            values = self.plain.values(constructor, node)  # of the first body: checks that the nodes are plain
            assert isinstance(node, MappingNode)
            own = {name: self._values(value) for name, value in node.entries.items() if self._varies(value)}
            make = functools.partial(constructor.make, **{name: values[name] for name in values if name not in own})
            names = tuple(own)
            return _shape_rows(lambda *row: make(**dict(zip(names, row, strict=True))), zip(*own.values(), strict=True))
        if not constructor.several:
            return _shape_rows(constructor.make, zip(self._operands(node, depth), strict=True))
        if type(node) is not SequenceNode:
            raise UnusualNode
        rows = zip(*[self._operands(item, depth) for item in node.items], strict=True)
        return _shape_rows(lambda *row: constructor.make(row), rows)

    def _operands(self, node: Node, depth: int) -> list[Shape | None]:
        """Return the operand at a node for each body."""
        shapes = self._shapes(node, depth + 1)
        return [shapes.shape] * self.count if isinstance(shapes, _SharedShape) else shapes

    def _moved(self, shapes: _Shapes, node: Node) -> _Shapes:
        """Return the shapes after all steps of a `move` list."""
        if type(node) is not SequenceNode or len(node.items) > MAX_STEPS:
            raise UnusualNode
        of_all = isinstance(shapes, _SharedShape)
        example = (
            shapes.shape if isinstance(shapes, _SharedShape) else next((one for one in shapes if one is not None), None)
        )
        if example is None:
            raise UnusualNode
        before = example.motion
        self.steps += len(before.steps) + len(node.items)
        if not self._varies(node):
            motion = functools.reduce(append_step, node.items, IDENTITY_MOTION)
            if isinstance(shapes, _SharedShape):
                return _SharedShape(apply_motion(shapes.shape, motion))
            return _shape_rows(lambda shape: apply_motion(shape, motion), zip(shapes, strict=True))
        # Motions are composed and checked in columns; a body whose motion is not good is left out.
        then, good = compose_motions(
            self.count, [self._step(step) for step in node.items], before.reach if of_all else IDENTITY_REACH
        )
        if isinstance(shapes, _SharedShape):
            moved = self._copies(shapes.shape, map(before.then, then) if before.steps else then)
        elif before.steps:
            moved = _shape_rows(apply_motion, zip(shapes, then, strict=True))
        else:
            pairs = zip(shapes, then, strict=True)
            moved = [None if shape is None else shape._with_motion(motion) for shape, motion in pairs]
        return [shape if fine else None for shape, fine in zip(moved, good.tolist(), strict=True)]

    def _copies(self, shape: Shape, motions: Iterable[Motion]) -> list[Shape | None]:
        """Return a copy of a shape under each of some motions, which are checked already."""
        fields: dict[str, Iterable[Any]] = {name: repeat(value) for name, value in pickle_state(shape).items()}
        return construct_many(type(shape), self.count, **{**fields, "motion": motions})

    def _step(self, node: Node) -> StepColumn:
        """Return a step for each body, as `append_step` reads one."""
        if not self._varies(node):
            (step,) = append_step(IDENTITY_MOTION, node).steps
            return repeat_step(step)
        if type(node) is not MappingNode or len(node.entries) != 1:
            raise UnusualNode
        ((verb, value),) = node.entries.items()
        if verb == "translate":
            plain_vector(value)  # of the first body: checks that the nodes are plain
            return translate_column(self._values(value))
        if verb == "scale" and type(value) is ScalarNode:
            return scale_column([(factor, factor, factor) for factor in self._values(value)])
        if verb == "scale":
            plain_vector(value)
            return scale_column(self._values(value))
        if verb == "transform":
            plain_matrix(value)
            return transform_column(self._values(value))
        if verb != "rotate" or type(value) is not MappingNode or value.entries.keys() != {"axis", "degrees"}:
            raise UnusualNode
        axis, degrees = value.entries["axis"], value.entries["degrees"]
        plain_number(degrees)
        if type(axis) is ScalarNode and axis.text in AXES and is_text(axis):
            return rotate_column([AXES[axis.text]] * self.count, self._values(degrees))
        plain_vector(axis)
        return rotate_column(self._values(axis), self._values(degrees))


def _shape_rows(make: Callable[..., Shape], rows: Iterable[tuple[Any, ...]]) -> list[Shape | None]:
    """Return make(*row) for each row of operands or fields; None for a row with None in it, or one that raises."""
    shapes: list[Shape | None] = []
    for row in rows:
        try:
            shapes.append(None if None in row else make(*row))
        except (ValueError, TypeError, ArithmeticError):
            shapes.append(None)
    return shapes
