"""Is a point of some surfaces on a body's wall? What the body is on each side of them decides, as in a ray's sweep."""

from __future__ import annotations

from typing import NamedTuple

from ...compiler.jit import helper, inline
from .. import tables as table
from ..body.cell import NO_PLACE, quadric_place
from ..body.gates import hold, root_value, turn_leaf
from ..programs import sense_of
from ..tables import Geometry, integer, whole
from .form import form_at, length_of
from .outline import is_within
from .room import (
    AT_X,
    AT_Y,
    AT_Z,
    BODY,
    CELL_OF,
    ENTRY,
    FIRST_LINK,
    LEAF,
    LEAVES,
    LINK_COUNT,
    LOWER,
    NEAREST,
    PLACE,
    PROGRAM,
    SENSE,
    SHEET_OF,
    SURFACES,
    UPPER,
    WITHIN,
    Room,
    limit,
)  # fmt: skip
from .touch import TANGENT, touch

_MOST = 6
"""So many surfaces through one point are tried in all combinations of their sides."""
_BESIDE = 2.0**-42
"""Share of a point's size at which it is looked beside it, where its surfaces touch or are many."""
_VAGUE, _FAR = 2.0**-16, 2.0**-36
"""Shares of its size, and of that with its distance, from which on a point that may be off is no point to tell: its
surfaces need not meet at all."""
NOWHERE, MAYBE, SURE = 0, 1, 2


class Query(NamedTuple):
    """The point that is asked for, and whose walls are looked at."""

    x: float
    y: float
    z: float
    body: int
    entry: int


@inline
def _is_on(room: Room, k: int) -> bool:
    """Is a near leaf on, by room.sign? It holds its own walls."""
    first, count = room.leaves[4 * k + FIRST_LINK], room.leaves[4 * k + LINK_COUNT]
    on = True
    for link in range(first, first + count):
        on = on and room.sign[room.links[2 * link]] * room.links[2 * link + 1] <= 0
    return on


@helper
def holds(geometry: Geometry, room: Room) -> bool:
    """Is the body there, or not clipped, by room.sign? `scratch.counts` are as before when it returns."""
    program, leaves = room.sizes[PROGRAM], room.sizes[LEAVES]
    if program < 0:
        return room.sizes[SHEET_OF] == 1 or (leaves > 0 and _is_on(room, 0))
    counts = room.scratch.counts
    hold(geometry, counts, whole(program))
    for k in range(leaves):
        if _is_on(room, k):
            turn_leaf(geometry, counts, whole(program), whole(room.leaves[4 * k + LEAF]), True)
    value = root_value(geometry, counts, whole(program))
    for k in range(leaves):
        if _is_on(room, k):
            turn_leaf(geometry, counts, whole(program), whole(room.leaves[4 * k + LEAF]), False)
    return value


@helper
def put_signs(geometry: Geometry, room: Room, chosen: int, x: float, y: float, z: float, off: float) -> int:
    """Find on which side of the near surfaces a point is that may be off; returns how many it may be on.

    The first `chosen` of room.chosen it is on; those that it may be on come behind them.
    """
    count = chosen
    for k in range(room.sizes[SURFACES]):
        known = False
        for i in range(chosen):
            known = known or room.chosen[i] == k
        if known:
            room.sign[k] = 0
            continue
        form = form_at(geometry, room.surface[k], x, y, z)
        g = length_of(form.gx, form.gy, form.gz)
        may = form.off + (2.0 * g + form.size * off) * off
        room.sign[k] = 0 if abs(form.value) <= may else (1 if form.value > 0.0 else -1)
        if room.sign[k] == 0:
            room.chosen[count] = k
            count += 1
    return count


@helper
def sides_around(geometry: Geometry, room: Room, count: int) -> int:
    """Bit k is the body for combination k of the sides of the first `count` of room.chosen."""
    found = whole(0)
    for sides in range(1 << count):
        for i in range(count):
            room.sign[room.chosen[i]] = 1 if (sides >> i) & 1 else -1
        if holds(geometry, room):
            found |= whole(1) << sides
    for i in range(count):
        room.sign[room.chosen[i]] = 0
    return found


@inline
def _turns(found: int, count: int, i: int) -> bool:
    """Does the side of chosen surface i matter to any combination?"""
    turns = False
    for sides in range(1 << count):
        turns = turns or ((found >> sides) & 1) != ((found >> (sides ^ (1 << i))) & 1)
    return turns


