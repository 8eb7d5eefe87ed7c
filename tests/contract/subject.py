"""A shape under test with suitable rays."""

import math
import zlib
from functools import cached_property

import numpy as np

import conicoid as co

WINDOW = 6.0
"""Half the side of the window on an unbounded shape."""


class Subject:
    def __init__(self, name: str, shape, count: int = 300) -> None:
        self.name, self.shape, self.count = name, shape, count
        self.scene = co.Scene([shape])
        low, high = (np.asarray(x, dtype=float) for x in shape.bounds)
        self.bounded = bool(np.isfinite([low, high]).all())
        if not self.bounded and getattr(shape, "combines", False):
            # a complement of a finite solid is tested around that solid
            inner = np.asarray((~shape).bounds, dtype=float)
            if np.isfinite(inner).all():
                low, high = inner
        self.low, self.high = np.maximum(low, -WINDOW), np.minimum(high, WINDOW)
        self.size = float(np.linalg.norm(self.high - self.low))

    @property
    def random(self) -> np.random.Generator:
        """Return the same random numbers for every test of this subject, in any order of tests."""
        return np.random.default_rng(zlib.crc32(self.name.encode()))

    @cached_property
    def rays(self) -> tuple[np.ndarray, np.ndarray]:
        """Return rays from outside at random points of the box, from points in the box, and along the axes."""
        r, n = self.random, self.count
        targets = r.uniform(self.low - 0.02 * self.size, self.high + 0.02 * self.size, (n, 3))
        directions = r.normal(size=(n, 3)) * 10 ** r.uniform(-1, 1, (n, 1))
        along = r.random(n) < 0.2
        directions[along] = np.eye(3)[r.integers(0, 3, along.sum())] * r.choice([-1.0, 1.0], (along.sum(), 1))
        away = np.where(r.random(n) < 0.7, r.uniform(1, 30, n), 0)[:, None] * self.size
        return targets - away * directions / np.linalg.norm(directions, axis=1, keepdims=True), directions

    @property
    def speed(self) -> np.ndarray:
        return np.linalg.norm(self.rays[1], axis=1)

    @cached_property
    def whole_lines(self):
        """Return spans of the whole lines."""
        return self.scene.spans(*self.rays, t_min=-math.inf)

    def at(self, ray: np.ndarray, t: np.ndarray) -> np.ndarray:
        o, d = self.rays
        return o[ray] + t[:, None] * d[ray]

    def slack(self, ray: np.ndarray, t: np.ndarray) -> np.ndarray:
        """Return, in units of t and with a wide margin, how far rounding may shift a point."""
        travelled = np.abs(t) * self.speed[ray]
        reach = np.abs(self.rays[0][ray]).max(axis=1)
        return 1e-12 * (travelled + reach + self.size) / self.speed[ray]


def rows(answer) -> np.ndarray:
    """Return the flat ray index of every row of a CSR answer."""
    return np.repeat(np.arange(len(answer.offsets) - 1), np.diff(answer.offsets))
