"""Cells, programs, sheets and entries, collected in lists and turned into arrays once."""

from __future__ import annotations

import math
from collections.abc import Sequence
from dataclasses import dataclass, field
from typing import Any

import numpy as np

from ...shapes import exact as ex
from ...shapes.cells import All, Any_, Cell, Not, PolygonSheet, SurfaceSheet, Tree
from ...shapes.material import Material
from ...shapes.surface import PlaneSurface
from ...shapes.vector import Box
from ..tables import BALL, CELL, POLYGON, REGION, SHEET, SPHERE, Floats, Ints, Signs, Tables
from .limits import with_limits
from .surfaces import SurfaceArrays, SurfaceTable, end_to_end

UNBOUNDED = np.array([-math.inf] * 3 + [math.inf] * 3)
LeafBounds = dict[int, Floats]


@dataclass
class Assembly:
    """Growing lists, one per column of `Tables`. Surfaces are referred to by temporary numbers."""

    surfaces: SurfaceTable = field(default_factory=SurfaceTable)
    # (quadric or None, side, face) and its planes (surface, side, face)
    cells: list[tuple[int | None, int, int]] = field(default_factory=list)
    cell_first: list[int] = field(default_factory=lambda: [0])
    planes: list[tuple[int, int, int]] = field(default_factory=list)
    program_leaf: list[int] = field(default_factory=lambda: [0])
    program_gate: list[int] = field(default_factory=lambda: [0])
    leaves: list[tuple[int, int, int, int]] = field(default_factory=list)
    leaf_bounds: list[Floats] = field(default_factory=list)
    gates: list[tuple[int, int, int, int]] = field(default_factory=list)
    sheets: list[tuple[int, int, int, int]] = field(default_factory=list)
    polygons: list[tuple[int, int]] = field(default_factory=list)
    polygon_first: list[int] = field(default_factory=lambda: [0])
    outlines: list[tuple[ex.Row, ...]] = field(default_factory=list)

    def cell(self, cell: Cell) -> int:
        """Add a cell; returns its number. Raises ValueError for a second quadric."""
        quadric, side, number = None, 1, -1
        for face in cell.faces:
            surface = self.surfaces.add(face.surface)
            if isinstance(face.surface, PlaneSurface):
                self.planes.append((surface, face.inside, face.number))
            elif quadric is None:
                quadric, side, number = surface, face.inside, face.number
            else:
                raise ValueError("a cell holds at most one quadric: combine two cells instead")
        self.cells.append((quadric, side, number))
        self.cell_first.append(len(self.planes))
        return len(self.cells) - 1

    def append(self, other: Assembly) -> None:
        """Put another's columns after one's own; its numbers are counted on from there."""
        surface, plane, cell = self.surfaces.append(other.surfaces), len(self.planes), len(self.cells)
        gate, leaf, corner = len(self.gates), len(self.leaves), self.polygon_first[-1]
        program = len(self.program_leaf) - 1
        self.cells.extend((None if q is None else q + surface, side, face) for q, side, face in other.cells)
        self.planes.extend((p + surface, side, face) for p, side, face in other.planes)
        self.cell_first.extend(first + plane for first in other.cell_first[1:])
        self.leaves.extend((c + cell, g + gate, negated, sense) for c, g, negated, sense in other.leaves)
        self.leaf_bounds.extend(other.leaf_bounds)
        self.gates.extend((p if p < 0 else p + gate, need, negated, start) for p, need, negated, start in other.gates)
        self.program_leaf.extend(first + leaf for first in other.program_leaf[1:])
        self.program_gate.extend(first + gate for first in other.program_gate[1:])
        self.sheets.extend((s + surface, p if p < 0 else p + program, side, one) for s, p, side, one in other.sheets)
        self.polygons.extend((s + surface, p if p < 0 else p + program) for s, p in other.polygons)
        self.polygon_first.extend(first + corner for first in other.polygon_first[1:])
        self.outlines.extend(other.outlines)

    def program(self, tree: Tree, bounds: LeafBounds) -> int:
        """Gates and leaves for a Boolean tree, parents before children; `bounds` as in `Faces`."""
        first = len(self.gates)
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
        self._count_at_start(first, self.program_leaf[-1])
        self.program_leaf.append(len(self.leaves))
        self.program_gate.append(len(self.gates))
        return len(self.program_leaf) - 2

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
            self.sheets.append((self.surfaces.add(sheet.surface), program, sheet.side, int(sheet.one_sided)))
            return SHEET, len(self.sheets) - 1
        self.polygons.append((self.surfaces.add(sheet.plane), program))
        self.outlines.append(sheet.vertices)
        self.polygon_first.append(self.polygon_first[-1] + len(sheet.vertices))
        return POLYGON, len(self.polygons) - 1


