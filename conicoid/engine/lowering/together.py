"""Bodies lowered together: primitives as they are recorded, and Boolean bodies put together from theirs."""

from __future__ import annotations

from collections.abc import Callable, Hashable, Iterator, Sequence
from dataclasses import dataclass
from typing import Any

import numpy as np

from ...shapes.base import Primitive, Shape
from ...shapes.bulk import Bulk
from ...shapes.distinct import distinct, distinct_places, first_places
from ...shapes.material import Material
from ...shapes.motion import STILL, Motion
from ...shapes.region import Boolean, Painted, region_bounds
from ..tables import Floats, Ints
from .bounds import box_columns, boxes_of
from .composed import Composition, Form
from .motions import Chains
from .pattern import BOX_NUMBERS, Pattern
from .plan import Plan, is_a, plan_of
from .planned import Many, Planned, is_more
from .recorded import Primitives
from .rows import Rows, blocks
from .said import places_by

Found = tuple[Pattern, Ints, Rows]
Told = Callable[[int, int], Any]
_AT_ONCE = 8192
"""Primitives, alone or in Boolean bodies, that are lowered together where there are many."""


@dataclass
class _Known:
    """Where the rows of places are: in which rows, and which of these."""

    forms: list[Form]
    rows: list[Rows]
    number: Ints  # -1 where there are none
    row: Ints

    def of(self, places: Ints) -> Rows:
        """The rows of places whose forms are one."""
        numbers, row = self.number[places], self.row[places]
        rows = self.rows[numbers[0]]
        if (numbers == numbers[0]).all():
            every = len(row) == len(rows) and (row == np.arange(len(row), dtype=np.int32)).all()
            return rows if every else rows[row]
        width = self.forms[numbers[0]].pattern.width
        found = np.empty((len(places), width))
        for number in distinct(numbers).tolist():
            mine = numbers == number
            found[mine] = self.rows[number][row[mine], :]
        return Rows.of(found, np.arange(width, dtype=np.int32))


