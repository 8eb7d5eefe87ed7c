"""Numbers for random shapes, over twelve decades of scale: sizes, places, directions, limits."""

from __future__ import annotations

from typing import Any

import numpy as np

Random = np.random.Generator


def floats(values: Any) -> tuple[float, ...]:
    return tuple(float(v) for v in values)


def direction(random: Random) -> np.ndarray:
    v = random.normal(size=3)
    return v / np.linalg.norm(v)


def scale(random: Random) -> float:
    """10^U(-6, 6)"""
    return float(10 ** random.uniform(-6, 6))


def place(random: Random, size: float) -> np.ndarray:
    """The origin, a point up to thirty sizes away, or one of up to a million."""
    far = random.choice([0.0, 1.5, 6.0], p=[0.3, 0.5, 0.2])
    return direction(random) * size * 10 ** random.uniform(-1, far) if far else np.zeros(3)


def span(random: Random, size: float) -> tuple[float, float]:
    low, high = np.sort(random.uniform(-1, 1, 2)) * size
    return float(low), float(high)


def near(random: Random, size: float) -> float:
    """A length within a factor of eight of `size`; one in ten far smaller, so that thin and flat shapes come too."""
    return float(size * (10 ** random.uniform(-5, -1) if random.random() < 0.1 else 2 ** random.uniform(-3, 0)))


def curvature(random: Random, size: float) -> float:
    """A coefficient A such that A x² = 1 at about x = size."""
    return 1 / near(random, size) ** 2
