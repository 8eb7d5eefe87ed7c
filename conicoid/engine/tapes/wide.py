"""Numbers of 253 bits and more that know how far off they may be: those of `shapes.number`, made small and quick.

A number is a row of int64: LIMBS limbs of 28 bits, the lowest first, then how many there are, the exponent of the first
(of 2^28), the sign, and the error: the true number lies within 2^OFF. EXACT says that it is the number itself. Sums and
products of floats are exact while they have room; what is cut off is counted as an error, as it is in `shapes.number`.
Limbs of 28 bits leave room for the sums of ten products in an int64, so that carries can wait.

Long division and the rest are as Knuth has them (The Art of Computer Programming, 4.3.1); roots are by Newton's method,
and certified by what is left of the square.
"""

from __future__ import annotations

import numpy as np

from ...compiler.jit import bits_of, helper, inline
from ..numbers.bits import exponent_of, power_of_two, scaled_by_power
from ..tables import Longs

LIMBS, BITS = 10, 28
COUNT, EXPONENT, SIGN, OFF = range(LIMBS, LIMBS + 4)
WIDTH = LIMBS + 4
EXACT = -(1 << 40)
_LIMB = (1 << BITS) - 1
_NOTHING = -(1 << 30)
"""The magnitude of zero."""
SCRATCH = 4 * LIMBS
"""Columns of the three rows of scratch."""
_QUOTIENT = LIMBS + 2


@inline
def wider(off: int, more: int) -> int:
    """The error of a sum whose terms have these."""
    if off == EXACT or more == EXACT:
        return max(off, more)
    return max(off, more) + 1


@inline
def magnitude(w: Longs, a: int) -> int:
    """The least m with |value| < 2^m."""
    count = w[a, COUNT]
    if count == 0:
        return _NOTHING
    return BITS * (w[a, EXPONENT] + count - 1) + exponent_of(float(w[a, count - 1])) + 1


@inline
def is_sure(w: Longs, a: int) -> bool:
    """Is the sign known: is the number certainly not zero, or certainly zero?"""
    return w[a, OFF] == EXACT or magnitude(w, a) - 1 > w[a, OFF]


@helper
def copy(w: Longs, d: int, a: int) -> None:
    """d = a"""
    for k in range(WIDTH):
        w[d, k] = w[a, k]


@helper
def _put(w: Longs, d: int, t: Longs, count: int, exponent: int, sign: int, off: int) -> None:
    """Number d from limbs in scratch, without the zeros at both ends; what there is no room for is cut."""
    while count > 0 and t[0, count - 1] == 0:
        count -= 1
    low = max(0, count - LIMBS)
    for k in range(low):
        if t[0, k] != 0:
            off = wider(off, BITS * (exponent + low))
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
def put_float(w: Longs, d: int, x: float, shift: int) -> None:
    """d = x 2^shift; x is finite."""
    w[d, COUNT], w[d, EXPONENT], w[d, SIGN], w[d, OFF] = 0, 0, 1, EXACT
    if x == 0.0:
        return
    if x < 0.0:
        w[d, SIGN], x = -1, -x
    power = exponent_of(x)
    whole = bits_of(scaled_by_power(x, -power)) & ((1 << 52) - 1) | (1 << 52)
    lowest = power - 52 + shift
    exponent = lowest // BITS
    up = lowest - exponent * BITS
    # whole 2^up, of at most 80 bits, in limbs
    low, high = whole & _LIMB, whole >> BITS
    first = low << up
    second = (high << up) + (first >> BITS)
    limbs = (first & _LIMB, second & _LIMB, second >> BITS)
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
    off = wider(w[a, OFF], w[b, OFF])
    if w[b, COUNT] == 0 or w[a, COUNT] == 0:
        source, sign = (b, sense * w[b, SIGN]) if w[a, COUNT] == 0 else (a, w[a, SIGN])
        copy(w, d, source)
        w[d, SIGN], w[d, OFF] = sign, off
        return
    low = min(w[a, EXPONENT], w[b, EXPONENT])
    high = max(w[a, EXPONENT] + w[a, COUNT], w[b, EXPONENT] + w[b, COUNT])
    if high - low > 3 * LIMBS:
        low = high - 3 * LIMBS
        off = wider(off, BITS * low + 1)
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
        t[0, k], carry = value & _LIMB, value >> BITS
    if carry < 0:  # the sum is carry 2^(28 count) plus what stands there: turn it over
        top, carry, sign = -carry - 1, 1, -1
        for k in range(count):
            value = _LIMB - t[0, k] + carry
            t[0, k], carry = value & _LIMB, value >> BITS
        carry += top
    t[0, count] = carry
    _put(w, d, t, count + 1, low, sign, off)


