"""Points and planes carried by motions, every number rounded once: many by one motion, from recordings."""

from __future__ import annotations

from collections.abc import Callable, Sequence
from typing import Any

import numpy as np

from ...shapes import exact as ex
from ...shapes.motion import Motion
from ...shapes.recorder import Tape
from ...shapes.surface import PlaneSurface
from ..tables import PLANE_SIZE, Floats, Signs
from ..tapes.play import Given
from . import recordings
from .motions import Motions, given_motion
from .records import floats, rests, rounded_record

POINT = 3
"""Numbers of a point."""


class Carried:
    """Carries points and planes whose numbers are floats; what it has carried it knows."""

    def __init__(self) -> None:
        self._motions: dict[Motion, tuple[Given, Signs]] = {}
        self._known: dict[tuple[Motion, bytes], Floats] = {}

    def points(self, motion: Motion, points: Floats) -> Floats:
        """(n, 6): where it takes points (n, 3), and what rounding took from that."""
        key = motion, points.tobytes()
        if key not in self._known:
            self._known[key] = self._played("point", _point, motion, points)
        return self._known[key]

    def planes(self, motion: Motion, planes: Floats) -> Floats:
        """(n, 15) of records of planes (n, 7) from which nothing was rounded: records, their rests, and senses."""
        return self._played("plane", _plane, motion, planes)

    def _played(self, name: str, carried: Callable[[Motion, Any], Sequence[Any]], motion: Motion, of: Floats) -> Floats:
        """What carrying gives for each row, all of one length."""
        given, similar = self._given(motion)

        def record(which: int, tape: Tape) -> None:
            row = of[which].tolist()
            moved = given_motion(tape, bool(similar[0] == 1), motion)
            for number in carried(moved, [tape.input(x) for x in row]):
                tape.write(number)

        found: Any = None
        results, left = recordings.RECORDINGS.play(
            ("carried", name, int(similar[0])), record, of, given, np.zeros(len(of), np.int32)
        )
        for _, which, played in results:
            found = np.empty((len(of), played.floats.shape[1])) if found is None else found
            found[which] = played.floats
        for row in left.tolist():
            numbers = [float(x) for x in carried(motion, of[row].tolist())]
            found = np.empty((len(of), len(numbers))) if found is None else found
            found[row] = numbers
        return found

    def _given(self, motion: Motion) -> tuple[Given, Signs]:
        """The numbers of a motion; 1 where it is a similarity."""
        if motion not in self._motions:
            motions = Motions()
            motions.row(motion.steps, recordings.FEWEST)
            self._motions[motion] = motions.work_out()[:2]
        return self._motions[motion]


def _point(motion: Motion, numbers: Sequence[Any]) -> Sequence[Any]:
    """Where it takes a point, and the rests."""
    place = motion.carried(ex.exact_row(numbers))
    return *floats(place), *rests(place)


def _plane(motion: Motion, numbers: Sequence[Any]) -> Sequence[Any]:
    """The record of a plane that had one, the rests, and the sense of its normal."""
    normal, over, anchor = tuple(numbers[:3]), numbers[3], tuple(numbers[4:PLANE_SIZE])
    offset = ex.dot(ex.exact_row(normal), ex.exact_row(anchor), -ex.exact(over))
    record = rounded_record(PlaneSurface(normal, offset, anchor, over).moved(motion))
    return *record.numbers, *record.rests, record.sense
