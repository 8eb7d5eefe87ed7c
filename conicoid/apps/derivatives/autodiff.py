"""Jacobian-vector and vector-Jacobian products of hits and spans, and the derivative of a volume.

Each product checks its arguments, builds the walls of the crossings once per result, runs the kernels of
`crossing_derivatives`, and chains with the Jacobians of the walls by the parameters.
"""

from __future__ import annotations

from collections.abc import Iterator
from typing import Any, Protocol

import numpy as np
import numpy.typing as npt

from ..._util.arrays import BoxEnds, FloatArray, ignore_fp_errors
from ..._util.records import dataclass
from ..._util.validation import check_integer, describe_kind, format_value, real_array
from ...geometry.bulk import Bulk
from ...kernels.crossings import row_owners
from ...prepare.prepared_scene import PreparedScene
from ...queries import spans
from ...queries.derivatives import Cotangents, SpanTangents, Tangents
from ...queries.hits import Hits
from ...queries.rays import lines_of
from ...queries.result import NO_SCENE
from ...queries.scene_protocol import SceneLike
from ...queries.spans import Spans
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


def check_parameters(owner: str, parameters: Any, prepared: PreparedScene) -> Parameters:
    """Return `parameters` if they fit the scene of a result: the same shapes, whose values may differ."""
    if not isinstance(parameters, Parameters):
        raise TypeError(f"{owner}: parameters must be those of co.parameters(scene), got {describe_kind(parameters)}")
    if not parameters._fits(prepared.entries):
        raise ValueError(f"{owner}: parameters must belong to a scene of the same shapes; only their values may differ")
    return parameters


def scene_of(owner: str, answer: Any) -> PreparedScene:
    """Return the prepared scene of a result. Raise ValueError if the result is detached from it."""
    if answer._scene is NO_SCENE:
        raise ValueError(f"{owner}: derivatives need the scene, but this result was detached from its scene or pickled")
    return answer._scene


def array_of(owner: str, name: str, value: Any, shape: tuple[int, ...], width: int) -> FloatArray | None:
    """Broadcast an argument to the shape of the result and flatten it to (n,) or (n, width); None stays None."""
    if value is None:
        return None
    expected = shape if width == 1 else (*shape, width)
    array = real_array(owner, name, value)
    try:
        broadcast = np.broadcast_to(array, expected)
    except ValueError:
        raise ValueError(f"{owner}: {name} must broadcast to {expected}, got {array.shape}") from None
    return broadcast.reshape((-1,) if width == 1 else (-1, width))


def spread_tangent(owner: str, name: str, value: Any, parameters: Parameters) -> FloatArray:
    """Scatter a tangent of the selected parameters into one of all numbers of the scene."""
    vector = real_array(owner, name, value)
    if vector.shape != (len(parameters),):
        raise ValueError(f"{owner}: {name} must have shape ({len(parameters)},), got {vector.shape}")
    return parameters._spread(vector)


def wall_tangent(
    owner: str, prepared: PreparedScene, answer: Any, walls: HitSurfaces, parameters: Any, d_parameters: Any
) -> FloatArray | None:
    """Return the tangents (w, 22) of walls, forms then maps; None if no parameter changes."""
    if d_parameters is None:
        # Wrong parameters are an error even if none of them changes.
        if parameters is not None:
            check_parameters(owner, parameters, prepared)
        return None
    if parameters is None:
        raise ValueError(f"{owner}: d_parameters need parameters, from co.parameters(scene)")
    checked = check_parameters(owner, parameters, prepared)
    tangent = spread_tangent(owner, "d_parameters", d_parameters, checked)
    return np.concatenate(apply_jacobians(_cached_jacobians(prepared, answer, walls, checked), tangent), axis=1)


def parameter_cotangent(
    owner: str, prepared: PreparedScene, answer: Any, walls: HitSurfaces, parameters: Any, cotangents: FloatArray
) -> FloatArray | None:
    """Pull cotangents of walls (w, 22) back to the parameters, (parameters,); None without parameters."""
    if parameters is None:
        return None
    checked = check_parameters(owner, parameters, prepared)
    gradient = apply_jacobians_transposed(
        _cached_jacobians(prepared, answer, walls, checked), *split_forms_maps(cotangents), len(checked._full)
    )
    return gradient[checked._chosen]


