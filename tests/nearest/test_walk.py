"""Walks on spheres, the example of distances, against the closed form between two spheres."""

from __future__ import annotations

import importlib.util
from pathlib import Path

import numpy as np
import pytest

import conicoid as co

EXAMPLE = Path(__file__).parents[2] / "examples" / "walk_on_spheres.py"


@pytest.fixture
def example():
    spec = importlib.util.spec_from_file_location("walk_on_spheres", EXAMPLE)
    module = importlib.util.module_from_spec(spec)
    spec.loader.exec_module(module)
    return module


def test_heat_between_two_spheres(example):
    hollow = co.Scene([co.Sphere(2) - co.Sphere(1)])
    points = np.array([(1.25, 0, 0), (0, 1.5, 0), (0, 0, -1.75), (1, 1, 0.5)])
    value, error = example.heat(hollow, points, lambda nearest: nearest.face == 1, 600)
    exactly = example.shell(1, 2, np.linalg.norm(points, axis=1))
    assert exactly[1] == pytest.approx((1 / 1.5 - 1 / 2) / (1 - 1 / 2))
    assert (error < 0.03).all()
    assert np.abs(value - exactly) == pytest.approx(np.zeros(4), abs=4 * error.max())


def test_a_map_of_the_block(example):
    pixels = example.picture(30, 4).pixels
    assert pixels.shape == (12, 30, 3)
    assert np.isfinite(pixels).all()
    assert pixels.std() > 0.1
