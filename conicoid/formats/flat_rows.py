"""Arrays that broadcast to the shape of rays, some flat rows of them at a time."""

from __future__ import annotations

import math
from collections.abc import Callable
from typing import Any

import numpy as np

ORIGINS, DIRECTIONS = "origins", "directions"
WIDTHS: dict[str, tuple[int, ...]] = {ORIGINS: (3,), DIRECTIONS: (3,), "t_min": (), "t_max": ()}
"""The arrays of rays, and what follows their leading shape."""
Read = Callable[[int, int], Any]


def leading_shape(shapes: dict[str, tuple[int, ...]]) -> tuple[int, ...]:
    """That of the rays whose arrays have these shapes. Raises ValueError for what does not fit together."""
    for name in (ORIGINS, DIRECTIONS):
        if name not in shapes:
            found = ", ".join(shapes) or "nothing"
            raise ValueError(f"must hold the arrays origins and directions (and t_min, t_max), got {found[:120]}")
        if not shapes[name] or shapes[name][-1] != 3:
            raise ValueError(f"{name} must have shape (..., 3), got {shapes[name]}")
    try:
        rays: tuple[int, ...] = np.broadcast_shapes(shapes[ORIGINS], shapes[DIRECTIONS])[:-1]
    except ValueError:
        raise ValueError(
            f"origins {shapes[ORIGINS]} and directions {shapes[DIRECTIONS]} do not broadcast together"
        ) from None
    for name in ("t_min", "t_max"):
        if name in shapes and not _fits(shapes[name], rays):
            raise ValueError(
                f"t_min and t_max must broadcast to the rays' shape {rays}, got {name} of shape {shapes[name]}"
            )
    return rays


def _fits(shape: tuple[int, ...], rays: tuple[int, ...]) -> bool:
    try:
        return bool(np.broadcast_shapes(shape, rays) == rays)
    except ValueError:
        return False


def rows_of(array: Any, shape: tuple[int, ...]) -> Read:
    """Flat rows `begin` to `end` of what is sliced along its first axis, with the leading shape of the rays."""
    each = math.prod(shape[1:])

    def read(begin: int, end: int) -> Any:
        first = begin // each
        some = np.asarray(array[first : -(-end // each)], np.float64)
        return some.reshape(-1, *some.shape[len(shape) :])[begin - first * each : end - first * each]

    return read


def broadcast_rows(array: Any, shape: tuple[int, ...]) -> Read:
    """The same of an array in memory, of which one row stands for many."""
    last = array.shape[-1:] if array.ndim and array.shape[-1:] == (3,) else ()
    whole = np.broadcast_to(array, (*shape, *last))

    def read(begin: int, end: int) -> Any:
        return whole[np.unravel_index(np.arange(begin, end), shape)]

    return read
