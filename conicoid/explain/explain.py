"""`scene.explain`: one ray asked as usual, and all that the kernels did for it gathered into steps."""

from __future__ import annotations

import math
from typing import TYPE_CHECKING, Any

import numpy as np

from ..engine.answers.rays import Rays
from ..engine.certified.settle import ranks_of
from ..engine.queries import recorded as kernels
from ..engine.queries.queries import as_rays
from ..engine.surface.decide import CROSSES
from ..scene_parts import named
from .culled import ball_test, box_test, missed_ball, missed_box
from .explanation import Explanation, plain
from .line import Line
from .on_bodies import KINDS, Bodies
from .on_surfaces import Surfaces
from .outcomes import finished, worked_all_the_same
from .recording import Recording
from .steps import BodyStep, Crossing, Decision, Place, Span

if TYPE_CHECKING:
    from ..scene import Scene

MOST_MISSED = 16
"""Bodies left out by the tree that are told of one by one."""
FEW = 8
"""In a scene of no more bodies, also those that are left out are worked out."""
_LONGEST = 160


def explain(scene: Scene, origin: Any, direction: Any, t_min: Any, t_max: Any, body: Any) -> Explanation:
    """The explanation of a single ray; of `body` alone, a number or name, if it is given."""
    ray = as_rays("explain", origin, direction)
    if ray.shape:
        raise ValueError(f"explain: one ray is worked out, got rays of shape {ray.shape}; rays[i] is one of them")
    recording = Recording(scene.prepared, ray, t_min, t_max)
    origin, direction = plain(ray.origins), plain(ray.directions)
    line = Line.of(origin, direction, recording.t_min, recording.t_max)
    surfaces = Surfaces(recording, line)
    asked = None if body is None else _asked(scene, body)
    hit = scene.first_hit(ray, t_min=recording.t_min, t_max=recording.t_max)
    crossings, spans = _answers(scene, ray, recording)
    first = Crossing(float(hit.t), int(hit.body), int(hit.face), int(hit.surface), bool(hit.entering))
    steps, missed = _steps(scene, recording, surfaces, line, asked)
    done = tuple(finished(step, crossings, spans, first) for step in steps)
    decision = _decision(recording, surfaces, hit)
    return Explanation(
        origin, direction, recording.t_min, recording.t_max, hit, done, missed,
        {step.number: step for step in surfaces}, tuple(crossings), decision, scene,
    )  # fmt: skip


def _asked(scene: Scene, body: Any) -> range:
    """The numbers of the bodies that are meant."""
    if isinstance(body, str):
        entry = named(scene.bodies, body)
        firsts = scene._firsts
        return range(int(firsts[entry]), int(firsts[entry + 1]))
    scene.body(body)
    return range(int(body), int(body) + 1)


def _answers(scene: Scene, ray: Rays, recording: Recording) -> tuple[list[Crossing], dict[int, list[Span]]]:
    """All crossings and spans, as the queries tell them."""
    limits = dict(t_min=recording.t_min, t_max=recording.t_max)
    found, inside = scene.crossings(ray, **limits), scene.spans(ray, **limits)
    columns = found.t, found.body, found.face, found.surface, found.entering, found.t_error
    rows = zip(*(column.tolist() for column in columns), strict=True)
    spans: dict[int, list[Span]] = {}
    ends_of = inside.body, inside.t_enter, inside.t_exit, inside.enter_clipped, inside.exit_clipped
    for number, *ends in zip(*(column.tolist() for column in ends_of), strict=True):
        spans.setdefault(number, []).append(Span(*ends))
    return [Crossing(*row) for row in rows], spans


def _steps(
    scene: Scene, recording: Recording, surfaces: Surfaces, line: Line, asked: range | None
) -> tuple[list[BodyStep], int]:
    """(bodies met, and the first of those left out by the tree; how many more there are of these)."""
    reached, balls = recording.walk()
    tables, boxes = recording.tables, scene.prepared.lowered.boxes
    work, wanted = Bodies(recording, surfaces, line), np.ones(len(boxes), np.bool_)
    if asked is not None:
        wanted[: asked.start], wanted[asked.stop :] = False, False
    met = np.flatnonzero(wanted & (reached == kernels.IN_BALL))
    left = np.flatnonzero(wanted & (reached != kernels.IN_BALL))
    steps = []
    for entry in sorted([*met.tolist(), *left[:MOST_MISSED].tolist()]):
        known = _known(scene, entry, int(tables.entry_kind[entry]))
        if reached[entry] == kernels.IN_BALL:
            steps.append(work.step(entry, known))
            continue
        box = box_test(boxes[entry].tolist(), line)
        if reached[entry] == kernels.REACHED and not box.missed:
            left_out = missed_ball(known, box, ball_test(balls[entry].tolist(), line))
        else:
            left_out = missed_box(known, box)
        if asked is not None or len(boxes) <= FEW:
            left_out = worked_all_the_same(left_out, work.step(entry, known))
        steps.append(left_out)
    return steps, max(0, len(left) - MOST_MISSED)


def _known(scene: Scene, number: int, kind: int) -> BodyStep:
    """A body before anything is known of the ray."""
    body = scene.body(number)
    shape = repr(body.shape)
    shape = shape if len(shape) <= _LONGEST else f"{shape[:_LONGEST]} ..."
    return BodyStep(number, body.name or f"{type(body.shape).__name__} {number}", shape, KINDS[kind], "", "")


def _decision(recording: Recording, surfaces: Surfaces, hit: Any) -> Decision:
    """Which formulas decided; the first hit may be certain where something beyond it is not."""
    error, doubtful = (float(hit.t_error) if hit.hit else 0.0), bool(hit.doubtful)
    if not (doubtful or recording.is_doubtful()):
        return Decision("floats", "floats", error)
    ranks, exact = ranks_of(recording.scene, recording.arrays, 0)
    places = []
    for step in surfaces:
        number = step.number
        if ranks.verdict[2 * number] != CROSSES:
            continue
        first = int(ranks.first[number])
        for k in (first,) if step.flat else (first, first + 1):
            if math.isfinite(ranks.t[k]):
                t = (float(column[k]) * recording.scale for column in (ranks.high, ranks.low, ranks.error, ranks.t))
                places.append(Place(int(ranks.rank[k]), number, *t))
    how = "exact" if exact else "certified"
    return Decision(how if doubtful else "floats", how, error, tuple(sorted(places, key=lambda one: one.rank)))
