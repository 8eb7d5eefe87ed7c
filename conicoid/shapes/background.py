"""What rays see that hit nothing: one colour, or a sky that changes with height."""

from __future__ import annotations

from dataclasses import dataclass
from typing import Any, TypeAlias

from .color import Color, checked_color
from .validate import what


@dataclass(frozen=True)
class Sky:
    """From `ground` straight down over `horizon` to `zenith` straight up (the z axis).

    Between them linear in the square root of |direction's z|, so that most of the change is near the horizon.
    Without `ground` the lower half looks like the horizon.
    """

    zenith: Color = (0.28, 0.45, 0.75)
    horizon: Color = (0.85, 0.9, 0.95)
    ground: Color | None = None

    def __post_init__(self) -> None:
        for field in ("zenith", "horizon", "ground"):
            value = getattr(self, field)
            if value is not None or field != "ground":
                object.__setattr__(self, field, checked_color("Sky", field, value, most=float("inf")))


Background: TypeAlias = Color | Sky
DEFAULT_BACKGROUND = Sky((0.62, 0.72, 0.84), (0.94, 0.95, 0.96))


def as_background(value: Any) -> Background | None:
    """A colour, a Sky, or None for the default, checked."""
    if value is None or isinstance(value, Sky):
        return value
    if not isinstance(value, str) and not hasattr(value, "__len__"):
        raise TypeError(f"Scene: background must be a colour, a Sky or None, got {what(value)}")
    return checked_color("Scene", "background", value, most=float("inf"))
