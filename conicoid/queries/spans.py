"""`Spans` and `Crossings`: for each ray a list of rows, stored one after the other (the CSR layout).

The rows of ray i are offsets[i]:offsets[i + 1], where rays are numbered in C order. `RayLists` holds what both classes
share; the functions at the end trace rays in chunks and join the rows.
"""

from __future__ import annotations

import math
import os
from collections.abc import Callable, Iterable
from functools import cached_property
from typing import TYPE_CHECKING, Any, ClassVar, Literal, Self

import numpy as np
import numpy.typing as npt

from .._util.arrays import FloatArray, ignore_fp_errors
from .._util.records import freeze_arrays
from .._util.text import MOST_ROWS, NameTuple, format_count, html_table
from .._util.validation import check_npz_path, format_value, zero_negligible
from ..kernels.body.crossing_rows import (
    BODY as BODY_OF_ROW,
    ENTER,
    ENTER_CLIPPED,
    ENTER_SURFACE,
    ENTERS,
    EXIT,
    EXIT_CLIPPED,
    EXIT_SURFACE,
    FACE,
    SURFACE,
    T,
)
from ..kernels.body.media import AFTER, BEFORE
from ..kernels.crossings import (
    CrossingColumns,
    CrossingLists,
    SpanColumns,
    _Piece,
    integrate_spans,
    put_crossings,
    put_offsets,
    put_spans,
    row_owners,
    trace_rows,
)
from ..kernels.ray import RayArrays
from ..kernels.threads import KernelRange, chunk_of_rays, run_chunks, run_on, run_rows
from ..prepare.prepared_scene import PreparedScene
from .derivatives import SpanDerivatives
from .exact.doubtful_rays import resolve_rows
from .exact.error_bounds import bounds_of_t, refine_points
from .exact.hit_sides import HitPlaces, sides_of
from .hit_fields import hit_points, normals_of
from .overlaps import REFUSE_OVERLAPS, check_overlaps, report_overlaps
from .rays import Rays, join_rays, lines_of
from .result import (
    NO_SCENE,
    QueryResult,
    check_parts,
    common_scene_state,
    extension,
    format_body,
    format_field,
    format_rows,
)
from .weights import BODY, DistinctMaterials, LineValues, Weights, check_by, weights_of

if TYPE_CHECKING:
    from .device import Device


class _OfSingle(cached_property):  # type: ignore[type-arg]
    """A field of the rows of one ray, made where it is needed: programs that go ray by ray wait for it."""

    def __init__(self, field: Callable[[FloatArray], Any]) -> None:
        def read_only(lists: Any) -> Any:
            made = np.ascontiguousarray(field(np.asarray(lists._single[1])))
            made.flags.writeable = False
            return made

        super().__init__(read_only)


