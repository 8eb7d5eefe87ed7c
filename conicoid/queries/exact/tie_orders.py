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
from ...kernels.numbers.shell_sort import make_sort
from ...kernels.ray import Ray
from ...kernels.surface.exact_crossing import CROSSES, TOUCHES
from ...kernels.surface.polygon_loop import EDGE
from ...kernels.surface.records import gradient_at, is_curved
from ...kernels.tables import POLYGON, Geometry, integer, whole
from .ranks import (
    CROSSINGS,
    SURFACES,
    RankedRay,
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


class Place(NamedTuple):
    """The crossings ranks.order[first:end] in one place of the ray; `moving` of them have a drift."""

    first: int
    end: int
    moving: int


class TiedWall(NamedTuple):
    """The wall that a crossing in a tied place has, by the orders seen so far."""

    stays: Any  # bool: a ray crosses the wall that the crossing has while the place is tied
    face: int  # the lowest face number of those that rays cross, -1 for none
    place: int  # the place and the sense of that face's wall
    sense: int


class Orders(NamedTuple):
    """The orders in which a hit is traced again besides the direction in which the ray moves."""

    hit: Hit
    wall: int  # the surface of the hit, -1 for a miss
    slots: int  # of the origin among the crossings at its place, spread over `at_origin`
    at_origin: int
    ways: int  # 2 where touches and edges of polygons are passed in two ways


@inline
def _comes_after(data: tuple[Ranks, Direction], i: int, j: int) -> bool:
    """Return True if crossing i comes after crossing j: by place, then along the direction, then across it."""
    ranks, to = data
    if ranks.tied[i] != ranks.tied[j]:
        return ranks.tied[i] > ranks.tied[j]
    ix, iy, jx, jy = ranks.drift[2 * i], ranks.drift[2 * i + 1], ranks.drift[2 * j], ranks.drift[2 * j + 1]
    size = abs(ix) + abs(iy) + abs(jx) + abs(jy)
    # A quotient g / (g·d) has an error that grows as its square
    level = _LEVEL * (size + size * size) * (abs(to.x) + abs(to.y))
    along, across = (ix - jx) * to.x + (iy - jy) * to.y, (iy - jy) * to.x - (ix - jx) * to.y
    if abs(along) > level:
        return along > 0.0
    if abs(across) > level:
        return across > 0.0
    return (i > j) == to.as_listed


_sort_crossings = make_sort(_comes_after)


# Crossings of the ray: number 0 is its origin, 2k + 1 and 2k + 2 are of the same surface


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
def _place_at(geometry: Geometry, ranks: Ranks, first: int) -> Place:
    """Return the place that begins at ranks.order[first]."""
    end, moving = first, 0
    while end < ranks.size[CROSSINGS] and ranks.tied[ranks.order[end]] == ranks.tied[ranks.order[first]]:
        moving += 1 if _moves(geometry, ranks, ranks.order[end]) else 0
        end += 1
    return Place(first, end, moving)


@inline
def _starts_on_crossing(ranks: Ranks, start: int) -> bool:
    """Return True if the ray crosses the surface on which it starts."""
    return start >= 0 and ranks.listed[start] > 0 and ranks.verdict[2 * start] == CROSSES


@helper
def find_ties(geometry: Geometry, ranks: Ranks, ray: Ray) -> bool:
    """Sort the crossings by place, and write their drifts. Return True if several surfaces cross the ray in a place."""
    crossings, tied, first = ranks.size[CROSSINGS], False, 0
    for k in range(crossings):
        ranks.order[k], ranks.tied[k] = k, ranks.rank[k]
        ranks.drift[2 * k], ranks.drift[2 * k + 1] = 0.0, 0.0
    _sort_crossings(ranks.order, crossings, (ranks, Direction(1.0, 0.0, True)))
    while first < crossings:
        place = _place_at(geometry, ranks, first)
        if place.moving > 1:
            tied = True
            _put_drifts(geometry, ranks, ray, place)
        first = place.end
    return tied


@helper
def _put_drifts(geometry: Geometry, ranks: Ranks, ray: Ray, place: Place) -> None:
    """Write the drifts of the crossings of a place along the two axes that are not the main one of the ray."""
    main = 0 if abs(ray.dx) >= max(abs(ray.dy), abs(ray.dz)) else 1 if abs(ray.dy) >= abs(ray.dz) else 2
    for n in range(place.first, place.end):
        k = ranks.order[n]
        t = ranks.high[k]
        if k == 0 or not math.isfinite(t):
            continue
        gx, gy, gz = gradient_at(
            geometry, ranks.owner[k], ray.ox + t * ray.dx, ray.oy + t * ray.dy, ray.oz + t * ray.dz
        )
        rate = gx * ray.dx + gy * ray.dy + gz * ray.dz
        if rate != 0.0:
            ranks.drift[2 * k] = (gy if main == 0 else gx) / rate
            ranks.drift[2 * k + 1] = (gy if main == 2 else gz) / rate


# The orders of a place, each by a direction in which the ray moves


@inline
def _count_orders(place: Place) -> int:
    """Return how many orders of a place are tried."""
    return place.moving * (place.moving - 1) if place.moving <= _MOST_PAIRED else _DIRECTIONS


@helper
def _moving_crossing(geometry: Geometry, ranks: Ranks, place: Place, n: int) -> int:
    """Return crossing number n of those of a place that have a drift."""
    for k in range(place.first, place.end):
        if _moves(geometry, ranks, ranks.order[k]):
            if n == 0:
                return whole(ranks.order[k])
            n -= 1
    return whole(-1)


@inline
def _direction_around(number: int) -> Direction:
    """Return one of 64 directions, all around a square: kernels have no sines."""
    side, along = number & 3, (number // 4 + 0.37) / (_DIRECTIONS // 8) - 1.0
    x, y = (1.0, along) if side & 1 == 0 else (-along, 1.0)
    return Direction(x if side < 2 else -x, y if side < 2 else -y, number & 1 == 0)


@helper
def _direction_of(geometry: Geometry, ranks: Ranks, place: Place, number: int) -> Direction:
    """Return the direction of order `number` of a place: across the line through two points, or one of 64."""
    if place.moving > _MOST_PAIRED:
        return _direction_around(number)
    i, j = number // (place.moving - 1), number % (place.moving - 1)
    j += 1 if j >= i else 0
    a, b = _moving_crossing(geometry, ranks, place, i), _moving_crossing(geometry, ranks, place, j)
    x, y = ranks.drift[2 * b + 1] - ranks.drift[2 * a + 1], ranks.drift[2 * a] - ranks.drift[2 * b]
    if not (x != 0.0 or y != 0.0):
        return Direction(1.0, 0.618, i < j)  # surfaces that touch each other: in the order of the list, and against it
    return Direction(x, y, i < j)


@helper
def _break_ties(of: RankedRay, to: Direction, slot: int, apart: bool) -> None:
    """Give each crossing a rank of its own, in the order of a ray that lies beside this one in a direction.

    Of the crossings at the origin `slot` come before it; but the one on which the ray starts stays there. Both
    crossings of a touch are around the others of the place, or with `apart` before them.
    """
    ranks, first = of.ranks, 0
    for k in range(ranks.size[CROSSINGS]):
        ranks.sequence[k] = ranks.order[k]
    _sort_crossings(ranks.sequence, ranks.size[CROSSINGS], (ranks, to))
    while first < ranks.size[CROSSINGS]:
        end = _place_at(of.geometry, ranks, first).end
        _rank_place(of.geometry, ranks, first, end, slot, apart)
        first = end
    _shift_ranks(of.geometry, ranks, of.ray.start)


@inline
def _rank_place(geometry: Geometry, ranks: Ranks, first: int, end: int, slot: int, apart: bool) -> None:
    """Write ranks from `first` on to the crossings ranks.sequence[first:end] of one place; see `_break_ties`."""
    rank, sequence, next_rank, left = ranks.rank, ranks.sequence, float(first), -1
    for n in range(first, end):
        left = slot if sequence[n] == 0 else left
    for n in range(first, end):
        k = sequence[n]
        if left == 0:
            rank[0], next_rank, left = next_rank, next_rank + 1.0, -1
        if _touches(geometry, ranks, k):
            behind = float(first) - 0.125 if apart else float(end) - 0.75
            rank[k] = float(first) - 0.25 if _other(k) > k else behind
        elif _moves(geometry, ranks, k):
            rank[k], next_rank, left = next_rank, next_rank + 1.0, left - 1
            if k & 1 == 1 and not is_curved(geometry, ranks.owner[k]):
                rank[k + 1] = rank[k]
    if left >= 0:
        rank[0] = next_rank


@inline
def _shift_ranks(geometry: Geometry, ranks: Ranks, start: int) -> None:
    """Shift the ranks such that the origin has 0: the crossing of the surface on which the ray starts, if it has one.

    Touches of that surface are left where they are; then each of its crossings at the origin gets 0.
    """
    rank, zero, starts = ranks.rank, ranks.rank[0], _starts_on_crossing(ranks, start)
    first = ranks.first[start] if starts else 0
    for k in range(first, first + 2 if starts else first):
        zero = rank[k] if ranks.tied[k] == 0.0 and not _touches(geometry, ranks, k) else zero
    for k in range(ranks.size[CROSSINGS]):
        rank[k] -= zero
    for k in range(first, first + 2 if starts else first):
        rank[k] = 0.0 if ranks.tied[k] == 0.0 else rank[k]


@helper
def _restore_ties(of: RankedRay) -> None:
    """Undo `_break_ties`."""
    for k in range(of.ranks.size[CROSSINGS]):
        of.ranks.rank[k] = of.ranks.tied[k]
    put_canonical_surfaces(of)


# The face of a crossing, and the first hit


@helper
def wall_of_tie(
    of: RankedRay, entry: int, place_rank: float, enters: bool, wall: tuple[int, int]
) -> tuple[bool, int, int]:
    """Return (True, place, sense) of the wall that a crossing of an entry has if it does not have its `wall`.

    wall: surface and face that the crossing has while its place is tied, or -1 for any face. It stays if a ray beside
    this one crosses it there; otherwise that with the lowest face number of those that such rays cross. The entry's
    crossings in scratch are lost.
    """
    geometry, ranks, first, none = of.geometry, of.ranks, 0, whole(-1)
    if not is_solid(geometry, entry):
        return False, none, none
    while ranks.tied[ranks.order[first]] != place_rank:
        first += 1
    here = _place_at(geometry, ranks, first)
    if here.moving < 2:
        return False, none, none
    found = TiedWall(False, none, none, none)
    for number in range(_count_orders(here)):
        _break_ties(of, _direction_of(geometry, ranks, here, number), 0, False)
        put_canonical_surfaces(of)
        found = _wall_in_order(of, entry, place_rank, enters, wall, found)
        if found.stays:
            break
    _restore_ties(of)
    return not found.stays and found.face >= 0, found.place, found.sense


@inline
def _wall_in_order(
    of: RankedRay, entry: int, place_rank: float, enters: bool, wall: tuple[int, int], known: TiedWall
) -> TiedWall:
    """Return the wall of a crossing after one more order of its place, whose canonical surfaces are put."""
    geometry, ranks = of.geometry, of.ranks
    stays, lowest, place, sense = known.stays, known.face, known.place, known.sense
    crossings, _, _ = entry_crossings(of.stand, of.scratch, entry, ray_of_ranks(of.ray.start), 1 << 30)
    for n in range(crossings):
        rank, n_place, n_sense, n_enters = read_crossing(of.scratch, n)
        surface, face, _ = crossing_face(geometry, entry, n_place, n_sense)
        k = ranks.first[surface]
        k += 0 if ranks.rank[k] == rank else 1
        if n_enters == enters and ranks.tied[k] == place_rank:
            stays |= surface == wall[0] and (face == wall[1] or wall[1] < 0)
            if lowest < 0 or face < lowest:
                lowest, place, sense = face, n_place, n_sense
    return TiedWall(stays, lowest, place, sense)


@helper
def first_of_ranks(of: RankedRay, tied: bool) -> Hit:
    """Return the first crossing of the ray; t is the largest reported t at its rank.

    tied: whether places may have several surfaces, as `find_ties` found.
    """
    geometry, scratch, best, latest = of.geometry, of.scratch, no_hit(), -math.inf
    for k in range(of.entry_count):
        entry = scratch.found[k]
        find_leaves(geometry, scratch, entry, of.ray)
        crossings, _ = ranked_crossings(of, entry)
        rank, place, sense, enters = read_crossing(scratch, 0)
        body = whole(entry)
        if crossings > 0 and rank <= best.t:
            t = scratch.time[0]
            if tied:
                surface, face, _ = crossing_face(geometry, entry, place, sense)
                differs, other, other_sense = wall_of_tie(of, entry, rank, enters, (surface, face))
                if differs:
                    place, sense = other, other_sense
                    t = t_of(of.ranks, crossing_face(geometry, entry, place, sense)[0], rank)
            # Coinciding crossings report one t, the largest, so that t_min = hit.t passes all of them
            latest = max(latest if rank == best.t else -math.inf, t)
            if comes_first(rank, body, best.t, best.body):
                best = Hit(rank, body, whole(entry), place, sense, enters, 0.0, False)
    forget_leaves(scratch)
    if best.entry < 0:
        return best
    return Hit(latest, best.body, best.entry, best.place, best.sense, best.enters, 0.0, False)


# Whether the first hit hangs on a tie: it is traced again in each order


@helper
def _open_touches(of: RankedRay) -> int:
    """Make touches crossings. Return 2 if there are touches, or edges of polygons, which are passed in two ways."""
    geometry, ranks, ways = of.geometry, of.ranks, 1
    for k in range(ranks.size[SURFACES]):
        at = 2 * ranks.surfaces[k]
        if ranks.verdict[at] == TOUCHES:
            ranks.verdict[at], ways = CROSSES, 2
    for k in range(of.entry_count):
        entry = of.scratch.found[k]
        if integer(geometry, table.ENTRY_KIND, entry) == POLYGON:
            ways = 2 if ranks.loops[integer(geometry, table.ENTRY_INDEX, entry)] >= EDGE else ways
    return ways


@inline
def _put_edges(of: RankedRay, inside: bool) -> None:
    """Let the ray pass the edges of polygons inside or outside."""
    for k in range(of.entry_count):
        entry = of.scratch.found[k]
        if integer(of.geometry, table.ENTRY_KIND, entry) == POLYGON:
            polygon = integer(of.geometry, table.ENTRY_INDEX, entry)
            if of.ranks.loops[polygon] >= EDGE:
                of.ranks.loops[polygon] = EDGE + (1 if inside else 0)


@helper
def _differs(of: RankedRay, orders: Orders, to: Direction) -> bool:
    """Return True if the first hit is another in a direction, for any slot of the origin and any way of touches."""
    hit = orders.hit
    for slot in range(orders.slots):
        for way in range(orders.ways):
            _break_ties(of, to, slot * orders.at_origin // max(orders.slots - 1, 1), way == 1)
            _put_edges(of, way == 1)
            put_canonical_surfaces(of)
            other = first_of_ranks(of, False)
            if other.body != hit.body or other.enters != hit.enters:
                return True
            if hit.body >= 0 and hit_surface(of.geometry, other) != orders.wall:
                return True
    return False


@helper
def _matters(ranks: Ranks, ray: Ray, place: Place, last: float) -> bool:
    """Return True if a crossing of a place is ahead of the start of the interval, and not beyond the place `last`."""
    for n in range(place.first, place.end):
        k = ranks.order[n]
        is_ahead = ranks.tied[k] >= 0.0 if ray.t_min == 0.0 else ranks.t[k] > ray.t_min
        if is_ahead and ranks.tied[k] <= last:
            return True
    return False


@helper
def hangs_on_tie(of: RankedRay, hit: Hit) -> bool:
    """Return True if the first hit of a ray hangs on a tie. Relies on `find_ties`. The ranks are lost."""
    geometry, ranks, wall, last = of.geometry, of.ranks, whole(-1), math.inf
    if hit.body >= 0:
        wall = whole(hit_surface(geometry, hit))
        k = ranks.first[wall]
        last = ranks.rank[k + 1] if ranks.t[k + 1] <= hit.t else ranks.rank[k]
    ways, at_origin, first, most = _open_touches(of), 0, 0, 0
    while first < ranks.size[CROSSINGS]:
        place = _place_at(geometry, ranks, first)
        at_origin = place.moving if ranks.tied[ranks.order[first]] == 0.0 else at_origin
        most, first = max(most, place.moving), place.end
    if _starts_on_crossing(ranks, of.ray.start):
        at_origin = 0  # the surface on which the ray starts is where the origin is
    if most < 2 and at_origin == 0 and ways == 1:
        return False
    orders = Orders(hit, wall, min(at_origin + 1, _MOST_SLOTS), at_origin, ways)
    if _differs(of, orders, _direction_around(0)):
        return True
    first = 0
    while first < ranks.size[CROSSINGS]:
        place = _place_at(geometry, ranks, first)
        if place.moving > 1 and _matters(ranks, of.ray, place, last):
            for number in range(_count_orders(place)):
                if _differs(of, orders, _direction_of(geometry, ranks, place, number)):
                    return True
        first = place.end
    return False
