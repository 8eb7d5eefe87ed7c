"""A sample of many cases: some are fast tests, and the others are deep ones, which a fast run does not collect.

A deep run takes a part of the cases that differ in chance alone, by a seed that the head of its report shows. Other
runs take other parts. `DEEP_SEED=7 make deep` repeats a run; `DEEP_SEED=all` takes all, for hours.
"""

import os
import random
import secrets
from collections.abc import Container, Iterable, Sequence
from typing import Any, TypeVar

import pytest

T = TypeVar("T")
SEED = os.environ.setdefault("DEEP_SEED", str(secrets.randbelow(10_000)))
"""The seed is in the environment, so that the workers of a run share one."""
CASES = 40
"""How many deep cases of each test a run takes: all kinds, and some of the products of kinds, motions and seeds."""
_FAST_ALONE = "not deep"
_marks = [""]
"""The value of `-m`, which `tests/conftest.py` puts here."""


def choose(marks: str) -> None:
    """Take the marks of `-m`, before pytest collects tests."""
    _marks[0] = marks


def quick() -> bool:
    """Return whether this run excludes deep cases."""
    return _marks[0] == _FAST_ALONE


def many(fast: int, deep: int) -> int:
    """Return the size of a sample: that of a fast run, or that of a deep one."""
    return fast if quick() else deep


def drawn(cases: Sequence[T], count: int, name: str = "") -> list[T]:
    """Return so many random cases in order, or all of them if this run takes all. Each name has its own draw."""
    places = range(len(cases))
    if SEED != "all" and count < len(cases):
        places = sorted(random.Random(f"{SEED} {name}").sample(places, count))
    return [cases[place] for place in places]


def sampled(cases: Iterable[Any], every: int) -> list[Any]:
    """Return cases for `pytest.mark.parametrize`: one in `every` is fast."""
    return marked((case, number % every == 0) for number, case in enumerate(cases))


def in_turn(firsts: Iterable[Any], seconds: Iterable[Any], wanted: Container[Any] | None = None) -> list[Any]:
    """Return pairs for `pytest.mark.parametrize`: each first value (of those `wanted`) is fast with one second value, in turn."""
    others = list(seconds)
    return marked(
        ((one, other), number == place % len(others) and (wanted is None or one in wanted))
        for place, one in enumerate(firsts)
        for number, other in enumerate(others)
    )


def marked(cases: Iterable[tuple[Any, bool]]) -> list[Any]:
    """Return those of (case, whether it is fast) that this run may take, with their marks."""
    return [case if fast else deep(case) for case, fast in cases if fast or not quick()]


def deeper(cases: Iterable[Any]) -> list[Any]:
    """Return cases that only `make deep` runs. A fast run does not collect them."""
    return [] if quick() else [deep(case) for case in cases]


def deep(case: Any) -> Any:
    """Return a case that only `make deep` runs."""
    values = case if isinstance(case, tuple) else (case,)
    return pytest.param(*values, marks=pytest.mark.deep)
