"""Lower bounds of the distance to the nearest wall for packets of 64 points: safety distances.

The formulas are those of neighbourhood.py, run over the lanes of a block of rows of 64 floats. Packets go through the
tree, the nearest boxes first.

User: distances on slices and grids of points; factor over single points on 1,000 bodies: 5 to 6 on slices, 2 on grids,
1.2 on flat lists of a grid's points (processor time, one thread, 2026-11-28).
"""

from __future__ import annotations

import math
from typing import Any, NamedTuple

import numpy as np

from ..._jit.decorators import allocator, choose, helper, inline, kernel
from .. import tables as table
from ..bvh.culling import extent
from ..bvh.walk import LeafItem, leaf_at, leaf_ball, leaf_item, leaf_range
from ..faces import cell_side, plane_side
from ..packet.booleans import MOST
from ..packet.lanes import LANES, packet_row
from ..programs import LeafBounds, cell_of_leaf, gates_of, leaf_bounds, leaves_of, root_of, rows_of_leaves
from ..surface.quadric import SphereRecord, sign_everywhere
from ..surface.records import load_plane, load_quadric, load_sphere
from ..tables import (
    CELL as CELLS,
    PLANE,
    POLYGON,
    REGION,
    SHEET,
    SPHERE,
    Floats,
    Geometry,
    Ints,
    integer,
    is_halted,
    length,
    real,
)
from .form import Axes, SurfaceForm, form_of_plane, form_of_quadric, form_of_sphere, principal_axes
from .nearest_walls import PointBox, begin_search, distance_to_ball, distance_to_node, next_near_leaf, polygon_distance
from .neighbourhood import (
    LESS,
    Neighbourhood,
    bisection_bound,
    entry_bound,
    leaf_box,
    less_rounding,
    new_room,
    plain_bound,
    plane_bound,
    sphere_bound,
)
from .secular import (
    STEPS,
    PositiveSecular,
    RootSearch,
    first_guess,
    next_step,
    positive_secular,
    root_distance,
    safe_root,
)

# Begins of the rows
(
    X, Y, Z, BEST, FOUND, BOX_DISTANCE, NEAR, BOUND, CELL, FACE, PLAIN, LEAF, VALUE, OFF, GX, GY, GZ, STEEP, W, LOW,
    HIGH, DONE, F, G0, G1, G2, A0, A1, A2, POLE,
) = (np.uint64(row) for row in range(0, 30 * LANES, LANES))  # fmt: skip
"""The points; walls beyond BEST do not matter; FOUND is 1 where a wall may be as near as BEST. For an entry: lower
bounds by its boxes and its ball (BOX_DISTANCE, NEAR), its own bound, that of a cell, of a face, of a quadric by its
value alone, of the box of a leaf. For a quadric: its form, the search for its nearest point, its equation."""
GATES = 30 * LANES
SIZE = GATES + MOST * LANES
EVERY = np.uint64(LANES)


class SafetyLanes(NamedTuple):
    """Memory of one thread."""

    room: Floats  # see `X`
    which: Ints  # the number of each lane's point, -1 for none
    single: Neighbourhood  # for points that are handled one by one


@allocator
def new_memory(geometry: Geometry) -> SafetyLanes:
    """Return memory for one thread."""
    return SafetyLanes(np.zeros(SIZE), np.empty(LANES, np.int32), new_room(geometry, np.zeros(1, np.int32)))


@helper
def put_points(memory: SafetyLanes, points: Floats, reach: Floats, packet: int, width: int) -> int:
    """Load the points of a packet into lanes; return how many.

    Lanes without a point repeat the first one, and seek nothing.
    """
    room, which, count, lanes = memory.room, memory.which, len(points), 0
    some, _ = packet_row(packet, 0, width, count)
    if some >= count:
        return 0
    for row in range(8):
        first, n = packet_row(packet, row, width, count)
        for k in range(8):
            lane, i = np.uint64(8 * row + k), first + k if k < n else some
            # Idle lanes repeat a real point, so that they widen no box
            room[X + lane], room[Y + lane], room[Z + lane] = points[i, 0], points[i, 1], points[i, 2]
            # -1: no bound is at most this, so that idle lanes never ask for more work
            room[BEST + lane], room[FOUND + lane] = reach[i] if k < n else -1.0, 0.0
            which[8 * row + k] = i if k < n else -1
        lanes += n
    return lanes


