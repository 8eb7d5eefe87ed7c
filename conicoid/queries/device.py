"""Queries on a GPU: its memory, and chunks of rays that are copied while others are traced.

The kernels are those of `conicoid.kernels.device` as PTX, from the package conicoid_cuda. All but the calls of NVIDIA's
driver (`nvidia_driver.py`) runs in tests on a card that the CPU emulates (tests/emulation.py).

A query copies its rays by chunks into memory that the card reads by itself, on several streams: one chunk is on its way
there, one is traced, one on its way back. Python waits for a stream in short naps, so that Ctrl-C comes through.
"""

from __future__ import annotations

import contextlib
import math
import threading
import time
import weakref
from collections import deque
from collections.abc import Callable, Iterator, Sequence
from typing import Any, NamedTuple, Protocol

import numpy as np

from ..kernels.body.crossing_rows import CROSSING_COLUMNS, SPAN_COLUMNS
from ..kernels.bvh.culling_constants import SHORT_NODE
from ..kernels.device import BY_KIND, EACH, ROW_COLUMNS, ROWS, SHARED, WIDTHS, ScratchSize, size_name
from ..kernels.device_walk import place_count
from ..kernels.tables import NODE_CHILDREN, Geometry, length
from ..prepare.prepared_scene import PreparedScene

BLOCK = 128
"""Threads of a block; numbers of threads are multiples of it."""
CHUNK = 1 << 19
"""Rays or points of a chunk: some 30 MB, a millisecond of a large card."""
LANES = 3
"""Chunks on their way."""
ALIGNMENT = 256
"""Bytes to which arrays in a card's memory are aligned."""
_ROWS = 1 << 21  # rows of spans or crossings that a lane has room for, 170 MB
_NUMBERS = 1 << 24  # sums that a lane has room for
_PIECE = 1 << 22  # rays or points that live on a card, between two looks for Ctrl-C; a multiple of SUMMED
_SHARE = 2  # scratch memory that threads share takes up to one part in so many of a card's free memory
_LOOKS, _NAP = 400, 5e-5  # looks at a stream without a nap, some hundred microseconds; then seconds between two


class GpuDriver(Protocol):
    """A GPU: memory by addresses, streams that work side by side, kernels by name."""

    def free_memory(self) -> int:
        """Return the number of free bytes."""

    def allocate(self, size: int) -> int:
        """Return the address of new memory. Raise MemoryError if too little is free."""

    def release(self, address: int) -> None:
        """Give memory back."""

    def pinned(self, size: int) -> Any:
        """Return an array of bytes of the CPU's memory from and to which the card copies by itself."""

    def stream(self) -> Any:
        """Return a new stream: its work runs in order."""

    def send(self, address: int, array: Any, stream: Any) -> None:
        """Copy an array to the card."""

    def fetch(self, array: Any, address: int, stream: Any) -> None:
        """Copy from the card into an array."""

    def resident(self, kernel: str) -> int:
        """Return the number of threads that run at a time, a multiple of BLOCK."""

    def launch(self, kernel: str, arguments: Sequence[int], threads: int, stream: Any) -> None:
        """Run a kernel, with `threads` rounded up to whole blocks."""

    def is_done(self, stream: Any) -> bool:
        """Return whether all that was put into a stream is done."""

    def number(self, stream: Any) -> int:
        """Return the number by which other libraries know a stream."""

    def follow(self, stream: Any, other: int) -> None:
        """Let later work of a stream wait for the work in another library's stream."""

    def card_of(self, address: int) -> int:
        """Return the number of the card in whose memory an address is. Raise RuntimeError if it is in none."""


# The work of a query


class CardMemory:
    """Memory of a card, which is given back with this object."""

    def __init__(self, driver: GpuDriver, size: int) -> None:
        self.size, self.address = size, driver.allocate(max(size, ALIGNMENT))
        weakref.finalize(self, driver.release, self.address).atexit = False


class _Room(NamedTuple):
    """Scratch memory of a kernel."""

    size: str
    numbers: tuple[int, ...] = ()  # for the kernel: address and length of each array that its threads share
    most: int = 0  # threads for which there is memory; 0 for any number

    def threads(self, count: int) -> int:
        """Return the number of threads for so many rays or points."""
        return min(self.most, count) if self.most else count


