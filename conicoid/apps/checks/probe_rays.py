"""Random rays of a check and the findings that they give: overlaps of bodies, and slivers between surfaces.

Rays go through the whole scene, through every body, and through the common boxes of two bodies. Where bodies are
instances, rays through a box end at it: beyond it lie copies, which have rays of their own.
"""

from __future__ import annotations

import math
from collections.abc import Iterator
from dataclasses import field, replace
from functools import cached_property, partial
from typing import Any, NamedTuple

import numpy as np
import numpy.typing as npt

from ..._jit.decorators import kernel
from ..._util.arrays import FloatArray, ignore_fp_errors
from ..._util.records import dataclass
from ...kernels.body.crossing_rows import grow_rows
from ...kernels.crossings import row_owners
from ...kernels.tables import Flags, Floats, Ints, Longs
from ...kernels.threads import run_chunks, run_rows
from ...materials.color import amount_rgb
from ...prepare.lowering import LazyBounds, LoweredScene
from ...queries.scene_protocol import SceneLike

Indices = npt.NDArray[np.int64]

_MOST_PAIRS = 100_000
"""The search for pairs of bodies ends after about so many."""
_ALONG_AXES = 0.25
"""Share of rays that run along an axis of the world."""
_BACK = 2.0
"""Rays start so many diagonals of their target box before it."""
_RAYS = 1 << 10  # rays that a thread takes at a time
_OVERSHOOT = 2.0**-10
"""Rays that end at a box go on by this share of its diagonal."""


class ProbeRays(NamedTuple):
    """Rays of unit direction, and the stretch of each that is probed."""

    origins: FloatArray
    directions: FloatArray
    t_min: Any = 0.0
    t_max: Any = np.inf

    def select(self, some: Any) -> ProbeRays:
        """Return some of the rays."""
        return ProbeRays(*(each[some] if np.ndim(each) else each for each in self))

    @property
    def is_whole(self) -> bool:
        """True if the rays go to infinity."""
        return np.ndim(self.t_max) == 0


