"""Shapes to flat arrays: the only bridge between objects and kernels.

Motions are baked here, in exact arithmetic, and every number is rounded once.
"""

from __future__ import annotations

import dataclasses
from collections.abc import Callable, Sequence
from dataclasses import dataclass
from typing import Any

import numpy as np

from ...shapes.body import Body
from ...shapes.exact import Row
from ...shapes.material import Material
from ...shapes.motion import STILL
from ...shapes.spheres import Spheres
from ...shapes.surface import Surface
from ...shapes.vector import FloatArray
from ..tables import BALL, CELL, Floats, Geometry, Ints, Tables, shared
from .assembly import Assembly, Entries, finished_tables
from .parts import part_of, stretched_balls
from .records import rests
from .surfaces import Remainders, end_to_end

_CHUNK = 1 << 13


@dataclass(frozen=True)
class Lowered:
    """A scene as arrays. `tables` become what kernels take."""

    tables: Tables  # without a tree over the entries
    boxes: Floats  # (entries, 6) low, high
    frames: Floats  # (bodies with a frame, 3, 4) world to own coordinates
    body_frame: Ints  # (bodies,) row in frames; -1 - k: about the ball's center, by ball frame k
    body_item: Ints  # (bodies,) which entry of the scene's list a body comes from
    face_paint: dict[int, Material]  # row of a face -> its material, where it is not the body's
    body_count: int
    rest: Remainders  # what rounding took from the records of surfaces
    outlines: list[tuple[Row, ...]]  # of polygons, before they were rounded
    exact: list[Surface]  # what the first surfaces were before they were rounded; the others are bulk balls

    def sharing(self, geometry: Geometry) -> Lowered:
        """The same with tables that share the memory of what was packed from them."""
        return dataclasses.replace(self, tables=shared(self.tables, geometry))


def lower(bodies: Sequence[Body], progress: Callable[[int, int], Any] | None = None) -> Lowered:
    """Flat arrays for a list of bodies; a `Spheres` entry takes one number for each ball.

    progress(done, count) is called after each body.
    """
    assembly, entries = Assembly(), Entries()
    frames: list[Floats] = []
    body_frame, body_item = [], []
    for item, body in enumerate(bodies):
        before = entries.body_count
        if isinstance(body.shape, Spheres):
            _add_spheres(assembly, entries, body.shape)
            frame = np.full(len(body.shape), -len(entries.ball_frames), np.int32)
        else:
            part = part_of(body.shape)
            entries.add(part.kind, part.put(assembly), part.box, part.faces, part.paints)
            frame = np.array([len(frames)], np.int32)
            frames.append(part.frame)
        body_frame.append(frame)
        body_item.append(np.full(entries.body_count - before, item, np.int32))
        if progress is not None:
            progress(item + 1, len(bodies))
    tables, boxes, surfaces = finished_tables(assembly, entries)
    return Lowered(
        tables,
        boxes,
        np.array(frames).reshape(-1, 3, 4),
        end_to_end([np.zeros(0, np.int32), *body_frame]),
        end_to_end([np.zeros(0, np.int32), *body_item]),
        entries.paints,
        entries.body_count,
        dataclasses.replace(surfaces.rest, vertices=_rest_of_outlines(assembly)),
        assembly.outlines,
        surfaces.exact,
    )


def _rest_of_outlines(assembly: Assembly) -> Floats:
    """What rounding took from the corners of polygons, (n, 3)."""
    return np.array([rests(point) for outline in assembly.outlines for point in outline]).reshape(-1, 3)


def _ball_boxes(centers: FloatArray, radii: FloatArray, stretch: FloatArray) -> Floats:
    """(n, 6) around balls whose radius is stretched along each axis; a part at a time, to stay in the cache."""
    boxes = np.empty((len(radii), 6))
    for begin in range(0, len(radii), _CHUNK):
        rows = slice(begin, begin + _CHUNK)
        reach = radii[rows, None] * stretch
        np.nextafter(centers[rows] - reach, -np.inf, out=boxes[rows, :3])
        np.nextafter(centers[rows] + reach, np.inf, out=boxes[rows, 3:])
    return boxes


def _add_spheres(assembly: Assembly, entries: Entries, shape: Spheres) -> None:
    """Balls straight from arrays; ellipsoids where a motion is no similarity."""
    centers, linear, factor = shape.placed(STILL)
    boxes = _ball_boxes(centers, shape.radii, np.sqrt((linear**2).sum(axis=1)))
    back = shape.motion.inverse_matrix[:3, :3]
    entries.ball_frames.append(back.ravel())
    frame = -len(entries.ball_frames)
    if factor is not None:
        balls = np.empty((len(shape), 4))
        balls[:, :3] = centers
        np.multiply(shape.radii, factor, out=balls[:, 3])
        numbers = assembly.surfaces.add_balls(balls)
        entries.add_many(BALL, numbers, boxes, frame)
        return
    first = len(assembly.cells)
    assembly.append(stretched_balls(shape, centers, back))
    entries.add_many(CELL, np.arange(first, len(assembly.cells), dtype=np.int32), boxes, frame)
