"""Closed forms of primitives: moments and areas in their own frames, and moved to the world.

`own_moments` and `own_area` dispatch on the class of the shape and return None for classes without a closed form: a new
closed form is one registered function.
"""

from __future__ import annotations

import itertools
import math
from collections.abc import Iterable, Iterator, Sequence
from functools import singledispatch
from typing import Any, NamedTuple

import numpy as np

from ..._util.arrays import FloatArray
from ..._util.records import dataclass
from ...geometry.bounds.support import real_roots
from ...geometry.primitives import Box, Cone, Cylinder, Sphere, Tube
from ...geometry.prismatoids import (
    BetweenRectangles,
    Parallelepiped,
    Pyramid,
    RegularPrism,
    RegularSides,
    Trapezoid,
    Wedge,
)
from ...geometry.quadrics import Ellipsoid, EllipticSolid
from ...geometry.revolution import Polycone, Revolution, SphereSection, profile_rings
from ...geometry.shape import Shape
from ...geometry.sheets import CylinderPatch, Disc, Triangle
from ...numerics.portable_math import sin_cos_degrees

_NODES, _WEIGHTS = math.sqrt(0.6) * np.array([-1, 0, 1]), np.array([5, 8, 5]) / 9
"""Gauss's rule, exact up to degree 5; sums over odd functions are 0 to the bit."""
_SIMILAR = 1e-14
"""A map keeps angles if its Gram matrix differs from a multiple of 1 by at most this share."""


@dataclass(frozen=True)
class Moments:
    """Volume, centroid c (3,), and the mean (3, 3) of (x - c)(x - c)ᵀ over the volume.

    The mean, a square of lengths, stays within float64 for more sizes than the integral, a fifth power.
    """

    volume: float
    centroid: FloatArray
    spread: FloatArray

    @property
    def second(self) -> FloatArray:
        """Second moments (3, 3) about the centroid: ∫ (x - c)(x - c)ᵀ dV."""
        return self.volume * self.spread

    def moved(self, matrix: FloatArray) -> Moments:
        """Return the moments after an affine map by a (4, 4) matrix."""
        linear, factor = matrix[:3, :3], abs(float(np.linalg.det(matrix[:3, :3])))
        spread: FloatArray = linear @ self.spread @ linear.T
        return Moments(self.volume * factor, linear @ self.centroid + matrix[:3, 3], (spread + spread.T) / 2)


def closed_moments(shape: Shape) -> Moments | None:
    """Return the moments of a shape in the world; None without a closed form."""
    try:
        own = own_moments(shape)
    except OverflowError:  # squares of a needle's widths
        return None
    return None if own is None else own.moved(shape.under().matrix)


def closed_area(shape: Shape) -> float | None:
    """Return the area of a shape in the world; None without a closed form."""
    linear = shape.under().matrix[:3, :3]
    # Boxes, triangles and discs have areas under any map, others under maps that keep angles
    if isinstance(shape, Box):
        x, y, z = (linear * np.subtract(shape.high, shape.low)).T
        return 2 * (_parallelogram(x, y) + _parallelogram(y, z) + _parallelogram(z, x))
    if isinstance(shape, Triangle):
        a, b, c = (np.array(p) for p in (shape.a, shape.b, shape.c))
        return _parallelogram(linear @ (b - a), linear @ (c - a)) / 2
    if isinstance(shape, Disc):
        return math.pi * _parallelogram(shape.radius * linear[:, 0], shape.radius * linear[:, 1])
    factor = similarity(linear)
    if factor is None and (isinstance(shape, Sphere) or (isinstance(shape, Ellipsoid) and shape.z_range is None)):
        radii = shape.radius if isinstance(shape, Sphere) else shape.radii
        return own_area(Ellipsoid(np.linalg.svd(linear * radii, compute_uv=False)))
    own = own_area(shape)
    return None if own is None or factor is None else own * factor * factor


def _parallelogram(a: FloatArray, b: FloatArray) -> float:
    """Return the area of the parallelogram of two vectors."""
    return float(np.linalg.norm(np.cross(a, b)))