@helper
def _beside(geometry: Geometry, room: Room, x: float, y: float, z: float, step: float) -> bool:
    """Are there points about a step away that are surely inside and surely outside?"""
    inside, outside = False, False
    for k in range(26):
        i = k if k < 13 else k + 1
        dx, dy, dz = float(i % 3 - 1) + 0.03, float(i // 3 % 3 - 1) - 0.05, float(i // 9 - 1) + 0.07
        if put_signs(geometry, room, 0, x + step * dx, y + step * dy, z + step * dz, 0.0) == 0:
            if holds(geometry, room):
                inside = True
            else:
                outside = True
    return inside and outside


@helper
def sheet_around(geometry: Geometry, room: Room, count: int) -> bool:
    """Is there any of a sheet about a point that is on its own surface, the first of room.chosen?"""
    for sides in range(1 << (count - 1)):
        for i in range(1, count):
            room.sign[room.chosen[i]] = 1 if (sides >> (i - 1)) & 1 else -1
        if holds(geometry, room):
            return True
    return False


@helper
def try_point(
    geometry: Geometry, room: Room, at: Query, count: int, vx: float, vy: float, vz: float, known: float, least: float
) -> int:
    """Try x + v on the first `count` of room.chosen as the nearest wall: NOWHERE, MAYBE or SURE.

    `known`: by how much it may be off, of what is known without them; infinite where nothing is. `least`: all that they
    have in common is surely as far away.
    """
    x, y, z, off, sine = touch(geometry, room, count, at.x + vx, at.y + vy, at.z + vz)
    if known < off:
        x, y, z, off = at.x + vx, at.y + vy, at.z + vz, known
    distance = length_of(x - at.x, y - at.y, z - at.z)
    off += 2.0**-50 * distance
    if not distance - off <= limit(room):
        return NOWHERE
    if room.sizes[WITHIN] > 0 and not is_within(geometry, whole(room.sizes[WITHIN]) - 1, x, y, z):
        return NOWHERE
    many = put_signs(geometry, room, count, x, y, z, off)
    sheet, turned = room.sizes[SHEET_OF] == 1, 0
    if sheet:
        if many <= _MOST and not sheet_around(geometry, room, many):
            return NOWHERE
    elif many <= _MOST:
        values = sides_around(geometry, room, many)
        every = whole(-1) if many == _MOST else (whole(1) << (1 << many)) - 1
        if values == 0 or values == every:
            return NOWHERE
        while turned < many - 1 and not _turns(values, many, turned):
            turned += 1
    room.best[LOWER] = min(room.best[LOWER], max(distance - off, min(least, distance)))
    wall = room.chosen[turned]
    if count < many <= 3:
        sine = min(sine, touch(geometry, room, many, x, y, z).sine)
    if many > 3 or sine < TANGENT:
        first, second, third = room.chosen[0], room.chosen[1], room.chosen[2]
        step = max(_BESIDE * (abs(x) + abs(y) + abs(z) + distance), 16.0 * off)
        proved = not sheet and _beside(geometry, room, x, y, z, step)
        put_signs(geometry, room, 0, x, y, z, off)
        room.chosen[0], room.chosen[1], room.chosen[2] = first, second, third
        if not proved:
            return MAYBE
        off += 2.0 * step
    elif many > count:
        off += 4.0 * off / sine
    size = abs(x) + abs(y) + abs(z)
    if off > max(_VAGUE * size, _FAR * (size + distance)):
        return MAYBE
    room.best[UPPER] = min(room.best[UPPER], distance + off)
    keep(geometry, room, at, wall, x, y, z, distance)
    return SURE


@inline
def keep(geometry: Geometry, room: Room, at: Query, chosen: int, x: float, y: float, z: float, distance: float) -> None:
    """Keep a wall if it is the nearest, or as near and of a body that is listed before."""
    best, who = room.best, room.who
    if distance < best[NEAREST] or (distance == best[NEAREST] and at.body < who[BODY]):
        best[NEAREST], best[AT_X], best[AT_Y], best[AT_Z] = distance, x, y, z
        who[BODY], who[ENTRY] = at.body, at.entry
        who[PLACE], who[SENSE] = _place_of(geometry, room, chosen)


@helper
def _place_of(geometry: Geometry, room: Room, chosen: int) -> tuple[int, int]:
    """(place of the face, sense of its leaf) of a near surface: of the first leaf that it bounds."""
    surface, program = room.surface[chosen], whole(room.sizes[PROGRAM])
    for k in range(room.sizes[LEAVES]):
        cell, leaf = whole(room.leaves[4 * k + CELL_OF]), whole(room.leaves[4 * k + LEAF])
        sense = sense_of(geometry, program, leaf) if leaf >= 0 else whole(1)
        first, count = room.leaves[4 * k + FIRST_LINK], room.leaves[4 * k + LINK_COUNT]
        mine, fits = False, True
        for link in range(first, first + count):
            mine = mine or room.links[2 * link] == chosen
            fits = fits and room.sign[room.links[2 * link]] * room.links[2 * link + 1] <= 0
        if mine and fits and room.sizes[SHEET_OF] == 0:
            for slot in range(integer(geometry, table.CELL_FIRST, cell), integer(geometry, table.CELL_FIRST, cell + 1)):
                if integer(geometry, table.PLANE_SURFACE, slot) == surface:
                    return whole(slot), sense
            return whole(quadric_place(cell)), sense
    return whole(NO_PLACE), whole(1)
