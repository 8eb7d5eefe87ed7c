"""Surfaces that are equal up to rounding, but not equal: two entries of the scene's table where one was meant.

Two surfaces are compared by their coefficients about the middle of the common box of two bodies, in units of its size.
Candidates are surfaces whose coefficients over the whole scene differ little.
"""

from __future__ import annotations

from collections.abc import Iterator
from dataclasses import dataclass
from typing import Any

import numpy as np

from ..._util.arrays import FloatArray
from ...kernels.programs import cells_of_leaves, leaves_of_programs
from ...kernels.tables import BALL, CELL, PLANE, POLYGON, REGION, SHEET, SPHERE, Tables
from .probe_rays import ProbeTargets

CLOSE = 1e-12
"""Relative difference of coefficients below which surfaces are nearly coincident."""

_FAR_OFF = 1e-11
"""The same for candidates, over the whole scene."""
_MOST_PAIRS = 20_000
"""The search for candidates ends after about so many."""


@dataclass(frozen=True)
class NearPair:
    """Two surfaces, a body of each, the relative difference of their coefficients, and the common box of the bodies."""

    surfaces: tuple[int, int]
    bodies: tuple[int, int]
    difference: float
    low: FloatArray
    high: FloatArray


def near_pairs(tables: Tables, targets: ProbeTargets) -> Iterator[NearPair]:
    """Yield pairs of surfaces that nearly coincide in the common box of two bodies with them, or of one with both."""
    users = SurfaceUsers.of(tables)
    for one, other in _candidates(tables, targets):
        a, b = users.bodies(one), users.bodies(other)
        first, second = np.repeat(a, len(b)), np.tile(b, len(a))
        low, high = targets.common(first, second)
        # Boxes that touch up to rounding have a common part
        margin = CLOSE * np.minimum(targets.sizes[first], targets.sizes[second])[:, None]
        meeting = np.flatnonzero((low <= high + margin).all(axis=1))
        if not len(meeting):
            continue
        # The largest common box of all pairs of bodies
        k = meeting[np.argmax(np.linalg.norm(high - low, axis=1)[meeting])]
        difference = _difference(coefficients(tables, np.array([one, other]), low[k], high[k]))
        if difference <= CLOSE:
            yield NearPair((one, other), (int(first[k]), int(second[k])), difference, low[k], high[k])


def _candidates(tables: Tables, targets: ProbeTargets) -> Iterator[tuple[int, int]]:
    """Yield pairs of surfaces that differ little over the whole window: neighbours along a random projection.

    The projection has a fixed seed. Its absolute value is compared, as the sign of a surface's equation is arbitrary.
    """
    surfaces = np.arange(len(tables.surface_kind))
    rows = coefficients(tables, surfaces, *targets.window)
    place = np.abs(rows @ np.random.default_rng(20261121).normal(size=10))
    order = np.argsort(place, kind="stable")
    count = 0
    # Neighbours of distance 1, 2 and so on in the order, until none of them is close
    for apart in range(1, len(order)):
        near = np.flatnonzero(place[order[apart:]] - place[order[:-apart]] <= _FAR_OFF)
        if not len(near) or count > _MOST_PAIRS:
            return
        for one, other in zip(order[near].tolist(), order[near + apart].tolist(), strict=True):
            if _difference(rows[[one, other]]) <= _FAR_OFF:
                yield min(one, other), max(one, other)
                count += 1


def _difference(rows: FloatArray) -> float:
    """Return the largest difference of two rows of coefficients, whatever the sign of each row."""
    return float(min(np.abs(rows[0] - rows[1]).max(), np.abs(rows[0] + rows[1]).max()))


