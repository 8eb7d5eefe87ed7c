"""The lanes of a packet: 64 rays side by side, a row of 64 floats for each of their numbers; loading and reading them.

All rows are in one block of floats, integers too, at places that are constants to the compiler: so it sees that a loop
over lanes does not read what it writes, and vectorises it. Lanes are unsigned numbers, else the compiler would have to
allow for indices that count from the end.
"""

from __future__ import annotations

import math
from typing import Any

import numpy as np

from ..._jit.decorators import choose, helper, inline
from ..._util.validation import LARGEST, SMALLEST
from .. import tables as table
from ..body.cell import PlaneSlab
from ..body.hit import Hit, comes_first, cull_limit, may_tie
from ..bvh.culling import (
    BEAM,
    FIRST,
    HIGH_I,
    HIGH_O,
    LAST,
    LOW_I,
    LOW_O,
    copy_points,
    extent,
    extents,
    load_eight,
    reach,
)
from ..bvh.walk import reciprocal
from ..ray import DEAD, Ray, RayArrays, RayLine, are_traceable, start_margin
from ..surface.doubt import STARTING
from ..surface.interval import Nearness, is_open, limits_along, ray_size, ray_unit
from ..tables import Floats, Geometry, whole

LANES = 64
GROUPS = LANES // 8

# Begins of the rows. Culling tests rely on the order of the first fourteen
(
    OX, OY, OZ, IX, IY, IZ, T_MIN, T_MAX, WITHIN, DX, DY, DZ, INVERSE, UNIT, START, BEST, BODY, ENTRY, PLACE, SENSE,
    ENTERS, A, B, C, DISCRIMINANT, FOOT, T_IN, T_OUT, PLACE_IN, PLACE_OUT, LOW, HIGH, FLAG, TURN, NOW, NEXT, INSIDE,
    SEEKS, NARROW_IN, NARROW_OUT, FOUND, NEW_PLACE, NEW_SENSE, NEW_ENTERS, ORIGIN_SIZE, START_SIZE, UNSURE, DOUBT,
    LATEST, ENDS, OFF, OWN,
) = (np.uint64(row) for row in range(0, 52 * LANES, LANES))  # fmt: skip
BEAM_AT = 52 * LANES
ALL = np.uint64(LANES)
SOME_START = BEAM_AT + BEAM
"""Not 0 if some lane starts on a surface."""
SLOPES = BEAM_AT + BEAM + 1
"""Not 0 once the inverse directions are computed."""
SHARED = BEAM_AT + BEAM + 2
"""Not 0 if all lanes have one origin."""
SPREAD = BEAM_AT + BEAM + 3
"""Largest difference between two lanes in a component of the direction."""
LEAST_START = BEAM_AT + BEAM + 4
"""Least `Ray.start` of the lanes."""
GROUP_BEAMS = BEAM_AT + BEAM + 5
"""Not 0 once the beams of the eight groups are computed."""
WAYS_AT = BEAM_AT + BEAM + 6
"""The corners of the beam's directions, whose inverses are in the beam: three least, three greatest."""
GROUPS_AT = WAYS_AT + 6
"""The beams of the eight groups: the numbers of a beam, eight of each."""
GROUP_ENDS = GROUPS_AT + GROUPS * LAST
START_MARGIN = GROUPS_AT + GROUPS * BEAM
"""Largest `start_margin` of the lanes."""
SIZE = START_MARGIN + 1


@inline
def eights(first: int, last: int) -> tuple[Any, Any]:
    """Return the same two multiples of 8 in [0, 64], masked so that the compiler can prove that property."""
    return np.uint64(first) & np.uint64(56), np.uint64(last) & np.uint64(120)


@inline
def put_ray(lanes: Floats, i: Any, ray: Ray) -> None:
    """Write a ray to lane i."""
    ox, oy, oz, dx, dy, dz, t_min, t_max, start = ray
    i = np.uint64(i)
    lanes[OX + i], lanes[OY + i], lanes[OZ + i] = ox + 0.0, oy + 0.0, oz + 0.0
    lanes[DX + i], lanes[DY + i], lanes[DZ + i] = dx, dy, dz
    lanes[T_MIN + i], lanes[T_MAX + i], lanes[START + i] = t_min, t_max, start


@inline
def put_limits(lanes: Floats, t_min: float, t_max: float, start: int) -> None:
    """Write one interval and start to all lanes."""
    for i in range(ALL):
        lanes[T_MIN + i], lanes[T_MAX + i], lanes[START + i] = t_min, t_max, start


