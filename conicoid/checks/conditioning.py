"""How many decimal digits of each body its numbers leave, and which number loses them: docs/conditioning.md."""

from __future__ import annotations

import dataclasses
import math
from collections.abc import Callable, Iterator
from dataclasses import dataclass
from typing import TYPE_CHECKING, Any

import numpy as np

from ..shapes import exact as ex
from ..shapes.base import Shape
from ..shapes.motion import STILL, Motion
from ..shapes.polygon import Polygon
from ..shapes.region import Boolean, ClippedSheet
from ..shapes.sphere import Sphere
from ..shapes.spheres import Spheres
from ..shapes.triangle import Triangle
from ..shapes.vector import FloatArray
from .aim import Targets
from .changes import HALF_ULP
from .local import Extent, Frame, Local, fields_of, local, own_frame
from .movement import Movement, ball_movements, movement, polygon_movement

if TYPE_CHECKING:
    from ..scene import Scene

ALL_DIGITS = 53 * math.log10(2)
"""What float64 has: 15.95."""
FEW = 8.0
"""Fewer digits than this are reported."""

_NOTABLE = 1e3
_MARGIN = 1e-3

Progress = Callable[[int, int], Any]


@dataclass(frozen=True, eq=False)
class Conditioning:
    """What is left of a body's digits where that is least.

    body      its id
    part      the kind of the primitive
    digits    decimal digits that remain, 0 to 15.95: -log10 of `movement`
    movement  how far the surface moves, in units of the part's extent in that direction, when each number that was
              written changes by a relative 2^-53
    number    the number that most of it comes from
    point     (3,) where that is
    reason    why, in words
    """

    body: int
    part: str
    digits: float
    movement: float
    number: str
    point: FloatArray
    reason: str


def conditioning(scene: Scene, below: float = math.inf, progress: Progress | None = None) -> list[Conditioning]:
    """The worst place of every body with fewer than `below` digits, in order of their ids.

    A body of which nothing is left to look at (an empty one) is missing. Bodies of a million `Spheres` take a second,
    others some milliseconds for each kind of part and less for the same part moved elsewhere.
    """
    lowered = scene.lowered
    if lowered.body_count == 0:
        return []
    examiner, found, first = _Examiner(Targets.of(lowered)), [], 0
    for item, body in enumerate(scene.bodies):
        if isinstance(body.shape, Spheres):
            found.extend(_balls(body.shape, first, below))
            first += len(body.shape)
        else:
            worst = examiner.worst(body.shape, first)
            if worst is not None and worst.digits < below:
                found.append(worst)
            first += 1
        if progress is not None:
            progress(item + 1, len(scene.bodies))
    return found


def digits_of(relative: float) -> float:
    """-log10, between none and all that float64 has."""
    return ALL_DIGITS if relative <= 0 else min(max(-math.log10(relative), 0.0), ALL_DIGITS)


def parts(shape: Shape, outer: Motion = STILL) -> Iterator[tuple[Any, Motion]]:
    """The primitives of a shape without their motions, and what motion takes each to the world."""
    pending: list[tuple[Any, Motion]] = [(shape, outer)]
    while pending:
        node, motion = pending.pop()
        own = node.motion.then(motion)
        if isinstance(node, Boolean):
            pending.extend((part, own) for part in reversed(node.operands))
        elif isinstance(node, ClippedSheet):
            pending.extend((part, own) for part in (node.solid, node.base))
        else:
            yield dataclasses.replace(node, motion=STILL), own


class _Examiner:
    """Looks at bodies, and at parts that only differ by their motion once."""

    def __init__(self, targets: Targets) -> None:
        self.targets = targets
        self._known: dict[Any, tuple[Frame, Extent]] = {}
        self._local: dict[Any, Local] = {}

    def worst(self, shape: Shape, body: int) -> Conditioning | None:
        """The worst part of a body."""
        low, high = self.targets.box(body)
        if (low > high).any():
            return None
        whole = not isinstance(shape, (Boolean, ClippedSheet))
        found = [self._part(leaf, motion, body, (low, high), whole) for leaf, motion in parts(shape)]
        return min((one for one in found if one is not None), key=lambda one: one.digits, default=None)

    def _part(self, leaf: Any, motion: Motion, body: int, box: Extent, whole: bool) -> Conditioning | None:
        if isinstance(leaf, Sphere):
            return _ball(leaf, motion, body)
        if isinstance(leaf, (Polygon, Triangle)):
            moved, frame = polygon_movement(leaf, motion)
            return _told(leaf, motion, body, moved, frame)
        if leaf not in self._known:
            self._known[leaf] = own_frame(leaf)
        frame, own = self._known[leaf]
        cut = not whole or not np.isfinite(own).all()
        extent = _common(own, _seen(box, motion, frame)) if cut else own
        if not (extent[0] <= extent[1]).all():
            return None
        extent = _thickened(extent, frame, leaf.is_sheet)
        key = (leaf, cut, extent[0].tobytes(), extent[1].tobytes())
        if key not in self._local:
            self._local[key] = local(leaf, frame.scaled(extent), cut)
        seen = self._local[key]
        moved = movement(seen, fields_of(motion, seen.frame), leaf.is_sheet)
        return None if moved is None else _told(leaf, motion, body, moved, seen.frame)


