"""Pictures of colours without light: the diffuse colour of the first surface; misses are black."""

from __future__ import annotations

from typing import Any

from ..._jit.decorators import helper, inline
from ...kernels.body.scratch import Scratch
from ...kernels.ray import Ray
from ...kernels.surface.records import normal_at
from ...kernels.tables import Geometry, whole
from ..bsdf.medium import OUTSIDE
from ..interaction import SurfaceInteraction
from ..lights.direct_light import surface_color
from .samples import FirstHit, Samples, Settings, first_hit_along, first_hit_of, trace_samples


@inline
def _color(geometry: Geometry, settings: Settings, at: FirstHit) -> tuple[float, float, float]:
    """Return the colour of a surface."""
    outside: Any = whole(OUTSIDE)
    t, body, surface, face, side, x, y, z = at
    if body < 0:
        return 0.0, 0.0, 0.0
    nx, ny, nz = normal_at(geometry, surface, side, x, y, z)
    sight = SurfaceInteraction(t, body, surface, face, side, outside, outside, x, y, z, nx, ny, nz)
    return surface_color(geometry, settings.look.look.materials, sight)


@helper
def gather(geometry: Geometry, scratch: Scratch, memory: None, settings: Settings, samples: Samples) -> None:
    """Add the colours of the first surfaces."""
    trace_samples(geometry, scratch, samples)
    for i in range(samples.size):
        r, g, b = _color(geometry, settings, first_hit_of(geometry, samples, i))
        samples.colors[i, 0] += r
        samples.colors[i, 1] += g
        samples.colors[i, 2] += b


@inline
def radiance(
    geometry: Geometry, scratch: Scratch, memory: None, settings: Settings, ray: Ray, pixel: int, sample: int
) -> tuple[float, float, float]:
    """`gather` for a single ray."""
    return _color(geometry, settings, first_hit_along(geometry, scratch, ray))
