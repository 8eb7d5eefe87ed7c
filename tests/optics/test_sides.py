"""hits.before and hits.after: which body a ray is in on both sides of a wall."""

import numpy as np
import pytest

import conicoid as co

from ..samples import size
from .exact_sides import sides, wall_of_ball, wall_of_box


def leaf(rng):
    """A box of even integers, or a ball around an even point; many share walls, touch, and hold one another."""
    if rng.random() < 0.6:
        low = 2 * rng.integers(-4, 4, 3)
        return ("box", low.tolist(), (low + 2 * rng.integers(1, 5, 3)).tolist())
    return ("ball", (2 * rng.integers(-3, 4, 3)).tolist(), int(rng.integers(1, 7)) ** 2)


def shape(body):
    if body[0] == "box":
        return co.Box(*body[1:])
    if body[0] == "ball":
        return co.Sphere(body[2] ** 0.5, body[1])
    a, b = shape(body[1]), shape(body[2])
    return a | b if body[0] == "or" else a & b if body[0] == "and" else a - b


def random_scene(rng):
    """(bodies of the oracle, which are transparent, scene)"""
    bodies = []
    for _ in range(int(rng.integers(3, 9))):
        kind = rng.choice(["leaf", "leaf", "or", "and", "less"])
        bodies.append(leaf(rng) if kind == "leaf" else (str(kind), leaf(rng), leaf(rng)))
    clear = (rng.random(len(bodies)) < 0.8).tolist()
    looks = [co.glass(1.5) if one else co.matte("red") for one in clear]
    return bodies, clear, co.Scene([co.Body(shape(b), look) for b, look in zip(bodies, looks, strict=True)])


def integer_rays(rng, count):
    """Origins of odd integers, so that none is on a wall of a box; directions of small ones, some along axes."""
    o, d = 2 * rng.integers(-10, 10, (count, 3)) + 1, rng.integers(-6, 7, (count, 3))
    d[(d == 0).all(axis=1)] = (0, 0, 1)
    return o, d


def walls(bodies, hits, o, d):
    """Which leaf and which of its walls each hit is on, as [(rows, Place)]."""
    found, normal, centre = [], hits.normal, hits.point
    for number, body in enumerate(bodies):
        leaves = [body] if body[0] in ("box", "ball") else list(body[1:])
        first = 0
        for one in leaves:
            faces = 6 if one[0] == "box" else 1
            rows = np.flatnonzero((hits.body == number) & (hits.face >= first) & (hits.face < first + faces))
            first += faces
            if not len(rows):
                continue
            if one[0] == "box":
                axis = np.argmax(abs(normal[rows]), axis=1)
                at = centre[rows, axis]
                high = abs(at - np.array(one[2])[axis]) < abs(at - np.array(one[1])[axis])
                found.append((rows, wall_of_box(one[1:], axis, high, o[rows], d[rows])))
            else:
                outward = ((centre[rows] - np.array(one[1])) * d[rows]).sum(1)
                found.append((rows, wall_of_ball(one[1:], outward < 0, o[rows], d[rows])))
    return found


def compare(seed, count):
    """All walls along random rays of a random scene; returns how many hits were compared, all of them equal."""
    rng = np.random.default_rng(seed)
    bodies, clear, scene = random_scene(rng)
    o, d = integer_rays(rng, count)
    t_min, done = np.zeros(count), 0
    while len(o):
        hits = scene.first_hit(o, d, t_min=t_min)
        some = hits.hit
        hits, o, d = hits[some], o[some], d[some]
        t_min = hits.t
        seen = np.zeros(len(o), int)
        for rows, place in walls(bodies, hits, o, d):
            before, after = sides(bodies, clear, o[rows], d[rows], place)
            seen[rows] += 1
            same = (hits.before[rows] == before) & (hits.after[rows] == after)
            bad = rows[~same]
            told = [(o[i].tolist(), d[i].tolist(), float(hits.t[i]), int(hits.body[i])) for i in bad[:3]]
            got = [(int(hits.before[i]), int(hits.after[i])) for i in bad[:3]]
            want = list(zip(before[~same][:3].tolist(), after[~same][:3].tolist(), strict=True))
            assert not len(bad), f"seed {seed}: {len(bad)} of {len(rows)}: {told} got {got}, exact {want}; {bodies}"
        assert (seen == 1).all()
        done += len(o)
    return done


def test_both_sides_of_every_wall_against_whole_numbers():
    assert sum(compare(seed, 300) for seed in range(size(20, 40))) > 1000


