"""All integrals of a shape: three families of rays through its box."""

from __future__ import annotations

from typing import TYPE_CHECKING

import numpy as np

from ..scene import Scene
from ..shapes.base import Shape
from .chords import AREA, VOLUME, Family, Progress, Sums
from .frames import FittedBox
from .hull import Sight, directions_for, hull_of
from .refine import refined

if TYPE_CHECKING:
    from ..cluster.workers import Workers

_ROUNDING = 1e-14
"""No error is given as less than this part of the area, or of the volume times a power of the box's size."""


def sample(
    shape: Shape, box: FittedBox, rays: int, seed: int, progress: Progress | None, workers: Workers | None = None
) -> Sums:
    """Follow about `rays` rays, a third along each axis. A seed gives the same sums for any threads and workers."""
    sums = Sums(np.zeros(11), np.zeros((11, 11)))
    scene, directions = Scene([shape]), directions_for(shape, box)
    hull = hull_of(shape, box, directions)
    for axis in range(3):
        last, sight = (axis + 1) * rays // 3, Sight.along(axis, directions)
        family = Family(scene, box, sight, seed, sums, last, progress, rays, workers)
        rectangles = refined(family, hull)
        if len(rectangles):
            family.estimate(rectangles, max(2, family.left // len(rectangles)))
    if progress is not None:
        progress(rays, rays)
    reach = box.half.max() ** np.array([0, 1, 1, 1, 2, 2, 2, 2, 2, 2, 0])
    sizes = np.where(np.arange(11) == AREA, sums.values[AREA], sums.values[VOLUME]) * reach
    sums.covariance += np.diag((_ROUNDING * sizes) ** 2)
    return sums
