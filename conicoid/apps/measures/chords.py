"""Moments and area from exact chords along the three axes of a box.

Three families of parallel rays. The moments of a chord are polynomials of its ends. Every crossing
adds |n·a| for the family along a: its line density over an element dS of the surface is |n·a| dS, and
Σ (n·a)² = 1 over three orthogonal a, so the sum is the area. (Crofton's formula with the lines
weighted by their cosine: it leaves two dimensions to sample instead of four.)

Errors come from the differences among the rays of one rectangle; nothing else is assumed.
"""

from __future__ import annotations

from collections.abc import Callable, Iterator
from dataclasses import dataclass
from typing import TYPE_CHECKING, Any

import numpy as np

from ..._util.arrays import FloatArray, dot_rows, matmul_rows
from ..._util.validation import SMALLEST
from ...geometry.shape import Shape
from ...kernels.entry.crossings import row_owners
from ...parallel.scheduler import prepare_first
from ...queries.extensions import extension
from .hull import FittedBox, Hull, Rectangles, ViewDirection, directions_for, hull_of
from .parallel import follow_on_workers

if TYPE_CHECKING:
    from ...parallel.workers import Workers
    from ...queries.scene_protocol import SceneLike


VOLUME, FIRST, SECOND, AREA = 0, slice(1, 4), slice(4, 10), 10
"""Places of 1, (x, y, z), (xx, xy, xz, yy, yz, zz) integrated over the volume, and of the area."""

PAIRS = ((0, 0), (0, 1), (0, 2), (1, 1), (1, 2), (2, 2))

CHUNK = 1 << 14
"""Rays at a time."""

Progress = Callable[[int, int], Any]


@dataclass
class ChordSums:
    """Integrals (11,) about the center of the box, along its axes, their covariance (11, 11), and rays followed."""

    values: FloatArray
    covariance: FloatArray
    rays: int = 0


@dataclass(frozen=True)
class AxisRays:
    """Rays along one axis of a box."""

    box: FittedBox
    axis: int

    def integrals(self, scene: SceneLike, places: FloatArray) -> FloatArray:
        """What each ray adds for a unit of the area across, (n, 11); places (n, 2) across the axis."""
        axis, across = self.axis, [i for i in range(3) if i != self.axis]
        start = np.zeros((len(places), 3))
        start[:, across] = places
        ray, t, sign, cosine = _crossings(
            scene, _snap_origins(matmul_rows(start, self.box.axes.T) + self.box.center), self.box.axes[:, axis]
        )
        # ∫ t^k dt over the chords, k = 0, 1, 2, from their ends; each volume is found three times
        length, first, second = (np.bincount(ray, sign * t**k / (3 * k), len(places)) for k in (1, 2, 3))
        powers = np.empty((3, len(places)))
        powers[axis] = first
        powers[across] = places.T * length
        result = np.empty((len(places), 11))
        result[:, VOLUME], result[:, FIRST] = length, powers.T
        for k, (i, j) in enumerate(PAIRS):
            along, fixed = (i, j) if i == axis else (j, i)
            result[:, 4 + k] = second if i == j == axis else powers[along] * start[:, fixed]
        result[:, AREA] = np.bincount(ray, cosine, len(places))
        return result


