"""Collect the bodies of a scene into groups of equal pattern, with their rows of numbers; exact surfaces on demand.

A volume may be a Boolean shape of thousands of primitives, and only one of them is needed for an exact surface. So
each surface is computed from the primitive alone that it belongs to.
"""

from __future__ import annotations

from bisect import bisect_right
from collections.abc import Hashable, Sequence
from dataclasses import field
from fractions import Fraction
from functools import cache, lru_cache
from itertools import accumulate
from typing import Any, NamedTuple, Protocol, TypeAlias

import numpy as np

from .._jit.decorators import kernel
from .._util.arrays import FloatArray
from .._util.dataclass import dataclass
from ..geometry.body import Body
from ..geometry.bulk import Bulk, Spheres
from ..geometry.cell import Cell, Not, Tree
from ..geometry.instances import InstanceList
from ..geometry.shape import PrimitiveSolid, Shape
from ..geometry.surface import Key, PlaneSurface, QuadricSurface, Surface
from ..geometry.transform import IDENTITY_MOTION, Rotate, Step, Transform, Translate
from ..kernels.numbers.double_double import next_float_down, next_float_up
from ..kernels.tables import Floats, Ints, Longs
from ..kernels.threads import KernelRange, run_chunks
from ..materials.material import Material
from ..numerics import bigfloat as ex
from .batch_lowering import BatchLowering
from .csg_plan import placed_primitives
from .instances import PrimitiveCache, instance_rows
from .lower_shape import lower_shape, lower_stretched_balls
from .motion_batch import PointPlaneMover
from .pattern import BodyGroup, BodyGroups, BodyPattern, BulkBalls
from .progress import AFTER_BATCH, AFTER_READING, ProgressStages


@dataclass
class _ShapeLeaves:
    """The primitives of a body, the number of the first surface of each, and the surfaces computed so far."""

    moved: list[tuple[Shape, tuple[Step, ...]]]
    first: list[int]
    known: dict[int, Surface] = field(default_factory=dict)

    def of(self, number: int) -> tuple[Any, tuple[Step, ...], int]:
        """Return the primitive of a surface, its steps, and the number of the surface within it."""
        which = bisect_right(self.first, number) - 1
        return *self.moved[which], number - self.first[which]


def exact_surface(shape: Shape, number: int) -> Surface:
    """Return an exact surface of a body, by its number among those of all its primitives."""
    leaves = None if "part" in shape.cache else _shape_leaves(shape)
    if leaves is None:
        return lower_shape(shape).exact[number]
    if number not in leaves.known:
        leaf, steps, own = leaves.of(number)
        # Without the uv maps of its faces
        leaves.known[number] = own_surfaces(leaf)[own].moved(leaf._under_steps(steps).under())
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


def own_surfaces(leaf: Any) -> Sequence[Surface]:
    """List the surfaces of a primitive solid in its own frame, once for all its copies."""
    if leaf._face_count:
        return leaf.surfaces
    found: list[Surface] | None = leaf.own_cache.get("surfaces")
    if found is None:
        found = leaf.own_cache["surfaces"] = _tree_surfaces(leaf.tree())
    return found


def own_forms(leaf: Any) -> Sequence[UprightForm | Surface]:
    """List the surfaces of a primitive solid as `surface_name` takes them, once for all its copies."""
    found: list[UprightForm | Surface] | None = leaf.own_cache.get("forms")
    if found is None:
        found = leaf.own_cache["forms"] = list(map(UprightForm.of, own_surfaces(leaf)))
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


# Names of surfaces: exact numbers before the first step of a motion that would round them
#
# The walls of crystals in a rotated module, or of boxes in an oblique row, coincide by the hundred. Keys in 3,000 bits
# would show it, at a millisecond each. Fractions carry a surface as far as translations, scalings along the axes and
# quarter turns lead, and rotations about an axis that leave it where it is. From there on surfaces with equal numbers
# are equal after equal steps, without the shifts that move a surface within itself.

FEWEST_SURFACES = 64
"""For fewer surfaces exact keys are as quick."""

_AxisMap: TypeAlias = tuple[tuple[int, Fraction | int, Fraction | int], ...]
"""For each axis i (k, factor, shift): x[i] becomes factor x[k] + shift."""