@inline
def box_of_lanes(room: Floats) -> PointBox:
    """Return the box around the points."""
    low_x, high_x = extent(room, X)
    low_y, high_y = extent(room, Y)
    low_z, high_z = extent(room, Z)
    return PointBox(low_x, low_y, low_z, high_x, high_y, high_z)


@inline
def farthest_bound(room: Floats) -> float:
    """Return the distance beyond which walls do not matter to any lane."""
    _, most = extent(room, BEST)
    return most


@inline
def put_form(room: Floats, i: Any, form: SurfaceForm) -> None:
    """Write the part of a quadric's form that depends on the point."""
    room[VALUE + i], room[OFF + i], room[STEEP + i] = form.value, form.off, form.steep
    room[GX + i], room[GY + i], room[GZ + i] = form.gx, form.gy, form.gz


@inline
def form_of_lane(room: Floats, i: Any, same: SurfaceForm) -> SurfaceForm:
    """Return the form in a lane; `same` is the quadric's form at any point."""
    return SurfaceForm(
        room[VALUE + i], room[OFF + i], room[GX + i], room[GY + i], room[GZ + i],
        same.xx, same.yy, same.zz, same.xy, same.xz, same.yz, same.size, room[STEEP + i],
    )  # fmt: skip


@inline
def put_equation(room: Floats, i: Any, e: PositiveSecular) -> None:
    """Write the secular equation of a lane."""
    room[F + i], room[G0 + i], room[G1 + i], room[G2 + i] = e.value, e.g0, e.g1, e.g2
    room[A0 + i], room[A1 + i], room[A2 + i], room[POLE + i] = e.a0, e.a1, e.a2, e.pole


@inline
def equation_of_lane(room: Floats, i: Any) -> PositiveSecular:
    """Return the secular equation of a lane."""
    return PositiveSecular(
        room[F + i], room[G0 + i], room[G1 + i], room[G2 + i], room[A0 + i], room[A1 + i], room[A2 + i], room[POLE + i]
    )


@inline
def put_search(room: Floats, i: Any, at: RootSearch) -> None:
    """Write the state of a lane's search."""
    room[W + i], room[LOW + i], room[HIGH + i], room[DONE + i] = at.w, at.low, at.high, at.done


@inline
def search_of_lane(room: Floats, i: Any) -> RootSearch:
    """Return the state of a lane's search."""
    return RootSearch(room[W + i], room[LOW + i], room[HIGH + i], room[DONE + i])


@inline
def keep_bounds(room: Floats) -> None:
    """Keep the bounds of an entry in lanes where they are at most the best so far."""
    for i in range(EVERY):
        # All bounds hold, so that the largest is the best
        bound = max(room[BOUND + i], room[NEAR + i])
        nearer = bound <= room[BEST + i]
        room[BEST + i] = choose(nearer, bound, room[BEST + i])
        room[FOUND + i] = choose(nearer, 1.0, room[FOUND + i])


@inline
def keep_bound(room: Floats, i: Any, bound: float) -> None:
    """Keep the bound of an entry in one lane if it is at most the best so far."""
    bound = max(bound, room[NEAR + i])
    if bound <= room[BEST + i]:
        room[BEST + i], room[FOUND + i] = bound, 1.0


@inline
def lane_bound(room: Floats, i: Any) -> float:
    """Return the bound of a lane; infinite if no wall is within reach."""
    return room[BEST + i] if room[FOUND + i] == 1.0 else math.inf


# Signed bounds of the distances from 64 points to a surface


@helper
def _go_on(room: Floats) -> None:
    """Step all lanes until each is done, or for the most steps."""
    for _ in range(STEPS):
        done = 0.0
        for i in range(EVERY):
            at = next_step(equation_of_lane(room, i), search_of_lane(room, i))
            put_search(room, i, at)
            done += at.done
        if done == 64.0:
            break


