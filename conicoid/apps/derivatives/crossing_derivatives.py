"""Derivatives of crossings on walls, forward (`push_forward`) and reverse (`pull_back`), as kernels over the crossings.

The implicit function theorem gives them. On the wall, f(x; p) = 0 with x = o + t d. Hence
dt = -(f_p + ∇f·(do + t dd)) / (∇f·d) and dx = do + t dd + d dt. The normal n = ∇f / |∇f| changes by
(d∇f - n (n·d∇f)) / |∇f| with d∇f = H dx + ∇f_p, and uv by the chain rule through its map.
A wall is a row of 25 numbers: its form, the anchor of the form (`quadric_form`), and its map to uv, three rows of four.
"""

from __future__ import annotations

import math
from typing import Any, NamedTuple

import numpy as np

from ..._jit.decorators import inline, kernel, record_shapes
from ..._util.records import FloatArray
from ...kernels.numbers.vectors import Vector, dot
from ...kernels.tables import Floats, Ints, Longs, Signs
from ...kernels.threads import KernelRange, run_calls, run_chunks
from .quadric_form import FORM

WALL, CHANGE = 25, 22
"""Lengths of the row of a wall, and of its tangent, which has the form and the map but no anchor."""
ANCHOR, MAP_AT = FORM, FORM + 3
"""First columns of the anchor and of the map in the row of a wall. In a tangent the map follows the form."""


@record_shapes(place="n", side="n", lost="n", points="n 3", directions="n 3", t="n")
class CrossingRows(NamedTuple):
    """Crossings, one row each, in the order of the rays."""

    place: Longs  # the row of the wall, -1 for a miss
    side: Ints  # +1 where the gradient points out of the body, -1 where it points into it
    lost: Signs  # 1: the crossing is on more than one wall, so it has no derivative
    points: Floats
    directions: Floats
    t: Floats


@record_shapes(numbers="w 25", angular="w")
class WallRows(NamedTuple):
    """Walls, one row each."""

    numbers: Floats
    angular: Signs  # 1: u is an angle in turns


class WallPoint(NamedTuple):
    """A crossing on its wall: the point x, r = x - anchor, the direction, t, g = ∇f / 2 and rate = ∇f·d / 2."""

    x: Vector
    r: Vector
    d: Vector
    t: float
    g: Vector
    rate: float


@inline
def scale_vector(factor: float, a: Vector) -> Vector:
    """Return factor a."""
    return factor * a[0], factor * a[1], factor * a[2]


@inline
def add_vectors(a: Vector, b: Vector) -> Vector:
    """Return a + b."""
    return a[0] + b[0], a[1] + b[1], a[2] + b[2]


@inline
def inner(a: Vector, b: Vector) -> float:
    """Return a·b."""
    return dot(a[0], a[1], a[2], b[0], b[1], b[2])


@inline
def row_of(rows: Floats, i: int) -> Vector:
    """Return row i of an array of three columns."""
    return rows[i, 0], rows[i, 1], rows[i, 2]


@inline
def multiply_matrix(forms: Floats, k: int, v: Vector) -> Vector:
    """Return A v for the form in row k."""
    xy, xz, yz = forms[k, 3], forms[k, 4], forms[k, 5]
    return (
        forms[k, 0] * v[0] + xy * v[1] + xz * v[2],
        xy * v[0] + forms[k, 1] * v[1] + yz * v[2],
        xz * v[0] + yz * v[1] + forms[k, 2] * v[2],
    )


@inline
def half_gradient(forms: Floats, k: int, r: Vector) -> Vector:
    """Return ∇f / 2 = A r + B for the form in row k."""
    return add_vectors(multiply_matrix(forms, k, r), (forms[k, 6], forms[k, 7], forms[k, 8]))


@inline
def at_wall(walls: WallRows, crossings: CrossingRows, i: int, k: int) -> WallPoint:
    """Evaluate crossing i on wall k."""
    w = walls.numbers
    x, d = row_of(crossings.points, i), row_of(crossings.directions, i)
    # Forms are written about the anchor, which is near the wall.
    r = x[0] - w[k, ANCHOR], x[1] - w[k, ANCHOR + 1], x[2] - w[k, ANCHOR + 2]
    g = half_gradient(w, k, r)
    return WallPoint(x, r, d, crossings.t[i], g, inner(g, d))


