"""OpenSCAD's solids: round ones, and the prisms that $fn asks for, with the corners that OpenSCAD gives them."""

from __future__ import annotations

import itertools

from ...shapes.base import Solid
from ...shapes.box import Box
from ...shapes.cone import Cone
from ...shapes.cylinder import Cylinder
from ...shapes.mesh import Extrusion, Mesh
from ...shapes.region import Union
from ...shapes.rounded import sin_cos_degrees
from ...shapes.sphere import Sphere
from .flat import ring
from .values import Arguments


def cube(given: Arguments) -> Solid:
    """A box from the origin, or about it."""
    size = given.given("size")
    sizes = [size] * 3 if isinstance(size, float) else size if isinstance(size, list) else [1.0] * 3
    if len(sizes) != 3 or not all(isinstance(s, float) and 0 < s < 1e100 for s in sizes):
        raise given.refuse(f"size must be three numbers > 0, got {size!s:.60}")
    low = [-s / 2 if given.flag("center") else 0.0 for s in sizes]
    high = [s / 2 if given.flag("center") else s for s in sizes]
    return Box((low[0], low[1], low[2]), (high[0], high[1], high[2]))


def sphere(given: Arguments, smooth: bool) -> Solid:
    """A ball; with $fn a stack of half as many rings of so many corners, at the middles of even steps from the pole."""
    radius, sides = _radius(given), given.sides(smooth)
    if not sides:
        return Sphere(radius)
    levels = rings_of_ball(radius, sides)
    parts = [frustum(low[0], high[0], low[1], high[1], sides) for low, high in itertools.pairwise(levels)]
    return parts[0] if len(parts) == 1 else Union(tuple(parts))


def rings_of_ball(radius: float, sides: int) -> list[tuple[float, float]]:
    """Radii and heights of the rings of a ball with $fn, from the lowest."""
    count = (sides + 1) // 2
    turns = [sin_cos_degrees(180.0 * (k + 0.5) / count) for k in range(count)]
    return [(radius * s, radius * c) for s, c in turns][::-1]


def cylinder(given: Arguments, smooth: bool) -> Solid:
    """A cylinder, cone or frustum; with $fn a prism, pyramid or frustum of one."""
    height = given.number("h", 1.0)
    both = _radius(given)
    first, second = given.number("r1", both), given.number("r2", both)
    if not height > 0:
        raise given.refuse(f"h must be > 0, got {height:g}")
    if first < 0 or second < 0 or first == second == 0:
        raise given.refuse(f"r1 and r2 must be >= 0, and not both 0, got {first:g} and {second:g}")
    low = -height / 2 if given.flag("center") else 0.0
    return frustum(first, second, low, low + height, given.sides(smooth))


def frustum(first: float, second: float, low: float, high: float, sides: int) -> Solid:
    """From a circle about the z axis to another, or between regular polygons."""
    if sides and first >= second:
        return Extrusion(ring(first, sides), (low, high), second / first)
    if sides:
        return Extrusion(ring(second, sides), (-high, -low), first / second).scale((1, 1, -1))
    if first == second:
        return Cylinder((0, 0, low), (0, 0, high), first)
    return Cone((0, 0, low), (0, 0, high), first, second)


def polyhedron(given: Arguments) -> Solid:
    """Any closed one."""
    points = given.rows("points", 3)
    faces = given.paths("faces" if given.given("faces") is not None else "triangles", len(points))
    return Mesh(tuple((p[0], p[1], p[2]) for p in points), tuple(faces))


def _radius(given: Arguments) -> float:
    """r, or half of d."""
    radius = given.number("r", given.number("d", 2.0) / 2)
    if not radius > 0 and given.call.name == "sphere":
        raise given.refuse(f"r must be > 0, got {radius:g}")
    return radius
