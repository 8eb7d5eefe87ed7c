"""State of a GDML reader, the numbers of its elements, and the sections <define> and <materials>.

`GdmlReader` holds the defined names, unrolls loops and collects errors and remarks with their lines. `GdmlValues` reads
the attributes of one element in mm and degrees. `read_motion` and the rotation functions turn <position>, <rotation>
and <scale> into shifts and rotations. `read_defines` reads numbers, vectors and matrices.

All numbers are fractions, so that walls which coincide on paper get equal numbers after one rounding.
"""

from __future__ import annotations

import itertools
import os
import re
from collections.abc import Callable, Iterator, MutableMapping
from dataclasses import field
from fractions import Fraction
from typing import Any

from ..._util.files import MAX_PROBLEMS, Problem, SceneFileError, Suggestions, printable
from ..._util.records import dataclass
from ...geometry.transform import IDENTITY_MOTION
from ...materials.material import Material, Properties
from ...materials.presets import matte
from ..importers import OmittedPart, palette_color
from ..openmc.placement import NO_ROTATION, NO_TURN, ORIGIN, AxisTurn, CellRotation, Point, rotation_by_angles
from ..scene_file.nodes import shorten
from ..xml_tree import XmlElement
from . import expressions
from .expressions import ExpressionError, evaluate, to_degrees

MAX_LOOP_TURNS = 200_000
"""Iterations of all loops of a file together."""
MAX_FACES, MAX_CONVEX_FACES, MAX_FACE_EFFORT = 400, 3_000, 4_000_000
"""Limits on the time that meshes take: most faces of a concave solid, most faces of a convex solid, and most of the sum
of squared face counts in a file, to which a convex solid contributes a tenth of its square."""

_BRACKETS = re.compile(r"\[([^\[\]]*)\]")
# The address that Geant4 appends to names of volumes and solids that it writes.
_POINTER = re.compile(r"(?<=.)0x[0-9a-fA-F]{4,}$")


class GdmlError(Exception):
    """An error in a file, with the element that it is in."""

    def __init__(self, element: XmlElement, message: str) -> None:
        super().__init__(message)
        self.element, self.message = element, message


