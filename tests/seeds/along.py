"""One ray at one shape, as plain numbers."""

from __future__ import annotations

import math
from typing import Any

import conicoid as co

CLOSE = {"rel": 1e-14, "abs": 1e-14}


def first(shape: Any, origin: Any, direction: Any, **limits: Any) -> Any:
    """The first hit, scalars."""
    return co.Scene([shape]).first_hit(origin, direction, **limits)


def spans(shape: Any, origin: Any, direction: Any) -> list[tuple[float, float]]:
    """Where the whole line is inside, in order."""
    found = co.Scene([shape]).spans(origin, direction, t_min=-math.inf)
    return [(float(a), float(b)) for a, b in zip(found.t_enter, found.t_exit, strict=True)]


def flat(pairs: list[tuple[float, float]]) -> list[float]:
    return [t for pair in pairs for t in pair]
