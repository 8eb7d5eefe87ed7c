"""How a body ends: its outcome, and that in words."""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from dataclasses import replace

from .numbers import told
from .steps import (
    BALL,
    BEHIND,
    BOOLEAN,
    BOX,
    CLIPPED,
    CROSSED,
    HIT,
    INSIDE,
    INTERVAL,
    NO_ROOT,
    OUTLINE,
    PARALLEL,
    PLANES,
    STARTED,
    TOUCHED,
    BodyStep,
    Crossing,
    Span,
)

_WORDS = {
    NO_ROOT: "the discriminant is negative: there is no real root",
    TOUCHED: "the ray only touches it, which counts as not met",
    PLANES: "what its faces leave of the ray has nothing in common",
    INTERVAL: "its crossings lie outside the interval of t",
    BOOLEAN: "whatever parts are crossed, the Boolean's value does not change within the interval",
    OUTLINE: "its plane is met outside its outline",
    CLIPPED: "its surface is met where it has been cut away",
    PARALLEL: "the ray is parallel to its plane",
    BEHIND: "it is one-sided and seen from behind",
    INSIDE: "the ray is inside all along, and crosses nothing",
    STARTED: "the ray starts on it, and that crossing is left out; there is no other",
}


def finished(
    step: BodyStep, crossings: Sequence[Crossing], spans: Mapping[int, Sequence[Span]], first: Crossing
) -> BodyStep:
    """A step with the answers of the queries, and its outcome in words."""
    own = tuple(one for one in crossings if one.body == step.body)
    inside = tuple(spans.get(step.body, ()))
    if step.outcome in (BOX, BALL):
        return replace(step, crossings=own, spans=inside)
    outcome = step.outcome
    if own:
        outcome = HIT if first.body == step.body else CROSSED
    elif step.floats:
        outcome = INSIDE if inside else TOUCHED
    told_of = _met(own, outcome) if own else _WORDS[outcome]
    doubtful = step.doubtful or own != step.floats
    return replace(step, outcome=outcome, told=told_of, crossings=own, spans=inside, doubtful=doubtful)


def worked_all_the_same(left_out: BodyStep, worked: BodyStep) -> BodyStep:
    """A body that the tree leaves out, with what would have come of it."""
    why = _WORDS.get(worked.outcome)
    told_of = f"{left_out.told}; worked out all the same: {why}" if why else left_out.told
    return replace(worked, outcome=left_out.outcome, told=told_of, box=left_out.box, ball=left_out.ball)


def _met(crossings: Sequence[Crossing], outcome: str) -> str:
    """Where a body is entered and left."""
    told_of = [f"{'entered' if one.entering else 'left'} at t = {told(one.t)} (face {one.face})" for one in crossings]
    return ("first hit: " if outcome == HIT else "") + ", ".join(told_of)
