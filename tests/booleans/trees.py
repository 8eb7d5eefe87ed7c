"""Boolean trees of leaves, each node with its own motion, and what they hold by formula."""

from __future__ import annotations

from collections.abc import Iterator
from dataclasses import dataclass
from typing import Any

import numpy as np

import conicoid as co

from .leaves import MANY_DIGITS, Leaf, grid_leaf, random_leaf


@dataclass(frozen=True)
class Node:
    """A leaf, or one of | & - ~ over nodes; `back` (3, 4) of mpf takes the parent's coordinates to the node's."""

    shape: Any
    back: Any
    leaf: Leaf | None = None
    operation: str = ""
    parts: tuple[Node, ...] = ()

    def leaves(self) -> Iterator[Node]:
        if self.leaf is not None:
            yield self
        for part in self.parts:
            yield from part.leaves()

    def inside(self, points: Any) -> Any:
        """Which points, three arrays of the parent's coordinates, are inside by the Boolean formula."""
        own = _carried(self.back, points)
        if self.leaf is not None:
            return self.leaf.inside(own)
        return combined(self.operation, [part.inside(own) for part in self.parts])

    def functions(self, points: Any) -> list[Any]:
        """Those of all leaves."""
        own = _carried(self.back, points)
        if self.leaf is not None:
            return self.leaf.functions(*own)
        return [f for part in self.parts for f in part.functions(own)]

    def distance(self, points: Any) -> Any:
        """About how far points (arrays of mpf) are from the nearest surface of a leaf: the least |f| / |grad f|."""
        step = MANY_DIGITS.mpf(10) ** -30
        here, squares = self.functions(points), 0
        for axis in range(3):
            beside = [p + step if k == axis else p for k, p in enumerate(points)]
            squares = squares + np.array(
                [((g - f) / step) ** 2 for f, g in zip(here, self.functions(beside), strict=True)]
            )
        return np.min(
            np.abs(np.array(here)) / np.frompyfunc(MANY_DIGITS.sqrt, 1, 1)(squares + MANY_DIGITS.mpf(10) ** -90), axis=0
        )


def combined(operation: str, values: list[Any]) -> Any:
    """Truth of a node from those of its parts."""
    if operation == "|":
        return np.logical_or.reduce(values)
    if operation == "&":
        return np.logical_and.reduce(values)
    if operation == "~":
        return ~values[0]
    return values[0] & ~np.logical_or.reduce(values[1:])


def world_leaves(node: Node) -> list[Any]:
    """The leaf shapes, moved to where the tree has them."""
    if node.leaf is not None:
        return [node.shape]
    found, motion = [leaf for part in node.parts for leaf in world_leaves(part)], node.shape.motion
    return [co.Union((leaf,), motion=motion) if motion.steps else leaf for leaf in found]


def _carried(back: Any, points: Any) -> Any:
    if back is None:
        return points
    back = back.astype(points[0].dtype)
    return tuple(row[0] * points[0] + row[1] * points[1] + row[2] * points[2] + row[3] for row in back)


def _moved(shape: Any, steps: list[tuple[str, Any]]) -> tuple[Any, Any]:
    """The shape after the steps, and the inverse map in 60 digits."""
    if not steps:
        return shape, None
    total = MANY_DIGITS.eye(4)
    for name, values in steps:
        shape = getattr(shape, name)(*values)
        total = _matrix(name, values) * total
    back = total**-1
    return shape, np.array([[back[i, j] for j in range(4)] for i in range(3)], dtype=object)


