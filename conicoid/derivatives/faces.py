"""Which face of its body a crossing is on, by the surface; where several cells share that, the one of the cell met."""

from __future__ import annotations

from typing import TYPE_CHECKING, Any

import numpy as np

from ..shapes.vector import FloatArray
from .ties import cells_of, entries_of, grouped, values_at, walls_of_cell

if TYPE_CHECKING:
    from ..engine.prepared import Prepared


def faces_on(prepared: Prepared, body: Any, surface: Any, points: FloatArray, size: FloatArray) -> Any:
    """The face numbers (n,) of crossings of bodies with surfaces, at points (n, 3); size as for `tied_within`."""
    tables, face = prepared.lowered.tables, np.zeros(len(body), np.int32)
    _, back = np.unique(body.astype(np.int64) * (len(tables.surface_kind) + 1) + surface, return_inverse=True)
    for mine in grouped(back, np.arange(len(back))):
        wanted = int(surface[mine[0]])
        cells = cells_of(tables, int(entries_of(tables, body[mine[0]])))
        found = [
            (cell, number)
            for cell in cells
            for own, _, number in zip(*walls_of_cell(tables, cell), strict=True)
            if own == wanted
        ]
        if found:
            face[mine] = found[-1][1]
        for cell, number in reversed(found) if len(found) > 1 else ():
            x = [points[:, k].take(mine) for k in range(3)]
            surfaces, sides, _ = walls_of_cell(tables, cell)
            values, slacks = values_at(tables, surfaces, x, size[mine])
            within = [side * v <= slack for v, slack, side in zip(values, slacks, sides, strict=True)]
            face[mine[np.all(within, axis=0)]] = number
    return face
