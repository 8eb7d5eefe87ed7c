"""Convex solids of flat faces from their corners, and what encloses them in fractions."""

from __future__ import annotations

import itertools
from collections import Counter
from collections.abc import Sequence
from fractions import Fraction
from functools import partial
from math import lcm

import numpy as np

from ...geometry.csg import Difference, Intersection, Union
from ...geometry.general_quadric import Quadric
from ...geometry.mesh import Mesh
from ...geometry.polyhedron import Polyhedron
from ...geometry.primitives import Box
from ...geometry.shape import Solid
from ...numerics.portable_math import sin_cos_degrees
from ..openmc.placement import Point, shift_point
from ..xml_tree import XmlElement
from .round_solids import quadric_about_z, slab
from .solid_template import SolidFactory
from .values import MAX_CONVEX_FACES, GdmlError, GdmlUnsupported, GdmlValues, look_up, read_reference

_FLATNESS = Fraction(1, 100_000)
"""How far a corner may be off the plane of its face, as a share of the size."""
FacePlane = tuple[Point, Fraction]


class NonPlanarFace(GdmlUnsupported):
    """A face is not flat."""


def cross(a: Point, b: Point) -> Point:
    """The vector product."""
    return a[1] * b[2] - a[2] * b[1], a[2] * b[0] - a[0] * b[2], a[0] * b[1] - a[1] * b[0]


def dot(a: Point, b: Point) -> Fraction:
    """The scalar product."""
    return a[0] * b[0] + a[1] * b[1] + a[2] * b[2]


def subtract(a: Point, b: Point) -> Point:
    """The difference."""
    return a[0] - b[0], a[1] - b[1], a[2] - b[2]


def mean(points: Sequence[Point]) -> Point:
    """The mean of points."""
    x, y, z = (sum((point[i] for point in points), Fraction(0)) / len(points) for i in range(3))
    return x, y, z


def fit_plane(points: Sequence[Point], inside: Point) -> FacePlane | None:
    """The plane of a face, outward; None where its corners enclose nothing. Raises LeftOut where it is not flat."""
    kept = [point for k, point in enumerate(points) if point != points[k - 1]]
    if len(kept) < 3:
        return None
    spokes = [subtract(point, kept[0]) for point in kept[1:]]
    terms = [cross(a, b) for a, b in itertools.pairwise(spokes)]
    normal = tuple(sum((term[i] for term in terms), Fraction(0)) for i in range(3))
    size = max(abs(c) for spoke in spokes for c in spoke)
    largest = max(map(abs, normal))
    if largest <= size * size / 10**12:
        return None
    x, y, z = (c / largest for c in normal)
    outward: Point = (x, y, z)
    center = mean(kept)
    if dot(outward, subtract(center, inside)) < 0:
        outward = (-x, -y, -z)
    if max(abs(dot(outward, subtract(point, center))) for point in kept) > _FLATNESS * size:
        raise NonPlanarFace("a face of it is not flat")
    return _integer_normal(outward), dot(_integer_normal(outward), center)


def _integer_normal(normal: Point) -> Point:
    """The same direction by whole numbers where these are short, so that it needs no rounding."""
    factor = lcm(*(c.denominator for c in normal))
    if factor.bit_length() > 50:
        return normal
    x, y, z = (c * factor for c in normal)
    return x, y, z


def convex_solid(corners: Sequence[Point], faces: Sequence[Sequence[int]]) -> SolidFactory:
    """Inside the planes of faces, given by numbers of corners in any sense."""
    inside = mean(list(dict.fromkeys(corners)))
    found = [fit_plane([corners[k] for k in face], inside) for face in faces]
    planes = list(dict.fromkeys(plane for plane in found if plane is not None))
    size = max(abs(c) for corner in corners for c in subtract(corner, inside))
    for normal, offset in planes:
        if dot(normal, inside) >= offset:
            raise ValueError("it must enclose a volume")
        most = max(dot(normal, corner) for corner in corners)
        if most - offset > 2 * _FLATNESS * size * max(map(abs, normal)):
            raise GdmlUnsupported("it is not convex")
    if len(planes) < 4:
        raise ValueError("it must enclose a volume")
    return polyhedron_factory(planes)


