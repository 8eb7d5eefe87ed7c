"""Bodies that are one another moved: the first is lowered as ever, of the others only what moving changes.

A shift moves the anchors of surfaces, and with them uv and frames. Along each axis there are few different shifts, so
what depends on one axis is lowered from one body for each of them, and gathered: the numbers are those that every body
would have alone, to the bit. Boxes are the first body's, moved and a little wider.

What a number depends on is not taken on trust: all bodies that were lowered for some axis are compared with what is
told of them, and where one differs, every body is lowered alone.
"""

from __future__ import annotations

from collections.abc import Hashable
from dataclasses import dataclass, replace
from fractions import Fraction
from functools import cached_property
from typing import Any, Protocol

import numpy as np

from ...shapes.base import Solid
from ...shapes.repeated import Ints, Shift, Shifts
from ...shapes.surface import ORIGIN, PlaneSurface, QuadricSurface
from ..tables import PLANE, PLANE_SIZE, Floats
from .alone import Alone
from .away import Away
from .moved_rows import Gathered, MovedRows
from .parts import Part, part_of
from .pattern import SIZES, Pattern
from .together import Together

FEWEST = 24
"""Bodies of a kind that are worth it."""
SAME = 2.0**-40
"""Relative difference of uv and frames of slanted bodies, which are computed, from those worked out alone."""


class OneAnotherMoved(Protocol):
    """What `moved_rows` asks of `Repeated`."""

    @property
    def shifts(self) -> Shifts: ...

    @property
    def alone(self) -> dict[tuple[int, ...], Floats]: ...

    def is_rigid(self, kind: int, /) -> bool: ...

    def made(self, kind: int, shift: Shift, /) -> Solid: ...

    def shape(self, number: int, /) -> Solid: ...


def moved_rows(
    bodies: OneAnotherMoved, kind: int, numbers: Ints, alone: Alone | None = None
) -> tuple[Pattern, MovedRows] | None:
    """The pattern and the rows of the bodies of a kind; None where they have to be lowered one by one.

    alone: what is known of primitives that other kinds have in common with this one.
    """
    if len(numbers) < FEWEST or not bodies.is_rigid(kind):
        return None
    first = bodies.shape(int(numbers[0]))
    part = part_of(first)
    if part.paints or part.outlines or not isinstance(first, Solid):
        return None
    try:
        return _Moved(bodies, kind, numbers, part, alone or Alone()).rows()
    except _OfOtherStructure:
        return None


class _OfOtherStructure(Exception):
    """Of bodies that are one another moved one has more or fewer numbers, as rounding has made two of them one."""


@dataclass
class _Alone:
    """What bodies with all the different shifts along an axis are, each alone."""

    leads: Ints  # among the bodies of the kind
    index: Ints  # of each body, which of them has its shift
    numbers: Floats  # (leads, columns up to the boxes, then the frame)


