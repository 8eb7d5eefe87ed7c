"""Lists of rows for each ray, indexed by ray: `spans[i]`, `len(crossings)`, `for one in spans`."""

from __future__ import annotations

import contextlib
import math
import os
import threading
from collections.abc import Callable, Iterable, Iterator
from functools import cached_property
from typing import TYPE_CHECKING, Any, ClassVar, Literal, Self

import numpy as np
import numpy.typing as npt

from .._util.arrays import FloatArray
from .._util.errstate import ignore_fp_errors
from .._util.foreign_names import with_attribute_hints
from .._util.hints import closest_name, with_method_hints
from .._util.name_tuples import NamedPartTuple
from .._util.pickling import freeze_arrays
from .._util.validation import check_npz_path, format_value, zero_negligible
from ..geometry.labels import Labels, format_count
from ..kernels.body.media import AFTER, BEFORE
from ..kernels.entry.crossings import (
    CrossingColumns,
    CrossingLists,
    SpanColumns,
    _Piece,
    put_crossings,
    put_spans,
    row_owners,
    trace_rows,
)
from ..kernels.ray import RayArrays
from ..kernels.tables import Geometry
from ..kernels.threads import chunk_of_rays, run_chunks, run_on
from .derivative_methods import SpanDerivatives
from .exact.doubtful_rays import resolve_rows
from .exact.error_bounds import bounds_of_t
from .exact.hit_sides import HitPlaces, sides_of
from .hit_fields import normals_of, points_along
from .id_arrays import as_id_array, number_fields
from .rays import Rays, lines_of, refuse_name_index, refuse_pairs
from .result import QueryResult, format_crossings, format_spans
from .weights import BODY, DistinctMaterials, Weights, check_by, weights_of

if TYPE_CHECKING:
    from ..prepare.prepared_scene import PreparedScene


