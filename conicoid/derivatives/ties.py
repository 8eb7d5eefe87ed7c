"""Where more than one wall is met at once: there the answer has no derivative, as either wall may come to be the one.

Within a body other walls of its cells are evaluated at the point; of other bodies the crossings of the ray about there
are asked for. What cannot be told from a tie in floats counts as one.
"""

from __future__ import annotations

from typing import TYPE_CHECKING, Any

import numpy as np

from ..engine.answers.rays import Rays, lines_of
from ..engine.queries import queries
from ..engine.tables import BALL, CELL, POLYGON, REGION, SHEET, Tables
from ..shapes.vector import FloatArray
from .forms import forms_of
from .forward import Columns, gradient, numbers_of, table_of, value

if TYPE_CHECKING:
    from ..engine.answers.hits import Hits
    from ..engine.prepared import Prepared

_NEAR = 2.0**-47
"""Points nearer to one another than this share of their coordinates are not told apart."""
_ROUNDED = 2.0**-50
"""More than rounding takes from the value of a form, as a share of its terms."""


def tied_within(prepared: Prepared, body: Any, face: Any, points: FloatArray, size: FloatArray) -> Any:
    """bool (n,): is a point (n, 3) of a body's face on another wall of that body as well? For hits only.

    size (n,): the largest of the numbers that points are the sums of, as `sizes` gives it.
    """
    tied = np.zeros(len(body), np.bool_)
    tables = prepared.lowered.tables
    entries = entries_of(tables, body)
    kinds = tables.entry_kind[entries]
    alone = np.flatnonzero(kinds == CELL)
    near = alone[_near_walls(tables, tables.entry_index[entries[alone]], face[alone], points[alone], size[alone])]
    for mine in grouped(body, np.concatenate([near, np.flatnonzero(kinds == REGION)])):
        cells = cells_of(tables, int(entries_of(tables, body[mine[0]])))
        if len(cells) > 1 or len(walls_of_cell(tables, cells[0])[0]) > 1:
            x = [points[:, k].take(mine) for k in range(3)]
            tied[mine] = _tied_in_cells(tables, cells, face[mine], x, size[mine])
    return tied


def _near_walls(tables: Tables, cell: Any, face: Any, points: FloatArray, size: FloatArray) -> Any:
    """bool (n,): may points of cells' faces lie on another wall of the cell? A test of all cells at once."""
    near = np.zeros(len(cell), np.bool_)
    first = tables.cell_first[cell]
    count = tables.cell_first[cell + 1] - first
    for k in range(int(count.max(initial=0))):
        some = np.flatnonzero(count > k)
        row = first[some] + k
        other = tables.plane_face[row] != face[some]
        some, row = some[other], row[other]
        near[some] |= _may_be_zero(tables, tables.plane_surface[row], points, size, some)
    curved = np.flatnonzero((tables.cell_quadric[cell] >= 0) & (tables.cell_face[cell] != face))
    near[curved] |= _may_be_zero(tables, tables.cell_quadric[cell[curved]], points, size, curved)
    return near


def _may_be_zero(tables: Tables, surface: Any, points: FloatArray, size: FloatArray, some: Any) -> Any:
    """bool: may some points be on surfaces?"""
    known, back = np.unique(surface, return_inverse=True)
    forms, anchors = forms_of(tables, known)
    rows = numbers_of(table_of(forms, anchors), back)
    r = [points[some, k] - rows[10 + k] for k in range(3)]
    found = value(rows, r, gradient(rows, r))
    largest = np.abs(anchors).max(axis=1, initial=0.0)
    second, steep = 2 * np.abs(forms[:, :6]).sum(axis=1), 2 * np.abs(forms[:, 6:9]).sum(axis=1)
    far = np.maximum(size[some], largest[back])
    slope = steep[back] + 2 * second[back] * far
    terms = (slope * far + np.abs(forms[:, 9])[back]) * (second[back] > 0) + np.abs(forms[:, 9])[back]
    return np.abs(found) <= far * (_NEAR * slope) + _ROUNDED * terms


def grouped(keys: Any, rows: Any) -> list[Any]:
    """Some rows by their keys, which are numbers from 0 on; in each group they rise."""
    if not len(rows):
        return []
    mine = keys[rows]
    order = np.argsort(mine.astype(np.uint16) if mine.max() < 1 << 16 else mine, kind="stable")
    ends = np.flatnonzero(np.diff(mine[order])) + 1
    return np.split(rows[order], ends)


def sizes(origins: FloatArray, points: FloatArray) -> FloatArray:
    """The largest coordinates of origins and points (n, 3), which say how exact the points are."""
    found: FloatArray = np.abs(points[:, 0])
    for column in (points[:, 1], points[:, 2], *origins.T):
        np.maximum(found, np.abs(column), out=found)
    return found


