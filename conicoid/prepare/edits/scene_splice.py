"""Splice two scenes: the pieces that they share, and columns of a third from both."""

from __future__ import annotations

import operator
from collections.abc import Callable, Sequence
from dataclasses import field
from functools import cached_property
from itertools import compress, count
from typing import Any, NamedTuple

import numpy as np
import numpy.typing as npt

from ..._util.records import dataclass
from ...geometry.body import Body
from ...kernels.tables import Floats, Ints, Longs
from ..row_layout import AXES_OF_ROWS, BALLS, ENTRIES, FACES, SPHERES, SURFACES, RowLayout

# Find what an edited scene shares with the scene before: pieces of two scenes, one after the other.

_OLD, _NEW = 0, 1
Run = tuple[int, int, int]
"""(which of two scenes, first entry, end)."""


class SpliceRuns(NamedTuple):
    """Pieces of an old scene and of a scene of the new entries that make up the edited scene; which entries are new."""

    pieces: list[Run]
    fresh: list[int]


def find_runs(old: Sequence[Body], new: Sequence[Body]) -> SpliceRuns:
    """Find what an edited scene keeps of an old one (the same shapes in the same order), and the new bodies."""
    if len(old) == len(new):
        front, back = 0, 0
    else:
        least = min(len(old), len(new))
        front = _common_prefix(old, new)
        back = min(_common_prefix(old[::-1], new[::-1]), least - front)
    ends = len(old) - back, len(new) - back
    shared = _increasing_runs(old[front : ends[0]], new[front : ends[1]])
    found: list[Run] = [(_OLD, 0, front)] if front else []
    fresh: list[int] = []
    before = 0  # end of the covered part of the middle of the new scene
    for begin, end, of_old in shared:
        if begin > before:
            found.append((_NEW, len(fresh), len(fresh) + begin - before))
            fresh.extend(range(front + before, front + begin))
        if end > begin:
            found.append((_OLD, front + of_old, front + of_old + end - begin))
        before = end
    return SpliceRuns([*found, *([(_OLD, ends[0], len(old))] if back else [])], fresh)


def _common_prefix(old: Sequence[Body], new: Sequence[Body]) -> int:
    """Count the bodies from the first on that have the same shapes."""
    for place, same in enumerate(map(operator.is_, old, new)):
        if not same and old[place].shape is not new[place].shape:
            return place
    return min(len(old), len(new))


def _increasing_runs(old: Sequence[Body], new: Sequence[Body]) -> list[tuple[int, int, int]]:
    """Return (first, end, first of the old) of runs of kept bodies, in rising order; an empty run at the end."""
    if len(old) == len(new):
        other = list(compress(count(), map(operator.is_not, old, new)))
        other = [place for place in other if old[place].shape is not new[place].shape]
        begins = [0, *(place + 1 for place in other)]
        parts = [(a, b, a) for a, b in zip(begins, [*other, len(new)], strict=True) if b > a]
        return [*parts, (len(new), len(new), len(old))]
    places: dict[int, list[int]] = {}
    for number in range(len(old) - 1, -1, -1):
        places.setdefault(id(old[number].shape), []).append(number)
    found: list[tuple[int, int, int]] = []
    last = -1
    for place, body in enumerate(new):
        numbers = places.get(id(body.shape), [])
        while numbers and numbers[-1] <= last:
            numbers.pop()
        if not numbers:
            continue
        last = numbers.pop()
        if found and found[-1][1] == place and found[-1][2] + place - found[-1][0] == last:
            found[-1] = (found[-1][0], place + 1, found[-1][2])
        else:
            found.append((place, place + 1, last))
    return [*found, (len(new), len(new), len(old))]


