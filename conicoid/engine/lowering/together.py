"""Bodies lowered together: primitives as they are recorded, and Boolean bodies put together from theirs."""

from __future__ import annotations

from collections.abc import Callable, Hashable, Sequence
from dataclasses import dataclass, field
from typing import Any

import numpy as np

from ...shapes.base import Shape
from ...shapes.material import Material
from ...shapes.motion import STILL, Motion
from ...shapes.region import Boolean, region_bounds
from ..tables import Floats, Ints
from .bounds import box_columns, boxes_of
from .composed import Composition, Form
from .pattern import Pattern
from .plan import Plan, plan_of
from .recorded import Primitives

Found = tuple[Pattern, Ints, Floats]
_IN_PLACE = np.array([1.0, 0, 0, 0, 0, 1, 0, 0, 0, 0, 1, 0])


@dataclass
class _Planned:
    """Boolean bodies that are built alike: shapes, plans and numbers, the places of their first leaves, frames."""

    shapes: list[Boolean] = field(default_factory=list)
    plans: list[Plan] = field(default_factory=list)
    numbers: list[int] = field(default_factory=list)
    first: list[int] = field(default_factory=list)
    frames: list[int] = field(default_factory=list)


@dataclass
class _Rows:
    """Where the rows of places are: which table, and which row of it."""

    forms: list[Form]
    tables: list[Floats]
    table: Ints  # -1 where there is none
    row: Ints

    def of(self, places: Ints) -> Floats:
        """The rows of places whose forms are one."""
        tables = np.unique(self.table[places])
        if len(tables) == 1:
            return self.tables[tables[0]][self.row[places]]
        rows = np.empty((len(places), self.forms[tables[0]].pattern.width))
        for table in tables.tolist():
            mine = self.table[places] == table
            rows[mine] = self.tables[table][self.row[places[mine]]]
        return rows


