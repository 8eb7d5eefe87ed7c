"""The numbers of motions, beside fractions: also where terms cancel to less than 2⁻²⁹⁰ of themselves."""

from __future__ import annotations

from fractions import Fraction
from itertools import product

import numpy as np
import pytest

from conicoid.geometry.transform import Motion
from conicoid.prepare.motion_batch import MotionBatch

from .test_wide import error_of, sum_of


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
def test_they_are_known_to_195_bits(hard):
    random = np.random.default_rng(0)
    every = [*random.normal(size=(12, 3, 3)).tolist(), *(hard(k) for k in range(6))]
    motions = MotionBatch()
    asked = [motions.row(Motion().transform([[*row, 0.0] for row in rows] + [[0, 0, 0, 1.0]]).steps) for rows in every]
    given, _, _ = motions.compute()
    for row, rows in zip(given[asked], every, strict=True):
        for number, true in zip(row, numbers_of(rows), strict=False):
            assert abs(sum_of(number) - true) <= error_of(number)
            assert error_of(number) <= abs(true) * Fraction(2) ** -195
