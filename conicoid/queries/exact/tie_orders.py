"""Orders of ties: in which order the rays beside a ray cross what it crosses in one place.

A ray may cross several surfaces at one place, touch one, start on one that is not its own, or pass through an edge of a
polygon. As the ray moves by a small vector v, its crossing with a surface of gradient g moves by -(g·v) / (g·d) along
it. So a ray beside it crosses the surfaces of the place in the order of the numbers (g·v) / (g·d), and the orders that
rays have are those of points of a plane, (g_a, g_b) / (g·d), along all directions of that plane: n (n - 1) orders of n
crossings. Each order begins where two points are level. Three walls through one line have two orders, not six.

They decide two things. A crossing has the face of a wall that such a ray crosses there: the plane of an inner cut of a
body is none. And the first hit hangs on a tie if in one of the orders, or where a touch becomes two crossings, it is
another. Both are properties of the exact ray. Of places behind the start or beyond the hit no order matters.

Of places with more than 9 crossings 64 of the orders are tried. Others of so many crossings may hang on a tie unseen.
"""

from __future__ import annotations

import math
from typing import Any, NamedTuple

from ..._jit.decorators import helper, inline
from ...kernels import tables as table
from ...kernels.body.boolean import read_crossing
from ...kernels.body.entry import crossing_face, entry_crossings, is_solid
from ...kernels.body.hit import Hit, comes_first, hit_surface, no_hit
from ...kernels.body.scratch import Scratch
from ...kernels.numbers.shell_sort import make_sort
from ...kernels.ray import Ray
from ...kernels.surface.exact_crossing import CROSSES, TOUCHES
from ...kernels.surface.polygon_loop import EDGE
from ...kernels.surface.records import gradient_at, is_curved
from ...kernels.tables import POLYGON, Geometry, integer, whole
from .ranks import (
    CROSSINGS,
    SURFACES,
    Ranks,
    find_leaves,
    forget_leaves,
    put_canonical_surfaces,
    ranked_crossings,
    ray_of_ranks,
    t_of,
)

_MOST_PAIRED = 9
"""Places with more crossings have orders of `_DIRECTIONS` directions, not of all their pairs."""
_DIRECTIONS = 64
_MOST_SLOTS = 10
"""Of an origin on more crossings than 9, that many of its places among them are tried."""
_LEVEL = 4e-15
"""Points are level along a direction if they differ by rounding only: a few units in the last place of their parts."""


class Direction(NamedTuple):
    """A direction in which a ray moves, along two axes; with the order of crossings that stay level."""

    x: float
    y: float
    as_listed: Any  # bool


@inline
def _comes_after(data: tuple[Ranks, Direction], i: int, j: int) -> bool:
    """Return True if crossing i comes after crossing j: by place, then along the direction, then across it."""
    ranks, to = data
    if ranks.tied[i] != ranks.tied[j]:
        return ranks.tied[i] > ranks.tied[j]
    x, y = ranks.drift[2 * i] - ranks.drift[2 * j], ranks.drift[2 * i + 1] - ranks.drift[2 * j + 1]
    size = abs(ranks.drift[2 * i]) + abs(ranks.drift[2 * i + 1]) + abs(ranks.drift[2 * j])
    size += abs(ranks.drift[2 * j + 1])
    # A quotient g / (g·d) has an error that grows as its square
    level, along = _LEVEL * (size + size * size) * (abs(to.x) + abs(to.y)), x * to.x + y * to.y
    if abs(along) > level:
        return along > 0.0
    across = y * to.x - x * to.y
    if abs(across) > level:
        return across > 0.0
    return (i > j) == to.as_listed


_sort_crossings = make_sort(_comes_after)


@inline
def _other(k: int) -> int:
    """Return the other crossing of the surface of crossing k."""
    return k - 1 if k & 1 == 0 else k + 1


@inline
def _touches(geometry: Geometry, ranks: Ranks, k: int) -> bool:
    """Return True if crossing k is one of a touch."""
    return k > 0 and ranks.tied[_other(k)] == ranks.tied[k] and is_curved(geometry, ranks.owner[k])


@inline
def _moves(geometry: Geometry, ranks: Ranks, k: int) -> bool:
    """Return True if crossing k has a drift: not the origin, no touch, and not the second one of its plane."""
    return k > 0 and (k & 1 == 1 or is_curved(geometry, ranks.owner[k])) and not _touches(geometry, ranks, k)