def _cached_jacobians(
    prepared: PreparedScene, answer: Any, walls: HitSurfaces, parameters: Parameters
) -> SurfaceJacobians:
    """Return the Jacobians of the walls of a result. They are cached on the result.

    They cover all numbers of the scene, so one cache serves every selection of parameters.
    """
    cached: SurfaceJacobians | None = vars(answer).get("_moving")
    if cached is None:
        cached = vars(answer)["_moving"] = surface_jacobians(prepared, walls, parameters)
    return cached


# --- First hits


def hits_jvp(hits: Hits, parameters: Any, d_parameters: Any, d_origins: Any, d_directions: Any) -> Tangents:
    """Implement `Hits.jvp`."""
    prepared, shape = scene_of("jvp", hits), hits.rays.shape
    do = array_of("jvp", "d_origins", d_origins, shape, 3)
    dd = array_of("jvp", "d_directions", d_directions, shape, 3)
    walls, crossings = _hit_walls(hits)
    change = wall_tangent("jvp", prepared, hits, walls, parameters, d_parameters)
    t, *fields = push_forward(walls.rows, crossings, (change, do, dd), True)
    # Indexing by () makes the t of a single ray a scalar.
    return Tangents(t.reshape(shape)[()], *(part.reshape((*shape, part.shape[1])) for part in fields))


def hits_vjp(hits: Hits, parameters: Any, t: Any, point: Any, normal: Any, uv: Any) -> Cotangents:
    """Implement `Hits.vjp`."""
    prepared, shape = scene_of("vjp", hits), hits.rays.shape
    cotangents = [
        array_of("vjp", name, value, shape, width)
        for name, value, width in (("t", t, 1), ("point", point, 3), ("normal", normal, 3), ("uv", uv, 2))
    ]
    walls, crossings = _hit_walls(hits)
    rays, miss = pull_back(walls.rows, crossings, cotangents, parameters is not None)
    if miss >= 0:
        ray = [int(i) for i in np.unravel_index(miss, shape)]
        raise ValueError(f"vjp: cotangents must be 0 for rays that hit nothing, as the ray {ray} does")
    gradient = parameter_cotangent("vjp", prepared, hits, walls, parameters, rays.walls)
    return Cotangents(gradient, rays.origins.reshape((*shape, 3)), rays.directions.reshape((*shape, 3)))


def _hit_walls(hits: Hits) -> tuple[HitSurfaces, CrossingRows]:
    """Return the walls of hits, and the hits as crossings on them. They are cached on the hits."""
    cached: tuple[HitSurfaces, CrossingRows] | None = vars(hits).get("_met")
    if cached is None:
        surface, face, side = hits._faces
        walls = find_hit_surfaces(hits._scene, hits._buffers.body, face, surface)
        columns = walls.place, side, find_hit_ties(hits), hits._points, lines_of(hits.rays)[1], hits._buffers.t
        crossings = make_crossing_rows(*columns)
        cached = vars(hits)["_met"] = walls, crossings
    return cached


# --- Spans: their ends, lengths and line integrals
#
# Spans of one body do not depend on other bodies, so their ends have derivatives also where bodies abut. A clipped end
# is an end of the interval and does not move. When a span shrinks to nothing, its ends move ever faster, but its length
# does not jump: integrals over rays have no boundary term at outlines.


@dataclass
class _SpanEnds:
    """The ends of spans that lie on walls: all entries, then all exits."""

    which: Any  # (n,) the span of an entry, or count of spans + the span of an exit
    ray: Any  # (n,) the ray of each end
    walls: HitSurfaces
    crossings: CrossingRows


