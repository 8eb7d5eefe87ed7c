"""Where a figure is drawn: the plane through the ray and a body's axis, and the window in it."""

from __future__ import annotations

import math
from collections.abc import Mapping, Sequence
from typing import TYPE_CHECKING, Any

import numpy as np

from ..shapes.classification import PLANE, SPHERE
from ..shapes.vector import FloatArray
from .arcs import Arc, Plane
from .polynomial import Source
from .steps import BodyStep

if TYPE_CHECKING:
    from .explanation import Explanation

_PARALLEL = 1e-9
_MARGIN = 0.08


def plane_of(found: Explanation, main: BodyStep | None, shown: Sequence[int]) -> tuple[Plane, str]:
    """(the plane, a sentence about it)."""
    origin, direction = np.array(found.origin), np.array(found.direction)
    along = direction / np.linalg.norm(direction)
    middle, reach = _middle(found, shown)
    foot = origin + along * float(along @ (middle - origin))
    place, axis, name = _axis(found, main, middle)
    across, about = (
        None,
        f"The plane through the ray and the middle of “{name}”." if main else "A plane through the ray.",
    )
    if axis is not None:
        beside = axis - along * float(along @ axis)
        if float(np.linalg.norm(beside)) > _PARALLEL:
            across = beside / np.linalg.norm(beside)
            normal = np.cross(along, across)
            through = abs(float(normal @ (place - origin))) <= 1e-9 * (reach + float(np.linalg.norm(place - origin)))
            about = f"The plane through the ray {'and' if through else 'that is parallel to'} the axis of “{name}”."
    if across is None:
        beside = place - origin
        beside = beside - along * float(along @ beside)
        size = float(np.linalg.norm(beside))
        if size <= _PARALLEL * (1 + reach):
            beside = np.eye(3)[int(np.argmin(np.abs(along)))]
            beside = beside - along * float(along @ beside)
            size = float(np.linalg.norm(beside))
        across = beside / size
        if axis is not None:
            about = f"The plane through the ray and the axis of “{name}”."
    if across[int(np.argmax(np.abs(across)))] < 0:
        across = -across
    return Plane(foot, np.array([along, across]), reach), about


def _axis(found: Explanation, main: BodyStep | None, middle: FloatArray) -> tuple[FloatArray, Any, str]:
    """(a point, a direction or None, the name) of the axis of a body: of its first curved surface that has one."""
    from .figure import surfaces_of

    if main is None:
        return middle, None, ""
    scene, center = found.scene.prepared, None
    for number in surfaces_of(scene, main.body):
        told = Source.of(scene, number).classification
        if told.center is None or told.kind == PLANE:
            continue
        if told.kind != SPHERE:
            return np.array(told.center), np.array(told.axes[2]), main.name
        center = told.center if center is None else center
    if center is not None:
        return np.array(center), None, main.name
    low, high = _box(found, [main.body])
    bounded = np.isfinite([low, high]).all()
    return ((low + high) / 2 if bounded else middle), None, main.name


def _box(found: Explanation, shown: Sequence[int]) -> tuple[FloatArray, FloatArray]:
    """(low, high) around some bodies, infinite where they are."""
    lowered = found.scene.prepared.lowered
    rows = lowered.boxes[np.array(shown, np.intp)]
    return rows[:, :3].min(axis=0, initial=math.inf), rows[:, 3:].max(axis=0, initial=-math.inf)


def _middle(found: Explanation, shown: Sequence[int]) -> tuple[FloatArray, float]:
    """(the middle of what is drawn, how far it reaches): of boxes that have an end, and of the crossings."""
    origin, direction = np.array(found.origin), np.array(found.direction)
    points = [origin + one.t * direction for one in found.crossings[:16]]
    met = [step.body for step in found.bodies if step.body in shown and (step.crossings or step.spans)]
    for body in met or shown:
        low, high = _box(found, [body])
        if np.isfinite(low).all() and np.isfinite(high).all() and (low <= high).all():
            points += [low, high]
    if not points:
        points = [origin, origin + direction]
    low, high = np.min(points, axis=0), np.max(points, axis=0)
    reach = float(np.linalg.norm(high - low)) / 2
    return (low + high) / 2, 1.25 * reach if reach > 0 else 1.0


def window(found: Explanation, plane: Plane, arcs: Mapping[int, Sequence[Arc]]) -> tuple[float, float, float, float]:
    """(x0, x1, y0, y1) that holds what is drawn, and the ray's origin unless it is far away."""
    length = float(np.linalg.norm(found.direction))
    origin = float(plane.places(np.array([found.origin]))[0, 0])
    xs, ys = [], [0.0]
    for each in arcs.values():
        for arc in each:
            places = np.clip(arc.branch.points(np.linspace(arc.first, arc.last, 65)), -plane.reach, plane.reach)
            xs += places[:, 0].tolist()
            ys += places[:, 1].tolist()
    xs += [origin + one.t * length for one in found.crossings if abs(origin + one.t * length) <= 2 * plane.reach]
    xs = xs or [origin, origin + length]
    x0, x1, y0, y1 = min(xs), max(xs), min(ys), max(ys)
    size = max(x1 - x0, y1 - y0, 1e-12 * plane.reach)
    if x0 - size <= origin <= x1 + size:
        x0, x1 = min(x0, origin), max(x1, origin)
    x1 += 0.12 * size
    margin = _MARGIN * max(x1 - x0, y1 - y0)
    x0, x1, y0, y1 = x0 - margin, x1 + margin, y0 - margin, y1 + margin
    low, high = 0.3 * (x1 - x0), 1.1 * (x1 - x0)
    if y1 - y0 < low:
        middle = (y0 + y1) / 2
        y0, y1 = middle - low / 2, middle + low / 2
    if y1 - y0 > high:
        middle, half = (x0 + x1) / 2, (y1 - y0) / 2.2
        x0, x1 = middle - half, middle + half
    return x0, x1, y0, y1
