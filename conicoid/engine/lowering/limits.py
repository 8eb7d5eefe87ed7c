"""How far the fast formulas can be trusted: the limits by which rays are marked as doubtful.

Every bound of docs/exactness.md depends on a scene only through a few numbers of each surface and cell.
They are computed here, once, from the constants of surface/doubt.py. R is how far from a surface's anchor the bodies
reach that it bounds, kappa the share of a value's terms by which rounding may change it, and the bounds hold for rays
within `far` of the scene.
"""

from __future__ import annotations

import math
from collections.abc import Iterator
from typing import Any

import numpy as np
import numpy.typing as npt

from ..faces import rows_of_cells
from ..programs import cells_of_leaves, leaves_of_programs, rows_of_programs
from ..tables import CELL, PLANE, POLYGON, QUADRIC, REGION, SHEET, Floats, Tables
from .apart import apart, empty
from .surfaces import Remainders
from .weighed import Records, put_limits_of_planes, put_limits_of_quadrics, size_of_records, weigh

Whole = npt.NDArray[Any]

_USES = 1 << 17


def with_limits(tables: Tables, boxes: Floats, rest: Remainders) -> Tables:
    """The tables with `limits_of` them."""
    return tables._replace(**limits_of(tables, boxes, rest))


def shapes_of_limits(tables: Tables) -> dict[str, Floats]:
    """Arrays of the shapes of `limits_of`."""
    counts = dict(
        plane=len(tables.planes), quadric=len(tables.quadric_forms), cell=_rows_of_cells(tables),
        program=len(_models(tables)), sheet=len(tables.sheet_surface), polygon=len(tables.polygon_surface),
    )  # fmt: skip
    return {f"{of}_limits": np.broadcast_to(0.0, (count, 2)) for of, count in counts.items()}


def limits_of(tables: Tables, boxes: Floats, rest: Remainders) -> dict[str, Any]:
    """`plane_limits`, `quadric_limits`, and those of cells, programs, sheets and polygons."""
    cells, sheets, polygons = _rows_of_cells(tables), len(tables.sheet_surface), len(tables.polygon_surface)
    cell_entry = _entries_of_cells(tables)
    size = 1.0 if np.isfinite(boxes).all() else size_of(tables, boxes)  # else nothing depends on it
    limits = no_limits(cells + sheets + polygons)
    last = max((int(surface.max(initial=-1)) for surface, _, _ in _uses(tables, cell_entry)), default=-1)
    place, used = _places(tables, last)
    most = empty((3, len(used)), np.float64)
    records = Records.of(tables, rest)
    for surface, owner, users in _uses(tables, cell_entry):
        places = place.take(surface, mode="clip")  # of one that is not there whichever, as it is refused
        weigh_all(records, boxes, size, (surface, places, owner, users), limits, most)
    of_cells = apart(limits[:cells])
    of_planes, of_quadrics = (empty((len(table), 2), np.float64) for table in (tables.planes, tables.quadric_forms))
    put_limits_of_planes(records, used, most, of_planes)
    put_limits_of_quadrics(records, used, most, of_quadrics)
    return dict(
        plane_limits=of_planes,
        quadric_limits=of_quadrics,
        cell_limits=of_cells,
        program_limits=_merged(tables, of_cells),
        sheet_limits=apart(limits[cells : cells + sheets]),
        polygon_limits=apart(limits[cells + sheets :]),
    )


def _rows_of_cells(tables: Tables) -> int:
    """How many limits cells have: those that are one another moved share them."""
    return len(tables.cell_face)


def _models(tables: Tables) -> Whole:
    """Of each of the limits that programs have, one of the programs that share them."""
    models = np.empty(len(tables.program_gate) - 1, np.int32)
    models[rows_of_programs(tables)] = np.arange(len(tables.program_leaf) - 1, dtype=np.int32)
    return models


def _places(tables: Tables, last: int) -> tuple[Whole, Whole]:
    """(the place of each surface in what is known of them, the surface of each place; -1: none up to the last).

    Planes have one each, and quadrics of one form share one; spheres need none, and have one together.
    """
    planes, row = len(tables.planes), tables.surface_row
    place = np.full(len(row), planes + len(tables.quadric_forms), np.int32)
    surfaces = np.full(planes + len(tables.quadric_forms) + 1, -1, np.int32)
    flat, curved = (np.flatnonzero(tables.surface_kind == kind) for kind in (PLANE, QUADRIC))
    place[flat] = row[flat]
    place[curved] = tables.quadrics[row[curved], 3] + planes
    for some in (flat, curved):
        some = some[some <= last]
        surfaces[place[some]] = some
    return place, surfaces


