"""Leaves with their inequalities, evaluated by code of the tests' own in the arithmetic of the points given: float64, or mpmath's in arrays of objects.

`functions(x, y, z)` gives arrays that are <= 0 inside; `joined` says how they make the leaf.
"""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import dataclass
from typing import Any

import mpmath
import numpy as np

import conicoid as co

MANY_DIGITS = mpmath.MPContext()
MANY_DIGITS.dps = 60


def number(like: Any, value: float) -> Any:
    """A number in the arithmetic of an array."""
    return MANY_DIGITS.mpf(value) if like.dtype == object else float(value)


def sin_cos(like: Any, degrees: float) -> tuple[Any, Any]:
    """Sine and cosine in the arithmetic of an array; exact at multiples of 90."""
    if degrees % 90 == 0:
        return [(0, 1), (1, 0), (0, -1), (-1, 0)][int(degrees // 90) % 4]
    angle = MANY_DIGITS.radians(MANY_DIGITS.mpf(degrees))
    return number(like, MANY_DIGITS.sin(angle)), number(like, MANY_DIGITS.cos(angle))


@dataclass(frozen=True)
class Leaf:
    shape: Any
    functions: Callable[[Any, Any, Any], list[Any]]
    joined: Callable[..., Any] = np.logical_and.reduce

    def inside(self, points: Any) -> Any:
        return self.joined([f <= 0 for f in self.functions(*points)])


def _range(z: Any, low: float, high: float) -> list[Any]:
    return [low - z, z - high]


def sphere(r: float, c: Any) -> Leaf:
    return Leaf(
        co.Sphere(r, c), lambda x, y, z: [(x - c[0]) ** 2 + (y - c[1]) ** 2 + (z - c[2]) ** 2 - number(x, r) ** 2]
    )


def ellipsoid(radii: Any, c: Any, z_range: Any = None) -> Leaf:
    def functions(x: Any, y: Any, z: Any) -> list[Any]:
        x, y, z = x - c[0], y - c[1], z - c[2]
        return [(x / radii[0]) ** 2 + (y / radii[1]) ** 2 + (z / radii[2]) ** 2 - 1] + (
            _range(z, *z_range) if z_range else []
        )

    return Leaf(co.Ellipsoid(radii, c, z_range), functions)


def box(low: Any, high: Any) -> Leaf:
    def functions(*p: Any) -> list[Any]:
        return [f for x, a, b in zip(p, low, high, strict=True) for f in (a - x, x - b)]

    return Leaf(co.Box(low, high), functions)


def _along(start: Any, end: Any, x: Any, y: Any, z: Any) -> tuple[Any, Any, Any]:
    """(height along the axis times its length, squared distance from it times the square of that, length squared)"""
    a = [number(x, e) - number(x, s) for s, e in zip(start, end, strict=True)]
    p = [c - s for c, s in zip((x, y, z), start, strict=True)]
    square = a[0] ** 2 + a[1] ** 2 + a[2] ** 2
    height = a[0] * p[0] + a[1] * p[1] + a[2] * p[2]
    cross = [a[1] * p[2] - a[2] * p[1], a[2] * p[0] - a[0] * p[2], a[0] * p[1] - a[1] * p[0]]
    return height, cross[0] ** 2 + cross[1] ** 2 + cross[2] ** 2, square


def cylinder(start: Any, end: Any, r: float) -> Leaf:
    def functions(x: Any, y: Any, z: Any) -> list[Any]:
        height, distance, square = _along(start, end, x, y, z)
        return [distance - number(x, r) ** 2 * square, -height, height - square]

    return Leaf(co.Cylinder(start, end, r), functions)


def cone(start: Any, end: Any, r0: float, r1: float) -> Leaf:
    def functions(x: Any, y: Any, z: Any) -> list[Any]:
        height, distance, square = _along(start, end, x, y, z)
        radius = r0 + (number(x, r1) - r0) * height / square
        return [distance - radius**2 * square, -height, height - square]

    return Leaf(co.Cone(start, end, r0, r1), functions)


def wedge(r: float, h: float, first: float, last: float) -> Leaf:
    """About z, angles from x; given in degrees."""
    shape = co.Cylinder((0, 0, 0), (0, 0, h), r, first, last, (1, 0, 0))

    def functions(x: Any, y: Any, z: Any) -> list[Any]:
        (sin_a, cos_a), (sin_b, cos_b) = (sin_cos(x, angle) for angle in (first, last))
        walls = [x * sin_a - y * cos_a, y * cos_b - x * sin_b]
        return [x * x + y * y - number(x, r) ** 2, -z, z - h, *walls]

    def joined(inside: list[Any]) -> Any:
        between = inside[3] & inside[4] if last - first <= 180 else inside[3] | inside[4]
        return inside[0] & inside[1] & inside[2] & between

    return Leaf(shape, functions, joined)


def half_space(n: Any, d: float) -> Leaf:
    return Leaf(co.HalfSpace(n, d), lambda x, y, z: [n[0] * x + n[1] * y + n[2] * z - d])


def polyhedron(normals: Any, offsets: Any) -> Leaf:
    def functions(x: Any, y: Any, z: Any) -> list[Any]:
        return [n[0] * x + n[1] * y + n[2] * z - d for n, d in zip(normals, offsets, strict=True)]

    return Leaf(co.Polyhedron(normals, offsets), functions)


def canonical(
    kind: type, signs: tuple[int, int, int], linear: float, constant: int, values: dict[str, float], **cut: Any
) -> Leaf:
    """±A x² ± E y² ± H z² + linear z + constant <= 0, cut by z_range or within."""
    a, e, h = (values.get(name, 0.0) * sign for name, sign in zip("AEH", signs, strict=True))

    def functions(x: Any, y: Any, z: Any) -> list[Any]:
        result = [a * x * x + e * y * y + h * z * z + linear * z + constant]
        if cut.get("z_range"):
            result += _range(z, *cut["z_range"])
        if cut.get("within"):
            result += box(*cut["within"]).functions(x, y, z)
        return result

    arguments = dict(cut)
    if cut.get("within"):
        arguments["within"] = co.Box(*cut["within"])
    return Leaf(kind(**values, **arguments), functions)


def double_cone(slope: float, z_range: Any) -> Leaf:
    return Leaf(
        co.DoubleCone(slope, z_range),
        lambda x, y, z: [x * x + y * y - number(x, slope) ** 2 * z * z] + (_range(z, *z_range) if z_range else []),
    )


def parabolic_cylinder(g: float, within: Any) -> Leaf:
    shape = co.ParabolicCylinder(g, co.Box(*within) if within else None)
    return Leaf(shape, lambda x, y, z: [x * x - 2 * g * y] + (box(*within).functions(x, y, z) if within else []))


def quadric(matrix: Any) -> Leaf:
    def functions(x: Any, y: Any, z: Any) -> list[Any]:
        p = (x, y, z, 1)
        return [sum(matrix[i][j] * p[i] * p[j] for i in range(4) for j in range(4))]

    return Leaf(co.Quadric(matrix=matrix), functions)


def random_leaf(r: np.random.Generator) -> Leaf:
    """Of any kind, about as large as 1, around the origin."""

    def some(low: float, high: float) -> float:
        return float(r.uniform(low, high))

    def point(reach: float = 1.0) -> tuple[float, float, float]:
        x, y, z = r.uniform(-reach, reach, 3)
        return float(x), float(y), float(z)

    z_range = (some(-1.5, -0.1), some(0.1, 1.5)) if r.random() < 0.6 else None
    within = (point(1.0), tuple(c + 1.5 for c in point(0.4))) if r.random() < 0.6 else None
    aeh = {"A": some(0.3, 3), "E": some(0.3, 3), "H": some(0.3, 3)}
    ae = {"A": aeh["A"], "E": aeh["E"]}
    first = some(0, 360)
    makers: list[Callable[[], Leaf]] = [
        lambda: sphere(some(0.3, 1.5), point()),
        lambda: ellipsoid((some(0.3, 2), some(0.3, 2), some(0.3, 2)), point(), z_range),
        lambda: box(point(), tuple(c + 2 for c in point())),
        lambda: cylinder(point(1.5), point(1.5), some(0.2, 1)),
        lambda: wedge(some(0.5, 1.5), some(0.5, 2), first, first + some(20, 340)),
        lambda: cone(point(1.5), point(1.5), some(0, 1) if r.random() < 0.7 else 0.0, some(0.1, 1)),
        lambda: half_space(point(), some(-0.5, 0.5)),
        lambda: polyhedron(
            [(1, 0.2, 0), (-1, 0, 0.3), (0.1, 1, 0), (0, -1, 0.2), (0.3, 0, 1), (0, 0.1, -1)],
            [some(0.3, 1.2) for _ in range(6)],
        ),
        lambda: double_cone(some(0.3, 1.5), z_range),
        lambda: canonical(
            co.EllipticParaboloid, (1, 1, 0), -1, 0, ae, z_range=(some(-0.5, 0.3), some(0.5, 1.5)) if z_range else None
        ),
        lambda: canonical(co.HyperbolicParaboloid, (1, -1, 0), -1, 0, ae, within=within),
        lambda: canonical(co.OneSheetHyperboloid, (1, 1, -1), 0, -1, aeh, z_range=z_range),
        lambda: canonical(
            co.TwoSheetHyperboloid, (1, 1, -1), 0, 1, aeh, z_range=(some(-3, -2), some(0.5, 3)) if z_range else None
        ),
        lambda: canonical(co.EllipticCone, (1, 1, -1), 0, 0, aeh, z_range=z_range),
        lambda: canonical(co.EllipticCylinder, (1, 1, 0), 0, -1, ae, z_range=z_range),
        lambda: canonical(co.HyperbolicCylinder, (1, -1, 0), 0, -1, ae, within=within),
        lambda: parabolic_cylinder(some(0.2, 1), within),
        lambda: quadric((lambda m: (m + m.T).tolist())(r.uniform(-1, 1, (4, 4)))),
    ]
    while True:
        try:
            return makers[r.integers(len(makers))]()
        except ValueError as error:  # a box that leaves nothing of the solid is refused
            if "a part of the solid" not in str(error):
                raise


def grid_leaf(r: np.random.Generator) -> Leaf:
    """With small integers everywhere, so that faces, edges and corners of different leaves coincide."""

    def whole(low: int, high: int) -> int:
        return int(r.integers(low, high + 1))

    def point() -> tuple[int, int, int]:
        return whole(-2, 1), whole(-2, 1), whole(-2, 1)

    def along(start: tuple[int, int, int]) -> tuple[int, int, int]:
        axis, length = whole(0, 2), whole(1, 3)
        x, y, z = (c + length * (k == axis) for k, c in enumerate(start))
        return x, y, z

    p, normal, factor = point(), (0, 0, 0), whole(1, 3)
    while normal == (0, 0, 0):
        normal = (whole(-1, 1), whole(-1, 1), whole(-1, 1))
    makers: list[Callable[[], Leaf]] = [
        lambda: box(p, (p[0] + whole(1, 3), p[1] + whole(1, 3), p[2] + whole(1, 3))),
        lambda: box(p, (p[0] + whole(1, 3), p[1] + whole(1, 3), p[2] + whole(1, 3))),
        lambda: half_space([factor * c for c in normal], factor * whole(-2, 2)),
        lambda: cylinder(p, along(p), whole(1, 2)),
        lambda: cone(p, along(p), whole(0, 2), whole(1, 2)),
        lambda: sphere(whole(1, 2), p),
        lambda: wedge(whole(1, 2), whole(1, 2), *_quarters(r)),
        lambda: polyhedron([(x, y, z) for x in (-1, 1) for y in (-1, 1) for z in (-1, 1)], [whole(1, 3)] * 8),
        lambda: double_cone(1, (whole(-2, -1), whole(0, 2))),
        lambda: canonical(co.EllipticCylinder, (1, 1, 0), 0, -1, {"A": 1, "E": 1}, z_range=(whole(-2, 0), whole(1, 2))),
    ]
    return makers[r.integers(len(makers))]()


def _quarters(r: np.random.Generator) -> tuple[int, int]:
    """Angles that are multiples of 90 degrees."""
    first = 90 * int(r.integers(-4, 4))
    return first, first + 90 * int(r.integers(1, 4))