class Together:
    """Collects bodies, and lowers those that can be."""

    def __init__(self) -> None:
        self._primitives = Primitives()
        self._owners: list[Ints] = []  # of each place: the number of its body, -1 for a part of one
        self._places = 0
        self._single: tuple[list[Shape], list[int]] = [], []  # shapes and numbers
        self._templates: dict[Hashable, tuple[Sequence[Shape], Plan | None]] = {}
        self._plans: dict[Hashable, Planned] = {}
        self._many: list[Many] = []
        self.paints: dict[int, dict[int, Material]] = {}

    def add(self, shape: Shape, number: int) -> bool:
        """Take in the body of a number; False where it has to be lowered alone."""
        kind = type(shape)
        if is_a(kind, Boolean):
            return self._add_planned(shape, number)  # type: ignore[arg-type]
        if not is_a(kind, Primitive):
            return False
        shapes, numbers = self._single
        shapes.append(shape)
        numbers.append(number)
        return True

    def _own(self, owners: Ints) -> Ints:
        """The next places, which belong to these bodies."""
        first = self._places
        self._places += len(owners)
        self._owners.append(owners)
        return np.arange(first, self._places, dtype=np.int32)

    def add_many(self, shape: Bulk, number: int) -> None:
        """Take in many bodies in one entry, from a number on."""
        if not len(shape):
            return
        leaves = len(shape.leaves)
        if leaves == 1:
            owners = np.arange(number, number + len(shape), dtype=np.int32)
        else:
            owners = np.full(len(shape) * leaves, -1, np.int32)
            self._many.append(Many(shape, number, self._places, self._frame_of(shape.motion, len(shape))))
        self._primitives.add_many(shape, self._own(owners).reshape(-1, leaves))

    def _frame_of(self, motion: Motion, uses: int = 1) -> int:
        """The number by which the frames of primitives know a motion; -1 for one that is known at once."""
        return self._primitives.frame(motion.steps, uses) if is_more(motion) else -1

    def _add_planned(self, shape: Boolean, number: int) -> bool:
        # What a combination of the same objects is built like need not be found out again for each of its copies
        key = type(shape), *map(id, shape.operands), id(shape.material) if isinstance(shape, Painted) else None
        found = self._templates.get(key)
        if found is None:
            found = self._templates[key] = (shape,), plan_of(shape, still=True)  # which keeps the operands
        plan = found[1]
        if plan is None:
            return False
        like = self._plans.get(plan.key)
        if like is None:
            like = self._plans[plan.key] = Planned()
        like.shapes.append(shape)
        like.plans.append(plan)
        like.numbers.append(number)
        return True

    def _take_single(self) -> list[tuple[Shape, int]]:
        """Hand on the bodies that are primitives; those that are left."""
        shapes, numbers = self._single
        if not shapes:
            return []
        places = self._own(np.array(numbers, np.int32))
        left = self._primitives.add(shapes, Chains([shape.motion.steps for shape in shapes]), places)
        return [(shapes[k], numbers[k]) for k in left.tolist()]

    def _take_planned(self) -> None:
        """Hand on the primitives of Boolean bodies; one that is left, its body is left for."""
        for like in self._plans.values():
            count, leaves = len(like.shapes), len(like.plans[0].leaves)
            places = self._own(np.full(count * leaves, -1, np.int32)).reshape(count, leaves)
            own = Chains([shape.motion.steps for shape in like.shapes])
            for leaf in range(leaves):
                listed = [plan.leaves[leaf] for plan in like.plans]
                chains = own
                if any(inner for _, inner in listed):
                    chains = Chains([inner + mine for (_, inner), mine in zip(listed, own.steps, strict=True)])
                self._primitives.add([shape for shape, _ in listed], chains, places[:, leaf])
            # A translation, or none, is known at once
            like.first, like.frames = places[:, 0].copy(), self._primitives.frames_of(own)

    def lowered(self, told: Told = lambda *_: None) -> tuple[list[Found], list[tuple[Shape, int]]]:
        """(pattern, numbers, rows) of bodies that could be lowered together; shapes and numbers of those left.

        Where there are many of a kind, so many at a time that what they are made of stays in the cache. Bodies that are
        left then may find enough of their like among those that others left. told(done, count) is called now and then.
        """
        results: list[Found] = []
        pending = [*self._blocks_of_plans(), *self._blocks_of_single()]
        count = len(pending)
        for done in range(count):
            told(done, count + 1)
            block = pending.pop(0)  # then nobody holds it, nor what its bodies are made of
            found, left = block._all(lambda *_: None)
            results += found
            self.paints.update(block.paints)
            for shape, number in left:
                if not self.add(shape, number):
                    raise AssertionError("a shape was lowered with others once, and is not taken again")
        found, rest = self._all((lambda *_: None) if count else told)
        return results + found, rest

    def _blocks_of_plans(self) -> Iterator[Together]:
        """Boolean bodies of which there are many, no longer here."""
        for key, like in list(self._plans.items()):
            size = _AT_ONCE // len(like.plans[0].leaves) + 1
            if len(like.shapes) > 2 * size:
                del self._plans[key]
                for begin in range(0, len(like.shapes), size):
                    block = Together()
                    block._plans[key] = like.some(begin, begin + size)
                    yield block

    def _blocks_of_single(self) -> Iterator[Together]:
        """Primitives of which there are many, no longer here."""
        shapes, numbers = self._single
        if len(shapes) <= 2 * _AT_ONCE:
            return
        left: list[int] = []
        for places in places_by(list(map(type, shapes))).values():
            if len(places) <= 2 * _AT_ONCE:
                left += places
                continue
            for begin in range(0, len(places), _AT_ONCE):
                block, some = Together(), places[begin : begin + _AT_ONCE]
                block._single = [shapes[k] for k in some], [numbers[k] for k in some]
                yield block
        self._single = [shapes[k] for k in left], [numbers[k] for k in left]

    def _all(self, told: Told) -> tuple[list[Found], list[tuple[Shape, int]]]:
        """`lowered`, all at once."""
        rest = self._take_single()
        self._take_planned()
        kinds = self._primitives.kinds + len(self._plans) + len(self._many)
        found, left = self._primitives.lowered(lambda done: told(done, kinds))
        owners = np.concatenate([np.zeros(0, np.int32), *self._owners])
        results: list[Found] = []
        for form, places, rows in found:
            alone = owners[places] >= 0
            if alone.all():
                results.append((form.pattern, owners[places], rows))
            elif alone.any():
                results.append((form.pattern, owners[places[alone]], rows[alone]))
        rest += [(shape, int(owners[place])) for shape, place in left if owners[place] >= 0]
        if self._plans or self._many:
            rows_of = _found_rows(found, len(owners))
            every: list[Planned | Many] = [*self._plans.values(), *self._many]
            for done, like in enumerate(every, start=self._primitives.kinds):
                told(done, kinds)
                composed, others = self._composed(like, rows_of)
                results += composed
                rest += others
        return results, rest

    def _composed(self, like: Planned | Many, rows: _Known) -> tuple[list[Found], list[tuple[Shape, int]]]:
        """Bodies of one plan; those that are left."""
        _, plan = like.of(0)
        key, count = plan.key, len(plan.leaves)
        bodies, first, frame_rows = like.columns()
        places = first[:, None] + np.arange(count, dtype=np.int32)
        frames = like.frames_of(frame_rows, self._primitives.frames)
        known = (rows.number[places] >= 0).all(axis=1) & ~np.isnan(frames[:, 0])
        left: list[tuple[Shape, int]] = [(like.of(i)[0], int(bodies[i])) for i in np.flatnonzero(~known).tolist()]
        numbers = {id(form): number for number, form in enumerate(rows.forms)}
        form_of = np.array([numbers[id(form)] for form in rows.forms], np.int32)
        results: list[Found] = []
        for forms, chosen in _alike(form_of, rows.number[places], np.flatnonzero(known)):
            made = Composition.of(key, [rows.forms[form] for form in forms])
            some: Any = slice(None) if len(chosen) == len(bodies) else chosen
            parts = [rows.of(places[some, part]) for part in range(count)]
            leaves = [leaf for leaf, _ in like.of(int(chosen[0]))[1].leaves]  # those of the others have the same forms
            boxes, known_boxes = _boxes_of(key, leaves, parts)
            others = np.flatnonzero(~known_boxes)
            if len(others):
                narrowed = [like.of(i) for i in chosen[others].tolist()]
                boxes[others] = _narrowed(narrowed, [box_columns(part[others]) for part in parts])
            results.append((made.pattern, bodies[chosen], made.rows(parts, boxes, frames[some])))
            for i in chosen.tolist() if plan.painted else ():
                painted = like.plans[i].painted if isinstance(like, Planned) else like.of(i)[1].painted
                self._paint(int(bodies[i]), painted, made)
        return results, left

    def _paint(self, number: int, painted: list[tuple[int, int, Material]], made: Composition) -> None:
        """The materials of faces that have their own; paint further in stays."""
        ends = [*made.faces, len(made.pattern.angular)]
        paints = self.paints.setdefault(number, {})
        for first, last, material in painted:
            for face in range(ends[first], ends[last]):
                paints.setdefault(face, material)


