"""The kernels that fill a film, one square tile of pixels after the other: one kernel for each integrator.

A pixel's colour depends on its place, the sample count and the seed only, so pictures are the same
to the bit whatever the number of threads. Where sums are kept a picture may be gone on with: samples are added one
after the other, so that also those of several runs make the same sums.
"""

from __future__ import annotations

import functools
import importlib
import math
from collections.abc import Callable
from typing import Annotated, NamedTuple

import numpy as np
import numpy.typing as npt

from .. import integrators
from ..compiler.jit import allocator, helper, inline, kernel
from ..emitters.lamplight import Lamplight
from ..emitters.transport import Transport
from ..engine.body.scratch import new_scratch
from ..engine.packets.lanes import LANES, put_ray
from ..engine.packets.packet import new_packet
from ..engine.ray import Ray
from ..engine.tables import Floats, Geometry, Longs, Signs, halted, whole
from ..film.sums import COUNT, SQUARES, SUMS, luminance
from ..integrators import INTEGRATORS
from ..integrators.samples import Samples, Settings, no_memory, nothing_left
from ..integrators.stack import NO_SURFACE
from .camera import LINEAR, THIN_LENS
from .sampler import sample_in_pixel, sobol_pair
from .view import View, camera_ray, filtered_offset, special_ray

SIDE = 32
"""Pixels along a tile."""

SQUARE = 8
"""Pixels along a packet."""

Film = npt.NDArray[np.float32]


class Frame(NamedTuple):
    """What the tile loop keeps of the pixels of a square."""

    pixels: Longs  # (64,) their numbers
    places: Floats  # (2 · 64) where in the picture a sample of each lies: x, then y
    weights: Floats  # (64 a sample,) what samples count
    colors: Floats  # (64 a sample, 3) of some samples
    sums: Floats  # (64, SUMS) of all, see `film.sums`


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
def _in_pixel(progressive: bool, seed: int, pixel: int, sample: int, samples: int) -> tuple[float, float]:
    """Where in its pixel a sample lies, (x, y) in [0, 1)²."""
    if progressive:
        return sobol_pair(seed, pixel, sample, 0)
    return sample_in_pixel(seed, pixel, sample, samples)


@helper
def number_pixels(frame: Frame, film: Film, left: int, top: int) -> int:
    """The numbers of a square's pixels, row by row, and their corners; returns how many there are."""
    height, width, count = film.shape[0], film.shape[1], 0
    for row in range(top, min(height, top + SQUARE)):
        for column in range(left, min(width, left + SQUARE)):
            frame.pixels[count] = row * width + column
            frame.places[count], frame.places[LANES + count] = column, row
            count += 1
    return count


@helper
def plain_rays(
    frame: Frame, lens: Floats, lanes: Floats, film: Film, count: int, sample: int, settings: Settings,
    progressive: bool,
) -> None:  # fmt: skip
    """`camera_rays` of a pinhole or an orthographic camera, without a filter: short loops, for lanes of a processor."""
    height, width, seed, samples, pixels = film.shape[0], film.shape[1], settings.seed, settings.samples, frame.pixels
    x, y = frame.places[:LANES], frame.places[LANES:]
    if progressive:
        for i in range(count):
            u, v = sobol_pair(seed, pixels[i], sample, 0)
            put_plain_ray(lens, lanes, i, x[i] + u, y[i] + v, width, height)
    elif samples == 1:
        for i in range(count):
            put_plain_ray(lens, lanes, i, x[i] + 0.5, y[i] + 0.5, width, height)
    else:
        for i in range(count):
            u, v = sample_in_pixel(seed, pixels[i], sample, samples)
            put_plain_ray(lens, lanes, i, x[i] + u, y[i] + v, width, height)


