"""Conics of optics, by radius of curvature R and conic constant k: the solid cap, the sheet, the stop, and their walls.

About the vertex x² + y² + (1 + k) z² = 2 R z. Only the part through the vertex counts,
z = r² / (R (1 + sqrt(1 - (1 + k) r² / R²))): the plane through the centre, z = R / (1 + k), cuts off the other bowl of
a hyperboloid (k < -1) and the far half of an ellipsoid (k > -1).
"""

from __future__ import annotations

import math
from abc import abstractmethod
from collections.abc import Sequence
from fractions import Fraction
from functools import cached_property
from typing import Any

import numpy as np

from .._util.arrays import FloatArray, Vector, ignore_fp_errors, two_product, two_sum
from .._util.records import dataclass
from .._util.validation import check_fields, check_nonnegative, check_number, check_positive, format_value
from ..numerics import bigfloat as ex
from ..numerics.portable_math import hypot, is_finite
from .bounds.support import (
    Pair,
    elliptic_support,
    elliptic_supports,
    pair_above,
    pair_polynomial,
    plane_lengths,
    raised_sums,
    round_up,
    sum_up,
)
from .cell import (
    PLAIN_UV,
    UV,
    All,
    Any_,
    Cell,
    Face,
    Not,
    SurfaceSheet,
    Tree,
    cartesian_uv,
    cylindrical_uv,
    transform_uv,
)
from .shape import Primitive, PrimitiveSheet, PrimitiveSolid
from .surface import PlaneSurface, QuadricSurface, Surface
from .transform import Motion


def check_radius(owner: str, field: str, value: Any) -> float:
    """Return a radius of curvature, infinite for a plane. Raise ValueError for 0."""
    radius = check_number(owner, field, value, finite=False)
    if radius == 0:
        raise ValueError(f"{owner}: {field} must not be 0: infinity is that of a plane, got {format_value(value)}")
    return math.inf if math.isinf(radius) else radius


def conic_reaches(radius: float, conic: float, semi: float) -> bool:
    """Return True if the part through the vertex reaches the distance `semi` from the axis: (1 + k) r² <= R²."""
    # Without a root, so that a hemisphere of exactly this diameter is accepted
    return not is_finite(radius) or (1 + ex.rational(conic)) * ex.rational(semi) ** 2 <= ex.rational(radius) ** 2


def check_reach(owner: str, field: str, radius: float, conic: float, diameter: float, names: str) -> None:
    """Raise ValueError for a diameter over that of the ellipsoid. `names` are the fields that give it."""
    if not conic_reaches(radius, conic, diameter / 2):
        widest = 2 * abs(radius) / math.sqrt(1 + conic)
        reason = f"a conic of radius {radius:g} and constant {conic:g} is {widest:.6g} wide"
        raise ValueError(f"{owner}: {field} must not be over what {names}: {reason}, got {diameter:g}")


