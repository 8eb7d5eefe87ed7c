"""Colours that volumes have as auxiliary information: a custom of several programs, no part of GDML itself."""

from __future__ import annotations

import re

from ..nodes import shortened
from ..openmc.xml_tree import Element
from .reading import Reading, local

_NAMES = {
    "white": "#ffffff", "gray": "#808080", "grey": "#808080", "black": "#000000", "brown": "#734000", "red": "#ff0000",
    "green": "#00ff00", "blue": "#0000ff", "cyan": "#00ffff", "magenta": "#ff00ff", "yellow": "#ffff00",
}  # fmt: skip
"""Those of Geant4 (G4Colour), with its shares of red, green and blue taken for sRGB."""
_CODE = re.compile(r"#([0-9a-fA-F]{6})([0-9a-fA-F]{2})?")
_CHANNEL = re.compile(r"\d{1,9}(?:\.\d{0,20})?|\.\d{1,20}", re.ASCII)


def hint_of(reading: Reading, volume: Element) -> str | None:
    """#rrggbb of the last <auxiliary auxtype="Color">; None without one, or for a value that is not understood.

    Values are names, #rrggbb or #rrggbbaa, and three or four shares from 0 to 1, with commas and brackets or without.
    """
    found = None
    for child in volume.children:
        if local(child) != "auxiliary" or child.attributes.get("auxtype", "").lower() not in ("color", "colour"):
            continue
        text = child.attributes.get("auxvalue", "").strip()
        color = _read(text)
        where = f"volume {volume.attributes.get('name', '')!r}"
        if color is None:
            reading.remark(child, where, f"has the colour {shortened(text)!r}, which is not understood")
            continue
        found, opacity = color
        if opacity < 1:
            reading.remark(child, where, f"has a colour of opacity {opacity:.3g}, which is not read")
    return found


def _read(text: str) -> tuple[str, float] | None:
    """Colour and opacity."""
    name = _NAMES.get(text.lower())
    if name is not None:
        return name, 1.0
    code = _CODE.fullmatch(text)
    if code is not None:
        return f"#{code[1].lower()}", int(code[2] or "ff", 16) / 255
    words = text.strip("()").replace(",", " ").split()
    if len(words) not in (3, 4) or not all(_CHANNEL.fullmatch(word) for word in words):
        return None
    channels = list(map(float, words))
    if max(channels) > 1:
        return None
    return "#" + "".join(f"{round(255 * channel):02x}" for channel in channels[:3]), (*channels, 1.0)[3]
