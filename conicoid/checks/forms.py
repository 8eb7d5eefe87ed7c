"""Surfaces of a shape as exact symmetric 4 × 4 forms, in any affine coordinates."""

from __future__ import annotations

from collections.abc import Iterator, Sequence
from dataclasses import dataclass
from typing import Any

import numpy as np

from ..shapes import exact as ex
from ..shapes.base import PrimitiveSheet, PrimitiveSolid
from ..shapes.cells import Cell, Not, PolygonSheet, Tree
from ..shapes.motion import STILL
from ..shapes.polyhedron import Polyhedron
from ..shapes.quadric import Quadric
from ..shapes.surface import PlaneSurface, QuadricSurface, Surface
from ..shapes.vector import FloatArray


@dataclass(frozen=True)
class Form:
    """xᵀ second x + 2 first·x + zeroth; `second` is None for a plane."""

    second: ex.Rows | None
    first: ex.Row
    zeroth: ex.Exact

    @property
    def entries(self) -> tuple[ex.Exact, ...]:
        second = self.second or ((ex.ZERO,) * 3,) * 3
        return (*second[0], *second[1], *second[2], *self.first, *self.first, self.zeroth)

    def minus(self, factor: ex.Exact, other: Form) -> Form:
        """self - factor other"""

        def row(a: Sequence[ex.Exact], b: Sequence[ex.Exact]) -> ex.Row:
            return a[0] - factor * b[0], a[1] - factor * b[1], a[2] - factor * b[2]

        second = self.second
        if second is not None and other.second is not None:
            second = row(second[0], other.second[0]), row(second[1], other.second[1]), row(second[2], other.second[2])
        return Form(second, row(self.first, other.first), self.zeroth - factor * other.zeroth)

    def seen_from(self, origin: ex.Row, columns: ex.Rows) -> Form:
        """The form in coordinates z, x = origin + columns z."""
        rows = ex.transpose(columns)
        if self.second is None:
            return Form(None, _applied(rows, self.first), 2 * dot(self.first, origin) + self.zeroth)
        half = _applied(self.second, origin)
        slope = half[0] + self.first[0], half[1] + self.first[1], half[2] + self.first[2]
        zeroth = dot(origin, half) + 2 * dot(self.first, origin) + self.zeroth
        x, y, z = (_applied(self.second, column) for column in rows)
        second = _applied((x, y, z), rows[0]), _applied((x, y, z), rows[1]), _applied((x, y, z), rows[2])
        return Form(second, _applied(rows, slope), zeroth)

    def rounded(self) -> FloatArray:
        """(4, 4) float64."""
        result = np.zeros((4, 4))
        if self.second is not None:
            result[:3, :3] = [[float(c) for c in row] for row in self.second]
        result[:3, 3] = result[3, :3] = [float(c) for c in self.first]
        result[3, 3] = float(self.zeroth)
        return result


def dot(a: Sequence[ex.Exact], b: Sequence[ex.Exact]) -> ex.Exact:
    """a·b to 3000 bits. What cancels leaves its rounding, unlike in `exact.dot`: here all is rounded to float64."""
    return ex.total(x * y for x, y in zip(a, b, strict=True))


def _applied(rows: ex.Rows, point: ex.Row) -> ex.Row:
    return dot(rows[0], point), dot(rows[1], point), dot(rows[2], point)


@dataclass(frozen=True)
class Side:
    """A surface in the shape's own frame; `inside` as of a `Face`, 0 for a sheet's own surface."""

    number: int
    inside: int
    surface: Surface


def cells_of(leaf: Any) -> list[list[Side]]:
    """The faces of every cell of a primitive, in its own frame; a sheet's surface with each cell that clips it."""
    if isinstance(leaf, Polyhedron):
        planes = [PlaneSurface(n, d) for n, d in zip(leaf.normals, leaf.offsets, strict=True)]
        return [[Side(i, 1, plane) for i, plane in enumerate(planes)]]
    if isinstance(leaf, PrimitiveSolid):
        return [_sides(cell) for cell in _cells(leaf.tree())]
    assert isinstance(leaf, PrimitiveSheet)
    sheet = leaf.sheet(STILL)
    assert not isinstance(sheet, PolygonSheet)
    clips = [_sides(cell) for cell in _cells(sheet.clip)] if sheet.clip is not None else [[]]
    return [[Side(-1, 0, sheet.surface), *clip] for clip in clips]


def kinds_of(cells: Sequence[Sequence[Side]]) -> list[list[tuple[Any, ...]]]:
    """What cells are made of: faces, on which side, plane or not."""
    return [[(side.number, side.inside, type(side.surface)) for side in cell] for cell in cells]


def forms_of(leaf: Any, cells: Sequence[Sequence[Side]] | None = None) -> list[dict[int, Form]]:
    """The forms of `cells_of` by number, where the placement puts them. A general quadric needs no principal axes."""
    if isinstance(leaf, Quadric):
        q = [[ex.exact(c) for c in row] for row in leaf.symmetric]
        second = (ex.exact_row(q[0][:3]), ex.exact_row(q[1][:3]), ex.exact_row(q[2][:3]))
        curved = any(c for row in second for c in row)
        return [{0: Form(second if curved else None, (q[0][3], q[1][3], q[2][3]), q[3][3])}]
    placement = leaf.placement
    return [{side.number: form_of(side.surface.moved(placement)) for side in cell} for cell in cells or cells_of(leaf)]


def form_of(surface: Surface) -> Form:
    """The exact polynomial of a surface about the origin."""
    if isinstance(surface, PlaneSurface):
        x, y, z = (c / 2 for c in ex.exact_row(surface.normal))
        return Form(None, (x, y, z), -ex.exact(surface.offset))
    assert isinstance(surface, QuadricSurface)
    xx, yy, zz, xy, xz, yz, x, y, z, constant = surface.coefficients()
    return Form(((xx, xy, xz), (xy, yy, yz), (xz, yz, zz)), (x, y, z), constant)


def _cells(tree: Tree) -> Iterator[Cell]:
    if isinstance(tree, Cell):
        yield tree
        return
    for part in (tree.part,) if isinstance(tree, Not) else tree.parts:
        yield from _cells(part)


def _sides(cell: Cell) -> list[Side]:
    return [Side(face.number, face.inside, face.surface) for face in cell.faces]