@dataclass(frozen=True)
class ConicWall:
    """One end of a solid of revolution about z: a conic, a flat ring around it, or a plane.

    The conic has its vertex at the height `vertex` and reaches out to `semi` from the axis; the ring goes on to `edge`.
    """

    radius: float
    conic: float
    vertex: Any
    semi: float
    edge: float
    number: int = 0
    ring: int = 1
    hidden: int = 2
    """The face number of planes that only cut off the other parts of the quadric; no ray crosses the solid there."""

    @property
    def is_plane(self) -> bool:
        return not is_finite(self.radius)

    @property
    def has_ring(self) -> bool:
        return not self.is_plane and self.semi < self.edge

    def sag(self, distance: float) -> ex.BigFloat:
        """Return z - vertex at a distance from the axis, at most `semi`."""
        if self.is_plane:
            return ex.ZERO
        # This form of the root has no difference of large numbers, also for nearly flat surfaces
        square, radius = ex.rational(distance) ** 2, ex.rational(self.radius)
        under = ex.exact(1 - (1 + ex.rational(self.conic)) * square / radius**2)
        return ex.exact(square) / (ex.exact(radius) * (ex.ONE + ex.sqrt(under)))

    @cached_property
    def depth(self) -> ex.BigFloat:
        """The height of the rim above the vertex."""
        return self.sag(self.semi)

    @cached_property
    def rim(self) -> ex.BigFloat:
        """The height of the rim, and of the ring."""
        return ex.exact(self.vertex) + self.depth

    @property
    def center(self) -> ex.BigFloat:
        """The height of the centre of an ellipsoid or a hyperboloid."""
        return ex.exact(self.vertex) + ex.exact(ex.rational(self.radius) / (1 + ex.rational(self.conic)))

    @property
    def surface(self) -> Surface:
        """x² + y² + (1 + k) z² - 2 R z about the vertex, or the plane z = vertex."""
        if self.is_plane:
            return axial_plane(1, self.vertex)
        anchor = (0.0, 0.0, self.vertex)
        return QuadricSurface((1.0, 1.0, 1 + ex.rational(self.conic)), (0.0, 0.0, -self.radius), 0.0, anchor=anchor)

    @property
    def uv(self) -> UV:
        """The map (angle / 360, share of the height of the rim); on a plane (x, y) / edge."""
        vertex = ex.rounded(self.vertex)
        height = ex.rounded(self.depth)
        if self.is_plane or not height:
            return cartesian_uv((self.edge, 0, 0), (0, self.edge, 0))
        return cylindrical_uv(vertex, vertex + height) if vertex + height != vertex else PLAIN_UV

    @property
    def ring_uv(self) -> UV:
        return cartesian_uv((self.edge, 0, 0), (0, self.edge, 0))

    def bowl(self) -> Cell:
        """Return the hollow side of the conic: the part of the quadric's inside that the vertex belongs to."""
        faces = [Face(self.surface, self.number, self.uv)]
        # A hyperboloid has a second bowl, beyond the plane through its centre
        if self.conic < -1:
            sense = -1 if self.radius > 0 else 1
            faces.append(Face(axial_plane(sense, self.center), self.hidden))
        return Cell(tuple(faces))

    def sides(self, above: bool, reach: Any) -> tuple[list[Tree], list[Face]]:
        """Return (trees, planes) whose intersection, within `edge` of the axis, is above the wall, or below it.

        Parameters
        ----------
        above : bool
            Which side.
        reach : exact number
            The solid does not go beyond this height on that side.
        """
        if self.is_plane:
            sense = -1 if above else 1
            return [Cell((Face(axial_plane(sense, self.vertex), self.number, self.uv),))], []
        # A positive radius curves towards larger z: above its vertex lies the hollow side
        hollow = (self.radius > 0) == above
        far = -1 if self.radius > 0 else 1  # the sense of a plane whose far side is in the hollow
        if hollow:
            beyond = self.rim if self.has_ring else self._closing_height(reach)
            if beyond is None:
                return [self.bowl()], []
            return [Any_((self.bowl(), Cell((self._flat(far, beyond),))))], []
        end = self.rim if self.has_ring else self.center if self.conic > -1 else None
        return [Not(self.bowl())], [] if end is None else [self._flat(-far, end)]

    def _flat(self, sense: int, height: ex.BigFloat) -> Face:
        """Return the plane of the ring, or the one through the centre."""
        return Face(axial_plane(sense, height), self.ring if self.has_ring else self.hidden, self.ring_uv)

    def _closing_height(self, reach: Any) -> ex.BigFloat | None:
        """Return the height from which on an ellipsoid closes again, if the solid goes so far; else None."""
        if self.conic <= -1:
            return None
        over = ex.exact(reach) - self.center
        return self.center if (over if self.radius > 0 else -over) > 0 else None

    def support(self, direction: Vector, hollow: bool, hole: float = 0.0) -> float:
        """Return sup direction·p over the wall between `hole` and `edge`.

        `hollow` is True if the solid is on the hollow side of the conic, which then bulges out of it; otherwise the
        rims of the wall are enough.
        """
        best = ring_support(self.edge, self.rim, direction)
        if hole:
            best = max(best, ring_support(hole, ex.exact(self.vertex) + self.sag(hole), direction))
        if self.is_plane or not hollow:
            return best
        sense = 1 if self.radius > 0 else -1
        size, steep = Fraction(abs(self.radius)), 1 + Fraction(self.conic)
        # Upwards, whichever way the conic opens
        low, high = sense * self.sag(hole), sense * self.depth
        top = round_up(high) if steep <= 0 else min(round_up(high), round_up(ex.exact(size / steep)))
        x, y, z = direction
        cap = elliptic_support(1.0, 1.0, (0, 2 * size, -steep), -round_up(-low), top, (x, y, sense * z))
        lifted = float(self.vertex) * z
        return max(best, sum_up((cap, lifted)) if lifted else cap)


