"""Vectors of eight floats, spelled out where the compiler would not find them by itself.

It vectorises loops over many lanes, but unrolls a loop over the eight children of a node or the
eight rows of a packet first, and then leaves it scalar. So these three are written in LLVM's own
vectors, which it lowers to whatever the machine has. IEEE arithmetic as elsewhere.
"""

from __future__ import annotations

from typing import Any, TypeAlias

from llvmlite import ir
from numba import types
from numba.core import cgutils
from numba.extending import intrinsic

from ..geometry.tables import Floats, Ray
from ..jit import inline

Point: TypeAlias = tuple[float, float, float]
WIDTH = 8
_DOUBLE = ir.DoubleType()
_EIGHT = ir.VectorType(_DOUBLE, WIDTH)
_BITS = ir.IntType(WIDTH)
_INT64 = ir.IntType(64)
_DOUBT, _LEAST = 1e-13, 1e-290
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

    def balls(self, pointer: Any, at: Any, stride: Any) -> list[Any]:
        """x, y, z and radii of eight balls."""
        b = self.builder
        return [self.eight(pointer, b.add(at, b.mul(stride, _INT64(k))), 0) for k in range(4)]

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

    def product(self, a: Any, b: Any) -> Any:
        """The dot product of two lists of three."""
        return self.fused(a[0], b[0], self.fused(a[1], b[1], self.builder.fmul(a[2], b[2])))

    def fused(self, a: Any, b: Any, c: Any) -> Any:
        """a b + c."""
        return self._call("llvm.fma.v8f64", a, b, c)

    def root(self, a: Any) -> Any:
        return self._call("llvm.sqrt.v8f64", a)

    def _call(self, name: str, *eights: Any) -> Any:
        kind = ir.FunctionType(_EIGHT, [_EIGHT] * len(eights))
        return self.builder.call(cgutils.get_or_insert_function(self.builder.module, kind, name), eights)

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


def _beam_code(sides_of: Any, beam: int) -> Any:
    """The code of `boxes_met` for eight boxes with six `sides_of`; the beam is argument number `beam`."""

    def code(context: Any, builder: Any, signature: Any, arguments: Any) -> Any:
        c, b = _Code(context, builder), builder
        floats, rays, out = (c.data(signature, arguments, k) for k in (0, beam, beam + 2))
        sides, begin = sides_of(c, floats, arguments), arguments[beam + 1]
        first, last = c.spread(c.number(rays, begin, FIRST)), c.spread(c.number(rays, begin, LAST))
        none, all_of_it = c.constant(float("-inf")), c.constant(float("inf"))
        for axis in range(3):
            # The low corner must not lie beyond the box's high side, nor the high corner before its low side
            for corner, slope, side, upward in ((LOW_O, LOW_I, 3, True), (HIGH_O, HIGH_I, 0, False)):
                o = c.spread(c.number(rays, begin, corner + axis))
                inverse = c.number(rays, begin, slope + axis)
                t = b.fmul(b.fsub(sides[side + axis], o), c.spread(inverse))
                rises = b.fcmp_ordered(">" if upward else "<", inverse, _DOUBLE(0.0))
                last = c.smaller(b.select(rises, t, all_of_it), last)
                first = c.larger(b.select(rises, none, t), first)
        c.store(first, out, _INT64(0), 0)
        return b.zext(c.overlaps(first, last), _INT64)

    return code


@intrinsic  # type: ignore[untyped-decorator]
def boxes_met(typing_context: Any, boxes: Any, at: Any, beam: Any, start: Any, near: Any) -> Any:
    """Which of the eight boxes at boxes[at:] a beam meets, as bits; where it enters each goes into near[:8].

    The beam (beam[start:], see `BEAM`) holds all points o + t d, t in [first, last], with o and d
    between two corners each: x(t) lies between low o + t low d and high o + t high d as long as t >= 0, so
    every axis gives two linear conditions on t. A single ray is the beam whose corners are equal.
    """
    code = _beam_code(lambda c, floats, arguments: [c.eight(floats, arguments[1], 8 * k) for k in range(6)], 2)
    return types.int64(boxes, types.int64, beam, types.int64, near), code


