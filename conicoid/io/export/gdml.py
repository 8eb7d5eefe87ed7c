"""Materials as GDML's elements, with their densities and what they are made of."""

from __future__ import annotations

import math
import re
from collections.abc import Mapping
from dataclasses import dataclass, field
from typing import Any
from xml.sax.saxutils import quoteattr

from ..._util.file_errors import printable
from ..._util.text import format_count
from ...geometry.shape import Difference, Solid
from ...materials.material import Material
from ..gdml.materials import GAS_DENSITY
from ..importers import palette_color as color_of_number
from ..openmc.region import Region
from ..scene_file.scene_file import WritableScene
from .csg_pieces import split_into_pieces
from .element_guesses import guess_element
from .exporters import (
    ExportBody,
    ExportOptions,
    ExportReport,
    ExportResult,
    ExportUnsupported,
    collect_solids,
    format_expression,
    format_number,
    hex_color,
    is_void,
    overlapping_boxes,
)
from .gdml_motions import AxisStretch, GdmlMoves, join_moves, relative_moves, split_last_placement
from .gdml_solids import SolidReference, SolidWriter, position_element, rotation_element
from .openmc_regions import ExportSurfaceTable, RegionWriter, are_disjoint

_WRITTEN_PROPERTIES = {"density", "fractions", "composite", "formula", "state", "Z"}
_NO_MATERIAL_NAME = "no material"
_COLORS_REMARK = "not said: colours of materials"


class GdmlMaterialWriter:
    """The materials of a file by name, in the order in which readers give them the colours that they have."""

    def __init__(self, items: list[ExportBody], report: ExportReport) -> None:
        self._report = report
        used = list(dict.fromkeys(item.material for item in items if item.material is not None))
        self.names: dict[Material, str] = {}
        self._numbers: dict[Material, int] = {}
        self._firsts: dict[tuple[object, ...], Material] = {}
        taken: set[str] = set()
        for material in sorted(used, key=lambda each: _palette_number(each, len(used))):
            if material.name == _NO_MATERIAL_NAME and is_void(material):
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

    def reference(self, item: ExportBody) -> str:
        """What a volume says."""
        if item.material is None or item.material not in self.names:
            return ""
        return f"<materialref ref={quoteattr(self.names[item.material])}/>"

    def color(self, item: ExportBody) -> str:
        """A hint for readers, where they would give another colour to the material."""
        material = item.material
        if material is None or material not in self.names or is_void(material):
            return ""
        color, _ = hex_color(material)
        if color == color_of_number(self._numbers[material]):
            return ""
        return f'<auxiliary auxtype="Color" auxvalue="{color}"/>'

    def elements(self) -> list[str]:
        """Lines of XML."""
        once = {name: material for material, name in reversed(self.names.items())}
        told = [name for material, name in self.names.items() if not is_void(material) and not hex_color(material)[1]]
        for name in told:
            self._report.narrow(_COLORS_REMARK, name)
        return [line for name in dict.fromkeys(self.names.values()) for line in self._element(once[name], name)]

    def _element(self, material: Material, name: str) -> list[str]:
        given = dict(material.properties)
        density = given.get("density")
        thin = (isinstance(density, (int, float)) and density < GAS_DENSITY) or given.get("state") == "gas"
        if is_void(material) and not thin:
            density, thin = 1e-25, True
        if is_void(material) != thin:
            self._report.narrow(_COLORS_REMARK, name)
        attributes = "".join(f" {key}={quoteattr(str(given[key]))}" for key in ("formula", "state") if given.get(key))
        if isinstance(given.get("Z"), (int, float)):
            attributes += f' Z="{format_number(float(given["Z"]))}"'
        lines = [f"<material name={quoteattr(name)}{attributes}>"]
        if isinstance(density, (int, float)):
            lines.append(f'  <D value="{format_number(float(density))}" unit="g/cm3"/>')
        else:
            self._report.narrow("no density is known of materials", name)
        parts = _material_parts(given)
        lines += [f'  <{tag} n="{format_number(float(share))}" ref={quoteattr(part)}/>' for tag, part, share in parts]
        rest = sorted(map(str, set(given) - _WRITTEN_PROPERTIES))
        if rest:
            self._report.narrow(f"not said: properties of materials ({', '.join(rest[:4])})", name)
        return [*lines, "</material>"]


def _palette_number(material: Material, count: int) -> int:
    """Its number, if it has the colour that readers give to that."""
    found, _ = hex_color(material)
    return next((n for n in range(1, 4 * count + 9) if color_of_number(n) == found), 0)


def _material_parts(given: Mapping[str, Any]) -> list[tuple[str, str, float]]:
    """(tag, name, share) of what it is made of."""
    found = []
    for key, tag in (("fractions", "fraction"), ("composite", "composite")):
        if isinstance(given.get(key), Mapping):
            found += [(tag, str(part), share) for part, share in given[key].items()]
    return found


