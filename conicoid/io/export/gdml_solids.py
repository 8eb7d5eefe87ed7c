"""Paraboloids and hyperboloids of revolution, by the radii and angles that GDML has them by."""

from __future__ import annotations

import math
from collections.abc import Sequence
from dataclasses import dataclass, field
from fractions import Fraction
from functools import lru_cache

from ..._util.arrays import VectorLike
from ...geometry.polyhedron import Polyhedron
from ...numerics import bigfloat_linalg as ex
from ...numerics.portable_math import sin_cos_degrees
from ..gdml.expressions import evaluate
from ..gdml.flat_solids import convex_planes, polyhedron_factory
from ..openmc.placement import ORIGIN, AxisTurn, Point
from .exporters import ExportUnsupported, format_expression, format_number, shortest_decimal
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

_NEAR = 12
"""Floats on either side of an angle that are tried for the very slope."""
_STEEPEST = 89.999
_DOWN = AxisTurn(signs=(1, -1, -1))


def write_bowl(solids: SolidWriter, piece: QuadricPiece) -> SolidReference:
    """A paraboloid or a hype."""
    return _hype(solids, piece) if piece.g2 else _paraboloid(solids, piece)


def _paraboloid(solids: SolidWriter, piece: QuadricPiece) -> SolidReference:

    is_up = piece.g1 > 0
    slope = abs(piece.g1)
    low, high = (Fraction(piece.low), Fraction(piece.high)) if is_up else (-Fraction(piece.high), -Fraction(piece.low))
    low = max(low, -piece.g0 / slope)
    radii = [_root(piece.g0 + slope * z) for z in (low, high)]
    text = (
        f' rlo="{format_number(radii[0])}" rhi="{format_number(radii[1])}" '
        f'dz="{format_number((high - low) / 2)}" lunit="mm"'
    )
    middle = RigidMove(shift=(Fraction(0), Fraction(0), (low + high) / 2))
    return SolidReference(solids.add("paraboloid", text), join_moves([middle], [] if is_up else [RigidMove(_DOWN)]))


def _hype(solids: SolidWriter, piece: QuadricPiece) -> SolidReference:

    middle = -piece.g1 / (2 * piece.g2)
    radius = _root(piece.g0 - piece.g2 * middle * middle)
    half = max(abs(Fraction(z) - middle) for z in (piece.low, piece.high))
    angle, is_exact = _angle(piece.g2)
    text = (
        f' rmin="0" rmax="{format_number(radius)}" inst="0" outst="{format_number(angle)}" '
        f'z="{format_number(2 * half)}"'
    )
    shift = join_moves([RigidMove(shift=(Fraction(0), Fraction(0), middle))])
    return SolidReference(solids.add("hype", f'{text} aunit="deg" lunit="mm"'), shift, not is_exact)


def _angle(bend: Fraction) -> tuple[float, bool]:
    """The angle in degrees whose tangent squared is read as a float, and whether there is one."""
    about = math.degrees(math.atan(math.sqrt(bend)))
    if about > _STEEPEST:
        raise ExportUnsupported("a hyperboloid of it is nearly flat, and GDML has it by an angle near 90 degrees")
    tried = about
    for _ in range(_NEAR):
        tried = math.nextafter(tried, 0.0)
    for _ in range(2 * _NEAR + 1):
        s, c = sin_cos_degrees(tried)
        if float((Fraction(s) / Fraction(c)) ** 2) == float(bend):
            return tried, True
        tried = math.nextafter(tried, math.inf)
    return about, False


def _root(value: Fraction) -> Fraction:
    """The square root, to more digits than are written."""
    return ex.fraction(ex.cancelling_sum((ex.sqrt(max(value, Fraction(0))),)))


# Faces as triangles and quadrangles, which is what GDML has.

MAX_FACETS = 20_000


