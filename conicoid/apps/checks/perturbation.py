"""How a shape's surfaces move as its numbers change: each number in its last place, surfaces as exact 4 × 4 forms.

The numbers are those of the shape's fields and of its motion. Forms are exact up to the local coordinates of the tested
part, and rounded to float64 there. docs/dev/conditioning.md derives the method.
"""

from __future__ import annotations

import dataclasses
import itertools
import math
import re
from collections.abc import Iterator, Sequence
from functools import cached_property
from typing import Any, Generic, TypeVar

import numpy as np

from ..._util.arrays import FloatArray
from ..._util.records import dataclass
from ...geometry.bounds.support import plane_through
from ...geometry.cell import Cell, PolygonSheet, cells_of_tree
from ...geometry.general_quadric import Quadric
from ...geometry.polyhedron import Extrusion, FlatSolid, Polyhedron
from ...geometry.primitives import Box, Cylinder, HalfSpace
from ...geometry.shape import PrimitiveSheet, PrimitiveSolid
from ...geometry.surface import UPRIGHT, PlaneSurface, QuadricSurface, Surface
from ...geometry.transform import IDENTITY_MOTION, Motion
from ...numerics import bigfloat as ex
from ..derivatives.parameters import Make, map_numbers, numbers_of, replace_checked, replace_unchecked

# The numbers of a shape, and the shape with one of them changed.

HALF_ULP = 2.0**-53
"""The relative change whose effect is wanted: the largest that rounding a number to float64 makes."""

Changed = TypeVar("Changed")


@dataclass(frozen=True)
class NumberChange(Generic[Changed]):
    """A shape or a motion with one number moved to the next float64.

    number   name of the number as in `co.parameters`: center[0], coefficients.xy, [1].degrees of a motion
    share    the wanted change (a relative 2^-53) as a part of the one applied, in [1/2, 1]
    result   the changed shape or motion
    """

    number: str
    share: float
    result: Changed


def number_changes(thing: Changed, make: Make = replace_checked) -> Iterator[NumberChange[Changed]]:
    """Yield a change of each number of a shape or a motion other than 0.

    A number moves away from 0, or towards 0 if `make` refuses that; it is left out if both are refused.
    """
    for place, (name, value) in enumerate(zip(*numbers_of(thing), strict=True)):
        for towards in (math.copysign(math.inf, value), 0.0):
            changed = math.nextafter(value, towards)
            # A change to 0 or infinity is no rounding of the number, and 0 has none
            if not value or not changed or math.isinf(changed):
                continue
            try:
                made = _with_number(thing, place, changed, make)
            except ValueError:
                continue
            yield NumberChange(name, HALF_ULP * abs(value / (changed - value)), made)
            break


def _with_number(thing: Changed, place: int, number: float, make: Make) -> Changed:
    """Return a shape or a motion with another number at a place in the order of `numbers_of`."""
    places = itertools.count()

    def take(_: str, old: float) -> float:
        return number if next(places) == place else old

    result: Changed = map_numbers(thing, take, make, None)
    return result


def column_change(table_rows: Any, change: NumberChange[Any], make: Make) -> NumberChange[Any] | None:
    """Return a change of all numbers of a table's column that are equal to one; None for any but the first of them.

    None also for a change that makes one corner of two, as then rows of both tables are no pairs.
    """
    match = _IN_TABLE.fullmatch(change.number)
    if match is None:
        return None
    field, row, column = match[1], int(match[2]), int(match[3])
    table, changed_table = getattr(table_rows, field), getattr(change.result, field)
    if len(changed_table) != len(table):
        return None
    old, new = table[row][column], changed_table[row][column]
    rows = [k for k, each in enumerate(table) if each[column] == old]
    # Equal numbers change once, by the first of them
    if rows[0] != row:
        return None
    changed = tuple((*each[:column], new, *each[column + 1 :]) if k in rows else each for k, each in enumerate(table))
    try:
        return dataclasses.replace(change, result=make(table_rows, {field: changed}))
    except ValueError:
        return None


_IN_TABLE = re.compile(r"(\w+)\[(\d+)\]\[(\d+)\]")
"""The name of a number in a table: field[row][column]."""


