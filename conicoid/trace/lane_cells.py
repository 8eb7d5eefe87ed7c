"""Balls and cells met by the lanes of a packet.

The lanes go through the same formulas as single rays, which the compiler turns into vector
instructions: functions are merged into the loop, a surface's record is a tuple read before it, and
selects take the place of branches. The few lanes whose terms cancel are done again one by one. So a
ray gives the same hit to the bit, whichever way it goes.

Every function works on lanes first..last, multiples of eight.
"""

from __future__ import annotations

import math

from ..geometry import tables as table
from ..geometry.cell import NO_PLACE, load_plane, load_quadric, load_sphere, quadric_place
from ..geometry.plane import Plane, careful_plane, plain_plane
from ..geometry.quadric import Quadric, Sphere, careful_quadratic, quadratic_on_ray, settled_roots, sphere_roots
from ..geometry.tables import SPHERE, Floats, Geometry, integer
from ..jit import helper, inline
from .lanes import (
    DISCRIMINANT,
    DX,
    DY,
    DZ,
    FLAG,
    FOOT,
    HIGH,
    INVERSE,
    LOW,
    OX,
    OY,
    OZ,
    PLACE_IN,
    PLACE_OUT,
    START,
    T_IN,
    T_MAX,
    T_MIN,
    T_OUT,
    A,
    B,
    C,
    eights,
    take,
)  # fmt: skip

SpanLanes = tuple[float, float, float, float, float, float, float, float, bool, bool]


@helper
def ball_lanes(geometry: Geometry, lanes: Floats, surface: int, entry: int, body: int, first: int, last: int) -> None:
    """The first crossing of a ball."""
    first, last = eights(first, last)
    sphere = load_sphere(geometry, integer(geometry, table.SURFACE_ROW, surface))
    for i in range(first, last):
        low, high, _, crosses = sphere_roots(
            sphere, lanes[OX + i], lanes[OY + i], lanes[OZ + i], lanes[DX + i], lanes[DY + i], lanes[DZ + i],
            lanes[INVERSE + i], lanes[START + i] == surface,
        )  # fmt: skip
        enters = crosses & (low > lanes[T_MIN + i]) & (low < lanes[T_MAX + i])
        leaves = crosses & (high > lanes[T_MIN + i]) & (high < lanes[T_MAX + i])
        t = low if enters else (high if leaves else math.inf)
        take(lanes, i, t, entry, body, NO_PLACE, 1.0, 1.0 if enters else 0.0)


@helper
def _cut_lanes(lanes: Floats, surface: int, side: int, place: int, first: int, last: int) -> None:
    """Cut the spans by a plane whose height and rate stand in A and B."""
    first, last = eights(first, last)
    for i in range(first, last):
        rate = lanes[B + i]
        height = 0.0 if lanes[START + i] == surface else lanes[A + i]
        t = -height / rate
        parallel = rate == 0.0
        outside = parallel & ((height <= 0.0) != (side > 0))
        falls = ((rate < 0.0) == (side > 0)) & ~parallel
        rises = ((rate < 0.0) != (side > 0)) & ~parallel
        later = falls & (t > lanes[T_IN + i])
        sooner = rises & (t < lanes[T_OUT + i])
        t_in = t if later else lanes[T_IN + i]
        lanes[T_IN + i] = math.inf if outside else t_in
        lanes[T_OUT + i] = t if sooner else lanes[T_OUT + i]
        lanes[PLACE_IN + i] = place if later else lanes[PLACE_IN + i]
        lanes[PLACE_OUT + i] = place if sooner else lanes[PLACE_OUT + i]


@inline
def _plane_lanes(lanes: Floats, plane: Plane, surface: int, side: int, place: int, first: int, last: int) -> None:
    """Cut the lanes' spans [T_IN, T_OUT] by a plane of a cell."""
    again = 0
    for i in range(first, last):
        height, rate, cancels = plain_plane(
            plane, lanes[OX + i], lanes[OY + i], lanes[OZ + i], lanes[DX + i], lanes[DY + i], lanes[DZ + i]
        )
        lanes[A + i], lanes[B + i] = height, rate
        lanes[FLAG + i] = 1.0 if cancels else 0.0
        again += 1 if cancels else 0
    if again > 0:
        for i in range(first, last):
            if lanes[FLAG + i] == 1.0:
                lanes[A + i], lanes[B + i] = careful_plane(
                    plane, lanes[OX + i], lanes[OY + i], lanes[OZ + i], lanes[DX + i], lanes[DY + i], lanes[DZ + i]
                )
    _cut_lanes(lanes, surface, side, place, first, last)


@helper
def _settle_lanes(lanes: Floats, surface: int, first: int, last: int) -> None:
    """Roots from the terms in A, B, C, DISCRIMINANT and FOOT."""
    first, last = eights(first, last)
    for i in range(first, last):
        low, high, outside, crosses = settled_roots(
            lanes[A + i],
            lanes[B + i],
            lanes[C + i],
            lanes[DISCRIMINANT + i],
            lanes[FOOT + i],
            lanes[START + i] == surface,
        )
        lanes[LOW + i], lanes[HIGH + i] = low, high
        lanes[FLAG + i] = (1.0 if outside else 0.0) + (2.0 if crosses else 0.0)


