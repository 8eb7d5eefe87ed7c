"""Sines and cosines of angles in degrees, in lanes of four floats; the method is `bigfloat_functions.sine_cosine`."""

from __future__ import annotations

import numpy as np

from ..._jit.decorators import choose, helper, inline
from ...kernels.numbers.quad_double import QuadDouble, four, minus, opposite
from ...kernels.tables import Floats
from .bigfloat_functions import MULTIPLES, STEP
from .simd_registers import (
    ALL,
    UNSURE,
    WORKS,
    add_rows,
    fill_rows,
    load,
    multiply_rows,
    of_table,
    plain,
    root_rows,
    store,
    subtract_rows,
    wide,
)

LANE_TERMS = 11
"""Terms of the series of a sine: the next is below 2^-235 of it (2^-7.34 to the 22nd, over 23!)."""
LANE_CONSTANTS = 2 + LANE_TERMS + 2 * (MULTIPLES + 1)
"""Rows of the table of `sine_cosine_rows`: pi / 180, 1, the coefficients from last to first, the multiples of STEP."""
ROOM = 8
"""Registers that it uses."""


@helper
def sine_cosine_rows(w: Floats, d: int, f: Floats, a: int, table: Floats, free: int, state: Floats) -> None:
    """Write sine and cosine of the angles in a plain register to d and d + 1, certain below 2^40 degrees.

    Uses registers from `free` on.
    """
    x, square, s, c, y, its_s, its_c, one = free, free + 1, free + 2, free + 3, free + 4, free + 5, free + 6, free + 7
    _reduce_angles(w, x, its_s, its_c, f, a, table, state)
    fill_rows(w, y, table, 0)
    multiply_rows(w, s, x, y)
    multiply_rows(w, square, s, s)
    fill_rows(w, one, table, 1)
    fill_rows(w, c, table, 2)
    for term in range(1, LANE_TERMS):
        multiply_rows(w, x, c, square)
        fill_rows(w, y, table, 2 + term)
        add_rows(w, c, x, y)
    # Add the truncation of the series to its error.
    rest = wide(c)
    for i in range(ALL):
        sine = load(w, rest, i)
        store(w, rest, i, QuadDouble(sine.a, sine.b, sine.c, sine.d, sine.error + 2.0**-234))
    multiply_rows(w, x, s, c)  # the sine
    multiply_rows(w, square, x, x)
    subtract_rows(w, y, one, square)
    root_rows(w, c, y, state)
    multiply_rows(w, y, x, its_c)
    multiply_rows(w, square, c, its_s)
    add_rows(w, s, y, square)
    multiply_rows(w, y, c, its_c)
    multiply_rows(w, square, x, its_s)
    subtract_rows(w, one, y, square)
    _rotate_quarters(w, d, s, one, f, a)


@inline
def _quarters(angle: float) -> float:
    """Return the nearest multiple of 90 degrees."""
    return np.floor(angle / 90.0 + 0.5)


@helper
def _reduce_angles(w: Floats, x: int, s: int, c: int, f: Floats, a: int, table: Floats, state: Floats) -> None:
    """Write to x the angles less quarters of a turn and less the nearest multiple of STEP.

    S and c belong to that multiple.
    """
    x, s, c, a = wide(x), wide(s), wide(c), plain(a)
    for i in range(ALL):
        known = abs(f[a + i]) < 2.0**40
        state[i] = choose(state[i] == WORKS, choose(known, WORKS, UNSURE), state[i])
        angle = choose(known, f[a + i], 0.0)
        rest = angle - 90.0 * _quarters(angle)  # exact: both are of one size, or the second is zero
        count = min(max(int(np.floor(abs(rest) / STEP + 0.5)), 0), MULTIPLES)
        side = 1.0 if rest > 0.0 else -1.0
        store(w, x, i, minus(four(rest), four(side * STEP * float(count))))
        row = 2 + LANE_TERMS + 2 * count
        store(w, s, i, of_table(table, row, side))
        store(w, c, i, of_table(table, row + 1, 1.0))


@helper
def _rotate_quarters(w: Floats, d: int, s: int, c: int, f: Floats, a: int) -> None:
    """Write sine and cosine of the angles to d and d + 1, given those of the angles less quarters of a turn."""
    sine, cosine, s, c, a = wide(d), wide(d + 1), wide(s), wide(c), plain(a)
    for i in range(ALL):
        angle = choose(abs(f[a + i]) < 2.0**40, f[a + i], 0.0)
        turn = int(_quarters(angle)) & 3
        its_s, its_c = load(w, s, i), load(w, c, i)
        if turn & 1 == 1:
            its_s, its_c = its_c, its_s
        store(w, sine, i, opposite(its_s) if turn >= 2 else its_s)
        store(w, cosine, i, opposite(its_c) if turn == 1 or turn == 2 else its_c)
