"""Collect the bodies of a scene into groups of equal pattern, with their rows of numbers; exact surfaces on demand.

A volume may be a Boolean shape of thousands of primitives, and only one of them is needed for an exact surface. So
each surface is computed from the primitive alone that it belongs to.
"""

from __future__ import annotations

from bisect import bisect_right
from collections.abc import Sequence
from dataclasses import field
from functools import cache
from itertools import accumulate
from typing import Any, Protocol

import numpy as np

from .._jit.decorators import kernel
from .._util.arrays import FloatArray, unique_first_with_inverse, unique_sorted
from .._util.records import dataclass
from ..geometry.body import Body
from ..geometry.bulk import Bulk, Spheres
from ..geometry.instances import InstanceList
from ..geometry.shape import PrimitiveSolid, Shape
from ..geometry.surface import Key, Surface
from ..geometry.transform import IDENTITY_MOTION, Motion, Step
from ..kernels.numbers.double_double import next_float_down, next_float_up
from ..kernels.tables import Floats, Ints, Longs
from ..kernels.threads import KernelRange, run_chunks
from ..materials.material import Material
from ..numerics import bigfloat as ex
from .batch_lowering import BatchLowering
from .csg_plan import placed_primitives
from .instances import instance_rows
from .lower_shape import lower_shape, lower_stretched_balls
from .motion_batch import PointPlaneMover
from .pattern import BodyGroup, BodyGroups, BodyPattern, BulkBalls, Primitives
from .primitive_cache import PrimitiveCache
from .progress import AFTER_BATCH, AFTER_READING, ProgressStages
from .surface_names import FEWEST_SURFACES, list_forms, name_surfaces, own_surfaces


@dataclass
class _ShapeLeaves:
    """The primitives of a body, the number of the first surface of each, and the surfaces computed so far."""

    moved: list[tuple[Shape, tuple[Step, ...]]]
    first: list[int]
    known: dict[int, Surface] = field(default_factory=dict)
    motions: dict[int, Motion] = field(default_factory=dict)
    """The motions of primitives from their own frames: the surfaces of one share the products of its steps."""

    def moved_surface(self, number: int) -> Surface:
        """Return a surface, computed without the uv maps of its faces."""
        which = bisect_right(self.first, number) - 1
        leaf, steps = self.moved[which]
        if which not in self.motions:
            self.motions[which] = leaf._under_steps(steps).under()
        return own_surfaces(leaf)[number - self.first[which]].moved(self.motions[which])


def exact_surface(shape: Shape, number: int) -> Surface:
    """Return an exact surface of a body, by its number among those of all its primitives."""
    leaves = None if "part" in shape.cache else _shape_leaves(shape)
    if leaves is None:
        return lower_shape(shape).exact[number]
    if number not in leaves.known:
        leaves.known[number] = leaves.moved_surface(number)
    return leaves.known[number]


def _shape_leaves(shape: Shape) -> _ShapeLeaves | None:
    """Return the primitives of a body, which caches them; None where one of them is no solid."""
    leaves: _ShapeLeaves | None = shape.cache.get("leaves")
    if leaves is None:
        moved = placed_primitives(shape)
        if not all(isinstance(leaf, PrimitiveSolid) for leaf, _ in moved):
            return None
        counts = (leaf._face_count or len(own_surfaces(leaf)) for leaf, _ in moved)
        leaves = shape.cache["leaves"] = _ShapeLeaves(moved, [0, *accumulate(counts)])
    return leaves


_CHUNK = 1 << 13


class ShapeSource(Protocol):
    """A source of shapes, by the number of their entry."""

    def __getitem__(self, number: int, /) -> Shape: ...


class BodyShapes:
    """The shapes of bodies, read one by one on demand, because not all bodies may exist yet."""

    def __init__(self, bodies: Sequence[Body]) -> None:
        self._bodies = bodies

    def __getitem__(self, number: int) -> Shape:
        return self._bodies[number].shape


