"""Doubtful rays and what becomes of them: error bounds first, exact arithmetic for what they leave open."""

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
from ..arrays.first import trace_first
from ..arrays.found import Found
from ..body.hit import DOUBTFUL
from ..packets.load import ALONE
from ..packets.tile import tile_count
from ..ray import Arguments, Ray, scaled_ray
from ..surface.decide import CROSSES, MISSES, Rest
from ..tables import POLYGON, Geometry, length
from ..threads import chunk_size, run_on
from .forms import form
from .kernels import limits_of_hits, ranked_first, ranked_rows, settle_first, settle_rows, surfaces_met
from .membership import locate_ranked, surfaces_near
from .ranks import Ranks

if TYPE_CHECKING:
    from ..prepared import Prepared

_CHUNK = 256


def _memory(geometry: Geometry) -> tuple[Geometry, Ranks]:
    """Room for one thread. Memory from `zeros` is taken only where it is written to."""
    surfaces, polygons = int(length(geometry, table.SURFACE_KIND)), int(length(geometry, table.POLYGON_SURFACE))
    most = 2 * surfaces + 8

    def whole(count: int) -> Any:
        return np.zeros(count, np.int32)

    ranks = Ranks(
        whole(surfaces), whole(surfaces), whole(2 * surfaces), whole(surfaces),
        np.zeros(most), np.zeros(most), np.zeros(most), whole(most), np.zeros(most), whole(most), np.zeros(most),
        whole(polygons), np.zeros(2, np.int64),
    )  # fmt: skip
    return Geometry(geometry.places, geometry.integers, np.zeros(len(geometry.floats))), ranks


def _ask(scene: Prepared, kernel: Callable[..., Any], stand: Geometry, *arguments: Any) -> Any:
    """What a kernel says of one ray or point, which ends early at Ctrl-C."""
    found: list[Any] = []

    def work(geometry: Geometry, begin: int, end: int) -> None:
        found.append(kernel(geometry, stand._replace(places=geometry.places), *arguments))

    run_on(scene.geometry, work, 1, 1, 1)
    return found[0]


def settle_hits(scene: Prepared, arguments: Arguments, doubtful: Any, found: Found) -> None:
    """Decide the first hits of rays that may be doubtful, in place."""
    geometry, rest = scene.geometry, scene.rest
    which, still = doubtful.astype(np.int32), np.zeros(len(doubtful), np.int8)

    def work(geometry: Geometry, begin: int, end: int) -> None:
        stand, ranks = _memory(geometry)
        settle_first(geometry, rest, stand, ranks, *arguments, which, begin, end, *found, still)

    run_on(geometry, work, len(which), max(_CHUNK, len(which) // 64), len(which))
    left = which[still == 1].tolist()
    if left:
        stand, ranks = _memory(geometry)
        for i in left:
            _rank_exactly(scene, ranks, arguments, i)
            _ask(scene, ranked_first, stand, ranks, *arguments, i, *found)


def doubted(scene: Prepared, arguments: Arguments, which: Any, found: Found) -> Any:
    """Those of some settled rays that the fast formulas leave open up to their hits, each asked alone.

    On their way different routes ask different bodies beyond the hit, which may be doubtful as well.
    """
    origins, directions, t_min, t_max, starts = (part if len(part) == 1 else part[which] for part in arguments)
    t, entry, limits = found.t[which], found.entry[which], np.empty(len(which))
    limits_of_hits(scene.geometry, origins, directions, t_max, t, entry, limits)
    again, tiles = Found.new(len(which)), tile_count(ALONE, len(which))
    run_on(
        scene.geometry,
        lambda geometry, a, b: trace_first(
            geometry, origins, directions, t_min, limits, starts, ALONE, a, b, *again
        ),
        tiles,
        chunk_size(tiles, _CHUNK),
        len(which),
    )  # fmt: skip
    return which[again.turn > DOUBTFUL // 2]


def settled_rows(scene: Prepared, arguments: Arguments, doubtful: Any, spans: bool) -> list[FloatArray]:
    """The rows of doubtful rays' spans or crossings, an array for each."""
    geometry, rest = scene.geometry, scene.rest
    which, still = doubtful.astype(np.int32), np.zeros(len(doubtful), np.int8)
    counts, (stand, ranks) = np.zeros(len(doubtful), np.int32), _memory(geometry)
    found: list[FloatArray] = []

    def work(geometry: Geometry, begin: int, end: int) -> None:
        own = stand._replace(places=geometry.places)
        found.append(settle_rows(geometry, rest, own, ranks, *arguments, which, spans, counts, still))

    run_on(geometry, work, 1, 1, len(which))
    parts = np.split(found[0], np.cumsum(counts)[:-1])
    for k in np.flatnonzero(still).tolist():
        i = int(which[k])
        _rank_exactly(scene, ranks, arguments, i)
        parts[k] = _ask(scene, ranked_rows, stand, ranks, *arguments, i, spans)
    return parts


def settle_bodies(scene: Prepared, points: FloatArray, doubtful: Any, bodies: Any) -> None:
    """Decide in which bodies doubtful points are, in place, by exact arithmetic."""
    if not len(doubtful):
        return
    geometry, (stand, ranks) = scene.geometry, _memory(scene.geometry)
    nothing = Rest(*(np.zeros(len(part)) for part in scene.rest))
    for i in doubtful.tolist():
        x, y, z = points[i].tolist()
        here = line((x, y, z), (0.0, 0.0, 0.0))
        for surface in ranks.surfaces[: surfaces_near(geometry, ranks, x, y, z)].tolist():
            ranks.verdict[surface] = sign(form(scene, surface).at(here))
        bodies[i] = _ask(scene, locate_ranked, stand, nothing, ranks, x, y, z)


def _pick(values: Any, i: int) -> float:
    return float(values[i if len(values) > 1 else 0])


def _rank_exactly(scene: Prepared, ranks: Ranks, arguments: Arguments, i: int) -> None:
    """Put the ranks of all that ray i may cross where kernels look for them."""
    geometry, tables = scene.geometry, scene.lowered.tables
    entries = np.zeros(len(tables.entry_kind), np.int32)
    surfaces, count = surfaces_met(geometry, ranks, *arguments, i, entries)
    origins, directions, _, _, starts = arguments
    ox, oy, oz = origins[i].tolist()
    dx, dy, dz = directions[i].tolist()
    scaled, _ = scaled_ray(Ray(ox, oy, oz, dx, dy, dz, 0.0, 0.0, -1))
    origin, direction = scaled[:3], scaled[3:6]
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
    ranks.size[1] = len(places)
    for entry in entries[:count].tolist():
        if tables.entry_kind[entry] == POLYGON:
            polygon = int(tables.entry_index[entry])
            ranks.loops[polygon] = passes_within(scene.lowered.outlines[polygon], origin, direction)
