"""The colour keys and file suffixes of slices. It needs no NumPy, for the command line."""

from __future__ import annotations

import os
from typing import Any

from ..._util.validation import format_value

BY = ("body", "material")
"""Keys by which slices are coloured and volume fractions are grouped."""
CURVES = (".svg", ".pdf")
PIXELS = (".png", ".exr", ".jpg", ".jpeg", ".webp")
"""Suffixes of files with exact curves, and of files with pixels."""


def check_suffix(suffix: str, path: Any) -> None:
    """Raise ValueError for a suffix that slices are not saved as, ImportError for an .exr without OpenEXR."""
    if suffix not in (*CURVES, *PIXELS):
        raise ValueError(
            f"Slice: slices are saved as {', '.join((*CURVES, *PIXELS))}, got {format_value(os.fspath(path))}"
        )
    if suffix == ".exr":
        from ...materials.image_file import import_openexr

        import_openexr()