@inline
def t_tangent(at: WallPoint, by_ray: Vector, by_wall: float) -> float:
    """Return dt from `by_ray` = do + t dd and `by_wall` = f_p."""
    change = inner(at.g, by_ray) + 0.5 * by_wall  # half of the numerator: g and rate are halves too
    return 0.0 - change / at.rate


@inline
def form_at(forms: Floats, k: int, r: Vector, half: Vector) -> float:
    """Return f(r) = r·(A r + B) + r·B + C, where `half` = A r + B is known."""
    return inner(r, add_vectors(half, (forms[k, 6], forms[k, 7], forms[k, 8]))) + forms[k, 9]


@inline
def normal_tangent(walls: WallRows, k: int, at: WallPoint, dx: Vector, of_gradient: Vector, side: float) -> Vector:
    """Return dn of the outward unit normal, from dx and `of_gradient` = ∇f_p / 2."""
    size = math.sqrt(inner(at.g, at.g))
    n = scale_vector(1.0 / size, at.g)
    # d∇f = H dx + ∇f_p, halved like g. Its part along n changes the length of ∇f only, not n.
    dg = add_vectors(multiply_matrix(walls.numbers, k, dx), of_gradient)
    return scale_vector(side / size, add_vectors(dg, scale_vector(-inner(n, dg), n)))


@inline
def map_rows(rows: Floats, k: int, first: int, v: Vector, one: float) -> Vector:
    """Apply three rows of four, from column `first` on, to (v, one): one = 1 for a point, 0 for a tangent."""
    a, b, c = first, first + 4, first + 8
    return (
        rows[k, a] * v[0] + rows[k, a + 1] * v[1] + rows[k, a + 2] * v[2] + rows[k, a + 3] * one,
        rows[k, b] * v[0] + rows[k, b + 1] * v[1] + rows[k, b + 2] * v[2] + rows[k, b + 3] * one,
        rows[k, c] * v[0] + rows[k, c + 1] * v[1] + rows[k, c + 2] * v[2] + rows[k, c + 3] * one,
    )


@inline
def uv_tangent(angular: bool, own: Vector, change: Vector) -> tuple[float, float]:
    """Return (du, dv). An angular map has u = angle of (a, b) in turns and v = c; a flat one has u = a and v = b."""
    if not angular:
        return change[0], change[1]
    a, b, _ = own
    return (a * change[1] - b * change[0]) / (2.0 * math.pi * (a * a + b * b)), change[2]


# --- Forward mode: tangents of rays and walls -> tangents of crossings

CHUNK = 8192
"""Crossings that a thread takes at a time."""


@record_shapes(walls="w|0 22", origins="n|0 3", directions="n|0 3")
class InputTangents(NamedTuple):
    """Tangents of walls, origins and directions. An array without rows stands for no change."""

    walls: Floats
    origins: Floats
    directions: Floats


@record_shapes(t="n", points="n|0 3", normals="n|0 3", uv="n|0 2")
class CrossingTangents(NamedTuple):
    """Tangents of crossings; no rows for fields that are not computed. NaN for misses and where none exists."""

    t: Floats
    points: Floats
    normals: Floats
    uv: Floats


@inline
def _put_row(rows: Floats, i: int, v: Vector) -> None:
    """Store v in row i; adding 0.0 turns -0.0 into 0.0."""
    rows[i, 0], rows[i, 1], rows[i, 2] = v[0] + 0.0, v[1] + 0.0, v[2] + 0.0


@inline
def _put_unknown_tangent(tangents: CrossingTangents, i: int) -> None:
    """Store NaN in every field of crossing i."""
    nan = math.nan
    tangents.t[i] = nan
    if len(tangents.points) > 0:
        _put_row(tangents.points, i, (nan, nan, nan))
    if len(tangents.normals) > 0:
        _put_row(tangents.normals, i, (nan, nan, nan))
    if len(tangents.uv) > 0:
        tangents.uv[i, 0], tangents.uv[i, 1] = nan, nan