@intrinsic  # type: ignore[untyped-decorator]
def _balls_in_beam(
    typing_context: Any, balls: Any, at: Any, stride: Any, beam: Any, start: Any, near: Any
) -> Any:  # fmt: skip
    def sides(c: _Code, floats: Any, arguments: Any) -> list[Any]:
        b, (x, y, z, r) = c.builder, c.balls(floats, arguments[1], arguments[2])
        r = b.fmul(r, c.constant(1.0 + 1e-14))
        return [b.fsub(k, r) for k in (x, y, z)] + [b.fadd(k, r) for k in (x, y, z)]

    return types.int64(balls, types.int64, types.int64, beam, types.int64, near), _beam_code(sides, 3)


@inline
def balls_in_beam(floats: Floats, at: int, stride: int, count: int, beam: Floats, start: int, near: Floats) -> int:
    """`boxes_met` for the boxes around up to eight balls, which are laid out as for `balls_met`."""
    return _balls_in_beam(floats, at, stride, beam, start, near) & ((1 << count) - 1)


@intrinsic  # type: ignore[untyped-decorator]
def boxes_met_by_ray(typing_context: Any, boxes: Any, at: Any, rays: Any, number: Any, near: Any) -> Any:
    """`boxes_met` for ray `number` of a stream, at rays[8 number:]: origin, inverse direction, first and last t.

    near[:8] get the ray's number and where it enters, as `waiting` tells them apart again.
    """

    def code(context: Any, builder: Any, signature: Any, arguments: Any) -> Any:
        c, b = _Code(context, builder), builder
        floats, ray, out = (c.data(signature, arguments, k) for k in (0, 2, 4))
        place, begin = arguments[1], b.mul(arguments[3], _INT64(8))
        first, last = c.spread(c.number(ray, begin, 6)), c.spread(c.number(ray, begin, 7))
        for axis in range(3):
            o, inverse = c.spread(c.number(ray, begin, axis)), c.spread(c.number(ray, begin, 3 + axis))
            s = b.fmul(b.fsub(c.eight(floats, place, 8 * axis), o), inverse)
            t = b.fmul(b.fsub(c.eight(floats, place, 24 + 8 * axis), o), inverse)
            first, last = c.larger(c.smaller(s, t), first), c.smaller(c.larger(s, t), last)
        # A little less, as a short float
        less = b.fsub(first, b.fadd(b.fmul(c.size(first), c.constant(1.2e-7)), c.constant(1e-37)))
        less = b.fptrunc(c.smaller(less, c.constant(3e38)), ir.VectorType(ir.FloatType(), WIDTH))
        wide = ir.VectorType(_INT64, WIDTH)
        bits = b.shl(
            b.zext(b.bitcast(less, ir.VectorType(ir.IntType(32), WIDTH)), wide), ir.Constant(wide, [32] * WIDTH)
        )
        same = b.insert_element(ir.Constant(wide, ir.Undefined), arguments[3], ir.IntType(32)(0))
        zeros = ir.Constant(ir.VectorType(ir.IntType(32), WIDTH), [0] * WIDTH)
        packed = b.or_(bits, b.shuffle_vector(same, ir.Constant(wide, ir.Undefined), zeros))
        b.store(packed, b.bitcast(out, wide.as_pointer()), align=8)
        return b.zext(c.overlaps(first, last), _INT64)

    return types.int64(boxes, types.int64, rays, types.int64, near), code


@intrinsic  # type: ignore[untyped-decorator]
def waiting(typing_context: Any, packed: Any) -> Any:
    """(number, t) of a ray that waits to enter a box: its number, and not more than where it enters."""

    def code(context: Any, builder: Any, signature: Any, arguments: Any) -> Any:
        b, short = builder, ir.IntType(32)
        number = b.and_(arguments[0], _INT64(0xFFFFFFFF))
        t = b.bitcast(b.trunc(b.lshr(arguments[0], _INT64(32)), short), ir.FloatType())
        return context.make_tuple(b, signature.return_type, [number, b.fpext(t, _DOUBLE)])

    return types.Tuple((types.int64, types.float64))(types.int64), code


