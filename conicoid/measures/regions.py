"""Closed forms of combinations of surfaces, such as the cells of imported models: prisms and solids of revolution."""

from __future__ import annotations

import contextlib
from typing import Any

import numpy as np

from ..shapes.base import Shape
from ..shapes.vector import FloatArray
from .closed import Moments
from .frames import FittedBox
from .prisms import Unknown, prism_sums
from .revolved import revolved_sums
from .surfaces import ALIKE, Plane, Quadric, Region, region_of

_MOST_AXES = 6


def closed_region(shape: Shape, box: FittedBox) -> tuple[Moments, float | None] | None:
    """Moments in the world and the area, where a solid's surfaces allow a closed form; the area may lack one."""
    region = region_of(shape, box.center)
    if region is None:
        return None
    for axis, origin in _axes(region):
        axes = _frame(axis)
        with contextlib.suppress(Unknown):
            sums, area = prism_sums(region, axes)
            return _moments(sums, axes, box.center), area
        with contextlib.suppress(Unknown):
            sums, some_area = revolved_sums(region, axes, origin)
            return _moments(sums, axes, box.center + origin), some_area
    return None


def _axes(region: Region) -> list[tuple[FloatArray, FloatArray]]:
    """Directions in which the solid might be a prism, or an axis about which it might be turned, with points there."""
    found: list[tuple[FloatArray, FloatArray]] = []

    def add(axis: FloatArray, origin: FloatArray) -> None:
        if all(np.linalg.norm(np.cross(axis, other)) > ALIKE for other, _ in found) and len(found) < _MOST_AXES:
            found.append((axis, origin))

    quadrics = [surface for surface in region.surfaces.values() if isinstance(surface, Quadric)]
    centers = [center for quadric in quadrics if (center := _center(quadric)) is not None]
    origin = centers[0] if centers else np.zeros(3)
    for quadric in quadrics:
        axis = _axis(quadric)
        if axis is not None:
            center = _center(quadric)
            add(axis, origin if center is None else center)
    for center in centers[1:]:
        way = center - origin
        if np.linalg.norm(way) > ALIKE * (1 + np.abs(origin).max()):
            add(way / np.linalg.norm(way), origin)
    for surface in region.surfaces.values():
        if isinstance(surface, Plane):
            add(surface.normal, origin)
    if not found:
        add(np.array([0.0, 0.0, 1.0]), origin)
    return found


def _axis(quadric: Quadric) -> FloatArray | None:
    """The direction of the axis of a quadric of revolution; None for spheres and others."""
    squares, axes = np.linalg.eigh(quadric.a)
    size = np.abs(squares).max()
    for k in range(3):
        one, other = np.delete(squares, k)
        if abs(one - other) <= 1e-9 * size < abs(squares[k] - one):
            axis: Any = axes[:, k]
            nearest = np.round(axis)
            found: FloatArray = nearest if np.abs(axis - nearest).max() < ALIKE else axis
            return found
    return None


def _center(quadric: Quadric) -> FloatArray | None:
    """The center, a point of the axis where there are many; None where there is none, as of paraboloids."""
    center: Any = np.linalg.lstsq(quadric.a, -quadric.b, rcond=1e-9)[0]
    rest = np.abs(quadric.a @ center + quadric.b).max()
    result: FloatArray = center
    return result if rest <= ALIKE * max(np.abs(quadric.b).max(), 1e-300) or not quadric.b.any() else None


def _frame(axis: FloatArray) -> FloatArray:
    """Right angles, (3, 3), the last column along an axis; of the world's axes their order is changed."""
    across = np.eye(3)[int(np.argmin(np.abs(axis)))]
    first = np.cross(across, axis)
    first = first / np.linalg.norm(first)
    return np.column_stack([first, np.cross(axis, first), axis])


def _moments(sums: FloatArray, axes: FloatArray, origin: FloatArray) -> Moments:
    """From integrals of 1, x, y, z, xx, xy, xz, yy, yz, zz along axes from an origin on."""
    volume = float(sums[0])
    if volume <= 0:
        return Moments(0.0, np.full(3, np.nan), np.zeros((3, 3)))
    mean = sums[1:4] / volume
    xx, xy, xz, yy, yz, zz = sums[4:] / volume
    spread = np.array([[xx, xy, xz], [xy, yy, yz], [xz, yz, zz]]) - np.outer(mean, mean)
    turned = axes @ spread @ axes.T
    return Moments(volume, origin + axes @ mean, (turned + turned.T) / 2)
