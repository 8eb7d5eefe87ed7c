"""The <solids> section of a GDML file: templates by name, and solids of outlines and sections.

Polycones revolve an outline of (r, z); polyhedra replace the circle by a polygon of `numsides` sides; <xtru> sweeps an
outline of (x, y) through sections along z. Each public reader returns a `SolidFactory`, which builds the solid
translated by a shift. Lengths are in mm, angles in degrees. Wrong attributes raise GdmlError; outlines that no solid
has raise OmittedPart.
"""

from __future__ import annotations

import math
from collections.abc import Callable, Sequence
from fractions import Fraction
from functools import partial
from itertools import pairwise
from typing import cast

from ...geometry.polyhedron import Extrusion
from ...geometry.shape import Difference, Solid, Union
from ...geometry.sheets import check_outline, check_simple
from ...numerics.portable_math import sin_cos_degrees
from ..importers import OmittedPart
from ..openmc.placement import ORIGIN, Point, UniversePlacement
from ..xml_tree import XmlElement
from . import flat_solids, round_solids
from .expressions import UNIT_VALUES
from .flat_solids import FacePlane, closed_mesh, convex_planes, polyhedron_factory
from .round_solids import RevolvedProfile, read_angles
from .solid_template import (
    BooleanKind,
    PrimitiveTemplate,
    SharedSolid,
    SolidFactory,
    SolidTemplate,
    SourceElement,
    TemplateOperand,
    combine_templates,
)
from .values import (
    GdmlError,
    GdmlReader,
    GdmlValues,
    compose_rotations,
    local_tag,
    look_up,
    operand_rotation,
    read_motion,
    read_reference,
    scaling,
)

_ZERO = Fraction(0)
RadiusLine = tuple[Fraction, Fraction]
"""A distance from the axis that is linear in z: (distance at z = 0, slope)."""
SideRing = tuple[Fraction, Fraction, RadiusLine, RadiusLine]
"""(lower z, upper z, inner edge, outer edge)."""
ZPlane = tuple[Fraction, Fraction, Fraction]
"""(z, rmin, rmax)."""

# Polycones


def polycone(values: GdmlValues) -> SolidFactory:
    """<polycone>: a stack of truncated cones between zplane elements with z, rmin, rmax."""
    planes = read_zplanes(values)
    angles = read_angles(values)
    rings = [ring for ring in map(zplane_ring, planes, planes[1:]) if ring]
    if not rings:
        raise GdmlError(values.element, "zplane elements must leave a volume")
    outline = [(outer, z) for z, _, outer in planes] + [(inner, z) for z, inner, _ in reversed(planes)]
    return partial(_stack, RevolvedProfile(outline, angles), [RevolvedProfile(ring, angles) for ring in rings])


def _stack(outline: RevolvedProfile, rings: Sequence[RevolvedProfile], shift: Point) -> Solid:
    """Return the revolved outline; the union of its rings if the outline touches itself."""
    # One outline has no walls between its rings, so a ray does not meet faces that the solid does not have
    if len(rings) > 1:
        try:
            return outline(shift)
        except ValueError:  # the outline touches itself, which no Revolution may
            return Union(tuple(ring(shift) for ring in rings))
    return rings[0](shift)


def read_zplanes(values: GdmlValues) -> list[ZPlane]:
    """Return (z, rmin, rmax) of the zplane elements, in rising z.

    Raise GdmlError for fewer than two planes or rmin > rmax, and OmittedPart for planes in no order.
    """
    planes = []
    for element in values.element.all("zplane"):
        part = GdmlValues(values.reading, element, values.element)
        z, inner, outer = part.length("z"), part.radius("rmin"), part.radius("rmax")
        if inner > outer:
            raise GdmlError(element, f"rmin must be <= rmax = {float(outer):g} mm, got {float(inner):g} mm")
        planes.append((z, inner, outer))
    # Expressions for one height may differ by less than a float can
    heights = [float(z) for z, _, _ in planes]
    if len(planes) < 2:
        raise GdmlError(values.element, "must have two or more zplane elements")
    # Geant4 takes sections from above and from below
    if heights == sorted(heights, reverse=True):
        planes.reverse()
    elif heights != sorted(heights):
        raise OmittedPart("its zplane elements neither rise nor fall in z")
    return planes


