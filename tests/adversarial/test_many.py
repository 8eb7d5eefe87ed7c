"""Many bodies: the tree loses none of them, and rays in common walls belong to one side."""

from __future__ import annotations

import math

import numpy as np
import pytest

import conicoid as co

from ..samples import sampled


def all_roots(centers, radii, origins, directions):
    """(rays, balls) smaller and larger root in extended precision, NaN for a miss."""
    f = origins[:, None].astype(np.longdouble) - centers
    d = directions.astype(np.longdouble)
    a = np.sum(d * d, axis=1)[:, None]
    b = np.einsum("ijk,ik->ij", f, d)
    foot = f - (b / a)[..., None] * d[:, None]
    with np.errstate(invalid="ignore"):
        half = np.sqrt((radii**2 - np.sum(foot * foot, axis=2)) / a)
    return -b / a - half, -b / a + half


@pytest.mark.parametrize("scale", sampled([1e-6, 1.0, 1e6], 3))
def test_balls_against_all_pairs(scale):
    """2000 balls of sizes over three decades and 500 rays: ids, t and counts, with the tree against none."""
    random = np.random.default_rng(11)
    centers, radii = random.uniform(-10, 10, (2000, 3)), 10 ** random.uniform(-2, 0.3, 2000)
    centers, radii = centers * scale, radii * scale
    origins, directions = random.uniform(-20, 20, (500, 3)) * scale, random.normal(size=(500, 3))
    near, far = all_roots(centers, radii, origins, directions)
    for items in ([co.Spheres(centers, radii)], [co.Sphere(r, c) for r, c in zip(radii, centers, strict=True)]):
        scene = co.Scene(items)
        spans = scene.spans(origins, directions, t_min=-math.inf)
        assert np.array_equal(np.diff(spans.offsets), np.isfinite(near).sum(axis=1))
        ahead = np.where(near > 0, near, np.where(far > 0, far, np.inf))
        ahead = np.where(np.isnan(ahead), np.inf, ahead)
        hits = scene.first_hit(origins, directions)
        hit = np.isfinite(hits.t)
        assert np.array_equal(hit, np.isfinite(ahead.min(axis=1)))
        assert np.array_equal(hits.body[hit], ahead.argmin(axis=1)[hit])
        speed = np.linalg.norm(directions, axis=1)
        assert (np.abs(hits.t[hit] - ahead.min(axis=1)[hit]) * speed[hit] <= 1e-12 * (20 * scale)).all()
        assert np.array_equal(scene.occluded(origins, directions), hit)
        inside = (np.linalg.norm(origins[:, None] - centers, axis=2) <= radii).argmax(axis=1)
        contained = (np.linalg.norm(origins[:, None] - centers, axis=2) <= radii).any(axis=1)
        assert np.array_equal(scene.body_at(origins), np.where(contained, inside, -1))


def mixed(count, seed):
    """Small shapes of many kinds strewn about, some of them unbounded."""
    random = np.random.default_rng(seed)
    kinds = [
        lambda: co.Sphere(0.5), lambda: co.Box((-0.4, -0.3, -0.5), (0.3, 0.5, 0.2)), lambda: co.Cylinder((0, 0, -0.5), (0, 0, 0.5), 0.3),
        lambda: co.Cone((0, 0, 0), (0, 0, 1), 0.5, 0.1), lambda: co.EllipticParaboloid(2, 1, (0, 0.7)), lambda: co.OneSheetHyperboloid(9, 9, 4, (-0.5, 0.5)),
        lambda: co.Sphere(0.5) - co.Box((0, 0, 0), (1, 1, 1)), lambda: co.Polygon([(0, 0, 0), (0.9, 0, 0), (0.2, 0.2, 0), (0, 0.9, 0)]),
        lambda: co.Disc((0, 0, 0), (1, 1, 1), 0.5), lambda: co.Triangle((0, 0, 0), (1, 0, 0), (0, 1, 0)), lambda: co.TwoSheetHyperboloid(4, 4, 9, (-0.8, 0.8)),
    ]  # fmt: skip
    shapes = []
    for i in range(count):
        axis, place = random.normal(size=3), random.uniform(-6, 6, 3)
        shapes.append(kinds[i % len(kinds)]().rotate(axis, random.uniform(0, 360)).translate(place))
    return [
        *shapes,
        co.Plane((0, 0, 1), -7),
        co.HalfSpace((0, 1, 0.2), -8),
        co.EllipticCylinder(4, 4).translate((1, 1, 0)),
    ]


def test_a_crowd_is_the_union_of_its_members():
    """A scene of 200 bodies answers what its members answer one by one."""
    shapes = mixed(200, 12)
    random = np.random.default_rng(13)
    origins, directions = random.uniform(-9, 9, (600, 3)), random.normal(size=(600, 3))
    whole = co.Scene(shapes)
    alone = [co.Scene([shape]) for shape in shapes]
    t = np.array([scene.first_hit(origins, directions).t for scene in alone])
    hits = whole.first_hit(origins, directions)
    assert np.array_equal(hits.t, t.min(axis=0))
    hit = np.isfinite(hits.t)
    assert np.array_equal(hits.body[hit], t.argmin(axis=0)[hit])
    counts = np.array([np.diff(scene.crossings(origins, directions).offsets) for scene in alone])
    assert np.array_equal(np.diff(whole.crossings(origins, directions).offsets), counts.sum(axis=0))
    lengths = whole.spans(origins, directions, t_min=-50, t_max=50).lengths()
    one_by_one = np.stack([s.spans(origins, directions, t_min=-50, t_max=50).lengths()[:, 0] for s in alone], axis=1)
    assert np.array_equal(lengths, one_by_one)
    contained = np.array([scene.contains(origins) for scene in alone])
    assert np.array_equal(whole.body_at(origins), np.where(contained.any(axis=0), contained.argmax(axis=0), -1))


@pytest.mark.parametrize(
    "motion",
    [lambda s: s, lambda s: s.rotate((0, 0, 1), 90), lambda s: s.translate((0, 0.25, 8))],
    ids=["still", "turned", "moved"],
)
def test_a_ray_in_a_common_wall_is_in_one_of_the_two(motion):
    """As if the wall were moved along its normal: exactly one of two abutting boxes is crossed, twice, whichever way the ray goes."""
    left, right = motion(co.Box((-1, -1, -1), (0, 1, 1))), motion(co.Box((0, -1, -1), (1, 1, 1)))
    wall = motion(co.Disc((0, 0, 0), (1, 0, 0), 1))
    random = np.random.default_rng(14)
    flat = np.stack([np.zeros(300), *random.normal(size=(2, 300))], axis=1)
    flat /= np.linalg.norm(flat, axis=1, keepdims=True)
    center = np.mean(wall.bounds, axis=0)
    along = (
        np.stack([-flat[:, 1], flat[:, 0], flat[:, 2]], axis=1)
        if np.ptp(np.asarray(wall.bounds)[:, 1]) < 1e-9
        else flat
    )
    for directions in (along, -along):
        origins = center - 8 * directions
        for pair in ([left, right], [right, left]):
            crossings = co.Scene(pair).crossings(origins, directions)
            assert (np.diff(crossings.offsets) == 2).all()
            assert (crossings.body.reshape(-1, 2)[:, 0] == crossings.body.reshape(-1, 2)[:, 1]).all()
        assert (np.diff(co.Scene([left | right]).crossings(origins, directions).offsets) == 2).all()
        assert len(co.Scene([left & right]).crossings(origins, directions).t) == 0
