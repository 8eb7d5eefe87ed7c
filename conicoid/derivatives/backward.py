"""The transpose of `forward`: what is asked of crossings, handed back to rays and walls, by a kernel over them.

What crossings ask of their walls is added up in a fixed number of parts, in the order of the rays, whatever the number
of threads: so equal questions have equal answers to the bit.
"""

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
    CHANGE,
    MAP_AT,
    At,
    Crossings,
    WallRows,
    at_wall,
    inner,
    mapped,
    plus,
    row_of,
    scaled,
    times,
)
from .forms import FORM
from .forward import CHUNK, rows

_PARTS = 16


@shaped(t="n|0", points="n|0 3", normals="n|0 3", uv="n|0 2")
class Asked(NamedTuple):
    """What is asked of crossings, the weights in a sum; no rows where nothing is."""

    t: Floats
    points: Floats
    normals: Floats
    uv: Floats


@shaped(origins="n 3", directions="n 3", walls="w|0 22")
class Given(NamedTuple):
    """What that asks of rays, and of walls; the latter is added to what is there, and may have no rows."""

    origins: Floats
    directions: Floats
    walls: Floats


@inline
def _is_asked(asked: Asked, i: int) -> bool:
    """Is anything asked of crossing i?"""
    found = len(asked.t) > 0 and asked.t[i] != 0.0
    if len(asked.points) > 0:
        found |= asked.points[i, 0] != 0.0 or asked.points[i, 1] != 0.0 or asked.points[i, 2] != 0.0
    if len(asked.normals) > 0:
        found |= asked.normals[i, 0] != 0.0 or asked.normals[i, 1] != 0.0 or asked.normals[i, 2] != 0.0
    if len(asked.uv) > 0:
        found |= asked.uv[i, 0] != 0.0 or asked.uv[i, 1] != 0.0
    return found


@inline
def _of_normal(walls: WallRows, k: int, at: At, asked: Vector, side: float) -> Vector:
    """What is asked of d∇f / 2 where it is asked of the normal."""
    size = math.sqrt(inner(at.g, at.g))
    n = scaled(1.0 / size, at.g)
    return scaled(side / size, plus(asked, scaled(-inner(n, asked), n)))


@inline
def _of_uv(walls: WallRows, k: int, at: At, u: float, v: float) -> Vector:
    """What is asked of the three rows of the map where it is asked of uv."""
    if walls.angular[k] == 0:
        return u, v, 0.0
    a, b, _ = mapped(walls.numbers, k, MAP_AT, at.x, 1.0)
    turn = u / (2.0 * math.pi * (a * a + b * b))
    return -turn * b, turn * a, v


@inline
def _through_map(walls: WallRows, k: int, of_rows: Vector) -> Vector:
    """What is asked of dx where it is asked of the rows of the map."""
    w, p, q, s = walls.numbers, of_rows[0], of_rows[1], of_rows[2]
    a, b, c = MAP_AT, MAP_AT + 4, MAP_AT + 8
    return (
        p * w[k, a] + q * w[k, b] + s * w[k, c],
        p * w[k, a + 1] + q * w[k, b + 1] + s * w[k, c + 1],
        p * w[k, a + 2] + q * w[k, b + 2] + s * w[k, c + 2],
    )


@inline
def _add_form(sums: Floats, k: int, r: Vector, of_value: float, v: Vector) -> None:
    """What is asked of the ten numbers of a form by its value r·A r + 2 B·r + C, and v by its half gradient A r + B."""
    w = plus(scaled(of_value, r), v)
    for i in range(3):
        sums[k, i] += w[i] * r[i]
    p, q, s = scaled(of_value, r)
    sums[k, 3] += 2.0 * p * r[1] + (v[0] * r[1] + v[1] * r[0])
    sums[k, 4] += 2.0 * p * r[2] + (v[0] * r[2] + v[2] * r[0])
    sums[k, 5] += 2.0 * q * r[2] + (v[1] * r[2] + v[2] * r[1])
    sums[k, 6] += 2.0 * p + v[0]
    sums[k, 7] += 2.0 * q + v[1]
    sums[k, 8] += 2.0 * s + v[2]
    sums[k, 9] += of_value


@inline
def _add_map(sums: Floats, k: int, x: Vector, of_rows: Vector) -> None:
    """What is asked of the rows of a map: each a weight times (x, 1)."""
    for j in range(3):
        at = FORM + 4 * j
        for i in range(3):
            sums[k, at + i] += of_rows[j] * x[i]
        sums[k, at + 3] += of_rows[j]


