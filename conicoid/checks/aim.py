"""Rays for a check: through the whole scene, through every body, and where boxes of two bodies overlap."""

from __future__ import annotations

from dataclasses import dataclass
from typing import Any

import numpy as np
import numpy.typing as npt

from ..engine.lowering import Lowered
from ..shapes.vector import FloatArray

Indices = npt.NDArray[np.int64]

_MOST_PAIRS = 100_000
_ALONG_AXES = 0.25
_BACK = 2.0
"""Rays start so many sizes of what they are aimed at away from it."""


@dataclass(frozen=True)
class Targets:
    """Boxes of all bodies, (n, 3) low and high, and of the part of space that is looked at."""

    low: FloatArray
    high: FloatArray
    window: tuple[FloatArray, FloatArray]

    @classmethod
    def of(cls, lowered: Lowered) -> Targets:
        return cls(lowered.boxes[:, :3], lowered.boxes[:, 3:], _window(lowered))

    @property
    def sizes(self) -> FloatArray:
        """(n,) diagonals of the boxes, cut to the window; 0 for empty ones."""
        low, high = self._cut(np.arange(len(self.low)))
        result: FloatArray = np.linalg.norm(np.maximum(high - low, 0.0), axis=1)
        return result

    @property
    def empty(self) -> Any:
        """(n,) bool: boxes that hold nothing."""
        return (self.low > self.high).any(axis=1)

    def _cut(self, bodies: Indices) -> tuple[FloatArray, FloatArray]:
        """Boxes of bodies, infinite ends moved to the window's."""
        low, high = self.low[bodies], self.high[bodies]
        first, last = self.window
        return np.where(np.isfinite(low), low, np.minimum(first, high)), np.where(
            np.isfinite(high), high, np.maximum(last, low)
        )

    def box(self, body: int) -> tuple[FloatArray, FloatArray]:
        """The box of one body; low > high if it is empty. Infinite ends lie as far from 0 as the window reaches."""
        low, high = self.low[body], self.high[body]
        if (low > high).any():
            return low, high
        first, last = self.window
        far = np.abs([first, last]).max()
        size = float((last - first).max())
        return np.where(np.isfinite(low), low, np.minimum(-far, high - size)), np.where(
            np.isfinite(high), high, np.maximum(far, low + size)
        )

    def endless(self, body: int) -> bool:
        """Is some end of a body's box infinite?"""
        return not (np.isfinite(self.low[body]).all() and np.isfinite(self.high[body]).all())

    def common(self, one: Indices, other: Indices) -> tuple[FloatArray, FloatArray]:
        """The common boxes of pairs of bodies; low > high where there is none."""
        (a, b), (c, d) = self._cut(one), self._cut(other)
        return np.maximum(a, c), np.minimum(b, d)

    def pairs(self) -> tuple[Indices, Indices]:
        """Pairs of bodies whose boxes meet, at most about 100 000: those next to each other along x first."""
        order = np.argsort(self.low[:, 0], kind="stable")
        order = order[~self.empty[order]]
        low, high = self.low[order], self.high[order]
        found: list[tuple[Indices, Indices]] = []
        count = 0
        for apart in range(1, len(order)):
            if count > _MOST_PAIRS or not (low[apart:, 0] <= high[:-apart, 0]).any():
                break
            met = np.flatnonzero(((low[apart:] <= high[:-apart]) & (low[:-apart] <= high[apart:])).all(axis=1))
            count += len(met)
            found.append((order[met], order[met + apart]))
        none = np.zeros(0, np.int64)
        return np.concatenate([none, *(a for a, _ in found)]), np.concatenate([none, *(b for _, b in found)])

    def through_window(self, count: int, random: np.random.Generator) -> tuple[FloatArray, FloatArray]:
        """Rays (origins, directions) through random points of the window."""
        low, high = self.window
        return rays_through(np.tile(low, (count, 1)), np.tile(high, (count, 1)), random)

    def through_bodies(self, bodies: Indices, random: np.random.Generator) -> tuple[FloatArray, FloatArray]:
        """A ray through a random point of each body's box."""
        return rays_through(*self._cut(bodies), random)


def rays_through(low: FloatArray, high: FloatArray, random: np.random.Generator) -> tuple[FloatArray, FloatArray]:
    """A ray through a random point of each box (n, 3), from outside of it; a quarter of them along the axes."""
    points = low + (high - low) * random.random(low.shape)
    directions = random.normal(size=low.shape)
    directions /= np.linalg.norm(directions, axis=1, keepdims=True)
    along = np.flatnonzero(random.random(len(low)) < _ALONG_AXES)
    directions[along] = np.eye(3)[random.integers(0, 3, len(along))]
    sizes = np.linalg.norm(high - low, axis=1, keepdims=True)
    back = _BACK * np.where(sizes > 0, sizes, np.abs(points).max(axis=1, keepdims=True, initial=1.0))
    return points - back * directions, directions


def _window(lowered: Lowered) -> tuple[FloatArray, FloatArray]:
    """Around all that is finite; where a body is infinite also around the anchors of surfaces, and somewhat larger."""
    boxes = lowered.boxes[(lowered.boxes[:, :3] <= lowered.boxes[:, 3:]).all(axis=1)]
    points = np.concatenate([boxes[:, :3], boxes[:, 3:]])
    endless = not len(points) or not np.isfinite(points).all()
    if endless:
        tables = lowered.tables
        points = np.concatenate([points, tables.planes[:, 4:7], tables.spheres[:, :3], tables.quadrics[:, :3]])
    finite = np.isfinite(points)
    low = np.where(finite, points, np.inf).min(axis=0, initial=np.inf)
    high = np.where(finite, points, -np.inf).max(axis=0, initial=-np.inf)
    low, high = np.where(low <= high, low, 0.0), np.where(low <= high, high, 0.0)
    if endless:
        margin = float(max((high - low).max(), 1e-3 * np.abs([low, high]).max())) or 1.0
        low, high = low - margin, high + margin
    return low, high
