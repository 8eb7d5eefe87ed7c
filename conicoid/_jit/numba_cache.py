"""Cache of a kernel's compiled versions on disk, in place of Numba's own cache.

Numba stamps a function with its own file only, and would return stale code after an edit of a file that it calls.
"""

from __future__ import annotations

import contextlib
import hashlib
import pickle
import sys
from collections.abc import Iterator
from pathlib import Path
from typing import Any

from numba.core import caching, config
from numba.core.compiler import CompileResult
from numba.core.serialize import dumps

from . import address_space, compile_lock, disk_cache, vector_width
from .compile_lock import CompileLock
from .sources import source_hash

PATIENCE = 120.0
"""Seconds to wait for another process that compiles the same kernel; then this process compiles it as well."""

_SETTINGS = ("OPT", "LOOP_VECTORIZE", "SLP_VECTORIZE", "BOUNDSCHECK", "DEBUGINFO_DEFAULT")


def _parts(function: Any) -> list[Any]:
    """Return a function and everything that it encloses, recursively; for compiled functions their Python ones."""
    enclosed = [cell.cell_contents for cell in getattr(function, "__closure__", None) or ()]
    return [function, *(part for each in enclosed for part in _parts(getattr(each, "py_func", each)))]


def _is_ours(function: Any) -> bool:
    """True for a function of this package, which the hash of sources identifies, and for an integer."""
    if isinstance(function, int):
        return True
    code = getattr(function, "__code__", None)
    return code is not None and Path(code.co_filename).resolve().is_relative_to(disk_cache.PACKAGE)


def _place_of(function: Any) -> str:
    """Return module, name and line of a function, or the text of an integer."""
    if isinstance(function, int):
        return str(function)
    return f"{function.__module__}.{function.__qualname__}:{function.__code__.co_firstlineno}"


class KernelCache(caching.NullCache):
    """The cache from which Numba's dispatcher loads compiled versions; functions of other packages are not saved."""

    def __init__(self, function: Any) -> None:
        self._function = function
        self._turn: CompileLock | None = None
        self._parts = _parts(function)
        self._kept = all(map(_is_ours, self._parts)) and bool(source_hash())

    @property
    def cache_path(self) -> str | None:
        """The folder of the kernels; None if nothing is saved."""
        folder = disk_cache.kernel_directory()
        return str(folder) if self._kept and folder else None

    def load_overload(self, signature: Any, target: Any) -> Any:
        """Return a version from the disk, if need be after another process has compiled it; None: compile it."""
        target.refresh()
        name = self._function.__name__
        version = None
        if self._kept:
            file = self._file(signature, target.codegen())
            version = self._loaded(file, target) or self._from_another(file, target)
        if version is None:
            address_space.require_memory(address_space.TO_COMPILE, f"to compile the kernel {name}")
        return version

    def save_overload(self, signature: Any, data: Any) -> None:
        """Save a compiled version, if that is possible."""
        if not self._kept or data.library.has_dynamic_globals:  # these hold addresses of this process
            return
        disk_cache.write_kernel(self._file(signature, data.codegen), dumps(data._reduce()))

    @contextlib.contextmanager
    def until_saved(self) -> Iterator[None]:
        """Release the kernel's lock at the end of the block; until then other processes wait for this one."""
        try:
            yield
        finally:
            turn, self._turn = self._turn, None
            if turn is not None:
                turn.end()

    def _file(self, signature: Any, codegen: Any) -> str:
        """Return the name of a version's file, with a hash of all that it depends on besides the sources."""
        code = self._function.__code__
        settings = [str(getattr(config, name, None)) for name in _SETTINGS]
        target = *codegen.magic_tuple(), vector_width.bits(codegen)
        about = (str(signature), target, sys.implementation.cache_tag, settings, code.co_code)
        places = ",".join(map(_place_of, self._parts))
        number = hashlib.sha256(f"{places} {about!r}".encode()).hexdigest()[:24]
        return f"{self._function.__name__}-{number}.nbc"

    def _loaded(self, file: str, target: Any) -> Any:
        """Return the version in a file; None if there is no usable one."""
        data = disk_cache.read_kernel(file)
        if data is None:
            return None
        address_space.require_memory(address_space.TO_LOAD, f"to load the kernel {self._function.__name__}")
        try:
            return CompileResult._rebuild(target, *pickle.loads(data))
        except MemoryError:
            raise
        except Exception:  # a complete file that cannot be used here
            disk_cache.drop_kernel(file)
            return None

    def _from_another(self, file: str, target: Any) -> Any:
        """Return the version that another process has compiled; None if this process shall compile it."""
        folder = disk_cache.prepare_directory()
        if folder is None:
            return None
        turn = self._turn = CompileLock(folder / f"{file}.lock")
        if turn.taken():
            return self._loaded(file, target)  # another process may have saved it meanwhile
        # Another process compiles it: wait until it releases the lock
        compile_lock.notify_compile(self._function.__name__)
        compile_lock.poll(lambda: turn.taken(), PATIENCE)
        return self._loaded(file, target)