def convex_planes(corners: Sequence[Point], faces: Sequence[Sequence[int]]) -> list[FacePlane] | None:
    """The planes of a closed surface that is convex, exactly, and whose faces are flat; None for any other."""
    edges = Counter((face[k - 1], face[k]) for face in faces for k in range(len(face)))
    if len(faces) < 4 or any(count != 1 or edges[b, a] != 1 for (a, b), count in edges.items()):
        return None
    inside = mean(corners)
    planes: dict[FacePlane, None] = {}
    for face in faces:
        try:
            plane = fit_plane([corners[k] for k in face], inside)
        except GdmlUnsupported:
            return None
        if plane is None or any(dot(plane[0], corners[k]) != plane[1] for k in face):
            return None
        planes[plane] = None
    for normal, offset in planes:
        if dot(normal, inside) >= offset or any(dot(normal, corner) > offset for corner in corners):
            return None
    return list(planes)


def polyhedron_factory(planes: Sequence[FacePlane]) -> SolidFactory:
    """What is inside all of some planes."""
    normals = tuple((float(a), float(b), float(c)) for (a, b, c), _ in planes)
    exact = [(Fraction(a), Fraction(b), Fraction(c)) for a, b, c in normals]
    return partial(_polyhedron, normals, [(normal, offset) for normal, (_, offset) in zip(exact, planes, strict=True)])


def _polyhedron(normals: tuple[tuple[float, float, float], ...], planes: Sequence[FacePlane], shift: Point) -> Solid:
    return Polyhedron(normals, tuple(float(offset + dot(normal, shift)) for normal, offset in planes))


HEXAHEDRON_FACES = ((3, 2, 1, 0), (4, 5, 6, 7), (0, 1, 5, 4), (1, 2, 6, 5), (2, 3, 7, 6), (3, 0, 4, 7))
"""Of eight corners, four around the bottom and four around the top."""


# GDML's solids whose sides are twisted, where these are quadrics: ruled by lines between two planes across z.
#
# A side through the lines from a(z) to b(z), whose ends go evenly with z, is where (b - a) × ((x, y) - a) = 0: at
# each z
# a straight line, and of degree two in x, y and z together, a hyperbolic paraboloid. The sides of a twisted tube are
# the
# same about the axis, y = k x z; its walls are the hyperboloids that lines at both ends sweep. G4TwistedBox,
# G4TwistedTrd
# and G4TwistedTrap turn evenly in angle, so theirs are not: x sin(c z) = y cos(c z) has no such form.

PlanePoint = tuple[Fraction, Fraction]
QuadricTerms = dict[str, Fraction]
"""Of a quadric, <= 0 inside."""
_ZERO, _ONE = Fraction(0), Fraction(1)