class _Twin(NamedTuple):
    """An array of the CPU's, and the address of its copy on the card."""

    array: Any
    address: int

    def part(self, first: int, last: int, more: int = 0) -> list[int]:
        """Return the arguments of a kernel for rows first..last: address and length. One row stands for all."""
        if len(self.array) == 1:
            return [self.address, 1]
        return [self.address + first * self.array.strides[0], last - first + more]


class _Lane:
    """A stream with memory for one chunk, on the card and on the CPU."""

    def __init__(self, driver: GpuDriver) -> None:
        self.driver, self.stream = driver, driver.stream()
        self._rooms: dict[str, tuple[CardMemory, Any]] = {}

    def twins(self, name: str, *kinds: tuple[tuple[int, ...], Any]) -> list[_Twin]:
        """Return arrays of these shapes and types, not initialised, in memory that belongs to a name."""
        sizes = [math.prod(shape) * np.dtype(kind).itemsize for shape, kind in kinds]
        ends = np.cumsum([0, *(-(-size // ALIGNMENT) * ALIGNMENT for size in sizes)]).tolist()
        if name not in self._rooms or self._rooms[name][0].size < ends[-1]:
            self._rooms.pop(name, None)  # before the new memory, which may not have room beside it
            self._rooms[name] = CardMemory(self.driver, ends[-1]), self.driver.pinned(max(ALIGNMENT, ends[-1]))
        memory, pinned = self._rooms[name]
        return [
            _Twin(pinned[begin : begin + size].view(kind).reshape(shape), memory.address + begin)
            for (shape, kind), size, begin in zip(kinds, sizes, ends, strict=False)
        ]

    def open(self, arrays: Sequence[Any], first: int, last: int, count: int, kinds: Sequence[Any]) -> list[_Twin]:
        """Send a status, and rows first..last of arrays of `count` rows or one; return them and arrays of `kinds`."""
        parts = [np.zeros(1, np.int64), *(array[first:last] if len(array) == count else array for array in arrays)]
        twins = self.twins("rays", *((part.shape, part.dtype) for part in parts), *kinds)
        for twin, part in zip(twins, parts, strict=False):
            twin.array[...] = part
        self.send(*twins[: len(parts)])
        return twins

    def send(self, *twins: _Twin) -> None:
        """Copy arrays to the card."""
        for array, address in twins:
            if array.size:
                self.driver.send(address, array, self.stream)

    def fetch(self, *twins: _Twin) -> None:
        """Copy arrays from the card."""
        for array, address in twins:
            if array.size:
                self.driver.fetch(array, address, self.stream)


class SpanSums(NamedTuple):
    """The weights of sums along rays on a card (`kernels.device.sum_spans`), and arrays for the answers."""

    places: Any
    weights: Any
    groups: bool
    total: Any  # (rays, width)
    crossed: Any


class _Pass(NamedTuple):
    """The data that the chunks of a query share."""

    function: str
    tables: list[int]
    room: _Room


class Device:
    """A card with the memory of its queries: one query at a time."""

    def __init__(self, driver: GpuDriver) -> None:
        self.driver, self.lock = driver, threading.Lock()
        self.lanes = [_Lane(driver) for _ in range(LANES)]
        self._scratch: CardMemory | None = None
        self._tables: dict[int, CardMemory] = {}
        self._short_nodes: dict[int, CardMemory] = {}
        self._sizes: dict[int, ScratchSize] = {}
        self._status = CardMemory(driver, ALIGNMENT)

    def wait(self, lane: _Lane) -> None:
        """Wait for the work in a lane."""
        looks = 0
        while not self.driver.is_done(lane.stream):
            looks += 1
            if looks > _LOOKS:  # a nap takes longer than most kernels
                time.sleep(_NAP)

    def tables(self, scene: PreparedScene | None, function: str) -> list[int]:
        """Return the first arguments of a function's kernels: addresses of a scene's tables, and lengths."""
        if scene is None:
            return []
        tables: list[Any]
        places, *tables = scene.geometry
        tables += scene.rest if function in ("first_bodies", "refine_points") else ()
        sent = [self._table_address(places), *(n for table in tables for n in (self._table_address(table), table.size))]
        return sent + self._nodes(scene.geometry, sent) if function in BY_KIND else sent

    def _nodes(self, geometry: Geometry, tables: list[int]) -> list[int]:
        """Return address and number of a scene's short nodes, which the card makes."""
        count, floats = int(length(geometry, NODE_CHILDREN)) // 8, geometry.floats
        if id(floats) not in self._short_nodes:
            memory, lane = CardMemory(self.driver, 8 * SHORT_NODE * count), self.lanes[0]
            numbers = [self._status.address, *tables, memory.address, count]
            if count:  # bodies without a box alone have no nodes, and a driver refuses a launch of no threads
                self.driver.launch(f"shorten_nodes_{EACH}", numbers, count, lane.stream)
                self.wait(lane)
            self._short_nodes[id(floats)] = memory
            weakref.finalize(floats, self._short_nodes.pop, id(floats)).atexit = False
        return [self._short_nodes[id(floats)].address, count]

    def size_needed(self, geometry: Geometry) -> ScratchSize:
        """Return the scratch memory that a scene needs."""
        places = geometry.places
        if id(places) not in self._sizes:
            self._sizes[id(places)] = ScratchSize.needed(geometry)
            weakref.finalize(places, self._sizes.pop, id(places)).atexit = False
        return self._sizes[id(places)]

    def _table_address(self, table: Any) -> int:
        """Return the address of a table, which is sent once: scenes that share it share that memory too.

        No table changes as long as it lives; an edited scene that takes over its memory has arrays of its own.
        """
        if id(table) not in self._tables:
            memory = CardMemory(self.driver, table.nbytes)
            if table.size:
                self.driver.send(memory.address, table, self.lanes[0].stream)
                self.wait(self.lanes[0])
            self._tables[id(table)] = memory  # now that it is there
            weakref.finalize(table, self._tables.pop, id(table)).atexit = False
        return self._tables[id(table)].address

    def run(
        self, scene: PreparedScene, function: str, inputs: Sequence[Any], outputs: Sequence[Any],
        constants: Sequence[Any] = (), size: int = CHUNK, width: int = 0,
    ) -> bool:  # fmt: skip
        """Run a function of `kernels.device` on all rays or points, into `outputs`, by chunks of `size` at most.

        Inputs have a row for each ray or one for all. Constants are numbers, and tables with the lengths that the
        function takes, as tuples. `width` is that of the picture that rays make, or 0. Returns False, and does nothing,
        if the scene needs more scratch memory than the card has.
        """
        count, width = len(outputs[0]), width if 64 * width <= CHUNK else 0

        def work(lane: _Lane, shared: _Pass, first: int, last: int) -> Iterator[None]:
            results = [array[first:last] for array in outputs]
            kinds = [(part.shape, part.dtype) for part in results]
            status, *rest = lane.open(inputs, first, last, count, kinds)
            numbers = [n for twin in rest for n in twin.part(0, len(twin.array))]
            own = [width] if function in BY_KIND else []
            numbers = [*self._constants(constants), *own, *numbers]
            self._launch(lane, shared, status, numbers, place_count(width, last - first))
            found = rest[len(inputs) :]
            lane.fetch(status, *found)
            yield
            _check_status(status.array)
            for result, twin in zip(results, found, strict=True):
                result[...] = twin.array

        return self._run_chunks(scene, function, count, picture_rows(width, min(CHUNK, size)), work)

    def _constants(self, constants: Sequence[Any]) -> Iterator[int]:
        """Yield constants as kernels take them."""
        for each in constants:
            yield from (self._table_address(each[0]), *each[1:]) if isinstance(each, tuple) else (each,)

    def list_rows(
        self, scene: PreparedScene, rays: Any, spans: bool, counts: Any, doubts: Any, sums: SpanSums | None = None
    ) -> list[tuple[int, int, Any]] | None:
        """Return the rows of spans or crossings, or sum spans up; None as `run` returns False.

        They are in pieces, in no order: first ray, last ray, rows. `counts` and `doubts` are those of `trace_rows`.
        """
        count, width = len(counts), sums.total.shape[1] if sums else 0
        columns = SPAN_COLUMNS if spans else CROSSING_COLUMNS
        pieces: list[tuple[int, int, Any]] = []

        def work(lane: _Lane, shared: _Pass, first: int, last: int) -> Iterator[None]:
            n = last - first
            kinds = ((n + 1,), np.int64), ((n,), np.int32), ((n,), np.int8), ((n * width,), np.float64), ((n,), np.int8)
            status, *lines, offsets, many, doubtful, total, crossed = lane.open(rays, first, last, count, kinds)

            def launch(begin: int, end: int, table: list[int]) -> None:
                """Count the rows of some rays, or write them into a table."""
                given = [0, *(number for line in lines for number in line.part(begin, end))]
                own = [*offsets.part(begin, end, 1), *table, *many.part(begin, end), *doubtful.part(begin, end)]
                self._launch(lane, shared, status, [*given, int(spans), *own], end - begin)

            launch(0, n, [offsets.address, 0])
            lane.fetch(status, many)
            yield
            _check_status(status.array)
            offsets.array[0] = 0
            np.cumsum(many.array, out=offsets.array[1:])
            lane.send(offsets)
            begin = 0
            while begin < n:
                # At least one ray, however many rows it has
                end = int(np.searchsorted(offsets.array, offsets.array[begin] + _ROWS, side="right")) - 1
                end = max(begin + 1, end)
                used = int(offsets.array[end] - offsets.array[begin])
                (table,) = lane.twins("rows", ((used, ROW_COLUMNS), np.float64))
                if used:
                    launch(begin, end, [table.address, used])
                if sums:
                    given = [lines[1].part(begin, end), offsets.part(begin, end, 1), [table.address, used]]
                    made = total.part(begin * width, end * width), crossed.part(begin, end)
                    self._sum(lane, status, sums, given, made, end - begin)
                else:
                    lane.fetch(status, table, doubtful)
                yield  # after sums too: the next piece may need a larger table
                if not sums:
                    sure, its = doubtful.array[begin:end] == 0, many.array[begin:end]
                    rows = table.array[:, :columns]
                    if its[~sure].any():  # in doubt since they were sorted: they give their rows up
                        rows, its[~sure] = rows[np.repeat(sure, its)], 0
                    pieces.append((first + begin, first + end, np.array(rows)))
                begin = end
            if sums:
                lane.fetch(status, doubtful, total, crossed)
                yield
                sums.total[first:last], sums.crossed[first:last] = total.array.reshape(n, width), crossed.array
            _check_status(status.array)
            counts[first:last], doubts[first:last] = many.array, doubtful.array

        size = min(CHUNK, _NUMBERS // max(1, width))
        return pieces if self._run_chunks(scene, "list_rows", count, size, work) else None

    def _sum(
        self, lane: _Lane, status: _Twin, sums: SpanSums, given: Sequence[list[int]], made: Sequence[list[int]],
        count: int,
    ) -> None:  # fmt: skip
        """Run `sum_spans` on so many rays, in a lane."""
        tables = [[self._table_address(each), each.size] for each in (sums.places, sums.weights)]
        parts = *given, *tables, [sums.total.shape[1], int(sums.groups)], *made
        shared = _Pass("sum_spans", [], _Room(EACH))
        self._launch(lane, shared, status, [number for part in parts for number in part], count)

    def _run_chunks(
        self, scene: PreparedScene, function: str, count: int, size: int,
        work: Callable[[_Lane, _Pass, int, int], Iterator[None]],
    ) -> bool:  # fmt: skip
        """Run the work of chunks of `size` rays, each in a lane; it yields where it waits for its work there.

        Returns False, and does nothing, if there is not enough scratch memory.
        """
        with self.lock:
            for lane in self.lanes:  # a second Ctrl-C may have left work behind
                self.wait(lane)
            room = self._room(scene, function)
            if room is None:
                return False
            shared, starts = _Pass(function, self.tables(scene, function), room), iter(range(0, count, max(1, size)))
            # Kernels that share scratch memory follow each other
            waiting = deque[tuple[_Lane, Iterator[None]]]()
            waiting.extend((lane, iter(())) for lane in (self.lanes[:1] if room.most else self.lanes))
            try:
                while waiting:
                    lane, steps = waiting.popleft()
                    self.wait(lane)
                    if next(steps, self) is None:
                        waiting.append((lane, steps))
                    elif (first := next(starts, None)) is not None:
                        waiting.appendleft((lane, work(lane, shared, first, min(count, first + max(1, size)))))
            finally:  # after Ctrl-C too: the memory is used again
                for lane in self.lanes:
                    self.wait(lane)
        return True

    def _launch(self, lane: _Lane, shared: _Pass, status: _Twin, numbers: Sequence[int], count: int) -> None:
        """Run a kernel on so many rays or points, in a lane."""
        function, tables, room = shared
        arguments = [status.address, *tables, *numbers, *room.numbers]
        self.driver.launch(f"{function}_{room.size}", arguments, room.threads(count), lane.stream)

    def send(self, address: int, array: Any) -> None:
        """Copy an array to the card, and wait for it."""
        with self._idle_lane() as lane:
            self.driver.send(address, array, lane.stream)

    def fetch(self, array: Any, address: int) -> None:
        """Copy from the card into an array, and wait for it."""
        with self._idle_lane() as lane:
            self.driver.fetch(array, address, lane.stream)

    @contextlib.contextmanager
    def _idle_lane(self) -> Iterator[_Lane]:
        """Yield a lane while no other query runs, and wait for the work that it got."""
        with self.lock:
            for each in self.lanes:
                self.wait(each)
            try:
                yield self.lanes[0]
            finally:
                self.wait(self.lanes[0])

    def run_on_card(
        self, function: str, numbers: Callable[[int, int], list[int]], count: int, scene: PreparedScene | None = None,
        width: int = 0,
    ) -> bool:  # fmt: skip
        """Run a function of `kernels.device`, or a kernel of `ROWS`, on arrays that live on the card.

        numbers: the arguments for rows first..last. Returns False, and does nothing, if the scene needs more scratch
        memory than the card has.
        """
        status, width = np.zeros(1, np.int64), width if 64 * width <= _PIECE else 0
        with self._idle_lane() as lane:
            room = _Room(EACH) if scene is None or function in ROWS else self._room(scene, function)
            tables = self.tables(scene, function)
            if room is None:
                return False
            self.driver.send(self._status.address, status, lane.stream)
            piece = max(1, count) if room.size == EACH else picture_rows(width, _PIECE)
            for first in range(0, count, piece):
                last = min(count, first + piece)
                own = [width] if function in BY_KIND else []
                arguments = [self._status.address, *tables, *own, *numbers(first, last), *room.numbers]
                threads = room.threads(place_count(width, last - first))
                self.driver.launch(f"{function}_{room.size}", arguments, threads, lane.stream)
                self.wait(lane)
            self.driver.fetch(status, self._status.address, lane.stream)
        _check_status(status)
        return True

    def _room(self, scene: PreparedScene, function: str) -> _Room | None:
        """Return scratch memory for a function; None if that of one block would not fit."""
        needed, driver = self.size_needed(scene.geometry), self.driver
        size = size_name(function, needed)
        if size != SHARED:
            return _Room(size)
        lengths, held = needed.lengths, self._scratch.size if self._scratch else 0
        each = sum(WIDTHS[name] * length for name, length in lengths.items())
        most = max(held, (driver.free_memory() + held) // _SHARE)
        threads = min(driver.resident(f"{function}_{size}"), most // each) // BLOCK * BLOCK
        if threads == 0:
            return None
        sizes = [-(-threads * WIDTHS[name] * length // ALIGNMENT) * ALIGNMENT for name, length in lengths.items()]
        if self._scratch is None or held < sum(sizes):
            self._scratch = None
            self._scratch = CardMemory(driver, sum(sizes))
        begins = np.cumsum([self._scratch.address, *sizes]).tolist()
        numbers = (n for pair in zip(begins, lengths.values(), strict=False) for n in pair)
        return _Room(size, tuple(numbers), threads)


def picture_rows(width: int, most: int) -> int:
    """Return a number of rays up to `most` that is some rows of squares (`ray_of_place`); `most` without a picture.

    It is a multiple of `SUMMED`, as `most` is.
    """
    return most // (64 * width) * 64 * width if width else most


def _check_status(status: Any) -> None:
    """Raise RuntimeError if a kernel has failed."""
    if status[0]:
        raise RuntimeError(f"device='cuda': a kernel ended with status {status[0]}")