def _span_ends(spans: Spans) -> _SpanEnds:
    """Return the ends of all spans that lie on walls; clipped ends do not. They are cached on the spans."""
    cached: _SpanEnds | None = vars(spans).get("_met")
    if cached is not None:
        return cached
    prepared = spans._scene
    clipped = np.concatenate([spans.enter_clipped, spans.exit_clipped])
    which = np.flatnonzero(~clipped)
    # The order of all columns is that of `clipped`: entries first, then exits.
    t = np.concatenate([spans.t_enter, spans.t_exit])[which]
    body, surface = np.tile(spans.body, 2)[which], spans._ends.reshape(-1)[which].astype(np.int32)
    ray = np.tile(row_owners(spans.offsets), 2)[which]
    o, d = (part[ray] for part in lines_of(spans.rays))
    x, entry = o + t[:, None] * d, body.astype(np.int32)
    # Spans store the surfaces of their ends; the faces follow from the points.
    face = faces_of_ends(prepared, entry, surface, o, x)
    walls, ties = find_hit_surfaces(prepared, body, face, surface), find_ties_within(prepared, entry, face, o, x)
    # The side is +1 throughout: only normals depend on it, and spans have none.
    crossings = make_crossing_rows(walls.place, np.ones(len(t), np.int32), ties, x, d, t)
    cached = vars(spans)["_met"] = _SpanEnds(which, ray, walls, crossings)
    return cached


def spans_jvp(spans: Spans, parameters: Any, d_parameters: Any, d_origins: Any, d_directions: Any) -> SpanTangents:
    """Implement `Spans.jvp`."""
    prepared, shape = scene_of("jvp", spans), spans.shape
    do = array_of("jvp", "d_origins", d_origins, shape, 3)
    dd = array_of("jvp", "d_directions", d_directions, shape, 3)
    ends, count = _span_ends(spans), len(spans.body)
    change = wall_tangent("jvp", prepared, spans, ends.walls, parameters, d_parameters)
    d_t, d = np.zeros(2 * count), lines_of(spans.rays)[1]
    changes = change, *(None if part is None else part[ends.ray] for part in (do, dd))
    d_t[ends.which] = push_forward(ends.walls.rows, ends.crossings, changes, False).t
    # The relative change of |d|, by which lengths change at constant ends.
    stretch = np.zeros(len(d)) if dd is None else (d * dd).sum(axis=1) / (d * d).sum(axis=1)
    return SpanTangents(d_t[:count], d_t[count:], spans, stretch)


def spans_vjp(
    spans: Spans, parameters: Any, t_enter: Any, t_exit: Any, line_integral: Any, values: Any, otherwise: Any
) -> Cotangents:
    """Implement `Spans.vjp`."""
    prepared, shape, count = scene_of("vjp", spans), spans.shape, len(spans.body)
    of_rays, of_t = np.zeros((6, len(spans.offsets) - 1)), np.zeros((2, count))
    for row, name, value in ((0, "t_enter", t_enter), (1, "t_exit", t_exit)):
        cotangent = array_of("vjp", name, value, (count,), 1)
        if cotangent is not None:
            of_t[row] += cotangent
    if line_integral is not None:
        _integral_cotangent(spans, line_integral, values, otherwise, of_t, of_rays)
    ends = _span_ends(spans)
    cotangents = of_t.reshape(-1)[ends.which], None, None, None
    rays, _ = pull_back(ends.walls.rows, ends.crossings, cotangents, parameters is not None)
    # A ray gathers the cotangents of all its ends.
    for k, column in enumerate((*rays.origins.T, *rays.directions.T)):
        of_rays[k] += np.bincount(ends.ray, column, of_rays.shape[1])
    gradient = parameter_cotangent("vjp", prepared, spans, ends.walls, parameters, rays.walls)
    origins, directions = (np.ascontiguousarray(part.T).reshape((*shape, 3)) for part in (of_rays[:3], of_rays[3:]))
    return Cotangents(gradient, origins, directions)