def coefficients(tables: Tables, surfaces: Any, low: FloatArray, high: FloatArray) -> FloatArray:
    """Return coefficients (n, 10) of xx, yy, zz, xy, xz, yz, x, y, z, 1 of some surfaces; the largest of a row is ±1.

    Coordinates are about the middle of the box low (3,) to high (3,), in units of half its largest side.
    """
    center, half = low / 2 + high / 2, max(float(np.abs(high / 2 - low / 2).max()), 1e-290)
    kind, row = tables.surface_kind[surfaces], tables.surface_row[surfaces]
    result = np.zeros((len(surfaces), 10))
    # A quadric Σ s y² + 2 l y - c with y = W (x - anchor); mixed and linear terms halved, as in a matrix
    ball, plane = kind == SPHERE, kind == PLANE
    p = center - tables.spheres[row[ball], :3]
    result[ball, :3], result[ball, 6:9] = half * half, half * p
    result[ball, 9] = (p * p).sum(axis=1) - tables.spheres[row[ball], 3] ** 2
    q = tables.whole_quadrics(row[~ball & ~plane])
    w, s, b = q[:, 3:12].reshape(-1, 3, 3), q[:, 12:15], q[:, 15:18]
    y = np.einsum("nki,ni->nk", w, center - q[:, :3])
    second = np.einsum("nki,nk,nkj->nij", w, s, w)[:, (0, 1, 2, 0, 0, 1), (0, 1, 2, 1, 2, 2)]
    first = np.einsum("nki,nk->ni", w, s * y + b)
    zeroth = (s * y * y + 2 * b * y).sum(axis=1) - q[:, 18]
    result[~ball & ~plane] = np.column_stack([second * half * half, first * half, zeroth])
    n = tables.planes[row[plane]]
    result[plane, 6:9], result[plane, 9] = n[:, :3] * half, n[:, 3] + (n[:, :3] * (center - n[:, 4:])).sum(axis=1)
    # Coefficients that are all 0 stay 0
    largest = np.abs(result).max(axis=1, keepdims=True)
    return result / np.where(largest > 0, largest, 1.0)


@dataclass(frozen=True)
class SurfaceUsers:
    """The bodies that have each surface, as pairs (surface, body) sorted by surface."""

    surface: Any
    body: Any

    @classmethod
    def of(cls, tables: Tables) -> SurfaceUsers:
        """Collect the pairs of balls, cells, regions, sheets and polygons."""
        kind, index, body = tables.entry_kind, tables.entry_index, np.arange(len(tables.entry_kind))
        # The index of a ball is its surface
        pairs = [(index[kind == BALL], body[kind == BALL])]
        # Surfaces of every cell: those of cell i are surface[order][first[i]:first[i + 1]]
        cell = np.repeat(np.arange(len(tables.cell_quadric)), np.diff(tables.cell_first))
        curved = np.flatnonzero(tables.cell_quadric >= 0)
        cell, surface = (
            np.concatenate([cell, curved]),
            np.concatenate([tables.plane_surface, tables.cell_quadric[curved]]),
        )
        order = np.argsort(cell, kind="stable")
        first = np.searchsorted(cell[order], np.arange(len(tables.cell_quadric) + 1))
        # Cells of every body: its own, or those of its program
        cells, owners = [index[kind == CELL]], [body[kind == CELL]]
        programs = [(index[kind == REGION], body[kind == REGION])]
        for sort, own, clip in (
            (SHEET, tables.sheet_surface, tables.sheet_program),
            (POLYGON, tables.polygon_surface, tables.polygon_program),
        ):
            pairs.append((own[index[kind == sort]], body[kind == sort]))
            clipped = clip[index[kind == sort]]
            programs.append((clipped[clipped >= 0], body[kind == sort][clipped >= 0]))
        for program, owner in programs:
            firsts, counts = (each[program] for each in leaves_of_programs(tables))
            leaves = np.repeat(firsts, counts) + _count_ranges(counts)
            cells.append(cells_of_leaves(tables, leaves))
            owners.append(np.repeat(owner, counts))
        used, by = np.concatenate(cells), np.concatenate(owners)
        counts = first[used + 1] - first[used]
        pairs.append((surface[order][np.repeat(first[used], counts) + _count_ranges(counts)], np.repeat(by, counts)))
        rows = np.unique(np.column_stack([np.concatenate(column) for column in zip(*pairs, strict=True)]), axis=0)
        return cls(rows[:, 0], rows[:, 1])

    def bodies(self, surface: int) -> Any:
        """Return the ids of the bodies that have a surface."""
        first, last = np.searchsorted(self.surface, (surface, surface + 1))
        return self.body[first:last]


def _count_ranges(counts: Any) -> Any:
    """Return 0 .. n - 1 for every n, one after the other."""
    return np.arange(int(counts.sum())) - np.repeat(np.cumsum(counts) - counts, counts)
