"""From shapes to Boolean trees of cells in the world, with faces numbered through a whole body."""

from __future__ import annotations

import dataclasses
from collections.abc import Callable, Iterator
from dataclasses import dataclass, field
from typing import Any

import numpy as np

from ..geometry.bulk import Spheres
from ..geometry.cell import PLAIN_UV, UV, All, Any_, Cell, Face, Not, PolygonSheet, SurfaceSheet, Tree
from ..geometry.csg import Boolean, ClippedSheet, Complement, Difference, Painted, Union
from ..geometry.shape import Primitive, PrimitiveSheet, PrimitiveSolid, Shape, Sheet, Solid
from ..geometry.surface import QuadricSurface
from ..geometry.transform import IDENTITY_MOTION, FloatRows, Motion
from ..kernels.bvh.culling_constants import BOUNDS, WALL
from ..kernels.tables import CELL, REGION, Floats
from ..materials.material import Material
from ..numerics import bigfloat_linalg as ex
from .assembly import Assembly, SurfaceRecord, round_numbers, rounding_rests
from .pattern import BodyPattern

EMPTY_BOX = np.array([np.inf] * 3 + [-np.inf] * 3)


@dataclass(frozen=True, eq=False)
class MapRow:
    """The four numbers of a row of a map to uv, from coordinates of the world."""

    numbers: tuple[float, ...]
    made_of: tuple[object, ...] = ()
    """What it was known by, which is held as long as it."""


_NO_MAP = MapRow((0.0, 0.0, 0.0, 0.0))
"""Of numbers that no face has."""


@dataclass
class BodyFaces:
    """The uv maps of a body's faces, in the order of their numbers, and boxes around its cells."""

    rows: list[tuple[bool, tuple[MapRow, ...]]] = field(default_factory=list)
    """(is u an angle, the rows of the map from world coordinates: three for an angle, else two) of each face."""
    paints: dict[int, Material] = field(default_factory=dict)
    """Material of a face, where it is not the body's."""
    primitives: list[tuple[PrimitiveSolid, Motion, Tree]] = field(default_factory=list)
    _known: dict[tuple[int, int, int], MapRow] = field(default_factory=dict)

    def bounds(self) -> dict[int, tuple[float, ...]]:
        """id of a cell -> low, high: outside of them the cell does not matter to its body."""
        boxes: dict[int, tuple[float, ...]] = {}
        for solid, outer, tree in self.primitives:
            box = tuple(widen_boxes(np.array(solid.bounds_under(outer)).reshape(1, 6))[0].tolist())
            boxes.update((id(cell), box) for cell in cullable_cells(tree))
        return boxes

    def put(self, number: int, uv: UV, motion: Motion) -> None:
        """Set the uv map of a face, by a number within the body; `motion` carries its coordinates to the world."""
        while len(self.rows) <= number:
            self.rows.append((False, (_NO_MAP, _NO_MAP)))
        own = uv.matrix if uv.angular else uv.matrix[:2]
        self.rows[number] = uv.angular, tuple(self._in_world(row, motion) for row in own)

    def maps(self) -> tuple[list[tuple[float, ...]], list[tuple[int, int, int]]]:
        """Each row of the maps once, and for each face which rows are its own; of a flat one the third is its first.

        Rows are one where shapes make them once, for several faces, and not where numbers happen to agree: so how many
        a body has is told by how it is built.
        """
        places: dict[int, int] = {}
        distinct: list[tuple[float, ...]] = []
        for _, rows in self.rows:
            for row in rows:
                if places.setdefault(id(row), len(distinct)) == len(distinct):
                    distinct.append(row.numbers)
        return distinct, [(*(places[id(row)] for row in (*rows, rows[0])[:3]),) for _, rows in self.rows]  # type: ignore[misc]

    def _in_world(self, own: tuple[float, float, float, float], motion: Motion) -> MapRow:
        """A row of a map after the motion is undone: the same object for the same row and motion of one primitive.

        Of one primitive, as two are two even where they are one object that is used twice.
        """
        key = len(self.primitives), id(own), id(motion)
        if key not in self._known:
            self._known[key] = MapRow(_compose_maps(own, motion.inverse_rows), (own, motion))
        return self._known[key]


def _compose_maps(own: tuple[float, float, float, float], then: FloatRows) -> tuple[float, ...]:
    """A row of an affine map after another map; the sums are those of a product of 4 × 4 matrices."""
    (a, b, c, d), last = own, (0.0, 0.0, 0.0, 1.0)
    return tuple(((a * then[0][k] + b * then[1][k]) + c * then[2][k]) + d * last[k] for k in range(4))


