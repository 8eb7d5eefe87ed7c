"""Sampling of light sources: the choice of a source, directions to it, and their densities per solid angle.

Lamps are bodies that glow; lights are points or parallel; surroundings are an image of all directions.
"""

from __future__ import annotations

import math
from typing import Any, NamedTuple

from ..._jit.decorators import helper, inline
from ...kernels.body.uv import turns
from ...kernels.numbers.elementary import cos_sin_turns
from ...kernels.numbers.vectors import dot, normalize
from ...kernels.tables import Floats
from ..sampling import Direction, sphere_direction, to_world, unit_direction
from .environment import EnvironmentTable, environment_density, environment_direction, environment_radiance
from .light_tables import (
    BALL,
    CYLINDER,
    DELTA_LIGHT,
    DISC,
    POLYGON,
    SURROUNDINGS,
    TRIANGLE_STRIDE,
    LightSources,
    ShadingTables,
    light_direction,
    light_share,
)

MOST_TRIANGLES = 6
"""Polygons of more triangles are sampled by area."""
LEAST_ANGLE = 1.0 / 64.0
"""Polygons of a smaller solid angle are sampled by area: from far away the two are the same."""
_STRIDE = 10  # as TRIANGLE_STRIDE

# Triangles and polygons by their solid angle, for lamps that are near
#
# Arvo, Stratified sampling of spherical triangles, SIGGRAPH 1995. The angle of a triangle is that of Van Oosterom and
# Strackee, The solid angle of a plane triangle, 1983: tan(Ω / 2) = |a·(b×c)| / (1 + a·b + b·c + c·a) for unit vectors
# to its corners. The triangles of a polygon do not overlap, so their angles add up, and each is chosen by its own.


@inline
def _cross(a: Direction, b: Direction) -> Direction:
    """Return the unit vector along a × b."""
    return normalize(a[1] * b[2] - a[2] * b[1], a[2] * b[0] - a[0] * b[2], a[0] * b[1] - a[1] * b[0])


@inline
def _dot(a: Direction, b: Direction) -> float:
    return dot(a[0], a[1], a[2], b[0], b[1], b[2])


@inline
def _corners(f: Floats, k: int, x: float, y: float, z: float) -> tuple[Direction, Direction, Direction]:
    """Return unit vectors from a point to the corners of triangle k."""
    at = _STRIDE * k
    px, py, pz = f[at] - x, f[at + 1] - y, f[at + 2] - z
    return (
        normalize(px, py, pz), normalize(px + f[at + 3], py + f[at + 4], pz + f[at + 5]),
        normalize(px + f[at + 6], py + f[at + 7], pz + f[at + 8]),
    )  # fmt: skip


@helper
def triangle_angle(f: Floats, k: int, x: float, y: float, z: float) -> float:
    """Return the solid angle of triangle k from a point, in steradians."""
    a, b, c = _corners(f, k, x, y, z)
    volume = (
        a[0] * (b[1] * c[2] - b[2] * c[1]) + a[1] * (b[2] * c[0] - b[0] * c[2]) + a[2] * (b[0] * c[1] - b[1] * c[0])
    )  # fmt: skip
    return 4.0 * math.pi * turns(1.0 + _dot(a, b) + _dot(b, c) + _dot(c, a), abs(volume))


@helper
def polygon_angle(f: Floats, source: Any, x: float, y: float, z: float) -> float:
    """Return the solid angle of a polygon lamp, in steradians; 0 if it is to be sampled by area."""
    if source.count > MOST_TRIANGLES:
        return 0.0
    total = 0.0
    for k in range(source.index, source.index + source.count):
        total += triangle_angle(f, k, x, y, z)
    return total if total >= LEAST_ANGLE else 0.0


@inline
def _slerp(a: Direction, b: Direction, cosine: float) -> Direction:
    """Return the unit vector in the plane of a and b at an angle of that cosine to a, on the side of b."""
    along = _dot(a, b)
    x, y, z = normalize(b[0] - along * a[0], b[1] - along * a[1], b[2] - along * a[2])
    s = math.sqrt(max(0.0, (1.0 - cosine) * (1.0 + cosine)))
    return cosine * a[0] + s * x, cosine * a[1] + s * y, cosine * a[2] + s * z


