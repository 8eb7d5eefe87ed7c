"""Paraxial rays, by matrices: the place of the pupil, and the width of beams.

The state is (y, n u), with n below 0 where light travels along -z, so that mirrors are surfaces like others.
"""

from __future__ import annotations

import math
from collections.abc import Sequence
from dataclasses import dataclass
from typing import TypeAlias

Matrix: TypeAlias = tuple[float, float, float, float]
"""A, B, C, D of y' = A y + B nu, nu' = C y + D nu."""

IDENTITY: Matrix = (1.0, 0.0, 0.0, 1.0)


@dataclass(frozen=True)
class ParaxialSurface:
    """A surface for paraxial rays: curvature, the signed indices before and behind it, the thickness that follows."""

    curvature: float
    before: float
    behind: float
    thickness: float

    @property
    def bend(self) -> Matrix:
        """The refraction: nu' = nu - (n' - n) c y."""
        return 1.0, 0.0, -(self.behind - self.before) * self.curvature, 1.0

    @property
    def gap(self) -> Matrix:
        """The way to the next surface: y' = y + (t / n') nu'."""
        return 1.0, self.thickness / self.behind, 0.0, 1.0


def multiply(second: Matrix, first: Matrix) -> Matrix:
    """Return the matrix of `first`, then `second`."""
    a, b, c, d = second  # row by row
    e, f, g, h = first
    return a * e + b * g, a * f + b * h, c * e + d * g, c * f + d * h


def matrix_to_vertex(surfaces: Sequence[ParaxialSurface], last: int) -> Matrix:
    """Return the matrix from before the first surface to the vertex of surface `last`, before its refraction."""
    matrix = IDENTITY
    for surface in surfaces[:last]:
        matrix = multiply(surface.gap, multiply(surface.bend, matrix))
    return matrix


def system_matrix(surfaces: Sequence[ParaxialSurface]) -> Matrix:
    """Return the matrix from before the first surface to behind the last one."""
    return multiply(surfaces[-1].bend, matrix_to_vertex(surfaces, len(surfaces) - 1))


def focus(surfaces: Sequence[ParaxialSurface], object_distance: float) -> float:
    """Return the distance along z from the last vertex to the image of an object on the axis; infinite for none."""
    a, b, c, d = system_matrix(surfaces)
    # A ray parallel to the axis, or one from the object's point on the axis.
    y, nu = (1.0, 0.0) if math.isinf(object_distance) else (object_distance / surfaces[0].before, 1.0)
    height, slope = a * y + b * nu, c * y + d * nu
    return -height * surfaces[-1].behind / slope if slope else math.inf


def entrance_pupil(surfaces: Sequence[ParaxialSurface], stop: int) -> tuple[float, float]:
    """Return (z of the stop's image in front, from the first vertex; diameter of the stop over that of this image)."""
    a, b, _, _ = matrix_to_vertex(surfaces, stop)
    # The stop lies in the focal plane of the surfaces before it.
    if a == 0:
        raise ValueError("prescription: the entrance pupil lies at infinity: rows must have another stop")
    return b * surfaces[0].before / a, abs(a)


def heights(surfaces: Sequence[ParaxialSurface], y: float, nu: float) -> list[float]:
    """Return the heights of a ray at all vertices, from its state at the first one."""
    heights_at_vertices = []
    for last in range(len(surfaces)):
        a, b, _, _ = matrix_to_vertex(surfaces, last)
        heights_at_vertices.append(a * y + b * nu)
    return heights_at_vertices
