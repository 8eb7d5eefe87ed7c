"""PNG pictures: 8 bits of sRGB per channel."""

from __future__ import annotations

import io
import os
from typing import Any

import numpy as np

from ..shapes.color import srgb_encode
from .atomic import replacing

_PERCEPTUAL = b"\x00"  # rendering intent in the sRGB chunk


def srgb_bytes(pixels: Any) -> Any:
    """Linear pixels as uint8 of sRGB: cut to [0, 1], NaN is black."""
    cut = np.clip(np.nan_to_num(np.asarray(pixels, dtype=np.float64), nan=0.0, posinf=1.0), 0.0, 1.0)
    return np.rint(255 * srgb_encode(cut)).astype(np.uint8)


def png_bytes(pixels: Any) -> bytes:
    """Linear (height, width, 3) pixels as a PNG file; values are cut to [0, 1], NaN is black."""
    from PIL import Image
    from PIL.PngImagePlugin import PngInfo

    tags = PngInfo()
    tags.add(b"sRGB", _PERCEPTUAL)
    stream = io.BytesIO()
    Image.fromarray(srgb_bytes(pixels), "RGB").save(stream, "PNG", pnginfo=tags)
    return stream.getvalue()


def write_png(path: str | os.PathLike[str], pixels: Any) -> None:
    """Write linear (height, width, 3) pixels."""
    with replacing(path) as part:
        part.write_bytes(png_bytes(pixels))
