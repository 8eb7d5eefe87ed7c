"""Samples in a pixel: stratified, reproducible, different from pixel to pixel."""

from __future__ import annotations

import numpy as np
import pytest

from conicoid.render import sampling as sampler

from ..compiled import compiled

reversed_bits, sample_in_pixel = compiled(sampler.reverse_bits), compiled(sampler.sample_in_pixel)


def samples(count: int, pixel: int = 7, seed: int = 0) -> np.ndarray:
    return np.array([sample_in_pixel(seed, pixel, i, count) for i in range(count)])


def test_one_sample_is_the_centre():
    assert sample_in_pixel(3, 4, 0, 1) == (0.5, 0.5)


@pytest.mark.parametrize("count", [2, 3, 4, 5, 7, 9, 16, 25, 64])
def test_each_column_has_one_sample(count):
    for pixel in range(20):
        points = samples(count, pixel)
        assert ((points >= 0) & (points < 1)).all()
        assert (np.floor(points[:, 0] * count) == np.arange(count)).all()


@pytest.mark.parametrize("power", [1, 2, 3, 4, 6])
def test_every_box_of_a_power_of_two_has_one_sample(power):
    count = 2**power
    for pixel in range(20):
        points = samples(count, pixel)
        for columns in (2**k for k in range(power + 1)):
            cells = np.floor(points * (columns, count // columns)).astype(int)
            assert len({tuple(cell) for cell in cells}) == count


def test_samples_depend_on_seed_and_pixel_only():
    assert (samples(9) == samples(9)).all()
    assert (samples(9) != samples(9, pixel=8)).all()
    assert (samples(9) != samples(9, seed=1)).all()


def test_samples_are_uniform_on_the_whole():
    """The mean of 9 × 4000 stratified samples is that of the square, to 5 standard errors of independent ones."""
    points = np.concatenate([samples(9, pixel) for pixel in range(4000)])
    assert np.abs(points.mean(axis=0) - 0.5).max() < 5 / np.sqrt(12 * len(points))
    assert np.abs((points**2).mean(axis=0) - 1 / 3).max() < 5 * np.sqrt(4 / 45 / len(points))


def test_bits_reverse():
    for value in (0, 1, 2, 0b1011, 2**63, 2**64 - 1, 0x0123456789ABCDEF):
        assert int(reversed_bits(np.uint64(value))) == int(f"{value:064b}"[::-1], 2)
