"""Planes of cells met by the lanes of a packet (see cells.py)."""

from __future__ import annotations

import math
from typing import Any, NamedTuple

import numpy as np

from ..._jit.decorators import choose, helper, inline
from .. import tables as table
from ..body.cell import (
    NO_PLACE,
    PlaneSlab,
    SpanPair,
    clip_slab,
    compose_spans,
    quadric_place,
    spans_at_start,
    spans_unsure,
)
from ..body.hit import Hit, ball_event
from ..faces import cell_side, plane_side
from ..ray import RayLine
from ..surface.interval import Nearness, counts_in, is_open, is_too_far, lengths_of, lengths_of_ball, may_overlap
from ..surface.plane import PlaneLimits, PlaneRecord, careful_plane, plain_plane, runs_along, unsure_of_plane
from ..surface.quadric import (
    QuadricLimits,
    QuadricRecord,
    QuadricRoots,
    RayQuadratic,
    SphereRecord,
    careful_quadratic,
    quadratic_on_ray,
    roots_of_terms,
    sphere_roots,
)
from ..surface.records import load_plane, load_quadric, load_sphere, plane_limits, quadric_limits
from ..tables import SPHERE, Floats, Geometry, integer, whole
from .lanes import (
    DISCRIMINANT,
    DOUBT,
    FLAG,
    FOOT,
    HIGH,
    INVERSE,
    LANES,
    LOW,
    OWN,
    OX,
    OY,
    OZ,
    SHARED,
    SOME_START,
    START,
    T_IN,
    T_MAX,
    T_MIN,
    T_OUT,
    UNSURE,
    A,
    B,
    C,
    eights,
    keep_nearer,
    lane_line,
    lane_line_from,
    lane_nearness,
    lane_slab,
    put_slab,
)


@helper
def _cut_lanes(lanes: Floats, lengths: Nearness, surface: int, inner: bool, place: int, first: int, last: int) -> None:
    """Cut the slabs by a plane whose height and rate are in A and B; FLAG 2: rounding may have changed them too much.

    UNSURE becomes 1 where it may have changed the order of two planes, 2 where it may have changed more.
    """
    first, last = eights(first, last)
    for i in range(first, last):
        cut_lane(lanes, i, lengths, surface, inner, place)


@inline
def cut_lane(lanes: Floats, i: Any, lengths: Nearness, surface: Any, inner: bool, place: int) -> None:
    """`_cut_lanes` for a lane."""
    height = 0.0 if lanes[START + i] == surface else lanes[A + i]
    off = lane_nearness(lanes, i, lengths).off
    slab, close = clip_slab(lane_slab(lanes, i), height, lanes[B + i], inner, float(place), off)
    put_slab(lanes, i, slab)
    unsure = max(lanes[UNSURE + i], choose(close, 1.0, 0.0))
    lanes[UNSURE + i] = choose(lanes[FLAG + i] == 2.0, 2.0, unsure)


@inline
def plane_of_lane(lanes: Floats, i: int, line: RayLine, plane: PlaneRecord, limits: PlaneLimits) -> int:
    """A lane's height and rate into A and B; returns 1, as FLAG, where they are to be done again with care."""
    height, rate, cancels, parallel = plain_plane(plane, line)
    cancels |= unsure_of_plane(height, rate, parallel, lanes[INVERSE + i], limits)
    lanes[A + i], lanes[B + i] = height, rate
    lanes[FLAG + i] = 1.0 if cancels else 0.0
    return 1 if cancels else 0


@inline
def put_careful_plane(lanes: Floats, i: Any, plane: PlaneRecord, limits: PlaneLimits) -> None:
    """A lane's height and rate again, with care; FLAG 2 where rounding may still have changed them too much."""
    line = lane_line(lanes, i)
    height, rate = careful_plane(plane, line)
    unsure = unsure_of_plane(height, rate, runs_along(plane, line), lanes[INVERSE + i], limits)
    lanes[A + i], lanes[B + i], lanes[FLAG + i] = height, rate, 2.0 if unsure else 1.0


