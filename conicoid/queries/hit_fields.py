"""Compiled loops for arrays: the check and the copy of rays, rays of scans; faces, points, normals and uv of hits."""

from __future__ import annotations

import math
from typing import Any, TypeAlias

import numpy as np
import numpy.typing as npt

from .._jit.decorators import fma, inline, kernel
from .._util.validation import BELOW_ROUNDING, LARGEST, SMALLEST
from ..kernels.body.entry import crossing_face
from ..kernels.body.uv import from_center, uv_at
from ..kernels.bvh.culling import finish_streams
from ..kernels.numbers.vectors import dot
from ..kernels.packet.lanes import copy_run
from ..kernels.ray import are_traceable, is_traceable
from ..kernels.surface.records import normal_at
from ..kernels.tables import Floats, Geometry, Ints, Signs, whole

Singles: TypeAlias = npt.NDArray[np.float32]


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


_FEW = 256  # rays that are converted before they are copied


@inline
def _without_negligible(x: float, y: float, z: float) -> tuple[float, float, float]:
    """Return a vector as `zero_negligible` does."""
    a, b, c = abs(x), abs(y), abs(z)
    largest, every = max(a, b, c), a + b + c
    limit = BELOW_ROUNDING * largest if every == every else -1.0  # nothing is negligible beside NaN
    return (
        0.0 if (a < SMALLEST) & (a <= limit) else x,
        0.0 if (b < SMALLEST) & (b <= limit) else y,
        0.0 if (c < SMALLEST) & (c <= limit) else z,
    )


@inline
def put_ray(
    origins: Floats, directions: Floats, i: int, ox: float, oy: float, oz: float, dx: float, dy: float, dz: float
) -> int:
    """Write a computed ray without negligible components; return 1 if `first_invalid` finds it, else 0."""
    valid = are_traceable(ox, oy, oz, dx, dy, dz)
    if not valid:
        ox, oy, oz = _without_negligible(ox, oy, oz)
        dx, dy, dz = _without_negligible(dx, dy, dz)
        valid = are_traceable(ox, oy, oz, dx, dy, dz)
    # The sum has 0 in place of -0
    origins[i, 0], origins[i, 1], origins[i, 2] = ox + 0.0, oy + 0.0, oz + 0.0
    directions[i, 0], directions[i, 1], directions[i, 2] = dx + 0.0, dy + 0.0, dz + 0.0
    return 0 if valid & ((dx != 0.0) | (dy != 0.0) | (dz != 0.0)) else 1


@kernel(
    vectors="v 12", first="0..4611686018427387904", rows="1..2147483647", columns="1..2147483647", begin="0..end",
    end="0..n", origins="out n 3", directions="out n 3", bad="out 1",
)  # fmt: skip
def scan_lines(
    vectors: Floats, first: int, rows: int, columns: int, is_parallel: bool, begin: int, end: int,
    origins: Floats, directions: Floats, bad: Signs,
) -> None:  # fmt: skip
    """Compute the rays to flat detectors: begin..end of those from number `first` on; bad[0] = 1 as `check_rays`."""
    wrong, size = 0, rows * columns
    for i in range(begin, end):
        view, pixel = (first + i) // size, (first + i) % size
        if view >= len(vectors):
            wrong = 1
            break
        w = vectors[view]
        across, up = pixel % columns - (columns - 1) / 2, pixel // columns - (rows - 1) / 2
        x = w[3] + across * w[6] + up * w[9]
        y = w[4] + across * w[7] + up * w[10]
        z = w[5] + across * w[8] + up * w[11]
        if is_parallel:  # rays pass the pixel, else t = 1 there
            wrong |= put_ray(origins, directions, i, x, y, z, w[0], w[1], w[2])
        else:
            wrong |= put_ray(origins, directions, i, w[0], w[1], w[2], x - w[0], y - w[1], z - w[2])
    if wrong != 0:
        bad[0] = 1


@inline
def _copy_rows(
    origins: Any, directions: Any, begin: int, end: int, own_origins: Floats, own_directions: Floats, bad: Signs,
    few_origins: Floats, few_directions: Floats,
) -> None:  # fmt: skip
    """Copy rays begin..end by way of arrays of a few, which stay in the cache, and mark invalid ones."""
    for first in range(begin, end, len(few_origins)):
        count = min(end - first, len(few_origins))
        for i in range(np.uint64(count)):
            for k in range(np.uint64(3)):
                few_origins[i, k] = float(origins[np.uint64(first) + i, k])
                few_directions[i, k] = float(directions[np.uint64(first) + i, k])
        if copy_run(few_origins, few_directions, 0, own_origins, own_directions, first, count) != 0:
            bad[0] = 1
    finish_streams()


@kernel(origins="3*n", directions="3*n", begin="0..end", end="0..n", bad="out 1")
def check_rays(origins: Floats, directions: Floats, begin: int, end: int, bad: Signs) -> None:
    """Set bad[0] if `first_invalid` finds one of the rays begin..end; loops without branches."""
    wrong = 0
    for i in range(np.uint64(3 * begin), np.uint64(3 * end)):
        wrong |= 0 if is_traceable(origins[i]) & is_traceable(directions[i]) else 1
    for i in range(np.uint64(begin), np.uint64(end)):
        k = np.uint64(3) * i
        zero = (directions[k] == 0.0) & (directions[k + 1] == 0.0) & (directions[k + 2] == 0.0)
        wrong |= 1 if zero else 0
    if wrong != 0:
        bad[0] = 1


