"""What other kernels ask of a scene: the nearest crossing, occlusion, the media on both sides, normals, uv."""

from __future__ import annotations

import math
import sys
from typing import Any, TypeAlias

import numpy as np

from ..geometry import tables as table
from ..geometry.cell import NO_PLACE, anchor_of, cell_spans, load_plane, load_quadric, load_sphere
from ..geometry.nearness import along, beyond, lengths_of_ball, nearness_of
from ..geometry.quadric import Sphere, quadric_gradient, sphere_roots
from ..geometry.tables import BALL, CELL, PLANE, SPHERE, Geometry, Ints, Ray, Signs, integer, length, real, whole
from ..geometry.vectors import dot, normalized
from ..jit import helper, inline
from .entries import crossed_face, entry_crossings, entry_nearness, entry_sides
from .events import at_start, counts_in, crossing, span_inverse, surface_of
from .leaf import Item, leaf_at, leaf_ball, leaf_item, leaf_range
from .scratch import Scratch, new_scratch
from .simd import LAST, balls_met, lowest_bit
from .walk import ITS_CODE, ITS_T, OWN_BEAM, on_stack, push_node, push_roots, put_beam, walk

Hit: TypeAlias = tuple[float, Any, Any, Any, Any, Any, float, Any]
"""t, body, entry, place, sense, entered: `crossed_face` makes the middle ones a surface, a face and a side.

Then by how much rounding may have moved t, and whether anything of the answer is doubtful for it."""

_FAR = 2.0**100
_LARGEST = sys.float_info.max


@inline
def _finite(t: float, scaled: float) -> float:
    """A scaled end of an interval; beyond all crossings, but finite, if it was."""
    return scaled if abs(scaled) < math.inf or abs(t) == math.inf else math.copysign(_LARGEST, t)


@inline
def scaled_ray(ray: Ray) -> tuple[Ray, float]:
    """The ray with a direction whose squares neither overflow nor underflow, by a power of two; and that power."""
    ox, oy, oz, dx, dy, dz, t_min, t_max, start = ray
    largest = max(abs(dx), max(abs(dy), abs(dz)))
    if 1.0 / _FAR < largest < _FAR:
        return ray, 1.0
    scale = math.ldexp(1.0, -math.frexp(largest)[1]) if largest > 1e-300 else math.ldexp(1.0, 1000)
    low, high = _finite(t_min, t_min / scale), _finite(t_max, t_max / scale)
    return (ox, oy, oz, dx * scale, dy * scale, dz * scale, low, high, start), scale


@inline
def scene_tree(geometry: Geometry) -> int:
    """The number of the tree over all entries."""
    return length(geometry, table.TREE_ROOT) - 2


@inline
def no_hit() -> Hit:
    nothing = np.int64(-1)
    return math.inf, nothing, nothing, nothing, np.int64(1), False, 0.0, False


@inline
def certain(hit: Hit, off: float, unsure: bool) -> Hit:
    """A hit with what is said of its certainty."""
    return hit[0], hit[1], hit[2], hit[3], hit[4], hit[5], off, unsure


@inline
def within(hit: Hit) -> float:
    """Nothing beyond can be the nearer crossing."""
    return hit[0] + hit[6]


@inline
def nearer(geometry: Geometry, best: Hit, new: Hit) -> Hit:
    """The nearer of two hits; equal t goes to the body listed first.

    Where rounding might have changed which it is, the answer is doubtful; not where both are on the same
    surface: then they are at the same t, whatever it is.
    """
    unsure = best[7] | new[7]
    if abs(new[0] - best[0]) <= new[6] + best[6]:
        unsure |= new[0] != best[0] or resolved_surface(geometry, new) != resolved_surface(geometry, best)
    closer = new[0] < best[0] or (new[0] == best[0] and new[1] < best[1])
    return certain(new, new[6], unsure) if closer else certain(best, best[6], unsure)


