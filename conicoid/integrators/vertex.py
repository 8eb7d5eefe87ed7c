"""One end of a path's ray: what is found there, what a source may add, and where the path goes on."""

from __future__ import annotations

import math
from typing import Any, NamedTuple

from ..compiler.jit import helper, inline
from ..emitters.draw import draw_lit, escaped_density, found_density, is_placed
from ..emitters.environment import environment_radiance
from ..emitters.transport import Transport
from ..engine.numbers.vectors import dot
from ..engine.ray import Ray
from ..engine.tables import Geometry, whole
from ..scattering.bent import FLAT, draw_over, evaluate_over
from ..scattering.dispersion import color_of, index_by, wavelength
from ..scattering.medium import free_way, phase, phase_direction, transmitted
from ..scattering.record import LOST, SHARP, STRAIGHT, Touched
from ..scattering.surface import has_extent
from ..scattering.warps import to_frame, to_world
from ..shading.background import background_color
from ..shading.local import surface_color
from ..shading.materials import ROUGH_STEPS, Materials, material_row
from ..shading.relief import bent_point, has_relief, place_of
from ..shading.sight import Sight, facing
from ..textures.patterns import texture_color
from .sobol import sobol_pair

NONE = -1.0
"""Density of a direction that only a path finds: of camera rays, mirrors, smooth glass."""


_ROUGH_PAIRS = 1 << 20
"""Numbers of pairs from those of a scattering to the one by which roughness is drawn between its steps."""


class Path(NamedTuple):
    """What a path carries along its ray."""

    r: float  # its weight
    g: float
    b: float
    density: float  # of the ray's direction, or NONE
    x: float  # where it was drawn
    y: float
    z: float
    scale: float  # what refraction has taken from the weight, which comes back
    medium: Any  # that the ray starts in
    turns: Any  # how often it has been scattered
    wave: float  # its wavelength in μm; 0: all
    passed: Any  # how often it has gone straight through something


class Asked(NamedTuple):
    """A ray to a source, and what it brings if nothing is in the way; end 0 where none is asked."""

    x: float
    y: float
    z: float
    d: tuple[float, float, float]
    end: float
    body: Any
    r: float
    g: float
    b: float
    medium: Any
    on_surface: bool


@inline
def _no_source() -> Asked:
    return Asked(0.0, 0.0, 0.0, (0.0, 0.0, 1.0), 0.0, whole(-1), 0.0, 0.0, 0.0, whole(-1), False)


@inline
def weighed(path: Path, r: float, g: float, b: float) -> Path:
    """The path with its weight times rgb."""
    return Path(
        path.r * r, path.g * g, path.b * b, path.density, path.x, path.y, path.z, path.scale, path.medium, path.turns,
        path.wave, path.passed,
    )  # fmt: skip


@inline
def _ended(path: Path) -> Path:
    return weighed(path, 0.0, 0.0, 0.0)


@inline
def _colored(path: Path, wave: float) -> Path:
    """The path, of one wavelength from now on."""
    r, g, b = color_of(wave)
    return Path(
        path.r * r, path.g * g, path.b * b, path.density, path.x, path.y, path.z, path.scale, path.medium, path.turns,
        wave, path.passed,
    )  # fmt: skip


@inline
def _turned(path: Path, density: float, x: float, y: float, z: float, medium: int, scale: float) -> Path:
    """The path, scattered at a point."""
    return Path(path.r, path.g, path.b, density, x, y, z, scale, medium, path.turns + 1, path.wave, path.passed)


@inline
def _passed(path: Path, medium: int) -> Path:
    """The path, straight through something."""
    return Path(
        path.r, path.g, path.b, path.density, path.x, path.y, path.z, path.scale, medium, path.turns, path.wave,
        path.passed + 1,
    )  # fmt: skip


@inline
def _share(own: float, other: float) -> float:
    """The power heuristic, of a density `own` against another."""
    if other <= 0.0:
        return 1.0
    if own == math.inf:
        return 1.0
    ratio = other / own
    return 1.0 / (1.0 + ratio * ratio)


@inline
def at_ray(
    geometry: Geometry, transport: Transport, depth: int, random: tuple[int, int, int, int], path: Path, ray: Ray,
    sight: Sight,
) -> tuple[tuple[float, float, float], Path, Ray, Asked]:  # fmt: skip
    """(light found at the end of a path's ray, the path and its ray beyond, a source that is asked).

    random: seed, pixel, sample and the first pair of dimensions.
    """
    materials = transport.look.materials
    medium = path.medium if sight.body < 0 else sight.before
    if materials.any_transparent and medium >= 0:
        length = sight.t
        if materials.rows[medium].scatters == 1:
            _, u = sobol_pair(random[0], random[1], random[2], random[3] + 3)
            length, r, g, b, turns = free_way(materials, medium, sight.t, u)
            path = weighed(path, r, g, b)
            if turns:
                return _in_medium(transport, depth, random, path, ray, medium, length)
        else:
            r, g, b = transmitted(materials, medium, length)
            path = weighed(path, r, g, b)
    if sight.body < 0:
        return _escaped(transport, path, ray), _ended(path), ray, _no_source()
    return _at_surface(geometry, transport, depth, random, path, ray, sight)


