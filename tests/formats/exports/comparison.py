"""Comparisons of scenes that must answer alike, to the last bit."""

from pathlib import Path
from typing import Any

import numpy as np

import conicoid as co


def written_and_read(scene: co.Scene, path: Path, **options: Any) -> co.Scene:
    """Write a scene and return the scene of the file.

    Lengths keep their numbers, because units have tests of their own.
    """
    co.export(scene.replace(unit=None), path, **options)
    return co.load(path)


def rays_through(scene: co.Scene, count: int = 1500) -> co.Rays:
    """Return rays from around a scene to points in it.

    A tenth of them go along the axes, so that they run in flat faces too.
    """
    rng = np.random.default_rng(7)
    low, high = scene.extent
    size = (high - low).max()
    origins = rng.uniform(low - 0.1 * size, high + 0.1 * size, (count, 3))
    ends = rng.uniform(low, high, (count, 3))
    directions = ends - origins
    straight = count // 10
    directions[:straight] = np.eye(3)[rng.integers(0, 3, straight)]
    return co.Rays(origins, directions)


def assert_same_answers(one: co.Scene, other: co.Scene, count: int = 1500) -> None:
    """Assert equal spans, first hits and points, bit by bit, and that at least one ray hits."""
    rays = rays_through(one, count)
    a, b = one.spans(rays), other.spans(rays)
    assert len(a.t_enter) > 0
    for name in ("offsets", "body", "t_enter", "t_exit"):
        np.testing.assert_array_equal(getattr(a, name), getattr(b, name), err_msg=name)
    mine, its = one.first_hit(rays), other.first_hit(rays)
    for name in ("body", "t", "normal", "entering"):
        np.testing.assert_array_equal(getattr(mine, name), getattr(its, name), err_msg=name)
    points = rays.origins + rays.directions
    np.testing.assert_array_equal(one.body_at(points), other.body_at(points))


def assert_close_answers(one: co.Scene, other: co.Scene, tolerance: float = 1e-9) -> None:
    """Assert equal bodies along rays, with lengths within a tolerance: the file has rounded numbers."""
    rays = rays_through(one, 400)
    a, b = (scene.spans(rays).lengths() for scene in (one, other))
    size = float((one.extent[1] - one.extent[0]).max())
    np.testing.assert_allclose(a, b, rtol=0, atol=tolerance * size)
