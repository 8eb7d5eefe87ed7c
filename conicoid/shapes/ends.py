"""Bounds of a moved shape from its support, rounded outward."""

from __future__ import annotations

from collections.abc import Callable

from . import exact as ex
from .motion import Motion
from .planar import rounded_up
from .rounded import above, above_if, count_of, is_finite, sign_of_first
from .vector import Vector

_SAFE = 1e-150
"""Products with a number of the domain do not underflow."""


def support_ends(support: Callable[[Vector], float], motion: Motion) -> list[float]:
    """(low x, y, z, high x, y, z) of a shape with this support in its own frame, where a motion puts that frame.

    Support of the moved shape along each axis: h(Lᵀ e) + t·e, rounded outward.
    Where row e of L has one entry k alone, h(Lᵀ e) = |k| h(±e'), so only h itself and the end are rounded: what is
    0 on paper is 0. So it is in other rows where h is 0 in floats, as `support` raises every sum of several terms.
    """
    simple = motion.is_identity or motion.shift is not None
    low: list[float] = []
    high: list[float] = []
    for i, (*row, shift) in enumerate(motion.rows):
        single = not (simple or count_of(row) >= 2)
        towards = [count_of((entry,)) * sign_of_first((entry,)) for entry in row] if single else row
        for sign, ends in ((1.0, high), (-1.0, low)):
            x, y, z = towards if sign > 0 else (0.0 - entry for entry in towards)
            reach = support((x, y, z))
            if single:
                ends.append(_stretched(reach, motion, i, sign))
            elif not shift and reach == 0 and _is_nothing(motion, i):
                ends.append(0.0)
            else:
                ends.append(_outward(reach, shift if sign > 0 else -shift, simple))
    return [*(0.0 - end for end in low), *high]


def _is_nothing(motion: Motion, row: int) -> bool:
    """Whether a row shifts by nothing on paper, and no product with it that is not 0 is 0 in floats."""
    if motion.shift is not None:
        return True
    rows, shift = motion.affine
    return not shift[row] and all(abs(entry) > _SAFE for entry in rows[row] if entry)


def _stretched(reach: float, motion: Motion, row: int, sign: float) -> float:
    """The least float64 not below |k| reach + sign·shift, k being the one entry of the motion's row that is not 0."""
    if not is_finite(reach):
        return reach
    rows, shift = motion.affine
    size = ex.total(map(abs, rows[row]))
    return rounded_up(ex.cancelling_sum((size * ex.exact(reach), sign * shift[row])))


def _outward(reach: float, shift: float, exact: bool) -> float:
    """An upper bound of reach + shift; the nearest one if there is only a translation, whose floats are exact."""
    total = reach + shift
    if not is_finite(total):
        return total
    if not exact:
        return above(total + 4 * 2.0**-53 * (abs(reach) + abs(shift)))
    # Knuth's TwoSum: what the sum has lost
    part = total - reach
    lost = (reach - (total - part)) + (shift - part)
    return above_if(total, lost)
