"""Vectors as three floats."""

from __future__ import annotations

import math

from ...compiler.jit import fma, inline

Vector = tuple[float, float, float]


@inline
def dot(ax: float, ay: float, az: float, bx: float, by: float, bz: float) -> float:
    """a·b"""
    return fma(ax, bx, fma(ay, by, az * bz))


@inline
def normalized(x: float, y: float, z: float) -> tuple[float, float, float]:
    """v / |v|, scaled first so that no square overflows or underflows; zero stays zero."""
    largest = max(abs(x), max(abs(y), abs(z)))
    scale = 1.0 / largest if largest > 0.0 else 0.0
    x, y, z = x * scale, y * scale, z * scale
    length = math.sqrt(dot(x, y, z, x, y, z))
    length = length if length > 0.0 else 1.0
    return x / length, y / length, z / length
