"""Polynomials."""

from __future__ import annotations

from ...compiler.jit import fma, inline


@inline
def polynomial(x: float, coefficients: tuple[float, ...]) -> float:
    """Coefficients, an even number, the highest power first; odd and even powers by Horner's rule side by side."""
    square, odd, even = x * x, 0.0, 0.0
    for k in range(0, len(coefficients), 2):
        odd = fma(odd, square, coefficients[k])
        even = fma(even, square, coefficients[k + 1])
    return fma(odd, x, even)
