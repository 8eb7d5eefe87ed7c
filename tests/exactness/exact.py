"""A ray on exact forms: integer quadratics, the signs of their discriminants, equality and order of their roots.

Origins and directions are binary floats, so with a common power of two they are integers, and so are the
coefficients of a t² + 2 b t + c. Roots are balls of `arb` (python-flint). Two balls that overlap are roots of two
quadratics that either share a root, which their resultant

    (a1 c2 - a2 c1)² - 4 (a1 b2 - a2 b1)(b1 c2 - b2 c1)

says exactly, or are parted by more digits. Where coefficients are roundings of irrational numbers (to 3000 bits),
what agrees to 600 digits or more is equal on paper.
"""

from __future__ import annotations

import math
from collections.abc import Sequence
from dataclasses import dataclass
from functools import cmp_to_key
from typing import Any

from flint import arb, ctx, fmpz

from .forms import Form

FIRST_BITS, EQUAL_BITS = 160, 1000
NEARLY_NONE = 2200
"""A discriminant of inexact numbers, 2^-2200 of its terms, is zero on paper."""


def integers(values: Sequence[float]) -> tuple[list[fmpz], int]:
    """(whole numbers n, e) with values = n 2^-e"""
    parts = [float(v).as_integer_ratio() for v in values]
    e = max(q.bit_length() - 1 for _, q in parts)
    return [fmpz(p) << (e - (q.bit_length() - 1)) for p, q in parts], e


class ExactRay:
    """Integers O, D, W with origin = O / W and direction = D / W."""

    def __init__(self, origin: Sequence[float], direction: Sequence[float]) -> None:
        o, eo = integers(origin)
        d, ed = integers(direction)
        e = max(eo, ed)
        self.o = [x << (e - eo) for x in o]
        self.d = [x << (e - ed) for x in d]
        self.w = fmpz(1) << e
        self.dd: list[fmpz] | None = None

    def quadratic(self, f: Form) -> tuple[fmpz, fmpz, fmpz]:
        """(a, b, c) times a positive number; of a plane a = 0 and 2 b t + c is its height."""
        (x, y, z), (u, v, w), one = self.o, self.d, self.w
        if f.flat:
            nx, ny, nz, k = f.integers[6:]
            b, c = nx * u + ny * v + nz * w, 2 * (nx * x + ny * y + nz * z) + k * one
            return self._settled_plane(f, b, c)
        xx, yy, zz, xy, xz, yz, lx, ly, lz, k = f.integers
        # half the gradient along the direction and at the origin
        gu, gv, gw = xx * u + xy * v + xz * w, xy * u + yy * v + yz * w, xz * u + yz * v + zz * w
        hx = xx * x + xy * y + xz * z + lx * one
        hy = xy * x + yy * y + yz * z + ly * one
        hz = xz * x + yz * y + zz * z + lz * one
        a = gu * u + gv * v + gw * w
        b = hx * u + hy * v + hz * w
        c = hx * x + hy * y + hz * z + (lx * x + ly * y + lz * z + k * one) * one
        if not f.exact:
            a, b, c = self._settled(f, a, b, c)
        return a, b, c

    def _settled_plane(self, f: Form, b: fmpz, c: fmpz) -> tuple[fmpz, fmpz, fmpz]:
        if not f.exact:
            n = max(abs(k) for k in f.integers[6:9])
            d, o = max(map(abs, self.d)), max(map(abs, self.o))
            b, c = vanishing(b, n * d), vanishing(c, n * o + abs(f.integers[9]) * self.w)
        return fmpz(0), b, c

    def _settled(self, f: Form, a: fmpz, b: fmpz, c: fmpz) -> tuple[fmpz, fmpz, fmpz]:
        """Zero where inexact terms cancel."""
        m = max(abs(k) for k in f.integers[:6])
        n = max(abs(k) for k in f.integers[6:9])
        d, o = max(map(abs, self.d)), max(map(abs, self.o))
        sizes = (m * d * d, (m * o + n * self.w) * d, m * o * o + n * o * self.w + abs(f.integers[9]) * self.w * self.w)
        return tuple(vanishing(v, s) for v, s in zip((a, b, c), sizes, strict=True))


def vanishing(value: fmpz, size: fmpz) -> fmpz:
    """The value of a sum of inexact terms of that size: zero where they cancel."""
    return fmpz(0) if abs(value) << NEARLY_NONE < size else value


@dataclass(eq=False)
class Root:
    """A simple root of form `index`: the `which`-th of a t² + 2 b t + c from the left."""

    index: int
    which: int
    quadratic: tuple[fmpz, fmpz, fmpz]
    discriminant: fmpz
    exact: bool
    bits: int = FIRST_BITS
    ball: arb | None = None

    def at(self, bits: int) -> arb:
        """The root as a ball of about that relative precision."""
        if self.ball is None or bits > self.bits:
            self.bits = max(bits, self.bits)
            with ctx.workprec(self.bits + 10):
                self.ball = self._value()
        return self.ball

    def _value(self) -> arb:
        a, b, c = self.quadratic
        if not a:
            return arb(-c) / arb(2 * b)
        s = arb(self.discriminant).sqrt()
        q = -(arb(b) + s) if b > 0 else -arb(b) + s
        far, near = q / arb(a), arb(c) / q
        # for b > 0 the root q / a is (-b - s) / a: the left one if a > 0
        left_is_far = (b > 0) == (a > 0)
        return far if left_is_far == (self.which == 0) else near

    @property
    def sign(self) -> int:
        """Of the root itself: where it lies from the origin of the ray."""
        a, b, c = self.quadratic
        if not c:
            if not a:
                return 0
            other = -1 if (a > 0) == (b > 0) else 1  # the other root is -2 b / a
            return 0 if (other < 0) == (self.which == 1) else other
        if not a:
            return -1 if (c > 0) == (b > 0) else 1
        if (c > 0) != (a > 0):
            return -1 if self.which == 0 else 1
        return -1 if (a > 0) == (b > 0) else 1