def twisted_tubs(values: GdmlValues) -> SolidFactory:
    """twistedangle, endinnerrad and endouterrad at z = ± zlen / 2, phi; or mid radii, negativeEndz and positiveEndz.

    r² from inner² to outer² times 1 + k² z², of radii at z = 0, and angles within ± phi / 2 of atan(k z), where
    k = tan(twistedangle / 2) / the height of the farther end (G4TwistedTubs::SetFields, G4TwistTubsSide::SurfacePoint).
    """
    half = values.length("zlen", 0) / 2
    s, c = (Fraction(part) for part in sin_cos_degrees(float(values.angle("twistedangle") / 2)))
    if c <= Fraction(1, 10**9):
        raise GdmlError(values.element, "twistedangle must be between -180 and 180 degrees")
    if half:
        low, high = -half, half
        inner, outer = (values.radius(name) * c for name in ("endinnerrad", "endouterrad"))
    else:
        low, high = values.length("negativeEndz"), values.length("positiveEndz")
        inner, outer = values.radius("midinnerrad"), values.radius("midouterrad")
    if not low < high or not 0 <= inner < outer:
        raise GdmlError(values.element, "the ends must rise in z, and the inner radius be less than the outer")
    twist = s / c / max(abs(low), abs(high))
    width = _segment_angle(values)
    bend = twist * twist
    reach = outer * (1 + abs(twist) * max(abs(low), abs(high)))
    sides = [] if width >= 360 else [_twisted_side(twist, float(sense * width / 2), sense) for sense in (-1, 1)]
    ends = low, high, high - low + abs(low) + abs(high), 2 * reach
    return partial(_build_twisted_tube, (inner * inner, outer * outer), bend, ends, sides, width <= 180)


def _build_twisted_tube(
    squares: PlanePoint, bend: Fraction, ends: tuple[Fraction, Fraction, Fraction, Fraction], sides: list[QuadricTerms],
    narrow: bool, shift: Point,
) -> Solid:  # fmt: skip
    """Between two radii, given by their squares, of a slab and within both of its sides; within one if it is wide."""
    parts: list[Solid] = [slab(*ends, shift), quadric_about_z(squares[1], _ZERO, squares[1] * bend, shift)]
    walls = [_build_quadric(side, shift) for side in sides]
    parts += walls if narrow or not walls else [Union(tuple(walls))]
    whole = Intersection(tuple(parts))
    return Difference((whole, quadric_about_z(squares[0], _ZERO, squares[0] * bend, shift))) if squares[0] else whole


def _segment_angle(values: GdmlValues) -> Fraction:
    """The angle of a segment in degrees."""
    count = values.integer("nseg", 0)
    width = values.angle("totphi") / count if count else values.angle("phi", 360)
    if width <= 0:
        raise GdmlError(values.element, "phi must be > 0")
    return width


def _twisted_side(twist: Fraction, degrees: float, sense: int) -> QuadricTerms:
    """sense (y - twist x z) <= 0 in axes that are turned."""
    s, c = (Fraction(part) for part in sin_cos_degrees(degrees))
    return {"x": -sense * s, "y": sense * c, "xz": -sense * twist * c, "yz": -sense * twist * s}


def ruled_solid(low: Sequence[PlanePoint], high: Sequence[PlanePoint], half: Fraction) -> SolidFactory:
    """Between as many corners at -half and at half, all sections convex; sides that are not flat are quadrics.

    Raises LeftOut where a section between the ends is not convex.
    """
    count = len(low)
    middle = [((a[0] + b[0]) / 2, (a[1] + b[1]) / 2) for a, b in zip(low, high, strict=True)]
    if sum((_cross_2d(a, b) for a, b in zip(middle, [*middle[1:], middle[0]], strict=True)), _ZERO) < 0:
        low, high = low[::-1], high[::-1]
    kept = [k for k in range(count) if (low[k], high[k]) != (low[(k + 1) % count], high[(k + 1) % count])]
    edges = [_RuledSide(low[k], high[k], low[(k + 1) % count], high[(k + 1) % count]) for k in kept]
    if len(edges) < 3:
        raise ValueError("it must enclose a volume")
    for first, second in zip(edges, [*edges[1:], edges[0]], strict=True):
        if not first.turns_left(second):
            raise GdmlUnsupported("a section of it between its ends is not convex")
    ends: list[FacePlane] = [((_ZERO, _ZERO, -_ONE), half), ((_ZERO, _ZERO, _ONE), half)]
    sides = [plane for edge in edges if (plane := edge.plane(half)) is not None]
    flat = polyhedron_factory([*ends, *sides, *_bounding_planes([*low, *high])])
    return partial(_build_ruled_solid, flat, [edge.terms(half) for edge in edges if edge.plane(half) is None])


