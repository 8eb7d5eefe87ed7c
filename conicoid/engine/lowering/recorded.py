"""Many primitives lowered at once: what `parts` does for one is recorded, and worked out for all that are made alike.

Alike are shapes of one kind whose fields have the same forms (so many numbers, or none), moved or not. For each kind
there are a few recordings, as tests of numbers turn out one way or the other. What they cannot settle is left to
`parts`: numbers that 253 bits leave open, kinds that look at their numbers in other ways, and shapes of which there are
too few.
"""

from __future__ import annotations

import dataclasses
import operator
from collections.abc import Callable, Hashable, Sequence
from dataclasses import dataclass, field
from typing import Any, Protocol, cast

import numpy as np

from ...forks import lock
from ...shapes import exact as ex
from ...shapes.base import Primitive, Shape
from ...shapes.bulk import Bulk
from ...shapes.motion import STILL, Affine, Motion, Step, Translate
from ...shapes.recorder import Tape
from ...shapes.traced import Plain
from ..tables import Floats, Ints, Longs
from ..tapes.play import Played, Recording, wide_row
from ..tapes.wide import WIDTH
from .composed import FORMS, Form
from .parts import Part, worked_out
from .pattern import FRAME_NUMBERS
from .plan import primitives

FEWEST = 8
"""Shapes of one kind that are worth a new recording, which takes as long as some of them alone."""
_NO_NUMBERS = np.zeros((1, 0, WIDTH), np.int64)
_MOST = 48
"""Recordings of one kind."""


@dataclass(frozen=True)
class Known:
    """A step that is known by what it does: a whole chain of them, worked out before."""

    forth_and_back: tuple[Affine, Affine]
    factor: ex.Exact | None

    def similarity(self) -> ex.Exact | None:
        """The factor of all lengths, if there is one."""
        return self.factor


@dataclass(slots=True)
class Said:
    """What was said of a shape: the form of its fields, and their numbers from the first to the last."""

    form: tuple[Hashable, ...]
    numbers: list[float]


_FIELDS: dict[type, Callable[[Any], tuple[Any, ...]]] = {}


def _fields_of(kind: type) -> Callable[[Any], tuple[Any, ...]]:
    """What reads the fields of a kind of shape or step, but for the motion."""
    found = _FIELDS.get(kind)
    if found is None:
        names = [each.name for each in dataclasses.fields(kind) if each.name != "motion"]
        get = operator.attrgetter(*names)
        found = _FIELDS[kind] = get if len(names) > 1 else lambda thing: (get(thing),)
    return found


def said(thing: Any) -> Said | None:
    """What was said of a shape or a step; None where there is more to it than numbers."""
    form: list[Hashable] = [cast(Hashable, type(thing))]
    numbers: list[float] = []
    for value in _fields_of(type(thing))(thing):
        if not _take(value, form, numbers):
            return None
    return Said(tuple(form), numbers)


def _take(value: Any, form: list[Hashable], numbers: list[float]) -> bool:
    """Add a value of a field; False for what has another form."""
    kind = type(value)
    if kind is float:
        form.append(float)
        numbers.append(value)
    elif kind is tuple:
        form.append(len(value))
        for place, each in enumerate(value):
            if type(each) is float:
                numbers.append(each)
                continue
            form.append((place,))
            if not _take(each, form, numbers):
                return False
    elif value is None or kind is str or kind is bool:
        form.append(value)
    else:
        return False
    return True


def _retold(value: Any, tape: Tape) -> Any:
    """A value of a field with numbers that are recorded."""
    if type(value) is float:
        return tape.input(value)
    return tuple(_retold(each, tape) for each in value) if type(value) is tuple else value


def _again(thing: Any, tape: Tape) -> Any:
    """A shape or a step whose numbers are recorded; nothing of it is checked anew."""
    made = object.__new__(type(thing))
    for each in dataclasses.fields(thing):
        if each.name != "motion":
            object.__setattr__(made, each.name, _retold(getattr(thing, each.name), tape))
    return made


class Recordings:
    """What has been recorded in this process, by what it is of. None: it cannot be recorded."""

    def __init__(self) -> None:
        self._of: dict[Hashable, list[tuple[Any, Recording]] | None] = {}
        self._lock = lock()

    def play(
        self, key: Hashable, record: Callable[[int, Tape], Any], inputs: Floats, given: Longs, rows: Ints
    ) -> tuple[list[tuple[Any, Longs, Played]], Longs]:
        """(what recordings were of, for which rows of inputs they held, what they gave), and the rows that are left.

        `record(row, tape)` works one out on a tape.
        """
        with self._lock:
            found = self._of.setdefault(key, [])
            results: list[tuple[Any, Longs, Played]] = []
            left, open_, number = np.arange(len(inputs)), [], 0
            while len(left) and found is not None:
                if number == len(found):
                    if len(left) < FEWEST or number == _MOST:
                        break
                    try:
                        tape = Tape()
                        made = record(int(left[0]), tape)
                        found.append((made, Recording.of(tape)))
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


