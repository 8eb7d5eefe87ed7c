"""The solids of the public interface as formulas, from the user's parameters."""

from __future__ import annotations

from collections.abc import Callable, Sequence
from typing import Any

from .formula import AllOf, AnyOf, Below, Formula, Not, Surface, plane, quadric, slab
from .frames import Affine, axis_frame, translation
from .precision import length, minus, number, sine_cosine, vector

HERE = Affine()
AXES = ((1, 0, 0), (0, 1, 0), (0, 0, 1))


def square(x: Any) -> Any:
    return number(x) ** 2


def joined(*parts: Formula) -> Formula:
    return parts[0] if len(parts) == 1 else AllOf(parts)


def sphere(radius: Any = 1, center: Any = (0, 0, 0)) -> Formula:
    return quadric(translation(center).inverse(), (1, 1, 1), -square(radius))


def ellipsoid(radii: Any = (1, 2, 3), center: Any = (0, 0, 0), z_range: Any = None) -> Formula:
    own = translation(center).inverse()
    return joined(quadric(own, [1 / square(r) for r in radii], -1), *slab(own, z_range))


def box(low: Any = (-1, -1, -1), high: Any = (1, 1, 1)) -> Formula:
    """Faces 0 to 5: low and high x, low and high y, low and high z."""
    parts = []
    for i, axis in enumerate(AXES):
        parts.append(plane(HERE, [-c for c in axis], -number(low[i]), 2 * i))
        parts.append(plane(HERE, axis, high[i], 2 * i + 1))
    return AllOf(tuple(parts))


def sector(
    own: Affine, start_angle: Any, end_angle: Any, faces: tuple[int | None, int | None] = (3, 4)
) -> Formula | None:
    """The wedge counter-clockwise from start_angle to end_angle about z."""
    turn = number(end_angle) - number(start_angle)
    if turn == 360:
        return None
    sine, cosine = sine_cosine(start_angle)
    after_start = plane(own, (sine, -cosine, 0), 0, faces[0])
    sine, cosine = sine_cosine(end_angle)
    before_end = plane(own, (-sine, cosine, 0), 0, faces[1])
    return (AllOf if turn <= 180 else AnyOf)((after_start, before_end))


def cylinder(
    start: Any, end: Any, radius: Any, start_angle: Any = 0, end_angle: Any = 360, reference: Any = None
) -> Formula:
    own = axis_frame(start, end, reference).inverse()
    height = length(minus(vector(end), vector(start)))
    wedge = sector(own, start_angle, end_angle)
    parts = [quadric(own, (1, 1, 0), -square(radius)), *slab(own, (0, height)), wedge]
    return AllOf(tuple(p for p in parts if p is not None))


def cone(start: Any, end: Any, start_radius: Any, end_radius: Any) -> Formula:
    """x² + y² <= (r0 + (r1 - r0) z / h)², 0 <= z <= h along the axis."""
    own = axis_frame(start, end, None).inverse()
    height = length(minus(vector(end), vector(start)))
    r0 = number(start_radius)
    k = (number(end_radius) - r0) / height
    return AllOf((quadric(own, (1, 1, -k * k), -r0 * r0, z=-2 * r0 * k), *slab(own, (0, height))))


def double_cone(slope: Any = 1, z_range: Any = None) -> Formula:
    return joined(quadric(HERE, (1, 1, -square(slope)), 0), *slab(HERE, z_range))


def elliptic_paraboloid(A: Any, E: Any, z_range: Any = None) -> Formula:
    return joined(quadric(HERE, (A, E, 0), 0, z=-1), *slab(HERE, z_range))


def canonical(signs: Sequence[int], constant: int) -> Callable[..., Formula]:
    """± A x² ± E y² ± H z² + constant <= 0 cut by z_range."""

    def build(A: Any, E: Any, H: Any, z_range: Any = None) -> Formula:
        squares = [s * number(k) for s, k in zip(signs, (A, E, H), strict=True)]
        return joined(quadric(HERE, squares, constant), *slab(HERE, z_range))

    return build


def elliptic_cylinder(A: Any, E: Any, z_range: Any = None) -> Formula:
    return joined(quadric(HERE, (A, E, 0), -1), *slab(HERE, z_range))


def boxed(formula: Formula, within: Any) -> Formula:
    """Cut by a box given as (low, high); its faces come after the quadric."""
    if within is None:
        return formula
    planes = list(box(*within).surfaces())
    renumbered = [Below(Surface(s.terms, s.own, None if s.face is None else s.face + 1)) for s in planes]
    return AllOf((formula, *renumbered))


def hyperbolic_paraboloid(A: Any, E: Any, within: Any = None) -> Formula:
    return boxed(quadric(HERE, (A, -number(E), 0), 0, z=-1), within)


def hyperbolic_cylinder(A: Any, E: Any, within: Any = None) -> Formula:
    return boxed(quadric(HERE, (A, -number(E), 0), -1), within)


def parabolic_cylinder(G: Any, within: Any = None) -> Formula:
    return boxed(quadric(HERE, (1, 0, 0), 0, y=-2 * number(G)), within)


def from_matrix(matrix: Any) -> Formula:
    terms = [(number(matrix[i][j]), min(i, j), max(i, j)) for i in range(4) for j in range(4)]
    return Below(Surface(tuple(t for t in terms if t[0]), HERE, 0))


NAMED = {"xx": (0, 0), "yy": (1, 1), "zz": (2, 2), "xy": (0, 1), "yz": (1, 2), "xz": (0, 2),
         "x": (0, 3), "y": (1, 3), "z": (2, 3), "constant": (3, 3)}  # fmt: skip


def general(matrix: Any = None, coefficients: Any = None) -> Formula:
    if matrix is not None:
        return from_matrix(matrix)
    return Below(Surface(tuple((number(k), *NAMED[name]) for name, k in coefficients.items() if k), HERE, 0))


def half_space(normal: Any, offset: Any) -> Formula:
    return plane(HERE, normal, offset, 0)


def polyhedron(normals: Any, offsets: Any) -> Formula:
    return AllOf(tuple(plane(HERE, n, d, i) for i, (n, d) in enumerate(zip(normals, offsets, strict=True))))


def spheres(centers: Any, radii: Any) -> Formula:
    return AnyOf(tuple(sphere(r, c) for r, c in zip(radii, centers, strict=True)))


SOLIDS: dict[str, Callable[..., Formula]] = {
    "Sphere": sphere,
    "Ellipsoid": ellipsoid,
    "Box": box,
    "Cylinder": cylinder,
    "Cone": cone,
    "DoubleCone": double_cone,
    "EllipticParaboloid": elliptic_paraboloid,
    "HyperbolicParaboloid": hyperbolic_paraboloid,
    "OneSheetHyperboloid": canonical((1, 1, -1), -1),
    "TwoSheetHyperboloid": canonical((1, 1, -1), 1),
    "EllipticCone": canonical((1, 1, -1), 0),
    "EllipticCylinder": elliptic_cylinder,
    "HyperbolicCylinder": hyperbolic_cylinder,
    "ParabolicCylinder": parabolic_cylinder,
    "Quadric": general,
    "HalfSpace": half_space,
    "Polyhedron": polyhedron,
    "Spheres": spheres,
}

COMBINED: dict[str, Callable[..., Formula]] = {
    "Union": lambda *parts: AnyOf(parts),
    "Intersection": lambda *parts: AllOf(parts),
    "Difference": lambda first, *others: AllOf((first, *(Not(part) for part in others))),
    "Complement": lambda part: Not(part),
}
