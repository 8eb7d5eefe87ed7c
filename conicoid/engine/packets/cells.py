"""Balls and cells met by the lanes of a packet.

The lanes go through the same formulas as single rays, which the compiler turns into vector
instructions: functions are merged into the loop, a surface's record is a tuple read before it, and
selects take the place of branches. The few lanes whose terms cancel are done again one by one. So a
ray gives the same hit to the bit, whichever way it goes. Loops are written twice where the lanes may
have one origin: what follows from it is worked out before the first.

Every function works on lanes first..last, multiples of eight.
"""

from __future__ import annotations

import math

from ...compiler.jit import choose, helper, inline
from .. import tables as table
from ..body.cell import NO_PLACE, quadric_place
from ..surface.nearness import Nearness, at_start, lengths_of, lengths_of_ball
from ..surface.plane import Limits
from ..surface.quadric import Quadric, Roots, Sphere, careful_quadratic, quadratic_on_ray, settled_roots, sphere_roots
from ..surface.records import load_limits, load_plane, load_quadric, load_sphere
from ..tables import SPHERE, Floats, Geometry, integer
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
    lane_nearness,
    take,
)
from .planes import plane_lanes

SpanLanes = tuple[float, float, float, float, float, float, float, float, bool, bool]


@helper
def ball_lanes(lanes: Floats, sphere: Sphere, surface: int, entry: int, body: int, first: int, last: int) -> None:
    """The first crossing of a ball."""
    first, last = eights(first, last)
    lengths = lengths_of_ball(sphere[0], sphere[1], sphere[2], sphere[3])
    x, y, z = lanes[OX], lanes[OY], lanes[OZ]
    if lanes[SHARED] != 0.0:
        for i in range(first, last):
            _ball_of_lane(lanes, i, x, y, z, sphere, lengths, surface, entry, body)
    else:
        for i in range(first, last):
            _ball_of_lane(lanes, i, lanes[OX + i], lanes[OY + i], lanes[OZ + i], sphere, lengths, surface, entry, body)


@inline
def _ball_of_lane(
    lanes: Floats, i: int, ox: float, oy: float, oz: float, sphere: Sphere, lengths: Nearness,
    surface: int, entry: int, body: int,
) -> None:  # fmt: skip
    starts = lanes[START + i] == surface
    low, high, _, crosses, unsure = sphere_roots(
        sphere, ox, oy, oz, lanes[DX + i], lanes[DY + i], lanes[DZ + i], lanes[INVERSE + i], starts
    )
    enters = crosses & (low > lanes[T_MIN + i]) & (low < lanes[T_MAX + i])
    leaves = crosses & (high > lanes[T_MIN + i]) & (high < lanes[T_MAX + i])
    t = low if enters else (high if leaves else math.inf)
    off, far = lane_nearness(lanes, i, lengths)
    t_min = lanes[T_MIN + i]
    near = at_start(low, starts, t_min, off) | at_start(high, starts, t_min, off)
    unsure |= (crosses & near) | (far < 0.0)
    lanes[DOUBT + i] = choose(unsure, 1.0, lanes[DOUBT + i])
    take(lanes, i, t, off, entry, body, NO_PLACE, 1.0, 1.0 if enters else 0.0)


@inline
def _put_roots(lanes: Floats, i: int, roots: Roots) -> None:
    low, high, outside, crosses, unsure = roots
    lanes[LOW + i], lanes[HIGH + i] = low, high
    lanes[FLAG + i] = (1.0 if outside else 0.0) + (2.0 if crosses else 0.0)
    lanes[DISCRIMINANT + i] = 1.0 if unsure else 0.0


