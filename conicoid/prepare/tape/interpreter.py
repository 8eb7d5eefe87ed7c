"""Interpreter of tapes: straight lines of operations, evaluated for many bodies side by side in numbers of four floats.

`numerics.tracing` records a tape while a formula is evaluated for one body. An operation is a row of five integers: its
code (see below), the register that it writes, and its operands. Wide registers hold numbers of
`kernels.numbers.quad_double`, plain ones floats. Results are certain: a test passes where the interval of its number
leaves no doubt, and a number is rounded where both ends of its interval round alike. A tape is valid for a body where
all of its tests turn out as in the recording, and where four floats decide all of them; else the body's state says so,
and its outputs are meaningless.
"""

from __future__ import annotations

import numpy as np

from ..._jit.decorators import allocator, choose, helper, kernel
from ...kernels.numbers.double_double import exponent_of, next_float_up, power_of_two
from ...kernels.tables import Floats, Ints, Longs, Signs
from .registers import (
    ALL,
    COLUMNS,
    CONSTANTS,
    LANES,
    OF_WIDE,
    ROOM,
    STATE_OTHER_BRANCH,
    STATE_UNDECIDED,
    STATE_VALID,
    add_rows,
    ball_rows,
    divide_rows,
    fill_rows,
    multiply_rows,
    negate_rows,
    plain,
    root_rows,
    round_rows,
    sine_cosine_rows,
    size_rows,
    subtract_rows,
    test_plain_rows,
    test_rows,
    widen_rows,
)

OPERATIONS = (
    "widen", "constant", "given", "add", "subtract", "multiply", "divide", "ball", "root", "negate", "size",
    "sine and cosine", "round", "input", "number", "plain add", "plain subtract", "plain multiply", "plain divide",
    "plain root", "plain negate", "plain size", "greater", "above", "above if", "power", "count", "several", "leading",
    "unit sign", "sign", "plain sign", "turn", "write wide",
)  # fmt: skip
(
    WIDEN, CONSTANT, GIVEN, ADD, SUBTRACT, MULTIPLY, DIVIDE, BALL, ROOT, NEGATE, SIZE, SINE_COSINE,
    ROUND, INPUT, NUMBER, PLAIN_ADD, PLAIN_SUBTRACT, PLAIN_MULTIPLY, PLAIN_DIVIDE, PLAIN_ROOT,
    PLAIN_NEGATE, PLAIN_SIZE, GREATER, ABOVE, ABOVE_IF, POWER, COUNT_NONZERO, SEVERAL, LEADING, UNIT_SIGN,
    SIGN_IS, PLAIN_SIGN_IS, TURN_IS, WRITE_WIDE,
) = range(34)  # fmt: skip

_FEW = 4
"""Where only one in so many lanes is still working, its body waits until there are more."""


@allocator
def _rows(wides: int, plains: int) -> tuple[Floats, Floats, Floats, Longs, Longs]:
    """Allocate wide and plain registers, states, the bodies in lanes, and the queue of bodies that wait for a lane."""
    return (
        np.zeros((wides + ROOM) * OF_WIDE), np.zeros((plains + 1) * LANES), np.zeros(LANES),
        np.zeros(LANES, np.int64), np.zeros(2 * LANES, np.int64),
    )  # fmt: skip


@helper
def _wide_step(step: tuple[int, int, int, int], w: Floats, state: Floats) -> None:
    """Run an operation between wide registers."""
    which, d, a, b = step
    if which == ADD:
        add_rows(w, d, a, b)
    elif which == SUBTRACT:
        subtract_rows(w, d, a, b)
    elif which == MULTIPLY:
        multiply_rows(w, d, a, b)
    elif which == DIVIDE:
        divide_rows(w, d, a, b, state)
    elif which == BALL:
        ball_rows(w, d, a, b)
    elif which == ROOT:
        root_rows(w, d, a, state)
    elif which == NEGATE:
        negate_rows(w, d, a)
    else:
        size_rows(w, d, a, state)


