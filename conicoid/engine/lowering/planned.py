"""Boolean bodies that are built alike: listed one by one, or many in one entry."""

from __future__ import annotations

from dataclasses import dataclass, field
from typing import Any

import numpy as np

from ...shapes.bulk import Bulk
from ...shapes.motion import Motion
from ...shapes.region import Boolean
from ..tables import Floats, Ints
from .pattern import FRAME_NUMBERS
from .plan import Plan, plan_of

_IN_PLACE = np.array([1.0, 0, 0, 0, 0, 1, 0, 0, 0, 0, 1, 0])


@dataclass
class Planned:
    """Boolean bodies that are built alike: shapes, and their plans but for their own motions; numbers.

    Then the places of their first leaves, and frames.
    """

    shapes: list[Boolean] = field(default_factory=list)
    plans: list[Plan] = field(default_factory=list)
    numbers: list[int] = field(default_factory=list)
    first: Ints = field(default_factory=lambda: np.zeros(0, np.int32))
    frames: Ints = field(default_factory=lambda: np.zeros(0, np.int32))

    def some(self, begin: int, end: int) -> Planned:
        """Some of the bodies, before they have places."""
        return Planned(self.shapes[begin:end], self.plans[begin:end], self.numbers[begin:end])

    def of(self, index: int) -> tuple[Boolean, Plan]:
        """One of the bodies, and its plan."""
        plan = plan_of(self.shapes[index])
        assert plan is not None
        return self.shapes[index], plan

    def frames_of(self, rows: Ints, known: Floats) -> Floats:
        """World to own coordinates of each body, from rows of those that are known; the others stand, or are shifted.

        Nothing is rounded in a translation, so its way back is the offset turned over, as in `Motion.inverse_rows`.
        """
        if len(known):
            found = known[rows]
        else:
            found = np.empty((len(rows), FRAME_NUMBERS))
        plain = np.flatnonzero(rows < 0)
        found[plain] = _IN_PLACE
        shifted = [place for place in plain.tolist() if self.shapes[place].motion.steps]
        found[shifted, 3::4] = -np.array([self.shapes[place].motion.shift for place in shifted]).reshape(-1, 3)
        return found

    def columns(self) -> tuple[Ints, Ints, Ints]:
        """Numbers, places and frames as arrays."""
        return np.array(self.numbers, np.int32), self.first, self.frames


@dataclass
class Many:
    """Many Boolean bodies in one entry: the number of the first, the place of its first leaf, and the frame of all."""

    shape: Bulk
    number: int
    first: int
    frame: int

    def of(self, index: int) -> tuple[Boolean, Plan]:
        """`Planned.of`"""
        shape = self.shape.single(index)
        assert isinstance(shape, Boolean)
        plan = plan_of(shape)
        assert plan is not None
        return shape, plan

    def frames_of(self, rows: Ints, known: Floats) -> Floats:
        """`Planned.frames_of`"""
        own = known[self.frame] if self.frame >= 0 else frame_of(self.shape.motion)
        return np.broadcast_to(own, (len(rows), FRAME_NUMBERS))

    def columns(self) -> tuple[Ints, Ints, Ints]:
        """`Planned.columns`"""
        count, leaves = len(self.shape), len(self.shape.leaves)
        every = np.arange(count, dtype=np.int32)
        return self.number + every, self.first + leaves * every, np.full(count, self.frame, np.int32)


def is_more(motion: Motion) -> bool:
    """Is it more than a translation?"""
    steps = motion.steps
    return len(steps) > 1 or (len(steps) == 1 and motion.shift is None)


def frame_of(motion: Motion) -> Any:
    """World to own coordinates of a body whose motion is a translation, or none."""
    return np.array(Motion(motion.steps).inverse_rows).ravel() if motion.steps else _IN_PLACE
