"""`check`: look for probable mistakes in a scene, and give a ray that shows each of them.

Random rays find overlaps, slivers, empty bodies and undefined regions. Coefficients of surfaces give near-coincidences,
and the numbers of shapes give lost digits; neither needs a ray.
"""

from __future__ import annotations

from collections.abc import Callable, Iterator
from typing import Any

import numpy as np

from ..._util.arrays import FloatArray, IndexArray, ignore_fp_errors
from ..._util.records import dataclass
from ..._util.validation import check_callback, check_integer
from ...geometry.body import Body
from ...geometry.instances import InstanceList
from ...geometry.shape import Shape
from ...kernels.tables import BALL, PLANE, POLYGON, SHEET, Tables
from ...queries.result import extension
from ...queries.scene_protocol import SceneLike
from ..derivatives.quadric_form import SurfaceUsers, forms_of, shift_forms
from .conditioning import SINGLE_PRECISION_DIGITS, Conditioning, conditioning
from .findings import COINCIDENCE, DIGITS, EMPTY, OVERLAP, SLIVER, Finding, Findings, body_titles
from .probe_rays import THIN, ProbeRays, ProbeScan, ProbeTargets, Sighting, rays_through
from .undefined_regions import skipped_checks, undefined_regions

# --- Near-coincidence: surfaces that are equal up to rounding, but not equal, where one was meant
#
# Two surfaces are compared by their coefficients about the middle of the common box of two bodies, in units of its
# size. Candidates are surfaces whose coefficients over the whole scene differ little.

CLOSE = 1e-12
"""Relative difference of coefficients below which surfaces are nearly coincident."""

_FAR_OFF = 1e-11
"""The same for candidates, over the whole scene."""
_MOST_PAIRS = 20_000
"""The search for candidates ends after about so many."""


@dataclass(frozen=True)
class NearPair:
    """Two surfaces, a body of each, the relative difference of their coefficients, and the common box of the bodies."""

    surfaces: tuple[int, int]
    bodies: tuple[int, int]
    difference: float
    low: FloatArray
    high: FloatArray


def near_pairs(tables: Tables, targets: ProbeTargets) -> Iterator[NearPair]:
    """Yield pairs of surfaces that nearly coincide in the common box of two bodies with them, or of one with both."""
    users = SurfaceUsers.of(tables)
    for one, other in _candidates(tables, targets):
        a, b = users.bodies(one), users.bodies(other)
        first, second = np.repeat(a, len(b)), np.tile(b, len(a))
        low, high = targets.common(first, second)
        # Boxes that touch up to rounding have a common part
        margin = CLOSE * np.minimum(targets.sizes[first], targets.sizes[second])[:, None]
        meeting = np.flatnonzero((low <= high + margin).all(axis=1))
        if not len(meeting):
            continue
        # The largest common box of all pairs of bodies
        k = meeting[np.argmax(np.linalg.norm(high - low, axis=1)[meeting])]
        difference = _difference(coefficients(tables, np.array([one, other]), low[k], high[k]))
        if difference <= CLOSE:
            yield NearPair((one, other), (int(first[k]), int(second[k])), difference, low[k], high[k])


def _candidates(tables: Tables, targets: ProbeTargets) -> Iterator[tuple[int, int]]:
    """Yield pairs of surfaces that differ little over the whole window: neighbours along a random projection.

    The projection has a fixed seed. Its absolute value is compared, as the sign of a surface's equation is arbitrary.
    """
    surfaces = np.arange(len(tables.surface_kind))
    rows = coefficients(tables, surfaces, *targets.window)
    place = np.abs(rows @ np.random.default_rng(20261121).normal(size=10))
    order = np.argsort(place, kind="stable")
    count = 0
    # Neighbours of distance 1, 2 and so on in the order, until none of them is close
    for step in range(1, len(order)):
        near = np.flatnonzero(place[order[step:]] - place[order[:-step]] <= _FAR_OFF)
        if not len(near) or count > _MOST_PAIRS:
            return
        for one, other in zip(order[near].tolist(), order[near + step].tolist(), strict=True):
            if _difference(rows[[one, other]]) <= _FAR_OFF:
                yield min(one, other), max(one, other)
                count += 1


