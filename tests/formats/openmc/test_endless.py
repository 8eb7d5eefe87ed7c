"""A lattice in two dimensions, its cells without ends along z: located and met by few nodes, however many pins."""

from __future__ import annotations

import math

import numpy as np
import pytest

import conicoid as co

from ...engine.nodes import Nodes
from .models import endless, loaded, put

RADIUS = 0.4
SIDES = 8, 32


@pytest.fixture(scope="module")
def lattices(tmp_path_factory: pytest.TempPathFactory) -> dict[int, co.Scene]:
    folder = tmp_path_factory.mktemp("lattices")
    return {side: loaded(put(endless(side, RADIUS), folder)) for side in SIDES}


def test_points_are_located_by_few_nodes(lattices: dict[int, co.Scene]) -> None:
    """Sixteen times as many pins: hardly more nodes for a point, at any height; nothing stands beside the trees."""
    random = np.random.default_rng(3)
    mean = {}
    for side, scene in lattices.items():
        assert len(scene.bodies) == 2 * side**2
        points = random.uniform((0, 0, -1e6), (side, side, 1e6), (400, 3))
        element = np.floor(points[:, :2])
        pin = ((points[:, :2] - element - 0.5) ** 2).sum(axis=1) < RADIUS**2
        located = scene.body_at(points)
        names = np.array([body.name for body in scene.bodies])
        wanted = [
            f"cell {1 if inner else 2} @ cell 3, lattice 9 [{x:.0f}, {y:.0f}]"
            for inner, (x, y) in zip(pin, element, strict=True)
        ]
        assert names[located].tolist() == wanted
        nodes = Nodes(scene)
        nodes.check()
        assert nodes.beside() == []
        mean[side] = np.mean([nodes.visits(point) for point in points])
    assert mean[32] < mean[8] + 3
    assert mean[32] < 8


def test_a_ray_meets_every_wall_that_arithmetic_says(lattices: dict[int, co.Scene]) -> None:
    """Along x through the middles of pins: water, pin, water in each element, without a gap, at any height."""
    for side, scene in lattices.items():
        spans = scene.spans((-1.0, 2.5, 123456.0), (1, 0, 0))
        ends = np.append(spans.t_enter, spans.t_exit[-1])
        walls = [k + 1 + at for k in range(side) for at in (0, 0.5 - RADIUS, 0.5 + RADIUS)] + [side + 1]
        assert (spans.t_enter[1:] == spans.t_exit[:-1]).all()
        assert np.allclose(ends, walls, rtol=1e-12, atol=0)
        assert scene.first_hit((-1.0, 2.5, -7e5), (1, 0, 0)).t == 1.0
        assert scene.first_hit((0.5, 0.5, 0.0), (0, 0, 1)).t == math.inf
