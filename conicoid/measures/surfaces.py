"""A solid as its surfaces f <= 0 and a Boolean function of them, read from the scene-wide table.

Coinciding walls are one surface there, so that what is told by a surface's side is told by its number.
"""

from __future__ import annotations

from collections.abc import Iterator, Sequence
from dataclasses import dataclass
from typing import Any

import numpy as np

from ..engine.lowering import lower
from ..engine.tables import BALL, CELL, REGION, SPHERE
from ..engine.tables import PLANE as PLANE_KIND
from ..shapes.base import Shape
from ..shapes.body import Body
from ..shapes.vector import FloatArray

MOST_SURFACES, MOST_LEAVES = 48, 96
ALIKE = 1e-12
"""Directions and coefficients are equal up to so much: what motions leave of rounding, and far less than shows."""


@dataclass(frozen=True)
class Plane:
    """normal·x <= offset; the normal is unit."""

    normal: FloatArray
    offset: float


@dataclass(frozen=True)
class Quadric:
    """x·A x + 2 b·x + c <= 0."""

    a: FloatArray
    b: FloatArray
    c: float

    def within(self, axes: FloatArray, origin: FloatArray) -> Quadric:
        """In coordinates along the columns of `axes` from `origin` on."""
        slope = self.a @ origin
        c = float(origin @ slope + 2 * self.b @ origin + self.c)
        return Quadric(axes.T @ self.a @ axes, axes.T @ (slope + self.b), c)


Surfaces = dict[int, "Plane | Quadric"]


@dataclass(frozen=True)
class Region:
    """Leaves are intersections of sides; gates count them, as in `geometry.program`."""

    surfaces: Surfaces
    leaves: Sequence[tuple[tuple[tuple[int, bool], ...], int, bool]]  # sides (surface, is negative), gate, negated
    gates: Sequence[tuple[int, int, bool]]  # parent, need, negated

    def contains(self, inside: dict[int, bool]) -> bool:
        """Whether the region has the points on these sides; `inside` says of each surface if f <= 0 there."""
        counts = [0] * len(self.gates)
        for sides, gate, negated in self.leaves:
            counts[gate] += all(inside[surface] == negative for surface, negative in sides) != negated
        value = False
        for gate in reversed(range(len(self.gates))):
            parent, need, negated = self.gates[gate]
            value = (counts[gate] >= need) != negated
            if parent >= 0:
                counts[parent] += value
        return value


def region_of(shape: Shape, origin: FloatArray) -> Region | None:
    """The region of a solid, coordinates counted from `origin` on; None for what has too many parts, and for sheets."""
    if shape.is_sheet or _leaves(shape) > MOST_LEAVES:
        return None
    tables = lower([Body(shape)]).tables
    if len(tables.entry_kind) != 1 or len(tables.surface_kind) > MOST_SURFACES:
        return None
    surfaces = {number: _surface(tables, number, origin) for number in range(len(tables.surface_kind))}
    kind, index = int(tables.entry_kind[0]), int(tables.entry_index[0])
    if kind == BALL:
        return Region(surfaces, [(((index, True),), 0, False)], [(-1, 1, False)])
    if kind == CELL:
        return Region(surfaces, [(tuple(_sides(tables, index)), 0, False)], [(-1, 1, False)])
    assert kind == REGION
    leaves = zip(tables.leaf_cell, tables.leaf_gate, tables.leaf_negated, strict=True)
    gates = zip(tables.gate_parent, tables.gate_need, tables.gate_negated, strict=True)
    return Region(
        surfaces,
        [(tuple(_sides(tables, int(cell))), int(gate), bool(negated)) for cell, gate, negated in leaves],
        [(int(parent), int(need), bool(negated)) for parent, need, negated in gates],
    )


def _leaves(shape: Shape) -> int:
    from .frames import parts_of

    count = 0
    for _ in parts_of(shape):
        count += 1
        if count > MOST_LEAVES:
            break
    return count


def _sides(tables: Any, cell: int) -> Iterator[tuple[int, bool]]:
    if tables.cell_quadric[cell] >= 0:
        yield int(tables.cell_quadric[cell]), bool(tables.cell_face[cell] > 0)
    for row in range(int(tables.cell_first[cell]), int(tables.cell_first[cell + 1])):
        yield int(tables.plane_surface[row]), bool(tables.plane_face[row] > 0)


def _surface(tables: Any, number: int, origin: FloatArray) -> Plane | Quadric:
    kind, row = int(tables.surface_kind[number]), int(tables.surface_row[number])
    if kind == PLANE_KIND:
        normal, height, anchor = np.split(tables.planes[row], [3, 4])[0], tables.planes[row][3], tables.planes[row][4:7]
        length = float(np.linalg.norm(normal))
        return Plane(normal / length, (float(normal @ (anchor - origin)) - float(height)) / length)
    if kind == SPHERE:
        center, radius = tables.spheres[row][:3], float(tables.spheres[row][3])
        return Quadric(np.eye(3), np.zeros(3), -radius * radius).within(np.eye(3), origin - center)
    record = tables.whole_quadrics([row])[0]
    anchor, rows, squares = record[:3], record[3:12].reshape(3, 3), record[12:15]
    linear, constant = record[15:18], float(record[18])
    own = Quadric(rows.T @ np.diag(squares) @ rows, rows.T @ linear, -constant)
    return own.within(np.eye(3), origin - anchor)
