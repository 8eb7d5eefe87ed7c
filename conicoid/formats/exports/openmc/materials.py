"""Materials as OpenMC's elements: what their properties say, under the numbers that they had."""

from __future__ import annotations

from collections.abc import Mapping
from typing import Any
from xml.sax.saxutils import quoteattr

from ....shapes.material import Material
from ..bodies import Item, is_void
from ..exported import Report
from ..numbers import word


class Materials:
    """The materials of a file, each with a number; void has none."""

    def __init__(self, items: list[Item], report: Report) -> None:
        self._report = report
        self.numbers: dict[Material, int] = {}
        wanted = list(dict.fromkeys(item.material for item in items if not is_void(item.material)))
        taken: set[int] = set()
        for material in wanted:
            number = _own_number(material)
            if material is not None and number is not None and number not in taken:
                taken.add(number)
                self.numbers[material] = number
        free = 1
        for material in wanted:
            if material is None or material in self.numbers:
                continue
            while free in taken:
                free += 1
            taken.add(free)
            self.numbers[material] = free

    def number(self, item: Item) -> str:
        """What a cell says: a number, or void."""
        if item.material is None:
            self._report.narrow("without a material, and void in OpenMC", item.name)
        if item.material is None or is_void(item.material):
            return "void"
        return str(self.numbers[item.material])

    def elements(self) -> list[str]:
        """Lines of XML."""
        lines = []
        for material, number in sorted(self.numbers.items(), key=lambda pair: pair[1]):
            lines += self._element(material, number)
        return lines

    def _element(self, material: Material, number: int) -> list[str]:
        given = dict(material.properties)
        name = f" name={quoteattr(material.name)}" if material.name else ""
        attributes = "".join(
            f' {key}="{word(float(given[key]))}"' for key in ("temperature", "volume") if _is_number(given.get(key))
        )
        if "depletable" in given:
            attributes += f' depletable="{"true" if given["depletable"] else "false"}"'
        density = _density(given)
        if not density:
            self._report.narrow("no density is known of materials", material.name or str(number))
        lines = [f'<material id="{number}"{name}{attributes}>', *([f"  {density}"] if density else [])]
        for kind in ("ao", "wo"):
            if isinstance(given.get(kind), Mapping):
                for nuclide, share in given[kind].items():
                    lines.append(f'  <nuclide name={quoteattr(nuclide)} {kind}="{word(float(share))}"/>')
        for kind in ("sab", "macroscopic"):
            names = given.get(kind, ())
            for each in (names,) if isinstance(names, str) else names:
                lines.append(f"  <{kind} name={quoteattr(str(each))}/>")
        rest = sorted(set(given) - _SAID - ({"id"} if given.get("id") == number else set()))
        if rest:
            told = ", ".join(map(str, rest[:4]))
            self._report.narrow(
                f"properties that OpenMC's materials do not have ({told})", material.name or str(number)
            )
        if not any(kind in given for kind in ("ao", "wo", "macroscopic")):
            self._report.narrow("no nuclides are known of materials", material.name or str(number))
        return [*lines, "</material>"]


_SAID = {"density", "atom_density", "ao", "wo", "sab", "macroscopic", "temperature", "volume", "depletable"}


def _own_number(material: Material | None) -> int | None:
    number = None if material is None else material.properties.get("id")
    return number if isinstance(number, int) and not isinstance(number, bool) and number > 0 else None


def _density(given: dict[str, Any]) -> str:
    for key, units in (("density", "g/cm3"), ("atom_density", "atom/b-cm")):
        if _is_number(given.get(key)) and given[key] > 0:
            return f'<density value="{word(float(given[key]))}" units="{units}"/>'
    return '<density units="macro"/>' if given.get("macroscopic") else ""


def _is_number(value: Any) -> bool:
    return isinstance(value, (int, float)) and not isinstance(value, bool)
