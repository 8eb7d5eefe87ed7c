"""Bodies as they stand in nearly all files, read at once. What is unusual in any way is left to the reader that tells.

A `Quick` reads a node of one kind; it raises `Unusual` where the node is not plainly of that kind, and may raise what
the classes of shapes raise. Nothing is reported here, and nothing is counted before all of a body is read.
"""

from __future__ import annotations

import re
from collections.abc import Callable
from dataclasses import dataclass, field
from functools import cache
from typing import Any, TypeAlias

from ..shapes import REGISTRY, Shape
from ..shapes.body import Body
from ..shapes.bulk import Bulk
from ..shapes.makers import as_material
from ..shapes.material import Material
from ..shapes.motion import AXES, STILL, Motion
from .alike import Alike
from .fields import fields_of
from .kinds import Fixed, Kind, Maybe, Number, Several
from .nodes import DECIMAL, Listing, Node, Scalar, Table, is_text
from .reading import Bad
from .shape_nodes import MAX_STEPS, ShapeReader, moved_by, operand_field

Quick: TypeAlias = Callable[[Node], Any]

_NUMBER = re.compile(DECIMAL)
DEEPEST = 20


class Unusual(Exception):
    """What is not read here."""


@dataclass
class PlainBodies:
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

    def read_alike(self, item: Alike) -> Body | None:
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
        except (Unusual, ValueError, TypeError, ArithmeticError):
            return None

    def _body(self, node: Node) -> Body:
        if type(node) is not Table:
            raise Unusual
        name: str | None = None
        shape: Shape | None = None
        material: Material | None = None
        for key, value in node.entries.items():
            if key == "shape":
                shape = self.shape(value, 0)
            elif key == "name":
                name = text_of(value)
            elif key == "material":
                material = self.material(value)
            elif key != "move":
                raise Unusual
        if shape is None or name in self.names:
            raise Unusual
        if "move" in node.entries:
            shape = self._moved(shape, node.entries["move"])
        body = Body(shape, material, name)
        if not self.accepts(name, 0 if name is None else node.entries["name"].line, self.steps):
            raise Unusual
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
        name = text_of(node)
        found = self.materials.get(name) or self.colors.get(name)
        if isinstance(found, Material):
            return found
        if name in self.materials:
            raise Unusual
        made = self.colors[name] = as_material("matte", name)
        return made

    def shape(self, node: Node, depth: int) -> Shape:
        known = self.shapes.read_nodes.get(id(node)) if self.lasting else None
        if known is not None:
            if isinstance(known, Bad):
                raise Unusual
            shape: Shape = known
            return shape
        if type(node) is Scalar:
            return self._named(node)
        if type(node) is not Table or len(node.entries) - ("move" in node.entries) != 1 or depth > DEEPEST:
            raise Unusual
        head = next(name for name in node.entries if name != "move")
        value = node.entries[head]
        if head == "shape":
            shape = self.shape(value, depth + 1)
        else:
            made = made_by(head)
            if made is None:
                raise Unusual
            shape = self.built(made, value, depth)
        if "move" in node.entries:
            shape = self._moved(shape, node.entries["move"])
        if self.lasting:
            self.shapes.read_nodes[id(node)] = shape
        return shape

    def _named(self, node: Node) -> Shape:
        found = self.shapes.built.get(text_of(node))
        if found is None or isinstance(found, Bad):
            raise Unusual
        return found

    def built(self, made: MadeBy, node: Node, depth: int) -> Shape:
        """A primitive of its fields, or a combination of its operands."""
        if made.fields:
            return made.make(**self.values(made, node))
        if not made.several:
            return made.make(self.shape(node, depth + 1))
        if type(node) is not Listing or not node.items:
            raise Unusual
        return made.make(tuple([self.shape(item, depth + 1) for item in node.items]))

    def values(self, made: MadeBy, node: Node) -> dict[str, Any]:
        """The values of a primitive's fields."""
        if type(node) is not Table:
            raise Unusual
        fields, values = made.fields, {}
        for name, value in node.entries.items():
            if name not in fields:
                raise Unusual
            values[name] = fields[name](value)
        for name in made.required:
            if name not in values:
                raise Unusual
        return values

    def _moved(self, shape: Shape, node: Node) -> Shape:
        if type(node) is not Listing or len(node.items) > MAX_STEPS:
            raise Unusual
        motion = self.shapes.motions.get(id(node)) if self.lasting else None
        if motion is None:
            motion = STILL
            for step in node.items:
                motion = followed(motion, step)
            if self.lasting:
                self.shapes.motions[id(node)] = motion
        if isinstance(motion, Bad):
            raise Unusual
        self.steps += len(shape.motion.steps) + len(motion.steps)
        return moved_by(shape, motion)


@dataclass(frozen=True)
class MadeBy:
    """How a class is made: from fields by name, or, where there are none, from one operand or several."""

    make: Callable[..., Shape]
    fields: dict[str, Quick]
    required: tuple[str, ...]
    several: bool = False


def made_by(name: str) -> MadeBy | None:
    """None for what is not a class, and for bulk shapes."""
    cls = REGISTRY.get(name)
    return None if cls is None or issubclass(cls, Bulk) else _made_of(cls)


@cache
def _made_of(cls: type[Shape]) -> MadeBy:
    """How its objects are made."""
    operand = operand_field(cls)
    if operand is not None:
        return MadeBy(cls, {}, (), isinstance(operand, Several))
    fields = fields_of(cls)
    return MadeBy(
        cls,
        {name: _quick(field.kind) for name, field in fields.items()},
        tuple(name for name, field in fields.items() if field.required),
    )


def _quick(kind: Kind) -> Quick:
    """What reads the plainest nodes of a kind."""
    if type(kind) is Number:
        return number
    if type(kind) is Fixed or type(kind) is Several:
        return _list(_quick(kind.item), kind.count if isinstance(kind, Fixed) else None)
    return _quick(kind.item) if type(kind) is Maybe else _unusual


def _unusual(_: Node) -> Any:
    raise Unusual


def _list(item: Quick, count: int | None) -> Quick:
    def read(node: Node) -> tuple[Any, ...]:
        if type(node) is not Listing or (count is not None and len(node.items) != count):
            raise Unusual
        return tuple([item(each) for each in node.items])

    return read


def number(node: Node) -> float:
    if type(node) is not Scalar or not node.plain or not _NUMBER.fullmatch(node.text):
        raise Unusual
    return float(node.text)


vector_of = _list(number, 3)
matrix_of = _list(_list(number, 4), 4)


def text_of(node: Node) -> str:
    if type(node) is not Scalar or not is_text(node) or not node.text:
        raise Unusual
    return node.text


def followed(motion: Motion, step: Node) -> Motion:
    """The motion followed by one more step."""
    if type(step) is not Table or len(step.entries) != 1:
        raise Unusual
    ((verb, value),) = step.entries.items()
    if verb == "translate":
        return motion.translate(vector_of(value))
    if verb == "scale":
        return motion.scale(number(value) if type(value) is Scalar else vector_of(value))
    if verb == "transform":
        return motion.transform(matrix_of(value))
    if verb != "rotate" or type(value) is not Table or value.entries.keys() != {"axis", "degrees"}:
        raise Unusual
    axis = value.entries["axis"]
    direction = axis.text if type(axis) is Scalar and axis.text in AXES and is_text(axis) else vector_of(axis)
    return motion.rotate(direction, number(value.entries["degrees"]))
