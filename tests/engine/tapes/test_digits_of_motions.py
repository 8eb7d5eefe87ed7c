"""The digits of motions' numbers, beside fractions: also of motions that four floats settle and 253 bits leave open.

Four floats hold 1 + 2⁻²⁹⁰ exactly, 253 bits do not: a test of signs by the difference is open in them.
"""

from __future__ import annotations

from fractions import Fraction
from itertools import product

import numpy as np
import pytest

from conicoid.geometry.transform import Motion
from conicoid.prepare.motion_batch import MotionBatch

from .test_wide import bound, value


def minor(m, i, j):
    (a, b), (c, d) = [[m[r][s] for s in range(3) if s != j] for r in range(3) if r != i]
    return a * d - b * c


def numbers_of(rows):
    """A matrix without a shift, its shift, its inverse by Cramer's rule, and the shift of that."""
    m = [[Fraction(entry) for entry in row] for row in rows]
    size = sum((-1) ** j * m[0][j] * minor(m, 0, j) for j in range(3))
    inverse = [(-1) ** (i + j) * minor(m, j, i) / size for i, j in product(range(3), range(3))]
    return [*(entry for row in m for entry in row), 0, 0, 0, *inverse, 0, 0, 0]


def flat(k):
    """Two rows are nearly at a right angle: 1 + t² - 1."""
    t = 2.0**-145 * (1 + k / 64)
    return [[1.0, t, 1.0], [1.0, t, -1.0], [0.0, 1.0, 0.0]]


def thin(k):
    """Its determinant is -t."""
    t = 2.0**-300 * (1 + k / 64)
    return [[1.0, t, 1.0], [1.0, 1.0, 0.0], [1.0, 0.0, 1.0]]


@pytest.mark.parametrize("hard", [flat, thin])
def test_digits(hard):
    random = np.random.default_rng(0)
    every = [*random.normal(size=(12, 3, 3)).tolist(), *(hard(k) for k in range(6))]
    motions = MotionBatch()
    asked = [motions.row(Motion().transform([[*row, 0.0] for row in rows] + [[0, 0, 0, 1.0]]).steps) for rows in every]
    given, _, _ = motions.compute()
    for some in (asked[:6], asked[12:], asked[5:14]):
        digits = given.digits(np.array(some, np.int32))
        for row, rows in zip(digits, (every[asked.index(one)] for one in some), strict=True):
            for number, true in zip(row, numbers_of(rows), strict=False):
                assert abs(value(number) - true) <= bound(number)
                assert bound(number) <= abs(true) * Fraction(2) ** -200
