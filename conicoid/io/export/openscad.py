"""Export to OpenSCAD: a coloured solid for each body, from pieces under `multmatrix`.

The calls are sphere, cube, cylinder, polyhedron and extrusions, which .scad and .csg files share.
"""

from __future__ import annotations

from collections import Counter
from collections.abc import Iterator
from fractions import Fraction
from typing import Any

from ..._util.files import printable
from ..._util.records import dataclass
from ..._util.text import format_count
from ..._util.validation import SMALLEST
from ...geometry.shape import Solid
from ...geometry.transform import Motion, Scale, Step, Translate
from ...numerics import bigfloat as ex
from ..gdml.flat_solids import signed_volume
from ..openscad.solids import SidedBall
from ..scene_file.scene_file import WritableScene
from .csg_pieces import split_into_pieces
from .exporters import (
    ExportOptions,
    ExportReport,
    ExportResult,
    UnsupportedExport,
    collect_solids,
    format_number,
    hex_color,
    is_void,
    shortest_decimal,
    unit_factor,
    unit_notes,
)
from .pieces import (
    BallPiece,
    BoxPiece,
    EllipsoidPiece,
    ExtrusionPiece,
    FrustumPiece,
    NativePiece,
    Piece,
    PieceLeaf,
    PieceNode,
    PolyhedronPiece,
    QuadricPiece,
    RevolutionPiece,
    Steps,
)

_ROUND_OPTIONS = "$fn = 0, $fa = 3, $fs = 0.01"
"""Conicoid reads circles with these options as round; OpenSCAD gives them 120 sides."""


@dataclass(frozen=True)
class CsgCallText:
    """The text of a call, and its children."""

    text: str
    children: tuple[CsgCallText, ...] = ()

    def lines(self, depth: int = 0) -> Iterator[str]:
        """Yield the lines of a file, indented by tabs."""
        margin = "\t" * depth
        if not self.children:
            yield f"{margin}{self.text};"
            return
        yield f"{margin}{self.text} {{"
        for child in self.children:
            yield from child.lines(depth + 1)
        yield f"{margin}}}"


