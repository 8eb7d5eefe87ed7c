"""The page as a widget in notebooks, through anywidget: Jupyter, VS Code, Colab, marimo."""

from __future__ import annotations

import json
from functools import cache
from typing import Any

from ..scene import Scene
from ..shapes.validate import integer
from .html import as_url, asset, markup, preview_of, script, shaders
from .lowered_data import scene_data
from .picks import MISTAKES, pick, why
from .still_page import run_by_a_program, still_page

_RENDER = """
export default {
  render({ model, el }) {
    const root = document.createElement("div");
    root.className = "conicoid";
    root.style.height = `${model.get("height")}px`;
    root.innerHTML = MARKUP;
    el.append(root);
    const viewer = opened(root, JSON.parse(model.get("data")), new Kernel(model));
    model.on("change:data", () => viewer?.answered({ scene: JSON.parse(model.get("data")).scene }));
    return () => viewer?.end();
  },
};
"""


def view(scene: Scene, height: int = 480) -> Any:
    """A widget of the scene, `height` pixels high. Raises ImportError where anywidget is not installed."""
    height = integer("view", "height", height, 1, 10_000)
    made = _widget_class()
    preview = preview_of(scene)
    data = {"title": "Scene", "scene": scene_data(scene), "shaders": shaders(), "preview": as_url(preview)}
    widget = made(data=json.dumps(data), height=height)
    widget.show(scene, preview)
    return widget


def answer(scene: Scene, message: Any) -> dict[str, Any] | None:
    """The kernel's answer to what the page asks, {id, answer} or {id, error}; None for messages that are not its own.

    The page asks {ask, id, request}: `hello`, whether there is a kernel at all, or `pick`, `why`, as picks.py has them.
    """
    if not isinstance(message, dict) or message.get("ask") not in ("hello", *_ASKED):
        return None
    try:
        found = _ASKED[message["ask"]](scene, message["request"]) if message["ask"] in _ASKED else None
    except MISTAKES as error:
        return {"id": message.get("id"), "error": str(error) or type(error).__name__}
    return {"id": message.get("id"), "answer": found}


_ASKED = {"pick": pick, "why": why}


@cache
def _widget_class() -> type[Any]:
    try:
        import anywidget
        import traitlets
    except ImportError:
        raise ImportError("scene.view() needs anywidget: pip install anywidget") from None

    class SceneWidget(anywidget.AnyWidget):
        """A scene to walk around in."""

        _esm = f"{script()}\nconst MARKUP = {json.dumps(markup('data:,'))};\n{_RENDER}"
        _css = asset("page/style.css")
        data = traitlets.Unicode().tag(sync=True)
        height = traitlets.Int(480).tag(sync=True)

        def open(self) -> None:
            """Tell the front end of this widget, if there is one."""
            if not run_by_a_program():
                super().open()

        def show(self, scene: Scene, preview: bytes) -> None:
            """The scene that answers, and its small picture."""
            self._scene, self._preview = scene, preview
            self.on_msg(self._asked)

        def _asked(self, _: Any, message: Any, __: Any) -> None:
            found = answer(self._scene, message)
            if found is not None:
                self.send(found)

        def _repr_mimebundle_(self, **options: Any) -> Any:
            """The widget, and a page in itself for where there are no widgets: a notebook as HTML."""
            still = {"text/html": still_page(self._scene, self._preview, self.height)}
            if self.comm is None:
                return still | {"text/plain": repr(self._scene)}, {}
            data, metadata = super()._repr_mimebundle_(**options) or ({}, {})
            return data | still, metadata

    return SceneWidget