FROM_THE_START = -(1 << 55)
"""Added to a ray's number: it waits from t = -inf on (0xff800000 in the upper half)."""


@intrinsic  # type: ignore[untyped-decorator]
def _balls_met(
    typing_context: Any, floats: Any, at: Any, stride: Any,
    ox: Any, oy: Any, oz: Any, dx: Any, dy: Any, dz: Any, inverse: Any, first: Any, last: Any,
) -> Any:  # fmt: skip
    def code(context: Any, builder: Any, signature: Any, arguments: Any) -> Any:
        c, b = _Code(context, builder), builder
        balls = c.data(signature, arguments, 0)
        origin, direction = arguments[3:6], [c.spread(d) for d in arguments[6:9]]
        rows = c.balls(balls, arguments[1], arguments[2])
        center = [b.fsub(rows[k], c.spread(origin[k])) for k in range(3)]
        per_square, squared = c.spread(arguments[9]), b.fmul(rows[3], rows[3])
        foot = b.fmul(c.product(center, direction), per_square)
        off = [c.fused(b.fneg(foot), direction[k], center[k]) for k in range(3)]
        slack = c.fused(b.fadd(c.product(center, center), squared), c.constant(_DOUBT), c.constant(_LEAST))
        inside = b.fadd(b.fsub(squared, c.product(off, off)), slack)
        half = c.root(b.fmul(inside, per_square))
        # What is not a number counts as met
        missed = b.fcmp_ordered("<", inside, c.constant(0.0))
        missed = b.or_(missed, b.fcmp_ordered(">", b.fsub(foot, half), c.spread(arguments[11])))
        missed = b.or_(missed, b.fcmp_ordered("<", b.fadd(foot, half), c.spread(arguments[10])))
        return b.zext(b.not_(b.bitcast(missed, _BITS)), _INT64)

    number = types.float64
    return types.int64(floats, types.int64, types.int64, *[number] * 9), code


@inline
def balls_met(floats: Floats, at: int, stride: int, count: int, ray: Ray, inverse: float, last: float) -> int:
    """Which of up to eight balls a ray may meet between its t_min and `last`, as bits; `inverse` is 1 / d·d.

    The balls' x begin at floats[at], their y, z and radii `stride` further each. A ball is left out only if
    the ray misses it for certain: the square of the half chord is raised by more than all
    roundings can take away from it, 1e-13 of the squares of distance and radius, which moves both ends
    by more than what rounding does to them too.
    """
    ox, oy, oz, dx, dy, dz, t_min, _, _ = ray
    return _balls_met(floats, at, stride, ox, oy, oz, dx, dy, dz, inverse, t_min, last) & ((1 << count) - 1)


def _lanes_in_box(groups: int) -> Any:
    def in_box(typing_context: Any, lanes: Any, lx: Any, ly: Any, lz: Any, hx: Any, hy: Any, hz: Any) -> Any:
        def code(context: Any, builder: Any, signature: Any, arguments: Any) -> Any:
            c, b = _Code(context, builder), builder
            rays, sides = c.data(signature, arguments, 0), [c.spread(side) for side in arguments[1:]]
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

        return types.int64(lanes, *[types.float64] * 6), code

    return intrinsic(in_box)


_in_box_64, _in_box_16 = _lanes_in_box(8), _lanes_in_box(2)


@inline
def lanes_in_box(lanes: Floats, low: Point, high: Point, groups: int) -> int:
    """Which lanes of a packet of two or eight groups of eight meet a box, as bits.

    The block of lanes begins with rows of 64: origins, inverse directions, t_min, t_max, nearest hits.
    """
    if groups == 8:
        return _in_box_64(lanes, low[0], low[1], low[2], high[0], high[1], high[2])
    return _in_box_16(lanes, low[0], low[1], low[2], high[0], high[1], high[2])


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
