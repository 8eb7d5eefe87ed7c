"""MCNP's surfaces by their mnemonics: the negative side of each is the common part of negative sides of one or more."""

from __future__ import annotations

import re
from collections.abc import Callable
from dataclasses import dataclass, field
from fractions import Fraction

from ..._util.hints import suggest_name
from ...numerics.portable_math import portable_sqrt
from ..openmc.placement import ORIGIN, Point
from ..openmc.region import HalfSpaceNode, IntersectionNode, Region
from ..openmc.surfaces import ConeSurface, FlatSurface, GeneralSurface, OpenmcSurface, RoundSurface, Surface
from ..scene_file.nodes import shorten
from .cards import FIRST_FREE_KEY, Card, parse_integer, parse_numbers
from .regions import join_regions, renumber_region
from .transformations import (
    IDENTITY,
    FrameChange,
    add_rows,
    add_scaled,
    cross,
    dot,
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
    """What bounds the negative side, all of it; each bound a facet of its own, or none."""

    surfaces: tuple[Surface, ...]
    has_facets: bool = False


def build_bounds(kind: str, numbers: Numbers) -> SurfaceBounds:
    """Raises ValueError for what is wrong and for tori, which are no quadrics."""
    if kind in TORUS_MNEMONICS:
        raise ValueError(f"is a torus ({kind}), which is no quadric: Conicoid cannot express it")
    known = SURFACE_KINDS | MACROBODIES
    if kind not in known:
        raise ValueError(f"{shorten(kind, 20)!r} is no kind of surface{suggest_name(kind, known)}")
    counts, make = known[kind]
    if len(numbers) not in counts:
        expected = " or ".join(map(str, counts))
        raise ValueError(f"{kind} needs {expected} number{'' if counts == (1,) else 's'}, got {len(numbers)}")
    return make(numbers)


def check_positive(what: str, value: Fraction) -> Fraction:
    if value <= 0:
        raise ValueError(f"the {what} must be > 0, got {float(value):g}")
    return value


def _single_bound(surface: Surface) -> SurfaceBounds:
    return SurfaceBounds((surface,))


def _plane(numbers: Numbers) -> SurfaceBounds:
    """A x + B y + C z = D, or by three points."""
    if len(numbers) == 4:
        normal, offset = to_point(numbers[:3]), numbers[3]
        if not any(normal):
            raise ValueError("the normal of a plane must not be zero")
        return _single_bound(FlatSurface(normal, offset))
    a, b, c = (to_point(numbers[i : i + 3]) for i in (0, 3, 6))
    normal = cross(add_scaled(b, a, -1), add_scaled(c, a, -1))
    if not any(normal):
        raise ValueError("the three points of a plane lie on a line")
    offset = dot(normal, a)
    # The origin is on the negative side; else (0, 0, ∞) on the positive one, else (0, ∞, 0), else (∞, 0, 0)
    if next(value for value in (offset, *reversed(normal)) if value) < 0:
        normal, offset = scale_vector(normal, -1), -offset
    return _single_bound(FlatSurface(normal, offset))


def _axis_plane(axis: int) -> Callable[[Numbers], SurfaceBounds]:
    return lambda numbers: _single_bound(FlatSurface(IDENTITY[axis], numbers[0]))


def _sphere(center: Numbers, radius: Fraction) -> SurfaceBounds:
    return _single_bound(RoundSurface(None, to_point(center), check_positive("radius", radius)))


def _axis_sphere(axis: int) -> Callable[[Numbers], SurfaceBounds]:
    return lambda numbers: _sphere(list(scale_vector(IDENTITY[axis], numbers[0])), numbers[1])


def _cylinder(axis: int) -> Callable[[Numbers], SurfaceBounds]:
    """Two coordinates of the axis, in the order x, y, z, or none; and the radius."""

    def make(numbers: Numbers) -> SurfaceBounds:
        center = [*numbers[:-1]] or [_ZERO, _ZERO]
        center.insert(axis, _ZERO)
        return _single_bound(RoundSurface(axis, to_point(center), check_positive("radius", numbers[-1])))

    return make


def _cone(axis: int, on_axis: bool) -> Callable[[Numbers], SurfaceBounds]:
    """The apex, the squared slope, and 1 or -1 for one nappe."""

    def make(numbers: Numbers) -> SurfaceBounds:
        count = 2 if on_axis else 4
        apex = scale_vector(IDENTITY[axis], numbers[0]) if on_axis else to_point(numbers[:3])
        square = check_positive("square of the slope", numbers[count - 1])
        nappe = numbers[count] if len(numbers) > count else _ZERO
        if nappe not in (-1, 0, 1):
            raise ValueError(f"the nappe of a cone must be 1 or -1, got {float(nappe):g}")
        return cone_nappe(axis, apex, square, int(nappe))

    return make


def cone_nappe(axis: int, apex: Point, square: Fraction, nappe: int) -> SurfaceBounds:
    """A cone, or its part above (1) or below (-1) the apex."""
    cone = ConeSurface(axis, apex, square)
    if not nappe:
        return _single_bound(cone)
    return SurfaceBounds((cone, FlatSurface(scale_vector(IDENTITY[axis], -nappe), -nappe * apex[axis])))


def _special(numbers: Numbers) -> SurfaceBounds:
    """A (x-x0)² + B (y-y0)² + C (z-z0)² + 2D (x-x0) + 2E (y-y0) + 2F (z-z0) + G"""
    a, b, c, d, e, f, g = numbers[:7]
    return _quadric([a, b, c, _ZERO, _ZERO, _ZERO, 2 * d, 2 * e, 2 * f, g], to_point(numbers[7:]))


def _quadric(numbers: Numbers, shift: Point = ORIGIN) -> SurfaceBounds:
    if any(numbers[:6]):
        return _single_bound(GeneralSurface(tuple(numbers), shift))
    normal = to_point(numbers[6:9])
    if not any(normal):
        raise ValueError("must hold more than a constant")
    return _single_bound(FlatSurface(normal, dot(normal, shift) - numbers[9]))


def _surface_by_points(axis: int) -> Callable[[Numbers], SurfaceBounds]:
    """Through one to three points (coordinate along the axis, distance from it)."""

    def make(numbers: Numbers) -> SurfaceBounds:
        pairs = list(zip(numbers[::2], numbers[1::2], strict=True))
        if any(r < 0 for _, r in pairs):
            raise ValueError("distances from the axis must not be negative")
        heights = {t for t, _ in pairs}
        if len(heights) == 1:
            return _single_bound(FlatSurface(IDENTITY[axis], pairs[0][0]))
        if len(heights) < len(pairs):
            raise ValueError("two of three points have one coordinate along the axis")
        if len(pairs) == 2:
            return _line_through_points(axis, pairs)
        return _conic_through_points(axis, pairs)

    return make


def _line_through_points(axis: int, pairs: list[tuple[Fraction, Fraction]]) -> SurfaceBounds:
    """A cylinder, or the nappe of a cone on which both points are."""
    (s, p), (t, q) = pairs
    if p == q:
        return _single_bound(RoundSurface(axis, ORIGIN, check_positive("radius", p)))
    slope = (q - p) / (t - s)
    return cone_nappe(axis, scale_vector(IDENTITY[axis], s - p / slope), slope * slope, 1 if slope > 0 else -1)


def _conic_through_points(axis: int, pairs: list[tuple[Fraction, Fraction]]) -> SurfaceBounds:
    """r² = a t² + b t + c through three points."""
    (s, p), (t, q), (u, r) = ((height, radius**2) for height, radius in pairs)
    first, second = (q - p) / (t - s), (r - q) / (u - t)
    a = (second - first) / (u - s)
    b = first - a * (s + t)
    c = p - s * first + a * s * t
    squares = [-a if i == axis else _ONE for i in range(3)]
    return _quadric([*squares, _ZERO, _ZERO, _ZERO, *scale_vector(IDENTITY[axis], -b), -c])


SurfaceKind = tuple[tuple[int, ...], Callable[[Numbers], SurfaceBounds]]
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


# MCNP's surface cards, and surfaces as regions of numbered sheets: macrobodies have several.

_CARD_NUMBER = re.compile(r"([*+]?)([0-9]{1,9})")
_BOUNDARIES = {"": "transmission", "*": "reflective", "+": "white"}


@dataclass(frozen=True)
class SurfaceCard:
    """A surface as its card says it."""

    number: int
    boundary: str
    change: int | None  # of a TR card
    partner: int | None  # periodic with another surface
    form: SurfaceBounds


def read_surface_card(card: Card) -> SurfaceCard:
    """Raises ValueError."""
    words = card.text.split()
    found = _CARD_NUMBER.fullmatch(words[0])
    if found is None or not int(found[2]):
        raise ValueError(f"a surface begins with its number, got {words[0][:20]!r}")
    change = partner = None
    rest = words[1:]
    if rest and re.fullmatch(r"[-+]?[0-9]+", rest[0]):
        other = parse_integer("a transformation", rest.pop(0))
        change, partner = (other, None) if other > 0 else (None, -other or None)
    if not rest:
        raise ValueError("a surface needs a kind, such as px")
    boundary = "periodic" if partner else _BOUNDARIES[found[1]]
    return SurfaceCard(int(found[2]), boundary, change, partner, build_bounds(rest[0], parse_numbers(rest[1:])))


@dataclass
class SurfaceSheets:
    """The single surfaces of all cards, each with a key: the card's number where it has one sheet, else a new one."""

    found: dict[int, OpenmcSurface] = field(default_factory=dict)
    facets: dict[int, list[Region]] = field(default_factory=dict)  # by the number of a card: the negative sides
    copies: dict[tuple[int, FrameChange], int] = field(default_factory=dict)
    with_facets: set[int] = field(default_factory=set)

    def add(self, card: SurfaceCard, change: FrameChange | None) -> None:
        """The sheets of a card, moved."""
        regions: list[Region] = []
        for surface in card.form.surfaces:
            own = surface if change is None else transform_surface(surface, change)
            key = card.number if len(card.form.surfaces) == 1 else FIRST_FREE_KEY + len(self.found)
            regions.append(HalfSpaceNode(self._kept(key, card.number, own, card.boundary), False))
        self.facets[card.number] = regions
        if card.form.has_facets:
            self.with_facets.add(card.number)

    def _kept(self, key: int, number: int, surface: Surface, boundary: str) -> int:
        self.found[key] = OpenmcSurface(number, "", surface, boundary)
        return key

    def side(self, number: int, facet: int | None) -> Region:
        """The negative side of a surface or of a facet. Raises ValueError."""
        regions = self.facets[number]
        if facet is None:
            return join_regions(IntersectionNode, regions)
        if number not in self.with_facets:
            raise ValueError(f"region: surface {number} has no facets, {number}.{facet} is asked for")
        if not 1 <= facet <= len(regions):
            raise ValueError(f"region: surface {number} has facets 1 to {len(regions)}, {number}.{facet} is asked for")
        return regions[facet - 1]

    def moved(self, region: Region, change: FrameChange) -> Region:
        """A region elsewhere."""
        return renumber_region(region, lambda key: self._copy(key, change))

    def _copy(self, key: int, change: FrameChange) -> int:
        if (key, change) not in self.copies:
            old = self.found[key]
            copy = self._kept(
                FIRST_FREE_KEY + len(self.found), old.id, transform_surface(old.surface, change), old.boundary
            )
            self.copies[key, change] = copy
        return self.copies[key, change]


# MCNP's macrobodies: all of a body is on the negative side of each of its facets, which are numbered from 1.

_ZERO_OFFSET = Fraction(0)
_ROOT_3_4 = Fraction(portable_sqrt(Fraction(3, 4)))
MAX_SKEW = Fraction(1, 1000)
"""Cosines up to this between vectors that ought to be perpendicular."""


def _vectors(numbers: Numbers) -> list[Point]:
    return [to_point(numbers[i : i + 3]) for i in range(0, len(numbers) - 2, 3)]


def _facet(normal: Point, through: Point) -> FlatSurface:
    """The plane across a vector that points out of the body."""
    if not any(normal):
        raise ValueError("a vector must not be zero")
    return FlatSurface(normal, dot(normal, through))


def _end_planes(vector: Point, base: Point) -> tuple[FlatSurface, FlatSurface]:
    """At the end of a vector and at its beginning."""
    return _facet(vector, add_scaled(base, vector)), _facet(scale_vector(vector, -1), base)


def _check_across(*vectors: Point) -> None:
    for i, u in enumerate(vectors):
        for v in vectors[i + 1 :]:
            if dot(u, v) ** 2 > MAX_SKEW**2 * dot(u, u) * dot(v, v):
                raise ValueError("its vectors must be perpendicular to each other")


def _rpp(numbers: Numbers) -> SurfaceBounds:
    facets: list[Surface] = []
    for axis in range(3):
        low, high = numbers[2 * axis : 2 * axis + 2]
        if low >= high:
            raise ValueError(f"rpp: the {'xyz'[axis]} of one end must be below that of the other")
        facets += [FlatSurface(IDENTITY[axis], high), FlatSurface(scale_vector(IDENTITY[axis], -1), -low)]
    return SurfaceBounds(tuple(facets), True)


def _box(numbers: Numbers) -> SurfaceBounds:
    """Three edges from a corner; two for one without ends."""
    corner, *edges = _vectors(numbers)
    _check_across(*edges)
    return SurfaceBounds(tuple(facet for edge in edges for facet in _end_planes(edge, corner)), True)


def _rcc(numbers: Numbers) -> SurfaceBounds:
    base, height = _vectors(numbers)
    return SurfaceBounds(
        (_cylinder_about(base, height, check_positive("radius", numbers[6])), *_end_planes(height, base)), True
    )


def _cylinder_about(base: Point, height: Point, radius: Fraction) -> Surface:
    """The cylinder about a vector."""
    along = [i for i in range(3) if height[i]]
    if len(along) == 1:
        x, y, z = (_ZERO_OFFSET if i == along[0] else value for i, value in enumerate(base))
        return RoundSurface(along[0], (x, y, z), radius)
    if not along:
        raise ValueError("a vector must not be zero")
    across = add_rows(IDENTITY, outer_product(height), -1 / dot(height, height))
    return shift_quadric(across, (_ZERO_OFFSET, _ZERO_OFFSET, _ZERO_OFFSET), -(radius**2), base)


def _trc(numbers: Numbers) -> SurfaceBounds:
    base, height = _vectors(numbers[:6])
    first, last = numbers[6:]
    if min(first, last) < 0 or first == last == 0:
        raise ValueError("the radii of trc must be >= 0, and one of them > 0")
    ends = _end_planes(height, base)
    if first == last:
        return SurfaceBounds((_cylinder_about(base, height, first), *ends), True)
    square, step = dot(height, height), last - first
    # |q|² - (q·H)²/H² = (R1 + (R2 - R1) q·H/H²)²
    matrix = add_rows(IDENTITY, outer_product(height), -1 / square - (step / square) ** 2)
    return SurfaceBounds(
        (shift_quadric(matrix, scale_vector(height, -2 * first * step / square), -(first**2), base), *ends), True
    )


def _rec(numbers: Numbers) -> SurfaceBounds:
    """Two half axes, or one and the length of the other."""
    base, height, major = _vectors(numbers[:9])
    minor = to_point(numbers[9:]) if len(numbers) == 12 else cross(height, major)
    if not (any(height) and any(major) and any(minor)):
        raise ValueError("a vector must not be zero")
    _check_across(height, major, minor)
    if len(numbers) == 12:
        other = 1 / dot(minor, minor) ** 2
    else:
        other = 1 / (dot(minor, minor) * check_positive("radius", numbers[9]) ** 2)
    matrix = add_rows(scale_rows(outer_product(major), 1 / dot(major, major) ** 2), outer_product(minor), other)
    return SurfaceBounds(
        (
            shift_quadric(matrix, (_ZERO_OFFSET, _ZERO_OFFSET, _ZERO_OFFSET), Fraction(-1), base),
            *_end_planes(height, base),
        ),
        True,
    )


def _ell(numbers: Numbers) -> SurfaceBounds:
    """By foci and half of the long axis, or by the centre, half of the long axis and the other radius, negative."""
    a, b = _vectors(numbers[:6])
    radius = numbers[6]
    if radius > 0:
        center, along = (
            scale_vector(add_scaled(a, b), Fraction(1, 2)),
            scale_vector(add_scaled(b, a, -1), Fraction(1, 2)),
        )
        long, short = radius**2, radius**2 - dot(along, along)
        if short <= 0:
            raise ValueError("ell: half of the long axis must be greater than the way from the centre to a focus")
    elif radius < 0 and any(b):
        center, along, long, short = a, b, dot(b, b), radius**2
    else:
        raise ValueError("ell: neither the radius nor the axis may be zero")
    if not any(along) or long == short:
        if long == short and radius < 0:
            return SurfaceBounds((RoundSurface(None, center, -radius),))
        return SurfaceBounds((RoundSurface(None, center, radius),))
    size = dot(along, along)
    matrix = add_rows(scale_rows(IDENTITY, 1 / short), outer_product(along), (1 / long - 1 / short) / size)
    return SurfaceBounds((shift_quadric(matrix, (_ZERO_OFFSET, _ZERO_OFFSET, _ZERO_OFFSET), Fraction(-1), center),))


def _rhp(numbers: Numbers) -> SurfaceBounds:
    """A hexagonal prism by its height and the ways to three of its sides; two of them may follow from the first."""
    base, height, r, *others = _vectors(numbers)
    if others:
        s, t = others
    else:
        _check_across(height, r)
        if not any(height):
            raise ValueError("a vector must not be zero")
        across = scale_vector(cross(height, r), 1 / _length(height))
        s = add_scaled(scale_vector(r, Fraction(1, 2)), across, _ROOT_3_4)
        t = add_scaled(s, r, -1)
    facets = [_facet(scale_vector(v, sign), add_scaled(base, v, sign)) for v in (r, s, t) for sign in (1, -1)]
    return SurfaceBounds((*facets, *_end_planes(height, base)), True)


def _length(vector: Point) -> Fraction:
    along = [abs(value) for value in vector if value]
    return along[0] if len(along) == 1 else Fraction(portable_sqrt(dot(vector, vector)))


def _wed(numbers: Numbers) -> SurfaceBounds:
    corner, a, b, height = _vectors(numbers)
    _check_across(a, height)
    _check_across(b, height)
    slant = cross(height, add_scaled(b, a, -1))
    if dot(slant, a) < 0:
        slant = scale_vector(slant, -1)
    facets = [_facet(slant, add_scaled(corner, a))]
    for u, v, inward in ((b, height, a), (a, height, b)):
        normal = cross(u, v)
        facets.append(_facet(scale_vector(normal, -1 if dot(normal, inward) > 0 else 1), corner))
    top = cross(a, b)
    if dot(top, height) < 0:
        top = scale_vector(top, -1)
    facets += [_facet(top, add_scaled(corner, height)), _facet(scale_vector(top, -1), corner)]
    if not dot(slant, a):
        raise ValueError("wed: its vectors lie in a plane")
    return SurfaceBounds(tuple(facets), True)


def _arb(numbers: Numbers) -> SurfaceBounds:
    """Eight corners and six sides, each by the digits of its three or four corners."""
    corners = _vectors(numbers[:24])
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
    size = max(dot(add_scaled(p, middle, -1), add_scaled(p, middle, -1)) for p in used)
    facets = []
    for side in sides:
        a, b, c, *rest = (corners[int(n) - 1] for n in side)
        normal = cross(add_scaled(b, a, -1), add_scaled(c, a, -1))
        if not any(normal):
            raise ValueError(f"arb: the corners of the side {side} lie on a line")
        if dot(normal, add_scaled(middle, a, -1)) > 0:
            normal = scale_vector(normal, -1)
        slack = MAX_SKEW * Fraction(portable_sqrt(dot(normal, normal) * size))
        if any(abs(dot(normal, add_scaled(p, a, -1))) > slack for p in rest):
            raise ValueError(f"arb: the corners of the side {side} do not lie in a plane")
        if any(dot(normal, add_scaled(p, a, -1)) > slack for p in used):
            raise ValueError(f"arb: must be convex, there are corners beyond the side {side}")
        facets.append(_facet(normal, a))
    return SurfaceBounds(tuple(facets), True)


MACROBODIES: dict[str, SurfaceKind] = {
    "rpp": ((6,), _rpp), "box": ((9, 12), _box), "rcc": ((7,), _rcc), "trc": ((8,), _trc), "rec": ((10, 12), _rec),
    "ell": ((7,), _ell), "rhp": ((9, 15), _rhp), "hex": ((9, 15), _rhp), "wed": ((12,), _wed), "arb": ((30,), _arb),
}  # fmt: skip
