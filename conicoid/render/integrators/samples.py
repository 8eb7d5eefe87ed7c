"""The arguments of an integrator, from the tile loop: records, so that one more field changes no integrator."""

from __future__ import annotations

import math
from typing import Any, NamedTuple, cast

import numpy as np

from ..._jit.decorators import allocator, inline, record_shapes
from ...kernels.body.hit import Hit, resolve_hit
from ...kernels.body.scratch import Scratch
from ...kernels.first_hits import first_crossing
from ...kernels.packet.lanes import close_lanes, lane_hit, lane_ray
from ...kernels.packet.packet import Packet
from ...kernels.packet.traversal import PixelSquare, trace_square
from ...kernels.ray import Ray
from ...kernels.tables import Floats, Geometry, Longs

NO_SURFACE = cast(int, np.int64(-1))  # a Python int would be a type of its own to the compiler
"""The start surface of a ray that begins on none."""


@record_shapes(samples="1..1048576", depth="0..10000", sobol="0..1")
class Settings(NamedTuple):
    """The same for all of a picture. Each integrator has a kernel of its own, compiled for the type of `look`."""

    samples: int  # rays per pixel
    seed: int
    depth: int  # reflections and refractions of a ray, at most
    look: Any  # Lamplight or Transport; None for integrators that are not `lit`
    sobol: int = 0  # 1: places in pixels are Sobol's also for integrators that are not progressive


class Samples(NamedTuple):
    """One camera ray through each of up to 64 pixels, in the first lanes of a packet."""

    packet: Packet
    colors: Floats  # (64, channels of the film) sums, to which the integrator adds; of `finish` 64 for each sample
    size: int  # how many rays there are
    pixels: Longs  # (64,) the number of each one's pixel
    sample: int  # which of the samples of their pixels they are; of `finish` the first
    square: PixelSquare  # shared with the other samples of their pixels


class FirstHit(NamedTuple):
    """The first surface on a ray, and the point there; body -1 if there is none."""

    t: float
    body: int
    surface: int
    face: int
    side: int  # -1 where the surface's own normal points into the body, else 1
    x: float
    y: float
    z: float


@inline
def trace_samples(geometry: Geometry, scratch: Scratch, samples: Samples) -> None:
    """Trace the first hits of all rays together; `seen` then returns them ray by ray."""
    close_lanes(samples.packet.lanes, samples.size)
    trace_square(geometry, scratch, samples.packet, samples.square, samples.pixels[0], scratch.nothing, False)


@inline
def first_hit_of(geometry: Geometry, samples: Samples, i: int) -> FirstHit:
    """The first hit of ray i. Relies on `trace_samples` having been called."""
    return _place_hit(geometry, lane_ray(samples.packet.lanes, i, math.inf), lane_hit(samples.packet.lanes, i))


@inline
def first_hit_along(geometry: Geometry, scratch: Scratch, ray: Ray) -> FirstHit:
    """The first hit of a single ray."""
    return _place_hit(geometry, ray, first_crossing(geometry, scratch, ray, scratch.nothing, False))


@inline
def _place_hit(geometry: Geometry, ray: Ray, hit: Hit) -> FirstHit:
    """Return the first surface on a ray, and the point there."""
    t, body, surface, face, side = resolve_hit(geometry, hit)
    if body < 0:
        return FirstHit(t, body, surface, face, side, 0.0, 0.0, 0.0)
    return FirstHit(t, body, surface, face, side, ray.ox + t * ray.dx, ray.oy + t * ray.dy, ray.oz + t * ray.dz)


@allocator
def no_memory(geometry: Geometry, settings: Settings) -> None:
    """For integrators that keep nothing from one packet to the next."""


@inline
def finish_nothing(geometry: Geometry, scratch: Scratch, memory: Any, settings: Settings, samples: Samples) -> None:
    """For integrators that are done with a packet when they return."""
