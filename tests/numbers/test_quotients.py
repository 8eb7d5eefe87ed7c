"""Quotients by a shared reciprocal, and unit vectors by it, against Python's own division."""

from __future__ import annotations

import math

import numpy as np

from conicoid.kernels.numbers.vectors import normalize, quotient, unit_vector

from ..compiled import compiled

QUOTIENT, UNIT, NORMALIZED = compiled(quotient), compiled(unit_vector), compiled(normalize)
RANDOM = np.random.default_rng(1990)
BELOW_TWO = 2.0 - 2.0**-52
"""All bits of its fraction are set: Markstein's theorem on reciprocals leaves it out, that on quotients does not."""


def same_bits(a, b):
    return np.array(a).tobytes() == np.array(b).tobytes()


def test_quotients_are_those_of_division():
    a = RANDOM.uniform(-2, 2, 20_000) * 2.0 ** RANDOM.integers(-400, 400, 20_000)
    b = RANDOM.uniform(1, 2, 20_000) * 2.0 ** RANDOM.integers(-400, 400, 20_000)
    for x, y in zip(a.tolist(), b.tolist(), strict=True):
        assert same_bits(QUOTIENT(x, y, 1.0 / y), x / y), (x, y)


def test_quotients_that_are_hard_to_round():
    """By divisors at either end of a binade, and of numbers just beside a multiple or a half of one."""
    ends = [1.0 + k * 2.0**-52 for k in range(40)] + [BELOW_TWO - k * 2.0**-52 for k in range(40)]
    for b in [*ends, 3.0, 511.0, 512.0, 1080.0, 2.0**31 - 1]:
        for q in RANDOM.uniform(1, 2, 50).tolist() + ends[::8]:
            for a in (q * b, math.nextafter(q * b, 0.0), math.nextafter(q * b, 9e9), (q + 2.0**-53) * b):
                assert same_bits(QUOTIENT(a, b, 1.0 / b), a / b), (a, b)


def test_divisors_at_the_ends_of_the_range():
    for b in (2.0**-900, 1.7 * 2.0**-900, 2.0**900, BELOW_TWO * 2.0**1023):
        for q in (RANDOM.uniform(1, 2, 200) * 2.0 ** RANDOM.integers(-400, 400, 200)).tolist():
            if 2.0**-900 <= q * b <= 2.0**900:
                assert same_bits(QUOTIENT(q * b, b, 1.0 / b), q * b / b), (q, b)


def test_places_of_all_pixels():
    for height in (1, 3, 7, 511, 1080):
        for k in range(-height, height + 1):
            assert same_bits(QUOTIENT(float(k), float(height), 1.0 / height), k / height)


def test_zeros_keep_their_signs():
    assert [math.copysign(1.0, QUOTIENT(zero, 3.0, 1.0 / 3.0)) for zero in (0.0, -0.0)] == [1.0, -1.0]


def test_unit_vectors_are_those_of_four_divisions():
    vectors = RANDOM.normal(size=(20_000, 3)) * 2.0 ** RANDOM.integers(-250, 250, (20_000, 3))
    vectors[::7, 1], vectors[::11, 2], vectors[::13, 0] = 0.0, -0.0, 0.0
    for vector in [*vectors.tolist(), [0.0, 0.0, 0.0], [-0.0, 0.0, 1e300], [1e-300, 3e-300, 2e-300]]:
        assert same_bits(UNIT(*vector), NORMALIZED(*vector)), vector
