"""Exponents and neighbours by bits, against Python's own."""

from __future__ import annotations

import math

import numpy as np
import pytest

from conicoid.kernels.numbers import double_double as bits
from conicoid.kernels.ray import Ray, _scale, scale_ray

from ..compiled import compiled

ABOVE, BELOW = compiled(bits.next_float_up), compiled(bits.next_float_down)
EXPONENT, POWER, SCALED = compiled(bits.exponent_of), compiled(bits.power_of_two), compiled(bits.scale_by_power)

RANDOM = np.random.default_rng(20261122)
SOME = [
    *(2.0 ** RANDOM.uniform(-1074, 1024, 500)).tolist(),
    *(2.0**k for k in range(-1074, 1024)),
    1.7976931348623157e308,
]
SOME += [-x for x in SOME]


def test_neighbours():
    for x in (*SOME, 0.0, -0.0):
        assert ABOVE(x) == math.nextafter(x, math.inf)
        assert BELOW(x) == math.nextafter(x, -math.inf)
    assert (ABOVE(math.inf), BELOW(-math.inf)) == (math.inf, -math.inf)
    assert (ABOVE(-math.inf), BELOW(math.inf)) == (-1.7976931348623157e308, 1.7976931348623157e308)
    assert math.isnan(ABOVE(math.nan))


def test_exponents():
    assert [EXPONENT(x) for x in SOME] == [math.frexp(x)[1] - 1 for x in SOME]


def test_powers_of_two():
    assert [POWER(k) for k in range(-1022, 1024)] == [math.ldexp(1.0, k) for k in range(-1022, 1024)]
    for x in RANDOM.uniform(1, 2, 20).tolist():
        assert [SCALED(x, k) for k in range(-1022, 1024)] == [math.ldexp(x, k) for k in range(-1022, 1024)]


@pytest.mark.parametrize("exponent", [-1074, -1050, -1022, -700, -101, -99, 0, 99, 101, 700, 1023])
def test_the_scale_of_a_ray_is_a_power_of_two_that_brings_it_near_one(exponent):
    x = math.ldexp(1.0, exponent)
    given = Ray(0.0, 0.0, 0.0, x, -0.75 * x, 0.0, 0.0, math.inf, -1)
    ray, scale = compiled(scale_ray)(given)
    assert scale_ray(given) == (ray, scale)  # without a compiler, as where a ray is decided in exact arithmetic
    assert math.frexp(scale)[0] == 0.5
    assert ray.dx == x * scale
    assert (scale == 1.0) == (2.0**-100 < x < 2.0**100)
    assert 2.0**-100 < ray.dx < 2.0**100


def test_the_scale_of_every_exponent():
    scale = compiled(_scale)
    for x in (*SOME, 3e-300):
        if x > 1e-300:
            assert scale(x) == _scale(x) == math.ldexp(1.0, -math.frexp(x)[1])
