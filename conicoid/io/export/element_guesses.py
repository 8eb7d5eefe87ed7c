"""Recognize solids that importers made of one element of GDML or one ball of OpenSCAD, to write that element again.

The numbers of the element are guessed: short decimals near the numbers of the solid. A guess counts only if an importer
makes exactly the same solid of it, so that a wrong guess costs time but never correctness.
"""

from __future__ import annotations

import itertools
import math
from collections.abc import Iterator
from fractions import Fraction
from functools import lru_cache
from itertools import chain

from ..._util.arrays import Vector
from ...geometry.general_quadric import Quadric
from ...geometry.polyhedron import Polyhedron
from ...geometry.primitives import Box, HalfSpace
from ...geometry.revolution import Revolution
from ...geometry.shape import Boolean, Difference, Intersection, Solid
from ...geometry.transform import IDENTITY_MOTION, Scale, Translate
from ..gdml.solids import read_template
from ..gdml.values import GdmlError, GdmlReader, GdmlUnsupported
from ..openmc.placement import UniversePlacement
from ..openscad.solids import ball_rings, regular_polygon
from ..xml_tree import XmlElement
from .exporters import format_number, shortest_decimal
from .pieces import ExtrusionPiece, NativePiece, PieceBoolean, PieceLeaf, PieceNode

# Paraboloids and hyperboloids, which importers make as a quadric that a box cuts.

_BOWL_GUESS_DIGITS = (6, 9, 12)
"""Decimals that are tried for the numbers of the element."""
_Wall = tuple[float, float, float]
"""g0, g1, g2 of x² + y² <= g0 + g1 z + g2 z²"""


def guess_bowls(solid: Intersection | Difference) -> Iterator[NativePiece]:
    """Yield the paraboloids and hypes of GDML that a solid may be."""
    outer: Solid = solid
    inner: Solid | None = None
    if isinstance(solid, Difference) and len(solid.operands) == 2:
        outer, inner = solid.operands
    if not isinstance(outer, Intersection) or len(outer.operands) != 2 or outer.motion.steps:
        return
    boxes = [part for part in outer.operands if isinstance(part, Box) and not part.motion.steps]
    walls = [part for part in outer.operands if not isinstance(part, Box)]
    if len(boxes) != 1 or len(walls) != 1:
        return
    low, high = shortest_decimal(boxes[0].low[2]), shortest_decimal(boxes[0].high[2])
    place, wall = _shift(walls[0]), _wall(walls[0])
    bore = (0.0, 0.0, 0.0) if inner is None else _wall(inner)
    if place is None or wall is None or bore is None:
        return
    at = (shortest_decimal(place[0]), shortest_decimal(place[1]), (low + high) / 2)
    for digits in _BOWL_GUESS_DIGITS:
        if wall[2] or bore[2]:
            yield _guess_hype(wall, bore, low, high, at, digits)
        elif inner is None:
            radii = [_rounded(_radius(wall, float(z)), digits) for z in (low, high)]
            text = (
                f' rlo="{format_number(radii[0])}" rhi="{format_number(radii[1])}" '
                f'dz="{format_number((high - low) / 2)}" lunit="mm"'
            )
            yield NativePiece("paraboloid", text, "", at)


def _guess_hype(wall: _Wall, bore: _Wall, low: Fraction, high: Fraction, at: tuple[Fraction, Fraction, Fraction],
          digits: int) -> NativePiece:  # fmt: skip
    attributes = ""
    for each, radius, angle in ((bore, "rmin", "inst"), (wall, "rmax", "outst")):
        degrees = math.degrees(math.atan(math.sqrt(max(each[2], 0.0))))
        size = _rounded(_radius(each, float(at[2])), digits)
        attributes += f' {radius}="{format_number(size)}" {angle}="{format_number(_rounded(degrees, digits))}"'
    return NativePiece("hype", f'{attributes} z="{format_number(high - low)}" aunit="deg" lunit="mm"', "", at)


def _shift(solid: Solid) -> tuple[float, float, float] | None:
    """Return the shift of a wall; None if it is moved in another way."""
    steps = solid.motion.steps
    if not steps:
        return 0.0, 0.0, 0.0
    return steps[0].offset if len(steps) == 1 and isinstance(steps[0], Translate) else None


def _wall(solid: Solid) -> _Wall | None:
    """Return the coefficients of a quadric about z or of a cylinder; None for other solids."""
    if isinstance(solid, Quadric) and solid.coefficients is not None:
        coefficients = dict(solid.coefficients)
        if coefficients.pop("xx", 0.0) != 1 or coefficients.pop("yy", 0.0) != 1:
            return None
        return -coefficients.get("constant", 0.0), -coefficients.get("z", 0.0), -coefficients.get("zz", 0.0)
    if isinstance(solid, Revolution) and len(solid.profile) == 4:
        return max(r for r, _ in solid.profile) ** 2, 0.0, 0.0
    return None


def _radius(wall: _Wall, z: float) -> float:
    """Return the radius of a wall at height z."""
    g0, g1, g2 = wall
    return math.sqrt(max(g0 + z * (g1 + z * g2), 0.0))


