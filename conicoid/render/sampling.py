"""Sampling: Owen-scrambled Sobol' points, places of samples in a pixel, and directions drawn by chance.

No random number depends on the ones before it, so a picture is the same for any order of work.
"""

from __future__ import annotations

import math
from typing import TypeAlias

import numpy as np

from .._jit.decorators import helper, inline
from ..kernels.numbers.elementary import cos_sin_turns, log_pair
from ..kernels.numbers.vectors import dot

# Owen-scrambled Sobol' points, of any pixel, sample and dimension at once
#
# Dimensions come in pairs: 2k and 2k + 1 are the first two of Sobol's sequence, which are a net together in every power
# of two of samples. Each pair, pixel and seed has a shuffle of the order and two scrambles of its own, by a hash in
# place of Owen's random trees: Burley, Practical Hash-based Owen Scrambling, JCGT 9(4), 2020, with the better hash of
# Vegdahl, Building a better LK hash, 2021. Neither the number of samples nor any state plays a part, so a picture can
# be continued.

_WORD = np.uint64(0xFFFFFFFF)
_HALF = np.uint64(32)
_PER_WORD = 2.0**-32
_WEYL = np.uint64(0x9E3779B97F4A7C15)  # 2⁶⁴ / golden ratio


@inline
def mix_bits(value: np.uint64) -> np.uint64:
    """Return a 64-bit hash: the output function of SplitMix64 (Steele, Lea and Flood 2014)."""
    z = value + _WEYL
    z = (z ^ (z >> np.uint64(30))) * np.uint64(0xBF58476D1CE4E5B9)
    z = (z ^ (z >> np.uint64(27))) * np.uint64(0x94D049BB133111EB)
    return z ^ (z >> np.uint64(31))


@inline
def reverse_word(value: np.uint64) -> np.uint64:
    """Return the 32 lower bits of a value in reverse order, by swapping halves of halves."""
    v = ((value >> np.uint64(16)) | (value << np.uint64(16))) & _WORD
    v = ((v & np.uint64(0xFF00FF00)) >> np.uint64(8)) | ((v & np.uint64(0x00FF00FF)) << np.uint64(8))
    v = ((v & np.uint64(0xF0F0F0F0)) >> np.uint64(4)) | ((v & np.uint64(0x0F0F0F0F)) << np.uint64(4))
    v = ((v & np.uint64(0xCCCCCCCC)) >> np.uint64(2)) | ((v & np.uint64(0x33333333)) << np.uint64(2))
    return ((v & np.uint64(0xAAAAAAAA)) >> np.uint64(1)) | ((v & np.uint64(0x55555555)) << np.uint64(1))


@inline
def second_word(index: np.uint64) -> np.uint64:
    """Return the second Sobol' coordinate of a point, its 32 bits in reverse order.

    Its generator matrix is Pascal's triangle modulo 2, the fifth Kronecker power of ((1, 1), (0, 1)).
    """
    v = index
    v ^= (v & np.uint64(0xAAAAAAAA)) >> np.uint64(1)
    v ^= (v & np.uint64(0xCCCCCCCC)) >> np.uint64(2)
    v ^= (v & np.uint64(0xF0F0F0F0)) >> np.uint64(4)
    v ^= (v & np.uint64(0xFF00FF00)) >> np.uint64(8)
    return v ^ ((v & np.uint64(0xFFFF0000)) >> np.uint64(16))


@inline
def _owen_scramble(word: np.uint64, seed: np.uint64) -> np.uint64:
    """Return a word with each bit flipped by a hash of the bits below it: Owen's tree, for bits in reverse order."""
    x = word
    x ^= (x * np.uint64(0x3D20ADEA)) & _WORD
    x = (x + seed) & _WORD
    x = (x * ((seed >> np.uint64(16)) | np.uint64(1))) & _WORD
    x ^= (x * np.uint64(0x05526C56)) & _WORD
    return x ^ ((x * np.uint64(0x53A22864)) & _WORD)


@inline
def sobol_keys(seed: int, pixel: int, pair: int) -> tuple[np.uint64, np.uint64]:
    """Return (the key that shuffles the order of a pair of dimensions of a pixel, the key that scrambles both).

    They are the same for all samples.
    """
    order = mix_bits(mix_bits(mix_bits(np.uint64(seed)) ^ np.uint64(pixel)) ^ np.uint64(pair))
    return order, mix_bits(order)


@inline
def pair_by_keys(order: np.uint64, scramble: np.uint64, sample: int) -> tuple[float, float]:
    """Return `sobol_pair` of a sample by its `sobol_keys`."""
    index = reverse_word(_owen_scramble(reverse_word(np.uint64(sample)), order & _WORD))
    u = reverse_word(_owen_scramble(index, scramble & _WORD))
    v = reverse_word(_owen_scramble(second_word(index), scramble >> _HALF))
    return float(u) * _PER_WORD, float(v) * _PER_WORD


@inline
def sobol_pair(seed: int, pixel: int, sample: int, pair: int) -> tuple[float, float]:
    """Return dimensions 2 pair and 2 pair + 1 of a sample of a pixel, each in [0, 1)."""
    order, scramble = sobol_keys(seed, pixel, pair)
    return pair_by_keys(order, scramble, sample)


@inline
def sobol(seed: int, pixel: int, sample: int, dimension: int) -> float:
    """Return one dimension of a sample of a pixel, in [0, 1)."""
    u, v = sobol_pair(seed, pixel, sample, dimension >> 1)
    return u if dimension & 1 == 0 else v