def similarity(linear: FloatArray) -> float | None:
    """Return the factor of a linear map that keeps angles, up to the rounding of its matrix; None for others."""
    gram = linear @ linear.T
    square = float(np.trace(gram)) / 3
    return math.sqrt(square) if abs(gram - square * np.eye(3)).max() <= _SIMILAR * square else None


@singledispatch
def own_moments(shape: Any) -> Moments | None:
    """Return the moments in the shape's own frame; None without a closed form."""
    return None


@singledispatch
def own_area(shape: Any) -> float | None:
    """Return the area in the shape's own frame, to be scaled by maps that keep angles; None without a closed form."""
    return None


@own_moments.register
def _(box: Box) -> Moments:
    # Halved before the sum, which may overflow
    edges, middle = np.subtract(box.high, box.low), np.array(box.low) / 2 + np.array(box.high) / 2
    volume = float(np.prod(edges))
    return Moments(volume, middle, np.diag(edges**2 / 12))


@own_moments.register
def _(sphere: Sphere) -> Moments:
    volume = 4 / 3 * math.pi * sphere.radius**3
    return Moments(volume, np.zeros(3), sphere.radius**2 / 5 * np.eye(3))


@own_area.register
def _(sphere: Sphere) -> float:
    return 4 * math.pi * sphere.radius**2


@own_moments.register
def _(solid: EllipticSolid) -> Moments:
    (sx, sy), (g0, g1, g2) = solid.squares, (float(g) for g in solid.profile)
    return _sections(float(sx), float(sy), (g0, g1, g2), solid.heights)


@own_area.register
def _(patch: CylinderPatch) -> float:
    return math.radians(patch.end_angle - patch.start_angle) * patch.radius * patch.length


def _sections(sx: float, sy: float, profile: tuple[float, float, float], heights: tuple[float, float]) -> Moments:
    """Return the moments of sx x² + sy y² <= g(z) = g0 + g1 z + g2 z², low <= z <= high, by Gauss's rule (exact here).

    The section at z is an ellipse with area π g / √(sx sy), ∫ x² = area g / (4 sx), ∫ y² = area g / (4 sy).
    """
    # The integrands g, g z, g z² and g² have at most degree 4
    parts = list(_parts(profile, heights))
    z = np.array([a / 2 + b / 2 + (b / 2 - a / 2) * _NODES for a, b in parts])
    weight = np.array([(b / 2 - a / 2) * _WEIGHTS for a, b in parts])
    g = np.maximum(np.polynomial.polynomial.polyval(z, profile), 0.0)
    area = math.pi / math.sqrt(sx * sy) * g * weight
    volume = float(area.sum())
    if volume == 0:
        return Moments(0.0, np.full(3, np.nan), np.zeros((3, 3)))
    return _stack_moments(area.ravel(), 0.0, 0.0, z.ravel(), g.ravel() / (4 * sx), g.ravel() / (4 * sy))


def _parts(profile: tuple[float, float, float], heights: tuple[float, float]) -> Iterator[tuple[float, float]]:
    """Yield the parts of [low, high] where g > 0: the profile may vanish within the heights."""
    g0, g1, g2 = profile
    low, high = heights
    cuts = sorted({low, high, *(root for root in real_roots(g2, g1, g0) if low < root < high)}) if low < high else []
    for a, b in itertools.pairwise(cuts):
        middle = a / 2 + b / 2
        if g0 + middle * (g1 + middle * g2) > 0:
            yield a, b


_MOST_NODES = 1 << 14
_SERIES = [2 / ((2 * k + 1) * (2 * k + 3)) for k in range(16)]


