"""Numbers of 253 bits and more with error bounds: those of `numerics.bigfloat`, made small and fast for kernels.

A number is a row of int64: LIMBS limbs of 28 bits, the lowest first, then their count, the exponent of the first (of
2^28), the sign, and the error: the true number lies within 2^OFF; EXACT says that it is the number itself. Sums and
products of floats are exact while they have room; truncation counts as an error, as in `numerics.bigfloat`. Limbs of 28
bits leave room for the sums of ten products in an int64, so that carries can wait.

Long division and the rest follow Knuth (The Art of Computer Programming, 4.3.1).
"""

from __future__ import annotations

from ..._jit.decorators import float_bits, helper, inline
from ...kernels.numbers.double_double import exponent_of, scale_by_power
from ...kernels.tables import Longs

LIMBS, BITS = 10, 28
COUNT, EXPONENT, SIGN, OFF = range(LIMBS, LIMBS + 4)
WIDTH = LIMBS + 4
EXACT = -(1 << 40)
LIMB = (1 << BITS) - 1
_NOTHING = -(1 << 30)
"""The magnitude of zero."""
SCRATCH = 4 * LIMBS
"""Columns of the three rows of scratch memory."""
_QUOTIENT = LIMBS + 2


@inline
def sum_error(off: int, more: int) -> int:
    """Return the error exponent of a sum of terms with these error exponents."""
    if off == EXACT or more == EXACT:
        return max(off, more)
    return max(off, more) + 1


@inline
def magnitude(w: Longs, a: int) -> int:
    """Return the least m with |value| < 2^m."""
    count = w[a, COUNT]
    if count == 0:
        return _NOTHING
    return BITS * (w[a, EXPONENT] + count - 1) + exponent_of(float(w[a, count - 1])) + 1


@inline
def is_sure(w: Longs, a: int) -> bool:
    """Return whether the sign is known: the number is certainly not zero, or certainly zero."""
    return w[a, OFF] == EXACT or magnitude(w, a) - 1 > w[a, OFF]


@helper
def copy(w: Longs, d: int, a: int) -> None:
    """d = a"""
    for k in range(WIDTH):
        w[d, k] = w[a, k]


@helper
def set_limbs(w: Longs, d: int, t: Longs, count: int, exponent: int, sign: int, off: int) -> None:
    """Set number d from limbs in scratch, without zeros at both ends; what does not fit is cut off."""
    while count > 0 and t[0, count - 1] == 0:
        count -= 1
    low = max(0, count - LIMBS)
    for k in range(low):
        if t[0, k] != 0:
            off = sum_error(off, BITS * (exponent + low))
            break
    while low < count and t[0, low] == 0:
        low += 1
    for k in range(low, count):
        w[d, k - low] = t[0, k]
    w[d, COUNT] = count - low
    w[d, EXPONENT] = exponent + low if count > low else 0
    w[d, SIGN] = sign
    w[d, OFF] = off


@helper
def set_float(w: Longs, d: int, x: float, shift: int) -> None:
    """d = x 2^shift; x is finite."""
    w[d, COUNT], w[d, EXPONENT], w[d, SIGN], w[d, OFF] = 0, 0, 1, EXACT
    if x == 0.0:
        return
    if x < 0.0:
        w[d, SIGN], x = -1, -x
    power = exponent_of(x)
    whole = float_bits(scale_by_power(x, -power)) & ((1 << 52) - 1) | (1 << 52)
    lowest = power - 52 + shift
    exponent = lowest // BITS
    up = lowest - exponent * BITS
    # whole 2^up, of at most 80 bits, in limbs.
    low, high = whole & LIMB, whole >> BITS
    first = low << up
    second = (high << up) + (first >> BITS)
    limbs = (first & LIMB, second & LIMB, second >> BITS)
    skip = 1 if limbs[0] == 0 else 0
    skip += 1 if limbs[0] == 0 and limbs[1] == 0 else 0
    count = 0
    for k in range(skip, 3):
        w[d, k - skip] = limbs[k]
        if limbs[k] != 0:
            count = k - skip + 1
    w[d, COUNT], w[d, EXPONENT] = count, exponent + skip


@helper
def add(w: Longs, d: int, a: int, b: int, sense: int, t: Longs) -> None:
    """d = a + sense b, sense being 1 or -1."""
    off = sum_error(w[a, OFF], w[b, OFF])
    if w[b, COUNT] == 0 or w[a, COUNT] == 0:
        source, sign = (b, sense * w[b, SIGN]) if w[a, COUNT] == 0 else (a, w[a, SIGN])
        copy(w, d, source)
        w[d, SIGN], w[d, OFF] = sign, off
        return
    low = min(w[a, EXPONENT], w[b, EXPONENT])
    high = max(w[a, EXPONENT] + w[a, COUNT], w[b, EXPONENT] + w[b, COUNT])
    # Terms far apart: limbs that scratch has no room for are cut off, and count as an error.
    if high - low > 3 * LIMBS:
        low = high - 3 * LIMBS
        off = sum_error(off, BITS * low + 1)
    count = high - low
    for k in range(count):
        t[0, k] = 0
    for term in range(2):
        source, sign = (a, w[a, SIGN]) if term == 0 else (b, sense * w[b, SIGN])
        start = w[source, EXPONENT] - low
        for k in range(max(0, -start), w[source, COUNT]):
            t[0, start + k] += sign * w[source, k]
    carry, sign = 0, 1
    for k in range(count):
        value = t[0, k] + carry
        t[0, k], carry = value & LIMB, value >> BITS
    if carry < 0:  # the sum is carry 2^(28 count) plus the limbs: negate it
        top, carry, sign = -carry - 1, 1, -1
        for k in range(count):
            value = LIMB - t[0, k] + carry
            t[0, k], carry = value & LIMB, value >> BITS
        carry += top
    t[0, count] = carry
    set_limbs(w, d, t, count + 1, low, sign, off)


