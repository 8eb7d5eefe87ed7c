"""Seed 000, ray and sphere: the algebraic and the geometric method, entering and leaving."""

from __future__ import annotations

import math
from fractions import Fraction

import pytest

from .along import CLOSE, first

CENTER, RADIUS = (1, -2, 3), 3
# The point (2, -4, 3) is the nearest to the centre on every line through it along (2, 1, 2)/3 or
# (2, 1, -2)/3: (1, -2, 0)·(2, 1, ±2) = 0. Its squared distance is 5, so half the chord is √(9 - 5) = 2.
NEAREST = (2, -4, 3)
DIRECTION = (Fraction(2, 3), Fraction(1, 3), Fraction(2, 3))


def start(before):
    return tuple(n - before * d for n, d in zip(NEAREST, DIRECTION, strict=True))


def algebraic(origin, direction):
    """t² + 2 B t + C = 0 with B = (R_d, R_0 - S_c), C = (R_0 - S_c)² - r²; the smaller positive root."""
    out = [o - c for o, c in zip(origin, CENTER, strict=True)]
    b = sum(d * x for d, x in zip(direction, out, strict=True))
    c = sum(x * x for x in out) - RADIUS**2
    discriminant = b * b - c
    if discriminant < 0:
        return None
    for t in (-b - math.sqrt(discriminant), -b + math.sqrt(discriminant)):
        if t > 0:
            return t
    return None


def geometric(origin, direction):
    """OC, t_ca = (OC, R_d), t_hc² = r² - OC² + t_ca²; minus from outside, plus from inside."""
    oc = [c - o for o, c in zip(origin, CENTER, strict=True)]
    distance2 = sum(x * x for x in oc)
    outside = distance2 > RADIUS**2
    t_ca = sum(x * d for x, d in zip(oc, direction, strict=True))
    if t_ca < 0 and outside:
        return None
    t_hc2 = RADIUS**2 - distance2 + t_ca**2
    if t_hc2 < 0:
        return None
    return t_ca - math.sqrt(t_hc2) if outside else t_ca + math.sqrt(t_hc2)


@pytest.mark.parametrize(
    ("before", "t", "entering"),
    [(6, 4, True), (0, 2, False), (1, 3, False), (-1, 1, False), (-3, None, False)],
    ids=["t0, t1 > 0: enters", "middle of the chord", "t0 < 0 < t1: leaves", "past the middle", "t0, t1 < 0: behind"],
)
def test_both_methods_and_the_library(before, t, entering):
    import conicoid as co

    origin = start(before)
    assert algebraic(origin, DIRECTION) == t
    assert geometric(origin, DIRECTION) == t
    hit = first(co.Sphere(RADIUS, CENTER), [float(x) for x in origin], [float(x) for x in DIRECTION])
    assert hit.entering == entering
    if t is None:
        assert hit.t == math.inf
        assert hit.body == -1
        return
    assert hit.t == pytest.approx(t, **CLOSE)
    point = [float(o + t * d) for o, d in zip(origin, DIRECTION, strict=True)]
    assert hit.point == pytest.approx(point, **CLOSE)
    # N = (R_i - S_c) / r
    assert hit.normal == pytest.approx([(p - c) / RADIUS for p, c in zip(point, CENTER, strict=True)], **CLOSE)


def test_negative_discriminant_is_a_miss():
    import conicoid as co

    # 4 beside the centre: C = 16 + 25 - 9 = 32, B = -5, D = 25 - 32 < 0
    assert algebraic((1, 2, -2), (0, 0, 1)) is None
    assert geometric((1, 2, -2), (0, 0, 1)) is None
    assert first(co.Sphere(RADIUS, CENTER), (1, 2, -2), (0, 0, 1)).t == math.inf


@pytest.mark.parametrize("length", [1, 0.5, 7])
def test_direction_need_not_be_unit(length):
    import conicoid as co

    hit = first(co.Sphere(RADIUS, CENTER), [float(x) for x in start(6)], [2 * length, length, 2 * length])
    assert hit.t == pytest.approx(4 / (3 * length), **CLOSE)
