"""Many bodies in one entry of a scene file: a template, columns of its numbers, and their motions, all at once.

Its user is who gives thousands of bodies as columns, or as bodies that are written alike (`body_patterns.py`). 10,000
rows of five leaves take a ninth of the time of rows one by one, and 10,000 boxes that are turned and moved a 25th.

Columns only mark rows in doubt. The caller builds these motions one by one, which decides or raises the error.
"""

from __future__ import annotations

import re
from collections.abc import Callable, Iterable, Iterator, Mapping, Sequence
from functools import partial
from itertools import repeat
from typing import Any, NamedTuple, TypeAlias

import numpy as np
import numpy.typing as npt

from ..._util.arrays import FloatArray, Matrix4, Vector
from ..._util.records import construct_many, pickle_state
from ..._util.validation import SuppressedWarning, is_outside_domain, looks_like_radians, raise_warnings, real_array
from ...geometry.bulk import Bulk
from ...geometry.registry import REGISTRY
from ...geometry.shape import Shape
from ...geometry.transform import (
    AXES,
    CLEAR_DETERMINANT,
    IDENTITY_REACH,
    SAFE_REACH,
    Motion,
    Reach,
    Rotate,
    Scale,
    Step,
    Transform,
    Translate,
)
from .fields import argument_fields
from .nodes import (
    BAD,
    BadValue,
    FixedListType,
    ListType,
    MappingNode,
    Node,
    NodeReader,
    NumberType,
    OptionalType,
    ScalarNode,
    SequenceNode,
    TextType,
    UnionType,
    ValueType,
    parse_float,
    shorten,
)
from .shape_reader import (
    AXIS_TYPE,
    MAX_PARTS,
    STEP_COMPOSED,
    PartBudget,
    ShapeReader,
    apply_motion,
    build_boolean,
    operand_field,
    read_bulk_arrays,
)
from .writer import format_number

Bools = npt.NDArray[np.bool_]


class ReachColumn(NamedTuple):
    """The bounds of `Reach` for many motions: arrays (n,), or one number for all."""

    stretch: Any
    back: Any
    shift: Any


class StepColumn(NamedTuple):
    """One step of each of many motions."""

    steps: Iterable[Step]
    reach: Reach | ReachColumn
    good: Bools | bool
    """Which rows are valid beyond doubt."""


def repeat_step(step: Step) -> StepColumn:
    """Return the column of one step, checked before, that all motions have."""
    return StepColumn(repeat(step), step.reach(), True)


def translate_column(offsets: Sequence[Vector]) -> StepColumn:
    """Return a column of translations, by tuples of three floats."""
    rows = np.array(offsets)
    return StepColumn(_make_steps(Translate, "offset", offsets), ReachColumn(1.0, 1.0, _sizes(rows)), _in_domain(rows))


def scale_column(factors: Sequence[Vector]) -> StepColumn:
    """Return a column of scalings, by tuples of three floats."""
    sizes = np.abs(np.array(factors))
    least = sizes.min(axis=1)
    good = _in_domain(sizes) & (least > 0)
    reach = ReachColumn(sizes.max(axis=1), 1 / np.where(good, least, 1.0), 0.0)
    return StepColumn(_make_steps(Scale, "factors", factors), reach, good)


def rotate_column(axes: Sequence[Vector], degrees: Sequence[float]) -> StepColumn:
    """Return a column of turns about axes, tuples of three floats. Angles that may be in radians are in doubt."""
    rows, angles = np.array(axes), np.array(degrees)
    good = _in_domain(rows) & rows.any(axis=1) & ~is_outside_domain(angles)
    # Such an angle makes the step alone warn
    for place in np.flatnonzero(np.abs(angles) < _FEW_DEGREES).tolist():
        good[place] &= not looks_like_radians(degrees[place])
    steps = construct_many(Rotate, len(degrees), axis=axes, degrees=degrees)
    return StepColumn(steps, ReachColumn(1.0, 1.0, 0.0), good)