@helper
def sample_triangle(f: Floats, k: int, x: float, y: float, z: float, u: float, v: float) -> Direction:
    """Return a unit direction from a point into triangle k, of even density."""
    a, b, c = _corners(f, k, x, y, z)
    ab, ac = _cross(a, b), _cross(a, c)
    cos_a = min(1.0, max(-1.0, _dot(ab, ac)))
    sin_a = math.sqrt((1.0 - cos_a) * (1.0 + cos_a))
    share = u * triangle_angle(f, k, x, y, z) / (2.0 * math.pi) - turns(cos_a, sin_a)
    t, s = cos_sin_turns(share)
    p, q = t - cos_a, s + sin_a * _dot(a, b)
    below = (q * s + p * t) * sin_a
    cosine = ((q * t - p * s) * cos_a - q) / below if below != 0.0 else 1.0
    far = _slerp(a, c, min(1.0, max(-1.0, cosine)))
    return normalized3(_slerp(b, far, 1.0 - v * (1.0 - _dot(far, b))))


@inline
def normalized3(d: Direction) -> Direction:
    """Return a vector at unit length."""
    return normalize(d[0], d[1], d[2])


@helper
def sample_polygon(f: Floats, source: Any, total: float, x: float, y: float, z: float, u: float, v: float) -> Direction:
    """Return `sample_triangle` of a polygon whose solid angle is `total`; u chooses it and is reused in it."""
    left = u * total
    for k in range(source.index, source.index + source.count):
        angle = triangle_angle(f, k, x, y, z)
        if left < angle or k == source.index + source.count - 1:
            return sample_triangle(f, k, x, y, z, min(1.0 - 2.0**-53, left / angle) if angle > 0.0 else 0.5, v)
        left -= angle
    return 0.0, 0.0, 1.0


# Sampling of any source

_MOST_WEIGHTED = 16
"""Up to this many sources are weighed at each point; among more the power alone chooses."""
_OVERSHOOT = 1.0 + 2.0**-10
"""A ray to a lamp ends a little behind the lamp's surface, which it has to hit."""


class LightSample(NamedTuple):
    """A ray to a source, and its light over the density of the ray, if nothing is in between."""

    d: Direction  # not of unit length
    end: float  # of the ray
    body: Any  # int64: the body that the ray has to hit first; -1 for none
    r: float
    g: float
    b: float
    density: float  # per solid angle, the choice of the source included; 0 for points and parallel light


# Choice of a source


@inline
def _weight(look: ShadingTables, source: Any, x: float, y: float, z: float) -> float:
    """Return about the power of a source that may arrive at a point."""
    if source.kind == DELTA_LIGHT:
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
def _total_weight(look: ShadingTables, sources: LightSources, x: float, y: float, z: float) -> float:
    """Return the sum of the weights of all sources."""
    total = 0.0
    for k in range(len(sources.records)):
        total += _weight(look, sources.records[k], x, y, z)
    return total


@inline
def light_probability(look: ShadingTables, sources: LightSources, k: int, x: float, y: float, z: float) -> float:
    """Return the probability by which `choose_light` takes source k at a point."""
    count = len(sources.records)
    if count == 1:
        return 1.0
    if count > _MOST_WEIGHTED:
        return float(sources.records[k].until - (sources.records[k - 1].until if k > 0 else 0.0))
    total = _total_weight(look, sources, x, y, z)
    return _weight(look, sources.records[k], x, y, z) / total if total > 0.0 else 0.0


@inline
def choose_light(
    look: ShadingTables, sources: LightSources, x: float, y: float, z: float, u: float
) -> tuple[int, float]:
    """Return (a source drawn for a point, its probability); u in [0, 1)."""
    if len(sources.records) == 1:
        return 0, 1.0
    return _choose_of_several(look, sources, x, y, z, u)


@helper
def _choose_of_several(
    look: ShadingTables, sources: LightSources, x: float, y: float, z: float, u: float
) -> tuple[int, float]:
    """Return `choose_light` of several sources: by bisection of their power, or by their weights at the point."""
    count = len(sources.records)
    if count > _MOST_WEIGHTED:
        low, high = 0, count - 1
        while low < high:
            middle = (low + high) >> 1
            if sources.records[middle].until > u:
                high = middle
            else:
                low = middle + 1
        return low, light_probability(look, sources, low, x, y, z)
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
def has_area(sources: LightSources) -> bool:
    """Return whether any source has an extent, so that places on it are drawn. Lamps come first, surroundings last."""
    last = len(sources.records) - 1
    return bool(sources.records[0].kind != DELTA_LIGHT or sources.records[last].kind == SURROUNDINGS)


# Lamps


@inline
def _opposite(source: Any, x: float, y: float, z: float) -> tuple[float, float, float, float]:
    """Return (the vector from a point to the middle of a source, the square of its length)."""
    px, py, pz = source.center[0] - x, source.center[1] - y, source.center[2] - z
    return px, py, pz, dot(px, py, pz, px, py, pz)


