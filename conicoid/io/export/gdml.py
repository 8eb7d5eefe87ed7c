"""Export to GDML: materials, solids and volumes.

Bodies that are cut from another become volumes within its volume; all others are placed beside one another. Solids are
written by `gdml_solids.py`, motions by `gdml_motions.py`.
"""

from __future__ import annotations

import itertools
import math
import re
from collections.abc import Mapping
from dataclasses import field, replace
from typing import Any
from xml.sax.saxutils import quoteattr

import numpy as np

from ..._util.files import printable
from ..._util.records import dataclass
from ..._util.text import format_count
from ...geometry.body import Body
from ...geometry.shape import Boolean, Difference, PrimitiveSolid, Solid
from ...materials.material import Material
from ..gdml.values import GAS_DENSITY
from ..importers import palette_color as color_of_number
from ..openmc.region_expression import Region
from ..scene_file.scene_file import WritableScene
from .csg_pieces import split_into_pieces
from .exporters import (
    ExportBody,
    ExportOptions,
    ExportReport,
    ExportResult,
    UnsupportedExport,
    collect_solids,
    format_expression,
    format_number,
    hex_color,
    is_void,
    overlapping_boxes,
    unit_factor,
    unit_notes,
)
from .gdml_motions import AxisStretch, GdmlMoves, join_moves, relative_moves, split_last_placement
from .gdml_solids import LENGTH_UNIT, SolidReference, SolidWriter, position_element, rotation_element, source_piece
from .openmc_regions import EmptinessTest, ExportSurfaceTable, RegionWriter

# Materials, with their densities and components.

_WRITTEN_PROPERTIES = {"density", "fractions", "composite", "formula", "state", "Z"}
_NO_MATERIAL_NAME = "no material"
_COLORS_REMARK = "not written: colours of materials"


class GdmlMaterialWriter:
    """The materials of a file by name, in an order that makes readers give them their own colours where possible.

    Readers colour materials by number from a palette, so materials with a palette colour are sorted by its number.
    """

    def __init__(self, items: list[ExportBody], report: ExportReport) -> None:
        self._report = report
        used = list(dict.fromkeys(item.material for item in items if item.material is not None))
        self.names: dict[Material, str] = {}
        self._numbers: dict[Material, int] = {}
        self._firsts: dict[tuple[object, ...], Material] = {}
        used_names: set[str] = set()
        for material in sorted(used, key=lambda each: _palette_number(each, len(used))):
            # The importer's own stand-in: without a reference it comes back
            if material.name == _NO_MATERIAL_NAME and is_void(material):
                continue
            # Readers compare materials by name and properties; colours belong to volumes
            first = self._firsts.setdefault((material.name, material.properties, is_void(material)), material)
            if material.name and first is not material:  # only the colour differs, which volumes hold
                self.names[material], self._numbers[material] = self.names[first], self._numbers[first]
                continue
            self._numbers[material] = len(used_names) + 1
            # Brackets in names are indices in GDML
            name = printable(material.name or "material").replace("[", "(").replace("]", ")")
            unique, k = name, 2
            while unique in used_names:
                unique, k = f"{name} {k}", k + 1
            used_names.add(unique)
            self.names[material] = unique

    def reference(self, item: ExportBody) -> str:
        """Return the element by which a volume refers to its material, or "" for none."""
        if item.material is None or item.material not in self.names:
            return ""
        return f"<materialref ref={quoteattr(self.names[item.material])}/>"

    def color(self, item: ExportBody) -> str:
        """Return the element of a volume's colour, or "" if readers give the material this colour anyway."""
        material = item.material
        if material is None or material not in self.names or is_void(material):
            return ""
        color, _ = hex_color(material)
        if color == color_of_number(self._numbers[material]):
            return ""
        return f'<auxiliary auxtype="Color" auxvalue="{color}"/>'

    def elements(self) -> list[str]:
        """Return the lines of XML, and report materials whose look is more than a colour."""
        once = {name: material for material, name in reversed(self.names.items())}
        lossy = [name for material, name in self.names.items() if not is_void(material) and not hex_color(material)[1]]
        for name in lossy:
            self._report.narrow(_COLORS_REMARK, name)
        return [line for name in dict.fromkeys(self.names.values()) for line in self._element(once[name], name)]

    def _element(self, material: Material, name: str) -> list[str]:
        properties = dict(material.properties)
        density = properties.get("density")
        thin = (isinstance(density, (int, float)) and density < GAS_DENSITY) or properties.get("state") == "gas"
        # Readers take thin materials for void. Where that is not the look of this one, density or look is lost.
        if is_void(material) and not thin:
            density, thin = 1e-25, True
        if is_void(material) != thin:
            self._report.narrow(_COLORS_REMARK, name)
        attributes = "".join(
            f" {key}={quoteattr(printable(str(properties[key])))}"
            for key in ("formula", "state")
            if properties.get(key)
        )
        if isinstance(properties.get("Z"), (int, float)):
            attributes += f' Z="{format_number(float(properties["Z"]))}"'
        lines = [f"<material name={quoteattr(name)}{attributes}>"]
        if isinstance(density, (int, float)):
            lines.append(f'  <D value="{format_number(float(density))}" unit="g/cm3"/>')
        else:
            self._report.narrow("materials without a density", name)
        parts = _material_parts(properties)
        lines += [
            f'  <{tag} n="{format_number(float(share))}" ref={quoteattr(printable(part))}/>'
            for tag, part, share in parts
        ]
        rest = sorted(map(str, set(properties) - _WRITTEN_PROPERTIES))
        if rest:
            self._report.narrow(f"not written: properties of materials ({', '.join(rest[:4])})", name)
        return [*lines, "</material>"]