def transform_column(matrices: Sequence[Matrix4]) -> StepColumn:
    """Return a column of affine maps, by tuples of four rows of four floats."""
    rows = np.array(matrices)
    good = _in_domain(rows.reshape(len(rows), 16)) & (rows[:, 3] == (0.0, 0.0, 0.0, 1.0)).all(axis=1)
    linear = np.where(good[:, None, None], rows[:, :3, :3], 1.0)
    across = np.cross(linear[:, 1], linear[:, 2])
    volume = np.abs((linear[:, 0] * across).sum(axis=1))
    x, y, z = (_sizes(linear[:, k]) for k in range(3))
    good &= volume > CLEAR_DETERMINANT * (x * y * z)
    back = 1.01 * (x * y + y * z + z * x) / np.where(good, volume, 1.0)
    shift = _sizes(np.where(good[:, None], rows[:, :3, 3], 0.0))
    return StepColumn(_make_steps(Transform, "matrix", matrices), ReachColumn(x + y + z, back, shift), good)


_FEW_DEGREES = 13.0
"""Angles beyond this are surely in degrees, see `looks_like_radians`."""


def compose_motions(count: int, chain: Sequence[StepColumn], before: Reach) -> tuple[list[Motion], Bools]:
    """Return (the motions of many shapes, which of them are valid beyond doubt), with one step of each column.

    `before` bounds the motions that the shapes have already.
    """
    reach: Any = before
    good = np.ones(count, bool)
    with np.errstate(over="ignore", invalid="ignore"):
        for each in chain:
            reach = Reach.then(reach, each.reach)  # type: ignore[arg-type]
            good &= each.good
        for bound in reach:
            good &= bound <= SAFE_REACH
    rows = zip(*(each.steps for each in chain), strict=False) if chain else repeat((), count)
    return construct_many(Motion, count, steps=rows), good


def _make_steps(kind: type[Any], field: str, values: Sequence[Any]) -> list[Any]:
    return construct_many(kind, len(values), **{field: values})


def _in_domain(rows: FloatArray) -> Bools:
    return ~is_outside_domain(rows).any(axis=1)


def _sizes(rows: FloatArray) -> FloatArray:
    """Return upper bounds of the lengths of rows, up to rounding."""
    return np.abs(rows).sum(axis=1)


# Many bodies in one entry of a scene file: a template and the columns of its numbers.
#
# A template is a body with names such as `$radius` in place of numbers, or of lists of numbers. Each row of the columns
# makes a body of its own:
#
#     - shape: {Difference: [{Sphere: {radius: 2}}, {Cylinder: {start: [0, 0, -3], end: [0, 0, 3], radius: $bore}}]}
#       move: [{translate: $place}]
#       columns: {bore: [0.5, 0.7], place: [[0, 0, 0], [9, 0, 0]]}
#
# `read_row` puts the numbers of one row into the tree and reads that as a body that is written out. It reports all
# problems, and takes some 60 µs a body. `ShapeColumns` builds the shapes of all rows together, ten times faster for a
# moved shape. It leaves out rows in doubt, which `read_row` then reads.

COLUMN_TYPE = ListType(UnionType((NumberType(), ListType(NumberType()))))
"""A column in the scene file: a number for each body, or a list of numbers."""
_NAME = re.compile(r"\$([A-Za-z_]\w*)")
_VALUES_AROUND = 10
"""Values that a body of its own has beside its numbers, by which `PartBudget` counts a row."""
_MOST_VALUES = 8_000_000
"""Most values of the template times rows."""
_MOST_VALUES_OF_ROW = 100_000
"""A row is nodes of the scene file while it is read, some 200 bytes each."""