@inline
def plane_lanes(geometry: Geometry, lanes: Floats, lengths: Nearness, place: int, first: int, last: int) -> None:
    """Cut the lanes' slabs by the plane of a place; `lengths` are the limits of its cell."""
    surface = integer(geometry, table.PLANE_SURFACE, place)
    row, inner = integer(geometry, table.SURFACE_ROW, surface), plane_side(geometry, place) > 0
    plane, limits = load_plane(geometry, row), plane_limits(geometry, row)
    again, x, y, z = 0, lanes[OX], lanes[OY], lanes[OZ]
    if lanes[SHARED] != 0.0:
        for i in range(first, last):
            again += plane_of_lane(lanes, i, lane_line_from(lanes, i, x, y, z), plane, limits)
    else:
        for i in range(first, last):
            again += plane_of_lane(lanes, i, lane_line(lanes, i), plane, limits)
    if again > 0:
        for i in range(first, last):
            if lanes[FLAG + i] == 1.0:
                put_careful_plane(lanes, i, plane, limits)
    _cut_lanes(lanes, lengths, surface, inner, place, first, last)
    if lanes[SOME_START] != 0.0:
        for i in range(first, last):
            lanes[OWN + i] = choose(lanes[START + i] == surface, 1.0, lanes[OWN + i])


# Balls and cells met by the lanes of a packet.
#
# The lanes go through the same formulas as single rays, which the compiler turns into vector
# instructions: functions are merged into the loop, a surface's record is a tuple read before it, and
# selects replace branches. The few lanes whose terms cancel are evaluated again one by one. So a
# ray gives the same hit to the bit, whichever route it takes. Loops are written twice where the lanes may
# share one origin: what depends on it alone is then computed once, before the loop.
#
# Every function works on lanes first..last, multiples of eight.


@helper
def ball_lanes(lanes: Floats, sphere: SphereRecord, surface: int, entry: int, body: int, first: int, last: int) -> None:
    """The first crossing of a ball, kept by each lane if it is the nearer; to the same bits as `meet.try_ball`."""
    first, last = eights(first, last)
    lengths = lengths_of_ball(sphere)
    x, y, z = lanes[OX], lanes[OY], lanes[OZ]
    if lanes[SHARED] != 0.0:
        for i in range(first, last):
            _ball_of_lane(lanes, i, lane_line_from(lanes, i, x, y, z), sphere, lengths, surface, entry, body)
    else:
        for i in range(first, last):
            _ball_of_lane(lanes, i, lane_line(lanes, i), sphere, lengths, surface, entry, body)


@inline
def _ball_of_lane(
    lanes: Floats, i: int, line: RayLine, sphere: SphereRecord, lengths: Nearness, surface: int, entry: int, body: int
) -> None:
    """The first crossing of a ball by one lane, kept if it is the nearer (`take`)."""
    starts, nearness = lanes[START + i] == surface, lane_nearness(lanes, i, lengths)
    roots = sphere_roots(sphere, line, lanes[INVERSE + i], starts)
    t, enters, unsure = ball_event(roots, starts, lanes[T_MIN + i], lanes[T_MAX + i], nearness)
    keep_nearer(lanes, i, Hit(t, body, entry, NO_PLACE, 1.0, enters, nearness.off, unsure))


@inline
def put_roots(lanes: Floats, i: int, roots: QuadricRoots) -> None:
    """Roots into the rows of a lane, as `_quadric_lanes` describes them."""
    lanes[LOW + i], lanes[HIGH + i] = roots.low, roots.high
    lanes[FLAG + i] = (1.0 if roots.outside else 0.0) + (2.0 if roots.crosses else 0.0)
    lanes[DISCRIMINANT + i] = 1.0 if roots.unsure else 0.0


@inline
def lane_terms(lanes: Floats, i: int) -> RayQuadratic:
    """The terms in A, B, C, DISCRIMINANT and FOOT; FLAG: 1 they cancel, and 2 or more no term bends, 4 a ruling."""
    flag = lanes[FLAG + i]
    cancels = (flag == 1.0) | (flag == 3.0) | (flag == 5.0)
    return RayQuadratic(
        lanes[A + i], lanes[B + i], lanes[C + i], lanes[DISCRIMINANT + i], lanes[FOOT + i],
        cancels, flag >= 2.0, flag >= 4.0,
    )  # fmt: skip


@inline
def put_terms(lanes: Floats, i: int, terms: RayQuadratic) -> None:
    """Terms into the rows of a lane, as `lane_terms` reads them."""
    lanes[A + i], lanes[B + i], lanes[C + i] = terms.a, terms.b, terms.c
    lanes[DISCRIMINANT + i], lanes[FOOT + i] = terms.discriminant, terms.foot
    lanes[FLAG + i] = (
        (1.0 if terms.cancels else 0.0) + (2.0 if terms.straight else 0.0) + (2.0 if terms.ruling else 0.0)
    )


@helper
def settle_lanes(lanes: Floats, limits: QuadricLimits, surface: int, first: int, last: int) -> None:
    """Roots from the lanes' terms."""
    first, last = eights(first, last)
    for i in range(first, last):
        roots = roots_of_terms(lane_terms(lanes, i), lanes[START + i] == surface, lanes[INVERSE + i], limits)
        put_roots(lanes, i, roots)


