"""A transparent sheet to draw on, finer than the picture below it, so that lines and letters are smooth."""

from __future__ import annotations

from collections.abc import Sequence
from decimal import Decimal
from functools import cache, cached_property
from typing import Any

import numpy as np

from ..materials.color import linear_rgb, srgb_decode

_SUPERSAMPLING = 3
Place = Sequence[float]


class Canvas:
    """Drawing in pixels of the picture, from its top left corner."""

    def __init__(self, width: int, height: int) -> None:
        from PIL import Image, ImageDraw

        self.width, self.height = width, height
        self._sheet = Image.new("RGBA", (_SUPERSAMPLING * width, _SUPERSAMPLING * height))
        self._draw = ImageDraw.Draw(self._sheet)

    @cached_property
    def unit(self) -> float:
        """Pixels that stand for one on a picture 480 high: lines and letters grow with large pictures."""
        return max(1.0, min(self.width, self.height) / 480)

    def line(self, places: Sequence[Place], color: str, width: float, opacity: float = 1.0) -> None:
        """A line along some places; places far beside the picture are no harm."""
        ends = [tuple(_SUPERSAMPLING * min(max(c, -1e5), 1e5) for c in place) for place in places]
        self._draw.line(
            ends, (*_bytes(color), round(255 * opacity)), round(_SUPERSAMPLING * width * self.unit), "curve"
        )

    def size_of(self, text: str, size: float) -> tuple[float, float]:
        """Width and height of a text."""
        left, top, right, bottom = self._draw.textbbox((0, 0), text, self._font(size), "mm")
        return (right - left) / _SUPERSAMPLING, (bottom - top) / _SUPERSAMPLING

    def text(self, place: Place, text: str, color: str, size: float) -> None:
        """A text about a place, with a light rim that keeps it legible."""
        x, y = (_SUPERSAMPLING * c for c in place)
        rim, light = round(1.5 * _SUPERSAMPLING * self.unit), (255, 255, 255, 225)
        fill, font = (*_bytes(color), 255), self._font(size)
        self._draw.text((x, y), text, fill, font, "mm", stroke_width=rim, stroke_fill=light)

    def _font(self, size: float) -> Any:
        from PIL import ImageFont

        return ImageFont.load_default(_SUPERSAMPLING * size * self.unit)

    def over(self, pixels: Any) -> Any:
        """Linear pixels with the sheet upon them."""
        drawn = np.asarray(self._sheet).reshape(self.height, _SUPERSAMPLING, self.width, _SUPERSAMPLING, 4)
        opacity = drawn[..., 3:] / 255
        share = opacity.mean(axis=(1, 3))
        light = srgb_decode(np.arange(256) / 255)[drawn[..., :3]]
        color = (light * opacity).mean(axis=(1, 3))
        return np.where(share > 0, pixels * (1 - share) + color, pixels).astype(np.float32)


@cache
def is_in_font(letter: str) -> bool:
    """Whether a letter looks other than one that no font has."""
    from PIL import ImageFont

    font: Any = ImageFont.load_default(20)
    return letter.isascii() or bytes(font.getmask(letter)) != bytes(font.getmask("\U0010ffff"))


def _bytes(color: str) -> tuple[int, int, int]:
    from ..materials.color import srgb_encode

    red, green, blue = (round(255 * float(c)) for c in srgb_encode(linear_rgb(color)))
    return red, green, blue


def round_down_125(length: float) -> float:
    """The largest of 1, 2 and 5 times a power of ten that is at most a length."""
    power = float(f"1e{Decimal(length).adjusted()}")
    return power * next((k for k in (5, 2) if k * power <= length), 1)