SOLIDS = [
    co.Cone((0, 0, -1), (0, 0, 2), 1, 0.3), co.Cylinder((0, 0, -1), (1, 0, 1), 0.7), co.DoubleCone(0.8, (-1, 1)),
    co.OneSheetHyperboloid(2, 3, 1, (-1, 1)), co.TwoSheetHyperboloid(1, 1, 9, (-1, 1)), co.Ellipsoid((1, 2, 0.5)),
    co.EllipticParaboloid(1, 2, (0, 1.5)), co.Box() - co.Sphere(1.2), co.Sphere() | co.Sphere(1, (1, 0, 0)),
    co.Cylinder((0, 0, -1), (0, 0, 1), 1, 20, 300, (1, 0, 0)), co.HalfSpace((0, 0.1, 1), -1.5), ~co.Sphere(6),
]  # fmt: skip


@pytest.mark.parametrize("look", [None, co.glass(1.4)])
def test_between_two_walls_a_ray_is_in_one_body(look):
    """After each wall, and before the next one, it is in the body that holds the point midway."""
    rng = np.random.default_rng(7)
    for _ in range(5):
        bodies = [
            co.Body(SOLIDS[k].rotate(rng.normal(size=3), 360 * rng.random()).translate(rng.normal(0, 0.7, 3)), look)
            for k in rng.permutation(len(SOLIDS))
        ]
        scene = co.Scene(bodies)
        walls = scene.crossings(rng.uniform(-3, 3, (200, 3)), rng.normal(size=(200, 3)))
        ray = np.repeat(np.arange(200), np.diff(walls.offsets))
        one = np.flatnonzero((np.diff(ray) == 0) & (np.diff(walls.t) > 1e-9))
        origins, directions = walls.rays
        middle = origins[ray[one]] + ((walls.t[one] + walls.t[one + 1]) / 2)[:, None] * directions[ray[one]]
        there = scene.body_at(middle)
        assert len(one) > 300
        assert (walls.after[one] == there).all()
        assert (walls.before[one + 1] == there).all()
        hits = scene.first_hit(walls.rays)
        first = walls.offsets[:-1][hits.hit]
        assert (hits.before[hits.hit] == walls.before[first]).all()
        assert (hits.after[hits.hit] == walls.after[first]).all()


def test_spawned_rays_go_on_in_the_body_that_they_came_into():
    shapes = co.Box((-1, -1, 0), (1, 1, 1)), co.Box((-1, -1, 1), (1, 1, 2)), co.Sphere(0.5, (0, 0, 1)), co.Sphere(4)
    scene = co.Scene([co.Body(shape, co.glass(1.5)) for shape in shapes])
    rng = np.random.default_rng(5)
    hits = scene.first_hit(rng.uniform(-9, 9, (2000, 3)), rng.normal(size=(2000, 3)))
    for _ in range(5):
        hits = hits[hits.hit]
        goes = scene.first_hit(hits.spawn(hits.rays.directions))
        assert (goes.before[goes.hit] == hits.after[goes.hit]).all()
        assert (hits.after[~goes.hit] == -1).all()
        hits = goes


def test_a_transparent_body_counts_before_an_opaque_one():
    room, ball = co.Body(co.Box((-5, -5, -5), (5, 5, 5)), "white"), co.Body(co.Sphere(), co.glass())
    core, pane = co.Body(co.Sphere(0.5), "red"), co.Body(co.Disc((0, 0, 3), (0, 0, 1), 1), co.glass())
    scene = co.Scene([room, core, ball, pane])
    hits = scene.first_hit([(0, 0, 4), (0, 0, 2), (0, 0, 0.9), (9, 9, 9)], (0, 0, -1))
    assert hits.body.tolist() == [3, 2, 1, -1]
    assert hits.before.tolist() == [0, 0, 2, -1]
    assert hits.after.tolist() == [0, 2, 2, -1]
    assert (int(hits[1].before), int(hits[1].after)) == (0, 2)
    kept = hits.detached()
    assert kept == hits
    assert (kept[1:].after == hits.after[1:]).all()
    walls = scene.crossings([(0, 0, 4), (9, 9, 9)], (0, 0, -1))
    assert walls.before.tolist() == [0, 0, 2, 2, 2, 0]
    assert (walls.detached()[0].after == walls.after[:6]).all()


@pytest.mark.deep
def test_both_sides_of_a_million_walls_against_whole_numbers():
    done, seed = 0, 1000
    while done < 1_000_000:
        done += compare(seed, 4000)
        seed += 1
