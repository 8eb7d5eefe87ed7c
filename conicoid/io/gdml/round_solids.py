"""GDML solids of revolution about the z axis, and stretched solids of revolution.

Tubes, cones, spheres, ellipsoids, paraboloids and hyperboloids. Each public function reads the attributes of an
element and returns a `SolidFactory`, which builds the solid translated by a shift. Lengths are in mm, angles in
degrees. Wrong attributes raise GdmlError.
"""

from __future__ import annotations

import math
from collections.abc import Sequence
from dataclasses import field
from fractions import Fraction
from functools import partial

from ..._util.records import dataclass
from ...geometry.general_quadric import Quadric
from ...geometry.primitives import Box, HalfSpace, Sphere
from ...geometry.quadrics import Ellipsoid
from ...geometry.revolution import Revolution
from ...geometry.shape import Difference, Intersection, Solid
from ...geometry.transform import IDENTITY_MOTION
from ...numerics.portable_math import sin_cos_degrees
from ..openmc.placement import Point
from .solid_template import MOST_HELD, SolidFactory
from .values import GdmlError, GdmlValues

ProfileCorners = Sequence[tuple[Fraction, Fraction]]
"""Corners (r, z) around a profile, in mm."""
AngleRange = tuple[float, float]
"""First and last azimuth in degrees."""
_FULL_TURN: AngleRange = (0.0, 360.0)
_FULL_TURN_ERROR = Fraction(28, 10**9)
"""2 pi of ten digits is a full turn: Geant4's tubes and cones allow 5e-10 rad, which are 2.8e-8 degrees."""
_ZERO = Fraction(0)


def read_angles(values: GdmlValues) -> AngleRange:
    """Return the azimuths at which a solid begins and ends, in degrees; (0, 360) for a full turn."""
    width = values.angle("deltaphi", 360)
    if width <= 0:
        raise GdmlError(values.element, f"deltaphi must be > 0, got {float(width):g} degrees")
    if width > 360 - _FULL_TURN_ERROR:
        return _FULL_TURN
    first = values.angle("startphi", 0)
    return float(first), float(first + width)


@dataclass(eq=False)
class RevolvedProfile:
    """Builds a profile revolved about the axis through a shift that is parallel to z; `cache` has one of each height.

    The shift in z is added to the profile in fractions; the shift in x and y becomes a translation.
    """

    corners: ProfileCorners
    angles: AngleRange
    cache: dict[tuple[int, int], Revolution] = field(default_factory=dict)

    def __call__(self, shift: Point) -> Solid:
        x, y, z = shift
        key = z.as_integer_ratio()
        solid = self.cache.get(key)
        if solid is None:
            # One rounding for each height: faces of two solids at the same height in the world get the same float
            solid = Revolution(tuple((float(r), float(height + z)) for r, height in self.corners), *self.angles)
            if len(self.cache) < MOST_HELD:
                self.cache[key] = solid
        # A copy: a template marks its solids
        return solid.translate((float(x), float(y), 0.0)) if x or y else solid._with_motion(IDENTITY_MOTION)


def tube(values: GdmlValues) -> SolidFactory:
    """<tube>: rmin, rmax, full length z, startphi, deltaphi."""
    inner, outer, half = values.radius("rmin"), values.positive("rmax"), values.positive("z") / 2
    _check_radii(values, inner, outer)
    return RevolvedProfile([(inner, -half), (outer, -half), (outer, half), (inner, half)], read_angles(values))


def _check_radii(values: GdmlValues, inner: Fraction, outer: Fraction) -> None:
    if inner >= outer:
        raise GdmlError(values.element, f"rmin must be < rmax = {float(outer):g} mm, got {float(inner):g} mm")


