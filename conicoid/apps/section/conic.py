"""The exact intersection of a surface with the plane of a window: a conic, and the curves that it consists of.

A conic is A s² + 2 B st + C t² + 2 D s + 2 E t + F with integer coefficients; s and t are in sides of the window, from
its middle. For irrational surfaces the coefficients are known to thousands of bits (`prepare/prepared_scene.py`),
and a number that cannot be distinguished from zero is zero. So rounding does not decide the kind of a conic, and
coincident conics compare as equal.
"""

from __future__ import annotations

import math
from dataclasses import replace
from fractions import Fraction
from math import isqrt
from typing import Any, TypeAlias

import numpy as np

from ..._util.records import dataclass
from ...geometry.exact_crossings import IntegerForm
from ...kernels.tables import PLANE, SPHERE
from ...numerics.rational import dot3, is_certain, minus
from ...prepare.prepared_scene import PreparedScene
from .curve import Curve, Ellipse, Graph, Hyperbola, Pair, StraightLine
from .window import Window

Six: TypeAlias = tuple[int, int, int, int, int, int]
Floats6: TypeAlias = tuple[float, float, float, float, float, float]
Fractions6: TypeAlias = tuple[Fraction, Fraction, Fraction, Fraction, Fraction, Fraction]

_FAR = 64
"""Sizes of the window beyond which the centre of a conic is far from it, or its half-axis long."""
_THIN, _LEAST, _OPEN = 1e-3, 4e-16, 1e-6
"""Half-axes, in sizes of the window, below which a hyperbola is almost two lines; those that it has at least, which
moves it by less than rounding; and the distance from its vertex within which its pieces stand for themselves."""
_KEY = 80
"""Bits of the numbers by which curves are compared."""
_BITS = 2048
_CUT = 400
"""For irrational conics: bits of the coefficients, and bits below which a determinant is zero. A shape turned by 1e-100
degrees has coefficients that are 2^-680 of the largest, and both terms of a determinant may be as small."""
_QUICK = 30
"""For conics from rounded records: bits below which a determinant is not known."""


class UnclearConicError(Exception):
    """Raised for a conic that is not known well enough to decide its kind."""


