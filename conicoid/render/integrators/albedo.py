"""Pictures of colours without light: the diffuse colour of the first surface; misses are black."""

from __future__ import annotations

from typing import Any

from ..._jit.decorators import helper
from ...kernels.body.scratch import Scratch
from ...kernels.surface.records import normal_at
from ...kernels.tables import Geometry, whole
from ..bsdf.medium import OUTSIDE
from ..interaction import SurfaceInteraction
from ..lights.direct_light import surface_color
from .samples import Samples, Settings, first_hit_of, trace_samples


@helper
def gather(geometry: Geometry, scratch: Scratch, memory: None, settings: Settings, samples: Samples) -> None:
    """Add the colours of the first surfaces."""
    trace_samples(geometry, scratch, samples)
    outside: Any = whole(OUTSIDE)
    for i in range(samples.size):
        t, body, surface, face, side, x, y, z = first_hit_of(geometry, samples, i)
        if body < 0:
            continue
        nx, ny, nz = normal_at(geometry, surface, side, x, y, z)
        sight = SurfaceInteraction(t, body, surface, face, side, outside, outside, x, y, z, nx, ny, nz)
        r, g, b = surface_color(geometry, settings.look.look.materials, sight)
        samples.colors[i, 0] += r
        samples.colors[i, 1] += g
        samples.colors[i, 2] += b
