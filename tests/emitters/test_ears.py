"""Polygons cut into triangles: all of the area, nothing beside it; what crosses itself is left alone."""

from __future__ import annotations

import math

import numpy as np
import pytest

from conicoid.render.lights.light_tables import triangulate

ARROW = [(0, 0), (4, -3), (1, 0), (4, 3)]
COMB = [(0, 0), (6, 0), (6, 3), (5, 3), (5, 1), (4, 1), (4, 3), (3, 3), (3, 1), (2, 1), (2, 3), (0, 3)]
ROUND = [(math.cos(a), math.sin(a)) for a in np.linspace(0, 6, 20)]


def area(loop):
    """The shoelace formula."""
    x, y = np.array(loop, float).T
    return 0.5 * abs(np.dot(x, np.roll(y, -1)) - np.dot(y, np.roll(x, -1)))


@pytest.mark.parametrize("loop", [ARROW, COMB, ROUND, ARROW[::-1]], ids=["arrow", "comb", "round", "clockwise"])
@pytest.mark.parametrize("axes", [(0, 1, 2), (1, 2, 0), (2, 0, 1)])
def test_all_of_the_area(loop, axes):
    points = np.zeros((len(loop), 3))
    points[:, axes[0]], points[:, axes[1]], points[:, axes[2]] = *np.array(loop, float).T, 7
    cut = triangulate(points)
    assert cut.shape == (len(loop) - 2, 3)
    a, b, c = (points[cut[:, k]] for k in range(3))
    sizes = np.linalg.norm(np.cross(b - a, c - a), axis=1) / 2
    assert sizes.sum() == pytest.approx(area(loop), rel=1e-12)


def test_a_loop_that_crosses_itself_is_left_alone():
    assert triangulate(np.array([(0, 0, 0), (1, 1, 0), (1, 0, 0), (0, 2, 0)], float)) is None
