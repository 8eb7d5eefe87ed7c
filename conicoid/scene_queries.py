"""The questions that a scene answers: along rays, and at points."""

from __future__ import annotations

import math
from typing import TYPE_CHECKING, Any, Literal

import numpy as np

from .shapes.calm import calm
from .shapes.validate import callback
from .shapes.vector import FloatArray

if TYPE_CHECKING:
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
    def first_hit(self, origins: Any, directions: Any = None, t_min: Any = 0.0, t_max: Any = math.inf) -> Hits:
        """The nearest crossing of each ray in the open interval (t_min, t_max).

        Raises ValueError for rays that cannot be traced, with the index of the first.
        """
        from .engine.queries import queries

        if self._prepared is None:
            from .compiler.ahead import expect

            expect("rays", "streams", "points")
        return queries.first_hit(self.prepared, queries.as_rays(origins, directions), t_min, t_max)

    @calm
    def occluded(self, origins: Any, directions: Any = None, t_min: Any = 0.0, t_max: Any = math.inf) -> Any:
        """bool (...): is there any crossing strictly between t_min and t_max?  Equals first_hit(...).t < inf."""
        from .engine.queries import queries

        return queries.occluded(self.prepared, queries.as_rays(origins, directions), t_min, t_max)

    @calm
    def spans(self, origins: Any, directions: Any = None, t_min: Any = 0.0, t_max: Any = math.inf) -> Spans:
        """Every stretch of each ray inside each solid, clipped to [t_min, t_max], sorted along the ray."""
        from .engine.queries import queries

        return queries.spans(self.prepared, queries.as_rays(origins, directions), t_min, t_max)

    @calm
    def crossings(self, origins: Any, directions: Any = None, t_min: Any = 0.0, t_max: Any = math.inf) -> Crossings:
        """Every crossing of each ray with solids and sheets, strictly between t_min and t_max, sorted along the ray."""
        from .engine.queries import queries

        return queries.crossings(self.prepared, queries.as_rays(origins, directions), t_min, t_max)

    @calm
    def lengths(
        self, origins: Any, directions: Any = None, t_min: Any = 0.0, t_max: Any = math.inf, *,
        by: Literal["body", "material"] = "body", progress: Progress | None = None,
    ) -> FloatArray:  # fmt: skip
        """`spans(...).lengths(by)`, the same to the bit, for any number of rays: their spans are not kept.

        `progress(done, count)` is called with numbers of rays.
        """
        from .engine.queries import integrals, queries

        callback("lengths", "progress", progress)
        return integrals.lengths(self.prepared, queries.as_rays(origins, directions), t_min, t_max, by, progress)

    @calm
    def line_integral(
        self, values: Any, origins: Any, directions: Any = None, t_min: Any = 0.0, t_max: Any = math.inf, *,
        otherwise: Any = None, progress: Progress | None = None,
    ) -> Any:  # fmt: skip
        """`spans(...).line_integral(values)`, the same to the bit, for any number of rays: their spans are not kept.

        `values`: (bodies,) or (bodies, energies), a mapping from names of materials, or the name of a property.
        """
        from .engine.queries import integrals, queries

        callback("line_integral", "progress", progress)
        rays = queries.as_rays(origins, directions)
        return integrals.line_integral(self.prepared, values, rays, t_min, t_max, otherwise, progress)

    @calm
    def contains(self, points: Any) -> Any:
        """bool (...): does any solid contain the point (..., 3)? Primitives hold their boundary, Booleans are exact."""
        from .engine.queries import queries

        return np.asarray(queries.body_at(self.prepared, points, "contains") >= 0)[()]

    @calm
    def body_at(self, points: Any) -> Any:
        """int32 (...): the first listed body that contains the point (..., 3), or -1."""
        from .engine.queries import queries

        return queries.body_at(self.prepared, points)


QUERIES: dict[str, str] = {}
"""The name of each query, and of its first argument: "origins", "points" or others."""

for _name, _query in vars(Queries).items():
    if hasattr(_query, "__wrapped__"):
        _query.__wrapped__.__qualname__ = f"Scene.{_name}"  # as Python calls it where an argument is missing
        QUERIES[_name] = _query.__wrapped__.__code__.co_varnames[1]
