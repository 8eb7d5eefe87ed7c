"""What Python does around the kernel for one ray: counted, as seconds depend on the machine."""

from __future__ import annotations

import sys
from fractions import Fraction
from typing import Any

import numpy as np
import pytest

import conicoid as co
from conicoid._jit.machine_code import SHIPPED
from conicoid._util.validation import real_array

CALLS = 16 if SHIPPED else 200
"""By a kept call of machine code 13; through arrays 163, and 357 when two tuples and two limits were checked twice."""


def _calls_of(ask: Any) -> int:
    """How many functions are called, Python's and those in C, from the second time on."""
    ask()
    count = 0

    def called(_frame: Any, event: str, _argument: Any) -> None:
        nonlocal count
        count += event in ("call", "c_call")

    before = sys.getprofile()
    sys.setprofile(called)
    try:
        ask()
    finally:
        sys.setprofile(before)
    return count


@pytest.mark.parametrize("kind", [tuple, list, np.array])
def test_a_query_of_one_ray_calls_few_functions(kind: Any) -> None:
    scene = co.Scene([co.Sphere(1.0, center=(x, 0.0, 0.0)) for x in (0.0, 3.0, 6.0)])
    origin, direction = kind((0.0, 0.0, 5.0)), kind((0.0, 0.0, -1.0))
    assert scene.first_hit(origin, direction).t == 4.0
    assert _calls_of(lambda: scene.first_hit(origin, direction)) <= CALLS
    assert _calls_of(lambda: scene.first_hit(origin, direction, 0.5, 10.0)) <= CALLS


@pytest.mark.parametrize(
    "number", [3, -0.0, 2**53 + 1, 2**63, -(2**64) - 1, 10**300 + 1, 5e-324, float("inf"), 2**1024 - 2**970 - 1]
)
def test_numbers_of_python_are_rounded_as_alone(number: Any) -> None:
    expected = float(Fraction(number)) if isinstance(number, int) else number
    for values in ((number, 0.5, 1), [number, 0.5, 1], number):
        found = real_array("Rays", "origins", values)
        assert found.dtype == np.float64
        first = float(found.ravel()[0])
        assert first.hex() == float(expected).hex()


@pytest.mark.parametrize("values", [(10**400, 0.0, 0.0), [0, 0, -(10**310)], 10**400])
def test_integers_beyond_floats_are_told(values: Any) -> None:
    with pytest.raises(ValueError, match=r"^Rays: origins must be numbers, got "):
        real_array("Rays", "origins", values, "numbers")