def zplane_ring(low: ZPlane, high: ZPlane) -> list[tuple[Fraction, Fraction]]:
    """Return the profile (r, z) between two planes; empty if it has no area."""
    (z0, a, b), (z1, c, d) = low, high
    # Two planes at one height make a step of the radius, not a ring; planes whose radii are equal at both ends enclose
    # nothing
    return [(a, z0), (b, z0), (d, z1), (c, z1)] if float(z0) < float(z1) and a + c < b + d else []


def generic_polycone(values: GdmlValues) -> SolidFactory:
    """<genericPolycone>: a polygon of rzpoint elements with r and z, revolved about z."""
    return partial(_revolve_outline, RevolvedProfile(read_rzpoints(values), read_angles(values)))


def _revolve_outline(profile: RevolvedProfile, shift: Point) -> Solid:
    try:
        return profile(shift)
    except ValueError as error:
        raise OmittedPart(f"its rzpoint elements make no simple outline: {error}") from None


def read_rzpoints(values: GdmlValues) -> list[tuple[Fraction, Fraction]]:
    """Return (r, z) of the rzpoint elements. Raise GdmlError for fewer than three."""
    parts = [GdmlValues(values.reading, element, values.element) for element in values.element.all("rzpoint")]
    if len(parts) < 3:
        raise GdmlError(values.element, "must have three or more rzpoint elements")
    return [(part.radius("r"), part.length("z")) for part in parts]


# Polyhedra


def polyhedra(values: GdmlValues) -> SolidFactory:
    """<polyhedra>: `numsides` sides about z; the radii of zplane elements are distances to the sides."""
    planes = read_zplanes(values)
    rings = []
    for (z0, a, b), (z1, c, d) in pairwise(planes):
        if zplane_ring((z0, a, b), (z1, c, d)):
            rings.append((z0, z1, _radius_line(a, z0, c, z1), _radius_line(b, z0, d, z1)))
    return _stack_sides(values, rings, Fraction(1))


def generic_polyhedra(values: GdmlValues) -> SolidFactory:
    """<genericPolyhedra>: `numsides` sides about z; the radii of rzpoint elements are distances to the corners."""
    s, c = _half_side(values)
    del s
    return _stack_sides(values, _side_rings(read_rzpoints(values)), Fraction(c))


def _side_count(values: GdmlValues) -> int:
    count = values.integer("numsides", most=10_000)
    if count < 1:
        raise GdmlError(values.element, f"numsides must be 1 or more, got {count}")
    return count


def _half_side(values: GdmlValues) -> tuple[float, float]:
    """Return sine and cosine of half the angle of a side. Raise GdmlError if a side has 180 degrees or more."""
    first, last = read_angles(values)
    width = (last - first) / _side_count(values)
    if width >= 180:
        raise GdmlError(values.element, "numsides must leave each side less than 180 degrees")
    return sin_cos_degrees(width / 2)


def _radius_line(r0: Fraction, z0: Fraction, r1: Fraction, z1: Fraction) -> RadiusLine:
    """Return the line through (r0, z0) and (r1, z1)."""
    growth = (r1 - r0) / (z1 - z0)
    return r0 - growth * z0, growth


def _side_rings(corners: Sequence[tuple[Fraction, Fraction]]) -> list[SideRing]:
    """Cut a polygon of (r, z) into rings at the heights of its corners. Raise OmittedPart if it has no area."""
    ends = list(zip(corners, [*corners[1:], corners[0]], strict=True))
    heights = sorted({z for _, z in corners})
    rings = []
    for low, high in pairwise(heights):
        # Edges are in one order between the heights of two corners, and the middle shows it
        middle = (low + high) / 2
        across = []
        for (r0, z0), (r1, z1) in ends:
            if min(z0, z1) <= low and high <= max(z0, z1):
                across.append(_radius_line(r0, z0, r1, z1))
        across.sort(key=lambda edge: edge[0] + edge[1] * middle)
        if any(a + b * z > c + d * z for (a, b), (c, d) in pairwise(across) for z in (low, high)):
            raise OmittedPart("its rzpoint elements make no simple outline: edges cross")
        # Edges that do not cross enter and leave the polygon in turn
        for inner, outer in zip(across[::2], across[1::2], strict=True):
            if inner != outer:
                rings.append((low, high, inner, outer))
    if not rings:
        raise OmittedPart("its rzpoint elements enclose nothing")
    return rings


