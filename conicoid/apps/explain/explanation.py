"""An explanation: the steps of one ray as data, as text, as HTML, and as a figure."""

from __future__ import annotations

import html
import math
import os
from dataclasses import dataclass
from functools import cached_property
from typing import TYPE_CHECKING, Any

import numpy as np

from ..._util.safe_files import write_text
from ..._util.validation import check_path as checked_path
from ..._util.validation import format_value
from ...geometry.entries import find_entry
from ...kernels.surface.exact_crossing import CROSSES
from ...queries.exact.doubtful_rays import ranks_of
from ...queries.ray_queries import as_rays
from ...queries.rays import Rays
from . import ray_records as kernels
from .body_steps import (
    KINDS,
    BodySteps,
    SurfaceSteps,
    ball_miss_step,
    ball_test,
    box_miss_step,
    box_test,
    finish_step,
    merge_missed_step,
)
from .document import Block
from .polynomial import ExactRay
from .ray_records import RayRecording
from .steps import BodyStep, Crossing, Decision, RankedPlace, RayRecord, Span

if TYPE_CHECKING:
    from ...queries.scene_protocol import SceneLike
    from .figure import Figure


@dataclass(frozen=True)
class Explanation(RayRecord):
    """One ray worked out: what every body does with it, and why. `scene.explain` makes it.

    origin, direction, t_min, t_max   the ray, and the open interval that was asked for
    hit          the answer of `scene.first_hit`, which all this explains
    bodies       a `BodyStep` each: those that are met, and the first of those that are not
    missed       how many bodies more are left out by the tree of boxes
    surfaces     a `SurfaceStep` for each surface that was looked at, by its number
    crossings    all crossings in order, as `scene.crossings` has them
    decision     which formulas decided it, and with what bound

    `str()` is the text, a notebook shows it as HTML, `figure()` is a drawing.
    """

    @cached_property
    def blocks(self) -> tuple[Block, ...]:
        """What is told, block by block."""
        from .narrative import blocks_of

        return tuple(blocks_of(self))

    @property
    def text(self) -> str:
        """All of it for a terminal."""
        from .document import text_of

        return text_of(self.blocks)

    def __str__(self) -> str:
        return self.text

    def __repr__(self) -> str:
        found = "a miss" if not self.hit.hit else f"t={float(self.hit.t)!r}"
        return f"Explanation(origin={self.origin}, direction={self.direction}, {found}; print it for all steps)"

    def figure(self, body: Any = None, width: int = 640) -> Figure:
        """A drawing of the ray in a plane: the exact sections of the bodies, and the crossings with their t.

        body: the number or name of the one through whose axis the plane goes; by default the one that is hit first.
        width: in pixels.
        """
        from .figure import figure_of

        return figure_of(self, body, width)

    @cached_property
    def svg(self) -> str:
        """`figure()` as the text of an SVG picture."""
        return self.figure().svg

    @property
    def html(self) -> str:
        """All of it as HTML in itself, with the figure: a part of a page, which asks nothing of the network."""
        from .document import html_of

        return html_of(self.blocks, self.svg)

    def save(self, path: Any) -> None:
        """Write it to a file at `path`: as a page (.html), the drawing alone (.svg) or the text (.txt).

        Raises ValueError for other endings, OSError where it cannot be written.
        """
        save_explanation(self, path)

    def _repr_html_(self) -> str:
        return self.html


def page_of(title: str, body: str) -> str:
    """A whole page around a part of one."""
    style = "body { margin: 2rem auto; max-width: 60rem; padding: 0 1rem; }"
    return (
        f'<!doctype html>\n<html lang="en"><head><meta charset="utf-8"><title>{html.escape(title)}</title>'
        f"<style>{style}</style></head><body>\n{body}\n</body></html>\n"
    )


def as_floats_tuple(values: Any) -> tuple[float, ...]:
    """An array of floats as a tuple."""
    return tuple(np.asarray(values, np.float64).tolist())


# An explanation as a file.


def save_explanation(found: Explanation, path: Any) -> None:
    """A page, a drawing or a text, by the ending."""
    name = checked_path("save", path)
    suffix = os.path.splitext(name)[1].lower()
    if suffix == ".html":
        content = page_of("A ray explained", found.html)
    elif suffix == ".svg":
        content = found.svg
    elif suffix == ".txt":
        content = found.text
    else:
        raise ValueError(
            f"save: path of an explanation must end with .html, .svg or .txt, got {format_value(str(path))}"
        )
    write_text(name, content)


