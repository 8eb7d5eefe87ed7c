"""A GPU emulated on this processor, which runs the LLVM code of PTX one thread after the other.

The compiler takes half a minute for the code. So one of the processes of tests makes the code of sources, the objects
and the PTX, and `out/emulation` keeps them for the others and for later runs. An object is made again where a source
that the compiler read, or a function, has changed; all other files where their code or their maker has changed.
"""

from __future__ import annotations

import ctypes
import functools
import os
import shutil
from collections import deque
from collections.abc import Callable, Sequence
from hashlib import sha256
from pathlib import Path
from typing import Any

import llvmlite.binding as llvm
import numpy as np

from conicoid.queries.device import BLOCK
from native import ptx
from native.build import EDITED, alone, device_code

from .children import ROOT

STORE = ROOT / "out" / "emulation"
LOWERED = ROOT / "out" / "device_code"


def from_store(key: str, make: Callable[[], bytes]) -> bytes:
    """Return the result of `make`, from a file if any process has made it; `key` names its sources."""
    file = STORE / sha256(key.encode()).hexdigest()
    if not file.exists():
        with alone():
            if not file.exists():
                STORE.mkdir(parents=True, exist_ok=True)
                part = file.with_suffix(f".{os.getpid()}")
                part.write_bytes(make())
                part.replace(file)
                for old in sorted(STORE.iterdir(), key=lambda each: each.stat().st_mtime)[:-24]:
                    old.unlink()
    return file.read_bytes()


def sources_of(code: bytes) -> str:
    """Return a digest of some code and of its compilers: `native`, and LLVM for this processor."""
    digest = sha256(code)
    for path in sorted((ROOT / "native").glob("*.py")):
        digest.update(path.read_bytes())
    digest.update(f"{llvm.get_host_cpu_name()} {llvm.llvm_version_info}".encode())
    return digest.hexdigest()


def _lowered(part: str) -> Path:
    """Return the code of a part. Functions that another part or an incremental build has lowered come from there."""
    memory = LOWERED / f"{part}.functions"
    LOWERED.mkdir(parents=True, exist_ok=True)
    others = [*LOWERED.glob("*.functions"), EDITED / "functions.pickle"]
    if not memory.exists() and (known := [each for each in others if each.exists()]):
        shutil.copyfile(known[-1], memory)
    return device_code(LOWERED, part, memory)


@functools.cache
def device_module(part: str = "queries") -> bytes:
    """Return the code that becomes PTX; `part` is one of `native.signature.on_device`."""
    with alone():
        code = _lowered(part)
    return from_store(f"{part} {sources_of(code.read_bytes())}", lambda: ptx.base(code))


@functools.cache
def ptx_of(name: str, part: str = "queries") -> str:
    """Return the PTX of a kernel. `ptx.ptx` refuses wrong code; the CUDA wheel has all kernels."""
    module = device_module(part)
    return from_store(f"{name} {sources_of(module)}", lambda: ptx.ptx(module, name).encode()).decode()


@functools.cache
def device_kernels(part: str = "queries") -> Kernels:
    """Return the same kernels, as functions that run."""
    return Kernels(device_module(part))


class Kernels:
    """The entries of `native.ptx.base`, as functions of this machine."""

    def __init__(self, module: bytes) -> None:
        llvm.initialize_native_target()
        llvm.initialize_native_asmprinter()
        target, features = llvm.Target.from_default_triple(), llvm.get_host_cpu_features().flatten()
        machine = target.create_target_machine(cpu=llvm.get_host_cpu_name(), features=features, opt=2, jit=True)
        whole = llvm.parse_bitcode(module)
        whole.triple, whole.data_layout = target.triple, str(machine.target_data)

        def compile_object() -> bytes:
            builder = llvm.create_pass_builder(machine, llvm.create_pipeline_tuning_options(speed_level=1))
            builder.getModulePassManager().run(whole, builder)
            return bytes(machine.emit_object(whole))

        found = from_store(f"{features} {sources_of(module)}", compile_object)
        self._engine = llvm.create_mcjit_compiler(llvm.parse_assembly(""), machine)
        self._engine.add_object_file(llvm.ObjectFileRef.from_data(found))
        self._engine.finalize_object()
        self._functions: dict[str, Any] = {}

    def run(self, name: str, arguments: list[int], threads: int) -> None:
        """Run all threads of a kernel, in order."""
        if name not in self._functions:
            address = self._engine.get_function_address(ptx.PREFIX + name)
            kinds = [ctypes.c_int64] * (2 + len(arguments))
            self._functions[name] = ctypes.CFUNCTYPE(ctypes.c_int32, *kinds)(address)
        for thread in range(threads):
            assert self._functions[name](thread, threads, *arguments) == 0


