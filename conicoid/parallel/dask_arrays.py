"""Queries of Dask arrays, with lazy answers.

Each block of the rays is one task. Fields of the answer are arrays of the blocks of the rays. The scene is part of the
graph, as the bytes of its recipe. So a result that is lost with a worker can be computed again on any other one:
nothing is scattered.
"""

from __future__ import annotations

import math
from typing import Any

import numpy as np

from .._util.text import format_count
from .._util.validation import describe_kind
from ..kernels.threads import limit_threads
from ..queries.hits import Hits
from ..queries.line_integrals import trailing_axes
from ..queries.scene_protocol import SceneLike
from ..queries.spans import Crossings, Spans
from ..queries.weights import BODY
from .shared_state import find_shared, shared_scene, source_version
from .workers import worker_name

_SCALARS: dict[str, Any] = dict(
    t=float, body=np.int32, face=np.int32, surface=np.int32, hit=bool, entering=bool, doubtful=bool,
    t_error=float, point_error=float,
)  # fmt: skip
_VECTORS = dict(point=3, local_point=3, normal=3, uv=2)


class LazyHits:
    """The lazy answer to `first_hit` for arrays of Dask: each field of `Hits` as an array of the rays' chunks.

    t, body, face, surface, hit, entering, doubtful, t_error, point_error   (...)
    point, local_point, normal   (..., 3)
    uv                           (..., 2)
    blocks                       (...), a `Hits` in place of each block, without its scene

    Several fields that are computed together (`dask.compute(hits.t, hits.body)`) trace the rays once.
    """

    def __init__(self, blocks: Any) -> None:
        self.blocks = blocks

    @property
    def shape(self) -> tuple[int, ...]:
        """The leading shape of the rays."""
        return self.blocks.shape

    def __getattr__(self, name: str) -> Any:
        # Fields are computed from the blocks on access, so that unused ones cost nothing.
        if name in _SCALARS:
            return _field(self.blocks, name, _SCALARS[name])
        if name in _VECTORS:
            return _field(self.blocks, name, float, _VECTORS[name])
        fields = ", ".join([*_SCALARS, *_VECTORS])
        raise AttributeError(f"LazyHits has no field {name[:80]!r}; it has {fields}")

    def __dir__(self) -> list[str]:
        return [*_SCALARS, *_VECTORS, "blocks", "shape"]

    def __repr__(self) -> str:
        return f"LazyHits(shape={self.shape}, {_chunks(self.blocks)})"


class LazyLists:
    """The lazy answer to `spans` or `crossings` for arrays of Dask: lists of rows for each ray, block by block.

    counts    (...): the number of rows of each ray
    blocks    (...): a `Spans` or `Crossings` in place of each block, without its scene
    bag       the blocks as a dask.bag, for functions of their fields (`.map(lambda spans: spans.t_enter)`)
    lengths(by), line_integral(values)   of spans: arrays (..., bodies) or (..., energies), as those of `Spans`
    """

    def __init__(self, blocks: Any, sums: Any) -> None:
        self.blocks, self._sums = blocks, sums

    @property
    def shape(self) -> tuple[int, ...]:
        """The leading shape of the rays."""
        return self.blocks.shape

    @property
    def counts(self) -> Any:
        """Number of rows of each ray, (...) int64."""
        return _map_blocks(_counts, self.blocks, dtype=np.int64)

    @property
    def bag(self) -> Any:
        """The blocks as a dask.bag."""
        import dask.bag as bag

        # Each block is one partition, in the order of the rays.
        return bag.from_delayed([bag_of(block) for block in self.blocks.to_delayed().ravel()])

    def lengths(self, by: str = BODY, overlaps: str | None = None) -> Any:
        """Return lengths of the rays inside each body or material; the spans are not kept.

        Parameters
        ----------
        by : {"body", "material"}
            The columns of the answer.
        overlaps : str, optional
            As in `Spans.lengths`.

        Returns
        -------
        dask.array.Array
            (..., bodies) or (..., materials).
        """
        return self._summed("lengths", by=by, overlaps=overlaps)

    def line_integral(self, values: Any, otherwise: Any = None, overlaps: str | None = None) -> Any:
        """Return sums of value × length along each ray; the spans are not kept.

        Parameters
        ----------
        values
            Values of bodies or materials, as in `Spans.line_integral`.
        otherwise
            The value of all others, as there.
        overlaps : str, optional
            As there.

        Returns
        -------
        dask.array.Array
            (...) or (..., energies).
        """
        return self._summed("line_integral", values=values, otherwise=otherwise, overlaps=overlaps)

    def _summed(self, query: str, **options: Any) -> Any:
        """Return sums over spans. Raise AttributeError for crossings."""
        if self._sums is None:
            raise AttributeError(f"crossings have no {query}: spans have")
        return self._sums(query, options)

    def __repr__(self) -> str:
        return f"LazyLists(shape={self.shape}, {_chunks(self.blocks)})"