@inline
def resolved_surface(geometry: Geometry, hit: Hit) -> int:
    """The surface of a hit."""
    return crossed_face(geometry, hit[2], hit[3], hit[4])[0]


@inline
def try_ball(geometry: Geometry, item: Item, sphere: Sphere, ray: Ray, inverse: float, best: Hit) -> Hit:
    """`try_entry` for a ball."""
    ox, oy, oz, dx, dy, dz, _, _, start = ray
    _, surface, body, entry = item
    low, high, _, crosses, unsure = sphere_roots(sphere, ox, oy, oz, dx, dy, dz, inverse, surface == start)
    nearness = along(ray, inverse, lengths_of_ball(sphere[0], sphere[1], sphere[2], sphere[3]))
    unsure |= nearness[1] < 0.0
    if not crosses:
        return certain(best, best[6], best[7] | unsure)
    unsure |= at_start(low, surface, ray, nearness) | at_start(high, surface, ray, nearness)
    enters = counts_in(low, surface, ray)
    t = low if enters else high
    if enters or counts_in(high, surface, ray):
        return nearer(geometry, best, (t, body, entry, whole(NO_PLACE), whole(1), enters, nearness[0], unsure))
    return certain(best, best[6], best[7] | unsure)


@inline
def try_cell(geometry: Geometry, item: Item, ray: Ray, inverse: float, best: Hit) -> Hit:
    """`try_entry` for a cell."""
    _, cell, body, entry = item
    spans, in1, out1, a1, b1, in2, out2, a2, b2, unsure = cell_spans(geometry, cell, ray, inverse)
    if spans == 0:
        return certain(best, best[6], best[7] | unsure)
    nearness = nearness_of(geometry, table.CELL_LIMITS, cell, ray, inverse)
    for end in range(2 * spans):
        t, place = (in1, a1) if end == 0 else ((out1, b1) if end == 1 else ((in2, a2) if end == 2 else (out2, b2)))
        surface = surface_of(geometry, place, t)
        unsure |= at_start(t, surface, ray, nearness)
        if counts_in(t, surface, ray):
            unsure |= beyond(t, nearness)
            hit = (t, body, entry, place, whole(1), end == 0 or end == 2, nearness[0], unsure)
            return nearer(geometry, best, hit)
    return certain(best, best[6], best[7] | unsure)


@helper
def try_entry(geometry: Geometry, scratch: Scratch, entry: int, ray: Ray, best: Hit) -> Hit:
    """The better of `best` and the first crossing of an entry; equal t goes to the body listed first."""
    ox, oy, oz, dx, dy, dz, t_min, t_max, start = ray
    limit = min(t_max, within(best) + abs(best[0]) * 1e-15 + 1e-300)
    ray = (ox, oy, oz, dx, dy, dz, t_min, limit, start)
    nearness = entry_nearness(geometry, entry, ray)
    count, _, unsure = entry_crossings(geometry, scratch, entry, ray, 1)
    if count == 0:
        return certain(best, best[6], best[7] | unsure)
    t, place, sense, enters = crossing(scratch, 0)
    body = integer(geometry, table.ENTRY_BODY, entry)
    hit = (t, body, entry, place, sense, enters, nearness[0], unsure)
    return nearer(geometry, best, hit)


@inline
def meet(geometry: Geometry, scratch: Scratch, item: Item, sphere: Sphere, ray: Ray, inverse: float, best: Hit) -> Hit:
    """`try_entry` for an item of a leaf with a ball around it, by the shortest way for its kind."""
    if item[0] == BALL:
        return try_ball(geometry, item, sphere, ray, inverse, best)
    if item[0] == CELL:
        return try_cell(geometry, item, ray, inverse, best)
    return try_entry(geometry, scratch, item[3], ray, best)


