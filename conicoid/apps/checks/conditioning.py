"""How many decimal digits of each body its numbers leave, and which number loses them: docs/dev/conditioning.md.

The worst place of a body is that of its worst primitive. Balls, polygons and triangles have formulas of their own;
other primitives are tested at the points of `critical_points.py`.
"""

from __future__ import annotations

import itertools
import math
import re
from collections.abc import Callable, Iterator, Sequence, Set
from functools import lru_cache
from typing import Any

import numpy as np
import numpy.typing as npt

from ..._util.arrays import FloatArray, Vector
from ..._util.records import dataclass
from ...geometry.bulk import Bulk, Spheres
from ...geometry.instances import InstanceList, transform_offsets
from ...geometry.primitives import Cylinder, Sphere
from ...geometry.shape import Boolean, ClippedSheet, Shape
from ...geometry.sheets import Polygon, Triangle, newell_sum
from ...geometry.transform import IDENTITY_MOTION, Motion
from ...numerics import bigfloat as ex
from ...queries.scene_protocol import SceneLike
from ..measures.hull import moved_parts
from .critical_points import Movement, TestedPart, least_displacement, movement
from .perturbation import (
    HALF_ULP,
    Extent,
    LocalFrame,
    MotionFields,
    OwnForms,
    fields_of,
    has_face_shifts,
    localize,
    own_frame,
)
from .probe_rays import ProbeTargets

ALL_DIGITS = 53 * math.log10(2)
"""Decimal digits of float64: 15.95."""
_NOTABLE = 1e3
"""A cause of lost digits is named if it is larger than this."""


@dataclass(frozen=True, eq=False)
class Conditioning:
    """The digits of a body at its worst place.

    body      id of the body
    part      class name of the primitive
    digits    decimal digits that remain, 0 to 15.95: -log10 of `movement`
    movement  how far the surface moves, in units of the part's extent in that direction, when each number of the shape
              changes by a relative 2^-53
    number    the number that contributes most, as scene files name it
    point     (3,) the place in the world
    reason    the causes in words
    """

    body: int
    part: str
    digits: float
    movement: float
    number: str
    point: FloatArray
    reason: str


def digits_of(relative: float) -> float:
    """Return -log10 of a relative movement, clamped to 0 ... ALL_DIGITS."""
    return ALL_DIGITS if relative <= 0 else min(max(-math.log10(relative), 0.0), ALL_DIGITS)


def verdict(part: type[Shape], motion: Motion, body: int, moved: Movement, frame: LocalFrame) -> Conditioning:
    """Return the conditioning of a primitive from its worst movement.

    `frame` takes local coordinates to the primitive's own, and `motion` takes those to the world.
    """
    linear, shift = motion.affine
    z = ex.exact_row(moved.local.tolist())
    own = ex.exact_row(ex.dot(row, z, start) for row, start in zip(frame.columns, frame.origin, strict=True))
    point = np.array([float(ex.dot(row, own, t)) for row, t in zip(linear, shift, strict=True)])
    return Conditioning(
        body,
        part.__name__,
        digits_of(moved.relative),
        moved.relative,
        _number(moved.number, motion),
        point,
        _reason(moved, point, linear, ex.multiply(linear, frame.columns)),
    )


def _number(name: str, motion: Motion) -> str:
    """Return a number's name as in scene files: steps[0].degrees of a rotation is move[0].rotate.degrees."""
    match = re.match(r"steps\[(\d+)\]\.(.*)", name)
    # A number of the shape itself: its name is that of scene files
    if match is None:
        return name
    step, field = int(match[1]), match[2]
    verb = type(motion.steps[step]).__name__.lower()
    # Scene files give these fields without their name, as the value of the step
    field = re.sub(r"^(offset|factors|matrix)", "", field)
    return f"move[{step}].{verb}{field if not field or field.startswith('[') else f'.{field}'}"


def _sine(normals: FloatArray) -> float:
    """Return the volume spanned by the unit vectors along one, two or three vectors; 0 if they are parallel."""
    lengths = np.linalg.norm(normals, axis=1, keepdims=True)
    # One surface alone, or a surface without a normal, has no angle to name
    if len(normals) == 1 or not lengths.all():
        return 1.0
    units = normals / lengths
    across = np.cross(units[0], units[1])
    return float(np.linalg.norm(across) if len(units) == 2 else abs(across @ units[2]))


