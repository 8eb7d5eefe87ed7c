"""Boolean trees over cells, which all solids reduce to, and sheets clipped by such trees.

A *cell* is at most one quadric, cut by any number of planes. A *face* is one of its surfaces, together with the side
that is inside, a number that the user sees as ``hits.face``, and a map that gives its uv coordinates.
"""

from __future__ import annotations

from collections.abc import Callable, Iterator
from dataclasses import dataclass
from typing import TypeAlias

from .._util.records import Vector
from ..numerics import bigfloat as ex
from .surface import PlaneSurface, QuadricSurface, Surface
from .transform import Motion


@dataclass(frozen=True, slots=True)
class UV:
    """A map from own coordinates p to uv, by (a, b, c) = matrix (p, 1), a 3 × 4 matrix as a tuple of rows.

    An `angular` map has u = angle of (a, b) in turns, in [0, 1), and v = c. A planar one has u = a and v = b; it does
    not use c (`NO_ROW`).
    """

    angular: bool
    matrix: tuple[tuple[float, float, float, float], ...]


NO_ROW = (0.0, 0.0, 0.0, 0.0)
"""The third row of a planar map."""


def cylindrical_uv(low: float = 0.0, high: float = 1.0) -> UV:
    """Return the map (angle about z / 360, height scaled from [low, high] to [0, 1]); infinite ends do not scale z."""
    scale, shift = (1 / (high - low), -low / (high - low)) if high - low < float("inf") else (1.0, 0.0)
    return UV(True, ((1, 0, 0, 0), (0, 1, 0, 0), (0, 0, scale, shift)))


def cartesian_uv(u: Vector, v: Vector, origin: Vector = (0.0, 0.0, 0.0)) -> UV:
    """Return the map to the components of (p - origin) along the vectors u and v, divided by their squared lengths."""
    return UV(False, (component_row(u, origin), component_row(v, origin), NO_ROW))


def component_row(a: Vector, origin: Vector) -> tuple[float, float, float, float]:
    """Return one row of a map: the component of (p - origin) along the vector `a`, divided by its squared length."""
    n = a[0] * a[0] + a[1] * a[1] + a[2] * a[2]
    return a[0] / n, a[1] / n, a[2] / n, -(a[0] * origin[0] + a[1] * origin[1] + a[2] * origin[2]) / n


def transform_uv(uv: UV, motion: Motion) -> UV:
    """Return the same map from world coordinates, if `motion` carries own coordinates to the world."""
    if motion.is_identity:
        return uv
    back, shift = motion.inverse
    columns = ex.transpose(back)

    def row(own: tuple[float, float, float, float]) -> tuple[float, float, float, float]:
        a, b, c, d = (ex.exact(value) for value in own)
        x, y, z = ex.apply(columns, (a, b, c))
        return ex.rounded(x), ex.rounded(y), ex.rounded(z), ex.rounded(ex.dot((a, b, c), shift, d))

    return UV(uv.angular, tuple(row(own) for own in uv.matrix))


PLAIN_UV = cartesian_uv((1, 0, 0), (0, 1, 0))


@dataclass(frozen=True, slots=True)
class Face:
    """One surface of a cell. `inside` is +1 if surface <= 0 is inside, -1 if surface >= 0 is."""

    surface: Surface
    number: int
    uv: UV = PLAIN_UV
    inside: int = 1


@dataclass(frozen=True, slots=True)
class Cell:
    """The points inside all faces.

    At most one face is a quadric, and it comes first. Numbers rise along the tuple: of several crossings at one t, the
    face with the lower number counts.
    """

    faces: tuple[Face, ...]


@dataclass(frozen=True, slots=True)
class All:
    """The points inside every part; all of space without parts."""

    parts: tuple[Tree, ...]


@dataclass(frozen=True, slots=True)
class Any_:
    """The points inside at least one part; none without parts."""

    parts: tuple[Tree, ...]


@dataclass(frozen=True, slots=True)
class Not:
    """The points outside of the part."""

    part: Tree


Tree: TypeAlias = Cell | All | Any_ | Not
NOTHING = Any_(())


def cells_of_tree(tree: Tree) -> Iterator[Cell]:
    """Yield the cells of a tree from left to right."""
    pending = [tree]
    while pending:
        part = pending.pop()
        if isinstance(part, Cell):
            yield part
        else:
            pending.extend(reversed((part.part,) if isinstance(part, Not) else part.parts))


def faces_of_tree(tree: Tree) -> Iterator[Face]:
    """Yield the faces of all cells of a tree from left to right."""
    for cell in cells_of_tree(tree):
        yield from cell.faces


def bounding_faces(tree: Tree, inside: bool) -> Iterator[tuple[Face, int]]:
    """Yield (face, sense) of the faces that contain all of the inside, or all of the outside, of a tree.

    The sense is 1 where that side is the negative one of the face's surface.
    """
    pending = [(tree, inside)]
    while pending:
        part, inner = pending.pop()
        if isinstance(part, Not):
            pending.append((part.part, not inner))
        elif isinstance(part, Cell):
            if inner or len(part.faces) == 1:  # the outside of several faces is a union, in none of their outsides
                sense = 1 if inner else -1
                yield from ((face, sense * face.inside) for face in part.faces)
        elif isinstance(part, All if inner else Any_) or len(part.parts) == 1:
            pending.extend((each, inner) for each in part.parts)


def negate_tree(tree: Tree) -> Tree:
    """Return the complement of a tree; two complements never follow each other."""
    return tree.part if isinstance(tree, Not) else Not(tree)


def join_trees(kind: type[All] | type[Any_], parts: list[Tree]) -> Tree:
    """Join parts to one node of a kind; parts of the same kind are flattened into it, and one part needs no node."""
    nodes: list[Tree] = []
    for part in parts:
        nodes.extend(part.parts if isinstance(part, kind) else (part,))
    return nodes[0] if len(nodes) == 1 else kind(tuple(nodes))


def map_faces(tree: Tree, of: Callable[[Face], Face]) -> Tree:
    """Return a tree with another face for each of its faces, made from left to right; its nodes are joined."""
    if isinstance(tree, Cell):
        return Cell(tuple(map(of, tree.faces)))
    if isinstance(tree, Not):
        return negate_tree(map_faces(tree.part, of))
    return join_trees(type(tree), [map_faces(part, of) for part in tree.parts])


@dataclass(frozen=True, slots=True)
class SurfaceSheet:
    """The part of a surface in `clip`, all of it if None.

    The normal of the sheet is the gradient of the surface times `side`, +1 or -1.
    """

    surface: Surface
    clip: Tree | None = None
    side: int = 1
    one_sided: bool = False
    uv: UV = PLAIN_UV


@dataclass(frozen=True, slots=True)
class PolygonSheet:
    """The even-odd inside of a closed loop of points in a plane, with exact coordinates."""

    plane: PlaneSurface
    vertices: tuple[ex.Row, ...]
    uv: UV = PLAIN_UV


__all__ = [
    "NOTHING",
    "UV",
    "All",
    "Any_",
    "Cell",
    "Face",
    "Not",
    "PlaneSurface",
    "PolygonSheet",
    "QuadricSurface",
    "SurfaceSheet",
    "Tree",
    "bounding_faces",
    "cartesian_uv",
    "cells_of_tree",
    "cylindrical_uv",
    "faces_of_tree",
    "join_trees",
    "map_faces",
    "negate_tree",
    "transform_uv",
]
