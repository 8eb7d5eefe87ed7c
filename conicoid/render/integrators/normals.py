"""Pictures of normals: rgb = (1 + n) / 2 for the outward unit normal; misses are black."""

from __future__ import annotations

from ..._jit.decorators import helper
from ...kernels.body.scratch import Scratch
from ...kernels.surface.records import normal_at
from ...kernels.tables import Geometry
from .samples import Samples, Settings, first_hit_of, trace_samples


@helper
def gather(geometry: Geometry, scratch: Scratch, memory: None, settings: Settings, samples: Samples) -> None:
    """Add the colours of the first surfaces' normals."""
    trace_samples(geometry, scratch, samples)
    for i in range(samples.size):
        at = first_hit_of(geometry, samples, i)
        if at.body >= 0:
            nx, ny, nz = normal_at(geometry, at.surface, at.side, at.x, at.y, at.z)
            samples.colors[i, 0] += 0.5 + 0.5 * nx
            samples.colors[i, 1] += 0.5 + 0.5 * ny
            samples.colors[i, 2] += 0.5 + 0.5 * nz