class StepChain(NamedTuple):
    """Steps of a motion, and the map of each that takes axes to axes."""

    steps: tuple[Step, ...]
    maps: list[_AxisMap | None]

    @classmethod
    def of(cls, steps: tuple[Step, ...]) -> StepChain:
        """Return a chain with its maps."""
        return cls(steps, [_shift(step) if isinstance(step, Translate) else _axis_map(step) for step in steps])


def surface_name(form: UprightForm | Surface, chain: StepChain) -> Hashable:
    """Name a surface that steps carry: equal names are equal surfaces with the same inside, or equal planes."""
    steps, maps = chain
    if not isinstance(form, UprightForm):
        return form, steps
    flat, weights, center, constant = form
    count = 0
    for step, axes in zip(steps, maps, strict=True):
        if axes is not None:
            center = [
                factor * center[k] + shift if weights[k] and (shift or factor != 1) else center[k]
                for k, factor, shift in axes
            ]
            if not isinstance(step, Translate):
                weights = [
                    weights[k] / (factor if flat else factor * factor) if weights[k] and factor != 1 else weights[k]
                    for k, factor, _ in axes
                ]
        elif not _is_kept(step, weights, center, flat):
            break
        count += 1
    free = frozenset(axis for axis, weight in enumerate(weights) if not weight)
    rest = _steps_across(steps[count:], free) if free else steps[count:]
    lead = next((weight for weight in weights if weight), Fraction(1))
    scale = lead if flat else abs(lead)
    ratios = ((w / scale if w != scale else 1) if w else 0 for w in weights)
    if flat:
        return (rest, *ratios, sum((w * c for w, c in zip(weights, center, strict=True) if c), constant) / scale)
    return (rest, *ratios, *center, constant / scale)


class _NotRationalError(Exception):
    """A surface has a number that is no fraction, or it is turned in its own frame."""


class UprightForm(NamedTuple):
    """w·(x - c) = d if flat, else the sum of w[i] (x[i] - c[i])² = d, in fractions; c[i] = 0 where w[i] = 0."""

    flat: bool
    weights: Sequence[Fraction]
    center: Sequence[Fraction]
    constant: Fraction

    @classmethod
    def of(cls, surface: Surface) -> UprightForm | Surface:
        """Return the form of a surface, or the surface itself if its numbers are no fractions or it is not upright."""
        try:
            if isinstance(surface, PlaneSurface):
                normal = [_rational(n) for n in surface.normal]
                return cls(True, normal, [Fraction(0)] * 3, _rational(surface.offset))
            return cls._of_quadric(surface)
        except _NotRationalError:
            return surface

    @classmethod
    def _of_quadric(cls, surface: QuadricSurface) -> UprightForm:
        """Return a quadric with squares completed."""
        constant, weights, center = _rational(surface.constant), [], []
        for axis, row in enumerate(surface.rows):
            square, linear, factor = map(_rational, (surface.squares[axis], surface.linear[axis], row[axis]))
            if any(row[k] for k in range(3) if k != axis) or (linear and not square):
                raise _NotRationalError
            weights.append(square * factor * factor)
            center.append(_rational(surface.anchor[axis]) - linear / (square * factor) if square else Fraction(0))
            constant += linear * linear / square if linear else 0
        return cls(False, weights, center, constant)


def _rational(value: Any) -> Fraction:
    """Return a number as a fraction; raise `_NotRationalError` for one that was rounded or has derivatives."""
    if isinstance(value, (float, Fraction, int)) or (isinstance(value, ex.BigFloat) and not value.off):
        return ex.fraction(value)
    raise _NotRationalError


def _shift(step: Translate) -> _AxisMap:
    """Return the map of a translation."""
    return tuple((k, 1, Fraction(t) if t else 0) for k, t in enumerate(step.offset))


