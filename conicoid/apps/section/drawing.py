"""The drawing of a slice: colours by body or material, outlines and the legend, as pixels, SVG and PDF."""

from __future__ import annotations

import base64
import colorsys
import html
import math
import zlib
from collections.abc import Callable
from typing import Any, Protocol

import numpy as np
import numpy.typing as npt

from ..._util.arrays import FloatArray
from ..._util.files import printable
from ..._util.records import dataclass
from ..._util.text import format_count
from ...io.image import Image
from ...io.image_codecs import png_bytes, srgb_bytes
from ...materials.color import srgb_decode
from ...prepare.prepared_scene import PreparedScene
from ...render.overlay import Canvas
from .outline import Outline
from .section_image import material_color

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
    differences = np.abs(own[:, None] - own[None]).sum(axis=2) + 1000 * np.eye(len(own), dtype=int)
    if len(own) and differences.min() < _NEAR:
        return [distinct_colors(int(k)) for k in shown]
    return [(int(r), int(g), int(b)) for r, g, b in own]


def _short(text: str) -> str:
    """Shorten a text to one line of the legend."""
    plain = printable(" ".join(text.split()))
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
        height = (len(self.rows) + 1) * 1.6 * self.letter
        return round(self.text_left + (0.62 * longest + 1) * self.letter), max(self.height, round(height))

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


# Write slices as SVG 1.1: an image of the colours, and the outlines above it as curves.
#
# Elliptic arcs and parabolas (quadratic Béziers) are exact. Hyperbolas are cubic Béziers within `OFF` of a pixel.
# Coordinates have fifteen digits. Source: https://www.w3.org/TR/SVG11/paths.html

OFF = 1e-6
"""Largest distance of a Bézier from its curve, in pixels."""
_FLAT = 1e5
"""Ellipses with larger half-axes, in pixels, are drawn as Béziers: renderers compute the centres in short floats."""
_MOST_TURN = 0.75 * math.pi
"""Longer arcs of ellipses are two commands."""


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
        f'<g clip-path="url(#window)" fill="none" stroke="{_svg_color(INK)}" '
        f'stroke-width="{_svg_text(drawing.line_width)}" stroke-linecap="round" stroke-linejoin="round">',
        *(f'<path d="{svg_path(drawing, outline)}"/>' for outline in drawing.outlines),
        "</g>",
        f'<g font-family="Helvetica, Arial, sans-serif" font-size="{_svg_text(drawing.letter)}" '
        f'fill="{_svg_color(INK)}">',
    ]
    side = 1.1 * drawing.letter
    for text, color, left, middle in drawing.rows:
        base = middle + 0.36 * drawing.letter
        lines.append(
            f'<rect x="{_svg_text(left)}" y="{_svg_text(middle - side / 2)}" width="{_svg_text(side)}" '
            f'height="{_svg_text(side)}" fill="{_svg_color(color)}" stroke="#808080" stroke-width="0.5"/>'
            f'<text x="{_svg_text(drawing.text_left)}" y="{_svg_text(base)}">{html.escape(text, quote=False)}</text>'
        )
    return "\n".join([*lines, "</g>", "</svg>", ""])


def _svg_text(number: float) -> str:
    """Return a number in fifteen digits."""
    return f"{float(number):.15g}"


class PixelFrame(Protocol):
    """A frame of pixels that outlines are drawn in."""

    @property
    def scale(self) -> tuple[float, float]:
        """Pixels per unit of length, to the right and up."""

    def places(self, about: Any) -> FloatArray:
        """Return the pixel coordinates of places about the middle of the window."""


def svg_path(
    frame: PixelFrame,
    outline: Outline,
    off: float = OFF,
    text: Callable[[float], str] = _svg_text,
    is_reversed: bool = False,
) -> str:
    """Return the path data of an outline, from its start or from its end; `text` writes numbers.

    The path is exact, or of Béziers that are at most `off` of a pixel from the outline.
    """

    def pair(place: Any) -> str:
        return f"{text(place[0])} {text(place[1])}"

    x, y = frame.scale
    radii, angle = outline.radii, outline.angle
    order = slice(None, None, -1 if is_reversed else 1)
    # Arcs need equal scales across and up: an unequal scale would change the radii and the angle.
    if (
        radii
        and angle is not None
        and outline._curve.closed
        and max(radii) * max(x, y) < _FLAT
        and abs(x - y) <= 1e-12 * max(x, y)
    ):
        # An arc of a whole turn has no direction; the centre of one of half a turn depends on rounding of its ends.
        parts = 2 if outline._stop - outline._begin > _MOST_TURN else 1
        places = frame.places(outline.points(parts + 1) - outline._origin)[order]
        # y points down, so the angle changes its sign.
        arc = f"A {text(radii[0] * x)} {text(radii[1] * x)} {text(-angle)} 0 {int(is_reversed)}"
        return f"M {pair(places[0])} " + " ".join(f"{arc} {pair(place)}" for place in places[1:])
    cubics = frame.places(outline._cubics(off / max(x, y)))[order, order]
    begin = f"M {pair(cubics[0, 0])}"
    if outline.kind == "line":
        return f"{begin} L {pair(cubics[-1, 3])}"
    if outline.kind == "parabola":
        middle = 1.5 * cubics[0, 1] - 0.5 * cubics[0, 0]  # control point of the quadratic that equals the cubic
        return f"{begin} Q {pair(middle)} {pair(cubics[0, 3])}"
    return begin + "".join(f" C {pair(b)} {pair(c)} {pair(d)}" for _, b, c, d in cubics)


