"""Culling tests as vector intrinsics: boxes and balls against beams, rays, lanes of packets, tile items and ray lists.

Boxes of a node and balls of a leaf are tested eight at a time. Results are bit masks, or compressed lists of the items
that pass. All tests are conservative (culling_constants.py).

User: every query that walks a tree. In the loop that LLVM leaves scalar a box takes 115 instructions, here 41.
"""

from __future__ import annotations

from typing import Any

from llvmlite import ir
from numba import types
from numba.core import cgutils
from numba.extending import intrinsic

from ..._jit.decorators import inline
from ..ray import Ray, start_margin
from ..tables import Floats
from . import culling_constants
from .culling_constants import FIRST, HIGH_I, HIGH_O, ITEM_ROW, ITEMS_SIZE, LAST, LOW_I, LOW_O
from .vector_code import BITS, DOUBLE, EIGHT, INT64, MASK, WHOLE, WIDTH, Code


def beam_stretch(c: Code, sides: Any, number: Any, first: Any, last: Any) -> tuple[Any, Any]:
    """Emit the box test of beams: cut [first, last] to the t that may lie within six sides, for eight boxes or beams.

    number(k) is number k of a beam (`BEAM`), as an eight and, for the comparison of its sign, unchanged.
    """
    b = c.builder
    none, all_of_it = c.constant(float("-inf")), c.constant(float("inf"))
    for axis in range(3):
        # The low corner must not lie beyond the box's high side, nor the high corner before its low side
        for corner, slope, side, upward in ((LOW_O, LOW_I, 3, True), (HIGH_O, HIGH_I, 0, False)):
            o, (inverse, plain) = number(corner + axis)[0], number(slope + axis)
            t = b.fmul(b.fsub(sides[side + axis], o), inverse)
            zero = ir.Constant(plain.type, [0.0] * WIDTH if plain.type == EIGHT else 0.0)
            rises = b.fcmp_ordered(">" if upward else "<", plain, zero)
            last = c.smaller(b.select(rises, t, all_of_it), last)
            first = c.larger(b.select(rises, none, t), first)
    return first, last


def stretches(c: Code, sides: Any, rays: Any, begin: Any) -> tuple[Any, Any]:
    """Emit (first, last) t of a beam, rays[begin:], in eight boxes with six sides."""

    def number(k: int) -> tuple[Any, Any]:
        plain = c.number(rays, begin, k)
        return c.spread(plain), plain

    return beam_stretch(c, sides, number, number(FIRST)[0], number(LAST)[0])


def beam_code(sides_of: Any, beam: int, tells_where: bool) -> Any:
    """Return the code of `hit_boxes` for eight boxes whose six sides `sides_of` emits; the beam is argument `beam`.

    With `tells_where` it stores the t of entry in its last argument; without, it has no such argument.
    """

    def code(context: Any, builder: Any, signature: Any, arguments: Any) -> Any:
        c, b = Code(context, builder), builder
        floats, rays = (c.data(signature, arguments, k) for k in (0, beam))
        first, last = stretches(c, sides_of(c, floats, arguments), rays, arguments[beam + 1])
        if tells_where:
            c.store(first, c.data(signature, arguments, beam + 2), INT64(0), 0)
        return b.zext(c.overlaps(first, last), INT64)

    return code


@intrinsic
def hit_boxes(typing_context: Any, boxes: Any, at: Any, beam: Any, start: Any, near: Any) -> Any:
    """Return which of the eight boxes at boxes[at:] a beam meets, as bits; the t of entry goes into near[:8].

    The beam (beam[start:], see `BEAM`) holds all points o + t d, t in [first, last], with o and d between two corners
    each: x(t) lies between low o + t low d and high o + t high d as long as t >= 0 (or the corners of d are equal), so
    every axis gives two linear conditions on t. A single ray is a beam whose corners are equal.
    """
    code = beam_code(lambda c, floats, arguments: [c.eight(floats, arguments[1], 8 * k) for k in range(6)], 2, True)
    return types.int64(boxes, types.int64, beam, types.int64, near), code


