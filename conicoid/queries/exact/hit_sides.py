"""The bodies before and after hits: in floats first, then by ranks (ranks.py) where rounding might change them."""

from __future__ import annotations

import math
from typing import Any, NamedTuple

import numpy as np

from ..._jit.decorators import helper, inline, kernel, record_shapes
from ...kernels.body.boolean import read_crossing
from ...kernels.body.entry import entry_crossings, is_solid
from ...kernels.body.media import AFTER, BEFORE, BLOCKER, Sides, body_after, body_before, no_sides, sides_at, with_body
from ...kernels.body.scratch import Scratch, new_scratch
from ...kernels.ray import Ray, RayArrays, load_ray, scale_ray
from ...kernels.tables import Floats, Geometry, Ints, Signs, is_halted, whole
from ...kernels.threads import KernelRange, chunk_size, run_on
from ...prepare.prepared_scene import PreparedScene
from .doubtful_rays import (
    limits_of_hits,
    new_rank_scratch,
    prepare_ranked_ray,
    put_exact_ranks,
    run_one,
    share_halt_flag,
)
from .ranks import (
    Doubtful,
    RankedRay,
    RankScratch,
    clear_stand,
    find_leaves,
    forget_leaves,
    rank_ray,
    ray_of_ranks,
    t_of,
)

_SIDE_CHUNK = 4096  # hits that a thread takes at a time, at most
_FEW = 256  # doubtful hits that a thread takes at a time, at least
_EVERY = 1 << 30  # as many crossings of an entry as there are


@record_shapes(t="n", surface="n", entry="n", turn="n")
class HitPlaces(NamedTuple):
    """Hits of rays: t, surface, entry of the tree (-1 for a miss), and `turn` as in `HitBuffers`."""

    t: Floats
    surface: Ints
    entry: Ints
    turn: Signs

    def some(self, which: Any) -> HitPlaces:
        """Return the hits with these numbers."""
        return HitPlaces(*(part[which] for part in self))


@inline
def _put(sides: Ints, i: int, found: Sides) -> None:
    """Write the bodies before and after a hit, and the opaque one that is crossed, to column i."""
    sides[BEFORE, i], sides[AFTER, i], sides[BLOCKER, i] = body_before(found), body_after(found), found.blocker


@kernel(kinds="body_face", begin="0..end", end="0..n", sides="out 3 n", doubts="out n")
def trace_sides(
    geometry: Geometry,
    rays: RayArrays,
    places: HitPlaces,
    kinds: Signs,
    begin: int,
    end: int,
    sides: Ints,
    doubts: Signs,
) -> None:
    """Write sides (3, n): the bodies before and after hits, and the opaque one that is crossed; -1 for none.

    Misses have -1 throughout. doubts[i] becomes 1 where rounding might change the sides.
    """
    scratch = new_scratch(geometry)
    for i in range(begin, end):
        sides[BEFORE, i], sides[AFTER, i], sides[BLOCKER, i], doubts[i] = -1, -1, -1, 0
        if places.entry[i] < 0 or is_halted(geometry):
            continue
        ray, scale = scale_ray(load_ray(rays, i))
        surface, entry = whole(places.surface[i]), whole(places.entry[i])
        found, unsure = sides_at(geometry, scratch, ray, places.t[i] / scale, surface, entry, kinds)
        _put(sides, i, found)
        doubts[i] = 1 if unsure else 0


@helper
def _rank_of_hit(of: RankedRay, t: float, surface: int, entry: int, enters: bool) -> float:
    """Return the rank of a hit: of the crossing nearest to t, of the same entry and sense, where its surface crosses.

    NaN if there is none. The crossing itself may have another surface of that place (tie_orders.py).
    """
    scratch, ranks = of.scratch, of.ranks
    find_leaves(of.geometry, scratch, entry, of.ray)
    count, _, _ = entry_crossings(of.stand, scratch, entry, ray_of_ranks(of.ray.start), _EVERY)
    rank, best, first = math.nan, math.inf, ranks.first[surface]
    for n in range(count):
        at, _, _, turned = read_crossing(scratch, n)
        if turned == enters and (ranks.rank[first] == at or ranks.rank[first + 1] == at):
            gap = abs(t_of(ranks, surface, at) - t)
            if gap < best or math.isnan(rank):
                rank, best = at, gap
    return rank


@helper
def _sides_of_rank(of: RankedRay, rank: float, kinds: Signs) -> Sides:
    """Return the bodies before and after a rank."""
    scratch, sides = of.scratch, no_sides()
    for k in range(of.entry_count):
        entry = scratch.found[k]
        find_leaves(of.geometry, scratch, entry, of.ray)
        crossings, was, _ = entry_crossings(of.stand, scratch, entry, ray_of_ranks(of.ray.start), _EVERY)
        solid, crossed, now = is_solid(of.geometry, entry), False, was
        for n in range(crossings):
            at = read_crossing(scratch, n)[0]
            was ^= solid and at < rank
            now ^= solid and at <= rank
            crossed |= at == rank
        body = whole(entry)
        sides = with_body(sides, body, kinds[body], crossed, was, now)
    forget_leaves(scratch)
    return sides


