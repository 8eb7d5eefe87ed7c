"""Which stretches of rays through undefined points lie in one region: those that see each other, one by the other."""

from __future__ import annotations

import math
from collections.abc import Callable, Iterator, Sequence
from dataclasses import dataclass
from typing import TYPE_CHECKING, Any

import numpy as np

from ..._util.arrays import FloatArray
from ..._util.text import format_count
from ...kernels.entry.crossings import row_owners
from ...queries.extensions import extension
from .findings import UNDEFINED, Finding, body_titles
from .probe_rays import CHUNK, THIN, ProbeTargets

if TYPE_CHECKING:
    from ...queries.scene_protocol import SceneLike


GapWall = tuple[int, int]
"""A body and a surface."""

_SHARE_KEPT, _OF_EACH, _MOST_STRETCHES = 600, 24, 6000
"""Stretches that are compared: about so many in all, at least so many of each set that shares walls, and at most."""
_NEIGHBOURS, _LOOKS, _NEAR, _PAIRS = 8, 3, 12.0, 2000
"""Of each place; of each point; what shares a wall is near within so many times the way to neighbours; pairs."""
_SHARES = (0.05, 0.5, 0.95)
_MOST_REGIONS, _WALKERS, _STEPS, _TURN = 64, 24, 12, 0.3
"""Regions that are walked through, the walks of each, their steps, and how far each turns from the one before."""


@dataclass
class Gap:
    """A stretch of a ray in no body, between two walls; None where an end is that of the domain."""

    ends: FloatArray
    walls: tuple[GapWall | None, GapWall | None]
    origin: FloatArray
    direction: FloatArray

    @property
    def length(self) -> float:
        return float(np.linalg.norm(self.ends[1] - self.ends[0]))


class UnionFind:
    """Sets that are joined, each known by one of its members (union-find)."""

    def __init__(self) -> None:
        self.parent: dict[Any, Any] = {}

    def of(self, item: Any) -> Any:
        while self.parent.setdefault(item, item) != item:
            self.parent[item] = item = self.parent[self.parent[item]]
        return item

    def join(self, one: Any, other: Any) -> None:
        self.parent[self.of(one)] = self.of(other)


@dataclass
class UndefinedRegions:
    """Stretches of each region, and what they were told apart by: places in it, (n, 3), and whose each is."""

    stretches: list[list[Gap]]
    places: FloatArray
    region: Any

    def of_points(self, points: FloatArray, some: Sequence[int], free: Free) -> Any:
        """The region of each point, among some: that of the nearest place that it sees, or of the nearest one."""
        result = np.full(len(points), some[0])
        if len(some) == 1:
            return result
        own = np.flatnonzero(np.isin(self.region, some))
        for begin in range(0, len(points), 256):
            here = points[begin : begin + 256]
            squares = ((here[:, None] - self.places[own][None]) ** 2).sum(axis=2)
            close = np.argsort(squares, axis=1, kind="stable")[:, :_LOOKS]
            sees = free(np.repeat(here, close.shape[1], axis=0), self.places[own[close.ravel()]]).reshape(close.shape)
            first = np.argmax(sees, axis=1)  # the nearest one where none is seen
            result[begin : begin + 256] = self.region[own[close[np.arange(len(here)), first]]]
        return result


Free = Callable[[FloatArray, FloatArray], Any]
"""Whether all points between two are undefined: (n, 3), (n, 3) to (n,)."""
Around = Callable[[FloatArray, FloatArray], Any]
"""The surface by which the way between two points leaves what is undefined and comes back; -1 where it is not one."""


Reach = Callable[[FloatArray, FloatArray], tuple[FloatArray, FloatArray]]
"""How far it is from undefined points in directions to what ends the region, (n,), and the normals there, (n, 3)."""


