"""One crossing on a wall, and how it moves: the formulas, as kernels evaluate them.

On the wall f(x; p) = 0 with x = o + t d. So dt = -(f_p + ∇f·(do + t dd)) / (∇f·d), dx = do + t dd + d dt; the normal
n = ∇f / |∇f| turns by (d∇f - n (n·d∇f)) / |∇f| with d∇f = H dx + ∇f_p; and uv by the chain rule through its map.

A wall is a row of 25 numbers: its form and the form's anchor (`forms`), and three rows of four, its map to uv.
"""

from __future__ import annotations

import math
from typing import Any, NamedTuple

import numpy as np

from ..._jit.decorators import inline, kernel, record_shapes
from ..._util.arrays import FloatArray
from ...kernels.numbers.vectors import Vector, dot
from ...kernels.tables import Floats, Ints, Longs, Signs
from ...kernels.threads import run_chunks
from .quadric_form import FORM

WALL, CHANGE = 25, 22
"""Numbers of a wall, and of how it changes: its form and its map."""
ANCHOR, MAP_AT = FORM, FORM + 3
"""Where in a wall its anchor and its map begin; in a change the map follows the form."""


@record_shapes(place="n", side="n", lost="n", points="n 3", directions="n 3", t="n")
class CrossingRows(NamedTuple):
    """Crossings in the order of the rays."""

    place: Longs  # the row of the wall, -1 for a miss
    side: Ints  # +1 where the gradient points out of the body, -1 where into it
    lost: Signs  # 1: more than one wall is met, there is no derivative
    points: Floats
    directions: Floats
    t: Floats


@record_shapes(numbers="w 25", angular="w")
class WallRows(NamedTuple):
    """Walls by their rows."""

    numbers: Floats
    angular: Signs  # 1: u is an angle


class WallPoint(NamedTuple):
    """A crossing on its wall: the point, about the anchor too; half of ∇f is g, and half of ∇f·d is rate."""

    x: Vector
    r: Vector
    d: Vector
    t: float
    g: Vector
    rate: float


@inline
def scale_vector(factor: float, a: Vector) -> Vector:
    """factor a"""
    return factor * a[0], factor * a[1], factor * a[2]


@inline
def add_vectors(a: Vector, b: Vector) -> Vector:
    """a + b"""
    return a[0] + b[0], a[1] + b[1], a[2] + b[2]


@inline
def inner(a: Vector, b: Vector) -> float:
    """a·b"""
    return dot(a[0], a[1], a[2], b[0], b[1], b[2])


@inline
def row_of(rows: Floats, i: int) -> Vector:
    """Row i of an array of three columns."""
    return rows[i, 0], rows[i, 1], rows[i, 2]


@inline
def multiply_matrix(forms: Floats, k: int, v: Vector) -> Vector:
    """A v for the form in row k."""
    xy, xz, yz = forms[k, 3], forms[k, 4], forms[k, 5]
    return (
        forms[k, 0] * v[0] + xy * v[1] + xz * v[2],
        xy * v[0] + forms[k, 1] * v[1] + yz * v[2],
        xz * v[0] + yz * v[1] + forms[k, 2] * v[2],
    )


@inline
def half_gradient(forms: Floats, k: int, r: Vector) -> Vector:
    """Half of ∇f, A r + B."""
    return add_vectors(multiply_matrix(forms, k, r), (forms[k, 6], forms[k, 7], forms[k, 8]))


@inline
def at_wall(walls: WallRows, crossings: CrossingRows, i: int, k: int) -> WallPoint:
    """Crossing i on wall k."""
    w = walls.numbers
    x, d = row_of(crossings.points, i), row_of(crossings.directions, i)
    r = x[0] - w[k, ANCHOR], x[1] - w[k, ANCHOR + 1], x[2] - w[k, ANCHOR + 2]
    g = half_gradient(w, k, r)
    return WallPoint(x, r, d, crossings.t[i], g, inner(g, d))


@inline
def t_tangent(at: WallPoint, by_ray: Vector, by_wall: float) -> float:
    """dt where the point of the ray moves by do + t dd and f by f_p."""
    change = inner(at.g, by_ray) + 0.5 * by_wall
    return 0.0 - change / at.rate


@inline
def form_at(forms: Floats, k: int, r: Vector, half: Vector) -> float:
    """f at r, whose half gradient is known: r·(A r + B) + r·B + C."""
    value: float = inner(r, add_vectors(half, (forms[k, 6], forms[k, 7], forms[k, 8]))) + forms[k, 9]
    return value


