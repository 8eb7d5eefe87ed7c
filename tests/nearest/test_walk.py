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


@pytest.mark.deep
def test_a_map_of_the_block_and_of_the_closed_form(example):
    pixels = example.picture(24, 40).pixels
    assert pixels.shape == (24, 58 + 2 + 24, 3)
    assert np.isfinite(pixels).all()
    ring = pixels[:, 60:]
    assert ring[12, [0, 8, 16, 23]] == pytest.approx(0.8)  # the hole, and outside
    assert ring[:, 12].min() == 1  # the line between
    # Walked on the left, worked out on the right: mirror images but for the noise and the lines
    left, right = ring[:, 1:11], ring[:, 22:12:-1]
    wall = (left != 0.8).any(axis=-1) & (right != 0.8).any(axis=-1)
    assert wall.sum() > 100
    assert np.median(np.abs(left - right)[wall]) < 0.1
    assert np.abs(left - right)[wall].mean() < 0.15


def test_neighbours_that_are_there_are_averaged(example):
    values = np.array([[1.0, 2.0, np.nan], [3.0, np.nan, np.nan]])
    expected = [[2.0, 2.0, np.nan], [2.0, np.nan, np.nan]]
    np.testing.assert_array_equal(example.smoothed(values), expected)
