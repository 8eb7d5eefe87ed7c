"""One vertex of a path: the light that its ray finds, a query to a source of light, and the direction to go on."""

from __future__ import annotations

import math
from typing import Any, NamedTuple

from ..._jit.decorators import helper, inline
from ...kernels.numbers.vectors import dot
from ...kernels.ray import Ray
from ...kernels.tables import Geometry, whole
from ..bsdf.bsdf_sample import LOST, SHARP, STRAIGHT, LobeSurface
from ..bsdf.dielectric import index_at_wavelength, sample_wavelength, wavelength_color
from ..bsdf.material_table import ROUGH_STEPS, MaterialTable, material_row
from ..bsdf.medium import medium_transmittance, phase_function, sample_free_path, sample_phase_function
from ..bsdf.registry import FLAT_NORMAL, evaluate_bsdf, has_extent, sample_bsdf
from ..interaction import SurfaceInteraction, bend_normal, face_viewer, has_relief, texture_place
from ..lights.direct_light import surface_color
from ..lights.environment import background_color, environment_radiance
from ..lights.light_sampling import escape_density, has_area, hit_density, sample_light
from ..lights.light_tables import PathLight
from ..sampling import sobol_pair, to_frame, to_world
from ..textures import texture_color

NO_DENSITY = -1.0
"""Density of a direction that sources cannot sample: of camera rays, mirrors, smooth glass."""

_ROUGH_PAIRS = 1 << 20
"""Offset from a scattering's first pair of dimensions to the pair that draws roughness between its steps."""


class PathState(NamedTuple):
    """The state of a path along its ray."""

    r: float  # its weight
    g: float
    b: float
    density: float  # of the ray's direction, or NO_DENSITY
    x: float  # the point where the direction was drawn
    y: float
    z: float
    scale: float  # the factor that refraction has taken from the weight and will give back: for roulette
    medium: Any  # the medium that the ray starts in
    turns: Any  # the number of scatterings so far
    wave: float  # its wavelength in μm; 0: all
    passed: Any  # the number of surfaces passed straight through


class LightQuery(NamedTuple):
    """A ray to a source, and the light along it if nothing is in the way; end 0 if there is no ray."""

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
def _no_query() -> LightQuery:
    """Return a query without a ray."""
    return LightQuery(0.0, 0.0, 0.0, (0.0, 0.0, 1.0), 0.0, whole(-1), 0.0, 0.0, 0.0, whole(-1), False)


@inline
def scale_path(path: PathState, r: float, g: float, b: float) -> PathState:
    """Return the path with its weight times rgb."""
    return PathState(
        path.r * r, path.g * g, path.b * b, path.density, path.x, path.y, path.z, path.scale, path.medium, path.turns,
        path.wave, path.passed,
    )  # fmt: skip


@inline
def _end_path(path: PathState) -> PathState:
    """Return the path with weight 0, which ends it."""
    return scale_path(path, 0.0, 0.0, 0.0)


@inline
def _with_wavelength(path: PathState, wave: float) -> PathState:
    """Return the path, of one wavelength from now on."""
    r, g, b = wavelength_color(wave)
    return PathState(
        path.r * r, path.g * g, path.b * b, path.density, path.x, path.y, path.z, path.scale, path.medium, path.turns,
        wave, path.passed,
    )  # fmt: skip


@inline
def _scatter_path(
    path: PathState, density: float, x: float, y: float, z: float, medium: int, scale: float
) -> PathState:
    """Return the path, scattered at a point."""
    return PathState(path.r, path.g, path.b, density, x, y, z, scale, medium, path.turns + 1, path.wave, path.passed)


@inline
def _pass_straight(path: PathState, medium: int) -> PathState:
    """Return the path, straight through a surface."""
    return PathState(
        path.r, path.g, path.b, path.density, path.x, path.y, path.z, path.scale, medium, path.turns, path.wave,
        path.passed + 1,
    )  # fmt: skip


@inline
def _power_heuristic(own: float, other: float) -> float:
    """Return the share of a sample of density `own` against another strategy's density, by the power heuristic."""
    if other <= 0.0:
        return 1.0
    if own == math.inf:
        return 1.0
    ratio = other / own
    return 1.0 / (1.0 + ratio * ratio)