@lru_cache(maxsize=1 << 12)
def _axis_map(step: Step) -> _AxisMap | None:
    """Return a step that takes axes to axes, in fractions; None for others, whose numbers may be rounded."""
    if isinstance(step, Rotate) and (step.degrees % 90 or sum(map(bool, step.axis)) > 1):
        return None
    rows, shift = step.forth_and_back[0]
    numbers = [*(x for row in rows for x in row), *shift]
    if any(x.off for x in numbers) or any(sum(map(bool, line)) != 1 for line in (*rows, *zip(*rows, strict=True))):
        return None
    sources = [next(k for k in range(3) if row[k]) for row in rows]
    factors = [ex.fraction(row[k]) for k, row in zip(sources, rows, strict=True)]
    return tuple(
        (k, f if abs(f) != 1 else int(f), ex.fraction(t)) for k, f, t in zip(sources, factors, shift, strict=True)
    )


def _is_kept(step: Step, weights: Sequence[Fraction], center: Sequence[Fraction], flat: bool) -> bool:
    """Return whether a rotation about an axis leaves a surface where it is."""
    axis = _rotation_axis(step)
    if axis is None:
        return False
    i, j = (k for k in range(3) if k != axis)
    return weights[i] == weights[j] and not (weights[i] and (flat or center[i] or center[j]))


def _rotation_axis(step: Step) -> int | None:
    """Return the coordinate axis that a step rotates about; None for other steps."""
    along = [k for k in range(3) if step.axis[k]] if isinstance(step, Rotate) else []
    return along[0] if len(along) == 1 else None


@lru_cache(maxsize=1 << 12)
def _steps_across(steps: tuple[Step, ...], free: frozenset[int]) -> tuple[Step, ...]:
    """Return steps without shifts along axes that lie in a surface everywhere: they carry it to the same one.

    So the caps of parallel wires, side by side, are one plane.
    """
    kept: list[Step] = []
    for number, step in enumerate(steps):
        if not free:
            return (*kept, *steps[number:])
        if isinstance(step, Translate):
            if not all(k in free or not t for k, t in enumerate(step.offset)):
                x, y, z = (0.0 if k in free else t for k, t in enumerate(step.offset))
                kept.append(Translate((x, y, z)))
            continue
        axes = _axis_map(step)
        if axes is not None:
            free = frozenset(axis for axis, (k, _, _) in enumerate(axes) if k in free)
        elif isinstance(step, Transform):
            matrix = step.matrix
            free = frozenset(k for k in free if matrix[k][k] and not any(matrix[j][k] for j in range(3) if j != k))
        else:
            free = free & {_rotation_axis(step)}
        if isinstance(step, Transform):
            a, b, c = ((*row[:3], 0.0) if k in free else row for k, row in enumerate(step.matrix[:3]))
            step = Transform((a, b, c, step.matrix[3]))
        kept.append(step)
    return tuple(kept)


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

    def known_names(self, clusters: Sequence[Longs]) -> dict[int, Hashable]:
        """Return names, known without exact keys, that are equal only for surfaces that are certainly equal.

        Surfaces are compared within clusters. Empty for few surfaces, for which exact keys are as quick.
        """
        if sum(map(len, clusters)) < FEWEST_SURFACES:
            return {}
        parts: dict[int, tuple[Any, tuple[Step, ...], int]] = {}
        for body, numbers in surface_owners(self.first, np.concatenate(clusters)).items():
            leaves = _shape_leaves(self._single(body))
            if leaves is not None:
                parts.update((int(self.first[body]) + number, leaves.of(number)) for number in numbers)
        names: dict[int, Hashable] = {}
        chains: dict[tuple[int, int], StepChain] = {}
        for cluster in clusters:
            # A volume is often a part of its mother, too: one surface of one primitive needs no name
            some = {index: parts[index] for index in cluster.tolist() if index in parts}
            ids = {index: (id(leaf), id(steps), own) for index, (leaf, steps, own) in some.items()}
            is_one = len(some) == len(cluster) and len(set(ids.values())) == 1
            # The first surface of a name stands for it, so that long names are compared once
            named: dict[Hashable, Hashable] = {}
            firsts: dict[Hashable, tuple[int]] = {}
            for index, (leaf, steps, own) in some.items():
                key = ids[index]
                if key not in named and not is_one:
                    if key[:2] not in chains:
                        chains[key[:2]] = StepChain.of((*leaf.placement.steps, *steps))
                    name = surface_name(own_forms(leaf)[own], chains[key[:2]])
                    named[key] = firsts.setdefault(name, (index,))
                names[index] = named.get(key, key)
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
