"""A picture in a terminal: each character shows two pixels, one over the other, as half a block on a background."""

from __future__ import annotations

from collections.abc import Callable
from typing import TYPE_CHECKING, Any

import numpy as np

from ..shapes.vector import FloatArray
from .srgb import srgb_bytes

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


def half_blocks(pixels: Any, columns: int, rows: int) -> Text:
    """A picture (height, width, 3) of linear light in at most so many columns and rows of characters."""
    from rich.text import Text

    shown = np.asarray(srgb_bytes(shrunk(pixels, columns, 2 * rows).astype(np.float32)))
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


def in_terminal() -> Callable[[Any], None]:
    """What draws pictures in the terminal that stderr is, each over the one before; nothing where it is none."""
    from rich.console import Console
    from rich.control import Control
    from rich.segment import ControlType

    console, above = Console(stderr=True), [0]

    def preview(image: Any) -> None:
        if not console.is_terminal:
            return
        drawn = half_blocks(image._shown, console.width, max(1, console.height - 2))
        if above[0]:
            console.control(Control((ControlType.CURSOR_UP, above[0])))
        console.print(drawn, end="\n")
        above[0] = drawn.plain.count("\n") + 1

    return preview
