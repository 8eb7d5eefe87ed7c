"""What of a solid is turned by angles, which surfaces cannot say without rounding: it fills a cell, as a universe.

OpenMC turns what fills a cell by three angles or a matrix, and then shifts it. So a solid that is an intersection of
parts, some of them under further turns and shifts, is a cell with the unturned parts, filled with a universe that is
turned, in which there is a cell with the turned ones.
"""

from __future__ import annotations

import re
from collections.abc import Iterator, Mapping
from dataclasses import dataclass, field
from fractions import Fraction
from itertools import count, pairwise
from typing import Any
from xml.sax.saxutils import quoteattr

from ..._util.file_errors import printable
from ..._util.text import format_count
from ...geometry.general_quadric import Quadric
from ...geometry.shape import Boolean, Complement, Difference, Intersection, Solid, Union
from ...geometry.transform import IDENTITY_MOTION, Motion, Rotate, Step, Transform, Translate
from ...materials.material import Material
from ..openmc.placement import Rows, invert_rows
from ..openmc.region import HalfSpaceNode, IntersectionNode, Region, list_half_spaces
from ..scene_file.scene_file import WritableScene
from .exporters import (
    ExportBody,
    ExportOptions,
    ExportReport,
    ExportResult,
    ExportUnsupported,
    collect_solids,
    format_number,
    format_numbers,
    is_void,
    overlapping_boxes,
    shortest_decimal,
)
from .openmc_regions import (
    ExportSurfaceTable,
    RegionSides,
    RegionWriter,
    are_disjoint,
    are_disjoint_sides,
    format_region,
    is_empty_region,
    join_regions,
    list_conjuncts,
    negate_region,
    region_sides,
)


@dataclass(frozen=True)
class FillPlacement:
    """How what fills a cell is placed: the texts of the attributes `rotation` and `translation`."""

    rotation: str = ""
    translation: str = ""

    @property
    def attributes(self) -> str:
        """As they stand in an element."""
        told = [(name, getattr(self, name)) for name in ("rotation", "translation")]
        return "".join(f' {name}="{value}"' for name, value in told if value)


@dataclass(frozen=True)
class NestedSolid:
    """A solid as parts in universes within universes: `levels` lead from each to the next; the first is the root."""

    parts: tuple[tuple[Solid, ...], ...]
    levels: tuple[tuple[FillPlacement, ...], ...]


def split_levels(solid: Solid) -> NestedSolid | None:
    """A solid by levels; None where nothing of it is turned, or where that is said otherwise than by angles."""
    groups: dict[tuple[Step, ...], list[Solid]] = {}
    for operand in _intersection_parts(solid):
        own, outer = _split_turns(operand)
        groups.setdefault(outer, []).append(own)
    if set(groups) == {()}:
        return None
    chain = sorted(groups, key=len)
    if chain[0] != ():
        chain.insert(0, ())
    levels = []
    for around, inner in pairwise(chain):
        if around and inner[-len(around) :] != around:
            return None
        further = _fill_placements(inner[: len(inner) - len(around)])
        if further is None:
            return None
        levels.append(further)
    return NestedSolid(tuple(tuple(groups.get(steps, ())) for steps in chain), tuple(levels))


def _intersection_parts(solid: Solid, outer: Motion = IDENTITY_MOTION) -> Iterator[Solid]:
    """What a solid is the intersection of, under a further motion."""
    if not isinstance(solid, Intersection | Difference):
        yield _parts_under(solid, outer)
        return
    motion = solid.motion.then(outer)
    for k, operand in enumerate(solid.operands):
        if k and isinstance(solid, Difference):
            yield Complement(_parts_under(operand, motion))
        else:
            yield from _intersection_parts(operand, motion)


def _parts_under(solid: Solid, outer: Motion) -> Solid:
    return solid._moved(solid.motion.then(outer)) if outer.steps else solid


