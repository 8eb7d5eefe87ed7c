"""The rows of bodies that are one another moved (`moved`), made when they are asked for: few differ along each axis."""

from __future__ import annotations

from collections.abc import Hashable
from dataclasses import dataclass, field
from typing import Any, TypeAlias

import numpy as np

from ...shapes.repeated import Ints
from ..tables import Floats
from .away import Away
from .pattern import BOX_NUMBERS

_WIDER = 2.0**-20
"""Boxes are wider by this share of their size and of how far they are moved (the geometric mean). Their ends are roots
of quadratic equations in numbers that moving rounds, so what they are off by is of the order of its square root."""


@dataclass(frozen=True)
class Gathered:
    """Columns of rows that depend on one thing: a table by its values, and which of these each body has."""

    first: int
    last: int
    values: Floats  # (different ones, last - first)
    index: Ints  # (bodies,)


Named: TypeAlias = tuple[Hashable, list[tuple[Floats, Ints]]]
"""A form; of each axis the different coordinates, and which of them each body has."""


@dataclass
class MovedRows:
    """The rows of bodies, worked out when columns are asked for: `rows[:, a:b]` and `rows[:, a]`."""

    base: Floats
    away: Away  # from the first
    gathered: list[Gathered] = field(default_factory=list)
    slanted: list[int] = field(default_factory=list)
    """Where rows of four begin, an affine map each, that depend on several axes."""
    boxes: tuple[int, int] = (0, 0)
    """The columns that are boxes."""
    leads: dict[int, Ints] = field(default_factory=dict)
    """Of a plane that begins at a column, for each body the one whose record stands for all that have the same."""
    forms: dict[int, Hashable] = field(default_factory=dict)
    """Of a curved surface that begins at a column, what it is but for its anchor, which nothing was rounded in."""
    names: dict[int, Named] = field(default_factory=dict)
    """Of other surfaces that begin at a column, what says which are one."""

    def __len__(self) -> int:
        return len(self.away)

    def __getitem__(self, where: tuple[slice, Any]) -> Floats:
        every, columns = where
        if not isinstance(columns, slice):
            return self[every, columns : columns + 1][:, 0]
        return self.of(np.arange(*every.indices(len(self))), columns.start, columns.stop)

    def of(self, bodies: Any, first: int, last: int) -> Floats:
        """Some columns of some bodies."""
        rows = np.empty((len(bodies), last - first))
        rows[:] = self.base[first:last]
        for each in self.gathered:
            a, b = max(first, each.first), min(last, each.last)
            if a < b:
                rows[:, a - first : b - first] = each.values[:, a - each.first : b - each.first][each.index[bodies]]
        for at in self.slanted:
            if first <= at + 3 < last:
                rows[:, at + 3 - first] -= (self.base[at : at + 3] * self.away[bodies]).sum(axis=1)
        for at in range(*self.boxes, BOX_NUMBERS):
            a, b = max(first, at), min(last, at + BOX_NUMBERS)
            if a < b:
                rows[:, a - first : b - first] = self._boxes(bodies, at)[:, a - at : b - at]
        return rows

    def distinct(self, column: int) -> tuple[Floats, Ints]:
        """Of a column that depends on at most one thing: (the different values, which of them each body has)."""
        for each in self.gathered:
            if each.first <= column < each.last:
                return each.values[:, column - each.first], each.index
        return self.base[column : column + 1], np.zeros(len(self), np.int32)

    def name(self, column: int) -> Named | None:
        """What says of surfaces that begin at a column which are one: those of one form with equal coordinates."""
        form = self.forms.get(column)
        if form is None:
            return self.names.get(column)
        return form, [self.distinct(column + axis) for axis in range(3)]

    def maps(self, at: int) -> tuple[Floats, Ints]:
        """Of the row of an affine map that begins at a column: (the different ones (n, 4), which each body has)."""
        for each in self.gathered:
            if (each.first, each.last) == (at, at + 4) and (each.values != each.values[0]).any():
                return each.values, each.index
        if at in self.slanted:
            return self[:, at : at + 4], np.arange(len(self), dtype=np.int32)
        return self.base[None, at : at + 4], np.zeros(len(self), np.int32)

    def _boxes(self, bodies: Any, at: int) -> Floats:
        """A box of the first body, moved to others."""
        return moved_boxes(self.base[at : at + BOX_NUMBERS], self.away[bodies])

    def around_all(self, at: int, count: int) -> Floats:
        """So many boxes of the first body, from a column on, wide enough for those of all bodies less `away`."""
        boxes, far = self.base[at : at + BOX_NUMBERS * count].reshape(-1, BOX_NUMBERS).copy(), self.away.most
        for box in boxes:
            wider = _wider(box, far)
            box[:3] -= wider
            box[3:] += wider
        return boxes


def moved_boxes(box: Floats, away: Floats) -> Floats:
    """A box (6,) low and high, moved by each of (n, 3)."""
    wider = _wider(box, np.abs(away).max(axis=1))[:, None]
    return np.concatenate([box[:3] + (away - wider), box[3:] + (away + wider)], axis=1)


def _wider(box: Floats, away: Any) -> Any:
    """By how much a box is wider that is moved so far (see `_WIDER`)."""
    ends = np.where(np.isfinite(box), box, 0.0)
    size = np.abs(ends[3:] - ends[:3]).max()
    return _WIDER * np.sqrt(size * (size + np.abs(ends).max() + away))