def _palette_number(material: Material, count: int) -> int:
    """Return the number in the palette of readers of a material's colour, or 0; `count` materials are expected."""
    found, _ = hex_color(material)
    return next((n for n in range(1, 4 * count + 9) if color_of_number(n) == found), 0)


def _material_parts(composition: Mapping[str, Any]) -> list[tuple[str, str, float]]:
    """Return (tag, name, share) of the components of a material."""
    found = []
    for key, tag in (("fractions", "fraction"), ("composite", "composite")):
        if isinstance(composition.get(key), Mapping):
            found += [(tag, str(part), share) for part, share in composition[key].items()]
    return found


# Volumes within volumes. In GDML daughters displace their mother, so the body of a mother is a difference.


@dataclass
class VolumeNest:
    """A body with the bodies that are placed in it; `outer` is its solid before these are cut from it."""

    number: int
    item: ExportBody
    outer: Solid
    inner: list[VolumeNest] = field(default_factory=list)


def body_numbers(nests: list[VolumeNest]) -> list[int]:
    """Return the numbers of the bodies in the order in which readers meet them: depth first, the mother first."""
    found: list[int] = []
    pending = list(reversed(nests))
    while pending:
        nest = pending.pop()
        found.append(nest.number)
        pending += reversed(nest.inner)
    return found


def nest_bodies(items: list[ExportBody]) -> list[VolumeNest]:
    """Return the outermost bodies, with those within them, in the order of the scene.

    Importers make differences of volumes in volumes: ``mother - daughter - daughter``. Such a difference is taken apart
    again for each daughter that is a body listed after the mother.
    """
    free: dict[Solid, list[VolumeNest]] = {}
    for number in range(len(items) - 1, -1, -1):  # daughters before their mother
        item = items[number]
        nest = VolumeNest(number, item, item.solid)
        unnested: list[Solid] = []
        if isinstance(item.solid, Difference) and item.solid.motion.is_identity:
            first, *cut = item.solid.operands
            for solid in cut:
                # By equality of solids: the importer cut the very solid that the daughter has
                daughters = free.get(solid)
                if daughters:
                    nest.inner.append(daughters.pop())
                else:
                    unnested.append(solid)
            if nest.inner:
                nest.outer = Difference((first, *unnested)) if unnested else first
        # Readers list daughters in the order of the file
        nest.inner.sort(key=lambda inner: inner.number)
        free.setdefault(nest.outer, []).append(nest)
    return sorted((nest for nests in free.values() for nest in nests), key=lambda nest: nest.number)


# The structure and the file.

