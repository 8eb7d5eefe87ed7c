"""Shapes of every kind with random parameters: floats of any scale, or small whole numbers."""

import math
import zlib
from collections.abc import Callable, Sequence
from typing import Any

import numpy as np

import conicoid as co

from .items import Item

Random = np.random.Generator
Vector = tuple[float, ...]
LEAST, MOST = 1e-100, 1e100
"""Magnitudes of the documented domain."""


def generator(name: str, index: int) -> Random:
    """Return the same random numbers for a name and an index, everywhere."""
    return np.random.default_rng([20261127, zlib.crc32(name.encode()), index])


def floats(values: Any) -> Vector:
    return tuple(float(v) for v in values)


def pick(r: Random, options: Sequence[Any]) -> Any:
    return options[int(r.integers(len(options)))]


def direction(r: Random) -> np.ndarray:
    v = r.normal(size=3)
    return v / np.linalg.norm(v)


class FloatDraw:
    """Floats about a scale, in one case of ten far smaller, which makes thin and flat shapes too."""

    def __init__(self, random: Random, size: float) -> None:
        self.random, self.size = random, size

    def near(self, size: float) -> float:
        r = self.random
        return float(size * (10 ** r.uniform(-5, -1) if r.random() < 0.1 else 2 ** r.uniform(-3, 0)))

    def length(self) -> float:
        return self.near(self.size / 2)

    def ratio(self) -> float:
        return self.near(2.0)

    def inverse(self) -> float:
        return self.near(8 / self.size)

    def curvature(self) -> float:
        return 1 / self.length() ** 2

    def point(self) -> np.ndarray:
        """Return the origin, a point up to thirty sizes away, or one of up to a million."""
        far = self.random.choice([0.0, 1.5, 6.0], p=[0.3, 0.5, 0.2])
        return direction(self.random) * self.size * 10 ** self.random.uniform(-1, far) if far else np.zeros(3)

    def beside(self, point: np.ndarray) -> np.ndarray:
        return point + direction(self.random) * self.length()

    def span(self, reach: float) -> tuple[float, float]:
        low, high = np.sort(self.random.uniform(-1, 1, 2)) * reach
        return float(low), float(high)

    def normal(self) -> Vector:
        r = self.random
        return floats(direction(r) * 10 ** r.uniform(-3, 3) if r.random() < 0.7 else np.eye(3)[r.integers(3)])

    def offset(self, normal: Vector) -> float:
        return float(self.random.normal() * self.size * np.linalg.norm(normal))

    def end(self, start: np.ndarray) -> np.ndarray:
        """Return an end, along a coordinate axis in one case of three."""
        r = self.random
        axis = np.eye(3)[r.integers(3)] * r.choice([-1, 1]) if r.random() < 1 / 3 else direction(r)
        return start + axis * self.near(self.size)

    def angles(self) -> tuple[float, float]:
        """Return angles in steps of 2^-20 degrees, so that their difference is a float."""
        r = self.random
        turn = float(r.choice([90, 180, 270, 360, r.uniform(5, 355), r.uniform(5, 355)]))
        first = round(pick(r, [0, -90, 45, r.uniform(-360, 360)]) * 2**20) / 2**20
        return first, min(first + round(turn * 2**20) / 2**20, first + 360)

    def quadric(self) -> dict[str, Any]:
        """Return a random symmetric form, mostly bounded or central, by matrix or by names."""
        r, s = self.random, self.size / 4
        form = r.normal(size=(3, 3))
        form = (form @ form.T + 0.2 * np.eye(3) if r.random() < 0.5 else form + form.T) / s**2
        linear, constant = floats(r.normal(size=3) / s), -float(r.uniform(0.2, 2))
        if r.random() < 0.5:
            half = np.array([linear]) / 2
            return {"matrix": np.block([[form, half.T], [half, np.array([[constant]])]]).tolist()}
        (xx, xy, xz), (_, yy, yz), (_, _, zz) = (form * (2 - np.eye(3))).tolist()
        x, y, z = linear
        return {"coefficients": dict(xx=xx, yy=yy, zz=zz, xy=xy, yz=yz, xz=xz, x=x, y=y, z=z, constant=constant)}

    def polyhedron(self, center: np.ndarray) -> dict[str, Any]:
        """Return tangent planes of a ball with those of a tetrahedron at least, so that it is bounded."""
        r = self.random
        around = np.array([[1, 1, 1], [1, -1, -1], [-1, 1, -1], [-1, -1, 1]]) / np.sqrt(3)
        normals = np.vstack([around, *(direction(r) for _ in range(r.integers(0, 9)))])
        normals *= 10 ** r.uniform(-1, 1, (len(normals), 1))
        offsets = normals @ center + np.linalg.norm(normals, axis=1) * self.size / 8
        return {"normals": [floats(n) for n in normals], "offsets": floats(offsets)}


