"""How far a relative change of 2^-53 of each of its numbers moves a shape, in units of its own extent.

docs/conditioning.md derives what is computed here: a lower bound on the movement, attained up to second order.
"""

from __future__ import annotations

from dataclasses import dataclass
from typing import Any

import numpy as np

from ..shapes import exact as ex
from ..shapes.motion import Motion
from ..shapes.polygon import Polygon
from ..shapes.triangle import Triangle
from ..shapes.vector import FloatArray
from .changes import HALF_ULP
from .local import Fields, Frame, Local, LocalCell, fields_of
from .places import gradients, tests_of

_MOST_EDGES = 128
_ROUNDING = 2.0**-50


@dataclass(frozen=True, eq=False)
class Movement:
    """The worst place of a part.

    relative    how far it moves there, in units of the part's extent in that direction
    number      the number that most of it comes from
    local       (3,) where, in local coordinates; `gradient` (3,) of what moves, and `width` of the part along it
    normals     (k, 3) gradients of the surfaces that meet there
    singular    does the surface's gradient vanish there, as far as its numbers can tell?
    """

    relative: float
    number: str
    local: FloatArray
    gradient: FloatArray
    width: float
    singular: bool = False
    normals: FloatArray | None = None


def movement(part: Local, fields: Fields, is_sheet: bool) -> Movement | None:
    """The worst of all cells; None where nothing of the part is looked at."""
    found = [_of_cell(cell, fields, is_sheet) for cell in part.cells]
    return max((one for one in found if one is not None), key=lambda one: one.relative, default=None)


def _of_cell(cell: LocalCell, fields: Fields, is_sheet: bool) -> Movement | None:
    tests = tests_of(cell)
    if not len(tests.points):
        return None
    h = np.concatenate([tests.points, np.ones((len(tests.points), 1))], axis=1)
    slopes = gradients(cell.forms, tests.points)
    gradient = np.einsum("ts,tsi->ti", tests.weights, slopes)
    by_number = np.concatenate(
        [
            np.einsum("ts,ti,nsij,tj->tn", tests.weights, h, cell.moves, h, optimize=True),
            np.einsum("ti,mij,tj->tm", gradient, fields.fields, h, optimize=True),
        ],
        axis=1,
    )
    by_number = np.abs(by_number)
    change = by_number.sum(axis=1)
    width = np.abs(gradient).sum(axis=1)
    if is_sheet:
        width = np.linalg.norm(gradient, axis=1)
    elif len(tests.corners) > 3 and not cell.cut:
        reach = gradient @ tests.corners.T
        width = np.minimum(width, reach.max(axis=1) - reach.min(axis=1))
    width = width + _ROUNDING * np.einsum("ts,ts->t", np.abs(tests.weights), np.abs(slopes).sum(axis=2))
    bend = np.abs(tests.weights) @ np.abs(cell.forms[:, :3, :3]).sum(axis=(1, 2))
    relative = moved(change, width, bend)
    worst = int(relative.argmax())
    names = (*cell.numbers, *fields.numbers)
    return Movement(
        float(relative[worst]),
        names[int(by_number[worst].argmax())] if names else "",
        tests.points[worst],
        gradient[worst],
        float(width[worst]),
        bool(4 * bend[worst] * change[worst] > width[worst] ** 2),
        slopes[worst][tests.weights[worst] != 0],
    )


def moved(change: Any, width: Any, bend: Any) -> Any:
    """The least d with width d + bend d² >= change."""
    with np.errstate(divide="ignore", invalid="ignore"):
        found = 2 * change / (width + np.sqrt(width * width + 4 * bend * change))
    return np.where(change > 0, found, 0.0)


def polygon_movement(leaf: Polygon | Triangle, motion: Motion) -> tuple[Movement, Frame]:
    """Vertices against the polygon's width across each edge, in the world's directions; across its plane the least."""
    own = leaf.vertices if isinstance(leaf, Polygon) else (leaf.a, leaf.b, leaf.c)
    names = [f"vertices[{k}]" for k in range(len(own))] if isinstance(leaf, Polygon) else ["a", "b", "c"]
    rows, _ = motion.affine
    start = ex.exact_row(own[0])
    frame = Frame(start, ex.IDENTITY)
    fields = fields_of(motion, frame)
    exact = [ex.exact_row(ex.exact(a) - b for a, b in zip(vertex, start, strict=True)) for vertex in own]
    local = np.array([[float(c) for c in row] for row in exact])
    points = np.array([[float(c) for c in ex.apply(rows, row)] for row in exact])
    linear = np.array([[float(c) for c in row] for row in rows])
    normal = _area(points)
    edges = np.roll(points, -1, axis=0) - points
    across = np.cross(normal, edges[:: -(-len(edges) // _MOST_EDGES)])
    across = across[np.abs(across).max(axis=1) > 0]
    across = across / np.linalg.norm(across, axis=1)[:, None]
    heights = across @ points.T
    widths = heights.max(axis=1) - heights.min(axis=1)
    tests = np.concatenate([across, normal[None] / np.linalg.norm(normal)])
    widths = np.append(widths, widths.min())
    by_own = HALF_ULP * np.abs((tests @ linear)[:, None, :] * np.array(own)[None, :, :])
    h = np.concatenate([local, np.ones((len(local), 1))], axis=1)
    by_field = np.abs(np.einsum("ei,mij,vj->evm", tests @ linear, fields.fields, h, optimize=True))
    relative = (by_own.sum(axis=2) + by_field.sum(axis=2)) / widths[:, None]
    e, v = np.unravel_index(int(relative.argmax()), relative.shape)
    parts = np.concatenate([by_own[e, v], by_field[e, v]])
    number = (*(f"{names[v]}[{k}]" for k in range(3)), *fields.numbers)[int(parts.argmax())]
    return Movement(float(relative[e, v]), number, local[v], tests[e] @ linear, float(widths[e])), frame


def _area(points: FloatArray) -> FloatArray:
    """Twice the area vector of a loop that begins at the origin."""
    total: FloatArray = np.cross(points[1:-1], points[2:]).sum(axis=0)
    return total
