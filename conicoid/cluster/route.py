"""Where a question goes that is not for this process alone: to workers, to Dask's arrays, or through here in parts."""

from __future__ import annotations

from typing import Any

from ..shapes.arrays import is_lazy
from ..shapes.validate import what


def is_dask(thing: Any) -> bool:
    """Is it an array of Dask, or one of its lazy collections?"""
    return is_lazy(thing)


def routed(
    scene: Any, query: str, executor: Any, origins: Any, directions: Any, t_min: Any, t_max: Any, *more: Any
) -> Any:
    """The answer to a query of rays; `more` are what it takes beyond rays and interval."""
    if any(map(is_dask, (origins, directions, t_min, t_max))):
        from . import lazy

        _no_executor(query, executor)
        return lazy.routed(scene, query, origins, directions, t_min, t_max, *more)
    from . import queries
    from .rays import Asked

    asked = Asked(query, origins, directions, t_min, t_max)
    if query == "lengths":
        by, overlaps, progress = more
        return queries.lengths(scene, asked, by, overlaps, executor, progress)
    if query == "line_integral":
        values, otherwise, overlaps, progress = more
        return queries.line_integral(scene, values, asked, (otherwise, overlaps), executor, progress)
    simple: dict[str, Any] = {
        "first_hit": queries.first_hit, "occluded": queries.occluded, "spans": queries.spans,
        "crossings": queries.crossings,
    }  # fmt: skip
    return simple[query](scene, asked, executor)


def located(scene: Any, query: str, executor: Any, points: Any) -> Any:
    """The answer to a query of points."""
    if is_dask(points) and query == "bodies_at":
        raise TypeError(f"{query}: points must be an array of NumPy's, got {what(points)}; body_at takes Dask's")
    if is_dask(points):
        from . import lazy

        _no_executor(query, executor)
        return lazy.located(scene, query, points)
    if hasattr(points, "_share"):
        raise TypeError(f"{query}: points must be an array (..., 3), got {what(points)}")
    from . import queries

    if query == "bodies_at":
        return queries.bodies_at(scene, points, executor)
    found = queries.body_at(scene, points, executor, query)
    return found if query == "body_at" else (found >= 0)


def measured(scene: Any, executor: Any, points: Any, max_distance: Any, exact: bool, progress: Any) -> Any:
    """Distances of points."""
    if is_dask(points) or hasattr(points, "_share"):
        raise TypeError(f"distance: points must be an array (..., 3) that is at hand, got {what(points)}")
    from . import queries

    return queries.distance(scene, points, max_distance, exact, executor, progress)


def _no_executor(query: str, executor: Any) -> None:
    if executor is not None:
        raise TypeError(f"{query}: executor must be left out for Dask's arrays: their own scheduler computes them")