class ExactBodySurfaces:
    """The exact surfaces of a scene's bodies, in body order, and the exact outlines of polygons.

    Few are ever needed: surfaces that may coincide with others, and those that a doubtful ray hits. The surfaces of a
    shape are computed on first use and cached with the shape.
    """

    def __init__(self, shapes: ShapeSource, starts: Any, first: Any, first_outline: Any) -> None:
        """Create the source.

        `shapes` gives the shape of each entry; `starts` the number of its first body (None: each entry has one body).
        `first` and `first_outline` give for each body the number of its first surface and first outline.
        """
        self._shapes, self._starts, self.first, self._first_outline = shapes, starts, first, first_outline

    def of(self, shapes: ShapeSource, first: Any = None) -> ExactBodySurfaces:
        """Return the same for other entries with as many bodies, and surfaces, unless `first` says how many."""
        first = self.first if first is None else first
        return ExactBodySurfaces(shapes, self._starts, first, self._first_outline)

    def __getitem__(self, index: int) -> Surface:
        return _body_surface(*self._of(index))

    def name(self, index: int, primitives: Primitives | None = None) -> tuple[Key, int]:
        """Return the exact name of a surface, and its sense. Known primitives save those of its body."""
        shape, own = self._of(index)
        names: dict[int, tuple[Key, int]] = shape.cache.setdefault("names", {})
        if own not in names:
            which = -1 if primitives is None else int(primitives.leaf[index])
            if primitives is not None and which >= 0 and isinstance(primitives.leaves[which][0], PrimitiveSolid):
                leaf = _ShapeLeaves([primitives.leaves[which]], [0])
                names[own] = leaf.moved_surface(int(primitives.number[index])).key()
            else:
                names[own] = _body_surface(shape, own).key()
        return names[own]

    def known_names(self, surfaces: Longs, clusters: Longs, primitives: Primitives | None) -> Longs:
        """Return names, known without exact keys, that surfaces of a cluster share only if they are certainly equal.

        -1 for no name; few surfaces have none, as exact keys are as quick. The numbers of `clusters` rise.
        """
        if len(surfaces) < FEWEST_SURFACES:
            return np.full(len(surfaces), -1)
        parts, which, own = self._locate(surfaces, primitives)
        names = np.where(which < 0, -1, which * (1 + int(own.max())) + own)
        axial = _axial_names(parts, which, own)
        # Most clusters are caps of cylinders, one within the other: they need no other names
        begin = np.flatnonzero(np.diff(clusters, prepend=-1))
        sizes = np.diff(begin, append=len(clusters))
        equal = (axial >= 0) & (axial == np.repeat(axial[begin], sizes))
        same = np.repeat(np.logical_and.reduceat(equal, begin), sizes)
        names[same] = axial[same]
        solid = np.flatnonzero((which >= 0) & ~same)
        if len(solid):
            first_of, place = unique_first_with_inverse(names[solid])
            some, numbers = which[solid[first_of]], own[solid[first_of]]
            carried = unique_sorted(some)
            leaf_of, leaves = np.searchsorted(carried, some), [parts[k] for k in carried.tolist()]
            forms = list_forms([leaf for leaf, _ in leaves], leaf_of, numbers)
            chains = [(*leaf.placement.steps, *steps) for leaf, steps in leaves]
            names[solid] = name_surfaces(forms, chains, leaf_of)[place]
        return names

    def _locate(
        self, surfaces: Longs, primitives: Primitives | None
    ) -> tuple[list[tuple[Any, tuple[Step, ...]]], Longs, Longs]:
        """Return primitives with their steps, and for each surface the number of its primitive and its number there.

        -1 stands for primitives that are no solids.
        """
        parts: list[tuple[Any, tuple[Step, ...]]] = []
        which, own = np.full((2, len(surfaces)), -1)
        if primitives is not None:
            parts = [*primitives.leaves]
            is_solid = np.array([*(isinstance(leaf, PrimitiveSolid) for leaf, _ in parts), False])
            which, own = primitives.leaf[surfaces].astype(np.int64), primitives.number[surfaces].astype(np.int64)
            which[~is_solid[which]] = -1
        left = np.flatnonzero(which < 0)
        if not len(left):
            return parts, which, own
        known: dict[tuple[int, int], int] = {}
        starts: list[int] = []  # of each primitive of each body the first surface, and the number of the primitive
        numbers: list[int] = []
        bodies = unique_sorted(np.searchsorted(self.first, surfaces[left], side="right") - 1)
        for body, first in zip(bodies.tolist(), self.first[bodies].tolist(), strict=True):
            found = _shape_leaves(self._single(body))
            if found is None:
                starts.append(first)
                numbers.append(-1)
                continue
            starts += [first + begin for begin in found.first[:-1]]
            for leaf in found.moved:
                numbers.append(known.setdefault((id(leaf[0]), id(leaf[1])), len(parts)))
                if numbers[-1] == len(parts):
                    parts.append(leaf)
        at = np.searchsorted(starts, surfaces[left], side="right") - 1
        which[left], own[left] = np.array(numbers)[at], surfaces[left] - np.array(starts)[at]
        return parts, which, own

    def outline(self, polygon: int) -> tuple[ex.Row, ...]:
        """Return the exact corners of a polygon."""
        body = int(np.searchsorted(self._first_outline, polygon, side="right")) - 1
        return lower_shape(self._shape(body)).outlines[polygon - int(self._first_outline[body])]

    def _of(self, index: int) -> tuple[Shape, int]:
        """Return the shape that a surface belongs to, and the number of the surface within that shape."""
        # Of the type of the array, which would be converted otherwise
        body = int(np.searchsorted(self.first, self.first.dtype.type(index), side="right")) - 1
        shape = self._shape(body)
        return shape, body - self._start(body) if isinstance(shape, Spheres) else index - int(self.first[body])

    def _entry(self, body: int) -> int:
        """Return the entry that a body belongs to."""
        return body if self._starts is None else int(np.searchsorted(self._starts, body, side="right")) - 1

    def _start(self, body: int) -> int:
        """Return the first body of the entry that a body belongs to."""
        return body if self._starts is None else int(self._starts[self._entry(body)])

    def _single(self, body: int) -> Shape:
        """Return the shape of a body, which nobody needs to cache."""
        shape = self._shapes[self._entry(body)]
        return shape.single(body - self._start(body)) if isinstance(shape, Bulk) else shape

    def _shape(self, body: int) -> Shape:
        """Return the shape of a body in which its surfaces and their names are cached.

        A `Spheres` caches those of its balls.
        """
        shape = self._shapes[self._entry(body)]
        if not isinstance(shape, Bulk) or isinstance(shape, Spheres):
            return shape
        singles: dict[int, Shape] = shape.cache.setdefault("singles", {})
        own = body - self._start(body)
        if own not in singles:
            singles[own] = shape.single(own)
        return singles[own]