@dataclass(frozen=True)
class SplicePieces:
    """Pieces of an old scene (0) and of one of the new entries (1). Columns are the kinds of rows of `RowLayout`."""

    sources: list[int]
    begin: Longs  # (pieces, AXES_OF_ROWS) first rows
    end: Longs
    at: Longs  # first rows in the new scene
    total: Longs  # (AXES_OF_ROWS,)
    _on: dict[int, list[tuple[int, slice, slice]]] = field(default_factory=dict, repr=False, compare=False)

    @classmethod
    def of(cls, found: Sequence[Run], layouts: tuple[RowLayout, RowLayout]) -> SplicePieces:
        """Convert runs of entries to pieces."""
        begin, end = (np.zeros((len(found), AXES_OF_ROWS), np.int64) for _ in range(2))
        for source in (_OLD, _NEW):
            mine = [k for k, run in enumerate(found) if run[0] == source]
            bounds = np.array([found[k][1:] for k in mine], np.int64).reshape(-1)
            rows = layouts[source].rows_up_to(bounds)
            begin[mine], end[mine] = rows[0::2], rows[1::2]
        ends = np.cumsum(end - begin, axis=0)
        total = ends[-1] if len(found) else np.zeros(AXES_OF_ROWS, np.int64)
        return cls([run[0] for run in found], begin, end, ends - (end - begin), total)

    def of_source(self, source: int) -> SplicePieces:
        """Select the pieces of one of the scenes."""
        mine = [k for k, which in enumerate(self.sources) if which == source]
        return SplicePieces([source] * len(mine), self.begin[mine], self.end[mine], self.at[mine], self.total)

    def after_rows(self, bounds: Longs) -> SplicePieces:
        """Prepend pieces of the old scene that stay; bounds (2 n, AXES_OF_ROWS): their first rows and ends."""
        begin, end = bounds[0::2], bounds[1::2]
        return SplicePieces(
            [_OLD] * len(begin) + self.sources, np.concatenate([begin, self.begin]),
            np.concatenate([end, self.end]), np.concatenate([begin, self.at]), self.total,
        )  # fmt: skip

    def on(self, axis: int) -> list[tuple[int, slice, slice]]:
        """List (source, its rows, rows in the new scene) of all pieces that have rows of a kind."""
        if axis not in self._on:
            parts = zip(
                self.sources, self.begin[:, axis].tolist(), self.end[:, axis].tolist(), self.at[:, axis].tolist(),
                strict=True,
            )  # fmt: skip
            self._on[axis] = [(source, slice(a, b), slice(at, at + b - a)) for source, a, b, at in parts if b > a]
        return self._on[axis]

    def begins(self, axis: int, beside: int) -> list[int]:
        """List where the rows of kind `beside` begin in the new scene, for all pieces with rows of kind `axis`."""
        parts = zip(self.at[:, beside].tolist(), self.begin[:, axis].tolist(), self.end[:, axis].tolist(), strict=True)
        return [at for at, a, b in parts if b > a]

    def moved(self, axis: int, beside: int) -> list[tuple[int, slice, slice, int]]:
        """`on`, with the shift of the numbers of rows of kind `beside`."""
        shifts, begin, end = self._shifts[beside], self.begin[:, axis].tolist(), self.end[:, axis].tolist()
        of_pieces = [shift for shift, a, b in zip(shifts, begin, end, strict=True) if b > a]
        return [(*part, shift) for part, shift in zip(self.on(axis), of_pieces, strict=True)]

    @cached_property
    def _shifts(self) -> list[list[int]]:
        """The shift of the numbers of rows of each kind in each piece."""
        return (self.at - self.begin).T.tolist()


Array = npt.NDArray[Any]


