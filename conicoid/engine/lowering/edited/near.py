"""Which surfaces of a scene may be one of some new ones: a number for each, nearly equal where two are equal.

It is the place along one direction of what `surfaces` compares, about a point and in units that stay the same while a
scene is edited, so that only the new surfaces need new numbers.
"""

from __future__ import annotations

from dataclasses import dataclass
from functools import cached_property
from typing import TypeAlias

import numpy as np
import numpy.typing as npt

from ....shapes.row_vectors import dot_rows, lengths
from ...tables import QUADRIC, SPHERE, Floats, Longs
from ..clusters import ALONG, CLOSE, coefficients

Records: TypeAlias = tuple[Floats, Floats, Floats]
"""Tables of planes, spheres and quadrics."""
Marks: TypeAlias = npt.NDArray[np.uint16]
_ROOM = 4.0
"""The unit is so many times the size of the scene, which may grow before all numbers are worked out again."""
_BUCKETS = 1 << 16


@dataclass(frozen=True)
class Frame:
    """What numbers are relative to: points, and units of length, of planes and of what is curved."""

    middle_of_planes: Floats
    unit_of_planes: float
    middle: Floats
    unit: float

    @classmethod
    def around(cls, old: Records, new: Records) -> tuple[Frame, Places, Places]:
        """One that fits the records of two scenes, and the numbers of both."""
        planes, spheres, quadrics = (np.concatenate(pair) for pair in zip(old, new, strict=True))
        anchors = np.concatenate([spheres[:, :3], quadrics[:, :3]])
        first = cls(_middle(planes[:, 4:]), 1.0, _middle(anchors), 1.0)
        flat, curved = first._of_planes(planes), first._of_curved(spheres, quadrics)
        of_planes = float(np.abs(flat[:, 3]).max(initial=0.0))
        with np.errstate(over="ignore"):
            reach = float(np.abs(curved[:, 6:9]).max(initial=0.0))
            reach = max(reach, float(np.sqrt(np.abs(curved[:, 9]).max(initial=0.0))))
        found = cls(first.middle_of_planes, _ROOM * of_planes or 1.0, first.middle, _ROOM * reach or 1.0)
        flat[:, 3] /= found.unit_of_planes
        _scale(curved, found.unit)
        both, curves = _place(flat, 3), _place(curved, 6)
        round_, rest = curves[: len(spheres)], curves[len(spheres) :]
        ends = [len(table) for table in old]
        parts = [(part[:end], part[end:]) for part, end in zip((both, round_, rest), ends, strict=True)]
        return found, Places(*(part for part, _ in parts)), Places(*(part for _, part in parts))

    def _of_planes(self, planes: Floats) -> Floats:
        """Unit normals, and offsets about the middle."""
        normals, over, anchors = planes[:, :3], planes[:, 3], planes[:, 4:]
        sizes = lengths(normals)
        offsets = (((anchors - self.middle_of_planes) * normals).sum(axis=1) - over) / sizes
        return np.column_stack([normals / sizes[:, None], offsets / self.unit_of_planes])

    def _of_curved(self, spheres: Floats, quadrics: Floats) -> Floats:
        """Coefficients about the middle."""
        kind = np.repeat(np.array([SPHERE, QUADRIC], np.int8), [len(spheres), len(quadrics)])
        row = np.concatenate([np.arange(len(spheres)), np.arange(len(quadrics))]).astype(np.int32)
        numbers = coefficients(kind, row, spheres, quadrics, self.middle)
        _scale(numbers, self.unit)
        return numbers

    def places_within(self, planes: Floats, spheres: Floats, quadrics: Floats) -> Places | None:
        """The numbers of records; None where these are larger than the units."""
        flat, curved = self._of_planes(planes), self._of_curved(spheres, quadrics)
        if not all(bool((np.abs(part) <= 1.0).all()) for part in (flat[:, 3:], curved[:, 6:])):
            return None
        numbers = _place(curved, 6)
        return Places(_place(flat, 3), numbers[: len(spheres)], numbers[len(spheres) :])


@dataclass(frozen=True)
class Places:
    """The numbers of planes, spheres and quadrics, by their rows."""

    planes: Floats
    spheres: Floats
    quadrics: Floats

    @cached_property
    def marks(self) -> tuple[Marks, Marks, Marks]:
        """In which of many parts of a unit each is."""
        return _bucket(self.planes), _bucket(self.spheres), _bucket(self.quadrics)

    @classmethod
    def marked(cls, planes: Floats, spheres: Floats, quadrics: Floats, *marks: Marks) -> Places:
        """These, with the marks of each."""
        made = cls(planes, spheres, quadrics)
        vars(made)["marks"] = marks
        return made


def near(places: Floats, marks: Marks, new: Floats) -> Longs:
    """Rows of places, by them and their marks, that are as close to a new one as surfaces may be that are one."""
    if not len(places) or not len(new):
        return np.zeros(0, np.int64)
    marked = np.zeros(_BUCKETS, bool)
    for off in (-1.0, 0.0, 1.0):
        marked[_bucket(new + 2 * off * CLOSE)] = True
    rows = np.flatnonzero(marked.take(marks))
    ordered = np.sort(new)
    low = np.searchsorted(ordered, places[rows] - 2 * CLOSE, side="left")
    high = np.searchsorted(ordered, places[rows] + 2 * CLOSE, side="right")
    found: Longs = rows[low < high]
    return found


def _bucket(places: Floats) -> Marks:
    """In which of many parts of a unit each place is; any, where it is no number."""
    with np.errstate(invalid="ignore"):
        return (places * _BUCKETS).astype(np.int64).astype(np.uint16)


def _scale(numbers: Floats, unit: float) -> None:
    """Coefficients in other units of length."""
    numbers[:, 6:9] /= unit
    numbers[:, 9] /= unit
    numbers[:, 9] /= unit


def _middle(anchors: Floats) -> Floats:
    return anchors.mean(axis=0) if len(anchors) else np.zeros(3)


def _place(features: Floats, leading: int) -> Floats:
    """Along one direction, after the sign has been fixed by the leading numbers."""
    sign = np.sign(dot_rows(features[:, :leading], ALONG[:leading]))
    places: Floats = dot_rows(features, ALONG[: features.shape[1]]) * np.where(sign == 0, 1.0, sign)
    return places