def _reason(moved: Movement, point: FloatArray, linear: ex.Rows, to_world: ex.Rows) -> str:
    """Return the two largest causes of lost digits in words, the largest first."""
    if moved.relative < _NOTABLE * HALF_ULP:
        return "no digits are lost"
    back, forth = _floats(ex.inverse(to_world)), _floats(to_world)
    with np.errstate(all="ignore"):  # sizes may be beyond float64
        # Gradients are covectors: they go to the world by the inverse matrix
        slope = np.linalg.norm(moved.gradient @ back)
        width = moved.width / slope if 0 < slope < math.inf else np.linalg.norm(forth, -2)
        far, long = float(np.linalg.norm(point) / width), float(np.linalg.norm(forth, 2) / width)
        stretch = float(np.linalg.cond(_floats(linear)))
        sine = 1.0 if moved.normals is None else _sine(moved.normals @ back)
    causes = [
        (far, f"it lies {far:.1e} times its extent from the origin"),
        (long, f"it is {long:.1e} times as long as thick"),
        (stretch, f"its motion is nearly singular, of condition number {stretch:.1e}"),
        (1 / sine if sine else 0.0, f"surfaces meet there at {sine:.1e} rad"),
        (math.inf if moved.singular else 0.0, "its surfaces touch, or one has a double point, there"),
    ]
    words = [words for size, words in sorted(causes, reverse=True) if size > _NOTABLE]
    return ", ".join(words[:2]) or "its numbers cancel"


def _floats(rows: ex.Rows) -> FloatArray:
    """Round an exact matrix to float64."""
    return np.array([[float(c) for c in row] for row in rows])


# Digits of balls, by a formula and all at once.

_STEPS = 4
"""Steps from the worst axis towards the worst direction."""


@dataclass(frozen=True, eq=False)
class BallsConditioning:
    """The worst movements of the balls of one entry, or of single ones that share a motion.

    shape      the entry
    bodies     (N,) ids of the balls
    single     each ball is a body of its own
    fields     the motion's fields in the coordinates of the balls
    relative   (N,) movement in units of the diameter
    where      (N, 3) unit vector from the center to the worst place
    """

    shape: Spheres
    bodies: npt.NDArray[np.int64]
    single: bool
    fields: MotionFields
    relative: FloatArray
    where: FloatArray

    @classmethod
    def of(cls, shape: Spheres, bodies: npt.NDArray[np.int64], single: bool = False) -> BallsConditioning:
        """Compute the movements of all balls of an entry."""
        # All balls share the motion: its fields are taken once, about the origin of their coordinates
        fields = fields_of(shape.motion, LocalFrame(ex.exact_row((0.0, 0.0, 0.0)), ex.IDENTITY))
        return cls(shape, bodies, single, fields, *ball_movements(shape.centers, shape.radii, fields))

    @classmethod
    def of_single(cls, balls: Sequence[Sphere], motion: Motion, bodies: npt.NDArray[np.int64]) -> BallsConditioning:
        """Compute the movements of single balls that share a motion."""
        shape = Spheres([ball.center for ball in balls], [ball.radius for ball in balls], motion=motion)
        return cls.of(shape, bodies, single=True)

    @property
    def digits(self) -> FloatArray:
        """(N,) decimal digits that remain, as `digits_of` has them."""
        with np.errstate(divide="ignore"):
            result: FloatArray = np.clip(-np.log10(self.relative), 0.0, ALL_DIGITS)
        return result

    def below(self, limit: float, most: int | None) -> Iterator[Conditioning]:
        """Yield the balls with fewer digits than a limit, in order; the worst `most` of them if they are more."""
        digits = self.digits
        few = np.flatnonzero(digits < limit)
        if most is not None and len(few) > most:
            # The worst of them, in the order of their ids
            few = np.sort(few[np.argsort(digits[few], kind="stable")[:most]])
        yield from map(self.of_ball, few.tolist())

    def of_ball(self, i: int) -> Conditioning:
        """Return the conditioning of ball i."""
        center_name, radius_name = ("center", "radius") if self.single else (f"centers[{i}]", f"radii[{i}]")
        center, radius, n = self.shape.centers[i], float(self.shape.radii[i]), self.where[i]
        shares = ball_shares(center, radius, n, self.fields)
        names = *(f"{center_name}[{k}]" for k in range(3)), radius_name, *self.fields.numbers
        number = names[int(shares.argmax())]
        worst = Movement(float(self.relative[i]), number, radius * n, n, 2 * radius)
        part = Sphere if self.single else Spheres
        frame = LocalFrame(ex.exact_row(center.tolist()), ex.IDENTITY)
        return verdict(part, self.shape.motion, int(self.bodies[i]), worst, frame)


