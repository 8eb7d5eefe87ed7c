"""GDML's solids of outlines and sections: polyhedra about z, and outlines drawn along z."""

from __future__ import annotations

from collections.abc import Sequence
from fractions import Fraction
from functools import partial
from itertools import pairwise

from ...geometry.csg import Difference, Union
from ...geometry.mesh import Extrusion
from ...geometry.shape import Solid
from ...numerics.portable_math import sin_cos_degrees
from ..openmc.placement import Point
from .flat_solids import FacePlane, closed_mesh, convex_planes, polyhedron_factory
from .round_solids import read_angles, read_rzpoints, read_zplanes, zplane_ring
from .solid_template import SolidFactory
from .values import GdmlError, GdmlUnsupported, GdmlValues

_ZERO = Fraction(0)
RadiusLine = tuple[Fraction, Fraction]
"""(distance at z = 0, its growth with z)."""
SideRing = tuple[Fraction, Fraction, RadiusLine, RadiusLine]
"""Between two heights, from one edge to another."""


def polyhedra(values: GdmlValues) -> SolidFactory:
    """numsides sides about z; radii are distances to the sides."""
    planes = read_zplanes(values)
    rings = []
    for (z0, a, b), (z1, c, d) in pairwise(planes):
        if zplane_ring((z0, a, b), (z1, c, d)):
            rings.append((z0, z1, _radius_line(a, z0, c, z1), _radius_line(b, z0, d, z1)))
    return _stack_sides(values, rings, Fraction(1))


def generic_polyhedra(values: GdmlValues) -> SolidFactory:
    """numsides sides about z; radii of rzpoint elements are those of corners."""
    s, c = _half_side(values)
    del s
    return _stack_sides(values, _side_rings(read_rzpoints(values)), Fraction(c))


def _side_count(values: GdmlValues) -> int:
    count = values.integer("numsides", most=10_000)
    if count < 1:
        raise GdmlError(values.element, "numsides must be 1 or more")
    return count


def _half_side(values: GdmlValues) -> tuple[float, float]:
    """Sine and cosine of half the angle of a side."""
    first, last = read_angles(values)
    width = (last - first) / _side_count(values)
    if width >= 180:
        raise GdmlError(values.element, "numsides must leave each side less than 180 degrees")
    return sin_cos_degrees(width / 2)


def _radius_line(r0: Fraction, z0: Fraction, r1: Fraction, z1: Fraction) -> RadiusLine:
    growth = (r1 - r0) / (z1 - z0)
    return r0 - growth * z0, growth


def _side_rings(corners: Sequence[tuple[Fraction, Fraction]]) -> list[SideRing]:
    """A polygon of (r, z), cut at the heights of its corners."""
    ends = list(zip(corners, [*corners[1:], corners[0]], strict=True))
    heights = sorted({z for _, z in corners})
    found = []
    for low, high in pairwise(heights):
        middle = (low + high) / 2
        across = []
        for (r0, z0), (r1, z1) in ends:
            if min(z0, z1) <= low and high <= max(z0, z1):
                across.append(_radius_line(r0, z0, r1, z1))
        across.sort(key=lambda edge: edge[0] + edge[1] * middle)
        for inner, outer in zip(across[::2], across[1::2], strict=True):
            if inner != outer:
                found.append((low, high, inner, outer))
    if not found:
        raise GdmlUnsupported("its rzpoint elements enclose nothing")
    return found


def _stack_sides(values: GdmlValues, rings: Sequence[SideRing], share: Fraction) -> SolidFactory:
    """Rings of sides. `share`: of the radii, the distances to the sides."""
    count, (first, last) = _side_count(values), read_angles(values)
    if not rings:
        raise GdmlError(values.element, "must leave a volume")
    if count * len(rings) > 20_000:
        raise GdmlUnsupported("it has more than 20,000 sides")
    _half_side(values)
    whole = (first, last) == (0.0, 360.0)
    begin = float(values.angle("startphi", 0)) if whole else first
    step = (last - first) / count
    normals = [_direction(begin + (k + 0.5) * step) for k in range(count)]
    walls = [_direction(begin + k * step + 90) for k in range(count + 1)]
    pieces = []
    for low, high, inner, outer in rings:
        ends: list[FacePlane] = [((_ZERO, _ZERO, Fraction(-1)), -low), ((_ZERO, _ZERO, Fraction(1)), high)]
        if whole and count > 2:
            body = polyhedron_factory([*ends, *(_side_plane(n, outer, share, 1) for n in normals)])
            bore = None
            if inner[0] + inner[1] * (low + high) / 2 > 0:
                far = (high - low) + abs(low) + abs(high)
                outside: list[FacePlane] = [((_ZERO, _ZERO, Fraction(-1)), far), ((_ZERO, _ZERO, Fraction(1)), far)]
                bore = polyhedron_factory([*outside, *(_side_plane(n, inner, share, 1) for n in normals)])
            pieces.append((body, bore))
            continue
        for k, normal in enumerate(normals):
            (ax, ay), (bx, by) = walls[k], walls[k + 1]
            wedge: list[FacePlane] = [((-ax, -ay, _ZERO), _ZERO), ((bx, by, _ZERO), _ZERO)]
            planes = [*ends, *wedge, _side_plane(normal, outer, share, 1), _side_plane(normal, inner, share, -1)]
            pieces.append((polyhedron_factory(planes), None))
    return partial(_bore_pieces, pieces)