@inline
def _quadric_lanes(lanes: Floats, quadric: Quadric, surface: int, first: int, last: int) -> None:
    """The lanes' roots into LOW and HIGH; FLAG: 1 outside is inside, 2 it crosses."""
    again = 0
    for i in range(first, last):
        a, b, c, discriminant, foot, cancels = quadratic_on_ray(
            quadric, lanes[OX + i], lanes[OY + i], lanes[OZ + i], lanes[DX + i], lanes[DY + i], lanes[DZ + i],
            lanes[INVERSE + i], lanes[START + i] == surface,
        )  # fmt: skip
        lanes[A + i], lanes[B + i], lanes[C + i], lanes[DISCRIMINANT + i], lanes[FOOT + i] = a, b, c, discriminant, foot
        lanes[FLAG + i] = 1.0 if cancels else 0.0
        again += 1 if cancels else 0
    if again > 0:
        for i in range(first, last):
            if lanes[FLAG + i] == 1.0:
                lanes[A + i], lanes[B + i], lanes[C + i], lanes[DISCRIMINANT + i] = careful_quadratic(
                    quadric, lanes[OX + i], lanes[OY + i], lanes[OZ + i], lanes[DX + i], lanes[DY + i], lanes[DZ + i],
                    lanes[FOOT + i],
                )  # fmt: skip
    _settle_lanes(lanes, surface, first, last)


@inline
def _sphere_lanes(lanes: Floats, sphere: Sphere, surface: int, first: int, last: int) -> None:
    """As `_quadric_lanes`, for the sphere of a cut ball."""
    for i in range(first, last):
        low, high, outside, crosses = sphere_roots(
            sphere, lanes[OX + i], lanes[OY + i], lanes[OZ + i], lanes[DX + i], lanes[DY + i], lanes[DZ + i],
            lanes[INVERSE + i], lanes[START + i] == surface,
        )  # fmt: skip
        lanes[LOW + i], lanes[HIGH + i] = low, high
        lanes[FLAG + i] = (1.0 if outside else 0.0) + (2.0 if crosses else 0.0)


@helper
def face_lanes(geometry: Geometry, lanes: Floats, cell: int, first: int, last: int) -> int:
    """The span inside all planes of a cell, the roots of its quadric. Returns how many lanes may be inside."""
    first, last = eights(first, last)
    for i in range(first, last):
        lanes[T_IN + i], lanes[T_OUT + i] = -math.inf, math.inf
        lanes[PLACE_IN + i], lanes[PLACE_OUT + i] = NO_PLACE, NO_PLACE
        lanes[FLAG + i] = 1.0
    for place in range(integer(geometry, table.CELL_FIRST, cell), integer(geometry, table.CELL_FIRST, cell + 1)):
        surface = integer(geometry, table.PLANE_SURFACE, place)
        plane = load_plane(geometry, integer(geometry, table.SURFACE_ROW, surface))
        _plane_lanes(lanes, plane, surface, integer(geometry, table.PLANE_SIDE, place), place, first, last)
    some = 0
    for i in range(first, last):
        low = lanes[T_IN + i] if lanes[T_IN + i] > lanes[T_MIN + i] else lanes[T_MIN + i]
        some += 1 if (low < lanes[T_OUT + i]) & (lanes[T_IN + i] < lanes[T_MAX + i]) else 0
        lanes[FLAG + i] = 1.0
    surface = integer(geometry, table.CELL_QUADRIC, cell)
    if some == 0 or surface < 0:
        return some
    if integer(geometry, table.SURFACE_KIND, surface) == SPHERE:
        sphere = load_sphere(geometry, integer(geometry, table.SURFACE_ROW, surface))
        _sphere_lanes(lanes, sphere, surface, first, last)
    else:
        quadric = load_quadric(geometry, integer(geometry, table.SURFACE_ROW, surface))
        _quadric_lanes(lanes, quadric, surface, first, last)
    return some


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


@helper
def cell_lanes(geometry: Geometry, lanes: Floats, cell: int, entry: int, body: int, first: int, last: int) -> None:
    """The first end of the spans of a cell within each lane's interval."""
    if face_lanes(geometry, lanes, cell, first, last) == 0:
        return
    side, curved = curved_side(geometry, cell), quadric_place(cell)
    first, last = eights(first, last)
    for i in range(first, last):
        in1, out1, in2, out2, a1, b1, a2, b2, some, more = span_lane(lanes, i, side, curved)
        t_min, t_max = lanes[T_MIN + i], lanes[T_MAX + i]
        c1 = some & (in1 > t_min) & (in1 < t_max)
        c2 = some & (out1 > t_min) & (out1 < t_max)
        c3 = more & (in2 > t_min) & (in2 < t_max)
        c4 = more & (out2 > t_min) & (out2 < t_max)
        t = in1 if c1 else (out1 if c2 else (in2 if c3 else (out2 if c4 else math.inf)))
        place = a1 if c1 else (b1 if c2 else (a2 if c3 else b2))
        take(lanes, i, t, entry, body, place, 1.0, 1.0 if c1 | (~c2 & c3) else 0.0)
