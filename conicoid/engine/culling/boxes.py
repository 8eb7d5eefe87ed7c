"""Eight boxes against a beam or a ray, a box against the lanes of a packet."""

from __future__ import annotations

from typing import Any

from llvmlite import ir
from numba import types
from numba.extending import intrinsic

from . import slack
from .code import BITS, EIGHT, INT64, WIDTH, Code
from .layout import FIRST, HIGH_I, HIGH_O, ITEM_ROW, LAST, LOW_I, LOW_O


def beam_stretch(c: Code, sides: Any, number: Any, first: Any, last: Any) -> tuple[Any, Any]:
    """The box test of beams: [first, last] cut to what may lie within six sides; what is compared are eights.

    number(k) is number k of a beam (`BEAM`), as an eight and, for the comparison of its sign, as it is.
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
    """(first, last) t of a beam, rays[begin:], in eight boxes with six sides."""

    def number(k: int) -> tuple[Any, Any]:
        plain = c.number(rays, begin, k)
        return c.spread(plain), plain

    return beam_stretch(c, sides, number, number(FIRST)[0], number(LAST)[0])


def beam_code(sides_of: Any, beam: int, tells_where: bool) -> Any:
    """The code of `boxes_met` for eight boxes with six `sides_of`; the beam is argument number `beam`.

    Without `tells_where` it does not store where they are entered, and has no last argument.
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
def boxes_met(typing_context: Any, boxes: Any, at: Any, beam: Any, start: Any, near: Any) -> Any:
    """Which of the eight boxes at boxes[at:] a beam meets, as bits; where it enters each goes into near[:8].

    The beam (beam[start:], see `BEAM`) holds all points o + t d, t in [first, last], with o and d
    between two corners each: x(t) lies between low o + t low d and high o + t high d as long as t >= 0 (or the
    corners of d are equal), so every axis gives two linear conditions on t. A single ray is the beam whose
    corners are equal.
    """
    code = beam_code(lambda c, floats, arguments: [c.eight(floats, arguments[1], 8 * k) for k in range(6)], 2, True)
    return types.int64(boxes, types.int64, beam, types.int64, near), code


def _stretch_of_lanes(c: Code, rays: Any, sides: list[Any], begin: Any) -> tuple[Any, Any]:
    """(first, last) t in a box of the eight lanes from `begin` on, within their intervals and before nearest hits."""
    b, rows = c.builder, [c.eight(rays, begin, 64 * k) for k in range(9)]
    first, last = rows[6], c.smaller(rows[7], rows[8])
    for axis in range(3):
        s = b.fmul(b.fsub(sides[axis], rows[axis]), rows[3 + axis])
        t = b.fmul(b.fsub(sides[3 + axis], rows[axis]), rows[3 + axis])
        first, last = c.larger(c.smaller(s, t), first), c.smaller(c.larger(s, t), last)
    return first, last


@intrinsic
def lanes_in_box(typing_context: Any, lanes: Any, lx: Any, ly: Any, lz: Any, hx: Any, hy: Any, hz: Any) -> Any:
    """Which lanes of a packet meet a box (low, high), as bits.

    The block of lanes begins with rows of 64: origins, inverse directions, t_min, t_max, nearest hits.
    """

    def code(context: Any, builder: Any, signature: Any, arguments: Any) -> Any:
        c, b = Code(context, builder), builder
        rays, sides = c.data(signature, arguments, 0), [c.spread(side) for side in arguments[1:]]
        met: Any = INT64(0)
        for group in range(8):
            bits = b.zext(c.overlaps(*_stretch_of_lanes(c, rays, sides, INT64(8 * group))), INT64)
            met = b.or_(met, b.shl(bits, INT64(8 * group)))
        return met

    return types.int64(lanes, *[types.float64] * 6), code


@intrinsic
def put_entries(
    typing_context: Any, lanes: Any, row: Any, items: Any, item: Any, entries: Any, at: Any, group: Any
) -> Any:
    """Where a group of eight lanes enters the box of an item, at the earliest, into entries[at:]; NaN if it misses it.

    What is greater in a row (lanes[row:]) becomes that.
    """

    def code(context: Any, builder: Any, signature: Any, arguments: Any) -> Any:
        c, b = Code(context, builder), builder
        rays, boxes, out = (c.data(signature, arguments, k) for k in (0, 2, 4))
        sides = [c.spread(c.number(boxes, arguments[3], k * ITEM_ROW)) for k in range(6)]
        begin = b.shl(arguments[6], INT64(3))
        first, last = _stretch_of_lanes(c, rays, sides, begin)
        sooner = b.fsub(first, b.fmul(c.size(first), c.constant(4.0 * slack.BOX_SLACK)))
        entered = b.select(c.overlapping(first, last), sooner, c.constant(float("nan")))
        c.store(entered, out, arguments[5], 0)
        row = b.add(arguments[1], begin)
        c.store(c.smaller(entered, c.eight(rays, row, 0)), rays, row, 0)
        return context.get_dummy_value()

    whole = types.int64
    return types.void(lanes, whole, items, whole, entries, whole, whole), code


@intrinsic
def lanes_entering(typing_context: Any, lanes: Any, row: Any, entries: Any, at: Any, group: Any) -> Any:
    """Which of a group of lanes enter a box (`put_entries`) within their intervals and no later than a row says.

    As bits, each that of its lane in the packet. Relies on no ray beginning before its origin.
    """

    def code(context: Any, builder: Any, signature: Any, arguments: Any) -> Any:
        c, b = Code(context, builder), builder
        rays, known = c.data(signature, arguments, 0), c.data(signature, arguments, 2)
        begin = b.shl(arguments[4], INT64(3))
        last = c.smaller(c.eight(rays, begin, 64 * 7), c.eight(rays, b.add(arguments[1], begin), 0))
        enter = b.fcmp_ordered("<=", c.eight(known, arguments[3], 0), last)
        return b.shl(b.zext(b.bitcast(enter, BITS), INT64), begin)

    return types.int64(lanes, types.int64, entries, types.int64, types.int64), code
