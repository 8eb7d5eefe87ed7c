"""Pictures for mail and pages: JPEG, which loses a little, and WebP, which loses nothing. Both in 8 bits of sRGB."""

from __future__ import annotations

import io
import os
from typing import Any

from .atomic import replacing
from .srgb import srgb_bytes

OPTIONS: dict[str, tuple[str, dict[str, Any]]] = {
    ".jpg": ("JPEG", dict(quality=92, subsampling=0)),
    ".jpeg": ("JPEG", dict(quality=92, subsampling=0)),
    ".webp": ("WEBP", dict(lossless=True)),
}
"""Suffix -> Pillow's format and its options."""


def write_photo(path: str | os.PathLike[str], pixels: Any, suffix: str) -> None:
    """Write linear (height, width, 3) pixels. Raises ValueError for more pixels a side than the format has."""
    from PIL import Image

    kind, options = OPTIONS[suffix]
    stream = io.BytesIO()
    try:
        Image.fromarray(srgb_bytes(pixels), "RGB").save(stream, kind, **options)
    except (KeyError, OSError, ValueError) as error:
        raise ValueError(f"Image: {os.fspath(path)} cannot be written as {kind}: {error}") from None
    with replacing(path) as part:
        part.write_bytes(stream.getvalue())
