"""A general quadric on its principal axes: directions, center or vertex, in exact arithmetic.

xᵀA x + 2 b·x + c becomes Σ λ_i y_i² + 2 Σ β_i y_i + γ with y = W (x - anchor). The rows of W are the unit
eigenvectors of A, and β_i = 0 if the anchor can be at the center along axis i.

Floats find the eigenvalues, their order and the sign of each direction (Jacobi). Newton's steps refine the eigenvalues,
and their residuals bound the error: in 3,000 bits, or in the numbers of a recording. So the axes of many quadrics
are computed together. Eigenvalues that floats cannot separate take mpmath.
"""

from __future__ import annotations

import functools
from collections.abc import Iterator, Sequence
from contextlib import contextmanager
from fractions import Fraction
from functools import cache, lru_cache
from typing import Any, TypeAlias

from .._util.process import fork_safe_rlock
from ..numerics import bigfloat as ex
from ..numerics.bigfloat import Symbol
from ..numerics.portable_math import (
    leading_sign,
    negative_indicator,
    portable_max,
    portable_sqrt,
    select_if_several,
)
from ..numerics.rational import row_echelon
from .surface import UPRIGHT, QuadricSurface, Triples

Symmetric: TypeAlias = tuple[tuple[Fraction, ...], ...]

_WEAK = 1024
"""An axis whose eigenvalue is so many times less than another may keep its linear term."""
_FAR_CENTER = 1024
"""The anchor does not move to a center so many times farther away than the part near the origin."""


def principal_quadric(matrix: Symmetric) -> QuadricSurface:
    """Return the surface (x, 1) matrix (x, 1)ᵀ = 0 on its principal axes; its second-order part is not zero."""
    values, rows = eigen_decomposition(matrix)
    first = (matrix[0][3], matrix[1][3], matrix[2][3])
    if rows is UPRIGHT:
        slopes = [ex.exact(value) for value in first]
    else:
        slopes = [ex.dot(row, ex.exact_row(first)) for row in rows]
    squares = [ex.exact(value) for value in values]
    place, linear, constant = _anchor(squares, slopes, ex.exact(matrix[3][3]))
    anchor = place if rows is UPRIGHT else tuple(ex.dot(column, place) for column in ex.transpose(rows))
    return QuadricSurface(
        (values[0], values[1], values[2]),
        (linear[0], linear[1], linear[2]),
        -constant,
        rows,
        (anchor[0], anchor[1], anchor[2]),
    )


def eigen_decomposition(matrix: Symmetric, rank: int | None = None) -> tuple[list[ex.Writable], Triples]:
    """Return the eigenvalues and unit eigenvectors (rows) of the second-order part; those of a diagonal one are exact.

    Parameters
    ----------
    matrix : Symmetric
        The 4 × 4 matrix of the quadric.
    rank : int, optional
        The rank of the second-order part, if its entries are rounded. It is computed from exact entries.
    """
    a = [list(row[:3]) for row in matrix[:3]]
    if not (a[0][1] or a[0][2] or a[1][2]):
        return [a[0][0], a[1][1], a[2][2]], UPRIGHT
    if any(isinstance(entry, Symbol) for row in a for entry in row):
        found = _distinct_axes(a)
        if found is None:
            raise TypeError("a recording cannot separate these eigenvalues")
    else:
        found = _known_axes(tuple(map(tuple, a)), rank)
    return list(found[0]), found[1]


@lru_cache(maxsize=256)
def _known_axes(a: Symmetric, rank: int | None) -> tuple[list[ex.Writable], Triples]:
    """`eigen_decomposition`, once for each second-order part: the places of a lattice share it."""
    values, rows = _distinct_axes(a) or _mpmath_axes(a, rank)
    if rank is not None:
        for k in sorted(range(3), key=lambda k: abs(ex.exact(values[k])))[: 3 - rank]:
            values[k] = ex.ZERO
    return values, rows


# Eigenvalues that floats separate

