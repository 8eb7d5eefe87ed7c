"""Backgrounds, for rays that hit nothing: one colour, a sky that changes with height, or an image of all directions."""

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
    """Return a colour that may be brighter than white; refuse three bytes, as they would make everything white."""
    color = check_color(owner, field, value, most=float("inf"))
    if not isinstance(color, str) and look_like_bytes(color):
        # Three whole numbers up to 255 are most likely bytes.
        brighter = "for light brighter than white use co.Sky(zenith, horizon, ground, intensity)"
        raise ValueError(
            f"{owner}: {field} must be linear light, where 1 is white, got {color}; {bytes_hint(color)}; {brighter}"
        )
    if not isinstance(color, str) and BRIGHT < max(color) <= BYTE:
        warn(
            f"{owner}: {field} {color} is linear light, {max(color):g} times white; co.Sky(..., intensity=...) says so"
        )
    return color


@dataclass(frozen=True)
class Sky:
    """A sky from `ground` straight down over `horizon` to `zenith` straight up (the z axis).

    Between them it is linear in the square root of |direction's z|, so that most of the change is near the horizon.

    Parameters
    ----------
    zenith, horizon : Color
        Colours straight up and at the horizon.
    ground : Color, optional
        Colour straight down. Without it the lower half has the colour of the horizon.
    intensity : float
        Factor of all colours, >= 0.
    """

    zenith: Color = (0.28, 0.45, 0.75)
    horizon: Color = (0.85, 0.9, 0.95)
    ground: Color | None = None
    intensity: float = 1.0

    def __post_init__(self) -> None:
        for field in ("zenith", "horizon", "ground"):
            value = getattr(self, field)
            # Only the ground may be missing.
            if value is not None or field != "ground":
                object.__setattr__(self, field, _light("Sky", field, value))
        object.__setattr__(self, "intensity", check_nonnegative("Sky", "intensity", self.intensity))


def _read(path: str | os.PathLike[str]) -> Any:
    """Return the linear light of an image file."""
    try:
        return read_pixels(path).linear(is_data=False)
    except ValueError as error:
        raise ValueError(f"Environment: pixels: file {error}") from None


@dataclass(frozen=True, eq=False)
class Environment:
    """An image of all directions around a scene, equirectangular, that lights it in light transport.

    Whitted's pictures show the mean colours of its top, middle and bottom.

    Parameters
    ----------
    pixels : array_like or path
        (height, width, 3): linear radiance >= 0, bytes (uint8) of sRGB, or an `Image`. Or the name of a file, an .exr
        of linear light, or a .png, .jpg or .webp, which is read at once. A scene file may name those in its own
        folder, or below. The first row is straight up, +z; along a row the angle about z grows from left to right,
        starting at the x axis.
    intensity : float
        Factor of the radiance, >= 0.
    rotation : float
        Degrees about z that turn the image, counter-clockwise as seen from above.

    Raises
    ------
    ValueError
        If a file cannot be read, or pixels have another shape or are not finite and >= 0.
    """

    pixels: ImagePath | Any
    intensity: float = 1.0
    rotation: float = 0.0
    file: ClassVar[ImagePath | None] = None
    """The file of the pixels, if they came from one."""

    def __post_init__(self) -> None:
        if isinstance(self.pixels, str | os.PathLike):
            object.__setattr__(self, "file", ImagePath(os.path.abspath(checked_path("Environment", self.pixels))))
            radiance: Any = _read(self.pixels)
        else:
            radiance = image_array("Environment", "pixels", self.pixels)
        radiance = srgb_decode(radiance / 255) if radiance.dtype == np.uint8 else radiance
        if radiance.ndim != 3 or radiance.shape[2] != 3 or radiance.size == 0:
            raise ValueError(f"Environment: pixels must have shape (height, width, 3), got {radiance.shape}")
        bad = np.argwhere(~(np.isfinite(radiance) & (radiance >= 0)))
        if len(bad):
            place = tuple(int(k) for k in bad[0])
            raise ValueError(f"Environment: pixels{list(place)} must be finite and >= 0, got {radiance[place]}")
        intensity = check_nonnegative("Environment", "intensity", self.intensity)
        rotation = check_degrees("Environment", "rotation", self.rotation)
        pixels = np.array(radiance, np.float64)
        # Frozen: equality and hashes depend on the pixels.
        pixels.flags.writeable = False
        for field, value in (("pixels", pixels), ("intensity", intensity), ("rotation", rotation)):
            object.__setattr__(self, field, value)

    @classmethod
    def of_file(cls, path: str | os.PathLike[str], intensity: float = 1.0, rotation: float = 0.0) -> Environment:
        """Read an image of all directions from a file, an .exr of linear light, or a .png, .jpg or .webp.

        Parameters
        ----------
        path : str or os.PathLike
            The file.
        intensity, rotation : float
            As in `Environment`.

        Returns
        -------
        Environment

        Raises
        ------
        ValueError
            If the file is missing, no picture, or damaged.
        """
        return cls(ImagePath(checked_path("Environment", path)), intensity, rotation)

    def __eq__(self, other: object) -> bool:
        return (
            isinstance(other, Environment) and self._key() == other._key() and np.array_equal(self.pixels, other.pixels)
        )

    def __hash__(self) -> int:
        return hash(self._key())

    def _key(self) -> tuple[Any, ...]:
        """Return the values that equality and hashes use; the sum stands for the pixels."""
        pixels: Any = self.pixels
        # A cheap key: equality also compares all pixels.
        return pixels.shape, float(pixels.sum()), self.intensity, self.rotation

    @property
    def radiance(self) -> FloatArray:
        """Radiance (height, width, 3) with intensity and rotation; the rotation is rounded to whole pixels."""
        pixels: Any = self.pixels
        rotated: FloatArray = np.roll(pixels, round(self.rotation / 360 * pixels.shape[1]), axis=1)
        return self.intensity * rotated


Background: TypeAlias = Color | Sky | Environment
DEFAULT_BACKGROUND = Sky((0.62, 0.72, 0.84), (0.94, 0.95, 0.96))
"""The sky of scenes without a background."""


def as_background(value: Any) -> Background | None:
    """Return a checked background: a colour, a Sky, an Environment, or None for the default."""
    if value is None or isinstance(value, Sky | Environment):
        return value
    if not isinstance(value, str) and not hasattr(value, "__len__"):
        grey = grey_hint(value) if isinstance(value, int | float) and not isinstance(value, bool) else ""
        raise TypeError(
            f"Scene: background must be a colour, a Sky, an Environment or None, got {describe_kind(value)}{grey}"
        )
    return _light("Scene", "background", value)
