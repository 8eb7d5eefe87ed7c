"""Moments and area of a shape from exact chords along the three axes of a box.

There are three families of parallel rays. The moments of a chord are polynomials of its ends. Every crossing adds |n·a|
for the family along a: its line density over an element dS of the surface is |n·a| dS, and Σ (n·a)² = 1 over three
orthogonal a, so the sum is the area. (This is Crofton's formula with lines weighted by their cosine: it leaves two
dimensions to sample instead of four.) Errors come from the differences among rays of one rectangle alone.
"""

from __future__ import annotations

import itertools
import math
from collections.abc import Callable, Iterator, Sequence
from typing import Any

import numpy as np

from ..._jit.decorators import inline, kernel
from ..._util.arrays import FloatArray, ignore_fp_errors
from ..._util.records import dataclass
from ..._util.validation import SMALLEST
from ...geometry.shape import Shape
from ...kernels.surface.records import normal_at
from ...kernels.tables import Flags, Floats, Geometry, Ints, Longs
from ...kernels.threads import run_calls, run_rows
from ...parallel.shared_state import SharedObject, shared_scene
from ...parallel.workers import ScheduledTask, Workers, as_workers, prepare_first, run_tasks
from ...queries.result import extension
from ...queries.scene_protocol import SceneLike
from .hull import FittedBox, Rectangles, Shadow, directions_for, hull_of

# Integrals along rays.

VOLUME, FIRST, SECOND, AREA = 0, slice(1, 4), slice(4, 10), 10
"""Places of the integrals of 1, (x, y, z), (xx, xy, xz, yy, yz, zz) over the volume, and of the area."""

PAIRS = ((0, 0), (0, 1), (0, 2), (1, 1), (1, 2), (2, 2))
"""Axes of the second moments, in order."""

CHUNK = 1 << 14
"""Rays of a piece, and of one query on a worker."""
_AT_ONCE = 16  # pieces whose results wait for each other in this process
_ROWS, _BLOCK = 1 << 11, 64  # rays that a thread takes at a time; rectangles whose sums are added first

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
        direction, count = np.ascontiguousarray(self.box.axes[:, self.axis]), len(places)
        origins, found = np.empty((count, 3)), np.empty((count, 11))
        run_rows(put_origins, (places, self.box.axes, self.box.center, self.axis), count, origins, most=_ROWS)
        hits = scene.crossings(origins, direction, t_min=-np.inf)
        # A sheet has an area and no volume
        solid = 0.0 if scene.bodies[0].shape.is_sheet else 1.0
        lists = hits.offsets, hits.t, hits.entering, hits.surface
        before = scene._prepared.geometry, origins, direction, places, *lists, self.axis, solid
        run_rows(integrate_chords, before, count, found, most=_ROWS)
        return found


@inline
def _across(axis: int) -> tuple[int, int]:
    """Return the two other axes."""
    return 1 if axis == 0 else 0, 1 if axis == 2 else 2


@kernel(places="n 2", axes="3 3", center="3", axis="0..2", begin="0..end", end="0..n", origins="out n 3")
def put_origins(
    places: Floats, axes: Floats, center: Floats, axis: int, begin: int, end: int, origins: Floats
) -> None:  # fmt: skip
    """Write origins in the world of rays begin..end, at places in the frame of a box, whose center is the origin."""
    a, b = _across(axis)
    for i in range(begin, end):
        for k in range(3):
            x = places[i, 0] * axes[k, a] + places[i, 1] * axes[k, b] + center[k]
            origins[i, k] = x if abs(x) >= SMALLEST else 0.0  # rays refuse smaller ones


@kernel(
    origins="n 3", direction="3", places="n 2", offsets="n+1", t="s", entering="s", surface="s", axis="0..2",
    begin="0..end", end="0..n", found="out n 11",
)  # fmt: skip
def integrate_chords(
    geometry: Geometry, origins: Floats, direction: Floats, places: Floats, offsets: Longs, t: Floats, entering: Flags,
    surface: Ints, axis: int, solid: float, begin: int, end: int, found: Floats,
) -> None:  # fmt: skip
    """Write the integrals of rays begin..end from their crossings; `solid` is 0 for a sheet, else 1.

    Those of t^k along the chords, k = 0, 1, 2, come from their ends; each volume is found three times.
    """
    a, b = _across(axis)
    dx, dy, dz = direction[0], direction[1], direction[2]
    place, moments = np.zeros(3), np.empty(3)
    for i in range(begin, end):
        length, first, second, area = 0.0, 0.0, 0.0, 0.0
        for row in range(max(0, offsets[i]), min(offsets[i + 1], len(t))):
            s, sign = t[row], -solid if entering[row] else solid
            x, y, z = origins[i, 0] + s * dx, origins[i, 1] + s * dy, origins[i, 2] + s * dz
            nx, ny, nz = normal_at(geometry, surface[row], 1, x, y, z)
            area += abs(nx * dx + ny * dy + nz * dz)
            length += sign * s / 3.0
            first += sign * (s * s) / 6.0
            second += sign * (s * s * s) / 9.0
        place[a], place[b] = places[i, 0], places[i, 1]
        moments[axis], moments[a], moments[b] = first, place[a] * length, place[b] * length
        found[i, VOLUME], found[i, AREA], at = length, area, 4
        for j in range(3):
            found[i, 1 + j] = moments[j]
            for k in range(j, 3):
                # A moment along the ray and across it is the first moment of the chord times the place
                mixed = moments[j] * place[k] if j == axis else moments[k] * place[j]
                found[i, at] = second if j == k == axis else mixed
                at += 1