def _difference(rows: FloatArray) -> float:
    """Return the largest difference of two rows of coefficients, whatever the sign of each row."""
    return float(min(np.abs(rows[0] - rows[1]).max(), np.abs(rows[0] + rows[1]).max()))


def coefficients(tables: Tables, surfaces: Any, low: FloatArray, high: FloatArray) -> FloatArray:
    """Return coefficients (n, 10) of xx, yy, zz, xy, xz, yz, x, y, z, 1 of some surfaces; the largest of a row is ±1.

    Coordinates are about the middle of the box low (3,) to high (3,), in units of half its largest side.
    """
    center, half = low / 2 + high / 2, max(float(np.abs(high / 2 - low / 2).max()), 1e-290)
    forms, anchors = forms_of(tables, surfaces)
    result = shift_forms(forms, center - anchors) * ([half * half] * 6 + [half] * 3 + [1.0])
    result[tables.surface_kind[surfaces] == PLANE, 6:9] *= 2  # a plane has the normal itself
    # Coefficients that are all 0 stay 0
    largest = np.abs(result).max(axis=1, keepdims=True)
    return result / np.where(largest > 0, largest, 1.0)


# --- The check

_PAIRS_OF_A_QUERY = 256
"""Pairs of nearly coincident surfaces whose rays are traced together."""
_FOR_A_PAIR = 64
"""Rays through the common box of each pair of nearly coincident surfaces."""
_FOR_THE_UNSEEN = 256
"""Rays through the box of each body that no ray has hit, at most `rays` in all."""
_MOST_BALLS = 1000
"""Balls of one entry of `Spheres` that are reported for lost digits: the worst."""
_MOST_RAYS = 10**9

Progress = Callable[[int, int], Any]
"""progress(done, total)"""


