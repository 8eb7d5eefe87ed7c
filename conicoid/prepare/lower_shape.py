"""Lower one shape: from the shape to a Boolean tree of cells in the world, and to the pattern and row of its body.

The faces of a body are numbered through all its primitives. Arithmetic has 3,000 bits, and the result is cached with
the shape.
"""

from __future__ import annotations

import dataclasses
import itertools
import operator
from collections.abc import Callable, Mapping, Sequence
from dataclasses import field
from functools import cached_property
from typing import Any

import numpy as np

from .._util.records import dataclass
from ..geometry.bulk import Spheres
from ..geometry.cell import (
    PLAIN_UV,
    UV,
    All,
    Any_,
    Cell,
    Face,
    Not,
    PolygonSheet,
    SurfaceSheet,
    Tree,
    join_trees,
    map_faces,
    negate_tree,
)
from ..geometry.shape import (
    Boolean,
    ClippedSheet,
    Complement,
    Difference,
    Painted,
    Primitive,
    PrimitiveSheet,
    PrimitiveSolid,
    Shape,
    Sheet,
    Solid,
    Union,
)
from ..geometry.surface import QuadricSurface
from ..geometry.transform import IDENTITY_MOTION, FloatRows, Motion
from ..kernels.bvh.culling_constants import BOUNDS, WALL
from ..kernels.tables import CELL, REGION, Floats
from ..materials.material import Material
from ..numerics import bigfloat as ex
from ..numerics.portable_math import is_finite, portable_max
from .assembly import Assembly, SurfaceRecord, SurfaceSlot, round_numbers, round_surface, rounding_rests
from .csg_plan import EMPTY_BOX, PrimitiveForm, bound_bodies, csg_plan
from .pattern import FRAME_NUMBERS, BodyPattern, RowTable


@dataclass(frozen=True, eq=False)
class MapRow:
    """A row of a uv map from world coordinates: four numbers."""

    numbers: tuple[float, ...]
    made_of: tuple[object, ...] = ()
    """The objects whose ids are its cache key: held, so that their ids stay unique."""


@dataclass
class BodyFaces:
    """The uv maps of a body's faces, in the order of their numbers, and boxes around its cells."""

    rows: list[tuple[bool, tuple[MapRow, ...]]] = field(default_factory=list)
    """For each face (is u an angle, rows of the map from world coordinates: three for an angle, else two)."""
    paints: dict[int, Material] = field(default_factory=dict)
    """Face -> material, where it is not the body's."""
    primitives: list[tuple[PrimitiveSolid, Motion, Tree]] = field(default_factory=list)
    _cache: dict[tuple[int, int, int], MapRow] = field(default_factory=dict)

    def bounds(self) -> dict[int, tuple[float, ...]]:
        """Map the id of a cell to its box (low, high): outside the box the cell does not matter to its body."""
        boxes: dict[int, tuple[float, ...]] = {}
        for (_, _, tree), own in zip(self.primitives, self.boxes, strict=True):
            box = _widen_box(own.tolist())
            boxes.update((id(cell), box) for cell in cullable_cells(tree))
        return boxes

    @cached_property
    def boxes(self) -> list[Floats]:
        """The boxes of all primitives, to be read when the last of them is there."""
        return [np.concatenate(solid.bounds_under(outer)) for solid, outer, _ in self.primitives]

    def put(self, number: int, uv: UV, motion: Motion) -> None:
        """Set the uv map of a face, by its number in the body; `motion` carries its coordinates to the world."""
        # Faces may arrive in any order. Numbers that no face has share a row, but not with another primitive.
        blank = self._cache.setdefault((len(self.primitives), 0, 0), MapRow((0.0, 0.0, 0.0, 0.0)))
        while len(self.rows) <= number:
            self.rows.append((False, (blank, blank)))
        own = uv.matrix if uv.angular else uv.matrix[:2]
        self.rows[number] = uv.angular, tuple(self._in_world(row, motion) for row in own)

    def put_tree(self, tree: Tree, motion: Motion) -> Tree:
        """Carry a primitive's tree to the world; its faces take the next numbers."""
        first = len(self.rows)

        def moved(face: Face) -> Face:
            self.put(first + face.number, face.uv, motion)
            return dataclasses.replace(face, surface=face.surface.moved(motion), number=first + face.number)

        return map_faces(tree, moved)

    def maps(self) -> tuple[list[tuple[float, ...]], list[tuple[int, int, int]]]:
        """Return the distinct rows of the maps, and for each face its rows; a flat face repeats its first row as third.

        Rows are equal where a shape builds them once for several faces, not where numbers happen to agree: so the
        structure of a body alone decides how many rows it has.
        """
        places: dict[int, int] = {}
        distinct: list[tuple[float, ...]] = []
        for _, rows in self.rows:
            for row in rows:
                # By identity, as the docstring promises: the number of rows is a part of the pattern
                if places.setdefault(id(row), len(distinct)) == len(distinct):
                    distinct.append(row.numbers)
        return distinct, [(*(places[id(row)] for row in (*rows, rows[0])[:3]),) for _, rows in self.rows]  # type: ignore[misc]

    def _in_world(self, own: tuple[float, float, float, float], motion: Motion) -> MapRow:
        """Return a row of a map after the motion is undone: one object for one row and motion of one primitive.

        Two primitives have two rows even where one object is used twice.
        """
        # The ids stay unique because the row holds both objects.
        key = len(self.primitives), id(own), id(motion)
        if key not in self._cache:
            self._cache[key] = MapRow(_compose_maps(own, motion.inverse_rows), (own, motion))
        return self._cache[key]