# Which bodies lie in which: daughters displace their mother, so a mother is a difference from which they are cut.


@dataclass
class VolumeNest:
    """A body with those that are placed in it; `outer` is its solid before these are cut from it."""

    number: int
    item: ExportBody
    outer: Solid
    inner: list[VolumeNest] = field(default_factory=list)


def body_numbers(nests: list[VolumeNest]) -> list[int]:
    """The bodies of some nests in the order in which readers find them."""
    found: list[int] = []
    pending = list(reversed(nests))
    while pending:
        nest = pending.pop()
        found.append(nest.number)
        pending += reversed(nest.inner)
    return found


def nest_bodies(items: list[ExportBody]) -> list[VolumeNest]:
    """All bodies, those within others there; in the order of the scene.

    What importers make of volumes in volumes, ``mother - daughter - daughter``, is taken apart again where each
    daughter is a body that is listed after the mother.
    """
    free: dict[Solid, list[VolumeNest]] = {}
    for number in range(len(items) - 1, -1, -1):
        item = items[number]
        nest = VolumeNest(number, item, item.solid)
        left: list[Solid] = []
        if isinstance(item.solid, Difference) and item.solid.motion.is_identity:
            first, *cut = item.solid.operands
            for solid in cut:
                found = free.get(solid)
                if found:
                    nest.inner.append(found.pop())
                else:
                    left.append(solid)
            if nest.inner:
                nest.outer = Difference((first, *left)) if left else first
        nest.inner.sort(key=lambda inner: inner.number)
        free.setdefault(nest.outer, []).append(nest)
    return sorted((nest for nests in free.values() for nest in nests), key=lambda nest: nest.number)


# A scene as a GDML file: volumes within volumes where bodies are cut by those in them, else beside one another.

_COPY_NAME = re.compile(r"(.+)\[(\d{1,9})\]\Z", re.S)
CONTAINER = '<auxiliary auxtype="Conicoid" auxvalue="container"/>'
"""Of a world that is no body of the scene."""


@dataclass
class _StructureWriter:
    """The volumes that are written, each once."""

    report: ExportReport
    solids: SolidWriter
    materials: GdmlMaterialWriter
    names: dict[str, str] = field(default_factory=dict)
    taken: set[str] = field(default_factory=set)
    elements: list[str] = field(default_factory=list)

    def placed(self, nest: VolumeNest, frame: GdmlMoves, around: str) -> str:
        """The physvol of a body, whose volume is written before."""
        said = self._said(nest)
        if said is None:
            return ""
        rest, place = split_last_placement(relative_moves(said.moves, frame), True)
        solid = self.solids.wrapped(said.name, rest)
        inner = self._inner(nest, join_moves(place.moves, frame))
        label, copy = self._label(nest.item, around)
        volume = self.volume(nest.item, solid, inner, label)
        return (
            f"<physvol name={quoteattr(label)}{copy}><volumeref ref={quoteattr(volume)}/>"
            f"{position_element(place.shift)}{rotation_element(place.angles)}</physvol>"
        )

    def world(self, nest: VolumeNest) -> str:
        """The volume of a body that holds all others, where it is."""
        said = self._said(nest)
        if said is None:
            return ""
        solid = self.solids.wrapped(said.name, said.moves)
        return self.volume(nest.item, solid, self._inner(nest, ()), self._plain(nest.item, nest.item.name))

    def _said(self, nest: VolumeNest) -> SolidReference | None:
        said, self.solids.is_worked_out = None, False
        with self.report.about(nest.item.name):
            said = self.solids.said(split_into_pieces(nest.outer, guess_element))
            if nest.inner and any(isinstance(move, AxisStretch) for move in said.moves):
                said = SolidReference(self.solids.wrapped(said.name, said.moves), (), said.is_rounded)
            if said.is_rounded:
                self.report.narrow("numbers are rounded to float64", nest.item.name)
            elif self.solids.is_worked_out:
                told = "planes are worked out from corners by readers, so that the last digits may be others"
                self.report.narrow(told, nest.item.name)
        return said

    def _inner(self, nest: VolumeNest, frame: GdmlMoves) -> list[str]:
        return [self.placed(inner, frame, nest.item.name) for inner in nest.inner]

    def volume(self, item: ExportBody, solid: str, inner: list[str], label: str) -> str:
        """The name of a volume; those that are alike are one."""
        material = self.materials.reference(item)
        color = self.materials.color(item)
        lines = [f'{material}<solidref ref="{solid}"/>', *inner, *([color] if color else [])]
        text = "\n".join(f"  {line}" for line in lines)
        if text not in self.names:
            name, k = label, 2
            while name in self.taken:
                name, k = f"{label} {k}", k + 1
            self.taken.add(name)
            self.names[text] = name
            self.elements.append(f"<volume name={quoteattr(name)}>\n{text}\n</volume>")
        return self.names[text]

    def _label(self, item: ExportBody, around: str) -> tuple[str, str]:
        """What a body is called within another, and its copy number."""
        name = item.name.removeprefix(f"{around}/") if around else item.name
        found = _COPY_NAME.match(name)
        if found is None or str(int(found[2])) != found[2]:
            return self._plain(item, name), ""
        return self._plain(item, found[1]), f' copynumber="{found[2]}"'

    def _plain(self, item: ExportBody, name: str) -> str:
        """Without brackets, in which GDML has numbers."""
        plain = printable(name).replace("[", "(").replace("]", ")")
        if plain != name:
            self.report.narrow("names with brackets have others in GDML", item.name)
        return plain


