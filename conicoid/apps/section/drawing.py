"""The drawing of a slice, whatever the file format: colours by body or material, outlines, and the legend."""

from __future__ import annotations

import colorsys
import math
from dataclasses import dataclass
from typing import TYPE_CHECKING, Any

import numpy as np
import numpy.typing as npt

from ..._util.arrays import FloatArray
from ..._util.text import format_count
from ...io.images.codecs import srgb_bytes
from ...io.images.image import Image
from ...materials.color import srgb_decode
from ...render.overlay import Canvas
from .outline import Outline
from .section_image import material_color

if TYPE_CHECKING:
    from ...prepare.prepared_scene import PreparedScene


Bytes = npt.NDArray[np.uint8]
NOTHING = (255, 255, 255)
"""Colour of pixels without a body."""
OVERLAPPING, UNDEFINED = (255, 0, 0), (255, 0, 255)
_MOST = 40
"""Rows of a legend."""
_LONGEST = 32
"""Characters of a text in a legend."""
_GOLDEN = 0.6180339887498949  # steps of the golden ratio keep hues apart
_NEAR = 12  # steps of a byte by which colours of materials must differ, in all channels together


@dataclass(frozen=True)
class SliceColors:
    """A colour for each pixel, and the legend: (text, colour) from top to bottom."""

    pixels: Bytes
    legend: tuple[tuple[str, tuple[int, int, int]], ...]


