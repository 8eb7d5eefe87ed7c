"""Solids of OpenSCAD: figures in the plane of x and y, to be extruded or revolved, and primitives.

With $fn, circles are regular polygons, and round solids are polyhedra, prisms and stacks of frustums with OpenSCAD's
corners; without it they are exactly round.
"""

from __future__ import annotations

import itertools
import math
from collections.abc import Callable, Sequence
from dataclasses import replace
from typing import Any

import numpy as np

from ..._util.records import dataclass
from ...geometry.polyhedron import Extrusion, Mesh, Polyhedron
from ...geometry.primitives import Box, Cone, Cylinder, Sphere
from ...geometry.revolution import Revolution
from ...geometry.shape import Difference, Solid, Union
from ...geometry.sheets import twice_area
from ...numerics.portable_math import sin_cos_degrees
from ..importers import OmittedPart
from .syntax import CallArguments

Matrix = np.ndarray[Any, Any]
IDENTITY_MATRIX = np.eye(4)


@dataclass(frozen=True)
class PlaneFigure:
    """A circle (`radius`) or a polygon (`points`), moved by a matrix (4, 4) that maps the plane to itself."""

    radius: float = 0.0
    points: tuple[tuple[float, float], ...] = ()
    motion: Any = None

    def moved(self, matrix: Matrix) -> PlaneFigure:
        """Return the figure after one more motion."""
        return replace(self, motion=matrix @ (IDENTITY_MATRIX if self.motion is None else self.motion))

    def extruded(self, low: float, high: float, scale: float) -> Solid:
        """Return the solid extruded along z from low to high; its upper end is scaled by `scale` about the z axis."""
        motion = IDENTITY_MATRIX if self.motion is None else self.motion
        solid = self._upright(low, high, scale)
        shift, height = motion[:2, 3], high - low
        # The scale applies to the shift too: the figure goes to p + shift (1 + (scale - 1) (z - low) / h), a shear.
        if scale != 1 and shift.any():
            lean = IDENTITY_MATRIX.copy()
            lean[:2, 2] = (scale - 1) * shift / height
            lean[:2, 3] = -lean[:2, 2] * low
            motion = lean @ motion
        return solid if np.array_equal(motion, IDENTITY_MATRIX) else solid.transform(motion.tolist())

    def _upright(self, low: float, high: float, scale: float) -> Solid:
        """Return the figure extruded before its motion."""
        if self.points:
            return Extrusion(self.points, (low, high), scale)
        if scale == 1:
            return Cylinder((0, 0, low), (0, 0, high), self.radius)
        return Cone((0, 0, low), (0, 0, high), self.radius, scale * self.radius)

    def turned(self, start: float, end: float, sides: int) -> Solid:
        """Return the solid of revolution about the y axis of the plane, which becomes z.

        Parameters
        ----------
        start, end
            First and last azimuth in degrees.
        sides
            Number of flat sides of a full turn; 0 for round.

        Raises
        ------
        OmittedPart
            The solid is no quadric (a torus), or a polygon lies on both sides of the axis.

        """
        motion = IDENTITY_MATRIX if self.motion is None else self.motion
        if self.points:
            points = [(motion[:2, :2] @ point + motion[:2, 3]).tolist() for point in self.points]
            if max(x for x, _ in points) <= 0:  # on the left side, half a turn ahead
                points, start, end = [(-x, y) for x, y in points], start + 180, end + 180
            if min(x for x, _ in points) < 0:
                raise OmittedPart("has a polygon on both sides of the y axis")
            if sides:
                return _revolve_in_steps(points, sides, start, end)
            return Revolution(tuple(map(tuple, points)), *((0, 360) if end - start == 360 else (start, end)))
        linear, shift = motion[:2, :2], motion[:2, 3]
        # A circle stays a circle only under a similarity of the plane.
        even = np.allclose(linear @ linear.T, linear[0] @ linear[0] * np.eye(2), rtol=0, atol=1e-15)
        if sides or shift[0] != 0 or not even or end - start != 360:
            raise OmittedPart("is a torus, or a sphere cut by sides or angles, which no quadric bounds")
        return Sphere(self.radius * math.sqrt(float(linear[0] @ linear[0])), (0, 0, float(shift[1])))


