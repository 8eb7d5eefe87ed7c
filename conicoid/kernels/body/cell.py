"""The spans of a ray in a cell, from the crossings of the cell's faces.

A cell lies between planes and inside, or outside, of at most one quadric. The planes leave one span of a ray, from t_in
to t_out; of this the quadric's roots low < high leave the part between them, or the parts before and after. A contact
of zero length is no span. The rules have no branches, so that single rays and the lanes of packets share them.

Every end has the place of the face on which it lies: a row in the table of the cells' planes, `quadric_place` of a
cell, or `NO_PLACE` for an end at infinity.
"""

from __future__ import annotations

import math
from typing import Any, NamedTuple

from ..._jit.decorators import choose, helper, inline
from .. import tables as table
from ..faces import cell_face_and_side, cell_side, plane_face_and_side, plane_side
from ..ray import Ray, line_of
from ..surface.interval import Nearness, is_too_far, may_pass_start, may_swap, nearness_of
from ..surface.records import curved_roots, load_plane, plane_values
from ..tables import GROUP_SIZE, LINKS, Geometry, integer, length, whole


class PlaneSlab(NamedTuple):
    """The span that the planes so far leave of a ray, with the place of each end's face; empty if t_in >= t_out."""

    t_in: float
    t_out: float
    place_in: Any
    place_out: Any


class SpanPair(NamedTuple):
    """Up to two spans: the first exists if `some`, the second if `more`."""

    in1: float
    out1: float
    place_in1: Any
    place_out1: Any
    in2: float
    out2: float
    place_in2: Any
    place_out2: Any
    some: bool
    more: bool


@inline
def clip_slab(
    slab: PlaneSlab, height: float, rate: float, inner: bool, place: Any, off: float
) -> tuple[PlaneSlab, bool]:
    """Cut the slab by one more plane: (slab, rounding might have changed the order of two planes).

    Along the ray the plane's value is height + rate t. The cell is where that is negative if `inner`, else where it is
    positive. A ray within a plane is treated as if the plane lay an infinitesimal further along its normal. Keeps t_in
    the largest t of the planes entered and t_out the least t of the planes left, each with its plane's place. An empty
    slab stays empty.
    """
    # For a parallel plane rate = 0 and t is infinite or NaN; comparisons with NaN are false, so `close` is unset
    t, parallel = -height / rate, rate == 0.0
    outside = parallel & ((height <= 0.0) != inner)
    enters, leaves = ((rate < 0.0) == inner) & (not parallel), ((rate < 0.0) != inner) & (not parallel)
    # Only the end that this plane may move matters: planes entered compete for t_in, planes left for t_out
    close = abs(t - choose(enters, slab.t_in, slab.t_out)) <= off
    later, sooner = enters & (t > slab.t_in), leaves & (t < slab.t_out)
    # (inf, -inf) is empty, and no further plane makes it larger
    t_in = choose(outside, math.inf, choose(later, t, slab.t_in))
    t_out = choose(outside, -math.inf, choose(sooner, t, slab.t_out))
    place_in, place_out = place if later else slab.place_in, place if sooner else slab.place_out
    return PlaneSlab(t_in, t_out, place_in, place_out), close


@inline
def compose_spans(slab: PlaneSlab, low: float, high: float, crosses: bool, outside: bool, curved: Any) -> SpanPair:
    """Return the spans that a quadric leaves of a slab: `outside` of its roots, or between them.

    Where the ray does not cross the quadric, the whole slab is left if `outside`, else nothing. `curved` is the place
    of the quadric's face. Relies on low < high where the ray crosses. The spans are in order, of positive length, and
    within the slab.
    """
    t_in, t_out, place_in, place_out = slab
    between, beside = crosses & (not outside), crosses & outside
    by_low = between & (low >= t_in)
    in1, place_in1 = low if by_low else t_in, curved if by_low else place_in
    by_root = (between & (high <= t_out)) | (beside & (low <= t_out))
    out1, place_out1 = (high if between else low) if by_root else t_out, curved if by_root else place_out
    some = (in1 < out1) & (crosses | outside)
    # The part behind the quadric begins at its far root, or at the slab where that begins later
    in2, place_in2 = high if high >= t_in else t_in, curved if high >= t_in else place_in
    more = beside & (in2 < t_out) & (t_in < t_out)
    return SpanPair(in1, out1, place_in1, place_out1, in2, t_out, place_in2, place_out, some, more)