@dataclass
class Entries:
    """The leaves of the scene's tree, in order of their bodies, and what bodies need besides."""

    kinds: list[Signs] = field(default_factory=list)
    indices: list[Ints] = field(default_factory=list)
    bodies: list[Ints] = field(default_factory=list)
    boxes: list[Floats] = field(default_factory=list)
    body_face: list[Ints] = field(default_factory=list)
    faces: list[Floats] = field(default_factory=list)
    paints: dict[int, Material] = field(default_factory=dict)  # by row of face
    ball_frames: list[Floats] = field(default_factory=list)
    face_count: int = 0
    body_count: int = 0

    def add(self, kind: int, index: int, box: Box, faces: list[Floats], paints: dict[int, Material]) -> None:
        """One body with the uv maps of its faces, and the materials of those that have their own."""
        self.paints.update((self.face_count + number, material) for number, material in paints.items())
        self.add_many(kind, np.array([index], np.int32), np.concatenate(box)[None, :], self.face_count)
        self.faces.extend(faces)
        self.face_count += len(faces)

    def add_many(self, kind: int, indices: Ints, boxes: Floats, first_face: int) -> None:
        """Many bodies of one kind, a row of boxes each."""
        count = len(indices)
        self.kinds.append(np.full(count, kind, np.int8))
        self.indices.append(indices)
        self.bodies.append(np.arange(self.body_count, self.body_count + count, dtype=np.int32))
        self.boxes.append(boxes)
        self.body_face.append(np.full(count, first_face, np.int32))
        self.body_count += count

    def resolved(self, ball_ids: Ints) -> list[Ints]:
        """The indices, those of bulk balls by the ids of their surfaces."""
        return [
            ball_ids[-1 - int(index[0]) : len(index) - 1 - int(index[0])] if kind[0] == BALL else index
            for kind, index in zip(self.kinds, self.indices, strict=True)
            if len(index)
        ]