_COPY_NAME = re.compile(r"(.+)\[(\d{1,9})\]\Z", re.S)
CONTAINER = '<auxiliary auxtype="Conicoid" auxvalue="container"/>'
"""Marks a world volume that is no body of the scene."""


@dataclass
class _StructureWriter:
    """The elements of <structure>: volumes, equal ones once."""

    report: ExportReport
    solids: SolidWriter
    materials: GdmlMaterialWriter
    names: dict[str, str] = field(default_factory=dict)
    used_names: set[str] = field(default_factory=set)
    next_numbers: dict[str, int] = field(default_factory=dict)
    """For each label the first number that no volume has: molecules have 10,000 bodies of one name."""
    elements: list[str] = field(default_factory=list)

    def place(self, nest: VolumeNest, frame: GdmlMoves, mother: str) -> str:
        """Write the volume of a body, and return its <physvol> in the volume `mother` at `frame`.

        Return "" if GDML cannot hold the solid, which is reported.
        """
        own = self._solid(nest)
        if own is None:
            return ""
        rest, place = split_last_placement(relative_moves(own.moves, frame), True)
        solid = self.solids.move(own.name, rest)
        inner = self._inner(nest, join_moves(place.moves, frame))
        label, copy = self._label(nest.item, mother)
        volume = self.volume(nest.item, solid, inner, label)
        return (
            f"<physvol name={quoteattr(label)}{copy}><volumeref ref={quoteattr(volume)}/>"
            f"{position_element(place.shift)}{rotation_element(place.angles)}</physvol>"
        )

    def world(self, nest: VolumeNest) -> str:
        """Write the volume of a body that holds all others, at its place, and return its name."""
        own = self._solid(nest)
        if own is None:
            return ""
        solid = self.solids.move(own.name, own.moves)
        return self.volume(nest.item, solid, self._inner(nest, ()), self._plain(nest.item, nest.item.name))

    def _solid(self, nest: VolumeNest) -> SolidReference | None:
        """Write the solid of a body and report its losses; return None if GDML cannot hold it, which is reported."""
        solid, self.solids.has_computed_planes = None, False
        with self.report.about(nest.item.name):
            solid = self.solids.write(split_into_pieces(nest.outer, source_piece))
            # Frames of volumes in it have no stretches: let the solid hold them.
            if nest.inner and any(isinstance(move, AxisStretch) for move in solid.moves):
                solid = SolidReference(self.solids.move(solid.name, solid.moves), (), solid.is_rounded)
            if solid.is_rounded:
                self.report.narrow("numbers are rounded to float64", nest.item.name)
            elif self.solids.has_computed_planes:
                loss = "readers compute planes from corners, so that the last digits may differ"
                self.report.narrow(loss, nest.item.name)
        return solid

    def _inner(self, nest: VolumeNest, frame: GdmlMoves) -> list[str]:
        """Write the volumes in a body, and return their <physvol> elements."""
        return [self.place(inner, frame, nest.item.name) for inner in nest.inner]

    def volume(self, item: ExportBody, solid: str, inner: list[str], label: str) -> str:
        """Return the name of a volume; it is added unless an equal one exists."""
        material = self.materials.reference(item)
        color = self.materials.color(item)
        lines = [f'{material}<solidref ref="{solid}"/>', *inner, *([color] if color else [])]
        text = "\n".join(f"  {line}" for line in lines)
        # Bodies of equal solid, material and daughters are one volume, placed many times, as in the file that they came
        # from
        if text not in self.names:
            name, k = label, self.next_numbers.get(label, 2)
            while name in self.used_names:
                name, k = f"{label} {k}", k + 1
            self.next_numbers[label] = k
            self.used_names.add(name)
            self.names[text] = name
            self.elements.append(f"<volume name={quoteattr(name)}>\n{text}\n</volume>")
        return self.names[text]

    def _label(self, item: ExportBody, mother: str) -> tuple[str, str]:
        """Return the name of a body within another, and the attribute of its copy number, which `[3]` at its end is."""
        name = item.name.removeprefix(f"{mother}/") if mother else item.name
        found = _COPY_NAME.match(name)
        # A number with zeros in front would come back without them
        if found is None or str(int(found[2])) != found[2]:
            return self._plain(item, name), ""
        return self._plain(item, found[1]), f' copynumber="{found[2]}"'

    def _plain(self, item: ExportBody, name: str) -> str:
        """Return a name without brackets, which hold indices in GDML, and report a change."""
        plain = printable(name).replace("[", "(").replace("]", ")")
        if plain != name:
            self.report.narrow("names with brackets have parentheses in GDML", item.name)
        return plain


