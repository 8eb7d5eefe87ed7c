"""Lists of different length for each ray, one after the other: spans and crossings (CSR layout)."""

from __future__ import annotations

import math
from functools import cached_property
from typing import TYPE_CHECKING, Any, Literal

import numpy as np
import numpy.typing as npt

from ...shapes.arrays import without_traces
from ...shapes.calls import explained_methods
from ...shapes.calm import calm
from ...shapes.labels import counted
from ...shapes.named_parts import Named
from ...shapes.other_names import hinted
from ...shapes.vector import FloatArray
from ..arrays.crossing_arrays import CrossingColumns, SpanColumns, put_crossings, put_spans
from ..arrays.listed import Listed
from ..arrays.owners import owners
from ..body.sides import AFTER, BEFORE
from ..certified.exact_errors import bounds_of_t
from ..certified.sides import Places, sides_of
from ..ray import RayArrays
from ..threads import run_chunks
from .answer import Answer
from .by_ray import ByRay
from .fields import normals_of, points_along
from .no_names import numbered, numbers_of
from .overlaps import ERROR, checked_overlaps, tell_overlaps
from .rays import Rays, lines_of
from .slopes import SpanSlopes
from .told import crossings_of_one, spans_of_one
from .weights import BODY, Distinct, Weights, checked_by, weights_of

if TYPE_CHECKING:
    from ..prepared import Prepared

LARGEST = 4 << 30
_CHUNK = 16384


def refuse_large(rays: int, columns: int, by: str) -> None:
    """ValueError for an array of lengths that would be absurd."""
    if rays * columns * 8 > LARGEST:
        what = "bodies" if by == BODY else "materials"
        raise ValueError(
            f"lengths: an array of {rays} rays x {columns} {what} would take {rays * columns * 8 / 2**30:.0f} GiB; "
            "use line_integral(values), or t_enter, t_exit and body"
        )


def _errors(scene: Prepared, rays: Rays, offsets: Any, t: FloatArray, surfaces: Any) -> FloatArray:
    """The bounds on the crossings of rays with surfaces, rows offsets[i]:offsets[i + 1] of ray i."""
    which = owners(offsets)
    errors = bounds_of_t(scene, lines_of(rays), rays._starts_in(scene), which, t, surfaces)
    errors.flags.writeable = False
    return errors


@hinted
@explained_methods
class Spans(Answer, ByRay, SpanSlopes):
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

    def __init__(self, scene: Prepared, rays: Rays, listed: Listed) -> None:
        count = int(listed.offsets[-1])
        t_enter, t_exit, body = np.empty(count), np.empty(count), np.empty(count, np.int32)
        clipped, ends = np.empty((2, count), np.bool_), np.empty((2, count), np.int32)
        listed.put(put_spans, SpanColumns(t_enter, t_exit, body, clipped, ends))
        vars(self).update(
            offsets=listed.offsets, t_enter=t_enter, t_exit=t_exit, body=numbers_of("body", body),
            enter_clipped=clipped[0], exit_clipped=clipped[1], _ends=ends,
            _rays=rays, _scene=scene, _body_count=scene.lowered.body_count,
        )  # fmt: skip

    @cached_property
    def t_enter_error(self) -> FloatArray:
        return _errors(self._scene, self._rays, self.offsets, self.t_enter, self._ends[0])

    @cached_property
    def t_exit_error(self) -> FloatArray:
        return _errors(self._scene, self._rays, self.offsets, self.t_exit, self._ends[1])

    def _chords(self) -> tuple[Any, FloatArray]:
        """(flat index of the ray, true length) of every span."""
        ray = owners(self.offsets)
        directions = self._rays.directions.reshape(-1, 3)
        scale = np.abs(directions).max(axis=1, initial=0.0)
        scale = np.where(scale > 0, scale, 1.0)
        length = scale * np.sqrt(((directions / scale[:, None]) ** 2).sum(axis=1))
        return ray, (self.t_exit - self.t_enter) * length[ray]

    @cached_property
    def materials(self) -> tuple[Any, ...]:
        """The different materials of the scene, as `scene.materials`: the columns of lengths(by="material")."""
        return Named((material for material, _ in self._distinct), "spans.materials")

    @cached_property
    def _distinct(self) -> Distinct:
        return self._labels.distinct

    def __getstate__(self) -> dict[str, Any]:
        return {"_distinct": self._distinct, **super().__getstate__()}

    def _places(self, by: str) -> tuple[Any, int]:
        """(column of every span, how many columns there are)."""
        if by == BODY:
            return self.body, self._body_count
        return self._labels.columns_of(self.body, self.materials), len(self.materials)

    @calm
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
        places, count = self._places(checked_by("lengths", by))
        rays = len(self.offsets) - 1
        refuse_large(rays, count, by)
        if checked_overlaps("lengths", overlaps) is not None or by != BODY:
            tell_overlaps("lengths", self, overlaps, None if by == BODY else places, None)
        ray, chord = self._chords()
        result = np.zeros(rays * count)
        if len(chord):
            result += np.bincount(ray * count + places, chord, rays * count)
        return result.reshape((*self._rays.shape, count))

    @calm
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
        total = self._integral(weights, checked_overlaps("line_integral", overlaps))
        return total.reshape((*self._rays.shape, *total.shape[1:]))[()]

    def _integral(self, weights: Weights, overlaps: str | None) -> FloatArray:
        """(rays,) or (rays, energies)."""
        places, _ = self._places(weights.by)
        table = weights.values.reshape(len(weights.values), math.prod(weights.shape))
        if overlaps == ERROR or not (weights.values < 0).any():
            counts = (table != 0).any(axis=1)
            tell_overlaps("line_integral", self, overlaps, None, counts[places])
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
            return f"Spans(shape=(), {spans_of_one(self)})"
        return f"Spans(shape={self._rays.shape}, {counted(len(self.body), 'span', 'spans')})"


