"""Pictures of normals: rgb = (1 + n) / 2 for the outward unit normal; misses are black."""

from __future__ import annotations

from ..geometry.tables import Geometry
from ..jit import helper
from ..trace.kernels import normal_at, resolved
from ..trace.lanes import close_lanes, lane_hit, lane_ray
from ..trace.packet_first import trace_packet
from ..trace.scratch import Scratch
from .samples import Samples, Settings


@helper
def gather(geometry: Geometry, scratch: Scratch, memory: None, settings: Settings, samples: Samples) -> None:
    """Add the colours of the first surfaces' normals."""
    lanes, colors = samples.packet.lanes, samples.colors
    close_lanes(lanes, samples.size)
    trace_packet(geometry, scratch, samples.packet, 8, True, scratch.nothing, False)
    for i in range(samples.size):
        t, body, surface, _, side = resolved(geometry, lane_hit(lanes, i))
        if body < 0:
            continue
        ox, oy, oz, dx, dy, dz, _, _, _ = lane_ray(lanes, i, t)
        nx, ny, nz = normal_at(geometry, surface, side, ox + t * dx, oy + t * dy, oz + t * dz)
        colors[i, 0] += 0.5 + 0.5 * nx
        colors[i, 1] += 0.5 + 0.5 * ny
        colors[i, 2] += 0.5 + 0.5 * nz
