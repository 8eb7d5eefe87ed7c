"""Write slices as PDF 1.4: one page with an image, curves and text.

Pillow writes pixels only. fpdf2 writes curves, but it brings 33 MB with fontTools, and its import takes 0.27 s.

PDF has cubic Béziers only. Parabolas are cubics exactly; ellipses and hyperbolas are approximated within `OFF` of a
pixel. A pixel is a point of the page. Source: ISO 32000-1, 7.5 (file), 8.5 (paths), 8.9.5 (images), 9.6 (the standard
fonts).
"""

from __future__ import annotations

import zlib
from typing import Any

from .drawing import INK, SliceDrawing
from .outline import Outline

OFF = 1e-6
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
    lines += [f"{_color(INK)} RG {_text(drawing.line_width)} w 1 J 1 j"]
    lines += [path_of(drawing, outline) for outline in drawing.outlines]
    lines.append("Q")
    side = 1.1 * drawing.letter
    for text, color, left, middle in drawing.rows:
        y = height - middle
        box = f"{_text(left)} {_text(y - side / 2)} {_text(side)} {_text(side)} re"
        lines.append(f"{_color(color)} rg 0.5 0.5 0.5 RG 0.5 w {box} B")
        at = f"{_text(drawing.text_left)} {_text(y - 0.36 * drawing.letter)}"
        lines.append(f"BT {_color(INK)} rg /Letters {_text(drawing.letter)} Tf {at} Td ({_escaped(text)}) Tj ET")
    return "\n".join(lines)


def path_of(drawing: SliceDrawing, outline: Outline) -> str:
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
    return f"{_text(place[0])} {_text(place[1])}"


def _text(number: float) -> str:
    """Return a number without an exponent, since PDF has none."""
    return f"{float(number):.9f}".rstrip("0").rstrip(".")


def _color(color: tuple[int, int, int]) -> str:
    return " ".join(_text(channel / 255) for channel in color)
