"""Shapes without formulas of their own in `outlines`: by differences of first hits."""

from __future__ import annotations

import numpy as np
import pytest

import conicoid as co

from ..contract.examples import examples_of
from ..samples import sampled

BY_NUMBERS = (
    "Wall", "Prism", "PentaPrism", "CornerCube", "Stop", "Tube", "SphereSection", "Polycone", "Trapezoid", "Wedge",
    "RegularPrism", "Pyramid", "Parallelepiped",
)  # fmt: skip
BY_RAYS = ("Conic", "ConicSheet", "Lens", "Mirror", "Mesh", "Extrusion", "Revolution")
STEP = 1e-6


def hits_of(shape):
    scene = co.Scene([co.Body(shape, name="it")])
    random = np.random.default_rng(1)
    low, high = (np.clip(end, -4, 4) for end in shape.bounds)
    inside, directions = random.uniform(low, high, (60, 3)), random.normal(size=(60, 3))
    hits = scene.first_hit(inside - 4 * directions, directions)
    return co.parameters(scene), hits[hits.hit]


@pytest.mark.parametrize("name", sampled(BY_NUMBERS, 4))
def test_by_differences_of_hits(name):
    compared = 0
    for shape in examples_of(name):
        parameters, hits = hits_of(shape)
        values = np.array(parameters.values)
        for k in range(len(values)):
            change = np.eye(len(values))[k]
            try:
                scenes = [parameters.scene(values + s * STEP * change) for s in (1, -1)]
            except ValueError:
                continue  # at the end of what is allowed: a full turn, a pole, an edge without a length
            found = hits.jvp(parameters, change).t
            after, before = (scene.first_hit(hits.rays) for scene in scenes)
            alike = np.isfinite(found) & (after.face == hits.face) & (before.face == hits.face)
            expected = (after.t - before.t)[alike] / (2 * STEP)
            compared += int(alike.sum())
            assert np.allclose(found[alike], expected, rtol=1e-6, atol=1e-6), (name, parameters.names[k])
    assert compared > 20


@pytest.mark.parametrize("name", BY_RAYS)
def test_by_differences_of_rays(name):
    """Rays that are shifted meet walls as differences say."""
    for shape in examples_of(name):
        _, hits = hits_of(shape)
        shift = np.broadcast_to((0.3, -0.2, 0.5), hits.point.shape)
        found = hits.jvp(d_origins=shift).t
        scene = co.Scene([shape])
        after, before = (scene.first_hit(hits.rays.origins + s * STEP * shift, hits.rays.directions) for s in (1, -1))
        alike = np.isfinite(found) & (after.face == hits.face) & (before.face == hits.face) & (np.abs(found) < 100)
        whole_ball = isinstance(shape, co.Lens) and shape.thickness == 2  # its two faces are one sphere: they tie
        assert alike.sum() > 5 or whole_ball
        assert np.allclose(found[alike], (after.t - before.t)[alike] / (2 * STEP), rtol=1e-4, atol=1e-5)
