"""Random shapes over twelve decades of scale, of every kind, and random motions."""

from __future__ import annotations

import zlib
from collections.abc import Callable
from typing import Any

import numpy as np

import conicoid as co

from .cases import Case
from .draws import Random, curvature, direction, floats, near, place, scale, span
from .solids import COMBINED


def sphere(r: Random, s: float) -> Case:
    center = floats(place(r, s))
    return Case("Sphere", {"radius": s / 2, "center": center}, center, s)


def ellipsoid(r: Random, s: float) -> Case:
    center, radii = floats(place(r, s)), floats(near(r, s / 2) for _ in range(3))
    z_range = None if r.random() < 0.4 else span(r, radii[2])
    return Case("Ellipsoid", {"radii": radii, "center": center, "z_range": z_range}, center, s)


def box(r: Random, s: float) -> Case:
    low = place(r, s)
    high = low + [near(r, s) for _ in range(3)]
    return Case("Box", {"low": floats(low), "high": floats(high)}, floats((low + high) / 2), s * 2)


def on_axis(r: Random, s: float) -> tuple[np.ndarray, np.ndarray]:
    """Two ends: along a coordinate axis in one case of three."""
    start = place(r, s)
    axis = np.eye(3)[r.integers(3)] * r.choice([-1, 1]) if r.random() < 1 / 3 else direction(r)
    return start, start + axis * near(r, s)


def wedge(r: Random, start: np.ndarray, end: np.ndarray, s: float) -> dict[str, Any]:
    turn = float(r.choice([90, 180, 270, 360, r.uniform(5, 355), r.uniform(5, 355)]))
    first = float(r.choice([0, -90, 45, r.uniform(-360, 360)]))
    return {"start_angle": first, "end_angle": first + turn, "reference": floats(start + direction(r) * s)}


def cylinder(r: Random, s: float) -> Case:
    start, end = on_axis(r, s)
    angles = {} if r.random() < 0.4 else wedge(r, start, end, s)
    parameters = {"start": floats(start), "end": floats(end), "radius": near(r, s / 2), **angles}
    return Case("Cylinder", parameters, floats((start + end) / 2), s * 2)


def cone(r: Random, s: float) -> Case:
    start, end = on_axis(r, s)
    radii = [near(r, s / 2), near(r, s / 2)]
    if r.random() < 0.4:
        radii[r.integers(2)] = 0.0
    parameters = {"start": floats(start), "end": floats(end), "start_radius": radii[0], "end_radius": radii[1]}
    return Case("Cone", parameters, floats((start + end) / 2), s * 2)


def double_cone(r: Random, s: float) -> Case:
    bounded = r.random() < 0.6
    z_range = span(r, s / 2) if bounded else None
    return Case("DoubleCone", {"slope": near(r, 2.0), "z_range": z_range}, (0, 0, 0), s * 4, bounded)


def elliptic(kind: str, count: int) -> Callable[[Random, float], Case]:
    """The canonical quadrics that a z_range makes finite (or not)."""

    def make(r: Random, s: float) -> Case:
        names = ("A", "E", "H")[:count]
        parameters: dict[str, Any] = {name: curvature(r, s / 2) for name in names}
        if kind == "EllipticParaboloid":
            parameters = {name: near(r, 8 / s) for name in names}
        half_infinite = r.random() < 0.15
        bounded = not half_infinite and r.random() < 0.6
        low, high = span(r, s)
        z_range = (low, high) if bounded else (low, float("inf")) if half_infinite else None
        # half axes of the section at height h: √((1 + H h²) / A), or √(h / A) of the paraboloid
        h = max(abs(low), abs(high))
        top = h if kind == "EllipticParaboloid" else 1 + parameters.get("H", 0.0) * h * h
        wide = max((top / parameters[name]) ** 0.5 for name in "AE")
        return Case(
            kind, {**parameters, "z_range": z_range}, (0, 0, 0), 4 * max(wide, h) if bounded else s * 8, bounded
        )

    return make


