"""The rays of a scan, made where they are traced."""

from __future__ import annotations

import math

import numpy as np

from ..engine.answers.lazy_rays import LazyRays
from ..shapes.arrays import without_traces
from ..shapes.same import by_value
from ..shapes.vector import FloatArray
from .geometry import Geometry


@by_value("geometry")
class ScanRays(LazyRays):
    """Rays to the pixels of a scan, in the shape of its sinogram."""

    def __init__(self, geometry: Geometry) -> None:
        self.geometry = geometry

    @property
    def shape(self) -> tuple[int, ...]:
        return self.geometry.shape

    @property
    def interval(self) -> tuple[float, float]:
        """That of the scan: from the source to the pixel, or the whole of a line."""
        return self.geometry.interval

    def _lines(self, begin: int, end: int) -> tuple[FloatArray, FloatArray]:
        scan = self.geometry
        pixel, column = np.divmod(np.arange(begin, end), scan.columns)
        view, row = np.divmod(pixel, scan.rows)
        places, first = scan.pixels(view, row, column), scan.vectors[view, :3]
        origins, directions = (places, first) if scan.is_parallel else (first, places - first)
        return without_traces(origins), without_traces(directions)

    def _share(self, begin: int, end: int) -> tuple[LazyRays, int, int]:
        each = math.prod(self.shape[1:])
        first, last = begin // each, -(-end // each)
        return ScanRays(self.geometry[first:last]), begin - first * each, end - first * each
