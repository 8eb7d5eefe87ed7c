"""Undefined regions: points of a scene's domain that are in no body.

Rays find gaps: stretches in the domain and in no body. Gaps belong to one region if a straight way between them stays
undefined, directly or through other gaps. Random points then estimate the volume of each region.
"""

from __future__ import annotations

import math
from collections.abc import Callable, Sequence
from typing import Any

import numpy as np

from ..._util.arrays import FloatArray, unique_sorted
from ..._util.records import dataclass
from ..._util.text import format_count
from ...kernels.crossings import row_owners
from ...queries.result import extension
from ...queries.scene_protocol import SceneLike
from .findings import UNDEFINED, Finding, body_titles
from .probe_rays import CHUNK, THIN, ProbeRays, ProbeTargets

GapWall = tuple[int, int]
"""A body and a surface."""

_SHARE_KEPT, _OF_EACH, _MOST_STRETCHES = 600, 24, 6000
"""Gaps that are compared: about so many in all, at least so many of each set that shares walls, and at most so many."""
_NEIGHBOURS, _LOOKS, _NEAR, _PAIRS = 8, 3, 12.0, 2000
"""Nearest places that a place is tested against; nearest places that a point is tested against; gaps that share a wall
are near within so many times the median distance of neighbours; pairs of near gaps that are tested."""
_SHARES = (0.05, 0.5, 0.95)
"""Places along a gap, as shares of its length."""
_MOST_REGIONS, _WALKERS, _STEPS, _TURN = 64, 24, 12, 0.3
"""Regions that random walks explore at most; walks in each, steps of a walk, and spread of its turns."""


@dataclass
class Gap:
    """A stretch of a ray in the domain and in no body.

    ends       (2, 3) points
    walls      (body, surface) at each end; None where the domain ends
    origin, direction   (3,) the ray
    """

    ends: FloatArray
    walls: tuple[GapWall | None, GapWall | None]
    origin: FloatArray
    direction: FloatArray

    @property
    def length(self) -> float:
        """Distance between the ends."""
        return float(np.linalg.norm(self.ends[1] - self.ends[0]))


class UnionFind:
    """Disjoint sets, each represented by one of its members (union-find)."""

    def __init__(self) -> None:
        self.parent: dict[Any, Any] = {}

    def of(self, item: Any) -> Any:
        """Return the representative of an item's set; a new item is a set of its own."""
        while self.parent.setdefault(item, item) != item:
            self.parent[item] = item = self.parent[self.parent[item]]
        return item

    def join(self, one: Any, other: Any) -> None:
        """Unite the sets of two items."""
        self.parent[self.of(one)] = self.of(other)


@dataclass
class UndefinedRegions:
    """Regions and the places by which points are assigned to them.

    stretches   the gaps of each region
    places      (n, 3) points within regions
    region      (n,) number of the region of each place
    """

    stretches: list[list[Gap]]
    places: FloatArray
    region: Any

    def of_points(self, points: FloatArray, some: Sequence[int], free: Free) -> Any:
        """Return the region (n,) of each point, among some regions.

        It is that of the nearest place with a free straight way to the point, or of the nearest place if there is none.
        """
        result = np.full(len(points), some[0])
        if len(some) == 1:
            return result
        own = np.flatnonzero(np.isin(self.region, some))
        # In blocks, as the distances of all pairs would need too much memory
        for begin in range(0, len(points), 256):
            block = points[begin : begin + 256]
            squares = sum((block[:, k, None] - self.places[own, k]) ** 2 for k in range(3))
            close = _nearest(squares)
            sees = free(np.repeat(block, close.shape[1], axis=0), self.places[own[close.ravel()]]).reshape(close.shape)
            first = np.argmax(sees, axis=1)  # the nearest one where none is seen
            result[begin : begin + 256] = self.region[own[close[np.arange(len(block)), first]]]
        return result


def _nearest(squares: FloatArray) -> Any:
    """Return the columns of the `_LOOKS` least numbers of each row, the least first, and the first of equal ones."""
    count = min(_LOOKS, squares.shape[1])
    limits = np.partition(squares, count - 1, axis=1)[:, count - 1]
    row, column = np.nonzero(squares <= limits[:, None])
    order = np.lexsort((squares[row, column], row))
    begins = np.searchsorted(row, np.arange(len(squares)))
    return column[order][begins[:, None] + np.arange(count)]


