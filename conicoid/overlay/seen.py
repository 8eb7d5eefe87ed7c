"""What a camera sees of points in the world."""

from __future__ import annotations

import math
from typing import TYPE_CHECKING, Any

import numpy as np

from ..render.camera import Camera, OrthographicCamera
from ..render.wide_cameras import FisheyeCamera
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
    is_around = not isinstance(camera, Camera | OrthographicCamera)
    front = (points != lens[0]).any(axis=-1) if is_around else depths > 0
    ways = depths[front, None] * lens[3] if isinstance(camera, OrthographicCamera) else points[front] - lens[0]
    result[front] = scene.occluded(points[front] - ways, ways, t_max=_ALMOST) if front.any() else False
    return result


def pixel_sizes(camera: AnyCamera, points: Any, height: int) -> Any:
    """(n,): the length in the world that is a pixel long, where points (n, 3) are."""
    if isinstance(camera, OrthographicCamera):
        return np.full(len(points), camera.height / height)
    lens = camera.lens
    if not isinstance(camera, Camera):
        angle = math.radians(camera.field_of_view if isinstance(camera, FisheyeCamera) else 180.0)
        return lengths(points - lens[0]) * (angle / height)
    return 2 * dot_rows(points - lens[0], lens[3]) * lengths(lens[5]) / height


def grid_of_hits(scene: Scene, camera: AnyCamera, width: int, height: int, step: float) -> Any:
    """The first hits (rows, columns) of rays about `step` pixels apart."""
    return scene.first_hit(camera.rays(max(1, round(width / step)), max(1, round(height / step))))
