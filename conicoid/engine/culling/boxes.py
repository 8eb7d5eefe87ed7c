"""Eight boxes against a beam or a ray, a box against the lanes of a packet."""

from __future__ import annotations

from typing import Any

from llvmlite import ir
from numba import types
from numba.extending import intrinsic

from .code import EIGHT, INT64, WIDTH, Code
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


def _stretch_of_lanes(c: Code, rays: Any, sides: list[Any], group: int) -> tuple[Any, Any]:
    """(first, last) t in a box of one of the eight groups of lanes, within their intervals and before nearest hits."""
    b, rows = c.builder, [c.eight(rays, INT64(0), 64 * k + 8 * group) for k in range(9)]
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
            bits = b.zext(c.overlaps(*_stretch_of_lanes(c, rays, sides, group)), INT64)
            met = b.or_(met, b.shl(bits, INT64(8 * group)))
        return met

    return types.int64(lanes, *[types.float64] * 6), code


@intrinsic
def put_entries(typing_context: Any, lanes: Any, row: Any, items: Any, item: Any, entries: Any, at: Any) -> Any:
    """Where the lanes of a packet enter the box of an item, into entries[at : at + 64]; NaN for those that miss it.

    What is greater in a row (lanes[row:]) becomes that.
    """

    def code(context: Any, builder: Any, signature: Any, arguments: Any) -> Any:
        c, b = Code(context, builder), builder
        rays, boxes, out = (c.data(signature, arguments, k) for k in (0, 2, 4))
        sides = [c.spread(c.number(boxes, arguments[3], k * ITEM_ROW)) for k in range(6)]
        for group in range(8):
            first, last = _stretch_of_lanes(c, rays, sides, group)
            entered = b.select(c.overlapping(first, last), first, c.constant(float("nan")))
            c.store(entered, out, arguments[5], 8 * group)
            c.store(c.smaller(entered, c.eight(rays, arguments[1], 8 * group)), rays, arguments[1], 8 * group)
        return context.get_dummy_value()

    whole = types.int64
    return types.void(lanes, whole, items, whole, entries, whole), code


@intrinsic
def lanes_entering(typing_context: Any, lanes: Any, row: Any, entries: Any, at: Any) -> Any:
    """Which lanes enter a box (`put_entries`) within their intervals, and no later than a row says, as bits."""

    def code(context: Any, builder: Any, signature: Any, arguments: Any) -> Any:
        c, b = Code(context, builder), builder
        rays, known = c.data(signature, arguments, 0), c.data(signature, arguments, 2)
        met: Any = INT64(0)
        for group in range(8):
            last = c.smaller(c.eight(rays, INT64(0), 64 * 7 + 8 * group), c.eight(rays, arguments[1], 8 * group))
            bits = b.zext(c.overlaps(c.eight(known, arguments[3], 8 * group), last), INT64)
            met = b.or_(met, b.shl(bits, INT64(8 * group)))
        return met

    return types.int64(lanes, types.int64, entries, types.int64), code
