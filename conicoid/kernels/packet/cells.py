"""Balls and cells in the lanes of a packet: planes, quadrics, first crossings and spans.

The lanes go through the same formulas as single rays, which the compiler turns into vector instructions: functions are
inlined into the loop, a surface's record is a tuple read before it, and selects replace branches. The few lanes whose
terms cancel are evaluated again one by one. So a ray gives the same hit to the bit, whichever route it takes. Loops are
written twice where the lanes may share one origin: terms that depend on the origin alone are then computed once, before
the loop. Every function works on lanes first..last, multiples of eight.
"""

from __future__ import annotations

import math
from typing import Any, NamedTuple

import numpy as np

from ..._jit.decorators import choose, helper, inline
from .. import tables as table
from ..body.cell import (
    FIRST_CUTS,
    FIRST_GROUPS,
    MANY_PLANES,
    NO_PLACE,
    PLANE_ROUNDING,
    PlaneGroup,
    PlaneSlab,
    SpanPair,
    clip_slab,
    compose_spans,
    groups_of,
    groups_within,
    load_group,
    most_of_group,
    plane_of_group,
    quadric_place,
    slab_of_many,
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
    DX,
    DY,
    DZ,
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
    PLACE_IN,
    PLACE_OUT,
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
    lane_ray,
    lane_slab,
    put_slab,
)


@helper
def _cut_lanes(lanes: Floats, lengths: Nearness, surface: int, inner: bool, place: int, first: int, last: int) -> None:
    """Cut the slabs by a plane whose height and rate are in A and B; FLAG 2: these are not certain.

    UNSURE becomes 1 where rounding may have changed the order of two planes, 2 where it may have changed more.
    """
    first, last = eights(first, last)
    for i in range(first, last):
        cut_lane(lanes, i, lengths, surface, inner, place, False)


@inline
def cut_lane(lanes: Floats, i: Any, lengths: Nearness, surface: Any, inner: bool, place: int, again: bool) -> None:
    """`_cut_lanes` for one lane; `again`: the plane may have cut the slab before."""
    height = 0.0 if lanes[START + i] == surface else lanes[A + i]
    off = lane_nearness(lanes, i, lengths).off
    if again:  # a plane is not close to itself
        off = choose((lanes[PLACE_IN + i] == place) | (lanes[PLACE_OUT + i] == place), -1.0, off)
    slab, close = clip_slab(lane_slab(lanes, i), height, lanes[B + i], inner, float(place), off)
    put_slab(lanes, i, slab)
    # 1 may still be harmless, outside of the interval (`unsure_lane`); 2 never is
    unsure = max(lanes[UNSURE + i], choose(close, 1.0, 0.0))
    lanes[UNSURE + i] = choose(lanes[FLAG + i] == 2.0, 2.0, unsure)


@inline
def plane_of_lane(lanes: Floats, i: int, line: RayLine, plane: PlaneRecord, limits: PlaneLimits) -> int:
    """Write a lane's height and rate to A and B; return 1, as FLAG, if they need `put_careful_plane`."""
    height, rate, cancels, parallel = plain_plane(plane, line)
    cancels |= unsure_of_plane(height, rate, parallel, lanes[INVERSE + i], limits)
    lanes[A + i], lanes[B + i] = height, rate
    lanes[FLAG + i] = 1.0 if cancels else 0.0
    return 1 if cancels else 0


@inline
def put_careful_plane(lanes: Floats, i: Any, plane: PlaneRecord, limits: PlaneLimits) -> None:
    """Compute a lane's height and rate again in twice the precision; FLAG 2 if they are still not certain."""
    line = lane_line(lanes, i)
    height, rate = careful_plane(plane, line)
    unsure = unsure_of_plane(height, rate, runs_along(plane, line), lanes[INVERSE + i], limits)
    lanes[A + i], lanes[B + i], lanes[FLAG + i] = height, rate, 2.0 if unsure else 1.0


