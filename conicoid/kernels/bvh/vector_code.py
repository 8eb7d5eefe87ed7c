"""What the vector intrinsics are written with: short names over LLVM's builder."""

from __future__ import annotations

from typing import Any

from llvmlite import ir
from numba import types
from numba.core import cgutils
from numba.extending import intrinsic

from . import culling_constants

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
        wider = b.fmul(b.fadd(self.size(first), self.size(last)), self.constant(culling_constants.BOX_SLACK))
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


# Places of bits.


@intrinsic
def lowest_bit(typing_context: Any, bits: Any) -> Any:
    """The place of the lowest bit set; 64 if none is."""

    def code(context: Any, builder: Any, signature: Any, arguments: Any) -> Any:
        return builder.cttz(arguments[0], ir.IntType(1)(0))

    return types.int64(types.int64), code


@intrinsic
def highest_bit(typing_context: Any, bits: Any) -> Any:
    """The place of the highest bit set; -1 if none is."""

    def code(context: Any, builder: Any, signature: Any, arguments: Any) -> Any:
        return builder.sub(INT64(63), builder.ctlz(arguments[0], ir.IntType(1)(0)))

    return types.int64(types.int64), code


@intrinsic
def bit_count(typing_context: Any, bits: Any) -> Any:
    """How many bits are set."""

    def code(context: Any, builder: Any, signature: Any, arguments: Any) -> Any:
        return builder.ctpop(arguments[0])

    return types.int64(types.int64), code


# Rows of lanes: their extremes, and eight rays or hits at once from and to a user's arrays.


@intrinsic
def extent(typing_context: Any, lanes: Any, row: Any) -> Any:
    """(least, greatest) of the 64 lanes from lanes[row]."""

    def code(context: Any, builder: Any, signature: Any, arguments: Any) -> Any:
        c = Code(context, builder)
        pointer, at = c.data(signature, arguments, 0), arguments[1]
        low = high = c.eight(pointer, at, 0)
        for group in range(1, 8):
            value = c.eight(pointer, at, 8 * group)
            low, high = c.smaller(value, low), c.larger(value, high)
        parts = [c.folded(low, c.smaller), c.folded(high, c.larger)]
        return context.make_tuple(builder, signature.return_type, parts)

    return types.UniTuple(types.float64, 2)(lanes, types.int64), code


@intrinsic
def extents(typing_context: Any, lanes: Any, row: Any, low: Any, high: Any) -> Any:
    """The least of each of eight groups of lanes from lanes[row] into lanes[low:], the greatest into lanes[high:]."""

    def code(context: Any, builder: Any, signature: Any, arguments: Any) -> Any:
        c = Code(context, builder)
        pointer = c.data(signature, arguments, 0)
        columns = c.transposed([c.eight(pointer, arguments[1], 8 * group) for group in range(8)])
        for place, join in ((arguments[2], c.smaller), (arguments[3], c.larger)):
            c.store(_joined(columns, join), pointer, place, 0)
        return context.get_dummy_value()

    whole = types.int64
    return types.void(lanes, whole, whole, whole), code


@intrinsic
def reach(typing_context: Any, lanes: Any) -> Any:
    """The greatest of min(t_max, nearest hit) of the 64 lanes."""

    def code(context: Any, builder: Any, signature: Any, arguments: Any) -> Any:
        c, pointer = Code(context, builder), Code(context, builder).data(signature, arguments, 0)
        ends = [
            c.smaller(c.eight(pointer, INT64(0), 64 * 7 + 8 * k), c.eight(pointer, INT64(0), 64 * 8 + 8 * k))
            for k in range(8)
        ]
        most = ends[0]
        for end in ends[1:]:
            most = c.larger(end, most)
        return c.folded(most, c.larger)

    return types.float64(lanes), code


@intrinsic
def put_reaches(typing_context: Any, lanes: Any, row: Any, at: Any) -> Any:
    """The greatest number of each of eight groups of lanes in a row (lanes[row:]) into lanes[at:]."""

    def code(context: Any, builder: Any, signature: Any, arguments: Any) -> Any:
        c = Code(context, builder)
        pointer = c.data(signature, arguments, 0)
        columns = c.transposed([c.eight(pointer, arguments[1], 8 * group) for group in range(8)])
        c.store(_joined(columns, c.larger), pointer, arguments[2], 0)
        return context.get_dummy_value()

    return types.void(lanes, types.int64, types.int64), code


