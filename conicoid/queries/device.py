"""Queries on a GPU: which device answers, its memory, and chunks of rays that are copied while others are traced.

The kernels are those of `conicoid.kernels.device` as PTX, from the package conicoid_cuda. All but the calls of NVIDIA's
driver (`NvidiaDriver`) runs in tests on a card that the CPU emulates (tests/emulation.py).

A query copies its rays by chunks into memory that the card reads by itself, on several streams: one chunk is on its way
there, one is traced, one on its way back. Python waits for a stream in short naps, so that Ctrl-C comes through.
"""

from __future__ import annotations

import contextlib
import os
import threading
import time
import weakref
from collections.abc import Sequence
from importlib.util import find_spec
from typing import TYPE_CHECKING, Any, NamedTuple, Protocol

import numpy as np

from .._util.environment import DEVICES, read_device
from .._util.process import fork_safe_lock
from .._util.validation import format_value

if TYPE_CHECKING:
    from pathlib import Path

    from ..prepare.prepared_scene import PreparedScene

BLOCK = 128
"""Threads of a block; numbers of threads are multiples of it."""
CHUNK = 1 << 19
"""Rays or points of a chunk: some 30 MB, a millisecond of a large card."""
LANES = 3
"""Chunks on their way."""
_LINE = 256  # bytes to which arrays in a card's memory are aligned
_SHARE = 2  # scratch memory that threads share takes up to one part in so many of a card's free memory
_NAP = 5e-5  # seconds between two looks at a stream

_default_device: list[str] = []


def set_device(device: str | None) -> None:
    """Answer `first_hit`, `occluded`, `contains` and `body_at` on a device from now on: "cpu" or "cuda".

    The answers are the same to the bit. One point, one ray and up to a thousand rays in a list stay on the CPU.
    Other queries stay there too, except for parts that call one of these four.

    Parameters
    ----------
    device : {"cpu", "cuda"} or None
        None returns to the default: CONICOID_DEVICE, or the CPU.

    Raises
    ------
    ValueError
        For another name.
    ImportError, RuntimeError
        If a package, NVIDIA's driver or a card is missing.
    """
    if device is not None:
        device_of("set_device", device)
    _default_device[:] = [] if device is None else [device]


def device_of(query: str, device: str | None, are_few: bool = False) -> Device | None:
    """Return the GPU that answers a query, None for the CPU; `device` is the argument of the query.

    The CPU answers for few rays or points sooner than they travel, so they go to a card only if the call names it.
    """
    if device is None and are_few:
        return None
    if device is None:
        device = _default_device[-1] if _default_device else read_device()
    elif not isinstance(device, str) or device not in DEVICES:
        names = " or ".join(map(repr, DEVICES))
        raise ValueError(f"{query}: device must be {names}, got {format_value(device)}")
    return None if device == "cpu" else _first_device()


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
        """Return a new stream: what is put into it runs in order."""

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


# The work of a query


class _Memory:
    """Memory of a card, which is given back with this object."""

    def __init__(self, driver: GpuDriver, size: int) -> None:
        self.size, self.address = size, driver.allocate(max(size, _LINE))
        weakref.finalize(self, driver.release, self.address).atexit = False


class _Chunk(NamedTuple):
    """Rays first..last of a query, on their way through a lane."""

    first: int
    last: int
    results: tuple[Any, ...]
    """Views of the lane's memory: the status, then the outputs."""


class _Room(NamedTuple):
    """Scratch memory of a kernel."""

    size: str
    numbers: tuple[int, ...] = ()  # for the kernel: address and length of each array that its threads share
    threads: int = 0  # for which there is memory; 0 for any number


class _Lane:
    """A stream with memory for one chunk, on the card and on the CPU."""

    def __init__(self, driver: GpuDriver) -> None:
        self.stream = driver.stream()
        self.memory: Any = None
        self.pinned: Any = None
        self.chunk: _Chunk | None = None