def _integral_cotangent(
    spans: Spans, cotangents: Any, values: Any, otherwise: Any, of_t: FloatArray, of_rays: FloatArray
) -> None:
    """Add the cotangents of line integrals to `of_t` (2, spans), for the ends, and to `of_rays` (6, rays)."""
    if values is None:
        raise ValueError("vjp: line_integral needs values, as spans.line_integral(values) takes them")
    weights = weights_of(values, otherwise, spans._body_count, spans._distinct)
    table = weights.values.reshape(len(weights.values), -1)
    of_integrals = array_of("vjp", "line_integral", cotangents, (*spans.shape, *weights.shape), 1)
    assert of_integrals is not None
    places, _ = spans._places(weights.by)
    ray, chord = spans._chords()
    weight = (of_integrals.reshape(-1, table.shape[1])[ray] * table[places]).sum(axis=1)
    # A length is (t_exit - t_enter) |d|: it changes with both ends, and with the length of the direction.
    d = lines_of(spans.rays)[1]
    size = np.sqrt((d * d).sum(axis=1))
    of_t[0] -= weight * size[ray]
    of_t[1] += weight * size[ray]
    # Without weight an infinite chord counts as 0, not as NaN.
    stretch = np.where(weight == 0, 0.0, weight * np.where(weight == 0, 0.0, chord)) / size[ray] ** 2
    for k in range(3):
        of_rays[3 + k] += np.bincount(ray, stretch, of_rays.shape[1]) * d[:, k]


# The derivative of a volume by the numbers of a shape: the integral of the normal velocity over the wall.
#
# V_p = ∫ v dA with the outward velocity v = -f_p / |∇f| (Reynolds' transport theorem). Parallel rays along the three
# axes sample the wall, as `measure` finds areas. A ray along a crosses an element dA with density |n·a|, and Σ (n·a)² =
# 1 over the axes, so each crossing has weight |n·a|. No division by a cosine occurs: no boundary term at outlines is
# missed, and the variance is finite.

_ROUNDS = 16
"""Independent estimates, whose scatter gives the standard error."""
_FEWEST, _MOST = 3 * _ROUNDS, 10**12
"""Limits of `rays`: at least one ray per axis and round."""
_CHUNK = 1 << 16
"""Rays that are traced at a time."""


@dataclass(frozen=True)
class VolumeGradient:
    """The gradient of a body's volume, by `volume_gradient`.

    Attributes
    ----------
    gradient : float64 (parameters,)
        The derivatives of the volume by the parameters.
    error : float64 (parameters,)
        Their standard errors.
    rays : int
        Number of rays traced.
    """

    gradient: FloatArray
    error: FloatArray
    rays: int


@ignore_fp_errors
def volume_gradient(parameters: Parameters, body: str | int, rays: int = 300_000, seed: int = 0) -> VolumeGradient:
    """Return the gradient of the volume of a body by the parameters, by an integral over its wall.

    Parameters
    ----------
    parameters : Parameters
        Those of `co.parameters(scene)`.
    body : str or int
        The name of an entry, or the number of a body.
    rays : int
        About how many rays are traced; the error falls with their number.
    seed : int
        Equal seeds give equal results.

    Returns
    -------
    VolumeGradient
        NaN where walls of the body tie over an area, as flush walls of a union do.

    Raises
    ------
    TypeError
        For `parameters` of another type.
    ValueError
        For a body that is unbounded or a sheet.
    KeyError
        For an unknown name.
    IndexError
        For an unknown number.
    """
    if not isinstance(parameters, Parameters):
        raise TypeError(
            f"volume_gradient: parameters must be those of co.parameters(scene), got {describe_kind(parameters)}"
        )
    rays = check_integer("volume_gradient", "rays", rays, _FEWEST, _MOST)
    seed = check_integer("volume_gradient", "seed", seed, 0)
    entry, index = _entry(parameters._scene, body)
    target = parameters._scene.bodies[entry]
    shape = target.shape.single(index) if isinstance(target.shape, Bulk) else target.shape
    if shape.is_sheet:
        raise ValueError(f"volume_gradient: body must be a solid, got the sheet {format_value(body)}")
    box = shape.bounds
    if not np.isfinite(box).all():
        raise ValueError(f"volume_gradient: body must be bounded, got {format_value(body)} with bounds {box}")
    # Each round has side x side rays along each of the three axes.
    side = max(1, round((rays / (3 * _ROUNDS)) ** 0.5))
    # The entry alone: crossings of other bodies do not matter.
    estimates = np.array(list(_rounds(type(parameters._scene)([target]), index, box, side, seed)))
    full = np.zeros((2, len(parameters._full)))
    # The other parameters do not change the volume: their derivatives stay 0.
    own = slice(int(parameters._firsts[entry]), int(parameters._firsts[entry + 1]))
    full[0, own], full[1, own] = estimates.mean(axis=0), estimates.std(axis=0, ddof=1) / _ROUNDS**0.5
    gradient, error = full[:, parameters._chosen]
    return VolumeGradient(gradient, error, 3 * _ROUNDS * side * side)


