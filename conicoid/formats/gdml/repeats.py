"""Volumes that stand in their mother many times by a rule: replicas, divisions, parameterised volumes."""

from __future__ import annotations

from collections.abc import Iterator
from dataclasses import replace
from fractions import Fraction
from typing import TYPE_CHECKING

from ..openmc.xml_tree import Element
from .placement import ORIGIN, STRAIGHT, Point, Rotation, placed, turned
from .reading import LeftOut, Mistake, local, shown_name
from .solids import template_of
from .structure import Daughter, Volume
from .units import PI, in_degrees
from .values import Values, motion_of

if TYPE_CHECKING:
    from .structure import Structure

MOST = 1_000_000
_AXES = {"kXAxis": "x", "kYAxis": "y", "kZAxis": "z", "kRho": "rho", "kPhi": "phi"}


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
            part = _resized(structure, element, inner, inner.source, ("tube",), changes)
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


def divisions(structure: Structure, volume: Volume, element: Element) -> None:
    """<divisionvol axis number width offset unit>: slices of the mother, a box or a tube; they replace the solid."""
    reading, inner = structure.reading, structure.volume_in(element)
    axis = _AXES.get(element.attributes.get("axis", ""))
    if axis is None:
        raise Mistake(element, f"axis must be one of {', '.join(_AXES)}")
    source = volume.source
    if source is None or local(source) not in ("box", "tube"):
        raise LeftOut("divides what is no box and no tube, which is not built yet")
    given = Values(reading, element)
    unit = reading.value(element.attributes.get("unit") or "mm", element, "unit")
    width, offset = given.number("width", 0) * unit, given.number("offset", 0) * unit
    count = given.integer("number", 0, MOST)
    whole = _extent(structure, source, axis)
    if not count:
        if width <= 0:
            raise Mistake(element, "number or width must be given")
        count = int((whole - offset) / width + Fraction(1, 10**9))
    width = width or (whole - offset) / count
    if width <= 0 or not 0 < count <= MOST or offset + count * width > whole * (1 + Fraction(1, 10**9)):
        raise Mistake(element, "number, width and offset must fit into the mother")
    base = shown_name(element.attributes.get("name", "") or inner.name)
    for k, (changes, shift, rotation) in enumerate(_slices(structure, source, axis, width, offset, count)):
        part = _resized(structure, element, inner, source, ("box", "tube"), changes)
        structure.add(volume, Daughter(base, part, shift, rotation, k))
    volume.is_filled = offset == 0 and count * width == whole


def _extent(structure: Structure, source: Element, axis: str) -> Fraction:
    values = Values(structure.reading, source)
    if axis == "phi" and local(source) == "tube":
        return values.angle("deltaphi", 360) * PI / 180
    if axis == "rho" and local(source) == "tube":
        return values.length("rmax") - values.length("rmin", 0)
    if axis in ("x", "y", "z") and (local(source) == "box" or axis == "z"):
        return values.length(axis)
    raise LeftOut(f"divides a {local(source)} along {axis}, which is not built yet")


def _slices(
    structure: Structure, source: Element, axis: str, width: Fraction, offset: Fraction, count: int
) -> Iterator[tuple[dict[str, Fraction], Point, Rotation]]:
    """What is changed of the mother's solid, in mm and radians, and where each slice stands."""
    values = Values(structure.reading, source)
    for k in range(count):
        low = offset + k * width
        if axis == "phi":
            start = values.angle("startphi", 0) * PI / 180
            yield {"startphi": start, "deltaphi": width}, ORIGIN, about_z(low)
        elif axis == "rho":
            inner = values.length("rmin", 0)
            yield {"rmin": inner + low, "rmax": inner + low + width}, ORIGIN, STRAIGHT
        else:
            yield {axis: width}, along(axis, low + width / 2 - values.length(axis) / 2), STRAIGHT


def _resized(
    structure: Structure,
    element: Element,
    inner: Volume,
    source: Element | None,
    kinds: tuple[str, ...],
    changes: dict[str, Fraction],
) -> Volume:
    """A volume with a solid whose attributes are other numbers, in mm and radians."""
    if source is None or local(source) not in kinds:
        raise LeftOut(f"is of what is no {' and no '.join(kinds)}, which is not built yet")
    reading = structure.reading
    if inner.source is not None and _is_same(structure, inner.source, source, changes):
        return inner
    units = {name: reading.value(source.attributes.get(name, unit), source, name) for name, unit in _UNITS.items()}
    given = dict(source.attributes)
    for name, value in changes.items():
        given[name] = _spelled(value / units["aunit" if name.endswith("phi") else "lunit"])
    made = replace_attributes(source, given)
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


def replace_attributes(element: Element, attributes: dict[str, str]) -> Element:
    """The element with others, at its place in the file."""
    return Element(element.tag, element.line, element.column, attributes, element.children)


_DIMENSIONS: dict[str, dict[str, str]] = {
    "box": {"x": "x", "y": "y", "z": "z"},
    "tube": {"InR": "rmin", "OutR": "rmax", "hz": "z", "StartPhi": "startphi", "DeltaPhi": "deltaphi"},
    "orb": {"r": "r"},
    "trd": {name: name for name in ("x1", "x2", "y1", "y2", "z")},
    "sphere": {name: name for name in ("rmin", "rmax", "startphi", "deltaphi", "starttheta", "deltatheta")},
    "cone": {name: name for name in ("rmin1", "rmax1", "rmin2", "rmax2", "z", "startphi", "deltaphi")},
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
        raise LeftOut(f"has {dimensions.tag}, which is not built yet")
    given = {new: dimensions.attributes[old] for old, new in _DIMENSIONS[kind].items() if old in dimensions.attributes}
    given |= {name: dimensions.attributes[name] for name in _UNITS if name in dimensions.attributes}
    made = Element(kind, dimensions.line, dimensions.column, given)
    try:
        template = template_of(structure.reading, made, {})
    except ValueError as error:
        raise Mistake(dimensions, str(error)) from None
    return replace(inner, template=template, source=made, is_filled=False)
