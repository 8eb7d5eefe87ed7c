"""Eight balls against a beam or a ray."""

from __future__ import annotations

from typing import Any

from numba import types
from numba.extending import intrinsic

from ...geometry.tables import Floats, Ray
from ...jit import inline
from .boxes import beam_code
from .code import BITS, INT64, Code

_DOUBT, _LEAST = 1e-13, 1e-290


@intrinsic  # type: ignore[untyped-decorator]
def _balls_in_beam(
    typing_context: Any, balls: Any, at: Any, stride: Any, beam: Any, start: Any, near: Any
) -> Any:  # fmt: skip
    def sides(c: Code, floats: Any, arguments: Any) -> list[Any]:
        b, (x, y, z, r) = c.builder, c.balls(floats, arguments[1], arguments[2])
        r = b.fmul(r, c.constant(1.0 + 1e-14))
        return [b.fsub(k, r) for k in (x, y, z)] + [b.fadd(k, r) for k in (x, y, z)]

    return types.int64(balls, types.int64, types.int64, beam, types.int64, near), beam_code(sides, 3)


@inline
def balls_in_beam(floats: Floats, at: int, stride: int, count: int, beam: Floats, start: int, near: Floats) -> int:
    """`boxes_met` for the boxes around up to eight balls, which are laid out as for `balls_met`."""
    return _balls_in_beam(floats, at, stride, beam, start, near) & ((1 << count) - 1)


@intrinsic  # type: ignore[untyped-decorator]
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
        per_square, squared = c.spread(arguments[9]), b.fmul(rows[3], rows[3])
        foot = b.fmul(c.product(center, direction), per_square)
        off = [c.fused(b.fneg(foot), direction[k], center[k]) for k in range(3)]
        slack = c.fused(b.fadd(c.product(center, center), squared), c.constant(_DOUBT), c.constant(_LEAST))
        inside = b.fadd(b.fsub(squared, c.product(off, off)), slack)
        half = c.root(b.fmul(inside, per_square))
        # What is not a number counts as met
        missed = b.fcmp_ordered("<", inside, c.constant(0.0))
        missed = b.or_(missed, b.fcmp_ordered(">", b.fsub(foot, half), c.spread(arguments[11])))
        missed = b.or_(missed, b.fcmp_ordered("<", b.fadd(foot, half), c.spread(arguments[10])))
        return b.zext(b.not_(b.bitcast(missed, BITS)), INT64)

    number = types.float64
    return types.int64(floats, types.int64, types.int64, *[number] * 9), code


@inline
def balls_met(floats: Floats, at: int, stride: int, count: int, ray: Ray, inverse: float, last: float) -> int:
    """Which of up to eight balls a ray may meet between its t_min and `last`, as bits; `inverse` is 1 / d·d.

    The balls' x begin at floats[at], their y, z and radii `stride` further each. A ball is left out only if
    the ray misses it for certain: the square of the half chord is raised by more than all
    roundings can take away from it, 1e-13 of the squares of distance and radius, which moves both ends
    by more than what rounding does to them too.
    """
    ox, oy, oz, dx, dy, dz, t_min, _, _ = ray
    return _balls_met(floats, at, stride, ox, oy, oz, dx, dy, dz, inverse, t_min, last) & ((1 << count) - 1)
