"""One end of what is turned about z: a conic through its vertex, a flat ring around it, or a plane.

With the radius of curvature R and the conic constant k, x² + y² + (1 + k) z² = 2 R z about the vertex. Of it only the
part through the vertex counts, z = r² / (R (1 + sqrt(1 - (1 + k) r² / R²))): the other bowl of a hyperboloid (k < -1)
and the far half of an ellipsoid (k > -1) are cut off by the plane through the centre, z = R / (1 + k), which meets
neither.
"""

from __future__ import annotations

import math
from dataclasses import dataclass
from fractions import Fraction
from typing import Any

from . import exact as ex
from .cells import PLAIN_UV, UV, Any_, Cell, Face, Not, Tree, around_z, flat
from .planar import rounded_up
from .rounded import hypot, is_finite
from .support import elliptic_support, sum_up
from .surface import PlaneSurface, QuadricSurface, Surface
from .validate import number, shown
from .vector import Vector


def radius_of(owner: str, field: str, value: Any) -> float:
    """A radius of curvature: not zero, infinite for a plane."""
    radius = number(owner, field, value, finite=False)
    if radius == 0:
        raise ValueError(f"{owner}: {field} must not be 0: infinity is that of a plane, got {shown(value)}")
    return math.inf if math.isinf(radius) else radius


def reaches(radius: float, conic: float, semi: float) -> bool:
    """Whether the part through the vertex has points at the distance `semi` from the axis: (1 + k) r² <= R²."""
    return not is_finite(radius) or (1 + ex.rational(conic)) * ex.rational(semi) ** 2 <= ex.rational(radius) ** 2


def check_reach(owner: str, field: str, radius: float, conic: float, diameter: float, names: str) -> None:
    """Refuse a diameter over that of the ellipsoid."""
    if not reaches(radius, conic, diameter / 2):
        widest = 2 * abs(radius) / math.sqrt(1 + conic)
        told = f"a conic of radius {radius:g} and constant {conic:g} is {widest:.6g} wide"
        raise ValueError(f"{owner}: {field} must not be over what {names}: {told}, got {diameter:g}")


