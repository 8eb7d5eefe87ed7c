"""The decorators that every compiled function uses.

`kernel` marks entry points called from Python: they release the interpreter lock and say what their arguments are.
`inline` marks the small functions inside them, which are merged into their callers, so that loops over lanes vectorise.
None ever uses fastmath: infinities, NaN and error-free transformations must keep their IEEE meaning.

Where the package came with machine code (`machine_code`), a kernel is that, and nothing is compiled; Numba is not even
imported. Elsewhere kernels are compiled as they are first called (`dispatch`), to the same bits.
"""

from __future__ import annotations

import contextlib
import functools
import importlib
import sys
from collections.abc import Callable, Iterator
from typing import Any, TypeVar, cast

from .machine_code import SHIPPED, entry

if SHIPPED is None:
    from . import dispatch as dispatch  # before anything else of the compiler: it asks for room first

Function = TypeVar("Function", bound=Callable[..., Any])

_PACKAGE = __name__.partition(".")[0] + "."

DECLARED: dict[str, tuple[Callable[..., Any], dict[str, str]]] = {}
"""Every kernel that has been declared in this process, and what it says of its arguments (`shapes`)."""


class _LazyFunction:
    """A function or intrinsic that only compiled code calls, made when a compiler asks for it, if ever one does."""

    def __init__(self, function: Callable[..., Any], make: Callable[[], Any]) -> None:
        self.py_func, self._make = function, make
        functools.update_wrapper(self, function)

    def __call__(self, *arguments: Any) -> Any:
        return self.py_func(*arguments)

    def __getattr__(self, name: str) -> Any:
        """All else is asked of what the compiler makes."""
        if name.startswith("__"):
            raise AttributeError(name)
        return getattr(self._made, name)

    @functools.cached_property
    def _made(self) -> Any:
        return self._make()

    @functools.cached_property
    def _numba_type_(self) -> Any:
        """What Numba takes for the type of a value that it does not know."""
        from numba.core.registry import cpu_target

        made = self._made
        for context in (cpu_target.typing_context, cpu_target.target_context):
            context.refresh()  # an intrinsic has just been entered where they look for them
        return cpu_target.typing_context.resolve_value_type(made)


def _compile(function: Any, entry: bool = False, **options: Any) -> Any:
    """A function that Numba is to compile."""
    from . import dispatch

    return dispatch.compile_function(function, entry, **options)


def _inner(function: Function, **options: Any) -> Function:
    """A function that only kernels call."""
    if SHIPPED is None:
        return cast(Function, _compile(function, **options))
    return cast(Function, _LazyFunction(function, lambda: _compile(function, **options)))


def kernel(**shapes: str) -> Callable[[Function], Function]:
    """Declare an entry point: no interpreter lock; its arguments are as `shapes` says."""

    def declare(function: Function) -> Function:
        if not function.__module__.startswith(_PACKAGE):  # somebody else's: it is in no wheel
            return cast(Function, _compile(function, entry=True))
        DECLARED[function.__name__] = function, shapes
        found = entry(function.__name__)
        return cast(Function, _compile(function, entry=True) if found is None else found)

    return declare


def inline(function: Function) -> Function:
    """Compile a function that is merged into each caller. It may not allocate (no reference counts)."""
    return _inner(function, forceinline=True, _nrt=False)


def helper(function: Function) -> Function:
    """Compile a function that is called, not merged: for large ones outside of inner loops. It may not allocate.

    Numba hands forceinline down to the functions that an inlined one calls, unless they say no.
    """
    return _inner(function, forceinline=False, _nrt=False)


def allocator(function: Function) -> Function:
    """Compile a function that is called from kernels and allocates arrays."""
    return _inner(function, forceinline=False, _nrt=True)


def intrinsic(function: Callable[..., Any]) -> Any:
    """Declare an instruction: a function as Numba's own `intrinsic` takes it. Python cannot call it."""

    def make() -> Any:
        from numba.extending import intrinsic as numbas

        return numbas(function)

    return make() if SHIPPED is None else _LazyFunction(function, make)


