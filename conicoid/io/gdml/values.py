"""What is known while a GDML file is read: names, mistakes and remarks with their lines, loops."""

from __future__ import annotations

import itertools
import os
import re
from collections.abc import Callable, Iterator
from dataclasses import dataclass, field
from fractions import Fraction
from typing import Any

from ..._util.file_errors import MAX_PROBLEMS, Problem, SceneFileError, Suggestions, printable
from ...geometry.transform import IDENTITY_MOTION
from ..openmc.placement import NO_ROTATION, NO_TURN, ORIGIN, AxisTurn, CellRotation, Point, rotation_by_angles
from ..scene_file.nodes import shorten
from ..xml_tree import XmlElement
from . import expressions
from .expressions import ExpressionError, evaluate, to_degrees

MAX_LOOP_TURNS = 200_000
"""Turns of all loops of a file together."""
MAX_FACES, MAX_CONVEX_FACES, MAX_FACE_EFFORT = 400, 3_000, 4_000_000
"""Faces of a concave solid and of a convex one whose parts are found in time; the sum of their squares in a file, of
which those of convex ones count a tenth."""

_BRACKETS = re.compile(r"\[([^\[\]]*)\]")
_POINTER = re.compile(r"(?<=.)0x[0-9a-fA-F]{4,}$")


class GdmlError(Exception):
    """What is wrong with an element."""

    def __init__(self, element: XmlElement, message: str) -> None:
        super().__init__(message)
        self.element, self.message = element, message


class GdmlUnsupported(Exception):
    """Why an element cannot be what the file says, and the rest of the file may still be read."""


@dataclass
class GdmlReader:
    """The state of reading one file. `names` are constants, quantities, variables and entries of matrices."""

    path: str
    names: dict[str, Fraction] = field(default_factory=lambda: dict(expressions.UNIT_VALUES))
    variables: set[str] = field(default_factory=set)
    vectors: dict[str, dict[str, tuple[Fraction, Fraction, Fraction]]] = field(default_factory=dict)
    columns: dict[str, int] = field(default_factory=dict)  # of matrices
    problems: list[Problem] = field(default_factory=list)
    remarks: dict[str, list[str]] = field(default_factory=dict)
    turns: int = 0
    effort: int = 0
    counter: Iterator[int] = field(default_factory=lambda: itertools.count(1))  # of materials
    suggest: Suggestions = field(default_factory=Suggestions)

    def report(self, element: XmlElement, where: str, message: str) -> None:
        """A mistake; after very many of them the file is given up."""
        self.problems.append(Problem(element.line, element.column, where, message))
        if len(self.problems) >= MAX_PROBLEMS:
            raise SceneFileError(self.path, self.problems)

    def remark(self, element: XmlElement, where: str, message: str) -> None:
        """What is not as the file says, by kind of element, so that no kind hides the others."""
        file = os.path.basename(self.path)
        text = f"{file}:{element.line}: {printable(shorten(where))}: {printable(message)}"
        self.remarks.setdefault(element.tag, []).append(text)

    def spend(self, faces: int, is_convex: bool) -> None:
        """Raises LeftOut where to cut what has so many faces into convex parts would take too long."""
        most, kind = (MAX_CONVEX_FACES, "") if is_convex else (MAX_FACES, "concave ")
        if faces > most:
            raise GdmlUnsupported(
                f"it has {faces:,} faces, more than the {most:,} of a {kind}solid that are read in time"
            )
        self.effort += faces * faces // (10 if is_convex else 1)
        if self.effort > MAX_FACE_EFFORT:
            raise GdmlUnsupported("the file has too many solids of many faces before it")

    def solved(self, text: str, element: XmlElement) -> str:
        """A name whose [i] and [i, j] are replaced by _1 and _1_2, as Geant4 does."""
        for _ in range(8):
            found = _BRACKETS.search(text)
            if found is None:
                return text
            numbers = [self.value(part, element, "index") for part in found[1].split(",")]
            if any(number.denominator != 1 for number in numbers):
                raise GdmlError(element, f"index must be whole, got [{shorten(found[1])}]")
            text = text[: found.start()] + "".join(f"_{number}" for number in numbers) + text[found.end() :]
        raise GdmlError(element, "has too many brackets in a name")

    def value(self, text: str, element: XmlElement, name: str) -> Fraction:
        """The value of an expression. Raises Mistake."""
        try:
            return evaluate(self.solved(text, element) if "[" in text else text, self.names)
        except ExpressionError as error:
            raise GdmlError(element, f"{name} {error}, got {shorten(text)!r}") from None
        except KeyError as error:
            unknown = str(error.args[0])
            told = self.suggest(unknown, self.names)
            raise GdmlError(element, f"{name} has {shorten(unknown)!r}, which is not defined{told}") from None

    def each(self, children: list[XmlElement], depth: int = 0) -> Iterator[XmlElement]:
        """The elements, those in loops as often as these turn, their variable set meanwhile."""
        for child in children:
            if child.tag != "loop":
                yield child
                continue
            try:
                first, last, step, name = self._loop(child, depth)
            except GdmlError as mistake:
                self.report(mistake.element, "loop", mistake.message)
                continue
            value = first
            while (value <= last) if step > 0 else (value >= last):
                self.turns += 1
                if self.turns > MAX_LOOP_TURNS:
                    found = Problem(child.line, child.column, "loop", f"loops turn more than {MAX_LOOP_TURNS:,} times")
                    raise SceneFileError(self.path, [found])
                self.names[name] = value
                yield from self.each(child.children, depth + 1)
                value += step

    def _loop(self, loop: XmlElement, depth: int) -> tuple[Fraction, Fraction, Fraction, str]:
        name = loop.attributes.get("for", "")
        if name not in self.variables:
            raise GdmlError(loop, f"for must be a variable that is defined before, got {shorten(name)!r}")
        given = loop.attributes
        first = self.value(given["from"], loop, "from") if "from" in given else self.names[name]
        last = self.value(given.get("to", ""), loop, "to")
        step = self.value(given.get("step", "1"), loop, "step")
        if not step:
            raise GdmlError(loop, "step must not be 0")
        return first, last, step, name