_STEEP = 2.0**-20
"""A conic whose square of the cosine of its slope is below this at the rim has its support from 3000 bits."""


def _depths(radius: FloatArray, conic: FloatArray, distance: FloatArray) -> tuple[Pair, FloatArray]:
    """Return `ConicWall.sag` of many, as pairs, and the square of the cosine of its slope; NaN for planes."""
    steep, square = two_sum(np.ones_like(conic), conic), two_product(distance, distance)
    under = 1 - steep[0] * square[0] / (radius * radius)
    depth = square[0] / (radius * (1 + np.sqrt(under)))
    # A step of Newton's towards (1 + k) z² - 2 R z + r² = 0
    over, _ = pair_polynomial(depth, (square, (-2 * radius, 0 * radius), steep))
    return two_sum(depth, 0.5 * over / (radius - steep[0] * depth)), under


@ignore_fp_errors
def _wall_supports(walls: Sequence[tuple[ConicWall, bool, float]], directions: FloatArray) -> FloatArray:
    """Return `ConicWall.support` of n walls in m directions each; NaN for steep rims. Sums are rounded up."""
    rows = [(w.radius, w.conic, float(w.vertex), w.semi, w.edge, hollow, hole) for w, hollow, hole in walls]
    radius, conic, vertex, semi, edge, hollow, hole = np.array(rows).T
    across = plane_lengths(directions[..., 0], directions[..., 1])
    up, is_curved = directions[..., 2], np.isfinite(radius)

    def ring(distance: FloatArray, depth: Pair) -> FloatArray:
        """Return the supports of circles about the axis, at depths below the vertices."""
        height, lost = two_sum(vertex, np.where(is_curved, depth[0], 0.0))
        height, rest = two_sum(height, lost + np.where(is_curved, depth[1], 0.0))
        top, bottom = pair_above(height, rest)[:, None], -pair_above(-height, -rest)[:, None]
        return raised_sums(np.stack([up * np.where(up > 0, top, bottom), distance[:, None] * across], axis=-1))

    deep, under = _depths(radius, conic, semi)
    shallow, _ = _depths(radius, conic, hole)
    best = ring(edge, deep)
    best = np.where(hole[:, None] > 0, np.maximum(best, ring(hole, shallow)), best)
    # The cap, upwards: along the axis it ends at its vertex or hole and at its rim, and nowhere is it wider than there
    sense, size, one = np.copysign(1.0, radius), np.abs(radius), np.ones(len(radius))
    low, high = -pair_above(-sense * shallow[0], -sense * shallow[1]), pair_above(sense * deep[0], sense * deep[1])
    # An ellipsoid ends at its equator
    high = np.where(conic > -1, np.minimum(high, np.nextafter(size / (1 + conic), np.inf)), high)
    solids = np.stack([one, one, 0 * one, 2 * size, -(1 + conic), low, high], axis=-1)
    lifted = up * vertex[:, None]
    ways = np.stack([directions[..., 0], directions[..., 1], up * sense[:, None]], axis=-1)
    caps = raised_sums(np.stack([elliptic_supports(solids, np.zeros((len(solids), 3)), ways), lifted], axis=-1))
    at_vertex = np.where(hole[:, None] > 0, -np.inf, lifted)
    caps = np.where(across == 0, at_vertex, np.where(up == 0, -np.inf, caps))
    best = np.where(((hollow != 0) & is_curved)[:, None], np.maximum(best, caps), best)
    return np.where((~is_curved | (under > _STEEP))[:, None] & np.isfinite(best), best, np.nan)