def finished_tables(assembly: Assembly, entries: Entries) -> tuple[Tables, Floats, SurfaceArrays]:
    """The finished arrays (without a tree), the entries' boxes (n, 6), the surfaces with what rounding took."""
    table = assembly.surfaces.finish()
    single = len(assembly.surfaces.kinds)

    def resolve(temporary: list[int]) -> tuple[Ints, Signs]:
        """(ids, senses) of surfaces in the finished table."""
        numbers = np.array(temporary, dtype=np.int64)
        at = np.where(numbers >= 0, numbers, single - 1 - numbers)
        return table.ids[at].astype(np.int32), table.senses[at]

    cell_quadric, cell_sense = resolve([q if q is not None else 0 for q, _, _ in assembly.cells])
    cell_side = np.array([s for _, s, _ in assembly.cells], np.int8) * cell_sense
    cell_quadric[[q is None for q, _, _ in assembly.cells]] = -1
    plane_surface, plane_sense = resolve([p for p, _, _ in assembly.planes])
    sheet_surface, sheet_sense = resolve([s for s, _, _, _ in assembly.sheets])
    polygon_surface, polygon_sense = resolve([p for p, _ in assembly.polygons])
    leaf_cells = [leaf[0] for leaf in assembly.leaves]
    tables = Tables(
        surface_kind=table.kind,
        surface_row=table.row,
        planes=table.planes,
        spheres=table.spheres,
        quadrics=table.quadrics,
        cell_quadric=cell_quadric,
        cell_side=cell_side,
        cell_face=_column(assembly.cells, 2),
        cell_first=np.array(assembly.cell_first, np.int32),
        plane_surface=plane_surface,
        plane_side=np.array([s for _, s, _ in assembly.planes], np.int8) * plane_sense,
        plane_face=_column(assembly.planes, 2),
        program_leaf=np.array(assembly.program_leaf, np.int32),
        program_gate=np.array(assembly.program_gate, np.int32),
        leaf_cell=np.array(leaf_cells, np.int32),
        leaf_gate=_column(assembly.leaves, 1),
        leaf_negated=_column(assembly.leaves, 2).astype(np.int8),
        leaf_sense=_column(assembly.leaves, 3).astype(np.int8),
        leaf_bounds=np.array(assembly.leaf_bounds, dtype=np.float64).reshape(-1, 6),
        gate_parent=_column(assembly.gates, 0),
        gate_need=_column(assembly.gates, 1),
        gate_negated=_column(assembly.gates, 2).astype(np.int8),
        gate_start=_column(assembly.gates, 3),
        sheet_surface=sheet_surface,
        sheet_program=_column(assembly.sheets, 1),
        sheet_side=np.array([s for _, _, s, _ in assembly.sheets], np.int8) * sheet_sense,
        sheet_one_sided=_column(assembly.sheets, 3).astype(np.int8),
        polygon_surface=polygon_surface,
        polygon_side=polygon_sense,
        polygon_first=np.array(assembly.polygon_first, np.int32),
        polygon_program=_column(assembly.polygons, 1),
        vertices=np.array([[float(x) for x in p] for line in assembly.outlines for p in line]).reshape(-1, 3),
        entry_kind=end_to_end([np.zeros(0, np.int8), *entries.kinds]),
        entry_index=end_to_end([np.zeros(0, np.int32), *entries.resolved(table.ids[single:])]),
        entry_body=end_to_end([np.zeros(0, np.int32), *entries.bodies]),
        body_face=end_to_end([np.zeros(0, np.int32), *entries.body_face]),
        ball_frames=np.array(entries.ball_frames, dtype=np.float64).reshape(-1, 9),
        face_uv=np.array(entries.faces, dtype=np.float64).reshape(-1, 13),
        **_to_come(),
    )
    boxes = end_to_end([np.zeros((0, 6)), *entries.boxes])
    return with_limits(_balls_direct(tables), boxes, table.rest), boxes, table


def _to_come() -> dict[str, Any]:
    """What later steps fill in: the tree and the limits."""
    return dict(
        node_boxes=np.zeros((0, 6, 8)),
        node_children=np.zeros((0, 8), np.int32),
        tree_order=np.zeros(0, np.int32),
        tree_root=np.zeros(0, np.int32),
        roots=np.zeros(0, np.int32),
        tree_depth=np.zeros(1, np.int32),
        leaf_items=np.zeros(0),
        extent=np.zeros(5),
        plane_limits=np.zeros((0, 2)),
        quadric_limits=np.zeros((0, 2)),
        cell_limits=np.zeros((0, 2)),
        program_limits=np.zeros((0, 2)),
        sheet_limits=np.zeros((0, 2)),
        polygon_limits=np.zeros((0, 2)),
    )


def _balls_direct(tables: Tables) -> Tables:
    """Cells that are nothing but a sphere become balls, which are traced without their cell."""
    at = np.flatnonzero(tables.entry_kind == CELL)
    if not len(at):
        return tables
    kind, index = tables.entry_kind.copy(), tables.entry_index.copy()
    cells = index[at]
    quadric = tables.cell_quadric[cells]
    ball = (quadric >= 0) & (tables.cell_side[cells] > 0) & (tables.cell_face[cells] == 0)
    ball &= np.diff(tables.cell_first)[cells] == 0
    ball[ball] = tables.surface_kind[quadric[ball]] == SPHERE
    kind[at[ball]], index[at[ball]] = BALL, quadric[ball]
    return tables._replace(entry_kind=kind, entry_index=index)


def _column(rows: Sequence[tuple[Any, ...]], column: int) -> Ints:
    """A column of rows as int32."""
    return np.array([row[column] for row in rows], dtype=np.int32)


__all__ = ["REGION", "Assembly", "Entries", "finished_tables"]