@inline
def put_plain_ray(lens: Floats, lanes: Floats, i: int, x: float, y: float, width: int, height: int) -> None:
    """The ray through a point of the picture into a lane."""
    ox, oy, oz, dx, dy, dz = camera_ray(lens, x, y, width, height)
    put_ray(lanes, i, Ray(ox, oy, oz, dx, dy, dz, 0.0, math.inf, whole(NO_SURFACE)))


@helper
def special_rays(
    view: View, frame: Frame, lanes: Floats, film: Film, count: int, sample: int, settings: Settings,
    progressive: bool, first: int,
) -> None:  # fmt: skip
    """`camera_rays` of any camera and filter; what they count goes into the frame, from `first` on."""
    height, width, seed = film.shape[0], film.shape[1], settings.seed
    for i in range(count):
        pixel = frame.pixels[i]
        x, y = _in_pixel(progressive, seed, pixel, sample, settings.samples)
        weight = view.scale
        if view.filtered == 1:
            x, one = filtered_offset(view, x)
            y, other = filtered_offset(view, y)
            x, y, weight = x + 0.5, y + 0.5, weight * one * other
        a, b = sobol_pair(seed, pixel, sample, 1) if view.kind == THIN_LENS else (0.5, 0.5)
        x, y = frame.places[i] + x, frame.places[LANES + i] + y
        ox, oy, oz, dx, dy, dz, is_seen = special_ray(view, x, y, a, b, width, height)
        frame.weights[first + i] = weight if is_seen else 0.0
        put_ray(lanes, i, Ray(ox, oy, oz, dx, dy, dz, 0.0, math.inf, whole(NO_SURFACE)))


@inline
def camera_rays(
    view: View, frame: Frame, lanes: Floats, film: Film, count: int, sample: int, settings: Settings,
    progressive: bool, first: int,
) -> None:  # fmt: skip
    """One ray through each pixel of a square whose pixels are numbered, into the first `count` lanes.

    What each ray counts, where they do not count the same, goes into the frame, from row `first` on.
    """
    if view.kind == LINEAR and view.filtered == 0:
        plain_rays(frame, view.lens, lanes, film, count, sample, settings, progressive)
    else:
        special_rays(view, frame, lanes, film, count, sample, settings, progressive, first)


@allocator
def new_frame(batch: int) -> Frame:
    """For one thread, and so many samples at a time."""
    rows = LANES * batch
    return Frame(
        np.zeros(LANES, np.int64), np.empty(2 * LANES), np.ones(rows), np.empty((rows, 3)), np.empty((LANES, SUMS))
    )


@helper
def begin_square(frame: Frame, film: Film, sums: Floats, left: int, top: int) -> int:
    """The sums of a square's samples so far, and how many samples they are of."""
    frame.sums[:] = 0.0
    if len(sums) == 0:
        return 0
    count = 0
    for row in range(top, min(film.shape[0], top + SQUARE)):
        for column in range(left, min(film.shape[1], left + SQUARE)):
            for k in range(SUMS):
                frame.sums[count, k] = sums[row, column, k]
            count += 1
    return int(frame.sums[0, COUNT])


@inline
def add_samples(frame: Frame, count: int, first: int) -> None:
    """One sample more of each pixel of a square: its light, from row `first` on, times what it counts."""
    for i in range(count):
        weight, color = frame.weights[first + i], frame.colors[first + i]
        r, g, b = weight * color[0], weight * color[1], weight * color[2]
        light = luminance(r, g, b)
        row = frame.sums[i]
        row[0], row[1], row[2], row[SQUARES] = row[0] + r, row[1] + g, row[2] + b, row[SQUARES] + light * light


@helper
def end_square(frame: Frame, film: Film, sums: Floats, left: int, top: int, samples: int) -> None:
    """The mean of a square's samples onto the film, and their sums where these are kept."""
    count = 0
    for row in range(top, min(film.shape[0], top + SQUARE)):
        for column in range(left, min(film.shape[1], left + SQUARE)):
            for k in range(film.shape[2]):
                film[row, column, k] = frame.sums[count, k] / samples
            if len(sums) > 0:
                for k in range(SUMS):
                    sums[row, column, k] = frame.sums[count, k]
                sums[row, column, COUNT] = samples
            count += 1