@inline
def _escaped(transport: Transport, path: Path, ray: Ray) -> tuple[float, float, float]:
    """Light of the surroundings."""
    look = transport.look
    if transport.surroundings.width > 0:
        r, g, b = environment_radiance(transport.surroundings, ray.dx, ray.dy, ray.dz)
    else:
        r, g, b = background_color(look.background, ray.dz)
    part = 1.0
    if path.density >= 0.0 and transport.surroundings.width > 0:
        d = ray.dx, ray.dy, ray.dz
        other = escaped_density(look, transport.sources, transport.surroundings, path.x, path.y, path.z, d)
        part = _share(path.density, other)
    ar, ag, ab = 0.0, 0.0, 0.0
    if path.turns > 0:
        ar, ag, ab = look.ambient
    return path.r * (part * r + ar), path.g * (part * g + ag), path.b * (part * b + ab)


@inline
def _glow(transport: Transport, path: Path, sight: Sight, row: Any) -> tuple[float, float, float]:
    """Light of a surface itself, shared with what sources were asked for where the path came from."""
    r, g, b = row.emission[0], row.emission[1], row.emission[2]
    if r + g + b == 0.0:
        return 0.0, 0.0, 0.0
    part, sources = 1.0, transport.sources
    if path.density >= 0.0 and len(sources.source_of) > 0 and sources.source_of[sight.body] >= 0:
        k = sources.source_of[sight.body]
        p, n = (sight.x, sight.y, sight.z), (sight.nx, sight.ny, sight.nz)
        part = _share(path.density, found_density(transport.look, sources, k, path.x, path.y, path.z, p, n))
    return path.r * part * r, path.g * part * g, path.b * part * b


@inline
def _index(materials: Materials, medium: int, wave: float) -> float:
    """Refractive index of a medium for a path's wavelength."""
    if medium < 0:
        return 1.0
    return index_by(materials.rows[medium].index, materials.rows[medium].dispersion, wave)


@inline
def _disperses(materials: Materials, medium: int) -> bool:
    return medium >= 0 and materials.rows[medium].dispersion > 0.0


@inline
def _touched(
    geometry: Geometry, materials: Materials, path: Path, sight: Sight, number: int, from_inside: bool
) -> Touched:
    """The surface that is met, as its lobes see it."""
    row = materials.rows[number]
    r, g, b = surface_color(geometry, materials, sight)
    refracts, eta = materials.medium[sight.body] == 1, 1.0
    if refracts:
        eta = _index(materials, sight.before, path.wave) / _index(materials, sight.after, path.wave)
    kd = row.diffuse
    return Touched(number, min(1.0, kd * r), min(1.0, kd * g), min(1.0, kd * b), refracts, not from_inside, eta)


@inline
def _lets_through(materials: Materials, at: Touched) -> bool:
    """May light go straight through the surface?"""
    row = materials.rows[at.row]
    return row.transparency[0] + row.transparency[1] + row.transparency[2] > 0.0


@helper
def _as_rough(geometry: Geometry, materials: Materials, sight: Sight, at: Touched, u: float) -> Touched:
    """The surface with the roughness that a texture has there: one of two steps, by chance u as near as it is."""
    row = materials.rows[at.row]
    r, g, b = texture_color(
        geometry, materials.textures, materials.texels, row.rough_texture, place_of(materials, sight)
    )
    rough = min(1.0, max(0.0, (r + g + b) * (1.0 / 3.0)))
    step = min(ROUGH_STEPS - 1, int(math.sqrt(rough) * ROUGH_STEPS))
    low, high = step * step, (step + 1) * (step + 1)
    share = (rough * (ROUGH_STEPS * ROUGH_STEPS) - low) / (high - low)
    number = row.first_rough + step + (1 if u < share else 0)
    return Touched(whole(number), at.r, at.g, at.b, at.refracts, at.outside, at.eta)