# Queries as arrays with one task for each block.


def lazy_ray_query(
    scene: SceneLike, query: str, origins: Any, directions: Any, t_min: Any, t_max: Any, options: dict[str, Any]
) -> Any:
    """Return the lazy answer to a query of rays in arrays of Dask."""
    arrays = _arrays(query, origins, directions, t_min, t_max)
    if query in ("lengths", "line_integral"):
        return _sums(scene, query, arrays, options)
    if query == "occluded":
        return _map_query(scene, query, arrays, {}, dtype=bool)
    blocks = _map_query(scene, query, arrays, {}, dtype=object)
    if query == "first_hit":
        return LazyHits(blocks)
    sums = (lambda name, options: _sums(scene, name, arrays, options)) if query == "spans" else None
    return LazyLists(blocks, sums)


def lazy_point_query(scene: SceneLike, query: str, points: Any) -> Any:
    """Return the lazy answer to a query of points in an array of Dask."""
    rows = _whole_rows(query, "points", points)
    kind = bool if query == "contains" else np.int32
    return _map_blocks(
        _answer_points,
        rows,
        name=query,
        scene=_scene(scene),
        query=query,
        edition=source_version(),
        dtype=kind,
        drop_axis=rows.ndim - 1,
    )


def _sums(scene: SceneLike, query: str, arrays: list[Any], options: dict[str, Any]) -> Any:
    """Return lazy lengths or line integrals of rays."""
    return _map_query(scene, query, arrays, options, dtype=float, last=trailing_axes(scene._prepared, query, options))


def _arrays(query: str, origins: Any, directions: Any, t_min: Any, t_max: Any) -> list[Any]:
    """Return origins, directions and interval as arrays of the same blocks; vectors are whole in each."""
    import dask.array as da

    if directions is None:
        raise TypeError(f"{query}: directions are missing: arrays of Dask come as origins and directions")
    lines = [_whole_rows(query, name, x) for name, x in (("origins", origins), ("directions", directions))]
    try:
        shape = np.broadcast_shapes((1, 3), *(x.shape for x in lines))
        limits = [da.asarray(t, dtype=float) for t in (t_min, t_max)]
        # A last axis of length 1: then rays and limits have as many axes, and one call aligns their blocks.
        limits = [da.broadcast_to(t, shape[:-1])[..., None] for t in limits]
        lines = [da.broadcast_to(x, shape) for x in lines]
        fitting: list[Any] = da.unify_chunks(*_interleave([*lines, *limits], len(shape)))[1]
    except ValueError as error:
        raise ValueError(f"{query}: origins, directions, t_min and t_max do not fit together: {error}") from None
    return fitting


def _interleave(arrays: list[Any], ndim: int) -> list[Any]:
    """Return arrays and their indices, as `unify_chunks` needs them; the last axes of rays and of limits differ."""
    rays, ends = tuple(range(ndim)), (*range(ndim - 1), ndim)
    return [part for array in arrays for part in (array, rays if array.shape[-1] == 3 else ends)]


def _whole_rows(query: str, name: str, array: Any) -> Any:
    """Return an array (..., 3) whose vectors are not cut."""
    import dask.array as da

    rows = da.asarray(array)
    if rows.ndim < 1 or rows.shape[-1] != 3 or any(map(math.isnan, rows.shape)):
        raise ValueError(
            f"{query}: {name} must be an array (..., 3) of known chunks, got {describe_kind(array)} {rows.shape}"
        )
    return rows.rechunk({rows.ndim - 1: 3})


def _map_query(
    scene: SceneLike, query: str, arrays: list[Any], options: dict[str, Any], dtype: Any, last: tuple[int, ...] = ()
) -> Any:
    """Return a lazy array with one task for each block: the query of its rays."""
    shape = (
        dict(drop_axis=arrays[0].ndim - 1) if not last else dict(chunks=(*arrays[0].chunks[:-1], *((n,) for n in last)))
    )
    return _map_blocks(
        _answer,
        *arrays,
        name=query,
        scene=_scene(scene),
        query=query,
        options=options,
        edition=source_version(),
        dtype=dtype,
        **shape,
    )


