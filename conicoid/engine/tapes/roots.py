"""Square roots, sines and cosines of `wide` numbers.

Roots are by Newton's method, and certified by what is left of the square; sines by their series.
"""

from __future__ import annotations

import numpy as np

from ...compiler.jit import helper
from ..numbers.bits import power_of_two
from ..tables import Longs
from .wide import (
    BITS,
    COUNT,
    EXACT,
    EXPONENT,
    LIMB,
    LIMBS,
    OFF,
    SIGN,
    WIDTH,
    add,
    copy,
    magnitude,
    multiply,
    put,
    put_float,
    wider,
)  # fmt: skip


@helper
def square_root(w: Longs, d: int, a: int, free: int, t: Longs) -> bool:
    """d = sqrt(a); False unless a is certainly positive, or zero. Uses six numbers from `free` on."""
    if w[a, COUNT] == 0 and w[a, OFF] == EXACT:
        copy(w, d, a)
        return True
    count, given = w[a, COUNT], w[a, OFF]
    if count == 0 or w[a, SIGN] < 0 or (given != EXACT and given > magnitude(w, a) - 3):
        return False
    of, y, x, z, half, root = free, free + 1, free + 2, free + 3, free + 4, free + 5
    copy(w, of, a)
    w[of, OFF] = EXACT
    top = 0.0
    for k in range(min(count, 3)):
        top = top * power_of_two(BITS) + float(w[a, count - 1 - k])
    up = w[a, EXPONENT] + count - min(count, 3)  # a is near top 2^(28 up)
    put_float(w, y, 1.0 / np.sqrt(top), -(BITS // 2) * up)
    put_float(w, half, 0.5, 0)
    for _ in range(3):  # y += y (1 - a y²) / 2
        multiply(w, x, y, y, t)
        w[x, OFF] = EXACT
        multiply(w, x, x, of, t)
        w[x, OFF] = EXACT
        put_float(w, z, 1.0, 0)
        add(w, x, z, x, -1, t)
        multiply(w, x, x, half, t)
        multiply(w, x, x, y, t)
        w[x, OFF] = EXACT
        add(w, y, y, x, 1, t)
        w[y, OFF] = EXACT
    multiply(w, root, of, y, t)
    w[root, OFF] = EXACT
    multiply(w, x, root, root, t)
    add(w, x, of, x, -1, t)
    multiply(w, x, x, half, t)
    multiply(w, x, x, y, t)
    add(w, root, root, x, 1, t)
    w[root, OFF] = EXACT
    # A root that is a number of half the length is that number
    _shortened(w, z, root, LIMBS // 2 + 1, t)
    multiply(w, x, z, z, t)
    add(w, x, of, x, -1, t)
    if w[x, COUNT] == 0 and w[x, OFF] == EXACT:
        copy(w, d, z)
    else:
        multiply(w, x, root, root, t)
        add(w, x, of, x, -1, t)
        left = max(magnitude(w, x), w[x, OFF]) + 1
        copy(w, d, root)
        w[d, OFF] = left - magnitude(w, root) + 1
    if given != EXACT:
        w[d, OFF] = wider(w[d, OFF], given - magnitude(w, d) + 2)
    return True


@helper
def _shortened(w: Longs, d: int, a: int, limbs: int, t: Longs) -> None:
    """d = a rounded to so many limbs, as if that were exact."""
    less = w[a, COUNT] - limbs
    if less <= 0:
        copy(w, d, a)
        return
    carry = w[a, less - 1] >> (BITS - 1)
    for k in range(limbs):
        value = w[a, less + k] + carry
        t[0, k], carry = value & LIMB, value >> BITS
    t[0, limbs] = carry
    put(w, d, t, limbs + 1, w[a, EXPONENT] + less, w[a, SIGN], EXACT)


@helper
def sine_cosine(w: Longs, d: int, angle: float, constants: Longs, free: int, t: Longs) -> bool:
    """Numbers d and d + 1: sine and cosine of an angle in degrees; False for angles beyond 2^40.

    The angle less quarters of a turn, in radians over 64; the sine's series; cosine² = 1 - sine²; six times doubled.
    `constants`: pi / 180, then the series' coefficients, the last one first. Uses eleven numbers from `free`.
    """
    if not abs(angle) < 2.0**40:
        return False
    quarters = int(np.floor(angle / 90.0 + 0.5))
    x, square, s, c, one = free, free + 1, free + 2, free + 3, free + 4
    put_float(w, x, angle, 0)
    put_float(w, s, -90.0 * float(quarters), 0)
    add(w, x, x, s, 1, t)
    for k in range(WIDTH):
        w[s, k] = constants[0, k]
    multiply(w, x, x, s, t)
    put_float(w, one, 1.0 / 64.0, 0)
    multiply(w, x, x, one, t)
    put_float(w, one, 1.0, 0)
    multiply(w, square, x, x, t)
    for k in range(WIDTH):
        w[s, k] = constants[1, k]
    for term in range(2, len(constants)):
        multiply(w, s, s, square, t)
        for k in range(WIDTH):
            w[c, k] = constants[term, k]
        add(w, s, s, c, 1, t)
    w[s, OFF] = wider(w[s, OFF], -400)  # what the series leaves out
    multiply(w, s, s, x, t)
    multiply(w, square, s, s, t)
    add(w, square, one, square, -1, t)
    if not square_root(w, c, square, free + 5, t):
        return False
    for _ in range(6):
        multiply(w, square, s, s, t)
        multiply(w, s, s, c, t)
        add(w, s, s, s, 1, t)
        add(w, c, square, square, 1, t)
        add(w, c, one, c, -1, t)
    turn = quarters & 3
    copy(w, d, s if (turn & 1) == 0 else c)
    copy(w, d + 1, c if (turn & 1) == 0 else s)
    if turn >= 2:
        w[d, SIGN] = -w[d, SIGN]
    if turn == 1 or turn == 2:
        w[d + 1, SIGN] = -w[d + 1, SIGN]
    return True
