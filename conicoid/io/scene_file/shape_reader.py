"""Shapes of scene files: primitives, Booleans, references, motions, and arrays of many bodies in one entry.

`ShapeReader` reads them. `PartBudget` limits the parts that references and aliases expand to: twenty lines of
references that double would make a million parts, and placing each takes time. So parts are counted before anything is
made of them, and only long files may have many.
"""

from __future__ import annotations

import contextlib
import functools
import operator
import re
from collections.abc import Callable, Iterable, Iterator, Sequence
from functools import cache
from pathlib import Path
from typing import Any

import numpy as np

from ..._util.files import open_regular
from ...geometry.bulk import Bulk
from ...geometry.registry import REGISTRY
from ...geometry.shape import Difference, Intersection, Shape, Sheet
from ...geometry.transform import AXES, IDENTITY_MOTION, Motion, apply_about
from ..npz import NpzArchive, read_array, read_rows, resolve_data_file
from .fields import ArgumentsType, ShapeType, argument_fields
from .nodes import (
    BAD,
    BadValue,
    BoolType,
    ChoiceType,
    FixedListType,
    HasPosition,
    IntegerType,
    ListType,
    MappingNode,
    Node,
    NodeReader,
    NumberType,
    OptionalType,
    ScalarNode,
    Schema,
    SequenceNode,
    TextType,
    TooManyProblems,
    UnionType,
    ValueType,
    is_text,
    shorten,
)

# Limits on the number of parts.

FREE_PARTS, PARTS_PER_VALUE, MAX_PARTS = 1 << 15, 4, 1_000_000
"""Parts that any file may have, parts for each value in a file, and most parts of any file."""
STEP_PARTS, STEP_COMPOSED = 2, 4
"""Parts that take as long as one step in the motion of a part, and as one step that is composed into a motion."""
PARTS_PHRASE = "parts and steps of motion, references written out,"


class PartBudget:
    """The number of parts of all bodies of a file together, and of composed steps, with their limit.

    `values` is the number of values written in the file, keys included; the values of an alias count once.
    """

    def __init__(self, values: int) -> None:
        self.parts = self.steps = 0
        self.values = values
        self.most = part_limit(values)

    def extend(self, values: int) -> None:
        """Count more values of the file, such as the numbers of columns beside it."""
        self.values += values
        self.most = part_limit(self.values)

    def take(self, parts: int = 0, steps: int = 0) -> bool:
        """Count more parts, and steps to be composed; return False beyond the limit."""
        self.parts += parts
        self.steps += steps * STEP_COMPOSED
        return max(self.parts, self.steps) <= self.most


def part_limit(values: int) -> int:
    """Return the most parts of a file with so many values."""
    # In proportion to the file: a short text must not make much work
    return min(MAX_PARTS, max(FREE_PARTS, PARTS_PER_VALUE * values))


class ShapeSizes:
    """Counts the parts of shapes, with references written out: a shared part counts once for each use."""

    def __init__(self) -> None:
        self.sizes: dict[int, tuple[Shape, int]] = {}  # by id: the shape, kept alive, and its parts
        self.below: dict[int, tuple[Any, int]] = {}  # by id: operands, which shapes that are moved share, and theirs

    def __call__(self, shape: Shape) -> int:
        """Return the number of primitives and Booleans of a shape, and `STEP_PARTS` for each step of motion.

        The tree is walked without recursion, as it may be deep.
        """
        names = shape_fields(type(shape))
        own = 1 + STEP_PARTS * len(shape.motion.steps)
        if not names:
            return own
        operands = getattr(shape, names[0]) if len(names) == 1 else None
        # A shape that is moved a thousand times has one tuple of operands
        sizes = self.below.get(id(operands)) if operands is not None else None
        if sizes is not None:
            return own + sizes[1]
        pending = [shape]
        while pending:
            top = pending[-1]
            parts = operand_shapes(top)
            unknown = [part for part in parts if id(part) not in self.sizes]
            if unknown:
                pending.extend(unknown)
                continue
            below = sum(self.sizes[id(part)][1] for part in parts)
            # The shape is kept beside its size, so that its id stays its own
            self.sizes[id(top)] = top, 1 + STEP_PARTS * len(top.motion.steps) + below
            pending.pop()
        size = self.sizes[id(shape)][1]
        if operands is not None:
            self.below[id(operands)] = operands, size - own
        return size


