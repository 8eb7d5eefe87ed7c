"""Where rays are worth sending: convex hulls around the parts of a shape, combined as the shape is.

The hull of a part is a polytope: for fixed directions u it keeps sup u·x. A union has the hulls of its
operands, gathered into a tree by nearness; an intersection must meet all of them; what is cut away
does not count. A column of space that misses the hulls misses the shape, and that is certain.
"""

from __future__ import annotations

import itertools
from collections.abc import Iterator, Sequence
from dataclasses import dataclass
from typing import Any

import numpy as np
import numpy.typing as npt

from ..shapes.base import Primitive, Shape
from ..shapes.motion import STILL, Motion
from ..shapes.region import Boolean, ClippedSheet, Complement, Difference, Union
from ..shapes.vector import FloatArray
from .frames import FittedBox, parts_of

Mask = npt.NDArray[np.bool_]

_TURNS = 8  # directions in half of each coordinate plane that every hull has
_OWN_AXES = 6  # parts whose own axes give further directions
_MANY = 1000  # parts of a shape that get boxes instead
_DEEPEST = 30  # levels; below, hulls are merged into one
_GROUP = 4
_BLOCK = 1 << 15
_SLACK = 1e-12


@dataclass(frozen=True)
class Rectangles:
    """Low corners (n, 2) and sides (n, 2)."""

    low: FloatArray
    size: FloatArray

    def __len__(self) -> int:
        return len(self.low)

    def __getitem__(self, index: Any) -> Rectangles:
        return Rectangles(self.low[index], self.size[index])

    def __add__(self, other: Rectangles) -> Rectangles:
        return Rectangles(np.concatenate([self.low, other.low]), np.concatenate([self.size, other.size]))

    def without(self, index: Any) -> Rectangles:
        return Rectangles(np.delete(self.low, index, axis=0), np.delete(self.size, index, axis=0))

    def pieces(self, step: int) -> Iterator[tuple[int, Rectangles]]:
        """(place of the first, `step` of them)"""
        for begin in range(0, len(self), step):
            yield begin, self[begin : begin + step]

    @property
    def areas(self) -> FloatArray:
        result: FloatArray = self.size.prod(axis=1)
        return result

    def halved(self) -> Rectangles:
        """Each cut across its longer side, the halves one after the other."""
        longer = np.arange(2) == np.argmax(self.size, axis=1)[:, None]
        size = np.where(longer, self.size / 2, self.size)
        low = np.stack([self.low, self.low + np.where(longer, size, 0.0)], axis=1)
        return Rectangles(low.reshape(-1, 2), np.repeat(size, 2, axis=0))


@dataclass(frozen=True)
class Sight:
    """A view along an axis of the box: the directions across it (m, 2), and their places among all."""

    axis: int
    across: FloatArray
    chosen: Any

    @classmethod
    def along(cls, axis: int, directions: FloatArray) -> Sight:
        """From directions (n, 3): those without a component along the axis."""
        chosen = np.flatnonzero(directions[:, axis] == 0)
        return cls(axis, np.delete(directions[chosen], axis, axis=1), chosen)


@dataclass(frozen=True)
class Hull:
    """`offsets` (directions,): sup u·x. With parts: inside `every` one of them, or any."""

    offsets: FloatArray
    parts: tuple[Hull, ...] = ()
    every: bool = False
    depth: int = 0

    def seen(self, rectangles: Rectangles, sight: Sight) -> Rectangles:
        """Those that meet the hull, seen along an axis; those left out certainly miss the shape."""
        met = [np.zeros(0, bool), *(self._meets(part, sight) for _, part in rectangles.pieces(_BLOCK))]
        return rectangles[np.concatenate(met)]

    def _meets(self, rectangles: Rectangles, sight: Sight) -> Mask:
        least = rectangles.low @ sight.across.T + rectangles.size @ np.minimum(sight.across, 0.0).T
        found: Mask = (least <= self.offsets[sight.chosen]).all(axis=1)
        if self.every or not self.parts:
            for part in self.parts:
                rest = np.flatnonzero(found)
                found[rest] = part._meets(rectangles[rest], sight)
            return found
        pending, result = np.flatnonzero(found), np.zeros(len(found), bool)
        for part in self.parts:
            met = part._meets(rectangles[pending], sight)
            result[pending[met]] = True
            pending = pending[~met]
        return result