@dataclass
class OpenscadWriter:
    """Converts pieces to calls; `is_rounded` becomes true if a number in them is not exactly that of the scene."""

    is_rounded: bool = False

    def call(self, node: PieceNode) -> CsgCallText:
        """Return the call of a node under its steps. Raise UnsupportedExport for pieces that OpenSCAD lacks."""
        if isinstance(node, PieceLeaf):
            self.is_rounded = self.is_rounded or node.is_rounded
            call, before = self._piece(node.piece)
            return self._moved(self._moved(call, before), node.steps)
        parts = tuple(self.call(part) for part in node.parts)
        whole = parts[0] if len(parts) == 1 else CsgCallText(f"{node.kind}()", parts)
        if node.color is not None:
            whole = CsgCallText(f"color({color_list(node.color)})", (whole,))
        return self._moved(whole, node.steps)

    def _moved(self, call: CsgCallText, steps: Steps) -> CsgCallText:
        for step in steps:
            call = CsgCallText(f"multmatrix({self._matrix(step)})", (call,))
        return call

    def _matrix(self, step: Step) -> str:
        """Return the 4 x 4 matrix of a step as text, rounded to floats."""
        linear, shift = Motion((step,)).affine
        rows = []
        for row, end in zip(linear, shift, strict=True):
            numbers = [_within_domain(ex.rounded(value)) for value in (*row, end)]
            for exact, near in zip((*row, end), numbers, strict=True):
                self.is_rounded = self.is_rounded or bool(ex.cancelling_sum((exact, -ex.exact(near))))
            rows.append(f"[{', '.join(map(format_number, numbers))}]")
        return f"[{', '.join(rows)}, [0, 0, 0, 1]]"

    def _piece(self, piece: Piece) -> tuple[CsgCallText, Steps]:
        """Return the call of a piece, and the steps that move it to the piece's place."""
        if isinstance(piece, BallPiece):
            return CsgCallText(f"sphere({_ROUND_OPTIONS}, r = {format_number(piece.radius)})"), ()
        if isinstance(piece, EllipsoidPiece):
            return CsgCallText(f"sphere({_ROUND_OPTIONS}, r = 1)"), (Scale(piece.radii),)
        if isinstance(piece, BoxPiece):
            return self._cuboid(piece)
        if isinstance(piece, FrustumPiece):
            return self._frustum(piece)
        if isinstance(piece, RevolutionPiece):
            return self._turned(piece), ()
        if isinstance(piece, ExtrusionPiece):
            return self._drawn(piece)
        if isinstance(piece, NativePiece):
            return CsgCallText(f"{piece.tag}({piece.attributes})"), ()
        if isinstance(piece, QuadricPiece):
            raise UnsupportedExport("a part of it is a paraboloid or hyperboloid, which OpenSCAD does not have")
        return self._faces(piece), ()

    def _cuboid(self, piece: BoxPiece) -> tuple[CsgCallText, Steps]:
        size = [b - a for a, b in zip(piece.low, piece.high, strict=True)]
        if all(a == -b for a, b in zip(piece.low, piece.high, strict=True)):
            return CsgCallText(f"cube(size = {_list(size)}, center = true)"), ()
        # At other places low + size may differ from high by rounding: write the corners.
        if not any(piece.low):
            return CsgCallText(f"cube(size = {_list(size)}, center = false)"), ()
        corners = []
        for k in range(8):
            corners.append(tuple(Fraction((piece.low, piece.high)[k >> i & 1][i]) for i in range(3)))
        faces = ((0, 4, 6, 2), (1, 3, 7, 5), (0, 1, 5, 4), (2, 6, 7, 3), (0, 2, 3, 1), (4, 5, 7, 6))
        return self._faces(PolyhedronPiece(tuple(corners), faces, True)), ()  # type: ignore[arg-type]

    def _frustum(self, piece: FrustumPiece) -> tuple[CsgCallText, Steps]:
        height = _height(piece.low, piece.high)
        if height is None:
            r, low, s, high = piece.first, piece.low, piece.second, piece.high
            return self._turned(
                RevolutionPiece(tuple(dict.fromkeys(((0.0, low), (r, low), (s, high), (0.0, high)))))
            ), ()
        text = f"h = {format_number(height)}, r1 = {format_number(piece.first)}, r2 = {format_number(piece.second)}"
        return CsgCallText(f"cylinder({_ROUND_OPTIONS}, {text}, center = {_center(piece.low)})"), ()

    def _turned(self, piece: RevolutionPiece) -> CsgCallText:
        angle = piece.end - piece.start
        if shortest_decimal(piece.start) and piece.start + angle != piece.end:
            self.is_rounded = True
        text = f"angle = {format_number(angle)}, start = {format_number(piece.start)}, {_ROUND_OPTIONS}"
        return CsgCallText(f"rotate_extrude({text})", (_polygon(piece.profile),))

    def _drawn(self, piece: ExtrusionPiece) -> tuple[CsgCallText, Steps]:
        height = _height(piece.low, piece.high)
        steps: Steps = ()
        if height is None:
            # A height that is no float would move the top: write faces instead.
            size = Fraction(piece.high) - Fraction(piece.low)
            if Fraction(float(size)) != size:
                return self._faces(_ends(piece)), ()
            height, steps = float(size), (Translate((0.0, 0.0, piece.low)),)
        center = _center(0.0 if steps else piece.low)
        text = f"height = {format_number(height)}, center = {center}, scale = {format_number(piece.scale)}"
        return CsgCallText(f"linear_extrude({text}, {_ROUND_OPTIONS})", (_polygon(piece.outline),)), steps

    def _faces(self, piece: PolyhedronPiece) -> CsgCallText:
        """Return a polyhedron; OpenSCAD expects the corners of faces clockwise, as seen from outside."""
        points = []
        for corner in piece.corners:
            numbers = [float(value) for value in corner]
            self.is_rounded = self.is_rounded or any(
                Fraction(near) != value for near, value in zip(numbers, corner, strict=True)
            )
            points.append(_list(numbers))
        # Faces of meshes may run either way; the sign of the volume shows which.
        turned = piece.is_convex or signed_volume(piece.corners, piece.faces) > 0
        faces = [f"[{', '.join(map(str, reversed(face) if turned else face))}]" for face in piece.faces]
        return CsgCallText(f"polyhedron(points = [{', '.join(points)}], faces = [{', '.join(faces)}], convexity = 10)")


