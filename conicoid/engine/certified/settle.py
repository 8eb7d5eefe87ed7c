"""Doubtful rays and points, decided: by numbers with bounds first, by exact arithmetic where those leave it open."""

from __future__ import annotations

from collections.abc import Callable
from typing import TYPE_CHECKING, Any

import numpy as np

from ...exact.forms import line
from ...exact.order import Place, exact_ranks, verdict
from ...exact.outline import passes_within
from ...exact.roots import ZERO, sign
from ...shapes.vector import FloatArray
from .. import tables as table
from ..arrays.first import trace_first_alone
from ..arrays.found import Found
from ..body.hit import is_doubtful
from ..lowering.apart import empty
from ..ray import Ray, RayArrays, scaled_ray
from ..surface.decide import CROSSES, MISSES, Rest
from ..tables import POLYGON, Geometry, length
from ..threads import chunk_size, run_on
from .forms import form
from .kernels import limits_of_hits, ranked_first, ranked_rows, settle_first, settle_rows, surfaces_met
from .membership import located_by_ranks, surfaces_near
from .ranks import CROSSINGS, Doubtful, Ranks, Room
from .stand_ins import room_for_forms

if TYPE_CHECKING:
    from ..prepared import Prepared

_CHUNK = 256


def new_room(scene: Prepared) -> Room:
    """Room for one thread, as large as the scene. Memory is taken only where it is written to."""
    geometry = scene.geometry
    surfaces, polygons = int(length(geometry, table.SURFACE_KIND)), int(length(geometry, table.POLYGON_SURFACE))
    most = 2 * surfaces + 8

    def whole(count: int) -> Any:
        return empty(count, np.int32, sparse=True)

    def real(count: int) -> Any:
        return empty(count, np.float64, sparse=True)

    ranks = Ranks(
        whole(surfaces), whole(surfaces), whole(2 * surfaces), whole(surfaces),
        real(most), real(most), real(most), whole(most), real(most), whole(most), real(most),
        whole(polygons), np.zeros(2, np.int64),
    )  # fmt: skip
    floats = real(len(geometry.floats) + room_for_forms(geometry))
    return Room(scene.rest, Geometry(geometry.places, geometry.integers, floats), ranks)


def halted_with(geometry: Geometry, room: Room) -> Room:
    """The room, whose stand-ins share the flag of `geometry` that ends kernels early."""
    return room._replace(stand=room.stand._replace(places=geometry.places))


def ask(scene: Prepared, kernel: Callable[..., Any], room: Room, *arguments: Any) -> Any:
    """Run a kernel for one ray or point, so that it ends early at Ctrl-C; returns its result."""
    found: list[Any] = []

    def work(geometry: Geometry, begin: int, end: int) -> None:
        found.append(kernel(geometry, halted_with(geometry, room), *arguments))

    run_on(scene.geometry, work, 1, 1, 1)
    return found[0]


