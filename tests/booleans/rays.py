"""Rays for Boolean trees: at random, and along a grid through its faces, edges and corners."""

from __future__ import annotations

from typing import Any

import numpy as np


def random_rays(r: np.random.Generator, count: int, reach: float = 2.5) -> tuple[Any, Any]:
    targets = r.uniform(-reach, reach, (count, 3))
    directions = r.normal(size=(count, 3)) * 10 ** r.uniform(-1, 1, (count, 1))
    origins = targets - r.uniform(0, 5, (count, 1)) * directions / np.linalg.norm(directions, axis=1, keepdims=True)
    return origins, directions


def grid_rays(r: np.random.Generator, count: int, reach: int = 4) -> tuple[Any, Any]:
    """Return rays between points with whole and half coordinates, which pass exactly through faces, edges and corners."""
    targets = r.integers(-2 * reach, 2 * reach + 1, (count, 3)) / 2
    directions = r.integers(-2, 3, (count, 3)).astype(float)
    directions[(directions == 0).all(axis=1)] = (1, 1, 1)
    return targets - 8 * directions, directions


def mixed_rays(r: np.random.Generator, count: int) -> tuple[Any, Any]:
    """Return random rays and grid rays, half of each, and rays from corner to corner with a small random turn."""
    one, other, third = random_rays(r, count // 3), grid_rays(r, count // 3), grid_rays(r, count - 2 * (count // 3))
    near = third[1] + r.normal(size=third[1].shape) * 10 ** r.uniform(-16, -1, (len(third[1]), 1))
    return np.concatenate([one[0], other[0], third[0]]), np.concatenate([one[1], other[1], near])
