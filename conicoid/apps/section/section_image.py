"""Render the section of a scene by a plane: the colours of the bodies at each point, and dark lines around them."""

from __future__ import annotations

import math
import warnings
from collections.abc import Sequence
from typing import Any

import numpy as np

from ..._util.records import BoxEnds, FloatArray
from ..._util.validation import as_integer, check_number, describe_kind, format_value
from ...geometry.body import Body
from ...geometry.labels import body_material_table
from ...materials.material import Material
from ...materials.texture import mean_color
from ...prepare.prepared_scene import PreparedScene
from ...render.camera import OrthographicCamera
from ...render.options import check_size
from .window import AXES

_FACING = ((-1.0, 0.0, 0.0), (0.0, 1.0, 0.0), (0.0, 0.0, -1.0))
"""View direction of the section across each axis: y, x and x point to the right, z, z and y point up."""
_MARGIN = 1.05
"""Size of a fitting window, in sizes of the scene."""
_VOID_COLOR, _CLEAR = (1.0, 1.0, 1.0), (0.55, 0.75, 0.9)
_LINE = 0.25
"""Factor that darkens pixels on lines."""
_MOST_SAMPLES = 256


def section_pixels(
    scene: PreparedScene,
    listed: Sequence[Body],
    extent: BoxEnds,
    plane: Any,
    at: Any,
    width: Any,
    height: Any,
    samples: Any,
) -> Any:
    """Return the pixels of `Scene.section`: float32 (height, width, 3) of linear light.

    listed: the entries of the scene. plane: "x", "y" or "z", the axis across it, which it crosses at `at`; the window
    fits the scene. Or an `OrthographicCamera`: its window, in the plane through its position and across its view.
    Warn if no solid is cut.
    """
    from ...queries.points import body_at

    width, height = check_size(width, height, "section")
    camera = _camera(plane, at, extent, width / height)
    grid = as_integer(samples)
    if grid is None or not 1 <= grid <= _MOST_SAMPLES:
        raise ValueError(
            f"section: samples must be a whole number from 1 to {_MOST_SAMPLES}, got {format_value(samples)}"
        )
    # A grid of steps x steps samples per pixel, at least `samples` in all.
    steps = math.isqrt(grid - 1) + 1
    # Each table gets one more row at the end, for the body number -1.
    materials, _, place_of = body_material_table(listed, scene.lowered.body_item)
    colors = np.array([material_color(material) for material in materials] + [_VOID_COLOR])
    entries = np.append(place_of, len(materials))
    groups = _groups(materials, entries)
    x, y = ((np.arange(steps * size) + 0.5) / steps for size in (width, height))
    film = np.empty((height, width, 3), np.float32)
    before, is_empty = None, True
    for row in range(height):
        rows = y[row * steps : (row + 1) * steps]
        bodies = body_at(scene, _points(camera, x, rows, width, height), "section")
        film[row] = colors[entries[bodies]].reshape(steps, width, steps, 3).mean(axis=(0, 2))
        pixel_groups, is_empty = groups[bodies], is_empty and not (bodies >= 0).any()
        # Lines are drawn where the group of bodies changes, within the row or from the row above.
        film[row][_meets(pixel_groups, before, steps)] *= _LINE
        before = pixel_groups[-1]
    if is_empty and materials:
        warnings.warn(_nothing_there(plane, at, extent), stacklevel=4)
    return film


def _nothing_there(plane: Any, at: Any, extent: BoxEnds) -> str:
    """Return the warning for a picture that is white throughout."""
    if isinstance(plane, OrthographicCamera):
        return "section: no solid is cut in the window of this camera, so the picture is white"
    low, high = (float(end[AXES.index(plane)]) for end in extent)
    place = f"{plane} = {0 if at is None else at:g}"
    reach = f"bodies reach from {plane} = {low:.6g} to {high:.6g}; sheets have no inside and do not show"
    return f"section: no solid is cut by {place}, so the picture is white; {reach}"


def _camera(plane: Any, at: Any, extent: BoxEnds, aspect: float) -> OrthographicCamera:
    """Return the camera of a section: one that fits the scene across an axis, or the given one."""
    if isinstance(plane, OrthographicCamera):
        if at is not None:
            raise ValueError("section: at goes with an axis; a camera is placed by its position")
        return plane
    if not isinstance(plane, str) or plane not in AXES:
        value = format_value(plane) if isinstance(plane, str) else describe_kind(plane)
        raise ValueError(f"section: plane must be 'x', 'y', 'z' or an OrthographicCamera, got {value}")
    axis, (low, high) = AXES.index(plane), extent
    position = (low + high) / 2
    position[axis] = check_number("section", "at", 0.0 if at is None else at)
    right, up = {0: (1, 2), 1: (0, 2), 2: (0, 1)}[axis]
    # The window fits both ways.
    size = max(float(high[up] - low[up]), float(high[right] - low[right]) / aspect)
    up_vector = (0.0, 1.0, 0.0) if axis == 2 else (0.0, 0.0, 1.0)
    facing = max(1.0, float(np.abs(position).max())) * np.array(_FACING[axis])
    return OrthographicCamera(position, position + facing, up_vector, _MARGIN * size if size > 0 else 1.0)


def _points(camera: OrthographicCamera, x: FloatArray, y: FloatArray, width: int, height: int) -> FloatArray:
    """Return the points (rows, columns, 3) of the plane at coordinates in pixels."""
    lens = camera.lens
    u, v = (2 * x - width) / height, (height - 2 * y) / height
    return lens[0] + u[None, :, None] * lens[1] + v[:, None, None] * lens[2]


def _groups(materials: list[Any], entries: Any) -> Any:
    """Return a group number for each body, and last one for no body.

    Bodies of one material form a group; a body without a material is a group of its own.
    """
    first: dict[Any, int] = {}
    own = [first.setdefault(material, -2 - k) for k, material in enumerate(materials)]
    table = np.array([*own, -1])[entries]
    without = np.array([*(material is None for material in materials), False])[entries]
    return np.where(without, np.arange(len(entries)), table)


def _meets(bodies: Any, before: Any, steps: int) -> Any:
    """Return bool (width,): pixels in which, or at whose left or upper edge, another group of bodies begins."""
    first, middle = bodies[0], bodies[steps // 2]
    across = np.diff(middle, prepend=middle[:1]) != 0
    down = np.zeros_like(across) if before is None else first != before
    down |= (np.diff(bodies, axis=0) != 0).any(axis=0)
    return (across | down).reshape(-1, steps).any(axis=1)


def material_color(material: Any) -> tuple[float, float, float]:
    """Return the colour of a material in a section: its own, pale blue if it is transparent, white for void."""
    material = Material() if material is None else material
    if np.any(np.asarray(material.transparency) != 0):
        is_void = material.refractive_index == 1 and not np.any(np.asarray(material.absorption) != 0)
        return _VOID_COLOR if is_void else _CLEAR
    return mean_color(material.color)
