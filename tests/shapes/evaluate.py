"""Trees of cells and uv maps at points, in plain NumPy, without the package's own kernels."""

from typing import Any

import numpy as np

from conicoid.geometry.cell import UV, All, Cell, Face, Not, Tree
from conicoid.geometry.surface import PlaneSurface, Surface
from conicoid.geometry.transform import IDENTITY_MOTION, Motion


def _principal(surface: Any, points: Any) -> tuple[Any, ...]:
    """Return points on the principal axes, the axes as rows, the squares and the linear terms."""
    rows = np.array([[float(c) for c in row] for row in surface.rows])
    y = (points - np.array([float(c) for c in surface.anchor])) @ rows.T
    squares, linear = (np.array([float(c) for c in row]) for row in (surface.squares, surface.linear))
    return y, rows, squares, linear


def value(surface: Surface, points: Any) -> Any:
    """Return the surface's left side at points (..., 3)."""
    if isinstance(surface, PlaneSurface):
        return points @ np.array([float(c) for c in surface.normal]) - float(surface.offset)
    y, _, squares, linear = _principal(surface, points)
    return (y * y) @ squares + 2 * y @ linear - float(surface.constant)


def gradient(surface: Surface, points: Any) -> Any:
    """Return ∇ of the left side at points (..., 3)."""
    if isinstance(surface, PlaneSurface):
        return np.broadcast_to(np.array([float(c) for c in surface.normal]), np.shape(points))
    y, rows, squares, linear = _principal(surface, points)
    return 2 * (y * squares + linear) @ rows


def contains(tree: Tree, points: Any, motion: Motion = IDENTITY_MOTION) -> Any:
    """Return which points (..., 3) of the world are inside the tree moved by a motion."""
    if isinstance(tree, Cell):
        sides = [face.inside * value(face.surface.moved(motion), points) <= 0 for face in tree.faces]
        return np.all(sides, axis=0)
    if isinstance(tree, Not):
        return ~contains(tree.part, points, motion)
    parts = [contains(part, points, motion) for part in tree.parts]
    return np.all(parts, axis=0) if isinstance(tree, All) else np.any(parts, axis=0)


def faces(tree: Tree) -> dict[int, Face]:
    """Return the faces of a tree by number."""
    if isinstance(tree, Cell):
        return {face.number: face for face in tree.faces}
    found: dict[int, Face] = {}
    for part in (tree.part,) if isinstance(tree, Not) else tree.parts:
        found.update(faces(part))
    return found


def uv(mapping: UV, point: Any) -> tuple[float, float]:
    """Return (u, v) at a point (3,) of the frame of the map."""
    a, b, c = np.array(mapping.matrix) @ np.append(np.array(point, float), 1.0)
    return (np.arctan2(b, a) / (2 * np.pi) % 1.0, c) if mapping.angular else (a, b)
