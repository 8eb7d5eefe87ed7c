"""First hits and line integrals as functions that JAX differentiates, by `jax.custom_vjp`: `pip install conicoid[jax]`.

They run on the CPU, also inside of `jax.jit` (`jax.pure_callback`). With 32-bit floats, which are JAX's own, answers
are rounded to these; `jax.config.update("jax_enable_x64", True)` keeps all digits.
"""

from __future__ import annotations

from collections.abc import Callable
from typing import Any

import numpy as np

from .adapters import AdapterFunctions
from .parameters import Parameters

try:
    import jax
    import jax.numpy as jnp
except ImportError as error:  # pragma: no cover
    raise ImportError("conicoid.apps.derivatives.for_jax needs JAX: pip install conicoid[jax]") from error


def first_hit(parameters: Parameters) -> Callable[..., dict[str, Any]]:
    """trace(vector, origins, directions) -> dict of t, point, normal, uv, differentiable by all three.

    parameters: those of `co.parameters(scene)`; the vector (parameters,) is of their values. Rays are (..., 3). A miss
    has t = inf and NaN elsewhere, and what is asked of it must be 0: `jnp.where(jnp.isinf(t), ...)` sees to that.
    """
    return _function(AdapterFunctions(parameters).of_hits())


def line_integral(parameters: Parameters, values: Any) -> Callable[..., Any]:
    """integrate(vector, origins, directions) -> (...), `spans.line_integral(values)`, differentiable by all three.

    parameters, vector: as for `first_hit`; values: (bodies,), which stay.
    """
    traced = _function(AdapterFunctions(parameters).of_integrals(values))
    return lambda vector, origins, directions: traced(vector, origins, directions)["integral"]


def _function(host: Any) -> Callable[..., dict[str, Any]]:
    """A function of JAX from one that works out answers, and what is handed back, in NumPy."""

    def forward(vector: Any, origins: Any, directions: Any) -> Any:
        kind = jnp.result_type(float)
        shape = np.broadcast_shapes(origins.shape, directions.shape)[:-1]
        out = {name: jax.ShapeDtypeStruct((*shape, *last), kind) for name, last in host.shapes.items()}

        def call(*arrays: Any) -> Any:
            found = host.forward(*(np.asarray(array, np.float64) for array in arrays))
            return {name: np.asarray(found[name], kind) for name in out}

        return jax.pure_callback(call, out, vector, origins, directions)

    def run(vector: Any, origins: Any, directions: Any) -> Any:
        return forward(vector, origins, directions), (vector, origins, directions)

    def back(kept: Any, asked: Any) -> Any:
        out = tuple(jax.ShapeDtypeStruct(array.shape, array.dtype) for array in kept)

        def call(*arrays: Any) -> Any:
            given = [np.asarray(array, np.float64) for array in arrays[:3]]
            wanted = {name: np.asarray(array, np.float64) for name, array in arrays[3].items()}
            found = host.backward(*given, wanted)
            return tuple(np.asarray(one, kind.dtype) for one, kind in zip(found, out, strict=True))

        return jax.pure_callback(call, out, *kept, asked)

    traced = jax.custom_vjp(forward)
    traced.defvjp(run, back)

    def function(vector: Any, origins: Any, directions: Any) -> Any:
        return traced(*(jnp.asarray(array, jnp.result_type(float)) for array in (vector, origins, directions)))

    return function
