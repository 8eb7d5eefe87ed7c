"""Many bodies of one kind in one entry of a scene, from arrays."""

from __future__ import annotations

from abc import abstractmethod
from collections.abc import Iterable, Sequence
from typing import Any, ClassVar, NoReturn

import numpy as np

from .arrays import real_array
from .base import Shape
from .boxes import EVERYWHERE
from .calm import calm
from .motion import Motion
from .row_vectors import product
from .validate import DOMAIN, outside_domain, shown, whole
from .vector import Box, FloatArray

_CLOSE = 1e-9
"""Bodies whose ends, worked out in floats, lie so near the last one may be the last, as a share of sizes and places."""
_MOST_LAST = 256


class Bulk(Shape, abstract=True):
    """N bodies of one kind, with consecutive ids, as if N single shapes stood in the list.

    A scene entry only: it does not combine with ``| & - ~``. A motion moves all of them. `single` gives one.
    """

    combines: ClassVar[bool] = False
    columns: ClassVar[dict[str, tuple[str, ...]]] = {}
    """Of each field, what its numbers are called in a table: one name for a number, three for a vector."""
    leaves: ClassVar[tuple[tuple[str | float, ...], ...]] = ()
    """Of each primitive of a single shape, the fields and constants that its numbers are, in their order."""

    @abstractmethod
    def single(self, index: int) -> Shape:
        """One of them, by its `index`, as a shape of its own under the same motion."""

    def check_rows(self) -> None:
        """Refuse bodies that there cannot be, by `refuse`; each number is known to be finite and of the domain."""

    def reaches(self, rows: FloatArray) -> tuple[FloatArray, FloatArray]:
        """About how far the bodies reach along the rows of a matrix (3, 3), down and up: two arrays (N, 3)."""
        raise NotImplementedError

    @calm
    def __post_init__(self) -> None:
        owner = type(self).__name__
        given = {name: real_array(owner, name, getattr(self, name)) for name in self.columns}
        count = _count(owner, given, self.columns)
        for name, values in given.items():
            made = _broadcast(values, count, len(self.columns[name]))
            _check_numbers(owner, name, made)
            made.flags.writeable = False
            object.__setattr__(self, name, made)
        self.check_rows()

    def refuse(self, field: str, bad: Any, expected: str) -> None:
        """Raise ValueError for the first body of which a `field` is bad, and say what was `expected`.

        As in "Cylinders: radii[3] must be > 0, got -1.0".
        """
        found = np.flatnonzero(bad)
        if len(found):
            value = getattr(self, field)[found[0]]
            raise ValueError(f"{type(self).__name__}: {field}[{found[0]}] must be {expected}, got {value}")

    def __len__(self) -> int:
        return len(getattr(self, next(iter(self.columns))))

    def __eq__(self, other: object) -> bool:
        if type(other) is not type(self):
            return NotImplemented
        same = (np.array_equal(getattr(self, name), getattr(other, name)) for name in self.columns)
        return self.motion == other.motion and all(same)

    def __hash__(self) -> int:
        first = getattr(self, next(reversed(self.columns)))
        return hash((type(self), len(self), self.motion, first.tobytes()[:64]))

    def row(self, index: int, name: str) -> Any:
        """The number of the field `name` of body `index` as a float, or its three as a tuple."""
        return _plain(getattr(self, name)[self._place(index)])

    def _place(self, index: Any) -> int:
        """The place of one body, checked."""
        place = whole(index)
        if place is None:
            raise TypeError(f"{type(self).__name__}.single: index must be a whole number, got {shown(index)}")
        if not 0 <= place < len(self):
            raise IndexError(
                f"{type(self).__name__}.single: index must be at least 0 and below {len(self)}, got {shown(index)}"
            )
        return place

    def numbers(self, leaf: int) -> FloatArray:
        """(N, n) numbers of one primitive, number `leaf`, of each body, in the order of its fields."""
        parts = [
            self._flat(part) if isinstance(part, str) else np.full((len(self), 1), part) for part in self.leaves[leaf]
        ]
        return np.concatenate(parts, axis=1)

    def _flat(self, name: str) -> FloatArray:
        """(N, n) numbers of a field."""
        values: FloatArray = getattr(self, name)
        return values if values.ndim == 2 else values[:, None]

    @classmethod
    def headings(cls) -> tuple[str, ...]:
        """The columns of a table of them."""
        return tuple(heading for headings in cls.columns.values() for heading in headings)

    def table(self) -> FloatArray:
        """(N, columns) all numbers, but for the motion."""
        return np.concatenate([self._flat(name) for name in self.columns], axis=1)

    @classmethod
    def of_table(cls, table: FloatArray) -> Any:
        """From what `table` gives."""
        fields: dict[str, Any] = {}
        at = 0
        for name, headings in cls.columns.items():
            values = table[:, at : at + len(headings)]
            fields[name] = values if len(headings) > 1 else values[:, 0]
            at += len(headings)
        return cls(**fields)

    def bounds_under(self, outer: Motion) -> Box:
        """The box around the boxes of all; where hundreds of bodies end at one place, wider by 1e-9 of its size."""
        if len(self) == 0:
            return EVERYWHERE[1], EVERYWHERE[0]
        motion = self.motion.then(outer)
        matrix = motion.matrix
        down, up = self.reaches(matrix[:3, :3])
        ends = np.concatenate([down - matrix[:3, 3], up + matrix[:3, 3]], axis=1)
        size = _CLOSE * (np.abs(ends).max(initial=0.0) + np.abs(matrix[:3, 3]).max(initial=0.0))
        last = [np.flatnonzero(column >= column.max() - size) for column in ends.T]
        known: dict[int, FloatArray] = {}
        result = np.empty(6)
        for side, which in enumerate(last):
            if len(which) > _MOST_LAST:
                result[side] = ends[:, side].max() + size
                continue
            for index in which.tolist():
                if index not in known:
                    low, high = self.single(index).bounds_under(outer)
                    known[index] = np.concatenate([0.0 - low, high])
            result[side] = max(known[index][side] for index in which.tolist())
        return 0.0 - result[:3], result[3:] + 0.0

    def __or__(self, other: Any) -> NoReturn:
        raise _alone(self)

    __and__ = __sub__ = __ror__ = __rand__ = __rsub__ = __or__

    def __invert__(self) -> NoReturn:
        raise _alone(self)


