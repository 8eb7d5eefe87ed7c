"""Export to OpenMC: a model.xml of materials, surfaces and cells, with rotated parts of solids in universes.

Coefficients of rotated surfaces would have to be rounded. OpenMC rotates the universe that fills a cell by three angles
or a matrix, and then shifts it, without rounding in the file. So a solid that is an intersection of parts, some of them
rotated, becomes a cell of the other parts, filled with a rotated universe that holds a cell of the rotated parts.
"""

from __future__ import annotations

import re
from collections.abc import Iterator, Mapping
from dataclasses import field
from fractions import Fraction
from itertools import count, pairwise
from typing import Any
from xml.sax.saxutils import quoteattr

from ..._util.files import printable
from ..._util.records import dataclass
from ..._util.text import format_count
from ...geometry.general_quadric import Quadric
from ...geometry.shape import Boolean, Complement, Difference, Intersection, Solid, Union
from ...geometry.transform import IDENTITY_MOTION, Motion, Rotate, Step, Transform, Translate
from ...materials.material import Material
from ..openmc.placement import AxisTurn, Rows, invert_rows
from ..openmc.region_expression import HalfSpaceNode, IntersectionNode, Region, list_half_spaces
from ..openmc.values import read_title
from ..scene_file.scene_file import WritableScene
from .exporters import (
    ExportBody,
    ExportOptions,
    ExportReport,
    ExportResult,
    UnsupportedExport,
    collect_solids,
    format_number,
    format_numbers,
    is_void,
    overlapping_boxes,
    shortest_decimal,
    unit_factor,
    unit_notes,
)
from .openmc_regions import (
    EmptinessTest,
    ExportSurfaceTable,
    RegionSides,
    RegionWriter,
    are_disjoint_sides,
    format_region,
    join_regions,
    list_conjuncts,
)

# Solids as nested universes.


@dataclass(frozen=True)
class FillPlacement:
    """The placement of a universe that fills a cell: the texts of the attributes `rotation` and `translation`."""

    rotation: str = ""
    translation: str = ""

    def attributes(self, factor: Fraction) -> str:
        """Return the attributes as text of an element, with the shift multiplied by a factor."""
        shift = self.translation
        if factor != 1:
            shift = format_numbers(Fraction(word) * factor for word in shift.split())
        values = ("rotation", self.rotation), ("translation", shift)
        return "".join(f' {name}="{value}"' for name, value in values if value)


@dataclass(frozen=True)
class NestedSolid:
    """A solid as parts in nested universes, the root first; `levels[i]` leads from `parts[i]` to the next parts."""

    parts: tuple[tuple[Solid, ...], ...]
    levels: tuple[tuple[FillPlacement, ...], ...]


def split_levels(solid: Solid) -> NestedSolid | None:
    """Return a solid as nested universes.

    None if no part is rotated, or all are, or if fills cannot express the motions.
    """
    groups: dict[tuple[Step, ...], list[Solid]] = {}
    for operand in _intersection_parts(solid):
        own, outer = _split_turns(operand)
        groups.setdefault(outer, []).append(own)
    # Nothing is rotated; or all is, and a universe with no part around it would fill all of space, beside other cells
    if () not in groups or len(groups) == 1:
        return None
    # Each motion must end with the motion around it: the rest leads from one universe into the next.
    chain = sorted(groups, key=len)
    levels = []
    # The shortest motion is the outermost.
    for parent, inner in pairwise(chain):
        if parent and inner[-len(parent) :] != parent:
            return None
        further = _fill_placements(inner[: len(inner) - len(parent)])
        if further is None:
            return None
        levels.append(further)
    return NestedSolid(tuple(tuple(groups[steps]) for steps in chain), tuple(levels))


def _intersection_parts(solid: Solid, outer: Motion = IDENTITY_MOTION) -> Iterator[Solid]:
    """Yield the parts that a solid is the intersection of, under a further motion."""
    if not isinstance(solid, Intersection | Difference):
        yield _parts_under(solid, outer)
        return
    motion = solid.motion.then(outer)
    for k, operand in enumerate(solid.operands):
        if k and isinstance(solid, Difference):
            # a - b is a and not b, and a complement of a part is a region of OpenMC too
            yield Complement(_parts_under(operand, motion))
        else:
            yield from _intersection_parts(operand, motion)


def _parts_under(solid: Solid, outer: Motion) -> Solid:
    return solid._moved(solid.motion.then(outer)) if outer.steps else solid


