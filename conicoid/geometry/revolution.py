"""Solids of revolution about z: `Revolution` of a polygon, `Polycone`, and `SphereSection`.

Their walls are cylinders, cones, planes across the axis, and spheres.
"""

from __future__ import annotations

import functools
import itertools
from collections.abc import Iterator, Sequence
from dataclasses import replace
from fractions import Fraction
from operator import methodcaller
from typing import Any, NamedTuple

from .._util.arrays import Interval, Vector, VectorLike
from .._util.records import dataclass
from .._util.validation import (
    check_angle_range,
    check_degrees,
    check_fields,
    check_interval,
    check_nonnegative,
    check_numbers,
    check_positive,
    check_vector,
    format_value,
)
from ..numerics import bigfloat as ex
from ..numerics.portable_math import hypot, negative_indicator, portable_max, select_if_several, sin_cos_degrees
from .bounds.support import sum_up
from .cell import UV, All, Any_, Cell, Face, Tree, cartesian_uv, cylindrical_uv
from .primitives import arc_support, check_inner_radius, cut_wedge, frustum_side, union_of_walls, wedge_walls
from .shape import PrimitiveSolid
from .sheets import check_outline, check_simple
from .surface import PlaneSurface, QuadricSurface
from .transform import Motion, Translate

OutlineProfile = tuple[tuple[float, float], ...]


class _ProfileEdge(NamedTuple):
    """An edge of the profile: its lower and upper end (r, z), and its number."""

    low: tuple[Any, Any]
    high: tuple[Any, Any]
    number: int

    def radius(self, z: Any) -> Any:
        """Return its distance from the axis at a height."""
        (r, low), (end, high) = self.low, self.high
        if r == end:
            return r
        r, low, end, high = map(ex.rational, (r, low, end, high))
        return r + (end - r) * (ex.rational(z) - low) / (high - low)

    def middle_radius(self, low: Any, high: Any) -> Any:
        """Return its distance from the axis in the middle between two heights."""
        r = self.low[0]
        return r if r == self.high[0] else self.radius((ex.rational(low) + ex.rational(high)) / 2)


class _ProfileRing(NamedTuple):
    """The part of the profile between two heights and between two edges; the inner one is None for the axis."""

    inner: _ProfileEdge | None
    outer: _ProfileEdge
    low: Any
    high: Any


@dataclass(frozen=True)
class Revolution(PrimitiveSolid):
    """A polygon in the half-plane of r and z, turned about the z axis: tubes, frustums and stacks of them.

    `profile` are its corners (r, z), r >= 0, in either sense; it must not cross itself, and may touch the axis. With
    angles only the part whose angle of (x, y) is from `start_angle` to `end_angle`, in degrees, their difference in
    (0, 360].
    Faces: edge i, from corner i to the next, sweeps face i (none, on the axis), then the walls at start_angle and
    end_angle; half a turn has one plane for both. uv: (angle / 360, height from the lower end of the edge to the
    upper in [0, 1]) where it rises, (x, y) / the larger radius where it is level, (distance from the axis, z), in units
    of the largest of each, on the walls.
    Source: the polycones of detector simulation (Geant4, "Book for Application Developers", solids).
    """

    profile: tuple[tuple[float, float], ...]
    start_angle: float = 0.0
    end_angle: float = 360.0

    def __post_init__(self) -> None:
        profile = check_outline("Revolution", "profile", self.profile)
        for k, (r, _) in enumerate(profile):
            if r < 0:
                raise ValueError(f"Revolution: profile[{k}] must have r >= 0, got ({r:g}, {profile[k][1]:g})")
        # A profile that touches itself would have walls inside the solid
        check_simple("Revolution", "profile", profile)
        object.__setattr__(self, "profile", profile)
        check_angle_range(self)

    def tree(self) -> Tree:
        corners, ends = _corners_and_ends(self.profile)
        rising = _rising_edges(ends)
        # Level edges bound no ring from the side; they number its ends
        level = [(*sorted((a[0], b[0])), a[1], k) for k, (a, b) in enumerate(ends) if _equal(a[1], b[1])]
        walls = {edge.number: _edge_face(edge) for edge in rising if edge.low[0] > 0 or edge.high[0] > 0}
        parts = [_ring_tree(ring, walls, level, len(corners) + 2) for ring in split_rings(rising)]
        whole: Tree = parts[0] if len(parts) == 1 else Any_(tuple(parts))
        ends_of_turn = self._walls(len(corners))
        if not ends_of_turn:
            return whole
        is_convex = self.end_angle - self.start_angle <= 180
        wedge: Tree = Cell(ends_of_turn) if is_convex else union_of_walls(ends_of_turn)
        return All((whole, wedge))

    def _walls(self, first: int) -> tuple[Face, ...]:
        """Return the half-planes at the two angles as faces, numbered from `first` on."""
        radius, size = (
            functools.reduce(portable_max, map(abs, numbers)) for numbers in zip(*self.profile, strict=True)
        )
        walls = wedge_walls(self.start_angle, self.end_angle, radius, size or 1.0)
        return tuple(replace(face, number=first + k) for k, face in enumerate(walls))

    def support(self, direction: Vector) -> float:
        across = arc_support(1.0, self.start_angle, self.end_angle, direction)
        if self.end_angle - self.start_angle < 360:
            # Above its rounding, since the bounds must hold all of a wedge
            across += 2.0**-51 * abs(across)
        best = -float("inf")
        for r, z in self.profile:
            best = portable_max(best, sum_up((r * across, z * direction[2])))
        return best


