"""Solids as Boolean formulas over exact forms, from the user's parameters.

A formula is ("cell", forms), ("all", parts), ("any", parts) or ("not", part); a cell is closed. Bodies on an oblique
axis w = end - start need no square root: x² + y² = |p|² - (p·w)² / w², and z = p·w / |w|.
"""

from __future__ import annotations

import math
from collections.abc import Callable, Iterable, Sequence
from typing import Any

from flint import fmpq

from .forms import Affine, Form, carried, form, plane, squared
from .rational import ONE, ZERO, cross, dot, exactly, minus, root, sine_cosine, total, vector

Formula = tuple[str, Any]
AXES = ((1, 0, 0), (0, 1, 0), (0, 0, 1))


def cell(*forms: Form) -> Formula:
    return ("cell", tuple(forms))


def mapped(formula: Formula, change: Callable[[Form], Form]) -> Formula:
    kind, parts = formula
    if kind == "cell":
        return kind, tuple(change(f) for f in parts)
    if kind == "not":
        return kind, mapped(parts, change)
    return kind, tuple(mapped(part, change) for part in parts)


def moved(formula: Formula, motion: Affine) -> Formula:
    back = motion.inverse()
    return mapped(formula, lambda f: carried(f, back))


def forms_of(formula: Formula) -> Iterable[Form]:
    kind, parts = formula
    if kind == "cell":
        yield from parts
    else:
        for part in [parts] if kind == "not" else parts:
            yield from forms_of(part)


def diagonal(squares: Sequence[Any], constant: Any, y: Any = 0, z: Any = 0, center: Sequence[Any] = (0, 0, 0)) -> Form:
    """sum of squares[i] (x_i - center_i)² + y Y + z Z + constant <= 0, face 0"""
    k, c = vector(squares), vector(center)
    terms: dict[tuple[int, int], Any] = {(i, i): k[i] for i in range(3)}
    terms.update({(i, 3): -2 * k[i] * c[i] for i in range(3)})
    terms[1, 3] += exactly(y)
    terms[2, 3] += exactly(z)
    terms[3, 3] = exactly(constant) + sum((a * b * b for a, b in zip(k, c, strict=True)), ZERO)
    result = form(terms)
    return Form(result.k, 0, True, False)


def sphere(radius: Any = 1, center: Any = (0, 0, 0)) -> Formula:
    return cell(diagonal((1, 1, 1), -(exactly(radius) ** 2), center=center))


def slab(z_range: Any, shift: Any = 0) -> list[Form]:
    """low <= z - shift <= high, faces 1 and 2"""
    if z_range is None:
        return []
    low, high = (float(z) for z in z_range)
    found = [] if math.isinf(low) else [plane((0, 0, -1), -(exactly(low) + exactly(shift)), 1)]
    return found if math.isinf(high) else [*found, plane((0, 0, 1), exactly(high) + exactly(shift), 2)]


def ellipsoid(radii: Any = (1, 2, 3), center: Any = (0, 0, 0), z_range: Any = None) -> Formula:
    return cell(diagonal([1 / exactly(r) ** 2 for r in radii], -1, center=center), *slab(z_range, center[2]))


def box_faces(low: Any, high: Any, first: int = 0) -> list[Form]:
    found = []
    for i, axis in enumerate(AXES):
        found.append(plane([-c for c in axis], -exactly(low[i]), first + 2 * i))
        found.append(plane(axis, high[i], first + 2 * i + 1))
    return found


def box(low: Any = (-1, -1, -1), high: Any = (1, 1, 1)) -> Formula:
    return cell(*box_faces(low, high))


class Axis:
    """Start, w = end - start and, towards the reference, u across it (not of unit length)."""

    def __init__(self, start: Any, end: Any, reference: Any = None) -> None:
        self.start = vector(start)
        self.w = minus(vector(end), self.start)
        self.square = dot(self.w, self.w)
        if reference is not None:
            v = minus(vector(reference), self.start)
            along = dot(v, self.w)
            self.u = tuple(self.square * a - along * b for a, b in zip(v, self.w, strict=True))

    def row(self, n: Sequence[fmpq]) -> tuple[fmpq, ...]:
        """n·(p - start) as four numbers"""
        return (*n, -dot(n, self.start))

    def across(self) -> list[tuple[fmpq, tuple[fmpq, ...]]]:
        """(x² + y²) w² as squares of rows: |p|² w² - (p·w)²"""
        unit = [tuple(fmpq(c) for c in axis) for axis in AXES]
        return [(self.square, self.row(n)) for n in unit] + [(-ONE, self.row(self.w))]

    def caps(self) -> list[Form]:
        h = dot(self.w, self.start)
        return [plane([-c for c in self.w], -h, 1), plane(self.w, h + self.square, 2)]

    def wall(self, angle: Any, sense: int, face: int) -> Form:
        """sense (sin X - cos Y) <= 0, X = u / |u|, Y = w × u / (|w| |u|); times |u| |w|"""
        s, c, exact = sine_cosine(angle)
        y = cross(self.w, self.u)
        length, rational = root(self.square)
        if not s or not c:  # one of the two directions alone: any positive factor will do
            n = [sense * (s * a - c * b) for a, b in zip(self.u, y, strict=True)]
            return plane(n, dot(n, self.start), face)
        exact = exact and rational
        n = [sense * total((s * length * a, -c * b), exact) for a, b in zip(self.u, y, strict=True)]
        return plane(n, dot(n, self.start, exact), face, exact)


