"""Inner functions from Numba's own `njit`, and how often they are compiled."""

import numba
import numpy as np

from conicoid.jit import helper, inline, kernel


@inline
def half(x: float) -> float:
    return 0.5 * x


@helper
def half_of_element(values: np.ndarray, k: int) -> float:
    return half(values[k])


@helper
def sum_of_halves(values: np.ndarray) -> float:
    return half_of_element(values, 0) + half_of_element(values, np.int32(1)) + half_of_element(values, len(values) - 1)


def test_njit_finds_what_an_inner_function_calls():
    @numba.njit
    def outer(values):
        return sum_of_halves(values) + half_of_element(values, 0)

    assert outer(np.array([2.0, 4.0, 6.0])) == 7.0


def test_a_kernel_is_linked_with_all_that_it_calls():
    outer = kernel(lambda values: sum_of_halves(values))
    assert outer(np.array([2.0, 4.0, 8.0])) == 7.0


def test_constants_and_widths_do_not_multiply_a_function():
    sum_of_halves.compile((numba.float64[::1],))
    assert len(half_of_element.overloads) == 1