@inline
def _put_fields(
    walls: WallRows,
    changes: InputTangents,
    tangents: CrossingTangents,
    i: int,
    k: int,
    at: WallPoint,
    dx: Vector,
    of_gradient: Vector,
    side: float,
) -> None:
    """Store the tangents of crossing i besides that of t, where its point moves by dx."""
    if len(tangents.points) > 0:
        _put_row(tangents.points, i, dx)
    if len(tangents.normals) > 0:
        _put_row(tangents.normals, i, normal_tangent(walls, k, at, dx, of_gradient, side))
    if len(tangents.uv) > 0:
        # The map takes world coordinates, unlike the form.
        own, change = map_rows(walls.numbers, k, MAP_AT, at.x, 1.0), map_rows(walls.numbers, k, MAP_AT, dx, 0.0)
        if len(changes.walls) > 0:
            change = add_vectors(change, map_rows(changes.walls, k, FORM, at.x, 1.0))  # the map itself changes too
        du, dv = uv_tangent(walls.angular[k] != 0, own, change)
        tangents.uv[i, 0], tangents.uv[i, 1] = du + 0.0, dv + 0.0


@kernel(moved="out", begin="0..end", end="0..n")
def move_crossings(
    walls: WallRows, crossings: CrossingRows, changes: InputTangents, begin: int, end: int, moved: CrossingTangents
) -> None:  # fmt: skip
    """Compute the tangents of the crossings `begin` to `end`."""
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
    """Return the tangents of crossings (n,): of t alone, or with `fields` of point, normal and uv too.

    changes: the tangents of walls (w, 22), origins and directions (n, 3); None for no change.
    """
    count = len(crossings.t)
    inputs = InputTangents(*(as_kernel_rows(part, width) for part, width in zip(changes, (22, 3, 3), strict=True)))
    more = count if fields else 0
    tangents = CrossingTangents(np.empty(count), *(np.empty((more, width)) for width in (3, 3, 2)))
    run_chunks(KernelRange(move_crossings, (walls, crossings, inputs), (tangents,)), count, CHUNK)
    return tangents


def as_kernel_rows(array: FloatArray | None, width: int) -> FloatArray:
    """Return an array as kernels take it, with no rows for None."""
    return as_kernel_array(np.empty((0, width)) if array is None else np.asarray(array, np.float64))


def as_kernel_array(array: Any) -> Any:
    """Return a contiguous read-only view, as the kernels of this package take arrays.

    Fields of results may be read-only. Always passing read-only arrays avoids a second compilation of every kernel for
    writable ones.
    """
    view = np.ascontiguousarray(array).view()
    view.flags.writeable = False
    return view


def make_crossing_rows(*columns: Any) -> CrossingRows:
    """Build `CrossingRows` from its columns, in the order of its fields."""
    return CrossingRows(*map(as_kernel_array, columns))


# --- Reverse mode, the transpose: cotangents of crossings -> cotangents of rays and walls
#
# The cotangents of walls are summed in a fixed number of parts, in the order of the rays, whatever the number of
# threads. So the sums are reproducible to the bit.

_PARTS = 16
"""Partial sums at most."""


@record_shapes(t="n|0", points="n|0 3", normals="n|0 3", uv="n|0 2")
class CrossingCotangents(NamedTuple):
    """Cotangents of crossings: the weights of their fields in a sum. An array without rows stands for zeros."""

    t: Floats
    points: Floats
    normals: Floats
    uv: Floats


@record_shapes(origins="n 3", directions="n 3", walls="w|0 22")
class InputCotangents(NamedTuple):
    """Cotangents of rays, and of walls. Those of walls are added to the array, which may have no rows."""

    origins: Floats
    directions: Floats
    walls: Floats


