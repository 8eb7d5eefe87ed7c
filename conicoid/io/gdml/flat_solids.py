"""GDML solids of flat and ruled faces, from their corners, in fractions.

First the geometry of planes and convex polyhedra, then solids with ruled sides (twisted tubes, twisted trapezoids),
then the readers of boxes, trapezoids, parallelepipeds, tetrahedra, arb8 and tessellated solids. Each reader returns a
`SolidFactory`, which builds the solid translated by a shift. Lengths are in mm, angles in degrees. Wrong attributes
raise GdmlError or ValueError; solids that cannot be built from quadrics raise OmittedPart.
"""

from __future__ import annotations

import itertools
from collections import Counter
from collections.abc import Sequence
from fractions import Fraction
from functools import partial
from math import gcd

import numpy as np

from ...geometry.bounds.linear_program import integer_row
from ...geometry.general_quadric import Quadric
from ...geometry.polyhedron import Mesh, Polyhedron
from ...geometry.primitives import Box
from ...geometry.shape import Difference, Intersection, Solid, Union
from ...numerics.portable_math import sin_cos_degrees
from ...numerics.rational import cross, dot3 as dot, minus
from ..importers import OmittedPart
from ..openmc.placement import Point, shift_point
from ..xml_tree import XmlElement
from .round_solids import quadric_about_z, slab
from .solid_template import SolidFactory
from .values import MAX_CONVEX_FACES, GdmlError, GdmlValues, look_up, read_reference

_FLATNESS = 100_000
"""The size of a face divided by the largest distance of a corner from its plane."""
FacePlane = tuple[Point, Fraction]
"""(outward normal, offset): normal·p <= offset inside."""


class NonPlanarFace(OmittedPart):
    """Raised for a face that is not flat."""


WholePoint = tuple[int, int, int]
WholePlane = tuple[WholePoint, int]
"""`FacePlane` of points in whole numbers, without a common divisor: sums of integers are quicker than of fractions."""


