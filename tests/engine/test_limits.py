"""The limits that kernels work out one use at a time are those of `limits_by_arrays`, to the bit."""

from __future__ import annotations

import random

import numpy as np
import pytest

import conicoid as co
from conicoid.prepare.error_limits import with_limits
from conicoid.prepare.lowering import lower

from ..samples import sampled
from ..shapes.test_bulk import MOTIONS, many
from . import limits_by_arrays
from .test_lowered_scenes import solids_of

LIMITS = ("plane", "quadric", "cell", "program", "sheet", "polygon")
ENDLESS = [
    co.Plane((0, 0, 1), -9), co.HalfSpace((1, 2, 3), -7), co.EllipticParaboloid(2, 1), co.Conic(1, 0, 2),
    co.Quadric(coefficients=dict(xx=1, yy=-2, xy=0.5, z=3)).rotate((1, 2, 3), 20), co.Polygon([(0, 0, 0), (3, 0, 0), (0, 2, 0)]),
    co.Disc((1, 2, 3), (1, 1, 0), 2) & co.Sphere(9), co.Plane((1, 2, 2), 0.1).rotate((1, 0, 1), 10),
]  # fmt: skip


def assert_same_limits(shapes):
    lowered = lower([co.Body(shape) for shape in shapes]).limited()
    expected = limits_by_arrays.with_limits(lowered.tables, lowered.boxes, lowered.rest)
    for kind in LIMITS:
        found, right = (np.asarray(getattr(tables, f"{kind}_limits")) for tables in (lowered.tables, expected))
        assert (found.dtype, found.shape) == (right.dtype, right.shape), kind
        assert found.tobytes() == right.tobytes(), kind
    return lowered


@pytest.mark.parametrize("endless", [False, True])
@pytest.mark.parametrize("seed", sampled(range(6), 3))
def test_of_random_scenes(seed, endless):
    finite = [solid for solid in solids_of(random.Random(seed)) if np.isfinite(solid.bounds).all()]
    lowered = assert_same_limits(finite + ENDLESS * endless)
    assert np.isfinite(lowered.boxes).all() != endless


@pytest.mark.parametrize("motion", MOTIONS)
def test_of_many_in_one_entry(motion):
    lowered = assert_same_limits([MOTIONS[motion](shape) for shape in many().values()])
    assert min(len(lowered.tables.planes), len(lowered.tables.quadrics), len(lowered.tables.sheet_limits)) > 20


def test_of_nothing():
    assert_same_limits([])


def test_a_use_of_what_is_not_there_is_refused():
    """Its owner would have no limit, and be trusted."""
    lowered = lower([co.Body(co.Box()), co.Body(co.Sphere())])
    tables = lowered.tables
    beyond = tables.plane_surface.copy()
    beyond[2] = len(tables.surface_kind)
    with pytest.raises(IndexError, match="that they do not have"):
        with_limits(tables._replace(plane_surface=beyond), lowered.boxes, lowered.rest)
