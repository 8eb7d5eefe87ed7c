"""A sample of many cases: some are fast tests, and the others are deep ones."""

from __future__ import annotations

from collections.abc import Iterable
from typing import Any

import pytest


def sampled(cases: Iterable[Any], every: int) -> list[Any]:
    """Return cases for `pytest.mark.parametrize`: one in `every` is fast."""
    return [case if number % every == 0 else deep(case) for number, case in enumerate(cases)]


def in_turn(firsts: Iterable[Any], seconds: Iterable[Any]) -> list[Any]:
    """Return all pairs for `pytest.mark.parametrize`: each first value is fast with one second value, these in turn."""
    others = list(seconds)
    return [
        pair if number == place % len(others) else deep(pair)
        for place, one in enumerate(firsts)
        for number, pair in enumerate((one, other) for other in others)
    ]


def deep(case: Any) -> Any:
    """Return a case that only `make deep` runs."""
    values = case if isinstance(case, tuple) else (case,)
    return pytest.param(*values, marks=pytest.mark.deep)