# Surfaces of a shape as exact symmetric 4 × 4 forms, in any affine coordinates.


@dataclass(frozen=True)
class ExactForm:
    """xᵀ second x + 2 first·x + zeroth; `second` is None for a plane."""

    second: ex.Rows | None
    first: ex.Row
    zeroth: ex.BigFloat

    @property
    def entries(self) -> tuple[ex.BigFloat, ...]:
        """All 16 entries of the symmetric 4 × 4 matrix, in an order of their own."""
        second = self.second or ((ex.ZERO,) * 3,) * 3
        return (*second[0], *second[1], *second[2], *self.first, *self.first, self.zeroth)

    def minus(self, factor: ex.BigFloat, other: ExactForm) -> ExactForm:
        """Return self - factor other."""

        def row(a: Sequence[ex.BigFloat], b: Sequence[ex.BigFloat]) -> ex.Row:
            return a[0] - factor * b[0], a[1] - factor * b[1], a[2] - factor * b[2]

        second = self.second
        if second is not None and other.second is not None:
            second = row(second[0], other.second[0]), row(second[1], other.second[1]), row(second[2], other.second[2])
        return ExactForm(second, row(self.first, other.first), self.zeroth - factor * other.zeroth)

    def seen_from(self, origin: ex.Row, columns: ex.Rows) -> ExactForm:
        """Return the form in coordinates z, x = origin + columns z."""
        rows = ex.transpose(columns)
        if self.second is None:
            return ExactForm(None, _apply_rows(rows, self.first), 2 * dot(self.first, origin) + self.zeroth)
        # Terms of f(origin + columns z) by powers of z
        half = _apply_rows(self.second, origin)
        slope = half[0] + self.first[0], half[1] + self.first[1], half[2] + self.first[2]
        zeroth = dot(origin, half) + 2 * dot(self.first, origin) + self.zeroth
        x, y, z = (_apply_rows(self.second, column) for column in rows)
        second = _apply_rows((x, y, z), rows[0]), _apply_rows((x, y, z), rows[1]), _apply_rows((x, y, z), rows[2])
        return ExactForm(second, _apply_rows(rows, slope), zeroth)

    def rounded(self) -> FloatArray:
        """Return the symmetric matrix (4, 4), rounded to float64."""
        result = np.zeros((4, 4))
        if self.second is not None:
            result[:3, :3] = [[float(c) for c in row] for row in self.second]
        result[:3, 3] = result[3, :3] = [float(c) for c in self.first]
        result[3, 3] = float(self.zeroth)
        return result


def dot(a: Sequence[ex.BigFloat], b: Sequence[ex.BigFloat]) -> ex.BigFloat:
    """Return a·b to 3000 bits.

    Unlike `bigfloat.dot`, terms that cancel leave their rounding, as results are rounded to float64 here.
    """
    return ex.total(x * y for x, y in zip(a, b, strict=True))


def _apply_rows(rows: ex.Rows, point: ex.Row) -> ex.Row:
    """Return the product of a matrix and a vector."""
    return dot(rows[0], point), dot(rows[1], point), dot(rows[2], point)


@dataclass(frozen=True)
class CellSide:
    """A surface in the shape's own frame; `inside` is that of a `Face`, 0 for a sheet's own surface."""

    number: int
    inside: int
    surface: Surface


def cells_of(leaf: Any) -> list[list[CellSide]]:
    """Return the faces of every cell of a primitive in its own frame; of a sheet, its surface and a clipping cell."""
    if isinstance(leaf, Polyhedron):
        planes = [PlaneSurface(n, d) for n, d in zip(leaf.normals, leaf.offsets, strict=True)]
        return [[CellSide(i, 1, plane) for i, plane in enumerate(planes)]]
    if isinstance(leaf, PrimitiveSolid):
        return [_sides(cell) for cell in cells_of_tree(leaf.tree())]
    assert isinstance(leaf, PrimitiveSheet)
    sheet = leaf.sheet(IDENTITY_MOTION)
    # Polygons have a formula of their own in `conditioning.py`
    assert not isinstance(sheet, PolygonSheet)
    clips = [_sides(cell) for cell in cells_of_tree(sheet.clip)] if sheet.clip is not None else [[]]
    return [[CellSide(-1, 0, sheet.surface), *clip] for clip in clips]