def _joined(eights: list[Any], join: Any) -> Any:
    """Eights joined two by two, to one."""
    while len(eights) > 1:
        eights = [join(eights[k], eights[k + 1]) for k in range(0, len(eights), 2)]
    return eights[0]


@intrinsic
def load_eight(typing_context: Any, points: Any, first: Any, lanes: Any, at: Any) -> Any:
    """Eight points (x, y, z) from row `first` into three rows of 64 lanes, from lanes[at:]; zeros become positive."""

    def code(context: Any, builder: Any, signature: Any, arguments: Any) -> Any:
        c, b = Code(context, builder), builder
        source, target = c.data(signature, arguments, 0), c.data(signature, arguments, 2)
        begin = b.mul(arguments[1], INT64(3))
        parts = [b.fadd(c.eight(source, begin, 8 * k), c.constant(0.0)) for k in range(3)]
        number = ir.IntType(32)
        pair = b.shuffle_vector(
            parts[0], parts[1], ir.Constant(ir.VectorType(number, 16), list(range(16)))
        )  # the first 16 floats
        last = b.shuffle_vector(
            parts[2], ir.Constant(EIGHT, ir.Undefined), ir.Constant(ir.VectorType(number, 16), [*range(8), *range(8)])
        )
        for axis in range(3):
            places = ir.Constant(ir.VectorType(number, WIDTH), [axis + 3 * k for k in range(WIDTH)])
            c.store(b.shuffle_vector(pair, last, places), target, arguments[3], 64 * axis)
        return context.get_dummy_value()

    return types.none(points, types.int64, lanes, types.int64), code


@intrinsic
def store_eight(typing_context: Any, lanes: Any, at: Any, numbers: Any, first: Any) -> Any:
    """Eight lanes from lanes[at:], as they are or as whole numbers, to numbers[first:]."""

    def code(context: Any, builder: Any, signature: Any, arguments: Any) -> Any:
        c, b = Code(context, builder), builder
        value = c.eight(c.data(signature, arguments, 0), arguments[1], 0)
        kind = context.get_data_type(signature.args[2].dtype)
        wide = ir.VectorType(kind, WIDTH)
        if signature.args[2].dtype != types.float64:
            value = b.fptosi(value, wide)
        place = b.bitcast(c.place(c.data(signature, arguments, 2), arguments[3], 0), wide.as_pointer())
        b.store(value, place, align=1)
        return context.get_dummy_value()

    return types.none(lanes, types.int64, numbers, types.int64), code


def _prefetch(to_write: int, level: int) -> Any:
    """An intrinsic that prefetches a line of memory, by LLVM's `prefetch` of a locality."""

    def ask(typing_context: Any, array: Any, at: Any) -> Any:
        def code(context: Any, builder: Any, signature: Any, arguments: Any) -> Any:
            c, number, byte = Code(context, builder), ir.IntType(32), ir.IntType(8).as_pointer()
            place = builder.bitcast(c.place(c.data(signature, arguments, 0), arguments[1], 0), byte)
            kind = ir.FunctionType(ir.VoidType(), [byte, number, number, number])
            function = cgutils.get_or_insert_function(builder.module, kind, "llvm.prefetch.p0")
            builder.call(function, [place, number(to_write), number(level), number(1)])
            return context.get_dummy_value()

        return types.none(array, types.int64), code

    return intrinsic(ask)


prefetch = _prefetch(0, 2)
"""prefetch(array, at): fetch the memory of an array from its element `at`, counted flat, into the cache to be read."""
prefetch_soon = _prefetch(0, 3)
"""The same, to be read at once."""
prefetch_to_write = _prefetch(1, 3)
"""The same, to be written."""


@intrinsic
def widen(typing_context: Any, points: Any, first: Any, extremes: Any, at: Any) -> Any:
    """Eight points (x, y, z) from row `first` on join the extremes of others.

    From extremes[at:] stand 24 least and 24 greatest numbers, those of axis k in every third from the k-th on.
    """

    def code(context: Any, builder: Any, signature: Any, arguments: Any) -> Any:
        c, b = Code(context, builder), builder
        source, target = c.data(signature, arguments, 0), c.data(signature, arguments, 2)
        begin, at = b.mul(arguments[1], INT64(3)), arguments[3]
        for k in (0, 8, 16):
            value = c.eight(source, begin, k)
            c.store(c.smaller(value, c.eight(target, at, k)), target, at, k)
            c.store(c.larger(value, c.eight(target, at, 24 + k)), target, at, 24 + k)
        return context.get_dummy_value()

    return types.none(points, types.int64, extremes, types.int64), code