@dataclass
class GdmlReader:
    """The state of reading one file.

    `names` holds constants, quantities, variables and entries of matrices; `vectors` holds positions, rotations and
    scales by tag and name; `turns` and `effort` count what `MAX_LOOP_TURNS` and `MAX_FACE_EFFORT` limit.
    """

    path: str
    names: dict[str, Fraction] = field(default_factory=lambda: dict(expressions.UNIT_VALUES))
    variables: set[str] = field(default_factory=set)
    vectors: dict[str, dict[str, tuple[Fraction, Fraction, Fraction]]] = field(default_factory=dict)
    columns: dict[str, int] = field(default_factory=dict)  # columns of each matrix
    problems: list[Problem] = field(default_factory=list)
    remarks: dict[str, list[str]] = field(default_factory=dict)
    turns: int = 0
    effort: int = 0
    counter: Iterator[int] = field(default_factory=lambda: itertools.count(1))  # numbers materials
    suggest: Suggestions = field(default_factory=Suggestions)

    def report(self, element: XmlElement, where: str, message: str) -> None:
        """Record an error. Raise SceneFileError with all of them once there are `MAX_PROBLEMS`."""
        self.problems.append(Problem(element.line, element.column, where, message))
        if len(self.problems) >= MAX_PROBLEMS:
            raise SceneFileError(self.path, self.problems)

    def remark(self, element: XmlElement, where: str, message: str) -> None:
        """Record a remark about something that is read differently from the file or left out.

        Remarks are grouped by tag, so that many of one kind do not hide the others.
        """
        file = os.path.basename(self.path)
        text = f"{file}:{element.line}: {printable(shorten(where))}: {printable(message)}"
        self.remarks.setdefault(element.tag, []).append(text)

    def spend(self, faces: int, is_convex: bool) -> None:
        """Charge the time to cut a solid of `faces` faces into convex parts; raise OmittedPart if it is too long.

        The time grows with the square of the face count.
        """
        most, kind = (MAX_CONVEX_FACES, "") if is_convex else (MAX_FACES, "concave ")
        if faces > most:
            raise OmittedPart(f"it has {faces:,} faces, more than the {most:,} of a {kind}solid that are read")
        self.effort += faces * faces // (10 if is_convex else 1)
        if self.effort > MAX_FACE_EFFORT:
            raise OmittedPart("the solids before it have too many faces together; divide the file")

    def resolve_indices(self, text: str, element: XmlElement) -> str:
        """Return a name with [i] and [i, j] replaced by _1 and _1_2, as Geant4 does."""
        for _ in range(8):  # each pass replaces one innermost pair of brackets
            found = _BRACKETS.search(text)
            if found is None:
                return text
            numbers = [self.value(part, element, "index") for part in found[1].split(",")]
            if any(number.denominator != 1 for number in numbers):
                raise GdmlError(element, f"index must be whole, got [{shorten(found[1])}]")
            text = text[: found.start()] + "".join(f"_{number}" for number in numbers) + text[found.end() :]
        raise GdmlError(element, "has too many brackets in a name")

    def value(self, text: str, element: XmlElement, name: str) -> Fraction:
        """Return the value of an expression in the attribute `name`. Raise GdmlError if it has none.

        An empty text is 0, as in G4GDMLEvaluator::Evaluate.
        """
        if not text.strip():
            return Fraction(0)
        try:
            return evaluate(self.resolve_indices(text, element) if "[" in text else text, self.names)
        except ExpressionError as error:
            raise GdmlError(element, f"{name} {error}, got {shorten(text)!r}") from None
        except KeyError as error:
            unknown = str(error.args[0])
            hint = self.suggest(unknown, self.names)
            raise GdmlError(element, f"{name} has {shorten(unknown)!r}, which is not defined{hint}") from None

    def each(self, children: list[XmlElement], depth: int = 0) -> Iterator[XmlElement]:
        """Yield elements with loops unrolled: `names` holds the loop variable while its elements are yielded.

        Errors in a loop are reported, and the loop is skipped. Raise SceneFileError after `MAX_LOOP_TURNS` iterations.
        """
        for child in children:
            if child.tag != "loop":
                yield child
                continue
            try:
                first, last, step, name = self._loop(child)
            except GdmlError as mistake:
                self.report(mistake.element, "loop", mistake.message)
                continue
            value = first
            # The end is included, as in G4GDMLRead::LoopRead
            while (value <= last) if step > 0 else (value >= last):
                self.turns += 1
                if self.turns > MAX_LOOP_TURNS:
                    problem = Problem(
                        child.line, child.column, "loop", f"loops turn more than {MAX_LOOP_TURNS:,} times"
                    )
                    raise SceneFileError(self.path, [problem])
                self.names[name] = value
                yield from self.each(child.children, depth + 1)
                value += step

    def _loop(self, loop: XmlElement) -> tuple[Fraction, Fraction, Fraction, str]:
        """Return first value, last value, step and variable of a loop."""
        name = loop.attributes.get("for", "")
        # Geant4 refuses loops over constants, and names that are nowhere defined are mistakes in the file
        if name not in self.variables:
            raise GdmlError(loop, f"for must be a variable that is defined before, got {shorten(name)!r}")
        attributes = loop.attributes
        # Without `from`, a loop goes on from the value of its variable
        first = self.value(attributes["from"], loop, "from") if "from" in attributes else self.names[name]
        if "to" not in attributes:
            raise GdmlError(loop, "to must be given")
        last = self.value(attributes["to"], loop, "to")
        step = self.value(attributes.get("step", "1"), loop, "step")
        if not step:
            raise GdmlError(loop, "step must not be 0, or the loop would never end")
        return first, last, step, name


