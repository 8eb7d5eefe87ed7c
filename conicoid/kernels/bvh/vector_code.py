"""Helpers to write vector intrinsics, and the small intrinsics themselves: bits, extremes of lanes, prefetches, boxes.

`Code` gives short names to LLVM's builder; an eight is a vector of eight doubles.
"""

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
        """Return the pointer to the elements of array argument k."""
        return self.context.make_array(signature.args[k])(self.context, self.builder, arguments[k]).data

    def place(self, pointer: Any, at: Any, offset: int) -> Any:
        """Return a pointer to element at + offset."""
        return self.builder.gep(pointer, [self.builder.add(at, INT64(offset))])

    def number(self, pointer: Any, at: Any, offset: int) -> Any:
        """Load one float."""
        return self.builder.load(self.place(pointer, at, offset))

    def eight(self, pointer: Any, at: Any, offset: int) -> Any:
        """Load eight consecutive floats."""
        place = self.builder.bitcast(self.place(pointer, at, offset), EIGHT.as_pointer())
        return self.builder.load(place, align=8)

    def balls(self, pointer: Any, at: Any, stride: Any) -> list[Any]:
        """Load x, y, z and radii of eight balls."""
        b = self.builder
        return [self.eight(pointer, b.add(at, b.mul(stride, INT64(k))), 0) for k in range(4)]

    def store(self, value: Any, pointer: Any, at: Any, offset: int) -> None:
        """Store eight floats."""
        self.builder.store(value, self.builder.bitcast(self.place(pointer, at, offset), EIGHT.as_pointer()), align=8)

    def spread(self, number: Any) -> Any:
        """Return an eight of equal floats."""
        first = self.builder.insert_element(ir.Constant(EIGHT, ir.Undefined), number, ir.IntType(32)(0))
        zeros = ir.Constant(ir.VectorType(ir.IntType(32), WIDTH), [0] * WIDTH)
        return self.builder.shuffle_vector(first, ir.Constant(EIGHT, ir.Undefined), zeros)

    def whole(self, number: Any) -> Any:
        """Return a vector of eight equal integers."""
        first = self.builder.insert_element(ir.Constant(WHOLE, ir.Undefined), number, ir.IntType(32)(0))
        return self.builder.shuffle_vector(first, ir.Constant(WHOLE, ir.Undefined), ir.Constant(_PLACES, [0] * WIDTH))

    def constant(self, value: float) -> Any:
        """Return an eight of a constant."""
        return ir.Constant(EIGHT, [value] * WIDTH)

    def smaller(self, a: Any, b: Any) -> Any:
        """Return the elementwise minimum; b where either is NaN."""
        return self.builder.select(self.builder.fcmp_ordered("<", a, b), a, b)

    def larger(self, a: Any, b: Any) -> Any:
        """Return the elementwise maximum; b where either is NaN."""
        return self.builder.select(self.builder.fcmp_ordered(">", a, b), a, b)

    def size(self, a: Any) -> Any:
        """Return absolute values."""
        return self.larger(a, self.builder.fneg(a))

    def product(self, a: Any, b: Any) -> Any:
        """Return the dot product of two lists of three eights."""
        return self.fused(a[0], b[0], self.fused(a[1], b[1], self.builder.fmul(a[2], b[2])))

    def fused(self, a: Any, b: Any, c: Any) -> Any:
        """Return a b + c, rounded once."""
        return self._call("llvm.fma.v8f64", a, b, c)

    def root(self, a: Any) -> Any:
        """Return square roots; NaN for negative numbers."""
        return self._call("llvm.sqrt.v8f64", a)

    def _call(self, name: str, *eights: Any) -> Any:
        """Call an intrinsic of LLVM on eights."""
        kind = ir.FunctionType(EIGHT, [EIGHT] * len(eights))
        return self.builder.call(cgutils.get_or_insert_function(self.builder.module, kind, name), eights)

    def overlaps(self, first: Any, last: Any) -> Any:
        """Return first <= last, with slack, as an integer of eight bits."""
        return self.builder.bitcast(self.overlapping(first, last), BITS)

    def overlapping(self, first: Any, last: Any) -> Any:
        """Return first <= last, with slack (`BOX_SLACK`), as a vector of eight bits."""
        b = self.builder
        wider = b.fmul(b.fadd(self.size(first), self.size(last)), self.constant(culling_constants.BOX_SLACK))
        return b.fcmp_ordered("<=", first, b.fadd(last, wider))

    def folded(self, a: Any, join: Any) -> Any:
        """Reduce an eight to one number, by joining halves."""
        for half in (4, 2, 1):
            order = [(i + half) % WIDTH for i in range(WIDTH)]
            mask = ir.Constant(ir.VectorType(ir.IntType(32), WIDTH), order)
            a = join(a, self.builder.shuffle_vector(a, a, mask))
        return self.builder.extract_element(a, ir.IntType(32)(0))

    def transposed(self, rows: list[Any]) -> list[Any]:
        """Transpose eight eights: exchange blocks of 4, of 2 and of 1."""
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
        """Move the elements of eight (integers or floats) that a mask selects to the front, without gaps."""
        b, kind = self.builder, ir.FunctionType(WHOLE, [WHOLE, MASK, WHOLE])
        function = cgutils.get_or_insert_function(b.module, kind, "llvm.experimental.vector.compress.v8i64")
        packed = b.call(function, [b.bitcast(values, WHOLE), wanted, ir.Constant(WHOLE, ir.Undefined)])
        return b.bitcast(packed, values.type)


