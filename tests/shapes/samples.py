"""Solids with the inequality of their interface, in NumPy.

`inside(x, y, z)` uses nothing of the package: it is the formula in the frame of the world. `reach` is half the side of
a cube around the origin that holds the places of samples.
"""

from collections.abc import Callable
from dataclasses import dataclass
from typing import Any

import numpy as np

from conicoid.geometry.cell import UV, All, Cell, Face, Not, Tree
from conicoid.geometry.general_quadric import Quadric
from conicoid.geometry.polyhedron import Polyhedron
from conicoid.geometry.primitives import Box, Cone, Cylinder, HalfSpace, Sphere
from conicoid.geometry.quadrics import (
    DoubleCone,
    Ellipsoid,
    EllipticCone,
    EllipticCylinder,
    EllipticParaboloid,
    HyperbolicCylinder,
    HyperbolicParaboloid,
    OneSheetHyperboloid,
    ParabolicCylinder,
    TwoSheetHyperboloid,
)
from conicoid.geometry.shape import PrimitiveSolid
from conicoid.geometry.surface import PlaneSurface, Surface
from conicoid.geometry.transform import IDENTITY_MOTION, Motion

Inside = Callable[[Any, Any, Any], Any]


@dataclass(frozen=True)
class Sample:
    name: str
    shape: PrimitiveSolid
    inside: Inside
    reach: float
    bounded: bool = True


def cylindrical(start: Any, end: Any, reference: Any = None) -> Callable[[Any, Any, Any], Any]:
    """Return (height along the axis, distance from it, angle from the reference in degrees in [0, 360))."""
    start, end = np.array(start, float), np.array(end, float)
    axis = (end - start) / np.linalg.norm(end - start)
    towards = np.array(reference if reference is not None else start + np.array((1, 0, 0)), float) - start
    first = towards - towards @ axis * axis
    second = np.cross(axis, first)

    def coordinates(x: Any, y: Any, z: Any) -> Any:
        p = np.stack([x, y, z], axis=-1) - start
        height = p @ axis
        radius = np.linalg.norm(p - height[..., None] * axis, axis=-1)
        return height, radius, np.degrees(np.arctan2(p @ second, p @ first)) % 360

    return coordinates


def cylinder(start: Any, end: Any, radius: float, first: float = 0, last: float = 360, reference: Any = None) -> Inside:
    coordinates, length = cylindrical(start, end, reference), np.linalg.norm(np.subtract(end, start))

    def inside(x: Any, y: Any, z: Any) -> Any:
        height, distance, angle = coordinates(x, y, z)
        return (height >= 0) & (height <= length) & (distance <= radius) & ((angle - first) % 360 <= last - first)

    return inside


def cone(start: Any, end: Any, r0: float, r1: float) -> Inside:
    coordinates, length = cylindrical(start, end), np.linalg.norm(np.subtract(end, start))

    def inside(x: Any, y: Any, z: Any) -> Any:
        height, distance, _ = coordinates(x, y, z)
        return (height >= 0) & (height <= length) & (distance <= r0 + (r1 - r0) * height / length)

    return inside


def between(low: float, high: float) -> Callable[[Any], Any]:
    return lambda z: (low <= z) & (z <= high)


A, B, C = (0.3, -0.2, 0.1), (1.1, 0.9, 1.6), (2.0, -1.0, 0.5)
MATRIX = ((2.0, 0.5, 0.1, 0.3), (0.5, 1.0, -0.2, 0.0), (0.1, -0.2, 0.7, -0.4), (0.3, 0.0, -0.4, -2.0))
NORMALS = ((1, 1, 1), (-1, 0.2, 0), (0, -1, 0.1), (0.3, 0.1, -1), (1, -1, 0.5), (0, 0, 3))
OFFSETS = (2.0, 1.0, 0.7, 0.5, 1.2, 3.3)


def quadratic(x: Any, y: Any, z: Any) -> Any:
    p = np.stack([x, y, z, np.ones_like(x)], axis=-1)
    return np.einsum("...i,ij,...j->...", p, np.array(MATRIX), p)


def polyhedron(x: Any, y: Any, z: Any) -> Any:
    return ((np.stack([x, y, z], axis=-1) @ np.array(NORMALS, float).T) <= np.array(OFFSETS)).all(axis=-1)


SHEARED = Box((-1, -0.5, -1), (0.5, 1, 1.5)).transform(
    [[1, 0.3, 0, 0.1], [0, 1, -0.2, 0], [0.2, 0, 1, 0], [0, 0, 0, 1]]
)
_BACK = np.linalg.inv([[1, 0.3, 0], [0, 1, -0.2], [0.2, 0, 1]])


