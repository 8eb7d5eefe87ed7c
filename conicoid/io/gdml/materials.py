"""The <materials> section of a GDML file, and the colours of materials.

Materials have a name, a density and a composition. Gases and vacuum are invisible; other materials get the colour that
a volume hints at, or a palette colour by their number.
"""

from __future__ import annotations

import re
from collections.abc import MutableMapping
from fractions import Fraction
from typing import Any

from ..._util.records import dataclass
from ...materials.material import Material, Properties
from ...materials.presets import matte
from ..importers import palette_color
from ..scene_file.nodes import shorten
from ..xml_tree import XmlElement
from .values import GdmlError, GdmlReader, local_tag, strip_pointer

GAS_DENSITY = 0.01
"""Density in g/cm3 that gases and vacuum do not reach and that all solids and liquids exceed."""
_GASES = {"G4_Galactic": 1e-25, "G4_AIR": 0.00120479, "Galactic": 1e-25}
"""Densities in g/cm3 of gases of Geant4's own list, which many files use without a definition."""


@dataclass(frozen=True, eq=False)
class GdmlMaterial:
    """A material of a file; `number` counts them, `is_thin` is True for gases and vacuum, `hint` is a colour."""

    number: int
    name: str
    properties: Properties
    is_thin: bool
    hint: str | None = None

    @property
    def color(self) -> str | None:
        """The colour that the file hints at, or a palette colour by number; None for gases and vacuum."""
        return None if self.is_thin else self.hint or palette_color(self.number)

    @property
    def title(self) -> str:
        """A name that is unique in the file: the same material in another colour has another title."""
        return self.name if self.hint is None else f"{self.name} {self.hint}"

    @property
    def look(self) -> Material:
        """The material of bodies in the scene."""
        if self.is_thin:
            return Material(
                (0.0, 0.0, 0.0), ambient=0.0, diffuse=0.0, transparency=1.0, name=self.name, properties=self.properties
            )
        return matte(self.color or "#000000", name=self.name, properties=self.properties)


MaterialTable = MutableMapping[str, GdmlMaterial]


def read_materials(reading: GdmlReader, section: XmlElement, materials: MaterialTable) -> None:
    """Read a section into `materials`; errors are reported. Isotopes and elements are not needed and are skipped."""
    for element in reading.each(section.children):
        if local_tag(element) != "material":
            if local_tag(element) not in ("element", "isotope", "property"):
                reading.remark(element, local_tag(element), "is no material that is known, left out")
            continue
        name = element.attributes.get("name", "")
        try:
            name = reading.resolve_indices(name, element)
            materials[name] = _material(reading, element, name)
        except GdmlError as mistake:
            reading.report(mistake.element, f"material {name!r}", mistake.message)


def find_material(reading: GdmlReader, materials: MaterialTable, name: str) -> GdmlMaterial | None:
    """Return a material of the file or of Geant4's own list; None for an unknown name.

    A material of Geant4's list that the file uses without defining it is added to `materials`.
    """
    if name not in materials:
        # Geant4 builds materials of its list on demand, so files use them without a definition
        if not name.startswith("G4_") and name not in _GASES:
            return None
        density = _GASES.get(name)
        # Of the list only the gases are known here: they decide what is invisible
        properties = {} if density is None else {"density": density}
        materials[name] = GdmlMaterial(next(reading.counter), name, Properties(properties), density is not None)
    return materials[name]


