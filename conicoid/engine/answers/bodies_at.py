"""All bodies at each of some points, as lists of different length one after the other."""

from __future__ import annotations

from collections.abc import Iterator
from typing import Any

import numpy as np
import numpy.typing as npt

from ...shapes.calls import explained_methods
from ...shapes.labels import Labels, counted
from .no_names import numbers_of
from .objects import objects


@explained_methods
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
        self.body: Any = numbers_of("body", body)

    @property
    def counts(self) -> Any:
        """How many bodies each point is in, of the points' shape."""
        return np.diff(self.offsets).reshape(self.shape)[()]

    @property
    def name(self) -> Any:
        """What each of `body` is called, or None."""
        return objects(self._labels.names_of(self.body))

    @property
    def material(self) -> Any:
        """What each of `body` is made of, or None."""
        return objects(self._labels.materials_of(self.body))

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
        return f"BodiesAt(shape={self.shape}, {counted(len(self.body), 'body', 'bodies')})"