def kinds_of(cells: Sequence[Sequence[CellSide]]) -> list[list[tuple[Any, ...]]]:
    """Return the kinds of the faces of cells: number, side, and class of surface."""
    return [[(side.number, side.inside, type(side.surface)) for side in cell] for cell in cells]


def forms_of(leaf: Any, cells: Sequence[Sequence[CellSide]]) -> list[list[ExactForm]]:
    """Return the forms of the faces of each cell, moved by the shape's placement.

    A general quadric gives its form from its coefficients, without its principal axes.
    """
    if isinstance(leaf, Quadric):
        q = [[ex.exact(c) for c in row] for row in leaf.symmetric]
        second = (ex.exact_row(q[0][:3]), ex.exact_row(q[1][:3]), ex.exact_row(q[2][:3]))
        # Without terms of the second degree it is a plane
        curved = any(c for row in second for c in row)
        return [[ExactForm(second if curved else None, (q[0][3], q[1][3], q[2][3]), q[3][3])]]
    placement = leaf.placement
    return [[form_of(side.surface.moved(placement)) for side in cell] for cell in cells]


def form_of(surface: Surface) -> ExactForm:
    """Return the exact polynomial of a surface about the origin."""
    if isinstance(surface, PlaneSurface):
        x, y, z = (c / 2 for c in ex.exact_row(surface.normal))
        return ExactForm(None, (x, y, z), -ex.exact(surface.offset))
    assert isinstance(surface, QuadricSurface)
    xx, yy, zz, xy, xz, yz, x, y, z, constant = surface.coefficients()
    return ExactForm(((xx, xy, xz), (xy, yy, yz), (xz, yz, zz)), (x, y, z), constant)


def _sides(cell: Cell) -> list[CellSide]:
    """Return the faces of a cell."""
    return [CellSide(face.number, face.inside, face.surface) for face in cell.faces]


# A cell of a shape in coordinates of its own size, and how its surfaces move as the shape's numbers change.
#
# The coordinates z have their origin in the middle of the tested part and axes along the quadric's principal ones. The
# part reaches from -1/2 to 1/2 along each; so z measures in units of the part itself, whatever its size and place.
# Everything is exact up to here and rounded to float64 now.

Extent = tuple[FloatArray, FloatArray]
"""(low, high) (3,) along the axes of a frame."""


@dataclass(frozen=True)
class LocalFrame:
    """The map x = origin + columns z from local coordinates to those of the shape before its motion."""

    origin: ex.Row
    columns: ex.Rows

    def scaled(self, extent: Extent) -> LocalFrame:
        """Return the frame with the same axes in which `extent` (low, high) goes from -1/2 to 1/2."""
        low, high = extent
        middle = ex.exact_row((ex.exact(a) + ex.exact(b)) / 2 for a, b in zip(low.tolist(), high.tolist(), strict=True))
        sizes = ex.exact_row(high - low)
        x, y, z = (ex.dot(row, middle, start) for row, start in zip(self.columns, self.origin, strict=True))
        a, b, c = ((row[0] * sizes[0], row[1] * sizes[1], row[2] * sizes[2]) for row in self.columns)
        return LocalFrame((x, y, z), (a, b, c))


@dataclass(frozen=True, eq=False)
class LocalCell:
    """S surfaces of a cell as float64 forms in z.

    forms     (S, 4, 4), the largest entry of each 1
    flat      (S,) bool: planes
    sides     (S,): +1 where f <= 0 is inside, -1 where f >= 0 is, 0 for the surface of a sheet
    moves     (n, S, 4, 4): the change of the forms, up to a multiple of each form, when each of n numbers changes by
              a relative 2^-53
    numbers   names of the n numbers
    cut       whether the tested part is smaller than the cell
    shifts    (S,) bounds of how far the forms change within the tested part, for numbers that `moves` leaves out
    """

    forms: FloatArray
    flat: Any
    sides: Any
    moves: FloatArray
    numbers: tuple[str, ...]
    cut: bool
    shifts: FloatArray