class RayLists:
    """A sequence over rays, numbered in C order: `x[i]` has the rows of one ray; a slice, list or mask selects several.

    The rows of one ray are true if there are any.
    """

    _columns: ClassVar[tuple[str, ...]]
    _views: ClassVar[tuple[str, ...]]
    offsets: Any
    _rays: Rays
    _single: tuple[Any, ...]  # of one ray: its bytes or the ray, and its rows

    @classmethod
    def _of_single(cls, scene: PreparedScene, ray: Any, rows: Any) -> Self:
        """Return the rows of one ray, given by its bytes or as `Rays`, as a kernel returned them."""
        lists = object.__new__(cls)
        vars(lists).update(_scene=scene, _single=(ray, rows))
        return lists

    if not TYPE_CHECKING:  # a single ray's are made when a field needs them
        offsets = _OfSingle(lambda rows: np.array([0, len(rows)], np.int64))

        @cached_property
        def _rays(self) -> Rays:
            ray = self._single[0]
            return ray if isinstance(ray, Rays) else Rays._of_few(ray, single=True)

    @property
    def rays(self) -> Rays:
        """The traced rays."""
        return self._rays

    @property
    def shape(self) -> tuple[int, ...]:
        """The leading shape of the rays; np.diff(offsets) counts the rows of each."""
        return self._rays.shape

    @classmethod
    def concatenate(cls, parts: Iterable[Self]) -> Self:
        """Join results along the first axis of their rays; a single ray counts as a row of one.

        Parameters
        ----------
        parts : iterable
            Results of this class and of one scene, detached or not.

        Raises
        ------
        TypeError
            If a part has another class.
        ValueError
            If `parts` is empty, if the rays' shapes differ in another axis than the first, or if the parts belong to
            different scenes, in which body numbers have different meanings.
        """
        return _concatenate_lists(cls, parts)

    def _table(self, *names: str) -> str:
        """Return the table that a notebook shows: some fields of the first rows."""
        body = self.body[:MOST_ROWS]  # type: ignore[attr-defined]
        rays = np.searchsorted(self.offsets, np.arange(len(body)), side="right") - 1
        fields = (getattr(self, name)[:MOST_ROWS] for name in names)
        rows = zip(rays, *fields, self._labels.names_of(body), strict=True)  # type: ignore[attr-defined]
        return html_table(("ray", *names, "name"), rows, len(self.body))  # type: ignore[attr-defined]

    def save(self, path: str | os.PathLike[str]) -> None:
        """Write all fields, without the scene, as a .npz file that `load` reads.

        Parameters
        ----------
        path : path
            Must end with .npz. The complete file appears at once, or none.

        Raises
        ------
        ValueError
            For another suffix.
        OSError
            If the file cannot be written.
        """
        extension("lists.write")(check_npz_path("save", type(self).__name__.lower(), path), self)

    @classmethod
    def load(cls, path: str | os.PathLike[str]) -> Self:
        """Return the result in a file, detached from its scene. Loading executes nothing that the file contains.

        Parameters
        ----------
        path : path
            A .npz file that `save` of this class wrote.

        Raises
        ------
        ValueError
            If the file has another format; the message names the file.
        OSError
            If the file cannot be read.
        """
        return extension("lists.read")(check_npz_path("load", cls.__name__.lower(), path), cls)

    def __len__(self) -> int:
        """Number of rays; 1 for a single ray."""
        return len(self.offsets) - 1

    def __bool__(self) -> bool:
        if len(self) != 1:
            raise ValueError(
                f"{type(self).__name__}: the truth value of the rows of {len(self)} rays is ambiguous; "
                "np.diff(offsets) > 0 has the value for each ray"
            )
        return bool(self.offsets[1] > 0)

    def __getitem__(self, index: Any) -> Self:
        """Return the rows of one ray, or of several."""
        which = self._which(index)
        flat = np.ravel(which)
        counts = np.diff(self.offsets)[flat].astype(np.intp, copy=False)
        offsets = np.concatenate([[0], np.cumsum(counts, dtype=np.int64)])
        first = np.repeat(self.offsets[flat], counts)
        rows = first + np.arange(offsets[-1]) - np.repeat(offsets[:-1], counts)
        part = object.__new__(type(self))
        own = {*self._columns, *self._views, "offsets", "_rays"}
        state = {name: value for name, value in vars(self).items() if not hasattr(type(self), name) and name not in own}
        # Cached fields are copied, since a detached result could not compute them again
        cached = {name: vars(self)[name] for name in vars(self) if hasattr(type(self), name) and name not in own}
        state |= {name: value[rows] if isinstance(value, np.ndarray) else value for name, value in cached.items()}
        rays = self._rays if self._rays.shape else self._rays[None]
        part.__dict__.update(
            state,
            offsets=offsets.astype(self.offsets.dtype),
            _rays=rays[np.unravel_index(which, rays.shape)],
            # np.take gives C order, which the compiled kernels expect
            **{name: np.take(getattr(self, name), rows, axis=-1) for name in self._columns},
        )
        freeze_arrays(part)
        return part

    def _which(self, index: Any) -> Any:
        """Return the numbers of the rays that an index selects, scalar for one ray. Raise IndexError for others."""
        if np.shape(index) == self._rays.shape != () and np.asarray(index).dtype == np.bool_:
            index = np.ravel(index)
        is_flat = np.ndim(index) < 2 and not (isinstance(index, tuple) and len(index) != 1)
        is_other_mask = np.asarray(index).dtype == np.bool_ and np.shape(index) != (len(self),)
        which = np.arange(len(self))[index] if is_flat and not is_other_mask else None
        if which is None or which.ndim > 1:
            raise IndexError(
                f"{type(self).__name__}: index must be a number, a slice, a list of numbers or a mask over the "
                f"{format_count(len(self), 'ray', 'rays')}, got {format_value(index)}"
            )
        return which


# Spans and crossings

_SUM_CHUNK = 1 << 13  # rays that a thread takes at a time when it sums up their spans
LARGEST_LENGTHS = 4 << 30
"""The largest array of lengths in bytes."""