def _split_turns(solid: Solid) -> tuple[Solid, tuple[Step, ...]]:
    """Split a solid into itself before its first rotation by an odd angle, and the steps from there on.

    A shift of a quadric of ten coefficients counts too: about the origin its coefficients would be rounded.
    """
    if isinstance(solid, Complement) and solid.motion.is_identity:
        own, outer = _split_turns(solid.operand)
        return Complement(own), outer
    steps = solid.motion.steps
    if isinstance(solid, Quadric) and steps and isinstance(steps[0], Translate):
        return solid._moved(IDENTITY_MOTION), steps
    first = next((k for k, step in enumerate(steps) if _is_odd_turn(step)), len(steps))
    if isinstance(solid, Boolean) and first < len(steps):
        first = 0  # all steps stay together, so that operands have none of them
    if first == len(steps):
        return solid, ()
    return solid._moved(Motion(steps[:first]) if first else IDENTITY_MOTION), steps[first:]


def _is_odd_turn(step: Step) -> bool:
    """Return True if a step rotates by anything but multiples of 90 degrees."""
    if isinstance(step, Rotate):
        return step.degrees % 90 != 0 or sum(map(bool, step.axis)) > 1
    return isinstance(step, Transform) and AxisTurn.of([row[:3] for row in step.matrix[:3]]) is None


def _fill_placements(steps: tuple[Step, ...]) -> tuple[FillPlacement, ...] | None:
    """Return steps as fills, the outermost first; None if some are neither rotations nor shifts.

    A fill rotates about x, then y, then z, and then shifts. OpenMC's matrix is the inverse of the rotation.
    """
    fills: list[FillPlacement] = []
    pending = list(steps)
    while pending:
        rotation, shift = "", ""
        if isinstance(pending[0], Transform):
            matrix = pending.pop(0).matrix  # type: ignore[union-attr]
            # A fill rotates first and shifts afterwards, so a matrix with a shift within is not one rotation
            if any(row[3] for row in matrix[:3]):
                return None
            rows: Rows = tuple(tuple(map(Fraction, row[:3])) for row in matrix[:3])  # type: ignore[assignment]
            back = invert_rows(rows)
            if back is None:
                return None
            rotation = format_numbers(
                float(value) if Fraction(float(value)) == value else value for row in back for value in row
            )
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
        # A scaling, or a rotation about a slanted axis
        if not rotation and not shift:
            return None
        fills.append(FillPlacement(rotation, shift))
    return tuple(reversed(fills))


def _rotation_axis(step: Rotate) -> int | None:
    """Return the axis of coordinates of a rotation; None for any other axis."""
    along = [i for i in range(3) if step.axis[i]]
    return along[0] if len(along) == 1 else None


# Materials: their properties as elements, under their `id` where possible.


class OpenmcMaterialWriter:
    """The numbered materials of a file; void has no number."""

    def __init__(self, items: list[ExportBody], report: ExportReport) -> None:
        self._report = report
        self.numbers: dict[Material, int] = {}
        materials = list(dict.fromkeys(item.material for item in items if not is_void(item.material)))
        used_ids: set[int] = set()
        # Own numbers first, so that no free one takes them.
        for material in materials:
            # A model that was read from OpenMC keeps the numbers that its tallies refer to
            number = _own_number(material)
            if material is not None and number is not None and number not in used_ids:
                used_ids.add(number)
                self.numbers[material] = number
        free = 1
        for material in materials:
            if material is None or material in self.numbers:
                continue
            while free in used_ids:
                free += 1
            used_ids.add(free)
            self.numbers[material] = free

    def number(self, item: ExportBody) -> str:
        """Return the attribute `material` of a cell: a number, or "void"."""
        if item.material is None:
            self._report.narrow("without a material, and void in OpenMC", item.name)
        if item.material is None or is_void(item.material):
            return "void"
        return str(self.numbers[item.material])

    def elements(self) -> list[str]:
        """Return the lines of XML, and report properties that OpenMC's materials lack."""
        lines = []
        for material, number in sorted(self.numbers.items(), key=lambda pair: pair[1]):
            lines += self._element(material, number)
        return lines

    def _element(self, material: Material, number: int) -> list[str]:
        properties = dict(material.properties)
        name = f" name={_quote(material.name)}" if material.name else ""
        attributes = "".join(
            f' {key}="{format_number(float(properties[key]))}"'
            for key in ("temperature", "volume")
            if _is_number(properties.get(key))
        )
        if "depletable" in properties:
            attributes += f' depletable="{"true" if properties["depletable"] else "false"}"'
        density = _density(properties)
        if not density:
            self._report.narrow("materials without a density", material.name or str(number))
        lines = [f'<material id="{number}"{name}{attributes}>', *([f"  {density}"] if density else [])]
        for kind in ("ao", "wo"):
            if isinstance(properties.get(kind), Mapping):
                for nuclide, share in properties[kind].items():
                    lines.append(f'  <nuclide name={_quote(nuclide)} {kind}="{format_number(float(share))}"/>')
        for kind in ("sab", "macroscopic"):
            names = properties.get(kind, ())
            for each in (names,) if isinstance(names, str) else names:
                lines.append(f"  <{kind} name={_quote(str(each))}/>")
        rest = sorted(set(properties) - _WRITTEN_PROPERTIES - ({"id"} if properties.get("id") == number else set()))
        if rest:
            names = ", ".join(map(str, rest[:4]))
            self._report.narrow(
                f"properties that OpenMC's materials do not have ({names})", material.name or str(number)
            )
        if not any(kind in properties for kind in ("ao", "wo", "macroscopic")):
            self._report.narrow("materials without nuclides", material.name or str(number))
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
    """Return the number that an importer stored as the property `id`; None if there is none."""
    number = None if material is None else material.properties.get("id")
    return number if isinstance(number, int) and not isinstance(number, bool) and number > 0 else None


