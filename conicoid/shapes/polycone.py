"""The polycone: cones and tubes about one axis, stacked on each other."""

from __future__ import annotations

import itertools
from collections.abc import Iterator
from dataclasses import dataclass, replace
from typing import Any

from . import exact as ex
from .base import PrimitiveSolid
from .cells import All, Any_, Cell, Face, Tree, around_z, flat
from .cylinder import arc_support, either, wedge_walls
from .degrees import turn
from .frustum import frustum_side
from .rounded import larger
from .support import sum_up
from .surface import PlaneSurface
from .validate import numbers, shown
from .vector import Vector

Section = tuple[float, float, float]
_MOST = 10_000


@dataclass(frozen=True)
class Polycone(PrimitiveSolid):
    """Between sections (z, inner radius, outer radius), one above the other, all that lies between straight lines.

    `sections`: two or more, z rising; a height may come twice, for a step. 0 <= inner <= outer, and some volume. Angles
    of (x, y), in degrees, from `start_angle` to `end_angle`, their difference in (0, 360]. Two sections make a hollow
    frustum, or a tube. Inner and outer radii may be equal: rings that touch or lie apart are parts of one solid. A
    profile that goes back on itself in z is for `Revolution`.

    Faces, of n sections: k the outer side from section k to the next, n - 1 + k the inner one, 2 (n - 1) + k what is
    level at section k, then the walls at start_angle and end_angle (half a turn has one plane for both). uv:
    (angle / 360, height from section to section in [0, 1]) on the sides, (x, y) / the largest radius on what is level,
    (distance from the axis, z), in units of the largest of each, on the walls.
    Source: the polycone of detector simulation (Geant4, "Book for Application Developers", solids).
    """

    sections: tuple[tuple[float, float, float], ...]
    start_angle: float = 0.0
    end_angle: float = 360.0

    def __post_init__(self) -> None:
        object.__setattr__(self, "sections", _checked(self.sections))
        first, last = turn("Polycone", self.start_angle, self.end_angle)
        object.__setattr__(self, "start_angle", first)
        object.__setattr__(self, "end_angle", last)

    @property
    def stretches(self) -> Iterator[tuple[int, Section, Section]]:
        """(number of the lower section, lower section, upper section) of every part that has a volume."""
        for k, (low, high) in enumerate(itertools.pairwise(self.sections)):
            if _has_volume(low, high):
                yield k, low, high

    @property
    def widest(self) -> float:
        """The largest radius."""
        widest = 0.0
        for _, _, outer in self.sections:
            widest = larger(widest, outer)
        return widest

    def tree(self) -> Tree:
        rings = tuple(self._ring(*stretch) for stretch in self.stretches)
        whole: Tree = rings[0] if len(rings) == 1 else Any_(rings)
        walls = self._walls()
        if not walls:
            return whole
        is_convex = self.end_angle - self.start_angle <= 180
        return All((whole, Cell(walls) if is_convex else either(walls)))

    def _ring(self, k: int, low: Section, high: Section) -> Tree:
        """Between two sections: a cell, or two where there is a bore."""
        sides, count = around_z(low[0], high[0]), len(self.sections)
        r0, r1, z0, z1 = (ex.rational(value) for value in (low[2], high[2], low[0], high[0]))
        bottom = self._level(low[0], -1.0, 2 * (count - 1) + k)
        top = self._level(high[0], 1.0, 2 * (count - 1) + k + 1)
        body = Cell((Face(frustum_side(r0, z0, r1, z1), k, sides), bottom, top))
        if not (low[1] > 0 or high[1] > 0):
            return body
        bore = frustum_side(ex.rational(low[1]), z0, ex.rational(high[1]), z1)
        # Between the same heights: else a bore that another has in one line with it would show this one's number
        return All((body, Cell((Face(bore, count - 1 + k, sides, inside=-1), bottom, top))))

    def _level(self, z: float, sense: float, number: int) -> Face:
        uv = flat((self.widest, 0, 0), (0, self.widest, 0))
        return Face(PlaneSurface((0.0, 0.0, sense), sense * z, (0.0, 0.0, z)), number, uv)

    def _walls(self) -> tuple[Face, ...]:
        tallest = larger(abs(self.sections[0][0]), abs(self.sections[-1][0]))
        made = wedge_walls(self.start_angle, self.end_angle, self.widest, tallest)
        return tuple(replace(wall, number=3 * len(self.sections) - 5 + wall.number) for wall in made)

    def support(self, direction: Vector) -> float:
        best = -float("inf")
        for _, low, high in self.stretches:
            for z, inner, outer in (low, high):
                reaches = (arc_support(r, self.start_angle, self.end_angle, direction) for r in (outer, inner))
                best = larger(best, sum_up((z * direction[2], larger(*reaches))))
        return best


def _has_volume(low: Section, high: Section) -> bool:
    return bool(low[0] < high[0] and (low[1] < low[2] or high[1] < high[2]))


def _checked(sections: Any) -> tuple[Section, ...]:
    try:
        rows = list(sections)
    except TypeError:
        told = "must be two or more of (z, inner radius, outer radius)"
        raise ValueError(f"Polycone: sections {told}, got {shown(sections)}") from None
    if not 2 <= len(rows) <= _MOST:
        raise ValueError(f"Polycone: sections must be from 2 to {_MOST:,}, got {len(rows):,}")
    found: list[Section] = []
    for k, row in enumerate(rows):
        z, inner, outer = numbers("Polycone", f"sections[{k}]", row, 3)
        if not 0 <= inner <= outer:
            told = f"0 <= inner radius <= outer radius, got {inner:g} and {outer:g}"
            raise ValueError(f"Polycone: sections[{k}] must have {told}")
        if found and z < found[-1][0]:
            told = f"must rise in z, got {z:g} above {found[-1][0]:g}; a list that falls is turned round"
            raise ValueError(f"Polycone: sections[{k}] {told}")
        found.append((z, inner, outer))
    if any(_has_volume(low, high) for low, high in itertools.pairwise(found)):
        return tuple(found)
    raise ValueError("Polycone: sections must enclose a volume: between two heights, inner radius < outer radius")
