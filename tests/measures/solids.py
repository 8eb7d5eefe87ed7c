"""Solids whose volume, and often area, centroid and inertia, follow from a formula.

Most are Boolean, so that rays measure them. Moved ones are askew on purpose.
"""

import math
from dataclasses import dataclass
from typing import Any

import numpy as np

import conicoid as co

PI = math.pi


@dataclass(frozen=True)
class Known:
    """A solid with its measures. `inertia` is the diagonal of the tensor about the centroid, if that is diagonal."""

    name: str
    shape: Any
    volume: float
    area: float | None = None
    centroid: tuple[float, float, float] | None = None
    inertia: tuple[float, float, float] | None = None


def rod(axis: int, half: float, radius: float) -> co.Cylinder:
    end = np.eye(3)[axis] * half
    return co.Cylinder(tuple(-end), tuple(end), radius)


def askew(shape: Any) -> Any:
    return shape.rotate((1, 2, 3), 37).translate((3, 4, 5))


HUGE = co.Box((-50, -50, -50), (50, 50, 50))


SHEAR = [[1, 0.4, 0, 1], [-0.3, 1, 0.2, 0], [0, 0.5, 0.8, -2], [0, 0, 0, 1]]
FRUSTUM, CAP = math.hypot(0.6, 2), 1.5 * 0.4
"""The slant height of radii that differ by 0.6 over a height of 2; radius times height of a cap."""
RING = math.sqrt(1 - 1.2**2 / 4)
"""Radius of the hole of a napkin ring 1.2 high in the unit ball."""
DEPTH = math.sqrt(1 - 0.3**2)
"""The depth of a bore of radius 0.3 at its rim, in the unit ball."""
ANGLE = math.radians(70)
HALF, CONE = 2 / 3 * PI * 1.1**3, PI * 0.49 * 1.5 / 3
"""Volumes of half a ball of radius 1.1, and of a cone of radius 0.7 and height 1.5."""
KNOWN = [
    Known("two crossed cylinders (Steinmetz)", rod(0, 2, 0.75) & rod(1, 2, 0.75), 16 / 3 * 0.75**3, 16 * 0.75**2, (0, 0, 0)),
    Known("three crossed cylinders (Steinmetz)", rod(0, 2, 0.75) & rod(1, 2, 0.75) & rod(2, 2, 0.75),
          8 * (2 - math.sqrt(2)) * 0.75**3, 24 * (2 - math.sqrt(2)) * 0.75**2, (0, 0, 0)),
    # r = 1.25, centers d = 1 apart: π (4 r + d) (2 r - d)² / 12
    Known("lens of two spheres", askew(co.Sphere(1.25, (-0.5, 0, 0)) & co.Sphere(1.25, (0.5, 0, 0))), PI * 6 * 1.5**2 / 12,
          4 * PI * 1.25 * 0.75, (3, 4, 5)),
    # r = 1.5, h = 0.4: π h² (3 r - h) / 3, and its centroid 3 (2 r - h)² / (4 (3 r - h)) from the center
    Known("spherical cap", co.Sphere(1.5) & co.HalfSpace((0, 0, -1), 0.4 - 1.5), PI * 0.16 * 4.1 / 3,
          2 * PI * CAP + PI * (2 * CAP - 0.16), (0, 0, 3 * 2.6**2 / (4 * 4.1))),
    Known("napkin ring", co.Sphere(1) - rod(2, 2, RING), PI * 1.2**3 / 6, 2 * PI * 1.2 + 2 * PI * RING * 1.2, (0, 0, 0)),
    Known("frustum", askew(co.Cone((0, 0, 0), (0, 0, 2), 1, 0.4) & HUGE), PI * 2 / 3 * (1 + 0.4 + 0.16), PI * (1.4 * FRUSTUM + 1 + 0.16)),
    Known("sphere with a blind bore", co.Sphere(1) - co.Cylinder((0, 0, 0), (0, 0, 2), 0.3),
          4 / 3 * PI - PI * 0.09 * DEPTH - PI * (1 - DEPTH) ** 2 * (2 + DEPTH) / 3, 4 * PI - 2 * PI * (1 - DEPTH) + 2 * PI * 0.3 * DEPTH + PI * 0.09),
    Known("capped paraboloid", co.EllipticParaboloid(1, 2) & co.Box((-2, -2, -1), (2, 2, 1.5)), PI * 1.5**2 / (2 * math.sqrt(2)), None, (0, 0, 1)),
    Known("hyperboloid of one sheet between planes", co.OneSheetHyperboloid(1, 1, 1) & co.Box((-2, -2, -0.5), (2, 2, 1)), PI * (1.5 + (1 + 0.125) / 3)),
    Known("barrel", askew(co.Ellipsoid((1, 1, 2)) & co.Box((-3, -3, -1), (3, 3, 1))), PI * (2 - 2 / 12), None, (3, 4, 5)),
    Known("wedge of a cylinder", co.Cylinder((0, 0, 0), (0, 0, 2), 1, 0, 70, (1, 0, 0)) & HUGE, ANGLE, 3 * ANGLE + 4,
          (2 / 3 * math.sin(ANGLE) / ANGLE, 2 / 3 * (1 - math.cos(ANGLE)) / ANGLE, 1)),
    Known("half a ball", co.Sphere(1.1) & co.HalfSpace((0, 0, -1), 0), HALF, 3 * PI * 1.21, (0, 0, 3 / 8 * 1.1),
          (83 / 320 * HALF * 1.21, 83 / 320 * HALF * 1.21, 2 / 5 * HALF * 1.21)),
    Known("box with a hole", askew(co.Box((-1, -1, -1), (1, 1, 1)) - rod(2, 1, 0.5)), 8 - PI / 2, 24 - PI / 2 + 2 * PI, (3, 4, 5)),
    Known("thin plate with a hole, tilted", askew(co.Box((-1, -1, -5e-4), (1, 1, 5e-4)) - rod(2, 1, 0.5)), (4 - PI / 4) * 1e-3,
          2 * (4 - PI / 4) + 8e-3 + PI * 1e-3, (3, 4, 5)),
    Known("thin shell", co.Sphere(1, (5, 0, 0)) - co.Sphere(0.999, (5, 0, 0)), 4 / 3 * PI * (3e-3 - 3e-6 + 1e-9), 4 * PI * (1 + 0.999**2), (5, 0, 0)),
    Known("capsule", askew(rod(0, 1, 0.5) | co.Sphere(0.5, (1, 0, 0)) | co.Sphere(0.5, (-1, 0, 0))), PI / 2 + PI / 6, 2 * PI + PI, (3, 4, 5)),
    Known("cone", co.Cone((0, 0, 0), (0, 0, 1.5), 0.7, 0) & HUGE, CONE, PI * 0.7 * (0.7 + math.hypot(0.7, 1.5)), (0, 0, 1.5 / 4),
          (CONE * (3 / 20 * 0.49 + 3 / 80 * 2.25), CONE * (3 / 20 * 0.49 + 3 / 80 * 2.25), CONE * 3 / 10 * 0.49)),
    Known("Viviani's solid", co.Sphere(2) & co.Cylinder((1, 0, -3), (1, 0, 3), 1), (2 / 3 * PI - 8 / 9) * 8, 2 * PI * 4),
    Known("tetrahedron", (co.Polyhedron([(1, 1, 1), (1, -1, -1), (-1, 1, -1), (-1, -1, 1)], [1, 1, 1, 1]) & HUGE).rotate((2, -1, 1), 20),
          8 * 8 / 24, math.sqrt(3) * 8, (0, 0, 0)),
    Known("two crossed cylinders, sheared", (rod(0, 2, 1) & rod(1, 2, 1)).transform(SHEAR),
          16 / 3 * float(np.linalg.det(np.array(SHEAR)[:3, :3])), None, (1, 0, -2)),
    Known("eight balls", co.Spheres([(x, y, z) for x in (-1, 1) for y in (-1, 1) for z in (-1, 1)], 0.5), 8 * PI / 6, 8 * PI, (0, 0, 0)),
    Known("two thin rods askew", co.Cylinder((-1, -1, -1), (1, 1, 1), 2e-3) | co.Cylinder((-1, 1, -1), (1, -1, 2), 2e-3).translate((0.1, 0, 0)),
          PI * 4e-6 * (math.sqrt(12) + math.sqrt(17)), 2 * PI * 2e-3 * (math.sqrt(12) + math.sqrt(17)) + 4 * PI * 4e-6),
    Known("bow tie", (co.DoubleCone(1) & co.Box((-2, -2, -1), (2, 2, 1))).rotate((2, -1, 1), 50), 2 * PI / 3, 2 * PI * (1 + math.sqrt(2)), (0, 0, 0)),
    Known("cube of eight", co.Union(tuple(co.Box((x, y, z), (x + 1, y + 1, z + 1)) for x in (0, 1) for y in (0, 1) for z in (0, 1))),
          8, 24, (1, 1, 1), (8 * 4 / 6,) * 3),
]  # fmt: skip
OCTAHEDRON = co.Polyhedron([(x, y, z) for x in (-1, 1) for y in (-1, 1) for z in (-1, 1)], [1] * 8)
L_OUTLINE = ((0, 0), (2, 0), (2, 1), (1, 1), (1, 2), (0, 2))
BARE = [
    Known("ball", co.Sphere(2, (1, 0, 0)).scale(3).rotate((0, 0, 1), 90), 4 / 3 * PI * 216, 4 * PI * 36, (0, 3, 0), (4 / 3 * PI * 216 * 2 / 5 * 36,) * 3),
    Known("box", co.Box((0, 0, 0), (1, 2, 3)), 6, 22, (0.5, 1, 1.5), (6 / 12 * 13, 6 / 12 * 10, 6 / 12 * 5)),
    Known("tilted drum", co.Cylinder((0, 0, 0), (0, 0, 2), 0.5).rotate((1, 0, 0), 90), PI / 2, 2.5 * PI, (0, -1, 0),
          (PI / 2 * (3 / 4 + 4) / 12, PI / 16, PI / 2 * (3 / 4 + 4) / 12)),
    # ∫ x² over |x| + |y| + |z| <= 1 is ∫ x² 2 (1 - |x|)² dx = 2 / 15
    Known("octahedron", OCTAHEDRON, 4 / 3, 4 * math.sqrt(3), (0, 0, 0), (4 / 15,) * 3),
    Known("octahedron of planes that repeat, touch or are far",
          co.Polyhedron((*OCTAHEDRON.normals, (2, 2, 2), (1, 0, 0), (1, 1, 0), (0, 0, 1)), (*OCTAHEDRON.offsets, 2, 1, 1, 1e9)), 4 / 3, 4 * math.sqrt(3)),
    # The area of the outline times the height times (1 + s + s²) / 3
    *(Known(f"extrusion to {top}", co.Extrusion(L_OUTLINE, (1, 4), top), 3 * (1 + top + top * top)) for top in (0.0, 0.5, 2.0)),
    Known("extrusion", co.Extrusion(L_OUTLINE, (1, 4)), 9, 2 * 3 + 8 * 3, (2.5 / 3, 2.5 / 3, 2.5)),
]  # fmt: skip
"""Primitives, which have closed forms."""
