"""Gradient noise: Ken Perlin, Improving noise, SIGGRAPH 2002, with a hash in place of his table of permutations."""

from __future__ import annotations

import numpy as np

from ..compiler.jit import helper, inline

_FAR = 2.0**40
"""From there on floats have too few places left for noise, and it is 0."""


@inline
def hashed(x: int, y: int, z: int) -> np.uint64:
    """64 bits for a point of the lattice: SplitMix64's output function, thrice (Steele, Lea and Flood 2014)."""
    h = np.uint64(0)
    for k in range(3):
        part = x if k == 0 else (y if k == 1 else z)
        h = (h ^ np.uint64(part)) + np.uint64(0x9E3779B97F4A7C15)
        h = (h ^ (h >> np.uint64(30))) * np.uint64(0xBF58476D1CE4E5B9)
        h = (h ^ (h >> np.uint64(27))) * np.uint64(0x94D049BB133111EB)
        h ^= h >> np.uint64(31)
    return h


@inline
def fade(t: float) -> float:
    """6t⁵ - 15t⁴ + 10t³"""
    return t * t * t * (t * (t * 6.0 - 15.0) + 10.0)


@inline
def slope(bits: np.uint64, x: float, y: float, z: float) -> float:
    """The product of a vector with one of twelve directions to the middles of a cube's edges, four of them twice."""
    h = bits & np.uint64(15)
    u = x if h < np.uint64(8) else y
    if h < np.uint64(4):
        v = y
    else:
        v = x if (h == np.uint64(12)) | (h == np.uint64(14)) else z
    return (u if h & np.uint64(1) == np.uint64(0) else -u) + (v if h & np.uint64(2) == np.uint64(0) else -v)


@helper
def noise(x: float, y: float, z: float) -> float:
    """Between about -1 and 1; 0 where x, y and z are whole numbers."""
    if not max(abs(x), max(abs(y), abs(z))) < _FAR:
        return 0.0
    fx, fy, fz = np.floor(x), np.floor(y), np.floor(z)
    ix, iy, iz = int(fx), int(fy), int(fz)
    x, y, z = x - fx, y - fy, z - fz
    u, v, w = fade(x), fade(y), fade(z)
    total = 0.0
    for corner in range(8):
        i, j, k = corner & 1, (corner >> 1) & 1, corner >> 2
        weight = (u if i == 1 else 1.0 - u) * (v if j == 1 else 1.0 - v) * (w if k == 1 else 1.0 - w)
        total += weight * slope(hashed(ix + i, iy + j, iz + k), x - i, y - j, z - k)
    return total


@helper
def turbulence(x: float, y: float, z: float, octaves: int) -> float:
    """Octaves of noise, each half as large and as strong as the one before, over the sum of their strengths."""
    total, weight, weights = 0.0, 1.0, 0.0
    for _ in range(octaves):
        total += weight * noise(x, y, z)
        weights += weight
        x, y, z, weight = 2.0 * x + 17.0, 2.0 * y + 31.0, 2.0 * z + 47.0, 0.5 * weight
    return total / weights