@inline
def plane_lanes(geometry: Geometry, lanes: Floats, lengths: Nearness, place: int, first: int, last: int) -> None:
    """Cut the lanes' slabs by the plane of a place; `lengths` are the limits of its cell."""
    surface = integer(geometry, table.PLANE_SURFACE, place)
    row, inner = integer(geometry, table.SURFACE_ROW, surface), plane_side(geometry, place) > 0
    _put_plane(lanes, load_plane(geometry, row), plane_limits(geometry, row), first, last)
    _cut_lanes(lanes, lengths, surface, inner, place, first, last)
    # Most packets come from a camera, where no ray starts on a surface
    if lanes[SOME_START] != 0.0:
        for i in range(first, last):
            lanes[OWN + i] = choose(lanes[START + i] == surface, float(place), lanes[OWN + i])


@inline
def _put_plane(lanes: Floats, plane: PlaneRecord, limits: PlaneLimits, first: Any, last: Any) -> None:
    """Write the heights and rates of a plane to A and B; FLAG 2: these are not certain."""
    again, x, y, z = 0, lanes[OX], lanes[OY], lanes[OZ]
    if lanes[SHARED] != 0.0:
        for i in range(first, last):
            again += plane_of_lane(lanes, i, lane_line_from(lanes, i, x, y, z), plane, limits)
    else:
        for i in range(first, last):
            again += plane_of_lane(lanes, i, lane_line(lanes, i), plane, limits)
    if again > 0:  # few lanes: one by one, out of the vectorised loop
        for i in range(first, last):
            if lanes[FLAG + i] == 1.0:
                put_careful_plane(lanes, i, plane, limits)


# Cells of many planes: groups of planes that surely do not cut are passed over, as for single rays (`slab_of_many`)
#
# While the planes of a cell cut, row C has a lane's share of the margin, and row FOOT 1 if the lane needs no plane.

_MANY_GROUPS = 400
"""Lanes without a common origin have little in common at a cell of so many groups: each is traced by itself."""
_SEVERAL = 64
"""In a cell of fewer groups half of the first planes are enough."""


@inline
def _put_margin(lanes: Floats, i: Any, lengths: Nearness) -> None:
    """Write a lane's share of the margin, from its slab so far; a slab that is surely empty needs no plane."""
    off = lane_nearness(lanes, i, lengths).off
    ox, oy, oz, dx, dy, dz = lane_line(lanes, i)
    t_in, t_out = lanes[T_IN + i], lanes[T_OUT + i]
    along, far = abs(dx) + abs(dy) + abs(dz), max(abs(t_in), abs(t_out))
    lanes[C + i] = along * off + PLANE_ROUNDING * ((abs(ox) + abs(oy) + abs(oz)) + along * far)
    lanes[FOOT + i] = 1.0 if t_in > t_out + off else 0.0


@helper
def _group_may_cut(lanes: Floats, group: PlaneGroup, first: int, last: int) -> bool:
    """True if a plane of a group may cut the slab of a lane."""
    first, last = eights(first, last)
    some = 0
    for i in range(first, last):
        ox, oy, oz, dx, dy, dz = lane_line(lanes, i)
        t_in, t_out, least = lanes[T_IN + i], lanes[T_OUT + i], -2.0 * lanes[C + i]
        at_in = most_of_group(group, ox + t_in * dx, oy + t_in * dy, oz + t_in * dz)
        at_out = most_of_group(group, ox + t_out * dx, oy + t_out * dy, oz + t_out * dz)
        some += 0 if ((at_in < least) & (at_out < least)) | (lanes[FOOT + i] != 0.0) else 1
    return some > 0


