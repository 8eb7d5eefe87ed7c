"""Queries along rays on a prepared scene: first hits, occlusion, spans and crossings.

Rays are traced in packets of 64, or in streams of sorted rays where packets are not coherent. The route changes no bit
of a result. Kernels mark rays in doubt, which exact methods then decide.

Order of the file: the queries, packets and streams, rows of pictures in lists of rays, calls for few rays, arguments.
"""

from __future__ import annotations

from collections.abc import Callable, Sequence
from functools import partial
from typing import TYPE_CHECKING, Any, TypeVar

import numpy as np

from .._jit.machine_code import empty_array, is_frozen
from .._util.arrays import FloatArray, dot_rows
from .._util.validation import describe_kind, format_value, real_array
from ..kernels.body.hit import is_doubtful
from ..kernels.first_hits import (
    HitBuffers,
    coherent_packets,
    trace_first,
    trace_first_and_copy,
    trace_occluded,
    trace_ordered,
)
from ..kernels.packet.frontier import PACKETS, tile_count
from ..kernels.packet.lanes import LANES
from ..kernels.ray import RayArrays
from ..kernels.stream import ray_order
from ..kernels.threads import KernelRange, chunk_of_rays, chunk_size, is_brief, run_on
from ..prepare.prepared_scene import PreparedScene
from .device_choice import device_of
from .hits import Hits
from .rays import LazyRays, Rays, checked_rays, packets_of, uncopied_rays
from .result import QueryResult

if TYPE_CHECKING:
    from .spans import Crossings, Spans

RowLists = TypeVar("RowLists", "Spans", "Crossings")


# The queries: chunks of packets on several threads; results have the rays' shape


def first_hit(scene: PreparedScene, rays: Rays, t_min: Any, t_max: Any, device: str | None = None) -> Hits:
    """Return the nearest crossing of each ray in (t_min, t_max)."""
    gpu = device_of("first_hit", device, _are_few(rays))
    arrays = arrays_of("first_hit", scene, rays, t_min, t_max)
    width, packets = _packets(rays)
    found = HitBuffers.new(len(arrays.origins))
    if gpu is not None and gpu.run(scene, "first_hits", arrays, found, width=width):
        return _settle_hits(scene, rays, arrays, found)
    if _is_coherent(scene, arrays, width, packets):
        _trace_packets(scene, trace_first, arrays, width, found)
    else:
        _trace_streams(scene, arrays, False, found)
    if _are_few(rays) and scene.lacks_single_calls("first_hit"):
        one, few = ("trace_first_alone", 0, 1), ("trace_first", 0, 0, 1)
        _keep_single_calls(scene, "first_hit", _hits_of_few, HitBuffers.new(1), one, few)
    return _settle_hits(scene, rays, arrays, found)


def first_hit_of_arrays(scene: PreparedScene, origins: Any, directions: Any, t_min: Any, t_max: Any) -> Hits | None:
    """`first_hit` on the CPU of many rays in arrays, which are checked and copied tile by tile as they are traced.

    Frozen arrays are kept without a copy.

    None where `first_hit` must answer: for other arrays, rays that are not coherent or not valid, and on a GPU.
    """
    rays = uncopied_rays(origins, directions)
    if rays is None or device_of("first_hit", None) is not None:
        return None
    try:
        arrays = arrays_of("first_hit", scene, rays, t_min, t_max)
    except ValueError:  # `first_hit` raises it, after errors of the rays
        return None
    width, packets = _packets(rays)
    if not _is_coherent(scene, arrays, width, packets):
        return None
    count, bad = 0 if is_frozen(origins) and is_frozen(directions) else rays.size, np.zeros(1, np.int8)
    own, found = [empty_array((count, 3), np.float64) for _ in range(2)], HitBuffers.new(rays.size)
    _trace_packets(scene, trace_first_and_copy, arrays, width, *own, bad, found)
    if bad[0]:
        return None
    if not count:
        return _settle_hits(scene, rays, arrays, found)
    copies = Rays._spawned(own[0].reshape(origins.shape), own[1].reshape(origins.shape), arrays.starts)
    return _settle_hits(scene, copies, arrays._replace(origins=own[0], directions=own[1]), found)


def _settle_hits(scene: PreparedScene, rays: Rays, arrays: RayArrays, found: HitBuffers) -> Hits:
    """Return hits as kernels found them, after exact methods have decided the doubtful ones."""
    doubtful = is_doubtful(found.turn).nonzero()[0]
    if len(doubtful):
        from .exact.doubtful_rays import resolve_hits

        doubtful = resolve_hits(scene, arrays, doubtful, found)
    return Hits(scene, rays, found, doubtful)


