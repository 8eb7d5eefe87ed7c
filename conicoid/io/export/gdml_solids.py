"""Pieces as the <solids> of a GDML file: boxes, tubes, cones, orbs and others, Booleans of them, moved and scaled.

`SolidWriter` writes each distinct solid once; the parts before it write bowls, closed faces and revolutions.
"""

from __future__ import annotations

import math
from collections.abc import Sequence
from dataclasses import field
from fractions import Fraction
from functools import lru_cache

from ..._util.arrays import VectorLike
from ..._util.records import dataclass
from ...geometry.polyhedron import Polyhedron
from ...geometry.shape import Solid
from ...numerics import bigfloat as ex
from ...numerics.portable_math import sin_cos_degrees
from ..gdml.expressions import evaluate
from ..gdml.flat_solids import convex_planes, polyhedron_factory
from ..gdml.solid_template import SourceElement
from ..openmc.placement import ORIGIN, AxisTurn, Point
from ..openscad.solids import SidedBall
from .exporters import UnsupportedExport, format_expression, format_number, shortest_decimal
from .gdml_motions import (
    AxisStretch,
    ExportPlacement,
    GdmlMove,
    GdmlMoves,
    RigidMove,
    convert_steps,
    join_moves,
    mirror_signs,
    split_last_placement,
)
from .pieces import (
    BallPiece,
    BoxPiece,
    EllipsoidPiece,
    ExtrusionPiece,
    FrustumPiece,
    NativePiece,
    Piece,
    PieceBoolean,
    PieceCorner,
    PieceLeaf,
    PieceNode,
    PolyhedronPiece,
    QuadricPiece,
    RevolutionPiece,
)

LENGTH_UNIT = "\0"
"""Stands for the unit of lengths of the file, in attributes: no text of XML holds this character."""

# Paraboloids and hyperboloids of revolution ("hype"), by the radii and angles of GDML.

_NEAR = 12
"""Floats that are tried on either side of an angle for one that gives the exact slope."""
_STEEPEST = 89.999
"""Largest angle of a hype in degrees."""
_DOWN = AxisTurn(signs=(1, -1, -1))
"""Half a turn about x, which takes z to -z."""


def _paraboloid(solids: SolidWriter, piece: QuadricPiece) -> SolidReference:
    """Write a paraboloid, which opens upward in GDML; half a turn takes the others there."""
    is_up = piece.g1 > 0
    slope = abs(piece.g1)
    low, high = (Fraction(piece.low), Fraction(piece.high)) if is_up else (-Fraction(piece.high), -Fraction(piece.low))
    # Below its vertex a paraboloid has no points, and GDML takes no radius of a negative number
    low = max(low, -piece.g0 / slope)
    radii = [_root(piece.g0 + slope * z) for z in (low, high)]
    text = (
        f' rlo="{format_number(radii[0])}" rhi="{format_number(radii[1])}" '
        f'dz="{format_number((high - low) / 2)}" lunit="{LENGTH_UNIT}"'
    )
    middle = RigidMove(shift=(Fraction(0), Fraction(0), (low + high) / 2))
    return SolidReference(solids.add("paraboloid", text), join_moves([middle], [] if is_up else [RigidMove(_DOWN)]))


def _hype(solids: SolidWriter, piece: QuadricPiece) -> SolidReference:
    """Write a hyperboloid, symmetric about its waist in GDML: it reaches as far as the farther end."""
    middle = -piece.g1 / (2 * piece.g2)
    radius = _root(piece.g0 - piece.g2 * middle * middle)
    half = max(abs(Fraction(z) - middle) for z in (piece.low, piece.high))
    angle, is_exact = _angle(piece.g2)
    text = (
        f' rmin="0" rmax="{format_number(radius)}" inst="0" outst="{format_number(angle)}" '
        f'z="{format_number(2 * half)}"'
    )
    shift = join_moves([RigidMove(shift=(Fraction(0), Fraction(0), middle))])
    return SolidReference(solids.add("hype", f'{text} aunit="deg" lunit="{LENGTH_UNIT}"'), shift, not is_exact)


def _angle(bend: Fraction) -> tuple[float, bool]:
    """Return an angle in degrees whose squared tangent is `bend` as a float, and whether such an angle was found.

    Raise UnsupportedExport above `_STEEPEST`.
    """
    about = math.degrees(math.atan(math.sqrt(bend)))
    if about > _STEEPEST:
        raise UnsupportedExport("a hyperboloid of it is nearly flat, and GDML has it by an angle near 90 degrees")
    angle = about
    # Among floats near the angle one often has the exact slope when it is read back
    for _ in range(_NEAR):
        angle = math.nextafter(angle, 0.0)
    for _ in range(2 * _NEAR + 1):
        s, c = sin_cos_degrees(angle)
        if float((Fraction(s) / Fraction(c)) ** 2) == float(bend):
            return angle, True
        angle = math.nextafter(angle, math.inf)
    return about, False