def _stretch_of_lanes(c: Code, rays: Any, sides: list[Any], begin: Any) -> tuple[Any, Any]:
    """Emit (first, last) t in a box of the eight lanes from `begin` on, within intervals and before nearest hits."""
    b, rows = c.builder, [c.eight(rays, begin, 64 * k) for k in range(9)]
    first, last = rows[6], c.smaller(rows[7], rows[8])
    for axis in range(3):
        s = b.fmul(b.fsub(sides[axis], rows[axis]), rows[3 + axis])
        t = b.fmul(b.fsub(sides[3 + axis], rows[axis]), rows[3 + axis])
        first, last = c.larger(c.smaller(s, t), first), c.smaller(c.larger(s, t), last)
    return first, last


@intrinsic
def lanes_in_box(typing_context: Any, lanes: Any, lx: Any, ly: Any, lz: Any, hx: Any, hy: Any, hz: Any) -> Any:
    """Return which lanes of a packet meet a box (low, high), as bits.

    The block of lanes begins with rows of 64: origins, inverse directions, t_min, t_max, nearest hits.
    """

    def code(context: Any, builder: Any, signature: Any, arguments: Any) -> Any:
        c, b = Code(context, builder), builder
        # No beam: every lane tests with its own corners, in eights
        rays, sides = c.data(signature, arguments, 0), [c.spread(side) for side in arguments[1:]]
        hits: Any = INT64(0)
        for group in range(8):
            bits = b.zext(c.overlaps(*_stretch_of_lanes(c, rays, sides, INT64(8 * group))), INT64)
            hits = b.or_(hits, b.shl(bits, INT64(8 * group)))
        return hits

    return types.int64(lanes, *[types.float64] * 6), code


# Balls against a beam, a ray or lanes


def sides_of_balls(c: Code, floats: Any, at: Any, stride: Any) -> list[Any]:
    """Emit the six sides of the boxes around eight balls, widened as all boxes are (`ORIGIN_SLACK`)."""
    b, (x, y, z, r) = c.builder, c.balls(floats, at, stride)
    place = b.fadd(b.fadd(c.size(x), c.size(y)), c.size(z))
    r = c.fused(place, c.constant(culling_constants.ORIGIN_SLACK), r)
    # Rounded outwards, because center and radius are added in floats
    r = b.fmul(r, c.constant(1.0 + culling_constants.BALL_BOX))
    return [b.fsub(k, r) for k in (x, y, z)] + [b.fadd(k, r) for k in (x, y, z)]


@intrinsic
def _balls_in_beam(typing_context: Any, balls: Any, at: Any, stride: Any, beam: Any, start: Any, near: Any) -> Any:
    def sides(c: Code, floats: Any, arguments: Any) -> list[Any]:
        return sides_of_balls(c, floats, arguments[1], arguments[2])

    return types.int64(balls, types.int64, types.int64, beam, types.int64, near), beam_code(sides, 3, True)


@inline
def balls_in_beam(floats: Floats, at: int, stride: int, count: int, beam: Floats, start: int, near: Floats) -> int:
    """`hit_boxes` for the boxes around up to eight balls, with the layout of `hit_balls`."""
    return _balls_in_beam(floats, at, stride, beam, start, near) & ((1 << count) - 1)


def _depth(c: Code, center: list[Any], direction: list[Any], foot: Any, squared: Any) -> Any:
    """Emit the depth of the foot of the perpendicular in balls, r² - |center - foot d|², raised by its slack."""
    b = c.builder
    # One rounding a component: a ball far along the ray has a small distance from it, and large terms
    off = [c.fused(b.fneg(foot), direction[k], center[k]) for k in range(3)]
    raised = c.fused(
        b.fadd(c.product(center, center), squared),
        c.constant(culling_constants.BALL_SLACK),
        c.constant(culling_constants.BALL_LEAST),
    )
    return b.fadd(b.fsub(squared, c.product(off, off)), raised)


