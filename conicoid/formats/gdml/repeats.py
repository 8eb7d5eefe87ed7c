"""Volumes that stand in their mother many times by a rule: replicas, parameterised volumes; and what divisions need."""

from __future__ import annotations

from dataclasses import replace
from fractions import Fraction
from typing import TYPE_CHECKING

from ..openmc.xml_tree import Element
from .placement import ORIGIN, STRAIGHT, Point, Rotation, placed, turned
from .reading import LeftOut, Mistake, local, shown_name
from .solids import template_of
from .structure import Daughter, Volume
from .units import in_degrees
from .values import Values, motion_of

if TYPE_CHECKING:
    from .structure import Structure

MOST = 1_000_000


def along(axis: str, amount: Fraction) -> Point:
    """A shift along x, y or z."""
    none = Fraction(0)
    return (amount if axis == "x" else none, amount if axis == "y" else none, amount if axis == "z" else none)


def about_z(radians: Fraction) -> Rotation:
    """Counter-clockwise."""
    return turned((Fraction(0), Fraction(0), in_degrees(radians)))


def replicas(structure: Structure, volume: Volume, element: Element) -> None:
    """<replicavol number><replicate_along_axis><direction/><width/><offset/>: they fill the mother."""
    inner = structure.volume_in(element)
    count = Values(structure.reading, element).integer("number", most=MOST)
    rule = next((child for child in element.children if child.tag in ("replicate_along_axis", "replicate")), None)
    if rule is None:
        raise Mistake(element, "must have a replicate_along_axis element")
    axis = _direction(structure, rule)
    width, offset = (_measure(structure, rule, name) for name in ("width", "offset"))
    if width <= 0 or count < 1:
        raise Mistake(rule, "width must be > 0 and number 1 or more")
    base = shown_name(element.attributes.get("name", "") or inner.name)
    for k in range(count):
        part, shift, rotation = inner, ORIGIN, STRAIGHT
        if axis == "phi":
            rotation = about_z(offset + (k + Fraction(1, 2)) * width)
        elif axis == "rho":
            changes = {"rmin": offset + k * width, "rmax": offset + (k + 1) * width}
            part = resized(structure, element, inner, inner.source, changes, ("tube",))
        else:
            shift = along(axis, (k - Fraction(count - 1, 2)) * width)
        structure.add(volume, Daughter(base, part, shift, rotation, k))
    volume.is_filled = _fills(structure, volume, axis, count * width)


def _fills(structure: Structure, volume: Volume, axis: str, width: Fraction) -> bool:
    """Do replicas leave nothing of their mother? Of a box along an axis, if they are as long."""
    source = volume.source
    if source is None or local(source) != "box" or axis not in ("x", "y", "z"):
        return False
    return Values(structure.reading, source).length(axis) == width


def _direction(structure: Structure, rule: Element) -> str:
    for child in rule.children:
        if child.tag == "direction":
            for axis in ("x", "y", "z", "rho", "phi"):
                if axis in child.attributes and structure.reading.value(child.attributes[axis], child, axis) == 1:
                    return axis
    raise Mistake(rule, "must have a direction element with one of x, y, z, rho, phi = 1")


def _measure(structure: Structure, rule: Element, tag: str) -> Fraction:
    """A width or an offset, in mm or radians."""
    for child in rule.children:
        if child.tag == tag:
            values = Values(structure.reading, child)
            return values.number("value") * structure.reading.value(child.attributes.get("unit") or "1", child, "unit")
    return Fraction(0)