def _bore_pieces(pieces: Sequence[tuple[SolidFactory, SolidFactory | None]], shift: Point) -> Solid:
    """All pieces, each less its bore, if it has one."""
    made = [body(shift) if bore is None else Difference((body(shift), bore(shift))) for body, bore in pieces]
    return made[0] if len(made) == 1 else Union(tuple(made))


def _direction(degrees: float) -> tuple[Fraction, Fraction]:
    s, c = sin_cos_degrees(degrees)
    return Fraction(c), Fraction(s)


def _side_plane(normal: tuple[Fraction, Fraction], edge: RadiusLine, share: Fraction, sense: int) -> FacePlane:
    """normal·(x, y) <= share (distance + growth z), or >= where `sense` is -1."""
    x, y = normal
    distance, growth = edge
    return (sense * x, sense * y, -sense * share * growth), sense * share * distance


def xtru(values: GdmlValues) -> SolidFactory:
    """An outline of twoDimVertex elements, drawn through section elements that shift and scale it."""
    parts = [GdmlValues(values.reading, element, values.element) for element in values.element.all("twoDimVertex")]
    outline = [(part.length("x"), part.length("y")) for part in parts]
    if outline and outline[0] == outline[-1]:
        outline.pop()
    if len(outline) < 3:
        raise GdmlError(values.element, "must have three or more twoDimVertex elements")
    values.reading.spend(len(outline), _is_convex_outline(outline))
    sections: list[tuple[Fraction, Fraction, Fraction, Fraction, Fraction]] = []
    for element in values.element.all("section"):
        part = GdmlValues(values.reading, element, values.element)
        scale = part.number("scalingFactor", 1)
        if scale < 0:
            raise GdmlError(element, "scalingFactor must be >= 0")
        z = part.length("zPosition")
        sections.append(
            (part.number("zOrder", len(sections)), z, part.length("xOffset", 0), part.length("yOffset", 0), scale)
        )
    sections.sort(key=lambda section: section[0])
    drawn = [section[1:] for section in sections]
    pieces = [_sweep_outline(outline, a, b) for a, b in pairwise(drawn) if a[0] < b[0]]
    if not pieces or any(a[0] > b[0] for a, b in pairwise(drawn)):
        raise GdmlError(values.element, "section elements must rise in zPosition")
    return partial(_bore_pieces, [(piece, None) for piece in pieces])


def _is_convex_outline(outline: Sequence[tuple[Fraction, Fraction]]) -> bool:
    """Does it bend to one side only?"""
    points = [(float(x), float(y)) for x, y in outline]
    ways = [(b[0] - a[0], b[1] - a[1]) for a, b in zip(points, [*points[1:], points[0]], strict=True)]
    bends = [a[0] * b[1] - a[1] * b[0] for a, b in zip(ways, [*ways[1:], ways[0]], strict=True)]
    return min(bends) >= 0 or max(bends) <= 0


_XtruSection = tuple[Fraction, Fraction, Fraction, Fraction]


def _sweep_outline(outline: Sequence[tuple[Fraction, Fraction]], low: _XtruSection, high: _XtruSection) -> SolidFactory:
    """Between two sections (z, x, y, scale)."""
    if low[1:] == high[1:]:
        return partial(_extrude_outline, outline, low, high[0])
    points = [(s * x + x0, s * y + y0, z) for z, x0, y0, s in (low, high) for x, y in outline]
    places = list(dict.fromkeys(points))
    number = {place: k for k, place in enumerate(places)}
    count = len(outline)
    faces = [(k, (k + 1) % count, count + (k + 1) % count, count + k) for k in range(count)]
    rings = [tuple(reversed(range(count))), tuple(range(count, 2 * count))]
    merged = [tuple(dict.fromkeys(number[points[k]] for k in face)) for face in [*faces, *rings]]
    kept = [face for face in merged if len(face) > 2]
    planes = convex_planes(places, kept)  # as of a tessellated solid, which it is exported as
    return closed_mesh(places, kept) if planes is None else polyhedron_factory(planes)


def _extrude_outline(
    outline: Sequence[tuple[Fraction, Fraction]], low: _XtruSection, end: Fraction, shift: Point
) -> Solid:
    """From a section up to a height, without a change."""
    z0, x0, y0, scale = low
    a, b, c = shift
    corners = tuple((float(scale * x + x0 + a), float(scale * y + y0 + b)) for x, y in outline)
    try:
        return Extrusion(corners, (float(z0 + c), float(end + c)))
    except ValueError as error:
        raise GdmlUnsupported(f"its outline cannot be drawn: {error}") from None