@own_area.register
def _(solid: EllipticSolid) -> float | None:
    """The caps, and the curved surface, whose element is √(g (a² sin² φ + b² cos² φ) + (a b g'/2)²) dφ dz.

    The midpoint rule for the angle φ of an ellipse converges like a power of its number of nodes, by symmetry over a
    quarter of a turn; a circle needs one. Very flat ones have no closed form here. Along z see `_root_integral`.
    """
    a, b = (1 / math.sqrt(s) for s in solid.squares)
    g0, g1, g2 = (float(g) for g in solid.profile)
    parts = list(_parts((g0, g1, g2), solid.heights))
    if not parts:
        return 0.0
    z = np.array(parts).T
    g = np.maximum(g0 + z * (g1 + z * g2), 0.0)
    caps, rise = math.pi * a * b * float(g[0, 0] + g[1, -1]), (a * b * (g1 / 2 + g2 * z)) ** 2
    count, before = 1 if a == b else 8, math.inf
    while count <= _MOST_NODES:
        angle = (np.arange(count)[:, None] + 0.5) * (math.pi / 2 / count)
        across = (a * np.sin(angle)) ** 2 + (b * np.cos(angle)) ** 2
        ends = np.sqrt(across * g[:, None] + rise[:, None])
        lengths = _root_integral(ends[0], ends[1], z[1] - z[0], g2 * (across + (a * b) ** 2 * g2))
        sides = 2 * math.pi * float(lengths.sum()) / count
        if count == 1 or abs(sides - before) <= 2.0**-50 * sides:
            return sides + caps
        count, before = 2 * count, sides
    return None


def _root_integral(low: FloatArray, high: FloatArray, length: FloatArray, square: FloatArray) -> FloatArray:
    """Return ∫ √q over intervals, from √q at both ends, the lengths and the factors of z² in the quadratics q.

    With s = √q_low + √q_high, u = square length² / s² and v = (√q_high - √q_low)² / s² it is
    length s (2 + (v - u) w) / 4, where w = Σ 2 uᵏ / ((2k + 1) (2k + 3)) = (1 - (1 - u) artanh(√u) / √u) / u.
    No terms cancel.
    """
    total = low + high
    u, v = square * (length / total) ** 2, ((high - low) / total) ** 2
    root = np.sqrt(np.abs(u))
    ratio = np.where(u > 0, np.arctanh(np.minimum(root, 1 - 2.0**-53)), np.arctan(root)) / root
    w = np.where(np.abs(u) < 0.1, np.polynomial.polynomial.polyval(u, _SERIES), (1 - (1 - u) * ratio) / u)
    return np.asarray(length * total / 4 * (2 + (v - u) * w))


# Closed forms of trapezoids, wedges, regular prisms, pyramids and parallelepipeds.


@own_moments.register(Trapezoid)
@own_moments.register(Wedge)
def _(solid: BetweenRectangles) -> Moments:
    """At each height a rectangle whose ends are linear in z."""
    # The ends of each rectangle are linear between those of the solid
    share = (1 + _NODES) / 2
    ends = _ends(solid)
    low, high = (float(z) for z in solid.heights)
    (x, wide), (y, deep) = (_middle_and_size(*(a + (b - a) * share for a, b in ends[i])) for i in (0, 1))
    z, weight = low + (high - low) * share, (high - low) / 2 * _WEIGHTS * wide * deep
    return _stack_moments(weight, x, y, z, wide**2 / 12, deep**2 / 12)


def _ends(solid: BetweenRectangles) -> list[list[tuple[float, float]]]:
    """Return for x and for y: (at the lower end, at the upper end) of the low side, and of the high side."""
    one, other = solid.rectangles()
    return [
        [(float(a), float(b)) for a, b in zip(low, high, strict=True)]
        for low, high in ((one.x, other.x), (one.y, other.y))
    ]


def _middle_and_size(low: FloatArray, high: FloatArray) -> tuple[FloatArray, FloatArray]:
    """Return the middles and the lengths of intervals."""
    return (low + high) / 2, high - low


