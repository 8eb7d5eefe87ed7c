"""What the boundary conditions of a geometry enclose: particles stay in there, so cells are to fill it."""

from __future__ import annotations

import math
from collections.abc import Callable, Iterable

from ...shapes.base import Solid
from ...shapes.boxes import around
from ...shapes.vector import Box
from .geometry import Geometry
from .region import Both, Half, Region, halves

OPEN = "transmission"
"""The boundary condition of a surface that particles go through."""


def enclosed(geometry: Geometry) -> Region | None:
    """The sides of all surfaces with a boundary condition on which the root's cells lie.

    Or what the file says; None where there is no such surface, or where cells lie on both sides of one.
    """
    if geometry.world is not None:
        return geometry.world
    sides: dict[int, bool] = {}
    for cell in geometry.universes[geometry.root]:
        for half in () if cell.region is None else halves(cell.region):
            if geometry.surfaces[half.surface].boundary == OPEN:
                continue
            if sides.setdefault(half.surface, half.positive) != half.positive:
                return None
    parts = tuple(Half(surface, positive) for surface, positive in sides.items())
    return Both(parts) if parts else None


def ends_with(solid: Solid, others: Callable[[], Iterable[Box]]) -> bool:
    """Has a solid an end wherever all the others, around which there are boxes, have one together?"""
    ends = solid.bounds
    if all(map(math.isfinite, (*ends[0], *ends[1]))):
        return True
    known = around(list(others()))
    pairs = zip((*ends[0], *ends[1]), (*known[0], *known[1]), strict=True)
    return all(math.isfinite(end) or not math.isfinite(other) for end, other in pairs)
