"""Numbers in two floats (about 106 bits), for the few rays whose fast formulas cancel.

A number is a pair (high, low) with high = fl(high + low). Joldes, Muller, Popescu: Tight and
rigorous error bounds for basic building blocks of double-word arithmetic, ACM TOMS 44, 2017.
"""

from __future__ import annotations

from typing import NamedTuple

from ...compiler.jit import fma, inline
from .bits import power_of_two, scaled_by_power
from .errorfree import two_sum


class Pair(NamedTuple):
    """high + low, where |low| is at most half a unit of high's last place."""

    high: float
    low: float


@inline
def quick_sum(a: float, b: float) -> Pair:
    """a + b exactly, where |a| >= |b| or a is zero."""
    s = a + b
    return Pair(s, b - (s - a))


@inline
def pair_sum(a: Pair, b: Pair) -> Pair:
    """a + b, relative error 3 u² (algorithm 6)."""
    s, e = two_sum(a.high, b.high)
    t, f = two_sum(a.low, b.low)
    s, e = quick_sum(s, e + t)
    return quick_sum(s, e + f)


@inline
def pair_product(a: Pair, b: Pair) -> Pair:
    """a b, relative error 5 u² (algorithm 12)."""
    p = a.high * b.high
    e = fma(a.high, b.high, -p)
    e += fma(a.high, b.low, a.low * b.high)
    return quick_sum(p, e)


@inline
def pair_scaled(a: Pair, b: float) -> Pair:
    """a b for one float b."""
    p = a.high * b
    return quick_sum(p, fma(a.low, b, fma(a.high, b, -p)))


@inline
def negative(a: Pair) -> Pair:
    """-a, exactly."""
    return Pair(-a.high, -a.low)


@inline
def pair_dot(x: float, y: float, z: float, a: Pair, b: Pair, c: Pair) -> Pair:
    """x a + y b + z c"""
    return pair_sum(pair_sum(pair_scaled(a, x), pair_scaled(b, y)), pair_scaled(c, z))


@inline
def rounded(a: Pair, k: int) -> float:
    """(high + low) 2^k, rounded once, also to a subnormal number; high from 0.5 to 4, k from -1080 to 1024."""
    if k > 0 or a.high >= power_of_two(-1022 - k):
        return scaled_by_power(a.high, k)
    lifted = power_of_two(-1022 - k)  # numbers from here to its double have the last place that is left
    s = lifted + a.high
    s += (a.high - (s - lifted)) + a.low
    return (s - lifted) * power_of_two(k + 1000) * 2.0**-1000
