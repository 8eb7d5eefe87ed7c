"""Prismatoids: convex solids of flat faces whose corners lie in two planes z = low and z = high."""

from __future__ import annotations

from abc import abstractmethod
from collections.abc import Sequence
from dataclasses import dataclass
from typing import Any, NamedTuple

from . import exact as ex
from .base import PrimitiveSolid
from .cells import NO_ROW, UV, Cell, Face
from .planar import corners_support
from .surface import PlaneSurface
from .validate import interval, shown
from .vector import Interval, Vector


class Side(NamedTuple):
    """(a, b)·(x, y) <= low at the lower plane, <= high at the upper, and in proportion between them."""

    a: Any
    b: Any
    low: Any
    high: Any
    uv: UV


class Level(NamedTuple):
    """The outline in one of the two planes: its corners (x, y), the map of its face; is it a face, or but an edge?"""

    corners: Sequence[tuple[Any, Any]]
    uv: UV
    is_face: bool


@dataclass(frozen=True)
class Prismatoid(PrimitiveSolid, abstract=True):
    """Sides of fixed directions whose distances change in proportion with z, and the two ends across z.

    Faces: i is side i, then the lower end and the upper, where they are more than an edge or a corner.
    """

    @property
    @abstractmethod
    def heights(self) -> tuple[Any, Any]:
        """z of the lower and of the upper plane, exact."""

    @abstractmethod
    def flanks(self) -> list[Side]:
        """The sides in the order of their numbers."""

    @abstractmethod
    def levels(self) -> tuple[Level, Level]:
        """The lower end and the upper."""

    def tree(self) -> Cell:
        low, high = self.heights
        ends, sides = self.levels(), self.flanks()
        corners = self._corners()
        faces = []
        for number, side in enumerate(sides):
            slope = (side.high - side.low) / (high - low)
            surface = PlaneSurface((side.a, side.b, -slope), side.low - slope * low, corners[0])
            faces.append(Face(surface, number, side.uv))
        for k, (end, z, sense) in enumerate(zip(ends, (low, high), (-1.0, 1.0), strict=True)):
            if end.is_face:
                faces.append(Face(PlaneSurface((0.0, 0.0, sense), sense * z, (0.0, 0.0, z)), len(sides) + k, end.uv))
        return Cell(tuple(faces))

    def _corners(self) -> list[ex.Row]:
        found = []
        for end, z in zip(self.levels(), self.heights, strict=True):
            found += [ex.exact_row((x, y, z)) for x, y in end.corners]
        return found

    def support(self, direction: Vector) -> float:
        return corners_support(self._corners(), direction)


def plain_map(u: tuple[Any, ...], v: tuple[Any, ...]) -> UV:
    """uv from the two rows (a, b, c, d) of a x + b y + c z + d."""
    return UV(False, (rounded_row(u), rounded_row(v), NO_ROW))


def rounded_row(row: tuple[Any, ...]) -> tuple[float, float, float, float]:
    """A row of exact numbers as floats."""
    a, b, c, d = (ex.rounded(ex.exact(number)) for number in row)
    return a, b, c, d


def finite_range(owner: str, value: Any) -> Interval:
    """`value` as a z_range of two finite numbers."""
    found = interval(owner, "z_range", value)
    if found is None or any(abs(end) == float("inf") for end in found):
        raise ValueError(f"{owner}: z_range must be two finite numbers, got {shown(value)}")
    return found
