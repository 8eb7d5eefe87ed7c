"""Crossings of a ray with surfaces, and sides of surfaces, in exact arithmetic, where error bounds leave them open.

Surfaces become polynomials with integer coefficients; integers of any length have no rounding at all.
"""

from __future__ import annotations

import math
from collections.abc import Iterator, Sequence
from fractions import Fraction
from functools import cmp_to_key
from itertools import combinations
from typing import Any, TypeAlias

from .._util.records import dataclass
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

    @property
    def absent_terms(self) -> int:
        """Bits 0 to 5: the coefficient of xx, yy, zz, xy, xz, yz is 0, or may be, which counts as 0 (`along`)."""
        off = (0,) * 6 if self.off is None else self.off[:6]
        present = [is_certain(v, o) for v, o in zip(self.coefficients[:6], off, strict=True)]
        return sum(1 << k for k, is_present in enumerate(present) if not is_present)

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


# The sides of surfaces that points of space have
#
# Decided in fractions: of three planes along a line six of eight. Sides of s_i f_i > 0 occur nowhere if a sum of these
# with positive factors is negative or zero everywhere (Pólik and Terlaky: A survey of the S-lemma, SIAM Review 49,
# 2007). Two kinds of sums are found: planes whose normals depend on each other, and a quadric with a plane or with the
# product of two, as where a plane touches a ball, or passes a cone at its apex.

_Row: TypeAlias = list[Fraction]
_Sides: TypeAlias = dict[int, int]  # number of a form -> its sign

_NOTHING = Fraction(1, 1 << 1000)
"""Size, where coefficients have about 1, below which a number that is known to 3000 bits counts as zero."""
_KEPT = 1200
"""Bits of such numbers that are kept: all of them would take seconds."""
_INFINITY = -1
"""As the number of a plane: the one at infinity, whose product with a plane is that plane."""


def occurring_sides(forms: Sequence[IntegerForm]) -> list[int]:
    """Return the combinations of sides, bit k for form k above 0, that are not known to occur nowhere."""
    zero = _NOTHING if any(form.off is not None for form in forms) else Fraction(0)
    matrices = [_matrix(form) for form in forms]
    planes = {
        k: [2 * matrices[k][i][3] for i in range(3)] + [matrices[k][3][3]] for k, f in enumerate(forms) if f.is_flat
    }
    missing = list(_sides_left_out_by_planes(planes, zero))
    planes[_INFINITY] = [Fraction(0)] * 3 + [Fraction(1)]
    for k in range(len(forms)):
        if k not in planes:
            missing += _sides_left_out_by_quadric(k, matrices[k], planes, zero)
    return [
        bits for bits in range(1 << len(forms))
        if not any(all(side == (1 if bits >> k & 1 else -1) for k, side in sides.items()) for sides in missing)
    ]  # fmt: skip


def common_rank(forms: Sequence[IntegerForm]) -> int:
    """Return 2 for planes through one line, 3 for planes through one point: beside that all their sides occur; else 0.

    Sides of planes that occur anywhere then occur beside each common point, since they are cones there.
    """
    zero = _NOTHING if any(form.off is not None for form in forms) else Fraction(0)
    matrices = [_matrix(form) for form in forms]
    left = _eliminate([[*row[:3], row[3] / 2] for *_, row in matrices], zero)
    common = all(form.is_flat for form in forms) and not any(_sign(row[3], zero) for row in left)
    return len(forms) - len(left) if common else 0


