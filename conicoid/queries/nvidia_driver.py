"""The first card that NVIDIA's driver shows, by cuda-bindings: memory, streams, and the kernels of `conicoid_cuda`."""

from __future__ import annotations

import contextlib
import os
import threading
import weakref
from collections.abc import Sequence
from importlib.util import find_spec
from typing import TYPE_CHECKING, Any

import numpy as np

from .device import ALIGNMENT, BLOCK

if TYPE_CHECKING:
    from pathlib import Path


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


_LOST = frozenset((214, 220, 700, 702, 709, 710, *range(714, 720)))
"""Errors after which the driver answers each call of the process with an error: NVIDIA's list of `CUresult`."""


_MOST_SPARE = 1 << 30  # bytes that are kept for the next arrays


def _size_class(size: int) -> int:
    """Return a size that is up to an eighth larger, so that arrays of nearly the same size share memory."""
    step = max(ALIGNMENT, 1 << max(0, size.bit_length() - 4))
    return -(-size // step) * step


class NvidiaDriver:
    """The first card that NVIDIA's driver shows (CUDA_VISIBLE_DEVICES chooses), in its primary context.

    The context is current during a call alone, so that CuPy or PyTorch in the same thread keep the card that is theirs.
    """

    OLDEST = 7, 5

    def __init__(self) -> None:
        try:
            from cuda.bindings import driver
        except ImportError:
            raise ImportError("device='cuda' needs NVIDIA's cuda-bindings: pip install 'conicoid[cuda]'") from None
        self._folder, self._driver, self._process = _kernels(), driver, os.getpid()
        self._functions: dict[str, Any] = {}
        self._taken: dict[int, int] = {}  # sizes of memory, by address
        self._spare: dict[int, list[int]] = {}  # addresses of memory that waits for the next array of its size
        self._spare_bytes, self._is_quiet = 0, True
        self._lock = threading.RLock()  # arrays that end while it is held give their memory back
        try:
            (state,) = driver.cuInit(0)
        except Exception as error:  # the package has errors of its own for a library that it does not find
            raise RuntimeError("device='cuda' needs NVIDIA's driver, and none was found here") from error
        if state == driver.CUresult.CUDA_ERROR_NOT_INITIALIZED:
            raise RuntimeError("device='cuda': a process that was forked from one that uses a card cannot use it")
        count = self._result("cuDeviceGetCount") if int(state) == 0 else 0
        if count == 0:
            raise RuntimeError(f"device='cuda' needs a card of NVIDIA's; the driver finds none ({self._text(state)})")
        device = self._result("cuDeviceGet", 0)
        kinds = driver.CUdevice_attribute
        major, minor, self._units, self._threads = (
            self._result("cuDeviceGetAttribute", getattr(kinds, f"CU_DEVICE_ATTRIBUTE_{kind}"), device)
            for kind in (
                "COMPUTE_CAPABILITY_MAJOR",
                "COMPUTE_CAPABILITY_MINOR",
                "MULTIPROCESSOR_COUNT",
                "MAX_THREADS_PER_MULTIPROCESSOR",
            )
        )
        self.name = self._result("cuDeviceGetName", 100, device).partition(b"\0")[0].decode()
        if (major, minor) < self.OLDEST:
            needed = ".".join(map(str, self.OLDEST))
            raise RuntimeError(f"device='cuda' needs compute capability {needed}; {self.name} has {major}.{minor}")
        self._family = f"sm_{major}0"
        self._context = self._result("cuDevicePrimaryCtxRetain", device)

    def _text(self, error: Any) -> str:
        found = self._driver.cuGetErrorString(error)[1]
        return found.decode() if found else str(error)

    def _check(self, name: str, error: Any) -> None:
        """Raise MemoryError or RuntimeError for the status that the driver returned, unless it is success."""
        if error == self._driver.CUresult.CUDA_ERROR_OUT_OF_MEMORY:
            raise MemoryError(f"device='cuda': {name}: {self.name} has too little memory")
        if int(error) != 0:
            lost = "; this process cannot use the card any more" if int(error) in _LOST else ""
            raise RuntimeError(f"device='cuda': {name}: {self._text(error)}{lost}")

    def _result(self, name: str, *arguments: Any) -> Any:
        """Call the driver; return its result."""
        error, *results = getattr(self._driver, name)(*arguments)
        self._check(name, error)
        return results[0] if results else None

    def _call(self, name: str, *arguments: Any) -> Any:
        """Call the driver, in the card's context; return its result."""
        self._result("cuCtxPushCurrent", self._context)
        try:
            return self._result(name, *arguments)
        finally:
            self._driver.cuCtxPopCurrent()

    def free_memory(self) -> int:
        return int(self._call("cuMemGetInfo")) + self._spare_bytes

    def _with_room(self, size: int, name: str, *arguments: Any) -> Any:
        """Call a function of the driver that takes so many bytes of the card. Raise MemoryError with their number."""
        try:
            return self._call(name, *arguments)
        except MemoryError:
            self._empty()
        try:
            return self._call(name, *arguments)
        except MemoryError:
            raise MemoryError(
                f"device='cuda': {size:,} bytes are needed, {self.free_memory():,} are free on {self.name}"
            ) from None

    def allocate(self, size: int) -> int:
        needed, size = size, _size_class(size)
        with self._lock:
            address = self._spare_of(size)
            if address is None:
                address = int(self._with_room(needed, "cuMemAlloc", size))
            self._taken[address] = size
        return address

    def _spare_of(self, size: int) -> int | None:
        """Return memory that is kept, if there is some of this size."""
        if not self._spare.get(size):
            return None
        if not self._is_quiet:  # another library may still read memory that it gave back
            self._is_quiet = True  # first: arrays that end meanwhile set it back
            self._call("cuCtxSynchronize")
        self._spare_bytes -= size
        return self._spare[size].pop()

    def release(self, address: int) -> None:
        """Keep memory for the next array of its size: to get some from the driver takes longer than to trace."""
        if os.getpid() != self._process:
            return
        with self._lock:
            size = self._taken.pop(address)
            if self._spare_bytes + size > _MOST_SPARE:
                self._give_back("cuMemFree", address)
                return
            self._spare.setdefault(size, []).append(address)
            self._spare_bytes += size
            self._is_quiet = False

    def _empty(self) -> None:
        """Give the memory that is kept back to the driver."""
        with self._lock:
            spare, self._spare, self._spare_bytes = self._spare, {}, 0  # arrays may end meanwhile
        for address in (each for addresses in spare.values() for each in addresses):
            self._give_back("cuMemFree", address)

    def _give_back(self, name: str, address: int) -> None:
        """Free memory, if it is of this process, and its card is not lost."""
        if os.getpid() == self._process:
            with contextlib.suppress(RuntimeError):
                self._call(name, address)

    def pinned(self, size: int) -> Any:
        import ctypes

        try:
            address = self._call("cuMemHostAlloc", size, 0)
        except MemoryError:
            raise MemoryError(f"device='cuda': {size:,} bytes of the CPU's memory cannot be pinned") from None
        room = (ctypes.c_uint8 * size).from_address(address)
        weakref.finalize(room, self._give_back, "cuMemFreeHost", address).atexit = False  # the array below holds it
        return np.ctypeslib.as_array(room)

    def stream(self) -> Any:
        return self._call("cuStreamCreate", self._driver.CUstream_flags.CU_STREAM_NON_BLOCKING)

    def send(self, address: int, array: Any, stream: Any) -> None:
        self._call("cuMemcpyHtoDAsync", address, array.ctypes.data, array.nbytes, stream)

    def fetch(self, array: Any, address: int, stream: Any) -> None:
        self._call("cuMemcpyDtoHAsync", array.ctypes.data, address, array.nbytes, stream)

    def _function(self, kernel: str) -> Any:
        """Return a kernel: machine code for cards of this family, or PTX, which the driver translates and keeps."""
        if kernel not in self._functions:
            import ctypes

            files = (self._folder / f"{kernel}.{kind}" for kind in (f"{self._family}.cubin", "ptx"))
            code = ctypes.create_string_buffer(next(file for file in files if file.exists()).read_bytes())
            try:
                module = self._call("cuModuleLoadData", ctypes.addressof(code))
            except RuntimeError as error:
                version = self._result("cuDriverGetVersion")
                raise RuntimeError(
                    f"{error}; the driver for CUDA {version // 1000}.{version % 1000 // 10} cannot load {kernel}"
                ) from None
            self._functions[kernel] = self._call("cuModuleGetFunction", module, kernel.encode())
        return self._functions[kernel]

    def resident(self, kernel: str) -> int:
        blocks = self._call("cuOccupancyMaxActiveBlocksPerMultiprocessor", self._function(kernel), BLOCK, 0)
        return int(blocks * self._units * BLOCK)

    def launch(self, kernel: str, arguments: Sequence[int], threads: int, stream: Any) -> None:
        function, values = self._function(kernel), np.array(arguments, np.int64)
        places = np.uint64(values.ctypes.data) + np.arange(0, values.nbytes, 8, dtype=np.uint64)
        blocks, kind = -(-threads // BLOCK), self._driver.CUfunction_attribute.CU_FUNC_ATTRIBUTE_LOCAL_SIZE_BYTES
        # A card reserves local memory for all threads that its multiprocessors can hold, at the first launch
        local = self._call("cuFuncGetAttribute", kind, function) * self._threads * self._units
        sizes = blocks, 1, 1, BLOCK, 1, 1, 0
        self._with_room(local, "cuLaunchKernel", function, *sizes, stream, places.ctypes.data, 0)

    def number(self, stream: Any) -> int:
        return int(stream)

    def follow(self, stream: Any, other: int) -> None:
        event = self._call("cuEventCreate", self._driver.CUevent_flags.CU_EVENT_DISABLE_TIMING)
        self._call("cuEventRecord", event, self._driver.CUstream(other))
        self._call("cuStreamWaitEvent", stream, event, 0)
        self._call("cuEventDestroy", event)

    def card_of(self, address: int) -> int:
        kind = self._driver.CUpointer_attribute.CU_POINTER_ATTRIBUTE_DEVICE_ORDINAL
        return int(self._call("cuPointerGetAttribute", kind, address))

    def is_done(self, stream: Any) -> bool:
        self._result("cuCtxPushCurrent", self._context)
        try:
            (error,) = self._driver.cuStreamQuery(stream)
        finally:
            self._driver.cuCtxPopCurrent()
        if error == self._driver.CUresult.CUDA_ERROR_NOT_READY:
            return False
        self._check("cuStreamQuery", error)
        return True
