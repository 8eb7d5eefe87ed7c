"""The kernels that fill a film, one square tile of pixels after the other: one kernel for each integrator.

A pixel's colour depends on its place, the sample count and the seed only, so pictures are the same
to the bit whatever the number of threads.
"""

from __future__ import annotations

import functools
import importlib
import math
from collections.abc import Callable
from typing import Annotated

import numpy as np
import numpy.typing as npt

from .. import integrators
from ..compiler.jit import helper, inline, kernel
from ..engine.body.scratch import new_scratch
from ..engine.numbers.vectors import normalized
from ..engine.packets.lanes import LANES, put_ray
from ..engine.packets.packet import new_packet
from ..engine.ray import Ray
from ..engine.tables import Floats, Geometry, Longs, halted, whole
from ..integrators import INTEGRATORS
from ..integrators.samples import Samples, Settings, no_memory
from ..integrators.stack import NO_SURFACE
from ..shading.look import Look
from .sampler import sample_in_pixel, sobol_pair

SIDE = 32
"""Pixels along a tile."""

_SQUARE = 8
"""Pixels along a packet."""

Film = npt.NDArray[np.float32]


@inline
def tile_total(width: int, height: int) -> int:
    """How many tiles a film has."""
    return -(-width // SIDE) * -(-height // SIDE)


@inline
def tile_corner(tile: int, width: int) -> tuple[int, int]:
    """(column, row) of the first pixel of a tile; tiles are numbered along rows of tiles."""
    across = (width + SIDE - 1) // SIDE
    return SIDE * (tile % across), SIDE * (tile // across)


@inline
def camera_ray(
    lens: Floats, x: float, y: float, width: int, height: int
) -> tuple[float, float, float, float, float, float]:
    """Origin and unit direction through a point of the picture, in pixels (see `camera`)."""
    u, v = (2.0 * x - width) / height, (height - 2.0 * y) / height
    dx, dy, dz = normalized(
        lens[3, 0] + u * lens[4, 0] + v * lens[5, 0],
        lens[3, 1] + u * lens[4, 1] + v * lens[5, 1],
        lens[3, 2] + u * lens[4, 2] + v * lens[5, 2],
    )
    ox = lens[0, 0] + u * lens[1, 0] + v * lens[2, 0]
    oy = lens[0, 1] + u * lens[1, 1] + v * lens[2, 1]
    oz = lens[0, 2] + u * lens[1, 2] + v * lens[2, 2]
    return ox, oy, oz, dx, dy, dz


@helper
def camera_rays(
    lens: Floats, lanes: Floats, film: Film, pixels: Longs, left: int, top: int, sample: int, samples: int, seed: int,
    progressive: bool,
) -> int:  # fmt: skip
    """One ray through each pixel of the square at (left, top), row by row; returns how many pixels that are.

    Their numbers go into `pixels`.
    """
    height, width, count = film.shape[0], film.shape[1], 0
    for row in range(top, min(height, top + _SQUARE)):
        for column in range(left, min(width, left + _SQUARE)):
            pixel = row * width + column
            if progressive:
                x, y = sobol_pair(seed, pixel, sample, 0)
            else:
                x, y = sample_in_pixel(seed, pixel, sample, samples)
            pixels[count] = pixel
            ox, oy, oz, dx, dy, dz = camera_ray(lens, column + x, row + y, width, height)
            put_ray(lanes, count, Ray(ox, oy, oz, dx, dy, dz, 0.0, math.inf, whole(NO_SURFACE)))
            count += 1
    return count


@helper
def expose(film: Film, colors: Floats, left: int, top: int, samples: int) -> None:
    """The mean of a square's samples onto the film."""
    count = 0
    for row in range(top, min(film.shape[0], top + _SQUARE)):
        for column in range(left, min(film.shape[1], left + _SQUARE)):
            for k in range(film.shape[2]):
                film[row, column, k] = colors[count, k] / samples
            count += 1


@functools.cache
def tile_kernel(integrator: str) -> Callable[..., None]:
    """The kernel that fills tiles begin to end of a film, with an integrator compiled into it."""
    chosen = INTEGRATORS[integrator]
    module = importlib.import_module(f"{integrators.__name__}.{chosen.file or integrator}")
    gather, new_memory, progressive = module.gather, getattr(module, "new_memory", no_memory), chosen.progressive

    def tiles(geometry: Geometry, lens: Floats, film: Film, settings: Settings, begin: int, end: int) -> None:
        """Fill tiles begin to end of a film."""
        scratch, packet, memory = new_scratch(geometry), new_packet(), new_memory(settings)
        colors, pixels = np.empty((LANES, film.shape[2])), np.zeros(LANES, np.int64)
        height, width = film.shape[0], film.shape[1]
        for tile in range(begin, min(end, tile_total(width, height))):
            corner = tile_corner(tile, width)
            for top in range(corner[1], min(height, corner[1] + SIDE), _SQUARE):
                for left in range(corner[0], min(width, corner[0] + SIDE), _SQUARE):
                    colors[:] = 0.0
                    for sample in range(settings.samples):
                        if halted(geometry):
                            break
                        count = camera_rays(
                            lens, packet.lanes, film, pixels, left, top, sample, settings.samples, settings.seed,
                            progressive,
                        )  # fmt: skip
                        rays = Samples(packet, colors, count, pixels, sample)
                        gather(geometry, scratch, memory, settings, rays)
                    expose(film, colors, left, top, settings.samples)

    look = Look if chosen.lit else None
    tiles.__annotations__["settings"] = Annotated[Settings, {"look": look}]
    tiles.__name__ = tiles.__qualname__ = chosen.kernel
    return kernel(lens="6 3", film="out h w 3", begin="0..end")(tiles)
