"""Numbers in two floats (about 106 bits), for the few rays whose fast formulas cancel.

A number is a pair (high, low) with high = fl(high + low). Joldes, Muller, Popescu: Tight and
rigorous error bounds for basic building blocks of double-word arithmetic, ACM TOMS 44, 2017.
"""

from __future__ import annotations

from typing import TypeAlias

from ...compiler.jit import fma, inline
from .errorfree import two_sum

Pair: TypeAlias = tuple[float, float]


@inline
def quick_sum(a: float, b: float) -> Pair:
    """a + b exactly, where |a| >= |b| or a is zero."""
    s = a + b
    return s, b - (s - a)


@inline
def pair_sum(a: Pair, b: Pair) -> Pair:
    """a + b, relative error 3 u² (algorithm 6)."""
    s, e = two_sum(a[0], b[0])
    t, f = two_sum(a[1], b[1])
    s, e = quick_sum(s, e + t)
    return quick_sum(s, e + f)


@inline
def pair_product(a: Pair, b: Pair) -> Pair:
    """a b, relative error 5 u² (algorithm 12)."""
    p = a[0] * b[0]
    e = fma(a[0], b[0], -p)
    e += fma(a[0], b[1], a[1] * b[0])
    return quick_sum(p, e)


@inline
def pair_scaled(a: Pair, b: float) -> Pair:
    """a b for one float b."""
    p = a[0] * b
    return quick_sum(p, fma(a[1], b, fma(a[0], b, -p)))


@inline
def negative(a: Pair) -> Pair:
    return -a[0], -a[1]


@inline
def pair_dot(x: float, y: float, z: float, a: Pair, b: Pair, c: Pair) -> Pair:
    """x a + y b + z c"""
    return pair_sum(pair_sum(pair_scaled(a, x), pair_scaled(b, y)), pair_scaled(c, z))