@inline
def is_wanted(squares: Signs, left: int, top: int, width: int) -> bool:
    """Is a square to get more samples? All are, where none are named."""
    at = top // SQUARE * ((width + SQUARE - 1) // SQUARE) + left // SQUARE
    return len(squares) == 0 or (at < len(squares) and squares[at] == 1)


def tile_kernel(integrator: str) -> Callable[..., None]:
    """The kernel that fills tiles begin to end of a film, with an integrator compiled into it."""
    chosen = INTEGRATORS[integrator]
    shared = ((name, each) for name, each in INTEGRATORS.items() if each.module == chosen.module)
    return _tile_kernel(next(name for name, each in shared if each.progressive == chosen.progressive))


@functools.cache
def _tile_kernel(integrator: str) -> Callable[..., None]:
    """The same for the first of the integrators that share a module and take their samples in the same way."""
    chosen = INTEGRATORS[integrator]
    module = importlib.import_module(f"{integrators.__name__}.{chosen.module}")
    gather, new_memory, progressive = module.gather, getattr(module, "new_memory", no_memory), chosen.progressive
    batch, finish = getattr(module, "BATCH", 1), getattr(module, "finish", nothing_left)

    def tiles(
        geometry: Geometry, view: View, film: Film, sums: Floats, squares: Signs, settings: Settings, last: int,
        begin: int, end: int,
    ) -> None:  # fmt: skip
        """Bring the pixels of tiles begin to end to `last` samples, in squares that are wanted.

        A square that is halted keeps its sums, if there are any.
        """
        scratch, packet, frame = new_scratch(geometry), new_packet(), new_frame(batch)
        memory = new_memory(geometry, settings)
        height, width = film.shape[0], film.shape[1]
        is_plain = batch == 1 and len(sums) == 0 and view.kind <= THIN_LENS and view.filtered == 0
        by_sobol = progressive or settings.sobol == 1
        colors = frame.sums if is_plain else frame.colors
        for tile in range(begin, min(end, tile_total(width, height))):
            corner = tile_corner(tile, width)
            for top in range(corner[1], min(height, corner[1] + SIDE), SQUARE):
                for left in range(corner[0], min(width, corner[0] + SIDE), SQUARE):
                    if not is_wanted(squares, left, top, width):
                        continue
                    first, count = begin_square(frame, film, sums, left, top), number_pixels(frame, film, left, top)
                    for sample in range(first, last, batch):
                        if halted(geometry):
                            break
                        several = min(batch, last - sample)
                        if not is_plain:
                            colors[: LANES * several] = 0.0
                        for k in range(several):
                            camera_rays(
                                view, frame, packet.lanes, film, count, sample + k, settings, by_sobol, LANES * k
                            )
                            mine = colors[LANES * k : LANES * k + LANES]
                            gather(
                                geometry, scratch, memory, settings,
                                Samples(packet, mine, count, frame.pixels, sample + k),
                            )  # fmt: skip
                        finish(
                            geometry, scratch, memory, settings,
                            Samples(packet, colors, count, frame.pixels, sample),
                        )  # fmt: skip
                        if not is_plain:
                            for k in range(several):
                                add_samples(frame, count, LANES * k)
                    if len(sums) == 0 or (first < last and not halted(geometry)):
                        end_square(frame, film, sums, left, top, last)

    look = Transport if chosen.transports else Lamplight if chosen.lit else None
    tiles.__annotations__["settings"] = Annotated[Settings, {"look": look}]
    tiles.__name__ = tiles.__qualname__ = f"{integrator}_tiles"
    return kernel(film="out h w 3", sums=f"out h|0 w {SUMS}", squares="*", last="1..1048576", begin="0..end")(tiles)
