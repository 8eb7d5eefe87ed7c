"""An explanation as a file."""

from __future__ import annotations

import os
from typing import TYPE_CHECKING, Any

from ..formats.atomic import write_text
from ..shapes.validate import path as checked_path
from ..shapes.validate import shown
from .explanation import page_of

if TYPE_CHECKING:
    from .explanation import Explanation


def save(found: Explanation, path: Any) -> None:
    """A page, a drawing or a text, by the ending."""
    name = checked_path("save", path)
    suffix = os.path.splitext(name)[1].lower()
    if suffix == ".html":
        content = page_of("A ray explained", found.html)
    elif suffix == ".svg":
        content = found.svg
    elif suffix == ".txt":
        content = found.text
    else:
        raise ValueError(f"save: path of an explanation must end with .html, .svg or .txt, got {shown(str(path))}")
    write_text(name, content)
