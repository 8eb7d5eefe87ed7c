"""Vectors of eight floats, spelled out where the compiler would not find them by itself.

It vectorises loops over many lanes, but unrolls a loop over the eight children of a node or the
eight rows of a packet first, and then leaves it scalar. So these three are written in LLVM's own
vectors, which it lowers to whatever the machine has. IEEE arithmetic as elsewhere.
"""

from __future__ import annotations

from typing import Any

from llvmlite import ir
from numba import types
from numba.core import cgutils
from numba.extending import intrinsic

from ..geometry.tables import Floats
from ..jit import inline

WIDTH = 8
_DOUBLE = ir.DoubleType()
_EIGHT = ir.VectorType(_DOUBLE, WIDTH)
_BITS = ir.IntType(WIDTH)
_INT64 = ir.IntType(64)
_SLACK = 1e-15
"""Share of |t| by which a box may be missed: more than the rounding of a slab's two ends."""

# Numbers of a beam, in the order of its block: where it starts and ends in t comes last
LOW_O, HIGH_O, LOW_I, HIGH_I, FIRST, LAST = 0, 3, 6, 9, 12, 13
BEAM = 14


class _Code:
    """Short names for what is built."""

    def __init__(self, context: Any, builder: Any) -> None:
        self.context, self.builder = context, builder

    def data(self, signature: Any, arguments: Any, k: int) -> Any:
        """Where the elements of array argument k begin."""
        return self.context.make_array(signature.args[k])(self.context, self.builder, arguments[k]).data

    def place(self, pointer: Any, at: Any, offset: int) -> Any:
        return self.builder.gep(pointer, [self.builder.add(at, _INT64(offset))])

    def number(self, pointer: Any, at: Any, offset: int) -> Any:
        return self.builder.load(self.place(pointer, at, offset))

    def eight(self, pointer: Any, at: Any, offset: int) -> Any:
        place = self.builder.bitcast(self.place(pointer, at, offset), _EIGHT.as_pointer())
        return self.builder.load(place, align=8)

    def store(self, value: Any, pointer: Any, at: Any, offset: int) -> None:
        self.builder.store(value, self.builder.bitcast(self.place(pointer, at, offset), _EIGHT.as_pointer()), align=8)

    def spread(self, number: Any) -> Any:
        """The same number in all eight."""
        first = self.builder.insert_element(ir.Constant(_EIGHT, ir.Undefined), number, ir.IntType(32)(0))
        zeros = ir.Constant(ir.VectorType(ir.IntType(32), WIDTH), [0] * WIDTH)
        return self.builder.shuffle_vector(first, ir.Constant(_EIGHT, ir.Undefined), zeros)

    def constant(self, value: float) -> Any:
        return ir.Constant(_EIGHT, [value] * WIDTH)

    def smaller(self, a: Any, b: Any) -> Any:
        return self.builder.select(self.builder.fcmp_ordered("<", a, b), a, b)

    def larger(self, a: Any, b: Any) -> Any:
        return self.builder.select(self.builder.fcmp_ordered(">", a, b), a, b)

    def size(self, a: Any) -> Any:
        return self.larger(a, self.builder.fneg(a))

    def overlaps(self, first: Any, last: Any) -> Any:
        """first <= last, with slack, as a number of eight bits."""
        b = self.builder
        slack = b.fmul(b.fadd(self.size(first), self.size(last)), self.constant(_SLACK))
        return b.bitcast(b.fcmp_ordered("<=", first, b.fadd(last, slack)), _BITS)

    def folded(self, a: Any, join: Any) -> Any:
        """The eight joined two by two, to one number."""
        for half in (4, 2, 1):
            order = [(i + half) % WIDTH for i in range(WIDTH)]
            mask = ir.Constant(ir.VectorType(ir.IntType(32), WIDTH), order)
            a = join(a, self.builder.shuffle_vector(a, a, mask))
        return self.builder.extract_element(a, ir.IntType(32)(0))


@intrinsic  # type: ignore[untyped-decorator]
def boxes_met(typing_context: Any, boxes: Any, at: Any, beam: Any, start: Any, near: Any) -> Any:
    """Which of the eight boxes at boxes[at:] a beam meets, as bits; where it enters each goes into near[:8].

    The beam (beam[start:], see `BEAM`) holds all points o + t d, t in [first, last], with o and d
    between two corners each: x(t) lies between low o + t low d and high o + t high d as long as t >= 0, so
    every axis gives two linear conditions on t. A single ray is the beam whose corners are equal.
    """

    def code(context: Any, builder: Any, signature: Any, arguments: Any) -> Any:
        c, b = _Code(context, builder), builder
        floats, rays, out = (c.data(signature, arguments, k) for k in (0, 2, 4))
        place, begin = arguments[1], arguments[3]
        first, last = c.spread(c.number(rays, begin, FIRST)), c.spread(c.number(rays, begin, LAST))
        none, all_of_it = c.constant(float("-inf")), c.constant(float("inf"))
        for axis in range(3):
            # The low corner must not lie beyond the box's high side, nor the high corner before its low side
            for corner, slope, side, upward in ((LOW_O, LOW_I, 24, True), (HIGH_O, HIGH_I, 0, False)):
                o = c.spread(c.number(rays, begin, corner + axis))
                inverse = c.number(rays, begin, slope + axis)
                t = b.fmul(b.fsub(c.eight(floats, place, side + 8 * axis), o), c.spread(inverse))
                rises = b.fcmp_ordered(">" if upward else "<", inverse, _DOUBLE(0.0))
                last = c.smaller(b.select(rises, t, all_of_it), last)
                first = c.larger(b.select(rises, none, t), first)
        c.store(first, out, _INT64(0), 0)
        return b.zext(c.overlaps(first, last), _INT64)

    return types.int64(boxes, types.int64, beam, types.int64, near), code