@helper
def _sum_step(step: tuple[int, int, int, int], f: Floats, state: Floats) -> None:
    """Run an arithmetic operation between plain registers."""
    which, d, a, b = step[0], plain(step[1]), plain(step[2]), plain(step[3])
    if which == PLAIN_ADD:
        for i in range(ALL):
            f[d + i] = f[a + i] + f[b + i]
    elif which == PLAIN_SUBTRACT:
        for i in range(ALL):
            f[d + i] = f[a + i] - f[b + i]
    elif which == PLAIN_MULTIPLY:
        for i in range(ALL):
            f[d + i] = f[a + i] * f[b + i]
    elif which == PLAIN_DIVIDE:
        for i in range(ALL):
            state[i] = choose(state[i] == STATE_VALID, choose(f[b + i] == 0.0, STATE_UNDECIDED, STATE_VALID), state[i])
            f[d + i] = f[a + i] / f[b + i]
    elif which == PLAIN_ROOT:
        for i in range(ALL):
            state[i] = choose(state[i] == STATE_VALID, choose(f[a + i] >= 0.0, STATE_VALID, STATE_UNDECIDED), state[i])
            f[d + i] = np.sqrt(f[a + i])
    elif which == PLAIN_NEGATE:
        for i in range(ALL):
            f[d + i] = -f[a + i]
    else:  # PLAIN_SIZE
        for i in range(ALL):
            f[d + i] = abs(f[a + i])


@helper
def _choice_step(step: tuple[int, int, int, int], c: int, f: Floats, state: Floats) -> None:
    """Run any other operation between plain registers."""
    which, d, a, b = step[0], plain(step[1]), plain(step[2]), plain(step[3])
    if which == GREATER:
        for i in range(ALL):
            f[d + i] = choose(f[b + i] > f[a + i], f[b + i], f[a + i])
    elif which == ABOVE:
        for i in range(ALL):
            f[d + i] = next_float_up(f[a + i])
    elif which == ABOVE_IF:
        for i in range(ALL):
            f[d + i] = choose(f[b + i] > 0.0, next_float_up(f[a + i]), f[a + i])
    elif which == COUNT_NONZERO:
        for i in range(ALL):
            f[d + i] = f[a + i] + choose(f[b + i] != 0.0, 1.0, 0.0)
    elif which == SEVERAL:
        third = plain(c)
        for i in range(ALL):
            f[d + i] = choose(f[third + i] >= 2.0, f[a + i], f[b + i])
    elif which == LEADING:
        for i in range(ALL):
            f[d + i] = choose(f[a + i] != 0.0, f[a + i], f[b + i])
    elif which == UNIT_SIGN:
        for i in range(ALL):
            f[d + i] = choose(f[a + i] < 0.0, -1.0, 1.0)
    else:  # POWER
        for i in range(ALL):
            size = abs(f[a + i])
            known = choose(size > 2.0**-1000, choose(size < 2.0**1000, STATE_VALID, STATE_UNDECIDED), STATE_UNDECIDED)
            state[i] = choose(state[i] == STATE_VALID, known, state[i])
            f[d + i] = power_of_two(-1 - exponent_of(choose(known == STATE_VALID, size, 1.0)))


@helper
def multiple_of_30_degrees(angle: float) -> int:
    """Return which multiple of 30 degrees an angle is, 0 to 11; 12 for other angles, -1 beyond 2^40."""
    if not abs(angle) < 2.0**40:
        return -1
    count = np.floor(angle / 30.0 + 0.5)
    if 30.0 * count != angle:
        return 12
    turn = int(count) % 12
    return turn + 12 if turn < 0 else turn


@helper
def _test_turns(f: Floats, a: int, expected: int, state: Floats) -> None:
    """Update the states of bodies whose angle is not the expected multiple of 30 degrees."""
    a = plain(a)
    for i in range(ALL):
        if state[i] == STATE_VALID and multiple_of_30_degrees(f[a + i]) != expected:
            state[i] = STATE_OTHER_BRANCH


