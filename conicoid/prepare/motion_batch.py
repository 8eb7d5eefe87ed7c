"""Compute the motions of many shapes, each once: by tapes, or one by one.

`MotionBatch` gives products, inverses and similarity factors; `PointPlaneMover` carries points and planes.
"""

from __future__ import annotations

from collections.abc import Callable, Hashable, Sequence
from dataclasses import field
from functools import cached_property
from typing import Any

import numpy as np

from .._util.records import dataclass
from ..geometry.surface import PlaneSurface
from ..geometry.transform import Affine, Motion, Rotate, Step, Translate
from ..kernels.tables import PLANE_SIZE, Floats, Ints, Longs, Signs
from ..numerics import bigfloat as ex
from ..numerics.tracing import Tape
from .assembly import round_numbers, round_surface, rounding_rests
from .pattern import FRAME_NUMBERS
from .pytree import flatten, flatten_all, positions_by_key, unflatten
from .tape import recordings
from .tape.recordings import NO_INPUTS, quad_row
from .tape.registers import COLUMNS

_TRANSLATE = {Translate}
_NUMBERS = 34
"""Numbers of a motion: forward and inverse (12 each), the factor of a similarity, and those of an `_InputTurn`."""
_TURN = 25
"""The first number of an `_InputTurn`."""
UNKNOWN_MOTION, AFFINITY, SIMILARITY, TURN = -1, 0, 1, 2
"""Kinds of motions. A turn is a rotation about a slanted axis, with a translation before it and after it at most."""


@dataclass(frozen=True)
class KnownStep:
    """A whole chain of steps, known by its maps and its similarity factor."""

    forth_and_back: tuple[Affine, Affine]
    factor: ex.BigFloat | None

    def similarity(self) -> ex.BigFloat | None:
        """Return the factor of all lengths, or None."""
        return self.factor


class _InputTurn(Motion):
    """A motion of the kind `TURN` whose numbers are inputs: it leaves points of its axis in place, without rounding.

    So the ends of a cylinder that is turned about itself are floats, which products with a matrix cannot show.
    """

    def __init__(self, known: KnownStep, parts: tuple[ex.Row, ex.Row, ex.Row]) -> None:
        super().__init__((known,))  # type: ignore[arg-type]
        vars(self)["_turn"] = parts

    def carried(self, point: ex.Row) -> ex.Row:
        """Return the image of a point."""
        axis, before, after = vars(self)["_turn"]
        start = ex.plus(point, before)
        # R p = p - (R - 1) (k × (k × p)) / k·k, since R k = k
        aside, size = ex.cross(axis, ex.cross(axis, start)), ex.dot(axis, axis)
        x, y, z = ex.minus(ex.apply(self.affine[0], aside), aside)
        return ex.plus(ex.minus(start, (x / size, y / size, z / size)), after)


@dataclass
class _MotionForm:
    """Motions of one structure: their parameters and steps, and parameters -> row, in that order."""

    rows: dict[bytes, int] = field(default_factory=dict)
    numbers: list[Floats] = field(default_factory=list)
    steps: list[tuple[Step, ...]] = field(default_factory=list)


class MotionChains:
    """The steps that move many shapes, and their classification."""

    def __init__(self, steps: Sequence[tuple[Step, ...]]) -> None:
        self.steps = steps

    @cached_property
    def translations(self) -> Ints:
        """(n,) the number of steps where all of them translate; else -1."""
        return np.array(list(map(count_translations, self.steps)), np.int32)

    @cached_property
    def rows(self) -> dict[MotionBatch, Ints]:
        """For each batch the rows of the motions that it was given; -1 for others."""
        return {}