class WholeDraw(FloatDraw):
    """Small whole numbers: tangencies, edges, corners and shared walls are exact and frequent."""

    AXES = ((0, 0, 1), (0, 2, 0), (-3, 0, 0), (1, 2, 2), (0, 3, 4), (2, -3, 6), (1, 1, 1), (1, -1, 0))
    """Directions, some of whose lengths are whole too."""

    def __init__(self, random: Random) -> None:
        super().__init__(random, 8.0)

    def length(self) -> float:
        return float(pick(self.random, (1, 2, 3, 5, 1.25)))

    def ratio(self) -> float:
        return float(pick(self.random, (0.5, 0.75, 1, 2)))

    def inverse(self) -> float:
        return float(pick(self.random, (0.5, 1, 1, 2)))

    def curvature(self) -> float:
        return float(pick(self.random, (0.25, 1, 1, 4)))

    def point(self) -> np.ndarray:
        return self.random.integers(-2, 3, 3).astype(float)

    def beside(self, point: np.ndarray) -> np.ndarray:
        return point + self.random.integers(-3, 4, 3)

    def span(self, reach: float) -> tuple[float, float]:
        low = float(self.random.integers(-3, 3))
        return low, low + float(self.random.integers(1, 4))

    def normal(self) -> Vector:
        normal = floats(self.point())
        return normal if any(normal) else (0.0, 0.0, 1.0)

    def offset(self, normal: Vector) -> float:
        return float(self.random.integers(-4, 5))

    def end(self, start: np.ndarray) -> np.ndarray:
        return start + np.array(pick(self.random, self.AXES))

    def angles(self) -> tuple[float, float]:
        first = float(pick(self.random, (0, 90, -90, 45, 30)))
        return first, first + float(pick(self.random, (45, 90, 180, 270, 300)))

    def quadric(self) -> dict[str, Any]:
        """Return a quadric of any class, with degenerate ones: pairs of planes, lines, points, nothing, all of space."""
        names = ("xx", "yy", "zz", "xy", "yz", "xz", "x", "y", "z", "constant")
        numbers = dict(zip(names, floats(self.random.choice([-2, -1, 0, 0, 0, 1, 2], 10)), strict=True))
        return {"coefficients": numbers if any([*numbers.values()][:-1]) else {**numbers, "xx": 1.0}}

    def polyhedron(self, center: np.ndarray) -> dict[str, Any]:
        """Return the cube with some of its corners and edges cut; planes often touch it in an edge or a corner alone."""
        r = self.random
        cuts = [n for n in (floats(r.integers(-1, 2, 3)) for _ in range(r.integers(0, 5))) if any(n)]
        normals = [floats(s * row) for row in np.eye(3) for s in (1, -1)]
        return {"normals": [*normals, *cuts], "offsets": [2.0] * 6 + [float(r.integers(2, 7)) for _ in cuts]}


Draw = FloatDraw


