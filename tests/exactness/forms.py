"""Polynomials of degree one and two with rational coefficients, and affine maps of them."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass, field
from functools import cached_property
from typing import Any

from flint import fmpq, fmpq_mat, fmpz

from .rational import ONE, ZERO, cross, dot, exactly, root, rounded, sine_cosine, total, vector

PAIRS = ((0, 0), (1, 1), (2, 2), (0, 1), (0, 2), (1, 2), (0, 3), (1, 3), (2, 3), (3, 3))
"""The order of the ten coefficients: those of X_i X_j with X = (x, y, z, 1)."""


@dataclass(frozen=True)
class Form:
    """sum of k X_i X_j <= 0; `flat`: a plane. `exact` False: the coefficients are roundings of irrational ones.

    Mixed coefficients count once: k of xy multiplies x·y.
    """

    k: tuple[fmpq, ...]
    face: int = 0
    exact: bool = True
    flat: bool = field(default=False)

    @cached_property
    def integers(self) -> tuple[fmpz, ...]:
        """The symmetric matrix: coefficients times a positive number, mixed ones halved."""
        halves = [k if i == j else k / 2 for k, (i, j) in zip(self.k, PAIRS, strict=True)]
        common = fmpz(1)
        for h in halves:
            common = common.lcm(h.q)
        whole = [h.p * (common // h.q) for h in halves]
        divisor = fmpz(0)
        for w in whole:
            divisor = divisor.gcd(w)
        return tuple(w // (divisor or 1) for w in whole)

    @cached_property
    def name(self) -> tuple[Any, ...]:
        """Equal for forms that are positive multiples of one another."""
        return (self.flat, *(int(k) for k in self.integers)) if self.exact else (id(self),)

    def same_surface(self, other: Form) -> bool:
        """Equal up to a factor, of either sign."""
        mine, its = self.integers, other.integers
        return self.exact and other.exact and (mine == its or mine == tuple(-k for k in its))

    @property
    def side(self) -> int:
        """Of a plane: the sign of the first component of its normal that is not zero."""
        return next((1 if k > 0 else -1 for k in self.k[6:9] if k), 0)


def form(terms: dict[tuple[int, int], Any], face: int = 0, exact: bool = True) -> Form:
    k = dict.fromkeys(PAIRS, ZERO)
    for (i, j), value in terms.items():
        k[min(i, j), max(i, j)] += exactly(value)
    numbers = tuple(k.values())
    return Form(numbers, face, exact, not any(numbers[:6]))


def plane(normal: Sequence[Any], offset: Any, face: int = 0, exact: bool = True) -> Form:
    """normal·x <= offset"""
    return form({**{(i, 3): n for i, n in enumerate(normal)}, (3, 3): -exactly(offset)}, face, exact)


def squared(parts: Sequence[tuple[Any, Sequence[Any]]], face: int = 0, exact: bool = True) -> Form:
    """sum of factor · (l·X)² over (factor, four numbers l)."""
    k = []
    for i, j in PAIRS:
        twice = 1 if i == j else 2
        k.append(total((twice * exactly(f) * row[i] * row[j] for f, row in parts), exact))
    return Form(tuple(k), face, exact, False)


@dataclass(frozen=True)
class Affine:
    """x ↦ rows x + shift"""

    rows: tuple[tuple[fmpq, ...], ...] = ((ONE, ZERO, ZERO), (ZERO, ONE, ZERO), (ZERO, ZERO, ONE))
    shift: tuple[fmpq, ...] = (ZERO, ZERO, ZERO)
    exact: bool = True

    def point(self, x: Sequence[fmpq]) -> tuple[fmpq, ...]:
        return tuple(
            total((*(a * b for a, b in zip(row, x, strict=True)), s), self.exact)
            for row, s in zip(self.rows, self.shift, strict=True)
        )

    def after(self, first: Affine) -> Affine:
        exact = self.exact and first.exact
        columns = tuple(zip(*first.rows, strict=True))
        rows = tuple(tuple(dot(row, column, exact) for column in columns) for row in self.rows)
        shift = tuple(
            total((*(a * b for a, b in zip(row, first.shift, strict=True)), s), exact)
            for row, s in zip(self.rows, self.shift, strict=True)
        )
        return Affine(rows, shift, exact)

    @property
    def determinant(self) -> fmpq:
        return dot(self.rows[0], cross(self.rows[1], self.rows[2], self.exact), self.exact)

    def inverse(self) -> Affine:
        a, b, c = zip(*self.rows, strict=True)
        volume = dot(a, cross(b, c, self.exact), self.exact)
        rows = tuple(
            tuple(self._short(x / volume) for x in cross(p, q, self.exact)) for p, q in ((b, c), (c, a), (a, b))
        )
        return Affine(rows, tuple(-dot(row, self.shift, self.exact) for row in rows), self.exact)

    def _short(self, x: fmpq) -> fmpq:
        return x if self.exact else rounded(x)


def carried(old: Form, back: Affine) -> Form:
    """The form moved by the inverse of `back`: its matrix Q becomes BᵀQB."""
    exact = old.exact and back.exact
    b = [[*row, s] for row, s in zip(back.rows, back.shift, strict=True)] + [[ZERO, ZERO, ZERO, ONE]]
    if old.flat:
        n = (*old.k[6:9], old.k[9])
        row = [total((n[i] * b[i][j] for i in range(4)), exact) for j in range(4)]
        return plane(row[:3], -row[3], old.face, exact)
    k = []
    q = [(v, i, j) for v, (i, j) in zip(old.k, PAIRS, strict=True) if v]
    for m, n in PAIRS:
        terms = [v * b[i][m] * b[j][n] for v, i, j in q]
        if m != n:
            terms += [v * b[i][n] * b[j][m] for v, i, j in q]
        k.append(total(terms, exact))
    return Form(tuple(k), old.face, exact, False)


def matrix_rank(rows: Sequence[Sequence[fmpq]]) -> int:
    return int(fmpq_mat([list(r) for r in rows]).rank())


def step(kind: str, *arguments: Any) -> Affine:
    """The map of one motion step, as the user wrote it."""
    here = Affine()
    if kind == "translate":
        return Affine(here.rows, vector(arguments[0]))
    if kind == "scale":
        factors = arguments[0] if hasattr(arguments[0], "__len__") else (arguments[0],) * 3
        x, y, z = vector(factors)
        return Affine(((x, ZERO, ZERO), (ZERO, y, ZERO), (ZERO, ZERO, z)))
    if kind == "transform":
        rows = [vector(row) for row in arguments[0]]
        return Affine(tuple(tuple(row[:3]) for row in rows[:3]), tuple(row[3] for row in rows[:3]))
    assert kind == "rotate"
    return rotation(vector(arguments[0]), arguments[1])


def rotation(axis: Sequence[fmpq], degrees: Any) -> Affine:
    """cos 1 + (1 - cos) k kᵀ / k² + sin [k]× / |k|"""
    s, c, exact = sine_cosine(degrees)
    square = dot(axis, axis)
    length, rational = root(square)
    exact = exact and (rational or not s)
    x, y, z = axis
    wedge = ((ZERO, -z, y), (z, ZERO, -x), (-y, x, ZERO))
    rows = tuple(
        tuple(
            total((c if i == j else ZERO, (1 - c) * axis[i] * axis[j] / square, s * wedge[i][j] / length), exact)
            for j in range(3)
        )
        for i in range(3)
    )
    return Affine(rows, (ZERO, ZERO, ZERO), exact)


def chain(steps: Sequence[Sequence[Any]]) -> Affine:
    """Steps composed first to last."""
    result = Affine()
    for one in steps:
        result = step(*one).after(result)
    return result