def sheared(x: Any, y: Any, z: Any) -> Any:
    p = (np.stack([x, y, z], axis=-1) - (0.1, 0, 0)) @ _BACK.T
    return ((p >= (-1, -0.5, -1)) & (p <= (0.5, 1, 1.5))).all(axis=-1)


def cube(x: Any, y: Any, z: Any) -> Any:
    return np.maximum(np.maximum(abs(x), abs(y)), abs(z)) <= 1


SAMPLES = [
    Sample("sphere", Sphere(1.5, (1, 0, -1)), lambda x, y, z: (x - 1) ** 2 + y**2 + (z + 1) ** 2 <= 2.25, 3),
    Sample("ellipsoid", Ellipsoid((1, 2, 0.5)), lambda x, y, z: x**2 + (y / 2) ** 2 + (2 * z) ** 2 <= 1, 2.2),
    Sample(
        "barrel",
        Ellipsoid((1, 1.5, 2), (0.5, 0, 1), (-1.2, 0.3)),
        lambda x, y, z: ((x - 0.5) ** 2 + (y / 1.5) ** 2 + ((z - 1) / 2) ** 2 <= 1) & between(-0.2, 1.3)(z),
        2.5,
    ),
    Sample("bowl", Ellipsoid(z_range=(-9, 1)), lambda x, y, z: (x**2 + y**2 / 4 + z**2 / 9 <= 1) & (z <= 1), 3),
    Sample("half", Ellipsoid(z_range=(-np.inf, -1)), lambda x, y, z: (x**2 + y**2 / 4 + z**2 / 9 <= 1) & (z <= -1), 3),
    Sample("AEH", Ellipsoid.from_coefficients(3, 0.7, 1), lambda x, y, z: 3 * x**2 + 0.7 * y**2 + z**2 <= 1, 1.3),
    Sample(
        "box", Box((-1, 0, 0.5), (1, 2, 1)), lambda x, y, z: (abs(x) <= 1) & between(0, 2)(y) & between(0.5, 1)(z), 2.5
    ),
    Sample("cylinder", Cylinder(A, B, 0.7), cylinder(A, B, 0.7), 2.5),
    Sample("wedge", Cylinder(A, B, 0.7, 30, 100, C), cylinder(A, B, 0.7, 30, 100, C), 2.5),
    Sample("half turn", Cylinder(A, B, 0.7, -20, 160, C), cylinder(A, B, 0.7, -20, 160, C), 2.5),
    Sample("open pie", Cylinder(A, B, 0.7, 300, 590, C), cylinder(A, B, 0.7, 300, 590, C), 2.5),
    Sample("frustum", Cone(A, B, 1, 0.25), cone(A, B, 1, 0.25), 2.5),
    Sample("widening frustum", Cone(A, B, 0.25, 1), cone(A, B, 0.25, 1), 2.5),
    Sample("cone", Cone(A, B, 1, 0), cone(A, B, 1, 0), 2.5),
    Sample("funnel", Cone(A, B, 0, 1), cone(A, B, 0, 1), 2.5),
    Sample("even cone", Cone(A, B, 0.5, 0.5), cylinder(A, B, 0.5), 2.5),
    Sample("double cone", DoubleCone(0.5), lambda x, y, z: x**2 + y**2 <= z**2 / 4, 3, bounded=False),
    Sample("bow tie", DoubleCone(2, (-1, 0.5)), lambda x, y, z: (x**2 + y**2 <= 4 * z**2) & between(-1, 0.5)(z), 2.5),
    Sample("paraboloid", EllipticParaboloid(1, 3), lambda x, y, z: x**2 + 3 * y**2 - z <= 0, 3, bounded=False),
    Sample(
        "dish", EllipticParaboloid(1, 3, (0.5, 2)), lambda x, y, z: (x**2 + 3 * y**2 <= z) & between(0.5, 2)(z), 2.2
    ),
    Sample("cup", EllipticParaboloid(1, 3, (-np.inf, 2)), lambda x, y, z: (x**2 + 3 * y**2 <= z) & (z <= 2), 2.2),
    Sample("saddle", HyperbolicParaboloid(1, 2), lambda x, y, z: x**2 - 2 * y**2 - z <= 0, 2, bounded=False),
    Sample(
        "cut saddle", HyperbolicParaboloid(1, 2, Box()), lambda x, y, z: (x**2 - 2 * y**2 - z <= 0) & cube(x, y, z), 1.2
    ),
    Sample(
        "sheared saddle",
        HyperbolicParaboloid(1, 2, SHEARED),
        lambda x, y, z: (x**2 - 2 * y**2 - z <= 0) & sheared(x, y, z),
        2.2,
    ),
    Sample(
        "one sheet", OneSheetHyperboloid(1, 2, 3), lambda x, y, z: x**2 + 2 * y**2 - 3 * z**2 <= 1, 3, bounded=False
    ),
    Sample(
        "cooling tower",
        OneSheetHyperboloid(1, 2, 3, (-0.2, 1)),
        lambda x, y, z: (x**2 + 2 * y**2 - 3 * z**2 <= 1) & between(-0.2, 1)(z),
        2.5,
    ),
    Sample(
        "two sheets", TwoSheetHyperboloid(1, 2, 3), lambda x, y, z: x**2 + 2 * y**2 - 3 * z**2 <= -1, 3, bounded=False
    ),
    Sample(
        "two bowls",
        TwoSheetHyperboloid(1, 2, 3, (-1, 2)),
        lambda x, y, z: (x**2 + 2 * y**2 - 3 * z**2 <= -1) & between(-1, 2)(z),
        3.5,
    ),
    Sample(
        "upper bowl",
        TwoSheetHyperboloid(1, 2, 3, (0, 2)),
        lambda x, y, z: (x**2 + 2 * y**2 - 3 * z**2 <= -1) & between(0, 2)(z),
        3.5,
    ),
    Sample("elliptic cone", EllipticCone(1, 2, 3), lambda x, y, z: x**2 + 2 * y**2 - 3 * z**2 <= 0, 3, bounded=False),
    Sample(
        "nappe",
        EllipticCone(1, 2, 3, (-1, 0)),
        lambda x, y, z: (x**2 + 2 * y**2 - 3 * z**2 <= 0) & between(-1, 0)(z),
        2,
    ),
    Sample("elliptic cylinder", EllipticCylinder(1, 4), lambda x, y, z: x**2 + 4 * y**2 <= 1, 2, bounded=False),
    Sample("can", EllipticCylinder(1, 4, (-1, 2)), lambda x, y, z: (x**2 + 4 * y**2 <= 1) & between(-1, 2)(z), 2.2),
    Sample("hyperbolic cylinder", HyperbolicCylinder(1, 4), lambda x, y, z: x**2 - 4 * y**2 <= 1, 2, bounded=False),
    Sample(
        "waist",
        HyperbolicCylinder(4, 1, Box()),
        lambda x, y, z: (4 * x**2 - y**2 <= 1) & cube(x, y, z),
        1.2,
    ),
    Sample(
        "sheared waist",
        HyperbolicCylinder(4, 1, SHEARED),
        lambda x, y, z: (4 * x**2 - y**2 <= 1) & sheared(x, y, z),
        2.2,
    ),
    Sample("trough", ParabolicCylinder(0.5), lambda x, y, z: x**2 - y <= 0, 2, bounded=False),
    Sample("cut trough", ParabolicCylinder(0.25, Box()), lambda x, y, z: (x**2 - y / 2 <= 0) & cube(x, y, z), 1.2),
    Sample(
        "sheared trough",
        ParabolicCylinder(0.25, SHEARED),
        lambda x, y, z: (x**2 - y / 2 <= 0) & sheared(x, y, z),
        2.2,
    ),
    Sample("quadric matrix", Quadric(matrix=MATRIX), lambda x, y, z: quadratic(x, y, z) <= 0, 4),
    Sample(
        "quadric coefficients",
        Quadric(coefficients=dict(xx=1, yy=1, zz=1, xy=1, x=-2, y=1, z=0.5, constant=-1)),
        lambda x, y, z: x * x + y * y + z * z + x * y - 2 * x + y + z / 2 - 1 <= 0,
        5,
    ),
    Sample(
        "quadric half-space",
        Quadric(coefficients=dict(x=1, y=-2, z=0.5, constant=-1)),
        lambda x, y, z: x - 2 * y + z / 2 - 1 <= 0,
        2,
        bounded=False,
    ),
    Sample("half-space", HalfSpace((1, -2, 3), 0.5), lambda x, y, z: x - 2 * y + 3 * z <= 0.5, 2, bounded=False),
    Sample("polyhedron", Polyhedron(NORMALS, OFFSETS), polyhedron, 4),
    Sample(
        "prism",
        Polyhedron(((1, 0, 0), (-1, 1, 0), (0, -1, 0)), (1, 0.5, 0.25)),
        lambda x, y, z: (x <= 1) & (y - x <= 0.5) & (-y <= 0.25),
        2,
        bounded=False,
    ),
]


