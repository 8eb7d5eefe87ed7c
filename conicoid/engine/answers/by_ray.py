"""Lists of rows for each ray, indexed by ray: `spans[i]`, `len(crossings)`, `for one in spans`."""

from __future__ import annotations

import os
from collections.abc import Iterable, Iterator
from typing import Any, ClassVar, Self

import numpy as np

from ...shapes.calls import explained_methods
from ...shapes.carried import read_only
from ...shapes.labels import counted
from ...shapes.validate import npz_path, shown
from .rays import Rays, refuse_name
from .unpacked import refuse_pairs


@explained_methods
class ByRay:
    """A sequence over flat rays (in C order). A number selects one ray's rows; a slice, numbers or a mask several rays.

    One ray's rows are true where there are any.
    """

    _columns: ClassVar[tuple[str, ...]]
    offsets: Any
    _rays: Rays

    @property
    def rays(self) -> Rays:
        """Those that were asked."""
        return self._rays

    @property
    def shape(self) -> tuple[int, ...]:
        """The leading shape of the rays; how many rows each has is np.diff(offsets)."""
        return self._rays.shape

    @classmethod
    def concatenate(cls, parts: Iterable[Self]) -> Self:
        """Rows of rays one after the other along the first axis of the rays; single ones count as rows of one.

        `parts` are of one scene, with it or without. Raises TypeError for what is of another kind, ValueError for none
        at all, for shapes that do not fit and for different scenes, whose body numbers mean different things.
        """
        from .joined import joined_lists

        return joined_lists(cls, parts)

    def save(self, path: str | os.PathLike[str]) -> None:
        """Write all fields as a .npz file at `path`, which `load` reads; the scene stays behind, as with `detached`.

        The file appears whole or not at all. Raises ValueError for another suffix, OSError where it cannot be written.
        """
        from ...formats.lists_file import write_lists_file

        write_lists_file(npz_path("save", type(self).__name__.lower(), path), self)

    @classmethod
    def load(cls, path: str | os.PathLike[str]) -> Self:
        """What is in the file at `path` that `save` wrote, detached from its scene. Nothing in a file is executed.

        Raises ValueError for what is no such file, naming it, and OSError where it cannot be read.
        """
        from ...formats.lists_file import read_lists_file

        return read_lists_file(npz_path("load", cls.__name__.lower(), path), cls)

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
        for i in range(len(self)):
            refuse_pairs(type(self).__name__)
            yield self[i]

    def __getitem__(self, index: Any) -> Self:
        """The rows of a flat ray, or of several."""
        refuse_name(self, index)
        which = self._which(index)
        flat = np.ravel(which)
        counts = np.diff(self.offsets)[flat].astype(np.intp, copy=False)
        offsets = np.concatenate([[0], np.cumsum(counts, dtype=np.int64)])
        first = np.repeat(self.offsets[flat], counts)
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

    def _which(self, index: Any) -> Any:
        """The numbers of the flat rays that an index selects."""
        if np.asarray(index).dtype == np.bool_ and np.shape(index) == (int(self.offsets[-1]),) != (len(self),):
            name, field = type(self).__name__.lower(), self._columns[0]
            raise IndexError(
                f"{type(self).__name__}: a mask selects rays, of which there are {len(self)}, got one of "
                f"{int(self.offsets[-1])} rows: {name}.{field}[mask] has the rows of a field"
            )
        if np.shape(index) == self._rays.shape != () and np.asarray(index).dtype == np.bool_:
            index = np.ravel(index)
        is_flat = np.ndim(index) < 2 and not (isinstance(index, tuple) and len(index) != 1)
        which = np.arange(len(self))[index] if is_flat else None
        if which is None or which.ndim > 1:
            raise IndexError(
                f"{type(self).__name__}: index must be a number, a slice, a list of numbers or a mask over the "
                f"{counted(len(self), 'ray', 'rays')}, got {shown(index)}{self._meant(index)}"
            )
        return which

    def _meant(self, index: Any) -> str:
        """What may be meant by several numbers: a ray of a picture by its axes, or a row of a ray."""
        if not isinstance(index, tuple) or not all(isinstance(i, int) for i in index):
            return ""
        name, shape = type(self).__name__.lower(), self._rays.shape
        if len(index) == len(shape) > 1 and all(-n <= i < n for i, n in zip(index, shape, strict=True)):
            flat = int(np.arange(len(self)).reshape(shape)[index])
            return f"; rays are counted flat: that of the index {index} is {name}[{flat}]"
        if len(index) == 2 and len(shape) < 2:
            return f"; one row of one ray is {name}[{index[0]}].{self._columns[0]}[{index[1]}]"
        return ""
