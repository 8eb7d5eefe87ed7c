"""Square roots, sines and cosines of `wide` numbers.

Roots come limb by limb with what is left of the square, so they are certain; sines by their series.
"""

from __future__ import annotations

import numpy as np

from ...compiler.jit import helper
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
def square_root(w: Longs, d: int, a: int, t: Longs) -> bool:
    """d = sqrt(a); False unless a is certainly positive, or zero.

    Limb by limb, as one takes roots by hand: what is left of a, in t[2], less (2 B root + q) q for the next limb q of
    the root, in t[1]; both have their highest limbs first. A root with nothing left is that number itself.
    """
    if w[a, COUNT] == 0 and w[a, OFF] == EXACT:
        copy(w, d, a)
        return True
    count, given = w[a, COUNT], w[a, OFF]
    if count == 0 or w[a, SIGN] < 0 or (given != EXACT and given > magnitude(w, a) - 3):
        return False
    for k in range(2 * LIMBS + 2):
        t[2, k] = 0
    top = w[a, EXPONENT] + count
    pad = top & 1
    for k in range(count):
        t[2, pad + k] = w[a, count - 1 - k]
    value = (t[2, 0] << BITS) + t[2, 1]
    first = int(np.sqrt(float(value)))
    while first * first > value:
        first -= 1
    while (first + 1) * (first + 1) <= value:
        first += 1
    t[1, 0], t[2, 0], t[2, 1] = first, (value - first * first) >> BITS, (value - first * first) & LIMB
    known, rest = 1, value - first * first
    while known < LIMBS and (rest != 0 or 2 * known < pad + count):
        rest = _next_of_root(t, known)
        known += 1
    exponent = (top + pad) // 2 - known
    for k in range(known):
        t[0, k] = t[1, known - 1 - k]
    put(w, d, t, known, exponent, 1, EXACT if rest == 0 and 2 * known >= pad + count else BITS * exponent)
    if given != EXACT:
        w[d, OFF] = wider(w[d, OFF], given - magnitude(w, d) + 2)
    return True


@helper
def _next_of_root(t: Longs, j: int) -> int:
    """Limb j of a root, of which there are j; not zero if anything is left then."""
    base = float(1 << BITS)
    left, root = 0.0, 0.0
    for k in range(j - 1, j + 5):  # of the last limb of the root twice what there is may be left
        left = left * base + float(t[2, k])
    for k in range(3):
        root = root * base + (float(t[1, k]) if k < j else 0.0)
    # The quotient is off by less than 2^-20, as its parts are by less than 2^-50 of themselves: q is right, or one too
    # large. Where the root has one limb, which may be small, the square of q counts as well
    if j == 1:
        left, root = left / (base * base), root / base
        quotient = left / (root + np.sqrt(root * root + left))
    else:
        quotient = left / (2.0 * base * root)
    q = min(int(quotient + 2.0**-16), LIMB)
    carry = -q * q
    for k in range(j - 1, -1, -1):
        value = t[2, j + 2 + k] + carry
        t[2, j + 2 + k], carry = value & LIMB, (value >> BITS) - 2 * q * t[1, k]
    for k in range(j + 1, j - 2, -1):
        value = t[2, k] + carry
        t[2, k], carry = value & LIMB, value >> BITS
    while carry < 0:
        q -= 1
        more = 2 * q + 1
        for k in range(j - 1, -1, -1):
            value = t[2, j + 2 + k] + more
            t[2, j + 2 + k], more = value & LIMB, (value >> BITS) + 2 * t[1, k]
        for k in range(j + 1, j - 2, -1):
            value = t[2, k] + more
            t[2, k], more = value & LIMB, value >> BITS
        carry += more
    t[1, j] = q
    rest = 0
    for k in range(j - 1, 2 * j + 2):
        rest |= t[2, k]
    return rest


@helper
def sine_cosine(w: Longs, d: int, angle: float, constants: Longs, free: int, t: Longs) -> bool:
    """Numbers d and d + 1: sine and cosine of an angle in degrees; False for angles beyond 2^40.

    The angle less quarters of a turn, in radians over 64; the sine's series; cosine² = 1 - sine²; six times doubled.
    `constants`: pi / 180, then the series' coefficients, the last one first. Uses five numbers from `free`.
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
    if not square_root(w, c, square, t):
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
