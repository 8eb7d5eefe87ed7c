"""OpenMC's surfaces f = 0, in fractions: where they move to, what is known of their two sides, and as solids.

The negative side of a surface is the solid f <= 0. What cannot be told of a side is left open: an
extent may be too large and `side_of` may say 0, but neither is ever wrong.
"""

from __future__ import annotations

import math
from dataclasses import dataclass, replace
from fractions import Fraction

from ...shapes.base import Solid
from ...shapes.elliptic_cone import EllipticCone
from ...shapes.elliptic_cylinder import EllipticCylinder
from ...shapes.half_space import HalfSpace
from ...shapes.motion import STILL, Motion
from ...shapes.quadric import Quadric
from ...shapes.sphere import Sphere
from ...shapes.vector import Vector
from .extent import EVERYWHERE, End, Extent
from .placement import Placement, Point, Turn, floats

_CLEAR = 2.0**-40
"""Share of the largest term of a sum: what floats lose of it is far less."""
TERMS = ("xx", "yy", "zz", "xy", "yz", "xz", "x", "y", "z", "constant")
"""The terms of OpenMC's quadric, in the order of its coefficients."""


@dataclass(frozen=True, slots=True)
class FlatSurface:
    """normal·x - offset"""

    normal: Point
    offset: Fraction

    def __hash__(self) -> int:
        return _quick_hash((*self.normal, self.offset))

    def placed(self, place: Placement) -> FlatSurface:
        normal = place.turn.apply(self.normal)
        return FlatSurface(
            normal, self.offset + sum(n * s for n, s in zip(normal, place.shift, strict=True) if n and s)
        )

    @property
    def axis(self) -> int | None:
        """The axis that the normal lies along, if any."""
        x, y, z = self.normal
        if x:
            return None if y or z else 0
        if y:
            return None if z else 1
        return 2 if z else None

    def extent(self, positive: bool) -> Extent:
        """Around the side f >= 0 or f <= 0."""
        axis = self.axis
        if axis is None:
            return EVERYWHERE
        end, above = self.offset / self.normal[axis], positive == (self.normal[axis] > 0)
        ends: list[End] = [None, None, None]
        ends[axis] = end
        sides = (ends[0], ends[1], ends[2])
        return Extent(low=sides) if above else Extent(high=sides)

    def side_of(self, extent: Extent) -> int:
        """-1 where all of the extent has f <= 0, +1 where all of it has f >= 0, else 0."""
        most = extent.most(self.normal)
        if most is not None and most <= self.offset:
            return -1
        least = extent.least(self.normal)
        return 1 if least is not None and least >= self.offset else 0

    def solid(self, positive: bool = False) -> HalfSpace:
        sign = -1 if positive else 1
        x, y, z = floats(self.normal)
        return HalfSpace((sign * x + 0.0, sign * y + 0.0, sign * z + 0.0), sign * float(self.offset) + 0.0)


@dataclass(frozen=True, slots=True)
class RoundSurface:
    """|x - center|² - radius², the distance measured across `axis`: a cylinder, or, without an axis, a sphere."""

    axis: int | None
    center: Point
    radius: Fraction

    def __hash__(self) -> int:
        return _quick_hash((*self.center, self.radius))

    @property
    def across(self) -> tuple[int, ...]:
        """The axes that the distance is measured along."""
        return tuple(i for i in range(3) if i != self.axis)

    def placed(self, place: Placement) -> RoundSurface:
        axis = None if self.axis is None else place.turn.axis(self.axis)
        x, y, z = place.point(self.center)
        return RoundSurface(axis, _without(axis, (x, y, z)), self.radius)

    def extent(self, positive: bool) -> Extent:
        if positive:
            return EVERYWHERE
        lows: list[End] = [None, None, None]
        highs: list[End] = [None, None, None]
        for i in self.across:
            lows[i], highs[i] = self.center[i] - self.radius, self.center[i] + self.radius
        return Extent((lows[0], lows[1], lows[2]), (highs[0], highs[1], highs[2]))

    def side_of(self, extent: Extent) -> int:
        """-1 where all of the extent has f < 0, +1 where all of it has f > 0, else 0."""
        least, most = extent.square_distances(self.center, self.across)
        square = self.radius**2
        if most is not None and most < square:
            return -1
        return 1 if least > square else 0

    def side_of_plane(self, plane: FlatSurface) -> int:
        """-1 where all of the round solid has plane < 0, +1 where all of it has plane > 0, else 0."""
        if self.axis is not None and plane.normal[self.axis]:
            return 0
        clear = self._clear_side_of_plane(plane)
        if clear is not None:
            return clear
        height = sum((n * c for n, c in zip(plane.normal, self.center, strict=True)), -plane.offset)
        if height**2 <= self.radius**2 * sum(n * n for n in plane.normal):
            return 0
        return 1 if height > 0 else -1

    def _clear_side_of_plane(self, plane: FlatSurface) -> int | None:
        """What floats show of it, which is as good as always; None where they are close, or too large."""
        try:
            normal, center = floats(plane.normal), floats(self.center)
            height, radius = float(plane.offset), float(self.radius)
        except OverflowError:
            return None
        terms = [n * c for n, c in zip(normal, center, strict=True)]
        reach, above = radius * math.hypot(*normal), sum(terms) - height
        margin = _CLEAR * (sum(map(abs, terms)) + abs(height) + reach)
        if abs(above) < reach - margin:
            return 0
        return (1 if above > 0 else -1) if abs(above) > reach + margin else None

    def is_within(self, other: RoundSurface) -> bool:
        """Whether this solid lies strictly inside another of the same kind."""
        gap = other.radius - self.radius
        return self.axis == other.axis and gap > 0 and self._apart(other) < gap**2

    def is_apart(self, other: RoundSurface) -> bool:
        """Whether this solid lies strictly outside another of the same kind."""
        return self.axis == other.axis and self._apart(other) > (self.radius + other.radius) ** 2

    def _apart(self, other: RoundSurface) -> Fraction:
        """The squared distance between the centers."""
        return sum(((a - b) ** 2 for a, b in zip(self.center, other.center, strict=True)), Fraction(0))

    def solid(self) -> Solid:
        radius, center = float(self.radius), floats(self.center)
        if self.axis is None:
            return Sphere(radius, center)
        return _moved(EllipticCylinder(1, 1), _towards(self.axis, STILL.scale((radius, radius, 1)), center))


