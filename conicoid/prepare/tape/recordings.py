"""Recordings: tapes as arrays that the interpreter takes, their schedule, and the results of playing them.

`RecordingCache` keeps the recordings of the process.
"""

from __future__ import annotations

import math
from collections.abc import Callable, Hashable
from dataclasses import field
from fractions import Fraction
from functools import cached_property, lru_cache
from typing import Any

import numpy as np
import numpy.typing as npt

from ..._util.process import fork_safe_lock
from ..._util.records import dataclass
from ...kernels.numbers.quad_double import LEAST
from ...kernels.tables import Floats, Ints, Longs, Signs
from ...kernels.threads import KernelRange, run_chunks
from ...numerics import bigfloat
from ...numerics.bigfloat import BigFloat
from ...numerics.tracing import Operation, Tape
from .interpreter import OPERATIONS, SINE_COSINE, play
from .registers import COLUMNS, CONSTANTS, MULTIPLES, STATE_OTHER_BRANCH, STATE_UNDECIDED, STATE_VALID, STEP, TERMS

_AT_ONCE = 512  # bodies that a thread takes at a time; each takes some microseconds
_MOST = 1 << 16
"""Most registers of a kind."""
_NUMBERED = {name: number for number, name in enumerate(OPERATIONS)}
_PLACES = 320
"""Binary places of the constants of sines: more than four floats hold."""


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


