"""The state of a square of pixels in the tile loop: their numbers, their light, and its sums onto the film.

Loops over rows of a table with several columns write these one by one: Numba fills a part of a table row by row, each
by a call, which took a tenth of the time of a simple picture.
"""

from __future__ import annotations

import functools
import importlib
import math
from collections.abc import Callable
from typing import Annotated, Any, NamedTuple

import numpy as np
import numpy.typing as npt

from .._jit.decorators import allocator, helper, inline, kernel
from ..kernels.body.scratch import Scratch, new_scratch
from ..kernels.packet.lanes import LANES, put_ray
from ..kernels.packet.packet import Packet, new_packet
from ..kernels.packet.traversal import PixelSquare, new_square
from ..kernels.ray import Ray
from ..kernels.tables import Floats, Geometry, Longs, Signs, is_halted, whole
from . import integrators
from .camera_rays import CameraView, camera_ray, filtered_offset, general_ray
from .film import BLUE, COUNT, GREEN, RED, SQUARES, SUMS
from .integrators import INTEGRATORS
from .integrators.samples import NO_SURFACE, Samples, Settings, finish_nothing, no_memory
from .lights.light_tables import PathLight, WhittedLight
from .options import LINEAR, THIN_LENS
from .sampling import pair_by_keys, sample_in_pixel, sobol_keys, sobol_pair

SQUARE = 8
"""Pixels along a packet."""

Film = npt.NDArray[np.float32]


class SquareBuffers(NamedTuple):
    """The state of the pixels of a square in the tile loop."""

    pixels: Longs  # (64,) their numbers
    places: Floats  # (2 · 64) where in the picture a sample of each lies: x, then y
    offsets: Floats  # (2 · 64) where in its pixel a sample of each lies: x, then y
    keys: Any  # uint64 (2 · 64) of Sobol's points in each: `sobol_keys`
    weights: Floats  # (64 a sample,) of samples
    colors: Floats  # (64 a sample, 3) of some samples
    sums: Floats  # (64, SUMS) of all, see `film.sums`


@allocator
def new_square_buffers(batch: int) -> SquareBuffers:
    """For one thread, and so many samples at a time."""
    rows = LANES * batch
    return SquareBuffers(
        np.zeros(LANES, np.int64), np.empty(2 * LANES), np.empty(2 * LANES), np.zeros(2 * LANES, np.uint64),
        np.ones(rows), np.empty((rows, 3)), np.empty((LANES, SUMS)),
    )  # fmt: skip


@helper
def number_pixels(frame: SquareBuffers, film: Film, left: int, top: int) -> int:
    """The numbers of a square's pixels, row by row, and their corners; returns how many there are."""
    height, width, count = film.shape[0], film.shape[1], 0
    for row in range(top, min(height, top + SQUARE)):
        for column in range(left, min(width, left + SQUARE)):
            frame.pixels[count] = row * width + column
            frame.places[count], frame.places[LANES + count] = column, row
            count += 1
    return count


@helper
def find_keys(frame: SquareBuffers, count: int, seed: int) -> None:
    """The keys of the places in numbered pixels."""
    orders, scrambles, pixels = frame.keys[:LANES], frame.keys[LANES:], frame.pixels
    for i in range(count):
        orders[i], scrambles[i] = sobol_keys(seed, pixels[i], 0)


@helper
def begin_square(frame: SquareBuffers, film: Film, sums: Floats, left: int, top: int) -> int:
    """The sums of a square's samples so far, and how many samples they are of."""
    count, total = 0, frame.sums
    if len(sums) == 0:
        for i in range(LANES):
            for k in range(SUMS):
                total[i, k] = 0.0
        return 0
    for row in range(top, min(film.shape[0], top + SQUARE)):
        for column in range(left, min(film.shape[1], left + SQUARE)):
            for k in range(SUMS):
                total[count, k] = sums[row, column, k]
            count += 1
    return int(total[0, COUNT])


@inline
def clear_colors(colors: Floats, rows: int) -> None:
    """Let the first rows of some colours be black."""
    for i in range(rows):
        colors[i, 0], colors[i, 1], colors[i, 2] = 0.0, 0.0, 0.0


@inline
def luminance(r: float, g: float, b: float) -> float:
    """Return the luminance of linear light."""
    return RED * r + GREEN * g + BLUE * b


@helper
def add_samples(frame: SquareBuffers, count: int, several: int) -> None:
    """Add some samples to the sums of each pixel of a square, one after the other, with their weights."""
    weights, colors, sums = frame.weights, frame.colors, frame.sums
    for i in range(count):
        red, green, blue, squares = sums[i, 0], sums[i, 1], sums[i, 2], sums[i, SQUARES]
        for at in range(i, i + LANES * several, LANES):
            weight = weights[at]
            r, g, b = weight * colors[at, 0], weight * colors[at, 1], weight * colors[at, 2]
            light = luminance(r, g, b)
            red, green, blue, squares = red + r, green + g, blue + b, squares + light * light
        sums[i, 0], sums[i, 1], sums[i, 2], sums[i, SQUARES] = red, green, blue, squares


