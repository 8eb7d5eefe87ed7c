"""What the tile loop keeps of a square of pixels: their numbers, their light, and its sums onto the film.

Loops over rows of a table with several columns write these one by one: Numba fills a part of a table row by row, each
by a call, which took a tenth of the time of a simple picture.
"""

from __future__ import annotations

from typing import Any, NamedTuple

import numpy as np
import numpy.typing as npt

from ..compiler.jit import allocator, helper, inline
from ..engine.packets.lanes import LANES
from ..engine.tables import Floats, Longs
from ..film.sums import COUNT, SQUARES, SUMS, luminance
from .sampler import sobol_keys

SQUARE = 8
"""Pixels along a packet."""

Film = npt.NDArray[np.float32]


class Frame(NamedTuple):
    """What the tile loop keeps of the pixels of a square."""

    pixels: Longs  # (64,) their numbers
    places: Floats  # (2 · 64) where in the picture a sample of each lies: x, then y
    offsets: Floats  # (2 · 64) where in its pixel a sample of each lies: x, then y
    keys: Any  # uint64 (2 · 64) of Sobol's points in each: `sobol_keys`
    weights: Floats  # (64 a sample,) what samples count
    colors: Floats  # (64 a sample, 3) of some samples
    sums: Floats  # (64, SUMS) of all, see `film.sums`


@allocator
def new_frame(batch: int) -> Frame:
    """For one thread, and so many samples at a time."""
    rows = LANES * batch
    return Frame(
        np.zeros(LANES, np.int64), np.empty(2 * LANES), np.empty(2 * LANES), np.zeros(2 * LANES, np.uint64),
        np.ones(rows), np.empty((rows, 3)), np.empty((LANES, SUMS)),
    )  # fmt: skip


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
def find_keys(frame: Frame, count: int, seed: int) -> None:
    """The keys of the places in numbered pixels."""
    orders, scrambles, pixels = frame.keys[:LANES], frame.keys[LANES:], frame.pixels
    for i in range(count):
        orders[i], scrambles[i] = sobol_keys(seed, pixels[i], 0)


@helper
def begin_square(frame: Frame, film: Film, sums: Floats, left: int, top: int) -> int:
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
def no_light(colors: Floats, rows: int) -> None:
    """Let the first rows of some colours be black."""
    for i in range(rows):
        colors[i, 0], colors[i, 1], colors[i, 2] = 0.0, 0.0, 0.0


@helper
def add_samples(frame: Frame, count: int, several: int) -> None:
    """Some samples more of each pixel of a square, one after the other: their light times what it counts."""
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
def end_square(frame: Frame, film: Film, sums: Floats, left: int, top: int, samples: int) -> None:
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
