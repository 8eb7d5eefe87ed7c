"""Eight balls against a beam or a ray."""

from __future__ import annotations

from typing import Any

from numba import types
from numba.extending import intrinsic

from ...compiler.jit import inline
from ..ray import Ray
from ..tables import Floats
from . import slack
from .boxes import beam_code
from .code import BITS, INT64, Code


def sides_of_balls(c: Code, floats: Any, at: Any, stride: Any) -> list[Any]:
    """The boxes around eight balls."""
    b, (x, y, z, r) = c.builder, c.balls(floats, at, stride)
    r = b.fmul(r, c.constant(1.0 + slack.BALL_BOX))
    return [b.fsub(k, r) for k in (x, y, z)] + [b.fadd(k, r) for k in (x, y, z)]


@intrinsic
def _balls_in_beam(typing_context: Any, balls: Any, at: Any, stride: Any, beam: Any, start: Any, near: Any) -> Any:
    def sides(c: Code, floats: Any, arguments: Any) -> list[Any]:
        return sides_of_balls(c, floats, arguments[1], arguments[2])

    return types.int64(balls, types.int64, types.int64, beam, types.int64, near), beam_code(sides, 3, True)


@inline
def balls_in_beam(floats: Floats, at: int, stride: int, count: int, beam: Floats, start: int, near: Floats) -> int:
    """`boxes_met` for the boxes around up to eight balls, which are laid out as for `balls_met`."""
    return _balls_in_beam(floats, at, stride, beam, start, near) & ((1 << count) - 1)


def _depth(c: Code, center: list[Any], direction: list[Any], foot: Any, squared: Any) -> Any:
    """How deep the foot of the perpendicular is in balls: r² - |center - foot d|², raised (`balls_met`)."""
    b = c.builder
    off = [c.fused(b.fneg(foot), direction[k], center[k]) for k in range(3)]
    raised = c.fused(
        b.fadd(c.product(center, center), squared), c.constant(slack.BALL_SLACK), c.constant(slack.BALL_LEAST)
    )
    return b.fadd(b.fsub(squared, c.product(off, off)), raised)


def balls_missed(
    c: Code, center: list[Any], direction: list[Any], per_square: Any, radius: Any, first: Any, last: Any
) -> Any:
    """Which of eight balls their rays miss for certain; `center` is seen from the origin (`balls_met`)."""
    b, squared = c.builder, c.builder.fmul(radius, radius)
    foot = b.fmul(c.product(center, direction), per_square)
    inside = _depth(c, center, direction, foot, squared)
    half = c.root(b.fmul(inside, per_square))
    # NaN counts as met
    missed = b.fcmp_ordered("<", inside, c.constant(0.0))
    missed = b.or_(missed, b.fcmp_ordered(">", b.fsub(foot, half), last))
    return b.or_(missed, b.fcmp_ordered("<", b.fadd(foot, half), first))


@intrinsic
def _balls_met(
    typing_context: Any, floats: Any, at: Any, stride: Any,
    ox: Any, oy: Any, oz: Any, dx: Any, dy: Any, dz: Any, inverse: Any, first: Any, last: Any,
) -> Any:  # fmt: skip
    def code(context: Any, builder: Any, signature: Any, arguments: Any) -> Any:
        c, b = Code(context, builder), builder
        balls = c.data(signature, arguments, 0)
        origin, direction = arguments[3:6], [c.spread(d) for d in arguments[6:9]]
        rows = c.balls(balls, arguments[1], arguments[2])
        center = [b.fsub(rows[k], c.spread(origin[k])) for k in range(3)]
        inverse, first, last = (c.spread(number) for number in arguments[9:])
        missed = balls_missed(c, center, direction, inverse, rows[3], first, last)
        return b.zext(b.not_(b.bitcast(missed, BITS)), INT64)

    number = types.float64
    return types.int64(floats, types.int64, types.int64, *[number] * 9), code


@inline
def balls_met(floats: Floats, at: int, stride: int, count: int, ray: Ray, inverse: float, last: float) -> int:
    """Which of up to eight balls a ray may meet between its t_min and `last`, as bits; `inverse` is 1 / d·d.

    The balls' x begin at floats[at], their y, z and radii `stride` further each. A ball is left out only if
    the ray misses it for certain (`slack.BALL_SLACK`).
    """
    ox, oy, oz, dx, dy, dz, t_min, _, _ = ray
    return _balls_met(floats, at, stride, ox, oy, oz, dx, dy, dz, inverse, t_min, last) & ((1 << count) - 1)


