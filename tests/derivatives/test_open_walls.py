"""One face of a solid as an open surface moves as the solid's does."""

from __future__ import annotations

import zlib

import numpy as np
import pytest

import conicoid as co
from conicoid.geometry.shape import PrimitiveSolid

from ..contract.examples import MOTIONS, every_example
from ..samples import sampled
from .test_every_shape import rays_at

SOLIDS = {name: shape for name, shape in every_example() if isinstance(shape, PrimitiveSolid) and name != "Lens-4"}
"""That lens is a whole ball, whose faces are one sphere, and tie."""


@pytest.mark.parametrize("name", sampled(SOLIDS, 7))
def test_a_wall_moves_as_its_solid_does(name):
    solid = MOTIONS["moved"](SOLIDS[name])
    random = np.random.default_rng(zlib.crc32(name.encode()))
    origins, directions = rays_at(solid, 300, 5)
    scene = co.Scene([co.Body(solid, name="it")])
    hits = scene.first_hit(origins, directions)
    numbers = co.parameters(scene)
    change = random.normal(size=len(numbers))
    known = dict(zip(numbers.names, change, strict=True))
    for face in np.unique(hits.face[hits.hit]).tolist():
        rays = np.flatnonzero(hits.hit & (hits.face == face))[:20]
        wall = co.Scene([co.Body(co.Wall(solid, face), name="it")])
        its = co.parameters(wall)
        alone = wall.first_hit(origins[rays], directions[rays])
        assert np.array_equal(alone.t, hits.t[rays])
        moved = alone.jvp(its, [known["it." + each.removeprefix("it.solid.")] for each in its.names])
        expected = hits[rays].jvp(numbers, change)
        tied = np.isnan(expected.t)  # of walls of the solid in one plane, this is one
        for field in ("t", "point", "normal", "uv"):
            own, its_solids = getattr(moved, field), getattr(expected, field)
            np.testing.assert_allclose(own[~tied], its_solids[~tied], rtol=1e-12, atol=1e-12)
