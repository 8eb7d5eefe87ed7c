"""Boxes around bodies that are one another moved: they are let go once a scene is prepared, and made when asked for."""

from __future__ import annotations

import dataclasses
from collections.abc import Sequence
from dataclasses import dataclass
from functools import cached_property
from typing import Any

import numpy as np

from ..geometry.body import Body
from ..geometry.instances import InstanceList
from ..geometry.shape import Shape
from ..kernels.tables import Floats, Geometry, Ints, Longs, Tables, unpack_tables
from ..materials.material import Material
from .body_collector import BodyCollector, ExactBodySurfaces, ShapeSource
from .coincidence import Remainders, SurfaceTable
from .error_limits import with_limits
from .mmap_arrays import mapped_zeros, trim_heap
from .pattern import BOX_NUMBERS, BodyGroup, FactoredRows, Offsets, row_blocks, shift_boxes
from .progress import AFTER_LAYOUT, AFTER_MERGING, ProgressStages
from .row_layout import RowLayout
from .tables_builder import TablesBuilder


@dataclass(frozen=True)
class LazyBounds:
    """Of each group of bodies the box of the first, or those of all where they were lowered one by one."""

    bodies: InstanceList
    groups: Sequence[tuple[Ints, Floats]]  # numbers of bodies, and (6,) or (bodies, 6)

    @classmethod
    def of(cls, bodies: InstanceList, groups: Sequence[BodyGroup], boxes: Floats) -> LazyBounds:
        """Of bodies that are in these groups, whose boxes are known."""
        parts = []
        for group in groups:
            at, rows = group.pattern.box_at, group.rows
            known = rows.base[at : at + BOX_NUMBERS] if isinstance(rows, FactoredRows) else boxes[group.bodies]
            parts.append((group.bodies, known))
        around = cls(bodies, parts)
        vars(around)["boxes"] = boxes
        return around

    @cached_property
    def boxes(self) -> Floats:
        """(bodies, 6) low, high: to the bit those that they had when the scene was lowered."""
        boxes = mapped_zeros((len(self.bodies), BOX_NUMBERS), np.float64)
        for numbers, known in self.groups:
            if known.ndim > 1:
                boxes[numbers] = known
                continue
            away = Offsets.among(self.bodies, numbers)
            for some in row_blocks(len(numbers)):
                boxes[numbers[some]] = shift_boxes(known, away[some])
        return boxes

    def let_go(self) -> None:
        """Keep the boxes no longer."""
        vars(self).pop("boxes", None)


# Shapes to flat arrays: the only bridge between objects and kernels.
#
# Motions are baked here, in exact arithmetic, and every number is rounded once.


@dataclass(frozen=True)
class LoweredScene:
    """A scene as arrays. `tables` become what kernels take."""

    tables: Tables  # without trees and limits, until they are packed
    around: Floats | LazyBounds  # (entries, 6) low, high; or what these are worked out from, see `boxes`
    frames: Floats  # (n, 3, 4) world to own coordinates
    body_frame: Ints  # (bodies,) row in frames; -1 - k: about the ball's center, by ball frame k
    body_item: Ints  # (bodies,) which entry of the scene's list a body comes from
    face_paint: dict[int, Material]  # row of a face -> its material, where it is not the body's
    body_count: int
    rest: Remainders  # what rounding took from the records of surfaces
    exact: ExactTables
    laid: RowLayout | None

    @property
    def boxes(self) -> Floats:
        """(entries, 6) low, high of the boxes around entries."""
        return self.around.boxes if isinstance(self.around, LazyBounds) else self.around

    def taken(self) -> Tables:
        """Its tables, of which it keeps the shapes alone: whoever packs them frees each as soon as it is copied."""
        tables = self.tables
        empty: list[Any] = [np.broadcast_to(column.dtype.type(), column.shape) for column in tables]
        object.__setattr__(self, "tables", Tables(*empty))
        return tables

    def limited(self) -> LoweredScene:
        """The same with limits."""
        return dataclasses.replace(self, tables=with_limits(self.tables, self.boxes, self.rest))

    def sharing(self, geometry: Geometry) -> LoweredScene:
        """The same with tables that share the memory of what was packed from them."""
        return dataclasses.replace(self, tables=unpack_tables(self.tables, geometry))


@dataclass(frozen=True)
class ExactTables:
    """What tables were before they were rounded, by the numbers of tables. The last surfaces, bulk balls, have none."""

    bodies: ExactBodySurfaces
    single: Longs  # of a surface, which it was among those of the bodies

    def __len__(self) -> int:
        return len(self.single)

    def __getitem__(self, surface: int) -> Any:
        """A surface of the table."""
        return self.bodies[int(self.single[surface])]

    def outline(self, polygon: int) -> Any:
        """The corners of a polygon."""
        return self.bodies.outline(polygon)


def lower(bodies: Sequence[Body], stages: ProgressStages | None = None) -> LoweredScene:
    """Flat arrays for a list of bodies, without trees and limits; a `Spheres` entry takes one number for each ball."""
    stages, collected = stages or ProgressStages(None, 0), BodyCollector()
    collected.collect(bodies, stages)
    layout, count = TablesBuilder(collected.contents), collected.contents.body_count
    counts = np.array(collected.items, np.int32)
    starts = None if isinstance(bodies, InstanceList) else (np.cumsum(counts) - counts).astype(np.int32)
    trim_heap(count)
    exact = ExactBodySurfaces(_shapes(bodies), starts, layout.surfaces.first, layout.polygons.first)
    surfaces: SurfaceTable = layout.surface_columns(exact)
    trim_heap(count)
    stages.reached(AFTER_MERGING)
    tables, boxes = layout.tables(surfaces)
    stages.reached(AFTER_LAYOUT)
    first_face = layout.faces.first
    frames, body_frame = layout.frames_of_bodies()
    return LoweredScene(
        tables,
        LazyBounds.of(bodies, collected.contents.groups, boxes) if isinstance(bodies, InstanceList) else boxes,
        frames,
        body_frame,
        np.repeat(np.arange(len(bodies), dtype=np.int32), counts),
        {int(first_face[body]) + face: one for body, faces in collected.paints.items() for face, one in faces.items()},
        collected.contents.body_count,
        dataclasses.replace(surfaces.rest, vertices=layout.lost_of_corners()),
        ExactTables(exact, surfaces.single),
        None
        if isinstance(bodies, InstanceList)
        else RowLayout.of(collected.contents, collected.items, collected.frames, surfaces),
    )


class _InstanceShapes:
    """The shapes of bodies that are made when they are asked for."""

    def __init__(self, bodies: InstanceList) -> None:
        self._bodies = bodies

    def __getitem__(self, number: int) -> Shape:
        return self._bodies.shape(number)


def _shapes(bodies: Sequence[Body]) -> ShapeSource:
    """The shape of each body."""
    return _InstanceShapes(bodies) if isinstance(bodies, InstanceList) else [body.shape for body in bodies]
