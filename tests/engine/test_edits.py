"""Scenes made from scenes have the tables of scenes from the beginning, to the bit, in any memory."""

import numpy as np
import pytest

import conicoid as co
from conicoid.kernels.tables import PLANE, Tables
from conicoid.prepare import lower_shape as parts
from conicoid.prepare.edits import column_splice as columns, in_place as exchange, scene_edit
from conicoid.prepare.edits.scene_splice import find_runs

from ..samples import in_turn, many, sampled
from .edits import KINDS, UNIT, WORLDS, chain, check_scene, content, note_memory_taken, same_answers, same_tables
from .nodes import Nodes

# --- An edited scene and the scene prepared from the beginning: the same tables to the bit, and the same answers


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


A, B, C, D, E = (co.Body(co.Sphere(radius)) for radius in (1, 2, 3, 4, 5))
OLD, NEW = 0, 1


@pytest.mark.parametrize(("before", "after", "runs", "changed"), [
    ([A, B, C], [A, D, C], [(OLD, 0, 1), (NEW, 0, 1), (OLD, 2, 3)], [1]), ([A, B, C, D], [A, D], [(OLD, 0, 1), (OLD, 3, 4)], []),
    ([A, B, C], [D, A, B, C, E], [(NEW, 0, 1), (OLD, 0, 3), (NEW, 1, 2)], [0, 4]), ([A, A, A], [A, A], [(OLD, 0, 2)], []),
    ([A, B, C, D], [B, E, D], [(OLD, 1, 2), (NEW, 0, 1), (OLD, 3, 4)], [1]), ([], [A], [(NEW, 0, 1)], [0]), ([A], [], [], []),
])  # fmt: skip
def test_equal_runs_are_kept(before, after, runs, changed):
    assert find_runs(before, after) == (runs, changed)


def test_a_body_under_a_motion_of_its_own_is_lowered_as_those_like_it(monkeypatch):
    """Its parts are recorded, and its motion is not. Alone, its five parts took 8 ms."""
    drilled = co.Box() - co.Cylinder((0, 0, -2), (0, 0, 2), 0.5)
    rng = np.random.default_rng(0)
    turned = [drilled.rotate(v, 30).translate(v) for v in rng.normal(size=(300, 3)).tolist()]
    turned += [shape.scale((-2, 2, 2)).rotate((1, 1, 3), 12) for shape in turned]
    scene = co.Scene(turned)
    scene.prepare()
    alone = []
    monkeypatch.setattr(parts, "compute_shape", lambda shape: alone.append(shape))
    edited = scene.moved(3, (1, 2, 3)).moved(3, lambda s: s.rotate((1, 1, 1), 12).scale(0.5)).moved(3, (0.1, 0, 0))
    edited = edited.moved(4, lambda s: s.scale((-2, 2, 2)).rotate((1, 1, 3), 12).rotate("x", 90))
    edited.prepare()
    assert alone == []
    monkeypatch.undo()
    for body in edited.bodies:
        parts.lower_shape(body.shape)  # a scene of these uses the rows that they keep
    same_tables(edited, co.Scene(edited.bodies))


# --- Chains of edits: each scene has the tables of the scene from the beginning, in any memory


@pytest.fixture
def reuses(monkeypatch):
    """Return whether each exchange takes the memory of another scene."""
    return note_memory_taken(monkeypatch)


@pytest.mark.parametrize(("name", "seed"), in_turn(WORLDS, range(2)))
def test_a_chain_of_edits(name, seed, reuses):
    merged = chain(name, seed, 14, 22)
    assert sum(reuses) > 2 or name == "on a grid"
    assert merged > 2 or name == "of all kinds"


@pytest.mark.parametrize(("name", "seed"), sampled([(name, seed) for seed in range(2, 5) for name in KINDS], 4))
def test_a_chain_of_edits_beside_others(name, seed):
    """The scene has floors, planes without an end, and many balls in one entry."""
    chain(name, seed, 14, 22)


@pytest.mark.parametrize("name", sampled(WORLDS[:4], 3))
def test_a_chain_of_edits_whose_tree_is_patched(name):
    chain(name, 7, 8, 280)


