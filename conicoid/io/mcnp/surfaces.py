"""MCNP's surfaces: mnemonics, surface cards, and macrobodies.

The negative side of an MCNP surface is the intersection of the negative sides of one or more single surfaces: a cone of
one nappe is a cone and a plane, a macrobody has several facets. `SurfaceSheets` numbers these single surfaces and
returns the regions of MCNP's numbers. Functions raise ValueError for wrong numbers. Lengths are in cm.
"""

from __future__ import annotations

import re
from collections.abc import Callable
from dataclasses import field
from fractions import Fraction

from ..._util.records import dataclass
from ..._util.text import suggest_name
from ...numerics.portable_math import portable_sqrt
from ...numerics.rational import cross, dot3
from ..importers import OmittedPart
from ..openmc.placement import ORIGIN, Point
from ..openmc.region_expression import HalfSpaceNode, IntersectionNode, Region, join_regions, renumber_region
from ..openmc.surfaces import (
    ConeSurface,
    FlatSurface,
    GeneralSurface,
    OpenmcSurface,
    RoundSurface,
    Surface,
    check_positive,
    round_quadric,
)
from ..scene_file.nodes import shorten
from .cards import FIRST_FREE_KEY, Card, parse_integer, parse_numbers
from .transformations import (
    IDENTITY,
    FrameChange,
    add_rows,
    add_scaled,
    outer_product,
    scale_rows,
    scale_vector,
    shift_quadric,
    to_point,
    transform_surface,
)

Numbers = list[Fraction]
_ZERO, _ONE = Fraction(0), Fraction(1)
TORUS_MNEMONICS = ("tx", "ty", "tz")


@dataclass(frozen=True)
class SurfaceBounds:
    """The surfaces whose negative sides intersect in the negative side; `has_facets` if each is a numbered facet."""

    surfaces: tuple[Surface, ...]
    has_facets: bool = False
    remark: str = ""


def build_bounds(kind: str, numbers: Numbers) -> SurfaceBounds:
    """Return the surfaces of a mnemonic with its numbers.

    Parameters
    ----------
    kind
        The mnemonic in lower case, such as "px" or "rpp".
    numbers
        Its numbers, in cm.

    Raises
    ------
    ValueError
        The mnemonic is unknown or its numbers are wrong.
    OmittedPart
        It is a torus, which is no quadric.

    """
    # Before the list of kinds, so that the message names the reason
    if kind in TORUS_MNEMONICS:
        raise OmittedPart(f"is a torus ({kind}), which is no quadric")
    kinds = SURFACE_KINDS | MACROBODIES
    if kind not in kinds:
        raise ValueError(f"{shorten(kind, 20)!r} is no kind of surface{suggest_name(kind, kinds)}")
    # A wrong count is the most frequent mistake, and a card that is read with shifted numbers shows nothing of it
    counts, make = kinds[kind]
    if len(numbers) not in counts:
        expected = " or ".join(map(str, counts))
        raise ValueError(f"{kind} needs {expected} number{'' if counts == (1,) else 's'}, got {len(numbers)}")
    return make(numbers)


def _single_bound(surface: Surface) -> SurfaceBounds:
    return SurfaceBounds((surface,))


def _plane(numbers: Numbers) -> SurfaceBounds:
    """Return the plane A x + B y + C z = D, or the plane through three points."""
    if len(numbers) == 4:
        normal, offset = to_point(numbers[:3]), numbers[3]
        if not any(normal):
            raise ValueError("the normal of a plane must not be zero")
        return _single_bound(FlatSurface(normal, offset))
    a, b, c = (to_point(numbers[i : i + 3]) for i in (0, 3, 6))
    normal = cross(add_scaled(b, a, -1), add_scaled(c, a, -1))
    if not any(normal):
        raise ValueError("the three points of a plane lie on a line")
    offset = dot3(normal, a)
    # MCNP's rule for the sense: the origin is on the negative side. If the plane goes through the origin, (0, 0, ∞) is
    # on the positive side; if the plane contains that direction too, (0, ∞, 0) is, and then (∞, 0, 0).
    if next(value for value in (offset, *reversed(normal)) if value) < 0:
        normal, offset = scale_vector(normal, -1), -offset
    return _single_bound(FlatSurface(normal, offset))


