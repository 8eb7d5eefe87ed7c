"""Functions by sums and products alone, against mpmath at 30 digits."""

from __future__ import annotations

import math

import mpmath
import numpy as np
import pytest

from conicoid.numerics.portable_math import portable_cos, portable_exp, portable_exp2, portable_interp, portable_log2


def exactly(function, x):
    with mpmath.workdps(30):
        return np.array([float(function(mpmath.mpf(float(value)))) for value in x])


@pytest.mark.parametrize(
    ("found", "function", "x"),
    [
        (portable_exp, mpmath.exp, np.linspace(-20, 3, 301)),
        (portable_log2, lambda v: mpmath.log(v, 2), np.concatenate([np.geomspace(1e-30, 1e30, 301), [0.7, 1.5]])),
        (portable_cos, mpmath.cos, np.linspace(0, 2 * math.pi, 301)),
    ],
)
def test_near_to_exact(found, function, x):
    assert found(x) == pytest.approx(exactly(function, x), rel=1e-12, abs=1e-13)


def test_powers_of_two():
    assert [portable_exp2(k) for k in (-64, -1, 0, 1, 10)] == [2.0**k for k in (-64, -1, 0, 1, 10)]
    assert portable_exp2(-2.5) == pytest.approx(2**-2.5, rel=1e-13)


def test_between_values():
    places, values = np.array([0.0, 1.0, 1.0, 3.0]), np.array([2.0, 4.0, 5.0, -1.0])
    x = np.array([-1.0, 0.0, 0.25, 1.5, 3.0, 9.0])
    assert portable_interp(x, places, values) == pytest.approx(np.interp(x, places, values), abs=1e-15)
