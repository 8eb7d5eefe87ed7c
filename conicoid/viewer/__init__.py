"""The scene in a browser: a fragment shader traces it there, from the tables that the engine on the CPU reads."""

from __future__ import annotations

from .html import export, page

__all__ = ["export", "page"]
