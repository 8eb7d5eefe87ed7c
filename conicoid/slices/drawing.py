"""What a picture of a slice consists of, whatever it is written as: sizes in pixels, from the upper left corner."""

from __future__ import annotations

from dataclasses import dataclass
from typing import Any

import numpy as np

from ..shapes.vector import FloatArray
from .colors import NOTHING, Painted
from .outline import Outline

INK = (24, 24, 32)


@dataclass(frozen=True)
class Drawing:
    """Coloured pixels, the outlines over them, and the legend beside them."""

    painted: Painted
    outlines: tuple[Outline, ...]
    scale: tuple[float, float]
    """Pixels for a length, to the right and up."""
    legend: bool

    @property
    def width(self) -> int:
        """Pixels of the slice."""
        return int(self.painted.pixels.shape[1])

    @property
    def height(self) -> int:
        """Rows of the slice."""
        return int(self.painted.pixels.shape[0])

    @property
    def unit(self) -> float:
        """Pixels that stand for one on a slice of 640: letters and lines grow with it."""
        return max(0.75, max(self.width, self.height) / 640)

    @property
    def line_width(self) -> float:
        """Of outlines."""
        return 1.1 * self.unit

    @property
    def letter(self) -> float:
        """The height of letters."""
        return 12 * self.unit

    @property
    def rows(self) -> tuple[tuple[str, tuple[int, int, int], float, float], ...]:
        """(text, colour, left, middle) of the legend; each has a square of 1.1 letters before its text."""
        if not self.legend:
            return ()
        step, left = 1.6 * self.letter, self.width + self.letter
        return tuple((text, color, left, (k + 1) * step) for k, (text, color) in enumerate(self.painted.legend))

    @property
    def text_left(self) -> float:
        """Where texts begin."""
        return self.width + 2.6 * self.letter

    @property
    def size(self) -> tuple[int, int]:
        """Width and height of the whole picture."""
        if not self.rows:
            return self.width, self.height
        longest = max(len(text) for text, *_ in self.rows)
        needed = (len(self.rows) + 1) * 1.6 * self.letter
        return round(self.text_left + (0.62 * longest + 1) * self.letter), max(self.height, round(needed))

    def places(self, about: Any) -> FloatArray:
        """Pixels of places about the middle of the window."""
        x, y = self.scale
        places: FloatArray = np.array([0.5 * self.width, 0.5 * self.height]) + about * np.array([x, -y])
        return places

    def canvas(self) -> Any:
        """(height, width, 3) bytes of the whole picture without lines and letters."""
        across, down = self.size
        canvas = np.full((down, across, 3), NOTHING, np.uint8)
        canvas[: self.height, : self.width] = self.painted.pixels
        return canvas

    def cubics(self, outline: Outline, off: float) -> FloatArray:
        """An outline as cubic Béziers (n, 4, 2) in pixels, at most `off` of a pixel from it."""
        return self.places(outline._cubics(off / max(self.scale)))
