"""Recordings: tapes as kernels take them, and what playing them gives."""

from __future__ import annotations

import math
from dataclasses import dataclass
from functools import lru_cache

import numpy as np
import numpy.typing as npt

from ...shapes import number, sines
from ...shapes.number import Number
from ...shapes.recorder import Tape
from ..tables import Floats, Ints, Signs
from .order import in_order
from .roots import CONSTANTS, MULTIPLES, STEP, TERMS
from .tape import ELSEWHERE, HELD, OPEN, OPERATIONS, SINE_COSINE, play
from .wide import BITS, COUNT, EXACT, EXPONENT, LIMBS, OFF, SIGN, WIDTH

Longs = npt.NDArray[np.int64]
_AT_ONCE = 4096
_PLACES = 320
"""Binary places of what sines are made of, which are more than numbers of `wide` have."""


def wide_row(value: Number) -> Longs:
    """A number as kernels take it; cut where it is longer."""
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


@lru_cache(maxsize=1)
def _series() -> Longs:
    """What `roots.sine_cosine` needs: pi / 180, the coefficients of the sine from the last one to the first, the table.

    A coefficient is cut to what counts beside its power of an angle below 2^-7.
    """
    coefficients, factor = [], number.ONE
    for k in range(TERMS):
        places = _PLACES - 14 * k
        coefficients.append(Number(math.floor(number.fraction(factor) * 2**places), -places, 2))
        factor = -factor / ((2 * k + 2) * (2 * k + 3))
    with sines.mpmath_of(number.BITS) as mp:
        degree = sines.of_mpmath(mp.pi / 180, number.BITS - 64)
    with sines.mpmath_of(_PLACES + 64) as mp:
        angles = [mp.mpf(STEP) * k * mp.pi / 180 for k in range(1, MULTIPLES + 1)]
        table = [sines.of_mpmath(value, _PLACES) for angle in angles for value in reversed(mp.cos_sin(angle))]
    coefficients[0] = number.ONE
    rows = degree, *reversed(coefficients), number.ZERO, number.ONE, *table
    return np.array([wide_row(value) for value in rows])


_NO_SERIES = np.zeros((CONSTANTS, WIDTH), np.int64)
"""For tapes without a sine, which are most: it takes mpmath to find the others."""


@dataclass
class Played:
    """What a recording gave for some bodies, and for which of them it held."""

    floats: Floats  # (bodies, outputs)
    wides: Longs  # (bodies, outputs, WIDTH)
    state: Signs

    @property
    def held(self) -> npt.NDArray[np.bool_]:
        """Those whose tests turned out as recorded, and whose numbers were settled."""
        return np.asarray(self.state == HELD)

    @property
    def elsewhere(self) -> npt.NDArray[np.bool_]:
        """Those of which a test turned out otherwise."""
        return np.asarray(self.state == ELSEWHERE)

    @property
    def open(self) -> npt.NDArray[np.bool_]:
        """Those that need more digits."""
        return np.asarray(self.state == OPEN)

    def kept(self) -> Played:
        """Only those for which it held."""
        held = self.held
        if held.all():
            return self
        return Played(self.floats[held], self.wides[held] if len(self.wides) else self.wides, self.state[held])


@dataclass(frozen=True)
class Recording:
    """A tape in arrays."""

    code: Ints
    written: Ints
    """The registers that are the outputs."""
    numbers: Floats
    constants: Longs
    wides: int
    plains: int
    wide_outputs: int

    @classmethod
    def of(cls, tape: Tape) -> Recording:
        """From what was recorded."""
        code = [(OPERATIONS.index(which), *operands) for which, *operands in in_order(tape)]
        constants = [wide_row(value) for _, value in tape.constants.values()]
        return cls(
            np.array(code, np.int32).reshape(-1, 5),
            np.array(tape.written, np.int32),
            np.array([value for _, value in tape.numbers.values()], np.float64),
            np.array(constants, np.int64).reshape(-1, WIDTH),
            tape.wides,
            tape.plains,
            tape.wide_outputs,
        )

    def play(self, inputs: Floats, given: Longs, rows: Ints) -> Played:
        """Work it out for bodies that have a row of inputs each, and one of the given numbers."""
        count = len(inputs)
        floats = np.empty((count, len(self.written)))
        wides = np.empty((count if self.wide_outputs else 0, self.wide_outputs, WIDTH), np.int64)
        state = np.zeros(count, np.int8)
        series = _series() if (self.code[:, 0] == SINE_COSINE).any() else _NO_SERIES
        inputs, rows = np.ascontiguousarray(inputs), np.ascontiguousarray(rows, np.int32)
        for begin in range(0, count, _AT_ONCE):  # Ctrl-C is heard in between
            play(
                self.code, self.written, self.numbers, self.constants, series, inputs, given, rows, floats, wides,
                state, self.wides, self.plains, begin, min(count, begin + _AT_ONCE),
            )  # fmt: skip
        return Played(floats, wides, state)
