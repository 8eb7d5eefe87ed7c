"""Canonical surfaces: simple ones in place of those of a ray whose ranks are known (see ranks.py).

A ray along the x axis crosses them at x = rank, exactly. They overwrite the records of `stand`, a copy of the scene's
tables.
"""

from __future__ import annotations

import math

from ..._jit.decorators import helper, inline
from ...kernels import tables as table
from ...kernels.body.scratch import Scratch
from ...kernels.surface.exact_crossing import CROSSES
from ...kernels.surface.records import is_curved
from ...kernels.tables import (
    ANCHOR_SIZE,
    FORM_SIZE,
    PLANE_SIZE,
    POLYGON,
    SPHERE,
    SPHERE_SIZE,
    Geometry,
    integer,
    length,
)
from .ranks import SURFACES, Ranks


@helper
def put_canonical_surfaces(
    geometry: Geometry, stand: Geometry, scratch: Scratch, ranks: Ranks, start: int, count: int
) -> None:
    """Write canonical surfaces for ranks.surfaces, and outlines of polygons, into the records of `stand`.

    start: the surface on which the ray starts; count: entries in scratch.found.
    """
    for k in range(ranks.size[SURFACES]):
        surface = ranks.surfaces[k]
        row = integer(geometry, table.SURFACE_ROW, surface)
        crosses, sense = ranks.verdict[2 * surface] == CROSSES, float(ranks.verdict[2 * surface + 1])
        low, high = 0.0, 0.0
        if crosses:
            low, high = ranks.rank[ranks.first[surface]], ranks.rank[ranks.first[surface] + 1]
        kind = integer(geometry, table.SURFACE_KIND, surface)
        if not is_curved(geometry, surface):
            _put_plane(stand, row, crosses, sense, low)
        elif kind == SPHERE:
            _put_sphere(stand, row, crosses, low, high)
        else:
            first = ranks.first[surface]
            ends = crosses and ranks.high[first] > -math.inf, crosses and ranks.high[first + 1] < math.inf
            _put_quadric(stand, row, crosses, sense, low, high, ends, surface == start)
    for k in range(count):
        entry = scratch.found[k]
        if integer(geometry, table.ENTRY_KIND, entry) == POLYGON:
            _put_outline(geometry, stand, ranks, integer(geometry, table.ENTRY_INDEX, entry))


@inline
def _put_plane(stand: Geometry, row: int, crosses: bool, sense: float, rank: float) -> None:
    """Write the plane x = rank, or for a miss a plane parallel to the x axis with the ray on its side `sense`."""
    f, at = stand.floats, stand.places[table.PLANES] + PLANE_SIZE * row
    f[at], f[at + 1], f[at + 2] = (sense, 0.0, 0.0) if crosses else (0.0, 1.0, 0.0)
    f[at + 3] = -sense * rank if crosses else sense
    f[at + 4], f[at + 5], f[at + 6] = 0.0, 0.0, 0.0


@inline
def _put_sphere(stand: Geometry, row: int, crosses: bool, low: float, high: float) -> None:
    """Write a sphere from x = low to x = high, or for a miss one beside the x axis."""
    f, at = stand.floats, stand.places[table.SPHERES] + SPHERE_SIZE * row
    f[at], f[at + 1], f[at + 2] = 0.5 * (low + high), 0.0 if crosses else 5.0, 0.0
    f[at + 3] = 0.5 * (high - low) if crosses else 1.0


def count_form_floats(geometry: Geometry) -> int:
    """Return the number of floats that `stand` has after the scene's: a form for each quadric."""
    return FORM_SIZE * (int(length(geometry, table.QUADRICS)) // ANCHOR_SIZE + 1)


@inline
def blank_quadric(stand: Geometry, row: int) -> tuple[int, int]:
    """Clear a quadric's record and form, and return where they begin in the floats of `stand`.

    In the scene several quadrics may share a form. In `stand` each has its own, after all tables
    (`count_form_floats`).
    """
    f, at, first = stand.floats, stand.places[table.QUADRICS] + ANCHOR_SIZE * row, stand.places[table.QUADRIC_FORMS]
    quadrics = length(stand, table.QUADRICS) // ANCHOR_SIZE
    own = (len(f) - first) // FORM_SIZE - quadrics + row
    form = first + FORM_SIZE * own
    f[at], f[at + 1], f[at + 2], f[at + 3] = 0.0, 0.0, 0.0, float(own)
    for k in range(FORM_SIZE):
        f[form + k] = 0.0
    return at, form


@inline
def _put_quadric(
    stand: Geometry, row: int, crosses: bool, sense: float, low: float, high: float, ends: tuple[bool, bool],
    starts: bool,
) -> None:  # fmt: skip
    """Write ± ((x - middle)² - half²), or a plane if one root is infinite, or for a miss a constant."""
    f, (at, form) = stand.floats, blank_quadric(stand, row)
    f[form], f[form + 4], f[form + 8] = 1.0, 1.0, 1.0
    if crosses and ends[0] and ends[1]:
        half = 0.5 * (high - low)
        f[at], f[form + 9], f[form + 15] = 0.5 * (low + high), sense, sense * half * half
    elif crosses:
        f[at], f[form + 12] = (high, 0.5) if ends[1] else (low, -0.5)
    elif starts:
        f[form + 9] = sense
    else:
        f[form + 15] = -sense


@inline
def _put_outline(geometry: Geometry, stand: Geometry, ranks: Ranks, polygon: int) -> None:
    """Write a triangle around the x axis, or for a miss a point beside it; the vertex count stays the same."""
    first, last = (
        integer(geometry, table.POLYGON_FIRST, polygon),
        integer(geometry, table.POLYGON_FIRST, polygon + 1),
    )
    for vertex in range(first, last):
        y, z = 0.0, 4.0
        # Further vertices repeat the third corner
        if vertex == first:
            y, z = -3.0, -2.0
        elif vertex == first + 1:
            y, z = 3.0, -2.0
        if ranks.loops[polygon] == 0:
            y, z = 5.0, 5.0
        at = stand.places[table.VERTICES] + 3 * vertex
        stand.floats[at], stand.floats[at + 1], stand.floats[at + 2] = 0.0, y, z