@inline
def _end_of_place(geometry: Geometry, ranks: Ranks, first: int) -> tuple[int, int]:
    """Return the end of the place that begins at ranks.order[first], and how many of its crossings have a drift."""
    last, moving = first, 0
    while last < ranks.size[CROSSINGS] and ranks.tied[ranks.order[last]] == ranks.tied[ranks.order[first]]:
        moving += 1 if _moves(geometry, ranks, ranks.order[last]) else 0
        last += 1
    return last, moving


@helper
def find_ties(geometry: Geometry, ranks: Ranks, ray: Ray) -> bool:
    """Sort the crossings by place, and write their drifts. Return True if several surfaces cross the ray in a place."""
    crossings, order, some, first = ranks.size[CROSSINGS], ranks.order, False, 0
    for k in range(crossings):
        order[k], ranks.tied[k] = k, ranks.rank[k]
        ranks.drift[2 * k], ranks.drift[2 * k + 1] = 0.0, 0.0
    _sort_crossings(order, crossings, (ranks, Direction(1.0, 0.0, True)))
    across = 0 if abs(ray.dx) >= max(abs(ray.dy), abs(ray.dz)) else 1 if abs(ray.dy) >= abs(ray.dz) else 2
    while first < crossings:
        last, moving = _end_of_place(geometry, ranks, first)
        some |= moving > 1
        for k in range(first, last if moving > 1 else first):
            this = order[k]
            t = ranks.high[this]
            if this > 0 and math.isfinite(t):
                gx, gy, gz = gradient_at(
                    geometry, ranks.owner[this], ray.ox + t * ray.dx, ray.oy + t * ray.dy, ray.oz + t * ray.dz
                )
                rate = gx * ray.dx + gy * ray.dy + gz * ray.dz
                if rate != 0.0:
                    ranks.drift[2 * this] = (gy if across == 0 else gx) / rate
                    ranks.drift[2 * this + 1] = (gy if across == 2 else gz) / rate
        first = last
    return some


@inline
def _count_orders(moving: int) -> int:
    """Return how many orders of a place with so many moving crossings are tried."""
    return moving * (moving - 1) if moving <= _MOST_PAIRED else _DIRECTIONS


@helper
def _moving(geometry: Geometry, ranks: Ranks, first: int, n: int) -> int:
    """Return moving crossing number n of the place that begins at ranks.order[first]."""
    k = first
    while True:
        if _moves(geometry, ranks, ranks.order[k]):
            if n == 0:
                return whole(ranks.order[k])
            n -= 1
        k += 1


