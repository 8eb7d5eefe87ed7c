"""An edited scene and the scene prepared from the beginning: the same tables to the bit, and the same answers."""

from __future__ import annotations

import numpy as np
import pytest

import conicoid as co
from conicoid.kernels.tables import Tables
from conicoid.prepare import lower_shape as parts
from conicoid.prepare.edits import column_splice as columns
from conicoid.prepare.edits.scene_splice import find_runs

from .edits import UNIT, same_answers, same_tables
from .nodes import Nodes


def test_every_table_has_a_rule():
    rules = [
        *columns.PLAIN, *columns.COUNTS, *columns.BEGINS, *columns.SURFACE, *columns.SIDES, *columns.OTHERS,
        *columns.TREES,
    ]  # fmt: skip
    assert sorted(rules) == sorted(Tables._fields)


@pytest.mark.parametrize("motion", [lambda s: s, lambda s: s.rotate((1, 2, 3), 25), lambda s: s.scale((1, 2, 0.7))])
def test_walls_become_one_and_part_again(motion):
    boxes = [motion(UNIT), motion(UNIT.translate((3, 0, 0)))]
    scene = co.Scene([co.Body(boxes[0], name="a"), co.Body(boxes[1], name="b")])
    count = 12 - 4  # both lie between the same y and z
    assert len(scene._prepared.lowered.tables.surface_kind) == count
    flush = scene.replace("b", motion(UNIT.translate((1, 0, 0))))
    assert len(flush._prepared.lowered.tables.surface_kind) == count - 1
    inner = flush.replace("a", motion(UNIT.translate((0, 0.25, 0.25))))
    assert len(inner._prepared.lowered.tables.surface_kind) == 11
    for edited in (flush, inner, inner.replace("a", boxes[0]), flush.replace("b", boxes[1])):
        same_tables(edited, co.Scene(edited.bodies))
        same_answers(edited, co.Scene(edited.bodies), np.random.default_rng(0))


def test_a_ball_becomes_that_of_many_and_back():
    balls = co.Spheres([(0, 0, 0), (3, 0, 0)], [1, 1])
    scene = co.Scene([co.Body(co.Ellipsoid((1, 1, 1)).rotate("x", 20), name="round"), balls])
    assert len(scene._prepared.lowered.tables.surface_kind) == 2
    away = scene.moved("round", (0, 0, 5))
    assert len(away._prepared.lowered.tables.surface_kind) == 3
    onto = away.replace("round", co.Ellipsoid((1, 1, 1)).rotate("y", 20).translate((3, 0, 0)))
    alone = onto.without("round").added(co.Sphere(1, (3, 0, 0)), before=None)
    for edited in (away, onto, alone):
        same_tables(edited, co.Scene(edited.bodies))
    assert len(onto._prepared.lowered.tables.surface_kind) == len(alone._prepared.lowered.tables.surface_kind) == 2


def test_a_tree_is_built_anew_after_many_edits(monkeypatch):
    rng = np.random.default_rng(0)
    scene = co.Scene([co.Sphere(0.3, at) for at in rng.uniform(-9, 9, (400, 3)).tolist()])
    scene.prepare()
    loose = []
    for number in range(45):
        scene = scene.moved(number, (0.1, 0, 0))
        loose.append(len(scene._prepared.woods.loose))
        Nodes(scene).check()
    assert loose == [*range(1, 21), 0, *range(1, 21), 0, 1, 2, 3]  # up to the square root of 400
    for _ in range(30):
        scene = scene.moved(5, (0.1, 0, 0))
    scene.prepare()
    assert len(scene._prepared.woods.loose) == 4


def test_what_runs_are_kept():
    a, b, c, d, e = (co.Body(co.Sphere(radius)) for radius in (1, 2, 3, 4, 5))
    old, new = 0, 1
    assert find_runs([a, b, c], [a, d, c]) == ([(old, 0, 1), (new, 0, 1), (old, 2, 3)], [1])
    assert find_runs([a, b, c], [d, a, b, c, e]) == ([(new, 0, 1), (old, 0, 3), (new, 1, 2)], [0, 4])
    assert find_runs([a, b, c, d], [a, d]) == ([(old, 0, 1), (old, 3, 4)], [])
    assert find_runs([a, b, c, d], [b, e, d]) == ([(old, 1, 2), (new, 0, 1), (old, 3, 4)], [1])
    assert find_runs([a, a, a], [a, a]) == ([(old, 0, 2)], [])
    assert find_runs([], [a]) == ([(new, 0, 1)], [0])
    assert find_runs([a], []) == ([], [])


def test_a_body_under_a_motion_of_its_own_is_lowered_as_those_like_it(monkeypatch):
    """Its parts are recorded, its motion is not: 8 ms for five parts, if it were worked out alone."""
    drilled = co.Box() - co.Cylinder((0, 0, -2), (0, 0, 2), 0.5)
    rng = np.random.default_rng(0)
    scene = co.Scene([drilled.rotate(v, 30).translate(v) for v in rng.normal(size=(20, 3)).tolist()])
    scene.prepare()
    alone = []
    monkeypatch.setattr(parts, "compute_shape", lambda shape: alone.append(shape))
    edited = scene.moved(3, (1, 2, 3)).moved(3, lambda s: s.rotate((1, 1, 1), 12).scale(0.5)).moved(3, (0.1, 0, 0))
    edited = edited.moved(4, lambda s: s.scale((-2, 2, 2)).rotate((1, 1, 3), 12).rotate("x", 90))
    edited.prepare()
    assert alone == []
    monkeypatch.undo()
    for body in edited.bodies:
        parts.lower_shape(body.shape)  # a scene of these takes what is kept with them
    same_tables(edited, co.Scene(edited.bodies))