def profile_rings(profile: OutlineProfile) -> Iterator[tuple[float, float, tuple[float, float], tuple[float, float]]]:
    """Yield the rings of an outline: (lower z, upper z, inner radii at both, outer radii at both)."""
    for ring in split_rings(_rising_edges(_corners_and_ends(profile)[1])):
        inner, outer = (
            (float(edge.radius(ring.low)), float(edge.radius(ring.high))) if edge else (0.0, 0.0)
            for edge in (ring.inner, ring.outer)
        )
        yield float(ring.low), float(ring.high), inner, outer


def _corners_and_ends(profile: OutlineProfile) -> tuple[list[Any], list[tuple[Any, Any]]]:
    """Return (the corners without negative zeros, the two corners of each edge)."""
    # Floats are compared as they are, ten times as fast as fractions, which arithmetic takes
    corners = [tuple(x + 0.0 if type(x) is float else ex.rational(x) for x in corner) for corner in profile]
    return corners, list(zip(corners, [*corners[1:], corners[0]], strict=True))


def _rising_edges(ends: Sequence[tuple[Any, Any]]) -> list[_ProfileEdge]:
    return [
        _ProfileEdge(min(a, b, key=_z), max(a, b, key=_z), k) for k, (a, b) in enumerate(ends) if not _equal(a[1], b[1])
    ]


def _z(corner: Any) -> Any:
    return corner[1]


def _equal(a: Any, b: Any) -> bool:
    """Return True if the values are equal. `==` of numbers with derivatives is False if these differ."""
    return bool(a <= b <= a)


def split_rings(edges: Sequence[_ProfileEdge]) -> list[_ProfileRing]:
    """Return the polygon as rings between rising edges.

    The heights of all corners cut it; adjacent rings between the same two edges are joined again.
    """
    heights: list[Any] = []
    for z in sorted(end[1] for edge in edges for end in (edge.low, edge.high)):
        if not heights or heights[-1] < z:
            heights.append(z)
    open_: dict[tuple[int, int], _ProfileRing] = {}
    rings: list[_ProfileRing] = []
    for low, high in itertools.pairwise(heights):
        across = [edge for edge in edges if edge.low[1] <= low and high <= edge.high[1]]
        across.sort(key=methodcaller("middle_radius", low, high))
        current = {}
        # Between the heights of two corners edges do not cross, so they enter and leave the polygon in turn
        for inner, outer in zip(across[::2], across[1::2], strict=True):
            before = open_.get((inner.number, outer.number))
            current[inner.number, outer.number] = _ProfileRing(inner, outer, before.low if before else low, high)
        # Fewer rings are fewer cells to trace: a corner of one wall must not cut all the others
        rings += [ring for key, ring in open_.items() if key not in current]
        open_ = current
    return [*rings, *open_.values()]


