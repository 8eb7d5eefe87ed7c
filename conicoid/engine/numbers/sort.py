"""Sorting integers that number things, by a comparison of the things: Shell's sort."""

from __future__ import annotations

from typing import Any

from ...compiler.jit import helper, inline


@inline
def first_gap(count: int) -> int:
    """The first gap of Shell's sort for some numbers: they grow by 9/4, after Ciura (2001)."""
    gap = 1
    while gap < count // 2:
        gap = gap * 9 // 4 + 1
    return gap


@inline
def next_gap(gap: int) -> int:
    """The gap after another; 0 ends the sort."""
    return gap * 4 // 9


@helper
def sort_numbers(numbers: Any, count: int, comes_after: Any, data: Any) -> None:
    """Order the first `count` numbers so that comes_after(data, a, b) holds for no a before b. In place; not stable.

    Relies on `comes_after` being a strict weak order; whoever needs ties in a fixed order compares the numbers too.
    """
    gap = first_gap(count)
    while gap > 0:
        for i in range(gap, count):
            number, j = numbers[i], i
            while j >= gap and comes_after(data, numbers[j - gap], number):
                numbers[j] = numbers[j - gap]
                j -= gap
            numbers[j] = number
        gap = next_gap(gap)