def occluded(scene: PreparedScene, rays: Rays, t_min: Any, t_max: Any, device: str | None = None) -> Any:
    """Return bool of the rays' shape: whether there is any crossing in (t_min, t_max)."""
    gpu = device_of("occluded", device, _are_few(rays))
    arrays = arrays_of("occluded", scene, rays, t_min, t_max)
    width, packets = _packets(rays)
    result: Any = np.zeros(len(arrays.origins), np.int8)
    if gpu is not None and gpu.run(scene, "any_hits", arrays, (result,), width=width):
        doubtful = np.flatnonzero(is_doubtful(result))
    elif _is_coherent(scene, arrays, width, packets):
        _trace_packets(scene, trace_occluded, arrays, width, result)
        doubtful = np.flatnonzero(is_doubtful(result))
        if _are_few(rays) and scene.lacks_single_calls("occluded"):
            kernel = "trace_occluded", 0, 0, 1
            _keep_single_calls(scene, "occluded", _are_few_occluded, (np.zeros(1, np.int8),), kernel, kernel)
    else:
        found = HitBuffers.new(len(arrays.origins))
        _trace_streams(scene, arrays, True, found)
        result, doubtful = found.body >= 0, np.flatnonzero(is_doubtful(found.turn))
    if len(doubtful):
        result[doubtful] = _resolve_occlusion(scene, arrays, doubtful)
    return result.view(np.bool_).reshape(rays.shape)[()]


def _resolve_occlusion(scene: PreparedScene, arrays: RayArrays, which: Any) -> Any:
    """Return bool: whether doubtful rays hit anything, decided with certainty."""
    from .exact.doubtful_rays import resolve_hits

    some = arrays.some(which)
    found = HitBuffers.new(len(which))
    resolve_hits(scene, some, np.arange(len(which)), found)
    return found.body >= 0


def spans(scene: PreparedScene, rays: Rays, t_min: Any, t_max: Any, device: str | None = None) -> Spans:
    """Return every stretch of each ray inside each solid, clipped to [t_min, t_max]."""
    from .spans import Spans

    return _row_lists(Spans, scene, rays, t_min, t_max, device)


def crossings(scene: PreparedScene, rays: Rays, t_min: Any, t_max: Any, device: str | None = None) -> Crossings:
    """Return every crossing of each ray with every body, solid or sheet, in (t_min, t_max)."""
    from .spans import Crossings

    return _row_lists(Crossings, scene, rays, t_min, t_max, device)


def _row_lists(
    kind: type[RowLists], scene: PreparedScene, rays: Rays, t_min: Any, t_max: Any, device: str | None
) -> RowLists:
    """Return the spans or the crossings of rays."""
    from .spans import Spans, trace_lists

    query = kind.__name__.lower()
    gpu = device_of(query, device, _are_few(rays))
    arrays = arrays_of(query, scene, rays, t_min, t_max)
    if len(arrays.origins) == 1 and scene.lacks_single_calls(query):
        _keep_single_lists(scene, kind)
    return kind(scene, rays, trace_lists(scene, arrays, *_packets(rays), kind is Spans, gpu))


# Packets of rays in their own order, or streams of sorted rays

_TILE_CHUNK = 32  # tiles that a thread takes at a time, at most
_FEW_PACKETS = 32  # fewer packets are not tested for coherence
_STREAM_RAYS = 8192  # rays of a stream


def _packets(rays: Rays) -> tuple[int, int]:
    """Return the width of the picture that the rays make, or 0, and the number of packets of 64 rays."""
    shape, count = rays.shape, rays.origins.size // 3
    width = row_length(rays) if len(shape) == 1 else shape[-1] if len(shape) > 1 and min(shape[-2:]) >= 8 else 0
    return width, packets_of(count, width)


def _trace_packets(scene: PreparedScene, kernel: Callable[..., Any], arrays: RayArrays, width: int, *out: Any) -> None:
    """Run a kernel over tiles of packets of rays, in chunks on several threads."""
    count = len(arrays.origins)
    tiles = tile_count(width, count)
    work = KernelRange(kernel, (arrays, width), out)
    run_on(scene.geometry, work, tiles, chunk_of_rays(scene.geometry, tiles, _TILE_CHUNK, count), count)


