"""Render slices as images of pixels, with antialiased outlines and the legend."""

from __future__ import annotations

import math

import numpy as np

from ...io.images.image import Image
from ...materials.color import srgb_decode
from ...render.canvas import Canvas
from .drawing import INK, SliceDrawing

_STEP = 2.0  # pixels between places along a curve, about
_MOST = 4096  # places along a curve


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
        count = 2 if outline.kind == "line" else min(_MOST, 9 + math.ceil(length / _STEP))
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
