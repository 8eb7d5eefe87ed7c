"""Planes and quadrics of cells, another in each lane: their records are gathered, row by row."""

from __future__ import annotations

from typing import Any

import numpy as np

from ...compiler.jit import helper, inline
from .. import tables as table
from ..culling import numbers_in_lanes
from ..surface.nearness import Nearness
from ..surface.plane import Plane, PlaneLimits
from ..surface.quadric import Quadric, QuadricLimits, Sphere, careful_quadratic, settled_roots, sphere_roots
from ..tables import ANCHOR_SIZE, FORM_SIZE, PLANE_SIZE, SPHERE_SIZE, Floats, Geometry, integer, real, whole
from .cells import lane_terms, put_roots, put_terms, quadric_of_lane
from .forms import (
    AT,
    CELL,
    CELL_FAR,
    CELL_OFF,
    LIMIT,
    OTHER_LIMIT,
    R0,
    R1,
    R2,
    R3,
    R4,
    R5,
    R6,
    R7,
    R8,
    R9,
    R10,
    R11,
    R12,
    R13,
    R14,
    R15,
    R16,
    R17,
    R18,
    SURFACE,
    Bodies,
)
from .lanes import (
    FLAG,
    INVERSE,
    LANES,
    OWN,
    START,
    eights,
    lane_line,
)
from .planes import cut_lane, plane_of_lane, put_careful_plane


@inline
def cell_limits(lanes: Floats, i: Any) -> Nearness:
    """The limits of the cell in a lane."""
    return Nearness(lanes[CELL_OFF + i], lanes[CELL_FAR + i])


@helper
def cut_planes(geometry: Geometry, bodies: Bodies, number: int, side: int, place: int, count: int) -> None:
    """Cut the lanes by plane `number` of their cells, which has a place among the body's faces."""
    lanes, numbers = bodies.lanes, bodies.numbers
    planes = geometry.places[table.PLANES]
    for k in range(count):
        lane = np.uint64(k)
        first = integer(geometry, table.CELL_FIRST, numbers[CELL + k])
        surface = integer(geometry, table.PLANE_SURFACE, first + number)
        row = integer(geometry, table.SURFACE_ROW, surface)
        numbers[AT + k], lanes[SURFACE + lane] = planes + PLANE_SIZE * row, surface
        lanes[LIMIT + lane] = real(geometry, table.PLANE_LIMITS, 2 * row)
        lanes[OTHER_LIMIT + lane] = real(geometry, table.PLANE_LIMITS, 2 * row + 1)
    for k in range(0, count, 8):
        numbers_in_lanes(geometry.floats, numbers, AT + k, lanes, R0 + np.uint64(k))
    first, last = eights(0, count)
    again = 0
    for i in range(first, last):
        again += plane_of_lane(lanes, i, lane_line(lanes, i), _plane(lanes, i), _plane_limits(lanes, i))
    if again > 0:
        for i in range(first, last):
            if lanes[FLAG + i] == 1.0:
                put_careful_plane(lanes, i, _plane(lanes, i), _plane_limits(lanes, i))
    for i in range(first, last):
        cut_lane(lanes, i, cell_limits(lanes, i), lanes[SURFACE + i], side > 0, place)
        lanes[OWN + i] = 1.0 if lanes[START + i] == lanes[SURFACE + i] else lanes[OWN + i]


@inline
def _plane(lanes: Floats, i: Any) -> Plane:
    """The plane in a lane."""
    return Plane(
        lanes[R0 + i], lanes[R1 + i], lanes[R2 + i], lanes[R3 + i], lanes[R4 + i], lanes[R5 + i], lanes[R6 + i]
    )  # fmt: skip


@inline
def _plane_limits(lanes: Floats, i: Any) -> PlaneLimits:
    """The limits of the plane in a lane."""
    return PlaneLimits(lanes[LIMIT + i], lanes[OTHER_LIMIT + i])