def _axis_plane(axis: int) -> Callable[[Numbers], SurfaceBounds]:
    return lambda numbers: _single_bound(FlatSurface(IDENTITY[axis], numbers[0]))


def _sphere(center: Numbers, radius: Fraction) -> SurfaceBounds:
    return _single_bound(RoundSurface(None, to_point(center), check_positive("the radius", radius)))


def _axis_sphere(axis: int) -> Callable[[Numbers], SurfaceBounds]:
    return lambda numbers: _sphere(list(scale_vector(IDENTITY[axis], numbers[0])), numbers[1])


def _cylinder(axis: int) -> Callable[[Numbers], SurfaceBounds]:
    """Return a builder from two coordinates of the axis, in the order x, y, z, or none, and the radius."""

    def make(numbers: Numbers) -> SurfaceBounds:
        # "c/x y z r" lists the two coordinates across the axis, "cx r" none
        center = [*numbers[:-1]] or [_ZERO, _ZERO]
        center.insert(axis, _ZERO)
        return _single_bound(RoundSurface(axis, to_point(center), check_positive("the radius", numbers[-1])))

    return make


def _cone(axis: int, on_axis: bool) -> Callable[[Numbers], SurfaceBounds]:
    """Return a builder from the apex, the squared slope, and 1 or -1 for one nappe."""

    def make(numbers: Numbers) -> SurfaceBounds:
        count = 2 if on_axis else 4
        apex = scale_vector(IDENTITY[axis], numbers[0]) if on_axis else to_point(numbers[:3])
        square = check_positive("the square of the slope", numbers[count - 1])
        nappe = numbers[count] if len(numbers) > count else _ZERO
        if nappe not in (-1, 0, 1):
            raise ValueError(f"the nappe of a cone must be 1 or -1, got {float(nappe):g}")
        return cone_nappe(axis, apex, square, int(nappe))

    return make


def cone_nappe(axis: int, apex: Point, square: Fraction, nappe: int) -> SurfaceBounds:
    """Return a cone (nappe 0), or its part above (1) or below (-1) the apex."""
    cone = ConeSurface(axis, apex, square)
    # Without the last number a cone has both nappes, and then its negative side has two parts
    if not nappe:
        return _single_bound(cone)
    return SurfaceBounds((cone, FlatSurface(scale_vector(IDENTITY[axis], -nappe), -nappe * apex[axis])))


def _special(numbers: Numbers) -> SurfaceBounds:
    """Return A (x-x0)² + B (y-y0)² + C (z-z0)² + 2D (x-x0) + 2E (y-y0) + 2F (z-z0) + G = 0."""
    a, b, c, d, e, f, g = numbers[:7]
    # About its centre, not expanded: the coefficients stay as short as the deck has them
    return _quadric([a, b, c, _ZERO, _ZERO, _ZERO, 2 * d, 2 * e, 2 * f, g], to_point(numbers[7:]))


def _quadric(numbers: Numbers, shift: Point = ORIGIN) -> SurfaceBounds:
    """Return the quadric with ten coefficients, in the order of `TERMS`, about a point; a plane if it is linear."""
    # GQ may hold a plane, and a quadric without squares would be refused later
    if any(numbers[:6]):
        return _single_bound(round_quadric(numbers, shift) or GeneralSurface(tuple(numbers), shift))
    normal = to_point(numbers[6:9])
    if not any(normal):
        raise ValueError("must hold more than a constant")
    return _single_bound(FlatSurface(normal, dot3(normal, shift) - numbers[9]))