@helper
def _settle_lanes(lanes: Floats, limits: Limits, surface: int, first: int, last: int) -> None:
    """Roots from the terms in A, B, C, DISCRIMINANT and FOOT; FLAG 2 or more: no term bends, 4: the ray is a ruling."""
    first, last = eights(first, last)
    for i in range(first, last):
        roots = settled_roots(
            lanes[A + i],
            lanes[B + i],
            lanes[C + i],
            lanes[DISCRIMINANT + i],
            lanes[FOOT + i],
            lanes[START + i] == surface,
            lanes[FLAG + i] >= 2.0,
            lanes[FLAG + i] >= 4.0,
            lanes[INVERSE + i],
            limits,
        )
        _put_roots(lanes, i, roots)


@inline
def _quadric_of_lane(lanes: Floats, i: int, ox: float, oy: float, oz: float, quadric: Quadric, surface: int) -> int:
    """A lane's terms into A, B, C, DISCRIMINANT and FOOT; returns 1 where they are to be done again with care."""
    a, b, c, discriminant, foot, cancels, straight, ruling = quadratic_on_ray(
        quadric, ox, oy, oz, lanes[DX + i], lanes[DY + i], lanes[DZ + i], lanes[INVERSE + i],
        lanes[START + i] == surface,
    )  # fmt: skip
    lanes[A + i], lanes[B + i], lanes[C + i], lanes[DISCRIMINANT + i], lanes[FOOT + i] = a, b, c, discriminant, foot
    lanes[FLAG + i] = (1.0 if cancels else 0.0) + (2.0 if straight else 0.0) + (2.0 if ruling else 0.0)
    return 1 if cancels else 0


@inline
def _quadric_lanes(lanes: Floats, quadric: Quadric, limits: Limits, surface: int, first: int, last: int) -> None:
    """The lanes' roots into LOW and HIGH; FLAG: 1 outside is inside, 2 it crosses; DISCRIMINANT: 1 it is unsure."""
    again, x, y, z = 0, lanes[OX], lanes[OY], lanes[OZ]
    if lanes[SHARED] != 0.0:
        for i in range(first, last):
            again += _quadric_of_lane(lanes, i, x, y, z, quadric, surface)
    else:
        for i in range(first, last):
            again += _quadric_of_lane(lanes, i, lanes[OX + i], lanes[OY + i], lanes[OZ + i], quadric, surface)
    if again > 0:
        for i in range(first, last):
            if lanes[FLAG + i] == 1.0 or lanes[FLAG + i] == 3.0 or lanes[FLAG + i] == 5.0:
                lanes[A + i], lanes[B + i], lanes[C + i], lanes[DISCRIMINANT + i] = careful_quadratic(
                    quadric, lanes[OX + i], lanes[OY + i], lanes[OZ + i], lanes[DX + i], lanes[DY + i], lanes[DZ + i],
                    lanes[FOOT + i],
                )  # fmt: skip
    _settle_lanes(lanes, limits, surface, first, last)


@inline
def _sphere_lanes(lanes: Floats, sphere: Sphere, surface: int, first: int, last: int) -> None:
    """As `_quadric_lanes`, for the sphere of a cut ball."""
    for i in range(first, last):
        roots = sphere_roots(
            sphere, lanes[OX + i], lanes[OY + i], lanes[OZ + i], lanes[DX + i], lanes[DY + i], lanes[DZ + i],
            lanes[INVERSE + i], lanes[START + i] == surface,
        )  # fmt: skip
        _put_roots(lanes, i, roots)


