"""Many balls in one entry of a scene."""

from __future__ import annotations

from dataclasses import dataclass
from typing import Any, ClassVar

import numpy as np

from .arrays import real_array
from .base import Solid
from .boxes import EVERYWHERE
from .bulk import Bulk
from .calm import calm
from .motion import Motion
from .row_vectors import product
from .sphere import Sphere
from .validate import DOMAIN, outside_domain
from .vector import Box, FloatArray


@dataclass(frozen=True, eq=False)
class Spheres(Bulk, Solid):
    """N balls |x - centers[i]|² <= radii[i]² as N bodies with consecutive ids.

    `centers` (N, 3), `radii` (N,) or one number for all. A scene entry only: it does not combine
    with ``| & - ~`` (use `Sphere` there). uv and face as for `Sphere`.
    """

    centers: Any
    radii: Any
    columns: ClassVar = {"centers": ("x", "y", "z"), "radii": ("radius",)}

    @calm
    def __post_init__(self) -> None:
        centers = _floats("centers", self.centers)
        if centers.size == 0:
            centers = centers.reshape(0, 3)
        if centers.ndim != 2 or centers.shape[1] != 3:
            raise ValueError(f"Spheres: centers must have shape (N, 3), got {centers.shape}")
        radii = _floats("radii", self.radii)
        if radii.ndim == 0:
            radii = np.full(len(centers), float(radii))
        if radii.shape != (len(centers),):
            raise ValueError(
                f"Spheres: radii must have shape ({len(centers)},) as there are centers, got {radii.shape}"
            )
        for field, values in (("centers", centers), ("radii", radii)):
            bad = np.flatnonzero(~np.isfinite(np.atleast_2d(values.T)).all(axis=0))
            if len(bad):
                raise ValueError(f"Spheres: {field}[{bad[0]}] must be finite, got {values[bad[0]]}")
            bad = np.flatnonzero(np.atleast_2d(outside_domain(values).T).any(axis=0))
            if len(bad):
                raise ValueError(f"Spheres: {field}[{bad[0]}] must be {DOMAIN}, got {values[bad[0]]}")
        small = np.flatnonzero(radii <= 0)
        if len(small):
            raise ValueError(f"Spheres: radii[{small[0]}] must be > 0, got {radii[small[0]]}")
        for field, values in (("centers", centers), ("radii", radii)):
            values.flags.writeable = False
            object.__setattr__(self, field, values)

    def single(self, index: int) -> Sphere:
        return Sphere(self.row(index, "radii"), self.row(index, "centers"), motion=self.motion)

    def placed(self, outer: Motion) -> tuple[FloatArray, FloatArray, float | None]:
        """(centers in the world, linear part (3, 3), its factor if it is a similarity, else None)."""
        motion = self.motion.then(outer)
        if motion.is_identity:
            return self.centers, np.eye(3), 1.0
        matrix = motion.matrix
        linear = matrix[:3, :3]
        if np.array_equal(linear, np.eye(3)):
            return self.centers + matrix[:3, 3], linear, 1.0
        gram = product(linear, linear.T)
        factor = float(np.sqrt(gram[0, 0]))
        similar = np.allclose(gram, gram[0, 0] * np.eye(3), rtol=0, atol=1e-15 * gram[0, 0])
        return product(self.centers, linear.T) + matrix[:3, 3], linear, factor if similar else None

    def bounds_under(self, outer: Motion) -> Box:
        if len(self) == 0:
            return EVERYWHERE[1], EVERYWHERE[0]
        motion = self.motion.then(outer)
        shift = np.zeros(3) if motion.is_identity else motion.shift
        if shift is not None:
            ends = (_raised(sign * self.centers, sign * np.array(shift), self.radii[:, None]) for sign in (-1.0, 1.0))
            low, high = (end.max(axis=0) for end in ends)
            return 0.0 - low, high + 0.0
        centers, linear, _ = self.placed(outer)
        reach = self.radii[:, None] * np.sqrt((linear**2).sum(axis=1))
        low, high = (centers - reach).min(axis=0), (centers + reach).max(axis=0)
        return np.where(low == 0, 0.0, np.nextafter(low, -np.inf)), np.where(high == 0, 0.0, np.nextafter(high, np.inf))


def _raised(one: FloatArray, other: FloatArray, third: FloatArray) -> FloatArray:
    """The sum of three, or the next float where that is below it: so an end that is 0 on paper is 0."""
    first, lost = _two_sum(one, other)
    total, more = _two_sum(first, third)
    small, least = _two_sum(lost, more)
    total, rest = _two_sum(total, small)
    return np.where(rest + least > 0, np.nextafter(total, np.inf), total)


def _two_sum(a: FloatArray, b: FloatArray) -> tuple[FloatArray, FloatArray]:
    """A sum and what rounding took from it (Knuth)."""
    total = a + b
    part = total - a
    return total, (a - (total - part)) + (b - part)


def _floats(field: str, values: Any) -> FloatArray:
    return np.array(real_array("Spheres", field, values))