def strip_pointer(name: str) -> str:
    """Return a name without the address that Geant4 appends to it."""
    # Geant4 appends addresses so that equal names stay apart; a name without them is the one that its author gave
    return _POINTER.sub("", name)


def local_tag(element: XmlElement) -> str:
    """Return the tag of an element without its namespace."""
    return element.tag.rpartition(":")[2]


def read_reference(reading: GdmlReader, element: XmlElement, attribute: str = "ref") -> str:
    """Return the name that an attribute of an element refers to. Raise GdmlError if the attribute is missing."""
    text = element.attributes.get(attribute)
    if not text:
        raise GdmlError(element, f"{attribute} must be given")
    return reading.resolve_indices(text, element)


def look_up(reading: GdmlReader, table: dict[str, Any], name: str, element: XmlElement, what: str) -> Any:
    """Return the entry of a table. Raise GdmlError, with similar names, if the table has no such entry."""
    if name not in table:
        hint = reading.suggest(name, table)
        raise GdmlError(element, f"there is no {what} {shorten(name)!r} before this{hint}")
    return table[name]


# Rotations and mirrors. GDML rotates about x, then y, then z: Booleans as written, placements by the inverse.

_ZERO_ANGLE = Fraction(0)


def operand_rotation(angles: Point) -> CellRotation:
    """Return the rotation that a Boolean applies to its operand: about x, then y, then z, in degrees."""
    rotation = NO_ROTATION
    # One axis after the other: `rotation_by_angles` of all three would turn in OpenMC's order
    for axis, angle in enumerate(angles):
        single = [_ZERO_ANGLE, _ZERO_ANGLE, _ZERO_ANGLE]
        single[axis] = angle
        rotation = compose_rotations(rotation_by_angles((single[0], single[1], single[2])), rotation)
    return rotation


def placement_rotation(angles: Point) -> CellRotation:
    """Return the inverse of `operand_rotation`, which a placement applies to its volume.

    Source: G4GDMLReadStructure::PhysvolRead. Angles are in degrees.
    """
    x, y, z = angles
    # The inverse of "x, then y, then z" is "-z, then -y, then -x", which is what these angles mean there
    return rotation_by_angles((-x, -y, -z))


def scaling(factors: Point) -> CellRotation:
    """Return the scaling by three factors: exact changes of sign if all are ±1, else a motion.

    Raise ValueError for a factor of zero.
    """
    # Mirrors are as exact as quarter turns, so that reflected parts share walls with others
    if all(abs(factor) == 1 for factor in factors):
        x, y, z = (int(factor) for factor in factors)
        return CellRotation(AxisTurn(signs=(x, y, z)))
    return CellRotation(motion=IDENTITY_MOTION.scale(tuple(map(float, factors))))


def compose_rotations(last: CellRotation, first: CellRotation) -> CellRotation:
    """Return the rotation that applies `first`, then `last`; exact if both are quarter turns."""
    if first.motion.is_identity and last.motion.is_identity:
        return CellRotation(last.turn.after(first.turn))
    motion = IDENTITY_MOTION
    for part in (first, last):
        # A quarter turn becomes a matrix of 0 and ±1, exact in floats too
        if part.turn != NO_TURN:
            rows = [(*map(float, row), 0.0) for row in part.turn.rows]
            motion = motion.transform((*rows, (0.0, 0.0, 0.0, 1.0)))
        motion = motion.then(part.motion)
    return CellRotation(motion=motion)


# Numbers of an element, in mm and degrees.

UNIT_SCALE: Point = (Fraction(1), Fraction(1), Fraction(1))
_MOTIONS = ("position", "rotation", "scale")