@with_method_hints
class RayLists:
    """A sequence over flat rays (in C order). A number selects one ray's rows; a slice, numbers or a mask several rays.

    One ray's rows are true where there are any.
    """

    _columns: ClassVar[tuple[str, ...]]
    offsets: Any
    _rays: Rays

    @property
    def rays(self) -> Rays:
        """Those that were asked."""
        return self._rays

    @property
    def shape(self) -> tuple[int, ...]:
        """The leading shape of the rays; how many rows each has is np.diff(offsets)."""
        return self._rays.shape

    @classmethod
    def concatenate(cls, parts: Iterable[Self]) -> Self:
        """Rows of rays one after the other along the first axis of the rays; single ones count as rows of one.

        `parts` are of one scene, with it or without. Raises TypeError for what is of another kind, ValueError for none
        at all, for shapes that do not fit and for different scenes, whose body numbers mean different things.
        """
        from .concatenate import concatenate_lists

        return concatenate_lists(cls, parts)

    def save(self, path: str | os.PathLike[str]) -> None:
        """Write all fields as a .npz file at `path`, which `load` reads; the scene stays behind, as with `detached`.

        The file appears whole or not at all. Raises ValueError for another suffix, OSError where it cannot be written.
        """
        from ..io.result_file import write_lists_file

        write_lists_file(check_npz_path("save", type(self).__name__.lower(), path), self)

    @classmethod
    def load(cls, path: str | os.PathLike[str]) -> Self:
        """What is in the file at `path` that `save` wrote, detached from its scene. Nothing in a file is executed.

        Raises ValueError for what is no such file, naming it, and OSError where it cannot be read.
        """
        from ..io.result_file import read_lists_file

        return read_lists_file(check_npz_path("load", cls.__name__.lower(), path), cls)

    def __len__(self) -> int:
        """How many rays there are; one for a single ray."""
        return len(self.offsets) - 1

    def __bool__(self) -> bool:
        if len(self) != 1:
            raise ValueError(
                f"{type(self).__name__}: the truth value of the rows of {len(self)} rays is ambiguous; "
                "np.diff(offsets) > 0 tells it for each"
            )
        return bool(self.offsets[1] > 0)

    def __iter__(self) -> Iterator[Self]:
        for i in range(len(self)):
            refuse_pairs(type(self).__name__)
            yield self[i]

    def __getitem__(self, index: Any) -> Self:
        """The rows of a flat ray, or of several."""
        refuse_name_index(self, index)
        which = self._which(index)
        flat = np.ravel(which)
        counts = np.diff(self.offsets)[flat].astype(np.intp, copy=False)
        offsets = np.concatenate([[0], np.cumsum(counts, dtype=np.int64)])
        first = np.repeat(self.offsets[flat], counts)
        rows = first + np.arange(offsets[-1]) - np.repeat(offsets[:-1], counts)
        part = object.__new__(type(self))
        kept = {name: value for name, value in vars(self).items() if not hasattr(type(self), name)}
        # What has been worked out stays, as answers without their scene cannot do it again
        known = {name: vars(self)[name] for name in vars(self) if hasattr(type(self), name)}
        kept |= {name: value[rows] if isinstance(value, np.ndarray) else value for name, value in known.items()}
        rays = self._rays if self._rays.shape else self._rays[None]
        part.__dict__.update(
            kept,
            offsets=offsets.astype(self.offsets.dtype),
            _rays=rays[np.unravel_index(which, rays.shape)],
            # in C order, as kernels were compiled for
            **{name: np.take(getattr(self, name), rows, axis=-1) for name in self._columns},
        )
        freeze_arrays(part)
        return part

    def _which(self, index: Any) -> Any:
        """The numbers of the flat rays that an index selects."""
        if np.asarray(index).dtype == np.bool_ and np.shape(index) == (int(self.offsets[-1]),) != (len(self),):
            name, field = type(self).__name__.lower(), self._columns[0]
            raise IndexError(
                f"{type(self).__name__}: a mask selects rays, of which there are {len(self)}, got one of "
                f"{int(self.offsets[-1])} rows: {name}.{field}[mask] has the rows of a field"
            )
        if np.shape(index) == self._rays.shape != () and np.asarray(index).dtype == np.bool_:
            index = np.ravel(index)
        is_flat = np.ndim(index) < 2 and not (isinstance(index, tuple) and len(index) != 1)
        which = np.arange(len(self))[index] if is_flat else None
        if which is None or which.ndim > 1:
            raise IndexError(
                f"{type(self).__name__}: index must be a number, a slice, a list of numbers or a mask over the "
                f"{format_count(len(self), 'ray', 'rays')}, got {format_value(index)}{self._meant(index)}"
            )
        return which

    def _meant(self, index: Any) -> str:
        """What may be meant by several numbers: a ray of a picture by its axes, or a row of a ray."""
        if not isinstance(index, tuple) or not all(isinstance(i, int) for i in index):
            return ""
        name, shape = type(self).__name__.lower(), self._rays.shape
        if len(index) == len(shape) > 1 and all(-n <= i < n for i, n in zip(index, shape, strict=True)):
            flat = int(np.arange(len(self)).reshape(shape)[index])
            return f"; rays are counted flat: that of the index {index} is {name}[{flat}]"
        if len(index) == 2 and len(shape) < 2:
            return f"; one row of one ray is {name}[{index[0]}].{self._columns[0]}[{index[1]}]"
        return ""


# What is told of answers beside them, once for each scene: in the log, or, in a task, to the one who asked.

_task_notes = threading.local()


@contextlib.contextmanager
def collect_notes() -> Iterator[list[str]]:
    """What this thread tells within the block, which is not logged here."""
    before, notes = getattr(_task_notes, "notes", None), list[str]()
    _task_notes.notes = notes
    try:
        yield notes
    finally:
        _task_notes.notes = before


def log_once(labels: Labels, text: Callable[[], str]) -> None:
    """Log a text, of the first answer of a scene alone, which its labels stand for; a task has one for its asker."""
    notes = getattr(_task_notes, "notes", None)
    if notes is not None:
        notes.extend([] if notes else [text()])
    elif not vars(labels).get("_told_overlaps"):
        vars(labels)["_told_overlaps"] = True
        import logging

        logging.getLogger("conicoid").warning("%s", text())


# Stretches of rays that lie in two bodies at once, which sums over bodies count twice: they are told of.

COUNT_BOTH, REFUSE_OVERLAPS = "both", "error"
_THIN_OVERLAP, _ROUNDING_OVERLAP = 1e-5, 1e-9
"""Of the longest stretch, and of the distance: less is what numbers with few digits leave between walls."""


