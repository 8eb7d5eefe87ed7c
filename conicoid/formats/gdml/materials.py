"""GDML's <materials>: names, densities, what they are made of; and which of them are shown."""

from __future__ import annotations

from dataclasses import dataclass
from fractions import Fraction
from typing import Any

from ...shapes.looks import matte
from ...shapes.material import Material
from ...shapes.properties import Properties
from ..openmc.palette import color_of
from ..openmc.xml_tree import Element
from .reading import Mistake, Reading, local, shown_name

THIN = 0.01
"""g/cm3: gases are thinner, as vacuum is; all solids and liquids are denser."""
_GASES = {"G4_Galactic": 1e-25, "G4_AIR": 0.00120479, "Galactic": 1e-25}
"""Those of Geant4's own list that stand in many files without a definition."""


@dataclass(frozen=True, eq=False)
class NamedMaterial:
    """A material of a file, with its place among them."""

    number: int
    name: str
    properties: Properties
    is_thin: bool
    hint: str | None = None

    @property
    def color(self) -> str | None:
        """What the file hints at, else by its number; None for gases and vacuum, which are invisible."""
        return None if self.is_thin else self.hint or color_of(self.number)

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


Materials = dict[str, NamedMaterial]


def read_materials(reading: Reading, section: Element, materials: Materials) -> None:
    """All of a section; isotopes and elements are of no use here but in names."""
    for element in reading.each(section.children):
        if local(element) != "material":
            if local(element) not in ("element", "isotope", "property"):
                reading.remark(element, local(element), "is no material that is known, left out")
            continue
        name = element.attributes.get("name", "")
        try:
            name = reading.solved(name, element)
            materials[name] = _material(reading, element, name)
        except Mistake as mistake:
            reading.report(mistake.element, f"material {name!r}", mistake.message)


def material_of(reading: Reading, materials: Materials, name: str) -> NamedMaterial | None:
    """A material of the file, or one of Geant4's own list that it only names; None for one that there is not."""
    if name not in materials:
        if not name.startswith("G4_") and name not in _GASES:
            return None
        density = _GASES.get(name)
        known = {} if density is None else {"density": density}
        materials[name] = NamedMaterial(next(reading.counter), name, Properties(known), density is not None)
    return materials[name]


def _material(reading: Reading, element: Element, name: str) -> NamedMaterial:
    if not name:
        raise Mistake(element, "name must be given")
    found: dict[str, Any] = {}
    shares: dict[str, float] = {}
    for child in element.children:
        if child.tag in ("D", "Dref"):
            found["density"] = _density(reading, child)
        elif child.tag in ("fraction", "composite") and "ref" in child.attributes:
            part = shown_name(child.attributes["ref"])
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
    is_gas = found.get("state") == "gas" or found.get("density", 1.0) < THIN
    try:
        return NamedMaterial(next(reading.counter), shown_name(name), Properties(found), is_gas)
    except (ValueError, TypeError) as error:
        raise Mistake(element, str(error)) from None


def _density(reading: Reading, element: Element) -> float:
    """In g/cm3."""
    if element.tag == "Dref":
        value = reading.value(element.attributes.get("ref", ""), element, "ref") * 1000
    else:
        unit = element.attributes.get("unit") or "g/cm3"
        value = reading.value(element.attributes.get("value", ""), element, "value")
        value *= reading.value(unit, element, "unit") * 1000
    if value < 0:
        raise Mistake(element, f"value must be >= 0, got {float(value):g} g/cm3")
    return _float(value, element)


def _float(value: Fraction, element: Element) -> float:
    try:
        return float(value)
    except OverflowError:
        raise Mistake(element, "has a number that is too large") from None