def source_piece(solid: Solid) -> PieceLeaf | None:
    """Return the ball of flat sides that an importer made a solid of; None for other solids."""
    ball = solid._source
    if not isinstance(ball, SidedBall):
        return None
    arguments = f"$fn = {ball.sides}, $fa = 3, $fs = 0.01, r = {format_number(ball.radius)}"
    return PieceLeaf(NativePiece("sphere", arguments))


def _within_domain(value: float) -> float:
    """Return a number, or 0 if it is smaller than a scene allows."""
    return value if abs(value) >= SMALLEST else 0.0


def color_list(text: str) -> str:
    """Return #rrggbb as a list of four numbers, which reads back as the same colour."""
    channels = [int(text[k : k + 2], 16) / 255 for k in (1, 3, 5)]
    return _list([*channels, 1.0])


def _height(low: float, high: float) -> float | None:
    """Return the height of a call whose solid begins at 0, or is centred there; None for other ends."""
    return high if low == 0 else 2 * high if low == -high else None


def _center(low: float) -> str:
    return "true" if low else "false"


def _polygon(points: Any) -> CsgCallText:
    return CsgCallText(f"polygon(points = [{', '.join(map(_list, points))}])")


def _list(values: Any) -> str:
    return f"[{', '.join(map(format_number, values))}]"


def _ends(piece: ExtrusionPiece) -> PolyhedronPiece:
    """Return an extrusion as a polyhedron: its sides, bottom and top."""
    scale, count = Fraction(piece.scale), len(piece.outline)
    flat = [(Fraction(x), Fraction(y)) for x, y in piece.outline]
    corners = [(x, y, Fraction(piece.low)) for x, y in flat]
    corners += [(scale * x, scale * y, Fraction(piece.high)) for x, y in flat]
    faces = [(k, (k + 1) % count, count + (k + 1) % count, count + k) for k in range(count)]
    return PolyhedronPiece(tuple(corners), (*faces, tuple(range(count))[::-1], tuple(range(count, 2 * count))))


def export_text(scene: WritableScene, options: ExportOptions) -> ExportResult:
    """Return the text of a .scad or .csg file: the calls used here belong to both.

    Raise ValueError for bodies that OpenSCAD cannot hold, and for a scene without visible bodies.
    """
    report = ExportReport("OpenSCAD")
    items = collect_solids(scene, report)
    lines: list[str] = []
    colors: Counter[str] = Counter()
    factor = unit_factor(scene, "mm")
    for number, item in enumerate(items):
        if options.progress is not None and number % 256 == 0:
            options.progress(number, len(items))
        if is_void(item.material):
            report.narrow("left out: invisible", item.name)
            continue
        with report.about(item.name):
            writer = OpenscadWriter()
            look, is_all = hex_color(item.material)
            solid = writer.call(split_into_pieces(item.solid, source_piece))
            whole = CsgCallText(f"color({color_list(look)})", (solid,))
            if factor != 1:
                f = format_number(factor)
                whole = CsgCallText(f"multmatrix([[{f},0,0,0],[0,{f},0,0],[0,0,{f},0],[0,0,0,1]])", (whole,))
            lines += [f"// {printable(item.name)}", *whole.lines()]
            colors[look] += 1
            if colors[look] == 2:
                report.narrow("one of several bodies of a colour, which are read back as one", item.name)
            if writer.is_rounded:
                report.narrow("numbers are rounded to float64", item.name)
            if not is_all:
                report.narrow("of its look only the colour is written", item.name)
            if item.material is not None and item.material.properties:
                report.narrow("not written: properties of the material", item.name)
    report.check()
    if not colors:
        raise ValueError("export: there is no visible body to write")
    facts = [f"{format_count(sum(colors.values()), 'solid')} of {format_count(len(colors), 'colour')}"]
    remarks = report.remarks
    return ExportResult("\n".join([*lines, ""]), (*facts, *unit_notes(scene, "mm"), *remarks), remarks)