def _edge_face(edge: _ProfileEdge) -> Face:
    """Return the face that a rising edge sweeps, inside towards the axis: a cylinder, or a cone (`frustum_side`).

    The cylinder is the unit cylinder, scaled, as those of OpenMC and MCNP are, so that all have the same bits.
    """
    (r0, z0), (r1, z1) = edge.low, edge.high
    uv = cylindrical_uv(ex.rounded(z0), ex.rounded(z1))
    if r0 == r1:
        inverse = 1 / ex.rational(r0)
        rows = ((inverse, 0.0, 0.0), (0.0, inverse, 0.0), (0.0, 0.0, 1.0))
        return Face(QuadricSurface((1.0, 1.0, 0.0), rows=rows), edge.number, uv)
    return Face(frustum_side(*map(ex.rational, (r0, z0, r1, z1))), edge.number, uv)


def _ring_tree(ring: _ProfileRing, walls: dict[int, Face], level: Sequence[Any], inner_number: int) -> Tree:
    """Return a ring as a cell, or as two if it has a bore.

    `inner_number` is the face number of planes between rings, which are no walls.
    """
    ends = []
    for z, inside in ((ring.low, -1), (ring.high, 1)):
        inner, outer = (edge.radius(z) if edge else 0 for edge in (ring.inner, ring.outer))
        number = next((k for a, b, at, k in level if _equal(at, z) and a < outer and inner < b), inner_number)
        radius = ex.rounded(max((b for _, b, at, k in level if k == number), default=Fraction(1)))
        uv = cartesian_uv((radius, 0, 0), (0, radius, 0))
        ends.append(_level_face(z, number, uv, inside))
    outside = walls[ring.outer.number]
    # The cell lists its faces by their numbers
    ends.sort(key=lambda face: face.number)
    body = Cell((outside, *ends))
    if ring.inner is None or ring.inner.number not in walls:
        return body
    # The bore needs the same two ends: without them another edge in line with it would get its face number
    return All((body, Cell((replace(walls[ring.inner.number], inside=-1), *ends))))


def _level_face(z: Any, number: int, uv: UV, inside: int) -> Face:
    """Return the face across the axis at a height, one plane for the ring below it and for the ring above."""
    z = ex.rational(z)
    return Face(PlaneSurface((0.0, 0.0, 1.0), z, (0.0, 0.0, z)), number, uv, inside)


# The polycone

Section = tuple[float, float, float]
_MAX_SECTIONS = 10_000


