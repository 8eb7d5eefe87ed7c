"""Set algebra holds on every ray, to the bit."""

from __future__ import annotations

import math
from typing import Any

import numpy as np
import pytest

import conicoid as co

from ..samples import size
from .intervals import same, table
from .rays import mixed_rays, random_rays
from .trees import tree

SEEDS = [(seed, grid) for seed in range(6) for grid in (False, True)]


def spans_of(shape: Any, rays: Any) -> tuple[Any, Any, Any]:
    found = co.Scene([shape]).spans(*rays, t_min=-math.inf)
    return found.offsets, found.t_enter, found.t_exit


def assert_equal(one: Any, other: Any, rays: Any) -> None:
    """Equal spans to the bit in one scene; in scenes of their own as many spans, equal up to the choice of a surface's record."""
    spans = co.Scene([one, other]).spans(*rays, t_min=-math.inf)
    assert same(table(spans, 0), table(spans, 1)).all()
    for a, b in zip(spans_of(one, rays), spans_of(other, rays), strict=True):
        assert np.allclose(a, b, rtol=1e-12, atol=1e-12)


@pytest.fixture(
    params=[pair if pair[0] < 1 else pytest.param(pair, marks=pytest.mark.deep) for pair in SEEDS],
    ids=lambda pair: f"{'grid' if pair[1] else 'random'} {pair[0]}",
)
def pair(request: Any) -> tuple[Any, Any, Any]:
    """Two solids and rays."""
    seed, grid = request.param
    r = np.random.default_rng(seed)
    a, b = tree(r, 2, grid=grid).shape, tree(r, 2, grid=grid).shape
    return a, b, (mixed_rays if grid else random_rays)(r, size(200, 400))


def test_difference_is_intersection_with_the_complement(pair: Any):
    a, b, rays = pair
    assert_equal(a - b, a & ~b, rays)
    assert_equal(a - b - a.translate((0.5, 0, 0)), a - (b | a.translate((0.5, 0, 0))), rays)


def test_de_morgan(pair: Any):
    a, b, rays = pair
    assert_equal(~(a | b), ~a & ~b, rays)
    assert_equal(~(a & b), ~a | ~b, rays)
    assert_equal(~~a, a, rays)


def test_a_solid_with_itself(pair: Any):
    a, _, rays = pair
    assert_equal(a & a, a, rays)
    assert_equal(a | a, a, rays)
    for empty in (a - a, a & ~a, ~(a | ~a)):
        scene = co.Scene([empty])
        assert len(scene.crossings(*rays, t_min=-math.inf).t) == 0
        assert len(scene.spans(*rays, t_min=-math.inf).t_enter) == 0
        assert not scene.contains(rays[0]).any()
    everything = co.Scene([a | ~a]).spans(*rays, t_min=-math.inf)
    assert len(everything.t_enter) == len(rays[0])
    assert everything.enter_clipped.all()
    assert everything.exit_clipped.all()


def test_what_was_cut_off_fits_back(pair: Any):
    a, b, rays = pair
    assert_equal((a - b) | (a & b), a, rays)
    assert_equal((a | b) - b, a - b, rays)
    assert_equal(a & (a | b), a, rays)
    assert_equal(a | (a & b), a, rays)


def test_order_does_not_matter(pair: Any):
    a, b, rays = pair
    c = b.translate((0, 1, 0))
    for one in (co.Union, co.Intersection):
        for order in ((b, a, c), (b, c, a)):  # which every order is made of
            assert_equal(one(order), one((a, b, c)), rays)
    assert_equal((a | b) | c, a | (b | c), rays)
    assert_equal(a & (b | c), (a & b) | (a & c), rays)
    assert_equal(a - b - c, a - c - b, rays)


def test_moved_together_is_moved_apart(pair: Any):
    """A motion of a tree is the same motion of its operands."""
    a, b, rays = pair

    def moved(shape: Any) -> Any:
        return shape.rotate((1, 2, 3), 40).scale((1, -2, 0.5)).translate((0.1, 0.2, 0.3))

    assert_equal(moved(a - b), moved(a) - moved(b), rays)
    assert_equal(moved(~a | b), ~moved(a) | moved(b), rays)
