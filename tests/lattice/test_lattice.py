"""Every query on lattices: bodies of all kinds under all motions, rays through their corners, edges, axes and walls. Nothing may be wrong."""

from __future__ import annotations

import pytest

from .kinds import SCENES
from .suite import score

SAMPLE = 60
DEEP = 44
"""Scenes of each kind, of some 750 rays each."""


@pytest.mark.parametrize("kind", SCENES)
def test_lattice(kind):
    total = score(kind, range(2), SAMPLE)
    assert total.rows
    total.check()


@pytest.mark.deep
@pytest.mark.parametrize("kind", SCENES)
def test_a_million_rays_on_lattices(kind):
    total = score(kind, range(100, 100 + DEEP), 500)
    total.check()
    assert total.rays > 1_000_000 / len(SCENES)