def _alone(shape: Bulk) -> TypeError:
    name = type(shape).__name__
    return TypeError(
        f"{name}: does not combine with other shapes, it is an entry of a scene; {name}(...).single(i) does"
    )


def reach_of_points(points: Sequence[FloatArray], rows: FloatArray) -> tuple[FloatArray, FloatArray]:
    """`Bulk.reaches` of the hulls of points, arrays (N, 3)."""
    placed = [product(each, rows.T) for each in points]
    return np.max([-each for each in placed], axis=0), np.max(placed, axis=0)


def reach_of_balls(
    centers: Iterable[FloatArray], radii: Iterable[FloatArray], rows: FloatArray
) -> tuple[FloatArray, FloatArray]:
    """`Bulk.reaches` of the hulls of balls."""
    size = np.sqrt((rows**2).sum(axis=1))
    pairs = [(product(center, rows.T), radius[:, None] * size) for center, radius in zip(centers, radii, strict=True)]
    return np.max([reach - at for at, reach in pairs], axis=0), np.max([reach + at for at, reach in pairs], axis=0)


def reach_of_discs(
    centers: Iterable[FloatArray], normals: FloatArray, radii: Iterable[FloatArray], rows: FloatArray
) -> tuple[FloatArray, FloatArray]:
    """`Bulk.reaches` of the hulls of discs across normals (N, 3), which need not be unit."""
    unit = normals / np.sqrt((normals**2).sum(axis=1))[:, None]
    along = product(unit, rows.T)
    across = np.sqrt(np.maximum((rows**2).sum(axis=1) - along**2, 0.0))
    pairs = [(product(center, rows.T), radius[:, None] * across) for center, radius in zip(centers, radii, strict=True)]
    return np.max([reach - at for at, reach in pairs], axis=0), np.max([reach + at for at, reach in pairs], axis=0)


def _plain(value: Any) -> Any:
    found = value.tolist()
    return tuple(found) if isinstance(found, list) else found


def _count(owner: str, given: dict[str, FloatArray], columns: dict[str, tuple[str, ...]]) -> int:
    """How many bodies arrays are of; one where each has what is of one body."""
    counts: dict[str, int] = {}
    for name, values in given.items():
        width = len(columns[name])
        own = 1 if width == 1 else 2
        if values.size == 0 and values.ndim <= own:
            counts[name] = 0
        elif values.ndim == own and (width == 1 or values.shape[1] == width):
            counts[name] = len(values)
        elif values.ndim != own - 1 or (width > 1 and values.shape != (width,)):
            one, many = ("one number", "(N,)") if width == 1 else (f"{width} numbers", f"(N, {width})")
            raise ValueError(f"{owner}: {name} must have shape {many}, or be {one} for all, got shape {values.shape}")
    different = sorted(set(counts.values()))
    if len(different) > 1:
        told = ", ".join(f"{name} of {count:,}" for name, count in counts.items())
        raise ValueError(f"{owner}: arrays must be of equally many bodies, got {told}")
    return different[0] if different else 1


def _broadcast(values: FloatArray, count: int, width: int) -> FloatArray:
    """A copy for each of the bodies."""
    shape = (count,) if width == 1 else (count, width)
    return np.array(np.broadcast_to(values.reshape(shape) if values.size == 0 and count == 0 else values, shape))


def _check_numbers(owner: str, field: str, values: FloatArray) -> None:
    """ValueError for the first body with a number that is not finite, or not of the domain."""
    for bad, expected in ((~np.isfinite(values), "finite"), (outside_domain(values), DOMAIN)):
        rows = np.flatnonzero(bad if values.ndim == 1 else bad.any(axis=1))
        if len(rows):
            raise ValueError(f"{owner}: {field}[{rows[0]}] must be {expected}, got {shown(_plain(values[rows[0]]))}")
