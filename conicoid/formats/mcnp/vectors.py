"""Vectors and matrices of fractions."""

from __future__ import annotations

from collections.abc import Sequence
from fractions import Fraction

from ..openmc.placement import Point, Rows


def point(values: Sequence[Fraction]) -> Point:
    x, y, z = values
    return x, y, z


def dot(u: Point, v: Point) -> Fraction:
    return u[0] * v[0] + u[1] * v[1] + u[2] * v[2]


def cross(u: Point, v: Point) -> Point:
    return u[1] * v[2] - u[2] * v[1], u[2] * v[0] - u[0] * v[2], u[0] * v[1] - u[1] * v[0]


def plus(u: Point, v: Point, times: Fraction | int = 1) -> Point:
    """u + times v"""
    return u[0] + times * v[0], u[1] + times * v[1], u[2] + times * v[2]


def scaled(u: Point, times: Fraction | int) -> Point:
    return u[0] * times, u[1] * times, u[2] * times


def applied(rows: Rows, u: Point) -> Point:
    return dot(rows[0], u), dot(rows[1], u), dot(rows[2], u)


def transposed(rows: Rows) -> Rows:
    a, b, c = rows
    return (a[0], b[0], c[0]), (a[1], b[1], c[1]), (a[2], b[2], c[2])


def product(a: Rows, b: Rows) -> Rows:
    x, y, z = (applied(transposed(b), row) for row in a)
    return x, y, z


def outer(u: Point) -> Rows:
    """u uᵀ"""
    return scaled(u, u[0]), scaled(u, u[1]), scaled(u, u[2])


def total(a: Rows, b: Rows, times: Fraction | int = 1) -> Rows:
    """a + times b"""
    return plus(a[0], b[0], times), plus(a[1], b[1], times), plus(a[2], b[2], times)


def times(a: Rows, factor: Fraction | int) -> Rows:
    return scaled(a[0], factor), scaled(a[1], factor), scaled(a[2], factor)


_ONE, _ZERO = Fraction(1), Fraction(0)
UNIT: Rows = ((_ONE, _ZERO, _ZERO), (_ZERO, _ONE, _ZERO), (_ZERO, _ZERO, _ONE))


def duals(vectors: Sequence[Point]) -> list[Point]:
    """Of one to three independent vectors v: w with v[i]·w[j] = 1 or 0, in their span. Raises ValueError."""
    found = []
    for i, vector in enumerate(vectors):
        rest = [other for j, other in enumerate(vectors) if j != i]
        if not rest:
            across = vector
        elif len(rest) == 1:
            across = plus(vector, rest[0], -dot(vector, rest[0]) / dot(rest[0], rest[0]))
        else:
            across = cross(*rest)
        size = dot(across, vector)
        if not size:
            raise ValueError("directions depend on each other")
        found.append(scaled(across, 1 / size))
    return found