@helper
def end_square(frame: SquareBuffers, film: Film, sums: Floats, left: int, top: int, samples: int) -> None:
    """The mean of a square's samples onto the film, and their sums where these are kept."""
    count, total = 0, frame.sums
    for row in range(top, min(film.shape[0], top + SQUARE)):
        for column in range(left, min(film.shape[1], left + SQUARE)):
            r, g, b = total[count, 0], total[count, 1], total[count, 2]
            if samples > 1:
                r, g, b = r / samples, g / samples, b / samples
            film[row, column, 0], film[row, column, 1], film[row, column, 2] = r, g, b
            count += 1
    if len(sums) == 0:
        return
    count = 0
    for row in range(top, min(film.shape[0], top + SQUARE)):
        for column in range(left, min(film.shape[1], left + SQUARE)):
            for k in range(SUMS):
                sums[row, column, k] = total[count, k]
            sums[row, column, COUNT] = samples
            count += 1


# The kernels that fill a film, one square tile of pixels after the other: one kernel for each integrator.
#
# A pixel's colour depends on its place, the sample count and the seed only, so pictures are the same
# to the bit whatever the number of threads. Where sums are kept a picture may be gone on with: samples are added one
# after the other, so that also those of several runs make the same sums.

SIDE = 32
"""Pixels along a tile."""


