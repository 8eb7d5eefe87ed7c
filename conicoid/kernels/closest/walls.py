"""The test of a wall: whether a candidate point on some surfaces is a wall of the current body; the nearest is kept.

`try_point` is the one place that decides this. A point is on a wall if the body differs between the sides of the
surfaces through it. The sides of clipped polygons come last. `point_sides.py` has the sides of surfaces around a point,
`projection.py` the points on surfaces and polygons.
"""

from __future__ import annotations

import math
from typing import NamedTuple

from ..._jit.decorators import helper, inline
from .. import tables as table
from ..body.cell import NO_PLACE, place_face, quadric_place
from ..numbers.vectors import dot
from ..programs import hold_program, leaf_decides, sense_of, turn_leaf
from ..surface.records import anchor_of, load_plane, load_quadric
from ..tables import PLANE, QUADRIC, Geometry, integer, whole
from .form import bend_times, form_at, length_of
from .neighbourhood import (
    AT_X,
    AT_Y,
    AT_Z,
    BODY,
    CELL_OF,
    ENTRY,
    FIRST_LINK,
    IN_DOUBT,
    LEAF,
    LEAVES,
    LINK_COUNT,
    LOWER,
    MOST_IN_DOUBT,
    NEAREST,
    PLACE,
    PROGRAM,
    SENSE,
    SHEET_OF,
    SURFACES,
    TIP,
    UPPER,
    WITHIN,
    Neighbourhood,
    WallQuery,
    limit,
)
from .point_sides import (
    holds,
    is_leaf_on,
    is_wholly,
    put_sides,
    put_signs,
    row_of_quadric,
    sheet_around,
    sides_around,
    straddles_wall,
    turning_sides,
)
from .projection import TANGENT, corner, is_within, nearest_of_side, project_point, slant

# Test of a wall: a point of some surfaces is on a wall if the body differs between their sides, as in a ray's sweep

_MOST = 6
"""Most surfaces through one point whose sides are tried in all combinations."""
_SHORT_STEP, _LONG_STEP = 2.0**-48, 2.0**-42
"""Steps, as shares of a point's size, to points beside it, which decide where its surfaces touch or are many."""
_VAGUE, _FAR, _OFFSET = 2.0**-16, 2.0**-36, 2.0**-44
"""Largest errors of a reported point, as shares of its size, of its size plus its distance, and of the distance of its
surface's anchor: with a larger error its surfaces need not meet at all."""
_STILL = 2.0**-30
"""Largest part along its surfaces, as a share, of the vector to a nearest point. Moving the point along them would gain
about the square of this share."""
NO_WALL, POSSIBLE_WALL, CERTAIN_WALL, SLANTED, UNKNOWN_SIDES = 0, 1, 2, 3, 4
UNSETTLED = -1.0
"""As a slack: the point has not been settled."""


class WallCandidate(NamedTuple):
    """A displacement from the query point to a candidate, with bounds from other sources than a projection."""

    x: float
    y: float
    z: float
    error: float  # of the point; infinite for none
    least: float  # a lower bound of the distance to all common points of the chosen surfaces
    slack: float  # how much nearer these may come beside the point, a local minimum of their distance; or UNSETTLED


@inline
def candidate(x: float, y: float, z: float) -> WallCandidate:
    """Return a candidate without bounds: the nearest of the common points of its surfaces."""
    return WallCandidate(x, y, z, math.inf, 0.0, 0.0)


class _Turn(NamedTuple):
    """Whether a body, or the existence of a sheet, differs between the sides of the surfaces through a point."""

    is_wall: bool
    chosen: int  # the first of room.chosen whose side matters
    sides: int  # a combination of sides in which it does
    values: int  # `sides_around`, of at most `_MOST` surfaces