@helper
def meet_spheres(geometry: Geometry, bodies: Bodies, count: int) -> None:
    """Roots of the spheres of cells into their lanes (`cells.put_roots`)."""
    lanes, numbers, spheres = bodies.lanes, bodies.numbers, geometry.places[table.SPHERES]
    for k in range(count):
        surface = integer(geometry, table.CELL_QUADRIC, numbers[CELL + k])
        numbers[AT + k] = spheres + SPHERE_SIZE * integer(geometry, table.SURFACE_ROW, surface)
        lanes[SURFACE + np.uint64(k)] = surface
    for k in range(0, count, 8):
        numbers_in_lanes(geometry.floats, numbers, AT + k, lanes, R0 + np.uint64(k))
    first, last = eights(0, count)
    for i in range(first, last):
        sphere, starts = Sphere(lanes[R0 + i], lanes[R1 + i], lanes[R2 + i], lanes[R3 + i]), _starts(lanes, i)
        put_roots(lanes, i, sphere_roots(sphere, lane_line(lanes, i), lanes[INVERSE + i], starts))


@inline
def _starts(lanes: Floats, i: Any) -> bool:
    """Does the ray of a lane start on the surface in it?"""
    return lanes[START + i] == lanes[SURFACE + i]


@helper
def meet_quadrics(geometry: Geometry, bodies: Bodies, count: int) -> None:
    """Roots of the quadrics of cells into their lanes (`cells.put_roots`)."""
    lanes, numbers = bodies.lanes, bodies.numbers
    quadrics = geometry.places[table.QUADRICS]
    forms = geometry.places[table.QUADRIC_FORMS]
    for k in range(count):
        lane, surface = np.uint64(k), integer(geometry, table.CELL_QUADRIC, numbers[CELL + k])
        row = integer(geometry, table.SURFACE_ROW, surface)
        numbers[AT + k], lanes[SURFACE + lane] = quadrics + ANCHOR_SIZE * row, surface
    for k in range(0, count, 8):
        numbers_in_lanes(geometry.floats, numbers, AT + k, lanes, R0 + np.uint64(k))
    for k in range(count):  # the row of the form stands behind the anchor, where the form comes to
        lane = np.uint64(k)
        form = whole(lanes[R3 + lane])
        numbers[AT + k] = forms + FORM_SIZE * form
        lanes[LIMIT + lane] = real(geometry, table.QUADRIC_LIMITS, 2 * form)
        lanes[OTHER_LIMIT + lane] = real(geometry, table.QUADRIC_LIMITS, 2 * form + 1)
    for part in range(2):
        for k in range(0, count, 8):
            numbers_in_lanes(geometry.floats, numbers, AT + k, lanes, R3 + np.uint64(8 * LANES * part + k))
        for k in range(count):
            numbers[AT + k] += 8
    first, last = eights(0, count)
    again = 0
    for i in range(first, last):
        again += quadric_of_lane(lanes, i, lane_line(lanes, i), _quadric(lanes, i), lanes[SURFACE + i])
    if again > 0:
        for i in range(first, last):
            terms = lane_terms(lanes, i)
            if terms.cancels:
                put_terms(lanes, i, careful_quadratic(_quadric(lanes, i), lane_line(lanes, i), terms))
    for i in range(first, last):
        its = QuadricLimits(lanes[LIMIT + i], lanes[OTHER_LIMIT + i])
        put_roots(lanes, i, settled_roots(lane_terms(lanes, i), _starts(lanes, i), lanes[INVERSE + i], its))


@inline
def _quadric(lanes: Floats, i: Any) -> Quadric:
    """The quadric in a lane."""
    return Quadric(
        lanes[R0 + i], lanes[R1 + i], lanes[R2 + i], lanes[R3 + i], lanes[R4 + i], lanes[R5 + i], lanes[R6 + i],
        lanes[R7 + i], lanes[R8 + i], lanes[R9 + i], lanes[R10 + i], lanes[R11 + i], lanes[R12 + i], lanes[R13 + i],
        lanes[R14 + i], lanes[R15 + i], lanes[R16 + i], lanes[R17 + i], lanes[R18 + i],
    )  # fmt: skip
