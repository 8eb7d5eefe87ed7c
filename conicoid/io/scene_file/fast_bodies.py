"""Bodies as they stand in nearly all files, read at once. What is unusual in any way is left to the reader that tells.

A `Quick` reads a node of one kind; it raises `Unusual` where the node is not plainly of that kind, and may raise what
the classes of shapes raise. Nothing is reported here, and nothing is counted before all of a body is read.
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

QuickReader: TypeAlias = Callable[[Node], Any]

_NUMBER = re.compile(DECIMAL)
MAX_PLAIN_DEPTH = 20


class UnusualNode(Exception):
    """What is not read here."""


@dataclass
class PlainBodyReader:
    """Reads bodies of one file, with what the reader of its shapes knows."""

    shapes: ShapeReader
    materials: dict[str, Any]
    names: dict[str, int]
    """Those of the bodies so far, with their lines."""
    steps: int = 0
    """Of the motions of the body that is being read."""
    colors: dict[str, Material] = field(default_factory=dict)
    lasting: bool = True
    """Do the nodes that are being read stay as they are?"""

    def read_alike(self, item: PatternItem) -> Body | None:
        """The same of a body that is written as others are; nothing is kept of its nodes, for which no alias stands."""
        self.lasting = False
        try:
            return self.read(item.read())
        finally:
            self.lasting = True

    def read(self, node: Node) -> Body | None:
        """The body at a node; None for one that is to be read word by word."""
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
        """Count a body of so many parts, with so many steps in its motions, and its name; False if it cannot be."""
        if name in self.names:
            return False
        if not self.shapes.allowance.take(parts, steps):
            self.shapes.allowance.take(-parts, -steps)
            return False
        if name is not None:
            self.names[name] = line
        return True

    def material(self, node: Node) -> Material:
        """A material by its name, or a colour."""
        name = plain_text(node)
        found = self.materials.get(name) or self.colors.get(name)
        if isinstance(found, Material):
            return found
        if name in self.materials:
            raise UnusualNode
        made = self.colors[name] = as_material("matte", name)
        return made

    def shape(self, node: Node, depth: int) -> Shape:
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
            made = find_constructor(head)
            if made is None:
                raise UnusualNode
            shape = self.built(made, value, depth)
        if "move" in node.entries:
            shape = self._moved(shape, node.entries["move"])
        if self.lasting:
            self.shapes.read_nodes[id(node)] = shape
        return shape

    def _named(self, node: Node) -> Shape:
        found = self.shapes.built.get(plain_text(node))
        if found is None or isinstance(found, BadValue):
            raise UnusualNode
        return found

    def built(self, made: ShapeConstructor, node: Node, depth: int) -> Shape:
        """A primitive of its fields, or a combination of its operands."""
        if made.fields:
            return made.make(**self.values(made, node))
        if not made.several:
            return made.make(self.shape(node, depth + 1))
        if type(node) is not SequenceNode or not node.items:
            raise UnusualNode
        return made.make(tuple([self.shape(item, depth + 1) for item in node.items]))

    def values(self, made: ShapeConstructor, node: Node) -> dict[str, Any]:
        """The values of a primitive's fields."""
        if type(node) is not MappingNode:
            raise UnusualNode
        fields, values = made.fields, {}
        for name, value in node.entries.items():
            if name not in fields:
                raise UnusualNode
            values[name] = fields[name](value)
        for name in made.required:
            if name not in values:
                raise UnusualNode
        return values

    def _moved(self, shape: Shape, node: Node) -> Shape:
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
    """How a class is made: from fields by name, or, where there are none, from one operand or several."""

    make: Callable[..., Shape]
    fields: dict[str, QuickReader]
    required: tuple[str, ...]
    several: bool = False


def find_constructor(name: str) -> ShapeConstructor | None:
    """None for what is not a class, and for bulk shapes."""
    cls = REGISTRY.get(name)
    return None if cls is None or issubclass(cls, Bulk) else _constructor(cls)


@cache
def _constructor(cls: type[Shape]) -> ShapeConstructor:
    """How its objects are made."""
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
    """What reads the plainest nodes of a kind."""
    if type(kind) is NumberType:
        return plain_number
    if type(kind) is FixedListType or type(kind) is ListType:
        return _list(_quick_reader(kind.item), kind.count if isinstance(kind, FixedListType) else None)
    return _quick_reader(kind.item) if type(kind) is OptionalType else _unusual


def _unusual(_: Node) -> Any:
    raise UnusualNode


def _list(item: QuickReader, count: int | None) -> QuickReader:
    def read(node: Node) -> tuple[Any, ...]:
        if type(node) is not SequenceNode or (count is not None and len(node.items) != count):
            raise UnusualNode
        return tuple([item(each) for each in node.items])

    return read