@helper
def _lanes_to_cut(lanes: Floats, plane: PlaneRecord, inner: bool, place: int, first: int, last: int) -> int:
    """Write 1 as FLAG to the lanes whose slabs a plane may cut, 0 to the others; return how many may be cut.

    Relies on components of the normal of at most 1 (`PlaneRecord`).
    """
    first, last = eights(first, last)
    sense = 1.0 if inner else -1.0
    nx, ny, nz = sense * plane.nx, sense * plane.ny, sense * plane.nz
    offset = (nx * plane.ax + ny * plane.ay + nz * plane.az) - sense * plane.above
    margin = PLANE_ROUNDING * ((abs(plane.ax) + abs(plane.ay) + abs(plane.az)) + abs(plane.above))
    some, ready = 0, float(place)
    for i in range(first, last):
        height = (nx * lanes[OX + i] + ny * lanes[OY + i] + nz * lanes[OZ + i]) - offset
        rate = nx * lanes[DX + i] + ny * lanes[DY + i] + nz * lanes[DZ + i]
        at_in, at_out, least = height + rate * lanes[T_IN + i], height + rate * lanes[T_OUT + i], -margin - lanes[C + i]
        # Values at an infinite end may be NaN: then the plane cuts
        beside = ((at_in < least) & (at_out < least)) | (lanes[FOOT + i] != 0.0)
        beside |= (lanes[PLACE_IN + i] == ready) | (lanes[PLACE_OUT + i] == ready)
        lanes[FLAG + i] = 0.0 if beside else 1.0
        some += 0 if beside else 1
    return some


@inline
def _cut_many(geometry: Geometry, lanes: Floats, lengths: Nearness, place: int, first: Any, last: Any) -> None:
    """Cut the slabs of lanes by a plane where it may cut; few lanes one by one."""
    surface = integer(geometry, table.PLANE_SURFACE, place)
    row, inner = integer(geometry, table.SURFACE_ROW, surface), plane_side(geometry, place) > 0
    plane, limits = load_plane(geometry, row), plane_limits(geometry, row)
    some = _lanes_to_cut(lanes, plane, inner, place, first, last)
    if 4 * some > last - first:
        _put_plane(lanes, plane, limits, first, last)
        for i in range(first, last):
            cut_lane(lanes, i, lengths, surface, inner, place, True)
            _put_margin(lanes, i, lengths)
    elif some > 0:
        for i in range(first, last):
            if lanes[FLAG + i] == 1.0:
                if plane_of_lane(lanes, i, lane_line(lanes, i), plane, limits) > 0:
                    put_careful_plane(lanes, i, plane, limits)
                cut_lane(lanes, i, lengths, surface, inner, place, False)
                _put_margin(lanes, i, lengths)


