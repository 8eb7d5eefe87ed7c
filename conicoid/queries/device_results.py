"""Queries of arrays that live on a card, and their answers, which stay there: hits, spans, crossings and distances.

A query returns when its work is done, since the CPU decides the doubtful rays. So an answer is complete, and any stream
may use it. Of each ray one byte travels, which says whether it is doubtful. A kernel adds up the numbers of spans:
twelve bytes of each ray would travel to NumPy and back, whose sum takes 3 ns.
"""

from __future__ import annotations

import math
from collections.abc import Callable, Sequence
from functools import cached_property
from typing import Any, ClassVar

import numpy as np

from .._util.records import freeze_arrays
from ..kernels.body.hit import is_doubtful
from ..kernels.crossings import CrossingColumns, SpanColumns
from ..kernels.device import MARKED, ROW_COLUMNS, SUMMED
from ..kernels.first_hits import HitBuffers
from ..kernels.ray import RayArrays
from ..kernels.threads import Progress
from ..prepare.prepared_scene import PreparedScene
from . import line_integrals, points as at_points, ray_queries
from .device import _ROWS, Device
from .device_arrays import (
    CardView,
    DeviceArray,
    DeviceRays,
    fetch_rows,
    find_flag,
    new_arrays,
    put_rows,
    rays_of,
    upload,
    view_of,
)
from .device_choice import device_of
from .exact.doubtful_rays import resolve_bodies, resolve_hits, resolve_rows
from .hits import Hits, refuse_directions, spawned_shape
from .rays import Rays
from .spans import Crossings, RayLists, Spans

_CardHits: Any = HitBuffers
_CardSpans: Any = SpanColumns
_CardCrossings: Any = CrossingColumns
"""With a `DeviceArray` for each field."""


def _open(query: str, executor: Any, device: str | None) -> Device:
    """Return the card. Raise TypeError where a query must not go there."""
    if query == "bodies_at":
        raise TypeError(f"{query}: arrays on a card are not taken; copy them to NumPy")
    if executor is not None:
        raise TypeError(f"{query}: executor must be left out for arrays on a card")
    found = device_of(query, device or "cuda")
    if found is None:
        raise TypeError(f"{query}: device must be 'cuda' for arrays on a card, got {device!r}")
    return found


def _trace(
    scene: PreparedScene, gpu: Device, function: str, inputs: Sequence[Any], outputs: Sequence[Any], width: int = 0
) -> bool:
    """Run a function with scratch memory on rays, which may be those of a picture, or on points."""
    count = inputs[0].shape[0]

    def numbers(first: int, last: int) -> list[int]:
        return [n for array in (*inputs, *outputs) for n in array._part(first, last, count)]

    return gpu.run_on_card(function, numbers, count, scene, width)


def _width(rays: DeviceRays) -> int:
    """Return the width of the picture whose shape rays have, or 0."""
    return rays.shape[-1] if len(rays.shape) > 1 else 0


# Queries of rays


def query_rays(
    scene: PreparedScene, query: str, executor: Any, device: str | None, origins: Any, directions: Any, t_min: Any,
    t_max: Any, progress: Progress | None, options: dict[str, Any],
) -> Any:  # fmt: skip
    """Answer a query of rays on a card there; `options` are the arguments of sums."""
    gpu = _open(query, executor, device)
    rays = rays_of(query, gpu, origins, directions)
    arrays = rays._arrays(query, scene, t_min, t_max)
    if options:
        plan = line_integrals.plan_of(scene, query, math.prod(rays.shape), **options)
        return _sums(scene, gpu, rays, arrays, plan, progress)._as((*rays.shape, *plan.axes))
    answer: Any = dict(first_hit=_first_hit, occluded=_occluded, spans=DeviceSpans, crossings=DeviceCrossings)[query]
    return answer(scene, gpu, rays, arrays)


def _here(rays: DeviceRays, arrays: Any) -> tuple[Rays, Any, Any]:
    """Return rays in a flat list, and limits, for the CPU to trace where a card has too little scratch memory."""
    o, d, t_min, t_max, starts = map(np.asarray, arrays)
    return Rays._spawned(o, d, starts, rays._home), t_min, t_max


