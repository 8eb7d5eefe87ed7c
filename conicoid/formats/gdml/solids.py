"""GDML's <solids>: templates by name."""

from __future__ import annotations

from collections.abc import Callable
from typing import cast

from ..openmc.xml_tree import Element
from . import flat_solids, round_solids, sections, twisted
from .placement import ORIGIN, STRAIGHT, Placement, after, scaled, turned
from .reading import LeftOut, Mistake, Reading, known, local, reference
from .templates import Kind, Make, Operand, Primitive, Template, combined
from .values import Values, motion_of

PRIMITIVES: dict[str, Callable[[Values], Make]] = {
    "box": flat_solids.box, "tube": round_solids.tube, "cutTube": round_solids.cut_tube, "cone": round_solids.cone,
    "sphere": round_solids.sphere, "orb": round_solids.orb, "ellipsoid": round_solids.ellipsoid,
    "eltube": round_solids.elliptic_tube, "elcone": round_solids.elliptic_cone,
    "paraboloid": round_solids.paraboloid, "hype": round_solids.hyperboloid, "trd": flat_solids.trd,
    "trap": flat_solids.trap, "para": flat_solids.para, "tet": flat_solids.tet, "arb8": flat_solids.arb8,
    "polycone": round_solids.polycone, "genericPolycone": round_solids.generic_polycone,
    "polyhedra": sections.polyhedra, "genericPolyhedra": sections.generic_polyhedra, "xtru": sections.xtru,
    "tessellated": flat_solids.tessellated, "twistedtubs": twisted.twisted_tubs,
}  # fmt: skip
_NOT_QUADRIC = ("torus", "twistedbox", "twistedtrd", "twistedtrap")
_BOOLEANS = ("union", "subtraction", "intersection")
_NO_SOLIDS = ("opticalsurface", "property", "userinfo")
Solids = dict[str, "Template | None"]
"""By name; None for one that is left out."""


def read_solids(reading: Reading, section: Element, solids: Solids) -> None:
    """All of a section, in the order of the file; what is wrong is reported, what cannot be is left out."""
    for element in reading.each(section.children):
        if local(element) in _NO_SOLIDS:
            continue
        name = element.attributes.get("name", "")
        where = f"{local(element)} {name!r}"
        try:
            name = reading.solved(name, element)
            solids[name] = None  # what is said of it is said once
            solids[name] = template_of(reading, element, solids)
        except Mistake as mistake:
            reading.report(mistake.element, where, mistake.message)
        except LeftOut as left:
            reading.remark(element, where, f"{left}; left out")
        except (ValueError, OverflowError) as error:
            told = "a number is too large" if isinstance(error, OverflowError) else str(error)
            reading.report(element, where, told)


def template_of(reading: Reading, element: Element, solids: Solids) -> Template:
    """One solid, made once at the origin, so that what is wrong with it is told here."""
    tag = local(element)
    if tag in PRIMITIVES:
        made: Template = Primitive(PRIMITIVES[tag](Values(reading, element)))
    elif tag in _BOOLEANS:
        made = combined(cast("Kind", tag), _operands(reading, element, solids))
    elif tag == "multiUnion":
        made = combined("union", _nodes(reading, element, solids))
    elif tag in ("scaledSolid", "reflectedSolid"):
        return combined("union", [_changed(reading, element, solids)])
    elif tag in _NOT_QUADRIC:
        raise LeftOut("is no quadric")
    else:
        raise LeftOut("is no solid that is known")
    if isinstance(made, Primitive):
        made.at(Placement())
    return made


def _solid(reading: Reading, element: Element, solids: Solids, attribute: str = "ref") -> Template:
    name = reference(reading, element, attribute)
    found: Template | None = (
        known(reading, dict(solids), name, element, "solid") if name not in solids else solids[name]
    )
    if found is None:
        raise LeftOut(f"is of {name!r}, which is left out")
    return found


def _child(element: Element, tag: str) -> Element:
    for child in element.children:
        if child.tag == tag:
            return child
    raise Mistake(element, f"must have a {tag} element")


def _operands(reading: Reading, element: Element, solids: Solids) -> list[Operand]:
    found: list[Operand] = []
    for tag, prefix in (("first", "first"), ("second", "")):
        template = _solid(reading, _child(element, tag), solids)
        shift, rotation, _ = motion_of(reading, element, turned, prefix)
        found.append((template, shift, rotation))
    return found


def _nodes(reading: Reading, element: Element, solids: Solids) -> list[Operand]:
    found = []
    for node in reading.each(element.children):
        if local(node) == "multiUnionNode":
            template = _solid(reading, _child(node, "solid"), solids)
            shift, rotation, _ = motion_of(reading, node, turned)
            found.append((template, shift, rotation))
    if not found:
        raise Mistake(element, "must have multiUnionNode elements")
    return found


def _changed(reading: Reading, element: Element, solids: Solids) -> Operand:
    """A solid that is scaled; or one that is scaled, turned and shifted, all by attributes."""
    if local(element) == "scaledSolid":
        template = _solid(reading, _child(element, "solidref"), solids)
        _, _, scale = motion_of(reading, element, turned)
        return template, ORIGIN, scaled(scale)
    template = _solid(reading, element, solids, "solid")
    values = Values(reading, element)
    scale = values.number("sx", 1), values.number("sy", 1), values.number("sz", 1)
    if not all(scale):
        raise Mistake(element, "sx, sy and sz must not be 0")
    angles = values.angle("rx", 0), values.angle("ry", 0), values.angle("rz", 0)
    rotation = after(turned(angles), scaled(scale)) if any(angles) else scaled(scale)
    return template, (values.length("dx", 0), values.length("dy", 0), values.length("dz", 0)), rotation


__all__ = ["ORIGIN", "PRIMITIVES", "STRAIGHT", "Solids", "read_solids", "template_of"]
