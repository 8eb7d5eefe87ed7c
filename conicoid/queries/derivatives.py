"""Derivatives of results: the methods by which hits and spans differentiate themselves, and their results.

`conicoid.apps.derivatives` computes the derivatives.
"""

from __future__ import annotations

from dataclasses import field
from typing import TYPE_CHECKING, Any, Literal

import numpy as np

from .._util.arrays import FloatArray, ignore_fp_errors
from .._util.records import dataclass
from .rays import lines_of
from .result import extension
from .weights import weights_of

if TYPE_CHECKING:
    import numpy.typing as npt

    from .weights import LineValues


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

    def lengths(self, by: Literal["body", "material"] = "body") -> FloatArray:
        """Return the change of `spans.lengths(by)`: (..., bodies), or (..., materials) for `by` "material"."""
        spans = self._spans
        places, count = spans._places(by)
        ray, change = self._chords()
        rays = len(spans.offsets) - 1
        found: FloatArray = np.bincount(ray * count + places, change, rays * count).astype(np.float64)
        return found.reshape((*spans.shape, count))

    def line_integral(self, values: LineValues, otherwise: npt.ArrayLike | None = None) -> Any:
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


# --- The methods


class HitDerivatives:
    """Derivatives of first hits, by the implicit function theorem at the wall that the ray hits."""

    @ignore_fp_errors
    def jvp(
        self,
        parameters: Any = None,
        d_parameters: npt.ArrayLike | None = None,
        *,
        d_origins: npt.ArrayLike | None = None,
        d_directions: npt.ArrayLike | None = None,
    ) -> Tangents:
        """Return the change of t, point, normal and uv for a change of the rays and of shape parameters (forward mode).

        Parameters
        ----------
        parameters : Parameters, optional
            Those of `co.parameters(scene)`; None if no shape changes.
        d_parameters : array_like (parameters,), optional
            Change of the parameters.
        d_origins, d_directions : array_like (..., 3), optional
            Change of the rays; None if they stay.

        Returns
        -------
        Tangents
            NaN for misses and where no derivative exists: where walls tie, and at the apex of a cone.

        Raises
        ------
        ValueError
            For parameters of another scene, for arrays of other shapes, and for detached hits.
        """
        return extension("hits.jvp")(self, parameters, d_parameters, d_origins, d_directions)

    @ignore_fp_errors
    def vjp(
        self,
        parameters: Any = None,
        *,
        t: npt.ArrayLike | None = None,
        point: npt.ArrayLike | None = None,
        normal: npt.ArrayLike | None = None,
        uv: npt.ArrayLike | None = None,
    ) -> Cotangents:
        """Return the gradient of Σ cotangent · field by the rays and by shape parameters (reverse mode).

        This is the transpose of `jvp`.

        Parameters
        ----------
        parameters : Parameters, optional
            Those of `co.parameters(scene)`; None for the gradient by the rays alone.
        t, point, normal, uv : array_like, optional
            Cotangents of these fields, of their shapes: the derivatives of a scalar by the fields. They must be 0 for
            misses.

        Returns
        -------
        Cotangents
            NaN for rays whose hits have no derivative but a cotangent other than 0, and for parameters of their walls.

        Raises
        ------
        ValueError
            If the cotangent of a miss is not 0, and for the reasons of `jvp`.
        """
        return extension("hits.vjp")(self, parameters, t, point, normal, uv)

    @ignore_fp_errors
    def curvature(self) -> Curvature:
        """Return the principal curvatures and directions of the walls at the hits.

        Returns
        -------
        Curvature
            `.k1` >= `.k2`, positive where the wall bulges outward (1 / r on a ball), with unit directions
            `.direction1` and `.direction2`. See docs/derivatives.md.
        """
        return extension("hits.curvature")(self)


class SpanDerivatives:
    """Derivatives of spans: of their ends, of lengths and of line integrals."""

    @ignore_fp_errors
    def jvp(
        self,
        parameters: Any = None,
        d_parameters: npt.ArrayLike | None = None,
        *,
        d_origins: npt.ArrayLike | None = None,
        d_directions: npt.ArrayLike | None = None,
    ) -> SpanTangents:
        """Return the change of the ends of spans for a change of the rays and of shape parameters (forward mode).

        Parameters
        ----------
        parameters : Parameters, optional
            Those of `co.parameters(scene)`; None if no shape changes.
        d_parameters : array_like (parameters,), optional
            Change of the parameters.
        d_origins, d_directions : array_like (..., 3), optional
            Change of the rays; None if they stay.

        Returns
        -------
        SpanTangents
            Its methods `lengths()` and `line_integral(values)` return the change of those sums. NaN where walls of a
            body tie; 0 for an end that is the end of the interval.

        Raises
        ------
        ValueError
            For the reasons of `Hits.jvp`.
        """
        return extension("spans.jvp")(self, parameters, d_parameters, d_origins, d_directions)

    @ignore_fp_errors
    def vjp(
        self, parameters: Any = None, *, t_enter: npt.ArrayLike | None = None, t_exit: npt.ArrayLike | None = None,
        line_integral: npt.ArrayLike | None = None, values: LineValues | None = None,
        otherwise: npt.ArrayLike | None = None,
    ) -> Cotangents:  # fmt: skip
        """Return the gradient of Σ cotangent · field by the rays and by shape parameters (reverse mode).

        This is the transpose of `jvp`. NaN and errors are as for `Hits.vjp`.

        Parameters
        ----------
        parameters : Parameters, optional
            Those of `co.parameters(scene)`; None for the gradient by the rays alone.
        t_enter, t_exit : array_like (spans,), optional
            Cotangents of the ends.
        line_integral : array_like (...) or (..., energies), optional
            Cotangent of `spans.line_integral(values, otherwise)`.
        values, otherwise
            The arguments of that integral.

        Returns
        -------
        Cotangents
        """
        return extension("spans.vjp")(self, parameters, t_enter, t_exit, line_integral, values, otherwise)