@intrinsic  # type: ignore[untyped-decorator]
def boxes_met_by_ray(typing_context: Any, boxes: Any, at: Any, rays: Any, start: Any, near: Any) -> Any:
    """`boxes_met` for one ray, at rays[start:]: origin, inverse direction, first and last t."""

    def code(context: Any, builder: Any, signature: Any, arguments: Any) -> Any:
        c, b = _Code(context, builder), builder
        floats, ray, out = (c.data(signature, arguments, k) for k in (0, 2, 4))
        place, begin = arguments[1], arguments[3]
        first, last = c.spread(c.number(ray, begin, 6)), c.spread(c.number(ray, begin, 7))
        for axis in range(3):
            o, inverse = c.spread(c.number(ray, begin, axis)), c.spread(c.number(ray, begin, 3 + axis))
            s = b.fmul(b.fsub(c.eight(floats, place, 8 * axis), o), inverse)
            t = b.fmul(b.fsub(c.eight(floats, place, 24 + 8 * axis), o), inverse)
            first, last = c.larger(c.smaller(s, t), first), c.smaller(c.larger(s, t), last)
        c.store(first, out, _INT64(0), 0)
        return b.zext(c.overlaps(first, last), _INT64)

    return types.int64(boxes, types.int64, rays, types.int64, near), code


def _lanes_in_box(groups: int) -> Any:
    def in_box(typing_context: Any, lanes: Any, boxes: Any, at: Any) -> Any:
        def code(context: Any, builder: Any, signature: Any, arguments: Any) -> Any:
            c, b = _Code(context, builder), builder
            rays, floats = c.data(signature, arguments, 0), c.data(signature, arguments, 1)
            sides = [c.spread(c.number(floats, arguments[2], 8 * k)) for k in range(6)]
            met: Any = _INT64(0)
            for group in range(groups):
                rows = [c.eight(rays, _INT64(0), 64 * k + 8 * group) for k in range(9)]
                first, last = rows[6], c.smaller(rows[7], rows[8])
                for axis in range(3):
                    s = b.fmul(b.fsub(sides[axis], rows[axis]), rows[3 + axis])
                    t = b.fmul(b.fsub(sides[3 + axis], rows[axis]), rows[3 + axis])
                    first, last = c.larger(c.smaller(s, t), first), c.smaller(c.larger(s, t), last)
                bits = b.zext(c.overlaps(first, last), _INT64)
                met = b.or_(met, b.shl(bits, _INT64(8 * group)))
            return met

        return types.int64(lanes, boxes, types.int64), code

    return intrinsic(in_box)


_in_box_64, _in_box_16 = _lanes_in_box(8), _lanes_in_box(2)


@inline
def lanes_in_box(lanes: Floats, boxes: Floats, at: int, groups: int) -> int:
    """Which lanes of a packet of two or eight groups of eight meet the box with its six sides at boxes[at::8], as bits.

    The block of lanes begins with rows of 64: origins, inverse directions, t_min, t_max, nearest hits.
    """
    if groups == 8:
        return _in_box_64(lanes, boxes, at)
    return _in_box_16(lanes, boxes, at)


def _extent(groups: int) -> Any:
    def least_and_greatest(typing_context: Any, lanes: Any, row: Any) -> Any:
        def code(context: Any, builder: Any, signature: Any, arguments: Any) -> Any:
            c = _Code(context, builder)
            pointer, at = c.data(signature, arguments, 0), arguments[1]
            low = high = c.eight(pointer, at, 0)
            for group in range(1, groups):
                value = c.eight(pointer, at, 8 * group)
                low, high = c.smaller(value, low), c.larger(value, high)
            parts = [c.folded(low, c.smaller), c.folded(high, c.larger)]
            return context.make_tuple(builder, signature.return_type, parts)

        return types.UniTuple(types.float64, 2)(lanes, types.int64), code

    return intrinsic(least_and_greatest)


_extent_64, _extent_16 = _extent(8), _extent(2)


@inline
def extent(lanes: Floats, row: Any, groups: int) -> tuple[float, float]:
    """(least, greatest) of the lanes of two or eight groups of eight from lanes[row]."""
    if groups == 8:
        return _extent_64(lanes, row)
    return _extent_16(lanes, row)


