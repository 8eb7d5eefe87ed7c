"""The numbers of a body, as its scene file would have them, and the scene with one of them changed."""

from __future__ import annotations

import dataclasses
import math
import tempfile
import time
from collections.abc import Callable
from pathlib import Path
from typing import Any

import numpy as np

from .._util.file_errors import SceneFileError
from .._util.fork_safe_locks import fork_safe_rlock
from .._util.safe_files import write_text
from ..geometry.bulk import Bulk
from ..geometry.instances import InstanceList
from ..geometry.quadric_coefficients import COEFFICIENT_NAMES as COEFFICIENTS
from ..io.data_files import save_array
from ..io.scene_file.scene_file import scene_data
from ..io.scene_file.writer import dump_yaml
from ..scene.files import load
from ..scene.scene import Scene
from .html import page, preview_of
from .picks import explain_pick, pick
from .scene_data import pack_scene

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
    return _changed(scene, path, value)._reuse(scene)


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
        write_text(file, dump_yaml(data))
        return load(file)


def _data_of(scene: Scene, item: int) -> tuple[dict[str, Any], int]:
    """(data of a file with an entry of a scene, where it is there): all, as shapes may be shared; one of many alike."""
    if isinstance(scene.bodies, InstanceList):
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


# What a served page looks at: a scene, and the file it comes from, read again when it changes.

Stamp = tuple[int, int, int, int]
_PAUSE, _SHARE = 2.0, 10.0
"""A file that cannot be loaded is tried again after two seconds, or ten times as long as trying takes, even if it
has not changed: what it refers to may have come."""


class Session:
    """One scene, shared by all requests; every method may be called from any thread."""

    def __init__(
        self,
        scene: Scene,
        title: str,
        path: Path | None = None,
        select: int | None = None,
        stamp: Stamp | None = None,
    ) -> None:
        self._scene, self._title, self._path = scene, title, path
        self._select = select
        self._stamp = stamp or stamp_of(path)  # of the file before the scene was read from it
        self._again = math.inf
        self._version = 0
        self._trouble: str | None = None
        self._lock = fork_safe_rlock()
        self._previews = fork_safe_rlock()
        self._pictured: Scene | None = None
        self._picture = b""

    @property
    def calls(self) -> dict[str, Callable[[Any], Any]]:
        """What a page may ask with a request, by name."""
        return {"pick": self.pick, "why": self.why, "numbers": self.numbers, "edit": self.edit}

    def page(self) -> str:
        """The page as it is now."""
        with self._lock:
            self._refresh()
            served: dict[str, Any] = {"version": self._version if self._trouble is None else -1}
            if self._select is not None:
                served["select"] = self._select
            return page(self._scene, self._title, "preview.webp", served)

    def preview(self) -> bytes:
        """The small picture, a WebP file, made once for each scene; other requests need not wait for it."""
        with self._previews:
            scene = self._scene
            if self._pictured is not scene:
                self._picture, self._pictured = preview_of(scene), scene
            return self._picture

    def version(self, _: Any = None) -> dict[str, Any]:
        """A number that changes when the file does, and what is wrong with it."""
        with self._lock:
            self._refresh()
            return {"version": self._version, "trouble": self._trouble}

    def scene(self, _: Any = None) -> dict[str, Any]:
        """The scene's data."""
        with self._lock:
            return pack_scene(self._scene)

    def pick(self, request: Any) -> dict[str, Any]:
        """What is on a ray."""
        return pick(self._scene, request)

    def why(self, request: Any) -> dict[str, Any]:
        """A ray worked out."""
        return explain_pick(self._scene, request)

    def numbers(self, request: Any) -> list[dict[str, Any]]:
        """The numbers of a body."""
        return numbers_of(self._scene, int(request["item"]))

    def edit(self, request: Any) -> dict[str, Any]:
        """Change a number; the file stays as it is. The new scene's data."""
        path: list[Step] = [step if isinstance(step, str) else int(step) for step in request["path"]]
        with self._lock:
            try:
                changed = with_number(self._scene, path, float(request["value"]))
                data = pack_scene(changed)
            except SceneFileError as error:
                raise ValueError("; ".join(problem.message for problem in error.problems[:3])) from None
            self._scene = changed
            return data

    def _refresh(self) -> None:
        if self._path is None:
            return
        stamp, started = stamp_of(self._path), time.monotonic()
        if stamp == self._stamp and (self._trouble is None or started < self._again):
            return
        trouble = self._load(self._path)
        if stamp != self._stamp or trouble != self._trouble:
            self._version += 1
        self._stamp, self._trouble = stamp, trouble
        now = time.monotonic()
        self._again = now + max(_PAUSE, _SHARE * (now - started))

    def _load(self, path: Path) -> str | None:
        """Take the scene from the file, or say why that is impossible: nothing that goes wrong here is passed over."""
        try:
            scene = load(path)._reuse(self._scene)
            pack_scene(scene)
        except ValueError as error:
            return str(error) or type(error).__name__
        except OSError as error:
            return f"{path}: {(error.strerror or str(error)).lower()}"
        except MemoryError:
            return f"{path}: there is not enough memory for this scene"
        except Exception as error:
            return f"{path}: cannot be shown: {type(error).__name__}: {error}"
        self._scene = scene
        return None


def stamp_of(path: Path | None) -> Stamp | None:
    """What tells one state of a file from another; None where there is none."""
    try:
        found = path.stat() if path is not None else None
    except OSError:
        return None
    return (found.st_mtime_ns, found.st_ctime_ns, found.st_size, found.st_ino) if found else None
