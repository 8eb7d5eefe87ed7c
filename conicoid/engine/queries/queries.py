"""Queries on arrays of rays: chunked over threads, any leading shape in, the same shape out."""

from __future__ import annotations

from typing import TYPE_CHECKING, Any

import numpy as np

from ...shapes.arrays import real_array
from ...shapes.validate import shown, what
from ...shapes.vector import FloatArray
from ..answers.answer import Answer
from ..answers.hits import Hits
from ..answers.lazy_rays import LazyRays
from ..answers.rays import Rays
from ..arrays.first import coherent_packets, trace_first, trace_occluded, trace_ordered
from ..arrays.found import Found
from ..body.hit import is_doubtful
from ..packets.tile import tile_count
from ..prepared import Prepared
from ..ray import RayArrays
from ..streams.order import ray_order
from ..threads import chunk_of_rays, chunk_size, run_on
from .scan_lines import row_length

if TYPE_CHECKING:  # and not before they are asked for: a first hit needs neither
    from ..answers.spans import Crossings, Spans

_TILES = 32
_FEW = 32
_STREAM = 8192


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
        raise TypeError(f"{query}: rays of a list are joined by co.Rays.concatenate(rays), got {what(origins)}")
    if directions is None:
        raise TypeError(
            f"{query}: directions are missing: pass origins and directions, or a Rays "
            f"(which unpacks to these two arrays: one of its rays is rays[i]){_both_in_one(query, origins)}"
        )
    return Rays(origins, directions)


def refuse_no_rays(query: str, given: Any) -> None:
    """TypeError for what is of this package and no rays: an answer, a camera, a shape."""
    if isinstance(given, Rays | LazyRays) or not type(given).__module__.startswith("conicoid."):
        return
    hint = ""
    if isinstance(given, Answer):
        hint = "; use its .rays, or hits.spawn(...)"
    elif callable(getattr(given, "rays", None)):
        hint = "; its rays are those of a picture: .rays(width, height)"
    elif hasattr(given, "lazy_rays"):
        hint = "; co.Rays.from_scan(geometry) are its rays"
    raise TypeError(f"{query}: origins must be arrays or a Rays, got {what(given)}{hint}")


def _both_in_one(query: str, given: Any) -> str:
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
    if isinstance(values, Rays | Answer):
        raise TypeError(f"{order} or line_integral(values, origins, directions); got {what(values)} first")
    try:
        return as_rays("line_integral", origins, directions)
    except ValueError as error:
        if not _is_of_points(values) or _is_of_points(directions):
            raise
        raise ValueError(f"{error}; values come first: line_integral(values, origins, directions)") from None


def _is_of_points(values: Any) -> bool:
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
        raise ValueError(f"{query}: {name} must be {expected}, got {shown(value)}, which is true or false")
    try:
        flat = array.reshape(1) if array.ndim == 0 else np.broadcast_to(array, rays.shape).reshape(-1)
    except ValueError:
        raise ValueError(f"{query}: {name} must be {expected}, got {shown(value)}") from None
    if np.isnan(flat).any():
        raise ValueError(f"{query}: {name} must not be NaN, got NaN at {int(np.flatnonzero(np.isnan(flat))[0])}")
    return np.ascontiguousarray(flat) if flat.size else np.zeros(1)


def arrays_of(query: str, scene: Prepared, rays: Rays, t_min: Any, t_max: Any) -> RayArrays:
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


