"""Memory of edited scenes: the next one takes that of one that is gone, and writes only the rows in which it differs.

Scenes that come from one another by exchanging entries for others with as many rows have their rows in the same
places. Each says of its entries by which edit their rows were written, its stamps: where those of two scenes are equal
so are the rows, but for the numbers of surfaces in them. By which edit surfaces got these is told for all together.
Memory comes back when nothing is left of a scene that reads it: neither itself nor an answer, a thread or an array that
was taken out of it. So a scene that somebody holds is never written to.

That nothing is left is told by the count of references to what all arrays of a scene hold, and not by the collector of
cycles: it does not look into NumPy's arrays, so it takes what these hold for something that is in use. Did it look into
them, it would tell of a cycle that is gone before what is in it is asked, by `__del__`, whether it is to come back.
"""

from __future__ import annotations

import math
import weakref
from collections import deque
from dataclasses import dataclass
from itertools import count
from typing import Any

import numpy as np
import numpy.typing as npt

from ...kernels.tables import (
    EXTENT,
    LEAF_ITEMS,
    LENGTHS,
    NODE_BOXES,
    NODE_CHILDREN,
    ROOTS,
    SPARE,
    SURFACE_KIND,
    SURFACE_ROW,
    TREE_DEPTH,
    TREE_ORDER,
    TREE_ROOT,
    Floats,
    Geometry,
    Ints,
    Longs,
    Tables,
    line_array,
    places_of,
)

Array = npt.NDArray[Any]
_TREES = (LEAF_ITEMS, NODE_BOXES, EXTENT, NODE_CHILDREN, TREE_ORDER, TREE_ROOT, ROOTS, TREE_DEPTH)
_LAST = (SURFACE_KIND, SURFACE_ROW, *_TREES)
_ORDER = (*(k for k in range(LENGTHS) if k not in _LAST), *_LAST)
"""Last comes what may grow: the table of surfaces, when one parts from another, and trees, which are always written.

The items of leaves come first of trees, as most of them are never written.
"""
_NODE = 64
"""More than the numbers, of either kind, of a node or of what a leaf says of an entry."""
MOST = 1 << 30
"""Bytes of memory that are kept for the next scene."""
_edits = count(1)


def next_edit_number() -> int:
    """What tells an edit apart from all others."""
    return next(_edits)


def stamp_entries(entries: int) -> Longs:
    """Stamps of a scene whose rows are equal to nobody's."""
    return np.broadcast_to(np.int64(next(_edits)), entries)


def restamp_entries(stamps: Longs, fresh: list[int]) -> Longs:
    """The stamps of a scene in which some entries are new, or have other numbers in their rows."""
    found = stamps.copy()
    found[fresh] = next(_edits)
    return found


class _LifetimeToken:
    """Is there as long as somebody reads one of the arrays that were handed out with it."""

    __slots__ = ("__weakref__",)


class _TokenArray:
    """An array that is handed out."""

    def __init__(self, array: Array, held: _LifetimeToken) -> None:
        self.__array_interface__ = array.__array_interface__
        self._array, self._held = array, held


class SceneBuffer:
    """The memory of one scene at a time: what kernels take, and what else has rows, by name."""

    def __init__(self, integers: Ints, floats: Floats) -> None:
        self.integers, self.floats = integers, floats
        self.beside: dict[str, Array] = {}
        self.frame: Any = None
        """What the places of surfaces among these are relative to."""
        self.stamps: Longs = np.zeros(0, np.int64)
        self.numbers = 0

    @property
    def nbytes(self) -> int:
        """Bytes of all arrays."""
        return self.integers.nbytes + self.floats.nbytes + sum(array.nbytes for array in self.beside.values())


@dataclass(frozen=True)
class PoolMemory:
    """Whose memory scenes of one kind may take, and what is known of that of one of them."""

    stores: BufferPool
    stamps: Longs  # by which edit the rows of each entry were written
    numbers: int  # by which edit surfaces got the numbers that they have in the table
    store: SceneBuffer | None = None  # its memory; None where that is none that may be taken
    held: weakref.ref[_LifetimeToken] | None = None

    @classmethod
    def new(cls, entries: int) -> PoolMemory:
        """Of a scene that has nothing in common with others, in memory of its own."""
        return cls(BufferPool(), stamp_entries(entries), next_edit_number())

    def claim(self) -> BufferClaim | None:
        """Take the memory of the scene, which the caller has let go of, or keep others from it; None: it is gone."""
        if self.store is None:
            return BufferClaim()
        held = self.held() if self.held is not None else None
        if held is not None:
            return BufferClaim(held=held)
        opened = self.stores.take(self.store)
        return None if opened is None else BufferClaim(opened)