class ConicEnds(Primitive, abstract=True):
    """A shape of revolution whose supports are those of its ends."""

    @property
    @abstractmethod
    def _ends(self) -> tuple[tuple[ConicWall, bool, float], ...]:
        """Each end with `hollow` and `hole` of `ConicWall.support`."""

    @property
    def _has_batch_support(self) -> bool:
        return True

    def support(self, direction: Vector) -> float:
        return float(self._supports([self], np.array([[direction]]))[0, 0])

    @classmethod
    def _supports(cls, shapes: Sequence[Any], directions: FloatArray) -> FloatArray:
        found = []
        for ends in zip(*(shape._ends for shape in shapes), strict=True):
            found.append(_wall_supports(ends, directions))
            for shape, way in np.argwhere(np.isnan(found[-1])).tolist():
                wall, hollow, hole = ends[shape]
                x, y, z = directions[shape, way].tolist()
                found[-1][shape, way] = wall.support((x, y, z), hollow, hole)
        return np.asarray(np.max(found, axis=0))


def ring_support(edge: float, height: ex.BigFloat, direction: Vector) -> float:
    """Return sup direction·p over a circle of radius `edge` about the axis at a height."""
    z = direction[2]
    lifted = z * (round_up(height) if z > 0 else -round_up(-height)) if z else 0.0
    across = edge * hypot(direction[0], direction[1])
    return sum_up((across, lifted))


def axial_plane(sense: int, height: Any) -> PlaneSurface:
    """Return the half-space sense z <= sense height, sense being +1 or -1."""
    height = ex.exact(height)
    return PlaneSurface((0.0, 0.0, float(sense)), height if sense > 0 else -height, (0.0, 0.0, height))


def round_tube(radius: float) -> QuadricSurface:
    """Return the cylinder x² + y² <= radius²."""
    return QuadricSurface((1.0, 1.0, 0.0), constant=ex.rational(radius) ** 2)


@dataclass(frozen=True)
class Conic(ConicEnds, PrimitiveSolid):
    """x² + y² + (1 + k) z² <= 2 R z between the vertex, z = 0, and the plane of the rim: a solid cap.

    R is `radius_of_curvature`, over 0 where the centre lies at z > 0; k is `conic_constant`: below -1 a hyperboloid,
    -1 a paraboloid, above -1 an ellipsoid (long along z below 0, a sphere at 0, flat above). `aperture` is the diameter
    of the rim, which lies at z = c r² / (1 + sqrt(1 - (1 + k) c² r²)) with c = 1 / R, r = aperture / 2. An aperture
    beyond the ellipsoid's equator is refused. `sheet()` is the curved part alone.
    Faces: 0 the conic, 1 the flat end at the rim. uv: (angle / 360, height from vertex to rim in [0, 1]) on the conic,
    (x, y) / r on the flat end.
    """

    radius_of_curvature: float
    conic_constant: float = 0.0
    aperture: float = 1.0

    def __post_init__(self) -> None:
        check_conic(self)
        if math.isinf(self.radius_of_curvature):
            raise ValueError("Conic: radius_of_curvature must be finite: flat, it holds nothing (a ConicSheet may be)")

    def sheet(self) -> ConicSheet:
        """Return the conic as an open surface, without the flat end."""
        return ConicSheet(self.radius_of_curvature, self.conic_constant, self.aperture, motion=self.motion)

    @cached_property
    def wall(self) -> ConicWall:
        """The conic in its own frame."""
        return conic_wall(self)

    def tree(self) -> Cell:
        wall, r = self.wall, self.aperture / 2
        conic, *cut = wall.bowl().faces
        sense = 1 if self.radius_of_curvature > 0 else -1
        end = Face(axial_plane(sense, wall.rim), 1, cartesian_uv((r, 0, 0), (0, r, 0)))
        return Cell((conic, end, *cut))

    @property
    def _ends(self) -> tuple[tuple[ConicWall, bool, float], ...]:
        return ((self.wall, True, 0.0),)