def item(
    kind: str, draw: Draw, parameters: dict[str, Any], center: Any = (0, 0, 0), size: float = 0.0, **more: Any
) -> Item:
    if isinstance(draw, WholeDraw):
        return Item(kind, parameters, **more)
    return Item(kind, parameters, center=floats(center), size=float(size) or draw.size * 4, **more)


def rounded_body(d: Draw, kind: str) -> Item:
    center, radii = d.point(), [d.length() for _ in range(3)]
    if kind == "Sphere":
        return item(kind, d, {"radius": radii[0], "center": floats(center)}, center, 2 * radii[0])
    z_range = None if d.random.random() < 0.4 else d.span(radii[2])
    return item(kind, d, {"radii": tuple(radii), "center": floats(center), "z_range": z_range}, center, 2 * max(radii))


def box(d: Draw, kind: str) -> Item:
    low = d.point()
    high = low + [d.length() for _ in range(3)]
    return item(kind, d, {"low": floats(low), "high": floats(high)}, (low + high) / 2, 2 * float(max(high - low)))


def on_axis(d: Draw, kind: str) -> Item:
    """Return cylinders, cones and patches."""
    r, start = d.random, d.point()
    end = d.end(start)
    parameters: dict[str, Any] = {"start": floats(start), "end": floats(end)}
    radii = [d.length(), d.length()]
    if kind == "Cone":
        if r.random() < 0.4:
            radii[r.integers(2)] = 0.0
        parameters |= {"start_radius": radii[0], "end_radius": radii[1]}
    else:
        parameters["radius"] = radii[0]
        reference = d.beside(start)
        if (kind == "CylinderPatch" or r.random() < 0.6) and np.cross(reference - start, end - start).any():
            first, last = d.angles()
            parameters |= {"start_angle": first, "end_angle": last, "reference": floats(reference)}
    return item(kind, d, parameters, (start + end) / 2, 2 * max(*radii, float(np.linalg.norm(end - start))))


def double_cone(d: Draw, kind: str) -> Item:
    bounded = d.random.random() < 0.6
    z_range = d.span(d.size / 2) if bounded else None
    return item(kind, d, {"slope": d.ratio(), "z_range": z_range}, bounded=bounded)


def ranged(d: Draw, kind: str) -> Item:
    """Return the canonical quadrics that a z_range makes finite (or not)."""
    names = "AEH" if kind in ("OneSheetHyperboloid", "TwoSheetHyperboloid", "EllipticCone") else "AE"
    bent = kind == "EllipticParaboloid"
    parameters: dict[str, Any] = {name: d.inverse() if bent else d.curvature() for name in names}
    half, bounded = d.random.random() < 0.15, d.random.random() < 0.6
    low, high = d.span(d.size)
    z_range = (low, math.inf) if half else (low, high) if bounded else None
    # half axes of the section at height h: √((1 + H h²) / A), or √(h / A) of the paraboloid
    h = max(abs(low), abs(high))
    top = h if bent else 1 + parameters.get("H", 0.0) * h * h
    size = 4 * max(h, *(math.sqrt(top / parameters[name]) for name in "AE"))
    return item(kind, d, {**parameters, "z_range": z_range}, size=size, bounded=bounded and not half)


def within_box(d: Draw, kind: str) -> Item:
    make = {"HyperbolicCylinder": d.curvature, "HyperbolicParaboloid": d.inverse, "ParabolicCylinder": d.length}[kind]
    names = "G" if kind == "ParabolicCylinder" else "AE"
    bounded = d.random.random() < 0.6
    ends = zip(*((-d.length(), d.length()) for _ in range(3)), strict=True)
    return item(
        kind, d, {**{name: make() for name in names}, "within": tuple(ends) if bounded else None}, bounded=bounded
    )


def flat(d: Draw, kind: str) -> Item:
    normal = d.normal()
    offset = d.offset(normal)
    more = {"one_sided": bool(d.random.random() < 0.5)} if kind == "Plane" else {}
    center = np.array(normal) * offset / np.dot(normal, normal)
    return item(kind, d, {"normal": normal, "offset": offset, **more}, center, d.size, bounded=False)


