"""What bodies are made of, as the tables of a prepared scene say it: which a window may cut, and what holds a place."""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import dataclass
from typing import TYPE_CHECKING, Any

import numpy as np
import numpy.typing as npt

from ..engine.faces import cell_faces, plane_faces, sides_of
from ..engine.programs import cells_of_leaves, gates_of_program, leaves_of_program, row_of_leaf
from ..engine.tables import BALL, CELL, POLYGON, REGION, SHEET
from ..shapes.vector import FloatArray
from .window import Window

if TYPE_CHECKING:
    from ..engine.prepared import Prepared

Signs = Callable[[int], Any]
"""The sign of a surface, -1, 0 or 1, at each of some places."""
Mask = npt.NDArray[np.bool_]
_WIDER = 1e-9


@dataclass(frozen=True)
class Faces:
    """The surfaces of an entry, and for each of its cells those that bound it, with the side that is inside."""

    cells: tuple[tuple[tuple[int, int], ...], ...]

    @property
    def surfaces(self) -> set[int]:
        """All of them."""
        return {surface for cell in self.cells for surface, _ in cell}


class Bodies:
    """The entries of a scene."""

    def __init__(self, scene: Prepared) -> None:
        self.scene, self.tables = scene, scene.lowered.tables
        self._faces: dict[int, Faces] = {}

    def cut_by(self, window: Window) -> list[int]:
        """The solid entries, and sheets, whose boxes the window may meet."""
        tables, boxes = self.tables, self.scene.lowered.boxes
        corners = np.stack([window.corner + s * window.u + t * window.v for s in (0, 1) for t in (0, 1)])
        low, high = corners.min(axis=0), corners.max(axis=0)
        slack = _WIDER * (np.abs(corners).max() + np.abs(high - low).max())
        meets = ((boxes[:, :3] <= high + slack) & (boxes[:, 3:] >= low - slack)).all(axis=1)
        normal = np.cross(window.u, window.v)
        normal = normal / np.linalg.norm(normal)
        with np.errstate(invalid="ignore"):
            middle, half = (boxes[:, 3:] + boxes[:, :3]) / 2, (boxes[:, 3:] - boxes[:, :3]) / 2
            away = np.abs((middle - window.corner) @ normal) - half @ np.abs(normal)
        meets &= ~(away > slack)
        return np.flatnonzero(meets & np.isin(tables.entry_kind, (BALL, CELL, REGION, SHEET, POLYGON))).tolist()

    def place_box(self, entry: int, window: Window) -> tuple[float, float, float, float]:
        """(left, bottom, right, top) of the box of an entry in the window, about its middle; it may be larger."""
        box = self.scene.lowered.boxes[entry]
        across, up = window.size
        half = np.array([across, up]) / 2
        if not np.isfinite(box).all():
            return -half[0], -half[1], half[0], half[1]
        middle, reach = (box[3:] + box[:3]) / 2, (box[3:] - box[:3]) / 2
        sides = np.stack([window.u / across, window.v / up])
        place = sides @ (middle - window.corner) - half
        size = np.abs(sides) @ reach
        size = size + _WIDER * (size + np.abs(place) + half)
        left, bottom = np.maximum(place - size, -half).tolist()
        right, top = np.minimum(place + size, half).tolist()
        return left, bottom, right, top

    def number(self, entry: int) -> int:
        """Its body."""
        return entry

    def is_sheet(self, entry: int) -> bool:
        return int(self.tables.entry_kind[entry]) in (SHEET, POLYGON)

    def faces(self, entry: int) -> Faces:
        """What bounds an entry; of a sheet its own surface comes first, as a cell of one."""
        known = self._faces.get(entry)
        if known is None:
            known = self._faces[entry] = Faces(tuple(self._cells(entry)))
        return known

    def _cells(self, entry: int) -> list[tuple[tuple[int, int], ...]]:
        tables = self.tables
        kind, index = int(tables.entry_kind[entry]), int(tables.entry_index[entry])
        if kind == BALL:
            return [((index, 1),)]
        if kind == CELL:
            return [self._cell(index)]
        if kind in (SHEET, POLYGON):
            program, surface = self._sheet(entry)
            own = ((surface, 1),)
            return [own, *(self._leaves(program) if program >= 0 else [])]
        return self._leaves(index)

    def _sheet(self, entry: int) -> tuple[int, int]:
        """(what clips a sheet or -1, its surface)"""
        tables, index = self.tables, int(self.tables.entry_index[entry])
        if int(tables.entry_kind[entry]) == POLYGON:
            return int(tables.polygon_program[index]), int(tables.polygon_surface[index])
        return int(tables.sheet_program[index]), int(tables.sheet_surface[index])

    def edges_cut(self, entry: int, window: Window) -> FloatArray | None:
        """Places (n, 2) where the edges of a polygon go through the plane of a window; None for what is none."""
        tables, index = self.tables, int(self.tables.entry_index[entry])
        if int(tables.entry_kind[entry]) != POLYGON:
            return None
        first, last = tables.polygon_first[index : index + 2].tolist()
        corners = tables.vertices[first:last]
        after = np.roll(corners, -1, axis=0)
        normal = np.cross(window.u, window.v)
        above, next_above = (corners - window.corner) @ normal, (after - window.corner) @ normal
        cut = (above < 0) != (next_above < 0)
        share = (above[cut] / (above[cut] - next_above[cut]))[:, None]
        points = corners[cut] + share * (after[cut] - corners[cut]) - window.corner
        across, up = window.size
        return np.stack([points @ window.u / across - across / 2, points @ window.v / up - up / 2], axis=1)

    def _leaves(self, program: int) -> list[tuple[tuple[int, int], ...]]:
        return [self._cell(int(cells_of_leaves(self.tables, leaf))) for leaf in leaves_of_program(self.tables, program)]

    def _cell(self, cell: int) -> tuple[tuple[int, int], ...]:
        tables = self.tables
        first, last = tables.cell_first[cell : cell + 2].tolist()
        planes = zip(
            tables.plane_surface[first:last].tolist(),
            sides_of(plane_faces(tables, slice(first, last))).tolist(),
            strict=True,
        )
        quadric = int(tables.cell_quadric[cell])
        return (*planes, *([(quadric, int(sides_of(cell_faces(tables, cell))))] if quadric >= 0 else []))

    def holds(self, entry: int, signs: Signs, count: int) -> Mask:
        """Is each of `count` places in an entry, by the signs of its surfaces there? Of a sheet: in what clips it."""
        tables, cells = self.tables, self.faces(entry).cells
        kind, index = int(tables.entry_kind[entry]), int(tables.entry_index[entry])
        if kind in (BALL, CELL):
            return _in_cell(cells[0], signs, count)
        if kind in (SHEET, POLYGON):
            program = self._sheet(entry)[0]
            return np.ones(count, bool) if program < 0 else self._program(program, cells[1:], signs, count)
        return self._program(index, cells, signs, count)

    def _program(self, program: int, cells: Any, signs: Signs, count: int) -> Mask:
        """A Boolean program, by counting the true inputs of its gates (engine/body/gates.py)."""
        tables = self.tables
        gates = gates_of_program(tables, program)
        begin, first = gates[0], int(row_of_leaf(tables, program, tables.program_leaf[program]))
        truths = np.repeat(tables.gate_start[begin : gates.stop].astype(np.int64)[:, None], count, axis=1)
        for k, cell in enumerate(cells):
            change = -1 if tables.leaf_negated[first + k] else 1
            truths[tables.leaf_gate[first + k] - begin] += change * _in_cell(cell, signs, count)
        for gate in reversed(gates[1:]):
            need, start = int(tables.gate_need[gate]), int(tables.gate_start[gate])
            falls = (start >= need) != bool(tables.gate_negated[gate])
            changed = (truths[gate - begin] >= need) != (start >= need)
            truths[tables.gate_parent[gate] - begin] += (-1 if falls else 1) * changed
        found: Mask = (truths[0] >= int(tables.gate_need[begin])) != bool(tables.gate_negated[begin])
        return found


def _in_cell(faces: tuple[tuple[int, int], ...], signs: Signs, count: int) -> Mask:
    inside = np.ones(count, bool)
    for surface, side in faces:
        inside &= signs(surface) * side <= 0
    return inside


def boxes_overlap(one: FloatArray, others: FloatArray) -> Mask:
    """Which of some boxes (n, 4) share a place with one."""
    found: Mask = (
        (others[:, 0] <= one[2]) & (others[:, 2] >= one[0]) & (others[:, 1] <= one[3]) & (others[:, 3] >= one[1])
    )
    return found