def missed_balls(
    c: Code, center: list[Any], direction: list[Any], per_square: Any, radius: Any, first: Any, last: Any
) -> Any:
    """Emit which of eight balls their rays certainly miss; `center` is relative to the ray's origin (`hit_balls`)."""
    b, squared = c.builder, c.builder.fmul(radius, radius)
    foot = b.fmul(c.product(center, direction), per_square)
    inside = _depth(c, center, direction, foot, squared)
    # NaN for a depth below 0, where the first test has decided already
    half = c.root(b.fmul(inside, per_square))
    # NaN counts as a hit
    missed = b.fcmp_ordered("<", inside, c.constant(0.0))
    missed = b.or_(missed, b.fcmp_ordered(">", b.fsub(foot, half), last))
    return b.or_(missed, b.fcmp_ordered("<", b.fadd(foot, half), first))


@intrinsic
def _hit_balls(
    typing_context: Any, floats: Any, at: Any, stride: Any,
    ox: Any, oy: Any, oz: Any, dx: Any, dy: Any, dz: Any, inverse: Any, first: Any, last: Any, margin: Any,
) -> Any:  # fmt: skip
    def code(context: Any, builder: Any, signature: Any, arguments: Any) -> Any:
        c, b = Code(context, builder), builder
        balls = c.data(signature, arguments, 0)
        origin, direction = arguments[3:6], [c.spread(d) for d in arguments[6:9]]
        rows = c.balls(balls, arguments[1], arguments[2])
        center = [b.fsub(rows[k], c.spread(origin[k])) for k in range(3)]
        inverse, first, last, margin = (c.spread(number) for number in arguments[9:])
        missed = missed_balls(c, center, direction, inverse, b.fadd(rows[3], margin), first, last)
        return b.zext(b.not_(b.bitcast(missed, BITS)), INT64)

    number = types.float64
    return types.int64(floats, types.int64, types.int64, *[number] * 10), code


@inline
def hit_balls(floats: Floats, at: int, stride: int, count: int, ray: Ray, inverse: float, last: float) -> int:
    """Return which of up to eight balls a ray may meet between its t_min and `last`, as bits; `inverse` is 1 / d·d.

    The balls' x begin at floats[at], their y, z and radii `stride` further each. A ball is left out only if the ray
    certainly misses it (`BALL_SLACK`).
    """
    ox, oy, oz, dx, dy, dz, t_min, _, start = ray
    margin = start_margin(float(start), ox, oy, oz)
    return _hit_balls(floats, at, stride, ox, oy, oz, dx, dy, dz, inverse, t_min, last, margin) & ((1 << count) - 1)


def _lanes_in_ball(groups: int) -> Any:
    def in_ball(typing_context: Any, lanes: Any, at: Any, x: Any, y: Any, z: Any, r: Any) -> Any:
        def code(context: Any, builder: Any, signature: Any, arguments: Any) -> Any:
            c, b = Code(context, builder), builder
            rays, ball = c.data(signature, arguments, 0), [c.spread(number) for number in arguments[2:]]
            squared, hits = b.fmul(ball[3], ball[3]), INT64(0)
            for group in range(groups):
                # Origin, direction; 1 / d·d and 1 / |d| or more; the interval
                rows = (0, 1, 2, 9, 10, 11, 12, 13, 6, 7, 8)
                row = [c.eight(rays, arguments[1], 64 * k + 8 * group) for k in rows]
                center, direction = [b.fsub(ball[k], row[k]) for k in range(3)], row[3:6]
                foot = b.fmul(c.product(center, direction), row[6])
                apart = b.fadd(b.fadd(c.size(center[0]), c.size(center[1])), c.size(center[2]))
                reach = b.fmul(c.fused(apart, c.constant(culling_constants.BALL_SLACK), ball[3]), row[7])
                first, last = b.fsub(foot, reach), b.fadd(foot, reach)
                # NaN counts as a hit
                missed = b.fcmp_ordered("<", _depth(c, center, direction, foot, squared), c.constant(0.0))
                missed = b.or_(missed, b.fcmp_ordered(">", first, c.smaller(row[9], row[10])))
                missed = b.or_(missed, b.fcmp_ordered("<", last, row[8]))
                bits = b.zext(b.not_(b.bitcast(missed, BITS)), INT64)
                hits = b.or_(hits, b.shl(bits, INT64(8 * group)))
            return hits

        return types.int64(lanes, types.int64, *[types.float64] * 4), code

    return intrinsic(in_ball)