class GdmlValues:
    """The attributes of a solid or of one of its parts.

    `lunit` and `aunit` are read from `units_of`, or else from the element itself; the defaults are mm and rad.
    All methods raise GdmlError for a missing attribute without a default and for a value out of range.
    """

    def __init__(self, reading: GdmlReader, element: XmlElement, units_of: XmlElement | None = None) -> None:
        self.reading, self.element = reading, element
        attributes = (units_of or element).attributes
        # The schema has "mm" and "rad" as defaults; units are expressions, so that a file may define its own
        self.length_unit = reading.value(attributes.get("lunit") or "mm", element, "lunit")
        self.angle_unit = reading.value(attributes.get("aunit") or "rad", element, "aunit")

    def has(self, name: str) -> bool:
        """Return True if the element has the attribute."""
        return name in self.element.attributes

    def number(self, name: str, default: Fraction | int | None = None) -> Fraction:
        """Return a number without a unit."""
        text = self.element.attributes.get(name)
        if text is None:
            if default is None:
                raise GdmlError(self.element, f"{name} must be given")
            return Fraction(default)
        return self.reading.value(text, self.element, name)

    def length(self, name: str, default: Fraction | int | None = None) -> Fraction:
        """Return a length in mm."""
        return self.number(name, default) * self.length_unit

    def positive(self, name: str) -> Fraction:
        """Return a length above 0 in mm."""
        value = self.length(name)
        if value <= 0:
            raise GdmlError(self.element, f"{name} must be > 0, got {float(value):g} mm")
        return value

    def radius(self, name: str, default: Fraction | int | None = 0) -> Fraction:
        """Return a length in mm that is 0 or more."""
        value = self.length(name, default)
        if value < 0:
            raise GdmlError(self.element, f"{name} must be >= 0, got {float(value):g} mm")
        return value

    def angle(self, name: str, default: Fraction | int | None = None) -> Fraction:
        """Return an angle in degrees (`to_degrees`); `default` is in degrees too."""
        # Defaults are degrees, as radians of a full turn would not be exact
        if not self.has(name) and default is not None:
            return Fraction(default)
        # Degrees because quarter turns are whole numbers in them
        return to_degrees(self.number(name) * self.angle_unit)

    def integer(self, name: str, default: int | None = None, most: int = 10**6, least: int = 0) -> int:
        """Return a whole number from `least` to `most`."""
        value = self.number(name, default)
        if value.denominator != 1 or not least <= value <= most:
            message = f"{name} must be a whole number from {least:,} to {most:,}, got {float(value):g}"
            raise GdmlError(self.element, message)
        return int(value)


def read_vector(reading: GdmlReader, element: XmlElement, kind: str) -> Point:
    """Return a position in mm, a rotation in degrees, or a scale.

    The element holds the numbers itself, or it is a reference such as <positionref> to a defined vector.
    """
    if element.tag.endswith("ref"):
        table = reading.vectors.setdefault(kind, {})
        return look_up(reading, table, read_reference(reading, element), element, kind)
    attributes, default = element.attributes, UNIT_SCALE[0] if kind == "scale" else ORIGIN[0]
    x = reading.value(attributes["x"], element, "x") if "x" in attributes else default
    y = reading.value(attributes["y"], element, "y") if "y" in attributes else default
    z = reading.value(attributes["z"], element, "z") if "z" in attributes else default
    # Factors have no unit
    if kind == "scale":
        return x, y, z
    unit = reading.value(attributes.get("unit") or ("mm" if kind == "position" else "rad"), element, "unit")
    # Positions in mm are the common case: skip three multiplications of fractions by 1.
    if kind == "position":
        return (x, y, z) if unit == 1 else (x * unit, y * unit, z * unit)
    return to_degrees(x * unit), to_degrees(y * unit), to_degrees(z * unit)


def read_motion(
    reading: GdmlReader, element: XmlElement, turn: Callable[[Point], CellRotation], prefix: str = ""
) -> tuple[Point, CellRotation, Point]:
    """Return shift in mm, rotation and scale, read from the children of an element.

    `turn` makes a rotation from angles in degrees (`operand_rotation` or `placement_rotation`); `prefix` stands before
    the tags, such as "first" in <firstrotationref>. Raise GdmlError for a scale of zero.
    """
    shift, angles, scale = read_placement(reading, element, prefix)
    return shift, turn(angles) if any(angles) else NO_ROTATION, scale