@dataclass(frozen=True)
class Polycone(PrimitiveSolid):
    """The solid between sections (z, inner radius, outer radius), one above the other, with straight lines between.

    `sections`: two or more, z rising; a height may come twice, for a step. 0 <= inner <= outer, and some volume. Angles
    of (x, y), in degrees, from `start_angle` to `end_angle`, their difference in (0, 360]. Two sections make a hollow
    frustum, or a tube. Inner and outer radii may be equal: rings that touch or lie apart are parts of one solid. A
    profile that goes back on itself in z is for `Revolution`.

    Faces of n sections: k the outer side from section k to the next, n - 1 + k the inner side, 2 (n - 1) + k the level
    face at section k, then the walls at start_angle and end_angle (half a turn has one plane for both). uv:
    (angle / 360, height from section to section in [0, 1]) on the sides, (x, y) / the largest radius on level faces,
    (distance from the axis, z), in units of the largest of each, on the walls.
    Source: the polycone of detector simulation (Geant4, "Book for Application Developers", solids).
    """

    sections: tuple[tuple[float, float, float], ...]
    start_angle: float = 0.0
    end_angle: float = 360.0

    def __post_init__(self) -> None:
        object.__setattr__(self, "sections", _check_sections(self.sections))
        check_angle_range(self)

    @property
    def stretches(self) -> Iterator[tuple[int, Section, Section]]:
        """(number of the lower section, lower section, upper section) for every part with a volume."""
        for k, (low, high) in enumerate(itertools.pairwise(self.sections)):
            if _has_volume(low, high):
                yield k, low, high

    @property
    def widest(self) -> float:
        """The largest radius."""
        widest = 0.0
        for _, _, outer in self.sections:
            widest = portable_max(widest, outer)
        return widest

    def tree(self) -> Tree:
        rings = tuple(self._ring(*stretch) for stretch in self.stretches)
        whole: Tree = rings[0] if len(rings) == 1 else Any_(rings)
        walls = self._walls()
        if not walls:
            return whole
        is_convex = self.end_angle - self.start_angle <= 180
        return All((whole, Cell(walls) if is_convex else union_of_walls(walls)))

    def _ring(self, k: int, low: Section, high: Section) -> Tree:
        """Return the part between two sections as a cell, or as two if it has a bore."""
        sides, count = cylindrical_uv(low[0], high[0]), len(self.sections)
        r0, r1, z0, z1 = (ex.rational(value) for value in (low[2], high[2], low[0], high[0]))
        bottom = self._level(low[0], -1, 2 * (count - 1) + k)
        top = self._level(high[0], 1, 2 * (count - 1) + k + 1)
        body = Cell((Face(frustum_side(r0, z0, r1, z1), k, sides), bottom, top))
        if not (low[1] > 0 or high[1] > 0):
            return body
        bore = frustum_side(ex.rational(low[1]), z0, ex.rational(high[1]), z1)
        # The bore needs the same two ends: without them another bore in line with it would get its face number
        return All((body, Cell((Face(bore, count - 1 + k, sides, inside=-1), bottom, top))))

    def _level(self, z: float, inside: int, number: int) -> Face:
        return _level_face(z, number, cartesian_uv((self.widest, 0, 0), (0, self.widest, 0)), inside)

    def _walls(self) -> tuple[Face, ...]:
        tallest = portable_max(abs(self.sections[0][0]), abs(self.sections[-1][0]))
        walls = wedge_walls(self.start_angle, self.end_angle, self.widest, tallest)
        return tuple(replace(wall, number=3 * len(self.sections) - 5 + wall.number) for wall in walls)

    def support(self, direction: Vector) -> float:
        best = -float("inf")
        for _, low, high in self.stretches:
            for z, inner, outer in (low, high):
                reaches = (arc_support(r, self.start_angle, self.end_angle, direction) for r in (outer, inner))
                best = portable_max(best, sum_up((z * direction[2], portable_max(*reaches))))
        return best


def _has_volume(low: Section, high: Section) -> bool:
    return bool(low[0] < high[0] and (low[1] < low[2] or high[1] < high[2]))


def _check_sections(sections: Any) -> tuple[Section, ...]:
    try:
        rows = list(sections)
    except TypeError:
        expected = "must be two or more of (z, inner radius, outer radius)"
        raise ValueError(f"Polycone: sections {expected}, got {format_value(sections)}") from None
    if not 2 <= len(rows) <= _MAX_SECTIONS:
        raise ValueError(f"Polycone: sections must be from 2 to {_MAX_SECTIONS:,}, got {len(rows):,}")
    checked: list[Section] = []
    for k, row in enumerate(rows):
        z, inner, outer = check_numbers("Polycone", f"sections[{k}]", row, 3)
        if not 0 <= inner <= outer:
            problem = f"0 <= inner radius <= outer radius, got {inner:g} and {outer:g}"
            raise ValueError(f"Polycone: sections[{k}] must have {problem}")
        if checked and z < checked[-1][0]:
            problem = f"must rise in z, got {z:g} above {checked[-1][0]:g}; reverse a list that falls"
            raise ValueError(f"Polycone: sections[{k}] {problem}")
        checked.append((z, inner, outer))
    if any(_has_volume(low, high) for low, high in itertools.pairwise(checked)):
        return tuple(checked)
    raise ValueError("Polycone: sections must enclose a volume: between two heights, inner radius < outer radius")


# The part of a ball or shell

_AT_LOW, _AT_HIGH = 2, 3
_HIDDEN = 6
"""The face number of the plane between the nappes of a cone, which is no wall."""


