"""Solids as Boolean formulas over polynomials, sheets as a polynomial and its bounds, from the user's parameters.

A formula is ("cell", forms), ("all", parts), ("any", parts) or ("not", part); a cell is closed. Bodies on an oblique
axis w = end - start need no square root: x² + y² = |p|² - (p·w)² / w², and z = p·w / |w|.
"""

from __future__ import annotations

import itertools
import math
from collections.abc import Callable, Iterator, Sequence
from dataclasses import dataclass, replace
from typing import Any

from .forms import Affine, Form, Row, chain, cross, dot, form, minus, plane, row, squared
from .items import Item
from .numbers import ONE, ZERO, Number, cosine, number, rational, root, sine, total

Formula = tuple[str, Any]
AXES = ((1, 0, 0), (0, 1, 0), (0, 0, 1))


@dataclass(frozen=True)
class Sheet:
    """`surface` within the formula `clip` and the closed polygon `loop` (even-odd)."""

    surface: Form
    clip: Formula | None = None
    loop: tuple[Row, ...] = ()
    one_sided: bool = False


@dataclass(frozen=True)
class Body:
    """A solid's formula or a sheet; `faces` is its count of face numbers."""

    formula: Formula | None
    sheet: Sheet | None
    faces: int

    def moved(self, motion: Affine) -> Body:
        """Return it moved. The gradient of a sheet stays on its physical side, with or without a mirror."""
        back = motion.backwards()

        def carried(formula: Formula | None) -> Formula | None:
            return None if formula is None else mapped(formula, lambda f: f.carried(back))

        if self.sheet is None:
            return replace(self, formula=carried(self.formula))
        loop = tuple(motion.point(p) for p in self.sheet.loop)
        surface = self.sheet.surface.carried(back)
        return replace(self, sheet=replace(self.sheet, surface=surface, clip=carried(self.sheet.clip), loop=loop))


def mapped(formula: Formula, change: Callable[[Form], Form]) -> Formula:
    kind, parts = formula
    if kind == "not":
        return kind, mapped(parts, change)
    return kind, tuple(change(part) if kind == "cell" else mapped(part, change) for part in parts)


def forms_of(formula: Formula | None) -> Iterator[Form]:
    kind, parts = formula or ("cell", ())
    if kind == "cell":
        yield from parts
    else:
        for part in [parts] if kind == "not" else parts:
            yield from forms_of(part)


def cell(*forms: Form) -> Formula:
    return "cell", forms


def diagonal(squares: Sequence[Any], constant: Any, y: Any = 0, z: Any = 0, center: Sequence[Any] = (0, 0, 0)) -> Form:
    """Return sum of squares[i] (x_i - center_i)² + y Y + z Z + constant <= 0, face 0."""
    k, c = row(squares), row(center)
    terms: dict[tuple[int, int], Any] = {(i, i): k[i] for i in range(3)}
    terms.update({(i, 3): -2 * k[i] * c[i] for i in range(3)})
    terms[1, 3] += y
    terms[2, 3] += z
    terms[3, 3] = total([constant, *(a * b * b for a, b in zip(k, c, strict=True))])
    return form(terms, flat=False)


def ball(radius: Any, center: Any) -> Form:
    return diagonal((1, 1, 1), -number(radius) * radius, center=center)


def slab(z_range: Any, shift: Any = 0) -> list[Form]:
    """Return low <= z - shift <= high, faces 1 and 2."""
    low, high = z_range or (-math.inf, math.inf)
    found = [] if math.isinf(low) else [plane((0, 0, -1), -number(low) - shift, 1)]
    return found if math.isinf(high) else [*found, plane((0, 0, 1), number(high) + shift, 2)]


def ellipsoid(radii: Any, center: Any = (0, 0, 0), z_range: Any = None) -> Formula:
    """Return an ellipsoid. An end of the range beyond the surface cuts nothing and is not a face."""
    low, high = z_range or (-math.inf, math.inf)
    z_range = (-math.inf if low <= -radii[2] else low, math.inf if high >= radii[2] else high)
    return cell(diagonal([ONE / (number(r) * r) for r in radii], -1, center=center), *slab(z_range, center[2]))


def paraboloid(A: Any, E: Any, z_range: Any = None) -> Formula:
    """Return a paraboloid. An end below 0 cuts nothing."""
    low, high = z_range or (-math.inf, math.inf)
    return cell(diagonal((A, E, 0), 0, z=-1), *slab((-math.inf if low <= 0 else low, high)))


