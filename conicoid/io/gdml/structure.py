"""GDML's <structure>: volumes with what is placed in them."""

from __future__ import annotations

import os
from collections.abc import Callable, Iterator
from dataclasses import dataclass, field, replace
from fractions import Fraction
from itertools import pairwise

from ..openmc.placement import NO_ROTATION, ORIGIN, CellRotation, Point
from ..scene_file.nodes import shorten
from ..xml_tree import XmlElement
from .expressions import PI, to_degrees
from .materials import GdmlMaterial, MaterialTable, find_material, read_color_hint
from .solid_template import SolidTemplate
from .solids import SolidTable, read_template
from .values import (
    UNIT_SCALE,
    GdmlError,
    GdmlReader,
    GdmlUnsupported,
    GdmlValues,
    compose_rotations,
    local_tag,
    look_up,
    operand_rotation,
    placement_rotation,
    read_motion,
    read_reference,
    scaling,
    strip_pointer,
)

MAX_PLACEMENTS = 2_000_000
"""Volumes that are placed in others, before those that stand at several places are counted more than once."""


@dataclass(eq=False)
class LogicalVolume:
    """A solid of a material, with volumes in it; an assembly has neither, only volumes."""

    name: str
    element: XmlElement
    template: SolidTemplate | None
    material: GdmlMaterial | None
    source: XmlElement | None = None  # of the solid
    daughters: list[PhysicalVolume] = field(default_factory=list)
    is_assembly: bool = False
    is_filled: bool = False  # by replicas, all of it
    is_container: bool = False  # around bodies of a scene that was exported: no body itself
    counted: int | None = None

    @property
    def is_open(self) -> bool:
        """Is it no level of its own, as what is in it stands beside it?"""
        return self.is_assembly or self.is_container


@dataclass(eq=False, slots=True)
class PhysicalVolume:
    """A volume within another: turned, then shifted."""

    label: str
    volume: LogicalVolume
    shift: Point = ORIGIN
    rotation: CellRotation = NO_ROTATION
    copy: int | None = None


@dataclass
class StructureReader:
    """What is known while volumes are read. `module` reads another file and gives one of its volumes."""

    reading: GdmlReader
    solids: SolidTable
    sources: dict[str, XmlElement]
    materials: MaterialTable
    module: Callable[[XmlElement], LogicalVolume]
    volumes: dict[str, LogicalVolume] = field(default_factory=dict)
    placed: int = 0
    colored: dict[tuple[GdmlMaterial, str], GdmlMaterial] = field(default_factory=dict)

    def read(self, section: XmlElement) -> None:
        """All volumes; one may hold only those before it, as Geant4 demands, so that none holds itself."""
        for element in self.reading.each(section.children):
            tag = local_tag(element)
            if tag in ("volume", "assembly"):
                self._attempt(element, StructureReader._volume)
            elif tag not in ("bordersurface", "skinsurface", "userinfo"):
                self.reading.remark(element, tag, "is nothing that is known in a structure, left out")

    def _attempt(self, element: XmlElement, read: Callable[..., None], *of: LogicalVolume) -> None:
        try:
            read(self, *of, element)
        except GdmlError as mistake:
            self.reading.report(mistake.element, _volume_title(element), mistake.message)
        except GdmlUnsupported as left:
            self.reading.remark(element, _volume_title(element), f"{left}; left out")
        except (ValueError, OverflowError) as error:
            self.reading.report(element, _volume_title(element), str(error))

    def _volume(self, element: XmlElement) -> None:
        name = self.reading.solved(element.attributes.get("name", ""), element)
        if not name:
            raise GdmlError(element, "name must be given")
        volume = LogicalVolume(name, element, None, None, is_assembly=local_tag(element) == "assembly")
        try:
            for child in element.children:
                if child.tag == "solidref":
                    solid = read_reference(self.reading, child)
                    if solid not in self.solids:
                        look_up(self.reading, dict(self.solids), solid, child, "solid")
                    volume.template, volume.source = self.solids[solid], self.sources.get(solid)
                elif child.tag == "materialref":
                    volume.material = self._colored(self._material(child), element)
            if not volume.is_assembly and not element.all("solidref"):
                raise GdmlError(element, "must have a solidref")
        finally:
            self.volumes[name] = volume  # so that what refers to it is no second mistake
        if any(_is_container(child) for child in element.children):
            volume.template, volume.is_container = None, True
        readers = _placement_readers()
        for child in self.reading.each(element.children):
            read = readers.get(local_tag(child))
            if read is not None:
                self._attempt(child, read, volume)

    def _material(self, child: XmlElement) -> GdmlMaterial:
        name = read_reference(self.reading, child)
        found = find_material(self.reading, self.materials, name)
        if found is None:
            told = self.reading.suggest(name, self.materials)
            raise GdmlError(child, f"there is no material {shorten(name)!r}{told}")
        return found

    def _colored(self, material: GdmlMaterial, element: XmlElement) -> GdmlMaterial:
        """In the colour that a volume is to have; what is invisible stays so."""
        color = read_color_hint(self.reading, element)
        if color is None or color == material.color or material.is_thin:
            return material
        return self.colored.setdefault((material, color), replace(material, hint=color))

    def volume_in(self, element: XmlElement) -> LogicalVolume:
        """The volume that a placement is of."""
        for child in element.children:
            if child.tag == "volumeref":
                found: LogicalVolume = look_up(
                    self.reading, self.volumes, read_reference(self.reading, child), child, "volume"
                )
                return found
            if child.tag == "file":
                return self.module(child)
        raise GdmlError(element, "must have a volumeref or a file")

    def add(self, volume: LogicalVolume, daughter: PhysicalVolume) -> None:
        """One more placement. LeftOut where there are too many."""
        if daughter.volume is volume:
            raise GdmlError(volume.element, "is placed in itself")
        self.placed += 1
        if self.placed > MAX_PLACEMENTS:
            raise GdmlError(volume.element, f"there are more than {MAX_PLACEMENTS:,} placements")
        volume.daughters.append(daughter)

    def _physvol(self, volume: LogicalVolume, element: XmlElement) -> None:
        inner = self.volume_in(element)
        shift, rotation, scale = read_motion(self.reading, element, placement_rotation)
        if scale is not UNIT_SCALE and any(factor != 1 for factor in scale):
            rotation = compose_rotations(rotation, scaling(scale))
        name = self.reading.solved(element.attributes.get("name", ""), element) or inner.name
        copy = None
        if "copynumber" in element.attributes:
            copy = GdmlValues(self.reading, element).integer("copynumber", most=2**31, least=-(2**31))
        self.add(volume, PhysicalVolume(strip_pointer(name), inner, shift, rotation, copy))


