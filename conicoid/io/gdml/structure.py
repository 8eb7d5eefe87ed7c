"""The <structure> section of a GDML file: logical volumes and the volumes placed in them.

`StructureReader` reads volumes, assemblies and physical volumes. The functions after it read what places a volume many
times by a rule: replicas, parameterised volumes and divisions.
"""

from __future__ import annotations

import dataclasses
from collections import Counter
from collections.abc import Callable
from dataclasses import field, replace
from fractions import Fraction
from itertools import chain

from ..._util.records import dataclass
from ..importers import OmittedPart
from ..openmc.placement import NO_ROTATION, ORIGIN, CellRotation, Point
from ..scene_file.nodes import shorten
from ..xml_tree import XmlElement
from .divided_solid import DIVISIBLE_KINDS, ROUNDING, DividedSolid, DivisionSlice, axis_shift
from .expressions import PI, to_degrees
from .solid_template import SolidTemplate, combine_templates
from .solids import SolidTable, read_template
from .values import (
    UNIT_SCALE,
    GdmlError,
    GdmlMaterial,
    GdmlReader,
    GdmlValues,
    MaterialTable,
    compose_rotations,
    find_material,
    local_tag,
    look_up,
    operand_rotation,
    placement_rotation,
    read_color_hint,
    read_motion,
    read_placement,
    read_reference,
    scaling,
    strip_pointer,
)

MAX_PLACEMENTS = 2_000_000
"""Most placements in a file, each counted once however often its mother is placed."""


@dataclass(eq=False)
class LogicalVolume:
    """A solid of a material with daughter volumes; an assembly has daughters only."""

    name: str
    element: XmlElement
    template: SolidTemplate | None
    material: GdmlMaterial | None
    source: XmlElement | None = None  # element of the solid
    daughters: list[PhysicalVolume] = field(default_factory=list)
    is_assembly: bool = False
    is_filled: bool = False  # replicas or slices leave nothing of it
    is_container: bool = False  # world around the bodies of an exported scene: no body itself
    inner_rotation: CellRotation = NO_ROTATION  # of the daughters, not of the solid
    body_count: int | None = None

    @property
    def is_open(self) -> bool:
        """Return True if the volume counts as no level: its daughters belong to the level of its siblings."""
        return self.is_assembly or self.is_container


@dataclasses.dataclass(eq=False, slots=True)
class PhysicalVolume:
    """A volume placed in another: rotated, then shifted (mm).

    `azimuth` is the angle of a rotation about z alone, counter-clockwise in degrees; None for other rotations.
    """

    label: str
    volume: LogicalVolume
    shift: Point = ORIGIN
    rotation: CellRotation = NO_ROTATION
    copy: int | None = None
    azimuth: Fraction | None = None


