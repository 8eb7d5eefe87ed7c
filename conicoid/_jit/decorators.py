"""The decorators that every compiled function uses.

`kernel` marks entry points called from Python: they release the interpreter lock and declare their arguments. `inline`
marks the small functions inside them, which are inlined into their callers, so that loops over lanes vectorise. None
ever uses fastmath: infinities, NaN and error-free transformations must keep their IEEE meaning.

If the package came with machine code (machine_code.py), a kernel is that code, nothing is compiled, and Numba is not
even imported. Otherwise kernels are compiled at their first call (compiler.py), to the same bits.
"""

from __future__ import annotations

import functools
import importlib
from collections.abc import Callable
from typing import Any, TypeVar, cast

from .machine_code import SHIPPED, entry

if SHIPPED is None:
    from . import compiler as compiler  # before other parts of Numba: it first checks that memory is left

Function = TypeVar("Function", bound=Callable[..., Any])

_PACKAGE = __name__.partition(".")[0] + "."

DECLARED: dict[str, tuple[Callable[..., Any], dict[str, str]]] = {}
"""Every kernel declared in this process, by name, with the declared shapes of its arguments."""


class _LazyFunction:
    """A function or intrinsic that only compiled code calls, made at the first use by a compiler."""

    def __init__(self, function: Callable[..., Any], make: Callable[[], Any]) -> None:
        self.py_func, self._make = function, make
        functools.update_wrapper(self, function)

    def __call__(self, *arguments: Any) -> Any:
        return self.py_func(*arguments)

    def __getattr__(self, name: str) -> Any:
        """Return an attribute of the function that the compiler makes."""
        if name.startswith("__"):
            raise AttributeError(name)
        return getattr(self._made, name)

    @functools.cached_property
    def _made(self) -> Any:
        return self._make()

    @functools.cached_property
    def _numba_type_(self) -> Any:
        """The attribute by which Numba finds the type of a value that it does not know."""
        from numba.core.registry import cpu_target

        made = self._made
        for context in (cpu_target.typing_context, cpu_target.target_context):
            context.refresh()  # making an intrinsic registers it, but contexts see new registrations only after this
        return cpu_target.typing_context.resolve_value_type(made)


def _compile(function: Any, entry: bool = False, **options: Any) -> Any:
    """Return a function that Numba compiles at its first call."""
    from . import compiler

    return compiler.compile_function(function, entry, **options)


def _inner(function: Function, **options: Any) -> Function:
    """Return a function that only kernels call."""
    if SHIPPED is None:
        return cast(Function, _compile(function, **options))
    return cast(Function, _LazyFunction(function, lambda: _compile(function, **options)))


def kernel(**shapes: str) -> Callable[[Function], Function]:
    """Declare an entry point, which releases the interpreter lock; `shapes` declares its arguments (see below)."""

    def declare(function: Function) -> Function:
        if not function.__module__.startswith(_PACKAGE):  # a kernel of another package: it is in no wheel
            return cast(Function, _compile(function, entry=True))
        DECLARED[function.__name__] = function, shapes
        found = entry(function.__name__)
        return cast(Function, _compile(function, entry=True) if found is None else found)

    return declare


def inline(function: Function) -> Function:
    """Compile a function that is inlined into each caller.

    It counts no references to arrays. So it may not allocate, and what it returns to a kernel or an allocator, which
    count theirs, may hold no array: memory would be freed twice.
    """
    return _inner(function, forceinline=True, _nrt=False)


def helper(function: Function) -> Function:
    """Compile a function that is called, not inlined: for large ones outside of inner loops. Else as `inline`."""
    # forceinline=False explicitly: Numba hands the option down to the functions that an inlined one calls
    return _inner(function, forceinline=False, _nrt=False)


def allocator(function: Function) -> Function:
    """Compile a function that kernels call and that allocates or returns arrays."""
    return _inner(function, forceinline=False, _nrt=True)


def intrinsic(function: Callable[..., Any]) -> Any:
    """Declare an intrinsic, for a function as Numba's `intrinsic` takes it. Python cannot call it."""

    def make() -> Any:
        from numba.extending import intrinsic as numbas

        return numbas(function)

    return make() if SHIPPED is None else _LazyFunction(function, make)


