"""Rays that are said and not yet made: each part of them is made where it is traced."""

from __future__ import annotations

import math
from typing import TYPE_CHECKING, Any, NoReturn

import numpy as np

from ...shapes.arrays import real_array
from ...shapes.calls import explained_methods
from ...shapes.calm import calm
from ...shapes.other_names import hinted
from ...shapes.vector import FloatArray
from ..threads import run_chunks
from .no_array import NoArray
from .rays import Rays, first_wrong

_BLOCK = 1 << 12


@hinted
@explained_methods
class LazyRays(NoArray):
    """Rays of a camera or a scan, which take a few bytes until they are traced, also on other machines.

    Every query takes them in place of `Rays`; `made()` has them as such. Those of any part are the same to the bit.
    """

    instead = "rays.made()"
    _in_blocks = True
    """Are they worked out, and not read?"""

    @property
    def shape(self) -> tuple[int, ...]:
        """The leading shape."""
        raise NotImplementedError

    @property
    def interval(self) -> tuple[float, float]:
        """t_min and t_max of queries that say nothing else."""
        return 0.0, math.inf

    @property
    def ndim(self) -> int:
        """How many axes `shape` has."""
        return len(self.shape)

    @property
    def size(self) -> int:
        """How many rays there are."""
        count = 1
        for length in self.shape:
            count *= length
        return count

    def __len__(self) -> int:
        return self.shape[0]

    if not TYPE_CHECKING:  # else checkers would let rays that are not made be told apart

        def __getitem__(self, index: Any) -> NoReturn:
            told = "rays.part(begin, end) are some of them, and rays.made()[...] any"
            raise TypeError(f"{type(self).__name__}: rays are made where they are traced: {told}")

        def __iter__(self) -> NoReturn:
            told = "origins, directions = rays.made() are two arrays of all"
            raise TypeError(f"{type(self).__name__}: rays are made where they are traced: {told}")

    def made(self) -> Rays:
        """All of them as `Rays`, 48 bytes each; these have no interval of their own, so queries of them start at 0."""
        return self.part(0, self.size, self.shape)

    @calm
    def part(self, begin: int, end: int, shape: tuple[int, ...] | None = None) -> Rays:
        """Flat rays `begin` to `end`, counted with the last axis the fastest; in another shape of so many if given."""
        made = (*(shape or (end - begin,)), 3)
        if not self._in_blocks:
            origins, directions = self._lines(begin, end)
            return Rays(origins.reshape(made), directions.reshape(made))
        origins, directions = np.empty(made), np.empty(made)
        if self._fill_all(begin, origins.reshape(-1, 3), directions.reshape(-1, 3)):
            return Rays._spawned(origins, directions, np.array([-1], np.int32))
        return Rays(origins, directions)  # which says what is wrong, and where

    def _fill_all(self, begin: int, origins: FloatArray, directions: FloatArray) -> bool:
        """`_fill`, some at a time, that what is worked out stays near the processor, and by all threads: all right?"""
        wrong = []

        def fill(first: int, last: int) -> None:
            lines = origins[first:last], directions[first:last]
            self._fill(begin + first, *lines)
            if first_wrong(*lines) is not None:
                wrong.append(first)

        run_chunks(fill, len(origins), _BLOCK)
        return not wrong

    def _fill(self, begin: int, origins: FloatArray, directions: FloatArray) -> None:
        """Write `_lines` from the flat ray `begin` on into arrays (n, 3)."""
        origins[:], directions[:] = self._lines(begin, begin + len(origins))

    def _lines(self, begin: int, end: int) -> tuple[FloatArray, FloatArray]:
        """Origins and directions (n, 3) of flat rays `begin` to `end`."""
        raise NotImplementedError

    def _share(self, begin: int, end: int) -> tuple[LazyRays, int, int]:
        """What makes flat rays `begin` to `end`, in as few bytes as may be, and their numbers there."""
        return self, begin, end

    def __repr__(self) -> str:
        return f"{type(self).__name__}(shape={self.shape})"


class ArrayRays(LazyRays):
    """Rays in two arrays (n, 3), or one (n, 6), which may be on a disk: what is sliced is read, and nothing else."""

    _in_blocks = False

    def __init__(self, origins: Any, directions: Any = None) -> None:
        self._origins, self._directions = origins, directions
        for name, array, last in (("origins", origins, 6 if directions is None else 3), ("directions", directions, 3)):
            shape = getattr(array, "shape", None)
            if array is not None and (shape is None or len(shape) != 2 or shape[1] != last):
                raise ValueError(f"rays: {name} must be an array of shape (n, {last}), got {shape}")
        if directions is not None and len(origins) != len(directions):
            told = f"{len(origins)} and {len(directions)}"
            raise ValueError(f"rays: origins and directions must be as many, got {told}")

    @property
    def shape(self) -> tuple[int, ...]:
        return (len(self._origins),)

    def _lines(self, begin: int, end: int) -> tuple[FloatArray, FloatArray]:
        first = real_array("rays", "origins", self._origins[begin:end], "an array of numbers")
        if self._directions is None:
            return first[:, :3], first[:, 3:]
        return first, real_array("rays", "directions", self._directions[begin:end], "an array of numbers")

    def _share(self, begin: int, end: int) -> tuple[LazyRays, int, int]:
        origins, directions = self._lines(begin, end)
        return ArrayRays(origins.copy(), directions.copy()), 0, end - begin
