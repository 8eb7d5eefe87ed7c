"""A cell of a shape in coordinates of its own size, and how its surfaces move as the shape's numbers change.

The coordinates z have their origin in the middle of the part looked at, axes along the quadric's principal ones, and
the part between -1/2 and 1/2 along each; so z measures in units of the part itself, whatever its size and place.
Everything is exact up to here and rounded to float64 now.
"""

from __future__ import annotations

import math
from collections.abc import Iterator, Sequence
from dataclasses import dataclass
from typing import Any

import numpy as np

from ..shapes import exact as ex
from ..shapes.motion import Motion
from ..shapes.surface import UPRIGHT, PlaneSurface, QuadricSurface
from ..shapes.vector import FloatArray
from .changes import Change, changes, together
from .forms import Form, Side, cells_of, dot, forms_of, kinds_of

Extent = tuple[FloatArray, FloatArray]


@dataclass(frozen=True)
class Frame:
    """x = origin + columns z, from local coordinates to those of the shape before its motion."""

    origin: ex.Row
    columns: ex.Rows

    def scaled(self, extent: Extent) -> Frame:
        """The same axes, with `extent` (low, high) going from -1/2 to 1/2."""
        low, high = extent
        middle = ex.exact_row((ex.exact(a) + ex.exact(b)) / 2 for a, b in zip(low.tolist(), high.tolist(), strict=True))
        sizes = ex.exact_row(high - low)
        x, y, z = (ex.dot(row, middle, start) for row, start in zip(self.columns, self.origin, strict=True))
        a, b, c = ((row[0] * sizes[0], row[1] * sizes[1], row[2] * sizes[2]) for row in self.columns)
        return Frame((x, y, z), (a, b, c))


@dataclass(frozen=True, eq=False)
class LocalCell:
    """S surfaces of a cell as float64 forms in z.

    forms     (S, 4, 4), the largest entry of each 1
    flat      (S,) bool: planes
    sides     (S,): +1 where f <= 0 is inside, -1 where f >= 0 is, 0 where a sheet lies in it
    moves     (n, S, 4, 4): what a relative change by 2^-53 of each of n numbers adds to the forms, up to a factor
    numbers   their names
    cut       is the part looked at smaller than the cell?
    """

    forms: FloatArray
    flat: Any
    sides: Any
    moves: FloatArray
    numbers: tuple[str, ...]
    cut: bool


@dataclass(frozen=True, eq=False)
class Local:
    """The cells of a shape in the same coordinates."""

    frame: Frame
    cells: tuple[LocalCell, ...]


def own_frame(leaf: Any) -> tuple[Frame, Extent, FloatArray]:
    """(axes of the first quadric about its anchor, how far the shape reaches along them, its own size along them).

    The extent is infinite where the shape is, and low > high where it is empty; the size is of the order of the
    quadric's semi-axes, and 0 for planes.
    """
    sides = [side.surface for cell in cells_of(leaf) for side in cell]
    curved = next((surface for surface in sides if isinstance(surface, QuadricSurface)), None)
    chosen = curved or sides[0]
    anchor, columns = ex.exact_row(chosen.anchor), ex.IDENTITY
    rows = ex.IDENTITY
    if curved is not None and curved.rows is not UPRIGHT:
        rows = ex.exact_row(curved.rows[0]), ex.exact_row(curved.rows[1]), ex.exact_row(curved.rows[2])
        columns = ex.inverse(rows)
    low, high = np.empty(3), np.empty(3)
    for k, row in enumerate(rows):
        x, y, z = (float(c) for c in row)
        middle = ex.dot(row, anchor)
        high[k] = _beyond(leaf.support((x, y, z)), -middle)
        low[k] = -_beyond(leaf.support((-x, -y, -z)), middle)
    linear, shift = leaf.placement.affine
    start = tuple(ex.dot(row, anchor, t) for row, t in zip(linear, shift, strict=True))
    frame = Frame((start[0], start[1], start[2]), ex.multiply(linear, columns))
    return frame, (low, high), _size(curved) if curved is not None else np.zeros(3)


def _beyond(reach: float, middle: ex.Exact) -> float:
    return float(ex.exact(reach) + middle) if math.isfinite(reach) else reach


def _size(surface: QuadricSurface) -> FloatArray:
    """(3,) half lengths along the axes, with the largest where the surface is not curved."""
    constant, slope = abs(ex.exact(surface.constant)), max(abs(ex.exact(b)) for b in surface.linear)
    squares = [abs(ex.exact(s)) for s in surface.squares]
    curved = [float(ex.sqrt(constant / s) + slope / s) if s else 0.0 for s in squares]
    return np.array([size or max(curved) for size in curved])


def local(leaf: Any, frame: Frame, cut: bool) -> Local:
    """The cells of a shape without motion, in a frame that fits the part looked at."""
    sides = cells_of(leaf)
    base = forms_of(leaf, sides)
    made = [(change, forms_of(change.made, cells)) for change, cells in _comparable(leaf, sides)]
    cells = []
    for i, (forms, cell) in enumerate(zip(base, sides, strict=True)):
        changed = [(change.share, forms_[i] if i < len(forms_) else {}) for change, forms_ in made]
        cells.append(_cell(forms, cell, changed, tuple(change.number for change, _ in made), frame, cut))
    return Local(frame, tuple(cells))


