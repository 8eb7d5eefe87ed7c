"""How many decimal digits of each body its numbers leave, and which number loses them: docs/conditioning.md."""

from __future__ import annotations

import dataclasses
import math
from collections.abc import Callable, Iterator
from functools import lru_cache
from typing import TYPE_CHECKING, Any

import numpy as np

from ..shapes import exact as ex
from ..shapes.base import Shape
from ..shapes.bulk import Bulk
from ..shapes.motion import STILL, Motion
from ..shapes.polygon import Polygon
from ..shapes.region import Boolean, ClippedSheet
from ..shapes.sphere import Sphere
from ..shapes.spheres import Spheres
from ..shapes.triangle import Triangle
from ..shapes.vector import FloatArray, Vector
from .aim import Targets
from .balls import Balls, ball_verdict
from .local import Extent, Frame, fields_of, local, own_frame
from .movement import Part, movement
from .polygons import polygon_movement
from .verdict import Conditioning, verdict

if TYPE_CHECKING:
    from ..scene import Scene

FEW = 24 * math.log10(2)
"""Fewer digits than this are reported: those of single precision, 7.22."""

_MARGIN = 1e-3
_REMEMBERED = 1024

Progress = Callable[[int, int], Any]


def conditioning(
    scene: Scene, below: float = math.inf, most: int | None = None, progress: Progress | None = None
) -> list[Conditioning]:
    """The worst place of every body with fewer than `below` digits, in order of their ids.

    Of an entry of `Spheres` at most so many. A body of which nothing is left to look at (an empty one) is missing.
    A part takes some 20 milliseconds, 2 where it only differs by its motion from another; a million `Spheres` one
    second, and half a millisecond for each that is told.
    """
    found: list[Conditioning] = []
    for one in _examined(scene, progress):
        if isinstance(one, Balls):
            found.extend(one.below(below, most))
        elif one.digits < below:
            found.append(one)
    return found


def digits(scene: Scene) -> FloatArray:
    """(bodies,) decimal digits that remain of every body, NaN where nothing is left to look at."""
    result = np.full(scene.body_count, np.nan)
    for one in _examined(scene, None):
        if isinstance(one, Balls):
            result[one.first : one.first + len(one.relative)] = one.digits
        else:
            result[one.body] = one.digits
    return result


def _examined(scene: Scene, progress: Progress | None) -> Iterator[Conditioning | Balls]:
    lowered = scene.lowered
    if lowered.body_count == 0:
        return
    examiner, first = _Examiner(Targets.of(lowered)), 0
    for item, body in enumerate(scene.bodies):
        if isinstance(body.shape, Spheres):
            yield Balls.of(body.shape, first)
            first += len(body.shape)
        elif isinstance(body.shape, Bulk):
            for index in range(len(body.shape)):
                worst = examiner.worst(body.shape.single(index), first + index)
                if worst is not None:
                    yield worst
            first += len(body.shape)
        else:
            worst = examiner.worst(body.shape, first)
            if worst is not None:
                yield worst
            first += 1
        if progress is not None:
            progress(item + 1, len(scene.bodies))


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
        self._own_frame = lru_cache(_REMEMBERED)(own_frame)
        self._made = lru_cache(_REMEMBERED)(_part)

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
            return ball_verdict(leaf, motion, body)
        if isinstance(leaf, (Polygon, Triangle)):
            return verdict(leaf, motion, body, *polygon_movement(leaf, motion))
        frame, own, size = self._own_frame(leaf)
        cut = not whole or not np.isfinite(own).all()
        extent = _common(own, self._looked_at(body, box, motion, frame, size)) if cut else own
        if not (extent[0] <= extent[1]).all():
            return None
        low, high = _thickened(extent, frame, leaf.is_sheet)
        seen = self._made(leaf, frame, tuple(low.tolist()), tuple(high.tolist()), cut)
        moved = movement(seen, fields_of(motion, seen.local.frame), leaf.is_sheet)
        return None if moved is None else verdict(leaf, motion, body, moved, seen.local.frame)

    def _looked_at(self, body: int, box: Extent, motion: Motion, frame: Frame, size: FloatArray) -> Extent:
        """What is looked at along the axes of a part: the box of its body; if that is endless, all its size."""
        low, high = _seen(box, motion, frame)
        if self.targets.endless(body):
            return np.minimum(low, -2 * size), np.maximum(high, 2 * size)
        return low, high


def _part(leaf: Any, frame: Frame, low: Vector, high: Vector, cut: bool) -> Part:
    return Part.of(local(leaf, frame.scaled((np.array(low), np.array(high))), cut))


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