_RECORDINGS = Recordings()


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
                motion = Motion(tuple(_again(step, tape) for step in all_steps[which]))
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
            results, left = _RECORDINGS.play(
                ("motion", kind), record, inputs, _NO_NUMBERS, np.zeros(len(rows), np.int32)
            )
            for similar, which, played in results:
                at = np.array(rows)[which]
                table[at, : 24 + similar] = played.wides
                back[at] = played.floats
                for row in at.tolist():
                    kinds[row] = similar
            for which in left.tolist() if len(left) < FEWEST else ():
                few.add(rows[which])
        for steps, row in self.known.items():
            if kinds[row] is None and (row in few or self.uses[row] >= FEWEST):  # those of a body, or of many shapes
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


def _given_motion(tape: Tape, similar: bool, motion: Motion) -> Motion:
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


class Like(Protocol):
    """Shapes that are made alike, and what was said of each."""

    def __len__(self) -> int: ...

    def of(self, index: int) -> tuple[Shape, tuple[Step, ...]]:
        """One of the shapes, and the steps that move it."""
        ...

    def columns(self) -> tuple[Floats, Ints, Ints]:
        """(n, numbers) what was said, and of each shape its motion and its place."""
        ...


@dataclass
class _Listed:
    """Shapes of bodies that stand alone."""

    shapes: list[Shape] = field(default_factory=list)
    steps: list[tuple[Step, ...]] = field(default_factory=list)
    numbers: list[list[float]] = field(default_factory=list)
    motions: list[int] = field(default_factory=list)
    places: list[int] = field(default_factory=list)

    def __len__(self) -> int:
        return len(self.shapes)

    def of(self, index: int) -> tuple[Shape, tuple[Step, ...]]:
        """`Like.of`"""
        return self.shapes[index], self.steps[index]

    def columns(self) -> tuple[Floats, Ints, Ints]:
        """`Like.columns`"""
        numbers = np.array(self.numbers).reshape(len(self), -1)
        return numbers, np.array(self.motions, np.int32), np.array(self.places, np.int32)


@dataclass
class _Many:
    """One primitive of each of many bodies in one entry."""

    shape: Bulk
    leaf: int
    steps: tuple[Step, ...]
    numbers: Floats
    motion: int
    places: Ints

    def __len__(self) -> int:
        return len(self.places)

    def of(self, index: int) -> tuple[Shape, tuple[Step, ...]]:
        """`Like.of`"""
        return primitives(self.shape.single(index))[self.leaf]

    def columns(self) -> tuple[Floats, Ints, Ints]:
        """`Like.columns`"""
        return self.numbers, np.full(len(self), self.motion, np.int32), self.places


@dataclass
class _Given:
    """Some shapes that are made alike: which, their numbers, the numbers of motions, and the motion of each."""

    like: Like
    chosen: Longs
    numbers: Floats
    table: Longs
    motions: Ints


