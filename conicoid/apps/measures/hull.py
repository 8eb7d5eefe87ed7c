"""The frame in which a shape is measured, a fitted box, and hulls that show where rays can hit the shape."""

from __future__ import annotations

import itertools
from collections.abc import Iterator, Sequence
from typing import Any

import numpy as np
import numpy.typing as npt

from ..._jit.decorators import kernel
from ..._util.arrays import BoxEnds, FloatArray
from ..._util.records import dataclass
from ...geometry.polyhedron import Polyhedron
from ...geometry.shape import Boolean, ClippedSheet, Primitive, Shape
from ...geometry.transform import IDENTITY_MOTION, Motion, Transform
from ...kernels.tables import Flags, Floats, Longs
from ...kernels.threads import run_rows
from ...queries.result import extension

# The fitted box.


class UnboundedShapeError(ValueError):
    """The shape is infinite and has no measures."""


_CANDIDATES = 8  # boxes that are tried, including the one along the world's axes
_BOUNDED_PARTS = 2000  # parts bounded for all candidates together
_CLEARLY_SMALLER = 0.99  # a turned box must have less than this share of the volume
_LEAN, _LEAN_AXIS = 2.0**-6, (0.48, 0.59, 0.65)  # the angle by which boxes lean at most, and about what
_PROBES = 1024  # rays along each axis of the world that find points of a combination
_PROBED_SIZES = 1e-50, 1e50  # the sizes of shapes that have points within the range of rays


@dataclass(frozen=True)
class FittedBox:
    """A box about `center` with half its edges `half` along the columns of the rotation `axes` (3, 3)."""

    axes: FloatArray
    center: FloatArray
    half: FloatArray

    @property
    def is_empty(self) -> bool:
        """Whether the box is that of an empty shape."""
        return bool((self.half < 0).any())


def fitted_box(shape: Shape) -> FittedBox:
    """Return the smallest box of a shape, along the world's axes or those of one of its parts.

    A box along the world's axes is preferred unless another is clearly smaller. Points of the shape show how large a
    turned box is at least, and so which need no exact bounds. Raise UnboundedShapeError, which names the axes of the
    world, if all boxes are unbounded.
    """
    best, least = _box_along(np.eye(3), shape.bounds), np.inf
    if best.is_empty:
        return best
    if np.isfinite(best.half).all():
        least = float(np.prod(best.half)) * _CLEARLY_SMALLER
    candidates = list(_candidates(shape))
    points = _points_of(shape, best) if candidates and isinstance(shape, Boolean) else np.zeros((1, 3))
    volumes = [float(np.prod(np.ptp(points @ axes, axis=0) / 2)) for axes in candidates]
    for k in np.argsort(volumes, kind="stable"):
        if volumes[k] >= least:
            break
        box = _box_along(candidates[k], shape.bounds_under(Motion((_turn(candidates[k].T),))))
        if box.is_empty:
            return box
        if np.isfinite(box.half).all() and np.prod(box.half) < least:
            best, least = box, float(np.prod(box.half)) * _CLEARLY_SMALLER
    if not np.isfinite(best.half).all():
        low, high = shape.bounds
        endless = ", ".join(axis for axis, a, b in zip("xyz", low, high, strict=True) if not np.isfinite([a, b]).all())
        bounds_text = f"got bounds that are infinite along {endless}"
        raise UnboundedShapeError(f"measure: {type(shape).__name__} must be bounded, {bounds_text}; cut it by a box")
    return best


def _points_of(shape: Shape, box: FittedBox) -> FloatArray:
    """Return points (n, 3) where rays along the axes cross a shape in its box in the world; the origin if none do."""
    points = np.zeros((1, 3))
    least, most = _PROBED_SIZES
    if not least < box.half.min() <= max(np.abs(box.center).max(), box.half.max()) < most:
        return points
    scene, rng = extension("Scene")([shape]), np.random.default_rng(0)
    found = []
    for direction in np.eye(3):
        origins = box.center + box.half * rng.uniform(-1, 1, (_PROBES, 3))
        hits = scene.crossings(origins, direction, t_min=-np.inf)
        found.append(np.repeat(origins, np.diff(hits.offsets), axis=0) + hits.t[:, None] * direction)
    return np.concatenate(found) if any(map(len, found)) else points


