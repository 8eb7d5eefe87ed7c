"""Bounds of pairs of quadrics under motions: they exist, and hold points that are inside for certain."""

from __future__ import annotations

import itertools
import math
from collections.abc import Callable
from typing import Any

import numpy as np
import pytest

import conicoid as co

from .random_pairs import DIGITS, Pair, random_pair

FAST, DEEP = 30, 100_000
SIZE = 1e7
"""No term of a place is larger where the place itself is small."""


def test_a_residue_is_no_height() -> None:
    # Above the bowl z >= 0, on paper and in floats
    low, high = (co.EllipticParaboloid(2, 0.5) & co.DoubleCone(1.5)).scale((1, 2, 0.5)).bounds
    assert low.tolist() == [-math.inf, -math.inf, 0]
    assert (high == math.inf).all()
    bow = co.HyperbolicParaboloid(2, 0.5) & co.DoubleCone(0.5, (0, 2))
    low, high = bow.rotate((1, 2, 3), 15).bounds
    # The apex, where all of it ends
    assert low[2] == 0
    assert np.isfinite([low, high]).all()
    # The same without a turn: z <= 2 and x² + y² <= z² / 4
    np.testing.assert_allclose(bow.bounds, [(-1, -1, 0), (1, 1, 2)], rtol=1e-9)


@pytest.mark.parametrize("residue", [5e-324, 1e-300, 1e-100, 1e-17])
def test_a_plane_beside_the_vertex_costs_no_digits(residue: float) -> None:
    """As a box's side may stand there; the bowl x² + y² <= z, z <= 4 is 2 wide."""
    from conicoid.geometry.bounds.quadric_extent import cut_quadric_bounds
    from conicoid.geometry.surface import PlaneSurface, QuadricSurface

    bowl = QuadricSurface((1.0, 1.0, 0.0), (0.0, 0.0, -0.5), 0.0)
    for end in (residue, -residue):
        planes = [PlaneSurface((0.0, 0.0, -1.0), end), PlaneSurface((0.0, 0.0, 1.0), 4.0)]
        low, high = cut_quadric_bounds(bowl, planes)
        np.testing.assert_allclose([*low, *high], [-2, -2, 0, 2, 2, 4], rtol=1e-12, atol=1e-12)


def exact_bounds(solid: Any) -> Any:
    """The box that `geometry.bounds` finds, in numbers of 3000 bits."""
    return solid.bounds


def prepared_bounds(solid: Any) -> Any:
    """The box that `prepare.csg_plan` finds, in floats."""
    box = co.Scene([solid])._prepared.lowered.boxes[0]
    return box[:3], box[3:]


def check_pairs(seed: int, count: int, bounds: Callable[[Any], Any] = exact_bounds) -> int:
    """How many points were held against bounds."""
    checked = 0
    for k in range(count):
        rng = np.random.default_rng([seed, k])
        pair = random_pair(rng)
        low, high = bounds(pair.solid)
        assert not np.isnan([low, high]).any(), (seed, k)
        for point in extreme_points(pair, rng):
            place = pair.world(point)
            # Turns that are rational together are so to 120 digits here
            slack = max(map(abs, place)) * DIGITS.mpf(10) ** -110 + DIGITS.mpf(10) ** -110 * SIZE
            for i in range(3):
                assert low[i] - slack <= place[i] <= high[i] + slack, (seed, k, point, i)
            checked += 1
    return checked


def extreme_points(pair: Pair, rng: np.random.Generator) -> list[list[float]]:
    """Points that are inside in rational arithmetic, far out along the world's axes."""
    grid = rng.integers(-8, 9, (300, 3)) / 4
    points = np.concatenate([np.zeros((1, 3)), grid, rng.normal(size=(500, 3)) * 10 ** rng.uniform(-1, 1, (500, 1))])
    points = points[pair.seems(points)]
    found = []
    for axis in range(3) if len(points) > 3 else ():
        row = np.array([float(pair.rows[axis, j]) for j in range(3)])
        for direction in (row, -row):
            people = points[np.argsort(-(points @ direction))][:20]
            for _ in range(12):
                others = people[rng.integers(len(people), size=(3, len(people)))]
                tries = others[0] + rng.uniform(0.3, 1.1, (len(people), 1)) * (others[1] - others[2])
                better = pair.seems(tries) & (tries @ direction > people @ direction)
                people = np.where(better[:, None], tries, people)
            found.append(people[np.argmax(people @ direction)].tolist())
    return [point for point in [*found, *points[:3].tolist()] if pair.holds(point)]


def test_bounds_hold_what_is_inside() -> None:
    assert check_pairs(0, FAST) > FAST


@pytest.mark.deep
@pytest.mark.parametrize("bounds", [exact_bounds, prepared_bounds])
@pytest.mark.parametrize("seed", range(1, 11))
def test_bounds_hold_what_is_inside_of_many(seed: int, bounds: Callable[[Any], Any]) -> None:
    assert check_pairs(seed, DEEP // 10, bounds) > DEEP // 10


def test_prepared_bounds_hold_what_is_inside() -> None:
    assert check_pairs(11, FAST, prepared_bounds) > FAST


def test_prepared_bounds_are_as_tight_as_exact_ones() -> None:
    solids = [random_pair(np.random.default_rng([12, k])).solid for k in range(FAST)]
    boxes = co.Scene(solids)._prepared.lowered.boxes
    finite = np.isfinite(boxes).all(axis=1)
    assert finite.sum() > FAST // 2
    for k, solid in enumerate(solids):
        exact, box = np.concatenate(solid.bounds), boxes[k]
        if finite[k]:
            # Infinite exact ends would be as if the box were tighter
            wider, size = np.maximum(exact[:3] - box[:3], box[3:] - exact[3:]), (exact[3:] - exact[:3]).max()
            assert (wider <= 1e-6 * size).all(), k
        # In a scene of many as alone, to the bit
        np.testing.assert_array_equal(box, np.concatenate(prepared_bounds(solid)))


def test_prepared_bounds_of_a_body_as_thin_as_the_rounding_of_its_place():
    """Sixteen steps of a float thick, far from the origin; the point is inside by exact fractions."""
    center = 1024.0
    thick = 8 * math.ulp(center)
    flat, round_, plane = (
        co.Ellipsoid((1, 1, thick), (0, 0, center)), co.Ellipsoid((1.5, 0.5, 2.0), (0, 0.6, center)),
        co.HalfSpace((-20 * thick, 0, 1), center),
    )  # fmt: skip
    for parts in itertools.permutations((flat, round_, plane)):
        low, high = prepared_bounds(co.Intersection(parts))
        assert (low <= (0.9, 0.25, center)).all()
        assert (high >= (0.9, 0.25, center)).all()