class Primitives:
    """Primitives to be lowered together, each for a place of its own."""

    def __init__(self) -> None:
        self._motions = Motions()
        self.frames = np.zeros((0, FRAME_NUMBERS))
        """Of motions, by the numbers that `frame` gave, the way back; NaN where that is not known."""
        self._like: dict[Hashable, _Listed] = {}
        self._many: list[tuple[Hashable, _Many]] = []

    def add_many(self, shape: Bulk, places: Ints) -> None:
        """Take in the primitives of many bodies; places (bodies, primitives)."""
        for leaf, (primitive, steps) in enumerate(primitives(shape.single(0))):
            told = said(primitive)
            assert told is not None
            numbers = shape.numbers(leaf)
            key, more, row = self._motion(told.form, steps, len(shape))
            if more:
                numbers = np.concatenate([numbers, np.tile(np.array(more), (len(numbers), 1))], axis=1)
            self._many.append((key, _Many(shape, leaf, steps, numbers, row, np.ascontiguousarray(places[:, leaf]))))

    def _motion(self, form: Hashable, steps: tuple[Step, ...], uses: int = 1) -> tuple[Hashable, list[float], int]:
        """(what is alike in shapes of a form under such steps, the steps' numbers where these count, their motion)."""
        if all(type(step) is Translate for step in steps):
            return (form, len(steps)), [x for step in steps for x in step.offset], 0  # type: ignore[union-attr]
        return (form, "moved"), [], self._motions.row(steps, uses)

    def add(self, shape: Shape, steps: tuple[Step, ...], place: int) -> bool:
        """Take in a shape that is moved by steps; False where it has to be lowered alone."""
        if not isinstance(shape, Primitive):
            return False
        told = said(shape)
        if told is None:
            return False
        key, more, row = self._motion(told.form, steps)
        told.numbers.extend(more)
        like = self._like.get(key)
        if like is None:
            like = self._like[key] = _Listed()
        like.shapes.append(shape)
        like.steps.append(steps)
        like.numbers.append(told.numbers)
        like.motions.append(row)
        like.places.append(place)
        return True

    def frame(self, steps: tuple[Step, ...], uses: int = 1) -> int:
        """A number by which `frames` knows the motion of these steps; to be asked for before they are lowered."""
        return self._motions.row(steps, uses)

    @property
    def kinds(self) -> int:
        """How many kinds there are of what is made alike."""
        return len(self._like) + len(self._many)

    def lowered(
        self, told: Callable[[int], Any] = lambda _: None
    ) -> tuple[list[tuple[Form, Ints, Floats]], list[tuple[Shape, int]]]:
        """(form, places, rows) of those that could be lowered together, and the shapes and places that are left."""
        table, similar, self.frames = self._motions.work_out()
        results: list[tuple[Form, Ints, Floats]] = []
        left: list[tuple[Shape, int]] = []
        every: list[tuple[Hashable, Like]] = [*self._like.items(), *self._many]
        for done, (key, like) in enumerate(every):
            told(done)
            numbers, motions, places = like.columns()
            for kind, chosen in _by_motion(key, motions, similar):
                given = _Given(like, chosen, numbers[chosen], table, motions[chosen])
                found, rest = self._of_a_kind(key, kind, given)
                results += [(form, places[chosen[which]], rows) for form, which, rows in found]
                left += [(like.of(i)[0], int(places[i])) for i in chosen[rest].tolist()]
        return results, left

    def _of_a_kind(
        self, key: Hashable, similar: bool | None, of: _Given
    ) -> tuple[list[tuple[Form, Longs, Floats]], Longs]:
        """`lowered` for some shapes that are made alike, by their numbers among them; those that are left."""
        if similar is None:
            return [], np.arange(len(of.chosen))
        moved = isinstance(key, tuple) and key[1] == "moved"

        def record(which: int, tape: Tape) -> Form:
            shape, steps = of.like.of(int(of.chosen[which]))
            part = _record(shape, steps, tape, moved, similar)
            alone = worked_out(dataclasses.replace(shape, motion=Motion(steps)))
            if part.pattern != alone.pattern or list(map(_bits, part.row)) != list(map(_bits, alone.row)):
                raise TypeError("it is not the same where it is recorded")
            for number in part.row:
                tape.write(number)
            return FORMS.of(part.pattern, part.tree)

        given = of.table if moved else _NO_NUMBERS
        found, left = _RECORDINGS.play((key, similar), record, of.numbers, given, of.motions)
        return [(form, which, played.floats) for form, which, played in found], left


def _bits(number: Any) -> str:
    """A float, recorded or not, to the last bit."""
    return float(number.value if isinstance(number, Plain) else number).hex()


def _by_motion(key: Hashable, motions: Ints, similar: list[bool | None]) -> list[tuple[bool | None, Longs]]:
    """Those whose motions are similarities, those whose are none, and those of which it is not known."""
    if not (isinstance(key, tuple) and key[1] == "moved"):
        return [(True, np.arange(len(motions)))]
    kinds = np.array([-1 if each is None else int(each) for each in similar])[motions]
    chosen = ((kind, np.flatnonzero(kinds == number)) for kind, number in ((True, 1), (False, 0), (None, -1)))
    return [(kind, which) for kind, which in chosen if len(which)]


def _record(shape: Shape, steps: tuple[Step, ...], tape: Tape, moved: bool, similar: bool) -> Part:
    """A shape worked out on a tape."""
    traced = _again(shape, tape)
    if not moved:
        motion = Motion(tuple(_again(step, tape) for step in steps)) if steps else STILL
    else:
        motion = _given_motion(tape, similar, Motion(steps))
    object.__setattr__(traced, "motion", motion)
    return worked_out(traced)
