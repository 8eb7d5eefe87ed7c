"""A cell on a ray: at most two spans, each end with the face it lies on.

A face is told by its place: a row in the table of the cells' planes, or `quadric_place` of a cell, or
`NO_PLACE` for an end at infinity.
"""

from __future__ import annotations

import math
from typing import TypeAlias

from ..jit import helper, inline
from . import tables as table
from .plane import Plane, plane_on_ray
from .quadric import Quadric, Roots, Sphere, quadric_roots, sphere_roots
from .tables import QUADRIC, SPHERE, Geometry, Ray, integer

NO_PLACE = -1

Spans: TypeAlias = tuple[int, float, float, int, int, float, float, int, int]
"""count, then t_in, t_out, place_in, place_out of each"""


@inline
def quadric_place(cell: int) -> int:
    """The place of a cell's curved face."""
    return -2 - cell


@inline
def load_plane(geometry: Geometry, row: int) -> Plane:
    at = geometry.places[table.PLANES, 0] + 7 * row
    t = geometry.floats
    return t[at], t[at + 1], t[at + 2], t[at + 3], t[at + 4], t[at + 5], t[at + 6]


@inline
def load_sphere(geometry: Geometry, row: int) -> Sphere:
    at = geometry.places[table.SPHERES, 0] + 4 * row
    t = geometry.floats
    return t[at], t[at + 1], t[at + 2], t[at + 3]


@inline
def load_quadric(geometry: Geometry, row: int) -> Quadric:
    at = geometry.places[table.QUADRICS, 0] + 19 * row
    t = geometry.floats
    return (
        t[at], t[at + 1], t[at + 2], t[at + 3], t[at + 4], t[at + 5], t[at + 6], t[at + 7], t[at + 8], t[at + 9],
        t[at + 10], t[at + 11], t[at + 12], t[at + 13], t[at + 14], t[at + 15], t[at + 16], t[at + 17], t[at + 18],
    )  # fmt: skip


@inline
def plane_crossing(geometry: Geometry, surface: int, ray: Ray) -> tuple[float, float, float]:
    """(t, height, rate): where the ray crosses a plane; t = 0 on the plane it starts on."""
    ox, oy, oz, dx, dy, dz, _, _, start = ray
    plane = load_plane(geometry, integer(geometry, table.SURFACE_ROW, surface))
    height, rate = plane_on_ray(plane, ox, oy, oz, dx, dy, dz)
    height = 0.0 if surface == start else height
    return -height / rate, height, rate


@helper
def curved_roots(geometry: Geometry, surface: int, ray: Ray, inverse: float) -> Roots:
    """Crossings with a sphere or general quadric."""
    ox, oy, oz, dx, dy, dz, _, _, start = ray
    row = integer(geometry, table.SURFACE_ROW, surface)
    if integer(geometry, table.SURFACE_KIND, surface) == SPHERE:
        return sphere_roots(load_sphere(geometry, row), ox, oy, oz, dx, dy, dz, inverse, surface == start)
    return quadric_roots(load_quadric(geometry, row), ox, oy, oz, dx, dy, dz, inverse, surface == start)


@inline
def slab_span(geometry: Geometry, cell: int, ray: Ray) -> tuple[float, float, int, int]:
    """The span inside all planes of a cell; t_in >= t_out where there is none.

    A ray within a plane counts as if the plane stood an infinitesimal further along its normal.
    """
    t_in, t_out, place_in, place_out = -math.inf, math.inf, NO_PLACE, NO_PLACE
    for slot in range(integer(geometry, table.CELL_FIRST, cell), integer(geometry, table.CELL_FIRST, cell + 1)):
        t, height, rate = plane_crossing(geometry, integer(geometry, table.PLANE_SURFACE, slot), ray)
        side = integer(geometry, table.PLANE_SIDE, slot)
        if rate == 0.0:
            if (height <= 0.0) != (side > 0):
                return math.inf, -math.inf, NO_PLACE, NO_PLACE
        elif (rate < 0.0) == (side > 0):
            if t > t_in:
                t_in, place_in = t, slot
        elif t < t_out:
            t_out, place_out = t, slot
    return t_in, t_out, place_in, place_out


@helper
def cell_spans(geometry: Geometry, cell: int, ray: Ray, inverse: float) -> Spans:
    """The spans of a ray inside a cell, in order; contacts of zero length are none."""
    t_in, t_out, place_in, place_out = slab_span(geometry, cell, ray)
    second = (math.inf, -math.inf, NO_PLACE, NO_PLACE)
    if not t_in < t_out:
        return 0, t_in, t_out, place_in, place_out, *second
    quadric, curved = integer(geometry, table.CELL_QUADRIC, cell), quadric_place(cell)
    if quadric < 0:
        return 1, t_in, t_out, place_in, place_out, *second
    low, high, outside, crosses = curved_roots(geometry, quadric, ray, inverse)
    outside = outside != (integer(geometry, table.CELL_SIDE, cell) < 0)
    if not crosses:
        return (1 if outside else 0), t_in, t_out, place_in, place_out, *second
    if not outside:
        in_slot = curved if low >= t_in else place_in
        out_slot = curved if high <= t_out else place_out
        t_in, t_out = max(low, t_in), min(high, t_out)
        return (1 if t_in < t_out else 0), t_in, t_out, in_slot, out_slot, *second
    # Outside of ]low, high[: what is left of it and what is right of it
    out_slot = curved if low <= t_out else place_out
    in_slot = curved if high >= t_in else place_in
    first_out, second_in = min(low, t_out), max(high, t_in)
    if second_in < t_out:
        if t_in < first_out:
            return 2, t_in, first_out, place_in, out_slot, second_in, t_out, in_slot, place_out
        return 1, second_in, t_out, in_slot, place_out, *second
    return (1 if t_in < first_out else 0), t_in, first_out, place_in, out_slot, *second


@inline
def place_face(geometry: Geometry, place: int) -> tuple[int, int, int]:
    """(surface, face number, side) of a place; side +1 where the surface's gradient points out of the cell."""
    if place < 0:
        cell = -2 - place
        return (
            integer(geometry, table.CELL_QUADRIC, cell),
            integer(geometry, table.CELL_FACE, cell),
            integer(geometry, table.CELL_SIDE, cell),
        )
    return (
        integer(geometry, table.PLANE_SURFACE, place),
        integer(geometry, table.PLANE_FACE, place),
        integer(geometry, table.PLANE_SIDE, place),
    )


@inline
def is_curved(geometry: Geometry, surface: int) -> bool:
    return (
        integer(geometry, table.SURFACE_KIND, surface) == SPHERE
        or integer(geometry, table.SURFACE_KIND, surface) == QUADRIC
    )
