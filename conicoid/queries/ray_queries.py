"""The rows of a picture in a flat list of rays, found by looking at the rays.

In the order in which a camera scans, rays move away from the first one until a row ends, and then
jump back to next to it. Where the list is made of rows like that, squares of neighbours can be traced together
instead of stretches of a row. A wrong guess costs time, never a hit.
"""

from __future__ import annotations

from typing import TYPE_CHECKING, Any

import numpy as np

from .._util.arrays import FloatArray, dot_rows
from .._util.validation import describe_kind, format_value, real_array
from ..kernels.body.hit import is_doubtful
from ..kernels.entry.first_hits import HitBuffers, coherent_packets, trace_first, trace_occluded, trace_ordered
from ..kernels.packet.frontier import tile_count
from ..kernels.ray import RayArrays
from ..kernels.stream.ray_order import ray_order
from ..kernels.threads import chunk_of_rays, chunk_size, run_on
from ..prepare.prepared_scene import PreparedScene
from .hits import Hits
from .rays import LazyRays, Rays
from .result import QueryResult

if TYPE_CHECKING:
    from .spans import Crossings, Spans


FEW_RAYS = 1 << 14
"""Shorter lists are not examined: it would take longer than it saves."""
_LEAST = 32  # rays in a row: a few idle lanes at its end do not matter
_PICTURE_SIDE = 8  # of a square
_LOOKS = (1 << 10, 1 << 14)  # how far the end of the first row is searched
_STEEP = 4.0  # the next row is at most so many neighbours away: of 64 rays in a square none is further than in a row


def row_length(rays: Rays) -> int:
    """How many rays each row of a flat list has, 0 if it has none.

    Rows are looked for in the directions (a camera of perspective), then in the origins (an orthographic one).
    """
    if len(rays.shape) != 1 or len(rays) < FEW_RAYS:
        return 0
    for lines in (rays.directions, rays.origins):
        length = _first_return(lines)
        if length >= _LEAST and len(lines) % length == 0 and _is_picture(lines.reshape(-1, length, 3)):
            return length
    return 0


def _squared(vectors: FloatArray) -> Any:
    """Squared lengths of vectors."""
    return dot_rows(vectors, vectors)