def _split_turns(solid: Solid) -> tuple[Solid, tuple[Step, ...]]:
    """A solid before its turns by odd angles and what follows them, and these.

    A quadric of ten coefficients that was shifted is one too: about the origin it would have others, rounded.
    """
    if isinstance(solid, Complement) and solid.motion.is_identity:
        own, outer = _split_turns(solid.operand)
        return Complement(own), outer
    steps = solid.motion.steps
    if isinstance(solid, Quadric) and steps and isinstance(steps[0], Translate):
        return solid._moved(IDENTITY_MOTION), steps
    first = next((k for k, step in enumerate(steps) if _is_odd_turn(step)), len(steps))
    if isinstance(solid, Boolean) and first < len(steps):
        first = 0
    if first == len(steps):
        return solid, ()
    return solid._moved(Motion(steps[:first]) if first else IDENTITY_MOTION), steps[first:]


def _is_odd_turn(step: Step) -> bool:
    """Does a step turn by anything but multiples of 90 degrees?"""
    if isinstance(step, Rotate):
        return step.degrees % 90 != 0 or sum(map(bool, step.axis)) > 1
    return isinstance(step, Transform) and not _is_exchange(step)


def _is_exchange(step: Transform) -> bool:
    rows = [row[:3] for row in step.matrix[:3]]
    lines = [*rows, *zip(*rows, strict=True)]
    return all(sorted(map(abs, line)) == [0, 0, 1] for line in lines)


def _fill_placements(steps: tuple[Step, ...]) -> tuple[FillPlacement, ...] | None:
    """Steps as fillings, the outermost first; None where they are others than turns and shifts."""
    found: list[FillPlacement] = []
    pending = list(steps)
    while pending:
        rotation, shift = "", ""
        if isinstance(pending[0], Transform):
            matrix = pending.pop(0).matrix  # type: ignore[union-attr]
            if any(row[3] for row in matrix[:3]):
                return None
            rows: Rows = tuple(tuple(map(Fraction, row[:3])) for row in matrix[:3])  # type: ignore[assignment]
            back = invert_rows(rows)
            if back is None:
                return None
            rotation = format_numbers(_format_plain(value) for row in back for value in row)
        else:
            angles = [Fraction(0)] * 3
            for axis in (2, 1, 0):
                if pending and isinstance(pending[0], Rotate) and _rotation_axis(pending[0]) == axis:
                    step = pending.pop(0)
                    sign = 1 if step.axis[axis] > 0 else -1  # type: ignore[union-attr]
                    angles[axis] = sign * shortest_decimal(step.degrees)  # type: ignore[union-attr]
            rotation = format_numbers(angles) if any(angles) else ""
        if pending and isinstance(pending[0], Translate):
            shift = format_numbers(pending.pop(0).offset)  # type: ignore[union-attr]
        if not rotation and not shift:
            return None
        found.append(FillPlacement(rotation, shift))
    return tuple(reversed(found))


def _format_plain(value: Fraction) -> float | Fraction:
    return float(value) if Fraction(float(value)) == value else value


def _rotation_axis(step: Rotate) -> int | None:
    """The axis of coordinates that a turn is about."""
    along = [i for i in range(3) if step.axis[i]]
    return along[0] if len(along) == 1 else None


# Materials as OpenMC's elements: what their properties say, under the numbers that they had.


class OpenmcMaterialWriter:
    """The materials of a file, each with a number; void has none."""

    def __init__(self, items: list[ExportBody], report: ExportReport) -> None:
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

    def number(self, item: ExportBody) -> str:
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
            f' {key}="{format_number(float(given[key]))}"'
            for key in ("temperature", "volume")
            if _is_number(given.get(key))
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
                    lines.append(f'  <nuclide name={quoteattr(nuclide)} {kind}="{format_number(float(share))}"/>')
        for kind in ("sab", "macroscopic"):
            names = given.get(kind, ())
            for each in (names,) if isinstance(names, str) else names:
                lines.append(f"  <{kind} name={quoteattr(str(each))}/>")
        rest = sorted(set(given) - _WRITTEN_PROPERTIES - ({"id"} if given.get("id") == number else set()))
        if rest:
            told = ", ".join(map(str, rest[:4]))
            self._report.narrow(
                f"properties that OpenMC's materials do not have ({told})", material.name or str(number)
            )
        if not any(kind in given for kind in ("ao", "wo", "macroscopic")):
            self._report.narrow("no nuclides are known of materials", material.name or str(number))
        return [*lines, "</material>"]


