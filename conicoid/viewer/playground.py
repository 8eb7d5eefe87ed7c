"""The playground: a page in which a scene is typed, and what is on a ray through it is read.

Who answers is Python: the process that serves the page, or one in the page itself (`native.playground` makes such a
site, with Conicoid's wheel for Pyodide).
"""

from __future__ import annotations

import re
from collections.abc import Callable
from functools import cache
from importlib import resources
from pathlib import Path
from typing import Any

from ..scene import Scene
from .html import MODULES, as_url, asset, embedded, joined, markup, preview_of, shaders
from .lowered_data import scene_data
from .session import Session
from .typed import NOWHERE, TypedScenes, scene_of

TITLE = "Conicoid playground"
EXAMPLES = "bored", "lens", "quadrics", "grazing", "barrel"
_MARKUP = re.compile(r"\{\{(\w+)\}\}")


@cache
def examples() -> list[dict[str, str]]:
    """Scenes to begin with: their names, texts, and a ray for each, all from the first lines of their files."""
    found = []
    for name in EXAMPLES:
        text = asset(f"page/examples/{name}.yaml")
        title, ray, *rest = text.splitlines(keepends=True)
        found.append({"name": title[2:].strip(), "ray": ray.partition(":")[2].strip(), "text": "".join([title, *rest])})
    return found


def first_scene() -> Scene:
    """The first of the examples."""
    return scene_of(examples()[0]["text"])


def page(
    scene: Scene, text: str | None, *, served: dict[str, Any] | None = None, python: dict[str, Any] | None = None
) -> str:
    """The page as HTML, with a scene in it and its text; without one it begins with the first example.

    served: what it needs to ask its server. python: where the Python is that it runs itself.
    """
    data = {
        "title": TITLE,
        "scene": scene_data(scene),
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
        "DATA": embedded(data),
        "SCRIPT": joined((*MODULES, "brain", "links", "playground")),
    }
    made = _MARKUP.sub(lambda match: fields[match[1]], asset("page/page.html"))
    made = made.replace("openPage();", "openPlayground();").replace(
        'class="conicoid"', 'class="conicoid playground"', 1
    )
    return made.replace("connect-src", "worker-src 'self'; connect-src", 1)


def worker() -> str:
    """The program that runs Python beside the page."""
    return (resources.files(__package__) / "page/worker.js").read_text(encoding="utf-8")


class Playground(Session):
    """The session of a served playground, which begins with the text of a file, or with the first example."""

    def __init__(self, path: Path | None = None) -> None:
        self._text = None if path is None else path.read_text(encoding="utf-8")
        place = NOWHERE if path is None else path
        super().__init__(first_scene() if self._text is None else scene_of(self._text, place), TITLE)
        self._typed = TypedScenes(place)

    @property
    def calls(self) -> dict[str, Callable[[Any], Any]]:
        return self._typed.calls

    def page(self) -> str:
        return page(self._scene, self._text, served={"version": 0})