@inline
def quadric_of_lane(lanes: Floats, i: int, line: RayLine, quadric: QuadricRecord, surface: int) -> int:
    """A lane's terms; returns 1 where `careful_quadratic` has to evaluate them again."""
    terms = quadratic_on_ray(quadric, line, lanes[INVERSE + i], lanes[START + i] == surface)
    put_terms(lanes, i, terms)
    return 1 if terms.cancels else 0


@inline
def _quadric_lanes(geometry: Geometry, lanes: Floats, row: int, surface: int, first: int, last: int) -> None:
    """The lanes' roots into LOW and HIGH; FLAG: 1 outside is inside, 2 it crosses; DISCRIMINANT: 1 it is unsure."""
    quadric, limits = load_quadric(geometry, row), quadric_limits(geometry, row)
    again, x, y, z = 0, lanes[OX], lanes[OY], lanes[OZ]
    if lanes[SHARED] != 0.0:
        for i in range(first, last):
            again += quadric_of_lane(lanes, i, lane_line_from(lanes, i, x, y, z), quadric, surface)
    else:
        for i in range(first, last):
            again += quadric_of_lane(lanes, i, lane_line(lanes, i), quadric, surface)
    if again > 0:
        for i in range(first, last):
            terms = lane_terms(lanes, i)
            if terms.cancels:
                put_terms(lanes, i, careful_quadratic(quadric, lane_line(lanes, i), terms))
    settle_lanes(lanes, limits, surface, first, last)


@inline
def _sphere_lanes(lanes: Floats, sphere: SphereRecord, surface: int, first: int, last: int) -> None:
    """As `_quadric_lanes`, for the sphere of a cut ball."""
    for i in range(first, last):
        starts = lanes[START + i] == surface
        put_roots(lanes, i, sphere_roots(sphere, lane_line(lanes, i), lanes[INVERSE + i], starts))


@inline
def put_whole_lane(lanes: Floats, i: int) -> None:
    """What a cell without faces leaves of a lane: all of it, for certain."""
    put_slab(lanes, i, PlaneSlab(-math.inf, math.inf, float(NO_PLACE), float(NO_PLACE)))
    lanes[UNSURE + i], lanes[OWN + i], lanes[FLAG + i] = 0.0, 0.0, 1.0
    lanes[DISCRIMINANT + i] = 0.0


@helper
def face_lanes(geometry: Geometry, lanes: Floats, cell: int, first: int, last: int) -> int:
    """The slab between the planes of a cell, the roots of its quadric. Returns how many lanes may be inside.

    Early out: where that is 0 no lane has a span or a doubt within its interval, and the roots are not written.
    Otherwise FLAG and DISCRIMINANT are as `_quadric_lanes` leaves them; without a quadric all of the slab is inside.
    """
    first, last = eights(first, last)
    lengths = lengths_of(geometry, table.CELL_LIMITS, cell)
    for i in range(first, last):
        put_whole_lane(lanes, i)
    for place in range(integer(geometry, table.CELL_FIRST, cell), integer(geometry, table.CELL_FIRST, cell + 1)):
        plane_lanes(geometry, lanes, lengths, place, first, last)
    some = 0
    for i in range(first, last):
        off, far = lane_nearness(lanes, i, lengths)
        inside = may_overlap(lanes[T_IN + i], lanes[T_OUT + i], lanes[T_MIN + i], lanes[T_MAX + i], off)
        some += 1 if inside | (lanes[UNSURE + i] == 2.0) | (far < 0.0) else 0
        lanes[FLAG + i] = 1.0
    surface = integer(geometry, table.CELL_QUADRIC, cell)
    if some == 0 or surface < 0:
        return some
    row = integer(geometry, table.SURFACE_ROW, surface)
    if integer(geometry, table.SURFACE_KIND, surface) == SPHERE:
        _sphere_lanes(lanes, load_sphere(geometry, row), surface, first, last)
    else:
        _quadric_lanes(geometry, lanes, row, surface, first, last)
    return some


@inline
def unsure_lane(lanes: Floats, i: int, nearness: Nearness) -> bool:
    """Might rounding change the spans of a cell within a lane's interval?"""
    t_min, t_max = lanes[T_MIN + i], lanes[T_MAX + i]
    unsure = (lanes[UNSURE + i] == 1.0) | (lanes[DISCRIMINANT + i] != 0.0)
    low, high, crosses = lanes[LOW + i], lanes[HIGH + i], lanes[FLAG + i] >= 2.0
    doubt = spans_unsure(lane_slab(lanes, i), low, high, crosses, unsure, t_min, t_max, nearness)
    doubt |= (lanes[UNSURE + i] == 2.0) | (nearness.far < 0.0)
    return doubt & is_open(t_min, t_max)


