"""Files of other programs as scenes: which formats there are, what may be asked of all, and what they give."""

from __future__ import annotations

from .formats import FORMATS, Format, format_of
from .imported import Imported, LegendEntry
from .options import Options

__all__ = ["FORMATS", "Format", "Imported", "LegendEntry", "Options", "format_of"]
