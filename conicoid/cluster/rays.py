"""Rays, points and intervals cut into the shares of tasks."""

from __future__ import annotations

import math
from typing import Any, NamedTuple

from ..engine.answers.lazy_rays import LazyRays
from ..engine.answers.rays import Rays, lines_of
from ..engine.queries.queries import as_rays, limits_of
from ..shapes.usual import given_or
from ..shapes.vector import FloatArray

SENT = 48
"""Bytes of a ray that is sent as numbers."""


class Share(NamedTuple):
    """Some of the flat rays as they travel, with their intervals."""

    rays: Rays | LazyRays
    begin: int
    end: int
    shape: tuple[int, ...]
    t_min: Any
    t_max: Any

    def made(self) -> Rays:
        """The rays of the share, in its shape."""
        if isinstance(self.rays, Rays):
            return self.rays
        return self.rays.part(self.begin, self.end, self.shape)


class Asked:
    """The rays of a question and their intervals, as a user gave them."""

    def __init__(self, query: str, origins: Any, directions: Any, t_min: Any, t_max: Any) -> None:
        lazy = isinstance(origins, LazyRays) and directions is None
        self.rays: Rays | LazyRays = origins if lazy else as_rays(query, origins, directions)
        first, last = self.rays.interval if isinstance(self.rays, LazyRays) else (t_min, t_max)
        self.t_min: FloatArray = limits_of(query, self.rays, "t_min", given_or(first, t_min))
        self.t_max: FloatArray = limits_of(query, self.rays, "t_max", given_or(last, t_max))

    @property
    def shape(self) -> tuple[int, ...]:
        return self.rays.shape

    @property
    def count(self) -> int:
        return math.prod(self.shape)

    @property
    def bytes_each(self) -> int:
        """That are sent for a ray."""
        ends = 8 * ((len(self.t_min) > 1) + (len(self.t_max) > 1))
        return ends + (1 if isinstance(self.rays, LazyRays) else SENT)

    @property
    def width(self) -> int:
        """Rays in a row, where they make a picture."""
        return self.shape[-1] if len(self.shape) > 1 else 0

    def share(self, begin: int, end: int) -> Share:
        """Flat rays `begin` to `end`; whole rows of a picture stay one."""
        width, count = self.width, end - begin
        rows = width > 0 and begin % width == 0 == count % width
        shape = (count // width, width) if rows else (count,)
        limits = (_cut(t, begin, end, shape) for t in (self.t_min, self.t_max))
        if isinstance(self.rays, LazyRays):
            source, first, last = self.rays._share(begin, end)
            return Share(source, first, last, shape, *limits)
        origins, directions = (lines[begin:end].reshape((*shape, 3)) for lines in lines_of(self.rays))
        starts = self.rays._starts
        some = starts[begin:end] if len(starts) > 1 else starts
        return Share(Rays._spawned(origins, directions, some, self.rays._home), 0, count, shape, *limits)

    def made(self) -> Rays:
        """All rays."""
        return self.rays.made() if isinstance(self.rays, LazyRays) else self.rays


def _cut(limits: FloatArray, begin: int, end: int, shape: tuple[int, ...]) -> Any:
    return limits[begin:end].reshape(shape) if len(limits) > 1 else float(limits[0])
