"""Moments and area of a shape from exact chords along the three axes of a box.

There are three families of parallel rays. The moments of a chord are polynomials of its ends. Every crossing adds |n·a|
for the family along a: its line density over an element dS of the surface is |n·a| dS, and Σ (n·a)² = 1 over three
orthogonal a, so the sum is the area. (This is Crofton's formula with lines weighted by their cosine: it leaves two
dimensions to sample instead of four.) Errors come from the differences among rays of one rectangle alone.
"""

from __future__ import annotations

import itertools
from collections.abc import Callable, Iterator, Sequence
from dataclasses import dataclass
from typing import TYPE_CHECKING, Any

import numpy as np

from ..._util.arrays import FloatArray, dot_rows, matmul_rows
from ..._util.validation import SMALLEST
from ...geometry.shape import Shape
from ...kernels.crossings import row_owners
from ...parallel.scheduler import ScheduledTask, prepare_first, run_tasks
from ...parallel.shared_state import SharedObject, shared_scene
from ...parallel.workers import as_workers
from ...queries.result import extension
from .hull import FittedBox, Hull, Rectangles, ViewDirection, directions_for, hull_of

if TYPE_CHECKING:
    from ...parallel.workers import Workers
    from ...queries.scene_protocol import SceneLike


# Integrals along rays.

VOLUME, FIRST, SECOND, AREA = 0, slice(1, 4), slice(4, 10), 10
"""Places of the integrals of 1, (x, y, z), (xx, xy, xz, yy, yz, zz) over the volume, and of the area."""

PAIRS = ((0, 0), (0, 1), (0, 2), (1, 1), (1, 2), (2, 2))
"""Axes of the second moments, in order."""

CHUNK = 1 << 14
"""Rays of one query."""

Progress = Callable[[int, int], Any]
"""progress(done, total), in rays."""


@dataclass
class ChordSums:
    """Integrals (11,) about the center of the box along its axes, their covariance (11, 11), and the number of rays."""

    values: FloatArray
    covariance: FloatArray
    rays: int = 0


@dataclass(frozen=True)
class AxisRays:
    """Rays along one axis of a box."""

    box: FittedBox
    axis: int

    def integrals(self, scene: SceneLike, places: FloatArray) -> FloatArray:
        """Return the integrals (n, 11) per unit area across the axis of rays at places (n, 2) across it."""
        axis, across = self.axis, [i for i in range(3) if i != self.axis]
        # Places of rays in the frame of the box, whose center is the origin
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
            # A moment along the ray and across it is the first moment of the chord times the place
            along, fixed = (i, j) if i == axis else (j, i)
            result[:, 4 + k] = second if i == j == axis else powers[along] * start[:, fixed]
        result[:, AREA] = np.bincount(ray, cosine, len(places))
        return result


