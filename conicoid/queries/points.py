"""All bodies at each of some points, as lists of different length one after the other."""

from __future__ import annotations

from collections.abc import Callable, Iterator
from typing import Any

import numpy as np
import numpy.typing as npt

from .._util.arrays import FloatArray
from .._util.hints import with_method_hints
from .._util.validation import LARGEST, rows_outside_domain
from ..geometry.labels import Labels, format_count
from ..kernels.threads import chunk_of_rays, run_on
from ..prepare.prepared_scene import PreparedScene
from .exact.doubtful_rays import resolve_bodies
from .exact.membership import locate_packets
from .id_arrays import as_id_array
from .rays import points_array
from .result import object_array


@with_method_hints
class BodiesAt:
    """The bodies that contain each point. Those of flat point i are body[offsets[i]:offsets[i + 1]], in their order.

    offsets   int64 (points + 1,)
    body      int32: numbers of bodies
    counts    int64, of the points' shape: how many bodies each point is in
    name, material   objects: what each of `body` is called and made of
    shape     the leading shape of the points
    labels    of the scene's bodies; answers are made by `Scene.bodies_at`

    It is a sequence over flat points: at[i] are the bodies of one.
    """

    def __init__(self, offsets: Any, body: npt.NDArray[np.int32], shape: tuple[int, ...], labels: Labels) -> None:
        self.offsets, self.shape, self._labels = offsets, shape, labels
        for array in (offsets, body):
            array.setflags(write=False)
        self.body: Any = as_id_array("body", body)

    @property
    def counts(self) -> Any:
        """How many bodies each point is in, of the points' shape."""
        return np.diff(self.offsets).reshape(self.shape)[()]

    @property
    def name(self) -> Any:
        """What each of `body` is called, or None."""
        return object_array(self._labels.names_of(self.body))

    @property
    def material(self) -> Any:
        """What each of `body` is made of, or None."""
        return object_array(self._labels.materials_of(self.body))

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


# Queries on arrays of points: which body contains each, and all bodies that do.

_CHUNK = 64  # packets that a thread takes at a time
_PACKET = 64  # points of a packet
_LEAST = 16  # rows and columns of a picture whose squares are asked about together
BEFORE_FIRST = np.full(1, -1, np.int32)
"""After no body: the first is sought."""


def points_of(owner: str, points: Any) -> tuple[FloatArray, tuple[int, ...]]:
    """The points of a query as kernels take them, (n, 3), and the shape of its answer; a named ValueError otherwise."""
    array = points_array(owner, "points", points)
    flat = np.ascontiguousarray(array.reshape(-1, 3))
    bad = rows_outside_domain(flat)
    if len(bad):
        where = [int(i) for i in np.unravel_index(bad[0], array.shape[:-1])] if array.ndim > 1 else ""
        found = tuple(flat[bad[0]].tolist())
        raise ValueError(f"{owner}: points{where} must be finite and of magnitude up to {LARGEST:g}, got {found}")
    return flat, array.shape[:-1]


def body_at(scene: PreparedScene, points: Any, owner: str = "body_at") -> Any:
    """The lowest-numbered body that contains each point, -1 for none; int32 of the points' shape."""
    flat, shape = points_of(owner, points)
    return as_id_array("body", first_after(scene, flat, BEFORE_FIRST, width_of(shape)).reshape(shape)[()])


def width_of(shape: tuple[int, ...]) -> int:
    """The width of the picture that points make, or 0."""
    return shape[-1] if len(shape) > 1 and min(shape[-2:]) >= _LEAST else 0


def packets_of(count: int, width: int) -> int:
    """How many packets some points make: squares of a picture of a width, or 64 in a row."""
    return -(-width // 8) * -(-count // (8 * width)) if width else -(-count // _PACKET)


def first_after(scene: PreparedScene, points: FloatArray, after: Any, width: int = 0) -> Any:
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
    resolve_bodies(scene, points, after, np.flatnonzero(still), bodies)
    return bodies


def bodies_at(scene: PreparedScene, points: Any, ask: Callable[[FloatArray, Any], Any] | None = None) -> BodiesAt:
    """All bodies that contain each point. ask(points, after) is `first_after`, or the same elsewhere.

    Round after round those points are asked for the next body that had one before.
    """
    flat, shape = points_of("bodies_at", points)
    width = width_of(shape)
    first = ask or (lambda some, after: first_after(scene, some, after, width if len(some) == len(flat) else 0))
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
