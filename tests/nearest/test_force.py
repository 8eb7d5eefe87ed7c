"""Distances against force in extended precision, which shares no code with them."""

from __future__ import annotations

import numpy as np
import pytest

from ..samples import sampled
from .bodies import BODIES, random_body
from .force import Walls
from .judge import faults


def test_force_knows_what_is_known():
    # From the middle of an ellipsoid with the radii 1, 2 and 1/2 its wall is 1/2 away.
    least, point, sure = Walls(BODIES["ellipsoid"][1], np.random.default_rng(5)).nearest((0.0, 0.25, 0.125))
    assert sure
    assert BODIES["ellipsoid"][1](point) == pytest.approx(0, abs=1e-16)
    # A box: the nearest point of a corner's neighbourhood is the corner.
    least, point, _ = Walls(BODIES["box"][1], np.random.default_rng(5)).nearest((2.0, 1.5, 2.75))
    assert float(least) == pytest.approx(np.sqrt(1 + 1 + 4), rel=1e-15)
    assert point.astype(float) == pytest.approx((1, 0.5, 0.75), abs=1e-15)


def test_a_wrong_distance_is_found(monkeypatch):
    monkeypatch.setitem(BODIES, "ball", (BODIES["ball"][0].scale(1.0 + 2.0**-40), BODIES["ball"][1]))
    assert list(faults("ball", np.random.default_rng(0), 60, 10))


@pytest.mark.parametrize("name", sampled(BODIES, 5))
def test_distances_are_within_the_bound_that_they_tell(name):
    assert list(faults(name, np.random.default_rng(11), 25, 1)) == []


def random_faults(seed, count, forced):
    """Those of a random body that is not empty."""
    rng = np.random.default_rng(seed)
    while True:
        try:
            return list(faults(f"random {seed}", rng, count, forced, random_body(rng), 0.5))
        except ValueError as error:
            if "empty" not in str(error):
                raise


@pytest.mark.parametrize("seed", sampled([1, 2, 5], 3))
def test_random_bodies(seed):
    assert random_faults(seed, 40, 2) == []


@pytest.mark.deep
@pytest.mark.parametrize("seed", range(100, 300))
def test_many_random_bodies(seed):
    assert random_faults(seed, 100, 4) == []


@pytest.mark.deep
@pytest.mark.parametrize("seed", range(4))
@pytest.mark.parametrize("name", BODIES)
def test_many_distances_are_within_the_bound_that_they_tell(name, seed):
    assert list(faults(name, np.random.default_rng(seed), 200, 8)) == []
