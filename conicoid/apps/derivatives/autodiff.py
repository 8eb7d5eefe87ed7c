"""`hits.jvp`, `hits.vjp` and `spans.vjp`: what they take and give."""

from __future__ import annotations

from dataclasses import dataclass
from typing import TYPE_CHECKING, Any

import numpy as np

from ..._util.arrays import FloatArray
from ..._util.validation import describe_kind, real_array
from ...kernels.entry.crossings import row_owners
from ...queries.rays import lines_of
from ...queries.result import NO_SCENE
from ...queries.tangents import Cotangents, SpanTangents, Tangents
from ...queries.weights import weights_of
from .crossing_derivatives import CrossingRows, make_crossing_rows, pull_back, push_forward, split_forms_maps
from .hit_surfaces import (
    HitSurfaces,
    SurfaceJacobians,
    apply_jacobians,
    apply_jacobians_transposed,
    find_hit_surfaces,
    surface_jacobians,
)
from .parameters import Parameters
from .ties import faces_of_ends, find_hit_ties, find_ties_within

if TYPE_CHECKING:
    from ...prepare.prepared_scene import PreparedScene
    from ...queries.hits import Hits
    from ...queries.spans import Spans


def check_parameters(owner: str, parameters: Any, prepared: PreparedScene) -> Parameters:
    """Parameters of the scene that an answer is of, or of one whose shapes have their numbers in the same places."""
    if not isinstance(parameters, Parameters):
        raise TypeError(f"{owner}: parameters must be those of co.parameters(scene), got {describe_kind(parameters)}")
    if not parameters._fits(prepared.entries):
        raise ValueError(f"{owner}: parameters must be of a scene with the same shapes, but for their numbers")
    return parameters


def scene_of(owner: str, answer: Any) -> PreparedScene:
    """The scene of an answer that still has one."""
    if answer._scene is NO_SCENE:
        raise ValueError(f"{owner}: these answers were detached from their scene, or pickled; derivatives need it")
    prepared: PreparedScene = answer._scene
    return prepared


def array_of(owner: str, name: str, given: Any, shape: tuple[int, ...], width: int) -> FloatArray | None:
    """An array shaped like the answer, flattened to (n,) or (n, width); None if it was not given."""
    if given is None:
        return None
    expected = shape if width == 1 else (*shape, width)
    array = real_array(owner, name, given)
    try:
        whole = np.broadcast_to(array, expected)
    except ValueError:
        raise ValueError(f"{owner}: {name} must broadcast to {expected}, got {array.shape}") from None
    return whole.reshape((-1,) if width == 1 else (-1, width))


def spread_tangent(owner: str, name: str, given: Any, parameters: Parameters) -> FloatArray:
    """A change of the parameters as one of all numbers of the scene."""
    vector = real_array(owner, name, given)
    if vector.shape != (len(parameters),):
        raise ValueError(f"{owner}: {name} must have shape ({len(parameters)},), got {vector.shape}")
    return parameters._spread(vector)


def wall_tangent(
    owner: str, prepared: PreparedScene, answer: Any, walls: HitSurfaces, parameters: Any, d_parameters: Any
) -> FloatArray | None:
    """How walls change (w, 22), their forms and maps; None where no parameter changes."""
    if d_parameters is None:
        if parameters is not None:
            check_parameters(owner, parameters, prepared)
        return None
    if parameters is None:
        raise ValueError(f"{owner}: d_parameters need parameters, those of co.parameters(scene)")
    checked = check_parameters(owner, parameters, prepared)
    tangent = spread_tangent(owner, "d_parameters", d_parameters, checked)
    return np.concatenate(apply_jacobians(_cached_jacobians(prepared, answer, walls, checked), tangent), axis=1)


def parameter_cotangent(
    owner: str, prepared: PreparedScene, answer: Any, walls: HitSurfaces, parameters: Any, asked: FloatArray
) -> FloatArray | None:
    """What is asked of walls (w, 22) as what is asked of parameters (parameters,)."""
    if parameters is None:
        return None
    checked = check_parameters(owner, parameters, prepared)
    every = apply_jacobians_transposed(
        _cached_jacobians(prepared, answer, walls, checked), *split_forms_maps(asked), len(checked._full)
    )
    result: FloatArray = every[checked._chosen]
    return result


def _cached_jacobians(
    prepared: PreparedScene, answer: Any, walls: HitSurfaces, parameters: Parameters
) -> SurfaceJacobians:
    """What moves the walls of an answer; kept with it."""
    known: SurfaceJacobians | None = vars(answer).get("_moving")
    if known is None:
        known = vars(answer)["_moving"] = surface_jacobians(prepared, walls, parameters)
    return known


# The derivatives of first hits.


def hits_jvp(hits: Hits, parameters: Any, d_parameters: Any, d_origins: Any, d_directions: Any) -> Tangents:
    """`hits.jvp`"""
    prepared, shape = scene_of("jvp", hits), hits.rays.shape
    do = array_of("jvp", "d_origins", d_origins, shape, 3)
    dd = array_of("jvp", "d_directions", d_directions, shape, 3)
    walls, crossings = _hit_walls(hits)
    change = wall_tangent("jvp", prepared, hits, walls, parameters, d_parameters)
    t, *fields = push_forward(walls.rows, crossings, (change, do, dd), True)
    return Tangents(t.reshape(shape)[()], *(part.reshape((*shape, part.shape[1])) for part in fields))


