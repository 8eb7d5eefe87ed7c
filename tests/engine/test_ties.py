"""The rules of ties: of two bodies by a formula, of leaves of one body by unit cubes, where a Boolean has one value."""

import math
from itertools import pairwise

import numpy as np
import pytest

import conicoid as co
from conicoid.kernels.body.hit import comes_first, may_tie

from ..samples import sampled


@pytest.mark.parametrize(
    ("first", "other"),
    [((1.0, 5), (2.0, 0)), ((1.0, 0), (1.0, 5)), ((-2.0, 3), (-1.0, 0)), ((1.0, 7), (math.inf, -1))],
)
def test_the_nearer_and_then_the_body_listed_first(first, other):
    assert comes_first(*first, *other)
    assert not comes_first(*other, *first)


@pytest.mark.parametrize("body", [-1, 0, 3])
def test_a_miss_never_comes_first(body):
    assert not comes_first(math.inf, body, math.inf, -1)
    assert not comes_first(math.inf, body, 1e300, 4)


def test_misses_are_never_too_close():
    assert not may_tie(math.inf, 0.0, math.inf, 0.0)
    assert not may_tie(math.inf, 1e-9, 1.0, 1e-9)
    assert may_tie(1.0, 2e-9, 1.0 + 3e-9, 2e-9)


CENTERS = np.arange(-0.5, 5)
GRID = np.stack(np.meshgrid(CENTERS, CENTERS, CENTERS, indexing="ij"))
TURNS = ((), ("z", 45), ("z", 30), ((1, 1, 1), 45), ((1, 2, 3), 30))
_NONE = 1 << 30


def random_tree(rng, depth, faces):
    """Return (operator, parts) of boxes between planes 0, 2 and 4, and the solid; `faces` counts the numbers of faces."""
    if depth == 0 or rng.random() < 0.15:
        low = 2 * rng.integers(0, 2, 3)
        high = np.minimum(low + 2 * rng.integers(1, 3, 3), 4)
        inside = ((low < GRID.T) & (high > GRID.T)).all(axis=-1).T
        faces[0] += 6
        return ("box", faces[0] - 6, inside), co.Box(low, high)
    (a, one), (b, other) = random_tree(rng, depth - 1, faces), random_tree(rng, depth - 1, faces)
    sort = rng.choice(["|", "&", "-"], p=[0.5, 0.3, 0.2])
    if sort == "|":
        return ("or", (a, b), a[2] | b[2]), one | other
    if sort == "&":
        return ("and", (a, b), a[2] & b[2]), one & other
    return ("and", (a, ("not", (b,), ~b[2])), a[2] & ~b[2]), one - other


def face_between(tree, before, after):
    """Return the lowest face of the boxes that turn the tree between two cubes: all operators above them turn, too."""
    sort, parts, inside = tree
    if inside[before] == inside[after]:
        return _NONE
    if sort == "box":
        axis = next(k for k in range(3) if before[k] != after[k])
        higher = inside[max(before, after)]
        return parts + 2 * axis + (0 if higher else 1)
    return min(face_between(part, before, after) for part in parts)


def walls_along(tree, axis, row):
    """Return (face, entering) of each crossing along an axis through the cubes of a row."""
    line = [tuple(np.insert(row, axis, k).tolist()) for k in range(len(CENTERS))]
    return [(face_between(tree, a, b), bool(tree[2][b])) for a, b in pairwise(line) if tree[2][a] != tree[2][b]]


