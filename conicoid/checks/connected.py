"""Which stretches of rays through undefined points lie in one region: those that see each other, one by the other."""

from __future__ import annotations

from collections.abc import Callable, Sequence
from dataclasses import dataclass
from typing import Any

import numpy as np

from ..shapes.vector import FloatArray

Wall = tuple[int, int]
"""A body and a surface."""

_KEPT, _OF_EACH, _MOST = 600, 24, 6000
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
    walls: tuple[Wall | None, Wall | None]
    origin: FloatArray
    direction: FloatArray

    @property
    def length(self) -> float:
        return float(np.linalg.norm(self.ends[1] - self.ends[0]))


class Roots:
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
class Regions:
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


def regions_of(gaps: list[Gap], free: Free, around: Around, reach: Reach) -> Regions:
    """Regions of undefined points, the one with most stretches first.

    Stretches that share a wall may be of several regions: two gaps beside one plane. They are one where they see each
    other, or others between them, or places to which one walks from them; and where they are neighbours around the
    bend of a wall that they share.
    """
    groups = _sharing(gaps)
    chosen = [gap for group in groups for gap in _some(group, len(gaps))][:_MOST]
    places, roots = _places(chosen), Roots()
    owners = np.repeat(np.arange(len(chosen)), len(_SHARES))
    _see(places, owners, roots, free)
    _bend(chosen, places, roots, around)
    visited, walkers = _walk(places, roots, reach)
    first = len(places)
    places, owners = np.concatenate([places, visited]), np.concatenate([owners, walkers])
    _see_others(places, owners, roots, free, first)
    numbers: dict[Any, int] = {}
    region = np.array([numbers.setdefault(roots.of(k), len(numbers)) for k in range(len(chosen))], np.int64)
    result = Regions([[] for _ in numbers], places, region[owners])
    _assign(groups, {id(gap): int(k) for gap, k in zip(chosen, region, strict=True)}, result, free)
    order = sorted((k for k, own in enumerate(result.stretches) if own), key=lambda k: -len(result.stretches[k]))
    rank = np.full(len(numbers), -1)
    rank[order] = np.arange(len(order))
    return Regions([result.stretches[k] for k in order], places, rank[result.region])


def _sharing(gaps: list[Gap]) -> list[list[Gap]]:
    """Stretches that share a wall, directly or one by the other; those without any walls together."""
    roots = Roots()
    for gap in gaps:
        roots.join(gap.walls[0] or gap.walls[1], gap.walls[1] or gap.walls[0])
    groups: dict[Any, list[Gap]] = {}
    for gap in gaps:
        groups.setdefault(roots.of(gap.walls[0] or gap.walls[1]), []).append(gap)
    return sorted(groups.values(), key=len, reverse=True)


def _some(group: list[Gap], count: int) -> list[Gap]:
    """A share of a group, at least a few."""
    kept = max(_OF_EACH, _KEPT * len(group) // count)
    return group[:: -(-len(group) // kept)]


def _places(gaps: Sequence[Gap]) -> FloatArray:
    """Points within stretches, (3 n, 3)."""
    ends, shares = np.array([gap.ends for gap in gaps]).reshape(-1, 2, 3), np.array(_SHARES)[:, None]
    result: FloatArray = ends[:, :1] + shares * (ends[:, 1:] - ends[:, :1])
    return result.reshape(-1, 3)


def _see(places: FloatArray, owners: Any, roots: Roots, free: Free) -> None:
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


def _see_others(places: FloatArray, owners: Any, roots: Roots, free: Free, first: int) -> None:
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


def _walk(places: FloatArray, roots: Roots, reach: Reach) -> tuple[FloatArray, Any]:
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


def _bend(gaps: Sequence[Gap], places: FloatArray, roots: Roots, around: Around) -> None:
    """Join neighbours that share a wall, and between which lies the bend of one: the parts of a thin shell."""
    middles = places[len(_SHARES) // 2 :: len(_SHARES)]
    by_wall: dict[Wall, list[int]] = {}
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


def _assign(groups: list[list[Gap]], known: dict[int, int], regions: Regions, free: Free) -> None:
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