def test_a_chain_of_edits_that_write_all_rows(reuses, monkeypatch):
    monkeypatch.setattr(exchange, "_MOST", 0)
    chain("of all kinds", 6, 14, 30)
    assert sum(reuses) > 2


@pytest.mark.deep
@pytest.mark.parametrize("seed", range(10, 14))
@pytest.mark.parametrize("name", WORLDS)
def test_long_chains_of_edits(name, seed):
    chain(name, seed, 60, 20 + 90 * (seed % 4))


# --- Bodies that slide along a common wall, leave it, or come to it: exchanged without another merge of surfaces


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
"""Along the floor, up, along, down to it, to the least anchor of all; onto the others, and down again."""


@pytest.fixture
def exchanges(monkeypatch):
    """Return one entry for each exchange; no edit may merge all surfaces again."""
    monkeypatch.setattr(scene_edit, "SpliceEdit", None)
    return note_memory_taken(monkeypatch)


def named(shapes):
    return co.Scene([co.Body(shape, name=str(number)) for number, shape in enumerate(shapes)])


def steps(shapes, index, motions, turn=lambda s: s):
    """Return scenes, each with one shape moved from the one before, checked, and with rays. All are turned."""
    scene = named([turn(shape) for shape in shapes])
    scene.prepare()
    rng, first, numbers = np.random.default_rng(1), scene, content(scene)
    at = np.zeros(3)
    for motion in motions:
        at = at + motion
        scene = scene.replace(str(index), turn(shapes[index].translate(at.tolist())))
        check_scene(scene)
        same_answers(scene, co.Scene(scene.bodies), rng, 60)
    assert content(first) == numbers


@pytest.mark.parametrize(("index", "turn"), sampled([(index, turn) for index in range(5) for turn in TURNED], 4))
def test_a_box_on_a_floor(turn, index, exchanges):
    """At first the record of one box stands for the floor, and later that of another may."""
    boxes = [co.Box((2 * k, -k, 0), (2 * k + 1, 1 - k, high)) for k, high in enumerate((1, 2, 1, 3, 3))]
    steps([*boxes, co.HalfSpace((0, 0, 1), -1)], index, STEPS, turn)
    assert len(exchanges) == len(STEPS)
    assert sum(exchanges) > 4


def test_a_wall_of_three(exchanges):
    """Two boxes stand on a third, for which the wall faces the other way."""
    shapes = [UNIT, UNIT.translate((3, 0.5, 0)), co.Box((6, 0.25, -1), (7, 2, 0)), co.Sphere(0.5, (9, 9, 9)),
              co.Sphere(0.5, (9, 7, 9)), UNIT.translate((20, 0.125, 7))]  # fmt: skip
    for index in range(3):
        steps(shapes, index, [(0.5, 0.75, 0), (0, 0, 4), (0, 0, -4), (-12, -3, 0), (0, 0, -4)])
    assert len(exchanges) == 15


@pytest.mark.parametrize("index", [0, 1])
def test_a_wall_that_reaches_farther_since_another_came(index, exchanges):
    """A wide box comes to stand beside one that stays, and its record may stand for both. Then others move."""
    turn = TURNED[1]
    two = [co.Box((-3, -3, 5), (30, 40, 6)), co.Box((0, 0, 0), (1, 1, 2)).translate((0, -50 if index else 50, 0))]
    shapes = [*two, *(co.Sphere(1, (k, 0, 9)) for k in range(9))]
    scene, memory = named([turn(shape) for shape in shapes]), []
    scene.prepare()
    for name, up in ((4, 3), (5, 3), (0, -5), (6, 3), (7, 3), (0, 0), (8, 3), (9, 3)):
        scene = scene.replace(str(name), turn(shapes[name].translate((0, 0, up))))
        check_scene(scene)
        memory.append(scene._prepared.lowered.layout.first is None)
    assert memory == [True, True, False, False, False, True, True, True]
    assert exchanges == 8 * [True]


def pin_in_a_block(at):
    pin = co.Cylinder((0.5, 0.5, 0), (0.5, 0.5, 1), 0.25)
    return [(UNIT - pin).translate(at), pin.translate(at)]