def _comparable(leaf: Any, sides: list[list[Side]]) -> Iterator[tuple[Change[Any], list[list[Side]]]]:
    """The changes of a shape, and its cells then, if they are as many of the same kinds.

    Where they are not, as one corner of a level edge that rises makes a flat cone of a plane, equal numbers are one
    number on paper, and change together.
    """
    kinds = kinds_of(sides)
    for alone in changes(leaf):
        cells = cells_of(alone.made)
        if kinds_of(cells) == kinds:
            yield alone, cells
            continue
        change = together(leaf, alone)
        if change is not None and kinds_of(cells := cells_of(change.made)) == kinds:
            yield change, cells


def _cell(
    forms: dict[int, Form],
    sides: Sequence[Side],
    changed: Sequence[tuple[float, dict[int, Form]]],
    numbers: tuple[str, ...],
    frame: Frame,
    cut: bool,
) -> LocalCell:
    rounded, moves = np.empty((len(sides), 4, 4)), np.zeros((len(changed), len(sides), 4, 4))
    for s, side in enumerate(sides):
        form = forms[side.number]
        seen = form.seen_from(frame.origin, frame.columns)
        largest = max(abs(entry) for entry in seen.entries) or ex.ONE
        rounded[s] = _divided(seen, largest)
        for n, (share, found) in enumerate(changed):
            other = found.get(side.number)
            if other is not None and other != form:
                moves[n, s] = share * _divided(_difference(other, form).seen_from(frame.origin, frame.columns), largest)
    flat = np.array([isinstance(side.surface, PlaneSurface) for side in sides])
    return LocalCell(rounded, flat, np.array([side.inside for side in sides]), moves, numbers, cut)


def _difference(changed: Form, form: Form) -> Form:
    """What is left of the changed form without the multiple of the old one that is most like it: 0 on the surface."""
    own = form.entries
    return changed.minus(dot(changed.entries, own) / dot(own, own), form)


def _divided(form: Form, divisor: ex.Exact) -> FloatArray:
    return Form(
        None if form.second is None else (_over(form.second[0], divisor), _over(form.second[1], divisor),
                                          _over(form.second[2], divisor)),
        _over(form.first, divisor),
        form.zeroth / divisor,
    ).rounded()  # fmt: skip


def _over(row: ex.Row, divisor: ex.Exact) -> ex.Row:
    return row[0] / divisor, row[1] / divisor, row[2] / divisor


@dataclass(frozen=True, eq=False)
class Fields:
    """How a motion's numbers move the points of a shape, seen from its own coordinates.

    fields    (n, 3, 4): a point (z, 1) goes by fields (z, 1), for a relative change by 2^-53 of each number
    numbers   their names
    """

    fields: FloatArray
    numbers: tuple[str, ...]


@dataclass(frozen=True, eq=False)
class MotionChange:
    """M⁻¹ M' - 1 for one number: x goes by linear x + shift; `linear` is None where all points go alike."""

    number: str
    linear: ex.Rows | None
    shift: ex.Row


def motion_changes(motion: Motion) -> list[MotionChange]:
    """For each number of a motion M = A S B, S being the step with the number: (S B)⁻¹ (S' - S) B."""
    found, before = [], Motion()
    for i, step in enumerate(motion.steps):
        until = before.then(Motion((step,)))
        back, _ = until.inverse
        before_rows, before_shift = before.affine
        rows, shift = step.affine()
        for change in changes(step):
            to, to_shift = change.made.affine()
            share = ex.exact(change.share)
            moved = share * (to_shift[0] - shift[0]), share * (to_shift[1] - shift[1]), share * (to_shift[2] - shift[2])
            linear = None
            if to != rows:
                turned = _times(share, _minus(to, rows))
                at = ex.apply(turned, before_shift)
                moved = moved[0] + at[0], moved[1] + at[1], moved[2] + at[2]
                linear = ex.multiply(ex.multiply(back, turned), before_rows)
            found.append(MotionChange(f"steps[{i}].{change.number}", linear, ex.apply(back, moved)))
        before = until
    return found


def fields_of(motion: Motion, frame: Frame) -> Fields:
    """The changes of a motion in the coordinates of `frame`."""
    found = motion_changes(motion)
    fields = np.zeros((len(found), 3, 4))
    own = ex.inverse(frame.columns) if found else ex.IDENTITY
    for field, change in zip(fields, found, strict=True):
        shift = change.shift
        if change.linear is not None:
            at = ex.apply(change.linear, frame.origin)
            shift = at[0] + shift[0], at[1] + shift[1], at[2] + shift[2]
            linear = ex.multiply(ex.multiply(own, change.linear), frame.columns)
            field[:, :3] = [[float(c) for c in row] for row in linear]
        field[:, 3] = [float(c) for c in ex.apply(own, shift)]
    return Fields(fields, tuple(change.number for change in found))


def _times(factor: ex.Exact, rows: ex.Rows) -> ex.Rows:
    (a, b, c), (d, e, f), (g, h, i) = rows
    return (
        (factor * a, factor * b, factor * c),
        (factor * d, factor * e, factor * f),
        (factor * g, factor * h, factor * i),
    )


def _minus(a: ex.Rows, b: ex.Rows) -> ex.Rows:
    def row(p: ex.Row, q: ex.Row) -> ex.Row:
        return p[0] - q[0], p[1] - q[1], p[2] - q[2]

    return row(a[0], b[0]), row(a[1], b[1]), row(a[2], b[2])