@lru_cache(256)
def is_read_identically(piece: PolyhedronPiece) -> bool:
    """Do readers get the planes that it had, or the faces, if it had none?"""
    corners = [_read_back(corner) for corner in piece.corners]
    planes = convex_planes(corners, piece.faces)
    if planes is None or piece.planes is None:
        return planes is None and piece.planes is None and all(len(face) <= 4 for face in piece.faces)
    found = polyhedron_factory(planes)(ORIGIN)
    assert isinstance(found, Polyhedron)
    known = {_scale_plane(*plane) for plane in piece.planes}
    return all(_scale_plane(*plane) in known for plane in zip(found.normals, found.offsets, strict=True))


def _read_back(corner: PieceCorner) -> PieceCorner:
    x, y, z = (evaluate(format_expression(value), {}) for value in corner)
    return x, y, z


def _scale_plane(normal: VectorLike, offset: float) -> tuple[float, ...]:
    """By a power of two, which no rounding depends on."""
    x, y, z = normal
    _, exponent = math.frexp(max(abs(x), abs(y), abs(z)))
    return tuple(math.ldexp(value, -exponent) for value in (x, y, z, offset))


def facet_rows(piece: PolyhedronPiece) -> list[list[PieceCorner]]:
    """Each face, those of more than four corners cut into triangles."""
    rows: list[list[PieceCorner]] = []
    for face in piece.faces:
        corners = [piece.corners[k] for k in face]
        rows += [corners] if len(corners) <= 4 else _triangles(corners)
    if len(rows) > MAX_FACETS:
        raise ExportUnsupported(f"it has {len(rows):,} faces, more than {MAX_FACETS:,}")
    return rows


def _triangles(corners: list[PieceCorner]) -> list[list[PieceCorner]]:
    """A polygon without its ears, one after the other (Meisters 1975), by its projection where that is widest."""
    normal = _newell_normal(corners)
    across = max(range(3), key=lambda i: abs(normal[i]))
    u, v = ((across + 1) % 3, (across + 2) % 3) if normal[across] > 0 else ((across + 2) % 3, (across + 1) % 3)
    left, found = list(corners), []
    while len(left) > 3:
        for k in range(len(left)):
            a, b, c = left[k - 1], left[k], left[(k + 1) % len(left)]
            if _turn_sign(a, b, c, u, v) > 0 and not any(
                _contains_point(p, a, b, c, u, v) for p in left if p not in (a, b, c)
            ):
                found.append([a, b, c])
                del left[k]
                break
        else:
            raise ExportUnsupported("a face of it is no simple polygon")
    return [*found, left]


def _newell_normal(corners: list[PieceCorner]) -> PieceCorner:
    """By Newell."""
    total = [Fraction(0)] * 3
    for a, b in zip(corners, [*corners[1:], corners[0]], strict=True):
        for i in range(3):
            j, k = (i + 1) % 3, (i + 2) % 3
            total[i] += (a[j] - b[j]) * (a[k] + b[k])
    return total[0], total[1], total[2]


def _turn_sign(a: PieceCorner, b: PieceCorner, c: PieceCorner, u: int, v: int) -> Fraction:
    return (b[u] - a[u]) * (c[v] - a[v]) - (b[v] - a[v]) * (c[u] - a[u])


def _contains_point(p: PieceCorner, a: PieceCorner, b: PieceCorner, c: PieceCorner, u: int, v: int) -> bool:
    return _turn_sign(a, b, p, u, v) >= 0 and _turn_sign(b, c, p, u, v) >= 0 and _turn_sign(c, a, p, u, v) >= 0


# What is turned about z: tubes and cones where they are some, else a genericPolycone.


def write_revolution(solids: SolidWriter, piece: RevolutionPiece) -> SolidReference:
    """The solid, and where its middle is."""
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
            name = solids.add(tag, f'{text} z="{size}"{angles} lunit="mm"')
            return SolidReference(name, join_moves([RigidMove(shift=(Fraction(0), Fraction(0), middle))]), rounded)
    points = "".join(f'<rzpoint r="{format_number(r)}" z="{format_number(z)}"/>' for r, z in corners)
    return SolidReference(solids.add("genericPolycone", f'{angles} lunit="mm"', points), (), rounded)


