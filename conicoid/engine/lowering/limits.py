"""How far the fast formulas can be trusted: the limits by which rays are marked as doubtful.

Every bound of docs/exactness.md depends on a scene only through a few numbers of each surface and cell.
They are computed here, once, from the constants of surface/doubt.py. R is how far from a surface's anchor the bodies
reach that it bounds, kappa the share of a value's terms by which rounding may change it, and the bounds hold for rays
within `far` of the scene.
"""

from __future__ import annotations

import math
from dataclasses import dataclass, field
from typing import Any

import numpy as np
import numpy.typing as npt

from ..tables import CELL, POLYGON, REGION, SHEET, Floats, Tables
from .apart import apart, empty
from .surfaces import Remainders
from .weighed import Records, put_limits_of_planes, put_limits_of_quadrics, size_of_records, weigh

Whole = npt.NDArray[Any]

_USES = 1 << 17


@dataclass
class _Uses:
    """Which surface bounds which cell, sheet or polygon, and in which entry's box."""

    surfaces: list[Whole] = field(default_factory=list)
    owners: list[Whole] = field(default_factory=list)
    entries: list[Whole] = field(default_factory=list)

    def add(self, surfaces: Whole, owners: Whole, entries: Whole) -> None:
        """Add surfaces with what they bound; those that are missing, or in no entry, are left out."""
        known = (surfaces >= 0) & (entries >= 0)
        self.surfaces.append(surfaces[known])
        self.owners.append(owners[known])
        self.entries.append(entries[known])


def with_limits(tables: Tables, boxes: Floats, rest: Remainders) -> Tables:
    """The tables with `plane_limits`, `quadric_limits`, and those of cells, programs, sheets and polygons."""
    cells, sheets, polygons = len(tables.cell_quadric), len(tables.sheet_surface), len(tables.polygon_surface)
    uses, cell_entry = _Uses(), np.full(cells, -1, np.int32)
    kind, index = tables.entry_kind, tables.entry_index
    own = np.flatnonzero(kind == CELL)
    cell_entry[index[own]] = own
    leaf_entry = np.repeat(_entries_of_programs(tables), np.diff(tables.program_leaf))
    held = leaf_entry >= 0
    cell_entry[tables.leaf_cell[held]] = leaf_entry[held]
    uses.add(tables.cell_quadric, np.arange(cells, dtype=np.int32), cell_entry)
    planes = np.repeat(np.arange(cells, dtype=np.int32), np.diff(tables.cell_first))
    uses.add(tables.plane_surface, planes, cell_entry[planes])
    for which, column, base in (
        (SHEET, tables.sheet_surface, cells),
        (POLYGON, tables.polygon_surface, cells + sheets),
    ):
        own = np.flatnonzero(kind == which)
        uses.add(column[index[own]], base + index[own], own)
    parts = list(zip(uses.surfaces, uses.owners, uses.entries, strict=True))
    size = 1.0 if np.isfinite(boxes).all() else size_of(tables, boxes)  # else nothing depends on it
    limits = apart(no_limits(cells + sheets + polygons))
    per_surface = np.zeros((3, max(int(surface.max(initial=-1)) for surface, _, _ in parts) + 1))
    records = Records.of(tables, rest)
    for surface, owner, users in parts:
        weigh_all(records, boxes, size, (surface, surface, owner, users), limits, per_surface)
    of_cells = limits[:cells]
    of_planes, of_quadrics = (empty((len(table), 2), np.float64) for table in (tables.planes, tables.quadrics))
    every = np.arange(per_surface.shape[1], dtype=np.int32)
    put_limits_of_planes(records, every, per_surface, of_planes)
    put_limits_of_quadrics(records, every, per_surface, of_quadrics)
    return tables._replace(
        plane_limits=of_planes,
        quadric_limits=of_quadrics,
        cell_limits=of_cells,
        program_limits=apart(_merged(tables, of_cells)),
        sheet_limits=limits[cells : cells + sheets],
        polygon_limits=limits[cells + sheets :],
    )


def _entries_of_programs(tables: Tables) -> Whole:
    """The entry that each program belongs to; -1 for none."""
    entries = np.full(len(tables.program_leaf) - 1, -1, np.int32)
    for kind, clip in ((REGION, None), (SHEET, tables.sheet_program), (POLYGON, tables.polygon_program)):
        own = np.flatnonzero(tables.entry_kind == kind)
        program = tables.entry_index[own] if clip is None else clip[tables.entry_index[own]]
        entries[program[program >= 0]] = own[program >= 0]
    return entries


def size_of(tables: Tables, boxes: Floats) -> float:
    """Of what is finite in a scene: coordinates, radii, the own sizes of quadrics."""
    return size_of_records(tables.planes, tables.quadrics, tables.quadric_forms, boxes) or 1.0


def no_limits(count: int) -> Floats:
    """(count, 2): what t may be off by, for |d| = 1; how far |o| + |t d| may be. Nothing is known yet."""
    limits = np.zeros((count, 2))
    limits[:, 1] = math.inf
    return limits


def weigh_all(
    records: Records, boxes: Floats, size: float, uses: tuple[Whole, Whole, Whole, Whole], limits: Floats, most: Floats
) -> None:
    """`weigh` for all uses: their surfaces, the places of these in `most`, their owners and entries.

    Raises IndexError if one names what is not there: its owner would be trusted without a limit.
    """
    surface, place, owner, entry = (np.ascontiguousarray(each, np.int32) for each in uses)
    for begin in range(0, len(surface), _USES):  # Ctrl-C is heard in between
        end = min(len(surface), begin + _USES)
        if weigh(records, boxes, size, surface, place, owner, entry, begin, end, limits, most):
            raise IndexError("the tables of a scene name surfaces, cells or boxes that they do not have")


def _merged(tables: Tables, cells: Floats) -> Floats:
    """The limits of programs: the widest of their leaves'."""
    program = np.repeat(np.arange(len(tables.program_leaf) - 1, dtype=np.int32), np.diff(tables.program_leaf))
    return limits_of_programs(program, cells[tables.leaf_cell], len(tables.program_leaf) - 1)


def limits_of_programs(program: Whole, leaves: Floats, count: int) -> Floats:
    """(count, 2): those of programs from those of their leaves' cells."""
    result = np.zeros((count, 2))
    result[:, 1] = math.inf
    np.maximum.at(result[:, 0], program, leaves[:, 0])
    np.minimum.at(result[:, 1], program, leaves[:, 1])
    return result