def _density(properties: dict[str, Any]) -> str:
    """Return the element of a density, "" for none."""
    for key, units in (("density", "g/cm3"), ("atom_density", "atom/b-cm")):
        if _is_number(properties.get(key)) and properties[key] > 0:
            return f'<density value="{format_number(float(properties[key]))}" units="{units}"/>'
    return '<density units="macro"/>' if properties.get("macroscopic") else ""


def _is_number(value: Any) -> bool:
    return isinstance(value, (int, float)) and not isinstance(value, bool)


# The model: surfaces, and cells in universes.

_ROOT_UNIVERSE = 0


@dataclass
class _CellEntry:
    """A body, the universe of its cell, and its region there; None for all of the universe."""

    item: ExportBody
    region: Region | None
    universe: int = _ROOT_UNIVERSE


@dataclass
class _UniverseTable:
    """Filled cells: (universe around, region there, placement) -> number of the universe within."""

    numbers: dict[tuple[int, Region | None, FillPlacement], int] = field(default_factory=dict)

    def fill_number(self, universe: int, region: Region | None, level: FillPlacement) -> int:
        """Return the universe that fills a region of another at a placement; it gets a number if it is new."""
        return self.numbers.setdefault((universe, region, level), len(self.numbers) + 1)


def export_text(scene: WritableScene, options: ExportOptions) -> ExportResult:
    """Return the text of a model.xml. Raise ValueError with the bodies that OpenMC cannot hold."""
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
    if not cells:  # a geometry without cells is none for OpenMC, nor for any reader
        raise ValueError("export: there is no body to write")
    emptiness = EmptinessTest(table)
    _cut_overlaps(cells, emptiness, report)
    for cell in cells:
        if cell.region is not None and emptiness.is_empty(cell.region):
            report.narrow("with nothing in it, and left out by readers", cell.item.name)
    _report_rounded(cells, table, report)
    _enclose(scene.domain, regions, table, cells, report)
    materials = OpenmcMaterialWriter(items, report)
    factor = unit_factor(scene, "cm")
    lines = _cell_lines(cells, universes, materials, factor)
    text = _document(materials.elements(), [*table.elements(factor), *lines])
    facts = [f"{format_count(len(cells), 'cell')}, {format_count(len(table.numbers), 'surface')}"]
    remarks = report.remarks
    return ExportResult(text, (*facts, *unit_notes(scene, "cm"), *remarks), remarks)


def _cell(item: ExportBody, regions: RegionWriter, universes: _UniverseTable) -> _CellEntry:
    """Return the cell of a body; rotated parts get universes."""
    nested = split_levels(item.solid)
    if nested is None:
        return _CellEntry(item, regions.of(item.solid))
    universe = _ROOT_UNIVERSE
    for parts, levels in zip(nested.parts, nested.levels, strict=False):
        region: Region | None = join_regions(IntersectionNode, [regions.of(part) for part in parts])
        for level in levels:
            universe, region = universes.fill_number(universe, region, level), None
    return _CellEntry(item, join_regions(IntersectionNode, [regions.of(part) for part in nested.parts[-1]]), universe)


