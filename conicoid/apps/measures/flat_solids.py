"""Closed forms of solids with flat faces: polyhedra, meshes, extrusions, and Booleans of boxes along common axes.

The integrals over a solid are sums over its faces: over the tetrahedra between a point and the triangles of a face,
each with the sign of its volume. A union of many boxes is a grid of blocks, each inside or outside.
"""

from __future__ import annotations

import dataclasses
import itertools
import math
from collections.abc import Iterable, Iterator, Sequence
from fractions import Fraction
from typing import Any, TypeAlias

import numpy as np
import numpy.typing as npt

from ..._util.arrays import BoxEnds, FloatArray
from ...geometry.cell import Cell
from ...geometry.convex_decomposition import exact_face
from ...geometry.facets import FlatPlane
from ...geometry.polyhedron import Extrusion, Mesh, Polyhedron
from ...geometry.primitives import Box
from ...geometry.shape import Boolean, Complement, Difference, Shape, Solid, Union
from ...geometry.surface import PlaneSurface
from ...geometry.transform import IDENTITY_MOTION, Motion
from ...numerics.rational import cross, dot3, minus
from .closed_forms import Moments
from .hull import moved_parts

Blocks: TypeAlias = npt.NDArray[np.bool_]
Polygons: TypeAlias = Sequence[FloatArray]
"""The corners (k, 3) of each face, counter-clockwise from outside."""

_ROUNDING = 2.0**-44
"""Corners within this share of the coordinates of a solid are in a plane."""
_SAME_VOLUME = 1e-9
"""The parts of a mesh fill its faces if both have the same volume, up to this share."""
_MOST_PARTS = 500
"""Meshes of more convex parts are not tried: their parts show whether their faces enclose a volume once."""


def flat_form(shape: Shape) -> tuple[Moments, float | None] | None:
    """Return the moments and the area of a polyhedron, mesh or extrusion in the world; None for other shapes.

    The area is None for a mesh with faces back to back, which bound nothing, or with pieces that overlap.
    """
    if isinstance(shape, Polyhedron):
        faces: Polygons = convex_faces(zip(shape.normals, shape.offsets, strict=True), _own_bounds(shape))
    elif isinstance(shape, (Mesh, Extrusion)):
        faces = _solid_faces(shape)
    else:
        return None
    found, matrix = polygon_moments(faces), shape.under().matrix
    if isinstance(shape, Mesh):
        tree = shape.tree()
        cells: Sequence[Cell] = (tree,) if isinstance(tree, Cell) else tree.parts  # type: ignore[union-attr,assignment]
        if len(cells) > _MOST_PARTS:
            return None
        bounds = _own_bounds(shape)
        by_parts = polygon_moments([face for cell in cells for face in convex_faces(_cell_planes(cell), bounds)])
        if shape._pieces_overlap:
            return by_parts.moved(matrix), None
        margin = _SAME_VOLUME * found.volume
        # Next to faces that are nearly coplanar there are slivers, whose volumes floats lose
        if abs(by_parts.volume - found.volume) > margin and abs(_exact_volume(cells) - found.volume) > margin:
            return None
    is_wall = isinstance(shape, Mesh) and _has_inner_walls(shape, faces)
    area = None if is_wall else math.fsum(_face_area((face - face[0]) @ matrix[:3, :3].T) for face in faces)
    return found.moved(matrix), area


def _exact_volume(cells: Sequence[Cell]) -> float:
    """Return the volume of convex cells between planes, by fractions."""
    total = Fraction(0)
    for cell in cells:
        planes = [
            FlatPlane.of((Fraction(x), Fraction(y), Fraction(z)), Fraction(end))
            for (x, y, z), end in _cell_planes(cell)
        ]
        sides = [(k, 1) for k in range(len(planes))]
        faces = list(filter(None, (exact_face(planes, sides, k) for k in range(len(planes)))))
        for face in faces:
            a, *others = (minus(corner, faces[0][0]) for corner in face)
            total += sum(abs(dot3(a, cross(b, c))) for b, c in itertools.pairwise(others))
    return float(total / 6)