def _surface_by_points(axis: int) -> Callable[[Numbers], SurfaceBounds]:
    """Return a builder of the surface of revolution through one to three points (coordinate, distance from axis)."""

    def make(numbers: Numbers) -> SurfaceBounds:
        pairs = list(zip(numbers[::2], numbers[1::2], strict=True))
        if any(r < 0 for _, r in pairs):
            raise ValueError("distances from the axis must not be negative")
        heights = {t for t, _ in pairs}
        # One point, or several at one height: a plane across the axis
        if len(heights) == 1:
            return _single_bound(FlatSurface(IDENTITY[axis], pairs[0][0]))
        # A surface with two distances at one height is none of r(t)
        if len(heights) < len(pairs):
            raise ValueError("two of three points have one coordinate along the axis")
        if len(pairs) == 2:
            return _line_through_points(axis, pairs)
        return _conic_through_points(axis, pairs)

    return make


def _line_through_points(axis: int, pairs: list[tuple[Fraction, Fraction]]) -> SurfaceBounds:
    """Return the cylinder or the nappe of a cone through two points."""
    (s, p), (t, q) = pairs
    if p == q:
        return _single_bound(RoundSurface(axis, ORIGIN, check_positive("the radius", p)))
    slope = (q - p) / (t - s)  # the apex is where the line through both points meets the axis
    return cone_nappe(axis, scale_vector(IDENTITY[axis], s - p / slope), slope * slope, 1 if slope > 0 else -1)


def _conic_through_points(axis: int, pairs: list[tuple[Fraction, Fraction]]) -> SurfaceBounds:
    """Return r² = a t² + b t + c through three points (t, r)."""
    # Newton's divided differences of r² at the three coordinates.
    (s, p), (t, q), (u, r) = ((height, radius**2) for height, radius in pairs)
    first, second = (q - p) / (t - s), (r - q) / (u - t)
    a = (second - first) / (u - s)
    b = first - a * (s + t)
    c = p - s * first + a * s * t
    # Negative nearer to the axis
    squares = [-a if i == axis else _ONE for i in range(3)]
    return _quadric([*squares, _ZERO, _ZERO, _ZERO, *scale_vector(IDENTITY[axis], -b), -c])


SurfaceKind = tuple[tuple[int, ...], Callable[[Numbers], SurfaceBounds]]
"""(numbers that a mnemonic may have, builder)."""
SURFACE_KINDS: dict[str, SurfaceKind] = {
    "p": ((4, 9), _plane),
    "so": ((1,), lambda numbers: _sphere([_ZERO] * 3, numbers[0])),
    "s": ((4,), lambda numbers: _sphere(numbers[:3], numbers[3])),
    "sph": ((4,), lambda numbers: _sphere(numbers[:3], numbers[3])),
    "sq": ((10,), _special),
    "gq": ((10,), _quadric),
}
for _axis, _letter in enumerate("xyz"):
    SURFACE_KINDS |= {
        f"p{_letter}": ((1,), _axis_plane(_axis)),
        f"s{_letter}": ((2,), _axis_sphere(_axis)),
        f"c{_letter}": ((1,), _cylinder(_axis)),
        f"c/{_letter}": ((3,), _cylinder(_axis)),
        f"k{_letter}": ((2, 3), _cone(_axis, True)),
        f"k/{_letter}": ((4, 5), _cone(_axis, False)),
        _letter: ((2, 4, 6), _surface_by_points(_axis)),
    }


# Surface cards, and surfaces as regions of numbered sheets

_CARD_NUMBER = re.compile(r"([*+]?)([0-9]{1,9})")
_BOUNDARIES = {"": "transmission", "*": "reflective", "+": "white"}


@dataclass(frozen=True)
class SurfaceCard:
    """A surface card."""

    number: int
    boundary: str
    change: int | None  # number of a TR card
    form: SurfaceBounds


