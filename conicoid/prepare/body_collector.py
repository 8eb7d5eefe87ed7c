"""What the bodies of a scene become: groups of like bodies with their numbers. What is exact is there on demand."""

from __future__ import annotations

from collections.abc import Hashable, Sequence
from functools import cache
from typing import Any, Protocol

import numpy as np

from .._util.arrays import FloatArray
from ..geometry.body import Body
from ..geometry.bulk import Bulk, Spheres
from ..geometry.instances import InstanceList
from ..geometry.shape import Shape
from ..geometry.surface import Key, Surface
from ..geometry.transform import IDENTITY_MOTION
from ..kernels.tables import Floats, Longs
from ..materials.material import Material
from ..numerics import bigfloat_linalg as ex
from .batch_lowering import BatchLowering
from .exact_surfaces import FEWEST_SURFACES, exact_surface, names_before_rotation, surface_owners
from .instances import PrimitiveCache, instance_rows
from .lower_shape import lower_shape, lower_stretched_balls
from .motion_batch import PointPlaneMover
from .pattern import BodyGroup, BodyGroups, BodyPattern, BulkBalls
from .progress import AFTER_BATCH, AFTER_READING, ProgressStages

_CHUNK = 1 << 13


class ShapeSource(Protocol):
    """Shapes by the numbers of their entries."""

    def __getitem__(self, number: int, /) -> Shape: ...


class BodyShapes:
    """The shapes of bodies, each read when it is asked for, as not all of the bodies may be there yet."""

    def __init__(self, bodies: Sequence[Body]) -> None:
        self._bodies = bodies

    def __getitem__(self, number: int) -> Shape:
        return self._bodies[number].shape


class ExactBodySurfaces:
    """The surfaces of a scene's bodies before they were rounded, in the order of the bodies; outlines of polygons.

    Only few are ever asked for: those that may be one with others, and those that a ray in doubt meets. A shape's
    are worked out at the first question and kept with the shape.
    """

    def __init__(self, shapes: ShapeSource, starts: Any, first: Any, first_outline: Any) -> None:
        """shapes: of the entries of a scene; starts: the number of each one's first body; None: each has one.

        first, first_outline: of each body, the number of its first surface, and of its first outline.
        """
        self._shapes, self._starts, self._first, self._first_outline = shapes, starts, first, first_outline

    def of(self, shapes: ShapeSource) -> ExactBodySurfaces:
        """The same of other entries that have as many bodies and surfaces."""
        return ExactBodySurfaces(shapes, self._starts, self._first, self._first_outline)

    def __getitem__(self, index: int) -> Surface:
        return _body_surface(*self._of(index))

    def name(self, index: int) -> tuple[Key, int]:
        """The exact name of a surface, and its sense."""
        shape, own = self._of(index)
        names: dict[int, tuple[Key, int]] = shape.kept.setdefault("names", {})
        if own not in names:
            names[own] = _body_surface(shape, own).key()
        return names[own]

    def said(self, indices: Longs) -> dict[int, Hashable]:
        """What is equal for surfaces that are surely one, where it is seen without their names; of many."""
        if len(indices) < FEWEST_SURFACES:
            return {}
        asked = surface_owners(self._first, indices)
        shapes = {body: self._single(body) for body in asked}
        known = names_before_rotation(shapes, asked)
        return {int(self._first[body]) + own: name for (body, own), name in known.items()}

    def outline(self, polygon: int) -> tuple[ex.Row, ...]:
        """The corners of a polygon."""
        body = int(np.searchsorted(self._first_outline, polygon, side="right")) - 1
        return lower_shape(self._shape(body)).outlines[polygon - int(self._first_outline[body])]

    def _of(self, index: int) -> tuple[Shape, int]:
        """The shape of the body that a surface belongs to, and which of all its surfaces it is."""
        body = int(np.searchsorted(self._first, index, side="right")) - 1
        shape = self._shape(body)
        return shape, body - self._start(body) if isinstance(shape, Spheres) else index - int(self._first[body])

    def _entry(self, body: int) -> int:
        """The entry that a body belongs to."""
        return body if self._starts is None else int(np.searchsorted(self._starts, body, side="right")) - 1

    def _start(self, body: int) -> int:
        """The first body of the entry that one belongs to."""
        return body if self._starts is None else int(self._starts[self._entry(body)])

    def _single(self, body: int) -> Shape:
        """The shape of a body, which need not be kept."""
        shape = self._shapes[self._entry(body)]
        return shape.single(body - self._start(body)) if isinstance(shape, Bulk) else shape

    def _shape(self, body: int) -> Shape:
        """The shape of a body, where its surfaces and their names are kept; a `Spheres` keeps those of its balls."""
        shape = self._shapes[self._entry(body)]
        if not isinstance(shape, Bulk) or isinstance(shape, Spheres):
            return shape
        singles: dict[int, Shape] = shape.kept.setdefault("singles", {})
        own = body - self._start(body)
        if own not in singles:
            singles[own] = shape.single(own)
        return singles[own]


def _body_surface(shape: Shape, number: int) -> Surface:
    """A surface of a body; of balls, that of one of them."""
    if isinstance(shape, Spheres):
        return shape.kept["balls"][2][number]
    return exact_surface(shape, number)