@helper
def multiply(w: Longs, d: int, a: int, b: int, t: Longs) -> None:
    """d = a b"""
    off = EXACT
    if w[b, OFF] != EXACT:
        off = magnitude(w, a) + w[b, OFF]
    if w[a, OFF] != EXACT:
        off = sum_error(off, max(magnitude(w, b), w[b, OFF] + 1) + w[a, OFF] + 1)
    if (w[a, COUNT] == 0 and w[a, OFF] == EXACT) or (w[b, COUNT] == 0 and w[b, OFF] == EXACT):
        off = EXACT
    sign, exponent = w[a, SIGN] * w[b, SIGN], w[a, EXPONENT] + w[b, EXPONENT]
    most, count = w[a, COUNT], w[b, COUNT]
    low = max(0, most + count - LIMBS - 2)  # columns below would be cut off in any case
    columns = most + count - low
    for k in range(columns):
        t[0, k] = 0
    for i in range(most):
        factor = w[a, i]
        for k in range(max(0, low - i), count):
            t[0, i + k - low] += factor * w[b, k]
    carry = 0
    for k in range(columns):
        value = t[0, k] + carry
        t[0, k], carry = value & LIMB, value >> BITS
    if low > 0:  # at most ten products in each column that is left out
        off = sum_error(off, BITS * (exponent + low) + BITS + 4)
    set_limbs(w, d, t, columns, exponent + low, sign, off)


@helper
def divide(w: Longs, d: int, a: int, b: int, t: Longs) -> bool:
    """d = a / b; return False where b may be zero, or its error is too large."""
    below = magnitude(w, b) - 1  # |b| >= 2^below
    if w[b, COUNT] == 0 or (w[b, OFF] != EXACT and w[b, OFF] > below - 2):
        return False
    if w[a, COUNT] == 0:
        off = EXACT if w[a, OFF] == EXACT else w[a, OFF] - below + 2
        copy(w, d, a)
        w[d, OFF] = off
        return True
    given, own = w[a, OFF], w[b, OFF]
    n, size = w[b, COUNT], w[a, COUNT]
    # Shift both so that the divisor has a leading bit: then a guess of a limb is at most two too large (Knuth).
    up = BITS - 1 - exponent_of(float(w[b, n - 1]))
    carry = 0
    for k in range(n):
        value = (w[b, k] << up) + carry
        t[1, k], carry = value & LIMB, value >> BITS
    pad = n + _QUOTIENT - size - 1
    for k in range(pad):
        t[2, k] = 0
    carry = 0
    for k in range(size):
        value = (w[a, k] << up) + carry
        t[2, pad + k], carry = value & LIMB, value >> BITS
    t[2, pad + size] = carry
    for j in range(_QUOTIENT - 1, -1, -1):
        _next_limb(t, j, n)
    rest = 0
    for k in range(n):
        rest |= t[2, k]
    exponent, sign = w[a, EXPONENT] - pad - w[b, EXPONENT], w[a, SIGN] * w[b, SIGN]
    off = EXACT if rest == 0 else BITS * exponent
    if given != EXACT:
        off = sum_error(off, given - below + 1)
    set_limbs(w, d, t, _QUOTIENT, exponent, sign, EXACT if off == EXACT and own == EXACT else off)
    if own != EXACT:
        w[d, OFF] = sum_error(w[d, OFF], magnitude(w, d) + own - below + 1)
    return True


@helper
def _next_limb(t: Longs, j: int, n: int) -> None:
    """Compute limb j of the quotient t[0] of t[2] by t[1], which has n limbs and a leading bit (Knuth, algorithm D)."""
    above = (t[2, j + n] << BITS) + t[2, j + n - 1]
    guess = min(above // t[1, n - 1], LIMB)
    left = above - guess * t[1, n - 1]
    while n > 1 and left <= LIMB and guess * t[1, n - 2] > (left << BITS) + t[2, j + n - 2]:
        guess -= 1
        left += t[1, n - 1]
    carry = 0
    for k in range(n):
        value = t[2, j + k] - guess * t[1, k] + carry
        t[2, j + k], carry = value & LIMB, value >> BITS
    value = t[2, j + n] + carry
    while value < 0:
        guess -= 1
        carry = 0
        for k in range(n):
            sum_ = t[2, j + k] + t[1, k] + carry
            t[2, j + k], carry = sum_ & LIMB, sum_ >> BITS
        value += carry
    t[2, j + n] = value
    t[0, j] = guess