@inline
def _turn_of(geometry: Geometry, room: Neighbourhood, many: int) -> _Turn:
    """Return how the body turns at a point on the first `many` of room.chosen. Relies on `put_signs`."""
    none = whole(0)
    if room.sizes[SHEET_OF] == 1:
        return _Turn(many > _MOST or sheet_around(geometry, room, many), none, none, none)
    if many > _MOST:
        varies = not is_wholly(geometry, room, True) and not is_wholly(geometry, room, False)
        return _Turn(varies, none, none, none)
    values, turned = sides_around(geometry, room, many), none
    every = whole(-1) if many == _MOST else (whole(1) << (1 << many)) - 1
    if values == 0 or values == every:
        return _Turn(False, none, none, values)
    while turned < many - 1 and turning_sides(values, many, turned) < 0:
        turned += 1
    return _Turn(True, turned, max(whole(turning_sides(values, many, turned)), none), values)


@inline
def _proved_error(
    geometry: Geometry, room: Neighbourhood, count: int, many: int, sine: float, x: float, y: float, z: float,
    off: float, distance: float,
) -> float:  # fmt: skip
    """Return how far from a point a wall surely is; infinite where none is sure.

    The point has an error of `off`; it lies on `count` surfaces, with angles of this least sine, and perhaps on `many`.
    """
    wide = 0.0
    if count < many <= 3:  # a wall is sure to be at the common point alone
        common = project_point(geometry, room, many, x, y, z)
        sine, wide = min(sine, common.sine), common.off + length_of(common.x - x, common.y - y, common.z - z)
    if many <= 3 and not sine < TANGENT:
        return max(off, wide)
    if room.sizes[SHEET_OF] == 1:
        return math.inf
    # Tangent or many surfaces: their combinations of sides need not all occur, so points beside decide
    first, second, third = room.chosen[0], room.chosen[1], room.chosen[2]
    far = abs(x) + abs(y) + abs(z) + distance
    step = max(_SHORT_STEP * far, 2.0 * off)
    proved = straddles_wall(geometry, room, x, y, z, step)
    if not proved:
        step = max(_LONG_STEP * far, 16.0 * off)
        proved = straddles_wall(geometry, room, x, y, z, step)
    room.chosen[0], room.chosen[1], room.chosen[2] = first, second, third
    put_signs(geometry, room, count, x, y, z, off)  # those of the point, with the surfaces in their order
    return off + 2.25 * step if proved else math.inf


@helper
def _is_at_apex(geometry: Geometry, room: Neighbourhood, many: int, x: float, y: float, z: float, off: float) -> bool:
    """True if the gradient of one of the first `many` of room.chosen is too small to bound that surface."""
    found = False
    for i in range(many):
        form = form_at(geometry, room.surface[room.chosen[i]], x, y, z)
        found = found or length_of(form.gx, form.gy, form.gz) <= 4.0 * form.size * off
    return found


@helper
def _is_regular(
    geometry: Geometry, room: Neighbourhood, count: int, many: int, sine: float, x: float, y: float, z: float,
    off: float,
) -> bool:  # fmt: skip
    """Return True if all combinations of sides of the surfaces through a point occur beside it.

    `sine` is that of the first `count` of room.chosen. At an apex the gradient is too small to bound the surface.
    """
    if many > 1:
        if count < many <= 3:
            sine = min(sine, project_point(geometry, room, many, x, y, z).sine)
        if many <= 3 and _is_at_apex(geometry, room, many, x, y, z, off):
            sine = 0.0
    return many <= 3 and sine >= TANGENT


