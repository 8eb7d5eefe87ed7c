"""The questions that a scene answers: along rays, and at points."""

from __future__ import annotations

import math
import os
from typing import TYPE_CHECKING, Any, Literal

import numpy as np

from .shapes.arrays import is_lazy
from .shapes.calm import calm
from .shapes.usual import END, START
from .shapes.validate import callback, flag
from .shapes.vector import FloatArray

if TYPE_CHECKING:
    from .engine.answers.bodies_at import BodiesAt
    from .engine.answers.distances import Distances
    from .engine.answers.hits import Hits
    from .engine.answers.spans import Crossings, Spans
    from .engine.prepared import Prepared
    from .engine.threads import Progress


class Queries:
    """What can be asked of `prepared`, the lowered scene with its tree; `_prepared` is None before it is."""

    _prepared: Prepared | None

    @property
    def prepared(self) -> Prepared:
        """Built on first use."""
        raise NotImplementedError

    @calm
    def first_hit(
        self, origins: Any, directions: Any = None, t_min: Any = START, t_max: Any = END, *,
        executor: Any = None,
    ) -> Hits:  # fmt: skip
        """The nearest crossing of each ray in the open interval (t_min, t_max).

        origins, directions: (..., 3), which broadcast; or a `Rays` alone. Directions are of any length but 0.
        t_min, t_max: the interval, one for all rays or one for each, in units of the direction's length; where t_min
            is not below t_max it is empty, and nothing is hit. If not given, 0 and infinity; of the rays of a scan,
            `co.Rays.from_scan`, what the scan says.

        executor: an executor, a Dask client or a `co.cluster.Workers` that does it in parts, to the same bits; the
            other queries take it as well.

        Arrays of Dask instead of NumPy's have lazy answers, arrays of Dask too.
        Raises ValueError for rays that cannot be traced, with the index of the first.
        """
        if _goes_elsewhere(executor, origins, directions):
            from .cluster.route import routed

            found: Hits = routed(self, "first_hit", executor, origins, directions, t_min, t_max)
            return found
        from .engine.queries import queries

        return queries.first_hit(self.prepared, queries.as_rays("first_hit", origins, directions), t_min, t_max)

    @calm
    def occluded(
        self, origins: Any, directions: Any = None, t_min: Any = START, t_max: Any = END, *,
        executor: Any = None,
    ) -> Any:  # fmt: skip
        """bool (...): is there any crossing strictly between t_min and t_max?  Equals first_hit(...).t < inf.

        origins, directions, t_min, t_max: as for `first_hit`; in an empty interval, t_min >= t_max, there is none.
        executor: as for `first_hit`.
        """
        if _goes_elsewhere(executor, origins, directions):
            from .cluster.route import routed

            return routed(self, "occluded", executor, origins, directions, t_min, t_max)
        from .engine.queries import queries

        return queries.occluded(self.prepared, queries.as_rays("occluded", origins, directions), t_min, t_max)

    @calm
    def spans(
        self, origins: Any, directions: Any = None, t_min: Any = START, t_max: Any = END, *,
        executor: Any = None,
    ) -> Spans:  # fmt: skip
        """Every stretch of each ray inside each solid, clipped to [t_min, t_max], sorted along the ray.

        origins, directions, t_min, t_max: as for `first_hit`; an empty interval, t_min >= t_max, has no spans.
        executor: as for `first_hit`.
        """
        if _goes_elsewhere(executor, origins, directions):
            from .cluster.route import routed

            found: Spans = routed(self, "spans", executor, origins, directions, t_min, t_max)
            return found
        from .engine.queries import queries

        return queries.spans(self.prepared, queries.as_rays("spans", origins, directions), t_min, t_max)

    @calm
    def crossings(
        self, origins: Any, directions: Any = None, t_min: Any = START, t_max: Any = END, *,
        executor: Any = None,
    ) -> Crossings:  # fmt: skip
        """Every crossing of each ray with solids and sheets, strictly between t_min and t_max, sorted along the ray.

        origins, directions, t_min, t_max: as for `first_hit`; an empty interval, t_min >= t_max, has no crossings.
        executor: as for `first_hit`.
        """
        if _goes_elsewhere(executor, origins, directions):
            from .cluster.route import routed

            found: Crossings = routed(self, "crossings", executor, origins, directions, t_min, t_max)
            return found
        from .engine.queries import queries

        return queries.crossings(self.prepared, queries.as_rays("crossings", origins, directions), t_min, t_max)

    @calm
    def stream(
        self, rays: Any, query: str = "first_hit", *, chunk: int | None = None, executor: Any = None,
        out: str | os.PathLike[str] | None = None, **options: Any,
    ) -> Any:  # fmt: skip
        """The answers to any number of rays, part by part and in order: neither rays nor answers are kept.

        rays: `Rays`, those of `Rays.from_camera` or `from_scan`; (origins, directions), or one array (n, 6) of both,
            which may be of `np.memmap`, zarr or what else is sliced; an iterable of such, one part after the other; or
            the name of a file of rays, .npy, .npz, .csv, .parquet or .zarr, that is read part by part.
        query: the name of a query of rays; options: its other arguments, such as `t_max` or `values`, for all rays.
        chunk: rays of a part; by default about a second's.
        executor: as for `first_hit`; parts are sent ahead as its workers have time for them.
        out: a .npz, .csv, .parquet or .zarr that is to hold the answers, as `conicoid trace` writes them; for
            `occluded`, `lengths` and `line_integral` also .npy. It appears whole or not at all.

        Yields the query's answer for each part; with `out` it returns how many rays there were. Raises what the query
        raises, ImportError for .parquet and .zarr without pyarrow and zarr, OSError for what cannot be read or written.
        """
        from .cluster.stream import stream

        return stream(self, rays, query, chunk, executor, out, options)

    @calm
    def lengths(
        self, origins: Any, directions: Any = None, t_min: Any = START, t_max: Any = END, *,
        by: Literal["body", "material"] = "body", overlaps: Literal["both", "error"] | None = None,
        progress: Progress | None = None, executor: Any = None,
    ) -> FloatArray:  # fmt: skip
        """`spans(...).lengths(by)`, the same to the bit, for any number of rays: their spans are not kept.

        origins, directions, t_min, t_max: as for `first_hit`; in an empty interval, t_min >= t_max, lengths are 0.
        by: "body" for the shape (..., bodies), or "material" for (..., materials), in the order of `scene.materials`.
        overlaps: "both", "error" or None, as for `Spans.lengths`.
        progress: progress(done, count) is called with numbers of rays.
        executor: as for `first_hit`.
        """
        from .engine.queries import integrals, queries

        callback("lengths", "progress", progress)
        if _goes_elsewhere(executor, origins, directions):
            from .cluster.route import routed

            found: FloatArray = routed(
                self, "lengths", executor, origins, directions, t_min, t_max, by, overlaps, progress
            )
            return found
        rays = queries.as_rays("lengths", origins, directions)
        return integrals.lengths(self.prepared, rays, t_min, t_max, by, progress, overlaps)

    @calm
    def line_integral(
        self, values: Any, origins: Any, directions: Any = None, t_min: Any = START, t_max: Any = END, *,
        otherwise: Any = None, overlaps: Literal["both", "error"] | None = None, progress: Progress | None = None,
        executor: Any = None,
    ) -> Any:  # fmt: skip
        """`spans(...).line_integral(values)`, the same to the bit, for any number of rays: their spans are not kept.

        It is the sum over what each ray goes through of value × length: (...), or (..., energies).

        values: (bodies,) or (bodies, energies); or a mapping from names of materials to numbers or arrays (energies,),
            a name standing for all materials that have it; or the name of a property that materials have.
        origins, directions, t_min, t_max: as for `first_hit`; over an empty interval, t_min >= t_max, it is 0.
        otherwise: stands for materials without such a value, which are a ValueError if it is not given.
        overlaps: "both", "error" or None, as for `Spans.line_integral`.
        progress: progress(done, count) is called with numbers of rays.
        executor: as for `first_hit`.
        """
        from .engine.queries import integrals, queries

        callback("line_integral", "progress", progress)
        if _goes_elsewhere(executor, origins, directions):
            from .cluster.route import routed

            more = values, otherwise, overlaps, progress
            return routed(self, "line_integral", executor, origins, directions, t_min, t_max, *more)
        rays = queries.rays_after_values(values, origins, directions)
        return integrals.line_integral(self.prepared, values, rays, t_min, t_max, otherwise, progress, overlaps)

    @calm
    def contains(self, points: Any, *, executor: Any = None) -> Any:
        """bool (...): does any solid contain the point? Primitives hold their boundary, Booleans are exact.

        points: (..., 3), finite.
        executor: as for `first_hit`.
        """
        if _goes_elsewhere(executor, points):
            from .cluster.route import located

            return located(self, "contains", executor, points)
        from .engine.queries.points import body_at

        return np.asarray(body_at(self.prepared, points, "contains") >= 0)[()]

    @calm
    def body_at(self, points: Any, *, executor: Any = None) -> Any:
        """int32 (...): the number of the first listed body that contains the point, or -1.

        points: (..., 3), finite.
        executor: as for `first_hit`.
        """
        if _goes_elsewhere(executor, points):
            from .cluster.route import located

            return located(self, "body_at", executor, points)
        from .engine.queries.points import body_at

        return body_at(self.prepared, points)

    @calm
    def bodies_at(self, points: Any, *, executor: Any = None) -> BodiesAt:
        """All bodies that contain each point, in their order, as lists one after the other.

        points: (..., 3), finite.
        executor: as for `first_hit`.
        """
        if _goes_elsewhere(executor, points):
            from .cluster.route import located

            found: BodiesAt = located(self, "bodies_at", executor, points)
            return found
        from .engine.queries.points import bodies_at

        return bodies_at(self.prepared, points)

    @calm
    def distance(
        self, points: Any, *, exact: bool = False, max_distance: Any = math.inf, progress: Progress | None = None,
        executor: Any = None,
    ) -> Distances:  # fmt: skip
        """How far each point is from the nearest wall of any body: negative inside a solid, inf where there is none.

        By default a certified bound: no wall is nearer than that. It is the distance itself for one surface, less
        near edges and where bodies are combined.

        points: (..., 3), finite.
        exact: whether to find the nearest wall itself: its point, normal, body and face, with an error bound.
        max_distance: walls beyond are not looked for, one for all points or one for each; such distances are infinite.
        progress: progress(done, count) is called with numbers of points.
        executor: as for `first_hit`.

        Raises ValueError for points that are not finite and a max_distance that is not positive.
        """
        from .engine.queries import distances

        callback("distance", "progress", progress)
        exact = flag("distance", "exact", exact)
        if _goes_elsewhere(executor, points):
            from .cluster.route import measured

            found: Distances = measured(self, executor, points, max_distance, exact, progress)
            return found
        return distances.distance(self.prepared, points, max_distance, exact, progress)


def _goes_elsewhere(executor: Any, *arrays: Any) -> bool:
    """Is a question for workers, or of rays that are not at hand as a whole?"""
    return executor is not None or any(is_lazy(a) or hasattr(a, "_share") for a in arrays)


QUERIES: dict[str, str] = {}
"""The name of each query, and of its first argument: "origins", "points" or others."""

for _name, _query in vars(Queries).items():
    if hasattr(_query, "__wrapped__"):
        _query.__wrapped__.__qualname__ = f"Scene.{_name}"  # as Python calls it where an argument is missing
        QUERIES[_name] = _query.__wrapped__.__code__.co_varnames[1]