class Template:
    """The shape and the motion of an entry, with names in place of some numbers."""

    def __init__(self, entry: MappingNode, names: Mapping[int, str] | None = None) -> None:
        self.entry, self.known_names = entry, names
        self.shape, self.move = entry.entries["shape"], entry.entries.get("move")
        self.names: dict[int, str] = {}  # by id of the node
        self.places: dict[str, ScalarNode] = {}
        """The first place of each name."""
        self.varied: dict[int, bool] = {}  # by id of the node
        self.size = self.shape.size + (0 if self.move is None else self.move.size)
        self.varies(self.shape)
        if self.move is not None:
            self.varies(self.move)

    def varies(self, node: Node) -> bool:
        """Return True if a name stands at a node or below it."""
        earlier = self.varied.get(id(node))
        if earlier is None:
            if isinstance(node, ScalarNode):
                match = _NAME.fullmatch(node.text)  # in JSON it is a text in quotes
                name = self.known_names.get(id(node)) if self.known_names is not None else match and match[1]
                earlier = name is not None
                if name is not None:
                    self.names[id(node)] = name
                    self.places.setdefault(name, node)
            else:
                below = [self.varies(part) for part in _parts(node)]  # all of them, to find each name
                earlier = True in below
            self.varied[id(node)] = earlier
        return earlier

    def fill(self, node: Node, row: Mapping[str, Any], filled: dict[int, Node]) -> Node:
        """Return a node with the numbers of a row; what has no names is shared, and so are aliases, by `filled`."""
        if not self.varies(node):
            return node
        if id(node) not in filled:
            if isinstance(node, ScalarNode):
                filled[id(node)] = _number_node(row[self.names[id(node)]], node)
            elif isinstance(node, SequenceNode):
                items = [self.fill(item, row, filled) for item in node.items]
                filled[id(node)] = SequenceNode(node.line, node.column, items, node.size)
            else:
                entries = {name: self.fill(value, row, filled) for name, value in node.entries.items()}
                filled[id(node)] = MappingNode(node.line, node.column, entries, node.heads, node.size)
        return filled[id(node)]


def _parts(node: SequenceNode | MappingNode) -> Iterable[Node]:
    return node.items if isinstance(node, SequenceNode) else node.entries.values()


def _number_node(value: Any, place: ScalarNode) -> Node:
    """Return the node of a number, or of a list of numbers, at the place of a name."""
    if isinstance(value, tuple):
        return SequenceNode(place.line, place.column, [_number_node(each, place) for each in value])
    return ScalarNode(place.line, place.column, ".nan" if value != value else format_number(value), True)


# The columns.


def read_columns(node: Node, template: Template, reader: NodeReader, where: str) -> dict[str, FloatArray] | BadValue:
    """Return the array of each name of a template, all of them equally long; BAD after a report."""
    if not template.places:
        return reader.report(node, where, "are for names such as $radius in place of numbers; the body has none")
    if not isinstance(node, MappingNode):
        return reader.report_mismatch(node, where, "a mapping from names to lists of numbers, or {file: NAME.npz}")
    file = node.entries.get("file")
    if isinstance(file, ScalarNode) and len(node.entries) == 1:
        name: str | BadValue = TextType().read(file, reader, f"{where}: file")
        if isinstance(name, BadValue):
            return name
        return reader.build(node, f"{where}: file", partial(read_arrays, name, template, reader))
    for name, place in template.places.items():
        if name not in node.entries:
            reader.unknown(place, where, "column", name, node.entries)
    for key in node.heads:
        if key.text not in template.places:
            reader.report(key, where, f"column {shorten(key.text)!r} is not used: no number is ${shorten(key.text)}")
    read = {name: COLUMN_TYPE.read(value, reader, f"{where}: {name}") for name, value in node.entries.items()}
    if BAD in read.values() or read.keys() != template.places.keys():
        return BAD
    return reader.build(node, where, lambda: _check_columns("columns", read))


def read_arrays(name: str, template: Template, reader: NodeReader) -> dict[str, FloatArray]:
    """Return the columns of a .npz file beside the scene. Raise ValueError for a file that has not all of them."""
    if not name.lower().endswith(".npz"):
        raise ValueError(f"must be the name of a .npz file, got {shorten(name)!r}")
    return _check_columns(shorten(name), read_bulk_arrays(name, reader.folder, tuple(template.places)))


