"""Buffer pool: an edited scene reuses the buffers of a garbage-collected one; and the state that the next edit needs.

Scenes that come from one another by exchanging entries for others with as many rows have their rows in the same places.
Each scene has stamps: for each entry the number of the edit that wrote its rows. Where the stamps of two scenes are
equal, so are the rows, except for the numbers of surfaces in them; one number tells by which edit all surfaces got
these. A buffer returns to the pool when nothing that reads it is left: neither the scene nor an answer, a thread or an
array that was taken from it. So a scene that somebody holds is never overwritten.

The reference count of a token that all arrays of a scene hold decides this, not the cycle collector: the collector does
not look into NumPy's arrays, so it takes what they hold to be in use. If it did look into them, it would report a dead
cycle before `__del__` of an object in it could decide to revive it.
"""

from __future__ import annotations

import dataclasses
import math
import weakref
from collections import deque
from collections.abc import Mapping
from dataclasses import KW_ONLY, field
from itertools import count
from typing import Any

import numpy as np
import numpy.typing as npt

from ..._util.records import dataclass
from ...kernels.tables import (
    CELL_GROUPS,
    EXTENT,
    GROUP_BOUNDS,
    GROUP_PLANES,
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
    unpack_tables,
)
from ..error_limits import scene_size
from ..lowering import LoweredScene
from ..mmap_arrays import has_own_memory
from ..row_layout import BODIES, CORNERS, FRAMES, PLANES, QUADRICS, SPHERES, SURFACES, RowLayout
from ..surface_features import Remainders
from .neighbour_index import NeighbourFrame, NeighbourPlaces, surface_columns
from .scene_splice import SplicePieces, SpliceRuns

Array = npt.NDArray[Any]
_GROUPS = (CELL_GROUPS, GROUP_BOUNDS, GROUP_PLANES)
_TREES = (LEAF_ITEMS, NODE_BOXES, EXTENT, NODE_CHILDREN, TREE_ORDER, TREE_ROOT, ROOTS, TREE_DEPTH)
_LAST = (SURFACE_KIND, SURFACE_ROW, *_GROUPS, *_TREES)
_ORDER = (*(k for k in range(LENGTHS) if k not in _LAST), *_LAST)
"""What may grow comes last: the table of surfaces (when a class of surfaces splits) and trees (always rewritten).

The items of leaves come first among the trees, because most of them are never written.
"""
_NODE = 64
"""More than the numbers, of either type, of a node, or of one entry in a leaf."""
MOST = 1 << 30
"""Larger buffers, in bytes, are not kept for the next scene."""
_edits = count(1)


def next_edit_number() -> int:
    """Return a new number for an edit."""
    return next(_edits)


def stamp_entries(entries: int) -> Longs:
    """Return stamps of a scene whose rows equal those of no other."""
    return np.broadcast_to(np.int64(next(_edits)), entries)


def restamp_entries(stamps: Longs, fresh: list[int]) -> Longs:
    """Return stamps of a scene in which some entries are new, or have other numbers in their rows."""
    found = stamps.copy()
    found[fresh] = next(_edits)
    return found


class _LifetimeToken:
    """Lives as long as somebody reads one of the arrays that were handed out with it."""

    __slots__ = ("__weakref__",)


class _TokenArray:
    """An array interface that keeps the token of its buffer alive."""

    def __init__(self, array: Array, token: _LifetimeToken) -> None:
        self.__array_interface__ = array.__array_interface__
        self._array, self._token = array, token


class SceneBuffer:
    """The memory of one scene at a time: the arrays that kernels take, and further arrays by name."""

    def __init__(self, integers: Ints, floats: Floats) -> None:
        self.integers, self.floats = integers, floats
        self.extra_arrays: dict[str, Array] = {}
        self.frame: Any = None
        """The frame to which the places of surfaces among these are relative."""
        self.stamps: Longs = np.zeros(0, np.int64)
        self.numbers = 0

    @property
    def nbytes(self) -> int:
        """Bytes of all arrays."""
        return self.integers.nbytes + self.floats.nbytes + sum(array.nbytes for array in self.extra_arrays.values())