def _placement_readers() -> dict[str, Callable[[StructureReader, LogicalVolume, XmlElement], None]]:
    """What reads the elements that place volumes."""
    return {
        "physvol": StructureReader._physvol, "replicavol": read_replicas, "divisionvol": read_divisions,
        "paramvol": read_parameterised,
    }  # fmt: skip


def _volume_title(element: XmlElement) -> str:
    return f"{local_tag(element)} {element.attributes.get('name', '')!r}"


def _is_container(element: XmlElement) -> bool:
    """Does it say that a volume is only there because a world must be?"""
    given = element.attributes
    return element.tag == "auxiliary" and (given.get("auxtype"), given.get("auxvalue")) == ("Conicoid", "container")


def resolve_module_file(path: str, name: str) -> str:
    """A file in the folder of another. Raises ValueError for one elsewhere."""
    if not name or os.path.basename(name) != name or name in (".", "..") or "\0" in name or "\\" in name:
        raise ValueError(f"file must be the name of a file in the same folder, got {shorten(name)!r}")
    folder = os.path.dirname(os.path.abspath(path))
    found = os.path.join(folder, name)
    if os.path.realpath(found) != os.path.join(os.path.realpath(folder), name):
        raise ValueError(f"file must be in the same folder, and {shorten(name)!r} is a link")
    return found


# Volumes that stand in their mother many times by a rule: replicas, parameterised volumes; and what divisions need.

MAX_COPIES = 1_000_000


def axis_shift(axis: str, amount: Fraction) -> Point:
    """A shift along x, y or z."""
    none = Fraction(0)
    return (amount if axis == "x" else none, amount if axis == "y" else none, amount if axis == "z" else none)


def rotation_about_z(radians: Fraction) -> CellRotation:
    """Counter-clockwise."""
    return operand_rotation((Fraction(0), Fraction(0), to_degrees(radians)))


