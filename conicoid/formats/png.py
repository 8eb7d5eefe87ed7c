"""PNG pictures: 8 bits of sRGB per channel."""

from __future__ import annotations

import io
import os
from typing import Any

from .atomic import replacing
from .srgb import srgb_bytes

_PERCEPTUAL = b"\x00"  # rendering intent in the sRGB chunk
_LEVEL = 3  # of zlib: half the time of 6, and pictures of smooth bodies are no larger


def png_bytes(pixels: Any) -> bytes:
    """Linear (height, width, 3) pixels as a PNG file; values are cut to [0, 1], NaN is black."""
    from PIL import Image
    from PIL.PngImagePlugin import PngInfo

    tags = PngInfo()
    tags.add(b"sRGB", _PERCEPTUAL)
    stream = io.BytesIO()
    Image.fromarray(srgb_bytes(pixels), "RGB").save(stream, "PNG", pnginfo=tags, compress_level=_LEVEL)
    return stream.getvalue()


def write_png(path: str | os.PathLike[str], pixels: Any) -> None:
    """Write linear (height, width, 3) pixels."""
    with replacing(path) as part:
        part.write_bytes(png_bytes(pixels))