def _angle_attributes(piece: RevolutionPiece) -> tuple[str, bool]:
    """Attributes, and whether readers get another end from start and width."""
    if piece.end - piece.start == 360:
        return ' startphi="0" deltaphi="360" aunit="deg"', False
    start, end = shortest_decimal(piece.start), shortest_decimal(piece.end)
    width = end - start
    tried = [width, Fraction(piece.end) - Fraction(piece.start), Fraction(piece.end - piece.start)]
    fits = [each for each in tried if float(Fraction(piece.start) + Fraction(float(each))) == piece.end]
    return (
        f' startphi="{format_number(start)}" deltaphi="{format_number(fits[0] if fits else width)}" aunit="deg"',
        not fits,
    )


# Pieces as GDML's solids, each once: boxes, tubes, cones, orbs and the rest, Booleans of them, moved and scaled.

_KINDS = {"union": "union", "intersection": "intersection", "difference": "subtraction"}


@dataclass(frozen=True)
class SolidReference:
    """A solid by its name, and what moves it to where it is."""

    name: str
    moves: GdmlMoves = ()
    is_rounded: bool = False


@dataclass
class SolidWriter:
    """The elements of <solids> and <define>, with what they are called."""

    names: dict[str, str] = field(default_factory=dict)
    elements: list[str] = field(default_factory=list)
    positions: dict[Point, str] = field(default_factory=dict)
    is_worked_out: bool = False
    """Has a solid been said whose planes readers get from its corners, and not as the very numbers that it has?"""

    def said(self, node: PieceNode) -> SolidReference:
        """A node. Raises Unsayable."""
        if isinstance(node, PieceLeaf):
            made = self._piece(node.piece)
            moves, rounded = convert_steps(node.steps)
            return SolidReference(
                made.name, join_moves(made.moves, moves), made.is_rounded or node.is_rounded or rounded
            )
        return self._combined(node)

    def add(self, tag: str, attributes: str, children: str = "") -> str:
        """The name of an element, which is made if there is none like it."""
        text = f"{attributes}>{children}</{tag}>" if children else f"{attributes}/>"
        key = f"{tag} {text}"
        if key not in self.names:
            self.names[key] = name = f"{tag}{len(self.names) + 1}"
            self.elements.append(f'<{tag} name="{name}"{text}')
        return self.names[key]

    def position(self, point: Point) -> str:
        """The name of a corner."""
        if point not in self.positions:
            self.positions[point] = f"corner{len(self.positions) + 1}"
        return self.positions[point]

    def _combined(self, node: PieceBoolean) -> SolidReference:
        """A chain of Booleans of two; what all operands have of moves at their ends is taken out."""
        parts = [self.said(part) for part in node.parts]
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
        name, place = self._ready(first)
        for part in parts[1:]:
            second, there = self._ready(part)
            children = (
                f'<first ref="{name}"/><second '
                f'ref="{second}"/>{_operand_elements(there)}{_operand_elements(place, "first")}'
            )
            name, place = self.add(_KINDS[node.kind], "", children), ExportPlacement()
        return SolidReference(name, whole, is_rounded)

    def _ready(self, said: SolidReference) -> tuple[str, ExportPlacement]:
        """A solid with all its moves but the last, and that as rotation and position."""
        rest, place = split_last_placement(said.moves, False)
        return self.wrapped(said.name, rest), place

    def wrapped(self, name: str, moves: GdmlMoves) -> str:
        """A solid that is moved, as a solid."""
        while moves:
            done = self._first(name, moves)
            name, moves = done
        return name

    def _first(self, name: str, moves: GdmlMoves) -> tuple[str, GdmlMoves]:
        """With the first of the moves carried out."""
        first: GdmlMove = moves[0]
        if isinstance(first, AxisStretch):
            return self._scaled(name, first.factors), moves[1:]
        mirror = mirror_signs(first) if isinstance(first, RigidMove) else None
        if mirror is not None:
            return self._scaled(name, mirror), moves[1:]
        for count in range(len(moves), 0, -1):
            rest, place = split_last_placement(moves[:count], False)
            if not rest:
                node = f'<multiUnionNode name="node"><solid ref="{name}"/>{_operand_elements(place)}</multiUnionNode>'
                return self.add("multiUnion", "", node), moves[count:]
        rest, place = split_last_placement(moves[:1], False)  # a mirror, and what comes after it
        return self.wrapped(name, rest), join_moves(place.moves, moves[1:])

    def _scaled(self, name: str, factors: Sequence[float]) -> str:
        x, y, z = map(format_number, factors)
        return self.add("scaledSolid", "", f'<solidref ref="{name}"/><scale x="{x}" y="{y}" z="{z}"/>')

    def _piece(self, piece: Piece) -> SolidReference:
        if isinstance(piece, BallPiece):
            return SolidReference(self.add("orb", f' r="{format_number(piece.radius)}" lunit="mm"'))
        if isinstance(piece, EllipsoidPiece):
            a, b, c = map(format_number, piece.radii)
            return SolidReference(self.add("ellipsoid", f' ax="{a}" by="{b}" cz="{c}" lunit="mm"'))
        if isinstance(piece, BoxPiece):
            return self._cuboid(piece)
        if isinstance(piece, FrustumPiece):
            ends = ((0.0, piece.low), (piece.first, piece.low), (piece.second, piece.high), (0.0, piece.high))
            return write_revolution(self, RevolutionPiece(ends))
        if isinstance(piece, RevolutionPiece):
            return write_revolution(self, piece)
        if isinstance(piece, ExtrusionPiece):
            return self._drawn(piece)
        if isinstance(piece, QuadricPiece):
            return write_bowl(self, piece)
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
            self.add("box", f' x="{x}" y="{y}" z="{z}" lunit="mm"'), join_moves([RigidMove(shift=(a, b, c))])
        )

    def _drawn(self, piece: ExtrusionPiece) -> SolidReference:
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
        rounded = piece.scale != 1 and any(Fraction(float(said)) != exact for exact, said in products)
        return SolidReference(self.add("xtru", ' lunit="mm"', corners + ends), (), rounded)

    def _faces(self, piece: PolyhedronPiece) -> SolidReference:
        rows = facet_rows(piece)
        self.is_worked_out = self.is_worked_out or not is_read_identically(piece)
        text = ""
        for row in rows:
            kind = "triangular" if len(row) == 3 else "quadrangular"
            corners = " ".join(f'vertex{k + 1}="{self.position(corner)}"' for k, corner in enumerate(row))
            text += f'<{kind} {corners} type="ABSOLUTE"/>'
        return SolidReference(self.add("tessellated", ' aunit="deg" lunit="mm"', text))


def _common_moves(all_moves: Sequence[GdmlMoves]) -> GdmlMoves:
    """The moves that all end with, from the first that is no plain shift."""
    count = 0
    shortest = min(map(len, all_moves))
    while count < shortest and len({moves[-1 - count] for moves in all_moves}) == 1:
        count += 1
    return all_moves[0][len(all_moves[0]) - count :] if count else ()


def _operand_elements(place: ExportPlacement, prefix: str = "") -> str:
    """Position and rotation elements of an operand."""
    return position_element(place.shift, f"{prefix}position") + rotation_element(place.angles, f"{prefix}rotation")


def position_element(shift: Point, tag: str = "position") -> str:
    """An element; nothing for none."""
    if shift == ORIGIN:
        return ""
    x, y, z = map(format_number, shift)
    return f'<{tag} x="{x}" y="{y}" z="{z}" unit="mm"/>'


def rotation_element(angles: Point, tag: str = "rotation") -> str:
    """An element; nothing for none."""
    if angles == ORIGIN:
        return ""
    x, y, z = map(format_number, angles)
    return f'<{tag} x="{x}" y="{y}" z="{z}" unit="deg"/>'
