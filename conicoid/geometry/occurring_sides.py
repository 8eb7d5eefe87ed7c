"""The sides of surfaces that points of space have, decided in fractions: of three planes along a line six of eight.

Sides of s_i f_i > 0 occur nowhere if a sum of these with positive factors is negative or zero everywhere (Pólik and
Terlaky: A survey of the S-lemma, SIAM Review 49, 2007). Two kinds of sums are found: planes whose normals depend on
each other, and a quadric with a plane or with the product of two, as where a plane touches a ball, or passes a cone at
its apex.
"""

from __future__ import annotations

from collections.abc import Iterator, Sequence
from fractions import Fraction
from itertools import combinations
from typing import TypeAlias

from .exact_crossings import IntegerForm

_Row: TypeAlias = list[Fraction]
_Sides: TypeAlias = dict[int, int]  # number of a form -> its sign

_NOTHING = Fraction(1, 1 << 1000)
"""Size, where coefficients have about 1, below which a number that is known to 3000 bits counts as zero."""
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


def _matrix(form: IntegerForm) -> list[_Row]:
    """Return the symmetric matrix M of a form (p, 1)·M (p, 1), scaled to entries of up to 1."""
    most = max(map(abs, form.coefficients))
    xx, yy, zz, xy, xz, yz, x, y, z, one = (Fraction(c, most) for c in form.coefficients)
    return [[xx, xy, xz, x], [xy, yy, yz, y], [xz, yz, zz, z], [x, y, z, one]]


def _sign(value: Fraction, zero: Fraction) -> int:
    return 0 if abs(value) <= zero else (1 if value > 0 else -1)


def _sides_left_out_by_planes(planes: dict[int, _Row], zero: Fraction) -> Iterator[_Sides]:
    """Yield sides of two to four planes of which some sum is constant."""
    for size in (2, 3, 4):
        for some in combinations(planes, size):
            factors = _dependence([planes[k][:3] for k in some], zero)
            level = _sign(sum((f * planes[k][3] for f, k in zip(factors, some, strict=False)), Fraction(0)), zero)
            for sign in (1, -1):
                if factors and sign * level >= 0:
                    yield {k: -sign * _sign(f, zero) for f, k in zip(factors, some, strict=True)}


def _dependence(rows: list[_Row], zero: Fraction) -> _Row:
    """Return the factors, none of them 0, with which the rows add up to zero; nothing for none or several."""
    count = len(rows)
    # Elimination turns each row into a sum of rows, whose factors stand behind it
    rows = [[*row, *(Fraction(int(i == k)) for i in range(count))] for k, row in enumerate(rows)]
    for column in range(3):
        pivot = next((row for row in rows if _sign(row[column], zero)), None)
        if pivot is not None:
            others = [(row, row[column] / pivot[column]) for row in rows if row is not pivot]
            rows = [[a - b * share for a, b in zip(row, pivot, strict=True)] for row, share in others]
    unique = len(rows) == 1 and all(_sign(f, zero) for f in rows[0][3:])
    return rows[0][3:] if unique else []


def _sides_left_out_by_quadric(k: int, matrix: list[_Row], planes: dict[int, _Row], zero: Fraction) -> Iterator[_Sides]:
    """Yield sides of a quadric and of one or two planes, for a sum with their product that has no or every sign."""
    for i, j in combinations(planes, 2):
        u, v = planes[i], planes[j]
        product = [[u[a] * v[b] + u[b] * v[a] for b in range(4)] for a in range(4)]
        factor = _middle_factor(matrix, product, zero)
        total = _plus(matrix, product, factor)
        for sign in (1, -1) if _sign(factor, zero) else ():
            if _is_nonnegative([[sign * x for x in row] for row in total], zero):
                for side in (1, -1):
                    sides = {k: -sign, i: -sign * side * _sign(factor, zero), j: side}
                    if sides.pop(_INFINITY, 1) == 1:
                        yield sides


def _plus(matrix: list[_Row], other: list[_Row], factor: Fraction) -> list[_Row]:
    return [[a + factor * b for a, b in zip(row, its, strict=True)] for row, its in zip(matrix, other, strict=True)]


def _middle_factor(matrix: list[_Row], product: list[_Row], zero: Fraction) -> Fraction:
    """Return the factor in the middle of those for which the sum has no more than its rank; 0 for none.

    Every minor has degree two in the factor, since a product of planes has rank two.
    """
    samples = [_minors(_plus(matrix, product, Fraction(f))) for f in (-1, 0, 1)]
    for low, middle, high in reversed(list(zip(*samples, strict=True))):
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
