"""The rays of a camera's pixels, made where they are traced."""

from __future__ import annotations

import numpy as np

from ..engine.answers.lazy_rays import LazyRays
from ..shapes.vector import FloatArray
from .camera import AnyCamera, checked_size, lines_through


class CameraRays(LazyRays):
    """`camera.rays(width, height)`, of shape (height, width)."""

    def __init__(self, camera: AnyCamera, width: int, height: int) -> None:
        self.camera = camera
        self.width, self.height = checked_size(width, height)

    @property
    def shape(self) -> tuple[int, ...]:
        return self.height, self.width

    def _lines(self, begin: int, end: int) -> tuple[FloatArray, FloatArray]:
        row, column = np.divmod(np.arange(begin, end), self.width)
        return lines_through(self.camera, column + 0.5, row + 0.5, self.width, self.height)
