"""The rule of ties, by itself."""

import math

import pytest

from conicoid.kernels.body.hit import comes_first, may_tie


@pytest.mark.parametrize(
    ("first", "other"),
    [((1.0, 5), (2.0, 0)), ((1.0, 0), (1.0, 5)), ((-2.0, 3), (-1.0, 0)), ((1.0, 7), (math.inf, -1))],
)
def test_the_nearer_and_then_the_body_listed_first(first, other):
    assert comes_first(*first, *other)
    assert not comes_first(*other, *first)


@pytest.mark.parametrize("body", [-1, 0, 3])
def test_a_miss_never_comes_first(body):
    assert not comes_first(math.inf, body, math.inf, -1)
    assert not comes_first(math.inf, body, 1e300, 4)


def test_misses_are_never_too_close():
    assert not may_tie(math.inf, 0.0, math.inf, 0.0)
    assert not may_tie(math.inf, 1e-9, 1.0, 1e-9)
    assert may_tie(1.0, 2e-9, 1.0 + 3e-9, 2e-9)
