"""The derivatives that results return: of first hits, of spans, and the curvature of walls."""

from __future__ import annotations

from dataclasses import dataclass, field
from typing import Any

import numpy as np

from .._util.arrays import FloatArray
from .rays import lines_of
from .weights import weights_of


@dataclass(frozen=True)
class Tangents:
    """Changes of first hits: of t (...), of point and normal (..., 3), of uv (..., 2).

    NaN where no derivative exists, and for misses (docs/derivatives.md).
    """

    t: Any
    point: FloatArray
    normal: FloatArray
    uv: FloatArray


@dataclass(frozen=True)
class Cotangents:
    """The gradient of Σ cotangent · field by the arguments of a query.

    parameters (parameters,), or None if the call had none; origins and directions (..., 3), shaped like the rays.
    """

    parameters: FloatArray | None
    origins: FloatArray
    directions: FloatArray


@dataclass(frozen=True)
class SpanTangents:
    """Changes of the ends of spans, t_enter and t_exit (spans,); 0 for clipped ends, NaN where no derivative exists."""

    t_enter: FloatArray
    t_exit: FloatArray
    _spans: Any = field(repr=False)  # `Spans`, which imports this module for its annotations
    _stretch: FloatArray = field(repr=False)  # (rays,) relative change of the length of the direction

    def lengths(self, by: Any = "body") -> FloatArray:
        """Return the change of `spans.lengths(by)`: (..., bodies), or (..., materials) for `by` "material"."""
        spans = self._spans
        places, count = spans._places(by)
        ray, change = self._chords()
        rays = len(spans.offsets) - 1
        found: FloatArray = np.bincount(ray * count + places, change, rays * count).astype(np.float64)
        return found.reshape((*spans.shape, count))

    def line_integral(self, values: Any, otherwise: Any = None) -> Any:
        """Return the change of `spans.line_integral(values, otherwise)` at constant values: (...) or (..., energies).

        The integral is linear in the values, so its derivative by a value is a length.
        """
        spans = self._spans
        weights = weights_of(values, otherwise, spans._body_count, spans._distinct)
        places, _ = spans._places(weights.by)
        ray, change = self._chords()
        columns = weights.values.reshape(len(weights.values), -1).T
        rays = len(spans.offsets) - 1
        parts = [np.where(column[places] == 0, 0.0, column[places]) for column in columns]
        found = [np.bincount(ray, np.where(part == 0, 0.0, part * change), rays) for part in parts]
        return np.array(found).T.reshape((*spans.shape, *weights.shape))[()]

    def _chords(self) -> tuple[Any, FloatArray]:
        """Return the ray's number and the change of the true length of every span."""
        ray, chord = self._spans._chords()
        size = np.sqrt((lines_of(self._spans.rays)[1] ** 2).sum(axis=1))
        with np.errstate(invalid="ignore"):
            longer = np.where(self._stretch[ray] == 0, 0.0, chord * self._stretch[ray])
        return ray, (self.t_exit - self.t_enter) * size[ray] + longer


@dataclass(frozen=True)
class Curvature:
    """Principal curvatures of walls at hits.

    k1 >= k2 (...), 1 / radius, positive where the wall bulges outward; direction1 and direction2 (..., 3), unit and
    perpendicular to the normal. Where k1 = k2, the directions are any orthogonal pair. NaN for misses, and at the apex
    of a cone.
    """

    k1: Any
    k2: Any
    direction1: FloatArray
    direction2: FloatArray

    @property
    def mean(self) -> Any:
        """The mean curvature, (k1 + k2) / 2."""
        return (self.k1 + self.k2) / 2

    @property
    def gaussian(self) -> Any:
        """The Gaussian curvature, k1 k2."""
        return self.k1 * self.k2
