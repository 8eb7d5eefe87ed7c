"""Our compiler: Numba's dispatchers with fewer passes, memoized typing, and code that is optimised once per kernel.

It compiles kernels at their first call where there is no machine code, and it is the front end of `native`, which makes
that. Nothing is kept on disk.

Numba compiles every function as if Python called it: with all functions that it calls it is optimised and turned into
machine code, then again as part of each caller, and so on at every level. A process then reaches its first hit after
134 s of processor time, its first picture after 291 s. Here an inner function, which only kernels call, is type-checked
and lowered once, and optimised only as a part of each kernel: 40 s and 67 s.
"""

from __future__ import annotations

import contextlib
import gc
import os
import re
import sys
import threading
import time
from collections.abc import Iterator
from typing import Any

from .machine_code import TO_COMPILE, TO_START, require_memory

require_memory(TO_START, "the compiler")

# isort: split
import numba
from numba import types
from numba.core import codegen, compiler, event, sigutils, typed_passes, typing, untyped_passes
from numba.core.compiler_lock import global_compiler_lock
from numba.core.compiler_machinery import PassManager
from numba.core.registry import CPUDispatcher
from numba.core.targetconfig import ConfigStack

from .._util.environment import read_jit_mode
from .._util.process import run_interruptible, start_thread, wait_for_imports

TESTED = (0, 65), (0, 68)
"""The first and the last version of Numba with which this file, which uses private parts of it, has been tested."""


def require_tested_version(version: str, wish: str) -> None:
    """Raise ImportError for a version of Numba outside `TESTED`, unless CONICOID_JIT (`wish`) is set."""
    parts = re.match(r"(\d+)\.(\d+)", version)
    # An unreadable version counts as untested
    if not wish and not (parts and TESTED[0] <= (int(parts[1]), int(parts[2])) <= TESTED[1]):
        first, last = (".".join(map(str, each)) for each in TESTED)
        raise ImportError(
            f"Conicoid compiles with Numba {first} to {last}, found {version}: pip install 'conicoid[jit]', "
            "or try it with CONICOID_JIT=own"
        )


require_tested_version(numba.__version__, read_jit_mode())

# The passes that inner functions need: they have no closures, no `with`, no literal arguments and no arithmetic on
# whole arrays, inline no overloads, and own no memory that the end of a variable's life would free
_PASSES = (
    untyped_passes.TranslateByteCode,
    untyped_passes.FixupArgs,
    untyped_passes.IRProcessing,
    untyped_passes.GenericRewrites,
    untyped_passes.ReconstructSSA,
    typed_passes.NopythonTypeInference,
    typed_passes.PreLowerStripPhis,
    typed_passes.NativeLowering,
    typed_passes.NoPythonBackend,
)


def inner_passes() -> PassManager:
    """Return the passes from the bytecode of an inner function to its LLVM code."""
    manager = PassManager("inner")
    for each in _PASSES:
        manager.add_pass(each, each.__name__)
    manager.finalize()
    return manager


class _Typing(typing.Context):
    """Numba's typing context with a memory of call types: Numba tries some dozen templates for each `+`."""

    _memory: dict[Any, Any]

    def resolve_function_type(self, function: Any, arguments: Any, names: Any) -> Any:
        """Return the type of a call, memoized by function, arguments and flags."""
        if not isinstance(function, types.Function) or names:
            return super().resolve_function_type(function, arguments, names)
        flags = ConfigStack.top_or_none()
        # The type of a call depends on these two flags of the caller
        key = function, arguments, flags and (flags.forceinline, flags.nrt)
        answer = self._memory.get(key)
        if answer is None:
            answer = self._memory[key] = super().resolve_function_type(function, arguments, names)
        return answer


_views: dict[int, _Typing] = {}


def memoize_typing(context: Any) -> Any:
    """Return a view of a typing context that shares its state and has a memory of call types."""
    if isinstance(context, _Typing):
        return context
    view = _views.get(id(context))
    if view is None:  # no __init__: it would make a second, empty context
        view = object.__new__(_Typing)
        context._memory = {}
        # Shared state: Numba goes on to register functions in its own context.
        view.__dict__ = context.__dict__
        _views[id(context)] = view
    return view


# The code of kernels, which Python calls, and of inner functions, which only kernels call