def read_placement(reading: GdmlReader, element: XmlElement, prefix: str = "") -> tuple[Point, Point, Point]:
    """Return shift in mm, angles in degrees and scale, as `read_motion` reads them."""
    vectors: dict[str, Point] = {}
    for child in element.children:
        kind = child.tag.removeprefix(prefix).removesuffix("ref")
        if kind in _MOTIONS and child.tag.startswith(prefix):
            vectors[kind] = read_vector(reading, child, kind)
    angles, scale = vectors.get("rotation", ORIGIN), vectors.get("scale", UNIT_SCALE)
    if not all(scale):
        raise GdmlError(element, f"scale must not be zero, got {shorten(str(tuple(map(float, scale))))}")
    return vectors.get("position", ORIGIN), angles, scale


# The <define> section: numbers, vectors and matrices by name.

MAX_MATRIX_ENTRIES = 1_000_000
_VECTOR_TAGS = ("position", "rotation", "scale")


def read_defines(reading: GdmlReader, section: XmlElement) -> None:
    """Read a <define> section into `reading`; errors are reported, and unknown tags are remarked."""
    for element in reading.each(section.children):
        name = element.attributes.get("name", "")
        try:
            name = reading.resolve_indices(name, element)
            _read_define(reading, element, name)
        except GdmlError as mistake:
            reading.report(mistake.element, f"{local_tag(element)} {name!r}", mistake.message)


def _read_define(reading: GdmlReader, element: XmlElement, name: str) -> None:
    tag = local_tag(element)
    if tag == "expression":
        reading.names[_define_name(element, name)] = reading.value(element.text.strip(), element, "expression")
    elif tag in ("constant", "variable", "quantity"):
        value = _define_number(reading, element)
        if tag == "quantity":
            value *= reading.value(element.attributes.get("unit") or "1", element, "unit")
        if tag == "variable":
            reading.variables.add(name)
        reading.names[_define_name(element, name)] = value
    elif tag in _VECTOR_TAGS:
        reading.vectors.setdefault(tag, {})[_define_name(element, name)] = read_vector(reading, element, tag)
    elif tag == "matrix":
        _define_matrix(reading, element, _define_name(element, name))
    else:
        reading.remark(element, f"{tag} {name!r}", "is no definition that is known, left out")


def _define_name(element: XmlElement, name: str) -> str:
    if not name:
        raise GdmlError(element, "name must be given")
    return name


def _define_number(reading: GdmlReader, element: XmlElement) -> Fraction:
    text = element.attributes.get("value")
    if text is None:
        raise GdmlError(element, "value must be given")
    return reading.value(text, element, "value")


def _define_matrix(reading: GdmlReader, element: XmlElement, name: str) -> None:
    """Define the entries of a matrix as name_1_1, and also as name_1 if it has one row or column."""
    words = element.attributes.get("values", "").split()
    columns = reading.value(element.attributes.get("coldim", "1"), element, "coldim")
    if columns.denominator != 1 or columns < 1 or not words or len(words) % int(columns):
        raise GdmlError(element, f"values must fill rows of coldim = {shorten(str(columns))}, got {len(words):,}")
    reading.columns[name] = count = int(columns)
    rows = len(words) // count
    if len(reading.names) + len(words) > MAX_MATRIX_ENTRIES:
        raise GdmlError(element, f"has more than {MAX_MATRIX_ENTRIES:,} entries, with all other names")
    for k, word in enumerate(words):
        value = reading.value(word, element, "values")
        row, column = divmod(k, count)
        reading.names[f"{name}_{row + 1}_{column + 1}"] = value
        # A vector is indexed by one number in expressions, a matrix by two
        if rows == 1 or count == 1:
            reading.names[f"{name}_{k + 1}"] = value