@dataclass(frozen=True, eq=False)
class LocalShape:
    """The cells of a shape in the coordinates of one frame."""

    frame: LocalFrame
    cells: tuple[LocalCell, ...]


def own_frame(leaf: Any) -> tuple[LocalFrame, Extent, FloatArray]:
    """Return the frame of the first quadric about its anchor, the shape's extent along its axes, and its size (3,).

    The extent is infinite where the shape is, and low > high if it is empty. The size is of the order of the quadric's
    semi-axes, and 0 for planes.
    """
    sides = [side.surface for cell in cells_of(leaf) for side in cell]
    curved = next((surface for surface in sides if isinstance(surface, QuadricSurface)), None)
    axis_source = curved or sides[0]
    anchor, columns = ex.exact_row(axis_source.anchor), ex.IDENTITY
    rows = ex.IDENTITY
    # The rows of an upright quadric are those of the identity
    if curved is not None and curved.rows is not UPRIGHT:
        rows = ex.exact_row(curved.rows[0]), ex.exact_row(curved.rows[1]), ex.exact_row(curved.rows[2])
        columns = ex.inverse(rows)
    low, high = np.empty(3), np.empty(3)
    for k, row in enumerate(rows):
        # How far the shape reaches beyond the anchor, both ways along the axis
        x, y, z = (float(c) for c in row)
        middle = ex.dot(row, anchor)
        high[k] = _distance_beyond(leaf.support((x, y, z)), -middle)
        low[k] = -_distance_beyond(leaf.support((-x, -y, -z)), middle)
    linear, shift = leaf.placement.affine
    start = tuple(ex.dot(row, anchor, t) for row, t in zip(linear, shift, strict=True))
    frame = LocalFrame((start[0], start[1], start[2]), ex.multiply(linear, columns))
    return frame, (low, high), _size(curved) if curved is not None else np.zeros(3)


def _distance_beyond(reach: float, middle: ex.BigFloat) -> float:
    """Return reach + middle, added exactly; an infinite reach as it is."""
    return float(ex.exact(reach) + middle) if math.isfinite(reach) else reach


def _size(surface: QuadricSurface) -> FloatArray:
    """Return half lengths (3,) along the axes, the largest of them along an axis without a square."""
    constant, slope = abs(ex.exact(surface.constant)), max(abs(ex.exact(b)) for b in surface.linear)
    squares = [abs(ex.exact(s)) for s in surface.squares]
    # A semi-axis √(c / s), plus the distance b / s of the center
    curved = [float(ex.sqrt(constant / s) + slope / s) if s else 0.0 for s in squares]
    return np.array([size or max(curved) for size in curved])


@dataclass(frozen=True, eq=False)
class OwnForms:
    """The exact forms of a shape without motion in its own frame, found once for all frames that it is seen in."""

    leaf: Any

    @cached_property
    def sides(self) -> list[list[CellSide]]:
        """The faces of every cell."""
        return cells_of(self.leaf)

    @cached_property
    def forms(self) -> list[list[ExactForm]]:
        """The forms of the faces of every cell."""
        return forms_of(self.leaf, self.sides)

    @cached_property
    def changes(self) -> list[tuple[NumberChange[Any], list[dict[int, ExactForm]]]]:
        """Each change of a number, and how it changes forms of every cell by place, up to a multiple of each form."""
        if isinstance(self.leaf, FlatSolid):
            return self._flat_changes(self.leaf)
        found = []
        for change, cells in _comparable_changes(self.leaf, self.sides):
            pairs = zip(forms_of(change.result, cells), self.forms, strict=False)
            # Most numbers leave most faces as they are
            found.append((change, [
                {k: _difference(form, own[k]) for k, form in enumerate(forms) if form != own[k]}
                for forms, own in pairs
            ]))  # fmt: skip
        return found

    def _flat_changes(self, solid: FlatSolid) -> list[tuple[NumberChange[Any], list[dict[int, ExactForm]]]]:
        """Return `changes` of a solid whose parts stay between the planes that they have: nothing is cut anew."""
        parts, found = solid.parts.parts, []
        own = {
            k: form
            for part, forms in zip(parts, self.forms, strict=True)
            for (k, _), form in zip(part, forms, strict=True)
        }
        for single in number_changes(solid, replace_unchecked):
            change: NumberChange[Any] | None = single
            planes = solid.moved_planes(single.result)
            if planes is None:  # a face leaves its plane; all equal numbers of the column may keep it flat
                change = column_change(solid, single, replace_unchecked)
                planes = None if change is None else solid.moved_planes(change.result)
            if change is None or planes is None:
                continue
            moved = {
                k: _difference(form_of(plane_through(plane.normal, plane.offset, solid._near)), own[k])
                for k, plane in planes.items()
                if k in own
            }
            sides = [{place: moved[k] for place, (k, _) in enumerate(part) if k in moved} for part in parts]
            found.append((change, sides))
        return found