def _whole_points(points: Sequence[Point]) -> tuple[list[WholePoint], WholePoint, int]:
    """Return points and their mean in whole numbers, and the number that they were multiplied by."""
    count = len(points)
    *whole, unit = (count * c for c in integer_row((*itertools.chain(*points), 1)))
    x, y, z = whole[::3], whole[1::3], whole[2::3]
    return list(zip(x, y, z, strict=True)), (sum(x) // count, sum(y) // count, sum(z) // count), unit


def fit_plane(points: Sequence[WholePoint], inside: WholePoint) -> WholePlane | None:
    """Return the plane of a face, with its normal away from `inside`; None if the face has no area.

    Raise NonPlanarFace if a corner is farther from the plane than `_FLATNESS` allows.
    """
    corners = [point for k, point in enumerate(points) if point != points[k - 1]]
    if len(corners) < 3:
        return None
    spokes = [minus(point, corners[0]) for point in corners[1:]]
    # The sum of the cross products of a fan is twice the vector area, whatever the shape of the polygon.
    nx, ny, nz = map(sum, zip(*(cross(a, b) for a, b in itertools.pairwise(spokes)), strict=True))
    size = max(abs(c) for spoke in spokes for c in spoke)
    largest = max(abs(nx), abs(ny), abs(nz))
    # Corners on a line, up to the digits of the file; such a face bounds nothing
    if 10**12 * largest <= size * size:
        return None
    # The plane goes through the mean of the corners
    normal, count = (nx, ny, nz), len(corners)
    heights = [dot(normal, point) for point in corners]
    offset = sum(heights)
    # Files hold some six digits, so corners of a flat face leave its plane by about a millionth of its size
    if _FLATNESS * max(abs(count * height - offset) for height in heights) > count * largest * size:
        raise NonPlanarFace("a face of it is not flat")
    divisor = gcd(count * nx, count * ny, count * nz, offset)
    divisor = -divisor if offset < count * dot(normal, inside) else divisor
    return (count * nx // divisor, count * ny // divisor, count * nz // divisor), offset // divisor


def _face_plane(plane: WholePlane, unit: int) -> FacePlane:
    """Return a plane of points that were multiplied by `unit`."""
    normal, offset = plane
    divisor = gcd(*normal)
    largest = max(map(abs, normal))
    # A normal in whole numbers if these are short, so that floats hold it without rounding: they have 53 bits
    if (largest // divisor).bit_length() > 50:
        divisor = largest
    x, y, z = (Fraction(c, divisor) for c in normal)
    return (x, y, z), Fraction(offset, divisor * unit)


def convex_solid(corners: Sequence[Point], faces: Sequence[Sequence[int]]) -> SolidFactory:
    """Return the factory of the convex solid bounded by faces.

    Parameters
    ----------
    corners
        Points in mm.
    faces
        For each face the indices of its corners, in either sense.

    Raises
    ------
    ValueError
        The solid has no volume.
    OmittedPart
        The solid is not convex, or a face is not flat.

    """
    number = {corner: k for k, corner in enumerate(dict.fromkeys(corners))}
    points, inside, unit = _whole_points(list(number))
    fitted = [fit_plane([points[number[corners[k]]] for k in face], inside) for face in faces]
    # Two triangles of one flat face give one plane
    planes = list(dict.fromkeys(plane for plane in fitted if plane is not None))
    size = max(abs(c) for point in points for c in minus(point, inside))
    for normal, offset in planes:
        if dot(normal, inside) >= offset:
            raise ValueError("it must enclose a volume")
        most = max(dot(normal, point) for point in points)
        # Corners that rounding puts before a face by less than the tolerance of flatness do not make a solid concave
        if _FLATNESS * (most - offset) > 2 * size * max(map(abs, normal)):
            raise OmittedPart("it is not convex")
    if len(planes) < 4:
        raise ValueError("it must enclose a volume")
    return polyhedron_factory([_face_plane(plane, unit) for plane in planes])


def convex_planes(corners: Sequence[Point], faces: Sequence[Sequence[int]]) -> list[FacePlane] | None:
    """Return the planes of a closed, exactly convex surface with exactly flat faces; None for any other surface."""
    # Closed and oriented: every directed edge occurs once, and once in the other direction.
    edges = Counter((face[k - 1], face[k]) for face in faces for k in range(len(face)))
    if len(faces) < 4 or any(count != 1 or edges[b, a] != 1 for (a, b), count in edges.items()):
        return None
    points, inside, unit = _whole_points(corners)
    planes: dict[WholePlane, None] = {}
    for face in faces:
        try:
            plane = fit_plane([points[k] for k in face], inside)
        except OmittedPart:
            return None
        # Exact here: a mesh whose faces are only nearly flat keeps its triangles, which are what the file describes
        if plane is None or any(dot(plane[0], points[k]) != plane[1] for k in face):
            return None
        planes[plane] = None
    for normal, offset in planes:
        if dot(normal, inside) >= offset or any(dot(normal, point) > offset for point in points):
            return None
    return [_face_plane(plane, unit) for plane in planes]


def polyhedron_factory(planes: Sequence[FacePlane]) -> SolidFactory:
    """Return the factory of the polyhedron inside all planes."""
    normals = tuple((float(a), float(b), float(c)) for (a, b, c), _ in planes)
    # The shift of a plane is computed from the rounded normal, which the solid has, so that only the sum is rounded.
    rows = [integer_row((*normal, offset, 1)) for normal, (_, offset) in zip(normals, planes, strict=True)]
    return partial(_polyhedron, normals, rows)


def _polyhedron(normals: tuple[tuple[float, float, float], ...], rows: Sequence[Sequence[int]], shift: Point) -> Solid:
    """Return a polyhedron, translated; rows: normals and offsets of its planes times an integer, and the integer."""
    x, y, z, w = integer_row((*shift, 1))
    return Polyhedron(normals, tuple((d * w + a * x + b * y + c * z) / (unit * w) for a, b, c, d, unit in rows))


HEXAHEDRON_FACES = ((3, 2, 1, 0), (4, 5, 6, 7), (0, 1, 5, 4), (1, 2, 6, 5), (2, 3, 7, 6), (3, 0, 4, 7))
"""Corner indices of the faces of a hexahedron: corners 0 to 3 go around the bottom, 4 to 7 around the top."""


# Solids with ruled sides, which are quadrics: at each z the side is a straight line between two points.
#
# If the points a(z) and b(z) are linear in z, the side is (b - a) × ((x, y) - a) = 0. This is a straight line at each z
# and of degree two in x, y and z together: a hyperbolic paraboloid. The sides of a twisted tube are the same about the
# axis, y = k x z; its walls are the hyperboloids that lines between both ends sweep. G4TwistedBox, G4TwistedTrd and
# G4TwistedTrap turn evenly in angle: their sides x sin(c z) = y cos(c z) are no quadrics, so these are not supported.

PlanePoint = tuple[Fraction, Fraction]
"""(x, y)."""
QuadricTerms = dict[str, Fraction]
"""Coefficients of a quadric by monomial, <= 0 inside."""
_ZERO, _ONE = Fraction(0), Fraction(1)


def twisted_tubs(values: GdmlValues) -> SolidFactory:
    """<twistedtubs>: a tube whose sides are twisted by `twistedangle` from end to end.

    Radii are `endinnerrad` and `endouterrad` at z = ±zlen / 2, or `midinnerrad` and `midouterrad` at z = 0 with ends
    at `negativeEndz` and `positiveEndz`. With the radii at z = 0, the solid is inner² (1 + k² z²) <= r² <=
    outer² (1 + k² z²) and azimuths within ±phi / 2 of atan(k z), where k = tan(twistedangle / 2) / |z of the farther
    end|. Source: G4TwistedTubs::SetFields, G4TwistTubsSide::SurfacePoint.
    """
    half = values.length("zlen", 0) / 2
    s, c = (Fraction(part) for part in sin_cos_degrees(float(values.angle("twistedangle") / 2)))
    # At 180 degrees the waist has no radius
    if c <= Fraction(1, 10**9):
        raise GdmlError(values.element, "twistedangle must be between -180 and 180 degrees")
    if half:
        low, high = -half, half
        # A line at the distance r from the axis at the end passes at r cos(half the twist) in the middle
        inner, outer = (values.radius(name) * c for name in ("endinnerrad", "endouterrad"))
    else:
        low, high = values.length("negativeEndz"), values.length("positiveEndz")
        inner, outer = values.radius("midinnerrad"), values.radius("midouterrad")
    if not low < high or not 0 <= inner < outer:
        raise GdmlError(values.element, "the ends must rise in z, and the inner radius be less than the outer")
    twist = s / c / max(abs(low), abs(high))
    width = _segment_angle(values)
    bend = twist * twist
    # Above sqrt(1 + k² z²) times the waist, without a root
    reach = outer * (1 + abs(twist) * max(abs(low), abs(high)))
    # Two sides at one azimuth would cut a whole tube
    sides = [] if width >= 360 else [_twisted_side(twist, float(sense * width / 2), sense) for sense in (-1, 1)]
    ends = low, high, high - low + abs(low) + abs(high), 2 * reach
    return partial(_build_twisted_tube, (inner * inner, outer * outer), bend, ends, sides, width <= 180)


def _build_twisted_tube(
    squares: PlanePoint, bend: Fraction, ends: tuple[Fraction, Fraction, Fraction, Fraction], sides: list[QuadricTerms],
    narrow: bool, shift: Point,
) -> Solid:  # fmt: skip
    """Return the part of a slab between two hyperboloids (`squares` of their waists) and between two sides.

    A tube of more than 180 degrees (not `narrow`) is the union of the half spaces of its sides, not the intersection.
    """
    parts: list[Solid] = [slab(*ends, shift), quadric_about_z(squares[1], _ZERO, squares[1] * bend, shift)]
    walls = [_build_quadric(side, shift) for side in sides]
    parts += walls if narrow or not walls else [Union(tuple(walls))]
    whole = Intersection(tuple(parts))
    return Difference((whole, quadric_about_z(squares[0], _ZERO, squares[0] * bend, shift))) if squares[0] else whole


def _segment_angle(values: GdmlValues) -> Fraction:
    """Return the angle of a segment in degrees: totphi / nseg, or phi."""
    count = values.integer("nseg", 0)
    width = values.angle("totphi") / count if count else values.angle("phi", 360)
    if width <= 0:
        raise GdmlError(values.element, "phi must be > 0")
    return width


def _twisted_side(twist: Fraction, degrees: float, sense: int) -> QuadricTerms:
    """Return the terms of sense (y - twist x z) <= 0, rotated about z by `degrees`."""
    s, c = (Fraction(part) for part in sin_cos_degrees(degrees))
    return {"x": -sense * s, "y": sense * c, "xz": -sense * twist * c, "yz": -sense * twist * s}


def ruled_solid(low: Sequence[PlanePoint], high: Sequence[PlanePoint], half: Fraction) -> SolidFactory:
    """Return the factory of the solid between polygons at z = -half and z = half, joined by straight lines.

    Parameters
    ----------
    low, high
        Corners (x, y) in mm at the lower and the upper end, as many at both. Sides that are not flat become quadrics.
    half
        Half the length in mm.

    Raises
    ------
    ValueError
        The solid has no volume.
    OmittedPart
        A section between the ends is not convex.

    """
    count = len(low)
    middle = [((a[0] + b[0]) / 2, (a[1] + b[1]) / 2) for a, b in zip(low, high, strict=True)]
    # Counter-clockwise, so that the solid lies to the left of each side.
    # At half height, because an end may be a point or a line
    if sum((_cross_2d(a, b) for a, b in zip(middle, [*middle[1:], middle[0]], strict=True)), _ZERO) < 0:
        low, high = low[::-1], high[::-1]
    # Arb8 writes a triangle as a quadrangle with two equal corners
    distinct = [k for k in range(count) if (low[k], high[k]) != (low[(k + 1) % count], high[(k + 1) % count])]
    edges = [_RuledSide(low[k], high[k], low[(k + 1) % count], high[(k + 1) % count]) for k in distinct]
    if len(edges) < 3:
        raise ValueError("it must enclose a volume")
    for first, second in zip(edges, [*edges[1:], edges[0]], strict=True):
        if not first.turns_left(second):
            raise OmittedPart("a section of it between its ends is not convex")
    ends: list[FacePlane] = [((_ZERO, _ZERO, -_ONE), half), ((_ZERO, _ZERO, _ONE), half)]
    sides = [plane for edge in edges if (plane := edge.plane(half)) is not None]
    flat = polyhedron_factory([*ends, *sides, *_bounding_planes([*low, *high])])
    return partial(_build_ruled_solid, flat, [edge.terms(half) for edge in edges if edge.plane(half) is None])


def _build_ruled_solid(flat: SolidFactory, curved: list[QuadricTerms], shift: Point) -> Solid:
    return Intersection((flat(shift), *(_build_quadric(terms, shift) for terms in curved)))


def _bounding_planes(corners: Sequence[PlanePoint]) -> list[FacePlane]:
    """Return planes in x and y a little beyond all corners: ruled sides alone do not bound a body."""
    planes: list[FacePlane] = []
    for axis in (0, 1):
        least, most = min(corner[axis] for corner in corners), max(corner[axis] for corner in corners)
        # A little beyond, so that no plane touches a corner of the solid; a power of two keeps the fraction short
        beyond = (most - least) / 1024
        across = (_ONE, _ZERO, _ZERO) if axis == 0 else (_ZERO, _ONE, _ZERO)
        planes += [(across, most + beyond), ((-across[0], -across[1], _ZERO), beyond - least)]
    return planes


class _RuledSide:
    """A ruled side from a to b at the lower end and from c to d at the upper end; the solid lies to its left.

    With u = z / half, the side goes from begin + u drift in the direction along + u turning.
    """

    def __init__(self, a: PlanePoint, c: PlanePoint, b: PlanePoint, d: PlanePoint) -> None:
        self.begin = (a[0] + c[0]) / 2, (a[1] + c[1]) / 2
        self.drift = (c[0] - a[0]) / 2, (c[1] - a[1]) / 2
        end, end_drift = ((b[0] + d[0]) / 2, (b[1] + d[1]) / 2), ((d[0] - b[0]) / 2, (d[1] - b[1]) / 2)
        self.along = end[0] - self.begin[0], end[1] - self.begin[1]
        self.turning = end_drift[0] - self.drift[0], end_drift[1] - self.drift[1]
        self.low, self.high = (a, b), (c, d)

    def turns_left(self, following: _RuledSide) -> bool:
        """Return True if the outline bends to the left after this side, or goes straight on, at every height."""
        # The cross product of both directions is a u² + b u + c: its least value for u in [-1, 1] must be >= 0.
        a = _cross_2d(self.turning, following.turning)
        b = _cross_2d(self.along, following.turning) + _cross_2d(self.turning, following.along)
        c = _cross_2d(self.along, following.along)
        least = min(a + b + c, a - b + c)
        # The parabola has its lowest point between the ends
        if a > 0 and abs(b) < 2 * a:
            least = min(least, c - b * b / (4 * a))
        return least >= 0

    def plane(self, half: Fraction) -> FacePlane | None:
        """Return the plane through all four corners; None if the side is twisted."""
        below, above = ((q[0] - p[0], q[1] - p[1]) for p, q in (self.low, self.high))
        if _cross_2d(below, above):
            return None
        # An end of the side may be a single point
        along = below if any(below) else above
        p, r = self.low[0], self.high[0]
        n = along[1], -along[0]
        offsets = n[0] * p[0] + n[1] * p[1], n[0] * r[0] + n[1] * r[1]
        size = max(abs(n[0]), abs(n[1]))
        slope = (offsets[1] - offsets[0]) / (2 * half) / size
        return (n[0] / size, n[1] / size, -slope), (offsets[0] + offsets[1]) / 2 / size

    def terms(self, half: Fraction) -> QuadricTerms:
        """Return -(b - a) × ((x, y) - a) with a and b linear in z, divided by its largest coefficient."""
        (ax, ay), (mx, my), (px, py), (qx, qy) = self.along, self.turning, self.begin, self.drift
        terms = {
            "x": ay, "y": -ax, "xz": my / half, "yz": -mx / half,
            "constant": ax * py - ay * px,
            "z": (ax * qy + mx * py - ay * qx - my * px) / half,
            "zz": (mx * qy - my * qx) / half**2,
        }  # fmt: skip
        # Sizes near 1 keep the discriminant of the quadric far from overflow, whatever the unit of the file
        size = max(map(abs, terms.values()))
        return {name: value / size for name, value in terms.items()}


def _cross_2d(a: PlanePoint, b: PlanePoint) -> Fraction:
    return a[0] * b[1] - a[1] * b[0]


def _build_quadric(terms: QuadricTerms, shift: Point) -> Solid:
    solid = Quadric(coefficients={name: float(value) for name, value in terms.items() if value})
    x, y, z = map(float, shift)
    return solid.translate((x, y, z)) if any((x, y, z)) else solid


# Readers of solids with flat faces; solids.py has those of outlines and sections.


def box(values: GdmlValues) -> SolidFactory:
    """<box>: full lengths x, y, z."""
    x, y, z = (values.positive(name) / 2 for name in "xyz")
    low, high = (-x, -y, -z), (x, y, z)
    return partial(_box, low, high)


def _box(low: Point, high: Point, shift: Point) -> Box:
    return Box(shift_point(low, shift), shift_point(high, shift))


def exact_tangent(degrees: Fraction) -> Fraction:
    """Return the tangent of an angle, exact at 0 and 45 degrees. Raise ValueError at 90 degrees."""
    s, c = sin_cos_degrees(float(degrees))
    if abs(c) < 1e-12:
        raise ValueError("an angle must not be 90 degrees")
    return Fraction(1) if s == c else Fraction(s) / Fraction(c)


def trd(values: GdmlValues) -> SolidFactory:
    """<trd>: full lengths x1, y1 at the lower end, x2, y2 at the upper end, and z."""
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
    """Return the eight corners of a solid between two trapezoids at z = -half and z = half.

    `low` and `high` hold half widths at -y and at y, and half the height in y; `slants` is dx/dy of the middle line in
    each trapezoid; `lean` is dx/dz and dy/dz of the axis.
    """
    corners: list[Point] = []
    for (below, above, y), z, slant in ((low, -half, slants[0]), (high, half, slants[1])):
        a, b = lean[0] * z, lean[1] * z
        corners += [
            (a - slant * y - below, b - y, z), (a - slant * y + below, b - y, z),
            (a + slant * y + above, b + y, z), (a + slant * y - above, b + y, z),
        ]  # fmt: skip
    return corners


def trap(values: GdmlValues) -> SolidFactory:
    """<trap>: Geant4's general trapezoid; full lengths z, y1, x1, x2, y2, x3, x4 and theta, phi, alpha1, alpha2."""
    half = values.positive("z") / 2
    y1, x1, x2, y2, x3, x4 = (values.radius(name) / 2 for name in ("y1", "x1", "x2", "y2", "x3", "x4"))
    slants = exact_tangent(values.angle("alpha1", 0)), exact_tangent(values.angle("alpha2", 0))
    return _hexahedron(_frustum((x1, x2, y1), (x3, x4, y2), half, slants, read_lean(values)), half)


def _hexahedron(corners: list[Point], half: Fraction) -> SolidFactory:
    """Return the solid between four corners at -half and four at half; sides that are not flat become quadrics."""
    try:
        return convex_solid(corners, HEXAHEDRON_FACES)
    except NonPlanarFace:
        low, high = ([(x, y) for x, y, _ in some] for some in (corners[:4], corners[4:]))
        return ruled_solid(low, high, half)


def read_lean(values: GdmlValues) -> tuple[Fraction, Fraction]:
    """Return dx/dz and dy/dz of the axis, from the attributes theta and phi."""
    slope = exact_tangent(values.angle("theta", 0))
    s, c = sin_cos_degrees(float(values.angle("phi", 0)))
    return slope * Fraction(c), slope * Fraction(s)


def para(values: GdmlValues) -> SolidFactory:
    """<para>: a parallelepiped of full lengths x, y, z and alpha, theta, phi."""
    x, y, half = (values.positive(name) / 2 for name in "xyz")
    slant = exact_tangent(values.angle("alpha", 0))
    return convex_solid(_frustum((x, x, y), (x, x, y), half, (slant, slant), read_lean(values)), HEXAHEDRON_FACES)


def tet(values: GdmlValues) -> SolidFactory:
    """<tet>: four corners vertex1 to vertex4, which name defined positions."""
    # Names, not coordinates: GDML's tet refers to positions of the define section
    corners = [_position(values, values.element, f"vertex{k}") for k in range(1, 5)]
    a, b, c = (minus(corner, corners[0]) for corner in corners[1:])
    if not dot(cross(a, b), c):
        raise GdmlError(values.element, "vertex1 to vertex4 must not lie in a plane")
    return convex_solid(corners, ((0, 1, 2), (0, 1, 3), (0, 2, 3), (1, 2, 3)))


def _position(values: GdmlValues, element: XmlElement, attribute: str) -> Point:
    reading = values.reading
    table = reading.vectors.setdefault("position", {})
    return look_up(reading, table, read_reference(reading, element, attribute), element, "position")


def arb8(values: GdmlValues) -> SolidFactory:
    """<arb8>: v1x, v1y to v8x, v8y, four corners at -dz and four at dz."""
    half = values.positive("dz")
    corners: list[Point] = []
    for k in range(8):
        corners.append((values.length(f"v{k + 1}x"), values.length(f"v{k + 1}y"), half if k > 3 else -half))
    return _hexahedron(corners, half)


def tessellated(values: GdmlValues) -> SolidFactory:
    """<tessellated>: a closed surface of triangular and quadrangular facets."""
    places: dict[Point, int] = {}
    faces = []
    for element in values.element.children:
        count = {"triangular": 3, "quadrangular": 4}.get(element.tag)
        if count is None:
            continue
        corners = [_position(values, element, f"vertex{k}") for k in range(1, count + 1)]
        if element.attributes.get("type", "ABSOLUTE") == "RELATIVE":  # the other corners count from the first
            x, y, z = corners[0]
            corners[1:] = [(a + x, b + y, c + z) for a, b, c in corners[1:]]
        # Corners of equal coordinates are one corner, since programs write each facet with positions of its own
        face = tuple(dict.fromkeys(places.setdefault(corner, len(places)) for corner in corners))
        # Facets that fall into an edge come from rounded exports; they bound nothing
        if len(face) > 2:
            faces.append(face)
    # The quick test in floating point saves the exact one for most concave solids.
    is_convex = _is_convex_mesh(list(places), faces)
    planes = convex_planes(list(places), faces) if is_convex else None
    if planes is not None:
        return polyhedron_factory(planes)
    # Only what becomes a mesh is charged: a polyhedron of planes need not be decomposed
    values.reading.spend(len(faces), is_convex)
    return closed_mesh(list(places), faces)


def _is_convex_mesh(vertices: list[Point], faces: list[tuple[int, ...]]) -> bool:
    """Return True if all corners lie on one side of each face, up to rounding; False for too many faces."""
    if len(faces) > MAX_CONVEX_FACES or not faces:
        return False
    points = np.array([tuple(map(float, vertex)) for vertex in vertices])
    a, b, c = (points[[face[k] for face in faces]] for k in range(3))
    normals = np.cross(b - a, c - a)
    # Loose on purpose: a solid that passes wrongly is decided in fractions after this
    loose = 1e-9 * np.abs(normals).sum(axis=1) * max(float(np.ptp(points, axis=0).max()), 1e-300)
    for normal, corner, slack in zip(normals, a, loose, strict=True):
        heights = (points - corner) @ normal
        if heights.max() > slack and heights.min() < -slack:
            return False
    return True


def closed_mesh(vertices: list[Point], faces: list[tuple[int, ...]]) -> SolidFactory:
    """Return the factory of a closed surface whose faces have one sense; the sense is reversed if it is inward.

    The factory raises OmittedPart if the surface is not closed.
    """
    # Negative where the facets turn clockwise seen from outside
    if signed_volume(vertices, faces) < 0:
        faces = [face[::-1] for face in faces]
    return partial(_mesh, vertices, tuple(faces))


def signed_volume(vertices: Sequence[Point], faces: Sequence[Sequence[int]]) -> Fraction:
    """Return six times the volume in a closed surface, by tetrahedra from the origin: above 0 for outward faces."""
    volume = Fraction(0)
    for face in faces:
        for k in range(2, len(face)):
            a, b, c = vertices[face[0]], vertices[face[k - 1]], vertices[face[k]]
            volume += dot(cross(a, b), c)
    return volume


def _mesh(vertices: list[Point], faces: tuple[tuple[int, ...], ...], shift: Point) -> Mesh:
    x, y, z = shift
    points = tuple((float(a + x), float(b + y), float(c + z)) for a, b, c in vertices)
    try:
        return Mesh(points, faces)
    except ValueError as error:
        raise OmittedPart(f"its faces are no closed surface: {error}") from None
