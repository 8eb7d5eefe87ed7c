"""Which surfaces of a scene may be one of some new ones: a number for each, nearly equal where two are equal.

It is the place along one direction of what `surfaces` compares, about a point and in units that stay the same while a
scene is edited, so that only the new surfaces need new numbers.
"""

from __future__ import annotations

import math
from dataclasses import dataclass
from functools import cached_property
from typing import TypeAlias

import numpy as np
import numpy.typing as npt

from ...tables import QUADRIC, SPHERE, Floats, Ints, Longs
from ..clusters import ALONG, CLOSE
from ..features import Point, put_places_of_curved, put_places_of_planes

Records: TypeAlias = tuple[Floats, Floats, Floats]
"""Tables of planes, spheres and quadrics."""
Marks: TypeAlias = npt.NDArray[np.uint16]
_ROOM = 4.0
"""The unit is so many times the size of the scene, which may grow before all numbers are worked out again."""
_BUCKETS = 1 << 16


@dataclass(frozen=True)
class Frame:
    """What numbers are relative to: points, and units of length, of planes and of what is curved."""

    middle_of_planes: Point
    unit_of_planes: float
    middle: Point
    unit: float

    @classmethod
    def around(cls, old: Records, new: Records) -> tuple[Frame, Places, Places]:
        """One that fits the records of two scenes, and the numbers of both."""
        planes, spheres, quadrics = old if any(map(len, old)) else new
        first = cls(_middle(planes[:, 4:]), 1.0, _middle(spheres[:, :3], quadrics[:, :3]), 1.0)
        most = [max(pair) for pair in zip(*(first._places(*records)[1] for records in (old, new)), strict=True)]
        units = [_ROOM * each if 0 < each < math.inf else 1.0 for each in most]
        found = cls(first.middle_of_planes, units[0], first.middle, units[1])
        return found, found._places(*old)[0], found._places(*new)[0]

    def _places(self, planes: Floats, spheres: Floats, quadrics: Floats) -> tuple[Places, tuple[float, float]]:
        """The numbers of records; the largest length of planes, and of what is curved, in their units."""
        flat, round_, rest = (np.zeros(len(table)) for table in (planes, spheres, quadrics))
        far = put_places_of_planes(
            planes, _rows(planes), self.middle_of_planes, self.unit_of_planes, ALONG[:4], ALONG[:3], flat
        )
        reach = [
            put_places_of_curved(
                np.full(len(table), kind, np.int8), _rows(table), spheres, quadrics, self.middle, self.unit, ALONG,
                ALONG[:6], np.empty((1, 10)), places,
            )
            for kind, table, places in ((SPHERE, spheres, round_), (QUADRIC, quadrics, rest))
        ]  # fmt: skip
        return Places(flat, round_, rest), (far, max(reach))

    def places_within(self, planes: Floats, spheres: Floats, quadrics: Floats) -> Places | None:
        """The numbers of records; None where these are larger than the units."""
        places, most = self._places(planes, spheres, quadrics)
        return places if max(most) <= 1.0 else None


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


def _rows(table: Floats) -> Ints:
    return np.arange(len(table), dtype=np.int32)


def _middle(*anchors: Floats) -> Point:
    """The mean of some points."""
    count = sum(map(len, anchors))
    x, y, z = (sum(part.sum(axis=0) for part in anchors) / count).tolist() if count else (0.0, 0.0, 0.0)
    return x, y, z
