"""Test for free memory before work that cannot fail safely: without memory LLVM and the C library end the process."""

from __future__ import annotations

import mmap
import sys

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