def _rounded(value: float, digits: int) -> Fraction:
    return Fraction(f"{round(value, digits):.{digits}f}")


# Elements of GDML in general.

_LIKE = 1e-9
"""Tolerance of the test whether sides are regular; the comparison with the solid is exact."""
_GUESS_DIGITS = (6, 9, 12, 15)
"""Decimals that are tried for numbers that an importer computed from others."""


def guess_element(solid: Solid) -> PieceLeaf | None:
    """Return the GDML element that a solid is, without the motion of the solid; None if there is none.

    The elements are cutTube, polyhedra of one section, paraboloid and hype.
    """
    plain = solid if solid.motion.is_identity else solid._moved(IDENTITY_MOTION)
    return _guess_plain(plain)


@lru_cache(256)
def _guess_plain(plain: Solid) -> PieceLeaf | None:
    """Return `guess_element` of a solid without a motion. It is cached, as many bodies are one such solid moved."""
    guesses: Iterator[NativePiece]
    if isinstance(plain, Intersection):
        guesses = chain(_cut_tubes(plain), guess_bowls(plain))
    elif isinstance(plain, Difference):
        guesses = chain(_polyhedra(plain), guess_bowls(plain))
    elif isinstance(plain, Polyhedron):
        guesses = _polyhedra(plain)
    else:
        return None
    for guess in guesses:
        if _read_guess(guess) == plain:
            return PieceLeaf(guess)
    return None


def _read_guess(guess: NativePiece) -> Solid | None:
    """Return the solid that the GDML importer makes of an element at its place; None if it refuses the element."""
    element = _element(guess.tag, guess.attributes)
    for child in guess.children.split("/>")[:-1]:
        tag, _, attributes = child[1:].partition(" ")
        element.children.append(_element(tag, attributes))
    try:
        return read_template(GdmlReader(""), element, {}).at(UniversePlacement(shift=guess.shift))
    except (GdmlError, GdmlUnsupported, ValueError):
        return None


def _element(tag: str, attributes: str) -> XmlElement:
    """Return an element with attributes as `NativePiece` has them: a="..." b="..."."""
    pairs = (pair.split('="') for pair in attributes.split('" ') if pair.strip())
    return XmlElement(tag, 0, 0, {name.strip(): value.rstrip('"') for name, value in pairs})


# Tubes between slanted planes.


def _cut_tubes(solid: Intersection) -> Iterator[NativePiece]:
    """Yield the cutTube that an intersection of a tube and two half-spaces may be."""
    if len(solid.operands) != 3:
        return
    tube, low, high = solid.operands
    if not (isinstance(tube, Revolution) and isinstance(low, HalfSpace) and isinstance(high, HalfSpace)):
        return
    if low.motion.steps or high.motion.steps or len(tube.profile) != 4:
        return
    shift = tube.motion.steps[0].offset if tube.motion.steps else (0.0, 0.0, 0.0)  # type: ignore[union-attr]
    if tube.motion.steps and not (len(tube.motion.steps) == 1 and isinstance(tube.motion.steps[0], Translate)):
        return
    ends = []
    for side in (low, high):
        a, b, c = map(shortest_decimal, side.normal)
        if not c:
            return
        ends.append(
            (shortest_decimal(side.offset) - a * shortest_decimal(shift[0]) - b * shortest_decimal(shift[1])) / c
        )
    (inner, _), (outer, _) = tube.profile[:2]
    size, middle = ends[1] - ends[0], (ends[0] + ends[1]) / 2
    width = shortest_decimal(tube.end_angle) - shortest_decimal(tube.start_angle)
    named = zip(("low", "high"), (low.normal, high.normal), strict=True)
    normals = "".join(
        f' {name}{axis}="{format_number(n)}"' for name, normal in named for axis, n in zip("XYZ", normal, strict=True)
    )
    text = (
        f' rmin="{format_number(inner)}" rmax="{format_number(outer)}" z="{format_number(size)}" '
        f'startphi="{format_number(tube.start_angle)}"'
    )
    at = shortest_decimal(shift[0]), shortest_decimal(shift[1]), middle
    yield NativePiece("cutTube", f'{text} deltaphi="{format_number(width)}"{normals} aunit="deg" lunit="mm"', "", at)


# Prisms and pyramids of equal sides about z.