def read_replicas(structure: StructureReader, volume: LogicalVolume, element: XmlElement) -> None:
    """<replicavol number><replicate_along_axis><direction/><width/><offset/>: they fill the mother."""
    inner = structure.volume_in(element)
    count = GdmlValues(structure.reading, element).integer("number", most=MAX_COPIES)
    rule = next((child for child in element.children if child.tag in ("replicate_along_axis", "replicate")), None)
    if rule is None:
        raise GdmlError(element, "must have a replicate_along_axis element")
    axis = _replica_direction(structure, rule)
    width, offset = (_replica_measure(structure, rule, name) for name in ("width", "offset"))
    if width <= 0 or count < 1:
        raise GdmlError(rule, "width must be > 0 and number 1 or more")
    base = strip_pointer(element.attributes.get("name", "") or inner.name)
    for k in range(count):
        part, shift, rotation = inner, ORIGIN, NO_ROTATION
        if axis == "phi":
            rotation = rotation_about_z(offset + (k + Fraction(1, 2)) * width)
        elif axis == "rho":
            changes = {"rmin": offset + k * width, "rmax": offset + (k + 1) * width}
            part = resize_volume(structure, element, inner, inner.source, changes, ("tube",))
        else:
            shift = axis_shift(axis, (k - Fraction(count - 1, 2)) * width)
        structure.add(volume, PhysicalVolume(base, part, shift, rotation, k))
    volume.is_filled = _fills_mother(structure, volume, axis, count * width)


def _fills_mother(structure: StructureReader, volume: LogicalVolume, axis: str, width: Fraction) -> bool:
    """Do replicas leave nothing of their mother? Of a box along an axis, if they are as long."""
    source = volume.source
    if source is None or local_tag(source) != "box" or axis not in ("x", "y", "z"):
        return False
    return GdmlValues(structure.reading, source).length(axis) == width


def _replica_direction(structure: StructureReader, rule: XmlElement) -> str:
    for child in rule.children:
        if child.tag == "direction":
            for axis in ("x", "y", "z", "rho", "phi"):
                if axis in child.attributes and structure.reading.value(child.attributes[axis], child, axis) == 1:
                    return axis
    raise GdmlError(rule, "must have a direction element with one of x, y, z, rho, phi = 1")


def _replica_measure(structure: StructureReader, rule: XmlElement, tag: str) -> Fraction:
    """A width or an offset, in mm or radians."""
    for child in rule.children:
        if child.tag == tag:
            values = GdmlValues(structure.reading, child)
            return values.number("value") * structure.reading.value(child.attributes.get("unit") or "1", child, "unit")
    return Fraction(0)


def resize_volume(
    structure: StructureReader,
    element: XmlElement,
    inner: LogicalVolume,
    source: XmlElement | None,
    changes: dict[str, Fraction],
    kinds: tuple[str, ...],
    sections: tuple[Point, ...] | None = None,
    kind: str | None = None,
) -> LogicalVolume:
    """A volume with a solid whose attributes, or sections (z, rmin, rmax), are other numbers, in mm and radians.

    kind: of which the solid becomes, of the changes alone.
    """
    if source is None or local_tag(source) not in kinds:
        raise GdmlUnsupported(f"is of what is no {' and no '.join(kinds)}, which is not built yet")
    reading = structure.reading
    if inner.source is not None and _is_whole_slice(structure, inner.source, source, changes):
        return inner
    units = {name: reading.value(source.attributes.get(name, unit), source, name) for name, unit in _UNITS.items()}
    given = dict(source.attributes) if kind is None else {"name": inner.name}
    if kind is not None:
        units = {"lunit": Fraction(1), "aunit": Fraction(1)}
    for name, value in changes.items():
        unit = units["aunit" if name.endswith("phi") else "lunit"] if name != "numsides" else Fraction(1)
        given[name] = _format_expression(value / unit)
    children = source.children
    if sections is not None:
        rows = [[_format_expression(value / units["lunit"]) for value in section] for section in sections]
        children = [
            XmlElement("zplane", source.line, source.column, dict(zip(("z", "rmin", "rmax"), row, strict=True)))
            for row in rows
        ]
    made = XmlElement(kind or source.tag, source.line, source.column, given, children)
    template = read_template(reading, made, {})
    return replace(inner, template=template, source=made, is_filled=False)


def _is_whole_slice(
    structure: StructureReader, own: XmlElement, source: XmlElement, changes: dict[str, Fraction]
) -> bool:
    """Is a volume's own solid, a box, what a slice of its mother is?"""
    if local_tag(own) != "box" or local_tag(source) != "box":
        return False
    mine, its = GdmlValues(structure.reading, own), GdmlValues(structure.reading, source)
    return all(mine.length(axis) == changes.get(axis, its.length(axis)) for axis in "xyz")


