"""Numbers of the reference: sums of rational multiples of square roots, or roundings to 3,000 bits of other numbers.

Square roots of different square-free numbers are independent over the rationals (Besicovitch 1940). So such a sum is
zero only if all its coefficients are. Sines of most angles and roots of long numbers are no such sums. They are
rounded, and a sum of rounded terms below 2^-2500 of its largest term counts as zero.
"""

from __future__ import annotations

import math
from collections.abc import Iterable
from functools import cache
from typing import Any

from flint import arb, ctx, fmpq, fmpz

BITS = 3000
VANISHED = fmpq(1, fmpz(1) << 2500)
FACTORED = 64
"""Numbers of more bits are not split into a square and the rest."""


def rational(value: Any) -> fmpq:
    """Return a whole number, fraction or float as it is."""
    if isinstance(value, (fmpq, fmpz, int)):
        return fmpq(value)
    if isinstance(value, Number):
        assert set(value.k) <= {1}, value
        return value.k.get(1, fmpq(0))
    return fmpq(*value.as_integer_ratio())


@cache
def product(p: int, q: int) -> tuple[int, int]:
    """Return (f, s) with sqrt p sqrt q = f sqrt s."""
    common = math.gcd(p, q)
    return common, (p // common) * (q // common)


@cache
def root_fraction(s: int) -> fmpq:
    """Return sqrt s, rounded."""
    with ctx.workprec(BITS + 20):
        return middle(arb(s).sqrt())


class Number:
    """sum of k[s] sqrt s, without zeros. Where it is not `exact`, k has s = 1 alone, with a rounded coefficient."""

    __slots__ = ("exact", "k")

    def __init__(self, k: dict[int, Any], exact: bool = True) -> None:
        self.k, self.exact = {s: c for s, c in k.items() if c}, exact

    @property
    def fraction(self) -> fmpq:
        """The number itself where it is rational, else a rounding."""
        if self.k.keys() <= {1}:
            return self.k.get(1, fmpq(0))
        return rounded(sum((c * root_fraction(s) for s, c in self.k.items()), fmpq(0)))

    def __add__(self, other: Any) -> Number:
        return total((self, other))

    __radd__ = __add__

    def __neg__(self) -> Number:
        return Number({s: -c for s, c in self.k.items()}, self.exact)

    def __sub__(self, other: Any) -> Number:
        return total((self, -number(other)))

    def __rsub__(self, other: Any) -> Number:
        return total((-self, other))

    def __mul__(self, other: Any) -> Number:
        other = number(other)
        if not self.k or not other.k:
            return ZERO
        if not (self.exact and other.exact):
            return Number({1: self.fraction * other.fraction}, False)
        k: dict[int, Any] = {}
        for p, a in self.k.items():
            for q, b in other.k.items():
                f, s = product(p, q)
                k[s] = k.get(s, 0) + a * b * f
        return Number(k)

    __rmul__ = __mul__

    def __truediv__(self, other: Any) -> Number:
        return self * (1 / rational(other))

    def __bool__(self) -> bool:
        return bool(self.k)

    def __eq__(self, other: object) -> bool:
        return not self - number(other)

    __hash__ = None  # type: ignore[assignment]

    def __repr__(self) -> str:
        return " + ".join(f"{c}" if s == 1 else f"{c} sqrt {s}" for s, c in sorted(self.k.items())) or "0"

    def __float__(self) -> float:
        with ctx.workprec(200):
            return float(ball(self, 100).mid())

    @property
    def sign(self) -> int:
        """-1, 0 or 1."""
        if not self.k:
            return 0
        return 1 if ball(self, 8) > 0 else -1


def number(value: Any) -> Number:
    return value if isinstance(value, Number) else Number({1: rational(value)})


ZERO, ONE = number(0), number(1)


def total(values: Iterable[Any]) -> Number:
    """Return the sum, which is zero where rounded terms cancel."""
    terms = [number(v) for v in values]
    if all(t.exact for t in terms):
        k: dict[int, Any] = {}
        for t in terms:
            for s, c in t.k.items():
                k[s] = k[s] + c if s in k else c
        return Number(k)
    fractions = [t.fraction for t in terms]
    result = sum(fractions, fmpq(0))
    vanishes = abs(result) < VANISHED * max(abs(f) for f in fractions)
    return Number({1: fmpq(0) if vanishes else rounded(result)}, False)


def rounded(value: fmpq) -> fmpq:
    """Return it in BITS bits, and a shorter number unchanged."""
    top, bottom = value.p, value.q
    if top.height_bits() + bottom.height_bits() <= BITS:
        return value
    shift = BITS - top.height_bits() + bottom.height_bits()
    if shift >= 0:
        return fmpq((2 * (top << shift) + bottom) // (2 * bottom), fmpz(1) << shift)
    scaled = bottom << -shift
    return fmpq((2 * top + scaled) // (2 * scaled) << -shift)


def middle(value: arb) -> fmpq:
    mantissa, exponent = value.mid().man_exp()
    exponent = int(exponent)
    return fmpq(mantissa << exponent) if exponent >= 0 else fmpq(mantissa, fmpz(1) << -exponent)


def root(value: Any) -> Number:
    """Return the square root of a rational number that is not negative."""
    value = rational(value)
    if value.p.is_square() and value.q.is_square():
        return number(fmpq(value.p.isqrt(), value.q.isqrt()))
    if value.p.height_bits() + value.q.height_bits() > FACTORED:
        with ctx.workprec(BITS + 20):
            return Number({1: middle(arb(value).sqrt())}, False)
    factor, rest = 1, 1
    for p, power in (value.p * value.q).factor():
        factor, rest = factor * int(p) ** (power // 2), rest * int(p) ** (power % 2)
    return Number({rest: fmpq(factor, value.q)})


_QUARTER = {0: (1, {1: 1}), 15: (4, {6: 1, 2: 1}), 30: (2, {3: 1}), 45: (2, {2: 1}), 60: (2, {1: 1}), 75: (4, {6: 1, 2: -1}), 90: (1, {})}  # fmt: skip


def cosine(degrees: Any) -> Number:
    """Return it exactly for multiples of 15 degrees, else rounded."""
    turn = rational(degrees)
    if turn.q != 1 or turn.p % 15:
        with ctx.workprec(BITS + 20):
            return Number({1: middle(arb.cos_pi_fmpq(turn / 180))}, False)
    whole = int(turn.p) % 360
    whole = min(whole, 360 - whole)
    sense, whole = (1, whole) if whole <= 90 else (-1, 180 - whole)
    below, k = _QUARTER[whole]
    return Number({s: fmpq(sense * c, below) for s, c in k.items()})


def sine(degrees: Any) -> Number:
    return cosine(rational(degrees) - 90)


def sign(value: Any) -> int:
    """Return -1, 0 or 1 of a number or a whole number."""
    return value.sign if isinstance(value, Number) else (value > 0) - (value < 0)


def ball(value: Any, bits: int) -> arb:
    """Return an interval of so many bits around a number, or a whole number itself. It holds zero only for zero."""
    if not isinstance(value, Number):
        return arb(value)
    precision = bits + 30
    while True:
        with ctx.workprec(precision):
            found = sum((arb(c) * arb(s).sqrt() for s, c in value.k.items()), arb(0))
        if not value.k or found.rel_accuracy_bits() >= bits:
            return found
        precision *= 2