@inline
def _has_cotangent(cotangents: CrossingCotangents, i: int) -> bool:
    """Return whether any cotangent of crossing i is not zero."""
    nonzero = len(cotangents.t) > 0 and cotangents.t[i] != 0.0
    if len(cotangents.points) > 0:
        nonzero |= cotangents.points[i, 0] != 0.0 or cotangents.points[i, 1] != 0.0 or cotangents.points[i, 2] != 0.0
    if len(cotangents.normals) > 0:
        nonzero |= cotangents.normals[i, 0] != 0.0 or cotangents.normals[i, 1] != 0.0 or cotangents.normals[i, 2] != 0.0
    if len(cotangents.uv) > 0:
        nonzero |= cotangents.uv[i, 0] != 0.0 or cotangents.uv[i, 1] != 0.0
    return nonzero


@inline
def _normal_cotangent(at: WallPoint, cotangent: Vector, side: float) -> Vector:
    """Return the cotangent of d∇f / 2 from that of the normal."""
    size = math.sqrt(inner(at.g, at.g))
    n = scale_vector(1.0 / size, at.g)
    return scale_vector(side / size, add_vectors(cotangent, scale_vector(-inner(n, cotangent), n)))


@inline
def _uv_cotangent(walls: WallRows, k: int, at: WallPoint, u: float, v: float) -> Vector:
    """Return the cotangent of the three rows of the map from that of uv, (u, v)."""
    if walls.angular[k] == 0:
        return u, v, 0.0
    a, b, _ = map_rows(walls.numbers, k, MAP_AT, at.x, 1.0)
    turn = u / (2.0 * math.pi * (a * a + b * b))
    return -turn * b, turn * a, v


@inline
def _map_cotangent(walls: WallRows, k: int, of_rows: Vector) -> Vector:
    """Return the cotangent of dx from that of the rows of the map."""
    w, p, q, s = walls.numbers, of_rows[0], of_rows[1], of_rows[2]
    a, b, c = MAP_AT, MAP_AT + 4, MAP_AT + 8
    return (
        p * w[k, a] + q * w[k, b] + s * w[k, c],
        p * w[k, a + 1] + q * w[k, b + 1] + s * w[k, c + 1],
        p * w[k, a + 2] + q * w[k, b + 2] + s * w[k, c + 2],
    )


@inline
def _add_form(sums: Floats, k: int, r: Vector, of_value: float, v: Vector) -> None:
    """Add the cotangent of the ten numbers of form k.

    of_value is the cotangent of f = r·A r + 2 B·r + C, and v that of the half gradient A r + B.
    """
    # r·A r and A r use a mixed number of A twice: in the sum, and in two components.
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
    """Add the cotangent of map k: each row gets its weight times (x, 1)."""
    for j in range(3):
        at = FORM + 4 * j
        for i in range(3):
            sums[k, at + i] += of_rows[j] * x[i]
        sums[k, at + 3] += of_rows[j]


@inline
def _put_ray_cotangent(result: InputCotangents, i: int, of_o: Vector, of_d: Vector) -> None:
    """Store the cotangents of origin and direction of ray i."""
    result.origins[i, 0], result.origins[i, 1], result.origins[i, 2] = of_o
    result.directions[i, 0], result.directions[i, 1], result.directions[i, 2] = of_d


@inline
def _pull_back_crossing(
    walls: WallRows, crossings: CrossingRows, cotangents: CrossingCotangents, result: InputCotangents, i: int, k: int
) -> None:
    """Pull the cotangents of crossing i back to its ray and to wall k."""
    at = at_wall(walls, crossings, i, k)
    of_x, of_gradient = (0.0, 0.0, 0.0), (0.0, 0.0, 0.0)
    if len(cotangents.points) > 0:
        of_x = row_of(cotangents.points, i)
    if len(cotangents.normals) > 0:
        of_gradient = _normal_cotangent(at, row_of(cotangents.normals, i), crossings.side[i])
        of_x = add_vectors(of_x, multiply_matrix(walls.numbers, k, of_gradient))
    if len(cotangents.uv) > 0:
        of_rows = _uv_cotangent(walls, k, at, cotangents.uv[i, 0], cotangents.uv[i, 1])
        of_x = add_vectors(of_x, _map_cotangent(walls, k, of_rows))
        if len(result.walls) > 0:
            _add_map(result.walls, k, at.x, of_rows)
    # x depends on the ray at constant t and through t, and t depends on ray and wall by `t_tangent`.
    of_t = inner(of_x, at.d) + (cotangents.t[i] if len(cotangents.t) > 0 else 0.0)
    share = -of_t / at.rate
    of_o = add_vectors(of_x, scale_vector(share, at.g))
    _put_ray_cotangent(result, i, of_o, scale_vector(at.t, of_o))
    if len(result.walls) > 0:
        _add_form(result.walls, k, at.r, 0.5 * share, of_gradient)


