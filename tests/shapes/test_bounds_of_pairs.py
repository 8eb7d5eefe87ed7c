"""Bounds of pairs of quadrics under motions: they exist, and hold points that are inside for certain."""

from __future__ import annotations

import itertools
import math
from collections.abc import Callable
from typing import Any

import numpy as np
import pytest

import conicoid as co

from ..reference.forms import PAIRS, chain
from ..reference.items import Item, combined
from ..reference.numbers import number
from ..reference.quadratics import Table
from ..reference.random_shapes import Random, generator, pick
from ..reference.solids import bodies
from ..reference.trace import body_at, truth
from ..reference.whole_items import SOLIDS, motion, plain, whole_motion
from .motions import climb

FAST, DEEP = 30, 120


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


def random_pair(r: Random) -> Item:
    """Two shapes, the second moved against the first, and the part of the one that is in the other, or is not."""
    parts = [plain(r, str(pick(r, SOLIDS))) for _ in range(2)]
    return combined(
        str(pick(r, ("Intersection", "Intersection", "Difference"))), parts[0], parts[1].moved(*whole_motion(r))
    )


def check_pairs(seed: int, count: int, bounds: Callable[[Any], Any] = exact_bounds) -> int:
    """How many points were held against bounds."""
    checked = 0
    for k in range(count):
        r = generator(f"pairs {seed}", k)
        pair = random_pair(r)
        moved = pair.moved(*motion(r))
        low, high = bounds(moved.shape(co))
        assert not np.isnan([low, high]).any(), moved
        there = chain(moved.exact_steps)
        for point in extreme_points(pair, there, r):
            for x, least, most in zip(there.point(point), low.tolist(), high.tolist(), strict=True):
                assert least == -math.inf or (x - number(least)).sign >= 0, (moved, point)
                assert most == math.inf or (number(most) - x).sign >= 0, (moved, point)
            checked += 1
    return checked


def extreme_points(pair: Item, there: Any, r: Random) -> list[list[float]]:
    """Points that are inside in exact arithmetic, far out along the world's axes."""
    table = Table(bodies([pair]))

    def seems(points: np.ndarray) -> np.ndarray:
        """Inside in floats."""
        whole = np.concatenate([points, np.ones((len(points), 1))], axis=1).T
        products = np.array([whole[i] * whole[j] for i, j in PAIRS])
        return truth(
            table.bodies[0].formula,
            lambda forms: np.all([np.array([*map(float, form.k)]) @ products <= 0 for form in forms], axis=0),
        )

    grid = r.integers(-8, 9, (300, 3)) / 4
    points = np.concatenate([np.zeros((1, 3)), grid, r.normal(size=(500, 3)) * 10 ** r.uniform(-1, 1, (500, 1))])
    points = points[seems(points)]
    found = points[:3].tolist()
    for row in there.rows if len(points) > 3 else ():
        for direction in np.array([*map(float, row)]) * [[1], [-1]]:
            found.append(climb(seems, direction, points, r, 12, 20).tolist())
    inside = body_at(table, np.array(found)) if found else ()
    return [point for point, body in zip(found, inside, strict=True) if body == 0]


def test_bounds_hold_what_is_inside() -> None:
    assert check_pairs(0, FAST) > FAST


@pytest.mark.deep
@pytest.mark.parametrize("bounds", [exact_bounds, prepared_bounds])
@pytest.mark.parametrize("seed", range(1, 11))
def test_bounds_hold_what_is_inside_of_many(seed: int, bounds: Callable[[Any], Any]) -> None:
    assert check_pairs(seed, DEEP, bounds) > DEEP


def test_prepared_bounds_hold_what_is_inside() -> None:
    assert check_pairs(11, FAST, prepared_bounds) > FAST


def test_prepared_bounds_are_as_tight_as_exact_ones() -> None:
    drawn = [generator("pairs 12", k) for k in range(FAST)]
    solids = [random_pair(r).moved(*motion(r)).shape(co) for r in drawn]
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