@hinted
@explained_methods
class Crossings(Answer, ByRay):
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

    def __init__(self, scene: Prepared, rays: Rays, listed: Listed) -> None:
        count = int(listed.offsets[-1])
        t, entering = np.empty(count), np.empty(count, np.bool_)
        body, face, surface = (np.empty(count, np.int32) for _ in range(3))
        listed.put(put_crossings, CrossingColumns(t, body, face, surface, entering))
        vars(self).update(
            offsets=listed.offsets, t=t, entering=entering, _scene=scene, _rays=rays,
            **numbered({"body": body, "face": face, "surface": surface}),
        )  # fmt: skip

    @property
    def _rows_rays(self) -> tuple[FloatArray, FloatArray]:
        """(origins, directions) of every row."""
        rays = owners(self.offsets)
        origins, directions = lines_of(self._rays)
        return origins[rays], directions[rays]

    @cached_property
    def point(self) -> FloatArray:
        points = np.empty((len(self.t), 3))
        o, d = self._rows_rays
        run_chunks(lambda a, b: points_along(o, d, self.t, a, b, points), len(points), _CHUNK)
        points.flags.writeable = False
        return points

    @cached_property
    @calm
    def normal(self) -> FloatArray:
        points, normals = self.point, np.empty((len(self.t), 3))
        faces = np.stack([self.surface, self.face, np.ones_like(self.face)])
        geometry = self._scene.geometry
        run_chunks(lambda a, b: normals_of(geometry, faces, points, a, b, normals), len(points), _CHUNK)
        along = (normals * self._rows_rays[1]).sum(axis=1)
        normals[(along < 0) != self.entering] *= -1
        result = without_traces(normals)
        result.flags.writeable = False
        return result

    @cached_property
    def t_error(self) -> FloatArray:
        return _errors(self._scene, self._rays, self.offsets, self.t, self.surface)

    @cached_property
    def _sides(self) -> Any:
        """(n, 3): bodies before and after each crossing, and the first opaque one that is crossed there."""
        scene, starts = self._scene, self._rays._starts_in(self._scene)
        starts = starts if len(starts) == 1 else starts[owners(self.offsets)]
        limits = np.array([-np.inf]), np.array([np.inf])
        turns = np.where(self.entering, 2, 1).astype(np.int8)
        places = Places(self.t, self.surface, self.body.astype(np.int32), turns)
        sides = np.ascontiguousarray(sides_of(scene, RayArrays(*self._rows_rays, *limits, starts), places).T)
        sides.flags.writeable = False
        return sides

    @cached_property
    def before(self) -> npt.NDArray[np.int32]:
        """int32: the body that the ray is in just before each crossing, as `Hits.before`; -1 for none."""
        result: npt.NDArray[np.int32] = numbers_of("before", self._sides[:, BEFORE])
        return result

    @cached_property
    def after(self) -> npt.NDArray[np.int32]:
        """int32: the body that the ray is in just after each crossing, as `Hits.after`; -1 for none."""
        result: npt.NDArray[np.int32] = numbers_of("after", self._sides[:, AFTER])
        return result

    def __repr__(self) -> str:
        if not self.shape:
            return f"Crossings(shape=(), {crossings_of_one(self)})"
        return f"Crossings(shape={self._rays.shape}, {counted(len(self.t), 'crossing', 'crossings')})"