_in_ball_64, _in_ball_8 = _lanes_in_ball(8), _lanes_in_ball(1)


@intrinsic
def lanes_in_ball_from_one(typing_context: Any, lanes: Any, x: Any, y: Any, z: Any, r: Any) -> Any:
    """`lanes_in_ball` for lanes that share an origin: a third of the work.

    The depth of the foot of the perpendicular in the ball, r² - |c|² + (c·d)² / d·d with the center c relative to the
    origin, loses some 3e-15 of |c|² + r² to rounding, so the same slack is enough.
    """

    def code(context: Any, builder: Any, signature: Any, arguments: Any) -> Any:
        c, b = Code(context, builder), builder
        rays, radius = c.data(signature, arguments, 0), c.spread(arguments[4])
        center = [b.fsub(c.spread(arguments[1 + k]), c.spread(c.number(rays, INT64(0), 64 * k))) for k in range(3)]
        squared, far = b.fmul(radius, radius), c.product(center, center)
        raised = c.fused(
            b.fadd(far, squared), c.constant(culling_constants.BALL_SLACK), c.constant(culling_constants.BALL_LEAST)
        )
        base = b.fadd(b.fsub(squared, far), raised)
        apart = b.fadd(b.fadd(c.size(center[0]), c.size(center[1])), c.size(center[2]))
        wide, hits = c.fused(apart, c.constant(culling_constants.BALL_SLACK), radius), INT64(0)
        for group in range(8):
            # Direction; 1 / d·d and 1 / |d| or more; the interval
            row = [c.eight(rays, INT64(0), 64 * k + 8 * group) for k in (9, 10, 11, 12, 13, 6, 7, 8)]
            along = c.product(center, row[:3])
            foot, reach = b.fmul(along, row[3]), b.fmul(wide, row[4])
            # NaN counts as a hit
            missed = b.fcmp_ordered("<", c.fused(foot, along, base), c.constant(0.0))
            missed = b.or_(missed, b.fcmp_ordered(">", b.fsub(foot, reach), c.smaller(row[6], row[7])))
            missed = b.or_(missed, b.fcmp_ordered("<", b.fadd(foot, reach), row[5]))
            bits = b.zext(b.not_(b.bitcast(missed, BITS)), INT64)
            hits = b.or_(hits, b.shl(bits, INT64(8 * group)))
        return hits

    return types.int64(lanes, *[types.float64] * 4), code


@inline
def lanes_in_ball(lanes: Floats, x: float, y: float, z: float, r: float) -> int:
    """Return which lanes of a packet may meet a ball, as bits; see `hit_balls`.

    It bounds the t of entry without a square root: within radius / |d| of the foot of the perpendicular.
    """
    return _in_ball_64(lanes, 0, x, y, z, r)


@inline
def group_in_ball(lanes: Floats, group: int, x: float, y: float, z: float, r: float) -> int:
    """`lanes_in_ball` for one group of eight."""
    return _in_ball_8(lanes, 8 * group, x, y, z, r)


# Items of a tile's frontier: rows of their boxes, tested eight at a time


