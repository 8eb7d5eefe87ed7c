"""Registers of many bodies side by side: the arithmetic of `kernels.numbers.quad_double`, lane by lane.

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
WORKS, FAILS, UNSURE = 0.0, 1.0, 2.0
"""States of the bodies in the lanes, as `interpreter.STATE_VALID`, `STATE_OTHER_BRANCH`, `STATE_UNDECIDED`.

A state other than WORKS stays.
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
    """`store`; an unknown value makes the body's state UNSURE."""
    store(w, at, i, value)
    state[i] = choose(state[i] == WORKS, choose(value.error < UNKNOWN, WORKS, UNSURE), state[i])


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
    """d, a plain register, = the floats nearest to a; uncertain ones make the body's state UNSURE."""
    d, a = plain(d), wide(a)
    for i in range(ALL):
        value, unsure = nearest(load(w, a, i))
        f[d + i] = value
        state[i] = choose(state[i] == WORKS, UNSURE * unsure, state[i])


@helper
def test_rows(w: Floats, a: int, expected: int, state: Floats) -> None:
    """Update the states of bodies whose number a certainly has none of the expected signs, or may have none."""
    a = wide(a)
    negative, zero, positive = expected_of(expected & 1), expected_of(expected & 2), expected_of(expected & 4)
    for i in range(ALL):
        state[i] = choose(state[i] == WORKS, by_sign(load(w, a, i), negative, zero, positive, UNSURE), state[i])


@helper
def test_plain_rows(f: Floats, a: int, expected: int, state: Floats) -> None:
    """`test_rows` for floats; NaN has a sign of its own."""
    a = plain(a)
    negative, zero, positive = expected_of(expected & 1), expected_of(expected & 2), expected_of(expected & 4)
    none = expected_of(expected & 8)
    for i in range(ALL):
        x = f[a + i]
        found = choose(x > 0.0, positive, choose(x < 0.0, negative, choose(x == 0.0, zero, none)))
        state[i] = choose(state[i] == WORKS, found, state[i])


@inline
def expected_of(bit: int) -> float:
    """Return the state of bodies with a sign whose bit among the expected ones this is."""
    return WORKS if bit != 0 else FAILS