# --- Trees of cells and uv maps at points, in plain NumPy, without the package's own kernels


def _principal(surface: Any, points: Any) -> tuple[Any, ...]:
    """Return points on the principal axes, the axes as rows, the squares and the linear terms."""
    rows = np.array([[float(c) for c in row] for row in surface.rows])
    y = (points - np.array([float(c) for c in surface.anchor])) @ rows.T
    squares, linear = (np.array([float(c) for c in row]) for row in (surface.squares, surface.linear))
    return y, rows, squares, linear


def value(surface: Surface, points: Any) -> Any:
    """Return the surface's left side at points (..., 3)."""
    if isinstance(surface, PlaneSurface):
        return points @ np.array([float(c) for c in surface.normal]) - float(surface.offset)
    y, _, squares, linear = _principal(surface, points)
    return (y * y) @ squares + 2 * y @ linear - float(surface.constant)


def gradient(surface: Surface, points: Any) -> Any:
    """Return ∇ of the left side at points (..., 3)."""
    if isinstance(surface, PlaneSurface):
        return np.broadcast_to(np.array([float(c) for c in surface.normal]), np.shape(points))
    y, rows, squares, linear = _principal(surface, points)
    return 2 * (y * squares + linear) @ rows


def contains(tree: Tree, points: Any, motion: Motion = IDENTITY_MOTION) -> Any:
    """Return which points (..., 3) of the world are inside the tree moved by a motion."""
    if isinstance(tree, Cell):
        sides = [face.inside * value(face.surface.moved(motion), points) <= 0 for face in tree.faces]
        return np.all(sides, axis=0)
    if isinstance(tree, Not):
        return ~contains(tree.part, points, motion)
    parts = [contains(part, points, motion) for part in tree.parts]
    return np.all(parts, axis=0) if isinstance(tree, All) else np.any(parts, axis=0)


