"""The rays of a list against the eight boxes of a node or the balls of a leaf, eight rays at a time."""

from __future__ import annotations

from typing import Any

from llvmlite import ir
from numba import types
from numba.core import cgutils
from numba.extending import intrinsic

from .balls import balls_missed
from .code import BITS, DOUBLE, EIGHT, INT64, WHOLE, WIDTH, Code

_UPPER, _LOWER = -(1 << 32), (1 << 32) - 1


class _Rays:
    """Eight rays that wait on a list; if fewer are left, the others repeat the first and are masked."""

    def __init__(self, c: Code, rays: Any, lists: Any, at: Any, left: Any) -> None:
        """Those from lists[at] on, of which there are `left`."""
        b, self.c = c.builder, c
        places = ir.Constant(WHOLE, list(range(WIDTH)))
        waiting = b.load(b.bitcast(c.place(lists, at, 0), WHOLE.as_pointer()), align=8)
        there = b.icmp_signed("<", places, c.whole(left))
        first = c.whole(b.load(c.place(lists, at, 0)))
        waiting = b.select(there, waiting, first)
        self.numbers = b.and_(waiting, ir.Constant(WHOLE, [_LOWER] * WIDTH))
        columns = self.columns(rays, INT64(8))
        self.origins, self.slopes = columns[:3], [b.fneg(column) for column in columns[3:6]]
        self.first, self.last = columns[6], columns[7]
        t = b.bitcast(b.and_(waiting, ir.Constant(WHOLE, [_UPPER] * WIDTH)), EIGHT)
        # Cut short, numbers come nearer to zero: what is not positive was less
        early = b.or_(b.fcmp_ordered("<=", t, c.constant(0.0)), b.fcmp_ordered("<=", t, self.last))
        self.there = b.and_(there, early)

    def columns(self, numbers: Any, size: Any) -> list[Any]:
        """The first eight numbers of these rays, of an array that holds `size` for each."""
        b, rows = self.c.builder, []
        for k in range(WIDTH):
            number = b.extract_element(self.numbers, ir.IntType(32)(k))
            rows.append(self.c.eight(numbers, b.mul(number, size), 0))
        return self.c.transposed(rows)

    def in_box(self, near: list[Any], far: list[Any]) -> tuple[Any, Any]:
        """(which rays meet a box, what they put on its list); the sides that they come to first, and the others."""
        c, b, first, last = self.c, self.c.builder, self.first, self.last
        for axis in range(3):
            s = b.fmul(b.fsub(self.origins[axis], c.spread(near[axis])), self.slopes[axis])
            t = b.fmul(b.fsub(self.origins[axis], c.spread(far[axis])), self.slopes[axis])
            first, last = c.larger(s, first), c.smaller(t, last)
        met = b.and_(self.there, c.overlapping(first, last))
        when = b.and_(b.bitcast(first, WHOLE), ir.Constant(WHOLE, [_UPPER] * WIDTH))
        return met, b.or_(when, self.numbers)


@intrinsic
def put_on_lists(
    typing_context: Any, boxes: Any, at: Any, octant: Any, rays: Any, lists: Any, begin: Any, count: Any, room: Any,
    counts: Any,
) -> Any:  # fmt: skip
    """Put the rays of a list on the lists of those of the eight boxes at boxes[at:] that they meet.

    The list has `count` rays from lists[begin], each as `waiting` reads it; that of box k begins at
    lists[room + k n], where n is `count` rounded up to eight, and gets counts[k] rays. Ray i is at rays[8 i:]: origin,
    inverse direction, first and last t. All directions are of one octant: bit k is set where coordinate k falls.
    """

    def code(context: Any, builder: Any, signature: Any, arguments: Any) -> Any:
        c, b = Code(context, builder), builder
        floats, ray, waiting, out = (c.data(signature, arguments, k) for k in (0, 3, 4, 8))
        place, octant, begin, count, room = (arguments[k] for k in (1, 2, 5, 6, 7))
        falls = [b.and_(b.lshr(octant, INT64(axis)), INT64(1)) for axis in range(3)]
        near = [b.add(place, b.add(b.mul(falls[axis], INT64(24)), INT64(8 * axis))) for axis in range(3)]
        far = [b.add(place, b.sub(INT64(24 + 8 * axis), b.mul(falls[axis], INT64(24)))) for axis in range(3)]
        groups = b.ashr(b.add(count, INT64(7)), INT64(3))
        ends = [cgutils.alloca_once_value(b, b.add(room, b.mul(groups, INT64(8 * k)))) for k in range(WIDTH)]
        with cgutils.for_range(b, groups) as loop:
            done = b.mul(loop.index, INT64(8))
            eight = _Rays(c, ray, waiting, b.add(begin, done), b.sub(count, done))
            for k in range(WIDTH):
                sides = ([c.number(floats, side, k) for side in which] for which in (near, far))
                met, entering = eight.in_box(*sides)
                end = b.load(ends[k])
                target = b.bitcast(c.place(waiting, end, 0), WHOLE.as_pointer())
                b.store(c.compressed(entering, met), target, align=8)
                met_count = b.ctpop(b.zext(b.bitcast(met, BITS), INT64))
                b.store(b.add(end, met_count), ends[k])
        for k in range(WIDTH):
            its = b.sub(b.load(ends[k]), b.add(room, b.mul(groups, INT64(8 * k))))
            b.store(b.trunc(its, ir.IntType(32)), c.place(out, INT64(0), k))
        return context.get_dummy_value()

    whole = types.int64
    return types.void(boxes, whole, whole, rays, lists, whole, whole, whole, counts), code


