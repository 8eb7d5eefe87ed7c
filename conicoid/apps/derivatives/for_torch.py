"""First hits and line integrals as functions that PyTorch differentiates: `pip install conicoid[torch]`.

They run on the CPU; tensors of other devices are brought there and back.
"""

from __future__ import annotations

from collections.abc import Callable
from typing import Any

import numpy as np

from .adapters import AdapterFunctions
from .parameters import Parameters

try:
    import torch
except ImportError as error:  # pragma: no cover
    raise ImportError("conicoid.apps.derivatives.for_torch needs PyTorch: pip install conicoid[torch]") from error


def first_hit(parameters: Parameters) -> Callable[..., dict[str, Any]]:
    """trace(vector, origins, directions) -> dict of t, point, normal, uv, differentiable by all three.

    parameters: those of `co.parameters(scene)`; the vector (parameters,) is of their values. Rays are (..., 3). A miss
    has t = inf and NaN elsewhere, and what is asked of it must be 0: sums over `t[torch.isfinite(t)]` see to that.
    """
    return _function(AdapterFunctions(parameters).of_hits())


def line_integral(parameters: Parameters, values: Any) -> Callable[..., Any]:
    """integrate(vector, origins, directions) -> (...), `spans.line_integral(values)`, differentiable by all three.

    parameters, vector: as for `first_hit`; values: (bodies,), which stay.
    """
    traced = _function(AdapterFunctions(parameters).of_integrals(values))
    return lambda vector, origins, directions: traced(vector, origins, directions)["integral"]


def _function(host: Any) -> Callable[..., dict[str, Any]]:
    """A function of PyTorch from one that works out answers, and what is handed back, in NumPy."""

    class Traced(torch.autograd.Function):  # type: ignore[misc]
        """One evaluation."""

        @staticmethod
        def forward(ctx: Any, *given: Any) -> Any:
            ctx.save_for_backward(*given)
            found = host.forward(*(_array(tensor) for tensor in given))
            return tuple(_like(found[name], given[0]) for name in host.shapes)

        @staticmethod
        def backward(ctx: Any, *asked: Any) -> Any:
            given = ctx.saved_tensors
            wanted = {name: _array(tensor) for name, tensor in zip(host.shapes, asked, strict=True)}
            found = host.backward(*(_array(tensor) for tensor in given), wanted)
            return tuple(_like(one, tensor) for one, tensor in zip(found, given, strict=True))

    def function(vector: Any, origins: Any, directions: Any) -> dict[str, Any]:
        like = vector if torch.is_tensor(vector) else torch.as_tensor(vector, dtype=torch.float64)
        given = [torch.as_tensor(part, dtype=like.dtype, device=like.device) for part in (like, origins, directions)]
        return dict(zip(host.shapes, Traced.apply(*given), strict=True))

    return function


def _array(tensor: Any) -> Any:
    return tensor.detach().cpu().numpy().astype(np.float64)


def _like(array: Any, tensor: Any) -> Any:
    """An array as a tensor of another's kind and device."""
    return torch.as_tensor(np.array(array), dtype=tensor.dtype, device=tensor.device)
