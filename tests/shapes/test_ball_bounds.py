"""Boxes around what balls and boxes have in common: against the closed form of a lens, and alike alone and together."""

from __future__ import annotations

import math

import numpy as np
import pytest

import conicoid as co
from conicoid.prepare.lowering import lower


@pytest.mark.parametrize("reach", [0.25, 1.0, 1.5])
def test_a_turned_lens(reach: float) -> None:
    """A ball of radius 2 about the origin, and one of radius 3 beside it along x, turned about z and x.

    The second ends at x = reach; the box of both cuts the first there: across x it reaches sqrt(4 - reach²), where the
    second ball is wide enough.
    """
    lens = (co.Sphere(2) & co.Sphere(3, (reach - 3, 0, 0))).rotate("x", 40)
    low, high = lens.bounds
    assert (low[0], high[0]) == pytest.approx((-2, reach), abs=1e-11)
    assert high[0] >= reach
    second = math.sqrt(9 - max(0.0, -2 - (reach - 3)) ** 2)
    assert high[1] == pytest.approx(min(2.0, second), rel=1e-11)


def test_alone_and_together_are_one() -> None:
    rng = np.random.default_rng(4)

    def one() -> co.Solid:
        ball = co.Sphere(2, rng.uniform(-1, 1, 3))
        solid = (
            ball & co.Sphere(rng.uniform(1, 2), rng.uniform(-1, 1, 3)) & co.Box((-1, -1, -1), rng.uniform(0.5, 2, 3))
        )
        solid = solid - co.Cylinder((0, 0, -3), (0, 0, 3), 0.3)
        return solid.rotate("z", 90).translate(rng.uniform(-3, 3, 3))

    shapes = [one() for _ in range(40)]
    boxes = lower([co.Body(shape) for shape in shapes]).boxes
    for shape, box in zip(shapes, boxes, strict=True):
        assert np.array_equal(np.concatenate(shape.bounds), box)
        low, high = shape.bounds
        points = rng.uniform(low - 0.2, high + 0.2, (2000, 3))
        inside = points[co.Scene([shape]).contains(points)] if shape is shapes[0] else points[:0]
        assert ((inside >= low) & (inside <= high)).all()
