"""Rows of the maps to uv are in the table once for all faces of a body for which a shape makes them once."""

from __future__ import annotations

import pickle

import numpy as np
import pytest

import conicoid as co
from conicoid.geometry.shape import Shape

ROWS = {
    "box": (co.Box((0, 0, 0), (1, 2, 3)), 3),  # x, y and z, each scaled
    "cylinder": (co.Cylinder((0, 0, 0), (0, 0, 1), 2), 5),  # x, y and height of the side; x and y over the radius
    "parallelepiped": (co.Parallelepiped((0, 0, 0), (1, 0, 0), (1, 1, 0), (0, 1, 1)), 3),
    "ball": (co.Sphere(1, (1, 2, 3)), 3),
    "triangle": (co.Triangle((0, 0, 0), (1, 0, 0), (0, 1, 0)), 2),
    "two": (co.Box((0, 0, 0), (1, 2, 3)) - co.Cylinder((0, 0, 0), (0, 0, 1), 2), 8),
}


@pytest.mark.parametrize("moved", [False, True])
@pytest.mark.parametrize("name", ROWS)
def test_as_many_as_the_documented_coordinates_have(name: str, moved: bool) -> None:
    shape, count = ROWS[name]
    tables = co.Scene([shape.rotate((1, 2, 3), 40) if moved else shape])._prepared.lowered.tables
    assert len(tables.map_rows) == count
    rows = np.where(tables.face_maps < 0, -1 - tables.face_maps, tables.face_maps)
    assert set(rows.ravel().tolist()) == set(range(count))
    flat = tables.face_maps[:, 0] >= 0
    assert (rows[flat, 2] == rows[flat, 0]).all()


def test_they_are_rows_of_each_body_in_a_bulk() -> None:
    low = np.random.default_rng(1).uniform(-9, 9, (50, 3))
    tables = co.Scene([co.Boxes(low, low + 1)])._prepared.lowered.tables
    assert len(tables.map_rows) == 3 * 50
    # Row k of a body scales its axis k: (p - low) / 1
    assert (tables.map_rows.reshape(50, 3, 4)[:, :, :3] != 0).sum() == 150


def test_one_object_that_is_used_twice_is_two() -> None:
    """How many there are does not tell whether a shape was made twice, or copied, or is one of many."""
    one, other, box = co.Cylinder((0, 0, 0), (0, 0, 1), 2), co.Cylinder((0, 0, 0), (0, 0, 1), 2), co.Box()
    twice, apart = (one | box) & (one | co.Sphere(2)), (one | box) & (other | co.Sphere(2))
    tables = [co.Scene([shape])._prepared.lowered.tables for shape in (twice, apart, pickle.loads(pickle.dumps(twice)))]
    assert [len(each.map_rows) for each in tables] == [5 + 3 + 5 + 3] * 3
    many = co.Scene([twice.translate((9 * k, 0, 0)) for k in range(40)])
    assert len(many._prepared.lowered.tables.map_rows) == 16 * 40
    edited = many.replace(3, apart)._prepared.lowered.tables
    anew = co.Scene([apart if k == 3 else body.shape for k, body in enumerate(many.bodies)])._prepared.lowered.tables
    assert edited.face_maps.tobytes() == anew.face_maps.tobytes()
    assert edited.map_rows.tobytes() == anew.map_rows.tobytes()


def test_equal_numbers_do_not_make_them_one() -> None:
    """How many there are is told by how a body is built: the radius of a cylinder may be 1."""
    shapes: list[Shape] = [co.Cylinder((0, 0, 0), (0, 0, 1), radius) for radius in (1, 2)]
    one, other = (co.Scene([shape])._prepared.lowered.tables for shape in shapes)
    assert len(one.map_rows) == len(other.map_rows)
