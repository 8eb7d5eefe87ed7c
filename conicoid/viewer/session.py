"""The session of a served page: a scene, its file, which is read again when it changes, and edits of numbers.

`numbers_of` lists the numbers of an entry as its scene file has them; `with_number` returns the scene with one changed.
"""

from __future__ import annotations

import dataclasses
import math
import tempfile
import time
from collections.abc import Callable
from pathlib import Path
from typing import Any

import numpy as np

from .._util.files import SceneFileError, write_text
from .._util.process import fork_safe_rlock
from ..geometry.bulk import Bulk
from ..geometry.instances import InstanceList
from ..geometry.quadric_classification import COEFFICIENT_NAMES as COEFFICIENTS
from ..io.data_files import save_array
from ..io.scene_file.scene_file import scene_data
from ..io.scene_file.writer import dump_yaml
from ..scene.files import load
from ..scene.scene import Scene
from .html import page, preview_of
from .picks import explain_pick, pick
from .scene_data import pack_scene

MOST = 40
"""The largest number of sliders of one body."""
_SIZES = {
    "radius", "radii", "start_radius", "end_radius", "outer_radius", "slope", "length", "width", "height",
    "A", "E", "H",
}  # fmt: skip
Step = str | int
"""A key or an index in the data of a file."""


def numbers_of(scene: Scene, item: int) -> list[dict[str, Any]]:
    """Return {label, path, value, low, high} for the numbers of an entry of the scene, at most `MOST`."""
    if not 0 <= item < len(scene.bodies):
        raise ValueError(f"numbers: item must be in [0, {len(scene.bodies)}), got {item}")
    if isinstance(scene.bodies[item].shape, Bulk):
        return []
    data, place = _data_of(scene, item)
    numbers: list[dict[str, Any]] = []
    body = data["bodies"][place]
    for part in ("shape", "move"):
        if part in body:
            _collect(data, body[part], ["bodies", item, part], [], numbers)
    return numbers[:MOST]


def with_number(scene: Scene, path: list[Step], value: float) -> Scene:
    """Return the scene with the number at a path of the data of its file changed.

    A number in the list of bodies belongs to one body, and only that one is written and read again. Raises ValueError
    (SceneFileError) for an invalid number, KeyError for an unknown path.
    """
    if path[0] == "bodies":
        entry = int(path[1])
        old = scene.bodies[entry]
        changed = _replace_number(Scene(old), ["bodies", 0, *path[2:]], value).bodies[0]
        return scene._with_entry(entry, old, dataclasses.replace(old, shape=changed.shape))
    return _replace_number(scene, path, value)._reuse(scene)


def _replace_number(scene: Scene, path: list[Step], value: float) -> Scene:
    """Return the scene with one number changed, by way of its file."""
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
    """Return (data of a file with an entry of a scene, the index of the entry there).

    The data are those of all entries, since shapes may be shared; of instances without shared shapes, of the one alone.
    """
    if isinstance(scene.bodies, InstanceList):
        data = _data(Scene(scene.bodies[item]), None)
        if "shapes" not in data:
            return data, 0
    return _data(scene, None), item


def _data(scene: Scene, folder: Path | None) -> dict[str, Any]:
    """Return the data of a scene file, with its lists copied; large sets of balls go to the folder."""
    count = 0

    def keep(_: str, table: Any) -> str:
        nonlocal count
        count += 1
        name = f"many-{count}.npy"
        if folder is not None:
            save_array(folder / name, table)
        return name

    return _copy_data(scene_data(scene, keep, defaults=True))


def _copy_data(value: Any) -> Any:
    """Return a copy of data in which lists can be changed; quadrics have all their coefficients."""
    if isinstance(value, dict):
        return {key: _copy_data(_with_zeros(item) if key == "Quadric" else item) for key, item in value.items()}
    if isinstance(value, np.ndarray):
        return value.tolist()
    return [_copy_data(item) for item in value] if isinstance(value, (list, tuple)) else value


def _with_zeros(fields: Any) -> Any:
    """Return the fields of a quadric with coefficients that are zero, which can be changed as well."""
    if not isinstance(fields, dict) or not isinstance(fields.get("coefficients"), dict):
        return fields
    return {**fields, "coefficients": {**dict.fromkeys(COEFFICIENTS, 0.0), **fields["coefficients"]}}


def _collect(data: Any, value: Any, path: list[Step], words: list[str], numbers: list[dict[str, Any]]) -> None:
    """Collect numbers from lists, mappings and named shapes."""
    if isinstance(value, str) and value in data.get("shapes", {}) and path[-1] != "name" and len(path) < 100:
        _collect(data, data["shapes"][value], ["shapes", value], words, numbers)
    elif isinstance(value, dict):
        for key, item in value.items():
            if key != "material":  # sliders move geometry only
                _collect(data, item, [*path, key], [*words, str(key)], numbers)
    elif isinstance(value, list):
        for k, item in enumerate(value):
            _collect(data, item, [*path, k], [*words, str(k)], numbers)
    elif isinstance(value, (int, float)) and not isinstance(value, bool) and np.isfinite(value):
        low, high = _range(words, float(value))
        numbers.append({"label": _label(words), "path": path, "value": value, "low": low, "high": high})


