"""The box."""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from dataclasses import dataclass
from typing import Any

from .base import PrimitiveSolid
from .cells import NO_ROW, UV, Cell, Face, scaled
from .rounded import larger
from .support import sum_up
from .surface import PlaneSurface
from .validate import vector
from .vector import Vector, VectorLike

_SIZES = (
    "size", "sizes", "half_size", "half_sizes", "extent", "extents", "half_extents", "dimensions", "edge", "edges",
)  # fmt: skip
"""What a box is given by elsewhere."""


@dataclass(frozen=True)
class Box(PrimitiveSolid):
    """low <= (x, y, z) <= high, its edges along the axes.

    Faces: 0 low x, 1 high x, 2 low y, 3 high y, 4 low z, 5 high z.
    uv: the other two coordinates, in the order x, y, z, each scaled over the box to [0, 1].
    Source: the ray tracing notes, "ray and box".
    """

    low: VectorLike = (-1.0, -1.0, -1.0)
    high: VectorLike = (1.0, 1.0, 1.0)

    def __post_init__(self) -> None:
        low, high = vector("Box", "low", self.low), vector("Box", "high", self.high)
        for i in range(3):
            if not low[i] < high[i]:
                raise ValueError(f"Box: high[{i}] must be > low[{i}] = {low[i]}, got {high[i]}")
        object.__setattr__(self, "low", low)
        object.__setattr__(self, "high", high)

    @staticmethod
    def _refused_call(args: Sequence[Any], keywords: Mapping[str, Any]) -> str:
        """Why a call is not taken: a size, or one argument, which may be meant for a size or half of it."""
        sized = [name for name in _SIZES if name in keywords]
        is_alone = len(args) == 1 and "high" not in keywords and args[0] is not None and not isinstance(args[0], str)
        if not is_alone and not sized:
            return ""
        found = f"{sized[0]} alone" if sized else "one argument alone"
        size = "of size (x, y, z) about the origin it is Box((-x/2, -y/2, -z/2), (x/2, y/2, z/2))"
        return f"Box: a box is given by two corners, Box(low, high), got {found}; {size}"

    def tree(self) -> Cell:
        faces, edges = [], [b - a for a, b in zip(self.low, self.high, strict=True)]
        rows = [scaled(_axis(i, edge), self.low) for i, edge in enumerate(edges)]
        for i in range(3):
            first, second = (row for k, row in enumerate(rows) if k != i)
            up, uv = _axis(i, 1.0), UV(False, (first, second, NO_ROW))
            faces.append(Face(PlaneSurface(_axis(i, -1.0), -self.low[i], self.low), 2 * i, uv))
            faces.append(Face(PlaneSurface(up, self.high[i], self.high), 2 * i + 1, uv))
        return Cell(tuple(faces))

    def support(self, direction: Vector) -> float:
        return sum_up(larger(u * a, u * b) for u, a, b in zip(direction, self.low, self.high, strict=True) if u)


def _axis(index: int, length: float) -> Vector:
    x, y, z = (length if i == index else 0.0 for i in range(3))
    return x, y, z
