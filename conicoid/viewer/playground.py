"""The playground: a page in which a user types a scene and reads the hits, spans and crossings of a ray through it.

Python answers: the process that serves the page, or one in the page itself (`native.playground` makes such a site,
with the wheel of Conicoid for Pyodide). The same functions answer a served page (`playground`) and one that runs Python
itself, in WebAssembly (`in_page`). `quadrics_scene` is the scene of nine quadrics.
"""

from __future__ import annotations

import json
import math
import os
import re
from collections.abc import Callable
from functools import cache
from importlib import resources
from io import TextIOWrapper
from pathlib import Path
from typing import Any

import numpy as np

import conicoid as co

from .._util.files import SceneFileError, open_regular
from .._util.process import fork_safe_rlock
from ..io.scene_file import scene_file
from ..scene.scene import Scene
from .html import MODULES, as_url, asset, embed_json, join_modules, markup, preview_of, shaders
from .scene_data import MISTAKES, explain_pick, pack_scene, pick
from .session import Session

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
    return Scene(parts.bodies, parts.lights, parts.camera, parts.background, parts.domain, unit=parts.unit)


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


# The page, and the processes that answer it

TITLE = "Conicoid playground"
EXAMPLES = "bored", "lens", "quadrics", "grazing", "barrel"
_MARKUP = re.compile(r"\{\{(\w+)\}\}")


@cache
def examples() -> list[dict[str, str]]:
    """Return the first scenes: name, text and a ray for each, all from the first lines of their files."""
    scenes = []
    for name in EXAMPLES:
        text = asset(f"page/examples/{name}.yaml")
        title, ray, *rest = text.splitlines(keepends=True)
        scenes.append(
            {"name": title[2:].strip(), "ray": ray.partition(":")[2].strip(), "text": "".join([title, *rest])}
        )
    return scenes


def first_scene() -> Scene:
    """Return the first of the examples."""
    return scene_of(examples()[0]["text"])


def playground_page(
    scene: Scene, text: str | None, *, served: dict[str, Any] | None = None, python: dict[str, Any] | None = None
) -> str:
    """Return the page as HTML, with a scene and its text; without a text it begins with the first example.

    served: the data for requests to its server. python: the place of the Python that it runs itself.
    """
    data = {
        "title": TITLE,
        "scene": pack_scene(scene),
        "shaders": shaders(),
        "served": served,
        "examples": examples(),
        "text": text,
        "python": python,
    }
    fields = {
        "TITLE": TITLE,
        "MACHINE": "",
        "CONNECT": "'self'",
        "STYLE": asset("page/style.css") + asset("page/typing.css"),
        "MARKUP": asset("page/typing.html") + markup("preview.webp" if served else as_url(preview_of(scene))),
        "DATA": embed_json(data),
        "SCRIPT": join_modules((*MODULES, "brain", "links", "playground")),
    }
    html = _MARKUP.sub(lambda match: fields[match[1]], asset("page/page.html"))
    # The markup and the script are those of a plain page but for these names
    html = html.replace("openPage();", "openPlayground();").replace(
        'class="conicoid"', 'class="conicoid playground"', 1
    )
    # Python in the page runs in a worker
    return html.replace("connect-src", "worker-src 'self'; connect-src", 1)


def worker() -> str:
    """Return the program that runs Python beside the page."""
    return (resources.files(__package__) / "page/worker.js").read_text(encoding="utf-8")


class Playground(Session):
    """The session of a served playground, which begins with the text of a file, or with the first example."""

    def __init__(self, path: Path | None = None) -> None:
        self._text = None
        if path is not None:
            with TextIOWrapper(open_regular(path), "utf-8") as file:
                self._text = file.read()
        place = NO_FILE if path is None else path
        super().__init__(first_scene() if self._text is None else scene_of(self._text, place), TITLE)
        self._typed = TextScenes(place)

    @property
    def calls(self) -> dict[str, Callable[[Any], Any]]:
        """The functions that a page may call, by name."""
        return self._typed.calls

    def page(self) -> str:
        """Return the page as HTML."""
        return playground_page(self._scene, self._text, served={"version": 0})


# --- The nine quadrics, each as its ten coefficients in a box

ZERO = dict.fromkeys(("xx", "yy", "zz", "xy", "yz", "xz", "x", "y", "z", "constant"), 0.0)

# Name, coefficients of f <= 0, colour
NINE: tuple[tuple[str, dict[str, float], str], ...] = (
    ("ellipsoid", {"xx": 1.4, "yy": 2.2, "zz": 1.8, "constant": -1}, "#a62b2b"),
    ("elliptic paraboloid", {"xx": 1.5, "yy": 2.2, "z": -1, "constant": -0.8}, "#c2622d"),
    ("hyperbolic paraboloid", {"xx": 0.9, "yy": -0.9, "z": 1}, "#d29a35"),
    ("hyperboloid of one sheet", {"xx": 3.5, "yy": 5, "zz": -2.6, "constant": -1}, "#6b8f3e"),
    ("hyperboloid of two sheets", {"xx": 9, "yy": 13, "zz": -14, "constant": 1}, "#2f7d5b"),
    ("elliptic cone", {"xx": 1, "yy": 1.5, "zz": -1}, "#2a7f8c"),
    ("elliptic cylinder", {"xx": 1.5, "yy": 3, "constant": -1}, "#2b5f93"),
    ("hyperbolic cylinder", {"xx": 6, "yy": -3, "constant": -1}, "#59468f"),
    ("parabolic cylinder", {"xx": 1, "y": -0.6, "constant": -0.5}, "#8d3c78"),
)
_GAP = 2.6
"""Between the centres of neighbours."""


def quadrics_scene() -> Scene:
    """Return nine bodies, three by three, the first row in front."""
    room = co.Box((-1, -1, -1), (1, 1, 1))
    bodies = []
    for k, (name, coefficients, color) in enumerate(NINE):
        solid = co.Quadric(coefficients=ZERO | coefficients) & room
        place = (_GAP * (k % 3 - 1), _GAP * (k // 3 - 1), 1.0)
        bodies.append(co.Body(solid.translate(place), material=co.lacquer(color), name=name))
    squares = co.Checker("#e6e2d9", "#d3cec3", scale=1.3, space=True)
    floor = co.Body(co.Disc((0, 0, -0.02), (0, 0, 1), 14), material=co.matte(squares), name="floor")
    lights = [co.AmbientLight(0.28), co.DirectionalLight((-0.5, 0.8, -1.1), 0.75)]
    camera = co.Camera((0.8, -11, 8.2), (0, -0.2, 0.7), field_of_view=36)
    return Scene([*bodies, floor], lights, camera, co.Sky((0.35, 0.47, 0.62), (0.82, 0.84, 0.86)))
