"""Shapes and rays of small whole numbers: tangencies, edges, corners and shared walls exactly, in great number."""

from __future__ import annotations

from collections.abc import Callable
from typing import Any

import numpy as np

from ..oracle.cases import Case
from ..oracle.samples import KINDS, something_left

Random = np.random.Generator
INFINITE = float("inf")


def whole(r: Random, low: int, high: int) -> float:
    return float(r.integers(low, high + 1))


def point(r: Random, reach: int = 2) -> tuple[float, ...]:
    return tuple(whole(r, -reach, reach) for _ in range(3))


def span(r: Random, reach: int = 3) -> tuple[float, float]:
    low = whole(r, -reach, reach - 1)
    return low, low + whole(r, 1, 3)


def maybe(r: Random, make: Callable[[Random], Any]) -> Any:
    return make(r) if r.random() < 0.6 else None


def case(kind: str, bounded: bool = True, **parameters: Any) -> Case:
    return Case(kind, parameters, (0.0, 0.0, 0.0), 8.0, bounded)


def corners(r: Random) -> tuple[tuple[float, ...], tuple[float, ...]]:
    low = point(r)
    return low, tuple(x + whole(r, 1, 4) for x in low)


def on_axis(r: Random) -> tuple[tuple[float, ...], tuple[float, ...]]:
    """Lengths of the axis are often whole too: (1, 2, 2), (0, 3, 4), (2, 3, 6)."""
    start = point(r, 1)
    axes = [(0, 0, 1), (0, 2, 0), (-3, 0, 0), (1, 2, 2), (0, 3, 4), (2, -3, 6), (1, 1, 1), (1, -1, 0)]
    axis = axes[r.integers(len(axes))]
    return start, tuple(s + float(a) for s, a in zip(start, axis, strict=True))


def wedge(r: Random, start: Any, end: Any) -> dict[str, Any]:
    first = float(r.choice([0, 90, -90, 45, 30]))
    reference = point(r, 3)
    axis, towards = np.subtract(end, start), np.subtract(reference, start)
    if not np.cross(axis, towards).any():
        return {}
    return {"start_angle": first, "end_angle": first + float(r.choice([45, 90, 180, 270, 300])), "reference": reference}


def cylinder(r: Random, kind: str = "Cylinder") -> Case:
    start, end = on_axis(r)
    angles = wedge(r, start, end) if r.random() < 0.5 or kind == "CylinderPatch" else {}
    return case(kind, start=start, end=end, radius=float(r.choice([1, 2, 3, 5, 1.25])), **angles)


def cone(r: Random) -> Case:
    start, end = on_axis(r)
    radii = r.permutation([float(x) for x in r.choice([0, 1, 2, 3], 2, replace=False)])
    return case("Cone", start=start, end=end, start_radius=float(radii[0]), end_radius=float(radii[1]))


def canonical(kind: str, names: str) -> Callable[[Random], Case]:
    def make(r: Random) -> Case:
        numbers = {name: float(r.choice([0.25, 1, 1, 4])) for name in names}
        z_range = maybe(r, span) if r.random() < 0.8 else (whole(r, -2, 2), INFINITE)
        return case(kind, z_range is not None and z_range[1] < INFINITE, **numbers, z_range=z_range)

    return make


def within_box(kind: str, names: str) -> Callable[[Random], Case]:
    def make(r: Random) -> Case:
        within = maybe(r, corners)
        return case(
            kind, within is not None, **{name: float(r.choice([0.5, 1, 1, 2])) for name in names}, within=within
        )

    return make


def quadric(r: Random) -> Case:
    """Of all classes, degenerate ones among them: pairs of planes, lines, points, nothing, all of space."""
    names = ("xx", "yy", "zz", "xy", "yz", "xz", "x", "y", "z", "constant")
    numbers = {name: float(r.choice([-2, -1, 0, 0, 0, 1, 2])) for name in names}
    if not any(numbers[name] for name in names[:-1]):
        numbers["xx"] = 1.0
    return case("Quadric", False, coefficients=numbers)