@dataclass(frozen=True)
class FlatBoolean:
    """A Boolean of figures: each figure is extruded or revolved by itself, and the solids are combined."""

    kind: Callable[[tuple[Solid, ...]], Solid]
    parts: tuple[PlaneFigure | FlatBoolean, ...]

    def moved(self, matrix: Matrix) -> FlatBoolean:
        """Return the figures after one more motion."""
        return FlatBoolean(self.kind, tuple(part.moved(matrix) for part in self.parts))

    def extruded(self, low: float, high: float, scale: float) -> Solid:
        """Return the extruded solid; see `PlaneFigure.extruded`."""
        return self.kind(tuple(part.extruded(low, high, scale) for part in self.parts))

    def turned(self, start: float, end: float, sides: int) -> Solid:
        """Return the solid of revolution; see `PlaneFigure.turned`."""
        return self.kind(tuple(part.turned(start, end, sides) for part in self.parts))


PlaneItem = PlaneFigure | FlatBoolean


def combine_figures(kind: Any, parts: Sequence[PlaneItem]) -> PlaneItem:
    """Return the Boolean of figures; a single figure is returned as it is."""
    return parts[0] if len(parts) == 1 else FlatBoolean(kind, tuple(parts))


def plane_circle(radius: float, sides: int) -> PlaneFigure:
    """Return a round circle, or, with `sides`, a regular polygon with its first corner on the x axis, as OpenSCAD."""
    if not radius > 0:
        raise OmittedPart(f"has the radius {radius:g}")
    if not sides:
        return PlaneFigure(radius=radius)
    return PlaneFigure(points=regular_polygon(radius, sides))


def regular_polygon(radius: float, sides: int) -> tuple[tuple[float, float], ...]:
    """Return the corners of a regular polygon, the first on the x axis."""
    turns = [sin_cos_degrees(360.0 * k / sides) for k in range(sides)]
    return tuple((radius * c, radius * s) for s, c in turns)


def plane_polygon(points: Sequence[Any], paths: Sequence[Sequence[int]] | None) -> PlaneItem:
    """Return the figure of one outline, or of several `paths` (indices of points) by the even-odd rule.

    Outlines without area are skipped. Raise OmittedPart if none has an area.
    """
    loops = [tuple(points)] if paths is None else [tuple(points[k] for k in path) for path in paths]
    drawn: PlaneItem | None = None
    for loop in loops:
        if not loop or not twice_area([(float(x), float(y)) for x, y in loop]):
            continue
        one = PlaneFigure(points=tuple((float(x), float(y)) for x, y in loop))
        if drawn is None:
            drawn = one
        else:  # the even-odd rule is the symmetric difference
            drawn = combine_figures(
                Union, [combine_figures(Difference, [drawn, one]), combine_figures(Difference, [one, drawn])]
            )
    if drawn is None:
        raise OmittedPart("has no area")
    return drawn


def _revolve_in_steps(points: Sequence[Any], sides: int, start: float, end: float) -> Solid:
    """Return a polygon revolved in `sides` steps from the azimuth `start`: a stack of frustums with flat sides."""
    if end - start != 360:
        raise OmittedPart("has $fn and an angle, which are not read: smooth makes it round")
    heights = sorted({y for _, y in points})

    rings = []
    for low, high in itertools.pairwise(heights):
        middle = (low + high) / 2
        ends = []
        for (x0, y0), (x1, y1) in zip(points, [*points[1:], points[0]], strict=True):
            if min(y0, y1) <= low and high <= max(y0, y1) and y0 != y1:
                a, b, m = (x0 + (x1 - x0) * (y - y0) / (y1 - y0) for y in (low, high, middle))
                ends.append((m, a, b))
        ends.sort()
        # No corner lies between low and high: edges do not cross there, and enter and leave the polygon in turn.
        for inner, outer in zip(ends[::2], ends[1::2], strict=True):
            body = frustum(outer[1], outer[2], low, high, sides)
            hole = frustum(inner[1], inner[2], low, high, sides) if inner[1] > 0 or inner[2] > 0 else None
            rings.append(body if hole is None else Difference((body, hole)))
    solid = rings[0] if len(rings) == 1 else Union(tuple(rings))
    # Frustums have a corner at the azimuth 0
    return solid.rotate("z", start) if start * sides % 360 else solid


# Primitives: round, or with the corners that OpenSCAD gives them with $fn