@helper
def face_lanes(geometry: Geometry, lanes: Floats, cell: int, first: int, last: int) -> int:
    """The span inside all planes of a cell, the roots of its quadric. Returns how many lanes may be inside."""
    first, last = eights(first, last)
    lengths = lengths_of(geometry, table.CELL_LIMITS, cell)
    for i in range(first, last):
        lanes[T_IN + i], lanes[T_OUT + i] = -math.inf, math.inf
        lanes[PLACE_IN + i], lanes[PLACE_OUT + i] = NO_PLACE, NO_PLACE
        lanes[UNSURE + i], lanes[OWN + i], lanes[FLAG + i] = 0.0, 0.0, 1.0
        lanes[DISCRIMINANT + i] = 0.0
    for place in range(integer(geometry, table.CELL_FIRST, cell), integer(geometry, table.CELL_FIRST, cell + 1)):
        surface = integer(geometry, table.PLANE_SURFACE, place)
        row = integer(geometry, table.SURFACE_ROW, surface)
        plane, limits = load_plane(geometry, row), load_limits(geometry, table.PLANE_LIMITS, row)
        side = integer(geometry, table.PLANE_SIDE, place)
        plane_lanes(lanes, plane, limits, lengths, surface, side, place, first, last)
        if lanes[SOME_START] != 0.0:
            for i in range(first, last):
                lanes[OWN + i] = choose(lanes[START + i] == surface, 1.0, lanes[OWN + i])
    some = 0
    for i in range(first, last):
        off, far = lane_nearness(lanes, i, lengths)
        t_in, t_out, t_min = lanes[T_IN + i], lanes[T_OUT + i] + off, lanes[T_MIN + i]
        inside = (t_in <= t_out) & (t_min <= t_out) & (t_in <= lanes[T_MAX + i] + off)
        some += 1 if inside | (lanes[UNSURE + i] == 2.0) | (far < 0.0) else 0
        lanes[FLAG + i] = 1.0
    surface = integer(geometry, table.CELL_QUADRIC, cell)
    if some == 0 or surface < 0:
        return some
    row = integer(geometry, table.SURFACE_ROW, surface)
    if integer(geometry, table.SURFACE_KIND, surface) == SPHERE:
        _sphere_lanes(lanes, load_sphere(geometry, row), surface, first, last)
    else:
        limits = load_limits(geometry, table.QUADRIC_LIMITS, row)
        _quadric_lanes(lanes, load_quadric(geometry, row), limits, surface, first, last)
    return some


@inline
def unsure_lane(lanes: Floats, i: int, off: float, far: float) -> bool:
    """Might rounding change the spans of a cell within a lane's interval?"""
    t_in, t_out, low, high = lanes[T_IN + i], lanes[T_OUT + i], lanes[LOW + i], lanes[HIGH + i]
    close = (
        (abs(low - t_in) <= off) | (abs(low - t_out) <= off) | (abs(high - t_in) <= off) | (abs(high - t_out) <= off)
    )
    close |= ((abs(low) > far) & (abs(low) < math.inf)) | ((abs(high) > far) & (abs(high) < math.inf))
    unsure = (lanes[UNSURE + i] == 1.0) | (abs(t_in - t_out) <= off) | (close & (lanes[FLAG + i] >= 2.0))
    unsure |= lanes[DISCRIMINANT + i] != 0.0
    matters = (t_out >= lanes[T_MIN + i] - off) & (t_in <= t_out + off)
    doubt = (unsure & matters) | (lanes[UNSURE + i] == 2.0) | (far < 0.0)
    return doubt & (lanes[T_MIN + i] < lanes[T_MAX + i])


@inline
def curved_side(geometry: Geometry, cell: int) -> int:
    """+1 where a cell lies inside of its quadric (or has none), -1 where outside."""
    return 1 if integer(geometry, table.CELL_QUADRIC, cell) < 0 else integer(geometry, table.CELL_SIDE, cell)


