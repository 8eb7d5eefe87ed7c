"""The room that a body is in: a box around it, with space between, in any frame that its parts stand in."""

from __future__ import annotations

import math
from dataclasses import dataclass

import numpy as np

from ...shapes.base import Solid
from ...shapes.motion import STILL, Motion
from ...shapes.vector import Vector
from .exported import Unsayable
from .pieces import Cuboid


@dataclass(frozen=True)
class Room:
    """A box around a body in the world, and the motion that takes a frame there."""

    low: Vector
    high: Vector
    motion: Motion = STILL

    def within(self, motion: Motion) -> Room:
        """Seen from the frame of what is moved by `motion` into this one."""
        return Room(self.low, self.high, motion.then(self.motion)) if motion.steps else self

    @property
    def box(self) -> Cuboid:
        """Around the body in the frame, larger by its size on every side, of short numbers."""
        low, high = np.array(self.low), np.array(self.high)
        if self.motion.steps:
            corners = np.array([[(low, high)[k >> i & 1][i] for i in range(3)] for k in range(8)])
            rows = self.motion.inverse_matrix
            corners = corners @ rows[:3, :3].T + rows[:3, 3]
            low, high = corners.min(axis=0), corners.max(axis=0)
        size = float((high - low).max())
        step = 2.0 ** math.floor(math.log2(size)) / 2 if size > 0 else 1.0
        least, most = (np.floor(low / step) - 2) * step, (np.ceil(high / step) + 2) * step
        if not (np.isfinite(least).all() and np.isfinite(most).all()):
            raise OverflowError
        x, y, z = least.tolist()
        a, b, c = most.tolist()
        return Cuboid((x, y, z), (a, b, c))


def room_of(solid: Solid) -> Room:
    """Around a body. Raises Unsayable for one without an end, or with nothing in it."""
    low, high = solid.bounds
    if (low > high).any():
        raise Unsayable("there is nothing in it")
    if not (np.isfinite(low).all() and np.isfinite(high).all()):
        raise Unsayable("it has no end on some side: intersect it with a Box that is large enough")
    return Room(tuple(low.tolist()), tuple(high.tolist()))