@helper
def _solve(room: Floats, same: SurfaceForm, axes: Axes, scale: float) -> None:
    """Compute FACE, without a sign, from the nearest points of a quadric where PLAIN is less than BEST; else NaN."""
    for i in range(EVERY):
        e = positive_secular(form_of_lane(room, i, same), axes, scale, room[PLAIN + i])
        put_equation(room, i, e)
        put_search(room, i, first_guess(e))
        # Lanes on the wall, or too far away to matter, count as done at once
        room[DONE + i] = choose((room[PLAIN + i] > 0.0) & (room[PLAIN + i] < room[BEST + i]), 0.0, 1.0)
    _go_on(room)
    # Once more for f less its error bound (`quadric_bound`)
    for i in range(EVERY):
        e = equation_of_lane(room, i)
        room[F + i] = less_rounding(form_of_lane(room, i, same), e, room[W + i], scale)
        room[LOW + i], room[HIGH + i] = 0.0, math.inf
        certain = (room[DONE + i] == 1.0) & (room[F + i] > 0.0)
        matters = (room[PLAIN + i] > 0.0) & (room[PLAIN + i] < room[BEST + i])
        room[DONE + i] = choose(certain & matters, 0.0, 1.0)
        room[BOUND + i] = choose(certain, 1.0, 0.0)
    _go_on(room)
    for i in range(EVERY):
        e = equation_of_lane(room, i)
        w = safe_root(e, room[W + i])
        # Only an equation that was solved to its end proves a bound
        proof = (room[BOUND + i] == 1.0) & (room[DONE + i] == 1.0) & (w < math.inf)
        room[FACE + i] = choose(proof, max(room[PLAIN + i], root_distance(e, w) * LESS), math.nan)


@helper
def _quadric(geometry: Geometry, row: int, room: Floats) -> None:
    """Compute FACE of a quadric, with its sign."""
    quadric, near = load_quadric(geometry, row), 0
    one = sign_everywhere(quadric)
    if one != 0.0:
        for i in range(EVERY):
            room[FACE + i] = one * math.inf
        return
    for i in range(EVERY):
        form = form_of_quadric(quadric, room[X + i], room[Y + i], room[Z + i])
        put_form(room, i, form)
        plain = plain_bound(form)
        room[PLAIN + i], room[FACE + i] = plain, plain
        # The cheap bound first: the equation is solved only where it leaves a wall within reach
        near += 1 if (plain > 0.0) & (plain < room[BEST + i]) else 0
    if near > 0:
        # The second-order terms do not depend on the point: one set of axes serves all lanes
        same = form_of_quadric(quadric, room[X], room[Y], room[Z])
        axes = principal_axes(same.xx, same.yy, same.zz, same.xy, same.xz, same.yz)
        scale = 1.0 / same.size if same.size > 0.0 else 1.0
        _solve(room, same, axes, scale)
        for i in range(EVERY):
            plain = room[PLAIN + i]
            solved = (plain > 0.0) & (plain < room[BEST + i])
            if solved and not room[FACE + i] >= 0.0:  # NaN: no proof in the few steps
                room[FACE + i] = bisection_bound(form_of_lane(room, i, same), axes, scale, plain)
        for i in range(EVERY):
            plain = room[PLAIN + i]
            solved = (plain > 0.0) & (plain < room[BEST + i])
            room[FACE + i] = choose(solved, room[FACE + i], plain)
    for i in range(EVERY):
        # The sign is that of the surface's value: negative inside
        room[FACE + i] = math.copysign(room[FACE + i], room[VALUE + i])


@helper
def surface_of_lanes(geometry: Geometry, surface: int, room: Floats) -> None:
    """Compute FACE: signed bounds of the distances to a surface, as `surface_bound` with enough = BEST."""
    kind, row = integer(geometry, table.SURFACE_KIND, surface), integer(geometry, table.SURFACE_ROW, surface)
    if kind == PLANE:
        plane = load_plane(geometry, row)
        for i in range(EVERY):
            room[FACE + i] = plane_bound(form_of_plane(plane, room[X + i], room[Y + i], room[Z + i]))
    elif kind == SPHERE:
        sphere = load_sphere(geometry, row)
        for i in range(EVERY):
            room[FACE + i] = sphere_bound(form_of_sphere(sphere, room[X + i], room[Y + i], room[Z + i]), sphere.radius)
    else:
        _quadric(geometry, row, room)


