"""Where more than one wall is met at once: there the answer has no derivative, as either wall may come to be the one.

Within a body other walls of its cells are evaluated at the point; of other bodies the crossings of the ray about there
are looked for. What cannot be told from a tie in floats counts as one.
"""

from __future__ import annotations

from typing import TYPE_CHECKING, Any

import numpy as np

from ..engine.answers.rays import Rays, lines_of
from ..engine.programs import cells_of_leaves, leaves_of_programs
from ..engine.queries import queries
from ..engine.ray import RayArrays
from ..engine.tables import BALL, CELL, POLYGON, REGION, SHEET, Signs
from ..engine.threads import run_on
from ..shapes.vector import FloatArray
from .across import OPEN, ties_across
from .forward import given, rows
from .touching import NEAR, TIED, faces_on, ties_within

if TYPE_CHECKING:
    from ..engine.answers.hits import Hits
    from ..engine.prepared import Prepared

_CHUNK = 4096


def tied_within(prepared: Prepared, entry: Any, face: Any, origins: FloatArray, points: FloatArray) -> Signs:
    """TIED (n,) where a point (n, 3) of an entry's face is on another wall of that entry as well, else 0.

    entry: -1 for a miss. origins (n, 3): of the rays that the points are on.
    """
    tied = np.zeros(len(entry), np.int8)
    arguments = given(entry), given(face), rows(origins, 3), rows(points, 3)
    count = len(entry)
    run_on(prepared.geometry, lambda g, a, b: ties_within(g, *arguments, a, b, tied), count, _CHUNK, count)
    return tied


def faces_of_ends(prepared: Prepared, entry: Any, surface: Any, origins: FloatArray, points: FloatArray) -> Any:
    """The face numbers (n,) of crossings of entries with surfaces; where cells share one, that of the cell met."""
    faces = np.zeros(len(entry), np.int32)
    arguments = given(entry), given(surface), rows(origins, 3), rows(points, 3)
    count = len(entry)
    run_on(prepared.geometry, lambda g, a, b: faces_on(g, *arguments, a, b, faces), count, _CHUNK, count)
    return faces


def tied_hits(hits: Hits) -> Signs:
    """TIED (n,) where a hit is on more than one wall, of its body or of several, else 0.

    Rays that start on a hit, and know it, meet nothing nearby.
    """
    prepared, found = hits._scene, hits._found
    origins, directions = (rows(part, 3) for part in lines_of(hits.rays))
    points, entry, count = rows(hits._points, 3), given(found.entry), hits.size
    tied = tied_within(prepared, entry, hits._faces[1], origins, points)
    if prepared.lowered.body_count < 2:
        return tied
    limits, starts = (np.array([-np.inf]), np.array([np.inf])), hits.rays._starts_in(prepared)
    arrays = RayArrays(origins, directions, *limits, given(starts))
    t = given(found.t)
    run_on(
        prepared.geometry, lambda g, a, b: ties_across(g, arrays, entry, t, points, a, b, tied), count, _CHUNK, count
    )
    still = np.flatnonzero(tied == OPEN)
    if len(still):
        tied[still] = np.where(_crossed_nearby(hits, still), TIED, 0)
    return tied


def _crossed_nearby(hits: Hits, which: Any) -> Any:
    """bool: do some of the hits lie on walls of other bodies as well? As rays are traced, with certainty.

    A surface that bodies share is left out where rays start on it, so it is asked for by the rays as they came.
    """
    prepared, surface = hits._scene, hits._faces[0][which]
    origins, directions = (array[which] for array in lines_of(hits.rays))
    points, t = hits._points[which], hits._found.t[which]
    length = np.abs(directions).max(axis=1)
    size = np.maximum(np.abs(points).max(axis=1), np.abs(origins).max(axis=1))
    reach = np.maximum(NEAR * size / length, NEAR * np.abs(t))
    away = Rays._spawned(points, directions, surface.astype(np.int32), hits._home)
    tied = queries.occluded(prepared, away, -reach, reach)
    common = np.flatnonzero(shared_surfaces(prepared)[surface])
    if len(common):
        t, part = t[common], reach[common]
        found = queries.crossings(prepared, Rays(origins[common], directions[common]), t - part, t + part)
        tied[common] |= np.diff(found.offsets) > 1
    return tied


def shared_surfaces(prepared: Prepared) -> Any:
    """bool (surfaces,): is a surface of more than one body?"""
    known = vars(prepared).get("_shared_surfaces")
    if known is not None:
        return known
    tables = prepared.lowered.tables
    kind, index, owner = tables.entry_kind, tables.entry_index, np.arange(len(tables.entry_kind))
    of_cells = np.full(len(tables.cell_quadric), -1, np.int64)
    of_cells[index[kind == CELL]] = owner[kind == CELL]
    (first, count), of_programs = leaves_of_programs(tables), np.full(len(tables.program_leaf) - 1, -1, np.int64)
    of_programs[index[kind == REGION]] = owner[kind == REGION]
    of_leaves = np.repeat(of_programs, count)
    leaves = np.repeat(first - (np.cumsum(count) - count), count) + np.arange(len(of_leaves))
    of_cells[cells_of_leaves(tables, leaves[of_leaves >= 0])] = of_leaves[of_leaves >= 0]
    pairs = [
        (tables.cell_quadric, of_cells),
        (tables.plane_surface, np.repeat(of_cells, np.diff(tables.cell_first))),
        (index[kind == BALL], owner[kind == BALL]),
        (tables.sheet_surface[index[kind == SHEET]], owner[kind == SHEET]),
        (tables.polygon_surface[index[kind == POLYGON]], owner[kind == POLYGON]),
    ]
    surfaces, bodies = (np.concatenate(part).astype(np.int64) for part in zip(*pairs, strict=True))
    real = (surfaces >= 0) & (bodies >= 0)
    keys = np.unique(surfaces[real] * (prepared.lowered.body_count + 1) + bodies[real])
    users = np.bincount(keys // (prepared.lowered.body_count + 1), minlength=len(tables.surface_kind))
    found = vars(prepared)["_shared_surfaces"] = users > 1
    return found