def first_hit(scene: Prepared, rays: Rays, t_min: Any, t_max: Any) -> Hits:
    """The nearest crossing of each ray in (t_min, t_max).

    In packets, or in streams where rays are not coherent; then what the kernels left in doubt is settled. Which route
    a ray took changes no bit of the answer.
    """
    arrays = arrays_of("first_hit", scene, rays, t_min, t_max)
    found = Found.new(len(arrays.origins))
    width, packets = _packets(rays)
    tiles = tile_count(width, len(arrays.origins))
    if not _in_order(scene, arrays, width, packets):
        _trace_streams(scene, arrays, False, found)
    else:
        run_on(
            scene.geometry,
            lambda geometry, a, b: trace_first(geometry, arrays, width, a, b, found),
            tiles,
            chunk_of_rays(scene.geometry, tiles, _TILES, len(arrays.origins)),
            len(arrays.origins),
        )
    doubtful = np.flatnonzero(is_doubtful(found.turn))
    if len(doubtful):
        from ..certified.settle import left_doubtful, settle_hits

        settle_hits(scene, arrays, doubtful, found)
        doubtful = left_doubtful(scene, arrays, doubtful, found)
    return Hits(scene, rays, found, doubtful)


def _trace_streams(scene: Prepared, arrays: RayArrays, any_hit: bool, found: Found) -> None:
    """First hits, or any, of rays in no order: sorted, and in streams."""
    order = ray_order(scene.geometry, arrays.origins, arrays.directions)
    streams = -(-len(order) // _STREAM)
    run_on(
        scene.geometry,
        lambda geometry, a, b: trace_ordered(geometry, arrays, order, _STREAM, any_hit, a, b, found),
        streams,
        chunk_size(streams, 8),
        len(order),
    )


def _in_order(scene: Prepared, arrays: RayArrays, width: int, packets: int) -> bool:
    """Should rays be traced in packets, in the order given? Yes if they are few, or every other packet is coherent."""
    if packets < _FEW:
        return True
    asked = 64
    return coherent_packets(scene.geometry, arrays, width, packets, asked) >= asked // 2


def occluded(scene: Prepared, rays: Rays, t_min: Any, t_max: Any) -> Any:
    """Is there any crossing in (t_min, t_max)?  bool of the rays' shape."""
    arrays = arrays_of("occluded", scene, rays, t_min, t_max)
    width, packets = _packets(rays)
    tiles = tile_count(width, len(arrays.origins))
    if _in_order(scene, arrays, width, packets):
        result: Any = np.zeros(len(arrays.origins), np.int8)
        run_on(
            scene.geometry,
            lambda geometry, a, b: trace_occluded(geometry, arrays, width, a, b, result),
            tiles,
            chunk_of_rays(scene.geometry, tiles, _TILES, len(arrays.origins)),
            len(arrays.origins),
        )
        doubtful = np.flatnonzero(is_doubtful(result))
    else:
        found = Found.new(len(arrays.origins))
        _trace_streams(scene, arrays, True, found)
        result, doubtful = found.body >= 0, np.flatnonzero(is_doubtful(found.turn))
    if len(doubtful):
        result[doubtful] = _settled(scene, arrays, doubtful)
    return result.astype(np.bool_).reshape(rays.shape)[()]


def _settled(scene: Prepared, arrays: RayArrays, which: Any) -> Any:
    """Do these rays hit anything?  In exact arithmetic; bool."""
    from ..certified.settle import settle_hits

    some = arrays.some(which)
    found = Found.new(len(which))
    settle_hits(scene, some, np.arange(len(which)), found)
    return found.body >= 0


def spans(scene: Prepared, rays: Rays, t_min: Any, t_max: Any) -> Spans:
    """Every stretch of each ray inside each solid, clipped to [t_min, t_max]."""
    from ..answers.spans import Spans
    from .listed import listed

    return Spans(scene, rays, listed(scene, arrays_of("spans", scene, rays, t_min, t_max), *_packets(rays), True))


def crossings(scene: Prepared, rays: Rays, t_min: Any, t_max: Any) -> Crossings:
    """Every crossing of each ray with every body in (t_min, t_max), sheets too."""
    from ..answers.spans import Crossings
    from .listed import listed

    return Crossings(
        scene, rays, listed(scene, arrays_of("crossings", scene, rays, t_min, t_max), *_packets(rays), False)
    )