def _root(value: Fraction) -> Fraction:
    """Return the square root to more digits than are written; 0 for numbers below 0."""
    return ex.fraction(ex.cancelling_sum((ex.sqrt(max(value, Fraction(0))),)))


# Closed faces: GDML has triangles and quadrangles.

MAX_FACETS = 20_000
"""Most facets of a solid."""


@lru_cache(256)
def is_read_identically(piece: PolyhedronPiece) -> bool:
    """Return True if readers get the planes of the piece from its corners, or its faces if it has no planes.

    Raise UnsupportedExport for planes that no shape takes: readers would refuse the file.
    """
    corners = [_read_back(corner) for corner in piece.corners]
    planes = convex_planes(corners, piece.faces)
    if planes is None or piece.planes is None:
        return planes is None and piece.planes is None and all(len(face) <= 4 for face in piece.faces)
    try:
        solid = polyhedron_factory(planes)(ORIGIN)
    except ValueError as error:
        raise UnsupportedExport(f"its faces would be refused when they are read: {error}") from None
    assert isinstance(solid, Polyhedron)
    own_planes = {_scale_plane(*plane) for plane in piece.planes}
    return all(_scale_plane(*plane) in own_planes for plane in zip(solid.normals, solid.offsets, strict=True))


def _read_back(corner: PieceCorner) -> PieceCorner:
    """Return a corner as a reader gets it from the text."""
    x, y, z = (evaluate(format_expression(value), {}) for value in corner)
    return x, y, z


def _scale_plane(normal: VectorLike, offset: float) -> tuple[float, ...]:
    """Scale a plane by a power of two, which changes no rounding, so that the largest component is in [1/2, 1)."""
    x, y, z = normal
    _, exponent = math.frexp(max(abs(x), abs(y), abs(z)))
    return tuple(math.ldexp(value, -exponent) for value in (x, y, z, offset))


def facet_rows(piece: PolyhedronPiece) -> list[list[PieceCorner]]:
    """Return the corners of each face; faces of more than four corners are cut into triangles.

    Raise UnsupportedExport for more than `MAX_FACETS`.
    """
    rows: list[list[PieceCorner]] = []
    for face in piece.faces:
        corners = [piece.corners[k] for k in face]
        rows += [corners] if len(corners) <= 4 else _triangles(corners)
    if len(rows) > MAX_FACETS:
        raise UnsupportedExport(f"it has {len(rows):,} faces, more than {MAX_FACETS:,}")
    return rows


def _triangles(corners: list[PieceCorner]) -> list[list[PieceCorner]]:
    """Cut a polygon into triangles by ear clipping (Meisters 1975), in its widest projection along an axis.

    Raise UnsupportedExport if no ear is left, as in polygons that cross themselves.
    """
    normal = _newell_normal(corners)
    across = max(range(3), key=lambda i: abs(normal[i]))
    u, v = ((across + 1) % 3, (across + 2) % 3) if normal[across] > 0 else ((across + 2) % 3, (across + 1) % 3)
    left, triangles = list(corners), []
    while len(left) > 3:
        for k in range(len(left)):
            a, b, c = left[k - 1], left[k], left[(k + 1) % len(left)]
            if _turn_sign(a, b, c, u, v) > 0 and not any(
                _contains_point(p, a, b, c, u, v) for p in left if p not in (a, b, c)
            ):
                triangles.append([a, b, c])
                del left[k]
                break
        else:
            raise UnsupportedExport("a face of it is no simple polygon")
    return [*triangles, left]


def _newell_normal(corners: list[PieceCorner]) -> PieceCorner:
    """Return the normal of a polygon by Newell's method, of length twice the area."""
    total = [Fraction(0)] * 3
    for a, b in zip(corners, [*corners[1:], corners[0]], strict=True):
        for i in range(3):
            j, k = (i + 1) % 3, (i + 2) % 3
            total[i] += (a[j] - b[j]) * (a[k] + b[k])
    return total[0], total[1], total[2]


def _turn_sign(a: PieceCorner, b: PieceCorner, c: PieceCorner, u: int, v: int) -> Fraction:
    """Return twice the signed area of a triangle in the projection to axes u, v: above 0 counter-clockwise."""
    return (b[u] - a[u]) * (c[v] - a[v]) - (b[v] - a[v]) * (c[u] - a[u])