def _build_ruled_solid(flat: SolidFactory, curved: list[QuadricTerms], shift: Point) -> Solid:
    return Intersection((flat(shift), *(_build_quadric(terms, shift) for terms in curved)))


def _bounding_planes(corners: Sequence[PlanePoint]) -> list[FacePlane]:
    """Planes a little beyond all corners, as twisted sides alone do not say how far a body reaches."""
    found: list[FacePlane] = []
    for axis in (0, 1):
        least, most = min(corner[axis] for corner in corners), max(corner[axis] for corner in corners)
        beyond = (most - least) / 1024
        across = (_ONE, _ZERO, _ZERO) if axis == 0 else (_ZERO, _ONE, _ZERO)
        found += [(across, most + beyond), ((-across[0], -across[1], _ZERO), beyond - least)]
    return found


class _RuledSide:
    """A side between the ends: from a to b below, from c to d above, all else to its left."""

    def __init__(self, a: PlanePoint, c: PlanePoint, b: PlanePoint, d: PlanePoint) -> None:
        self.begin = (a[0] + c[0]) / 2, (a[1] + c[1]) / 2
        self.drift = (c[0] - a[0]) / 2, (c[1] - a[1]) / 2
        end, its = ((b[0] + d[0]) / 2, (b[1] + d[1]) / 2), ((d[0] - b[0]) / 2, (d[1] - b[1]) / 2)
        self.along = end[0] - self.begin[0], end[1] - self.begin[1]
        self.turning = its[0] - self.drift[0], its[1] - self.drift[1]
        self.low, self.high = (a, b), (c, d)

    def turns_left(self, following: _RuledSide) -> bool:
        """Does the outline bend to the left after this side, or go straight on, at every height?"""
        a = _cross_2d(self.turning, following.turning)
        b = _cross_2d(self.along, following.turning) + _cross_2d(self.turning, following.along)
        c = _cross_2d(self.along, following.along)
        least = min(a + b + c, a - b + c)
        if a > 0 and abs(b) < 2 * a:
            least = min(least, c - b * b / (4 * a))
        return least >= 0

    def plane(self, half: Fraction) -> FacePlane | None:
        """The plane of all four corners; None where there is none."""
        below, above = ((q[0] - p[0], q[1] - p[1]) for p, q in (self.low, self.high))
        if _cross_2d(below, above):
            return None
        along = below if any(below) else above
        p, r = self.low[0], self.high[0]
        n = along[1], -along[0]
        offsets = n[0] * p[0] + n[1] * p[1], n[0] * r[0] + n[1] * r[1]
        size = max(abs(n[0]), abs(n[1]))
        slope = (offsets[1] - offsets[0]) / (2 * half) / size
        return (n[0] / size, n[1] / size, -slope), (offsets[0] + offsets[1]) / 2 / size

    def terms(self, half: Fraction) -> QuadricTerms:
        """-(b - a) × ((x, y) - a), a and b going evenly with z, divided by its largest number."""
        (ax, ay), (mx, my), (px, py), (qx, qy) = self.along, self.turning, self.begin, self.drift
        found = {
            "x": ay, "y": -ax, "xz": my / half, "yz": -mx / half,
            "constant": ax * py - ay * px,
            "z": (ax * qy + mx * py - ay * qx - my * px) / half,
            "zz": (mx * qy - my * qx) / half**2,
        }  # fmt: skip
        size = max(map(abs, found.values()))
        return {name: value / size for name, value in found.items()}


def _cross_2d(a: PlanePoint, b: PlanePoint) -> Fraction:
    return a[0] * b[1] - a[1] * b[0]


def _build_quadric(terms: QuadricTerms, shift: Point) -> Solid:
    made = Quadric(coefficients={name: float(value) for name, value in terms.items() if value})
    x, y, z = map(float, shift)
    return made.translate((x, y, z)) if any((x, y, z)) else made