class MotionBatch:
    """The motions of many shapes, each once: products, inverses and factors in numbers of four floats."""

    def __init__(self) -> None:
        self._steps: list[tuple[Step, ...]] = []
        self._forms: dict[Hashable, _MotionForm] = {}
        self._opaque: dict[tuple[Step, ...], int] = {}  # motions with more than numbers
        self._uses: list[tuple[Ints, int]] = []

    def row(self, steps: tuple[Step, ...], uses: int = 1) -> int:
        """Return the row of a motion, and count `uses` more shapes with it."""
        self._uses.append((self._rows([steps]), uses))
        return int(self._uses[-1][0][0])

    def rows(self, chains: MotionChains, which: Longs) -> Ints:
        """Return the rows of some motions, and count one more shape for each."""
        known = chains.rows.setdefault(self, np.full(len(chains.steps), -1, np.int32))
        fresh = which[known[which] < 0]
        known[fresh] = self._rows([chains.steps[k] for k in fresh.tolist()])
        found: Ints = known[which]
        self._uses.append((found, 1))
        return found

    def _rows(self, chains: Sequence[tuple[Step, ...]]) -> Ints:
        numbers = np.full(len(chains), -1, np.int32)
        for kinds, places in positions_by_key([tuple(map(type, steps)) for steps in chains]).items():
            some = [chains[place] for place in places] if len(places) < len(chains) else chains
            numbers[places] = self._rows_of_types(some, len(kinds))
        return numbers

    def _rows_of_types(self, chains: Sequence[tuple[Step, ...]], length: int) -> list[int]:
        """`_rows` of motions whose steps have the same types."""
        forms: list[Hashable] = []
        columns, branches = [np.zeros((len(chains), 0))], np.zeros(len(chains), np.int64)
        for step in range(length):
            group = flatten_all([steps[step] for steps in chains])
            # Steps with something beside numbers, or of several structures, have no common columns
            if len(group) != 1 or len(group[0].which) < len(chains):
                return [self._row_of_one(steps) for steps in chains]
            forms.append(group[0].form)
            columns.append(group[0].numbers)
            if isinstance(chains[0][step], Rotate):
                branches = branches * _BRANCHES + _turn_branches(group[0].numbers)
        return self._known_rows(tuple(forms), np.concatenate(columns, axis=1), chains, branches)

    def _row_of_one(self, steps: tuple[Step, ...]) -> int:
        """Return the row of one motion, whose steps may hold more than numbers."""
        flat = [flatten(step) for step in steps]
        if any(one is None for one in flat):
            row = self._opaque.setdefault(steps, len(self._steps))
            # setdefault returned the number that a new row gets
            if row == len(self._steps):
                self._steps.append(steps)
            return row
        form, branch = tuple(one.form for one in flat if one is not None), np.zeros(1, np.int64)
        numbers = [x for one in flat if one is not None for x in one.numbers]
        for step, one in zip(steps, flat, strict=True):
            if isinstance(step, Rotate) and one is not None:
                branch = branch * _BRANCHES + _turn_branches(np.array([one.numbers]))
        return self._known_rows(form, np.array([numbers]), [steps], branch)[0]

    def _known_rows(
        self, form: Hashable, numbers: Floats, chains: Sequence[tuple[Step, ...]], branches: Longs
    ) -> list[int]:
        """Return the rows of motions of one structure; zeros of both signs count as equal.

        Motions of different `branches` need different recordings.
        """
        if (branches != branches[0]).any():
            rows = np.zeros(len(chains), np.int64)
            for some in positions_by_key(branches.tolist()).values():
                rows[some] = self._known_rows(form, numbers[some], [chains[k] for k in some], branches[some])
            return rows.tolist()
        # Adding 0.0 turns -0.0 into 0.0: motions that differ in these signs only are equal.
        known, raw, width = (
            self._forms.setdefault((form, int(branches[0])), _MotionForm()),
            (numbers + 0.0).tobytes(),
            8 * numbers.shape[1],
        )
        keys = [raw[at : at + width] for at in range(0, len(raw), width)] if width else [b""] * len(chains)
        fresh = [key for key in dict.fromkeys(keys) if key not in known.rows]
        if fresh:
            # Reversed, so that the first position of each key wins.
            first = dict(zip(reversed(keys), range(len(keys) - 1, -1, -1), strict=True))
            new = list(map(first.__getitem__, fresh))
            known.rows.update(zip(fresh, range(len(self._steps), len(self._steps) + len(fresh)), strict=True))
            known.numbers.append(numbers[new])
            known.steps += [chains[place] for place in new]
            self._steps += known.steps[-len(new) :]
        return list(map(known.rows.__getitem__, keys))

    def compute(self) -> tuple[Floats, Signs, Floats]:
        """Compute all motions.

        Returns
        -------
        Floats
            (motions, 34, 5) the numbers of each motion, as four floats and an error.
        Signs
            (motions,) the kinds of motions.
        Floats
            (motions, 12) the rows of the inverses, rounded; NaN where not known.
        """
        count = len(self._steps)
        table, kinds = np.zeros((count, _NUMBERS, COLUMNS)), np.full(count, -1, np.int8)
        back, few = np.full((count, FRAME_NUMBERS), np.nan), np.zeros(count, bool)
        for form, motions in self._forms.items():
            rows, numbers = (
                np.fromiter(motions.rows.values(), np.int64, len(motions.rows)),
                np.concatenate(motions.numbers),
            )

            def record(which: int, tape: Tape, steps: list[tuple[Step, ...]] = motions.steps) -> bool:
                return _record_motion(steps[which], tape)

            results, left = recordings.RECORDINGS.play(
                ("motion", form), record, numbers, NO_INPUTS, np.zeros(len(rows), np.int32)
            )
            for similar, which, played in results:
                at = rows[which]
                table[at, : _TURN - 1 + similar] = played.fours
                back[at], kinds[at] = played.floats, similar
            # Few undecided motions are computed exactly below, however rarely used; of many, only those of many shapes.
            if len(left) < recordings.FEWEST:  # fewer than a recording is worth
                few[rows[left]] = True
        uses = np.zeros(count, np.int64)
        for found, each in self._uses:
            uses += each * np.bincount(found, minlength=count)
        for row in np.flatnonzero((kinds < 0) & (few | (uses >= recordings.FEWEST))).tolist():
            # Exact arithmetic, for one shape or many
            kinds[row], table[row], back[row] = _exact_motion_rows(Motion(self._steps[row]))
        for motions in self._forms.values():
            rows = np.fromiter(motions.rows.values(), np.int64, len(motions.rows))
            turns = _turns(motions.steps)
            is_turn = (kinds[rows] == SIMILARITY) & ((turns[:, :3] != 0).sum(axis=1) > 1)
            table[rows[is_turn], _TURN:, 0] = turns[is_turn]
            kinds[rows[is_turn]] = TURN
        return table, kinds, back