def check_overlaps(owner: str, overlaps: Any) -> str | None:
    """How stretches within two bodies count; a ValueError for anything but "both", "error" and None."""
    if overlaps is not None and overlaps not in (COUNT_BOTH, REFUSE_OVERLAPS):
        close = closest_name(overlaps, (COUNT_BOTH, REFUSE_OVERLAPS)) if isinstance(overlaps, str) else ""
        meant = f" (did you mean {close!r}?)" if close else ""
        raise ValueError(f"{owner}: overlaps must be 'both', 'error' or None, got {format_value(overlaps)}{meant}")
    return overlaps


def report_overlaps(owner: str, spans: Spans, overlaps: str | None, kinds: Any, counts: Any) -> None:
    """Refuse overlaps of stretches that are added up, for "error"; for None log them, once for a scene.

    kinds: what each stretch is added up with, a number, or None where all are added up; counts: which count at all.
    """
    if overlaps == COUNT_BOTH or not len(spans.body):
        return
    rows = np.arange(len(spans.body)) if counts is None else np.flatnonzero(counts)
    found = _find_overlaps(spans, rows)
    if len(found[0]) and kinds is not None:
        found = _find_overlaps(spans, rows[np.lexsort((rows, kinds[rows], _rays_of_rows(spans)[rows]))], kinds)
    if not len(found[0]):
        return
    if overlaps == REFUSE_OVERLAPS:
        raise ValueError(_overlap_message(owner, spans, *found) + "; co.check(scene) finds all")
    log_once(spans._labels, lambda: _overlap_message(owner, spans, *found) + _OVERLAP_HINT)


_OVERLAP_HINT = "; overlaps='both' says that it is meant, and overlaps='error' refuses it"


def _find_overlaps(spans: Spans, rows: Any, kinds: Any = None) -> tuple[Any, Any]:
    """Neighbours among some rows, sorted by ray and start, that overlap. If any two of a ray do, two neighbours do."""
    one, other = rows[:-1], rows[1:]
    ray = _rays_of_rows(spans)
    same = ray[one] == ray[other]
    if kinds is not None:
        same &= kinds[one] == kinds[other]
    start, end = spans.t_enter[other], spans.t_exit[one]
    common = np.minimum(end, spans.t_exit[other]) - start
    stretches = spans.t_exit - spans.t_enter
    longest = stretches.max(initial=0.0, where=np.isfinite(stretches))
    far = np.maximum(np.abs(start), np.abs(end))
    thick = np.isinf(common) | ((common > _THIN_OVERLAP * longest) & (common > _ROUNDING_OVERLAP * far))
    found = same & (common > 0) & thick
    return one[found], other[found]


def _rays_of_rows(spans: Spans) -> Any:
    """The flat ray of every row."""
    return row_owners(spans.offsets)


def _overlap_message(owner: str, spans: Spans, one: Any, other: Any) -> str:
    """What is told of the first overlap."""
    ray = _rays_of_rows(spans)[one]
    rays, first = format_count(len(np.unique(ray)), "ray goes", "rays go"), int(ray[0])
    origin, direction = (tuple(part.reshape(-1, 3)[first].tolist()) for part in spans.rays)
    names = spans.name
    rows = sorted((int(one[0]), int(other[0])), key=lambda k: int(spans.body[k]))
    pair = " and ".join(_body_label(int(spans.body[k]), names[k]) for k in rows)
    return (
        f"{owner}: {rays} through two bodies at once, and such a stretch counts for each: {pair} overlap on the "
        f"ray from {origin} along {direction}"
    )


def _body_label(number: int, name: Any) -> str:
    return f"body {number}" + (f" {format_value(name)}" if name else "")


# Lists of different length for each ray, one after the other: spans and crossings (CSR layout).

LARGEST_LENGTHS = 4 << 30
_SPAN_CHUNK = 16384


def refuse_large_lengths(rays: int, columns: int, by: str) -> None:
    """ValueError for an array of lengths that would be absurd."""
    if rays * columns * 8 > LARGEST_LENGTHS:
        what = "bodies" if by == BODY else "materials"
        raise ValueError(
            f"lengths: an array of {rays} rays x {columns} {what} would take {rays * columns * 8 / 2**30:.0f} GiB; "
            "use line_integral(values), or t_enter, t_exit and body"
        )