def box_faces(low: Any, high: Any, first: int = 0) -> list[Form]:
    found = []
    for i, axis in enumerate(AXES):
        found.append(plane([-c for c in axis], -number(low[i]), first + 2 * i))
        found.append(plane(axis, high[i], first + 2 * i + 1))
    return found


def boxed(curved: Form, within: Any) -> Formula:
    return cell(curved, *([] if within is None else box_faces(*within, first=1)))


class Axis:
    """Start, w = end - start and, towards the reference, u across it (not of unit length)."""

    def __init__(self, start: Any, end: Any, reference: Any = None) -> None:
        self.start = row(start)
        self.w = minus(row(end), self.start)
        self.square = dot(self.w, self.w)
        if reference is not None:
            v = minus(row(reference), self.start)
            along = dot(v, self.w)
            self.u = tuple(self.square * a - along * b for a, b in zip(v, self.w, strict=True))

    def across(self) -> list[tuple[Number, Row]]:
        """Return (x² + y²) w² as squares of rows: |p|² w² - (p·w)²."""
        return [(self.square, self._row(row(n))) for n in AXES] + [(-ONE, self._row(self.w))]

    def _row(self, n: Row) -> Row:
        """Return n·(p - start) as four numbers."""
        return (*n, -dot(n, self.start))

    def caps(self) -> list[Form]:
        h = dot(self.w, self.start)
        return [plane([-c for c in self.w], -h, 1), plane(self.w, h + self.square, 2)]

    def side(self, radius: Any) -> Form:
        return squared([*self.across(), (-(number(radius) * radius) * self.square, (0, 0, 0, 1))])

    def cone(self, start_radius: Any, end_radius: Any) -> Form:
        """Return (x² + y²) w² <= w² (r0 + (r1 - r0) p·w / w²)²."""
        growth = number(end_radius) - number(start_radius)
        n = self._row(tuple(growth * c / self.square for c in self.w))
        return squared([*self.across(), (-self.square, (*n[:3], n[3] + start_radius))])

    def wall(self, angle: Any, sense: int, face: int) -> Form:
        """Return sense (sin X - cos Y) <= 0, X = u / |u|, Y = w × u / (|w| |u|), times |u| |w|."""
        s, c, y = sine(angle), cosine(angle), cross(self.w, self.u)
        if s and c:
            s = s * root(self.square)  # of one direction alone any positive factor will do
        n = [total((s * a, -c * b)) * sense for a, b in zip(self.u, y, strict=True)]
        return plane(n, dot(n, self.start), face)

    def wedged(self, forms: Sequence[Form], start_angle: Any, end_angle: Any) -> Formula:
        """Cut some forms by the walls from the start to the end angle."""
        turn = rational(end_angle) - rational(start_angle)
        if turn == 360:
            return cell(*forms)
        walls = [self.wall(start_angle, 1, 3)]
        if turn != 180:
            walls.append(self.wall(end_angle, -1, 4))
        if turn <= 180:
            return cell(*forms, *walls)
        return "all", (cell(*forms), ("any", tuple(map(cell, walls))))


def cylinder(
    start: Any, end: Any, radius: Any, start_angle: Any = 0, end_angle: Any = 360, reference: Any = None
) -> Formula:
    axis = Axis(start, end, reference)
    return axis.wedged([axis.side(radius), *axis.caps()], start_angle, end_angle)


def cone(start: Any, end: Any, start_radius: Any, end_radius: Any) -> Formula:
    axis = Axis(start, end)
    return cell(axis.cone(start_radius, end_radius), *axis.caps())


def canonical(signs: Sequence[int], constant: int) -> Callable[..., Formula]:
    """Return the maker of ± A x² ± E y² ± H z² + constant <= 0 cut by z_range."""

    def build(A: Any, E: Any, H: Any = 0, z_range: Any = None) -> Formula:
        squares = [s * number(k) for s, k in zip(signs, (A, E, H), strict=True)]
        return cell(diagonal(squares, constant), *slab(z_range))

    return build


NAMED = {"xx": (0, 0), "yy": (1, 1), "zz": (2, 2), "xy": (0, 1), "yz": (1, 2), "xz": (0, 2),
         "x": (0, 3), "y": (1, 3), "z": (2, 3), "constant": (3, 3)}  # fmt: skip


def general(matrix: Any = None, coefficients: Any = None) -> Formula:
    if matrix is None:
        return cell(form({NAMED[name]: k for name, k in coefficients.items()}))
    terms: dict[tuple[int, int], Any] = {}
    for i, j in itertools.product(range(4), repeat=2):
        terms[min(i, j), max(i, j)] = terms.get((min(i, j), max(i, j)), ZERO) + matrix[i][j]
    return cell(form(terms))