def count_parts(shapes: Iterable[Shape]) -> int:
    """Return the parts of all shapes together, as `PartBudget` counts those of bodies."""
    size = ShapeSizes()
    return sum(1 + size(shape) for shape in shapes)


def operand_shapes(shape: Shape) -> list[Shape]:
    """Return the shapes in the fields of a shape."""
    operands = [getattr(shape, name) for name in shape_fields(type(shape))]
    flat = [item for value in operands for item in (value if isinstance(value, tuple) else (value,))]
    return [item for item in flat if isinstance(item, Shape)]


@cache
def shape_fields(cls: type[Shape]) -> tuple[str, ...]:
    """Return the fields of a class that may hold shapes: those whose type is not of numbers and texts only."""
    return tuple(name for name, field in argument_fields(cls).items() if not _is_plain(field.kind))


def _is_plain(kind: ValueType) -> bool:
    """Return True if a type holds numbers and texts only."""
    if isinstance(kind, UnionType):
        return all(map(_is_plain, kind.items))
    return (
        _is_plain(kind.item)
        if isinstance(kind, (ListType, FixedListType, OptionalType))
        else isinstance(kind, _PLAIN_TYPES)
    )


_PLAIN_TYPES = (NumberType, IntegerType, BoolType, TextType)


# Many bodies in one entry: arrays written out, or in a .npy, .npz or .csv file beside the scene file.

INDEX_SCHEMA: Schema = {
    "description": "Of many bodies in one entry, the place of each one's material among the materials.",
    "anyOf": [
        ListType(IntegerType()).schema(),
        {
            "type": "object",
            "properties": {"file": {"type": "string", "description": "A .npy file of integers beside the scene."}},
            "required": ["file"],
            "additionalProperties": False,
        },
    ],
}


def array_type(cls: type[Bulk], field: str) -> ValueType:
    """Return the type of a field: a value for each body, or one value for all."""
    width = len(cls.columns[field])
    one: ValueType = NumberType() if width == 1 else FixedListType(NumberType(), width)
    return UnionType((one, ListType(one)))


def read_bulk_shape(cls: type[Bulk], value: Node, reader: NodeReader, where: str) -> Any:
    """Return the shape of many bodies at a node, or BAD after a report."""
    fields = tuple(cls.columns)
    entries = reader.entries(value, where, (*fields, "file"))
    if isinstance(entries, BadValue):
        return BAD
    # Some columns here and others in a file could differ in length
    if set(entries) not in (set(fields), {"file"}):
        listed = f"{', '.join(fields[:-1])} and {fields[-1]}"
        return reader.report(value, where, f"either {listed}, or file, must be given")
    if "file" in entries:
        return _read_file(cls, entries["file"], reader, f"{where}: file")
    found = {name: _read_array(cls, name, entries[name], reader, f"{where}: {name}") for name in fields}
    if any(each is BAD for each in found.values()):
        return BAD
    return reader.build(value, where, lambda: cls(**found))


def _read_array(cls: type[Bulk], field: str, node: Node, reader: NodeReader, where: str) -> Any:
    """Return an array of a field, or BAD after a report. A list of numbers is one vector for all bodies."""
    width = len(cls.columns[field])
    if width == 1:
        return array_type(cls, field).read(node, reader, where)
    one = FixedListType(NumberType(), width)
    items = getattr(node, "items", ())
    if len(items) and all(NumberType().fits(item) for item in items):
        return one.read(node, reader, where)
    found = ListType(one).read(node, reader, where)
    return BAD if found is BAD else np.array(found, np.float64).reshape(len(found), width)


