"""The compiled loops behind the queries: chunks of rays in, arrays out."""

from __future__ import annotations

import math
from typing import Any

import numpy as np

from ..geometry import tables as table
from ..geometry.tables import Floats, Geometry, Ints, Ray, Signs, integer
from ..geometry.vectors import dot
from ..jit import allocator, fma, inline, kernel
from .events import entry_crossings, is_solid
from .kernels import blocked, collect, first_crossing, from_center, no_hit, normal_at, scaled_ray, uv_at
from .packet import LANES, SIZE, is_hit, packet_hit, put_ray, trace_packet
from .scratch import new_scratch

_SEVERAL = 4.0
DEAD = -2
"""Start of a ray that does not exist: the continuation of a miss."""


@kernel
def first_invalid(origins: Floats, directions: Floats) -> tuple[int, int]:
    """(index, reason) of the first ray that cannot be traced, (-1, 0) if none.

    Reasons: 1 the origin is not finite, 2 the direction is not finite, 3 the direction is zero.
    """
    for i in range(len(origins)):
        x, y, z = directions[i, 0], directions[i, 1], directions[i, 2]
        if not (math.isfinite(origins[i, 0]) and math.isfinite(origins[i, 1]) and math.isfinite(origins[i, 2])):
            return i, 1
        if not (math.isfinite(x) and math.isfinite(y) and math.isfinite(z)):
            return i, 2
        if x == 0.0 and y == 0.0 and z == 0.0:
            return i, 3
    return -1, 0


@inline
def load_ray(origins: Floats, directions: Floats, t_min: Floats, t_max: Floats, starts: Ints, i: int) -> Ray:
    """Ray i; t_min, t_max and starts hold one value for all or one for each."""
    start = np.int64(starts[i if len(starts) > 1 else 0])
    first, last = t_min[i if len(t_min) > 1 else 0], t_max[i if len(t_max) > 1 else 0]
    ox, oy, oz = origins[i, 0], origins[i, 1], origins[i, 2]
    return ox, oy, oz, directions[i, 0], directions[i, 1], directions[i, 2], first, last, start  # type: ignore[return-value]


