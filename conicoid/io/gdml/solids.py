"""The <solids> section of a GDML file: solid templates by name.

`SOLID_READERS` maps each tag of a primitive to the function that reads it. Booleans, multi-unions, scaled and reflected
solids combine templates that stand before them in the file.
"""

from __future__ import annotations

from collections.abc import Callable
from fractions import Fraction
from typing import cast

from ..openmc.placement import NO_ROTATION, ORIGIN, UniversePlacement
from ..xml_tree import XmlElement
from . import flat_solids, polyhedra, round_solids
from .expressions import UNIT_VALUES
from .solid_template import (
    BooleanKind,
    PrimitiveTemplate,
    SolidFactory,
    SolidTemplate,
    SourceElement,
    TemplateOperand,
    combine_templates,
)
from .values import (
    GdmlError,
    GdmlReader,
    GdmlUnsupported,
    GdmlValues,
    compose_rotations,
    local_tag,
    look_up,
    operand_rotation,
    read_motion,
    read_reference,
    scaling,
)

SOLID_READERS: dict[str, Callable[[GdmlValues], SolidFactory]] = {
    "box": flat_solids.box, "tube": round_solids.tube, "cutTube": round_solids.cut_tube, "cone": round_solids.cone,
    "sphere": round_solids.sphere, "orb": round_solids.orb, "ellipsoid": round_solids.ellipsoid,
    "eltube": round_solids.elliptic_tube, "elcone": round_solids.elliptic_cone,
    "paraboloid": round_solids.paraboloid, "hype": round_solids.hyperboloid, "trd": flat_solids.trd,
    "trap": flat_solids.trap, "para": flat_solids.para, "tet": flat_solids.tet, "arb8": flat_solids.arb8,
    "polycone": polyhedra.polycone, "genericPolycone": polyhedra.generic_polycone,
    "polyhedra": polyhedra.polyhedra, "genericPolyhedra": polyhedra.generic_polyhedra, "xtru": polyhedra.xtru,
    "tessellated": flat_solids.tessellated, "twistedtubs": flat_solids.twisted_tubs,
}  # fmt: skip
# Surfaces of degree four, or that turn evenly in angle.
_UNSUPPORTED_SOLIDS = ("torus", "twistedbox", "twistedtrd", "twistedtrap")
# Elements that become Booleans or polyhedra of computed planes, and their numbers: exports write them as they were.
_SOURCE_NUMBERS = {
    "cutTube": "rmin rmax z startphi deltaphi lowX lowY lowZ highX highY highZ",
    "hype": "rmin rmax inst outst z", "paraboloid": "rlo rhi dz",
    "polyhedra": "startphi deltaphi numsides", "zplane": "z rmin rmax",
    "genericPolyhedra": "startphi deltaphi numsides", "rzpoint": "r z",
}  # fmt: skip
_BOOLEANS = ("union", "subtraction", "intersection")
_IGNORED_ELEMENTS = ("opticalsurface", "property", "userinfo")
SolidTable = dict[str, "SolidTemplate | None"]
"""Templates by name; None for a solid that is left out."""


def read_solids(reading: GdmlReader, section: XmlElement, solids: SolidTable) -> None:
    """Read a section into `solids`, in the order of the file.

    Errors are reported; solids that are not supported are remarked and left out (None).
    """
    for element in reading.each(section.children):
        if local_tag(element) in _IGNORED_ELEMENTS:
            continue
        name = element.attributes.get("name", "")
        where = f"{local_tag(element)} {name!r}"
        try:
            name = reading.resolve_indices(name, element)
            solids[name] = None  # so that references to a wrong solid report no second error
            solids[name] = read_template(reading, element, solids)
        except GdmlError as mistake:
            reading.report(mistake.element, where, mistake.message)
        except GdmlUnsupported as left:
            reading.remark(element, where, f"{left}; left out")
        except (ValueError, OverflowError) as error:
            message = "a number is too large" if isinstance(error, OverflowError) else str(error)
            reading.report(element, where, message)


