"""Collect the bodies of a scene into groups of equal pattern, with their rows of numbers; exact surfaces on demand.

A volume may be a Boolean shape of thousands of primitives, and only one of them is needed for an exact surface. So
each surface is computed from the primitive alone that it belongs to.
"""

from __future__ import annotations

from bisect import bisect_right
from collections.abc import Hashable, Mapping, Sequence
from dataclasses import dataclass, field
from fractions import Fraction
from functools import cache
from itertools import accumulate
from typing import Any, Protocol, TypeAlias

import numpy as np

from .._util.arrays import FloatArray
from ..geometry.body import Body
from ..geometry.bulk import Bulk, Spheres
from ..geometry.cell import Cell, Not, Tree
from ..geometry.instances import InstanceList
from ..geometry.primitives import HalfSpace
from ..geometry.shape import PrimitiveSolid, Shape
from ..geometry.surface import Key, Surface
from ..geometry.transform import IDENTITY_MOTION, Rotate, Step, Transform, Translate
from ..kernels.tables import PLANE, PLANE_SIZE, Floats, Longs
from ..kernels.threads import run_chunks
from ..materials.material import Material
from ..numerics import bigfloat as ex
from ..numerics.portable_math import power_of_two_scale
from .batch_lowering import BatchLowering
from .csg_plan import placed_primitives
from .instances import PrimitiveCache, flatten_primitive, instance_rows
from .lower_shape import lower_shape, lower_stretched_balls
from .motion_batch import PointPlaneMover
from .pattern import SIZES, BodyGroup, BodyGroups, BodyPattern, BulkBalls
from .progress import AFTER_BATCH, AFTER_READING, ProgressStages


@dataclass
class _ShapeLeaves:
    """The primitives of a body, the number of the first surface of each, and the surfaces computed so far."""

    moved: list[tuple[Shape, tuple[Step, ...]]]
    first: list[int]
    known: dict[int, Surface] = field(default_factory=dict)


def exact_surface(shape: Shape, number: int) -> Surface:
    """Return an exact surface of a body, by its number among those of all its primitives."""
    if "part" in shape.cache:
        return lower_shape(shape).exact[number]
    leaves: _ShapeLeaves | None = shape.cache.get("leaves")
    if leaves is None:
        moved = placed_primitives(shape)
        if not all(isinstance(leaf, PrimitiveSolid) for leaf, _ in moved):
            return lower_shape(shape).exact[number]
        leaves = shape.cache["leaves"] = _ShapeLeaves(moved, [0, *accumulate(surface_count(leaf) for leaf, _ in moved)])
    if number not in leaves.known:
        which = bisect_right(leaves.first, number) - 1
        leaf, steps = leaves.moved[which]
        # Without the uv maps of its faces
        surface = _leaf_surfaces(leaf)[number - leaves.first[which]]
        leaves.known[number] = surface.moved(leaf._under_steps(steps).under())
    return leaves.known[number]


def _leaf_surfaces(leaf: Any) -> list[Surface]:
    """List the surfaces of a primitive solid in its own frame."""
    return leaf.surfaces if leaf._face_count else _tree_surfaces(leaf.tree())


def surface_count(leaf: Any) -> int:
    """Return how many surfaces a primitive solid has, by its tree at most once."""
    found: int | None = leaf._face_count or leaf.cache.get("surface count")
    if found is None:
        found = leaf.cache["surface count"] = len(_tree_surfaces(leaf.tree()))
    return found


def _tree_surfaces(tree: Tree) -> list[Surface]:
    """List the surfaces of all cells, from left to right."""
    found: list[Surface] = []
    pending = [tree]
    while pending:
        part = pending.pop()
        if isinstance(part, Cell):
            found += [face.surface for face in part.faces]
        else:
            pending.extend(reversed((part.part,) if isinstance(part, Not) else part.parts))
    return found


# Coincident surfaces in the frame before a common rotation, where they compare exactly
#
# The walls of crystals in a rotated module, or of boxes in an oblique row, coincide by the hundred. Exact names would
# show it, at a millisecond each. But before the rotation their numbers are exact (nothing was rounded), and surfaces
# that are equal there are equal after the same steps of a motion.

FEWEST_SURFACES = 64
"""For fewer surfaces exact names are as quick."""

_PlacedPrimitive: TypeAlias = tuple[Shape, tuple[Step, ...], tuple[Step, ...]]
"""A primitive, its leading translations, and the other steps."""