# The <materials> section of a GDML file, and the colours of materials.
#
# Materials have a name, a density and a composition. Gases and vacuum are invisible; other materials get the colour
# that a volume hints at, or a palette colour by their number.

GAS_DENSITY = 0.01
"""Density in g/cm3 that gases and vacuum do not reach and that all solids and liquids exceed."""
_GASES = {"G4_Galactic": 1e-25, "G4_AIR": 0.00120479, "Galactic": 1e-25}
"""Densities in g/cm3 of gases of Geant4's own list, which many files use without a definition."""


@dataclass(frozen=True, eq=False)
class GdmlMaterial:
    """A material of a file; `number` counts them, `is_thin` is True for gases and vacuum, `hint` is a colour."""

    number: int
    name: str
    properties: Properties
    is_thin: bool
    hint: str | None = None

    @property
    def color(self) -> str | None:
        """The colour that the file hints at, or a palette colour by number; None for gases and vacuum."""
        return None if self.is_thin else self.hint or palette_color(self.number)

    @property
    def title(self) -> str:
        """A name that is unique in the file: the same material in another colour has another title."""
        return self.name if self.hint is None else f"{self.name} {self.hint}"

    @property
    def look(self) -> Material:
        """The material of bodies in the scene."""
        if self.is_thin:
            return Material(
                (0.0, 0.0, 0.0), ambient=0.0, diffuse=0.0, transparency=1.0, name=self.name, properties=self.properties
            )
        return matte(self.color or "#000000", name=self.name, properties=self.properties)


MaterialTable = MutableMapping[str, GdmlMaterial]


def read_materials(reading: GdmlReader, section: XmlElement, materials: MaterialTable) -> None:
    """Read a section into `materials`; errors are reported. Isotopes and elements are not needed and are skipped."""
    for element in reading.each(section.children):
        if local_tag(element) != "material":
            if local_tag(element) not in ("element", "isotope", "property"):
                reading.remark(element, local_tag(element), "is no material that is known, left out")
            continue
        name = element.attributes.get("name", "")
        try:
            name = reading.resolve_indices(name, element)
            materials[name] = _material(reading, element, name)
        except GdmlError as mistake:
            reading.report(mistake.element, f"material {name!r}", mistake.message)


def find_material(reading: GdmlReader, materials: MaterialTable, name: str) -> GdmlMaterial | None:
    """Return a material of the file or of Geant4's own list; None for an unknown name.

    A material of Geant4's list that the file uses without defining it is added to `materials`.
    """
    if name not in materials:
        # Geant4 builds materials of its list on demand, so files use them without a definition
        if not name.startswith("G4_") and name not in _GASES:
            return None
        density = _GASES.get(name)
        # Of the list only the gases are known here: they decide what is invisible
        properties = {} if density is None else {"density": density}
        materials[name] = GdmlMaterial(next(reading.counter), name, Properties(properties), density is not None)
    return materials[name]


def _material(reading: GdmlReader, element: XmlElement, name: str) -> GdmlMaterial:
    if not name:
        raise GdmlError(element, "name must be given")
    properties: dict[str, Any] = {}
    shares: dict[str, float] = {}
    for child in element.children:
        if child.tag in ("D", "Dref"):
            properties["density"] = _density(reading, child)
        elif child.tag in ("fraction", "composite") and "ref" in child.attributes:
            # An element may be listed more than once; its shares add up
            part = strip_pointer(child.attributes["ref"])
            shares[part] = shares.get(part, 0.0) + _float(
                reading.value(child.attributes.get("n", "1"), child, "n"), child
            )
    if shares:
        properties["fractions" if element.all("fraction") else "composite"] = shares
    for key in ("formula", "state"):
        if element.attributes.get(key):
            properties[key] = element.attributes[key]
    if "Z" in element.attributes:
        properties["Z"] = _float(reading.value(element.attributes["Z"], element, "Z"), element)
    # A file need not have `state`, so the density decides as well
    is_gas = properties.get("state") == "gas" or properties.get("density", 1.0) < GAS_DENSITY
    try:
        return GdmlMaterial(next(reading.counter), strip_pointer(name), Properties(properties), is_gas)
    except (ValueError, TypeError) as error:
        raise GdmlError(element, str(error)) from None