@helper
def _direction_of(geometry: Geometry, ranks: Ranks, first: int, moving: int, number: int) -> Direction:
    """Return the direction of order `number` of a place: across the line through two points, or one of 64."""
    if moving < 2 or moving > _MOST_PAIRED:
        # Around a square: kernels have no sines
        side, along = number & 3, (number // 4 + 0.37) / (_DIRECTIONS // 8) - 1.0
        x, y = (1.0, along) if side & 1 == 0 else (-along, 1.0)
        return Direction(x if side < 2 else -x, y if side < 2 else -y, number & 1 == 0)
    i, j = number // (moving - 1), number % (moving - 1)
    j += 1 if j >= i else 0
    a, b = _moving(geometry, ranks, first, i), _moving(geometry, ranks, first, j)
    x, y = ranks.drift[2 * b + 1] - ranks.drift[2 * a + 1], ranks.drift[2 * a] - ranks.drift[2 * b]
    if not (x != 0.0 or y != 0.0):
        return Direction(1.0, 0.618, i < j)  # surfaces that touch each other: in the order of the list, and against it
    return Direction(x, y, i < j)


@helper
def _break_ties(geometry: Geometry, ranks: Ranks, ray: Ray, to: Direction, slot: int, apart: bool) -> None:
    """Give each crossing a rank of its own, in the order of a ray that lies beside this one in a direction.

    Of the crossings at the origin `slot` come before it; but the one on which the ray starts stays there. Both
    crossings of a touch are around the others of the place, or with `apart` before them.
    """
    crossings, rank, tied, sequence, first = ranks.size[CROSSINGS], ranks.rank, ranks.tied, ranks.sequence, 0
    for k in range(crossings):
        sequence[k] = ranks.order[k]
    _sort_crossings(sequence, crossings, (ranks, to))
    while first < crossings:
        last, next_rank, left = first, float(first), -1
        while last < crossings and tied[sequence[last]] == tied[sequence[first]]:
            left = slot if sequence[last] == 0 else left
            last += 1
        for k in range(first, last):
            this = sequence[k]
            if left == 0:
                rank[0], next_rank, left = next_rank, next_rank + 1.0, -1
            if _touches(geometry, ranks, this):
                end = float(first) - 0.125 if apart else float(last) - 0.75
                rank[this] = float(first) - 0.25 if _other(this) > this else end
            elif _moves(geometry, ranks, this):
                rank[this], next_rank, left = next_rank, next_rank + 1.0, left - 1
                if this & 1 == 1 and not is_curved(geometry, ranks.owner[this]):
                    rank[this + 1] = rank[this]
        if left >= 0:
            rank[0] = next_rank
        first = last
    zero, start = rank[0], ray.start
    starts = start >= 0 and ranks.listed[start] > 0 and ranks.verdict[2 * start] == CROSSES
    if starts:
        for k in range(ranks.first[start], ranks.first[start] + 2):
            zero = rank[k] if tied[k] == 0.0 and not _touches(geometry, ranks, k) else zero
    for k in range(crossings):
        rank[k] -= zero
    if starts:
        for k in range(ranks.first[start], ranks.first[start] + 2):
            rank[k] = 0.0 if tied[k] == 0.0 else rank[k]


@helper
def wall_of_tie(
    geometry: Geometry, stand: Geometry, scratch: Scratch, ranks: Ranks, ray: Ray, count: int, entry: int,
    place_rank: float, enters: bool, wall: tuple[int, int],
) -> tuple[bool, int, int]:  # fmt: skip
    """Return (True, place, sense) of the wall that a crossing of an entry has if it does not have its `wall`.

    wall: surface and face that the crossing has while its place is tied, or -1 for any face. It stays if a ray beside
    this one crosses it there; otherwise that with the lowest face number of those that such rays cross. The entry's
    crossings in scratch are lost.
    """
    first, none = 0, whole(-1)
    if not is_solid(geometry, entry):
        return False, none, none
    while ranks.tied[ranks.order[first]] != place_rank:
        first += 1
    _, moving = _end_of_place(geometry, ranks, first)
    if moving < 2:
        return False, none, none
    stays, best, place, sense = False, none, none, none
    for number in range(_count_orders(moving)):
        _break_ties(geometry, ranks, ray, _direction_of(geometry, ranks, first, moving, number), 0, False)
        put_canonical_surfaces(geometry, stand, scratch, ranks, ray.start, count)
        crossings, _, _ = entry_crossings(stand, scratch, entry, ray_of_ranks(ray.start), 1 << 30)
        for n in range(crossings):
            rank, n_place, n_sense, n_enters = read_crossing(scratch, n)
            surface, face, _ = crossing_face(geometry, entry, n_place, n_sense)
            k = ranks.first[surface]
            k += 0 if ranks.rank[k] == rank else 1
            if n_enters == enters and ranks.tied[k] == place_rank:
                stays |= surface == wall[0] and (face == wall[1] or wall[1] < 0)
                if best < 0 or face < best:
                    best, place, sense = face, n_place, n_sense
        if stays:
            break
    for k in range(ranks.size[CROSSINGS]):
        ranks.rank[k] = ranks.tied[k]
    put_canonical_surfaces(geometry, stand, scratch, ranks, ray.start, count)
    return not stays and best >= 0, place, sense


@helper
def first_of_ranks(
    geometry: Geometry, stand: Geometry, scratch: Scratch, ranks: Ranks, ray: Ray, count: int, tied: bool
) -> Hit:
    """Return the first crossing of the entries scratch.found[:count]; t is the largest reported t at its rank.

    tied: whether places may have several surfaces, as `find_ties` found.
    """
    best, latest = no_hit(), -math.inf
    for k in range(count):
        entry = scratch.found[k]
        find_leaves(geometry, scratch, entry, ray)
        crossings, _ = ranked_crossings(geometry, stand, scratch, ranks, entry, ray)
        rank, place, sense, enters = read_crossing(scratch, 0)
        body = whole(entry)
        if crossings > 0 and rank <= best.t:
            t = scratch.time[0]
            if tied:
                surface, face, _ = crossing_face(geometry, entry, place, sense)
                differs, other, other_sense = wall_of_tie(
                    geometry, stand, scratch, ranks, ray, count, entry, rank, enters, (surface, face)
                )
                if differs:
                    place, sense = other, other_sense
                    t = t_of(ranks, crossing_face(geometry, entry, place, sense)[0], rank)
            # Coinciding crossings report one t, the largest, so that t_min = hit.t passes all of them
            latest = max(latest if rank == best.t else -math.inf, t)
            if comes_first(rank, body, best.t, best.body):
                best = Hit(rank, body, whole(entry), place, sense, enters, 0.0, False)
    forget_leaves(scratch)
    if best.entry < 0:
        return best
    return Hit(latest, best.body, best.entry, best.place, best.sense, best.enters, 0.0, False)


@helper
def _open_touches(geometry: Geometry, scratch: Scratch, ranks: Ranks, count: int) -> int:
    """Make touches crossings. Return 2 if there are touches, or edges of polygons, which are passed in two ways."""
    ways = 1
    for k in range(ranks.size[SURFACES]):
        at = 2 * ranks.surfaces[k]
        ways = 2 if ranks.verdict[at] == TOUCHES else ways
        ranks.verdict[at] = CROSSES if ranks.verdict[at] == TOUCHES else ranks.verdict[at]
    for k in range(count):
        entry = scratch.found[k]
        if integer(geometry, table.ENTRY_KIND, entry) == POLYGON:
            ways = 2 if ranks.loops[integer(geometry, table.ENTRY_INDEX, entry)] >= EDGE else ways
    return ways


@inline
def _put_edges(geometry: Geometry, scratch: Scratch, ranks: Ranks, count: int, inside: bool) -> None:
    """Let the ray pass the edges of polygons inside or outside."""
    for k in range(count):
        entry = scratch.found[k]
        if integer(geometry, table.ENTRY_KIND, entry) == POLYGON:
            polygon = integer(geometry, table.ENTRY_INDEX, entry)
            if ranks.loops[polygon] >= EDGE:
                ranks.loops[polygon] = EDGE + (1 if inside else 0)


@helper
def _differs(
    geometry: Geometry, stand: Geometry, scratch: Scratch, ranks: Ranks, ray: Ray, count: int, hit: Hit, surface: int,
    to: Direction, slots: tuple[int, int], ways: int,
) -> bool:  # fmt: skip
    """Return True if the first hit is another in one order, for any slot of the origin and any way of touches."""
    number, moving = slots
    for slot in range(number):
        for way in range(ways):
            before = slot * moving // max(number - 1, 1)
            _break_ties(geometry, ranks, ray, to, before, way == 1)
            _put_edges(geometry, scratch, ranks, count, way == 1)
            put_canonical_surfaces(geometry, stand, scratch, ranks, ray.start, count)
            other = first_of_ranks(geometry, stand, scratch, ranks, ray, count, False)
            if other.body != hit.body or other.enters != hit.enters:
                return True
            if hit.body >= 0 and hit_surface(geometry, other) != surface:
                return True
    return False


@helper
def hangs_on_tie(
    geometry: Geometry, stand: Geometry, scratch: Scratch, ranks: Ranks, ray: Ray, count: int, hit: Hit
) -> bool:
    """Return True if the first hit of a ray hangs on a tie. Relies on `find_ties`. The ranks are lost."""
    surface, end = -1, math.inf
    if hit.body >= 0:
        surface = hit_surface(geometry, hit)
        k = ranks.first[surface]
        end = ranks.rank[k + 1] if ranks.t[k + 1] <= hit.t else ranks.rank[k]
    ways, at_origin, first, most = _open_touches(geometry, scratch, ranks, count), 0, 0, 0
    while first < ranks.size[CROSSINGS]:
        last, moving = _end_of_place(geometry, ranks, first)
        at_origin = moving if ranks.tied[ranks.order[first]] == 0.0 else at_origin
        most, first = max(most, moving), last
    start = ray.start
    if start >= 0 and ranks.listed[start] > 0 and ranks.verdict[2 * start] == CROSSES:
        at_origin = 0  # the surface on which the ray starts is where the origin is
    slots = min(at_origin + 1, _MOST_SLOTS), at_origin
    if most < 2 and at_origin == 0 and ways == 1:
        return False
    beside = _direction_of(geometry, ranks, 0, 0, 0)
    if _differs(geometry, stand, scratch, ranks, ray, count, hit, surface, beside, slots, ways):
        return True
    first = 0
    while first < ranks.size[CROSSINGS]:
        last, moving = _end_of_place(geometry, ranks, first)
        matters = False
        for k in range(first, last):
            this = ranks.order[k]
            is_ahead = ranks.tied[this] >= 0.0 if ray.t_min == 0.0 else ranks.t[this] > ray.t_min
            matters |= is_ahead and ranks.tied[this] <= end
        for number in range(_count_orders(moving) if matters and moving > 1 else 0):
            to = _direction_of(geometry, ranks, first, moving, number)
            if _differs(geometry, stand, scratch, ranks, ray, count, hit, surface, to, slots, ways):
                return True
        first = last
    return False