def export_text(scene: WritableScene, options: ExportOptions) -> ExportResult:
    """Return the text of a .gdml file. Raise ValueError with the bodies that GDML cannot hold."""
    report = ExportReport("GDML")
    items = collect_solids(scene, report)
    unit = scene.unit or "mm"
    if unit == "in":  # Geant4 knows all other units
        size = float(unit_factor(scene, "mm"))
        items, unit = [replace(item, solid=item.solid.scale(size)) for item in items], "mm"
    nests = nest_bodies(items)
    structure = _StructureWriter(report, SolidWriter(), GdmlMaterialWriter(items, report))
    if len(nests) == 1 and nests[0].inner:
        world = structure.world(nests[0])
    else:
        inner = []
        for number, nest in enumerate(nests):
            if options.progress is not None and number % 256 == 0:
                options.progress(number, len(nests))
            inner.append(structure.place(nest, (), ""))
        world = _write_container(structure, nests, inner)
    report.check()
    order = body_numbers(nests)
    if order != sorted(order):  # daughters follow their mother at once, in scenes perhaps later
        report.narrow("bodies come back in another order, which is by volumes", "")
    _report_overlaps(nests, report)
    if scene.domain is not None:
        report.narrow("not written: the domain that bodies are to fill", "")
    facts = [f"{format_count(len(structure.solids.names), 'solid')}, {format_count(len(structure.elements), 'volume')}"]
    text = _document(structure, world).replace(LENGTH_UNIT, unit)
    remarks = report.remarks
    return ExportResult(text, (*facts, *(unit_notes(scene, unit) if unit != scene.unit else ()), *remarks), remarks)


def _write_container(structure: _StructureWriter, nests: list[VolumeNest], inner: list[str]) -> str:
    """Write a world around bodies that none of them holds, and return its name.

    It is an empty box, marked so that Conicoid's importer leaves it out.
    """
    ends = [abs(float(end)) for nest in nests for corner in nest.outer.bounds for end in corner]
    size = max((end for end in ends if math.isfinite(end)), default=1.0)
    # A power of two beyond everything: nothing is cut off, and the number is short
    text = format_number(8.0 * 2.0 ** math.frexp(size)[1])
    solid = structure.solids.add("box", f' x="{text}" y="{text}" z="{text}" lunit="{LENGTH_UNIT}"')
    name = "world"
    while name in structure.used_names:
        name += "'"
    lines = [f'  <solidref ref="{solid}"/>', *(f"  {each}" for each in inner), f"  {CONTAINER}"]
    structure.elements.append("\n".join([f"<volume name={quoteattr(name)}>", *lines, "</volume>"]))
    return name


def _report_overlaps(nests: list[VolumeNest], report: ExportReport) -> None:
    """Report volumes in one mother that may share points, which GDML forbids."""
    pending = [nests]
    while pending:
        siblings = pending.pop()
        pending += [nest.inner for nest in siblings if nest.inner]
        _report_sibling_overlaps(siblings, report)


def _report_sibling_overlaps(siblings: list[VolumeNest], report: ExportReport) -> None:
    """Report volumes that share points with one before them, unless their boxes or their regions surely do not."""
    table = ExportSurfaceTable()
    regions, emptiness = RegionWriter(table), EmptinessTest(table)
    outer_regions: dict[int, Region] = {}

    def region(number: int) -> Region:
        if number not in outer_regions:
            outer_regions[number] = regions.of(siblings[number].outer)
        return outer_regions[number]

    def may_share_points(i: int, j: int) -> bool:
        first, later = siblings[i], siblings[j]
        if first.outer in _cut_bodies(later) or later.outer in _cut_bodies(first):  # one is cut from the other
            return False
        try:
            return not emptiness.is_empty(region(i), region(j))
        except UnsupportedExport:
            return True

    neighbours: dict[int, list[int]] = {}
    for i, j in overlapping_boxes([nest.outer.bounds for nest in siblings]):
        neighbours.setdefault(j, []).append(i)
    clear = _clear_overlaps(siblings, [(i, j) for j, before in neighbours.items() for i in before[:_PROBED_PAIRS]])
    for j, before in neighbours.items():
        if j in clear or any(may_share_points(i, j) for i in before):
            remark = "may share points with bodies before them, which GDML's daughters must not"
            report.narrow(remark, siblings[j].item.name)


