"""Scenes that users type into a page, and rays through them: the part of the playground that computes.

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
"""The number of scenes that are kept."""
NO_FILE = os.path.join(os.devnull, "scene")
"""Stands for the name of a file if a text can refer to no other files."""


class TextScenes:
    """The last scenes that pages have sent, by number, so that several open pages do not disturb each other.

    path: the file of the first text; files that a text names are looked for beside it.
    """

    def __init__(self, path: str | os.PathLike[str] = NO_FILE) -> None:
        self._path = path
        self._scenes: dict[int, Scene] = {}
        self._count = 0
        self._lock = fork_safe_rlock()

    @property
    def calls(self) -> dict[str, Callable[[Any], Any]]:
        """The functions that a page may call, by name."""
        return {"typed": self.typed, "pick": self.pick, "why": self.why}

    def typed(self, request: Any) -> dict[str, Any]:
        """Answer {text} with the data of the scene and its number, or with {problems} and their places."""
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
            for number in list(self._scenes)[:-_MOST_SCENES]:  # the oldest, as dictionaries keep their order
                del self._scenes[number]
            return {"scene": data, "number": self._count, "camera": scene.camera is not None}

    def pick(self, request: Any) -> dict[str, Any]:
        """Answer as `picks.pick`, for the scene of a number, with a normal and error bounds in every row."""
        scene = self._scene(request)
        return with_bounds(scene, request, pick(scene, request))

    def why(self, request: Any) -> dict[str, Any]:
        """Return the explanation of a ray through the scene of a number."""
        return explain_pick(self._scene(request), request)

    def _scene(self, request: Any) -> Scene:
        """Return the scene of a number."""
        with self._lock:
            scene = self._scenes.get(int(request["number"]))
        if scene is None:
            raise ValueError("this scene is no longer known here: change a letter of it, then try again")
        return scene


def scene_of(text: str, path: str | os.PathLike[str] = NO_FILE) -> Scene:
    """Return the scene of a text. Raise SceneFileError with every mistake and its place."""
    parts = scene_file.parse_scene(text, path)
    return Scene(parts.bodies, parts.lights, parts.camera, parts.background, parts.domain)


def with_bounds(scene: Scene, request: Any, answer: dict[str, Any]) -> dict[str, Any]:
    """Return the answer of `pick` with the normal of every crossing and the error bounds of the ends of spans.

    An infinite end has no bound, nor has an end on the section plane or at the begin of the ray.
    """
    if answer["found"] is None:
        return answer
    origin, direction = (np.array(request[name], dtype=np.float64) for name in ("origin", "direction"))
    crossings, errors = scene.crossings(origin, direction), {}
    normals = {}
    for t, body, entering, error, normal in zip(
        crossings.t, crossings.body, crossings.entering, crossings.t_error, crossings.normal, strict=True
    ):
        # Rows of `pick` hold the same floats, so a crossing is found by equality
        errors[float(t), int(body)] = _finite(error)
        normals[float(t), int(body), bool(entering)] = [_finite(v) for v in normal]
    for row in answer["found"]["crossings"]:
        row["normal"] = normals[row["t"], row["body"], row["entering"]]
    for row in answer["found"]["spans"]:
        for end in ("enter", "exit"):
            row[f"{end}_error"] = errors.get((row[end], row["body"]))
    return answer


def _finite(value: float) -> float | None:
    """Return a float, or None for one that is not finite."""
    return float(value) if math.isfinite(value) else None


def in_page() -> Callable[[str, str], str]:
    """Return ask(name, request) for Python that runs in a page: JSON to JSON, {answer} or {error}."""
    calls = TextScenes().calls

    def ask(name: str, request: str) -> str:
        try:
            return json.dumps({"answer": calls[name](json.loads(request))}, allow_nan=False)
        except MISTAKES as error:
            return json.dumps({"error": str(error) or type(error).__name__})

    return ask