@helper
def multiply(w: Longs, d: int, a: int, b: int, t: Longs) -> None:
    """d = a b"""
    off = EXACT
    if w[b, OFF] != EXACT:
        off = magnitude(w, a) + w[b, OFF]
    if w[a, OFF] != EXACT:
        off = wider(off, max(magnitude(w, b), w[b, OFF] + 1) + w[a, OFF] + 1)
    if (w[a, COUNT] == 0 and w[a, OFF] == EXACT) or (w[b, COUNT] == 0 and w[b, OFF] == EXACT):
        off = EXACT
    sign, exponent = w[a, SIGN] * w[b, SIGN], w[a, EXPONENT] + w[b, EXPONENT]
    most, count = w[a, COUNT], w[b, COUNT]
    low = max(0, most + count - LIMBS - 2)  # columns below would be cut in any case
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
        t[0, k], carry = value & _LIMB, value >> BITS
    if low > 0:  # at most ten products for each column that is left out
        off = wider(off, BITS * (exponent + low) + BITS + 4)
    _put(w, d, t, columns, exponent + low, sign, off)


@helper
def divide(w: Longs, d: int, a: int, b: int, t: Longs) -> bool:
    """d = a / b; False where b may be zero, or is known too badly."""
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
    up = BITS - 1 - exponent_of(float(w[b, n - 1]))
    carry = 0
    for k in range(n):
        value = (w[b, k] << up) + carry
        t[1, k], carry = value & _LIMB, value >> BITS
    pad = n + _QUOTIENT - size - 1
    for k in range(pad):
        t[2, k] = 0
    carry = 0
    for k in range(size):
        value = (w[a, k] << up) + carry
        t[2, pad + k], carry = value & _LIMB, value >> BITS
    t[2, pad + size] = carry
    for j in range(_QUOTIENT - 1, -1, -1):
        _next_limb(t, j, n)
    rest = 0
    for k in range(n):
        rest |= t[2, k]
    exponent, sign = w[a, EXPONENT] - pad - w[b, EXPONENT], w[a, SIGN] * w[b, SIGN]
    off = EXACT if rest == 0 else BITS * exponent
    if given != EXACT:
        off = wider(off, given - below + 1)
    _put(w, d, t, _QUOTIENT, exponent, sign, EXACT if off == EXACT and own == EXACT else off)
    if own != EXACT:
        w[d, OFF] = wider(w[d, OFF], magnitude(w, d) + own - below + 1)
    return True