@intrinsic
def hit_items(typing_context: Any, items: Any, at: Any, beam: Any, start: Any) -> Any:
    """Return which of eight items, from number `at` on, have boxes that a beam meets (`hit_boxes`), as bits."""

    def sides(c: Code, floats: Any, arguments: Any) -> list[Any]:
        return [c.eight(floats, arguments[1], k * ITEM_ROW) for k in range(6)]

    return types.int64(items, types.int64, beam, types.int64), beam_code(sides, 2, False)


@intrinsic
def keep_items(typing_context: Any, items: Any, at: Any, bits: Any, kept: Any, end: Any) -> Any:
    """Copy those of eight items, from number `at` on, that a mask selects to `kept`, from number `end` on."""

    def code(context: Any, builder: Any, signature: Any, arguments: Any) -> Any:
        c = Code(context, builder)
        source, target = c.data(signature, arguments, 0), c.data(signature, arguments, 3)
        wanted = builder.bitcast(builder.trunc(arguments[2], BITS), MASK)
        for row in range(0, ITEMS_SIZE, ITEM_ROW):
            c.store(c.compressed(c.eight(source, arguments[1], row), wanted), target, arguments[4], row)
        return context.get_dummy_value()

    whole = types.int64
    return types.void(items, whole, whole, kept, whole), code


@intrinsic
def put_children(
    typing_context: Any, boxes: Any, at: Any, codes: Any, first: Any, number: Any, beam: Any, start: Any,
    found: Any, t: Any, end: Any,
) -> Any:  # fmt: skip
    """Append the children of a node that a beam meets to found[:end], and their t of entry to t[:end]; return how many.

    The boxes are at boxes[at:], the codes of their content at codes[first:], 0 for nothing. An element of `found` is a
    code, with the number of its box in the upper half; `number` is that of the first box.
    """

    def code(context: Any, builder: Any, signature: Any, arguments: Any) -> Any:
        c, b = Code(context, builder), builder
        floats, numbers, rays, out, times = (c.data(signature, arguments, k) for k in (0, 2, 5, 7, 8))
        enters, leaves = stretches(c, [c.eight(floats, arguments[1], 8 * k) for k in range(6)], rays, arguments[6])
        kind = ir.VectorType(ir.IntType(32), WIDTH)
        child = b.zext(b.load(b.bitcast(c.place(numbers, arguments[3], 0), kind.as_pointer()), align=4), WHOLE)
        hits = b.and_(c.overlapping(enters, leaves), b.icmp_unsigned("!=", child, ir.Constant(WHOLE, [0] * WIDTH)))
        box = b.add(c.whole(arguments[4]), ir.Constant(WHOLE, list(range(WIDTH))))
        item = b.or_(child, b.shl(box, ir.Constant(WHOLE, [32] * WIDTH)))
        place = b.bitcast(c.place(out, arguments[9], 0), WHOLE.as_pointer())
        b.store(c.compressed(item, hits), place, align=8)
        c.store(c.compressed(enters, hits), times, arguments[9], 0)
        return b.ctpop(b.zext(b.bitcast(hits, BITS), INT64))

    whole = types.int64
    return types.int64(boxes, whole, codes, whole, whole, beam, whole, found, t, whole), code


