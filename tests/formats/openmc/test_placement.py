"""Turns, rotations and placements, against plain matrices."""

from __future__ import annotations

import itertools
from fractions import Fraction

import numpy as np
import pytest

from conicoid._util.arrays import FloatArray
from conicoid.io.openmc.placement import (
    AxisTurn,
    CellRotation,
    Extent,
    Point,
    UniversePlacement,
    rotation_by_angles,
    rotation_by_matrix,
    rotation_error,
    to_floats,
)

from .evaluator import rotation_matrix


def point(*numbers: float) -> Point:
    x, y, z = (Fraction(n) for n in numbers)
    return x, y, z


def carried(rotation: CellRotation, p: Point) -> FloatArray:
    """Where a rotation takes a point."""
    if rotation.motion.is_identity:
        return np.array(to_floats(rotation.turn.apply(p)))
    return rotation.motion.matrix[:3] @ [*to_floats(p), 1.0]


@pytest.mark.parametrize(
    "angles", [*itertools.product((-90, 0, 90, 180), repeat=3), (10, 20, 30), (0, 0, -7.5), (90, 0, 33), (400, 720, 90)]
)
def test_angles_turn_the_contents_so_that_the_lookup_turns_back(angles: tuple[float, ...]) -> None:
    rotation = rotation_by_angles(point(*angles))
    p = point(0.25, -1.5, 2.0)
    assert rotation_matrix(list(angles)) @ carried(rotation, p) == pytest.approx(to_floats(p), abs=1e-15 * 20)


@pytest.mark.parametrize("angles", list(itertools.product((0, 90, 180, 270), repeat=3)))
def test_right_angles_are_exact_also_as_a_matrix(angles: tuple[float, ...]) -> None:
    rotation = rotation_by_angles(point(*angles))
    assert rotation.motion.is_identity
    rows = np.rint(rotation_matrix(list(angles))).astype(int).tolist()
    assert rotation_by_matrix(tuple(point(*row) for row in rows)) == rotation


def test_a_turn_about_z_takes_x_to_y() -> None:
    assert rotation_by_angles(point(0, 0, 90)).turn.apply(point(1, 0, 0)) == point(0, 1, 0)


def test_matrices_are_inverted() -> None:
    rows = [[0.8, 0.6, 0.0], [-0.6, 0.8, 0.0], [0.0, 0.0, 1.0]]
    rotation = rotation_by_matrix(tuple(point(*row) for row in rows))
    assert rotation is not None
    assert np.array(rows) @ carried(rotation, point(1, 2, 3)) == pytest.approx([1, 2, 3], abs=1e-15 * 8)
    assert rotation_by_matrix((point(1, 0, 0), point(2, 0, 0), point(0, 0, 1))) is None
    assert rotation_error(tuple(point(*row) for row in rows)) < 1e-15
    assert rotation_error((point(1, 0, 0), point(0, 1.01, 0), point(0, 0, 1))) == pytest.approx(0.0201)


def test_turns_are_a_group() -> None:
    turns = [rotation_by_angles(point(*angles)).turn for angles in itertools.product((0, 90, 180, 270), repeat=3)]
    assert len(set(turns)) == 24
    p = point(1, 2, 4)
    for a, b in itertools.product(set(turns), repeat=2):
        assert a.after(b).apply(p) == a.apply(b.apply(p))
        assert a.inverse.apply(a.apply(p)) == p
        assert tuple(sum(r * v for r, v in zip(row, p, strict=True)) for row in a.rows) == a.apply(p)


def test_placements_nest_like_matrices() -> None:
    """Outer first: translation (1, 2, 3); then a turn and a shift; a rotation and a shift; a shift."""
    steps = [
        (point(1, 2, 3), CellRotation()),
        (point(0.5, 0, -1), rotation_by_angles(point(90, 0, 180))),
        (point(0, 0.25, 0), rotation_by_angles(point(10, 20, 30))),
        (point(-2, 1, 0.5), rotation_by_angles(point(0, 0, 90))),
    ]
    place, p = UniversePlacement(), point(0.3, 0.7, -0.2)
    for shift, rotation in steps:
        place = place.inner(shift, rotation)
    expected = np.array(to_floats(p))
    for shift, rotation in reversed(steps):
        expected = carried(rotation, point(*expected)) + to_floats(shift)
    found = place.outer.matrix[:3] @ [*to_floats(place.point(p)), 1.0]
    assert found == pytest.approx(expected, abs=1e-14)
    assert place.back.point(place.point(p)) == p


def test_extents_move_with_their_corners() -> None:
    box = Extent(point(-1, 2, 3), (Fraction(4), None, Fraction(5)))
    place = UniversePlacement(AxisTurn((2, 0, 1), (-1, 1, 1)), point(10, 20, 30))
    assert box.placed(place) == Extent((Fraction(5), Fraction(19), Fraction(32)), (Fraction(7), Fraction(24), None))
    assert box.placed(place).placed(place.back) == box