def localize(own: OwnForms, frame: LocalFrame, cut: bool, bounded: bool = False) -> LocalShape:
    """Return the cells of a shape without motion in a frame that fits the tested part.

    `bounded`: a shape with `has_face_shifts` gets bounds of all changes together, without a change of each number.
    """
    shifts = _face_shifts(own.leaf, frame) if bounded else {}
    changes = () if bounded else own.changes
    cells = []
    for i, (forms, cell) in enumerate(zip(own.forms, own.sides, strict=True)):
        changed = [(change.share, forms_[i] if i < len(forms_) else {}) for change, forms_ in changes]
        cells.append(_cell(forms, cell, changed, tuple(change.number for change, _ in changes), frame, cut, shifts))
    return LocalShape(frame, tuple(cells))


def has_face_shifts(leaf: Any) -> bool:
    """Return whether a shape has bounds of all changes together.

    Boxes, half-spaces, flat solids, polyhedra, general quadrics and whole cylinders have.
    """
    whole = isinstance(leaf, Cylinder) and leaf.end_angle - leaf.start_angle == 360
    return whole or isinstance(leaf, (Box, HalfSpace, FlatSolid, Polyhedron, Quadric))


def _face_shifts(leaf: Any, frame: LocalFrame) -> dict[int, float]:
    """Return for each face a bound of how much all numbers together change its form within the tested part.

    It is twice as large as needed, which leaves room for terms of second order. For a plane n·x - d of a polyhedron
    that is u (Σ |n_k p_k| + |d|), u = 2^-53, of a box u |d|, and for a quadric the same sum over its terms. Sides and
    caps of cylinders move as in `conditioning.least_digits`; the gradient of x² + y² - r² is 2 √2 r at most in the box
    around the cylinder.
    """
    if isinstance(leaf, FlatSolid):
        return {face: math.sqrt(3) * shift for face, shift in _flat_shifts(leaf, frame).items()}
    if isinstance(leaf, Cylinder):
        r, far = leaf.radius, sum(map(abs, (*leaf.start, *leaf.end, leaf.radius)))
        cap = 2 * HALF_ULP * far * (1 + 2 * r / float(leaf.length))
        return {0: 4 * math.sqrt(2) * r * HALF_ULP * far, 1: cap, 2: cap}
    reach = [
        abs(float(at)) + sum(abs(float(c)) for c in row) for at, row in zip(frame.origin, frame.columns, strict=True)
    ]
    if isinstance(leaf, Quadric):
        point = np.array([*reach, 1.0])
        return {0: float(2 * HALF_ULP * point @ np.abs(np.array(leaf.symmetric, np.float64)) @ point)}
    if isinstance(leaf, Box):
        sums = np.abs([leaf.low, leaf.high]).T.ravel()
    else:
        planes = ([leaf.normal], [leaf.offset]) if isinstance(leaf, HalfSpace) else (leaf.normals, leaf.offsets)
        sums = np.abs(planes[0]) @ reach + np.abs(planes[1])
    return dict(enumerate((2 * HALF_ULP * sums).tolist()))


