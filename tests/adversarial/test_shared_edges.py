"""Two polygons on opposite sides of a common edge, as the ray sees them: a ray through the edge hits exactly one."""

from __future__ import annotations

import math

import numpy as np
import pytest

import conicoid as co

STILL = np.eye(3)


def pair(random, kind, folded):
    """Two polygons on the edge p, q; in one plane, or folded by any dihedral angle. Returns vertices and the edge."""
    scale = 10 ** random.uniform(-2, 2)
    p = random.normal(size=3) * scale * 10 ** random.uniform(-1, 1)
    along = unit(random.normal(size=3))
    q = p + along * scale * random.uniform(0.2, 1)
    across = unit(np.cross(along, random.normal(size=3)))
    up = np.cross(along, across)
    fold = random.uniform(-2.5, 2.5) if folded else 0.0
    other = -(np.cos(fold) * across + np.sin(fold) * up)
    return [vertices(random, kind, p, q, side, scale) for side in (across, other)], p, q, across, up


def unit(v):
    return v / np.linalg.norm(v)


def vertices(random, kind, p, q, side, scale):
    """A triangle, a parallelogram or a concave pentagon on the edge, in the half-plane of `side`, in either order."""
    reach = side * scale * random.uniform(0.3, 1)
    slant = (q - p) * random.uniform(-0.5, 0.5)
    if kind == "triangle":
        points = [p, q, p + reach + slant]
    elif kind == "quadrilateral":
        points = [p, q, q + reach + slant, p + reach + slant]
    else:
        notch = (p + q) / 2 + 0.3 * reach
        points = [p, q, q + reach, notch, p + reach]
    start = random.integers(len(points))
    points = points[start:] + points[:start]
    return points[::-1] if random.random() < 0.5 else points


def rays_through(random, p, q, sides, count):
    """Rays through points of the edge that see the two polygons on opposite sides of it."""
    s = random.uniform(0.02, 0.98, (count, 1))
    points = p + s * (q - p)
    d = random.normal(size=(8 * count, 3))
    turn = [np.cross(q - p, side) for side in sides]
    opposite = (d @ turn[0]) * (d @ turn[1]) < 0
    steep = np.minimum(*(np.abs(d @ unit(t)) for t in turn)) > 1e-3 * np.linalg.norm(d, axis=1)
    d = d[opposite & steep][:count]
    away = 10 ** random.uniform(-1, 3, (len(d), 1)) * np.linalg.norm(q - p)
    d *= away / np.linalg.norm(d, axis=1, keepdims=True)
    return points[: len(d)] - d, d


def check(kind, folded, pairs, rays_per_pair, motion=lambda s: s, rows=STILL):
    random = np.random.default_rng([len(kind), int(folded), pairs])
    total = 0
    for _ in range(pairs):
        both, p, q, *_ = pair(random, kind, folded)
        shapes = [co.Triangle(*v) if kind == "triangle" and random.random() < 0.5 else co.Polygon(v) for v in both]
        sides = [np.mean(vs, axis=0) - p for vs in both]
        o, d = rays_through(random, p, q, sides, rays_per_pair)
        if not len(d):
            continue
        scene = co.Scene([motion(shape) for shape in shapes])
        o, d = o @ rows.T, d @ rows.T
        counts = np.diff(scene.crossings(o, d, t_min=-math.inf).offsets)
        wrong = np.flatnonzero(counts != 1)
        assert len(wrong) == 0, (
            f"{counts[wrong[0]]} hits of {both} by the ray {o[wrong[0]].tolist()}, {d[wrong[0]].tolist()} ({len(wrong)} of {len(o)})"
        )
        hits = scene.first_hit(o, d)
        assert np.isfinite(hits.t).all()
        assert (np.abs(hits.t - 1) < 1e-9).all()
        assert scene.occluded(o, d).all()
        total += len(o)
    return total


CASES = [(kind, folded) for kind in ("triangle", "quadrilateral", "concave") for folded in (False, True)]


@pytest.mark.parametrize(("kind", "folded"), CASES)
def test_exactly_one(kind, folded):
    assert check(kind, folded, pairs=2, rays_per_pair=600) > 500


@pytest.mark.deep
@pytest.mark.parametrize(("kind", "folded"), CASES)
def test_exactly_one_of_many(kind, folded):
    assert check(kind, folded, pairs=20, rays_per_pair=1500) > 20_000


@pytest.mark.parametrize("folded", [False, True])
def test_exactly_one_after_a_motion(folded):
    """Both polygons moved alike keep their common edge."""
    k = np.array([2, -1, 2]) / 3
    c, s = math.cos(math.radians(77)), math.sin(math.radians(77))
    rows = np.array([c * e + s * np.cross(k, e) + (1 - c) * (k @ e) * k for e in np.eye(3)]).T
    assert check("quadrilateral", folded, 6, 600, lambda shape: shape.rotate((2, -1, 2), 77), rows) > 1500


def test_a_lattice_of_squares_is_tight():
    """Rays through the corners and edges of a 3 × 3 tiling, straight on and slanted, hit exactly one square."""
    squares = [
        co.Polygon([(i, j, 0), (i + 1, j, 0), (i + 1, j + 1, 0), (i, j + 1, 0)]) for i in range(3) for j in range(3)
    ]
    halves = [co.Triangle(a, b, c) for i in range(3) for j in range(3) for a, b, c in (
        ((i, j, 0), (i + 1, j, 0), (i + 1, j + 1, 0)), ((i, j, 0), (i + 1, j + 1, 0), (i, j + 1, 0)))]  # fmt: skip
    x, y = (v.ravel() for v in np.meshgrid(np.arange(0.5, 2.75, 0.25), np.arange(0.5, 2.75, 0.25)))
    targets = np.stack([x, y, np.zeros_like(x)], axis=1)
    for shapes in (squares, halves):
        scene = co.Scene(shapes)
        for d in ((0, 0, -1), (0, 0, 1), (1, 0, -1), (0.5, -0.25, 1), (1, 1, -1)):
            assert (np.diff(scene.crossings(targets - 4 * np.array(d), d).offsets) == 1).all()