def moved_parts(shape: Shape) -> Iterator[tuple[Shape, Motion]]:
    """Yield the primitives of a shape, each with the motion that moves it after its own."""
    pending: list[tuple[Shape, Motion]] = [(shape, IDENTITY_MOTION)]
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
    """Yield the axes of the first few parts that are rotated, all different."""
    axes_list: list[FloatArray] = [np.eye(3)]
    parts = list(itertools.islice(moved_parts(shape), _BOUNDED_PARTS))
    # Shapes of many parts try fewer boxes
    most = min(_CANDIDATES, _BOUNDED_PARTS // len(parts) - 1)
    for part, outer in parts if most > 0 else ():
        axes = _own_axes(part, outer)
        if axes is None or any(np.abs(np.abs(axes.T @ a).max(axis=0) - 1).max() < 1e-12 for a in axes_list):
            continue
        axes_list.append(axes)
        yield axes
        if len(axes_list) > most:
            return


def _own_axes(part: Shape, outer: Motion) -> FloatArray | None:
    """Return orthonormal axes (3, 3) from a part's axes, its z axis first; from the first normals of a polyhedron."""
    linear = part.under(outer).matrix[:3, :3]
    if isinstance(part, Polyhedron):
        # Normals are covectors: they go to the world by the inverse matrix
        linear = np.column_stack([*(np.array(part.normals[:3]) @ np.linalg.inv(linear)), *np.eye(3)])
    else:
        # z first, as the first column keeps its direction
        linear = linear[:, (2, 0, 1)]
    linear = linear / np.linalg.norm(linear, axis=0)
    # Gram and Schmidt by Householder's method; columns that are signed unit vectors stay as they are
    axes = np.linalg.qr(linear)[0][:, :3]
    axes[:, 2] *= np.sign(np.linalg.det(axes))
    return np.where(np.abs(axes) < 1e-15, 0.0, axes) if np.isfinite(axes).all() else None


def leaning_box(box: FittedBox) -> FittedBox:
    """Return a turned box turned a little further, around itself; a box along the axes of the world as it is.

    User: turned parts of CAD models. Rays along the axes of such a part meet none of its walls or all of them, but for
    a last digit of its normals: each ray would be in doubt, which takes ten to seventy times as long.
    """
    lean = min(_LEAN, box.half.min() / box.half.max())
    if np.array_equal(box.axes, np.eye(3)) or not lean > 0:
        return box
    axes, upper = np.linalg.qr(box.axes + lean * np.cross(box.axes, _LEAN_AXIS, axis=0))
    axes *= np.sign(np.diag(upper))
    return FittedBox(axes, box.center, np.abs(axes.T @ box.axes) @ box.half)


def _turn(rows: FloatArray) -> Transform:
    """Return the rotation of a (3, 3) matrix."""
    matrix = np.eye(4)
    matrix[:3, :3] = rows
    return Transform(tuple(tuple(row) for row in matrix.tolist()))


def _box_along(axes: FloatArray, bounds: BoxEnds) -> FittedBox:
    """Return the box of bounds (low, high) along some axes; half edges of -1 for empty bounds."""
    low, high = bounds
    with np.errstate(invalid="ignore"):
        center, half = low / 2 + high / 2, high / 2 - low / 2
    if (low > high).any():
        center, half = np.zeros(3), np.full(3, -1.0)
    return FittedBox(axes, axes @ center if np.isfinite(center).all() else center, half)


# Convex hulls around the parts of a shape, combined as the shape is.
#
# The hull of a part is a polytope: for fixed directions u it has sup u·x. A union has the hulls of its operands,
# grouped into a tree by nearness; an intersection has all of them at once; operands that are cut away do not count. A
# column of space that misses the hulls certainly misses the shape.

_TURNS = 8  # directions of every hull in half of each coordinate plane
_OWN_AXES = 6  # parts whose own axes give further directions
_MANY = 1000  # hulls are boxes in shapes of more parts
_DEEPEST = 30  # levels of hulls; below, they are merged into one
_GROUP = 4  # parts of a union that are not grouped any more
_ROWS = 1 << 11  # rectangles that a thread takes at a time
_SLACK = 1e-12  # hulls are enlarged by this share, for rounding


@dataclass(frozen=True)
class Rectangles:
    """Rectangles in a plane: low corners (n, 2) and sides (n, 2)."""

    low: FloatArray
    size: FloatArray

    def __len__(self) -> int:
        return len(self.low)

    def __getitem__(self, index: Any) -> Rectangles:
        return Rectangles(self.low[index], self.size[index])

    def __add__(self, other: Rectangles) -> Rectangles:
        return Rectangles(np.concatenate([self.low, other.low]), np.concatenate([self.size, other.size]))

    def without(self, index: Any) -> Rectangles:
        """Return the rectangles but those at some places."""
        return Rectangles(np.delete(self.low, index, axis=0), np.delete(self.size, index, axis=0))

    def pieces(self, step: int) -> Iterator[tuple[int, Rectangles]]:
        """Yield (place of the first, rectangles) for each `step` of them."""
        for begin in range(0, len(self), step):
            yield begin, self[begin : begin + step]

    @property
    def areas(self) -> FloatArray:
        """(n,) areas."""
        return self.size[:, 0] * self.size[:, 1]


@dataclass(frozen=True)
class Shadow:
    """A hull in a view along an axis of the box: polygons, and which of them a rectangle must meet.

    Polygon k is where u·x <= offsets[k] for all directions u across the axis. A rectangle that meets the last polygon
    goes on to number ways[k, 0], else to ways[k, 1], and so on down to an answer: -1 in the shadow, -2 outside.
    """

    axis: int
    across: FloatArray  # (m, 2)
    offsets: FloatArray  # (polygons, m)
    ways: npt.NDArray[np.int64]  # (polygons, 2)

    def halves(self, rectangles: Rectangles) -> Rectangles:
        """Return the halves of rectangles that are in the shadow, one after the other; the others miss the shape."""
        count = len(rectangles)
        low, size, marks = np.empty((2 * count, 2)), np.empty((2 * count, 2)), np.empty(2 * count, np.bool_)
        before = self.across, self.offsets, self.ways, rectangles.low, rectangles.size
        run_rows(halve_rectangles, before, count, low, size, marks, most=_ROWS)
        seen = np.flatnonzero(marks)
        return Rectangles(low.take(seen, axis=0), size.take(seen, axis=0))


@kernel(
    across="m 2", offsets="k m", ways="k 2", low="n 2", size="n 2", begin="0..end", end="0..n", low_halves="out 2*n 2",
    size_halves="out 2*n 2", marks="out 2*n",
)  # fmt: skip
def halve_rectangles(
    across: Floats, offsets: Floats, ways: Longs, low: Floats, size: Floats, begin: int, end: int,
    low_halves: Floats, size_halves: Floats, marks: Flags,
) -> None:  # fmt: skip
    """Cut the rectangles begin..end across their longer sides, and write whether each half is in a `Shadow`."""
    for i in range(2 * begin, 2 * end):
        x, y, a, b = low[i // 2, 0], low[i // 2, 1], size[i // 2, 0], size[i // 2, 1]
        a, b = (a, b / 2.0) if b > a else (a / 2.0, b)
        if i % 2 == 1:
            x, y = (x, y + b) if b < size[i // 2, 1] else (x + a, y)
        low_halves[i, 0], low_halves[i, 1], size_halves[i, 0], size_halves[i, 1] = x, y, a, b
        polygon, way = len(ways), len(ways) - 1
        while 0 <= way < polygon:  # each way leads down, so the walk ends
            polygon, turn = way, 0
            for k in range(len(across)):
                u, v = across[k, 0], across[k, 1]
                # The smallest u·x over the rectangle, at the corner that minimizes it
                if not x * u + y * v + (a * min(u, 0.0) + b * min(v, 0.0)) <= offsets[polygon, k]:
                    turn = 1
                    break
            way = ways[polygon, turn]
        marks[i] = way == -1


@dataclass(frozen=True)
class Hull:
    """A polytope, `offsets` (directions,) being sup u·x; if it has parts, also inside `every` one of them, or any."""

    offsets: FloatArray
    parts: tuple[Hull, ...] = ()
    every: bool = False
    depth: int = 0

    def shadow(self, axis: int, directions: FloatArray) -> Shadow:
        """Return the view along an axis; of the directions (n, 3) those without a component along it count."""
        views, polygons = np.flatnonzero(directions[:, axis] == 0), list[tuple[FloatArray, int, int]]()
        self._put_polygons(-1, -2, polygons)
        offsets, ways = np.array([each[0][views] for each in polygons]), np.array([each[1:] for each in polygons])
        return Shadow(axis, np.delete(directions[views], axis, axis=1), offsets, ways)

    def _put_polygons(self, inside: int, outside: int, polygons: list[tuple[FloatArray, int, int]]) -> int:
        """Append (offsets, way in, way out) of the parts, the last first, and of the hull; return its number."""
        on, off = inside, outside
        for part in reversed(self.parts):
            number = part._put_polygons(on, off, polygons)
            on, off = (number, outside) if self.every else (inside, number)
        polygons.append((self.offsets, on if self.every or not self.parts else off, outside))
        return len(polygons) - 1


def directions_for(shape: Shape, box: FittedBox) -> FloatArray:
    """Return unit vectors (n, 3) in the frame of the box with their opposites, each in one of its coordinate planes."""
    first = list(itertools.islice(moved_parts(shape), _MANY + 1))
    # Two directions in each plane are those of a box
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
    """Return the unit vector at an angle in the plane across an axis."""
    return np.insert(np.array([np.cos(angle), np.sin(angle)]), axis, 0.0)


def hull_of(shape: Shape, box: FittedBox, directions: FloatArray) -> Hull:
    """Return the hull of a shape in the frame of the box; complements move inward to the primitives (De Morgan)."""
    world = directions @ box.axes.T
    # Relative to the center of the box, with room for rounding
    shift = _SLACK * (np.abs(directions) @ box.half + np.abs(box.center).sum() / 100) - world @ box.center
    results: list[Hull] = []
    # (node, motion outside of its own, counts its inside?, combine its operands' results now?)
    pending: list[tuple[Shape, Motion, bool, bool]] = [(shape, IDENTITY_MOTION, True, False)]
    while pending:
        node, outer, inside, combine = pending.pop()
        operands = _operands(node, inside)
        if combine:
            parts = results[-len(operands) :]
            del results[-len(operands) :]
            results.append(_combine_hulls(parts, not isinstance(node, Boolean) or node._is_intersection(inside)))
        elif operands:
            pending.append((node, outer, inside, True))
            inner = node.motion.then(outer)
            pending.extend((part, inner, side, False) for part, side in reversed(operands))
        elif inside and isinstance(node, Primitive):
            results.append(Hull(_supports(node, outer, world) + shift))
        else:  # a complement has no bounds
            results.append(Hull(np.full(len(directions), np.inf)))
    return results[0]


def _operands(node: Shape, inside: bool) -> list[tuple[Shape, bool]]:
    """Return (operand, does its inside count?) for each operand of a combination; nothing for primitives."""
    if isinstance(node, ClippedSheet):
        return [(node.base, True), (node.solid, node.keep == "inside")]
    if not isinstance(node, Boolean):
        return []
    return list(zip(node.operands, node._sides(len(node.operands), inside), strict=True))


def _supports(part: Primitive, outer: Motion, world: FloatArray) -> FloatArray:
    """Return sup u·x (n,) of a moved primitive in directions u (n, 3) of the world."""
    matrix = part.under(outer).matrix
    own = world @ matrix[:3, :3]
    offsets = np.array([part.support((x, y, z)) for x, y, z in own.tolist()])
    return offsets + world @ matrix[:3, 3]


def _combine_hulls(parts: Sequence[Hull], every: bool) -> Hull:
    """Return the hull inside every one, or any, of some hulls; unbounded ones do not count in an intersection."""
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
    sides = tuple(_combine_hulls([parts[i] for i in side], False) for side in (order[:half], order[half:]))
    return Hull(merged, sides, depth=depth)
