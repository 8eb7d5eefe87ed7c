"""The derivatives of spans: of their ends, of lengths and of line integrals.

Spans of one body do not depend on other bodies, so their ends have derivatives also where bodies abut. An end that is
the interval's stays where it is. A span that is about to vanish has ends that move ever faster, and a length that does
not jump: integrals over rays lose nothing at outlines.
"""

from __future__ import annotations

from dataclasses import dataclass, field
from typing import TYPE_CHECKING, Any

import numpy as np

from ..engine.answers.rays import lines_of
from ..engine.answers.weights import weights_of
from ..engine.arrays.owners import owners
from ..shapes.vector import FloatArray
from .asked import Cotangents, array_of, change_of, handed_back, met, scene_of
from .backward import asked_by
from .crossing import Crossings
from .forward import crossings_at, moved_by
from .ties import faces_of_ends, tied_within

if TYPE_CHECKING:
    from ..engine.answers.spans import Spans
    from .met import Met


@dataclass(frozen=True)
class SpanTangents:
    """How the ends of spans change, t_enter and t_exit (spans,); 0 for what is clipped, NaN without a derivative."""

    t_enter: FloatArray
    t_exit: FloatArray
    _spans: Spans = field(repr=False)
    _stretch: FloatArray = field(repr=False)  # (rays,) how much longer directions become

    def lengths(self, by: Any = "body") -> FloatArray:
        """How `spans.lengths(by)` changes: (..., bodies), or (..., materials) `by` "material"."""
        spans = self._spans
        places, count = spans._places(by)
        ray, change = self._chords()
        rays = len(spans.offsets) - 1
        found: FloatArray = np.bincount(ray * count + places, change, rays * count).astype(np.float64)
        return found.reshape((*spans.shape, count))

    def line_integral(self, values: Any, otherwise: Any = None) -> Any:
        """How `spans.line_integral(values, otherwise)` changes, where the values stay: (...), or (..., energies).

        By the values it changes as it does by its definition: by the lengths.
        """
        spans = self._spans
        weights = weights_of(values, otherwise, spans._body_count, spans._distinct)
        places, _ = spans._places(weights.by)
        ray, change = self._chords()
        columns = weights.values.reshape(len(weights.values), -1).T
        rays = len(spans.offsets) - 1
        parts = [np.where(column[places] == 0, 0.0, column[places]) for column in columns]
        found = [np.bincount(ray, np.where(part == 0, 0.0, part * change), rays) for part in parts]
        return np.array(found).T.reshape((*spans.shape, *weights.shape))[()]

    def _chords(self) -> tuple[Any, FloatArray]:
        """(ray, change of the true length) of every span."""
        ray, chord = self._spans._chords()
        size = np.sqrt((lines_of(self._spans.rays)[1] ** 2).sum(axis=1))
        with np.errstate(invalid="ignore"):
            longer = np.where(self._stretch[ray] == 0, 0.0, chord * self._stretch[ray])
        return ray, (self.t_exit - self.t_enter) * size[ray] + longer


@dataclass
class _Ends:
    """The ends of spans that are walls: all that are entered by, then all that are left by."""

    which: Any  # rows: span, or count of spans + span
    ray: Any
    walls: Met
    crossings: Crossings


def _ends(spans: Spans) -> _Ends:
    """The walls at the ends of all spans, but for what is clipped; kept with the spans."""
    known: _Ends | None = vars(spans).get("_met")
    if known is not None:
        return known
    prepared = spans._scene
    clipped = np.concatenate([spans.enter_clipped, spans.exit_clipped])
    which = np.flatnonzero(~clipped)
    t = np.concatenate([spans.t_enter, spans.t_exit])[which]
    body, surface = np.tile(spans.body, 2)[which], spans._ends.reshape(-1)[which].astype(np.int32)
    ray = np.tile(owners(spans.offsets), 2)[which]
    o, d = (part[ray] for part in lines_of(spans.rays))
    x, entry = o + t[:, None] * d, body.astype(np.int32)
    face = faces_of_ends(prepared, entry, surface, o, x)
    walls, lost = met(prepared, body, face, surface), tied_within(prepared, entry, face, o, x)
    crossings = crossings_at(walls.place, np.ones(len(t), np.int32), lost, x, d, t)
    known = vars(spans)["_met"] = _Ends(which, ray, walls, crossings)
    return known