@lru_cache(maxsize=1)
def _series() -> Floats:
    """Return the table of `sine_cosine_rows`: pi / 180, 1, coefficients from last to first, multiples of STEP.

    Coefficients of the sine are cut to the digits that count beside their powers of an angle below 2^-7. Sine and
    cosine of each multiple are computed by a rotation of the one before.
    """
    coefficients = [bigfloat.ONE]
    for k in range(1, TERMS):
        places = _PLACES - 14 * k
        coefficients.append(BigFloat(((-1) ** k << places) // math.factorial(2 * k + 1), -places, 2))
    degree = BigFloat(bigfloat.round_shift(bigfloat.pi_fixed_point(bigfloat.BITS) // 180, 64), 64 - bigfloat.BITS, 2)
    places = _PLACES + 64
    s, c = sine, cosine = bigfloat.sin_cos_fixed_point(Fraction(STEP), places)
    table = []
    for _ in range(MULTIPLES):
        table += [BigFloat(bigfloat.round_shift(x, 64), -_PLACES, 2) for x in (s, c)]
        s, c = (s * cosine + c * sine) >> places, (c * cosine - s * sine) >> places
    rows = degree, bigfloat.ONE, *reversed(coefficients), bigfloat.ZERO, bigfloat.ONE, *table
    return np.array([quad_row(value) for value in rows])


_NO_SERIES = np.zeros((CONSTANTS, COLUMNS))
"""For tapes without a sine, which are most: the table need not be computed for them."""
NO_INPUTS = np.zeros((1, 0, COLUMNS))
"""For tapes without wide inputs."""


@dataclass
class ProgramResult:
    """The outputs of a recording for some bodies, and for which of them they are valid."""

    floats: Floats  # (bodies, outputs)
    fours: Floats  # (bodies, wide outputs, COLUMNS)
    state: Signs

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
        return ProgramResult(self.floats[valid], fours, self.state[valid])


@dataclass(frozen=True)
class TapeProgram:
    """A tape as arrays."""

    code: Ints
    outputs: Ints
    """The registers that hold the outputs."""
    numbers: Floats
    constants: Floats
    wides: int
    plains: int
    wide_outputs: int

    @classmethod
    def of(cls, tape: Tape) -> TapeProgram:
        """Build the arrays from a recorded tape."""
        which, *operands = zip(*schedule_tape(tape), strict=True)
        constants = [quad_row(value) for _, value in tape.constants.values()]
        return cls(
            np.ascontiguousarray(np.array([list(map(_NUMBERED.__getitem__, which)), *operands], np.int32).T),
            np.array(tape.written, np.int32),
            np.array([value for _, value in tape.numbers.values()], np.float64),
            np.array(constants, np.float64).reshape(-1, COLUMNS),
            tape.wides,
            tape.plains,
            tape.wide_outputs,
        )

    def play(self, inputs: Floats, wide_in: Floats, rows: Ints) -> ProgramResult:
        """Play the recording for bodies with a row of inputs each, and a row of wide inputs.

        Where a tape is too long for the registers, all bodies stay undecided.
        """
        count, inputs, rows = len(inputs), np.ascontiguousarray(inputs), np.ascontiguousarray(rows, np.int32)
        floats, state = np.empty((count, len(self.outputs))), np.full(count, STATE_UNDECIDED, np.int8)
        fours = np.empty((count if self.wide_outputs else 0, self.wide_outputs, COLUMNS))
        if max(self.wides, self.plains) <= _MOST:
            series = _series() if self._turns else _NO_SERIES
            arguments = (
                self.code, self.outputs, self.numbers, self.constants, series, inputs, wide_in, rows, floats, fours,
                state, self.wides, self.plains,
            )  # fmt: skip
            run_chunks(KernelRange(play, arguments, ()), count, _AT_ONCE)
        return ProgramResult(floats, fours, state)

    @cached_property
    def _turns(self) -> bool:
        """Does it compute sines?"""
        return bool((self.code[:, 0] == SINE_COSINE).any())


# The schedule: tests as early as possible, and nothing that is not needed
#
# A body for which a tape is not valid then costs little. Tests stay in their order, and no operation moves ahead of a
# test that preceded it, so what a test guards stays guarded.

_TESTS = ("sign", "plain sign", "turn")
_WIDE, _PLAIN = 0, 1
_NONE = ("constant", "given", "input", "number")
_OF_A_WIDE = ("root", "negate", "size", "round", "sign", "write wide")
_OF_WIDES = ("add", "subtract", "multiply", "divide", "ball")
_OF_A_PLAIN = (
    "widen", "sine and cosine", "plain root", "plain negate", "plain size", "above", "power", "unit sign", "plain sign",
    "turn",
)  # fmt: skip
_READS = {
    **dict.fromkeys(_NONE, (_PLAIN, 0)),
    **dict.fromkeys(_OF_A_WIDE, (_WIDE, 1)),
    **dict.fromkeys(_OF_WIDES, (_WIDE, 2)),
    **dict.fromkeys(_OF_A_PLAIN, (_PLAIN, 1)),
    "several": (_PLAIN, 3),
}
"""The kind of an operation's operands, and their count; other operations read two plain ones."""


def schedule_tape(tape: Tape) -> list[Operation]:
    """Return the needed operations of a tape, in the order in which they are played."""
    code, makers = tape.code, (tape.wide_makers, tape.plain_makers)
    order: list[int] = []
    placed = bytearray(len(code))

    def take(place: int) -> None:
        """Add an operation after all that it needs, in the order of the tape."""
        needed, placed[place] = [place], 1
        for each in needed:  # grows in the loop
            operation = code[each]
            kind, count = _READS.get(operation[0], (_PLAIN, 2))
            for register in operation[2:][:count]:
                before = makers[kind][register]
                if not placed[before]:
                    placed[before] = 1
                    needed.append(before)
        needed.sort()
        order.extend(needed)

    for place, operation in enumerate(code):
        if operation[0] in _TESTS:
            take(place)
    for place, operation in enumerate(code):
        if operation[0] == "write wide":
            take(place)
    for register in tape.written:
        place = tape.plain_makers[register]
        if not placed[place]:
            take(place)
    return [code[place] for place in order]


# Recordings of this process: a few for each kind, because comparisons of numbers turn out one way or the other

FEWEST = 8
"""A new recording needs at least so many shapes of a kind: it takes as long as some of them lowered singly."""
_MOST_RECORDINGS = 48
"""Most recordings of one kind."""
_MOST_DOUBLINGS = 4
"""However often a kind has failed, 16 times `FEWEST` of its bodies are tried again."""
_MOST_FAILURES = 2
"""After so many bodies without a recording, the rest of a call is left as well."""


@dataclass
class _Recordings:
    """The recordings of a key, and how many tries to make one failed since the last that did not."""

    made: list[tuple[Any, TapeProgram]] = field(default_factory=list)
    failures: int = 0


class RecordingCache:
    """The recordings of a process, by key."""

    def __init__(self) -> None:
        self._of: dict[Hashable, _Recordings] = {}
        self._lock = fork_safe_lock()

    def play(
        self, key: Hashable, record: Callable[[int, Tape], Any], inputs: Floats, wide_in: Floats, rows: Ints
    ) -> tuple[list[tuple[Any, Longs, ProgramResult]], Longs]:
        """Play the recordings of a key, and make new ones where enough rows are left.

        Parameters
        ----------
        key : Hashable
            What the recordings are of.
        record : Callable[[int, Tape], Any]
            `record(row, tape)` evaluates the formula for a row of inputs on a tape; its result goes with the recording.
        inputs : Floats
            (n, inputs) numbers of each body.
        wide_in : Floats
            Wide inputs, by rows (rows, numbers, 5): four floats and an error each.
        rows : Ints
            (n,) the row of wide inputs of each body.

        Returns
        -------
        list[tuple[Any, Longs, ProgramResult]]
            (result of `record`, rows for which the recording is valid, their outputs).
        Longs
            The rows that are left.
        """
        with self._lock:
            recordings = self._of.setdefault(key, _Recordings())
            results: list[tuple[Any, Longs, ProgramResult]] = []
            left, undecided, number, failed = np.arange(len(inputs)), [], 0, 0
            while len(left):
                if number == len(recordings.made):
                    # A try costs as much as some bodies lowered singly: after a failure it takes twice as many
                    fewest = FEWEST << min(recordings.failures, _MOST_DOUBLINGS)
                    if len(left) < fewest or number == _MOST_RECORDINGS or failed == _MOST_FAILURES:
                        break
                    try:
                        tape = Tape()
                        result = record(int(left[0]), tape)
                        recordings.made.append((result, TapeProgram.of(tape)))
                        recordings.failures = 0
                    except Exception:  # it inspects numbers untraceably, or single lowering reports what is wrong
                        recordings.failures, failed = recordings.failures + 1, failed + 1
                        undecided.append(left[:1])  # of this body; the next may have a recording
                        left = left[1:]
                        continue
                label, recording = recordings.made[number]
                played = recording.play(inputs[left], wide_in, rows[left])
                if played.valid.any():
                    results.append((label, left[played.valid], played.select_valid()))
                undecided.append(left[played.undecided])
                left = left[played.other_branch]
                number += 1
            return results, np.concatenate([left, *undecided])


RECORDINGS = RecordingCache()
