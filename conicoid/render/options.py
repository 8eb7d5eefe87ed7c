"""Names of filters, tone curves, layers and colour keys, kinds of cameras, checks of sizes and suffixes of pictures.

The command line reads them at its start, so this module imports no NumPy. Cameras (`camera`) share their kinds with
the kernels of their rays (`camera_rays`) here, so that a scene with a camera can be read and edited without Numba.
"""

from __future__ import annotations

import os
from typing import TYPE_CHECKING, Any, Literal, Protocol, TypeAlias, get_args

if TYPE_CHECKING:
    from .._util.arrays import FloatArray

BY = ("body", "material")
"""Keys by which slices are coloured and volume fractions are grouped."""
CURVES = (".svg", ".pdf")
PIXELS = (".png", ".exr", ".jpg", ".jpeg", ".webp")
"""Suffixes of files with exact curves, and of files with pixels."""


def check_suffix(suffix: str, path: Any) -> None:
    """Raise ValueError for a suffix that slices are not saved as, ImportError for an .exr without OpenEXR."""
    from .._util.validation import format_value

    if suffix not in (*CURVES, *PIXELS):
        raise ValueError(
            f"Slice: slices are saved as {', '.join((*CURVES, *PIXELS))}, got {format_value(os.fspath(path))}"
        )
    if suffix == ".exr":
        from ..materials.image_file import import_openexr

        import_openexr()


Filter: TypeAlias = Literal["box", "tent", "gaussian", "mitchell", "blackman-harris"]
FILTERS: tuple[Filter, ...] = get_args(Filter)
Tone: TypeAlias = Literal["srgb", "filmic", "agx"]
TONES: tuple[Tone, ...] = get_args(Tone)

LAYERS = {
    "albedo": "the colours of what is first seen, without light: the mean of all samples, (h, w, 3)",
    "normal": "the outward unit normal at the pixel's centre, (h, w, 3); 0 where nothing is",
    "depth": "the distance from the camera at the pixel's centre, (h, w); inf where nothing is",
    "position": "the point of the world at the pixel's centre, (h, w, 3); NaN where nothing is",
    "body": "the number of the body at the pixel's centre, (h, w) integers; -1 where nothing is",
    "samples": "how many samples the pixel has, (h, w) integers",
    "error": "the standard error of its brightness as displayed, (h, w); see `noise`",
}
"""Name -> description."""

SAMPLES, MOST_SAMPLES = 4, 1 << 14
"""Samples of a pixel by default, and at most where only the noise is set."""

# Cameras

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
    from .._util.validation import as_integer, format_value

    for name, value in (("width", width), ("height", height)):
        pixels = as_integer(value)
        if pixels is None or not 1 <= pixels < 1 << 31:
            raise ValueError(f"{owner}: {name} must be a whole number of pixels >= 1, got {format_value(value)}")
    return int(width), int(height)
