"""The doublet and the phantom come out as told."""

import importlib
import sys
from pathlib import Path

import numpy as np
import pytest

import conicoid as co

EXAMPLES = Path(__file__).resolve().parents[2] / "examples"


@pytest.fixture
def load(monkeypatch):
    monkeypatch.syspath_prepend(str(EXAMPLES))
    yield importlib.import_module
    for name in ("aspheric_doublet", "recovered_ellipsoids"):
        sys.modules.pop(name, None)


def test_the_doublet(load):
    doublet = load("aspheric_doublet")
    # The derivatives of the whole chain, by differences
    at, step = doublet.solve(steps=3), 1e-5
    _, slopes = doublet.trace(at)
    for k in range(4):
        ends = [doublet.trace(at + s * step * np.eye(4)[k])[0] for s in (-1, 1)]
        assert slopes[k] == pytest.approx((ends[1] - ends[0]) / (2 * step), rel=1e-6, abs=1e-8)
    assert doublet.spot_size(doublet.solve(free=(3,))) == pytest.approx(2.61e-3, rel=0.01)
    assert doublet.spot_size(doublet.solve()) < 0.3e-3


def test_the_phantom(load):
    phantom = load("recovered_ellipsoids")
    rays = phantom.scan()
    sinogram = phantom.scene(phantom.TRUE).line_integral(phantom.densities(phantom.TRUE), rays, overlaps="both")
    near = [(tuple(np.multiply(r, 1.05)), a + 3, tuple(np.add(c, 0.03)), d * 0.95) for r, a, c, d in phantom.TRUE]
    phantom.GUESS = near
    found, values, history = phantom.recovered(sinogram, rays, steps=14)
    assert history[-1] < 1e-12
    expected = phantom.unknowns(phantom.scene(phantom.TRUE))
    assert phantom.unknowns(found).names == expected.names
    assert phantom.unknowns(found).values == pytest.approx(expected.values, rel=1e-9)
    assert values == pytest.approx(phantom.densities(phantom.TRUE), rel=1e-9)


@pytest.mark.deep
def test_pictures(load):
    for name in ("aspheric_doublet", "recovered_ellipsoids"):
        assert isinstance(load(name).picture(scale=0.1), co.Image)
