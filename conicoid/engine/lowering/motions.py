"""The motions of many shapes, each worked out once: by recordings, or alone."""

from __future__ import annotations

from collections.abc import Hashable, Sequence
from dataclasses import dataclass, field
from typing import Any

import numpy as np

from ...shapes import exact as ex
from ...shapes.motion import Affine, Motion, Step
from ...shapes.recorder import Tape
from ..tables import Floats, Longs
from ..tapes.play import wide_row
from ..tapes.wide import WIDTH
from . import recordings
from .pattern import FRAME_NUMBERS
from .said import again, said

NO_NUMBERS = np.zeros((1, 0, WIDTH), np.int64)


@dataclass(frozen=True)
class Known:
    """A step that is known by what it does: a whole chain of them, worked out before."""

    forth_and_back: tuple[Affine, Affine]
    factor: ex.Exact | None

    def similarity(self) -> ex.Exact | None:
        """The factor of all lengths, if there is one."""
        return self.factor


@dataclass
class Motions:
    """The motions of many shapes, each once: their products, inverses and factors in numbers of 253 bits and more."""

    known: dict[tuple[Step, ...], int] = field(default_factory=dict)
    uses: list[int] = field(default_factory=list)

    def row(self, steps: tuple[Step, ...], uses: int = 1) -> int:
        """The number of a motion, which so many more shapes have."""
        row = self.known.setdefault(steps, len(self.known))
        if row == len(self.uses):
            self.uses.append(0)
        self.uses[row] += uses
        return row

    def work_out(self) -> tuple[Longs, list[bool | None], Floats]:
        """(motions, 25, WIDTH) wide numbers; of each, whether it is a similarity, and None where that is not known.

        And (motions, 12), the rows of the inverse, rounded.
        """
        table = np.zeros((len(self.known), 25, WIDTH), np.int64)
        kinds: list[bool | None] = [None] * len(self.known)
        back = np.full((len(self.known), FRAME_NUMBERS), np.nan)
        like: dict[Hashable, tuple[list[int], list[list[float]], list[tuple[Step, ...]]]] = {}
        few: set[int] = set()  # of which there are too few for a recording
        for steps, row in self.known.items():
            told = [said(step) for step in steps]
            if all(one is not None for one in told):
                form = tuple(one.form for one in told if one is not None)
                rows, numbers, all_steps = like.setdefault(form, ([], [], []))
                rows.append(row)
                numbers.append([x for one in told if one is not None for x in one.numbers])
                all_steps.append(steps)
        for kind, (rows, numbers, all_steps) in like.items():

            def record(which: int, tape: Tape, all_steps: list[tuple[Step, ...]] = all_steps) -> bool:
                motion = Motion(tuple(again(step, tape) for step in all_steps[which]))
                for linear, shift in (motion.affine, motion.inverse):
                    for number in (*(x for line in linear for x in line), *shift):
                        tape.write_wide(number)
                for row in motion.inverse_rows:
                    for entry in row:
                        tape.write(entry)
                factor = motion.similarity
                if factor is not None:
                    tape.write_wide(factor)
                return factor is not None

            inputs = np.array(numbers).reshape(len(rows), -1)
            results, left = recordings.RECORDINGS.play(
                ("motion", kind), record, inputs, NO_NUMBERS, np.zeros(len(rows), np.int32)
            )
            for similar, which, played in results:
                at = np.array(rows)[which]
                table[at, : 24 + similar] = played.wides
                back[at] = played.floats
                for row in at.tolist():
                    kinds[row] = similar
            for which in left.tolist() if len(left) < recordings.FEWEST else ():
                few.add(rows[which])
        for steps, row in self.known.items():
            if kinds[row] is None and (
                row in few or self.uses[row] >= recordings.FEWEST
            ):  # those of a body, or of many shapes
                kinds[row], table[row], back[row] = _worked_out_motion(Motion(steps))
        return table, kinds, back


def _worked_out_motion(motion: Motion) -> tuple[bool, Longs, Any]:
    """A row of each of the three that `Motions.work_out` gives, by arithmetic of 3,000 bits."""
    wides = np.zeros((25, WIDTH), np.int64)
    numbers = [x for linear, shift in (motion.affine, motion.inverse) for line in (*linear, shift) for x in line]
    factor = motion.similarity
    for row, number in enumerate([*numbers, *(() if factor is None else (factor,))]):
        wides[row] = wide_row(ex.exact(number))
    return factor is not None, wides, np.array(motion.inverse_rows).ravel()


def given_motion(tape: Tape, similar: bool, motion: Motion) -> Motion:
    """A motion whose numbers come with each body."""

    def take(values: Sequence[ex.Exact], first: int) -> Any:
        return tuple(tape.given(value, first + k) for k, value in enumerate(values))

    def taken(affine: Affine, first: int) -> Affine:
        rows, shift = affine
        x, y, z = (take(row, first + 3 * k) for k, row in enumerate(rows))
        return (x, y, z), take(shift, first + 9)

    factor = motion.similarity
    forth_and_back = taken(motion.affine, 0), taken(motion.inverse, 12)
    known = Known(forth_and_back, tape.given(factor, 24) if similar and factor is not None else None)
    return Motion((known,))  # type: ignore[arg-type]
