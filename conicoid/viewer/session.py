"""The session of a served page: a scene, its file, which is read again when it changes, and edits of numbers.

`numbers_of` lists the numbers of an entry, its parameters; `with_number` returns the scene with one changed.
"""

from __future__ import annotations

import dataclasses
import itertools
import math
import re
import time
from collections.abc import Callable
from pathlib import Path
from typing import Any

from .._util.process import fork_safe_rlock
from .._util.validation import format_value
from ..apps.derivatives.parameters import map_numbers, numbers_of as shape_numbers, replace_checked, replace_unchecked
from ..geometry.bulk import Bulk
from ..geometry.general_quadric import COEFFICIENT_NAMES, Quadric
from ..geometry.shape import Boolean, ClippedSheet
from ..geometry.sheets import Wall
from ..scene.files import load
from ..scene.scene import Scene
from .html import page, preview_of
from .scene_data import explain_pick, pack_scene, pick

MOST = 40
"""The largest number of sliders of one body."""
_SIZES = {
    "radius", "radii", "start_radius", "end_radius", "outer_radius", "slope", "length", "width", "height",
    "A", "E", "H",
}  # fmt: skip
_VECTORS = {"center", "start", "end", "low", "high", "offset", "factors", "axis", "normal"}


def numbers_of(scene: Scene, item: int) -> list[dict[str, Any]]:
    """Return {label, path, value, low, high} for the numbers of an entry of the scene, at most `MOST`."""
    if not 0 <= item < len(scene.bodies):
        raise ValueError(f"numbers: item must be in [0, {len(scene.bodies)}), got {item}")
    if isinstance(scene.bodies[item].shape, Bulk):
        return []
    numbers = []
    for name, value in itertools.islice(zip(*shape_numbers(_with_zeros(scene.bodies[item].shape)), strict=True), MOST):
        words = re.findall(r"[A-Za-z_]+|\d+", name)
        low, high = _range(words, value)
        numbers.append({"label": _label(words), "path": [item, name], "value": value, "low": low, "high": high})
    return numbers


def with_number(scene: Scene, item: int, name: str, value: float) -> Scene:
    """Return the scene with one number of an entry changed. Raise ValueError for an invalid one, KeyError for none."""
    old = scene.bodies[item]
    shape = _with_zeros(old.shape)
    if name not in shape_numbers(shape)[0]:
        raise KeyError(f"edit: there is no number {format_value(name)}")
    # Products are equal floats but other objects: so constructors build all parts anew, without the zeros
    changed = map_numbers(shape, lambda each, number: value if each == name else 1.0 * number, replace_checked)
    return scene._with_entry(item, old, dataclasses.replace(old, shape=changed))


def _with_zeros(part: Any) -> Any:
    """Return a shape, or a field of one, whose quadrics have all coefficients: zeros can be changed as well."""
    if isinstance(part, tuple):
        return tuple(map(_with_zeros, part))
    if isinstance(part, Quadric) and part.coefficients is not None:
        # The constructor drops zeros
        return replace_unchecked(part, {"coefficients": {**dict.fromkeys(COEFFICIENT_NAMES, 0.0), **part.coefficients}})
    if isinstance(part, Boolean | ClippedSheet | Wall):
        return replace_unchecked(
            part, {field.name: _with_zeros(getattr(part, field.name)) for field in dataclasses.fields(part)}
        )
    return part


def _label(words: list[str]) -> str:
    """Return the name of the field with its component: `radii 2`, `center z`."""
    last = words[-2:] if words[-1].isdigit() else words[-1:]
    if last[-1].isdigit() and last[0] in _VECTORS:
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
        item, name = request["path"]
        with self._lock:
            changed = with_number(self._scene, int(item), name, float(request["value"]))
            data = pack_scene(changed)
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