_SWEEPS = 4
"""Jacobi's method doubles its digits in each sweep, and more."""
_APART = 2.0**-20
"""Floats separate eigenvalues that differ by more than this share of the largest entry."""
_TINY = 1e-300
"""Keeps a tangent of 0 / 0 from being no number, and changes no other."""
_NEWTON_STEPS, _FIRST_BITS = 8, 128
"""Each step doubles some 33 digits; a float's 53, less those of `_APART`."""
_RECORDED_STEPS = 3


def _distinct_axes(matrix: Sequence[Sequence[Any]]) -> tuple[list[ex.Writable], Triples] | None:
    """Return eigenvalues and unit eigenvectors of a symmetric matrix, or None where floats cannot separate them."""
    a = ex.exact_row(matrix[0]), ex.exact_row(matrix[1]), ex.exact_row(matrix[2])
    recorded = any(isinstance(entry, Symbol) for row in a for entry in row)
    floats = [[ex.rounded(entry) for entry in row] for row in a]
    size = functools.reduce(portable_max, (abs(entry) for row in floats for entry in row))
    starts, low, high = _float_axes(floats)
    if not (high > _APART * size and low > _APART * size):
        return None
    minors = [ex.dot((a[i][i], -a[i][j]), (a[j][j], a[i][j])) for i, j in ((0, 1), (0, 2), (1, 2))]
    trace = ex.cancelling_sum((a[0][0], a[1][1], a[2][2]))
    polynomial = trace, ex.cancelling_sum(minors), ex.determinant(a)
    upright = [_coordinate_axis(a, start[1:]) for start in starts]
    roots = [
        _refined_root(ex.exact(start[0]), polynomial, recorded) if axis is None else a[axis][axis]
        for start, axis in zip(starts, upright, strict=True)
    ]
    # As near to its start as no other: three starts have three roots
    if any(
        axis is None and abs(root - ex.exact(start[0])) * 4 > ex.exact(_APART * size)
        for root, start, axis in zip(roots, starts, upright, strict=True)
    ):
        return None
    rows = []
    for k, ((_, *start), axis) in enumerate(zip(starts, upright, strict=True)):
        if axis is not None:
            rows.append(UPRIGHT[axis])
            continue
        along = ex.exact_row(start)
        share = ex.ONE
        for other in (roots[k - 1], roots[k - 2]):
            along = ex.minus(ex.apply(a, along), (other * along[0], other * along[1], other * along[2]))
            share = share * (roots[k] - other)
        x, y, z = ex.unit((along[0] / share, along[1] / share, along[2] / share))
        rows.append((ex.settled(x), ex.settled(y), ex.settled(z)))
    return [ex.settled(root) for root in roots], (rows[0], rows[1], rows[2])


def _coordinate_axis(a: Sequence[Sequence[Any]], along: Sequence[Any]) -> int | None:
    """Return the coordinate axis that a direction is, if that is an eigenvector: its eigenvalue is on the diagonal."""
    return next((k for k in range(3) if not (a[k][k - 1] or a[k][k - 2]) and along[k] == 1.0), None)


def _refined_root(root: Any, polynomial: tuple[Any, Any, Any], recorded: bool) -> Any:
    """Return the root of x³ - trace x² + minors x - determinant near a first guess, with a bound of its error."""
    trace, minors, determinant = polynomial

    def step(x: Any) -> Any:
        return (((x - trace) * x + minors) * x - determinant) / ((3 * x - 2 * trace) * x + minors)

    for k in range(_RECORDED_STEPS if recorded else _NEWTON_STEPS):
        root = root - step(root)
        if not recorded:
            root = ex.cut(root, min(_FIRST_BITS << k, ex.BITS + 64))
    # One of n roots lies within n steps of Newton's
    return ex.ball(root, 3 * step(root))