def polyhedron(d: Draw, kind: str) -> Item:
    center = d.point()
    return item(kind, d, d.polyhedron(center), center, d.size)


def disc(d: Draw, kind: str) -> Item:
    center, radius = d.point(), d.length()
    return item(kind, d, {"center": floats(center), "normal": d.normal(), "radius": radius}, center, 2 * radius)


def triangle(d: Draw, kind: str) -> Item:
    middle = d.point()
    corners = [d.beside(middle) for _ in range(3)]
    if not np.cross(corners[1] - corners[0], corners[2] - corners[0]).any():
        return triangle(d, kind)
    return item(kind, d, dict(zip("abc", map(floats, corners), strict=True)), middle, d.size)


def polygon(d: Draw, kind: str) -> Item:
    """Return points of a dyadic lattice in a tilted plane: exactly planar, often concave or self-crossing."""
    r = d.random
    unit, most = (1.0, 2) if isinstance(d, WholeDraw) else (2.0 ** round(np.log2(d.size / 64)), 8)
    u, v, corner = (r.integers(-min(3, most - 1), min(4, most), 3).astype(float) for _ in range(3))
    count = int(r.integers(3, 13 if most > 2 else 8))
    angles = np.sort(r.uniform(0, 2 * np.pi, count)) if r.random() < 0.7 else r.uniform(0, 2 * np.pi, count)
    reach = r.uniform(1, most + 1, count)
    steps = np.round(np.stack([np.cos(angles) * reach, np.sin(angles) * reach], axis=1))
    points = (corner + steps[:, :1] * u + steps[:, 1:] * v) * unit
    points = points[np.any(points != np.roll(points, 1, axis=0), axis=1)]
    if len(points) < 3 or not np.cross(points, np.roll(points, -1, axis=0)).sum(axis=0).any():
        return polygon(d, kind)
    extent = float(np.linalg.norm(points.max(axis=0) - points.min(axis=0)))
    return item(kind, d, {"vertices": [floats(p) for p in points]}, points.mean(axis=0), extent)


def spheres(d: Draw, kind: str) -> Item:
    """Return balls beside one another: some touch, some overlap, some are one in another."""
    center, count = d.point(), int(d.random.integers(1, 10))
    centers = [floats(d.beside(center)) for _ in range(count)]
    return item(kind, d, {"centers": centers, "radii": [d.length() / 2 for _ in range(count)]}, center, d.size)


def something_left(make: Callable[[Draw, str], Item]) -> Callable[[Draw, str], Item]:
    """Draw again where a range or a box leaves nothing of the solid, because the library refuses that."""

    def again(draw: Draw, kind: str) -> Item:
        while True:
            found = make(draw, kind)
            try:
                found.shape(co)
            except ValueError as error:
                if "a part of the solid" not in str(error):
                    raise
            else:
                return found

    return again


MAKERS: dict[str, Callable[[Draw, str], Item]] = {
    **dict.fromkeys(("Sphere", "Ellipsoid"), something_left(rounded_body)),
    "Box": box, "Cylinder": on_axis, "Cone": on_axis, "DoubleCone": double_cone,
    **dict.fromkeys(("EllipticParaboloid", "OneSheetHyperboloid", "TwoSheetHyperboloid", "EllipticCone", "EllipticCylinder"), something_left(ranged)),
    **dict.fromkeys(("HyperbolicParaboloid", "HyperbolicCylinder", "ParabolicCylinder"), something_left(within_box)),
    "Quadric": lambda d, kind: item(kind, d, d.quadric(), bounded=False),
    "HalfSpace": flat, "Polyhedron": polyhedron, "Spheres": spheres,
    "Plane": flat, "Disc": disc, "Triangle": triangle, "Polygon": polygon, "CylinderPatch": on_axis,
}  # fmt: skip


def random_shape(draw: Draw, kind: str) -> Item:
    return MAKERS[kind](draw, kind)