@dataclass
class StructureReader:
    """The state of reading volumes. `module` reads another file and returns one of its volumes.

    `sources` holds the elements of solids by name; `placed` counts placements; `colored` caches recoloured materials.
    """

    reading: GdmlReader
    solids: SolidTable
    sources: dict[str, XmlElement]
    materials: MaterialTable
    module: Callable[[XmlElement], LogicalVolume]
    volumes: dict[str, LogicalVolume] = field(default_factory=dict)
    placed: int = 0
    colored: dict[tuple[GdmlMaterial, str], GdmlMaterial] = field(default_factory=dict)

    def read(self, section: XmlElement) -> None:
        """Read the volumes of a section and report errors.

        A volume may hold only volumes before it, as Geant4 demands, so that no volume contains itself.
        """
        for element in self.reading.each(section.children):
            tag = local_tag(element)
            if tag in ("volume", "assembly"):
                self._attempt(element, StructureReader._volume)
            # Optical surfaces describe reflection between volumes for Geant4's optical photons; they are no geometry
            elif tag not in ("bordersurface", "skinsurface", "userinfo"):
                self.reading.remark(element, tag, "is nothing that is known in a structure, left out")

    def _attempt(self, element: XmlElement, read: Callable[..., None], *mother: LogicalVolume) -> None:
        """Call a reader; report its errors, and remark elements that are left out."""
        try:
            read(self, *mother, element)
        except GdmlError as mistake:
            self.reading.report(mistake.element, _volume_title(element), mistake.message)
        # A file with one torus is still worth reading: the rest of it is imported, and the remark names what is missing
        except OmittedPart as left:
            self.reading.remark(element, _volume_title(element), f"{left}; left out")
        except (ValueError, OverflowError) as error:
            self.reading.report(element, _volume_title(element), str(error))

    def _volume(self, element: XmlElement) -> None:
        name = self.reading.resolve_indices(element.attributes.get("name", ""), element)
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
            self.volumes[name] = volume  # so that references to a wrong volume report no second error
        # A scene that was exported has no world of its own: without this mark it would come back with one more body
        if any(_is_container(child) for child in element.children):
            volume.template, volume.is_container = None, True
        readers = _placement_readers()
        for child in self.reading.each(element.children):
            read = readers.get(local_tag(child))
            if read is not None:
                self._attempt(child, read, volume)
        join_wedges(self, volume)

    def _material(self, child: XmlElement) -> GdmlMaterial:
        name = read_reference(self.reading, child)
        found = find_material(self.reading, self.materials, name)
        if found is None:
            hint = self.reading.suggest(name, self.materials)
            raise GdmlError(child, f"there is no material {shorten(name)!r}{hint}")
        return found

    def _colored(self, material: GdmlMaterial, element: XmlElement) -> GdmlMaterial:
        """Return the material in the colour that the volume hints at; invisible materials stay invisible."""
        color = read_color_hint(self.reading, element)
        # A colour hint must not make the air of a hall visible
        if color is None or color == material.color or material.is_thin:
            return material
        # One object for each colour, so that bodies of equal look share a material
        return self.colored.setdefault((material, color), replace(material, hint=color))

    def volume_in(self, element: XmlElement) -> LogicalVolume:
        """Return the volume that a placement names. Raise GdmlError if it names none or an unknown one."""
        for child in element.children:
            if child.tag == "volumeref":
                return look_up(self.reading, self.volumes, read_reference(self.reading, child), child, "volume")
            if child.tag == "file":
                return self.module(child)
        raise GdmlError(element, "must have a volumeref or a file")

    def add(self, volume: LogicalVolume, daughter: PhysicalVolume) -> None:
        """Add a daughter. Raise GdmlError if it is the volume itself, or after `MAX_PLACEMENTS` placements."""
        # A longer circle cannot occur, since names refer back only
        if daughter.volume is volume:
            raise GdmlError(volume.element, "is placed in itself")
        self.placed += 1
        if self.placed > MAX_PLACEMENTS:
            raise GdmlError(volume.element, f"there are more than {MAX_PLACEMENTS:,} placements")
        volume.daughters.append(daughter)

    def _physvol(self, volume: LogicalVolume, element: XmlElement) -> None:
        inner = self.volume_in(element)
        shift, angles, scale = read_placement(self.reading, element)
        rotation = placement_rotation(angles) if any(angles) else NO_ROTATION
        azimuth = None if angles[0] or angles[1] else -angles[2]
        # G4GDMLReadStructure reflects and scales the volume before it rotates it
        if scale is not UNIT_SCALE and any(factor != 1 for factor in scale):
            rotation, azimuth = compose_rotations(rotation, scaling(scale)), None
        name = self.reading.resolve_indices(element.attributes.get("name", ""), element) or inner.name
        copy = None
        # Copy numbers are C++ ints in Geant4, so a wider one is a mistake
        if "copynumber" in element.attributes:
            copy = GdmlValues(self.reading, element).integer("copynumber", most=2**31 - 1, least=-(2**31))
        self.add(volume, PhysicalVolume(strip_pointer(name), inner, shift, rotation, copy, azimuth))


def _placement_readers() -> dict[str, Callable[[StructureReader, LogicalVolume, XmlElement], None]]:
    """Return the readers of elements that place volumes, by tag."""
    return {
        "physvol": StructureReader._physvol, "replicavol": read_replicas, "divisionvol": read_divisions,
        "paramvol": read_parameterised,
    }  # fmt: skip


def _volume_title(element: XmlElement) -> str:
    return f"{local_tag(element)} {element.attributes.get('name', '')!r}"