Free = Callable[[FloatArray, FloatArray], Any]
"""free(one, other) -> (n,) bool: are all points between two points undefined? Both are (n, 3)."""
Detour = Callable[[FloatArray, FloatArray], Any]
"""detour(one, other) -> (n,) the surface by which the way between two points leaves the region and comes back to it;
-1 if these are two surfaces."""
Reach = Callable[[FloatArray, FloatArray], tuple[FloatArray, FloatArray]]
"""reach(points, directions) -> t (n,) where rays from undefined points leave the region, and the normals (n, 3)."""


def regions_of(gaps: list[Gap], free: Free, detour: Detour, reach: Reach) -> UndefinedRegions:
    """Return the regions of gaps, the one with most gaps first.

    Gaps that share a wall may belong to several regions: two gaps beside one plane. They are of one region if a free
    straight way leads from one to the other, through others between them, or through places that a random walk from
    them reaches; and if they are neighbours around the bend of a wall that they share.
    """
    groups = _wall_groups(gaps)
    sample = [gap for group in groups for gap in _sample_group(group, len(gaps))][:_MOST_STRETCHES]
    places, roots = _places(sample), UnionFind()
    owners = np.repeat(np.arange(len(sample)), len(_SHARES))
    _join_visible_gaps(places, owners, roots, free)
    _join_around_bends(sample, places, roots, detour)
    visited, walkers = _random_walks(places, roots, reach)
    first = len(places)
    # Places of walks count as places of the gaps that they started from
    places, owners = np.concatenate([places, visited]), np.concatenate([owners, walkers])
    _join_visible_regions(places, owners, roots, free, first)
    numbers: dict[Any, int] = {}
    region = np.array([numbers.setdefault(roots.of(k), len(numbers)) for k in range(len(sample))], np.int64)
    result = UndefinedRegions([[] for _ in numbers], places, region[owners])
    # Gaps that were not compared join the regions of those that were
    _assign(groups, {id(gap): int(k) for gap, k in zip(sample, region, strict=True)}, result, free)
    order = sorted((k for k, own in enumerate(result.stretches) if own), key=lambda k: -len(result.stretches[k]))
    rank = np.full(len(numbers), -1)
    rank[order] = np.arange(len(order))
    return UndefinedRegions([result.stretches[k] for k in order], places, rank[result.region])


def _wall_groups(gaps: list[Gap]) -> list[list[Gap]]:
    """Return groups of gaps that share walls, directly or through others; gaps without walls are one group."""
    roots = UnionFind()
    for gap in gaps:
        # A gap with one wall joins that wall with itself
        roots.join(gap.walls[0] or gap.walls[1], gap.walls[1] or gap.walls[0])
    groups: dict[Any, list[Gap]] = {}
    for gap in gaps:
        groups.setdefault(roots.of(gap.walls[0] or gap.walls[1]), []).append(gap)
    return sorted(groups.values(), key=len, reverse=True)


