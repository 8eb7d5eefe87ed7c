"""What the saddle and the hyperbolic and parabolic cylinders share: a box that they may be cut by."""

from __future__ import annotations

import dataclasses
import itertools
import math
from abc import abstractmethod
from collections.abc import Iterator

import numpy as np

from .base import PrimitiveSolid
from .box import Box
from .calm import calm
from .cells import UV, Cell, Face, flat, moved_uv
from .motion import STILL
from .row_vectors import dot_rows, product
from .support import real_roots, sum_up
from .surface import QuadricSurface
from .validate import shown
from .vector import FloatArray, Vector

_BOUNDARY, _GROWN = 1e-13, 64 * 2.0**-53
"""By these shares the box is grown, and the quadric of its terms: bounds err outward."""


class WithinBox(PrimitiveSolid, abstract=True):
    """A quadric solid in its own frame, optionally the part of it in the box `within` (of that frame).

    Faces: 0 the quadric, 1 to 6 the faces of the box in its own order (low x, high x, low y, ...).
    uv of face 0: two of the box's own coordinates scaled to [0, 1], or of the shape's, unscaled, without
    a box; which two, the shape says. uv of the others: as on the box.
    """

    within: Box | None

    @calm
    def check_within(self) -> None:
        """Refuse anything but None and a box that holds something of the solid."""
        owner, box = type(self).__name__, self.within
        if box is None:
            return
        if not isinstance(box, Box):
            raise ValueError(f"{owner}: within must be a Box or None, got {type(box).__name__}")
        if _Cut(self.surface, box).support(np.array([0.0, 0.0, 1.0])) == -math.inf:
            raise ValueError(
                f"{owner}: within must hold a part of the solid, which has nothing in it, got {shown(box)}"
            )

    @property
    @abstractmethod
    def surface(self) -> QuadricSurface:
        """The quadric, its rows the identity and its anchor the origin."""

    @property
    @abstractmethod
    def uv_axes(self) -> tuple[int, int]:
        """The coordinates that are u and v on face 0."""

    @abstractmethod
    def unbounded_support(self, direction: Vector) -> float:
        """The support without a box."""

    def tree(self) -> Cell:
        if self.within is None:
            return Cell((Face(self.surface, 0, _coordinates(self.uv_axes)),))
        motion = self.within.under(STILL)
        uv = _coordinates(self.uv_axes, self.within)
        faces = [Face(self.surface, 0, moved_uv(uv, motion))]
        for face in self.within.tree().faces:
            surface, number = face.surface.moved(motion), face.number + 1
            faces.append(dataclasses.replace(face, surface=surface, number=number, uv=moved_uv(face.uv, motion)))
        return Cell(tuple(faces))

    def support(self, direction: Vector) -> float:
        if self.within is None:
            return self.unbounded_support(direction)
        return min(_Cut(self.surface, self.within).support(np.array(direction)), self.unbounded_support(direction))


