"""Derivatives in examples, and in PyTorch and JAX."""

import importlib
import math
import sys
from pathlib import Path

import numpy as np
import pytest

import conicoid as co

# --- The doublet and the phantom come out right


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


# --- First hits and line integrals in PyTorch and JAX, where these are installed


SCENE = co.Scene([co.Body(co.Sphere(2), name="ball")])
RAYS = np.array([(-5.0, 1.0, 0.0), (-5.0, 9.0, 0.0)]), np.array((1.0, 0.0, 0.0))
# t = 5 - sqrt(r² - h²): by r, by the center's x, by the height h of the ray
BY_RADIUS, BY_HEIGHT = -2 / math.sqrt(3), 1 / math.sqrt(3)


def test_jax():
    jax = pytest.importorskip("jax", reason="JAX is not installed: pip install conicoid[jax]")
    jax.config.update("jax_enable_x64", True)
    from conicoid.apps.derivatives.for_jax import first_hit, line_integral

    parameters = co.parameters(SCENE)
    trace, integrate = first_hit(parameters), line_integral(parameters, [3.0])

    def total(vector, origins, directions):
        t = trace(vector, origins, directions)["t"]
        return jax.numpy.where(jax.numpy.isinf(t), 0.0, t).sum()

    of_vector, of_origins, of_directions = jax.jit(jax.grad(total, argnums=(0, 1, 2)))(parameters.values, *RAYS)
    assert of_vector == pytest.approx([BY_RADIUS, 1, -BY_HEIGHT, 0], rel=1e-14)
    assert of_origins == pytest.approx(np.array([(-1, BY_HEIGHT, 0), (0, 0, 0)]), rel=1e-14)
    assert of_directions.shape == (3,)
    of_vector = jax.grad(lambda vector: integrate(vector, *RAYS).sum())(parameters.values)
    assert of_vector == pytest.approx([-3 * 2 * BY_RADIUS, 0, 3 * 2 * BY_HEIGHT, 0], rel=1e-14)


def test_torch():
    torch = pytest.importorskip("torch", reason="PyTorch is not installed: pip install conicoid[torch]")
    from conicoid.apps.derivatives.for_torch import first_hit, line_integral

    parameters = co.parameters(SCENE)
    vector = torch.tensor(parameters.values, requires_grad=True)
    origins = torch.tensor(RAYS[0], requires_grad=True)
    t = first_hit(parameters)(vector, origins, torch.tensor(RAYS[1]))["t"]
    t[torch.isfinite(t)].sum().backward()
    assert vector.grad.numpy() == pytest.approx([BY_RADIUS, 1, -BY_HEIGHT, 0], rel=1e-14)
    assert origins.grad.numpy() == pytest.approx(np.array([(-1, BY_HEIGHT, 0), (0, 0, 0)]), rel=1e-14)
    vector.grad = None
    line_integral(parameters, [3.0])(vector, origins, torch.tensor(RAYS[1])).sum().backward()
    assert vector.grad.numpy() == pytest.approx([-3 * 2 * BY_RADIUS, 0, 3 * 2 * BY_HEIGHT, 0], rel=1e-14)