def _is_container(element: XmlElement) -> bool:
    """Return True for the <auxiliary> by which Conicoid's export marks a world that is no body of the scene."""
    attributes = element.attributes
    kind = attributes.get("auxtype"), attributes.get("auxvalue")
    return element.tag == "auxiliary" and kind == ("Conicoid", "container")


# Replicas and parameterised volumes: one volume placed many times in its mother by a rule.

MAX_COPIES = 1_000_000


def _place_around(
    structure: StructureReader, volume: LogicalVolume, label: str, part: LogicalVolume, radians: Fraction, copy: int
) -> None:
    """Place a copy rotated about z, counter-clockwise."""
    azimuth = to_degrees(radians)
    rotation = operand_rotation((*ORIGIN[:2], azimuth))
    structure.add(volume, PhysicalVolume(label, part, ORIGIN, rotation, copy, azimuth))


def read_replicas(structure: StructureReader, volume: LogicalVolume, element: XmlElement) -> None:
    """Place the copies of <replicavol number><replicate_along_axis><direction/><width/><offset/>.

    Copies along x, y or z are shifted, copies along phi are rotated, and copies along rho are tubes of other radii.
    """
    inner = structure.volume_in(element)
    count = GdmlValues(structure.reading, element).integer("number", most=MAX_COPIES)
    rule = next((child for child in element.children if child.tag in ("replicate_along_axis", "replicate")), None)
    if rule is None:
        raise GdmlError(element, "must have a replicate_along_axis element")
    axis = _replica_direction(structure, rule)
    width, offset = (_replica_measure(structure, rule, name) for name in ("width", "offset"))
    if width <= 0 or count < 1:
        raise GdmlError(rule, f"width must be > 0 and number 1 or more, got {float(width):g} and {count}")
    base = strip_pointer(element.attributes.get("name", "") or inner.name)
    if axis == "phi":
        # G4PVReplica: the frame of a copy points to the middle of its sector, and `offset` is where the first begins
        for k in range(count):
            _place_around(structure, volume, base, inner, offset + k * width + width / 2, k)
        return
    for k in range(count):
        part, shift = inner, ORIGIN
        if axis == "rho":
            # Copies along rho stand in one place, so each is a volume of its own size, which Geant4 computes while it
            # navigates
            changes = {"rmin": offset + k * width, "rmax": offset + (k + 1) * width}
            part = resize_volume(structure, inner, inner.source, changes, ("tube",))
        else:
            shift = axis_shift(axis, (k - Fraction(count - 1, 2)) * width)  # centred on the mother
        structure.add(volume, PhysicalVolume(base, part, shift, NO_ROTATION, k))
    volume.is_filled = _fills_mother(structure, volume, axis, count * width)


_WEDGE_KINDS = ("tube", "cone", "sphere", "polycone", "genericPolycone", "polyhedra", "genericPolyhedra")
_FLAT_WEDGES = ("polyhedra", "genericPolyhedra")
_CLOSE_DEGREES = Fraction(1, 10**7)
"""Angles that differ by less differ by their rounding in the file."""


def join_wedges(structure: StructureReader, mother: LogicalVolume) -> None:
    """Give daughters that stand side by side around an axis along z one angle for both where they touch.

    Where degrees or their sums are no floats, rotated copies of one solid would miss their neighbours by a rounding.
    Then each wedge is a solid of its own that stands unrotated, from the angle that ends its neighbour to the next, and
    only its daughters are rotated. Placements, replicas and divisions are treated alike.
    """
    sites: dict[tuple[Fraction, Fraction], list[tuple[PhysicalVolume, Fraction, Fraction]]] = {}
    ranges: dict[int, tuple[Fraction, Fraction] | None] = {}
    for daughter in mother.daughters:
        source = daughter.volume.source
        if daughter.azimuth is None:
            continue
        if id(source) not in ranges:
            ranges[id(source)] = _wedge_range(structure, source)
        extent = ranges[id(source)]
        if extent is not None:
            begin, end = (angle + daughter.azimuth for angle in extent)
            sites.setdefault(daughter.shift[:2], []).append((daughter, begin, end))
    walls = (_wedge_range(structure, mother.source) or ()) if sites else ()
    for site, wedges in sites.items():
        if len({daughter.azimuth for daughter, _, _ in wedges}) > 1:
            _join_site(structure, wedges, () if any(site) else walls)


