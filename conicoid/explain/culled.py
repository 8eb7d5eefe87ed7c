"""What the tree leaves out: boxes and balls that the ray misses, worked out as the ray tracing notes do."""

from __future__ import annotations

import math
from collections.abc import Sequence
from fractions import Fraction

from .line import Line
from .numbers import as_float, told
from .slabs import worked_out
from .steps import BALL, BOX, BallTest, BodyStep, BoxTest


def box_test(box: Sequence[float], line: Line) -> BoxTest:
    """t_near and t_far of a box (low, high): six floats. Axes along which it has no end are left out."""
    ends = [(box[axis], box[axis + 3]) for axis in range(3)]
    slabs = [
        ("xyz"[k], Fraction(low), Fraction(high), line.origin[k], line.direction[k])
        for k, (low, high) in enumerate(ends)
        if math.isfinite(low) and math.isfinite(high)
    ]
    near, far = line.t_min, line.t_max
    for _, low, high, at, slope in slabs:
        first, last = (-math.inf, math.inf) if low <= at <= high else (math.inf, -math.inf)
        if slope:
            first, last = sorted((as_float((low - at) / slope), as_float((high - at) / slope)))
        near, far = max(near, first), min(far, last)
    x, y, z, u, v, w = box
    return BoxTest((x, y, z), (u, v, w), near, far, worked_out(slabs, line))


def ball_test(ball: Sequence[float], line: Line) -> BallTest:
    """How far from the center of a ball the line passes."""
    x, y, z, radius = ball
    out = [o - c for o, c in zip(map(float, line.origin), (x, y, z), strict=True)]
    d = list(map(float, line.direction))
    length = math.hypot(*d)
    cross = (out[1] * d[2] - out[2] * d[1], out[2] * d[0] - out[0] * d[2], out[0] * d[1] - out[1] * d[0])
    return BallTest((x, y, z), radius, math.hypot(*cross) / length)


def missed_box(known: BodyStep, box: BoxTest) -> BodyStep:
    """A body whose box is missed."""
    if box.low > box.high:
        why = "it is empty: there is nothing of it anywhere"
    elif box.near == math.inf or box.far == -math.inf:
        why = "its box is missed: the ray runs beside it, parallel to two of its sides"
    elif box.near > box.far:
        why = f"its box is missed within the interval: t_near = {told(box.near)} > t_far = {told(box.far)}"
    else:
        why = "its box is missed"
    return _with(known, BOX, why, box, None)


def missed_ball(known: BodyStep, box: BoxTest, ball: BallTest) -> BodyStep:
    """A body whose ball is missed."""
    if ball.distance > ball.radius:
        why = f"the ball around it is missed: {told(ball.distance)} from its center, radius {told(ball.radius)}"
    else:
        why = "the ball around it lies outside the interval"
    return _with(known, BALL, why, box, ball)


def _with(known: BodyStep, outcome: str, why: str, box: BoxTest, ball: BallTest | None) -> BodyStep:
    return BodyStep(known.body, known.name, known.shape, known.kind, outcome, why, box=box, ball=ball)