@helper
def _wall_beside(
    geometry: Geometry, room: Neighbourhood, count: int, x: float, y: float, z: float, far: float, off: float
) -> int:
    """Return the first near surface that bounds the body beside a point, where others only touch it; -1 for none found.

    Points of each surface a step away decide. For a surface found room.sign has the sides there; else it is unchanged,
    as the first `count` of room.chosen always are: the caller's next candidates lie on them.
    """
    first, second, third = room.chosen[0], room.chosen[1], room.chosen[2]
    for number in range(2):
        step = max(_LONG_STEP * far, 16.0 * off) * (1.0 if number == 0 else 256.0)
        for k in range(room.sizes[SURFACES]):
            for i in range(27):
                dx, dy, dz = float(i % 3 - 1) + 0.03, float(i // 3 % 3 - 1) - 0.05, float(i // 9 - 1) + 0.07
                room.chosen[0] = k
                at = project_point(geometry, room, 1, x + step * dx, y + step * dy, z + step * dz)
                if not length_of(at.x - x, at.y - y, at.z - z) <= 4.0 * step:
                    continue
                if put_signs(geometry, room, 1, at.x, at.y, at.z, at.off) == 1:
                    room.sign[k] = -1
                    inside = holds(geometry, room)
                    room.sign[k] = 1
                    if inside != holds(geometry, room):
                        room.sign[k] = 0
                        room.chosen[0], room.chosen[1], room.chosen[2] = first, second, third
                        return whole(k)
    room.chosen[0], room.chosen[1], room.chosen[2] = first, second, third
    put_signs(geometry, room, count, x, y, z, off)
    return whole(-1)


@helper
def _wall_of_sides(geometry: Geometry, room: Neighbourhood, count: int, many: int, least: float) -> int:
    """Return NO_WALL if the body has one value for all sides of the first `many` of room.chosen that occur.

    Return CERTAIN_WALL if it has two values, and the sides occur beside each common point of the first `count`. Else
    return POSSIBLE_WALL, or UNKNOWN_SIDES for surfaces that room.known lacks; the nearest of these become room.doubt.
    Signs of the chosen surfaces in room.sign are lost.
    """
    if many > MOST_IN_DOUBT or room.sizes[SHEET_OF] == 1:
        return POSSIBLE_WALL
    row = _known_row(room, many)
    if row < 0:
        if least < room.best[IN_DOUBT]:
            room.best[IN_DOUBT], room.doubt[0] = least, many
            for i in range(many):
                room.doubt[1 + i] = room.surface[room.chosen[i]]
        return UNKNOWN_SIDES
    inside, outside = False, False
    for k in range(room.known[row + 1]):
        _put_known_sides(room, row, many, room.known[row + 3 + many + k])
        value = holds(geometry, room)
        inside, outside = inside or value, outside or not value
    if not (inside and outside):
        return NO_WALL
    return CERTAIN_WALL if room.known[row + 2] == count else POSSIBLE_WALL


@inline
def _put_known_sides(room: Neighbourhood, row: int, many: int, sides: int) -> None:
    """Write a combination of sides of the surfaces of a row of room.known to room.sign."""
    for pair in range(many * many):
        near = room.chosen[pair // many]
        if room.known[row + 3 + pair % many] == room.surface[near]:
            room.sign[near] = 1 if (sides >> (pair % many)) & 1 else -1


@helper
def _wall_of_known_sides(geometry: Geometry, room: Neighbourhood, many: int) -> int:
    """Return a surface that bounds the body beside a point where all known sides occur; -1 for none.

    Regions of planes through one point share a face if they differ in the side of one plane alone. room.sign has the
    sides there.
    """
    row = _known_row(room, many)
    first, number = row + 3 + many, room.known[row + 1]
    for pair in range(number * number):
        one, other = room.known[first + pair // number], room.known[first + pair % number]
        for i in range(many * many):
            near = room.chosen[i // many]
            if one ^ other == 1 << (i % many) and room.known[row + 3 + i % many] == room.surface[near]:
                _put_known_sides(room, row, many, one)
                inside = holds(geometry, room)
                _put_known_sides(room, row, many, other)
                if inside != holds(geometry, room):
                    room.sign[near] = 0
                    return whole(near)
    return whole(-1)


@inline
def _known_row(room: Neighbourhood, many: int) -> int:
    """Return where room.known has the first `many` of room.chosen, -1 for nowhere."""
    row = 0
    while room.known[row] > 0:
        left = many if room.known[row] == many else -1  # surfaces that this row lacks
        for pair in range(many * many if left == many else 0):
            left -= 1 if room.known[row + 3 + pair % many] == room.surface[room.chosen[pair // many]] else 0
        if left == 0:
            return row
        row += 3 + room.known[row] + room.known[row + 1]
    return -1


@helper
def try_point(geometry: Geometry, room: Neighbourhood, at: WallQuery, count: int, v: WallCandidate) -> int:
    """Try x + v on the first `count` of room.chosen as the nearest wall; return NO_, POSSIBLE_ or CERTAIN_WALL.

    An UNSETTLED vector that slants to the surfaces is not tried: the result is SLANTED.
    """
    # The point on the surfaces, with the better of two error bounds
    x, y, z, off, sine, one, two = project_point(geometry, room, count, at.x + v.x, at.y + v.y, at.z + v.z)
    if v.error < off:
        x, y, z, off = at.x + v.x, at.y + v.y, at.z + v.z, v.error
    distance = length_of(x - at.x, y - at.y, z - at.z)
    # v was found relative to the query point: adding it there rounds by a share of the distance
    off += 2.0**-50 * distance
    if not distance - off <= limit(room):
        return NO_WALL
    if room.sizes[WITHIN] > 0 and not is_within(geometry, whole(room.sizes[WITHIN]) - 1, x, y, z):
        return NO_WALL
    slack = max(v.slack, 0.0)
    if v.slack == UNSETTLED and slant(one, two, x - at.x, y - at.y, z - at.z) > _STILL * distance + off:
        if count == 1 or not _is_at_apex(geometry, room, count, x, y, z, off):
            return SLANTED
        # A plane through an apex: points about the apex, and feet on rulings at h from it, nearer by h² / 2d
        h = length_of(x - (at.x + v.x), y - (at.y + v.y), z - (at.z + v.z))
        slack = 8.0 * off + h * h / distance
    least = max(distance - off - slack, min(v.least, distance))
    for i in range(count):  # however uncertain the point is
        least = max(least, min(room.bound[room.chosen[i]], distance))
    # At a tip of n planes the corners of each three are one point: a proof of each would take its time n³ times. Those
    # whose point is not much more exact than the one that was proved are left out.
    apart = length_of(x - room.best[AT_X], y - room.best[AT_Y], z - room.best[AT_Z])
    if room.who[BODY] == at.body and math.inf > 2.0 * off >= room.best[TIP] and apart <= 8.0 * off:
        room.best[LOWER] = min(room.best[LOWER], least)
        return CERTAIN_WALL
    many = put_signs(geometry, room, count, x, y, z, off)
    turn = _turn_of(geometry, room, many)
    if not turn.is_wall:
        return NO_WALL
    wall, size, point_off = room.chosen[turn.chosen], abs(x) + abs(y) + abs(z), off
    off = _proved_error(geometry, room, count, many, sine, x, y, z, off, distance)
    proved = off <= max(max(_VAGUE * size, _FAR * (size + distance)), _OFFSET * _reach(geometry, room, x, y, z))
    for i in range(count):
        surface = room.surface[room.chosen[i]]
        proved = proved and _passes_near(geometry, surface, x, y, z, 2.0**-50 * (size + distance))
    # Two planes and an apex: their sides need not all occur, whatever their angles
    unsure = not proved or (many == 3 and _is_at_apex(geometry, room, many, x, y, z, point_off))
    common = count if sine >= TANGENT else whole(-1)
    known = _wall_of_sides(geometry, room, common, many, least) if unsure else CERTAIN_WALL
    if known == NO_WALL:
        return NO_WALL
    room.best[LOWER] = min(room.best[LOWER], least)
    if known == UNKNOWN_SIDES or not (proved or known == CERTAIN_WALL):
        return POSSIBLE_WALL
    room.best[UPPER] = min(room.best[UPPER], distance + (off if proved else point_off))
    beside = whole(-1)
    if room.sizes[SHEET_OF] != 1 and not _is_regular(geometry, room, count, many, sine, x, y, z, point_off):
        beside = _wall_beside(geometry, room, count, x, y, z, size + distance, point_off)
    if beside < 0 and not proved:
        beside = _wall_of_known_sides(geometry, room, many)
    if beside >= 0:
        wall = beside
    elif room.sizes[SHEET_OF] != 1 and many <= _MOST:  # of the surroundings, where the wall's own sides differ
        sides = turn.sides
        if count < many and room.sizes[PROGRAM] >= 0:
            sides = _sides_of_lowest(geometry, room, turn.values, many, turn.chosen, sides)
        put_sides(room, many, turn.chosen, sides)
    keep_wall(geometry, room, at, wall, x, y, z, distance)
    if many > _MOST:
        room.best[TIP] = min(room.best[TIP], point_off) if apart <= point_off else point_off
    elif room.best[NEAREST] == distance:
        room.best[TIP] = math.inf
    return CERTAIN_WALL


@helper
def _passes_near(geometry: Geometry, surface: int, x: float, y: float, z: float, moved: float) -> bool:
    """Return False where a surface leaves out a point that rounding may have put on it.

    Beside a flat sheared quadric its value is the difference of large squares, and Newton's steps end where it is far
    from zero. The rows of its record keep more digits: their values err by e = 2^-50 |W| |p|, and because rounding has
    `moved` the point. What is left of |f| must vanish along the gradient.
    """
    if integer(geometry, table.SURFACE_KIND, surface) != QUADRIC:
        return True
    quadric = load_quadric(geometry, integer(geometry, table.SURFACE_ROW, surface))
    px, py, pz = (
        2.0**-50 * abs(x - quadric.ax) + moved, 2.0**-50 * abs(y - quadric.ay) + moved,
        2.0**-50 * abs(z - quadric.az) + moved,
    )  # fmt: skip
    off = 2.0**-50 * abs(quadric.k)
    for i in range(3):
        wx, wy, wz, _ = row_of_quadric(quadric, i)
        s, b = abs(quadric[12 + i]), abs(quadric[15 + i])
        own = abs(dot(wx, wy, wz, x - quadric.ax, y - quadric.ay, z - quadric.az))
        e = dot(abs(wx), abs(wy), abs(wz), px, py, pz)
        off += (s * (2.0 * own + e) + 2.0 * b) * e + 2.0**-50 * (s * own + 2.0 * b) * own
    form = form_at(geometry, surface, x, y, z)
    g, value = length_of(form.gx, form.gy, form.gz), abs(form.value) - off
    return value <= 0.0 or g * g >= form.size * value


@inline
def _reach(geometry: Geometry, room: Neighbourhood, x: float, y: float, z: float) -> float:
    """Return the distance of a point from the anchor of the first of room.chosen."""
    surface = room.surface[room.chosen[0]]
    if integer(geometry, table.SURFACE_KIND, surface) == PLANE:
        plane = load_plane(geometry, integer(geometry, table.SURFACE_ROW, surface))
        return length_of(x - plane.ax, y - plane.ay, z - plane.az)
    ax, ay, az = anchor_of(geometry, surface)
    return length_of(x - ax, y - ay, z - az)


@inline
def keep_wall(
    geometry: Geometry, room: Neighbourhood, at: WallQuery, chosen: int, x: float, y: float, z: float, distance: float
) -> None:
    """Keep a wall if it is the nearest so far, or as near and of a body listed before."""
    best, who = room.best, room.who
    if distance < best[NEAREST] or (distance == best[NEAREST] and at.body < who[BODY]):
        best[NEAREST], best[AT_X], best[AT_Y], best[AT_Z] = distance, x, y, z
        who[BODY], who[ENTRY] = at.body, at.entry
        who[PLACE], who[SENSE] = _place_of(geometry, room, chosen)


@helper
def _place_of(geometry: Geometry, room: Neighbourhood, chosen: int) -> tuple[int, int]:
    """Return (place of the face, sense of its leaf) of a near surface, for the first leaf that turns the body there.

    By room.sign, which has the sides of the other surfaces. A first leaf that it bounds serves where none is proved.
    """
    surface, program, best = room.surface[chosen], whole(room.sizes[PROGRAM]), -1
    for k in range(room.sizes[LEAVES] if room.sizes[SHEET_OF] == 0 else 0):
        first, count = room.leaves[4 * k + FIRST_LINK], room.leaves[4 * k + LINK_COUNT]
        mine, fits = False, True
        for link in range(first, first + count):
            mine = mine or room.links[2 * link] == chosen
            fits = fits and room.sign[room.links[2 * link]] * room.links[2 * link + 1] <= 0
        if mine and fits:
            decides = program < 0 or _decides(geometry, room, k, chosen)
            if decides or best < 0:
                best = k
            if decides:
                break
    if best < 0:
        return whole(NO_PLACE), whole(1)
    cell, leaf = whole(room.leaves[4 * best + CELL_OF]), whole(room.leaves[4 * best + LEAF])
    sense = sense_of(geometry, program, leaf) if leaf >= 0 else whole(1)
    for slot in range(integer(geometry, table.CELL_FIRST, cell), integer(geometry, table.CELL_FIRST, cell + 1)):
        if integer(geometry, table.PLANE_SURFACE, slot) == surface:
            return whole(slot), sense
    return whole(quadric_place(cell)), sense


@helper
def _decides(geometry: Geometry, room: Neighbourhood, k: int, chosen: int) -> bool:
    """True if near leaf k turns the body on both sides of a near surface (`leaf_decides`); room.sign is unchanged."""
    counts, program, decides = room.scratch.counts, whole(room.sizes[PROGRAM]), True
    before, leaf = room.sign[chosen], whole(room.leaves[4 * k + LEAF])
    for side in range(2):
        room.sign[chosen] = 2 * side - 1
        hold_program(geometry, counts, program)
        for sweep in range(2):
            for j in range(room.sizes[LEAVES]):
                if is_leaf_on(room, j):
                    turn_leaf(geometry, counts, program, whole(room.leaves[4 * j + LEAF]), sweep == 0)
            if sweep == 0:
                decides &= leaf_decides(geometry, counts, program, leaf, is_leaf_on(room, k))
    room.sign[chosen] = before
    return decides


@helper
def _sides_of_lowest(geometry: Geometry, room: Neighbourhood, values: int, count: int, i: int, sides: int) -> int:
    """Return the sides in which chosen surface i bounds the body with its lowest face number, as for rays."""
    lowest = whole(1 << 60)
    for k in range(1 << count):
        if ((values >> k) & 1) != ((values >> (k ^ (1 << i))) & 1):
            put_sides(room, count, i, k)
            place = _place_of(geometry, room, room.chosen[i])[0]
            if place != NO_PLACE and place_face(geometry, place)[1] < lowest:
                sides, lowest = k, place_face(geometry, place)[1]
    return sides


# The sides of a clipped polygon, tried as nearest walls


@inline
def _try(geometry: Geometry, room: Neighbourhood, at: WallQuery, x: float, y: float, z: float) -> None:
    room.chosen[0] = 0
    try_point(geometry, room, at, 1, candidate(x, y, z))


@helper
def _try_crossings(
    geometry: Geometry,
    room: Neighbourhood,
    at: WallQuery,
    ax: float,
    ay: float,
    az: float,
    bx: float,
    by: float,
    bz: float,
) -> None:
    """Try the points where a side, from a to b, meets the surfaces that clip its polygon."""
    dx, dy, dz = bx - ax, by - ay, bz - az
    for k in range(1, room.sizes[SURFACES]):
        form = form_at(geometry, room.surface[k], at.x + ax, at.y + ay, at.z + az)
        ux, uy, uz = bend_times(form, dx, dy, dz)
        a, b = dot(ux, uy, uz, dx, dy, dz), dot(form.gx, form.gy, form.gz, dx, dy, dz)
        square = b * b - a * form.value
        if square < 0.0:
            continue
        far = -(b + math.copysign(math.sqrt(square), b))
        for which in range(2):
            over, under = (far, a) if which == 0 else (form.value, far)
            t = over / under if under != 0.0 else -1.0
            if 0.0 <= t <= 1.0:
                _try(geometry, room, at, ax + t * dx, ay + t * dy, az + t * dz)


@helper
def try_sides(geometry: Geometry, room: Neighbourhood, at: WallQuery, polygon: int) -> None:
    """Try the nearest points of a polygon's sides, their ends, and their crossings with the clipping surfaces."""
    room.sizes[WITHIN] = 0
    first, last = integer(geometry, table.POLYGON_FIRST, polygon), integer(geometry, table.POLYGON_FIRST, polygon + 1)
    ax, ay, az = corner(geometry, last - 1, at.x, at.y, at.z)
    for vertex in range(first, last):
        bx, by, bz = corner(geometry, vertex, at.x, at.y, at.z)
        x, y, z = nearest_of_side(ax, ay, az, bx, by, bz)
        _try(geometry, room, at, x, y, z)
        _try(geometry, room, at, bx, by, bz)
        _try_crossings(geometry, room, at, ax, ay, az, bx, by, bz)
        ax, ay, az = bx, by, bz