def _crossing_errors(scene: PreparedScene, rays: Rays, offsets: Any, t: FloatArray, surfaces: Any) -> FloatArray:
    """The bounds on the crossings of rays with surfaces, rows offsets[i]:offsets[i + 1] of ray i."""
    which = row_owners(offsets)
    errors = bounds_of_t(scene, lines_of(rays), rays._starts_in(scene), which, t, surfaces)
    errors.flags.writeable = False
    return errors


@with_attribute_hints
@with_method_hints
class Spans(QueryResult, RayLists, SpanDerivatives):
    """Stretches of rays inside solids. Those of flat ray i are rows offsets[i]:offsets[i + 1], sorted by t_enter.

    t_enter, t_exit   float64, in units of the direction's length
    body              int32
    enter_clipped, exit_clipped   bool: the end is the interval's (or infinity), not a wall
    t_enter_error, t_exit_error   float64: each end is at most so far from the exact one; 0 where it is clipped
    name, material    objects: what the body is called and made of
    materials         tuple: the different materials of the scene's bodies, the columns of lengths(by="material")
    rays, shape       the rays that were asked, and their leading shape

    Pickled, or `detached`, spans keep all these fields and do not keep the scene.
    """

    instead = "spans.t_enter, spans.t_exit and spans.body"
    t_enter: FloatArray
    t_exit: FloatArray
    body: npt.NDArray[np.int32]
    enter_clipped: npt.NDArray[np.bool_]
    exit_clipped: npt.NDArray[np.bool_]
    _ends: npt.NDArray[np.int32]
    _body_count: int
    _columns = ("t_enter", "t_exit", "body", "enter_clipped", "exit_clipped", "_ends")

    def __init__(self, scene: PreparedScene, rays: Rays, listed: CrossingLists) -> None:
        count = int(listed.offsets[-1])
        t_enter, t_exit, body = np.empty(count), np.empty(count), np.empty(count, np.int32)
        clipped, ends = np.empty((2, count), np.bool_), np.empty((2, count), np.int32)
        listed.put(put_spans, SpanColumns(t_enter, t_exit, body, clipped, ends))
        vars(self).update(
            offsets=listed.offsets, t_enter=t_enter, t_exit=t_exit, body=as_id_array("body", body),
            enter_clipped=clipped[0], exit_clipped=clipped[1], _ends=ends,
            _rays=rays, _scene=scene, _body_count=scene.lowered.body_count,
        )  # fmt: skip

    @cached_property
    def t_enter_error(self) -> FloatArray:
        return _crossing_errors(self._scene, self._rays, self.offsets, self.t_enter, self._ends[0])

    @cached_property
    def t_exit_error(self) -> FloatArray:
        return _crossing_errors(self._scene, self._rays, self.offsets, self.t_exit, self._ends[1])

    def _chords(self) -> tuple[Any, FloatArray]:
        """(flat index of the ray, true length) of every span."""
        ray = row_owners(self.offsets)
        directions = self._rays.directions.reshape(-1, 3)
        scale = np.abs(directions).max(axis=1, initial=0.0)
        scale = np.where(scale > 0, scale, 1.0)
        length = scale * np.sqrt(((directions / scale[:, None]) ** 2).sum(axis=1))
        return ray, (self.t_exit - self.t_enter) * length[ray]

    @cached_property
    def materials(self) -> tuple[Any, ...]:
        """The different materials of the scene, as `scene.materials`: the columns of lengths(by="material")."""
        return NamedPartTuple((material for material, _ in self._distinct), "spans.materials")

    @cached_property
    def _distinct(self) -> DistinctMaterials:
        return self._labels.distinct

    def __getstate__(self) -> dict[str, Any]:
        return {"_distinct": self._distinct, **super().__getstate__()}

    def _places(self, by: str) -> tuple[Any, int]:
        """(column of every span, how many columns there are)."""
        if by == BODY:
            return self.body, self._body_count
        return self._labels.columns_of(self.body, self.materials), len(self.materials)

    @ignore_fp_errors
    def lengths(
        self, by: Literal["body", "material"] = "body", *, overlaps: Literal["both", "error"] | None = None
    ) -> FloatArray:
        """True length of each ray inside each body, (t_exit - t_enter)·|direction|: (..., bodies).

        by: "body", or "material" for the sums over the bodies of each material, in the order of `materials`:
            (..., materials). Two materials of one name that differ in anything are two columns.

        overlaps: where bodies overlap, the stretch counts for each of them, and where they have one material, twice in
            its sum. "both" says that this is meant and "error" raises a ValueError; None logs the first of a scene.

        Raises ValueError where that array would take more than 4 GiB: `line_integral` needs none.
        """
        places, count = self._places(check_by("lengths", by))
        rays = len(self.offsets) - 1
        refuse_large_lengths(rays, count, by)
        if check_overlaps("lengths", overlaps) is not None or by != BODY:
            report_overlaps("lengths", self, overlaps, None if by == BODY else places, None)
        ray, chord = self._chords()
        result = np.zeros(rays * count)
        if len(chord):
            result += np.bincount(ray * count + places, chord, rays * count)
        return result.reshape((*self._rays.shape, count))

    @ignore_fp_errors
    def line_integral(
        self, values: Any, otherwise: Any = None, *, overlaps: Literal["both", "error"] | None = None
    ) -> Any:
        """Sum over spans of value × length: (...), or (..., energies). A zero stays zero on infinite spans.

        values: an array (bodies,) or (bodies, energies); or a mapping from the names of materials to numbers or
            arrays (energies,), a name standing for all materials that have it; or the name of a property of materials.
        otherwise: stands for materials without such a value, which are a ValueError if it is not given.
        overlaps: where bodies overlap, the stretch counts for each of them. "both" says that this is meant and "error"
            raises a ValueError; None logs the first of a scene, unless values of both signs say that it is meant.
        """
        weights = weights_of(values, otherwise, self._body_count, self._distinct)
        total = self._integral(weights, check_overlaps("line_integral", overlaps))
        return total.reshape((*self._rays.shape, *total.shape[1:]))[()]

    def _integral(self, weights: Weights, overlaps: str | None) -> FloatArray:
        """(rays,) or (rays, energies)."""
        places, _ = self._places(weights.by)
        table = weights.values.reshape(len(weights.values), math.prod(weights.shape))
        if overlaps == REFUSE_OVERLAPS or not (weights.values < 0).any():
            counts = (table != 0).any(axis=1)
            report_overlaps("line_integral", self, overlaps, None, counts[places])
        ray, chord = self._chords()
        count, columns = len(self.offsets) - 1, table.T
        total = np.zeros((count, len(columns)))
        for energy, column in enumerate(columns if count else ()):
            weight = column[places]
            part = np.where(weight == 0, 0.0, weight * np.where(weight == 0, 0.0, chord))
            total[:, energy] = np.bincount(ray, part, count)
        return total.reshape((count, *weights.shape))

    def __repr__(self) -> str:
        if not self.shape:
            return f"Spans(shape=(), {format_spans(self)})"
        return f"Spans(shape={self._rays.shape}, {format_count(len(self.body), 'span', 'spans')})"


