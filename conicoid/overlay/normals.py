"""Outward normals of what is seen, as arrows: of one length in the picture, shorter where they point at the eye."""

from __future__ import annotations

from typing import TYPE_CHECKING

import numpy as np

from ..shapes.rounded import hypot
from .seen import grid_of_hits, pixel_sizes
from .sheet import Sheet

if TYPE_CHECKING:
    from ..render.camera import AnyCamera
    from ..scene import Scene

_APART, _LONG, _HEAD = 30, 22, 5  # pixels of a small picture
_COLOR = "#7a1fa2"


def draw_normals(sheet: Sheet, scene: Scene, camera: AnyCamera) -> None:
    """An arrow on each point of a grid of pixels that shows a body."""
    hits = grid_of_hits(scene, camera, sheet.width, sheet.height, _APART * sheet.unit)
    hits = hits[hits.hit]
    lengths = _LONG * sheet.unit * pixel_sizes(camera, hits.point, sheet.height)
    starts = camera.project(hits.point, sheet.width, sheet.height)
    ends = camera.project(hits.point + lengths[:, None] * hits.normal, sheet.width, sheet.height)
    for start, end in zip(starts, ends, strict=True):
        if np.isfinite(end).all():
            arrow = _arrow(start, end, _HEAD * sheet.unit)
            for color, width, opacity in (("white", 3.5, 0.6), (_COLOR, 1.5, 1.0)):
                for line in arrow:
                    sheet.line(line, color, width, opacity)


def _arrow(start: np.ndarray, end: np.ndarray, head: float) -> list[list[list[float]]]:
    """Its shaft and its head; a cross where it points at the eye."""
    along = end - start
    length = hypot(*along.tolist())
    if length < 1:
        a, b = np.array([head / 2, 0]), np.array([0, head / 2])
        return [[(start - a).tolist(), (start + a).tolist()], [(start - b).tolist(), (start + b).tolist()]]
    along *= min(head, 0.6 * length) / length
    side = np.array([-along[1], along[0]]) * 0.6
    return [
        [start.tolist(), end.tolist()],
        [(end - along + side).tolist(), end.tolist(), (end - along - side).tolist()],
    ]
