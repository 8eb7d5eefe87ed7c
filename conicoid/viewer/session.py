"""What a served page looks at: a scene, and the file it comes from, read again when it changes."""

from __future__ import annotations

from pathlib import Path
from typing import Any

from ..files import load
from ..forks import nested_lock
from ..formats.errors import SceneFileError
from ..scene import Scene
from .html import page, preview_of
from .lowered_data import scene_data
from .numbers import Step, numbers_of, with_number
from .picks import pick

Stamp = tuple[int, int, int]


class Session:
    """One scene, shared by all requests; every method may be called from any thread."""

    def __init__(self, scene: Scene, title: str, path: Path | None = None, select: int | None = None) -> None:
        self._scene, self._title, self._path = scene, title, path
        self._select = select
        self._stamp = _stamp(path)
        self._version = 0
        self._trouble: str | None = None
        self._lock = nested_lock()

    def page(self) -> str:
        """The page as it is now."""
        with self._lock:
            self._refresh()
            served: dict[str, Any] = {"version": self._version if self._trouble is None else -1}
            if self._select is not None:
                served["select"] = self._select
            return page(self._scene, self._title, "preview.webp", served)

    def preview(self) -> bytes:
        """The small picture, a WebP file."""
        with self._lock:
            return preview_of(self._scene)

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
        stamp = _stamp(self._path)
        if stamp == self._stamp:
            return
        self._stamp = stamp
        self._version += 1
        try:
            scene = load(self._path)
            scene_data(scene)
            self._scene, self._trouble = scene, None
        except OSError as error:
            self._trouble = f"{self._path}: {(error.strerror or str(error)).lower()}"
        except ValueError as error:
            self._trouble = str(error)


def _stamp(path: Path | None) -> Stamp | None:
    """What tells one state of a file from another; None where there is none."""
    try:
        found = path.stat() if path is not None else None
    except OSError:
        return None
    return (found.st_mtime_ns, found.st_size, found.st_ino) if found else None
