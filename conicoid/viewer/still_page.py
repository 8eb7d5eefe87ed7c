"""A scene within a notebook that is saved as HTML: a page in itself, which asks neither a kernel nor the network."""

from __future__ import annotations

import os
import sys
from typing import Any

from ..scene import Scene
from .html import as_url, page

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