def _matrix(name: str, values: Any) -> Any:
    result = MANY_DIGITS.eye(4)
    if name == "translate":
        for i, c in enumerate(values[0]):
            result[i, 3] = MANY_DIGITS.mpf(c)
    elif name == "scale":
        factors = values[0] if isinstance(values[0], tuple) else (values[0],) * 3
        for i, c in enumerate(factors):
            result[i, i] = MANY_DIGITS.mpf(c)
    elif name == "transform":
        result = MANY_DIGITS.matrix([[MANY_DIGITS.mpf(c) for c in row] for row in values[0]])
    else:
        axis = [MANY_DIGITS.mpf(c) for c in values[0]]
        length = MANY_DIGITS.sqrt(sum(c * c for c in axis))
        x, y, z = (c / length for c in axis)
        angle = MANY_DIGITS.radians(MANY_DIGITS.mpf(values[1]))
        c, s = (
            (MANY_DIGITS.cos(angle), MANY_DIGITS.sin(angle))
            if values[1] % 90
            else ([1, 0, -1, 0][values[1] // 90 % 4], [0, 1, 0, -1][values[1] // 90 % 4])
        )
        k = 1 - c
        rows = [[c + x * x * k, x * y * k - z * s, x * z * k + y * s], [y * x * k + z * s, c + y * y * k, y * z * k - x * s],
                [z * x * k - y * s, z * y * k + x * s, c + z * z * k]]  # fmt: skip
        for i in range(3):
            for j in range(3):
                result[i, j] = rows[i][j]
    return result


def random_steps(r: np.random.Generator) -> list[tuple[str, Any]]:
    steps: list[tuple[str, Any]] = []
    for _ in range(r.integers(0, 3)):
        kind = r.integers(4)
        if kind == 0:
            steps.append(("translate", (tuple(r.uniform(-1, 1, 3).tolist()),)))
        elif kind == 1:
            steps.append(("rotate", (tuple(r.normal(size=3).tolist()), float(r.uniform(-180, 180)))))
        elif kind == 2:
            steps.append(("scale", (tuple((r.uniform(0.5, 2, 3) * r.choice([-1, 1], 3)).tolist()),)))
        else:
            matrix = np.eye(4)
            matrix[:3] += r.uniform(-0.3, 0.3, (3, 4))
            steps.append(("transform", (matrix.tolist(),)))
    return steps


def grid_steps(r: np.random.Generator) -> list[tuple[str, Any]]:
    """Motions that keep whole numbers whole."""
    steps: list[tuple[str, Any]] = []
    for _ in range(r.integers(0, 3)):
        kind = r.integers(3)
        if kind == 0:
            steps.append(("translate", (tuple(float(c) for c in r.integers(-1, 2, 3)),)))
        elif kind == 1:
            steps.append(("rotate", (tuple(np.eye(3)[r.integers(3)].tolist()), 90 * int(r.integers(-2, 4)))))
        else:
            steps.append(("scale", (tuple(float(c) for c in r.choice([-1.0, 1.0, 2.0], 3, p=[0.3, 0.6, 0.1])),)))
    return steps


def tree(r: np.random.Generator, depth: int, *, grid: bool = False, shared: list[Node] | None = None) -> Node:
    """A random tree; now and then a subtree stands in it twice."""
    shared = [] if shared is None else shared
    if shared and r.random() < 0.1:
        return shared[r.integers(len(shared))]
    steps = (grid_steps if grid else random_steps)(r)
    if depth == 0 or r.random() < 0.12:
        leaf = (grid_leaf if grid else random_leaf)(r)
        shape, back = _moved(leaf.shape, steps)
        node = Node(shape, back, leaf)
    else:
        operation = str(r.choice(["|", "&", "-", "~"], p=[0.4, 0.25, 0.25, 0.1]))
        count = 1 if operation == "~" else 2 if depth > 4 else int(r.integers(2, 4))
        parts = tuple(tree(r, depth - 1, grid=grid, shared=shared) for _ in range(count))
        kinds = {"|": co.Union, "&": co.Intersection, "-": co.Difference}
        shapes = tuple(part.shape for part in parts)
        shape = ~shapes[0] if operation == "~" else kinds[operation](shapes)
        shape, back = _moved(shape, steps)
        node = Node(shape, back, None, operation, parts)
    shared.append(node)
    return node