@dataclass(frozen=True)
class BufferClaim:
    """The memory of the scene that another one is made from: that one's own, or somebody's who holds it."""

    opened: OpenBuffer | None = None
    held: _LifetimeToken | None = None


class OpenBuffer:
    """A store for the next scene; nobody else has it. `close` says that the scene is finished."""

    def __init__(self, store: SceneBuffer) -> None:
        self._store, self._held = store, _LifetimeToken()
        self.stamps, self.numbers, self.frame = store.stamps, store.numbers, store.frame
        self.beside = {name: self._out(array) for name, array in store.beside.items()}

    @classmethod
    def new(cls, tables: Tables) -> OpenBuffer:
        """Room for a scene with tables of these shapes; its trees may grow by those of what moves about.

        The table of surfaces may, until none is one with another.
        """
        _, integers, floats = places_of(tables, _ORDER)
        more = len(tables.node_children) // 4 + 4 * math.isqrt(len(tables.entry_kind)) + 8
        rows = len(tables.planes) + len(tables.spheres) + len(tables.quadrics) - len(tables.surface_kind)
        room = line_array(floats + more * _NODE + SPARE)
        return cls(SceneBuffer(np.empty(integers + more * _NODE + 2 * max(rows, 0), np.int32), room))

    def _out(self, array: Array) -> Array:
        return np.asarray(_TokenArray(array, self._held))

    def put(self, name: str, array: Array) -> Array:
        """Keep an array that nobody else has; returns it as it may be handed out."""
        self._store.beside[name] = array
        self.beside[name] = out = self._out(array)
        return out

    def geometry(self, tables: Tables) -> Geometry | None:
        """The memory for tables of these shapes; None where trees have grown out of it."""
        places, integers, floats = places_of(tables, _ORDER)
        if integers > len(self._store.integers) or floats + SPARE > len(self._store.floats):
            return None
        out = self._out(self._store.integers), self._out(self._store.floats)
        out[1][places[EXTENT] + tables.extent.size : floats + SPARE] = 0.0  # all between two tables is 0, and behind
        return Geometry(places, out[0][:integers], out[1][: floats + SPARE])

    def raw(self, name: str) -> Array:
        """An array beside the tables that does not say whether the scene is held."""
        return self._store.beside[name]

    def memory(self, stores: BufferPool, stamps: Longs, numbers: int) -> PoolMemory:
        """What is to be known of the memory; it is nobody's but the scene's until `close`."""
        return PoolMemory(stores, stamps, numbers, self._store, weakref.ref(self._held))

    def close(self, memory: PoolMemory, frame: Any) -> None:
        """The scene is finished: when it is gone the memory goes to others of its kind."""
        self._store.stamps, self._store.numbers, self._store.frame = memory.stamps, memory.numbers, frame
        weakref.finalize(self._held, _return_buffer, weakref.ref(memory.stores), self._store).atexit = False


class BufferPool:
    """What scenes with their rows in the same places share: at most one store that nobody reads."""

    def __init__(self) -> None:
        self._free: deque[SceneBuffer] = deque(maxlen=1)

    def take(self, wanted: SceneBuffer | None = None) -> OpenBuffer | None:
        """A store in which an earlier scene's rows are, if need be that one; None if there is none."""
        try:
            found = self._free.pop()
        except IndexError:
            return None
        if wanted is not None and found is not wanted:
            self._free.append(found)
            return None
        return OpenBuffer(found)

    def give(self, store: SceneBuffer) -> None:
        """A store of which nobody reads anything. It may come at any time: nothing here waits for a lock."""
        if store.nbytes <= MOST:
            self._free.append(store)


def _return_buffer(stores: weakref.ref[BufferPool], store: SceneBuffer) -> None:
    known = stores()
    if known is not None:
        known.give(store)
