"""Write slices as SVG 1.1: an image of the colours, and the outlines above it as curves.

Elliptic arcs and parabolas (quadratic Béziers) are exact. Hyperbolas are cubic Béziers within `OFF` of a pixel.
Coordinates have fifteen digits. Source: https://www.w3.org/TR/SVG11/paths.html
"""

from __future__ import annotations

import base64
import html
import math
from collections.abc import Callable
from typing import Any, Protocol

from ..._util.arrays import FloatArray
from ...io.images.codecs import png_bytes
from ...materials.color import srgb_decode
from .drawing import INK, SliceDrawing
from .outline import Outline

OFF = 1e-6
"""Largest distance of a Bézier from its curve, in pixels."""
_FLAT = 1e5
"""Ellipses with larger half-axes, in pixels, are drawn as Béziers: renderers compute the centres in short floats."""


def svg_text(drawing: SliceDrawing) -> str:
    """Return the contents of the file."""
    width, height = drawing.size
    picture = base64.b64encode(png_bytes(srgb_decode(drawing.painted.pixels / 255))).decode()
    lines = [
        '<?xml version="1.0" encoding="UTF-8"?>',
        f'<svg xmlns="http://www.w3.org/2000/svg" xmlns:xlink="http://www.w3.org/1999/xlink" width="{width}" '
        f'height="{height}" viewBox="0 0 {width} {height}">',
        f'<rect width="{width}" height="{height}" fill="white"/>',
        f'<image width="{drawing.width}" height="{drawing.height}" style="image-rendering:pixelated" '
        f'xlink:href="data:image/png;base64,{picture}"/>',
        f'<clipPath id="window"><rect width="{drawing.width}" height="{drawing.height}"/></clipPath>',
        f'<g clip-path="url(#window)" fill="none" stroke="{_color(INK)}" stroke-width="{_text(drawing.line_width)}" '
        'stroke-linecap="round" stroke-linejoin="round">',
        *(f'<path d="{path_of(drawing, outline)}"/>' for outline in drawing.outlines),
        "</g>",
        f'<g font-family="Helvetica, Arial, sans-serif" font-size="{_text(drawing.letter)}" fill="{_color(INK)}">',
    ]
    side = 1.1 * drawing.letter
    for text, color, left, middle in drawing.rows:
        base = middle + 0.36 * drawing.letter
        lines.append(
            f'<rect x="{_text(left)}" y="{_text(middle - side / 2)}" width="{_text(side)}" height="{_text(side)}" '
            f'fill="{_color(color)}" stroke="#808080" stroke-width="0.5"/>'
            f'<text x="{_text(drawing.text_left)}" y="{_text(base)}">{html.escape(text, quote=False)}</text>'
        )
    return "\n".join([*lines, "</g>", "</svg>", ""])


def _text(number: float) -> str:
    """Return a number in fifteen digits."""
    return f"{float(number):.15g}"


class PixelFrame(Protocol):
    """A frame of pixels that outlines are drawn in."""

    @property
    def scale(self) -> tuple[float, float]:
        """Pixels per unit of length, to the right and up."""
        ...

    def places(self, about: Any) -> FloatArray:
        """Return the pixel coordinates of places about the middle of the window."""
        ...


def path_of(frame: PixelFrame, outline: Outline, off: float = OFF, text: Callable[[float], str] = _text) -> str:
    """Return the path data of an outline: exact, or Béziers at most `off` of a pixel from it. `text` writes numbers."""

    def pair(place: Any) -> str:
        return f"{text(place[0])} {text(place[1])}"

    x, y = frame.scale
    radii, angle = outline.radii, outline.angle
    # Arcs need equal scales across and up: an unequal scale would change the radii and the angle.
    if radii and angle is not None and max(radii) * max(x, y) < _FLAT and abs(x - y) <= 1e-12 * max(x, y):
        # More than half a turn becomes two arcs: an arc of a whole turn has no direction.
        parts = 2 if outline._stop - outline._begin > math.pi else 1
        places = frame.places(outline.points(parts + 1) - outline._origin)
        # y points down, so the angle changes its sign.
        arc = f"A {text(radii[0] * x)} {text(radii[1] * x)} {text(-angle)} 0 0"
        return f"M {pair(places[0])} " + " ".join(f"{arc} {pair(place)}" for place in places[1:])
    cubics = frame.places(outline._cubics(off / max(x, y)))
    begin = f"M {pair(cubics[0, 0])}"
    if outline.kind == "line":
        return f"{begin} L {pair(cubics[-1, 3])}"
    if outline.kind == "parabola":
        middle = 1.5 * cubics[0, 1] - 0.5 * cubics[0, 0]  # control point of the quadratic that equals the cubic
        return f"{begin} Q {pair(middle)} {pair(cubics[0, 3])}"
    return begin + "".join(f" C {pair(b)} {pair(c)} {pair(d)}" for _, b, c, d in cubics)


def _color(color: tuple[int, int, int]) -> str:
    return "#{:02x}{:02x}{:02x}".format(*color)