@dataclass(frozen=True)
class PlaneConic:
    """A surface in the plane of a window."""

    exact: Six
    """The coefficients A to F."""
    rounded: bool
    """Whether the coefficients are truncated."""
    sides: tuple[float, float]
    """Lengths of the sides of the window: the units of s and t."""
    quick: bool = False
    """Whether the coefficients come from a record. Then a number near zero raises `UnclearConicError`."""

    @property
    def floats(self) -> Floats6:
        """Coefficients for lengths from the middle, scaled so that the largest of `exact` becomes 1."""
        across, up = self.sides
        largest = max(map(abs, self.exact))
        a, b, c, d, e, f = (x / largest for x in self.exact)
        return a / across / across, b / across / up, c / up / up, d / across, e / up, f

    @property
    def is_everywhere(self) -> bool:
        """Whether the plane lies in the surface."""
        return not any(self.exact)

    @property
    def constant_sign(self) -> float:
        """The sign beside the points where it vanishes, of a conic that has no curves near the window."""
        a, b, c, _, _, f = self.exact
        # A hyperbola has both signs, and in the window that of its middle; others touch it, or vanish nowhere
        lead = f if self._difference(a * c, b * b) < 0 else a or c or f
        return 1.0 if lead > 0 else -1.0

    def curves(self) -> list[Curve]:
        """Return the curves along which the conic changes its sign: no isolated points, and no double lines."""
        a, b, c, d, e, f = self.exact
        if not (a or b or c):
            return [self._line((2 * d, 2 * e, f))] if d or e else []
        # det > 0: ellipse; = 0: parabola, or parallel lines; < 0: hyperbola, or lines that cross.
        det = self._difference(a * c, b * b)
        whole = a * (c * f - e * e) - b * (b * f - e * d) + d * (b * e - c * d)
        # The largest term bounds the rounding error of the determinant.
        terms = max(map(abs, (a * c * f, a * e * e, b * b * f, b * e * d, d * d * c)))
        if self._vanishes(whole, terms):
            whole = 0
        if whole == 0:
            pair = self._parallel() if det == 0 else self._crossing(det) if det < 0 else []
            return [self._line(numbers) for numbers in pair]
        return self._graphs("parabola") if det == 0 else self._central(det, whole)

    def _difference(self, x: int, y: int) -> int:
        """Return x - y, or 0 if the difference cannot be distinguished from zero."""
        return 0 if self._vanishes(x - y, max(abs(x), abs(y))) else x - y

    def _vanishes(self, x: int, terms: int) -> bool:
        """Return whether a sum counts as zero, given its largest term. Raise UnclearConicError if that is not known."""
        if not self.rounded:
            return x == 0
        if self.quick and terms and abs(x) << _QUICK <= terms:
            raise UnclearConicError
        return abs(x) << _CUT <= terms

    def _line(self, numbers: tuple[int, int, int]) -> Curve:
        """Return the line p s + q t + r = 0."""
        across, up = self.sides
        largest = max(map(abs, numbers))
        p, q, r = (x / largest for x in numbers)
        return StraightLine(("line", *conic_key(numbers)), (0.0, 0.0, 0.0, p / across / 2, q / up / 2, r))

    def _parallel(self) -> list[tuple[int, int, int]]:
        """Return the two parallel lines of a conic with A C = B²; none for a double line, where no sign changes."""
        a, b, c, d, e, f = self.exact
        # Along the variable with the larger square: lead x² + 2 shift x + f.
        first = abs(a) >= abs(c)
        lead, shift = (a, d) if first else (c, e)
        disc = self._difference(shift * shift, lead * f)
        if disc <= 0:
            return []
        bits = 2 * _BITS
        # An integer square root, scaled by 2^bits, keeps the coefficients of the lines integers.
        root = isqrt(disc << (2 * bits))
        p, q = (a, b) if first else (b, c)
        return [(p << bits, q << bits, (shift << bits) + turn * root) for turn in (1, -1)]

    def _crossing(self, det: int) -> list[tuple[int, int, int]]:
        """Return the two lines that cross at the centre of a degenerate conic, each a linear factor of it."""
        a, b, c, d, e, _ = self.exact
        bits = 2 * _BITS
        root, one = isqrt(-det << (2 * bits)), 1 << bits
        at_s, at_t = b * e - c * d, b * d - a * e  # divided by det: the centre
        if a:
            rows = [(a << bits, (b << bits) + turn * root) for turn in (1, -1)]
        else:
            # For A = 0 the quadratic part is t (2 B s + C t).
            rows = [(0, one), (2 * b << bits, c << bits)]
        return [(p * det, q * det, -(p * at_s + q * at_t)) for p, q in rows]

    def _axes(self) -> tuple[float, float, float, float, float]:
        """Return (larger eigenvalue, smaller one, cosine, sine of the larger one's axis, sum) of the quadratic part.

        Each is rounded only a few times: differences that cancel are computed exactly.
        """
        a, b, c, *_ = self.exact
        # Sides in a power of two near them, which changes no rounding: squares of tiny ones would overflow.
        power = math.frexp(max(self.sides))[1]
        (across, up), unit = _binary([math.ldexp(side, -power) for side in self.sides])
        # The terms over one denominator: quotients of integers are rounded once.
        first, last, mixed = (value * unit * unit for value in (a * up * up, c * across * across, b * across * up))
        size = max(map(abs, self.exact)) * (across * up) ** 2
        mean, half, b2 = (first + last) / size / 2, (first - last) / size / 2, mixed / size
        radius = math.hypot(half, b2)
        angle = 0.5 * math.atan2(b2, half)
        most = mean + math.copysign(radius, mean)
        # The smaller eigenvalue is the determinant over the larger one: a difference would cancel.
        other = (first * last - mixed * mixed) / (size * size) / most if most else -radius
        if mean < 0:
            angle += math.pi / 2
        most, other, total = (math.ldexp(value, -2 * power) for value in (most, other, 2 * mean))
        return most, other, math.cos(angle), math.sin(angle), total

    def _central(self, det: int, whole: int) -> list[Curve]:
        """Return an ellipse, or both branches of a hyperbola."""
        a, b, c, d, e, _ = self.exact
        across, up = self.sides
        at_s, at_t = _quotient(b * e - c * d, det), _quotient(b * d - a * e, det)
        center = at_s * across, at_t * up
        at_center = _quotient(whole, det * max(map(abs, self.exact)))
        first, other, cosine, sine, _ = self._axes()
        if first == 0.0:
            return []
        # The squares of the half-axes; one is negative for a hyperbola.
        squares = -at_center / first, -at_center / other if other else math.inf
        if det > 0 and min(squares) <= 0:
            return []
        r, s = (math.sqrt(abs(square)) for square in squares)
        axes = (cosine, sine), (-sine, cosine)
        size, far = math.hypot(across, up), math.hypot(*center)
        is_thin = det < 0 and max(r, s) < _THIN * size
        if is_thin:
            # Lines that all but cross: their centre is in the window, or the parts in it are graphs.
            far = far if far < size else math.inf
            grown = max(1.0, _LEAST * size / max(r, s))
            r, s = grown * r, grown * s
        if max(far, r, s) > _FAR * size:
            return self._graphs("ellipse", (center, axes[0], (r, s))) if det > 0 else self._graphs("hyperbola")
        floats, key = self.floats, conic_key(self.exact)
        if det > 0:
            return [Ellipse(("conic", *key), floats, center, axes[0], (r, s))]
        main = 0 if squares[0] > 0 else 1
        x, y = axes[main]
        radii = (s, r) if main else (r, s)
        return [
            Hyperbola(
                (f"branch {k}", *key), floats, center, (turn * x, turn * y), radii, _OPEN * size if is_thin else 0.0
            )
            for k, turn in enumerate(_in_order(x, y))
        ]

    def _graphs(self, kind: str, whole: tuple[Pair, Pair, Pair] | None = None) -> list[Curve]:
        """Return the parts near the window of a conic without a centre there, as graphs over lines."""
        unit = math.hypot(*self.sides)
        c, b, a, e, d, f = map(float, self._in_frame((0.0, 0.0), (1.0, 0.0), unit))
        _, _, x, y, _ = self._axes()
        slope, base = math.hypot(d, e), (0.0, 0.0)
        is_steep = slope > 4 * abs(a * x * x + 2 * b * x * y + c * y * y)
        if is_steep:
            # The gradient hardly turns in the window, so the curve is one graph over a line across it.
            x, y = d / slope, e / slope
        else:
            # The axis in which the conic is a parabola, or two lines, to first order: so y = 0 is in its middle.
            if (x if abs(x) > 0.65 else y) < 0:  # equal for equal conics
                x, y = -x, -y
            middle = -unit * (d * x + e * y) / (a * x * x + 2 * b * x * y + c * y * y)
            base = middle * x, middle * y
        axis = y, -x
        numbers = self._in_frame(base, axis, unit)
        signs = [math.copysign(1.0, numbers[3])]
        if not is_steep:
            square, linear, constant = _discriminant(numbers)
            ends = square - linear + constant, square + linear + constant
            if max(ends) <= 0:
                return []
            signs = [1.0, -1.0]
            if min(ends) <= 0:
                # The apex is near: a graph over the other axis.
                a2, b2, c2, d2, e2, f2 = numbers
                axis, numbers = (x, y), (c2, -b2, a2, -e2, d2, f2)
                signs = [math.copysign(1.0, numbers[3])]
        p, q, r = map(float, _discriminant(numbers))
        a, b, c, d, e, f = map(float, numbers)
        key = conic_key(self.exact)
        return [
            Graph((f"part {k}", *key), self.floats, kind, base, axis, unit, (a, b, c, d, e, f), (p, q, r), sign, whole)
            for k, sign in enumerate(signs)
        ]

    def _in_frame(self, base: Pair, axis: Pair, unit: float) -> Fractions6:
        """Return the coefficients at base + unit (t axis + y (axis turned to the left)): of y², 2 ty, t², 2 y, 2 t, 1.

        They are exact, for the largest of `exact` as 1 or -1, and of the sign for which the larger square is positive.
        """
        across, up = map(Fraction, self.sides)
        a, b, c, d, e, f = self.exact
        largest = max(map(abs, self.exact)) * (1 if a + c >= 0 else -1)
        x, y, long = Fraction(axis[0]), Fraction(axis[1]), Fraction(unit)
        s, t = Fraction(base[0]) / across, Fraction(base[1]) / up
        (i, j), (k, m) = (x * long / across, y * long / up), (-y * long / across, x * long / up)
        by_s, by_t = a * s + b * t + d, b * s + c * t + e
        values = (
            a * k * k + 2 * b * k * m + c * m * m, a * i * k + b * (i * m + j * k) + c * j * m,
            a * i * i + 2 * b * i * j + c * j * j, by_s * k + by_t * m, by_s * i + by_t * j,
            by_s * s + by_t * t + d * s + e * t + f,
        )  # fmt: skip
        one, two, three, four, five, six = (value / largest for value in values)
        return one, two, three, four, five, six


