"""Registers of many bodies side by side: arithmetic, sines and cosines of `kernels.numbers.quad_double`, lane by lane.

A wide register is five rows of LANES floats, a plain one is one. All registers of a kind lie in one block, at places
that are unsigned integers: so the compiler sees that a loop over lanes touches only two or three blocks, and vectorises
it.
"""

from __future__ import annotations

from typing import Any

import numpy as np

from ..._jit.decorators import choose, helper, inline
from ...kernels.numbers.quad_double import (
    UNKNOWN,
    QuadDouble,
    by_sign,
    four,
    minus,
    nearest,
    opposite,
    over,
    plus,
    root,
    size_of,
    times,
)
from ...kernels.tables import Floats

LANES = 32
ALL = np.uint64(LANES)
_B, _C, _D, _ERROR = (np.uint64(row) for row in range(LANES, 5 * LANES, LANES))
OF_WIDE = 5 * LANES
"""Floats of a wide register."""
COLUMNS = 5
"""Columns of a number in tables: four floats and the error."""
STATE_VALID, STATE_OTHER_BRANCH, STATE_UNDECIDED = 0.0, 1.0, 2.0
"""States of a body: the tape is valid; a test turned out otherwise; bounds were too wide.

A state other than STATE_VALID stays.
"""


@inline
def load(w: Floats, at: Any, i: Any) -> QuadDouble:
    """Load lane i of the register whose rows begin at `at`."""
    # The five numbers of a lane stand a row apart: each access is one vector over the lanes.
    return QuadDouble(w[at + i], w[at + _B + i], w[at + _C + i], w[at + _D + i], w[at + _ERROR + i])


@inline
def store(w: Floats, at: Any, i: Any, value: QuadDouble) -> None:
    """Store lane i of a register."""
    w[at + i], w[at + _B + i], w[at + _C + i], w[at + _D + i], w[at + _ERROR + i] = value


@inline
def wide(register: int) -> Any:
    """Return where the rows of a wide register begin."""
    return np.uint64(register * OF_WIDE)


@inline
def plain(register: int) -> Any:
    """Return where the row of a plain register begins."""
    return np.uint64(register * LANES)


@helper
def add_rows(w: Floats, d: int, a: int, b: int) -> None:
    """d = a + b"""
    d, a, b = wide(d), wide(a), wide(b)
    for i in range(ALL):
        store(w, d, i, plus(load(w, a, i), load(w, b, i)))


@helper
def subtract_rows(w: Floats, d: int, a: int, b: int) -> None:
    """d = a - b"""
    d, a, b = wide(d), wide(a), wide(b)
    for i in range(ALL):
        store(w, d, i, minus(load(w, a, i), load(w, b, i)))


@helper
def multiply_rows(w: Floats, d: int, a: int, b: int) -> None:
    """d = a b"""
    d, a, b = wide(d), wide(a), wide(b)
    for i in range(ALL):
        store(w, d, i, times(load(w, a, i), load(w, b, i)))


@inline
def _store_known(w: Floats, at: Any, i: Any, value: QuadDouble, state: Floats) -> None:
    """`store`; an unknown value makes the body's state STATE_UNDECIDED."""
    store(w, at, i, value)
    state[i] = choose(state[i] == STATE_VALID, choose(value.error < UNKNOWN, STATE_VALID, STATE_UNDECIDED), state[i])


@helper
def divide_rows(w: Floats, d: int, a: int, b: int, state: Floats) -> None:
    """d = a / b"""
    d, a, b = wide(d), wide(a), wide(b)
    for i in range(ALL):
        _store_known(w, d, i, over(load(w, a, i), load(w, b, i)), state)


@helper
def root_rows(w: Floats, d: int, a: int, state: Floats) -> None:
    """d = sqrt(a)"""
    d, a = wide(d), wide(a)
    for i in range(ALL):
        _store_known(w, d, i, root(load(w, a, i)), state)


@helper
def ball_rows(w: Floats, d: int, a: int, b: int) -> None:
    """d = a number within |b| of a"""
    d, a, b = wide(d), wide(a), wide(b)
    for i in range(ALL):
        middle, radius = load(w, a, i), load(w, b, i)
        # The last three of four floats are below 2^-49 of the first
        reach = abs(radius.a) * (1.0 + 2.0**-48) + radius.error
        error = (middle.error + reach) * (1.0 + 2.0**-48)
        store(w, d, i, QuadDouble(middle.a, middle.b, middle.c, middle.d, error))


@helper
def negate_rows(w: Floats, d: int, a: int) -> None:
    """d = -a"""
    d, a = wide(d), wide(a)
    for i in range(ALL):
        store(w, d, i, opposite(load(w, a, i)))


@helper
def size_rows(w: Floats, d: int, a: int, state: Floats) -> None:
    """d = |a|"""
    d, a = wide(d), wide(a)
    for i in range(ALL):
        _store_known(w, d, i, size_of(load(w, a, i)), state)