def _stack_sides(values: GdmlValues, rings: Sequence[SideRing], share: Fraction) -> SolidFactory:
    """Return the factory of rings with flat sides.

    `share` is the distance to a side divided by the radius: 1 for radii of sides, cos(half angle) for radii of corners.
    A full turn of more than two sides is a convex body less a convex bore for each ring; otherwise every side is a
    wedge of its own. Raise OmittedPart for more than 20,000 sides.
    """
    count, whole = _side_count(values), read_angles(values) == (0.0, 360.0)
    if not rings:
        raise GdmlError(values.element, "must leave a volume")
    # Each side is a plane or a wedge that preparing must look at
    if count * len(rings) > 20_000:
        raise OmittedPart("it has more than 20,000 sides")
    _half_side(values)  # checks that sides are less than 180 degrees
    # A full turn still begins at startphi: it fixes where the edges are
    begin = values.angle("startphi", 0)
    step = (Fraction(360) if whole else values.angle("deltaphi", 360)) / count
    normals = [_direction(begin + (k + Fraction(1, 2)) * step) for k in range(count)]
    walls = [(-y, x) for x, y in (_direction(begin + k * step) for k in range(count + 1))]
    pieces = []
    for low, high, inner, outer in rings:
        ends: list[FacePlane] = [((_ZERO, _ZERO, Fraction(-1)), -low), ((_ZERO, _ZERO, Fraction(1)), high)]
        if whole and count > 2:
            body = polyhedron_factory([*ends, *(_side_plane(n, outer, share, 1) for n in normals)])
            # Of radius 0 at both ends there is no bore, and a polyhedron without width would be refused
            bore = None
            if inner[0] + inner[1] * (low + high) / 2 > 0:
                # The bore reaches beyond the ends of the body, so that no faces coincide.
                far = (high - low) + abs(low) + abs(high)
                outside: list[FacePlane] = [((_ZERO, _ZERO, Fraction(-1)), far), ((_ZERO, _ZERO, Fraction(1)), far)]
                bore = polyhedron_factory([*outside, *(_side_plane(n, inner, share, 1) for n in normals)])
            pieces.append((body, bore))
            continue
        for k, normal in enumerate(normals):
            (ax, ay), (bx, by) = walls[k], walls[k + 1]
            # Neighbouring wedges share the plane between them, the same numbers with another sign, so that the union
            # has no wall there
            wedge: list[FacePlane] = [((-ax, -ay, _ZERO), _ZERO), ((bx, by, _ZERO), _ZERO)]
            planes = [*ends, *wedge, _side_plane(normal, outer, share, 1), _side_plane(normal, inner, share, -1)]
            pieces.append((polyhedron_factory(planes), None))
    return partial(_bore_pieces, pieces)


def _bore_pieces(pieces: Sequence[tuple[SolidFactory, SolidFactory | None]], shift: Point) -> Solid:
    """Return the union of all pieces, each less its bore if it has one."""
    solids = [body(shift) if bore is None else Difference((body(shift), bore(shift))) for body, bore in pieces]
    return solids[0] if len(solids) == 1 else Union(tuple(solids))


def _direction(degrees: Fraction) -> tuple[Fraction, Fraction]:
    # Reduced and rounded once, so that parts of one polyhedra have its sides and share the walls between them
    s, c = sin_cos_degrees(float(degrees % 360))
    return Fraction(c), Fraction(s)


def _side_plane(normal: tuple[Fraction, Fraction], edge: RadiusLine, share: Fraction, sense: int) -> FacePlane:
    """Return the plane normal·(x, y) <= share (distance + growth z); with >= if `sense` is -1."""
    x, y = normal
    distance, growth = edge
    return (sense * x, sense * y, -sense * share * growth), sense * share * distance


# Extruded outlines

_XtruSection = tuple[Fraction, Fraction, Fraction, Fraction]
"""(z, x offset, y offset, scale)."""


