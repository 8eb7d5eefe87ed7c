"""Solids whose volume, and often area, centroid and inertia, follow from a formula.

Most are Boolean, so that they are measured by rays; moved ones are askew on purpose.
"""

from __future__ import annotations

import math
from collections.abc import Callable
from dataclasses import dataclass
from typing import Any

import numpy as np

import conicoid as co

PI = math.pi


@dataclass(frozen=True)
class Known:
    """`inertia`: the diagonal of the tensor about the centroid, where it is diagonal."""

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


def turned(degrees: float) -> Callable[[Any], Any]:
    return lambda shape: shape.rotate((2, -1, 1), degrees)


HUGE = co.Box((-50, -50, -50), (50, 50, 50))


def _cases() -> list[Known]:
    found: list[Known] = []

    def add(name: str, shape: Any, volume: float, **rest: Any) -> None:
        found.append(Known(name, shape, volume, **rest))

    r = 0.75
    add(
        "two crossed cylinders (Steinmetz)",
        rod(0, 2, r) & rod(1, 2, r),
        16 / 3 * r**3,
        area=16 * r**2,
        centroid=(0, 0, 0),
    )
    add("three crossed cylinders (Steinmetz)", rod(0, 2, r) & rod(1, 2, r) & rod(2, 2, r), 8 * (2 - math.sqrt(2)) * r**3,
        area=24 * (2 - math.sqrt(2)) * r**2, centroid=(0, 0, 0))  # fmt: skip

    r, d = 1.25, 1.0
    add("lens of two spheres", askew(co.Sphere(r, (-d / 2, 0, 0)) & co.Sphere(r, (d / 2, 0, 0))), PI * (4 * r + d) * (2 * r - d) ** 2 / 12,
        area=4 * PI * r * (r - d / 2), centroid=(3, 4, 5))  # fmt: skip
    r, h = 1.5, 0.4
    add("spherical cap", co.Sphere(r) & co.HalfSpace((0, 0, -1), h - r), PI * h**2 * (3 * r - h) / 3,
        area=2 * PI * r * h + PI * (2 * r * h - h**2), centroid=(0, 0, 3 * (2 * r - h) ** 2 / (4 * (3 * r - h))))  # fmt: skip
    h, r = 1.2, 1.0
    inner = math.sqrt(r**2 - h**2 / 4)
    add(
        "napkin ring",
        co.Sphere(r) - rod(2, 2, inner),
        PI * h**3 / 6,
        area=2 * PI * r * h + 2 * PI * inner * h,
        centroid=(0, 0, 0),
    )
    h, r0, r1 = 2.0, 1.0, 0.4
    add("frustum", askew(co.Cone((0, 0, 0), (0, 0, h), r0, r1) & HUGE), PI * h / 3 * (r0**2 + r0 * r1 + r1**2),
        area=PI * ((r0 + r1) * math.hypot(r0 - r1, h) + r0**2 + r1**2))  # fmt: skip
    r, a = 1.0, 0.3
    depth = math.sqrt(r**2 - a**2)
    plug = PI * a**2 * depth + PI * (r - depth) ** 2 * (2 * r + depth) / 3
    add("sphere with a blind bore", co.Sphere(r) - co.Cylinder((0, 0, 0), (0, 0, 2), a), 4 / 3 * PI * r**3 - plug,
        area=4 * PI * r**2 - 2 * PI * r * (r - depth) + 2 * PI * a * depth + PI * a**2)  # fmt: skip
    h = 1.5
    add(
        "capped paraboloid",
        co.EllipticParaboloid(1, 2) & co.Box((-2, -2, -1), (2, 2, h)),
        PI * h**2 / (2 * math.sqrt(2)),
        centroid=(0, 0, h * 2 / 3),
    )
    add("hyperboloid of one sheet between planes", co.OneSheetHyperboloid(1, 1, 1) & co.Box((-2, -2, -0.5), (2, 2, 1)),
        PI * (1.5 + (1 + 0.125) / 3))  # fmt: skip
    add(
        "barrel",
        askew(co.Ellipsoid((1, 1, 2)) & co.Box((-3, -3, -1), (3, 3, 1))),
        PI * (2 - 2 / 12),
        centroid=(3, 4, 5),
    )
    r, h, turn = 1.0, 2.0, math.radians(70)
    add("wedge of a cylinder", co.Cylinder((0, 0, 0), (0, 0, h), r, 0, 70, (1, 0, 0)) & HUGE, r**2 * turn / 2 * h,
        area=r * turn * h + r**2 * turn + 2 * r * h, centroid=(2 * r / 3 * math.sin(turn) / turn, 2 * r / 3 * (1 - math.cos(turn)) / turn, h / 2))  # fmt: skip
    r = 1.1
    mass = 2 / 3 * PI * r**3
    add("half a ball", co.Sphere(r) & co.HalfSpace((0, 0, -1), 0), mass, area=3 * PI * r**2, centroid=(0, 0, 3 / 8 * r),
        inertia=(83 / 320 * mass * r**2, 83 / 320 * mass * r**2, 2 / 5 * mass * r**2))  # fmt: skip
    a = 0.5
    add(
        "box with a hole",
        askew(co.Box((-1, -1, -1), (1, 1, 1)) - rod(2, 1, a)),
        8 - 2 * PI * a**2,
        area=24 - 2 * PI * a**2 + 4 * PI * a,
        centroid=(3, 4, 5),
    )
    t = 1e-3
    add("thin plate with a hole, tilted", askew(co.Box((-1, -1, -t / 2), (1, 1, t / 2)) - rod(2, 1, a)), (4 - PI * a**2) * t,
        area=2 * (4 - PI * a**2) + 8 * t + 2 * PI * a * t, centroid=(3, 4, 5))  # fmt: skip
    add(
        "thin shell",
        co.Sphere(1, (5, 0, 0)) - co.Sphere(1 - t, (5, 0, 0)),
        4 / 3 * PI * (3 * t - 3 * t**2 + t**3),
        area=4 * PI * (1 + (1 - t) ** 2),
        centroid=(5, 0, 0),
    )
    r, h = 0.5, 2.0
    add("capsule", askew(rod(0, h / 2, r) | co.Sphere(r, (h / 2, 0, 0)) | co.Sphere(r, (-h / 2, 0, 0))), PI * r**2 * h + 4 / 3 * PI * r**3,
        area=2 * PI * r * h + 4 * PI * r**2, centroid=(3, 4, 5))  # fmt: skip
    mass = PI * 0.49 * 1.5 / 3
    add("cone", co.Cone((0, 0, 0), (0, 0, 1.5), 0.7, 0) & HUGE, mass, area=PI * 0.7 * (0.7 + math.hypot(0.7, 1.5)), centroid=(0, 0, 1.5 / 4),
        inertia=(mass * (3 / 20 * 0.49 + 3 / 80 * 2.25),) * 2 + (mass * 3 / 10 * 0.49,))  # fmt: skip
    add(
        "Viviani's solid",
        co.Sphere(2) & co.Cylinder((1, 0, -3), (1, 0, 3), 1),
        (2 / 3 * PI - 8 / 9) * 8,
        area=2 * PI * 4,
    )
    normals = [(1, 1, 1), (1, -1, -1), (-1, 1, -1), (-1, -1, 1)]
    add(
        "tetrahedron",
        turned(20)(co.Polyhedron(normals, [1, 1, 1, 1]) & HUGE),
        8 * 8 / 24,
        area=math.sqrt(3) * 8,
        centroid=(0, 0, 0),
    )
    shear = [[1, 0.4, 0, 1], [-0.3, 1, 0.2, 0], [0, 0.5, 0.8, -2], [0, 0, 0, 1]]
    factor = np.linalg.det(np.array(shear)[:3, :3])
    add(
        "two crossed cylinders, sheared",
        (rod(0, 2, 1) & rod(1, 2, 1)).transform(shear),
        16 / 3 * factor,
        centroid=(1, 0, -2),
    )
    add(
        "eight balls",
        co.Spheres([(x, y, z) for x in (-1, 1) for y in (-1, 1) for z in (-1, 1)], 0.5),
        8 * PI / 6,
        area=8 * PI,
        centroid=(0, 0, 0),
    )
    t = 2e-3
    add("two thin rods askew", co.Cylinder((-1, -1, -1), (1, 1, 1), t) | co.Cylinder((-1, 1, -1), (1, -1, 2), t).translate((0.1, 0, 0)),
        PI * t**2 * (math.sqrt(12) + math.sqrt(17)), area=2 * PI * t * (math.sqrt(12) + math.sqrt(17)) + 4 * PI * t**2)  # fmt: skip
    add(
        "bow tie",
        turned(50)(co.DoubleCone(1) & co.Box((-2, -2, -1), (2, 2, 1))),
        2 * PI / 3,
        area=2 * PI * (1 + math.sqrt(2)),
        centroid=(0, 0, 0),
    )
    add("cube of eight", co.Union(tuple(co.Box((x, y, z), (x + 1, y + 1, z + 1)) for x in (0, 1) for y in (0, 1) for z in (0, 1))), 8, area=24, centroid=(1, 1, 1),
        inertia=(8 * 4 / 6,) * 3)  # fmt: skip
    return found


KNOWN = _cases()