def world_tree(solid: Solid, outer: Motion, faces: BodyFaces) -> Tree:
    """The tree of a solid moved by `outer`; its faces take the next numbers."""
    results: list[Tree] = []
    pending: list[tuple[Solid, Motion, int]] = [(solid, outer, -1)]
    while pending:
        node, motion, first_face = pending.pop()
        if isinstance(node, PrimitiveSolid):
            tree = _move_tree(node.tree(), node.under(motion), faces, len(faces.rows))
            faces.primitives.append((node, motion, tree))
            results.append(tree)
        elif not isinstance(node, Boolean):
            raise TypeError(f"{type(node).__name__} cannot be part of a Boolean combination")
        elif first_face >= 0:
            parts = results[-len(node.operands) :]
            del results[-len(node.operands) :]
            results.append(combine_trees(type(node), parts))
            if isinstance(node, Painted):
                for face in range(first_face, len(faces.rows)):
                    faces.paints.setdefault(face, node.material)
        else:
            pending.append((node, motion, len(faces.rows)))
            inner = node.motion.then(motion)
            pending.extend((part, inner, -1) for part in reversed(node.operands))
    return results[0]


def combine_trees(kind: type[Boolean], parts: list[Tree]) -> Tree:
    """The tree of a Boolean node of a kind from those of its operands."""
    if kind is Complement:
        return negate_tree(parts[0])
    if kind is Painted:
        return parts[0]
    if kind is Union:
        return _join_nodes(Any_, parts)
    if kind is Difference:
        return _join_nodes(All, [parts[0], *(negate_tree(part) for part in parts[1:])])
    return _join_nodes(All, parts)


def negate_tree(tree: Tree) -> Tree:
    """The complement of a tree, of which there are never two in a row."""
    return tree.part if isinstance(tree, Not) else Not(tree)


def _join_nodes(kind: type[All] | type[Any_], parts: list[Tree]) -> Tree:
    """One node of a kind, nodes of the same kind among its parts opened up."""
    opened: list[Tree] = []
    for part in parts:
        opened.extend(part.parts if isinstance(part, kind) else (part,))
    return opened[0] if len(opened) == 1 else kind(tuple(opened))


def _move_tree(tree: Tree, motion: Motion, faces: BodyFaces, first: int) -> Tree:
    """A primitive's tree carried to the world, face numbers raised by `first`."""
    if isinstance(tree, Cell):
        moved = []
        for face in tree.faces:
            number = first + face.number
            faces.put(number, face.uv, motion)
            moved.append(dataclasses.replace(face, surface=face.surface.moved(motion), number=number))
        return Cell(tuple(moved))
    if isinstance(tree, Not):
        return negate_tree(_move_tree(tree.part, motion, faces, first))
    return _join_nodes(type(tree), [_move_tree(part, motion, faces, first) for part in tree.parts])


def cullable_cells(tree: Tree) -> list[Cell]:
    """All cells of a primitive, which may be culled where a ray misses the primitive's box.

    None where its tree has a complement: it might be inside although all of its cells are not.
    """
    found, pending = [], [tree]
    while pending:
        part = pending.pop()
        if isinstance(part, Not):
            return []
        if isinstance(part, Cell):
            found.append(part)
        else:
            pending.extend(part.parts)
    return found


def widen_boxes(boxes: Floats) -> Floats:
    """Boxes (n, 6) grown by some ulps; (inf, -inf) where they are empty."""
    low, high = boxes[:, :3], boxes[:, 3:]
    size = np.maximum(np.where(np.isfinite(low), np.abs(low), 0.0), np.where(np.isfinite(high), np.abs(high), 0.0))
    margin = BOUNDS * size + WALL
    grown = np.concatenate([low - margin, high + margin], axis=1)
    return np.where(np.asarray((low > high).any(axis=1))[:, None], EMPTY_BOX, grown)


# What one body alone lowers to, by arithmetic of 3,000 bits. It is kept with the shape, for all scenes with it.


@dataclass(frozen=True)
class LoweredShape:
    """A body's pattern and its row, and what is exact about it."""

    pattern: BodyPattern
    row: list[float]
    paints: dict[int, Material]
    exact: list[Any]
    """Its surfaces, before they were rounded."""
    outlines: list[tuple[ex.Row, ...]]
    """Of its polygons."""
    tree: Tree | None = None
    """Of a solid, the cells with the numbers of their surfaces in place of these."""


def lower_shape(shape: Shape) -> LoweredShape:
    """What a shape lowers to, worked out once."""
    part: LoweredShape = _cache_with_shape(shape, "part", compute_shape)
    return part