def _polyhedra(solid: Solid) -> Iterator[NativePiece]:
    """Yield the polyhedra of one section that a body of equal sides may be, with a bore or without."""
    parts = solid.operands if isinstance(solid, Boolean) else (solid,)
    if len(parts) > 2 or not all(isinstance(part, Polyhedron) for part in parts):
        return
    if len(parts) == 2 and any(part.motion.steps for part in parts):
        return
    body = parts[0]
    assert isinstance(body, Polyhedron)
    count = len(body.normals) - 2
    if count < 3 or body.normals[:2] != ((0.0, 0.0, -1.0), (0.0, 0.0, 1.0)):
        return
    if not _is_regular(body.normals[2:]):
        return
    z0, z1 = -shortest_decimal(body.offsets[0]), shortest_decimal(body.offsets[1])
    sides = []
    for part in parts:
        assert isinstance(part, Polyhedron)
        sides.append(list(zip(part.normals[2:], part.offsets[2:], strict=True)))
    shift = _axis_of(sides[0])
    step = 360.0 / count
    normal = body.normals[2]
    start = math.degrees(math.atan2(normal[1], normal[0])) - step / 2
    for digits in _GUESS_DIGITS:
        axis = tuple(_near(value, digits) for value in shift)
        radii = []
        for (a, b, c), offset in (rows[0] for rows in sides):
            at = offset - a * float(axis[0]) - b * float(axis[1])
            radii.append([_near(at - c * float(z), digits) for z in (z0, z1)])
        radii.append([Fraction(0), Fraction(0)])
        middle = _near(_middle(parts[-1]), digits)
        for low, high in ((z0 - middle, z1 - middle), (_near(z0 - middle, digits), _near(z1 - middle, digits))):
            ends = "".join(
                f'<zplane z="{format_number(z)}" rmin="{format_number(radii[1][k])}" '
                f'rmax="{format_number(radii[0][k])}"/>'
                for k, z in enumerate((low, high))
            )
            for angle in (start, start + 360.0):
                text = f' startphi="{format_number(_near(angle, digits))}" deltaphi="360" numsides="{count}"'
                yield NativePiece("polyhedra", f'{text} aunit="deg" lunit="mm"', ends, (axis[0], axis[1], middle))


def _is_regular(normals: tuple[Vector, ...]) -> bool:
    """Return True if each normal, turned by 360° / count about z, is the next one, to within `_LIKE`."""
    c, s = math.cos(2 * math.pi / len(normals)), math.sin(2 * math.pi / len(normals))
    return all(
        max(abs(c * x - s * y - u), abs(s * x + c * y - v), abs(z - w), abs(math.hypot(x, y) - 1)) < _LIKE
        for (x, y, z), (u, v, w) in zip(normals, (*normals[1:], normals[0]), strict=True)
    )


def _middle(part: Solid) -> float:
    """Return half the difference of the end offsets: the middle of a part.

    A bore extends equally far in both directions from the origin of its element, so this finds the origin.
    """
    assert isinstance(part, Polyhedron)
    return float((shortest_decimal(part.offsets[1]) - shortest_decimal(part.offsets[0])) / 2)


def _axis_of(rows: list[tuple[tuple[float, float, float], float]]) -> tuple[float, float]:
    """Return the axis (x, y) of equal sides: twice the mean of normal times offset.

    The parts of the offsets that do not depend on the axis cancel around it.
    """
    x = 2 * sum(normal[0] * offset for normal, offset in rows) / len(rows)
    y = 2 * sum(normal[1] * offset for normal, offset in rows) / len(rows)
    return x, y


def _near(value: float | Fraction, digits: int) -> Fraction:
    """Return a number rounded to some decimals."""
    return Fraction(f"{round(float(value), digits):.{digits}f}")


# Balls of flat sides, which OpenSCAD makes with $fn, and which importers read as frustums.

_NEAR_ULPS = 4
"""Floats that are tried on either side of the radius that follows from the highest ring."""


def guess_ball(node: PieceBoolean) -> tuple[float, int] | None:
    """Return the radius and the number of sides of the ball that a union of frustums is; None if it is none."""
    parts = node.parts
    if node.kind != "union" or not all(
        isinstance(part, PieceLeaf) and isinstance(part.piece, ExtrusionPiece) for part in parts
    ):
        return None
    pieces = [part.piece for part in parts if isinstance(part, PieceLeaf) and isinstance(part.piece, ExtrusionPiece)]
    sides = len(pieces[0].outline)
    if (sides + 1) // 2 != len(parts) + 1 or any(len(piece.outline) != sides for piece in pieces):
        return None
    _, top = ball_rings(1.0, sides)[-1]
    last = pieces[-1]
    radius = max(last.high, -last.low) / top
    for _ in range(_NEAR_ULPS):
        radius = math.nextafter(radius, 0.0)
    for _ in range(2 * _NEAR_ULPS + 1):
        if list(parts) == _ball_frustums(radius, sides):
            return radius, sides
        radius = math.nextafter(radius, math.inf)
    return None


def _ball_frustums(radius: float, sides: int) -> list[PieceNode]:
    """Return the frustums that the OpenSCAD importer reads for a ball of flat sides."""
    frustums: list[PieceNode] = []
    for (first, low), (second, high) in itertools.pairwise(ball_rings(radius, sides)):
        if first >= second:
            frustums.append(PieceLeaf(ExtrusionPiece(regular_polygon(first, sides), low, high, second / first)))
        else:
            frustums.append(
                PieceLeaf(
                    ExtrusionPiece(regular_polygon(second, sides), -high, -low, first / second),
                    (Scale((1.0, 1.0, -1.0)),),
                )
            )
    return frustums
