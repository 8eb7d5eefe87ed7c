"""Shell sort of integers by a compiled rule, and its gaps for sorts of other data."""

from __future__ import annotations

from collections.abc import Callable
from typing import Any

from ..._jit.decorators import helper, inline


@inline
def first_gap(count: int) -> int:
    """Return the first gap of Shell's sort for `count` numbers; gaps grow by 9/4, after Ciura (2001)."""
    gap = 1
    while gap < count // 2:
        gap = gap * 9 // 4 + 1
    return gap


@inline
def next_gap(gap: int) -> int:
    """Return the gap after `gap`; 0 ends the sort."""
    return gap * 4 // 9


def make_sort(comes_after: Callable[[Any, int, int], bool]) -> Callable[[Any, int, Any], None]:
    """Return a compiled function sort(numbers, count, data) that sorts the first `count` numbers by a compiled rule.

    After the sort, comes_after(data, a, b) holds for no a that stands before b.
    """
    # A closure: Numba would put the address of a rule passed as an argument into the code, which could not be cached

    @helper
    def sort(numbers: Any, count: int, data: Any) -> None:
        gap = first_gap(count)
        while gap > 0:
            for i in range(gap, count):
                number, j = numbers[i], i
                while j >= gap and comes_after(data, numbers[j - gap], number):
                    numbers[j] = numbers[j - gap]
                    j -= gap
                numbers[j] = number
            gap = next_gap(gap)

    return sort