@intrinsic
def rays_in_balls(
    typing_context: Any, balls: Any, at: Any, size: Any, rays: Any, more: Any, lists: Any, begin: Any, left: Any,
    pairs: Any,
) -> Any:  # fmt: skip
    """Which of the first eight rays of a list may meet which of up to 16 balls (`balls_met`); returns how many.

    16 times a ray, and the ball, goes into pairs[0], pairs[1] and so on, by ball. The x of the `size` balls begin at
    balls[at], their y, z and radii `size` further each. The list has `left` rays from lists[begin]; more[8 i:]
    begins with the direction d of ray i and 1 / d·d.
    """

    def code(context: Any, builder: Any, signature: Any, arguments: Any) -> Any:
        c, b = Code(context, builder), builder
        floats, ray, other, waiting, out = (c.data(signature, arguments, k) for k in (0, 3, 4, 5, 8))
        place, size, begin, left = (arguments[k] for k in (1, 2, 6, 7))
        eight = _Rays(c, ray, waiting, begin, left)
        columns = eight.columns(other, INT64(8))
        numbers = b.shl(eight.numbers, ir.Constant(WHOLE, [4] * WIDTH))
        count = cgutils.alloca_once_value(b, INT64(0))
        with cgutils.for_range(b, size) as loop:
            x = b.add(place, loop.index)
            ball = [c.spread(c.number(floats, b.add(x, b.mul(size, INT64(k))), 0)) for k in range(4)]
            center = [b.fsub(ball[k], eight.origins[k]) for k in range(3)]
            missed = balls_missed(c, center, columns[:3], columns[3], ball[3], eight.first, eight.last)
            met = b.and_(eight.there, b.not_(missed))
            end = b.load(count)
            target = b.bitcast(c.place(out, end, 0), WHOLE.as_pointer())
            b.store(c.compressed(b.or_(numbers, c.whole(loop.index)), met), target, align=8)
            b.store(b.add(end, b.ctpop(b.zext(b.bitcast(met, BITS), INT64))), count)
        return b.load(count)

    whole = types.int64
    return types.int64(balls, whole, whole, rays, more, lists, whole, whole, pairs), code


@intrinsic
def records_in_lanes(typing_context: Any, records: Any, numbers: Any, at: Any, lanes: Any, row: Any) -> Any:
    """Eight records of eight floats, those of numbers[at:], as columns: rows of 64 lanes, from lanes[row:] on."""

    def code(context: Any, builder: Any, signature: Any, arguments: Any) -> Any:
        c, b = Code(context, builder), builder
        source, which, target = (c.data(signature, arguments, k) for k in (0, 1, 3))
        rows = []
        for k in range(WIDTH):
            rows.append(c.eight(source, b.mul(c.number(which, arguments[2], k), INT64(8)), 0))
        for k, column in enumerate(c.transposed(rows)):
            c.store(column, target, arguments[4], 64 * k)
        return context.get_dummy_value()

    return types.void(records, numbers, types.int64, lanes, types.int64), code


@intrinsic
def numbers_in_lanes(typing_context: Any, floats: Any, places: Any, at: Any, lanes: Any, row: Any) -> Any:
    """Eight floats side by side from each of eight places, those of places[at:], as columns: see `records_in_lanes`."""

    def code(context: Any, builder: Any, signature: Any, arguments: Any) -> Any:
        c = Code(context, builder)
        source, which, target = (c.data(signature, arguments, k) for k in (0, 1, 3))
        rows = [c.eight(source, c.number(which, arguments[2], k), 0) for k in range(WIDTH)]
        for k, column in enumerate(c.transposed(rows)):
            c.store(column, target, arguments[4], 64 * k)
        return context.get_dummy_value()

    return types.void(floats, places, types.int64, lanes, types.int64), code


@intrinsic
def waiting(typing_context: Any, packed: Any) -> Any:
    """(number, t) of a ray that waits to enter a box: its number, and not more than where it enters."""

    def code(context: Any, builder: Any, signature: Any, arguments: Any) -> Any:
        b = builder
        number = b.and_(arguments[0], INT64(_LOWER))
        t = b.bitcast(b.and_(arguments[0], INT64(_UPPER)), DOUBLE)
        # The lower half of the bits is missing: what is not positive was less
        t = b.select(b.fcmp_ordered("<=", t, DOUBLE(0.0)), DOUBLE(float("-inf")), t)
        return context.make_tuple(b, signature.return_type, [number, t])

    return types.Tuple((types.int64, types.float64))(types.int64), code