@inline
def spans_at_start(spans: SpanPair, own: Any, t_min: float, off: float) -> bool:
    """True if rounding might have moved an end of the spans past the ray's origin (`may_pass_start`).

    `own` is the place of the face on whose surface the ray starts; an end on another face at t = 0 is no start.
    """
    in1, out1, place_in1, place_out1, in2, out2, place_in2, place_out2, some, more = spans
    first = may_pass_start(in1, place_in1 == own, t_min, off) | may_pass_start(out1, place_out1 == own, t_min, off)
    second = may_pass_start(in2, place_in2 == own, t_min, off) | may_pass_start(out2, place_out2 == own, t_min, off)
    return (some & first) | (more & second)


@inline
def spans_unsure(
    slab: PlaneSlab,
    low: float,
    high: float,
    crosses: bool,
    unsure: bool,
    t_min: float,
    t_max: float,
    nearness: Nearness,
) -> bool:
    """True if rounding might change the spans of a cell within a ray's interval.

    `unsure` is True if it might change the order of two planes, or the roots of the quadric. A slab that is certainly
    empty, or certainly outside of the interval, is not doubtful, however close other crossings are.
    """
    t_in, t_out = slab.t_in, slab.t_out
    # The roots may also swap with an end that they do not cut: a touch there is no span
    close = may_swap(low, t_in, nearness) | may_swap(low, t_out, nearness)
    close |= may_swap(high, t_in, nearness) | may_swap(high, t_out, nearness)
    close |= is_too_far(low, nearness) | is_too_far(high, nearness)  # the side of such a root is not certain either
    close |= low == high  # a span that no two floats tell from a touch
    begins = (t_in < t_max) | may_swap(t_in, t_max, nearness)
    ends = (t_out > t_min) | may_swap(t_out, t_min, nearness)
    touches = may_swap(t_in, t_out, nearness)
    return (unsure | touches | (close & crosses)) & begins & ends & ((t_in < t_out) | touches)


# The spans of a cell from the tables

NO_PLACE = -1


class CellSpans(NamedTuple):
    """The spans of a ray in a cell: in1 < out1 <= in2 < out2, as far as their `number` goes."""

    number: int  # of spans: 0, 1 or 2
    in1: float
    out1: float
    place_in1: Any
    place_out1: Any
    in2: float
    out2: float
    place_in2: Any
    place_out2: Any
    unsure: bool  # rounding might change the spans within the interval


@inline
def quadric_place(cell: int) -> int:
    """Return the place of a cell's curved face."""
    return -2 - cell


@inline
def end_of(spans: CellSpans, end: int) -> tuple[float, Any]:
    """Return (t, place) of end 0, 1, 2 or 3; the ray enters at even ends and leaves at odd ones."""
    if end < 2:
        return (spans.in1, spans.place_in1) if end == 0 else (spans.out1, spans.place_out1)
    return (spans.in2, spans.place_in2) if end == 2 else (spans.out2, spans.place_out2)


# Cells of many planes
#
# Planes are in groups of up to four, four groups in a larger one, and so on: a tree, each branch before its parts. A
# ray passes over a group where surely none of its planes cuts the slab so far: their values, linear along the ray, are
# on the inner side at both ends by a margin. The margin covers rounding, and the doubt about the order of crossings. So
# only some groups about each end of the slab remain on every level. A ray at the 4,900 faces of a sphere of OpenSCAD
# with $fn = 100 takes a tenth of the time, in packets a sixth; at the 80,000 faces of $fn = 400 a seventieth.

MANY_PLANES = 32
FIRST_CUTS, FIRST_GROUPS = 8, 2
"""Planes in all directions, which cut first; they are in the first groups, which bound nothing."""
PLANE_ROUNDING = 2.0**-47
"""More than the relative rounding of the value of a plane at a point of a ray, as a share of the sizes."""


class PlaneGroup(NamedTuple):
    """Bounds of some planes of a cell: their outward unit normals n are in a box, their values at the anchor at most v.

    So at a distance q from the anchor no value is larger than v + n·q for the n in the box where that is largest.
    """

    nx: float  # the middle of the box of normals
    ny: float
    nz: float
    wx: float  # its half widths
    wy: float
    wz: float
    ax: float  # the anchor
    ay: float
    az: float
    v: float  # raised by more than any rounding of the numbers of the group


@inline
def groups_of(geometry: Geometry, cell: int) -> tuple[int, int]:
    """Return (first, end) of the groups of a cell's planes; none if it has few planes."""
    if length(geometry, table.CELL_GROUPS) == 0:
        return whole(0), whole(0)
    return integer(geometry, table.CELL_GROUPS, cell), integer(geometry, table.CELL_GROUPS, cell + 1)