@dataclass(frozen=True)
class ConicSheet(ConicEnds, PrimitiveSheet):
    """z = c r² / (1 + sqrt(1 - (1 + k) c² r²)), hole / 2 <= r <= aperture / 2: a thin mirror or an ideal surface.

    c is 1 / `radius_of_curvature`, 0 for an infinite one: a flat ring; k is `conic_constant`, `aperture` the diameter
    of the rim and `hole` that of a round hole about the vertex. The normal points to the side of negative z, whence
    light comes. Parts of it, off the axis or not round: ``sheet & solid``, ``sheet - solid``.
    Face 0. uv: (angle / 360, height from vertex to rim in [0, 1]); on a flat one (x, y) / (aperture / 2).
    """

    radius_of_curvature: float
    conic_constant: float = 0.0
    aperture: float = 1.0
    hole: float = 0.0

    def __post_init__(self) -> None:
        check_conic(self)
        object.__setattr__(self, "hole", check_nonnegative("ConicSheet", "hole", self.hole))
        if not self.hole < self.aperture:
            raise ValueError(f"ConicSheet: hole must be below aperture = {self.aperture:g}, got {self.hole:g}")

    @cached_property
    def wall(self) -> ConicWall:
        """The conic in its own frame."""
        return conic_wall(self)

    def sheet(self, motion: Motion) -> SurfaceSheet:
        wall, side = self.wall, -1
        if wall.is_plane:
            clip = ring_clip(self.hole / 2, self.aperture / 2, motion)
        else:
            sense = 1 if self.radius_of_curvature > 0 else -1
            side = sense  # the gradient at the vertex points against the centre
            planes = [axial_plane(sense, wall.rim), *(face.surface for face in wall.bowl().faces[1:])]
            if self.hole > 0:
                planes.append(axial_plane(-sense, wall.sag(self.hole / 2)))
            clip = Cell(tuple(Face(surface.moved(motion), 0) for surface in planes))
        return SurfaceSheet(wall.surface.moved(motion), clip, side, uv=transform_uv(wall.uv, motion))

    @property
    def _ends(self) -> tuple[tuple[ConicWall, bool, float], ...]:
        return ((self.wall, True, self.hole / 2),)


def check_conic(shape: Conic | ConicSheet) -> None:
    """Check the three numbers of a conic and set the checked values."""
    owner = type(shape).__name__
    check_fields(shape, radius_of_curvature=check_radius, conic_constant=check_number, aperture=check_positive)
    check_reach(
        owner,
        "aperture",
        shape.radius_of_curvature,
        shape.conic_constant,
        shape.aperture,
        "radius_of_curvature and conic_constant give",
    )


def conic_wall(shape: Conic | ConicSheet) -> ConicWall:
    """Return the wall of a conic with its vertex at the origin."""
    r = shape.aperture / 2
    return ConicWall(shape.radius_of_curvature, shape.conic_constant, 0.0, r, r)


def ring_clip(inner: float, outer: float, motion: Motion) -> Tree:
    """Return the tree of points within `outer` of the axis and not within `inner`, after a motion."""
    tube = Cell((Face(round_tube(outer).moved(motion), 0),))
    return All((tube, Not(Cell((Face(round_tube(inner).moved(motion), 0),))))) if inner > 0 else tube


@dataclass(frozen=True)
class Stop(PrimitiveSheet):
    """z = 0, aperture / 2 <= r <= diameter / 2: a thin screen with an opening of the diameter `aperture`.

    The normal is that of `ConicSheet`, towards negative z. Any opaque material of the body stops light.
    Face 0. uv: (x, y) / (diameter / 2).
    """

    aperture: float
    diameter: float

    def __post_init__(self) -> None:
        check_fields(self, aperture=check_positive, diameter=check_positive)
        if not self.aperture < self.diameter:
            raise ValueError(f"Stop: aperture must be below diameter = {self.diameter:g}, got {self.aperture:g}")

    def sheet(self, motion: Motion) -> SurfaceSheet:
        r = self.diameter / 2
        uv = transform_uv(cartesian_uv((r, 0, 0), (0, r, 0)), motion)
        return SurfaceSheet(axial_plane(1, 0.0).moved(motion), ring_clip(self.aperture / 2, r, motion), -1, uv=uv)

    def support(self, direction: Vector) -> float:
        return self.diameter / 2 * hypot(direction[0], direction[1])