def _discriminant(numbers: Fractions6) -> tuple[Fraction, Fraction, Fraction]:
    """Return the coefficients of t², t and 1 in a quarter of the discriminant of a conic by y."""
    a, b, c, d, e, f = numbers
    return b * b - a * c, 2 * (b * d - a * e), d * d - a * f


def _quotient(above: int, below: int) -> float:
    """Return the float nearest to a quotient, infinite beyond the largest."""
    try:
        return above / below
    except OverflowError:
        return math.inf if (above > 0) == (below > 0) else -math.inf


def _in_order(x: float, y: float) -> tuple[float, float]:
    """Return the two signs of a direction, first the one that makes it point to the right, or up."""
    return (1.0, -1.0) if (x, y) > (0.0, 0.0) else (-1.0, 1.0)


def conic_key(numbers: tuple[int, ...]) -> tuple[int, ...]:
    """Return a key that is equal for proportional coefficients, also with the opposite sign."""
    largest = max(map(abs, numbers))
    # The first coefficient that is largest up to rounding, so that equal conics take the same one.
    lead = next(x for x in numbers if abs(x) << 100 >= largest * ((1 << 100) - 1))
    return tuple(_rounded(x << _KEY, lead) for x in numbers)


def _rounded(above: int, below: int) -> int:
    """Return the integer nearest to a quotient."""
    return (2 * above + below) // (2 * below)


