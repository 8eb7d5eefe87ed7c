"""Items that a tile sees: rows of their boxes, eight tested at a time, of which those that are met stay together."""

from __future__ import annotations

from typing import Any

from llvmlite import ir
from numba import types
from numba.extending import intrinsic

from .balls import sides_of_balls
from .boxes import beam_code, beam_stretch, stretches
from .code import BITS, DOUBLE, EIGHT, INT64, MASK, WHOLE, WIDTH, Code
from .layout import FIRST, ITEM_ROW, ITEMS_SIZE, LAST


@intrinsic
def items_met(typing_context: Any, items: Any, at: Any, beam: Any, start: Any) -> Any:
    """Which of eight items, from number `at` on, have boxes that a beam meets (`boxes_met`), as bits."""

    def sides(c: Code, floats: Any, arguments: Any) -> list[Any]:
        return [c.eight(floats, arguments[1], k * ITEM_ROW) for k in range(6)]

    return types.int64(items, types.int64, beam, types.int64), beam_code(sides, 2, False)


@intrinsic
def keep_items(typing_context: Any, items: Any, at: Any, bits: Any, kept: Any, end: Any) -> Any:
    """Those of eight items, from number `at` on, that a mask selects become items of `kept`, from number `end` on."""

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
    """Put those of a node's children that a beam meets behind found[:end]; returns how many.

    The boxes are at boxes[at:], the codes of what they hold at codes[first:], 0 for nothing. An element of `found` is a
    code, with the number of its box in the upper half; `number` is that of the first box.
    """

    def code(context: Any, builder: Any, signature: Any, arguments: Any) -> Any:
        c, b = Code(context, builder), builder
        floats, numbers, rays, out, times = (c.data(signature, arguments, k) for k in (0, 2, 5, 7, 8))
        enters, leaves = stretches(c, [c.eight(floats, arguments[1], 8 * k) for k in range(6)], rays, arguments[6])
        kind = ir.VectorType(ir.IntType(32), WIDTH)
        child = b.zext(b.load(b.bitcast(c.place(numbers, arguments[3], 0), kind.as_pointer()), align=4), WHOLE)
        met = b.and_(c.overlapping(enters, leaves), b.icmp_unsigned("!=", child, ir.Constant(WHOLE, [0] * WIDTH)))
        box = b.add(c.whole(arguments[4]), ir.Constant(WHOLE, list(range(WIDTH))))
        item = b.or_(child, b.shl(box, ir.Constant(WHOLE, [32] * WIDTH)))
        place = b.bitcast(c.place(out, arguments[9], 0), WHOLE.as_pointer())
        b.store(c.compressed(item, met), place, align=8)
        c.store(c.compressed(enters, met), times, arguments[9], 0)
        return b.ctpop(b.zext(b.bitcast(met, BITS), INT64))

    whole = types.int64
    return types.int64(boxes, whole, codes, whole, whole, beam, whole, found, t, whole), code


@intrinsic
def put_balls(
    typing_context: Any, balls: Any, at: Any, count: Any, leaf: Any, beam: Any, start: Any, items: Any, end: Any
) -> Any:
    """Those of the `count` balls of a leaf that a beam meets become items from number `end` on; returns how many.

    The balls are laid out as for `balls_met`; `leaf` is its code.
    """

    def code(context: Any, builder: Any, signature: Any, arguments: Any) -> Any:
        c, b = Code(context, builder), builder
        floats, rays, target = (c.data(signature, arguments, k) for k in (0, 4, 6))
        sides = sides_of_balls(c, floats, arguments[1], arguments[2])
        enters, leaves = stretches(c, sides, rays, arguments[5])
        places = ir.Constant(WHOLE, list(range(WIDTH)))
        met = b.and_(c.overlapping(enters, leaves), b.icmp_signed("<", places, c.whole(arguments[2])))
        box = ir.Constant(EIGHT, [float(-2 - k) for k in range(WIDTH)])
        rows = [*sides, enters, c.spread(b.sitofp(arguments[3], DOUBLE)), box]
        for row, value in enumerate(rows):
            c.store(c.compressed(value, met), target, arguments[7], row * ITEM_ROW)
        return b.ctpop(b.zext(b.bitcast(met, BITS), INT64))

    whole = types.int64
    return types.int64(balls, whole, whole, whole, beam, whole, items, whole), code


@intrinsic
def put_numbers(typing_context: Any, first: Any, bits: Any, numbers: Any, end: Any) -> Any:
    """Put those of the numbers first..first + 7 that a mask selects behind numbers[:end]."""

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
    """Put those of eight groups of lanes whose beams meet the box of an item behind pairs[:end]; returns how many.

    A pair is eight times a number, and the group. The beams are lanes[beams:] (`lanes.put_group_beams`).
    """

    def code(context: Any, builder: Any, signature: Any, arguments: Any) -> Any:
        c, b = Code(context, builder), builder
        boxes, rays, out = (c.data(signature, arguments, k) for k in (0, 3, 5))
        sides = [c.spread(c.number(boxes, arguments[1], k * ITEM_ROW)) for k in range(6)]

        def number(k: int) -> tuple[Any, Any]:
            eight = c.eight(rays, arguments[4], 8 * k)
            return eight, eight

        met = c.overlapping(*beam_stretch(c, sides, number, number(FIRST)[0], number(LAST)[0]))
        pair = b.add(c.whole(b.shl(arguments[2], INT64(3))), ir.Constant(WHOLE, list(range(WIDTH))))
        place = b.bitcast(c.place(out, arguments[6], 0), WHOLE.as_pointer())
        b.store(c.compressed(pair, met), place, align=8)
        return b.ctpop(b.zext(b.bitcast(met, BITS), INT64))

    whole = types.int64
    return types.int64(items, whole, whole, lanes, whole, pairs, whole), code