def strip_pointer(name: str) -> str:
    """Without the address that Geant4 adds to a name."""
    return _POINTER.sub("", name)


def local_tag(element: XmlElement) -> str:
    """A tag without its namespace."""
    return element.tag.rpartition(":")[2]


def read_reference(reading: GdmlReader, element: XmlElement, attribute: str = "ref") -> str:
    """What an element refers to."""
    text = element.attributes.get(attribute)
    if not text:
        raise GdmlError(element, f"{attribute} must be given")
    return reading.solved(text, element)


def look_up(reading: GdmlReader, table: dict[str, Any], name: str, element: XmlElement, what: str) -> Any:
    """What a table has by a name. Raises Mistake."""
    if name not in table:
        told = reading.suggest(name, table)
        raise GdmlError(element, f"there is no {what} {shorten(name)!r} before this{told}")
    return table[name]


# How GDML turns and mirrors: about x, then y, then z; Booleans as written, placements the other way.

_ZERO_ANGLE = Fraction(0)


def operand_rotation(angles: Point) -> CellRotation:
    """In degrees, about x, then y, then z: what a Boolean does to its operand."""
    found = NO_ROTATION
    for axis, angle in enumerate(angles):
        alone = [_ZERO_ANGLE, _ZERO_ANGLE, _ZERO_ANGLE]
        alone[axis] = angle
        found = compose_rotations(rotation_by_angles((alone[0], alone[1], alone[2])), found)
    return found


def placement_rotation(angles: Point) -> CellRotation:
    """The inverse of `turned`: what a placement does to its volume (G4GDMLReadStructure::PhysvolRead)."""
    x, y, z = angles
    return rotation_by_angles((-x, -y, -z))


def scaling(factors: Point) -> CellRotation:
    """Mirrors are exchanges of axes; other factors are motions. Raises ValueError for one that is zero."""
    if all(abs(factor) == 1 for factor in factors):
        x, y, z = (int(factor) for factor in factors)
        return CellRotation(AxisTurn(signs=(x, y, z)))
    return CellRotation(motion=IDENTITY_MOTION.scale(tuple(map(float, factors))))


def compose_rotations(last: CellRotation, first: CellRotation) -> CellRotation:
    """`first`, then `last`."""
    if first.motion.is_identity and last.motion.is_identity:
        return CellRotation(last.turn.after(first.turn))
    motion = IDENTITY_MOTION
    for part in (first, last):
        if part.turn != NO_TURN:
            rows = [(*map(float, row), 0.0) for row in part.turn.rows]
            motion = motion.transform((*rows, (0.0, 0.0, 0.0, 1.0)))
        motion = motion.then(part.motion)
    return CellRotation(motion=motion)


# The numbers of an element, in mm and degrees.

UNIT_SCALE: Point = (Fraction(1), Fraction(1), Fraction(1))
_MOTIONS = ("position", "rotation", "scale")