def _own_bounds(shape: Solid) -> BoxEnds:
    """Return the bounds of a solid before its motion."""
    return dataclasses.replace(shape, motion=IDENTITY_MOTION).bounds


def polygon_moments(faces: Polygons) -> Moments:
    """Return the moments of the solid inside closed faces.

    A tetrahedron with corners 0, a, b, c has the volume a·(b × c) / 6, the mean (a + b + c) / 4 and the mean square
    (s sᵀ + a aᵀ + b bᵀ + c cᵀ) / 20, s = a + b + c.
    """
    nothing = Moments(0.0, np.full(3, np.nan), np.zeros((3, 3)))
    if not faces:
        return nothing
    corners = np.concatenate(faces)
    middle = (corners.min(axis=0) + corners.max(axis=0)) / 2
    fans = [face - middle for face in faces]
    a = np.concatenate([np.repeat(fan[:1], len(fan) - 2, axis=0) for fan in fans])
    b, c = np.concatenate([fan[1:-1] for fan in fans]), np.concatenate([fan[2:] for fan in fans])
    six = (a * np.cross(b, c)).sum(axis=1)
    volume = abs(float(six.sum()) / 6)
    if not volume:
        return nothing
    share, total = six / six.sum(), a + b + c
    mean = share @ total / 4
    square = sum(np.einsum("n,ni,nj->ij", share, each, each) for each in (total, a, b, c)) / 20
    return Moments(volume, middle + mean, square - np.outer(mean, mean))


def _face_area(corners: FloatArray) -> float:
    """Return the area of a face; one that is not flat consists of the triangles about its first corner."""
    spokes = corners[1:] - corners[0]
    doubled = np.cross(spokes[:-1], spokes[1:])
    normal = doubled.sum(axis=0)
    size = float(np.linalg.norm(normal))
    if size and np.abs(spokes @ normal).max() <= _ROUNDING * size * np.abs(corners).max():
        return size / 2
    return float(np.linalg.norm(doubled, axis=1).sum()) / 2


def _solid_faces(shape: Mesh | Extrusion) -> Polygons:
    """Return the faces of a mesh or an extrusion, without those that have no area."""
    _, _, corners, faces = shape._boundary()
    points = np.array([[float(x) for x in corner] for corner in corners])
    return [points[list(face)] for face in faces]


def _has_inner_walls(shape: Mesh, faces: Polygons) -> bool:
    """Return True if two faces in one plane look in opposite directions: their common part bounds nothing."""
    for _, members in shape.planes():
        normals = [
            np.cross(face[1:-1] - face[0], face[2:] - face[0]).sum(axis=0) for face in map(faces.__getitem__, members)
        ]
        if any(float(normals[0] @ other) < 0 for other in normals[1:]):
            return True
    return False


# Faces of convex cells

_NEIGHBOURS = 48
"""So many planes near a face are tried before all."""
_FAR_FACTOR = 4.0
"""The first square of a face is so many times as large as the solid."""
HalfSpaces: TypeAlias = Iterable[tuple[Sequence[Any], Any]]
"""(normal, offset) of each n·x <= d."""


def _cell_planes(cell: Cell) -> HalfSpaces:
    """Yield the half-spaces of a cell between planes."""
    for face in cell.faces:
        assert isinstance(face.surface, PlaneSurface)
        yield [face.inside * x for x in face.surface.normal], face.inside * face.surface.offset


