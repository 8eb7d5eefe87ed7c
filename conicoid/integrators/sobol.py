"""Random numbers of light transport: Owen-scrambled Sobol' points, of any pixel, sample and dimension at once.

Dimensions come in pairs: 2k and 2k + 1 are the first two of Sobol's sequence, which share their net in every
power of two of samples. Each pair, pixel and seed has a shuffle of the order and two scrambles of its own, by a
hash in place of Owen's random trees: Burley, Practical Hash-based Owen Scrambling, JCGT 9(4), 2020, with the better
hash of Vegdahl, Building a better LK hash, 2021. As neither the number of samples nor any state plays a part, a picture
can be continued, and is the same for any order of work.
"""

from __future__ import annotations

import numpy as np

from ..compiler.jit import inline

_WORD = np.uint64(0xFFFFFFFF)
_HALF = np.uint64(32)
_PER_WORD = 2.0**-32
_WEYL = np.uint64(0x9E3779B97F4A7C15)  # 2⁶⁴ / golden ratio


@inline
def mixed(value: np.uint64) -> np.uint64:
    """A 64-bit hash: the output function of SplitMix64 (Steele, Lea and Flood 2014)."""
    z = value + _WEYL
    z = (z ^ (z >> np.uint64(30))) * np.uint64(0xBF58476D1CE4E5B9)
    z = (z ^ (z >> np.uint64(27))) * np.uint64(0x94D049BB133111EB)
    return z ^ (z >> np.uint64(31))


@inline
def reversed_word(value: np.uint64) -> np.uint64:
    """The 32 lower bits of a value in reverse order, by swapping halves of halves."""
    v = ((value >> np.uint64(16)) | (value << np.uint64(16))) & _WORD
    v = ((v & np.uint64(0xFF00FF00)) >> np.uint64(8)) | ((v & np.uint64(0x00FF00FF)) << np.uint64(8))
    v = ((v & np.uint64(0xF0F0F0F0)) >> np.uint64(4)) | ((v & np.uint64(0x0F0F0F0F)) << np.uint64(4))
    v = ((v & np.uint64(0xCCCCCCCC)) >> np.uint64(2)) | ((v & np.uint64(0x33333333)) << np.uint64(2))
    return ((v & np.uint64(0xAAAAAAAA)) >> np.uint64(1)) | ((v & np.uint64(0x55555555)) << np.uint64(1))


@inline
def second_word(index: np.uint64) -> np.uint64:
    """The second Sobol' coordinate of a point, its 32 bits in reverse order.

    Its generator matrix is Pascal's triangle modulo 2, the fifth Kronecker power of ((1, 1), (0, 1)).
    """
    v = index
    v ^= (v & np.uint64(0xAAAAAAAA)) >> np.uint64(1)
    v ^= (v & np.uint64(0xCCCCCCCC)) >> np.uint64(2)
    v ^= (v & np.uint64(0xF0F0F0F0)) >> np.uint64(4)
    v ^= (v & np.uint64(0xFF00FF00)) >> np.uint64(8)
    return v ^ ((v & np.uint64(0xFFFF0000)) >> np.uint64(16))


@inline
def _flipped(word: np.uint64, seed: np.uint64) -> np.uint64:
    """A word, each of its bits flipped by a hash of those below it: Owen's tree, of bits in reverse order."""
    x = word
    x ^= (x * np.uint64(0x3D20ADEA)) & _WORD
    x = (x + seed) & _WORD
    x = (x * ((seed >> np.uint64(16)) | np.uint64(1))) & _WORD
    x ^= (x * np.uint64(0x05526C56)) & _WORD
    return x ^ ((x * np.uint64(0x53A22864)) & _WORD)


@inline
def sobol_keys(seed: int, pixel: int, pair: int) -> tuple[np.uint64, np.uint64]:
    """What shuffles the order of a pair of dimensions of a pixel, and what scrambles both: the same for all samples."""
    order = mixed(mixed(mixed(np.uint64(seed)) ^ np.uint64(pixel)) ^ np.uint64(pair))
    return order, mixed(order)


@inline
def pair_by_keys(order: np.uint64, scramble: np.uint64, sample: int) -> tuple[float, float]:
    """`sobol_pair` of a sample, by its `sobol_keys`."""
    index = reversed_word(_flipped(reversed_word(np.uint64(sample)), order & _WORD))
    u = reversed_word(_flipped(index, scramble & _WORD))
    v = reversed_word(_flipped(second_word(index), scramble >> _HALF))
    return float(u) * _PER_WORD, float(v) * _PER_WORD


@inline
def sobol_pair(seed: int, pixel: int, sample: int, pair: int) -> tuple[float, float]:
    """Dimensions 2 pair and 2 pair + 1 of a sample of a pixel, each in [0, 1)."""
    order, scramble = sobol_keys(seed, pixel, pair)
    return pair_by_keys(order, scramble, sample)


@inline
def sobol(seed: int, pixel: int, sample: int, dimension: int) -> float:
    """One dimension of a sample of a pixel, in [0, 1)."""
    u, v = sobol_pair(seed, pixel, sample, dimension >> 1)
    return u if dimension & 1 == 0 else v
