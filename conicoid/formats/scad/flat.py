"""What is drawn in the plane of x and y: circles and polygons, moved and combined, to be extruded or turned."""

from __future__ import annotations

import itertools
import math
from collections.abc import Callable, Sequence
from dataclasses import dataclass, replace
from typing import Any

import numpy as np

from ...shapes.base import Solid
from ...shapes.cone import Cone
from ...shapes.cylinder import Cylinder
from ...shapes.mesh import Extrusion
from ...shapes.outline import twice_area
from ...shapes.region import Difference, Intersection, Union
from ...shapes.revolution import Revolution
from ...shapes.rounded import sin_cos_degrees
from ...shapes.sphere import Sphere

Matrix = np.ndarray[Any, Any]
UNMOVED = np.eye(4)


@dataclass(frozen=True)
class Flat:
    """A circle (`radius`) or a polygon (`points`) under a motion of the plane, (4, 4)."""

    radius: float = 0.0
    points: tuple[tuple[float, float], ...] = ()
    motion: Any = None

    def moved(self, matrix: Matrix) -> Flat:
        """Under one motion more."""
        return replace(self, motion=matrix @ (UNMOVED if self.motion is None else self.motion))

    def extruded(self, low: float, high: float, scale: float) -> Solid:
        """Drawn along z from low to high, to `scale` times its size about the z axis."""
        motion = UNMOVED if self.motion is None else self.motion
        solid = self._upright(low, high, scale)
        shift, height = motion[:2, 3], high - low
        if scale != 1 and shift.any():  # p + shift (1 + (scale - 1) (z - low) / h)
            lean = UNMOVED.copy()
            lean[:2, 2] = (scale - 1) * shift / height
            lean[:2, 3] = -lean[:2, 2] * low
            motion = lean @ motion
        return solid if np.array_equal(motion, UNMOVED) else solid.transform(motion.tolist())

    def _upright(self, low: float, high: float, scale: float) -> Solid:
        if self.points:
            return Extrusion(self.points, (low, high), scale)
        if scale == 1:
            return Cylinder((0, 0, low), (0, 0, high), self.radius)
        return Cone((0, 0, low), (0, 0, high), self.radius, scale * self.radius)

    def turned(self, start: float, end: float, sides: int) -> Solid:
        """Turned about the y axis of the plane, which becomes z. Raises ValueError for a torus."""
        motion = UNMOVED if self.motion is None else self.motion
        if self.points:
            points = [(motion[:2, :2] @ point + motion[:2, 3]).tolist() for point in self.points]
            if max(x for x, _ in points) <= 0:
                points = [(-x, y) for x, y in points]
            if min(x for x, _ in points) < 0:
                raise ValueError("what is turned must lie on one side of the y axis, got a polygon on both")
            return (
                _many_sided(points, sides, start, end) if sides else Revolution(tuple(map(tuple, points)), start, end)
            )
        linear, shift = motion[:2, :2], motion[:2, 3]
        even = np.allclose(linear @ linear.T, linear[0] @ linear[0] * np.eye(2), rtol=0, atol=1e-15)
        if sides or shift[0] != 0 or not even or end - start != 360:
            raise ValueError("is a torus, or a sphere cut by sides or angles, which is no quadric solid of ours")
        return Sphere(self.radius * math.sqrt(float(linear[0] @ linear[0])), (0, 0, float(shift[1])))


@dataclass(frozen=True)
class FlatBoolean:
    """Several of the plane, combined: each is extruded or turned by itself, and the solids are combined."""

    kind: Callable[[tuple[Solid, ...]], Solid]
    parts: tuple[Flat | FlatBoolean, ...]

    def moved(self, matrix: Matrix) -> FlatBoolean:
        """Under one motion more."""
        return FlatBoolean(self.kind, tuple(part.moved(matrix) for part in self.parts))

    def extruded(self, low: float, high: float, scale: float) -> Solid:
        """As of `Flat`."""
        return self.kind(tuple(part.extruded(low, high, scale) for part in self.parts))

    def turned(self, start: float, end: float, sides: int) -> Solid:
        """As of `Flat`."""
        return self.kind(tuple(part.turned(start, end, sides) for part in self.parts))


Drawn = Flat | FlatBoolean


def combined(kind: Any, parts: Sequence[Drawn]) -> Drawn:
    """A combination; one alone is itself."""
    return parts[0] if len(parts) == 1 else FlatBoolean(kind, tuple(parts))


def circle(radius: float, sides: int) -> Flat:
    """A round one, or a regular polygon whose first corner is on the x axis, as OpenSCAD has it."""
    if not sides:
        return Flat(radius=radius)
    return Flat(points=ring(radius, sides))


def ring(radius: float, sides: int) -> tuple[tuple[float, float], ...]:
    """The corners of a regular polygon."""
    turns = [sin_cos_degrees(360.0 * k / sides) for k in range(sides)]
    return tuple((radius * c, radius * s) for s, c in turns)


def polygon(points: Sequence[Any], paths: Sequence[Sequence[int]] | None) -> Drawn:
    """One outline, or several by even-odd."""
    loops = [tuple(points)] if paths is None else [tuple(points[k] for k in path) for path in paths]
    drawn: Drawn | None = None
    for loop in loops:
        if not twice_area([(float(x), float(y)) for x, y in loop]):
            continue
        one = Flat(points=tuple((float(x), float(y)) for x, y in loop))
        if drawn is None:
            drawn = one
        else:
            drawn = combined(Union, [combined(Difference, [drawn, one]), combined(Difference, [one, drawn])])
    if drawn is None:
        raise ValueError("points must enclose an area")
    return drawn


def _many_sided(points: Sequence[Any], sides: int, start: float, end: float) -> Solid:
    """A polygon turned in so many steps: a stack of frustums with flat sides."""
    if end - start != 360:
        raise ValueError("$fn with an angle is not read: smooth makes it round")
    heights = sorted({y for _, y in points})
    from .solids import frustum

    rings = []
    for low, high in itertools.pairwise(heights):
        middle = (low + high) / 2
        ends = []
        for (x0, y0), (x1, y1) in zip(points, [*points[1:], points[0]], strict=True):
            if min(y0, y1) <= low and high <= max(y0, y1) and y0 != y1:
                a, b, m = (x0 + (x1 - x0) * (y - y0) / (y1 - y0) for y in (low, high, middle))
                ends.append((m, a, b))
        ends.sort()
        for inner, outer in zip(ends[::2], ends[1::2], strict=True):
            body = frustum(outer[1], outer[2], low, high, sides)
            hole = frustum(inner[1], inner[2], low, high, sides) if inner[1] > 0 or inner[2] > 0 else None
            rings.append(body if hole is None else Difference((body, hole)))
    return rings[0] if len(rings) == 1 else Union(tuple(rings))


__all__ = ["Difference", "Drawn", "Flat", "Intersection", "Union", "circle", "combined", "polygon", "ring"]