@dataclass(frozen=True)
class PoolMemory:
    """The pool that related scenes share, and the state of the buffer of one of them."""

    stores: BufferPool
    stamps: Longs  # by which edit the rows of each entry were written
    numbers: int  # by which edit surfaces got their numbers in the table
    store: SceneBuffer | None = None  # its buffer; None where that cannot be reused
    token: weakref.ref[_LifetimeToken] | None = None

    @classmethod
    def new(cls, entries: int) -> PoolMemory:
        """Describe a scene that shares nothing with others, in memory of its own."""
        return cls(BufferPool(), stamp_entries(entries), next_edit_number())

    def claim(self) -> BufferClaim | None:
        """Claim the buffer of a scene that the caller has released, or keep others from taking it; None: it is gone."""
        if self.store is None:
            return BufferClaim()
        held = self.token() if self.token is not None else None
        if held is not None:
            return BufferClaim(token=held)
        opened = self.stores.take(self.store)
        return None if opened is None else BufferClaim(opened)


@dataclass(frozen=True)
class BufferClaim:
    """A claim on the memory of the scene that an edit starts from: an open buffer, or the token of its holder."""

    buffer: OpenBuffer | None = None
    token: _LifetimeToken | None = None


class OpenBuffer:
    """A buffer for the next scene, exclusively; `close` marks the scene as finished."""

    def __init__(self, store: SceneBuffer) -> None:
        self._store, self._token = store, _LifetimeToken()
        self.stamps, self.numbers, self.frame = store.stamps, store.numbers, store.frame
        self.extra_arrays = {name: self._out(array) for name, array in store.extra_arrays.items()}

    @classmethod
    def new(cls, tables: Tables) -> OpenBuffer:
        """Allocate a buffer for tables of these shapes, with slack for trees that grow by the entries that move.

        The table of surfaces has slack, too, for the case that no surface coincides with another.
        """
        _, integers, floats = places_of(tables, _ORDER)
        # A quarter more nodes, the loose entries (at most the square root of all), and a few.
        more = len(tables.node_children) // 4 + 4 * math.isqrt(len(tables.entry_kind)) + 8
        rows = len(tables.planes) + len(tables.spheres) + len(tables.quadrics) - len(tables.surface_kind)
        room = line_array(floats + more * _NODE + SPARE)
        return cls(SceneBuffer(np.empty(integers + more * _NODE + 2 * max(rows, 0), np.int32), room))

    @property
    def arrays(self) -> tuple[Ints, Floats]:
        """The integers and floats of the buffer, in the form in which they may be handed out."""
        return self._out(self._store.integers), self._out(self._store.floats)

    def _out(self, array: Array) -> Array:
        return np.asarray(_TokenArray(array, self._token))

    def put(self, name: str, array: Array) -> Array:
        """Store an array that nobody else has; return it in the form in which it may be handed out."""
        self._store.extra_arrays[name] = array
        self.extra_arrays[name] = out = self._out(array)
        return out

    def geometry(self, tables: Tables) -> Geometry | None:
        """Lay out tables of these shapes; None where trees have outgrown the buffer."""
        places, integers, floats = places_of(tables, _ORDER)
        if integers > len(self._store.integers) or floats + SPARE > len(self._store.floats):
            return None
        out = self._out(self._store.integers), self._out(self._store.floats)
        out[1][places[EXTENT] + tables.extent.size : floats + SPARE] = 0.0  # gaps between tables, and the end, are 0
        return Geometry(places, out[0][:integers], out[1][: floats + SPARE])

    def raw(self, name: str) -> Array:
        """Return a named array without the token: it does not keep the scene's buffer from reuse."""
        return self._store.extra_arrays[name]

    def memory(self, stores: BufferPool, stamps: Longs, numbers: int) -> PoolMemory:
        """Describe this buffer for the scene; until `close` it belongs to that scene alone."""
        return PoolMemory(stores, stamps, numbers, self._store, weakref.ref(self._token))

    def close(self, memory: PoolMemory, frame: Any) -> None:
        """Finish the scene: when it is gone, the buffer returns to the pool."""
        self._store.stamps, self._store.numbers, self._store.frame = memory.stamps, memory.numbers, frame
        # A weak reference: a buffer must not keep its pool alive.
        weakref.finalize(self._token, _return_buffer, weakref.ref(memory.stores), self._store).atexit = False


