"""Methods by which hits and spans differentiate themselves; `conicoid.apps.derivatives` computes the derivatives."""

from __future__ import annotations

from typing import TYPE_CHECKING, Any

from .._util.errstate import ignore_fp_errors
from .extensions import extension

if TYPE_CHECKING:
    from .tangents import Cotangents, Curvature, SpanTangents, Tangents


class HitDerivatives:
    """Derivatives of first hits, by the implicit function theorem at the wall that the ray hits."""

    @ignore_fp_errors
    def jvp(
        self, parameters: Any = None, d_parameters: Any = None, *, d_origins: Any = None, d_directions: Any = None
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
        tangents: Tangents = extension("hits.jvp")(self, parameters, d_parameters, d_origins, d_directions)
        return tangents

    @ignore_fp_errors
    def vjp(
        self, parameters: Any = None, *, t: Any = None, point: Any = None, normal: Any = None, uv: Any = None
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
        cotangents: Cotangents = extension("hits.vjp")(self, parameters, t, point, normal, uv)
        return cotangents

    @ignore_fp_errors
    def curvature(self) -> Curvature:
        """Return the principal curvatures and directions of the walls at the hits.

        Returns
        -------
        Curvature
            `.k1` >= `.k2`, positive where the wall bulges outward (1 / r on a ball), with unit directions
            `.direction1` and `.direction2`. See docs/derivatives.md.
        """
        curvature: Curvature = extension("hits.curvature")(self)
        return curvature


class SpanDerivatives:
    """Derivatives of spans: of their ends, of lengths and of line integrals."""

    @ignore_fp_errors
    def jvp(
        self, parameters: Any = None, d_parameters: Any = None, *, d_origins: Any = None, d_directions: Any = None
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
        tangents: SpanTangents = extension("spans.jvp")(self, parameters, d_parameters, d_origins, d_directions)
        return tangents

    @ignore_fp_errors
    def vjp(
        self, parameters: Any = None, *, t_enter: Any = None, t_exit: Any = None, line_integral: Any = None,
        values: Any = None, otherwise: Any = None,
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
        cotangents: Cotangents = extension("spans.vjp")(
            self, parameters, t_enter, t_exit, line_integral, values, otherwise
        )
        return cotangents