def _density(reading: GdmlReader, element: XmlElement) -> float:
    """Return the density of a <D> or <Dref> element in g/cm3."""
    if element.tag == "Dref":  # quantities hold g/mm3, the unit g/cm3 being 1/1000
        value = reading.value(element.attributes.get("ref", ""), element, "ref") * 1000
    else:
        unit = element.attributes.get("unit") or "g/cm3"
        value = reading.value(element.attributes.get("value", ""), element, "value")
        # Units of density are in g/mm3, the base units of masses and lengths here
        value *= reading.value(unit, element, "unit") * 1000
    if value < 0:
        raise GdmlError(element, f"value must be >= 0, got {float(value):g} g/cm3")
    return _float(value, element)


def _float(value: Fraction, element: XmlElement) -> float:
    try:
        return float(value)
    except OverflowError:
        raise GdmlError(element, "has a number that is too large") from None


# Colours of volumes as auxiliary information: a custom of several programs, no part of GDML itself

_COLOR_NAMES = {
    "white": "#ffffff", "gray": "#808080", "grey": "#808080", "black": "#000000", "brown": "#734000", "red": "#ff0000",
    "green": "#00ff00", "blue": "#0000ff", "cyan": "#00ffff", "magenta": "#ff00ff", "yellow": "#ffff00",
}  # fmt: skip
"""Geant4's named colours (G4Colour), with its shares of red, green and blue taken as sRGB."""
_COLOR_CODE = re.compile(r"#([0-9a-fA-F]{6})([0-9a-fA-F]{2})?")
_COLOR_CHANNEL = re.compile(r"\d{1,9}(?:\.\d{0,20})?|\.\d{1,20}", re.ASCII)


def read_color_hint(reading: GdmlReader, volume: XmlElement) -> str | None:
    """Return #rrggbb of the last valid <auxiliary auxtype="Color"> of a volume; None if it has none.

    Values are names, #rrggbb or #rrggbbaa, and three or four shares from 0 to 1, with or without commas and brackets.
    Invalid values and opacities below 1 are remarked.
    """
    hint = None
    for child in volume.children:
        if local_tag(child) != "auxiliary" or child.attributes.get("auxtype", "").lower() not in ("color", "colour"):
            continue
        text = child.attributes.get("auxvalue", "").strip()
        color = _parse_color(text)
        where = f"volume {volume.attributes.get('name', '')!r}"
        if color is None:
            reading.remark(child, where, f"has the colour {shorten(text)!r}, which is not understood")
            continue
        hint, opacity = color
        if opacity < 1:
            reading.remark(child, where, f"has a colour of opacity {opacity:.3g}, which is not read")
    return hint


def _parse_color(text: str) -> tuple[str, float] | None:
    """Return colour (#rrggbb) and opacity; None for an invalid text."""
    name = _COLOR_NAMES.get(text.lower())
    if name is not None:
        return name, 1.0
    code = _COLOR_CODE.fullmatch(text)
    if code is not None:
        return f"#{code[1].lower()}", int(code[2] or "ff", 16) / 255
    words = text.strip("()").replace(",", " ").split()
    if len(words) not in (3, 4) or not all(_COLOR_CHANNEL.fullmatch(word) for word in words):
        return None
    channels = list(map(float, words))
    # Some programs write channels from 0 to 255; which of both (1, 1, 1) means nobody can know, so these are refused
    if max(channels) > 1:
        return None
    return "#" + "".join(f"{round(255 * channel):02x}" for channel in channels[:3]), (*channels, 1.0)[3]
