"""A scene as an OpenMC model: surfaces, cells of half-spaces in universes, materials."""

from __future__ import annotations

import re
from dataclasses import dataclass, field
from itertools import count
from xml.sax.saxutils import quoteattr

from ....shapes.base import Solid
from ....shapes.region import Union
from ...errors import printable
from ...imports.imported import counted
from ...openmc.region import Both, Half, Region, halves
from ...scene_file import SceneLike
from ..bodies import Item, solids_of
from ..exported import Exported, Options, Report, Unsayable
from ..overlaps import near_pairs
from .apart import Sides, is_nothing, nothing_in_common, sides_of, surely_apart
from .levels import Level, nested
from .materials import Materials
from .regions import Regions, conjuncts, joined, negated, text_of
from .surfaces import Table

_TITLE = re.compile(r"cell (\d{1,9})(?: '(.*)')?\Z")
_ROOT = 0


@dataclass
class _Cell:
    """A body in a universe, and what it is there; `turned` where surfaces are rounded for it."""

    item: Item
    region: Region | None
    universe: int = _ROOT


@dataclass
class _Universes:
    """Cells that are filled, by what leads to them: (universe around, region there, level) -> universe within."""

    numbers: dict[tuple[int, Region | None, Level], int] = field(default_factory=dict)

    def within(self, universe: int, region: Region | None, level: Level) -> int:
        """The universe that fills a region in another, placed by a level."""
        return self.numbers.setdefault((universe, region, level), len(self.numbers) + 1)


def exported(scene: SceneLike, options: Options) -> Exported:
    """The text of a model.xml."""
    report = Report("OpenMC")
    items = solids_of(scene, report)
    table, universes = Table(), _Universes()
    regions = Regions(table)
    cells = []
    for number, item in enumerate(items):
        if options.progress is not None and number % 256 == 0:
            options.progress(number, len(items))
        with report.about(item.name):
            cells.append(_cell(item, regions, universes))
    report.check()
    _flatten_what_fills_everything(cells, regions, universes)
    _cut_overlaps(cells, table, report)
    for cell in cells:
        if cell.region is not None and is_nothing(cell.region, table):
            report.narrow("with nothing in it, and left out by readers", cell.item.name)
    _tell_rounded(cells, universes, table, report)
    _enclose(scene.domain, regions, table, cells, report)
    materials = Materials(items, report)
    lines = _cell_lines(cells, universes, materials)
    text = _document(materials.elements(), [*table.elements(), *lines])
    facts = [f"{counted(len(cells), 'cell')}, {counted(len(table.numbers), 'surface')}"]
    remarks = report.remarks
    return Exported(text, (*facts, *remarks), remarks)


def _cell(item: Item, regions: Regions, universes: _Universes) -> _Cell:
    """A body in the universe that it is said in."""
    found = nested(item.solid)
    if found is None:
        return _Cell(item, regions.of(item.solid))
    universe = _ROOT
    for parts, levels in zip(found.parts, found.levels, strict=False):
        region = joined(Both, [regions.of(part) for part in parts]) if parts else None
        for level in levels:
            universe, region = universes.within(universe, region, level), None
    return _Cell(item, joined(Both, [regions.of(part) for part in found.parts[-1]]), universe)


def _flatten_what_fills_everything(cells: list[_Cell], regions: Regions, universes: _Universes) -> None:
    """Turned bodies without a part that is not turned would fill all of space: they go to the root if others are there.

    Their surfaces then are the turned ones, rounded.
    """
    root = {
        universe for (around, region, _), universe in universes.numbers.items() if around == _ROOT and region is None
    }
    beside = any(around == _ROOT and universe not in root for (around, _, _), universe in universes.numbers.items())
    others = beside or any(cell.universe == _ROOT for cell in cells)
    if not root or (len(root) == 1 and not others):
        return
    inner = set(root)
    for (around, _, _), universe in universes.numbers.items():
        if around in inner:
            inner.add(universe)
    for cell in cells:
        if cell.universe in inner:
            cell.universe, cell.region = _ROOT, regions.of(cell.item.solid)
    for key in [key for key, universe in universes.numbers.items() if universe in inner]:
        del universes.numbers[key]