@dataclass
class ChordFamily:
    """Rays along one axis of the box; those of all families together end at the `last` of `total`.

    They go in pieces, each with random numbers of its own, whose sums are added in order: what comes out is the same
    wherever the pieces are followed.
    """

    scene: SceneLike
    box: FittedBox
    sight: ViewDirection
    seed: int
    sums: ChordSums
    last: int
    progress: Progress | None
    total: int
    workers: Workers | None = None

    @property
    def left(self) -> int:
        """Rays still to be followed."""
        return self.last - self.sums.rays

    def estimate(self, rectangles: Rectangles, count: int) -> None:
        """Add what `count` random rays through each rectangle find."""
        pieces = rectangles.pieces(CHUNK // count + 1)
        items = ((len(part) * count, (self.seed, begin, part, count)) for begin, part in pieces)
        for values, covariance in self._followed(_estimate_piece, items):
            self.sums.values += values
            self.sums.covariance += covariance

    def ranges(self, rectangles: Rectangles) -> FloatArray:
        """How much volume and area differ among the corners of each rectangle, as shares of their sums."""
        corners = (rectangles.low[:, None] + rectangles.size[:, None] * _CORNERS).reshape(-1, 2)
        # Neighbours share corners: follow each once
        half = np.delete(self.box.half, self.sight.axis)
        with np.errstate(invalid="ignore"):
            key = np.nan_to_num((corners + half) / (2 * half) * 2.0**30).round().astype(np.int64) @ (2**31, 1)
        _, first, back = np.unique(key, return_index=True, return_inverse=True)
        places = (corners[first[begin : begin + CHUNK]] for begin in range(0, len(first), CHUNK))
        found = [np.zeros((0, 2)), *self._followed(_chords_at_corners, ((len(some), some) for some in places))]
        ranges = np.ptp(np.concatenate(found)[back].reshape(-1, 4, 2), axis=1) * rectangles.areas[:, None]
        sums = ranges.sum(axis=0)
        result: FloatArray = (ranges / np.where(sums > 0, sums, 1.0)).sum(axis=1)
        return result

    def _followed(self, call: Callable[..., Any], items: Iterator[tuple[int, Any]]) -> Iterator[Any]:
        """call(scene, view, item) of each (rays, item), in order, here or on workers."""
        view = AxisRays(self.box, self.sight.axis)
        if self.workers is None:
            found: Iterator[tuple[int, Any]] = ((rays, call(self.scene, view, item)) for rays, item in items)
        else:
            found = follow_on_workers(self.workers, self.scene, view, call, items)
        for rays, value in found:
            self.sums.rays += rays
            if self.progress is not None:
                self.progress(min(self.sums.rays, self.last), self.total)
            yield value


@prepare_first
def _estimate_piece(
    scene: SceneLike, view: AxisRays, item: tuple[int, int, Rectangles, int]
) -> tuple[FloatArray, FloatArray]:
    """The sums (11,) of a piece of rectangles, and their covariance (11, 11)."""
    seed, begin, part, count = item
    random = np.random.default_rng((seed, view.axis, begin))
    places = part.low[:, None] + part.size[:, None] * random.random((len(part), count, 2))
    found = view.integrals(scene, places.reshape(-1, 2)).reshape(-1, count, 11) * part.areas[:, None, None]
    mean = found.mean(axis=1)
    apart = np.ascontiguousarray((found - mean[:, None]).reshape(-1, 11).T)
    covariance = np.empty((11, 11))
    for i in range(11):  # written out, as BLAS adds up in an order that depends on its threads
        for j in range(i + 1):
            covariance[i, j] = covariance[j, i] = (apart[i] * apart[j]).sum()
    return np.ascontiguousarray(mean.T).sum(axis=1), covariance / (count * (count - 1))


@prepare_first
def _chords_at_corners(scene: SceneLike, view: AxisRays, places: FloatArray) -> FloatArray:
    """Volume and area of rays, (n, 2)."""
    return np.ascontiguousarray(view.integrals(scene, places)[:, (VOLUME, AREA)])


def _snap_origins(points: FloatArray) -> FloatArray:
    """Origins of the domain: less than 1e-100 is 0."""
    return np.where(np.abs(points) < SMALLEST, 0.0, points)


_CORNERS = np.array([(0, 0), (0, 1), (1, 0), (1, 1)])


def _crossings(scene: SceneLike, origins: FloatArray, direction: FloatArray) -> Iterator[Any]:
    """ray, t, +1 where a solid is left and -1 where it is entered, and |normal·direction| of every crossing."""
    from ...queries.hit_fields import normals_of

    found = scene.crossings(origins, direction, t_min=-np.inf)
    ray = row_owners(found.offsets)
    points = origins[ray] + found.t[:, None] * direction
    normals = np.empty_like(points)
    faces = np.stack([found.surface, found.face, np.ones_like(found.face)])
    normals_of(scene.geometry, faces, points, 0, len(points), normals)
    solid = 0.0 if scene.bodies[0].shape.is_sheet else 1.0
    return iter((ray, found.t, np.where(found.entering, -solid, solid), np.abs(dot_rows(normals, direction))))


# Rectangles to send rays through: small where what rays find differs from corner to corner.

_FIRST = 16  # there is a first rectangle for so many rays
_THIN = 4  # or for so many, while hulls still take away much of the area
_CLEARLY_LESS = 0.9
_ROUNDS = 6
_SPLIT = 12  # at most one in so many rectangles is quartered in a round
_WORSE = 2.0  # those that differ by so many times the average
_CORNER_RAYS = 9  # around four quarters
_MOST = 1 << 19
"""Rectangles in memory; beyond, each gets more rays."""


def refine_rectangles(family: ChordFamily, hull: Hull) -> Rectangles:
    """Rectangles that cover the shape's shadow, in number about half of the family's rays that are left.

    The rays that decide this are not used again: what is estimated on the rectangles stays unbiased.
    """
    sight, most = family.sight, min(family.left, 2 * _MOST)
    rectangles = _covering(hull, family.box, sight, most)
    scores = family.ranges(rectangles) if len(rectangles) <= most // _FIRST else np.zeros(len(rectangles))
    for _ in range(_ROUNDS if scores.any() else 0):
        worst = np.argsort(-scores, kind="stable")[: max(1, len(scores) // _SPLIT)]
        worst = worst[scores[worst] > _WORSE * scores.mean()]
        if 2 * len(scores) + (6 + _CORNER_RAYS) * len(worst) > min(family.left, 2 * _MOST):
            break
        parts = hull.seen(rectangles[worst].halved().halved(), sight)
        scores = np.concatenate([np.delete(scores, worst), family.ranges(parts)])
        rectangles = rectangles.without(worst) + parts
    return _fill_rectangles(rectangles, hull, sight, min(family.left // 2, _MOST))


def _covering(hull: Hull, box: FittedBox, sight: ViewDirection, rays: int) -> Rectangles:
    """Equal rectangles that cover the shape's shadow along an axis; none where there is no shadow."""
    half = np.delete(box.half, sight.axis)[None]
    rectangles = hull.seen(Rectangles(-half, 2 * half), sight)
    while len(rectangles):
        smaller = hull.seen(rectangles.halved(), sight)
        thinner = smaller.areas.sum() < _CLEARLY_LESS * rectangles.areas.sum()
        if len(smaller) > rays // (_THIN if thinner else _FIRST) or not smaller.areas.all():
            break
        rectangles = smaller
    return rectangles


def _fill_rectangles(rectangles: Rectangles, hull: Hull, sight: ViewDirection, most: int) -> Rectangles:
    """All of them halved as often as `most` allows."""
    while len(rectangles):
        smaller = hull.seen(rectangles.halved(), sight)
        if len(smaller) > most or not smaller.areas.all():
            break
        rectangles = smaller
    return rectangles


# All integrals of a shape: three families of rays through its box.

_ROUNDING = 1e-14
"""No error is given as less than this part of the area, or of the volume times a power of the box's size."""


def sample_integrals(
    shape: Shape, box: FittedBox, rays: int, seed: int, progress: Progress | None, workers: Workers | None = None
) -> ChordSums:
    """Follow about `rays` rays, a third along each axis. A seed gives the same sums for any threads and workers."""
    sums = ChordSums(np.zeros(11), np.zeros((11, 11)))
    scene, directions = extension("Scene")([shape]), directions_for(shape, box)
    hull = hull_of(shape, box, directions)
    for axis in range(3):
        last, sight = (axis + 1) * rays // 3, ViewDirection.along(axis, directions)
        family = ChordFamily(scene, box, sight, seed, sums, last, progress, rays, workers)
        rectangles = refine_rectangles(family, hull)
        if len(rectangles):
            family.estimate(rectangles, max(2, family.left // len(rectangles)))
    if progress is not None:
        progress(rays, rays)
    reach = box.half.max() ** np.array([0, 1, 1, 1, 2, 2, 2, 2, 2, 2, 0])
    sizes = np.where(np.arange(11) == AREA, sums.values[AREA], sums.values[VOLUME]) * reach
    sums.covariance += np.diag((_ROUNDING * sizes) ** 2)
    return sums