def _label(words: list[str]) -> str:
    """Return the name of the field with its component: `radii 2`, `center z`."""
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
    """Return the range of a slider: sizes stay positive, all else passes through zero."""
    reach = max(2.0, 2.0 * abs(value))
    if "degrees" in words or any("angle" in word for word in words):
        return -360.0, 360.0
    if value > 0 and _SIZES & set(words):
        return max(2.0, value) / 100, max(2.0, 3.0 * value)
    return -reach, reach


# --- Sessions

Stamp = tuple[int, int, int, int]
_PAUSE, _SHARE = 2.0, 10.0
"""A file that fails to load is tried again after two seconds, or ten times the time of a try, even if it has not
changed: a file that it refers to may have come."""


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
        self._stamp = stamp or stamp_of(path)  # from before the scene was read, so that a change meanwhile counts
        self._next_refresh = math.inf
        self._version = 0  # grows with every change of the file or of its problem
        self._trouble: str | None = None
        self._lock = fork_safe_rlock()
        self._previews = fork_safe_rlock()
        self._pictured: Scene | None = None
        self._picture = b""

    @property
    def calls(self) -> dict[str, Callable[[Any], Any]]:
        """The functions that a page may call with a request, by name."""
        return {"pick": self.pick, "why": self.why, "numbers": self.numbers, "edit": self.edit}

    def page(self) -> str:
        """Return the page in its present state."""
        with self._lock:
            self._refresh()
            served: dict[str, Any] = {"version": self._version if self._trouble is None else -1}
            if self._select is not None:
                served["select"] = self._select
            return page(self._scene, self._title, "preview.webp", served)

    def preview(self) -> bytes:
        """Return the small picture, a WebP file, made once for each scene; other requests do not wait for it."""
        with self._previews:
            scene = self._scene
            if self._pictured is not scene:
                self._picture, self._pictured = preview_of(scene), scene
            return self._picture

    def version(self, _: Any = None) -> dict[str, Any]:
        """Return a number that changes with the file, and the problem of the file, if it has one."""
        with self._lock:
            self._refresh()
            return {"version": self._version, "trouble": self._trouble}

    def scene(self, _: Any = None) -> dict[str, Any]:
        """Return the data of the scene."""
        with self._lock:
            return pack_scene(self._scene)

    def pick(self, request: Any) -> dict[str, Any]:
        """Return the hit, the spans and the crossings on a ray."""
        return pick(self._scene, request)

    def why(self, request: Any) -> dict[str, Any]:
        """Return the explanation of a ray."""
        return explain_pick(self._scene, request)

    def numbers(self, request: Any) -> list[dict[str, Any]]:
        """Return the numbers of a body."""
        return numbers_of(self._scene, int(request["item"]))

    def edit(self, request: Any) -> dict[str, Any]:
        """Change a number, not the file, and return the data of the new scene."""
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
        """Load the file again if it has changed, or if it is time for another try after a failure."""
        if self._path is None:
            return
        stamp, started = stamp_of(self._path), time.monotonic()
        if stamp == self._stamp and (self._trouble is None or started < self._next_refresh):
            return
        trouble = self._load(self._path)
        if stamp != self._stamp or trouble != self._trouble:
            self._version += 1
        self._stamp, self._trouble = stamp, trouble
        now = time.monotonic()
        # Counted from the end of the try, so that a slow file does not keep the session busy
        self._next_refresh = now + max(_PAUSE, _SHARE * (now - started))

    def _load(self, path: Path) -> str | None:
        """Load the scene from the file; return the problem if that fails, whatever the error."""
        try:
            scene = load(path)._reuse(self._scene)
            pack_scene(scene)
        except ValueError as error:
            return str(error) or type(error).__name__
        except OSError as error:
            return f"{path}: {(error.strerror or str(error)).lower()}"
        except MemoryError:
            return f"{path}: there is not enough memory for this scene"
        except Exception as error:  # no error may pass unreported
            return f"{path}: cannot be shown: {type(error).__name__}: {error}"
        self._scene = scene
        return None


def stamp_of(path: Path | None) -> Stamp | None:
    """Return times, size and inode of a file, which differ between its states; None without a file."""
    try:
        status = path.stat() if path is not None else None
    except OSError:
        return None
    return (status.st_mtime_ns, status.st_ctime_ns, status.st_size, status.st_ino) if status else None
