"""Images of surroundings: directions as densely as is said, and as there is light."""

from __future__ import annotations

import numba
import numpy as np
import pytest

from conicoid.render.lights.environment import (
    environment_density,
    environment_direction,
    lower_environment,
    mean_radiance,
)

HEIGHT, WIDTH = 6, 10
IMAGE = np.random.default_rng(4).random((HEIGHT, WIDTH, 3)) ** 3


@numba.njit
def _drawn(image, numbers, out):
    for k in range(len(numbers)):
        d, density = environment_direction(image, numbers[k, 0], numbers[k, 1])
        out[k, 0], out[k, 1], out[k, 2], out[k, 3] = d[0], d[1], d[2], density
        out[k, 4] = environment_density(image, d[0], d[1], d[2])


def test_directions_are_as_dense_as_is_said():
    """χ² over the pixels: the density is even within each, so its share is density times solid angle."""
    count = 40_000
    numbers, out = np.random.default_rng(1).random((count, 2)), np.empty((count, 5))
    _drawn(lower_environment(IMAGE), numbers, out)
    assert out[:, 4] == pytest.approx(out[:, 3], rel=1e-6)
    assert np.linalg.norm(out[:, :3], axis=1) == pytest.approx(np.ones(count), rel=1e-12)
    row = (np.arccos(out[:, 2]) / np.pi * HEIGHT).astype(int)
    column = (np.arctan2(out[:, 1], out[:, 0]) / (2 * np.pi) % 1 * WIDTH).astype(int)
    edges = np.cos(np.linspace(0, np.pi, HEIGHT + 1))
    angle = (edges[:-1] - edges[1:])[row] * 2 * np.pi / WIDTH
    pixel = row * WIDTH + column
    seen = np.bincount(pixel, minlength=HEIGHT * WIDTH)
    share = np.zeros(HEIGHT * WIDTH)
    share[pixel] = out[:, 3] * angle
    assert share.sum() == pytest.approx(1, rel=1e-9)
    square = ((seen - count * share) ** 2 / (count * share)).sum()
    assert square < HEIGHT * WIDTH + 5 * np.sqrt(2 * HEIGHT * WIDTH)


def test_the_mean_of_all_directions():
    assert mean_radiance(np.full((5, 9, 3), 0.7)) == pytest.approx(0.7, rel=1e-12)
