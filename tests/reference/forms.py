"""Polynomials of degree one and two, affine maps, and polynomials under such maps."""

from __future__ import annotations

from collections.abc import Iterable, Sequence
from dataclasses import dataclass, replace
from functools import cached_property
from typing import Any

from flint import fmpz

from .numbers import ONE, ZERO, Number, cosine, number, root, sine, total

Row = tuple[Number, ...]
PAIRS = ((0, 0), (1, 1), (2, 2), (0, 1), (0, 2), (1, 2), (0, 3), (1, 3), (2, 3), (3, 3))
"""The order of the ten coefficients, of X_i X_j with X = (x, y, z, 1)."""


def row(values: Iterable[Any]) -> Row:
    return tuple(number(v) for v in values)


def dot(a: Sequence[Any], b: Sequence[Any]) -> Number:
    return total(number(x) * y for x, y in zip(a, b, strict=True))


def cross(a: Sequence[Any], b: Sequence[Any]) -> Row:
    return tuple(total((a[i] * b[j], -a[j] * b[i])) for i, j in ((1, 2), (2, 0), (0, 1)))


def minus(a: Sequence[Any], b: Sequence[Any]) -> Row:
    return tuple(total((x, -number(y))) for x, y in zip(a, b, strict=True))


@dataclass(frozen=True, eq=False)
class Form:
    """sum of k X_i X_j <= 0 over PAIRS, mixed coefficients once; `flat`: a plane; `face`: its number on a body."""

    k: Row
    face: int
    flat: bool

    @cached_property
    def exact(self) -> bool:
        return all(k.exact for k in self.k)

    @cached_property
    def side(self) -> int:
        """The sign of the first component of a plane's normal that is not zero."""
        return next((k.sign for k in self.k[6:9] if k), 0) if self.flat else 0

    def numbered(self, first: int) -> Form:
        return replace(self, face=self.face + first)

    def carried(self, back: Sequence[Row]) -> Form:
        """Return the form of x where f is that of back x, back having four rows of four."""
        if self.flat:
            n = (*self.k[6:9], self.k[9])
            return Form((ZERO,) * 6 + tuple(dot(n, column) for column in zip(*back, strict=True)), self.face, True)
        terms = [(k, i, j) for k, (i, j) in zip(self.k, PAIRS, strict=True) if k]
        found = []
        for m, n in PAIRS:
            values = [k * back[i][m] * back[j][n] for k, i, j in terms]
            if m != n:
                values += [k * back[i][n] * back[j][m] for k, i, j in terms]
            found.append(total(values))
        return Form(tuple(found), self.face, False)

    @cached_property
    def whole(self) -> list[dict[int, fmpz]]:
        """Return the ten coefficients times a positive number, with whole parts of no common factor."""
        common, divisor = fmpz(1), fmpz(0)
        numbers = [k.k if self.exact else {1: k.fraction} for k in self.k]
        parts = [c for k in numbers for c in k.values()]
        for c in parts:
            common = common.lcm(c.q)
        for c in parts:
            divisor = divisor.gcd(c.p * (common // c.q))
        return [{s: c.p * (common // c.q) // (divisor or 1) for s, c in k.items()} for k in numbers]


def form(terms: dict[tuple[int, int], Any], face: int = 0, flat: bool | None = None) -> Form:
    k = dict.fromkeys(PAIRS, ZERO)
    for (i, j), value in terms.items():
        k[min(i, j), max(i, j)] += value
    found = tuple(k.values())
    return Form(found, face, not any(found[:6]) if flat is None else flat)


def plane(normal: Sequence[Any], offset: Any, face: int = 0) -> Form:
    """Return normal·x <= offset."""
    return Form((ZERO,) * 6 + (*row(normal), -number(offset)), face, True)


def squared(parts: Iterable[tuple[Any, Sequence[Any]]], face: int = 0) -> Form:
    """Return the sum of factor · (n·X)² over (factor, four numbers n)."""
    parts = [(number(f), row(n)) for f, n in parts]
    twice = {pair: 1 if pair[0] == pair[1] else 2 for pair in PAIRS}
    return Form(tuple(total(twice[i, j] * f * n[i] * n[j] for f, n in parts) for i, j in PAIRS), face, False)


def proportional(a: Form, b: Form) -> int:
    """Return 1 or -1 where a is a positive or negative multiple of b, else 0."""
    if a.flat != b.flat or any(bool(x) != bool(y) for x, y in zip(a.k, b.k, strict=True)):
        return 0
    pivot = next((i for i, k in enumerate(b.k) if k), 0)
    if any(a.k[i] * b.k[pivot] - b.k[i] * a.k[pivot] for i in range(10) if i != pivot and a.k[i]):
        return 0
    return a.k[pivot].sign * b.k[pivot].sign


@dataclass(frozen=True)
class Affine:
    """x ↦ rows x + shift"""

    rows: tuple[Row, ...] = (row((1, 0, 0)), row((0, 1, 0)), row((0, 0, 1)))
    shift: Row = (ZERO, ZERO, ZERO)

    def point(self, x: Sequence[Any]) -> Row:
        return tuple(dot((*r, s), (*x, 1)) for r, s in zip(self.rows, self.shift, strict=True))

    def after(self, first: Affine) -> Affine:
        columns = tuple(zip(*first.rows, strict=True))
        return Affine(tuple(tuple(dot(r, c) for c in columns) for r in self.rows), self.point(first.shift))

    def backwards(self) -> tuple[Row, ...]:
        """Return four rows of the inverse, times the magnitude of the determinant."""
        a, b, c = zip(*self.rows, strict=True)
        volume = dot(a, cross(b, c))
        assert volume, "a motion must have an inverse"
        rows = [tuple(x * volume.sign for x in cross(p, q)) for p, q in ((b, c), (c, a), (a, b))]
        full = tuple((*r, -dot(r, self.shift)) for r in rows)
        return (*full, (ZERO, ZERO, ZERO, volume * volume.sign))


def step(verb: str, *arguments: Any) -> Affine:
    """Return the map of one step, as the user writes it."""
    if verb == "translate":
        return Affine(shift=row(arguments[0]))
    if verb == "scale":
        k = row(arguments[0] if hasattr(arguments[0], "__len__") else (arguments[0],) * 3)
        return Affine(tuple(tuple(k[i] if i == j else ZERO for j in range(3)) for i in range(3)))
    if verb == "transform":
        rows = [row(r) for r in arguments[0]]
        return Affine(tuple(r[:3] for r in rows[:3]), tuple(r[3] for r in rows[:3]))
    assert verb == "rotate", verb
    return rotation(row(arguments[0]), arguments[1])


def rotation(axis: Row, degrees: Any) -> Affine:
    """Return cos 1 + (1 - cos) k kᵀ / k² + sin [k]× / |k|, of an axis of rational components."""
    square = dot(axis, axis)
    s, c = sine(degrees), cosine(degrees)
    s = s * root(ONE / square) if s else s
    x, y, z = axis
    wedge = ((ZERO, -z, y), (z, ZERO, -x), (-y, x, ZERO))
    return Affine(
        tuple(
            tuple(
                total((c if i == j else ZERO, (1 - c) * axis[i] * axis[j] / square, s * wedge[i][j])) for j in range(3)
            )
            for i in range(3)
        )
    )


def chain(steps: Sequence[Sequence[Any]]) -> Affine:
    """Return steps composed first to last."""
    result = Affine()
    for one in steps:
        result = step(*one).after(result)
    return result
