"""One numbering: numbers of `hits.body`, `body_at`, spans and lengths index names, materials and bodies."""

from fractions import Fraction

import numpy as np
import pytest

import conicoid as co
from conicoid.cli.report import list_bodies, totals
from conicoid.geometry.instances import ShiftTable

RED, GREEN = co.matte("red"), co.matte("green")
CENTERS = [(0.0, 0.0, 0.0), (3.0, 0.0, 0.0), (6.0, 0.0, 0.0)]
SCENE = co.Scene(
    [
        co.Spheres(np.zeros((0, 3)), 1),
        co.Body(co.Sphere(1, (-3, 0, 0)), GREEN, "first"),
        co.Body(co.Spheres(CENTERS, [1, 0.5, 0.25]), RED, "balls"),
        co.Body(co.Box((8, -1, -1), (9, 1, 1)), name="box"),
    ]
)
NAMES = ["first", "balls", "balls", "balls", "box", None]
MATERIALS = [GREEN, RED, RED, RED, None, None]
ORIGINS = np.array([(-3, 0, 5), *(np.array(CENTERS) + (0, 0, 5)), (8.5, 0, 5), (20, 0, 5)])
DOWN = (0, 0, -1)


def test_names_and_materials_are_those_of_the_body_that_was_hit():
    hits = SCENE.first_hit(ORIGINS, DOWN)
    assert hits.body.tolist() == [0, 1, 2, 3, 4, -1]
    assert hits.name.tolist() == NAMES
    assert hits.material.tolist() == MATERIALS
    square = SCENE.first_hit(ORIGINS.reshape(2, 3, 3), DOWN)
    assert square.name.shape == square.material.shape == (2, 3)
    assert square.name.ravel().tolist() == NAMES


def test_one_hit_has_one_name():
    for origin, name, material in zip(ORIGINS, NAMES, MATERIALS, strict=True):
        hit = SCENE.first_hit(origin, DOWN)
        assert hit.name == name
        assert hit.material == material


def test_no_hits_have_no_names():
    none = co.Scene([]).first_hit(np.zeros((0, 3)), DOWN)
    assert none.name.shape == none.material.shape == (0,)
    assert co.Scene([]).first_hit((0, 0, 0), DOWN).name is None


def test_spans_and_crossings_have_the_same_names():
    origin, along = (-9, 0, 0), (1, 0, 0)
    assert SCENE.spans(origin, along).name.tolist() == NAMES[:-1]
    assert SCENE.spans(origin, along).material.tolist() == MATERIALS[:-1]
    assert SCENE.crossings(origin, along).name.tolist() == [name for name in NAMES[:-1] for _ in range(2)]


def test_bodies_by_number():
    for number, (name, material) in enumerate(zip(NAMES[:-1], MATERIALS[:-1], strict=True)):
        for body in (SCENE.body(number), SCENE[number], SCENE.body(np.int32(number))):
            assert (body.name, body.material) == (name, material)
    assert SCENE.body(SCENE.body_at((6, 0, 0.2))).shape == co.Sphere(0.25, (6, 0, 0))
    assert [body.name for body in SCENE[1:]] == NAMES[1:-1]
    assert [body.name for body in SCENE] == NAMES[:-1]


def test_a_ball_of_moved_balls_is_where_it_was_hit():
    moved = co.Scene([co.Spheres(CENTERS, [1, 0.5, 0.25]).rotate((1, 2, 3), 40).scale((1, 2, 3)).translate((1, 1, 1))])
    for number in range(3):
        low, high = moved.body(number).shape.bounds
        middle = (low + high) / 2
        assert moved.body_at(middle) == number
        alone = co.Scene([moved.body(number)])
        hit, same = moved.first_hit(middle, (1, 2, 3)), alone.first_hit(middle, (1, 2, 3))
        assert hit.body == number
        assert abs(hit.t - same.t) <= 4 * (hit.t_error + same.t_error) + 1e-14


BEYOND, NO_NUMBER = "body: number must be at least 0 and below 5", "body: number must be one integer, got"


@pytest.mark.parametrize("query", [SCENE.body, SCENE.__getitem__])
@pytest.mark.parametrize(("number", "error", "message"), [
    *((number, IndexError, BEYOND) for number in (-1, -2, 5, 10**30, np.int32(-1))),
    (SCENE.first_hit((20, 0, 5), DOWN).body, IndexError, "got -1$"),
    *((number, TypeError, NO_NUMBER) for number in (1.0, None, True, np.array([1, 2]), [1])),
])  # fmt: skip
def test_invalid_body_numbers_are_refused(query, number, error, message):
    with pytest.raises(error, match=message if query == SCENE.body or error is IndexError else "Scene: index must be"):
        query(number)


def test_all_count_alike():
    assert SCENE.body_count == 5
    assert SCENE.spans((-9, 0, 0), (1, 0, 0)).lengths().tolist() == [2.0, 2.0, 1.0, 0.5, 1.0]
    assert repr(SCENE) == "Scene(5 bodies in 4 entries, 0 lights)"
    assert repr(co.Scene([co.Sphere()])) == "Scene(1 body, 0 lights)"
    assert totals(SCENE)[0] == "bodies    5"
    assert [line.split()[0] for line in list_bodies(SCENE)[1:]] == ["none", "0", "1-3", "4"]
    with pytest.raises(ValueError, match=r"\(5,\)"):
        SCENE.spans((-9, 0, 0), (1, 0, 0)).line_integral([1, 2, 3, 4])


def test_no_body_has_no_measures():
    found = co.measure(co.Scene([co.Sphere(), co.Sphere(2)]))
    assert found[1] == found.bodies[1]
    for number in (-1, 2):
        with pytest.raises(IndexError, match="must be at least 0 and below 2"):
            found[number]


def test_a_part_of_a_table_of_shifts_holds_no_values_of_others():
    # Bounds of a kind cost as many exact differences as the table has values
    table = ShiftTable(tuple(tuple(Fraction(k) for k in range(100)) for _ in range(3)), np.tile(np.arange(100), (3, 1)))
    part = table.select(np.array([7, 3, 7]))
    assert part.values == ((3, 7),) * 3
    assert part.offsets_from(1).tolist() == [[4, 4, 4], [0, 0, 0], [4, 4, 4]]