@inline
def normal_tangent(walls: WallRows, k: int, at: WallPoint, dx: Vector, of_gradient: Vector, side: float) -> Vector:
    """dn of the unit normal that looks outward, where ∇f_p / 2 is known."""
    size = math.sqrt(inner(at.g, at.g))
    n = scale_vector(1.0 / size, at.g)
    dg = add_vectors(multiply_matrix(walls.numbers, k, dx), of_gradient)
    return scale_vector(side / size, add_vectors(dg, scale_vector(-inner(n, dg), n)))


@inline
def map_rows(rows: Floats, k: int, first: int, v: Vector, one: float) -> Vector:
    """Three rows of four, from a column on, of (v, one): a point with 1, a change with 0."""
    a, b, c = first, first + 4, first + 8
    return (
        rows[k, a] * v[0] + rows[k, a + 1] * v[1] + rows[k, a + 2] * v[2] + rows[k, a + 3] * one,
        rows[k, b] * v[0] + rows[k, b + 1] * v[1] + rows[k, b + 2] * v[2] + rows[k, b + 3] * one,
        rows[k, c] * v[0] + rows[k, c + 1] * v[1] + rows[k, c + 2] * v[2] + rows[k, c + 3] * one,
    )


@inline
def uv_tangent(angular: bool, own: Vector, change: Vector) -> tuple[float, float]:
    """(du, dv): u is the angle of (a, b) in turns and v is c, or u is a and v is b."""
    if not angular:
        return change[0], change[1]
    a, b, _ = own
    return (a * change[1] - b * change[0]) / (2.0 * math.pi * (a * a + b * b)), change[2]


# How crossings move where rays and walls change: a kernel over the crossings (`crossing` has the formulas).

CHUNK = 8192


@record_shapes(walls="w|0 22", origins="n|0 3", directions="n|0 3")
class InputTangents(NamedTuple):
    """How walls, origins and directions change; no rows where they stay."""

    walls: Floats
    origins: Floats
    directions: Floats


@record_shapes(t="n", points="n|0 3", normals="n|0 3", uv="n|0 2")
class CrossingTangents(NamedTuple):
    """How crossings change; no rows for what is not asked for. NaN where there is no derivative, and of misses."""

    t: Floats
    points: Floats
    normals: Floats
    uv: Floats


@inline
def _put_row(rows: Floats, i: int, v: Vector) -> None:
    rows[i, 0], rows[i, 1], rows[i, 2] = v[0] + 0.0, v[1] + 0.0, v[2] + 0.0


@inline
def _put_unknown_tangent(moved: CrossingTangents, i: int) -> None:
    nan = math.nan
    moved.t[i] = nan
    if len(moved.points) > 0:
        _put_row(moved.points, i, (nan, nan, nan))
    if len(moved.normals) > 0:
        _put_row(moved.normals, i, (nan, nan, nan))
    if len(moved.uv) > 0:
        moved.uv[i, 0], moved.uv[i, 1] = nan, nan


@inline
def _put_fields(
    walls: WallRows,
    changes: InputTangents,
    moved: CrossingTangents,
    i: int,
    k: int,
    at: WallPoint,
    dx: Vector,
    of_gradient: Vector,
    side: float,
) -> None:
    """What of a crossing changes besides t, where its point moves by dx."""
    if len(moved.points) > 0:
        _put_row(moved.points, i, dx)
    if len(moved.normals) > 0:
        _put_row(moved.normals, i, normal_tangent(walls, k, at, dx, of_gradient, side))
    if len(moved.uv) > 0:
        own, change = map_rows(walls.numbers, k, MAP_AT, at.x, 1.0), map_rows(walls.numbers, k, MAP_AT, dx, 0.0)
        if len(changes.walls) > 0:
            change = add_vectors(change, map_rows(changes.walls, k, FORM, at.x, 1.0))
        du, dv = uv_tangent(walls.angular[k] != 0, own, change)
        moved.uv[i, 0], moved.uv[i, 1] = du + 0.0, dv + 0.0


