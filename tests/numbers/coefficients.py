"""The polynomials of the elementary functions: through the values at Chebyshev's nodes, whose error is near the least."""

from collections.abc import Callable
from typing import Any

import mpmath

Function = Callable[[Any], Any]


def _through_nodes(context: Any, function: Function, low: Any, high: Any, count: int) -> list[Any]:
    """The coefficients, the constant one first, of the polynomial that meets a function at `count` nodes."""
    nodes = [
        (low + high) / 2 + (high - low) / 2 * context.cos(context.pi * (2 * k + 1) / (2 * count)) for k in range(count)
    ]
    powers = context.matrix([[node**j for j in range(count)] for node in nodes])
    return list(context.lu_solve(powers, context.matrix([function(node) for node in nodes])))


def polynomial(function: Function, low: str, high: str, count: int) -> tuple[float, ...]:
    """Coefficients as floats, the highest first, as Horner's rule takes them."""
    context = mpmath.mp.clone()
    context.prec = 400
    found = _through_nodes(context, lambda x: function(context, x), context.mpf(low), context.mpf(high), count)
    return tuple(float(c) for c in reversed(found))


def of_exp(context: Any, r: Any) -> Any:
    """(e^r - 1 - r - r²/2) / r³"""
    return (context.exp(r) - 1 - r - r * r / 2) / r**3


def of_log(context: Any, z: Any) -> Any:
    """(atanh s - s - s³/3 - s⁵/5) / s⁷ with z = s²"""
    s = context.sqrt(z)
    return (context.atanh(s) - s - s**3 / 3 - s**5 / 5) / s**7


def of_asin(context: Any, z: Any) -> Any:
    """(asin s - s - s³/6) / s⁵ with z = s²"""
    s = context.sqrt(z)
    return (context.asin(s) - s - s**3 / 6) / s**5


def of_atan(context: Any, z: Any) -> Any:
    """(atan s - s) / s³ with z = s²"""
    s = context.sqrt(z)
    return (context.atan(s) - s) / s**3


def doubled(constant: Function) -> tuple[float, float]:
    """A constant as a sum of two floats."""
    context = mpmath.mp.clone()
    context.prec = 400
    value = constant(context)
    high = float(value)
    return high, float(value - high)


POLYNOMIALS: dict[str, Callable[[], tuple[float, ...]]] = {
    "EXP": lambda: polynomial(of_exp, "-0.34658", "0.34658", 10),
    "LOG": lambda: polynomial(of_log, "0", "0.02944", 8),
    "ASIN": lambda: polynomial(of_asin, "0", "0.25", 14),
    "ATAN": lambda: polynomial(of_atan, "0", "0.0625", 10),
}
