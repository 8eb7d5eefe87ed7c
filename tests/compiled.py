"""Functions that only kernels call, compiled: Python interprets them, and cannot where they use instructions."""

from __future__ import annotations

from collections.abc import Callable
from typing import Any

import numba


def compiled(function: Callable[..., Any]) -> Callable[..., Any]:
    """Return a kernel that calls `function`."""

    @numba.njit(error_model="numpy")
    def call(*arguments):
        return function(*arguments)

    return call