def _map_blocks(function: Any, *arrays: Any, dtype: Any, name: str | None = None, **more: Any) -> Any:
    """Return `dask.array.map_blocks` with the type of its result, so that Dask makes no trial call."""
    import dask.array as da

    # Equal queries of equal arrays get equal keys, so that Dask computes them once.
    token = dict(token=f"conicoid-{name}-{_token(arrays, more)}") if name else {}
    # With `meta` Dask knows the type and makes no trial call.
    meta = np.empty((0,) * arrays[0].ndim, dtype)
    return da.map_blocks(function, *arrays, dtype=dtype, meta=meta, **token, **more)


def _token(arrays: Any, more: Any) -> str:
    """Return a hash of arrays and arguments; arguments that are keys of the graph stand for their content."""
    from dask.base import tokenize

    arguments = {key: value.key if hasattr(value, "dask") else value for key, value in more.items()}
    return tokenize([x.name for x in arrays], arguments)


def _scene(scene: SceneLike) -> Any:
    """Return the recipe of a scene as one key of a graph."""
    from dask.delayed import delayed

    recipe = shared_scene(scene)
    # One key for all tasks: a lost result can be computed again from these bytes.
    return delayed(recipe.reference(whole=True), name=f"conicoid-scene-{recipe.key.hex()}", traverse=False)


def _field(blocks: Any, name: str, dtype: Any, last: int = 0) -> Any:
    """Return one field of the answers as a lazy array."""
    # Vectors add an axis, which is one chunk.
    shape = dict(new_axis=blocks.ndim, chunks=(*blocks.chunks, (last,))) if last else {}
    return _map_blocks(_read_field, blocks, field=name, dtype=dtype, **shape)


# The functions that run on workers.


def _answer(*arrays: Any, scene: Any, query: str, options: dict[str, Any], edition: str) -> Any:
    """Return one block's answer; this runs on a worker. `arrays` are `origins`, `directions`, `t_min`, `t_max`."""
    origins, directions, t_min, t_max = arrays
    local_scene, values = _ready(scene, edition), dict(options)
    first = [values.pop("values")] if query == "line_integral" else []
    with limit_threads(1):
        answer = getattr(local_scene, query)(*first, origins, directions, t_min[..., 0], t_max[..., 0], **values)
        return answer.detached() if isinstance(answer, Hits | Spans | Crossings) else np.asarray(answer)


def _answer_points(points: Any, scene: Any, query: str, edition: str) -> Any:
    """Return one block's answer to a query of points; this runs on a worker."""
    with limit_threads(1):
        return np.asarray(getattr(_ready(scene, edition), query)(points))


def _ready(reference: Any, edition: str) -> Any:
    """Return the scene of a reference in this worker. Raise ValueError if its edition differs."""
    if edition != source_version():
        raise ValueError(
            f"executor: the worker {worker_name()} has conicoid {source_version()}, and the graph was made by {edition}"
        )
    (scene,) = find_shared(reference)
    return scene


def _read_field(hits: Any, field: str) -> Any:
    """Return one field of a block."""
    return np.asarray(getattr(hits, field))


def _counts(lists: Any) -> Any:
    """Return the number of rows of each ray of a block."""
    return np.diff(lists.offsets).reshape(lists.shape)


def bag_of(block: Any) -> Any:
    """Return a block as a partition of a bag: a list of one."""
    from dask.delayed import delayed

    return delayed(lambda found: [found], pure=True)(block)


def _chunks(blocks: Any) -> str:
    """Return the number of blocks as a text."""
    return format_count(blocks.npartitions, "block", "blocks")


def lazy_parts(scene: SceneLike, call: Any, shares: list[Any], options: Any, shapes: list[tuple[int, ...]]) -> Any:
    """Return call(scene, share, options) of each share as a block along the first axis."""
    import dask.array as da
    from dask.delayed import delayed

    reference, edition = _scene(scene), source_version()
    task = delayed(_call_on_scene, pure=True)
    parts = [task(call, reference, share, options, edition) for share in shares]
    blocks = [da.from_delayed(part, shape, float) for part, shape in zip(parts, shapes, strict=True)]
    return da.concatenate(blocks)


def _call_on_scene(call: Any, reference: Any, share: Any, options: Any, edition: str) -> Any:
    """Call a function with the scene of a reference; this runs on a worker."""
    with limit_threads(1):
        return call(_ready(reference, edition), share, options)