def _contains_point(p: PieceCorner, a: PieceCorner, b: PieceCorner, c: PieceCorner, u: int, v: int) -> bool:
    return _turn_sign(a, b, p, u, v) >= 0 and _turn_sign(b, c, p, u, v) >= 0 and _turn_sign(c, a, p, u, v) >= 0


# Revolutions about z: tubes and cones where possible, else a genericPolycone.


def write_revolution(solids: SolidWriter, piece: RevolutionPiece) -> SolidReference:
    """Write a solid of revolution; tubes and cones have their origin in the middle, and a shift takes them there."""
    angles, rounded = _angle_attributes(piece)
    corners = [(shortest_decimal(r), shortest_decimal(z)) for r, z in piece.profile]
    if len(corners) == 4:
        (a, low), (b, second), (d, high), (c, last) = corners
        if low == second < high == last and 0 <= a < b and c <= d and (c < d or a < b):
            size, middle = format_number(high - low), (low + high) / 2
            if (a, b) == (c, d):
                text, tag = f' rmin="{format_number(a)}" rmax="{format_number(b)}"', "tube"
            else:
                text = (
                    f' rmin1="{format_number(a)}" rmax1="{format_number(b)}" '
                    f'rmin2="{format_number(c)}" rmax2="{format_number(d)}"'
                )
                tag = "cone"
            name = solids.add(tag, f'{text} z="{size}"{angles} lunit="{LENGTH_UNIT}"')
            return SolidReference(name, join_moves([RigidMove(shift=(Fraction(0), Fraction(0), middle))]), rounded)
    points = "".join(f'<rzpoint r="{format_number(r)}" z="{format_number(z)}"/>' for r, z in corners)
    return SolidReference(solids.add("genericPolycone", f'{angles} lunit="{LENGTH_UNIT}"', points), (), rounded)


def _angle_attributes(piece: RevolutionPiece) -> tuple[str, bool]:
    """Return the angle attributes, and whether readers get another end angle from start and width."""
    if piece.end - piece.start == 360:
        return ' startphi="0" deltaphi="360" aunit="deg"', False
    start, end = shortest_decimal(piece.start), shortest_decimal(piece.end)
    width = end - start
    widths = [width, Fraction(piece.end) - Fraction(piece.start), Fraction(piece.end - piece.start)]
    fits = [each for each in widths if float(Fraction(piece.start) + Fraction(float(each))) == piece.end]
    return (
        f' startphi="{format_number(start)}" deltaphi="{format_number(fits[0] if fits else width)}" aunit="deg"',
        not fits,
    )


# Solids that were imported from an element of GDML which has no piece of its own.


def source_piece(solid: Solid) -> PieceLeaf | None:
    """Return the element of GDML that an importer made a solid of; None for other solids."""
    source = solid._source
    if isinstance(source, SidedBall):
        return _ring_stack(source)
    if not isinstance(source, SourceElement):
        return None
    parts = "".join(f"<{part.tag}{_source_attributes(part)}/>" for part in source.parts)
    return PieceLeaf(NativePiece(source.tag, _source_attributes(source), parts, source.shift))


def _ring_stack(ball: SidedBall) -> PieceLeaf:
    """Return a ball of flat sides as polyhedra: rounded corners have no plane where four sides meet."""
    count, (_, flat) = (ball.sides + 1) // 2, sin_cos_degrees(180.0 / ball.sides)
    planes = ""
    for ring in range(count - 1, -1, -1):
        s, c = sin_cos_degrees(180.0 * (ring + 0.5) / count)
        z, inner = format_number(ball.radius * c), format_number(ball.radius * s * flat)
        planes += f'<zplane z="{z}" rmin="0" rmax="{inner}"/>'
    attributes = f' startphi="0" deltaphi="360" numsides="{ball.sides}" aunit="deg" lunit="{LENGTH_UNIT}"'
    return PieceLeaf(NativePiece("polyhedra", attributes, planes), (), True)


def _source_attributes(source: SourceElement) -> str:
    """Return the attributes of an element as text, numbers as expressions."""
    texts = ((name, value if isinstance(value, str) else format_expression(value)) for name, value in source.values)
    return "".join(f' {name}="{text}"' for name, text in texts)


# The writer of all solids.

_KINDS = {"union": "union", "intersection": "intersection", "difference": "subtraction"}


@dataclass(frozen=True)
class SolidReference:
    """The name of a written solid, and the moves that take it to its place."""

    name: str
    moves: GdmlMoves = ()
    is_rounded: bool = False