def within_box(kind: str, names: tuple[str, ...]) -> Callable[[Random, float], Case]:
    def make(r: Random, s: float) -> Case:
        parameters: dict[str, Any] = {}
        for name in names:
            parameters[name] = curvature(r, s / 2) if kind == "HyperbolicCylinder" else near(r, 4 / s)
        if kind == "ParabolicCylinder":
            parameters["G"] = near(r, s)
        bounded = r.random() < 0.6
        low, high = floats(-s * r.uniform(0.1, 1, 3)), floats(s * r.uniform(0.1, 1, 3))
        return Case(kind, {**parameters, "within": (low, high) if bounded else None}, (0, 0, 0), s * 4, bounded)

    return make


def quadric(r: Random, s: float) -> Case:
    """A random symmetric form, mostly bounded or central, at scale s; by matrix or by names."""
    form = r.normal(size=(3, 3))
    form = form @ form.T + 0.2 * np.eye(3) if r.random() < 0.5 else form + form.T
    linear, constant = r.normal(size=3), -float(r.uniform(0.2, 2))
    form, linear = form / (s / 4) ** 2, linear / (s / 4)
    bounded = bool((np.linalg.eigvalsh(form) > 0).all())
    if r.random() < 0.5:
        matrix = np.zeros((4, 4))
        matrix[:3, :3], matrix[:3, 3], matrix[3, :3], matrix[3, 3] = form, linear / 2, linear / 2, constant
        parameters: dict[str, Any] = {"matrix": matrix.tolist()}
    else:
        xx, yy, zz = (float(form[i, i]) for i in range(3))
        xy, yz, xz = (2 * float(form[i, j]) for i, j in ((0, 1), (1, 2), (0, 2)))
        x, y, z = floats(linear)
        parameters = {"coefficients": dict(xx=xx, yy=yy, zz=zz, xy=xy, yz=yz, xz=xz, x=x, y=y, z=z, constant=constant)}
    return Case("Quadric", parameters, (0, 0, 0), s * 4, bounded)


def half_space(r: Random, s: float) -> Case:
    normal = direction(r) * 10 ** r.uniform(-3, 3) if r.random() < 0.7 else np.eye(3)[r.integers(3)]
    offset = float(r.normal() * s * np.linalg.norm(normal))
    return Case(
        "HalfSpace", {"normal": floats(normal), "offset": offset}, floats(normal * offset / (normal @ normal)), s, False
    )


def polyhedron(r: Random, s: float) -> Case:
    """Tangent planes of a ball: a tetrahedron at least, so that it is bounded."""
    center = place(r, s)
    around = np.array([[1, 1, 1], [1, -1, -1], [-1, 1, -1], [-1, -1, 1]]) / np.sqrt(3)
    normals = np.vstack([around, *(direction(r) for _ in range(r.integers(0, 9)))])
    normals *= 10 ** r.uniform(-1, 1, (len(normals), 1))
    offsets = normals @ center + np.linalg.norm(normals, axis=1) * s / 8
    parameters = {"normals": [floats(n) for n in normals], "offsets": floats(offsets)}
    return Case("Polyhedron", parameters, floats(center), s)


def plane_sheet(r: Random, s: float) -> Case:
    base = half_space(r, s)
    parameters = {**base.parameters, "one_sided": bool(r.random() < 0.5)}
    return Case("Plane", parameters, base.center, s, False)


def disc(r: Random, s: float) -> Case:
    center = floats(place(r, s))
    normal = floats(direction(r) if r.random() < 0.7 else np.eye(3)[r.integers(3)] * 2)
    return Case("Disc", {"center": center, "normal": normal, "radius": s / 2}, center, s)


def triangle(r: Random, s: float) -> Case:
    middle = place(r, s)
    corners = [floats(middle + direction(r) * near(r, s / 2)) for _ in range(3)]
    return Case("Triangle", dict(zip("abc", corners, strict=True)), floats(np.mean(corners, axis=0)), s)


