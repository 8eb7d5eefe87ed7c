"""The rays of a camera's pixels, made where they are traced."""

from __future__ import annotations

from functools import cached_property
from typing import TYPE_CHECKING, Any

import numpy as np

from ..engine.answers.lazy_rays import LazyRays
from ..shapes.same import by_value
from ..shapes.vector import FloatArray
from .camera import AnyCamera, checked_size

if TYPE_CHECKING:
    from .view import View


@by_value("camera", "width", "height")
class CameraRays(LazyRays):
    """`camera.rays(width, height)`, of shape (height, width)."""

    def __init__(self, camera: AnyCamera, width: int, height: int) -> None:
        self.camera = camera
        self.width, self.height = checked_size(width, height)

    @property
    def shape(self) -> tuple[int, ...]:
        return self.height, self.width

    def _lines(self, begin: int, end: int) -> tuple[FloatArray, FloatArray]:
        origins, directions = np.empty((end - begin, 3)), np.empty((end - begin, 3))
        self._fill(begin, origins, directions)
        return origins, directions

    def _fill(self, begin: int, origins: FloatArray, directions: FloatArray) -> None:
        from .view import fill_lines

        fill_lines(self._view, begin, self.width, self.height, origins, directions)

    @cached_property
    def _view(self) -> View:
        """Of a lens that of its middle, as a pinhole has it."""
        from .camera import LINEAR, THIN_LENS
        from .view import view_of

        view = view_of(self.camera, "box")
        return view._replace(kind=LINEAR) if view.kind == THIN_LENS else view

    def __getstate__(self) -> dict[str, Any]:
        return {name: value for name, value in self.__dict__.items() if name != "_view"}
