"""Paraboloids and hyperboloids as importers make them, a quadric cut by a box: guesses at their numbers."""

from __future__ import annotations

import math
from collections.abc import Iterator
from fractions import Fraction

from ....shapes.base import Solid
from ....shapes.box import Box
from ....shapes.quadric import Quadric
from ....shapes.region import Difference, Intersection
from ....shapes.revolution import Revolution
from ....shapes.steps import Translate
from ..numbers import decimal, word
from ..pieces import Native

_GUESSED = (6, 9, 12)
_Wall = tuple[float, float, float]
"""g0, g1, g2 of x² + y² <= g0 + g1 z + g2 z²"""


def known_bowls(solid: Intersection | Difference) -> Iterator[Native]:
    """What a solid may be, as elements of GDML."""
    outer: Solid = solid
    inner: Solid | None = None
    if isinstance(solid, Difference) and len(solid.operands) == 2:
        outer, inner = solid.operands
    if not isinstance(outer, Intersection) or len(outer.operands) != 2 or outer.motion.steps:
        return
    boxes = [part for part in outer.operands if isinstance(part, Box) and not part.motion.steps]
    walls = [part for part in outer.operands if not isinstance(part, Box)]
    if len(boxes) != 1 or len(walls) != 1:
        return
    low, high = decimal(boxes[0].low[2]), decimal(boxes[0].high[2])
    place, wall = _shift(walls[0]), _wall(walls[0])
    bore = (0.0, 0.0, 0.0) if inner is None else _wall(inner)
    if place is None or wall is None or bore is None:
        return
    at = (decimal(place[0]), decimal(place[1]), (low + high) / 2)
    for digits in _GUESSED:
        if wall[2] or bore[2]:
            yield _hype(wall, bore, low, high, at, digits)
        elif inner is None:
            radii = [_rounded(_radius(wall, float(z)), digits) for z in (low, high)]
            text = f' rlo="{word(radii[0])}" rhi="{word(radii[1])}" dz="{word((high - low) / 2)}" lunit="mm"'
            yield Native("paraboloid", text, "", at)


def _hype(wall: _Wall, bore: _Wall, low: Fraction, high: Fraction, at: tuple[Fraction, Fraction, Fraction],
          digits: int) -> Native:  # fmt: skip
    told = ""
    for each, radius, angle in ((bore, "rmin", "inst"), (wall, "rmax", "outst")):
        degrees = math.degrees(math.atan(math.sqrt(max(each[2], 0.0))))
        size = _rounded(_radius(each, float(at[2])), digits)
        told += f' {radius}="{word(size)}" {angle}="{word(_rounded(degrees, digits))}"'
    return Native("hype", f'{told} z="{word(high - low)}" aunit="deg" lunit="mm"', "", at)


def _shift(solid: Solid) -> tuple[float, float, float] | None:
    """Where a wall has its axis."""
    steps = solid.motion.steps
    if not steps:
        return 0.0, 0.0, 0.0
    return steps[0].offset if len(steps) == 1 and isinstance(steps[0], Translate) else None


def _wall(solid: Solid) -> _Wall | None:
    """Of a quadric about z, or of a cylinder."""
    if isinstance(solid, Quadric) and solid.coefficients is not None:
        given = dict(solid.coefficients)
        if given.pop("xx", 0.0) != 1 or given.pop("yy", 0.0) != 1:
            return None
        return -given.get("constant", 0.0), -given.get("z", 0.0), -given.get("zz", 0.0)
    if isinstance(solid, Revolution) and len(solid.profile) == 4:
        return max(r for r, _ in solid.profile) ** 2, 0.0, 0.0
    return None


def _radius(wall: _Wall, z: float) -> float:
    g0, g1, g2 = wall
    return math.sqrt(max(g0 + z * (g1 + z * g2), 0.0))


def _rounded(value: float, digits: int) -> Fraction:
    return Fraction(f"{round(value, digits):.{digits}f}")
