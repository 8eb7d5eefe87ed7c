"""Closed forms of solids of revolution: planes across an axis, and quadrics of revolution about it.

Shells, caps, capped cylinders and cones, coated particles, tanks. At each height z every quadric is a circle
r² = g(z), g a polynomial of second degree; between the heights where circles meet, vanish, or planes lie, the same
circles bound the solid, and all integrals are those of polynomials, which Gauss's rule takes exactly.
"""

from __future__ import annotations

import itertools
import math
from dataclasses import dataclass

import numpy as np

from ..shapes.support import real_roots
from ..shapes.vector import FloatArray
from .prisms import Unknown, middle
from .surfaces import ALIKE, Plane, Quadric, Region

_NODES, _WEIGHTS = (np.array(a) for a in np.polynomial.legendre.leggauss(5))
_NEAR = 1e-9


@dataclass(frozen=True)
class Profile:
    """r² <= g(z) = g0 + g1 z + g2 z²; `outer` where f <= 0 is the outside."""

    g: tuple[float, float, float]
    outer: bool

    def at(self, z: FloatArray) -> FloatArray:
        g0, g1, g2 = self.g
        result: FloatArray = g0 + z * (g1 + z * g2)
        return result

    @property
    def square(self) -> bool:
        """Whether 4 g + g'² is the square of a linear function: cylinders, spheres, cones."""
        g0, g1, g2 = self.g
        a, b, c = 4 * g2 + 4 * g2 * g2, 4 * g1 + 4 * g1 * g2, 4 * g0 + g1 * g1
        return abs(b * b - 4 * a * c) <= 1e-10 * max(b * b, abs(4 * a * c), c * c * 1e-4) and (a, b, c) != (0, 0, 0)

    def speed(self, z: FloatArray) -> FloatArray:
        """The area of the surface for a unit of z, over π: √(4 g + g'²)."""
        _, g1, g2 = self.g
        result: FloatArray = np.sqrt(np.maximum(4 * self.at(z) + (g1 + 2 * g2 * z) ** 2, 0.0))
        return result


def revolved_sums(region: Region, axes: FloatArray, origin: FloatArray) -> tuple[FloatArray, float | None]:
    """Integrals of 1, x, y, z, xx, xy, xz, yy, yz, zz from `origin` along `axes`, the last being that of revolution.

    And the area, None where it has no closed form. Raises Unknown for what is no bounded solid of revolution.
    """
    caps: dict[int, tuple[float, bool]] = {}
    profiles: dict[int, Profile] = {}
    for number, surface in region.surfaces.items():
        if isinstance(surface, Plane):
            x, y, z = surface.normal @ axes
            if math.hypot(x, y) > ALIKE:
                raise Unknown
            caps[number] = (surface.offset - float(surface.normal @ origin)) / z, z < 0
        else:
            profiles[number] = _profile(surface.within(axes, origin))
    return _stacked(region, caps, profiles)


def _profile(own: Quadric) -> Profile:
    size = own.a[0, 0]
    if size == 0:
        raise Unknown
    a, b, c = own.a / size, own.b / size, own.c / size
    scale = math.sqrt(abs(c)) + abs(float(b[2]))
    off = np.abs(a - np.diag([1, 1, a[2, 2]])).max()
    if off > ALIKE * max(1.0, abs(a[2, 2])) or np.abs(b[:2]).max() > ALIKE * scale:
        raise Unknown
    return Profile((-float(c), -2 * float(b[2]), -float(a[2, 2])), bool(size < 0))


def _stacked(
    region: Region, caps: dict[int, tuple[float, bool]], profiles: dict[int, Profile]
) -> tuple[FloatArray, float | None]:
    heights = {height for height, _ in caps.values()}
    for profile in profiles.values():
        heights |= set(real_roots(profile.g[2], profile.g[1], profile.g[0]))
    for first, second in itertools.combinations(profiles.values(), 2):
        d0, d1, d2 = (a - b for a, b in zip(first.g, second.g, strict=True))
        if d0 or d1 or d2:
            heights |= set(real_roots(d2, d1, d0))
    cuts = sorted(height for height in heights if math.isfinite(height))
    ends = [-math.inf, *cuts, math.inf]
    total, area, has_area = np.zeros(10), 0.0, True
    rings: list[tuple[float, list[tuple[int, int]]]] = []
    for low, high in itertools.pairwise(ends):
        if low == high:
            continue
        found = _circles(region, caps, profiles, middle(low, high))
        rings.append((low, found))
        if not found:
            continue
        if math.isinf(low) or math.isinf(high):
            raise Unknown
        half = (high - low) / 2
        z, weight = low + half + half * _NODES, half * _WEIGHTS
        for number, sense in found:
            g = np.maximum(profiles[number].at(z), 0.0)
            one, across = math.pi * sense * g * weight, math.pi / 4 * sense * g**2 * weight
            total += np.array([one.sum(), 0, 0, one @ z, across.sum(), 0, 0, across.sum(), 0, one @ z**2])
            has_area = has_area and profiles[number].square
            area += math.pi * float(profiles[number].speed(z) @ weight)
    for (_, below), (height, above) in itertools.pairwise(rings):
        area += _ring_area(profiles, height, below, above)
    return total, area if has_area else None


def _circles(
    region: Region, caps: dict[int, tuple[float, bool]], profiles: dict[int, Profile], z: float
) -> list[tuple[int, int]]:
    """The circles that bound the solid at a height, with 1 where it is within, -1 where it is outside."""
    sides = {number: (z <= height) != turned for number, (height, turned) in caps.items()}
    squares = {number: float(profile.at(np.array(z))) for number, profile in profiles.items()}
    order = sorted(profiles, key=lambda number: squares[number])
    size = max([abs(square) for square in squares.values()], default=0.0)
    # From the axis outward
    sides |= {number: (squares[number] > 0) != profiles[number].outer for number in order}
    found = []
    before = region.contains(sides)
    for place, number in enumerate(order):
        if squares[number] <= 0:
            continue
        later = order[place + 1] if place + 1 < len(order) else None
        sides = sides | {number: profiles[number].outer}
        after = region.contains(sides)
        if later is not None and squares[later] - squares[number] <= _NEAR * size and len({before, after}) > 1:
            raise Unknown  # circles that are all but the same
        if before != after:
            found.append((number, 1 if before else -1))
        before = after
    if before:
        raise Unknown  # without end across the axis
    return found


def _ring_area(
    profiles: dict[int, Profile], height: float, below: list[tuple[int, int]], above: list[tuple[int, int]]
) -> float:
    """The area of what is solid on one side of a height only."""
    ends: list[tuple[float, int]] = []
    for part, circles in enumerate((below, above)):
        for number, _ in circles:
            ends.append((max(float(profiles[number].at(np.array(height))), 0.0), part))
    inside = [bool(circles) and circles[0][1] > 0 for circles in (below, above)]
    area, last = 0.0, 0.0
    for square, part in sorted(ends):
        area += math.pi * (square - last) if inside[0] != inside[1] else 0.0
        inside[part], last = not inside[part], square
    return area