@dataclass(frozen=True)
class ProbeTargets:
    """Boxes of all bodies, (n, 3) low and high, and the window: the box of the part of space that rays go through.

    `repeats` tells that bodies are instances, so that rays end at the boxes that they aim at.
    """

    low: FloatArray
    high: FloatArray
    window: tuple[FloatArray, FloatArray]
    repeats: bool = False

    @classmethod
    def of(cls, lowered: LoweredScene) -> ProbeTargets:
        """Return the boxes of a lowered scene."""
        boxes = lowered.boxes
        return cls(boxes[:, :3], boxes[:, 3:], _window(lowered), isinstance(lowered.bounds, LazyBounds))

    @cached_property
    def sizes(self) -> FloatArray:
        """(n,) diagonals of the boxes, cut to the window; 0 for empty boxes."""
        low, high = self._ends
        return np.linalg.norm(np.maximum(high - low, 0.0), axis=1)

    @cached_property
    def empty(self) -> Any:
        """(n,) bool: is the box empty?"""
        return (self.low > self.high).any(axis=1)

    @cached_property
    def _ends(self) -> tuple[FloatArray, FloatArray]:
        """All boxes with infinite ends moved to the window's."""
        first, last = self.window
        # A finite end may lie beyond the window: the infinite one then moves to it, so that low <= high
        low = np.where(np.isfinite(self.low), self.low, np.minimum(first, self.high))
        return low, np.where(np.isfinite(self.high), self.high, np.maximum(last, self.low))

    def _cut(self, bodies: Indices) -> tuple[FloatArray, FloatArray]:
        """Return the boxes of bodies with infinite ends moved to the window's."""
        low, high = self._ends
        return low.take(bodies, axis=0), high.take(bodies, axis=0)

    def box(self, body: int) -> tuple[FloatArray, FloatArray]:
        """Return the box of one body; low > high if it is empty.

        Infinite ends are moved at least as far from 0 as the window reaches, and at least its size from the other end.
        """
        low, high = self.low[body], self.high[body]
        if (low > high).any():
            return low, high
        first, last = self.window
        far = np.abs([first, last]).max()
        size = float((last - first).max())
        return np.where(np.isfinite(low), low, np.minimum(-far, high - size)), np.where(
            np.isfinite(high), high, np.maximum(far, low + size)
        )

    def endless(self, body: int) -> bool:
        """Return True if some end of a body's box is infinite."""
        return not (np.isfinite(self.low[body]).all() and np.isfinite(self.high[body]).all())

    def common(self, one: Indices, other: Indices) -> tuple[FloatArray, FloatArray]:
        """Return the common boxes (n, 3) of pairs of bodies; low > high if a pair has none."""
        (a, b), (c, d) = self._cut(one), self._cut(other)
        return np.maximum(a, c), np.minimum(b, d)

    def pairs(self) -> tuple[Indices, Indices]:
        """Return pairs of bodies whose boxes meet, at most about 100 000: neighbours along x first."""
        # Sorted along x: neighbours of distance 1, 2 and so on in the order, until none overlap along x
        order = np.argsort(self.low[:, 0], kind="stable")
        order = order[~self.empty[order]]
        ends = [(np.ascontiguousarray(self.low[order, k]), np.ascontiguousarray(self.high[order, k])) for k in range(3)]
        chunks: list[tuple[Indices, Indices]] = []
        count = 0
        for step in range(1, len(order)):
            near = ends[0][0][step:] <= ends[0][1][:-step]
            if count > _MOST_PAIRS or not near.any():
                break
            for low, high in ends[1:]:
                near &= (low[step:] <= high[:-step]) & (low[:-step] <= high[step:])
            overlapping = np.flatnonzero(near)
            count += len(overlapping)
            chunks.append((order[overlapping], order[overlapping + step]))
        none = np.zeros(0, np.int64)
        return np.concatenate([none, *(a for a, _ in chunks)]), np.concatenate([none, *(b for _, b in chunks)])

    def through_window(self, count: int, random: np.random.Generator) -> ProbeRays:
        """Return rays through random points of the window."""
        low, high = self.window
        return rays_through(np.tile(low, (count, 1)), np.tile(high, (count, 1)), random)

    def through_bodies(self, bodies: Indices, random: np.random.Generator) -> ProbeRays:
        """Return a ray through a random point of each body's box."""
        return self.through(*self._cut(bodies), random)

    def through(self, low: FloatArray, high: FloatArray, random: np.random.Generator) -> ProbeRays:
        """Return a ray through a random point of each box (n, 3)."""
        rays = rays_through(low, high, random)
        return _end_at_boxes(rays, low, high) if self.repeats else rays


def rays_through(low: FloatArray, high: FloatArray, random: np.random.Generator) -> ProbeRays:
    """Return a ray through a random point of each box (n, 3), from outside of it; a quarter of them along the axes."""
    origins, directions = random.random(low.shape), random.normal(size=low.shape)
    along, axes = random.random(len(low)) < _ALONG_AXES, np.full(len(low), -1, np.int32)
    axes[along] = random.integers(0, 3, np.count_nonzero(along))
    run_rows(aim_rays, (low, high, axes), len(low), origins, directions, most=_RAYS)
    return ProbeRays(origins, directions)


@kernel(low="n 3", high="n 3", axes="n", begin="0..end", end="0..n", origins="out n 3", directions="out n 3")
def aim_rays(
    low: Floats, high: Floats, axes: Ints, begin: int, end: int, origins: Floats, directions: Floats
) -> None:  # fmt: skip
    """Turn shares of boxes and vectors into origins before the boxes and unit directions: rays begin..end.

    axes: the axis that a ray is along, -1 for none.
    """
    for i in range(begin, end):
        square, size, far = 0.0, 0.0, 1.0
        for k in range(3):
            side = high[i, k] - low[i, k]
            origins[i, k] = low[i, k] + side * origins[i, k]
            square, size = square + directions[i, k] * directions[i, k], size + side * side
            far = max(far, abs(origins[i, k]))
        length, size = math.sqrt(square), math.sqrt(size)
        back = _BACK * (size if size > 0.0 else far)  # a box without size: its coordinates give the distance
        for k in range(3):
            part = directions[i, k] / length if axes[i] < 0 else (1.0 if axes[i] == k else 0.0)
            directions[i, k] = part
            origins[i, k] -= back * part