@inline
def lane_index(i: int) -> Any:
    """Return the number of a lane as an unsigned integer, as rows are indexed."""
    return np.uint64(i)


# Bounds of the distances from 64 points to the walls of an entry


@inline
def _largest(room: Floats, side: float) -> None:
    """Raise each lane's CELL to side * FACE."""
    for i in range(EVERY):
        room[CELL + i] = max(room[CELL + i], side * room[FACE + i])


@helper
def cell_of_lanes(geometry: Geometry, cell: int, room: Floats) -> None:
    """Compute CELL: signed bounds of the distances to the walls of a cell, negative inside."""
    quadric = integer(geometry, table.CELL_QUADRIC, cell)
    for i in range(EVERY):
        room[CELL + i] = -math.inf
    for slot in range(integer(geometry, table.CELL_FIRST, cell), integer(geometry, table.CELL_FIRST, cell + 1)):
        surface_of_lanes(geometry, integer(geometry, table.PLANE_SURFACE, slot), room)
        _largest(room, float(plane_side(geometry, slot)))
    if quadric >= 0:
        surface_of_lanes(geometry, quadric, room)
        _largest(room, float(cell_side(geometry, cell)))


@inline
def _feed(room: Floats, row: int, gate: int, sign: float, least: bool) -> None:
    """Feed a row of inputs to a gate: unions keep the least, intersections the largest."""
    source, target = np.uint64(row), np.uint64(GATES + gate * LANES)
    if least:
        for i in range(EVERY):
            room[target + i] = min(room[target + i], sign * room[source + i])
    else:
        for i in range(EVERY):
            room[target + i] = max(room[target + i], sign * room[source + i])


@helper
def _leaf_of_lanes(geometry: Geometry, bounds: LeafBounds, first: int, leaf: int, room: Floats) -> None:
    """Compute CELL: signed bounds of a leaf, from its box and, where that is near, its cell.

    `first` is the first leaf of the program.
    """
    near = 0
    for i in range(EVERY):
        distance = leaf_box(geometry, bounds, leaf - first, room[X + i], room[Y + i], room[Z + i])
        room[LEAF + i] = distance
        near += 1 if distance < room[BEST + i] else 0
    if near > 0:
        cell_of_lanes(geometry, cell_of_leaf(geometry, leaf), room)
        for i in range(EVERY):
            inner, distance = room[CELL + i], room[LEAF + i]
            room[CELL + i] = max(distance, inner) if distance > 0.0 else inner
    else:
        for i in range(EVERY):
            room[CELL + i] = room[LEAF + i]


@helper
def program_of_lanes(geometry: Geometry, program: int, room: Floats) -> None:
    """Compute the root's row of GATES: signed bounds of a region as by `program_bound`, before the root's negation."""
    first, last = gates_of(geometry, program)
    for gate in range(first, last):
        # Neutral for the least (unions need one input) and for the largest
        none = math.inf if integer(geometry, table.GATE_NEED, gate) == 1 else -math.inf
        target = np.uint64(GATES + (gate - first) * LANES)
        for i in range(EVERY):
            room[target + i] = none
    bounds, row = leaf_bounds(geometry, program), rows_of_leaves(geometry, program)
    begin, end = leaves_of(geometry, program)
    for leaf in range(begin, end):
        _leaf_of_lanes(geometry, bounds, begin, leaf, room)
        gate = integer(geometry, table.LEAF_GATE, leaf + row)
        negated = integer(geometry, table.LEAF_NEGATED, leaf + row) == 1
        least = integer(geometry, table.GATE_NEED, gate) == 1
        _feed(room, int(CELL), gate - first, -1.0 if negated else 1.0, least)
    for gate in range(last - 1, first, -1):
        parent, negated = integer(geometry, table.GATE_PARENT, gate), integer(geometry, table.GATE_NEGATED, gate) == 1
        least = integer(geometry, table.GATE_NEED, parent) == 1
        _feed(room, GATES + (gate - first) * LANES, parent - first, -1.0 if negated else 1.0, least)