def regions_of(gaps: list[Gap], free: Free, around: Around, reach: Reach) -> UndefinedRegions:
    """Regions of undefined points, the one with most stretches first.

    Stretches that share a wall may be of several regions: two gaps beside one plane. They are one where they see each
    other, or others between them, or places to which one walks from them; and where they are neighbours around the
    bend of a wall that they share.
    """
    groups = _sharing(gaps)
    chosen = [gap for group in groups for gap in _sample_group(group, len(gaps))][:_MOST_STRETCHES]
    places, roots = _places(chosen), UnionFind()
    owners = np.repeat(np.arange(len(chosen)), len(_SHARES))
    _see(places, owners, roots, free)
    _bend(chosen, places, roots, around)
    visited, walkers = _walk(places, roots, reach)
    first = len(places)
    places, owners = np.concatenate([places, visited]), np.concatenate([owners, walkers])
    _see_others(places, owners, roots, free, first)
    numbers: dict[Any, int] = {}
    region = np.array([numbers.setdefault(roots.of(k), len(numbers)) for k in range(len(chosen))], np.int64)
    result = UndefinedRegions([[] for _ in numbers], places, region[owners])
    _assign(groups, {id(gap): int(k) for gap, k in zip(chosen, region, strict=True)}, result, free)
    order = sorted((k for k, own in enumerate(result.stretches) if own), key=lambda k: -len(result.stretches[k]))
    rank = np.full(len(numbers), -1)
    rank[order] = np.arange(len(order))
    return UndefinedRegions([result.stretches[k] for k in order], places, rank[result.region])


def _sharing(gaps: list[Gap]) -> list[list[Gap]]:
    """Stretches that share a wall, directly or one by the other; those without any walls together."""
    roots = UnionFind()
    for gap in gaps:
        roots.join(gap.walls[0] or gap.walls[1], gap.walls[1] or gap.walls[0])
    groups: dict[Any, list[Gap]] = {}
    for gap in gaps:
        groups.setdefault(roots.of(gap.walls[0] or gap.walls[1]), []).append(gap)
    return sorted(groups.values(), key=len, reverse=True)