def directions_for(shape: Shape, box: FittedBox) -> FloatArray:
    """(n, 3) unit vectors in the frame of the box, with their opposites, each in one of its coordinate planes."""
    first = list(itertools.islice(parts_of(shape), _MANY + 1))
    turns = 2 if len(first) > _MANY else _TURNS
    rows = [_in_plane(axis, np.pi * k / turns) for axis in range(3) for k in range(turns)]
    for part, outer in first[: _OWN_AXES if len(first) <= _MANY else 0]:
        for own in (box.axes.T @ part.under(outer).matrix[:3, :3]).T:
            for axis in range(3):
                # Across the image of one of the part's own axes in the plane of sight
                a, b = np.delete(own, axis)
                if np.hypot(a, b) > 1e-9 * np.abs(own).max():
                    rows.append(_in_plane(axis, np.arctan2(b, a) + np.pi / 2))
    directions = np.array(rows)
    directions[np.abs(directions) < _SLACK] = 0.0
    directions = np.concatenate([directions, -directions])
    _, different = np.unique(np.round(directions, 9) + 0.0, axis=0, return_index=True)
    return directions[np.sort(different)]


def _in_plane(axis: int, angle: float) -> FloatArray:
    return np.insert(np.array([np.cos(angle), np.sin(angle)]), axis, 0.0)


def hull_of(shape: Shape, box: FittedBox, directions: FloatArray) -> Hull:
    """The hulls of a shape in the frame of the box; complements are carried inward (De Morgan)."""
    world = directions @ box.axes.T
    # Relative to the center of the box, with room for rounding
    shift = _SLACK * (np.abs(directions) @ box.half + np.abs(box.center).sum() / 100) - world @ box.center
    results: list[Hull] = []
    pending: list[tuple[Shape, Motion, bool, bool]] = [(shape, STILL, True, False)]
    while pending:
        node, outer, inside, combine = pending.pop()
        operands = _operands(node)
        if combine:
            parts = results[-len(operands) :]
            del results[-len(operands) :]
            single = isinstance(node, Complement)
            results.append(parts[0] if single else _joined(parts, isinstance(node, Union) != inside))
        elif operands:
            pending.append((node, outer, inside, True))
            inner = node.motion.then(outer)
            pending.extend((part, inner, inside != turned, False) for part, turned in reversed(operands))
        elif inside and isinstance(node, Primitive):
            results.append(Hull(_supports(node, outer, world) + shift))
        else:
            results.append(Hull(np.full(len(directions), np.inf)))
    return results[0]


def _operands(node: Shape) -> list[tuple[Shape, bool]]:
    """(operand, whether its complement counts)"""
    if isinstance(node, ClippedSheet):
        return [(node.base, False), (node.solid, node.keep == "outside")]
    if not isinstance(node, Boolean):
        return []
    cut, turned = isinstance(node, Difference), isinstance(node, Complement)
    return [(part, turned or (cut and k > 0)) for k, part in enumerate(node.operands)]


def _supports(part: Primitive, outer: Motion, world: FloatArray) -> FloatArray:
    matrix = part.under(outer).matrix
    own = world @ matrix[:3, :3]
    offsets = np.array([part.support((x, y, z)) for x, y, z in own.tolist()])
    return offsets + world @ matrix[:3, 3]


def _joined(parts: Sequence[Hull], every: bool) -> Hull:
    """All or any of some hulls; what is everywhere is left out."""
    endless = [bool(np.isposinf(part.offsets).all()) for part in parts]
    if any(endless) and not every:
        return parts[endless.index(True)]
    parts = [part for part, out in zip(parts, endless, strict=True) if not out] or list(parts[:1])
    if len(parts) == 1:
        return parts[0]
    offsets = np.array([part.offsets for part in parts])
    merged = offsets.min(axis=0) if every else offsets.max(axis=0)
    depth = 1 + max(part.depth for part in parts)
    if depth > _DEEPEST:
        return Hull(merged)
    if every or len(parts) <= _GROUP:
        return Hull(merged, tuple(parts), every, depth)
    # Halve along the direction in which the parts spread most
    finite = np.isfinite(offsets).all(axis=0)
    spread = np.where(finite, np.ptp(np.where(finite, offsets, 0.0), axis=0), -1.0)
    order = np.argsort(offsets[:, int(np.argmax(spread))])
    half = len(parts) // 2
    sides = tuple(_joined([parts[i] for i in side], False) for side in (order[:half], order[half:]))
    return Hull(merged, sides, depth=depth)
