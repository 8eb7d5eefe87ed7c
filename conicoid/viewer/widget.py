"""The page as a widget in notebooks, through anywidget: Jupyter, VS Code, Colab, marimo."""

from __future__ import annotations

import base64
import json
from functools import cache
from typing import Any

from ..scene import Scene
from ..shapes.validate import integer
from .html import asset, preview_of, script, shaders
from .lowered_data import scene_data

_RENDER = """
export default {
  render({ model, el }) {
    const root = document.createElement("div");
    root.className = "conicoid";
    root.style.height = `${model.get("height")}px`;
    root.innerHTML = MARKUP;
    el.append(root);
    let viewer = null;
    const data = JSON.parse(model.get("data"));
    try { viewer = new Viewer(root, data); } catch (error) { showInstead(root, error.message, data.preview); }
    model.on("change:data", () => viewer?.answered({ scene: JSON.parse(model.get("data")).scene }));
    return () => viewer?.end();
  },
};
"""


def view(scene: Scene, height: int = 480) -> Any:
    """A widget of the scene, `height` pixels high. Raises ImportError where anywidget is not installed."""
    height = integer("view", "height", height, 1, 10_000)
    return _widget_class()(data=json.dumps(_data(scene)), height=height)


def _data(scene: Scene) -> dict[str, Any]:
    preview = "data:image/webp;base64," + base64.b64encode(preview_of(scene)).decode()
    return {"title": "Scene", "scene": scene_data(scene), "shaders": shaders(), "preview": preview, "served": None}


@cache
def _widget_class() -> type[Any]:
    try:
        import anywidget
        import traitlets
    except ImportError:
        raise ImportError("scene.view() needs anywidget: pip install anywidget") from None

    class SceneWidget(anywidget.AnyWidget):
        """A scene to walk around in."""

        _esm = f"{script()}\nconst MARKUP = {json.dumps(asset('page/markup.html'))};\n{_RENDER}"
        _css = asset("page/style.css")
        data = traitlets.Unicode().tag(sync=True)
        height = traitlets.Int(480).tag(sync=True)

    return SceneWidget