def _entry(scene: SceneLike, body: Any) -> tuple[int, int]:
    """Return the entry of a body, and the number of the body within the entry."""
    if isinstance(body, str):
        return scene.bodies.index(body), 0
    scene.body(body)  # it raises for a number that does not exist
    entry = int(np.searchsorted(scene._firsts, body, side="right")) - 1
    return entry, int(body - scene._firsts[entry])


def _rounds(single_body: SceneLike, index: int, box: BoxEnds, side: int, seed: int) -> Iterator[FloatArray]:
    """Yield independent estimates (numbers of the shape,).

    Each is stratified: one random ray through every square of a grid on three sides of the box.
    """
    own = Parameters(single_body)
    low, size = box[0], np.maximum(box[1] - box[0], 0.0)
    grid = np.stack(np.meshgrid(np.arange(side), np.arange(side), indexing="ij"), axis=-1).reshape(-1, 2)
    for turn in range(_ROUNDS):
        total = np.zeros(len(own._full))
        for axis in range(3):
            random = np.random.default_rng((seed, turn, axis))
            across = [i for i in range(3) if i != axis]
            origins = np.empty((len(grid), 3))
            # One random point in each square of the grid.
            origins[:, across] = low[across] + size[across] * (grid + random.random(grid.shape)) / side
            origins[:, axis] = low[axis] - 0.5 * size[axis]
            weight = float(size[across].prod()) / len(grid)
            for begin in range(0, len(origins), _CHUNK):
                # The weight is the area of a square.
                total += weight * _integral(single_body, own, index, origins[begin : begin + _CHUNK], axis)
        yield total


def _integral(single_body: SceneLike, own: Parameters, index: int, origins: FloatArray, axis: int) -> FloatArray:
    """Return Σ |n·a| v over the crossings of rays along an axis a, for every number of the shape.

    v = |n·a| dt where the ray leaves the body, and -|n·a| dt where it enters. So the cotangent of t is ±(n·a)².
    """
    direction = np.eye(3)[axis]
    lists: spans.Crossings = single_body.crossings(origins, direction, t_min=-np.inf)
    # Other bodies of the entry do not count.
    mine = np.flatnonzero(lists.body == index)
    prepared, origins = single_body._prepared, origins[row_owners(lists.offsets)[mine]]
    t, directions = lists.t[mine], np.tile(direction, (len(mine), 1))
    points = origins + t[:, None] * directions
    body, face = lists.body[mine], lists.face[mine].astype(np.int32)
    walls, ties = (
        find_hit_surfaces(prepared, body, face, lists.surface[mine]),
        find_ties_within(prepared, body.astype(np.int32), face, points, points),
    )
    # The side does not matter: no normals are differentiated.
    crossings = make_crossing_rows(walls.place, np.ones(len(mine), np.int32), ties, points, directions, t)
    sense = np.where(lists.entering[mine], -1.0, 1.0)
    cotangents, _ = pull_back(walls.rows, crossings, (sense * lists.normal[mine, axis] ** 2, None, None, None), True)
    return apply_jacobians_transposed(
        surface_jacobians(prepared, walls, own), *split_forms_maps(cotangents.walls), len(own._full)
    )


# Differentiable functions of NumPy arrays, which the adapters for JAX and PyTorch wrap.
#
# Each has a forward pass and a backward pass (vector-Jacobian product) over the parameter vector and the rays.

Arrays = dict[str, FloatArray]
Axes = dict[str, tuple[int, ...]]