@inline
def _cap(square: float) -> float:
    """Return 1 - sqrt(1 - square), without cancellation."""
    return square / (1.0 + math.sqrt(max(0.0, 1.0 - square)))


@inline
def _ball_density(source: Any, x: float, y: float, z: float) -> float:
    """Return the density of directions to a ball: uniform in its cone; from inside of it, to all sides."""
    _, _, _, square = _opposite(source, x, y, z)
    own = source.radius * source.radius
    if square <= own:
        return 0.25 / math.pi
    return 1.0 / (2.0 * math.pi * _cap(own / square))


@inline
def _to_ball(source: Any, x: float, y: float, z: float, u: float, v: float) -> tuple[Direction, float, float]:
    """Return (unit direction, end, density) of a ray to a ball."""
    px, py, pz, square = _opposite(source, x, y, z)
    own = source.radius * source.radius
    if square <= own:
        return sphere_direction(u, v), 2.0 * source.radius * _OVERSHOOT, 0.25 / math.pi
    part = _cap(own / square)
    d = to_world(unit_direction(v, 1.0 - u * part), normalize(px, py, pz))
    return d, (math.sqrt(square) + source.radius) * _OVERSHOOT, 1.0 / (2.0 * math.pi * part)


@inline
def _on_disc(source: Any, u: float, v: float) -> Direction:
    """Return a point of a disc, uniform by area."""
    c, s = cos_sin_turns(v)
    r = source.radius * math.sqrt(u)
    a, b, m = source.across, source.beside, source.center
    return m[0] + r * (c * a[0] + s * b[0]), m[1] + r * (c * a[1] + s * b[1]), m[2] + r * (c * a[2] + s * b[2])


@inline
def _on_polygon(sources: LightSources, source: Any, u: float, v: float) -> Direction:
    """Return a point of one of the triangles, uniform by area; u chooses it and is reused in it (Turk 1990)."""
    f, low, high = sources.triangles, source.index, source.index + source.count - 1
    while low < high:
        middle = (low + high) >> 1
        if f[TRIANGLE_STRIDE * middle + 9] > u:
            high = middle
        else:
            low = middle + 1
    before = f[TRIANGLE_STRIDE * (low - 1) + 9] if low > source.index else 0.0
    at = TRIANGLE_STRIDE * low
    root = math.sqrt(min(1.0, max(0.0, (u - before) / (f[at + 9] - before))))
    p, q = root * (1.0 - v), root * v
    return (
        f[at] + p * f[at + 3] + q * f[at + 6],
        f[at + 1] + p * f[at + 4] + q * f[at + 7],
        f[at + 2] + p * f[at + 5] + q * f[at + 8],
    )


@inline
def _on_cylinder(source: Any, u: float, v: float) -> tuple[Direction, Direction]:
    """Return (a point of a closed cylinder, uniform by area, its outward normal)."""
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
    """Return whether a point is in a cylinder."""
    px, py, pz, square = _opposite(source, x, y, z)
    h = -dot(px, py, pz, source.along[0], source.along[1], source.along[2])
    return bool(0.0 <= h <= source.length and square - h * h <= source.radius * source.radius)


@inline
def _seen_area(px: float, py: float, pz: float, n: Direction) -> float:
    """Return the solid angle for each unit of area at the end of p: the cosine over the square of the distance."""
    square = dot(px, py, pz, px, py, pz)
    if square == 0.0:
        return 0.0
    return abs(dot(px, py, pz, n[0], n[1], n[2])) / (square * math.sqrt(square))


@helper
def lamp_density(sources: LightSources, source: Any, x: float, y: float, z: float, p: Direction, n: Direction) -> float:
    """Return the density by which `sample_lamp` takes the direction from a point to p on a lamp with unit normal n.

    Per solid angle; inf where the lamp is seen edge on.
    """
    if source.kind == BALL:
        return _ball_density(source, x, y, z)
    if source.kind == POLYGON:
        angle = polygon_angle(sources.triangles, source, x, y, z)
        if angle > 0.0:
            return 1.0 / angle
    area = _seen_area(p[0] - x, p[1] - y, p[2] - z, n)
    return 1.0 / (area * source.area) if area > 0.0 else math.inf