@pytest.mark.parametrize(("index", "turn"), sampled([(index, turn) for index in range(4) for turn in TURNED], 4))
def test_a_pin_in_a_block(turn, index):
    """The pin's wall is the bore's, from the other side, and its ends are the block's."""
    shapes = [shape for k in range(3) for shape in pin_in_a_block((1.5 * k, 0.25 * k, 0))]
    steps(shapes, index, [(0, 0, 0.5), (0, 0, -0.5), (0.75, 0, 0), (-0.75, 0, 0.25), (0, 0, -0.25)], turn)


@pytest.mark.parametrize("index", [1, 5])
def test_balls_that_are_one_and_part(index, exchanges):
    """Kernels trace balls without their cell, by the number of their surface.

    After each merge or split all later numbers change.
    """
    ball = co.Sphere(0.5, (1, 1, 1))
    many = co.Spheres([(1, 1, 1), (2, 2, 2), (4, 4, 4)], 0.5)
    shapes = [co.Sphere(0.5, (7, 7, 7)), ball, UNIT - ball, many, co.Sphere(0.5, (5, 5, 5)), ball, UNIT]
    steps(shapes, index, [(1, 1, 1), (1, 1, 1), (1, 1, 1), (1, 1, 1), (-4, -4, -4), (0.5, 0, 0)])
    assert len(exchanges) == 6


def test_walls_whose_records_are_turned_over():
    """A ball, or a tube, stands there by its coefficients and by their negatives. All have the record of one of them."""

    def quadric(sign, **coefficients):
        return co.Quadric(coefficients={name: sign * value for name, value in coefficients.items()})

    ball, tube = dict(xx=1, yy=1, zz=1, constant=-0.25), dict(xx=1, yy=1, constant=-0.25)
    wide, others = co.Box((-1, -2, -3), (1, 2, 3)), [UNIT.translate((7, 7, 7)), UNIT.translate((11, 17, 27))]
    for first in (
        [wide & quadric(1, **tube), wide & quadric(-1, **tube)], [wide - quadric(-1, **ball), co.Sphere(0.5)],
        [quadric(-1, **ball), co.Sphere(0.5)], [~quadric(-1, **ball), quadric(-1, **ball)],
    ):  # fmt: skip
        for shapes in (first, first[::-1]):
            for index in (0, 1):
                steps([*shapes, *others], index, [(3, 0, 0), (0.5, 0, 0), (-3.5, 0, 0), (0, 0, 0.5)])


def test_items_of_leaves_in_a_tree_that_stays(exchanges):
    """Coaxial pins share the wall of one of them, and three balls each are one. The items of leaves show both."""
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
        check_scene(scene)
    assert len(exchanges) == count


def test_walls_that_are_all_in_one_oblique_plane_stay_one():
    """The walls that an edit compares again all lie in one plane, so that only rounding distinguishes them."""
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


def test_walls_of_many_added_bodies_stay_apart_where_floats_do_not_show_it():
    """The scene has 200 boxes, and 40 whose walls across x lie 2^-110 apart."""
    rest = [co.Box((k, -9, -9), (k + 0.5, -8, -8)).rotate((1, 2, 3), 20) for k in range(200)]
    near = [co.Box((1, k, 0), (2, k + 1, 1)).translate((k * 2.0**-110, 0, 0)).rotate((1, 2, 3), 20) for k in range(40)]
    scene = co.Scene(rest)
    scene.prepare()
    edited = scene.added(near)
    check_scene(edited)
    # Across x, y and z; those at x = 1 and x = 2 are in both rows
    assert len(edited._prepared.lowered.tables.surface_kind) == (400 + 2 + 2) + (80 + 41 + 2) - 2


def test_sheets_in_one_oblique_plane_are_one_surface():
    discs = [
        co.Disc((0, 0, 0), (0, 0, 1), 0.3).translate((3.0 * k, 0.7 * k, 0)).rotate((1, 2, 3), 25).translate((7, 8, 9))
        for k in range(5)
    ]
    assert (co.Scene(discs)._prepared.lowered.tables.surface_kind == PLANE).sum() == 1
