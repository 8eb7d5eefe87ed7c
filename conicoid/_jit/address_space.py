"""Memory tested for beforehand: LLVM and the C library end a process that gets none in the middle of their work."""

from __future__ import annotations

import mmap
import sys

TO_RUN, TO_START, TO_LOAD, TO_COMPILE = 128, 512, 256, 512
"""MiB that must be left where a limit is set: for what comes without a compiler, for the compiler itself, for a kernel
of the cache and the threads that run it, and to compile one. About one and a half times of what was seen (2026-11,
Linux)."""


def _is_limited() -> bool:
    """Does this process have a limit of memory?"""
    if sys.platform in ("win32", "emscripten"):
        return False
    import resource

    kinds = (resource.RLIMIT_AS, resource.RLIMIT_DATA)
    return any(resource.getrlimit(kind)[0] != resource.RLIM_INFINITY for kind in kinds)


def require_memory(mebibytes: int, what: str) -> None:
    """MemoryError, in one line, where a limit of this process (`ulimit -v`, `ulimit -d`) leaves less than that."""
    if sys.platform == "win32" or not _is_limited():
        return
    try:
        mmap.mmap(-1, mebibytes << 20, flags=mmap.MAP_PRIVATE | mmap.MAP_ANONYMOUS).close()
    except (OSError, MemoryError):
        message = f"{what} takes up to {mebibytes} MiB of memory; a limit of this process leaves less (see ulimit -v)"
        raise MemoryError(message) from None