def _sample_group(group: list[Gap], count: int) -> list[Gap]:
    """Return a share of a group of gaps, at least a few."""
    size = max(_OF_EACH, _SHARE_KEPT * len(group) // count)
    return group[:: -(-len(group) // size)]


def _places(gaps: Sequence[Gap]) -> FloatArray:
    """Return the places (3 n, 3) within n gaps, gap by gap."""
    ends, shares = np.array([gap.ends for gap in gaps]).reshape(-1, 2, 3), np.array(_SHARES)[:, None]
    result: FloatArray = ends[:, :1] + shares * (ends[:, 1:] - ends[:, :1])
    return result.reshape(-1, 3)


def _join_visible_gaps(places: FloatArray, owners: Any, roots: UnionFind, free: Free) -> None:
    """Join gaps if a free way leads from a place of one to a near place of another; owners: the gap of each place."""
    most = min(_NEIGHBOURS + len(_SHARES), len(places))
    for begin in range(0, len(places), 256):
        squares = ((places[begin : begin + 256, None] - places[None]) ** 2).sum(axis=2)
        close = np.argpartition(squares, most - 1, axis=1)[:, :most]
        one, other = np.repeat(np.arange(begin, begin + len(close)), most), close.ravel()
        differs = owners[one] != owners[other]
        one, other = one[differs], other[differs]
        sees = free(places[one], places[other])
        for a, b in zip(owners[one[sees]].tolist(), owners[other[sees]].tolist(), strict=True):
            roots.join(a, b)


def _join_visible_regions(places: FloatArray, owners: Any, roots: UnionFind, free: Free, first: int) -> None:
    """Join regions if a free way leads from a place, from `first` on, to one of the nearest places of other regions."""
    regions: Any = np.array([roots.of(k) for k in owners.tolist()])
    for begin in range(first, len(places), 256):
        some = np.arange(begin, min(begin + 256, len(places)))
        squares = ((places[some][:, None] - places[None]) ** 2).sum(axis=2)
        squares[regions[some][:, None] == regions] = np.inf
        close = np.argpartition(squares, _LOOKS, axis=1)[:, :_LOOKS]
        finite = np.isfinite(np.take_along_axis(squares, close, axis=1)).ravel()
        one, other = np.repeat(some, _LOOKS)[finite], close.ravel()[finite]
        sees = free(places[one], places[other])
        for a, b in zip(owners[one[sees]].tolist(), owners[other[sees]].tolist(), strict=True):
            roots.join(a, b)


def _random_walks(places: FloatArray, roots: UnionFind, reach: Reach) -> tuple[FloatArray, Any]:
    """Return places (n, 3) on random walks from some gaps of each region along its walls, and the gaps (n,).

    Few gaps show a thin region in pieces: a slab, both sides of an edge. Walks bring the pieces together. They have a
    fixed seed.
    """
    middles = places[len(_SHARES) // 2 :: len(_SHARES)]
    regions: dict[Any, list[int]] = {}
    for k in range(len(middles)):
        regions.setdefault(roots.of(k), []).append(k)
    if not 1 < len(regions) <= _MOST_REGIONS:
        return np.empty((0, 3)), np.empty(0, np.int64)
    # As many walks in every region, from gaps that are spread over it
    walkers = np.array([np.resize(own[:: -(-len(own) // _WALKERS)], _WALKERS) for own in regions.values()]).ravel()
    random, at = np.random.default_rng(0), middles[walkers]
    way, visited = random.normal(size=(len(walkers), 3)), []
    for _ in range(_STEPS):
        far, normals = reach(at, way)
        # A step ends short of the wall
        at = at + (far * random.uniform(0.3, 0.95, len(at)))[:, None] * way
        visited.append(at)
        way = way / np.linalg.norm(way, axis=1, keepdims=True) + random.normal(scale=_TURN, size=at.shape)
        way = way - (way * normals).sum(axis=1, keepdims=True) * normals  # along the wall that ended the last step
    return np.concatenate(visited), np.tile(walkers, _STEPS)


def _join_around_bends(gaps: Sequence[Gap], places: FloatArray, roots: UnionFind, detour: Detour) -> None:
    """Join near gaps that share a wall if its bend alone lies between them: the parts of a thin shell."""
    middles = places[len(_SHARES) // 2 :: len(_SHARES)]
    by_wall: dict[GapWall, list[int]] = {}
    for k, gap in enumerate(gaps):
        for wall in gap.walls:
            if wall is not None:
                by_wall.setdefault(wall, []).append(k)
    for own in by_wall.values():
        if len({roots.of(k) for k in own}) < 2:
            continue
        distances = np.linalg.norm(middles[own][:, None] - middles[own][None], axis=2)
        # Near: within some times the median distance of nearest neighbours at this wall
        np.fill_diagonal(distances, np.inf)
        one, other = np.nonzero(np.triu(distances <= _NEAR * np.median(distances.min(axis=1))))
        order = np.argsort(distances[one, other], kind="stable")[:_PAIRS]
        pairs = [(own[a], own[b]) for a, b in zip(one[order].tolist(), other[order].tolist(), strict=True)]
        pairs = [(a, b) for a, b in pairs if roots.of(a) != roots.of(b)]
        if pairs:
            first, second = (middles[list(side)] for side in zip(*pairs, strict=True))
            for k in np.flatnonzero(detour(first, second) >= 0).tolist():
                roots.join(*pairs[k])


def _assign(groups: list[list[Gap]], region_of_gap: dict[int, int], regions: UndefinedRegions, free: Free) -> None:
    """Add every gap to its region; `region_of_gap` has the regions of gaps that were compared, by id."""
    for group in groups:
        of_group = sorted({region_of_gap[id(gap)] for gap in group if id(gap) in region_of_gap})
        if group[0].walls == (None, None):  # these gaps share no wall, and may lie in any region
            of_group = list(range(len(regions.stretches)))
        rest = [gap for gap in group if id(gap) not in region_of_gap]
        for gap in group:
            if id(gap) in region_of_gap:
                regions.stretches[region_of_gap[id(gap)]].append(gap)
        if rest and of_group:
            middles = np.array([gap.ends.mean(axis=0) for gap in rest])
            for gap, k in zip(rest, regions.of_points(middles, of_group, free).tolist(), strict=True):
                regions.stretches[k].append(gap)


# Findings of undefined regions.

_POINTS = 4096
"""Random points that estimate a volume."""
_MOST_NAMED = 4
"""Bodies beside a region that its message names."""
_MOST_REGIONS_BOXED = 64
"""Regions, the first ones, whose points are separated where their boxes overlap."""


def undefined_regions(scene: SceneLike, targets: ProbeTargets, rays: int, random: np.random.Generator) -> list[Finding]:
    """Return a finding for each undefined region, the largest first; none if the scene has no domain."""
    if scene.domain is None or skip_reason(scene):
        return []
    domain: SceneLike = extension("Scene")(scene.domain)
    whole = ProbeTargets.of(domain._prepared.lowered)
    low, high = whole.window
    bodies = np.flatnonzero(~targets.empty)
    aims = [whole.through_window(rays // 2 + 1, random)]
    if len(bodies):
        aims.append(targets.through_bodies(np.resize(bodies, max(rays // 2, 4 * len(bodies))), random))
    gaps: list[Gap] = []
    thin = THIN * float(np.linalg.norm(high - low))
    for aim in aims:
        for begin in range(0, len(aim.origins), CHUNK):
            gaps += _find_gaps(scene, domain, aim.select(slice(begin, begin + CHUNK)), thin)
    if not gaps:
        return []
    regions = regions_of(gaps, _make_free(scene, domain), _make_detour(scene, domain), _make_reach(scene, domain))
    findings = [_finding(scene, domain, regions, k, random) for k in range(len(regions.stretches))]
    return sorted(findings, key=lambda finding: -finding.size)


def skipped_checks(scene: SceneLike) -> list[str]:
    """Return the checks that are skipped for a scene, each with its reason."""
    reason = skip_reason(scene)
    return [f"undefined regions ({reason})"] if reason else []


def skip_reason(scene: SceneLike) -> str:
    """Return why undefined regions of a scene are not searched for; an empty string if they are."""
    if scene.domain is None:
        return "the scene has no domain for its bodies to fill"
    targets = ProbeTargets.of(extension("Scene")(scene.domain)._prepared.lowered)
    low, high = targets.window
    return "the scene's domain is empty" if targets.empty.all() or not (low < high).all() else ""


def _find_gaps(scene: SceneLike, domain: SceneLike, rays: ProbeRays, thin: float) -> list[Gap]:
    """Return the gaps of rays, longer than the slivers that rounding leaves between walls.

    Rays that end at a box are followed to their ends where there is a gap in the box.
    """
    if not rays.is_whole:
        ray, *_, rows = _gap_rows(scene, domain, rays, thin)
        rays = ProbeRays(*rays.select(unique_sorted(ray[rows]))[:2])
    ray, t, body, surface, rows = _gap_rows(scene, domain, rays, thin)
    gaps = []
    for row in rows.tolist():
        walls = tuple((int(body[k]), int(surface[k])) if body[k] >= 0 else None for k in (row, row + 1))
        o, d = rays.origins[ray[row]], rays.directions[ray[row]]
        gaps.append(Gap(o + t[row : row + 2, None] * d, (walls[0], walls[1]), o, d))
    return gaps


def _gap_rows(
    scene: SceneLike, domain: SceneLike, rays: ProbeRays, thin: float
) -> tuple[Any, FloatArray, Any, Any, Any]:
    """Return (ray, t, body, surface) at all ends of stretches of rays, and the rows of ends at which a gap begins."""
    # Ends of stretches of the scene (0) and of its domain (1) along each ray; counts of both are summed from end to end
    stretches = [_stretches(each.spans(*rays), thin) for each in (scene, domain)]
    ray, t, body, surface = (np.concatenate([s[k].ravel() for s in stretches]) for k in range(4))
    turn = np.concatenate([np.repeat([1, -1], s[0].shape[1]) for s in stretches])
    which = np.repeat([0, 1], [s[0].size for s in stretches])
    body[which == 1] = -1
    order = np.lexsort((t, ray))
    ray, t, turn, which, body, surface = (column[order] for column in (ray, t, turn, which, body, surface))
    bodies, domains = np.cumsum(np.where(which == 0, turn, 0)), np.cumsum(np.where(which == 1, turn, 0))
    with np.errstate(invalid="ignore"):
        there = (bodies[:-1] == 0) & (domains[:-1] > 0) & (ray[1:] == ray[:-1]) & (t[1:] - t[:-1] > thin)
    rows = np.flatnonzero(there & np.isfinite(t[1:]))
    middles = rays.origins[ray[rows]] + ((t[rows] + t[rows + 1]) / 2)[:, None] * rays.directions[ray[rows]]
    # Ends that coincide may come in any order: the middle of a gap decides
    return ray, t, body, surface, rows[_is_undefined(scene, domain, middles)]


def _stretches(spans: Any, thin: float) -> tuple[Any, FloatArray, Any, Any]:
    """Return (ray, t, body, surface) of stretches within bodies, (2, n) each: where they begin and where they end.

    A span and the next one are one stretch if they overlap or leave a gap of at most `thin` between them. Spans within
    an earlier one are stretches of their own.
    """
    ray = row_owners(spans.offsets)
    joined = (ray[1:] == ray[:-1]) & (spans.t_exit[1:] >= spans.t_exit[:-1])
    joined &= spans.t_enter[1:] - spans.t_exit[:-1] <= thin
    begins, ends = np.ones(len(ray), bool), np.ones(len(ray), bool)
    begins[1:], ends[:-1] = ~joined, ~joined
    t = np.stack([spans.t_enter[begins], spans.t_exit[ends]])
    surface = np.stack([spans._ends[0, begins], spans._ends[1, ends]])
    return np.tile(ray[begins], (2, 1)), t, np.stack([spans.body[begins], spans.body[ends]]), surface


def _is_undefined(scene: SceneLike, domain: SceneLike, points: FloatArray) -> Any:
    """Return (n,) bool: is the point in the domain and in no body?"""
    return domain.contains(points) & ~scene.contains(points)


def _finding(
    scene: SceneLike, domain: SceneLike, regions: UndefinedRegions, which: int, random: np.random.Generator
) -> Finding:
    """Return the finding of one region."""
    gaps = regions.stretches[which]
    own, volume, error = _sample_region(scene, domain, regions, which, random)
    reached = np.concatenate([*(gap.ends for gap in gaps), own])
    # Shown by the longest gap, preferably one with walls at both ends
    longest = max(gaps, key=lambda gap: (sum(wall is not None for wall in gap.walls), gap.length))
    point = longest.ends.mean(axis=0)
    bodies = tuple(sorted({wall[0] for gap in gaps for wall in gap.walls if wall is not None}))
    neighbours = f" beside {body_titles(scene, bodies[:_MOST_NAMED])}" if bodies else ""
    more = f" and {len(bodies) - _MOST_NAMED} more" if len(bodies) > _MOST_NAMED else ""
    sides = reached.max(axis=0) - reached.min(axis=0)
    place, reach = (", ".join(f"{c:.6g}" for c in row.tolist()) for row in (point, sides))
    size = f"about {volume:.2g} ± {error:.1g}" if len(own) else f"less than about {3 * error:.1g}"
    message = (
        f"({place}) is in the scene's domain but in no body; the region{neighbours}{more} extends over about "
        f"({reach}) and has a volume of {size}; seen by {format_count(len(gaps), 'ray', 'rays')}"
    )
    origin, direction = longest.origin.copy(), longest.direction.copy()
    for array in (point, origin, direction):
        array.flags.writeable = False
    return Finding(UNDEFINED, bodies, message, volume, origin, direction, point, error)


def _sample_region(
    scene: SceneLike, domain: SceneLike, regions: UndefinedRegions, which: int, random: np.random.Generator
) -> tuple[FloatArray, float, float]:
    """Return points (n, 3) of a region, its volume and the standard error of that, from random points of its box."""
    low, high = _box(regions.stretches[which])
    points = low + (high - low) * random.random((_POINTS, 3))
    inside = points[_is_undefined(scene, domain, points)]
    boxes = [_box(gaps) for gaps in regions.stretches[:_MOST_REGIONS_BOXED]] if which < _MOST_REGIONS_BOXED else []
    # Points in the boxes of other regions may belong to these
    others = [k for k, (a, b) in enumerate(boxes) if k != which and (a <= high).all() and (low <= b).all()]
    own = inside[regions.of_points(inside, [which, *others], _make_free(scene, domain)) == which]
    share, box = len(own) / _POINTS, float(np.prod(high - low))
    return own, box * share, box * _share_error(len(own))


def _share_error(inside: int) -> float:
    """Return the standard error of the share of n points that are inside.

    With no point inside it is 1 / n: the share is below 3 / n with a confidence of 95 %. Otherwise it is that of the
    posterior for a uniform prior (Bayes and Laplace), which is not 0 even if all points are inside.
    """
    if not inside:
        return 1 / _POINTS
    return math.sqrt((inside + 1) * (_POINTS - inside + 1) / (_POINTS + 3)) / (_POINTS + 2)


def _box(gaps: list[Gap]) -> tuple[FloatArray, FloatArray]:
    """Return a box (low, high) around the ends of gaps, with a margin that shrinks as there are more gaps."""
    ends = np.concatenate([gap.ends for gap in gaps])
    low, high = ends.min(axis=0), ends.max(axis=0)
    margin = (high - low) * 2 / (len(ends) + 1)
    return low - margin, high + margin


def _make_free(scene: SceneLike, domain: SceneLike) -> Free:
    """Return the `Free` function of a scene and its domain."""

    def free(one: FloatArray, other: FloatArray) -> Any:
        """Return whether the segment between two points is in the domain and in no body, by exact spans."""
        way = other - one
        # A way without length has no direction, and is free
        is_free: Any = ~way.any(axis=1)
        rays = one, np.where(is_free[:, None], 1.0, way)
        within = domain.spans(*rays, 0, 1)
        # The way is free if one span of the domain covers it, and no body has a span on it
        ends = within.enter_clipped & within.exit_clipped
        covered = np.bincount(row_owners(within.offsets), ends, len(one)) > 0
        return is_free | (covered & (np.diff(scene.spans(*rays, 0, 1).offsets) == 0))

    return free


def _make_reach(scene: SceneLike, domain: SceneLike) -> Reach:
    """Return the `Reach` function of a scene and its domain."""

    def reach(points: FloatArray, ways: FloatArray) -> tuple[FloatArray, FloatArray]:
        """Return t at the first body or at the end of the domain, and the normal there; 0 if there is neither."""
        still: Any = ~ways.any(axis=1)
        ways = np.where(still[:, None], 1.0, ways)
        body, end = scene.first_hit(points, ways), domain.first_hit(points, ways)
        nearer = body.t < end.t
        far = np.where(nearer, body.t, end.t)
        known = np.isfinite(far)
        normals = np.where(nearer[:, None], body.normal, end.normal)
        return np.where(known & ~still, far, 0.0), np.where(known[:, None], normals, (0.0, 0.0, 1.0))

    return reach


def _make_detour(scene: SceneLike, domain: SceneLike) -> Detour:
    """Return the `Detour` function of a scene and its domain."""

    def detour(one: FloatArray, other: FloatArray) -> Any:
        """Return the surface by which the way between two points enters a first body and leaves the last; -1 for two.

        It is -1 as well if an end of the way is in a body, or its middle is outside of the domain.
        """
        spans = scene.spans(one, other - one, 0, 1)
        result = np.full(len(one), -1)
        # Ways that enter some body; its first and its last end must be of one surface
        some = np.flatnonzero(np.diff(spans.offsets) > 0)
        first, last = spans._ends[0, spans.offsets[some]], spans._ends[1, spans.offsets[some + 1] - 1]
        inside = ~(spans.enter_clipped[spans.offsets[some]] | spans.exit_clipped[spans.offsets[some + 1] - 1])
        result[some] = np.where((first == last) & inside, first, -1)
        result[~domain.contains((one + other) / 2)] = -1
        return result

    return detour
