"""Colours: linear light inside, sRGB in texts and images.

A colour is three numbers of linear light (Rec. 709 primaries), or a text: "#rrggbb", "#rgb" or a CSS name such as
"steelblue". A text is sRGB, decoded by IEC 61966-2-1.
"""

from __future__ import annotations

from collections.abc import Sequence
from typing import Any, TypeAlias

import numpy as np

from .._util.arrays import FloatArray, Vector
from .._util.text import near_name
from .._util.validation import check_number, check_numbers, format_value
from ..numerics.portable_math import odd_root

Color: TypeAlias = Vector | str
"""Linear (red, green, blue), or a text in sRGB."""
Amount: TypeAlias = float | Vector | str
"""One number for all channels, or a colour."""

_HEX = "0123456789abcdefABCDEF"
BYTE = 255
BRIGHT = 30.0
"""Times white: brighter light would make a nearly black body white."""
_EXPECTED = "three linear numbers, '#rrggbb' or a CSS colour name"


def srgb_decode(encoded: Any) -> FloatArray:
    """Return linear light of sRGB values in [0, 1] (IEC 61966-2-1), any shape."""
    c = np.asarray(encoded, dtype=np.float64)
    # Both branches are computed: the maximum keeps the base of the unused power positive.
    return np.where(c <= 0.04045, c / 12.92, _power_decode((np.maximum(c, 0.04045) + 0.055) / 1.055))


def srgb_encode(linear: Any) -> FloatArray:
    """Return sRGB values of linear light in [0, 1] (IEC 61966-2-1), any shape."""
    c = np.asarray(linear, dtype=np.float64)
    return np.where(c <= 0.0031308, 12.92 * c, 1.055 * _power_encode(np.maximum(c, 0.0031308)) - 0.055)


def _power_decode(c: FloatArray) -> FloatArray:
    """Return c^2.4, without NumPy's powers: they depend on the C library or the processor."""
    root = odd_root(c, 5)
    return c * c * (root * root)


def _power_encode(c: FloatArray) -> FloatArray:
    """Return c^(1 / 2.4) = c^(1/4 + 1/6)."""
    root = np.sqrt(c)
    return np.sqrt(root) * odd_root(root, 3)


def linear_rgb(color: Color, owner: str = "color", field: str = "value") -> Vector:
    """Return the three linear numbers of a colour."""
    if isinstance(color, str):
        r, g, b = srgb_decode([channel / 255 for channel in _parse_bytes(owner, field, color)]).tolist()
    else:
        r, g, b = check_numbers(owner, field, color, 3)
    return r, g, b


def _parse_bytes(owner: str, field: str, text: str) -> tuple[int, int, int]:
    """Return red, green and blue, 0 to 255, of "#rgb", "#rrggbb" or a CSS name."""
    if text.startswith("#") and len(text) in (4, 7) and all(digit in _HEX for digit in text[1:]):
        red, green, blue = bytes.fromhex(text[1:] if len(text) == 7 else "".join(2 * digit for digit in text[1:]))
        return red, green, blue
    from PIL import ImageColor

    # The lookup comes first, as `getrgb` accepts more forms than CSS names.
    if text.lower() not in ImageColor.colormap:
        raise ValueError(f"{owner}: {field} must be {_EXPECTED}, got {format_value(text)}{near_color(text)}")
    red, green, blue = ImageColor.getrgb(text)[:3]
    return red, green, blue


def near_color(text: str) -> str:
    """Return the name of a colour that was probably meant in brackets; "" if there is none."""
    from PIL import ImageColor

    return near_name(text, ImageColor.colormap)


def check_color(owner: str, field: str, value: Any, *, most: float = 1.0) -> Color:
    """Return a colour as it was written: the text, or a tuple of three floats in [0, most]."""
    if isinstance(value, str):
        linear_rgb(value, owner, field)
        return value
    if isinstance(value, int | float | np.number) and not isinstance(value, bool):
        raise ValueError(f"{owner}: {field} must be 3 numbers, got the number {format_value(value)}")
    rgb = check_numbers(owner, field, value, 3)
    for i, channel in enumerate(rgb):
        _check_range(owner, f"{field}[{i}]", channel, most)
    return rgb[0], rgb[1], rgb[2]


def look_like_bytes(rgb: Sequence[float], bright: float = 1.0) -> bool:
    """Return whether the numbers of a colour are most likely bytes: whole, 0 to 255, and one above `bright`."""
    return bright < max(rgb) <= BYTE and min(rgb) >= 0 and all(channel.is_integer() for channel in rgb)


def check_amount(owner: str, field: str, value: Any, *, most: float = 1.0) -> Amount:
    """Return one float in [0, most], or a colour."""
    if isinstance(value, str) or hasattr(value, "__len__"):
        return check_color(owner, field, value, most=most)
    return _check_range(owner, field, check_number(owner, field, value), most)


def amount_rgb(amount: Amount) -> Vector:
    """Return three linear numbers of a checked amount."""
    if isinstance(amount, (int, float)):
        return float(amount), float(amount), float(amount)
    return linear_rgb(amount)


def _check_range(owner: str, field: str, value: float, most: float) -> float:
    """Return a number in [0, most]."""
    if not 0 <= value <= most:
        expected = f"in [0, {most:g}]" if most < float("inf") else ">= 0"
        raise ValueError(f"{owner}: {field} must be {expected}, got {value}")
    return value
