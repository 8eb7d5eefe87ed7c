"""Instructions on short nodes, by which threads of a GPU walk through trees (kernels/device_walk.py).

The eight boxes of a short node are whole numbers from 0 to 255 on a grid of the node's own (after Ylitie, Karras and
Laine, Efficient incoherent ray traversal on GPUs through compressed wide BVHs, HPG 2017). A ray meets them by float32,
rounded outward: no ray that meets a box may miss its short box.

User: first hits on a GPU; factor, with the walk of `device_walk.py`, over nodes of 416 bytes: 4.6 for camera rays on
1,000 balls, 4.7 for rays in no order (one H200, 2026-11-28).
"""

from __future__ import annotations

from typing import Any

from llvmlite import ir
from numba import types
from numba.core import cgutils
from numba.extending import intrinsic

from .culling_constants import SHORT_CHILDREN, SHORT_NODE, SHORT_SLACK
from .vector_code import DOUBLE, INT64, Code

_SINGLE, _INT32, _PAIR = ir.FloatType(), ir.IntType(32), ir.VectorType(INT64, 2)


@intrinsic
def float_bits(typing_context: Any, x: Any) -> Any:
    """Return the bits of a float as a whole number."""

    def code(context: Any, builder: Any, signature: Any, arguments: Any) -> Any:
        return builder.bitcast(arguments[0], INT64)

    return types.int64(types.float64), code


@intrinsic
def float_of_bits(typing_context: Any, bits: Any) -> Any:
    """Return the float with these bits."""

    def code(context: Any, builder: Any, signature: Any, arguments: Any) -> Any:
        return builder.bitcast(arguments[0], DOUBLE)

    return types.float64(types.int64), code


class _Singles:
    """LLVM's instructions on float32."""

    def __init__(self, builder: Any) -> None:
        self.builder = builder

    def constant(self, value: float) -> Any:
        return ir.Constant(_SINGLE, value)

    def call(self, name: str, *arguments: Any) -> Any:
        """Call an intrinsic of LLVM."""
        kind = ir.FunctionType(_SINGLE, [_SINGLE] * len(arguments))
        return self.builder.call(cgutils.get_or_insert_function(self.builder.module, kind, name), arguments)

    def smaller(self, a: Any, b: Any) -> Any:
        """Return the minimum; the other one where one is NaN."""
        return self.call("llvm.minnum.f32", a, b)

    def larger(self, a: Any, b: Any) -> Any:
        """Return the maximum; the other one where one is NaN."""
        return self.call("llvm.maxnum.f32", a, b)

    def fused(self, a: Any, b: Any, c: Any) -> Any:
        return self.call("llvm.fma.f32", a, b, c)

    def size(self, a: Any) -> Any:
        return self.call("llvm.fabs.f32", a)


def _stretch_of_axis(
    s: _Singles, begin: Any, step: Any, sides: tuple[Any, Any], origin: Any, inverse: Any
) -> tuple[list[Any], list[Any]]:
    """Emit (t of entry, t of exit) of eight short boxes along an axis, rounded outward."""
    b = s.builder
    # Sums and products of float64, which are rounded relative to themselves; then all in float32
    grid = b.fptrunc(b.fmul(b.fsub(begin, origin), inverse), _SINGLE)
    slope = b.fptrunc(b.fmul(step, inverse), _SINGLE)
    slack = b.fmul(s.fused(s.size(slope), s.constant(255.0), s.size(grid)), s.constant(SHORT_SLACK))
    falls = b.fcmp_ordered("<", slope, s.constant(0.0))
    ends: list[list[Any]] = []
    for bytes_first, start in (
        (b.select(falls, sides[1], sides[0]), b.fsub(grid, slack)),
        (b.select(falls, sides[0], sides[1]), b.fadd(grid, slack)),
    ):
        halves = b.trunc(bytes_first, _INT32), b.trunc(b.lshr(bytes_first, INT64(32)), _INT32)
        numbers = [b.and_(b.lshr(halves[k >> 2], _INT32(8 * (k & 3))), _INT32(255)) for k in range(8)]
        ends.append([s.fused(b.uitofp(each, _SINGLE), slope, start) for each in numbers])
    return ends[0], ends[1]


def _sorted_eight(b: Any, keys: list[Any]) -> list[Any]:
    """Emit Batcher's network of 19 comparisons."""
    keys = list(keys)
    for pairs in ("01 23 45 67", "02 13 46 57", "12 56", "04 15 26 37", "24 35", "12 34 56"):
        for pair in pairs.split():
            i, j = map(int, pair)
            less = b.icmp_unsigned("<", keys[i], keys[j])
            keys[i], keys[j] = b.select(less, keys[i], keys[j]), b.select(less, keys[j], keys[i])
    return keys


