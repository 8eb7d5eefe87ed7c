"""Moments and area from exact chords along the three axes of a box.

Three families of parallel rays, at two or more random places in each of many equal rectangles. The
moments of a chord are polynomials of its ends. Every crossing adds |n·a| for the family along a: its
line density over an element dS of the surface is |n·a| dS, and Σ (n·a)² = 1 over three orthogonal a,
so the sum is the area (Crofton's formula with the lines weighted by their cosine, which leaves two
dimensions to sample instead of four).

Errors come from the differences within each rectangle; there is no assumption beyond independence.
"""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import dataclass
from typing import TYPE_CHECKING, Any

import numpy as np

from ..shapes.base import Shape
from ..shapes.vector import FloatArray
from .frames import FittedBox
from .hull import cells_seen, directions_for, hull_of

if TYPE_CHECKING:
    from ..scene import Scene

CHUNK = 1 << 15
"""Rays at a time."""

VOLUME, FIRST, SECOND, AREA = 0, slice(1, 4), slice(4, 10), 10
"""Places of 1, (x, y, z), (xx, xy, xz, yy, yz, zz) integrated over the volume, and of the area."""

PAIRS = ((0, 0), (0, 1), (0, 2), (1, 1), (1, 2), (2, 2))

Progress = Callable[[int, int], Any]


@dataclass
class Sums:
    """Integrals (11,) about the center of the box, along its axes, and their covariance (11, 11)."""

    values: FloatArray
    covariance: FloatArray


def sample(shape: Shape, box: FittedBox, rays: int, seed: int, progress: Progress | None) -> Sums:
    """Follow about `rays` rays, a third along each axis. The same seed gives the same numbers for any number of threads."""
    from ..scene import Scene

    scene = Scene([shape])
    sums = Sums(np.zeros(11), np.zeros((11, 11)))
    directions = directions_for(shape, box)
    hull = hull_of(shape, box, directions)
    share, done = rays // 3, 0
    grids = [cells_seen(hull, box, axis, directions, share // 2) for axis in range(3)]
    counts = [max(2, share // max(1, len(low))) for low, _ in grids]
    total = sum(len(low) * count for (low, _), count in zip(grids, counts, strict=True))
    for axis, ((low, size), count) in enumerate(zip(grids, counts, strict=True)):
        step = max(1, CHUNK // count)
        for begin in range(0, len(low), step):
            random = np.random.default_rng((seed, axis, begin))
            corners = low[begin : begin + step]
            places = corners[:, None] + size * random.random((len(corners), count, 2))
            _add(sums, _chord_integrals(scene, box, axis, places.reshape(-1, 2)), count, float(size[0] * size[1]))
            done += len(corners) * count
            if progress is not None:
                progress(done, total)
    return sums


def _add(sums: Sums, integrals: FloatArray, count: int, area: float) -> None:
    """Add rectangles, each with `count` rays (rows one after the other)."""
    grouped = integrals.reshape(-1, count, 11)
    mean = grouped.mean(axis=1)
    apart = (grouped - mean[:, None]).reshape(-1, 11)
    sums.values += area * mean.sum(axis=0)
    sums.covariance += area * area / (count * (count - 1)) * (apart.T @ apart)


def _chord_integrals(scene: Scene, box: FittedBox, axis: int, places: FloatArray) -> FloatArray:
    """What each ray along an axis of the box adds, for a unit of the area across (n, 11)."""
    across = [i for i in range(3) if i != axis]
    start = np.zeros((len(places), 3))
    start[:, across] = places
    ray, t, sign, cosine = _crossings(scene, start @ box.axes.T + box.center, box.axes[:, axis])
    # ∫ t^k dt over the chords, k = 0, 1, 2, from their ends; each volume is found three times
    length, first, second = (np.bincount(ray, sign * t**k / (3 * k), len(places)) for k in (1, 2, 3))
    powers = np.empty((3, len(places)))
    powers[axis] = first
    powers[across] = places.T * length
    result = np.empty((len(places), 11))
    result[:, VOLUME], result[:, FIRST] = length, powers.T
    for k, (i, j) in enumerate(PAIRS):
        if i == j == axis:
            result[:, 4 + k] = second
        else:
            fixed, other = (j, i) if i == axis else (i, j)
            result[:, 4 + k] = powers[other] * start[:, fixed]
    result[:, AREA] = np.bincount(ray, cosine, len(places))
    return result


def _crossings(scene: Scene, origins: FloatArray, direction: FloatArray) -> tuple[Any, FloatArray, FloatArray, FloatArray]:
    """(ray, t, +1 where a solid is left and -1 where it is entered, |normal·direction|) of every crossing."""
    from ..trace.array_kernels import normals_of

    found = scene.crossings(origins, direction, t_min=-np.inf)
    ray = np.repeat(np.arange(len(origins)), np.diff(found.offsets))
    points = origins[ray] + found.t[:, None] * direction
    ids = np.column_stack([found.body, found.surface, found.face])
    normals = np.empty_like(points)
    normals_of(scene.geometry, ids, np.ones((len(ids), 2), np.int8), points, 0, len(ids), normals)
    solid = 0.0 if scene.bodies[0].shape.is_sheet else 1.0
    sign = np.where(found.entering, -solid, solid)
    return ray, found.t, sign, np.abs(normals @ direction)