def _stack_moments(
    weight: FloatArray, x: Any, y: Any, z: FloatArray, across_x: FloatArray, across_y: FloatArray
) -> Moments:
    """Return the moments of sections about (x, y) at nodes z with weights of volume.

    `across_x` and `across_y` are the means of the squares about there; that of the product is 0.
    """
    volume = float(weight.sum())
    share = weight / volume
    middles = np.array([x + 0 * z, y + 0 * z, z])
    # About a middle: what is symmetric has its centroid there, to the bit
    middle = middles[:, :1] / 2 + middles[:, -1:] / 2
    mean = middle[:, 0] + ((middles - middle) * share).sum(axis=1)
    from_mean = middles - mean[:, None]
    spread = (from_mean * share) @ from_mean.T + np.diag([share @ across_x, share @ across_y, 0.0])
    return Moments(volume, mean, spread)


@own_area.register(Trapezoid)
@own_area.register(Wedge)
def _(solid: BetweenRectangles) -> float:
    (x0, x1), (y0, y1) = _ends(solid)
    rise = float(solid.heights[1]) - float(solid.heights[0])
    wide, deep = ([b - a for a, b in zip(low, high, strict=True)] for low, high in ((x0, x1), (y0, y1)))
    area = wide[0] * deep[0] + wide[1] * deep[1]
    area += sum((deep[0] + deep[1]) / 2 * math.hypot(rise, end[1] - end[0]) for end in (x0, x1))
    return area + sum((wide[0] + wide[1]) / 2 * math.hypot(rise, end[1] - end[0]) for end in (y0, y1))


@own_moments.register(RegularPrism)
@own_moments.register(Pyramid)
def _(solid: RegularSides) -> Moments:
    """A regular polygon with corners at R has the area n R² sin(2π/n) / 2; x² has the mean R² (2 + cos(2π/n)) / 12."""
    angle = 2 * math.pi / solid.sides
    low, high = solid.z_range
    z, radius = (
        low + (high - low) * (1 + _NODES) / 2,
        _at_corners(solid) @ [(1 - _NODES) / 2, (1 + _NODES) / 2],
    )
    weight = (high - low) / 2 * _WEIGHTS * solid.sides / 2 * radius**2 * math.sin(angle)
    across = radius**2 * (2 + math.cos(angle)) / 12
    return _stack_moments(weight, 0.0, 0.0, z, across, across)


@own_area.register(RegularPrism)
@own_area.register(Pyramid)
def _(solid: RegularSides) -> float:
    below, above = _at_corners(solid).tolist()
    half = math.pi / solid.sides
    # Height of a side: from the middle of its lower edge to that of its upper edge
    slant = math.hypot(solid.z_range[1] - solid.z_range[0], (above - below) * math.cos(half))
    ends = (below**2 + above**2) * math.sin(2 * half) / 2
    return float(solid.sides * ((below + above) * math.sin(half) * slant + ends))


def _at_corners(solid: RegularSides) -> FloatArray:
    """Return the radii (2,) of the circles through the corners of both ends."""
    factor = 1.0 if solid.radius_to == "corners" else 1 / math.cos(math.pi / solid.sides)
    return factor * np.array(solid.radii)


@own_moments.register
def _(solid: Parallelepiped) -> Moments:
    """The unit cube under the linear map whose columns are the edges."""
    edges = np.array([solid.a, solid.b, solid.c]).T
    middle = np.array(solid.corner) + edges.sum(axis=1) / 2
    return Moments(abs(float(np.linalg.det(edges))), middle, edges @ edges.T / 12)


@own_area.register
def _(solid: Parallelepiped) -> float:
    a, b, c = (np.array(edge) for edge in (solid.a, solid.b, solid.c))
    return 2 * sum(float(np.linalg.norm(np.cross(u, v))) for u, v in ((a, b), (b, c), (c, a)))


# Closed forms of solids of revolution about z, also of parts of a turn: cylinders, cones, tubes, and so on.
#
# Integrals over the profile, (r, z), times those of 1, cos φ, sin φ and their products over the azimuth.


class Ring(NamedTuple):
    """The profile between two heights, from an inner radius to an outer one, each (at low, at high) and linear in z."""

    low: float
    high: float
    inner: tuple[float, float]
    outer: tuple[float, float]