def read_template(reading: GdmlReader, element: XmlElement, solids: SolidTable) -> SolidTemplate:
    """Return the template of one solid.

    A primitive is built once at the origin to validate it, so that errors are reported with this element's line.

    Raises
    ------
    GdmlError, ValueError, OverflowError
        The element is wrong.
    GdmlUnsupported
        The solid is valid GDML but cannot be built from quadrics.

    """
    tag = local_tag(element)
    if tag in SOLID_READERS:
        make = SOLID_READERS[tag](GdmlValues(reading, element))
        template: SolidTemplate = PrimitiveTemplate(make, read_source(reading, element))
    elif tag in _BOOLEANS:
        template = combine_templates(cast("BooleanKind", tag), _read_operands(reading, element, solids))
    elif tag == "multiUnion":
        template = combine_templates("union", _read_union_nodes(reading, element, solids))
    elif tag in ("scaledSolid", "reflectedSolid"):
        return combine_templates("union", [_read_transformed(reading, element, solids)])
    elif tag in _UNSUPPORTED_SOLIDS:
        raise GdmlUnsupported("is no quadric")
    else:
        raise GdmlUnsupported("is no solid that is known")
    if isinstance(template, PrimitiveTemplate):
        template.at(UniversePlacement())
    return template


def read_source(reading: GdmlReader, element: XmlElement) -> SourceElement | None:
    """Return the numbers of an element and of its parts, if exports need them. The element was read without errors."""
    names = _SOURCE_NUMBERS.get(local_tag(element))
    if names is None:
        return None
    values: list[tuple[str, Fraction | str]] = []
    for name in (*names.split(), "aunit", "lunit"):
        text = element.attributes.get(name, "").strip()
        if text:
            value = reading.value(text, element, name)
            # Units that GDML knows keep their names; files may define others.
            values.append((name, text if UNIT_VALUES.get(text) == value else value))
    parts = (read_source(reading, child) for child in element.children)
    return SourceElement(local_tag(element), tuple(values), tuple(part for part in parts if part is not None))


def _look_up_solid(
    reading: GdmlReader, element: XmlElement, solids: SolidTable, attribute: str = "ref"
) -> SolidTemplate:
    """Return the template that an attribute names. Raise GdmlUnsupported if that solid is left out."""
    name = read_reference(reading, element, attribute)
    template: SolidTemplate | None = (
        look_up(reading, dict(solids), name, element, "solid") if name not in solids else solids[name]
    )
    if template is None:
        raise GdmlUnsupported(f"is of {name!r}, which is left out")
    return template


def _find_child(element: XmlElement, tag: str) -> XmlElement:
    for child in element.children:
        if child.tag == tag:
            return child
    raise GdmlError(element, f"must have a {tag} element")


def _read_operands(reading: GdmlReader, element: XmlElement, solids: SolidTable) -> list[TemplateOperand]:
    operands: list[TemplateOperand] = []
    # <firstposition> and <firstrotation> move the first operand, <position> and <rotation> the second.
    for tag, prefix in (("first", "first"), ("second", "")):
        template = _look_up_solid(reading, _find_child(element, tag), solids)
        shift, rotation, _ = read_motion(reading, element, operand_rotation, prefix)
        operands.append((template, shift, rotation))
    return operands


def _read_union_nodes(reading: GdmlReader, element: XmlElement, solids: SolidTable) -> list[TemplateOperand]:
    operands = []
    for node in reading.each(element.children):
        if local_tag(node) == "multiUnionNode":
            template = _look_up_solid(reading, _find_child(node, "solid"), solids)
            shift, rotation, _ = read_motion(reading, node, operand_rotation)
            operands.append((template, shift, rotation))
    if not operands:
        raise GdmlError(element, "must have multiUnionNode elements")
    return operands


def _read_transformed(reading: GdmlReader, element: XmlElement, solids: SolidTable) -> TemplateOperand:
    """Return the operand of a <scaledSolid>, or of a <reflectedSolid>: scaled, rotated and shifted by attributes."""
    if local_tag(element) == "scaledSolid":
        template = _look_up_solid(reading, _find_child(element, "solidref"), solids)
        _, _, scale = read_motion(reading, element, operand_rotation)
        return template, ORIGIN, scaling(scale)
    template = _look_up_solid(reading, element, solids, "solid")
    values = GdmlValues(reading, element)
    scale = values.number("sx", 1), values.number("sy", 1), values.number("sz", 1)
    if not all(scale):
        raise GdmlError(element, "sx, sy and sz must not be 0")
    angles = values.angle("rx", 0), values.angle("ry", 0), values.angle("rz", 0)
    rotation = compose_rotations(operand_rotation(angles), scaling(scale)) if any(angles) else scaling(scale)
    return template, (values.length("dx", 0), values.length("dy", 0), values.length("dz", 0)), rotation


__all__ = ["NO_ROTATION", "ORIGIN", "SOLID_READERS", "SolidTable", "read_solids", "read_template"]
