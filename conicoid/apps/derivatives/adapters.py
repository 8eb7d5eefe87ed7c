"""Differentiable functions of NumPy arrays, which the adapters for JAX and PyTorch wrap.

Each has a forward pass and a backward pass (vector-Jacobian product) over the parameter vector and the rays.
"""

from __future__ import annotations

from typing import Any, Protocol

import numpy as np
import numpy.typing as npt

from ..._util.records import FloatArray, dataclass
from ..._util.validation import describe_kind
from .parameters import Parameters

Arrays = dict[str, FloatArray]
Axes = dict[str, tuple[int, ...]]


class DifferentiableFunction(Protocol):
    """A function (vector, origins, directions) -> named arrays, with its vector-Jacobian product."""

    shapes: Axes
    """Name of an output -> its axes after those of the rays."""

    def forward(self, vector: FloatArray, origins: FloatArray, directions: FloatArray) -> Arrays:
        """Return the outputs by name."""

    def backward(
        self, vector: FloatArray, origins: FloatArray, directions: FloatArray, cotangents: Arrays
    ) -> tuple[FloatArray, FloatArray, FloatArray]:
        """Return the cotangents of vector, origins and directions, in their shapes, from those of the outputs."""


@dataclass(frozen=True)
class AdapterFunctions:
    """Builds the differentiable functions of a scene's parameters."""

    parameters: Parameters

    def __post_init__(self) -> None:
        if not isinstance(self.parameters, Parameters):
            raise TypeError(f"parameters must be those of co.parameters(scene), got {describe_kind(self.parameters)}")

    def of_hits(self) -> DifferentiableFunction:
        """Return the function of first hits: t, point, normal, uv."""
        return _HitFunction(self.parameters)

    def of_integrals(self, values: npt.ArrayLike) -> DifferentiableFunction:
        """Return the function of line integrals with constant `values`, as `spans.line_integral` takes them."""
        return _IntegralFunction(self.parameters, np.asarray(values, np.float64))


class _HitFunction:
    """First hits. The backward pass traces the rays again."""

    shapes: Axes = {"t": (), "point": (3,), "normal": (3,), "uv": (2,)}  # noqa: RUF012 (never changed)

    def __init__(self, parameters: Parameters) -> None:
        self._parameters = parameters

    def forward(self, vector: FloatArray, origins: FloatArray, directions: FloatArray) -> Arrays:
        hits = self._parameters.scene(vector).first_hit(origins, directions)
        return {name: np.asarray(getattr(hits, name)) for name in self.shapes}

    def backward(
        self, vector: FloatArray, origins: FloatArray, directions: FloatArray, cotangents: Arrays
    ) -> tuple[FloatArray, FloatArray, FloatArray]:
        hits = self._parameters.scene(vector).first_hit(origins, directions)
        gradient = hits.vjp(self._parameters, **cotangents)
        return _shape_cotangents(gradient, origins, directions)


class _IntegralFunction:
    """Line integrals; overlapping bodies all count. The backward pass traces the rays again."""

    shapes: Axes = {"integral": ()}  # noqa: RUF012 (never changed)

    def __init__(self, parameters: Parameters, values: FloatArray) -> None:
        self._parameters, self._values = parameters, values

    def forward(self, vector: FloatArray, origins: FloatArray, directions: FloatArray) -> Arrays:
        spans = self._parameters.scene(vector).spans(origins, directions)
        return {"integral": np.asarray(spans.line_integral(self._values, overlaps="both"))}

    def backward(
        self, vector: FloatArray, origins: FloatArray, directions: FloatArray, cotangents: Arrays
    ) -> tuple[FloatArray, FloatArray, FloatArray]:
        spans = self._parameters.scene(vector).spans(origins, directions)
        gradient = spans.vjp(self._parameters, line_integral=cotangents["integral"], values=self._values)
        return _shape_cotangents(gradient, origins, directions)


def _shape_cotangents(
    gradient: Any, origins: FloatArray, directions: FloatArray
) -> tuple[FloatArray, FloatArray, FloatArray]:
    """Return the cotangents of vector, origins and directions, in the shapes of the arguments."""
    return (
        gradient.parameters,
        _sum_broadcast(gradient.origins, origins.shape),
        _sum_broadcast(gradient.directions, directions.shape),
    )


def _sum_broadcast(cotangent: FloatArray, shape: tuple[int, ...]) -> FloatArray:
    """Sum the cotangent of a broadcast array over the broadcast axes; the result has the array's own shape."""
    # First the axes that broadcasting added in front, then those of size 1 that it stretched.
    extra = cotangent.ndim - len(shape)
    total = cotangent.sum(axis=tuple(range(extra)))
    stretched = tuple(i for i, (have, size) in enumerate(zip(total.shape, shape, strict=True)) if have != size)
    return np.asarray(total.sum(axis=stretched, keepdims=True)).reshape(shape)
