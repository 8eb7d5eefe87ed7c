"""Rays that are said and not yet made: each part of them is made where it is traced."""

from __future__ import annotations

from typing import Any

import numpy as np

from ...shapes.arrays import real_array
from ...shapes.calls import explained_methods
from ...shapes.calm import calm
from ...shapes.vector import FloatArray
from ..threads import run_chunks
from .no_array import NoArray
from .rays import Rays

_BLOCK = 1 << 12


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

    def made(self) -> Rays:
        """All of them as `Rays`, 48 bytes each."""
        return self.part(0, self.size, self.shape)

    @calm
    def part(self, begin: int, end: int, shape: tuple[int, ...] | None = None) -> Rays:
        """Flat rays `begin` to `end`, counted with the last axis the fastest; in another shape of so many if given."""
        origins, directions = self._many_lines(begin, end)
        made = shape or (end - begin,)
        return Rays(origins.reshape((*made, 3)), directions.reshape((*made, 3)))

    def _many_lines(self, begin: int, end: int) -> tuple[FloatArray, FloatArray]:
        """`_lines`, some at a time, that what is worked out stays near the processor, and by all threads."""
        count = end - begin
        if not self._in_blocks or count <= _BLOCK:
            return self._lines(begin, end)
        origins, directions = np.empty((count, 3)), np.empty((count, 3))

        def fill(first: int, last: int) -> None:
            origins[first:last], directions[first:last] = self._lines(begin + first, begin + last)

        run_chunks(fill, count, _BLOCK)
        return origins, directions

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