def _read_file(cls: type[Bulk], node: Node, reader: NodeReader, where: str) -> Any:
    """Return the shape of a file beside the scene, or BAD after a report."""
    name = TextType().read(node, reader, where)
    if name is BAD:
        return BAD

    def load() -> Bulk:
        # A .npz holds one array for each field; the other files are one table
        if name.lower().endswith(".npz"):
            return cls(**read_bulk_arrays(name, reader.folder, tuple(cls.columns)))
        path = _read_bulk(name, lambda: resolve_data_file(reader.folder, name))
        headings = cls.headings()
        table, lines = _read_bulk(name, lambda: read_rows(path, len(headings), headings))
        try:
            shape: Bulk = cls.of_table(table)
        except ValueError as error:
            raise ValueError(_add_line(str(error), shorten(name), lines)) from None
        return shape

    return reader.build(node, where, load)


def read_index(node: Node, reader: NodeReader, where: str) -> Any:
    """Return `material_index`: integers written out, or in a .npy file; BAD after a report."""
    if not isinstance(node, MappingNode):
        return ListType(IntegerType()).read(node, reader, where)
    entries = reader.entries(node, where, ("file",), ("file",))
    name: Any = BAD
    if not isinstance(entries, BadValue) and "file" in entries:
        name = TextType().read(entries["file"], reader, where)
    if name is BAD:
        return BAD

    def load() -> Any:
        path = _read_bulk(name, lambda: resolve_data_file(reader.folder, name))
        found, values = _read_bulk(name, lambda: read_array(path))
        # Files hold floats or integers of any size; indices are compared once they are whole
        if values is None or values.ndim != 1 or not (np.isfinite(values) & (values == np.floor(values))).all():
            raise ValueError(f"{path.name} must hold integers of shape (N,), got {found}")
        return values.astype(np.int64)

    return reader.build(node, where, load)


def _read_bulk(name: str, read: Callable[[], Any]) -> Any:
    """Return read(), with an OSError as a ValueError that names the file."""
    try:
        return read()
    except OSError as error:
        raise ValueError(f"{shorten(name)!r} cannot be read: {(error.strerror or str(error)).lower()}") from None


def read_bulk_arrays(name: str, folder: Path, fields: Sequence[str]) -> dict[str, Any]:
    """Return the arrays of a .npz file in a folder. Raise ValueError if one is missing or bad."""
    path = _read_bulk(name, lambda: resolve_data_file(folder, name))

    def read() -> dict[str, Any]:
        with open_regular(path) as file:
            try:
                archive = NpzArchive(file)
            except ValueError as error:
                raise ValueError(f"{path.name} {error}") from None
            missing = [name for name in fields if name not in archive.members]
            if missing:
                raise ValueError(f"{path.name} must hold the arrays {', '.join(fields)}; {missing[0]} is missing")
            try:
                return dict(archive.arrays(fields))
            except ValueError as error:
                raise ValueError(f"{path.name}: {error}") from None

    return _read_bulk(path.name, read)


def _add_line(message: str, name: str, lines: Sequence[int]) -> str:
    """Return a message about one body of a file, such as "radii[3] ...", with the body's line if the file has lines."""
    row = re.search(r"\[(\d+)\]", message)
    if row is None or not int(row[1]) < len(lines):
        return message
    owner, _, rest = message.partition(": ")
    return f"{owner}: {name}:{lines[int(row[1])]}: {rest}"


# Shapes: ``{ClassName: {fields}, move: [...]}``, Booleans of them, and references. Examples:
#
# {Sphere: {radius: 2}, move: [{translate: [0, 0, 1]}]}
# {Difference: [{Box: {}}, {Sphere: {radius: 1.2}}]}
# wheel                                   # a name under `shapes`
# {shape: wheel, move: [{scale: 2}]}

MAX_LEVELS = 100
"""Most levels of shapes within shapes; reading them is recursive."""
MAX_STEPS = 1000
"""Most steps of one `move` list."""

VECTOR_TYPE = FixedListType(NumberType(), 3)


