"""Queries at points: the first body that contains each point, and `BodiesAt`, all bodies that do."""

from __future__ import annotations

from collections.abc import Callable, Iterator, Sequence
from typing import Any

import numpy as np
import numpy.typing as npt

from .._util.arrays import FloatArray
from .._util.text import format_count
from .._util.validation import LARGEST, rows_outside_domain
from ..geometry.labels import Labels
from ..kernels.threads import KernelRange, chunk_of_rays, run_on
from ..prepare.prepared_scene import PreparedScene
from .exact.doubtful_rays import resolve_bodies
from .exact.membership import locate_packets
from .rays import points_array


class BodiesAt:
    """The bodies that contain each point, in listing order. Those of point i are body[offsets[i]:offsets[i + 1]].

    `Scene.bodies_at` makes it. It is a sequence over points, numbered in C order: x[i] has the bodies of one point.

    Parameters
    ----------
    offsets : int64 (points + 1,)
        The first row of each point.
    body : int32 (n,)
        Numbers of bodies.
    shape : tuple of int
        The leading shape of the points.
    labels : Labels
        Names and materials of the scene's bodies.
    """

    def __init__(self, offsets: Any, body: npt.NDArray[np.int32], shape: tuple[int, ...], labels: Labels) -> None:
        self.offsets, self.shape, self._labels = offsets, shape, labels
        for array in (offsets, body):
            array.setflags(write=False)
        self.body: Any = body

    @property
    def counts(self) -> Any:
        """int64 (...): the number of bodies that contain each point."""
        return np.diff(self.offsets).reshape(self.shape)[()]

    @property
    def name(self) -> Any:
        """object (n,): the name of each of `body`, or None."""
        return self._labels.names_of(self.body)

    @property
    def material(self) -> Any:
        """object (n,): the material of each of `body`, or None."""
        return self._labels.materials_of(self.body)

    def __eq__(self, other: object) -> bool:
        if not isinstance(other, BodiesAt):
            return NotImplemented
        return (
            self.shape == other.shape
            and np.array_equal(self.offsets, other.offsets)
            and np.array_equal(self.body, other.body)
        )

    __hash__ = None  # type: ignore[assignment]

    def __len__(self) -> int:
        return len(self.offsets) - 1

    def __getitem__(self, point: int) -> npt.NDArray[np.int32]:
        number = range(len(self))[point]
        return self.body[self.offsets[number] : self.offsets[number + 1]]

    def __iter__(self) -> Iterator[npt.NDArray[np.int32]]:
        return (self[i] for i in range(len(self)))

    def __repr__(self) -> str:
        return f"BodiesAt(shape={self.shape}, {format_count(len(self.body), 'body', 'bodies')})"


# Queries on arrays of points, in packets of 64

_CHUNK = 64  # packets that a thread takes at a time
_PACKET = 64  # points of a packet
_LEAST = 16  # rows and columns of a picture, from which on its squares are packets
BEFORE_FIRST = np.full(1, -1, np.int32)
"""The number before all bodies, so that `first_after` returns the first body."""


def points_of(owner: str, points: Any) -> tuple[FloatArray, tuple[int, ...]]:
    """Return points as kernels take them, (n, 3), and their leading shape. Raise ValueError for invalid points."""
    array = points_array(owner, "points", points)
    flat = np.ascontiguousarray(array.reshape(-1, 3))
    bad = rows_outside_domain(flat)
    if len(bad):
        where = [int(i) for i in np.unravel_index(bad[0], array.shape[:-1])] if array.ndim > 1 else ""
        found = tuple(flat[bad[0]].tolist())
        raise ValueError(f"{owner}: points{where} must be finite and of magnitude up to {LARGEST:g}, got {found}")
    return flat, array.shape[:-1]


def body_at(scene: PreparedScene, points: Any, owner: str = "body_at") -> Any:
    """Return the lowest-numbered body that contains each point, -1 for none; int32 of the points' shape."""
    flat, shape = points_of(owner, points)
    if len(flat) == 1 and scene.lacks_single_calls("body_at"):
        _keep_single_call(scene, "body_at", _body_of_single)
    return first_after(scene, flat, BEFORE_FIRST, width_of(shape)).reshape(shape)[()]


def contains(scene: PreparedScene, points: Any) -> Any:
    """Return whether any solid contains each point; bool of the points' shape."""
    bodies = body_at(scene, points, "contains")
    if np.size(bodies) == 1 and scene.lacks_single_calls("contains"):
        _keep_single_call(scene, "contains", _is_in_solid)
    return np.asarray(bodies >= 0)[()]  # a scalar for one point


def _keep_single_call(scene: PreparedScene, query: str, answer: Callable[..., Any]) -> None:
    """Let `answer` answer the query of one point from now on, `PreparedScene.keep_single_calls`."""
    point, body, still = np.zeros((1, 3)), np.zeros(1, np.int32), np.zeros(1, np.int8)
    arguments = scene.geometry, scene.rest, point, BEFORE_FIRST, 0, 0, 1, body, still
    scene.keep_single_calls(query, answer, ("locate_packets", arguments, (point,), (body, still)))


def _body_of_single(calls: Sequence[Callable[..., Any]], scene: PreparedScene, point: Any) -> Any:
    """Return the first body that contains a point, -1 for none; None where `body_at` must answer."""
    found = calls[0](point)
    return None if found is None or found[2] else np.int32(found[1])


def _is_in_solid(calls: Sequence[Callable[..., Any]], scene: PreparedScene, point: Any) -> Any:
    """Return whether any solid contains a point; None where `contains` must answer."""
    body = _body_of_single(calls, scene, point)
    return None if body is None else body >= 0


def width_of(shape: tuple[int, ...]) -> int:
    """Return the width of the picture that points of a shape make, or 0."""
    return shape[-1] if len(shape) > 1 and min(shape[-2:]) >= _LEAST else 0


def packets_of(count: int, width: int) -> int:
    """Return the number of packets: of squares in a picture of that width, or of 64 points in a row."""
    return -(-width // 8) * -(-count // (8 * width)) if width else -(-count // _PACKET)


def first_after(scene: PreparedScene, points: FloatArray, after: Any, width: int = 0) -> Any:
    """Return the first body with a number above `after` that contains each of the points (n, 3), -1 for none.

    after: (n,), or (1,) for all points. width: of the picture that the points make, or 0.
    """
    count = len(points)
    bodies, still = np.empty(count, np.int32), np.empty(count, np.int8)
    packets = packets_of(count, width)
    run_on(
        scene.geometry,
        KernelRange(locate_packets, (scene.rest, points, after, width), (bodies, still)),
        packets,
        chunk_of_rays(scene.geometry, packets, _CHUNK, count),
        count,
    )
    resolve_bodies(scene, points, after, np.flatnonzero(still), bodies)
    return bodies


def bodies_at(scene: PreparedScene, points: Any, query: Callable[[FloatArray, Any], Any] | None = None) -> BodiesAt:
    """Return all bodies that contain each point.

    ask: a function (points, after) with the result of `first_after`, as on workers. Each round finds the next body of
    the points that had one in the round before.
    """
    flat, shape = points_of("bodies_at", points)
    width = width_of(shape)
    first = query or (lambda some, after: first_after(scene, some, after, width if len(some) == len(flat) else 0))
    which, after = np.arange(len(flat)), BEFORE_FIRST
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