def resized(
    structure: Structure,
    element: Element,
    inner: Volume,
    source: Element | None,
    changes: dict[str, Fraction],
    kinds: tuple[str, ...],
    sections: tuple[Point, ...] | None = None,
    kind: str | None = None,
) -> Volume:
    """A volume with a solid whose attributes, or sections (z, rmin, rmax), are other numbers, in mm and radians.

    kind: of which the solid becomes, of the changes alone.
    """
    if source is None or local(source) not in kinds:
        raise LeftOut(f"is of what is no {' and no '.join(kinds)}, which is not built yet")
    reading = structure.reading
    if inner.source is not None and _is_same(structure, inner.source, source, changes):
        return inner
    units = {name: reading.value(source.attributes.get(name, unit), source, name) for name, unit in _UNITS.items()}
    given = dict(source.attributes) if kind is None else {"name": inner.name}
    if kind is not None:
        units = {"lunit": Fraction(1), "aunit": Fraction(1)}
    for name, value in changes.items():
        unit = units["aunit" if name.endswith("phi") else "lunit"] if name != "numsides" else Fraction(1)
        given[name] = _spelled(value / unit)
    children = source.children
    if sections is not None:
        rows = [[_spelled(value / units["lunit"]) for value in section] for section in sections]
        children = [
            Element("zplane", source.line, source.column, dict(zip(("z", "rmin", "rmax"), row, strict=True)))
            for row in rows
        ]
    made = Element(kind or source.tag, source.line, source.column, given, children)
    template = template_of(reading, made, {})
    return replace(inner, template=template, source=made, is_filled=False)


def _is_same(structure: Structure, own: Element, source: Element, changes: dict[str, Fraction]) -> bool:
    """Is a volume's own solid, a box, what a slice of its mother is?"""
    if local(own) != "box" or local(source) != "box":
        return False
    mine, its = Values(structure.reading, own), Values(structure.reading, source)
    return all(mine.length(axis) == changes.get(axis, its.length(axis)) for axis in "xyz")


_UNITS = {"lunit": "mm", "aunit": "rad"}


def _spelled(value: Fraction) -> str:
    """As an expression."""
    return f"{value.numerator}/{value.denominator}"


_SAME = {
    "trd": "x1 x2 y1 y2 z", "sphere": "rmin rmax startphi deltaphi starttheta deltatheta",
    "cone": "rmin1 rmax1 rmin2 rmax2 z startphi deltaphi", "box": "x y z", "orb": "r",
    "trap": "z theta phi y1 x1 x2 alpha1 y2 x3 x4 alpha2", "para": "x y z alpha theta phi",
    "ellipsoid": "ax by cz zcut1 zcut2", "hype": "rmin rmax inst outst z",
}  # fmt: skip
_DIMENSIONS: dict[str, dict[str, str]] = {
    **{kind: {name: name for name in names.split()} for kind, names in _SAME.items()},
    "tube": {"InR": "rmin", "OutR": "rmax", "hz": "z", "StartPhi": "startphi", "DeltaPhi": "deltaphi"},
    "polycone": {"startPhi": "startphi", "openPhi": "deltaphi"},
    "polyhedra": {"startPhi": "startphi", "openPhi": "deltaphi", "numSide": "numsides"},
}
"""How the attributes of <box_dimensions> and others are called in <box>."""


def parameterised(structure: Structure, volume: Volume, element: Element) -> None:
    """<paramvol><parameterised_position_size><parameters><position/><rotation/><box_dimensions/>."""
    inner = structure.volume_in(element)
    base = shown_name(element.attributes.get("name", "") or inner.name)
    number = 0
    for rule in element.children:
        if rule.tag != "parameterised_position_size":
            continue
        for parameters in structure.reading.each(rule.children):
            if local(parameters) != "parameters":
                continue
            shift, rotation, _ = motion_of(structure.reading, parameters, placed)
            part = inner
            for child in parameters.children:
                if child.tag.endswith("_dimensions"):
                    part = _dimensioned(structure, inner, child)
            structure.add(volume, Daughter(base, part, shift, rotation, number))
            number += 1
    if not number:
        raise Mistake(element, "must have parameters elements")


def _dimensioned(structure: Structure, inner: Volume, dimensions: Element) -> Volume:
    kind = dimensions.tag.removesuffix("_dimensions")
    if kind not in _DIMENSIONS:
        raise LeftOut(f"has {dimensions.tag}, which is no solid that is read")
    given = {new: dimensions.attributes[old] for old, new in _DIMENSIONS[kind].items() if old in dimensions.attributes}
    given |= {name: dimensions.attributes[name] for name in _UNITS if name in dimensions.attributes}
    made = Element(kind, dimensions.line, dimensions.column, given, dimensions.children)
    try:
        template = template_of(structure.reading, made, {})
    except ValueError as error:
        raise Mistake(dimensions, str(error)) from None
    return replace(inner, template=template, source=made, is_filled=False)