def _check_columns(owner: str, read: Mapping[str, Any]) -> dict[str, FloatArray]:
    """Return arrays of float64. Raise ValueError for one that holds no row for each body."""
    columns = {name: real_array(owner, name, values) for name, values in read.items()}
    for name, values in columns.items():
        if not 1 <= values.ndim <= 3:
            raise ValueError(f"{owner}: {name} must have shape (N,), (N, 3) or (N, 4, 4), got {values.shape}")
    if len({len(values) for values in columns.values()}) > 1:
        lengths = ", ".join(f"{name} of {len(values):,}" for name, values in columns.items())
        raise ValueError(f"{owner}: columns must be of equally many bodies, got {lengths}")
    return columns


# From rows to shapes.


def read_shapes(
    template: Template, columns: Mapping[str, FloatArray], shapes: ShapeReader, where: str
) -> list[Any] | BadValue:
    """Return the shape of each row, or BAD after reports.

    The first row shows how many parts and steps a row has. All rows are counted before the others are made.
    """
    count = len(next(iter(columns.values())))
    numbers = sum(values[:1].size for values in columns.values())
    shapes.allowance.extend(count * (numbers + _VALUES_AROUND))
    # Each place of a name has numbers of its own, however wide the column is
    size = template.size + sum(columns[name][:1].size for name in template.names.values())
    if count * size > _MOST_VALUES or size > _MOST_VALUES_OF_ROW:
        most = _MOST_VALUES if size <= _MOST_VALUES_OF_ROW else _MOST_VALUES_OF_ROW
        message = f"{count:,} rows of {size:,} values are more than {most:,}"
        return shapes.reader.report(template.entry, where, message)
    if not count:
        return []
    before = shapes.allowance.steps
    first = read_row(template, columns, 0, shapes, where)
    if isinstance(first, BadValue):
        return BAD
    if isinstance(first, Bulk):
        message = f"must be the shape of one body, got {type(first).__name__}, which has columns of its own"
        return shapes.reader.report(template.shape, where, message)
    steps = shapes.allowance.steps - before
    shapes.charge(template.entry, where, count * (1 + shapes.size(first)), (count - 1) * steps // STEP_COMPOSED)
    found = [first, *build_batch(template, columns, shapes, where)]
    charged = shapes.allowance.steps
    for k, shape in enumerate(found):
        if shape is None:
            shapes.allowance.steps = charged - steps  # this row is counted already
            found[k] = read_row(template, columns, k, shapes, where)
    shapes.allowance.steps = charged
    return BAD if BAD in found else found


def read_row(template: Template, columns: Mapping[str, FloatArray], k: int, shapes: ShapeReader, where: str) -> Any:
    """Return the shape of a row, or BAD after reports."""
    row = {name: _as_tuples(values[k].tolist()) for name, values in columns.items()}
    nodes: dict[int, Node] = {}
    where = f"{where}, row {k}"
    with shapes.pause_cache():
        shape = shapes.read(template.fill(template.shape, row, nodes), where)
        return shapes.moved(shape, template.move and template.fill(template.move, row, nodes), where)


def _as_tuples(value: Any) -> Any:
    return tuple(map(_as_tuples, value)) if isinstance(value, list) else value


_Shapes: TypeAlias = Shape | list[Shape | None]
"""One shape for all rows, or the shape of each row, None for one in doubt."""


class _UnusualNode(Exception):
    """Raised for a node that `ShapeColumns` leaves to `read_row`."""


def build_batch(
    template: Template, columns: Mapping[str, FloatArray], shapes: ShapeReader, where: str
) -> list[Shape | None]:
    """Return the shape of each row but the first, None for one in doubt; also all rows if one of them warns."""
    count = len(next(iter(columns.values()))) - 1
    unbuilt: list[Shape | None] = [None] * count
    if not count:
        return unbuilt
    budget, shapes.allowance = shapes.allowance, PartBudget(MAX_PARTS)  # the parts are counted already
    try:
        with raise_warnings():
            built = ShapeColumns(template, {name: values[1:] for name, values in columns.items()}, shapes, where)
            found = built.shapes()
    except (_UnusualNode, SuppressedWarning, ValueError, TypeError, ArithmeticError):
        return unbuilt
    finally:
        shapes.allowance = budget
    finite = np.all([np.isfinite(values[1:]).reshape(count, -1).all(axis=1) for values in columns.values()], axis=0)
    return [shape if good else None for shape, good in zip(found, finite.tolist(), strict=True)]


class ShapeColumns:
    """Builds the shapes of all rows of a template whose first row was read without problems.

    Parts without names are read once, and numbers are handled in columns. `shapes` gives None for each row whose
    numbers are not good beyond doubt.
    """

    def __init__(self, template: Template, columns: Mapping[str, FloatArray], reader: ShapeReader, where: str) -> None:
        self.template, self.reader, self.where = template, reader, where
        self.count = len(next(iter(columns.values())))
        self.columns = {name: _tuple_rows(values) for name, values in columns.items()}

    def shapes(self) -> list[Shape | None]:
        """Return the shapes of all rows."""
        found = self._shapes(self.template.shape)
        if self.template.move is not None:
            found = self._moved(found, self.template.move)
        return [found] * self.count if isinstance(found, Shape) else found

    def _shapes(self, node: Node) -> _Shapes:
        """Return the shapes at a node, as `ShapeReader.read` reads one."""
        if not self.template.varies(node):
            return self.reader.read(node, self.where)
        if not isinstance(node, MappingNode):
            raise _UnusualNode
        key = next(key for key in node.heads if key.text != "move")
        value = node.entries[key.text]
        shapes: _Shapes
        if not self.template.varies(value):
            shapes = self.reader.shape_of_key(key, value, self.where)
        else:
            shapes = self._shapes(value) if key.text == "shape" else self._built(REGISTRY[key.text], value)
        return self._moved(shapes, node.entries["move"]) if "move" in node.entries else shapes

    def _built(self, cls: type[Shape], node: Node) -> _Shapes:
        """Return primitives by their fields, or combinations of their operands."""
        varies = self.template.varies
        field = operand_field(cls)
        if field is not None and not isinstance(field, ListType):
            return _shape_rows(lambda operand: build_boolean(cls, operand), zip(self._operands(node), strict=True))
        if field is not None:
            assert isinstance(node, SequenceNode)
            rows = zip(*map(self._operands, node.items), strict=True)
            return _shape_rows(lambda *operands: build_boolean(cls, operands), rows)
        assert isinstance(node, MappingNode)
        fields, entries = argument_fields(cls), node.entries
        names = [name for name in entries if varies(entries[name])]
        if not all(_has_numbers(fields[name].kind) for name in names):
            raise _UnusualNode
        shared = {
            name: fields[name].kind.read(value, self.reader.reader, self.where)
            for name, value in entries.items()
            if name not in names
        }
        rows = zip(*(self._values(entries[name]) for name in names), strict=True)
        return _shape_rows(lambda *row: cls(**shared, **dict(zip(names, row, strict=True))), rows)

    def _operands(self, node: Node) -> list[Shape | None]:
        """Return the operand at a node for each row."""
        shapes = self._shapes(node)
        return [shapes] * self.count if isinstance(shapes, Shape) else shapes

    def _values(self, node: Node) -> list[Any]:
        """Return the value at a node for each row: a number, or a tuple of values."""
        if isinstance(node, SequenceNode):
            return list(zip(*map(self._values, node.items), strict=True)) or [()] * self.count
        name = self.template.names.get(id(node))
        return [parse_float(node)] * self.count if name is None else self.columns[name]

    def _moved(self, shapes: _Shapes, node: Node) -> _Shapes:
        """Return the shapes after all steps of a `move` list."""
        assert isinstance(node, SequenceNode)
        if not self.template.varies(node):
            motion = self._motion(node)
            if isinstance(shapes, Shape):
                return apply_motion(shapes, motion)
            return _shape_rows(lambda shape: apply_motion(shape, motion), zip(shapes, strict=True))
        # Motions are composed and checked in columns; a row whose motion is not good is left out.
        before = shapes.motion.reach if isinstance(shapes, Shape) else IDENTITY_REACH
        then, good = compose_motions(
            self.count, [column for step in node.items for column in self._steps(step)], before
        )
        moved: list[Shape | None]
        if isinstance(shapes, Shape):
            first = shapes.motion
            moved = self._copies(shapes, map(first.then, then) if first.steps else then)
        else:
            moved = _shape_rows(_shape_under, zip(shapes, then, strict=True))
        return [shape if fine else None for shape, fine in zip(moved, good.tolist(), strict=True)]

    def _copies(self, shape: Shape, motions: Iterable[Motion]) -> list[Shape | None]:
        """Return a copy of a shape under each of some motions, which are checked already."""
        fields: dict[str, Iterable[Any]] = {name: repeat(value) for name, value in pickle_state(shape).items()}
        return construct_many(type(shape), self.count, **{**fields, "motion": motions})

    def _steps(self, node: Node) -> Iterator[StepColumn]:
        """Yield the columns of a step, as `ShapeReader` reads one."""
        if not self.template.varies(node):
            holder = SequenceNode(node.line, node.column, [node])
            yield from map(repeat_step, self._motion(holder).steps)
            return
        assert isinstance(node, MappingNode)
        ((verb, value),) = node.entries.items()
        if verb == "rotate":
            assert isinstance(value, MappingNode)
            if "about" in value.entries:
                raise _UnusualNode
            yield rotate_column(self._axes(value.entries["axis"]), self._values(value.entries["degrees"]))
        elif verb == "scale":
            factors = self._values(value)
            yield scale_column([each if isinstance(each, tuple) else (each, each, each) for each in factors])
        else:
            yield (translate_column if verb == "translate" else transform_column)(self._values(value))

    def _motion(self, node: SequenceNode) -> Motion:
        """Return the motion of steps without names."""
        motion = self.reader.motion(node, self.where)
        assert not isinstance(motion, BadValue)  # the first row was read
        return motion

    def _axes(self, node: Node) -> list[Any]:
        """Return the axis of a rotation for each row."""
        if self.template.varies(node):
            return self._values(node)
        axis = AXIS_TYPE.read(node, self.reader.reader, self.where)
        return [AXES[axis] if isinstance(axis, str) else axis] * self.count


def _tuple_rows(values: FloatArray) -> list[Any]:
    """Return the rows of a column as numbers or tuples."""
    rows: list[Any] = values.tolist()
    return rows if values.ndim == 1 else list(map(tuple if values.ndim == 2 else _as_tuples, rows))


def _has_numbers(kind: ValueType) -> bool:
    """Return True if a type holds numbers, or lists of them, alone."""
    if type(kind) in (ListType, FixedListType, OptionalType):
        return _has_numbers(kind.item)  # type: ignore[attr-defined]
    return type(kind) is NumberType


def _shape_under(shape: Shape, motion: Motion) -> Shape:
    """Return a shape after a motion, which is checked already if it is the only one."""
    return apply_motion(shape, motion) if shape.motion.steps else shape._with_motion(motion)


def _shape_rows(make: Callable[..., Shape], rows: Iterable[tuple[Any, ...]]) -> list[Shape | None]:
    """Return make(*row) for each row of operands or fields; None for a row with None in it, or one that raises."""
    shapes: list[Shape | None] = []
    for row in rows:
        try:
            shapes.append(None if None in row else make(*row))
        except (ValueError, TypeError, ArithmeticError):
            shapes.append(None)
    return shapes
