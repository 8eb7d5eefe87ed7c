"""The page as a widget in notebooks, through anywidget: Jupyter, VS Code, Colab, marimo.

A notebook that is saved as HTML shows a page of its own instead, which needs neither a kernel nor the network.
"""

from __future__ import annotations

import json
import os
import sys
from functools import cache
from typing import Any

from .._util.validation import check_integer
from ..scene.scene import Scene
from .html import as_url, asset, markup, page, preview_of, script, shaders
from .scene_data import MISTAKES, explain_pick, pack_scene, pick

MOST_BYTES = 2 << 20
"""The largest page in the file of a notebook, beside the widget; a larger scene leaves its small picture there."""
_RIGHTS = "allow-scripts allow-downloads allow-modals"
"""Permissions of the page in its frame: trace the scene, save a picture, show the numbers of the camera."""


def still_page(scene: Scene, preview: bytes, height: int) -> str:
    """Return HTML of `height` pixels: the page in a frame, over a small picture for readers that remove frames."""
    source = as_url(preview)
    text = "" if scene._prepared.lowered.tables.node_boxes.nbytes > MOST_BYTES else page(scene, "Scene", source)
    if len(text) > MOST_BYTES:  # the engine is the first part to go
        text = page(scene, "Scene", source, carries=False)
    picture = (
        f'<img src="{source}" alt="A picture of the scene" style="position: absolute; height: 100%; max-width: none">'
    )
    if not text or len(text) > MOST_BYTES:
        return f'<div style="position: relative; height: {height}px; overflow: hidden">{picture}</div>'
    frame = (
        f'<iframe sandbox="{_RIGHTS}" title="Scene" srcdoc="{_attribute(text)}" '
        'style="position: absolute; width: 100%; height: 100%; border: 0"></iframe>'
    )
    return f'<div style="position: relative; height: {height}px; overflow: hidden">{picture}{frame}</div>'


def run_by_a_program() -> bool:
    """Return whether a program executes the notebook, as `jupyter nbconvert --execute` does.

    Such programs refuse input and declare so with every cell. Nobody can click there, and a widget would make the HTML
    load its front end from the network. Voilà executes likewise, but then keeps the kernel for its reader.
    """
    if os.environ.get("SERVER_SOFTWARE", "").startswith("voila"):
        return False
    shell: Any = getattr(sys.modules.get("IPython"), "get_ipython", lambda: None)()
    # The request that runs the cell states whether its sender accepts input
    parent = shell.get_parent() if hasattr(shell, "get_parent") else {}
    return (parent.get("content") or {}).get("allow_stdin") is False


def _attribute(text: str) -> str:
    """Return text escaped for an attribute in double quotes."""
    return text.replace("&", "&amp;").replace('"', "&quot;")


# --- The widget

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
    """Return a widget of the scene, `height` pixels high. Raise ImportError without anywidget."""
    height = check_integer("view", "height", height, 1, 10_000)
    widget_class = _widget_class()
    preview = preview_of(scene)
    data = {"title": "Scene", "scene": pack_scene(scene), "shaders": shaders(), "preview": as_url(preview)}
    widget = widget_class(data=json.dumps(data), height=height)
    widget.show(scene, preview)
    return widget


def answer(scene: Scene, message: Any) -> dict[str, Any] | None:
    """Return the answer of the kernel to a message of the page, {id, answer} or {id, error}; None for other messages.

    A page sends {ask, id, request}: `hello` tests whether there is a kernel at all; `pick` and `why` are those of
    scene_data.py.
    """
    if not isinstance(message, dict) or message.get("ask") not in ("hello", *_REQUESTS):
        return None
    try:
        result = _REQUESTS[message["ask"]](scene, message["request"]) if message["ask"] in _REQUESTS else None
    except MISTAKES as error:
        return {"id": message.get("id"), "error": str(error) or type(error).__name__}
    return {"id": message.get("id"), "answer": result}


_REQUESTS = {"pick": pick, "why": explain_pick}


@cache
def _widget_class() -> type[Any]:
    """Return the class of the widget, which exists only with anywidget."""
    try:
        import anywidget
        import traitlets
    except ImportError:
        raise ImportError("scene.view() needs anywidget: pip install 'conicoid[notebook]'") from None

    class SceneWidget(anywidget.AnyWidget):
        """A scene to walk around in."""

        _esm = f"{script()}\nconst MARKUP = {json.dumps(markup('data:,'))};\n{_RENDER}"
        _css = asset("page/style.css")
        data = traitlets.Unicode().tag(sync=True)
        height = traitlets.Int(480).tag(sync=True)

        def open(self) -> None:
            """Register the widget with the front end, if there is one."""
            if not run_by_a_program():
                super().open()

        def show(self, scene: Scene, preview: bytes) -> None:
            """Set the scene that answers, and its small picture."""
            self._scene, self._preview = scene, preview
            self.on_msg(self._reply)

        def _reply(self, _: Any, message: Any, __: Any) -> None:
            """Answer a message of the page."""
            reply = answer(self._scene, message)
            if reply is not None:
                self.send(reply)

        def _repr_mimebundle_(self, **options: Any) -> Any:
            """Return the widget, and a page for readers without widgets: a notebook as HTML."""
            # Readers take the richest kind that they know, so both go into the file
            page = {"text/html": still_page(self._scene, self._preview, self.height)}
            if self.comm is None:
                return page | {"text/plain": repr(self._scene)}, {}
            data, metadata = super()._repr_mimebundle_(**options) or ({}, {})
            return data | page, metadata

    return SceneWidget
