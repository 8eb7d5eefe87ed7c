"""Methods of results that differentiate them; `conicoid.apps.derivatives` computes the derivatives."""

from __future__ import annotations

from typing import TYPE_CHECKING, Any

from .._util.errstate import ignore_fp_errors

if TYPE_CHECKING:
    from ..apps.derivatives.autodiff import Cotangents, SpanTangents, Tangents
    from ..apps.derivatives.curvature import Curvature


class HitDerivatives:
    """The derivatives of first hits, by the implicit function at the wall that is met."""

    @ignore_fp_errors
    def jvp(
        self, parameters: Any = None, d_parameters: Any = None, *, d_origins: Any = None, d_directions: Any = None
    ) -> Tangents:
        """How t, point, normal and uv change when the rays and the numbers of the shapes change by so much.

        parameters: those of `co.parameters(scene)`; None where no shape changes.
        d_parameters: (parameters,), how they change.
        d_origins, d_directions: (..., 3), how the rays change; None where they stay.

        NaN for misses and where there is no derivative: where walls tie, and at the apex of a cone. Raises ValueError
        for parameters of another scene, for shapes that do not fit, and for hits without their scene.
        """
        from ..apps.derivatives.autodiff import hits_jvp

        return hits_jvp(self, parameters, d_parameters, d_origins, d_directions)  # type: ignore[arg-type]

    @ignore_fp_errors
    def vjp(
        self, parameters: Any = None, *, t: Any = None, point: Any = None, normal: Any = None, uv: Any = None
    ) -> Cotangents:
        """The gradient of Σ asked · answer by the rays and by the numbers of the shapes: the transpose of `jvp`.

        parameters: those of `co.parameters(scene)`; None where only the rays are of interest.
        t, point, normal, uv: what is asked of these fields, of their shapes; 0 where they do not count, as for misses.

        NaN comes back to rays, and to what moves the wall, where something is asked of a hit without derivative. Raises
        ValueError where something is asked of a miss, and as `jvp` does.
        """
        from ..apps.derivatives.autodiff import hits_vjp

        return hits_vjp(self, parameters, t, point, normal, uv)  # type: ignore[arg-type]

    @ignore_fp_errors
    def curvature(self) -> Curvature:
        """Principal curvatures and directions of the walls at the hits: `.k1`, `.k2`, `.direction1`, `.direction2`.

        A wall that bulges outward has positive ones, 1 / r on a ball; k1 >= k2. See docs/derivatives.md.
        """
        from ..apps.derivatives.curvature import curvature

        return curvature(self)  # type: ignore[arg-type]


class SpanDerivatives:
    """The derivatives of spans."""

    @ignore_fp_errors
    def jvp(
        self, parameters: Any = None, d_parameters: Any = None, *, d_origins: Any = None, d_directions: Any = None
    ) -> SpanTangents:
        """How the ends of spans change when the rays and the numbers of the shapes change by so much.

        parameters: those of `co.parameters(scene)`; None where no shape changes.
        d_parameters: (parameters,), how they change.
        d_origins, d_directions: (..., 3), how the rays change; None where they stay.

        `.lengths()` and `.line_integral(values)` of the answer tell how those change. NaN where walls of a body tie. An
        end that is the interval's stays. Raises ValueError as `Hits.jvp` does.
        """
        from ..apps.derivatives.autodiff import spans_jvp

        return spans_jvp(self, parameters, d_parameters, d_origins, d_directions)  # type: ignore[arg-type]

    @ignore_fp_errors
    def vjp(
        self, parameters: Any = None, *, t_enter: Any = None, t_exit: Any = None, line_integral: Any = None,
        values: Any = None, otherwise: Any = None,
    ) -> Cotangents:  # fmt: skip
        """The gradient of Σ asked · answer by the rays and by the numbers of the shapes: the transpose of `jvp`.

        parameters: those of `co.parameters(scene)`; None where only the rays are of interest.
        t_enter, t_exit: (spans,), what is asked of the ends.
        line_integral: (...) or (..., energies), what is asked of `spans.line_integral(values, otherwise)`.
        values, otherwise: those of that integral.

        NaN and errors as for `Hits.vjp`.
        """
        from ..apps.derivatives.autodiff import spans_vjp

        return spans_vjp(self, parameters, t_enter, t_exit, line_integral, values, otherwise)  # type: ignore[arg-type]