def _end_at_boxes(rays: ProbeRays, low: FloatArray, high: FloatArray) -> ProbeRays:
    """Return rays that end a little beyond the boxes (n, 3) that they go through."""
    margin = _OVERSHOOT * np.linalg.norm(high - low, axis=1, keepdims=True)
    with np.errstate(divide="ignore", invalid="ignore"):
        ends = [(end - rays.origins) / rays.directions for end in (low - margin, high + margin)]
    # Across a direction of 0 the ray is between the ends, as it goes through a point of the box
    along = rays.directions != 0
    first = np.where(along, np.minimum(*ends), -np.inf).max(axis=1)
    last = np.where(along, np.maximum(*ends), np.inf).min(axis=1)
    return rays._replace(t_min=np.maximum(first, 0.0), t_max=np.maximum(last, 0.0))


def _window(lowered: LoweredScene) -> tuple[FloatArray, FloatArray]:
    """Return (low, high) around all finite ends of boxes.

    If a body is infinite, the window also holds the anchors of all surfaces, and has a margin of its own size.
    """
    boxes = lowered.boxes[(lowered.boxes[:, :3] <= lowered.boxes[:, 3:]).all(axis=1)]
    points = np.concatenate([boxes[:, :3], boxes[:, 3:]])
    endless = not len(points) or not np.isfinite(points).all()
    # The anchors of surfaces show where an infinite scene has its features
    if endless:
        tables = lowered.tables
        points = np.concatenate([points, tables.planes[:, 4:7], tables.spheres[:, :3], tables.quadrics[:, :3]])
    finite = np.isfinite(points)
    low = np.where(finite, points, np.inf).min(axis=0, initial=np.inf)
    high = np.where(finite, points, -np.inf).max(axis=0, initial=-np.inf)
    low, high = np.where(low <= high, low, 0.0), np.where(low <= high, high, 0.0)
    if endless:
        margin = float(max((high - low).max(), 1e-3 * np.abs([low, high]).max())) or 1.0
        low, high = low - margin, high + margin
    return low, high


# Findings of rays: stretches common to two bodies, and slivers between two surfaces.

CHUNK, _FIRST_CHUNK, _ROWS = 1 << 13, 1 << 8, 1 << 18
"""Most rays of one query, those of the first one, and about how many rows a query may give."""
_AT_ONCE = 1 << 6
"""Queries whose findings wait to be merged: results are the same for any number of threads."""
THIN = 1e-9
"""Anything thinner than this part of a body's size is a sliver."""

_PARALLEL = 0.99
"""|cosine| of the angle between the walls of a sliver; at an edge, walls meet at a larger angle."""


@dataclass
class Sighting:
    """The longest overlap of two bodies, or the thickest sliver of two surfaces: its ray, and the number of rays.

    kind   "overlap", or the kind of sliver: "film", "gap", "step" or "overlap"
    """

    length: float
    origin: FloatArray
    direction: FloatArray
    kind: str = ""
    times: int = 0