def instructions(package: str, *modules: str) -> Callable[[str], Any]:
    """What modules of a package write for LLVM, by name, where there is machine code (`SHIPPED`).

    The modules, and with them Numba, are imported when a compiler asks for one of the names.
    """

    def by_name(name: str) -> Any:
        if name.startswith("__"):
            raise AttributeError(name)

        def found() -> Any:
            every = (importlib.import_module(f"{package}.{module}") for module in modules)
            return next(getattr(module, name) for module in every if hasattr(module, name))

        return _LazyFunction(by_name, found)

    return by_name


@intrinsic
def fma(typing_context: Any, a: Any, b: Any, c: Any) -> Any:
    """a b + c with one rounding (IEEE 754 fusedMultiplyAdd), also in the lanes of a vectorised loop."""
    from numba import types

    def code(context: Any, builder: Any, signature: Any, arguments: Any) -> Any:
        return builder.fma(*arguments)

    return types.float64(types.float64, types.float64, types.float64), code


@intrinsic
def choose(typing_context: Any, condition: Any, a: Any, b: Any) -> Any:
    """a where the condition holds, else b: floats, both at hand. Unlike `a if c else b` it never becomes a branch."""
    from numba import types

    def code(context: Any, builder: Any, signature: Any, arguments: Any) -> Any:
        return builder.select(*arguments)

    return types.float64(types.boolean, types.float64, types.float64), code


@intrinsic
def float_bits(typing_context: Any, x: Any) -> Any:
    """The 64 bits of a float as an integer: sign, 11 of the exponent (1023 for 1 to 2), 52 of the fraction."""
    from llvmlite import ir
    from numba import types

    def code(context: Any, builder: Any, signature: Any, arguments: Any) -> Any:
        return builder.bitcast(arguments[0], ir.IntType(64))

    return types.int64(types.float64), code


@intrinsic
def float_from_bits(typing_context: Any, bits: Any) -> Any:
    """The float of these 64 bits."""
    from llvmlite import ir
    from numba import types

    def code(context: Any, builder: Any, signature: Any, arguments: Any) -> Any:
        return builder.bitcast(arguments[0], ir.DoubleType())

    return types.float64(types.int64), code


@intrinsic
def load_atomic(typing_context: Any, array: Any, index: Any) -> Any:
    """An element of an array of int64, read anew each time: another thread may have written it."""
    from numba import types

    def code(context: Any, builder: Any, signature: Any, arguments: Any) -> Any:
        data = context.make_array(signature.args[0])(context, builder, arguments[0]).data
        return builder.load_atomic(builder.gep(data, [arguments[1]]), "monotonic", 8)

    return types.int64(array, types.int64), code


@contextlib.contextmanager
def on_compile(callback: Callable[[str], None]) -> Iterator[None]:
    """Within the block, call `callback(name)` whenever a kernel starts to compile, or is waited for."""
    if SHIPPED is not None and "numba" not in sys.modules:
        yield
        return
    from .dispatch import on_compile

    with on_compile(callback):
        yield


# What kernels say of their arguments: the shapes of arrays, the limits of whole numbers, and what is written.
#
# `@kernel(points="out n 3", begin="0..end", end="0..n")` says that `points` is an array of n rows of three numbers that
# the kernel writes, and that begin and end are within it. Machine code relies on that: whoever hands over something
# else
# gets an error in place of a crash (`native/door.c`). The types are those of the annotations.
#
# - An array has a length for each dimension: a number, a sum like `n`, `n+1`, `8*n` or `2*n+8`, two of these as in
# `n|1`
#   or `n|0`, or `*` for any. `out` before them, or alone before a record, says that it is written.
# - A whole number has limits, `low..high`; either may be missing. `picture n` is what `packets.load` takes as width:
#   0 or a divisor of n.
# - A name is a length that all arguments share, or another whole number among them, or (a name of
# `engine.tables.Tables`)
#   the length of that table of the geometry.
#
# What is in an array is never looked at, only how long it is. So the rows of a table of any length, `*`, are where
# other
# tables say; those are the package's own work, as the geometry's `places` are, and a mistake in them is no caller's.
# Each
# such table has its reason in `tests/native/test_signature.py`.
#
# A record says it of its fields once for all kernels, by `@shaped`.

Record = TypeVar("Record", bound=type[Any])


def record_shapes(**shapes: str) -> Callable[[Record], Record]:
    """What the fields of a record are, for all kernels that take one."""

    def put(record: Record) -> Record:
        record.__shapes__ = shapes
        return record

    return put
