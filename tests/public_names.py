"""Every public name: those of the root, and those one level down that are for special purposes."""

from typing import Any

import conicoid as co

PACKAGES = ("checks", "explain", "materials", "measures", "scene", "section")
"""Packages whose names are all made in the same way as those of the root."""

PUBLIC: dict[str, Any] = {name: getattr(co, name) for name in co.__all__}
for _package in PACKAGES:
    PUBLIC |= {name: getattr(getattr(co, _package), name) for name in getattr(co, _package).__all__}
PUBLIC |= {name: getattr(co.optics, name) for name in ("fresnel", "trace_paths")}