@inline
def sample_light(
    look: ShadingTables,
    sources: LightSources,
    around_all: EnvironmentTable,
    x: float,
    y: float,
    z: float,
    choice: float,
    u: float,
    v: float,
) -> LightSample:
    """Return light from one of the sources, which `choice` draws; all three numbers are in [0, 1)."""
    k, likely = choose_light(look, sources, x, y, z, choice)
    source = sources.records[k]
    if likely == 0.0:
        return LightSample((0.0, 0.0, 1.0), 0.0, -1, 0.0, 0.0, 0.0, 0.0)
    if source.kind == DELTA_LIGHT:
        light = look.lights[source.index]
        lx, ly, lz, end = light_direction(light, x, y, z)
        distance = math.sqrt(dot(lx, ly, lz, lx, ly, lz))
        if distance == 0.0:
            return LightSample((0.0, 0.0, 1.0), 0.0, -1, 0.0, 0.0, 0.0, 0.0)
        part = math.pi * light_share(light, lx / distance, ly / distance, lz / distance, distance) / likely
        return LightSample(
            (lx, ly, lz), end, -1, part * light.intensity[0], part * light.intensity[1], part * light.intensity[2], 0.0
        )
    if source.kind == SURROUNDINGS:
        return _sample_surroundings(around_all, likely, u, v)
    return sample_lamp(sources, k, likely, x, y, z, u, v)


@helper
def _sample_surroundings(around_all: EnvironmentTable, likely: float, u: float, v: float) -> LightSample:
    """Return light of an image of the surroundings, chosen with the probability `likely`."""
    d, density = environment_direction(around_all, u, v)
    density *= likely
    if not density > 0.0:
        return LightSample(d, 0.0, -1, 0.0, 0.0, 0.0, 0.0)
    r, g, b = environment_radiance(around_all, d[0], d[1], d[2])
    return LightSample(d, math.inf, -1, r / density, g / density, b / density, density)


@helper
def sample_lamp(
    sources: LightSources, k: int, likely: float, x: float, y: float, z: float, u: float, v: float
) -> LightSample:
    """Return light from the lamp that is source k, chosen with the probability `likely`."""
    source = sources.records[k]
    d, end, density = (0.0, 0.0, 1.0), 0.0, 0.0
    if source.kind == BALL:
        d, end, density = _to_ball(source, x, y, z, u, v)
    else:
        d, end, density = _to_area(sources, source, x, y, z, u, v)
    density *= likely
    if not density > 0.0:
        return LightSample(d, 0.0, -1, 0.0, 0.0, 0.0, 0.0)
    r, g, b = source.radiance[0] / density, source.radiance[1] / density, source.radiance[2] / density
    return LightSample(d, end, source.body, r, g, b, density)


@inline
def _to_area(
    sources: LightSources, source: Any, x: float, y: float, z: float, u: float, v: float
) -> tuple[Direction, float, float]:
    """Return (direction, end, density) to a point of a lamp by its area; density 0 where the point faces away."""
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
    area = _seen_area(dx, dy, dz, n)
    return (dx, dy, dz), _OVERSHOOT, 1.0 / (area * source.area) if area > 0.0 else 0.0


@inline
def _to_angle(
    sources: LightSources, source: Any, angle: float, x: float, y: float, z: float, u: float, v: float
) -> tuple[Direction, float, float]:
    """Return (direction, end, density) to a point of a polygon by its solid angle."""
    d = sample_polygon(sources.triangles, source, angle, x, y, z, u, v)
    n, at = source.along, TRIANGLE_STRIDE * source.index
    px, py, pz = sources.triangles[at] - x, sources.triangles[at + 1] - y, sources.triangles[at + 2] - z
    along = dot(d[0], d[1], d[2], n[0], n[1], n[2])
    end = dot(px, py, pz, n[0], n[1], n[2]) / along if along != 0.0 else 0.0
    return d, end * _OVERSHOOT, 1.0 / angle if end > 0.0 else 0.0


# Densities of light that paths find by themselves


@inline
def hit_density(
    look: ShadingTables, sources: LightSources, k: int, x: float, y: float, z: float, p: Direction, n: Direction
) -> float:
    """Return the density by which `sample_light` takes the direction from a point to p, on lamp k."""
    return light_probability(look, sources, k, x, y, z) * lamp_density(sources, sources.records[k], x, y, z, p, n)


@inline
def escape_density(
    look: ShadingTables, sources: LightSources, around_all: EnvironmentTable, x: float, y: float, z: float, d: Direction
) -> float:
    """Return the density by which `sample_light` takes a unit direction into the surroundings.

    They are the last source; the density is 0 if they are none.
    """
    k = len(sources.records) - 1
    if k < 0 or sources.records[k].kind != SURROUNDINGS:
        return 0.0
    return light_probability(look, sources, k, x, y, z) * environment_density(around_all, d[0], d[1], d[2])
