"""What slices are coloured by and saved as, by name; without NumPy, for the command line."""

from __future__ import annotations

import os
from typing import Any

from ..._util.validation import format_value

BY = ("body", "material")
CURVES = (".svg", ".pdf")
PIXELS = (".png", ".exr", ".jpg", ".jpeg", ".webp")


def check_suffix(suffix: str, path: Any) -> None:
    """ValueError for what slices are not saved as."""
    if suffix not in (*CURVES, *PIXELS):
        raise ValueError(
            f"Slice: slices are saved as {', '.join((*CURVES, *PIXELS))}, got {format_value(os.fspath(path))}"
        )
