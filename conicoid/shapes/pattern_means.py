"""One value for a pattern, where no pattern can be shown."""

from __future__ import annotations

from collections.abc import Iterable
from typing import Any

from .checker import Checker
from .color import linear_rgb
from .texture import Brick, Gradient, ImageTexture, Noise, Wood


def mean_color(pattern: Any) -> tuple[float, float, float]:
    """One colour for a pattern."""
    if isinstance(pattern, ImageTexture):
        return pattern.mean
    if isinstance(pattern, Brick):
        return mean_color(pattern.bricks)
    if isinstance(pattern, Checker):
        return linear_rgb(pattern.a)
    ends: Iterable[Any] = ()
    if isinstance(pattern, Gradient | Noise):
        ends = pattern.a, pattern.b
    elif isinstance(pattern, Wood):
        ends = pattern.early, pattern.late
    else:
        return linear_rgb(pattern)
    (ar, ag, ab), (br, bg, bb) = map(linear_rgb, ends)
    return (ar + br) / 2, (ag + bg) / 2, (ab + bb) / 2


def mean_grey(pattern: Any) -> float:
    """One number for a pattern of numbers, in [0, 1]."""
    return min(1.0, max(0.0, sum(mean_color(pattern)) / 3))
