"""Crossings of a ray with surfaces in exact arithmetic, for the few rays that error bounds leave open.

Surfaces become polynomials with integer coefficients; integers of any length have no rounding at all.
"""

from __future__ import annotations

import math
from collections.abc import Sequence
from fractions import Fraction
from functools import cmp_to_key
from typing import Any

from .._util.dataclass import dataclass
from ..numerics import bigfloat as ex
from ..numerics.rational import ZERO, IntegerQuadratic, Root, compare_roots, dot, exact_real_roots, is_certain, sign
from .surface import PlaneSurface, QuadricSurface, Surface, expand_quadric

Numbers = tuple[int, int, int, int, int, int, int, int, int, int]

_RATIO = 1024
"""The largest number of bits of fractions that are sought for cut numbers (`simplest_ratio`)."""


def integers(values: Sequence[Fraction]) -> list[int]:
    """Return the values times a positive factor that makes them integers."""
    common = math.lcm(*(v.denominator for v in values))
    return [v.numerator * (common // v.denominator) for v in values]


@dataclass(frozen=True)
class IntegerLine:
    """The line (origin + t direction) / unit, in integers."""

    origin: tuple[int, ...]
    direction: tuple[int, ...]
    unit: int


def integer_line(origin: Sequence[float], direction: Sequence[float]) -> IntegerLine:
    """Return the line of a ray of floats."""
    numbers = [float(x).as_integer_ratio() for x in (*origin, *direction)]
    # Powers of two: the largest is their common multiple
    common = max(below for _, below in numbers)
    whole = [above * (common // below) for above, below in numbers]
    return IntegerLine(tuple(whole[:3]), tuple(whole[3:]), common)


@dataclass(frozen=True)
class IntegerForm:
    """The polynomial xx X² + yy Y² + zz Z² + 2 xy XY + 2 xz XZ + 2 yz YZ + 2 x X + 2 y Y + 2 z Z + one, <= 0 inside.

    The coefficients of a surface with irrational numbers have errors up to those in `off`.
    """

    coefficients: Numbers
    off: Numbers | None = None

    @property
    def is_flat(self) -> bool:
        return not any(self.coefficients[:6])

    def along(self, line: IntegerLine) -> IntegerQuadratic:
        """Return the polynomial on a ray, times a positive number. A coefficient is 0 unless it surely is not."""
        values = _along(self.coefficients, line)
        if self.off is None:
            return IntegerQuadratic(*values)
        # The same polynomial of sizes: each term grows by its error, and no sign cancels
        off = _along(self.off, IntegerLine(_sizes(line.origin), _sizes(line.direction), line.unit))
        # A coefficient that may be zero is zero, with no error left
        certain = [(v, o) if is_certain(v, o) else (0, 0) for v, o in zip(values, off, strict=True)]
        (a, off_a), (b, off_b), (c, off_c) = certain
        return IntegerQuadratic(a, b, c, (off_a, off_b, off_c))

    def at(self, line: IntegerLine) -> int:
        """Return the polynomial at the origin of a ray, times a positive number."""
        return self.along(line).c


def _sizes(values: Sequence[int]) -> tuple[int, ...]:
    return tuple(map(abs, values))


def _along(form: Numbers, line: IntegerLine) -> tuple[int, int, int]:
    """Return a, b, c of the form a t² + 2 b t + c on a line."""
    xx, yy, zz, xy, xz, yz, x, y, z, one = form
    (ox, oy, oz), (dx, dy, dz), unit = line.origin, line.direction, line.unit
    # Half the gradient, without its constant part, along the direction and at the origin
    ux, uy, uz = xx * dx + xy * dy + xz * dz, xy * dx + yy * dy + yz * dz, xz * dx + yz * dy + zz * dz
    px, py, pz = xx * ox + xy * oy + xz * oz, xy * ox + yy * oy + yz * oz, xz * ox + yz * oy + zz * oz
    a = ux * dx + uy * dy + uz * dz
    b = ux * ox + uy * oy + uz * oz + (x * dx + y * dy + z * dz) * unit
    c = px * ox + py * oy + pz * oz + (2 * (x * ox + y * oy + z * oz) + one * unit) * unit
    return a, b, c


def surface_form(surface: Surface) -> IntegerForm:
    """Return the form of a surface, in the sense of its record: the normal of a plane leads with a positive number."""
    if isinstance(surface, PlaneSurface):
        sense = -1 if next(float(n) for n in surface.normal if float(n)) < 0 else 1
        numbers = [0] * 6 + [sense * n for n in surface.normal] + [-2 * sense * surface.offset]
        return _form_of_coefficients(numbers)
    # Irrational numbers: the ten coefficients may still be rational (docs/dev/exactness.md)
    if any(map(ex.is_rounded, _surface_numbers(surface))):
        return _form_of_coefficients([ex.cancelling_sum(terms) for terms in surface.terms()])
    return _quadric_form(surface)


def ball_form(center: Sequence[float], radius: float) -> IntegerForm:
    """Return the form of a ball of floats."""
    x, y, z = map(Fraction, center)
    return _integer_form([1, 1, 1, 0, 0, 0, -x, -y, -z, x * x + y * y + z * z - Fraction(radius) ** 2])


def _surface_numbers(surface: QuadricSurface) -> list[Any]:
    rows = [w for row in surface.rows for w in row]
    return [*surface.squares, *surface.linear, surface.constant, *surface.anchor, *rows]


def _integer_form(coefficients: Sequence[int | Fraction]) -> IntegerForm:
    return IntegerForm(_ten_numbers(integers([Fraction(c) for c in coefficients])))


def _form_of_coefficients(coefficients: Sequence[Any]) -> IntegerForm:
    """Return the form of ten numbers: exact if they are fractions or have such ratios, else with error bounds."""
    if not any(map(ex.is_rounded, coefficients)):
        return _integer_form([ex.fraction(c) for c in coefficients])
    numbers = [ex.exact(c) for c in coefficients]
    # Ratios to the largest, which is certainly not zero
    largest = max(numbers, key=abs)
    ratios = [Fraction(1) if n is largest else _ratio(n, largest) for n in numbers]
    if None not in ratios:
        # Only a positive factor keeps the inside
        sign = 1 if largest > 0 else -1
        return _integer_form([sign * ratio for ratio in ratios if ratio is not None])
    # One power of two for all ten makes them integers
    least = min(n.exponent for n in numbers)
    return IntegerForm(
        _ten_numbers([n.mantissa << (n.exponent - least) for n in numbers]),
        _ten_numbers([n.off << (n.exponent - least) for n in numbers]),
    )


def _ratio(number: ex.BigFloat, other: ex.BigFloat) -> Fraction | None:
    """Return number / other if it is a fraction of at most `_RATIO` bits, else None."""
    if not number.mantissa and not number.off:
        return Fraction(0)
    return ex.simplest_ratio(number / other, _RATIO)


def _quadric_form(surface: QuadricSurface) -> IntegerForm:
    squares, linear, anchor, *rows = (
        tuple(map(ex.fraction, each)) for each in (surface.squares, surface.linear, surface.anchor, *surface.rows)
    )
    shift = [-dot(row, anchor) for row in rows]
    return _integer_form(expand_quadric(squares, linear, ex.fraction(surface.constant), rows, shift, Fraction(0)))


def _ten_numbers(values: Sequence[int]) -> Numbers:
    a, b, c, d, e, f, x, y, z, w = values
    return a, b, c, d, e, f, x, y, z, w


# The order of crossings along a ray

RayPlace = Root | float  # a root, or an infinity


@dataclass(frozen=True)
class CrossingVerdict:
    """How a ray crosses a surface.

    `sense` is the sign of the quadratic coefficient, of the rate at a plane, or of the value if there is no crossing.
    `low` and `high` are the places of the crossings, or both that of a touch, which is no crossing.
    """

    crosses: bool
    sense: int
    low: RayPlace = 0.0
    high: RayPlace = 0.0
    touches: bool = False


def decide_crossing(form: IntegerForm, line: IntegerLine, starts: bool) -> CrossingVerdict:
    """Return the verdict on a surface. If the ray `starts` on it, the root nearest to t = 0 is exactly 0."""
    q = form.along(line)
    if form.is_flat:
        return _decide_plane(sign(q.b), sign(q.c), starts, exact_real_roots(q))
    roots = exact_real_roots(q)
    touches = not roots and q.a != 0 and q.discriminant == 0 and not starts
    # -b / a
    middle = exact_real_roots(IntegerQuadratic(0, q.a, 2 * q.b, (0, q.off[0], 2 * q.off[1]))) if touches else ()
    if middle:
        return CrossingVerdict(False, sign(q.a), middle[0], middle[0], True)
    if not roots:
        return CrossingVerdict(False, sign(q.a) or sign(q.c))
    if len(roots) == 1:
        t = ZERO if starts else roots[0]
        return CrossingVerdict(True, 0, t, math.inf) if q.b < 0 else CrossingVerdict(True, 0, -math.inf, t)
    low, high = roots
    if starts:
        # One root is 0, and the sum low + high = -2 b / a has the sign of the other
        if q.b == 0:
            return CrossingVerdict(False, sign(q.a))
        low, high = (ZERO, high) if (q.b < 0) == (q.a > 0) else (low, ZERO)
    return CrossingVerdict(True, sign(q.a), low, high)


def _decide_plane(rate: int, height: int, starts: bool, roots: Sequence[Root]) -> CrossingVerdict:
    if rate == 0:
        return CrossingVerdict(False, 0 if starts else height)
    t = ZERO if starts else roots[0]
    return CrossingVerdict(True, rate, t, t)


def exact_ranks(places: Sequence[RayPlace]) -> list[float]:
    """Return the rank of each place along a ray: equal for equal places, 0 for the first one, the ray's origin.

    Floats around the places separate most of them. Only places whose floats overlap are compared exactly, and equal
    names count as one place: a ray may cross hundreds of surfaces in one point.
    """
    one: dict[Any, RayPlace] = {}
    distinct = [one.setdefault(_place_name(place), place) for place in places]
    order = sorted(one.values(), key=_least)
    rank: dict[int, float] = {}
    begin, so_far = 0, 0.0
    while begin < len(order):
        end, most = begin + 1, _most(order[begin])
        while end < len(order) and _least(order[end]) <= most:
            most = max(most, _most(order[end]))
            end += 1
        # Exact comparisons only within a group whose floats overlap
        near = sorted(order[begin:end], key=cmp_to_key(_compare))
        for k, place in enumerate(near):
            so_far += 1.0 if k == 0 or _compare(near[k - 1], place) != 0 else 0.0
            # By id: roots of one name are one object by now
            rank[id(place)] = so_far
        begin = end
    zero = rank[id(distinct[0])]
    return [rank[id(place)] - zero for place in distinct]


def _place_name(place: RayPlace) -> Any:
    """Return a key that is the same for places that are known to be equal."""
    if isinstance(place, float):
        return place
    return id(place) if place.name is None else place.name


def _least(place: RayPlace) -> float:
    return place if isinstance(place, float) else place.ends[0]


def _most(place: RayPlace) -> float:
    return place if isinstance(place, float) else place.ends[1]


def _compare(x: RayPlace, y: RayPlace) -> int:
    if isinstance(x, float) or isinstance(y, float):
        a, b = (value if isinstance(value, float) else 0.0 for value in (x, y))
        return (a > b) - (a < b)
    return compare_roots(x, y)


# Polygons


def side_of_loop(corners: Sequence[ex.Row], origin: Sequence[float], direction: Sequence[float]) -> tuple[bool, bool]:
    """Return (a ray passes inside a loop of `corners`, through an edge), as `kernels/surface/polygon_loop.py`.

    Each corner is three exact numbers. Sums that cannot be distinguished from zero count as zero.
    """
    sizes = [abs(d) for d in direction]
    axis = 2 if sizes[2] >= max(sizes[0], sizes[1]) else (0 if sizes[0] >= sizes[1] else 1)
    first, second = ((1, 2), (2, 0), (0, 1))[axis]
    o, d = ex.exact_row(origin), ex.exact_row(direction)
    projected = [
        tuple(ex.dot((d[axis], -d[axis], -d[k], d[k]), (p[k], o[k], p[axis], o[axis])) for k in (first, second))
        for p in map(ex.exact_row, corners)
    ]
    odd = edge = False
    ua, va = projected[-1]
    for ub, vb in projected:
        if (va < 0) != (vb < 0):
            side = ex.dot((ua, -ub), (vb, va))
            odd ^= side > 0 if vb > va else side < 0
            edge |= side == 0
        elif vb == 0:
            edge |= ub == 0 or (va == 0 and (ua < 0) != (ub < 0))
        ua, va = ub, vb
    return odd, edge