def cube(arguments: CallArguments) -> Solid:
    """Return a box with a corner at the origin, or centred on it."""
    size = arguments.value("size")
    sizes = [size] * 3 if isinstance(size, float) else size if isinstance(size, list) else [1.0] * 3
    if len(sizes) != 3 or not all(isinstance(s, float) for s in sizes):
        raise arguments.refuse(f"size must be three numbers, got {size!s:.60}")
    if not all(0 < s < 1e100 for s in sizes):
        raise OmittedPart(f"has the size {size!s:.60}")
    low = [-s / 2 if arguments.flag("center") else 0.0 for s in sizes]
    high = [s / 2 if arguments.flag("center") else s for s in sizes]
    return Box((low[0], low[1], low[2]), (high[0], high[1], high[2]))


@dataclass(frozen=True)
class SidedBall:
    """The call sphere($fn = sides, r = radius), which becomes a polyhedron: exports write it as it was."""

    radius: float
    sides: int


def sphere(arguments: CallArguments, smooth: bool) -> Solid:
    """Return a ball; with $fn the polyhedron of `sided_ball`."""
    radius, sides = arguments.radius("", 1.0), arguments.sides(smooth)
    if not radius > 0:
        raise OmittedPart(f"has the radius {radius:g}")
    if not sides:
        return Sphere(radius)
    whole = sided_ball(radius, sides)
    vars(whole)["_source"] = SidedBall(radius, sides)
    return whole


def sided_ball(radius: float, sides: int) -> Polyhedron:
    """Return the convex polyhedron of a ball with $fn sides: its sides from the lowest ring up, then bottom and top.

    There are half as many rings of corners as sides, at the middles of even steps δ of the polar angle. The side
    between two rings, at the polar angle θ and the azimuth φ of its middle, has the normal
    (sin θ cos φ, sin θ sin φ, c cos θ) and the offset radius c cos(δ / 2), with c = cos(180° / sides): its four
    corners are in one plane.
    """
    count = (sides + 1) // 2
    flat, half = sin_cos_degrees(180.0 / sides)[1], sin_cos_degrees(90.0 / count)[1]
    directions = [sin_cos_degrees(360.0 * (k + 0.5) / sides) for k in range(sides)]
    normals = []
    for ring in range(count - 1, 0, -1):
        s, c = sin_cos_degrees(180.0 * ring / count)
        normals += [(s * x, s * y, flat * c) for y, x in directions]
    level = radius * half
    offsets = [flat * level] * len(normals) + [level, level]
    return Polyhedron((*normals, (0.0, 0.0, -1.0), (0.0, 0.0, 1.0)), tuple(offsets))


def cylinder(arguments: CallArguments, smooth: bool) -> Solid:
    """Return a cylinder, cone or truncated cone; with $fn a prism, pyramid or frustum."""
    height = arguments.number("h", 1.0)
    both = arguments.radius("", 1.0)
    first, second = arguments.radius("1", both), arguments.radius("2", both)
    if not height > 0:
        raise OmittedPart(f"has the height {height:g}")
    if first < 0 or second < 0 or first == second == 0:
        raise OmittedPart(f"has the radii {first:g} and {second:g}")
    low = -height / 2 if arguments.flag("center") else 0.0
    return frustum(first, second, low, low + height, arguments.sides(smooth))


def frustum(first: float, second: float, low: float, high: float, sides: int) -> Solid:
    """Return the solid between two circles about the z axis, or between two regular polygons.

    The side at the azimuth φ of its middle has the normal (cos φ, sin φ, s), where s is the decrease of the inner
    radius, that of a corner times cos(180° / sides), by the height.
    """
    if sides:
        flat = sin_cos_degrees(180.0 / sides)[1]
        slope = flat * (first - second) / (high - low)
        directions = [sin_cos_degrees(360.0 * (k + 0.5) / sides) for k in range(sides)]
        normals = [(x, y, slope) for y, x in directions]
        offsets = [flat * first + slope * low] * sides
        return Polyhedron((*normals, (0.0, 0.0, -1.0), (0.0, 0.0, 1.0)), (*offsets, -low, high))
    if first == second:
        return Cylinder((0, 0, low), (0, 0, high), first)
    return Cone((0, 0, low), (0, 0, high), first, second)


def polyhedron(arguments: CallArguments) -> Solid:
    """Return a closed polyhedron from points and faces. OpenSCAD goes on without one that encloses nothing."""
    points = arguments.rows("points", 3)
    faces = arguments.paths("triangles" if arguments.value("triangles") is not None else "faces", len(points))
    try:
        return Mesh(tuple((p[0], p[1], p[2]) for p in points), tuple(faces))
    except ValueError as error:
        raise OmittedPart(f"is no closed solid ({error})") from None