def _wedge_range(structure: StructureReader, source: XmlElement | None) -> tuple[Fraction, Fraction] | None:
    """Return the angles at which a wedge begins and ends; None for a full turn and for other solids."""
    if source is None or local_tag(source) not in _WEDGE_KINDS:
        return None
    values = GdmlValues(structure.reading, source)
    begin, width = values.angle("startphi", 0), values.angle("deltaphi", 360)
    return (begin, begin + width) if 0 < width < 360 - _CLOSE_DEGREES else None


def _join_site(
    structure: StructureReader,
    wedges: list[tuple[PhysicalVolume, Fraction, Fraction]],
    walls: tuple[Fraction, ...],
) -> None:
    """Join wedges (daughter, first and last angle in degrees) about one axis; `walls` are those of the mother."""
    base = walls[0] if walls else Fraction(0)

    def reduce(angle: Fraction) -> Fraction:
        rest = (angle - base) % 360
        return base + (Fraction(0) if 360 - rest < _CLOSE_DEGREES else rest)

    ends = [tuple(reduce(angle) for angle in wedge[1:]) for wedge in wedges]
    known = [reduce(angle) for angle in walls]
    leaders: dict[Fraction, Fraction] = {}
    leader = base - 1
    for angle in sorted({*known, *chain.from_iterable(ends)}):
        # Walls of the mother stay where they are
        wall = next((wall for wall in known if abs(wall - angle) < _CLOSE_DEGREES), None)
        if wall is not None or angle - leader >= _CLOSE_DEGREES:
            leader = angle if wall is None else wall
        leaders[angle] = leader
    flat = [local_tag(daughter.volume.source) in _FLAT_WEDGES for daughter, _, _ in wedges if daughter.volume.source]
    # Normals of flat sides are rounded, so that rotated ones are none of those that a file would have there
    plain = [value for daughter, begin, end in wedges for value in (daughter.azimuth, begin, end)] + list(leaders)
    if not any(flat) and all(map(_is_float, plain)) and all(angle == end for angle, end in leaders.items()):
        return
    shares = Counter(leaders[angle] for angle in chain(known, *ends))
    for (daughter, _, _), angles, is_flat in zip(wedges, ends, flat, strict=True):
        low, high = (leaders[angle] for angle in angles)
        if max(shares[low], shares[high]) < 2:
            continue
        # The angles of flat sides are sums of the exact ones
        low, high = (low, high) if is_flat else (Fraction(float(low)), Fraction(float(high)))
        # A wedge that crosses 0: a float from 180 to 360, less 360, is a float
        low -= 360 if low >= high else 0
        changes = {"startphi": low * PI / 180, "deltaphi": (high - low) * PI / 180}
        inner = daughter.volume
        part = resize_volume(structure, inner, inner.source, changes, _WEDGE_KINDS)
        daughter.volume = replace(part, inner_rotation=daughter.rotation)
        daughter.rotation = NO_ROTATION


def _is_float(value: Fraction | None) -> bool:
    return value is not None and Fraction(float(value)) == value


def _fills_mother(structure: StructureReader, volume: LogicalVolume, axis: str, width: Fraction) -> bool:
    """Return True if replicas leave nothing of their mother: a box that is as long as they are along their axis."""
    source = volume.source
    # A mother of another kind stays a body, less its replicas
    if source is None or local_tag(source) != "box" or axis not in ("x", "y", "z"):
        return False
    # An equal length in fractions: with one of 10^-12 more the mother keeps a sliver, and a ray would see it
    return GdmlValues(structure.reading, source).length(axis) == width


def _replica_direction(structure: StructureReader, rule: XmlElement) -> str:
    for child in rule.children:
        if child.tag == "direction":
            for axis in ("x", "y", "z", "rho", "phi"):
                if axis in child.attributes and structure.reading.value(child.attributes[axis], child, axis) == 1:
                    return axis
    raise GdmlError(rule, "must have a direction element with one of x, y, z, rho, phi = 1")


