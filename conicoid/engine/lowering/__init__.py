"""Shapes to flat arrays: the only bridge between objects and kernels.

Motions are baked here, in exact arithmetic, and every number is rounded once.
"""

from __future__ import annotations

import dataclasses
from collections.abc import Sequence
from dataclasses import dataclass
from typing import Any

import numpy as np

from ...shapes.base import Shape
from ...shapes.body import Body
from ...shapes.material import Material
from ...shapes.repeated import Repeated
from ..tables import Floats, Geometry, Ints, Longs, Tables, shared
from .apart import give_back_of
from .around import Around
from .contents import Collected, Exact, Shapes
from .laid import Laid
from .layout import Layout
from .limits import with_limits
from .stages import LAID, MERGED, Stages
from .surfaces import Remainders, SurfaceArrays


@dataclass(frozen=True)
class Lowered:
    """A scene as arrays. `tables` become what kernels take."""

    tables: Tables  # without trees and limits, until they are packed
    around: Floats | Around  # (entries, 6) low, high; or what these are worked out from, see `boxes`
    frames: Floats  # (n, 3, 4) world to own coordinates
    body_frame: Ints  # (bodies,) row in frames; -1 - k: about the ball's center, by ball frame k
    body_item: Ints  # (bodies,) which entry of the scene's list a body comes from
    face_paint: dict[int, Material]  # row of a face -> its material, where it is not the body's
    body_count: int
    rest: Remainders  # what rounding took from the records of surfaces
    exact: ExactTables
    laid: Laid | None

    @property
    def boxes(self) -> Floats:
        """(entries, 6) low, high of the boxes around entries."""
        return self.around.boxes if isinstance(self.around, Around) else self.around

    def taken(self) -> Tables:
        """Its tables, of which it keeps the shapes alone: whoever packs them frees each as soon as it is copied."""
        tables = self.tables
        empty: list[Any] = [np.broadcast_to(column.dtype.type(), column.shape) for column in tables]
        object.__setattr__(self, "tables", Tables(*empty))
        return tables

    def limited(self) -> Lowered:
        """The same with limits."""
        return dataclasses.replace(self, tables=with_limits(self.tables, self.boxes, self.rest))

    def sharing(self, geometry: Geometry) -> Lowered:
        """The same with tables that share the memory of what was packed from them."""
        return dataclasses.replace(self, tables=shared(self.tables, geometry))


@dataclass(frozen=True)
class ExactTables:
    """What tables were before they were rounded, by the numbers of tables. The last surfaces, bulk balls, have none."""

    bodies: Exact
    single: Longs  # of a surface, which it was among those of the bodies

    def __len__(self) -> int:
        return len(self.single)

    def __getitem__(self, surface: int) -> Any:
        """A surface of the table."""
        return self.bodies[int(self.single[surface])]

    def outline(self, polygon: int) -> Any:
        """The corners of a polygon."""
        return self.bodies.outline(polygon)


def lower(bodies: Sequence[Body], stages: Stages | None = None) -> Lowered:
    """Flat arrays for a list of bodies, without trees and limits; a `Spheres` entry takes one number for each ball."""
    stages, collected = stages or Stages(None, 0), Collected()
    collected.collect(bodies, stages)
    layout, count = Layout(collected.contents), collected.contents.body_count
    counts = np.array(collected.items, np.int32)
    starts = None if isinstance(bodies, Repeated) else (np.cumsum(counts) - counts).astype(np.int32)
    give_back_of(count)
    exact = Exact(_shapes(bodies), starts, layout.surfaces.first, layout.polygons.first)
    surfaces: SurfaceArrays = layout.surface_columns(exact)
    give_back_of(count)
    stages.reached(MERGED)
    tables, boxes = layout.tables(surfaces)
    stages.reached(LAID)
    first_face = layout.faces.first
    frames, body_frame = layout.frames_of_bodies()
    return Lowered(
        tables,
        Around.of(bodies, collected.contents.groups, boxes) if isinstance(bodies, Repeated) else boxes,
        frames,
        body_frame,
        np.repeat(np.arange(len(bodies), dtype=np.int32), counts),
        {int(first_face[body]) + face: one for body, faces in collected.paints.items() for face, one in faces.items()},
        collected.contents.body_count,
        dataclasses.replace(surfaces.rest, vertices=layout.lost_of_corners()),
        ExactTables(exact, surfaces.single),
        None
        if isinstance(bodies, Repeated)
        else Laid.of(collected.contents, collected.items, collected.frames, surfaces),
    )


class _Shapes:
    """The shapes of bodies that are made when they are asked for."""

    def __init__(self, bodies: Repeated) -> None:
        self._bodies = bodies

    def __getitem__(self, number: int) -> Shape:
        return self._bodies.shape(number)


def _shapes(bodies: Sequence[Body]) -> Shapes:
    """The shape of each body."""
    return _Shapes(bodies) if isinstance(bodies, Repeated) else [body.shape for body in bodies]
