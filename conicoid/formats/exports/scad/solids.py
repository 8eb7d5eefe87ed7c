"""Pieces as calls of OpenSCAD: sphere, cube, cylinder, polyhedron, extrusions, under multmatrix."""

from __future__ import annotations

from collections.abc import Iterator
from dataclasses import dataclass
from fractions import Fraction
from typing import Any

from ....shapes import exact as ex
from ....shapes.motion import Motion
from ....shapes.steps import Scale, Step, Translate
from ....shapes.validate import SMALLEST
from ..exported import Unsayable
from ..numbers import decimal, word
from ..pieces import Ball, Bowl, Cuboid, Drawn, Egg, Faces, Frustum, Leaf, Native, Node, Piece, Steps, Turned
from .stacks import ball_of_sides

_ROUND = "$fn = 0, $fa = 3, $fs = 0.01"
"""Circles are round for Conicoid, and have 120 sides in OpenSCAD."""


@dataclass(frozen=True)
class Call:
    """A call with its children."""

    text: str
    children: tuple[Call, ...] = ()

    def lines(self, depth: int = 0) -> Iterator[str]:
        """As a file has it."""
        margin = "\t" * depth
        if not self.children:
            yield f"{margin}{self.text};"
            return
        yield f"{margin}{self.text} {{"
        for child in self.children:
            yield from child.lines(depth + 1)
        yield f"{margin}}}"


@dataclass
class Writer:
    """Turns pieces into calls; `is_rounded` once a number of them is not the scene's."""

    is_rounded: bool = False

    def call(self, node: Node) -> Call:
        """A node under its steps."""
        if isinstance(node, Leaf):
            self.is_rounded = self.is_rounded or node.is_rounded
            made, before = self._piece(node.piece)
            return self._moved(self._moved(made, before), node.steps)
        stack = ball_of_sides(node)
        if stack is not None:
            radius, sides = stack
            return self._moved(Call(f"sphere($fn = {sides}, $fa = 3, $fs = 0.01, r = {word(radius)})"), node.steps)
        parts = tuple(self.call(part) for part in node.parts)
        whole = parts[0] if len(parts) == 1 else Call(f"{node.kind}()", parts)
        if node.color is not None:
            whole = Call(f"color({color(node.color)})", (whole,))
        return self._moved(whole, node.steps)

    def _moved(self, call: Call, steps: Steps) -> Call:
        for step in steps:
            call = Call(f"multmatrix({self._matrix(step)})", (call,))
        return call

    def _matrix(self, step: Step) -> str:
        linear, shift = Motion((step,)).affine
        rows = []
        for row, end in zip(linear, shift, strict=True):
            numbers = [_within_domain(ex.rounded(value)) for value in (*row, end)]
            for exact, near in zip((*row, end), numbers, strict=True):
                self.is_rounded = self.is_rounded or bool(ex.cancelling_sum((exact, -ex.exact(near))))
            rows.append(f"[{', '.join(map(word, numbers))}]")
        return f"[{', '.join(rows)}, [0, 0, 0, 1]]"

    def _piece(self, piece: Piece) -> tuple[Call, Steps]:
        """The call, and what moves it to where the piece is."""
        if isinstance(piece, Ball):
            return Call(f"sphere({_ROUND}, r = {word(piece.radius)})"), ()
        if isinstance(piece, Egg):
            return Call(f"sphere({_ROUND}, r = 1)"), (Scale(piece.radii),)
        if isinstance(piece, Cuboid):
            return self._cuboid(piece)
        if isinstance(piece, Frustum):
            return self._frustum(piece)
        if isinstance(piece, Turned):
            return self._turned(piece), ()
        if isinstance(piece, Drawn):
            return self._drawn(piece)
        if isinstance(piece, Bowl | Native):
            raise Unsayable("a paraboloid or hyperboloid of it is nothing that OpenSCAD has")
        return self._faces(piece), ()

    def _cuboid(self, piece: Cuboid) -> tuple[Call, Steps]:
        size = [b - a for a, b in zip(piece.low, piece.high, strict=True)]
        if all(a == -b for a, b in zip(piece.low, piece.high, strict=True)):
            return Call(f"cube(size = {_list(size)}, center = true)"), ()
        if not any(piece.low):
            return Call(f"cube(size = {_list(size)}, center = false)"), ()
        corners = []
        for k in range(8):
            corners.append(tuple(Fraction((piece.low, piece.high)[k >> i & 1][i]) for i in range(3)))
        faces = ((0, 4, 6, 2), (1, 3, 7, 5), (0, 1, 5, 4), (2, 6, 7, 3), (0, 2, 3, 1), (4, 5, 7, 6))
        return self._faces(Faces(tuple(corners), faces, True)), ()  # type: ignore[arg-type]

    def _frustum(self, piece: Frustum) -> tuple[Call, Steps]:
        height = _height(piece.low, piece.high)
        if height is None:
            r, low, s, high = piece.first, piece.low, piece.second, piece.high
            return self._turned(Turned(tuple(dict.fromkeys(((0.0, low), (r, low), (s, high), (0.0, high)))))), ()
        text = f"h = {word(height)}, r1 = {word(piece.first)}, r2 = {word(piece.second)}"
        return Call(f"cylinder({_ROUND}, {text}, center = {_center(piece.low)})"), ()

    def _turned(self, piece: Turned) -> Call:
        angle = piece.end - piece.start
        if decimal(piece.start) and piece.start + angle != piece.end:
            self.is_rounded = True
        text = f"angle = {word(angle)}, start = {word(piece.start)}, {_ROUND}"
        return Call(f"rotate_extrude({text})", (_polygon(piece.profile),))

    def _drawn(self, piece: Drawn) -> tuple[Call, Steps]:
        height = _height(piece.low, piece.high)
        steps: Steps = ()
        if height is None:
            size = Fraction(piece.high) - Fraction(piece.low)
            if Fraction(float(size)) != size:
                return self._faces(_ends(piece)), ()
            height, steps = float(size), (Translate((0.0, 0.0, piece.low)),)
        center = _center(0.0 if steps else piece.low)
        text = f"height = {word(height)}, center = {center}, scale = {word(piece.scale)}"
        return Call(f"linear_extrude({text}, {_ROUND})", (_polygon(piece.outline),)), steps

    def _faces(self, piece: Faces) -> Call:
        """OpenSCAD wants corners clockwise, as seen from outside."""
        points = []
        for corner in piece.corners:
            numbers = [float(value) for value in corner]
            self.is_rounded = self.is_rounded or any(
                Fraction(near) != value for near, value in zip(numbers, corner, strict=True)
            )
            points.append(_list(numbers))
        turned = piece.is_convex or _volume(piece) > 0
        faces = [f"[{', '.join(map(str, reversed(face) if turned else face))}]" for face in piece.faces]
        return Call(f"polyhedron(points = [{', '.join(points)}], faces = [{', '.join(faces)}], convexity = 10)")


