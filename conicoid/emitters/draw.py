"""Directions to sources by chance, and how densely they lie."""

from __future__ import annotations

import math
from typing import Any, NamedTuple

from ..compiler.jit import helper, inline
from ..engine.numbers.turns import cos_sin_turns
from ..engine.numbers.vectors import dot, normalized
from ..scattering.warps import Direction, around, sphere_direction, to_world
from ..shading.lights import share, towards
from ..shading.look import Look
from .environment import Environment, environment_density, environment_direction, environment_radiance
from .sources import BALL, CYLINDER, DISC, LIGHT, POLYGON, SURROUNDINGS, TRIANGLE, Sources
from .spherical import in_polygon, polygon_angle

_WEIGHED = 16
"""So many sources are weighed for each point; more are drawn by their power alone."""
_BEYOND = 1.0 + 2.0**-10
"""A ray to a lamp ends a little behind what it is to meet first."""


class Lit(NamedTuple):
    """What comes from a source, if nothing is in between: a ray, and its light over the density of drawing it."""

    d: Direction  # not of unit length
    end: float  # of the ray
    body: Any  # int64: what the ray is to meet first; -1: nothing
    r: float
    g: float
    b: float
    density: float  # per solid angle, the choice of the source included; 0 of points and parallel light


# ---- Which source ----


@inline
def _weight(look: Look, source: Any, x: float, y: float, z: float) -> float:
    """About how much of a source may arrive at a point."""
    if source.kind == LIGHT:
        light = look.lights[source.index]
        if light.fades == 0:
            return float(source.power)
        px, py, pz = light.position[0] - x, light.position[1] - y, light.position[2] - z
        return float(source.power / (4.0 * math.pi * max(1e-300, dot(px, py, pz, px, py, pz))))
    if source.kind == SURROUNDINGS:
        return float(source.power)
    px, py, pz = source.center[0] - x, source.center[1] - y, source.center[2] - z
    near = max(dot(px, py, pz, px, py, pz), source.reach * source.reach)
    return float(source.power / near)


@helper
def _total_weight(look: Look, sources: Sources, x: float, y: float, z: float) -> float:
    total = 0.0
    for k in range(len(sources.records)):
        total += _weight(look, sources.records[k], x, y, z)
    return total


@inline
def chance(look: Look, sources: Sources, k: int, x: float, y: float, z: float) -> float:
    """How likely source k is the one that a point asks."""
    count = len(sources.records)
    if count == 1:
        return 1.0
    if count > _WEIGHED:
        return float(sources.records[k].until - (sources.records[k - 1].until if k > 0 else 0.0))
    total = _total_weight(look, sources, x, y, z)
    return _weight(look, sources.records[k], x, y, z) / total if total > 0.0 else 0.0


@inline
def chosen(look: Look, sources: Sources, x: float, y: float, z: float, u: float) -> tuple[int, float]:
    """(the source that a point asks, how likely it was); u in [0, 1)."""
    if len(sources.records) == 1:
        return 0, 1.0
    return _chosen_of_several(look, sources, x, y, z, u)


@helper
def _chosen_of_several(look: Look, sources: Sources, x: float, y: float, z: float, u: float) -> tuple[int, float]:
    """`chosen` where there is a choice."""
    count = len(sources.records)
    if count > _WEIGHED:
        low, high = 0, count - 1
        while low < high:
            middle = (low + high) >> 1
            if sources.records[middle].until > u:
                high = middle
            else:
                low = middle + 1
        return low, chance(look, sources, low, x, y, z)
    total = _total_weight(look, sources, x, y, z)
    if not total > 0.0:
        return 0, 0.0
    left = u * total
    for k in range(count - 1):
        weight = _weight(look, sources.records[k], x, y, z)
        if left < weight:
            return k, weight / total
        left -= weight
    return count - 1, _weight(look, sources.records[count - 1], x, y, z) / total


@inline
def is_placed(sources: Sources) -> bool:
    """Has any source an extent, so that places on it are drawn? Lamps come first, surroundings last."""
    last = len(sources.records) - 1
    return bool(sources.records[0].kind != LIGHT or sources.records[last].kind == SURROUNDINGS)


# ---- Lamps ----


@inline
def _away(source: Any, x: float, y: float, z: float) -> tuple[float, float, float, float]:
    """(from a point to the middle of a source, the square of the distance)."""
    px, py, pz = source.center[0] - x, source.center[1] - y, source.center[2] - z
    return px, py, pz, dot(px, py, pz, px, py, pz)


@inline
def _cap(square: float) -> float:
    """1 - sqrt(1 - square), without cancellation."""
    return square / (1.0 + math.sqrt(max(0.0, 1.0 - square)))


@inline
def _ball_density(source: Any, x: float, y: float, z: float) -> float:
    """Uniform in the cone that a ball fills; from inside of it, to all sides."""
    _, _, _, square = _away(source, x, y, z)
    own = source.radius * source.radius
    if square <= own:
        return 0.25 / math.pi
    return 1.0 / (2.0 * math.pi * _cap(own / square))


