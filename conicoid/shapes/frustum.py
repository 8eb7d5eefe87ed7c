"""The curved side of a frustum about the z axis: a cylinder or a cone through two circles."""

from __future__ import annotations

from typing import Any

from . import exact as ex
from .rounded import is_negative
from .surface import QuadricSurface


def frustum_side(r0: Any, z0: Any, r1: Any, z1: Any) -> QuadricSurface:
    """x² + y² = r² with r = r0 at z0 and r1 at z1, inside towards the axis; fractions or 3000-bit numbers.

    A cone is kept about the end with the smaller radius r, as x² + y² - m² z² - 2 m r z - r² = 0: there all terms of
    the radius have one sign, so that neither the nearly cylindrical nor the nearly pointed one loses digits. Which end
    that is decides a factor of 0 or 1, and is no test: one recording serves both.
    """
    growth = r1 - r0
    if not growth:
        return QuadricSurface((1.0, 1.0, 0.0), constant=r0 * r0)
    slope = growth / (z1 - z0)
    shrinks = ex.rational(is_negative(growth))
    r, z = ((1 - shrinks) * first + shrinks * second for first, second in ((r0, r1), (z0, z1)))
    return QuadricSurface((1.0, 1.0, -slope * slope), (0.0, 0.0, -slope * r), r * r, anchor=(0.0, 0.0, z))
