"""Recordings: tapes as arrays that kernels take, and the results of playing them."""

from __future__ import annotations

import math
from collections.abc import Callable
from dataclasses import dataclass
from fractions import Fraction
from functools import cached_property, lru_cache

import numpy as np
import numpy.typing as npt

from ..._util.arrays import unique_with_inverse
from ...kernels.numbers.quad_double import LEAST
from ...kernels.tables import Floats, Ints, Signs
from ...numerics import bigfloat
from ...numerics.bigfloat import BigFloat
from ...numerics.tracing import Tape
from .bigfloat_functions import CONSTANTS, MULTIPLES, STEP, TERMS
from .bigfloat_kernel import BITS, COUNT, EXACT, EXPONENT, LIMBS, OFF, SIGN, WIDTH
from .bigfloat_to_quad import cut_to_fours
from .interpreter import OPERATIONS, SINE_COSINE, STATE_OTHER_BRANCH, STATE_UNDECIDED, STATE_VALID, play
from .schedule import schedule_tape
from .simd_interpreter import play_in_lanes
from .simd_registers import COLUMNS
from .simd_sine_cosine import LANE_CONSTANTS, LANE_TERMS

Longs = npt.NDArray[np.int64]
_AT_ONCE = 4096
_FEWEST = 4
"""Fewer bodies are not worth lanes."""
_MOST = 1 << 16
"""Most registers of a kind in lanes."""
_NUMBERED = {name: number for number, name in enumerate(OPERATIONS)}
_PLACES = 320
"""Binary places of the constants of sines: more than numbers of `bigfloat_kernel` have."""


def bigfloat_row(value: BigFloat) -> Longs:
    """Convert a number to a row (WIDTH,) for kernels; longer numbers are cut, and their error grows."""
    row = np.zeros(WIDTH, np.int64)
    size, exponent, off = abs(value.mantissa), value.exponent, value.off
    less = size.bit_length() - (LIMBS - 1) * BITS
    if less > 0:
        cut = size & ((1 << less) - 1)
        size, exponent, off = size >> less, exponent + less, (off >> less) + (2 if cut or off else 0)
    up = exponent % BITS
    size, off, exponent = size << up, off << up, (exponent - up) // BITS
    while size and not size & ((1 << BITS) - 1) and not off:
        size, exponent = size >> BITS, exponent + 1
    row[SIGN] = -1 if value.mantissa < 0 else 1
    row[OFF] = BITS * exponent + off.bit_length() if off else EXACT
    count = 0
    while size:
        row[count], size, count = size & ((1 << BITS) - 1), size >> BITS, count + 1
    row[COUNT], row[EXPONENT] = count, exponent if count else 0
    return row


def quad_row(value: BigFloat) -> list[float]:
    """Convert a number to four floats and an error, for kernels in lanes; the error is infinite beyond the floats."""
    rest, scale, floats = value.mantissa, value.exponent, []
    for _ in range(COLUMNS - 1):
        try:
            floats.append(_leading(rest, scale))
        except OverflowError:
            return [0.0] * (COLUMNS - 1) + [math.inf]
        part, places = math.frexp(floats[-1])
        digits, unit = int(math.ldexp(part, 53)), places - 53
        finer = max(0, scale - unit)
        rest, scale = (rest << finer) - (digits << (unit - scale + finer)), scale - finer
    error = _leading(abs(rest) + (value.off << (value.exponent - scale)), scale)
    return [*floats, math.nextafter(error, math.inf) + LEAST if rest or value.off else 0.0]


def _leading(digits: int, scale: int) -> float:
    """Return the float nearest to digits · 2^scale, except for the last bit of very long ones. Raises OverflowError."""
    more = max(0, digits.bit_length() - 1000)
    return math.ldexp(float(digits >> more), scale + more)


