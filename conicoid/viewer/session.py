"""The session of a served page: a scene, its file, which is read again when it changes, and edits of numbers.

`numbers_of` lists the numbers of an entry, its parameters; `with_number` returns the scene with one changed.
"""

from __future__ import annotations

import dataclasses
import itertools
import json
import math
import os
import re
import time
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
from .._util.validation import format_value
from ..apps.derivatives.parameters import map_numbers, numbers_of as shape_numbers, replace_checked, replace_unchecked
from ..geometry.bulk import Bulk
from ..geometry.general_quadric import COEFFICIENT_NAMES, Quadric
from ..geometry.shape import Boolean, ClippedSheet
from ..geometry.sheets import Wall
from ..io.scene_file import scene_file
from ..scene.files import load
from ..scene.scene import Scene
from .html import MODULES, as_url, asset, embed_json, join_modules, markup, page, preview_of, shaders
from .scene_data import MISTAKES, explain_pick, pack_scene, pick

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


# The playground: a page in which a user types a scene and reads the hits, spans and crossings of a ray through it.
#
# Python answers: the process that serves the page, or one in the page itself (`native.playground` makes such a site,
# with the wheel of Conicoid for Pyodide). The same functions answer a served page (`playground`) and one that runs
# Python itself, in WebAssembly (`in_page`). `quadrics_scene` is the scene of nine quadrics.

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