def _flat_shifts(solid: FlatSolid, frame: LocalFrame) -> dict[int, float]:
    """Return for each face a bound of how far all numbers together move its planes within the tested part.

    The largest entry of the normal of a face is 1. Where the corners c_k of a polygon move by δ_k, the normal
    n = ½ Σ c_k × c_{k+1} · 2 of Newell changes by Σ (c_{k-1} - c_{k+1}) × δ_k. So at a point p the plane moves by
    Σ |δ_k| (1 + |p - c_0| D / |n|) at most, where D is twice the longest spoke from c_0. Numbers move |δ_k| by
    2^-52 |c_k|₁ together, as x and y of an extrusion are products of two; twice that leaves room for terms of second
    order. A face of a mesh that is no longer flat is cut into triangles, so that the smallest of these counts. Where
    floats do not show the area, no digit remains.
    """
    corners = solid._corners[:, :3].copy()
    corners[:, :2] *= solid._corners[:, 3:]
    origin = np.array([float(c) for c in frame.origin])
    reach = sum(abs(float(c)) for row in frame.columns for c in row)
    found: dict[int, float] = {}
    for number, piece in zip(solid.parts.numbers, solid.parts.pieces, strict=True):
        own = corners[list(piece)]
        spokes, total = own[1:] - own[0], float(np.abs(own).sum())
        normals = np.cross(spokes[:-1], spokes[1:])
        areas = [normals.sum(axis=0)] if isinstance(solid, Extrusion) else [*normals, normals.sum(axis=0)]
        area, size = np.linalg.norm(areas, axis=1).min(), 2 * np.linalg.norm(spokes, axis=1).max()
        bound = _NO_BOUND * reach
        if area > _AREA_MARGIN * size * total:
            far = np.linalg.norm(origin - own[0]) + reach
            bound = 4 * HALF_ULP * total * (1 + far * size / area)
        found[number] = max(found.get(number, 0.0), float(bound))
    return found


_AREA_MARGIN = 2.0**-30
"""Areas above this share of longest spoke times coordinates are certain in floats, to six digits."""
_NO_BOUND = 2.0**60
"""So many times the part stands for infinity, which would give 0 times infinity."""


def _comparable_changes(
    leaf: Any, sides: list[list[CellSide]]
) -> Iterator[tuple[NumberChange[Any], list[list[CellSide]]]]:
    """Yield the changes of a shape that keep the number and the kinds of its cells, with the cells after the change.

    A single change may not: one corner of a level edge that rises makes a flat cone of a plane. Then all equal numbers
    of the table's column change together, as they are one number on paper.
    """
    kinds = kinds_of(sides)
    for single in number_changes(leaf):
        cells = cells_of(single.result)
        if kinds_of(cells) == kinds:
            yield single, cells
            continue
        change = column_change(leaf, single, replace_checked)
        if change is not None and kinds_of(cells := cells_of(change.result)) == kinds:
            yield change, cells


def _cell(
    forms: Sequence[ExactForm],
    sides: Sequence[CellSide],
    changed: Sequence[tuple[float, dict[int, ExactForm]]],
    numbers: tuple[str, ...],
    frame: LocalFrame,
    cut: bool,
    face_shifts: dict[int, float],
) -> LocalCell:
    """Return a cell as float64 forms in a frame; `changed` holds (share, changes of forms) for each number."""
    rounded, moves = np.empty((len(sides), 4, 4)), np.zeros((len(changed), len(sides), 4, 4))
    shifts = np.zeros(len(sides))
    for s, (form, side) in enumerate(zip(forms, sides, strict=True)):
        local = form.seen_from(frame.origin, frame.columns)
        # The largest entry becomes 1, and changes are divided by the same number
        largest = max(abs(entry) for entry in local.entries) or ex.ONE
        rounded[s] = _divide_form(local, largest)
        shifts[s] = face_shifts.get(side.number, 0.0) / float(largest)
        for n, (share, changed_forms) in enumerate(changed):
            if s in changed_forms:
                difference = changed_forms[s].seen_from(frame.origin, frame.columns)
                moves[n, s] = share * _divide_form(difference, largest)
    flat = np.array([isinstance(side.surface, PlaneSurface) for side in sides])
    return LocalCell(rounded, flat, np.array([side.inside for side in sides]), moves, numbers, cut, shifts)


def _difference(changed: ExactForm, form: ExactForm) -> ExactForm:
    """Return the changed form minus its projection onto the old one: a multiple of the old form moves no surface."""
    own = form.entries
    return changed.minus(dot(changed.entries, own) / dot(own, own), form)


