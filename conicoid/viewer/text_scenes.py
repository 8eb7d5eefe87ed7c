"""Scenes that are typed into a page, and what is on a ray through them: the part of the playground that computes.

The same functions answer a served page (`playground`) and one that runs Python itself, in WebAssembly (`in_page`).
"""

from __future__ import annotations

import json
import math
import os
from collections.abc import Callable
from typing import Any

import numpy as np

from .._util.file_errors import SceneFileError
from .._util.fork_safe_locks import fork_safe_rlock
from ..io.scene_file import scene_file
from ..scene.scene import Scene
from .picks import MISTAKES, explain_pick, pick
from .scene_data import pack_scene

_MOST_SCENES = 16
NO_FILE = os.path.join(os.devnull, "scene")
"""In place of a file's name, where a typed scene can refer to no others."""


class TextScenes:
    """The last scenes that pages have typed, by number: pages that are open at once do not disturb each other.

    path: of the file that they began as; others that it names are looked for beside it.
    """

    def __init__(self, path: str | os.PathLike[str] = NO_FILE) -> None:
        self._path = path
        self._scenes: dict[int, Scene] = {}
        self._count = 0
        self._lock = fork_safe_rlock()

    @property
    def calls(self) -> dict[str, Callable[[Any], Any]]:
        """What a page may ask, by name."""
        return {"typed": self.typed, "pick": self.pick, "why": self.why}

    def typed(self, request: Any) -> dict[str, Any]:
        """The answer to {text}: the scene as the page takes it and its number, or {problems}, with their places."""
        try:
            scene = scene_of(str(request["text"]), self._path)
            data = pack_scene(scene)
        except SceneFileError as error:
            return {"problems": [vars(problem) for problem in error.problems[:50]], "count": len(error.problems)}
        except (ValueError, MemoryError, RecursionError) as error:
            problem = {"line": 0, "column": 0, "where": "", "message": str(error) or type(error).__name__}
            return {"problems": [problem], "count": 1}
        with self._lock:
            self._count += 1
            self._scenes[self._count] = scene
            for number in list(self._scenes)[:-_MOST_SCENES]:
                del self._scenes[number]
            return {"scene": data, "number": self._count, "camera": scene.camera is not None}

    def pick(self, request: Any) -> dict[str, Any]:
        """What is on a ray through the scene of a number: `picks.pick`, with a normal and bounds in every row."""
        scene = self._scene(request)
        return with_bounds(scene, request, pick(scene, request))

    def why(self, request: Any) -> dict[str, Any]:
        """A ray through the scene of a number, worked out."""
        return explain_pick(self._scene(request), request)

    def _scene(self, request: Any) -> Scene:
        with self._lock:
            scene = self._scenes.get(int(request["number"]))
        if scene is None:
            raise ValueError("this scene is no longer known here; change a letter of it, and ask again")
        return scene


def scene_of(text: str, path: str | os.PathLike[str] = NO_FILE) -> Scene:
    """The scene that a text says. Raises SceneFileError with every mistake, and where it is."""
    parts = scene_file.parse_scene(text, path)
    return Scene(parts.bodies, parts.lights, parts.camera, parts.background, parts.domain)


def with_bounds(scene: Scene, request: Any, answer: dict[str, Any]) -> dict[str, Any]:
    """The answer of `pick` with the normal of every crossing, and how far the ends of spans may be from the exact ones.

    An end that the section plane or the ray's begin makes has no bound, and neither has one without end.
    """
    if answer["found"] is None:
        return answer
    origin, direction = (np.array(request[name], dtype=np.float64) for name in ("origin", "direction"))
    crossings, errors = scene.crossings(origin, direction), {}
    normals = {}
    for t, body, entering, error, normal in zip(
        crossings.t, crossings.body, crossings.entering, crossings.t_error, crossings.normal, strict=True
    ):
        errors[float(t), int(body)] = _finite(error)
        normals[float(t), int(body), bool(entering)] = [_finite(v) for v in normal]
    for row in answer["found"]["crossings"]:
        row["normal"] = normals[row["t"], row["body"], row["entering"]]
    for row in answer["found"]["spans"]:
        for end in ("enter", "exit"):
            row[f"{end}_error"] = errors.get((row[end], row["body"]))
    return answer


def _finite(value: float) -> float | None:
    return float(value) if math.isfinite(value) else None


def in_page() -> Callable[[str, str], str]:
    """For Python that runs in a page itself: ask(name, request) in JSON, {answer} or {error}."""
    calls = TextScenes().calls

    def ask(name: str, request: str) -> str:
        try:
            return json.dumps({"answer": calls[name](json.loads(request))}, allow_nan=False)
        except MISTAKES as error:
            return json.dumps({"error": str(error) or type(error).__name__})

    return ask
