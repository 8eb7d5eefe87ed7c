"""The points of light transport: nets in each pair of dimensions, the same at any time, without regard to each other."""

from __future__ import annotations

import numba
import numpy as np
import pytest

from conicoid.render import sampling as sobol

from ..compiled import compiled
from ..samples import deep


@numba.njit
def _points(seed, pixel, count, pair):
    found = np.empty((count, 2))
    for k in range(count):
        found[k] = sobol.sobol_pair(seed, pixel, k, pair)
    return found


@pytest.mark.parametrize("pair", [0, 1, 7])
@pytest.mark.parametrize("pixel", [0, 12345])
@pytest.mark.parametrize("power", [1, 4, 7, deep(10)])
def test_every_box_of_a_power_of_two_has_one_point(pair, pixel, power):
    """A (0, m, 2)-net: also of the first 2^m points, so that a picture may go on."""
    points = _points(3, pixel, 2**power, pair)
    assert ((points >= 0) & (points < 1)).all()
    for across in range(power + 1):
        boxes = np.floor(points * (2**across, 2 ** (power - across))).astype(int)
        assert len({tuple(box) for box in boxes}) == 2**power


def test_single_dimensions_are_those_of_pairs():
    one = compiled(sobol.sobol)
    for k in range(20):
        assert [one(5, 6, k, 8), one(5, 6, k, 9)] == list(_points(5, 6, 20, 4)[k])


@pytest.mark.parametrize("other", [dict(seed=1), dict(pixel=8), dict(pair=3)])
def test_seeds_pixels_and_pairs_have_points_of_their_own(other):
    first = dict(seed=0, pixel=7, count=64, pair=2)
    assert (_points(*first.values()) != _points(*(first | other).values())).all()


def test_pairs_and_pixels_are_independent_on_the_whole():
    """Moments of 16 points in each of 4000 pixels, in two pairs, to 5 standard errors of independent ones."""
    a, b = (np.concatenate([_points(0, pixel, 16, pair) for pixel in range(4000)]) for pair in (4, 5))
    four = np.concatenate([a, b], axis=1)
    assert np.abs(four.mean(axis=0) - 0.5).max() < 5 / np.sqrt(12 * len(four))
    correlation = np.corrcoef(four.T) - np.eye(4)
    assert np.abs(correlation).max() < 5 / np.sqrt(len(four))
