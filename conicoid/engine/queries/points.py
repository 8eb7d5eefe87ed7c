"""Queries on arrays of points: which body contains each, and all bodies that do."""

from __future__ import annotations

from collections.abc import Callable
from typing import Any

import numpy as np

from ...shapes.arrays import outside
from ...shapes.validate import LARGEST
from ...shapes.vector import FloatArray
from ..answers.bodies_at import BodiesAt
from ..answers.no_names import numbers_of
from ..answers.rays import points_array
from ..certified.membership import locate_packets
from ..certified.settle import settle_bodies
from ..prepared import Prepared
from ..threads import chunk_of_rays, run_on

_CHUNK = 64  # packets that a thread takes at a time
_PACKET = 64  # points of a packet
_LEAST = 16  # rows and columns of a picture whose squares are asked about together
FIRST = np.full(1, -1, np.int32)
"""After no body: the first is sought."""


def points_of(owner: str, points: Any) -> tuple[FloatArray, tuple[int, ...]]:
    """The points of a query as kernels take them, (n, 3), and the shape of its answer; a named ValueError otherwise."""
    array = points_array(owner, "points", points)
    flat = np.ascontiguousarray(array.reshape(-1, 3))
    bad = outside(flat)
    if len(bad):
        where = [int(i) for i in np.unravel_index(bad[0], array.shape[:-1])] if array.ndim > 1 else ""
        found = tuple(flat[bad[0]].tolist())
        raise ValueError(f"{owner}: points{where} must be finite and of magnitude up to {LARGEST:g}, got {found}")
    return flat, array.shape[:-1]


def body_at(scene: Prepared, points: Any, owner: str = "body_at") -> Any:
    """The lowest-numbered body that contains each point, -1 for none; int32 of the points' shape."""
    flat, shape = points_of(owner, points)
    return numbers_of("body", first_after(scene, flat, FIRST, width_of(shape)).reshape(shape)[()])


def width_of(shape: tuple[int, ...]) -> int:
    """The width of the picture that points make, or 0."""
    return shape[-1] if len(shape) > 1 and min(shape[-2:]) >= _LEAST else 0


def packets_of(count: int, width: int) -> int:
    """How many packets some points make: squares of a picture of a width, or 64 in a row."""
    return -(-width // 8) * -(-count // (8 * width)) if width else -(-count // _PACKET)


def first_after(scene: Prepared, points: FloatArray, after: Any, width: int = 0) -> Any:
    """The first body after a number, or one number for all, that contains each of some flat points, -1 for none."""
    count = len(points)
    bodies, still = np.empty(count, np.int32), np.empty(count, np.int8)
    packets = packets_of(count, width)
    run_on(
        scene.geometry,
        lambda geometry, a, b: locate_packets(geometry, scene.rest, points, after, width, a, b, bodies, still),
        packets,
        chunk_of_rays(scene.geometry, packets, _CHUNK, count),
        count,
    )
    settle_bodies(scene, points, after, np.flatnonzero(still), bodies)
    return bodies


def bodies_at(scene: Prepared, points: Any, ask: Callable[[FloatArray, Any], Any] | None = None) -> BodiesAt:
    """All bodies that contain each point. ask(points, after) is `first_after`, or the same elsewhere.

    Round after round those points are asked for the next body that had one before.
    """
    flat, shape = points_of("bodies_at", points)
    width = width_of(shape)
    first = ask or (lambda some, after: first_after(scene, some, after, width if len(some) == len(flat) else 0))
    which, after = np.arange(len(flat)), FIRST
    owners, bodies = [np.zeros(0, np.int64)], [np.zeros(0, np.int32)]
    while len(which):
        found = first(flat[which], after)
        has = found >= 0
        which, after = which[has], np.ascontiguousarray(found[has])
        owners.append(which)
        bodies.append(after)
    owner = np.concatenate(owners)
    order = np.argsort(owner, kind="stable")
    offsets = np.concatenate([[0], np.cumsum(np.bincount(owner, minlength=len(flat)))]).astype(np.int64)
    return BodiesAt(offsets, np.concatenate(bodies)[order], shape, scene.labels)
