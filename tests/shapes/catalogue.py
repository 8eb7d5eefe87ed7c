"""Solids with the inequality of their interface, in NumPy.

`inside(x, y, z)` uses nothing of the package: it is the formula in the frame of the world. `reach` is half the side of
a cube around the origin that holds the places of samples.
"""

from collections.abc import Callable
from dataclasses import dataclass
from typing import Any

import numpy as np

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
