"""Intrinsics for boxes as LLVM vectors: LLVM unrolls a loop over eight numbers, and leaves it scalar."""

from __future__ import annotations

from typing import Any

from llvmlite import ir
from numba import types
from numba.extending import intrinsic

SIZE = 8
_EIGHT = ir.VectorType(ir.DoubleType(), SIZE)


def _vector_at(context: Any, builder: Any, signature: Any, arguments: Any, k: int) -> Any:
    """Return a pointer to the eight floats at arguments[k][arguments[k + 1]:]."""
    array = context.make_array(signature.args[k])(context, builder, arguments[k])
    return builder.bitcast(builder.gep(array.data, [arguments[k + 1]]), _EIGHT.as_pointer())


@intrinsic
def join(typing_context: Any, into: Any, at: Any, other: Any, place: Any) -> Any:
    """into[at:at + 8] = the greater of it and other[place:place + 8], number by number."""

    def code(context: Any, builder: Any, signature: Any, arguments: Any) -> Any:
        target = _vector_at(context, builder, signature, arguments, 0)
        a = builder.load(target, align=8)
        b = builder.load(_vector_at(context, builder, signature, arguments, 2), align=8)
        builder.store(builder.select(builder.fcmp_ordered(">", a, b), a, b), target, align=8)
        return context.get_dummy_value()

    return types.void(into, types.int64, other, types.int64), code


@intrinsic
def copy(typing_context: Any, into: Any, at: Any, other: Any, place: Any) -> Any:
    """into[at:at + 8] = other[place:place + 8]"""

    def code(context: Any, builder: Any, signature: Any, arguments: Any) -> Any:
        value = builder.load(_vector_at(context, builder, signature, arguments, 2), align=8)
        builder.store(value, _vector_at(context, builder, signature, arguments, 0), align=8)
        return context.get_dummy_value()

    return types.void(into, types.int64, other, types.int64), code


@intrinsic
def exchange(typing_context: Any, one: Any, at: Any, other: Any, place: Any) -> Any:
    """Exchange one[at:at + 8] and other[place:place + 8]."""

    def code(context: Any, builder: Any, signature: Any, arguments: Any) -> Any:
        first = _vector_at(context, builder, signature, arguments, 0)
        second = _vector_at(context, builder, signature, arguments, 2)
        a, b = builder.load(first, align=8), builder.load(second, align=8)
        builder.store(b, first, align=8)
        builder.store(a, second, align=8)
        return context.get_dummy_value()

    return types.void(one, types.int64, other, types.int64), code


@intrinsic
def clear(typing_context: Any, into: Any, at: Any) -> Any:
    """into[at:at + 8] = -inf: a box that holds nothing."""

    def code(context: Any, builder: Any, signature: Any, arguments: Any) -> Any:
        nothing = ir.Constant(_EIGHT, [float("-inf")] * SIZE)
        builder.store(nothing, _vector_at(context, builder, signature, arguments, 0), align=8)
        return context.get_dummy_value()

    return types.void(into, types.int64), code