def plain_number(node: Node) -> float:
    if type(node) is not ScalarNode or not node.plain or not _NUMBER.fullmatch(node.text):
        raise UnusualNode
    return float(node.text)


plain_vector = _list(plain_number, 3)
plain_matrix = _list(_list(plain_number, 4), 4)


def plain_text(node: Node) -> str:
    if type(node) is not ScalarNode or not is_text(node) or not node.text:
        raise UnusualNode
    return node.text


def append_step(motion: Motion, step: Node) -> Motion:
    """The motion followed by one more step."""
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


# Bodies that are written alike, made together: what they have in common is read once, and their numbers in columns.
#
# What is plain in one of them is plain in all, as they are of one pattern; what their numbers decide is looked at for
# all
# at once. Nothing is reported or counted here. A body of which anything is in doubt is left to `PlainBodies`, and all
# of
# a pattern are where there is something to warn of, or more to them than is plain.

_MIN_GROUP = 8
"""Bodies of a pattern that are worth it."""
_DOUBT = (UnusualNode, SuppressedWarning, ValueError, TypeError, ArithmeticError)
_DOUBTFUL: Any = object()


class FastBody(NamedTuple):
    """A body as it was made, and what is to be counted of it."""

    body: Body
    parts: int
    steps: int
    """Of its motions."""
    name_line: int


@dataclass
class _SharedShape:
    """The shape that all have."""

    shape: Shape


_Shapes: TypeAlias = _SharedShape | list[Shape | None]
"""The shape of each; None where it is in doubt."""


def build_alike_bodies(first: int, items: Sequence[DocumentItem], plain: PlainBodyReader) -> dict[int, FastBody]:
    """Bodies by their places, of which the first is said: those that could be made with others."""
    groups: dict[Any, list[int]] = {}
    words_of: dict[int, _SlotWords] = {}
    for place, item in enumerate(items):
        if type(item) is PatternItem:
            words = words_of.get(id(item.pattern))
            if words is None:
                words = words_of[id(item.pattern)] = _SlotWords(item.pattern)
            groups.setdefault((words, words.key(item.words)), []).append(place)
    found: dict[int, FastBody] = {}
    for (words, _), places in groups.items():
        if len(places) >= _MIN_GROUP:
            group = _BodyGroup(words, [items[place] for place in places], plain)  # type: ignore[misc]
            found.update((first + places[k], made) for k, made in group.made())
    return found


class _SlotWords:
    """What stands in the places of a pattern: numbers, the body's name and material, or what tells bodies apart."""

    def __init__(self, pattern: TextPattern) -> None:
        self.pattern = pattern
        own = [id(pattern.item.entries.get(name)) for name in ("name", "material")]
        self.numbers = [k for k, is_number in enumerate(pattern.is_number) if is_number]
        others = [k for k, place in enumerate(pattern.places) if id(place.node) not in own and not pattern.is_number[k]]
        self.key: Callable[[Sequence[str]], Any] = itemgetter(*others) if others else _no_key


def _no_key(_: Sequence[str]) -> None:
    """What bodies are told apart by that differ in numbers, names and materials alone."""


