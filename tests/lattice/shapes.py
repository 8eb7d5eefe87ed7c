"""Solids as Boolean formulas over polynomials, sheets as a polynomial and what bounds them, from the user's parameters.

A formula is ("cell", forms), ("all", parts), ("any", parts) or ("not", part). Shapes in their own frames are rational
and those of the exactness suite; what is irrational there (walls of wedges) and motions are worked out here.
"""

from __future__ import annotations

import math
from collections.abc import Callable, Iterator, Sequence
from dataclasses import dataclass, replace
from typing import Any

from ..exactness import sheets as plain_sheets
from ..exactness import solids as plain
from ..exactness.forms import Form as PlainForm
from .field import Number, cosine, number, rational, root, sine
from .items import Item
from .motions import PAIRS, ZERO, Affine, Row, chain, cross, dot, row, total

Formula = tuple[str, Any]


@dataclass(frozen=True, eq=False)
class Form:
    """sum of k X_i X_j <= 0 over PAIRS, mixed coefficients once; `flat`: a plane, of a face of a body"""

    k: Row
    face: int
    flat: bool

    def numbered(self, first: int) -> Form:
        return replace(self, face=self.face + first)

    @property
    def side(self) -> int:
        """Of a plane: the sign of the first component of its normal that is not zero."""
        return next((k.sign for k in self.k[6:9] if k), 0)

    def carried(self, back: Sequence[Row]) -> Form:
        """The form of x where f is that of back x, back having four rows of four."""
        if self.flat:
            n = (*self.k[6:9], self.k[9])
            return Form((ZERO,) * 6 + tuple(dot(n, column) for column in zip(*back, strict=True)), self.face, True)
        terms = [(k, i, j) for k, (i, j) in zip(self.k, PAIRS, strict=True) if k]
        found = []
        for m, n in PAIRS:
            value = total(k * back[i][m] * back[j][n] for k, i, j in terms)
            if m != n:
                value = value + total(k * back[i][n] * back[j][m] for k, i, j in terms)
            found.append(value)
        return Form(tuple(found), self.face, False)


@dataclass(frozen=True)
class Sheet:
    """`surface` within the formula `clip` and the closed polygon `loop` (even-odd)."""

    surface: Form
    clip: Formula | None = None
    loop: tuple[Row, ...] = ()
    one_sided: bool = False


@dataclass(frozen=True)
class Body:
    """A solid's formula or a sheet; `faces`: how many face numbers it takes."""

    formula: Formula | None
    sheet: Sheet | None
    faces: int


def mapped(formula: Formula, change: Callable[[Form], Form]) -> Formula:
    kind, parts = formula
    if kind == "cell":
        return kind, tuple(change(f) for f in parts)
    if kind == "not":
        return kind, mapped(parts, change)
    return kind, tuple(mapped(part, change) for part in parts)


def forms_of(formula: Formula | None) -> Iterator[Form]:
    if formula is None:
        return
    kind, parts = formula
    if kind == "cell":
        yield from parts
    else:
        for part in [parts] if kind == "not" else parts:
            yield from forms_of(part)


def _taken(form: PlainForm) -> Form:
    assert form.exact
    return Form(tuple(number(k) for k in form.k), form.face, form.flat)


def _formula(formula: Any) -> Formula:
    kind, parts = formula
    if kind == "cell":
        return kind, tuple(_taken(f) for f in parts)
    return kind, _formula(parts) if kind == "not" else tuple(_formula(p) for p in parts)


def moved(formula: Formula, motion: Affine) -> Formula:
    back, _ = motion.backwards()
    return mapped(formula, lambda f: f.carried(back))


def _moved_sheet(sheet: Sheet, motion: Affine) -> Sheet:
    """The gradient stays on its physical side, mirror or not."""
    back, _ = motion.backwards()
    return replace(
        sheet,
        surface=sheet.surface.carried(back),
        clip=None if sheet.clip is None else mapped(sheet.clip, lambda f: f.carried(back)),
        loop=tuple(motion.point(p) for p in sheet.loop),
    )


def _wall(axis: plain.Axis, angle: Any, sense: int, face: int) -> Form:
    """sense (sin X - cos Y) <= 0, X = u / |u|, Y = w × u / (|w| |u|); times |u| |w|"""
    s, c = sine(angle) * root(axis.square), cosine(angle)
    n = [(s * a - c * b) * sense for a, b in zip(axis.u, cross(axis.w, axis.u), strict=True)]
    return Form((ZERO,) * 6 + (*n, -dot(n, axis.start)), face, True)


def _wedge(axis: plain.Axis, start_angle: Any, end_angle: Any) -> tuple[list[Form], bool]:
    turn = rational(end_angle) - rational(start_angle)
    if turn == 360:
        return [], True
    walls = [_wall(axis, start_angle, 1, 3)]
    return (walls if turn == 180 else [*walls, _wall(axis, end_angle, -1, 4)]), turn <= 180


