"""MCNP's macrobodies: all of a body is on the negative side of each of its facets, which are numbered from 1."""

from __future__ import annotations

from fractions import Fraction

from ...shapes.rounded import root
from ..openmc.placement import Point
from ..openmc.surfaces import FlatSurface, RoundSurface, Surface
from .forms import Form, Kind, Numbers, positive
from .transformations import quadric
from .vectors import UNIT, cross, dot, outer, plus, point, scaled, times, total

_ZERO = Fraction(0)
_ROOT_3_4 = Fraction(root(Fraction(3, 4)))
CROOKED = Fraction(1, 1000)
"""Cosines up to this between vectors that ought to be perpendicular."""


def _vectors(numbers: Numbers) -> list[Point]:
    return [point(numbers[i : i + 3]) for i in range(0, len(numbers) - 2, 3)]


def _facet(normal: Point, through: Point) -> FlatSurface:
    """The plane across a vector that points out of the body."""
    if not any(normal):
        raise ValueError("a vector must not be zero")
    return FlatSurface(normal, dot(normal, through))


def _ends(vector: Point, base: Point) -> tuple[FlatSurface, FlatSurface]:
    """At the end of a vector and at its beginning."""
    return _facet(vector, plus(base, vector)), _facet(scaled(vector, -1), base)


def _check_across(*vectors: Point) -> None:
    for i, u in enumerate(vectors):
        for v in vectors[i + 1 :]:
            if dot(u, v) ** 2 > CROOKED**2 * dot(u, u) * dot(v, v):
                raise ValueError("its vectors must be perpendicular to each other")


def _rpp(numbers: Numbers) -> Form:
    facets: list[Surface] = []
    for axis in range(3):
        low, high = numbers[2 * axis : 2 * axis + 2]
        if low >= high:
            raise ValueError(f"rpp: the {'xyz'[axis]} of one end must be below that of the other")
        facets += [FlatSurface(UNIT[axis], high), FlatSurface(scaled(UNIT[axis], -1), -low)]
    return Form(tuple(facets), True)


def _box(numbers: Numbers) -> Form:
    """Three edges from a corner; two for one without ends."""
    corner, *edges = _vectors(numbers)
    _check_across(*edges)
    return Form(tuple(facet for edge in edges for facet in _ends(edge, corner)), True)


def _rcc(numbers: Numbers) -> Form:
    base, height = _vectors(numbers)
    return Form((_round(base, height, positive("radius", numbers[6])), *_ends(height, base)), True)


def _round(base: Point, height: Point, radius: Fraction) -> Surface:
    """The cylinder about a vector."""
    along = [i for i in range(3) if height[i]]
    if len(along) == 1:
        x, y, z = (_ZERO if i == along[0] else value for i, value in enumerate(base))
        return RoundSurface(along[0], (x, y, z), radius)
    if not along:
        raise ValueError("a vector must not be zero")
    across = total(UNIT, outer(height), -1 / dot(height, height))
    return quadric(across, (_ZERO, _ZERO, _ZERO), -(radius**2), base)


def _trc(numbers: Numbers) -> Form:
    base, height = _vectors(numbers[:6])
    first, last = numbers[6:]
    if min(first, last) < 0 or first == last == 0:
        raise ValueError("the radii of trc must be >= 0, and one of them > 0")
    ends = _ends(height, base)
    if first == last:
        return Form((_round(base, height, first), *ends), True)
    square, step = dot(height, height), last - first
    # |q|² - (q·H)²/H² = (R1 + (R2 - R1) q·H/H²)²
    matrix = total(UNIT, outer(height), -1 / square - (step / square) ** 2)
    return Form((quadric(matrix, scaled(height, -2 * first * step / square), -(first**2), base), *ends), True)


def _rec(numbers: Numbers) -> Form:
    """Two half axes, or one and the length of the other."""
    base, height, major = _vectors(numbers[:9])
    minor = point(numbers[9:]) if len(numbers) == 12 else cross(height, major)
    if not (any(height) and any(major) and any(minor)):
        raise ValueError("a vector must not be zero")
    _check_across(height, major, minor)
    if len(numbers) == 12:
        other = 1 / dot(minor, minor) ** 2
    else:
        other = 1 / (dot(minor, minor) * positive("radius", numbers[9]) ** 2)
    matrix = total(times(outer(major), 1 / dot(major, major) ** 2), outer(minor), other)
    return Form((quadric(matrix, (_ZERO, _ZERO, _ZERO), Fraction(-1), base), *_ends(height, base)), True)