@dataclass(frozen=True)
class SceneSplice:
    """The old scene and one of the new entries, and the pieces of them that make up a third."""

    sides: tuple[Any, Any]
    pieces: SplicePieces

    @property
    def layouts(self) -> tuple[RowLayout, RowLayout]:
        """The layouts of both scenes."""
        return self.sides[0].layout, self.sides[1].layout

    def of_both(self, axis: int, old: Array, new: Array) -> Array:
        """Splice a column of rows of a kind."""
        both = old, new
        spliced = np.empty((int(self.pieces.total[axis]), *old.shape[1:]), old.dtype)
        for source, rows, at in self.pieces.on(axis):
            spliced[at] = both[source][rows]
        return spliced

    def column(self, axis: int, of: Callable[[Any], Array], dtype: Any) -> Array:
        """Splice a column that `of` reads from each scene."""
        old, new = (np.asarray(of(side), dtype) for side in self.sides)
        return self.of_both(axis, old, new)

    def paint(self) -> dict[int, Any]:
        """Splice the materials of faces that have their own."""
        if not any(side.face_paint for side in self.sides):
            return {}
        found: dict[int, Any] = {}
        for source, rows, at in self.pieces.on(FACES):
            paint = self.sides[source].face_paint
            # Iterate over the shorter of both: the rows of the piece, or the painted rows.
            if len(paint) > rows.stop - rows.start:
                mine = [row for row in range(rows.start, rows.stop) if row in paint]
            else:
                mine = [row for row in paint if rows.start <= row < rows.stop]
            found.update((row - rows.start + at.start, paint[row]) for row in mine)
        return found

    def of_entries(self, old: Longs, new: Longs) -> Longs:
        """Splice counts up to each entry of the list, and in all."""
        both, counts = (np.diff(old), np.diff(new)), np.zeros(int(self.pieces.total[ENTRIES]) + 1, np.int64)
        for source, rows, at in self.pieces.on(ENTRIES):
            counts[1 + at.start : 1 + at.stop] = both[source][rows]
        return np.cumsum(counts)

    def of_spheres(self, old: Array, new: Array) -> Array:
        """Splice a column of the table of spheres, with the bulk balls at its end."""
        both = old, new
        single = self.of_both(SPHERES, old, new)
        if not self.pieces.total[BALLS]:
            return single
        # Pattern 0 marks bulk balls: their rows stand at the end of the table.
        counts = [len(part) - int(side.layout.which.size - np.count_nonzero(side.layout.which))
                  for part, side in zip(both, self.sides, strict=True)]  # fmt: skip
        balls = self.of_both(BALLS, *(part[count:] for part, count in zip(both, counts, strict=True)))
        return np.concatenate([single, balls])

    def take(self, axis: int, rows: Longs, of: Callable[[Any], Array]) -> Array:
        """Take some rows of a spliced column."""
        columns = [of(side) for side in self.sides]
        found = np.empty((len(rows), *columns[0].shape[1:]), columns[0].dtype)
        for source, there, at in self.pieces.on(axis):
            mine = (rows >= at.start) & (rows < at.stop)
            if mine.any():
                found[mine] = columns[source][rows[mine] - at.start + there.start]
        return found

    def take_balls(self, rows: Longs) -> Floats:
        """Take some of the bulk balls."""

        def balls(side: Any) -> Floats:
            return side.tables.spheres[len(side.rest.spheres) :]

        return self.take(BALLS, rows, balls)

    def numbers_of_surfaces(self, source: int) -> Ints:
        """Return the new number of each input surface of a scene, and of its bulk balls behind; -1 for removed ones."""
        return self._numbers[source]

    @cached_property
    def _numbers(self) -> tuple[Ints, Ints]:
        total, found = int(self.pieces.total[SURFACES]), []
        for side in self.sides:
            single = len(side.layout.kinds)
            found.append(np.full(single + len(side.tables.spheres) - len(side.rest.spheres), -1, np.int32))
        for axis, begins, begin in ((SURFACES, [0, 0], 0), (BALLS, [len(s.layout.kinds) for s in self.sides], total)):
            for source, rows, at in self.pieces.on(axis):
                first = begins[source]
                found[source][first + rows.start : first + rows.stop] = np.arange(
                    begin + at.start, begin + at.stop, dtype=np.int32
                )
        return found[0], found[1]
