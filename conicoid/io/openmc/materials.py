"""Reader of OpenMC's <material> elements into names and properties."""

from __future__ import annotations

from dataclasses import dataclass
from fractions import Fraction
from functools import partial
from typing import Any

from ...materials.properties import Properties
from ..xml_tree import XmlElement
from .values import OpenmcValues, format_title, quote_word

_MASS = {"g/cm3": Fraction(1), "g/cc": Fraction(1), "kg/m3": Fraction(1, 1000)}
_ATOMS = {"atom/b-cm": Fraction(1), "atom/cm3": Fraction(1, 10**24)}
# Units without a value of their own: "sum" adds the fractions, "macro" refers to macroscopic cross sections.
_OTHER_UNITS = ("sum", "macro")
NuclideShares = dict[str, dict[str, Fraction]]
"""Fractions by kind ("ao" or "wo") and by nuclide or element."""
VACUUM_DENSITIES = {"density": 0.0, "atom_density": 0.0}
"""The properties of void."""


@dataclass(frozen=True, slots=True)
class OpenmcMaterial:
    """A material of a file.

    Its properties are `id`; `density` in g/cm3 or `atom_density` in atoms per barn and cm, whichever the file has; `ao`
    and `wo`, fractions by nuclide or element; `sab` and `macroscopic`, names; `temperature`, `volume`, `depletable`.
    """

    id: int
    name: str
    properties: Properties

    def __str__(self) -> str:
        return format_title("material", self.id, self.name)


def read_material(element: XmlElement) -> OpenmcMaterial:
    """Return the material of a <material> element. Raise OpenmcElementError with all its errors."""
    values = OpenmcValues(element, "material")
    # Outside of `attempt`: without a number no message could name the material.
    name = values.text("name") or ""
    number = values.integer("id")
    values.where = format_title("material", number, name)
    properties: dict[str, Any] = {"id": number}
    fractions = values.attempt(lambda: _fractions(values), {})
    for part in element.all("density"):
        properties |= values.attempt(partial(_density, _part(values, part), fractions), {})
    for kind, shares in fractions.items():
        properties |= {kind: {name: float(share) for name, share in shares.items()}} if shares else {}
    for kind in ("sab", "macroscopic"):
        names = values.attempt(partial(_names, values, kind), ())
        properties |= {kind: names} if names else {}
    for kind in ("temperature", "volume"):
        properties |= values.attempt(partial(_number, values, kind), {})
    depletable = (values.text("depletable") or "").lower()
    properties |= {"depletable": depletable in ("true", "1")} if depletable else {}
    values.finish()
    return OpenmcMaterial(number, name, Properties(properties))


def _part(values: OpenmcValues, element: XmlElement) -> OpenmcValues:
    """Return a reader of a child element, whose messages name the material too."""
    part = OpenmcValues(element, element.tag)
    part.where = f"{values.where}: {element.tag}"
    return part


def _density(values: OpenmcValues, fractions: NuclideShares) -> dict[str, float]:
    """Return the density of a <density> element as a property; empty for macroscopic units."""
    units = values.text("units") or ""
    if units == "sum":
        return _sum(values, fractions)
    if units in _OTHER_UNITS:
        return {}
    if units not in _MASS and units not in _ATOMS:
        known = ", ".join((*_MASS, *_ATOMS, *_OTHER_UNITS))
        raise values.mistake(f"units must be one of {known}, got {quote_word(units)}")
    (value,) = values.numbers("value", 1)
    if value <= 0:
        raise values.mistake(f"value must be > 0, got {quote_word(values.require('value'))}")
    if units in _MASS:
        return {"density": float(value * _MASS[units])}
    return {"atom_density": float(value * _ATOMS[units])}


def _sum(values: OpenmcValues, fractions: NuclideShares) -> dict[str, float]:
    """Return the sum of fractions that are densities themselves: `ao` in atoms per barn and cm, `wo` in g/cm3."""
    kinds = [kind for kind, shares in fractions.items() if shares]
    if len(kinds) > 1:
        raise values.mistake("units sum needs either ao or wo of all nuclides, got both")
    names = {"ao": "atom_density", "wo": "density"}
    return {names[kind]: float(sum(fractions[kind].values())) for kind in kinds}


def _fractions(values: OpenmcValues) -> NuclideShares:
    """Return atom and weight fractions by name; fractions of the same name are added."""
    sums: dict[str, dict[str, Fraction]] = {"ao": {}, "wo": {}}
    for tag in ("nuclide", "element"):
        for element in values.element.all(tag):
            part = _part(values, element)
            name = part.require("name")
            for kind in sums:
                # Fractions are added exactly and rounded to floats once, at the end.
                if part.text(kind) is not None and name:
                    share = _not_negative(part, kind)
                    sums[kind][name] = sums[kind].get(name, Fraction(0)) + share
    return sums


def _names(values: OpenmcValues, tag: str) -> tuple[str, ...]:
    names = [_part(values, element).require("name") for element in values.element.all(tag)]
    return tuple(name for name in names if name)


def _number(values: OpenmcValues, name: str) -> dict[str, float]:
    if values.text(name) is None:
        return {}
    return {name: float(_not_negative(values, name))}


def _not_negative(values: OpenmcValues, name: str) -> Fraction:
    (value,) = values.numbers(name, 1)
    if value < 0:
        raise values.mistake(f"{name} must be >= 0, got {quote_word(values.require(name))}")
    return value
