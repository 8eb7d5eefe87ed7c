"""What one ray does to an exact shape: its crossings, all of them, in order."""

from __future__ import annotations

import itertools
from collections.abc import Callable, Sequence
from dataclasses import dataclass
from typing import Any

import numpy as np
from flint import fmpq

from .exact import ExactRay, Root, by_place, compare, roots, sign_at_start, value_sign
from .forms import Form
from .rational import total
from .sheets import ExactSheet
from .solids import Formula, forms_of

SKIPPED = -1


@dataclass(frozen=True)
class ExactCrossing:
    """A crossing at `root` of form `root.index`; `face` -1 where it is not told."""

    root: Root
    entering: bool
    face: int
    body: int


@dataclass(frozen=True)
class Body:
    """A solid's formula, or a sheet with the formula that clips it (None: all of it is there)."""

    formula: Formula | None
    sheet: ExactSheet | None = None
    own: int = -1


class Shape:
    """Bodies over numbered forms; `faces` False where a body's faces are not compared."""

    def __init__(self, references: Sequence[Formula | ExactSheet], faces: bool = True) -> None:
        self.faces = faces
        self.forms: list[Form] = []
        self.numbers: dict[int, int] = {}
        self._known: dict[Any, int] = {}
        self.bodies = [self._body(reference) for reference in references]

    def _body(self, reference: Formula | ExactSheet) -> Body:
        if isinstance(reference, ExactSheet):
            own = self._number(reference.surface)
            return Body(self._numbered(reference.clip), reference, own)
        return Body(self._numbered(reference))

    def _numbered(self, formula: Formula | None) -> Formula | None:
        for f in forms_of(formula) if formula is not None else ():
            self._number(f)
        return formula

    def _number(self, f: Form) -> int:
        number = self._known.setdefault(f.name, len(self.forms))
        if number == len(self.forms):
            self.forms.append(f)
        self.numbers[id(f)] = number
        return number

    def faces_of(self, number: int) -> list[int]:
        """The face that each form is of a solid body; -1 where it is none or is not told."""
        formula = self.bodies[number].formula
        found = [-1] * len(self.forms)
        if self.faces and formula is not None:
            for f in reversed(list(forms_of(formula))):
                found[self.numbers[id(f)]] = f.face
        return found

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

    def closed(self, formula: Formula, before: Callable[[int], Any], after: Callable[[int], Any]) -> Any:
        """Is a point of the ray in a clip?  Its cells are closed: they hold it if they hold what is just before or after."""

        def held(forms: Sequence[Form]) -> Any:
            numbers = [self.numbers[id(f)] for f in forms]
            return np.logical_or(_every(map(before, numbers)), _every(map(after, numbers)))

        return self.combined(formula, held)

    def body_at(self, point: Sequence[float]) -> int:
        """The first body that holds a point, or -1. Leaves are closed, combinations exactly Boolean; sheets hold nothing."""
        for number, body in enumerate(self.bodies):
            if body.sheet is not None or body.formula is None:
                continue
            if self.truth(body.formula, lambda i: value_sign(self.forms[i], point) <= 0):
                return number
        return -1


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
    """`start`: the form whose surface the ray starts on; one root of it, the nearest to t = 0, is taken out."""
    every: list[Root] = []
    before = []
    for index, f in enumerate(shape.forms):
        quadratic = ray.quadratic(f)
        found = roots(index, f, quadratic)
        negative = sign_at_start(f, quadratic, bool(found))
        if start != SKIPPED and found and (index == start or f.same_surface(shape.forms[start])):
            gone = found[0] if len(found) == 1 or abs(found[0].at(200)) < abs(found[1].at(200)) else found[1]
            negative = not negative  # so that all is right where t > 0
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
    """All crossings of the whole line, in order; at equal t by body."""
    met = events(shape, ray, start)
    states = met.states()
    found: list[tuple[int, int, ExactCrossing]] = []
    for number, body in enumerate(shape.bodies):
        one = _solid_crossings if body.sheet is None else _sheet_crossings
        found += [(k, number, crossing) for k, crossing in one(shape, number, met, states, ray)]
    return [crossing for _, _, crossing in sorted(found, key=lambda item: item[:2])]


Placed = list[tuple[int, ExactCrossing]]


def _solid_crossings(shape: Shape, number: int, met: Events, states: list[list[bool]], ray: ExactRay) -> Placed:
    formula = shape.bodies[number].formula
    assert formula is not None
    own = {shape.numbers[id(f)] for f in forms_of(formula)}
    faces = shape.faces_of(number)
    truths = [bool(shape.truth(formula, state.__getitem__)) for state in states]
    found = []
    for k, group in enumerate(met.groups):
        entering = truths[k + 1]
        if entering == truths[k]:
            continue
        mine = [r for r in group if r.index in own]
        turned = [r for r in mine if states[k + 1][r.index] == entering] or mine
        chosen = min(turned, key=lambda r: faces[r.index])
        found.append((k, ExactCrossing(chosen, entering, faces[chosen.index], number)))
    return found


def _sheet_crossings(shape: Shape, number: int, met: Events, states: list[list[bool]], ray: ExactRay) -> Placed:
    body = shape.bodies[number]
    sheet = body.sheet
    assert sheet is not None
    found = []
    for k, group in enumerate(met.groups):
        root = next((r for r in group if r.index == body.own), None)
        if root is None:
            continue
        entering = states[k + 1][body.own]
        if sheet.one_sided and not entering:
            continue
        if body.formula is not None and not shape.closed(
            body.formula, states[k].__getitem__, states[k + 1].__getitem__
        ):
            continue
        if sheet.loop and not in_loop(sheet, ray):
            continue
        found.append((k, ExactCrossing(root, entering, 0, number)))
    return found


def in_loop(sheet: ExactSheet, ray: ExactRay) -> bool:
    """Even-odd as documented: vertices seen along the ray, (u, v) = (d_z X - d_x Z, d_z Y - d_y Z) with z the longest axis
    of the direction (ties: z before x before y); an edge counts from its lower end inclusive, where u > 0."""
    dx, dy, dz = (abs(c) for c in ray.d)
    longest = 2 if dz >= dx and dz >= dy else 0 if dx >= dy else 1
    iu, iv, iw = ((1, 2, 0), (2, 0, 1), (0, 1, 2))[longest]
    seen = []
    for p in sheet.loop:
        x = [total((c * ray.w, -fmpq(o)), exact=False) for c, o in zip(p, ray.o, strict=True)]
        u, v = (total((ray.d[iw] * x[i], -ray.d[i] * x[iw]), exact=False) for i in (iu, iv))
        seen.append((u, v))
    odd = False
    for (ua, va), (ub, vb) in itertools.pairwise([seen[-1], *seen]):
        if (va < 0) != (vb < 0):
            side = total((ua * vb, -ub * va), exact=False)
            if (side > 0) if vb > va else (side < 0):
                odd = not odd
    return odd