def _reach(groups: int) -> Any:
    def furthest(typing_context: Any, lanes: Any) -> Any:
        def code(context: Any, builder: Any, signature: Any, arguments: Any) -> Any:
            c, pointer = _Code(context, builder), _Code(context, builder).data(signature, arguments, 0)
            ends = [
                c.smaller(c.eight(pointer, _INT64(0), 64 * 7 + 8 * k), c.eight(pointer, _INT64(0), 64 * 8 + 8 * k))
                for k in range(groups)
            ]
            most = ends[0]
            for end in ends[1:]:
                most = c.larger(end, most)
            return c.folded(most, c.larger)

        return types.float64(lanes), code

    return intrinsic(furthest)


_reach_64, _reach_16 = _reach(8), _reach(2)


@inline
def reach(lanes: Floats, groups: int) -> float:
    """The greatest of min(t_max, nearest hit) of the lanes of two or eight groups of eight."""
    if groups == 8:
        return _reach_64(lanes)
    return _reach_16(lanes)


@intrinsic  # type: ignore[untyped-decorator]
def load_eight(typing_context: Any, points: Any, first: Any, lanes: Any, at: Any) -> Any:
    """Eight points (x, y, z) from row `first` into three rows of 64 lanes, from lanes[at:]."""

    def code(context: Any, builder: Any, signature: Any, arguments: Any) -> Any:
        c, b = _Code(context, builder), builder
        source, target = c.data(signature, arguments, 0), c.data(signature, arguments, 2)
        begin = b.mul(arguments[1], _INT64(3))
        parts = [c.eight(source, begin, 8 * k) for k in range(3)]
        number = ir.IntType(32)
        pair = b.shuffle_vector(
            parts[0], parts[1], ir.Constant(ir.VectorType(number, 16), list(range(16)))
        )  # the first 16 floats
        last = b.shuffle_vector(
            parts[2], ir.Constant(_EIGHT, ir.Undefined), ir.Constant(ir.VectorType(number, 16), [*range(8), *range(8)])
        )
        for axis in range(3):
            places = ir.Constant(ir.VectorType(number, WIDTH), [axis + 3 * k for k in range(WIDTH)])
            c.store(b.shuffle_vector(pair, last, places), target, arguments[3], 64 * axis)
        return context.get_dummy_value()

    return types.none(points, types.int64, lanes, types.int64), code


@intrinsic  # type: ignore[untyped-decorator]
def store_eight(typing_context: Any, lanes: Any, at: Any, numbers: Any, first: Any) -> Any:
    """Eight lanes from lanes[at:], as they are or as whole numbers, to numbers[first:]."""

    def code(context: Any, builder: Any, signature: Any, arguments: Any) -> Any:
        c, b = _Code(context, builder), builder
        value = c.eight(c.data(signature, arguments, 0), arguments[1], 0)
        kind = context.get_data_type(signature.args[2].dtype)
        wide = ir.VectorType(kind, WIDTH)
        if signature.args[2].dtype != types.float64:
            value = b.fptosi(value, wide)
        place = b.bitcast(c.place(c.data(signature, arguments, 2), arguments[3], 0), wide.as_pointer())
        b.store(value, place, align=1)
        return context.get_dummy_value()

    return types.none(lanes, types.int64, numbers, types.int64), code


@intrinsic  # type: ignore[untyped-decorator]
def prefetch(typing_context: Any, array: Any, at: Any) -> Any:
    """Ask for the memory of an array of floats from its element `at`, counted flat."""

    def code(context: Any, builder: Any, signature: Any, arguments: Any) -> Any:
        c, number = _Code(context, builder), ir.IntType(32)
        place = builder.bitcast(c.place(c.data(signature, arguments, 0), arguments[1], 0), ir.IntType(8).as_pointer())
        kind = ir.FunctionType(ir.VoidType(), [ir.IntType(8).as_pointer(), number, number, number])
        function = cgutils.get_or_insert_function(builder.module, kind, "llvm.prefetch.p0")
        builder.call(function, [place, number(0), number(2), number(1)])
        return context.get_dummy_value()

    return types.none(array, types.int64), code


@intrinsic  # type: ignore[untyped-decorator]
def lowest_bit(typing_context: Any, bits: Any) -> Any:
    """The place of the lowest bit set; 64 if none is."""

    def code(context: Any, builder: Any, signature: Any, arguments: Any) -> Any:
        return builder.cttz(arguments[0], ir.IntType(1)(0))

    return types.int64(types.int64), code


@intrinsic  # type: ignore[untyped-decorator]
def highest_bit(typing_context: Any, bits: Any) -> Any:
    """The place of the highest bit set; -1 if none is."""

    def code(context: Any, builder: Any, signature: Any, arguments: Any) -> Any:
        return builder.sub(_INT64(63), builder.ctlz(arguments[0], ir.IntType(1)(0)))

    return types.int64(types.int64), code
