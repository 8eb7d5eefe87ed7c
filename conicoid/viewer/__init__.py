"""The scene in a browser, traced there in a fragment shader from the tables that the CPU engine reads."""

from __future__ import annotations

from .html import export, page

__all__ = ["export", "page"]
