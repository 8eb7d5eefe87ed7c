"""Solids along an axis of coordinates, which quarter turns take there exactly."""

from __future__ import annotations

from fractions import Fraction

from ...shapes.steps import Step, Transform, Translate
from ...shapes.vector import Matrix4, Vector
from .pieces import Cuboid, Faces

_TURNS: tuple[Matrix4, Matrix4] = (
    ((0.0, 0.0, 1.0, 0.0), (1.0, 0.0, 0.0, 0.0), (0.0, 1.0, 0.0, 0.0), (0.0, 0.0, 0.0, 1.0)),
    ((0.0, 1.0, 0.0, 0.0), (0.0, 0.0, 1.0, 0.0), (1.0, 0.0, 0.0, 0.0), (0.0, 0.0, 0.0, 1.0)),
)
"""What takes z to x, and z to y."""
_MIRROR: Matrix4 = ((1.0, 0.0, 0.0, 0.0), (0.0, -1.0, 0.0, 0.0), (0.0, 0.0, -1.0, 0.0), (0.0, 0.0, 0.0, 1.0))
"""Half a turn about x."""


def along_axis(start: Vector, end: Vector) -> tuple[tuple[float, float], tuple[Step, ...]] | None:
    """Heights about the z axis and the steps from there, for what stands along an axis of coordinates; else None."""
    along = [i for i in range(3) if start[i] != end[i]]
    if len(along) != 1:
        return None
    axis = along[0]
    low, high = start[axis], end[axis]
    steps: tuple[Step, ...] = ()
    if low > high:
        low, high, steps = -low, -high, (Transform(_MIRROR),)
    if axis != 2:
        steps += (Transform(_TURNS[axis]),)
    x, y, z = (0.0 if i == axis else value for i, value in enumerate(start))
    return (low, high), (*steps, Translate((x, y, z))) if x or y or z else steps


def upright(faces: Faces) -> Cuboid | None:
    """The box that a convex polyhedron is, if its sides are across the axes and its ends are floats."""
    if len(faces.corners) != 8 or len(faces.faces) != 6:
        return None
    ends: list[tuple[float, float]] = []
    for i in range(3):
        values = {corner[i] for corner in faces.corners}
        if len(values) != 2 or any(Fraction(float(value)) != value for value in values):
            return None
        ends.append((float(min(values)), float(max(values))))
    (x, a), (y, b), (z, c) = ends
    return Cuboid((x, y, z), (a, b, c))
