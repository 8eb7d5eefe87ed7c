"""What one body alone lowers to, by arithmetic of 3,000 bits. It is kept with the shape, for all scenes with it."""

from __future__ import annotations

from collections.abc import Callable, Iterator
from dataclasses import dataclass
from typing import Any

import numpy as np

from ...shapes import exact as ex
from ...shapes.base import Primitive, PrimitiveSheet, Shape, Sheet, Solid
from ...shapes.cells import PLAIN_UV, All, Cell, Face, Not, PolygonSheet, SurfaceSheet, Tree
from ...shapes.material import Material
from ...shapes.motion import STILL, Motion
from ...shapes.region import ClippedSheet
from ...shapes.spheres import Spheres
from ...shapes.surface import QuadricSurface
from ..tables import CELL, REGION, Floats
from .assembly import Assembly
from .pattern import Pattern
from .records import Record, floats, rests
from .trees import Faces, negation, world_tree


@dataclass(frozen=True)
class Part:
    """A body's pattern and its row, and what is exact about it."""

    pattern: Pattern
    row: list[float]
    paints: dict[int, Material]
    exact: list[Any]
    """Its surfaces, before they were rounded."""
    outlines: list[tuple[ex.Row, ...]]
    """Of its polygons."""
    tree: Tree | None = None
    """Of a solid, the cells with the numbers of their surfaces in place of these."""


def part_of(shape: Shape) -> Part:
    """What a shape lowers to, worked out once."""
    part: Part = _kept(shape, "part", worked_out)
    return part


def stretched_balls(shape: Spheres, centers: Floats, boxes: Floats, back: Floats) -> tuple[Pattern, Floats, list[Any]]:
    """(pattern, rows, exact surfaces) of balls that a motion has made ellipsoids; `back` undoes the motion."""

    def cells(_: Shape) -> tuple[Pattern, Floats, list[Any]]:
        """Of all balls."""
        rows, exact = [], []
        turned = tuple(tuple(float(x) for x in row) for row in back)
        for center, radius, box in zip(centers.tolist(), shape.radii.tolist(), boxes.tolist(), strict=True):
            surface = QuadricSurface((1.0, 1.0, 1.0), constant=radius * radius, rows=turned, anchor=tuple(center))  # type: ignore[arg-type]
            assembly = Assembly()
            assembly.cell(Cell((Face(surface, 0),)))
            rows.append([*numbers_of_surfaces(assembly), *box])
            exact.append(surface)
        return Pattern.of(assembly, CELL, 0, (), (), framed=False), np.array(rows), exact

    found: tuple[Pattern, Floats, list[Any]] = _kept(shape, "balls", cells)
    return found


def _kept(shape: Shape, name: str, work: Callable[[Shape], Any]) -> Any:
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


def numbers_of_surfaces(assembly: Assembly) -> list[float]:
    """The numbers of its surfaces, in the order of a row."""
    return [
        number
        for record in assembly.surfaces
        if isinstance(record, Record)
        for number in (*record.numbers, *record.rests, record.sense)
    ]  # fmt: skip


def worked_out(shape: Shape) -> Part:
    """`part_of`, computed."""
    assembly, faces = Assembly(), Faces()
    if isinstance(shape, Solid):
        tree = world_tree(shape, STILL, faces)
        if isinstance(tree, Cell):
            kind, index = CELL, assembly.cell(tree)
        else:
            kind, index = REGION, assembly.program(tree, faces.bounds())
    elif isinstance(shape, Sheet):
        sheet, clip = _world_sheet(shape, STILL, faces)
        kind, index = assembly.sheet(sheet, -1 if clip is None else assembly.program(clip, {}))
    else:
        raise TypeError(f"{type(shape).__name__} is neither a solid nor a sheet")
    corners = [number for outline in assembly.outlines for point in outline for number in floats(point)]
    lost = [number for outline in assembly.outlines for point in outline for number in rests(point)]
    map_rows, maps = faces.maps()
    row = [
        *numbers_of_surfaces(assembly),
        *(number for numbers in map_rows for number in numbers),
        *(number for box in assembly.leaf_bounds for number in box),
        *_box(shape),
        *(number for line in own_frame(shape).inverse_rows for number in line),
        *corners,
        *lost,
    ]
    pattern = Pattern.of(assembly, kind, index, [angular for angular, _ in faces.rows], maps)
    numbered = _numbered(tree, iter(range(len(assembly.surfaces)))) if isinstance(shape, Solid) else None
    return Part(pattern, row, faces.paints, assembly.exact, assembly.outlines, numbered)


def _numbered(tree: Tree, numbers: Iterator[int]) -> Tree:
    """A tree with numbers for its surfaces, in the order in which an `Assembly` takes them; no maps of uv."""
    if isinstance(tree, Cell):
        return Cell(tuple(Face(next(numbers), face.number, PLAIN_UV, face.inside) for face in tree.faces))  # type: ignore[arg-type]
    if isinstance(tree, Not):
        return Not(_numbered(tree.part, numbers))
    return type(tree)(tuple(_numbered(part, numbers) for part in tree.parts))


def _box(shape: Shape) -> list[float]:
    """The bounds of a shape as six numbers."""
    if isinstance(shape, Primitive) and type(shape).bounds_under is Primitive.bounds_under:
        return shape.ends(shape.under())
    low, high = shape.bounds
    return [*low.tolist(), *high.tolist()]


def own_frame(shape: Shape) -> Motion:
    """The motion from the frame of `hits.local_point` to the world."""
    return own_frame(shape.base).then(shape.motion) if isinstance(shape, ClippedSheet) else shape.under()


def _world_sheet(sheet: Any, outer: Motion, faces: Faces) -> tuple[SurfaceSheet | PolygonSheet, Tree | None]:
    """The sheet itself, in the world, and everything that clips it."""
    if isinstance(sheet, ClippedSheet):
        motion = sheet.motion.then(outer)
        base, clip = _world_sheet(sheet.base, motion, faces)
        cut = world_tree(sheet.solid, motion, Faces())
        cut = cut if sheet.keep == "inside" else negation(cut)
        return base, cut if clip is None else All((clip, cut))
    if not isinstance(sheet, PrimitiveSheet):
        raise TypeError(f"{type(sheet).__name__} is not a sheet that can be traced")
    result = sheet.sheet(sheet.under(outer))
    faces.put(0, result.uv, STILL)
    return result, getattr(result, "clip", None)
