"""A part of a ball or of a spherical shell, by ranges of its polar angle and of its azimuth."""

from __future__ import annotations

from dataclasses import dataclass, replace

from . import exact as ex
from .base import PrimitiveSolid
from .cells import UV, Any_, Cell, Face, Tree, around_z, flat
from .cylinder import arc_support, cut_open, wedge_walls
from .degrees import degrees, turn
from .motion import Motion, Translate
from .rounded import hypot, larger, sin_cos_degrees
from .support import sum_up
from .surface import PlaneSurface, QuadricSurface
from .tube import check_inner
from .validate import interval, nonnegative, positive, vector
from .vector import Interval, Vector, VectorLike

_AT_LOW, _AT_HIGH = 2, 3
_HIDDEN = 6
"""The plane between the nappes of a cone, which is no wall."""


@dataclass(frozen=True)
class SphereSection(PrimitiveSolid):
    """Of a ball, or of a shell with an inner radius, what lies in ranges of spherical coordinates, in degrees.

    Own frame: axes of the world about `center`. inner_radius <= r <= radius; the polar angle, 0 at +z and 180 at -z,
    in `polar_range`, within [0, 180]; the azimuth of (x, y), counter-clockwise from +x, from `start_angle` to
    `end_angle`, their difference in (0, 360]. Without a range all of it: a hemisphere is ``polar_range=(0, 90)``.

    Faces: 0 outer sphere, 1 inner sphere, 2 cone of the lower polar angle, 3 cone of the higher one (planes at 90;
    angles that add up to 180 have one cone for both: face 2), 4 wall at start_angle, 5 wall at end_angle (half a turn
    has one plane for both: face 4). uv: (angle / 360, height from south to north pole in [0, 1]) on the spheres,
    (angle / 360, z from end to end of the cone in [0, 1]) on the cones, (x, y) / radius on planes at 90, (distance from
    the axis, z) / radius on the walls.
    Source: the sphere of detector simulation (Geant4, "Book for Application Developers", solids).
    """

    radius: float = 1.0
    inner_radius: float = 0.0
    polar_range: Interval | None = None
    start_angle: float = 0.0
    end_angle: float = 360.0
    center: VectorLike = (0.0, 0.0, 0.0)

    def __post_init__(self) -> None:
        owner = "SphereSection"
        object.__setattr__(self, "radius", positive(owner, "radius", self.radius))
        object.__setattr__(self, "inner_radius", nonnegative(owner, "inner_radius", self.inner_radius))
        check_inner(owner, "radius", self.inner_radius, self.radius)
        found = interval(owner, "polar_range", self.polar_range)
        if found is not None:
            low, high = (degrees(owner, f"polar_range[{k}]", angle) for k, angle in enumerate(found))
            if low < 0 or high > 180:
                raise ValueError(f"{owner}: polar_range must lie within 0 and 180 degrees, got ({low:g}, {high:g})")
            found = low, high
        object.__setattr__(self, "polar_range", found)
        first, last = turn(owner, self.start_angle, self.end_angle)
        object.__setattr__(self, "start_angle", first)
        object.__setattr__(self, "end_angle", last)
        object.__setattr__(self, "center", vector(owner, "center", self.center))

    @property
    def polar(self) -> Interval:
        """The range of the polar angle, (0, 180) where none is given."""
        return (0.0, 180.0) if self.polar_range is None else self.polar_range

    @property
    def placement(self) -> Motion:
        return Motion((Translate(self.center),))

    def tree(self) -> Tree:
        low, high = self.polar
        faces = [self._ball(self.radius, 0)]
        more: list[Tree] = []
        if self.inner_radius > 0:
            more.append(Cell((replace(self._ball(self.inner_radius, 1), inside=-1),)))
        if self.has_one_cone:
            more.append(self._outside_of_both_nappes())
        for angle, number, sense in () if self.has_one_cone else ((low, _AT_LOW, -1), (high, _AT_HIGH, 1)):
            if not (angle < 90 or angle > 90):  # where a formula is recorded, "equal" is to move alike
                faces.append(Face(_level(-sense), number, flat((self.radius, 0, 0), (0, self.radius, 0))))
            elif 0 < angle < 180:
                more.append(self._nappe(angle, number, sense))
        walls = wedge_walls(self.start_angle, self.end_angle, self.radius, self.radius)
        numbered = tuple(replace(wall, number=wall.number + 1) for wall in walls)
        return cut_open(tuple(faces), numbered, self.end_angle - self.start_angle, *more)

    def _ball(self, radius: float, number: int) -> Face:
        surface = QuadricSurface(squares=(1.0, 1.0, 1.0), constant=ex.rational(radius) ** 2)
        return Face(surface, number, around_z(-radius, radius))

    @property
    def has_one_cone(self) -> bool:
        """Whether both polar angles are of one cone, with two nappes: they add up to 180."""
        low, high = (ex.rational(angle) for angle in self.polar)
        return bool(low > 0) and not (low + high < 180 or low + high > 180)

    def _outside_of_both_nappes(self) -> Cell:
        s, c = ex.sin_cos_degrees(self.polar[0])
        end = self.radius * sin_cos_degrees(self.polar[0])[1]
        cone = QuadricSurface((c * c, c * c, -(s * s)), constant=0.0)
        return Cell((Face(cone, _AT_LOW, around_z(-end, end), inside=-1),))

    def _nappe(self, angle: float, number: int, sense: int) -> Tree:
        """Polar angles up to an angle (sense 1), or from it on (-1): inside or outside of one nappe of its cone."""
        s, c = ex.sin_cos_degrees(angle)
        cone = QuadricSurface((c * c, c * c, -(s * s)), constant=0.0)
        above, uv = 1 if angle < 90 else -1, self._cone_uv(angle)  # where the nappe is; a number has one map
        if sense == above:
            return Cell((Face(cone, number, uv), Face(_level(-above), _HIDDEN)))
        return Any_((Cell((Face(cone, number, uv, inside=-1),)), Cell((Face(_level(above), _HIDDEN),))))

    def _cone_uv(self, angle: float) -> UV:
        _, c = sin_cos_degrees(angle)
        near, far = self.inner_radius * c, self.radius * c
        return around_z(near, far) if angle < 90 else around_z(far, near)

    def support(self, direction: Vector) -> float:
        """ρ (u_z cos θ + w sin θ) at its largest; w is the support of the arc of azimuths in the direction u."""
        w, uz = arc_support(1.0, self.start_angle, self.end_angle, direction), direction[2]
        ends = [sin_cos_degrees(angle) for angle in self.polar]
        (s, c), (t, d) = ends
        radii = (self.radius, self.inner_radius)
        found = [sum_up((r * cosine * uz, r * sine * w)) for r in radii for sine, cosine in ends]
        if w >= 0 and w * c >= uz * s and uz * t >= w * d:
            found.append(self.radius * hypot(w, uz))
        best = found[0]
        for reach in found[1:]:
            best = larger(best, reach)
        return best


def _level(sense: int) -> PlaneSurface:
    """z <= 0 (sense 1) or z >= 0 (-1)."""
    return PlaneSurface((0.0, 0.0, float(sense)), 0.0)
