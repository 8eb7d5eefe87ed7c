"""Walls in common: one surface however it was written, and Boolean trees full of coincident faces in exact arithmetic."""

from __future__ import annotations

import itertools
import math
from fractions import Fraction
from functools import reduce

import numpy as np
import pytest
from hypothesis import given, settings, strategies as st

import conicoid as co

from ..samples import size

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


# Trees over boxes of integer corners: every face coincides with others. Rays of random floats tie only there.

boxes = st.tuples(*[st.tuples(st.integers(-2, 2), st.integers(1, 3)) for _ in range(3)]).map(
    lambda spans: ("box", tuple(a for a, _ in spans), tuple(a + n for a, n in spans))
)
trees = st.recursive(
    boxes,
    lambda parts: st.one_of(
        st.tuples(st.sampled_from(["or", "and", "minus"]), parts, parts), st.tuples(st.just("not"), parts)
    ),
    max_leaves=7,
)


def shape_of(tree):
    if tree[0] == "box":
        return co.Box(*tree[1:])
    parts = [shape_of(part) for part in tree[1:]]
    return {"or": lambda a, b: a | b, "and": lambda a, b: a & b, "minus": lambda a, b: a - b, "not": lambda a: ~a}[
        tree[0]
    ](*parts)


def walls_of(tree):
    if tree[0] == "box":
        return {(i, c) for corner in tree[1:] for i, c in enumerate(corner)}
    return set().union(*(walls_of(part) for part in tree[1:]))


def holds(tree, point):
    if tree[0] == "box":
        return all(a <= x <= b for a, x, b in zip(tree[1], point, tree[2], strict=True))
    parts = [holds(part, point) for part in tree[1:]]
    return {"or": any, "and": all, "minus": lambda v: v[0] and not v[1], "not": lambda v: not v[0]}[tree[0]](parts)


def exact_spans(tree, origin, direction):
    """Spans of the whole line in fractions: the formula between consecutive walls, merged."""
    o, d = [Fraction(x) for x in origin], [Fraction(x) for x in direction]
    times = sorted({(c - o[i]) / d[i] for i, c in walls_of(tree)})
    middles = [times[0] - 1, *((a + b) / 2 for a, b in itertools.pairwise(times)), times[-1] + 1]
    inside = [holds(tree, [x + m * v for x, v in zip(o, d, strict=True)]) for m in middles]
    ends = [
        -math.inf,
        *(t for t, before, after in zip(times, inside, inside[1:], strict=False) if before != after),
        math.inf,
    ]
    if not inside[0]:
        ends = ends[1:]
    if not inside[-1]:
        ends = ends[:-1]
    return list(zip(ends[::2], ends[1::2], strict=True))


@settings(max_examples=size(60, 200), deadline=None, derandomize=True)
@given(tree=trees, seed=st.integers(0, 10**6))
def test_trees_of_coincident_boxes(tree, seed):
    random = np.random.default_rng(seed)
    origins, directions = random.uniform(-3, 4, (5, 3)), random.normal(size=(5, 3))
    scene = co.Scene([shape_of(tree)])
    spans = scene.spans(origins, directions, t_min=-math.inf)
    assert scene.contains(origins).tolist() == [holds(tree, o) for o in origins.tolist()]
    for i in range(5):
        of = slice(spans.offsets[i], spans.offsets[i + 1])
        expected = exact_spans(tree, origins[i], directions[i])
        assert spans.offsets[i + 1] - spans.offsets[i] == len(expected)
        for (low, high), enter, leave in zip(expected, spans.t_enter[of], spans.t_exit[of], strict=True):
            assert enter == pytest.approx(float(low), rel=1e-13, abs=1e-14)
            assert leave == pytest.approx(float(high), rel=1e-13, abs=1e-14)
    lattice = random.integers(-3, 5, (20, 3))
    assert scene.contains(lattice).tolist() == [holds(tree, p) for p in lattice.tolist()]