class BufferPool:
    """The pool that scenes with rows in the same places share: at most one free buffer."""

    def __init__(self) -> None:
        self._free: deque[SceneBuffer] = deque(maxlen=1)

    def take(self, requested: SceneBuffer | None = None) -> OpenBuffer | None:
        """Take a free buffer with the rows of an earlier scene, or only `requested`; None if there is none."""
        try:
            found = self._free.pop()
        except IndexError:
            return None
        if requested is not None and found is not requested:
            self._free.append(found)
            return None
        return OpenBuffer(found)

    def give(self, store: SceneBuffer) -> None:
        """Return a buffer that nobody reads. This may happen at any time: nothing here waits for a lock."""
        if store.nbytes <= MOST:
            self._free.append(store)


def _return_buffer(stores: weakref.ref[BufferPool], store: SceneBuffer) -> None:
    known = stores()
    if known is not None:
        known.give(store)


# The state that the next edit of a scene needs, and whether entries can be exchanged in place.
#
# An edit in place exchanges entries so that all other rows stay where they are.


@dataclass(frozen=True)
class EditState:
    """Places by which near surfaces are found, the size that limits depend on, and the memory that may be reused.

    Stamps are unique in one process only, and the memory of a copy is its own: so pickles and copies drop the memory.
    Their edits start with new stamps, in new memory.
    """

    frame: NeighbourFrame | None = None
    places: NeighbourPlaces | None = None
    size: float | None = None
    memory: PoolMemory | None = None

    @property
    def has_gaps(self) -> bool:
        """Whether edits have left rows in the tables that nobody reads."""
        return False

    def __reduce__(self) -> tuple[Any, ...]:
        return EditState, (self.frame, self.places, self.size)


@dataclass(frozen=True)
class FullEditState(EditState):
    """An edit state in which everything is known."""

    frame: NeighbourFrame = field()  # no default: none of these may be left out
    places: NeighbourPlaces = field()
    size: float | None = field()
    _: KW_ONLY
    memory: PoolMemory

    __reduce__ = EditState.__reduce__


def keeps_rows(old: RowLayout, new: RowLayout, found: SpliceRuns, entries: int) -> bool:
    """Return whether each new entry has as many rows of every kind as the one that it replaces.

    Bulk balls exclude it.
    """
    if entries != len(old.first_body) - 1 or not new.which.all():
        return False
    fresh = np.array(found.fresh, np.int64)
    counts = np.diff(old.first_body)[fresh]
    if not np.array_equal(counts, np.diff(new.first_body)):
        return False
    if np.diff(old.first_frame)[fresh].any() or new.first_frame.any():
        return False
    firsts = np.repeat(old.first_body[fresh] - new.first_body[:-1], counts)
    which = old.which[firsts + np.arange(len(new.which))]
    rows = old.patterns.counts[which], new.patterns.counts[new.which]
    return bool(which.all() and np.array_equal(*rows))


def keeps_classes(old: RowLayout, new: RowLayout, pieces: SplicePieces) -> bool:
    """Return whether surfaces coincide with the same others as before, if new ones coincide with no others.

    That they coincide with no others is a separate question: see `surface_classes.neighbour_slots`. This function
    requires that

    - no surface of a removed entry coincided with one that stays;
    - no surface of a new entry coincides with one of another piece, before or behind it;
    - within each piece every new surface takes the record of the surface at the same place as that of the entry it
      replaces.

    Then `RowLayout.first` and `RowLayout.ids` stay unchanged. A class of equal surfaces is new, or stays, as a whole,
    and lies within one piece of the new entries: so the rows of its record shift as those of all its members. For the
    second condition nothing weaker suffices: a record of another piece has its number, and its row, shifted as that
    piece.
    """
    if old.first is None:  # every surface stood for itself
        return new.first is None
    fresh = np.zeros(len(old.first), bool)
    for source, rows, at, shift in pieces.moved(SURFACES, SURFACES):
        if source == 1:
            fresh[at] = True
            first = np.arange(rows.start, rows.stop) if new.first is None else new.first[rows]
            if (first < rows.start).any() or (first >= rows.stop).any():
                return False
            if not np.array_equal(old.first[at], first + shift):
                return False
    return bool((fresh[old.first] == fresh).all())


