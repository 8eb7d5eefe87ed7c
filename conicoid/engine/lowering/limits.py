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

from ..surface.doubt import FAR, KAPPA, KAPPA_OF_BALLS, KAPPA_OF_PLANES, RELATIVE
from ..tables import CELL, POLYGON, REGION, SHEET, SPHERE, Floats, Tables
from .apart import apart
from .surfaces import Remainders

Whole = npt.NDArray[Any]

_CHUNK = 1 << 14
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
    size = size_of(tables, boxes) if any(len(surface) for surface, _, _ in parts) else 1.0
    limits = apart(no_limits(cells + sheets + polygons))
    known = _of_planes(rest.planes), _of_anchors(rest.quadrics)
    per_surface = np.zeros((3, max(int(surface.max(initial=-1)) for surface, _, _ in parts) + 1))
    for surface, owner, users in parts:
        for begin in range(0, len(surface), _CHUNK):
            some = slice(begin, begin + _CHUNK)
            _weigh(tables, boxes, known, size, (surface[some], owner[some], users[some]), limits, per_surface)
    of_cells = limits[:cells]
    return tables._replace(
        plane_limits=apart(_planes(tables, rest, *per_surface[:2])),
        quadric_limits=apart(_quadrics(tables, *per_surface)),
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


def _anchors(tables: Tables, surface: Whole) -> Floats:
    """(n, 3) anchors of surfaces."""
    kind, row = tables.surface_kind[surface], tables.surface_row[surface]
    anchors = np.empty((len(surface), 3))
    for which, table, first in ((0, tables.planes, 4), (1, tables.spheres, 0), (2, tables.quadrics, 0)):
        own = kind == which
        if own.all():
            return table[row, first : first + 3]
        anchors[own] = table[row[own], first : first + 3]
    return anchors


def _sums(rows: Floats) -> Floats:
    """The sums of the last axis, from left to right as `np.sum` of few numbers has them, all rows at once."""
    total: Floats = rows[..., 0].copy()
    for column in range(1, rows.shape[-1]):
        total += rows[..., column]
    return total


def reaches(
    tables: Tables, boxes: Floats, surface: Whole, entry: Whole, size: float
) -> tuple[Floats, npt.NDArray[np.bool_]]:
    """(how far from its anchor a surface is used, is that bounded) of every use."""
    anchors = _anchors(tables, surface)
    ends = boxes[entry]
    bounded = np.isfinite(ends[:, 0])
    for column in range(1, 6):
        bounded &= np.isfinite(ends[:, column])
    away = np.maximum(np.abs(ends[:, :3] - anchors), np.abs(ends[:, 3:] - anchors))
    away[~bounded] = 0.0
    reach = np.sqrt(_sums(away**2)) * (1 + 1e-12) + 1e-300
    reach = np.where(bounded, reach, _WIDE * size)
    ball = tables.surface_kind[surface] == SPHERE
    reach[ball] = tables.spheres[tables.surface_row[surface[ball]], 3]
    return reach, bounded


def size_of(tables: Tables, boxes: Floats) -> float:
    """Of what is finite in a scene: coordinates, radii, the own sizes of quadrics."""
    numbers = [np.abs(tables.planes[:, 4:7]).ravel(), np.abs(tables.quadrics[:, :3]).ravel()]
    for begin in range(0, len(boxes), _CHUNK):
        part = np.abs(boxes[begin : begin + _CHUNK])
        numbers.append(np.max(part, where=np.isfinite(part), initial=0.0, keepdims=True).ravel())
    for begin in range(0, len(tables.quadrics), _CHUNK):
        a, b, k = _sizes(tables.quadrics[begin : begin + _CHUNK])
        with np.errstate(divide="ignore", invalid="ignore"):
            numbers += [np.sqrt(k / a), b / a, k / b]
    known = np.concatenate(numbers)
    return float(np.max(known[np.isfinite(known)], initial=0.0)) or 1.0


def _sizes(quadrics: Floats) -> tuple[Floats, Floats, Floats]:
    """Bounds on the second-order, linear and constant terms at distance 1 from the anchor."""
    rows = np.sqrt(_sums(quadrics[:, 3:12].reshape(-1, 3, 3) ** 2))
    squares, linear = np.abs(quadrics[:, 12:15]), np.abs(quadrics[:, 15:18])
    return _sums(squares * rows**2), _sums(linear * rows), np.abs(quadrics[:, 18])


def kappas(tables: Tables, rest: Remainders, surface: Whole, reach: Floats) -> Floats:
    """kappa of every use of a surface."""
    kind, row = tables.surface_kind[surface], tables.surface_row[surface]
    flat, curved = kind == 0, kind == 2
    of_planes = _of_planes(rest.planes[row[flat]])
    return _kappas(flat, curved, of_planes, _of_anchors(rest.quadrics[tables.quadric_rest[row[curved]]]), reach)


def _of_planes(rest: Floats) -> Floats:
    """kappa of planes, from what rounding took from their records."""
    return np.where(_inexact(rest), KAPPA_OF_PLANES, 0.0)


def _of_anchors(rest: Floats) -> Floats:
    """How far the anchors of quadrics were rounded."""
    return np.sqrt(_sums(rest[:, :3] ** 2))


def _kappas(flat: Any, curved: Any, of_planes: Floats, off: Floats, reach: Floats) -> Floats:
    """`kappas` of uses, of which some are planes and some are quadrics, from what is known of these."""
    kappa = np.full(len(reach), KAPPA_OF_BALLS)
    kappa[flat] = of_planes
    kappa[curved] = KAPPA + 8.0 * off / reach[curved]
    return kappa


def _inexact(rest: Floats) -> npt.NDArray[np.bool_]:
    """Was anything rounded in each record?"""
    found = np.zeros(len(rest), bool)
    for column in range(rest.shape[1]):
        found |= rest[:, column] != 0.0
    return found


def no_limits(count: int) -> Floats:
    """(count, 2): what t may be off by, for |d| = 1; how far |o| + |t d| may be. Nothing is known yet."""
    limits = np.zeros((count, 2))
    limits[:, 1] = math.inf
    return limits


def _weigh(
    tables: Tables, boxes: Floats, known: tuple[Floats, Floats], size: float, uses: tuple[Whole, Whole, Whole],
    limits: Floats, per_surface: Floats,
) -> None:  # fmt: skip
    """Take some uses, surfaces with their owners and entries, into the limits of owners and the most of surfaces.

    known: kappa of each plane, and how far the anchor of each row of what was rounded of quadrics is off.
    per_surface (3, surfaces): the largest reach, the largest kappa, whether some use has no end.
    """
    surface, owner, users = uses
    reach, bounded = reaches(tables, boxes, surface, users, size)
    kind, row = tables.surface_kind[surface], tables.surface_row[surface]
    flat, curved = kind == 0, kind == 2
    kappa = _kappas(flat, curved, known[0][row[flat]], known[1][tables.quadric_rest[row[curved]]], reach)
    limit_owners(limits, flat, owner, reach, bounded, kappa, boxes[users], size)
    for numbers, of_use in zip(per_surface, (reach, kappa, ~bounded), strict=True):
        np.maximum.at(numbers, surface, of_use)


def limits_of_owners(
    flat: Any, owner: Whole, reach: Floats, bounded: Any, kappa: Floats, boxes: Floats, size: float, count: int
) -> Floats:
    """(count, 2): the limits of owners by uses, `boxes` being those of the uses' bodies."""
    limits = no_limits(count)
    limit_owners(limits, flat, owner, reach, bounded, kappa, boxes, size)
    return limits


def limit_owners(
    limits: Floats, flat: Any, owner: Whole, reach: Floats, bounded: Any, kappa: Floats, boxes: Floats, size: float
) -> None:
    """Take uses into the limits of their owners."""
    around = np.where(bounded, _sums(np.abs(boxes)), _WIDE * size)
    exact = ~bounded & flat & (kappa == 0)
    off = 0.5 * np.sqrt(kappa) * reach + RELATIVE * np.where(exact, _WIDEST * size, around)
    far = np.where(bounded, FAR * reach, np.where(exact, _WIDEST * size, _WIDE * size))
    if (owner[1:] > owner[:-1]).all():
        limits[owner, 0] = np.maximum(limits[owner, 0], off)
        limits[owner, 1] = np.minimum(limits[owner, 1], far)
    else:
        np.maximum.at(limits[:, 0], owner, off)
        np.minimum.at(limits[:, 1], owner, far)


def _planes(tables: Tables, rest: Remainders, reach: Floats, kappa: Floats) -> Floats:
    """(planes, 2): the square of the least rate that is certain, for |d| = 1; the least height of parallel rays."""
    result = np.zeros((len(tables.planes), 2))
    own = np.flatnonzero(tables.surface_kind[: len(reach)] == 0)
    result[tables.surface_row[own]] = limits_of_planes(tables, rest, own, reach[own], kappa[own])
    return result


def limits_of_planes(tables: Tables, rest: Remainders, own: Whole, reach: Floats, kappa: Floats) -> Floats:
    """`plane_limits` of some surfaces that are planes."""
    row = tables.surface_row[own]
    result = np.empty((len(own), 2))
    length = np.sqrt(_sums(tables.planes[row, :3] ** 2))
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
    for begin in range(0, len(own), _CHUNK):
        some = slice(begin, begin + _CHUNK)
        quadrics = tables.quadrics[tables.surface_row[own[some]]]
        _put_limits_of_quadrics(result[some], quadrics, r[some], share[some], endless[some])
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
