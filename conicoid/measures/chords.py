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
from .hull import Hull, Rectangles, Sight, directions_for, hull_of

if TYPE_CHECKING:
    from ..scene import Scene

CHUNK = 1 << 15
"""Rays at a time."""

VOLUME, FIRST, SECOND, AREA = 0, slice(1, 4), slice(4, 10), 10
"""Places of 1, (x, y, z), (xx, xy, xz, yy, yz, zz) integrated over the volume, and of the area."""

PAIRS = ((0, 0), (0, 1), (0, 2), (1, 1), (1, 2), (2, 2))

Progress = Callable[[int, int], Any]


ROUNDS = 6
SPLIT = 12
_COST = 16


@dataclass
class Sums:
    """Integrals (11,) about the center of the box, along its axes, and their covariance (11, 11)."""

    values: FloatArray
    covariance: FloatArray
    rays: int = 0


def sample(shape: Shape, box: FittedBox, rays: int, seed: int, progress: Progress | None) -> Sums:
    """Follow about `rays` rays, a third along each axis. The same seed gives the same numbers for any number of threads."""
    from ..scene import Scene

    sums = Sums(np.zeros(11), np.zeros((11, 11)))
    scene, directions = Scene([shape]), directions_for(shape, box)
    hull = hull_of(shape, box, directions)
    for axis in range(3):
        sight, last = Sight.along(axis, directions), (axis + 1) * rays // 3
        family = Family(
            scene, box, axis, seed, sums, lambda done, last=last: progress and progress(min(done, last), rays)
        )
        rectangles = refined(family, hull, sight, rays // 3)
        if len(rectangles):
            family.add(rectangles, max(2, (last - sums.rays) // len(rectangles)))
        if progress is not None:
            progress(last if axis < 2 else rays, rays)
    return sums


def refined(family: Family, hull: Hull, sight: Sight, rays: int) -> Rectangles:
    """Rectangles that cover the shape's shadow, smaller where what two rays of one find differs more.

    The rays that decide this are not used again: the estimates of the rectangles found stay unbiased.
    """
    rectangles = covering(hull, family.box, sight, max(1, int(rays / _COST)))
    budget = family.sums.rays + rays
    scores = family.ranges(rectangles)
    for _ in range(ROUNDS):
        worst = np.argsort(-scores, kind="stable")[: len(rectangles) // SPLIT]
        worst = worst[scores[worst] > 2 * scores.mean()]
        if not len(worst):
            break
        parts = rectangles[worst].halved().halved()
        parts = parts[hull.meets(parts, sight)]
        kept = np.delete(np.arange(len(rectangles)), worst)
        scores = np.concatenate([scores[kept], family.ranges(parts)])
        rectangles = rectangles[kept] + parts
    if len(rectangles):
        while True:
            smaller = rectangles.halved()
            smaller = smaller[hull.meets(smaller, sight)]
            if 2 * len(smaller) > budget - family.sums.rays or not smaller.size.all():
                break
            rectangles = smaller
    return rectangles


class Family:
    """Rays along one axis of the box."""

    def __init__(self, scene, box, axis, seed, sums, progress):
        self.scene, self.box, self.axis, self.seed, self.sums, self.progress = scene, box, axis, seed, sums, progress
        self.calls = 0

    def chunks(self, rectangles: Rectangles, count: int):
        self.calls += 1
        step = max(1, CHUNK // count)
        for begin in range(0, len(rectangles), step):
            random = np.random.default_rng((self.seed, self.axis, self.calls, begin))
            part = rectangles[begin : begin + step]
            places = part.low[:, None] + part.size[:, None] * random.random((len(part), count, 2))
            found = _chord_integrals(self.scene, self.box, self.axis, places.reshape(-1, 2))
            self.sums.rays += len(part) * count
            self.progress(self.sums.rays)
            yield part.size.prod(axis=1)[:, None], found.reshape(-1, count, 11)

    def differences(self, rectangles):
        scores = [np.zeros((0, 2))]
        for area, f in self.chunks(rectangles, 2):
            scores.append((area * np.abs(f[:, 0] - f[:, 1]))[:, (VOLUME, AREA)])
        s = np.concatenate(scores)
        m = s.sum(axis=0)
        return s[:, 0] / (m[0] or 1) + s[:, 1] / (m[1] or 1)

    def ranges(self, rectangles):
        """Range over corners times area."""
        if not len(rectangles):
            return np.zeros(0)
        offsets = np.array([(0, 0), (0, 1), (1, 0), (1, 1)])
        corners = (rectangles.low[:, None] + rectangles.size[:, None] * offsets).reshape(-1, 2)
        half = np.delete(self.box.half, self.axis)
        key = np.round((corners + half) / (2 * half) * 2.0**30).astype(np.int64)
        _, first, back = np.unique(key[:, 0] * 2**31 + key[:, 1], return_index=True, return_inverse=True)
        places = corners[first]
        vals = np.empty((len(places), 2))
        for b in range(0, len(places), CHUNK):
            vals[b : b + CHUNK] = _chord_integrals(self.scene, self.box, self.axis, places[b : b + CHUNK])[
                :, (VOLUME, AREA)
            ]
        self.sums.rays += len(places)
        self.progress(self.sums.rays)
        s = rectangles.size.prod(axis=1)[:, None] * np.ptp(vals[back].reshape(-1, 4, 2), axis=1)
        m = s.sum(axis=0)
        return s[:, 0] / (m[0] or 1) + s[:, 1] / (m[1] or 1)

    def add(self, rectangles, count):
        for area, f in self.chunks(rectangles, count):
            mean = f.mean(axis=1)
            apart = (area[:, None] * (f - mean[:, None])).reshape(-1, 11)
            self.sums.values += np.ascontiguousarray((area * mean).T).sum(axis=1)
            self.sums.covariance += (apart.T @ apart) / (count * (count - 1))


def covering(hull: Hull, box: FittedBox, sight: Sight, most: int) -> Rectangles:
    """At most `most` equal rectangles that cover the shape's shadow along an axis."""
    half = np.delete(box.half, sight.axis)[None]
    rectangles = Rectangles(-half, 2 * half)
    while len(rectangles):
        smaller = rectangles.halved()
        smaller = smaller[hull.meets(smaller, sight)]
        if len(smaller) > most or not smaller.size.all():
            break
        rectangles = smaller
    return rectangles


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


def _crossings(
    scene: Scene, origins: FloatArray, direction: FloatArray
) -> tuple[Any, FloatArray, FloatArray, FloatArray]:
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