def _entries_of_cells(tables: Tables) -> Whole:
    """The entry that each cell belongs to; -1 for none."""
    kind, index = tables.entry_kind, tables.entry_index
    cell_entry = empty(len(tables.cell_quadric), np.int32)
    cell_entry.fill(-1)
    own = np.flatnonzero(kind == CELL)
    cell_entry[index[own]] = own
    of_programs, (first, count) = _entries_of_programs(tables), leaves_of_programs(tables)
    ends = _ends(count)
    for begin, end in _parts(ends):
        some = count[begin:end]
        entries = np.repeat(of_programs[begin:end], some)
        leaves = np.repeat(first[begin:end] - ends[begin:end], some) + np.arange(ends[begin], ends[end], dtype=np.int32)
        held = entries >= 0
        cell_entry[cells_of_leaves(tables, leaves[held])] = entries[held]
    return cell_entry


def _ends(counts: Whole) -> Whole:
    """Where each begins, and the last ends."""
    return np.concatenate([np.zeros(1, np.int32), np.cumsum(counts, dtype=np.int32)])


def _uses(tables: Tables, cell_entry: Whole) -> Iterator[tuple[Whole, Whole, Whole]]:
    """Which surface bounds which cell, sheet or polygon, and in which entry's box; a part at a time.

    Those that are missing, or in no entry, are left out.
    """
    kind, index, cells = tables.entry_kind, tables.entry_index, len(cell_entry)
    for begin in range(0, cells, _USES):
        end = min(cells, begin + _USES)
        rows = rows_of_cells(tables, np.arange(begin, end, dtype=np.int32))
        yield _used(tables.cell_quadric[begin:end], rows, cell_entry[begin:end])
    for begin, end in _parts(tables.cell_first):
        first = tables.cell_first[begin : end + 1]
        owners = np.repeat(np.arange(begin, end, dtype=np.int32), np.diff(first))
        rows = rows_of_cells(tables, owners)
        yield _used(tables.plane_surface[first[0] : first[-1]], rows, cell_entry[owners])
    base = _rows_of_cells(tables)
    for which, column in ((SHEET, tables.sheet_surface), (POLYGON, tables.polygon_surface)):
        own = np.flatnonzero(kind == which)
        yield _used(column[index[own]], base + index[own], own)
        base += len(column)


def _used(surfaces: Whole, owners: Whole, entries: Whole) -> tuple[Whole, Whole, Whole]:
    """What is not missing, and in an entry."""
    known = (surfaces >= 0) & (entries >= 0)
    return surfaces[known], owners[known], entries[known]


def _parts(first: Whole) -> Iterator[tuple[int, int]]:
    """Parts of what has its rows from first[k] to first[k + 1]: about `_USES` of these, or those of one."""
    begin, count = 0, len(first) - 1
    while begin < count:
        end = min(count, max(begin + 1, int(np.searchsorted(first, first[begin] + _USES, side="right")) - 1))
        yield begin, end
        begin = end


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
    limits = empty((count, 2), np.float64)
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
    models = _models(tables)
    first, count = (each[models] for each in leaves_of_programs(tables))
    ends = _ends(count)
    merged = empty((len(models), 2), np.float64)
    for begin, end in _parts(ends):
        program = np.repeat(np.arange(end - begin, dtype=np.int32), np.diff(ends[begin : end + 1]))
        leaves = np.arange(ends[begin], ends[end]) + (first - ends[:-1])[begin:end][program]
        rows = rows_of_cells(tables, cells_of_leaves(tables, leaves))
        merged[begin:end] = limits_of_programs(program, cells[rows], end - begin)
    return merged


def limits_of_programs(program: Whole, leaves: Floats, count: int) -> Floats:
    """(count, 2): those of programs from those of their leaves' cells."""
    result = np.zeros((count, 2))
    result[:, 1] = math.inf
    np.maximum.at(result[:, 0], program, leaves[:, 0])
    np.minimum.at(result[:, 1], program, leaves[:, 1])
    return result