def _compose_maps(own: tuple[float, float, float, float], then: FloatRows) -> tuple[float, ...]:
    """Compose a row of an affine map with another map; the sums have the order of a product of 4 × 4 matrices."""
    (a, b, c, d), last = own, (0.0, 0.0, 0.0, 1.0)
    return tuple(((a * then[0][k] + b * then[1][k]) + c * then[2][k]) + d * last[k] for k in range(4))


def world_tree(solid: Solid, outer: Motion, faces: BodyFaces) -> Tree:
    """Return the tree of a solid moved by `outer`; its faces take the next numbers of `faces`.

    Raises TypeError for a part that is neither a primitive solid nor a Boolean node.
    """
    results: list[Tree] = []
    # A stack instead of recursion: a union chained from thousands of parts is as deep
    pending: list[tuple[Solid, Motion, int]] = [(solid, outer, -1)]
    while pending:
        node, motion, first_face = pending.pop()
        if isinstance(node, PrimitiveSolid):
            tree = faces.put_tree(node.tree(), node.under(motion))
            faces.primitives.append((node, motion, tree))
            results.append(tree)
        elif not isinstance(node, Boolean):
            raise TypeError(f"{type(node).__name__} cannot be part of a Boolean combination")
        elif first_face >= 0:
            # Second visit of a Boolean node: the trees of its operands are on top of the results.
            parts = results[-len(node.operands) :]
            del results[-len(node.operands) :]
            results.append(combine_trees(type(node), parts))
            if isinstance(node, Painted):
                # setdefault: the innermost paint comes first, and stays
                for face in node.painted_faces(first_face, len(faces.rows)):
                    faces.paints.setdefault(face, node.material)
        else:
            pending.append((node, motion, len(faces.rows)))
            inner = node.motion.then(motion)
            # Reversed, so that the stack yields operands, and numbers of faces, in their order
            pending.extend((part, inner, -1) for part in reversed(node.operands))
    return results[0]


def combine_trees(kind: type[Boolean], parts: list[Tree]) -> Tree:
    """Combine the trees of the operands of a Boolean node."""
    # Trees have no differences: a - b is a and not b
    if kind is Complement:
        return negate_tree(parts[0])
    if kind is Painted:
        return parts[0]
    if kind is Union:
        return join_trees(Any_, parts)
    if kind is Difference:
        return join_trees(All, [parts[0], *(negate_tree(part) for part in parts[1:])])
    return join_trees(All, parts)


