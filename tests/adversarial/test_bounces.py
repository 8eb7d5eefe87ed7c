"""A thousand bounces inside closed bodies: never out, never stuck; abutting bodies share their wall."""

from __future__ import annotations

import numpy as np
import pytest

import conicoid as co

from ..samples import sampled

N, BOUNCES = 60, 1000
DRIFT = BOUNCES * 4 * 2.0**-53
"""What a point may leave its wall by: four roundings a bounce."""


def start(random, middle=(0, 0, 0)):
    d = random.normal(size=(N, 3))
    return np.asarray(middle) + random.uniform(-0.3, 0.3, (N, 3)), d / np.linalg.norm(d, axis=1, keepdims=True)


def bounce(scene, origins, directions, check):
    rays = co.Rays(origins, directions)
    previous = None
    for step in range(BOUNCES):
        hits = scene.first_hit(rays)
        assert np.isfinite(hits.t).all(), f"{np.isinf(hits.t).sum()} rays escape at bounce {step}"
        assert not hits.entering.any()
        assert (hits.t > 0).all()
        check(hits, previous)
        directions = co.reflect(rays.directions, hits.normal)
        previous, rays = hits, hits.spawn(directions)


def test_grazing_inside_a_sphere():
    """Whispering gallery: chords of 1e-6 of the radius, a thousand of them.

    A hit point is up to e = 2^-52 beside the sphere, and the ray that starts there is traced as it stands: its chord
    changes by e / sin(1e-6), a ten-thousandth of it, every time. A thousand such steps at random add up to 1e-2.
    """

    def check(hits, previous):
        if previous is not None:
            chord = hits.t * np.linalg.norm(hits.rays.directions, axis=1)
            assert np.abs(chord / 2e-6 - 1).max() < 1e-2

    angle = np.linspace(0, 2 * np.pi, N, endpoint=False)
    origins = np.stack([np.cos(angle), np.sin(angle), 0 * angle], axis=1) * np.sqrt(1 - 1e-12)
    bounce(co.Scene([co.Sphere()]), origins, np.stack([-np.sin(angle), np.cos(angle), 0 * angle], axis=1), check)


BODIES = {
    "ball": co.Sphere(2),
    "box": co.Box((-1, -2, -1.5), (1, 2, 1.5)).rotate((1, 2, 3), 40).translate((0.1, 0.1, 0.1)),
    "cylinder": co.Cylinder((0, 0, -1.5), (0, 0, 1.5), 1),
    "frustum": co.Cone((0, 0, -1), (0, 0, 1), 1, 0.5),
    "barrel": co.Ellipsoid((1, 2, 3), z_range=(-1, 2)),
    "octahedron": co.Polyhedron([(x, y, z) for x in (-1, 1) for y in (-1, 1) for z in (-1, 1)], [2] * 8),
    "rounded box": co.Sphere(1.5) & co.Box(),
    "two balls": co.Sphere(1) | co.Sphere(1, (1, 0, 0)),
    "cooling tower": co.OneSheetHyperboloid(1, 1, 1, (-1, 1)),
}


FLAT = {"box": range(6), "cylinder": (1, 2), "frustum": (1, 2), "octahedron": range(8)}
"""Faces that no ray meets twice running."""


@pytest.mark.parametrize("name", sampled(BODIES, 3))
def test_never_out_and_never_twice_on_a_flat_face(name):
    def check(hits, previous):
        assert previous is None or not (np.isin(hits.face, FLAT.get(name, ())) & (hits.face == previous.face)).any()

    bounce(co.Scene([BODIES[name]]), *start(np.random.default_rng(4)), check)


def test_abutting_boxes_share_their_wall():
    """One t, one surface id; a ray that goes on from the wall does not meet it again, from either body."""
    scene = co.Scene([co.Box((0, 0, 0), (1, 1, 1)), co.Box((1, 0, 0), (2.5, 1, 1))])
    random = np.random.default_rng(5)
    targets = np.stack([np.ones(500), *random.uniform(0.1, 0.9, (2, 500))], axis=1)
    d = np.abs(random.normal(size=(500, 3))) * (1, 0.02, 0.02) + (0.1, 0, 0)
    o = targets - d * 0.3 / d[:, :1]
    spans = scene.spans(o, d)
    assert (np.diff(spans.offsets) == 2).all()
    assert np.array_equal(spans.t_exit[::2], spans.t_enter[1::2])
    assert np.array_equal(spans.body.reshape(-1, 2), np.broadcast_to([0, 1], (500, 2)))
    crossings = scene.crossings(o, d)
    wall = crossings.t == np.repeat(spans.t_exit[::2], np.diff(crossings.offsets))
    assert len(set(crossings.surface[wall].tolist())) == 1
    leaving = scene.first_hit(o, d)
    assert (leaving.body == 0).all()
    onward = scene.first_hit(leaving.spawn(d))
    assert (onward.body == 1).all()
    assert not onward.entering.any()
    assert np.allclose(onward.t + leaving.t, spans.t_exit[1::2], rtol=1e-14)


def test_spawned_misses_stay_misses_and_hits_keep_their_shape():
    scene = co.Scene([co.Sphere()])
    o = np.array([[[0, 0, 5.0], [0, 3, 5.0]], [[0.5, 0, 5.0], [0, 0, 0.0]]])
    hits = scene.first_hit(o, (0, 0, -1))
    assert np.array_equal(np.isfinite(hits.t), [[True, False], [True, True]])
    again = scene.first_hit(hits.spawn((0, 0, -1)))
    assert again.t.shape == (2, 2)
    assert again.t[0, 0] == pytest.approx(2, rel=1e-15)
    assert np.isinf(again.t[0, 1])
    assert np.isinf(again.t[1, 1])  # left through the far wall