def flat(kind: str) -> Callable[[Random], Case]:
    def make(r: Random) -> Case:
        normal = point(r)
        normal = normal if any(normal) else (0.0, 0.0, 1.0)
        extra = {"one_sided": bool(r.random() < 0.5)} if kind == "Plane" else {}
        return case(kind, False, normal=normal, offset=whole(r, -4, 4), **extra)

    return make


def polyhedron(r: Random) -> Case:
    """The cube with some of its corners and edges cut; planes often touch it in an edge or a corner alone."""
    normals = [tuple(float(s * (i == j)) for j in range(3)) for i in range(3) for s in (1, -1)]
    cuts = [n for n in (point(r, 1) for _ in range(r.integers(0, 5))) if any(n)]
    offsets = [2.0] * 6 + [whole(r, 2, 6) for _ in cuts]
    return case("Polyhedron", normals=[*normals, *cuts], offsets=offsets)


def disc(r: Random) -> Case:
    normal = point(r)
    return case(
        "Disc", center=point(r), normal=normal if any(normal) else (1.0, 0.0, 0.0), radius=float(r.choice([1, 2, 3, 5]))
    )


def triangle(r: Random) -> Case:
    a, b, c = (point(r, 3) for _ in range(3))
    if not np.cross(np.subtract(b, a), np.subtract(c, a)).any():
        return triangle(r)
    return case("Triangle", a=a, b=b, c=c)


def polygon(r: Random) -> Case:
    """Of a whole lattice, concave and crossing itself too."""
    u, v, corner = (np.array(point(r, 1)) for _ in range(3))
    count = int(r.integers(3, 8))
    steps = r.integers(-2, 3, (count, 2)).astype(float)
    points = corner + steps[:, :1] * u + steps[:, 1:] * v
    if (points == np.roll(points, 1, axis=0)).all(axis=1).any() or not np.cross(
        points, np.roll(points, -1, axis=0)
    ).sum(axis=0).any():
        return polygon(r)
    return case("Polygon", vertices=[tuple(float(c) for c in p) for p in points])


def spheres(r: Random) -> Case:
    """Some touch, some overlap, some are one in another."""
    count = int(r.integers(1, 7))
    return case(
        "Spheres",
        centers=[point(r, 3) for _ in range(count)],
        radii=[float(r.choice([1, 2, 1.25])) for _ in range(count)],
    )


PLAIN: dict[str, Callable[[Random], Case]] = {
    "Sphere": lambda r: case("Sphere", radius=float(r.choice([1, 3, 5, 1.25])), center=point(r)),
    "Ellipsoid": lambda r: case("Ellipsoid", radii=tuple(whole(r, 1, 4) for _ in range(3)), center=point(r), z_range=maybe(r, span)),
    "Box": lambda r: case("Box", **dict(zip(("low", "high"), corners(r), strict=True))),
    "Cylinder": cylinder,
    "Cone": cone,
    "DoubleCone": lambda r: case("DoubleCone", False, slope=float(r.choice([0.5, 0.75, 1, 2])), z_range=maybe(r, span)),
    "EllipticParaboloid": canonical("EllipticParaboloid", "AE"),
    "HyperbolicParaboloid": within_box("HyperbolicParaboloid", "AE"),
    "OneSheetHyperboloid": canonical("OneSheetHyperboloid", "AEH"),
    "TwoSheetHyperboloid": canonical("TwoSheetHyperboloid", "AEH"),
    "EllipticCone": canonical("EllipticCone", "AEH"),
    "EllipticCylinder": canonical("EllipticCylinder", "AE"),
    "HyperbolicCylinder": within_box("HyperbolicCylinder", "AE"),
    "ParabolicCylinder": within_box("ParabolicCylinder", "G"),
    "Quadric": quadric,
    "HalfSpace": flat("HalfSpace"),
    "Polyhedron": polyhedron,
    "Spheres": spheres,
    "Plane": flat("Plane"),
    "Disc": disc,
    "Triangle": triangle,
    "Polygon": polygon,
    "CylinderPatch": lambda r: cylinder(r, "CylinderPatch"),
}  # fmt: skip
for _name in ("Ellipsoid", "EllipticParaboloid", "TwoSheetHyperboloid", "HyperbolicParaboloid", "HyperbolicCylinder",
              "ParabolicCylinder"):  # fmt: skip
    PLAIN[_name] = something_left(PLAIN[_name])
