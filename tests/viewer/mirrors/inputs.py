"""Random inputs, and short binary fractions."""

from __future__ import annotations

import numpy as np

COUNT = 2048
FEW = 512
NO_SURFACE = -1


def records(count: int, *parts):
    """Return parts of one to four numbers, (count, k) or (count,) or one number, as records of float32.

    Each part begins a new record.
    """
    result = np.zeros((count, len(parts), 4), np.float32)
    for k, part in enumerate(parts):
        part = np.asarray(part, np.float32)
        part = np.broadcast_to(
            part[:, None] if part.shape == (count,) else part, (count, max(1, part.shape[-1] if part.ndim > 1 else 1))
        )
        result[:, k, : part.shape[1]] = part
    return result


def directions(rng, count: int):
    """Return unit vectors, some along an axis or in a plane of two."""
    d = rng.normal(size=(count, 3))
    axis, kind = rng.integers(0, 3, count), rng.integers(0, 8, count)
    d[np.arange(count), axis] *= kind != 0
    only = kind == 1
    d[only] = np.eye(3)[axis[only]] * rng.choice([-1, 1], only.sum())[:, None]
    return np.float32(d / np.linalg.norm(d, axis=1, keepdims=True)).astype(float)


def rays(rng, count: int, reach: float = 1.2):
    """Return three records: rays past the origin, from near and far, of any length, with intervals, without a start."""
    d = directions(rng, count)
    target = rng.uniform(-reach, reach, (count, 3))
    away = rng.choice([0.0, 0.5, 2.0, 8.0, 100.0], count, p=[0.2, 0.2, 0.3, 0.2, 0.1])
    length = 10.0 ** rng.choice([0, 0, 0, -2, 2], count)
    origin = np.where((away == 0)[:, None], target, target - away[:, None] * d)
    t_min = np.where(rng.random(count) < 0.5, 0.0, (away + rng.uniform(-1, 1, count)) / length)
    t_max = np.where(rng.random(count) < 0.7, 1e30, (away + rng.uniform(-0.5, 2, count)) / length)
    return [
        np.column_stack([origin, t_min]),
        np.column_stack([d * length[:, None], np.maximum(t_max, t_min + 1e-3)]),
        np.full((count, 1), NO_SURFACE),
    ]


RAY = ("vvvs", "vvvs", "----")
_ACROSS = np.array([(a, b) for a in (-1.25, -1, -0.75, 0, 0.75, 1, 1.25) for b in (-1.25, -1, -0.75, 0, 0.75, 1, 1.25)])
_RIGHT = [(a, b) for a, b in _ACROSS if a * b == 0 or {abs(a), abs(b)} == {0.75, 1.0}]


def exact_rays(rng, count: int):
    """Return rays along an axis, with roots of perfect squares, in steps of a quarter; half of them start on faces."""
    axis, sign = rng.integers(0, 3, count), rng.choice([-1.0, 1.0], count)
    origin, d = np.zeros((count, 3)), np.zeros((count, 3))
    across = np.array(_RIGHT)[rng.integers(0, len(_RIGHT), count)]
    rows = np.arange(count)
    origin[rows, (axis + 1) % 3], origin[rows, (axis + 2) % 3] = across[:, 0], across[:, 1]
    origin[rows, axis] = rng.choice([-3, -2, -1.25, -1, -0.75, -0.5, 0, 0.75, 1, 1.25, 3], count)
    d[rows, axis] = sign * rng.choice([0.5, 1.0, 2.0], count)
    t_min = rng.choice([-4, -1, 0, 0, 0, 0.5, 1, 2], count)
    t_max = t_min + rng.choice([1e30, 1e30, 0.25, 1, 2, 4], count)
    return [np.column_stack([origin, t_min]), np.column_stack([d, t_max]), np.full((count, 1), NO_SURFACE)]


def diagonal_rays(rng, count: int):
    """Return `exact_rays`, half of them along the diagonal of a square: they meet edges, crossing two planes at once."""
    o, d, start = exact_rays(rng, count)
    axis, rows = d[:, :3].nonzero()[1], np.arange(count)
    d[rows, (axis + 1) % 3] = d[rows, axis] * rng.choice([-1, 0, 1], count, p=[0.25, 0.5, 0.25])
    return [o, d, start]


def starting(rng, some_rays, surfaces):
    """Return the rays, a third of them with a surface to start on."""
    count = len(some_rays[2])
    start = np.where(rng.random(count) < 0.34, surfaces, NO_SURFACE)
    return [some_rays[0], some_rays[1], start[:, None].astype(float)]