class _NoAddressCodegen:
    """A code generator for functions without an address: they refer to no Python objects."""

    def __init__(self, actual: Any) -> None:
        self._actual = actual

    def __getattr__(self, name: str) -> Any:
        return getattr(self._actual, name)

    def set_env(self, name: str, environment: Any) -> None:
        """Keep no environment: the code has no address to put it at."""


class _InnerLibrary(codegen.JITCodeLibrary):
    """The code of an inner function alone: not linked with the functions that it calls, and not placed in memory."""

    _linking_libraries: list[Any]

    def finalize(self) -> None:
        self._raise_if_finalized()
        for library in self._linking_libraries:
            self._reload_init.update(library._reload_init)
        self._finalized = True

    def _get_module_for_linking(self) -> Any:
        """Return the code with all functions that it calls, for callers that Numba's own `njit` compiles."""
        whole = _own_module(self).clone()
        for library in _reachable_libraries(self._linking_libraries):
            whole.link_in(_own_module(library), preserve=True)
        return whole

    def get_pointer_to_function(self, name: str) -> int:
        return 0

    @property
    def codegen(self) -> Any:
        return _NoAddressCodegen(self._codegen)


class _KernelLibrary(codegen.JITCodeLibrary):
    """The code of a kernel, with all functions that it calls, directly or not."""

    _linking_libraries: list[Any]

    def finalize(self) -> None:
        for library in _reachable_libraries(self._linking_libraries):
            self._reload_init.update(library._reload_init)
            self._final_module.link_in(_own_module(library), preserve=True)
        self._linking_libraries = []
        super().finalize()


def _own_module(library: Any) -> Any:
    """Return the code of a library, without that of the inner functions that it calls."""
    return codegen.JITCodeLibrary._get_module_for_linking(library)


def _reachable_libraries(libraries: list[Any]) -> list[Any]:
    """Return some libraries and those that inner functions among them call, each once."""
    found: dict[Any, None] = {}
    waiting = list(libraries)
    while waiting:
        library = waiting.pop()
        if library not in found:
            found[library] = None
            if isinstance(library, _InnerLibrary):
                waiting += library._linking_libraries
    return list(found)


class _Compiler(compiler.Compiler):
    """Numba's compiler with our typing context and library class."""

    library: type[Any] = _InnerLibrary

    def __init__(self, typing_context: Any, target: Any, library: Any, *rest: Any) -> None:
        library = library or self.library(target.codegen(), "inner")
        super().__init__(memoize_typing(typing_context), target, library, *rest)


class _InnerCompiler(_Compiler):
    """The compiler of inner functions, with fewer passes for those that do not allocate."""

    def define_pipelines(self) -> list[Any]:
        return super().define_pipelines() if self.state.flags.nrt else [inner_passes()]


class _KernelCompiler(_Compiler):
    """The compiler of kernels."""

    library = _KernelLibrary


_fork_holds: list[bool] = []  # an element while a thread that forks holds the compiler's lock


def _lock_before_fork() -> None:
    """Take the compiler's lock: a fork while another thread compiles would leave the child half a compiler."""
    wait_for_imports()  # before the lock is held, as an import may compile
    global_compiler_lock.acquire()
    _fork_holds.append(True)


def _unlock_after_fork() -> None:
    """Release the compiler's lock, in parent and child."""
    if _fork_holds:  # empty after Ctrl-C in `_lock_before_fork`
        _fork_holds.pop()
        global_compiler_lock.release()


if hasattr(os, "register_at_fork"):
    os.register_at_fork(before=_lock_before_fork, after_in_parent=_unlock_after_fork, after_in_child=_unlock_after_fork)


@contextlib.contextmanager
def _rare_collections() -> Iterator[None]:
    """Collect garbage rarely: a compiler makes millions of objects, and nearly all of them stay alive."""
    with global_compiler_lock:
        thresholds = gc.get_threshold()
        gc.set_threshold(*map(max, thresholds, (200_000, 50, 50)))
        try:
            yield
        finally:
            gc.set_threshold(*thresholds)


def _is_being_imported(module: str) -> bool:
    """True if a module is only partly loaded."""
    return bool(getattr(getattr(sys.modules.get(module), "__spec__", None), "_initializing", False))