class Azimuth(NamedTuple):
    """Integrals over the azimuth of 1, cos, sin, cos², cos sin, sin²."""

    one: float
    cos: float
    sin: float
    cos2: float
    mixed: float
    sin2: float
    is_full: bool


def azimuth(start: float, end: float) -> Azimuth:
    """Return the integrals from one angle to another, in degrees; those that cancel over a full turn are exactly 0."""
    turn = math.radians(end - start)
    if end - start == 360:
        return Azimuth(turn, 0.0, 0.0, turn / 2, 0.0, turn / 2, True)
    (s, c), (t, d) = sin_cos_degrees(start), sin_cos_degrees(end)
    double, mixed = (t * d - s * c) / 2, (t * t - s * s) / 2
    return Azimuth(turn, t - s, c - d, turn / 2 + double, mixed, turn / 2 - double, False)


def ring_moments(profile: Iterable[float], about: Azimuth) -> Moments:
    """Return the moments from the integrals of r, r z, r z², r², r² z, r³ over the profile."""
    r, rz, rzz, rr, rrz, rrr = profile
    volume = about.one * r
    if volume == 0:
        return Moments(0.0, np.full(3, np.nan), np.zeros((3, 3)))
    mean = np.array([about.cos * rr, about.sin * rr, about.one * rz]) / volume
    xx, xy, yy, zz = about.cos2 * rrr, about.mixed * rrr, about.sin2 * rrr, about.one * rzz
    xz, yz = about.cos * rrz, about.sin * rrz
    spread = np.array([[xx, xy, xz], [xy, yy, yz], [xz, yz, zz]]) / volume - np.outer(mean, mean)
    return Moments(volume, mean, spread)


def ring_sums(rings: Iterable[Ring]) -> FloatArray:
    """Return the integrals (6,) of r, r z, r z², r², r² z, r³ over the profile, by Gauss's rule: exact here."""
    total = np.zeros(6)
    for low, high, inner, outer in rings:
        half = (high - low) / 2
        z, weight, share = low + half + half * _NODES, half * _WEIGHTS, (1 + _NODES) / 2
        a, b = (ends[0] + (ends[1] - ends[0]) * share for ends in (inner, outer))
        wide = weight * (b - a)  # a factor of its own: b² - a² of a thin wall would cancel
        one, two, three = wide * (a + b) / 2, wide * (a * a + a * b + b * b) / 3, wide * (a + b) * (a * a + b * b) / 4
        total += [x.sum() for x in (one, one * z, one * z**2, two, two * z, three)]
    return total


def ring_area(rings: Sequence[Ring], about: Azimuth) -> float:
    """Return the area of a stack of rings; rings that touch are one solid."""
    sides = sum(
        (ends[0] + ends[1]) / 2 * math.hypot(ends[1] - ends[0], ring.high - ring.low)
        for ring in rings
        for ends in (ring.inner, ring.outer)
    )
    below: dict[float, list[tuple[float, float]]] = {}
    above: dict[float, list[tuple[float, float]]] = {}
    for ring in rings:
        above.setdefault(ring.low, []).append((ring.inner[0], ring.outer[0]))
        below.setdefault(ring.high, []).append((ring.inner[1], ring.outer[1]))
    # Between two rings, the parts of a level that only one of them covers are surface
    levels = sum(_exclusive_area(below.get(z, []), above.get(z, [])) for z in {*below, *above})
    # A part of a turn has two flat sides
    walls = 0.0 if about.is_full else 2 * sum(_profile_area(ring) for ring in rings)
    return float(about.one * (sides + levels) + walls)


def _profile_area(ring: Ring) -> float:
    """Return the area of a ring's profile."""
    return (ring.high - ring.low) * (ring.outer[0] - ring.inner[0] + ring.outer[1] - ring.inner[1]) / 2


