"""Interpreter of tapes: straight lines of operations, evaluated for one body after the other.

`numerics.tracing` records a tape while a formula is evaluated for one body. An operation is a row of five integers: its
code (see below), the register that it writes, and its operands. Wide registers hold numbers of `bigfloat_kernel`, plain
ones floats. A tape is valid for a body where all of its tests turn out as in the recording, and where the numbers that
it rounds are known well enough; else the body's state says so, and its outputs are meaningless.
"""

from __future__ import annotations

import numpy as np

from ..._jit.decorators import allocator, helper, kernel
from ...kernels.numbers.double_double import exponent_of, next_float_up, power_of_two
from ...kernels.tables import Floats, Ints, Longs, Signs
from . import bigfloat_kernel
from .bigfloat_functions import CONSTANTS, sine_cosine, square_root
from .bigfloat_kernel import COUNT, SCRATCH, SIGN, WIDTH
from .bigfloat_rounding import round_bigfloat

OPERATIONS = (
    "widen", "constant", "given", "add", "subtract", "multiply", "divide", "root", "negate", "size", "sine and cosine",
    "round", "input", "number", "plain add", "plain subtract", "plain multiply", "plain divide", "plain root",
    "plain negate", "plain size", "greater", "above", "above if", "power", "count", "several", "leading", "unit sign",
    "sign", "plain sign", "turn", "write wide",
)  # fmt: skip
(
    WIDEN, CONSTANT, GIVEN, ADD, SUBTRACT, MULTIPLY, DIVIDE, ROOT, NEGATE, SIZE, SINE_COSINE,
    ROUND, INPUT, NUMBER, PLAIN_ADD, PLAIN_SUBTRACT, PLAIN_MULTIPLY, PLAIN_DIVIDE, PLAIN_ROOT,
    PLAIN_NEGATE, PLAIN_SIZE, GREATER, ABOVE, ABOVE_IF, POWER, COUNT_NONZERO, SEVERAL, LEADING, UNIT_SIGN,
    SIGN_IS, PLAIN_SIGN_IS, TURN_IS, WRITE_WIDE,
) = range(33)  # fmt: skip

STATE_VALID, STATE_OTHER_BRANCH, STATE_UNDECIDED = 0, 1, 2
"""States of a body: the tape is valid; a test turned out otherwise; bounds were too wide."""
_FREE = 12
"""Wide registers behind those of a tape, for the operations' own use."""


@allocator
def _registers(wides: int, plains: int) -> tuple[Longs, Floats, Longs]:
    """Allocate wide and plain registers, and scratch memory."""
    return np.zeros((wides + _FREE, WIDTH), np.int64), np.zeros(plains), np.zeros((3, SCRATCH), np.int64)


@helper
def _wide_step(step: tuple[int, int, int, int], w: Longs, t: Longs) -> bool:
    """Run an operation between wide registers; return whether its result is known."""
    which, d, a, b = step
    if which == ADD:
        bigfloat_kernel.add(w, d, a, b, 1, t)
    elif which == SUBTRACT:
        bigfloat_kernel.add(w, d, a, b, -1, t)
    elif which == MULTIPLY:
        bigfloat_kernel.multiply(w, d, a, b, t)
    elif which == DIVIDE:
        return bigfloat_kernel.divide(w, d, a, b, t)
    elif which == ROOT:
        return square_root(w, d, a, t)
    else:
        bigfloat_kernel.copy(w, d, a)
        w[d, SIGN] = -w[a, SIGN] if which == NEGATE else 1
        return which == NEGATE or bigfloat_kernel.is_sure(w, a)
    return True


@helper
def _plain_step(step: tuple[int, int, int, int], c: int, f: Floats) -> bool:
    """Run an operation between plain registers; return whether its result is known."""
    which, d, a, b = step
    if which == PLAIN_ADD:
        f[d] = f[a] + f[b]
    elif which == PLAIN_SUBTRACT:
        f[d] = f[a] - f[b]
    elif which == PLAIN_MULTIPLY:
        f[d] = f[a] * f[b]
    elif which == PLAIN_DIVIDE:
        if f[b] == 0.0:
            return False
        f[d] = f[a] / f[b]
    elif which == PLAIN_ROOT:
        if not f[a] >= 0.0:
            return False
        f[d] = np.sqrt(f[a])
    elif which == PLAIN_NEGATE:
        f[d] = -f[a]
    elif which == PLAIN_SIZE:
        f[d] = abs(f[a])
    elif which == GREATER:
        f[d] = f[b] if f[b] > f[a] else f[a]
    elif which == ABOVE:
        f[d] = next_float_up(f[a])
    elif which == ABOVE_IF:
        f[d] = next_float_up(f[a]) if f[b] > 0.0 else f[a]
    elif which == COUNT_NONZERO:
        f[d] = f[a] + (1.0 if f[b] != 0.0 else 0.0)
    elif which == SEVERAL:
        f[d] = f[a] if f[c] >= 2.0 else f[b]
    elif which == LEADING:
        f[d] = f[a] if f[a] != 0.0 else f[b]
    elif which == UNIT_SIGN:
        f[d] = -1.0 if f[a] < 0.0 else 1.0
    else:  # POWER: 2^n that brings the number into [1/2, 1)
        if not 2.0**-1000 < abs(f[a]) < 2.0**1000:
            return False
        f[d] = power_of_two(-1 - exponent_of(f[a]))
    return True


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
def _sign(x: float) -> int:
    """Return the bit of a sign in tests: 1 for negative, 2 for zero, 4 for positive, 8 for NaN."""
    if x > 0.0:
        return 4
    return 1 if x < 0.0 else 2 if x == 0.0 else 8


