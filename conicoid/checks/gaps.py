"""Where bodies leave part of a scene's domain empty: points that a model says are in a cell, and that are in none."""

from __future__ import annotations

from collections.abc import Iterator
from dataclasses import dataclass
from typing import TYPE_CHECKING, Any

import numpy as np

from ..shapes.vector import FloatArray
from .aim import Targets
from .finding import UNDEFINED, Finding, titles
from .scan import CHUNK, THIN

if TYPE_CHECKING:
    from ..scene import Scene

_POINTS = 4096
"""Points by which a volume is estimated."""
_NAMED = 4
_MOST, _KEPT, _PAIRS, _STEPS = 64, 48, 24, 16
"""Regions that are compared, stretches of each that are, pairs of places, and points between them."""
Wall = tuple[int, int]
"""A body and a surface."""


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


def undefined_regions(scene: Scene, targets: Targets, rays: int, random: np.random.Generator) -> list[Finding]:
    """One finding for each region, told apart by the walls around them; the largest first."""
    from ..scene import Scene

    if scene.domain is None or why_not(scene):
        return []
    domain = Scene(scene.domain)
    around = Targets.of(domain.lowered)
    low, high = around.window
    bodies = np.flatnonzero(~targets.empty)
    aims = [around.through_window(rays // 2 + 1, random)]
    if len(bodies):
        aims.append(targets.through_bodies(np.resize(bodies, max(rays // 2, 4 * len(bodies))), random))
    gaps: list[Gap] = []
    for origins, directions in aims:
        for begin in range(0, len(origins), CHUNK):
            some = slice(begin, begin + CHUNK)
            gaps += _seen(scene, domain, origins[some], directions[some], float(np.linalg.norm(high - low)))
    regions = _joined(scene, domain, _together(gaps))
    found = [_finding(scene, domain, regions, k, random) for k in range(len(regions))]
    return sorted(found, key=lambda finding: -finding.size)


def why_not(scene: Scene) -> str:
    """Why undefined regions of a scene are not looked for; empty where they are."""
    from ..scene import Scene

    if scene.domain is None:
        return "the scene has no domain, which says where bodies are to be"
    around = Targets.of(Scene(scene.domain).lowered)
    low, high = around.window
    return "the scene's domain is empty" if around.empty.all() or not (low < high).all() else ""


def _seen(scene: Scene, domain: Scene, origins: FloatArray, directions: FloatArray, size: float) -> Iterator[Gap]:
    """Stretches within the domain and in no body, longer than what rounding leaves between walls."""
    parts = [(scene.spans(origins, directions), 0), (domain.spans(origins, directions), 1)]
    ray = np.concatenate([np.tile(np.repeat(np.arange(len(origins)), np.diff(s.offsets)), 2) for s, _ in parts])
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


def _is_undefined(scene: Scene, domain: Scene, points: FloatArray) -> Any:
    return domain.contains(points) & ~scene.contains(points)


def _together(gaps: list[Gap]) -> list[list[Gap]]:
    """Stretches that share a wall lie in one region; those without any walls are taken for one too."""
    parent: dict[Any, Any] = {}

    def root(wall: Any) -> Any:
        while parent.setdefault(wall, wall) != wall:
            parent[wall] = wall = parent[parent[wall]]
        return wall

    for gap in gaps:
        walls: list[Wall | None] = [wall for wall in gap.walls if wall is not None]
        walls = walls or [None]
        parent[root(walls[0])] = root(walls[-1])
    groups: dict[Any, list[Gap]] = {}
    for gap in gaps:
        wall = gap.walls[0] if gap.walls[0] is not None else gap.walls[1]
        groups.setdefault(root(wall), []).append(gap)
    return list(groups.values())


def _nearest(points: FloatArray, places: FloatArray) -> FloatArray:
    """The squared distance of each point from the nearest of some places."""
    result: FloatArray = ((points[:, None] - places[None]) ** 2).sum(axis=2).min(axis=1, initial=np.inf)
    return result


def _joined(scene: Scene, domain: Scene, groups: list[list[Gap]]) -> list[list[Gap]]:
    """Groups of which some neighbouring stretches see each other through undefined points are one region."""
    groups = sorted(groups, key=len, reverse=True)
    joined: list[list[Gap]] = []
    for group in groups[:_MOST]:
        home = next((other for other in joined if _see_each_other(scene, domain, group, other)), None)
        if home is None:
            joined.append(group)
        else:
            home += group
    return joined + groups[_MOST:]


def _see_each_other(scene: Scene, domain: Scene, one: list[Gap], other: list[Gap]) -> bool:
    a, b = _places(one), _places(other)
    apart = np.linalg.norm(a[:, None] - b[None], axis=2)
    near = np.argsort(apart, axis=None, kind="stable")[:_PAIRS]
    first, second = a[near // len(b)], b[near % len(b)]
    steps = np.linspace(0, 1, _STEPS)[:, None, None]
    return bool(_is_undefined(scene, domain, first + steps * (second - first)).all(axis=0).any())


def _places(gaps: list[Gap]) -> FloatArray:
    """Points within the stretches, (n, 3)."""
    some = gaps[:: -(-len(gaps) // _KEPT)]
    shares = np.array([0.05, 0.5, 0.95])[:, None]
    return np.concatenate([gap.ends[0] + shares * (gap.ends[1] - gap.ends[0]) for gap in some])


def _finding(scene: Scene, domain: Scene, regions: list[list[Gap]], which: int, random: np.random.Generator) -> Finding:
    gaps = regions[which]
    ends = np.concatenate([gap.ends for gap in gaps])
    low, high = ends.min(axis=0), ends.max(axis=0)
    points = low + (high - low) * random.random((_POINTS, 3))
    inside = points[_is_undefined(scene, domain, points)]
    own = [_nearest(inside, _places(region)) for region in regions[:_MOST]] if which < _MOST else []
    is_own = np.argmin(own, axis=0) == which if own else np.ones(len(inside), bool)  # and not of another region
    volume = float(np.prod(high - low)) * int(is_own.sum()) / _POINTS
    longest = max(gaps, key=lambda gap: (sum(wall is not None for wall in gap.walls), gap.length))
    point = longest.ends.mean(axis=0)
    bodies = tuple(sorted({wall[0] for gap in gaps for wall in gap.walls if wall is not None}))
    beside = f" beside {titles(scene, bodies[:_NAMED])}" if bodies else ""
    more = f" and {len(bodies) - _NAMED} more" if len(bodies) > _NAMED else ""
    place, sides = (", ".join(f"{c:.6g}" for c in row.tolist()) for row in (point, high - low))
    message = (
        f"({place}) is in no body, though the scene's domain holds it; the region{beside}{more} reaches over about "
        f"({sides}), a volume of about {volume:.2g}; seen by {len(gaps)} ray{'s' * (len(gaps) != 1)}"
    )
    for array in (point, longest.origin, longest.direction):
        array.flags.writeable = False
    return Finding(UNDEFINED, bodies, message, volume, longest.origin.copy(), longest.direction.copy(), point)
