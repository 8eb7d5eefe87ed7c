"""Bodies that slide along a wall which others have too, leave it, or come to it: exchanged, and not merged anew.

Each edited scene has the tables of the scene from the beginning, to the bit, and what the next edit is told of them.
"""

from __future__ import annotations

import numpy as np
import pytest

import conicoid as co
from conicoid.kernels.tables import PLANE
from conicoid.prepare.edits import scene_edit as edited

from ..samples import many, sampled
from .edits import UNIT, checked, content, note_memory_taken, same_answers

TURNED = [lambda s: s, lambda s: s.rotate((1, 2, 3), 25), lambda s: s.scale((1, 2, 0.7)).rotate("x", 10)]
STEPS = [
    (0.25, 0.5, 0),
    (-0.125, 0.25, 0),
    (0, 0, 0.25),
    (0, 0.0625, 0),
    (0, 0, -0.25),
    (-4, -4, 0),
    (0, 0, 3),
    (0, 0, -3),
]
"""Along the floor, up, along, down to it, to where the least anchor of all is; onto the others, and down again."""


@pytest.fixture
def exchanged(monkeypatch):
    """One for each exchange; no edit may be merged as a whole."""
    monkeypatch.setattr(edited, "SpliceEdit", None)
    return note_memory_taken(monkeypatch)


def named(shapes):
    return co.Scene([co.Body(shape, name=str(number)) for number, shape in enumerate(shapes)])


def steps(shapes, which, motions, turn=lambda s: s):
    """Scenes in which a shape has been moved, one from another, each checked; and as asked by rays. All are turned."""
    scene = named([turn(shape) for shape in shapes])
    scene.prepare()
    rng, first, numbers = np.random.default_rng(1), scene, content(scene)
    at = np.zeros(3)
    for motion in motions:
        at = at + motion
        scene = scene.replace(str(which), turn(shapes[which].translate(at.tolist())))
        checked(scene)
        same_answers(scene, co.Scene(scene.bodies), rng, 60)
    assert content(first) == numbers


@pytest.mark.parametrize(("which", "turn"), sampled([(which, turn) for which in range(5) for turn in TURNED], 4))
def test_a_box_on_a_floor(turn, which, exchanged):
    """One of them has the record that stands for the floor at first, and others may afterwards."""
    boxes = [co.Box((2 * k, -k, 0), (2 * k + 1, 1 - k, high)) for k, high in enumerate((1, 2, 1, 3, 3))]
    steps([*boxes, co.HalfSpace((0, 0, 1), -1)], which, STEPS, turn)
    assert len(exchanged) == len(STEPS)
    assert sum(exchanged) > 4


def test_a_wall_of_three(exchanged):
    """Two boxes that stand on a third, which sees the wall from the other side."""
    shapes = [UNIT, UNIT.translate((3, 0.5, 0)), co.Box((6, 0.25, -1), (7, 2, 0)), co.Sphere(0.5, (9, 9, 9)),
              co.Sphere(0.5, (9, 7, 9)), UNIT.translate((20, 0.125, 7))]  # fmt: skip
    for which in range(3):
        steps(shapes, which, [(0.5, 0.75, 0), (0, 0, 4), (0, 0, -4), (-12, -3, 0), (0, 0, -4)])
    assert len(exchanged) == 15


@pytest.mark.parametrize("which", [0, 1])
def test_a_wall_that_reaches_farther_since_another_came(which, exchanged):
    """A wide box comes to stand beside one that stays, and whose record may stand for both; then others move."""
    turn = TURNED[1]
    two = [co.Box((-3, -3, 5), (30, 40, 6)), co.Box((0, 0, 0), (1, 1, 2)).translate((0, -50 if which else 50, 0))]
    shapes = [*two, *(co.Sphere(1, (k, 0, 9)) for k in range(9))]
    scene, memory = named([turn(shape) for shape in shapes]), []
    scene.prepare()
    for name, up in ((4, 3), (5, 3), (0, -5), (6, 3), (7, 3), (0, 0), (8, 3), (9, 3)):
        scene = scene.replace(str(name), turn(shapes[name].translate((0, 0, up))))
        checked(scene)
        memory.append(scene._prepared.lowered.layout.first is None)
    assert memory == [True, True, False, False, False, True, True, True]
    assert exchanged == 8 * [True]


def pin_in_a_block(at):
    pin = co.Cylinder((0.5, 0.5, 0), (0.5, 0.5, 1), 0.25)
    return [(UNIT - pin).translate(at), pin.translate(at)]


@pytest.mark.parametrize(("which", "turn"), sampled([(which, turn) for which in range(4) for turn in TURNED], 4))
def test_a_pin_in_a_block(turn, which):
    """Its wall is the bore's, seen from the other side; its ends are the block's."""
    shapes = [shape for k in range(3) for shape in pin_in_a_block((1.5 * k, 0.25 * k, 0))]
    steps(shapes, which, [(0, 0, 0.5), (0, 0, -0.5), (0.75, 0, 0), (-0.75, 0, 0.25), (0, 0, -0.25)], turn)


