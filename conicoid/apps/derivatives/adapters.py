"""What the adapters for other libraries share: answers and what is handed back, from arrays to arrays of NumPy."""

from __future__ import annotations

from dataclasses import dataclass
from typing import Any, Protocol

import numpy as np

from ..._util.arrays import FloatArray
from ..._util.validation import describe_kind
from .parameters import Parameters

Arrays = dict[str, FloatArray]
Axes = dict[str, tuple[int, ...]]


class DifferentiableFunction(Protocol):
    """Named arrays from (vector, origins, directions), and what is asked of them handed back."""

    shapes: Axes
    """Of each array, the axes after those of the rays."""

    def forward(self, vector: FloatArray, origins: FloatArray, directions: FloatArray) -> Arrays:
        """The answers."""
        ...

    def backward(
        self, vector: FloatArray, origins: FloatArray, directions: FloatArray, asked: Arrays
    ) -> tuple[FloatArray, FloatArray, FloatArray]:
        """What is asked of the vector, origins and directions, in their shapes."""
        ...


@dataclass(frozen=True)
class AdapterFunctions:
    """The functions of a scene's parameters."""

    parameters: Parameters

    def __post_init__(self) -> None:
        if not isinstance(self.parameters, Parameters):
            raise TypeError(f"parameters must be those of co.parameters(scene), got {describe_kind(self.parameters)}")

    def of_hits(self) -> DifferentiableFunction:
        """First hits: t, point, normal, uv."""
        return _HitFunction(self.parameters)

    def of_integrals(self, values: Any) -> DifferentiableFunction:
        """Line integrals."""
        return _IntegralFunction(self.parameters, np.asarray(values, np.float64))


class _HitFunction:
    shapes: Axes = {"t": (), "point": (3,), "normal": (3,), "uv": (2,)}  # noqa: RUF012 (never changed)

    def __init__(self, parameters: Parameters) -> None:
        self._parameters = parameters

    def forward(self, vector: FloatArray, origins: FloatArray, directions: FloatArray) -> Arrays:
        hits = self._parameters.scene(vector).first_hit(origins, directions)
        return {name: np.asarray(getattr(hits, name)) for name in self.shapes}

    def backward(
        self, vector: FloatArray, origins: FloatArray, directions: FloatArray, asked: Arrays
    ) -> tuple[FloatArray, FloatArray, FloatArray]:
        hits = self._parameters.scene(vector).first_hit(origins, directions)
        found = hits.vjp(self._parameters, **asked)
        return _shape_cotangents(found, origins, directions)


class _IntegralFunction:
    shapes: Axes = {"integral": ()}  # noqa: RUF012 (never changed)

    def __init__(self, parameters: Parameters, values: FloatArray) -> None:
        self._parameters, self._values = parameters, values

    def forward(self, vector: FloatArray, origins: FloatArray, directions: FloatArray) -> Arrays:
        spans = self._parameters.scene(vector).spans(origins, directions)
        return {"integral": np.asarray(spans.line_integral(self._values, overlaps="both"))}

    def backward(
        self, vector: FloatArray, origins: FloatArray, directions: FloatArray, asked: Arrays
    ) -> tuple[FloatArray, FloatArray, FloatArray]:
        spans = self._parameters.scene(vector).spans(origins, directions)
        found = spans.vjp(self._parameters, line_integral=asked["integral"], values=self._values)
        return _shape_cotangents(found, origins, directions)


def _shape_cotangents(
    found: Any, origins: FloatArray, directions: FloatArray
) -> tuple[FloatArray, FloatArray, FloatArray]:
    return (
        found.parameters,
        _sum_broadcast(found.origins, origins.shape),
        _sum_broadcast(found.directions, directions.shape),
    )


def _sum_broadcast(asked: FloatArray, shape: tuple[int, ...]) -> FloatArray:
    """What is asked of an array that was broadcast, as what is asked of the array."""
    extra = asked.ndim - len(shape)
    found = asked.sum(axis=tuple(range(extra)))
    stretched = tuple(i for i, (have, size) in enumerate(zip(found.shape, shape, strict=True)) if have != size)
    return np.asarray(found.sum(axis=stretched, keepdims=True)).reshape(shape)