@helper
def first_crossing(geometry: Geometry, scratch: Scratch, ray: Ray, blocks: Signs, any_hit: bool) -> Hit:
    """The nearest crossing of bodies with blocks[body] != 0 (of all, if `blocks` is empty), or any one of them."""
    best = no_hit()
    if not ray[6] < ray[7]:
        return best
    ray, scale = scaled_ray(ray)
    some = len(blocks) > 0
    way = scratch.way
    put_beam(way, OWN_BEAM, ray)
    inverse = span_inverse(ray)
    top = push_roots(geometry, way, scene_tree(geometry))
    while top > 0:
        top -= 1
        if way[on_stack(top) + ITS_T] > within(best) + abs(best[0]) * 1e-15:
            continue
        code = whole(way[on_stack(top) + ITS_CODE])
        if code >= 0:
            way[OWN_BEAM + LAST] = min(ray[7], within(best))
            top = push_node(geometry, way, code, top)
            continue
        first, last = leaf_range(code)
        at, count = leaf_at(geometry, first), last - first
        for eight in range(0, count, 8):
            end = min(ray[7], within(best))
            bits = balls_met(geometry.floats, at + eight, count, count - eight, ray, inverse, end)
            while bits != 0:
                k = eight + lowest_bit(bits)
                bits &= bits - 1
                item = leaf_item(geometry, at, count, k)
                if some and blocks[item[2]] == 0:
                    continue
                best = meet(geometry, scratch, item, leaf_ball(geometry, at, count, k), ray, inverse, best)
                if any_hit and best[1] >= 0:
                    return _unscaled(best, scale)
    return _unscaled(best, scale)


@inline
def _unscaled(best: Hit, scale: float) -> Hit:
    return best[0] * scale, best[1], best[2], best[3], best[4], best[5], best[6] * scale, best[7]


@inline
def resolved(geometry: Geometry, hit: Hit) -> tuple[float, int, int, int, int]:
    """(t, body, surface, face, side) of a hit; ids -1 for a miss."""
    t, body, entry, place, sense, _, _, _ = hit
    if entry < 0:
        return t, body, entry, entry, sense
    surface, face, side = crossed_face(geometry, entry, place, sense)
    return t, body, surface, face, side


@inline
def nearest(geometry: Geometry, scratch: Scratch, ray: Ray) -> tuple[float, int, int, int, int]:
    """(t, body, surface, face, side) of the first crossing in (t_min, t_max); t = inf and ids -1 for a miss."""
    return resolved(geometry, first_crossing(geometry, scratch, ray, scratch.nothing, False))


@inline
def blocked(geometry: Geometry, scratch: Scratch, ray: Ray, blocks: Signs) -> bool:
    """Is there any crossing in (t_min, t_max) of a body with blocks[body] != 0 (int8 over bodies)?"""
    return first_crossing(geometry, scratch, ray, blocks, True)[1] >= 0


@inline
def _sort(values: Ints, count: int) -> None:
    """Ascending, by Shell's sort."""
    gap = 1
    while gap < count // 2:
        gap = gap * 9 // 4 + 1
    while gap > 0:
        for i in range(gap, count):
            value, j = values[i], i
            while j >= gap and values[j - gap] > value:
                values[j] = values[j - gap]
                j -= gap
            values[j] = value
        gap = gap * 4 // 9


@helper
def collect(geometry: Geometry, scratch: Scratch, ray: Ray) -> int:
    """Put the entries whose boxes the ray meets within its interval into scratch, by number of body."""
    count = walk(geometry, scratch.way, scene_tree(geometry), ray, scratch.found)
    _sort(scratch.found, count)
    return count


@helper
def media(geometry: Geometry, scratch: Scratch, ray: Ray, t: float, is_medium: Signs) -> tuple[int, int]:
    """(before, after): the first body with is_medium[body] != 0 that the ray is in, just before and after t.

    -1 for none. All that crosses at the same t acts together.
    """
    ray, scale = scaled_ray(ray)
    t = t / scale
    ox, oy, oz, dx, dy, dz, _, _, start = ray
    here = (ox, oy, oz, dx, dy, dz, t, t, start)
    before, after = -1, -1
    for k in range(collect(geometry, scratch, here)):
        entry = scratch.found[k]
        body = integer(geometry, table.ENTRY_BODY, entry)
        if is_medium[body] == 0 or (before >= 0 and after >= 0):
            continue
        was_inside, is_inside = entry_sides(geometry, scratch, entry, here, t)
        before = body if was_inside and before < 0 else before
        after = body if is_inside and after < 0 else after
    return before, after