@inline
def put_origin(lanes: Floats, x: float, y: float, z: float) -> None:
    """Write one origin to all lanes."""
    for i in range(ALL):
        lanes[OX + i], lanes[OY + i], lanes[OZ + i] = x, y, z


@inline
def put_line(lanes: Floats, i: Any, origins: Floats, directions: Floats, k: Any) -> None:
    """Write origin and direction k to lane i; -0 becomes +0 (`load_ray`)."""
    i, k = np.uint64(i), np.uint64(k)
    lanes[OX + i], lanes[OY + i], lanes[OZ + i] = origins[k, 0] + 0.0, origins[k, 1] + 0.0, origins[k, 2] + 0.0
    lanes[DX + i], lanes[DY + i], lanes[DZ + i] = directions[k, 0] + 0.0, directions[k, 1] + 0.0, directions[k, 2] + 0.0


@inline
def put_idle(lanes: Floats, i: Any, like: Any) -> None:
    """Make lane i idle: it repeats the ray of lane `like`, with an empty interval."""
    i, like = np.uint64(i), np.uint64(like)
    lanes[OX + i], lanes[OY + i], lanes[OZ + i] = lanes[OX + like], lanes[OY + like], lanes[OZ + like]
    lanes[DX + i], lanes[DY + i], lanes[DZ + i] = lanes[DX + like], lanes[DY + like], lanes[DZ + like]
    # Numbers of a real ray, so that idle lanes neither widen the beam nor divide by 0
    lanes[T_MIN + i], lanes[T_MAX + i], lanes[START + i] = lanes[T_MIN + like], -math.inf, lanes[START + like]


@inline
def prepare_lanes(lanes: Floats) -> None:
    """Compute the other rows from the rays, without hits and doubts; required before lanes are traced."""
    for i in range(ALL):
        dx, dy, dz = lanes[DX + i], lanes[DY + i], lanes[DZ + i]
        # One division for each ray; planes, spheres and quadrics multiply
        inverse = 1.0 / (dx * dx + dy * dy + dz * dz)
        unit = ray_unit(dx, dy, dz, inverse)
        size = ray_size(lanes[OX + i], lanes[OY + i], lanes[OZ + i], unit)
        lanes[INVERSE + i], lanes[UNIT + i], lanes[ORIGIN_SIZE + i] = inverse, unit, size
        # `choose` is a select, which vectorises; a branch would not
        lanes[START_SIZE + i] = choose(lanes[START + i] >= 0.0, size * STARTING, size)
        lanes[BEST + i], lanes[WITHIN + i], lanes[DOUBT + i] = math.inf, math.inf, 0.0
        lanes[BODY + i], lanes[ENTRY + i], lanes[PLACE + i] = -1.0, -1.0, -1.0
        lanes[SENSE + i], lanes[ENTERS + i] = 1.0, 0.0
    lanes[SLOPES], lanes[GROUP_BEAMS] = 0.0, 0.0
    lanes[LEAST_START], last = extent(lanes, START)
    lanes[SOME_START] = 1.0 if last >= 0.0 else 0.0
    margin = 0.0
    if lanes[SOME_START] != 0.0:
        for i in range(ALL):
            margin = max(margin, start_margin(lanes[START + i], lanes[OX + i], lanes[OY + i], lanes[OZ + i]))
    lanes[START_MARGIN] = margin


@inline
def put_slopes(lanes: Floats) -> None:
    """Compute the inverse directions unless they exist; only box tests need them."""
    if lanes[SLOPES] == 0.0:
        for i in range(ALL):
            lanes[IX + i], lanes[IY + i] = reciprocal(lanes[DX + i]), reciprocal(lanes[DY + i])
            lanes[IZ + i] = reciprocal(lanes[DZ + i])
        lanes[SLOPES] = 1.0