def cut_conic(form: IntegerForm, window: Window, exact: Any) -> PlaneConic:
    """Return the conic of an exact form in the plane of a window; `exact` is window.exact()."""
    middle, u, v, unit = exact
    values = _on_plane(form.coefficients, middle, u, v, unit)
    if form.off is None:
        common = math.gcd(*values) or 1
        return PlaneConic(as_six([x // common for x in values]), False, window.size)
    # The error of each coefficient follows from the errors of the form by the same formula in sizes.
    sizes = [tuple(map(abs, part)) for part in (middle, u, v)]
    off = _on_plane(form.off, sizes[0], sizes[1], sizes[2], unit)
    certain = [x if is_certain(x, o) else 0 for x, o in zip(values, off, strict=True)]
    # Equal truncation of all coefficients to _BITS bits; towards zero, so that the sign does not matter.
    spare = max(0, max(abs(x).bit_length() for x in certain) - _BITS)
    return PlaneConic(as_six([x >> spare if x >= 0 else -(-x >> spare) for x in certain]), True, window.size)


def _on_plane(form: Any, o: Any, u: Any, v: Any, unit: int) -> list[int]:
    """Return the coefficients A to F of a form at (o + s u + t v) / unit, times unit²."""
    xx, yy, zz, xy, xz, yz, x, y, z, one = form

    def half_gradient(p: Any) -> tuple[int, int, int]:
        return xx * p[0] + xy * p[1] + xz * p[2], xy * p[0] + yy * p[1] + yz * p[2], xz * p[0] + yz * p[1] + zz * p[2]

    def times(p: Any, q: Any) -> int:
        return int(p[0] * q[0] + p[1] * q[1] + p[2] * q[2])

    of_u, of_v, of_o, linear = half_gradient(u), half_gradient(v), half_gradient(o), (x, y, z)
    return [
        times(of_u, u), times(of_u, v), times(of_v, v), times(of_o, u) + times(linear, u) * unit,
        times(of_o, v) + times(linear, v) * unit,
        times(of_o, o) + (2 * times(linear, o) + one * unit) * unit,
    ]  # fmt: skip


def as_six(values: list[int]) -> Six:
    """Return a list of six integers as a tuple."""
    a, b, c, d, e, f = values
    return a, b, c, d, e, f


_NEAR = Fraction(1, 1 << 40)
"""Share of the largest coefficient below which a number of a conic in a rounded plane counts as zero."""


def snap_conic(conic: PlaneConic) -> PlaneConic:
    """Return the degenerate conic nearby, if there is one, for a plane through an axis that had to be rounded.

    Such a plane cuts a cylinder in an ellipse of enormous length, and a cone in a hyperbola: here both are lines.
    """
    largest = max(map(abs, conic.exact))
    a, b, c, d, e, f = (Fraction(x if abs(x) > _NEAR * largest else 0) for x in conic.exact)
    det, square = a * c - b * b, max(abs(a), abs(b), abs(c))
    if not square:
        pass
    elif abs(det) <= _NEAR * square * square:
        # A parabola, or parallel lines if its slope along its axis vanishes.
        if abs(a) >= abs(c):
            c, near = b * b / a, b * d / a
            e = near if abs(e - near) <= _NEAR * largest else e
        else:
            a, near = b * b / c, b * e / c
            d = near if abs(d - near) <= _NEAR * largest else d
    else:
        # The constant for which the conic is zero at its centre: crossing lines, or a point.
        near = (d * (c * d - b * e) + e * (a * e - b * d)) / det
        f = near if abs(f - near) <= _NEAR * largest else f
    values = a, b, c, d, e, f
    unit = math.lcm(*(value.denominator for value in values))
    return replace(conic, exact=as_six([int(value * unit) for value in values]))


# --- The fast path: conics from the records of surfaces in the tables
#
# A record holds the rounded numbers of a surface, and the tables also hold the rest that rounding removed, to 2^-106 of
# the numbers. If the numbers are floats, the rest is zero and the conic is exact. Otherwise coefficients are known to
# about 98 bits. If that does not decide whether a coefficient or a determinant is zero, the caller falls back to the
# exact form of the surface.

_OFF = 2.0**-98
"""Relative error bound of a coefficient from a rounded record."""
_SURE = 2.0**60
"""Multiples of its error bound that a coefficient must exceed; otherwise the record does not decide."""


class RecordConics:
    """Computes conics from the records of a scene's surfaces, in one window."""

    def __init__(self, scene: PreparedScene, window: Window) -> None:
        self.tables, self.rest, self.window = scene.lowered.tables, scene.lowered.rest, window
        middle, u, v, self.unit = window.exact()
        self.plane = [*middle, *u, *v]
        self.sizes = np.abs(window.corner) + np.abs(window.u) + np.abs(window.v), np.abs(window.u), np.abs(window.v)

    def conic(self, surface: int) -> PlaneConic:
        """Return the conic of a surface. Raise UnclearConicError if its record does not decide the kind."""
        kind, row = int(self.tables.surface_kind[surface]), int(self.tables.surface_row[surface])
        if kind == PLANE:
            numbers, rests = self.tables.planes[row], self.rest.planes[row]
            convert, size = _plane_conic, self._size_of_plane
        elif kind == SPHERE:
            numbers = self.tables.spheres[row]
            rests = self.rest.spheres[row] if row < len(self.rest.spheres) else np.zeros(4)
            convert, size = _sphere_conic, self._size_of_sphere
        else:
            numbers = self.tables.whole_quadrics([row])[0]
            rests = self.rest.quadrics[int(self.tables.quadrics[row, 3])]
            convert, size = _quadric_conic, self._size_of_quadric
        count = len(numbers)
        whole, below = _binary([*numbers.tolist(), *rests.tolist()])
        # One unit for the numbers and the window
        unit = max(below, self.unit)
        record = [(x + y) * (unit // below) for x, y in zip(whole[:count], whole[count:], strict=True)]
        plane = [x * (unit // self.unit) for x in self.plane]
        values, denominator = convert(record, (plane[:3], plane[3:6], plane[6:]), unit)
        is_exact = not rests.any()
        if not is_exact:
            errors = [each * _OFF * _SURE for each in size(np.abs(numbers))]
            if any(abs(_quotient(x, denominator)) <= error for x, error in zip(values, errors, strict=True) if error):
                raise UnclearConicError
        common = math.gcd(*values) or 1
        return PlaneConic(as_six([x // common for x in values]), not is_exact, self.window.size, quick=True)

    def _size_of_plane(self, numbers: Any) -> list[float]:
        """Return the sums of the sizes of the terms of A to F, to which errors are relative."""
        middle, u, v = self.sizes
        normal = numbers[:3]
        return [0.0, 0.0, 0.0, normal @ u, normal @ v, normal @ (middle + numbers[4:]) + numbers[3]]

    def _size_of_sphere(self, numbers: Any) -> list[float]:
        """Return the sums of the sizes of the terms of A to F, as `_size_of_plane` does."""
        middle, u, v = self.sizes
        offset = middle + numbers[:3]
        return [u @ u, u @ v, v @ v, u @ offset, v @ offset, offset @ offset + numbers[3] ** 2]

    def _size_of_quadric(self, numbers: Any) -> list[float]:
        """Return the sums of the sizes of the terms of A to F, as `_size_of_plane` does."""
        middle, u, v = self.sizes
        rows, s, b = numbers[3:12].reshape(3, 3), numbers[12:15], numbers[15:18]
        p, q, r = rows @ u, rows @ v, rows @ (middle + numbers[:3])
        return [
            (s * p) @ p, (s * p) @ q, (s * q) @ q, (s * p) @ r + b @ p, (s * q) @ r + b @ q,
            (s * r) @ r + 2 * (b @ r) + numbers[18],
        ]  # fmt: skip


# Coefficients A to F of a record, and their denominator. Numbers are integers, to be divided by `unit`; so are the
# vectors of the plane: the middle of the window, u and v.

_IntegerPlane: TypeAlias = tuple[list[int], list[int], list[int]]


def _plane_conic(numbers: list[int], plane: _IntegerPlane, unit: int) -> tuple[list[int], int]:
    """Return the conic of normal·(x - anchor) + above."""
    middle, u, v = plane
    normal, above, anchor = numbers[:3], numbers[3], numbers[4:]
    constant = dot3(normal, minus(middle, anchor)) + above * unit
    return [0, 0, 0, dot3(normal, u), dot3(normal, v), 2 * constant], 2 * unit**2


def _sphere_conic(numbers: list[int], plane: _IntegerPlane, unit: int) -> tuple[list[int], int]:
    """Return the conic of |x - center|² - radius²."""
    middle, u, v = plane
    offset, radius = minus(middle, numbers[:3]), numbers[3]
    constant = dot3(offset, offset) - radius * radius
    return [dot3(u, u), dot3(u, v), dot3(v, v), dot3(u, offset), dot3(v, offset), constant], unit**2


def _quadric_conic(numbers: list[int], plane: _IntegerPlane, unit: int) -> tuple[list[int], int]:
    """Return the conic of Σ s y² + 2 b y - k with y = W (x - anchor)."""
    middle, u, v = plane
    offset = minus(middle, numbers[:3])
    rows = [numbers[3 + 3 * k : 6 + 3 * k] for k in range(3)]
    squares, linear, constant = numbers[12:15], [x * unit**2 for x in numbers[15:18]], numbers[18] * unit**4
    p, q, r = ([dot3(row, part) for row in rows] for part in (u, v, offset))
    of_p, of_q, of_r = ([s * x for s, x in zip(squares, part, strict=True)] for part in (p, q, r))
    values = [
        dot3(of_p, p), dot3(of_p, q), dot3(of_q, q), dot3(of_p, r) + dot3(linear, p), dot3(of_q, r) + dot3(linear, q),
        dot3(of_r, r) + 2 * dot3(linear, r) - constant,
    ]  # fmt: skip
    return values, unit**5


def _binary(values: list[float]) -> tuple[list[int], int]:
    """Return floats as integers over a common power of two, and that power."""
    ratios = [value.as_integer_ratio() for value in values]
    common = max(below for _, below in ratios)
    return [above * (common // below) for above, below in ratios], common
