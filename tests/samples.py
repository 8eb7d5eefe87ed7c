"""A sample of many cases: some are fast tests, and the others are deep ones, which a fast run does not even collect."""

from __future__ import annotations

from collections.abc import Container, Iterable
from typing import Any

import pytest

_FAST_ALONE = "not deep"
_marks = [""]
"""What `-m` says; `tests/conftest.py` puts it here."""


def choose(marks: str) -> None:
    """Keep what `-m` says, before tests are collected."""
    _marks[0] = marks


def size(fast: int, deep: int) -> int:
    """Return how many rays, examples or steps a test takes in this run."""
    return fast if quick() else deep


def quick() -> bool:
    """Return whether this run wants no deep case."""
    return _marks[0] == _FAST_ALONE


def sampled(cases: Iterable[Any], every: int) -> list[Any]:
    """Return cases for `pytest.mark.parametrize`: one in `every` is fast."""
    return marked((case, number % every == 0) for number, case in enumerate(cases))


def in_turn(firsts: Iterable[Any], seconds: Iterable[Any], wanted: Container[Any] | None = None) -> list[Any]:
    """Return pairs for `pytest.mark.parametrize`: each wanted first value is fast with one second value, in turn."""
    others = list(seconds)
    return marked(
        ((one, other), number == place % len(others) and (wanted is None or one in wanted))
        for place, one in enumerate(firsts)
        for number, other in enumerate(others)
    )


def marked(cases: Iterable[tuple[Any, bool]]) -> list[Any]:
    """Return those of (case, is it fast) that this run may want, with their marks."""
    return [case if fast else deep(case) for case, fast in cases if fast or not quick()]


def deep(case: Any) -> Any:
    """Return a case that only `make deep` runs."""
    values = case if isinstance(case, tuple) else (case,)
    return pytest.param(*values, marks=pytest.mark.deep)
