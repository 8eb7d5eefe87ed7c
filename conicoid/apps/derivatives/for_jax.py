"""First hits and line integrals as functions that JAX differentiates (`jax.custom_vjp`): `pip install conicoid[jax]`.

They run on the CPU, also inside `jax.jit` (`jax.pure_callback`). JAX uses 32-bit floats by default, to which results
are rounded; `jax.config.update("jax_enable_x64", True)` keeps all digits.
"""

from __future__ import annotations

from collections.abc import Callable
from typing import Any

import numpy as np
import numpy.typing as npt

from .autodiff import AdapterFunctions
from .parameters import Parameters

try:
    import jax
    import jax.numpy as jnp
except ImportError as error:  # pragma: no cover
    raise ImportError("conicoid.apps.derivatives.for_jax needs JAX: pip install conicoid[jax]") from error


def first_hit(parameters: Parameters) -> Callable[..., dict[str, Any]]:
    """Return a function trace(vector, origins, directions) that JAX differentiates by all three arguments.

    Parameters
    ----------
    parameters : Parameters
        Those of `co.parameters(scene)`.

    Returns
    -------
    callable
        It takes the values of the parameters, (parameters,), and rays (..., 3), and returns a dict of t (...), point
        and normal (..., 3), and uv (..., 2). A miss has t = inf and NaN in the other fields. The gradient must not
        depend on misses: mask them with `jnp.where(jnp.isinf(t), ...)`.

    Raises
    ------
    TypeError
        For `parameters` of another type.
    """
    return _function(AdapterFunctions(parameters).of_hits())


def line_integral(parameters: Parameters, values: npt.ArrayLike) -> Callable[..., Any]:
    """Return a function integrate(vector, origins, directions) that JAX differentiates by all three arguments.

    Parameters
    ----------
    parameters : Parameters
        Those of `co.parameters(scene)`.
    values : array_like (bodies,)
        The integrand in each body. They are constants.

    Returns
    -------
    callable
        It takes the arguments of the function of `first_hit`, and returns `spans.line_integral(values)`, (...).

    Raises
    ------
    TypeError
        For `parameters` of another type.
    """
    traced = _function(AdapterFunctions(parameters).of_integrals(values))
    return lambda vector, origins, directions: traced(vector, origins, directions)["integral"]


def _function(host: Any) -> Callable[..., dict[str, Any]]:
    """Wrap a `DifferentiableFunction` of NumPy arrays as a function of JAX."""

    def forward(vector: Any, origins: Any, directions: Any) -> Any:
        kind = jnp.result_type(float)
        shape = np.broadcast_shapes(origins.shape, directions.shape)[:-1]
        # JAX needs the shapes and dtypes before it calls back.
        out = {name: jax.ShapeDtypeStruct((*shape, *last), kind) for name, last in host.shapes.items()}

        def call(*arrays: Any) -> Any:
            results = host.forward(*(np.asarray(array, np.float64) for array in arrays))
            return {name: np.asarray(results[name], kind) for name in out}

        return jax.pure_callback(call, out, vector, origins, directions)

    # The residuals of the backward pass are the arguments: it traces the rays again.
    def run(vector: Any, origins: Any, directions: Any) -> Any:
        return forward(vector, origins, directions), (vector, origins, directions)

    def back(residuals: Any, cotangents: Any) -> Any:
        out = tuple(jax.ShapeDtypeStruct(array.shape, array.dtype) for array in residuals)

        def call(*arrays: Any) -> Any:
            inputs = [np.asarray(array, np.float64) for array in arrays[:3]]
            weights = {name: np.asarray(array, np.float64) for name, array in arrays[3].items()}
            results = host.backward(*inputs, weights)
            return tuple(np.asarray(one, kind.dtype) for one, kind in zip(results, out, strict=True))

        return jax.pure_callback(call, out, *residuals, cotangents)

    traced = jax.custom_vjp(forward)
    traced.defvjp(run, back)

    def function(vector: Any, origins: Any, directions: Any) -> Any:
        return traced(*(jnp.asarray(array, jnp.result_type(float)) for array in (vector, origins, directions)))

    return function