def _matrix(form: IntegerForm) -> list[_Row]:
    """Return the symmetric matrix M of a form (p, 1)·M (p, 1), scaled to entries of up to 1."""
    most = max(map(abs, form.coefficients))
    numbers = [Fraction(c, most) for c in form.coefficients]
    if form.off is not None:
        numbers = [Fraction((c << _KEPT) // most, 1 << _KEPT) for c in form.coefficients]
    xx, yy, zz, xy, xz, yz, x, y, z, one = numbers
    return [[xx, xy, xz, x], [xy, yy, yz, y], [xz, yz, zz, z], [x, y, z, one]]


def _sign(value: Fraction, zero: Fraction) -> int:
    return 0 if abs(value) <= zero else (1 if value > 0 else -1)


def _sides_left_out_by_planes(planes: dict[int, _Row], zero: Fraction) -> Iterator[_Sides]:
    """Yield sides of two to four planes that no point has: times some factors, the planes add up to a constant."""
    for size in (2, 3, 4):
        for some in combinations(planes, size):
            factors = _dependence([planes[k][:3] for k in some], zero)
            level = _sign(sum((f * planes[k][3] for f, k in zip(factors, some, strict=False)), Fraction(0)), zero)
            for turn in (1, -1):
                if factors and turn * level >= 0:
                    yield {k: -turn * _sign(f, zero) for f, k in zip(factors, some, strict=True)}


def _dependence(rows: list[_Row], zero: Fraction) -> _Row:
    """Return the factors, none of them 0, with which the rows add up to zero; nothing for none or several."""
    count = len(rows)
    # Elimination turns each row into a sum of rows, whose factors stand behind it
    rows = _eliminate([[*row, *(Fraction(int(i == k)) for i in range(count))] for k, row in enumerate(rows)], zero)
    unique = len(rows) == 1 and all(_sign(f, zero) for f in rows[0][3:])
    return rows[0][3:] if unique else []


def _eliminate(rows: list[_Row], zero: Fraction) -> list[_Row]:
    """Return the rows left by elimination; the first three numbers of each are zero."""
    for column in range(3):
        pivot = next((row for row in rows if _sign(row[column], zero)), None)
        if pivot is not None:
            others = [(row, row[column] / pivot[column]) for row in rows if row is not pivot]
            rows = [[a - b * share for a, b in zip(row, pivot, strict=True)] for row, share in others]
    return rows


def _sides_left_out_by_quadric(k: int, matrix: list[_Row], planes: dict[int, _Row], zero: Fraction) -> Iterator[_Sides]:
    """Yield sides of a quadric and of one or two planes, for a sum with their product that has no or every sign."""
    minors = _minors(matrix)
    for i, j in combinations(planes, 2):
        u, v = planes[i], planes[j]
        product = [[u[a] * v[b] + u[b] * v[a] for b in range(4)] for a in range(4)]
        factor = _middle_factor(matrix, minors, product, zero)
        total = _plus(matrix, product, factor)
        for turn in (1, -1) if _sign(factor, zero) else ():
            if _is_nonnegative([[turn * x for x in row] for row in total], zero):
                for side in (1, -1):
                    sides = {k: -turn, i: -turn * side * _sign(factor, zero), j: side}
                    if sides.pop(_INFINITY, 1) == 1:
                        yield sides


def _plus(matrix: list[_Row], other: list[_Row], factor: Fraction) -> list[_Row]:
    return [[a + factor * b for a, b in zip(row, its, strict=True)] for row, its in zip(matrix, other, strict=True)]


def _middle_factor(matrix: list[_Row], minors: _Row, product: list[_Row], zero: Fraction) -> Fraction:
    """Return the factor in the middle of those for which the sum has no more than its rank; 0 for none.

    Every minor has degree two in the factor, since a product of planes has rank two.
    """
    lows, highs = (_minors(_plus(matrix, product, Fraction(f))) for f in (-1, 1))
    for low, middle, high in reversed(list(zip(lows, minors, highs, strict=True))):
        if _sign(low, zero) or _sign(middle, zero) or _sign(high, zero):
            bend = low + high - 2 * middle
            return (low - high) / (2 * bend) if _sign(bend, zero) else Fraction(0)
    return Fraction(0)


def _minors(matrix: list[_Row]) -> _Row:
    """Return the sums of principal minors of order 1 to 4 (Faddeev and LeVerrier's method)."""
    found: _Row = []
    power = [[Fraction(a == b) for b in range(4)] for a in range(4)]
    for order in range(1, 5):
        power = [[sum((row[i] * power[i][b] for i in range(4)), Fraction(0)) for b in range(4)] for row in matrix]
        found.append(sum((power[a][a] for a in range(4)), Fraction(0)) / order)
        power = [[found[-1] * (a == b) - power[a][b] for b in range(4)] for a in range(4)]
    return found


def _is_nonnegative(matrix: list[_Row], zero: Fraction) -> bool:
    """Return whether a quadratic form is negative nowhere, by completing squares."""
    pivot = next((k for k in range(len(matrix)) if _sign(matrix[k][k], zero)), None)
    if pivot is None:
        return not any(_sign(x, zero) for row in matrix for x in row)
    if matrix[pivot][pivot] < 0:
        return False
    row, rest = matrix[pivot], [a for a in range(len(matrix)) if a != pivot]
    return _is_nonnegative([[matrix[a][b] - row[a] * row[b] / row[pivot] for b in rest] for a in rest], zero)
