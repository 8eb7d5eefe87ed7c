"""A scene as the page takes it: the lowered tables, the look, the camera and a list of bodies, as plain JSON."""

from __future__ import annotations

import base64
from typing import Any

import numpy as np
import numpy.typing as npt

from ..engine import tables as table
from ..engine.tables import Tables, length
from ..render.camera import Camera, OrthographicCamera
from ..render.fit import fitting_lights
from ..render.wide_cameras import EquirectangularCamera, FisheyeCamera
from ..scene import Scene
from ..shading.look import Look, lower_look
from ..shading.materials import CHECKER_SPACE, CHECKER_UV, PLAIN
from ..shapes.material import DEFAULT
from ..shapes.repeated_labels import looks_of
from .limits import check
from .written_out import written_out

ASPECT = 4 / 3
_UNUSED = {
    "leaf_bounds",
    "cell_likes",
    "program_row",
    "program_shifts",
    "shifts",
    "body_maps",
    "leaf_items",
    *(name for name in Tables._fields if name.endswith("_limits")),
}
_MOST_NAMED = 400
"""Items that get a row each in the page's list."""


def scene_data(scene: Scene) -> dict[str, Any]:
    """All that the page needs; every array as base64 of little-endian float64 or int32.

    Raises ValueError for a scene beyond what a browser must be able to draw, naming the limit.
    """
    camera = view_of(scene)
    lights = scene.lights or fitting_lights(camera)
    look = look_of(scene, lights)
    low, high = scene.extent
    tables = {name: _array(scene, number) for number, name in enumerate(Tables._fields) if name not in _UNUSED}
    # The engine takes those that share rows, see `engine_data`
    tables |= {name: column.ravel() for name, column in written_out(scene.prepared.lowered.tables).items()}
    check(tables)
    return {
        "tables": {name: _encoded(array) for name, array in tables.items()},
        "look": look_data(look),
        "lights": [_light(record, light) for record, light in zip(look.lights, _directed(lights), strict=True)],
        "camera": camera_data(camera),
        "bounds": [low.tolist(), high.tolist()],
        "items": [_item(scene, i) for i in range(min(len(scene.bodies), _MOST_NAMED))],
        "item_count": len(scene.bodies),
        "body_item": _encoded(scene.lowered.body_item),
    }


def view_of(scene: Scene) -> Camera | OrthographicCamera:
    """The scene's camera, or one that fits; one that sees all around is shown as a pinhole that looks the same way."""
    camera = scene.camera or scene.fitting_camera(ASPECT)
    if isinstance(camera, EquirectangularCamera | FisheyeCamera):
        return Camera(camera.position, camera.look_at, camera.up)
    if not isinstance(camera, Camera | OrthographicCamera):
        raise TypeError(f"view: camera must be a Camera or an OrthographicCamera, got {type(camera).__name__}")
    return camera


def look_of(scene: Scene, lights: Any) -> Look:
    """Materials and lights as records."""
    lowered = scene.lowered
    found, sheets, place_of = looks_of(scene.bodies, lowered.body_item)
    materials = [DEFAULT if material is None else material for material in found]
    return lower_look(materials, sheets, place_of, lights, scene.background, lowered.face_paint)


def camera_data(camera: Camera | OrthographicCamera) -> dict[str, Any]:
    """A camera by its fields."""
    data = {"position": camera.position, "look_at": camera.look_at, "up": camera.up}
    if isinstance(camera, Camera):
        return data | {"field_of_view": camera.field_of_view}
    return data | {"height": camera.height}


def look_data(look: Look) -> dict[str, Any]:
    """Eight rows of four numbers for each material, in the order of viewer/shaders/materials.glsl."""
    rows = look.materials.rows
    packed = np.zeros((len(rows), 8, 4))
    for out, row in zip(packed, rows, strict=True):
        columns = ("color", "second_color", "scale", "specular", "reflectivity", "transparency", "absorption")
        for k, name in enumerate(columns):
            out[k, :3] = row[name]
        numbers = ("pattern", "ambient", "diffuse", "shininess", "half_vector", "fresnel", "index", "transparent")
        for k, name in enumerate(numbers):
            out[k, 3] = row[name] if name != "pattern" or row[name] <= CHECKER_SPACE else PLAIN
    assert (CHECKER_UV, CHECKER_SPACE) == (1, 2), "the shader knows them by these numbers"
    return {
        "materials": _encoded(packed.ravel()),
        "row_of": _encoded(look.materials.row_of),
        "face_row": _encoded(look.materials.face_row),
        "opaque": _encoded(look.materials.opaque),
        "medium": _encoded(look.materials.medium),
        "any_transparent": look.materials.any_transparent,
        "ambient": look.ambient,
        "sky": look.background,
    }


def _directed(lights: Any) -> list[Any]:
    return [light for light in lights if hasattr(light, "position") or hasattr(light, "direction")]


def _light(record: Any, light: Any) -> dict[str, Any]:
    """A light's record; an angle without end becomes null."""
    data: dict[str, Any] = {
        name: record[name].tolist() for name in ("parallel", "position", "axis", "intensity", "fades")
    }
    for name in ("outer", "inner"):
        data[name] = float(record[name]) if np.isfinite(record[name]) else None
    return data | {"radius": float(getattr(light, "radius", 0.0) or 0.0)}


def _item(scene: Scene, number: int) -> dict[str, Any]:
    body = scene.bodies[number]
    return {"name": body.name, "shape": type(body.shape).__name__, "sheet": body.shape.is_sheet}


def _array(scene: Scene, number: int) -> npt.NDArray[Any]:
    """A table from what the kernels take, flat."""
    geometry = scene.geometry
    start, count = int(geometry.places[number]), int(length(geometry, number))
    real = number in _REAL
    flat: npt.NDArray[Any] = geometry.floats if real else geometry.integers
    return flat[start : start + count]


_REAL = {
    table.PLANES, table.SPHERES, table.QUADRICS, table.QUADRIC_FORMS, table.VERTICES, table.BALL_FRAMES,
    table.MAP_ROWS, table.NODE_BOXES, table.EXTENT,
}  # fmt: skip


def _encoded(array: npt.NDArray[Any]) -> dict[str, str]:
    real = array.dtype.kind == "f"
    data = np.ascontiguousarray(array, "<f8" if real else "<i4").tobytes()
    return {"f8" if real else "i4": base64.b64encode(data).decode()}