@dataclass
class ProbeScan:
    """Collects the findings of rays through a scene: `overlaps` by pair of bodies, `slivers` by bodies and surfaces."""

    scene: SceneLike
    sizes: FloatArray
    is_hit: Any  # (bodies,) bool: some ray hits it
    solid: Any  # (bodies,) bool: solids, not sheets
    endless: bool  # some body is infinite
    overlaps: dict[tuple[int, int], Sighting] = field(default_factory=dict)
    slivers: dict[tuple[int, int, int, int], Sighting] = field(default_factory=dict)
    covers: dict[int, int] = field(default_factory=dict)
    """Sheet -> a body listed before it with a wall in its place, which rays report, or the opaque one around it."""
    lamps: dict[int, bool] = field(default_factory=dict)
    """Body -> whether it shines, of bodies that were asked."""
    seen: set[int] = field(default_factory=set)
    """Bodies that some ray reports, or would report if nothing stood before them."""
    rays: int = 0

    @property
    def hidden(self) -> list[tuple[int, int]]:
        """(cover, sheet) for each sheet that no ray reports, wherever it hits it."""
        return sorted((cover, body) for body, cover in self.covers.items() if body not in self.seen)

    def follow(self, rays: ProbeRays) -> None:
        """Trace rays and collect their findings: chunks of rays on all threads, whose findings are merged in order."""
        begin, size, chunks = 0, _FIRST_CHUNK, 1
        while begin < len(rays.origins):
            some = rays.select(slice(begin, begin + chunks * size))
            parts = run_chunks(partial(self._part, some), len(some.origins), size)
            rows = 0
            for _, _, (part, count) in sorted(parts, key=lambda each: each[0]):
                self._merge(part)
                rows += count
            begin += len(some.origins)
            # Chunks of about so many rows stay in the cache of the processor
            size = min(max(_ROWS * len(some.origins) // max(rows, 1), _FIRST_CHUNK), CHUNK)
            chunks = _AT_ONCE

    @ignore_fp_errors
    def _part(self, rays: ProbeRays, first: int, last: int) -> tuple[ProbeScan, int]:
        """Return a scan of rays first..last alone, which shares `is_hit` and `lamps`, and the number of crossings."""
        rays = rays.select(slice(first, last))
        part = replace(self, overlaps={}, slivers={}, covers={}, seen=set(), rays=last - first)
        hits = self.scene.crossings(*rays)
        several, close = part._look(hits)
        if not rays.is_whole:  # a stretch of a ray may begin within bodies, which crossings do not tell
            part._spans(rays)
        elif len(several):
            part._spans(rays.select(several))
        if len(close):
            part._slivers(hits, close, rays.origins, rays.directions)
        if not self.solid.all():
            part._covers(hits)
        return part, len(hits.t)

    def _merge(self, part: ProbeScan) -> None:
        """Add the findings of the rays that follow."""
        for table, more in ((self.overlaps, part.overlaps), (self.slivers, part.slivers)):
            for key, sighting in more.items():
                _note(table, key, sighting)
        self.covers = part.covers | self.covers
        self.seen |= part.seen
        self.rays += part.rays

    def _look(self, hits: Any) -> tuple[Any, Any]:
        """Return the rays that may be within two bodies over some length, and the rows that a sliver may follow.

        Where bodies are infinite, or crossings are not those of closed solids, every ray may. Bodies with rows are hit.
        """
        several, close = np.empty(len(hits), np.bool_), np.empty(len(hits.t), np.bool_)
        rows = hits.offsets, hits.t, hits.body, hits.surface, hits.entering
        before, fields = (*rows, self.solid, self.sizes, self.endless), (several, close, self.is_hit)
        run_rows(look_at_rows, before, len(hits), *fields, most=_RAYS)
        return np.flatnonzero(several), np.flatnonzero(close)

    def _covers(self, hits: Any) -> None:
        """Collect sheets that are never seen: in walls of bodies listed before them, or lamps within opaque bodies."""
        ray = row_owners(hits.offsets)
        tied = np.zeros(len(ray), bool)
        tied[1:] = (ray[1:] == ray[:-1]) & (hits.t[1:] == hits.t[:-1]) & (hits.body[1:] > hits.body[:-1])
        cover = np.where(tied, np.roll(hits.body, 1), -1)
        sheets = np.flatnonzero(~self.solid[hits.body] & ~tied)
        lamps = sheets[[self._shines(body) for body in hits.body[sheets].tolist()]] if len(sheets) else sheets
        if len(lamps):
            around = hits.before[lamps]
            opaque = [body >= 0 and not self._lets_through(body) for body in around.tolist()]
            inside = (around == hits.after[lamps]) & opaque
            cover[lamps[inside]] = around[inside]
        self.seen.update(np.unique(hits.body[cover < 0]).tolist())
        rows = np.flatnonzero((cover >= 0) & ~self.solid[hits.body])
        bodies, first = np.unique(hits.body[rows], return_index=True)
        for body, k in zip(bodies.tolist(), rows[first].tolist(), strict=True):
            self.covers.setdefault(body, int(cover[k]))

    def _shines(self, body: int) -> bool:
        """Return whether a body is a lamp."""
        if body not in self.lamps:
            material = self.scene.body(body).material
            self.lamps[body] = material is not None and max(amount_rgb(material.emission)) > 0
        return self.lamps[body]

    def _lets_through(self, body: int) -> bool:
        """Return whether light passes through a body."""
        material = self.scene.body(body).material
        return material is not None and max(amount_rgb(material.transparency)) > 0

    def _spans(self, rays: ProbeRays) -> None:
        """Collect overlaps: spans of two bodies that have a stretch in common."""
        spans = self.scene.spans(*rays)
        self.is_hit[spans.body] = True
        found = common_stretches(spans.offsets, spans.t_enter, spans.t_exit, spans.body, rays.directions)
        # Of equal stretches those of neighbours in a list come first
        found = found[np.argsort(found[:, 1], kind="stable")]
        bodies, lengths, owners = found[:, 2:4].astype(np.int64), found[:, 4], found[:, 0].astype(np.int64)
        for (one, other), length, ray, times in _longest(bodies, lengths, owners):
            sighting = Sighting(length, rays.origins[ray], rays.directions[ray], "overlap", times)
            _note(self.overlaps, (one, other), sighting)

    def _slivers(self, hits: Any, one: Any, origins: FloatArray, directions: FloatArray) -> None:
        """Collect slivers: crossings with two surfaces that follow each other closely and are nearly parallel."""
        ray = np.searchsorted(hits.offsets, one, side="right") - 1
        lines = origins[ray], directions[ray]
        normals = [self._normals(hits, k, lines[0] + hits.t[k, None] * lines[1]) for k in (one, one + 1)]
        thin = np.flatnonzero(np.abs((normals[0] * normals[1]).sum(axis=1)) > _PARALLEL)
        # Thickness across the walls instead of along the ray
        gaps = ((hits.t[one + 1] - hits.t[one]) * np.abs((normals[0] * lines[1]).sum(axis=1)))[thin]
        one, other, ray = one[thin], one[thin] + 1, ray[thin]
        keys = np.column_stack([hits.body[one], hits.body[other], hits.surface[one], hits.surface[other]])
        # One key for both senses of a ray: the smaller number of a surface first
        swapped = (keys[:, 2] > keys[:, 3])[:, None]
        keys = np.where(swapped, keys[:, (1, 0, 3, 2)], keys)
        for key, length, k, times in _longest(keys, gaps, np.arange(len(gaps))):
            kind = _gap_kind(
                hits.body[one[k]] == hits.body[other[k]],
                hits.entering[one[k]],
                hits.entering[other[k]],
            )
            at = ray[k]
            _note(
                self.slivers,
                (key[0], key[1], key[2], key[3]),
                Sighting(length, origins[at], directions[at], kind, times),
            )

    def _normals(self, crossings: Any, rows: Any, points: FloatArray) -> FloatArray:
        """Return the unit normals (n, 3) at some crossings."""
        from ...queries.hit_fields import normals_of

        normals = np.empty_like(points)
        faces = np.stack([crossings.surface[rows], crossings.face[rows], np.ones_like(crossings.face[rows])])
        normals_of(self.scene._prepared.geometry, faces, points, 0, len(points), normals)
        return normals


@kernel(
    offsets="n+1", t="s", body="s", surface="s", entering="s", solid="b", sizes="b", begin="0..end", end="0..n",
    several="out n", close="out s", is_hit="out b",
)  # fmt: skip
def look_at_rows(
    offsets: Longs, t: Floats, body: Ints, surface: Ints, entering: Flags, solid: Flags, sizes: Floats, endless: bool,
    begin: int, end: int, several: Flags, close: Flags, is_hit: Flags,
) -> None:  # fmt: skip
    """Write whether rays begin..end may be within two bodies, which of their crossings a sliver may follow, and hits.

    The number of bodies around each stretch is counted from the ray's begin, which is outside of all bodies.
    """
    for i in range(begin, end):
        depth, found, last = 0, endless, min(offsets[i + 1], len(t))
        for row in range(max(0, offsets[i]), last):
            close[row], own = False, body[row]
            if not 0 <= own < len(solid):
                continue
            if not is_hit[own]:  # bytes that are read alone stay in the caches of all threads
                is_hit[own] = True
            if solid[own]:
                depth += 1 if entering[row] else -1
            found = found or depth < 0
            if row + 1 == last or not 0 <= body[row + 1] < len(solid):
                continue
            gap = t[row + 1] - t[row]
            found = found or (depth > 1 and gap > 0.0)
            thin = gap < THIN * min(sizes[own], sizes[body[row + 1]])
            close[row] = gap > 0.0 and thin and surface[row] != surface[row + 1]
        several[i] = found


@kernel(offsets="n+1", t_enter="s", t_exit="s", body="s", directions="n 3")
def common_stretches(offsets: Longs, t_enter: Floats, t_exit: Floats, body: Ints, directions: Floats) -> Floats:
    """Return rows of (ray, places between two spans of it, smaller body, larger body, length that both share).

    Rays along an axis of the world have none, as they may run within a sliver from end to end.
    """
    found, used = np.empty((64, 5)), 0
    for i in range(len(directions)):
        last, zeros = min(offsets[i + 1], len(t_enter)), 0
        for k in range(3):
            zeros += 1 if directions[i, k] == 0.0 else 0
        if zeros >= 2:
            continue
        for row in range(max(0, offsets[i]), last):
            # In order of t_enter, the spans that overlap one follow it without a gap
            for other in range(row + 1, last):
                if not t_enter[other] < t_exit[row]:
                    break
                length = min(t_exit[row], t_exit[other]) - t_enter[other]
                if length > 0.0:  # those that touch in a point do not overlap
                    found = grow_rows(found, used, 1)
                    found[used, 0], found[used, 1], found[used, 4] = i, other - row, length
                    found[used, 2], found[used, 3] = min(body[row], body[other]), max(body[row], body[other])
                    used += 1
    return found[:used].copy()


def _gap_kind(same_body: bool, first_enters: bool, second_enters: bool) -> str:
    """Return the kind of sliver between two walls that follow each other on a ray."""
    if same_body:
        return "film" if first_enters else "gap"
    if first_enters == second_enters:
        return "step"
    return "overlap" if first_enters else "gap"


def _longest(keys: Any, lengths: FloatArray, places: Any) -> Iterator[tuple[Any, float, int, int]]:
    """Yield (key, largest length, its place, number of rows) for every different row of keys."""
    if not len(keys):
        return
    # Rows of equal keys follow each other, the longest first
    order = np.lexsort((-lengths, *keys.T[::-1]))
    keys = keys[order]
    heads = np.flatnonzero(np.concatenate([[True], (keys[1:] != keys[:-1]).any(axis=1)]))
    counts = np.diff([*heads, len(keys)])
    for head, count in zip(heads.tolist(), counts.tolist(), strict=True):
        yield tuple(keys[head].tolist()), float(lengths[order[head]]), int(places[order[head]]), count


def _note(table: dict[Any, Sighting], key: Any, sighting: Sighting) -> None:
    """Add a sighting to a table: keep the longer of two, and the sum of their numbers of rays."""
    earlier = table.get(key)
    if earlier is None:
        table[key] = sighting
        return
    sighting.times += earlier.times
    if earlier.length >= sighting.length:
        earlier.times = sighting.times
    else:
        table[key] = sighting