@inline
def span_lane(lanes: Floats, i: int, side: int, curved: int) -> SpanLanes:
    """`cell_spans`, with selects: in and out of two spans, their places, is there a first, is there a second."""
    t_in, t_out, flag = lanes[T_IN + i], lanes[T_OUT + i], lanes[FLAG + i]
    low, high = lanes[LOW + i], lanes[HIGH + i]
    crosses = flag >= 2.0
    outside = ((flag == 1.0) | (flag == 3.0)) != (side < 0)
    # The span between the roots, or the one before them, or all of it
    between = crosses & ~outside
    beyond = crosses & outside
    in1 = low if between & (low >= t_in) else t_in
    by_root = (between & (high <= t_out)) | (beyond & (low <= t_out))
    out1 = (high if between else low) if by_root else t_out
    place_in1 = curved if between & (low >= t_in) else lanes[PLACE_IN + i]
    place_out1 = curved if by_root else lanes[PLACE_OUT + i]
    some = (in1 < out1) & (crosses | outside)
    # The span after the roots
    in2 = high if high >= t_in else t_in
    place_in2 = curved if high >= t_in else lanes[PLACE_IN + i]
    more = beyond & (in2 < t_out) & (t_in < t_out)
    return in1, out1, in2, t_out, place_in1, place_out1, place_in2, lanes[PLACE_OUT + i], some, more


@inline
def _has_one_span(geometry: Geometry, cell: int) -> bool:
    """Is no ray inside of a cell twice, because it lies inside of a quadric that bends one way?"""
    surface = integer(geometry, table.CELL_QUADRIC, cell)
    if surface < 0 or integer(geometry, table.CELL_SIDE, cell) < 0:
        return surface < 0
    if integer(geometry, table.SURFACE_KIND, surface) == SPHERE:
        return True
    quadric = load_quadric(geometry, integer(geometry, table.SURFACE_ROW, surface))
    return quadric[12] >= 0.0 and quadric[13] >= 0.0 and quadric[14] >= 0.0


@inline
def _end_of_lane(
    lanes: Floats, i: int, one: bool, side: int, curved: int, lengths: Nearness, quadric: int, entry: int, body: int
) -> None:
    """Take the first end of a lane's spans, of which there is `one` at most, or there may be two."""
    in1, out1, in2, out2, a1, b1, a2, b2, some, more = span_lane(lanes, i, side, curved)
    more &= not one
    t_min, t_max = lanes[T_MIN + i], lanes[T_MAX + i]
    c1 = some & (in1 > t_min) & (in1 < t_max)
    c2 = some & (out1 > t_min) & (out1 < t_max)
    c3 = more & (in2 > t_min) & (in2 < t_max)
    c4 = more & (out2 > t_min) & (out2 < t_max)
    t = in1 if c1 else (out1 if c2 else (in2 if c3 else (out2 if c4 else math.inf)))
    place = a1 if c1 else (b1 if c2 else (a2 if c3 else b2))
    off, far = lane_nearness(lanes, i, lengths)
    starts = (lanes[OWN + i] != 0.0) | (lanes[START + i] == quadric)
    near = some & (at_start(in1, starts, t_min, off) | at_start(out1, starts, t_min, off))
    near |= more & (at_start(in2, starts, t_min, off) | at_start(out2, starts, t_min, off))
    unsure = unsure_lane(lanes, i, off, far) | near | ((abs(t) > far) & (abs(t) < math.inf))
    lanes[DOUBT + i] = choose(unsure, 1.0, lanes[DOUBT + i])
    take(lanes, i, t, off, entry, body, place, 1.0, 1.0 if c1 | (~c2 & c3) else 0.0)


@helper
def cell_lanes(geometry: Geometry, lanes: Floats, cell: int, entry: int, body: int, first: int, last: int) -> None:
    """The first end of the spans of a cell within each lane's interval."""
    if face_lanes(geometry, lanes, cell, first, last) == 0:
        return
    side, curved = curved_side(geometry, cell), quadric_place(cell)
    lengths, quadric = lengths_of(geometry, table.CELL_LIMITS, cell), integer(geometry, table.CELL_QUADRIC, cell)
    quadric = quadric if quadric >= 0 else NO_PLACE - 9
    one = _has_one_span(geometry, cell)
    first, last = eights(first, last)
    if one:
        for i in range(first, last):
            _end_of_lane(lanes, i, True, side, curved, lengths, quadric, entry, body)
    else:
        for i in range(first, last):
            _end_of_lane(lanes, i, False, side, curved, lengths, quadric, entry, body)