@inline
def put_lane_beam(lanes: Floats, shared: bool) -> None:
    """Compute the beam that holds all lanes, where t >= 0 or the lanes are parallel; `shared`: they share an origin."""
    spread, apart = 0.0, 0.0
    for axis in range(3):  # rows OX, OY, OZ and DX, DY, DZ follow each other
        row = np.uint64(LANES * axis)
        # One origin for all: the first lane stands for it
        first = last = lanes[OX + row]
        if not shared:
            first, last = extent(lanes, OX + row)
        low, high = extent(lanes, DX + row)
        lanes[BEAM_AT + LOW_O + axis], lanes[BEAM_AT + HIGH_O + axis] = first, last
        lanes[BEAM_AT + LOW_I + axis], lanes[BEAM_AT + HIGH_I + axis] = reciprocal(low), reciprocal(high)
        lanes[WAYS_AT + axis], lanes[WAYS_AT + 3 + axis] = low, high
        spread, apart = max(spread, high - low), max(apart, last - first)
    lanes[SHARED], lanes[SPREAD] = 1.0 if apart == 0.0 else 0.0, spread
    lanes[BEAM_AT + FIRST] = extent(lanes, T_MIN)[0]
    shorten_beam(lanes)


@helper
def put_group_beams(lanes: Floats) -> None:
    """Compute the beams of the eight groups of a packet, for t >= 0 without an end."""
    for axis in range(3):
        row, low, high = np.uint64(LANES * axis), GROUPS_AT + 8 * axis, GROUPS_AT + 24 + 8 * axis
        extents(lanes, OX + row, low, high)
        extents(lanes, DX + row, low + 48, high + 48)
    for k in range(48):
        at = np.uint64(GROUPS_AT + 48 + k)
        lanes[at] = reciprocal(lanes[at])
    for k in range(8):
        lanes[np.uint64(GROUPS_AT + 8 * FIRST + k)], lanes[np.uint64(GROUP_ENDS + k)] = 0.0, math.inf
    lanes[GROUP_BEAMS] = 1.0


@inline
def close_lanes(lanes: Floats, count: int) -> None:
    """Prepare lanes for tracing after rays were written to the first `count`; the others become idle."""
    for i in range(count, LANES):
        put_idle(lanes, i, 0)
    prepare_lanes(lanes)
    put_lane_beam(lanes, False)


@inline
def put_beam_from(lanes: Floats, x: float, y: float, z: float) -> None:
    """Replace the beam by that from a point, where all lanes end at t = 1, back to their origins: it is narrower."""
    for axis in range(3):
        source = x if axis == 0 else (y if axis == 1 else z)
        low, high = extent(lanes, OX + np.uint64(LANES * axis))
        lanes[BEAM_AT + LOW_O + axis], lanes[BEAM_AT + HIGH_O + axis] = source, source
        # From the light to the origins; t runs from 0 at the light to 1
        low, high = low - source, high - source
        lanes[BEAM_AT + LOW_I + axis], lanes[BEAM_AT + HIGH_I + axis] = reciprocal(low), reciprocal(high)
        lanes[WAYS_AT + axis], lanes[WAYS_AT + 3 + axis] = low, high


@inline
def shorten_beam(lanes: Floats) -> None:
    """End the beam where the last of its lanes does."""
    lanes[BEAM_AT + LAST] = reach(lanes)


@inline
def lane_sight(lanes: Floats) -> tuple[float, float]:
    """Return (t of the furthest hit of the lanes, 0 for none; number of lanes with a hit)."""
    furthest, hits = 0.0, 0.0
    for i in range(ALL):
        t = lanes[BEST + i]
        # Misses do not count: they would put the horizon at infinity
        furthest = max(furthest, choose(t < math.inf, t, 0.0))
        hits += choose(t < math.inf, 1.0, 0.0)
    return furthest, hits


@inline
def lane_ray(lanes: Floats, i: Any, t_max: float) -> Ray:
    """Return the ray in lane i, up to t_max."""
    i = np.uint64(i)
    return Ray(
        lanes[OX + i], lanes[OY + i], lanes[OZ + i], lanes[DX + i], lanes[DY + i], lanes[DZ + i],
        lanes[T_MIN + i], t_max, whole(lanes[START + i]),
    )  # fmt: skip


@inline
def lane_nearness(lanes: Floats, i: int, lengths: Nearness) -> Nearness:
    """Convert limits from lengths to t of a lane."""
    return limits_along(lengths, lanes[UNIT + i], lanes[ORIGIN_SIZE + i], lanes[START_SIZE + i])


@inline
def lane_line(lanes: Floats, i: Any) -> RayLine:
    """Return origin and direction of a lane."""
    return RayLine(lanes[OX + i], lanes[OY + i], lanes[OZ + i], lanes[DX + i], lanes[DY + i], lanes[DZ + i])


@inline
def lane_line_from(lanes: Floats, i: Any, x: float, y: float, z: float) -> RayLine:
    """Return the line of a lane whose origin (x, y, z) all lanes share."""
    return RayLine(x, y, z, lanes[DX + i], lanes[DY + i], lanes[DZ + i])