def disc(center: Any, normal: Any, radius: Any) -> Sheet:
    return Sheet(plane(normal, dot(normal, center)), cell(ball(radius, center)))


def polygon(vertices: Any) -> Sheet:
    """The plane is Newell's, through the mean of the vertices."""
    points = [row(v) for v in vertices]
    spokes = [minus(p, points[0]) for p in points]
    pairs = [cross(p, q) for p, q in itertools.pairwise(spokes)]
    normal = [total(n[i] for n in pairs) for i in range(3)]
    middle = [total(p[i] for p in points) / len(points) for i in range(3)]
    return Sheet(plane(normal, dot(normal, middle)), loop=tuple(points))


def cylinder_patch(
    start: Any, end: Any, radius: Any, start_angle: Any = 0, end_angle: Any = 360, reference: Any = None
) -> Sheet:
    axis = Axis(start, end, reference)
    return Sheet(axis.side(radius), axis.wedged(axis.caps(), start_angle, end_angle))


PLAIN: dict[str, Callable[..., Formula | Sheet]] = {
    "Sphere": lambda radius=1, center=(0, 0, 0): cell(ball(radius, center)),
    "Ellipsoid": ellipsoid,
    "Box": lambda low=(-1, -1, -1), high=(1, 1, 1): cell(*box_faces(low, high)),
    "Cylinder": cylinder,
    "Cone": cone,
    "DoubleCone": lambda slope=1, z_range=None: cell(diagonal((1, 1, -number(slope) * slope), 0), *slab(z_range)),
    "EllipticParaboloid": paraboloid,
    "HyperbolicParaboloid": lambda A, E, within=None: boxed(diagonal((A, -number(E), 0), 0, z=-1), within),
    "OneSheetHyperboloid": canonical((1, 1, -1), -1),
    "TwoSheetHyperboloid": canonical((1, 1, -1), 1),
    "EllipticCone": canonical((1, 1, -1), 0),
    "EllipticCylinder": canonical((1, 1, 0), -1),
    "HyperbolicCylinder": lambda A, E, within=None: boxed(diagonal((A, -number(E), 0), -1), within),
    "ParabolicCylinder": lambda G, within=None: boxed(diagonal((1, 0, 0), 0, y=-2 * number(G)), within),
    "Quadric": general,
    "HalfSpace": lambda normal, offset: cell(plane(normal, offset)),
    "Polyhedron": lambda normals, offsets: cell(*(plane(n, d, i) for i, (n, d) in enumerate(zip(normals, offsets, strict=True)))),
    "Plane": lambda normal, offset, one_sided=False: Sheet(plane(normal, offset), one_sided=one_sided),
    "Disc": disc,
    "Triangle": lambda a, b, c: polygon((a, b, c)),
    "Polygon": polygon,
    "CylinderPatch": cylinder_patch,
}  # fmt: skip


def body(item: Item, first_face: int = 0) -> Body:
    """Return the body of one item; faces numbered from `first_face` on."""
    if item.kind == "ClippedSheet":
        found = _clipped(item)
    elif item.operands:
        found = _boolean(item, first_face)
    else:
        primitive = PLAIN[item.kind](**item.parameters)
        if isinstance(primitive, Sheet):
            found = Body(None, primitive, 1)
        else:
            count = 1 + max(f.face for f in forms_of(primitive))
            found = Body(mapped(primitive, lambda f: f.numbered(first_face)), None, count)
    return found.moved(chain(item.exact_steps)) if item.steps else found


def _clipped(item: Item) -> Body:
    base, solid = (body(operand) for operand in item.operands)
    clip = ("not", solid.formula) if item.parameters["keep"] == "outside" else solid.formula
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
        formula: Formula = ("not", first)
    elif item.kind == "Difference":
        formula = ("all", (first, *(("not", other) for other in others)))
    else:
        formula = ("any" if item.kind == "Union" else "all", tuple(formulas))
    return Body(formula, None, face - first_face)


def bodies(items: Sequence[Item]) -> list[Body]:
    """Return the bodies of a scene in listing order, a ball each of `Spheres`."""
    found = []
    for item in items:
        if item.kind == "Spheres":
            assert not item.steps, "a motion of bulk spheres rounds them"
            for center, radius in zip(item.parameters["centers"], item.parameters["radii"], strict=True):
                found.append(body(Item("Sphere", {"center": center, "radius": radius})))
        else:
            found.append(body(item))
    return found