class Device:
    """A card with the memory of its queries: one query at a time."""

    def __init__(self, driver: GpuDriver) -> None:
        self.driver, self.lock = driver, threading.Lock()
        self.lanes = [_Lane(driver) for _ in range(LANES)]
        self._scratch: _Memory | None = None

    def wait(self, lane: _Lane) -> None:
        """Wait for what is in a lane."""
        while not self.driver.is_done(lane.stream):
            time.sleep(_NAP)

    def put(self, arrays: Sequence[Any]) -> tuple[_Memory, list[int]]:
        """Copy tables to the card; return their memory, and the address and length of each."""
        ends = np.cumsum([-(-array.nbytes // _LINE) * _LINE for array in arrays]).tolist()
        memory, numbers = _Memory(self.driver, ends[-1]), list[int]()
        for array, begin in zip(arrays, [0, *ends], strict=False):
            if array.size:
                self.driver.send(memory.address + begin, array, self.lanes[0].stream)
            numbers += [memory.address + begin, array.size]
        self.wait(self.lanes[0])
        return memory, numbers

    def run(self, scene: PreparedScene, function: str, inputs: Sequence[Any], outputs: Sequence[Any]) -> bool:
        """Run a function of `kernels.device` on all rays or points, into `outputs`.

        Inputs have a row for each ray or one for all. Returns False, and does nothing, if the scene needs more scratch
        memory than the card has.
        """
        count = len(outputs[0])
        with self.lock:
            for lane in self.lanes:  # a second Ctrl-C may have left work behind
                self.wait(lane)
            room = self._room(scene, function)
            if room is None:
                return False
            try:
                tables = _Tables.of(scene, self)
                # Kernels that share scratch memory follow each other
                lanes = self.lanes[:1] if room.threads else self.lanes
                for number, first in enumerate(range(0, count, CHUNK)):
                    lane = lanes[number % len(lanes)]
                    self._end(lane, outputs)
                    self._begin(lane, tables, room, function, inputs, outputs, first, min(count, first + CHUNK))
                for lane in self.lanes:
                    self._end(lane, outputs)
            finally:  # after Ctrl-C too: the memory is used again
                for lane in self.lanes:
                    lane.chunk = None
                    self.wait(lane)
        return True

    def _room(self, scene: PreparedScene, function: str) -> _Room | None:
        """Return scratch memory for a function; None if that of one block would not fit."""
        from ..kernels.device import SHARED, WIDTHS, ScratchSize, size_name

        needed, driver = ScratchSize.needed(scene.geometry), self.driver
        size = size_name(needed)
        if size != SHARED:
            return _Room(size)
        lengths, held = needed.lengths, self._scratch.size if self._scratch else 0
        each = sum(WIDTHS[name] * length for name, length in lengths.items())
        most = max(held, (driver.free_memory() + held) // _SHARE)
        threads = min(driver.resident(f"{function}_{size}"), most // each) // BLOCK * BLOCK
        if threads == 0:
            return None
        sizes = [-(-threads * WIDTHS[name] * length // _LINE) * _LINE for name, length in lengths.items()]
        if self._scratch is None or held < sum(sizes):
            self._scratch = None
            self._scratch = _Memory(driver, sum(sizes))
        begins = np.cumsum([self._scratch.address, *sizes]).tolist()
        numbers = (n for pair in zip(begins, lengths.values(), strict=False) for n in pair)
        return _Room(size, tuple(numbers), threads)

    def _begin(
        self, lane: _Lane, tables: _Tables, room: _Room, function: str, inputs: Sequence[Any], outputs: Sequence[Any],
        first: int, last: int,
    ) -> None:  # fmt: skip
        """Put a chunk into a lane."""
        parts = [array[first:last] if len(array) == len(outputs[0]) else array for array in inputs]
        results = [np.zeros(1, np.int64), *(array[first:last] for array in outputs)]
        ends = np.cumsum([0, *(-(-part.nbytes // _LINE) * _LINE for part in (*parts, *results))]).tolist()
        if lane.memory is None or lane.memory.size < ends[-1]:
            lane.memory = None  # before the new memory, which may not have room beside it
            lane.memory, lane.pinned = _Memory(self.driver, ends[-1]), self.driver.pinned(ends[-1])
        views = [
            lane.pinned[begin : begin + part.nbytes].view(part.dtype).reshape(part.shape)
            for part, begin in zip((*parts, *results), ends, strict=False)
        ]
        for view, part in zip(views, parts, strict=False):
            view[...] = part
        views[len(parts)][0] = 0
        middle, base = ends[len(parts)], lane.memory.address
        numbers = [n for view, begin in zip(views, ends, strict=False) for n in (base + begin, len(view))]
        status, rays, rest = numbers[2 * len(parts)], numbers[: 2 * len(parts)], numbers[2 * len(parts) + 2 :]
        driver = self.driver
        driver.send(base, lane.pinned[: middle + _LINE], lane.stream)
        threads = min(room.threads, last - first) if room.threads else last - first
        driver.launch(
            f"{function}_{room.size}",
            [status, *tables.numbers(function), *rays, *rest, *room.numbers],
            threads,
            lane.stream,
        )
        driver.fetch(lane.pinned[middle : ends[-1]], base + middle, lane.stream)
        lane.chunk = _Chunk(first, last, tuple(views[len(parts) :]))

    def _end(self, lane: _Lane, outputs: Sequence[Any]) -> None:
        """Take the answers of a lane's chunk."""
        if lane.chunk is None:
            return
        self.wait(lane)
        (first, last, (status, *results)), lane.chunk = lane.chunk, None
        if status[0]:
            raise RuntimeError(f"device='cuda': a kernel ended with status {status[0]}")
        for array, result in zip(outputs, results, strict=True):
            array[first:last] = result


class _Tables:
    """A scene's tables in a card's memory."""

    def __init__(self, scene: PreparedScene, device: Device) -> None:
        self._device, self._scene = device, weakref.ref(scene)
        places, integers, floats = scene.geometry
        self._memory, numbers = device.put([places, integers, floats])
        self._geometry = [numbers[0], *numbers[2:]]  # `places` has one length
        self._rest: Any = None

    @classmethod
    def of(cls, scene: PreparedScene, device: Device) -> _Tables:
        """Return the tables of a scene, which are sent once."""
        known = scene.tables_on_devices.get(id(device))
        if known is None:
            known = scene.tables_on_devices[id(device)] = cls(scene, device)
        tables: _Tables = known
        return tables

    def numbers(self, function: str) -> list[int]:
        """Return what the kernels of a function take first."""
        if function != "first_bodies":
            return self._geometry
        if self._rest is None:
            scene = self._scene()
            assert scene is not None
            self._rest = self._device.put(scene.rest)
        return [*self._geometry, *self._rest[1]]


# NVIDIA's cards

_devices: dict[int, Device] = {}
"""The device of a process, by its number: after a fork the child has none."""
_opening = fork_safe_lock()


def _first_device() -> Device:
    """Return the first card with its memory. Raise ImportError or RuntimeError where something is missing."""
    with _opening:
        if os.getpid() not in _devices:
            _devices[os.getpid()] = Device(NvidiaDriver())
        return _devices[os.getpid()]


def _kernels() -> Path:
    """Return the folder of the PTX of these sources. Raise ImportError if there is none."""
    from pathlib import Path

    from .._jit.sources import is_current

    spec = find_spec("conicoid_cuda")
    if spec is None or spec.origin is None:
        raise ImportError("device='cuda' needs the kernels in conicoid-cuda: pip install 'conicoid[cuda]'")
    folder = Path(spec.origin).parent
    if not is_current((folder / "sources.stamp").read_text(encoding="utf-8"), compilers=False):
        raise ImportError(
            "device='cuda': conicoid-cuda was made for another version of Conicoid: pip install -U 'conicoid[cuda]'"
        )
    return folder


class NvidiaDriver:
    """The first card that NVIDIA's driver shows (CUDA_VISIBLE_DEVICES chooses), in its primary context."""

    OLDEST = 7, 5

    def __init__(self) -> None:
        try:
            from cuda.bindings import driver
        except ImportError:
            raise ImportError("device='cuda' needs NVIDIA's cuda-bindings: pip install 'conicoid[cuda]'") from None
        self._folder, self._driver, self._process = _kernels(), driver, os.getpid()
        self._context: Any = None
        self._functions: dict[str, Any] = {}
        try:
            driver.cuInit(0)
        except Exception as error:  # the package has errors of its own for a library that it does not find
            raise RuntimeError("device='cuda' needs NVIDIA's driver, and none was found here") from error
        state, *count = driver.cuDeviceGetCount()
        if int(state) != 0 or count[0] == 0:
            raise RuntimeError(f"device='cuda' needs a card of NVIDIA's; the driver finds none ({self._text(state)})")
        device = self._call("cuDeviceGet", 0)
        kinds = driver.CUdevice_attribute
        major, minor, self._units = (
            self._call("cuDeviceGetAttribute", kind, device)
            for kind in (
                kinds.CU_DEVICE_ATTRIBUTE_COMPUTE_CAPABILITY_MAJOR,
                kinds.CU_DEVICE_ATTRIBUTE_COMPUTE_CAPABILITY_MINOR,
                kinds.CU_DEVICE_ATTRIBUTE_MULTIPROCESSOR_COUNT,
            )
        )
        self.name = self._call("cuDeviceGetName", 100, device).partition(b"\0")[0].decode()
        if (major, minor) < self.OLDEST:
            needed = ".".join(map(str, self.OLDEST))
            raise RuntimeError(f"device='cuda' needs compute capability {needed}; {self.name} has {major}.{minor}")
        self._context = self._call("cuDevicePrimaryCtxRetain", device)

    def _text(self, error: Any) -> str:
        found = self._driver.cuGetErrorString(error)[1]
        return found.decode() if found else str(error)

    def _call(self, name: str, *arguments: Any) -> Any:
        """Call the driver, in the card's context; return its result."""
        if self._context is not None:
            self._driver.cuCtxSetCurrent(self._context)
        error, *results = getattr(self._driver, name)(*arguments)
        if error == self._driver.CUresult.CUDA_ERROR_OUT_OF_MEMORY:
            raise MemoryError(f"device='cuda': {self.name} has too little memory")
        if int(error) != 0:
            raise RuntimeError(f"device='cuda': {name}: {self._text(error)}")
        return results[0] if results else None

    def free_memory(self) -> int:
        return int(self._call("cuMemGetInfo"))

    def allocate(self, size: int) -> int:
        try:
            return int(self._call("cuMemAlloc", size))
        except MemoryError:
            raise MemoryError(
                f"device='cuda': {size:,} bytes are needed, {self.free_memory():,} are free on {self.name}"
            ) from None

    def release(self, address: int) -> None:
        if os.getpid() == self._process:
            with contextlib.suppress(RuntimeError):
                self._call("cuMemFree", address)

    def pinned(self, size: int) -> Any:
        import ctypes

        address = self._call("cuMemHostAlloc", size, 0)
        room = (ctypes.c_uint8 * size).from_address(address)
        weakref.finalize(room, self._unpin, address).atexit = False  # the array below holds it
        return np.ctypeslib.as_array(room)

    def _unpin(self, address: int) -> None:
        """Give back what `pinned` took."""
        if os.getpid() == self._process:
            self._call("cuMemFreeHost", address)

    def stream(self) -> Any:
        return self._call("cuStreamCreate", self._driver.CUstream_flags.CU_STREAM_NON_BLOCKING)

    def send(self, address: int, array: Any, stream: Any) -> None:
        self._call("cuMemcpyHtoDAsync", address, array.ctypes.data, array.nbytes, stream)

    def fetch(self, array: Any, address: int, stream: Any) -> None:
        self._call("cuMemcpyDtoHAsync", array.ctypes.data, address, array.nbytes, stream)

    def _function(self, kernel: str) -> Any:
        """Return a kernel; the driver translates its PTX once, and keeps that on disk."""
        if kernel not in self._functions:
            import ctypes

            text = ctypes.create_string_buffer((self._folder / f"{kernel}.ptx").read_bytes())
            module = self._call("cuModuleLoadData", ctypes.addressof(text))
            self._functions[kernel] = self._call("cuModuleGetFunction", module, kernel.encode())
        return self._functions[kernel]

    def resident(self, kernel: str) -> int:
        blocks = self._call("cuOccupancyMaxActiveBlocksPerMultiprocessor", self._function(kernel), BLOCK, 0)
        return int(blocks * self._units * BLOCK)

    def launch(self, kernel: str, arguments: Sequence[int], threads: int, stream: Any) -> None:
        values = np.array(arguments, np.int64)
        places = np.uint64(values.ctypes.data) + np.arange(0, values.nbytes, 8, dtype=np.uint64)
        blocks = -(-threads // BLOCK)
        self._call(
            "cuLaunchKernel", self._function(kernel), blocks, 1, 1, BLOCK, 1, 1, 0, stream, places.ctypes.data, 0
        )

    def is_done(self, stream: Any) -> bool:
        self._driver.cuCtxSetCurrent(self._context)
        (error,) = self._driver.cuStreamQuery(stream)
        if error == self._driver.CUresult.CUDA_ERROR_NOT_READY:
            return False
        if int(error) != 0:
            raise RuntimeError(f"device='cuda': {self._text(error)}")
        return True
