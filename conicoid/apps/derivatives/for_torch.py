"""First hits and line integrals as functions that PyTorch differentiates: `pip install conicoid[torch]`.

They run on the CPU. Tensors on other devices are copied there, and the results back.
"""

from __future__ import annotations

from collections.abc import Callable
from typing import Any

import numpy as np
import numpy.typing as npt

from .autodiff import AdapterFunctions
from .parameters import Parameters

try:
    import torch
except ImportError as error:  # pragma: no cover
    raise ImportError("conicoid.apps.derivatives.for_torch needs PyTorch: pip install conicoid[torch]") from error


def first_hit(parameters: Parameters) -> Callable[..., dict[str, Any]]:
    """Return a function trace(vector, origins, directions) that PyTorch differentiates by all three arguments.

    Parameters
    ----------
    parameters : Parameters
        Those of `co.parameters(scene)`.

    Returns
    -------
    callable
        It takes the values of the parameters, (parameters,), and rays (..., 3), and returns a dict of t (...), point
        and normal (..., 3), and uv (..., 2). A miss has t = inf and NaN in the other fields. The gradient must not
        depend on misses: sum over `t[torch.isfinite(t)]`.

    Raises
    ------
    TypeError
        For `parameters` of another type.
    """
    return _function(AdapterFunctions(parameters).of_hits())


def line_integral(parameters: Parameters, values: npt.ArrayLike) -> Callable[..., Any]:
    """Return a function integrate(vector, origins, directions) that PyTorch differentiates by all three arguments.

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
    """Wrap a `DifferentiableFunction` of NumPy arrays as a function of PyTorch."""

    class TorchFunction(torch.autograd.Function):  # type: ignore[misc]
        """The forward and the backward pass."""

        @staticmethod
        def forward(ctx: Any, *inputs: Any) -> Any:
            # The backward pass traces the rays again, so the inputs are all that it needs.
            ctx.save_for_backward(*inputs)
            results = host.forward(*(_array(tensor) for tensor in inputs))
            return tuple(_like(results[name], inputs[0]) for name in host.shapes)

        @staticmethod
        def backward(ctx: Any, *cotangents: Any) -> Any:
            inputs = ctx.saved_tensors
            weights = {name: _array(tensor) for name, tensor in zip(host.shapes, cotangents, strict=True)}
            results = host.backward(*(_array(tensor) for tensor in inputs), weights)
            return tuple(_like(one, tensor) for one, tensor in zip(results, inputs, strict=True))

    def function(vector: Any, origins: Any, directions: Any) -> dict[str, Any]:
        # The dtype and the device of the vector rule; float64 if it is not a tensor.
        like = vector if torch.is_tensor(vector) else torch.as_tensor(vector, dtype=torch.float64)
        inputs = [torch.as_tensor(part, dtype=like.dtype, device=like.device) for part in (like, origins, directions)]
        return dict(zip(host.shapes, TorchFunction.apply(*inputs), strict=True))

    return function


def _array(tensor: Any) -> Any:
    """Return a tensor as a float64 array on the CPU."""
    return tensor.detach().cpu().numpy().astype(np.float64)


def _like(array: Any, tensor: Any) -> Any:
    """Return an array as a tensor with the dtype and the device of another tensor."""
    return torch.as_tensor(np.array(array), dtype=tensor.dtype, device=tensor.device)
