"""Regular prisms and pyramids: equal sides around the z axis."""

from __future__ import annotations

from abc import abstractmethod
from dataclasses import dataclass
from fractions import Fraction
from typing import Any, Literal

from . import exact as ex
from .degrees import degrees
from .prismatoid import Level, Prismatoid, Side, finite_range, plain_map
from .validate import integer, nonnegative, positive, shown
from .vector import Interval

MOST_SIDES = 1000
RadiusTo = Literal["corners", "sides"]


class Regular(Prismatoid, abstract=True):
    """Equal sides around z, which may lean: corner k, from 0, is at the angle start_angle + 360 k / sides."""

    sides: int
    radius: float
    z_range: Interval
    start_angle: float
    radius_to: RadiusTo

    def _check(self) -> None:
        owner = type(self).__name__
        object.__setattr__(self, "sides", integer(owner, "sides", self.sides, 3, MOST_SIDES))
        object.__setattr__(self, "radius", positive(owner, "radius", self.radius))
        object.__setattr__(self, "z_range", finite_range(owner, self.z_range))
        object.__setattr__(self, "start_angle", degrees(owner, "start_angle", self.start_angle))
        if not isinstance(self.radius_to, str) or self.radius_to not in ("corners", "sides"):
            raise ValueError(f"{owner}: radius_to must be 'corners' or 'sides', got {shown(self.radius_to)}")

    @property
    @abstractmethod
    def radii(self) -> tuple[float, float]:
        """At the lower end and at the upper, to what `radius_to` says."""

    @property
    def heights(self) -> tuple[Any, Any]:
        return ex.rational(self.z_range[0]), ex.rational(self.z_range[1])

    def _directions(self, first: Fraction) -> list[tuple[ex.Exact, ex.Exact]]:
        """(cosine, sine) of start_angle and a part of the angle between sides, for every side."""
        s, c = ex.sin_cos_degrees(self.start_angle)
        found = []
        for k in range(self.sides):
            t, d = ex.sin_cos_degrees(360 * (k + first) / self.sides)  # type: ignore[arg-type]
            found.append((ex.dot((c, -s), (d, t)), ex.dot((s, c), (d, t))))
        return found

    def _reach(self, radius: float, to: RadiusTo) -> ex.Exact:
        """The distance of sides, or of corners, from the axis."""
        _, c = ex.sin_cos_degrees(Fraction(180, self.sides))  # type: ignore[arg-type]
        given = ex.exact(radius)
        if to == self.radius_to:
            return given
        return given * c if to == "sides" else given / c

    def flanks(self) -> list[Side]:
        low, high = (self._reach(radius, "sides") for radius in self.radii)
        s, _ = ex.sin_cos_degrees(Fraction(180, self.sides))  # type: ignore[arg-type]
        edge = self._reach(self.radius, "corners") * s * ex.exact(2)
        z, height = self.heights[0], ex.exact(self.heights[1]) - ex.exact(self.heights[0])
        up = (ex.ZERO, ex.ZERO, ex.ONE / height, -ex.exact(z) / height)
        return [
            Side(x, y, low, high, plain_map((-y / edge, x / edge, ex.ZERO, 0.5), up))
            for x, y in self._directions(Fraction(1, 2))
        ]

    def levels(self) -> tuple[Level, Level]:
        bottom, top = (self._level(radius) for radius in self.radii)
        return bottom, top

    def _level(self, radius: float) -> Level:
        if not radius > 0:
            return Level([(ex.ZERO, ex.ZERO)], plain_map((0, 0, 0, 0), (0, 0, 0, 0)), False)
        reach = self._reach(radius, "corners")
        corners = [(reach * x, reach * y) for x, y in self._directions(Fraction(0))]
        size = ex.ONE / reach
        return Level(corners, plain_map((size, 0, 0, 0), (0, size, 0, 0)), True)


@dataclass(frozen=True)
class RegularPrism(Regular):
    """A prism of equal sides about the z axis, from one end of `z_range` to the other: a hexagonal bar or pin.

    `sides`: 3 to 1000. `radius` is that of the circle through the corners, or with radius_to="sides" of the one that
    touches the sides, half the width across flats: these are then exact, so that hexagons at such a pitch share their
    walls. Corner k, from 0, is at the angle start_angle + 360 k / sides, in degrees, counter-clockwise from +x.

    Faces: i is the side from corner i to the next, then the lower end and the upper. uv: along the edge from corner to
    corner and along z, each in [0, 1], on the sides; (x, y) in units of the circle through the corners on the ends.
    A triangular prism of glass is `Prism`.
    """

    sides: int
    radius: float
    z_range: Interval = (-1.0, 1.0)
    start_angle: float = 0.0
    radius_to: RadiusTo = "corners"

    def __post_init__(self) -> None:
        self._check()

    @property
    def radii(self) -> tuple[float, float]:
        return self.radius, self.radius


@dataclass(frozen=True)
class Pyramid(Regular):
    """A pyramid of equal sides about the z axis, its base at the lower end of `z_range`; with a `top_radius` cut off.

    `sides`: 3 to 1000. `radius`, of the base, and `top_radius`, of the upper end, 0 for a tip, are those of circles
    through the corners, or with radius_to="sides" of those that touch the sides. Corner k, from 0, is at the angle
    start_angle + 360 k / sides, in degrees, counter-clockwise from +x. On a rectangle it is a `Trapezoid`.

    Faces: i is the side from corner i to the next, then the base and, if there is one, the upper end. uv: along the
    edge of the base from corner to corner and along z, each in [0, 1], on the sides; (x, y) in units of the circle
    through the corners on the ends.
    """

    sides: int
    radius: float
    z_range: Interval = (0.0, 1.0)
    top_radius: float = 0.0
    start_angle: float = 0.0
    radius_to: RadiusTo = "corners"

    def __post_init__(self) -> None:
        self._check()
        object.__setattr__(self, "top_radius", nonnegative("Pyramid", "top_radius", self.top_radius))

    @property
    def radii(self) -> tuple[float, float]:
        return self.radius, self.top_radius