class AxisType(UnionType):
    """A direction, or the name of an axis of coordinates."""

    def __init__(self) -> None:
        super().__init__((VECTOR_TYPE, ChoiceType(tuple(AXES))))
        self.phrase = "3 numbers, or one of x, y, z, -x, -y, -z"

    def read(self, node: Node, reader: NodeReader, where: str) -> Any:
        if isinstance(node, ScalarNode) and is_text(node) and node.text not in AXES:
            return reader.report_mismatch(node, where, self.phrase)
        return super().read(node, reader, where)


AXIS_TYPE = AxisType()
MOVE_TYPES: dict[str, ValueType] = {
    "translate": VECTOR_TYPE,
    "scale": UnionType((NumberType(), VECTOR_TYPE)),
    "transform": FixedListType(FixedListType(NumberType(), 4), 4),
}


ROTATION_TYPES: dict[str, ValueType] = {"axis": AXIS_TYPE, "degrees": NumberType(), "about": VECTOR_TYPE}


class ShapeReader:
    """Reads the shapes of one scene file; knows the named ones, and the number of parts of each.

    Named shapes are read on first use, so that they may stand in any order.
    """

    def __init__(self, reader: NodeReader, named: dict[str, Node], allowance: PartBudget) -> None:
        self.reader = reader
        self.named_nodes = named
        self.named_shapes: dict[str, Shape | BadValue] = {}
        self.stack: list[str] = []  # the named shapes that are being read, to find circles
        self.level = 0
        self.allowance = allowance
        self.size = ShapeSizes()
        self.classes: dict[str, type[Shape]] = {}  # a lookup in `REGISTRY` takes microseconds
        self.read_nodes: dict[int, Any] = {}  # by id: the values of nodes, for their aliases
        self.motions: dict[int, Motion | BadValue] = {}
        reader.shape = self.read

    @contextlib.contextmanager
    def pause_cache(self) -> Iterator[None]:
        """Within the block, store nothing for long by the ids of nodes: they do not last."""
        known = self.read_nodes, self.motions
        self.read_nodes, self.motions = {}, {}
        try:
            yield
        finally:
            self.read_nodes, self.motions = known

    def read_named(self) -> None:
        """Read all named shapes, used or not."""
        for name in self.named_nodes:
            self._resolve(name)

    def read(self, node: Node, where: str, base: type = Shape) -> Any:
        """Return the shape at a node, or BAD after a report; it must be of class `base`."""
        # Before recursion meets Python's limit, which would be no message about the file
        if self.level >= MAX_LEVELS:
            return self.reader.report(
                node, where, f"nested deeper than {MAX_LEVELS} levels (put parts under `shapes`, each before its use)"
            )
        self.level += 1
        try:
            if is_text(node):
                shape = self._reference(node, where)
            # An alias is the same node object, which is read once
            elif (shape := self.read_nodes.get(id(node))) is None:
                shape = self.read_nodes[id(node)] = self._written(node, where)
        finally:
            self.level -= 1
        if shape is BAD or isinstance(shape, base):
            return shape
        found = f"{type(shape).__name__}, a {'sheet' if shape.is_sheet else 'solid'}"
        return self.reader.report(node, where, f"must be {ShapeType(base).phrase}, got {found}")

    def check_size(self, node: Node, where: str, shape: Shape) -> Shape | BadValue:
        """Return the shape, or BAD after a report if references expand it to more than `MAX_PARTS`."""
        if self.size(shape) > MAX_PARTS:
            return self.reader.report(node, where, f"has more than {MAX_PARTS:,} parts, references written out")
        return shape

    def charge_body(self, node: HasPosition, where: str, shape: Shape) -> None:
        """Count the parts of a body. Raise TooManyProblems, after a report, if the file has too many for its length."""
        self.charge(node, where, parts=1 + self.size(shape))

    def charge(self, node: HasPosition, where: str, parts: int = 0, steps: int = 0) -> None:
        """Count parts and composed steps. Raise TooManyProblems, after a report, if the budget is exceeded."""
        if not self.allowance.take(parts, steps):
            grown = (
                f"here the file has grown to more than {self.allowance.most:,} "
                f"{PARTS_PHRASE} which is too much for its length"
            )
            self.reader.report(node, where, grown)
            raise TooManyProblems

    def _reference(self, node: Node, where: str) -> Any:
        """Return a named shape, or BAD after a report of an unknown name or a circle."""
        name = node.text if isinstance(node, ScalarNode) else ""
        if name in self.named_nodes:
            if name in self.stack:
                circle = " → ".join([*self.stack[self.stack.index(name) :], name])
                return self.reader.report(node, where, f"shapes refer to each other in a circle: {circle}")
            return self._resolve(name)
        # "Sphere" instead of "Sphere: {...}": the bare word is a text in YAML
        if name in REGISTRY:
            return self.reader.report(
                node, where, f"must be a mapping, {{{name}: {{...}}}}, got the bare word {name!r}"
            )
        return self.reader.unknown(node, where, "shape", name, self.named_nodes)

    def _resolve(self, name: str) -> Shape | BadValue:
        """Return a named shape, which is read on first use."""
        if name not in self.named_shapes:
            self.stack.append(name)
            node, where = self.named_nodes[name], f'shape "{name}"'
            shape = self.read(node, where)
            self.named_shapes[name] = shape if isinstance(shape, BadValue) else self.check_size(node, where, shape)
            self.stack.pop()
        return self.named_shapes[name]

    def _written(self, node: Node, where: str) -> Any:
        """Return the shape of a mapping: a shape as its only key, and perhaps `move`."""
        if not isinstance(node, MappingNode):
            example = "a shape, a mapping such as {Sphere: {radius: 1}}, or the name of one under `shapes`"
            return self.reader.report_mismatch(node, where, example)
        heads = [key for key in node.heads if key.text != "move"]
        if len(heads) != 1:
            found = f"{len(heads)}: {', '.join(key.text for key in heads[:4])}" if heads else "none"
            return self.reader.report(
                node, where, f"must have one shape as its key (and `move` beside it), got {found}"
            )
        shape = self.shape_of_key(heads[0], node.entries[heads[0].text], where)
        return self.moved(shape, node.entries.get("move"), where)

    def shape_of_key(self, key: ScalarNode, value: Node, where: str) -> Any:
        """Return the shape of one key and its value: a class, or `shape` for a nested one."""
        if key.text == "shape":
            return self.read(value, where)
        cls = self.classes.get(key.text)
        if cls is None:
            if key.text not in REGISTRY:
                return self.reader.unknown(key, where, "shape", key.text, [*REGISTRY, "shape"])
            cls = self.classes[key.text] = REGISTRY[key.text]
        if issubclass(cls, Bulk):
            return read_bulk_shape(cls, value, self.reader, f"{where}: {cls.__name__}")
        if (field := operand_field(cls)) is None:
            return ArgumentsType(cls).read(value, self.reader, where)
        where = f"{where}: {cls.__name__}"
        operands = self._operands(value, where, isinstance(field, ListType))
        return operands if operands is BAD else self.reader.build(value, where, lambda: build_boolean(cls, operands))

    def _operands(self, value: Node, where: str, several: bool) -> Any:
        """Return the operands of a Boolean, one shape or a tuple, or BAD after a report."""
        if not several:
            return self.read(value, where)
        # An empty union would be a body without points
        if not isinstance(value, SequenceNode) or not value.items:
            return self.reader.report_mismatch(value, where, "a list of at least one solid")
        shapes = []
        for i, item in enumerate(value.items):
            shapes.append(self.read(item, f"{where}[{i}]"))
        return BAD if BAD in shapes else tuple(shapes)

    def moved(self, shape: Any, moves: Node | None, where: str) -> Any:
        """Return a shape after the steps of a `move` list; problems with the steps of a BAD shape are reported too."""
        if moves is None:
            return shape
        where = f"{where}: move"
        if not isinstance(moves, SequenceNode):
            return self.reader.report_mismatch(moves, where, "a list of steps such as [{translate: [0, 0, 1]}]")
        if len(moves.items) > MAX_STEPS:
            return self.reader.report(moves, where, f"must have at most {MAX_STEPS} steps, got {len(moves.items)}")
        if (motion := self.motions.get(id(moves))) is None:
            motion = self.motions[id(moves)] = self.motion(moves, where)
        if shape is BAD or isinstance(motion, BadValue):
            return BAD
        # Composing motions takes time for each step, and aliases can repeat long lists
        self.charge(moves, where, steps=len(shape.motion.steps) + len(motion.steps))
        return self.reader.build(moves, where, lambda: apply_motion(shape, motion))

    def motion(self, moves: SequenceNode, where: str) -> Motion | BadValue:
        """Return the motion of all steps of a list; the caller stores it for aliases of the list."""
        motion, good = IDENTITY_MOTION, True
        for i, step in enumerate(moves.items):
            moved = self._step(motion, step, f"{where}[{i}]")
            motion, good = (motion, False) if isinstance(moved, BadValue) else (moved, good)
        return motion if good else BAD

    def _step(self, motion: Motion, step: Node, where: str) -> Any:
        """Return the motion followed by one more step, or BAD after a report."""
        entry = self.reader.only_entry(step)
        verbs = ("translate", "rotate", "scale", "transform")
        if entry is None:
            return self.reader.report_mismatch(
                step, where, f"one of {', '.join(verbs)}, such as {{translate: [0, 0, 1]}}"
            )
        verb, key, value = entry
        if verb not in verbs:
            return self.reader.unknown(key, where, "step", verb, verbs)
        where = f"{where}: {verb}"
        if verb == "rotate":
            return self._rotate(motion, value, where)
        argument = MOVE_TYPES[verb].read(value, self.reader, where)
        return BAD if argument is BAD else self.reader.build(value, where, lambda: getattr(motion, verb)(argument))

    def _rotate(self, motion: Motion, value: Node, where: str) -> Any:
        """Return the motion followed by a rotation, or BAD after a report."""
        entries = self.reader.entries(value, where, ROTATION_TYPES, ("axis", "degrees"))
        present = value.entries if isinstance(value, MappingNode) else {}
        arguments = {
            name: kind.read(present[name], self.reader, f"{where}: {name}")
            for name, kind in ROTATION_TYPES.items()
            if name in present
        }
        if isinstance(entries, BadValue) or BAD in arguments.values():
            return BAD
        point, axis, degrees = arguments.get("about"), arguments["axis"], arguments["degrees"]
        return self.reader.build(
            value,
            where,
            lambda: apply_about("rotate", motion, point, lambda moved_motion: moved_motion.rotate(axis, degrees)),
        )


def build_boolean(cls: Any, operands: Any) -> Any:
    """Return a Boolean of shapes; with one sheet, the result of `sheet - solid` or `sheet & solid`."""
    sheets = [part for part in operands if isinstance(part, Sheet)] if isinstance(operands, tuple) else []
    if len(sheets) == 1 and cls is Difference and operands[0] is sheets[0]:
        return functools.reduce(operator.sub, operands)
    if len(sheets) == 1 and cls is Intersection:
        return functools.reduce(operator.and_, (part for part in operands if part is not sheets[0]), sheets[0])
    return cls(operands)


def apply_motion(shape: Shape, motion: Motion) -> Shape:
    """Return the shape after all steps of a motion, with one check of the whole motion."""
    return shape._moved(shape.motion.then(motion))


def operand_field(cls: type[Shape]) -> ValueType | None:
    """Return the type of a class's only field if it holds shapes, else None.

    Booleans take their operands without the name of the field.
    """
    kinds = [field.kind for field in argument_fields(cls).values()]
    inner = kinds[0].item if len(kinds) == 1 and isinstance(kinds[0], ListType) else kinds[0] if kinds else None
    return kinds[0] if len(kinds) == 1 and isinstance(inner, ShapeType) else None