@ignore_fp_errors
def check(
    scene: SceneLike | Shape | Body, rays: int = 200_000, seed: int = 0, progress: Progress | None = None
) -> Findings:
    """Find overlaps, slivers, nearly coincident surfaces, empty bodies, lost digits and undefined regions.

    About a third of `rays` each goes through the whole scene, through the boxes of single bodies, and through the
    common boxes of two bodies. More rays go through nearly coincident surfaces, through bodies that no ray has hit, and
    into the domain. Overlaps, slivers and undefined regions that no ray crosses are not reported. Near-coincidences and
    lost digits need no ray: they follow from the numbers of the shapes. A region is undefined if it lies in the scene's
    `domain`, as imported models have one, and in no body; a scene without a domain is not searched for them.

    Parameters
    ----------
    scene : Scene, Shape or Body
        A shape or a body is checked as a scene of its own.
    rays : int
        About how many rays to trace, 1 to 1e9.
    seed : int
        Seed of the random rays; equal seeds give equal findings.
    progress : callable, optional
        progress(done, total) is called after each of the 6 steps.

    Returns
    -------
    Findings
        A list of `Finding`, kind by kind, the worst of each kind first. Its `omissions` names the checks that
        were skipped, with the reason.

    Raises
    ------
    TypeError, ValueError
        For wrong arguments.
    """
    whole: SceneLike = extension("as_scene")("check", scene)
    check_callback("check", "progress", progress)
    rays, seed = check_integer("check", "rays", rays, 1, _MOST_RAYS), check_integer("check", "seed", seed, 0)
    whole._close_gaps()
    lowered = whole._prepared.lowered
    targets, random = ProbeTargets.of(lowered), np.random.default_rng(seed)
    # Without bodies, all of the domain is undefined
    if lowered.body_count == 0:
        return Findings(undefined_regions(whole, targets, rays, random), skipped_checks(whole))
    solid = (lowered.tables.entry_kind != SHEET) & (lowered.tables.entry_kind != POLYGON)
    endless = not np.isfinite(lowered.boxes[~targets.empty]).all()
    scan = ProbeScan(whole, targets.sizes, np.zeros(lowered.body_count, bool), solid, endless)
    # Rays through the scene, through bodies and through pairs of bodies
    for part, step in enumerate((_probe_window, _probe_bodies, _probe_pairs)):
        step(scan, targets, rays // 3, random)
        if progress is not None:
            progress(part + 1, 6)
    # Surfaces that nearly coincide: more rays where both are, to show them and the slivers between them
    near = list(near_pairs(lowered.tables, targets))
    for begin in range(0, len(near), _PAIRS_OF_A_QUERY):
        parts = [_rays_through_pair(pair, random) for pair in near[begin : begin + _PAIRS_OF_A_QUERY]]
        origins, directions = (np.concatenate([part[k] for part in parts]) for k in (0, 1))
        scan.follow(ProbeRays(origins, directions))
    if progress is not None:
        progress(4, 6)
    # Bodies that are still unseen after this are reported as empty
    unseen = _probe_unseen(scan, targets, rays, random)
    if progress is not None:
        progress(5, 6)
    undefined = undefined_regions(whole, targets, rays // 3, random)
    # Lost digits follow from the numbers of shapes, without rays
    conditions = conditioning(whole, SINGLE_PRECISION_DIGITS, _MOST_BALLS)
    if progress is not None:
        progress(6, 6)
    findings = [
        *_overlaps(scan),
        *_slivers(scan),
        *_coincidences(scan, near),
        *_empty(scan, targets, unseen),
        *(_few_digits(whole, one) for one in sorted(conditions, key=lambda one: (one.digits, one.body))),
        *undefined,
    ]
    return Findings(findings, skipped_checks(whole))


def _rays_through_pair(pair: NearPair, random: np.random.Generator) -> ProbeRays:
    """Return rays through the common box of a pair."""
    low, high = (np.tile(end, (_FOR_A_PAIR, 1)) for end in (pair.low, pair.high))
    return rays_through(low, np.maximum(low, high), random)


def _probe_window(scan: ProbeScan, targets: ProbeTargets, rays: int, random: np.random.Generator) -> None:
    """Trace rays through the whole scene."""
    scan.follow(targets.through_window(rays, random))


def _probe_bodies(scan: ProbeScan, targets: ProbeTargets, rays: int, random: np.random.Generator) -> None:
    """Trace rays through the boxes of the bodies in turn, in random order."""
    full = np.flatnonzero(~targets.empty)
    if len(full):
        scan.follow(targets.through_bodies(np.resize(random.permutation(full), rays), random))


def _probe_pairs(scan: ProbeScan, targets: ProbeTargets, rays: int, random: np.random.Generator) -> None:
    """Trace rays through the common boxes of pairs of bodies in turn, in random order."""
    one, other = targets.pairs()
    if len(one):
        # Every pair gets rays if there are enough
        picks = np.resize(random.permutation(len(one)), rays)
        scan.follow(targets.through(*targets.common(one[picks], other[picks]), random))


def _probe_unseen(scan: ProbeScan, targets: ProbeTargets, rays: int, random: np.random.Generator) -> Any:
    """Return the ids of bodies that no ray has hit, after more rays through their boxes. A ball is never empty.

    Instances of one shape are empty together: if a ray hits one of them, none is, and rays go through the first alone.
    """
    kinds = _rigid_kinds(scan.scene.bodies, len(scan.is_hit))
    is_ball = scan.scene._prepared.lowered.tables.entry_kind == BALL

    def unseen() -> Any:
        seen = np.zeros(kinds.max() + 1, np.bool_)
        seen[kinds[scan.is_hit | is_ball]] = True
        return ~seen[kinds]

    missing = np.flatnonzero(unseen() & ~targets.empty)
    _, first = np.unique(kinds[missing], return_index=True)
    bodies = np.sort(missing[first])
    if len(bodies):
        # At least one ray for each of the bodies
        picks = np.resize(bodies, min(_FOR_THE_UNSEEN * len(bodies), max(rays, len(bodies))))
        scan.follow(targets.through_bodies(picks, random))
    return np.flatnonzero(unseen())


def _rigid_kinds(bodies: Any, count: int) -> IndexArray:
    """Return a number for each of `count` bodies, which instances of one shape have in common."""
    own = np.arange(count)
    if not isinstance(bodies, InstanceList):
        return own
    rigid = np.array([bodies.is_rigid(kind) for kind in range(len(bodies.members))])
    return np.where(rigid[bodies.kinds], bodies.kinds, len(rigid) + own)


def _by_length(sightings: Any) -> Any:
    """Sort (key, sighting) by length, the longest first, then by key."""
    return sorted(sightings, key=lambda item: (-item[1].length, item[0]))


def _overlaps(scan: ProbeScan) -> list[Finding]:
    """Return a finding for each pair of bodies that overlap by more than a sliver, and for sheets never seen."""
    findings = []
    for bodies, sighting in _by_length(scan.overlaps.items()):
        # A shorter overlap is a sliver, which `_slivers` reports
        if sighting.length > THIN * min(scan.sizes[list(bodies)]):
            message = (
                f"{body_titles(scan.scene, bodies)} overlap: {_ray_count(sighting)} "
                f"within both, for up to {sighting.length:.6g}"
            )
            findings.append(_finding_with_ray(OVERLAP, bodies, message, sighting))
    for bodies in scan.hidden:
        titles = body_titles(scan.scene, bodies)
        message = f"{titles}: the second lies in a wall of the first, or within it, and is never seen"
        findings.append(Finding(OVERLAP, bodies, message, 0.0))
    return findings


def _slivers(scan: ProbeScan) -> list[Finding]:
    """Return a finding for each pair of walls with a sliver between them."""
    findings = []
    for (one, other, first, second), sighting in _by_length(scan.slivers.items()):
        # Both walls of a sliver may be of one body
        bodies = (one,) if one == other else (min(one, other), max(one, other))
        where = "in" if one == other else "between"
        kinds = {"film": "a film", "gap": "a gap", "step": "a step", "overlap": "an overlap"}
        message = (
            f"{kinds[sighting.kind]} {where} {body_titles(scan.scene, bodies)}, {sighting.length:.3g} thick, "
            f"between surfaces {first} and {second}; seen by {sighting.times} ray{'s' * (sighting.times != 1)}"
        )
        findings.append(_finding_with_ray(SLIVER, bodies, message, sighting))
    return findings


def _ray_count(sighting: Sighting) -> str:
    """Return '1 ray is' or '5 rays are'."""
    return f"{sighting.times} ray{'s are' if sighting.times != 1 else ' is'}"


def _coincidences(scan: ProbeScan, near: list[NearPair]) -> list[Finding]:
    """Return the findings of pairs, with a ray on which both surfaces follow each other if the scan has one."""
    sightings: dict[frozenset[int], Sighting] = {}
    for key, sighting in scan.slivers.items():
        sightings.setdefault(frozenset(key[2:]), sighting)
    findings = []
    for pair in near:
        bodies = tuple(sorted(set(pair.bodies)))
        message = (
            f"surfaces {pair.surfaces[0]} and {pair.surfaces[1]} of {body_titles(scan.scene, bodies)} "
            f"differ by {pair.difference:.2g} of their size; written alike, they would be one"
        )
        seen = sightings.get(frozenset(pair.surfaces))
        if seen is None:
            findings.append(Finding(COINCIDENCE, bodies, message, pair.difference))
        else:
            findings.append(_finding_with_ray(COINCIDENCE, bodies, message, seen, pair.difference))
    return findings


def _empty(scan: ProbeScan, targets: ProbeTargets, bodies: Any) -> list[Finding]:
    """Return a finding for each of the bodies that no ray has hit."""
    findings = []
    for body in bodies.tolist():
        why = "its bounds are empty" if targets.empty[body] else f"none of {scan.rays:,} rays hits it"
        findings.append(Finding(EMPTY, (body,), f"{body_titles(scan.scene, (body,))} is empty: {why}", 0.0))
    return findings


def _few_digits(scene: SceneLike, condition: Conditioning) -> Finding:
    """Return the finding of a body that loses digits."""
    place = ", ".join(f"{c:.6g}" for c in condition.point.tolist())
    message = (
        f"{body_titles(scene, (condition.body,))} keeps {condition.digits:.1f} of 16 digits near ({place}): "
        f"{condition.reason}; {condition.number} of its {condition.part} counts most"
    )
    return Finding(DIGITS, (condition.body,), message, condition.digits)


def _finding_with_ray(
    kind: str, bodies: tuple[int, ...], message: str, sighting: Sighting, size: float | None = None
) -> Finding:
    """Return a finding with the ray of a sighting; its size is the length of the sighting unless given."""
    # Copies, as the rows of a sighting would keep the arrays of all rays alive; read-only, as findings are
    origin, direction = sighting.origin.copy(), sighting.direction.copy()
    origin.flags.writeable = direction.flags.writeable = False
    return Finding(kind, bodies, message, sighting.length if size is None else size, origin, direction)