def _cut_overlaps(cells: list[_CellEntry], emptiness: EmptinessTest, report: ExportReport) -> None:
    """Cut bodies by the bodies that are listed before them, since cells must not overlap; report the cuts."""
    sides_of: dict[int, RegionSides] = {}
    whole = [cell.region for cell in cells]
    for i, j in overlapping_boxes([cell.item.solid.bounds for cell in cells]):
        first, later = cells[i], cells[j]
        if first.universe != later.universe:
            if _ROOT_UNIVERSE in (first.universe, later.universe):
                report.narrow("may overlap others, which OpenMC's cells must not", later.item.name)
            continue
        # On demand: most bodies overlap no other's box
        for k in (i, j):
            if k not in sides_of:
                sides_of[k] = emptiness.sides(cells[k].region)
        body = whole[i]
        # The quick test first.
        if body is None or first.region is None or later.region is None or are_disjoint_sides(sides_of[i], sides_of[j]):
            continue
        if emptiness.is_empty(first.region, later.region):
            continue
        # By the whole body: what it lost belongs to earlier bodies. Cut regions within cut ones would double each time
        later.region = join_regions(IntersectionNode, [later.region, emptiness.complement(body)])
        sides_of[j] = emptiness.sides(later.region)
        report.narrow("cut by bodies before them, as cells must not overlap", later.item.name)


def _report_rounded(cells: list[_CellEntry], table: ExportSurfaceTable, report: ExportReport) -> None:
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
    """Put a vacuum boundary on the surfaces of the domain that the bodies fill, if cells use them all."""
    if domain is None:
        return
    # An importer joins the enclosure and the filled cells of the root: the enclosure comes first
    if isinstance(domain, Union) and domain.motion.is_identity:
        domain = domain.operands[0]
    used = {half.surface for cell in cells if cell.region is not None for half in list_half_spaces(cell.region)}
    try:
        parts = list_conjuncts(regions.of(domain))
    except UnsupportedExport:
        parts = ()
    if not parts or not all(isinstance(part, HalfSpaceNode) and part.surface in used for part in parts):
        report.narrow("not written: the domain, whose sides are none of the cells'", "")
        return
    for part in parts:
        assert isinstance(part, HalfSpaceNode)
        table.boundaries[part.surface] = "vacuum"
    report.narrow("the kind of boundaries is not known: they become vacuum", "")


def _cell_lines(
    cells: list[_CellEntry], universes: _UniverseTable, materials: OpenmcMaterialWriter, factor: Fraction
) -> list[str]:
    """Return the lines of all cells: those of bodies under their numbers and names, and the filled ones.

    Shifts are multiplied by a factor.
    """
    titles = [read_title(cell.item.name) for cell in cells]
    used_ids: set[int] = set()
    numbers: list[int | None] = []
    for title in titles:
        number = title[0] if title and title[0] > 0 else None
        # Names that `co.Body` was given may look like those of an importer, and then occur twice
        numbers.append(None if number in used_ids else number)
        used_ids |= {number} if number is not None else set()
    free = (number for number in count(1) if number not in used_ids)
    fillings = {universe: key for key, universe in universes.numbers.items()}
    lines: list[str] = []

    def lead_to(universe: int) -> None:
        """Write the filled cells on the way to a universe, before the first body in it."""
        if universe in fillings:
            parent, region, level = fillings.pop(universe)
            lead_to(parent)
            attributes = f'{_universe(parent)} fill="{universe}"{level.attributes(factor)}{_region(region)}'
            lines.append(f'<cell id="{next(free)}"{attributes}/>')

    for cell, title, number in zip(cells, titles, numbers, strict=True):
        lead_to(cell.universe)
        # The number of the cell is its id again, and the rest of the title its name
        name = title[1] if title is not None and number is not None else cell.item.name
        title_text = f" name={_quote(name)}" if name else ""
        which = number if number is not None else next(free)
        attributes = f'{_universe(cell.universe)} material="{materials.number(cell.item)}"{_region(cell.region)}'
        lines.append(f'<cell id="{which}"{title_text}{attributes}/>')
    return lines


# Characters that XML cannot hold, and other controls
_CONTROLS = re.compile(r"[\x00-\x1f\x7f-\x9f\ud800-\udfff\ufffe\uffff]")


def _quote(text: str) -> str:
    """Return a text as the value of an attribute, in quotes; controls and lone surrogates are escaped."""
    return quoteattr(_CONTROLS.sub(lambda match: printable(match[0]), text))


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