def _axial_names(parts: Sequence[tuple[Any, tuple[Step, ...]]], which: Longs, own: Longs) -> Longs:
    """Number caps and sides by the exact ends of their axes and their steps; -1 for other surfaces."""
    known: dict[Any, int] = {}
    placed: dict[tuple[int, int], tuple[float, ...] | None] = {}
    found = np.full(len(which), -1)
    for at in np.flatnonzero(which >= 0).tolist():
        leaf, steps = parts[which[at]]
        face = id(leaf), int(own[at])
        if face not in placed:
            placed[face] = leaf._axial_name(face[1])
        if placed[face] is not None:
            found[at] = known.setdefault((placed[face], steps), len(known))
    return found


def _body_surface(shape: Shape, number: int) -> Surface:
    """Return an exact surface of a body; of a `Spheres`, the surface of one of its balls."""
    if isinstance(shape, Spheres):
        return shape.cache["balls"][2][number]
    return exact_surface(shape, number)


class BodyCollector:
    """Sorts a scene's bodies into groups, and numbers them in the order of the entries."""

    def __init__(self) -> None:
        self.contents = BodyGroups(0)
        self.items: Sequence[int] | Ints = []  # bodies of each entry of the scene
        self.frames: Sequence[int] = []  # frames of balls up to and with each entry
        self.paints: dict[int, dict[int, Material]] = {}  # body -> face -> material, where it is not the body's
        self._batch = BatchLowering()
        self._single_shapes: list[tuple[Shape, int]] = []
        self._rows_by_pattern: dict[BodyPattern, tuple[list[int], list[list[float]]]] = {}

    def collect(self, bodies: Sequence[Body], stages: ProgressStages) -> None:
        """Lower all bodies of a scene, and report progress."""
        if isinstance(bodies, InstanceList):
            self._take_instances(bodies, stages)
        else:
            self._take(bodies, stages)
        found, left = self._batch.lower(lambda part, of: stages.advance(AFTER_READING, AFTER_BATCH, part, of))
        single = [*self._single_shapes, *left]
        done = len(bodies) - len(single)
        stages.bodies(done)
        self.contents.groups += found
        self.paints.update(self._batch.paints)
        self._batch = BatchLowering()  # releases the inputs of the batch
        for more, (shape, number) in enumerate(single, start=1):
            self._add(shape, number)
            stages.bodies(done + more)
        for pattern, (numbers, rows) in self._rows_by_pattern.items():
            self.contents.groups.append(BodyGroup(pattern, np.array(numbers, np.int32), np.array(rows)))

    def _take(self, bodies: Sequence[Body], stages: ProgressStages) -> None:
        """Sort bodies by the way in which they are lowered: in batches, one by one, or as bulk balls."""
        done, items, frames = 0, [], []
        for number, body in enumerate(bodies):
            # Progress costs time: report every 1,024 entries.
            if number & 1023 == 0:
                stages.advance(0.0, AFTER_READING, number, len(bodies))
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
                self._batch.add_many(shape, before)
                self.contents.body_count += len(shape)
            items.append(self.contents.body_count - before)
            frames.append(len(self.contents.ball_frames))
        self.items, self.frames = items, frames

    def _add_one(self, shape: Shape, number: int) -> None:
        """Queue a body for the batch, or for single lowering where it is lowered already or cannot be batched."""
        # A shape that was lowered before is in its own cache already.
        if "part" in vars(shape).get("cache", ()) or not self._batch.add(shape, number):
            self._single_shapes.append((shape, number))

    def _take_instances(self, bodies: InstanceList, stages: ProgressStages) -> None:
        """`_take` for a scene with instances: each kind of body is lowered from few of its copies, where possible."""
        self.contents.body_count, done = len(bodies), 0
        self.items = np.ones(len(bodies), np.int32)
        primitives, mover = PrimitiveCache(), PointPlaneMover()
        for kind, numbers in enumerate(bodies.members):
            stages.advance(0.0, AFTER_READING, done, len(bodies))
            rows = instance_rows(bodies, kind, numbers, primitives, mover)
            done += len(numbers)
            if rows is not None:
                self.contents.groups.append(BodyGroup(rows[0], numbers, rows[1]))
                continue
            for number in numbers.tolist():
                self._add_one(bodies.shape(number), number)

    def _add(self, shape: Shape, place: int) -> None:
        """Lower one body by itself."""
        part = lower_shape(shape)
        numbers, rows = self._rows_by_pattern.setdefault(part.pattern, ([], []))
        numbers.append(place)
        rows.append(part.row)
        if part.paints:
            self.paints[place] = part.paints

    def _add_spheres(self, shape: Spheres) -> None:
        """Add balls straight from arrays; as ellipsoids where the motion is no similarity."""
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

            def place(begin: int, end: int) -> None:
                """Write the records of balls begin..end."""
                balls[begin:end, :3] = centers[begin:end]
                np.multiply(shape.radii[begin:end], factor, out=balls[begin:end, 3])

            run_chunks(place, len(shape), _CHUNK)
            contents.balls.append(BulkBalls(bodies, balls, boxes, frame))
        elif len(shape):
            pattern, rows, _ = lower_stretched_balls(shape, centers, boxes, back)
            contents.groups.append(BodyGroup(pattern, bodies, rows, frame))


@cache
def _is_bulk(kind: type) -> bool:
    """Return whether entries of a type have many bodies."""
    return issubclass(kind, Bulk)


def _ball_boxes(centers: FloatArray, radii: FloatArray, stretch: FloatArray) -> Floats:
    """Return boxes (n, 6) around balls whose radius is stretched along each axis."""
    boxes, arrays = np.empty((len(radii), 6)), (np.ascontiguousarray(centers), np.ascontiguousarray(radii))
    run_chunks(KernelRange(box_balls, arrays, (tuple(stretch.tolist()), boxes)), len(radii), _CHUNK)
    return boxes


@kernel(centers="n 3", radii="n", begin="0..end", end="0..n", boxes="out n 6")
def box_balls(
    centers: Floats, radii: Floats, begin: int, end: int, stretch: tuple[float, float, float], boxes: Floats
) -> None:
    """Write the boxes of balls begin..end."""
    for i in range(begin, end):
        for k in range(3):
            reach = radii[i] * stretch[k]
            # One ulp outward covers the rounding of the sum.
            boxes[i, k], boxes[i, k + 3] = next_float_down(centers[i, k] - reach), next_float_up(centers[i, k] + reach)