_BRANCHES = 13 * 8
"""How many numbers `_turn_branches` can give."""


def _turn_branches(turns: Floats) -> Longs:
    """Number (axis, degrees) of turns (n, 4) by zeros of the axis and by which multiple of 30 degrees they are, if any.

    A recording serves turns of one number, and a process keeps a limited count of recordings of a kind.
    """
    count = np.floor(turns[:, 3] / 30.0 + 0.5)
    multiple = np.where(count * 30.0 == turns[:, 3], np.mod(count, 12.0), 12.0).astype(np.int64)
    return multiple * 8 + (turns[:, :3] != 0.0) @ (1, 2, 4)


def _turns(chains: Sequence[tuple[Step, ...]]) -> Floats:
    """Return (n, 9) the axis of each chain's rotation, to a scale, and the offsets before and after; zeros for none."""
    types = list(map(type, chains[0]))
    turns = np.zeros((len(chains), 3, 3))
    if types.count(Rotate) == 1 and set(types) <= {Rotate, Translate}:
        at = types.index(Rotate)
        if at <= 1 and len(types) <= at + 2:
            axes = np.array([steps[at].axis for steps in chains])  # type: ignore[union-attr]
            turns[:, 0] = np.ldexp(axes, -np.frexp(np.abs(axes).max(axis=1))[1][:, None])
            if at:
                turns[:, 1] = [steps[0].offset for steps in chains]  # type: ignore[union-attr]
            if len(types) > at + 1:
                turns[:, 2] = [steps[-1].offset for steps in chains]  # type: ignore[union-attr]
    return turns.reshape(-1, 9)


def count_translations(steps: tuple[Step, ...]) -> int:
    """Count the steps if all of them translate; else return -1."""
    return len(steps) if not steps or set(map(type, steps)) == _TRANSLATE else -1


def _record_motion(steps: tuple[Step, ...], tape: Tape) -> bool:
    """Compute a motion on a tape; return whether it is a similarity."""
    motion = Motion(tuple(unflatten(step, tape) for step in steps))
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


def _exact_motion_rows(motion: Motion) -> tuple[bool, Floats, Any]:
    """Return a row of each of the three results of `MotionBatch.compute`, by arithmetic of 3,000 bits."""
    fours = np.zeros((_NUMBERS, COLUMNS))
    numbers = [x for linear, shift in (motion.affine, motion.inverse) for line in (*linear, shift) for x in line]
    factor = motion.similarity
    for row, number in enumerate([*numbers, *(() if factor is None else (factor,))]):
        fours[row] = quad_row(ex.exact(number))
    return factor is not None, fours, np.array(motion.inverse_rows).ravel()