def lower_stretched_balls(
    shape: Spheres, centers: Floats, boxes: Floats, back: Floats
) -> tuple[BodyPattern, Floats, list[Any]]:
    """(pattern, rows, exact surfaces) of balls that a motion has made ellipsoids; `back` undoes the motion."""

    def cells(_: Shape) -> tuple[BodyPattern, Floats, list[Any]]:
        """Of all balls."""
        rows, exact = [], []
        turned = tuple(tuple(float(x) for x in row) for row in back)
        for center, radius, box in zip(centers.tolist(), shape.radii.tolist(), boxes.tolist(), strict=True):
            surface = QuadricSurface((1.0, 1.0, 1.0), constant=radius * radius, rows=turned, anchor=tuple(center))  # type: ignore[arg-type]
            assembly = Assembly()
            assembly.cell(Cell((Face(surface, 0),)))
            rows.append([*surface_numbers(assembly), *box])
            exact.append(surface)
        return BodyPattern.of(assembly, CELL, 0, (), (), framed=False), np.array(rows), exact

    found: tuple[BodyPattern, Floats, list[Any]] = _cache_with_shape(shape, "balls", cells)
    return found


def _cache_with_shape(shape: Shape, name: str, work: Callable[[Shape], Any]) -> Any:
    """What `work` makes of a shape, kept with the shape under a name."""
    found = shape.kept.get(name)
    if found is None:
        try:
            found = work(shape)
        except OverflowError:
            raise ValueError(
                f"{type(shape).__name__}: sizes must be below about 1e150, their squares overflow float64"
            ) from None
        shape.kept[name] = found
    return found


def surface_numbers(assembly: Assembly) -> list[float]:
    """The numbers of its surfaces, in the order of a row."""
    return [
        number
        for record in assembly.surfaces
        if isinstance(record, SurfaceRecord)
        for number in (*record.numbers, *record.rests, record.sense)
    ]  # fmt: skip


def compute_shape(shape: Shape) -> LoweredShape:
    """`part_of`, computed."""
    assembly, faces = Assembly(), BodyFaces()
    if isinstance(shape, Solid):
        tree = world_tree(shape, IDENTITY_MOTION, faces)
        if isinstance(tree, Cell):
            kind, index = CELL, assembly.cell(tree)
        else:
            kind, index = REGION, assembly.program(tree, faces.bounds())
    elif isinstance(shape, Sheet):
        sheet, clip = _world_sheet(shape, IDENTITY_MOTION, faces)
        kind, index = assembly.sheet(sheet, -1 if clip is None else assembly.program(clip, {}))
    else:
        raise TypeError(f"{type(shape).__name__} is neither a solid nor a sheet")
    corners = [number for outline in assembly.outlines for point in outline for number in round_numbers(point)]
    lost = [number for outline in assembly.outlines for point in outline for number in rounding_rests(point)]
    map_rows, maps = faces.maps()
    row = [
        *surface_numbers(assembly),
        *(number for numbers in map_rows for number in numbers),
        *(number for box in assembly.leaf_bounds for number in box),
        *_box(shape),
        *(number for line in own_frame(shape).inverse_rows for number in line),
        *corners,
        *lost,
    ]
    pattern = BodyPattern.of(assembly, kind, index, [angular for angular, _ in faces.rows], maps)
    numbered = _number_surfaces(tree, iter(range(len(assembly.surfaces)))) if isinstance(shape, Solid) else None
    return LoweredShape(pattern, row, faces.paints, assembly.exact, assembly.outlines, numbered)


def _number_surfaces(tree: Tree, numbers: Iterator[int]) -> Tree:
    """A tree with numbers for its surfaces, in the order in which an `Assembly` takes them; no maps of uv."""
    if isinstance(tree, Cell):
        return Cell(tuple(Face(next(numbers), face.number, PLAIN_UV, face.inside) for face in tree.faces))  # type: ignore[arg-type]
    if isinstance(tree, Not):
        return Not(_number_surfaces(tree.part, numbers))
    return type(tree)(tuple(_number_surfaces(part, numbers) for part in tree.parts))


def _box(shape: Shape) -> list[float]:
    """The bounds of a shape as six numbers."""
    if isinstance(shape, Primitive) and type(shape).bounds_under is Primitive.bounds_under:
        return shape.ends(shape.under())
    low, high = shape.bounds
    return [*low.tolist(), *high.tolist()]


def own_frame(shape: Shape) -> Motion:
    """The motion from the frame of `hits.local_point` to the world."""
    return own_frame(shape.base).then(shape.motion) if isinstance(shape, ClippedSheet) else shape.under()


def _world_sheet(sheet: Any, outer: Motion, faces: BodyFaces) -> tuple[SurfaceSheet | PolygonSheet, Tree | None]:
    """The sheet itself, in the world, and everything that clips it."""
    if isinstance(sheet, ClippedSheet):
        motion = sheet.motion.then(outer)
        base, clip = _world_sheet(sheet.base, motion, faces)
        cut = world_tree(sheet.solid, motion, BodyFaces())
        cut = cut if sheet.keep == "inside" else negate_tree(cut)
        return base, cut if clip is None else All((clip, cut))
    if not isinstance(sheet, PrimitiveSheet):
        raise TypeError(f"{type(sheet).__name__} is not a sheet that can be traced")
    result = sheet.sheet(sheet.under(outer))
    faces.put(0, result.uv, IDENTITY_MOTION)
    return result, getattr(result, "clip", None)
