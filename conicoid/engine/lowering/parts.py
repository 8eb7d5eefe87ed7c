"""What one body alone lowers to. It is kept with the shape, so scenes that share a shape share the work."""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import dataclass
from typing import Any

import numpy as np

from ...shapes.base import PrimitiveSheet, Shape, Sheet, Solid
from ...shapes.cells import All, Cell, Face, PolygonSheet, SurfaceSheet, Tree
from ...shapes.material import Material
from ...shapes.motion import STILL, Motion
from ...shapes.region import ClippedSheet
from ...shapes.spheres import Spheres
from ...shapes.surface import QuadricSurface
from ...shapes.vector import Box
from ..tables import CELL, POLYGON, REGION, SHEET, Floats
from .assembly import Assembly
from .trees import Faces, negation, world_tree


@dataclass(frozen=True)
class Part:
    """A body's own columns, numbered from 0, and the entry that it becomes."""

    assembly: Assembly
    kind: int
    index: int
    box: Box
    faces: list[Floats]
    paints: dict[int, Material]
    frame: Floats  # (3, 4) world to own coordinates

    def put(self, assembly: Assembly) -> int:
        """Append to the scene's columns; the index that its entry has there."""
        programs, sheets, polygons = len(assembly.program_leaf) - 1, len(assembly.sheets), len(assembly.polygons)
        first = {CELL: len(assembly.cells), REGION: programs, SHEET: sheets, POLYGON: polygons}[self.kind]
        assembly.append(self.assembly)
        return first + self.index


def part_of(shape: Shape) -> Part:
    """What a shape lowers to, worked out once."""
    part: Part = _kept(shape, "part", _part)
    return part


def stretched_balls(shape: Spheres, centers: Floats, back: Floats) -> Assembly:
    """The cells of balls that a motion has made ellipsoids, worked out once; `back` undoes the motion."""

    def cells(_: Shape) -> Assembly:
        """The cells of all balls."""
        assembly = Assembly()
        rows = tuple(tuple(float(x) for x in row) for row in back)
        for center, radius in zip(centers.tolist(), shape.radii.tolist(), strict=True):
            surface = QuadricSurface((1.0, 1.0, 1.0), constant=radius * radius, rows=rows, anchor=tuple(center))  # type: ignore[arg-type]
            assembly.cell(Cell((Face(surface, 0),)))
        return assembly

    assembly: Assembly = _kept(shape, "balls", cells)
    return assembly


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


def _part(shape: Shape) -> Part:
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
    frame = own_frame(shape).inverse_matrix[:3]
    return Part(assembly, kind, index, shape.bounds, faces.rows, faces.paints, frame)


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
    faces.put(0, result.uv, np.eye(4))
    return result, getattr(result, "clip", None)