def ball_movements(centers: FloatArray, radii: FloatArray, fields: MotionFields) -> tuple[FloatArray, FloatArray]:
    """Return the worst movement (N,) of each ball, and the direction (N, 3) from its center to that place.

    `fields` are those of the balls' own coordinates. Along the unit vector n the surface moves by
    Σ |n_k c_k| + r for the ball's own numbers, and by n·field(c + r n) for each number of a motion. From the worst
    axis, n turns to the sum of all changes with their signs, which makes the sum of their sizes grow.
    """
    worst, where = np.zeros(len(radii)), np.zeros((len(radii), 3))
    # Row k of a ball is c_k e_k: times 2^-53 it is the shift by coordinate k of the center
    own = np.eye(3) * centers[:, None, :]

    def look(n: FloatArray) -> FloatArray:
        """Update the worst directions by n (N, 3); return the sum of all changes with the signs that they have at n."""
        points = centers + radii[:, None] * n
        goes = [*own.transpose(1, 0, 2) * HALF_ULP, *(points @ field[:, :3].T + field[:, 3] for field in fields.fields)]
        along = [(vector * n).sum(axis=1) for vector in goes]
        change = HALF_ULP * radii + sum(np.abs(one) for one in along)
        # In units of the diameter, width and bend of a sphere are 1
        relative = least_displacement(change / (2 * radii), 1.0, 1.0)
        better = relative > worst
        worst[better], where[better] = relative[better], n[better]
        return np.sum([np.copysign(1.0, one)[:, None] * one_ for one, one_ in zip(along, goes, strict=True)], axis=0)

    # The worst axis is the start of the search
    for start in np.eye(3):
        look(np.broadcast_to(start, centers.shape))
    n = where.copy()
    for _ in range(_STEPS):
        total = look(n)
        lengths = np.linalg.norm(total, axis=1)
        # A ball that nothing moves keeps its direction
        n = np.where(lengths[:, None] > 0, total / np.where(lengths > 0, lengths, 1.0)[:, None], n)
    look(n)
    return worst, where


def ball_shares(center: FloatArray, radius: float, n: FloatArray, fields: MotionFields) -> FloatArray:
    """Return the share of each number of one ball in its movement: center, radius, then those of the motion."""
    own = HALF_ULP * np.append(np.abs(n * center), radius)
    return np.append(own, np.abs(fields.fields @ np.append(center + radius * n, 1.0) @ n))


# Digits of cylinders, from below: most need no exact forms.


def least_digits(shape: Cylinder) -> float:
    """Return digits that a cylinder certainly has; 0 for a wedge and for one with a motion.

    Let u = 2^-53, and let c be the sum of the sizes of the six coordinates of its ends. By all of them the axis moves
    by u c at most, and by the radius the side moves by u r, across its width 2r. A cap moves along the axis with its
    middle by u c at most, and at its rim by u c r / h more, as the axis turns; the width there is the height h. Normals
    of side and caps are at right angles, so that edges move no further. The sum of both is twice as much as needed,
    which leaves room for terms of second order.
    """
    if shape.motion.steps or shape.end_angle - shape.start_angle < 360:
        return 0.0
    (x, y, z), (a, b, c), r = shape.start, shape.end, shape.radius
    far = abs(x) + abs(y) + abs(z) + abs(a) + abs(b) + abs(c) + r
    height = math.dist(shape.start, shape.end)
    return digits_of(HALF_ULP * far * (1 / r + 2 * (1 + r / height) / height)) if height else 0.0


# Digits of polygons and triangles: how far corners move, relative to the polygon's width across each edge.

_MOST_EDGES = 128
"""About how many edges of a polygon give directions; of more, every second, third and so on."""