def _cut_overlaps(cells: list[_Cell], table: Table, report: Report) -> None:
    """Cells may not overlap: what a body shares with one listed before it belongs to that one."""
    known: dict[int, Sides] = {}
    for i, j in near_pairs([cell.item.solid.bounds for cell in cells]):
        first, later = cells[i], cells[j]
        if first.universe != later.universe:
            if _ROOT in (first.universe, later.universe):
                report.narrow("may overlap others, which OpenMC's cells must not", later.item.name)
            continue
        for k in (i, j):
            if k not in known:
                known[k] = sides_of(cells[k].region)
        if first.region is None or later.region is None or surely_apart(known[i], known[j]):
            continue
        if nothing_in_common(first.region, later.region, table):
            continue
        later.region = joined(Both, [later.region, negated(first.region)])
        known[j] = sides_of(later.region)
        report.narrow("cut by bodies before them, as cells must not overlap", later.item.name)


def _tell_rounded(cells: list[_Cell], universes: _Universes, table: Table, report: Report) -> None:
    if not table.rounded:
        return
    for cell in cells:
        if cell.region is not None and any(half.surface in table.rounded for half in halves(cell.region)):
            report.narrow("surfaces are rounded to float64", cell.item.name)


def _enclose(domain: Solid | None, regions: Regions, table: Table, cells: list[_Cell], report: Report) -> None:
    """A boundary on the surfaces of what the bodies are to fill."""
    if domain is None:
        return
    if isinstance(domain, Union) and domain.motion.is_identity:
        domain = domain.operands[0]
    used = {half.surface for cell in cells if cell.region is not None for half in halves(cell.region)}
    try:
        parts = conjuncts(regions.of(domain))
    except Unsayable:
        parts = ()
    if not parts or not all(isinstance(part, Half) and part.surface in used for part in parts):
        report.narrow("not said: the domain, whose sides are none of the cells'", "")
        return
    for part in parts:
        assert isinstance(part, Half)
        table.boundaries[part.surface] = "vacuum"
    report.narrow("of what kind boundaries are is not known: they are vacuum", "")


def _cell_lines(cells: list[_Cell], universes: _Universes, materials: Materials) -> list[str]:
    """All cells: those of bodies under their numbers and names, and those that are filled."""
    titles = [_TITLE.match(cell.item.name) for cell in cells]
    taken: set[int] = set()
    numbers: list[int | None] = []
    for title in titles:
        number = int(title[1]) if title and int(title[1]) > 0 else None
        numbers.append(None if number in taken else number)
        taken |= {number} if number is not None else set()
    free = (number for number in count(1) if number not in taken)
    fillings = {universe: key for key, universe in universes.numbers.items()}
    lines: list[str] = []

    def lead_to(universe: int) -> None:
        """The filled cells on the way to a universe, where its first body stands in the order of bodies."""
        if universe in fillings:
            around, region, level = fillings.pop(universe)
            lead_to(around)
            said = f'{_universe(around)} fill="{universe}"{level.attributes}{_region(region)}'
            lines.append(f'<cell id="{next(free)}"{said}/>')

    for cell, title, number in zip(cells, titles, numbers, strict=True):
        lead_to(cell.universe)
        keeps = title is not None and number is not None
        name = (title[2] if title else None) if keeps else cell.item.name
        told = f" name={quoteattr(printable(name))}" if name else ""
        which = number if number is not None else next(free)
        said = f'{_universe(cell.universe)} material="{materials.number(cell.item)}"{_region(cell.region)}'
        lines.append(f'<cell id="{which}"{told}{said}/>')
    return lines


def _universe(number: int) -> str:
    return f' universe="{number}"' if number != _ROOT else ""


def _region(region: Region | None) -> str:
    return "" if region is None else f' region="{text_of(region)}"'


def _document(materials: list[str], geometry: list[str]) -> str:
    parts = ['<?xml version="1.0" encoding="utf-8"?>', "<model>"]
    for tag, lines in (("materials", materials), ("geometry", geometry)):
        if lines:
            parts += [f"  <{tag}>", *(f"    {line}" for line in lines), f"  </{tag}>"]
    return "\n".join([*parts, "</model>", ""])
