"""Constants that cameras share with the kernels of their rays: kinds of camera, and the size of a picture.

`camera` has the classes, which need no compiler; `camera_rays` has the kernels. Neither imports the other's part from
here, so that a scene with a camera can be read, written and edited without Numba.
"""

from __future__ import annotations

from typing import Protocol

from .._util.arrays import FloatArray
from .._util.validation import as_integer, format_value

LINEAR, THIN_LENS, EQUIRECTANGULAR, FISHEYE = range(4)
"""Kinds of camera."""
EQUIDISTANT, EQUISOLID, STEREOGRAPHIC = range(3)
"""Projections of a fisheye camera."""
CAMERA_NUMBERS = 4
"""The numbers of a kind besides its lens."""


class CameraModel(Protocol):
    """A camera as the kernels see it; `camera.AnyCamera` is one."""

    @property
    def lens(self) -> FloatArray:
        """(6, 3): o₀, o₁, o₂, d₀, d₁, d₂."""

    @property
    def optics(self) -> tuple[int, tuple[float, float, float, float]]:
        """The kind of camera, and its numbers."""


def check_size(width: int, height: int, owner: str = "rays") -> tuple[int, int]:
    """Return the size of a picture in pixels; raise ValueError, which begins with `owner`, unless it is positive."""
    for name, value in (("width", width), ("height", height)):
        pixels = as_integer(value)
        if pixels is None or not 1 <= pixels < 1 << 31:
            raise ValueError(f"{owner}: {name} must be a whole number of pixels >= 1, got {format_value(value)}")
    return int(width), int(height)