def cut_tube(values: GdmlValues) -> SolidFactory:
    """<cutTube>: a tube between planes through (0, 0, -z/2) and (0, 0, z/2) with given outward normals."""
    inner, outer, half = values.radius("rmin"), values.positive("rmax"), values.positive("z") / 2
    _check_radii(values, inner, outer)
    low, high = ([values.number(f"{name}{axis}") for axis in "XYZ"] for name in ("low", "high"))
    # G4CutTubs demands outward normals
    if low[2] >= 0 or high[2] <= 0:
        raise GdmlError(values.element, "lowZ must be < 0 and highZ > 0: normals point outward")
    # A plane rises by at most `slope` times the distance from the axis.
    slope = max(max(abs(n[0]), abs(n[1])) / abs(n[2]) for n in (low, high))
    # Beyond the cutting planes everywhere within the outer radius, so that they alone bound the tube.
    end = half + 2 * outer * slope + half
    corners = [(inner, -end), (outer, -end), (outer, end), (inner, end)]
    return partial(_cut_profile, RevolvedProfile(corners, read_angles(values)), ((low, -half), (high, half)))


def _cut_profile(profile: RevolvedProfile, planes: Sequence[tuple[list[Fraction], Fraction]], shift: Point) -> Solid:
    """Return a revolved profile cut by planes (outward normal, height at which the plane meets the axis)."""
    x, y, z = shift
    sides = []
    for (a, b, c), height in planes:
        sides.append(HalfSpace((float(a), float(b), float(c)), float(a * x + b * y + c * (z + height))))
    return Intersection((profile(shift), *sides))


def cone(values: GdmlValues) -> SolidFactory:
    """<cone>: rmin1 and rmax1 at the lower end, rmin2 and rmax2 at the upper end, full length z."""
    half = values.positive("z") / 2
    r1, r2, r3, r4 = (values.radius(name) for name in ("rmin1", "rmax1", "rmin2", "rmax2"))
    # Equal radii at one end are allowed, where the wall of the cone ends in an edge
    if r1 > r2 or r3 > r4 or r1 + r3 >= r2 + r4:
        raise GdmlError(values.element, "rmin1 and rmin2 must be less than rmax1 and rmax2")
    return RevolvedProfile([(r1, -half), (r2, -half), (r4, half), (r3, half)], read_angles(values))


def orb(values: GdmlValues) -> SolidFactory:
    """<orb>: a ball of radius r."""
    radius = float(values.positive("r"))
    return partial(_ball, radius)


def _ball(radius: float, shift: Point) -> Sphere:
    return Sphere(radius, _floats(shift))


def sphere(values: GdmlValues) -> SolidFactory:
    """<sphere>: a shell from rmin to rmax, limited to a range of azimuths and a range of polar angles."""
    inner, outer = values.radius("rmin"), values.positive("rmax")
    _check_radii(values, inner, outer)
    angles = read_angles(values)
    low = values.angle("starttheta", 0)
    # Angles in radians with few digits may end a little beyond π
    high = min(low + values.angle("deltatheta", 180), Fraction(180))
    if low < 0 or high <= low:
        found = f"got {float(low):g} to {float(high):g}"
        raise GdmlError(
            values.element, f"starttheta and deltatheta must leave a range within 0 and 180 degrees, {found}"
        )
    is_whole = low == 0 and high == 180 and angles == _FULL_TURN
    sector = None if is_whole else RevolvedProfile(_sector(low, high, 4 * outer), angles)
    return partial(_shell, float(inner), float(outer), sector)


def _shell(inner: float, outer: float, sector: RevolvedProfile | None, shift: Point) -> Solid:
    """Return the shell between two balls, within a sector revolved about z."""
    whole: Solid = _ball(outer, shift)
    if sector is not None:
        whole = Intersection((whole, sector((_ZERO, _ZERO, _ZERO)).translate(_floats(shift))))
    return Difference((whole, _ball(inner, shift))) if inner else whole


def _sector(low: Fraction, high: Fraction, reach: Fraction) -> ProfileCorners:
    """Return the profile (r, z) of a range of polar angles, with corners at the distance `reach`.

    `reach` is four times the radius of the ball that it cuts: chords of 45 degrees at most stay outside that ball.
    """
    corners = [(_ZERO, _ZERO)]
    for k in range(5):
        s, c = sin_cos_degrees(float(low + (high - low) * k / 4))
        corners.append((Fraction(float(reach) * max(s, 0.0)), Fraction(float(reach) * c)))
    return corners


