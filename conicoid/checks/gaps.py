"""Where bodies leave part of a scene's domain empty: points that a model says are in a cell, and that are in none."""

from __future__ import annotations

import math
from collections.abc import Iterator
from typing import TYPE_CHECKING, Any

import numpy as np

from ..engine.arrays.owners import owners
from ..shapes.labels import counted
from ..shapes.vector import FloatArray
from .aim import Targets
from .connected import Around, Free, Gap, Reach, Regions, regions_of
from .finding import UNDEFINED, Finding, titles
from .scan import CHUNK, THIN

if TYPE_CHECKING:
    from ..scene import Scene

_POINTS = 4096
"""Points by which a volume is estimated."""
_NAMED = 4
_MOST = 64
"""Regions that are told apart where their boxes meet."""


def undefined_regions(scene: Scene, targets: Targets, rays: int, random: np.random.Generator) -> list[Finding]:
    """One finding for each region, told apart by what sees what; the largest first."""
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
    if not gaps:
        return []
    regions = regions_of(gaps, _free(scene, domain), _around(scene, domain), _reach(scene, domain))
    found = [_finding(scene, domain, regions, k, random) for k in range(len(regions.stretches))]
    return sorted(found, key=lambda finding: -finding.size)


def not_looked_for(scene: Scene) -> list[str]:
    """What a check has left out, and why."""
    reason = why_not(scene)
    return [f"undefined regions ({reason})"] if reason else []


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
    ray = np.concatenate([np.tile(owners(s.offsets), 2) for s, _ in parts])
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


def _finding(scene: Scene, domain: Scene, regions: Regions, which: int, random: np.random.Generator) -> Finding:
    gaps = regions.stretches[which]
    own, volume, error = _sampled(scene, domain, regions, which, random)
    reached = np.concatenate([*(gap.ends for gap in gaps), own])
    longest = max(gaps, key=lambda gap: (sum(wall is not None for wall in gap.walls), gap.length))
    point = longest.ends.mean(axis=0)
    bodies = tuple(sorted({wall[0] for gap in gaps for wall in gap.walls if wall is not None}))
    beside = f" beside {titles(scene, bodies[:_NAMED])}" if bodies else ""
    more = f" and {len(bodies) - _NAMED} more" if len(bodies) > _NAMED else ""
    sides = reached.max(axis=0) - reached.min(axis=0)
    place, reach = (", ".join(f"{c:.6g}" for c in row.tolist()) for row in (point, sides))
    size = f"about {volume:.2g} ± {error:.1g}" if len(own) else f"less than about {3 * error:.1g}"
    message = (
        f"({place}) is in no body, though the scene's domain holds it; the region{beside}{more} reaches over about "
        f"({reach}), a volume of {size}; seen by {counted(len(gaps), 'ray', 'rays')}"
    )
    origin, direction = longest.origin.copy(), longest.direction.copy()
    for array in (point, origin, direction):
        array.flags.writeable = False
    return Finding(UNDEFINED, bodies, message, volume, origin, direction, point, error)


def _sampled(
    scene: Scene, domain: Scene, regions: Regions, which: int, random: np.random.Generator
) -> tuple[FloatArray, float, float]:
    """Points of a region, its volume and the standard error of that, by points of a box around what was seen of it."""
    low, high = _box(regions.stretches[which])
    points = low + (high - low) * random.random((_POINTS, 3))
    inside = points[_is_undefined(scene, domain, points)]
    boxes = [_box(gaps) for gaps in regions.stretches[:_MOST]] if which < _MOST else []
    others = [k for k, (a, b) in enumerate(boxes) if k != which and (a <= high).all() and (low <= b).all()]
    own = inside[regions.of_points(inside, [which, *others], _free(scene, domain)) == which]
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


def _free(scene: Scene, domain: Scene) -> Free:
    def free(one: FloatArray, other: FloatArray) -> Any:
        """Whether all between two points is in the domain and in no body, by the exact spans of the way."""
        way = other - one
        still: Any = ~way.any(axis=1)
        rays = one, np.where(still[:, None], 1.0, way)
        within = domain.spans(*rays, 0, 1)
        ends = within.enter_clipped & within.exit_clipped
        covered = np.bincount(owners(within.offsets), ends, len(one)) > 0
        return still | (covered & (np.diff(scene.spans(*rays, 0, 1).offsets) == 0))

    return free


def _reach(scene: Scene, domain: Scene) -> Reach:
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


def _around(scene: Scene, domain: Scene) -> Around:
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
