"""Bodies of a lattice that is turned: one another moved before a motion that all of them have.

Before the motion they are lowered as all that are one another moved (`moved`), and few of their numbers differ. The
motion then carries anchors of curved surfaces, each once, and planes, each once; squares, rows and normals are those of
the first body. In the world, too, the bodies are one another moved, so they share what such bodies share.

Which of their surfaces are one is said by what they are before the motion, where it is seen without rounding.
"""

from __future__ import annotations

from dataclasses import dataclass
from typing import Any

import numpy as np

from ...shapes.base import Solid
from ...shapes.distinct import distinct_places
from ...shapes.motion import Motion
from ...shapes.repeated import Ints, Repeated, Shift, Shifts
from ..tables import MAP_SIZE, PLANE, PLANE_SIZE, SPHERE, Floats
from .alone import Alone
from .away import Away
from .carried import POINT, Carried
from .moved import SAME, moved_rows
from .moved_rows import Gathered, MovedRows
from .parts import Part, part_of
from .pattern import SIZES, Pattern
from .records import CENTERED

_TRIED = 3
"""Bodies of a kind that are worked out alone, to be compared."""


def rows_of_kind(
    bodies: Repeated, kind: int, numbers: Ints, alone: Alone, carried: Carried
) -> tuple[Pattern, MovedRows] | None:
    """The pattern and the rows of the bodies of a kind; None where they have to be lowered one by one."""
    motion = bodies.motion(kind)
    if motion.is_identity:
        return moved_rows(bodies, kind, numbers, alone)
    still = moved_rows(Before(bodies), kind, numbers, alone)
    if still is None:
        return None
    part = part_of(bodies.shape(int(numbers[0])))
    if part.pattern.kinds.tolist() != still[0].kinds.tolist() or part.paints:
        return None
    return _Turned(bodies, kind, numbers, part, still[0], still[1], alone, carried).rows()


@dataclass(frozen=True)
class Before:
    """Bodies before the motions of their kinds, as `moved_rows` asks for them."""

    bodies: Repeated

    @property
    def shifts(self) -> Shifts:
        """Those of the bodies."""
        return self.bodies.shifts

    @property
    def alone(self) -> dict[tuple[int, ...], Floats]:
        """What was worked out alone before."""
        return self.bodies.alone

    def is_rigid(self, kind: int) -> bool:
        """`Repeated.is_rigid`"""
        return self.bodies.is_rigid(kind)

    def made(self, kind: int, shift: Shift) -> Solid:
        """`Repeated.made`"""
        return self.bodies.before(kind, shift)

    def shape(self, number: int) -> Solid:
        """`Repeated.shape`"""
        return self.made(int(self.bodies.kinds[number]), self.shifts.of(number))


