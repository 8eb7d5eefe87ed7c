"""The library's crossings against the oracle's: wrong hits, wrong misses, and how far t is off.

A crossing at distance D = |t| |d| of a solid of size S must be within

    |t - t_exact| |d| <= max(1e-13 (D + S), half of the undecided stretch around it),

the stretch being eta / |cos θ| wide on each side (`trace.py`): the first bound rules unless the ray
meets the surface at a grazing angle of |cos θ| < 1/56 (or the solid was moved from far away).
"""

from __future__ import annotations

from collections.abc import Iterable
from dataclasses import dataclass, field, replace
from typing import Any

import numpy as np

from .cases import Case
from .precision import mp, number
from .restricted import Crossing, Line, line
from .sheets import SheetCrossing, sheet_crossings
from .trace import Run, trace

TOLERANCE = mp.mpf("1e-13")
ULP = mp.mpf(2) ** -53
STEEP = 1 / 56
"""|cos θ| from which the bound of 1e-13 holds as it stands."""


@dataclass(frozen=True)
class Found:
    """One crossing that the library reports."""

    t: Any
    entering: bool
    face: int


@dataclass
class Score:
    """What a comparison counted; `failures` are messages that reproduce."""

    rays: int = 0
    crossings: int = 0
    in_band: int = 0
    wrong_hits: int = 0
    wrong_misses: int = 0
    errors: list[float] = field(default_factory=list)
    """|t - t_exact| |d| / (D + S) of every crossing that the band leaves certain."""
    steep_errors: list[float] = field(default_factory=list)
    """The same where |cos θ| >= STEEP."""
    displacements: list[float] = field(default_factory=list)
    """error · |cos θ| in units of 2^-53: how far beside the surface the crossing lies."""
    normals: list[float] = field(default_factory=list)
    """|normal - exact| of first hits."""
    failures: list[str] = field(default_factory=list)

    def add(self, other: Score) -> None:
        for name, value in vars(other).items():
            setattr(self, name, getattr(self, name) + value)

    @property
    def median(self) -> float:
        return float(np.median(self.errors)) if self.errors else 0.0


@dataclass
class Cluster:
    """Runs whose tolerances overlap, or one root of a sheet: what must be found in [low, high]."""

    low: Any
    high: Any
    expected: list[tuple[Crossing, Any]]
    certain: bool
    parity: int | None = None


def reach_of(case: Case, ray: Line) -> Any:
    """How far crossings are compared: ten million sizes along an unbounded solid, and all of a bounded one."""
    away = mp.norm([a - b for a, b in zip(ray.origin, map(number, case.world_center), strict=True)])
    return (4 if case.bounded else 10**7) * (number(case.world_size) + away) / ray.speed


def compare(case: Case, library: Any, origins: np.ndarray, directions: np.ndarray) -> Score:
    """Every ray of a case."""
    scene = library.Scene([case.shape(library)])
    lines = [line(o, d) for o, d in zip(origins, directions, strict=True)]
    reaches = [reach_of(case, ray) for ray in lines]
    limit = np.full(len(lines), np.inf) if case.bounded else np.array([float(r) for r in reaches])
    crossings = scene.crossings(origins, directions, t_min=-limit, t_max=limit)
    first = scene.first_hit(origins, directions, t_max=limit)
    reference = case.reference()
    score = Score(rays=len(lines))
    for i, (ray, reach) in enumerate(zip(lines, reaches, strict=True)):
        rows = slice(int(crossings.offsets[i]), int(crossings.offsets[i + 1]))
        found = [
            Found(mp.mpf(float(t)), bool(e), int(f))
            for t, e, f in zip(crossings.t[rows], crossings.entering[rows], crossings.face[rows], strict=True)
        ]
        clusters = _clusters(case, reference, ray, reach)
        one = Score(crossings=len(found), in_band=int(not all(c.certain for c in clusters)))
        pairs = _match(clusters, found, ray, number(case.world_size), one)
        ahead = [f.t for f in found if f.t > 0]
        if float(first.t[i]) != (float(ahead[0]) if ahead else np.inf):
            one.failures.append(f"first_hit.t = {first.t[i]} but crossings begin with {ahead[:1]}")
        elif ahead and ahead[0] in pairs:
            _check_place(first.point[i], first.normal[i], ahead[0], pairs[ahead[0]], ray, one)
        one.failures = [_message(case, origins[i], directions[i], text, found, clusters) for text in one.failures]
        score.add(one)
    return score


def _clusters(case: Case, reference: Any, ray: Line, reach: Any) -> list[Cluster]:
    size = number(case.world_size)
    if case.is_sheet:
        return _merged(_sheet_cluster(c, ray, size) for c in sheet_crossings(reference, ray, size, reach))
    return _merged(_run_cluster(run, ray, size) for run in trace(reference, ray, size, reach).runs)


def _tolerance(t: Any, ray: Line, size: Any) -> Any:
    return TOLERANCE * (abs(t) * ray.speed + size) / ray.speed