def jvp(spans: Spans, parameters: Any, d_parameters: Any, d_origins: Any, d_directions: Any) -> SpanTangents:
    """`spans.jvp`"""
    prepared, shape = scene_of("jvp", spans), spans.shape
    do = array_of("jvp", "d_origins", d_origins, shape, 3)
    dd = array_of("jvp", "d_directions", d_directions, shape, 3)
    ends, count = _ends(spans), len(spans.body)
    change = change_of("jvp", prepared, spans, ends.walls, parameters, d_parameters)
    found, d = np.zeros(2 * count), lines_of(spans.rays)[1]
    changes = change, *(None if part is None else part[ends.ray] for part in (do, dd))
    found[ends.which] = moved_by(ends.walls.rows, ends.crossings, changes, False).t
    stretch = np.zeros(len(d)) if dd is None else (d * dd).sum(axis=1) / (d * d).sum(axis=1)
    return SpanTangents(found[:count], found[count:], spans, stretch)


def vjp(
    spans: Spans, parameters: Any, t_enter: Any, t_exit: Any, line_integral: Any, values: Any, otherwise: Any
) -> Cotangents:
    """`spans.vjp`"""
    prepared, shape, count = scene_of("vjp", spans), spans.shape, len(spans.body)
    of_rays, asked_t = np.zeros((6, len(spans.offsets) - 1)), np.zeros((2, count))
    for row, name, given in ((0, "t_enter", t_enter), (1, "t_exit", t_exit)):
        part = array_of("vjp", name, given, (count,), 1)
        if part is not None:
            asked_t[row] += part
    if line_integral is not None:
        _ask_of_integral(spans, line_integral, values, otherwise, asked_t, of_rays)
    ends = _ends(spans)
    asked = asked_t.reshape(-1)[ends.which], None, None, None
    given, _ = asked_by(ends.walls.rows, ends.crossings, asked, parameters is not None)
    for k, column in enumerate((*given.origins.T, *given.directions.T)):
        of_rays[k] += np.bincount(ends.ray, column, of_rays.shape[1])
    found = handed_back("vjp", prepared, spans, ends.walls, parameters, given.walls)
    origins, of_d2 = (np.ascontiguousarray(part.T).reshape((*shape, 3)) for part in (of_rays[:3], of_rays[3:]))
    return Cotangents(found, origins, of_d2)


def _ask_of_integral(
    spans: Spans, asked: Any, values: Any, otherwise: Any, of_t: FloatArray, of_rays: FloatArray
) -> None:
    """Add what is asked of line integrals to what is asked of the ends (2, spans), and of directions in (6, rays)."""
    if values is None:
        raise ValueError("vjp: line_integral needs values, those of spans.line_integral(values)")
    weights = weights_of(values, otherwise, spans._body_count, spans._distinct)
    table = weights.values.reshape(len(weights.values), -1)
    given = array_of("vjp", "line_integral", asked, (*spans.shape, *weights.shape), 1)
    assert given is not None
    places, _ = spans._places(weights.by)
    ray, chord = spans._chords()
    weight = (given.reshape(-1, table.shape[1])[ray] * table[places]).sum(axis=1)
    d = lines_of(spans.rays)[1]
    size = np.sqrt((d * d).sum(axis=1))
    of_t[0] -= weight * size[ray]
    of_t[1] += weight * size[ray]
    stretch = np.where(weight == 0, 0.0, weight * np.where(weight == 0, 0.0, chord)) / size[ray] ** 2
    for k in range(3):
        of_rays[3 + k] += np.bincount(ray, stretch, of_rays.shape[1]) * d[:, k]
