"""Square roots, sines and cosines of the numbers of `bigfloat_kernel`.

Roots are computed limb by limb with the remainder of the square, so they are certain; sines by their series.
"""

from __future__ import annotations

import numpy as np

from ..._jit.decorators import helper
from ...kernels.tables import Longs
from .bigfloat_kernel import (
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
    set_float,
    set_limbs,
    sum_error,
)

TERMS = 14
"""Terms of the series of a sine."""
STEP, MULTIPLES = 45.0 / 64.0, 64
"""Degrees; sines and cosines of so many multiples, up to 45 degrees, are tabulated.

A binary number: multiples are exact.
"""
CONSTANTS = 1 + TERMS + 2 * (MULTIPLES + 1)
"""Rows of the table of `sine_cosine`."""


@helper
def square_root(w: Longs, d: int, a: int, t: Longs) -> bool:
    """d = sqrt(a); return False unless a is certainly positive, or zero.

    Limb by limb, as in long-hand square roots: the remainder of a, in t[2], is reduced by (2 B root + q) q for the next
    limb q of the root, in t[1]; both have their highest limbs first. A root without remainder is exact.
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
    set_limbs(w, d, t, known, exponent, 1, EXACT if rest == 0 and 2 * known >= pad + count else BITS * exponent)
    if given != EXACT:
        w[d, OFF] = sum_error(w[d, OFF], given - magnitude(w, d) + 2)
    return True


@helper
def _next_of_root(t: Longs, j: int) -> int:
    """Compute limb j of a root with j limbs so far; return 0 if no remainder is left."""
    base = float(1 << BITS)
    left, root = 0.0, 0.0
    for k in range(j - 1, j + 5):  # up to twice the last limb of the root may be left
        left = left * base + float(t[2, k])
    for k in range(3):
        root = root * base + (float(t[1, k]) if k < j else 0.0)
    # The quotient is off by less than 2^-20, because its parts are by less than 2^-50 of themselves: q is right, or one
    # too large. Where the root has one limb, which may be small, the square of q counts as well.
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
def _without_noise(w: Longs, a: int) -> None:
    """Drop the limbs of a below its error, which at most doubles: later products then cost less."""
    low = min(w[a, COUNT], (w[a, OFF] - w[a, EXPONENT] * BITS) // BITS) if w[a, OFF] != EXACT else 0
    if low <= 0:
        return
    for k in range(low, w[a, COUNT]):
        w[a, k - low] = w[a, k]
    w[a, COUNT] -= low
    w[a, EXPONENT] = w[a, EXPONENT] + low if w[a, COUNT] > 0 else 0
    w[a, OFF] += 1


@helper
def _take(w: Longs, d: int, constants: Longs, row: int) -> None:
    """d = a constant"""
    for k in range(WIDTH):
        w[d, k] = constants[row, k]


@helper
def sine_cosine(w: Longs, d: int, angle: float, constants: Longs, free: int, t: Longs) -> bool:
    """Set numbers d and d + 1 to sine and cosine of an angle in degrees; return False for angles beyond 2^40.

    The angle is reduced by quarters of a turn, and by the nearest multiple of STEP, whose sine and cosine `constants`
    holds. For the rest, below 2^-7 in radians, the sine comes from its series, whose TERMS leave out less than 2^-300
    of it (2^-7.35 to the 28th, over 29!), and the cosine from sqrt(1 - sine²). Then the angles are added. `constants`:
    pi / 180, the series' coefficients from last to first, then the sines and cosines of multiples of STEP up to 45.
    Uses seven numbers from `free` on.
    """
    if not abs(angle) < 2.0**40 or len(constants) < CONSTANTS:
        return False
    x, square, s, c, one, its_s, its_c = free, free + 1, free + 2, free + 3, free + 4, free + 5, free + 6
    quarters = np.floor(angle / 90.0 + 0.5)
    rest = angle - 90.0 * quarters
    count = int(np.floor(abs(rest) / STEP + 0.5))
    count = min(max(count, 0), MULTIPLES)
    taken = -STEP * float(count) if rest > 0.0 else STEP * float(count)
    set_float(w, x, angle, 0)
    set_float(w, s, -90.0 * quarters, 0)
    add(w, x, x, s, 1, t)
    set_float(w, s, taken, 0)
    add(w, x, x, s, 1, t)
    # To radians.
    _take(w, s, constants, 0)
    multiply(w, x, x, s, t)
    # Horner's scheme for the series in the square.
    set_float(w, one, 1.0, 0)
    multiply(w, square, x, x, t)
    _take(w, s, constants, 1)
    for term in range(2, TERMS + 1):
        multiply(w, s, s, square, t)
        _without_noise(w, s)
        _take(w, c, constants, term)
        add(w, s, s, c, 1, t)
    w[s, OFF] = sum_error(w[s, OFF], -300)  # truncation of the series
    multiply(w, s, s, x, t)
    multiply(w, square, s, s, t)
    add(w, square, one, square, -1, t)
    if not square_root(w, c, square, t):
        return False
    # Add the angle of the table: sin(a + b) and cos(a + b).
    row = TERMS + 1 + 2 * count
    _take(w, its_s, constants, row)
    _take(w, its_c, constants, row + 1)
    if rest < 0.0:
        w[its_s, SIGN] = -w[its_s, SIGN]
    multiply(w, x, s, its_c, t)
    multiply(w, square, c, its_s, t)
    add(w, one, x, square, 1, t)
    multiply(w, x, c, its_c, t)
    multiply(w, square, s, its_s, t)
    add(w, c, x, square, -1, t)
    # Turn by quarters: exchange and negate.
    turn = int(quarters) & 3
    copy(w, d, one if (turn & 1) == 0 else c)
    copy(w, d + 1, c if (turn & 1) == 0 else one)
    if turn >= 2:
        w[d, SIGN] = -w[d, SIGN]
    if turn == 1 or turn == 2:
        w[d + 1, SIGN] = -w[d + 1, SIGN]
    return True