# Bits


@intrinsic
def lowest_bit(typing_context: Any, bits: Any) -> Any:
    """Return the index of the lowest bit set; 64 if none is."""

    def code(context: Any, builder: Any, signature: Any, arguments: Any) -> Any:
        return builder.cttz(arguments[0], ir.IntType(1)(0))

    return types.int64(types.int64), code


@intrinsic
def highest_bit(typing_context: Any, bits: Any) -> Any:
    """Return the index of the highest bit set; -1 if none is."""

    def code(context: Any, builder: Any, signature: Any, arguments: Any) -> Any:
        return builder.sub(INT64(63), builder.ctlz(arguments[0], ir.IntType(1)(0)))

    return types.int64(types.int64), code


@intrinsic
def bit_count(typing_context: Any, bits: Any) -> Any:
    """Return the number of bits set."""

    def code(context: Any, builder: Any, signature: Any, arguments: Any) -> Any:
        return builder.ctpop(arguments[0])

    return types.int64(types.int64), code


# Rows of 64 lanes: their extremes, and eight rays or hits at a time from and to arrays


@intrinsic
def extent(typing_context: Any, lanes: Any, row: Any) -> Any:
    """Return (least, greatest) of the 64 lanes from lanes[row]."""

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
    """Write the least of each of eight groups of lanes from lanes[row] to lanes[low:], the greatest to lanes[high:]."""

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
    """Return the greatest of min(t_max, nearest hit) of the 64 lanes."""

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


def _joined(eights: list[Any], join: Any) -> Any:
    """Reduce several eights to one, elementwise, two by two."""
    while len(eights) > 1:
        eights = [join(eights[k], eights[k + 1]) for k in range(0, len(eights), 2)]
    return eights[0]


@intrinsic
def load_eight(typing_context: Any, points: Any, first: Any, lanes: Any, at: Any) -> Any:
    """Load eight points (x, y, z) from row `first` into three rows of 64 lanes from lanes[at:]; -0 becomes +0."""

    def code(context: Any, builder: Any, signature: Any, arguments: Any) -> Any:
        c, b = Code(context, builder), builder
        source, target = c.data(signature, arguments, 0), c.data(signature, arguments, 2)
        begin = b.mul(arguments[1], INT64(3))
        parts = [b.fadd(c.eight(source, begin, 8 * k), c.constant(0.0)) for k in range(3)]
        number = ir.IntType(32)
        # 24 floats x y z x y z ...: every third one belongs to an axis
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
    """Store eight lanes from lanes[at:] to numbers[first:], converted to integers if `numbers` holds integers."""

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