@inline
def load_group(geometry: Geometry, group: int) -> PlaneGroup:
    """Return the bounds of a group."""
    at, t = geometry.places[table.GROUP_BOUNDS] + GROUP_SIZE * group, geometry.floats
    return PlaneGroup(
        t[at], t[at + 1], t[at + 2], t[at + 3], t[at + 4], t[at + 5], t[at + 6], t[at + 7], t[at + 8], t[at + 9]
    )


@inline
def plane_of_group(geometry: Geometry, group: int, k: int) -> int:
    """Return the number in its cell of plane k = 0..3 of a group, negative if there is none; those come last."""
    return integer(geometry, table.GROUP_PLANES, LINKS * group + k)


@inline
def groups_within(geometry: Geometry, group: int) -> int:
    """Return how many groups a branch has, itself included."""
    return integer(geometry, table.GROUP_PLANES, LINKS * group + LINKS - 1)


@inline
def most_of_group(group: PlaneGroup, x: float, y: float, z: float) -> float:
    """Return at least the largest value at a point of the planes of a group, as unit normals give it."""
    qx, qy, qz = x - group.ax, y - group.ay, z - group.az
    across = group.wx * abs(qx) + group.wy * abs(qy) + group.wz * abs(qz)
    return (group.nx * qx + group.ny * qy + group.nz * qz) + (across + group.v)


@inline
def slab_of(
    geometry: Geometry, cell: int, ray: Ray, inverse: float, nearness: Nearness
) -> tuple[PlaneSlab, bool, bool]:
    """Return (slab that the planes of a cell leave of a ray, rounding might change it, crossing of a plane unknown).

    It stops at a plane along the ray that leaves nothing, or among many planes when nothing is left: then no other
    plane matters.
    """
    begin, end = integer(geometry, table.CELL_FIRST, cell), integer(geometry, table.CELL_FIRST, cell + 1)
    if end - begin >= MANY_PLANES:
        return slab_of_many(geometry, cell, ray, inverse, nearness)
    # `unsure` is ignored later if the slab is certainly empty, `lost` never
    slab, unsure, lost = PlaneSlab(-math.inf, math.inf, whole(NO_PLACE), whole(NO_PLACE)), False, False
    for place in range(begin, end):
        slab, close, _, doubtful = _cut_slab(geometry, slab, place, ray, inverse, nearness)
        unsure |= close
        lost |= doubtful
        if slab.t_in == math.inf:
            break
    return slab, unsure, lost


@helper
def slab_of_many(
    geometry: Geometry, cell: int, ray: Ray, inverse: float, nearness: Nearness
) -> tuple[PlaneSlab, bool, bool]:
    """`slab_of` for a cell of many planes.

    The doubt does not depend on the order in which planes cut: only planes count that may cut the slab which all leave.
    """
    if nearness.off == 0.0:
        return _slab_of_ranks(geometry, cell, ray, inverse, nearness)
    slab, lost = PlaneSlab(-math.inf, math.inf, whole(NO_PLACE), whole(NO_PLACE)), False
    near = False, False
    ox, oy, oz, dx, dy, dz = line_of(ray)
    begin, (group, end) = integer(geometry, table.CELL_FIRST, cell), groups_of(geometry, cell)
    # First some planes in all directions, then one that is likely to cut at each end of what they leave
    for k in range(FIRST_CUTS + 2):
        if k < FIRST_CUTS:
            place = begin + plane_of_group(geometry, group + (k >> 2), k & 3)
        else:
            t = slab.t_in if k == FIRST_CUTS else slab.t_out
            place = begin + _likely_plane(geometry, group + FIRST_GROUPS, end, ox + t * dx, oy + t * dy, oz + t * dz)
        if (place != slab.place_in) & (place != slab.place_out):
            slab, near, doubtful = _cut_near_slab(geometry, slab, near, place, ray, inverse, nearness)
            lost |= doubtful
        if slab.t_in > slab.t_out + nearness.off:
            break  # surely empty
    margin = margin_of(slab, ray, nearness)
    group = next_group(geometry, group + FIRST_GROUPS, end, slab, ray, margin)
    while (group < end) & (slab.t_in <= slab.t_out + nearness.off):
        for k in range(4):
            number = plane_of_group(geometry, group, k)
            if number < 0:
                break
            place = begin + number
            if (place == slab.place_in) | (place == slab.place_out) | is_beside(geometry, slab, place, ray, margin):
                continue
            slab, near, doubtful = _cut_near_slab(geometry, slab, near, place, ray, inverse, nearness)
            lost |= doubtful
            margin = margin_of(slab, ray, nearness)
        group = next_group(geometry, group + 1, end, slab, ray, margin)
    if lost:
        lost = slab.t_in <= slab.t_out + nearness.off and _is_lost(geometry, cell, slab, ray, inverse, nearness)
    return slab, near[0] | near[1], lost