CONSTANT = (ZERO, ZERO, ZERO, ONE)


def walls(axis: Axis, start_angle: Any, end_angle: Any) -> tuple[list[Form], bool]:
    """(walls of the wedge from start_angle to end_angle, whether it is convex)"""
    turn = exactly(end_angle) - exactly(start_angle)
    if turn == 360:
        return [], True
    found = [axis.wall(start_angle, 1, 3)]
    return (found if turn == 180 else [*found, axis.wall(end_angle, -1, 4)]), turn <= 180


def wedged(forms: Sequence[Form], axis: Axis, start_angle: Any, end_angle: Any) -> Formula:
    sides, convex = walls(axis, start_angle, end_angle)
    if convex:
        return cell(*forms, *sides)
    return ("all", (cell(*forms), ("any", tuple(cell(side) for side in sides))))


def cylinder_side(axis: Axis, radius: Any) -> Form:
    return squared([*axis.across(), (-(exactly(radius) ** 2) * axis.square, CONSTANT)])


def cylinder(
    start: Any, end: Any, radius: Any, start_angle: Any = 0, end_angle: Any = 360, reference: Any = None
) -> Formula:
    axis = Axis(start, end, reference)
    return wedged([cylinder_side(axis, radius), *axis.caps()], axis, start_angle, end_angle)


def cone(start: Any, end: Any, start_radius: Any, end_radius: Any) -> Formula:
    """(x² + y²) w² <= w² (r0 + (r1 - r0) p·w / w²)²"""
    axis = Axis(start, end)
    r0, growth = exactly(start_radius), exactly(end_radius) - exactly(start_radius)
    row = axis.row([growth * c / axis.square for c in axis.w])
    return cell(squared([*axis.across(), (-axis.square, (*row[:3], row[3] + r0))]), *axis.caps())


def double_cone(slope: Any = 1, z_range: Any = None) -> Formula:
    return cell(diagonal((1, 1, -(exactly(slope) ** 2)), 0), *slab(z_range))


def canonical(signs: Sequence[int], constant: int) -> Callable[..., Formula]:
    def build(A: Any, E: Any, H: Any = 0, z_range: Any = None) -> Formula:
        squares = [s * exactly(k) for s, k in zip(signs, (A, E, H), strict=True)]
        return cell(diagonal(squares, constant), *slab(z_range))

    return build


def boxed(curved: Form, within: Any) -> Formula:
    return cell(curved, *([] if within is None else box_faces(*within, first=1)))


NAMED = {"xx": (0, 0), "yy": (1, 1), "zz": (2, 2), "xy": (0, 1), "yz": (1, 2), "xz": (0, 2),
         "x": (0, 3), "y": (1, 3), "z": (2, 3), "constant": (3, 3)}  # fmt: skip


def general(matrix: Any = None, coefficients: Any = None) -> Formula:
    if matrix is None:
        return cell(form({NAMED[name]: k for name, k in coefficients.items()}))
    terms: dict[tuple[int, int], fmpq] = {}
    for i in range(4):
        for j in range(4):
            pair = (min(i, j), max(i, j))
            terms[pair] = terms.get(pair, ZERO) + exactly(matrix[i][j])
    return cell(form(terms))


SOLIDS: dict[str, Callable[..., Formula]] = {
    "Sphere": sphere,
    "Ellipsoid": ellipsoid,
    "Box": box,
    "Cylinder": cylinder,
    "Cone": cone,
    "DoubleCone": double_cone,
    "EllipticParaboloid": lambda A, E, z_range=None: cell(diagonal((A, E, 0), 0, z=-1), *slab(z_range)),
    "HyperbolicParaboloid": lambda A, E, within=None: boxed(diagonal((A, -exactly(E), 0), 0, z=-1), within),
    "OneSheetHyperboloid": canonical((1, 1, -1), -1),
    "TwoSheetHyperboloid": canonical((1, 1, -1), 1),
    "EllipticCone": canonical((1, 1, -1), 0),
    "EllipticCylinder": canonical((1, 1, 0), -1),
    "HyperbolicCylinder": lambda A, E, within=None: boxed(diagonal((A, -exactly(E), 0), -1), within),
    "ParabolicCylinder": lambda G, within=None: boxed(diagonal((1, 0, 0), 0, y=-2 * exactly(G)), within),
    "Quadric": general,
    "HalfSpace": lambda normal, offset: cell(plane(normal, offset)),
    "Polyhedron": lambda normals, offsets: cell(
        *(plane(n, d, i) for i, (n, d) in enumerate(zip(normals, offsets, strict=True)))
    ),
}

COMBINED: dict[str, Callable[..., Formula]] = {
    "Union": lambda *parts: ("any", parts),
    "Intersection": lambda *parts: ("all", parts),
    "Difference": lambda first, *others: ("all", (first, *(("not", part) for part in others))),
    "Complement": lambda part: ("not", part),
}