@inline
def curved_side(geometry: Geometry, cell: int) -> int:
    """+1 where a cell lies inside of its quadric (or has none), -1 where outside."""
    return 1 if integer(geometry, table.CELL_QUADRIC, cell) < 0 else cell_side(geometry, cell)


@inline
def curved_surface(geometry: Geometry, cell: int) -> int:
    """The surface of a cell's quadric, or a number on which no ray starts."""
    quadric = integer(geometry, table.CELL_QUADRIC, cell)
    return quadric if quadric >= 0 else whole(NO_PLACE - 9)


@inline
def lane_spans(lanes: Floats, i: int, side: int, curved: int) -> SpanPair:
    """The spans of a cell in a lane; `curved` is the place of its quadric."""
    flag = lanes[FLAG + i]
    outside = ((flag == 1.0) | (flag == 3.0)) != (side < 0)
    slab = lane_slab(lanes, i)
    return compose_spans(slab, lanes[LOW + i], lanes[HIGH + i], flag >= 2.0, outside, float(curved))


@inline
def _has_one_span(geometry: Geometry, cell: int) -> bool:
    """Is no ray inside of a cell twice, because it lies inside of a quadric that bends one way?"""
    surface = integer(geometry, table.CELL_QUADRIC, cell)
    if surface < 0 or cell_side(geometry, cell) < 0:
        return surface < 0
    if integer(geometry, table.SURFACE_KIND, surface) == SPHERE:
        return True
    quadric = load_quadric(geometry, integer(geometry, table.SURFACE_ROW, surface))
    return quadric.s0 >= 0.0 and quadric.s1 >= 0.0 and quadric.s2 >= 0.0


class _LaneCell(NamedTuple):
    """A cell that lanes meet."""

    entry: int
    body: int
    side: int  # `curved_side`
    curved: int  # the place of its quadric
    quadric: int  # the surface of that, or one that no ray starts on
    lengths: Nearness


@inline
def _end_of_lane(lanes: Floats, i: int, cell: _LaneCell, one: bool) -> None:
    """Take the first end of a lane's spans, of which there is `one` at most, or there may be two."""
    in1, out1, a1, b1, in2, out2, a2, b2, some, more = lane_spans(lanes, i, cell.side, cell.curved)
    more &= not one
    spans = SpanPair(in1, out1, a1, b1, in2, out2, a2, b2, some, more)
    t_min, t_max = lanes[T_MIN + i], lanes[T_MAX + i]
    c1 = some & counts_in(in1, False, t_min, t_max)
    c2 = some & counts_in(out1, False, t_min, t_max)
    c3 = more & counts_in(in2, False, t_min, t_max)
    c4 = more & counts_in(out2, False, t_min, t_max)
    t = in1 if c1 else (out1 if c2 else (in2 if c3 else (out2 if c4 else math.inf)))
    place = a1 if c1 else (b1 if c2 else (a2 if c3 else b2))
    nearness = lane_nearness(lanes, i, cell.lengths)
    starts = (lanes[OWN + i] != 0.0) | (lanes[START + i] == cell.quadric)
    near = spans_at_start(spans, starts, t_min, nearness.off)
    unsure = unsure_lane(lanes, i, nearness) | near | is_too_far(t, nearness)
    keep_nearer(lanes, i, Hit(t, cell.body, cell.entry, place, 1.0, c1 | (~c2 & c3), nearness.off, unsure))


@helper
def cell_lanes(geometry: Geometry, lanes: Floats, cell: int, entry: int, body: int, first: int, last: int) -> None:
    """The first end of the spans of a cell within each lane's interval, kept if it is the nearer (`take`).

    To the same bits as `meet.try_cell`, or in doubt.
    """
    if face_lanes(geometry, lanes, cell, first, last) == 0:
        return
    quadric, lengths = curved_surface(geometry, cell), lengths_of(geometry, table.CELL_LIMITS, cell)
    met = _LaneCell(entry, body, curved_side(geometry, cell), quadric_place(cell), quadric, lengths)
    one = _has_one_span(geometry, cell)
    first, last = eights(first, last)
    if one:
        for i in range(first, last):
            _end_of_lane(lanes, i, met, True)
    else:
        for i in range(first, last):
            _end_of_lane(lanes, i, met, False)


# The spans of a ball or a cell in the lanes of a packet, as rows of 64 floats.

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
