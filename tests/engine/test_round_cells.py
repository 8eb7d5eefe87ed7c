"""Balls around cells hold them, and are as tight as a formula says."""

import math

import numpy as np
import pytest

import conicoid as co
from conicoid.kernels import tables as table
from conicoid.kernels.bvh.walk import ROUND, ROWS
from conicoid.kernels.tables import length

# Shape, and the radius of the least ball around it whose center is halfway along its axis
CASES = [
    (co.Cylinder((0, 0, -1), (0, 0, 1), 0.5), math.hypot(0.5, 1.0)),
    (co.Ellipsoid((1, 2, 3)), 3.0),
    (co.Ellipsoid((2, 2, 2), z_range=(-1.0, 1.0)), 2.0),
    (co.Ellipsoid((2, 2, 2), z_range=(1.0, 2.0)), 2.0),  # the least ball around a ball is itself
    (co.Ellipsoid((2, 2, 3), z_range=(1.5, 3.0)), math.hypot(math.sqrt(3.0), 0.75)),
    # x² + y² = z² between 1 and 2: the upper rim
    (co.EllipticCone(1, 1, 1, z_range=(1.0, 2.0)), math.hypot(2.0, 0.5)),
    # x² + y² = 1 + z²
    (co.OneSheetHyperboloid(1, 1, 1, z_range=(-1.0, 1.0)), math.sqrt(3.0)),
    (co.EllipticCylinder(0.25, 1.0, z_range=(-1.0, 2.0)), math.hypot(2.0, 1.5)),
    # x² + y² = z: the rim
    (co.EllipticParaboloid(1, 1, z_range=(0.0, 2.0)), math.hypot(math.sqrt(2.0), 1.0)),
]


def ball_of(shape):
    """Return (center, radius, whether it is better than the box) of the only entry of a scene."""
    geometry = co.Scene([shape])._prepared.geometry
    assert length(geometry, table.LEAF_ITEMS) == ROWS
    items = geometry.floats[geometry.places[table.LEAF_ITEMS] :][:ROWS]
    return items[:3], items[3], items[4] % 1 == ROUND


def points_of(shape, count=4000):
    """Return points on a shape, by rays towards its middle."""
    rng = np.random.default_rng(0)
    low, high = (np.array(corner) for corner in shape.bounds)
    directions = rng.normal(size=(count, 3))
    far = np.linalg.norm(high - low)
    origins = (low + high) / 2 + far * directions / np.linalg.norm(directions, axis=1, keepdims=True)
    targets = rng.uniform(low, high, (count, 3))
    points = co.Scene([shape]).first_hit(origins, targets - origins).point
    return points[np.isfinite(points[:, 0])]


@pytest.mark.parametrize(("shape", "radius"), CASES)
@pytest.mark.parametrize("turned", [False, True])
def test_a_ball_around_a_cell_holds_it_and_is_tight(shape, radius, turned):
    if turned:
        shape = shape.scale(0.1).rotate((1, 2, 3), 40).translate((5, -70, 11))
        radius *= 0.1
    center, found, preferred = ball_of(shape)
    low, high = (np.array(corner) for corner in shape.bounds)
    assert abs(found - radius) <= 1e-5 * radius
    points = points_of(shape)
    assert len(points) > 1000
    assert np.linalg.norm(points - center, axis=1).max() <= found * (1 + 1e-12)
    half = (high - low) / 2
    area = 2 * (half[0] * half[1] + half[1] * half[2] + half[2] * half[0])
    assert preferred == (math.pi * found**2 <= area)


@pytest.mark.parametrize(
    "shape",
    [
        co.Box((-1, -2, -3), (1, 2, 3)).rotate((1, 1, 0), 30),
        # Stretched across its axis and turned: the planes are not at right angles to it
        co.Cylinder((0, 0, -1), (0, 0, 1), 0.5).rotate((1, 0, 0), 40).scale((1, 3, 0.5)),
        co.HyperbolicParaboloid(1, 1, within=co.Box((-1, -1, -1), (1, 1, 1))),
    ],
)
def test_others_have_the_ball_around_their_box(shape):
    center, found, _ = ball_of(shape)
    low, high = (np.array(corner) for corner in shape.bounds)
    assert abs(found - 0.5 * np.linalg.norm(high - low)) <= 1e-9 * found
    assert np.allclose(center, (low + high) / 2, rtol=0, atol=1e-9)


@pytest.mark.parametrize("size", [1e-95, 1e-30, 1e30, 1e95])
@pytest.mark.parametrize(("shape", "radius"), CASES)
def test_balls_hold_cells_of_any_size(shape, radius, size):
    center, found, _ = ball_of(shape.scale(size))
    low, high = (np.array(corner) for corner in shape.bounds)
    assert radius * (1 - 1e-12) <= found / size <= 0.5 * np.linalg.norm(high - low) * (1 + 1e-9)
    assert np.linalg.norm(points_of(shape) - center / size, axis=1).max() <= found / size * (1 + 1e-12)
