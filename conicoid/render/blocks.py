"""A picture in a terminal: each character shows two pixels, one over the other, as half a block on a background."""

from __future__ import annotations

from typing import TYPE_CHECKING, Any

import numpy as np

from ..image import Image
from ..shapes.vector import FloatArray

if TYPE_CHECKING:
    from rich.text import Text

UPPER_HALF = "▀"


def shrunk(pixels: FloatArray, columns: int, rows: int) -> FloatArray:
    """(height, width, 3): the means of light over as few equal parts as fit into columns x rows; never enlarged."""
    height, width = pixels.shape[:2]
    share = min(1.0, columns / width, rows / height)
    high, wide = max(1, int(height * share)), max(1, int(width * share))
    y, x = (np.arange(n) * size // n for n, size in ((high, height), (wide, width)))
    total = np.add.reduceat(np.add.reduceat(np.asarray(pixels, float), y, axis=0), x, axis=1)
    sizes = np.diff(np.append(y, height))[:, None] * np.diff(np.append(x, width))
    return np.asarray(total / sizes[..., None])


def half_blocks(image: Image, columns: int, rows: int) -> Text:
    """The picture in at most so many columns and rows of characters."""
    from rich.text import Text

    small = shrunk(image.pixels, columns, 2 * rows)
    shown = np.asarray(Image._of_light(small.astype(np.float32)))
    text = Text(end="", no_wrap=True)
    for top in range(0, len(shown), 2):
        if top:
            text.append("\n")
        for column in range(shown.shape[1]):
            text.append(UPPER_HALF, _style(shown[top : top + 2, column]))
    return text


def _style(pair: Any) -> str:
    """The colours of one character."""
    over, under = ("#" + bytes(pixel.tolist()).hex() for pixel in (pair[0], pair[-1]))
    return f"{over} on {under}" if len(pair) == 2 else over