def complete_state(
    edit_state: EditState, old: LoweredScene, new: LoweredScene
) -> tuple[FullEditState, NeighbourPlaces]:
    """Complete the edit state of the old scene with all that an in-place edit needs.

    Return also the places of new surfaces.
    """
    frame, places, records = edit_state.frame, edit_state.places, surface_columns(new.tables)
    own = frame.places_within(*records) if frame is not None and places is not None else None
    if isinstance(edit_state, FullEditState) and own is not None:
        return edit_state, own
    assert old.layout is not None
    memory = edit_state.memory or PoolMemory.new(len(old.layout.first_body) - 1)
    if frame is None or places is None or own is None:
        frame, (places, own) = NeighbourFrame.of_scenes(surface_columns(old.tables), records)
    size = edit_state.size
    if size is None and not np.isfinite(old.boxes).all():
        size = scene_size(old.tables, old.boxes)
    return FullEditState(frame, places, size, memory=memory), own


# The arrays of a scene beside its tables

EXTRA_ARRAYS = {
    "boxes": BODIES, "frames": FRAMES, "planes": PLANES, "spheres": SPHERES, "quadrics": QUADRICS, "vertices": CORNERS,
    "place_of_planes": PLANES, "place_of_spheres": SPHERES, "place_of_quadrics": QUADRICS,
    "mark_of_planes": PLANES, "mark_of_spheres": SPHERES, "mark_of_quadrics": QUADRICS,
}  # fmt: skip
"""Arrays of a buffer beside the tables, and the kind of their rows."""
_PLACED = 1 << 18
"""Up to so many surfaces have places from the beginning: ten bytes each, and a hundredth of the time surfaces take."""
OF_FRAMES = "place", "mark"
"""Prefixes of the names of arrays that are relative to a frame (`neighbour_index.py`)."""


def extra_arrays(lowered: LoweredScene, places: NeighbourPlaces) -> dict[str, Any]:
    """Return the arrays of a scene beside the tables."""
    return dict(zip(EXTRA_ARRAYS, (*_first_arrays(lowered), *_place_arrays(places)), strict=True))


def _place_arrays(places: NeighbourPlaces) -> tuple[Any, ...]:
    """Return the arrays that are relative to a frame."""
    return places.planes, places.spheres, places.quadrics, *places.marks


def raw_places(opened: OpenBuffer) -> NeighbourPlaces:
    """Return the places in a buffer, in arrays that do not hold its scene."""
    return NeighbourPlaces.of_buckets(*(opened.raw(name) for name in EXTRA_ARRAYS if name.startswith(OF_FRAMES)))


def _first_arrays(lowered: LoweredScene) -> tuple[Any, ...]:
    """Return the arrays that exist even if nothing was edited."""
    rest = lowered.rest
    return lowered.boxes, lowered.frames, rest.planes, rest.spheres, rest.quadrics, rest.vertices


def _with_arrays(lowered: LoweredScene, tables: Tables, beside: Mapping[str, Any]) -> LoweredScene:
    rest = Remainders(beside["planes"], beside["spheres"], beside["quadrics"], beside["vertices"])
    return dataclasses.replace(lowered, tables=tables, bounds=beside["boxes"], frames=beside["frames"], rest=rest)


