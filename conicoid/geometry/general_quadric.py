"""`Quadric`, the general quadric by its matrix or coefficients."""

from __future__ import annotations

import math
from collections.abc import Mapping
from functools import cached_property

import numpy as np

from .._util.arrays import BoxEnds, Matrix4, Vector
from .._util.dataclass import dataclass
from .._util.validation import check_matrix4
from ..numerics import bigfloat as ex
from .bounds.quadric_extent import dual_support, quadric_ends
from .bounds.support import along_normal, half_space_bounds, plane_through, plane_uv
from .cell import UV, Cell, Face, transform_uv
from .principal_axes import Symmetric, principal_quadric
from .quadric_classification import (
    Classification,
    check_coefficients,
    classify,
    matrix_of_coefficients,
    symmetric_part,
)
from .shape import PrimitiveSolid
from .surface import PlaneSurface, Surface
from .transform import Motion, Translate


@dataclass(frozen=True)
class Quadric(PrimitiveSolid):
    """(x, y, z, 1) Q (x, y, z, 1)ᵀ <= 0, by its `matrix` or by named `coefficients`.

    Only the symmetric part of the matrix counts. Coefficients are xx, yy, zz, xy, yz, xz, x, y, z, constant;
    missing ones are 0, and xy multiplies x·y once. Without second-order terms it is a half-space. Pairs of
    planes, lines, points, all of space and nothing are legal; a constant alone is not.

    Face 0. uv: (angle of (x, y) / 360, z) about the center or, of paraboloids and cylinders, a point of the
    axis; of a half-space, the coordinates that `HalfSpace` has.
    Sources: the ray tracing notes (general quadric and its normal) and the Clemson notes (symmetric matrix).
    """

    matrix: Matrix4 | None = None
    coefficients: dict[str, float] | None = None

    def __post_init__(self) -> None:
        if (self.matrix is None) == (self.coefficients is None):
            present = "neither" if self.matrix is None else "both"
            raise ValueError(f"Quadric: exactly one of matrix and coefficients must be given, got {present}")
        if isinstance(self.matrix, Mapping):
            raise ValueError(
                "Quadric: matrix must be 4 x 4 numbers, got a mapping; Quadric(coefficients={...}) takes it"
            )
        if self.matrix is not None:
            object.__setattr__(self, "matrix", check_matrix4("Quadric", "matrix", self.matrix))
        else:
            object.__setattr__(self, "coefficients", check_coefficients("Quadric", self.coefficients))
        q = self.symmetric
        if not any(q[i][j] for i in range(3) for j in range(4)):
            field = "matrix" if self.matrix is not None else "coefficients"
            raise ValueError(f"Quadric: {field} must hold more than a constant, got {float(q[3][3])} alone")

    @property
    def symmetric(self) -> Symmetric:
        """Q, exact."""
        if self.matrix is not None:
            return symmetric_part(self.matrix)
        return matrix_of_coefficients(self.coefficients or {})

    @cached_property
    def surface(self) -> Surface:
        """The quadric about its principal axes; a plane if it has no second-order terms."""
        q = self.symmetric
        if any(q[i][j] for i in range(3) for j in range(3)):
            return principal_quadric(q)
        return plane_through((2 * q[0][3], 2 * q[1][3], 2 * q[2][3]), -q[3][3])

    def _with_motion(self, motion: Motion) -> Quadric:
        moved = super()._with_motion(motion)
        if "surface" in vars(self):  # its axes take ten milliseconds
            vars(moved)["surface"] = self.surface
        return moved

    @cached_property
    def classification(self) -> Classification:
        """The exact kind of the quadric, with its center, axes and semi-axes in the world."""
        return classify(self.symmetric, self.motion)

    def tree(self) -> Cell:
        return Cell((Face(self.surface, 0, self._uv()),))

    def _uv(self) -> UV:
        if isinstance(self.surface, PlaneSurface):
            return plane_uv(self.surface)
        x, y, z = map(ex.rounded, self.surface.anchor)
        upright = UV(True, ((1, 0, 0, 0), (0, 1, 0, 0), (0, 0, 1, 0)))
        return transform_uv(upright, Motion((Translate((x, y, z)),)))

    def support(self, direction: Vector) -> float:
        surface = self.surface
        if isinstance(surface, PlaneSurface):
            x, y, z = (float(c) for c in surface.normal)
            multiple = along_normal((x, y, z), direction)
            return math.inf if multiple is None or multiple < 0 else float(multiple * surface.offset)
        u = ex.exact_row(direction)
        rows = ex.exact_row(surface.rows[0]), ex.exact_row(surface.rows[1]), ex.exact_row(surface.rows[2])
        # u·x = (W u)·y + u·anchor, the rows of W being orthonormal
        reach = dual_support(surface, ex.apply(rows, u))
        return float(reach) if isinstance(reach, float) else float(ex.dot(u, ex.exact_row(surface.anchor), reach))

    def ends(self, motion: Motion) -> list[float]:
        """Return the bounds by the dual quadric in 3000 bits, rounded outward; an end is infinite exactly if it is."""
        return _surface_ends(self.surface.moved(motion))

    def outside_bounds_under(self, outer: Motion) -> BoxEnds:
        """Return the bounds of f >= 0."""
        ends = _surface_ends(self.surface.reversed().moved(self.under(outer)))
        return np.array(ends[:3]), np.array(ends[3:])


def _surface_ends(surface: Surface) -> list[float]:
    if isinstance(surface, PlaneSurface):
        return [end for side in half_space_bounds(surface, above=False) for end in side.tolist()]
    return quadric_ends(surface)
