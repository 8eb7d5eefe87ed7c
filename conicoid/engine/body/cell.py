"""A cell on a ray: at most two spans, each end with the face it lies on.

A face is identified by its place: a row in the table of the cells' planes, or `quadric_place` of a cell, or
`NO_PLACE` for an end at infinity.
"""

from __future__ import annotations

import math
from typing import Any, NamedTuple

from ...compiler.jit import helper, inline
from .. import tables as table
from ..faces import cell_face_and_side, cell_side, plane_face_and_side, plane_side
from ..ray import Ray
from ..surface.nearness import Nearness, nearness_of
from ..surface.records import curved_roots, plane_values
from ..tables import Geometry, integer, whole
from .spans import Slab, clip_slab, compose_spans, spans_unsure

NO_PLACE = -1


class CellSpans(NamedTuple):
    """The spans of a ray inside a cell: in1 < out1 <= in2 < out2 as far as their `number` goes."""

    number: int  # of spans
    in1: float
    out1: float
    place_in1: Any
    place_out1: Any
    in2: float
    out2: float
    place_in2: Any
    place_out2: Any
    unsure: bool  # might rounding change any of that within the interval?


@inline
def quadric_place(cell: int) -> int:
    """The place of a cell's curved face."""
    return -2 - cell


@inline
def end_of(spans: CellSpans, end: int) -> tuple[float, Any]:
    """(t, place) of end 0, 1, 2 or 3; even ends are entered, odd ones left."""
    if end < 2:
        return (spans.in1, spans.place_in1) if end == 0 else (spans.out1, spans.place_out1)
    return (spans.in2, spans.place_in2) if end == 2 else (spans.out2, spans.place_out2)


@inline
def slab_of(geometry: Geometry, cell: int, ray: Ray, inverse: float, nearness: Nearness) -> tuple[Slab, bool, bool]:
    """(what the planes of a cell leave of a ray, might rounding change it, is it unknown where the ray meets one?)

    Early out where a plane along the ray leaves nothing: then no other plane matters.
    """
    slab, unsure, lost = Slab(-math.inf, math.inf, whole(NO_PLACE), whole(NO_PLACE)), False, False
    for place in range(integer(geometry, table.CELL_FIRST, cell), integer(geometry, table.CELL_FIRST, cell + 1)):
        surface, inner = integer(geometry, table.PLANE_SURFACE, place), plane_side(geometry, place) > 0
        height, rate, doubtful = plane_values(geometry, surface, ray, inverse)
        slab, close = clip_slab(slab, height, rate, inner, whole(place), nearness.off)
        unsure |= close
        lost |= doubtful
        if slab.t_in == math.inf:
            break
    return slab, unsure, lost


@helper
def cell_spans(geometry: Geometry, cell: int, ray: Ray, inverse: float) -> CellSpans:
    """The spans of a ray inside a cell, over the whole line, each end with the place of its face.

    Relies on `inverse` = 1 / d·d. Unless `unsure`, the ends within the interval have the order of the exact ones, and
    lie within `nearness.off` of them.
    """
    nearness = nearness_of(geometry, table.CELL_LIMITS, cell, ray, inverse)
    slab, unsure, lost = slab_of(geometry, cell, ray, inverse, nearness)
    lost |= nearness.far < 0.0
    quadric, low, high, crosses, outside = integer(geometry, table.CELL_QUADRIC, cell), math.inf, math.inf, False, True
    if quadric >= 0 and slab.t_in < slab.t_out:
        low, high, outside, crosses, doubtful = curved_roots(geometry, quadric, ray, inverse)
        outside = outside != (cell_side(geometry, cell) < 0)
        unsure |= doubtful
    unsure = lost | spans_unsure(slab, low, high, crosses, unsure, ray.t_min, ray.t_max, nearness)
    if not crosses:  # an early out: what `compose_spans` would say
        t_in, t_out, place_in, place_out = slab
        there = (t_in < t_out) & outside
        return CellSpans(
            1 if there else 0, t_in, t_out, place_in, place_out, t_in, t_out, place_in, place_out, unsure
        )  # fmt: skip
    in1, out1, a1, b1, in2, out2, a2, b2, some, more = compose_spans(
        slab, low, high, crosses, outside, whole(quadric_place(cell))
    )
    if some:
        return CellSpans(2 if more else 1, in1, out1, a1, b1, in2, out2, a2, b2, unsure)
    return CellSpans(1 if more else 0, in2, out2, a2, b2, in2, out2, a2, b2, unsure)


@inline
def place_face(geometry: Geometry, place: int) -> tuple[int, int, int]:
    """(surface, face number, side) of a place; side +1 where the surface's gradient points out of the cell."""
    if place < 0:
        cell = -2 - place
        face, side = cell_face_and_side(geometry, cell)
        return integer(geometry, table.CELL_QUADRIC, cell), face, side
    face, side = plane_face_and_side(geometry, place)
    return integer(geometry, table.PLANE_SURFACE, place), face, side