@helper
def _run_body(
    code: Ints, numbers: Floats, constants: Longs, series: Longs, written: Ints, registers: tuple[Longs, Floats, Longs],
    inputs: Floats, wide_in: Longs, out: Floats, wide_out: Longs, i: int, row: int,
) -> int:  # fmt: skip
    """Run the tape for body i, whose wide inputs stand in a row; return its state."""
    w, f, t = registers
    free = len(w) - _FREE
    for k in range(len(code)):
        which, d, a, b, c = code[k, 0], code[k, 1], code[k, 2], code[k, 3], code[k, 4]
        known = True
        if ADD <= which <= SIZE:
            known = _wide_step((which, d, a, b), w, t)
        elif PLAIN_ADD <= which <= UNIT_SIGN:
            known = _plain_step((which, d, a, b), c, f)
        elif which == INPUT:
            f[d] = inputs[i, a]
        elif which == NUMBER:
            f[d] = numbers[a]
        elif which == WIDEN:
            known = abs(f[a]) < np.inf
            if known:
                bigfloat_kernel.set_float(w, d, f[a], 0)
        elif which == CONSTANT:
            for column in range(WIDTH):
                w[d, column] = constants[a, column]
        elif which == GIVEN:
            for column in range(WIDTH):
                w[d, column] = wide_in[row, a, column]
        elif which == SINE_COSINE:
            known = sine_cosine(w, d, f[a], series, free, t)
        elif which == ROUND:
            f[d], known = round_bigfloat(w, a, free, t)
        elif which == SIGN_IS:
            known = bigfloat_kernel.is_sure(w, a)
            if known and _sign(float(w[a, SIGN]) if w[a, COUNT] > 0 else 0.0) & b == 0:
                return STATE_OTHER_BRANCH
        elif which == PLAIN_SIGN_IS:
            if _sign(f[a]) & b == 0:
                return STATE_OTHER_BRANCH
        elif which == TURN_IS:
            if multiple_of_30_degrees(f[a]) != b:
                return STATE_OTHER_BRANCH
        else:  # WRITE_WIDE
            for column in range(WIDTH):
                wide_out[i, d, column] = w[a, column]
        if not known:
            return STATE_UNDECIDED
    for k in range(len(written)):
        out[i, k] = f[written[k]]
    return STATE_VALID


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


@helper
def _is_number(table: Longs, row: int) -> bool:
    """Return whether a row is a number of `bigfloat_kernel`: limbs, their count, and an exponent far from overflow."""
    if not 0 <= table[row, COUNT] <= bigfloat_kernel.LIMBS:
        return False
    for k in range(bigfloat_kernel.LIMBS):
        if not 0 <= table[row, k] < 1 << bigfloat_kernel.BITS:
            return False
    return -(1 << 24) < table[row, bigfloat_kernel.EXPONENT] < 1 << 24 and table[row, bigfloat_kernel.OFF] < 1 << 30


@kernel(
    code="* 5", written="outputs", numbers="*", constants=f"* {WIDTH}", series=f"* {WIDTH}", inputs="n *",
    wide_in=f"* * {WIDTH}", rows="n", out="out n outputs", wide_out=f"out n|0 * {WIDTH}", state="out n",
    wides="0..1048576", plains="0..1048576", begin="0..end", end="0..n",
)  # fmt: skip
def play(
    code: Ints, written: Ints, numbers: Floats, constants: Longs, series: Longs, inputs: Floats, wide_in: Longs,
    rows: Ints, out: Floats, wide_out: Longs, state: Signs, wides: int, plains: int, begin: int, end: int,
) -> None:  # fmt: skip
    """Play a tape for bodies begin to end, each with a row of inputs and one of wide inputs; `state` as above.

    A tape that names what does not exist leaves all bodies undecided.
    """
    outputs = wide_out.shape[1] if len(wide_out) == len(state) else 0
    sizes = (wides, plains, len(numbers), len(constants), inputs.shape[1], wide_in.shape[1], outputs)
    all_there = fits(code, written, sizes) and len(series) >= CONSTANTS
    for table in (constants, series):
        for row in range(len(table)):
            all_there = all_there and _is_number(table, row)
    registers = _registers(wides, plains)
    for i in range(begin, end):
        row = rows[i]
        known = all_there and (wide_in.shape[1] == 0 or is_within(row, len(wide_in)))
        for k in range(wide_in.shape[1]):
            known = known and _is_number(wide_in[row], k)
        state[i] = STATE_UNDECIDED
        if known:
            state[i] = _run_body(
                code, numbers, constants, series, written, registers, inputs, wide_in, out, wide_out, i, row
            )
