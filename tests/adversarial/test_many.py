"""Many bodies: the tree loses none of them, and rays in common walls belong to one side."""

from __future__ import annotations

import numpy as np

import conicoid as co


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
