"""Many primitives lowered at once: what `parts` does for one is recorded, and worked out for all that are made alike.

Alike are shapes of one kind whose fields have the same forms (so many numbers, or none), moved or not. For each kind
there are a few recordings, as tests of numbers turn out one way or the other. What they cannot settle is left to
`parts`: numbers that 253 bits leave open, kinds that look at their numbers in other ways, and shapes of which there are
too few.
"""

from __future__ import annotations

import dataclasses
from collections.abc import Callable, Hashable, Sequence
from dataclasses import dataclass, field
from typing import Any, Protocol

import numpy as np

from ...shapes.base import Shape
from ...shapes.bulk import Bulk
from ...shapes.motion import STILL, Motion, Step
from ...shapes.recorder import Tape
from ...shapes.traced import Plain
from ..tables import Floats, Ints, Longs, Signs
from ..tapes.play import NOTHING, Given
from . import recordings
from .composed import FORMS, Form
from .motions import Chains, Motions, given_motion, translations
from .parts import Part, worked_out
from .pattern import FRAME_NUMBERS
from .plan import primitives
from .rows import Rows
from .said import again, said, said_of_all


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
    """Shapes of bodies that stand alone, or in Boolean ones, some at a time."""

    shapes: list[Shape] = field(default_factory=list)
    steps: list[tuple[Step, ...]] = field(default_factory=list)
    numbers: list[Floats] = field(default_factory=list)
    motions: list[Ints] = field(default_factory=list)
    places: list[Ints] = field(default_factory=list)

    def __len__(self) -> int:
        return len(self.shapes)

    def add(self, shapes: Sequence[Shape], steps: list[tuple[Step, ...]], which: Longs, places: Ints) -> None:
        """Take in some of these shapes, with the steps of each of them."""
        self.shapes += [shapes[k] for k in which.tolist()]
        self.steps += steps
        self.places.append(places[which])

    def of(self, index: int) -> tuple[Shape, tuple[Step, ...]]:
        """`Like.of`"""
        return self.shapes[index], self.steps[index]

    def columns(self) -> tuple[Floats, Ints, Ints]:
        """`Like.columns`"""
        return np.concatenate(self.numbers), np.concatenate(self.motions), np.concatenate(self.places)


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
    motions_given: Given
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
        if translations(steps) >= 0:
            return (form, len(steps)), [x for step in steps for x in step.offset], 0  # type: ignore[union-attr]
        return (form, "moved"), [], self._motions.row(steps, uses)

    def add(self, shapes: Sequence[Shape], chains: Chains, places: Ints) -> Longs:
        """Take in shapes, each moved by steps and for a place; which are left, as they have to be lowered alone."""
        taken = np.zeros(len(shapes), bool)
        for alike in said_of_all(shapes):
            taken[alike.which] = True
            counts = chains.translations[alike.which]
            for count in sorted(set(counts.tolist())):
                some = np.flatnonzero(counts == count)
                which = alike.which[some]
                like = self._like.setdefault((alike.form, "moved" if count < 0 else count), _Listed())
                like.add(shapes, [chains.steps[k] for k in which.tolist()], which, places)
                numbers, motions = alike.numbers[some], np.zeros(len(which), np.int32)
                if count < 0:
                    motions = self._motions.rows(chains, which)
                elif count:
                    offsets = [step.offset for steps in like.steps[-len(which) :] for step in steps]  # type: ignore[union-attr]
                    numbers = np.concatenate([numbers, np.array(offsets).reshape(len(which), -1)], axis=1)
                like.numbers.append(numbers)
                like.motions.append(motions)
        return np.flatnonzero(~taken)

    def frames_of(self, chains: Chains) -> Ints:
        """`frame` of many; -1 for those of at most one translation."""
        more = np.flatnonzero((chains.translations < 0) | (chains.translations > 1))
        found = np.full(len(chains.steps), -1, np.int32)
        found[more] = self._motions.rows(chains, more)
        return found

    def frame(self, steps: tuple[Step, ...], uses: int = 1) -> int:
        """A number by which `frames` knows the motion of these steps; to be asked for before they are lowered."""
        return self._motions.row(steps, uses)

    @property
    def kinds(self) -> int:
        """How many kinds there are of what is made alike."""
        return len(self._like) + len(self._many)

    def lowered(
        self, told: Callable[[int], Any] = lambda _: None
    ) -> tuple[list[tuple[Form, Ints, Rows]], list[tuple[Shape, int]]]:
        """(form, places, rows) of those that could be lowered together, and the shapes and places that are left."""
        motions_given, similar, self.frames = self._motions.work_out()
        results: list[tuple[Form, Ints, Rows]] = []
        left: list[tuple[Shape, int]] = []
        every: list[tuple[Hashable, Like]] = [*self._like.items(), *self._many]
        for done, (key, like) in enumerate(every):
            told(done)
            numbers, motions, places = like.columns()
            for kind, chosen in _by_motion(key, motions, similar):
                given = _Given(like, chosen, numbers[chosen], motions_given, motions[chosen])
                found, rest = self._of_a_kind(key, kind, given)
                results += [(form, places[chosen[which]], rows) for form, which, rows in found]
                left += [(like.of(i)[0], int(places[i])) for i in chosen[rest].tolist()]
        return results, left

    def _of_a_kind(
        self, key: Hashable, similar: bool | None, of: _Given
    ) -> tuple[list[tuple[Form, Longs, Rows]], Longs]:
        """`lowered` for some shapes that are made alike, by their numbers among them; those that are left."""
        if similar is None:
            return [], np.arange(len(of.chosen))
        moved = isinstance(key, tuple) and key[1] == "moved"

        def record(which: int, tape: Tape) -> tuple[Form, Ints]:
            shape, steps = of.like.of(int(of.chosen[which]))
            part = _record(shape, steps, tape, moved, similar)
            alone = worked_out(dataclasses.replace(shape, motion=Motion(steps)))
            if part.pattern != alone.pattern or list(map(_bits, part.row)) != list(map(_bits, alone.row)):
                raise TypeError("it is not the same where it is recorded")
            return FORMS.of(part.pattern, part.tree), _written(part, tape)

        given = of.motions_given if moved else NOTHING
        found, left = recordings.RECORDINGS.play((key, similar), record, of.numbers, given, of.motions)
        return [(form, which, Rows.of(played.floats, columns)) for (form, columns), which, played in found], left