# GDML's solids of flat faces, but for those of outlines and sections.


def box(values: GdmlValues) -> SolidFactory:
    """x, y, z in all."""
    x, y, z = (values.positive(name) / 2 for name in "xyz")
    low, high = (-x, -y, -z), (x, y, z)
    return partial(_box, low, high)


def _box(low: Point, high: Point, shift: Point) -> Box:
    return Box(shift_point(low, shift), shift_point(high, shift))


def exact_tangent(degrees: Fraction) -> Fraction:
    """Exact of 0 and 45 degrees. Raises ValueError at 90."""
    s, c = sin_cos_degrees(float(degrees))
    if abs(c) < 1e-12:
        raise ValueError("an angle must not be 90 degrees")
    return Fraction(1) if s == c else Fraction(s) / Fraction(c)


def trd(values: GdmlValues) -> SolidFactory:
    """x1, y1 at the lower end, x2, y2 at the upper, z, all in all."""
    half = values.positive("z") / 2
    x1, x2, y1, y2 = (values.radius(name) / 2 for name in ("x1", "x2", "y1", "y2"))
    return convex_solid(_frustum((x1, x1, y1), (x2, x2, y2), half), HEXAHEDRON_FACES)


def _frustum(
    low: tuple[Fraction, Fraction, Fraction],
    high: tuple[Fraction, Fraction, Fraction],
    half: Fraction,
    slants: tuple[Fraction, Fraction] = (Fraction(0), Fraction(0)),
    lean: tuple[Fraction, Fraction] = (Fraction(0), Fraction(0)),
) -> list[Point]:
    """Eight corners of two trapezoids across z: half-widths at -y and at y, and half the height in y of each.

    slants: how x grows with y in each; lean: how x and y grow with z.
    """
    found: list[Point] = []
    for (below, above, y), z, slant in ((low, -half, slants[0]), (high, half, slants[1])):
        a, b = lean[0] * z, lean[1] * z
        found += [
            (a - slant * y - below, b - y, z), (a - slant * y + below, b - y, z),
            (a + slant * y + above, b + y, z), (a + slant * y - above, b + y, z),
        ]  # fmt: skip
    return found


def trap(values: GdmlValues) -> SolidFactory:
    """The general trapezoid of Geant4: z, theta, phi, y1, x1, x2, alpha1, y2, x3, x4, alpha2, lengths in all."""
    half = values.positive("z") / 2
    y1, x1, x2, y2, x3, x4 = (values.radius(name) / 2 for name in ("y1", "x1", "x2", "y2", "x3", "x4"))
    slants = exact_tangent(values.angle("alpha1", 0)), exact_tangent(values.angle("alpha2", 0))
    return _hexahedron(_frustum((x1, x2, y1), (x3, x4, y2), half, slants, read_lean(values)), half)


def _hexahedron(corners: list[Point], half: Fraction) -> SolidFactory:
    """Between four corners at -half and four at half; sides that are not flat are quadrics."""
    try:
        return convex_solid(corners, HEXAHEDRON_FACES)
    except NonPlanarFace:
        low, high = ([(x, y) for x, y, _ in some] for some in (corners[:4], corners[4:]))
        return ruled_solid(low, high, half)


def read_lean(values: GdmlValues) -> tuple[Fraction, Fraction]:
    """How x and y grow with z, by theta and phi."""
    slope = exact_tangent(values.angle("theta", 0))
    s, c = sin_cos_degrees(float(values.angle("phi", 0)))
    return slope * Fraction(c), slope * Fraction(s)


def para(values: GdmlValues) -> SolidFactory:
    """A parallelepiped: x, y, z in all, alpha, theta, phi."""
    x, y, half = (values.positive(name) / 2 for name in "xyz")
    slant = exact_tangent(values.angle("alpha", 0))
    return convex_solid(_frustum((x, x, y), (x, x, y), half, (slant, slant), read_lean(values)), HEXAHEDRON_FACES)


