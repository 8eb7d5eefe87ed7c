"""The spans of a ball or a cell in the lanes of a packet, as rows of 64 floats."""

from __future__ import annotations

import math
from typing import Any

import numpy as np

from ...compiler.jit import choose, helper, inline
from .. import tables as table
from ..body.cell import quadric_place
from ..body.spans import spans_at_start
from ..surface.nearness import Nearness, lengths_of, lengths_of_ball
from ..surface.quadric import sphere_roots
from ..surface.records import load_sphere
from ..tables import Floats, Geometry, integer
from .cells import curved_side, curved_surface, face_lanes, lane_spans, unsure_lane
from .lanes import DOUBT, INVERSE, LANES, OWN, START, T_MIN, eights, lane_line, lane_nearness

# Rows of a span: where it begins and ends, on which faces. It is none where it ends before it begins
IN, OUT, PLACE_OF_IN, PLACE_OF_OUT = (np.uint64(row) for row in range(0, 4 * LANES, LANES))
SPAN = 4 * LANES
LEAF = 2 * SPAN


@inline
def put_cell_spans(
    geometry: Geometry, lanes: Floats, leaves: Floats, at: int, cell: int, from_start: bool, first: int, last: int
) -> int:
    """The two spans of a cell, whose faces are met (`face_lanes`), into rows from leaves[at] on.

    Returns how many lanes have the second. Where `from_start`, one that begins or ends at a lane's origin is doubtful.
    """
    first, last = eights(first, last)
    side, curved, quadric = curved_side(geometry, cell), quadric_place(cell), curved_surface(geometry, cell)
    row, second, lengths = np.uint64(at), np.uint64(at + SPAN), lengths_of(geometry, table.CELL_LIMITS, cell)
    several = 0
    for i in range(first, last):
        nearness = lane_nearness(lanes, i, lengths)
        several += put_lane_spans(lanes, leaves, i, row, second, side, curved, quadric, nearness, from_start)
    return several


@inline
def put_lane_spans(
    lanes: Floats, leaves: Floats, i: Any, row: Any, second: Any, side: int, curved: int, quadric: Any,
    nearness: Nearness, from_start: bool,
) -> int:  # fmt: skip
    """`put_cell_spans` for a lane, into leaves[row:] and leaves[second:]; 1 where there is a second span.

    curved: the place of the cell's quadric, whose surface is `quadric`.
    """
    spans = lane_spans(lanes, i, side, curved)
    in1, out1, a1, b1, in2, out2, a2, b2, some, more = spans
    leaves[row + IN + i] = choose(some, in1, math.inf)
    leaves[row + OUT + i] = choose(some, out1, -math.inf)
    leaves[row + PLACE_OF_IN + i] = a1
    leaves[row + PLACE_OF_OUT + i] = b1
    leaves[second + IN + i] = choose(more, in2, math.inf)
    leaves[second + OUT + i] = choose(more, out2, -math.inf)
    leaves[second + PLACE_OF_IN + i] = a2
    leaves[second + PLACE_OF_OUT + i] = b2
    starts = (lanes[OWN + i] != 0.0) | (lanes[START + i] == quadric)
    near = spans_at_start(spans, starts, lanes[T_MIN + i], nearness.off)
    unsure = unsure_lane(lanes, i, nearness) | (from_start & near)
    lanes[DOUBT + i] = choose(unsure, 1.0, lanes[DOUBT + i])
    return 1 if more else 0


@helper
def spans_of_cell(geometry: Geometry, lanes: Floats, leaves: Floats, at: int, cell: int, first: int, last: int) -> bool:
    """The spans of a cell into rows from leaves[at] on; False if no lane can be inside, and they are not written."""
    if face_lanes(geometry, lanes, cell, first, last) == 0:
        return False
    put_cell_spans(geometry, lanes, leaves, at, cell, False, first, last)
    return True


@helper
def spans_of_ball(
    geometry: Geometry, lanes: Floats, leaves: Floats, at: int, surface: int, first: int, last: int
) -> None:
    """The span of a ball into rows from leaves[at] on."""
    first, last = eights(first, last)
    row, sphere = np.uint64(at), load_sphere(geometry, integer(geometry, table.SURFACE_ROW, surface))
    lengths = lengths_of_ball(sphere)
    for i in range(first, last):
        starts = lanes[START + i] == surface
        low, high, _, crosses, unsure = sphere_roots(sphere, lane_line(lanes, i), lanes[INVERSE + i], starts)
        leaves[row + IN + i] = choose(crosses, low, math.inf)
        leaves[row + OUT + i] = choose(crosses, high, -math.inf)
        unsure |= lane_nearness(lanes, i, lengths).far < 0.0
        lanes[DOUBT + i] = choose(unsure, 1.0, lanes[DOUBT + i])