def entries_of(tables: Tables, bodies: Any) -> Any:
    """The entry of each body; no body has more than one."""
    number = np.full(len(tables.body_face), -1, np.int64)
    number[tables.entry_body] = np.arange(len(tables.entry_body))
    return number[bodies]


def cells_of(tables: Tables, entry: int) -> list[int]:
    """The cells of an entry; none for a ball or a sheet, which have one wall."""
    kind, index = int(tables.entry_kind[entry]), int(tables.entry_index[entry])
    if kind == CELL:
        return [index]
    if kind != REGION:
        return []
    found: list[int] = tables.leaf_cell[tables.program_leaf[index] : tables.program_leaf[index + 1]].tolist()
    return found


def walls_of_cell(tables: Tables, cell: int) -> tuple[list[int], list[int], list[int]]:
    """(surfaces, sides, face numbers) of a cell."""
    part = slice(int(tables.cell_first[cell]), int(tables.cell_first[cell + 1]))
    rows = [tables.plane_surface[part].tolist(), tables.plane_side[part].tolist(), tables.plane_face[part].tolist()]
    curved = int(tables.cell_quadric[cell])
    if curved >= 0:
        rows = [
            [first, *rest]
            for first, rest in zip(
                (curved, int(tables.cell_side[cell]), int(tables.cell_face[cell])), rows, strict=True
            )
        ]
    return rows[0], rows[1], rows[2]


def _tied_in_cells(tables: Tables, cells: list[int], face: Any, x: Columns, size: FloatArray) -> Any:
    """bool (n,) for points in columns on faces of one body."""
    tied = np.zeros(len(face), np.bool_)
    for cell in cells:
        surfaces, sides, numbers = walls_of_cell(tables, cell)
        values, slacks = values_at(tables, surfaces, x, size)
        touched = np.zeros(len(face), np.int8)
        for found, slack, number in zip(values, slacks, numbers, strict=True):
            near = np.abs(found) <= slack
            if near.any():
                touched |= near & (face != number)
        some = np.flatnonzero(touched)
        if len(some):  # on a wall, unless another wall of its cell cuts it off there
            within = [side * v[some] <= slack[some] for v, slack, side in zip(values, slacks, sides, strict=True)]
            tied[some] |= np.all(within, axis=0)
    return tied


def values_at(tables: Tables, surfaces: list[int], x: Columns, size: FloatArray) -> tuple[Columns, Columns]:
    """(the values of surfaces at points, and below which size they may be zero), columns."""
    forms, anchors = forms_of(tables, np.array(surfaces))
    values, slacks = [], []
    for form, anchor in zip(forms.tolist(), anchors.tolist(), strict=True):
        r = [a - b if b else a for a, b in zip(x, anchor, strict=True)]
        largest = max(map(abs, anchor))
        steep, rounded = 2 * sum(map(abs, form[6:9])), abs(form[9])
        if any(form[:6]):
            far = float(size.max(initial=0.0)) + largest
            steep += 2 * sum(map(abs, form[:6])) * far
            rounded += steep * far
        reach = size if not largest else np.maximum(size, largest)
        values.append(value(form, r, gradient(form, r)) + 0.0 * size)
        slacks.append(reach * (_NEAR * steep) + _ROUNDED * rounded)
    return values, slacks


def tied_across(hits: Hits, rows: Any, surface: Any, size: FloatArray) -> Any:
    """bool (n,): do some of the hits, by rows, with these surfaces lie on walls of other bodies as well?

    Rays that start on the hits, and know it, meet nothing nearby; but a surface that bodies share is left out then.
    """
    prepared, tied = hits._scene, np.zeros(len(rows), np.bool_)
    if prepared.lowered.body_count < 2 or not len(rows):
        return tied
    origins, directions = (array[rows] for array in lines_of(hits.rays))
    t = hits._found.t[rows]
    length = np.maximum(np.maximum(*np.abs(directions[:, :2].T)), np.abs(directions[:, 2]))
    reach = np.maximum(_NEAR * size / length, _NEAR * np.abs(t))
    away = Rays._spawned(hits._points[rows], directions, surface.astype(np.int32), hits._home)
    tied |= queries.occluded(prepared, away, -reach, reach)
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
    kind, index, owner = tables.entry_kind, tables.entry_index, tables.entry_body
    of_cells = np.full(len(tables.cell_quadric), -1, np.int64)
    of_cells[index[kind == CELL]] = owner[kind == CELL]
    of_programs = np.full(len(tables.program_leaf), -1, np.int64)
    of_programs[index[kind == REGION]] = owner[kind == REGION]
    of_leaves = np.repeat(of_programs[:-1], np.diff(tables.program_leaf))
    of_cells[tables.leaf_cell[of_leaves >= 0]] = of_leaves[of_leaves >= 0]
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
    count = np.bincount(keys // (prepared.lowered.body_count + 1), minlength=len(tables.surface_kind))
    found = vars(prepared)["_shared_surfaces"] = count > 1
    return found
