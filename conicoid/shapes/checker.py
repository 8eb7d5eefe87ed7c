"""The checker pattern, on uv or in space."""

from __future__ import annotations

from dataclasses import dataclass
from typing import TypeAlias

from .color import Color, checked_color
from .validate import numbers, positive, shown

Scale: TypeAlias = float | tuple[float, float] | tuple[float, float, float]


@dataclass(frozen=True)
class Checker:
    """Squares (or cubes) of two colours: `a` where the sum of floor(coordinate / scale) is even, `b` where it is odd.

    `scale` is the side of a square in uv, or of a cube in world units with `space=True`; two or
    three numbers give each coordinate its own. In space the colour is taken just under the surface
    (scale / 2²⁰ deep, against the normal), so that a wall that lies on a boundary of the cubes has
    the one colour of the matter behind it.
    """

    a: Color = (0.8, 0.8, 0.8)
    b: Color = (0.1, 0.1, 0.1)
    scale: Scale = 1.0
    space: bool = False

    def __post_init__(self) -> None:
        object.__setattr__(self, "a", checked_color("Checker", "a", self.a))
        object.__setattr__(self, "b", checked_color("Checker", "b", self.b))
        object.__setattr__(self, "scale", _checked_scale(self.scale))
        if not isinstance(self.space, bool):
            raise ValueError(f"Checker: space must be true or false, got {shown(self.space)}")

    @property
    def scales(self) -> tuple[float, float, float]:
        """The side along each of three coordinates."""
        if isinstance(self.scale, tuple):
            return (*self.scale, 1.0) if len(self.scale) == 2 else self.scale
        return self.scale, self.scale, self.scale


def _checked_scale(scale: Scale) -> Scale:
    if not hasattr(scale, "__len__") or isinstance(scale, str) or getattr(scale, "ndim", 1) == 0:
        return positive("Checker", "scale", scale)
    count = 2 if len(scale) == 2 else 3
    sides = tuple(
        positive("Checker", f"scale[{i}]", side) for i, side in enumerate(numbers("Checker", "scale", scale, count))
    )
    return (sides[0], sides[1]) if count == 2 else (sides[0], sides[1], sides[2])
