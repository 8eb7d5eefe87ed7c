"""Bounded pieces that other programs have: balls, boxes, revolutions, extrusions, closed faces, and Booleans of them.

Unbounded parts of a body are cut by a box around the body, beyond it, so that nothing of the body is lost.
`csg_pieces.py` splits solids into these pieces.
"""

from __future__ import annotations

from collections.abc import Iterable, Sequence
from fractions import Fraction
from typing import Literal, TypeAlias

from ..._util.arrays import Matrix4, Vector
from ..._util.records import dataclass
from ...geometry.transform import Step, Transform, Translate

PieceBooleanKind: TypeAlias = Literal["union", "intersection", "difference"]
PieceCorner: TypeAlias = tuple[Fraction, Fraction, Fraction]
Steps: TypeAlias = tuple[Step, ...]


@dataclass(frozen=True)
class BallPiece:
    """x² + y² + z² <= radius²"""

    radius: float


@dataclass(frozen=True)
class EllipsoidPiece:
    """An ellipsoid about the origin, by its half-axes along x, y and z."""

    radii: Vector


@dataclass(frozen=True)
class BoxPiece:
    """low <= (x, y, z) <= high"""

    low: Vector
    high: Vector


@dataclass(frozen=True)
class FrustumPiece:
    """A cylinder or cone about z, from a circle of radius `first` at `low` to one of radius `second` at `high`."""

    first: float
    second: float
    low: float
    high: float


@dataclass(frozen=True)
class RevolutionPiece:
    """A polygon of (r, z) that turns about z, from one angle to another in degrees."""

    profile: tuple[tuple[float, float], ...]
    start: float = 0.0
    end: float = 360.0


@dataclass(frozen=True)
class ExtrusionPiece:
    """A polygon of (x, y) from z = `low` to z = `high`, where it is scaled about the z axis by `scale`."""

    outline: tuple[tuple[float, float], ...]
    low: float
    high: float
    scale: float = 1.0


@dataclass(frozen=True)
class QuadricPiece:
    """x² + y² <= g0 + g1 z + g2 z² between two heights: a paraboloid or hyperboloid, with exact coefficients."""

    g0: Fraction
    g1: Fraction
    g2: Fraction
    low: float
    high: float


@dataclass(frozen=True)
class PolyhedronPiece:
    """A solid that flat faces enclose; each face lists the numbers of its corners.

    Attributes
    ----------
    is_convex
        The solid is convex, and its faces are counter-clockwise as seen from outside.
    planes
        The planes (normal, offset) of the shape, if it was defined by planes.
    """

    corners: tuple[PieceCorner, ...]
    faces: tuple[tuple[int, ...], ...]
    is_convex: bool = False
    planes: tuple[tuple[Vector, float], ...] | None = None


@dataclass(frozen=True)
class NativePiece:
    """An element or call of the format itself, as text: its tag, its attributes or arguments, and its children.

    `shift` moves it to its place.
    """

    tag: str
    attributes: str
    children: str = ""
    shift: PieceCorner = (Fraction(0), Fraction(0), Fraction(0))


Piece: TypeAlias = (
    BallPiece
    | EllipsoidPiece
    | BoxPiece
    | FrustumPiece
    | RevolutionPiece
    | ExtrusionPiece
    | QuadricPiece
    | PolyhedronPiece
    | NativePiece
)


@dataclass(frozen=True)
class PieceLeaf:
    """A piece and the steps that move it. `is_rounded` if its numbers are not exactly those of the shape."""

    piece: Piece
    steps: Steps = ()
    is_rounded: bool = False


@dataclass(frozen=True)
class PieceBoolean:
    """A Boolean of nodes and the steps that move it; a difference is the first part without the others.

    `color` is the colour of a painted solid, #rrggbb.
    """

    kind: PieceBooleanKind
    parts: tuple[PieceNode, ...]
    steps: Steps = ()
    color: str | None = None


PieceNode: TypeAlias = PieceLeaf | PieceBoolean


# Solids along an axis of coordinates: quarter turns from the z axis, which are exact.

_AXIS_TURNS: tuple[Matrix4, Matrix4] = (
    ((0.0, 0.0, 1.0, 0.0), (1.0, 0.0, 0.0, 0.0), (0.0, 1.0, 0.0, 0.0), (0.0, 0.0, 0.0, 1.0)),
    ((0.0, 1.0, 0.0, 0.0), (0.0, 0.0, 1.0, 0.0), (1.0, 0.0, 0.0, 0.0), (0.0, 0.0, 0.0, 1.0)),
)
"""The rotations that take z to x, and z to y."""
_AXIS_MIRROR: Matrix4 = ((1.0, 0.0, 0.0, 0.0), (0.0, -1.0, 0.0, 0.0), (0.0, 0.0, -1.0, 0.0), (0.0, 0.0, 0.0, 1.0))
"""Half a turn about x, which takes z to -z."""