def _written(part: Part, tape: Tape) -> Ints:
    """Have a tape write each number of a row once; which of those that it writes is in each column."""
    places: dict[int, int] = {}
    columns = [places.setdefault(tape.plain_of(number).register, len(places)) for number in part.row]
    tape.written += places
    return np.array(columns, np.int32)


def _bits(number: Any) -> str:
    """A float, recorded or not, to the last bit."""
    return float(number.value if isinstance(number, Plain) else number).hex()


def _by_motion(key: Hashable, motions: Ints, similar: Signs) -> list[tuple[bool | None, Longs]]:
    """Those whose motions are similarities, those whose are none, and those of which it is not known."""
    if not (isinstance(key, tuple) and key[1] == "moved"):
        return [(True, np.arange(len(motions)))]
    kinds = similar[motions]
    chosen = ((kind, np.flatnonzero(kinds == number)) for kind, number in ((True, 1), (False, 0), (None, -1)))
    return [(kind, which) for kind, which in chosen if len(which)]


def _record(shape: Shape, steps: tuple[Step, ...], tape: Tape, moved: bool, similar: bool) -> Part:
    """A shape worked out on a tape."""
    traced = again(shape, tape)
    if not moved:
        motion = Motion(tuple(again(step, tape) for step in steps)) if steps else STILL
    else:
        motion = given_motion(tape, similar, Motion(steps))
    object.__setattr__(traced, "motion", motion)
    return worked_out(traced)