def instructions(package: str, *modules: str) -> Callable[[str], Any]:
    """Return a module `__getattr__` that gives lazy intrinsics of some modules of a package, where code is `SHIPPED`.

    It imports the modules, and with them Numba, when a compiler needs one of the names.
    """

    def by_name(name: str) -> Any:
        if name.startswith("__"):
            raise AttributeError(name)

        def make() -> Any:
            every = (importlib.import_module(f"{package}.{module}") for module in modules)
            return next(getattr(module, name) for module in every if hasattr(module, name))

        return _LazyFunction(by_name, make)

    return by_name


@intrinsic
def fma(typing_context: Any, a: Any, b: Any, c: Any) -> Any:
    """Return a b + c with one rounding (IEEE 754 fusedMultiplyAdd), also in the lanes of a vectorised loop."""
    from numba import types

    def code(context: Any, builder: Any, signature: Any, arguments: Any) -> Any:
        return builder.fma(*arguments)

    return types.float64(types.float64, types.float64, types.float64), code


@intrinsic
def choose(typing_context: Any, condition: Any, a: Any, b: Any) -> Any:
    """Return float a if the condition holds, else float b. Unlike `a if c else b` it never becomes a branch."""
    from numba import types

    def code(context: Any, builder: Any, signature: Any, arguments: Any) -> Any:
        return builder.select(*arguments)

    return types.float64(types.boolean, types.float64, types.float64), code


@intrinsic
def float_bits(typing_context: Any, x: Any) -> Any:
    """Return the 64 bits of a float as an integer: sign, 11 of the exponent (1023 for 1 to 2), 52 of the fraction."""
    from llvmlite import ir
    from numba import types

    def code(context: Any, builder: Any, signature: Any, arguments: Any) -> Any:
        return builder.bitcast(arguments[0], ir.IntType(64))

    return types.int64(types.float64), code


@intrinsic
def float_from_bits(typing_context: Any, bits: Any) -> Any:
    """Return the float of 64 bits."""
    from llvmlite import ir
    from numba import types

    def code(context: Any, builder: Any, signature: Any, arguments: Any) -> Any:
        return builder.bitcast(arguments[0], ir.DoubleType())

    return types.float64(types.int64), code


@intrinsic
def load_atomic(typing_context: Any, array: Any, index: Any) -> Any:
    """Return an element of an array of int64, read from memory each time: another thread may have written it."""
    from numba import types

    def code(context: Any, builder: Any, signature: Any, arguments: Any) -> Any:
        data = context.make_array(signature.args[0])(context, builder, arguments[0]).data
        return builder.load_atomic(builder.gep(data, [arguments[1]]), "monotonic", 8)

    return types.int64(array, types.int64), code


# Declarations of kernels' arguments: shapes of arrays, limits of integers, and which arrays a kernel writes
#
# `@kernel(points="out n 3", begin="0..end", end="0..n")` declares that `points` is an array of n rows of three numbers
# that the kernel writes, and that begin and end are within it. Machine code relies on that: a caller that passes
# anything else gets an error in place of a crash (`native/door.c`). The types are those of the annotations.
#
# - An array has a length for each dimension: a number, a sum like `n`, `n+1`, `8*n` or `2*n+8`, two of these as in
#   `n|1` or `n|0`, or `*` for any. `out` before them, or alone before a record, marks an array that the kernel writes,
#   `strided` one that is only read and whose elements may lie apart.
# - An integer has limits, `low..high`; either may be missing. `picture n` is a width as `fill_lanes` takes it: 0 or a
#   divisor of n.
# - A name is a length that all arguments share, or another integer among them, or (a name of `kernels.tables.Tables`)
#   the length of that table of the geometry.
#
# The check looks at lengths of arrays only, never at their elements. So other tables determine which rows of a table of
# any length, `*`, are read. The package itself makes these tables, as it makes the geometry's `places`, so a mistake in
# them is no caller's. Each such table has its reason in `tests/native/test_signature.py`.
#
# A record declares the shapes of its fields once for all kernels, with `@record_shapes`.

Record = TypeVar("Record", bound=type[Any])


def record_shapes(**shapes: str) -> Callable[[Record], Record]:
    """Declare the shapes of a record's fields, for all kernels that take one."""

    def put(record: Record) -> Record:
        record.__shapes__ = shapes
        return record

    return put