def _within_domain(value: float) -> float:
    """Nothing for what is too small for a scene."""
    return value if abs(value) >= SMALLEST else 0.0


def color(text: str) -> str:
    """#rrggbb as a list, to be read as the same."""
    channels = [int(text[k : k + 2], 16) / 255 for k in (1, 3, 5)]
    return _list([*channels, 1.0])


def _height(low: float, high: float) -> float | None:
    """Of what begins at 0, or is about it."""
    return high if low == 0 else 2 * high if low == -high else None


def _center(low: float) -> str:
    return "true" if low else "false"


def _polygon(points: Any) -> Call:
    return Call(f"polygon(points = [{', '.join(map(_list, points))}])")


def _list(values: Any) -> str:
    return f"[{', '.join(map(word, values))}]"


def _ends(piece: Drawn) -> Faces:
    """What is drawn, by its corners: the sides, bottom and top."""
    scale, count = Fraction(piece.scale), len(piece.outline)
    flat = [(Fraction(x), Fraction(y)) for x, y in piece.outline]
    corners = [(x, y, Fraction(piece.low)) for x, y in flat]
    corners += [(scale * x, scale * y, Fraction(piece.high)) for x, y in flat]
    faces = [(k, (k + 1) % count, count + (k + 1) % count, count + k) for k in range(count)]
    return Faces(tuple(corners), (*faces, tuple(range(count))[::-1], tuple(range(count, 2 * count))))


def _volume(piece: Faces) -> Fraction:
    """Six times the signed volume."""
    total = Fraction(0)
    for face in piece.faces:
        a = piece.corners[face[0]]
        for k in range(2, len(face)):
            b, c = piece.corners[face[k - 1]], piece.corners[face[k]]
            total += a[0] * (b[1] * c[2] - b[2] * c[1]) + a[1] * (b[2] * c[0] - b[0] * c[2])
            total += a[2] * (b[0] * c[1] - b[1] * c[0])
    return total