def convex_faces(planes: HalfSpaces, bounds: BoxEnds) -> list[FloatArray]:
    """Return the faces of a convex solid within bounds; half-spaces that it touches in less than a face have none.

    From a large square on its plane, each face is cut by the plane that cuts off most, until none cuts off anything;
    the planes near it come first.
    """
    middle = bounds[0] / 2 + bounds[1] / 2
    reach = float(np.linalg.norm(bounds[1] - middle))
    center = [Fraction(x) for x in middle.tolist()]
    rows = np.array(
        [
            (
                *map(float, normal),
                float(Fraction(offset) - sum(Fraction(n) * c for n, c in zip(normal, center, strict=True))),
            )
            for normal, offset in planes
        ]
    )
    rows /= np.linalg.norm(rows[:, :3], axis=1, keepdims=True)
    found = []
    for k, row in enumerate(rows):
        towards = rows[:, :3] @ row[:3]
        parallels = rows[np.flatnonzero(towards[:k] > 1 - _ROUNDING)]
        same = (np.abs(parallels - row) <= _ROUNDING * np.array([1.0, 1.0, 1.0, reach])).all(axis=1)
        if abs(row[3]) > _FAR_FACTOR * reach or same.any():
            continue
        corners = _square(row, _FAR_FACTOR * reach)
        near = np.argpartition(-towards, min(_NEIGHBOURS, len(rows) - 1))[: _NEIGHBOURS + 1]
        for some in (rows[near], rows) if len(rows) > len(near) else (rows,):
            corners = _cut_by(corners, some, _ROUNDING * reach)
        if len(corners) > 2:
            found.append(middle + corners)
    return found


def _square(row: FloatArray, half: float) -> FloatArray:
    """Return the corners of a square on a plane with a unit normal, counter-clockwise from the side of the normal."""
    across = np.cross(row[:3], np.eye(3)[int(np.abs(row[:3]).argmin())])
    first = across / np.linalg.norm(across)
    second = np.cross(row[:3], first)
    signs = np.array([(1.0, 1.0), (-1.0, 1.0), (-1.0, -1.0), (1.0, -1.0)])
    return row[3] * row[:3] + half * (signs @ np.array([first, second]))


def _cut_by(corners: FloatArray, rows: FloatArray, loose: float) -> FloatArray:
    """Return the part of a convex polygon within half-spaces; without corners if nothing is left."""
    normals, offsets = rows[:, :3].T, rows[:, 3]
    while len(corners) > 2:
        above = corners @ normals
        above -= offsets
        worst = int(above.argmax()) % len(rows)
        if above[:, worst].max() <= loose:
            return corners
        # Few corners: lists are quicker than arrays
        heights, points, left = above[:, worst].tolist(), corners.tolist(), []
        for k, (point, height) in enumerate(zip(points, heights, strict=True)):
            before = heights[k - 1]
            if (height <= 0) != (before <= 0):
                share = height / (height - before)
                left.append([a + share * (b - a) for a, b in zip(point, points[k - 1], strict=True)])
            if height <= 0:
                left.append(point)
        corners = np.array(left).reshape(-1, 3)
    return np.zeros((0, 3))


# Booleans of boxes along common axes: a grid of blocks between the planes of all boxes

_MOST_BLOCKS = 4_000_000
"""Larger grids are not tried."""
_SAME_PLACE, _LEAST_GAP = 2.0**-50, 1e-12
"""Planes of boxes closer than the first share of the coordinates are one, because motions round the places of walls.
Where others are closer than the second, floats cannot tell whether they are one."""


def box_grid(shape: Shape) -> tuple[Moments, float | None] | None:
    """Return the moments and the area of a Boolean of boxes along common axes; None for other shapes, or too many."""
    if not isinstance(shape, Boolean):
        return None
    own = dataclasses.replace(shape, motion=IDENTITY_MOTION)
    boxes = []
    for part, outer in moved_parts(own):
        ends = _upright_ends(part, outer) if isinstance(part, Box) else None
        if ends is None:
            return None
        boxes.append(ends)
    places = np.array(boxes)
    edges = [_distinct(places[:, :, axis].ravel()) for axis in range(3)]
    if math.prod(len(each) - 1 for each in edges) > _MOST_BLOCKS:
        return None
    if any((np.diff(each) <= _LEAST_GAP * np.abs(each).max()).any() for each in edges):
        return None
    if any(blocks.start == blocks.stop for ends in boxes for blocks in _slices(ends, edges)):
        return None  # a box thinner than rounding
    inside = _blocks(own, edges, iter(places))
    linear = shape.motion.matrix[:3, :3]
    return _grid_moments(inside, edges).moved(shape.motion.matrix), _grid_area(inside, edges, linear)