@inline
def _to_ball(source: Any, x: float, y: float, z: float, u: float, v: float) -> tuple[Direction, float, float]:
    """(unit direction, end, density)."""
    px, py, pz, square = _away(source, x, y, z)
    own = source.radius * source.radius
    if square <= own:
        return sphere_direction(u, v), 2.0 * source.radius * _BEYOND, 0.25 / math.pi
    part = _cap(own / square)
    d = to_world(around(v, 1.0 - u * part), normalized(px, py, pz))
    return d, (math.sqrt(square) + source.radius) * _BEYOND, 1.0 / (2.0 * math.pi * part)


@inline
def _on_disc(source: Any, u: float, v: float) -> Direction:
    """A point of a disc."""
    c, s = cos_sin_turns(v)
    r = source.radius * math.sqrt(u)
    a, b, m = source.across, source.beside, source.center
    return m[0] + r * (c * a[0] + s * b[0]), m[1] + r * (c * a[1] + s * b[1]), m[2] + r * (c * a[2] + s * b[2])


@inline
def _on_polygon(sources: Sources, source: Any, u: float, v: float) -> Direction:
    """A point of one of the triangles: u chooses it, and goes on in it (Turk 1990)."""
    f, low, high = sources.triangles, source.index, source.index + source.count - 1
    while low < high:
        middle = (low + high) >> 1
        if f[TRIANGLE * middle + 9] > u:
            high = middle
        else:
            low = middle + 1
    before = f[TRIANGLE * (low - 1) + 9] if low > source.index else 0.0
    at = TRIANGLE * low
    root = math.sqrt(min(1.0, max(0.0, (u - before) / (f[at + 9] - before))))
    p, q = root * (1.0 - v), root * v
    return (
        f[at] + p * f[at + 3] + q * f[at + 6],
        f[at + 1] + p * f[at + 4] + q * f[at + 7],
        f[at + 2] + p * f[at + 5] + q * f[at + 8],
    )


@inline
def _on_cylinder(source: Any, u: float, v: float) -> tuple[Direction, Direction]:
    """A point of a closed cylinder, and its outward normal."""
    r, length = source.radius, source.length
    a, b, w, m = source.across, source.beside, source.along, source.center
    side = length / (length + r)  # of the area
    c, s = cos_sin_turns(v)
    if u < side:
        h = length * u / side
        nx, ny, nz = c * a[0] + s * b[0], c * a[1] + s * b[1], c * a[2] + s * b[2]
        return (m[0] + r * nx + h * w[0], m[1] + r * ny + h * w[1], m[2] + r * nz + h * w[2]), (nx, ny, nz)
    u = 2.0 * (u - side) / (1.0 - side)
    sign = -1.0 if u < 1.0 else 1.0
    h, q = 0.0 if u < 1.0 else length, r * math.sqrt(u if u < 1.0 else u - 1.0)
    c, s = q * c, q * s
    point = (
        m[0] + c * a[0] + s * b[0] + h * w[0],
        m[1] + c * a[1] + s * b[1] + h * w[1],
        m[2] + c * a[2] + s * b[2] + h * w[2],
    )
    return point, (sign * w[0], sign * w[1], sign * w[2])


@inline
def _is_in_cylinder(source: Any, x: float, y: float, z: float) -> bool:
    px, py, pz, square = _away(source, x, y, z)
    h = -dot(px, py, pz, source.along[0], source.along[1], source.along[2])
    return bool(0.0 <= h <= source.length and square - h * h <= source.radius * source.radius)


@inline
def _seen_area(px: float, py: float, pz: float, n: Direction) -> float:
    """Cosine over the square of the distance, of a piece of area at the end of p."""
    square = dot(px, py, pz, px, py, pz)
    if square == 0.0:
        return 0.0
    return abs(dot(px, py, pz, n[0], n[1], n[2])) / (square * math.sqrt(square))


@helper
def lamp_density(sources: Sources, source: Any, x: float, y: float, z: float, p: Direction, n: Direction) -> float:
    """How densely the direction from a point to p, on a lamp with the unit normal n, is drawn; per solid angle."""
    if source.kind == BALL:
        return _ball_density(source, x, y, z)
    if source.kind == POLYGON:
        angle = polygon_angle(sources.triangles, source, x, y, z)
        if angle > 0.0:
            return 1.0 / angle
    seen = _seen_area(p[0] - x, p[1] - y, p[2] - z, n)
    return 1.0 / (seen * source.area) if seen > 0.0 else math.inf