def settle_hits(scene: Prepared, rays: RayArrays, doubtful: Any, found: Found) -> None:
    """Decide the first hits of rays that may be doubtful, in place."""
    asked = Doubtful(doubtful.astype(np.int32), np.zeros(len(doubtful), np.int8))
    rooms: list[Room] = []  # as large as the scene, so one for each thread, which its chunks use in turn

    def work(geometry: Geometry, begin: int, end: int) -> None:
        try:
            room = rooms.pop()
        except IndexError:
            room = new_room(scene)
        settle_first(geometry, halted_with(geometry, room), rays, asked, begin, end, found)
        rooms.append(room)

    count = len(doubtful)
    run_on(scene.geometry, work, count, max(_CHUNK, count // 64), count)
    left = asked.which[asked.still == 1].tolist()
    if left:
        room = rooms.pop() if rooms else new_room(scene)
        for i in left:
            rank_exactly(scene, room.ranks, rays, i)
            ask(scene, ranked_first, room, rays, i, found)


def ranks_of(scene: Prepared, rays: RayArrays, i: int) -> tuple[Ranks, bool]:
    """The ranks of all that ray i may cross, as a doubtful ray has them, and whether it took exact arithmetic.

    Of each surface `verdict`, `first` and from there on `rank`, `high`, `low`, `error` and `t` are filled in.
    """
    room, asked = new_room(scene), Doubtful(np.full(1, i, np.int32), np.zeros(1, np.int8))
    ask(scene, settle_first, room, rays, asked, 0, 1, Found.new(len(rays.origins)))
    if asked.still[0]:
        rank_exactly(scene, room.ranks, rays, i)
    return room.ranks, bool(asked.still[0])


def left_doubtful(scene: Prepared, rays: RayArrays, which: Any, found: Found) -> Any:
    """Those of some settled rays that the fast formulas leave open up to their hits, each asked alone.

    Different routes test different bodies beyond the hit, which may be doubtful too; the answer must not depend on it.
    """
    some = rays.some(which)
    t, entry, limits = found.t[which], found.entry[which], np.empty(len(which))
    limits_of_hits(scene.geometry, some._replace(starts=entry), t, entry, limits)
    again, count = Found.new(len(which)), len(which)

    def work(geometry: Geometry, begin: int, end: int) -> None:
        trace_first_alone(geometry, some._replace(t_max=limits), begin, end, again)

    run_on(scene.geometry, work, count, chunk_size(count, 16 * _CHUNK), count)
    return which[is_doubtful(again.turn)]


def settled_rows(scene: Prepared, rays: RayArrays, doubtful: Any, spans: bool) -> list[FloatArray]:
    """The rows of doubtful rays' spans or crossings, an array for each."""
    asked = Doubtful(doubtful.astype(np.int32), np.zeros(len(doubtful), np.int8))
    counts, room = np.zeros(len(doubtful), np.int32), new_room(scene)
    found: list[FloatArray] = []

    def work(geometry: Geometry, begin: int, end: int) -> None:
        found.append(settle_rows(geometry, halted_with(geometry, room), rays, asked, spans, counts))

    run_on(scene.geometry, work, 1, 1, len(doubtful))
    parts = np.split(found[0], np.cumsum(counts)[:-1])
    for k in np.flatnonzero(asked.still).tolist():
        i = int(asked.which[k])
        rank_exactly(scene, room.ranks, rays, i)
        parts[k] = ask(scene, ranked_rows, room, rays, i, spans)
    return parts


def settle_bodies(scene: Prepared, points: FloatArray, after: Any, doubtful: Any, bodies: Any) -> None:
    """Decide in which bodies doubtful points are, the first after a number, in place, by exact arithmetic."""
    if not len(doubtful):
        return
    geometry, room = scene.geometry, new_room(scene)
    ranks, nothing = room.ranks, Rest(*(np.zeros(len(part)) for part in scene.rest))
    for i in doubtful.tolist():
        x, y, z = points[i].tolist()
        here = line((x, y, z), (0.0, 0.0, 0.0))
        for surface in ranks.surfaces[: surfaces_near(geometry, ranks, x, y, z)].tolist():
            ranks.verdict[surface] = sign(form(scene, surface).at(here))
        bodies[i] = ask(scene, located_by_ranks, room._replace(rest=nothing), x, y, z, int(_pick(after, i)))


def _pick(values: Any, i: int) -> float:
    """Value i of an array of one value for all, or of one for each."""
    return float(values[i if len(values) > 1 else 0])


def rank_exactly(scene: Prepared, ranks: Ranks, rays: RayArrays, i: int) -> None:
    """Find the ranks of all that ray i may cross in exact arithmetic, and write them where kernels read them."""
    geometry, tables = scene.geometry, scene.lowered.tables
    entries = np.zeros(len(tables.entry_kind), np.int32)
    surfaces, count = surfaces_met(geometry, ranks, rays, i, entries)
    origins, directions, _, _, starts = rays
    ox, oy, oz = origins[i].tolist()
    dx, dy, dz = directions[i].tolist()
    scaled, _ = scaled_ray(Ray(ox, oy, oz, dx, dy, dz, 0.0, 0.0, -1))
    origin, direction = (scaled.ox, scaled.oy, scaled.oz), (scaled.dx, scaled.dy, scaled.dz)
    ray, start = line(origin, direction), int(_pick(starts, i))
    places: list[Place] = [ZERO]
    for surface in ranks.surfaces[:surfaces].tolist():
        found = verdict(form(scene, surface), ray, surface == start)
        ranks.verdict[2 * surface : 2 * surface + 2] = CROSSES if found.crosses else MISSES, found.sense
        if found.crosses:
            ranks.first[surface] = len(places)
            places += [found.low, found.high]
    ranks.rank[: len(places)] = exact_ranks(places)
    told = [float(t) for t in places]
    ranks.high[: len(places)], ranks.t[: len(places)] = told, told
    ranks.size[CROSSINGS] = len(places)
    for entry in entries[:count].tolist():
        if tables.entry_kind[entry] == POLYGON:
            polygon = int(tables.entry_index[entry])
            ranks.loops[polygon] = passes_within(scene.lowered.exact.outline(polygon), origin, direction)
