"""The decorators that every compiled function uses.

`kernel` marks entry points called from Python: they release the interpreter lock and are cached on
disk. `inline` marks the small functions inside them, which are merged into their callers, so that
loops over lanes vectorise. Neither ever uses fastmath: infinities, NaN and error-free
transformations must keep their IEEE meaning.

They compile in one of two ways, to the same bits. Ours (`jit_functions`) is made of parts of Numba that are not public,
is three times as fast and keeps kernels on disk; it is taken for the versions of Numba that it has been tested with.
Any other gets Numba's plain `njit`, and so does everybody with `CONICOID_JIT=plain`.
"""

from __future__ import annotations

import contextlib
import re
from collections.abc import Callable, Iterator
from typing import Any, TypeVar, cast

from .address_space import TO_START, require

require(TO_START, "the compiler")

# isort: split
import numba
from llvmlite import ir
from numba import types
from numba.core import event
from numba.extending import intrinsic

from ..environment import jit_wanted
from .ahead import on_begin

Function = TypeVar("Function", bound=Callable[..., Any])

TESTED = (0, 65), (0, 68)
"""The first and the last version of Numba that `jit_functions` has been tested with."""


def _is_plain(wish: str, version: str) -> bool:
    """Is Numba's own `njit` to be taken: by a wish ("plain", "own", or ""), or because of a version?"""
    known = re.match(r"(\d+)\.(\d+)", version)
    tested = known is not None and TESTED[0] <= (int(known[1]), int(known[2])) <= TESTED[1]
    return wish == "plain" or (not wish and not tested)


PLAIN = _is_plain(jit_wanted(), numba.__version__)
if not PLAIN:
    from .functions import Inner, Kernel


def _compiled(function: Any, entry: bool = False, **options: Any) -> Any:
    """A function compiled our way, or by plain `njit` (`PLAIN`)."""
    options |= dict(nogil=True, error_model="numpy")
    if PLAIN:
        return numba.njit(**options)(function)
    return (Kernel if entry else Inner)(function, **options)


def kernel(function: Function) -> Function:
    """Compile an entry point: no interpreter lock, cached on disk."""
    return cast(Function, _compiled(function, entry=True))


def inline(function: Function) -> Function:
    """Compile a function that is merged into each caller. It may not allocate (no reference counts)."""
    return cast(Function, _compiled(function, forceinline=True, _nrt=False))


def helper(function: Function) -> Function:
    """Compile a function that is called, not merged: for large ones outside of inner loops. It may not allocate.

    Numba hands forceinline down to the functions that an inlined one calls, unless they say no.
    """
    return cast(Function, _compiled(function, forceinline=False, _nrt=False))


def allocator(function: Function) -> Function:
    """Compile a function that is called from kernels and allocates arrays."""
    return cast(Function, _compiled(function, forceinline=False, _nrt=True))


@intrinsic
def fma(typing_context: Any, a: Any, b: Any, c: Any) -> Any:
    """a b + c with one rounding (IEEE 754 fusedMultiplyAdd), also in the lanes of a vectorised loop."""

    def code(context: Any, builder: Any, signature: Any, arguments: Any) -> Any:
        return builder.fma(*arguments)

    return types.float64(types.float64, types.float64, types.float64), code


@intrinsic
def choose(typing_context: Any, condition: Any, a: Any, b: Any) -> Any:
    """a where the condition holds, else b: floats, both at hand. Unlike `a if c else b` it never becomes a branch."""

    def code(context: Any, builder: Any, signature: Any, arguments: Any) -> Any:
        return builder.select(*arguments)

    return types.float64(types.boolean, types.float64, types.float64), code


@intrinsic
def bits_of(typing_context: Any, x: Any) -> Any:
    """The 64 bits of a float as an integer: sign, 11 of the exponent (1023 for 1 to 2), 52 of the fraction."""

    def code(context: Any, builder: Any, signature: Any, arguments: Any) -> Any:
        return builder.bitcast(arguments[0], ir.IntType(64))

    return types.int64(types.float64), code


@intrinsic
def of_bits(typing_context: Any, bits: Any) -> Any:
    """The float of these 64 bits."""

    def code(context: Any, builder: Any, signature: Any, arguments: Any) -> Any:
        return builder.bitcast(arguments[0], ir.DoubleType())

    return types.float64(types.int64), code


@intrinsic
def look(typing_context: Any, array: Any, index: Any) -> Any:
    """An element of an array of int64, read anew each time: another thread may have written it."""

    def code(context: Any, builder: Any, signature: Any, arguments: Any) -> Any:
        data = context.make_array(signature.args[0])(context, builder, arguments[0]).data
        return builder.load_atomic(builder.gep(data, [arguments[1]]), "monotonic", 8)

    return types.int64(array, types.int64), code


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
    """Within the block, call `callback(name)` whenever a kernel starts to compile, here or ahead, elsewhere."""
    listener = _Listener(callback)
    event.register("numba:compile", listener)
    try:
        with on_begin(callback):
            yield
    finally:
        event.unregister("numba:compile", listener)