@inline
def extend_path(
    geometry: Geometry, transport: PathLight, depth: int, random: tuple[int, int, int, int], path: PathState, ray: Ray,
    sight: SurfaceInteraction,
) -> tuple[tuple[float, float, float], PathState, Ray, LightQuery]:  # fmt: skip
    """Return (the light found at the end of a path's ray, the path and its ray beyond, a query to a source).

    random: seed, pixel, sample and the first pair of dimensions of this scattering.
    """
    materials = transport.look.materials
    medium = path.medium if sight.body < 0 else sight.before
    if materials.any_transparent and medium >= 0:
        length = sight.t
        if materials.rows[medium].scatters == 1:
            _, u = sobol_pair(random[0], random[1], random[2], random[3] + 3)
            length, r, g, b, turns = sample_free_path(materials, medium, sight.t, u)
            path = scale_path(path, r, g, b)
            if turns:
                return _in_medium(transport, depth, random, path, ray, medium, length)
        else:
            r, g, b = medium_transmittance(materials, medium, length)
            path = scale_path(path, r, g, b)
    if sight.body < 0:
        return _escape_light(transport, path, ray), _end_path(path), ray, _no_query()
    return _at_surface(geometry, transport, depth, random, path, ray, sight)


@inline
def _escape_light(transport: PathLight, path: PathState, ray: Ray) -> tuple[float, float, float]:
    """Return the light of the surroundings, shared with the sources sampled where the path came from."""
    look = transport.look
    if transport.surroundings.width > 0:
        r, g, b = environment_radiance(transport.surroundings, ray.dx, ray.dy, ray.dz)
    else:
        r, g, b = background_color(look.background, ray.dz)
    part = 1.0
    if path.density >= 0.0 and transport.surroundings.width > 0:
        d = ray.dx, ray.dy, ray.dz
        other = escape_density(look, transport.sources, transport.surroundings, path.x, path.y, path.z, d)
        part = _power_heuristic(path.density, other)
    ar, ag, ab = 0.0, 0.0, 0.0
    if path.turns > 0:
        ar, ag, ab = look.ambient
    return path.r * (part * r + ar), path.g * (part * g + ag), path.b * (part * b + ab)


@inline
def _emitted_light(
    transport: PathLight, path: PathState, sight: SurfaceInteraction, row: Any
) -> tuple[float, float, float]:
    """Return the light that a surface emits, shared with the sources sampled where the path came from."""
    r, g, b = row.emission[0], row.emission[1], row.emission[2]
    if r + g + b == 0.0:
        return 0.0, 0.0, 0.0
    part, sources = 1.0, transport.sources
    if path.density >= 0.0 and len(sources.source_of) > 0 and sources.source_of[sight.body] >= 0:
        k = sources.source_of[sight.body]
        p, n = (sight.x, sight.y, sight.z), (sight.nx, sight.ny, sight.nz)
        part = _power_heuristic(path.density, hit_density(transport.look, sources, k, path.x, path.y, path.z, p, n))
    return path.r * part * r, path.g * part * g, path.b * part * b


@inline
def _index(materials: MaterialTable, medium: int, wave: float) -> float:
    """Return the refractive index of a medium for a path's wavelength."""
    if medium < 0:
        return 1.0
    return index_at_wavelength(materials.rows[medium].index, materials.rows[medium].dispersion, wave)


@inline
def _disperses(materials: MaterialTable, medium: int) -> bool:
    """Return whether the index of a medium depends on the wavelength."""
    return medium >= 0 and materials.rows[medium].dispersion > 0.0


@inline
def _lobe_surface(
    geometry: Geometry,
    materials: MaterialTable,
    path: PathState,
    sight: SurfaceInteraction,
    number: int,
    from_inside: bool,
) -> LobeSurface:
    """Return the properties of an interaction that lobes depend on."""
    row = materials.rows[number]
    r, g, b = surface_color(geometry, materials, sight)
    refracts, eta = materials.medium[sight.body] == 1, 1.0
    if refracts:
        eta = _index(materials, sight.before, path.wave) / _index(materials, sight.after, path.wave)
    kd = row.diffuse
    return LobeSurface(number, min(1.0, kd * r), min(1.0, kd * g), min(1.0, kd * b), refracts, not from_inside, eta)