@kernel(
    origins="strided n 3", directions="strided n 3", begin="0..end", end="0..n", own_origins="out n 3",
    own_directions="out n 3", bad="out 1",
)  # fmt: skip
def copy_rays(
    origins: Floats, directions: Floats, begin: int, end: int, own_origins: Floats, own_directions: Floats, bad: Signs
) -> None:  # fmt: skip
    """Copy rays begin..end into other arrays, and set bad[0] if `first_invalid` finds one."""
    few_origins, few_directions = np.empty((_FEW, 3)), np.empty((_FEW, 3))
    _copy_rows(origins, directions, begin, end, own_origins, own_directions, bad, few_origins, few_directions)


@kernel(
    origins="strided n 3", directions="strided n 3", begin="0..end", end="0..n", own_origins="out n 3",
    own_directions="out n 3", bad="out 1",
)  # fmt: skip
def copy_single_rays(
    origins: Singles, directions: Singles, begin: int, end: int, own_origins: Floats, own_directions: Floats, bad: Signs
) -> None:  # fmt: skip
    """`copy_rays` of float32."""
    few_origins, few_directions = np.empty((_FEW, 3)), np.empty((_FEW, 3))
    _copy_rows(origins, directions, begin, end, own_origins, own_directions, bad, few_origins, few_directions)


@kernel(entry="n", place="n", turn="n", begin="0..end", end="0..n", faces="out 3 n")
def faces_of(geometry: Geometry, entry: Ints, place: Ints, turn: Signs, begin: int, end: int, faces: Ints) -> None:
    """Write faces (3, n): surface, face number and side of hits; -1, -1, 0 for misses."""
    for i in range(begin, end):
        faces[0, i], faces[1, i], faces[2, i] = -1, -1, 0
        if entry[i] >= 0:
            sense: Any = 1 if turn[i] > 0 else -1
            surface, face, side = crossing_face(geometry, whole(entry[i]), whole(place[i]), sense)
            faces[0, i], faces[1, i], faces[2, i] = surface, face, side


FAR = 2.0**17
"""A hit is far from the ray's origin if |t d| is larger than this times its own coordinates: then origin + t direction
is farther beside the surface than culling of rays that start there allows (`culling_constants.ORIGIN_SLACK`)."""


@inline
def is_far(directions: Floats, t: Floats, points: Floats, i: int) -> bool:
    """Return whether hit i is far from the origin of its ray."""
    along = abs(t[i]) * max(abs(directions[i, 0]), max(abs(directions[i, 1]), abs(directions[i, 2])))
    return along > FAR * max(abs(points[i, 0]), max(abs(points[i, 1]), abs(points[i, 2])))


@kernel(origins="n 3", directions="n 3", t="n", begin="0..end", end="0..n", points="out n 3", far="out 1")
def hit_points(
    origins: Floats, directions: Floats, t: Floats, begin: int, end: int, points: Floats, far: Signs
) -> None:  # fmt: skip
    """Write origin + t direction, rounded once by a fused multiply-add, NaN for misses; set far[0] for a far hit."""
    for i in range(begin, end):
        for k in range(3):
            points[i, k] = fma(t[i], directions[i, k], origins[i, k]) if t[i] < math.inf else math.nan
        if is_far(directions, t, points, i):
            far[0] = 1


@kernel(faces="3 n", points="n 3", begin="0..end", end="0..n", normals="out n 3")
def normals_of(geometry: Geometry, faces: Ints, points: Floats, begin: int, end: int, normals: Floats) -> None:
    """Write outward unit normals at points on faces (3, n), as `faces_of` writes them; NaN for misses."""
    for i in range(begin, end):
        x, y, z = math.nan, math.nan, math.nan
        if faces[0, i] >= 0:
            x, y, z = normal_at(geometry, faces[0, i], faces[2, i], points[i, 0], points[i, 1], points[i, 2])
        normals[i, 0], normals[i, 1], normals[i, 2] = x, y, z


@kernel(
    origins="1 3", spawned="1 3", directions="1 3", t="1", entry="1", place="1", turn="1", surface="out 1",
    face="out 1", side="out 1", x="out 1", y="out 1", z="out 1", nx="out 1", ny="out 1", nz="out 1",
)  # fmt: skip
def hit_alone(
    geometry: Geometry, origins: Floats, spawned: Floats, directions: Floats, t: Floats, entry: Ints, place: Ints,
    turn: Ints, surface: Ints, face: Ints, side: Ints, x: Floats, y: Floats, z: Floats, nx: Floats, ny: Floats,
    nz: Floats,
) -> int:  # fmt: skip
    """Write the surface, point and normal of one hit; return 1 where `hit_points` finds it far. For `single` calls.

    `spawned` is the direction of a ray that is to start there, which the call tests.
    """
    if entry[0] < 0:
        return 1
    sense: Any = 1 if turn[0] > 0 else -1
    surface[0], face[0], side[0] = crossing_face(geometry, whole(entry[0]), whole(place[0]), sense)
    points = np.empty((1, 3))
    for k in range(3):
        points[0, k] = fma(t[0], directions[0, k], origins[0, k])
    x[0], y[0], z[0] = points[0, 0], points[0, 1], points[0, 2]
    normal = normal_at(geometry, surface[0], side[0], x[0], y[0], z[0])
    nx[0], ny[0], nz[0] = _without_negligible(normal[0], normal[1], normal[2])
    return 1 if is_far(directions, t, points, 0) else 0


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