def _sample_group(group: list[Gap], count: int) -> list[Gap]:
    """A share of a group, at least a few."""
    kept = max(_OF_EACH, _SHARE_KEPT * len(group) // count)
    return group[:: -(-len(group) // kept)]


def _places(gaps: Sequence[Gap]) -> FloatArray:
    """Points within stretches, (3 n, 3)."""
    ends, shares = np.array([gap.ends for gap in gaps]).reshape(-1, 2, 3), np.array(_SHARES)[:, None]
    result: FloatArray = ends[:, :1] + shares * (ends[:, 1:] - ends[:, :1])
    return result.reshape(-1, 3)


def _see(places: FloatArray, owners: Any, roots: UnionFind, free: Free) -> None:
    """Join stretches where a place of one sees a near one of another; owners: the stretch of each place."""
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


def _see_others(places: FloatArray, owners: Any, roots: UnionFind, free: Free, first: int) -> None:
    """Join regions where a place, from a first one on, sees one of the nearest places of other regions."""
    regions: Any = np.array([roots.of(k) for k in owners.tolist()])
    for begin in range(first, len(places), 256):
        some = np.arange(begin, min(begin + 256, len(places)))
        squares = ((places[some][:, None] - places[None]) ** 2).sum(axis=2)
        squares[regions[some][:, None] == regions] = np.inf
        close = np.argpartition(squares, _LOOKS, axis=1)[:, :_LOOKS]
        known = np.isfinite(np.take_along_axis(squares, close, axis=1)).ravel()
        one, other = np.repeat(some, _LOOKS)[known], close.ravel()[known]
        sees = free(places[one], places[other])
        for a, b in zip(owners[one[sees]].tolist(), owners[other[sees]].tolist(), strict=True):
            roots.join(a, b)


def _walk(places: FloatArray, roots: UnionFind, reach: Reach) -> tuple[FloatArray, Any]:
    """Places that are reached from some stretches of each region, along its walls, and the stretches.

    Thin regions are seen in pieces where stretches are few: a slab, both sides of an edge. Walks bring them together.
    """
    middles = places[len(_SHARES) // 2 :: len(_SHARES)]
    regions: dict[Any, list[int]] = {}
    for k in range(len(middles)):
        regions.setdefault(roots.of(k), []).append(k)
    if not 1 < len(regions) <= _MOST_REGIONS:
        return np.empty((0, 3)), np.empty(0, np.int64)
    walkers = np.array([np.resize(own[:: -(-len(own) // _WALKERS)], _WALKERS) for own in regions.values()]).ravel()
    random, at = np.random.default_rng(0), middles[walkers]
    way, visited = random.normal(size=(len(walkers), 3)), []
    for _ in range(_STEPS):
        far, normals = reach(at, way)
        at = at + (far * random.uniform(0.3, 0.95, len(at)))[:, None] * way
        visited.append(at)
        way = way / np.linalg.norm(way, axis=1, keepdims=True) + random.normal(scale=_TURN, size=at.shape)
        way = way - (way * normals).sum(axis=1, keepdims=True) * normals  # along the wall that ended the last step
    return np.concatenate(visited), np.tile(walkers, _STEPS)


def _bend(gaps: Sequence[Gap], places: FloatArray, roots: UnionFind, around: Around) -> None:
    """Join neighbours that share a wall, and between which lies the bend of one: the parts of a thin shell."""
    middles = places[len(_SHARES) // 2 :: len(_SHARES)]
    by_wall: dict[GapWall, list[int]] = {}
    for k, gap in enumerate(gaps):
        for wall in gap.walls:
            if wall is not None:
                by_wall.setdefault(wall, []).append(k)
    for own in by_wall.values():
        if len({roots.of(k) for k in own}) < 2:
            continue
        apart = np.linalg.norm(middles[own][:, None] - middles[own][None], axis=2)
        np.fill_diagonal(apart, np.inf)
        one, other = np.nonzero(np.triu(apart <= _NEAR * np.median(apart.min(axis=1))))
        order = np.argsort(apart[one, other], kind="stable")[:_PAIRS]
        pairs = [(own[a], own[b]) for a, b in zip(one[order].tolist(), other[order].tolist(), strict=True)]
        pairs = [(a, b) for a, b in pairs if roots.of(a) != roots.of(b)]
        if pairs:
            first, second = (middles[list(side)] for side in zip(*pairs, strict=True))
            for k in np.flatnonzero(around(first, second) >= 0).tolist():
                roots.join(*pairs[k])


def _assign(groups: list[list[Gap]], known: dict[int, int], regions: UndefinedRegions, free: Free) -> None:
    """Every stretch to its region."""
    for group in groups:
        of_group = sorted({known[id(gap)] for gap in group if id(gap) in known})
        if group[0].walls == (None, None):  # these share nothing
            of_group = list(range(len(regions.stretches)))
        rest = [gap for gap in group if id(gap) not in known]
        for gap in group:
            if id(gap) in known:
                regions.stretches[known[id(gap)]].append(gap)
        if rest and of_group:
            middles = np.array([gap.ends.mean(axis=0) for gap in rest])
            for gap, k in zip(rest, regions.of_points(middles, of_group, free).tolist(), strict=True):
                regions.stretches[k].append(gap)


# Where bodies leave part of a scene's domain empty: points that a model says are in a cell, and that are in none.

_POINTS = 4096
"""Points by which a volume is estimated."""
_MOST_NAMED = 4
_MOST_REGIONS_BOXED = 64
"""Regions that are told apart where their boxes meet."""


def undefined_regions(scene: SceneLike, targets: ProbeTargets, rays: int, random: np.random.Generator) -> list[Finding]:
    """One finding for each region, told apart by what sees what; the largest first."""
    if scene.domain is None or skip_reason(scene):
        return []
    domain: SceneLike = extension("Scene")(scene.domain)
    around = ProbeTargets.of(domain.lowered)
    low, high = around.window
    bodies = np.flatnonzero(~targets.empty)
    aims = [around.through_window(rays // 2 + 1, random)]
    if len(bodies):
        aims.append(targets.through_bodies(np.resize(bodies, max(rays // 2, 4 * len(bodies))), random))
    gaps: list[Gap] = []
    for origins, directions in aims:
        for begin in range(0, len(origins), CHUNK):
            some = slice(begin, begin + CHUNK)
            gaps += _find_gaps(scene, domain, origins[some], directions[some], float(np.linalg.norm(high - low)))
    if not gaps:
        return []
    regions = regions_of(gaps, _make_free(scene, domain), _make_around(scene, domain), _make_reach(scene, domain))
    found = [_finding(scene, domain, regions, k, random) for k in range(len(regions.stretches))]
    return sorted(found, key=lambda finding: -finding.size)


def skipped_checks(scene: SceneLike) -> list[str]:
    """What a check has left out, and why."""
    reason = skip_reason(scene)
    return [f"undefined regions ({reason})"] if reason else []


def skip_reason(scene: SceneLike) -> str:
    """Why undefined regions of a scene are not looked for; empty where they are."""
    if scene.domain is None:
        return "the scene has no domain, which says where bodies are to be"
    around = ProbeTargets.of(extension("Scene")(scene.domain).lowered)
    low, high = around.window
    return "the scene's domain is empty" if around.empty.all() or not (low < high).all() else ""


def _find_gaps(
    scene: SceneLike, domain: SceneLike, origins: FloatArray, directions: FloatArray, size: float
) -> Iterator[Gap]:
    """Stretches within the domain and in no body, longer than what rounding leaves between walls."""
    parts = [(scene.spans(origins, directions), 0), (domain.spans(origins, directions), 1)]
    ray = np.concatenate([np.tile(row_owners(s.offsets), 2) for s, _ in parts])
    t = np.concatenate([np.concatenate([s.t_enter, s.t_exit]) for s, _ in parts])
    turn = np.concatenate([np.repeat([1, -1], len(s.body)) for s, _ in parts])
    which = np.concatenate([np.full(2 * len(s.body), part) for s, part in parts])
    body = np.concatenate([np.tile(s.body, 2) if part == 0 else np.full(2 * len(s.body), -1) for s, part in parts])
    surface = np.concatenate([s._ends.ravel() for s, _ in parts])
    order = np.lexsort((t, ray))
    ray, t, turn, which, body, surface = (column[order] for column in (ray, t, turn, which, body, surface))
    bodies, domains = np.cumsum(np.where(which == 0, turn, 0)), np.cumsum(np.where(which == 1, turn, 0))
    with np.errstate(invalid="ignore"):
        there = (bodies[:-1] == 0) & (domains[:-1] > 0) & (ray[1:] == ray[:-1]) & (t[1:] - t[:-1] > THIN * size)
    rows = np.flatnonzero(there & np.isfinite(t[1:]))
    middles = origins[ray[rows]] + ((t[rows] + t[rows + 1]) / 2)[:, None] * directions[ray[rows]]
    sure = _is_undefined(scene, domain, middles)
    for row in rows[sure].tolist():
        walls = tuple((int(body[k]), int(surface[k])) if body[k] >= 0 else None for k in (row, row + 1))
        o, d = origins[ray[row]], directions[ray[row]]
        yield Gap(o + t[row : row + 2, None] * d, (walls[0], walls[1]), o, d)


def _is_undefined(scene: SceneLike, domain: SceneLike, points: FloatArray) -> Any:
    return domain.contains(points) & ~scene.contains(points)


def _finding(
    scene: SceneLike, domain: SceneLike, regions: UndefinedRegions, which: int, random: np.random.Generator
) -> Finding:
    gaps = regions.stretches[which]
    own, volume, error = _sample_region(scene, domain, regions, which, random)
    reached = np.concatenate([*(gap.ends for gap in gaps), own])
    longest = max(gaps, key=lambda gap: (sum(wall is not None for wall in gap.walls), gap.length))
    point = longest.ends.mean(axis=0)
    bodies = tuple(sorted({wall[0] for gap in gaps for wall in gap.walls if wall is not None}))
    beside = f" beside {body_titles(scene, bodies[:_MOST_NAMED])}" if bodies else ""
    more = f" and {len(bodies) - _MOST_NAMED} more" if len(bodies) > _MOST_NAMED else ""
    sides = reached.max(axis=0) - reached.min(axis=0)
    place, reach = (", ".join(f"{c:.6g}" for c in row.tolist()) for row in (point, sides))
    size = f"about {volume:.2g} ± {error:.1g}" if len(own) else f"less than about {3 * error:.1g}"
    message = (
        f"({place}) is in no body, though the scene's domain holds it; the region{beside}{more} reaches over about "
        f"({reach}), a volume of {size}; seen by {format_count(len(gaps), 'ray', 'rays')}"
    )
    origin, direction = longest.origin.copy(), longest.direction.copy()
    for array in (point, origin, direction):
        array.flags.writeable = False
    return Finding(UNDEFINED, bodies, message, volume, origin, direction, point, error)


def _sample_region(
    scene: SceneLike, domain: SceneLike, regions: UndefinedRegions, which: int, random: np.random.Generator
) -> tuple[FloatArray, float, float]:
    """Points of a region, its volume and the standard error of that, by points of a box around what was seen of it."""
    low, high = _box(regions.stretches[which])
    points = low + (high - low) * random.random((_POINTS, 3))
    inside = points[_is_undefined(scene, domain, points)]
    boxes = [_box(gaps) for gaps in regions.stretches[:_MOST_REGIONS_BOXED]] if which < _MOST_REGIONS_BOXED else []
    others = [k for k, (a, b) in enumerate(boxes) if k != which and (a <= high).all() and (low <= b).all()]
    own = inside[regions.of_points(inside, [which, *others], _make_free(scene, domain)) == which]
    share, box = len(own) / _POINTS, float(np.prod(high - low))
    return own, box * share, box * _share_error(len(own))


def _share_error(inside: int) -> float:
    """The standard error of the share of points that are inside; 1 / n for none, which so is below 3 / n, at 95 %.

    That of a share of which nothing was known before (Bayes and Laplace): also for all of them it is not 0.
    """
    if not inside:
        return 1 / _POINTS
    return math.sqrt((inside + 1) * (_POINTS - inside + 1) / (_POINTS + 3)) / (_POINTS + 2)


def _box(gaps: list[Gap]) -> tuple[FloatArray, FloatArray]:
    """Around the ends of stretches, and by so much more as few of them may have missed."""
    ends = np.concatenate([gap.ends for gap in gaps])
    low, high = ends.min(axis=0), ends.max(axis=0)
    margin = (high - low) * 2 / (len(ends) + 1)
    return low - margin, high + margin


def _make_free(scene: SceneLike, domain: SceneLike) -> Free:
    def free(one: FloatArray, other: FloatArray) -> Any:
        """Whether all between two points is in the domain and in no body, by the exact spans of the way."""
        way = other - one
        still: Any = ~way.any(axis=1)
        rays = one, np.where(still[:, None], 1.0, way)
        within = domain.spans(*rays, 0, 1)
        ends = within.enter_clipped & within.exit_clipped
        covered = np.bincount(row_owners(within.offsets), ends, len(one)) > 0
        return still | (covered & (np.diff(scene.spans(*rays, 0, 1).offsets) == 0))

    return free


def _make_reach(scene: SceneLike, domain: SceneLike) -> Reach:
    def reach(points: FloatArray, ways: FloatArray) -> tuple[FloatArray, FloatArray]:
        """How far it is to the first body or the end of the domain, and the normal there."""
        still: Any = ~ways.any(axis=1)
        ways = np.where(still[:, None], 1.0, ways)
        body, end = scene.first_hit(points, ways), domain.first_hit(points, ways)
        nearer = body.t < end.t
        far = np.where(nearer, body.t, end.t)
        known = np.isfinite(far)
        normals = np.where(nearer[:, None], body.normal, end.normal)
        return np.where(known & ~still, far, 0.0), np.where(known[:, None], normals, (0.0, 0.0, 1.0))

    return reach


def _make_around(scene: SceneLike, domain: SceneLike) -> Around:
    def around(one: FloatArray, other: FloatArray) -> Any:
        """The surface by which the way between two points enters a first body and leaves the last, if it is one."""
        found = scene.spans(one, other - one, 0, 1)
        result = np.full(len(one), -1)
        some = np.flatnonzero(np.diff(found.offsets) > 0)
        first, last = found._ends[0, found.offsets[some]], found._ends[1, found.offsets[some + 1] - 1]
        inside = ~(found.enter_clipped[found.offsets[some]] | found.exit_clipped[found.offsets[some + 1] - 1])
        result[some] = np.where((first == last) & inside, first, -1)
        result[~domain.contains((one + other) / 2)] = -1
        return result

    return around