@kernel(moved="out", begin="0..end", end="0..n")
def move_crossings(
    walls: WallRows, crossings: CrossingRows, changes: InputTangents, begin: int, end: int, moved: CrossingTangents
) -> None:  # fmt: skip
    """How crossings begin to end change."""
    for i in range(begin, end):
        k = crossings.place[i]
        if k < 0 or k >= len(walls.numbers) or crossings.lost[i] != 0:
            _put_unknown_tangent(moved, i)
            continue
        at = at_wall(walls, crossings, i, k)
        by_ray, by_wall, of_gradient = (0.0, 0.0, 0.0), 0.0, (0.0, 0.0, 0.0)
        if len(changes.origins) > 0:
            by_ray = row_of(changes.origins, i)
        if len(changes.directions) > 0:
            by_ray = add_vectors(by_ray, scale_vector(at.t, row_of(changes.directions, i)))
        if len(changes.walls) > 0:
            of_gradient = half_gradient(changes.walls, k, at.r)
            by_wall = form_at(changes.walls, k, at.r, of_gradient)
        dt = t_tangent(at, by_ray, by_wall)
        moved.t[i] = dt
        _put_fields(
            walls, changes, moved, i, k, at, add_vectors(by_ray, scale_vector(dt, at.d)), of_gradient, crossings.side[i]
        )


def push_forward(walls: WallRows, crossings: CrossingRows, changes: Any, fields: bool) -> CrossingTangents:
    """How crossings (n,) change; t alone, or the other `fields` too.

    changes: of the walls (w, 22), origins and directions (n, 3), each None where nothing changes.
    """
    count = len(crossings.t)
    changed = InputTangents(*(as_kernel_rows(part, width) for part, width in zip(changes, (22, 3, 3), strict=True)))
    more = count if fields else 0
    moved = CrossingTangents(np.empty(count), *(np.empty((more, width)) for width in (3, 3, 2)))
    run_chunks(lambda begin, end: move_crossings(walls, crossings, changed, begin, end, moved), count, CHUNK)
    return moved


def as_kernel_rows(array: FloatArray | None, width: int) -> FloatArray:
    """An array of numbers as kernels take it; no rows for None."""
    found: FloatArray = as_kernel_array(np.empty((0, width)) if array is None else np.asarray(array, np.float64))
    return found


def as_kernel_array(array: Any) -> Any:
    """An array as kernels of this folder take it: contiguous, and read-only, as fields of answers may be.

    Compilers make a kernel anew for arrays that may be written.
    """
    view = np.ascontiguousarray(array).view()
    view.flags.writeable = False
    return view


def make_crossing_rows(*columns: Any) -> CrossingRows:
    """Crossings from the columns of `Crossings`."""
    return CrossingRows(*map(as_kernel_array, columns))


# The transpose of `forward`: what is asked of crossings, handed back to rays and walls, by a kernel over them.
#
# What crossings ask of their walls is added up in a fixed number of parts, in the order of the rays, whatever the
# number
# of threads: so equal questions have equal answers to the bit.

_PARTS = 16


@record_shapes(t="n|0", points="n|0 3", normals="n|0 3", uv="n|0 2")
class CrossingCotangents(NamedTuple):
    """What is asked of crossings, the weights in a sum; no rows where nothing is."""

    t: Floats
    points: Floats
    normals: Floats
    uv: Floats


@record_shapes(origins="n 3", directions="n 3", walls="w|0 22")
class InputCotangents(NamedTuple):
    """What that asks of rays, and of walls; the latter is added to what is there, and may have no rows."""

    origins: Floats
    directions: Floats
    walls: Floats


@inline
def _has_cotangent(asked: CrossingCotangents, i: int) -> bool:
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
def _normal_cotangent(walls: WallRows, k: int, at: WallPoint, asked: Vector, side: float) -> Vector:
    """What is asked of d∇f / 2 where it is asked of the normal."""
    size = math.sqrt(inner(at.g, at.g))
    n = scale_vector(1.0 / size, at.g)
    return scale_vector(side / size, add_vectors(asked, scale_vector(-inner(n, asked), n)))


@inline
def _uv_cotangent(walls: WallRows, k: int, at: WallPoint, u: float, v: float) -> Vector:
    """What is asked of the three rows of the map where it is asked of uv."""
    if walls.angular[k] == 0:
        return u, v, 0.0
    a, b, _ = map_rows(walls.numbers, k, MAP_AT, at.x, 1.0)
    turn = u / (2.0 * math.pi * (a * a + b * b))
    return -turn * b, turn * a, v


@inline
def _map_cotangent(walls: WallRows, k: int, of_rows: Vector) -> Vector:
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
    w = add_vectors(scale_vector(of_value, r), v)
    for i in range(3):
        sums[k, i] += w[i] * r[i]
    p, q, s = scale_vector(of_value, r)
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
def _put_ray_cotangent(given: InputCotangents, i: int, of_o: Vector, of_d: Vector) -> None:
    given.origins[i, 0], given.origins[i, 1], given.origins[i, 2] = of_o
    given.directions[i, 0], given.directions[i, 1], given.directions[i, 2] = of_d