@inline
def lane_slab(lanes: Floats, i: Any) -> PlaneSlab:
    """Return the slab that the planes of a cell have left of a lane so far."""
    return PlaneSlab(lanes[T_IN + i], lanes[T_OUT + i], lanes[PLACE_IN + i], lanes[PLACE_OUT + i])


@inline
def put_slab(lanes: Floats, i: Any, slab: PlaneSlab) -> None:
    """Write the slab of a lane."""
    lanes[T_IN + i], lanes[T_OUT + i] = slab.t_in, slab.t_out
    lanes[PLACE_IN + i], lanes[PLACE_OUT + i] = slab.place_in, slab.place_out


@inline
def keep_nearer(lanes: Floats, i: int, new: Hit) -> None:
    """Keep the nearer of a lane's hit and a new one, by the rule of `nearer_hit`.

    Equal t is always doubtful here: the single ray that follows decides whether both lie on the same surface.
    """
    best, limit = lanes[BEST + i], lanes[WITHIN + i]
    closer = comes_first(new.t, new.body, best, lanes[BODY + i])
    unsure = new.unsure | may_tie(new.t, new.off, best, limit - best)
    lanes[DOUBT + i] = choose(unsure, 1.0, lanes[DOUBT + i])
    lanes[BEST + i] = choose(closer, new.t, best)
    lanes[WITHIN + i] = choose(closer, cull_limit(new), limit)
    lanes[BODY + i] = choose(closer, new.body, lanes[BODY + i])
    lanes[ENTRY + i] = choose(closer, new.entry, lanes[ENTRY + i])
    lanes[PLACE + i] = choose(closer, new.place, lanes[PLACE + i])
    lanes[SENSE + i] = choose(closer, new.sense, lanes[SENSE + i])
    lanes[ENTERS + i] = choose(closer, 1.0 if new.enters else 0.0, lanes[ENTERS + i])


@inline
def is_searching(lanes: Floats, i: Any) -> bool:
    """True if lane i has a ray whose interval is not empty."""
    return is_open(lanes[T_MIN + i], lanes[T_MAX + i])


@inline
def put_turns(lanes: Floats) -> int:
    """Write the turns of the hits (`turn_of`) without doubt; return the number of doubtful lanes."""
    doubtful = 0
    for i in range(ALL):
        lanes[TURN + i] = lanes[SENSE + i] * (1.0 + lanes[ENTERS + i])
        doubtful += 1 if lanes[DOUBT + i] != 0.0 else 0
    return doubtful


@inline
def lane_hit(lanes: Floats, i: Any) -> Hit:
    """Return the hit of lane i."""
    i = np.uint64(i)
    t = lanes[BEST + i]
    # WITHIN is t + off: the difference is off, up to the rounding of the sum
    off = lanes[WITHIN + i] - t if t < math.inf else 0.0
    return Hit(
        t, whole(lanes[BODY + i]), whole(lanes[ENTRY + i]), whole(lanes[PLACE + i]),
        whole(lanes[SENSE + i]), lanes[ENTERS + i] == 1.0, off, lanes[DOUBT + i] != 0.0,
    )  # fmt: skip


# Packets of an array of rays
#
# If the rays make a picture, a packet is a square of 8 x 8 pixels, else 64 consecutive rays.

_SEVERAL = 4.0  # extent of coherent rays, in sizes of a body's share of the scene


@inline
def packets_across(width: int) -> int:
    """Return how many packets lie side by side in a picture."""
    return (width + 7) >> 3


