"""Convert numbers of `bigfloat_kernel` to four floats and an error."""

from __future__ import annotations

from ..._jit.decorators import helper, kernel
from ...kernels.numbers.double_double import power_of_two
from ...kernels.numbers.quad_double import LEAST, UNKNOWN, QuadDouble, four, plus
from ...kernels.tables import Floats, Longs
from .bigfloat_kernel import BITS, COUNT, EXACT, EXPONENT, LIMBS, OFF, SIGN, WIDTH
from .simd_registers import COLUMNS


@helper
def _quad_from_bigfloat(wides: Longs, row: int) -> QuadDouble:
    """Return a number as four floats: limbs added from the highest on.

    Unknown beyond 2^900, or with limbs below 2^-900.
    """
    count, exponent = wides[row, COUNT], wides[row, EXPONENT]
    low, high, off = BITS * exponent, BITS * (exponent + count), wides[row, OFF]
    if not (0 <= count <= LIMBS and low > -900 and high < 900 and (off == EXACT or -900 < off < 900)):
        return QuadDouble(0.0, 0.0, 0.0, 0.0, UNKNOWN)
    sign = 1.0 if wides[row, SIGN] >= 0 else -1.0
    found = four(0.0)
    for k in range(count - 1, -1, -1):
        found = plus(found, four(sign * float(wides[row, k]) * power_of_two(low + BITS * k)))
    own = 0.0 if off == EXACT else power_of_two(off)
    error = found.error + own
    return QuadDouble(found.a, found.b, found.c, found.d, 0.0 if error == 0.0 else error * 1.0001 + LEAST)


@kernel(wides=f"n {WIDTH}", fours=f"out n {COLUMNS}")
def cut_to_fours(wides: Longs, fours: Floats) -> None:
    """Convert rows of wide numbers to rows of four floats and an error."""
    for row in range(len(wides)):
        fours[row, 0], fours[row, 1], fours[row, 2], fours[row, 3], fours[row, 4] = _quad_from_bigfloat(wides, row)
