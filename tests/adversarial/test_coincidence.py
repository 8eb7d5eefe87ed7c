"""Walls in common: one surface however it was written, ties, and what is in the leaves of Booleans."""

from __future__ import annotations

import math
from functools import reduce

import numpy as np
import pytest

import conicoid as co

BALL, BLOCK, ROD = co.Sphere(1), co.Box(), co.Cylinder((0, 0, -2), (0, 0, 2), 1)


def rays(count=2000, seed=1):
    random = np.random.default_rng(seed)
    targets, d = random.uniform(-1.2, 1.2, (count, 3)), random.normal(size=(count, 3))
    return targets - 5 * d, d


def assert_never_hit(shape):
    o, d = rays()
    scene = co.Scene([shape])
    assert len(scene.crossings(o, d, t_min=-math.inf).t) == 0
    assert not scene.occluded(o, d).any()
    assert not scene.contains(o + 5 * d).any()


def assert_alike(a, b):
    o, d = rays()
    here, there = co.Scene([a]).spans(o, d, t_min=-math.inf), co.Scene([b]).spans(o, d, t_min=-math.inf)
    assert np.array_equal(here.offsets, there.offsets)
    assert np.array_equal(here.t_enter, there.t_enter)
    assert np.array_equal(here.t_exit, there.t_exit)


SAME = {
    "sphere as a quadric": (BALL, co.Quadric(coefficients=dict(xx=1, yy=1, zz=1, constant=-1))),
    "a quadric times three": (BALL, co.Quadric(matrix=np.diag([3.0, 3.0, 3.0, -3.0]))),
    "sphere as an ellipsoid": (co.Sphere(2), co.Ellipsoid((2, 2, 2))),
    "sphere scaled": (co.Sphere(2), BALL.scale(2)),
    "ellipsoid as a stretched sphere": (co.Ellipsoid((2, 4, 0.5)), BALL.scale((2, 4, 0.5))),
    "moved there and back": (BALL, BALL.translate((0.1, 0.2, 0.3)).translate((-0.1, -0.2, -0.3))),
    "turned there and back": (BLOCK, BLOCK.rotate((1, 2, 3), 33.3).rotate((1, 2, 3), -33.3)),
    "twelve turns by 30 degrees": (BLOCK, reduce(lambda shape, _: shape.rotate((1, 1, 0), 30), range(12), BLOCK)),
    "turned by 90 degrees": (BLOCK, BLOCK.rotate((0, 0, 1), 90)),
    "mirrored": (ROD, ROD.scale((1, 1, -1))),
    "a box of half-spaces": (BLOCK, co.Polyhedron([(2, 0, 0), (-1, 0, 0), (0, 3, 0), (0, -1, 0), (0, 0, 1), (0, 0, -0.5)], [2, 1, 3, 1, 1, 0.5])),
    "cylinder and elliptic cylinder": (ROD, co.EllipticCylinder(1, 1, (-2, 2))),
    "cone and double cone": (co.Cone((0, 0, 0), (0, 0, 2), 0, 2), co.DoubleCone(1, (0, 2))),
    "cone upside down": (co.Cone((0, 0, 0), (0, 0, 2), 2, 1), co.Cone((0, 0, 2), (0, 0, 0), 1, 2)),
}  # fmt: skip


@pytest.mark.parametrize("name", SAME)
def test_one_surface_however_it_was_written(name):
    """The difference is empty both ways, union and intersection are the shape itself, to the bit."""
    a, b = SAME[name]
    assert_never_hit(a - b)
    assert_never_hit(b - a)
    assert_alike(a | b, a)
    assert_alike(a & b, a)


def test_walls_in_common_have_one_surface_id():
    o, d = rays()
    scene = co.Scene([BLOCK, co.HalfSpace((4, 0, 0), 4), co.Plane((-1, 0, 0), -1), co.Box((1, -1, -1), (2, 1, 1))])
    crossings = scene.crossings(o, d, t_min=-math.inf)
    points = np.repeat(o, np.diff(crossings.offsets), axis=0) + crossings.t[:, None] * np.repeat(
        d, np.diff(crossings.offsets), axis=0
    )
    on_wall = (np.abs(points[:, 0] - 1) < 1e-12) & (np.abs(points[:, 1:]) < 0.99).all(axis=1)
    assert len(set(crossings.surface[on_wall].tolist())) == 1
    assert set(crossings.body[on_wall].tolist()) == {0, 1, 2, 3}
    # four bodies at one t, in the order of listing
    t = crossings.t[on_wall].reshape(-1, 4)
    assert (t == t[:, :1]).all()
    assert (crossings.body[on_wall].reshape(-1, 4) == [0, 1, 2, 3]).all()


def test_ties_go_to_the_body_listed_first():
    o, d = rays()
    for first, second in ((BALL, co.Quadric(matrix=np.diag([2.0, 2, 2, -2]))), (BLOCK, co.Plane((1, 0, 0), 1))):
        for bodies, index in (([first, second], 0), ([second, first], 0)):
            hits = co.Scene(bodies).first_hit(o, d)
            both = co.Scene(bodies).crossings(o, d)
            for i in np.flatnonzero(np.isfinite(hits.t)):
                of = slice(both.offsets[i], both.offsets[i + 1])
                assert hits.body[i] == both.body[of][both.t[of] == hits.t[i]].min()
            assert (hits.body == index).any()


def test_body_at_takes_the_first_listed():
    scene = co.Scene([co.Sphere(1, (5, 0, 0)), BLOCK, co.Sphere(3), BALL])
    assert scene.body_at([(0, 0, 0), (1, 1, 1), (2, 0, 0), (5, 0, 0), (9, 9, 9)]).tolist() == [1, 1, 2, 0, -1]
    assert scene.contains([(0, 0, 0), (9, 9, 9)]).tolist() == [True, False]


def test_contains_is_closed_on_leaves_and_exactly_boolean():
    points = np.array([(1, 0, 0), (0, 1, 0), (1, 1, 1), (-1, 0, 0), (0, 0, -1)])
    for shape, inside in ((BALL, [1, 1, 0, 1, 1]), (BLOCK, [1, 1, 1, 1, 1]), (ROD, [1, 1, 0, 1, 1])):
        assert co.Scene([shape]).contains(points).tolist() == [bool(x) for x in inside]
        assert co.Scene([~shape]).contains(points).tolist() == [not x for x in inside]
        assert co.Scene([BLOCK - shape]).contains(points).tolist() == [not x for x in inside]
