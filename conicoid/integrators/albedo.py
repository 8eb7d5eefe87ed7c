"""Pictures of colours without light: the diffuse colour of the first surface; misses are black."""

from __future__ import annotations

from typing import Any

from ..compiler.jit import helper
from ..engine.body.scratch import Scratch
from ..engine.surface.normal import normal_at
from ..engine.tables import Geometry, whole
from ..shading.local import surface_color
from ..shading.media import OUTSIDE
from ..shading.sight import Sight
from .samples import Samples, Settings, seen, trace_samples


@helper
def gather(geometry: Geometry, scratch: Scratch, memory: None, settings: Settings, samples: Samples) -> None:
    """Add the colours of the first surfaces."""
    trace_samples(geometry, scratch, samples)
    outside: Any = whole(OUTSIDE)
    for i in range(samples.size):
        t, body, surface, face, side, x, y, z = seen(geometry, samples, i)
        if body < 0:
            continue
        nx, ny, nz = normal_at(geometry, surface, side, x, y, z)
        sight = Sight(t, body, surface, face, side, outside, outside, x, y, z, nx, ny, nz)
        r, g, b = surface_color(geometry, settings.look.look.materials, sight)
        samples.colors[i, 0] += r
        samples.colors[i, 1] += g
        samples.colors[i, 2] += b