@inline
def normal_at(geometry: Geometry, surface: int, side: int, x: float, y: float, z: float) -> tuple[float, float, float]:
    """Unit normal of a surface at a point, times `side`; a cone's apex has its axis."""
    kind, row = integer(geometry, table.SURFACE_KIND, surface), integer(geometry, table.SURFACE_ROW, surface)
    if kind == PLANE:
        plane = load_plane(geometry, row)
        nx, ny, nz = plane[0], plane[1], plane[2]
    elif kind == SPHERE:
        cx, cy, cz, _ = load_sphere(geometry, row)
        nx, ny, nz = x - cx, y - cy, z - cz
    else:
        quadric = load_quadric(geometry, row)
        nx, ny, nz = quadric_gradient(quadric, x, y, z)
        if nx == 0.0 and ny == 0.0 and nz == 0.0:
            nx, ny, nz = quadric[9], quadric[10], quadric[11]
    nx, ny, nz = normalized(nx, ny, nz)
    return side * nx, side * ny, side * nz


@inline
def _uv_row(geometry: Geometry, row: int, k: int, x: float, y: float, z: float) -> float:
    at = geometry.places[table.FACE_UV] + 13 * row + k
    f = geometry.floats
    return dot(f[at], f[at + 1], f[at + 2], x, y, z) + f[at + 3]


@inline
def turns(x: float, y: float) -> float:
    """The angle of (x, y) as a fraction of a full turn, in [0, 1)."""
    angle = math.atan2(y, x) / (2.0 * math.pi)
    angle = angle + 1.0 if angle < 0.0 else angle
    return 0.0 if angle >= 1.0 else angle + 0.0


@inline
def uv_at(geometry: Geometry, body: int, face: int, surface: int, x: float, y: float, z: float) -> tuple[float, float]:
    """uv of a point of a face, by the map its shape documents."""
    first = integer(geometry, table.BODY_FACE, body)
    if first < 0:
        return ball_uv(geometry, -1 - first, surface, x, y, z)
    a = _uv_row(geometry, first + face, 1, x, y, z)
    b = _uv_row(geometry, first + face, 5, x, y, z)
    if real(geometry, table.FACE_UV, 13 * (first + face)) == 0.0:
        return a, b
    return turns(a, b), _uv_row(geometry, first + face, 9, x, y, z)


@inline
def from_center(
    geometry: Geometry, frame: int, surface: int, x: float, y: float, z: float
) -> tuple[float, float, float]:
    """A point relative to the center of one of many balls, along the ball's own axes."""
    cx, cy, cz = anchor_of(geometry, surface)
    x, y, z = x - cx, y - cy, z - cz
    at = geometry.places[table.BALL_FRAMES] + 9 * frame
    f = geometry.floats
    return (
        dot(f[at], f[at + 1], f[at + 2], x, y, z),
        dot(f[at + 3], f[at + 4], f[at + 5], x, y, z),
        dot(f[at + 6], f[at + 7], f[at + 8], x, y, z),
    )


@inline
def ball_uv(geometry: Geometry, frame: int, surface: int, x: float, y: float, z: float) -> tuple[float, float]:
    """(longitude / 360, height in [0, 1]) on one of many balls."""
    x, y, z = from_center(geometry, frame, surface, x, y, z)
    return turns(x, y), 0.5 * z / math.sqrt(dot(x, y, z, x, y, z)) + 0.5


__all__ = ["Scratch", "blocked", "collect", "media", "nearest", "new_scratch", "normal_at", "uv_at"]
