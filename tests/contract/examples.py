"""Instances of every registered shape.

A new shape whose fields have the usual names needs no entry here: `FIELDS` derives its instances from the dataclass.
Any other shape needs a line in `LISTED`.
"""

import dataclasses
import math
from collections.abc import Callable, Iterator
from typing import Any

import conicoid as co
from conicoid.geometry.registry import REGISTRY

INF = float("inf")
BOX = ((-2, -1.5, -1), (1, 2, 1.5))

FIELDS: dict[str, Any] = {
    "radius": 1.25, "center": (0.5, -0.25, 1.0), "radii": (1.0, 2.0, 1.5), "low": (-1.0, -2.0, 0.0), "high": (1.0, 0.5, 1.5),
    "start": (0.0, -1.0, 0.5), "end": (1.0, 1.0, 2.0), "start_radius": 1.0, "end_radius": 0.5, "slope": 0.75,
    "A": 1.5, "E": 0.5, "H": 0.75, "G": 0.6, "normal": (1.0, 2.0, -1.5), "offset": 0.5,
    "start_angle": 30.0, "end_angle": 250.0, "reference": (2.0, 0.0, 0.0),
    "a": (0.0, 0.0, 0.0), "b": (2.0, 0.5, 0.0), "c": (0.5, 2.0, 1.0),
    "normals": [(1, 0, 0), (0, 1, 0.5), (0, 0, 1), (-1, -1, -1)], "offsets": [1, 1, 1, 1.5],
    "centers": [(0, 0, 0), (2, 0, 0), (0, 3, 1)], "length": 2.0, "height": 2.0,
}  # fmt: skip
"""A value for each usual name of a field without a default."""


def _booleans() -> tuple[Any, Any, Any]:
    ball, block = co.Sphere(1.5), co.Box((-1, -1, -1), (2, 1, 1))
    return ball, block, co.Cylinder((0, 0, -3), (0, 0.5, 3), 0.5)


def _union() -> Iterator[Any]:
    ball, block, rod = _booleans()
    yield ball | block
    yield ball | block | rod
    yield co.Sphere(1, (-3, 0, 0)) | co.Sphere(1, (3, 0, 0))


def _intersection() -> Iterator[Any]:
    ball, block, rod = _booleans()
    yield ball & block
    yield ball & block & co.HalfSpace((1, 1, 1), 0.5)
    yield rod & ball.translate((0, 0, 1))


def _difference() -> Iterator[Any]:
    ball, block, rod = _booleans()
    yield ball - block
    yield block - ball - rod
    yield ball - rod


def _complement() -> Iterator[Any]:
    ball, block, rod = _booleans()
    yield ~ball
    yield ~(block - rod)


def _clipped() -> Iterator[Any]:
    yield co.Plane((0.2, 0.1, 1), 0.1) & co.Sphere(1.5)
    yield co.Disc((0, 0, 0.25), (0.5, 0, 1), 2) - co.Cylinder((0, 0, -2), (0, 0, 2), 0.7)
    yield co.CylinderPatch((0, 0, -1), (0, 0, 1), 1, 0, 360, (1, 0, 0)) & co.HalfSpace((0, 1, 1), 0.2)


def _painted() -> Iterator[Any]:
    ball, block, rod = _booleans()
    yield ball.painted(co.matte((0.9, 0.2, 0.1)))
    yield (block - rod.painted(co.mirror())).painted(co.matte((0.1, 0.2, 0.9)))