class _BodyGroup:
    """Bodies of one pattern that have the same words, but for numbers and their names and materials."""

    def __init__(self, words: _SlotWords, items: Sequence[PatternItem], plain: PlainBodyReader) -> None:
        self.pattern, self.items, self.plain, self.count = words.pattern, items, plain, len(items)
        self.columns = list(zip(*[item.words for item in items], strict=True))
        places = self.pattern.places
        self.numbers = {
            id(places[k].node): self.columns[k]
            for k in words.numbers
            if self.columns[k].count(self.columns[k][0]) < self.count
        }
        """The words of numbers that are not the same in all."""
        self.varied: dict[int, bool] = {}
        self.steps = 0

    def made(self) -> Iterator[tuple[int, FastBody]]:
        """Bodies by their numbers among those of the group, without those that are in doubt."""
        plain, first = self.plain, self.items[0]
        self.pattern.filled(first.words, first.line)
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
                parts = parts or 1 + plain.shapes.size(body.shape)  # it is that of all
                yield k, FastBody(body, parts, steps, item.line + row)

    def _bodies(self) -> list[Body]:
        """All of them, as `PlainBodies.read` reads one."""
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
            each = [shapes.shape] * self.count if is_named else self._twins(shapes.shape, repeat(shapes.shape.motion))
        else:
            each = shapes
        return construct_many(
            Body, self.count, shape=each, material=materials, name=names, materials=repeat(None),
            material_index=repeat(None),
        )  # fmt: skip

    def _material(self, word: str) -> Any:
        return self.plain.material(ScalarNode(0, 0, word, False))

    def _words(self, node: Node, meaning: Callable[[str], Any]) -> list[Any]:
        """What the words at a node mean, texts all of them; `_DOUBTFUL` for others."""
        plain_text(node)
        words, found = self.columns[self._place_of(node)], dict[str, Any]()
        for word in dict.fromkeys(words):
            try:
                found[word] = meaning(plain_text(ScalarNode(0, 0, word, node.plain)))  # type: ignore[union-attr]
            except _DOUBT:
                found[word] = _DOUBTFUL
        return list(map(found.__getitem__, words))

    def _place_of(self, node: Node) -> int:
        place = self.pattern.number_of.get(id(node))
        if place is None:
            raise UnusualNode
        return place

    def _varies(self, node: Node) -> bool:
        """Are there numbers at a node, or below it, that are not the same in all?"""
        if type(node) is ScalarNode:
            return id(node) in self.numbers
        known = self.varied.get(id(node))
        if known is None:
            below = node.items if isinstance(node, SequenceNode) else node.entries.values()  # type: ignore[union-attr]
            known = self.varied[id(node)] = any(self._varies(each) for each in below)
        return known

    def _values(self, node: Node) -> list[Any]:
        """What stands at a node in each: numbers, or tuples of what stands below."""
        if isinstance(node, SequenceNode):
            return list(zip(*map(self._values, node.items), strict=True)) or [()] * self.count
        words = self.numbers.get(id(node))
        return [plain_number(node)] * self.count if words is None else list(map(float, words))

    def _shapes(self, node: Node, depth: int) -> _Shapes:
        """The shapes at a node, as `PlainBodies.shape` reads one."""
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
            self._shapes(value, depth + 1) if head == "shape" else self._built(find_constructor(head), value, depth)
        )
        return self._moved(shapes, node.entries["move"]) if "move" in node.entries else shapes

    def _built(self, made: ShapeConstructor | None, node: Node, depth: int) -> _Shapes:
        """Primitives of their fields, or combinations of their operands."""
        if made is None:
            raise UnusualNode
        if not self._varies(node):
            return _SharedShape(self.plain.built(made, node, depth))
        if made.fields:
            given = self.plain.values(made, node)
            assert isinstance(node, MappingNode)
            own = {name: self._values(value) for name, value in node.entries.items() if self._varies(value)}
            make = functools.partial(made.make, **{name: given[name] for name in given if name not in own})
            names = tuple(own)
            return _shape_rows(lambda *row: make(**dict(zip(names, row, strict=True))), zip(*own.values(), strict=True))
        if not made.several:
            return _shape_rows(made.make, zip(self._listed(node, depth), strict=True))
        if type(node) is not SequenceNode:
            raise UnusualNode
        rows = zip(*[self._listed(item, depth) for item in node.items], strict=True)
        return _shape_rows(lambda *row: made.make(row), rows)

    def _listed(self, node: Node, depth: int) -> list[Shape | None]:
        """The operands at a node."""
        shapes = self._shapes(node, depth + 1)
        return [shapes.shape] * self.count if isinstance(shapes, _SharedShape) else shapes

    def _moved(self, shapes: _Shapes, node: Node) -> _Shapes:
        """The shapes after all steps of a list."""
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
        then, good = compose_motions(
            self.count, [self._step(step) for step in node.items], before.reach if of_all else IDENTITY_REACH
        )
        if isinstance(shapes, _SharedShape):
            moved = self._twins(shapes.shape, map(before.then, then) if before.steps else then)
        elif before.steps:
            moved = _shape_rows(apply_motion, zip(shapes, then, strict=True))
        else:
            kept = zip(shapes, then, strict=True)
            moved = [None if shape is None else shape._with_motion(motion) for shape, motion in kept]
        return [shape if fine else None for shape, fine in zip(moved, good.tolist(), strict=True)]

    def _twins(self, shape: Shape, moved: Iterable[Motion]) -> list[Shape | None]:
        """A shape under motions that were checked."""
        fields: dict[str, Iterable[Any]] = {name: repeat(value) for name, value in pickle_state(shape).items()}
        return construct_many(type(shape), self.count, **{**fields, "motion": moved})

    def _step(self, node: Node) -> StepColumn:
        """A step of each, as `followed` reads one."""
        if not self._varies(node):
            (step,) = append_step(IDENTITY_MOTION, node).steps
            return repeat_step(step)
        if type(node) is not MappingNode or len(node.entries) != 1:
            raise UnusualNode
        ((verb, value),) = node.entries.items()
        if verb == "translate":
            plain_vector(value)
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
    """Shapes of rows, which hold shapes or what they are made of; None for a row that is in doubt."""
    made: list[Shape | None] = []
    for row in rows:
        try:
            made.append(None if None in row else make(*row))
        except (ValueError, TypeError, ArithmeticError):
            made.append(None)
    return made