@inline
def _at_surface(
    geometry: Geometry, transport: Transport, depth: int, random: tuple[int, int, int, int], path: Path, ray: Ray,
    sight: Sight,
) -> tuple[tuple[float, float, float], Path, Ray, Asked]:  # fmt: skip
    """`at_ray`, where a surface is met."""
    materials, asked = transport.look.materials, _no_source()
    number = material_row(geometry, materials, sight.body, sight.face)
    found = _glow(transport, path, sight, materials.rows[number])
    if path.turns >= depth:
        return found, _ended(path), ray, asked
    seed, pixel, sample, pair = random
    if path.wave == 0.0 and (_disperses(materials, sight.before) or _disperses(materials, sight.after)):
        path = _colored(path, wavelength(sobol_pair(seed, pixel, sample, 3)[1]))
    point, _, from_inside = facing(sight, ray.dx, ray.dy, ray.dz)
    n = point.nx, point.ny, point.nz
    at, g = _touched(geometry, materials, path, sight, number, from_inside), FLAT
    if materials.rows[number].rough_texture >= 0:
        at = _as_rough(geometry, materials, sight, at, sobol_pair(seed, pixel, sample, pair + _ROUGH_PAIRS)[0])
    if has_relief(materials.rows[number]):
        point = bent_point(geometry, materials, sight, number, point, from_inside)
        g = to_frame(n, (point.nx, point.ny, point.nz))
        n = point.nx, point.ny, point.nz
    o = to_frame((point.ex, point.ey, point.ez), n)
    beyond = sight.after if at.refracts else sight.before
    goes_on = path.turns + 1 < depth or transport.shines or _lets_through(materials, at)
    light, lobe = 0.0, 0.0
    if goes_on or len(transport.sources.records) > 1:
        light, lobe = sobol_pair(seed, pixel, sample, pair)
    if len(transport.sources.records) > 0 and has_extent(materials, at):
        u, v = 0.0, 0.0
        if is_placed(transport.sources):
            u, v = sobol_pair(seed, pixel, sample, pair + 1)
        lit = draw_lit(
            transport.look, transport.sources, transport.surroundings, sight.x, sight.y, sight.z, light, u, v
        )
        if lit.end > 0.0:
            length = math.sqrt(dot(lit.d[0], lit.d[1], lit.d[2], lit.d[0], lit.d[1], lit.d[2]))
            i = to_frame((lit.d[0] / length, lit.d[1] / length, lit.d[2] / length), n)
            r, green, b, density = evaluate_over(materials, transport.albedos, at, o, i, g)
            if r + green + b > 0.0:
                part = _share(lit.density, density) if lit.density > 0.0 else 1.0
                asked = Asked(
                    sight.x, sight.y, sight.z, lit.d, lit.end, whole(lit.body), path.r * r * lit.r * part,
                    path.g * green * lit.g * part, path.b * b * lit.b * part,
                    sight.before if dot(i[0], i[1], i[2], g[0], g[1], g[2]) > 0.0 else beyond, True,
                )  # fmt: skip
    if not goes_on:
        return found, _ended(path), ray, asked
    u, v = sobol_pair(seed, pixel, sample, pair + 2)
    drawn = draw_over(materials, transport.albedos, at, o, g, lobe, u, v)
    if drawn.how == LOST or (drawn.how != STRAIGHT and path.turns + 1 >= depth and not transport.shines):
        return found, _ended(path), ray, asked
    d = ray.dx, ray.dy, ray.dz
    if drawn.how != STRAIGHT:
        d = to_world(drawn.i, n)
    behind = dot(drawn.i[0], drawn.i[1], drawn.i[2], g[0], g[1], g[2]) < 0.0
    scale = path.scale / (at.eta * at.eta) if behind and at.refracts else path.scale
    medium = whole(beyond if behind else sight.before)
    path = weighed(path, drawn.r, drawn.g, drawn.b)
    if drawn.how == STRAIGHT:
        path = _passed(path, medium)
    else:
        density = NONE if drawn.how == SHARP else drawn.density
        path = _turned(path, density, sight.x, sight.y, sight.z, medium, scale)
    return found, path, Ray(sight.x, sight.y, sight.z, d[0], d[1], d[2], 0.0, math.inf, sight.surface), asked


@helper
def _in_medium(
    transport: Transport, depth: int, random: tuple[int, int, int, int], path: Path, ray: Ray, medium: int,
    length: float,
) -> tuple[tuple[float, float, float], Path, Ray, Asked]:  # fmt: skip
    """`at_ray`, where a medium scatters the light before a wall is met."""
    asked, dark = _no_source(), (0.0, 0.0, 0.0)
    if path.turns >= depth:
        return dark, _ended(path), ray, asked
    x, y, z = ray.ox + length * ray.dx, ray.oy + length * ray.dy, ray.oz + length * ray.dz
    g, d = transport.look.materials.rows[medium].anisotropy, (ray.dx, ray.dy, ray.dz)
    seed, pixel, sample, pair = random
    if len(transport.sources.records) > 0:
        light, _ = sobol_pair(seed, pixel, sample, pair)
        u, v = sobol_pair(seed, pixel, sample, pair + 1)
        lit = draw_lit(transport.look, transport.sources, transport.surroundings, x, y, z, light, u, v)
        if lit.end > 0.0:
            size = math.sqrt(dot(lit.d[0], lit.d[1], lit.d[2], lit.d[0], lit.d[1], lit.d[2]))
            f = phase(g, dot(d[0], d[1], d[2], lit.d[0], lit.d[1], lit.d[2]) / size)
            part = f * _share(lit.density, f) if lit.density > 0.0 else f
            asked = Asked(
                x, y, z, lit.d, lit.end, whole(lit.body), path.r * lit.r * part, path.g * lit.g * part,
                path.b * lit.b * part, whole(medium), False,
            )  # fmt: skip
    u, v = sobol_pair(seed, pixel, sample, pair + 2)
    d, density = phase_direction(g, d, u, v)
    path = _turned(path, density, x, y, z, whole(medium), path.scale)
    return dark, path, Ray(x, y, z, d[0], d[1], d[2], 0.0, math.inf, whole(-1)), asked