def _ell(numbers: Numbers) -> Form:
    """By foci and half of the long axis, or by the centre, half of the long axis and the other radius, negative."""
    a, b = _vectors(numbers[:6])
    radius = numbers[6]
    if radius > 0:
        center, along = scaled(plus(a, b), Fraction(1, 2)), scaled(plus(b, a, -1), Fraction(1, 2))
        long, short = radius**2, radius**2 - dot(along, along)
        if short <= 0:
            raise ValueError("ell: half of the long axis must be greater than the way from the centre to a focus")
    elif radius < 0 and any(b):
        center, along, long, short = a, b, dot(b, b), radius**2
    else:
        raise ValueError("ell: neither the radius nor the axis may be zero")
    if not any(along) or long == short:
        if long == short and radius < 0:
            return Form((RoundSurface(None, center, -radius),))
        return Form((RoundSurface(None, center, radius),))
    size = dot(along, along)
    matrix = total(times(UNIT, 1 / short), outer(along), (1 / long - 1 / short) / size)
    return Form((quadric(matrix, (_ZERO, _ZERO, _ZERO), Fraction(-1), center),))


def _rhp(numbers: Numbers) -> Form:
    """A hexagonal prism by its height and the ways to three of its sides; two of them may follow from the first."""
    base, height, r, *others = _vectors(numbers)
    if others:
        s, t = others
    else:
        _check_across(height, r)
        if not any(height):
            raise ValueError("a vector must not be zero")
        across = scaled(cross(height, r), 1 / _length(height))
        s = plus(scaled(r, Fraction(1, 2)), across, _ROOT_3_4)
        t = plus(s, r, -1)
    facets = [_facet(scaled(v, sign), plus(base, v, sign)) for v in (r, s, t) for sign in (1, -1)]
    return Form((*facets, *_ends(height, base)), True)


def _length(vector: Point) -> Fraction:
    along = [abs(value) for value in vector if value]
    return along[0] if len(along) == 1 else Fraction(root(dot(vector, vector)))


def _wed(numbers: Numbers) -> Form:
    corner, a, b, height = _vectors(numbers)
    _check_across(a, height)
    _check_across(b, height)
    slant = cross(height, plus(b, a, -1))
    if dot(slant, a) < 0:
        slant = scaled(slant, -1)
    facets = [_facet(slant, plus(corner, a))]
    for u, v, inward in ((b, height, a), (a, height, b)):
        normal = cross(u, v)
        facets.append(_facet(scaled(normal, -1 if dot(normal, inward) > 0 else 1), corner))
    top = cross(a, b)
    if dot(top, height) < 0:
        top = scaled(top, -1)
    facets += [_facet(top, plus(corner, height)), _facet(scaled(top, -1), corner)]
    if not dot(slant, a):
        raise ValueError("wed: its vectors lie in a plane")
    return Form(tuple(facets), True)


def _arb(numbers: Numbers) -> Form:
    """Eight corners and six sides, each by the digits of its three or four corners."""
    corners = _vectors(numbers[:24])
    sides = [str(int(value)).rstrip("0") for value in numbers[24:] if value]
    if not all(value.denominator == 1 and value >= 0 for value in numbers[24:]):
        raise ValueError("arb: a side is given by the digits of its corners")
    if len(sides) < 4 or any(not 3 <= len(side) <= 4 or set(side) - set("12345678") for side in sides):
        raise ValueError("arb: has four to six sides, each given by the digits of three or four corners, 1 to 8")
    used = [corners[int(n) - 1] for n in sorted(set("".join(sides)))]
    middle = (sum((p[0] for p in used), _ZERO), sum((p[1] for p in used), _ZERO), sum((p[2] for p in used), _ZERO))
    middle = scaled(middle, Fraction(1, len(used)))
    size = max(dot(plus(p, middle, -1), plus(p, middle, -1)) for p in used)
    facets = []
    for side in sides:
        a, b, c, *rest = (corners[int(n) - 1] for n in side)
        normal = cross(plus(b, a, -1), plus(c, a, -1))
        if not any(normal):
            raise ValueError(f"arb: the corners of the side {side} lie on a line")
        if dot(normal, plus(middle, a, -1)) > 0:
            normal = scaled(normal, -1)
        slack = CROOKED * Fraction(root(dot(normal, normal) * size))
        if any(abs(dot(normal, plus(p, a, -1))) > slack for p in rest):
            raise ValueError(f"arb: the corners of the side {side} do not lie in a plane")
        if any(dot(normal, plus(p, a, -1)) > slack for p in used):
            raise ValueError(f"arb: must be convex, there are corners beyond the side {side}")
        facets.append(_facet(normal, a))
    return Form(tuple(facets), True)


MACROBODIES: dict[str, Kind] = {
    "rpp": ((6,), _rpp), "box": ((9, 12), _box), "rcc": ((7,), _rcc), "trc": ((8,), _trc), "rec": ((10, 12), _rec),
    "ell": ((7,), _ell), "rhp": ((9, 15), _rhp), "hex": ((9, 15), _rhp), "wed": ((12,), _wed), "arb": ((30,), _arb),
}  # fmt: skip
