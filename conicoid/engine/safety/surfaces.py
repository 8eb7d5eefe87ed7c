"""Signed bounds of the distances from 64 points to a surface: the formulas of `nearest/bounds.py` in lanes."""

from __future__ import annotations

import math
from typing import Any

import numpy as np

from ...compiler.jit import choose, helper, inline
from .. import tables as table
from ..nearest.axes import Axes, principal_axes
from ..nearest.bounds import LESS, less_rounding, plain_bound, plane_bound, slowly_solved, sphere_bound
from ..nearest.form import Form, form_of_plane, form_of_quadric, form_of_sphere
from ..nearest.quick import STEPS, first_guess, next_step, proved, reached, turned
from ..surface.records import load_plane, load_quadric, load_sphere
from ..tables import PLANE, SPHERE, Floats, Geometry, integer
from .rows import (
    BEST,
    BOUND,
    DONE,
    EVERY,
    FACE,
    HIGH,
    LOW,
    PLAIN,
    VALUE,
    F,
    W,
    X,
    Y,
    Z,
    equation_of_lane,
    form_of_lane,
    put_equation,
    put_form,
    put_search,
    search_of_lane,
)


@helper
def _go_on(room: Floats) -> None:
    """Steps of all lanes until each is done, or some will not be."""
    for _ in range(STEPS):
        done = 0.0
        for i in range(EVERY):
            at = next_step(equation_of_lane(room, i), search_of_lane(room, i))
            put_search(room, i, at)
            done += at.done
        if done == 64.0:
            break


@helper
def _solve(room: Floats, same: Form, axes: Axes, scale: float) -> None:
    """The nearest points of a quadric where its PLAIN bound is less than BEST: FACE, without a sign."""
    for i in range(EVERY):
        e = turned(form_of_lane(room, i, same), axes, scale, room[PLAIN + i])
        put_equation(room, i, e)
        put_search(room, i, first_guess(e))
        # What is on the wall, or too far away to matter, waits for nobody
        room[DONE + i] = choose((room[PLAIN + i] > 0.0) & (room[PLAIN + i] < room[BEST + i]), 0.0, 1.0)
    _go_on(room)
    for i in range(EVERY):
        e = equation_of_lane(room, i)
        room[F + i] = less_rounding(form_of_lane(room, i, same), e, room[W + i], scale)
        room[LOW + i], room[HIGH + i] = 0.0, math.inf
        certain = (room[DONE + i] == 1.0) & (room[F + i] > 0.0)
        matters = (room[PLAIN + i] > 0.0) & (room[PLAIN + i] < room[BEST + i])
        room[DONE + i] = choose(certain & matters, 0.0, 1.0)
        room[BOUND + i] = choose(certain, 1.0, 0.0)
    _go_on(room)
    for i in range(EVERY):
        e = equation_of_lane(room, i)
        w = proved(e, room[W + i])
        proof = (room[BOUND + i] == 1.0) & (room[DONE + i] == 1.0) & (w < math.inf)
        room[FACE + i] = choose(proof, max(room[PLAIN + i], reached(e, w) * LESS), math.nan)


@helper
def _quadric(geometry: Geometry, row: int, room: Floats) -> None:
    """FACE of a quadric, with its sign."""
    quadric, near = load_quadric(geometry, row), 0
    for i in range(EVERY):
        form = form_of_quadric(quadric, room[X + i], room[Y + i], room[Z + i])
        put_form(room, i, form)
        plain = plain_bound(form)
        room[PLAIN + i], room[FACE + i] = plain, plain
        near += 1 if (plain > 0.0) & (plain < room[BEST + i]) else 0
    if near > 0:
        same = form_of_quadric(quadric, room[X], room[Y], room[Z])
        axes = principal_axes(same.xx, same.yy, same.zz, same.xy, same.xz, same.yz)
        scale = 1.0 / same.size if same.size > 0.0 else 1.0
        _solve(room, same, axes, scale)
        for i in range(EVERY):
            plain = room[PLAIN + i]
            solved = (plain > 0.0) & (plain < room[BEST + i])
            if solved and not room[FACE + i] >= 0.0:
                room[FACE + i] = slowly_solved(form_of_lane(room, i, same), axes, scale, plain)
        for i in range(EVERY):
            plain = room[PLAIN + i]
            solved = (plain > 0.0) & (plain < room[BEST + i])
            room[FACE + i] = choose(solved, room[FACE + i], plain)
    for i in range(EVERY):
        room[FACE + i] = math.copysign(room[FACE + i], room[VALUE + i])


@helper
def surface_of_lanes(geometry: Geometry, surface: int, room: Floats) -> None:
    """FACE: signed bounds of the distances to a surface, as `nearest.bounds.surface_bound` up to BEST."""
    kind, row = integer(geometry, table.SURFACE_KIND, surface), integer(geometry, table.SURFACE_ROW, surface)
    if kind == PLANE:
        plane = load_plane(geometry, row)
        for i in range(EVERY):
            room[FACE + i] = plane_bound(form_of_plane(plane, room[X + i], room[Y + i], room[Z + i]))
    elif kind == SPHERE:
        sphere = load_sphere(geometry, row)
        for i in range(EVERY):
            room[FACE + i] = sphere_bound(form_of_sphere(sphere, room[X + i], room[Y + i], room[Z + i]), sphere.radius)
    else:
        _quadric(geometry, row, room)


@inline
def lane(i: int) -> Any:
    """The number of a lane as rows are counted."""
    return np.uint64(i)
