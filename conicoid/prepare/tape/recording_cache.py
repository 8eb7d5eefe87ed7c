"""The recordings of this process: for each kind a few, as tests of numbers turn out one way or the other."""

from __future__ import annotations

from collections.abc import Callable, Hashable
from typing import Any

import numpy as np

from ..._util.fork_safe_locks import fork_safe_lock
from ...kernels.tables import Floats, Ints, Longs
from ...numerics.tracing import Tape
from .program import ProgramResult, TapeProgram, WideInputs

FEWEST = 8
"""Shapes of one kind that are worth a new recording, which takes as long as some of them alone."""
_MOST = 48
"""Recordings of one kind."""


class RecordingCache:
    """What has been recorded in this process, by what it is of. None: it cannot be recorded."""

    def __init__(self) -> None:
        self._of: dict[Hashable, list[tuple[Any, TapeProgram]] | None] = {}
        self._lock = fork_safe_lock()

    def play(
        self, key: Hashable, record: Callable[[int, Tape], Any], inputs: Floats, given: WideInputs, rows: Ints
    ) -> tuple[list[tuple[Any, Longs, ProgramResult]], Longs]:
        """(what recordings were of, for which rows of inputs they held, what they gave), and the rows that are left.

        `record(row, tape)` works one out on a tape.
        """
        with self._lock:
            found = self._of.setdefault(key, [])
            results: list[tuple[Any, Longs, ProgramResult]] = []
            left, open_, number = np.arange(len(inputs)), [], 0
            while len(left) and found is not None:
                if number == len(found):
                    if len(left) < FEWEST or number == _MOST:
                        break
                    try:
                        tape = Tape()
                        made = record(int(left[0]), tape)
                        found.append((made, TapeProgram.of(tape)))
                    except Exception:  # it looks at numbers in ways that leave no trace, or says alone what is wrong
                        self._of[key] = None
                        break
                what, recording = found[number]
                played = recording.play(inputs[left], given, rows[left])
                if played.held.any():
                    results.append((what, left[played.held], played.kept()))
                open_.append(left[played.open])
                left = left[played.elsewhere]
                number += 1
            return results, np.concatenate([left, *open_])


RECORDINGS = RecordingCache()