@helper
def _many_planes(geometry: Geometry, lanes: Floats, lengths: Nearness, cell: int, first: int, last: int) -> None:
    """Cut the lanes' slabs by the planes of a cell that has many."""
    first, last = eights(first, last)
    begin, (group, end) = integer(geometry, table.CELL_FIRST, cell), groups_of(geometry, cell)
    if lanes[SHARED] == 0.0 and end - group > _MANY_GROUPS:
        for i in range(first, last):
            ray, nearness = lane_ray(lanes, i, lanes[T_MAX + i]), lane_nearness(lanes, i, lengths)
            slab, unsure, lost = slab_of_many(geometry, cell, ray, lanes[INVERSE + i], nearness)
            put_slab(lanes, i, slab)
            lanes[UNSURE + i] = 2.0 if lost else (1.0 if unsure else 0.0)
    else:
        for k in range(FIRST_CUTS if end - group > _SEVERAL else FIRST_CUTS // 2):
            plane_lanes(
                geometry, lanes, lengths, begin + plane_of_group(geometry, group + (k >> 2), k & 3), first, last
            )
        for i in range(first, last):
            _put_margin(lanes, i, lengths)
        group += FIRST_GROUPS
        while group < end:
            if not _group_may_cut(lanes, load_group(geometry, group), first, last):
                group += groups_within(geometry, group)
                continue
            for k in range(4):
                number = plane_of_group(geometry, group, k)
                if number < 0:
                    break
                _cut_many(geometry, lanes, lengths, begin + number, first, last)
            group += 1
    if lanes[SOME_START] != 0.0:
        for i in range(first, last):
            for place in (lanes[PLACE_IN + i], lanes[PLACE_OUT + i]):
                if place >= 0.0 and integer(geometry, table.PLANE_SURFACE, whole(place)) == lanes[START + i]:
                    lanes[OWN + i] = place


# First crossings of balls and cells


@helper
def ball_lanes(lanes: Floats, sphere: SphereRecord, surface: int, entry: int, body: int, first: int, last: int) -> None:
    """Find the first crossing of a ball; each lane keeps it if it is the nearer. The bits are those of `try_ball`."""
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
    """Find the first crossing of a ball by one lane, and keep it if it is the nearer (`keep_nearer`)."""
    starts, nearness = lanes[START + i] == surface, lane_nearness(lanes, i, lengths)
    roots = sphere_roots(sphere, line, lanes[INVERSE + i], starts)
    t, enters, unsure = ball_event(roots, starts, lanes[T_MIN + i], lanes[T_MAX + i], nearness)
    keep_nearer(lanes, i, Hit(t, body, entry, NO_PLACE, 1.0, enters, nearness.off, unsure))


@inline
def put_roots(lanes: Floats, i: int, roots: QuadricRoots) -> None:
    """Write roots to the rows of a lane, as `_quadric_lanes` describes them."""
    lanes[LOW + i], lanes[HIGH + i] = roots.low, roots.high
    lanes[FLAG + i] = (1.0 if roots.outside else 0.0) + (2.0 if roots.crosses else 0.0)
    lanes[DISCRIMINANT + i] = 1.0 if roots.unsure else 0.0


@inline
def lane_terms(lanes: Floats, i: int) -> RayQuadratic:
    """Return a lane's terms from A, B, C, DISCRIMINANT, FOOT; FLAG: odd if they cancel, >= 2 straight, >= 4 ruling."""
    flag = lanes[FLAG + i]
    cancels = (flag == 1.0) | (flag == 3.0) | (flag == 5.0)
    return RayQuadratic(
        lanes[A + i], lanes[B + i], lanes[C + i], lanes[DISCRIMINANT + i], lanes[FOOT + i],
        cancels, flag >= 2.0, flag >= 4.0,
    )  # fmt: skip


@inline
def put_terms(lanes: Floats, i: int, terms: RayQuadratic) -> None:
    """Write terms to the rows of a lane, as `lane_terms` reads them."""
    lanes[A + i], lanes[B + i], lanes[C + i] = terms.a, terms.b, terms.c
    lanes[DISCRIMINANT + i], lanes[FOOT + i] = terms.discriminant, terms.foot
    lanes[FLAG + i] = (
        (1.0 if terms.cancels else 0.0) + (2.0 if terms.straight else 0.0) + (2.0 if terms.ruling else 0.0)
    )


@helper
def settle_lanes(lanes: Floats, limits: QuadricLimits, surface: int, first: int, last: int) -> None:
    """Compute roots from the lanes' terms."""
    first, last = eights(first, last)
    for i in range(first, last):
        roots = roots_of_terms(lane_terms(lanes, i), lanes[START + i] == surface, lanes[INVERSE + i], limits)
        put_roots(lanes, i, roots)


@inline
def quadric_of_lane(lanes: Floats, i: int, line: RayLine, quadric: QuadricRecord, surface: int) -> int:
    """Compute a lane's terms; return 1 if `careful_quadratic` must evaluate them again."""
    terms = quadratic_on_ray(quadric, line, lanes[INVERSE + i], lanes[START + i] == surface)
    put_terms(lanes, i, terms)
    return 1 if terms.cancels else 0


@inline
def _quadric_lanes(geometry: Geometry, lanes: Floats, row: int, surface: int, first: int, last: int) -> None:
    """Write the lanes' roots to LOW and HIGH; FLAG: 1 for `outside` + 2 for `crosses`; DISCRIMINANT: 1 for `unsure`."""
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
    """`_quadric_lanes` for the sphere of a cut ball."""
    for i in range(first, last):
        starts = lanes[START + i] == surface
        put_roots(lanes, i, sphere_roots(sphere, lane_line(lanes, i), lanes[INVERSE + i], starts))


@inline
def put_whole_lane(lanes: Floats, i: int) -> None:
    """Reset a lane to the whole line without doubt, as a cell without faces leaves it."""
    put_slab(lanes, i, PlaneSlab(-math.inf, math.inf, float(NO_PLACE), float(NO_PLACE)))
    lanes[UNSURE + i], lanes[OWN + i], lanes[FLAG + i] = 0.0, math.inf, 1.0
    lanes[DISCRIMINANT + i] = 0.0


@helper
def face_lanes(geometry: Geometry, lanes: Floats, cell: int, first: int, last: int) -> int:
    """Compute the slab between the planes of a cell and the roots of its quadric; return how many lanes may be inside.

    Early out: if that is 0, no lane has a span or a doubt within its interval, and the roots are not written. Otherwise
    FLAG and DISCRIMINANT are as `_quadric_lanes` leaves them; without a quadric the whole slab is inside.
    """
    first, last = eights(first, last)
    lengths = lengths_of(geometry, table.CELL_LIMITS, cell)
    for i in range(first, last):
        put_whole_lane(lanes, i)
    begin, end = integer(geometry, table.CELL_FIRST, cell), integer(geometry, table.CELL_FIRST, cell + 1)
    if end - begin < MANY_PLANES:
        for place in range(begin, end):
            plane_lanes(geometry, lanes, lengths, place, first, last)
    else:
        _many_planes(geometry, lanes, lengths, cell, first, last)
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
    """True if rounding might change the spans of a cell within a lane's interval."""
    t_min, t_max = lanes[T_MIN + i], lanes[T_MAX + i]
    unsure = (lanes[UNSURE + i] == 1.0) | (lanes[DISCRIMINANT + i] != 0.0)
    low, high, crosses = lanes[LOW + i], lanes[HIGH + i], lanes[FLAG + i] >= 2.0
    doubt = spans_unsure(lane_slab(lanes, i), low, high, crosses, unsure, t_min, t_max, nearness)
    doubt |= (lanes[UNSURE + i] == 2.0) | (nearness.far < 0.0)
    return doubt & is_open(t_min, t_max)


@inline
def curved_side(geometry: Geometry, cell: int) -> int:
    """Return +1 if a cell lies inside its quadric or has none, -1 if outside."""
    return 1 if integer(geometry, table.CELL_QUADRIC, cell) < 0 else cell_side(geometry, cell)


@inline
def curved_surface(geometry: Geometry, cell: int) -> int:
    """Return the surface of a cell's quadric, or without one a number that no ray has as its start."""
    quadric = integer(geometry, table.CELL_QUADRIC, cell)
    return quadric if quadric >= 0 else whole(NO_PLACE - 9)


@inline
def lane_spans(lanes: Floats, i: int, side: int, curved: int) -> SpanPair:
    """Return the spans of a cell in a lane; `curved` is the place of its quadric."""
    flag = lanes[FLAG + i]
    outside = ((flag == 1.0) | (flag == 3.0)) != (side < 0)
    slab = lane_slab(lanes, i)
    return compose_spans(slab, lanes[LOW + i], lanes[HIGH + i], flag >= 2.0, outside, float(curved))


@inline
def _has_one_span(geometry: Geometry, cell: int) -> bool:
    """True if no ray has two spans in a cell: it has no quadric, or lies inside a convex one."""
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
    quadric: int  # `curved_surface`
    lengths: Nearness


@inline
def _end_of_lane(lanes: Floats, i: int, cell: _LaneCell, one: bool) -> None:
    """Keep the first end of a lane's spans if it is the nearer; with `one` a lane has at most one span, else two."""
    in1, out1, a1, b1, in2, out2, a2, b2, some, more = lane_spans(lanes, i, cell.side, cell.curved)
    more &= not one
    spans = SpanPair(in1, out1, a1, b1, in2, out2, a2, b2, some, more)
    t_min, t_max = lanes[T_MIN + i], lanes[T_MAX + i]
    c1 = some & counts_in(in1, False, t_min, t_max)
    c2 = some & counts_in(out1, False, t_min, t_max)
    c3 = more & counts_in(in2, False, t_min, t_max)
    c4 = more & counts_in(out2, False, t_min, t_max)
    # Spans are in order along the ray, so the first end that counts is the nearest
    t = in1 if c1 else (out1 if c2 else (in2 if c3 else (out2 if c4 else math.inf)))
    place = a1 if c1 else (b1 if c2 else (a2 if c3 else b2))
    nearness = lane_nearness(lanes, i, cell.lengths)
    own = choose(lanes[START + i] == cell.quadric, float(cell.curved), lanes[OWN + i])
    near = spans_at_start(spans, own, t_min, nearness.off)
    unsure = unsure_lane(lanes, i, nearness) | near | is_too_far(t, nearness)
    keep_nearer(lanes, i, Hit(t, cell.body, cell.entry, place, 1.0, c1 | (~c2 & c3), nearness.off, unsure))


@helper
def cell_lanes(geometry: Geometry, lanes: Floats, cell: int, entry: int, body: int, first: int, last: int) -> None:
    """Find the first span end of a cell within each lane's interval; each lane keeps it if it is the nearer.

    The bits are those of `try_cell`, or the lane is in doubt.
    """
    if face_lanes(geometry, lanes, cell, first, last) == 0:
        return
    quadric, lengths = curved_surface(geometry, cell), lengths_of(geometry, table.CELL_LIMITS, cell)
    lane_cell = _LaneCell(entry, body, curved_side(geometry, cell), quadric_place(cell), quadric, lengths)
    one = _has_one_span(geometry, cell)
    first, last = eights(first, last)
    # Two loops with a constant each, so that the compiler drops the second span from the first loop
    if one:
        for i in range(first, last):
            _end_of_lane(lanes, i, lane_cell, True)
    else:
        for i in range(first, last):
            _end_of_lane(lanes, i, lane_cell, False)


# Spans of balls and cells, as rows of 64 floats

# Rows of a span: its begin and end, and the places of their faces. A lane whose end lies before its begin has no span
IN, OUT, PLACE_OF_IN, PLACE_OF_OUT = (np.uint64(row) for row in range(0, 4 * LANES, LANES))
SPAN = 4 * LANES
LEAF = 2 * SPAN


@inline
def put_cell_spans(
    geometry: Geometry, lanes: Floats, leaves: Floats, at: int, cell: int, from_start: bool, first: int, last: int
) -> int:
    """Write the two spans of a cell to rows from leaves[at] on, after `face_lanes`; return how many lanes have two.

    With `from_start` a span that begins or ends at a lane's origin is doubtful.
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
    """`put_cell_spans` for one lane, to leaves[row:] and leaves[second:]; return 1 if it has a second span.

    `curved` is the place of the cell's quadric, whose surface is `quadric`.
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
    own = choose(lanes[START + i] == quadric, float(curved), lanes[OWN + i])
    near = spans_at_start(spans, own, lanes[T_MIN + i], nearness.off)
    unsure = unsure_lane(lanes, i, nearness) | (from_start & near)
    lanes[DOUBT + i] = choose(unsure, 1.0, lanes[DOUBT + i])
    return 1 if more else 0


@helper
def spans_of_cell(geometry: Geometry, lanes: Floats, leaves: Floats, at: int, cell: int, first: int, last: int) -> bool:
    """Write the spans of a cell to rows from leaves[at] on; False, and nothing written, if no lane can be inside."""
    if face_lanes(geometry, lanes, cell, first, last) == 0:
        return False
    put_cell_spans(geometry, lanes, leaves, at, cell, False, first, last)
    return True


@helper
def spans_of_ball(
    geometry: Geometry, lanes: Floats, leaves: Floats, at: int, surface: int, first: int, last: int
) -> None:
    """Write the span of a ball to rows from leaves[at] on."""
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
