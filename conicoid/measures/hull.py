"""Where rays are worth sending: convex hulls around the parts of a shape, combined as the shape is.

The hull of a part is a polytope: for fixed directions u it keeps sup u·x. A union has the hulls of its
operands, gathered into a tree by nearness; an intersection must meet all of them; what is cut away
does not count. A column of space that misses the hulls misses the shape, and that is certain.
"""

from __future__ import annotations

from collections.abc import Sequence
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

_TURNS = 8  # directions in each half-plane that every hull has
_OWN_AXES = 6  # parts whose own axes give further directions
_MOST_SUPPORTS = 40_000
_DEEPEST = 30  # nodes below are merged into one hull
_GROUP = 4
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

    def halved(self) -> Rectangles:
        """Each cut across its longer side, the halves one after the other."""
        longer = np.argmax(self.size, axis=1)
        low, size = np.repeat(self.low, 2, axis=0), np.repeat(self.size, 2, axis=0)
        both = np.arange(len(size)), np.repeat(longer, 2)
        size[both] /= 2
        low[1::2][np.arange(len(longer)), longer] += size[1::2][np.arange(len(longer)), longer]
        return Rectangles(low, size)


@dataclass(frozen=True)
class Sight:
    """A view along an axis of the box: the directions across it (m, 2), and their places among all."""

    axis: int
    across: FloatArray
    chosen: Any

    @classmethod
    def along(cls, axis: int, directions: FloatArray) -> Sight:
        chosen = np.flatnonzero(directions[:, axis] == 0)
        return cls(axis, np.delete(directions[chosen], axis, axis=1), chosen)


@dataclass(frozen=True)
class Hull:
    """`offsets` (directions,): sup u·x. With parts: inside `every` one of them, or any."""

    offsets: FloatArray
    parts: tuple[Hull, ...] = ()
    every: bool = False
    depth: int = 0

    def meets(self, rectangles: Rectangles, sight: Sight) -> Mask:
        """Which rectangles meet it, seen along an axis; False is certain."""
        least = rectangles.low @ sight.across.T + rectangles.size @ np.minimum(sight.across, 0.0).T
        found: Mask = (least <= self.offsets[sight.chosen]).all(axis=1)
        if not self.parts:
            return found
        if self.every:
            for part in self.parts:
                rest = np.flatnonzero(found)
                found[rest] = part.meets(rectangles[rest], sight)
            return found
        pending, result = np.flatnonzero(found), np.zeros(len(found), bool)
        for part in self.parts:
            met = part.meets(rectangles[pending], sight)
            result[pending[met]] = True
            pending = pending[~met]
        return result


def directions_for(shape: Shape, box: FittedBox) -> FloatArray:
    """(n, 3) unit vectors in the frame of the box, each in one of its coordinate planes; signs included."""
    rows = [_in_plane(axis, np.pi * k / _TURNS) for axis in range(3) for k in range(_TURNS)]
    for number, (part, outer) in enumerate(parts_of(shape)):
        if number >= _OWN_AXES:
            break
        for own in (box.axes.T @ part.under(outer).matrix[:3, :3]).T:
            for axis in range(3):
                # across the image of the part's own axis in the plane of sight
                a, b = np.delete(own, axis)
                if np.hypot(a, b) > 1e-9 * np.abs(own).max():
                    rows.append(_in_plane(axis, np.arctan2(b, a) + np.pi / 2))
    directions = np.array(rows)
    directions[np.abs(directions) < 1e-12] = 0.0
    _, first = np.unique(
        np.round(directions * np.sign(directions @ (1.0, 0.9, 0.8))[:, None], 9), axis=0, return_index=True
    )
    directions = directions[np.sort(first)]
    return np.concatenate([directions, -directions])


def _in_plane(axis: int, angle: float) -> FloatArray:
    return np.insert(np.array([np.cos(angle), np.sin(angle)]), axis, 0.0)


def hull_of(shape: Shape, box: FittedBox, directions: FloatArray) -> Hull:
    """The hulls of a shape in the frame of the box; complements are carried inward (De Morgan)."""
    world, shift = directions @ box.axes.T, directions @ (box.axes.T @ box.center)
    slack = _SLACK * (np.abs(directions) @ box.half) + 1e-14 * np.abs(box.center).sum()
    everything = Hull(np.full(len(directions), np.inf))
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
            for part, turned in reversed(operands):
                pending.append((part, inner, inside != turned, False))
        elif inside and isinstance(node, Primitive):
            results.append(Hull(_supports(node, outer, world) - shift + slack))
        else:
            results.append(everything)
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
    spread = np.where(
        np.isfinite(offsets).all(axis=0), np.ptp(np.nan_to_num(offsets, posinf=0.0, neginf=0.0), axis=0), -1.0
    )
    order = np.argsort(offsets[:, int(np.argmax(spread))])
    half = len(parts) // 2
    sides = tuple(_joined([parts[i] for i in side], False) for side in (order[:half], order[half:]))
    return Hull(merged, sides, depth=depth)