def names_before_rotation(
    shapes: Mapping[int, Shape], requested: Mapping[int, list[int]]
) -> dict[tuple[int, int], Hashable]:
    """Return keys that are equal only for surfaces that are certainly equal, by (body, surface).

    Parameters
    ----------
    shapes : Mapping[int, Shape]
        The shapes of bodies, by body number.
    requested : Mapping[int, list[int]]
        For each body, which of its surfaces.

    Returns
    -------
    dict[tuple[int, int], Hashable]
        Surfaces of unknown key are left out.
    """
    moved = {
        number: list(map(_split_steps, placed_primitives(shape)))
        for number, shape in shapes.items() if "unrotated names" not in shape.cache
    }  # fmt: skip
    primitives = PrimitiveCache()
    primitives.prepare_primitives(
        (leaf, first)
        for parts in moved.values()
        if _is_solid(parts)
        for leaf, first, rest in parts
        if rest and not leaf._face_count
    )
    counts: dict[int, int] = {}
    for number, parts in moved.items():
        names: list[Hashable] = []
        for leaf, first, rest in parts if _is_solid(parts) else ():
            planes = _plane_names(leaf, first, rest)
            if planes:
                names += planes
            elif rest:
                numbers, _, kinds = primitives.of(leaf, first)
                names += _names_of_surfaces(numbers, kinds, rest)
            else:
                if id(leaf) not in counts:
                    counts[id(leaf)] = len(_tree_surfaces(leaf.tree()))  # type: ignore[attr-defined]
                names += [None] * counts[id(leaf)]
        shapes[number].cache["unrotated names"] = names
    return {
        (number, own): names[own]
        for number, some in requested.items() for names in (shapes[number].cache["unrotated names"],) for own in some
        if own < len(names) and names[own] is not None
    }  # fmt: skip


def _is_solid(parts: list[_PlacedPrimitive]) -> bool:
    """Return whether a shape consists of primitive solids."""
    return all(isinstance(leaf, PrimitiveSolid) for leaf, _, _ in parts)


def _split_steps(moved: tuple[Shape, tuple[Step, ...]]) -> _PlacedPrimitive:
    """Split the steps of a primitive after the leading translations."""
    leaf, steps = moved
    count = next((k for k, step in enumerate(steps) if type(step) is not Translate), len(steps))
    return leaf, steps[:count], steps[count:]


def _names_of_surfaces(numbers: list[float], kinds: tuple[int, ...], rest: tuple[Step, ...]) -> list[Hashable]:
    """Name each surface of a primitive before the rotation that follows; None where it was rounded."""
    names: list[Hashable] = []
    at = 0
    for kind in kinds:
        size = SIZES[kind]
        record, lost, sense = numbers[at : at + size], numbers[at + size : at + 2 * size], numbers[at + 2 * size]
        at += 2 * size + 1
        if any(lost):
            names.append(None)
        elif kind == PLANE:
            names.append((_steps_across(rest, record[:3]), *_anchorless_plane(record)))
        else:
            names.append((rest, kind, sense, *(number + 0.0 for number in record)))
    return names


def _plane_names(leaf: Shape, first: tuple[Step, ...], rest: tuple[Step, ...]) -> list[Hashable]:
    """Name the planes that a user or a file gave as `_names_of_surfaces` names them; nothing for other primitives."""
    if isinstance(leaf, HalfSpace):
        rows = [(leaf.normal, leaf.offset)]
    elif leaf._hull is not None:
        rows = [leaf.parts.planes[k][:2] for part in leaf.parts.parts for k, _ in part]  # type: ignore[attr-defined]
    elif leaf._face_count:
        rows = zip(leaf.normals, leaf.offsets, strict=True)  # type: ignore[attr-defined, assignment]
    else:
        return []
    shifts = [tuple(map(Fraction, step.offset)) for step in first]  # type: ignore[union-attr]
    offset: Any
    names: list[Hashable] = []
    for normal, offset in rows:
        for shift in shifts:
            offset = sum((Fraction(n) * t for n, t in zip(normal, shift, strict=True) if n), Fraction(offset))
        along, steps = [axis for axis in range(3) if normal[axis]], _steps_across(rest, normal)
        if len(along) == 1:
            names.append((steps, along[0], Fraction(offset) / Fraction(normal[along[0]])))
            continue
        scale = power_of_two_scale(float(max(map(abs, normal)))) * (1 if normal[along[0]] > 0 else -1)
        names.append((steps, *(_times(x, scale) for x in (*normal, offset))))
    return names


def _steps_across(steps: tuple[Step, ...], normal: Sequence[float]) -> tuple[Step, ...]:
    """Return steps of a motion without their shifts along an axis that lies in a plane, where no step turns that axis.

    They carry the plane to the same one: the caps of parallel wires, side by side, are one plane.
    """
    for axis in range(3):
        if not normal[axis]:
            kept = tuple(step for step in (_without_shift(step, axis) for step in steps) if step is not None)
            steps = kept if len(kept) == len(steps) else steps
    return steps


def _without_shift(step: Step, axis: int) -> Step | None:
    """Return a step without its shift along an axis; None if it may turn the axis."""
    others = [k for k in range(3) if k != axis]
    if isinstance(step, Translate):
        x, y, z = (0.0 if k == axis else c for k, c in enumerate(step.offset))
        return Translate((x, y, z))
    if isinstance(step, Rotate):
        return None if any(step.axis[k] for k in others) else step
    if isinstance(step, Transform) and not any(step.matrix[axis][k] or step.matrix[k][axis] for k in others):
        a, b, c = ((*row[:3], 0.0) if k == axis else row for k, row in enumerate(step.matrix[:3]))
        return Transform((a, b, c, step.matrix[3]))
    return None