@intrinsic
def copy_points(
    typing_context: Any, source: Any, first: Any, target: Any, at: Any, least: Any, most: Any, streamed: Any
) -> Any:
    """Copy eight points (x, y, z) from row `first` of an array to row `at` of another; return what they are, in bits.

    Of 24 bits, one for each number, the low ones mark those that are neither 0 nor of a size in [least, most], the next
    ones those that are 0. streamed: write whole lines past the caches, which else read a line before they change it;
    `finish_streams` comes before other threads read them.
    """

    def code(context: Any, builder: Any, signature: Any, arguments: Any) -> Any:
        c, b, bits = Code(context, builder), builder, INT64(0)
        begin, end = (b.mul(arguments[k], INT64(3)) for k in (1, 3))
        numbers = [c.eight(c.data(signature, arguments, 0), begin, 8 * k) for k in range(3)]
        targets = [c.place(c.data(signature, arguments, 2), end, 8 * k) for k in range(3)]
        is_line = b.icmp_unsigned("==", b.and_(b.ptrtoint(targets[0], INT64), INT64(63)), INT64(0))
        with b.if_else(b.and_(is_line, b.trunc(arguments[6], ir.IntType(1)))) as ways:
            for way, align in zip(ways, (64, 8), strict=True):
                with way:
                    for value, target in zip(numbers, targets, strict=True):
                        written = b.store(value, b.bitcast(target, EIGHT.as_pointer()), align=align)
                        if align == 64:
                            written.set_metadata("nontemporal", b.module.add_metadata([ir.Constant(ir.IntType(32), 1)]))
        least, most = c.spread(arguments[4]), c.spread(arguments[5])
        for k, value in enumerate(numbers):
            size, is_zero = c.size(value), b.fcmp_ordered("==", value, c.constant(0.0))
            inside = b.and_(b.fcmp_ordered(">=", size, least), b.fcmp_ordered("<=", size, most))
            for mask, shift in ((b.not_(b.or_(is_zero, inside)), 0), (is_zero, 24)):
                bits = b.or_(bits, b.shl(b.zext(b.bitcast(mask, BITS), INT64), INT64(shift + 8 * k)))
        return bits

    return types.int64(source, types.int64, target, types.int64, types.float64, types.float64, types.int64), code


@intrinsic
def finish_streams(typing_context: Any) -> Any:
    """Make stores past the caches visible to other threads."""

    def code(context: Any, builder: Any, signature: Any, arguments: Any) -> Any:
        builder.fence("seq_cst")
        return context.get_dummy_value()

    return types.none(), code


def _prefetch(to_write: int, level: int) -> Any:
    """Return an intrinsic that prefetches a line of memory, by LLVM's `prefetch` with locality `level`."""

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
"""prefetch(array, at): prefetch for reading the memory of an array at its element `at`, counted flat."""
prefetch_soon = _prefetch(0, 3)
"""`prefetch` for reading very soon."""
prefetch_to_write = _prefetch(1, 3)
"""`prefetch` for writing."""


@intrinsic
def widen(typing_context: Any, points: Any, first: Any, extremes: Any, at: Any) -> Any:
    """Include eight points (x, y, z) from row `first` on in extremes.

    extremes[at:] holds 24 least and 24 greatest numbers; every third of them, from the k-th on, belongs to axis k.
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


# Boxes of eight floats, which `prepare/bvh/sah_binning.py` joins


def _vector_at(context: Any, builder: Any, signature: Any, arguments: Any, k: int) -> Any:
    """Return a pointer to the eight floats at arguments[k][arguments[k + 1]:]."""
    array = context.make_array(signature.args[k])(context, builder, arguments[k])
    return builder.bitcast(builder.gep(array.data, [arguments[k + 1]]), EIGHT.as_pointer())


@intrinsic
def join_box(typing_context: Any, into: Any, at: Any, other: Any, place: Any) -> Any:
    """into[at:at + 8] = the greater of it and other[place:place + 8], number by number."""

    def code(context: Any, builder: Any, signature: Any, arguments: Any) -> Any:
        target = _vector_at(context, builder, signature, arguments, 0)
        a = builder.load(target, align=8)
        b = builder.load(_vector_at(context, builder, signature, arguments, 2), align=8)
        builder.store(builder.select(builder.fcmp_ordered(">", a, b), a, b), target, align=8)
        return context.get_dummy_value()

    return types.void(into, types.int64, other, types.int64), code


@intrinsic
def copy_box(typing_context: Any, into: Any, at: Any, other: Any, place: Any) -> Any:
    """into[at:at + 8] = other[place:place + 8]"""

    def code(context: Any, builder: Any, signature: Any, arguments: Any) -> Any:
        value = builder.load(_vector_at(context, builder, signature, arguments, 2), align=8)
        builder.store(value, _vector_at(context, builder, signature, arguments, 0), align=8)
        return context.get_dummy_value()

    return types.void(into, types.int64, other, types.int64), code


@intrinsic
def exchange_boxes(typing_context: Any, one: Any, at: Any, other: Any, place: Any) -> Any:
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
def clear_box(typing_context: Any, into: Any, at: Any) -> Any:
    """into[at:at + 8] = -inf: a box that holds nothing."""

    def code(context: Any, builder: Any, signature: Any, arguments: Any) -> Any:
        nothing = ir.Constant(EIGHT, [float("-inf")] * WIDTH)
        builder.store(nothing, _vector_at(context, builder, signature, arguments, 0), align=8)
        return context.get_dummy_value()

    return types.void(into, types.int64), code
