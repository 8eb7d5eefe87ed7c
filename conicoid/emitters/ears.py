"""A polygon cut into triangles, by its ears (Meisters 1975)."""

from __future__ import annotations

from typing import Any

import numpy as np
import numpy.typing as npt


def triangles_of(loop: npt.NDArray[np.float64]) -> npt.NDArray[np.int64] | None:
    """(n - 2, 3) corners of triangles, by number; None where the loop crosses or touches itself."""
    points = _flat(loop)
    left, found = list(range(len(points))), []
    while len(left) > 3:
        ear = next((k for k in range(len(left)) if _is_ear(points, left, k)), None)
        if ear is None:
            return None
        found.append((left[ear - 1], left[ear], left[(ear + 1) % len(left)]))
        del left[ear]
    found.append((left[0], left[1], left[2]))
    cut = np.array(found)
    areas = _area(points[cut[:, 0]], points[cut[:, 1]], points[cut[:, 2]])
    whole = abs(_loop_area(points))
    return cut if (areas >= 0).all() and abs(areas.sum() - whole) <= 1e-9 * whole else None


def _flat(loop: npt.NDArray[np.float64]) -> Any:
    """The loop in its plane, counter-clockwise."""
    spokes = loop - loop[0]
    normal = np.cross(spokes[1:-1], spokes[2:]).sum(axis=0)
    axis = int(np.abs(normal).argmax())
    points = loop[:, [(axis + 1) % 3, (axis + 2) % 3]]
    return points if normal[axis] > 0 else points * (1, -1)


def _area(a: Any, b: Any, c: Any) -> Any:
    """Twice the areas of triangles that turn left."""
    p, q = b - a, c - a
    return p[..., 0] * q[..., 1] - p[..., 1] * q[..., 0]


def _loop_area(points: Any) -> float:
    following = np.roll(points, -1, axis=0)
    return float((points[:, 0] * following[:, 1] - points[:, 1] * following[:, 0]).sum())


def _is_ear(points: Any, left: list[int], k: int) -> bool:
    """Does the loop bulge at a corner, with no other corner within the triangle there?"""
    a, b, c = (points[left[j % len(left)]] for j in (k - 1, k, k + 1))
    if _area(a, b, c) < 0:
        return False
    corners = {k % len(left), (k - 1) % len(left), (k + 1) % len(left)}
    others = points[[left[j] for j in range(len(left)) if j not in corners]]
    if _area(a, b, c) == 0:
        return True
    inside = (_area(a, b, others) >= 0) & (_area(b, c, others) >= 0) & (_area(c, a, others) >= 0)
    return not bool(inside.any())
