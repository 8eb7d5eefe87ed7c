"""Patterns: what bodies of one kind have in common, as arrays, so that the tables of thousands are laid out at once.

A body is its pattern (how its cells, gates, faces and sheets hang together) and a row of numbers: for each surface its
record, what rounding took from that, and its sense; 4 numbers for each row of its maps to uv; a box for each leaf of
its programs; its own box; the frame of its local points; the corners of its polygons, and what rounding took from
these.
"""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass, field
from functools import cached_property
from typing import TYPE_CHECKING, Any

import numpy as np

from ..tables import MAP_SIZE, PLANE, PLANE_SIZE, QUADRIC, QUADRIC_SIZE, SPHERE, SPHERE_SIZE, Floats, Ints
from .assembly import Assembly

if TYPE_CHECKING:
    from .moved_rows import MovedRows
    from .rows import Rows

SIZES = {PLANE: PLANE_SIZE, SPHERE: SPHERE_SIZE, QUADRIC: QUADRIC_SIZE}
BOX_NUMBERS, FRAME_NUMBERS = 6, 12


@dataclass(frozen=True, eq=False)
class Pattern:
    """All that is alike in bodies of one kind. Columns of the lists are those of `Assembly`."""

    kind: int
    index: int
    angular: Ints
    maps: Ints  # (faces, 3) rows of the map to uv of each face, which faces may have in common
    kinds: Ints
    cells: Ints  # (cells, 3)
    cell_planes: Ints
    planes: Ints  # (planes, 3)
    programs: Ints  # (programs, 2)
    leaves: Ints  # (leaves, 4)
    gates: Ints  # (gates, 4)
    sheets: Ints  # (sheets, 4)
    polygons: Ints  # (polygons, 2)
    corners: Ints  # of each polygon
    framed: bool = True
    """Has it faces and a frame of its own? Balls of many share one."""

    # Columns of a row
    records: list[tuple[int, int, int]] = field(init=False)  # kind, first column, column of the sense
    uv_at: int = field(init=False)
    bounds_at: int = field(init=False)
    box_at: int = field(init=False)
    frame_at: int = field(init=False)
    corners_at: int = field(init=False)
    width: int = field(init=False)

    def __post_init__(self) -> None:
        at, records = 0, []
        for kind in self.kinds.tolist():
            records.append((kind, at, at + 2 * SIZES[kind]))
            at += 2 * SIZES[kind] + 1
        columns: dict[str, Any] = dict(records=records, uv_at=at)
        columns["bounds_at"] = at = at + MAP_SIZE * self.map_rows
        columns["box_at"] = at = at + BOX_NUMBERS * len(self.leaves)
        columns["frame_at"] = at = at + BOX_NUMBERS
        columns["corners_at"] = at = at + FRAME_NUMBERS * self.framed
        columns["width"] = at + 6 * int(self.corners.sum())
        for name, value in columns.items():
            object.__setattr__(self, name, value)

    @classmethod
    def of(
        cls,
        assembly: Assembly,
        kind: int,
        index: int,
        angular: Sequence[bool],
        maps: Sequence[tuple[int, int, int]],
        framed: bool = True,
    ) -> Pattern:
        """The pattern of a body that has been put together."""
        return cls(
            kind,
            index,
            np.array(angular, np.int32),
            _table(maps, 3),
            np.array([record.kind for record in assembly.surfaces], np.int32),
            _table(assembly.cells, 3),
            np.array(assembly.cell_planes, np.int32),
            _table(assembly.planes, 3),
            _table(assembly.programs, 2),
            _table(assembly.leaves, 4),
            _table(assembly.gates, 4),
            _table(assembly.sheets, 4),
            _table(assembly.polygons, 2),
            np.array([len(outline) for outline in assembly.outlines], np.int32),
            framed,
        )

    def __eq__(self, other: object) -> bool:
        return isinstance(other, Pattern) and self.key == other.key

    def __hash__(self) -> int:
        return hash(self.key)

    @property
    def map_rows(self) -> int:
        """How many rows the maps of its faces have."""
        return int(self.maps.max(initial=-1)) + 1

    @cached_property
    def key(self) -> tuple[Any, ...]:
        """What says that two patterns are one."""
        arrays = (
            self.angular, self.maps, self.kinds, self.cells, self.cell_planes, self.planes, self.programs, self.leaves,
            self.gates, self.sheets, self.polygons, self.corners,
        )  # fmt: skip
        return self.kind, self.index, self.framed, *((len(array), array.tobytes()) for array in arrays)


def _table(rows: Sequence[tuple[int, ...]], width: int) -> Ints:
    return np.array(rows, np.int32).reshape(-1, width)


@dataclass
class Group:
    """Bodies of one pattern: their numbers in the scene, in rising order, and their rows."""

    pattern: Pattern
    bodies: Ints
    rows: Floats | MovedRows | Rows
    ball_frame: int = 0
    """-1 - k for balls that share frame k; 0 for bodies with faces of their own."""