def cullable_cells(tree: Tree) -> list[Cell]:
    """List the cells of a primitive that may be culled where a ray misses the primitive's box.

    Empty where its tree has a complement: the ray may be inside the primitive although it is outside all of its cells.
    """
    found, pending = [], [tree]
    while pending:
        part = pending.pop()
        # Outside of a complement is inside of its part, so that a missed box proves nothing
        if isinstance(part, Not):
            return []
        if isinstance(part, Cell):
            found.append(part)
        else:
            pending.extend(part.parts)
    return found


def widen_boxes(boxes: Floats) -> Floats:
    """Widen boxes (n, 6) by some ulps; empty ones become (inf, -inf)."""
    low, high = boxes[:, :3], boxes[:, 3:]
    size = np.maximum(np.where(np.isfinite(low), np.abs(low), 0.0), np.where(np.isfinite(high), np.abs(high), 0.0))
    margin = BOUNDS * size + WALL
    grown = np.concatenate([low - margin, high + margin], axis=1)
    return np.where(np.asarray((low > high).any(axis=1))[:, None], EMPTY_BOX, grown)


def _widen_box(box: Sequence[float]) -> tuple[float, ...]:
    """`widen_boxes` of one box, whose numbers may be recorded."""
    low, high = box[:3], box[3:]
    if any(a > b for a, b in zip(low, high, strict=True)):
        return tuple(EMPTY_BOX.tolist())
    sizes = [portable_max(*(abs(x) if is_finite(x) else 0.0 for x in ends)) for ends in zip(low, high, strict=True)]
    margins = [BOUNDS * size + WALL for size in sizes]
    return (*map(operator.sub, low, margins), *map(operator.add, high, margins))


# One lowered body


@dataclass(frozen=True)
class LoweredShape:
    """The pattern and the row of one body, with its exact surfaces."""

    pattern: BodyPattern
    row: list[float]
    paints: dict[int, Material]
    exact: list[Any]
    """The surfaces before rounding."""
    outlines: list[tuple[ex.Row, ...]]
    """Exact corners of its polygons."""
    tree: Tree | None = None
    """The tree of cells of a solid, with the numbers of surfaces in place of these."""


def lower_shape(shape: Shape) -> LoweredShape:
    """Lower a shape, once: the result is cached with it.

    Parameters
    ----------
    shape : Shape
        A solid or a sheet.

    Returns
    -------
    LoweredShape
        Its pattern and row; exact surfaces, outlines and the materials of its faces.

    Raises
    ------
    TypeError
        For other shapes, and for parts that cannot be combined.
    ValueError
        For sizes whose squares overflow float64.
    """
    return _cache_with_shape(shape, "part", compute_shape)


def lower_stretched_balls(
    shape: Spheres, centers: Floats, boxes: Floats, back: Floats
) -> tuple[BodyPattern, Floats, list[Any]]:
    """Lower balls that a motion turns into ellipsoids: (pattern, rows, exact surfaces); `back` undoes the motion."""

    def cells(_: Shape) -> tuple[BodyPattern, Floats, list[Any]]:
        """Lower all balls."""
        rows, exact = [], []
        turned = tuple(tuple(float(x) for x in row) for row in back)
        for center, radius, box in zip(centers.tolist(), shape.radii.tolist(), boxes.tolist(), strict=True):
            surface = QuadricSurface((1.0, 1.0, 1.0), constant=radius * radius, rows=turned, anchor=tuple(center))  # type: ignore[arg-type]
            assembly = Assembly()
            assembly.cell(Cell((Face(surface, 0),)))
            rows.append([*surface_numbers(assembly), *box])
            exact.append(surface)
        return BodyPattern.of(assembly, CELL, 0, (), (), framed=False), np.array(rows), exact

    return _cache_with_shape(shape, "balls", cells)


def _cache_with_shape(shape: Shape, name: str, work: Callable[[Shape], Any]) -> Any:
    """Return `work(shape)`, cached with the shape under a name; raise ValueError for sizes that overflow."""
    found = shape.cache.get(name)
    if found is None:
        try:
            found = work(shape)
        except OverflowError:
            raise ValueError(
                f"{type(shape).__name__}: sizes must be below about 1e150, their squares overflow float64"
            ) from None
        shape.cache[name] = found
    return found