def _lanes_in_ball(groups: int) -> Any:
    def in_ball(typing_context: Any, lanes: Any, at: Any, x: Any, y: Any, z: Any, r: Any) -> Any:
        def code(context: Any, builder: Any, signature: Any, arguments: Any) -> Any:
            c, b = Code(context, builder), builder
            rays, ball = c.data(signature, arguments, 0), [c.spread(number) for number in arguments[2:]]
            squared, met = b.fmul(ball[3], ball[3]), INT64(0)
            for group in range(groups):
                # Origin, direction; 1 / d·d and 1 / |d| or more; the interval
                rows = (0, 1, 2, 9, 10, 11, 12, 13, 6, 7, 8)
                row = [c.eight(rays, arguments[1], 64 * k + 8 * group) for k in rows]
                center, direction = [b.fsub(ball[k], row[k]) for k in range(3)], row[3:6]
                foot = b.fmul(c.product(center, direction), row[6])
                apart = b.fadd(b.fadd(c.size(center[0]), c.size(center[1])), c.size(center[2]))
                reach = b.fmul(c.fused(apart, c.constant(slack.BALL_SLACK), ball[3]), row[7])
                first, last = b.fsub(foot, reach), b.fadd(foot, reach)
                # NaN counts as met
                missed = b.fcmp_ordered("<", _depth(c, center, direction, foot, squared), c.constant(0.0))
                missed = b.or_(missed, b.fcmp_ordered(">", first, c.smaller(row[9], row[10])))
                missed = b.or_(missed, b.fcmp_ordered("<", last, row[8]))
                bits = b.zext(b.not_(b.bitcast(missed, BITS)), INT64)
                met = b.or_(met, b.shl(bits, INT64(8 * group)))
            return met

        return types.int64(lanes, types.int64, *[types.float64] * 4), code

    return intrinsic(in_ball)


_in_ball_64, _in_ball_8 = _lanes_in_ball(8), _lanes_in_ball(1)


@intrinsic
def lanes_in_ball_from_one(typing_context: Any, lanes: Any, x: Any, y: Any, z: Any, r: Any) -> Any:
    """`lanes_in_ball` for lanes that share an origin: a third of the work.

    How deep the foot of the perpendicular is in the ball, r² - |c|² + (c·d)² / d·d with the center c as the origin
    sees it, loses some 3e-15 of |c|² + r² to rounding, so the same slack holds it.
    """

    def code(context: Any, builder: Any, signature: Any, arguments: Any) -> Any:
        c, b = Code(context, builder), builder
        rays, radius = c.data(signature, arguments, 0), c.spread(arguments[4])
        center = [b.fsub(c.spread(arguments[1 + k]), c.spread(c.number(rays, INT64(0), 64 * k))) for k in range(3)]
        squared, far = b.fmul(radius, radius), c.product(center, center)
        raised = c.fused(b.fadd(far, squared), c.constant(slack.BALL_SLACK), c.constant(slack.BALL_LEAST))
        base = b.fadd(b.fsub(squared, far), raised)
        apart = b.fadd(b.fadd(c.size(center[0]), c.size(center[1])), c.size(center[2]))
        wide, met = c.fused(apart, c.constant(slack.BALL_SLACK), radius), INT64(0)
        for group in range(8):
            # Direction; 1 / d·d and 1 / |d| or more; the interval
            row = [c.eight(rays, INT64(0), 64 * k + 8 * group) for k in (9, 10, 11, 12, 13, 6, 7, 8)]
            along = c.product(center, row[:3])
            foot, reach = b.fmul(along, row[3]), b.fmul(wide, row[4])
            # NaN counts as met
            missed = b.fcmp_ordered("<", c.fused(foot, along, base), c.constant(0.0))
            missed = b.or_(missed, b.fcmp_ordered(">", b.fsub(foot, reach), c.smaller(row[6], row[7])))
            missed = b.or_(missed, b.fcmp_ordered("<", b.fadd(foot, reach), row[5]))
            bits = b.zext(b.not_(b.bitcast(missed, BITS)), INT64)
            met = b.or_(met, b.shl(bits, INT64(8 * group)))
        return met

    return types.int64(lanes, *[types.float64] * 4), code


@inline
def lanes_in_ball(lanes: Floats, x: float, y: float, z: float, r: float) -> int:
    """Which lanes of a packet may meet a ball, as bits; see `balls_met`.

    Where it is entered is bounded without a root: within a radius / |d| of the foot of the perpendicular.
    """
    return _in_ball_64(lanes, 0, x, y, z, r)


@inline
def group_in_ball(lanes: Floats, group: int, x: float, y: float, z: float, r: float) -> int:
    """`lanes_in_ball` for one group of eight."""
    return _in_ball_8(lanes, 8 * group, x, y, z, r)