@kernel(found="n 11", areas="r", count="2..", begin="0..end", end="0..b", sums="out b 11", products="out b 66")
def add_rectangles(
    found: Floats, areas: Floats, count: int, begin: int, end: int, sums: Floats, products: Floats
) -> None:  # fmt: skip
    """Write the sums of blocks begin..end of rectangles, of `count` rays each: of means, and of products of deviations.

    Blocks make the rounding small, and the sums equal for any number of threads.
    """
    mean, deviation = np.empty(11), np.empty(11)
    for block in range(begin, end):
        sums[block, :], products[block, :] = 0.0, 0.0
        for part in range(block * _BLOCK, min(block * _BLOCK + _BLOCK, len(areas), len(found) // count)):
            for k in range(11):
                total = 0.0
                for i in range(part * count, part * count + count):
                    total += found[i, k] * areas[part]
                mean[k] = total / count
                sums[block, k] += mean[k]
            for i in range(part * count, part * count + count):
                at = 0
                for j in range(11):
                    deviation[j] = found[i, j] * areas[part] - mean[j]
                    for k in range(j + 1):
                        products[block, at] += deviation[j] * deviation[k]
                        at += 1


@dataclass
class ChordFamily:
    """Rays along one axis of the box, up to number `last` of the `total` rays of all families.

    They are traced in pieces, each with random numbers of its own, and sums of pieces are added in order: the result is
    the same wherever the pieces are traced.
    """

    scene: SceneLike
    box: FittedBox
    shadow: Shadow
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
        items = ((count * len(part), (self.seed, count, begin, part)) for begin, part in pieces)
        for values, covariance in self._piece_results(_estimate_piece, items):
            self.sums.values += values
            self.sums.covariance += covariance

    def ranges(self, rectangles: Rectangles) -> FloatArray:
        """Return how much length and area differ among the corners of each rectangle (n,), as shares of their sums."""
        count, half = len(rectangles), np.delete(self.box.half, self.shadow.axis)
        corners, keys = np.empty((4 * count, 2)), np.empty(4 * count, np.int64)
        run_rows(put_corners, (rectangles.low, rectangles.size, half), count, corners, keys, most=_ROWS)
        # Neighbours share corners: trace each once
        _, first, back = np.unique(keys, return_index=True, return_inverse=True)
        places = (corners[first[begin : begin + CHUNK]] for begin in range(0, len(first), CHUNK))
        values = [np.zeros((0, 2)), *self._piece_results(_chords_at_corners, ((len(some), some) for some in places))]
        ranges = np.empty((count, 2))
        run_rows(put_ranges, (np.concatenate(values), back, rectangles.areas), count, ranges, most=_ROWS)
        sums = ranges.sum(axis=0)
        shares: FloatArray = ranges / np.where(sums > 0, sums, 1.0)
        return shares[:, 0] + shares[:, 1]

    def _piece_results(self, call: Callable[..., Any], items: Iterator[tuple[int, Any]]) -> Iterator[Any]:
        """Yield call(scene, view, item) of each (rays, item) in order, computed on threads or on workers."""
        view = AxisRays(self.box, self.shadow.axis)
        if self.workers is None:
            found = _follow_on_threads(self.scene, view, call, items)
        else:
            found = follow_on_workers(self.workers, self.scene, view, call, items)
        for rays, value in found:
            self.sums.rays += rays
            if self.progress is not None:
                self.progress(min(self.sums.rays, self.last), self.total)
            yield value


@prepare_first
def _estimate_piece(
    scene: SceneLike, view: AxisRays, item: tuple[int, int, int, Rectangles]
) -> tuple[FloatArray, FloatArray]:
    """Return the sums (11,) over a piece of rectangles, and their covariance (11, 11)."""
    seed, count, begin, part = item
    roll = np.random.default_rng((seed, view.axis, begin)).random((len(part), count, 2))
    found = view.integrals(scene, (part.low[:, None] + part.size[:, None] * roll).reshape(-1, 2))
    blocks, covariance = -(-len(part) // _BLOCK), np.empty((11, 11))
    sums, products = np.empty((blocks, 11)), np.empty((blocks, 66))
    run_rows(add_rectangles, (found, part.areas, count), blocks, sums, products, most=_ROWS // _BLOCK)
    # The variance of each mean, from the differences within a rectangle
    halves = np.ascontiguousarray(products.T).sum(axis=1) / (count * (count - 1))
    covariance[_LOWER] = covariance.T[_LOWER] = halves
    return np.ascontiguousarray(sums.T).sum(axis=1), covariance


_LOWER = np.tril_indices(11)


@prepare_first
def _chords_at_corners(scene: SceneLike, view: AxisRays, places: FloatArray) -> FloatArray:
    """Return the chord length and the area of rays, (n, 2)."""
    return np.ascontiguousarray(view.integrals(scene, places)[:, (VOLUME, AREA)])


_UNITS, _TO_WHOLE = 2.0**30, 1.5 * 2.0**52
"""Units of a side of the box, in which equal corners are equal; adding and taking away the other rounds to integers."""


@kernel(
    low="n 2", size="n 2", half="2", begin="0..end", end="0..n", corners="out 4*n 2", keys="out 4*n"
)  # fmt: skip
def put_corners(
    low: Floats, size: Floats, half: Floats, begin: int, end: int, corners: Floats, keys: Longs
) -> None:  # fmt: skip
    """Write the corners of rectangles begin..end, and a key of each: equal corners differ by rounding."""
    for i in range(4 * begin, 4 * end):
        keys[i] = 0
        for k in range(2):
            far = (i % 4) // 2 if k == 0 else i % 2
            corners[i, k] = low[i // 4, k] + size[i // 4, k] * far
            unit = 2.0 * half[k]
            whole = (corners[i, k] + half[k]) / unit * _UNITS + _TO_WHOLE - _TO_WHOLE if unit > 0.0 else 0.0
            keys[i] = (keys[i] << 31) + int(whole)


@kernel(values="m 2", back="4*n", areas="n", begin="0..end", end="0..n", ranges="out n 2")
def put_ranges(values: Floats, back: Longs, areas: Floats, begin: int, end: int, ranges: Floats) -> None:
    """Write how much both values differ among the corners of rectangles begin..end, times the areas."""
    for i in range(begin, end):
        for k in range(2):
            low, high = math.inf, -math.inf
            for corner in range(4 * i, 4 * i + 4):
                if 0 <= back[corner] < len(values):
                    low, high = min(low, values[back[corner], k]), max(high, values[back[corner], k])
            ranges[i, k] = (high - low) * areas[i]


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


def refine_rectangles(family: ChordFamily) -> Rectangles:
    """Return rectangles that cover the shape's shadow, about half as many as the rays that the family has left.

    The rays that choose the rectangles are not used again, so that estimates on the rectangles stay unbiased.
    """
    shadow, most = family.shadow, min(family.remaining_rays, 2 * _MOST)
    rectangles = _covering_rectangles(shadow, family.box, most)
    # Without rays to spare for corners, all rectangles stay equal
    scores = family.ranges(rectangles) if len(rectangles) <= most // _FIRST else np.zeros(len(rectangles))
    for _ in range(_ROUNDS if scores.any() else 0):
        worst = np.argsort(-scores, kind="stable")[: max(1, len(scores) // _SPLIT)]
        worst = worst[scores[worst] > _WORSE * scores.mean()]
        if 2 * len(scores) + (6 + _CORNER_RAYS) * len(worst) > min(family.remaining_rays, 2 * _MOST):
            break
        # Halved twice: the quarters of the rectangles that differ most
        parts = shadow.halves(shadow.halves(rectangles[worst]))
        scores = np.concatenate([np.delete(scores, worst), family.ranges(parts)])
        rectangles = rectangles.without(worst) + parts
    return _fill_rectangles(rectangles, shadow, min(family.remaining_rays // 2, _MOST))


def _covering_rectangles(shadow: Shadow, box: FittedBox, rays: int) -> Rectangles:
    """Return equal rectangles that cover the shape's shadow along an axis; none if there is no shadow."""
    half = np.delete(box.half, shadow.axis)[None]
    rectangles = Rectangles(-half, 2 * half)
    while len(rectangles):
        smaller = shadow.halves(rectangles)
        thinner = smaller.areas.sum() < _CLEARLY_LESS * rectangles.areas.sum()
        if len(smaller) > rays // (_THIN if thinner else _FIRST) or not smaller.areas.all():
            break
        rectangles = smaller
    return rectangles


def _fill_rectangles(rectangles: Rectangles, shadow: Shadow, most: int) -> Rectangles:
    """Return the rectangles, all halved as often as `most` allows."""
    while len(rectangles):
        smaller = shadow.halves(rectangles)
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
        last, shadow = (axis + 1) * rays // 3, hull.shadow(axis, directions)
        family = ChordFamily(scene, box, shadow, seed, sums, last, progress, rays, workers)
        rectangles = refine_rectangles(family)
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


def _follow_on_threads(
    scene: SceneLike, view: AxisRays, call: Callable[..., Any], items: Iterator[tuple[int, Any]]
) -> Iterator[tuple[int, Any]]:
    """Yield (rays, call(scene, view, item)) for each (rays, item), in order, computed on all threads."""
    while some := list(itertools.islice(items, _AT_ONCE)):
        results = run_calls(ignore_fp_errors(call), [(scene, view, item) for _, item in some])
        yield from zip((rays for rays, _ in some), results, strict=True)


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
