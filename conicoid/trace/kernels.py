"""What other kernels ask of a scene: the nearest crossing, occlusion, the media on both sides, normals, uv."""

from __future__ import annotations

import math
from typing import TypeAlias

from ..geometry.cell import load_plane, load_quadric, load_sphere
from ..geometry.quadric import quadric_gradient
from ..geometry.tables import BALL, PLANE, SPHERE, Floats, Geometry, Ray, Signs
from ..geometry.vectors import normalized
from ..jit import helper, inline
from .events import Scratch, entry_crossings, entry_sides, new_scratch

Hit: TypeAlias = tuple[float, int, int, int, int, bool]

_FAR = 2.0**100


@inline
def _boxes_met(geometry: Geometry, scratch: Scratch, node: int, ray: Ray, ix: float, iy: float, iz: float, t_max: float) -> None:
    """Where the ray enters each child's box, into scratch.near; inf where it passes by."""
    boxes = geometry.node_boxes
    ox, oy, oz, t_min = ray[0], ray[1], ray[2], ray[6]
    for i in range(8):
        a, b = (boxes[node, 0, i] - ox) * ix, (boxes[node, 3, i] - ox) * ix
        near, far = max(min(a, b), t_min), min(max(a, b), t_max)
        a, b = (boxes[node, 1, i] - oy) * iy, (boxes[node, 4, i] - oy) * iy
        near, far = max(min(a, b), near), min(max(a, b), far)
        a, b = (boxes[node, 2, i] - oz) * iz, (boxes[node, 5, i] - oz) * iz
        near, far = max(min(a, b), near), min(max(a, b), far)
        slack = (abs(near) + abs(far)) * 4e-16
        scratch.near[i] = near if near <= far + slack else math.inf


@inline
def _reciprocal(d: float) -> float:
    """1 / d, finite: a direction along a wall of a box lies on one side of it."""
    return 1.0 / d if abs(d) > 1e-290 else math.copysign(1e290, d)


@inline
def _push_children(geometry: Geometry, scratch: Scratch, node: int, top: int) -> int:
    """Put the children that the ray meets on the stack, the nearest on top."""
    base = top
    for i in range(8):
        near = scratch.near[i]
        child = geometry.node_children[node, i]
        if child == 0 or not near < math.inf:
            continue
        slot = top
        while slot > base and scratch.stack_t[slot - 1] < near:
            scratch.stack_t[slot] = scratch.stack_t[slot - 1]
            scratch.stack[slot] = scratch.stack[slot - 1]
            slot -= 1
        scratch.stack_t[slot] = near
        scratch.stack[slot] = child
        top += 1
    return top


@inline
def scaled_ray(ray: Ray) -> tuple[Ray, float]:
    """The ray with a direction whose squares neither overflow nor underflow, by a power of two; and that power."""
    ox, oy, oz, dx, dy, dz, t_min, t_max, start = ray
    largest = max(abs(dx), max(abs(dy), abs(dz)))
    if 1.0 / _FAR < largest < _FAR:
        return ray, 1.0
    scale = math.ldexp(1.0, -math.frexp(largest)[1]) if largest > 1e-300 else math.ldexp(1.0, 1000)
    return (ox, oy, oz, dx * scale, dy * scale, dz * scale, t_min / scale, t_max / scale, start), scale


@inline
def _closer(t: float, body: int, best: Hit) -> bool:
    return t < best[0] or (t == best[0] and body < best[1])


@helper
def _try_entry(geometry: Geometry, scratch: Scratch, entry: int, ray: Ray, best: Hit) -> Hit:
    """The better of `best` and the first crossing of an entry; equal t goes to the body listed first."""
    ox, oy, oz, dx, dy, dz, t_min, t_max, start = ray
    limit = min(t_max, best[0] + abs(best[0]) * 1e-15 + 1e-300)
    count, _ = entry_crossings(geometry, scratch, entry, (ox, oy, oz, dx, dy, dz, t_min, limit, start), 1)
    body = geometry.entry_body[entry]
    if count == 0 or not _closer(scratch.cross_t[0], body, best):
        return best
    face = scratch.cross_face
    return scratch.cross_t[0], body, face[0, 0], face[0, 1], face[0, 2], face[0, 3] == 1


@helper
def first_crossing(geometry: Geometry, scratch: Scratch, ray: Ray, blocks: Signs, any_hit: bool) -> Hit:
    """The nearest crossing of bodies with blocks[body] != 0 (of all, if `blocks` is empty), or any one of them.

    (t, body, surface, face, side, entered); t = inf and ids -1 for a miss.
    """
    ray, scale = scaled_ray(ray)
    best = (math.inf, -1, -1, -1, 0, False)
    some = len(blocks) > 0
    for k in range(len(geometry.unbounded)):
        entry = geometry.unbounded[k]
        if some and blocks[geometry.entry_body[entry]] == 0:
            continue
        best = _try_entry(geometry, scratch, entry, ray, best)
        if any_hit and best[1] >= 0:
            return best
    if len(geometry.node_children) == 0:
        return _unscaled(best, scale)
    ix, iy, iz = _reciprocal(ray[3]), _reciprocal(ray[4]), _reciprocal(ray[5])
    scratch.stack[0], scratch.stack_t[0] = 0, ray[6]
    top = 1
    while top > 0:
        top -= 1
        if scratch.stack_t[top] > best[0] + abs(best[0]) * 1e-15:
            continue
        code = scratch.stack[top]
        if code >= 0:
            _boxes_met(geometry, scratch, code, ray, ix, iy, iz, min(ray[7], best[0]))
            top = _push_children(geometry, scratch, code, top)
            continue
        first, count = (-code - 1) >> 4, (-code - 1) & 15
        for k in range(first, first + count):
            entry = geometry.tree_order[k]
            if some and blocks[geometry.entry_body[entry]] == 0:
                continue
            best = _try_entry(geometry, scratch, entry, ray, best)
            if any_hit and best[1] >= 0:
                return best
    return _unscaled(best, scale)