@inline
def fits_lanes(geometry: Geometry, kind: int, index: int) -> bool:
    """True if an entry fits into lanes: no polygon, and no more than `MOST` gates and leaves."""
    program = index if kind == REGION else -1
    if kind == SHEET:
        program = integer(geometry, table.SHEET_PROGRAM, index)
    if program < 0:
        return kind != table.POLYGON
    gates, leaves = gates_of(geometry, program), leaves_of(geometry, program)
    return gates[1] - gates[0] <= MOST and leaves[1] - leaves[0] <= MOST


@helper
def entry_of_lanes(geometry: Geometry, kind: int, index: int, room: Floats) -> None:
    """Compute BOUND: lower bounds of the distances to the walls of an entry that `fits_lanes`, as `entry_bound`."""
    if kind == CELLS:
        cell_of_lanes(geometry, index, room)
        for i in range(EVERY):
            room[BOUND + i] = abs(room[CELL + i])
    elif kind == REGION:
        program_of_lanes(geometry, index, room)
        for i in range(EVERY):
            room[BOUND + i] = abs(room[GATES + i])
    elif kind == SHEET:
        _sheet_of_lanes(geometry, index, room)
    else:  # a ball
        surface_of_lanes(geometry, index, room)
        for i in range(EVERY):
            room[BOUND + i] = abs(room[FACE + i])


@helper
def _sheet_of_lanes(geometry: Geometry, sheet: int, room: Floats) -> None:
    """Compute BOUND of a sheet: the larger of the bounds of its surface and of its clipping program."""
    program = integer(geometry, table.SHEET_PROGRAM, sheet)
    for i in range(EVERY):
        room[GATES + i] = -math.inf
    if program >= 0:
        program_of_lanes(geometry, program, room)
        turned = integer(geometry, table.GATE_NEGATED, root_of(geometry, program)) == 1
        for i in range(EVERY):
            room[GATES + i] = -room[GATES + i] if turned else room[GATES + i]
    surface_of_lanes(geometry, integer(geometry, table.SHEET_SURFACE, sheet), room)
    for i in range(EVERY):
        room[BOUND + i] = max(abs(room[FACE + i]), room[GATES + i])


# Packets of points through the tree, the nearest boxes first
#
# The bound of an entry is the largest of its bounds by the boxes that contain it, by the ball around it, and by its
# walls; the result for a point is the least over all entries. Only entries proved to be farther away than the result
# are left out, so neither the order of entries nor the other points of a packet change a bit of it.

_FEW, _MANY = 6, 16
"""Up to `_FEW` points of a packet are handled one by one, and up to `_MANY` points that an entry is near to."""
_BODIES, _SEVERAL = 8, 4.0
"""In scenes with more bodies, points are handled together only if the sides of their box sum up to at most `_SEVERAL`
times the size of a body's share of the scene's box."""
_LOOKED, _SHARE = 1024, 8
"""A packet is given up if, of more than `_LOOKED` tests of balls, less than one in `_SHARE` found the ball near."""


@inline
def _walls_of(geometry: Geometry, gates: Floats, item: LeafItem, x: float, y: float, z: float, enough: float) -> float:
    """Return a lower bound of the distance from one point to the walls of an entry."""
    if item.kind == POLYGON:
        distance, off, _, _, _ = polygon_distance(geometry, item.index, x, y, z)
        return max(0.0, distance - off)
    return entry_bound(geometry, gates, item.entry, x, y, z, enough)


@helper
def bound_of_point(geometry: Geometry, way: Floats, gates: Floats, x: float, y: float, z: float, reach: float) -> float:
    """Return a lower bound of the distance from a point to the nearest wall; infinite if none is within reach.

    way, gates: as those of `Scratch` and `Neighbourhood`.
    """
    best, bound = reach, math.inf
    around = PointBox(x, y, z, x, y, z)
    found = next_near_leaf(geometry, way, begin_search(geometry, way), around, best)
    while found.code != 0:
        first, last = leaf_range(found.code)
        at, count = leaf_at(geometry, first), last - first
        for k in range(count):
            near = max(found.distance, distance_to_ball(leaf_ball(geometry, at, count, k), x, y, z))
            if near <= best:
                near = max(near, _walls_of(geometry, gates, leaf_item(geometry, at, count, k), x, y, z, best))
                if near <= best:
                    best, bound = near, near
        found = next_near_leaf(geometry, way, found.top, around, best)
    return bound