def _svg_color(color: tuple[int, int, int]) -> str:
    return "#{:02x}{:02x}{:02x}".format(*color)


# Write slices as PDF 1.4: one page with an image, curves and text.
#
# Pillow writes pixels only. fpdf2 writes curves, but it brings 33 MB with fontTools, and its import takes 0.27 s.
#
# PDF has cubic Béziers only. Parabolas are cubics exactly; ellipses and hyperbolas are approximated within `OFF` of a
# pixel. A pixel is a point of the page. Source: ISO 32000-1, 7.5 (file), 8.5 (paths), 8.9.5 (images), 9.6 (the standard
# fonts).

"""Largest distance of a Bézier from its curve, in pixels."""


def pdf_bytes(drawing: SliceDrawing) -> bytes:
    """Return the contents of the file."""
    width, height = drawing.size
    image = drawing.painted.pixels
    page = (
        f"<< /Type /Page /Parent 2 0 R /MediaBox [0 0 {width} {height}] /Contents 4 0 R "
        "/Resources << /XObject << /Slice 5 0 R >> /Font << /Letters 6 0 R >> >> >>"
    )
    picture = (
        f"/Type /XObject /Subtype /Image /Width {image.shape[1]} /Height {image.shape[0]} /ColorSpace /DeviceRGB "
        "/BitsPerComponent 8 /Interpolate false"
    )
    font = "<< /Type /Font /Subtype /Type1 /BaseFont /Helvetica /Encoding /WinAnsiEncoding >>"
    return _file([
        b"<< /Type /Catalog /Pages 2 0 R >>",
        b"<< /Type /Pages /Kids [3 0 R] /Count 1 >>",
        page.encode(),
        _stream("", _content(drawing).encode("cp1252", "replace")),
        _stream(picture, image.tobytes()),
        font.encode(),
    ])  # fmt: skip


def _file(objects: list[bytes]) -> bytes:
    """Return a file of objects, numbered from 1, with the cross-reference table of their offsets."""
    # The bytes above 127 mark the file as binary.
    parts, places = [b"%PDF-1.4\n%\xe2\xe3\xcf\xd3\n"], []
    for number, content in enumerate(objects, 1):
        places.append(sum(map(len, parts)))
        parts.append(b"%d 0 obj\n%b\nendobj\n" % (number, content))
    start = sum(map(len, parts))
    table = b"".join(b"%010d 00000 n \n" % place for place in places)
    count = len(objects) + 1
    parts.append(b"xref\n0 %d\n0000000000 65535 f \n%b" % (count, table))
    parts.append(b"trailer\n<< /Size %d /Root 1 0 R >>\nstartxref\n%d\n%%%%EOF\n" % (count, start))
    return b"".join(parts)


def _stream(entries: str, content: bytes) -> bytes:
    """Return a compressed stream object."""
    packed = zlib.compress(content, 6)
    head = f"<< {entries} /Length {len(packed)} /Filter /FlateDecode >>\nstream\n".encode()
    return head + packed + b"\nendstream"


def _content(drawing: SliceDrawing) -> str:
    """Return the operators of the page. y points up in PDF, so rows of pixels are flipped."""
    height = drawing.size[1]
    across, down = drawing.width, drawing.height
    corner = f"0 {height - down}"
    # The image, then the outlines clipped to it.
    lines = [f"q {across} 0 0 {down} {corner} cm /Slice Do Q", "q", f"{corner} {across} {down} re W n"]
    lines += [f"{_pdf_color(INK)} RG {_pdf_text(drawing.line_width)} w 1 J 1 j"]
    lines += [pdf_path(drawing, outline) for outline in drawing.outlines]
    lines.append("Q")
    side = 1.1 * drawing.letter
    for text, color, left, middle in drawing.rows:
        y = height - middle
        box = f"{_pdf_text(left)} {_pdf_text(y - side / 2)} {_pdf_text(side)} {_pdf_text(side)} re"
        lines.append(f"{_pdf_color(color)} rg 0.5 0.5 0.5 RG 0.5 w {box} B")
        at = f"{_pdf_text(drawing.text_left)} {_pdf_text(y - 0.36 * drawing.letter)}"
        lines.append(
            f"BT {_pdf_color(INK)} rg /Letters {_pdf_text(drawing.letter)} Tf {at} Td ({_escaped(text)}) Tj ET"
        )
    return "\n".join(lines)


def pdf_path(drawing: SliceDrawing, outline: Outline) -> str:
    """Return the operators that stroke an outline."""
    cubics = drawing.cubics(outline, OFF)
    # y points up in PDF.
    cubics[..., 1] = drawing.size[1] - cubics[..., 1]
    begin = f"{_pair(cubics[0, 0])} m"
    if outline.kind == "line":
        return f"{begin} {_pair(cubics[-1, 3])} l S"
    pieces = " ".join(f"{_pair(b)} {_pair(c)} {_pair(d)} c" for _, b, c, d in cubics)
    return f"{begin} {pieces} {'s' if outline.is_closed else 'S'}"


def _escaped(text: str) -> str:
    """Escape the characters that delimit strings."""
    return text.replace("\\", "\\\\").replace("(", "\\(").replace(")", "\\)")


def _pair(place: Any) -> str:
    return f"{_pdf_text(place[0])} {_pdf_text(place[1])}"


def _pdf_text(number: float) -> str:
    """Return a number without an exponent, since PDF has none."""
    return f"{float(number):.9f}".rstrip("0").rstrip(".")


def _pdf_color(color: tuple[int, int, int]) -> str:
    return " ".join(_pdf_text(channel / 255) for channel in color)