@inline
def tile_total(width: int, height: int) -> int:
    """How many tiles a film has."""
    return -(-width // SIDE) * -(-height // SIDE)


def tiles_of_squares(rows: Longs, columns: Longs, width: int) -> Longs:
    """The tiles in which squares lie, by the squares' rows and columns."""
    return rows * SQUARE // SIDE * -(-width // SIDE) + columns * SQUARE // SIDE


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
def plain_rays(
    frame: SquareBuffers, lens: Floats, lanes: Floats, film: Film, count: int, sample: int, settings: Settings,
    progressive: bool,
) -> None:  # fmt: skip
    """Put the rays of a pinhole or an orthographic camera without a filter into lanes, as `camera_rays` does.

    Its loops are short, for the lanes of a processor. The places of samples come first: in one loop with the rays, a
    processor sees too few lanes at a time.
    """
    height, width, seed, samples, pixels = film.shape[0], film.shape[1], settings.seed, settings.samples, frame.pixels
    x, y, u, v = frame.places[:LANES], frame.places[LANES:], frame.offsets[:LANES], frame.offsets[LANES:]
    if progressive:
        orders, scrambles = frame.keys[:LANES], frame.keys[LANES:]
        for i in range(count):
            u[i], v[i] = pair_by_keys(orders[i], scrambles[i], sample)
    else:
        for i in range(count):
            u[i], v[i] = sample_in_pixel(seed, pixels[i], sample, samples)
    for i in range(count):
        put_plain_ray(lens, lanes, i, x[i] + u[i], y[i] + v[i], width, height)


@inline
def put_plain_ray(lens: Floats, lanes: Floats, i: int, x: float, y: float, width: int, height: int) -> None:
    """The ray through a point of the picture into a lane."""
    ox, oy, oz, dx, dy, dz = camera_ray(lens, x, y, width, height)
    put_ray(lanes, i, Ray(ox, oy, oz, dx, dy, dz, 0.0, math.inf, whole(NO_SURFACE)))


@helper
def general_rays(
    view: CameraView, frame: SquareBuffers, lanes: Floats, film: Film, count: int, sample: int, settings: Settings,
    progressive: bool, first: int,
) -> None:  # fmt: skip
    """`camera_rays` of any camera and filter; their weights go into the frame, from `first` on."""
    height, width = film.shape[0], film.shape[1]
    for i in range(count):
        ray, frame.weights[first + i] = sample_ray(
            view,
            settings,
            progressive,
            frame.pixels[i],
            frame.places[i],
            frame.places[LANES + i],
            sample,
            width,
            height,
        )
        put_ray(lanes, i, ray)


@inline
def sample_ray(
    view: CameraView, settings: Settings, progressive: bool, pixel: int, column: float, row: float, sample: int,
    width: int, height: int,
) -> tuple[Ray, float]:  # fmt: skip
    """Return (the ray of a sample of a pixel, its weight) of any camera and filter."""
    x, y = _in_pixel(progressive, settings.seed, pixel, sample, settings.samples)
    weight = view.scale
    if view.filtered == 1:
        x, one = filtered_offset(view, x)
        y, other = filtered_offset(view, y)
        x, y, weight = x + 0.5, y + 0.5, weight * one * other
    a, b = sobol_pair(settings.seed, pixel, sample, 1) if view.kind == THIN_LENS else (0.5, 0.5)
    ox, oy, oz, dx, dy, dz, is_seen = general_ray(view, column + x, row + y, a, b, width, height)
    return Ray(ox, oy, oz, dx, dy, dz, 0.0, math.inf, whole(NO_SURFACE)), weight if is_seen else 0.0


@inline
def camera_rays(
    view: CameraView, frame: SquareBuffers, lanes: Floats, film: Film, count: int, sample: int, settings: Settings,
    progressive: bool, first: int,
) -> None:  # fmt: skip
    """One ray through each pixel of a square whose pixels are numbered, into the first `count` lanes.

    What each ray counts, where they do not count the same, goes into the frame, from row `first` on.
    """
    if view.kind == LINEAR and view.filtered == 0:
        plain_rays(frame, view.lens, lanes, film, count, sample, settings, progressive)
    else:
        general_rays(view, frame, lanes, film, count, sample, settings, progressive, first)


@inline
def is_wanted(squares: Signs, left: int, top: int, width: int) -> bool:
    """Is a square to get more samples? All are, where none are named."""
    at = top // SQUARE * ((width + SQUARE - 1) // SQUARE) + left // SQUARE
    return len(squares) == 0 or (at < len(squares) and squares[at] == 1)


def tile_kernel(integrator: str) -> Callable[..., None]:
    """The kernel that fills tiles begin to end of a film, with an integrator compiled into it."""
    kind = INTEGRATORS[integrator]
    shared = ((name, each) for name, each in INTEGRATORS.items() if each.module == kind.module)
    return _tile_kernel(next(name for name, each in shared if each.progressive == kind.progressive))


@functools.cache
def _tile_kernel(integrator: str) -> Callable[..., None]:
    """The same for the first of the integrators that share a module and take their samples in the same way."""
    kind = INTEGRATORS[integrator]
    module = importlib.import_module(f"{integrators.__name__}.{kind.module}")
    gather, new_memory, progressive = module.gather, getattr(module, "new_memory", no_memory), kind.progressive
    batch, finish = getattr(module, "BATCH", 1), getattr(module, "finish", finish_nothing)

    @helper
    def square(
        geometry: Geometry,
        scratch: Scratch,
        memory: Any,
        packet: Packet,
        seen: PixelSquare,
        frame: SquareBuffers,
        view: CameraView,
        film: Film,
        sums: Floats,
        settings: Settings,
        last: int,
        left: int,
        top: int,
    ) -> None:
        """Bring the pixels of a square to `last` samples."""
        first, count = begin_square(frame, film, sums, left, top), number_pixels(frame, film, left, top)
        by_sobol = progressive or settings.sobol == 1
        if by_sobol:
            find_keys(frame, count, settings.seed)
        is_plain = batch == 1 and len(sums) == 0 and view.kind <= THIN_LENS and view.filtered == 0
        colors = frame.sums if is_plain else frame.colors
        for sample in range(first, last, batch):
            if is_halted(geometry):
                break
            several = min(batch, last - sample)
            if not is_plain:
                clear_colors(colors, LANES * several)
            for k in range(several):
                camera_rays(view, frame, packet.lanes, film, count, sample + k, settings, by_sobol, LANES * k)
                mine = colors[LANES * k : LANES * k + LANES]
                gather(
                    geometry, scratch, memory, settings, Samples(packet, mine, count, frame.pixels, sample + k, seen)
                )  # fmt: skip
            finish(geometry, scratch, memory, settings, Samples(packet, colors, count, frame.pixels, sample, seen))
            if not is_plain:
                add_samples(frame, count, several)
        if len(sums) == 0 or (first < last and not is_halted(geometry)):
            end_square(frame, film, sums, left, top, last)

    def tiles(
        geometry: Geometry, view: CameraView, film: Film, sums: Floats, squares: Signs, settings: Settings, last: int,
        begin: int, end: int,
    ) -> None:  # fmt: skip
        """Bring the pixels of tiles begin to end to `last` samples, in squares that are wanted.

        A square that is halted keeps its sums, if there are any.
        """
        scratch, packet, seen, frame = (
            new_scratch(geometry),
            new_packet(geometry),
            new_square(),
            new_square_buffers(batch),
        )
        memory = new_memory(geometry, settings)
        height, width = film.shape[0], film.shape[1]
        for tile in range(begin, min(end, tile_total(width, height))):
            corner = tile_corner(tile, width)
            for top in range(corner[1], min(height, corner[1] + SIDE), SQUARE):
                for left in range(corner[0], min(width, corner[0] + SIDE), SQUARE):
                    if is_wanted(squares, left, top, width):
                        square(
                            geometry, scratch, memory, packet, seen, frame, view, film, sums, settings, last, left, top
                        )  # fmt: skip

    look = PathLight if kind.transports else WhittedLight if kind.lit else None
    tiles.__annotations__["settings"] = Annotated[Settings, {"look": look}]
    tiles.__name__ = tiles.__qualname__ = f"{integrator}_tiles"
    return kernel(film="out h w 3", sums=f"out h|0 w {SUMS}", squares="*", last="1..1048576", begin="0..end")(tiles)