PARTS = ("Sphere", "Ellipsoid", "Box", "Box", "Cylinder", "Cone", "Polyhedron", "OneSheetHyperboloid", "HalfSpace")


def motion(r: Random) -> tuple[tuple[Any, ...], ...]:
    """Turns that carry the lattice into itself or nearly, mirrors, whole shifts and stretches."""
    choices: list[tuple[Any, ...]] = [
        ("translate", point(r)), ("rotate", (0.0, 0.0, 1.0), 90.0), ("rotate", (1.0, 0.0, 0.0), -90.0),
        ("rotate", (1.0, 1.0, 1.0), 120.0), ("rotate", (1.0, 1.0, 0.0), 180.0), ("rotate", (0.0, 1.0, 0.0), 45.0),
        ("scale", (1.0, -1.0, 1.0)), ("scale", (2.0, 1.0, 0.5)), ("scale", -1.0),
        ("transform", [(1.0, 1.0, 0.0, 0.0), (0.0, 1.0, 0.0, 1.0), (0.0, 0.0, 1.0, 0.0), (0.0, 0.0, 0.0, 1.0)]),
    ]  # fmt: skip
    return tuple(choices[k] for k in r.integers(len(choices), size=r.integers(0, 3)))


def moved(old: Case, steps: tuple[tuple[Any, ...], ...]) -> Case:
    return Case(old.kind, old.parameters, old.center, old.size, old.bounded, old.steps + steps, old.operands)


def part(r: Random) -> Case:
    return moved(PLAIN[str(r.choice(PARTS))](r), motion(r) if r.random() < 0.4 else ())


def combined(r: Random, kind: str) -> Case:
    count = 1 if kind == "Complement" else int(r.integers(2, 4))
    return Case(kind, {}, (0.0, 0.0, 0.0), 8.0, False, (), tuple(part(r) for _ in range(count)))


def nice_case(kind: str, r: Random) -> Case:
    if kind in PLAIN:
        return moved(PLAIN[kind](r), motion(r) if kind != "Spheres" else ())
    if kind == "ClippedSheet":
        sheet = PLAIN[str(r.choice(["Plane", "Disc", "Triangle", "Polygon", "CylinderPatch"]))](r)
        keep = {"keep": str(r.choice(["inside", "outside"]))}
        return Case(kind, keep, (0.0, 0.0, 0.0), 8.0, False, (), (moved(sheet, motion(r)), part(r)))
    if kind == "NestedBooleans":
        kinds = [str(k) for k in r.choice(["Union", "Intersection", "Difference"], 3)]
        return Case(kinds[0], {}, (0.0, 0.0, 0.0), 8.0, False, (), tuple(combined(r, k) for k in kinds[1:]))
    return combined(r, kind)


assert set(PLAIN) <= set(KINDS)


def lattice_rays(r: Random, count: int) -> tuple[np.ndarray, np.ndarray]:
    """Whole or half origins, whole directions, many along axes; in a third of them one number is a little off."""
    origins = r.integers(-6, 7, (count, 3)) / r.choice([1.0, 1.0, 2.0], (count, 1))
    d = r.integers(-3, 4, (count, 3)).astype(float)
    axes = np.eye(3)[r.integers(3, size=count)] * r.choice([-1.0, 1.0], (count, 1))
    d = np.where((r.random((count, 1)) < 0.3) | ~d.any(axis=1, keepdims=True), axes, d)
    for values, share in ((origins, 0.2), (d, 0.13)):
        rows = np.flatnonzero(r.random(count) < share)
        columns = r.integers(3, size=len(rows))
        off = r.choice([-1.0, 1.0], len(rows)) * 2.0 ** -r.choice([20, 40, 49, 50, 51, 52, 60, 200], len(rows))
        values[rows, columns] += off * np.maximum(np.abs(values[rows, columns]), 2.0**-8)
        values[rows, columns] = np.where(values[rows, columns] == 0, off, values[rows, columns])
    return origins, d