def _exclusive_area(one: list[tuple[float, float]], other: list[tuple[float, float]]) -> float:
    """Return ∫ r dr over the radii that are in one of two sets of intervals and not in the other."""
    ends = sorted({end for interval in (*one, *other) for end in interval})
    total = 0.0
    for a, b in itertools.pairwise(ends):
        inside = [any(low <= a and b <= high for low, high in intervals) for intervals in (one, other)]
        total += (b - a) * (a + b) / 2 if inside[0] != inside[1] else 0.0
    return total


def _rings(shape: Any) -> list[Ring]:
    """Return the profile of a cylinder, tube, cone, polycone or revolution as rings from bottom to top."""
    if isinstance(shape, Cylinder):
        return [Ring(0.0, shape.length, (0.0, 0.0), (shape.radius, shape.radius))]
    if isinstance(shape, Tube):
        inner, outer = shape.inner_radius, shape.outer_radius
        return [Ring(0.0, shape.length, (inner, inner), (outer, outer))]
    if isinstance(shape, Cone):
        return [Ring(0.0, shape.length, (0.0, 0.0), (shape.start_radius, shape.end_radius))]
    if isinstance(shape, Polycone):
        return [Ring(a[0], b[0], (a[1], b[1]), (a[2], b[2])) for _, a, b in shape.stretches]
    return [Ring(*ring) for ring in profile_rings(shape.profile)]


@own_moments.register(Cylinder)
@own_moments.register(Tube)
@own_moments.register(Polycone)
@own_moments.register(Revolution)
@own_moments.register(Cone)
def _(shape: Any) -> Moments:
    rings = _rings(shape)
    # In units of a power of two near the size, whose fifth power float64 may not hold
    size = 2.0 ** math.frexp(max(abs(x) for low, high, _, outer in rings for x in (low, high, *outer)))[1]
    # About the middle: what is symmetric has its centroid there, to the bit
    middle = rings[0].low / 2 + rings[-1].high / 2
    small = [
        Ring((low - middle) / size, (high - middle) / size, (a / size, b / size), (c / size, d / size))
        for low, high, (a, b), (c, d) in rings
    ]
    found = ring_moments(ring_sums(small), azimuth(shape.start_angle, shape.end_angle))
    return Moments(found.volume * size**3, found.centroid * size + [0.0, 0.0, middle], found.spread * size**2)


@own_area.register(Cylinder)
@own_area.register(Tube)
@own_area.register(Polycone)
@own_area.register(Revolution)
@own_area.register(Cone)
def _(shape: Any) -> float:
    return ring_area(_rings(shape), azimuth(shape.start_angle, shape.end_angle))


@own_moments.register
def _(section: SphereSection) -> Moments:
    """∫ r dr dz and so on in polar coordinates r = ρ sin θ, z = ρ cos θ, with ρ dρ dθ in place of dr dz."""
    (s, c), (t, d) = (sin_cos_degrees(angle) for angle in section.polar)
    theta = math.radians(section.polar[1] - section.polar[0])
    a, b = section.inner_radius, section.radius
    second, third = (b - a) * (a * a + a * b + b * b) / 3, (b - a) * (a + b) * (a * a + b * b) / 4
    fourth = (b - a) * (a**4 + a**3 * b + a * a * b * b + a * b**3 + b**4) / 5
    sine, square = c - d, (theta - (t * d - s * c)) / 2
    profile = (
        second * sine, third * (t * t - s * s) / 2, fourth * (c**3 - d**3) / 3,
        third * square, fourth * (t**3 - s**3) / 3, fourth * (sine - (c**3 - d**3) / 3),
    )  # fmt: skip
    return ring_moments(profile, azimuth(section.start_angle, section.end_angle))


@own_area.register
def _(section: SphereSection) -> float:
    (s, c), (t, d) = (sin_cos_degrees(angle) for angle in section.polar)
    about = azimuth(section.start_angle, section.end_angle)
    a, b = section.inner_radius, section.radius
    annulus = (b - a) * (a + b) / 2
    walls = 0.0 if about.is_full else 2 * annulus * math.radians(section.polar[1] - section.polar[0])
    return about.one * ((a * a + b * b) * (c - d) + annulus * (s + t)) + walls