_UNITS = {"lunit": "mm", "aunit": "rad"}


def _format_expression(value: Fraction) -> str:
    """As an expression."""
    return f"{value.numerator}/{value.denominator}"


_SAME_DIMENSIONS = {
    "trd": "x1 x2 y1 y2 z", "sphere": "rmin rmax startphi deltaphi starttheta deltatheta",
    "cone": "rmin1 rmax1 rmin2 rmax2 z startphi deltaphi", "box": "x y z", "orb": "r",
    "trap": "z theta phi y1 x1 x2 alpha1 y2 x3 x4 alpha2", "para": "x y z alpha theta phi",
    "ellipsoid": "ax by cz zcut1 zcut2", "hype": "rmin rmax inst outst z",
}  # fmt: skip
_DIMENSIONS: dict[str, dict[str, str]] = {
    **{kind: {name: name for name in names.split()} for kind, names in _SAME_DIMENSIONS.items()},
    "tube": {"InR": "rmin", "OutR": "rmax", "hz": "z", "StartPhi": "startphi", "DeltaPhi": "deltaphi"},
    "polycone": {"startPhi": "startphi", "openPhi": "deltaphi"},
    "polyhedra": {"startPhi": "startphi", "openPhi": "deltaphi", "numSide": "numsides"},
}
"""How the attributes of <box_dimensions> and others are called in <box>."""


def read_parameterised(structure: StructureReader, volume: LogicalVolume, element: XmlElement) -> None:
    """<paramvol><parameterised_position_size><parameters><position/><rotation/><box_dimensions/>."""
    inner = structure.volume_in(element)
    base = strip_pointer(element.attributes.get("name", "") or inner.name)
    number = 0
    for rule in element.children:
        if rule.tag != "parameterised_position_size":
            continue
        for parameters in structure.reading.each(rule.children):
            if local_tag(parameters) != "parameters":
                continue
            shift, rotation, _ = read_motion(structure.reading, parameters, placement_rotation)
            part = inner
            for child in parameters.children:
                if child.tag.endswith("_dimensions"):
                    part = _resize_copy(structure, inner, child)
            structure.add(volume, PhysicalVolume(base, part, shift, rotation, number))
            number += 1
    if not number:
        raise GdmlError(element, "must have parameters elements")


def _resize_copy(structure: StructureReader, inner: LogicalVolume, dimensions: XmlElement) -> LogicalVolume:
    kind = dimensions.tag.removesuffix("_dimensions")
    if kind not in _DIMENSIONS:
        raise GdmlUnsupported(f"has {dimensions.tag}, which is no solid that is read")
    given = {new: dimensions.attributes[old] for old, new in _DIMENSIONS[kind].items() if old in dimensions.attributes}
    given |= {name: dimensions.attributes[name] for name in _UNITS if name in dimensions.attributes}
    made = XmlElement(kind, dimensions.line, dimensions.column, given, dimensions.children)
    try:
        template = read_template(structure.reading, made, {})
    except ValueError as error:
        raise GdmlError(dimensions, str(error)) from None
    return replace(inner, template=template, source=made, is_filled=False)


# <divisionvol>: slices of the mother's solid along an axis, as Geant4 divides each kind (geometry/divisions).

_DIVISION_AXES = {"kXAxis": "x", "kYAxis": "y", "kZAxis": "z", "kRho": "rho", "kPhi": "phi"}
_ROUNDING = Fraction(1, 10**9)
DIVISIBLE_KINDS = ("box", "tube", "cone", "trd", "para", "polycone", "polyhedra")

SolidChanges = dict[str, Fraction]


@dataclass(frozen=True)
class DivisionSlice:
    """What is changed of the mother's solid, in mm and radians; its sections in z, if it has such; where it stands."""

    changes: SolidChanges
    shift: Point = ORIGIN
    rotation: CellRotation = NO_ROTATION
    sections: tuple[Point, ...] | None = None
    kind: str | None = None


