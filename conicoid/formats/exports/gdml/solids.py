"""Pieces as GDML's solids, each once: boxes, tubes, cones, orbs and the rest, Booleans of them, moved and scaled."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass, field
from fractions import Fraction

from ...gdml.placement import ORIGIN, Point
from ..numbers import decimal, word
from ..pieces import Ball, Bowl, Combined, Cuboid, Drawn, Egg, Faces, Frustum, Leaf, Native, Node, Piece, Turned
from . import bowls, facets, turned
from .moves import Move, Moves, Place, Set, Stretch, joined, last_place, mirror_of, moves_of

_KINDS = {"union": "union", "intersection": "intersection", "difference": "subtraction"}


@dataclass(frozen=True)
class Said:
    """A solid by its name, and what moves it to where it is."""

    name: str
    moves: Moves = ()
    is_rounded: bool = False


@dataclass
class Solids:
    """The elements of <solids> and <define>, with what they are called."""

    names: dict[str, str] = field(default_factory=dict)
    elements: list[str] = field(default_factory=list)
    positions: dict[Point, str] = field(default_factory=dict)
    is_worked_out: bool = False
    """Has a solid been said whose planes readers get from its corners, and not as the very numbers that it has?"""

    def said(self, node: Node) -> Said:
        """A node. Raises Unsayable."""
        if isinstance(node, Leaf):
            made = self._piece(node.piece)
            moves, rounded = moves_of(node.steps)
            return Said(made.name, joined(made.moves, moves), made.is_rounded or node.is_rounded or rounded)
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

    def _combined(self, node: Combined) -> Said:
        """A chain of Booleans of two; what all operands have of moves at their ends is taken out."""
        parts = [self.said(part) for part in node.parts]
        outer = _common_end([part.moves for part in parts])
        parts = [Said(part.name, part.moves[: len(part.moves) - len(outer)], part.is_rounded) for part in parts]
        moves, rounded = moves_of(node.steps)
        whole = joined(outer, moves)
        is_rounded = rounded or any(part.is_rounded for part in parts)
        first = parts[0]
        if len(parts) == 1:
            return Said(first.name, joined(first.moves, whole), is_rounded)
        name, place = self._ready(first)
        for part in parts[1:]:
            second, there = self._ready(part)
            children = f'<first ref="{name}"/><second ref="{second}"/>{_placed(there)}{_placed(place, "first")}'
            name, place = self.add(_KINDS[node.kind], "", children), Place()
        return Said(name, whole, is_rounded)

    def _ready(self, said: Said) -> tuple[str, Place]:
        """A solid with all its moves but the last, and that as rotation and position."""
        rest, place = last_place(said.moves, False)
        return self.wrapped(said.name, rest), place

    def wrapped(self, name: str, moves: Moves) -> str:
        """A solid that is moved, as a solid."""
        while moves:
            done = self._first(name, moves)
            name, moves = done
        return name

    def _first(self, name: str, moves: Moves) -> tuple[str, Moves]:
        """With the first of the moves carried out."""
        first: Move = moves[0]
        if isinstance(first, Stretch):
            return self._scaled(name, first.factors), moves[1:]
        mirror = mirror_of(first) if isinstance(first, Set) else None
        if mirror is not None:
            return self._scaled(name, mirror), moves[1:]
        for count in range(len(moves), 0, -1):
            rest, place = last_place(moves[:count], False)
            if not rest:
                node = f'<multiUnionNode name="node"><solid ref="{name}"/>{_placed(place)}</multiUnionNode>'
                return self.add("multiUnion", "", node), moves[count:]
        rest, place = last_place(moves[:1], False)  # a mirror, and what comes after it
        return self.wrapped(name, rest), joined(place.moves, moves[1:])

    def _scaled(self, name: str, factors: Sequence[float]) -> str:
        x, y, z = map(word, factors)
        return self.add("scaledSolid", "", f'<solidref ref="{name}"/><scale x="{x}" y="{y}" z="{z}"/>')

    def _piece(self, piece: Piece) -> Said:
        if isinstance(piece, Ball):
            return Said(self.add("orb", f' r="{word(piece.radius)}" lunit="mm"'))
        if isinstance(piece, Egg):
            a, b, c = map(word, piece.radii)
            return Said(self.add("ellipsoid", f' ax="{a}" by="{b}" cz="{c}" lunit="mm"'))
        if isinstance(piece, Cuboid):
            return self._cuboid(piece)
        if isinstance(piece, Frustum):
            ends = ((0.0, piece.low), (piece.first, piece.low), (piece.second, piece.high), (0.0, piece.high))
            return turned.said(self, Turned(ends))
        if isinstance(piece, Turned):
            return turned.said(self, piece)
        if isinstance(piece, Drawn):
            return self._drawn(piece)
        if isinstance(piece, Bowl):
            return bowls.said(self, piece)
        if isinstance(piece, Native):
            return Said(self.add(piece.tag, piece.attributes, piece.children), joined([Set(shift=piece.shift)]))
        return self._faces(piece)

    def _cuboid(self, piece: Cuboid) -> Said:
        lows, highs = [list(map(decimal, end)) for end in (piece.low, piece.high)]
        x, y, z = (word(b - a) for a, b in zip(lows, highs, strict=True))
        a, b, c = ((low + high) / 2 for low, high in zip(lows, highs, strict=True))
        return Said(self.add("box", f' x="{x}" y="{y}" z="{z}" lunit="mm"'), joined([Set(shift=(a, b, c))]))

    def _drawn(self, piece: Drawn) -> Said:
        corners = "".join(f'<twoDimVertex x="{word(x)}" y="{word(y)}"/>' for x, y in piece.outline)
        scales = zip((piece.low, piece.high), (1.0, piece.scale), strict=True)
        ends = "".join(
            f'<section zOrder="{k}" zPosition="{word(z)}" xOffset="0" yOffset="0" scalingFactor="{word(scale)}"/>'
            for k, (z, scale) in enumerate(scales)
        )
        products = [
            (Fraction(piece.scale) * Fraction(v), decimal(piece.scale) * decimal(v)) for p in piece.outline for v in p
        ]
        rounded = piece.scale != 1 and any(Fraction(float(said)) != exact for exact, said in products)
        return Said(self.add("xtru", ' lunit="mm"', corners + ends), (), rounded)

    def _faces(self, piece: Faces) -> Said:
        rows = facets.rows_of(piece)
        self.is_worked_out = self.is_worked_out or not facets.is_read_alike(piece)
        text = ""
        for row in rows:
            kind = "triangular" if len(row) == 3 else "quadrangular"
            corners = " ".join(f'vertex{k + 1}="{self.position(corner)}"' for k, corner in enumerate(row))
            text += f'<{kind} {corners} type="ABSOLUTE"/>'
        return Said(self.add("tessellated", ' aunit="deg" lunit="mm"', text))


def _common_end(all_moves: Sequence[Moves]) -> Moves:
    """The moves that all end with, from the first that is no plain shift."""
    count = 0
    shortest = min(map(len, all_moves))
    while count < shortest and len({moves[-1 - count] for moves in all_moves}) == 1:
        count += 1
    return all_moves[0][len(all_moves[0]) - count :] if count else ()


def _placed(place: Place, prefix: str = "") -> str:
    """Position and rotation elements of an operand."""
    return position(place.shift, f"{prefix}position") + rotation(place.angles, f"{prefix}rotation")


def position(shift: Point, tag: str = "position") -> str:
    """An element; nothing for none."""
    if shift == ORIGIN:
        return ""
    x, y, z = map(word, shift)
    return f'<{tag} x="{x}" y="{y}" z="{z}" unit="mm"/>'


def rotation(angles: Point, tag: str = "rotation") -> str:
    """An element; nothing for none."""
    if angles == ORIGIN:
        return ""
    x, y, z = map(word, angles)
    return f'<{tag} x="{x}" y="{y}" z="{z}" unit="deg"/>'