@inline
def draw_lit(
    look: Look, sources: Sources, around_all: Environment, x: float, y: float, z: float, choice: float, u: float,
    v: float,
) -> Lit:  # fmt: skip
    """Light from one of the sources, which is drawn as well; all three numbers are in [0, 1)."""
    k, likely = chosen(look, sources, x, y, z, choice)
    source = sources.records[k]
    if likely == 0.0:
        return Lit((0.0, 0.0, 1.0), 0.0, -1, 0.0, 0.0, 0.0, 0.0)
    if source.kind == LIGHT:
        light = look.lights[source.index]
        lx, ly, lz, end = towards(light, x, y, z)
        distance = math.sqrt(dot(lx, ly, lz, lx, ly, lz))
        if distance == 0.0:
            return Lit((0.0, 0.0, 1.0), 0.0, -1, 0.0, 0.0, 0.0, 0.0)
        part = math.pi * share(light, lx / distance, ly / distance, lz / distance, distance) / likely
        return Lit(
            (lx, ly, lz), end, -1, part * light.intensity[0], part * light.intensity[1], part * light.intensity[2], 0.0
        )
    if source.kind == SURROUNDINGS:
        return _surroundings_lit(around_all, likely, u, v)
    return lamp_lit(sources, k, likely, x, y, z, u, v)


@helper
def _surroundings_lit(around_all: Environment, likely: float, u: float, v: float) -> Lit:
    """Light of an image of the surroundings, which was as likely to be asked."""
    d, density = environment_direction(around_all, u, v)
    density *= likely
    if not density > 0.0:
        return Lit(d, 0.0, -1, 0.0, 0.0, 0.0, 0.0)
    r, g, b = environment_radiance(around_all, d[0], d[1], d[2])
    return Lit(d, math.inf, -1, r / density, g / density, b / density, density)


@helper
def lamp_lit(sources: Sources, k: int, likely: float, x: float, y: float, z: float, u: float, v: float) -> Lit:
    """Light from the lamp that is source k, which was as likely to be asked."""
    source = sources.records[k]
    d, end, density = (0.0, 0.0, 1.0), 0.0, 0.0
    if source.kind == BALL:
        d, end, density = _to_ball(source, x, y, z, u, v)
    else:
        d, end, density = _to_area(sources, source, x, y, z, u, v)
    density *= likely
    if not density > 0.0:
        return Lit(d, 0.0, -1, 0.0, 0.0, 0.0, 0.0)
    r, g, b = source.radiance[0] / density, source.radiance[1] / density, source.radiance[2] / density
    return Lit(d, end, source.body, r, g, b, density)


@inline
def _to_area(
    sources: Sources, source: Any, x: float, y: float, z: float, u: float, v: float
) -> tuple[Direction, float, float]:
    """(direction, end, density) to a point of a lamp that is drawn by its area; density 0 where its back is seen."""
    p, n = (0.0, 0.0, 0.0), (source.along[0], source.along[1], source.along[2])
    if source.kind == POLYGON:
        angle = polygon_angle(sources.triangles, source, x, y, z)
        if angle > 0.0:
            return _to_angle(sources, source, angle, x, y, z, u, v)
    if source.kind == DISC:
        p = _on_disc(source, u, v)
    elif source.kind == POLYGON:
        p = _on_polygon(sources, source, u, v)
    else:
        p, n = _on_cylinder(source, u, v)
    dx, dy, dz = p[0] - x, p[1] - y, p[2] - z
    if source.kind == CYLINDER and dot(dx, dy, dz, n[0], n[1], n[2]) >= 0.0 and not _is_in_cylinder(source, x, y, z):
        return (dx, dy, dz), 0.0, 0.0
    seen = _seen_area(dx, dy, dz, n)
    return (dx, dy, dz), _BEYOND, 1.0 / (seen * source.area) if seen > 0.0 else 0.0


@inline
def _to_angle(
    sources: Sources, source: Any, angle: float, x: float, y: float, z: float, u: float, v: float
) -> tuple[Direction, float, float]:
    """The same, for a polygon that is drawn by its solid angle."""
    d = in_polygon(sources.triangles, source, angle, x, y, z, u, v)
    n, at = source.along, TRIANGLE * source.index
    px, py, pz = sources.triangles[at] - x, sources.triangles[at + 1] - y, sources.triangles[at + 2] - z
    along = dot(d[0], d[1], d[2], n[0], n[1], n[2])
    end = dot(px, py, pz, n[0], n[1], n[2]) / along if along != 0.0 else 0.0
    return d, end * _BEYOND, 1.0 / angle if end > 0.0 else 0.0


# ---- What paths find ----


@inline
def found_density(
    look: Look, sources: Sources, k: int, x: float, y: float, z: float, p: Direction, n: Direction
) -> float:
    """How densely `draw_lit` takes the direction from a point to p, on the lamp that is source k."""
    return chance(look, sources, k, x, y, z) * lamp_density(sources, sources.records[k], x, y, z, p, n)


@inline
def escaped_density(
    look: Look, sources: Sources, around_all: Environment, x: float, y: float, z: float, d: Direction
) -> float:
    """The same for a unit direction into the surroundings, which are the last source, if they are one."""
    k = len(sources.records) - 1
    if k < 0 or sources.records[k].kind != SURROUNDINGS:
        return 0.0
    return chance(look, sources, k, x, y, z) * environment_density(around_all, d[0], d[1], d[2])
