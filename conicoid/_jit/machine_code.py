"""Machine code of the package: the extension that native/ builds, its memory, and a test for free memory.

Without memory LLVM and the C library end the process, so work that cannot fail safely tests first.
"""

from __future__ import annotations

import importlib
import math
import mmap
import sys
from collections.abc import Callable
from typing import Any

import numpy as np

from .._util.environment import LEVEL, read_jit_mode, read_processor_level
from .._util.validation import LARGEST, SMALLEST

TO_RUN, TO_START, TO_COMPILE = 128, 512, 512
"""MiB that a memory limit must leave: to run without a compiler, to start the compiler, and to compile a kernel. About
one and a half times the measured values (2026-11, Linux)."""


def _is_limited() -> bool:
    """True if this process has a memory limit."""
    if sys.platform in ("win32", "emscripten"):
        return False
    import resource

    # Both limits make an allocation fail: of the address space, and of the data segment.
    kinds = (resource.RLIMIT_AS, resource.RLIMIT_DATA)
    return any(resource.getrlimit(kind)[0] != resource.RLIM_INFINITY for kind in kinds)


def require_memory(mebibytes: int, what: str) -> None:
    """Check that a limit of this process (`ulimit -v`, `ulimit -d`) leaves `mebibytes` of memory.

    Parameters
    ----------
    mebibytes : int
        MiB that must be left.
    what : str
        The work that needs them, for the message.

    Raises
    ------
    MemoryError
        If less memory is left; the message is one line.
    """
    if sys.platform == "win32" or not _is_limited():
        return
    # Reserve the memory and release it at once
    try:
        mmap.mmap(-1, mebibytes << 20, flags=mmap.MAP_PRIVATE | mmap.MAP_ANONYMOUS).close()
    except (OSError, MemoryError):
        message = f"{what} takes up to {mebibytes} MiB of memory; a limit of this process leaves less (see ulimit -v)"
        raise MemoryError(message) from None


# The kernels as machine code of the package: the extension `conicoid._kernels`, which `native/` builds.
#
# It holds them for several processor levels and uses the best that this processor has; all give the same bits.


def _load_extension() -> Any:
    """Return the extension; None if there is none, if it was built from other sources, or if CONICOID_JIT is set.

    Raises
    ------
    ValueError
        If the requested processor level is not available.
    """
    if read_jit_mode():
        return None
    # Before the import: loading without memory would end the process.
    require_memory(TO_RUN, "Conicoid")
    try:
        _kernels: Any = importlib.import_module(__name__.partition(".")[0] + "._kernels")
    except ModuleNotFoundError:
        return None
    if _kernels.sources:  # built in place: the sources may have been edited since
        from .sources import is_current

        if not is_current(_kernels.sources):
            return None
    requested, levels = read_processor_level(), _kernels.levels()
    if requested and requested not in levels:
        raise ValueError(f"{LEVEL} must be {' or '.join(levels)} on this processor, got {requested[:80]!r}")
    if requested:
        _kernels.use(requested)
    return _kernels


SHIPPED: Any = _load_extension()
"""The extension module, or None: then kernels are compiled at their first call."""


def _require_compiler() -> None:
    """Raise ImportError if no compiler is installed."""
    from importlib.util import find_spec

    if find_spec("numba") is None:
        what = "Conicoid came without machine code for this processor, so it needs a compiler"
        raise ImportError(f"{what}: pip install 'conicoid[jit]'")


if SHIPPED is None:
    _require_compiler()


def entry(name: str) -> Callable[..., Any] | None:
    """Return a kernel of the extension; None if it must be compiled."""
    if SHIPPED is None:
        return None
    function: Callable[..., Any] = SHIPPED.kernel(name)
    return _as_array(function) if SHIPPED.returns_array(name) else function


_KERNEL: Any = None if SHIPPED is None else type(SHIPPED.kernel(SHIPPED.kernels()[0]))


def shipped_kernel(kernel: Any) -> Any:
    """Return the kernel of the extension behind a function, which its threads can call; None for others."""
    if SHIPPED is None:
        return None
    return kernel if type(kernel) is _KERNEL else getattr(kernel, "shipped", None)


def _as_array(function: Callable[..., Any]) -> Callable[..., Any]:
    """Return a kernel that wraps the memory of its result as an array."""

    def call(*arguments: Any) -> Any:
        return np.asarray(function(*arguments))

    call.shipped = function  # type: ignore[attr-defined]
    return call


def single_call(kernel: str, arguments: Any, inputs: Any, outputs: Any, most: int = 0) -> Callable[..., Any]:
    """Return a call of a kernel of the extension on the numbers of one ray or point, or of up to `most`.

    It takes the numbers that stand for the arrays `inputs` of the kernel's arguments, and returns their bytes, the
    numbers in the arrays `outputs`, and the kernel's result (native/single.h); None for anything but plain numbers.
    """
    return SHIPPED.single(kernel, arguments, inputs, outputs, SMALLEST, LARGEST, most)


_LARGE = 1 << 18
"""Bytes of an array that takes the memory which earlier answers have left, if there is any."""


def empty_array(shape: int | tuple[int, ...], kind: Any) -> Any:
    """Return an array that is not initialised; a large one takes memory that earlier answers have left.

    The system takes longer to give a million rays new pages than a core to copy them.
    """
    size = math.prod(shape if isinstance(shape, tuple) else (shape,)) * np.dtype(kind).itemsize
    return np.empty(shape, kind) if SHIPPED is None or size < _LARGE else np.ndarray(shape, kind, SHIPPED.room(size))


_ROOM: Any = None if SHIPPED is None else type(SHIPPED.room(0))
"""The owner of the memory of such arrays."""


def is_frozen(array: Any) -> bool:
    """Return whether an array and the array that owns its memory are read-only."""
    while type(array) is np.ndarray and not array.flags.writeable:
        array = array.base
    return array is None or type(array) is _ROOM


def levels() -> tuple[str, ...]:
    """Return the processor levels that this processor can run and the package has machine code for, the best last."""
    return () if SHIPPED is None else tuple(SHIPPED.levels())


def describe_code() -> str:
    """Return the origin of the kernels, for a report."""
    if SHIPPED is None:
        return "compiled by Numba"
    return f"machine code of the package, for {SHIPPED.level()}"
