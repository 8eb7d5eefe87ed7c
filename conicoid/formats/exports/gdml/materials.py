"""Materials as GDML's elements, with their densities and what they are made of."""

from __future__ import annotations

from collections.abc import Mapping
from typing import Any
from xml.sax.saxutils import quoteattr

from ....shapes.material import Material
from ...errors import printable
from ...gdml.materials import THIN
from ...openmc.palette import color_of as color_of_number
from ..bodies import Item, color_of, is_void
from ..exported import Report
from ..numbers import word

_SAID = {"density", "fractions", "composite", "formula", "state", "Z"}
_NOTHING = "no material"
_COLORS = "not said: colours of materials"


class Materials:
    """The materials of a file by name, in the order in which readers give them the colours that they have."""

    def __init__(self, items: list[Item], report: Report) -> None:
        self._report = report
        used = list(dict.fromkeys(item.material for item in items if item.material is not None))
        self.names: dict[Material, str] = {}
        self._numbers: dict[Material, int] = {}
        self._firsts: dict[tuple[object, ...], Material] = {}
        taken: set[str] = set()
        for material in sorted(used, key=lambda each: _place(each, len(used))):
            if material.name == _NOTHING and is_void(material):
                continue
            first = self._firsts.setdefault((material.name, material.properties, is_void(material)), material)
            if material.name and first is not material:  # but for its colour, which volumes have
                self.names[material], self._numbers[material] = self.names[first], self._numbers[first]
                continue
            self._numbers[material] = len(taken) + 1
            name = printable(material.name or "material").replace("[", "(").replace("]", ")")
            unique, k = name, 2
            while unique in taken:
                unique, k = f"{name} {k}", k + 1
            taken.add(unique)
            self.names[material] = unique

    def reference(self, item: Item) -> str:
        """What a volume says."""
        if item.material is None or item.material not in self.names:
            return ""
        return f"<materialref ref={quoteattr(self.names[item.material])}/>"

    def color(self, item: Item) -> str:
        """A hint for readers, where they would give another colour to the material."""
        material = item.material
        if material is None or material not in self.names or is_void(material):
            return ""
        color, _ = color_of(material)
        if color == color_of_number(self._numbers[material]):
            return ""
        return f'<auxiliary auxtype="Color" auxvalue="{color}"/>'

    def elements(self) -> list[str]:
        """Lines of XML."""
        once = {name: material for material, name in reversed(self.names.items())}
        told = [name for material, name in self.names.items() if not is_void(material) and not color_of(material)[1]]
        for name in told:
            self._report.narrow(_COLORS, name)
        return [line for name in dict.fromkeys(self.names.values()) for line in self._element(once[name], name)]

    def _element(self, material: Material, name: str) -> list[str]:
        given = dict(material.properties)
        density = given.get("density")
        thin = (isinstance(density, (int, float)) and density < THIN) or given.get("state") == "gas"
        if is_void(material) and not thin:
            density, thin = 1e-25, True
        if is_void(material) != thin:
            self._report.narrow(_COLORS, name)
        attributes = "".join(f" {key}={quoteattr(str(given[key]))}" for key in ("formula", "state") if given.get(key))
        if isinstance(given.get("Z"), (int, float)):
            attributes += f' Z="{word(float(given["Z"]))}"'
        lines = [f"<material name={quoteattr(name)}{attributes}>"]
        if isinstance(density, (int, float)):
            lines.append(f'  <D value="{word(float(density))}" unit="g/cm3"/>')
        else:
            self._report.narrow("no density is known of materials", name)
        parts = _parts(given)
        lines += [f'  <{tag} n="{word(float(share))}" ref={quoteattr(part)}/>' for tag, part, share in parts]
        rest = sorted(map(str, set(given) - _SAID))
        if rest:
            self._report.narrow(f"not said: properties of materials ({', '.join(rest[:4])})", name)
        return [*lines, "</material>"]


def _place(material: Material, count: int) -> int:
    """Its number, if it has the colour that readers give to that."""
    found, _ = color_of(material)
    return next((n for n in range(1, 4 * count + 9) if color_of_number(n) == found), 0)


def _parts(given: Mapping[str, Any]) -> list[tuple[str, str, float]]:
    """(tag, name, share) of what it is made of."""
    found = []
    for key, tag in (("fractions", "fraction"), ("composite", "composite")):
        if isinstance(given.get(key), Mapping):
            found += [(tag, str(part), share) for part, share in given[key].items()]
    return found
