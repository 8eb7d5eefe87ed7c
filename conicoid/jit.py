"""The two decorators that every compiled function uses, and the cache of compiled kernels.

`kernel` marks entry points called from Python: they release the interpreter lock and are cached on
disk. `inline` marks the small functions inside them, which are merged into their callers, so that
loops over lanes vectorise. Neither ever uses fastmath: infinities, NaN and error-free
transformations must keep their IEEE meaning.

Numba stamps a cached function with its own file only and would serve stale code after an edit of
a file it calls into. Here the cache is a directory named by a hash over all sources of the
package, found by a locator that answers for files of this package and for no others.
"""

from __future__ import annotations

import contextlib
import functools
import hashlib
import os
import shutil
from collections.abc import Callable, Iterator
from pathlib import Path
from typing import Any, TypeVar, cast

import llvmlite
import numba
import platformdirs
from numba import types
from numba.core import caching, event
from numba.extending import intrinsic

from .ahead import on_begin
from .jit_functions import Inner, Kernel

Function = TypeVar("Function", bound=Callable[..., Any])

_PACKAGE = Path(__file__).resolve().parent
_KEPT = 4  # caches of earlier sources that are not removed


def kernel(function: Function) -> Function:
    """Compile an entry point: no interpreter lock, cached on disk."""
    return cast(Function, Kernel(function, nogil=True, error_model="numpy"))


def inline(function: Function) -> Function:
    """Compile a function that is merged into each caller. It may not allocate (no reference counts)."""
    return cast(Function, Inner(function, nogil=True, error_model="numpy", forceinline=True, _nrt=False))


def helper(function: Function) -> Function:
    """Compile a function that is called, not merged: for large ones outside of inner loops. It may not allocate.

    Numba hands forceinline down to the functions that an inlined one calls, unless they say no.
    """
    return cast(Function, Inner(function, nogil=True, error_model="numpy", forceinline=False, _nrt=False))


def allocator(function: Function) -> Function:
    """Compile a function that is called from kernels and allocates arrays."""
    return cast(Function, Inner(function, nogil=True, error_model="numpy", forceinline=False, _nrt=True))


@intrinsic  # type: ignore[untyped-decorator]
def fma(typing_context: Any, a: Any, b: Any, c: Any) -> Any:
    """a b + c with one rounding (IEEE 754 fusedMultiplyAdd), in a vector lane where it stands in a loop."""

    def code(context: Any, builder: Any, signature: Any, arguments: Any) -> Any:
        return builder.fma(*arguments)

    return types.float64(types.float64, types.float64, types.float64), code


@intrinsic  # type: ignore[untyped-decorator]
def choose(typing_context: Any, condition: Any, a: Any, b: Any) -> Any:
    """a where the condition holds, else b: floats, both at hand. Unlike `a if c else b` it never becomes a branch."""

    def code(context: Any, builder: Any, signature: Any, arguments: Any) -> Any:
        return builder.select(*arguments)

    return types.float64(types.boolean, types.float64, types.float64), code


@intrinsic  # type: ignore[untyped-decorator]
def look(typing_context: Any, array: Any, index: Any) -> Any:
    """An element of an array of int64, read anew each time: another thread may have written it."""

    def code(context: Any, builder: Any, signature: Any, arguments: Any) -> Any:
        data = context.make_array(signature.args[0])(context, builder, arguments[0]).data
        return builder.load_atomic(builder.gep(data, [arguments[1]]), "monotonic", 8)

    return types.int64(array, types.int64), code


@functools.cache
def source_hash() -> str:
    """A hash over every source file of the package and the compilers' versions."""
    digest = hashlib.sha256(f"{numba.__version__} {llvmlite.__version__}".encode())
    for path in sorted(_PACKAGE.rglob("*.py")):
        digest.update(path.relative_to(_PACKAGE).as_posix().encode())
        digest.update(path.read_bytes())
    return digest.hexdigest()[:20]


def cache_directory() -> Path:
    """Where kernels are cached: CONICOID_CACHE_DIR, or the user's cache folder."""
    chosen = os.environ.get("CONICOID_CACHE_DIR")
    return Path(chosen) if chosen else Path(platformdirs.user_cache_dir("conicoid", appauthor=False))


class _Locator(caching._CacheLocator):  # type: ignore[misc]
    """Puts the compiled functions of this package, and of no other, into its own cache."""

    def __init__(self, function: Any, file: Path) -> None:
        self._name = "-".join(file.relative_to(_PACKAGE).with_suffix("").parts)
        self._line = function.__code__.co_firstlineno

    def get_cache_path(self) -> str:
        return str(cache_directory() / source_hash() / self._name)

    def get_source_stamp(self) -> str:
        return source_hash()

    def get_disambiguator(self) -> str:
        return str(self._line)

    @classmethod
    def from_function(cls, py_func: Any, py_file: str) -> _Locator | None:
        file = Path(py_file).resolve()
        if not file.is_relative_to(_PACKAGE):
            return None
        locator = cls(py_func, file)
        try:
            locator.ensure_cache_path()
        except OSError:
            return None
        return locator


caching.CacheImpl._locator_classes.insert(0, _Locator)


def remove_old_caches() -> None:
    """Remove the caches of all but the most recent few versions of the sources."""
    with contextlib.suppress(OSError):
        folders = [path for path in cache_directory().iterdir() if path.is_dir() and path.name != source_hash()]
        folders.sort(key=lambda path: path.stat().st_mtime, reverse=True)
        for path in folders[_KEPT:]:
            shutil.rmtree(path, ignore_errors=True)


class _Listener(event.Listener):  # type: ignore[misc]
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