@inline
def of_table(table: Floats, row: int, side: float) -> QuadDouble:
    """Return a number of a table, times `side` (+1 or -1)."""
    return QuadDouble(
        side * table[row, 0], side * table[row, 1], side * table[row, 2], side * table[row, 3], table[row, 4]
    )


@helper
def fill_rows(w: Floats, d: int, table: Floats, row: int) -> None:
    """d = the same number of a table for all lanes"""
    d = wide(d)
    value = of_table(table, row, 1.0)
    for i in range(ALL):
        store(w, d, i, value)


@helper
def widen_rows(w: Floats, d: int, f: Floats, a: int, state: Floats) -> None:
    """d = the floats of a plain register"""
    d, a = wide(d), plain(a)
    for i in range(ALL):
        _store_known(w, d, i, four(f[a + i]), state)


@helper
def round_rows(f: Floats, d: int, w: Floats, a: int, state: Floats) -> None:
    """d, a plain register, = the floats nearest to a; uncertain ones make the body's state STATE_UNDECIDED."""
    d, a = plain(d), wide(a)
    for i in range(ALL):
        value, unsure = nearest(load(w, a, i))
        f[d + i] = value
        state[i] = choose(state[i] == STATE_VALID, STATE_UNDECIDED * unsure, state[i])


@helper
def test_rows(w: Floats, a: int, expected: int, state: Floats) -> None:
    """Update the states of bodies whose number a certainly has none of the expected signs, or may have none."""
    a = wide(a)
    negative, zero, positive = expected_of(expected & 1), expected_of(expected & 2), expected_of(expected & 4)
    for i in range(ALL):
        state[i] = choose(
            state[i] == STATE_VALID, by_sign(load(w, a, i), negative, zero, positive, STATE_UNDECIDED), state[i]
        )


@helper
def test_plain_rows(f: Floats, a: int, expected: int, state: Floats) -> None:
    """`test_rows` for floats; NaN has a sign of its own."""
    a = plain(a)
    negative, zero, positive = expected_of(expected & 1), expected_of(expected & 2), expected_of(expected & 4)
    none = expected_of(expected & 8)
    for i in range(ALL):
        x = f[a + i]
        found = choose(x > 0.0, positive, choose(x < 0.0, negative, choose(x == 0.0, zero, none)))
        state[i] = choose(state[i] == STATE_VALID, found, state[i])


@inline
def expected_of(bit: int) -> float:
    """Return the state of bodies with a sign whose bit among the expected ones this is."""
    return STATE_VALID if bit != 0 else STATE_OTHER_BRANCH


# Sines and cosines of angles in degrees

STEP, MULTIPLES = 45.0 / 64.0, 64
"""Degrees; sines and cosines of so many multiples, up to 45 degrees, are tabulated.

A binary number: multiples are exact.
"""
TERMS = 11
"""Terms of the series of a sine: the next is below 2^-235 of it (2^-7.34 to the 22nd, over 23!)."""
CONSTANTS = 2 + TERMS + 2 * (MULTIPLES + 1)
"""Rows of the table of `sine_cosine_rows`: pi / 180, 1, the coefficients from last to first, the multiples of STEP."""
ROOM = 8
"""Registers that it uses."""


@helper
def sine_cosine_rows(w: Floats, d: int, f: Floats, a: int, table: Floats, free: int, state: Floats) -> None:
    """Write sine and cosine of the angles in a plain register to d and d + 1, certain below 2^40 degrees.

    The angle is reduced by quarters of a turn, and by the nearest multiple of STEP, whose sine and cosine `table`
    holds. For the rest, below 2^-7 in radians, the sine comes from its series, and the cosine from sqrt(1 - sine²).
    Then the angles are added. Uses registers from `free` on.
    """
    x, square, s, c, y, its_s, its_c, one = free, free + 1, free + 2, free + 3, free + 4, free + 5, free + 6, free + 7
    _reduce_angles(w, x, its_s, its_c, f, a, table, state)
    fill_rows(w, y, table, 0)
    multiply_rows(w, s, x, y)
    multiply_rows(w, square, s, s)
    fill_rows(w, one, table, 1)
    fill_rows(w, c, table, 2)
    for term in range(1, TERMS):
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

    `s` and `c` are those of that multiple.
    """
    x, s, c, a = wide(x), wide(s), wide(c), plain(a)
    for i in range(ALL):
        known = abs(f[a + i]) < 2.0**40
        state[i] = choose(state[i] == STATE_VALID, choose(known, STATE_VALID, STATE_UNDECIDED), state[i])
        angle = choose(known, f[a + i], 0.0)
        rest = angle - 90.0 * _quarters(angle)  # exact: both are of one size, or the second is zero
        count = min(max(int(np.floor(abs(rest) / STEP + 0.5)), 0), MULTIPLES)
        side = 1.0 if rest > 0.0 else -1.0
        store(w, x, i, minus(four(rest), four(side * STEP * float(count))))
        row = 2 + TERMS + 2 * count
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