@with_attribute_hints
@with_method_hints
class Crossings(QueryResult, RayLists):
    """Every crossing of rays with bodies. Those of flat ray i are rows offsets[i]:offsets[i + 1], sorted by t.

    t                    float64, in units of the direction's length
    body, face, surface  int32
    entering             bool: against the outward normal
    point, normal        float64 (n, 3): the place, and the unit outward normal there
    t_error              float64: t is at most so far from the exact crossing
    before, after        int32: the body that the ray is in before and after it, as in `Hits`; -1 for none
    name, material       objects: what the body is called and made of
    rays, shape          the rays that were asked, and their leading shape

    Pickled, or `detached`, crossings keep all these fields and do not keep the scene.
    """

    instead = "crossings.t, crossings.point and crossings.body"
    t: FloatArray
    entering: npt.NDArray[np.bool_]
    body: npt.NDArray[np.int32]
    face: npt.NDArray[np.int32]
    surface: npt.NDArray[np.int32]
    _columns = ("t", "entering", "body", "face", "surface")

    def __init__(self, scene: PreparedScene, rays: Rays, listed: CrossingLists) -> None:
        count = int(listed.offsets[-1])
        t, entering = np.empty(count), np.empty(count, np.bool_)
        body, face, surface = (np.empty(count, np.int32) for _ in range(3))
        listed.put(put_crossings, CrossingColumns(t, body, face, surface, entering))
        vars(self).update(
            offsets=listed.offsets, t=t, entering=entering, _scene=scene, _rays=rays,
            **number_fields({"body": body, "face": face, "surface": surface}),
        )  # fmt: skip

    @property
    def _rows_rays(self) -> tuple[FloatArray, FloatArray]:
        """(origins, directions) of every row."""
        rays = row_owners(self.offsets)
        origins, directions = lines_of(self._rays)
        return origins[rays], directions[rays]

    @cached_property
    def point(self) -> FloatArray:
        points = np.empty((len(self.t), 3))
        o, d = self._rows_rays
        run_chunks(lambda a, b: points_along(o, d, self.t, a, b, points), len(points), _SPAN_CHUNK)
        points.flags.writeable = False
        return points

    @cached_property
    @ignore_fp_errors
    def normal(self) -> FloatArray:
        points, normals = self.point, np.empty((len(self.t), 3))
        faces = np.stack([self.surface, self.face, np.ones_like(self.face)])
        geometry = self._scene.geometry
        run_chunks(lambda a, b: normals_of(geometry, faces, points, a, b, normals), len(points), _SPAN_CHUNK)
        along = (normals * self._rows_rays[1]).sum(axis=1)
        normals[(along < 0) != self.entering] *= -1
        result = zero_negligible(normals)
        result.flags.writeable = False
        return result

    @cached_property
    def t_error(self) -> FloatArray:
        return _crossing_errors(self._scene, self._rays, self.offsets, self.t, self.surface)

    @cached_property
    def _sides(self) -> Any:
        """(n, 3): bodies before and after each crossing, and the first opaque one that is crossed there."""
        scene, starts = self._scene, self._rays._starts_in(self._scene)
        starts = starts if len(starts) == 1 else starts[row_owners(self.offsets)]
        limits = np.array([-np.inf]), np.array([np.inf])
        turns = np.where(self.entering, 2, 1).astype(np.int8)
        places = HitPlaces(self.t, self.surface, self.body.astype(np.int32), turns)
        sides = np.ascontiguousarray(sides_of(scene, RayArrays(*self._rows_rays, *limits, starts), places).T)
        sides.flags.writeable = False
        return sides

    @cached_property
    def before(self) -> npt.NDArray[np.int32]:
        """int32: the body that the ray is in just before each crossing, as `Hits.before`; -1 for none."""
        result: npt.NDArray[np.int32] = as_id_array("before", self._sides[:, BEFORE])
        return result

    @cached_property
    def after(self) -> npt.NDArray[np.int32]:
        """int32: the body that the ray is in just after each crossing, as `Hits.after`; -1 for none."""
        result: npt.NDArray[np.int32] = as_id_array("after", self._sides[:, AFTER])
        return result

    def __repr__(self) -> str:
        if not self.shape:
            return f"Crossings(shape=(), {format_crossings(self)})"
        return f"Crossings(shape={self._rays.shape}, {format_count(len(self.t), 'crossing', 'crossings')})"


