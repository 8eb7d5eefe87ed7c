"""Culling tests of boxes and balls, and of lists of them, in explicit vectors of eight floats.

The compiler vectorises loops over many lanes, but it unrolls a loop over the eight children of a node or the eight rows
of a packet first, and then leaves it scalar. So these few functions are written with LLVM's own vectors, which it
lowers to the instructions of the processor. Their arithmetic is IEEE as everywhere. All tests are conservative, by the
slacks of culling_constants.py: NaN counts as a hit.

This module exports the intrinsics of culling_tests.py, short_nodes.py and vector_code.py. Where machine code is shipped
it exports lazy names for them, which import these modules, and with them Numba, only when a compiler asks for one.
"""

from typing import TYPE_CHECKING

from ..._jit.decorators import instructions
from ..._jit.machine_code import SHIPPED
from .culling_constants import (
    BEAM,
    BOX_OR_BALL,
    CODE,
    ENTERED,
    FIRST,
    FROM_THE_START,
    HIGH_I,
    HIGH_O,
    ITEM_ROW,
    ITEMS_SIZE,
    LAST,
    LOW_I,
    LOW_O,
    MOST_CHOSEN,
    MOST_ITEMS,
    SHORT_CHILDREN,
    SHORT_NODE,
    SHORT_SLACK,
)

if TYPE_CHECKING or SHIPPED is None:
    from .culling_tests import (
        balls_in_beam,
        group_in_ball,
        hit_balls,
        hit_boxes,
        hit_items,
        keep_items,
        lanes_in_ball,
        lanes_in_ball_from_one,
        lanes_in_box,
        numbers_in_lanes,
        put_balls,
        put_children,
        put_groups,
        put_numbers,
        put_on_lists,
        rays_in_balls,
        records_in_lanes,
        waiting_ray,
    )
    from .short_nodes import float_bits, float_of_bits, put_waiting, take_waiting, visit_node
    from .vector_code import (
        bit_count,
        copy_points,
        extent,
        extents,
        finish_streams,
        highest_bit,
        load_eight,
        lowest_bit,
        prefetch,
        prefetch_soon,
        prefetch_to_write,
        reach,
        store_eight,
        widen,
    )
else:
    __getattr__ = instructions(__package__, "culling_tests", "short_nodes", "vector_code")

__all__ = [
    "BEAM", "BOX_OR_BALL", "CODE", "ENTERED", "FIRST", "FROM_THE_START", "HIGH_I", "HIGH_O", "ITEMS_SIZE",
    "ITEM_ROW", "LAST", "LOW_I", "LOW_O", "MOST_CHOSEN", "MOST_ITEMS", "SHORT_CHILDREN", "SHORT_NODE",
    "SHORT_SLACK", "balls_in_beam", "bit_count", "copy_points", "extent", "extents", "finish_streams", "float_bits",
    "float_of_bits", "group_in_ball", "highest_bit", "hit_balls", "hit_boxes", "hit_items", "keep_items",
    "lanes_in_ball", "lanes_in_ball_from_one", "lanes_in_box", "load_eight", "lowest_bit",
    "numbers_in_lanes", "prefetch", "prefetch_soon", "prefetch_to_write", "put_balls", "put_children",
    "put_groups", "put_numbers", "put_on_lists", "put_waiting", "rays_in_balls",
    "reach", "records_in_lanes", "store_eight", "take_waiting", "visit_node", "waiting_ray", "widen",
]  # fmt: skip
