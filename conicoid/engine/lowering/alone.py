"""The numbers of bodies worked out alone, but for their boxes: those of primitives that several bodies share, once.

Cells of one universe meet at its surfaces, so that each surface bounds several bodies, and bodies that are one another
moved have some in common.
"""

from __future__ import annotations

from collections.abc import Hashable, Iterable
from dataclasses import replace
from typing import Any, NamedTuple, TypeAlias

import numpy as np

from ...shapes.base import Shape
from ...shapes.cells import Cell
from ...shapes.motion import STILL, Motion
from ...shapes.recorder import Tape
from ...shapes.steps import Step
from ...shapes.traced import Plain
from ..tables import Floats
from ..tapes.play import NOTHING
from . import recordings
from .assembly import Assembly
from .parts import numbers_of_surfaces, own_frame
from .plan import primitives
from .said import again, said
from .trees import Faces, world_tree

_Lists: TypeAlias = tuple[list[float], list[float], tuple[int, ...]]
"""Numbers of surfaces and of uv, and the kinds of the surfaces."""


class Alone:
    """Works out bodies, and remembers their primitives; those of many bodies together, from recordings."""

    def __init__(self) -> None:
        self._known: dict[Hashable, _Lists] = {}

    def prepare(self, shapes: Iterable[Shape]) -> None:
        """Work out the primitives of solids whose numbers will be asked for."""
        self.prepare_primitives(primitive for shape in shapes for primitive in primitives(shape))

    def prepare_primitives(self, moved: Iterable[tuple[Shape, tuple[Step, ...]]]) -> None:
        """Work out primitives that steps move."""
        missing: dict[Hashable, dict[Hashable, tuple[Shape, tuple[Step, ...], Floats]]] = {}
        for leaf, steps in moved:
            told = _told(leaf, steps)
            if told is not None and told.key not in self._known:
                missing.setdefault(told.forms, {})[told.key] = leaf, steps, told.numbers
        for forms, alike in missing.items():
            if len(alike) >= recordings.FEWEST:
                self._play(forms, list(alike), list(alike.values()))

    def _play(self, forms: Hashable, keys: list[Hashable], alike: list[tuple[Shape, tuple[Step, ...], Floats]]) -> None:
        """Work out primitives of which the same was said but for its numbers; those that are left open are left."""

        def record(which: int, tape: Tape) -> tuple[int, int, tuple[int, ...]]:
            leaf, steps, _ = alike[which]
            traced = again(leaf, tape)
            object.__setattr__(traced, "motion", Motion(tuple(again(step, tape) for step in steps)))
            surfaces, uv, kinds = _numbers(traced)
            found = [float(x.value if isinstance(x, Plain) else x) for x in (*surfaces, *uv)]
            alone = _worked_out(leaf, steps)
            if not _same(found, [*alone[0], *alone[1]]) or kinds != alone[2]:
                raise TypeError("it is not the same where it is recorded")
            for number in (*surfaces, *uv):
                tape.write(number)
            return len(surfaces), len(found), kinds

        numbers = np.array([each for _, _, each in alike])
        rows = np.zeros(len(alike), np.int32)
        for (first_uv, count, kinds), which, played in recordings.RECORDINGS.play(
            ("alone", forms), record, numbers, NOTHING, rows
        )[0]:
            assert played.floats.shape[1] == count
            for k, row in zip(which.tolist(), played.floats.tolist(), strict=True):
                self._known[keys[k]] = row[:first_uv], row[first_uv:], kinds

    def numbers(self, shape: Shape) -> Floats:
        """The row of a solid's numbers but for its boxes: its surfaces, the uv of its faces, the way to its frame."""
        surfaces: list[float] = []
        uv: list[float] = []
        for leaf, steps in primitives(shape):
            own = self.of(leaf, steps)
            surfaces += own[0]
            uv += own[1]
        return np.array([*surfaces, *uv, *(number for line in own_frame(shape).inverse_rows for number in line)])

    def of(self, leaf: Shape, steps: tuple[Step, ...]) -> _Lists:
        """(numbers of surfaces, of uv, kinds of surfaces) of a primitive that steps move."""
        told = _told(leaf, steps)
        if told is None:
            return _worked_out(leaf, steps)
        if told.key not in self._known:
            self._known[told.key] = _worked_out(leaf, steps)
        return self._known[told.key]


class _Told(NamedTuple):
    """What was said of a primitive and of the steps that move it."""

    forms: Hashable
    numbers: Floats
    key: Hashable
    """All of it to the last bit."""


def _told(leaf: Shape, steps: tuple[Step, ...]) -> _Told | None:
    """None where there is more to them than numbers."""
    forms: list[Hashable] = []
    numbers: list[float] = []
    for thing in (leaf, *steps):
        told = said(thing)
        if told is None:
            return None
        forms.append(told.form)
        numbers += told.numbers
    every, all_forms = np.array(numbers), tuple(forms)
    return _Told(all_forms, every, (all_forms, every.tobytes()))


def _worked_out(leaf: Shape, steps: tuple[Step, ...]) -> _Lists:
    """`Alone.of`, computed."""
    return _numbers(replace(leaf, motion=Motion(steps)))


def _numbers(leaf: Any) -> _Lists:
    """(numbers of surfaces, of uv, kinds of surfaces) of a primitive, which may be recorded."""
    assembly, faces = Assembly(), Faces()
    tree = world_tree(leaf, STILL, faces)
    if isinstance(tree, Cell):
        assembly.cell(tree)
    else:
        assembly.program(tree, {})
    kinds = tuple(record.kind for record in assembly.surfaces)
    return numbers_of_surfaces(assembly), [number for numbers in faces.maps()[0] for number in numbers], kinds


def _same(some: list[float], others: list[float]) -> bool:
    """Are numbers equal to the last bit?"""
    return np.array(some).tobytes() == np.array(others).tobytes()
