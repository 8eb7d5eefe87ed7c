"""A general quadric about its principal axes: directions, center or vertex, in exact arithmetic.

xᵀA x + 2 b·x + c becomes Σ λ_i y_i² + 2 Σ β_i y_i + γ with y = W (x - anchor), the rows of W the
unit eigenvectors of A, β_i = 0 where the anchor could be put to the center along axis i.
"""

from __future__ import annotations

from collections.abc import Iterator
from contextlib import contextmanager
from fractions import Fraction
from functools import cache
from typing import Any

from ..forks import nested_lock
from . import exact as ex
from .coefficients import Symmetric
from .rational import eliminated
from .surface import UPRIGHT, QuadricSurface, Triples

_WEAK = Fraction(1, 1024)
"""Below this share of the largest eigenvalue an axis may keep its linear term."""
_FAR = 1024
"""A center so many times farther than what lies near the origin is not moved to."""
_NOISE = ex.power_of_two(-ex.CANCELLED)
_mp_lock = nested_lock()


@cache
def _mpmath() -> Any:
    """mpmath, imported where it is needed: few scenes have a matrix that needs it."""
    from mpmath import MPContext

    return MPContext()


@contextmanager
def _mpmath_of(bits: int) -> Iterator[Any]:
    """mpmath at a precision, for one thread at a time: the precision, and the constants it keeps, are those of all."""
    with _mp_lock:
        mp = _mpmath()
        mp.prec = bits
        yield mp


def _of_mpmath(value: Any, places: int) -> ex.Exact:
    """A number of mpmath's whose error is below 2^-places, within `_mpmath_of` at least so many bits."""
    mp = _mpmath()
    scaled = int(mp.nint(mp.ldexp(value, places)))
    return ex.settled(ex.Exact(scaled, -places, 2))


def principal_quadric(matrix: Symmetric) -> QuadricSurface:
    """The surface of (x, 1) matrix (x, 1)ᵀ = 0, whose second-order part is not zero."""
    values, rows = eigen(matrix)
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


def eigen(matrix: Symmetric, rank: int | None = None) -> tuple[list[ex.Writable], Triples]:
    """Eigenvalues and unit eigenvectors (as rows); a diagonal matrix keeps its own, exact.

    `rank` is that of the second-order part where its entries are rounded; it is found where they are exact.
    """
    a = [list(row[:3]) for row in matrix[:3]]
    if not (a[0][1] or a[0][2] or a[1][2]):
        return [a[0][0], a[1][1], a[2][2]], UPRIGHT
    entries = [abs(value) for row in a for value in row if value]
    # Small eigenvalues beside large ones need the more digits
    spread = (max(entries) / min(entries)).numerator.bit_length()
    scale, places = max(entries), ex.BITS + 4 * spread
    with _mpmath_of(places + 64) as mp:
        scaled = [[v / scale for v in row] for row in a]
        found, vectors = mp.eigsy(mp.matrix([[mp.mpf(v.numerator) / v.denominator for v in row] for row in scaled]))
        order = sorted(range(3), key=lambda k: max(range(3), key=lambda i: abs(vectors[i, k])))
        rank = len(eliminated(a, 3)[1]) if rank is None else rank
        vanishing = sorted(range(3), key=lambda k: abs(found[k]))[: 3 - rank]
        values = [ex.ZERO if k in vanishing else _of_mpmath(found[k], places) * scale for k in order]
        rows = tuple(tuple(_quiet(_of_mpmath(vectors[i, k], ex.BITS)) for i in range(3)) for k in order)
    return values, rows  # type: ignore[return-value]


def _quiet(entry: ex.Exact) -> ex.Exact:
    """An entry of a unit vector; zero where it is only rounding."""
    return ex.ZERO if abs(entry) < _NOISE else entry


def _anchor(
    squares: list[ex.Exact], slopes: list[ex.Exact], constant: ex.Exact
) -> tuple[list[ex.Exact], list[ex.Exact], ex.Exact]:
    """(anchor, linear terms and constant about it), all along the principal axes.

    Strong axes go to their center first. Then weak and flat ones go to their center if it is near, else
    to the vertex nearest to the origin, where they keep a linear term.
    """
    place, linear = [ex.ZERO] * 3, list(slopes)
    largest = max(abs(s) for s in squares)
    strength = sorted(range(3), key=lambda i: -abs(squares[i]))
    for i in strength:
        s, b = squares[i], linear[i]
        if not b:
            continue
        weak = abs(s) < _WEAK.numerator * largest / _WEAK.denominator
        y = _vertex(s, b, constant, largest) if weak else -b / s
        place[i], linear[i] = y, ex.cancelling_sum((b, s * y))
        constant = ex.cancelling_sum((constant, s * y * y, 2 * b * y))
    return place, linear, constant


def _vertex(s: ex.Exact, b: ex.Exact, constant: ex.Exact, largest: ex.Exact) -> ex.Exact:
    """Where to put the anchor on a weak axis, along which the quadric is s y² + 2 b y + constant."""
    root = ex.sqrt
    discriminant = ex.cancelling_sum((b * b, -s * constant))
    near = ex.ZERO
    if discriminant >= 0:
        # The smaller root, in the stable form
        near = -constant / (b + (root(discriminant) if b > 0 else -root(discriminant)))
    if not s:
        return near
    center = -b / s
    width = root(abs(constant) / largest)
    return near if abs(center - near) > _FAR * (abs(near) + width) else center