def hits_vjp(hits: Hits, parameters: Any, t: Any, point: Any, normal: Any, uv: Any) -> Cotangents:
    """`hits.vjp`"""
    prepared, shape = scene_of("vjp", hits), hits.rays.shape
    asked = [
        array_of("vjp", name, value, shape, width)
        for name, value, width in (("t", t, 1), ("point", point, 3), ("normal", normal, 3), ("uv", uv, 2))
    ]
    walls, crossings = _hit_walls(hits)
    back, missed = pull_back(walls.rows, crossings, asked, parameters is not None)
    if missed >= 0:
        where = [int(i) for i in np.unravel_index(missed, shape)]
        raise ValueError(f"vjp: what is asked must be 0 for rays that hit nothing, as the ray {where} does")
    found = parameter_cotangent("vjp", prepared, hits, walls, parameters, back.walls)
    return Cotangents(found, back.origins.reshape((*shape, 3)), back.directions.reshape((*shape, 3)))


def _hit_walls(hits: Hits) -> tuple[HitSurfaces, CrossingRows]:
    """(the walls of hits, the hits as crossings on them); kept with the hits."""
    known: tuple[HitSurfaces, CrossingRows] | None = vars(hits).get("_met")
    if known is None:
        surface, face, side = hits._faces
        walls = find_hit_surfaces(hits._scene, hits._found.body, face, surface)
        columns = walls.place, side, find_hit_ties(hits), hits._points, lines_of(hits.rays)[1], hits._found.t
        crossings = make_crossing_rows(*columns)
        known = vars(hits)["_met"] = walls, crossings
    return known


# The derivatives of spans: of their ends, of lengths and of line integrals.
#
# Spans of one body do not depend on other bodies, so their ends have derivatives also where bodies abut. An end that is
# the interval's stays where it is. A span that is about to vanish has ends that move ever faster, and a length that
# does
# not jump: integrals over rays lose nothing at outlines.


@dataclass
class _SpanEnds:
    """The ends of spans that are walls: all that are entered by, then all that are left by."""

    which: Any  # rows: span, or count of spans + span
    ray: Any
    walls: HitSurfaces
    crossings: CrossingRows


def _span_ends(spans: Spans) -> _SpanEnds:
    """The walls at the ends of all spans, but for what is clipped; kept with the spans."""
    known: _SpanEnds | None = vars(spans).get("_met")
    if known is not None:
        return known
    prepared = spans._scene
    clipped = np.concatenate([spans.enter_clipped, spans.exit_clipped])
    which = np.flatnonzero(~clipped)
    t = np.concatenate([spans.t_enter, spans.t_exit])[which]
    body, surface = np.tile(spans.body, 2)[which], spans._ends.reshape(-1)[which].astype(np.int32)
    ray = np.tile(row_owners(spans.offsets), 2)[which]
    o, d = (part[ray] for part in lines_of(spans.rays))
    x, entry = o + t[:, None] * d, body.astype(np.int32)
    face = faces_of_ends(prepared, entry, surface, o, x)
    walls, lost = find_hit_surfaces(prepared, body, face, surface), find_ties_within(prepared, entry, face, o, x)
    crossings = make_crossing_rows(walls.place, np.ones(len(t), np.int32), lost, x, d, t)
    known = vars(spans)["_met"] = _SpanEnds(which, ray, walls, crossings)
    return known


def spans_jvp(spans: Spans, parameters: Any, d_parameters: Any, d_origins: Any, d_directions: Any) -> SpanTangents:
    """`spans.jvp`"""
    prepared, shape = scene_of("jvp", spans), spans.shape
    do = array_of("jvp", "d_origins", d_origins, shape, 3)
    dd = array_of("jvp", "d_directions", d_directions, shape, 3)
    ends, count = _span_ends(spans), len(spans.body)
    change = wall_tangent("jvp", prepared, spans, ends.walls, parameters, d_parameters)
    found, d = np.zeros(2 * count), lines_of(spans.rays)[1]
    changes = change, *(None if part is None else part[ends.ray] for part in (do, dd))
    found[ends.which] = push_forward(ends.walls.rows, ends.crossings, changes, False).t
    stretch = np.zeros(len(d)) if dd is None else (d * dd).sum(axis=1) / (d * d).sum(axis=1)
    return SpanTangents(found[:count], found[count:], spans, stretch)


def spans_vjp(
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
        _integral_cotangent(spans, line_integral, values, otherwise, asked_t, of_rays)
    ends = _span_ends(spans)
    asked = asked_t.reshape(-1)[ends.which], None, None, None
    given, _ = pull_back(ends.walls.rows, ends.crossings, asked, parameters is not None)
    for k, column in enumerate((*given.origins.T, *given.directions.T)):
        of_rays[k] += np.bincount(ends.ray, column, of_rays.shape[1])
    found = parameter_cotangent("vjp", prepared, spans, ends.walls, parameters, given.walls)
    origins, of_d2 = (np.ascontiguousarray(part.T).reshape((*shape, 3)) for part in (of_rays[:3], of_rays[3:]))
    return Cotangents(found, origins, of_d2)


def _integral_cotangent(
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
