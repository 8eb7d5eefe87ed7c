"""Surfaces that are equal up to rounding, but not equal: two entries of the scene's table where one was meant.

Coefficients of each surface about the middle of what it is used for, in units of its size, say how far
two surfaces differ there. Candidates are found by a random projection of scene-wide features, as in lowering.
"""

from __future__ import annotations

from collections.abc import Iterator
from dataclasses import dataclass
from typing import Any

import numpy as np

from ..geometry.tables import BALL, CELL, PLANE, POLYGON, REGION, SHEET, SPHERE, Tables
from ..lowering.surfaces import _clusters, _plane_features, _quadric_features
from ..shapes.vector import FloatArray
from .aim import Targets

CLOSE = 1e-12
"""Relative difference of coefficients below which surfaces are nearly coincident."""

_MOST_PAIRS = 20_000


@dataclass(frozen=True)
class NearPair:
    """Two surfaces, a body that each belongs to, how far they differ, and the box where both bodies are."""

    surfaces: tuple[int, int]
    bodies: tuple[int, int]
    difference: float
    low: FloatArray
    high: FloatArray


def near_pairs(tables: Tables, targets: Targets) -> Iterator[NearPair]:
    """Pairs of different surfaces that are nearly coincident where two bodies with them meet, or one body has both."""
    users = Users.of(tables)
    for one, other in _candidates(tables):
        a, b = users.bodies(one), users.bodies(other)
        first, second = np.repeat(a, len(b)), np.tile(b, len(a))
        low, high = targets.common(first, second)
        margin = CLOSE * np.minimum(targets.sizes[first], targets.sizes[second])[:, None]
        meeting = np.flatnonzero((low <= high + margin).all(axis=1))
        if not len(meeting):
            continue
        k = meeting[np.argmax(np.linalg.norm(high - low, axis=1)[meeting])]
        center, half = (low[k] + high[k]) / 2, max(float(np.abs(high[k] - low[k]).max()) / 2, 1e-300)
        difference = _difference(tables, one, other, center, half)
        if difference <= CLOSE:
            yield NearPair((one, other), (int(first[k]), int(second[k])), difference, low[k], high[k])


def _candidates(tables: Tables) -> Iterator[tuple[int, int]]:
    """Pairs of surfaces of one kind whose features over the whole scene are close."""
    flat = tables.surface_kind == PLANE
    planes, curved = np.flatnonzero(flat), np.flatnonzero(~flat)
    rows = tables.surface_row
    clusters = list(_clusters(planes, _plane_features(tables.planes[rows[planes]])))
    clusters += _clusters(
        curved, _quadric_features(tables.surface_kind[curved], rows[curved], tables.spheres, tables.quadrics)
    )
    count = 0
    for cluster in clusters:
        members = sorted(int(i) for i in cluster)
        for i, one in enumerate(members):
            for other in members[i + 1 :]:
                yield one, other
                count += 1
                if count >= _MOST_PAIRS:
                    return


def _difference(tables: Tables, one: int, other: int, center: FloatArray, half: float) -> float:
    """The largest difference of coefficients, the largest of which is 1, about a point in units of a length."""
    a, b = (_coefficients(tables, surface, center, half) for surface in (one, other))
    return float(min(np.abs(a - b).max(), np.abs(a + b).max()))


def _coefficients(tables: Tables, surface: int, center: FloatArray, half: float) -> FloatArray:
    """(10,) xx, yy, zz, xy, xz, yz, x, y, z, 1 of (x - center) / half, scaled to a largest one of 1."""
    kind, row = tables.surface_kind[surface], tables.surface_row[surface]
    result = np.zeros(10)
    if kind == PLANE:
        normal, height, anchor = np.split(tables.planes[row], (3, 4))
        result[6:9] = normal * half
        result[9] = float(height[0]) + normal @ (center - anchor)
    else:
        anchor, rows, squares, linear, constant = _quadric(tables, int(kind), int(row))
        y = rows @ (center - anchor)
        second = rows.T @ (squares[:, None] * rows) * half * half
        result[:6] = second[(0, 1, 2, 0, 0, 1), (0, 1, 2, 1, 2, 2)]
        result[6:9] = rows.T @ (squares * y + linear) * half
        result[9] = y @ (squares * y + 2 * linear) - constant
    largest = np.abs(result).max()
    return result / (largest if largest > 0 else 1.0)


def _quadric(tables: Tables, kind: int, row: int) -> tuple[Any, Any, Any, Any, float]:
    """(anchor, rows, squares, linear, constant) of a quadric or sphere."""
    if kind == SPHERE:
        x, y, z, r = tables.spheres[row]
        return np.array((x, y, z)), np.eye(3), np.ones(3), np.zeros(3), float(r * r)
    q = tables.quadrics[row]
    return q[:3], q[3:12].reshape(3, 3), q[12:15], q[15:18], float(q[18])


@dataclass(frozen=True)
class Users:
    """Which bodies have which surfaces: rows sorted by surface."""

    surface: Any
    body: Any

    @classmethod
    def of(cls, tables: Tables) -> Users:
        kind, index, body = tables.entry_kind, tables.entry_index, tables.entry_body
        pairs = [(index[kind == BALL], body[kind == BALL])]
        # Surfaces of every cell
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
            counts = tables.program_leaf[program + 1] - tables.program_leaf[program]
            leaves = np.repeat(tables.program_leaf[program], counts) + _counted(counts)
            cells.append(tables.leaf_cell[leaves])
            owners.append(np.repeat(owner, counts))
        used, by = np.concatenate(cells), np.concatenate(owners)
        counts = first[used + 1] - first[used]
        pairs.append((surface[order][np.repeat(first[used], counts) + _counted(counts)], np.repeat(by, counts)))
        rows = np.unique(np.column_stack([np.concatenate(column) for column in zip(*pairs, strict=True)]), axis=0)
        return cls(rows[:, 0], rows[:, 1])

    def bodies(self, surface: int) -> Any:
        """Ids of the bodies that have a surface."""
        first, last = np.searchsorted(self.surface, (surface, surface + 1))
        return self.body[first:last]


def _counted(counts: Any) -> Any:
    """0 .. n - 1 for every n, one after the other."""
    return np.arange(int(counts.sum())) - np.repeat(np.cumsum(counts) - counts, counts)
