"""What one ray does to an exact shape: its crossings, all of them, in order."""

from __future__ import annotations

import itertools
from collections.abc import Callable, Sequence
from dataclasses import dataclass
from typing import Any

import numpy as np

from .exact import ExactRay, Root, by_place, compare, roots, sign_at_start, value_sign
from .forms import Form
from .sheets import ExactSheet
from .solids import Formula, forms_of

SKIPPED = -1


@dataclass(frozen=True)
class ExactCrossing:
    """A crossing at `root` of form `root.index`; `face` -1 where it is not told."""

    root: Root
    entering: bool
    face: int


class Shape:
    """A formula or sheet with its forms numbered; `faces` False where a body's faces are not compared."""

    def __init__(self, reference: Formula | ExactSheet, faces: bool = True) -> None:
        self.reference, self.faces = reference, faces
        self.sheet = reference if isinstance(reference, ExactSheet) else None
        self.formula = reference.clip if isinstance(reference, ExactSheet) else reference
        self.forms: list[Form] = [] if self.sheet is None else [self.sheet.surface]
        known: dict[Any, int] = {} if self.sheet is None else {self.sheet.surface.name: 0}
        self.numbers: dict[int, int] = {}
        for f in forms_of(self.formula) if self.formula is not None else ():
            if f.name not in known:
                known[f.name] = len(self.forms)
                self.forms.append(f)
            self.numbers[id(f)] = known[f.name]

    def truth(self, formula: Formula, negative: Callable[[int], Any]) -> Any:
        """The formula where negative(i) says of form i whether it is; bools or arrays of them."""
        return self.combined(formula, lambda forms: _every(negative(self.numbers[id(f)]) for f in forms))

    def combined(self, formula: Formula, held: Callable[[Sequence[Form]], Any]) -> Any:
        kind, parts = formula
        if kind == "cell":
            return held(parts)
        if kind == "not":
            return np.logical_not(self.combined(parts, held))
        values = (self.combined(part, held) for part in parts)
        return _every(values) if kind == "all" else _some(values)

    def contains(self, point: Sequence[float]) -> bool:
        """Leaves are closed; combinations exactly Boolean. A sheet contains nothing."""
        if self.sheet is not None or self.formula is None:
            return False
        return bool(self.truth(self.formula, lambda i: value_sign(self.forms[i], point) <= 0))


def _every(values: Any) -> Any:
    result: Any = True
    for value in values:
        result = np.logical_and(result, value)
    return result


def _some(values: Any) -> Any:
    result: Any = False
    for value in values:
        result = np.logical_or(result, value)
    return result


@dataclass
class Events:
    """Roots in groups of equal t, and for each form whether it is negative before the first."""

    groups: list[list[Root]]
    before: list[bool]

    def states(self) -> list[list[bool]]:
        """Negative or not, for each gap between groups and each form."""
        found = [list(self.before)]
        for group in self.groups:
            state = list(found[-1])
            for r in group:
                state[r.index] = not state[r.index]
            found.append(state)
        return found


def events(shape: Shape, ray: ExactRay, start: int = SKIPPED) -> Events:
    """`start`: the form that the ray starts on, one root of which, the nearest to t = 0, is taken out."""
    every: list[Root] = []
    before = []
    for index, f in enumerate(shape.forms):
        quadratic = ray.quadratic(f)
        found = roots(index, f, quadratic)
        negative = sign_at_start(f, quadratic, bool(found))
        if index == start and found:
            gone = found[0] if len(found) == 1 or abs(found[0].at(200)) < abs(found[1].at(200)) else found[1]
            if gone is found[0]:  # what was left of it never was
                negative = not negative
            found = [r for r in found if r is not gone]
        every += found
        before.append(negative)
    every.sort(key=by_place)
    groups: list[list[Root]] = []
    for r in every:
        if groups and compare(groups[-1][-1], r) == 0:
            groups[-1].append(r)
        else:
            groups.append([r])
    return Events(groups, before)


def crossings(shape: Shape, ray: ExactRay, start: int = SKIPPED) -> list[ExactCrossing]:
    """All crossings of the whole line, in order."""
    met = events(shape, ray, start)
    return _sheet_crossings(shape, met, ray) if shape.sheet is not None else _solid_crossings(shape, met)


def _solid_crossings(shape: Shape, met: Events) -> list[ExactCrossing]:
    states = met.states()
    truths = [bool(shape.truth(shape.formula, state.__getitem__)) for state in states]  # type: ignore[arg-type]
    found = []
    for k, group in enumerate(met.groups):
        entering = truths[k + 1]
        if entering == truths[k]:
            continue
        turned = [r for r in group if states[k + 1][r.index] == entering] or group
        chosen = min(turned, key=lambda r: shape.forms[r.index].face)
        found.append(ExactCrossing(chosen, entering, shape.forms[chosen.index].face if shape.faces else -1))
    return found


def _sheet_crossings(shape: Shape, met: Events, ray: ExactRay) -> list[ExactCrossing]:
    sheet, states = shape.sheet, met.states()
    assert sheet is not None
    found = []
    for k, group in enumerate(met.groups):
        own = next((r for r in group if r.index == 0), None)
        if own is None:
            continue
        entering = states[k + 1][0]
        if sheet.one_sided and not entering:
            continue
        if shape.formula is not None and not _held(shape, states[k], states[k + 1]):
            continue
        if sheet.loop and not in_loop(sheet, ray):
            continue
        found.append(ExactCrossing(own, entering, 0))
    return found


def _held(shape: Shape, before: list[bool], after: list[bool]) -> bool:
    """Is the point in the clip?  Its cells are closed: they hold it if they hold what is just before or just after."""

    def cell(forms: Sequence[Form]) -> bool:
        numbers = [shape.numbers[id(f)] for f in forms]
        return all(before[n] for n in numbers) or all(after[n] for n in numbers)

    return bool(shape.combined(shape.formula, cell))  # type: ignore[arg-type]


def in_loop(sheet: ExactSheet, ray: ExactRay) -> bool:
    """Even-odd as documented: vertices seen along the ray, (u, v) = (d_z X - d_x Z, d_z Y - d_y Z) with z the longest axis
    of the direction (ties: z before x before y); an edge counts from its lower end inclusive, where u > 0."""
    dx, dy, dz = (abs(c) for c in ray.d)
    longest = 2 if dz >= dx and dz >= dy else 0 if dx >= dy else 1
    iu, iv, iw = ((1, 2, 0), (2, 0, 1), (0, 1, 2))[longest]
    seen = []
    for p in sheet.loop:
        x = [c * ray.w - o for c, o in zip(p, ray.o, strict=True)]
        seen.append((ray.d[iw] * x[iu] - ray.d[iu] * x[iw], ray.d[iw] * x[iv] - ray.d[iv] * x[iw]))
    odd = False
    for (ua, va), (ub, vb) in itertools.pairwise([seen[-1], *seen]):
        if (va < 0) != (vb < 0):
            side = ua * vb - ub * va
            if (side > 0) if vb > va else (side < 0):
                odd = not odd
    return odd