class DifferentiableFunction(Protocol):
    """A function (vector, origins, directions) -> named arrays, with its vector-Jacobian product."""

    shapes: Axes
    """Name of an output -> its axes after those of the rays."""

    def forward(self, vector: FloatArray, origins: FloatArray, directions: FloatArray) -> Arrays:
        """Return the outputs by name."""

    def backward(
        self, vector: FloatArray, origins: FloatArray, directions: FloatArray, cotangents: Arrays
    ) -> tuple[FloatArray, FloatArray, FloatArray]:
        """Return the cotangents of vector, origins and directions, in their shapes, from those of the outputs."""


@dataclass(frozen=True)
class AdapterFunctions:
    """Builds the differentiable functions of a scene's parameters."""

    parameters: Parameters

    def __post_init__(self) -> None:
        if not isinstance(self.parameters, Parameters):
            raise TypeError(f"parameters must be those of co.parameters(scene), got {describe_kind(self.parameters)}")

    def of_hits(self) -> DifferentiableFunction:
        """Return the function of first hits: t, point, normal, uv."""
        return _HitFunction(self.parameters)

    def of_integrals(self, values: npt.ArrayLike) -> DifferentiableFunction:
        """Return the function of line integrals with constant `values`, as `spans.line_integral` takes them."""
        return _IntegralFunction(self.parameters, np.asarray(values, np.float64))


class _HitFunction:
    """First hits. The backward pass traces the rays again."""

    shapes: Axes = {"t": (), "point": (3,), "normal": (3,), "uv": (2,)}  # noqa: RUF012 (never changed)

    def __init__(self, parameters: Parameters) -> None:
        self._parameters = parameters

    def forward(self, vector: FloatArray, origins: FloatArray, directions: FloatArray) -> Arrays:
        hits = self._parameters.scene(vector).first_hit(origins, directions)
        return {name: np.asarray(getattr(hits, name)) for name in self.shapes}

    def backward(
        self, vector: FloatArray, origins: FloatArray, directions: FloatArray, cotangents: Arrays
    ) -> tuple[FloatArray, FloatArray, FloatArray]:
        hits = self._parameters.scene(vector).first_hit(origins, directions)
        gradient = hits.vjp(self._parameters, **cotangents)
        return _shape_cotangents(gradient, origins, directions)


class _IntegralFunction:
    """Line integrals; overlapping bodies all count. The backward pass traces the rays again."""

    shapes: Axes = {"integral": ()}  # noqa: RUF012 (never changed)

    def __init__(self, parameters: Parameters, values: FloatArray) -> None:
        self._parameters, self._values = parameters, values

    def forward(self, vector: FloatArray, origins: FloatArray, directions: FloatArray) -> Arrays:
        spans = self._parameters.scene(vector).spans(origins, directions)
        return {"integral": np.asarray(spans.line_integral(self._values, overlaps="both"))}

    def backward(
        self, vector: FloatArray, origins: FloatArray, directions: FloatArray, cotangents: Arrays
    ) -> tuple[FloatArray, FloatArray, FloatArray]:
        spans = self._parameters.scene(vector).spans(origins, directions)
        gradient = spans.vjp(self._parameters, line_integral=cotangents["integral"], values=self._values)
        return _shape_cotangents(gradient, origins, directions)


def _shape_cotangents(
    gradient: Any, origins: FloatArray, directions: FloatArray
) -> tuple[FloatArray, FloatArray, FloatArray]:
    """Return the cotangents of vector, origins and directions, in the shapes of the arguments."""
    return (
        gradient.parameters,
        _sum_broadcast(gradient.origins, origins.shape),
        _sum_broadcast(gradient.directions, directions.shape),
    )


def _sum_broadcast(cotangent: FloatArray, shape: tuple[int, ...]) -> FloatArray:
    """Sum the cotangent of a broadcast array over the broadcast axes; the result has the array's own shape."""
    # First the axes that broadcasting added in front, then those of size 1 that it stretched.
    extra = cotangent.ndim - len(shape)
    total = cotangent.sum(axis=tuple(range(extra)))
    stretched = tuple(i for i, (have, size) in enumerate(zip(total.shape, shape, strict=True)) if have != size)
    return np.asarray(total.sum(axis=stretched, keepdims=True)).reshape(shape)