@inline
def _cut_near_slab(
    geometry: Geometry, slab: PlaneSlab, near: tuple[bool, bool], place: int, ray: Ray, inverse: float,
    nearness: Nearness,
) -> tuple[PlaneSlab, tuple[bool, bool], bool]:  # fmt: skip
    """`_cut_slab`; a plane whose crossing is unknown cuts nothing.

    `near` holds whether another plane may cut the ray at t_in, and whether at t_out.
    """
    cut, close, enters, doubtful = _cut_slab(geometry, slab, place, ray, inverse, nearness)
    if doubtful:
        return slab, near, True
    # Planes near an end that has moved are no nearer to the new end than the old end is
    near_in = (close & enters) | (near[0] & (cut.t_in == slab.t_in))
    near_out = (close & (not enters)) | (near[1] & (cut.t_out == slab.t_out))
    return cut, (near_in, near_out), False


@helper
def _is_lost(geometry: Geometry, cell: int, slab: PlaneSlab, ray: Ray, inverse: float, nearness: Nearness) -> bool:
    """True if a plane whose crossing is unknown may cut the slab that the other planes leave.

    The crossing with a plane along the ray is unknown, and does not matter far beside the plane.
    """
    begin, (group, end) = integer(geometry, table.CELL_FIRST, cell), groups_of(geometry, cell)
    margin, first = margin_of(slab, ray, nearness), group + FIRST_GROUPS
    while group < end:
        for k in range(4):
            number = plane_of_group(geometry, group, k)
            if number < 0:
                break
            surface = integer(geometry, table.PLANE_SURFACE, begin + number)
            if (
                not is_beside(geometry, slab, begin + number, ray, margin)
                and plane_values(geometry, surface, ray, inverse)[2]
            ):
                return True
        group += 1
        if group >= first:
            group = next_group(geometry, group, end, slab, ray, margin)
    return False


@inline
def margin_of(slab: PlaneSlab, ray: Ray, nearness: Nearness) -> float:
    """Return how far inside of a plane, whose normal has length 1, the ends of a slab are if it surely does not cut."""
    along, far = abs(ray.dx) + abs(ray.dy) + abs(ray.dz), abs(ray.ox) + abs(ray.oy) + abs(ray.oz)
    return along * nearness.off + PLANE_ROUNDING * (far + along * max(abs(slab.t_in), abs(slab.t_out)))


@inline
def next_group(geometry: Geometry, group: int, end: int, slab: PlaneSlab, ray: Ray, margin: float) -> int:
    """Return the first of the groups from `group` on with a plane that may cut a slab; `end` if there is none."""
    ox, oy, oz, dx, dy, dz = line_of(ray)
    t_in, t_out = slab.t_in, slab.t_out
    while group < end:
        bounds = load_group(geometry, group)
        at_in = most_of_group(bounds, ox + t_in * dx, oy + t_in * dy, oz + t_in * dz)
        at_out = most_of_group(bounds, ox + t_out * dx, oy + t_out * dy, oz + t_out * dz)
        # Values at an infinite end may be NaN: then the planes cut. Normals of records have lengths from 1/2 on
        if not ((at_in < -2.0 * margin) & (at_out < -2.0 * margin)):
            return group
        group += groups_within(geometry, group)
    return end


@inline
def _slab_of_ranks(
    geometry: Geometry, cell: int, ray: Ray, inverse: float, nearness: Nearness
) -> tuple[PlaneSlab, bool, bool]:
    """`slab_of_many` where t is exact: the planes are canonical ones, or none (queries/exact/ranks.py).

    So the groups do not hold for them. Of planes at one t the first counts, as in other cells.
    """
    slab, lost = PlaneSlab(-math.inf, math.inf, whole(NO_PLACE), whole(NO_PLACE)), False
    for place in range(integer(geometry, table.CELL_FIRST, cell), integer(geometry, table.CELL_FIRST, cell + 1)):
        surface = integer(geometry, table.PLANE_SURFACE, place)
        plane = load_plane(geometry, integer(geometry, table.SURFACE_ROW, surface))
        if (plane.nx != 0.0) | (plane.ny != 0.0):
            slab, _, _, doubtful = _cut_slab(geometry, slab, place, ray, inverse, nearness)
            lost |= doubtful
            if slab.t_in == math.inf:
                break
    return slab, False, lost