def surface_numbers(assembly: Assembly) -> list[float]:
    """List the numbers of the surfaces of an assembly, in the order of a row."""
    return [
        number
        for record in assembly.surfaces
        if isinstance(record, SurfaceRecord)
        for number in (*record.numbers, *record.rests, record.sense)
    ]  # fmt: skip


def compute_shape(shape: Shape) -> LoweredShape:
    """`lower_shape` without the cache."""
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
        *_box(shape, faces, assembly),
        *(number for line in own_frame(shape).inverse_rows for number in line),
        *corners,
        *lost,
    ]
    pattern = BodyPattern.of(assembly, kind, index, [angular for angular, _ in faces.rows], maps)
    numbered = number_surfaces(tree) if isinstance(shape, Solid) else None
    return LoweredShape(pattern, row, faces.paints, assembly.exact, assembly.outlines, numbered)


def number_surfaces(tree: Tree) -> Tree:
    """Return a tree with numbers for surfaces, in the order in which an `Assembly` adds them; drop uv maps."""
    numbers = itertools.count()
    return map_faces(tree, lambda face: Face(next(numbers), face.number, PLAIN_UV, face.inside))  # type: ignore[arg-type]


def _box(shape: Shape, faces: BodyFaces, assembly: Assembly) -> list[float]:
    """Return the bounds of a shape as six numbers."""
    if isinstance(shape, Primitive) and type(shape).bounds_under is Primitive.bounds_under:
        return shape.ends(shape.under())
    plan = csg_plan(shape) if isinstance(shape, Boolean) else None
    if plan is not None:
        # As in batches, to the bit
        records = {id(exact): record for exact, record in zip(assembly.exact, assembly.surfaces, strict=True)}
        parts = [_lower_part(faces, part, records) for part in range(len(faces.primitives))]
        leaves = [leaf for leaf, _ in plan.leaves]
        boxes, certain = bound_bodies(plan.key, leaves, [form for form, _ in parts], [rows for _, rows in parts])
        if certain[0]:
            return boxes[0].tolist()
    low, high = shape.bounds
    return [*low.tolist(), *high.tolist()]


def _lower_part(faces: BodyFaces, part: int, records: Mapping[int, Any]) -> tuple[PrimitiveForm, RowTable]:
    """Return the form of a primitive of a body, and a row of its surfaces, its box and its frame, for `bound_bodies`.

    `records` has the records of the body's surfaces, by their ids.
    """
    solid, outer, tree = faces.primitives[part]
    used: list[SurfaceRecord] = []

    def slot(face: Face) -> Face:
        record = records.get(id(face.surface))
        used.append(round_surface(face.surface) if record is None else record)
        return dataclasses.replace(face, surface=SurfaceSlot(used[-1].kind, part, len(used) - 1))  # type: ignore[arg-type]

    own, slots = Assembly(), map_faces(tree, slot)
    kind, index = (CELL, own.cell(slots)) if isinstance(slots, Cell) else (REGION, own.program(slots, {}))
    # `bound_bodies` reads the frames of balls and boxes alone
    framed = solid.bounds_kind in ("ball", "box")
    frame = np.array(solid.under(outer).inverse_rows).ravel() if framed else np.zeros(FRAME_NUMBERS)
    row = np.array([number for record in used for number in (*record.numbers, *record.rests, record.sense)])
    row = np.concatenate([row, faces.boxes[part], frame])
    form = PrimitiveForm(BodyPattern.of(own, kind, index, (), ()), number_surfaces(tree))
    return form, RowTable.of(row[None], np.arange(len(row), dtype=np.int32))


def own_frame(shape: Shape) -> Motion:
    """Return the motion from the frame of `hits.local_point` to the world."""
    return own_frame(shape.base).then(shape.motion) if isinstance(shape, ClippedSheet) else shape.under()


def _world_sheet(sheet: Any, outer: Motion, faces: BodyFaces) -> tuple[SurfaceSheet | PolygonSheet, Tree | None]:
    """Return the sheet itself, in the world, and the tree of everything that clips it."""
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
