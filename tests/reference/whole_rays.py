"""Rays of small whole numbers, towards the corners, edges, axes and centers of bodies."""

from collections.abc import Iterator, Sequence
from typing import Any

import numpy as np

from .forms import chain
from .items import Item
from .random_shapes import Random
from .trace import Array

NAMES = ("start", "end", "center", "low", "high", "a", "b", "c", "reference")


def places(items: Sequence[Item]) -> Array:
    """Return points of the items' numbers, in the world, as floats, or of the lattice about them where they have none."""
    found = [(0.0, 0.0, 0.0)]
    for item in items:
        found += _named(item)
    points = np.array(found)
    nearly = np.round(points * 4) / 4
    return np.unique(nearly[np.isfinite(nearly).all(axis=1) & (np.abs(nearly) < 64).all(axis=1)], axis=0)


def _named(item: Item) -> Iterator[tuple[float, ...]]:
    own: list[Any] = [item.parameters[name] for name in NAMES if isinstance(item.parameters.get(name), (tuple, list))]
    for name in ("vertices", "centers"):
        own += list(item.parameters.get(name, ()))
    if item.kind == "Box":
        low, high = item.parameters["low"], item.parameters["high"]
        own += [tuple(pair[(k >> i) & 1] for i, pair in enumerate(zip(low, high, strict=True))) for k in range(8)]
    for operand in item.operands:
        own += list(_named(operand))
    motion = chain(item.exact_steps)
    rows, shift = [[float(x) for x in row] for row in motion.rows], [float(x) for x in motion.shift]
    for p in own:
        yield tuple(sum(k * c for k, c in zip(row, p, strict=True)) + s for row, s in zip(rows, shift, strict=True))


def directions(r: Random, count: int) -> Array:
    """Return whole directions, many along axes and diagonals."""
    d = r.integers(-3, 4, (count, 3)).astype(float)
    simple = r.integers(-1, 2, (count, 3)).astype(float)
    d = np.where(r.random((count, 1)) < 0.5, simple, d)
    axes = np.eye(3)[r.integers(3, size=count)] * r.choice([-1.0, 1.0], (count, 1))
    return np.where(d.any(axis=1, keepdims=True), d, axes)


def whole_rays(r: Random, items: Sequence[Item], count: int) -> tuple[Array, Array]:
    """Return rays, half of them through or between points of the items' numbers; t of such a point is a whole number."""
    d = directions(r, count)
    origins = r.integers(-6, 7, (count, 3)) / r.choice([1.0, 1.0, 2.0], (count, 1))
    near = places(items)
    target = near[r.integers(len(near), size=count)]
    other = near[r.integers(len(near), size=count)]
    target = np.where(r.random((count, 1)) < 0.3, (target + other) / 2, target)
    target = np.where(r.random((count, 1)) < 0.2, np.round(target), target)
    aimed = target - d * r.choice([0.0, 1.0, 2.0, 3.0, -1.0, 1.5], (count, 1))
    return np.where(r.random((count, 1)) < 0.55, aimed, origins), d


def picture(r: Random, items: Sequence[Item], side: int) -> tuple[Array, Array]:
    """Return side² rays of a camera, row by row: parallel ones on a lattice, or from one point through a lattice."""
    u, v = np.meshgrid(np.arange(side) - side // 2, np.arange(side) - side // 2)
    along = int(r.integers(3))
    across, up = (np.eye(3)[(along + k) % 3] for k in (1, 2))
    step = float(r.choice([0.25, 0.5, 0.125]))
    lattice = (u.ravel()[:, None] * across + v.ravel()[:, None] * up) * step
    near = places(items)
    target = near[int(r.integers(len(near)))]
    depth = np.eye(3)[along] * float(r.choice([-4.0, 4.0]))
    if r.random() < 0.5:
        return target - depth + lattice, np.broadcast_to(depth / 4, lattice.shape).copy()
    return np.broadcast_to(target - depth, lattice.shape).copy(), depth + lattice


def nudged(r: Random, origins: Array, d: Array) -> tuple[Array, Array]:
    """Return the same rays with one number of each a little off."""
    origins, d = origins.copy(), d.copy()
    for values, share in ((origins, 0.6), (d, 0.5)):
        rows = np.flatnonzero(r.random(len(d)) < share)
        columns = r.integers(3, size=len(rows))
        off = r.choice([-1.0, 1.0], len(rows)) * 2.0 ** -r.choice([20, 40, 49, 50, 51, 52, 60, 100], len(rows))
        off = off * np.maximum(np.abs(values[rows, columns]), 2.0**-8)
        values[rows, columns] += off
    return origins, d


def whole_points(r: Random, items: Sequence[Item], count: int) -> Array:
    near = places(items)
    points = r.integers(-8, 9, (count, 3)) / r.choice([1.0, 2.0, 4.0], (count, 1))
    on = near[r.integers(len(near), size=count)]
    step = r.integers(-1, 2, (count, 3)) * r.choice([0.0, 0.5, 1.0], (count, 1))
    return np.where(r.random((count, 1)) < 0.5, on + step, points)
