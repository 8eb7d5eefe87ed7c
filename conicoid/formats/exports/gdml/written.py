"""A scene as a GDML file: volumes within volumes where bodies are cut by those in them, else beside one another."""

from __future__ import annotations

import math
import re
from dataclasses import dataclass, field
from xml.sax.saxutils import quoteattr

from ...errors import printable
from ...imports.imported import counted
from ...openmc.region import Region
from ...scene_file import SceneLike
from ..bodies import Item, solids_of
from ..exported import Exported, Options, Report, Unsayable
from ..lowered import lowered
from ..numbers import expression, word
from ..openmc.apart import nothing_in_common
from ..openmc.regions import Regions
from ..openmc.surfaces import Table
from ..overlaps import near_pairs
from .known import known_again
from .materials import Materials
from .moves import Moves, Stretch, joined, last_place, relative
from .nesting import Nest, nests_of, numbers_in
from .solids import Said, Solids, position, rotation

_COPY = re.compile(r"(.+)\[(\d{1,9})\]\Z", re.S)
CONTAINER = '<auxiliary auxtype="Conicoid" auxvalue="container"/>'
"""Of a world that is no body of the scene."""


@dataclass
class _Structure:
    """The volumes that are written, each once."""

    report: Report
    solids: Solids
    materials: Materials
    names: dict[str, str] = field(default_factory=dict)
    taken: set[str] = field(default_factory=set)
    elements: list[str] = field(default_factory=list)

    def placed(self, nest: Nest, frame: Moves, around: str) -> str:
        """The physvol of a body, whose volume is written before."""
        said = self._said(nest)
        if said is None:
            return ""
        rest, place = last_place(relative(said.moves, frame), True)
        solid = self.solids.wrapped(said.name, rest)
        inner = self._inner(nest, joined(place.moves, frame))
        label, copy = self._label(nest.item, around)
        volume = self.volume(nest.item, solid, inner, label)
        return (
            f"<physvol name={quoteattr(label)}{copy}><volumeref ref={quoteattr(volume)}/>"
            f"{position(place.shift)}{rotation(place.angles)}</physvol>"
        )

    def world(self, nest: Nest) -> str:
        """The volume of a body that holds all others, where it is."""
        said = self._said(nest)
        if said is None:
            return ""
        solid = self.solids.wrapped(said.name, said.moves)
        return self.volume(nest.item, solid, self._inner(nest, ()), self._plain(nest.item, nest.item.name))

    def _said(self, nest: Nest) -> Said | None:
        said, self.solids.is_worked_out = None, False
        with self.report.about(nest.item.name):
            said = self.solids.said(lowered(nest.outer, known_again))
            if nest.inner and any(isinstance(move, Stretch) for move in said.moves):
                said = Said(self.solids.wrapped(said.name, said.moves), (), said.is_rounded)
            if said.is_rounded:
                self.report.narrow("numbers are rounded to float64", nest.item.name)
            elif self.solids.is_worked_out:
                told = "planes are worked out from corners by readers, so that the last digits may be others"
                self.report.narrow(told, nest.item.name)
        return said

    def _inner(self, nest: Nest, frame: Moves) -> list[str]:
        return [self.placed(inner, frame, nest.item.name) for inner in nest.inner]

    def volume(self, item: Item, solid: str, inner: list[str], label: str) -> str:
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

    def _label(self, item: Item, around: str) -> tuple[str, str]:
        """What a body is called within another, and its copy number."""
        name = item.name.removeprefix(f"{around}/") if around else item.name
        found = _COPY.match(name)
        if found is None or str(int(found[2])) != found[2]:
            return self._plain(item, name), ""
        return self._plain(item, found[1]), f' copynumber="{found[2]}"'

    def _plain(self, item: Item, name: str) -> str:
        """Without brackets, in which GDML has numbers."""
        plain = printable(name).replace("[", "(").replace("]", ")")
        if plain != name:
            self.report.narrow("names with brackets have others in GDML", item.name)
        return plain


def exported(scene: SceneLike, options: Options) -> Exported:
    """The text of a .gdml file."""
    report = Report("GDML")
    items = solids_of(scene, report)
    nests = nests_of(items)
    structure = _Structure(report, Solids(), Materials(items, report))
    if len(nests) == 1 and nests[0].inner:
        world = structure.world(nests[0])
    else:
        inner = []
        for number, nest in enumerate(nests):
            if options.progress is not None and number % 256 == 0:
                options.progress(number, len(nests))
            inner.append(structure.placed(nest, (), ""))
        world = _container(structure, nests, inner)
    report.check()
    order = numbers_in(nests)
    if order != sorted(order):  # as some of a body that is cut come after others that are not
        report.narrow("bodies come back in another order, which is by volumes", "")
    _tell_overlaps(nests, report)
    if scene.domain is not None:
        report.narrow("not said: the domain that bodies are to fill", "")
    facts = [f"{counted(len(structure.solids.names), 'solid')}, {counted(len(structure.elements), 'volume')}"]
    text = _document(structure, world)
    remarks = report.remarks
    return Exported(text, (*facts, *remarks), remarks)


def _container(structure: _Structure, nests: list[Nest], inner: list[str]) -> str:
    """A world around bodies that none of them holds: a box of nothing, which importers of ours leave out."""
    ends = [abs(float(end)) for nest in nests for corner in nest.outer.bounds for end in corner]
    size = max((end for end in ends if math.isfinite(end)), default=1.0)
    text = word(8.0 * 2.0 ** math.frexp(size)[1])
    solid = structure.solids.add("box", f' x="{text}" y="{text}" z="{text}" lunit="mm"')
    name = "world"
    while name in structure.taken:
        name += "'"
    lines = [f'  <solidref ref="{solid}"/>', *(f"  {each}" for each in inner), f"  {CONTAINER}"]
    structure.elements.append("\n".join([f"<volume name={quoteattr(name)}>", *lines, "</volume>"]))
    return name


def _tell_overlaps(nests: list[Nest], report: Report) -> None:
    """Volumes in one mother must not share points; who surely does not is left alone."""
    pending = [nests]
    while pending:
        siblings = pending.pop()
        pending += [nest.inner for nest in siblings if nest.inner]
        _tell_overlaps_among(siblings, report)


def _tell_overlaps_among(siblings: list[Nest], report: Report) -> None:
    table = Table()
    regions = Regions(table)
    known: dict[int, Region] = {}

    def region(number: int) -> Region:
        if number not in known:
            known[number] = regions.of(siblings[number].outer)
        return known[number]

    for i, j in near_pairs([nest.outer.bounds for nest in siblings]):
        first, later = siblings[i], siblings[j]
        if first.outer in _cut(later) or later.outer in _cut(first):
            continue
        try:
            if nothing_in_common(region(i), region(j), table):
                continue
        except Unsayable:
            pass
        report.narrow("may share points with bodies before them, which GDML's daughters must not", later.item.name)


def _cut(nest: Nest) -> tuple[object, ...]:
    return getattr(nest.outer, "operands", ())[1:]


def _document(structure: _Structure, world: str) -> str:
    corners = []
    for point, name in structure.solids.positions.items():
        x, y, z = map(expression, point)
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