def faces(tree: Tree) -> dict[int, Face]:
    """Return the faces of a tree by number."""
    if isinstance(tree, Cell):
        return {face.number: face for face in tree.faces}
    found: dict[int, Face] = {}
    for part in (tree.part,) if isinstance(tree, Not) else tree.parts:
        found.update(faces(part))
    return found


def uv(mapping: UV, point: Any) -> tuple[float, float]:
    """Return (u, v) at a point (3,) of the frame of the map."""
    a, b, c = np.array(mapping.matrix) @ np.append(np.array(point, float), 1.0)
    return (np.arctan2(b, a) / (2 * np.pi) % 1.0, c) if mapping.angular else (a, b)


# --- Motions for tests: a few plain ones and random affine ones, mirrors and shears among them


SHEAR = [[1, 0.7, 0, 0.5], [0, 1, -0.4, -1], [0.2, 0, 1, 2], [0, 0, 0, 1]]

MOTIONS = {
    "still": IDENTITY_MOTION,
    "shifted": IDENTITY_MOTION.translate((3, -1, 0.5)),
    "turned": IDENTITY_MOTION.rotate((1, 2, -1), 47).translate((1, 0, 0)),
    "quarter": IDENTITY_MOTION.rotate((0, 1, 0), 90),
    "mirrored": IDENTITY_MOTION.scale((1, -1, 1)).rotate((1, 0, 0), 20),
    "stretched": IDENTITY_MOTION.scale((3, 0.2, 1)).rotate((0, 0, 1), 33),
    "sheared": IDENTITY_MOTION.transform(SHEAR),
}


def random_motion(rng: np.random.Generator) -> Motion:
    """Return a random invertible matrix, half of them mirrors, with a shift."""
    matrix = np.eye(4)
    matrix[:3, :3] = rng.normal(size=(3, 3)) + np.diag(rng.choice([-1.0, 1.0], 3))
    matrix[:3, 3] = rng.normal(size=3) * 3
    return IDENTITY_MOTION.transform(matrix)


def climb(
    inside: Callable[[Any], Any],
    direction: Any,
    start: np.ndarray,
    rng: np.random.Generator,
    rounds: int,
    count: int = 60,
) -> np.ndarray:
    """Return the furthest point along a direction, by differential evolution: points move by differences of others."""
    people = start[np.argsort(-(start @ direction))][:count]
    for _ in range(rounds):
        others = people[rng.integers(len(people), size=(3, len(people)))]
        tries = others[0] + rng.uniform(0.3, 1.1, (len(people), 1)) * (others[1] - others[2])
        better = inside(tries) & (tries @ direction > people @ direction)
        people = np.where(better[:, None], tries, people)
    return people[np.argmax(people @ direction)]


def carried(motion: Motion, points: np.ndarray) -> np.ndarray:
    matrix = motion.matrix
    return points @ matrix[:3, :3].T + matrix[:3, 3]
