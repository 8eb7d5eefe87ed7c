"""Pictures of normals: rgb = (1 + n) / 2 for the outward unit normal; misses are black."""

from __future__ import annotations

from ..._jit.decorators import helper, inline
from ...kernels.body.scratch import Scratch
from ...kernels.ray import Ray
from ...kernels.surface.records import normal_at
from ...kernels.tables import Geometry
from .samples import FirstHit, Samples, Settings, first_hit_along, first_hit_of, trace_samples


@inline
def _color(geometry: Geometry, at: FirstHit) -> tuple[float, float, float]:
    """Return the colour of a surface's normal."""
    if at.body < 0:
        return 0.0, 0.0, 0.0
    nx, ny, nz = normal_at(geometry, at.surface, at.side, at.x, at.y, at.z)
    return 0.5 + 0.5 * nx, 0.5 + 0.5 * ny, 0.5 + 0.5 * nz


@helper
def gather(geometry: Geometry, scratch: Scratch, memory: None, settings: Settings, samples: Samples) -> None:
    """Add the colours of the first surfaces' normals."""
    trace_samples(geometry, scratch, samples)
    for i in range(samples.size):
        r, g, b = _color(geometry, first_hit_of(geometry, samples, i))
        samples.colors[i, 0] += r
        samples.colors[i, 1] += g
        samples.colors[i, 2] += b


@inline
def radiance(
    geometry: Geometry, scratch: Scratch, memory: None, settings: Settings, ray: Ray, pixel: int, sample: int
) -> tuple[float, float, float]:
    """`gather` for a single ray."""
    return _color(geometry, first_hit_along(geometry, scratch, ray))