@inline
def _put(given: Given, i: int, of_o: Vector, of_d: Vector) -> None:
    given.origins[i, 0], given.origins[i, 1], given.origins[i, 2] = of_o
    given.directions[i, 0], given.directions[i, 1], given.directions[i, 2] = of_d


@inline
def _hand_back(walls: WallRows, crossings: Crossings, asked: Asked, given: Given, i: int, k: int) -> None:
    """What crossing i asks of its ray and of wall k."""
    at = at_wall(walls, crossings, i, k)
    of_x, of_gradient = (0.0, 0.0, 0.0), (0.0, 0.0, 0.0)
    if len(asked.points) > 0:
        of_x = row_of(asked.points, i)
    if len(asked.normals) > 0:
        of_gradient = _of_normal(walls, k, at, row_of(asked.normals, i), crossings.side[i])
        of_x = plus(of_x, times(walls.numbers, k, of_gradient))
    if len(asked.uv) > 0:
        of_rows = _of_uv(walls, k, at, asked.uv[i, 0], asked.uv[i, 1])
        of_x = plus(of_x, _through_map(walls, k, of_rows))
        if len(given.walls) > 0:
            _add_map(given.walls, k, at.x, of_rows)
    of_t = inner(of_x, at.d) + (asked.t[i] if len(asked.t) > 0 else 0.0)
    share = -of_t / at.rate
    of_o = plus(of_x, scaled(share, at.g))
    _put(given, i, of_o, scaled(at.t, of_o))
    if len(given.walls) > 0:
        _add_form(given.walls, k, at.r, 0.5 * share, of_gradient)


@inline
def _put_unknown(asked: Asked, given: Given, i: int, k: int) -> None:
    """A crossing without derivative: nothing is known of its ray, nor of the form of its wall, nor by uv of the map."""
    nan = math.nan
    _put(given, i, (nan, nan, nan), (nan, nan, nan))
    if len(given.walls) > 0:
        by_uv = len(asked.uv) > 0 and (asked.uv[i, 0] != 0.0 or asked.uv[i, 1] != 0.0)
        for j in range(CHANGE if by_uv else FORM):
            given.walls[k, j] = nan


@kernel(given="out", begin="0..end", end="0..n")
def ask_crossings(
    walls: WallRows, crossings: Crossings, asked: Asked, begin: int, end: int, given: Given
) -> int:  # fmt: skip
    """Hand back what is asked of crossings begin to end; the first miss of which anything is, or -1.

    NaN for a crossing without derivative, and for its wall, where anything is asked of it.
    """
    missed = -1
    for i in range(begin, end):
        k = crossings.place[i]
        wanted = _is_asked(asked, i)
        if not wanted or k < 0 or k >= len(walls.numbers):
            _put(given, i, (0.0, 0.0, 0.0), (0.0, 0.0, 0.0))
            missed = i if wanted and missed < 0 else missed
        elif crossings.lost[i] != 0:
            _put_unknown(asked, given, i, k)
        else:
            _hand_back(walls, crossings, asked, given, i, k)
    return missed


def asked_by(walls: WallRows, crossings: Crossings, asked: Any, of_walls: bool) -> tuple[Given, int]:
    """(what crossings (n,) ask of rays (n, 3) and, if wanted, of walls (w, 22); the first miss that is asked, or -1).

    asked: of t (n,), points and normals (n, 3) and uv (n, 2); None where nothing is.
    """
    count, wide = len(crossings.t), len(walls.numbers)
    t, *others = asked
    wanted = Asked(rows(t, 1).reshape(-1), *(rows(part, width) for part, width in zip(others, (3, 3, 2), strict=True)))
    parts = max(1, min(_PARTS, count // max(CHUNK, 4 * wide)))
    sums = np.zeros((parts, wide if of_walls else 0, CHANGE))
    ends = [count * k // parts for k in range(parts + 1)]
    given = Given(np.empty((count, 3)), np.empty((count, 3)), sums[0])
    missed = [-1] * parts

    def work(first: int, last: int) -> None:
        for part in range(first, last):
            own = given._replace(walls=sums[part])
            missed[part] = ask_crossings(walls, crossings, wanted, ends[part], ends[part + 1], own)

    run_chunks(work, parts, 1)
    return given._replace(walls=sums.sum(axis=0)), max(missed, key=lambda k: (k >= 0, -k))


def unpacked(walls: FloatArray) -> tuple[FloatArray, FloatArray]:
    """(forms (w, 10), maps (w, 12)) of changes, or of what is asked of them."""
    return walls[:, :FORM], walls[:, FORM:]
