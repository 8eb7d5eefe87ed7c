"""Arithmetic that keeps the rounding error: differences, products and sums in two floats.

Sources: Knuth's TwoSum; Kahan's difference of products (error at most 1.5 ulp: Jeannerod, Louvet,
Muller, Math. Comp. 82, 2013); Dot2 (Ogita, Rump, Oishi, SIAM J. Sci. Comput. 26, 2005).
"""

from __future__ import annotations

from ...compiler.jit import fma, helper, inline


@inline
def two_sum(a: float, b: float) -> tuple[float, float]:
    """(s, e) with s = fl(a + b) and s + e = a + b exactly."""
    s = a + b
    v = s - a
    return s, (a - (s - v)) + (b - v)


@inline
def two_difference(a: float, b: float) -> tuple[float, float]:
    """(d, e) with d = fl(a - b) and d + e = a - b exactly."""
    d = a - b
    v = d - a
    return d, (a - (d - v)) - (b + v)


@inline
def difference_of_products(a: float, b: float, c: float, d: float) -> float:
    """a b - c d, to 1.5 ulp of the result."""
    w = c * d
    return fma(a, b, -w) + fma(-c, d, w)


@helper
def accurate_dot(ax: float, ay: float, az: float, bx: float, by: float, bz: float, more: float, tiny: float) -> float:
    """a·b + more + tiny as if in twice the precision, then rounded; tiny is small against the rest."""
    p = ax * bx
    q = ay * by
    r = az * bz
    s, e = two_sum(p, q)
    s, f = two_sum(s, r)
    s, g = two_sum(s, more)
    lost = (fma(ax, bx, -p) + fma(ay, by, -q)) + fma(az, bz, -r)
    return s + (((e + f) + g) + (lost + tiny))