# Spans and crossings of arrays of rays: traced in chunks, put together in the rays' order.

_LIST_PACKETS = 64


def trace_lists(scene: PreparedScene, rays: RayArrays, width: int, packets: int, spans: bool) -> CrossingLists:
    """All spans, or crossings, of some packets of rays; `width`: see `packet_row` of kernels/packet/lanes.py."""
    count = len(rays.origins)
    counts, doubts = np.zeros(count, np.int32), np.zeros(count, np.int8)
    offsets, pieces = np.zeros(count + 1, np.int64), []

    def work(geometry: Geometry, begin: int, end: int) -> None:
        """Trace some packets, and keep their rows as a piece."""
        rows = trace_rows(geometry, rays, width, spans, begin, end, counts, doubts)
        pieces.append(_Piece(rows, counts, offsets[:-1], width, begin, end))

    run_on(scene.geometry, work, packets, chunk_of_rays(scene.geometry, packets, _LIST_PACKETS, count), count)
    doubtful = np.flatnonzero(doubts)
    if not len(doubtful):
        np.cumsum(counts, out=offsets[1:])
        return CrossingLists(offsets, pieces)
    settled = resolve_rows(scene, rays, doubtful, spans)
    own = np.array([len(rows) for rows in settled], np.int32)
    every = counts.copy()
    every[doubtful] = own
    np.cumsum(every, out=offsets[1:])
    last = _Piece(np.concatenate(settled), own, offsets[doubtful], 0, 0, -(-len(doubtful) // 64))
    return CrossingLists(offsets, [*pieces, last])
