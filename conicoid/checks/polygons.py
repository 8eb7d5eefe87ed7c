"""Digits of polygons and triangles: how far corners move against the polygon's width across each edge."""

from __future__ import annotations

import numpy as np

from ..shapes import exact as ex
from ..shapes.motion import Motion
from ..shapes.polygon import Polygon, newell
from ..shapes.triangle import Triangle
from ..shapes.vector import FloatArray
from .changes import HALF_ULP
from .local import Frame, fields_of
from .movement import Movement

_MOST_EDGES = 128


def polygon_movement(leaf: Polygon | Triangle, motion: Motion) -> tuple[Movement, Frame]:
    """The worst corner and direction: across an edge in the plane, or across the plane, compared with the least width.

    A corner goes by u |v_k| for each of its coordinates, and by the fields of the motion's numbers. Coordinates are
    those of the polygon's own frame about its first corner.
    """
    own = leaf.vertices if isinstance(leaf, Polygon) else (leaf.a, leaf.b, leaf.c)
    names = [f"vertices[{k}]" for k in range(len(own))] if isinstance(leaf, Polygon) else ["a", "b", "c"]
    start = ex.exact_row(own[0])
    frame = Frame(start, ex.IDENTITY)
    fields = fields_of(motion, frame)
    corners = [ex.exact_row(ex.exact(a) - b for a, b in zip(vertex, start, strict=True)) for vertex in own]
    covectors, widths = _directions(corners, motion)
    h = np.array([[*(float(c) for c in corner), 1.0] for corner in corners])
    by_own = HALF_ULP * np.abs(covectors[:, None, :] * np.array(own)[None, :, :])
    by_field = np.abs(np.einsum("ei,mij,vj->evm", covectors, fields.fields, h, optimize=True))
    relative = (by_own.sum(axis=2) + by_field.sum(axis=2)) / widths[:, None]
    e, v = np.unravel_index(int(relative.argmax()), relative.shape)
    shares = np.concatenate([by_own[e, v], by_field[e, v]])
    number = (*(f"{names[v]}[{k}]" for k in range(3)), *fields.numbers)[int(shares.argmax())]
    return Movement(float(relative[e, v]), number, h[v, :3], covectors[e], float(widths[e])), frame


def _directions(corners: list[ex.Row], motion: Motion) -> tuple[FloatArray, FloatArray]:
    """Directions of the world as covectors (E, 3) of the own frame, and the polygon's widths (E,) along them.

    Across (at most about 128 of) the edges within the plane, and last across the plane, with the least of the widths.
    The world is scaled so that the largest coordinate is 1.
    """
    rows, _ = motion.affine
    carried = [ex.apply(rows, corner) for corner in corners]
    size = max(abs(c) for corner in carried for c in corner)
    points = np.array([[float(c / size) for c in corner] for corner in carried])
    linear = np.array([[float(c / size) for c in row] for row in rows])
    normal = np.array([float(c) for c in ex.unit(newell(carried))])
    edges = np.roll(points, -1, axis=0) - points
    across = np.cross(normal, edges[:: -(-len(edges) // _MOST_EDGES)])
    across = across[np.abs(across).max(axis=1) > 0]
    across = across / np.linalg.norm(across, axis=1)[:, None]
    heights = across @ points.T
    widths = heights.max(axis=1) - heights.min(axis=1)
    return np.concatenate([across, normal[None]]) @ linear, np.append(widths, widths.min())
