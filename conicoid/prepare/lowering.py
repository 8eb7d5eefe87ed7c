"""Lower a list of bodies to a `LoweredScene`: flat tables, without trees and limits.

This module is the only bridge between shapes (objects) and kernels (arrays). Motions are applied here, in exact
arithmetic, and every number is rounded to float64 once.
"""

from __future__ import annotations

import dataclasses
from collections.abc import Sequence
from functools import cached_property
from typing import Any

import numpy as np

from .._util.records import dataclass
from ..geometry.body import Body
from ..geometry.instances import InstanceList
from ..geometry.shape import Shape
from ..kernels.tables import Floats, Geometry, Ints, Longs, Tables, unpack_tables
from ..materials.material import Material
from .body_collector import BodyCollector, ExactBodySurfaces, ShapeSource
from .coincidence import SurfaceTable
from .error_limits import with_limits
from .mmap_arrays import mapped_zeros, trim_heap
from .pattern import BOX_NUMBERS, BodyGroup, FactoredRows, Offsets, put_shifted_boxes
from .progress import AFTER_LAYOUT, AFTER_MERGING, ProgressStages
from .row_layout import RowLayout
from .surface_features import Remainders
from .tables_builder import TablesBuilder


@dataclass(frozen=True)
class LazyBounds:
    """Bounding boxes of the bodies of a scene with instances, computed on demand.

    For each group of translated copies only the box of the first body is stored; for a group that was lowered body by
    body, the boxes of all. A scene releases the boxes once it is prepared, and recomputes them when they are needed
    again.
    """

    bodies: InstanceList
    groups: Sequence[tuple[Ints, Floats]]  # body numbers, and their boxes: (6,) of the first, or (bodies, 6)

    @classmethod
    def of(cls, bodies: InstanceList, groups: Sequence[BodyGroup], boxes: Floats) -> LazyBounds:
        """Store the bounds of the bodies of these groups; `boxes` (bodies, 6) are known and cached."""
        parts = []
        for group in groups:
            at, rows = group.pattern.box_at, group.rows
            known = rows.base[at : at + BOX_NUMBERS] if isinstance(rows, FactoredRows) else boxes[group.bodies]
            parts.append((group.bodies, known))
        lazy = cls(bodies, parts)
        vars(lazy)["boxes"] = boxes
        return lazy

    @cached_property
    def boxes(self) -> Floats:
        """Low and high corners, (bodies, 6): the same bits as when the scene was lowered."""
        boxes = mapped_zeros((len(self.bodies), BOX_NUMBERS), np.float64)
        for numbers, known in self.groups:
            if known.ndim > 1:
                boxes[numbers] = known
            else:
                put_shifted_boxes(known, numbers, Offsets.among(self.bodies, numbers), boxes)
        return boxes

    def release(self) -> None:
        """Release the cached boxes."""
        vars(self).pop("boxes", None)


# Lowered scenes


@dataclass(frozen=True)
class LoweredScene:
    """A scene as arrays. `build_scene_trees` turns `tables` into the geometry that kernels take."""

    tables: Tables  # without trees and limits until they are packed
    bounds: Floats | LazyBounds  # (entries, 6) low, high; or their lazy form, see `boxes`
    frames: Floats  # (n, 3, 4) maps from world to local coordinates
    body_frame: Ints  # (bodies,) row of `frames`; -1 - k: about the ball's center, with the axes of ball frame k
    body_item: Ints  # (bodies,) index of the entry of the scene's list that the body comes from
    face_paint: dict[int, Material]  # row of a face -> its material, where it differs from the body's
    body_count: int
    rest: Remainders  # what rounding removed from the surface records
    exact: ExactTables
    # None for scenes with instances, which are not edited
    layout: RowLayout | None

    @property
    def boxes(self) -> Floats:
        """Bounding boxes of the entries, (entries, 6) low and high."""
        return self.bounds.boxes if isinstance(self.bounds, LazyBounds) else self.bounds

    def take_tables(self) -> Tables:
        """Hand over the tables and keep their shapes alone, so that the packer can free each one once it is copied."""
        tables = self.tables
        empty: list[Any] = [np.broadcast_to(column.dtype.type(), column.shape) for column in tables]
        object.__setattr__(self, "tables", Tables(*empty))
        return tables

    def limited(self) -> LoweredScene:
        """Return this scene with the limits of its tables filled in."""
        return dataclasses.replace(self, tables=with_limits(self.tables, self.boxes, self.rest))

    def with_geometry(self, geometry: Geometry) -> LoweredScene:
        """Return this scene with tables that are views of a geometry packed from them."""
        return dataclasses.replace(self, tables=unpack_tables(self.tables, geometry))


@dataclass(frozen=True)
class ExactTables:
    """The exact surfaces behind the rows of the tables. The last surfaces, bulk balls, have none."""

    bodies: ExactBodySurfaces
    single: Longs  # (surfaces,) the number of each among the surfaces that the bodies came with

    def __len__(self) -> int:
        return len(self.single)

    def __getitem__(self, surface: int) -> Any:
        """Return the exact surface of a row of the table."""
        return self.bodies[int(self.single[surface])]

    def outline(self, polygon: int) -> Any:
        """Return the exact corners of a polygon."""
        return self.bodies.outline(polygon)


def lower(bodies: Sequence[Body], stages: ProgressStages | None = None) -> LoweredScene:
    """Lower bodies to flat arrays, without trees and limits.

    Parameters
    ----------
    bodies : Sequence[Body]
        The entries of a scene. A `Spheres` entry, or another bulk entry, takes one body number for each of its bodies.
    stages : ProgressStages, optional
        Receives the progress.

    Returns
    -------
    LoweredScene
        The tables, the boxes of the bodies, their frames, and the exact surfaces on demand.
    """
    stages, collected = stages or ProgressStages(None, 0), BodyCollector()
    collected.collect(bodies, stages)
    layout, count = TablesBuilder(collected.contents), collected.contents.body_count
    counts = np.array(collected.items, np.int32)
    starts = None if isinstance(bodies, InstanceList) else (np.cumsum(counts) - counts).astype(np.int32)
    trim_heap(count)
    exact = ExactBodySurfaces(_shapes(bodies), starts, layout.surfaces.first, layout.polygons.first)
    surfaces: SurfaceTable = layout.surface_columns(exact)
    trim_heap(count)
    stages.advance(AFTER_MERGING)
    tables, boxes = layout.tables(surfaces)
    stages.advance(AFTER_LAYOUT)
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
        dataclasses.replace(surfaces.rest, vertices=layout.corner_numbers(1)),
        ExactTables(exact, surfaces.single),
        None
        if isinstance(bodies, InstanceList)
        else RowLayout.of(collected.contents, collected.items, collected.frames, surfaces),
    )


class InstanceShapes:
    """The shapes of instances, which the list builds on demand; `pending` are those that an edit has yet to change."""

    def __init__(self, bodies: InstanceList, pending: dict[int, Shape] | None = None) -> None:
        self._bodies, self.pending = bodies, pending or {}

    def __getitem__(self, number: int) -> Shape:
        return self.pending[number] if number in self.pending else self._bodies.shape(number)


def _shapes(bodies: Sequence[Body]) -> ShapeSource:
    """Return a source of the shape of each entry."""
    return InstanceShapes(bodies) if isinstance(bodies, InstanceList) else [body.shape for body in bodies]