class Together:
    """Collects bodies, and lowers those that can be."""

    def __init__(self) -> None:
        self._primitives = Primitives()
        self._owners: list[int] = []  # of each place: the number of its body, -1 for a part of one
        self._plans: dict[Hashable, _Planned] = {}
        self.paints: dict[int, dict[int, Material]] = {}

    def add(self, shape: Shape, number: int) -> bool:
        """Take in the body of a number; False where it has to be lowered alone."""
        if isinstance(shape, Boolean):
            return self._add_planned(shape, number)
        if not self._primitives.add(shape, shape.motion.steps, len(self._owners)):
            return False
        self._owners.append(number)
        return True

    def _add_planned(self, shape: Boolean, number: int) -> bool:
        plan = plan_of(shape)
        if plan is None:
            return False
        first = len(self._owners)
        for leaf, steps in plan.leaves:
            if not self._primitives.add(leaf, steps, len(self._owners)):
                return False  # the parts that were taken in already belong to nobody
            self._owners.append(-1)
        like = self._plans.setdefault(plan.key, _Planned())
        like.shapes.append(shape)
        like.plans.append(plan)
        like.numbers.append(number)
        like.first.append(first)
        steps = shape.motion.steps
        like.frames.append(
            self._primitives.frame(steps) if len(steps) > 1 or (steps and shape.motion.shift is None) else -1
        )
        return True

    def lowered(self, told: Callable[[int, int], Any] = lambda *_: None) -> tuple[list[Found], list[tuple[Shape, int]]]:
        """(pattern, numbers, rows) of bodies that could be lowered together; shapes and numbers of those left.

        told(done, count) is called for the kinds that there are.
        """
        kinds = self._primitives.kinds + len(self._plans)
        found, left = self._primitives.lowered(lambda done: told(done, kinds))
        owners = np.array(self._owners, np.int32)
        results: list[Found] = []
        for form, places, rows in found:
            alone = owners[places] >= 0
            if alone.any():
                results.append((form.pattern, owners[places[alone]], rows[alone]))
        rest = [(shape, int(owners[place])) for shape, place in left if owners[place] >= 0]
        if self._plans:
            rows_of = _found_rows(found, len(owners))
            for done, like in enumerate(self._plans.values(), start=self._primitives.kinds):
                told(done, kinds)
                composed, others = self._composed(like, rows_of)
                results += composed
                rest += others
        return results, rest

    def _composed(self, like: _Planned, rows: _Rows) -> tuple[list[Found], list[tuple[Shape, int]]]:
        """Bodies of one plan; those that are left."""
        key, count = like.plans[0].key, len(like.plans[0].leaves)
        places = np.array(like.first, np.int32)[:, None] + np.arange(count, dtype=np.int32)
        frames = np.array(
            [_frame(shape, row, self._primitives.frames) for shape, row in zip(like.shapes, like.frames, strict=True)]
        )
        known = (rows.table[places] >= 0).all(axis=1) & ~np.isnan(frames[:, 0])
        left: list[tuple[Shape, int]] = [(like.shapes[i], like.numbers[i]) for i in np.flatnonzero(~known).tolist()]
        numbers = {id(form): number for number, form in enumerate(rows.forms)}
        form_of = np.array([numbers[id(form)] for form in rows.forms], np.int32)
        results: list[Found] = []
        kept = np.flatnonzero(known)
        if not len(kept):
            return results, left
        kinds, which = np.unique(form_of[rows.table[places[kept]]], axis=0, return_inverse=True)
        for kind, forms in enumerate(kinds):
            chosen = kept[which.reshape(-1) == kind]
            made = Composition.of(key, [rows.forms[form] for form in forms.tolist()])
            parts = [rows.of(places[chosen, part]) for part in range(count)]
            leaves = [leaf for leaf, _ in like.plans[int(chosen[0])].leaves]  # those of the others have the same forms
            boxes, known_boxes = boxes_of(key, leaves, parts)
            others = np.flatnonzero(~known_boxes)
            if len(others):
                narrowed = [(like.shapes[i], like.plans[i]) for i in chosen[others].tolist()]
                boxes[others] = _narrowed(narrowed, [box_columns(part[others]) for part in parts])
            bodies = np.array(like.numbers, np.int32)[chosen]
            results.append((made.pattern, bodies, made.rows(parts, boxes, frames[chosen])))
            for i in chosen.tolist() if like.plans[0].painted else ():
                self._paint(like.numbers[i], like.plans[i].painted, made)
        return results, left

    def _paint(self, number: int, painted: list[tuple[int, int, Material]], made: Composition) -> None:
        """The materials of faces that have their own; paint further in stays."""
        ends = [*made.faces, len(made.pattern.angular)]
        paints = self.paints.setdefault(number, {})
        for first, last, material in painted:
            for face in range(ends[first], ends[last]):
                paints.setdefault(face, material)


def _narrowed(bodies: Sequence[tuple[Boolean, Plan]], parts: Sequence[Floats]) -> Floats:
    """Bounds of bodies whose parts may narrow one another, from the boxes of their parts."""
    found = np.empty((len(bodies), 6))
    for row, (shape, plan) in enumerate(bodies):
        known = {
            (id(leaf), steps): (boxes[row, :3], boxes[row, 3:])
            for (leaf, steps), boxes in zip(plan.leaves, parts, strict=True)
        }
        found[row] = np.concatenate(region_bounds(shape, STILL, known))
    return found


def _frame(shape: Boolean, row: int, frames: Floats) -> Any:
    """World to own coordinates of a body."""
    if row >= 0:
        return frames[row]
    return np.array(Motion(shape.motion.steps).inverse_rows).ravel() if shape.motion.steps else _IN_PLACE


def _found_rows(found: list[tuple[Form, Ints, Floats]], count: int) -> _Rows:
    """Rows by places."""
    table, row = np.full(count, -1, np.int32), np.zeros(count, np.int32)
    for number, (_, places, rows) in enumerate(found):
        table[places] = number
        row[places] = np.arange(len(rows), dtype=np.int32)
    return _Rows([form for form, _, _ in found], [rows for _, _, rows in found], table, row)