def xtru(values: GdmlValues) -> SolidFactory:
    """<xtru>: an outline of twoDimVertex elements, swept through section elements that shift and scale it."""
    parts = [GdmlValues(values.reading, element, values.element) for element in values.element.all("twoDimVertex")]
    outline = [(part.length("x"), part.length("y")) for part in parts]
    # Some programs close the outline by its first corner
    if outline and outline[0] == outline[-1]:
        outline.pop()
    if len(outline) < 3:
        raise GdmlError(values.element, "must have three or more twoDimVertex elements")
    is_convex = _is_convex_outline(outline)
    values.reading.spend(len(outline), is_convex)
    sections: list[tuple[Fraction, Fraction, Fraction, Fraction, Fraction]] = []
    for element in values.element.all("section"):
        part = GdmlValues(values.reading, element, values.element)
        scale = part.number("scalingFactor", 1)
        if scale < 0:
            raise GdmlError(element, f"scalingFactor must be >= 0, got {float(scale):g}")
        z = part.length("zPosition")
        sections.append(
            (part.number("zOrder", len(sections)), z, part.length("xOffset", 0), part.length("yOffset", 0), scale)
        )
    # The attribute zOrder gives the order, whatever stands first in the file
    sections.sort(key=lambda section: section[0])
    drawn = [section[1:] for section in sections]
    is_shared = len(outline) > _MANY_CORNERS and not is_convex
    if is_shared:
        outline, drawn = _on_grid(outline, drawn)
    # Two sections at one height are a step in size or place
    pieces = [_sweep_outline(outline, a, b) for a, b in pairwise(drawn) if a[0] < b[0]]
    if not pieces or any(a[0] > b[0] for a, b in pairwise(drawn)):
        raise GdmlError(values.element, "section elements must rise in zPosition")
    make = partial(_bore_pieces, [(piece, None) for piece in pieces])
    return SharedSolid(make) if is_shared else make


_MANY_CORNERS = 128
"""A concave outline of more corners is cut into convex parts once for all places, which takes about a second."""


def _on_grid(
    outline: Sequence[tuple[Fraction, Fraction]], sections: Sequence[_XtruSection]
) -> tuple[list[tuple[Fraction, Fraction]], list[_XtruSection]]:
    """Round corners and offsets to multiples of a power of two, so that floats hold their sums.

    Sides between sections of scale 1 with different offsets are then flat: rounded corners would make two triangles of
    each side, with a ridge or a groove between them, and grooves double the convex parts.
    """
    most = sum(max(abs(c) for pair in pairs for c in pair) for pairs in (outline, [each[1:3] for each in sections]))
    unit = Fraction(2) ** (math.frexp(float(most))[1] - 52)
    corners = [(round(x / unit) * unit, round(y / unit) * unit) for x, y in outline]
    return corners, [(z, round(x / unit) * unit, round(y / unit) * unit, scale) for z, x, y, scale in sections]


def _is_convex_outline(outline: Sequence[tuple[Fraction, Fraction]]) -> bool:
    """Return True if the outline bends to one side only, in floating point."""
    points = [(float(x), float(y)) for x, y in outline]
    edges = [(b[0] - a[0], b[1] - a[1]) for a, b in zip(points, [*points[1:], points[0]], strict=True)]
    bends = [a[0] * b[1] - a[1] * b[0] for a, b in zip(edges, [*edges[1:], edges[0]], strict=True)]
    return min(bends) >= 0 or max(bends) <= 0


def _sweep_outline(outline: Sequence[tuple[Fraction, Fraction]], low: _XtruSection, high: _XtruSection) -> SolidFactory:
    """Return the solid between two sections: an extrusion, a convex polyhedron or a closed mesh.

    Sections that differ by z alone make an extrusion. Corners that coincide (a section of scale 0) are merged.
    """
    if low[1:] == high[1:]:
        return partial(_extrude_outline, outline, low, high[0])
    points = [(s * x + x0, s * y + y0, z) for z, x0, y0, s in (low, high) for x, y in outline]
    # Scale 0 draws the whole section into one point: a pyramid
    places = list(dict.fromkeys(points))
    number = {place: k for k, place in enumerate(places)}
    count = len(outline)
    faces = [(k, (k + 1) % count, count + (k + 1) % count, count + k) for k in range(count)]
    rings = [tuple(reversed(range(count))), tuple(range(count, 2 * count))]
    merged = [tuple(dict.fromkeys(number[points[k]] for k in face)) for face in [*faces, *rings]]
    polygons = [face for face in merged if len(face) > 2]
    # The rule of tessellated solids: the export writes this solid as one, and must get the same shape back.
    planes = convex_planes(places, polygons)
    if planes is not None:
        return polyhedron_factory(planes)
    _check_simple_outline(outline)
    return closed_mesh(places, polygons)


