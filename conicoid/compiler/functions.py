"""The compiled functions: kernels, which Python calls, and inner ones, which only kernels call.

Numba compiles every function as if it were called from Python: with all that it calls it is optimised
and turned into machine code, then again as part of each caller, and so on at every level. That was more
than half of the time of a first call. Here an inner function is type-checked and lowered once, and
optimised only as a part of each kernel.
"""

from __future__ import annotations

import contextlib
import gc
import os
import sys
from collections.abc import Iterator
from typing import Any

from numba import types
from numba.core import codegen, compiler, event, sigutils
from numba.core.compiler_lock import global_compiler_lock
from numba.core.registry import CPUDispatcher

from .beside import beside
from .cache import KernelCache
from .passes import passes, with_memory
from .vectors import bits, prefer


class _Nowhere:
    """A code generator for functions without an address: they have no Python objects to refer to."""

    def __init__(self, actual: Any) -> None:
        self._actual = actual

    def __getattr__(self, name: str) -> Any:
        return getattr(self._actual, name)

    def set_env(self, name: str, environment: Any) -> None:
        del name, environment


class _Own(codegen.JITCodeLibrary):
    """The code of a function of ours, in vectors of the width that is ours to choose."""

    def add_ir_module(self, module: Any) -> None:
        prefer(module, bits(self._codegen))
        super().add_ir_module(module)


class _Library(_Own):
    """The code of an inner function by itself: not linked with what it calls, and not placed in memory."""

    _linking_libraries: list[Any]

    def finalize(self) -> None:
        self._raise_if_finalized()
        for library in self._linking_libraries:
            self._reload_init.update(library._reload_init)
        self._finalized = True

    def _get_module_for_linking(self) -> Any:
        """With all that it calls: for functions that Numba's own `njit` compiles."""
        whole = _own(self).clone()
        for library in _reached(self._linking_libraries):
            whole.link_in(_own(library), preserve=True)
        return whole

    def get_pointer_to_function(self, name: str) -> int:
        del name
        return 0

    @property
    def codegen(self) -> Any:
        return _Nowhere(self._codegen)


class _Program(_Own):
    """The code of a kernel, with all that it calls, directly or not."""

    _linking_libraries: list[Any]

    def __init__(self, owner: Any, name: str) -> None:
        super().__init__(owner, name)
        self.enable_object_caching()

    def finalize(self) -> None:
        for library in _reached(self._linking_libraries):
            self._reload_init.update(library._reload_init)
            self._final_module.link_in(_own(library), preserve=True)
        self._linking_libraries = []
        super().finalize()


def _own(library: Any) -> Any:
    """The code of a library, without that of inner functions that it calls."""
    return codegen.JITCodeLibrary._get_module_for_linking(library)


def _reached(libraries: list[Any]) -> list[Any]:
    """Some libraries and those that inner functions among them call, each once."""
    found: dict[Any, None] = {}
    waiting = list(libraries)
    while waiting:
        library = waiting.pop()
        if library not in found:
            found[library] = None
            if isinstance(library, _Library):
                waiting += library._linking_libraries
    return list(found)


class _Compiler(compiler.Compiler):
    """Numba's compiler with our typing context and kind of library."""

    library: type[Any] = _Library

    def __init__(self, typing_context: Any, target: Any, library: Any, *rest: Any) -> None:
        library = library or self.library(target.codegen(), "inner")
        super().__init__(with_memory(typing_context), target, library, *rest)


class _InnerCompiler(_Compiler):
    """The compiler of inner functions, with fewer passes where they allocate nothing."""

    def define_pipelines(self) -> list[Any]:
        return super().define_pipelines() if self.state.flags.nrt else [passes()]


class _KernelCompiler(_Compiler):
    """The compiler of kernels."""

    library = _Program


_held: list[bool] = []  # by whoever forks: the compiler's lock


def _hold() -> None:
    """A fork while another thread compiles would leave the child half a compiler."""
    global_compiler_lock.acquire()
    _held.append(True)


def _let_go() -> None:
    """The compiler's lock is free again, in parent and child."""
    if _held:  # not after Ctrl-C in `_hold`
        _held.pop()
        global_compiler_lock.release()


if hasattr(os, "register_at_fork"):
    os.register_at_fork(before=_hold, after_in_parent=_let_go, after_in_child=_let_go)


@contextlib.contextmanager
def _rare_collections() -> Iterator[None]:
    """Collect garbage rarely: a compiler makes millions of objects, nearly all of which it keeps."""
    with global_compiler_lock:
        usual = gc.get_threshold()
        gc.set_threshold(*map(max, usual, (200_000, 50, 50)))
        try:
            yield
        finally:
            gc.set_threshold(*usual)


def _is_being_imported(module: str) -> bool:
    """Is a module only partly loaded?"""
    return bool(getattr(getattr(sys.modules.get(module), "__spec__", None), "_initializing", False))


class Kernel(CPUDispatcher):
    """Numba's dispatcher of a function that Python calls, cached on disk."""

    def __init__(self, function: Any, **options: Any) -> None:
        options |= dict(nopython=True, boundscheck=None, no_cfunc_wrapper=True)
        super().__init__(function, targetoptions=options, pipeline_class=_KernelCompiler)
        self._cache = KernelCache(self.py_func)

    def compile(self, signature: Any) -> Any:
        """Numba's own, beside the main thread, which would not hear of Ctrl-C in LLVM. What is begun is also ended.

        Not while the kernel's module is being imported: Numba imports it too, and another thread would wait for that.
        """
        if global_compiler_lock.is_locked() or _is_being_imported(self.py_func.__module__):
            return self._compile(signature)
        return beside(lambda: self._compile(signature), "conicoid-compile")

    def _compile(self, signature: Any) -> Any:
        with _rare_collections(), self._cache.until_saved():
            return super().compile(signature)


def _plain(kind: Any) -> Any:
    """The type of an argument, of any value and width."""
    kind = types.unliteral(kind)
    return types.int64 if kind == types.int32 else kind


class Inner(CPUDispatcher):
    """Numba's dispatcher of a function that kernels call. Called from Python, it is interpreted."""

    def __init__(self, function: Any, **options: Any) -> None:
        options |= dict(nopython=True, boundscheck=None, no_cfunc_wrapper=True, no_cpython_wrapper=True)
        super().__init__(function, targetoptions=options, pipeline_class=_InnerCompiler)

    def compile(self, signature: Any) -> Any:
        """Numba's own, without a cache and without timers: each would hear of all that is compiled for this one."""
        with global_compiler_lock, self._compiling_counter:
            arguments, result = sigutils.normalize_signature(signature)
            known = self.overloads.get(tuple(arguments))
            if known is None:
                details = dict(dispatcher=self, args=arguments, return_type=result)
                with event.trigger_event("numba:compile", data=details):
                    known = self._compiler.compile(arguments, result)
                self.add_overload(known)
            return known.entry_point

    def get_call_template(self, args: Any, kws: Any) -> Any:
        """Numba would compile a function anew for each constant and each width of numbers that it is called with."""
        return super().get_call_template(tuple(map(_plain, args)), {name: _plain(kind) for name, kind in kws.items()})

    def __call__(self, *arguments: Any) -> Any:
        return self.py_func(*arguments)