def export_text(scene: WritableScene, options: ExportOptions) -> ExportResult:
    """The text of a .gdml file."""
    report = ExportReport("GDML")
    items = collect_solids(scene, report)
    nests = nest_bodies(items)
    structure = _StructureWriter(report, SolidWriter(), GdmlMaterialWriter(items, report))
    if len(nests) == 1 and nests[0].inner:
        world = structure.world(nests[0])
    else:
        inner = []
        for number, nest in enumerate(nests):
            if options.progress is not None and number % 256 == 0:
                options.progress(number, len(nests))
            inner.append(structure.placed(nest, (), ""))
        world = _write_container(structure, nests, inner)
    report.check()
    order = body_numbers(nests)
    if order != sorted(order):  # as some of a body that is cut come after others that are not
        report.narrow("bodies come back in another order, which is by volumes", "")
    _report_overlaps(nests, report)
    if scene.domain is not None:
        report.narrow("not said: the domain that bodies are to fill", "")
    facts = [f"{format_count(len(structure.solids.names), 'solid')}, {format_count(len(structure.elements), 'volume')}"]
    text = _document(structure, world)
    remarks = report.remarks
    return ExportResult(text, (*facts, *remarks), remarks)


def _write_container(structure: _StructureWriter, nests: list[VolumeNest], inner: list[str]) -> str:
    """A world around bodies that none of them holds: a box of nothing, which importers of ours leave out."""
    ends = [abs(float(end)) for nest in nests for corner in nest.outer.bounds for end in corner]
    size = max((end for end in ends if math.isfinite(end)), default=1.0)
    text = format_number(8.0 * 2.0 ** math.frexp(size)[1])
    solid = structure.solids.add("box", f' x="{text}" y="{text}" z="{text}" lunit="mm"')
    name = "world"
    while name in structure.taken:
        name += "'"
    lines = [f'  <solidref ref="{solid}"/>', *(f"  {each}" for each in inner), f"  {CONTAINER}"]
    structure.elements.append("\n".join([f"<volume name={quoteattr(name)}>", *lines, "</volume>"]))
    return name


def _report_overlaps(nests: list[VolumeNest], report: ExportReport) -> None:
    """Volumes in one mother must not share points; who surely does not is left alone."""
    pending = [nests]
    while pending:
        siblings = pending.pop()
        pending += [nest.inner for nest in siblings if nest.inner]
        _report_sibling_overlaps(siblings, report)


def _report_sibling_overlaps(siblings: list[VolumeNest], report: ExportReport) -> None:
    table = ExportSurfaceTable()
    regions = RegionWriter(table)
    known: dict[int, Region] = {}

    def region(number: int) -> Region:
        if number not in known:
            known[number] = regions.of(siblings[number].outer)
        return known[number]

    for i, j in overlapping_boxes([nest.outer.bounds for nest in siblings]):
        first, later = siblings[i], siblings[j]
        if first.outer in _cut_bodies(later) or later.outer in _cut_bodies(first):
            continue
        try:
            if are_disjoint(region(i), region(j), table):
                continue
        except ExportUnsupported:
            pass
        report.narrow("may share points with bodies before them, which GDML's daughters must not", later.item.name)


def _cut_bodies(nest: VolumeNest) -> tuple[object, ...]:
    return getattr(nest.outer, "operands", ())[1:]


def _document(structure: _StructureWriter, world: str) -> str:
    corners = []
    for point, name in structure.solids.positions.items():
        x, y, z = map(format_expression, point)
        corners.append(f'<position name="{name}" x="{x}" y="{y}" z="{z}" unit="mm"/>')
    lines = ['<?xml version="1.0" encoding="UTF-8"?>', "<gdml>"]
    sections = (
        ("define", corners), ("materials", structure.materials.elements()), ("solids", structure.solids.elements),
        ("structure", [line for element in structure.elements for line in element.split("\n")]),
    )  # fmt: skip
    for tag, content in sections:
        lines += [f"<{tag}>", *(f"  {line}" for line in content), f"</{tag}>"]
    lines += ['<setup name="Default" version="1.0">', f"  <world ref={quoteattr(world)}/>", "</setup>", "</gdml>", ""]
    return "\n".join(lines)
