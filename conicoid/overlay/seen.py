"""What a camera sees of points in the world."""

from __future__ import annotations

from typing import TYPE_CHECKING, Any

import numpy as np

from ..render.camera import Camera
from ..shapes.row_vectors import dot_rows, lengths

if TYPE_CHECKING:
    from ..render.camera import AnyCamera
    from ..scene import Scene

_ALMOST = 1 - 1e-6  # of the way to a point: what it lies on does not hide it


def hidden(scene: Scene, camera: AnyCamera, points: Any) -> Any:
    """bool (n,): do bodies stand between the camera and points (n, 3) in front of it?"""
    lens = camera.lens
    depths = dot_rows(points - lens[0], lens[3])
    result = np.ones(len(points), bool)
    front = depths > 0
    ways = points[front] - lens[0] if isinstance(camera, Camera) else depths[front, None] * lens[3]
    result[front] = scene.occluded(points[front] - ways, ways, t_max=_ALMOST) if front.any() else False
    return result


def pixel_sizes(camera: AnyCamera, points: Any, height: int) -> Any:
    """(n,): the length in the world that is a pixel long, where points (n, 3) are."""
    if not isinstance(camera, Camera):
        return np.full(len(points), camera.height / height)
    lens = camera.lens
    return 2 * dot_rows(points - lens[0], lens[3]) * lengths(lens[5]) / height


def grid_of_hits(scene: Scene, camera: AnyCamera, width: int, height: int, step: float) -> Any:
    """The first hits (rows, columns) of rays about `step` pixels apart."""
    return scene.first_hit(camera.rays(max(1, round(width / step)), max(1, round(height / step))))