_PROBED_PAIRS = 4
"""Bodies before one that a ray tests; regions, which take exact arithmetic, test the others."""
_CLEAR_SHARE = 1e-6
"""Share of the way between the centres of two boxes that both bodies must hold: far more than rounding."""
_ASIDE = np.array([0.013, -0.017, 0.011])
"""A ray starts so far beside the centre of a box, where sticks of an atom end: in thicknesses of the thinner body."""


def _clear_overlaps(siblings: list[VolumeNest], pairs: list[tuple[int, int]]) -> set[int]:
    """Return the later bodies of pairs of primitives that surely share points of the line between their centres."""
    solids = {k: siblings[k].outer for k in sorted({k for pair in pairs for k in pair})}
    simple = [k for k, solid in solids.items() if isinstance(solid, PrimitiveSolid) and np.isfinite(solid.bounds).all()]
    places = {number: place for place, number in enumerate(simple)}
    both = np.array([(places[i], places[j]) for i, j in pairs if i in places and j in places], int).reshape(-1, 2)
    if not len(both):
        return set()
    # Only here: most files need no rays
    from ...prepare.prepared_scene import prepare
    from ...queries.ray_queries import as_rays, spans

    low, high = np.array([solids[k].bounds for k in simple]).transpose(1, 0, 2)
    first, later = both.T
    thickness = (high - low).min(axis=1)
    origins = (low + high)[first] / 2 + _ASIDE * np.minimum(thickness[first], thickness[later])[:, None]
    scene = prepare([Body(solids[k]) for k in simple])
    found = spans(scene, as_rays("export", origins, (low + high)[later] / 2 - origins), 0.0, 1.0)
    clear = set()
    # As lists: to take the rows of each ray out of `found` costs more than all rays
    body, enter, leave, offsets = (part.tolist() for part in (found.body, found.t_enter, found.t_exit, found.offsets))
    for ray, pair in enumerate(both.tolist()):
        rows = range(offsets[ray], offsets[ray + 1])
        own, other = ([row for row in rows if body[row] == number] for number in pair)
        shared = (min(leave[a], leave[b]) - max(enter[a], enter[b]) for a, b in itertools.product(own, other))
        if max(shared, default=0.0) > _CLEAR_SHARE:
            clear.add(simple[pair[1]])
    return clear


def _cut_bodies(nest: VolumeNest) -> tuple[object, ...]:
    """Return the solids that are cut from a volume."""
    return nest.outer.operands[1:] if isinstance(nest.outer, Boolean) else ()


def _document(structure: _StructureWriter, world: str) -> str:
    """Return the file with its four sections and the world volume."""
    corners = []
    for point, name in structure.solids.positions.items():
        x, y, z = map(format_expression, point)
        corners.append(f'<position name="{name}" x="{x}" y="{y}" z="{z}" unit="{LENGTH_UNIT}"/>')
    lines = ['<?xml version="1.0" encoding="UTF-8"?>', "<gdml>"]
    sections = (
        ("define", corners), ("materials", structure.materials.elements()), ("solids", structure.solids.elements),
        ("structure", [line for element in structure.elements for line in element.split("\n")]),
    )  # fmt: skip
    for tag, content in sections:
        lines += [f"<{tag}>", *(f"  {line}" for line in content), f"</{tag}>"]
    lines += ['<setup name="Default" version="1.0">', f"  <world ref={quoteattr(world)}/>", "</setup>", "</gdml>", ""]
    return "\n".join(lines)
