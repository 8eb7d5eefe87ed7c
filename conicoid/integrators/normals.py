"""Pictures of normals: rgb = (1 + n) / 2 for the outward unit normal; misses are black."""

from __future__ import annotations

from ..compiler.jit import helper
from ..engine.body.hit import resolved
from ..engine.body.scratch import Scratch
from ..engine.packets.first import trace_packet
from ..engine.packets.lanes import close_lanes, lane_hit, lane_ray
from ..engine.packets.packet import Packet
from ..engine.surface.normal import normal_at
from ..engine.tables import Floats, Geometry


@helper
def normals_wave(geometry: Geometry, scratch: Scratch, packet: Packet, colors: Floats, count: int) -> None:
    """Add the colours of the first surfaces' normals to those of a packet's first `count` rays."""
    lanes = packet.lanes
    close_lanes(lanes, count)
    trace_packet(geometry, scratch, packet, scratch.nothing, False)
    for i in range(count):
        t, body, surface, _, side = resolved(geometry, lane_hit(lanes, i))
        if body < 0:
            continue
        ox, oy, oz, dx, dy, dz, _, _, _ = lane_ray(lanes, i, t)
        nx, ny, nz = normal_at(geometry, surface, side, ox + t * dx, oy + t * dy, oz + t * dz)
        colors[i, 0] += 0.5 + 0.5 * nx
        colors[i, 1] += 0.5 + 0.5 * ny
        colors[i, 2] += 0.5 + 0.5 * nz
