"""The two kernels that fill a film, one square tile of pixels after the other.

A pixel's colour depends on its place, the sample count and the seed only, so pictures are the same
to the bit whatever the number of threads.
"""

from __future__ import annotations

import numpy as np
import numpy.typing as npt

from ..geometry.tables import Floats, Geometry
from ..geometry.vectors import normalized
from ..integrators.normals import normals_radiance
from ..integrators.stack import new_stack
from ..integrators.whitted import camera_medium, whitted_radiance
from ..jit import inline, kernel
from ..shading.look import Look
from ..trace.kernels import new_scratch
from .sampler import sample_in_pixel

SIDE = 16
"""Pixels along a tile."""

Film = npt.NDArray[np.float32]


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


@kernel
def normals_tiles(geometry: Geometry, lens: Floats, film: Film, samples: int, seed: int, begin: int, end: int) -> None:
    """Fill tiles begin to end with the colours of normals."""
    scratch = new_scratch(geometry)
    height, width = film.shape[0], film.shape[1]
    for tile in range(begin, end):
        left, top = tile_corner(tile, width)
        for row in range(top, min(height, top + SIDE)):
            for column in range(left, min(width, left + SIDE)):
                red, green, blue = 0.0, 0.0, 0.0
                for sample in range(samples):
                    x, y = sample_in_pixel(seed, row * width + column, sample, samples)
                    ox, oy, oz, dx, dy, dz = camera_ray(lens, column + x, row + y, width, height)
                    r, g, b = normals_radiance(geometry, scratch, ox, oy, oz, dx, dy, dz)
                    red, green, blue = red + r, green + g, blue + b
                film[row, column, 0] = red / samples
                film[row, column, 1] = green / samples
                film[row, column, 2] = blue / samples


@kernel
def whitted_tiles(
    geometry: Geometry, lens: Floats, film: Film, samples: int, seed: int, look: Look, depth: int, begin: int, end: int
) -> None:
    """Fill tiles begin to end by Whitted's method."""
    scratch = new_scratch(geometry)
    stack = new_stack(depth)
    height, width = film.shape[0], film.shape[1]
    for tile in range(begin, end):
        left, top = tile_corner(tile, width)
        for row in range(top, min(height, top + SIDE)):
            for column in range(left, min(width, left + SIDE)):
                red, green, blue = 0.0, 0.0, 0.0
                for sample in range(samples):
                    x, y = sample_in_pixel(seed, row * width + column, sample, samples)
                    ox, oy, oz, dx, dy, dz = camera_ray(lens, column + x, row + y, width, height)
                    medium = camera_medium(geometry, scratch, look.materials, ox, oy, oz)
                    r, g, b = whitted_radiance(geometry, scratch, stack, look, depth, medium, ox, oy, oz, dx, dy, dz)
                    red, green, blue = red + r, green + g, blue + b
                film[row, column, 0] = red / samples
                film[row, column, 1] = green / samples
                film[row, column, 2] = blue / samples
