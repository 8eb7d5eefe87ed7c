"""Where in a pixel the samples lie: stratified, jittered, and the same for any order of work.

Sample i of n in a pixel is a randomised Hammersley point: x = (i + jitter) / n, one sample in each
of n columns, and y = the binary digits of i read backwards, with a random digit flip that all samples of
the pixel share; where n is a power of two each of n rows has one sample too, and so has every
box of 2⁻ᵃ by 2ᵃ / n. Random numbers are a hash of (seed, pixel, sample): no state passes between them.

Progressive pictures, which do not know n, take `sobol` for all: dimensions 0 and 1 are the place in the pixel, 2 and 3
that on the lens, 4 is the time, 5 to 7 are for later, and a path takes those from 8 on.
"""

from __future__ import annotations

import numpy as np

from ..compiler.jit import inline
from ..integrators.sobol import mixed, pair_by_keys, sobol, sobol_keys, sobol_pair

__all__ = [
    "pair_by_keys",
    "reversed_bits",
    "sample_in_pixel",
    "sobol",
    "sobol_keys",
    "sobol_pair",
    "unit_interval",
]

_UNIT = 2.0**-53


@inline
def reversed_bits(value: np.uint64) -> np.uint64:
    """The 64 bits of a value in reverse order, by swapping halves of halves."""
    v = (value >> np.uint64(32)) | (value << np.uint64(32))
    v = ((v & np.uint64(0xFFFF0000FFFF0000)) >> np.uint64(16)) | ((v & np.uint64(0x0000FFFF0000FFFF)) << np.uint64(16))
    v = ((v & np.uint64(0xFF00FF00FF00FF00)) >> np.uint64(8)) | ((v & np.uint64(0x00FF00FF00FF00FF)) << np.uint64(8))
    v = ((v & np.uint64(0xF0F0F0F0F0F0F0F0)) >> np.uint64(4)) | ((v & np.uint64(0x0F0F0F0F0F0F0F0F)) << np.uint64(4))
    v = ((v & np.uint64(0xCCCCCCCCCCCCCCCC)) >> np.uint64(2)) | ((v & np.uint64(0x3333333333333333)) << np.uint64(2))
    return ((v & np.uint64(0xAAAAAAAAAAAAAAAA)) >> np.uint64(1)) | ((v & np.uint64(0x5555555555555555)) << np.uint64(1))


@inline
def unit_interval(bits: np.uint64) -> float:
    """The upper 53 bits as a number in [0, 1)."""
    return float(bits >> np.uint64(11)) * _UNIT


@inline
def sample_in_pixel(seed: int, pixel: int, sample: int, count: int) -> tuple[float, float]:
    """(x, y) in [0, 1)² of one sample of `count`; the centre of the pixel if there is but one."""
    if count == 1:
        return 0.5, 0.5
    of_pixel = mixed(mixed(np.uint64(seed)) ^ np.uint64(pixel))
    jitter = unit_interval(mixed(of_pixel ^ np.uint64(sample + 1)))
    y = unit_interval(reversed_bits(np.uint64(sample)) ^ of_pixel)
    return (sample + jitter) / count, y
