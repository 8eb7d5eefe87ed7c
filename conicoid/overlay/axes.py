"""The axes of the world: from the origin, or from a corner where that is far away; dim where bodies hide them."""

from __future__ import annotations

from typing import TYPE_CHECKING

import numpy as np

from ..shapes.rounded import hypot
from .seen import hidden
from .sheet import Sheet, nice

if TYPE_CHECKING:
    from ..render.camera import AnyCamera
    from ..scene import Scene
    from ..shapes.vector import FloatArray

_COLORS = ("#c8102e", "#1a7f37", "#1f4fd0")
_STEPS = 240
_ROOM = 30  # pixels between two numbers, at least


def draw_axes(sheet: Sheet, scene: Scene, camera: AnyCamera) -> None:
    """x in red, y in green, z in blue, with ticks and numbers."""
    low, high = scene.extent
    size = float((high - low).max())
    near = ((low - size <= 0) & (high + size >= 0)).all()
    start = np.zeros(3) if near else low
    for axis in range(3):
        end = start.copy()
        end[axis] = max(high[axis], start[axis]) + 0.15 * size
        _draw_axis(sheet, scene, camera, axis, start, end, nice(size / 3))


def _draw_axis(
    sheet: Sheet, scene: Scene, camera: AnyCamera, axis: int, start: FloatArray, end: FloatArray, step: float
) -> None:
    points = start + np.linspace(0, 1, _STEPS + 1)[:, None] * (end - start)
    places = camera.project(points, sheet.width, sheet.height)
    known = ~np.isnan(places[:, 0])
    behind = hidden(scene, camera, (points[:-1] + points[1:]) / 2)
    for dim in (True, False):  # what is seen is drawn last
        for first, last in _runs((behind == dim) & known[:-1] & known[1:]):
            line = places[first : last + 1].tolist()
            if not dim:
                sheet.line(line, "white", 4, 0.6)
            sheet.line(line, _COLORS[axis], 1.2 if dim else 2, 0.35 if dim else 1.0)
    _draw_numbers(sheet, camera, axis, start, end, step)
    if known[-1]:
        sheet.text(places[-1].tolist(), "xyz"[axis], _COLORS[axis], 17)


def _draw_numbers(sheet: Sheet, camera: AnyCamera, axis: int, start: FloatArray, end: FloatArray, step: float) -> None:
    numbers = np.arange(np.floor(start[axis] / step) + 1, np.ceil(end[axis] / step)) * step
    numbers = numbers[numbers <= end[axis] - 0.3 * step]
    points = np.tile(start, (len(numbers), 1))
    points[:, axis] = numbers
    ends = camera.project(np.array([start, end]), sheet.width, sheet.height)
    along = ends[1] - ends[0]
    length = hypot(*along.tolist())
    if not length >= 0.5 * _ROOM * sheet.unit:
        return  # the axis points at the eye
    if length * step / abs(end[axis] - start[axis]) < _ROOM * sheet.unit:
        numbers, points = numbers[-1:], points[-1:]
    across = np.array([-along[1], along[0]]) / length
    across *= np.sign(across[1]) or 1.0  # below the line, or to its right
    for number, place in zip(numbers.tolist(), camera.project(points, sheet.width, sheet.height), strict=True):
        if np.isfinite(place).all():
            tick = across * 4 * sheet.unit
            sheet.line([(place - tick).tolist(), (place + tick).tolist()], _COLORS[axis], 1.5)
            sheet.text((place + 3.2 * tick).tolist(), f"{number + 0.0:g}", _COLORS[axis], 11)


def _runs(mask: FloatArray) -> list[tuple[int, int]]:
    """[first, last) of each stretch of true entries."""
    edges = np.flatnonzero(np.diff(np.concatenate([[False], mask, [False]]).astype(np.int8)))
    return [(int(a), int(b)) for a, b in edges.reshape(-1, 2)]