def read_divisions(structure: StructureReader, volume: LogicalVolume, element: XmlElement) -> None:
    """<divisionvol axis number width offset unit>: slices of the mother; they replace the solid of the volume."""
    reading, inner = structure.reading, structure.volume_in(element)
    axis = _DIVISION_AXES.get(element.attributes.get("axis", ""))
    if axis is None:
        raise GdmlError(element, f"axis must be one of {', '.join(_DIVISION_AXES)}")
    source = volume.source
    if source is None or local_tag(source) not in DIVISIBLE_KINDS:
        raise GdmlUnsupported(f"divides what is no {', '.join(DIVISIBLE_KINDS[:-1])} or {DIVISIBLE_KINDS[-1]}")
    given = GdmlValues(reading, element)
    unit = reading.value(element.attributes.get("unit") or "mm", element, "unit")
    width, offset = given.number("width", 0) * unit, given.number("offset", 0) * unit
    count = given.integer("number", 0, MAX_COPIES)
    mother = _DividedSolid(structure, source)
    whole = mother.extent(axis)
    by_number = count > 0 and not width
    if not count:
        if width <= 0:
            raise GdmlError(element, "number or width must be given")
        count = int((whole - offset) / width + _ROUNDING)
    width = width or (whole - offset) / count
    if width <= 0 or offset < 0 or not 0 < count <= MAX_COPIES or offset + count * width > whole * (1 + _ROUNDING):
        raise GdmlError(element, "number, width and offset must fit into the mother")
    base = strip_pointer(element.attributes.get("name", "") or inner.name)
    for k, part in enumerate(mother.slices(axis, width, offset, count, by_number)):
        made = resize_volume(
            structure,
            element,
            inner,
            source,
            part.changes,
            kinds=DIVISIBLE_KINDS,
            sections=part.sections,
            kind=part.kind,
        )
        structure.add(volume, PhysicalVolume(base, made, part.shift, part.rotation, k))
    volume.is_filled = offset == 0 and count * width == whole