@dataclass
class ChordFamily:
    """Rays along one axis of the box, up to number `last` of the `total` rays of all families.

    They are traced in pieces, each with random numbers of its own, and sums of pieces are added in order: the result is
    the same wherever the pieces are traced.
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
    def remaining_rays(self) -> int:
        """Rays that are still to be traced."""
        return self.last - self.sums.rays

    def estimate(self, rectangles: Rectangles, count: int) -> None:
        """Add the integrals of `count` random rays through each rectangle."""
        # Pieces have about the same number of rays, and are numbered by their first rectangle
        pieces = rectangles.pieces(CHUNK // count + 1)
        items = ((len(part) * count, (self.seed, begin, part, count)) for begin, part in pieces)
        for values, covariance in self._piece_results(_estimate_piece, items):
            self.sums.values += values
            self.sums.covariance += covariance

    def ranges(self, rectangles: Rectangles) -> FloatArray:
        """Return how much length and area differ among the corners of each rectangle (n,), as shares of their sums."""
        corners = (rectangles.low[:, None] + rectangles.size[:, None] * _CORNERS).reshape(-1, 2)
        # Neighbours share corners: trace each once
        half = np.delete(self.box.half, self.sight.axis)
        with np.errstate(invalid="ignore"):
            # Corners as integers: equal ones differ by rounding
            key = np.nan_to_num((corners + half) / (2 * half) * 2.0**30).round().astype(np.int64) @ (2**31, 1)
        _, first, back = np.unique(key, return_index=True, return_inverse=True)
        places = (corners[first[begin : begin + CHUNK]] for begin in range(0, len(first), CHUNK))
        values = [np.zeros((0, 2)), *self._piece_results(_chords_at_corners, ((len(some), some) for some in places))]
        ranges = np.ptp(np.concatenate(values)[back].reshape(-1, 4, 2), axis=1) * rectangles.areas[:, None]
        sums = ranges.sum(axis=0)
        return (ranges / np.where(sums > 0, sums, 1.0)).sum(axis=1)

    def _piece_results(self, call: Callable[..., Any], items: Iterator[tuple[int, Any]]) -> Iterator[Any]:
        """Yield call(scene, view, item) of each (rays, item) in order, computed here or on workers."""
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
    """Return the sums (11,) over a piece of rectangles, and their covariance (11, 11)."""
    seed, begin, part, count = item
    random = np.random.default_rng((seed, view.axis, begin))
    places = part.low[:, None] + part.size[:, None] * random.random((len(part), count, 2))
    found = view.integrals(scene, places.reshape(-1, 2)).reshape(-1, count, 11) * part.areas[:, None, None]
    # The variance of each mean, from the differences within a rectangle
    mean = found.mean(axis=1)
    deviations = np.ascontiguousarray((found - mean[:, None]).reshape(-1, 11).T)
    covariance = np.empty((11, 11))
    for i in range(11):  # without BLAS, whose order of addition depends on its threads
        for j in range(i + 1):
            covariance[i, j] = covariance[j, i] = (deviations[i] * deviations[j]).sum()
    return np.ascontiguousarray(mean.T).sum(axis=1), covariance / (count * (count - 1))


@prepare_first
def _chords_at_corners(scene: SceneLike, view: AxisRays, places: FloatArray) -> FloatArray:
    """Return the chord length and the area of rays, (n, 2)."""
    return np.ascontiguousarray(view.integrals(scene, places)[:, (VOLUME, AREA)])


def _snap_origins(points: FloatArray) -> FloatArray:
    """Set components of origins below 1e-100 to 0, as rays refuse them."""
    return np.where(np.abs(points) < SMALLEST, 0.0, points)


_CORNERS = np.array([(0, 0), (0, 1), (1, 0), (1, 1)])


def _crossings(scene: SceneLike, origins: FloatArray, direction: FloatArray) -> Iterator[Any]:
    """Return the ray, t, the sign and |normal·direction| of every crossing.

    The sign is +1 where a solid is left, -1 where it is entered, and 0 for a sheet.
    """
    from ...queries.hit_fields import normals_of

    found = scene.crossings(origins, direction, t_min=-np.inf)
    ray = row_owners(found.offsets)
    points = origins[ray] + found.t[:, None] * direction
    normals = np.empty_like(points)
    faces = np.stack([found.surface, found.face, np.ones_like(found.face)])
    normals_of(scene._prepared.geometry, faces, points, 0, len(points), normals)
    # A sheet has an area and no volume
    solid = 0.0 if scene.bodies[0].shape.is_sheet else 1.0
    return iter((ray, found.t, np.where(found.entering, -solid, solid), np.abs(dot_rows(normals, direction))))


# Rectangles to send rays through: small where integrals differ from corner to corner.

_FIRST = 16  # rays for each of the first rectangles
_THIN = 4  # the same while halving still removes much of the area
_CLEARLY_LESS = 0.9  # the area after a halving that removes much
_ROUNDS = 6
_SPLIT = 12  # at most one in so many rectangles is quartered in a round
_WORSE = 2.0  # a rectangle is quartered if its corners differ by so many times the average
_CORNER_RAYS = 9  # corners of four quarters
_MOST = 1 << 19
"""Rectangles in memory; if more would be wanted, each gets more rays."""


def refine_rectangles(family: ChordFamily, hull: Hull) -> Rectangles:
    """Return rectangles that cover the shape's shadow, about half as many as the rays that the family has left.

    The rays that choose the rectangles are not used again, so that estimates on the rectangles stay unbiased.
    """
    sight, most = family.sight, min(family.remaining_rays, 2 * _MOST)
    rectangles = _covering_rectangles(hull, family.box, sight, most)
    # Without rays to spare for corners, all rectangles stay equal
    scores = family.ranges(rectangles) if len(rectangles) <= most // _FIRST else np.zeros(len(rectangles))
    for _ in range(_ROUNDS if scores.any() else 0):
        worst = np.argsort(-scores, kind="stable")[: max(1, len(scores) // _SPLIT)]
        worst = worst[scores[worst] > _WORSE * scores.mean()]
        if 2 * len(scores) + (6 + _CORNER_RAYS) * len(worst) > min(family.remaining_rays, 2 * _MOST):
            break
        # Halved twice: the quarters of the rectangles that differ most
        parts = hull.visible_rectangles(rectangles[worst].halved().halved(), sight)
        scores = np.concatenate([np.delete(scores, worst), family.ranges(parts)])
        rectangles = rectangles.without(worst) + parts
    return _fill_rectangles(rectangles, hull, sight, min(family.remaining_rays // 2, _MOST))


def _covering_rectangles(hull: Hull, box: FittedBox, sight: ViewDirection, rays: int) -> Rectangles:
    """Return equal rectangles that cover the shape's shadow along an axis; none if there is no shadow."""
    half = np.delete(box.half, sight.axis)[None]
    rectangles = hull.visible_rectangles(Rectangles(-half, 2 * half), sight)
    while len(rectangles):
        smaller = hull.visible_rectangles(rectangles.halved(), sight)
        thinner = smaller.areas.sum() < _CLEARLY_LESS * rectangles.areas.sum()
        if len(smaller) > rays // (_THIN if thinner else _FIRST) or not smaller.areas.all():
            break
        rectangles = smaller
    return rectangles


