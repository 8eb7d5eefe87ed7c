"""Paths that go on, and rays to sources that wait: collected from many packets, and traced together in streams.

What was scattered goes anywhere. One by one such rays cost three times what they do in streams of an octant each, of
some hundred or more (measured: 1,000 balls, bounces of 32 samples of 64 pixels); so they wait for those of other
samples. Where a ray is traced changes no bit of what it meets.
"""

from __future__ import annotations

from typing import NamedTuple

import numpy as np

from ..compiler.jit import allocator, helper, inline
from ..engine.body.hit import Hit, no_hit
from ..engine.body.scratch import Scratch
from ..engine.packets.lanes import LANES
from ..engine.ray import Ray, scaled_ray
from ..engine.single.first import first_crossing
from ..engine.streams.stream import Stream, new_stream, octant_of, put_stream_ray, stream_hit, trace_stream
from ..engine.tables import Floats, Geometry, Longs, Signs, whole
from .vertex import Asked, Path

BATCH = 32
"""So many samples of a square of pixels are traced together."""
ROOM = BATCH * LANES
_STATE, _ASK, _HIT = 21, 14, 8
_END = 7
"""The column of a ray's end in both; what belongs to it follows."""
_PLACE = 20
_ALONE, _KINDS = 8, 9
"""Rays are of one of eight octants, or alone."""
_FEW = 4
"""So many rays are traced one by one."""
PATHS, ASKS, ROUND = 0, 1, 2
"""What is counted: rows of both in use, and packets since the pool was emptied."""


class Pool(NamedTuple):
    """Memory of one thread. The first rows of tables are in use."""

    paths: Floats  # (ROOM, _STATE) a ray, a `Path`, the place of its light: 64 · sample + pixel
    asks: Floats  # (ROOM, _ASK) a ray to a source, the place of its light, rgb, the body it is to meet, its medium
    hits: Floats  # (ROOM, _HIT) what the rays of one of them meet
    counts: Longs  # (3,)
    order: Longs  # (ROOM,) rows by octant
    kinds: Longs  # (ROOM,) each row's octant
    begins: Longs  # (_KINDS + 1,) where in the order an octant's rows begin
    stream: Stream


@allocator
def new_pool(geometry: Geometry) -> Pool:
    """Memory for one thread."""
    return Pool(
        np.empty((ROOM, _STATE)), np.empty((ROOM, _ASK)), np.empty((ROOM, _HIT)), np.zeros(3, np.int64),
        np.empty(ROOM, np.int64), np.empty(ROOM, np.int64), np.empty(_KINDS + 1, np.int64), new_stream(geometry, ROOM),
    )  # fmt: skip


@inline
def ray_in(row: Floats) -> Ray:
    """The ray in a row."""
    return Ray(row[0], row[1], row[2], row[3], row[4], row[5], 0.0, row[_END], whole(row[6]))


@inline
def _put_ray(row: Floats, ray: Ray) -> None:
    row[0], row[1], row[2], row[3], row[4], row[5], row[6], row[_END] = (
        ray.ox, ray.oy, ray.oz, ray.dx, ray.dy, ray.dz, ray.start, ray.t_max,
    )  # fmt: skip


@inline
def put_path(row: Floats, path: Path, ray: Ray, place: int) -> None:
    """A path and its ray into a row."""
    _put_ray(row, ray)
    row[8], row[9], row[10], row[11], row[12], row[13], row[14] = (
        path.r, path.g, path.b, path.density, path.x, path.y, path.z,
    )  # fmt: skip
    row[15], row[16], row[17], row[18], row[19] = path.scale, path.medium, path.turns, path.wave, path.passed
    row[_PLACE] = place


@inline
def path_in(row: Floats) -> tuple[Path, int]:
    """(the path in a row, its place)."""
    path = Path(
        row[8], row[9], row[10], row[11], row[12], row[13], row[14], row[15], whole(row[16]), whole(row[17]), row[18],
        whole(row[19]),
    )  # fmt: skip
    return path, whole(row[_PLACE])


@inline
def put_ask(row: Floats, asked: Asked, start: int, place: int) -> None:
    """A ray to a source, from the surface `start`, and what it brings, into a row."""
    _put_ray(row, Ray(asked.x, asked.y, asked.z, asked.d[0], asked.d[1], asked.d[2], 0.0, asked.end, start))
    row[8], row[9], row[10], row[11], row[12], row[13] = place, asked.r, asked.g, asked.b, asked.body, asked.medium


@inline
def ask_in(row: Floats) -> tuple[int, float, float, float, int, int]:
    """(place, rgb, the body that is to be met first, the medium that the ray starts in) of a row."""
    return whole(row[8]), row[9], row[10], row[11], whole(row[12]), whole(row[13])


@inline
def put_hit(row: Floats, hit: Hit) -> None:
    """A hit into a row."""
    row[0], row[1], row[2], row[3], row[4], row[5], row[6] = (
        hit.t, hit.body, hit.entry, hit.place, hit.sense, 1.0 if hit.enters else 0.0, hit.off,
    )  # fmt: skip


@inline
def hit_in(row: Floats) -> Hit:
    """The hit in a row."""
    return Hit(row[0], whole(row[1]), whole(row[2]), whole(row[3]), whole(row[4]), row[5] != 0.0, row[6], False)


@helper
def _sort(pool: Pool, rows: Floats, count: int) -> None:
    """Rows into the order of their rays' octants; those keep theirs that have the same."""
    begins = pool.begins
    for kind in range(_KINDS + 1):
        begins[kind] = 0
    for k in range(count):
        ray = ray_in(rows[k])
        kind = octant_of(ray.dx, ray.dy, ray.dz) if scaled_ray(ray)[1] == 1.0 else _ALONE
        pool.kinds[k] = kind
        begins[kind + 1] += 1
    for kind in range(_KINDS):
        begins[kind + 1] += begins[kind]
    for k in range(count):
        kind = pool.kinds[k]
        pool.order[begins[kind]] = k
        begins[kind] += 1


@helper
def trace_rows(
    geometry: Geometry, scratch: Scratch, pool: Pool, rows: Floats, count: int, blocks: Signs, any_hit: bool
) -> None:
    """What the rays of the first `count` rows meet first, or any, into `hits`.

    Only bodies with blocks[body] != 0 count, or all, if `blocks` is empty.
    """
    _sort(pool, rows, count)
    first, stream = whole(0), pool.stream
    for kind in range(_KINDS):
        end = pool.begins[kind]  # as sorting has moved it on
        together = kind != _ALONE and end - first > _FEW
        if together:
            for j in range(first, end):
                put_stream_ray(stream, j - first, ray_in(rows[pool.order[j]]))
            trace_stream(geometry, scratch, stream, end - first, blocks, any_hit)
        for j in range(first, end):
            k = pool.order[j]
            hit = stream_hit(stream, j - first) if together else no_hit()
            if not together or hit.unsure:  # single rays doubt less
                hit = first_crossing(geometry, scratch, ray_in(rows[k]), blocks, any_hit)
            put_hit(pool.hits[k], hit)
        first = end