LISTED: dict[str, Callable[[], Any]] = {
    "Mesh": lambda: [
        co.Mesh([(0, 0, 0), (2, 0, 0), (0, 2, 0), (0, 0, 2)], [(0, 2, 1), (0, 1, 3), (1, 2, 3), (2, 0, 3)]),
        co.Mesh([(0, 0, 0), (2, 0, 0), (2, 2, 0), (0, 2, 0), (1, 1, 0.5), (1, 1, 2)],  # a pyramid with a pit below
                [(0, 1, 5), (1, 2, 5), (2, 3, 5), (3, 0, 5), (1, 0, 4), (2, 1, 4), (3, 2, 4), (0, 3, 4)]),
    ],
    "Extrusion": lambda: [
        co.Extrusion([(0, 0), (1, 0), (1, 0.5), (0.5, 0.5), (0.5, 1), (0, 1)], (-1, 1)), co.Extrusion([(0, 0), (0.25, 1), (1, 0)], (0, 1), 0.5),
        co.Extrusion([(-1, -1), (1, -1), (1, 1), (-1, 1)], (0, 2), 0),
    ],
    "Revolution": lambda: [
        co.Revolution([(1, -1), (2, -1), (2, 1), (1.5, 1), (1, 0.5)]), co.Revolution([(0, 0), (2, 0), (1, 1), (0, 2)]),
        co.Revolution([(0.5, 0), (2, 0), (1.5, 1), (0.75, 1)], 20, 110), co.Revolution([(0, 0), (2, 0), (2, 1), (0, 1)], -30, 240),
    ],
    "Tube": lambda: [
        co.Tube((0, 0, -1), (0, 0, 1), 0.5, 1), co.Tube((0, 0, 0), (1, 1, 1), 0.75, 1, 20, 110, (2, 0, 0)), co.Tube((0, 0, 0), (0, 2, 0), 0, 1.5),
        co.Tube((0, 0, 0), (0, 2, 0), 0.5, 1.5, -30, 240, (2, 1, 0.5)), co.Tube((0, 0, 0), (0, 0, 1), 0.25, 1, 45, 225, (1, 0, 0)),
    ],
    "Polycone": lambda: [
        co.Polycone([(-1, 0.5, 1), (1, 0.75, 2)]), co.Polycone([(-1, 0, 1), (0, 0, 1), (0, 0.5, 2), (0.5, 1, 1), (1, 0, 2)]),
        co.Polycone([(-1, 0, 1.5), (0, 0, 0.5), (0, 0, 1), (1, 0, 0)], 20, 110), co.Polycone([(0, 1, 2), (1, 0, 2), (1, 1, 2), (2, 1, 1)], -30, 240),
    ],
    "SphereSection": lambda: [
        co.SphereSection(), co.SphereSection(2, 1, center=(1, -2, 0.5)), co.SphereSection(1.5, 0, (0, 90)), co.SphereSection(2, 1, (30, 120), 20, 220),
        co.SphereSection(2, 0.5, (40, 140), -100, -10), co.SphereSection(1.5, 0.5, (100, 180), 90, 270, (1, 0, 0)), co.SphereSection(2, 0, (90, 135), 10, 350),
    ],
    "Trapezoid": lambda: [
        co.Trapezoid((2, 1), (1, 3)), co.Trapezoid((2, 2), (0, 0), (0, 2), (0.5, -1)), co.Trapezoid((2, 0), (0, 1.5)), co.Trapezoid((0, 1), (2, 2), (-1, 0.5)),
    ],
    "Wedge": lambda: [co.Wedge(3, 2, 1), co.Wedge(3, 2, 1, 1, 1), co.Wedge(2, 2, 1.5, 4, -2), co.Wedge(2, 1, 1, 0)],
    "RegularPrism": lambda: [co.RegularPrism(3, 1), co.RegularPrism(6, 1, (0, 2), 30, "sides"), co.RegularPrism(7, 1.5, (-1, 0.5), -10.5)],
    "Pyramid": lambda: [co.Pyramid(4, 1.5), co.Pyramid(5, 1, (-1, 1), 0.5, 20, "sides"), co.Pyramid(3, 1, (0, 2), 1.5, 100)],
    "Parallelepiped": lambda: [
        co.Parallelepiped((0, 0, 0), (1, 0, 0), (0.5, 1, 0), (0.25, 0.5, 2)), co.Parallelepiped((1, -1, 0), (0, 2, 1), (1.5, 0, 0.5), (0, -1, 2)),
    ],
    "Sphere": lambda: [co.Sphere(), co.Sphere(0.75, (1, -2, 0.5))],
    "Ellipsoid": lambda: [
        co.Ellipsoid(), co.Ellipsoid((1, 2, 1.5), (0.5, 0, -1), z_range=(-0.5, 1)), co.Ellipsoid((2, 1, 1), z_range=(0, INF)),
        co.Ellipsoid.from_coefficients(0.5, 1, 2),
    ],
    "Box": lambda: [co.Box(), co.Box((-1, 0, 0.5), (0.5, 2, 1))],
    "Cylinder": lambda: [
        co.Cylinder((0, 0, -1), (0, 0, 1), 1), co.Cylinder((0.5, 0, 0), (2, 1, -1), 0.75), co.Cylinder((0, 0, 0), (1, 1, 1), 1, 20, 110, (2, 0, 0)),
        co.Cylinder((0, 0, 0), (0, 2, 0), 1.5, -30, 240, (2, 1, 0.5)), co.Cylinder((0, 0, 0), (0, 0, 1), 1, 45, 225, (1, 0, 0)),
    ],
    "Cone": lambda: [
        co.Cone((0, 0, 0), (0, 0, 2), 1, 0), co.Cone((0, 1, 0), (1, 0, 2), 0.5, 1.25), co.Cone((0, 0, 0), (0, 1, 0), 0.75, 0.75),
        co.Cone((1, 1, 1), (-1, 0, 1), 0, 1), co.Cone((0, 0, 0), (1, 1, 1), 0.5, 1.5, 20, 110, (2, 0, 0)), co.Cone((0, 0, 0), (0, 1, 0), 1.25, 0, -30, 240, (2, 1, 0.5)),
        co.Cone((0, 0, 0), (0, 0, 1), 1, 0.5, 45, 225, (1, 0, 0)),
    ],
    "DoubleCone": lambda: [co.DoubleCone(), co.DoubleCone(0.5, (-1, 2)), co.DoubleCone(1.5, (0.5, 1.5)), co.DoubleCone(1, (0, INF))],
    "EllipticParaboloid": lambda: [co.EllipticParaboloid(1, 2), co.EllipticParaboloid(1, 0.5, (0.5, 2)), co.EllipticParaboloid(2, 1, (-1, 1.5))],
    "HyperbolicParaboloid": lambda: [co.HyperbolicParaboloid(1, 2), co.HyperbolicParaboloid(1, 0.5, co.Box(*BOX))],
    "OneSheetHyperboloid": lambda: [co.OneSheetHyperboloid(1, 2, 0.5), co.OneSheetHyperboloid(1, 1, 1, (-1, 1.5))],
    "TwoSheetHyperboloid": lambda: [
        co.TwoSheetHyperboloid(1, 2, 4), co.TwoSheetHyperboloid(1, 1, 1, (-2, 3)), co.TwoSheetHyperboloid(1, 2, 1, (0, 2)),
    ],
    "EllipticCone": lambda: [co.EllipticCone(1, 2, 1), co.EllipticCone(1, 2, 0.5, (-1, 2))],
    "EllipticCylinder": lambda: [co.EllipticCylinder(1, 2), co.EllipticCylinder(0.5, 1, (-1, 1)), co.EllipticCylinder(1, 1, (-INF, 0.5))],
    "HyperbolicCylinder": lambda: [co.HyperbolicCylinder(1, 2), co.HyperbolicCylinder(2, 1, co.Box(*BOX))],
    "ParabolicCylinder": lambda: [co.ParabolicCylinder(0.5), co.ParabolicCylinder(0.25, co.Box(*BOX))],
    "Quadric": lambda: [
        co.Quadric(coefficients=dict(xx=1, yy=2, zz=3, xy=0.5, yz=-0.5, xz=0.25, x=1, y=-1, z=0.5, constant=-2)),
        co.Quadric(matrix=[[1, 0.5, 0, 0.2], [0.5, -1, 0.3, 0], [0, 0.3, 2, -0.4], [0.2, 0, -0.4, -1]]),
        co.Quadric(coefficients=dict(xy=1, z=-1)), co.Quadric(coefficients=dict(x=1, y=2, z=2, constant=-1)),
        co.Quadric(coefficients=dict(xx=1, xy=2, yy=1, z=-1)), co.Quadric(coefficients=dict(zz=1, constant=-1)),
    ],
    "HalfSpace": lambda: [co.HalfSpace((0, 0, 1), 0.5), co.HalfSpace((1, -2, 0.5), 1)],
    "Polyhedron": lambda: [
        co.Polyhedron([(1, 0, 0), (0, 1, 0), (0, 0, 1), (-1, -1, -1)], [1, 1, 1, 1]),
        co.Polyhedron([(x, y, z) for x in (-1, 1) for y in (-1, 1) for z in (-1, 1)], [2] * 8),
        co.Polyhedron([(1, 0, 0.5), (-1, 0, 0.5)], [1, 1]),
    ],
    "Spheres": lambda: [co.Spheres([(0, 0, 0), (2.5, 0, 0), (0, 3, 1)], [1, 0.5, 1.25])],
    "Cylinders": lambda: [co.Cylinders([(0, 0, -1), (3, 0, 0)], [(0, 0, 1), (4, 2, 1)], [1, 0.5])],
    "Capsules": lambda: [co.Capsules([(0, 0, -1), (3, 0, 0)], [(0, 0, 1), (4, 2, 1)], [1, 0.5])],
    "Cones": lambda: [co.Cones([(0, 0, -1), (3, 0, 0)], [(0, 0, 1), (4, 2, 1)], [1, 0.5], [0, 0.75])],
    "Ellipsoids": lambda: [co.Ellipsoids([(0, 0, 0), (3, 1, 0)], [(1, 2, 1.5), (0.5, 0.5, 1)])],
    "Boxes": lambda: [co.Boxes([(-1, 0, 0.5), (1, 0, 0)], [(0.5, 2, 1), (2, 1, 1.5)])],
    "Discs": lambda: [co.Discs([(0, 0, 0), (1, -1, 0.5)], [(0, 0, 1), (1, 2, 2)], [1, 1.5])],
    "Triangles": lambda: [co.Triangles([(0, 0, 0), (3, 0, 0)], [(2, 0, 0.5), (5, 0, 0.5)], [(0, 2, 1), (3, 2, 0)])],
    "Plane": lambda: [co.Plane((0, 0, 1), 0.5), co.Plane((1, -2, 0.5), 1, one_sided=True)],
    "Disc": lambda: [co.Disc((0, 0, 0), (0, 0, 1), 1), co.Disc((1, -1, 0.5), (1, 2, 2), 1.5)],
    "Triangle": lambda: [co.Triangle((0, 0, 0), (2, 0, 0.5), (0, 2, 1))],
    "Polygon": lambda: [
        co.Polygon([(0, 0, 1), (4, 0, 1), (4, 4, 1), (2, 1, 1), (0, 4, 1)]),
        co.Polygon([(0, 0, 0), (2, 0, 2), (2, 2, 4), (0, 2, 2), (1, 1, 2)]),
    ],
    "CylinderPatch": lambda: [
        co.CylinderPatch((0, 0, 0), (0, 0, 2), 1, 0, 90, (1, 0, 0)), co.CylinderPatch((0, 0, 0), (1, 1, 1), 1, 20, 310, (2, 0, 0)),
    ],
    "Conic": lambda: [co.Conic(2, 0, 2), co.Conic(-1.5, -1, 3), co.Conic(1.5, -3, 2.5), co.Conic(-1, 2, 1.1), co.Conic(1, 0, 2), co.Conic(2, -0.6, 3)],
    "ConicSheet": lambda: [
        co.ConicSheet(-2, -1, 3, 0.5), co.ConicSheet(1.5, -3, 2.5), co.ConicSheet(math.inf, 0, 2, 1), co.ConicSheet(-1, 2, 1.1), co.ConicSheet(2, -0.6, 3),
    ],
    "Lens": lambda: [
        co.Lens(2, -3, 1, 2), co.Lens(-2, 1.5, 0.4, 2, front_aperture=1.5), co.Lens(math.inf, -2, 0.75, 2), co.Lens(1, 1.5, 0.5, 1.8, -0.5, -2),
        co.Lens(1, -1, 2, 2), co.Lens(1, math.inf, 4, 1.5), co.Lens(-1.5, -1, 1, 2.5, -3, 0, 2, 1.5), co.Lens(math.inf, math.inf, 0.5, 2),
        co.Lens(1.5, 2, 1, 2.5, -3, -1, 1.5),
    ],
    "Mirror": lambda: [co.Mirror(-2, -1, 3, 0.5, 0.75), co.Mirror(-1.5, -3, 2, -1), co.Mirror(math.inf, 0, 2, 0.25), co.Mirror(1, 0, 1.5, 1, 0.5)],
    "Stop": lambda: [co.Stop(1, 3)],
    "Prism": lambda: [co.Prism(60, 2, 3), co.Prism(90, 1.5, 1)],
    "PentaPrism": lambda: [co.PentaPrism(1.5, 2)],
    "CornerCube": lambda: [co.CornerCube(2)],
    "Wall": lambda: [
        co.Wall(co.EllipticParaboloid(1, 0.5, (0, 2))), co.Wall(co.Box((-3, -3, 0.5), (3, 3, 1)).rotate("x", 20), 5), co.Wall(co.Sphere(1.5, (1, 0, 0))),
        co.Wall(co.Cylinder((0, 0, 0), (0, 2, 0), 1.5, -30, 240, (2, 1, 0.5)), 3), co.Wall(co.Lens(-2, 1.5, 0.4, 2, front_aperture=1.5), 3),
    ],
    "Union": _union, "Intersection": _intersection, "Difference": _difference, "Complement": _complement, "Painted": _painted, "ClippedSheet": _clipped,
}  # fmt: skip

