"""An edited scene and the scene prepared from the beginning: the same tables to the bit, and the same answers."""

from __future__ import annotations

import itertools

import numpy as np
import pytest

import conicoid as co
from conicoid.kernels.tables import Tables
from conicoid.prepare import lower_shape as parts
from conicoid.prepare.edits import column_splice as columns
from conicoid.prepare.edits.scene_splice import find_runs
from tests.engine.nodes import Nodes

OF_TREES = {"node_boxes", "node_children", "tree_order", "tree_root", "roots", "tree_depth", "leaf_items"}
CUBE = co.Box((0, 0, 0), (1, 1, 1))


def same_tables(a, b):
    """Everything but trees, to the bit."""
    p, q = a._prepared.lowered, b._prepared.lowered
    for name, column in p.tables._asdict().items():
        other = getattr(q.tables, name)
        if name not in OF_TREES:
            assert (column.shape, column.dtype) == (other.shape, other.dtype), name
            assert column.tobytes() == other.tobytes(), name
    for name in ("boxes", "frames", "body_frame", "body_item"):
        assert np.array_equal(getattr(p, name), getattr(q, name), equal_nan=True), name
    for name in ("planes", "spheres", "quadrics", "vertices"):
        assert getattr(p.rest, name).tobytes() == getattr(q.rest, name).tobytes(), name
    assert (p.face_paint, p.body_count) == (q.face_paint, q.body_count)
    assert np.array_equal(p.exact.single, q.exact.single)
    assert a._prepared.key == b._prepared.key


def same_answers(a, b, rng, count=200):
    origins, directions = rng.normal(size=(count, 3)) * 4, rng.normal(size=(count, 3))
    for ask, names in (("first_hit", "t body face surface"), ("crossings", "t body"), ("spans", "t_enter t_exit body")):
        ours, theirs = getattr(a, ask)(origins, directions), getattr(b, ask)(origins, directions)
        for name in names.split():
            assert np.array_equal(getattr(ours, name), getattr(theirs, name)), (ask, name)
    assert np.array_equal(a.body_at(origins), b.body_at(origins))


def some_shape(rng) -> co.Shape:
    """On a coarse grid, so that much coincides: of all kinds that lower in ways of their own."""
    x, y, z = at = tuple(float(v) for v in rng.integers(-2, 3, 3))
    drilled = CUBE - co.Sphere(0.5, (1, 1, 1)).painted(co.matte("red"))
    many = CUBE
    for corner in rng.uniform(0, 1, (14, 3)).tolist():
        many = many - co.Sphere(0.1, corner)
    kinds = [
        lambda: CUBE.translate(at),
        lambda: CUBE.rotate("z", 30).translate(at),
        lambda: co.Sphere(1, at),
        lambda: co.Ellipsoid((1, 1, 1)).translate(at).rotate("z", 30 * float(rng.integers(0, 4))),
        lambda: co.Cylinder(at, (x, y, z + 1), 0.5),
        lambda: drilled.rotate((1, 2, 3), 40).translate(at),
        lambda: many.translate(at),
        lambda: co.Spheres(rng.integers(-2, 3, (5, 3)).astype(float), 1.0),
        lambda: co.Spheres(rng.normal(size=(4, 3)), 0.2).scale((1, 1, 2)),
        lambda: co.Disc(at, (0, 0, 1), 2) - co.Sphere(1, at),
        lambda: co.Polygon([(0, 0, 0), (1, 0, 0), (0, 1, 0)]).rotate("x", 10).translate(at),
        lambda: co.Plane((0, 0, 1), z),
        lambda: co.Cylinder((0, 0, 0), (0, 0, 1), 1) & co.HalfSpace((0, 0, 1), z),
    ]
    return kinds[rng.integers(0, len(kinds))]()


def edit(scene: co.Scene, rng, names) -> co.Scene:
    """One edit: of the first or the last entry in some cases."""
    last = len(scene.bodies) - 1
    name = scene.bodies[int(rng.choice([0, last, rng.integers(0, last + 1)]))].name
    what = rng.integers(0, 4)
    if what == 0:
        new = [co.Body(some_shape(rng), name=next(names)) for _ in range(rng.integers(1, 3))]
        return scene.added(new, before=name if rng.random() < 0.8 else None)
    if what == 1 and last > 3:
        return scene.without(name)
    if what == 2:
        return scene.moved(name, (0, 0, float(rng.integers(-1, 2))))
    return scene.replace(name, some_shape(rng))


def chain(seed: int, bodies: int, edits: int, answers: int) -> int:
    """Edits one after the other, each compared with the scene from the beginning. How many changed what coincides."""
    rng = np.random.default_rng(seed)
    names = map(str, itertools.count())
    scene = co.Scene([co.Body(some_shape(rng), name=next(names)) for _ in range(bodies)])
    scene.prepare()
    merged = []
    for number in range(edits):
        edited = edit(scene, rng, names)
        if rng.random() < 0.3:  # two at once
            edited = edit(edited, rng, names)
        assert edited._previous is scene._prepared
        fresh = co.Scene(edited.bodies)
        same_tables(edited, fresh)
        Nodes(edited).check()
        if number % answers == 0:
            same_answers(edited, fresh, rng)
        ids = edited._prepared.lowered.layout.ids
        merged.append(0 if ids is None else len(ids) - len(np.unique(ids)))
        scene = edited
    return int((np.diff(merged) != 0).sum())


@pytest.mark.parametrize("seed", range(2))
def test_a_chain_of_edits(seed):
    assert chain(seed, 14, 12, 4) > 2


def test_a_chain_of_edits_whose_tree_is_patched():
    chain(7, 280, 10, 5)


@pytest.mark.deep
@pytest.mark.parametrize("seed", range(20))
def test_long_chains_of_edits(seed):
    chain(100 + seed, int(5 + 20 * (seed % 4)), 50, 5)
    chain(200 + seed, 400, 50, 10)


def test_every_table_has_a_rule():
    rules = [
        *columns.PLAIN, *columns.COUNTS, *columns.BEGINS, *columns.SURFACE, *columns.SIDES, *columns.OTHERS,
        *columns.TREES,
    ]  # fmt: skip
    assert sorted(rules) == sorted(Tables._fields)


@pytest.mark.parametrize("motion", [lambda s: s, lambda s: s.rotate((1, 2, 3), 25), lambda s: s.scale((1, 2, 0.7))])
def test_walls_become_one_and_part_again(motion):
    boxes = [motion(CUBE), motion(CUBE.translate((3, 0, 0)))]
    scene = co.Scene([co.Body(boxes[0], name="a"), co.Body(boxes[1], name="b")])
    count = 12 - 4  # both lie between the same y and z
    assert len(scene._prepared.lowered.tables.surface_kind) == count
    flush = scene.replace("b", motion(CUBE.translate((1, 0, 0))))
    assert len(flush._prepared.lowered.tables.surface_kind) == count - 1
    inner = flush.replace("a", motion(CUBE.translate((0, 0.25, 0.25))))
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
