"""Ambient occlusion: the share of the light of an even white sky that reaches each point of a surface.

One direction of density cos / pi for each sample; misses are white.
"""

from __future__ import annotations

import math

from ..._jit.decorators import helper
from ...kernels.body.scratch import Scratch
from ...kernels.first_hits import is_blocked
from ...kernels.numbers.vectors import dot
from ...kernels.packet.lanes import lane_ray
from ...kernels.ray import Ray
from ...kernels.surface.records import normal_at
from ...kernels.tables import Geometry
from ..sampling import cosine_direction, sobol_pair, to_world
from .samples import Samples, Settings, first_hit_of, trace_samples

_PAIR = 4


@helper
def gather(geometry: Geometry, scratch: Scratch, memory: None, settings: Settings, samples: Samples) -> None:
    """Add white where no body hides the sky."""
    trace_samples(geometry, scratch, samples)
    for i in range(samples.size):
        light = 1.0
        at = first_hit_of(geometry, samples, i)
        if at.body >= 0:
            nx, ny, nz = normal_at(geometry, at.surface, at.side, at.x, at.y, at.z)
            _, _, _, dx, dy, dz, _, _, _ = lane_ray(samples.packet.lanes, i, at.t)
            if dot(dx, dy, dz, nx, ny, nz) > 0.0:
                nx, ny, nz = -nx, -ny, -nz
            u, v = sobol_pair(settings.seed, samples.pixels[i], samples.sample, _PAIR)
            x, y, z = to_world(cosine_direction(u, v), (nx, ny, nz))
            ray = Ray(at.x, at.y, at.z, x, y, z, 0.0, math.inf, at.surface)
            light = 0.0 if is_blocked(geometry, scratch, ray, scratch.nothing) else 1.0
        samples.colors[i, 0] += light
        samples.colors[i, 1] += light
        samples.colors[i, 2] += light
