"""The parallelepiped: a corner and three edges."""

from __future__ import annotations

from dataclasses import dataclass
from itertools import product
from typing import Any

from . import exact as ex
from .base import PrimitiveSolid
from .cells import NO_ROW, UV, Cell, Face
from .planar import corners_support
from .prismatoid import rounded_row
from .surface import PlaneSurface
from .validate import vector
from .vector import Vector, VectorLike


@dataclass(frozen=True)
class Parallelepiped(PrimitiveSolid):
    """corner + i a + j b + k c with i, j, k from 0 to 1: a box with slanted edges, its volume |a·(b × c)|.

    a, b, c: the three edges that leave the corner, in any order and sense, not in one plane. Decided exactly.

    Faces: 0 i = 0, 1 i = 1, 2 j = 0, 3 j = 1, 4 k = 0, 5 k = 1. uv: the other two of i, j, k, in this order.
    Source: MCNP's macrobody BOX, Geant4's Para.
    """

    corner: VectorLike
    a: VectorLike
    b: VectorLike
    c: VectorLike

    def __post_init__(self) -> None:
        for name in ("corner", "a", "b", "c"):
            object.__setattr__(self, name, vector("Parallelepiped", name, getattr(self, name)))
        if not _product(_cross(*self._edges[:2]), self._edges[2]):
            raise ValueError("Parallelepiped: a, b and c must not lie in one plane")

    @property
    def _edges(self) -> list[tuple[Any, ...]]:
        return [tuple(ex.rational(x) for x in edge) for edge in (self.a, self.b, self.c)]

    def tree(self) -> Cell:
        a, b, c = self._edges
        volume = _product(_cross(a, b), c)
        corner = tuple(ex.rational(x) for x in self.corner)
        opposite = ex.exact_row(x + i + j + k for x, i, j, k in zip(corner, a, b, c, strict=True))
        rows = []
        for normal in (_cross(b, c), _cross(c, a), _cross(a, b)):
            own = tuple(x / volume for x in normal)
            rows.append((*own, -_product(own, corner)))
        faces, maps = [], [rounded_row(row) for row in rows]
        for i, (x, y, z, shift) in enumerate(rows):
            first, second = (row for k, row in enumerate(maps) if k != i)
            uv = UV(False, (first, second, NO_ROW))
            faces.append(Face(PlaneSurface((-x, -y, -z), shift, ex.exact_row(corner)), 2 * i, uv))
            faces.append(Face(PlaneSurface((x, y, z), 1 - shift, opposite), 2 * i + 1, uv))
        return Cell(tuple(faces))

    def support(self, direction: Vector) -> float:
        a, b, c = self._edges
        corners = []
        for i, j, k in product((0, 1), repeat=3):
            point = (ex.rational(x) + i * p + j * q + k * r for x, p, q, r in zip(self.corner, a, b, c, strict=True))
            corners.append(ex.exact_row(point))
        return corners_support(corners, direction)


def _cross(a: tuple[Any, ...], b: tuple[Any, ...]) -> tuple[Any, Any, Any]:
    return a[1] * b[2] - a[2] * b[1], a[2] * b[0] - a[0] * b[2], a[0] * b[1] - a[1] * b[0]


def _product(a: tuple[Any, ...], b: tuple[Any, ...]) -> Any:
    return a[0] * b[0] + a[1] * b[1] + a[2] * b[2]
