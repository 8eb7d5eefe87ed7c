"""Roots of integer quadratics in order: exact coefficients against mpmath, rounded ones against known numbers."""

import itertools
from fractions import Fraction
from math import isqrt

import mpmath
import numpy as np
import pytest

from conicoid.geometry import exact_crossings as order
from conicoid.numerics.rational import IntegerQuadratic, Root, compare_roots, exact_real_roots, rational_root

BITS = 3000
ROOT_2 = isqrt(2 << (2 * BITS))  # times 2^-BITS, less than one unit too small


def expected(q: IntegerQuadratic) -> list[mpmath.mpf]:
    if q.a == 0:
        return [mpmath.mpf(-q.c) / (2 * q.b)] if q.b else []
    d = q.b * q.b - q.a * q.c
    return sorted((-q.b + s * mpmath.sqrt(d)) / q.a for s in (1, -1)) if d > 0 else []


def test_all_small_quadratics_in_order() -> None:
    """Different roots are more than 1e-12 apart here, and roots that agree to 40 digits are equal."""
    random = np.random.default_rng(1)
    quadratics = [IntegerQuadratic(*map(int, random.integers(-4, 5, 3))) for _ in range(60)]
    with mpmath.workdps(40):
        pairs = []
        for q in quadratics:
            found, values = exact_real_roots(q), expected(q)
            assert len(found) == len(values)
            assert all(abs(float(r) - v) < 1e-15 * (1 + abs(v)) for r, v in zip(found, values, strict=True))
            pairs += zip(found, values, strict=True)
        for (x, a), (y, b) in itertools.product(pairs, repeat=2):
            assert compare_roots(x, y) == (0 if abs(a - b) < 1e-30 else -1 if a < b else 1)


def line_at(numerator: int, bits: int, off: int) -> Root:
    """Return numerator 2^-bits, whose numerator has so large an error."""
    (root,) = exact_real_roots(IntegerQuadratic(0, 1 << bits, -2 * numerator, (0, 0, 2 * off)))
    return root


@pytest.mark.parametrize("sense", [1, -1])
def test_a_rounded_root_stands_for_the_exact_root_nearby(sense: int) -> None:
    low, high = exact_real_roots(IntegerQuadratic(1, 0, -2))
    exact = high if sense > 0 else low
    assert compare_roots(exact, line_at(sense * ROOT_2, BITS, 2)) == 0
    assert compare_roots(line_at(sense * ROOT_2, BITS, 2), exact) == 0
    # 2^-2000 away
    for beside in (1, -1):
        other = line_at(sense * ROOT_2 + (beside << 1000), BITS, 2)
        assert compare_roots(exact, other) == -beside
        assert compare_roots(other, exact) == beside
        assert compare_roots(exact, line_at(sense * ROOT_2 + (beside << 1000), BITS, 1 << 1001)) == 0


def test_rounded_roots_of_curves() -> None:
    """With √2 to 3000 bits, t² - 2 √2 t + 1 has the roots √2 - 1, also of t² + 2 t - 1, and √2 + 1, of t² - 2 t - 1."""
    off = (0, 2, 0)
    rounded = exact_real_roots(IntegerQuadratic(1 << BITS, -ROOT_2, 1 << BITS, off))
    (_, plus), (_, minus) = exact_real_roots(IntegerQuadratic(1, -1, -1)), exact_real_roots(IntegerQuadratic(1, 1, -1))
    assert compare_roots(rounded[0], minus) == 0
    assert compare_roots(rounded[1], plus) == 0
    assert compare_roots(rounded[0], plus) == -1
    assert [float(r) for r in rounded] == [0.41421356237309504880, 2.41421356237309504880]


def test_a_rounded_touch_is_a_touch() -> None:
    """t² - 2 √2 t + 2 touches zero; with 2 - 2^-2000 it crosses."""
    off = (0, 2, 0)
    assert exact_real_roots(IntegerQuadratic(1 << BITS, -ROOT_2, 2 << BITS, off)) == ()
    assert len(exact_real_roots(IntegerQuadratic(1 << BITS, -ROOT_2, (2 << BITS) - (1 << 1000), off))) == 2
    assert exact_real_roots(IntegerQuadratic(1 << BITS, -ROOT_2, (2 << BITS) + (1 << 1000), off)) == ()


def test_a_root_at_the_origin_is_zero_exactly() -> None:
    zero = rational_root(Fraction(0))
    for q in (
        IntegerQuadratic(3 << BITS, ROOT_2, 0, (0, 2, 0)),
        IntegerQuadratic(3 << BITS, -ROOT_2, 0, (0, 2, 0)),
        IntegerQuadratic(-(3 << BITS), -ROOT_2, 0, (0, 2, 0)),
    ):
        low, high = exact_real_roots(q)
        assert [compare_roots(low, zero), compare_roots(high, zero)] in ([-1, 0], [0, 1])
        assert {float(low), float(high)} == {0.0, -2 * q.b / q.a}
    (line,) = exact_real_roots(IntegerQuadratic(0, ROOT_2, 0, (0, 2, 0)))
    assert compare_roots(line, zero) == 0


def test_hundreds_of_surfaces_through_one_point_are_one_place(noted_calls) -> None:
    """The roots of (t - 1) (k t - k - 3) share 1, while the others, 1 + 3 / k, differ.

    The roots ±√2 of all multiples are two.
    """
    calls = noted_calls(order, "compare_roots")
    places = [order.ZERO]
    for k in range(1, 201):
        places += exact_real_roots(IntegerQuadratic(2 * k, -(2 * k + 3), 2 * (k + 3)))
        places += exact_real_roots(IntegerQuadratic(k, 0, -2 * k))
    ranks = order.exact_ranks(places)
    # -√2 < 0 < 1 < 1 + 3/200 < ... < 1 + 3/8 < √2 < 1 + 3/7 < ... < 4
    one, others, below, above = ranks[1::4], ranks[2::4], ranks[3::4], ranks[4::4]
    assert set(one) == {1.0}
    assert set(below) == {-1.0}
    assert others == [202.0 - k + (k <= 7) for k in range(1, 201)]
    assert set(above) == {195.0}
    assert len(calls) < 800