@inline
def _lets_through(materials: MaterialTable, at: LobeSurface) -> bool:
    """Return whether light may go straight through the surface."""
    row = materials.rows[at.row]
    return row.transparency[0] + row.transparency[1] + row.transparency[2] > 0.0


@helper
def _as_rough(
    geometry: Geometry, materials: MaterialTable, sight: SurfaceInteraction, at: LobeSurface, u: float
) -> LobeSurface:
    """Return the surface with the roughness of its texture: one of the two nearest steps, chosen by u by nearness."""
    row = materials.rows[at.row]
    r, g, b = texture_color(
        geometry, materials.textures, materials.texels, row.rough_texture, texture_place(materials, sight)
    )
    rough = min(1.0, max(0.0, (r + g + b) * (1.0 / 3.0)))
    step = min(ROUGH_STEPS - 1, int(math.sqrt(rough) * ROUGH_STEPS))
    low, high = step * step, (step + 1) * (step + 1)
    share = (rough * (ROUGH_STEPS * ROUGH_STEPS) - low) / (high - low)
    number = row.first_rough + step + (1 if u < share else 0)
    return LobeSurface(whole(number), at.r, at.g, at.b, at.refracts, at.outside, at.eta)


@inline
def _at_surface(
    geometry: Geometry, transport: PathLight, depth: int, random: tuple[int, int, int, int], path: PathState, ray: Ray,
    sight: SurfaceInteraction,
) -> tuple[tuple[float, float, float], PathState, Ray, LightQuery]:  # fmt: skip
    """Return `extend_path` where the ray hits a surface."""
    materials, query = transport.look.materials, _no_query()
    number = material_row(geometry, materials, sight.body, sight.face)
    found = _emitted_light(transport, path, sight, materials.rows[number])
    if path.turns >= depth:
        return found, _end_path(path), ray, query
    seed, pixel, sample, pair = random
    if path.wave == 0.0 and (_disperses(materials, sight.before) or _disperses(materials, sight.after)):
        path = _with_wavelength(path, sample_wavelength(sobol_pair(seed, pixel, sample, 3)[1]))
    point, _, from_inside = face_viewer(sight, ray.dx, ray.dy, ray.dz)
    n = point.nx, point.ny, point.nz
    at, g = _lobe_surface(geometry, materials, path, sight, number, from_inside), FLAT_NORMAL
    if materials.rows[number].rough_texture >= 0:
        at = _as_rough(geometry, materials, sight, at, sobol_pair(seed, pixel, sample, pair + _ROUGH_PAIRS)[0])
    if has_relief(materials.rows[number]):
        point = bend_normal(geometry, materials, sight, number, point, from_inside)
        g = to_frame(n, (point.nx, point.ny, point.nz))
        n = point.nx, point.ny, point.nz
    # The frame of the lobes: o back along the path, z along the shading normal, g the true normal
    o = to_frame((point.ex, point.ey, point.ez), n)
    beyond = sight.after if at.refracts else sight.before
    # After the last scattering a path finds only light that no source ray brings: of what glows, or behind a pane
    goes_on = path.turns + 1 < depth or transport.shines or _lets_through(materials, at)
    light, lobe = 0.0, 0.0
    if goes_on or len(transport.sources.records) > 1:
        light, lobe = sobol_pair(seed, pixel, sample, pair)
    # Light of one source
    if len(transport.sources.records) > 0 and has_extent(materials, at):
        u, v = 0.0, 0.0
        if has_area(transport.sources):
            u, v = sobol_pair(seed, pixel, sample, pair + 1)
        lit = sample_light(
            transport.look, transport.sources, transport.surroundings, sight.x, sight.y, sight.z, light, u, v
        )
        if lit.end > 0.0:
            length = math.sqrt(dot(lit.d[0], lit.d[1], lit.d[2], lit.d[0], lit.d[1], lit.d[2]))
            i = to_frame((lit.d[0] / length, lit.d[1] / length, lit.d[2] / length), n)
            r, green, b, density = evaluate_bsdf(materials, transport.albedos, at, o, i, g)
            if r + green + b > 0.0:
                part = _power_heuristic(lit.density, density) if lit.density > 0.0 else 1.0
                query = LightQuery(
                    sight.x, sight.y, sight.z, lit.d, lit.end, whole(lit.body), path.r * r * lit.r * part,
                    path.g * green * lit.g * part, path.b * b * lit.b * part,
                    sight.before if dot(i[0], i[1], i[2], g[0], g[1], g[2]) > 0.0 else beyond, True,
                )  # fmt: skip

    # On along a direction of the surface
    if not goes_on:
        return found, _end_path(path), ray, query
    u, v = sobol_pair(seed, pixel, sample, pair + 2)
    drawn = sample_bsdf(materials, transport.albedos, at, o, g, lobe, u, v)
    if drawn.how == LOST or (drawn.how != STRAIGHT and path.turns + 1 >= depth and not transport.shines):
        return found, _end_path(path), ray, query
    d = ray.dx, ray.dy, ray.dz
    if drawn.how != STRAIGHT:
        d = to_world(drawn.i, n)
    is_behind = dot(drawn.i[0], drawn.i[1], drawn.i[2], g[0], g[1], g[2]) < 0.0
    scale = path.scale / (at.eta * at.eta) if is_behind and at.refracts else path.scale
    medium = whole(beyond if is_behind else sight.before)
    path = scale_path(path, drawn.r, drawn.g, drawn.b)
    if drawn.how == STRAIGHT:
        path = _pass_straight(path, medium)
    else:
        density = NO_DENSITY if drawn.how == SHARP else drawn.density
        path = _scatter_path(path, density, sight.x, sight.y, sight.z, medium, scale)
    return found, path, Ray(sight.x, sight.y, sight.z, d[0], d[1], d[2], 0.0, math.inf, sight.surface), query


