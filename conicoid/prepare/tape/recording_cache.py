"""Recordings of this process: a few for each kind, because comparisons of numbers turn out one way or the other."""

from __future__ import annotations

from collections.abc import Callable, Hashable
from dataclasses import field
from typing import Any

import numpy as np

from ..._util.dataclass import dataclass
from ..._util.process import fork_safe_lock
from ...kernels.tables import Floats, Ints, Longs
from ...numerics.tracing import Tape
from .program import ProgramResult, TapeProgram

FEWEST = 8
"""A new recording needs at least so many shapes of a kind: it takes as long as some of them lowered singly."""
_MOST = 48
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
                    if len(left) < fewest or number == _MOST or failed == _MOST_FAILURES:
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