def ellipsoid(values: GdmlValues) -> SolidFactory:
    """<ellipsoid>: semi-axes ax, by, cz, cut at the heights zcut1 and zcut2; both 0 mean no cut."""
    a, b, c = (values.positive(name) for name in ("ax", "by", "cz"))
    low, high = values.length("zcut1", 0), values.length("zcut2", 0)
    # Both 0 is the default of Geant4: a whole ellipsoid
    if low == high == 0:
        low, high = -c, c
    if low >= min(high, c) or high <= -c:
        raise GdmlError(
            values.element,
            f"zcut1 must be < zcut2, and leave a part of the ellipsoid, got {float(low):g} and {float(high):g} mm",
        )
    radii = float(a), float(b), float(c)
    # No cut: a slab that touches the poles would add two faces without area
    if low <= -c and high >= c:
        return partial(_ellipsoid, radii)
    return partial(_cut_ellipsoid, radii, low, high, c, 2 * max(a, b, c))


def _ellipsoid(radii: tuple[float, float, float], shift: Point) -> Ellipsoid:
    return Ellipsoid(radii, _floats(shift))


def _cut_ellipsoid(
    radii: tuple[float, float, float], low: Fraction, high: Fraction, end: Fraction, beyond: Fraction, shift: Point
) -> Solid:
    return Intersection((_ellipsoid(radii, shift), slab(low, high, end, beyond, shift)))


def slab(low: Fraction, high: Fraction, end: Fraction, beyond: Fraction, shift: Point) -> Box:
    """Return the box between two heights that contains |x|, |y| <= beyond.

    A height at or beyond ±`end` cuts nothing; the face is moved out to ±2 `end`, away from the surface it would touch.
    """
    x, y, z = shift
    bottom, top = (low if low > -end else -2 * end), (high if high < end else 2 * end)
    corner = float(x - beyond), float(y - beyond), float(z + bottom)
    return Box(corner, (float(x + beyond), float(y + beyond), float(z + top)))


def elliptic_tube(values: GdmlValues) -> SolidFactory:
    """<eltube>: semi-axes dx and dy, half length dz."""
    a, b, half = (values.positive(name) for name in ("dx", "dy", "dz"))
    return _stretch_profile([(_ZERO, -half), (Fraction(1), -half), (Fraction(1), half), (_ZERO, half)], a, b)


def elliptic_cone(values: GdmlValues) -> SolidFactory:
    """<elcone>: (x / dx)² + (y / dy)² <= (zmax - z)², |z| <= zcut."""
    a, b = values.number("dx"), values.number("dy")
    top, cut = values.positive("zmax"), values.positive("zcut")
    if a <= 0 or b <= 0:
        raise GdmlError(values.element, f"dx and dy must be > 0, got {float(a):g} and {float(b):g}")
    cut = min(cut, top)  # beyond the apex at zmax there is nothing
    return _stretch_profile([(_ZERO, -cut), (top + cut, -cut), (top - cut, cut), (_ZERO, cut)], a, b)


def _stretch_profile(corners: ProfileCorners, a: Fraction, b: Fraction) -> SolidFactory:
    """Return the factory of a revolved profile, scaled by a along x and by b along y."""
    return partial(_elliptic, RevolvedProfile(corners, _FULL_TURN), (float(a), float(b), 1.0))


def _elliptic(profile: RevolvedProfile, factors: tuple[float, float, float], shift: Point) -> Solid:
    x, y, z = shift
    # Scaling follows the shift in z, which it keeps, and precedes the shift in x and y, which it would scale.
    whole = profile((_ZERO, _ZERO, z)).scale(factors)
    return whole.translate((float(x), float(y), 0.0)) if x or y else whole