class _Cut:
    """A quadric f <= 0 cut by a box, which is the parallelepiped corner + edges t, 0 <= t <= 1."""

    def __init__(self, surface: QuadricSurface, box: Box) -> None:
        squares, linear = (np.array([float(v) for v in row]) for row in (surface.squares, surface.linear))
        matrix, ends = box.under(STILL).matrix, np.array((box.low, box.high))
        self.linear_part, self.shift, self.ends = matrix[:3, :3], matrix[:3, 3], ends
        self.corner: FloatArray = product(ends[0], self.linear_part.T) + self.shift
        self.edges: FloatArray = self.linear_part * (ends[1] - ends[0])
        corner, edges = self.corner, self.edges
        # f = tᵀ second t + 2 first·t + zeroth
        self.second: FloatArray = product(edges.T, squares[:, None] * edges)
        self.first: FloatArray = product(squares * corner + linear, edges)
        reach = abs(corner) + abs(edges).sum(axis=1)
        terms = float(
            dot_rows(abs(squares), reach**2) + 2 * dot_rows(abs(linear), reach) + abs(float(surface.constant))
        )
        # Much more than rounding takes from f, and than roots lose where f is nearly flat
        self.zeroth = float(dot_rows(corner, squares * corner + 2 * linear) - float(surface.constant)) - _GROWN * terms

    def support(self, direction: FloatArray) -> float:
        """Largest value among corners, ends of edges on the quadric, and stationary points in faces.

        None of the three quadrics has a stationary point of a linear function in the open solid's boundary
        that is not also reached on the box: saddles and hyperbolic cylinders are nowhere locally convex,
        and a parabolic cylinder is stationary along whole rulings.
        """
        best, whole = -math.inf, -math.inf
        for t, point in self._corners():
            value = sum_up((direction * point).tolist())
            whole = max(whole, value)
            if self._f(t) <= 0:
                best = max(best, value)
        slope = product(direction, self.edges)
        for t in itertools.chain(self._on_edges(), self._in_faces(slope)):
            if all(-_BOUNDARY <= x <= 1 + _BOUNDARY for x in t):
                best = max(best, sum_up([*(direction * self.corner).tolist(), *(slope * t).tolist()]))
        return min(best, whole)

    def _f(self, t: FloatArray) -> float:
        return float(dot_rows(product(t, self.second), t) + 2 * dot_rows(self.first, t) + self.zeroth)

    def _corners(self) -> Iterator[tuple[FloatArray, FloatArray]]:
        """(t, point) of each corner of the box."""
        for pick in itertools.product((0, 1), repeat=3):
            yield np.array(pick, dtype=np.float64), product(self.ends[pick, (0, 1, 2)], self.linear_part.T) + self.shift

    def _on_edges(self) -> Iterator[FloatArray]:
        for i in range(3):
            for fixed in itertools.product((0.0, 1.0), repeat=2):
                t = np.insert(np.array(fixed), i, 0.0)
                yield from self._on_line(t, np.eye(3)[i])

    def _in_faces(self, slope: FloatArray) -> Iterator[FloatArray]:
        """Where f = 0 and the gradient of f in the face is along that of the linear function."""
        for i in range(3):
            j, k = (m for m in range(3) if m != i)
            along, line = np.zeros(3), np.zeros(3)
            along[j], along[k] = -slope[k], slope[j]
            along /= abs(along).max() or 1.0
            # ∇f·along = 0 is a line across `normal` in the face
            normal = product(along, self.second)[[j, k]]
            size = float(abs(normal).max())
            if size == 0:
                continue
            normal /= size
            line[j], line[k] = -normal[1], normal[0]
            for end in (0.0, 1.0):
                start = np.zeros(3)
                start[i] = end
                shift = (
                    -float(dot_rows(product(start, self.second) + self.first, along))
                    / size
                    / float(dot_rows(normal, normal))
                )
                start[[j, k]] = shift * normal
                yield from self._on_line(start, line)

    def _on_line(self, start: FloatArray, line: FloatArray) -> Iterator[FloatArray]:
        a = float(dot_rows(product(line, self.second), line))
        b = 2 * float(dot_rows(line, product(start, self.second) + self.first))
        for root in real_roots(a, b, self._f(start)):
            if math.isfinite(root):
                yield start + root * line


def _coordinates(axes: tuple[int, int], box: Box | None = None) -> UV:
    """Two coordinates, scaled over the box if there is one."""
    first, second = axes
    if box is None:
        return flat(_unit(first, 1.0), _unit(second, 1.0))
    edges = [b - a for a, b in zip(box.low, box.high, strict=True)]
    return flat(_unit(first, edges[first]), _unit(second, edges[second]), box.low)


def _unit(index: int, length: float) -> Vector:
    x, y, z = (length if i == index else 0.0 for i in range(3))
    return x, y, z