@inline
def _put_unknown_cotangent(cotangents: CrossingCotangents, result: InputCotangents, i: int, k: int) -> None:
    """Store NaN for a crossing without derivative: for its ray, the form of its wall and, if uv counts, the map."""
    nan = math.nan
    _put_ray_cotangent(result, i, (nan, nan, nan), (nan, nan, nan))
    if len(result.walls) > 0:
        # The cotangent of the map comes from that of uv alone.
        by_uv = len(cotangents.uv) > 0 and (cotangents.uv[i, 0] != 0.0 or cotangents.uv[i, 1] != 0.0)
        for j in range(CHANGE if by_uv else FORM):
            result.walls[k, j] = nan


@kernel(inputs="out", begin="0..end", end="0..n")
def pull_back_crossings(
    walls: WallRows, crossings: CrossingRows, weights: CrossingCotangents, begin: int, end: int, inputs: InputCotangents
) -> int:  # fmt: skip
    """Pull back the cotangents of the crossings `begin` to `end`. Return the first miss with a cotangent, or -1.

    A crossing without derivative gives NaN to its ray and its wall, unless its cotangents are all zero.
    """
    miss = -1
    for i in range(begin, end):
        k = crossings.place[i]
        nonzero = _has_cotangent(weights, i)
        if not nonzero or k < 0 or k >= len(walls.numbers):
            _put_ray_cotangent(inputs, i, (0.0, 0.0, 0.0), (0.0, 0.0, 0.0))
            miss = i if nonzero and miss < 0 else miss
        elif crossings.lost[i] != 0:
            _put_unknown_cotangent(weights, inputs, i, k)
        else:
            _pull_back_crossing(walls, crossings, weights, inputs, i, k)
    return miss


def pull_back(walls: WallRows, crossings: CrossingRows, cotangents: Any, of_walls: bool) -> tuple[InputCotangents, int]:
    """Return (cotangents of rays (n, 3) and, if `of_walls`, of walls (w, 22); first miss with a cotangent, or -1).

    cotangents: those of t (n,), points and normals (n, 3) and uv (n, 2); None for zeros.
    """
    count, wide = len(crossings.t), len(walls.numbers)
    t, *others = cotangents
    weights = CrossingCotangents(
        as_kernel_rows(t, 1).reshape(-1),
        *(as_kernel_rows(part, width) for part, width in zip(others, (3, 3, 2), strict=True)),
    )
    # Few parts where there are many walls: each part needs sums for all of them.
    parts = max(1, min(_PARTS, count // max(CHUNK, 4 * wide)))
    sums = np.zeros((parts, wide if of_walls else 0, CHANGE))
    ends = [count * k // parts for k in range(parts + 1)]
    result = InputCotangents(np.empty((count, 3)), np.empty((count, 3)), sums[0])
    own = [result._replace(walls=part) for part in sums]
    calls = [(walls, crossings, weights, ends[k], ends[k + 1], own[k]) for k in range(parts)]
    misses = run_calls(pull_back_crossings, calls)
    # The first miss is the smallest index that is not -1.
    return result._replace(walls=sums.sum(axis=0)), max(misses, key=lambda k: (k >= 0, -k))


def split_forms_maps(walls: FloatArray) -> tuple[FloatArray, FloatArray]:
    """Split tangents or cotangents of walls (w, 22) into those of forms (w, 10) and of maps (w, 12)."""
    return walls[:, :FORM], walls[:, FORM:]