def _coefficients(terms: int) -> list[BigFloat]:
    """Return the coefficients of the sine's series, from the first on.

    Each is cut to the digits that count beside its power of an angle below 2^-7.
    """
    coefficients = [bigfloat.ONE]
    for k in range(1, terms):
        places = _PLACES - 14 * k
        coefficients.append(BigFloat(((-1) ** k << places) // math.factorial(2 * k + 1), -places, 2))
    return coefficients


@lru_cache(maxsize=1)
def _degree_and_table() -> tuple[BigFloat, list[BigFloat]]:
    """Return pi / 180, and sine and cosine of each multiple of STEP, each by a rotation of the one before."""
    degree = BigFloat(bigfloat.round_shift(bigfloat.pi_fixed_point(bigfloat.BITS) // 180, 64), 64 - bigfloat.BITS, 2)
    places = _PLACES + 64
    s, c = sine, cosine = bigfloat.sin_cos_fixed_point(Fraction(STEP), places)
    table = []
    for _ in range(MULTIPLES):
        table += [BigFloat(bigfloat.round_shift(x, 64), -_PLACES, 2) for x in (s, c)]
        s, c = (s * cosine + c * sine) >> places, (c * cosine - s * sine) >> places
    return degree, table


@lru_cache(maxsize=1)
def _series() -> Longs:
    """Return the table of `bigfloat_functions.sine_cosine`: pi / 180, coefficients from last to first, multiples."""
    degree, table = _degree_and_table()
    rows = degree, *reversed(_coefficients(TERMS)), bigfloat.ZERO, bigfloat.ONE, *table
    return np.array([bigfloat_row(value) for value in rows])


@lru_cache(maxsize=1)
def _lane_series() -> Floats:
    """Return the table of `simd_sine_cosine.sine_cosine_rows`."""
    degree, table = _degree_and_table()
    rows = degree, bigfloat.ONE, *reversed(_coefficients(LANE_TERMS)), bigfloat.ZERO, bigfloat.ONE, *table
    return np.array([quad_row(value) for value in rows])


_NO_SERIES = np.zeros((CONSTANTS, WIDTH), np.int64), np.zeros((LANE_CONSTANTS, COLUMNS))
"""For tapes without a sine, which are most: these tables need not be computed for them."""


@dataclass(frozen=True)
class WideInputs:
    """Wide inputs of bodies: rows of numbers as four floats each, and with more digits where these do not suffice."""

    fours: Floats  # (rows, numbers, COLUMNS)
    digits: Callable[[Ints], Longs]
    """Returns some of the rows with all digits, (rows, numbers, WIDTH)."""


NO_INPUTS = WideInputs(np.zeros((1, 0, COLUMNS)), lambda rows: np.zeros((len(rows), 0, WIDTH), np.int64))


def quads_from_bigfloats(wides: Longs) -> Floats:
    """Convert wide numbers (..., WIDTH) to four floats and an error each, (..., COLUMNS)."""
    rows = np.ascontiguousarray(wides).reshape(-1, WIDTH)
    found = np.empty((len(rows), COLUMNS))
    cut_to_fours(rows, found)
    return found.reshape(*wides.shape[:-1], COLUMNS)


@dataclass
class ProgramResult:
    """The outputs of a recording for some bodies, and for which of them they are valid."""

    floats: Floats  # (bodies, outputs)
    fours: Floats  # (bodies, wide outputs, COLUMNS)
    state: Signs
    recording: TapeProgram

    @property
    def valid(self) -> npt.NDArray[np.bool_]:
        """Bodies whose tests turned out as recorded, with all numbers decided."""
        return np.asarray(self.state == STATE_VALID)

    @property
    def other_branch(self) -> npt.NDArray[np.bool_]:
        """Bodies for which a test turned out otherwise."""
        return np.asarray(self.state == STATE_OTHER_BRANCH)

    @property
    def undecided(self) -> npt.NDArray[np.bool_]:
        """Bodies that need more digits."""
        return np.asarray(self.state == STATE_UNDECIDED)

    def select_valid(self) -> ProgramResult:
        """Select the bodies for which the outputs are valid."""
        valid = self.valid
        if valid.all():
            return self
        fours = self.fours[valid] if len(self.fours) else self.fours
        return ProgramResult(self.floats[valid], fours, self.state[valid], self.recording)


@dataclass(frozen=True)
class TapeProgram:
    """A tape as arrays."""

    code: Ints
    outputs: Ints
    """The registers that hold the outputs."""
    numbers: Floats
    constants: Longs
    wides: int
    plains: int
    wide_outputs: int

    @classmethod
    def of(cls, tape: Tape) -> TapeProgram:
        """Build the arrays from a recorded tape."""
        which, *operands = zip(*schedule_tape(tape), strict=True)
        constants = [bigfloat_row(value) for _, value in tape.constants.values()]
        return cls(
            np.ascontiguousarray(np.array([list(map(_NUMBERED.__getitem__, which)), *operands], np.int32).T),
            np.array(tape.written, np.int32),
            np.array([value for _, value in tape.numbers.values()], np.float64),
            np.array(constants, np.int64).reshape(-1, WIDTH),
            tape.wides,
            tape.plains,
            tape.wide_outputs,
        )

    def play(self, inputs: Floats, wide_in: WideInputs, rows: Ints) -> ProgramResult:
        """Play the recording for bodies with a row of inputs each, and a row of wide inputs.

        In four floats first, and with more digits for the bodies that these leave undecided.
        """
        played = self.in_lanes(inputs, wide_in.fours, rows)
        left = np.flatnonzero(played.undecided)
        if len(left):
            mine, places = unique_with_inverse(rows[left])
            which: Ints = places.astype(np.int32)
            played.floats[left], wides, played.state[left] = self.in_digits(inputs[left], wide_in.digits(mine), which)
            if self.wide_outputs:
                valid = played.valid[left]  # undecided bodies have no numbers
                played.fours[left[valid]] = quads_from_bigfloats(wides[valid])
        return played

    def in_lanes(self, inputs: Floats, wide_in: Floats, rows: Ints) -> ProgramResult:
        """`play` in four floats alone; few bodies, and tapes too long for lanes, stay undecided."""
        count, inputs, rows = len(inputs), np.ascontiguousarray(inputs), np.ascontiguousarray(rows, np.int32)
        floats, state = np.empty((count, len(self.outputs))), np.full(count, STATE_UNDECIDED, np.int8)
        fours = np.empty((count if self.wide_outputs else 0, self.wide_outputs, COLUMNS))
        if count >= _FEWEST and max(self.wides, self.plains) <= _MOST:
            series = _lane_series() if self._turns else _NO_SERIES[1]
            for begin in range(0, count, _AT_ONCE):  # Ctrl-C takes effect between calls
                play_in_lanes(
                    self.code, self.outputs, self.numbers, self._lane_constants, series, inputs, wide_in, rows, floats,
                    fours, state, self.wides, self.plains, begin, min(count, begin + _AT_ONCE),
                )  # fmt: skip
        return ProgramResult(floats, fours, state, self)

    @cached_property
    def _turns(self) -> bool:
        """Does it compute sines?"""
        return bool((self.code[:, 0] == SINE_COSINE).any())

    @cached_property
    def _lane_constants(self) -> Floats:
        """The constants in four floats."""
        return quads_from_bigfloats(self.constants)

    def in_digits(self, inputs: Floats, wide_in: Longs, rows: Ints) -> tuple[Floats, Longs, Signs]:
        """Play with numbers of 253 bits and more alone; return outputs, wide outputs (..., WIDTH), and states."""
        count, inputs, rows = len(inputs), np.ascontiguousarray(inputs), np.ascontiguousarray(rows, np.int32)
        floats, state = np.empty((count, len(self.outputs))), np.zeros(count, np.int8)
        wides = np.empty((count if self.wide_outputs else 0, self.wide_outputs, WIDTH), np.int64)
        series = _series() if self._turns else _NO_SERIES[0]
        for begin in range(0, count, _AT_ONCE):
            play(
                self.code, self.outputs, self.numbers, self.constants, series, inputs, wide_in, rows, floats, wides,
                state, self.wides, self.plains, begin, min(count, begin + _AT_ONCE),
            )  # fmt: skip
        return floats, wides, state
