"""Scenes as files of other programs: which formats there are, what may be asked of all, and what they give."""

from __future__ import annotations

from .exported import Exported, Options
from .formats import FORMATS, Format, format_for

__all__ = ["FORMATS", "Exported", "Format", "Options", "format_for"]