class BodyCollector:
    """A scene's bodies, sorted into groups; their number in the scene is that of their turn."""

    def __init__(self) -> None:
        self.contents = BodyGroups(0)
        self.items: Sequence[int] = []  # how many bodies each entry of the scene has
        self.frames: Sequence[int] = []  # how many frames of balls there are up to it
        self.paints: dict[int, dict[int, Material]] = {}  # body -> its faces with materials of their own
        self._together = BatchLowering()
        self._alone: list[tuple[Shape, int]] = []
        self._like: dict[BodyPattern, tuple[list[int], list[list[float]]]] = {}

    def collect(self, bodies: Sequence[Body], stages: ProgressStages) -> None:
        """Take in all bodies of a scene, and tell of it now and then."""
        if isinstance(bodies, InstanceList):
            self._take_moved(bodies, stages)
        else:
            self._take(bodies, stages)
        found, left = self._together.lowered(lambda part, of: stages.reached(AFTER_READING, AFTER_BATCH, part, of))
        alone = [*self._alone, *left]
        done = len(bodies) - len(alone)
        stages.bodies(done)
        self.contents.groups.extend(BodyGroup(pattern, numbers, rows) for pattern, numbers, rows in found)
        self.paints.update(self._together.paints)
        self._together = BatchLowering()  # what the bodies are made of is not needed any more
        for more, (shape, number) in enumerate(alone, start=1):
            self._add(shape, number)
            stages.bodies(done + more)
        for pattern, (numbers, rows) in self._like.items():
            self.contents.groups.append(BodyGroup(pattern, np.array(numbers, np.int32), np.array(rows)))

    def _take(self, bodies: Sequence[Body], stages: ProgressStages) -> None:
        """Sort bodies by how they are to be lowered."""
        done, items, frames = 0, [], []
        for number, body in enumerate(bodies):
            if number & 1023 == 0:
                stages.reached(0.0, AFTER_READING, number, len(bodies))
            before, shape = self.contents.body_count, body.shape
            if not _is_bulk(type(shape)):
                self.contents.body_count += 1
                self._add_one(shape, before)
            elif isinstance(shape, Spheres):
                self._add_spheres(shape)
                done += 1
                if not stages.many:
                    stages.bodies(done)
            elif isinstance(shape, Bulk):
                self._together.add_many(shape, before)
                self.contents.body_count += len(shape)
            items.append(self.contents.body_count - before)
            frames.append(len(self.contents.ball_frames))
        self.items, self.frames = items, frames

    def _add_one(self, shape: Shape, number: int) -> None:
        """A body that is lowered together with others, or alone."""
        if "part" in vars(shape).get("kept", ()) or not self._together.add(shape, number):
            self._alone.append((shape, number))

    def _take_moved(self, bodies: InstanceList, stages: ProgressStages) -> None:
        """`_take` for bodies that are one another moved."""
        self.contents.body_count, done = len(bodies), 0
        self.items = [1] * len(bodies)
        alone, carried = PrimitiveCache(), PointPlaneMover()
        for kind, numbers in enumerate(bodies.members):
            stages.reached(0.0, AFTER_READING, done, len(bodies))
            found = instance_rows(bodies, kind, numbers, alone, carried)
            done += len(numbers)
            if found is not None:
                self.contents.groups.append(BodyGroup(found[0], numbers, found[1]))
                continue
            for number in numbers.tolist():
                self._add_one(bodies.shape(number), number)

    def _add(self, shape: Shape, place: int) -> None:
        """A body that is lowered alone."""
        part = lower_shape(shape)
        numbers, rows = self._like.setdefault(part.pattern, ([], []))
        numbers.append(place)
        rows.append(part.row)
        if part.paints:
            self.paints[place] = part.paints

    def _add_spheres(self, shape: Spheres) -> None:
        """Balls straight from arrays; ellipsoids where a motion is no similarity."""
        contents = self.contents
        centers, linear, factor = shape.placed(IDENTITY_MOTION)
        boxes = _ball_boxes(centers, shape.radii, np.sqrt((linear**2).sum(axis=1)))
        back = shape.motion.inverse_matrix[:3, :3]
        contents.ball_frames.append(back.ravel())
        frame = -len(contents.ball_frames)
        bodies = np.arange(contents.body_count, contents.body_count + len(shape), dtype=np.int32)
        contents.body_count += len(shape)
        if factor is not None:
            balls = np.empty((len(shape), 4))
            balls[:, :3] = centers
            np.multiply(shape.radii, factor, out=balls[:, 3])
            contents.balls.append(BulkBalls(bodies, balls, boxes, frame))
        elif len(shape):
            pattern, rows, _ = lower_stretched_balls(shape, centers, boxes, back)
            contents.groups.append(BodyGroup(pattern, bodies, rows, frame))


@cache
def _is_bulk(kind: type) -> bool:
    """Does an entry of a kind have many bodies?"""
    return issubclass(kind, Bulk)


def _ball_boxes(centers: FloatArray, radii: FloatArray, stretch: FloatArray) -> Floats:
    """(n, 6) around balls whose radius is stretched along each axis; a part at a time, to stay in the cache."""
    boxes = np.empty((len(radii), 6))
    for begin in range(0, len(radii), _CHUNK):
        rows = slice(begin, begin + _CHUNK)
        reach = radii[rows, None] * stretch
        np.nextafter(centers[rows] - reach, -np.inf, out=boxes[rows, :3])
        np.nextafter(centers[rows] + reach, np.inf, out=boxes[rows, 3:])
    return boxes