def read_surface_card(card: Card) -> SurfaceCard:
    """Return the surface of a card. Raise ValueError for a wrong card."""
    words = card.text.split()
    match = _CARD_NUMBER.fullmatch(words[0])
    if match is None or not int(match[2]):
        raise ValueError(f"a surface begins with its number, got {words[0][:20]!r}")
    change, is_periodic = None, False
    rest = words[1:]
    # A number before the mnemonic is a transformation if positive; negative, it is the partner of a periodic surface
    if rest and re.fullmatch(r"[-+]?[0-9]+", rest[0]):
        other = parse_integer("a transformation", rest.pop(0))
        change, is_periodic = other if other > 0 else None, other < 0
    if not rest:
        raise ValueError("a surface needs a kind, such as px")
    # Boundaries do not change the geometry; they are kept as facts of the surface
    boundary = "periodic" if is_periodic else _BOUNDARIES[match[1]]
    return SurfaceCard(int(match[2]), boundary, change, build_bounds(rest[0], parse_numbers(rest[1:])))


@dataclass
class SurfaceSheets:
    """The single surfaces ("sheets") of all cards by key: the card's number if it has one sheet, else a new number."""

    found: dict[int, OpenmcSurface] = field(default_factory=dict)
    facets: dict[int, list[Region]] = field(default_factory=dict)  # negative sides of all sheets by number of card
    copies: dict[tuple[int, FrameChange], int] = field(default_factory=dict)
    with_facets: set[int] = field(default_factory=set)

    def add(self, card: SurfaceCard, change: FrameChange | None) -> None:
        """Add the sheets of a card, moved by its transformation."""
        regions: list[Region] = []
        for surface in card.form.surfaces:
            own = surface if change is None else transform_surface(surface, change)
            # A card of several sheets has no sheet of its own number
            key = card.number if len(card.form.surfaces) == 1 else FIRST_FREE_KEY + len(self.found)
            regions.append(HalfSpaceNode(self._store(key, card.number, own, card.boundary), False))
        self.facets[card.number] = regions
        if card.form.has_facets:
            self.with_facets.add(card.number)

    def _store(self, key: int, number: int, surface: Surface, boundary: str) -> int:
        """Store a sheet and return its key."""
        self.found[key] = OpenmcSurface(number, "", surface, boundary)
        return key

    def side(self, number: int, facet: int | None) -> Region:
        """Return the negative side of a surface or of a facet. Raise ValueError for a facet that does not exist."""
        regions = self.facets[number]
        # A macrobody as a whole is the intersection; its positive side is the complement of all, not of each
        if facet is None:
            return join_regions(IntersectionNode, regions)
        if number not in self.with_facets:
            raise ValueError(f"region: surface {number} has no facets, got {number}.{facet}")
        if not 1 <= facet <= len(regions):
            raise ValueError(f"region: surface {number} has facets 1 to {len(regions)}, got {number}.{facet}")
        return regions[facet - 1]

    def moved(self, region: Region, change: FrameChange) -> Region:
        """Return a region moved by a transformation, with moved copies of its sheets."""
        return renumber_region(region, lambda key: self._copy(key, change))

    def _copy(self, key: int, change: FrameChange) -> int:
        """Return the key of a sheet moved by a transformation; equal copies are one."""
        if (key, change) not in self.copies:
            old = self.found[key]
            copy = self._store(
                FIRST_FREE_KEY + len(self.found), old.id, transform_surface(old.surface, change), old.boundary
            )
            self.copies[key, change] = copy
        return self.copies[key, change]


# Macrobodies: a body is on the negative side of each of its facets, which are numbered from 1.

_ZERO_OFFSET = Fraction(0)
_ROOT_3_4 = Fraction(portable_sqrt(Fraction(3, 4)))
MAX_SKEW = Fraction(1, 1000)
"""Largest cosine between vectors that must be perpendicular."""
_INFINITE_HEIGHT = 10**6
"""Height in cm from which a hexagonal prism has no ends, by the manual on RHP."""


def _vectors(numbers: Numbers) -> list[Point]:
    """Return numbers as vectors of three; a rest of one or two numbers is left out."""
    return [to_point(numbers[i : i + 3]) for i in range(0, len(numbers) - 2, 3)]


def _facet(normal: Point, through: Point) -> FlatSurface:
    """Return the plane through a point, across a vector that points out of the body."""
    if not any(normal):
        raise ValueError("a vector must not be zero")
    return FlatSurface(normal, dot3(normal, through))