MOTIONS: dict[str, Callable[[Any], Any]] = {
    "still": lambda shape: shape,
    "moved": lambda shape: shape.translate((3, -1, 2)).rotate((1, 2, -1), 50),
    "mirrored and sheared": lambda shape: shape.scale((-1, 2, 0.5)).transform(
        [[1, 0.4, 0, 1], [-0.3, 1, 0.2, 5], [0, 0.5, 0.8, -2], [0, 0, 0, 1]]
    ),
}


def derived(kind: type[co.Shape]) -> list[co.Shape]:
    """Make an instance from the names of the fields without a default."""
    required = [f.name for f in dataclasses.fields(kind) if f.default is f.default_factory is dataclasses.MISSING]
    unknown = [name for name in required if name not in FIELDS]
    if unknown:
        raise LookupError(
            f"{kind.__name__}: give it a line in LISTED of tests/contract/examples.py (no sample of {unknown})"
        )
    return [kind(**{name: FIELDS[name] for name in required})]


def examples_of(name: str) -> list[co.Shape]:
    return list(LISTED[name]()) if name in LISTED else derived(REGISTRY[name])


def sample_of_kinds(turn: int) -> set[str]:
    """Return every other example of each kind, odd or even ones by turns, and the only one of a kind that has one."""
    kinds = {name: len(examples_of(name)) for name in REGISTRY}
    return {f"{kind}-{k}" for kind, count in kinds.items() for k in range(count) if count == 1 or (k + turn) % 2 == 0}


def every_example() -> Iterator[tuple[str, co.Shape]]:
    """Return (readable id, shape) of all instances, unmoved."""
    for name in sorted(REGISTRY):
        for index, shape in enumerate(examples_of(name)):
            yield f"{name}-{index}", shape
