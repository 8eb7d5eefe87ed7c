"""Look for what a scene's author may not have meant, and show each with a ray."""

from __future__ import annotations

from collections.abc import Callable
from typing import TYPE_CHECKING, Any

import numpy as np

from ..._util.errstate import ignore_fp_errors
from ..._util.validation import check_callback, check_integer
from ...kernels.tables import BALL
from ...queries.extensions import extension
from .conditioning import SINGLE_PRECISION_DIGITS, Conditioning, conditioning
from .findings import COINCIDENCE, DIGITS, EMPTY, OVERLAP, SLIVER, Finding, Findings, body_titles
from .near_coincidence import NearPair, near_pairs
from .probe_rays import THIN, ProbeScan, ProbeTargets, Sighting, rays_through
from .undefined_regions import skipped_checks, undefined_regions

if TYPE_CHECKING:
    from ...geometry.body import Body
    from ...geometry.shape import Shape
    from ...queries.scene_protocol import SceneLike

_FOR_A_PAIR = 64
_FOR_THE_UNSEEN = 256
_MOST_BALLS = 1000
_MOST_RAYS = 10**9

Progress = Callable[[int, int], Any]


@ignore_fp_errors
def check(
    scene: SceneLike | Shape | Body, rays: int = 200_000, seed: int = 0, progress: Progress | None = None
) -> Findings:
    """Overlaps, slivers, nearly coincident surfaces, empty bodies, lost digits, undefined regions; worst first of each.

    scene: a shape or a body is checked as a scene of it.
    rays: about how many rays are followed, of each kind.
    seed: of their places; equal seeds give equal findings.
    progress: progress(done, count) is called with steps of the check.

    About `rays` rays go through the whole scene, through every body, and where boxes of two bodies meet; more
    through surfaces that are nearly equal and bodies that none has met. What no ray has seen is not
    reported, but for surfaces and digits: those follow from the numbers that were written. Regions are undefined
    where a scene has a `domain`, as imported models have, and points of it are in no body; `not_looked_for` of the
    answer says so where there is none.
    """
    whole: SceneLike = extension("as_scene")("check", scene)
    check_callback("check", "progress", progress)
    rays, seed = check_integer("check", "rays", rays, 1, _MOST_RAYS), check_integer("check", "seed", seed, 0)
    lowered = whole.lowered
    targets, random = ProbeTargets.of(lowered), np.random.default_rng(seed)
    if lowered.body_count == 0:
        return Findings(undefined_regions(whole, targets, rays, random), skipped_checks(whole))
    scan = ProbeScan(whole, targets.sizes, np.zeros(lowered.body_count, bool))
    for part, step in enumerate((_probe_window, _probe_bodies, _probe_pairs)):
        step(scan, targets, rays // 3, random)
        if progress is not None:
            progress(part + 1, 6)
    near = list(near_pairs(lowered.tables, targets))
    for pair in near:
        low, high = (np.tile(end, (_FOR_A_PAIR, 1)) for end in (pair.low, pair.high))
        scan.follow(*rays_through(low, np.maximum(low, high), random))
    if progress is not None:
        progress(4, 6)
    unseen = _probe_unseen(scan, targets, rays, random)
    if progress is not None:
        progress(5, 6)
    undefined = undefined_regions(whole, targets, rays // 3, random)
    few = conditioning(whole, SINGLE_PRECISION_DIGITS, _MOST_BALLS)
    if progress is not None:
        progress(6, 6)
    found = [
        *_overlaps(scan),
        *_slivers(scan),
        *(_coincidence(scan, pair) for pair in near),
        *_empty(scan, targets, unseen),
        *(_few_digits(whole, one) for one in sorted(few, key=lambda one: (one.digits, one.body))),
        *undefined,
    ]
    return Findings(found, skipped_checks(whole))


def _probe_window(scan: ProbeScan, targets: ProbeTargets, rays: int, random: np.random.Generator) -> None:
    scan.follow(*targets.through_window(rays, random))


def _probe_bodies(scan: ProbeScan, targets: ProbeTargets, rays: int, random: np.random.Generator) -> None:
    full = np.flatnonzero(~targets.empty)
    if len(full):
        scan.follow(*targets.through_bodies(np.resize(random.permutation(full), rays), random))


def _probe_pairs(scan: ProbeScan, targets: ProbeTargets, rays: int, random: np.random.Generator) -> None:
    one, other = targets.pairs()
    if len(one):
        chosen = np.resize(random.permutation(len(one)), rays)
        scan.follow(*rays_through(*targets.common(one[chosen], other[chosen]), random))


def _probe_unseen(scan: ProbeScan, targets: ProbeTargets, rays: int, random: np.random.Generator) -> Any:
    """Bodies that no ray has met, after some more through their boxes. A ball is never empty."""
    tables = scan.scene.lowered.tables
    missing = ~scan.seen
    missing[tables.entry_kind == BALL] = False
    bodies = np.flatnonzero(missing & ~targets.empty)
    if len(bodies):
        scan.follow(
            *targets.through_bodies(
                np.resize(bodies, min(_FOR_THE_UNSEEN * len(bodies), max(rays, len(bodies)))), random
            )
        )
    return np.flatnonzero(missing & ~scan.seen)


def _ordered(sightings: Any) -> Any:
    return sorted(sightings, key=lambda item: (-item[1].length, item[0]))


def _overlaps(scan: ProbeScan) -> list[Finding]:
    found = []
    for bodies, sighting in _ordered(scan.overlaps.items()):
        if sighting.length > THIN * min(scan.sizes[list(bodies)]):
            message = (
                f"{body_titles(scan.scene, bodies)} overlap: {_times(sighting)} "
                f"within both, for up to {sighting.length:.6g}"
            )
            found.append(_finding_with_ray(OVERLAP, bodies, message, sighting))
    return found


def _slivers(scan: ProbeScan) -> list[Finding]:
    found = []
    for (one, other, first, second), sighting in _ordered(scan.slivers.items()):
        bodies = (one,) if one == other else (min(one, other), max(one, other))
        where = "in" if one == other else "between"
        kinds = {"film": "a film", "gap": "a gap", "step": "a step", "overlap": "an overlap"}
        message = (
            f"{kinds[sighting.what]} {where} {body_titles(scan.scene, bodies)}, {sighting.length:.3g} thick, "
            f"between surfaces {first} and {second}; seen by {sighting.times} ray{'s' * (sighting.times != 1)}"
        )
        found.append(_finding_with_ray(SLIVER, bodies, message, sighting))
    return found


def _times(sighting: Sighting) -> str:
    return f"{sighting.times} ray{'s are' if sighting.times != 1 else ' is'}"


def _coincidence(scan: ProbeScan, pair: NearPair) -> Finding:
    """Shown by a ray on which both surfaces were seen next to each other, if there was one."""
    bodies = tuple(sorted(set(pair.bodies)))
    message = (
        f"surfaces {pair.surfaces[0]} and {pair.surfaces[1]} of {body_titles(scan.scene, bodies)} "
        f"differ by {pair.difference:.2g} of their size; written alike, they would be one"
    )
    shown = [sighting for key, sighting in scan.slivers.items() if set(key[2:]) == set(pair.surfaces)]
    if shown:
        return _finding_with_ray(COINCIDENCE, bodies, message, shown[0], pair.difference)
    return Finding(COINCIDENCE, bodies, message, pair.difference)


def _empty(scan: ProbeScan, targets: ProbeTargets, bodies: Any) -> list[Finding]:
    found = []
    for body in bodies.tolist():
        why = "its bounds are empty" if targets.empty[body] else f"none of {scan.rays:,} rays meets it"
        found.append(Finding(EMPTY, (body,), f"{body_titles(scan.scene, (body,))} is empty: {why}", 0.0))
    return found


def _few_digits(scene: SceneLike, one: Conditioning) -> Finding:
    place = ", ".join(f"{c:.6g}" for c in one.point.tolist())
    message = (
        f"{body_titles(scene, (one.body,))} keeps {one.digits:.1f} of 16 digits near ({place}): {one.reason}; "
        f"{one.number} of its {one.part} counts most"
    )
    return Finding(DIGITS, (one.body,), message, one.digits)


def _finding_with_ray(
    kind: str, bodies: tuple[int, ...], message: str, sighting: Sighting, size: float | None = None
) -> Finding:
    origin, direction = sighting.origin.copy(), sighting.direction.copy()
    origin.flags.writeable = direction.flags.writeable = False
    return Finding(kind, bodies, message, sighting.length if size is None else size, origin, direction)