def _float_axes(a: list[list[Any]]) -> tuple[list[list[Any]], Any, Any]:
    """Return (eigenvalue, x, y, z) of each axis in floats, and the distances between the eigenvalues.

    The axes are in the order of the coordinates in which they are largest, and positive there; of one coordinate, in
    the order of the eigenvalues. No test depends on the numbers, so that a recording holds for all of them.
    """
    axes = [[1.0, 0.0, 0.0], [0.0, 1.0, 0.0], [0.0, 0.0, 1.0]]
    for p, q in ((0, 1), (0, 2), (1, 2)) * _SWEEPS:
        r, gap, off = 3 - p - q, a[q][q] - a[p][p], a[p][q]
        sign = leading_sign((gap,))
        tangent = sign * (2.0 * off) / (abs(gap) + portable_sqrt(gap * gap + 4.0 * (off * off)) + _TINY)
        cosine = 1.0 / portable_sqrt(1.0 + tangent * tangent)
        sine = tangent * cosine
        a[p][p], a[q][q] = a[p][p] - tangent * off, a[q][q] + tangent * off
        a[p][q] = a[q][p] = 0.0
        near, far = a[p][r], a[q][r]
        a[p][r] = a[r][p] = cosine * near - sine * far
        a[q][r] = a[r][q] = sine * near + cosine * far
        first, second = axes[p], axes[q]
        axes[p] = [cosine * x - sine * y for x, y in zip(first, second, strict=True)]
        axes[q] = [sine * x + cosine * y for x, y in zip(first, second, strict=True)]
    found = [[a[k][k], *axes[k]] for k in range(3)]
    for k in (0, 1, 0):
        found[k], found[k + 1] = _in_order(found[k], found[k + 1], found[k + 1][0] - found[k][0])
    low, high = found[1][0] - found[0][0], found[2][0] - found[1][0]
    found = [_directed(each) for each in found]
    for k in (0, 1, 0):
        found[k], found[k + 1] = _in_order(found[k], found[k + 1], found[k + 1][-1] - found[k][-1])
    return [each[:-1] for each in found], low, high


def _directed(axis: list[Any]) -> list[Any]:
    """Return (eigenvalue, x, y, z) with a positive largest coordinate, and the number of that coordinate."""
    value, x, y, z = axis
    second = negative_indicator(abs(x) - abs(y))
    third = negative_indicator(portable_max(abs(x), abs(y)) - abs(z))
    largest = select_if_several(2.0 * third, z, select_if_several(2.0 * second, y, x))
    sign = leading_sign((largest,))
    return [value, sign * x, sign * y, sign * z, select_if_several(2.0 * third, 2.0, second)]


def _in_order(a: list[Any], b: list[Any], rise: Any) -> tuple[list[Any], list[Any]]:
    """Return two rows, exchanged for a negative rise."""
    swap = 2.0 * negative_indicator(rise)
    return (
        [select_if_several(swap, y, x) for x, y in zip(a, b, strict=True)],
        [select_if_several(swap, x, y) for x, y in zip(a, b, strict=True)],
    )


# All others

_EIGENVECTOR_NOISE = ex.power_of_two(-ex.CANCELLED)
"""Entries of unit eigenvectors below this are rounding."""
_mp_lock = fork_safe_rlock()


@cache
def _mpmath() -> Any:
    """Return a context of mpmath, imported on first use: few scenes have a matrix that needs it."""
    from mpmath import MPContext

    return MPContext()


@contextmanager
def _mpmath_precision(bits: int) -> Iterator[Any]:
    """Lend mpmath at a precision to one thread at a time: all threads share its precision and cached constants."""
    with _mp_lock:
        mp = _mpmath()
        mp.prec = bits
        yield mp


def _from_mpmath(value: Any, places: int) -> ex.BigFloat:
    """Return a number of mpmath with an error below 2^-places; call it within `_mpmath_precision` of that many bits."""
    mp = _mpmath()
    scaled = int(mp.nint(mp.ldexp(value, places)))
    return ex.settled(ex.BigFloat(scaled, -places, 2))