def _end_planes(vector: Point, base: Point) -> tuple[FlatSurface, FlatSurface]:
    """Return the planes across a vector at its end and at its beginning."""
    return _facet(vector, add_scaled(base, vector)), _facet(scale_vector(vector, -1), base)


def _check_across(*vectors: Point) -> None:
    """Raise ValueError unless all vectors are perpendicular to each other, up to `MAX_SKEW`."""
    for i, u in enumerate(vectors):
        for v in vectors[i + 1 :]:
            # Squared, so that no root is needed; decks write unit vectors with few digits
            if dot3(u, v) ** 2 > MAX_SKEW**2 * dot3(u, u) * dot3(v, v):
                raise ValueError(
                    f"its vectors must be perpendicular to each other, with cosines of at most {float(MAX_SKEW):g}"
                )


def _rpp(numbers: Numbers) -> SurfaceBounds:
    """Return a box along the axes from xmin xmax ymin ymax zmin zmax; equal ends leave one direction infinite."""
    facets: list[Surface] = []
    for axis in range(3):
        low, high = numbers[2 * axis : 2 * axis + 2]
        if low > high:
            raise ValueError(f"rpp: the {'xyz'[axis]} of one end must be below that of the other")
        # The manual, on facets: those of an infinite direction are skipped, so that later ones have lower numbers
        if low < high:
            facets += [FlatSurface(IDENTITY[axis], high), FlatSurface(scale_vector(IDENTITY[axis], -1), -low)]
    if len(facets) < 4:
        raise ValueError("rpp: at most one direction may be infinite, by equal ends")
    return SurfaceBounds(tuple(facets), True)


def _box(numbers: Numbers) -> SurfaceBounds:
    """Return a box of three edges from a corner; of two edges, a box that is infinite along the third."""
    corner, *edges = _vectors(numbers)
    _check_across(*edges)
    # Facet 1 lies at the end of the first edge, facet 2 at the corner, and so on
    return SurfaceBounds(tuple(facet for edge in edges for facet in _end_planes(edge, corner)), True)


def _rcc(numbers: Numbers) -> SurfaceBounds:
    """Return a cylinder from base, height vector and radius."""
    base, height = _vectors(numbers)
    return SurfaceBounds(
        (_cylinder_about(base, height, check_positive("the radius", numbers[6])), *_end_planes(height, base)), True
    )


def _cylinder_about(base: Point, height: Point, radius: Fraction) -> Surface:
    """Return the infinite cylinder about a vector: a `RoundSurface` along an axis, else a general quadric."""
    along = [i for i in range(3) if height[i]]
    # Along an axis a cylinder is exact and cheap, and coincides with one of a CX card
    if len(along) == 1:
        x, y, z = (_ZERO_OFFSET if i == along[0] else value for i, value in enumerate(base))
        return RoundSurface(along[0], (x, y, z), radius)
    if not along:
        raise ValueError("a vector must not be zero")
    # |q|² - (q·H)²/H² = r² with q = x - base.
    across = add_rows(IDENTITY, outer_product(height), -1 / dot3(height, height))
    return shift_quadric(across, (_ZERO_OFFSET, _ZERO_OFFSET, _ZERO_OFFSET), -(radius**2), base)


def _trc(numbers: Numbers) -> SurfaceBounds:
    """Return a truncated cone from base, height vector H and the radii R1 and R2 at both ends."""
    base, height = _vectors(numbers[:6])
    first, last = numbers[6:]
    if min(first, last) < 0 or first == last == 0:
        raise ValueError("the radii of trc must be >= 0, and one of them > 0")
    ends = _end_planes(height, base)
    # The cone of equal radii has its apex at infinity
    if first == last:
        return SurfaceBounds((_cylinder_about(base, height, first), *ends), True)
    square, step = dot3(height, height), last - first
    # With q = x - base: |q|² - (q·H)²/H² = (R1 + (R2 - R1) q·H/H²)².
    matrix = add_rows(IDENTITY, outer_product(height), -1 / square - (step / square) ** 2)
    return SurfaceBounds(
        (shift_quadric(matrix, scale_vector(height, -2 * first * step / square), -(first**2), base), *ends), True
    )