class _Moved:
    """One run of `moved_rows`."""

    def __init__(self, bodies: OneAnotherMoved, kind: int, numbers: Ints, part: Part, alone: Alone) -> None:
        self.bodies, self.kind, self.part, self.alone = bodies, kind, part, alone
        self.shifts: Shifts = bodies.shifts.chosen(numbers)
        self.known: dict[int, Floats] = {}
        self.taken: list[int] = []  # columns that are those of another body with the same plane
        p = part.pattern
        self.ends = p.bounds_at, p.frame_at

    def rows(self) -> tuple[Pattern, MovedRows] | None:
        """`moved_rows`"""
        pattern, base = self.part.pattern, np.array(self.part.row)
        moved = MovedRows(base, Away.of(self.shifts), boxes=(pattern.bounds_at, pattern.frame_at))
        axes = [self._along(axis) for axis in range(3)]
        for slot, (kind, column, sense) in enumerate(pattern.records):
            normal = np.flatnonzero(base[column : column + 3])
            if kind == PLANE and len(normal) > 1:
                found = self._slanted(slot)
                if found is None:
                    return None
                moved.gathered.append(self._gathered(found, column, sense + 1))
                moved.leads[column] = found.leads.astype(np.int32)[found.index]
                self.taken += range(column, sense + 1)
                continue
            anchor = column + SIZES[kind] - 3 if kind == PLANE else column
            for axis, along in enumerate(axes):
                for at in (anchor + axis, anchor + SIZES[kind] + axis):
                    moved.gathered.append(self._gathered(along, at, at + 1))
            if kind != PLANE:
                moved.forms[column] = self._form(slot, kind, column, moved)
            else:
                moved.leads[column] = _least(axes[normal[0]].index, moved[:, column : column + PLANE_SIZE])
        for begin, end in ((pattern.uv_at, pattern.bounds_at), (pattern.frame_at, pattern.corners_at)):
            for at in range(begin, end, 4):
                used = np.flatnonzero(base[at : at + 3])
                if len(used) == 1:
                    moved.gathered.append(self._gathered(axes[used[0]], at, at + 4))
                elif len(used) > 1 and self._moves(at):
                    moved.slanted.append(at)
        return (pattern, moved) if self._holds(moved) else None

    def _form(self, slot: int, kind: int, column: int, moved: MovedRows) -> Hashable:
        """What says that surfaces are one whose anchors are; None where anchors are rounded."""
        surface, size = self.part.exact[slot], SIZES[kind]
        if moved[:, column + size : column + size + 3].any() or not isinstance(surface, QuadricSurface):
            return None
        numbers = np.delete(moved.base[column : column + 2 * size + 1], [0, 1, 2])
        return replace(surface, anchor=ORIGIN).key(), numbers.tobytes()

    def _made(self, which: int) -> Solid:
        """The shape of one of the bodies."""
        return self.bodies.made(self.kind, self.shifts.of(which))

    def _numbers(self, shape: Solid) -> Floats:
        """The columns of a body but for its boxes, worked out alone."""
        numbers = self.alone.numbers(shape)
        if len(numbers) != self._column(self.part.pattern.corners_at):
            raise _OfOtherStructure
        return numbers

    def _alone(self, which: int) -> Floats:
        """Those of one of the bodies."""
        if which not in self.known and not self._is_kept(which):
            self._keep(which, self._numbers(self._made(which)))
        return self.known[which]

    def _work_out(self, leads: list[int]) -> None:
        """Make sure that bodies are known: those of several parts together, which is to the bit the same."""
        missing = [lead for lead in leads if lead not in self.known and not self._is_kept(lead)]
        if len(missing) < FEWEST or len(self.part.pattern.cells) < FEWEST:
            shapes = list(map(self._made, missing))
            self.alone.prepare(shapes)
            for lead, shape in zip(missing, shapes, strict=True):
                self._keep(lead, self._numbers(shape))
            return
        together = Together()
        for lead in missing:
            if not together.add(self.bodies.made(self.kind, self.shifts.of(lead)), lead):
                return
        before_boxes, after_boxes = self.ends
        found, _ = together.lowered()
        for pattern, numbers, rows in found:
            if pattern != self.part.pattern:
                raise _OfOtherStructure
            some = np.concatenate([rows[:, :before_boxes], rows[:, after_boxes : pattern.corners_at]], axis=1)
            for lead, row in zip(numbers.tolist(), some, strict=True):
                self._keep(lead, row)

    def _keep(self, lead: int, numbers: Floats) -> None:
        """Know a body, for edited lists as well."""
        self.known[lead] = self.bodies.alone[self._place(lead)] = numbers

    def _is_kept(self, lead: int) -> bool:
        """Is a body known to the list? Then it is known here."""
        found = self.bodies.alone.get(self._place(lead))
        if found is None or len(found) != self._column(self.part.pattern.corners_at):
            return False
        self.known[lead] = found
        return True

    def _place(self, lead: int) -> tuple[int, ...]:
        """The kind of a body, and the places of its shift."""
        x, y, z = self.shifts.index[:, lead].tolist()
        return self.kind, x, y, z

    @cached_property
    def _aside(self) -> Floats:
        """How far the bodies are from the diagonal of their shifts."""
        index = self.shifts.index
        share = index / (1.0 + index.max(axis=1, keepdims=True))
        some = index.max(axis=1) > 0
        return np.ptp(share[some], axis=0) if some.any() else np.zeros(index.shape[1])

    def _leads(self, key: Any) -> _Alone:
        """One body for each value of a key; those on the diagonal, if there are some, as they serve several axes."""
        key = np.asarray(key)
        least = np.full(int(key.max()) + 1, np.inf)
        np.minimum.at(least, key, self._aside)
        there = np.isfinite(least)
        which = (np.cumsum(there, dtype=np.int32) - np.int32(1))[key]
        nearest = np.flatnonzero(self._aside == least[key])[::-1]
        leads = np.empty(int(there.sum()), np.int64)
        leads[which[nearest]] = nearest  # of equal ones the first
        self._work_out(leads.tolist())
        alone = np.array([self._alone(lead) for lead in leads.tolist()])
        return _Alone(leads.astype(np.int32), which, alone)

    def _along(self, axis: int) -> _Alone:
        """By the shift along an axis."""
        return self._leads(self.shifts.index[axis])

    def _slanted(self, slot: int) -> _Alone | None:
        """By what a plane depends on: how far the shift is along its normal. None where it differs too often."""
        surface = self.part.exact[slot]
        if not isinstance(surface, PlaneSurface):
            return None
        try:
            exact = [Fraction(n) for n in surface.normal]
        except TypeError:
            return None
        distances: dict[Fraction, int] = {}
        parts = [[n * value for value in values] for n, values in zip(exact, self.shifts.values, strict=True)]
        keys = [
            distances.setdefault(parts[0][x] + parts[1][y] + parts[2][z], len(distances))
            for x, y, z in self.shifts.index.T.tolist()
        ]
        return self._leads(np.array(keys)) if len(distances) <= max(FEWEST, len(keys) // 8) else None

    def _gathered(self, alone: _Alone, first: int, last: int) -> Gathered:
        """Columns by what they depend on."""
        begin = self._column(first)
        return Gathered(first, last, alone.numbers[:, begin : begin + last - first], alone.index)

    def _column(self, column: int) -> int:
        """A column of rows among those without boxes."""
        before_boxes, after_boxes = self.ends
        return column if column < before_boxes else column - (after_boxes - before_boxes)

    def _moves(self, at: int) -> bool:
        """Does an affine map, of which the row begins at a column, move with the bodies?"""
        column = self._column(at)
        return any(numbers[column + 3] != self.part.row[at + 3] for numbers in self.known.values())

    def _holds(self, moved: MovedRows) -> bool:
        """Are all bodies that were worked out alone as the rows say?"""
        which = np.array(sorted(self.known))
        before_boxes, after_boxes = self.ends
        told = np.concatenate(
            [moved.of(which, 0, before_boxes), moved.of(which, after_boxes, self.part.pattern.corners_at)], axis=1
        )
        found = np.array([self.known[int(each)] for each in which])
        if told.shape != found.shape:
            return False
        exact, own = np.ones(told.shape[1], bool), np.ones(told.shape[1], bool)
        exact[[self._column(at) + 3 for at in moved.slanted]] = False
        own[self.taken] = False
        near = np.abs(told - found) <= SAME * (1.0 + np.abs(found) + np.abs(moved.away[which]).max(axis=1)[:, None])
        return bool((told.view(np.int64) == found.view(np.int64))[:, exact & own].all() and near[:, own].all())


def _least(groups: Ints, records: Floats) -> Ints:
    """For each row the one of its group whose record comes first in order, as `surfaces` chooses among equals."""
    differing = [column for column in records.T[::-1] if (column != column[0]).any()]
    order = np.lexsort((*differing, groups))
    begins = np.concatenate([[True], np.diff(groups[order]) != 0])
    found = np.empty(len(groups), np.int32)
    found[order] = order[np.maximum.accumulate(np.where(begins, np.arange(len(order)), 0))]
    return found
