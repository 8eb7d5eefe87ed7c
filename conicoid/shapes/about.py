"""Motions about a point other than the origin: three steps, exact as all motions are."""

from __future__ import annotations

from collections.abc import Callable
from typing import Any

from .motion import Motion
from .validate import vector


def about(owner: str, motion: Motion, point: Any, step: Callable[[Motion], Motion]) -> Motion:
    """A motion followed by a step about a point: from the point to the origin, the step, and back. None: the origin."""
    if point is None:
        return step(motion)
    x, y, z = vector(owner, "about", point)
    return step(motion.translate((0.0 - x, 0.0 - y, 0.0 - z))).translate((x, y, z))