def _times(value: Any, scale: float) -> Any:
    """Multiply by a power of two, exactly."""
    product = value * scale if isinstance(value, float) else 0.0
    return product + 0.0 if product and product / scale == value else Fraction(value) * Fraction(scale)


def _anchorless_plane(record: list[float]) -> tuple[Hashable, ...]:
    """Describe the plane of a record independently of its anchor."""
    normal, height, anchor = record[:3], record[3], record[4:PLANE_SIZE]
    along = [axis for axis in range(3) if normal[axis]]
    if len(along) == 1 and not height:
        return along[0], anchor[along[0]] + 0.0
    # The offset n·a - height, exact.
    terms = (Fraction(n) * Fraction(a) for n, a in zip(normal, anchor, strict=True) if n and a)
    return *(number + 0.0 for number in normal), sum(terms, Fraction(-height))


def surface_owners(first: np.ndarray, surfaces: np.ndarray) -> dict[int, list[int]]:
    """Map bodies to their surfaces among these; `first` gives the first surface of each body."""
    bodies = np.searchsorted(first, surfaces, side="right") - 1
    found: dict[int, list[int]] = {}
    for body, own in zip(bodies.tolist(), (surfaces - first[bodies]).tolist(), strict=True):
        found.setdefault(body, []).append(own)
    return found


# --- Bodies in groups of equal pattern

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

    def name(self, index: int) -> tuple[Key, int]:
        """Return the exact name of a surface, and its sense."""
        shape, own = self._of(index)
        names: dict[int, tuple[Key, int]] = shape.cache.setdefault("names", {})
        if own not in names:
            names[own] = _body_surface(shape, own).key()
        return names[own]

    def known_names(self, indices: Longs) -> dict[int, Hashable]:
        """Return keys, visible without exact names, that are equal only for surfaces that are certainly equal.

        Empty for few surfaces, for which exact names are as quick.
        """
        if len(indices) < FEWEST_SURFACES:
            return {}
        owners = surface_owners(self.first, indices)
        shapes = {body: self._single(body) for body in owners}
        known = names_before_rotation(shapes, owners)
        return {int(self.first[body]) + own: name for (body, own), name in known.items()}

    def leaf_names(self, indices: Longs) -> dict[int, Hashable]:
        """Return names that are equal for one surface of primitives with equal numbers, moved by equal steps.

        A volume that others are cut from has their primitives too.
        """
        owners = surface_owners(self.first, indices)
        parts = {body: placed_primitives(self._single(body)) for body in owners}
        known: dict[tuple[int, tuple[Step, ...]], Any] = {}

        def flattened(leaf: Shape, steps: tuple[Step, ...]) -> Any:
            key = id(leaf), steps
            if key not in known:
                known[key] = flatten_primitive(leaf, steps)
            return known[key]

        flat = {
            body: [flattened(*leaf) for leaf in leaves]
            for body, leaves in parts.items()
            if all(isinstance(leaf, PrimitiveSolid) for leaf, _ in leaves)
        }
        # How many surfaces a primitive has is known without its tree where it is a body of its own
        counts: dict[Hashable, int] = {
            only[0].key: int(self.first[body + 1] - self.first[body])
            for body, only in flat.items()
            if len(only) == 1 and only[0] is not None and body + 1 < len(self.first)
        }
        names: dict[int, Hashable] = {}
        for body, own in owners.items():
            begin, pending = int(self.first[body]), sorted(own, reverse=True)
            end = begin
            for (leaf, _), one in zip(parts[body], flat.get(body, ()), strict=False):
                if not pending:
                    break
                key = id(leaf) if one is None else one.key
                if key not in counts:
                    counts[key] = surface_count(leaf)
                first, end = end, end + counts[key]
                while pending and begin + pending[-1] < end:
                    surface = begin + pending.pop()
                    if one is not None:
                        names[surface] = key, surface - first
        return names

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


def _body_surface(shape: Shape, number: int) -> Surface:
    """Return an exact surface of a body; of a `Spheres`, the surface of one of its balls."""
    if isinstance(shape, Spheres):
        return shape.cache["balls"][2][number]
    return exact_surface(shape, number)


class BodyCollector:
    """Sorts a scene's bodies into groups, and numbers them in the order of the entries."""

    def __init__(self) -> None:
        self.contents = BodyGroups(0)
        self.items: Sequence[int] = []  # bodies of each entry of the scene
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
        self.contents.groups.extend(BodyGroup(pattern, numbers, rows) for pattern, numbers, rows in found)
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
        self.items = [1] * len(bodies)
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
    """Return boxes (n, 6) around balls whose radius is stretched along each axis, in blocks that stay in the cache."""
    boxes = np.empty((len(radii), 6))

    def enclose(begin: int, end: int) -> None:
        """Write the boxes of balls begin..end."""
        rows = slice(begin, end)
        reach = radii[rows, None] * stretch
        # One ulp outward covers the rounding of the sum.
        np.nextafter(centers[rows] - reach, -np.inf, out=boxes[rows, :3])
        np.nextafter(centers[rows] + reach, np.inf, out=boxes[rows, 3:])

    run_chunks(enclose, len(radii), _CHUNK)
    return boxes