def input_motion(tape: Tape, kind: int, motion: Motion) -> Motion:
    """Return a motion of a kind whose numbers are inputs of each body."""

    def take(values: Sequence[ex.BigFloat], first: int) -> Any:
        return tuple(tape.add_input(value, first + k) for k, value in enumerate(values))

    def taken(affine: Affine, first: int) -> Affine:
        rows, shift = affine
        x, y, z = (take(row, first + 3 * k) for k, row in enumerate(rows))
        return (x, y, z), take(shift, first + 9)

    factor = motion.similarity
    forth_and_back = taken(motion.affine, 0), taken(motion.inverse, 12)
    is_similar = kind in (SIMILARITY, TURN)
    known = KnownStep(forth_and_back, tape.add_input(factor, 24) if is_similar and factor is not None else None)
    if kind == TURN:
        axis, before, after = map(ex.exact_row, _turns([motion.steps])[0].reshape(3, 3).tolist())
        return _InputTurn(known, (take(axis, _TURN), take(before, _TURN + 3), take(after, _TURN + 6)))
    return Motion((known,))  # type: ignore[arg-type]


# Points and planes carried by motions: many by one motion, from recordings; every result is rounded once

POINT_SIZE = 3
"""Numbers of a point."""


class PointPlaneMover:
    """Carries points and planes with float coordinates, and caches the results for points."""

    def __init__(self) -> None:
        self._motions: dict[Motion, tuple[Floats, Signs]] = {}
        self._cache: dict[tuple[Motion, bytes], Floats] = {}

    def points(self, motion: Motion, points: Floats) -> Floats:
        """Carry points (n, 3) by a motion: (n, 6) rounded coordinates and their remainders."""
        key = motion, points.tobytes()
        if key not in self._cache:
            self._cache[key] = self._carry("point", _move_point, motion, points)
        return self._cache[key]

    def planes(self, motion: Motion, planes: Floats) -> Floats:
        """Carry exact records of planes (n, 7): (n, 15) records, remainders and senses."""
        return self._carry("plane", _move_plane, motion, planes)

    def _carry(self, name: str, carry: Callable[[Motion, Any], Sequence[Any]], motion: Motion, rows: Floats) -> Floats:
        """Carry each row on a tape; rows that it leaves undecided by exact arithmetic. All results have one length."""
        given, kinds = self._motion_numbers(motion)

        def record(which: int, tape: Tape) -> None:
            row = rows[which].tolist()
            moved = input_motion(tape, int(kinds[0]), motion)
            for number in carry(moved, [tape.input(x) for x in row]):
                tape.write(number)

        found: Any = None
        results, left = recordings.RECORDINGS.play(
            ("carried", name, int(kinds[0])), record, rows, given, np.zeros(len(rows), np.int32)
        )
        for _, which, played in results:
            found = np.empty((len(rows), played.floats.shape[1])) if found is None else found
            found[which] = played.floats
        for row in left.tolist():
            numbers = [float(x) for x in carry(motion, rows[row].tolist())]
            found = np.empty((len(rows), len(numbers))) if found is None else found
            found[row] = numbers
        return found

    def _motion_numbers(self, motion: Motion) -> tuple[Floats, Signs]:
        """Return the numbers of a motion, and (1,) its kind."""
        if motion not in self._motions:
            motions = MotionBatch()
            motions.row(motion.steps, recordings.FEWEST)
            self._motions[motion] = motions.compute()[:2]
        return self._motions[motion]


def _move_point(motion: Motion, numbers: Sequence[Any]) -> Sequence[Any]:
    """Return the rounded coordinates of a carried point, and their remainders."""
    place = motion.carried(ex.exact_row(numbers))
    return *round_numbers(place), *rounding_rests(place)


def _move_plane(motion: Motion, numbers: Sequence[Any]) -> Sequence[Any]:
    """Return the record of a carried plane, its remainders, and the sense of its normal."""
    normal, over, anchor = tuple(numbers[:3]), numbers[3], tuple(numbers[4:PLANE_SIZE])
    offset = ex.dot(ex.exact_row(normal), ex.exact_row(anchor), -ex.exact(over))
    record = round_surface(PlaneSurface(normal, offset, anchor, over).moved(motion))
    return *record.numbers, *record.rests, record.sense