@dataclass
class _Turned:
    """One run of `rows_of_kind`."""

    bodies: Repeated
    kind: int
    numbers: Ints
    part: Part
    before: Pattern
    still: MovedRows
    alone: Alone
    carried: Carried

    def rows(self) -> tuple[Pattern, MovedRows] | None:
        """`rows_of_kind`"""
        pattern, away = self.part.pattern, Away.among(self.bodies, self.numbers)
        moved = MovedRows(np.array(self.part.row), away, boxes=(pattern.bounds_at, pattern.frame_at))
        for kind, column, sense in pattern.records:
            if not (self._plane(moved, column, sense) if kind == PLANE else self._curved(moved, kind, column)):
                return None
        ends = (pattern.uv_at, pattern.bounds_at, self.before.uv_at), (
            pattern.frame_at, pattern.corners_at, self.before.frame_at,
        )  # fmt: skip
        for begin, end, own in ends:
            for at in range(0, end - begin, MAP_SIZE):
                self._map(moved, begin + at, own + at)
        return (pattern, moved) if self._holds(moved) else None

    @property
    def motion(self) -> Motion:
        """That of the kind."""
        return self.bodies.motion(self.kind)

    def _curved(self, moved: MovedRows, kind: int, column: int) -> bool:
        """Carry the anchors of a surface of all bodies; False where rounding was in the way before."""
        form, size = self.still.forms.get(column), SIZES[kind]
        if form is None:
            return False
        coordinates = [self.still.distinct(column + axis) for axis in range(POINT)]
        first, index = _distinct(coordinates)
        points = np.stack([values[which[first]] for values, which in coordinates], axis=1) + 0.0
        found = self.carried.points(self.motion, points)
        if kind == SPHERE and (np.abs(found[:, POINT:]).max() > CENTERED * moved.base[column + POINT]):
            return False
        moved.gathered.append(Gathered(column, column + POINT, found[:, :POINT], index))
        moved.gathered.append(Gathered(column + size, column + size + POINT, found[:, POINT:], index))
        moved.names[column] = (self.motion, form), coordinates
        return True

    def _plane(self, moved: MovedRows, column: int, sense: int) -> bool:
        """Carry a plane of all bodies, each different one once: that of the first of those that have it."""
        leads, index = distinct_places(self.still.leads[column])
        records, which = self.still.of(leads, column, sense + 1), index.astype(np.int32)
        rests = records[:, PLANE_SIZE:-1]
        if rests.any():
            found = np.array([self._alone(lead)[column : sense + 1] for lead in leads.tolist()])
        else:
            found = self.carried.planes(self.motion, records[:, :PLANE_SIZE])
            found[:, -1] *= records[:, -1]
            normal = records[0, :POINT]
            along = np.flatnonzero(normal)
            if (
                len(along) == 1
                and not records[:, POINT].any()
                and (records[:, [0, 1, 2, -1]] == [*normal, records[0, -1]]).all()
            ):
                once = np.zeros(1), np.zeros(len(which), np.int32)
                place = records[:, POINT + 1 + along[0]], which
                moved.names[column] = ("plane", int(along[0]), self.motion), [place, once, once]
        moved.gathered.append(Gathered(column, sense + 1, found, which))
        if column not in moved.names:
            moved.leads[column] = leads[index].astype(np.int32)
        return True

    def _map(self, moved: MovedRows, at: int, own: int) -> None:
        """A row of an affine map: what is before it, the motion, is alike; its height moves as it did before."""
        values, index = self.still.maps(own)
        if len(values) > 1:
            first = self.still.of(np.zeros(1, np.int64), own, own + MAP_SIZE)[0]
            rows = np.tile(moved.base[at : at + MAP_SIZE], (len(values), 1))
            rows[:, -1] += values[:, -1] - first[-1]
            moved.gathered.append(Gathered(at, at + MAP_SIZE, rows, index))

    def _alone(self, which: int) -> Floats:
        """The numbers of one of the bodies but for its boxes, worked out alone; edited lists know them too."""
        number = int(self.numbers[which])
        x, y, z = self.bodies.shifts.index[:, number].tolist()
        known, place = self.bodies.alone, (-1 - self.kind, x, y, z)  # not those before the turn
        if place not in known:
            known[place] = self.alone.numbers(self.bodies.shape(number))
        return known[place]

    def _holds(self, moved: MovedRows) -> bool:
        """Are some bodies that are worked out alone as the rows say? Planes need not be, of which others have one."""
        pattern, count = self.part.pattern, len(moved)
        for which in {count - 1 - k * (count - 1) // _TRIED for k in range(_TRIED)}:
            some, found = np.array([which]), self._alone(which)
            told = np.concatenate(
                [moved.of(some, 0, pattern.bounds_at)[0], moved.of(some, pattern.frame_at, pattern.corners_at)[0]]
            )
            if told.shape != found.shape:
                return False
            for kind, column, sense in pattern.records:
                same: Any = told[column : sense + 1].view(np.int64) == found[column : sense + 1].view(np.int64)
                if not same[[0, 1, 2, -1] if kind == PLANE else slice(None)].all():
                    return False
            far = 1.0 + np.abs(found) + np.abs(moved.away[some]).max()
            if not (np.abs(told - found)[pattern.uv_at :] <= SAME * far[pattern.uv_at :]).all():
                return False
        return True


def _distinct(coordinates: list[tuple[Floats, Ints]]) -> tuple[Any, Ints]:
    """(the first thing of each different place, of each thing the number of its place)."""
    code = np.zeros(len(coordinates[0][1]), np.int64)
    for values, which in coordinates:
        code = code * len(values) + which
    _, first, index = np.unique(code, return_index=True, return_inverse=True)
    return first, index.astype(np.int32)
