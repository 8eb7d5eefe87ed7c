"""A sample of many cases: some are fast tests, and the others are deep ones."""

from __future__ import annotations

from collections.abc import Container, Iterable
from typing import Any

import pytest


def sampled(cases: Iterable[Any], every: int, also: Container[Any] = ()) -> list[Any]:
    """Return cases for `pytest.mark.parametrize`: one in `every`, and each that is in `also`, is fast."""
    return [
        case if number % every == 0 or case in also else deep(case)
        for number, case in enumerate(cases)
    ]  # fmt: skip


def deep(case: Any) -> Any:
    """Return a case that only `make deep` runs."""
    values = case if isinstance(case, tuple) else (case,)
    return pytest.param(*values, marks=pytest.mark.deep)
