"""A scene within a notebook that is saved as HTML: a page in itself, which asks neither a kernel nor the network."""

from __future__ import annotations

import json
import os
import sys
from functools import cache
from typing import Any

from .._util.validation import check_integer
from ..scene.scene import Scene
from .html import as_url, asset, markup, page, preview_of, script, shaders
from .picks import MISTAKES, explain_pick, pick
from .scene_data import pack_scene

MOST_BYTES = 2 << 20
"""Of a page that stands in a notebook's file beside the widget; a larger scene leaves its small picture there."""
_RIGHTS = "allow-scripts allow-downloads allow-modals"
"""What a page may do in there: trace the scene, save a picture, show the camera's numbers."""


def still_page(scene: Scene, preview: bytes, height: int) -> str:
    """HTML of `height` pixels: the scene's page in a frame, and its small picture where frames are taken out."""
    source = as_url(preview)
    text = "" if _is_too_large(scene) else page(scene, "Scene", source)
    if len(text) > MOST_BYTES:
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


def _is_too_large(scene: Scene) -> bool:
    """Are the boxes of its tree alone too much for a page, so that none need be made to see it?"""
    return scene.lowered.tables.node_boxes.nbytes > MOST_BYTES


def run_by_a_program() -> bool:
    """Whether the notebook is executed by a program, as `jupyter nbconvert --execute` does.

    Such programs cannot be asked for input and say so with every cell. Nobody can click there, and a widget would make
    the HTML load its front end from the network. Voilà executes likewise, but then keeps the kernel for its reader.
    """
    if os.environ.get("SERVER_SOFTWARE", "").startswith("voila"):
        return False
    shell: Any = getattr(sys.modules.get("IPython"), "get_ipython", lambda: None)()
    parent = shell.get_parent() if hasattr(shell, "get_parent") else {}
    return (parent.get("content") or {}).get("allow_stdin") is False


def _attribute(text: str) -> str:
    return text.replace("&", "&amp;").replace('"', "&quot;")


# The page as a widget in notebooks, through anywidget: Jupyter, VS Code, Colab, marimo.

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
    height = check_integer("view", "height", height, 1, 10_000)
    made = _widget_class()
    preview = preview_of(scene)
    data = {"title": "Scene", "scene": pack_scene(scene), "shaders": shaders(), "preview": as_url(preview)}
    widget = made(data=json.dumps(data), height=height)
    widget.show(scene, preview)
    return widget


def answer(scene: Scene, message: Any) -> dict[str, Any] | None:
    """The kernel's answer to what the page asks, {id, answer} or {id, error}; None for messages that are not its own.

    The page asks {ask, id, request}: `hello`, whether there is a kernel at all, or `pick`, `why`, as picks.py has them.
    """
    if not isinstance(message, dict) or message.get("ask") not in ("hello", *_REQUESTS):
        return None
    try:
        found = _REQUESTS[message["ask"]](scene, message["request"]) if message["ask"] in _REQUESTS else None
    except MISTAKES as error:
        return {"id": message.get("id"), "error": str(error) or type(error).__name__}
    return {"id": message.get("id"), "answer": found}


_REQUESTS = {"pick": pick, "why": explain_pick}


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