def polygon_movement(leaf: Polygon | Triangle, motion: Motion) -> tuple[Movement, LocalFrame]:
    """Return the worst movement of a corner, and the local frame: the polygon's own about its first corner.

    Directions are across an edge within the plane, and across the plane; the latter counts against the least width.
    A corner moves by u |v_k| for each of its coordinates, u = 2^-53, and by the fields of the motion's numbers.
    """
    own = leaf.vertices if isinstance(leaf, Polygon) else (leaf.a, leaf.b, leaf.c)
    names = [f"vertices[{k}]" for k in range(len(own))] if isinstance(leaf, Polygon) else ["a", "b", "c"]
    start = ex.exact_row(own[0])
    frame = LocalFrame(start, ex.IDENTITY)
    fields = fields_of(motion, frame)
    # Exact differences, so that a polygon far from the origin keeps its digits
    corners = [ex.exact_row(ex.exact(a) - b for a, b in zip(vertex, start, strict=True)) for vertex in own]
    covectors, widths = _directions(corners, motion)
    h = np.array([[*(float(c) for c in corner), 1.0] for corner in corners])
    by_own = HALF_ULP * np.abs(covectors[:, None, :] * np.array(own)[None, :, :])
    by_field = np.abs(np.einsum("ei,mij,vj->evm", covectors, fields.fields, h, optimize=True))
    relative = (by_own.sum(axis=2) + by_field.sum(axis=2)) / widths[:, None]
    e, v = np.unravel_index(int(relative.argmax()), relative.shape)
    shares = np.concatenate([by_own[e, v], by_field[e, v]])
    number = (*(f"{names[v]}[{k}]" for k in range(3)), *fields.numbers)[int(shares.argmax())]
    return Movement(float(relative[e, v]), number, h[v, :3], covectors[e], float(widths[e])), frame


