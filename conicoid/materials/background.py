"""What rays see that hit nothing: one colour, or a sky that changes with height."""

from __future__ import annotations

import os
from dataclasses import dataclass
from typing import Any, ClassVar, TypeAlias

import numpy as np

from .._util.arrays import FloatArray
from .._util.user_warnings import warn
from .._util.validation import check_degrees, check_nonnegative, describe_kind
from .._util.validation import check_path as checked_path
from .color import BRIGHT, BYTE, Color, bytes_hint, check_color, grey_hint, look_like_bytes, srgb_decode
from .image_file import image_array, read_pixels
from .texture import ImagePath


def _light(owner: str, field: str, value: Any) -> Color:
    """A colour, which may be brighter than white; three bytes are refused, as everything would be white."""
    color = check_color(owner, field, value, most=float("inf"))
    if not isinstance(color, str) and look_like_bytes(color):
        brighter = "what is brighter than white is co.Sky(zenith, horizon, ground, intensity)"
        raise ValueError(
            f"{owner}: {field} must be linear light, of which 1 is white, got {color}; {bytes_hint(color)}; {brighter}"
        )
    if not isinstance(color, str) and BRIGHT < max(color) <= BYTE:
        warn(
            f"{owner}: {field} {color} is linear light, {max(color):g} times white; co.Sky(..., intensity=...) says so"
        )
    return color


@dataclass(frozen=True)
class Sky:
    """From `ground` straight down over `horizon` to `zenith` straight up (the z axis).

    Between them linear in the square root of |direction's z|, so that most of the change is near the horizon.
    Without `ground` the lower half looks like the horizon. All is `intensity` times as bright as the colours say.
    """

    zenith: Color = (0.28, 0.45, 0.75)
    horizon: Color = (0.85, 0.9, 0.95)
    ground: Color | None = None
    intensity: float = 1.0

    def __post_init__(self) -> None:
        for field in ("zenith", "horizon", "ground"):
            value = getattr(self, field)
            if value is not None or field != "ground":
                object.__setattr__(self, field, _light("Sky", field, value))
        object.__setattr__(self, "intensity", check_nonnegative("Sky", "intensity", self.intensity))


def _read(path: str | os.PathLike[str]) -> Any:
    """What is in a file, as linear light."""
    try:
        return read_pixels(path).linear(is_data=False)
    except ValueError as error:
        raise ValueError(f"Environment: pixels: file {error}") from None


@dataclass(frozen=True, eq=False)
class Environment:
    """An image of all directions around a scene, equirectangular, which lights it in light transport.

    pixels: (height, width, 3), linear radiance >= 0, bytes (uint8) of sRGB, or an `Image`; or the name of a file, an
        .exr of linear light, or a .png, .jpg or .webp, which is read at once. A scene file may name those in its own
        folder, or below.
        The first row is straight up, +z; along a row the angle about z grows from left to right, from the x axis on.
    intensity: everything is so many times as bright.
    rotation: degrees about z by which the image is turned, counter-clockwise as seen from above.

    Whitted's pictures show the mean colours of its top, middle and bottom.
    """

    pixels: ImagePath | Any
    intensity: float = 1.0
    rotation: float = 0.0
    file: ClassVar[ImagePath | None] = None
    """Where they were read from."""

    def __post_init__(self) -> None:
        if isinstance(self.pixels, str | os.PathLike):
            object.__setattr__(self, "file", ImagePath(os.path.abspath(checked_path("Environment", self.pixels))))
            found: Any = _read(self.pixels)
        else:
            found = image_array("Environment", "pixels", self.pixels)
        found = srgb_decode(found / 255) if found.dtype == np.uint8 else found
        if found.ndim != 3 or found.shape[2] != 3 or found.size == 0:
            raise ValueError(f"Environment: pixels must have shape (height, width, 3), got {found.shape}")
        bad = np.argwhere(~(np.isfinite(found) & (found >= 0)))
        if len(bad):
            place = tuple(int(k) for k in bad[0])
            raise ValueError(f"Environment: pixels{list(place)} must be finite and >= 0, got {found[place]}")
        intensity = check_nonnegative("Environment", "intensity", self.intensity)
        rotation = check_degrees("Environment", "rotation", self.rotation)
        pixels = np.array(found, np.float64)
        pixels.flags.writeable = False
        for field, value in (("pixels", pixels), ("intensity", intensity), ("rotation", rotation)):
            object.__setattr__(self, field, value)

    @classmethod
    def of_file(cls, path: str | os.PathLike[str], intensity: float = 1.0, rotation: float = 0.0) -> Environment:
        """The picture of all directions in a file, an .exr of linear light, or a .png, .jpg or .webp.

        path: the file; intensity, rotation: those of an `Environment`.

        Raises ValueError for what is missing, no picture, or damaged.
        """
        return cls(ImagePath(checked_path("Environment", path)), intensity, rotation)

    def __eq__(self, other: object) -> bool:
        return (
            isinstance(other, Environment) and self._key() == other._key() and np.array_equal(self.pixels, other.pixels)
        )

    def __hash__(self) -> int:
        return hash(self._key())

    def _key(self) -> tuple[Any, ...]:
        pixels: Any = self.pixels
        return pixels.shape, float(pixels.sum()), self.intensity, self.rotation

    @property
    def radiance(self) -> FloatArray:
        """(height, width, 3) with intensity and rotation, which is rounded to whole pixels."""
        pixels: Any = self.pixels
        turned: FloatArray = np.roll(pixels, round(self.rotation / 360 * pixels.shape[1]), axis=1)
        return self.intensity * turned


Background: TypeAlias = Color | Sky | Environment
DEFAULT_BACKGROUND = Sky((0.62, 0.72, 0.84), (0.94, 0.95, 0.96))


def as_background(value: Any) -> Background | None:
    """A colour, a Sky, or None for the default, checked."""
    if value is None or isinstance(value, Sky | Environment):
        return value
    if not isinstance(value, str) and not hasattr(value, "__len__"):
        grey = grey_hint(value) if isinstance(value, int | float) and not isinstance(value, bool) else ""
        raise TypeError(
            f"Scene: background must be a colour, a Sky, an Environment or None, got {describe_kind(value)}{grey}"
        )
    return _light("Scene", "background", value)
