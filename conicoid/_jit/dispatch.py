"""Compilation at the first call of a kernel: by our compiler or by Numba's plain `njit`, to the same bits.

Our compiler (compiler.py) uses parts of Numba that are not public, is three times as fast and caches kernels on disk.
It serves the versions of Numba with which it has been tested. Other versions, and `CONICOID_JIT=plain`, get `njit`.
"""

from __future__ import annotations

import contextlib
import re
from collections.abc import Callable, Iterator
from typing import Any

from .address_space import TO_START, require_memory

require_memory(TO_START, "the compiler")

# isort: split
import numba
from numba.core import event

from .._util.environment import read_jit_mode
from .compile_lock import on_begin

TESTED = (0, 65), (0, 68)
"""The first and the last version of Numba with which compiler.py has been tested."""


def _is_plain(wish: str, version: str) -> bool:
    """True if Numba's `njit` shall compile: by a wish ("plain", "own", or "" for none), or for an untested version."""
    known = re.match(r"(\d+)\.(\d+)", version)
    # An unreadable version counts as untested.
    tested = known is not None and TESTED[0] <= (int(known[1]), int(known[2])) <= TESTED[1]
    return wish == "plain" or (not wish and not tested)


PLAIN = _is_plain(read_jit_mode(), numba.__version__)
if not PLAIN:
    from .compiler import Inner, Kernel


def compile_function(function: Any, entry: bool = False, **options: Any) -> Any:
    """Return a function compiled by our compiler, or by plain `njit` (`PLAIN`); `entry`: Python calls it."""
    options |= dict(nogil=True, error_model="numpy")
    if PLAIN:
        return numba.njit(**options)(function)
    return (Kernel if entry else Inner)(function, **options)


class _Listener(event.Listener):
    """Calls a function with the name of each kernel of this package that Numba starts to compile."""

    def __init__(self, callback: Callable[[str], None]) -> None:
        self._callback = callback

    def on_start(self, event: Any) -> None:
        function = event.data["dispatcher"].py_func
        options = event.data["dispatcher"].targetoptions
        # Inlined functions are part of a kernel: listeners hear of kernels and called functions only.
        if function.__module__.startswith("conicoid.") and not options.get("forceinline"):
            self._callback(function.__name__)

    def on_end(self, event: Any) -> None:
        del event


@contextlib.contextmanager
def on_compile(callback: Callable[[str], None]) -> Iterator[None]:
    """Within the block, call `callback(name)` when a kernel starts to compile, here or in a process to wait for."""
    listener = _Listener(callback)
    event.register("numba:compile", listener)
    try:
        with on_begin(callback):
            yield
    finally:
        event.unregister("numba:compile", listener)