class GdmlValues:
    """The attributes of a solid or of one of its parts; its units are those of `units_of`."""

    def __init__(self, reading: GdmlReader, element: XmlElement, units_of: XmlElement | None = None) -> None:
        self.reading, self.element = reading, element
        given = (units_of or element).attributes
        self.length_unit = reading.value(given.get("lunit") or "mm", element, "lunit")
        self.angle_unit = reading.value(given.get("aunit") or "rad", element, "aunit")

    def has(self, name: str) -> bool:
        """Is it given?"""
        return name in self.element.attributes

    def number(self, name: str, default: Fraction | int | None = None) -> Fraction:
        """A number without a unit."""
        text = self.element.attributes.get(name)
        if text is None or not text.strip():
            if default is None:
                raise GdmlError(self.element, f"{name} must be given")
            return Fraction(default)
        return self.reading.value(text, self.element, name)

    def length(self, name: str, default: Fraction | int | None = None) -> Fraction:
        """In mm."""
        return self.number(name, default) * self.length_unit

    def positive(self, name: str) -> Fraction:
        """A length above 0."""
        found = self.length(name)
        if found <= 0:
            raise GdmlError(self.element, f"{name} must be > 0, got {float(found):g} mm")
        return found

    def radius(self, name: str, default: Fraction | int | None = 0) -> Fraction:
        """A length that may be 0."""
        found = self.length(name, default)
        if found < 0:
            raise GdmlError(self.element, f"{name} must be >= 0, got {float(found):g} mm")
        return found

    def angle(self, name: str, default: Fraction | int | None = None) -> Fraction:
        """In degrees, a float's value; the default is in degrees."""
        if not self.has(name) and default is not None:
            return Fraction(default)
        return to_degrees(self.number(name) * self.angle_unit)

    def integer(self, name: str, default: int | None = None, most: int = 10**6, least: int = 0) -> int:
        """A whole number between two."""
        found = self.number(name, default)
        if found.denominator != 1 or not least <= found <= most:
            told = f"{name} must be a whole number from {least:,} to {most:,}, got {float(found):g}"
            raise GdmlError(self.element, told)
        return int(found)


def read_vector(reading: GdmlReader, element: XmlElement, kind: str) -> Point:
    """A position in mm, a rotation in degrees, or a scale: written out, or what a <positionref> names."""
    if element.tag.endswith("ref"):
        table = reading.vectors.setdefault(kind, {})
        found: Point = look_up(reading, table, read_reference(reading, element), element, kind)
        return found
    given, default = element.attributes, UNIT_SCALE[0] if kind == "scale" else ORIGIN[0]
    x = reading.value(given["x"], element, "x") if "x" in given else default
    y = reading.value(given["y"], element, "y") if "y" in given else default
    z = reading.value(given["z"], element, "z") if "z" in given else default
    if kind == "scale":
        return x, y, z
    unit = reading.value(given.get("unit") or ("mm" if kind == "position" else "rad"), element, "unit")
    if kind == "position":
        return (x, y, z) if unit == 1 else (x * unit, y * unit, z * unit)
    return to_degrees(x * unit), to_degrees(y * unit), to_degrees(z * unit)


def read_motion(
    reading: GdmlReader, element: XmlElement, turn: Callable[[Point], CellRotation], prefix: str = ""
) -> tuple[Point, CellRotation, Point]:
    """Shift, rotation and scale of an element's children, such as <position> or <firstrotationref>."""
    found: dict[str, Point] = {}
    for child in element.children:
        kind = child.tag.removeprefix(prefix).removesuffix("ref")
        if kind in _MOTIONS and child.tag.startswith(prefix):
            found[kind] = read_vector(reading, child, kind)
    angles, scale = found.get("rotation", ORIGIN), found.get("scale", UNIT_SCALE)
    if not all(scale):
        raise GdmlError(element, f"scale must not be zero, got {shorten(str(tuple(map(float, scale))))}")
    return found.get("position", ORIGIN), turn(angles) if any(angles) else NO_ROTATION, scale


# GDML's <define>: numbers, vectors and matrices by name.

MAX_MATRIX_ENTRIES = 1_000_000
_VECTOR_TAGS = ("position", "rotation", "scale")


def read_defines(reading: GdmlReader, section: XmlElement) -> None:
    """All of a section; what is wrong is reported."""
    for element in reading.each(section.children):
        name = element.attributes.get("name", "")
        try:
            name = reading.solved(name, element)
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
    """Entries are name_1_1, and name_1 where there is one row or column."""
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
        if rows == 1 or count == 1:
            reading.names[f"{name}_{k + 1}"] = value
