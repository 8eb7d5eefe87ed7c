"""Rays infinitely near the axis, by matrices: where the pupil lies, and how wide beams are.

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
    """A surface to paraxial rays: curvature, the signed indices before and behind, the thickness that follows."""

    curvature: float
    before: float
    behind: float
    thickness: float

    @property
    def bend(self) -> Matrix:
        """nu' = nu - (n' - n) c y"""
        return 1.0, 0.0, -(self.behind - self.before) * self.curvature, 1.0

    @property
    def gap(self) -> Matrix:
        """y' = y + (t / n') nu'"""
        return 1.0, self.thickness / self.behind, 0.0, 1.0


def multiply(second: Matrix, first: Matrix) -> Matrix:
    """The product: first one, then the other."""
    a, b, c, d = second
    e, f, g, h = first
    return a * e + b * g, a * f + b * h, c * e + d * g, c * f + d * h


def matrix_to_vertex(surfaces: Sequence[ParaxialSurface], last: int) -> Matrix:
    """From before the first surface to the vertex of one, not yet bent by it."""
    found = IDENTITY
    for surface in surfaces[:last]:
        found = multiply(surface.gap, multiply(surface.bend, found))
    return found


def system_matrix(surfaces: Sequence[ParaxialSurface]) -> Matrix:
    """From before the first surface to behind the last one."""
    return multiply(surfaces[-1].bend, matrix_to_vertex(surfaces, len(surfaces) - 1))


def focus(surfaces: Sequence[ParaxialSurface], object_distance: float) -> float:
    """How far along z behind the last vertex an object on the axis has its image; infinite if nowhere."""
    a, b, c, d = system_matrix(surfaces)
    y, nu = (1.0, 0.0) if math.isinf(object_distance) else (object_distance / surfaces[0].before, 1.0)
    height, slope = a * y + b * nu, c * y + d * nu
    return -height * surfaces[-1].behind / slope if slope else math.inf


def entrance_pupil(surfaces: Sequence[ParaxialSurface], stop: int) -> tuple[float, float]:
    """(z of the stop's image in front, from the first vertex; how much wider the stop is than this image)."""
    a, b, _, _ = matrix_to_vertex(surfaces, stop)
    if a == 0:
        raise ValueError("prescription: the entrance pupil lies at infinity: rows must have another stop")
    return b * surfaces[0].before / a, abs(a)


def heights(surfaces: Sequence[ParaxialSurface], y: float, nu: float) -> list[float]:
    """The heights of a ray at all vertices, from those at the first one."""
    found = []
    for last in range(len(surfaces)):
        a, b, _, _ = matrix_to_vertex(surfaces, last)
        found.append(a * y + b * nu)
    return found