def refuse_large_lengths(rays: int, columns: int, by: str) -> None:
    """Raise ValueError if an array of lengths would take more than `LARGEST_LENGTHS` bytes."""
    if rays * columns * 8 > LARGEST_LENGTHS:
        noun = "bodies" if by == BODY else "materials"
        raise ValueError(
            f"lengths: an array of {rays} rays x {columns} {noun} would take {rays * columns * 8 / 2**30:.0f} GiB; "
            "use line_integral(values), or t_enter, t_exit and body"
        )


def _crossing_errors(scene: PreparedScene, rays: Rays, offsets: Any, t: FloatArray, surfaces: Any) -> FloatArray:
    """Return bounds on the errors of t of crossings with surfaces, rows offsets[i]:offsets[i + 1] of ray i."""
    owners = row_owners(offsets)
    errors = bounds_of_t(scene, lines_of(rays), rays._starts_in(scene), owners, t, surfaces)
    errors.flags.writeable = False
    return errors


class Spans(QueryResult, RayLists, SpanDerivatives):
    """Stretches of rays inside solids. Those of ray i are rows offsets[i]:offsets[i + 1], sorted by t_enter.

    Attributes
    ----------
    t_enter, t_exit : float64 (spans,)
        In units of the direction's length.
    body : int32 (spans,)
        Number of the body.
    enter_clipped, exit_clipped : bool (spans,)
        Whether the end is that of the interval (or infinity) rather than a wall.
    t_enter_error, t_exit_error : float64 (spans,)
        Bounds on the distance of each end from the exact one; 0 for a clipped end.
    name, material : object (spans,)
        Name and material of the body.
    materials : tuple
        The different materials of the scene's bodies, the columns of lengths(by="material").
    offsets : int (rays + 1,)
        The first row of each ray.
    rays, shape
        The traced rays, and their leading shape.

    Notes
    -----
    Pickled or `detached` spans keep all these fields and drop the scene.
    """

    t_enter: FloatArray
    t_exit: FloatArray
    body: npt.NDArray[np.int32]
    enter_clipped: npt.NDArray[np.bool_]
    exit_clipped: npt.NDArray[np.bool_]
    _ends: npt.NDArray[np.int32]
    _body_count: int
    _columns = ("t_enter", "t_exit", "body", "enter_clipped", "exit_clipped", "_ends")
    _views = ("_single",)

    if not TYPE_CHECKING:
        t_enter, t_exit = _OfSingle(lambda rows: rows[:, ENTER] + 0.0), _OfSingle(lambda rows: rows[:, EXIT] + 0.0)
        body = _OfSingle(lambda rows: rows[:, BODY_OF_ROW].astype(np.int32))
        enter_clipped = _OfSingle(lambda rows: rows[:, ENTER_CLIPPED] != 0.0)
        exit_clipped = _OfSingle(lambda rows: rows[:, EXIT_CLIPPED] != 0.0)
        _ends = _OfSingle(lambda rows: rows[:, [ENTER_SURFACE, EXIT_SURFACE]].T.astype(np.int32))

        @cached_property
        def _body_count(self) -> int:
            return self._scene.lowered.body_count

    def __init__(self, scene: PreparedScene, rays: Rays, listed: CrossingLists) -> None:
        count = int(listed.offsets[-1])
        t_enter, t_exit, body = np.empty(count), np.empty(count), np.empty(count, np.int32)
        clipped, ends = np.empty((2, count), np.bool_), np.empty((2, count), np.int32)
        listed.put(put_spans, SpanColumns(t_enter, t_exit, body, clipped, ends))
        vars(self).update(
            offsets=listed.offsets, t_enter=t_enter, t_exit=t_exit, body=body,
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
        """Return the ray's number and the true length of every span."""
        ray = row_owners(self.offsets)
        directions = self._rays.directions.reshape(-1, 3)
        # Dividing by the largest component keeps the squares finite
        scale = np.abs(directions).max(axis=1, initial=0.0)
        scale = np.where(scale > 0, scale, 1.0)
        length = scale * np.sqrt(((directions / scale[:, None]) ** 2).sum(axis=1))
        return ray, (self.t_exit - self.t_enter) * length[ray]

    @cached_property
    def materials(self) -> tuple[Any, ...]:
        """The different materials of the scene, as `scene.materials`: the columns of lengths(by="material")."""
        return NameTuple((material for material, _ in self._distinct), "spans.materials")

    @cached_property
    def _distinct(self) -> DistinctMaterials:
        return self._labels.distinct

    def __getstate__(self) -> dict[str, Any]:
        return {"_distinct": self._distinct, "_body_count": self._body_count, **super().__getstate__()}

    def _places(self, by: str) -> tuple[Any, int]:
        """Return the column of every span in an array of sums, and the number of columns."""
        if by == BODY:
            return self.body, self._body_count
        return self._labels.columns_of(self.body, self.materials), len(self.materials)

    @ignore_fp_errors
    def lengths(
        self, by: Literal["body", "material"] = "body", *, overlaps: Literal["both", "error"] | None = None
    ) -> FloatArray:
        """Return the true length of each ray inside each body, (t_exit - t_enter)·|direction|.

        Parameters
        ----------
        by : {"body", "material"}
            "material" sums over the bodies of each material, in the order of `materials`. Materials of one name that
            differ in any property have separate columns.
        overlaps : {"both", "error"}, optional
            Where bodies overlap, the stretch counts for each of them, and twice in the sum of a material that both
            have. "both" accepts this, "error" raises ValueError, None logs the first overlap of a scene.

        Returns
        -------
        float64 (..., bodies) or (..., materials)

        Raises
        ------
        ValueError
            If the array would take more than 4 GiB; `line_integral` needs no such array.
        """
        places, count = self._places(check_by("lengths", by))
        refuse_large_lengths(len(self), count, by)
        if check_overlaps("lengths", overlaps) is not None or by != BODY:
            report_overlaps("lengths", self, overlaps, None if by == BODY else places, None)
        return self._sums(places, np.empty((0, count))).reshape((*self._rays.shape, count))

    @ignore_fp_errors
    def line_integral(
        self,
        values: LineValues,
        otherwise: npt.ArrayLike | None = None,
        *,
        overlaps: Literal["both", "error"] | None = None,
    ) -> Any:
        """Return the sum over spans of value × length. A value of 0 contributes 0 even on an infinite span.

        Parameters
        ----------
        values : array_like, mapping or str
            An array (bodies,) or (bodies, energies); or a mapping from names of materials to numbers or arrays
            (energies,), each for all materials of that name; or the name of a property of materials.
        otherwise : number or array_like (energies,), optional
            The value for materials without one.
        overlaps : {"both", "error"}, optional
            Where bodies overlap, the stretch counts for each of them. "both" accepts this, "error" raises ValueError.
            None logs the first overlap of a scene, unless a value is negative: then overlaps count as intended.

        Returns
        -------
        float64 (...) or (..., energies)

        Raises
        ------
        ValueError
            If a material of a solid has no value and `otherwise` is None, or if shapes do not fit.
        """
        weights = weights_of(values, otherwise, self._body_count, self._distinct)
        total = self._integral(weights, check_overlaps("line_integral", overlaps))
        return total.reshape((*self._rays.shape, *total.shape[1:]))[()]

    def _integral(self, weights: Weights, overlaps: str | None) -> FloatArray:
        """Return the line integrals, (rays,) or (rays, energies)."""
        places, _ = self._places(weights.by)
        table = weights.values.reshape(len(weights.values), math.prod(weights.shape))
        if overlaps == REFUSE_OVERLAPS or not (weights.values < 0).any():
            counts = (table != 0).any(axis=1)
            report_overlaps("line_integral", self, overlaps, None, None if counts.all() else counts[places])
        return self._sums(places, np.ascontiguousarray(table)).reshape((-1, *weights.shape))

    def _sums(self, places: Any, table: FloatArray) -> FloatArray:
        """Return the sums (rays, columns) of weights times lengths, or of lengths where the table has no rows."""
        total = np.empty((len(self), table.shape[1]))
        before = (
            lines_of(self._rays)[1], self.offsets, self.t_enter, self.t_exit, places.astype(np.int32, copy=False), table
        )  # fmt: skip
        run_chunks(KernelRange(integrate_spans, before, (total,)), len(total), _SUM_CHUNK)
        return total

    def __repr__(self) -> str:
        if not self.shape:
            return f"Spans(shape=(), {_format_spans(self)})"
        return f"Spans(shape={self._rays.shape}, {format_count(len(self.body), 'span', 'spans')})"

    def _repr_html_(self) -> str:
        """Return the table that a notebook shows: the first spans."""
        return self._table("t_enter", "t_exit", "body")


class Crossings(QueryResult, RayLists):
    """Every crossing of rays with bodies. Those of ray i are rows offsets[i]:offsets[i + 1], sorted by t.

    Attributes
    ----------
    t : float64 (n,)
        In units of the direction's length.
    body, face, surface : int32 (n,)
        Numbers.
    entering : bool (n,)
        Whether the ray runs against the outward normal.
    point, normal : float64 (n, 3)
        The point, and the unit outward normal there.
    t_error : float64 (n,)
        A bound on the distance of t from the exact crossing.
    before, after : int32 (n,)
        The body that the ray is in before and after the crossing, as in `Hits`; -1 for none.
    name, material : object (n,)
        Name and material of the body.
    offsets : int (rays + 1,)
        The first row of each ray.
    rays, shape
        The traced rays, and their leading shape.

    Notes
    -----
    Pickled or `detached` crossings keep all these fields and drop the scene.
    """

    t: FloatArray
    entering: npt.NDArray[np.bool_]
    body: npt.NDArray[np.int32]
    face: npt.NDArray[np.int32]
    surface: npt.NDArray[np.int32]
    _columns = ("t", "entering", "body", "face", "surface")
    _views = ("_single",)

    if not TYPE_CHECKING:
        t, entering = _OfSingle(lambda rows: rows[:, T]), _OfSingle(lambda rows: rows[:, ENTERS] != 0.0)
        body, face, surface = (
            _OfSingle(lambda rows, k=k: rows[:, k].astype(np.int32)) for k in (BODY_OF_ROW, FACE, SURFACE)
        )

    def __init__(self, scene: PreparedScene, rays: Rays, listed: CrossingLists) -> None:
        count = int(listed.offsets[-1])
        t, entering = np.empty(count), np.empty(count, np.bool_)
        body, face, surface = (np.empty(count, np.int32) for _ in range(3))
        listed.put(put_crossings, CrossingColumns(t, body, face, surface, entering))
        vars(self).update(
            offsets=listed.offsets, t=t, entering=entering, _scene=scene, _rays=rays,
            body=body, face=face, surface=surface,
        )  # fmt: skip

    @property
    def _rows_rays(self) -> tuple[FloatArray, FloatArray]:
        """The origin and direction of every row, (n, 3) each."""
        rays = row_owners(self.offsets)
        origins, directions = lines_of(self._rays)
        return origins[rays], directions[rays]

    @cached_property
    def point(self) -> FloatArray:
        points, far, lines = np.empty((len(self.t), 3)), np.zeros(1, np.int8), self._rows_rays
        run_rows(hit_points, (*lines, self.t), len(points), points, far)
        if far[0]:  # the rule of `Hits.point`
            scene, turns = self._scene, np.zeros(len(points), np.int8)
            faces = np.stack([self.surface, self.face, np.ones_like(self.face)])
            arguments = (scene.geometry, scene.rest, *lines, self.t, turns, faces)
            run_rows(refine_points, arguments, len(points), points, np.empty(len(points)))
        points.flags.writeable = False
        return points

    @cached_property
    @ignore_fp_errors
    def normal(self) -> FloatArray:
        points, normals = self.point, np.empty((len(self.t), 3))
        faces = np.stack([self.surface, self.face, np.ones_like(self.face)])
        run_rows(normals_of, (self._scene.geometry, faces, points), len(points), normals)
        along = (normals * self._rows_rays[1]).sum(axis=1)
        # `faces` assumes side 1; `entering` shows where the outward normal is the opposite one
        normals[(along < 0) != self.entering] *= -1
        result = zero_negligible(normals)
        result.flags.writeable = False
        return result

    @cached_property
    def t_error(self) -> FloatArray:
        return _crossing_errors(self._scene, self._rays, self.offsets, self.t, self.surface)

    @cached_property
    def _sides(self) -> Any:
        """(n, 3): the bodies before and after each crossing, and the first opaque body that the ray crosses there."""
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
        return self._sides[:, BEFORE]

    @cached_property
    def after(self) -> npt.NDArray[np.int32]:
        """int32: the body that the ray is in just after each crossing, as `Hits.after`; -1 for none."""
        return self._sides[:, AFTER]

    def __repr__(self) -> str:
        if not self.shape:
            return f"Crossings(shape=(), {_format_crossings(self)})"
        return f"Crossings(shape={self._rays.shape}, {format_count(len(self.t), 'crossing', 'crossings')})"

    def _repr_html_(self) -> str:
        """Return the table that a notebook shows: the first crossings."""
        return self._table("t", "entering", "body", "face")


def _format_spans(spans: Spans) -> str:
    """Return the first spans of one ray as text."""
    rows = zip(spans.body, spans.name, spans.t_enter, spans.t_exit, strict=True)
    return format_rows(
        len(spans.body),
        "span",
        (f"body {format_body(b, n)} [{format_field(a)}, {format_field(e)}]" for b, n, a, e in rows),
    )


def _format_crossings(crossings: Crossings) -> str:
    """Return the first crossings of one ray as text."""
    rows = zip(crossings.body, crossings.name, crossings.t, strict=True)
    return format_rows(
        len(crossings.body), "crossing", (f"body {format_body(b, n)} t={format_field(t)}" for b, n, t in rows)
    )


# Rows of several queries joined into one


def _concatenate_lists(kind: Any, parts: Any) -> Any:
    """Join spans or crossings (see `RayLists.concatenate`). They keep their scene if all parts have the same one."""
    name = kind.__name__
    results = check_parts(kind, parts)
    rays = join_rays(name, [part._rays for part in results])
    is_one = results[0]._scene is not NO_SCENE and all(part._scene is results[0]._scene for part in results)
    rows = results if is_one else [part.detached() for part in results]
    counts = np.concatenate([np.diff(part.offsets) for part in rows])
    state = {"_rays": rays, "offsets": np.concatenate([[0], np.cumsum(counts)]).astype(rows[0].offsets.dtype)}
    columns = kind._columns if is_one else [n for n, v in vars(rows[0]).items() if isinstance(v, np.ndarray)]
    for column in columns:
        if column not in state:
            axis = -1 if column in kind._columns else 0
            state[column] = np.concatenate([getattr(part, column) for part in rows], axis=axis)
    result = object.__new__(kind)
    result.__setstate__({**vars(rows[0]), **state} if not is_one else state | _counts(rows[0]))
    if is_one:
        vars(result)["_scene"] = results[0]._scene
    else:
        vars(result).update(common_scene_state(rows, name))
    return result


def _counts(part: Any) -> dict[str, Any]:
    """Return the number of bodies, which spans have and crossings have not."""
    return {"_body_count": part._body_count} if hasattr(part, "_body_count") else {}


# Tracing: chunks of rays on several threads, whose rows are joined in the rays' order

_LIST_PACKETS = 64  # packets that a thread takes at a time, at most


def trace_lists(
    scene: PreparedScene, rays: RayArrays, width: int, packets: int, spans: bool, gpu: Device | None = None
) -> CrossingLists:
    """Return all spans, or all crossings, of rays in packets.

    width: of the picture that the rays make, whose squares are the packets, or 0 (`packet_row` in
    kernels/packet/lanes.py).
    """
    count = len(rays.origins)
    counts, doubts, offsets = np.zeros(count, np.int32), np.zeros(count, np.int8), np.zeros(count + 1, np.int64)
    there = None if gpu is None else gpu.list_rows(scene, rays, spans, counts, doubts)
    if there is None:
        work = KernelRange(trace_rows, (rays, width, spans), (counts, doubts))
        chunk = chunk_of_rays(scene.geometry, packets, _LIST_PACKETS, count)
        traced = run_on(scene.geometry, work, packets, chunk, count)
        pieces = [_Piece(np.asarray(rows), counts, offsets[:-1], width, begin, end) for begin, end, rows in traced]
    else:
        pieces = [
            _Piece(rows, counts[begin:end], offsets[begin:end], 0, 0, -(-(end - begin) // 64))
            for begin, end, rows in there
        ]
    doubtful = np.flatnonzero(doubts)
    if not len(doubtful):
        put_offsets(counts, offsets[1:])
        return CrossingLists(offsets, pieces)
    # Exact methods trace the doubtful rays, whose rows form one more piece
    resolved = resolve_rows(scene, rays, doubtful, spans)
    own = np.array([len(rows) for rows in resolved], np.int32)
    every = counts.copy()
    every[doubtful] = own
    put_offsets(every, offsets[1:])
    last = _Piece(np.concatenate(resolved), own, offsets[doubtful], 0, 0, -(-len(doubtful) // 64))
    return CrossingLists(offsets, [*pieces, last])