@intrinsic
def put_balls(
    typing_context: Any, balls: Any, at: Any, count: Any, leaf: Any, beam: Any, start: Any, items: Any, end: Any
) -> Any:
    """Write those of the `count` balls of a leaf that a beam meets as items from number `end` on; return how many.

    The balls have the layout of `hit_balls`; `leaf` is the code of the leaf.
    """

    def code(context: Any, builder: Any, signature: Any, arguments: Any) -> Any:
        c, b = Code(context, builder), builder
        floats, rays, target = (c.data(signature, arguments, k) for k in (0, 4, 6))
        sides = sides_of_balls(c, floats, arguments[1], arguments[2])
        enters, leaves = stretches(c, sides, rays, arguments[5])
        places = ir.Constant(WHOLE, list(range(WIDTH)))
        hits = b.and_(c.overlapping(enters, leaves), b.icmp_signed("<", places, c.whole(arguments[2])))
        box = ir.Constant(EIGHT, [float(-2 - k) for k in range(WIDTH)])
        rows = [*sides, enters, c.spread(b.sitofp(arguments[3], DOUBLE)), box]
        for row, value in enumerate(rows):
            c.store(c.compressed(value, hits), target, arguments[7], row * ITEM_ROW)
        return b.ctpop(b.zext(b.bitcast(hits, BITS), INT64))

    whole = types.int64
    return types.int64(balls, whole, whole, whole, beam, whole, items, whole), code


@intrinsic
def put_numbers(typing_context: Any, first: Any, bits: Any, numbers: Any, end: Any) -> Any:
    """Append those of the numbers first..first + 7 that a mask selects to numbers[:end]."""

    def code(context: Any, builder: Any, signature: Any, arguments: Any) -> Any:
        c, b = Code(context, builder), builder
        value = b.add(c.whole(arguments[0]), ir.Constant(WHOLE, list(range(WIDTH))))
        wanted = b.bitcast(b.trunc(arguments[1], BITS), MASK)
        place = b.bitcast(c.place(c.data(signature, arguments, 2), arguments[3], 0), WHOLE.as_pointer())
        b.store(c.compressed(value, wanted), place, align=8)
        return context.get_dummy_value()

    whole = types.int64
    return types.void(whole, whole, numbers, whole), code


@intrinsic
def put_groups(
    typing_context: Any, items: Any, item: Any, number: Any, lanes: Any, beams: Any, pairs: Any, end: Any
) -> Any:
    """Append a pair to pairs[:end] for each of eight groups of lanes whose beam meets an item's box; return how many.

    A pair is 8 number + group. The beams are at lanes[beams:] (`put_group_beams`).
    """

    def code(context: Any, builder: Any, signature: Any, arguments: Any) -> Any:
        c, b = Code(context, builder), builder
        boxes, rays, out = (c.data(signature, arguments, k) for k in (0, 3, 5))
        sides = [c.spread(c.number(boxes, arguments[1], k * ITEM_ROW)) for k in range(6)]

        def number(k: int) -> tuple[Any, Any]:
            eight = c.eight(rays, arguments[4], 8 * k)
            return eight, eight

        hits = c.overlapping(*beam_stretch(c, sides, number, number(FIRST)[0], number(LAST)[0]))
        pair = b.add(c.whole(b.shl(arguments[2], INT64(3))), ir.Constant(WHOLE, list(range(WIDTH))))
        place = b.bitcast(c.place(out, arguments[6], 0), WHOLE.as_pointer())
        b.store(c.compressed(pair, hits), place, align=8)
        return b.ctpop(b.zext(b.bitcast(hits, BITS), INT64))

    whole = types.int64
    return types.int64(items, whole, whole, lanes, whole, pairs, whole), code


# Lists of rays against the eight boxes of a node or the balls of a leaf, eight rays at a time
#
# An element of a list is an integer of 64 bits: the upper half of the float t at which the ray enters, and the ray's
# number in the lower half.

_UPPER, _LOWER = -(1 << 32), (1 << 32) - 1