def _run_cluster(run: Run, ray: Line, size: Any) -> Cluster:
    middle = (run.low + run.high) / 2
    parity = None if run.before is None or run.after is None else int(run.before is not run.after)
    half = (run.high - run.low) / 2
    tolerance = _tolerance(middle, ray, size)
    expected = [(_known_face(c, run), max(half, tolerance)) for c in run.crossings]
    return Cluster(run.low - tolerance, run.high + tolerance, expected, run.certain, parity)


def _known_face(crossing: Crossing, run: Run) -> Crossing:
    face = crossing.face if len(run.surfaces) <= 1 else None
    return replace(crossing, face=face)


def _sheet_cluster(root: SheetCrossing, ray: Line, size: Any) -> Cluster:
    tolerance = _tolerance(root.crossing.t, ray, size)
    reach = max(root.slack, tolerance)
    t = root.crossing.t
    return Cluster(t - reach, t + reach, [(root.crossing, reach)], root.on is True, None)


def _merged(clusters: Iterable[Cluster]) -> list[Cluster]:
    merged: list[Cluster] = []
    for cluster in clusters:
        if merged and cluster.low <= merged[-1].high:
            last = merged[-1]
            parity = None if last.parity is None or cluster.parity is None else last.parity ^ cluster.parity
            merged[-1] = Cluster(
                last.low,
                max(last.high, cluster.high),
                last.expected + cluster.expected,
                last.certain and cluster.certain,
                parity,
            )
        else:
            merged.append(cluster)
    return merged


def _match(clusters: list[Cluster], found: list[Found], ray: Line, size: Any, score: Score) -> dict[Any, Crossing]:
    """Count and complain; the exact crossing for each t that has a certain one."""
    pairs: dict[Any, Crossing] = {}
    for f in found:
        if not any(c.low <= f.t <= c.high for c in clusters):
            score.wrong_hits += 1
            score.failures.append(f"wrong hit at t = {mp.nstr(f.t, 20)}")
    for cluster in clusters:
        held = [f for f in found if cluster.low <= f.t <= cluster.high]
        if cluster.certain:
            _match_certain(cluster, held, ray, size, score)
            pairs.update({f.t: exact for f, (exact, _) in zip(held, cluster.expected, strict=False)})
        elif cluster.parity is not None and len(held) % 2 != cluster.parity:
            score.failures.append(f"odd number of crossings in the band at t = {mp.nstr(cluster.low, 20)}: {len(held)}")
            score.wrong_misses += 1
    return pairs


def _check_place(point: Any, normal: Any, t: Any, exact: Crossing, ray: Line, score: Score) -> None:
    """The point as o + t d to a few roundings; the normal as exact as its curvature and the point let it be."""
    wanted = ray.at(t)
    reach = max(abs(x) for x in (*ray.origin, *wanted))
    if max(abs(mp.mpf(float(p)) - x) for p, x in zip(point, wanted, strict=True)) > 4 * ULP * reach:
        score.failures.append(f"point {tuple(point)} is not o + t d")
    off = abs(t - exact.t) * ray.speed + 8 * ULP * reach
    if exact.face is None or exact.bend * off > mp.mpf("1e-3"):
        return
    turned = mp.norm([mp.mpf(float(n)) - x for n, x in zip(normal, exact.normal, strict=True)])
    if turned > 2 * exact.bend * off + 16 * ULP:
        score.failures.append(f"normal {tuple(normal)} is {mp.nstr(turned, 5)} off")
    score.normals.append(float(turned))


def _match_certain(cluster: Cluster, held: list[Found], ray: Line, size: Any, score: Score) -> None:
    missing = len(cluster.expected) - len(held)
    if missing:
        score.wrong_misses += max(missing, 0)
        score.wrong_hits += max(-missing, 0)
        score.failures.append(
            f"{len(held)} crossings instead of {len(cluster.expected)} at t = {mp.nstr(cluster.low, 20)}"
        )
        return
    for f, (exact, allowed) in zip(held, cluster.expected, strict=True):
        off = abs(f.t - exact.t)
        if off > allowed:
            score.failures.append(
                f"t = {mp.nstr(f.t, 20)} is {mp.nstr(off, 5)} off {mp.nstr(exact.t, 20)}, allowed {mp.nstr(allowed, 5)}"
            )
        if f.entering != exact.entering:
            score.failures.append(f"entering is {f.entering} at t = {mp.nstr(f.t, 20)}")
        if exact.face is not None and f.face != exact.face:
            score.failures.append(f"face is {f.face} instead of {exact.face} at t = {mp.nstr(f.t, 20)}")
        relative = float(off * ray.speed / (abs(exact.t) * ray.speed + size))
        cosine = abs(float(exact.cosine))
        score.errors.append(relative)
        score.displacements.append(relative * cosine * 2.0**53)
        if cosine >= STEEP:
            score.steep_errors.append(relative)


def _message(case: Case, origin: Any, direction: Any, text: str, found: list[Found], clusters: list[Cluster]) -> str:
    expected = [(mp.nstr(c.t, 20), c.entering, c.face) for cluster in clusters for c, _ in cluster.expected]
    got = [(mp.nstr(f.t, 20), f.entering, f.face) for f in found]
    return (
        f"{text}\n  {case!r}\n  origin {tuple(map(float, origin))}\n  direction {tuple(map(float, direction))}\n"
        f"  expected {expected}\n  found {got}"
    )