class _DividedSolid:
    """The solid that is divided."""

    def __init__(self, structure: StructureReader, source: XmlElement) -> None:
        self.values, self.kind = GdmlValues(structure.reading, source), local_tag(source)
        self.sections: list[Point] = []
        for child in source.all("zplane"):
            part = GdmlValues(structure.reading, child, source)
            self.sections.append((part.length("z"), part.radius("rmin"), part.radius("rmax")))
        self.sections.sort(key=lambda section: section[0])
        if self.kind in ("polycone", "polyhedra") and len(self.sections) < 2:
            raise GdmlUnsupported("divides a solid without sections")

    def extent(self, axis: str) -> Fraction:
        """How much there is to be divided, in mm or radians. Raises LeftOut for an axis that the kind has not."""
        values, kind = self.values, self.kind
        if axis == "phi" and kind in ("tube", "cone", "polycone", "polyhedra"):
            return values.angle("deltaphi", 360) * PI / 180
        if axis == "rho" and kind == "tube":
            return values.length("rmax") - values.length("rmin", 0)
        if axis == "rho" and kind == "cone":
            return values.length("rmax1") - values.length("rmin1", 0)
        if self.sections and axis == "rho":
            return self.sections[0][2] - self.sections[0][1]
        if self.sections and axis == "z":
            return self.sections[-1][0] - self.sections[0][0]
        if axis in ("x", "y") and kind == "trd":
            return (values.length(f"{axis}1") + values.length(f"{axis}2")) / 2
        if axis in ("x", "y", "z") and (kind in ("box", "para") or (axis == "z" and not self.sections)):
            return values.length(axis)
        raise GdmlUnsupported(f"divides a {kind} along {axis}, which Geant4 does not either")

    def slices(
        self, axis: str, width: Fraction, offset: Fraction, count: int, by_number: bool
    ) -> Iterator[DivisionSlice]:
        """One after the other."""
        if axis == "phi":
            yield from self._about(width, offset, count)
        elif self.sections:
            yield from self._of_sections(axis, width, offset, count, by_number)
        else:
            for k in range(count):
                yield self._slice(axis, offset + k * width, offset + (k + 1) * width, k, count, offset)

    def _about(self, width: Fraction, offset: Fraction, count: int) -> Iterator[DivisionSlice]:
        start = self.values.angle("startphi", 0) * PI / 180
        changes = {"startphi": start, "deltaphi": width}
        if self.kind == "polyhedra":
            sides = self.values.integer("numsides", most=10_000)
            each = width / (self.extent("phi") / sides)
            if abs(each - round(each)) > _ROUNDING or round(each) < 1:
                raise GdmlUnsupported("divides a polyhedra across its sides, which Geant4 does not either")
            changes["numsides"] = Fraction(round(each))
        for k in range(count):
            yield DivisionSlice(changes, rotation=rotation_about_z(offset + k * width))

    def _slice(self, axis: str, low: Fraction, high: Fraction, k: int, count: int, offset: Fraction) -> DivisionSlice:
        values, middle = self.values, (low + high) / 2
        if self.kind == "tube" and axis == "rho":
            inner = values.length("rmin", 0)
            return DivisionSlice({"rmin": inner + low, "rmax": inner + high})
        if self.kind == "cone" and axis == "rho":
            first, second = values.length("rmin1", 0), values.length("rmin2", 0)
            wide = (values.length("rmax2") - second - offset) / count
            begin = second + offset + k * wide
            return DivisionSlice({"rmin1": first + low, "rmax1": first + high, "rmin2": begin, "rmax2": begin + wide})
        whole = self.extent(axis)
        shift = axis_shift(axis, middle - whole / 2)
        if self.kind == "para":
            return DivisionSlice({axis: high - low}, self._leaning(axis, middle - whole / 2))
        if axis == "z" and self.kind in ("cone", "trd"):
            return DivisionSlice(self._between(low / whole, high / whole) | {"z": high - low}, shift)
        if self.kind == "trd":
            return self._of_trd(axis, low, high, shift)
        return DivisionSlice({axis: high - low}, shift)

    def _leaning(self, axis: str, amount: Fraction) -> Point:
        """A shift along an axis of a parallelepiped."""
        from .flat_solids import exact_tangent, read_lean

        if axis == "y":
            return amount * exact_tangent(self.values.angle("alpha", 0)), amount, Fraction(0)
        if axis == "z":
            x, y = read_lean(self.values)
            return x * amount, y * amount, amount
        return axis_shift(axis, amount)

    def _between(self, low: Fraction, high: Fraction) -> SolidChanges:
        """The sizes of both ends of a slice of what goes evenly with z, from shares of the height."""
        found: SolidChanges = {}
        for name in ("rmin", "rmax") if self.kind == "cone" else ("x", "y"):
            ends = [self.values.length(f"{name}{end}", 0) for end in (1, 2)]
            for end, share in ((1, low), (2, high)):
                found[f"{name}{end}"] = ends[0] + (ends[1] - ends[0]) * share
        return found

    def _of_trd(self, axis: str, low: Fraction, high: Fraction, shift: Point) -> DivisionSlice:
        """Slices of one width; where the sides lean, they share both ends alike and lean with them."""
        a, b = self.values.length(f"{axis}1"), self.values.length(f"{axis}2")
        if a == b:
            return DivisionSlice({f"{axis}1": high - low, f"{axis}2": high - low}, shift)
        other = "y" if axis == "x" else "x"
        corners: SolidChanges = {"dz": self.values.length("z") / 2}
        number = 1
        for size, end in ((a, 1), (b, 2)):
            ends = [size * (2 * each / (a + b) - Fraction(1, 2)) for each in (low, high)]
            wide = self.values.length(f"{other}{end}") / 2
            for first, second in ((ends[0], -wide), (ends[0], wide), (ends[1], wide), (ends[1], -wide)):
                x, y = (first, second) if axis == "x" else (second, first)
                corners |= {f"v{number}x": x, f"v{number}y": y}
                number += 1
        return DivisionSlice(corners, kind="arb8")

    def _of_sections(
        self, axis: str, width: Fraction, offset: Fraction, count: int, by_number: bool
    ) -> Iterator[DivisionSlice]:
        sections = self.sections
        if axis == "z":
            begin, kinks = sections[0][0], [z for z, _, _ in sections]
            ends = [begin + offset + k * width for k in range(count + 1)]
            if by_number:  # of which there must be as many as sections, and are these
                if count != len(sections) - 1:
                    raise GdmlUnsupported(
                        f"has {count} slices of {len(sections) - 1} sections, which Geant4 does not divide either"
                    )
                ends = kinks
            for low, high in pairwise(ends):
                inside = [z for z in kinks if low < z < high]
                yield DivisionSlice({}, sections=tuple(self._at(z) for z in (low, *inside, high)))
            return
        for k in range(count):
            found = []
            for number, (z, inner, outer) in enumerate(sections):
                wide = width if number == 0 else (outer - inner - offset) / count
                found.append((z, inner + offset + k * wide, inner + offset + (k + 1) * wide))
            yield DivisionSlice({}, sections=tuple(found))

    def _at(self, z: Fraction) -> Point:
        """The section at a height."""
        for (z0, a, b), (z1, c, d) in pairwise(self.sections):
            if z0 <= z <= z1 and z0 < z1:
                share = (z - z0) / (z1 - z0)
                return z, a + (c - a) * share, b + (d - b) * share
        return self.sections[-1]