@inline
def _hand_back(
    walls: WallRows, crossings: CrossingRows, asked: CrossingCotangents, given: InputCotangents, i: int, k: int
) -> None:
    """What crossing i asks of its ray and of wall k."""
    at = at_wall(walls, crossings, i, k)
    of_x, of_gradient = (0.0, 0.0, 0.0), (0.0, 0.0, 0.0)
    if len(asked.points) > 0:
        of_x = row_of(asked.points, i)
    if len(asked.normals) > 0:
        of_gradient = _normal_cotangent(walls, k, at, row_of(asked.normals, i), crossings.side[i])
        of_x = add_vectors(of_x, multiply_matrix(walls.numbers, k, of_gradient))
    if len(asked.uv) > 0:
        of_rows = _uv_cotangent(walls, k, at, asked.uv[i, 0], asked.uv[i, 1])
        of_x = add_vectors(of_x, _map_cotangent(walls, k, of_rows))
        if len(given.walls) > 0:
            _add_map(given.walls, k, at.x, of_rows)
    of_t = inner(of_x, at.d) + (asked.t[i] if len(asked.t) > 0 else 0.0)
    share = -of_t / at.rate
    of_o = add_vectors(of_x, scale_vector(share, at.g))
    _put_ray_cotangent(given, i, of_o, scale_vector(at.t, of_o))
    if len(given.walls) > 0:
        _add_form(given.walls, k, at.r, 0.5 * share, of_gradient)


@inline
def _put_unknown_cotangent(asked: CrossingCotangents, given: InputCotangents, i: int, k: int) -> None:
    """A crossing without derivative: nothing is known of its ray, nor of the form of its wall, nor by uv of the map."""
    nan = math.nan
    _put_ray_cotangent(given, i, (nan, nan, nan), (nan, nan, nan))
    if len(given.walls) > 0:
        by_uv = len(asked.uv) > 0 and (asked.uv[i, 0] != 0.0 or asked.uv[i, 1] != 0.0)
        for j in range(CHANGE if by_uv else FORM):
            given.walls[k, j] = nan


@kernel(given="out", begin="0..end", end="0..n")
def ask_crossings(
    walls: WallRows, crossings: CrossingRows, asked: CrossingCotangents, begin: int, end: int, given: InputCotangents
) -> int:  # fmt: skip
    """Hand back what is asked of crossings begin to end; the first miss of which anything is, or -1.

    NaN for a crossing without derivative, and for its wall, where anything is asked of it.
    """
    missed = -1
    for i in range(begin, end):
        k = crossings.place[i]
        wanted = _has_cotangent(asked, i)
        if not wanted or k < 0 or k >= len(walls.numbers):
            _put_ray_cotangent(given, i, (0.0, 0.0, 0.0), (0.0, 0.0, 0.0))
            missed = i if wanted and missed < 0 else missed
        elif crossings.lost[i] != 0:
            _put_unknown_cotangent(asked, given, i, k)
        else:
            _hand_back(walls, crossings, asked, given, i, k)
    return missed


def pull_back(walls: WallRows, crossings: CrossingRows, asked: Any, of_walls: bool) -> tuple[InputCotangents, int]:
    """(what crossings (n,) ask of rays (n, 3) and, if wanted, of walls (w, 22); the first miss that is asked, or -1).

    asked: of t (n,), points and normals (n, 3) and uv (n, 2); None where nothing is.
    """
    count, wide = len(crossings.t), len(walls.numbers)
    t, *others = asked
    wanted = CrossingCotangents(
        as_kernel_rows(t, 1).reshape(-1),
        *(as_kernel_rows(part, width) for part, width in zip(others, (3, 3, 2), strict=True)),
    )
    parts = max(1, min(_PARTS, count // max(CHUNK, 4 * wide)))
    sums = np.zeros((parts, wide if of_walls else 0, CHANGE))
    ends = [count * k // parts for k in range(parts + 1)]
    given = InputCotangents(np.empty((count, 3)), np.empty((count, 3)), sums[0])
    missed = [-1] * parts

    def work(first: int, last: int) -> None:
        for part in range(first, last):
            own = given._replace(walls=sums[part])
            missed[part] = ask_crossings(walls, crossings, wanted, ends[part], ends[part + 1], own)

    run_chunks(work, parts, 1)
    return given._replace(walls=sums.sum(axis=0)), max(missed, key=lambda k: (k >= 0, -k))


def split_forms_maps(walls: FloatArray) -> tuple[FloatArray, FloatArray]:
    """(forms (w, 10), maps (w, 12)) of changes, or of what is asked of them."""
    return walls[:, :FORM], walls[:, FORM:]
