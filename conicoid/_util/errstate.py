"""NumPy's settings for floating-point errors, which are the caller's, kept out of what is worked out here."""

from __future__ import annotations

import functools
from collections.abc import Callable
from typing import ParamSpec, TypeVar

import numpy as np

from .hints import misfit_error

P = ParamSpec("P")
R = TypeVar("R")


def ignore_fp_errors(function: Callable[P, R]) -> Callable[P, R]:
    """The function with no warnings or errors of NumPy's, whatever `np.seterr` or `np.errstate` says around it.

    Overflows and NaN are looked for where they matter. An underflow, which is harmless, may not stop anything.
    A call that does not fit is told in words of our own.
    """

    @functools.wraps(function)
    def calmly(*args: P.args, **keywords: P.kwargs) -> R:
        try:
            with np.errstate(all="ignore"):
                return function(*args, **keywords)
        except TypeError as error:
            if (told := misfit_error(function, args, keywords, error)) is None:
                raise
            raise told from None

    return calmly
