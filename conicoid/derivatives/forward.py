"""How crossings move where rays and walls change: a kernel over the crossings (`crossing` has the formulas)."""

from __future__ import annotations

import math
from typing import Any, NamedTuple

import numpy as np

from ..compiler.jit import inline, kernel
from ..compiler.shapes import shaped
from ..engine.numbers.vectors import Vector
from ..engine.tables import Floats
from ..engine.threads import run_chunks
from ..shapes.vector import FloatArray
from .crossing import (
    MAP_AT,
    At,
    Crossings,
    WallRows,
    at_wall,
    form_at,
    half_gradient,
    mapped,
    normal_moved,
    plus,
    row_of,
    scaled,
    time_moved,
    uv_moved,
)
from .forms import FORM

CHUNK = 8192


@shaped(walls="w|0 22", origins="n|0 3", directions="n|0 3")
class Changes(NamedTuple):
    """How walls, origins and directions change; no rows where they stay."""

    walls: Floats
    origins: Floats
    directions: Floats


@shaped(t="n", points="n|0 3", normals="n|0 3", uv="n|0 2")
class Moved(NamedTuple):
    """How crossings change; no rows for what is not asked for. NaN where there is no derivative, and of misses."""

    t: Floats
    points: Floats
    normals: Floats
    uv: Floats


@inline
def _put(rows: Floats, i: int, v: Vector) -> None:
    rows[i, 0], rows[i, 1], rows[i, 2] = v[0] + 0.0, v[1] + 0.0, v[2] + 0.0


@inline
def _put_unknown(moved: Moved, i: int) -> None:
    nan = math.nan
    moved.t[i] = nan
    if len(moved.points) > 0:
        _put(moved.points, i, (nan, nan, nan))
    if len(moved.normals) > 0:
        _put(moved.normals, i, (nan, nan, nan))
    if len(moved.uv) > 0:
        moved.uv[i, 0], moved.uv[i, 1] = nan, nan


@inline
def _put_fields(
    walls: WallRows, changes: Changes, moved: Moved, i: int, k: int, at: At, dx: Vector, of_gradient: Vector,
    side: float,
) -> None:  # fmt: skip
    """What of a crossing changes besides t, where its point moves by dx."""
    if len(moved.points) > 0:
        _put(moved.points, i, dx)
    if len(moved.normals) > 0:
        _put(moved.normals, i, normal_moved(walls, k, at, dx, of_gradient, side))
    if len(moved.uv) > 0:
        own, change = mapped(walls.numbers, k, MAP_AT, at.x, 1.0), mapped(walls.numbers, k, MAP_AT, dx, 0.0)
        if len(changes.walls) > 0:
            change = plus(change, mapped(changes.walls, k, FORM, at.x, 1.0))
        du, dv = uv_moved(walls.angular[k] != 0, own, change)
        moved.uv[i, 0], moved.uv[i, 1] = du + 0.0, dv + 0.0


@kernel(moved="out", begin="0..end", end="0..n")
def move_crossings(
    walls: WallRows, crossings: Crossings, changes: Changes, begin: int, end: int, moved: Moved
) -> None:  # fmt: skip
    """How crossings begin to end change."""
    for i in range(begin, end):
        k = crossings.place[i]
        if k < 0 or k >= len(walls.numbers) or crossings.lost[i] != 0:
            _put_unknown(moved, i)
            continue
        at = at_wall(walls, crossings, i, k)
        by_ray, by_wall, of_gradient = (0.0, 0.0, 0.0), 0.0, (0.0, 0.0, 0.0)
        if len(changes.origins) > 0:
            by_ray = row_of(changes.origins, i)
        if len(changes.directions) > 0:
            by_ray = plus(by_ray, scaled(at.t, row_of(changes.directions, i)))
        if len(changes.walls) > 0:
            of_gradient = half_gradient(changes.walls, k, at.r)
            by_wall = form_at(changes.walls, k, at.r, of_gradient)
        dt = time_moved(at, by_ray, by_wall)
        moved.t[i] = dt
        _put_fields(walls, changes, moved, i, k, at, plus(by_ray, scaled(dt, at.d)), of_gradient, crossings.side[i])


def moved_by(walls: WallRows, crossings: Crossings, changes: Any, fields: bool) -> Moved:
    """How crossings (n,) change; t alone, or the other `fields` too.

    changes: of the walls (w, 22), origins and directions (n, 3), each None where nothing changes.
    """
    count = len(crossings.t)
    changed = Changes(*(rows(part, width) for part, width in zip(changes, (22, 3, 3), strict=True)))
    more = count if fields else 0
    moved = Moved(np.empty(count), *(np.empty((more, width)) for width in (3, 3, 2)))
    run_chunks(lambda begin, end: move_crossings(walls, crossings, changed, begin, end, moved), count, CHUNK)
    return moved


def rows(array: FloatArray | None, width: int) -> FloatArray:
    """An array of numbers as kernels take it; no rows for None."""
    found: FloatArray = given(np.empty((0, width)) if array is None else np.asarray(array, np.float64))
    return found


def given(array: Any) -> Any:
    """An array as kernels of this folder take it: contiguous, and read-only, as fields of answers may be.

    Compilers make a kernel anew for arrays that may be written.
    """
    view = np.ascontiguousarray(array).view()
    view.flags.writeable = False
    return view


def crossings_at(*columns: Any) -> Crossings:
    """Crossings from the columns of `Crossings`."""
    return Crossings(*map(given, columns))
