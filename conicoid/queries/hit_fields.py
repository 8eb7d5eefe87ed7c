"""Compiled loops that compute fields of results: faces, points, normals and uv of hits; and the check of input rays."""

from __future__ import annotations

import math
from typing import Any

from .._jit.decorators import fma, inline, kernel
from .._util.validation import LARGEST, SMALLEST
from ..kernels.body.entry import crossing_face
from ..kernels.body.uv import from_center, uv_at
from ..kernels.numbers.vectors import dot
from ..kernels.surface.records import normal_at
from ..kernels.tables import Floats, Geometry, Ints, Signs, whole


@inline
def _is_outside_domain(x: float) -> bool:
    """Return True if a number is neither 0 nor within the domain of magnitudes."""
    return x != 0.0 and not SMALLEST <= abs(x) <= LARGEST


@kernel(origins="n 3", directions="n 3")
def first_invalid(origins: Floats, directions: Floats) -> tuple[int, int]:
    """Return (index, reason) of the first ray that cannot be traced, (-1, 0) if there is none.

    Reasons: 1 the origin is not finite, 2 the direction is not finite, 3 the direction is zero, 4 and 5 a component of
    the origin or direction is outside of the domain.
    """
    for i in range(len(origins)):
        x, y, z = directions[i, 0], directions[i, 1], directions[i, 2]
        if not (math.isfinite(origins[i, 0]) and math.isfinite(origins[i, 1]) and math.isfinite(origins[i, 2])):
            return i, 1
        if not (math.isfinite(x) and math.isfinite(y) and math.isfinite(z)):
            return i, 2
        if x == 0.0 and y == 0.0 and z == 0.0:
            return i, 3
        if _is_outside_domain(origins[i, 0]) or _is_outside_domain(origins[i, 1]) or _is_outside_domain(origins[i, 2]):
            return i, 4
        if _is_outside_domain(x) or _is_outside_domain(y) or _is_outside_domain(z):
            return i, 5
    return -1, 0


@kernel(entry="n", place="n", turn="n", begin="0..end", end="0..n", faces="out 3 n")
def faces_of(geometry: Geometry, entry: Ints, place: Ints, turn: Signs, begin: int, end: int, faces: Ints) -> None:
    """Write faces (3, n): surface, face number and side of hits; -1, -1, 0 for misses."""
    for i in range(begin, end):
        faces[0, i], faces[1, i], faces[2, i] = -1, -1, 0
        if entry[i] >= 0:
            sense: Any = 1 if turn[i] > 0 else -1
            surface, face, side = crossing_face(geometry, whole(entry[i]), whole(place[i]), sense)
            faces[0, i], faces[1, i], faces[2, i] = surface, face, side


@kernel(origins="n 3", directions="n 3", t="n", begin="0..end", end="0..n", points="out n 3")
def points_along(origins: Floats, directions: Floats, t: Floats, begin: int, end: int, points: Floats) -> None:
    """Write origin + t direction, rounded once by a fused multiply-add; NaN for misses."""
    for i in range(begin, end):
        for k in range(3):
            points[i, k] = fma(t[i], directions[i, k], origins[i, k]) if t[i] < math.inf else math.nan


@kernel(faces="3 n", points="n 3", begin="0..end", end="0..n", normals="out n 3")
def normals_of(geometry: Geometry, faces: Ints, points: Floats, begin: int, end: int, normals: Floats) -> None:
    """Write outward unit normals at points on faces (3, n), as `faces_of` writes them; NaN for misses."""
    for i in range(begin, end):
        x, y, z = math.nan, math.nan, math.nan
        if faces[0, i] >= 0:
            x, y, z = normal_at(geometry, faces[0, i], faces[2, i], points[i, 0], points[i, 1], points[i, 2])
        normals[i, 0], normals[i, 1], normals[i, 2] = x, y, z


@kernel(body="n", faces="3 n", points="n 3", begin="0..end", end="0..n", uv="out n 2")
def uvs_of(geometry: Geometry, body: Ints, faces: Ints, points: Floats, begin: int, end: int, uv: Floats) -> None:
    """Write uv coordinates of hit points; NaN for misses."""
    for i in range(begin, end):
        u, v = math.nan, math.nan
        if body[i] >= 0:
            u, v = uv_at(geometry, body[i], faces[1, i], faces[0, i], points[i, 0], points[i, 1], points[i, 2])
        uv[i, 0], uv[i, 1] = u, v


@kernel(
    frames="* 3 4", body_frame="body_face", bodies="n", faces="3 n", points="n 3", begin="0..end", end="0..n",
    local="out n 3"
)  # fmt: skip
def local_points_of(
    geometry: Geometry, frames: Floats, body_frame: Ints, bodies: Ints, faces: Ints, points: Floats,
    begin: int, end: int, local: Floats,
) -> None:  # fmt: skip
    """Write hit points in the frames of their bodies' own shapes; NaN for misses."""
    for i in range(begin, end):
        body = bodies[i]
        if body < 0:
            local[i, 0], local[i, 1], local[i, 2] = math.nan, math.nan, math.nan
            continue
        row = body_frame[body]
        if row < 0:  # a ball of a `Spheres`: coordinates about its center, with the axes of ball frame -1 - row
            own = from_center(geometry, -1 - row, faces[0, i], points[i, 0], points[i, 1], points[i, 2])
            local[i, 0], local[i, 1], local[i, 2] = own
            continue
        for k in range(3):
            f = frames[row]
            local[i, k] = dot(f[k, 0], f[k, 1], f[k, 2], points[i, 0], points[i, 1], points[i, 2]) + f[k, 3]
