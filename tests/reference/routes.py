"""The same rays one at a time, in order, in no order, in streams and as a picture: equal to the bit."""

from typing import Any

import numpy as np

from conicoid.kernels.body.hit import is_doubtful
from conicoid.kernels.first_hits import HitBuffers, trace_first_alone
from conicoid.queries.exact.doubtful_rays import resolve_hits
from conicoid.queries.ray_queries import arrays_of

from .judge import Comparison
from .trace import Array

Random = np.random.Generator

FIELDS = (
    "t",
    "t_error",
    "point",
    "point_error",
    "body",
    "face",
    "surface",
    "entering",
    "normal",
    "local_point",
    "uv",
    "doubtful",
)
COLUMNS = ("t", "t_error", "body", "face", "surface", "entering")
STREAM = 33 * 64
"""Enough packets for the rays to be sorted and traced in streams."""


def in_doubt(scene: Any, rays: Any, t_min: Any = 0.0, t_max: Any = np.inf) -> Array:
    """Return for which rays (n,) alone the fast formulas doubt the hit, or something behind it."""
    arrays, found = arrays_of("first_hit", scene._prepared, rays, t_min, t_max), HitBuffers.new(rays.size)
    trace_first_alone(scene._prepared.geometry, arrays, 0, rays.size, found)
    return is_doubtful(found.turn)


def ties(scene: Any, rays: Any, t_min: Any = 0.0, t_max: Any = np.inf) -> tuple[Array, Array]:
    """Return t (n,), and which hits depend on a tie, as exact methods find them for all rays, doubtful or not."""
    arrays, found = arrays_of("first_hit", scene._prepared, rays, t_min, t_max), HitBuffers.new(rays.size)
    which = resolve_hits(scene._prepared, arrays, np.arange(rays.size), found)
    return found.t, np.isin(np.arange(rays.size), which)


class Routes:
    """A `comparison` once more by other routes; `limits` are t_min and t_max of each ray, or None for the usual ones."""

    def __init__(self, comparison: Comparison, limits: tuple[Array, Array] | None = None) -> None:
        self.comparison, self.scene, self.limits = comparison, comparison.judge.scene, limits
        self.rays = comparison.arguments[0] if comparison.spawned else None
        self.flat = self.hits(np.arange(comparison.count))
        t, tied = ties(self.scene, self.flat.rays, *(limits or ()))
        comparison.fail("routes: first_hit or exact methods", np.flatnonzero(self.flat.t != t))
        comparison.fail("routes: doubtful or a tie", np.flatnonzero(self.flat.doubtful != tied))

    def of(self, rows: Any) -> tuple[Any, ...]:
        if self.rays is not None:
            return (self.rays[rows],)
        return self.comparison.origins[rows], self.comparison.directions[rows]

    def within(self, rows: Any) -> dict[str, Any]:
        return {} if self.limits is None else {"t_min": self.limits[0][rows], "t_max": self.limits[1][rows]}

    def hits(self, rows: Any) -> Any:
        return self.scene.first_hit(*self.of(rows), **self.within(rows))

    def same(self, route: str, rows: Array, hits: Any) -> None:
        """Check that the hits of rays `which`, in any shape, are those of the flat array."""
        self.comparison.score.queries += rows.size
        for name in FIELDS:
            expected, found = getattr(self.flat, name)[rows], getattr(hits, name)
            differ = ~((expected == found) | ((expected != expected) & (found != found)))
            wrong = np.asarray(rows)[differ.reshape(*rows.shape, -1).any(axis=-1)]
            self.comparison.fail(f"routes: {name} {route}", wrong, "compare with the same rays in one flat array")
        hidden = self.scene.occluded(*self.of(rows), **self.within(rows))
        wrong = np.asarray(rows)[hidden != np.isfinite(self.flat.t[rows])]
        self.comparison.fail(f"routes: occluded {route}", wrong, "occluded is not first_hit.t < inf")

    def shuffled(self, r: Random) -> None:
        order = r.permutation(self.comparison.count)
        self.same("shuffled", order, self.hits(order))
        easy = np.flatnonzero(~self.flat.doubtful)
        if len(easy):
            more = easy[r.integers(0, len(easy), max(0, STREAM - len(order)))]
            stream = r.permutation(np.concatenate([order, more]))
            self.same("in a stream", stream, self.hits(stream))

    def singles(self, r: Random, count: int) -> None:
        for i in r.integers(0, self.comparison.count, count):
            self.same("alone", np.array(i), self.hits(i))
            self._lists("alone", np.array([i]), i)

    def picture(self, rows: Array) -> None:
        """Check the picture of rays `which` (height, width)."""
        self.same("in a picture", rows, self.hits(rows))
        self._lists("in a picture", rows.ravel(), rows)

    def _lists(self, route: str, which: Array, shape: Any = None) -> None:
        every = np.arange(self.comparison.count)
        one = self.scene.crossings(*self.of(every), **self.within(every))
        shape = which if shape is None else shape
        two = self.scene.crossings(*self.of(shape), **self.within(shape))
        counts = np.diff(one.offsets)[which]
        wrong = counts != np.diff(two.offsets)
        self.comparison.fail(f"routes: crossings {route}", which[wrong])
        if wrong.any():
            return
        rows = np.repeat(one.offsets[:-1][which] - two.offsets[:-1], counts) + np.arange(len(two.t))
        ray = np.repeat(which, counts)
        for name in COLUMNS:
            self.comparison.fail(
                f"routes: crossings.{name} {route}", ray[getattr(one, name)[rows] != getattr(two, name)]
            )
