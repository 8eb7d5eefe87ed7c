"""The numbers of a body, as its scene file would have them, and the scene with one of them changed."""

from __future__ import annotations

import dataclasses
import tempfile
from pathlib import Path
from typing import Any

import numpy as np

from ..files import load
from ..formats.atomic import write_text
from ..formats.data_files import save_array
from ..formats.scene_file import scene_data
from ..formats.yaml_writer import dump
from ..scene import Scene
from ..shapes.bulk import Bulk
from ..shapes.coefficients import NAMES as COEFFICIENTS
from ..shapes.repeated import Repeated

MOST = 40
"""Numbers of one body that get a slider."""
_SIZES = {
    "radius", "radii", "start_radius", "end_radius", "outer_radius", "slope", "length", "width", "height",
    "A", "E", "H",
}  # fmt: skip
Step = str | int


def numbers_of(scene: Scene, item: int) -> list[dict[str, Any]]:
    """{label, path, value, low, high} of the numbers of an entry of the scene, at most `MOST`."""
    if not 0 <= item < len(scene.bodies):
        raise ValueError(f"numbers: item must be in [0, {len(scene.bodies)}), got {item}")
    if isinstance(scene.bodies[item].shape, Bulk):
        return []
    data, place = _data_of(scene, item)
    found: list[dict[str, Any]] = []
    body = data["bodies"][place]
    for part in ("shape", "move"):
        if part in body:
            _collect(data, body[part], ["bodies", item, part], [], found)
    return found[:MOST]


def with_number(scene: Scene, path: list[Step], value: float) -> Scene:
    """The scene with the number at a path of its file's data changed.

    A number in the file's list of bodies is that of one body, and only that one is written and read again.
    Raises ValueError (SceneFileError) where the new number is not possible, KeyError for no such path.
    """
    if path[0] == "bodies":
        entry = int(path[1])
        old = scene.bodies[entry]
        changed = _changed(Scene(old), ["bodies", 0, *path[2:]], value).bodies[0]
        return scene._with_entry(entry, old, dataclasses.replace(old, shape=changed.shape))
    return _changed(scene, path, value)._taking_from(scene)


def _changed(scene: Scene, path: list[Step], value: float) -> Scene:
    """The scene that is read from the file with one number changed."""
    with tempfile.TemporaryDirectory(prefix="conicoid-") as folder:
        file = Path(folder) / "scene.yaml"
        data = _data(scene, file.parent)
        place: Any = data
        for step in path[:-1]:
            place = place[step]
        if isinstance(place[path[-1]], bool) or not isinstance(place[path[-1]], (int, float)):
            raise ValueError(f"edit: there is no number at {path}")
        place[path[-1]] = float(value)
        write_text(file, dump(data))
        return load(file)


def _data_of(scene: Scene, item: int) -> tuple[dict[str, Any], int]:
    """(data of a file with an entry of a scene, where it is there): all, as shapes may be shared; one of many alike."""
    if isinstance(scene.bodies, Repeated):
        data = _data(Scene(scene.bodies[item]), None)
        if "shapes" not in data:
            return data, 0
    return _data(scene, None), item


def _data(scene: Scene, folder: Path | None) -> dict[str, Any]:
    """A scene file's data, its lists copied; large sets of balls go to the folder."""
    count = 0

    def keep(_: str, table: Any) -> str:
        nonlocal count
        count += 1
        name = f"many-{count}.npy"
        if folder is not None:
            save_array(folder / name, table)
        return name

    copied: dict[str, Any] = _copied(scene_data(scene, keep, defaults=True))
    return copied


def _copied(value: Any) -> Any:
    if isinstance(value, dict):
        return {key: _copied(_with_zeros(item) if key == "Quadric" else item) for key, item in value.items()}
    if isinstance(value, np.ndarray):
        return value.tolist()
    return [_copied(item) for item in value] if isinstance(value, (list, tuple)) else value


def _with_zeros(fields: Any) -> Any:
    """A quadric's fields with the coefficients that are zero, which can be changed as well."""
    if not isinstance(fields, dict) or not isinstance(fields.get("coefficients"), dict):
        return fields
    return {**fields, "coefficients": {**dict.fromkeys(COEFFICIENTS, 0.0), **fields["coefficients"]}}


def _collect(data: Any, value: Any, path: list[Step], words: list[str], found: list[dict[str, Any]]) -> None:
    """Walk through lists, mappings and shapes that stand under a name."""
    if isinstance(value, str) and value in data.get("shapes", {}) and path[-1] != "name" and len(path) < 100:
        _collect(data, data["shapes"][value], ["shapes", value], words, found)
    elif isinstance(value, dict):
        for key, item in value.items():
            if key != "material":
                _collect(data, item, [*path, key], [*words, str(key)], found)
    elif isinstance(value, list):
        for k, item in enumerate(value):
            _collect(data, item, [*path, k], [*words, str(k)], found)
    elif isinstance(value, (int, float)) and not isinstance(value, bool) and np.isfinite(value):
        low, high = _range(words, float(value))
        found.append({"label": _label(words), "path": path, "value": value, "low": low, "high": high})


def _label(words: list[str]) -> str:
    """The field's name with its component: `radii 2`, `center z`."""
    last = words[-2:] if words[-1].isdigit() else words[-1:]
    if last[-1].isdigit() and last[0] in {
        "center",
        "start",
        "end",
        "low",
        "high",
        "translate",
        "axis",
        "normal",
        "scale",
    }:
        return f"{last[0]} {'xyz'[int(last[-1]) % 3]}"
    return " ".join(last)


def _range(words: list[str], value: float) -> tuple[float, float]:
    """Where a slider goes: sizes stay above zero, everything else passes through it."""
    reach = max(2.0, 2.0 * abs(value))
    if "degrees" in words or any("angle" in word for word in words):
        return -360.0, 360.0
    if value > 0 and _SIZES & set(words):
        return max(2.0, value) / 100, max(2.0, 3.0 * value)
    return -reach, reach
