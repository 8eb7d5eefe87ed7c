"""The limits of a scene (`engine.lowering.limits`) by NumPy, all uses at once: an oracle for the kernels."""

from __future__ import annotations

import math
from dataclasses import dataclass, field
from typing import Any

import numpy as np
import numpy.typing as npt

from conicoid.kernels.surface.doubt import FAR, KAPPA, KAPPA_OF_BALLS, KAPPA_OF_PLANES, RELATIVE
from conicoid.kernels.tables import CELL, POLYGON, REGION, SHEET, SPHERE, Floats, Tables

Whole = npt.NDArray[Any]

_LEAST = 1e-100
"""Times the square of a direction's least component that is still a number."""
_WIDE, _WIDEST = 2.0**10, 2.0**20
"""Bodies without an end are taken to be so many times as large as the scene; those of exact planes, so many times."""


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


def with_limits(tables: Tables, boxes: Floats, rest: Any) -> Tables:
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
    size = size_of(tables, boxes) if any(len(surface) for surface, _, _ in parts) else 1.0
    limits = no_limits(cells + sheets + polygons)
    per_surface = np.zeros((3, max(int(surface.max(initial=-1)) for surface, _, _ in parts) + 1))
    for surface, owner, users in parts:
        _weigh(tables, boxes, rest, size, (surface, owner, users), limits, per_surface)
    of_cells = limits[:cells]
    return tables._replace(
        plane_limits=_planes(tables, rest, *per_surface[:2]),
        quadric_limits=_quadrics(tables, *per_surface),
        cell_limits=of_cells,
        program_limits=_merged(tables, of_cells),
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


def _anchors(tables: Tables, surface: Whole) -> Floats:
    """(n, 3) anchors of surfaces."""
    kind, row = tables.surface_kind[surface], tables.surface_row[surface]
    anchors = np.empty((len(surface), 3))
    for which, table, first in ((0, tables.planes, 4), (1, tables.spheres, 0), (2, tables.quadrics, 0)):
        anchors[kind == which] = table[row[kind == which], first : first + 3]
    return anchors


def reaches(
    tables: Tables, boxes: Floats, surface: Whole, entry: Whole, size: float
) -> tuple[Floats, npt.NDArray[np.bool_]]:
    """(how far from its anchor a surface is used, is that bounded) of every use."""
    anchors = _anchors(tables, surface)
    low, high = boxes[entry, :3], boxes[entry, 3:]
    bounded = np.asarray(np.isfinite(low).all(axis=1) & np.isfinite(high).all(axis=1))
    away = np.where(bounded[:, None], np.maximum(np.abs(low - anchors), np.abs(high - anchors)), 0.0)
    reach = np.sqrt((away**2).sum(axis=1)) * (1 + 1e-12) + 1e-300
    reach = np.where(bounded, reach, _WIDE * size)
    ball = tables.surface_kind[surface] == SPHERE
    reach[ball] = tables.spheres[tables.surface_row[surface[ball]], 3]
    return reach, bounded


def size_of(tables: Tables, boxes: Floats) -> float:
    """Of what is finite in a scene: coordinates, radii, the own sizes of quadrics."""
    numbers = [np.abs(part).ravel() for part in (tables.planes[:, 4:7], tables.quadrics[:, :3], boxes)]
    a, b, k = _sizes(tables.whole_quadrics())
    with np.errstate(divide="ignore", invalid="ignore"):
        numbers += [np.sqrt(k / a), b / a, k / b]
    known = np.concatenate(numbers)
    return float(np.max(known[np.isfinite(known)], initial=0.0)) or 1.0


def _sizes(quadrics: Floats) -> tuple[Floats, Floats, Floats]:
    """Bounds on the second-order, linear and constant terms at distance 1 from the anchor."""
    rows = np.sqrt((quadrics[:, 3:12].reshape(-1, 3, 3) ** 2).sum(axis=2))
    squares, linear = np.abs(quadrics[:, 12:15]), np.abs(quadrics[:, 15:18])
    return (squares * rows**2).sum(axis=1), (linear * rows).sum(axis=1), np.abs(quadrics[:, 18])


def kappas(tables: Tables, rest: Any, surface: Whole, reach: Floats) -> Floats:
    """kappa of every use of a surface."""
    kind, row = tables.surface_kind[surface], tables.surface_row[surface]
    kappa = np.full(len(surface), KAPPA_OF_BALLS)
    flat, curved = kind == 0, kind == 2
    kappa[flat] = np.where(_inexact(rest.planes[row[flat]]), KAPPA_OF_PLANES, 0.0)
    off = np.sqrt((rest.quadrics[tables.rows_of_forms[row[curved]], :3] ** 2).sum(axis=1))
    kappa[curved] = KAPPA + 8.0 * off / reach[curved]
    return kappa


def _inexact(rest: Floats) -> npt.NDArray[np.bool_]:
    """Was anything rounded in each record?"""
    return np.asarray((rest != 0.0).any(axis=1))


def no_limits(count: int) -> Floats:
    """(count, 2): what t may be off by, for |d| = 1; how far |o| + |t d| may be. Nothing is known yet."""
    limits = np.zeros((count, 2))
    limits[:, 1] = math.inf
    return limits


def _weigh(
    tables: Tables, boxes: Floats, rest: Any, size: float, uses: tuple[Whole, Whole, Whole], limits: Floats,
    per_surface: Floats,
) -> None:  # fmt: skip
    """Take some uses, surfaces with their owners and entries, into the limits of owners and the most of surfaces.

    per_surface (3, surfaces): the largest reach, the largest kappa, whether some use has no end.
    """
    surface, owner, users = uses
    reach, bounded = reaches(tables, boxes, surface, users, size)
    kappa = kappas(tables, rest, surface, reach)
    limit_owners(limits, tables.surface_kind[surface] == 0, owner, reach, bounded, kappa, boxes[users], size)
    for numbers, of_use in zip(per_surface, (reach, kappa, ~bounded), strict=True):
        np.maximum.at(numbers, surface, of_use)


def limit_owners(
    limits: Floats, flat: Any, owner: Whole, reach: Floats, bounded: Any, kappa: Floats, boxes: Floats, size: float
) -> None:
    """Take uses into the limits of their owners."""
    around = np.where(bounded, np.abs(np.where(bounded[:, None], boxes, 0.0)).sum(axis=1), _WIDE * size)
    exact = ~bounded & flat & (kappa == 0)
    off = 0.5 * np.sqrt(kappa) * reach + RELATIVE * np.where(exact, _WIDEST * size, around)
    np.maximum.at(limits[:, 0], owner, off)
    far = np.where(bounded, FAR * reach, np.where(exact, _WIDEST * size, _WIDE * size))
    np.minimum.at(limits[:, 1], owner, far)


def _planes(tables: Tables, rest: Any, reach: Floats, kappa: Floats) -> Floats:
    """(planes, 2): the square of the least rate that is certain, for |d| = 1; the least height of parallel rays."""
    result = np.zeros((len(tables.planes), 2))
    own = np.flatnonzero(tables.surface_kind[: len(reach)] == 0)
    result[tables.surface_row[own]] = limits_of_planes(tables, rest, own, reach[own], kappa[own])
    return result


def limits_of_planes(tables: Tables, rest: Any, own: Whole, reach: Floats, kappa: Floats) -> Floats:
    """`plane_limits` of some surfaces that are planes."""
    row = tables.surface_row[own]
    result = np.empty((len(own), 2))
    length = np.sqrt((tables.planes[row, :3] ** 2).sum(axis=1))
    result[:, 0] = (np.maximum(2.0 * np.sqrt(kappa), 2.0**-40) * length) ** 2
    plain = (
        ~_inexact(rest.planes[row]) & ((tables.planes[row, :3] != 0).sum(axis=1) == 1) & (tables.planes[row, 3] == 0)
    )
    slack = 2.0**-40 * (length * reach + np.abs(tables.planes[row, 3]))
    result[:, 1] = np.where(plain, 0.0, slack)
    return result


def _quadrics(tables: Tables, reach: Floats, kappa: Floats, endless: Floats) -> Floats:
    """(quadrics, 2): the least discriminant that is certain, for |d| = 1; the least value along rulings.

    The latter is infinite where a body has no end and a direction's part along an axis that bends is a sum: rounding
    may have made that 0, where the ray comes to a wall, however far away.
    """
    result = np.zeros((len(tables.quadrics), 2))
    own = np.flatnonzero(tables.surface_kind[: len(reach)] == 2)
    result[tables.surface_row[own]] = limits_of_quadrics(tables, own, reach[own], kappa[own], endless[own])
    return result


def limits_of_quadrics(tables: Tables, own: Whole, r: Floats, share: Floats, endless: Floats) -> Floats:
    """`quadric_limits` of some surfaces that are quadrics."""
    result = np.empty((len(own), 2))
    _put_limits_of_quadrics(result, tables.whole_quadrics(tables.surface_row[own]), r, share, endless)
    return result


def _put_limits_of_quadrics(result: Floats, quadrics: Floats, r: Floats, share: Floats, endless: Floats) -> None:
    """`limits_of_quadrics` of a part of them."""
    a, b, k = _sizes(quadrics)
    with np.errstate(divide="ignore", invalid="ignore", over="ignore"):
        terms = 10.0 * a * r * r + 6.0 * b * r + k
        result[:, 0] = np.where(r > 0, 4.0 * share * (terms / r) ** 2, math.inf)
    result[:, 1] = np.where((endless > 0) & ~_plain(quadrics), math.inf, share * terms)


def _plain(quadrics: Floats) -> npt.NDArray[np.bool_]:
    """Is each axis along which a quadric bends one of the world's, and its coefficient no number that underflows?"""
    rows, squares, linear = quadrics[:, 3:12].reshape(-1, 3, 3), quadrics[:, 12:15], quadrics[:, 15:18]
    size = np.abs(rows).max(axis=2)
    curved = (squares == 0) | (np.abs(squares) * size**2 > _LEAST)
    along = ((rows != 0).sum(axis=2) <= 1) & curved & ((linear == 0) | (np.abs(linear) * size > _LEAST))
    return np.asarray((along | ((squares == 0) & (linear == 0))).all(axis=1))


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