def _trace_streams(scene: PreparedScene, arrays: RayArrays, any_hit: bool, found: HitBuffers) -> None:
    """Trace first hits, or any hits, of rays without order: sort them and trace streams of neighbours."""
    order = ray_order(scene.geometry, arrays.origins, arrays.directions)
    streams = -(-len(order) // _STREAM_RAYS)
    run_on(
        scene.geometry,
        KernelRange(trace_ordered, (arrays, order, _STREAM_RAYS, any_hit), (found,)),
        streams,
        chunk_size(streams, 8),
        len(order),
    )


def _is_coherent(scene: PreparedScene, arrays: RayArrays, width: int, packets: int) -> bool:
    """Return True if rays should be traced in packets in their own order.

    That is so for few rays, and if at least half of a sample of the packets are coherent.
    """
    if packets < _FEW_PACKETS:
        return True
    sampled = 64
    return coherent_packets(scene.geometry, arrays, width, packets, sampled) >= sampled // 2


# Rows of a picture in a flat list of rays
#
# In the order in which a camera scans, rays move away from the first ray until a row ends, and then jump back to beside
# it. If the list consists of such rows, a packet can be a square of neighbours instead of a stretch of one row. A wrong
# guess costs time, never a hit.

FEW_RAYS = 1 << 12
"""Shorter lists are not examined, since this would take longer than it saves."""
_LEAST = 32  # rays in a row; a few idle lanes at the end of such a row do not matter
_PICTURE_SIDE = 8  # side of a square
_LOOKS = (1 << 10, 1 << 14)  # how far the end of the first row is searched
_STEEP = 4.0  # distance of rows in distances of neighbours, up to which a square of 64 rays is no wider than a row


def row_length(rays: Rays) -> int:
    """Return the length of the rows of a flat list of rays, 0 if it has none.

    The search uses directions first (a perspective camera), then origins (an orthographic camera).
    """
    if len(rays.shape) != 1 or len(rays) < FEW_RAYS:
        return 0
    for lines in (rays.directions, rays.origins):
        length = _first_return(lines)
        if length >= _LEAST and len(lines) % length == 0 and _is_picture(lines.reshape(-1, length, 3)):
            return length
    return 0


def _squared(vectors: FloatArray) -> Any:
    """Return the squared lengths of vectors."""
    return dot_rows(vectors, vectors)


def _first_return(lines: FloatArray) -> int:
    """Return the first index at which vectors (n, 3) jump back to near the first of them, 0 if there is none."""
    for look in _LOOKS:
        squares = _squared(lines[: min(look, len(lines) // _PICTURE_SIDE) + 1] - lines[0])
        back = np.flatnonzero(16.0 * squares[_PICTURE_SIDE:] < squares[_PICTURE_SIDE - 1 : -1])
        if len(back):
            return int(back[0]) + _PICTURE_SIDE
    return 0


def _is_picture(rows: FloatArray) -> bool:
    """Return True if a few of the rows (height, width, 3) start, pass and end beside the row before."""
    height, width, _ = rows.shape
    some = np.linspace(1, height - 1, _PICTURE_SIDE).astype(np.int64)
    columns = np.array([0, width // 2, width - 1])
    here, before = rows[some][:, columns], rows[some - 1][:, columns]
    across = np.sqrt(_squared(here[:, 1:] - here[:, :-1])).sum(axis=1) / (width - 1)
    down = np.sqrt(_squared(here - before)).max(axis=1)
    return bool((down <= _STEEP * across).all())


# One ray or few, given by plain numbers
#
# Codes that trace ray by ray or in small lots, such as transport loops, wait mostly for the Python around the kernel:
# some 70 µs through arrays. Once a scene has answered a query of few rays it keeps a call for the next ones. That takes
# 3 µs for one ray and 20 for a thousand (native/single.h).

_MOST_FEW = PACKETS * LANES  # rays of a list that are one tile, which one thread traces


def _are_few(rays: Rays) -> bool:
    """Return whether calls of few rays can answer for as many of the same shape."""
    return rays.ndim < 2 and 0 < rays.size <= _MOST_FEW


def _keep_single_calls(
    scene: PreparedScene, query: str, answer: Callable[..., Any], outputs: tuple[Any, ...], *kernels: tuple[Any, ...]
) -> None:
    """Let `answer` answer the query from now on: by a kernel for one ray, and another for few.

    A kernel comes with its arguments between rays and outputs. Few rays that may take long are traced where Ctrl-C is
    watched for.
    """
    rays = RayArrays(np.zeros((1, 3)), np.ones((1, 3)), np.zeros(1), np.ones(1), np.full(1, -1, np.int32))
    last = (outputs,) if isinstance(outputs, HitBuffers) else outputs
    calls = [(kernel, (scene.geometry, rays, *rest, *last), tuple(rays), outputs) for kernel, *rest in kernels]
    calls = calls if is_brief(scene.geometry, _MOST_FEW) else calls[:1]
    scene.keep_single_calls(query, answer, *((*call, most) for call, most in zip(calls, (0, _MOST_FEW), strict=False)))


def _call_single(
    call: Callable[..., Any], scene: PreparedScene, origins: Any, directions: Any, t_min: Any, t_max: Any
) -> tuple[Any, Rays | None]:
    """Return the result of a call for one ray, and the ray if it was spawned on a wall of this scene."""
    found = call(origins, directions, t_min, t_max, -1)
    if found is None and directions is None and type(origins) is Rays and not origins.shape:
        start = int(origins._starts[0])
        if start >= 0 and origins._home == scene.key:
            return call(origins.origins, origins.directions, t_min, t_max, start), origins
    return found, None


def _hits_of_few(calls: Sequence[Callable[..., Any]], scene: PreparedScene, *numbers: Any) -> Hits | None:
    """Return the first hits of one ray or few; None where `first_hit` must answer."""
    found, ray = _call_single(calls[0], scene, *numbers)
    if found is not None:
        return None if is_doubtful(found[5]) else Hits._of_single(scene, found, ray)
    found = calls[1](*numbers, -1) if len(calls) > 1 else None
    if found is None:
        return None
    rays, room = Rays._of_few(found[0]), found[1]
    n = rays.size
    body, entry, place = np.frombuffer(room, np.int32, 3 * n, 8 * n).reshape(3, n)
    turn = np.frombuffer(room, np.int8, n, 20 * n)
    if np.count_nonzero(is_doubtful(turn)):
        return None
    return Hits(scene, rays, HitBuffers(np.frombuffer(room, np.float64, n), body, entry, place, turn))


def _are_few_occluded(calls: Sequence[Callable[..., Any]], scene: PreparedScene, *numbers: Any) -> Any:
    """Return whether one ray or few are occluded; None where `occluded` must answer."""
    found, _ = _call_single(calls[0], scene, *numbers)
    if found is not None:
        return None if is_doubtful(found[1]) else np.bool_(found[1])
    found = calls[1](*numbers, -1) if len(calls) > 1 else None
    if found is None:
        return None
    result = np.frombuffer(found[1], np.int8)
    return None if np.count_nonzero(is_doubtful(result)) else result.astype(np.bool_)


def _keep_single_lists(scene: PreparedScene, kind: type[RowLists]) -> None:
    """Let a call of one kernel answer the query of the spans or crossings of one ray from now on."""
    query = kind.__name__.lower()
    outputs, kernel = (np.zeros(1, np.int32), np.zeros(1, np.int8)), ("trace_rows_alone", query == "spans", 0, 1)
    _keep_single_calls(scene, query, partial(_lists_of_single, kind), outputs, kernel)


def _lists_of_single(
    kind: type[RowLists], calls: Sequence[Callable[..., Any]], scene: PreparedScene, *numbers: Any
) -> RowLists | None:
    """Return the spans or crossings of one ray; None where the query itself must answer."""
    found, ray = _call_single(calls[0], scene, *numbers)
    if found is None or found[2]:
        return None
    return kind._of_single(scene, found[0] if ray is None else ray, found[3])


# Arguments of queries


def as_rays(query: str, origins: Any, directions: Any, keep: bool = True) -> Rays:
    """Return the rays of a query's first two arguments: arrays, or a `Rays` alone. Raise TypeError for others.

    keep: whether the answer holds the rays, so that they must be copies.
    """
    if isinstance(origins, Rays):
        if directions is not None:
            found = describe_kind(directions)
            raise TypeError(f"{query}: directions must be left out where a Rays is given, got {found}")
        return origins
    if isinstance(origins, LazyRays):
        return as_rays(query, origins.to_rays(), directions)
    if directions is None:
        found = describe_kind(origins)
        raise TypeError(f"{query}: origins must be a Rays, or an array with directions beside it, got {found} alone")
    return Rays(origins, directions) if keep else checked_rays(origins, directions)


def rays_after_values(values: Any, origins: Any, directions: Any) -> Rays:
    """Return the rays of a line integral. Raise TypeError if the values do not come first."""
    if isinstance(values, Rays | QueryResult):
        raise TypeError(f"line_integral: values come before the rays, got {describe_kind(values)} first")
    return as_rays("line_integral", origins, directions, keep=False)


def limits_of(query: str, rays: Rays, name: str, value: Any) -> FloatArray:
    """Return t_min or t_max as an array of one value for all rays, or of one for each ray."""
    if isinstance(value, float) and value == value:  # the common case, without the checks below; False for NaN
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
    """Return rays and limits as kernels take them, an item for each ray or one for all; messages name `query`."""
    return RayArrays(
        rays.origins.reshape(-1, 3),
        rays.directions.reshape(-1, 3),
        limits_of(query, rays, "t_min", t_min),
        limits_of(query, rays, "t_max", t_max),
        rays._starts_in(scene),
    )