@dataclass(frozen=True, slots=True)
class ConeSurface:
    """The squared distance from the axis minus square × (height over the apex)², both nappes."""

    axis: int
    apex: Point
    square: Fraction

    def placed(self, place: Placement) -> ConeSurface:
        return ConeSurface(place.turn.axis(self.axis), place.point(self.apex), self.square)

    def extent(self, positive: bool) -> Extent:
        del positive
        return EVERYWHERE

    def side_of(self, extent: Extent) -> int:
        del extent
        return 0

    def solid(self) -> Solid:
        return _moved(EllipticCone(1, 1, float(self.square)), _towards(self.axis, STILL, floats(self.apex)))


@dataclass(frozen=True, slots=True)
class QuadricSurface:
    """The sum of `coefficients` times `TERMS` of x - shift."""

    coefficients: tuple[Fraction, ...]
    shift: Point

    def placed(self, place: Placement) -> QuadricSurface:
        return QuadricSurface(_turned(self.coefficients, place.turn), place.point(self.shift))

    def extent(self, positive: bool) -> Extent:
        del positive
        return EVERYWHERE

    def side_of(self, extent: Extent) -> int:
        del extent
        return 0

    def solid(self) -> Solid:
        values = {name: float(value) for name, value in zip(TERMS, self.coefficients, strict=True) if value}
        quadric = Quadric(coefficients=values)
        return quadric.translate(floats(self.shift)) if any(self.shift) else quadric


CurvedSurface = RoundSurface | ConeSurface | QuadricSurface
Surface = FlatSurface | CurvedSurface


def _quick_hash(values: tuple[Fraction, ...]) -> int:
    """That of `Fraction` agrees with the hashes of all other numbers, which takes long."""
    return hash(tuple([value.numerator for value in values] + [value.denominator for value in values]))


def _without(axis: int | None, point: Point) -> Point:
    x, y, z = (Fraction(0) if i == axis else value for i, value in enumerate(point))
    return x, y, z


def _moved(shape: Solid, motion: Motion) -> Solid:
    motion.check(type(shape).__name__)
    return replace(shape, motion=motion)


def _towards(axis: int, upright: Motion, place: Vector) -> Motion:
    """What turns something about z to another axis, its mirror images being the same, and moves it to a place."""
    if axis != 2:
        upright = upright.rotate((0, 1, 0), 90) if axis == 0 else upright.rotate((1, 0, 0), 90)
    return upright.translate(place) if any(place) else upright


def _turned(coefficients: tuple[Fraction, ...], turn: Turn) -> tuple[Fraction, ...]:
    """The coefficients after a turn: each term's axes are exchanged, with their signs."""
    result = dict.fromkeys(TERMS, Fraction(0))
    for name, value in zip(TERMS, coefficients, strict=True):
        if name == "constant":
            result[name] = value
            continue
        axes = ["xyz".index(letter) for letter in name]
        goes = sorted("xyz"[turn.axis(axis)] for axis in axes)
        sign = math.prod(turn.signs[turn.axis(axis)] for axis in axes)
        result["".join(goes)] = sign * value
    return tuple(result.values())