@dataclass(frozen=True, slots=True)
class ConicWall:
    """A conic at the height `vertex` out to `semi` from the axis, and a flat ring from there to `edge`."""

    radius: float
    conic: float
    vertex: Any
    semi: float
    edge: float
    number: int = 0
    ring: int = 1
    hidden: int = 2
    """Of planes that only cut off what is no part of the wall, and that nothing meets."""

    @property
    def is_plane(self) -> bool:
        return not is_finite(self.radius)

    @property
    def has_ring(self) -> bool:
        return not self.is_plane and self.semi < self.edge

    def sag(self, distance: float) -> ex.Exact:
        """z - vertex at a distance from the axis, which is not over `semi`."""
        if self.is_plane:
            return ex.ZERO
        square, radius = ex.rational(distance) ** 2, ex.rational(self.radius)
        under = ex.exact(1 - (1 + ex.rational(self.conic)) * square / radius**2)
        return ex.exact(square) / (ex.exact(radius) * (ex.ONE + ex.sqrt(under)))

    @property
    def rim(self) -> ex.Exact:
        """The height of the rim, and of the ring."""
        return ex.exact(self.vertex) + self.sag(self.semi)

    @property
    def center(self) -> ex.Exact:
        """The height of the centre of an ellipsoid or a hyperboloid."""
        return ex.exact(self.vertex) + ex.exact(ex.rational(self.radius) / (1 + ex.rational(self.conic)))

    @property
    def surface(self) -> Surface:
        """x² + y² + (1 + k) z² - 2 R z about the vertex, or the plane z = vertex."""
        if self.is_plane:
            return plane(1, self.vertex)
        anchor = (0.0, 0.0, self.vertex)
        return QuadricSurface((1.0, 1.0, 1 + ex.rational(self.conic)), (0.0, 0.0, -self.radius), 0.0, anchor=anchor)

    @property
    def uv(self) -> UV:
        """(angle / 360, share of the height of the rim); on a plane (x, y) / edge."""
        vertex = ex.rounded(self.vertex)
        height = ex.rounded(self.sag(self.semi))
        if self.is_plane or not height:
            return flat((self.edge, 0, 0), (0, self.edge, 0))
        return around_z(vertex, vertex + height) if vertex + height != vertex else PLAIN_UV

    @property
    def ring_uv(self) -> UV:
        return flat((self.edge, 0, 0), (0, self.edge, 0))

    def bowl(self) -> Cell:
        """The hollow side of the conic: what of the quadric's inside belongs to the part through the vertex."""
        faces = [Face(self.surface, self.number, self.uv)]
        if self.conic < -1:
            sense = -1 if self.radius > 0 else 1
            faces.append(Face(plane(sense, self.center), self.hidden))
        return Cell(tuple(faces))

    def sides(self, above: bool, reach: Any) -> tuple[list[Tree], list[Face]]:
        """(trees, planes) whose intersection, within `edge` of the axis, lies above the wall, or below it.

        reach: a height that the rest of the solid does not go beyond on that side.
        """
        if self.is_plane:
            sense = -1 if above else 1
            return [Cell((Face(plane(sense, self.vertex), self.number, self.uv),))], []
        hollow = (self.radius > 0) == above
        far = -1 if self.radius > 0 else 1  # the sense of a plane that leaves what lies beyond it in the hollow
        if hollow:
            beyond = self.rim if self.has_ring else self._needed(reach)
            if beyond is None:
                return [self.bowl()], []
            return [Any_((self.bowl(), Cell((self._flat(far, beyond),))))], []
        end = self.rim if self.has_ring else self.center if self.conic > -1 else None
        return [Not(self.bowl())], [] if end is None else [self._flat(-far, end)]

    def _flat(self, sense: int, height: ex.Exact) -> Face:
        """The ring as a plane, or the one through the centre."""
        return Face(plane(sense, height), self.ring if self.has_ring else self.hidden, self.ring_uv)

    def _needed(self, reach: Any) -> ex.Exact | None:
        """The height from which on an ellipsoid closes again, if the solid goes so far."""
        if self.conic <= -1:
            return None
        over = ex.exact(reach) - self.center
        return self.center if (over if self.radius > 0 else -over) > 0 else None

    def support(self, direction: Vector, hollow: bool, hole: float = 0.0) -> float:
        """sup of direction·p over the wall between `hole` and `edge`; of its ends alone, if the solid is not `hollow`.

        The solid lies on the hollow side of its conic where that bulges out of it.
        """
        best = ring_support(self.edge, self.rim, direction)
        if hole:
            best = max(best, ring_support(hole, ex.exact(self.vertex) + self.sag(hole), direction))
        if self.is_plane or not hollow:
            return best
        sense = 1 if self.radius > 0 else -1
        size, steep = Fraction(abs(self.radius)), 1 + Fraction(self.conic)
        low, high = (sense * self.sag(distance) for distance in (hole, self.semi))
        top = rounded_up(high) if steep <= 0 else min(rounded_up(high), rounded_up(ex.exact(size / steep)))
        x, y, z = direction
        cap = elliptic_support(1.0, 1.0, (0, 2 * size, -steep), -rounded_up(-low), top, (x, y, sense * z))
        lifted = float(self.vertex) * z
        return max(best, sum_up((cap, lifted)) if lifted else cap)


def ring_support(edge: float, height: ex.Exact, direction: Vector) -> float:
    """sup of direction·p over a circle of radius `edge` about the axis."""
    z = direction[2]
    lifted = z * (rounded_up(height) if z > 0 else -rounded_up(-height)) if z else 0.0
    across = edge * hypot(direction[0], direction[1])
    return sum_up((across, lifted))


def plane(sense: int, height: Any) -> PlaneSurface:
    """sense z <= sense height"""
    height = ex.exact(height)
    return PlaneSurface((0.0, 0.0, float(sense)), height if sense > 0 else -height, (0.0, 0.0, height))


def tube(radius: float) -> QuadricSurface:
    """x² + y² <= radius²"""
    return QuadricSurface((1.0, 1.0, 0.0), constant=ex.rational(radius) ** 2)