def _divide_form(form: ExactForm, divisor: ex.BigFloat) -> FloatArray:
    """Return form / divisor, rounded to float64."""
    return ExactForm(
        None if form.second is None else (_divide_row(form.second[0], divisor), _divide_row(form.second[1], divisor),
                                          _divide_row(form.second[2], divisor)),
        _divide_row(form.first, divisor),
        form.zeroth / divisor,
    ).rounded()  # fmt: skip


def _divide_row(row: ex.Row, divisor: ex.BigFloat) -> ex.Row:
    """Return row / divisor."""
    return row[0] / divisor, row[1] / divisor, row[2] / divisor


# How the numbers of a motion move the points of a shape.


@dataclass(frozen=True, eq=False)
class MotionFields:
    """The displacements of a shape's points by a motion's numbers, in the shape's own coordinates.

    fields    (n, 3, 4): a point z moves by fields @ (z, 1) when each of n numbers changes by a relative 2^-53
    numbers   names of the n numbers
    """

    fields: FloatArray
    numbers: tuple[str, ...]


@dataclass(frozen=True, eq=False)
class MotionChange:
    """M⁻¹ M' - 1 for one number: x moves by linear x + shift; `linear` is None if all points move alike."""

    number: str
    linear: ex.Rows | None
    shift: ex.Row


def motion_changes(motion: Motion) -> list[MotionChange]:
    """Return (S B)⁻¹ (S' - S) B for each number of a motion M = A S B, where S is the step with the number."""
    changes, before = [], Motion()
    for i, step in enumerate(motion.steps):
        # `before` is B and `through` is S B
        through = before.then(Motion((step,)))
        back, _ = through.inverse
        before_rows, before_shift = before.affine
        rows, shift = step.affine()
        for change in number_changes(Motion((step,))):
            to, to_shift = change.result.steps[0].affine()
            share = ex.exact(change.share)
            # The shift of (S' - S) B; its linear part follows if S has one that changes
            moved = (
                share * (to_shift[0] - shift[0]),
                share * (to_shift[1] - shift[1]),
                share * (to_shift[2] - shift[2]),
            )
            linear = None
            if to != rows:
                difference = _times(share, _minus(to, rows))
                at = ex.apply(difference, before_shift)
                moved = moved[0] + at[0], moved[1] + at[1], moved[2] + at[2]
                linear = ex.multiply(ex.multiply(back, difference), before_rows)
            name = f"steps[{i}]{change.number.removeprefix('[0]')}"
            changes.append(MotionChange(name, linear, ex.apply(back, moved)))
        before = through
    return changes


def fields_of(motion: Motion, frame: LocalFrame) -> MotionFields:
    """Return the changes of a motion in the coordinates of `frame`."""
    changes = motion_changes(motion)
    fields = np.zeros((len(changes), 3, 4))
    own = ex.inverse(frame.columns) if changes else ex.IDENTITY
    for field, change in zip(fields, changes, strict=True):
        shift = change.shift
        if change.linear is not None:
            # x = origin + columns z: the displacement in coordinates z
            at = ex.apply(change.linear, frame.origin)
            shift = at[0] + shift[0], at[1] + shift[1], at[2] + shift[2]
            linear = ex.multiply(ex.multiply(own, change.linear), frame.columns)
            field[:, :3] = [[float(c) for c in row] for row in linear]
        field[:, 3] = [float(c) for c in ex.apply(own, shift)]
    return MotionFields(fields, tuple(change.number for change in changes))


def _times(factor: ex.BigFloat, rows: ex.Rows) -> ex.Rows:
    """Return factor times a matrix."""
    (a, b, c), (d, e, f), (g, h, i) = rows
    return (
        (factor * a, factor * b, factor * c),
        (factor * d, factor * e, factor * f),
        (factor * g, factor * h, factor * i),
    )


def _minus(a: ex.Rows, b: ex.Rows) -> ex.Rows:
    """Return a - b."""

    def row(p: ex.Row, q: ex.Row) -> ex.Row:
        return p[0] - q[0], p[1] - q[1], p[2] - q[2]

    return row(a[0], b[0]), row(a[1], b[1]), row(a[2], b[2])