def _replica_measure(structure: StructureReader, rule: XmlElement, tag: str) -> Fraction:
    """Return a width or an offset in mm or radians; 0 if the rule has none."""
    for child in rule.children:
        if child.tag == tag:
            values = GdmlValues(structure.reading, child)
            return values.number("value") * structure.reading.value(child.attributes.get("unit") or "1", child, "unit")
    return Fraction(0)


def resize_volume(
    structure: StructureReader,
    inner: LogicalVolume,
    source: XmlElement | None,
    changes: dict[str, Fraction],
    kinds: tuple[str, ...],
    sections: tuple[Point, ...] | None = None,
    kind: str | None = None,
) -> LogicalVolume:
    """Return the volume `inner` with a changed copy of the solid `source`.

    Parameters
    ----------
    structure
        The reader.
    inner
        The volume to be resized.
    source
        The element of the solid to start from.
    changes
        New values of attributes, in mm and radians.
    kinds
        Tags of solids that can be changed.
    sections
        New zplane elements (z, rmin, rmax) in mm, if any.
    kind
        The tag of a new solid that has the changed attributes only; None keeps tag and attributes of `source`.

    Raises
    ------
    OmittedPart
        The solid is of no such kind.

    """
    if source is None or local_tag(source) not in kinds:
        found = "another kind of solid" if source is None else f"<{local_tag(source)}>"
        raise OmittedPart(f"changes the size of {found}; copies are read of {', '.join(kinds)}")
    reading = structure.reading
    if inner.source is not None and _is_whole_slice(structure, inner.source, source, changes):
        return inner  # shares one template among all slices
    attributes = dict(source.attributes) if kind is None else {"name": inner.name}
    units = {name: reading.value(attributes.get(name, unit), source, name) for name, unit in _UNITS.items()}
    for name, value in changes.items():
        unit = units["aunit" if name.endswith("phi") else "lunit"] if name != "numsides" else Fraction(1)
        # The new element goes through the reader of its kind, so that a slice obeys the same checks as a written solid
        attributes[name] = _format_expression(value / unit)
    children = source.children
    if sections is not None:
        rows = [[_format_expression(value / units["lunit"]) for value in section] for section in sections]
        children = [
            XmlElement("zplane", source.line, source.column, dict(zip(("z", "rmin", "rmax"), row, strict=True)))
            for row in rows
        ]
    resized = XmlElement(kind or source.tag, source.line, source.column, attributes, children)
    template = read_template(reading, resized, {})
    return replace(inner, template=template, source=resized, is_filled=False)


def _is_whole_slice(
    structure: StructureReader, own: XmlElement, source: XmlElement, changes: dict[str, Fraction]
) -> bool:
    """Return True if the volume's own solid is a box of the size of a slice of its mother, also a box."""
    if local_tag(own) != "box" or local_tag(source) != "box":
        return False
    own_values, source_values = GdmlValues(structure.reading, own), GdmlValues(structure.reading, source)
    return all(own_values.length(axis) == changes.get(axis, source_values.length(axis)) for axis in "xyz")


_UNITS = {"lunit": "mm", "aunit": "rad"}


def _format_expression(value: Fraction) -> str:
    """Return a fraction as a GDML expression, which is read back exactly."""
    return f"{value.numerator}/{value.denominator}"


# G4GDMLReadParamvol has names of its own for a few attributes
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
"""For each kind of solid, the names of attributes in <kind_dimensions> and in <kind>."""


def read_parameterised(structure: StructureReader, volume: LogicalVolume, element: XmlElement) -> None:
    """Place the copies of <paramvol><parameterised_position_size><parameters>.

    Each <parameters> element has <position/>, <rotation/> and dimensions such as <box_dimensions/>.
    """
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
    """Return the volume with a solid of the given dimensions."""
    kind = dimensions.tag.removesuffix("_dimensions")
    if kind not in _DIMENSIONS:
        raise OmittedPart(f"has {dimensions.tag}, which is no solid that is read")
    present = dimensions.attributes
    attributes = {new: present[old] for old, new in _DIMENSIONS[kind].items() if old in present}
    attributes |= {name: present[name] for name in _UNITS if name in present}
    resized = XmlElement(kind, dimensions.line, dimensions.column, attributes, dimensions.children)
    try:
        template = read_template(structure.reading, resized, {})
    except ValueError as error:
        raise GdmlError(dimensions, str(error)) from None
    return replace(inner, template=template, source=resized, is_filled=False)