@dataclass
class SolidWriter:
    """The elements of <solids> and the positions of <define>, by text and by corner, each once."""

    names: dict[str, str] = field(default_factory=dict)
    elements: list[str] = field(default_factory=list)
    positions: dict[Point, str] = field(default_factory=dict)
    has_computed_planes: bool = False
    """True once a solid was written whose planes readers compute from its corners with other numbers than its own."""

    def write(self, node: PieceNode) -> SolidReference:
        """Write a node and return its reference. Raise UnsupportedExport."""
        if isinstance(node, PieceLeaf):
            solid = self._piece(node.piece)
            moves, rounded = convert_steps(node.steps)
            return SolidReference(
                solid.name, join_moves(solid.moves, moves), solid.is_rounded or node.is_rounded or rounded
            )
        return self._boolean(node)

    def add(self, tag: str, attributes: str, children: str = "") -> str:
        """Return the name of an element; it is added unless an equal one exists."""
        text = f"{attributes}>{children}</{tag}>" if children else f"{attributes}/>"
        key = f"{tag} {text}"
        if key not in self.names:
            self.names[key] = name = f"{tag}{len(self.names) + 1}"
            self.elements.append(f'<{tag} name="{name}"{text}')
        return self.names[key]

    def position(self, point: Point) -> str:
        """Return the name of a corner in <define>; it is added unless it exists."""
        if point not in self.positions:
            self.positions[point] = f"corner{len(self.positions) + 1}"
        return self.positions[point]

    def _boolean(self, node: PieceBoolean) -> SolidReference:
        """Write a Boolean as a chain of Booleans of two; the common last moves of all operands move the whole."""
        parts = [self.write(part) for part in node.parts]
        outer = _common_moves([part.moves for part in parts])
        parts = [
            SolidReference(part.name, part.moves[: len(part.moves) - len(outer)], part.is_rounded) for part in parts
        ]
        moves, rounded = convert_steps(node.steps)
        whole = join_moves(outer, moves)
        is_rounded = rounded or any(part.is_rounded for part in parts)
        first = parts[0]
        if len(parts) == 1:
            return SolidReference(first.name, join_moves(first.moves, whole), is_rounded)
        name, place = self._write_operand(first)
        for part in parts[1:]:
            second, there = self._write_operand(part)
            children = (
                f'<first ref="{name}"/><second '
                f'ref="{second}"/>{_operand_elements(there)}{_operand_elements(place, "first")}'
            )
            name, place = self.add(_KINDS[node.kind], "", children), ExportPlacement()
        return SolidReference(name, whole, is_rounded)

    def _write_operand(self, reference: SolidReference) -> tuple[str, ExportPlacement]:
        """Write a solid with its first moves, and return its name and the last ones as rotation and position."""
        rest, place = split_last_placement(reference.moves, False)
        return self.move(reference.name, rest), place

    def move(self, name: str, moves: GdmlMoves) -> str:
        """Write a moved solid as a solid, and return its name."""
        while moves:
            written = self._apply_first(name, moves)
            name, moves = written
        return name

    def _apply_first(self, name: str, moves: GdmlMoves) -> tuple[str, GdmlMoves]:
        """Write a solid with the first moves carried out; return its name and the remaining moves.

        GDML has no moved solid: a multiUnion of one node moves it, a scaledSolid stretches or mirrors it.
        """
        first: GdmlMove = moves[0]
        if isinstance(first, AxisStretch):
            return self._scaled(name, first.factors), moves[1:]
        mirror = mirror_signs(first) if isinstance(first, RigidMove) else None
        if mirror is not None:
            return self._scaled(name, mirror), moves[1:]
        # As many moves at once as one rotation and shift can express.
        for count in range(len(moves), 0, -1):
            rest, place = split_last_placement(moves[:count], False)
            if not rest:
                node = f'<multiUnionNode name="node"><solid ref="{name}"/>{_operand_elements(place)}</multiUnionNode>'
                return self.add("multiUnion", "", node), moves[count:]
        rest, place = split_last_placement(moves[:1], False)  # a mirror, and the rotation after it
        return self.move(name, rest), join_moves(place.moves, moves[1:])

    def _scaled(self, name: str, factors: Sequence[float]) -> str:
        x, y, z = map(format_number, factors)
        return self.add("scaledSolid", "", f'<solidref ref="{name}"/><scale x="{x}" y="{y}" z="{z}"/>')

    def _piece(self, piece: Piece) -> SolidReference:
        """Write one piece and return its reference."""
        if isinstance(piece, BallPiece):
            return SolidReference(self.add("orb", f' r="{format_number(piece.radius)}" lunit="{LENGTH_UNIT}"'))
        if isinstance(piece, EllipsoidPiece):
            a, b, c = map(format_number, piece.radii)
            return SolidReference(self.add("ellipsoid", f' ax="{a}" by="{b}" cz="{c}" lunit="{LENGTH_UNIT}"'))
        if isinstance(piece, BoxPiece):
            return self._cuboid(piece)
        if isinstance(piece, FrustumPiece):
            ends = ((0.0, piece.low), (piece.first, piece.low), (piece.second, piece.high), (0.0, piece.high))
            return write_revolution(self, RevolutionPiece(ends))
        if isinstance(piece, RevolutionPiece):
            return write_revolution(self, piece)
        if isinstance(piece, ExtrusionPiece):
            return self._extrusion(piece)
        if isinstance(piece, QuadricPiece):
            return _hype(self, piece) if piece.g2 else _paraboloid(self, piece)
        if isinstance(piece, NativePiece):
            return SolidReference(
                self.add(piece.tag, piece.attributes, piece.children), join_moves([RigidMove(shift=piece.shift)])
            )
        return self._faces(piece)

    def _cuboid(self, piece: BoxPiece) -> SolidReference:
        lows, highs = [list(map(shortest_decimal, end)) for end in (piece.low, piece.high)]
        x, y, z = (format_number(b - a) for a, b in zip(lows, highs, strict=True))
        a, b, c = ((low + high) / 2 for low, high in zip(lows, highs, strict=True))
        return SolidReference(
            self.add("box", f' x="{x}" y="{y}" z="{z}" lunit="{LENGTH_UNIT}"'), join_moves([RigidMove(shift=(a, b, c))])
        )

    def _extrusion(self, piece: ExtrusionPiece) -> SolidReference:
        corners = "".join(f'<twoDimVertex x="{format_number(x)}" y="{format_number(y)}"/>' for x, y in piece.outline)
        scales = zip((piece.low, piece.high), (1.0, piece.scale), strict=True)
        ends = "".join(
            f'<section zOrder="{k}" zPosition="{format_number(z)}" xOffset="0" '
            f'yOffset="0" scalingFactor="{format_number(scale)}"/>'
            for k, (z, scale) in enumerate(scales)
        )
        products = [
            (Fraction(piece.scale) * Fraction(v), shortest_decimal(piece.scale) * shortest_decimal(v))
            for p in piece.outline
            for v in p
        ]
        # Readers multiply decimals; the scene multiplies the floats.
        rounded = piece.scale != 1 and any(Fraction(float(decimal)) != exact for exact, decimal in products)
        return SolidReference(self.add("xtru", f' lunit="{LENGTH_UNIT}"', corners + ends), (), rounded)

    def _faces(self, piece: PolyhedronPiece) -> SolidReference:
        rows = facet_rows(piece)
        self.has_computed_planes = self.has_computed_planes or not is_read_identically(piece)
        text = ""
        for row in rows:
            kind = "triangular" if len(row) == 3 else "quadrangular"
            corners = " ".join(f'vertex{k + 1}="{self.position(corner)}"' for k, corner in enumerate(row))
            text += f'<{kind} {corners} type="ABSOLUTE"/>'
        return SolidReference(self.add("tessellated", f' aunit="deg" lunit="{LENGTH_UNIT}"', text))


def _common_moves(all_moves: Sequence[GdmlMoves]) -> GdmlMoves:
    """Return the longest common end of all moves."""
    count = 0
    shortest = min(map(len, all_moves))
    while count < shortest and len({moves[-1 - count] for moves in all_moves}) == 1:
        count += 1
    return all_moves[0][len(all_moves[0]) - count :] if count else ()


def _operand_elements(place: ExportPlacement, prefix: str = "") -> str:
    """Return the position and rotation elements of an operand."""
    return position_element(place.shift, f"{prefix}position") + rotation_element(place.angles, f"{prefix}rotation")


def position_element(shift: Point, tag: str = "position") -> str:
    """Return the element of a shift in `LENGTH_UNIT`, or "" for no shift."""
    return _vector_element(tag, shift, LENGTH_UNIT)


def rotation_element(angles: Point, tag: str = "rotation") -> str:
    """Return the element of a rotation by angles in degrees, or "" for no rotation."""
    return _vector_element(tag, angles, "deg")


def _vector_element(tag: str, vector: Point, unit: str) -> str:
    if vector == ORIGIN:
        return ""
    x, y, z = map(format_number, vector)
    return f'<{tag} x="{x}" y="{y}" z="{z}" unit="{unit}"/>'