def _rec(numbers: Numbers) -> SurfaceBounds:
    """Return an elliptic cylinder from base, height and two semi-axes, or one and the length of the other."""
    base, height, major = _vectors(numbers[:9])
    minor = to_point(numbers[9:]) if len(numbers) == 12 else cross(height, major)
    if not (any(height) and any(major) and any(minor)):
        raise ValueError("a vector must not be zero")
    _check_across(height, major, minor)
    if len(numbers) == 12:
        other = 1 / dot3(minor, minor) ** 2
    else:
        other = 1 / (dot3(minor, minor) * check_positive("the radius", numbers[9]) ** 2)
    matrix = add_rows(scale_rows(outer_product(major), 1 / dot3(major, major) ** 2), outer_product(minor), other)
    return SurfaceBounds(
        (
            shift_quadric(matrix, (_ZERO_OFFSET, _ZERO_OFFSET, _ZERO_OFFSET), Fraction(-1), base),
            *_end_planes(height, base),
        ),
        True,
    )


def _ell(numbers: Numbers) -> SurfaceBounds:
    """Return an ellipsoid of revolution.

    A negative radius -b is that across the axis; the vectors are centre and semi-axis. A positive one, a, is the
    semi-axis along two points, the "foci", which are 2 f apart. MCNP's manual calls a the length of the whole axis, but
    the program takes b² = a² - (a - f)², as two converters that were compared with it know: gxsview, t4_geom_convert.
    """
    a, b = _vectors(numbers[:6])
    radius = numbers[6]
    remark = ""
    if radius > 0:
        center = scale_vector(add_scaled(a, b), Fraction(1, 2))
        along = scale_vector(add_scaled(b, a, -1), Fraction(1, 2))
        far = _length(along)
        long, short = radius**2, far * (2 * radius - far)
        if short <= 0:
            raise ValueError("ell: the two points must be apart, by less than four times the radius")
        remark = "is the ellipsoid of MCNP itself, which takes the points for no foci, against its manual"
    elif radius < 0 and any(b):
        center, along, long, short = a, b, dot3(b, b), radius**2
    else:
        raise ValueError("ell: neither the radius nor the axis may be zero")
    if long == short:
        return SurfaceBounds((RoundSurface(None, center, abs(radius)),), remark=remark)
    # |q|²/b² + (1/a² - 1/b²) (q·A)²/A² = 1 with q = x - centre and the axis A; `long` is a², `short` is b².
    size = dot3(along, along)
    matrix = add_rows(scale_rows(IDENTITY, 1 / short), outer_product(along), (1 / long - 1 / short) / size)
    sheet = shift_quadric(matrix, (_ZERO_OFFSET, _ZERO_OFFSET, _ZERO_OFFSET), Fraction(-1), center)
    return SurfaceBounds((sheet,), remark=remark)


def _rhp(numbers: Numbers) -> SurfaceBounds:
    """Return a hexagonal prism from base, height and the vectors to the middles of three sides.

    With one vector r only, the other two are r turned by 60 and 120 degrees. Of 10⁶ cm or more the height is infinite.
    """
    base, height, r, *others = _vectors(numbers)
    if others:
        s, t = others
    else:
        _check_across(height, r)
        if not any(height):
            raise ValueError("a vector must not be zero")
        across = scale_vector(cross(height, r), 1 / _length(height))
        # cos 60 = 1/2 and sin 60 = sqrt(3/4): the turn about the height of a vector that is perpendicular to it
        s = add_scaled(scale_vector(r, Fraction(1, 2)), across, _ROOT_3_4)
        t = add_scaled(s, r, -1)
    facets = [_facet(scale_vector(v, sign), add_scaled(base, v, sign)) for v in (r, s, t) for sign in (1, -1)]
    ends = () if dot3(height, height) >= _INFINITE_HEIGHT**2 else _end_planes(height, base)
    return SurfaceBounds((*facets, *ends), True)