@helper
def _in_medium(
    transport: PathLight, depth: int, random: tuple[int, int, int, int], path: PathState, ray: Ray, medium: int,
    length: float,
) -> tuple[tuple[float, float, float], PathState, Ray, LightQuery]:  # fmt: skip
    """Return `extend_path` where a medium scatters the light before the next wall."""
    query, dark = _no_query(), (0.0, 0.0, 0.0)
    if path.turns >= depth:
        return dark, _end_path(path), ray, query
    x, y, z = ray.ox + length * ray.dx, ray.oy + length * ray.dy, ray.oz + length * ray.dz
    g, d = transport.look.materials.rows[medium].anisotropy, (ray.dx, ray.dy, ray.dz)
    seed, pixel, sample, pair = random
    if len(transport.sources.records) > 0:
        light, _ = sobol_pair(seed, pixel, sample, pair)
        u, v = sobol_pair(seed, pixel, sample, pair + 1)
        lit = sample_light(transport.look, transport.sources, transport.surroundings, x, y, z, light, u, v)
        if lit.end > 0.0:
            size = math.sqrt(dot(lit.d[0], lit.d[1], lit.d[2], lit.d[0], lit.d[1], lit.d[2]))
            f = phase_function(g, dot(d[0], d[1], d[2], lit.d[0], lit.d[1], lit.d[2]) / size)
            part = f * _power_heuristic(lit.density, f) if lit.density > 0.0 else f
            query = LightQuery(
                x, y, z, lit.d, lit.end, whole(lit.body), path.r * lit.r * part, path.g * lit.g * part,
                path.b * lit.b * part, whole(medium), False,
            )  # fmt: skip
    u, v = sobol_pair(seed, pixel, sample, pair + 2)
    d, density = sample_phase_function(g, d, u, v)
    path = _scatter_path(path, density, x, y, z, whole(medium), path.scale)
    return dark, path, Ray(x, y, z, d[0], d[1], d[2], 0.0, math.inf, whole(-1)), query
