"""Paraboloids and hyperboloids of revolution, by the radii and angles that GDML has them by."""

from __future__ import annotations

import math
from fractions import Fraction
from typing import TYPE_CHECKING

from ....shapes import exact as ex
from ....shapes.rounded import sin_cos_degrees
from ...openmc.placement import Turn
from ..exported import Unsayable
from ..numbers import word
from ..pieces import Bowl
from .moves import Set, joined

if TYPE_CHECKING:
    from .solids import Said, Solids

_NEAR = 12
"""Floats on either side of an angle that are tried for the very slope."""
_STEEPEST = 89.999
_DOWN = Turn(signs=(1, -1, -1))


def said(solids: Solids, piece: Bowl) -> Said:
    """A paraboloid or a hype."""
    return _hype(solids, piece) if piece.g2 else _paraboloid(solids, piece)


def _paraboloid(solids: Solids, piece: Bowl) -> Said:
    from .solids import Said

    is_up = piece.g1 > 0
    slope = abs(piece.g1)
    low, high = (Fraction(piece.low), Fraction(piece.high)) if is_up else (-Fraction(piece.high), -Fraction(piece.low))
    low = max(low, -piece.g0 / slope)
    radii = [_root(piece.g0 + slope * z) for z in (low, high)]
    text = f' rlo="{word(radii[0])}" rhi="{word(radii[1])}" dz="{word((high - low) / 2)}" lunit="mm"'
    middle = Set(shift=(Fraction(0), Fraction(0), (low + high) / 2))
    return Said(solids.add("paraboloid", text), joined([middle], [] if is_up else [Set(_DOWN)]))


def _hype(solids: Solids, piece: Bowl) -> Said:
    from .solids import Said

    middle = -piece.g1 / (2 * piece.g2)
    radius = _root(piece.g0 - piece.g2 * middle * middle)
    half = max(abs(Fraction(z) - middle) for z in (piece.low, piece.high))
    angle, is_exact = _angle(piece.g2)
    text = f' rmin="0" rmax="{word(radius)}" inst="0" outst="{word(angle)}" z="{word(2 * half)}"'
    shift = joined([Set(shift=(Fraction(0), Fraction(0), middle))])
    return Said(solids.add("hype", f'{text} aunit="deg" lunit="mm"'), shift, not is_exact)


def _angle(bend: Fraction) -> tuple[float, bool]:
    """The angle in degrees whose tangent squared is read as a float, and whether there is one."""
    about = math.degrees(math.atan(math.sqrt(bend)))
    if about > _STEEPEST:
        raise Unsayable("a hyperboloid of it is nearly flat, and GDML has it by an angle near 90 degrees")
    tried = about
    for _ in range(_NEAR):
        tried = math.nextafter(tried, 0.0)
    for _ in range(2 * _NEAR + 1):
        s, c = sin_cos_degrees(tried)
        if float((Fraction(s) / Fraction(c)) ** 2) == float(bend):
            return tried, True
        tried = math.nextafter(tried, math.inf)
    return about, False


def _root(value: Fraction) -> Fraction:
    """The square root, to more digits than are written."""
    return ex.fraction(ex.cancelling_sum((ex.sqrt(max(value, Fraction(0))),)))
