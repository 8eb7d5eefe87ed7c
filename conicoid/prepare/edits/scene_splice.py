"""Splice two scenes: columns of a third from pieces of both."""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import dataclass
from functools import cached_property
from typing import Any, Protocol

import numpy as np
import numpy.typing as npt

from ...kernels.tables import Floats, Ints, Longs, Tables
from ..coincidence import Remainders
from ..row_layout import BALLS, ENTRIES, FACES, SPHERES, SURFACES, RowLayout
from .pieces import SplicePieces

Array = npt.NDArray[Any]


class SpliceSide(Protocol):
    """One of the two scenes, lowered."""

    @property
    def tables(self) -> Tables: ...

    @property
    def rest(self) -> Remainders: ...

    @property
    def layout(self) -> Any: ...


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
