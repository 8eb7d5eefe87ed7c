"""What the vector intrinsics are written with: short names over LLVM's builder."""

from __future__ import annotations

from typing import Any

from llvmlite import ir
from numba.core import cgutils

from . import slack

WIDTH = 8
DOUBLE = ir.DoubleType()
EIGHT = ir.VectorType(DOUBLE, WIDTH)
BITS = ir.IntType(WIDTH)
INT64 = ir.IntType(64)
WHOLE = ir.VectorType(INT64, WIDTH)
MASK = ir.VectorType(ir.IntType(1), WIDTH)
_PLACES = ir.VectorType(ir.IntType(32), WIDTH)


class Code:
    """Short names over LLVM's builder; an eight is a vector of eight doubles."""

    def __init__(self, context: Any, builder: Any) -> None:
        self.context, self.builder = context, builder

    def data(self, signature: Any, arguments: Any, k: int) -> Any:
        """Where the elements of array argument k begin."""
        return self.context.make_array(signature.args[k])(self.context, self.builder, arguments[k]).data

    def place(self, pointer: Any, at: Any, offset: int) -> Any:
        """A pointer to element at + offset."""
        return self.builder.gep(pointer, [self.builder.add(at, INT64(offset))])

    def number(self, pointer: Any, at: Any, offset: int) -> Any:
        """One float."""
        return self.builder.load(self.place(pointer, at, offset))

    def eight(self, pointer: Any, at: Any, offset: int) -> Any:
        """Eight floats side by side."""
        place = self.builder.bitcast(self.place(pointer, at, offset), EIGHT.as_pointer())
        return self.builder.load(place, align=8)

    def balls(self, pointer: Any, at: Any, stride: Any) -> list[Any]:
        """x, y, z and radii of eight balls."""
        b = self.builder
        return [self.eight(pointer, b.add(at, b.mul(stride, INT64(k))), 0) for k in range(4)]

    def store(self, value: Any, pointer: Any, at: Any, offset: int) -> None:
        """Eight floats to memory."""
        self.builder.store(value, self.builder.bitcast(self.place(pointer, at, offset), EIGHT.as_pointer()), align=8)

    def spread(self, number: Any) -> Any:
        """The same number in all eight."""
        first = self.builder.insert_element(ir.Constant(EIGHT, ir.Undefined), number, ir.IntType(32)(0))
        zeros = ir.Constant(ir.VectorType(ir.IntType(32), WIDTH), [0] * WIDTH)
        return self.builder.shuffle_vector(first, ir.Constant(EIGHT, ir.Undefined), zeros)

    def whole(self, number: Any) -> Any:
        """The same whole number in all eight."""
        first = self.builder.insert_element(ir.Constant(WHOLE, ir.Undefined), number, ir.IntType(32)(0))
        return self.builder.shuffle_vector(first, ir.Constant(WHOLE, ir.Undefined), ir.Constant(_PLACES, [0] * WIDTH))

    def constant(self, value: float) -> Any:
        """The same constant in all eight."""
        return ir.Constant(EIGHT, [value] * WIDTH)

    def smaller(self, a: Any, b: Any) -> Any:
        """The lesser of each two; b where either is NaN."""
        return self.builder.select(self.builder.fcmp_ordered("<", a, b), a, b)

    def larger(self, a: Any, b: Any) -> Any:
        """The greater of each two; b where either is NaN."""
        return self.builder.select(self.builder.fcmp_ordered(">", a, b), a, b)

    def size(self, a: Any) -> Any:
        """Absolute values."""
        return self.larger(a, self.builder.fneg(a))

    def product(self, a: Any, b: Any) -> Any:
        """The dot product of two lists of three."""
        return self.fused(a[0], b[0], self.fused(a[1], b[1], self.builder.fmul(a[2], b[2])))

    def fused(self, a: Any, b: Any, c: Any) -> Any:
        """a b + c."""
        return self._call("llvm.fma.v8f64", a, b, c)

    def root(self, a: Any) -> Any:
        """Square roots; NaN of negative numbers."""
        return self._call("llvm.sqrt.v8f64", a)

    def _call(self, name: str, *eights: Any) -> Any:
        """Call an intrinsic of LLVM on eights."""
        kind = ir.FunctionType(EIGHT, [EIGHT] * len(eights))
        return self.builder.call(cgutils.get_or_insert_function(self.builder.module, kind, name), eights)

    def overlaps(self, first: Any, last: Any) -> Any:
        """first <= last, with slack, as a number of eight bits."""
        return self.builder.bitcast(self.overlapping(first, last), BITS)

    def overlapping(self, first: Any, last: Any) -> Any:
        """first <= last, with slack, each by itself."""
        b = self.builder
        wider = b.fmul(b.fadd(self.size(first), self.size(last)), self.constant(slack.BOX_SLACK))
        return b.fcmp_ordered("<=", first, b.fadd(last, wider))

    def folded(self, a: Any, join: Any) -> Any:
        """The eight joined two by two, to one number."""
        for half in (4, 2, 1):
            order = [(i + half) % WIDTH for i in range(WIDTH)]
            mask = ir.Constant(ir.VectorType(ir.IntType(32), WIDTH), order)
            a = join(a, self.builder.shuffle_vector(a, a, mask))
        return self.builder.extract_element(a, ir.IntType(32)(0))

    def transposed(self, rows: list[Any]) -> list[Any]:
        """Eight rows of eight as columns: blocks of 4, 2 and 1 change places."""
        for size in (4, 2, 1):
            low = [k if not k & size else k - size + WIDTH for k in range(WIDTH)]
            high = [k + size if not k & size else k + WIDTH for k in range(WIDTH)]
            changed = list(rows)
            for k in range(WIDTH):
                if not k & size:
                    a, other = rows[k], rows[k + size]
                    changed[k] = self.builder.shuffle_vector(a, other, ir.Constant(_PLACES, low))
                    changed[k + size] = self.builder.shuffle_vector(a, other, ir.Constant(_PLACES, high))
            rows = changed
        return rows

    def compressed(self, values: Any, wanted: Any) -> Any:
        """Those of eight (whole numbers or floats) that are wanted, without gaps."""
        b, kind = self.builder, ir.FunctionType(WHOLE, [WHOLE, MASK, WHOLE])
        function = cgutils.get_or_insert_function(b.module, kind, "llvm.experimental.vector.compress.v8i64")
        packed = b.call(function, [b.bitcast(values, WHOLE), wanted, ir.Constant(WHOLE, ir.Undefined)])
        return b.bitcast(packed, values.type)
