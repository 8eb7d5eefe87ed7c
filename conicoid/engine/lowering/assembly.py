"""What one body alone consists of, in lists: surfaces, cells, programs and sheets, numbered from 0."""

from __future__ import annotations

import math
from dataclasses import dataclass, field
from typing import Any, NamedTuple

from ...shapes import exact as ex
from ...shapes.cells import All, Any_, Cell, Not, PolygonSheet, SurfaceSheet, Tree
from ..tables import PLANE, POLYGON, SHEET
from .records import Record, rounded_record

UNBOUNDED: tuple[float, ...] = (-math.inf,) * 3 + (math.inf,) * 3
LeafBounds = dict[int, Any]


class Slot(NamedTuple):
    """A surface that is known elsewhere: of which part of a body, and which of its surfaces."""

    kind: int
    part: int
    number: int


@dataclass
class Assembly:
    """Growing lists, one per column of `Tables`."""

    surfaces: list[Record | Slot] = field(default_factory=list)
    exact: list[Any] = field(default_factory=list)
    """The surfaces before they were rounded."""
    # (quadric or -1, side, face), how many planes each has, and these: (surface, side, face)
    cells: list[tuple[int, int, int]] = field(default_factory=list)
    cell_planes: list[int] = field(default_factory=list)
    planes: list[tuple[int, int, int]] = field(default_factory=list)
    programs: list[tuple[int, int]] = field(default_factory=list)  # leaves, gates
    leaves: list[tuple[int, int, int, int]] = field(default_factory=list)
    leaf_bounds: list[Any] = field(default_factory=list)
    gates: list[tuple[int, int, int, int]] = field(default_factory=list)
    sheets: list[tuple[int, int, int, int]] = field(default_factory=list)
    polygons: list[tuple[int, int]] = field(default_factory=list)
    outlines: list[tuple[ex.Row, ...]] = field(default_factory=list)

    def surface(self, surface: Any) -> int:
        """Add a surface; returns its number."""
        self.surfaces.append(surface if isinstance(surface, Slot) else rounded_record(surface))
        self.exact.append(surface)
        return len(self.surfaces) - 1

    def cell(self, cell: Cell) -> int:
        """Add a cell; returns its number. Raises ValueError for a second quadric."""
        quadric, side, number, first = -1, 1, -1, len(self.planes)
        for face in cell.faces:
            surface = self.surface(face.surface)
            if self.surfaces[surface].kind == PLANE:
                self.planes.append((surface, face.inside, face.number))
            elif quadric < 0:
                quadric, side, number = surface, face.inside, face.number
            else:
                raise ValueError("a cell holds at most one quadric: combine two cells instead")
        self.cells.append((quadric, side, number))
        self.cell_planes.append(len(self.planes) - first)
        return len(self.cells) - 1

    def program(self, tree: Tree, bounds: LeafBounds) -> int:
        """Gates and leaves for a Boolean tree, parents before children; `bounds` as in `Faces`."""
        first, first_leaf = len(self.gates), len(self.leaves)
        pending: list[tuple[Tree, int, int]] = [(tree, -1, 1)]  # part, the gate it feeds, sense
        while pending:
            part, gate, sense = pending.pop()
            negated = isinstance(part, Not)
            inner = part.part if isinstance(part, Not) else part
            sense = -sense if negated else sense
            if isinstance(inner, Cell):
                if gate < 0:
                    gate = self._gate(-1, 1, negated)
                    negated = False
                self.leaves.append((self.cell(inner), gate, int(negated), sense))
                self.leaf_bounds.append(bounds.get(id(inner), UNBOUNDED))
                continue
            assert isinstance(inner, (All, Any_)), "negation() leaves no complement of a complement"
            parts = inner.parts
            its_gate = self._gate(gate, len(parts) if isinstance(inner, All) else 1, negated)
            pending.extend((child, its_gate, sense) for child in reversed(parts))
        self._count_at_start(first, first_leaf)
        self.programs.append((len(self.leaves) - first_leaf, len(self.gates) - first))
        return len(self.programs) - 1

    def _gate(self, parent: int, need: int, negated: bool) -> int:
        """Add a gate; returns its number."""
        self.gates.append((parent, need, int(negated), 0))
        return len(self.gates) - 1

    def _count_at_start(self, first_gate: int, first_leaf: int) -> None:
        """How many inputs of each gate are true while every leaf is outside; children come after parents."""
        true = [0] * (len(self.gates) - first_gate)
        for _, gate, negated, _ in self.leaves[first_leaf:]:
            true[gate - first_gate] += negated
        for gate in range(len(self.gates) - 1, first_gate - 1, -1):
            parent, need, negated, _ = self.gates[gate]
            count = true[gate - first_gate]
            self.gates[gate] = (parent, need, negated, count)
            if parent >= 0:
                true[parent - first_gate] += (count >= need) != bool(negated)

    def sheet(self, sheet: SurfaceSheet | PolygonSheet, program: int) -> tuple[int, int]:
        """(kind of entry, index)"""
        if isinstance(sheet, SurfaceSheet):
            self.sheets.append((self.surface(sheet.surface), program, sheet.side, int(sheet.one_sided)))
            return SHEET, len(self.sheets) - 1
        self.polygons.append((self.surface(sheet.plane), program))
        self.outlines.append(sheet.vertices)
        return POLYGON, len(self.polygons) - 1