def distinct_colors(number: int) -> tuple[int, int, int]:
    """Return a colour for a number: hues far from those of the numbers before, in three shades."""
    hue = (0.58 + number * _GOLDEN) % 1.0
    light, strong = ((0.62, 0.55), (0.75, 0.65), (0.5, 0.5))[number // 3 % 3]
    red, green, blue = (round(255 * c) for c in colorsys.hls_to_rgb(hue, light, strong))
    return red, green, blue


def color_slice(scene: PreparedScene, body: Any, column: Any, by: str) -> SliceColors:
    """Colour pixels by their bodies, or by the columns of their materials; -1 is no body."""
    ids = body if by == "body" else column
    # Only bodies or materials that appear get a colour and a row of the legend.
    shown = np.unique(ids[ids >= 0])
    colors = [distinct_colors(int(k)) for k in shown] if by == "body" else _of_materials(scene, shown)
    table = np.array([*colors, NOTHING], np.uint8)
    pixels = table[np.where(ids < 0, len(shown), np.searchsorted(shown, ids))]
    named = body_name if by == "body" else material_name
    rows = [(named(scene, int(k)), color) for k, color in zip(shown[:_MOST], colors[:_MOST], strict=True)]
    if len(shown) > _MOST:
        rows.append((f"and {format_count(len(shown) - _MOST, 'other', 'others')}", NOTHING))
    return SliceColors(pixels, tuple(rows))


def _of_materials(scene: PreparedScene, shown: Any) -> list[tuple[int, int, int]]:
    """Return the materials' own colours, as in sections; distinct ones if two of them would look the same."""
    materials = [material for material, _ in scene.labels.distinct]
    light = np.array([material_color(materials[int(k)]) for k in shown]).reshape(-1, 1, 3)
    own = srgb_bytes(light).reshape(-1, 3).astype(int)
    # Distances of all pairs of colours; the diagonal is made large, so that it does not count.
    away = np.abs(own[:, None] - own[None]).sum(axis=2) + 1000 * np.eye(len(own), dtype=int)
    if len(own) and away.min() < _NEAR:
        return [distinct_colors(int(k)) for k in shown]
    return [(int(r), int(g), int(b)) for r, g, b in own]


def _short(text: str) -> str:
    """Shorten a text to one line of the legend."""
    plain = " ".join(text.split())
    return plain if len(plain) <= _LONGEST else plain[: _LONGEST - 3] + "..."


def body_name(scene: PreparedScene, number: int) -> str:
    """Return the text for a body in a legend."""
    name = scene.labels.names_of(np.array([number]))[0]
    return f"body {number}" if name is None else _short(str(name))


def material_name(scene: PreparedScene, column: int) -> str:
    """Return the text for a material in a legend."""
    material = scene.labels.distinct[column][0]
    if material is None:
        return "no material"
    return f"material {column}" if material.name is None else _short(material.name)


# --- The layout: sizes in pixels, from the upper left corner

INK = (24, 24, 32)


@dataclass(frozen=True)
class SliceDrawing:
    """Coloured pixels, the outlines over them, and the legend to the right of them."""

    painted: SliceColors
    outlines: tuple[Outline, ...]
    scale: tuple[float, float]
    """Pixels per unit of length, to the right and up."""
    legend: bool

    @property
    def width(self) -> int:
        """The width of the slice, without the legend."""
        return int(self.painted.pixels.shape[1])

    @property
    def height(self) -> int:
        """The height of the slice."""
        return int(self.painted.pixels.shape[0])

    @property
    def unit(self) -> float:
        """The scale of letters and lines: 1 for a slice of 640 pixels, at least 0.75."""
        return max(0.75, max(self.width, self.height) / 640)

    @property
    def line_width(self) -> float:
        """The width of outlines."""
        return 1.1 * self.unit

    @property
    def letter(self) -> float:
        """The height of letters."""
        return 12 * self.unit

    @property
    def rows(self) -> tuple[tuple[str, tuple[int, int, int], float, float], ...]:
        """(text, colour, left, middle) of each row of the legend; a square of 1.1 letters stands before the text."""
        if not self.legend:
            return ()
        # Rows are 1.6 letters apart, and the first is one row below the top.
        step, left = 1.6 * self.letter, self.width + self.letter
        return tuple((text, color, left, (k + 1) * step) for k, (text, color) in enumerate(self.painted.legend))

    @property
    def text_left(self) -> float:
        """The left end of the texts."""
        return self.width + 2.6 * self.letter

    @property
    def size(self) -> tuple[int, int]:
        """Width and height of the whole picture, with the legend."""
        if not self.rows:
            return self.width, self.height
        longest = max(len(text) for text, *_ in self.rows)
        needed = (len(self.rows) + 1) * 1.6 * self.letter
        return round(self.text_left + (0.62 * longest + 1) * self.letter), max(self.height, round(needed))

    def places(self, about: Any) -> FloatArray:
        """Return the pixel coordinates of places about the middle of the window."""
        # y points down in pixels and up in the window.
        x, y = self.scale
        return np.array([0.5 * self.width, 0.5 * self.height]) + about * np.array([x, -y])

    def canvas(self) -> Any:
        """Return the whole picture without lines and letters: bytes (height, width, 3)."""
        across, down = self.size
        canvas = np.full((down, across, 3), NOTHING, np.uint8)
        canvas[: self.height, : self.width] = self.painted.pixels
        return canvas

    def cubics(self, outline: Outline, off: float) -> FloatArray:
        """Return an outline as cubic Béziers (n, 4, 2) in pixels, at most `off` of a pixel from it."""
        return self.places(outline._cubics(off / max(self.scale)))


# --- The drawing as an image: antialiased outlines and the legend over the pixels

_STEP = 2.0  # pixels between places along a curve, about
_MOST_PLACES = 4096  # places along a curve


def rasterize(drawing: SliceDrawing) -> Image:
    """Return the image of a drawing."""
    width, height = drawing.size
    pixels = srgb_decode(np.arange(256) / 255)[drawing.canvas()].astype(np.float32)
    if not (drawing.outlines or drawing.rows):
        return Image._of_light(pixels)
    sheet = Canvas(width, height)
    ink = "#{:02x}{:02x}{:02x}".format(*INK)
    for outline in drawing.outlines:
        rough = drawing.places(outline.points(33) - outline._origin)
        length = float(np.linalg.norm(np.diff(rough, axis=0), axis=1).sum())
        count = 2 if outline.kind == "line" else min(_MOST_PLACES, 9 + math.ceil(length / _STEP))
        places = drawing.places(outline.points(count) - outline._origin)
        sheet.line(places.tolist(), ink, drawing.line_width / sheet.unit)
    _put_legend(sheet, drawing, ink)
    return Image._of_light(sheet.over(pixels))


def _put_legend(sheet: Canvas, drawing: SliceDrawing, ink: str) -> None:
    """Draw the squares and texts of the legend."""
    side, size = 1.1 * drawing.letter, drawing.letter / sheet.unit
    for text, color, left, middle in drawing.rows:
        sheet.line([(left, middle), (left + side, middle)], "#808080", side / sheet.unit)
        # A grey square, and a coloured one inside that leaves an edge.
        inner = [(left + 0.6, middle), (left + side - 0.6, middle)]
        sheet.line(inner, "#{:02x}{:02x}{:02x}".format(*color), (side - 1.2) / sheet.unit)
        width, _ = sheet.size_of(text, size)
        sheet.text((drawing.text_left + width / 2, middle), text, ink, size)
