"""Numbers of a multiquadratic field: sums of rational multiples of square roots of square-free whole numbers.

Such roots are independent over the rationals (Besicovitch 1940): a number is zero only if all its coefficients are.
"""

from __future__ import annotations

import math
from functools import cache
from typing import Any

from flint import arb, ctx, fmpq, fmpz

Parts = dict[int, fmpq]


def rational(value: Any) -> fmpq:
    """A whole number, fraction or float as it is."""
    if isinstance(value, fmpq):
        return value
    if isinstance(value, (int, fmpz)):
        return fmpq(value)
    numerator, denominator = value.as_integer_ratio()
    return fmpq(numerator, denominator)


@cache
def squarefree(n: int) -> tuple[int, int]:
    """(f, s) with n = f² s and s square-free"""
    factor, rest = 1, 1
    for p, power in fmpz(n).factor():
        factor *= int(p) ** (power // 2)
        rest *= int(p) ** (power % 2)
    return factor, rest


@cache
def product(p: int, q: int) -> tuple[int, int]:
    """(f, s) with sqrt p sqrt q = f sqrt s"""
    common = math.gcd(p, q)
    return common, (p // common) * (q // common)


class Number:
    """sum of k[s] sqrt s; coefficients that are zero are left out"""

    __slots__ = ("k",)

    def __init__(self, k: Parts) -> None:
        self.k = {s: c for s, c in k.items() if c}

    def __add__(self, other: Any) -> Number:
        k = dict(self.k)
        for s, c in number(other).k.items():
            k[s] = k[s] + c if s in k else c
        return Number(k)

    __radd__ = __add__

    def __neg__(self) -> Number:
        return Number({s: -c for s, c in self.k.items()})

    def __sub__(self, other: Any) -> Number:
        return self + -number(other)

    def __rsub__(self, other: Any) -> Number:
        return number(other) + -self

    def __mul__(self, other: Any) -> Number:
        k: Parts = {}
        for p, a in self.k.items():
            for q, b in number(other).k.items():
                f, s = product(p, q)
                k[s] = k.get(s, fmpq(0)) + a * b * f
        return Number(k)

    __rmul__ = __mul__

    def __bool__(self) -> bool:
        return bool(self.k)

    def __eq__(self, other: object) -> bool:
        return not self - number(other)

    def __hash__(self) -> int:
        return hash(tuple(sorted((s, int(c.p), int(c.q)) for s, c in self.k.items())))

    def __repr__(self) -> str:
        return " + ".join(f"{c}" if s == 1 else f"{c} sqrt {s}" for s, c in sorted(self.k.items())) or "0"

    def ball(self, bits: int) -> arb:
        """An enclosure, from arithmetic of so many bits."""
        with ctx.workprec(bits):
            return sum((arb(c) * arb(s).sqrt() for s, c in self.k.items()), arb(0))

    @property
    def sign(self) -> int:
        return sign_of(self.k)

    def __float__(self) -> float:
        return float(self.ball(200).mid())


def sign_of(k: dict[int, Any]) -> int:
    """The sign of sum of k[s] sqrt s: 0 only if every k is, else by as many digits as it takes."""
    terms = [(s, c) for s, c in k.items() if c]
    if len(terms) < 2:
        return (terms[0][1] > 0) - (terms[0][1] < 0) if terms else 0
    bits = 128
    while True:
        with ctx.workprec(bits):
            value = sum((arb(c) * arb(s).sqrt() for s, c in terms), arb(0))
            if value > 0:
                return 1
            if value < 0:
                return -1
        bits *= 2


def number(value: Any) -> Number:
    """Whole numbers, fractions, floats and numbers as numbers."""
    return value if isinstance(value, Number) else Number({1: rational(value)})


def root(value: Any) -> Number:
    """The square root of a rational number that is not negative."""
    value = rational(value)
    if not value:
        return Number({})
    factor, s = squarefree(int(value.p * value.q))
    return Number({s: fmpq(factor, value.q)})


_QUARTER = {0: (1, {1: 1}), 15: (4, {6: 1, 2: 1}), 30: (2, {3: 1}), 45: (2, {2: 1}), 60: (2, {1: 1}), 75: (4, {6: 1, 2: -1}), 90: (1, {})}  # fmt: skip


def cosine(degrees: Any) -> Number:
    """Of a multiple of 15 degrees."""
    turn = rational(degrees)
    assert turn.q == 1, "whole degrees only"
    turn = int(turn.p) % 360
    turn = min(turn, 360 - turn)
    sign, turn = (1, turn) if turn <= 90 else (-1, 180 - turn)
    below, k = _QUARTER[turn]
    return Number({s: fmpq(sign * c, below) for s, c in k.items()})


def sine(degrees: Any) -> Number:
    return cosine(rational(degrees) - 90)