class Card:
    """`conicoid.queries.nvidia_driver.NvidiaDriver`, emulated on this processor.

    Streams work only while somebody waits for them, one piece at a time, so that an early read gives garbage. `check`,
    and the release of an allocation, find a byte that was written beside it.
    """

    EDGE, GARBAGE = 256, 0xA7

    def __init__(self, kernels: Kernels, size: int = 1 << 30, threads: int = 256) -> None:
        self.name, self.launches, self.sent = "emulation", list[tuple[str, int]](), 0
        self.followed = list[int]()
        self._kernels, self._size, self._threads = kernels, size, threads
        self._rooms: dict[int, np.ndarray] = {}

    def free_memory(self) -> int:
        return self._size - sum(len(room) for room in self._rooms.values())

    def allocate(self, size: int) -> int:
        if size > self.free_memory():
            raise MemoryError(
                f"device='cuda': {size:,} bytes are needed, {self.free_memory():,} are free on {self.name}"
            )
        room = np.full(size + 3 * self.EDGE, self.GARBAGE, np.uint8)
        address = (room.ctypes.data + 2 * self.EDGE - 1) // self.EDGE * self.EDGE
        self._rooms[address] = room
        return address

    def release(self, address: int) -> None:
        self.check(address)
        del self._rooms[address]

    def check(self, *addresses: int) -> None:
        """Assert that no kernel wrote beside some allocations, or beside any."""
        for address in addresses or [*self._rooms]:
            room = self._rooms[address]
            begin = address - room.ctypes.data
            end = begin + len(room) - 3 * self.EDGE
            assert (room[:begin] == self.GARBAGE).all()
            assert (room[end:] == self.GARBAGE).all()

    def pinned(self, size: int) -> np.ndarray:
        return np.full(size, self.GARBAGE, np.uint8)

    def stream(self) -> deque[Callable[[], None]]:
        return deque()

    def _within(self, address: int, size: int) -> None:
        assert any(
            begin <= address and address + size <= begin + len(room) - 3 * self.EDGE
            for begin, room in self._rooms.items()
        )

    def send(self, address: int, array: np.ndarray, stream: deque[Callable[[], None]]) -> None:
        assert array.flags.c_contiguous
        self._within(address, array.nbytes)
        self.sent += array.nbytes
        stream.append(lambda: ctypes.memmove(address, array.ctypes.data, array.nbytes))

    def fetch(self, array: np.ndarray, address: int, stream: deque[Callable[[], None]]) -> None:
        assert array.flags.c_contiguous
        self._within(address, array.nbytes)
        stream.append(lambda: ctypes.memmove(array.ctypes.data, address, array.nbytes))

    def resident(self, kernel: str) -> int:
        assert kernel in ptx.NAMES
        return self._threads

    def launch(self, kernel: str, arguments: Sequence[int], threads: int, stream: deque[Callable[[], None]]) -> None:
        assert threads > 0  # NVIDIA's driver refuses a grid of no blocks
        self.launches.append((kernel, threads))
        blocks = -(-threads // BLOCK)
        stream.append(lambda: self._kernels.run(kernel, list(arguments[1:]), BLOCK * blocks))

    def number(self, stream: deque[Callable[[], None]]) -> int:
        return id(stream)

    def follow(self, stream: deque[Callable[[], None]], other: int) -> None:
        self.followed.append(other)

    def card_of(self, address: int) -> int:
        self._within(address, 1)
        return 0

    def is_done(self, stream: deque[Callable[[], None]]) -> bool:
        if stream:
            stream.popleft()()
        return not stream
