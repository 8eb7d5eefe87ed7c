"""Compiling as a kernel is first called: by Numba, in our own way or in its plain one, to the same bits.

Our way (`functions`) is made of parts of Numba that are not public, is three times as fast and keeps kernels on disk;
it is taken for the versions of Numba that it has been tested with. Any other gets Numba's plain `njit`, and so does
everybody with `CONICOID_JIT=plain`.
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
"""The first and the last version of Numba that `functions` has been tested with."""


def _is_plain(wish: str, version: str) -> bool:
    """Is Numba's own `njit` to be taken: by a wish ("plain", "own", or ""), or because of a version?"""
    known = re.match(r"(\d+)\.(\d+)", version)
    tested = known is not None and TESTED[0] <= (int(known[1]), int(known[2])) <= TESTED[1]
    return wish == "plain" or (not wish and not tested)


PLAIN = _is_plain(read_jit_mode(), numba.__version__)
if not PLAIN:
    from .compiler import Inner, Kernel


def compile_function(function: Any, entry: bool = False, **options: Any) -> Any:
    """A function compiled our way, or by plain `njit` (`PLAIN`)."""
    options |= dict(nogil=True, error_model="numpy")
    if PLAIN:
        return numba.njit(**options)(function)
    return (Kernel if entry else Inner)(function, **options)


class _Listener(event.Listener):
    """Numba's events of our kernels, as calls with their names."""

    def __init__(self, callback: Callable[[str], None]) -> None:
        self._callback = callback

    def on_start(self, event: Any) -> None:
        function = event.data["dispatcher"].py_func
        options = event.data["dispatcher"].targetoptions
        if function.__module__.startswith("conicoid.") and not options.get("forceinline"):
            self._callback(function.__name__)

    def on_end(self, event: Any) -> None:
        del event


@contextlib.contextmanager
def on_compile(callback: Callable[[str], None]) -> Iterator[None]:
    """Within the block, call `callback(name)` whenever a kernel starts to compile, or is waited for."""
    listener = _Listener(callback)
    event.register("numba:compile", listener)
    try:
        with on_begin(callback):
            yield
    finally:
        event.unregister("numba:compile", listener)