def _length(vector: Point) -> Fraction:
    """Return the length of a vector, exact along an axis."""
    along = [abs(value) for value in vector if value]
    return along[0] if len(along) == 1 else Fraction(portable_sqrt(dot3(vector, vector)))


def _wed(numbers: Numbers) -> SurfaceBounds:
    """Return a wedge: a triangular prism from a corner, two edges a and b of the triangle, and the height."""
    corner, a, b, height = _vectors(numbers)
    _check_across(a, height)
    _check_across(b, height)
    slant = cross(height, add_scaled(b, a, -1))
    if dot3(slant, a) < 0:
        slant = scale_vector(slant, -1)
    facets = [_facet(slant, add_scaled(corner, a))]
    for u, v, inward in ((b, height, a), (a, height, b)):  # the vectors may be left- or right-handed
        normal = cross(u, v)
        facets.append(_facet(scale_vector(normal, -1 if dot3(normal, inward) > 0 else 1), corner))
    top = cross(a, b)
    if dot3(top, height) < 0:
        top = scale_vector(top, -1)
    facets += [_facet(top, add_scaled(corner, height)), _facet(scale_vector(top, -1), corner)]
    if not dot3(slant, a):
        raise ValueError("wed: its vectors lie in a plane")
    return SurfaceBounds(tuple(facets), True)


def _arb(numbers: Numbers) -> SurfaceBounds:
    """Return a convex polyhedron from eight corners and six sides, each a number whose digits are its corners."""
    corners = _vectors(numbers[:24])
    # A side of three corners is written with a 0 as its last digit, and a missing side as 0
    sides = [str(int(value)).rstrip("0") for value in numbers[24:] if value]
    if not all(value.denominator == 1 and value >= 0 for value in numbers[24:]):
        raise ValueError("arb: a side is given by the digits of its corners")
    if len(sides) < 4 or any(not 3 <= len(side) <= 4 or set(side) - set("12345678") for side in sides):
        raise ValueError("arb: has four to six sides, each given by the digits of three or four corners, 1 to 8")
    used = [corners[int(n) - 1] for n in sorted(set("".join(sides)))]
    middle = (
        sum((p[0] for p in used), _ZERO_OFFSET),
        sum((p[1] for p in used), _ZERO_OFFSET),
        sum((p[2] for p in used), _ZERO_OFFSET),
    )
    middle = scale_vector(middle, Fraction(1, len(used)))
    size = max(dot3(add_scaled(p, middle, -1), add_scaled(p, middle, -1)) for p in used)
    facets = []
    for side in sides:
        a, b, c, *rest = (corners[int(n) - 1] for n in side)
        normal = cross(add_scaled(b, a, -1), add_scaled(c, a, -1))
        if not any(normal):
            raise ValueError(f"arb: the corners of the side {side} lie on a line")
        if dot3(normal, add_scaled(middle, a, -1)) > 0:
            normal = scale_vector(normal, -1)
        # Corners are rounded in decks: a fourth corner may be a little off the plane of the first three.
        slack = MAX_SKEW * Fraction(portable_sqrt(dot3(normal, normal) * size))
        if any(abs(dot3(normal, add_scaled(p, a, -1))) > slack for p in rest):
            raise ValueError(f"arb: the corners of the side {side} do not lie in a plane")
        if any(dot3(normal, add_scaled(p, a, -1)) > slack for p in used):
            raise ValueError(f"arb: must be convex, there are corners beyond the side {side}")
        facets.append(_facet(normal, a))
    return SurfaceBounds(tuple(facets), True)


MACROBODIES: dict[str, SurfaceKind] = {
    "rpp": ((6,), _rpp), "box": ((9, 12), _box), "rcc": ((7,), _rcc), "trc": ((8,), _trc), "rec": ((10, 12), _rec),
    "ell": ((7,), _ell), "rhp": ((9, 15), _rhp), "hex": ((9, 15), _rhp), "wed": ((12,), _wed), "arb": ((30,), _arb),
}  # fmt: skip