def _upright_ends(box: Box, outer: Motion) -> FloatArray | None:
    """Return (low, high) of a moved box; None if it is no longer along the axes."""
    matrix = box.under(outer).matrix
    if ((matrix[:3, :3] != 0).sum(axis=1) != 1).any():
        return None
    ends = np.array([box.low, box.high]) @ matrix[:3, :3].T + matrix[:3, 3]
    return np.sort(ends, axis=0)


def _distinct(places: FloatArray) -> FloatArray:
    """Return the rising places of planes; those that only rounding keeps apart are one."""
    rising = np.sort(places)
    is_new = np.diff(rising) > _SAME_PLACE * np.abs(rising).max()
    return rising[np.concatenate([[True], is_new])]


def _blocks(solid: Solid, edges: list[FloatArray], boxes: Iterator[FloatArray]) -> Blocks:
    """Return which blocks of the grid are inside a solid; `boxes` has the ends of its boxes, in their order."""
    counts = [len(each) - 1 for each in edges]
    if isinstance(solid, Box):
        within = np.zeros(counts, bool)
        within[_slices(next(boxes), edges)] = True
        return within
    assert isinstance(solid, Boolean)
    inside = None
    for part in solid.operands:
        if isinstance(part, Box) and inside is not None and isinstance(solid, (Union, Difference)):
            inside[_slices(next(boxes), edges)] = isinstance(solid, Union)  # without a grid of its own
            continue
        other = _blocks(part, edges, boxes)
        if inside is None:
            inside = other
        elif isinstance(solid, Union):
            inside |= other
        else:
            inside &= ~other if isinstance(solid, Difference) else other
    assert inside is not None
    return ~inside if isinstance(solid, Complement) else inside


def _slices(ends: FloatArray, edges: list[FloatArray]) -> tuple[slice, ...]:
    """Return the blocks of a box along each axis."""
    return tuple(slice(*(int(np.abs(each - end).argmin()) for end in ends[:, axis])) for axis, each in enumerate(edges))


def _grid_moments(inside: Blocks, edges: list[FloatArray]) -> Moments:
    """Return the moments of the blocks that are inside."""
    sizes = [np.diff(each) for each in edges]
    middles = [each[:-1] + size / 2 for each, size in zip(edges, sizes, strict=True)]
    weight = np.einsum("xyz,x,y,z->xyz", inside, *sizes)
    volume = float(weight.sum())
    if volume == 0:
        return Moments(0.0, np.full(3, np.nan), np.zeros((3, 3)))
    along = [weight.sum(axis=tuple({0, 1, 2} - {axis})) / volume for axis in range(3)]
    mean = np.array([share @ middle for share, middle in zip(along, middles, strict=True)])
    from_mean = [middle - m for middle, m in zip(middles, mean, strict=True)]
    spread = np.empty((3, 3))
    for i, j in itertools.combinations(range(3), 2):
        share = weight.sum(axis=3 - i - j) / volume
        spread[i, j] = spread[j, i] = from_mean[i] @ share @ from_mean[j]
    for axis in range(3):
        spread[axis, axis] = along[axis] @ (from_mean[axis] ** 2 + sizes[axis] ** 2 / 12)
    return Moments(volume, mean, spread)


def _grid_area(inside: Blocks, edges: list[FloatArray], linear: FloatArray) -> float:
    """Return the area of the walls between blocks that are inside and others, after a linear map."""
    area = 0.0
    for axis in range(3):
        i, j = (k for k in range(3) if k != axis)
        walls = np.diff(inside, axis=axis, prepend=False, append=False).sum(axis=axis)
        stretch = float(np.linalg.norm(np.cross(linear[:, i], linear[:, j])))
        area += stretch * float(np.diff(edges[i]) @ walls @ np.diff(edges[j]))
    return area