class _Rays:
    """Eight rays of a list; if fewer are left, the others repeat the first and are masked."""

    def __init__(self, c: Code, rays: Any, lists: Any, at: Any, left: Any) -> None:
        """Load the rays from lists[at] on; `left` of them are on the list."""
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
        # Without its lower bits t is nearer to zero: where it is not positive, the exact t may be less
        early = b.or_(b.fcmp_ordered("<=", t, c.constant(0.0)), b.fcmp_ordered("<=", t, self.last))
        self.there = b.and_(there, early)

    def columns(self, numbers: Any, size: Any) -> list[Any]:
        """Emit the first eight numbers of these rays, as columns, from an array that holds `size` numbers for each."""
        b, rows = self.c.builder, []
        for k in range(WIDTH):
            number = b.extract_element(self.numbers, ir.IntType(32)(k))
            rows.append(self.c.eight(numbers, b.mul(number, size), 0))
        return self.c.transposed(rows)

    def in_box(self, near: list[Any], far: list[Any]) -> tuple[Any, Any]:
        """Emit (which rays meet a box, their elements for its list); `near` are the sides that they reach first."""
        c, b, first, last = self.c, self.c.builder, self.first, self.last
        for axis in range(3):
            s = b.fmul(b.fsub(self.origins[axis], c.spread(near[axis])), self.slopes[axis])
            t = b.fmul(b.fsub(self.origins[axis], c.spread(far[axis])), self.slopes[axis])
            first, last = c.larger(s, first), c.smaller(t, last)
        hits = b.and_(self.there, c.overlapping(first, last))
        when = b.and_(b.bitcast(first, WHOLE), ir.Constant(WHOLE, [_UPPER] * WIDTH))
        return hits, b.or_(when, self.numbers)


@intrinsic
def put_on_lists(
    typing_context: Any, boxes: Any, at: Any, octant: Any, rays: Any, lists: Any, begin: Any, count: Any, room: Any,
    counts: Any,
) -> Any:  # fmt: skip
    """Write the rays of a list to the lists of those of the eight boxes at boxes[at:] that they meet.

    The list has `count` rays from lists[begin] on, each as `waiting_ray` reads it. The list of box k begins at
    lists[room + k n], where n is `count` rounded up to eight, and gets counts[k] rays. Ray i is at rays[8 i:]: origin,
    inverse direction, first and last t. All directions are of one octant: bit k is set where coordinate k falls.
    """

    def code(context: Any, builder: Any, signature: Any, arguments: Any) -> Any:
        c, b = Code(context, builder), builder
        floats, ray, waiting, out = (c.data(signature, arguments, k) for k in (0, 3, 4, 8))
        place, octant, begin, count, room = (arguments[k] for k in (1, 2, 5, 6, 7))
        # By octant, the sides that rays reach first: the low ones (rows 0 to 2) or the high ones (rows 3 to 5)
        falls = [b.and_(b.lshr(octant, INT64(axis)), INT64(1)) for axis in range(3)]
        near = [b.add(place, b.add(b.mul(falls[axis], INT64(24)), INT64(8 * axis))) for axis in range(3)]
        far = [b.add(place, b.sub(INT64(24 + 8 * axis), b.mul(falls[axis], INT64(24)))) for axis in range(3)]
        # Each box has room for all rays, as `compressed` stores eight at a time
        groups = b.ashr(b.add(count, INT64(7)), INT64(3))
        ends = [cgutils.alloca_once_value(b, b.add(room, b.mul(groups, INT64(8 * k)))) for k in range(WIDTH)]
        with cgutils.for_range(b, groups) as loop:
            done = b.mul(loop.index, INT64(8))
            eight = _Rays(c, ray, waiting, b.add(begin, done), b.sub(count, done))
            for k in range(WIDTH):
                sides = ([c.number(floats, side, k) for side in which] for which in (near, far))
                hits, entering = eight.in_box(*sides)
                end = b.load(ends[k])
                target = b.bitcast(c.place(waiting, end, 0), WHOLE.as_pointer())
                b.store(c.compressed(entering, hits), target, align=8)
                hit_count = b.ctpop(b.zext(b.bitcast(hits, BITS), INT64))
                b.store(b.add(end, hit_count), ends[k])
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
    """Find which of the first eight rays of a list may meet which of up to 16 balls (`hit_balls`); return how many.

    16 ray + ball goes into pairs[0], pairs[1] and so on, ball after ball. The x of the `size` balls begin at balls[at],
    their y, z and radii `size` further each. The list has `left` rays from lists[begin] on; more[8 i:] begins with the
    direction d of ray i, 1 / d·d and the surface on which it starts.
    """

    def code(context: Any, builder: Any, signature: Any, arguments: Any) -> Any:
        c, b = Code(context, builder), builder
        floats, ray, other, waiting, out = (c.data(signature, arguments, k) for k in (0, 3, 4, 5, 8))
        place, size, begin, left = (arguments[k] for k in (1, 2, 6, 7))
        eight = _Rays(c, ray, waiting, begin, left)
        columns = eight.columns(other, INT64(8))
        numbers = b.shl(eight.numbers, ir.Constant(WHOLE, [4] * WIDTH))
        sizes = [c.size(origin) for origin in eight.origins]
        margin = b.fmul(b.fadd(b.fadd(sizes[0], sizes[1]), sizes[2]), c.constant(culling_constants.ORIGIN_SLACK))
        margin = b.select(b.fcmp_ordered(">=", columns[4], c.constant(0.0)), margin, c.constant(0.0))  # `start_margin`
        count = cgutils.alloca_once_value(b, INT64(0))
        with cgutils.for_range(b, size) as loop:
            x = b.add(place, loop.index)
            ball = [c.spread(c.number(floats, b.add(x, b.mul(size, INT64(k))), 0)) for k in range(4)]
            center = [b.fsub(ball[k], eight.origins[k]) for k in range(3)]
            radius = b.fadd(ball[3], margin)
            missed = missed_balls(c, center, columns[:3], columns[3], radius, eight.first, eight.last)
            hits = b.and_(eight.there, b.not_(missed))
            end = b.load(count)
            target = b.bitcast(c.place(out, end, 0), WHOLE.as_pointer())
            b.store(c.compressed(b.or_(numbers, c.whole(loop.index)), hits), target, align=8)
            b.store(b.add(end, b.ctpop(b.zext(b.bitcast(hits, BITS), INT64))), count)
        return b.load(count)

    whole = types.int64
    return types.int64(balls, whole, whole, rays, more, lists, whole, whole, pairs), code


