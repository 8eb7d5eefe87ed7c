"""Different numbers, against NumPy's `unique`."""

from __future__ import annotations

import numpy as np
import pytest

from conicoid._util.arrays import is_member_sorted, unique_first_with_inverse, unique_sorted, unique_with_inverse

RANDOM = np.random.default_rng(7)
ARRAYS = [
    np.zeros(0, np.int64), np.array([5]), np.full(9, -2), RANDOM.integers(-4, 5, 1000), RANDOM.integers(0, 10**6, 500),
    RANDOM.integers(0, 50, 300).astype(np.int32), RANDOM.integers(-9, 9, 400) / 4.0, np.array([0.0, -0.0, np.inf, -np.inf, 0.0]),
]  # fmt: skip


@pytest.mark.parametrize("numbers", ARRAYS)
def test_they_are_those_of_numpy(numbers: np.ndarray) -> None:
    values, first, place = np.unique(numbers, return_index=True, return_inverse=True)
    assert np.array_equal(unique_sorted(numbers), values)
    assert np.array_equal(unique_sorted(numbers[:3], numbers, numbers[-2:]), values)
    found, places = unique_with_inverse(numbers)
    assert np.array_equal(found, values)
    assert np.array_equal(places, place)
    assert all(np.array_equal(*pair) for pair in zip(unique_first_with_inverse(numbers), (first, place), strict=True))
    assert np.array_equal(is_member_sorted(numbers, values[::2]), np.isin(numbers, values[::2]))