@helper
def _fill_register(
    step: tuple[int, int, int], registers: tuple[Floats, Floats], numbers: Floats, constants: Floats, inputs: Floats,
    wide_in: Floats, lanes: Longs, rows: Ints,
) -> None:  # fmt: skip
    """Fill a register with inputs: numbers of the tape, or of the bodies in the lanes."""
    which, register, column = step
    w, f = registers
    if which == INPUT:
        d = plain(register)
        for i in range(LANES):
            f[d + np.uint64(i)] = inputs[lanes[i], column]
    elif which == NUMBER:
        d = plain(register)
        for i in range(ALL):
            f[d + i] = numbers[column]
    elif which == CONSTANT:
        fill_rows(w, register, constants, column)
    else:  # GIVEN
        for i in range(LANES):
            row = rows[lanes[i]]
            for k in range(COLUMNS):
                w[register * OF_WIDE + k * LANES + i] = wide_in[row, column, k]


@helper
def _count_working(state: Floats, count: int) -> int:
    """Count the working bodies in the first lanes."""
    left = 0
    for i in range(count):
        left += 1 if state[i] == STATE_VALID else 0
    return left


@helper
def _write_wide(out: Floats, column: int, w: Floats, register: int, lanes: Longs, count: int) -> None:
    """Write a wide output of the bodies in the first lanes."""
    for i in range(count):
        for k in range(COLUMNS):
            out[lanes[i], column, k] = w[register * OF_WIDE + k * LANES + i]


@helper
def _run_lanes(
    code: Ints, tables: tuple[Floats, Floats, Floats], written: Ints, registers: tuple[Floats, Floats, Floats],
    inputs: Floats, wide_in: Floats, rows: Ints, out: Floats, wide_out: Floats, lanes: Longs, count: int,
) -> bool:  # fmt: skip
    """Play for the bodies in the first lanes; return False, without output, where few still work and should wait."""
    w, f, state = registers
    numbers, constants, series = tables
    free = len(w) // OF_WIDE - ROOM
    for i in range(ALL):
        state[i] = STATE_VALID
    for k in range(len(code)):
        which, d, a, b, c = code[k, 0], code[k, 1], code[k, 2], code[k, 3], code[k, 4]
        if ADD <= which <= SIZE:
            _wide_step((which, d, a, b), w, state)
        elif PLAIN_ADD <= which <= PLAIN_SIZE:
            _sum_step((which, d, a, b), f, state)
        elif GREATER <= which <= UNIT_SIGN:
            _choice_step((which, d, a, b), c, f, state)
        elif which == WIDEN:
            widen_rows(w, d, f, a, state)
        elif which == ROUND:
            round_rows(f, d, w, a, state)
        elif which == SINE_COSINE:
            sine_cosine_rows(w, d, f, a, series, free, state)
        elif which == WRITE_WIDE:
            _write_wide(wide_out, d, w, a, lanes, count)
        elif SIGN_IS <= which <= TURN_IS:
            if which == SIGN_IS:
                test_rows(w, a, b, state)
            elif which == PLAIN_SIGN_IS:
                test_plain_rows(f, a, b, state)
            else:
                _test_turns(f, a, b, state)
            left = _count_working(state, count)
            if left == 0:
                return True
            if _FEW * left <= count:
                return False
        else:
            _fill_register((which, d, a), (w, f), numbers, constants, inputs, wide_in, lanes, rows)
    for i in range(count):
        if state[i] == STATE_VALID:
            for k in range(len(written)):
                out[lanes[i], k] = f[written[k] * LANES + i]
    return True


@helper
def is_within(value: int, size: int) -> bool:
    """Return whether a value is an index of `size` items."""
    return 0 <= value < size