def axis_steps(start: Vector, end: Vector) -> tuple[tuple[float, float], tuple[Step, ...]] | None:
    """Return heights along z, and the steps that take the z axis to the line from `start` to `end`.

    Return None for a line that is not parallel to an axis of coordinates.
    """
    along = [i for i in range(3) if start[i] != end[i]]
    if len(along) != 1:
        return None
    axis = along[0]
    low, high = start[axis], end[axis]
    steps: tuple[Step, ...] = ()
    if low > high:
        # Other programs want the lower end first, so that an axis that points down is turned over
        low, high, steps = -low, -high, (Transform(_AXIS_MIRROR),)
    if axis != 2:
        steps += (Transform(_AXIS_TURNS[axis]),)
    x, y, z = (0.0 if i == axis else value for i, value in enumerate(start))
    return (low, high), (*steps, Translate((x, y, z))) if x or y or z else steps


def upright_box(faces: PolyhedronPiece) -> BoxPiece | None:
    """Return a convex polyhedron as a box, if its sides are across the axes and its ends are floats; else None."""
    if len(faces.corners) != 8 or len(faces.faces) != 6:
        return None
    ends: list[tuple[float, float]] = []
    for i in range(3):
        values = {corner[i] for corner in faces.corners}
        if len(values) != 2 or any(Fraction(float(value)) != value for value in values):
            return None
        ends.append((float(min(values)), float(max(values))))
    (x, a), (y, b), (z, c) = ends
    return BoxPiece((x, y, z), (a, b, c))


# Convex polyhedra: a box, clipped by planes in exact fractions.

ClipPlane = tuple[PieceCorner, Fraction]
"""normal·x <= offset"""
_BOX_FACES = ((0, 4, 6, 2), (1, 3, 7, 5), (0, 1, 5, 4), (2, 6, 7, 3), (0, 2, 3, 1), (4, 5, 7, 6))
"""The faces of a box, counter-clockwise from outside; bit i of a corner's number chooses the high end along axis i."""


def clip_box(box: BoxPiece, planes: Iterable[ClipPlane]) -> PolyhedronPiece | None:
    """Return the part of a box that is inside of all planes; None if it is empty."""
    # Floats are fractions, so that nothing is rounded before the file is written
    ends = tuple(tuple(map(Fraction, end)) for end in (box.low, box.high))
    corners = [(ends[k & 1][0], ends[k >> 1 & 1][1], ends[k >> 2 & 1][2]) for k in range(8)]
    loops = [[corners.index(corners[k]) for k in face] for face in _BOX_FACES]
    for plane in planes:
        loops = _clip_faces(loops, corners, plane)
        if len(loops) < 4:
            return None
    numbers: dict[int, int] = {}
    faces = tuple(tuple(numbers.setdefault(corner, len(numbers)) for corner in loop) for loop in loops)
    return PolyhedronPiece(tuple(corners[k] for k in numbers), faces, True)


def _clip_faces(loops: list[list[int]], corners: list[PieceCorner], plane: ClipPlane) -> list[list[int]]:
    """Clip the faces of a convex polyhedron by a plane, and add the face in the plane and its corners."""
    heights = {corner: _plane_height(plane, corners[corner]) for corner in {k for loop in loops for k in loop}}
    if not any(height > 0 for height in heights.values()):
        return loops
    kept, edges = [], {}  # edges: end -> start, in the order in which the new face runs
    cuts: dict[tuple[int, int], int] = {}
    for loop in loops:
        left = _clip_face(loop, corners, heights, cuts)
        on = [corner for corner in left if not heights.get(corner, 0)]  # new corners lie in the plane
        if len(left) < 3 or len(on) == len(left):  # nothing of the face is left, or only an edge or face in the plane
            continue
        kept.append(left)
        for a, b in zip(left, [*left[1:], left[0]], strict=True):
            if not heights.get(a, 0) and not heights.get(b, 0):
                edges[b] = a
    if len(edges) >= 3:
        first = next(iter(edges))
        cap, at = [first], edges[first]
        while at != first and len(cap) <= len(edges):  # the count ends the walk on any broken loop
            cap.append(at)
            at = edges.get(at, first)
        kept.append(cap)
    return kept


def _clip_face(
    loop: Sequence[int], corners: list[PieceCorner], heights: dict[int, Fraction], cuts: dict[tuple[int, int], int]
) -> list[int]:
    """Return the part of a face on the inner side of a plane; `cuts` has the new corner on each edge that it cuts."""
    found: list[int] = []
    for a, b in zip(loop, [*loop[1:], loop[0]], strict=True):
        ha, hb = heights[a], heights[b]
        if ha <= 0:
            found.append(a)
        if (ha < 0 < hb) or (hb < 0 < ha):
            edge = (a, b) if a < b else (b, a)
            if edge not in cuts:
                # In fractions, once for the two faces of an edge
                share = ha / (ha - hb)
                x, y, z = (p if p == q else p + share * (q - p) for p, q in zip(corners[a], corners[b], strict=True))
                cuts[edge] = len(corners)
                corners.append((x, y, z))
            found.append(cuts[edge])
    return found


def _plane_height(plane: ClipPlane, corner: PieceCorner) -> Fraction:
    """Return normal·corner - offset: above 0 outside."""
    normal, height = plane[0], -plane[1]
    for n, c in zip(normal, corner, strict=True):
        if n:
            height += c if n == 1 else n * c
    return height