@inline
def packet_row(packet: int, row: int, width: int, count: int) -> tuple[int, int]:
    """Return (first ray, number of rays) of one of the eight rows of a packet; `width` is 0 for a list of rays."""
    if width == 0:
        i = LANES * packet + 8 * row
        return i, max(0, min(8, count - i))
    across = packets_across(width)
    x, y = 8 * (packet % across), 8 * (packet // across) + row
    return y * width + x, min(8, width - x) if y * width < count else 0


@inline
def fill_lanes(lanes: Floats, rays: RayArrays, packet: int, width: int, shared: bool) -> None:
    """Load the rays of a packet; lanes beyond the end are idle. `shared`: all lanes hold their origin already."""
    origins, directions, t_min, t_max, starts = rays
    one_min, one_max, one_start = len(t_min) == 1, len(t_max) == 1, len(starts) == 1
    # The common case, one interval for all; others overwrite it below
    put_limits(lanes, t_min[0], t_max[0], starts[0])
    for row in range(8):
        i, n = packet_row(packet, row, width, len(origins))
        if n == 8:
            if not shared:
                load_eight(origins, i, lanes, OX + np.uint64(8 * row))
            load_eight(directions, i, lanes, DX + np.uint64(8 * row))
        else:
            for k in range(n):
                put_line(lanes, 8 * row + k, origins, directions, i + k)
        if not (one_min and one_max and one_start):
            for k in range(n):
                lane = np.uint64(8 * row + k)
                lanes[T_MIN + lane] = t_min[0 if one_min else i + k]
                lanes[T_MAX + lane] = t_max[0 if one_max else i + k]
                lanes[START + lane] = starts[0 if one_start else i + k]
        for k in range(n, 8):
            put_idle(lanes, 8 * row + k, 0)
    prepare_lanes(lanes)
    put_lane_beam(lanes, shared)


@inline
def is_ordinary(lanes: Floats) -> bool:
    """True if the rays may be traced as a packet.

    Not if a direction is far from unit length, or a ray begins before its origin. Parallel lines that do not start on a
    surface may begin anywhere.
    """
    shortest, longest = extent(lanes, INVERSE)
    in_range = shortest > 1e-60 and longest < 1e60 and lanes[LEAST_START] != DEAD
    # Before their origins rays of a pencil cross over, so that no beam of corners holds them
    if lanes[BEAM_AT + FIRST] < 0.0:
        in_range &= lanes[SOME_START] == 0.0 and lanes[SPREAD] == 0.0
    return in_range


@helper
def is_coherent(geometry: Geometry, lanes: Floats) -> bool:
    """True if the rays of a packet are coherent: they see about the same part of the scene.

    Their origins and, at the far end of the scene, their points must lie within a few times the size of a body's share
    of the scene's box.
    """
    if not is_ordinary(lanes):
        return False
    at, floats = geometry.places[table.EXTENT], geometry.floats
    diagonal, cell = floats[at], floats[at + 1]
    # From the first lane's origin to the far end of the scene
    ox, oy, oz = lanes[OX] - floats[at + 2], lanes[OY] - floats[at + 3], lanes[OZ] - floats[at + 4]
    reach = math.sqrt(ox * ox + oy * oy + oz * oz) + 0.5 * diagonal
    spread = 0.0
    for axis in range(3):
        spread += lanes[BEAM_AT + HIGH_O + axis] - lanes[BEAM_AT + LOW_O + axis]
    return lanes[SPREAD] * math.sqrt(lanes[INVERSE]) * reach + spread <= _SEVERAL * cell


# Copies of arrays of rays

_EVERY, _FIRST_AXES = 0xFFFFFF, 0x249249  # bits of eight points (`copy_points`): of all numbers, and of each x
_STREAMED = 1 << 17  # rays from which on a copy is written past the caches, which would not hold it


@inline
def copy_run(
    origins: Floats, directions: Floats, first: int, own_origins: Floats, own_directions: Floats, at: int, count: int
) -> int:
    """Copy `count` rays from row `first` of two arrays to row `at` of two others; return 0 if all can be traced."""
    wrong, streamed = 0, 1 if len(own_origins) >= _STREAMED else 0
    for k in range(0, count & -8, 8):
        wrong |= copy_points(origins, first + k, own_origins, at + k, SMALLEST, LARGEST, streamed) & _EVERY
        bits = copy_points(directions, first + k, own_directions, at + k, SMALLEST, LARGEST, streamed)
        zeros = bits >> 24
        wrong |= bits & _EVERY | zeros & zeros >> 1 & zeros >> 2 & _FIRST_AXES
    for k in range(count & -8, count):
        ox, oy, oz = origins[first + k, 0], origins[first + k, 1], origins[first + k, 2]
        dx, dy, dz = directions[first + k, 0], directions[first + k, 1], directions[first + k, 2]
        own_origins[at + k, 0], own_origins[at + k, 1], own_origins[at + k, 2] = ox, oy, oz
        own_directions[at + k, 0], own_directions[at + k, 1], own_directions[at + k, 2] = dx, dy, dz
        wrong |= 0 if are_traceable(ox, oy, oz, dx, dy, dz) & ((dx != 0.0) | (dy != 0.0) | (dz != 0.0)) else 1
    return wrong
