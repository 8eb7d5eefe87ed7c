"""Rays still to be followed, with their weight in the picture: recursion without recursion."""

from __future__ import annotations

from typing import Any, NamedTuple, cast

import numpy as np
import numpy.typing as npt

from ..compiler.jit import allocator, inline
from ..engine.tables import Floats

FAINT = 2.0**-12
"""A ray that adds less than this share of what it meets is not followed."""

NO_SURFACE = cast(int, np.int64(-1))  # a Python int would be a type of its own to the compiler
"""Start of a ray that lies on no surface."""


class Pending(NamedTuple):
    """A ray to be followed."""

    x: float
    y: float
    z: float
    dx: float  # unit
    dy: float
    dz: float
    r: float  # its weight
    g: float
    b: float
    start: Any  # the surface that it lies on
    turns: Any  # how often it may be mirrored or refracted yet
    medium: Any  # that it starts in


class Stack(NamedTuple):
    """One row a ray."""

    floats: Floats  # as `Pending`, the first nine
    numbers: npt.NDArray[np.int64]  # and the others


@allocator
def new_stack(depth: int) -> Stack:
    """A stack for rays of at most `depth` turns: each level leaves at most one ray waiting."""
    return Stack(np.empty((depth + 2, 9)), np.empty((depth + 2, 3), np.int64))


@inline
def push(stack: Stack, size: int, ray: Pending) -> int:
    """Add a ray unless it is too faint to matter; returns the new size."""
    x, y, z, dx, dy, dz, r, g, b, start, turns, medium = ray
    if max(r, max(g, b)) < FAINT:
        return size
    row = stack.floats[size]
    row[0], row[1], row[2], row[3], row[4], row[5] = x, y, z, dx, dy, dz
    row[6], row[7], row[8] = r, g, b
    stack.numbers[size, 0], stack.numbers[size, 1], stack.numbers[size, 2] = start, turns, medium
    return size + 1


@inline
def pending(stack: Stack, k: int) -> Pending:
    """Ray k of a stack."""
    row, numbers = stack.floats[k], stack.numbers[k]
    return Pending(
        row[0], row[1], row[2], row[3], row[4], row[5], row[6], row[7], row[8], numbers[0], numbers[1], numbers[2]
    )