def paraboloid(values: GdmlValues) -> SolidFactory:
    """<paraboloid>: radii rlo at -dz and rhi at dz, with r² linear in z."""
    low, high, half = values.radius("rlo"), values.positive("rhi"), values.positive("dz")
    _check_radii(values, low, high)
    slope = (high * high - low * low) / (2 * half)
    return partial(_conic, (high * high + low * low) / 2, slope, half, 2 * high)


def _conic(square: Fraction, slope: Fraction, half: Fraction, beyond: Fraction, shift: Point) -> Solid:
    """Return x² + y² <= square + slope z for |z| <= half."""
    within = slab(-half, half, 2 * half, beyond, shift)
    return Intersection((quadric_about_z(square, slope, _ZERO, shift), within))


def quadric_about_z(square: Fraction, slope: Fraction, bend: Fraction, shift: Point) -> Solid:
    """Return x² + y² <= square + slope z + bend z², for use near z = 0: a cylinder is cut at a distance.

    The cylinder (no slope, no bend) is a solid of revolution of length 4 sqrt(square) about z = 0.
    """
    x, y, z = shift
    # A general quadric without zz and z is an endless cylinder, which has no box
    if not slope and not bend:
        beyond = 2 * Fraction(math.sqrt(square))
        return RevolvedProfile([(_ZERO, -beyond), (beyond, -beyond), (beyond, beyond)], _FULL_TURN)(shift)
    # With z' = z - shift: expand square + slope z' + bend z'² in fractions and round each coefficient once.
    constant = slope * z - bend * z * z - square
    coefficients = {"xx": 1.0, "yy": 1.0, "zz": float(-bend), "z": float(2 * bend * z - slope)}
    solid = Quadric(coefficients=coefficients | {"constant": float(constant)})
    return solid.translate((float(x), float(y), 0.0)) if x or y else solid


def hyperboloid(values: GdmlValues) -> SolidFactory:
    """<hype>: r² <= rmax² + tan²(outst) z² and r² >= rmin² + tan²(inst) z², full length z."""
    inner, outer, half = values.radius("rmin"), values.positive("rmax"), values.positive("z") / 2
    _check_radii(values, inner, outer)
    bends = []
    for name in ("inst", "outst"):
        s, c = sin_cos_degrees(float(values.angle(name, 0)))
        if abs(c) < 1e-9:
            raise GdmlError(values.element, f"{name} must not be 90 degrees")
        bends.append((Fraction(s) / Fraction(c)) ** 2)
    # Squares of radii at the ends
    reach = outer * outer + bends[1] * half * half
    if inner * inner + bends[0] * half * half >= reach:
        raise GdmlError(values.element, "inst must leave the inner surface within the outer")
    return partial(_waists, (inner, bends[0]), (outer, bends[1]), half, 2 * Fraction(math.sqrt(reach)))


def _waists(
    inner: tuple[Fraction, Fraction], outer: tuple[Fraction, Fraction], half: Fraction, beyond: Fraction, shift: Point
) -> Solid:
    """Return the solid between two hyperboloids or cylinders (waist radius, bend), |z| <= half."""
    # The slab cuts the ends; both surfaces reach beyond it, so that no faces of theirs coincide with it.
    whole = Intersection((slab(-half, half, 2 * half, beyond, shift), _waist(*outer, half, shift)))
    return Difference((whole, _waist(*inner, half, shift))) if any(inner) else whole


def _waist(radius: Fraction, bend: Fraction, half: Fraction, shift: Point) -> Solid:
    """Return a hyperboloid, or a cylinder that reaches beyond |z| = half."""
    if bend:
        return quadric_about_z(radius * radius, _ZERO, bend, shift)
    corners = [(_ZERO, -2 * half), (radius, -2 * half), (radius, 2 * half), (_ZERO, 2 * half)]
    return RevolvedProfile(corners, _FULL_TURN)(shift)


def _floats(point: Point) -> tuple[float, float, float]:
    x, y, z = map(float, point)
    return x, y, z