@helper
def fits(code: Ints, written: Ints, sizes: tuple[int, int, int, int, int, int, int]) -> bool:
    """Return whether all registers, constants, inputs and outputs that the code names exist.

    sizes: of wide and plain registers, numbers, constants, inputs, wide inputs, wide outputs.
    """
    wides, plains, numbers, constants, inputs, given, outputs = sizes
    for k in range(len(code)):
        which, d, a, b, c = code[k, 0], code[k, 1], code[k, 2], code[k, 3], code[k, 4]
        if not is_within(which, len(OPERATIONS)) or min(d, a, b, c) < 0:
            return False
        fits = True
        if ADD <= which <= SIZE:
            fits = max(d, a, b) < wides
        elif PLAIN_ADD <= which <= UNIT_SIGN:
            fits = max(d, a, b) < plains and c < plains
        elif which == WIDEN:
            fits = d < wides and a < plains
        elif which == CONSTANT:
            fits = d < wides and a < constants
        elif which == GIVEN:
            fits = d < wides and a < given
        elif which == SINE_COSINE:
            fits = d + 1 < wides and a < plains
        elif which == ROUND:
            fits = d < plains and a < wides
        elif which == INPUT:
            fits = d < plains and a < inputs
        elif which == NUMBER:
            fits = d < plains and a < numbers
        elif which == SIGN_IS:
            fits = a < wides
        elif which == WRITE_WIDE:
            fits = d < outputs and a < wides
        else:  # PLAIN_SIGN_IS, TURN_IS
            fits = a < plains
        if not fits:
            return False
    known = True
    for k in range(len(written)):
        known = known and is_within(written[k], plains)
    return known


@kernel(
    code="* 5", written="outputs", numbers="*", constants=f"* {COLUMNS}", series=f"* {COLUMNS}", inputs="n *",
    wide_in=f"* * {COLUMNS}", rows="n", out="out n outputs", wide_out=f"out n|0 * {COLUMNS}", state="out n",
    wides="0..65536", plains="0..65536", begin="0..end", end="0..n",
)  # fmt: skip
def play(
    code: Ints, written: Ints, numbers: Floats, constants: Floats, series: Floats, inputs: Floats, wide_in: Floats,
    rows: Ints, out: Floats, wide_out: Floats, state: Signs, wides: int, plains: int, begin: int, end: int,
) -> None:  # fmt: skip
    """Play a tape for bodies begin to end, each with a row of inputs and one of wide inputs; `state` as above.

    Where a test turns out as recorded for few bodies, these wait until there are enough to fill the lanes. A tape that
    names what does not exist leaves all bodies undecided.
    """
    outputs = wide_out.shape[1] if len(wide_out) == len(state) else 0
    sizes = (wides, plains, len(numbers), len(constants), inputs.shape[1], wide_in.shape[1], outputs)
    all_there = fits(code, written, sizes) and len(series) >= CONSTANTS
    w, f, states, lanes, waiting = _rows(wides, plains)
    fresh, left = begin, 0
    while fresh < end or left > 0:
        count = 0
        if left >= LANES or fresh == end:
            while count < LANES and left > 0:
                left -= 1
                lanes[count] = waiting[left]
                count += 1
        else:
            while count < LANES and fresh < end:
                state[fresh] = STATE_UNDECIDED
                if all_there and (wide_in.shape[1] == 0 or is_within(rows[fresh], len(wide_in))):
                    lanes[count] = fresh
                    count += 1
                fresh += 1
        if count == 0:
            continue
        # Idle lanes repeat the first body, so that all operations see valid numbers.
        for i in range(count, LANES):
            lanes[i] = lanes[0]
        done = _run_lanes(
            code, (numbers, constants, series), written, (w, f, states), inputs, wide_in, rows, out, wide_out, lanes,
            count,
        )  # fmt: skip
        for i in range(count):
            if not done and states[i] == STATE_VALID:
                waiting[left] = lanes[i]
                left += 1
            else:
                state[lanes[i]] = int(states[i])