_WRITTEN_PROPERTIES = {
    "density",
    "atom_density",
    "ao",
    "wo",
    "sab",
    "macroscopic",
    "temperature",
    "volume",
    "depletable",
}


def _own_number(material: Material | None) -> int | None:
    number = None if material is None else material.properties.get("id")
    return number if isinstance(number, int) and not isinstance(number, bool) and number > 0 else None


def _density(given: dict[str, Any]) -> str:
    for key, units in (("density", "g/cm3"), ("atom_density", "atom/b-cm")):
        if _is_number(given.get(key)) and given[key] > 0:
            return f'<density value="{format_number(float(given[key]))}" units="{units}"/>'
    return '<density units="macro"/>' if given.get("macroscopic") else ""


def _is_number(value: Any) -> bool:
    return isinstance(value, (int, float)) and not isinstance(value, bool)


# A scene as an OpenMC model: surfaces, cells of half-spaces in universes, materials.

_CELL_TITLE = re.compile(r"cell (\d{1,9})(?: '(.*)')?\Z")
_ROOT_UNIVERSE = 0


@dataclass
class _CellEntry:
    """A body in a universe, and what it is there; `turned` where surfaces are rounded for it."""

    item: ExportBody
    region: Region | None
    universe: int = _ROOT_UNIVERSE


@dataclass
class _UniverseTable:
    """Cells that are filled, by what leads to them: (universe around, region there, level) -> universe within."""

    numbers: dict[tuple[int, Region | None, FillPlacement], int] = field(default_factory=dict)

    def within(self, universe: int, region: Region | None, level: FillPlacement) -> int:
        """The universe that fills a region in another, placed by a level."""
        return self.numbers.setdefault((universe, region, level), len(self.numbers) + 1)


def export_text(scene: WritableScene, options: ExportOptions) -> ExportResult:
    """The text of a model.xml."""
    report = ExportReport("OpenMC")
    items = collect_solids(scene, report)
    table, universes = ExportSurfaceTable(), _UniverseTable()
    regions = RegionWriter(table)
    cells = []
    for number, item in enumerate(items):
        if options.progress is not None and number % 256 == 0:
            options.progress(number, len(items))
        with report.about(item.name):
            cells.append(_cell(item, regions, universes))
    report.check()
    _flatten_unbounded(cells, regions, universes)
    _cut_overlaps(cells, table, report)
    for cell in cells:
        if cell.region is not None and is_empty_region(cell.region, table):
            report.narrow("with nothing in it, and left out by readers", cell.item.name)
    _report_rounded(cells, universes, table, report)
    _enclose(scene.domain, regions, table, cells, report)
    materials = OpenmcMaterialWriter(items, report)
    lines = _cell_lines(cells, universes, materials)
    text = _document(materials.elements(), [*table.elements(), *lines])
    facts = [f"{format_count(len(cells), 'cell')}, {format_count(len(table.numbers), 'surface')}"]
    remarks = report.remarks
    return ExportResult(text, (*facts, *remarks), remarks)


def _cell(item: ExportBody, regions: RegionWriter, universes: _UniverseTable) -> _CellEntry:
    """A body in the universe that it is said in."""
    found = split_levels(item.solid)
    if found is None:
        return _CellEntry(item, regions.of(item.solid))
    universe = _ROOT_UNIVERSE
    for parts, levels in zip(found.parts, found.levels, strict=False):
        region = join_regions(IntersectionNode, [regions.of(part) for part in parts]) if parts else None
        for level in levels:
            universe, region = universes.within(universe, region, level), None
    return _CellEntry(item, join_regions(IntersectionNode, [regions.of(part) for part in found.parts[-1]]), universe)