# `scene.explain`: one ray asked as usual, and all that the kernels did for it gathered into steps.

MOST_MISSED = 16
"""Bodies left out by the tree that are told of one by one."""
FEW_BODIES = 8
"""In a scene of no more bodies, also those that are left out are worked out."""
_LONGEST_REPR = 160


def explain(scene: SceneLike, origin: Any, direction: Any, t_min: Any, t_max: Any, body: Any) -> Explanation:
    """The explanation of a single ray; of `body` alone, a number or name, if it is given."""
    ray = as_rays("explain", origin, direction)
    if ray.shape:
        raise ValueError(f"explain: one ray is worked out, got rays of shape {ray.shape}; rays[i] is one of them")
    recording = RayRecording(scene.prepared, ray, t_min, t_max)
    origin, direction = as_floats_tuple(ray.origins), as_floats_tuple(ray.directions)
    line = ExactRay.of(origin, direction, recording.t_min, recording.t_max)
    surfaces = SurfaceSteps(recording, line)
    asked = None if body is None else _body_range(scene, body)
    hit = scene.first_hit(ray, t_min=recording.t_min, t_max=recording.t_max)
    crossings, spans = _trace_all(scene, ray, recording)
    first = Crossing(float(hit.t), int(hit.body), int(hit.face), int(hit.surface), bool(hit.entering))
    steps, missed = _steps(scene, recording, surfaces, line, asked)
    done = tuple(finish_step(step, crossings, spans, first) for step in steps)
    decision = _decision(recording, surfaces, hit)
    return Explanation(
        origin, direction, recording.t_min, recording.t_max, hit, done, missed,
        {step.number: step for step in surfaces}, tuple(crossings), decision, scene,
    )  # fmt: skip


def _body_range(scene: SceneLike, body: Any) -> range:
    """The numbers of the bodies that are meant."""
    if isinstance(body, str):
        entry = find_entry(scene.bodies, body)
        firsts = scene._firsts
        return range(int(firsts[entry]), int(firsts[entry + 1]))
    scene.body(body)
    return range(int(body), int(body) + 1)


def _trace_all(scene: SceneLike, ray: Rays, recording: RayRecording) -> tuple[list[Crossing], dict[int, list[Span]]]:
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
    scene: SceneLike, recording: RayRecording, surfaces: SurfaceSteps, line: ExactRay, asked: range | None
) -> tuple[list[BodyStep], int]:
    """(bodies met, and the first of those left out by the tree; how many more there are of these)."""
    reached, balls = recording.walk()
    tables, boxes = recording.tables, scene.prepared.lowered.boxes
    work, wanted = BodySteps(recording, surfaces, line), np.ones(len(boxes), np.bool_)
    if asked is not None:
        wanted[: asked.start], wanted[asked.stop :] = False, False
    met = np.flatnonzero(wanted & (reached == kernels.IN_BALL))
    left = np.flatnonzero(wanted & (reached != kernels.IN_BALL))
    steps = []
    for entry in sorted([*met.tolist(), *left[:MOST_MISSED].tolist()]):
        known = _initial_step(scene, entry, int(tables.entry_kind[entry]))
        if reached[entry] == kernels.IN_BALL:
            steps.append(work.step(entry, known))
            continue
        box = box_test(boxes[entry].tolist(), line)
        if reached[entry] == kernels.REACHED and not box.missed:
            left_out = ball_miss_step(known, box, ball_test(balls[entry].tolist(), line))
        else:
            left_out = box_miss_step(known, box)
        if asked is not None or len(boxes) <= FEW_BODIES:
            left_out = merge_missed_step(left_out, work.step(entry, known))
        steps.append(left_out)
    return steps, max(0, len(left) - MOST_MISSED)


def _initial_step(scene: SceneLike, number: int, kind: int) -> BodyStep:
    """A body before anything is known of the ray."""
    body = scene.body(number)
    shape = repr(body.shape)
    shape = shape if len(shape) <= _LONGEST_REPR else f"{shape[:_LONGEST_REPR]} ..."
    return BodyStep(number, body.name or f"{type(body.shape).__name__} {number}", shape, KINDS[kind], "", "")


def _decision(recording: RayRecording, surfaces: SurfaceSteps, hit: Any) -> Decision:
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
                places.append(RankedPlace(int(ranks.rank[k]), number, *t))
    how = "exact" if exact else "certified"
    return Decision(how if doubtful else "floats", how, error, tuple(sorted(places, key=lambda one: one.rank)))