@inline
def _likely_plane(geometry: Geometry, first: int, end: int, x: float, y: float, z: float) -> int:
    """Return the number in its cell of a plane whose value at a point is likely to be the largest of some branches."""
    while True:
        chosen, most, group = first, -math.inf, first
        while group < end:
            bounds, size = load_group(geometry, group), groups_within(geometry, group)
            value = bounds.nx * (x - bounds.ax) + bounds.ny * (y - bounds.ay) + bounds.nz * (z - bounds.az) + bounds.v
            if value > most:
                chosen, most = group, value
            group += size
        if groups_within(geometry, chosen) == 1:
            return plane_of_group(geometry, chosen, 0)
        first, end = chosen + 1, chosen + groups_within(geometry, chosen)


@inline
def is_beside(geometry: Geometry, slab: PlaneSlab, place: int, ray: Ray, margin: float) -> bool:
    """True if the plane of a place surely does not cut a slab."""
    ox, oy, oz, dx, dy, dz = line_of(ray)
    surface = integer(geometry, table.PLANE_SURFACE, place)
    nx, ny, nz, above, ax, ay, az = load_plane(geometry, integer(geometry, table.SURFACE_ROW, surface))
    height = (nx * (ox - ax) + ny * (oy - ay) + nz * (oz - az)) + above
    rate = nx * dx + ny * dy + nz * dz
    sense = 1.0 if plane_side(geometry, place) > 0 else -1.0
    least = -(margin + PLANE_ROUNDING * ((abs(ax) + abs(ay) + abs(az)) + abs(above)))
    return (sense * (height + rate * slab.t_in) < least) & (sense * (height + rate * slab.t_out) < least)


@inline
def _cut_slab(
    geometry: Geometry, slab: PlaneSlab, place: int, ray: Ray, inverse: float, nearness: Nearness
) -> tuple[PlaneSlab, bool, bool, bool]:
    """Cut the slab by the plane of a place: (slab, rounding might change it, ray enters there, crossing unknown)."""
    surface, inner = integer(geometry, table.PLANE_SURFACE, place), plane_side(geometry, place) > 0
    height, rate, doubtful = plane_values(geometry, surface, ray, inverse)
    slab, close = clip_slab(slab, height, rate, inner, whole(place), nearness.off)
    return slab, close, (rate < 0.0) == inner, doubtful


@helper
def cell_spans(geometry: Geometry, cell: int, ray: Ray, inverse: float) -> CellSpans:
    """Return the spans of a ray in a cell, over the whole line, each end with the place of its face.

    Relies on `inverse` = 1 / d·d. Unless `unsure`, the ends within the interval have the order of the exact ends, and
    lie within `nearness.off` of them.
    """
    nearness = nearness_of(geometry, table.CELL_LIMITS, cell, ray, inverse)
    slab, unsure, lost = slab_of(geometry, cell, ray, inverse, nearness)
    lost |= nearness.far < 0.0
    quadric, low, high, crosses, outside = integer(geometry, table.CELL_QUADRIC, cell), math.inf, math.inf, False, True
    # The quadric last, and only where the planes leave something: it costs more than they do
    if quadric >= 0 and slab.t_in < slab.t_out:
        low, high, outside, crosses, doubtful = curved_roots(geometry, quadric, ray, inverse)
        outside = outside != (cell_side(geometry, cell) < 0)
        unsure |= doubtful
    unsure = lost | spans_unsure(slab, low, high, crosses, unsure, ray.t_min, ray.t_max, nearness)
    if not crosses:  # an early out, with the result of `compose_spans`
        t_in, t_out, place_in, place_out = slab
        there = (t_in < t_out) & outside
        return CellSpans(
            1 if there else 0, t_in, t_out, place_in, place_out, t_in, t_out, place_in, place_out, unsure
        )  # fmt: skip
    in1, out1, a1, b1, in2, out2, a2, b2, some, more = compose_spans(
        slab, low, high, crosses, outside, whole(quadric_place(cell))
    )
    if some:
        return CellSpans(2 if more else 1, in1, out1, a1, b1, in2, out2, a2, b2, unsure)
    return CellSpans(1 if more else 0, in2, out2, a2, b2, in2, out2, a2, b2, unsure)


@inline
def place_face(geometry: Geometry, place: int) -> tuple[int, int, int]:
    """Return (surface, face number, side) of a place; side +1 where the surface's gradient points out of the cell."""
    if place < 0:
        cell = -2 - place
        face, side = cell_face_and_side(geometry, cell)
        return integer(geometry, table.CELL_QUADRIC, cell), face, side
    face, side = plane_face_and_side(geometry, place)
    return integer(geometry, table.PLANE_SURFACE, place), face, side
