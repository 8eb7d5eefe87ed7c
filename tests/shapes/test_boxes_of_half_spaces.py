"""Boxes that preparing finds in floats around half-spaces: against corners in fractions, and never inside of them."""

from __future__ import annotations

import itertools
import math
from fractions import Fraction
from typing import Any

import numpy as np
import pytest

import conicoid as co
from conicoid.prepare import batch_lowering

Point = tuple[Fraction, Fraction, Fraction]
CELL = [(1, 1, 1), (-1, -1, 1), (-1, 1, -1), (1, -1, -1)]
"""The normals of a tetrahedron."""


def corners(planes: list[tuple[Any, Any]]) -> list[Point]:
    """The points common to three planes (normal, offset) that no other plane cuts off, by Cramer's rule."""
    rows = [tuple(map(Fraction, (*normal, offset))) for normal, offset in planes]
    found = []
    for a, b, c in itertools.combinations(rows, 3):
        unit = _determinant(a[:3], b[:3], c[:3])
        if not unit:
            continue
        columns = list(zip(a, b, c, strict=True))
        point = [_determinant(*(columns[3] if k == i else columns[k] for k in range(3))) / unit for i in range(3)]
        if all(sum(n * x for n, x in zip(row[:3], point, strict=True)) <= row[3] for row in rows):
            found.append((point[0], point[1], point[2]))
    return found


def _determinant(a: Any, b: Any, c: Any) -> Fraction:
    return sum(
        (a[i] * (b[i - 2] * c[i - 1] - b[i - 1] * c[i - 2]) for i in range(3)),
        Fraction(0),
    )


def random_cell(rng: np.random.Generator, count: int) -> list[tuple[Any, Any]]:
    """A tetrahedron that further planes cut; some have whole numbers, so that several meet in a point."""
    normals = np.concatenate([np.array(CELL) + 0.3 * rng.normal(size=(4, 3)), rng.normal(size=(count, 3))])
    if rng.random() < 0.5:
        normals = np.round(2 * normals) / 2
    center, offsets = 10.0 ** rng.integers(-1, 4) * rng.normal(size=3), rng.uniform(0.2, 2, len(normals))
    planes = []
    for normal, offset in zip(normals.tolist(), offsets.tolist(), strict=True):
        if any(normal):
            planes.append((tuple(normal), float(np.dot(normal, center) + offset)))
    return planes


@pytest.mark.parametrize("count", [0, 1, 3, 6])
def test_boxes_hold_all_corners_tightly(count, monkeypatch) -> None:
    """Both where all bodies are of one plan, and for each alone; floats decide nearly all."""
    rng = np.random.default_rng(count)
    cells = [random_cell(rng, count) for _ in range(12)]
    left: list[Any] = []
    exact = batch_lowering._exact_bounds
    monkeypatch.setattr(
        batch_lowering, "_exact_bounds", lambda bodies, parts: left.extend(bodies) or exact(bodies, parts)
    )
    solids = [co.Intersection(tuple(co.HalfSpace(*plane) for plane in planes)) for planes in cells]
    together = co.Scene(solids)._prepared.lowered.boxes
    for planes, solid, box in zip(cells, solids, together, strict=True):
        points = corners(planes)
        ends = [max(sign * point[k] for point in points) for sign in (-1, 1) for k in range(3)]
        alone = co.Scene([solid.translate((0.0, 0.0, 0.0))])._prepared.lowered.boxes[0]
        for found in (box, alone):
            size = max(map(abs, found.tolist())) * 1e-14 + (found[3:] - found[:3]).max() * 1e-8
            for end, value in zip(ends, [*(-found[:3]).tolist(), *found[3:].tolist()], strict=True):
                assert 0 <= Fraction(value) - end <= size
    assert len(left) <= 3


def test_parallel_planes_bound_nothing_across() -> None:
    sides = [(1.0, 0.5, 0.0), (-1.0, -0.5, 0.0), (0.5, -1.0, 0.0), (-0.5, 1.0, 0.0)]
    prism = co.Intersection(tuple(co.HalfSpace(side, 1.0) for side in sides))
    box = co.Scene([prism])._prepared.lowered.boxes[0]
    assert box[[2, 5]].tolist() == [-math.inf, math.inf]
    assert box[3] == pytest.approx(1.5 / 1.25)
    assert box[4] == pytest.approx(1.5 / 1.25)


def test_an_endless_cylinder_between_slanted_planes() -> None:
    """|x|, |y| <= 2; z between -1 + x / 2 and 1 - y / 4, so from -2 to 1.5; a second cell is empty."""
    rod = co.Quadric(coefficients={"xx": 1.0, "yy": 1.0, "constant": -4.0})
    above = co.HalfSpace((0.5, 0.0, -1.0), 1.0)
    for offset, expected in ((1.0, (-2, -2, -2, 2, 2, 1.5)), (-9.0, None)):
        box = co.Scene([rod & above & co.HalfSpace((0.0, 0.25, 1.0), offset)])._prepared.lowered.boxes[0]
        if expected is None:
            assert (box[:3] > box[3:]).any()
        else:
            np.testing.assert_allclose(box, expected, rtol=1e-8)
            assert (box[:3] <= expected[:3]).all()
            assert (box[3:] >= expected[3:]).all()