def _seen(box: Extent, motion: Motion, frame: Frame) -> Extent:
    """How far a box of the world reaches along the axes of a part's frame."""
    back, shift = motion.inverse
    own = ex.inverse(frame.columns)
    middle = ex.exact_row((ex.exact(a) + ex.exact(b)) / 2 for a, b in zip(*(end.tolist() for end in box), strict=True))
    at = [ex.dot(row, middle, t, -start) for row, t, start in zip(back, shift, frame.origin, strict=True)]
    center = np.array([float(c) for c in ex.apply(own, (at[0], at[1], at[2]))])
    reach = np.array([[float(c) for c in row] for row in ex.multiply(own, back)])
    half = np.abs(reach) @ ((box[1] - box[0]) / 2) * (1 + _MARGIN)
    return center - half, center + half


def _common(one: Extent, other: Extent) -> Extent:
    return np.maximum(one[0], other[0]), np.minimum(one[1], other[1])


def _thickened(extent: Extent, frame: Frame, is_sheet: bool) -> Extent:
    """Directions without any extent, and the thickness of sheets, take the largest; a point that of its place."""
    size, middle = extent[1] - extent[0], (extent[0] + extent[1]) / 2
    largest = float(size.max()) or max(abs(float(c)) for c in frame.origin) or 1.0
    size = np.where((size <= 0) | is_sheet, largest, size)
    return middle - size / 2, middle + size / 2


def _told(leaf: Any, motion: Motion, body: int, moved: Movement, frame: Frame) -> Conditioning:
    linear, shift = motion.affine
    z = ex.exact_row(moved.local.tolist())
    own = ex.exact_row(ex.dot(row, z, start) for row, start in zip(frame.columns, frame.origin, strict=True))
    point = np.array([float(ex.dot(row, own, t)) for row, t in zip(linear, shift, strict=True)])
    whole = ex.multiply(linear, frame.columns)
    back = np.array([[float(c) for c in row] for row in ex.inverse(whole)])
    to_world = np.array([[float(c) for c in row] for row in whole])
    slope = float(np.linalg.norm(back.T @ moved.gradient))
    width = moved.width / slope if slope else float(np.linalg.norm(to_world, -2))
    far, long = float(np.linalg.norm(point)) / width, float(np.linalg.norm(to_world, 2)) / width
    stretch = float(np.linalg.cond(np.array([[float(c) for c in row] for row in linear])))
    reason = _reason(moved, far, long, stretch)
    name = type(leaf).__name__
    return Conditioning(body, name, digits_of(moved.relative), moved.relative, _number(moved.number), point, reason)


def _number(name: str) -> str:
    return f"move {name}" if name.startswith("steps") else name


def _reason(moved: Movement, far: float, long: float, stretch: float) -> str:
    """What has been measured there and is large, the largest first."""
    if moved.relative < _NOTABLE * HALF_ULP:
        return "no digits are lost"
    causes = [
        (far, f"it lies {far:.1e} times its extent from the origin"),
        (long, f"it is {long:.1e} times as long as thick"),
        (stretch, f"its motion is nearly singular, of condition number {stretch:.1e}"),
        (1 / moved.sine if moved.sine else 0.0, f"surfaces meet there at {moved.sine:.1e} rad"),
        (math.inf if moved.singular else 0.0, "its surface has a double point there"),
    ]
    words = [words for size, words in sorted(causes, reverse=True) if size > _NOTABLE]
    return ", ".join(words[:2]) or "its numbers cancel"


def _ball(leaf: Sphere, motion: Motion, body: int) -> Conditioning:
    center, radius = np.array([leaf.center]), np.array([leaf.radius])
    frame = Frame(ex.exact_row(leaf.center), ex.IDENTITY)
    fields = fields_of(motion, Frame(ex.exact_row((0.0, 0.0, 0.0)), ex.IDENTITY))
    relative, where = ball_movements(center, radius, fields)
    return _ball_told(leaf, motion, body, float(relative[0]), where[0], frame, radius[0])


def _ball_told(
    leaf: Any, motion: Motion, body: int, relative: float, n: FloatArray, frame: Frame, radius: float
) -> Conditioning:
    number = "center" if motion.is_identity else "move"
    moved = Movement(relative, number, radius * n, n, 2 * float(radius))
    return _told(leaf, motion, body, moved, frame)


def _balls(shape: Spheres, first: int, below: float) -> Iterator[Conditioning]:
    fields = fields_of(shape.motion, Frame(ex.exact_row((0.0, 0.0, 0.0)), ex.IDENTITY))
    relative, where = ball_movements(shape.centers, shape.radii, fields)
    for i in np.flatnonzero(-np.log10(np.maximum(relative, 2.0**-53)) < below).tolist():
        frame = Frame(ex.exact_row(shape.centers[i].tolist()), ex.IDENTITY)
        yield _ball_told(shape, shape.motion, first + i, float(relative[i]), where[i], frame, float(shape.radii[i]))
