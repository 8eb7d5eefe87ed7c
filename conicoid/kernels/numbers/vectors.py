"""Vectors as three floats, and quotients of several numbers by one divisor."""

from __future__ import annotations

import math

from ..._jit.decorators import fma, inline

Vector = tuple[float, float, float]


@inline
def dot(ax: float, ay: float, az: float, bx: float, by: float, bz: float) -> float:
    """Return a·b."""
    return fma(ax, bx, fma(ay, by, az * bz))


@inline
def normalize(x: float, y: float, z: float) -> tuple[float, float, float]:
    """Return v / |v|, scaled first so that no square overflows or underflows; zero stays zero."""
    largest = max(abs(x), max(abs(y), abs(z)))
    scale = 1.0 / largest if largest > 0.0 else 0.0
    x, y, z = x * scale, y * scale, z * scale
    length = math.sqrt(dot(x, y, z, x, y, z))
    length = length if length > 0.0 else 1.0
    return x / length, y / length, z / length


# Quotients with a shared divisor, and unit vectors, with fewer divisions: for loops over lanes
#
# A division takes as long as some thirty multiplications of as many lanes. One reciprocal, rounded once, gives every
# quotient by it, and two corrections make these the rounded quotients: Markstein, Computation of elementary functions
# on the IBM RISC System/6000 processor, IBM J. Res. Dev. 34(1), 1990, theorem 8.1.


@inline
def quotient(a: float, b: float, inverse: float) -> float:
    """Return a / b to the bit, for finite b >= 2⁻⁹⁰⁰ and inverse = 1 / b.

    The first quotient may be off by 1.5 units of the last place, the second is within one unit, so that the third is
    a / b. The remainder at each step must be exact: |a| and |a / b| are 0 or from 2⁻⁹⁰⁰ to 2⁹⁰⁰. Smaller ones may lose
    their last bits.
    """
    first = a * inverse
    # copysign keeps the sign of a zero, which the corrections may lose
    second = fma(fma(-first, b, a), inverse, first)
    return math.copysign(fma(fma(-second, b, a), inverse, second), a)


@inline
def unit_vector(x: float, y: float, z: float) -> tuple[float, float, float]:
    """`normalize` with half as many divisions, to the bit except for components below 2⁻⁹⁰⁰ of the vector."""
    largest = max(abs(x), max(abs(y), abs(z)))
    scale = 1.0 / largest if largest > 0.0 else 0.0
    x, y, z = x * scale, y * scale, z * scale
    length = math.sqrt(dot(x, y, z, x, y, z))
    length = length if length > 0.0 else 1.0
    inverse = 1.0 / length
    return quotient(x, length, inverse), quotient(y, length, inverse), quotient(z, length, inverse)
