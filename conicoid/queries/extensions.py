"""Names that results and applications resolve at call time, because the code behind them belongs to a higher layer.

Hits, spans and rays save, load and differentiate themselves; `measure(shape)` and others take a shape and need a scene
of it; `scene.view()` opens the viewer. The files and the derivatives lie above `queries`, the class `Scene` lies above
all applications, and the viewer above `Scene`. So the lower module asks this registry by name instead of importing
upwards, and `import conicoid` stays free of whatever a program does not call. `tests/queries/test_extensions.py`
resolves every entry.
"""

from __future__ import annotations

import importlib
from typing import Any

EXTENSIONS = {
    "Scene": "conicoid.scene.scene:Scene",
    "as_scene": "conicoid.scene.scene:as_scene",
    "view": "conicoid.viewer.widget:view",
    "rays.write": "conicoid.io.result_file:write_rays_file",
    "rays.read": "conicoid.io.result_file:read_rays_file",
    "hits.write": "conicoid.io.result_file:write_hits_file",
    "hits.read": "conicoid.io.result_file:read_hits_file",
    "lists.write": "conicoid.io.result_file:write_lists_file",
    "lists.read": "conicoid.io.result_file:read_lists_file",
    "hits.jvp": "conicoid.apps.derivatives.autodiff:hits_jvp",
    "hits.vjp": "conicoid.apps.derivatives.autodiff:hits_vjp",
    "hits.curvature": "conicoid.apps.derivatives.quadric_form:curvature",
    "spans.jvp": "conicoid.apps.derivatives.autodiff:spans_jvp",
    "spans.vjp": "conicoid.apps.derivatives.autodiff:spans_vjp",
}
"""Name -> "module:attribute". `lists` are spans and crossings."""


def extension(name: str) -> Any:
    """Import and return the function or class of an entry of `EXTENSIONS`."""
    module, _, attribute = EXTENSIONS[name].partition(":")
    return getattr(importlib.import_module(module), attribute)