def roots(index: int, f: Form, quadratic: tuple[fmpz, fmpz, fmpz]) -> list[Root]:
    """Simple real roots, left to right; a double root is a touch and counts as none."""
    a, b, c = quadratic
    if not a:
        return [Root(index, 0, quadratic, b * b, f.exact)] if b else []
    p, q = b * b, a * c
    discriminant = p - q
    if not f.exact and abs(discriminant) << NEARLY_NONE < max(p, abs(q)):
        discriminant = fmpz(0)
    if discriminant <= 0:
        return []
    return [Root(index, which, quadratic, discriminant, f.exact) for which in (0, 1)]


def share_a_root(r: Root, s: Root) -> bool:
    """The resultant vanishes."""
    (a1, b1, c1), (a2, b2, c2) = r.quadratic, s.quadratic
    if not a1 and not a2:
        return b1 * c2 == b2 * c1
    ac = a1 * c2 - a2 * c1
    return ac * ac == 4 * (a1 * b2 - a2 * b1) * (b1 * c2 - b2 * c1)


def compare(r: Root, s: Root) -> int:
    """-1, 0, 1 for r < s, r = s, r > s"""
    if r is s:
        return 0
    if r.index == s.index:
        return -1 if r.which < s.which else 1
    bits = FIRST_BITS
    # Roots that stay together to EQUAL_BITS bits of quadratics that share a root are that root:
    # integers of some 2^12 bits hold no two different roots as near as this if they hold a common one too
    while True:
        p, q = r.at(bits), s.at(bits)
        if p < q:
            return -1
        if p > q:
            return 1
        if bits > EQUAL_BITS and (not (r.exact and s.exact) or share_a_root(r, s)):
            return 0
        if bits == FIRST_BITS and r.exact and s.exact and share_a_root(r, s) and _equal_known(r, s):
            return 0
        bits *= 4
        assert bits < 1 << 20, "two roots that cannot be parted"


def _equal_known(r: Root, s: Root) -> bool:
    """Of quadratics that share a root and balls that overlap: are the other roots, if any, elsewhere?"""
    (a1, b1, c1), (a2, b2, c2) = r.quadratic, s.quadratic
    if a1 * b2 == a2 * b1 and a1 * c2 == a2 * c1:
        return (r.which == s.which) or not a1
    others = [roots_of for roots_of in (_other(r), _other(s)) if roots_of is not None]
    mine = r.at(FIRST_BITS), s.at(FIRST_BITS)
    return all(not o.overlaps(m) for o in others for m in mine)


def _other(r: Root) -> arb | None:
    if not r.quadratic[0]:
        return None
    return Root(r.index, 1 - r.which, r.quadratic, r.discriminant, r.exact).at(FIRST_BITS)


by_place = cmp_to_key(compare)


def sign_at_start(f: Form, quadratic: tuple[fmpz, fmpz, fmpz], crossed: bool) -> bool:
    """Is the form negative towards t = -inf?  A ray within a plane: as if the plane stood further along its
    normal, the normal taken so that its first component is positive. A ray in a curved surface is outside."""
    a, b, c = quadratic
    if a:
        return bool(a < 0)
    if b:
        return bool(b > 0)
    if not c and f.flat:
        return f.side > 0
    return bool(c < 0)


def nearest(value: arb) -> float:
    """A float64 beside the middle of a ball."""
    try:
        return float(value.mid())
    except OverflowError:
        return math.inf if value > 0 else -math.inf


def as_pair(root: Root) -> tuple[float, float]:
    """A root as the sum of two floats."""
    ball = root.at(FIRST_BITS)
    high = nearest(ball)
    if math.isinf(high):
        return high, 0.0
    with ctx.workprec(400):
        return high, nearest(ball - arb(high))


def distance(root: Root, t: float) -> tuple[float, float]:
    """(lower, upper) float bounds of |t - root|, some 2^-50 apart in relative terms."""
    bits = FIRST_BITS
    while True:
        with ctx.workprec(bits + 200):
            gap = abs(arb(float(t)) - root.at(bits))
            if gap == 0 or gap.rel_accuracy_bits() > 52 or bits > 5000:
                middle = nearest(gap)
                return math.nextafter(math.nextafter(middle, 0), 0), math.nextafter(
                    math.nextafter(middle, math.inf), math.inf
                )
        bits *= 2


def value_sign(f: Form, point: Sequence[float]) -> int:
    """Sign of the form at a point."""
    c: Any = ExactRay(point, (1.0, 0.0, 0.0)).quadratic(f)[2]
    return (c > 0) - (c < 0)