def _material(reading: GdmlReader, element: XmlElement, name: str) -> GdmlMaterial:
    if not name:
        raise GdmlError(element, "name must be given")
    properties: dict[str, Any] = {}
    shares: dict[str, float] = {}
    for child in element.children:
        if child.tag in ("D", "Dref"):
            properties["density"] = _density(reading, child)
        elif child.tag in ("fraction", "composite") and "ref" in child.attributes:
            # An element may be listed more than once; its shares add up
            part = strip_pointer(child.attributes["ref"])
            shares[part] = shares.get(part, 0.0) + _float(
                reading.value(child.attributes.get("n", "1"), child, "n"), child
            )
    if shares:
        properties["fractions" if element.all("fraction") else "composite"] = shares
    for key in ("formula", "state"):
        if element.attributes.get(key):
            properties[key] = element.attributes[key]
    if "Z" in element.attributes:
        properties["Z"] = _float(reading.value(element.attributes["Z"], element, "Z"), element)
    # A file need not have `state`, so the density decides as well
    is_gas = properties.get("state") == "gas" or properties.get("density", 1.0) < GAS_DENSITY
    try:
        return GdmlMaterial(next(reading.counter), strip_pointer(name), Properties(properties), is_gas)
    except (ValueError, TypeError) as error:
        raise GdmlError(element, str(error)) from None


def _density(reading: GdmlReader, element: XmlElement) -> float:
    """Return the density of a <D> or <Dref> element in g/cm3."""
    if element.tag == "Dref":  # quantities hold g/mm3, the unit g/cm3 being 1/1000
        value = reading.value(element.attributes.get("ref", ""), element, "ref") * 1000
    else:
        unit = element.attributes.get("unit") or "g/cm3"
        value = reading.value(element.attributes.get("value", ""), element, "value")
        # Units of density are in g/mm3, the base units of masses and lengths here
        value *= reading.value(unit, element, "unit") * 1000
    if value < 0:
        raise GdmlError(element, f"value must be >= 0, got {float(value):g} g/cm3")
    return _float(value, element)


def _float(value: Fraction, element: XmlElement) -> float:
    try:
        return float(value)
    except OverflowError:
        raise GdmlError(element, "has a number that is too large") from None


# Colours of volumes as auxiliary information: a custom of several programs, no part of GDML itself

_COLOR_NAMES = {
    "white": "#ffffff", "gray": "#808080", "grey": "#808080", "black": "#000000", "brown": "#734000", "red": "#ff0000",
    "green": "#00ff00", "blue": "#0000ff", "cyan": "#00ffff", "magenta": "#ff00ff", "yellow": "#ffff00",
}  # fmt: skip
"""Geant4's named colours (G4Colour), with its shares of red, green and blue taken as sRGB."""
_COLOR_CODE = re.compile(r"#([0-9a-fA-F]{6})([0-9a-fA-F]{2})?")
_COLOR_CHANNEL = re.compile(r"\d{1,9}(?:\.\d{0,20})?|\.\d{1,20}", re.ASCII)


def read_color_hint(reading: GdmlReader, volume: XmlElement) -> str | None:
    """Return #rrggbb of the last valid <auxiliary auxtype="Color"> of a volume; None if it has none.

    Values are names, #rrggbb or #rrggbbaa, and three or four shares from 0 to 1, with or without commas and brackets.
    Invalid values and opacities below 1 are remarked.
    """
    hint = None
    for child in volume.children:
        if local_tag(child) != "auxiliary" or child.attributes.get("auxtype", "").lower() not in ("color", "colour"):
            continue
        text = child.attributes.get("auxvalue", "").strip()
        color = _parse_color(text)
        where = f"volume {volume.attributes.get('name', '')!r}"
        if color is None:
            reading.remark(child, where, f"has the colour {shorten(text)!r}, which is not understood")
            continue
        hint, opacity = color
        if opacity < 1:
            reading.remark(child, where, f"has a colour of opacity {opacity:.3g}, which is not read")
    return hint


def _parse_color(text: str) -> tuple[str, float] | None:
    """Return colour (#rrggbb) and opacity; None for an invalid text."""
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
    # Some programs write channels from 0 to 255; which of both (1, 1, 1) means nobody can know, so these are refused
    if max(channels) > 1:
        return None
    return "#" + "".join(f"{round(255 * channel):02x}" for channel in channels[:3]), (*channels, 1.0)[3]
