"""Machine parts as people write them, flush, coaxial and about zero, are prepared without exact arithmetic."""

from __future__ import annotations

import math
from collections.abc import Callable
from functools import reduce
from operator import or_

import numpy as np
import pytest

import conicoid as co
from conicoid.geometry.shape import Boolean, Shape
from conicoid.prepare import batch_lowering, body_collector
from conicoid.prepare.body_collector import ExactBodySurfaces
from conicoid.prepare.lowering import lower
from conicoid.prepare.surface_names import FEWEST_SURFACES


def rod(x: float, y: float, radius: float, low: float = -1, high: float = 1) -> co.Cylinder:
    return co.Cylinder((x, y, low), (x, y, high), radius)


TEETH = [co.Box((0.8, -0.1, -0.2), (1.3, 0.1, 0.2)).rotate("z", 30 * k) for k in range(12)]
FLOORS = [co.Box((-1, -1, k), (1, 1, k + 1)) for k in range(3)]
CORNERS = [(x, y) for x in (-0.5, 0.5) for y in (-0.5, 0.5)]
PARTS: dict[str, tuple[Shape, int]] = {
    "plate with flush holes": (co.Box() - reduce(or_, [rod(x, y, 0.2) for x, y in CORNERS]), 6 + 4),
    "plate with long holes": (co.Box() - reduce(or_, [rod(x, y, 0.2, -2, 2) for x, y in CORNERS]), 6 + 4 + 2),
    "peg on a box": (co.Box() | rod(0, 0, 0.2, 1, 2), 6 + 2),
    "peg from above": (co.Box() | co.Cylinder((0.5, 0, 2), (0.5, 0, 1), 0.2), 6 + 2),
    "peg through the side": (co.Box() - co.Cylinder((1, 0.5, 0), (-1, 0.5, 0), 0.2), 6 + 1),
    # Squares that a quarter turn takes to themselves
    "tower": (FLOORS[0].rotate("z", 30) | FLOORS[1].rotate("z", 120) | FLOORS[2].rotate("-z", 60), 4 + 4),
    "tower at 45 degrees": (FLOORS[0].rotate("z", 45) | FLOORS[1].rotate("z", 135) | FLOORS[2].rotate("-z", 45), 4 + 4),
    "hemisphere": (co.Sphere(1) & co.HalfSpace((0, 0, 1), 0), 2),
    "octant": (co.Sphere(1) & co.HalfSpace((1, 0, 0), 0) & co.HalfSpace((0, 1, 0), 0) & co.HalfSpace((0, 0, 1), 0), 4),
    "die": ((co.Box() & co.Sphere(1.4)) - co.Sphere(0.2, (0, 0, 1)) - co.Sphere(0.2, (0, 1, 0)), 6 + 3),
    "stepped shaft": (rod(0, 0, 1) | rod(0, 0, 0.5, 1, 2), 2 + 3),
    "oblique stepped shaft": (co.Cylinder((0, 0, 0), (1, 2, 3), 0.5) | co.Cylinder((1, 2, 3), (2, 4, 6), 0.2), 2 + 3),
    "oblique rod in two": (co.Cylinder((0, 0, 0), (1, 2, 3), 0.5) | co.Cylinder((1, 2, 3), (2, 4, 6), 0.5), 1 + 3),
    "oblique bar about zero": (co.Cylinder((-1, -2, -3), (1, 2, 3), 0.5) - co.Sphere(0.6), 3 + 1),
    # Opposite teeth have their two sides in common
    "gear": ((rod(0, 0, 1, -0.2, 0.2) | reduce(or_, TEETH)) - rod(0, 0, 0.3, -0.2, 0.2), 2 + 2 + 2 * 12 + 12),
    "flat lens": (co.Lens(5, math.inf, 1, 2), 3),
    "oblique point": (co.Cone((0, 0, 0), (1, 1, 0), 1, 0), 3),
    "cup": (co.Cone((0, 0, 0), (0, 0, 2), 1, 0) - co.Cone((0, 0, -0.2), (0, 0, 1.8), 1, 0), 2 * 3),
    "bowl in a box": (co.Quadric(coefficients={"xx": 1, "yy": 1, "z": -1}) & co.Box(), 1 + 6),
    "tile": (co.Polygon([(0, 0, 1), (1, 0, 1), (1, 1, 1), (0, 2, 1)]), 1),
    "dish": (co.EllipticParaboloid(1, 1) & co.HalfSpace((0, 0, 1), 1), 2),
    "slice of a cone": (co.EllipticCone(1, 1, 1) & co.HalfSpace((0, 0, 1), 2) & co.HalfSpace((0, 0, -1), -1), 3),
    "waist": (co.OneSheetHyperboloid(1, 2, 1) & co.HalfSpace((0, 0, 1), 1) & co.HalfSpace((0.1, 0, -1), 1), 3),
}
"""Shapes, and how many different planes and quadrics bound each."""


def turned(shape: Shape, rng: np.random.Generator) -> Shape:
    return shape.rotate(rng.normal(size=3), rng.uniform(0, 360))


MOTIONS: dict[str, Callable[[Shape, np.random.Generator], Shape]] = {
    "turned": turned,
    "turned about z": lambda shape, rng: shape.rotate("z", rng.uniform(0, 360)),
    "scaled": lambda shape, rng: turned(shape.scale(rng.uniform(0.5, 2)), rng),
    "stretched": lambda shape, rng: shape.scale(tuple(rng.uniform(0.5, 2, 3))).rotate("z", rng.uniform(0, 360)),
    "by a matrix": lambda shape, rng: shape.transform(
        np.vstack([np.column_stack([np.linalg.qr(rng.normal(size=(3, 3)))[0], np.zeros(3)]), (0, 0, 0, 1)])
    ),
}


@pytest.mark.parametrize("motion", MOTIONS)
@pytest.mark.parametrize("part", PARTS)
def test_parts_are_prepared_together(part: str, motion: str, monkeypatch: pytest.MonkeyPatch) -> None:
    """Walls are one where they coincide. In the second scene of a process few bodies take exact arithmetic.

    Few surfaces that may be equal have exact names, and few bodies of a sort no recording.
    """
    rng, count = np.random.default_rng(7), 200
    solid, surfaces = PARTS[part]
    single: list[str] = []

    def watch(owner: object, name: str) -> None:
        work = getattr(owner, name)
        monkeypatch.setattr(owner, name, lambda *arguments: single.append(name) or work(*arguments))

    for scene in range(2):
        shapes: list[Shape] = [MOTIONS[motion](solid, rng).translate(rng.uniform(-50, 50, 3)) for _ in range(count)]
        if scene:
            watch(ExactBodySurfaces, "name")
            watch(batch_lowering, "lower_shape")
            watch(body_collector, "lower_shape")
            watch(Boolean, "bounds_under")
        tables = lower(list(map(co.Body, shapes))).tables
    assert len(tables.surface_kind) == surfaces * count
    assert len(single) < FEWEST_SURFACES