@pytest.mark.parametrize("seed", sampled(range(40), 3))
def test_a_crossing_has_the_face_of_a_leaf_that_turns_the_body(seed):
    """The face is the same on every route, even where walls of several leaves coincide and some are cut away."""
    rng = np.random.default_rng(seed)
    tree, solid = random_tree(rng, int(rng.integers(2, 6)), [0])
    turn = TURNS[seed % len(TURNS)]
    scene = co.Scene([solid.rotate(*turn) if turn else solid])
    rows = [(axis, rng.integers(0, 6, 2)) for axis in range(3) for _ in range(6)]
    d = np.eye(3)[[axis for axis, _ in rows]]
    origins = np.array([np.insert(CENTERS[row], axis, -2.0) for axis, row in rows])
    if turn:  # the rays turn with the body: they go through the middles of cubes
        columns = [co.Scene([co.Plane(e, 0).rotate(*turn)]).first_hit(e, -e).normal for e in np.eye(3)]
        origins, d = origins @ columns, d @ columns
    expected = [walls_along(tree, axis, row) for axis, row in rows]
    found = scene.crossings(origins, d)
    assert [list(zip(one.face, one.entering, strict=True)) for one in (found[i] for i in range(len(rows)))] == expected
    first = np.array([walls[0][0] if walls else -1 for walls in expected])
    last = np.array([walls[-1][0] if walls else -1 for walls in expected])
    order = rng.permutation(len(rows))
    assert (scene.first_hit(np.tile(origins, (64, 1)), np.tile(d, (64, 1))).face == np.tile(first, 64)).all()
    assert (
        scene.first_hit(np.repeat(origins, 64, axis=0), np.repeat(d, 64, axis=0)).face == np.repeat(first, 64)
    ).all()
    assert (scene.first_hit(origins[order], d[order]).face == first[order]).all()
    assert (scene.first_hit(origins + 20 * d, -d).face == last).all()
    for i in np.flatnonzero(first >= 0)[:4].tolist():
        hit, entering = scene.first_hit(origins[i], d[i]), expected[i][0][1]
        assert (hit.face, hit.before, hit.after) == (first[i], -1 if entering else 0, 0 if entering else -1)
        assert ((hit.uv >= 0) & (hit.uv <= 1)).all()
        assert scene.first_hit(hit.spawn(d[i])).face == (expected[i][1][0] if len(expected[i]) > 1 else -1)
        near = scene.distance(hit.point - 0.25 * d[i], exact=True)
        assert near.face == first[i]


def test_two_halves_are_painted_each():
    ball, red, blue = co.Sphere(), co.matte("red"), co.matte("blue")
    half, other = ball & co.HalfSpace((1, 0, 0), 0), ball & co.HalfSpace((-1, 0, 0), 0)
    scene = co.Scene([half.painted(red) | other.painted(blue)])
    hits = scene.first_hit([(-0.5, 0.1, 5), (0.5, 0.1, 5)], (0, 0, -1))
    assert hits.face.tolist() == [0, 2]
    assert scene.distance([(-0.5, 0.1, 1), (0.5, 0.1, 1)], exact=True).face.tolist() == [0, 2]


def test_a_wall_far_from_a_primitive_is_not_its_own():
    rod = co.Cylinder((50, -1, -1), (50, -1, 1), 1, 0, 270, (51, -1, 0))  # one of its flat faces lies in y = -1
    scene = co.Scene([rod | co.Box()])
    hit = scene.first_hit((0.2, -3, 0.3), (0, 1, 0))
    assert hit.face == scene.distance((0.2, -3, 0.3), exact=True).face == 7
    assert hit.uv == pytest.approx([0.6, 0.65], abs=1e-15)
    assert scene.first_hit(np.tile([0.2, -3, 0.3], (256, 1)), (0, 1, 0)).face.tolist() == [7] * 256


def test_walls_in_common_have_one_surface_however_they_are_written():
    """Four bodies have one t, in the order of the list."""
    planes = co.HalfSpace((4, 0, 0), 4), co.Plane((-1, 0, 0), -1), co.Box((1, -1, -1), (2, 1, 1))
    crossings = co.Scene([co.Box(), *planes]).crossings((-5, 0.1, 0.2), (1, 0, 0))
    assert crossings.body[crossings.t == 6].tolist() == [0, 1, 2, 3]
    assert len(set(crossings.surface[crossings.t == 6].tolist())) == 1