def adopt_buffer(lowered: LoweredScene, opened: OpenBuffer) -> tuple[LoweredScene, EditState]:
    """Move a freshly prepared scene, whose tables are in a buffer, there with all its arrays.

    Places of surfaces are computed, so that the first edit need not process all of them, unless there are so many that
    their memory matters more.
    """
    records, frame, places = surface_columns(lowered.tables), None, None
    beside: tuple[Any, ...] = _first_arrays(lowered)
    if sum(len(table) for table in records) <= _PLACED:
        frame, (found,) = NeighbourFrame.of_scenes(records)
        beside = *beside, *_place_arrays(found)
    # An array that is writable and no view of another belongs to this scene alone; others are copied
    for name, column in zip(EXTRA_ARRAYS, beside, strict=False):
        whole = not isinstance(column.base, np.ndarray) or has_own_memory(column)
        opened.put(name, column if column.flags.writeable and whole else column.copy())
    if frame is not None:
        places = raw_places(opened)
    assert lowered.layout is not None
    memory = PoolMemory.new(len(lowered.layout.first_body) - 1)
    memory = opened.memory(memory.stores, memory.stamps, memory.numbers)
    opened.close(memory, frame)
    return _with_arrays(lowered, lowered.tables, opened.extra_arrays), EditState(frame, places, memory=memory)


def release_memory(lowered: LoweredScene, geometry: Geometry, memory: PoolMemory) -> LoweredScene:
    """Return the scene in arrays that do not hold its buffer: who reads them claims it (`PoolMemory.claim`)."""
    store = memory.store
    if store is None:
        return lowered
    raw = unpack_tables(lowered.tables, geometry._replace(integers=store.integers, floats=store.floats))
    return _with_arrays(lowered, raw, store.extra_arrays)


# Tables of scenes with instances, which grow in their buffer


class UneditableError(Exception):
    """The edited scene must be prepared afresh."""


class TableRows:
    """Tables that grow: their rows by name, their room, and what rounding removed from their records."""

    def __init__(self, geometry: Geometry, tables: Tables, rest: Remainders) -> None:
        self.geometry, self.rest = geometry, rest
        self.shapes = {name: (k, *column.shape[1:]) for k, (name, column) in enumerate(tables._asdict().items())}
        self._real = [column.dtype == np.float64 for column in tables]
        ends = [
            np.append(np.sort(geometry.places[:LENGTHS][np.array(self._real) == real]), len(numbers))
            for real, numbers in ((False, geometry.integers), (True, geometry.floats))
        ]
        begins = geometry.places[:LENGTHS].tolist()
        self._room = [
            int(ends[r][np.searchsorted(ends[r], b, "right")]) - b for r, b in zip(self._real, begins, strict=True)
        ]

    def __getitem__(self, name: str) -> Any:
        return self.span(name, int(self.geometry.places[LENGTHS + self.shapes[name][0]]))

    def span(self, name: str, size: int) -> Any:
        """Return so many numbers of a table, in rows."""
        k, *row = self.shapes[name]
        if size > self._room[k]:
            raise UneditableError
        numbers: Any = self.geometry.floats if self._real[k] else self.geometry.integers
        begin = int(self.geometry.places[k])
        return numbers[begin : begin + size].reshape(-1, *row)

    def resize(self, name: str, rows: int) -> Any:
        """Set the number of rows of a table; return the table."""
        k, *row = self.shapes[name]
        found = self.span(name, rows * math.prod(row))
        self.geometry.places[LENGTHS + k] = found.size
        return found

    def append(self, name: str, rows: Any) -> int:
        """Append rows to a table; return the number of the first."""
        first = len(self[name])
        self.resize(name, first + len(rows))[first:] = rows
        return first

    def append_rest(self, name: str, rows: Floats) -> None:
        """Append what rounding removed from new records of a table."""
        joined = np.concatenate([getattr(self.rest, name), rows])
        self.rest = dataclasses.replace(self.rest, **{name: joined})

    def tables(self) -> Tables:
        """View all tables."""
        return Tables(**{name: self[name] for name in self.shapes})

    def kind_and_row(self, surface: int) -> tuple[int, int]:
        """Return the kind of a surface, and the row of its record."""
        return int(self["surface_kind"][surface]), int(self["surface_row"][surface])
