"""GDML's <materials>: names, densities, what they are made of; and which of them are shown."""

from __future__ import annotations

import re
from dataclasses import dataclass
from fractions import Fraction
from typing import Any

from ...materials.material import Material
from ...materials.presets import matte
from ...materials.properties import Properties
from ..importers import palette_color
from ..scene_file.nodes import shorten
from ..xml_tree import XmlElement
from .values import GdmlError, GdmlReader, local_tag, strip_pointer

GAS_DENSITY = 0.01
"""g/cm3: gases are thinner, as vacuum is; all solids and liquids are denser."""
_GASES = {"G4_Galactic": 1e-25, "G4_AIR": 0.00120479, "Galactic": 1e-25}
"""Those of Geant4's own list that stand in many files without a definition."""


@dataclass(frozen=True, eq=False)
class GdmlMaterial:
    """A material of a file, with its place among them."""

    number: int
    name: str
    properties: Properties
    is_thin: bool
    hint: str | None = None

    @property
    def color(self) -> str | None:
        """What the file hints at, else by its number; None for gases and vacuum, which are invisible."""
        return None if self.is_thin else self.hint or palette_color(self.number)

    @property
    def title(self) -> str:
        """A name that none of the same file's has."""
        return self.name if self.hint is None else f"{self.name} {self.hint}"

    @property
    def look(self) -> Material:
        """As bodies have it."""
        if self.is_thin:
            return Material(
                (0.0, 0.0, 0.0), ambient=0.0, diffuse=0.0, transparency=1.0, name=self.name, properties=self.properties
            )
        return matte(self.color or "#000000", name=self.name, properties=self.properties)


MaterialTable = dict[str, GdmlMaterial]


def read_materials(reading: GdmlReader, section: XmlElement, materials: MaterialTable) -> None:
    """All of a section; isotopes and elements are of no use here but in names."""
    for element in reading.each(section.children):
        if local_tag(element) != "material":
            if local_tag(element) not in ("element", "isotope", "property"):
                reading.remark(element, local_tag(element), "is no material that is known, left out")
            continue
        name = element.attributes.get("name", "")
        try:
            name = reading.solved(name, element)
            materials[name] = _material(reading, element, name)
        except GdmlError as mistake:
            reading.report(mistake.element, f"material {name!r}", mistake.message)


def find_material(reading: GdmlReader, materials: MaterialTable, name: str) -> GdmlMaterial | None:
    """A material of the file, or one of Geant4's own list that it only names; None for one that there is not."""
    if name not in materials:
        if not name.startswith("G4_") and name not in _GASES:
            return None
        density = _GASES.get(name)
        known = {} if density is None else {"density": density}
        materials[name] = GdmlMaterial(next(reading.counter), name, Properties(known), density is not None)
    return materials[name]


def _material(reading: GdmlReader, element: XmlElement, name: str) -> GdmlMaterial:
    if not name:
        raise GdmlError(element, "name must be given")
    found: dict[str, Any] = {}
    shares: dict[str, float] = {}
    for child in element.children:
        if child.tag in ("D", "Dref"):
            found["density"] = _density(reading, child)
        elif child.tag in ("fraction", "composite") and "ref" in child.attributes:
            part = strip_pointer(child.attributes["ref"])
            shares[part] = shares.get(part, 0.0) + _float(
                reading.value(child.attributes.get("n", "1"), child, "n"), child
            )
    if shares:
        found["fractions" if element.all("fraction") else "composite"] = shares
    for key in ("formula", "state"):
        if element.attributes.get(key):
            found[key] = element.attributes[key]
    if "Z" in element.attributes:
        found["Z"] = _float(reading.value(element.attributes["Z"], element, "Z"), element)
    is_gas = found.get("state") == "gas" or found.get("density", 1.0) < GAS_DENSITY
    try:
        return GdmlMaterial(next(reading.counter), strip_pointer(name), Properties(found), is_gas)
    except (ValueError, TypeError) as error:
        raise GdmlError(element, str(error)) from None


def _density(reading: GdmlReader, element: XmlElement) -> float:
    """In g/cm3."""
    if element.tag == "Dref":
        value = reading.value(element.attributes.get("ref", ""), element, "ref") * 1000
    else:
        unit = element.attributes.get("unit") or "g/cm3"
        value = reading.value(element.attributes.get("value", ""), element, "value")
        value *= reading.value(unit, element, "unit") * 1000
    if value < 0:
        raise GdmlError(element, f"value must be >= 0, got {float(value):g} g/cm3")
    return _float(value, element)


def _float(value: Fraction, element: XmlElement) -> float:
    try:
        return float(value)
    except OverflowError:
        raise GdmlError(element, "has a number that is too large") from None


# Colours that volumes have as auxiliary information: a custom of several programs, no part of GDML itself.

_COLOR_NAMES = {
    "white": "#ffffff", "gray": "#808080", "grey": "#808080", "black": "#000000", "brown": "#734000", "red": "#ff0000",
    "green": "#00ff00", "blue": "#0000ff", "cyan": "#00ffff", "magenta": "#ff00ff", "yellow": "#ffff00",
}  # fmt: skip
"""Those of Geant4 (G4Colour), with its shares of red, green and blue taken for sRGB."""
_COLOR_CODE = re.compile(r"#([0-9a-fA-F]{6})([0-9a-fA-F]{2})?")
_COLOR_CHANNEL = re.compile(r"\d{1,9}(?:\.\d{0,20})?|\.\d{1,20}", re.ASCII)


def read_color_hint(reading: GdmlReader, volume: XmlElement) -> str | None:
    """#rrggbb of the last <auxiliary auxtype="Color">; None without one, or for a value that is not understood.

    Values are names, #rrggbb or #rrggbbaa, and three or four shares from 0 to 1, with commas and brackets or without.
    """
    found = None
    for child in volume.children:
        if local_tag(child) != "auxiliary" or child.attributes.get("auxtype", "").lower() not in ("color", "colour"):
            continue
        text = child.attributes.get("auxvalue", "").strip()
        color = _parse_color(text)
        where = f"volume {volume.attributes.get('name', '')!r}"
        if color is None:
            reading.remark(child, where, f"has the colour {shorten(text)!r}, which is not understood")
            continue
        found, opacity = color
        if opacity < 1:
            reading.remark(child, where, f"has a colour of opacity {opacity:.3g}, which is not read")
    return found


def _parse_color(text: str) -> tuple[str, float] | None:
    """Colour and opacity."""
    name = _COLOR_NAMES.get(text.lower())
    if name is not None:
        return name, 1.0
    code = _COLOR_CODE.fullmatch(text)
    if code is not None:
        return f"#{code[1].lower()}", int(code[2] or "ff", 16) / 255
    words = text.strip("()").replace(",", " ").split()
    if len(words) not in (3, 4) or not all(_COLOR_CHANNEL.fullmatch(word) for word in words):
        return None
    channels = list(map(float, words))
    if max(channels) > 1:
        return None
    return "#" + "".join(f"{round(255 * channel):02x}" for channel in channels[:3]), (*channels, 1.0)[3]
