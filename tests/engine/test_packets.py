"""Tiles of pictures that see more bodies than they can hold, or further than the one before: the hits are the same."""

from __future__ import annotations

import numpy as np

import conicoid as co


def deep_scene():
    """20,000 balls in a long corridor, and parallel rays along it: one tile sees all of them, more than it can hold."""
    rng = np.random.default_rng(1)
    scene = co.Scene([co.Spheres(rng.uniform(0, 1, (20_000, 3)) * (1, 1, 100), np.full(20_000, 0.006))])
    x, y = np.meshgrid((np.arange(32) + 0.5) / 32, (np.arange(32) + 0.5) / 32)
    origins = np.stack([x, y, np.full_like(x, -1.0)], axis=-1)
    return scene, co.Rays(origins, np.broadcast_to((0.0, 0.0, 1.0), origins.shape).copy())


def test_hits_are_the_same_where_a_tile_holds_nodes():
    scene, rays = deep_scene()
    order = np.random.default_rng(2).permutation(1024)
    together = scene.first_hit(rays)
    apart = scene.first_hit(rays.origins.reshape(-1, 3)[order], rays.directions.reshape(-1, 3)[order])
    assert np.array_equal(together.t.ravel()[order], apart.t)
    assert 0.3 < np.isfinite(apart.t).mean() < 1.0


def test_hits_are_the_same_where_a_tile_sees_further_than_the_one_before():
    """A wall with slots before a deep lattice: beside tiles that end at the wall lie others that see through it."""
    x, y, z = (part.ravel() for part in np.meshgrid(np.arange(40.0), np.arange(20.0), np.arange(40.0)))
    slots = [co.Box((a, -9, -3), (a + 1.0, 9, -2)) for a in (-7.3, 0.4, 6.8)]
    wall = co.Box((-40, -20, -3), (40, 20, -2)) - slots[0] - slots[1] - slots[2]
    scene = co.Scene([co.Spheres(np.stack([x - 19.5, y - 9.5, z + 4.0], axis=1), np.full(len(x), 0.35)), wall])
    rays = co.Camera((0.3, 0.2, -30), (0, 0, 0), up=(0, 1, 0), field_of_view=34).rays(288, 96)
    order = np.random.default_rng(3).permutation(288 * 96)
    together, apart = scene.first_hit(rays), scene.first_hit(rays[np.unravel_index(order, rays.shape)])
    for field in ("t", "body", "face", "surface", "entering"):
        assert np.array_equal(getattr(together, field).ravel()[order], getattr(apart, field)), field
    seen = np.isin(np.arange(32_001), together.body)
    assert seen[:-1].sum() > 300, "balls through the slots"
    assert 0.5 < (together.body == 32_000).mean() < 0.95