class _Note:
    """A line on the terminal while a kernel compiles; nothing where stderr is no terminal."""

    SECONDS = 0.2
    """Between two states of the line."""

    def __init__(self, kernel: str) -> None:
        self._kernel, self._begin, self.functions, self._width = kernel, time.monotonic(), 0, 0
        self._ended = threading.Event()
        self._thread: threading.Thread | None = None

    def __enter__(self) -> _Note:
        stream = sys.stderr
        if stream is not None and not stream.closed and stream.isatty():
            self._write(stream, self._text())
            # LLVM works for many seconds without a call of Python
            self._thread = start_thread(lambda: self._update(stream), "conicoid-note")
        return self

    def __exit__(self, *_: object) -> None:
        self._ended.set()
        if self._thread is not None:
            self._thread.join()

    def _update(self, stream: Any) -> None:
        """Write the line until the kernel is compiled, then erase it."""
        while not self._ended.wait(self.SECONDS):
            self._write(stream, self._text())
        self._write(stream, "")
        self._write(stream, "")

    def _text(self) -> str:
        seconds = time.monotonic() - self._begin
        return f"compiling {self._kernel} in this process: {self.functions} functions, {seconds:.0f} s"

    def _write(self, stream: Any, text: str) -> None:
        """Write over the line; a terminal that is gone is no reason to fail."""
        with contextlib.suppress(OSError, ValueError):
            stream.write(f"\r{text:<{self._width}}")
            stream.flush()
        self._width = len(text)


_notes: list[_Note] = []
"""That of the kernel which is being compiled; guarded by the compiler's lock."""


class Kernel(CPUDispatcher):
    """Numba's dispatcher for a function that Python calls."""

    def __init__(self, function: Any, **options: Any) -> None:
        # No wrapper for C callers: kernels are called from Python alone.
        options |= dict(nopython=True, boundscheck=None, no_cfunc_wrapper=True)
        super().__init__(function, targetoptions=options, pipeline_class=_KernelCompiler)

    def compile(self, signature: Any) -> Any:
        """Compile in another thread, as the main thread would not receive Ctrl-C in LLVM; a compilation always ends.

        While the kernel's module is being imported it compiles in this thread: Numba imports the module as well, and
        another thread would wait for the import to end.
        """
        if global_compiler_lock.is_locked() or _is_being_imported(self.py_func.__module__):
            return self._compile(signature)
        return run_interruptible(lambda: self._compile(signature), "conicoid-compile")

    def _compile(self, signature: Any) -> Any:
        name = self.py_func.__name__
        require_memory(TO_COMPILE, f"to compile the kernel {name}")
        with _rare_collections(), _Note(name) as note:
            _notes.append(note)
            try:
                return super().compile(signature)
            finally:
                _notes.pop()


def _plain_type(kind: Any) -> Any:
    """Return the type of an argument without its value, and without the width of an integer."""
    kind = types.unliteral(kind)
    return types.int64 if kind == types.int32 else kind


class Inner(CPUDispatcher):
    """Numba's dispatcher for a function that kernels call; Python interprets it."""

    def __init__(self, function: Any, **options: Any) -> None:
        # No wrappers at all: only compiled code calls inner functions.
        options |= dict(nopython=True, boundscheck=None, no_cfunc_wrapper=True, no_cpython_wrapper=True)
        super().__init__(function, targetoptions=options, pipeline_class=_InnerCompiler)

    def compile(self, signature: Any) -> Any:
        """Compile as Numba does, without a cache and without timers, which would count nested compilations."""
        with global_compiler_lock, self._compiling_counter:
            arguments, result = sigutils.normalize_signature(signature)
            known = self.overloads.get(tuple(arguments))
            if known is None:
                if _notes:
                    _notes[-1].functions += 1
                details = dict(dispatcher=self, args=arguments, return_type=result)
                with event.trigger_event("numba:compile", data=details):
                    known = self._compiler.compile(arguments, result)
                self.add_overload(known)
            return known.entry_point

    def get_call_template(self, args: Any, kws: Any) -> Any:
        """Return the template for plain types: Numba would compile a function for each constant and integer width."""
        return super().get_call_template(
            tuple(map(_plain_type, args)), {name: _plain_type(kind) for name, kind in kws.items()}
        )

    def __call__(self, *arguments: Any) -> Any:
        return self.py_func(*arguments)


def compile_function(function: Any, entry: bool, **options: Any) -> Any:
    """Return a function that is compiled at its first call; `entry`: Python calls it."""
    return (Kernel if entry else Inner)(function, nogil=True, error_model="numpy", **options)