# Divisions: volumes with slices of the mother's solid.

_DIVISION_AXES = {"kXAxis": "x", "kYAxis": "y", "kZAxis": "z", "kRho": "rho", "kPhi": "phi"}


def read_divisions(structure: StructureReader, volume: LogicalVolume, element: XmlElement) -> None:
    """Place the slices of <divisionvol axis number width offset unit>; they replace the solid of the placed volume."""
    reading, inner = structure.reading, structure.volume_in(element)
    axis = _DIVISION_AXES.get(element.attributes.get("axis", ""))
    if axis is None:
        raise GdmlError(element, f"axis must be one of {', '.join(_DIVISION_AXES)}")
    source = volume.source
    if source is None or local_tag(source) not in DIVISIBLE_KINDS:
        raise OmittedPart(f"divides what is no {', '.join(DIVISIBLE_KINDS[:-1])} or {DIVISIBLE_KINDS[-1]}")
    values = GdmlValues(reading, element)
    unit = reading.value(element.attributes.get("unit") or "mm", element, "unit")
    width, offset = values.number("width", 0) * unit, values.number("offset", 0) * unit
    count = values.integer("number", 0, MAX_COPIES)
    mother = DividedSolid(reading, source)
    whole = mother.extent(axis)
    by_number = count > 0 and not width
    if not count:
        if width <= 0:
            raise GdmlError(element, "number or width must be given")
        count = int((whole - offset) / width + ROUNDING)  # angles are rounded: 3 slices may come out as 2.999...
    width = width or (whole - offset) / count
    most = whole * (1 + ROUNDING)
    # A ring may begin anywhere: ROOT writes offsets of -360 degrees
    misplaced = offset < 0 and (axis != "phi" or most < 2 * PI)
    if width <= 0 or misplaced or not 0 < count <= MAX_COPIES or count * width + max(offset, Fraction(0)) > most:
        ends = f"{float(offset):g} + {count:,} × {float(width):g}, of {float(whole):g} (mm or radians)"
        raise GdmlError(element, f"number, width and offset must fit into the mother, got {ends}")
    base = strip_pointer(element.attributes.get("name", "") or inner.name)
    if axis == "phi":
        changes = mother.wedge(width)
        part = resize_volume(structure, inner, source, changes, DIVISIBLE_KINDS)
        for k in range(count):
            _place_around(structure, volume, base, part, offset + k * width, k)
    else:
        leans = mother.leans(axis, by_number)
        for k, cut in enumerate(mother.slices(axis, width, offset, count, by_number)):
            part = resize_volume(structure, inner, source, cut.changes, DIVISIBLE_KINDS, cut.sections, cut.kind)
            if leans:
                part = replace(part, template=_cut_across(structure, volume, part, cut, axis))
            structure.add(volume, PhysicalVolume(base, part, cut.shift, copy=k))
    # Exact again: otherwise the mother stays, less its slices
    volume.is_filled = offset == 0 and count * width == whole


def _cut_across(
    structure: StructureReader, mother: LogicalVolume, part: LogicalVolume, cut: DivisionSlice, axis: str
) -> SolidTemplate:
    """Return the mother's solid between the ends of a slice across y or z, in the frame of the slice.

    A wall that leans, from other corners, would miss that of the mother by a rounding.
    """
    assert mother.template is not None
    assert part.source is not None
    values, (x, y, z) = DividedSolid(structure.reading, part.source), cut.shift
    height, low = values.extent("z"), values.sections[0][0] if values.sections else None
    middle = Fraction(0) if low is None else low + height / 2
    wide = _format_expression(values.reach)
    tag, sizes = "box", {"name": part.name, "x": wide, "y": wide, "z": _format_expression(height)}
    if axis == "y":
        wide = _format_expression(values.reach / values.values.length_unit)
        tag, sizes = part.source.tag, part.source.attributes | {"x": wide}
    slab = read_template(structure.reading, XmlElement(tag, part.source.line, part.source.column, sizes), {})
    whole = mother.template, (-x, -y, -z), NO_ROTATION
    return combine_templates("intersection", [whole, (slab, axis_shift("z", middle), NO_ROTATION)])