def _mpmath_axes(a: Symmetric, rank: int | None) -> tuple[list[ex.Writable], Triples]:
    """Return `eigen_decomposition` by mpmath."""
    entries = [abs(value) for row in a for value in row if value]
    # Small eigenvalues beside large ones need more digits
    spread = (max(entries) / min(entries)).numerator.bit_length()
    scale, places = max(entries), ex.BITS + 4 * spread
    with _mpmath_precision(places + 64) as mp:
        scaled = [[v / scale for v in row] for row in a]
        eigenvalues, vectors = mp.eigsy(
            mp.matrix([[mp.mpf(v.numerator) / v.denominator for v in row] for row in scaled])
        )
        order = sorted(range(3), key=lambda k: max(range(3), key=lambda i: abs(vectors[i, k])))
        rank = len(row_echelon(list(map(list, a)), 3)[1]) if rank is None else rank
        vanishing = sorted(range(3), key=lambda k: abs(eigenvalues[k]))[: 3 - rank]
        values = [ex.ZERO if k in vanishing else _from_mpmath(eigenvalues[k], places) * scale for k in order]
        rows = tuple(tuple(_denoise_entry(_from_mpmath(vectors[i, k], ex.BITS)) for i in range(3)) for k in order)
    return values, rows  # type: ignore[return-value]


def _denoise_entry(entry: ex.BigFloat) -> ex.BigFloat:
    """Return an entry of a unit vector, 0 if it is only rounding."""
    return ex.ZERO if abs(entry) < _EIGENVECTOR_NOISE else entry


def _anchor(
    squares: list[ex.BigFloat], slopes: list[ex.BigFloat], constant: ex.BigFloat
) -> tuple[list[ex.BigFloat], list[ex.BigFloat], ex.BigFloat]:
    """Return (anchor, linear terms about it, constant about it), all along the principal axes.

    Strong axes move to their center first. Then weak and flat axes move to their center if it is near, otherwise to the
    vertex nearest to the origin, where they keep a linear term. A quadric of one sign, which is a point, a line or a
    double plane, moves to its center always: only there nothing is left but squares.
    """
    center = [-b / s if s else ex.ZERO for s, b in zip(squares, slopes, strict=True)]
    rest = ex.cancelling_sum((constant, *(b * y for b, y in zip(slopes, center, strict=True))))
    one_sign = min(squares) >= 0 or max(squares) <= 0
    if one_sign and not rest and all(s or not b for s, b in zip(squares, slopes, strict=True)):
        return center, [ex.ZERO] * 3, ex.ZERO
    place, linear = [ex.ZERO] * 3, list(slopes)
    weak = [i for i in range(3) if any(abs(squares[i]) * _WEAK < abs(squares[j]) for j in range(3) if j != i)]
    strong = [i for i in range(3) if i not in weak]
    for i in (*strong, *sorted(weak, key=lambda i: -abs(squares[i]))):
        s, b = squares[i], linear[i]
        if not b:
            continue
        y = _vertex(s, b, constant, max(abs(each) for each in squares)) if i in weak else -b / s
        place[i], linear[i] = y, ex.cancelling_sum((b, s * y))
        constant = ex.cancelling_sum((constant, s * y * y, 2 * b * y))
    return place, linear, constant


def _vertex(s: ex.BigFloat, b: ex.BigFloat, constant: ex.BigFloat, largest: ex.BigFloat) -> ex.BigFloat:
    """Return the place of the anchor on a weak axis, along which the quadric is s y² + 2 b y + constant."""
    root = ex.sqrt
    discriminant = ex.cancelling_sum((b * b, -s * constant))
    near = ex.ZERO
    if discriminant >= 0:
        # The smaller root, by the formula without cancellation
        near = -constant / (b + (root(discriminant) if b > 0 else -root(discriminant)))
    if not s:
        return near
    center = -b / s
    width = root(abs(constant) / largest)
    return near if abs(center - near) > _FAR_CENTER * (abs(near) + width) else center