def _check_simple_outline(outline: Sequence[tuple[Fraction, Fraction]]) -> None:
    """Raise OmittedPart if an outline is none of an Extrusion: a mesh closes even where its faces cross each other."""
    corners = [(float(x), float(y)) for x, y in outline]
    try:
        check_simple("xtru", "outline", check_outline("xtru", "outline", corners))
    except ValueError as error:
        raise OmittedPart(f"its outline cannot be drawn: {error}") from None


def _extrude_outline(
    outline: Sequence[tuple[Fraction, Fraction]], low: _XtruSection, end: Fraction, shift: Point
) -> Solid:
    """Return the extrusion of a section up to the height `end`. Raise OmittedPart if the outline is not simple."""
    z0, x0, y0, scale = low
    a, b, c = shift
    corners = tuple((float(scale * x + x0 + a), float(scale * y + y0 + b)) for x, y in outline)
    try:
        return Extrusion(corners, (float(z0 + c), float(end + c)))
    except ValueError as error:
        raise OmittedPart(f"its outline cannot be drawn: {error}") from None


# The <solids> section of a GDML file: solid templates by name.
#
# `SOLID_READERS` maps each tag of a primitive to the function that reads it. Booleans, multi-unions, scaled and
# reflected solids combine templates that stand before them in the file.

SOLID_READERS: dict[str, Callable[[GdmlValues], SolidFactory]] = {
    "box": flat_solids.box, "tube": round_solids.tube, "cutTube": round_solids.cut_tube, "cone": round_solids.cone,
    "sphere": round_solids.sphere, "orb": round_solids.orb, "ellipsoid": round_solids.ellipsoid,
    "eltube": round_solids.elliptic_tube, "elcone": round_solids.elliptic_cone,
    "paraboloid": round_solids.paraboloid, "hype": round_solids.hyperboloid, "trd": flat_solids.trd,
    "trap": flat_solids.trap, "para": flat_solids.para, "tet": flat_solids.tet, "arb8": flat_solids.arb8,
    "polycone": polycone, "genericPolycone": generic_polycone,
    "polyhedra": polyhedra, "genericPolyhedra": generic_polyhedra, "xtru": xtru,
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
        except OmittedPart as left:
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
    OmittedPart
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
        # A union of one operand is the operand, moved
        return combine_templates("union", [_read_transformed(reading, element, solids)])
    elif tag in _UNSUPPORTED_SOLIDS:
        raise OmittedPart("is no quadric")
    else:
        raise OmittedPart("is no solid that is known")
    # A Boolean is not built here: its operands were, and a large union would be built twice
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
    """Return the template that an attribute names. Raise OmittedPart if that solid is left out."""
    name = read_reference(reading, element, attribute)
    template: SolidTemplate | None = (
        look_up(reading, dict(solids), name, element, "solid") if name not in solids else solids[name]
    )
    # An operand is left out, so the result would be another solid: it is left out as well, and the remark names the
    # cause
    if template is None:
        raise OmittedPart(f"is of {name!r}, which is left out")
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
    # A factor of zero flattens the solid
    if not all(scale):
        raise GdmlError(element, f"sx, sy and sz must not be 0, got {', '.join(f'{float(s):g}' for s in scale)}")
    angles = values.angle("rx", 0), values.angle("ry", 0), values.angle("rz", 0)
    rotation = compose_rotations(operand_rotation(angles), scaling(scale)) if any(angles) else scaling(scale)
    return template, (values.length("dx", 0), values.length("dy", 0), values.length("dz", 0)), rotation