def _directions(corners: list[ex.Row], motion: Motion) -> tuple[FloatArray, FloatArray]:
    """Return directions of the world as covectors (E, 3) of the own frame, and the polygon's widths (E,) along them.

    They are across (at most about 128 of) the edges within the plane, and last across the plane, with the least of the
    widths. The world is scaled so that the largest coordinate is 1.
    """
    rows, _ = motion.affine
    carried = [ex.apply(rows, corner) for corner in corners]
    size = max(abs(c) for corner in carried for c in corner)
    points = np.array([[float(c / size) for c in corner] for corner in carried])
    linear = np.array([[float(c / size) for c in row] for row in rows])
    normal = np.array([float(c) for c in ex.unit(newell_sum(carried))])
    edges = np.roll(points, -1, axis=0) - points
    across = np.cross(normal, edges[:: -(-len(edges) // _MOST_EDGES)])
    # Edges of length 0 have no direction
    across = across[np.abs(across).max(axis=1) > 0]
    across = across / np.linalg.norm(across, axis=1)[:, None]
    heights = across @ points.T
    widths = heights.max(axis=1) - heights.min(axis=1)
    # Covectors of the own frame: movements and widths are in the same scale
    return np.concatenate([across, normal[None]]) @ linear, np.append(widths, widths.min())


# Digits of all bodies of a scene.

SINGLE_PRECISION_DIGITS = 24 * math.log10(2)
"""`check` reports fewer digits than this: those of single precision, 7.22."""

_MARGIN = 1e-3
"""The box of a body is enlarged by this share in a part's frame."""
_CACHE_SIZE = 1024
"""Parts whose frames and tests are kept, for others that differ by their motion alone."""
_CORNER_MARGIN = 0.5
"""Digits: more than terms of second order and other test points change between the corners of a box of shifts."""

Progress = Callable[[int, int], Any]
"""progress(done, total)"""


def conditioning(
    scene: SceneLike, below: float = math.inf, most: int | None = None, progress: Progress | None = None
) -> list[Conditioning]:
    """Return the worst place of every body with fewer than `below` digits, in order of their ids.

    An empty body has no place to test and is left out. A primitive takes some 20 milliseconds, or 2 if it differs from
    another by its motion alone; a cylinder that certainly has `below` digits takes microseconds. A million `Spheres`
    take one second, and half a millisecond for each one returned.

    Parameters
    ----------
    scene : Scene
        Its balls that share a motion are tested all at once, other bodies one by one.
    below : float
        Digits; bodies with as many or more are left out.
    most : int, optional
        The largest number of balls returned for each entry of `Spheres`, and of single balls for each motion that they
        share: the worst. Default: all.
    progress : callable, optional
        progress(done, total) is called after each entry of the scene.

    Returns
    -------
    list of Conditioning
    """
    found: list[Conditioning] = []
    for one in _examine_bodies(scene, below, progress):
        if isinstance(one, BallsConditioning):
            found.extend(one.below(below, most))
        elif one.digits < below:
            found.append(one)
    return sorted(found, key=lambda one: one.body)


def digits(scene: SceneLike) -> FloatArray:
    """Return the decimal digits (bodies,) that remain of every body, NaN for an empty one.

    Parameters
    ----------
    scene : Scene

    Returns
    -------
    float64 (bodies,)
        0 to 15.95.
    """
    result = np.full(scene.body_count, np.nan)
    for one in _examine_bodies(scene, math.inf, None):
        if isinstance(one, BallsConditioning):
            result[one.bodies] = one.digits
        else:
            result[one.body] = one.digits
    return result


def _examine_bodies(
    scene: SceneLike, below: float, progress: Progress | None
) -> Iterator[Conditioning | BallsConditioning]:
    """Yield the conditioning of each body, of `Spheres` and of balls that share a motion all at once.

    Empty bodies are left out, and instances that certainly have `below` digits or more.
    """
    lowered = scene._prepared.lowered
    if lowered.body_count == 0:
        return
    examiner, first = _BodyExaminer(ProbeTargets.of(lowered), below), 0
    bodies = scene.bodies
    balls: dict[Motion, dict[int, Sphere]] = {}
    good = examiner.good_instances(bodies) if isinstance(bodies, InstanceList) else frozenset()
    for item in range(len(bodies)):
        # A list of instances builds each body
        body = None if item in good else bodies[item]
        if body is None:
            first += 1
        elif isinstance(body.shape, Spheres):
            yield BallsConditioning.of(body.shape, np.arange(first, first + len(body.shape)))
            first += len(body.shape)
        elif isinstance(body.shape, Sphere):
            balls.setdefault(body.shape.motion, {})[first] = body.shape
            first += 1
        # Other entries of many bodies: one body at a time
        elif isinstance(body.shape, Bulk):
            for index in range(len(body.shape)):
                condition = examiner.worst(body.shape.single(index), first + index)
                if condition is not None:
                    yield condition
            first += len(body.shape)
        else:
            condition = examiner.worst(body.shape, first)
            if condition is not None:
                yield condition
            first += 1
        if progress is not None:
            progress(item + 1, len(bodies))
    for motion, some in balls.items():
        yield BallsConditioning.of_single([*some.values()], motion, np.array([*some]))


def parts(shape: Shape) -> Iterator[tuple[Any, Motion]]:
    """Yield the primitives of a shape without their motions, and the motion that takes each to the world."""
    for leaf, outer in moved_parts(shape):
        # No constructor runs: that of a mesh cuts it into convex parts
        yield leaf._with_motion(IDENTITY_MOTION), leaf.motion.then(outer)


class _BodyExaminer:
    """Tests bodies; prepares parts that differ by their motion alone once. `below` is as of `conditioning`."""

    def __init__(self, targets: ProbeTargets, below: float) -> None:
        self.targets, self.below = targets, below
        self._own_frame = lru_cache(_CACHE_SIZE)(own_frame)
        self._own_forms = lru_cache(_CACHE_SIZE)(OwnForms)
        self._prepared_part = lru_cache(_CACHE_SIZE)(_part)

    def good_instances(self, bodies: InstanceList) -> Set[int]:
        """Return the numbers of instances whose kind has `below` digits or more wherever it is.

        A number's effect on a surface is the absolute value of an affine function of the shift, and their sum is
        convex: it is largest at a corner of the box of all shifts. So the corners decide for all instances of a kind.
        """
        good: set[int] = set()
        for kind, numbers in enumerate(bodies.members):
            if len(numbers) < 2 or not bodies.is_rigid(kind):
                continue
            shifts, at = bodies.shifts.select(numbers), int(numbers[0])
            used = (
                [values[k] for k in set(index)]
                for values, index in zip(shifts.values, shifts.index.tolist(), strict=True)
            )
            ends = [{min(shift), max(shift)} for shift in used]
            corners = list(itertools.product(*ends))
            if len(corners) >= len(numbers):
                continue
            offsets = np.array(
                [[float(x - y) for x, y in zip(corner, shifts.of(0), strict=True)] for corner in corners]
            )
            offsets = transform_offsets(offsets, bodies.motion(kind))
            low, high = self.targets.box(at)
            conditions = (
                self._of_shape(bodies.shape_at(kind, corner), at, (low + offset, high + offset))
                for corner, offset in zip(corners, offsets, strict=True)
            )
            if all(one is None or one.digits >= self.below + _CORNER_MARGIN for one in conditions):
                good.update(numbers.tolist())
        return good

    def worst(self, shape: Shape, body: int) -> Conditioning | None:
        """Return the conditioning of a body's worst part; None if it is empty or certainly has `below` digits."""
        # The bonds of a molecule: thousands, no two alike
        if isinstance(shape, Cylinder) and least_digits(shape) >= self.below:
            return None
        return self._of_shape(shape, body, self.targets.box(body))

    def _of_shape(self, shape: Shape, body: int, box: Extent) -> Conditioning | None:
        """Return the conditioning of the worst part of a shape within a box, with the number `body`."""
        low, high = box
        if (low > high).any():
            return None
        whole = not isinstance(shape, (Boolean, ClippedSheet))
        conditions = [self._part(leaf, motion, body, (low, high), whole) for leaf, motion in parts(shape)]
        return min((one for one in conditions if one is not None), key=lambda one: one.digits, default=None)

    def _part(self, leaf: Any, motion: Motion, body: int, box: Extent, whole: bool) -> Conditioning | None:
        """Return the conditioning of one primitive within its body's box; `whole` if it is all of the body."""
        if isinstance(leaf, Sphere):
            return BallsConditioning.of_single([leaf], motion, np.array([body])).of_ball(0)
        if isinstance(leaf, (Polygon, Triangle)):
            return verdict(type(leaf), motion, body, *polygon_movement(leaf, motion))
        frame, own, size = self._own_frame(leaf)
        # A part of a combination, or an infinite one, counts only as far as its body reaches
        cut = not whole or not np.isfinite(own).all()
        extent = _intersect_extents(own, self._tested_extent(body, box, motion, frame, size)) if cut else own
        # The part lies outside of its body's box
        if not (extent[0] <= extent[1]).all():
            return None
        low, high = _thicken(extent, frame, leaf.is_sheet)
        where = self._own_forms(leaf), frame, tuple(low.tolist()), tuple(high.tolist()), cut
        if self.below < math.inf and has_face_shifts(leaf):
            # A change of each number takes all forms once more, and cuts a flat solid into convex parts once more
            bounded = self._prepared_part(*where, True)
            most = movement(bounded, fields_of(motion, bounded.local.frame), leaf.is_sheet)
            if most is None or digits_of(most.relative) >= self.below + _CORNER_MARGIN:
                return None
        part = self._prepared_part(*where)
        displacement = movement(part, fields_of(motion, part.local.frame), leaf.is_sheet)
        return None if displacement is None else verdict(type(leaf), motion, body, displacement, part.local.frame)

    def _tested_extent(self, body: int, box: Extent, motion: Motion, frame: LocalFrame, size: FloatArray) -> Extent:
        """Return the extent to test along a part's axes: its body's box; at least twice its size if it is infinite."""
        low, high = _extent_in_frame(box, motion, frame)
        if self.targets.endless(body):
            return np.minimum(low, -2 * size), np.maximum(high, 2 * size)
        return low, high


def _part(own: OwnForms, frame: LocalFrame, low: Vector, high: Vector, cut: bool, bounded: bool = False) -> TestedPart:
    """Return a primitive in coordinates of its extent, with its test points; `low` and `high` are hashable."""
    return TestedPart.of(localize(own, frame.scaled((np.array(low), np.array(high))), cut, bounded))


def _extent_in_frame(box: Extent, motion: Motion, frame: LocalFrame) -> Extent:
    """Return how far a box of the world reaches along the axes of a part's frame."""
    back, shift = motion.inverse
    own = ex.inverse(frame.columns)
    middle = ex.exact_row((ex.exact(a) + ex.exact(b)) / 2 for a, b in zip(*(end.tolist() for end in box), strict=True))
    at = [ex.dot(row, middle, t, -start) for row, t, start in zip(back, shift, frame.origin, strict=True)]
    center = np.array([float(c) for c in ex.apply(own, (at[0], at[1], at[2]))])
    reach = np.array([[float(c) for c in row] for row in ex.multiply(own, back)])
    # The axis-aligned box around the rotated box
    half = np.abs(reach) @ ((box[1] - box[0]) / 2) * (1 + _MARGIN)
    return center - half, center + half


def _intersect_extents(one: Extent, other: Extent) -> Extent:
    """Return the common part of two extents; low > high if there is none."""
    return np.maximum(one[0], other[0]), np.minimum(one[1], other[1])


def _thicken(extent: Extent, frame: LocalFrame, is_sheet: bool) -> Extent:
    """Give directions without extent, and all directions of sheets, the largest extent; a point that of its place."""
    size, middle = extent[1] - extent[0], (extent[0] + extent[1]) / 2
    largest = float(size.max()) or max(abs(float(c)) for c in frame.origin) or 1.0
    size = np.where((size <= 0) | is_sheet, largest, size)
    return middle - size / 2, middle + size / 2