def _fill_rectangles(rectangles: Rectangles, hull: Hull, sight: ViewDirection, most: int) -> Rectangles:
    """Return the rectangles, all halved as often as `most` allows."""
    while len(rectangles):
        smaller = hull.visible_rectangles(rectangles.halved(), sight)
        if len(smaller) > most or not smaller.areas.all():
            break
        rectangles = smaller
    return rectangles


# All integrals of a shape: three families of rays through its box.

_ROUNDING = 1e-14
"""Errors are at least this part of the area, or of the volume times a power of the box's size."""


def sample_integrals(
    shape: Shape, box: FittedBox, rays: int, seed: int, progress: Progress | None, workers: Workers | None = None
) -> ChordSums:
    """Return the integrals of a shape from about `rays` rays, a third along each axis.

    A seed gives the same sums for any number of threads and workers.
    """
    sums = ChordSums(np.zeros(11), np.zeros((11, 11)))
    scene, directions = extension("Scene")([shape]), directions_for(shape, box)
    hull = hull_of(shape, box, directions)
    for axis in range(3):
        # The families share the rays: each goes on to its third of the total
        last, sight = (axis + 1) * rays // 3, ViewDirection.along(axis, directions)
        family = ChordFamily(scene, box, sight, seed, sums, last, progress, rays, workers)
        rectangles = refine_rectangles(family, hull)
        if len(rectangles):
            family.estimate(rectangles, max(2, family.remaining_rays // len(rectangles)))
    if progress is not None:
        progress(rays, rays)
    # The size of the box to the power that each integral has beyond the volume
    reach = box.half.max() ** np.array([0, 1, 1, 1, 2, 2, 2, 2, 2, 2, 0])
    sizes = np.where(np.arange(11) == AREA, sums.values[AREA], sums.values[VOLUME]) * reach
    sums.covariance += np.diag((_ROUNDING * sizes) ** 2)
    return sums


# On workers: each body of a scene is a task, or each few pieces of the rays through one shape

_ITEMS_A_TASK = 8
"""Pieces of a task, each of some ten milliseconds; the first tasks have one."""


def run_on_workers(
    call: Callable[..., Any], calls: Sequence[tuple[Any, ...]], executor: Any, progress: Progress | None
) -> list[Any]:
    """Return call(*arguments) for each tuple of arguments, in order."""
    workers = as_workers("measure", executor, progress)
    pieces = (ScheduledTask(i, i + 1, arguments) for i, arguments in enumerate(calls))
    with run_tasks("measure", workers, call, (), pieces, total=len(calls)) as results:
        return [value for _, value in results]


def follow_on_workers(
    workers: Workers, scene: Any, view: Any, call: Callable[..., Any], items: Iterator[tuple[int, Any]]
) -> Iterator[tuple[int, Any]]:
    """Yield (rays, call(scene, view, item)) for each (rays, item), in order."""
    # The scene, the call and the view go to each worker once, the items with each task
    shared = shared_scene(scene), SharedObject((call, view))
    with run_tasks("measure", workers, _run_items, shared, _pieces(items, 2 * workers.count)) as results:
        for piece, values in results:
            yield from zip(piece.note, values, strict=True)


def _pieces(items: Iterator[tuple[int, Any]], workers: int) -> Iterator[ScheduledTask]:
    """Yield tasks of one item for the first, so that all workers have one, and of several items for the others."""
    for place in itertools.count():
        chunk = list(itertools.islice(items, 1 if place < workers else _ITEMS_A_TASK))
        if not chunk:
            return
        yield ScheduledTask(place, place + 1, ([item for _, item in chunk],), note=[rays for rays, _ in chunk])


def _run_items(scene: Any, call_and_view: tuple[Callable[..., Any], Any], items: list[Any]) -> list[Any]:
    """Return call(scene, view, item) for each item of a task."""
    call, view = call_and_view
    return [call(scene, view, item) for item in items]
