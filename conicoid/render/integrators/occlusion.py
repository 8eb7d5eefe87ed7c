"""Ambient occlusion: the share of the light of an even white sky that reaches each point of a surface.

One direction of density cos / pi for each sample; misses are white.
"""

from __future__ import annotations

import math

from ..._jit.decorators import helper, inline
from ...kernels.body.scratch import Scratch
from ...kernels.first_hits import is_blocked
from ...kernels.numbers.vectors import dot
from ...kernels.packet.lanes import lane_ray
from ...kernels.ray import Ray
from ...kernels.surface.records import normal_at
from ...kernels.tables import Geometry
from ..sampling import cosine_direction, sobol_pair, to_world
from .samples import FirstHit, Samples, Settings, first_hit_along, first_hit_of, trace_samples

_PAIR = 4


@inline
def _light(
    geometry: Geometry, scratch: Scratch, settings: Settings, ray: Ray, at: FirstHit, pixel: int, sample: int
) -> float:
    """Return 1 unless a body hides the sky, along one direction from the point that a ray hits."""
    if at.body < 0:
        return 1.0
    nx, ny, nz = normal_at(geometry, at.surface, at.side, at.x, at.y, at.z)
    if dot(ray.dx, ray.dy, ray.dz, nx, ny, nz) > 0.0:
        nx, ny, nz = -nx, -ny, -nz
    u, v = sobol_pair(settings.seed, pixel, sample, _PAIR)
    x, y, z = to_world(cosine_direction(u, v), (nx, ny, nz))
    beyond = Ray(at.x, at.y, at.z, x, y, z, 0.0, math.inf, at.surface)
    return 0.0 if is_blocked(geometry, scratch, beyond, scratch.nothing) else 1.0


@helper
def gather(geometry: Geometry, scratch: Scratch, memory: None, settings: Settings, samples: Samples) -> None:
    """Add white where no body hides the sky."""
    trace_samples(geometry, scratch, samples)
    for i in range(samples.size):
        ray, at = lane_ray(samples.packet.lanes, i, math.inf), first_hit_of(geometry, samples, i)
        light = _light(geometry, scratch, settings, ray, at, samples.pixels[i], samples.sample)
        samples.colors[i, 0] += light
        samples.colors[i, 1] += light
        samples.colors[i, 2] += light


@inline
def radiance(
    geometry: Geometry, scratch: Scratch, memory: None, settings: Settings, ray: Ray, pixel: int, sample: int
) -> tuple[float, float, float]:
    """`gather` for a single ray."""
    at = first_hit_along(geometry, scratch, ray)
    light = _light(geometry, scratch, settings, ray, at, pixel, sample)
    return light, light, light