@inline
def ray_of_lane(packet: int, lane: int, width: int, count: int) -> int:
    """The ray in a lane: 64 in a row, or 8 x 8 of a picture of some width; -1 beyond the end."""
    if width == 0:
        i = 64 * packet + lane
        return i if i < count else -1
    across = (width + 7) >> 3
    x, y = 8 * (packet % across) + (lane & 7), 8 * (packet // across) + (lane >> 3)
    i = y * width + x
    return i if x < width and i < count else -1


@inline
def coherent(
    geometry: Geometry, origins: Floats, directions: Floats, t_min: Floats, starts: Ints, packet: int, width: int
) -> bool:
    """Do the rays of a packet see about the same part of the scene?

    Their origins and, at the far end of the scene, their points must lie within a few times the
    size that a body has when the scene's box is shared out among all. Rays that start on a surface
    with t_min < 0, or whose directions are not of ordinary length, go one by one.
    """
    extent = geometry.places[table.EXTENT, 0]
    diagonal, cell = geometry.floats[extent], geometry.floats[extent + 1]
    first = -1
    spread, apart = 0.0, 0.0
    ox, oy, oz, dx, dy, dz, reach = 0.0, 0.0, 0.0, 0.0, 0.0, 0.0, 0.0
    for lane in range(LANES):
        i = ray_of_lane(packet, lane, width, len(origins))
        if i < 0:
            continue
        x, y, z = directions[i, 0], directions[i, 1], directions[i, 2]
        length = math.sqrt(x * x + y * y + z * z)
        start = starts[i if len(starts) > 1 else 0]
        if not 1e-30 < length < 1e30 or start == DEAD or (start >= 0 and t_min[i if len(t_min) > 1 else 0] < 0.0):
            return False
        x, y, z = x / length, y / length, z / length
        if first < 0:
            first = i
            ox, oy, oz, dx, dy, dz = origins[i, 0], origins[i, 1], origins[i, 2], x, y, z
            cx, cy, cz = geometry.floats[extent + 2], geometry.floats[extent + 3], geometry.floats[extent + 4]
            reach = math.sqrt((ox - cx) ** 2 + (oy - cy) ** 2 + (oz - cz) ** 2) + 0.5 * diagonal
        spread = max(spread, max(abs(x - dx), max(abs(y - dy), abs(z - dz))))
        apart = max(apart, abs(origins[i, 0] - ox) + abs(origins[i, 1] - oy) + abs(origins[i, 2] - oz))
    return spread * reach + apart <= _SEVERAL * cell


@inline
def fill_lanes(
    lanes: Floats, origins: Floats, directions: Floats, t_min: Floats, t_max: Floats, starts: Ints,
    packet: int, width: int,
) -> None:  # fmt: skip
    """The rays of a packet into its lanes; those beyond the end stay idle."""
    for lane in range(LANES):
        i = ray_of_lane(packet, lane, width, len(origins))
        put_ray(lanes, lane, load_ray(origins, directions, t_min, t_max, starts, max(i, 0)), i < 0)


@kernel
def trace_first(
    geometry: Geometry, origins: Floats, directions: Floats, t_min: Floats, t_max: Floats, starts: Ints,
    width: int, begin: int, end: int, t: Floats, ids: Ints, flags: Signs,
) -> None:  # fmt: skip
    """First hits of packets begin..end of 64 rays: t, ids (n, 3) body, surface, face, flags (n, 2) side, entered."""
    scratch, lanes = new_scratch(geometry), np.empty(SIZE)
    for packet in range(begin, end):
        together = coherent(geometry, origins, directions, t_min, starts, packet, width)
        if together:
            fill_lanes(lanes, origins, directions, t_min, t_max, starts, packet, width)
            trace_packet(geometry, scratch, lanes, False)
        for lane in range(LANES):
            i = ray_of_lane(packet, lane, width, len(origins))
            if i < 0:
                continue
            hit = no_hit()
            if together:
                hit = packet_hit(geometry, lanes, lane)
            else:
                ray = load_ray(origins, directions, t_min, t_max, starts, i)
                if ray[8] != DEAD:
                    hit = first_crossing(geometry, scratch, ray, scratch.nothing, False)
            t[i], ids[i, 0], ids[i, 1], ids[i, 2] = hit[0], hit[1], hit[2], hit[3]
            flags[i, 0], flags[i, 1] = hit[4], 1 if hit[5] else 0


@kernel
def trace_occluded(
    geometry: Geometry, origins: Floats, directions: Floats, t_min: Floats, t_max: Floats, starts: Ints,
    width: int, begin: int, end: int, result: Any,
) -> None:  # fmt: skip
    """Is there any crossing? Of packets begin..end of 64 rays."""
    scratch, lanes = new_scratch(geometry), np.empty(SIZE)
    for packet in range(begin, end):
        together = coherent(geometry, origins, directions, t_min, starts, packet, width)
        if together:
            fill_lanes(lanes, origins, directions, t_min, t_max, starts, packet, width)
            trace_packet(geometry, scratch, lanes, True)
        for lane in range(LANES):
            i = ray_of_lane(packet, lane, width, len(origins))
            if i < 0:
                continue
            if together:
                result[i] = is_hit(lanes, lane)
            else:
                ray = load_ray(origins, directions, t_min, t_max, starts, i)
                result[i] = ray[8] != DEAD and blocked(geometry, scratch, ray, scratch.nothing)


@allocator
def _grown(table: Floats) -> Floats:
    larger = np.empty((2 * len(table), table.shape[1]))
    larger[: len(table)] = table
    return larger


@allocator
def _sort_rows(rows: Floats, first: int, last: int, columns: int) -> None:
    """Order rows by their first columns (few rows: by insertion)."""
    for i in range(first + 1, last):
        row = rows[i].copy()
        j = i
        while j > first:
            later = False
            for k in range(columns):
                if rows[j - 1, k] != row[k]:
                    later = rows[j - 1, k] > row[k]
                    break
            if not later:
                break
            rows[j] = rows[j - 1]
            j -= 1
        rows[j] = row


@kernel
def trace_spans(
    geometry: Geometry, origins: Floats, directions: Floats, t_min: Floats, t_max: Floats, starts: Ints,
    begin: int, end: int, counts: Any,
) -> Floats:  # fmt: skip
    """Rows (t_enter, body, t_exit, enter clipped, exit clipped), ordered within each ray; counts[i] rows for ray i."""
    scratch = new_scratch(geometry)
    rows = np.empty((max(64, 4 * (end - begin)), 5))
    used = 0
    for i in range(begin, end):
        whole = load_ray(origins, directions, t_min, t_max, starts, i)
        counts[i] = 0
        if whole[8] == DEAD or not whole[6] < whole[7]:
            continue
        ray, scale = scaled_ray(whole)
        first = used
        for k in range(collect(geometry, scratch, ray)):
            entry = scratch.found[k]
            if not is_solid(geometry, entry):
                continue
            crossings, inside = entry_crossings(geometry, scratch, entry, ray, 1 << 30)
            enter, clipped = ray[6], 1.0
            for c in range(crossings + 1):
                at_end = c == crossings
                if inside:
                    if used == len(rows):
                        rows = _grown(rows)
                    rows[used, 0] = whole[6] if clipped == 1.0 else enter * scale
                    rows[used, 1] = integer(geometry, table.ENTRY_BODY, entry)
                    rows[used, 2] = whole[7] if at_end else scratch.cross_t[c] * scale
                    rows[used, 3] = clipped
                    rows[used, 4] = 1.0 if at_end else 0.0
                    used += 1
                if not at_end:
                    inside = not inside
                    enter, clipped = scratch.cross_t[c], 0.0
        _sort_rows(rows, first, used, 2)
        counts[i] = used - first
    return rows[:used].copy()


@kernel
def trace_crossings(
    geometry: Geometry, origins: Floats, directions: Floats, t_min: Floats, t_max: Floats, starts: Ints,
    begin: int, end: int, counts: Any,
) -> Floats:  # fmt: skip
    """Rows (t, body, face, surface, side, entered), ordered within each ray; counts[i] rows for ray i."""
    scratch = new_scratch(geometry)
    rows = np.empty((max(64, 4 * (end - begin)), 6))
    used = 0
    for i in range(begin, end):
        ray = load_ray(origins, directions, t_min, t_max, starts, i)
        counts[i] = 0
        if ray[8] == DEAD:
            continue
        ray, scale = scaled_ray(ray)
        first = used
        for k in range(collect(geometry, scratch, ray)):
            entry = scratch.found[k]
            crossings, _ = entry_crossings(geometry, scratch, entry, ray, 1 << 30)
            for c in range(crossings):
                if used == len(rows):
                    rows = _grown(rows)
                rows[used, 0] = scratch.cross_t[c] * scale
                rows[used, 1] = integer(geometry, table.ENTRY_BODY, entry)
                rows[used, 2] = scratch.crossing[4 * c + 1]
                rows[used, 3] = scratch.crossing[4 * c]
                rows[used, 4] = scratch.crossing[4 * c + 2]
                rows[used, 5] = scratch.crossing[4 * c + 3]
                used += 1
        _sort_rows(rows, first, used, 3)
        counts[i] = used - first
    return rows[:used].copy()


@kernel
def points_along(origins: Floats, directions: Floats, t: Floats, begin: int, end: int, points: Floats) -> None:
    """origin + t direction with one rounding; NaN for misses."""
    for i in range(begin, end):
        for k in range(3):
            points[i, k] = fma(t[i], directions[i, k], origins[i, k]) if t[i] < math.inf else math.nan


@kernel
def normals_of(
    geometry: Geometry, ids: Ints, flags: Signs, points: Floats, begin: int, end: int, normals: Floats
) -> None:
    """Outward unit normals at hit points; NaN for misses."""
    for i in range(begin, end):
        x, y, z = math.nan, math.nan, math.nan
        if ids[i, 1] >= 0:
            x, y, z = normal_at(geometry, ids[i, 1], flags[i, 0], points[i, 0], points[i, 1], points[i, 2])
        normals[i, 0], normals[i, 1], normals[i, 2] = x, y, z


@kernel
def uvs_of(geometry: Geometry, ids: Ints, points: Floats, begin: int, end: int, uv: Floats) -> None:
    """uv coordinates of hit points; NaN for misses."""
    for i in range(begin, end):
        u, v = math.nan, math.nan
        if ids[i, 0] >= 0:
            u, v = uv_at(geometry, ids[i, 0], ids[i, 2], ids[i, 1], points[i, 0], points[i, 1], points[i, 2])
        uv[i, 0], uv[i, 1] = u, v


@kernel
def local_points_of(
    geometry: Geometry, frames: Floats, body_frame: Ints, ids: Ints, points: Floats, begin: int, end: int, local: Floats
) -> None:
    """Hit points in the own frames of their bodies; NaN for misses."""
    for i in range(begin, end):
        body = ids[i, 0]
        if body < 0:
            local[i, 0], local[i, 1], local[i, 2] = math.nan, math.nan, math.nan
            continue
        row = body_frame[body]
        if row < 0:
            own = from_center(geometry, -1 - row, ids[i, 1], points[i, 0], points[i, 1], points[i, 2])
            local[i, 0], local[i, 1], local[i, 2] = own
            continue
        for k in range(3):
            f = frames[row]
            local[i, k] = dot(f[k, 0], f[k, 1], f[k, 2], points[i, 0], points[i, 1], points[i, 2]) + f[k, 3]