@inline
def _put_boxes(geometry: Geometry, room: Floats, box: int) -> None:
    """Compute BOX_DISTANCE: lower bounds of the distances to the box of a leaf."""
    for i in range(EVERY):
        room[BOX_DISTANCE + i] = distance_to_node(geometry, box, room[X + i], room[Y + i], room[Z + i])


@inline
def _put_balls(room: Floats, ball: SphereRecord) -> int:
    """Compute NEAR: lower bounds of the distances to an entry by box and ball; return for how many lanes it is near."""
    near = 0
    for i in range(EVERY):
        beyond = max(room[BOX_DISTANCE + i], distance_to_ball(ball, room[X + i], room[Y + i], room[Z + i]))
        room[NEAR + i] = beyond
        near += 1 if beyond <= room[BEST + i] else 0
    return near


@helper
def _meet(geometry: Geometry, memory: SafetyLanes, item: LeafItem, near: int) -> None:
    """Keep the bounds of an entry that is near to `near` lanes."""
    room = memory.room
    # For few points single evaluation is cheaper than 64 lanes
    if near > _MANY and fits_lanes(geometry, item.kind, item.index):
        entry_of_lanes(geometry, item.kind, item.index, room)
        keep_bounds(room)
        return
    for k in range(64):
        i = lane_index(k)
        if room[NEAR + i] <= room[BEST + i]:
            x, y, z = room[X + i], room[Y + i], room[Z + i]
            keep_bound(room, i, _walls_of(geometry, memory.single.gates, item, x, y, z, room[BEST + i]))


@inline
def _belong_together(geometry: Geometry, around: PointBox) -> bool:
    """True if the points in a box see about the same part of the scene."""
    cell = real(geometry, table.EXTENT, 1)
    sides = (around.high_x - around.low_x) + (around.high_y - around.low_y) + (around.high_z - around.low_z)
    return length(geometry, table.ENTRY_KIND) <= _BODIES or sides <= _SEVERAL * cell


@helper
def bound_packet(geometry: Geometry, memory: SafetyLanes) -> bool:
    """Compute BEST and FOUND of all lanes; False, with no valid result, if the points have too little in common."""
    room, way, looks, hits = memory.room, memory.single.scratch.way, 0, 0
    around = box_of_lanes(room)
    if not _belong_together(geometry, around):
        return False
    found = next_near_leaf(geometry, way, begin_search(geometry, way), around, farthest_bound(room))
    while found.code != 0:
        first, last = leaf_range(found.code)
        at, count = leaf_at(geometry, first), last - first
        _put_boxes(geometry, room, found.box)
        for k in range(count):
            near = _put_balls(room, leaf_ball(geometry, at, count, k))
            looks, hits = looks + 64, hits + near
            if near > 0:
                _meet(geometry, memory, leaf_item(geometry, at, count, k), near)
        # Points too far apart test each other's bodies in vain
        if looks > _LOOKED and hits * _SHARE < looks:
            return False
        found = next_near_leaf(geometry, way, found.top, around, farthest_bound(room))
    return True


@kernel(points="n 3", reach="n", width="picture n", begin="0..end", end="0..n", bounds="out n")
def bounds_of_points(
    geometry: Geometry, points: Floats, reach: Floats, width: int, begin: int, end: int, bounds: Floats
) -> None:
    """Write lower bounds of the distances from points to the nearest wall; infinite if none is within reach[i]."""
    memory = new_memory(geometry)
    room, count, single = memory.room, len(points), memory.single
    for packet in range(begin, end):
        if is_halted(geometry):
            return
        together = put_points(memory, points, reach, packet, width) > _FEW and bound_packet(geometry, memory)
        for row in range(8):
            first, n = packet_row(packet, row, width, count)
            for k in range(n):
                i = first + k
                if together:
                    bounds[i] = lane_bound(room, lane_index(8 * row + k))
                elif not is_halted(geometry):
                    x, y, z = points[i, 0], points[i, 1], points[i, 2]
                    bounds[i] = bound_of_point(geometry, single.scratch.way, single.gates, x, y, z, reach[i])
