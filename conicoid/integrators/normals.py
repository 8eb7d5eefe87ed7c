"""Pictures of normals: rgb = (1 + n) / 2 for the outward unit normal; misses are black."""

from __future__ import annotations

import math

from ..geometry.tables import Geometry
from ..jit import inline
from ..trace.kernels import nearest, normal_at
from ..trace.scratch import Scratch
from .stack import NO_SURFACE


@inline
def normals_radiance(
    geometry: Geometry, scratch: Scratch, ox: float, oy: float, oz: float, dx: float, dy: float, dz: float
) -> tuple[float, float, float]:
    """The colour of the first surface's normal."""
    t, body, surface, _, side = nearest(geometry, scratch, (ox, oy, oz, dx, dy, dz, 0.0, math.inf, NO_SURFACE))
    if body < 0:
        return 0.0, 0.0, 0.0
    nx, ny, nz = normal_at(geometry, surface, side, ox + t * dx, oy + t * dy, oz + t * dz)
    return 0.5 + 0.5 * nx, 0.5 + 0.5 * ny, 0.5 + 0.5 * nz