@intrinsic
def records_in_lanes(typing_context: Any, records: Any, numbers: Any, at: Any, lanes: Any, row: Any) -> Any:
    """Write eight records of eight floats, those of numbers[at:], as columns: rows of 64 lanes from lanes[row:] on."""

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
    """Write eight consecutive floats from each of eight places, those of places[at:], as in `records_in_lanes`."""

    def code(context: Any, builder: Any, signature: Any, arguments: Any) -> Any:
        c = Code(context, builder)
        source, which, target = (c.data(signature, arguments, k) for k in (0, 1, 3))
        rows = [c.eight(source, c.number(which, arguments[2], k), 0) for k in range(WIDTH)]
        for k, column in enumerate(c.transposed(rows)):
            c.store(column, target, arguments[4], 64 * k)
        return context.get_dummy_value()

    return types.void(floats, places, types.int64, lanes, types.int64), code


@intrinsic
def waiting_ray(typing_context: Any, packed: Any) -> Any:
    """Return (number, t) of an element of a list: a ray's number, and a lower bound of the t at which it enters."""

    def code(context: Any, builder: Any, signature: Any, arguments: Any) -> Any:
        b = builder
        number = b.and_(arguments[0], INT64(_LOWER))
        t = b.bitcast(b.and_(arguments[0], INT64(_UPPER)), DOUBLE)
        # The lower half of the bits is missing: where t is not positive, the exact t may be less
        t = b.select(b.fcmp_ordered("<=", t, DOUBLE(0.0)), DOUBLE(float("-inf")), t)
        return context.make_tuple(b, signature.return_type, [number, t])

    return types.Tuple((types.int64, types.float64))(types.int64), code
