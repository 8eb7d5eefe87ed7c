"""What a served page looks at: a scene, and the file it comes from, read again when it changes."""

from __future__ import annotations

import math
import time
from collections.abc import Callable
from pathlib import Path
from typing import Any

from ..files import load
from ..forks import nested_lock
from ..formats.errors import SceneFileError
from ..scene import Scene
from .html import page, preview_of
from .lowered_data import scene_data
from .numbers import Step, numbers_of, with_number
from .picks import pick, why

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
        self._lock = nested_lock()
        self._previews = nested_lock()
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
            return scene_data(self._scene)

    def pick(self, request: Any) -> dict[str, Any]:
        """What is on a ray."""
        return pick(self._scene, request)

    def why(self, request: Any) -> dict[str, Any]:
        """A ray worked out."""
        return why(self._scene, request)

    def numbers(self, request: Any) -> list[dict[str, Any]]:
        """The numbers of a body."""
        return numbers_of(self._scene, int(request["item"]))

    def edit(self, request: Any) -> dict[str, Any]:
        """Change a number; the file stays as it is. The new scene's data."""
        path: list[Step] = [step if isinstance(step, str) else int(step) for step in request["path"]]
        with self._lock:
            try:
                changed = with_number(self._scene, path, float(request["value"]))
                data = scene_data(changed)
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
            scene = load(path)._taking_from(self._scene)
            scene_data(scene)
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