def _boxes_of(key: Sequence[Hashable], leaves: Sequence[Shape], parts: Sequence[Rows]) -> tuple[Floats, Any]:
    """`boxes_of`, some bodies at a time."""
    boxes, known = np.empty((len(parts[0]), BOX_NUMBERS)), np.empty(len(parts[0]), bool)
    for some in blocks(len(boxes)):
        boxes[some], known[some] = boxes_of(key, leaves, [part[some] for part in parts])
    return boxes, known


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


def _alike(form_of: Ints, tables: Ints, which: Any) -> Iterator[tuple[list[int], Any]]:
    """(the forms of their parts, bodies of these forms) of some bodies; tables (bodies, parts) has numbers of forms."""
    if not len(which):
        return
    forms = form_of[tables[which]].astype(np.int64)
    if (forms == forms[0]).all():
        yield forms[0].tolist(), which
        return
    code = forms[:, 0]
    for part in range(1, forms.shape[1]):
        code = distinct_places(code)[1] * len(form_of) + forms[:, part]
    first, group = first_places(code)
    for number, example in enumerate(first.tolist()):
        yield forms[example].tolist(), which[group == number]


def _found_rows(found: list[tuple[Form, Ints, Rows]], count: int) -> _Known:
    """Rows by places."""
    table, row = np.full(count, -1, np.int32), np.zeros(count, np.int32)
    for number, (_, places, rows) in enumerate(found):
        table[places] = number
        row[places] = np.arange(len(rows), dtype=np.int32)
    return _Known([form for form, _, _ in found], [rows for _, _, rows in found], table, row)