def _some(arrays: Any, which: Any) -> RayArrays:
    """Return some rays, here."""
    return RayArrays(*(fetch_rows(array, which) for array in arrays))


def _doubtful_hits(gpu: Device, turn: DeviceArray) -> Any:
    """Return the numbers of doubtful hits; only marks travel, and the turns of few hits."""
    n = len(turn)
    marks = upload(gpu, np.zeros(n // MARKED + 1, np.int8))
    gpu.run_on_card("mark_doubtful", lambda *_: [turn._address, n, marks._address, len(marks)], n)
    found = [np.zeros(0, np.int64)]
    for first in (MARKED * np.asarray(marks).nonzero()[0]).tolist():
        part = np.empty(min(MARKED, n - first), np.int8)
        gpu.fetch(part, turn._address + first)
        found.append(first + is_doubtful(part).nonzero()[0])
    return np.concatenate(found)


def _first_hit(scene: PreparedScene, gpu: Device, rays: DeviceRays, arrays: Any) -> DeviceHits:
    count = len(arrays.origins)
    found = _CardHits(*new_arrays(gpu, *(((count,), kind) for kind in ("f8", "i4", "i4", "i4", "i1"))))
    if not _trace(scene, gpu, "first_hits", arrays, found, _width(rays)):
        hits = ray_queries.first_hit(scene, *_here(rays, arrays), "cpu")
        return DeviceHits(scene, gpu, rays, _CardHits(*(upload(gpu, x) for x in hits._buffers)), hits._doubtful)
    doubtful = _doubtful_hits(gpu, found.turn)
    if len(doubtful):
        some, decided = _some(arrays, doubtful), HitBuffers(*(fetch_rows(array, doubtful) for array in found))
        every = np.arange(len(doubtful))
        tied = resolve_hits(scene, some, every, decided)
        for array, values in zip(found, decided, strict=True):
            put_rows(array, doubtful, values)
        doubtful = doubtful[tied]
    return DeviceHits(scene, gpu, rays, found, doubtful)


def _occluded(scene: PreparedScene, gpu: Device, rays: DeviceRays, arrays: Any) -> DeviceArray:
    (result,) = new_arrays(gpu, (arrays.origins.shape[:1], "i1"))
    if not _trace(scene, gpu, "any_hits", arrays, (result,), _width(rays)):
        answer = ray_queries.occluded(scene, *_here(rays, arrays), "cpu")
        return upload(gpu, np.asarray(answer))._as(rays.shape)
    doubtful = _doubtful_hits(gpu, result)
    if len(doubtful):
        hits = HitBuffers.new(len(doubtful))
        resolve_hits(scene, _some(arrays, doubtful), np.arange(len(doubtful)), hits)
        put_rows(result, doubtful, (hits.body >= 0).astype(np.int8))
    return result._as(rays.shape, np.bool_)


# Rows of spans and crossings: counted, then written


def _offsets_of(gpu: Device, counts: DeviceArray) -> tuple[DeviceArray, Any]:
    """Return the first row of each ray, and the end; and here those of every ray whose number `SUMMED` divides."""
    n = len(counts)
    sums, offsets = new_arrays(gpu, ((n // SUMMED + 1,), "i8"), ((n + 1,), "i8"))
    numbers = [counts._address, n, sums._address, len(sums), offsets._address]
    gpu.run_on_card("add_counts", lambda first, last: [*numbers, 0], len(sums))
    starts = np.concatenate([[0], np.cumsum(np.asarray(sums))])
    gpu.send(sums._address, starts[:-1])
    gpu.run_on_card("add_counts", lambda first, last: [*numbers, n + 1], len(sums))
    return offsets, starts


class _RayRows:
    """Rows of rays: `counts` of each, as a kernel has counted them, at `offsets`; doubtful rays have none."""

    offsets: DeviceArray
    starts: Any

    def __init__(self, scene: PreparedScene, gpu: Device, rays: DeviceRays, arrays: Any, spans: bool) -> None:
        self._scene, self.gpu, self._arrays, self._spans, self._width = scene, gpu, arrays, spans, _width(rays)
        self._count = n = len(arrays.origins)
        self.counts, self.doubts = new_arrays(gpu, ((n,), "i4"), ((n,), "i1"))

    def count(self) -> bool:
        """Count the rows; return False, and do nothing, if the card has too little scratch memory."""
        nothing = [self.counts._address, 0]  # of offsets, which are not read, and of rows
        if not self._run(0, self._count, lambda first, last: [self.counts._address, last - first + 1, *nothing]):
            return False
        self.offsets, self.starts = _offsets_of(self.gpu, self.counts)
        return True

    def start(self, ray: int) -> int:
        """Return the first row of a ray whose number `SUMMED` divides, or the end."""
        return int(self.starts[-(-ray // SUMMED)])

    def write(self, table: DeviceArray, begin: int, end: int) -> None:
        """Write the rows of rays begin..end to a table; `SUMMED` divides both, or the end is that of all rays."""

        def place(first: int, last: int) -> list[int]:
            row, offsets = self.start(first), self.offsets._address + 8 * first
            table_part = table._address + 8 * ROW_COLUMNS * (row - self.start(begin))
            return [offsets, last - first + 1, table_part, self.start(last) - row]

        self._run(begin, end, place)

    def _run(self, begin: int, end: int, place: Callable[[int, int], list[int]]) -> bool:
        """Run the kernel on rays begin..end; `place` returns its arguments for offsets and rows of some of them."""

        def numbers(first: int, last: int) -> list[int]:
            first, last = begin + first, begin + last
            parts = (self._arrays, (self.counts, self.doubts))
            lines, own = ([n for each in part for n in each._part(first, last, self._count)] for part in parts)
            return [*lines, int(self._spans), *place(first, last), *own]

        width = self._width if begin == 0 and end == self._count else 0
        return self.gpu.run_on_card("list_rows", numbers, end - begin, self._scene, width)


class _DeviceLists:
    """Rows of rays, stored one after the other, those of ray i at offsets[i]:offsets[i + 1]. Fields are on the card.

    The fields of `Spans` and `Crossings` that are not here are those of `to_host()`.
    """

    _host: ClassVar[type[RayLists]]
    _of_spans: ClassVar[bool]
    _kernel: ClassVar[str]
    offsets: DeviceArray

    def __init__(self, scene: PreparedScene, gpu: Device, rays: DeviceRays, arrays: Any) -> None:
        self._scene, self.rays = scene, rays
        rows = _RayRows(scene, gpu, rays, arrays, self._of_spans)
        if rows.count():
            vars(self).update(self._columns_of(rows, arrays))
            return
        query = ray_queries.spans if self._of_spans else ray_queries.crossings
        lists: Any = query(scene, *_here(rays, arrays), "cpu")
        vars(self).update({name: upload(gpu, getattr(lists, name)) for name in ("offsets", *lists._columns)})

    def _columns_of(self, rows: _RayRows, arrays: Any) -> dict[str, DeviceArray]:
        """Return the fields, from rows that were counted; exact methods find those of doubtful rays."""
        gpu, offsets, total, more = rows.gpu, rows.offsets, int(rows.starts[-1]), list[Any]()
        (table,) = new_arrays(gpu, ((total, ROW_COLUMNS), "f8"))
        if total:
            rows.write(table, 0, len(rows.counts))
        doubtful = np.asarray(rows.doubts).nonzero()[0]
        if len(doubtful):
            some, every = _some(arrays, doubtful), np.arange(len(doubtful))
            resolved = resolve_rows(self._scene, some, every, self._of_spans)
            own, joined = np.array([len(each) for each in resolved], np.int32), np.concatenate(resolved)
            padded = np.zeros((len(joined), ROW_COLUMNS))
            padded[:, : joined.shape[1]] = joined
            put_rows(rows.counts, doubtful, own)
            offsets, starts = _offsets_of(gpu, rows.counts)
            put_rows(rows.counts, doubtful, np.zeros_like(own))  # also of rays that sorting found doubtful
            its = np.cumsum(own, dtype=np.int64) - own, own, padded, fetch_rows(offsets, doubtful)
            more, total = [[upload(gpu, each) for each in its]], int(starts[-1])
        fields, named = self._new_columns(gpu, total)
        for first, counts, some, put in [(rows.offsets, rows.counts, table, offsets), *more]:
            n = len(counts)
            numbers = [first._address, n, counts._address, n, some._address, len(some), put._address, n]
            numbers += [number for each in fields for number in (each._address, total)]
            gpu.run_on_card(self._kernel, lambda *_, given=numbers: given, n)
        return {"offsets": offsets, **named}

    def _new_columns(self, gpu: Device, total: int) -> tuple[Any, dict[str, DeviceArray]]:
        """Return columns as a kernel takes them, and by their names."""
        raise NotImplementedError

    @property
    def shape(self) -> tuple[int, ...]:
        """The leading shape of the rays."""
        return self.rays.shape

    def __len__(self) -> int:
        return len(self.offsets) - 1

    def __repr__(self) -> str:
        return f"{type(self).__name__}(shape={self.shape})"

    def to_host(self) -> Any:
        """Return a copy in the memory of the CPU, which has all other fields: `Spans` or `Crossings`."""
        lists = object.__new__(self._host)
        columns = {name: np.asarray(getattr(self, name)) for name in ("offsets", *self._host._columns)}
        vars(lists).update(columns, _rays=self.rays.to_host(), _scene=self._scene)
        freeze_arrays(lists)
        return lists


class DeviceSpans(_DeviceLists):
    """Spans of rays on a card. Those of ray i are rows offsets[i]:offsets[i + 1], sorted by t_enter.

    Attributes
    ----------
    t_enter, t_exit : float64 (spans,)
        In units of the direction's length.
    body : int32 (spans,)
        Number of the body.
    enter_clipped, exit_clipped : bool (spans,)
        As those of `Spans`.
    offsets : int64 (rays + 1,)
        The first row of each ray.
    rays : DeviceRays
        The traced rays.
    """

    t_enter: DeviceArray
    t_exit: DeviceArray
    body: DeviceArray
    enter_clipped: DeviceArray
    exit_clipped: DeviceArray
    _host, _of_spans, _kernel = Spans, True, "put_span_rows"

    def _new_columns(self, gpu: Device, total: int) -> tuple[Any, dict[str, DeviceArray]]:
        one, two = (total,), (2, total)
        fields = _CardSpans(*new_arrays(gpu, (one, "f8"), (one, "f8"), (one, "i4"), (two, "?"), (two, "i4")))
        t_enter, t_exit, body, clipped, ends = fields
        columns = t_enter, t_exit, body, clipped._row(0, one), clipped._row(1, one), ends
        return fields, dict(zip(Spans._columns, columns, strict=True))


class DeviceCrossings(_DeviceLists):
    """Crossings of rays on a card. Those of ray i are rows offsets[i]:offsets[i + 1], sorted by t.

    Attributes
    ----------
    t : float64 (n,)
        In units of the direction's length.
    body, face, surface : int32 (n,)
        Numbers.
    entering : bool (n,)
        Whether the ray runs against the outward normal.
    offsets : int64 (rays + 1,)
        The first row of each ray.
    rays : DeviceRays
        The traced rays.
    """

    t: DeviceArray
    body: DeviceArray
    face: DeviceArray
    surface: DeviceArray
    entering: DeviceArray
    _host, _of_spans, _kernel = Crossings, False, "put_crossing_rows"

    def _new_columns(self, gpu: Device, total: int) -> tuple[Any, dict[str, DeviceArray]]:
        fields = _CardCrossings(*new_arrays(gpu, *(((total,), kind) for kind in ("f8", "i4", "i4", "i4", "?"))))
        return fields, fields._asdict()


def _sums(
    scene: PreparedScene, gpu: Device, rays: DeviceRays, arrays: Any, plan: line_integrals.SumPlan,
    progress: Progress | None,
) -> DeviceArray:  # fmt: skip
    """Return `lengths` or `line_integral`. It writes about `_ROWS` spans at a time, and sums them up."""
    count, width, rows = len(arrays.origins), plan.table.shape[1], _RayRows(scene, gpu, rays, arrays, True)
    if not rows.count():
        return upload(gpu, line_integrals.sum_along(scene, *_here(rays, arrays), plan, progress, "cpu"))
    total, crossed = new_arrays(gpu, ((count, width), "f8"), ((count,), "i1"))
    tables = [upload(gpu, each) for each in (plan.places(scene), plan.table)]
    constants = [*(n for each in tables for n in (each._address, each.size)), width, int(plan.is_grouped)]
    begin = 0
    while begin < count:
        # As many rays as fit, but at least `SUMMED`, however many rows these have
        last = int(np.searchsorted(rows.starts, rows.start(begin) + _ROWS, side="right")) - 1
        end = min(count, max(begin + SUMMED, SUMMED * last))
        used, n = rows.start(end) - rows.start(begin), end - begin
        (table,) = new_arrays(gpu, ((used, ROW_COLUMNS), "f8"))
        if used:
            rows.write(table, begin, end)
        given = [*arrays.directions._part(begin, end, count), rows.offsets._address + 8 * begin, n + 1]
        made = [total._address + 8 * width * begin, width * n, *crossed._part(begin, end, count)]
        numbers = [*given, table._address, used, *constants, *made]
        gpu.run_on_card("sum_spans", lambda *_, given=numbers: given, n)
        begin = end
        if progress is not None:
            progress(end, count)
    marks = line_integrals.marks_of(np.asarray(rows.doubts), np.asarray(crossed))
    for which, sums in plan.exact_sums(scene, marks, lambda some: _some(arrays, some), rays._home):
        put_rows(total, which, sums)
    return total


# Queries of points


def _points_of(query: str, gpu: Device, points: Any) -> tuple[DeviceArray, tuple[int, ...]]:
    """Return points (n, 3) as kernels take them, and their leading shape."""
    view = view_of(query, "points", points, gpu)
    flat = view.vectors(gpu, view.shape)
    if find_flag(gpu, "check_points", [flat._address, len(flat)], len(flat)):
        at_points.points_of(query, np.asarray(flat._as(view.shape)))  # which raises
    return flat, view.shape[:-1]


def _bodies_of(scene: PreparedScene, query: str, gpu: Device, flat: DeviceArray) -> DeviceArray:
    """Return the first body at each point, int32 (n,)."""
    count = len(flat)
    bodies, undecided = new_arrays(gpu, ((count,), "i4"), ((count,), "i1"))
    if not _trace(scene, gpu, "first_bodies", (flat, upload(gpu, at_points.BEFORE_FIRST)), (bodies, undecided)):
        return upload(gpu, at_points.body_at(scene, np.asarray(flat), query, "cpu"))
    doubtful = np.asarray(undecided).nonzero()[0]
    if len(doubtful):
        found = np.empty(len(doubtful), np.int32)
        resolve_bodies(scene, fetch_rows(flat, doubtful), at_points.BEFORE_FIRST, np.arange(len(doubtful)), found)
        put_rows(bodies, doubtful, found)
    return bodies


def query_points(scene: PreparedScene, query: str, executor: Any, device: str | None, points: Any) -> DeviceArray:
    """Return the first body at each point on a card, or whether there is one."""
    gpu = _open(query, executor, device)
    flat, shape = _points_of(query, gpu, points)
    bodies, count = _bodies_of(scene, query, gpu, flat), len(flat)
    if query == "body_at":
        return bodies._as(shape)
    (result,) = new_arrays(gpu, ((count,), "i1"))
    gpu.run_on_card("are_bodies", lambda first, last: [bodies._address, count, result._address, count], count)
    return result._as(shape, np.bool_)


class DeviceDistances:
    """Bounds of distances of points on a card, shaped like the points.

    Attributes
    ----------
    distance, lower, error : float64 (...)
        As those of `Distances`, as `DeviceArray`.
    points : float64 (..., 3)
        The points of the query.
    shape : tuple of int
        That of `distance`.
    """

    def __init__(self, scene: PreparedScene, points: DeviceArray, fields: Sequence[DeviceArray]) -> None:
        self._scene, self.points, self.shape = scene, points, points.shape[:-1]
        self.distance, self.lower, self.error = (each._as(self.shape) for each in fields)

    def __repr__(self) -> str:
        return f"DeviceDistances(shape={self.shape})"

    def to_host(self) -> at_points.Distances:
        """Return a copy in the memory of the CPU, which has all other fields."""
        found = at_points.Nearest.nothing(self.distance.size)
        for name in ("distance", "lower", "error"):
            getattr(found, name)[:] = np.asarray(getattr(self, name)).ravel()
        return at_points.Distances(self._scene, np.asarray(self.points), found)


def query_distances(
    scene: PreparedScene, executor: Any, points: Any, max_distance: Any, exact: bool, progress: Progress | None
) -> DeviceDistances:
    """Return bounds of the distances of points on a card."""
    gpu = _open("distance", executor, None)
    if exact:
        raise TypeError("distance: exact must be False for arrays on a card, got True; copy them to NumPy")
    flat, shape = _points_of("distance", gpu, points)
    reach = at_points.reach_of(max_distance, shape if np.ndim(max_distance) else ())
    count, limit = len(flat), upload(gpu, reach if len(reach) else np.ones(1))
    distance, lower, error = fields = new_arrays(gpu, *[((count,), "f8")] * 3)
    if _trace(scene, gpu, "wall_bounds", (flat, limit), (lower,)):
        bodies = _bodies_of(scene, "distance", gpu, flat)
        numbers = [bodies._address, count, limit._address, len(limit)]
        numbers += [number for each in (distance, lower, error) for number in (each._address, count)]
        gpu.run_on_card("sign_distances", lambda first, last: numbers, count)
    else:
        found = at_points.distance_bounds(scene, np.asarray(flat), np.ascontiguousarray(np.broadcast_to(reach, count)))
        fields = [upload(gpu, each) for each in (found.distance, found.lower, found.error)]
    if progress is not None:
        progress(count, count)
    return DeviceDistances(scene, flat._as((*shape, 3)), fields)


class DeviceHits:
    """First hits of rays on a card, shaped like the rays. Each field is a `DeviceArray`, made when it is needed.

    They hold the rays, which share arrays of float64 in C order with their owner. Writing to these arrays changes
    fields that are computed later.

    Attributes
    ----------
    t : float64 (...)
        In units of the direction's length; inf for a miss.
    body, face, surface : int32 (...)
        Numbers; -1 for a miss.
    hit, entering, doubtful : bool (...)
        As those of `Hits`.
    point, normal : float64 (..., 3)
        NaN for a miss.
    uv : float64 (..., 2)
        NaN for a miss.
    rays : DeviceRays
        The traced rays.
    shape : tuple of int
        That of `t`.
    """

    def __init__(self, scene: PreparedScene, device: Device, rays: DeviceRays, found: Any, doubtful: Any) -> None:
        self._scene, self._device, self._found, self._doubtful = scene, device, found, doubtful
        self.rays, self.shape, self._count = rays, rays.shape, len(found.t)

    def __repr__(self) -> str:
        return f"DeviceHits(shape={self.shape})"

    def to_host(self) -> Hits:
        """Return a copy in the memory of the CPU, which has all other fields."""
        return Hits(self._scene, self.rays.to_host(), HitBuffers(*map(np.asarray, self._found)), self._doubtful)

    def spawn(self, directions: Any) -> DeviceRays:
        """Return rays on the card that start exactly on the hits, as `Hits.spawn` does.

        Parameters
        ----------
        directions : (..., 3)
            An array on the card. It broadcasts to the hits, or has axes before theirs: (many, *hits.shape, 3) starts
            many rays on each hit. Rays from misses miss everything.

        Raises
        ------
        ValueError
            For a NaN, infinite or zero direction of a hit, with its index.
        """
        gpu = self._device
        view = view_of("spawn", "directions", directions, gpu)
        shape = spawned_shape(self.shape, view.shape)
        d = view.vectors(gpu, (*shape, 3))
        count, points, (starts,) = len(d), self._points, new_arrays(gpu, ((len(d),), "i4"))
        given = [n for each in (self._found.body, self.surface) for n in (each._address, self._count)]
        if find_flag(gpu, "start_rays", [*given, d._address, count, starts._address, count], count):
            refuse_directions(np.asarray(d), np.broadcast_to(np.asarray(self.hit), shape).ravel(), shape)
        if shape != self.shape:
            points = CardView(points._address, "f8", (*self.shape, 3), None, points).vectors(gpu, (*shape, 3))
        return DeviceRays(shape, (points, d), starts, self._scene.key)

    def _fill(self, function: str, inputs: Sequence[Any], outputs: Sequence[Any], flag: Any = None) -> None:
        """Run a kernel of the CPU's on all rows; one that has a flag needs no tables."""
        n = self._count
        given, made = ([number for x in some for number in (x._address, n)] for some in (inputs, outputs))
        numbers = [*given, n, *made, *([] if flag is None else [flag._address])]
        self._device.run_on_card(function, lambda first, last: numbers, n, self._scene if flag is None else None)

    def _flags(self, function: str, array: Any) -> DeviceArray:
        """Return a number for each ray, 0 or 1, as bool."""
        n, (result,) = self._count, new_arrays(self._device, ((self._count,), "i1"))
        self._device.run_on_card(function, lambda first, last: [array._address, n, result._address, n], n)
        return result._as(self.shape, np.bool_)

    @property
    def t(self) -> DeviceArray:
        return self._found.t._as(self.shape)

    @property
    def body(self) -> DeviceArray:
        return self._found.body._as(self.shape)

    @cached_property
    def hit(self) -> DeviceArray:
        return self._flags("are_bodies", self._found.body)

    @cached_property
    def entering(self) -> DeviceArray:
        return self._flags("are_entries", self._found.turn)

    @cached_property
    def doubtful(self) -> DeviceArray:
        flags = np.zeros(self._count, np.bool_)
        flags[self._doubtful] = True
        return upload(self._device, flags)._as(self.shape)

    @cached_property
    def _faces(self) -> DeviceArray:
        (faces,) = new_arrays(self._device, ((3, self._count), "i4"))
        self._fill("faces_of", self._found[2:], [faces])
        return faces

    @property
    def surface(self) -> DeviceArray:
        return self._faces._row(0, self.shape)

    @property
    def face(self) -> DeviceArray:
        return self._faces._row(1, self.shape)

    @cached_property
    def _points(self) -> DeviceArray:
        far, (points,) = (
            upload(self._device, np.zeros(1, np.int8)),
            new_arrays(self._device, ((self._count, 3), "f8")),
        )
        lines, found = self.rays._lines, self._found
        self._fill("hit_points", [*lines, found.t], [points], far)
        if np.asarray(far)[0]:
            (errors,) = new_arrays(self._device, ((self._count,), "f8"))
            self._fill("refine_points", [*lines, found.t, found.turn, self._faces], [points, errors])
        return points

    @property
    def point(self) -> DeviceArray:
        return self._points._as((*self.shape, 3))

    @cached_property
    def normal(self) -> DeviceArray:
        n, (normals,) = self._count, new_arrays(self._device, ((self._count, 3), "f8"))
        self._fill("normals_of", [self._faces, self._points], [normals])
        self._device.run_on_card("clear_negligible", lambda first, last: [normals._address, n], n)
        return normals._as((*self.shape, 3))

    @cached_property
    def uv(self) -> DeviceArray:
        (uv,) = new_arrays(self._device, ((self._count, 2), "f8"))
        self._fill("uvs_of", [self._found.body, self._faces, self._points], [uv])
        return uv._as((*self.shape, 2))
