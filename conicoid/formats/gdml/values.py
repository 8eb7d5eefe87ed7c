"""The numbers of an element, in mm and degrees."""

from __future__ import annotations

from collections.abc import Callable
from fractions import Fraction

from ..nodes import shortened
from ..openmc.xml_tree import Element
from .placement import ORIGIN, STRAIGHT, Point, Rotation
from .reading import Mistake, Reading, known, reference
from .units import in_degrees

UNSCALED: Point = (Fraction(1), Fraction(1), Fraction(1))
_MOTIONS = ("position", "rotation", "scale")


class Values:
    """The attributes of a solid or of one of its parts; its units are those of `units_of`."""

    def __init__(self, reading: Reading, element: Element, units_of: Element | None = None) -> None:
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
                raise Mistake(self.element, f"{name} must be given")
            return Fraction(default)
        return self.reading.value(text, self.element, name)

    def length(self, name: str, default: Fraction | int | None = None) -> Fraction:
        """In mm."""
        return self.number(name, default) * self.length_unit

    def positive(self, name: str) -> Fraction:
        """A length above 0."""
        found = self.length(name)
        if found <= 0:
            raise Mistake(self.element, f"{name} must be > 0, got {float(found):g} mm")
        return found

    def radius(self, name: str, default: Fraction | int | None = 0) -> Fraction:
        """A length that may be 0."""
        found = self.length(name, default)
        if found < 0:
            raise Mistake(self.element, f"{name} must be >= 0, got {float(found):g} mm")
        return found

    def angle(self, name: str, default: Fraction | int | None = None) -> Fraction:
        """In degrees, a float's value; the default is in degrees."""
        if not self.has(name) and default is not None:
            return Fraction(default)
        return in_degrees(self.number(name) * self.angle_unit)

    def integer(self, name: str, default: int | None = None, most: int = 10**6, least: int = 0) -> int:
        """A whole number between two."""
        found = self.number(name, default)
        if found.denominator != 1 or not least <= found <= most:
            told = f"{name} must be a whole number from {least:,} to {most:,}, got {float(found):g}"
            raise Mistake(self.element, told)
        return int(found)


def vector(reading: Reading, element: Element, kind: str) -> Point:
    """A position in mm, a rotation in degrees, or a scale: written out, or what a <positionref> names."""
    if element.tag.endswith("ref"):
        table = reading.vectors.setdefault(kind, {})
        found: Point = known(reading, table, reference(reading, element), element, kind)
        return found
    given, default = element.attributes, UNSCALED[0] if kind == "scale" else ORIGIN[0]
    x = reading.value(given["x"], element, "x") if "x" in given else default
    y = reading.value(given["y"], element, "y") if "y" in given else default
    z = reading.value(given["z"], element, "z") if "z" in given else default
    if kind == "scale":
        return x, y, z
    unit = reading.value(given.get("unit") or ("mm" if kind == "position" else "rad"), element, "unit")
    if kind == "position":
        return (x, y, z) if unit == 1 else (x * unit, y * unit, z * unit)
    return in_degrees(x * unit), in_degrees(y * unit), in_degrees(z * unit)


def motion_of(
    reading: Reading, element: Element, turn: Callable[[Point], Rotation], prefix: str = ""
) -> tuple[Point, Rotation, Point]:
    """Shift, rotation and scale of an element's children, such as <position> or <firstrotationref>."""
    found: dict[str, Point] = {}
    for child in element.children:
        kind = child.tag.removeprefix(prefix).removesuffix("ref")
        if kind in _MOTIONS and child.tag.startswith(prefix):
            found[kind] = vector(reading, child, kind)
    angles, scale = found.get("rotation", ORIGIN), found.get("scale", UNSCALED)
    if not all(scale):
        raise Mistake(element, f"scale must not be zero, got {shortened(str(tuple(map(float, scale))))}")
    return found.get("position", ORIGIN), turn(angles) if any(angles) else STRAIGHT, scale