# Places of samples in a pixel: stratified and jittered
#
# Sample i of n in a pixel is a randomised Hammersley point: x = (i + jitter) / n, one sample in each
# of n columns, and y = the binary digits of i read backwards, with a random digit flip that all samples of
# the pixel share; where n is a power of two each of n rows has one sample too, and so has every
# box of 2⁻ᵃ by 2ᵃ / n. Random numbers are a hash of (seed, pixel, sample): no state passes between them.
#
# Progressive pictures, which do not know n, take `sobol` for all: dimensions 0 and 1 are the place in the pixel, 2 and
# 3 the place on the lens, 4 is the time, 5 to 7 are not used yet, and a path takes those from 8 on.

_UNIT = 2.0**-53


@inline
def reverse_bits(value: np.uint64) -> np.uint64:
    """Return the 64 bits of a value in reverse order, by swapping halves of halves."""
    v = (value >> np.uint64(32)) | (value << np.uint64(32))
    v = ((v & np.uint64(0xFFFF0000FFFF0000)) >> np.uint64(16)) | ((v & np.uint64(0x0000FFFF0000FFFF)) << np.uint64(16))
    v = ((v & np.uint64(0xFF00FF00FF00FF00)) >> np.uint64(8)) | ((v & np.uint64(0x00FF00FF00FF00FF)) << np.uint64(8))
    v = ((v & np.uint64(0xF0F0F0F0F0F0F0F0)) >> np.uint64(4)) | ((v & np.uint64(0x0F0F0F0F0F0F0F0F)) << np.uint64(4))
    v = ((v & np.uint64(0xCCCCCCCCCCCCCCCC)) >> np.uint64(2)) | ((v & np.uint64(0x3333333333333333)) << np.uint64(2))
    return ((v & np.uint64(0xAAAAAAAAAAAAAAAA)) >> np.uint64(1)) | ((v & np.uint64(0x5555555555555555)) << np.uint64(1))


@inline
def unit_interval(bits: np.uint64) -> float:
    """Return the upper 53 bits as a number in [0, 1)."""
    return float(bits >> np.uint64(11)) * _UNIT


@inline
def sample_in_pixel(seed: int, pixel: int, sample: int, count: int) -> tuple[float, float]:
    """Return (x, y) in [0, 1)² of one sample of `count`; the centre of the pixel if count is 1."""
    if count == 1:
        return 0.5, 0.5
    of_pixel = mix_bits(mix_bits(np.uint64(seed)) ^ np.uint64(pixel))
    jitter = unit_interval(mix_bits(of_pixel ^ np.uint64(sample + 1)))
    y = unit_interval(reverse_bits(np.uint64(sample)) ^ of_pixel)
    return (sample + jitter) / count, y


# Points of the unit square to directions of hemispheres, spheres and cones, without a function of the C library, whose
# last bits differ between systems

Direction: TypeAlias = tuple[float, float, float]


@inline
def unit_direction(u: float, z: float) -> Direction:
    """Return the unit vector of height z at the angle 2 pi u."""
    c, s = cos_sin_turns(u)
    r = math.sqrt(max(0.0, (1.0 - z) * (1.0 + z)))
    return r * c, r * s, z


@inline
def cosine_direction(u: float, v: float) -> Direction:
    """Return a direction of the upper hemisphere, of density cos / pi: a point of the disc, raised (Malley)."""
    c, s = cos_sin_turns(v)
    r = math.sqrt(u)
    return r * c, r * s, math.sqrt(1.0 - u)


@inline
def sphere_direction(u: float, v: float) -> Direction:
    """Return a direction of density 1 / (4 pi)."""
    return unit_direction(v, 1.0 - 2.0 * u)


@inline
def frame_of(x: float, y: float, z: float) -> tuple[Direction, Direction]:
    """Return two unit vectors that make a right-handed frame with a unit vector as the third.

    Duff and others, Building an orthonormal basis, revisited, JCGT 6(1), 2017.
    """
    sign = 1.0 if z >= 0.0 else -1.0
    a = -1.0 / (sign + z)
    b = x * y * a
    return (1.0 + sign * x * x * a, sign * b, -sign * x), (b, sign + y * y * a, -y)


@inline
def to_world(d: Direction, n: Direction) -> Direction:
    """Return a direction of the frame about a unit normal (`frame_of`), in the world."""
    (sx, sy, sz), (tx, ty, tz) = frame_of(n[0], n[1], n[2])
    return (
        dot(d[0], d[1], d[2], sx, tx, n[0]),
        dot(d[0], d[1], d[2], sy, ty, n[1]),
        dot(d[0], d[1], d[2], sz, tz, n[2]),
    )


@inline
def to_frame(d: Direction, n: Direction) -> Direction:
    """Return a direction of the world, in the frame about a unit normal (`frame_of`)."""
    (sx, sy, sz), (tx, ty, tz) = frame_of(n[0], n[1], n[2])
    return (
        dot(d[0], d[1], d[2], sx, sy, sz),
        dot(d[0], d[1], d[2], tx, ty, tz),
        dot(d[0], d[1], d[2], n[0], n[1], n[2]),
    )


@helper
def logarithm(x: float) -> float:
    """Return the natural logarithm of a positive number."""
    high, low = log_pair(x)
    return high + low
