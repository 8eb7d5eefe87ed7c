"""First hits and line integrals in PyTorch and JAX, where these are installed."""

import math

import numpy as np
import pytest

import conicoid as co

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
