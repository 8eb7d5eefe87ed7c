"""Run with NumPy floating-point warnings off, whatever `np.errstate` the caller has set."""

from __future__ import annotations

import functools
from collections.abc import Callable
from typing import ParamSpec, TypeVar

import numpy as np

P = ParamSpec("P")
R = TypeVar("R")


def ignore_fp_errors(function: Callable[P, R]) -> Callable[P, R]:
    """Return the function with NumPy warnings and errors off, whatever `np.seterr` or `np.errstate` the caller has set.

    Code checks for overflows and NaN where they matter, and a harmless underflow must not stop it.
    """

    @functools.wraps(function)
    def wrapper(*args: P.args, **keywords: P.kwargs) -> R:
        with np.errstate(all="ignore"):
            return function(*args, **keywords)

    return wrapper