def _around(forms: Sequence[Form], axis: plain.Axis, start_angle: Any, end_angle: Any) -> Formula:
    walls, convex = _wedge(axis, start_angle, end_angle)
    if convex:
        return "cell", (*forms, *walls)
    return "all", (("cell", tuple(forms)), ("any", tuple(("cell", (wall,)) for wall in walls)))


def _cylinder(
    start: Any, end: Any, radius: Any, start_angle: Any = 0, end_angle: Any = 360, reference: Any = None
) -> Formula:
    axis = plain.Axis(start, end, reference)
    forms = [_taken(f) for f in (plain.cylinder_side(axis, radius), *axis.caps())]
    return _around(forms, axis, start_angle, end_angle)


def _patch(
    start: Any, end: Any, radius: Any, start_angle: Any = 0, end_angle: Any = 360, reference: Any = None
) -> Sheet:
    axis = plain.Axis(start, end, reference)
    clip = _around([_taken(f) for f in axis.caps()], axis, start_angle, end_angle)
    return Sheet(_taken(plain.cylinder_side(axis, radius)), clip)


def _sheet(item: Item) -> Sheet:
    if item.kind == "CylinderPatch":
        return _patch(**item.parameters)
    made = plain_sheets.SHEETS[item.kind](**item.parameters)
    loop = tuple(row(p) for p in made.loop)
    return Sheet(_taken(made.surface), None if made.clip is None else _formula(made.clip), loop, made.one_sided)


def _solid(item: Item) -> Formula:
    if item.kind == "Cylinder":
        return _cylinder(**item.parameters)
    return _formula(plain.SOLIDS[item.kind](**_reached(item)))


def _reached(item: Item) -> dict[str, Any]:
    """The parameters, without those ends of a range that the surface does not reach: they cut nothing and are no faces."""
    low, high = item.parameters.get("z_range") or (-math.inf, math.inf)
    if item.kind == "Ellipsoid":
        pole = item.parameters["radii"][2]
        low, high = -math.inf if low <= -pole else low, math.inf if high >= pole else high
    elif item.kind == "EllipticParaboloid":
        low = -math.inf if low <= 0 else low
    else:
        return item.parameters
    return {**item.parameters, "z_range": (low, high)}


def body(item: Item, first_face: int = 0) -> Body:
    """The body of one item; faces numbered from `first_face` on."""
    if item.kind == "ClippedSheet":
        found = _clipped(item)
    elif item.operands:
        found = _boolean(item, first_face)
    elif item.is_sheet:
        found = Body(None, _sheet(item), 1)
    else:
        formula = _solid(item)
        count = 1 + max(f.face for f in forms_of(formula))
        found = Body(mapped(formula, lambda f: f.numbered(first_face)), None, count)
    if not item.steps:
        return found
    motion = chain(item.exact_steps)
    if found.sheet is not None:
        return replace(found, sheet=_moved_sheet(found.sheet, motion))
    assert found.formula is not None
    return replace(found, formula=moved(found.formula, motion))


def _clipped(item: Item) -> Body:
    base, solid = (body(operand) for operand in item.operands)
    assert base.sheet is not None
    clip = ("not", solid.formula) if item.parameters.get("keep") == "outside" else solid.formula
    assert clip is not None
    whole = clip if base.sheet.clip is None else ("all", (base.sheet.clip, clip))
    return replace(base, sheet=replace(base.sheet, clip=whole))


def _boolean(item: Item, first_face: int) -> Body:
    formulas, face = [], first_face
    for operand in item.operands:
        part = body(operand, face)
        face += part.faces
        formulas.append(part.formula)
    first, *others = formulas
    if item.kind == "Complement":
        made: Formula = ("not", first)
    elif item.kind == "Difference":
        made = ("all", (first, *(("not", other) for other in others)))
    else:
        made = ("any" if item.kind == "Union" else "all", tuple(formulas))
    return Body(made, None, face - first_face)


def bodies(items: Sequence[Item]) -> list[Body]:
    """The bodies of a scene, a ball each of `Spheres`, in listing order."""
    found = []
    for item in items:
        if item.kind == "Spheres":
            assert not item.steps, "a motion of bulk spheres rounds them"
            for center, radius in zip(item.parameters["centers"], item.parameters["radii"], strict=True):
                found.append(body(Item("Sphere", {"center": center, "radius": radius})))
        else:
            found.append(body(item))
    return found


def proportional(a: Form, b: Form) -> int:
    """1 or -1 where a is a positive or negative multiple of b, else 0."""
    if a.flat != b.flat:
        return 0
    pivot = next(i for i, k in enumerate(b.k) if k)
    if not a.k[pivot] or any(x * b.k[pivot] - y * a.k[pivot] for x, y in zip(a.k, b.k, strict=True)):
        return 0
    return a.k[pivot].sign * b.k[pivot].sign


__all__ = ["Body", "Form", "Formula", "Number", "Sheet", "bodies", "body", "forms_of", "proportional"]
