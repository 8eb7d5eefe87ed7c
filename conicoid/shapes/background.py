"""What rays see that hit nothing: one colour, or a sky that changes with height."""

from __future__ import annotations

from dataclasses import dataclass
from typing import Any, TypeAlias

import numpy as np

from .arrays import real_array
from .color import BRIGHT, BYTE, Color, are_bytes, bytes_hint, checked_color, grey_hint
from .validate import nonnegative, number, what
from .vector import FloatArray
from .warned import warn


def _light(owner: str, field: str, value: Any) -> Color:
    """A colour, which may be brighter than white; three bytes are refused, as everything would be white."""
    color = checked_color(owner, field, value, most=float("inf"))
    if not isinstance(color, str) and are_bytes(color):
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
        object.__setattr__(self, "intensity", nonnegative("Sky", "intensity", self.intensity))


@dataclass(frozen=True, eq=False)
class Environment:
    """An image of all directions around a scene, equirectangular, which lights it in light transport.

    pixels: (height, width, 3), linear radiance >= 0. The first row is straight up, +z; along a row the angle about z
        grows from left to right, from the x axis on.
    intensity: everything is so many times as bright.
    rotation: degrees about z by which the image is turned, counter-clockwise as seen from above.

    Whitted's pictures show the mean colours of its top, middle and bottom.
    """

    pixels: Any
    intensity: float = 1.0
    rotation: float = 0.0

    def __post_init__(self) -> None:
        found = real_array("Environment", "pixels", self.pixels, "an array of numbers (height, width, 3)")
        if found.ndim != 3 or found.shape[2] != 3 or found.size == 0:
            raise ValueError(f"Environment: pixels must have shape (height, width, 3), got {found.shape}")
        bad = np.argwhere(~(np.isfinite(found) & (found >= 0)))
        if len(bad):
            place = tuple(int(k) for k in bad[0])
            raise ValueError(f"Environment: pixels{list(place)} must be finite and >= 0, got {found[place]}")
        intensity = nonnegative("Environment", "intensity", self.intensity)
        rotation = number("Environment", "rotation", self.rotation)
        pixels = np.array(found, np.float64)
        pixels.flags.writeable = False
        for field, value in (("pixels", pixels), ("intensity", intensity), ("rotation", rotation)):
            object.__setattr__(self, field, value)

    @property
    def radiance(self) -> FloatArray:
        """(height, width, 3) with intensity and rotation, which is rounded to whole pixels."""
        turned: FloatArray = np.roll(self.pixels, round(self.rotation / 360 * self.pixels.shape[1]), axis=1)
        return self.intensity * turned


Background: TypeAlias = Color | Sky | Environment
DEFAULT_BACKGROUND = Sky((0.62, 0.72, 0.84), (0.94, 0.95, 0.96))


def as_background(value: Any) -> Background | None:
    """A colour, a Sky, or None for the default, checked."""
    if value is None or isinstance(value, Sky | Environment):
        return value
    if not isinstance(value, str) and not hasattr(value, "__len__"):
        grey = grey_hint(value) if isinstance(value, int | float) and not isinstance(value, bool) else ""
        raise TypeError(f"Scene: background must be a colour, a Sky or None, got {what(value)}{grey}")
    return _light("Scene", "background", value)