def polygon(r: Random, s: float) -> Case:
    """Up to a dozen points of a dyadic lattice in a tilted plane: exactly planar, often concave or crossing itself."""
    unit = 2.0 ** round(np.log2(s / 64))
    u, v, corner = (r.integers(-3, 4, 3).astype(float) for _ in range(3))
    while not np.cross(u, v).any():
        v = r.integers(-3, 4, 3).astype(float)
    count = int(r.integers(3, 13))
    angles = np.sort(r.uniform(0, 2 * np.pi, count)) if r.random() < 0.7 else r.uniform(0, 2 * np.pi, count)
    reach = r.uniform(1, 8, count)
    steps = np.round(np.stack([np.cos(angles) * reach, np.sin(angles) * reach], axis=1))
    points = (corner + steps[:, :1] * u + steps[:, 1:] * v) * unit
    points = points[np.any(points != np.roll(points, 1, axis=0), axis=1)]
    newell = np.cross(points, np.roll(points, -1, axis=0)).sum(axis=0) if len(points) > 2 else np.zeros(3)
    if not newell.any():
        return polygon(r, s)
    extent = float(np.linalg.norm(points.max(axis=0) - points.min(axis=0)))
    return Case("Polygon", {"vertices": [floats(p) for p in points]}, floats(points.mean(axis=0)), extent)


def cylinder_patch(r: Random, s: float) -> Case:
    start, end = on_axis(r, s)
    parameters = {"start": floats(start), "end": floats(end), "radius": near(r, s / 2), **wedge(r, start, end, s)}
    return Case("CylinderPatch", parameters, floats((start + end) / 2), s * 2)


def boolean(kind: str) -> Callable[[Random, float], Case]:
    """Of two or three bounded solids about the origin, each moved by its own motion."""

    def make(r: Random, s: float) -> Case:
        count = 1 if kind == "Complement" else int(r.choice([2, 2, 2, 3]))
        parts = []
        for _ in range(count):
            part = PRIMITIVES[str(r.choice(list(BUILDING_BLOCKS)))](r, s)
            while not part.bounded:
                part = PRIMITIVES[part.kind](r, s)
            away = r.uniform(0.2, 0.5) if parts and kind == "Difference" else r.uniform(0, 0.25)
            home = ("translate", floats(-np.array(part.center) + direction(r) * s * away))
            turn = [("rotate", floats(direction(r)), float(r.uniform(0, 360)))] if r.random() < 0.5 else []
            parts.append(Case(part.kind, part.parameters, part.center, part.size, True, (home, *turn)))
        return Case(kind, {}, (0, 0, 0), max(s, *(part.size for part in parts)) * 3, True, (), tuple(parts))

    return make


def nested(r: Random, s: float) -> Case:
    """A tree of Booleans of Booleans."""
    kinds = [str(k) for k in r.choice(["Union", "Intersection", "Difference"], 3)]
    parts = [boolean(kind)(r, s) for kind in kinds[1:]]
    if r.random() < 0.4:
        parts[1] = Case("Complement", {}, (0, 0, 0), parts[1].size, True, (), (parts[1],))
    return Case(kinds[0], {}, (0, 0, 0), max(part.size for part in parts), True, (), tuple(parts))


def clipped_sheet(r: Random, s: float) -> Case:
    """A sheet about the origin, inside or outside of a bounded solid there."""
    base = PRIMITIVES[str(r.choice(["Plane", "Disc", "Triangle", "Polygon", "CylinderPatch"]))](r, s)
    home = ("translate", floats(-np.array(base.center)))
    base = Case(base.kind, base.parameters, base.center, base.size, base.bounded, (home,))
    solid = boolean("Intersection")(r, s).operands[0]
    return Case(
        "ClippedSheet",
        {"keep": str(r.choice(["inside", "outside"]))},
        (0, 0, 0),
        s * 2,
        base.bounded,
        (),
        (base, solid),
    )