@helper
def _put_ranked_sides(
    geometry: Geometry, room: RankScratch, scratch: Scratch, ray: Ray, count: int, scale: float, i: int,
    places: HitPlaces, kinds: Signs, sides: Ints,
) -> None:  # fmt: skip
    """Write the sides of hit i of a ray whose ranks are known."""
    of = RankedRay(geometry, room.stand, scratch, room.ranks, ray, count)
    t, surface, entry = places.t[i] / scale, whole(places.surface[i]), whole(places.entry[i])
    enters = places.turn[i] == 2 or places.turn[i] == -2
    _put(sides, i, _sides_of_rank(of, _rank_of_hit(of, t, surface, entry, enters), kinds))


@kernel(
    room="out", doubtful="out", kinds="body_face", begin="0..end", end="0..m", sides="out 3 n",
)  # fmt: skip
def settle_sides(
    geometry: Geometry,
    room: RankScratch,
    rays: RayArrays,
    doubtful: Doubtful,
    places: HitPlaces,
    kinds: Signs,
    begin: int,
    end: int,
    sides: Ints,
) -> None:
    """Write the sides of doubtful hits begin to end, on rays cut off around them; mark the undecided."""
    scratch = new_scratch(geometry)
    for k in range(begin, end):
        if is_halted(geometry):
            break
        i = doubtful.which[k]
        ray, scale = scale_ray(load_ray(rays, i))
        count = rank_ray(geometry, room, scratch, ray)
        doubtful.undecided[k] = 1 if count < 0 else 0
        if count >= 0:
            _put_ranked_sides(geometry, room, scratch, ray, count, scale, i, places, kinds, sides)
        clear_stand(room.stand, room.ranks)


@kernel(room="out", kinds="body_face", i="0..n-1", sides="out 3 n")
def ranked_sides(
    geometry: Geometry, room: RankScratch, rays: RayArrays, i: int, places: HitPlaces, kinds: Signs, sides: Ints
) -> None:
    """Write the sides of hit i on a ray with ranks from exact arithmetic."""
    scratch, (ray, scale) = new_scratch(geometry), scale_ray(load_ray(rays, i))
    count = prepare_ranked_ray(geometry, room, scratch, ray)
    _put_ranked_sides(geometry, room, scratch, ray, count, scale, i, places, kinds, sides)
    clear_stand(room.stand, room.ranks)


def _writable(array: Any) -> Any:
    """Return the array, or a copy if it is read-only or not contiguous: kernels are compiled for one kind only."""
    return array if array.flags.writeable and array.flags.c_contiguous else array.copy()


def sides_of(scene: PreparedScene, rays: RayArrays, places: HitPlaces) -> Ints:
    """Return int32 (3, n): the bodies before and after hits, and the first opaque one crossed there; -1 for none."""
    kinds, count = scene.kinds, len(places.t)
    rays, places = RayArrays(*map(_writable, rays)), HitPlaces(*map(_writable, places))
    sides, doubts = np.empty((3, count), np.int32), np.zeros(count, np.int8)
    work = KernelRange(trace_sides, (rays, places, kinds), (sides, doubts))
    run_on(scene.geometry, work, count, chunk_size(count, _SIDE_CHUNK), count)
    doubtful = np.flatnonzero(doubts)
    if len(doubtful):
        sides[:, doubtful] = _resolve_sides(scene, rays.some(doubtful), places.some(doubtful), kinds)
    return sides


def _resolve_sides(scene: PreparedScene, rays: RayArrays, places: HitPlaces, kinds: Signs) -> Ints:
    """Return `sides_of` for doubtful hits, decided with certainty."""
    count = len(places.t)
    limits, sides = np.empty(count), np.full((3, count), -1, np.int32)
    every = rays._replace(t_max=np.array([math.inf]), starts=places.entry)  # any start >= 0 has the widest limits
    limits_of_hits(scene.geometry, every, places.t, places.entry, limits)
    width = 4 * (limits - places.t + np.spacing(np.abs(places.t)))
    rays = rays._replace(t_min=places.t - width, t_max=places.t + width)
    undecided = Doubtful(np.arange(count, dtype=np.int32), np.zeros(count, np.int8))

    def work(geometry: Geometry, begin: int, end: int) -> None:
        room = share_halt_flag(geometry, new_rank_scratch(scene))
        settle_sides(geometry, room, rays, undecided, places, kinds, begin, end, sides)

    run_on(scene.geometry, work, count, max(_FEW, count // 64), count)
    left = undecided.which[undecided.undecided == 1].tolist()
    if left:
        room = new_rank_scratch(scene)
        for i in left:
            put_exact_ranks(scene, room.ranks, rays, i)
            run_one(scene, ranked_sides, room, rays, i, places, kinds, sides)
    return sides


__all__ = ["sides_of"]