def tet(values: GdmlValues) -> SolidFactory:
    """Four corners, named positions."""
    corners = [_position(values, values.element, f"vertex{k}") for k in range(1, 5)]
    a, b, c = (subtract(corner, corners[0]) for corner in corners[1:])
    if not dot(cross(a, b), c):
        raise GdmlError(values.element, "vertex1 to vertex4 must not lie in a plane")
    return convex_solid(corners, ((0, 1, 2), (0, 1, 3), (0, 2, 3), (1, 2, 3)))


def _position(values: GdmlValues, element: XmlElement, attribute: str) -> Point:
    reading = values.reading
    table = reading.vectors.setdefault("position", {})
    found: Point = look_up(reading, table, read_reference(reading, element, attribute), element, "position")
    return found


def arb8(values: GdmlValues) -> SolidFactory:
    """v1x, v1y to v8x, v8y: four corners at -dz, four at dz."""
    half = values.positive("dz")
    corners: list[Point] = []
    for k in range(8):
        corners.append((values.length(f"v{k + 1}x"), values.length(f"v{k + 1}y"), half if k > 3 else -half))
    return _hexahedron(corners, half)


def tessellated(values: GdmlValues) -> SolidFactory:
    """Triangles and quadrangles that close."""
    places: dict[Point, int] = {}
    faces = []
    for element in values.element.children:
        count = {"triangular": 3, "quadrangular": 4}.get(element.tag)
        if count is None:
            continue
        corners = [_position(values, element, f"vertex{k}") for k in range(1, count + 1)]
        if element.attributes.get("type", "ABSOLUTE") == "RELATIVE":
            x, y, z = corners[0]
            corners[1:] = [(a + x, b + y, c + z) for a, b, c in corners[1:]]
        face = tuple(dict.fromkeys(places.setdefault(corner, len(places)) for corner in corners))
        if len(face) > 2:
            faces.append(face)
    convex_ones = _is_convex_mesh(list(places), faces)
    planes = convex_planes(list(places), faces) if convex_ones else None
    if planes is not None:
        return polyhedron_factory(planes)
    values.reading.spend(len(faces), convex_ones)
    return closed_mesh(list(places), faces)


def _is_convex_mesh(vertices: list[Point], faces: list[tuple[int, ...]]) -> bool:
    """Are all corners on one side of each face, about?"""
    if len(faces) > MAX_CONVEX_FACES or not faces:
        return False
    points = np.array([tuple(map(float, vertex)) for vertex in vertices])
    a, b, c = (points[[face[k] for face in faces]] for k in range(3))
    normals = np.cross(b - a, c - a)
    loose = 1e-9 * np.abs(normals).sum(axis=1) * max(float(np.ptp(points, axis=0).max()), 1e-300)
    for normal, corner, slack in zip(normals, a, loose, strict=True):
        heights = (points - corner) @ normal
        if heights.max() > slack and heights.min() < -slack:
            return False
    return True


def closed_mesh(vertices: list[Point], faces: list[tuple[int, ...]]) -> SolidFactory:
    """A closed surface, its faces all in one sense. LeftOut where it is none."""
    volume = Fraction(0)
    for face in faces:
        for k in range(2, len(face)):
            a, b, c = vertices[face[0]], vertices[face[k - 1]], vertices[face[k]]
            volume += dot(cross(a, b), c)
    if volume < 0:
        faces = [face[::-1] for face in faces]
    return partial(_mesh, vertices, tuple(faces))


def _mesh(vertices: list[Point], faces: tuple[tuple[int, ...], ...], shift: Point) -> Mesh:
    x, y, z = shift
    points = tuple((float(a + x), float(b + y), float(c + z)) for a, b, c in vertices)
    try:
        return Mesh(points, faces)
    except ValueError as error:
        raise GdmlUnsupported(f"its faces are no closed surface: {error}") from None