def _first_return(lines: FloatArray) -> int:
    """The first place where lines (n, 3) jump back to near the first of them, 0 if there is none."""
    for look in _LOOKS:
        away = _squared(lines[: min(look, len(lines) // _PICTURE_SIDE) + 1] - lines[0])
        back = np.flatnonzero(16.0 * away[_PICTURE_SIDE:] < away[_PICTURE_SIDE - 1 : -1])
        if len(back):
            return int(back[0]) + _PICTURE_SIDE
    return 0


def _is_picture(rows: FloatArray) -> bool:
    """Do a few rows (height, width, 3) begin, pass and end beside those before them?"""
    height, width, _ = rows.shape
    some = np.linspace(1, height - 1, _PICTURE_SIDE).astype(np.int64)
    columns = np.array([0, width // 2, width - 1])
    here, before = rows[some][:, columns], rows[some - 1][:, columns]
    across = np.sqrt(_squared(here[:, 1:] - here[:, :-1])).sum(axis=1) / (width - 1)
    down = np.sqrt(_squared(here - before)).max(axis=1)
    return bool((down <= _STEEP * across).all())


# Queries on arrays of rays: chunked over threads, any leading shape in, the same shape out.

_TILE_CHUNK = 32
_FEW_PACKETS = 32
_STREAM_RAYS = 8192


def as_rays(query: str, origins: Any, directions: Any) -> Rays:
    """The Rays of a query's first two arguments: arrays, or a `Rays` alone."""
    if isinstance(origins, Rays):
        if directions is not None:
            numbers = np.ndim(directions) == 0 and isinstance(directions, int | float | np.number)
            hint = f"; intervals are named: {query}(rays, t_min={directions}, t_max=...)" if numbers else ""
            if isinstance(directions, str):
                hint = f"; what follows has a name: {query}(rays, by={directions!r})" if query == "lengths" else ""
            raise TypeError(f"{query}: directions must be left out where a Rays is given{hint}")
        return origins
    if isinstance(origins, LazyRays):
        return as_rays(query, origins.made(), directions)
    if directions is None:
        refuse_no_rays(query, origins)
    if directions is None and isinstance(origins, list | tuple) and any(isinstance(ray, Rays) for ray in origins):
        raise TypeError(
            f"{query}: rays of a list are joined by co.Rays.concatenate(rays), got {describe_kind(origins)}"
        )
    if directions is None:
        raise TypeError(
            f"{query}: directions are missing: pass origins and directions, or a Rays "
            f"(which unpacks to these two arrays: one of its rays is rays[i]){_pair_hint(query, origins)}"
        )
    return Rays(origins, directions)


def refuse_no_rays(query: str, given: Any) -> None:
    """TypeError for what is of this package and no rays: an answer, a camera, a shape."""
    if isinstance(given, Rays | LazyRays) or not type(given).__module__.startswith("conicoid."):
        return
    hint = ""
    if isinstance(given, QueryResult):
        hint = "; use its .rays, or hits.spawn(...)"
    elif callable(getattr(given, "rays", None)):
        hint = "; its rays are those of a picture: .rays(width, height)"
    elif hasattr(given, "lazy_rays"):
        hint = "; co.Rays.from_scan(geometry) are its rays"
    raise TypeError(f"{query}: origins must be arrays or a Rays, got {describe_kind(given)}{hint}")


def _pair_hint(query: str, given: Any) -> str:
    """What to tell where origins and directions come as one."""
    if (
        isinstance(given, tuple | list)
        and len(given) == 2
        and all(np.ndim(part) and np.shape(part)[-1] == 3 for part in given)
    ):
        return f"; a pair of arrays is passed as two, {query}(*pair)"
    shape = getattr(given, "shape", ())
    return f"; an array of both is two, {query}(a[..., :3], a[..., 3:])" if shape and shape[-1] == 6 else ""


def rays_after_values(values: Any, origins: Any, directions: Any) -> Rays:
    """The Rays of a line integral, whose values come first: what looks like another order is a TypeError."""
    order = "line_integral: values come first, and then the rays: line_integral(values, rays)"
    if isinstance(values, Rays | QueryResult):
        raise TypeError(f"{order} or line_integral(values, origins, directions); got {describe_kind(values)} first")
    try:
        return as_rays("line_integral", origins, directions)
    except ValueError as error:
        if not _looks_like_points(values) or _looks_like_points(directions):
            raise
        raise ValueError(f"{error}; values come first: line_integral(values, origins, directions)") from None


def _looks_like_points(values: Any) -> bool:
    """Whether something may be meant for origins or directions."""
    try:
        return bool(np.shape(values)[-1:] == (3,))
    except ValueError:
        return False


def limits_of(query: str, rays: Rays, name: str, value: Any) -> FloatArray:
    """t_min or t_max as one value, or one for each ray."""
    if isinstance(value, float) and value == value:  # as almost always
        return np.array([value])
    expected = f"a number or broadcast to {rays.shape}"
    array = real_array(query, name, value, expected)
    if isinstance(value, bool) or getattr(value, "dtype", None) == np.bool_:
        raise ValueError(f"{query}: {name} must be {expected}, got {format_value(value)}, which is true or false")
    try:
        flat = array.reshape(1) if array.ndim == 0 else np.broadcast_to(array, rays.shape).reshape(-1)
    except ValueError:
        raise ValueError(f"{query}: {name} must be {expected}, got {format_value(value)}") from None
    if np.isnan(flat).any():
        raise ValueError(f"{query}: {name} must not be NaN, got NaN at {int(np.flatnonzero(np.isnan(flat))[0])}")
    return np.ascontiguousarray(flat) if flat.size else np.zeros(1)


def arrays_of(query: str, scene: PreparedScene, rays: Rays, t_min: Any, t_max: Any) -> RayArrays:
    """The rays of a query as kernels take them: an item, or one for all, of each. Messages begin with its name."""
    return RayArrays(
        rays.origins.reshape(-1, 3),
        rays.directions.reshape(-1, 3),
        limits_of(query, rays, "t_min", t_min),
        limits_of(query, rays, "t_max", t_max),
        rays._starts_in(scene),
    )


def _packets(rays: Rays) -> tuple[int, int]:
    """(width of the picture that the rays make or 0, how many packets of 64 they make)."""
    shape, count = rays.shape, rays.origins.size // 3
    width = row_length(rays) if len(shape) == 1 else shape[-1] if len(shape) > 1 and min(shape[-2:]) >= 8 else 0
    if width == 0:
        return 0, -(-count // 64)
    return width, -(-width // 8) * -(-count // (8 * width))


def first_hit(scene: PreparedScene, rays: Rays, t_min: Any, t_max: Any) -> Hits:
    """The nearest crossing of each ray in (t_min, t_max).

    In packets, or in streams where rays are not coherent; then what the kernels left in doubt is settled. Which route
    a ray took changes no bit of the answer.
    """
    arrays = arrays_of("first_hit", scene, rays, t_min, t_max)
    found = HitBuffers.new(len(arrays.origins))
    width, packets = _packets(rays)
    tiles = tile_count(width, len(arrays.origins))
    if not _is_coherent(scene, arrays, width, packets):
        _trace_streams(scene, arrays, False, found)
    else:
        run_on(
            scene.geometry,
            lambda geometry, a, b: trace_first(geometry, arrays, width, a, b, found),
            tiles,
            chunk_of_rays(scene.geometry, tiles, _TILE_CHUNK, len(arrays.origins)),
            len(arrays.origins),
        )
    doubtful = np.flatnonzero(is_doubtful(found.turn))
    if len(doubtful):
        from .exact.doubtful_rays import filter_doubtful, resolve_hits

        resolve_hits(scene, arrays, doubtful, found)
        doubtful = filter_doubtful(scene, arrays, doubtful, found)
    return Hits(scene, rays, found, doubtful)


def _trace_streams(scene: PreparedScene, arrays: RayArrays, any_hit: bool, found: HitBuffers) -> None:
    """First hits, or any, of rays in no order: sorted, and in streams."""
    order = ray_order(scene.geometry, arrays.origins, arrays.directions)
    streams = -(-len(order) // _STREAM_RAYS)
    run_on(
        scene.geometry,
        lambda geometry, a, b: trace_ordered(geometry, arrays, order, _STREAM_RAYS, any_hit, a, b, found),
        streams,
        chunk_size(streams, 8),
        len(order),
    )


def _is_coherent(scene: PreparedScene, arrays: RayArrays, width: int, packets: int) -> bool:
    """Should rays be traced in packets, in the order given? Yes if they are few, or every other packet is coherent."""
    if packets < _FEW_PACKETS:
        return True
    asked = 64
    return coherent_packets(scene.geometry, arrays, width, packets, asked) >= asked // 2


def occluded(scene: PreparedScene, rays: Rays, t_min: Any, t_max: Any) -> Any:
    """Is there any crossing in (t_min, t_max)?  bool of the rays' shape."""
    arrays = arrays_of("occluded", scene, rays, t_min, t_max)
    width, packets = _packets(rays)
    tiles = tile_count(width, len(arrays.origins))
    if _is_coherent(scene, arrays, width, packets):
        result: Any = np.zeros(len(arrays.origins), np.int8)
        run_on(
            scene.geometry,
            lambda geometry, a, b: trace_occluded(geometry, arrays, width, a, b, result),
            tiles,
            chunk_of_rays(scene.geometry, tiles, _TILE_CHUNK, len(arrays.origins)),
            len(arrays.origins),
        )
        doubtful = np.flatnonzero(is_doubtful(result))
    else:
        found = HitBuffers.new(len(arrays.origins))
        _trace_streams(scene, arrays, True, found)
        result, doubtful = found.body >= 0, np.flatnonzero(is_doubtful(found.turn))
    if len(doubtful):
        result[doubtful] = _resolve_occlusion(scene, arrays, doubtful)
    return result.astype(np.bool_).reshape(rays.shape)[()]


def _resolve_occlusion(scene: PreparedScene, arrays: RayArrays, which: Any) -> Any:
    """Do these rays hit anything?  In exact arithmetic; bool."""
    from .exact.doubtful_rays import resolve_hits

    some = arrays.some(which)
    found = HitBuffers.new(len(which))
    resolve_hits(scene, some, np.arange(len(which)), found)
    return found.body >= 0


def spans(scene: PreparedScene, rays: Rays, t_min: Any, t_max: Any) -> Spans:
    """Every stretch of each ray inside each solid, clipped to [t_min, t_max]."""
    from .spans import Spans, trace_lists

    return Spans(scene, rays, trace_lists(scene, arrays_of("spans", scene, rays, t_min, t_max), *_packets(rays), True))


def crossings(scene: PreparedScene, rays: Rays, t_min: Any, t_max: Any) -> Crossings:
    """Every crossing of each ray with every body in (t_min, t_max), sheets too."""
    from .spans import Crossings, trace_lists

    return Crossings(
        scene, rays, trace_lists(scene, arrays_of("crossings", scene, rays, t_min, t_max), *_packets(rays), False)
    )
