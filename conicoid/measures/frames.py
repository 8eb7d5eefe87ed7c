"""The frame in which a shape is measured: the turned box that fits it best."""

from __future__ import annotations

import itertools
from collections.abc import Iterator
from dataclasses import dataclass

import numpy as np

from ..shapes.base import Shape
from ..shapes.motion import STILL, Motion, Transform
from ..shapes.polyhedron import Polyhedron
from ..shapes.region import Boolean, ClippedSheet
from ..shapes.vector import Box, FloatArray


class Unbounded(ValueError):
    """A shape without end has no measures."""


_CANDIDATES = 8
_BOUNDED_PARTS = 2000  # parts bounded for all candidates together
_CLEARLY_SMALLER = 0.99


@dataclass(frozen=True)
class FittedBox:
    """A box about `center` with half its edges `half` along the columns of the rotation `axes` (3, 3)."""

    axes: FloatArray
    center: FloatArray
    half: FloatArray

    @property
    def is_empty(self) -> bool:
        return bool((self.half < 0).any())


def fitted_box(shape: Shape) -> FittedBox:
    """The smallest box, along the world's axes or those of one of the shape's parts.

    Raises ValueError where all of them are unbounded, naming the axes of the world.
    """
    best, least = _boxed(np.eye(3), shape.bounds), np.inf
    if best.is_empty:
        return best
    if np.isfinite(best.half).all():
        least = float(np.prod(best.half)) * _CLEARLY_SMALLER
    for axes in _candidates(shape):
        box = _boxed(axes, shape.bounds_under(Motion((_turn(axes.T),))))
        if box.is_empty:
            return box
        if np.isfinite(box.half).all() and np.prod(box.half) < least:
            best, least = box, float(np.prod(box.half))
    if not np.isfinite(best.half).all():
        low, high = shape.bounds
        endless = ", ".join(axis for axis, a, b in zip("xyz", low, high, strict=True) if not np.isfinite([a, b]).all())
        found = f"got bounds that are infinite along {endless}"
        raise Unbounded(f"measure: {type(shape).__name__} must be bounded, {found}; cut it by a box")
    return best


def parts_of(shape: Shape) -> Iterator[tuple[Shape, Motion]]:
    """The primitives of a shape, each with the motion that moves it besides its own."""
    pending: list[tuple[Shape, Motion]] = [(shape, STILL)]
    while pending:
        node, outer = pending.pop()
        if isinstance(node, Boolean):
            inner = node.motion.then(outer)
            pending.extend((part, inner) for part in reversed(node.operands))
        elif isinstance(node, ClippedSheet):
            inner = node.motion.then(outer)
            pending.extend([(node.solid, inner), (node.base, inner)])
        else:
            yield node, outer


def _candidates(shape: Shape) -> Iterator[FloatArray]:
    """Rotations to the axes of the first few parts that stand askew, all different."""
    found: list[FloatArray] = [np.eye(3)]
    parts = list(itertools.islice(parts_of(shape), _BOUNDED_PARTS))
    most = min(_CANDIDATES, _BOUNDED_PARTS // len(parts) - 1)
    for part, outer in parts if most > 0 else ():
        axes = _own_axes(part, outer)
        if axes is None or any(_same_axes(axes, other) for other in found):
            continue
        found.append(axes)
        yield axes
        if len(found) > most:
            return


def _own_axes(part: Shape, outer: Motion) -> FloatArray | None:
    """Right angles as near to a part's axes as can be, its z axis kept; of a polyhedron, its first normals."""
    linear = part.under(outer).matrix[:3, :3]
    if isinstance(part, Polyhedron):
        linear = np.column_stack([*(np.array(part.normals[:3]) @ np.linalg.inv(linear)), *np.eye(3)])
    else:
        linear = linear[:, (2, 0, 1)]
    linear = linear / np.linalg.norm(linear, axis=0)
    # Gram and Schmidt by Householder's method; columns that are signed unit vectors stay as they are
    axes = np.linalg.qr(linear)[0][:, :3]
    axes[:, 2] *= np.sign(np.linalg.det(axes))
    return np.where(np.abs(axes) < 1e-15, 0.0, axes) if np.isfinite(axes).all() else None


def _same_axes(a: FloatArray, b: FloatArray) -> bool:
    """Equal up to order and sign."""
    return bool(np.abs(np.abs(a.T @ b).max(axis=0) - 1).max() < 1e-12)


def _turn(rows: FloatArray) -> Transform:
    matrix = np.eye(4)
    matrix[:3, :3] = rows
    return Transform(tuple(tuple(row) for row in matrix.tolist()))


def _boxed(axes: FloatArray, bounds: Box) -> FittedBox:
    low, high = bounds
    with np.errstate(invalid="ignore"):
        center, half = low / 2 + high / 2, high / 2 - low / 2
    if (low > high).any():
        center, half = np.zeros(3), np.full(3, -1.0)
    return FittedBox(axes, axes @ center if np.isfinite(center).all() else center, half)