def _flatten_unbounded(cells: list[_CellEntry], regions: RegionWriter, universes: _UniverseTable) -> None:
    """Turned bodies without a part that is not turned would fill all of space: they go to the root if others are there.

    Their surfaces then are the turned ones, rounded.
    """
    root = {
        universe
        for (around, region, _), universe in universes.numbers.items()
        if around == _ROOT_UNIVERSE and region is None
    }
    beside = any(
        around == _ROOT_UNIVERSE and universe not in root for (around, _, _), universe in universes.numbers.items()
    )
    others = beside or any(cell.universe == _ROOT_UNIVERSE for cell in cells)
    if not root or (len(root) == 1 and not others):
        return
    inner = set(root)
    for (around, _, _), universe in universes.numbers.items():
        if around in inner:
            inner.add(universe)
    for cell in cells:
        if cell.universe in inner:
            cell.universe, cell.region = _ROOT_UNIVERSE, regions.of(cell.item.solid)
    for key in [key for key, universe in universes.numbers.items() if universe in inner]:
        del universes.numbers[key]


def _cut_overlaps(cells: list[_CellEntry], table: ExportSurfaceTable, report: ExportReport) -> None:
    """Cells may not overlap: what a body shares with one listed before it belongs to that one."""
    known: dict[int, RegionSides] = {}
    for i, j in overlapping_boxes([cell.item.solid.bounds for cell in cells]):
        first, later = cells[i], cells[j]
        if first.universe != later.universe:
            if _ROOT_UNIVERSE in (first.universe, later.universe):
                report.narrow("may overlap others, which OpenMC's cells must not", later.item.name)
            continue
        for k in (i, j):
            if k not in known:
                known[k] = region_sides(cells[k].region)
        if first.region is None or later.region is None or are_disjoint_sides(known[i], known[j]):
            continue
        if are_disjoint(first.region, later.region, table):
            continue
        later.region = join_regions(IntersectionNode, [later.region, negate_region(first.region)])
        known[j] = region_sides(later.region)
        report.narrow("cut by bodies before them, as cells must not overlap", later.item.name)


def _report_rounded(
    cells: list[_CellEntry], universes: _UniverseTable, table: ExportSurfaceTable, report: ExportReport
) -> None:
    if not table.rounded:
        return
    for cell in cells:
        if cell.region is not None and any(half.surface in table.rounded for half in list_half_spaces(cell.region)):
            report.narrow("surfaces are rounded to float64", cell.item.name)


def _enclose(
    domain: Solid | None,
    regions: RegionWriter,
    table: ExportSurfaceTable,
    cells: list[_CellEntry],
    report: ExportReport,
) -> None:
    """A boundary on the surfaces of what the bodies are to fill."""
    if domain is None:
        return
    if isinstance(domain, Union) and domain.motion.is_identity:
        domain = domain.operands[0]
    used = {half.surface for cell in cells if cell.region is not None for half in list_half_spaces(cell.region)}
    try:
        parts = list_conjuncts(regions.of(domain))
    except ExportUnsupported:
        parts = ()
    if not parts or not all(isinstance(part, HalfSpaceNode) and part.surface in used for part in parts):
        report.narrow("not said: the domain, whose sides are none of the cells'", "")
        return
    for part in parts:
        assert isinstance(part, HalfSpaceNode)
        table.boundaries[part.surface] = "vacuum"
    report.narrow("of what kind boundaries are is not known: they are vacuum", "")


def _cell_lines(cells: list[_CellEntry], universes: _UniverseTable, materials: OpenmcMaterialWriter) -> list[str]:
    """All cells: those of bodies under their numbers and names, and those that are filled."""
    titles = [_CELL_TITLE.match(cell.item.name) for cell in cells]
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
    return f' universe="{number}"' if number != _ROOT_UNIVERSE else ""


def _region(region: Region | None) -> str:
    return "" if region is None else f' region="{format_region(region)}"'


def _document(materials: list[str], geometry: list[str]) -> str:
    parts = ['<?xml version="1.0" encoding="utf-8"?>', "<model>"]
    for tag, lines in (("materials", materials), ("geometry", geometry)):
        if lines:
            parts += [f"  <{tag}>", *(f"    {line}" for line in lines), f"  </{tag}>"]
    return "\n".join([*parts, "</model>", ""])