@pytest.mark.parametrize("which", [1, 5])
def test_balls_that_are_one_and_part(which, exchanged):
    """Balls are traced without their cell, by the number of their surface: each number behind is another."""
    ball = co.Sphere(0.5, (1, 1, 1))
    many = co.Spheres([(1, 1, 1), (2, 2, 2), (4, 4, 4)], 0.5)
    shapes = [co.Sphere(0.5, (7, 7, 7)), ball, UNIT - ball, many, co.Sphere(0.5, (5, 5, 5)), ball, UNIT]
    steps(shapes, which, [(1, 1, 1), (1, 1, 1), (1, 1, 1), (1, 1, 1), (-4, -4, -4), (0.5, 0, 0)])
    assert len(exchanged) == 6


def test_walls_whose_records_are_turned_over():
    """A ball, or a tube, by its coefficients and by their negatives; all have the record of one of them."""

    def quadric(sign, **coefficients):
        return co.Quadric(coefficients={name: sign * value for name, value in coefficients.items()})

    ball, tube = dict(xx=1, yy=1, zz=1, constant=-0.25), dict(xx=1, yy=1, constant=-0.25)
    wide, others = co.Box((-1, -2, -3), (1, 2, 3)), [UNIT.translate((7, 7, 7)), UNIT.translate((11, 17, 27))]
    for first in (
        [wide & quadric(1, **tube), wide & quadric(-1, **tube)], [wide - quadric(-1, **ball), co.Sphere(0.5)],
        [quadric(-1, **ball), co.Sphere(0.5)], [~quadric(-1, **ball), quadric(-1, **ball)],
    ):  # fmt: skip
        for shapes in (first, first[::-1]):
            for which in (0, 1):
                steps([*shapes, *others], which, [(3, 0, 0), (0.5, 0, 0), (-3.5, 0, 0), (0, 0, 0.5)])


def test_items_of_leaves_in_a_tree_that_stays(exchanged):
    """Coaxial pins have the wall of one of them, and balls are one in threes: leaves tell of both."""
    rng, count = np.random.default_rng(7), many(8, 24)
    shapes = []
    for number in range(300):
        at, low = (2.0 * (number // 6 % 10), 2.0 * (number // 60), 0.0), float(rng.uniform(0, 4))
        if number % 3 == 2:
            shapes.append(co.Sphere(0.5, (at[0] + 1, at[1], 0)))
        else:
            shapes.append(co.Cylinder((*at[:2], low), (*at[:2], low + float(rng.uniform(0.5, 1))), 0.25))
    scene = named([TURNED[1](shape) for shape in shapes])
    scene.prepare()
    for number in rng.permutation(300)[:count].tolist():
        step = (0.0, 0.0, float(rng.uniform(-1, 1))) if number % 3 < 2 else (0.0, 0.5, 0.0)
        scene = scene.replace(str(number), TURNED[1](shapes[number].translate(step)))
        checked(scene)
    assert len(exchanged) == count


def test_a_wall_that_stays_goes_from_one_wall_of_a_body_to_the_other():
    """The plane x = 1 is the high side of what is moved, and then its low side: the same records lead before and after."""
    moved, stays = co.Body(co.Box((0, 0, 0), (1, 1, 1)), name="moved"), co.Body(co.Box((1, 2, 2), (4, 3, 3)))
    scene = co.Scene([moved, stays])
    scene.first_hit((-5, 0, 0), (1, 0, 0))
    scene = scene.moved("moved", (1, 0, 0))
    assert scene.first_hit((-5, 2.5, 2.5), (1, 0, 0)).t == 6.0
    assert scene.contains((1.5, 2.5, 2.5))
    anew = co.Scene(list(scene.bodies))
    for name, table, other in zip(
        scene._prepared.lowered.tables._fields,
        scene._prepared.lowered.tables,
        anew._prepared.lowered.tables,
        strict=True,
    ):
        if name in ("cell_quadric", "plane_surface", "plane_face", "surface_kind", "surface_row", "planes"):
            assert table.tobytes() == other.tobytes(), name


def test_walls_that_are_all_in_one_oblique_plane_stay_one():
    """Of what is looked at again all is in one plane, so that rounding alone tells these walls from one another."""
    for number in range(6):
        low = np.random.default_rng(number).integers(-4, 4, (4, 2)) + 0.1 * np.arange(4)[:, None]
        boxes = [co.Box((0, *low[k]), (k + 1.3, *(low[k] + 1))).rotate((1, 2, 3), 25) for k in range(4)]
        balls = [co.Sphere(0.2, (9 + k, 9, 9)) for k in range(4)]
        scene = co.Scene([*(co.Body(box, name=str(k)) for k, box in enumerate(boxes)), *balls])
        scene.prepare()
        for k in range(4):
            edited = scene.without(str(k))
            assert len(edited._prepared.lowered.tables.surface_kind) == len(
                co.Scene(edited.bodies)._prepared.lowered.tables.surface_kind
            )


def test_sheets_in_one_oblique_plane_are_one_surface():
    discs = [
        co.Disc((0, 0, 0), (0, 0, 1), 0.3).translate((3.0 * k, 0.7 * k, 0)).rotate((1, 2, 3), 25).translate((7, 8, 9))
        for k in range(5)
    ]
    assert (co.Scene(discs)._prepared.lowered.tables.surface_kind == PLANE).sum() == 1