@dataclass(frozen=True)
class SphereSection(PrimitiveSolid):
    """The part of a ball, or of a shell with an inner radius, in ranges of spherical coordinates, in degrees.

    Own frame: axes of the world about `center`. inner_radius <= r <= radius; the polar angle, 0 at +z and 180 at -z,
    in `polar_range`, within [0, 180]; the azimuth of (x, y), counter-clockwise from +x, from `start_angle` to
    `end_angle`, their difference in (0, 360]. By default all angles count; ``polar_range=(0, 90)`` is a hemisphere.

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
        check_fields(self, radius=check_positive, inner_radius=check_nonnegative)
        check_inner_radius(owner, "radius", self.inner_radius, self.radius)
        found = check_interval(owner, "polar_range", self.polar_range)
        if found is not None:
            low, high = (check_degrees(owner, f"polar_range[{k}]", angle) for k, angle in enumerate(found))
            if low < 0 or high > 180:
                raise ValueError(f"{owner}: polar_range must lie within 0 and 180 degrees, got ({low:g}, {high:g})")
            found = low, high
        object.__setattr__(self, "polar_range", found)
        check_angle_range(self)
        check_fields(self, center=check_vector)

    @property
    def polar(self) -> Interval:
        """The range of the polar angle, (0, 180) by default."""
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
            if not (angle < 90 or angle > 90):  # not `==`, which also compares derivatives (see `_equal`)
                faces.append(Face(_polar_face(-sense), number, cartesian_uv((self.radius, 0, 0), (0, self.radius, 0))))
            elif 0 < angle < 180:
                more.append(self._nappe(angle, number, sense))
        walls = wedge_walls(self.start_angle, self.end_angle, self.radius, self.radius)
        numbered = tuple(replace(wall, number=wall.number + 1) for wall in walls)
        return cut_wedge(tuple(faces), numbered, self.end_angle - self.start_angle, *more)

    def _ball(self, radius: float, number: int) -> Face:
        surface = QuadricSurface(squares=(1.0, 1.0, 1.0), constant=ex.rational(radius) ** 2)
        return Face(surface, number, cylindrical_uv(-radius, radius))

    @property
    def has_one_cone(self) -> bool:
        """True if both polar angles belong to one cone with two nappes: if they add up to 180."""
        low, high = (ex.rational(angle) for angle in self.polar)
        return bool(low > 0) and not (low + high < 180 or low + high > 180)

    def _outside_of_both_nappes(self) -> Cell:
        s, c = ex.sin_cos_degrees(self.polar[0])
        end = self.radius * sin_cos_degrees(self.polar[0])[1]
        cone = QuadricSurface((c * c, c * c, -(s * s)), constant=0.0)
        return Cell((Face(cone, _AT_LOW, cylindrical_uv(-end, end), inside=-1),))

    def _nappe(self, angle: float, number: int, sense: int) -> Tree:
        """Return polar angles up to an angle (sense 1), or from it on (-1): the inside or outside of one nappe."""
        s, c = ex.sin_cos_degrees(angle)
        cone = QuadricSurface((c * c, c * c, -(s * s)), constant=0.0)
        above, uv = 1 if angle < 90 else -1, self._cone_uv(angle)  # the side of the nappe; one map for each number
        if sense == above:
            return Cell((Face(cone, number, uv), Face(_polar_face(-above), _HIDDEN)))
        return Any_((Cell((Face(cone, number, uv, inside=-1),)), Cell((Face(_polar_face(above), _HIDDEN),))))

    def _cone_uv(self, angle: float) -> UV:
        _, c = sin_cos_degrees(angle)
        near, far = self.inner_radius * c, self.radius * c
        return cylindrical_uv(near, far) if angle < 90 else cylindrical_uv(far, near)

    def support(self, direction: Vector) -> float:
        """Return the maximum of ρ (u_z cos θ + w sin θ); w is the support of the arc of azimuths in the direction u."""
        w, uz = arc_support(1.0, self.start_angle, self.end_angle, direction), direction[2]
        ends = [sin_cos_degrees(angle) for angle in self.polar]
        (s, c), (t, d) = ends
        radii = (self.radius, self.inner_radius)
        reaches = [sum_up((r * cosine * uz, r * sine * w)) for r in radii for sine, cosine in ends]
        best = reaches[0]
        for reach in reaches[1:]:
            best = portable_max(best, reach)
        # No test, so that one recording serves all directions
        beyond = negative_indicator(w) + negative_indicator(w * c - uz * s) + negative_indicator(uz * t - w * d)
        return select_if_several(2.0 * beyond, best, portable_max(best, self.radius * hypot(w, uz)))


def _polar_face(sense: int) -> PlaneSurface:
    """Return the half-space z <= 0 (sense 1) or z >= 0 (-1)."""
    return PlaneSurface((0.0, 0.0, float(sense)), 0.0)
