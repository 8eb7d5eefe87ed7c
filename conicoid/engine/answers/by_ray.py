"""Lists of rows for each ray, indexed by ray: `spans[i]`, `len(crossings)`, `for one in spans`."""

from __future__ import annotations

from collections.abc import Iterator
from typing import Any, ClassVar, Self

import numpy as np

from ...shapes.carried import read_only
from .rays import Rays


class ByRay:
    """A sequence over flat rays (in C order). A number selects one ray's rows; a slice, numbers or a mask several rays.

    One ray's rows are true where there are any.
    """

    _columns: ClassVar[tuple[str, ...]]
    offsets: Any
    _rays: Rays

    def __len__(self) -> int:
        """How many rays there are; one for a single ray."""
        return len(self.offsets) - 1

    def __bool__(self) -> bool:
        if len(self) != 1:
            raise ValueError(
                f"{type(self).__name__}: the truth value of the rows of {len(self)} rays is ambiguous; "
                "np.diff(offsets) > 0 tells it for each"
            )
        return bool(self.offsets[1] > 0)

    def __iter__(self) -> Iterator[Self]:
        return (self[i] for i in range(len(self)))

    def __getitem__(self, index: Any) -> Self:
        """The rows of a flat ray, or of several."""
        if np.shape(index) == self._rays.shape != () and np.asarray(index).dtype == np.bool_:
            index = np.ravel(index)
        which = np.arange(len(self))[index]
        counts = np.diff(self.offsets)[which]
        offsets = np.concatenate([[0], np.cumsum(np.atleast_1d(counts))])
        first = np.repeat(self.offsets[which], counts)
        rows = first + np.arange(offsets[-1]) - np.repeat(offsets[:-1], counts)
        part = object.__new__(type(self))
        kept = {name: value for name, value in vars(self).items() if not hasattr(type(self), name)}
        # What has been worked out stays, as answers without their scene cannot do it again
        known = {name: vars(self)[name] for name in vars(self) if hasattr(type(self), name)}
        kept |= {name: value[rows] if isinstance(value, np.ndarray) else value for name, value in known.items()}
        rays = self._rays if self._rays.shape else self._rays[None]
        part.__dict__.update(
            kept,
            offsets=offsets.astype(self.offsets.dtype),
            _rays=rays[np.unravel_index(which, rays.shape)],
            # in C order, as kernels were compiled for
            **{name: np.take(getattr(self, name), rows, axis=-1) for name in self._columns},
        )
        read_only(part)
        return part