@inline
def _unscaled(best: Hit, scale: float) -> Hit:
    return best[0] * scale, best[1], best[2], best[3], best[4], best[5]


@inline
def nearest(geometry: Geometry, scratch: Scratch, ray: Ray) -> tuple[float, int, int, int, int]:
    """(t, body, surface, face, side) of the first crossing in ]t_min, t_max[; t = inf and ids -1 for a miss."""
    t, body, surface, face, side, _ = first_crossing(geometry, scratch, ray, geometry.surface_kind[:0], False)
    return t, body, surface, face, side


@inline
def blocked(geometry: Geometry, scratch: Scratch, ray: Ray, blocks: Signs) -> bool:
    """Is there any crossing in ]t_min, t_max[ of a body with blocks[body] != 0 (int8 over bodies)?"""
    return first_crossing(geometry, scratch, ray, blocks, True)[1] >= 0


@helper
def collect(geometry: Geometry, scratch: Scratch, ray: Ray) -> int:
    """Put the entries whose boxes the ray meets within its interval into scratch.found, by number of body."""
    count = 0
    for k in range(len(geometry.unbounded)):
        scratch.found[count] = geometry.unbounded[k]
        count += 1
    top = 0
    if len(geometry.node_children) > 0:
        scratch.stack[0], top = 0, 1
    ix, iy, iz = _reciprocal(ray[3]), _reciprocal(ray[4]), _reciprocal(ray[5])
    while top > 0:
        top -= 1
        code = scratch.stack[top]
        if code >= 0:
            _boxes_met(geometry, scratch, code, ray, ix, iy, iz, ray[7])
            top = _push_children(geometry, scratch, code, top)
            continue
        first, size = (-code - 1) >> 4, (-code - 1) & 15
        for k in range(first, first + size):
            scratch.found[count] = geometry.tree_order[k]
            count += 1
    scratch.found[:count].sort()
    return count


@helper
def media(geometry: Geometry, scratch: Scratch, ray: Ray, t: float, is_medium: Signs) -> tuple[int, int]:
    """(before, after): the lowest-numbered body with is_medium[body] != 0 that the ray is inside of, just
    before and just after t; -1 for none. All that crosses at the same t acts together."""
    ray, scale = scaled_ray(ray)
    t = t / scale
    ox, oy, oz, dx, dy, dz, _, _, start = ray
    here = (ox, oy, oz, dx, dy, dz, t, t, start)
    before, after = -1, -1
    for k in range(collect(geometry, scratch, here)):
        entry = scratch.found[k]
        body = geometry.entry_body[entry]
        if is_medium[body] == 0 or (before >= 0 and after >= 0):
            continue
        was_inside, is_inside = entry_sides(geometry, scratch, entry, here, t)
        before = body if was_inside and before < 0 else before
        after = body if is_inside and after < 0 else after
    return before, after


@inline
def normal_at(geometry: Geometry, surface: int, side: int, x: float, y: float, z: float) -> tuple[float, float, float]:
    """Unit normal of a surface at a point, times `side`; a cone's apex has its axis."""
    kind, row = geometry.surface_kind[surface], geometry.surface_row[surface]
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
def _uv_row(face_uv: Floats, row: int, k: int, x: float, y: float, z: float) -> float:
    return face_uv[row, k] * x + face_uv[row, k + 1] * y + face_uv[row, k + 2] * z + face_uv[row, k + 3]


@inline
def turns(x: float, y: float) -> float:
    """The angle of (x, y) as a fraction of a full turn, in [0, 1)."""
    angle = math.atan2(y, x) / (2.0 * math.pi)
    angle = angle + 1.0 if angle < 0.0 else angle
    return 0.0 if angle >= 1.0 else angle


@inline
def uv_at(geometry: Geometry, body: int, face: int, surface: int, x: float, y: float, z: float) -> tuple[float, float]:
    """uv of a point of a face, by the map its shape documents."""
    first = geometry.body_face[body]
    if first < 0:
        return ball_uv(geometry, surface, x, y, z)
    a = _uv_row(geometry.face_uv, first + face, 1, x, y, z)
    b = _uv_row(geometry.face_uv, first + face, 5, x, y, z)
    if geometry.face_uv[first + face, 0] == 0.0:
        return a, b
    return turns(a, b), _uv_row(geometry.face_uv, first + face, 9, x, y, z)


@inline
def ball_uv(geometry: Geometry, surface: int, x: float, y: float, z: float) -> tuple[float, float]:
    """(longitude / 360, height in [0, 1]) on one of many balls, or on the ellipsoid it was made."""
    row = geometry.surface_row[surface]
    if geometry.surface_kind[surface] == SPHERE:
        cx, cy, cz, r = load_sphere(geometry, row)
    else:
        quadric = load_quadric(geometry, row)
        cx, cy, cz, r = quadric[0], quadric[1], quadric[2], math.sqrt(quadric[18] / quadric[14]) / abs(quadric[11])
    return turns(x - cx, y - cy), 0.5 * (z - cz) / r + 0.5


__all__ = ["BALL", "Scratch", "blocked", "collect", "media", "nearest", "new_scratch", "normal_at", "uv_at"]