@helper
def _next_limb(t: Longs, j: int, n: int) -> None:
    """Limb j of the quotient t[0] of t[2] by t[1], which has n limbs and a leading bit (Knuth's algorithm D)."""
    above = (t[2, j + n] << BITS) + t[2, j + n - 1]
    guess = min(above // t[1, n - 1], _LIMB)
    left = above - guess * t[1, n - 1]
    while n > 1 and left <= _LIMB and guess * t[1, n - 2] > (left << BITS) + t[2, j + n - 2]:
        guess -= 1
        left += t[1, n - 1]
    carry = 0
    for k in range(n):
        value = t[2, j + k] - guess * t[1, k] + carry
        t[2, j + k], carry = value & _LIMB, value >> BITS
    value = t[2, j + n] + carry
    while value < 0:
        guess -= 1
        carry = 0
        for k in range(n):
            sum_ = t[2, j + k] + t[1, k] + carry
            t[2, j + k], carry = sum_ & _LIMB, sum_ >> BITS
        value += carry
    t[2, j + n] = value
    t[0, j] = guess


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
        t[0, k], carry = value & _LIMB, value >> BITS
    t[0, limbs] = carry
    _put(w, d, t, limbs + 1, w[a, EXPONENT] + less, w[a, SIGN], EXACT)


@helper
def _nearest(w: Longs, a: int) -> tuple[float, int]:
    """(m, k), m 2^k being the number of 53 bits nearest to |a|, which is not zero; of two the even one."""
    last = magnitude(w, a) - 53
    first = last // BITS
    down = last - first * BITS
    whole = 0
    for k in range(3):  # 53 bits from place `last` on
        at = first + k - w[a, EXPONENT]
        limb = w[a, at] if 0 <= at < w[a, COUNT] else 0
        shift = BITS * k - down
        whole |= limb << shift if shift >= 0 else limb >> -shift
    half = (last - 1) // BITS - w[a, EXPONENT]  # the limb with the first bit that is left out
    if 0 <= half < w[a, COUNT]:
        place = last - 1 - (half + w[a, EXPONENT]) * BITS
        if (w[a, half] >> place) & 1:
            rest = (whole & 1) | (w[a, half] & ((1 << place) - 1))
            for k in range(half):
                rest |= w[a, k]
            whole += 1 if rest != 0 else 0
    return float(whole), last


@inline
def _is_clear(w: Longs, a: int) -> bool:
    """Does the interval of a number of five limbs or more certainly hold no float, and no number halfway between two?

    That is plain where the 40 bits that follow its first 54 are not all alike, and its error is smaller than these.
    """
    last = magnitude(w, a) - 54
    if w[a, OFF] > last - 40:
        return False
    k = last // BITS - w[a, EXPONENT]
    up = last - (k + w[a, EXPONENT]) * BITS
    rest = ((w[a, k] & ((1 << up) - 1)) << BITS) | w[a, k - 1]  # the up + 28 bits that follow
    rest = ((rest << 16) | (w[a, k - 2] >> 12)) >> (up + 4) if up < 12 else rest >> (up - 12)
    return 1 < rest < (1 << 40) - 2


@helper
def rounded(w: Longs, a: int, free: int, t: Longs) -> tuple[float, bool]:
    """(the float nearest to a, is that sure); none is where it would be subnormal or beyond the floats.

    Sure it is where both ends of the interval round alike. Uses three numbers from `free` on.
    """
    if w[a, COUNT] == 0:
        return 0.0, w[a, OFF] == EXACT
    if w[a, OFF] == EXACT or (w[a, COUNT] > 4 and _is_clear(w, a)):
        value, power = _nearest(w, a)
    else:
        if not is_sure(w, a):
            return 0.0, False
        put_float(w, free, 1.0, max(w[a, OFF], BITS * (w[a, EXPONENT] + w[a, COUNT] - LIMBS + 1)))
        copy(w, free + 1, a)
        w[free + 1, OFF], w[free + 1, SIGN] = EXACT, 1
        add(w, free + 2, free + 1, free, -1, t)
        add(w, free + 1, free + 1, free, 1, t)
        if w[free + 1, OFF] != EXACT or w[free + 2, OFF] != EXACT or w[free + 2, COUNT] == 0:
            return 0.0, False
        value, power = _nearest(w, free + 2)
        other, its_power = _nearest(w, free + 1)
        if (value != other or power != its_power) and not (its_power == power + 1 and value == 2.0 * other):
            return 0.0, False
    if power < -1022 or power > 970:
        return 0.0, False
    return float(w[a, SIGN]) * scaled_by_power(value, power), True


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