def spheres(r: Random, s: float) -> Case:
    """Some of the balls of a 3 × 3 × 3 lattice, apart from one another: as a formula they are a union."""
    corner, step = place(r, s), s / 4
    sites = r.permutation(27)[: r.integers(1, 12)]
    centers = [floats(corner + step * np.array([i % 3 - 1, i // 3 % 3 - 1, i // 9 - 1])) for i in sites]
    radii = floats(near(r, 0.45 * step) for _ in sites)
    return Case("Spheres", {"centers": centers, "radii": radii}, floats(corner), s)


def something_left(make: Callable[..., Case]) -> Callable[..., Case]:
    """Cases that are drawn again where a range or a box leaves nothing of the solid, which the library refuses."""

    def again(*arguments: Any) -> Case:
        while True:
            case = make(*arguments)
            try:
                case.shape(co)
            except ValueError as error:
                if "a part of the solid" not in str(error):
                    raise
            else:
                return case

    return again


PRIMITIVES: dict[str, Callable[[Random, float], Case]] = {
    "Sphere": sphere, "Ellipsoid": ellipsoid, "Box": box, "Cylinder": cylinder, "Cone": cone,
    "DoubleCone": double_cone, "EllipticParaboloid": elliptic("EllipticParaboloid", 2),
    "HyperbolicParaboloid": within_box("HyperbolicParaboloid", ("A", "E")),
    "OneSheetHyperboloid": elliptic("OneSheetHyperboloid", 3), "TwoSheetHyperboloid": elliptic("TwoSheetHyperboloid", 3),
    "EllipticCone": elliptic("EllipticCone", 3), "EllipticCylinder": elliptic("EllipticCylinder", 2),
    "HyperbolicCylinder": within_box("HyperbolicCylinder", ("A", "E")),
    "ParabolicCylinder": within_box("ParabolicCylinder", ("G",)),
    "Quadric": quadric, "HalfSpace": half_space, "Polyhedron": polyhedron,
    "Spheres": spheres, "Plane": plane_sheet, "Disc": disc, "Triangle": triangle, "Polygon": polygon, "CylinderPatch": cylinder_patch,
}  # fmt: skip
for _name in ("Ellipsoid", "EllipticParaboloid", "TwoSheetHyperboloid", "HyperbolicParaboloid", "HyperbolicCylinder",
              "ParabolicCylinder"):  # fmt: skip
    PRIMITIVES[_name] = something_left(PRIMITIVES[_name])
BUILDING_BLOCKS = (
    "Sphere",
    "Ellipsoid",
    "Box",
    "Cylinder",
    "Cone",
    "Polyhedron",
    "OneSheetHyperboloid",
    "EllipticParaboloid",
)
KINDS = {
    **PRIMITIVES,
    "ClippedSheet": clipped_sheet,
    "NestedBooleans": nested,
    **{kind: boolean(kind) for kind in COMBINED},
}


def motion(r: Random, size: float) -> tuple[tuple[Any, ...], ...]:
    """No motion in two cases of five; else one to three steps."""
    steps: list[tuple[Any, ...]] = []
    if r.random() < 0.4:
        return ()
    for _ in range(r.integers(1, 4)):
        verb = r.choice(["translate", "rotate", "turn", "scale", "stretch", "transform"])
        if verb == "translate":
            steps.append(("translate", floats(direction(r) * size * 10 ** r.uniform(-1, 1.5))))
        elif verb == "rotate":
            steps.append(("rotate", floats(direction(r)), float(r.uniform(-360, 360))))
        elif verb == "turn":
            steps.append(("rotate", floats(np.eye(3)[r.integers(3)]), float(90 * r.integers(1, 4))))
        elif verb == "scale":
            steps.append(("scale", float(r.choice([-1, 1]) * 2 ** r.uniform(-2, 2))))
        elif verb == "stretch":
            steps.append(("scale", floats(r.choice([-1, 1], 3) * 2 ** r.uniform(-1, 1, 3))))
        else:
            matrix = np.eye(4)
            matrix[:3, :3] += r.uniform(-0.4, 0.4, (3, 3))
            matrix[:3, 3] = direction(r) * size
            steps.append(("transform", [floats(row) for row in matrix]))
    return tuple(steps)


def random_case(kind: str, random: Random) -> Case:
    """A random shape and motion; shapes far from the origin stay, as a motion would round their place once more."""
    case = KINDS[kind](random, scale(random))
    far = float(np.linalg.norm(case.center)) > 40 * case.size
    return Case(
        case.kind, case.parameters, case.center, case.size, case.bounded, () if far else motion(random, case.size), case.operands
    )  # fmt: skip


def generator(kind: str, index: int) -> Random:
    """The same random numbers for a kind and an index, wherever they are asked for."""
    return np.random.default_rng([zlib.crc32(kind.encode()), index])