@intrinsic
def visit_node(
    typing_context: Any, nodes: Any, node: Any, ox: Any, oy: Any, oz: Any, ix: Any, iy: Any, iz: Any, first: Any,
    last: Any, way: Any, top: Any,
) -> Any:  # fmt: skip
    """Return (code of the nearest child that a ray meets within [first, last], 0 for none; height of the stack).

    The other children that it meets are pushed on the stack in `way`, the nearest on top: an element is the bits of
    the t of entry (of 0 where that is less; the last three are 0) and the code, 32 bits each.
    """

    def code(context: Any, builder: Any, signature: Any, arguments: Any) -> Any:
        c, b, s = Code(context, builder), builder, _Singles(builder)
        node, origin, inverse, first, last, top = (
            arguments[1], arguments[2:5], arguments[5:8], arguments[8], arguments[9], arguments[11]
        )  # fmt: skip
        place = b.gep(c.data(signature, arguments, 0), [b.mul(node, INT64(SHORT_NODE))])
        pairs = b.bitcast(place, _PAIR.as_pointer())
        words = []
        for k in range(5):
            pair = b.load(b.gep(pairs, [_INT32(k)]), align=16)
            words += [b.extract_element(pair, _INT32(j)) for j in range(2)]
        near, far = [first] * 8, [last] * 8
        for axis in range(3):
            exponent = b.and_(b.lshr(words[3], INT64(16 * axis)), INT64(0xFFFF))
            entries, exits = _stretch_of_axis(
                s,
                b.bitcast(words[axis], DOUBLE),
                b.bitcast(b.shl(exponent, INT64(52)), DOUBLE),
                (words[4 + axis], words[7 + axis]),
                origin[axis],
                inverse[axis],
            )
            near = [s.larger(*each) for each in zip(entries, near, strict=True)]
            far = [s.smaller(*each) for each in zip(exits, far, strict=True)]
        keys, miss = [], _INT32(0xFFFFFFFF)
        for k in range(8):
            bits = b.bitcast(s.larger(near[k], s.constant(0.0)), _INT32)
            key = b.or_(b.and_(bits, _INT32(0x7FFFFFF8)), _INT32(k))
            keys.append(b.select(b.fcmp_ordered(">", near[k], far[k]), miss, key))
        keys = _sorted_eight(b, keys)
        children = b.bitcast(b.gep(place, [INT64(SHORT_CHILDREN)]), _INT32.as_pointer())
        stack = b.bitcast(c.data(signature, arguments, 10), INT64.as_pointer())

        def child(key: Any) -> Any:
            return b.load(b.gep(children, [b.and_(key, _INT32(7))]))

        height = cgutils.alloca_once_value(b, top)
        for key in keys[:0:-1]:
            with b.if_then(b.icmp_unsigned("!=", key, miss)):
                at = b.load(height)
                low = b.zext(child(key), INT64)
                b.store(b.or_(b.shl(b.zext(key, INT64), INT64(32)), low), b.gep(stack, [at]))
                b.store(b.add(at, INT64(1)), height)
        nearest = cgutils.alloca_once_value(b, INT64(0))
        with b.if_then(b.icmp_unsigned("!=", keys[0], miss)):
            b.store(b.sext(child(keys[0]), INT64), nearest)
        return context.make_tuple(b, signature.return_type, [b.load(nearest), b.load(height)])

    double, whole, single = types.float64, types.int64, types.float32
    arguments = [nodes, whole, *[double] * 6, single, single, way, whole]
    return types.UniTuple(whole, 2)(*arguments), code


@intrinsic
def put_waiting(typing_context: Any, way: Any, k: Any, code: Any) -> Any:
    """Write element k of the stack of `visit_node`: a node or leaf with this code, which a ray enters at any t."""

    def emit(context: Any, builder: Any, signature: Any, arguments: Any) -> Any:
        b = builder
        stack = b.bitcast(Code(context, b).data(signature, arguments, 0), INT64.as_pointer())
        b.store(b.and_(arguments[2], INT64(0xFFFFFFFF)), b.gep(stack, [arguments[1]]))
        return context.get_dummy_value()

    return types.void(way, types.int64, types.int64), emit


@intrinsic
def take_waiting(typing_context: Any, way: Any, k: Any, last: Any) -> Any:
    """Return the code of element k of the stack of `visit_node`; 0 if the ray enters it beyond `last`."""

    def emit(context: Any, builder: Any, signature: Any, arguments: Any) -> Any:
        b, s = builder, _Singles(builder)
        stack = b.bitcast(Code(context, b).data(signature, arguments, 0), INT64.as_pointer())
        element = b.load(b.gep(stack, [arguments[1]]))
        t = b.bitcast(b.and_(b.trunc(b.lshr(element, INT64(32)), _INT32), _INT32(0x7FFFFFF8)), _SINGLE)
        # Boxes that are entered before t = 0 have t = 0 here
        beyond = b.fcmp_ordered(">", t, s.larger(arguments[2], s.constant(0.0)))
        return b.select(beyond, INT64(0), b.sext(b.trunc(element, _INT32), INT64))

    return types.int64(way, types.int64, types.float32), emit
