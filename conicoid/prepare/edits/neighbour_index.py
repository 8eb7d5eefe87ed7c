"""Neighbour index: a place for each surface, nearly equal where two surfaces are equal.

It is the place along one direction of the features in `surface_features.py`, about a point and in units that stay
while a scene is edited, so that only new surfaces need new places.
"""

from __future__ import annotations

import math
from collections.abc import Sequence
from dataclasses import replace
from functools import cached_property
from typing import TypeAlias

import numpy as np
import numpy.typing as npt

from ..._util.records import dataclass
from ...kernels.tables import QUADRIC, SPHERE, Floats, Ints, Longs, Tables
from ..surface_features import (
    CLOSENESS,
    FIRST_DIRECTION,
    Point,
    QuadricTable,
    put_places_of_curved,
    put_places_of_planes,
)

RecordColumns: TypeAlias = tuple[Floats, Floats, QuadricTable]
"""Tables of planes, spheres and quadrics."""
Marks: TypeAlias = npt.NDArray[np.uint16]
_ROOM = 4.0
"""The unit is about so many times the size of the scene, which may grow that much before all places are recomputed."""
_FITS = 1.0 / 64, 1.0 / 2
"""The size of the scene may be between these shares of the unit."""
_SOME = 256
"""So many records, spread over a table, give an estimate of its middle and size."""
_BUCKETS = 1 << 16
_NO_SPHERES, _NO_QUADRICS = np.zeros((0, 4)), QuadricTable(np.zeros((0, 4)), np.zeros((0, 16)))
Reach: TypeAlias = tuple[float, float]
"""The largest length of planes, and that of curved surfaces."""


@dataclass(frozen=True)
class NeighbourFrame:
    """What places are relative to: points, and units of length, of planes and of curved surfaces."""

    middle_of_planes: Point
    unit_of_planes: float
    middle: Point
    unit: float

    @classmethod
    def of_scenes(cls, *scenes: RecordColumns) -> tuple[NeighbourFrame, list[NeighbourPlaces]]:
        """Choose a frame that fits the records of some scenes, the first above all.

        Return also the places in each scene.

        It is estimated from some of the records; only where it does not fit all of them, they are processed twice.
        """
        few = [_sample(records) for records in scenes]
        planes, spheres, quadrics = next((records for records in few if any(len(table) for table in records)), few[0])
        about = cls(_middle(planes[:, 4:]), 1.0, _middle(spheres[:, :3], quadrics.rows[:, :3]), 1.0)
        # First estimate the units by a sample of the records.
        guess = about._with_room([about._places(*records)[1] for records in few])
        places, reach = guess._all_places(scenes)
        if all(_fits(max(of_kind)) for of_kind in zip(*reach, strict=True)):
            return guess, places
        found = about._with_room([(planes * guess.unit_of_planes, curved * guess.unit) for planes, curved in reach])
        return found, places if found == guess else found._all_places(scenes)[0]

    def _all_places(self, scenes: Sequence[RecordColumns]) -> tuple[list[NeighbourPlaces], list[Reach]]:
        """`_places` of the records of each scene."""
        found = [self._places(*records) for records in scenes]
        return [places for places, _ in found], [reach for _, reach in found]

    def _with_room(self, reach: Sequence[Reach]) -> NeighbourFrame:
        """Choose units for records of this reach; a unit is 1 where no record has a length."""
        planes, curved = (max(of_kind) for of_kind in zip(*reach, strict=True))
        return replace(self, unit_of_planes=_unit(planes), unit=_unit(curved))

    def _places(self, planes: Floats, spheres: Floats, quadrics: QuadricTable) -> tuple[NeighbourPlaces, Reach]:
        """Compute the places of records; return also the largest lengths of planes and of curved surfaces, in units."""
        flat, round_, rest = (np.zeros(len(table)) for table in (planes, spheres, quadrics))
        far = put_places_of_planes(
            planes,
            _rows(planes),
            self.middle_of_planes,
            self.unit_of_planes,
            FIRST_DIRECTION[:4],
            FIRST_DIRECTION[:3],
            flat,
        )
        reach = self._put_curved(SPHERE, spheres, _NO_QUADRICS, round_)
        reach = max(reach, self._put_curved(QUADRIC, _NO_SPHERES, quadrics, rest))
        return NeighbourPlaces(flat, round_, rest), (far, reach)

    def _put_curved(self, kind: int, spheres: Floats, quadrics: QuadricTable, places: Floats) -> float:
        """Write the places of spheres or of quadrics; return the largest length."""
        count, rows = len(places), np.ascontiguousarray(quadrics.rows)
        return put_places_of_curved(
            np.full(count, kind, np.int8), np.arange(count, dtype=np.int32), spheres, rows, quadrics.forms,
            self.middle, self.unit, FIRST_DIRECTION, FIRST_DIRECTION[:6], np.empty((1, 19)), np.empty((1, 10)), places,
        )  # fmt: skip

    def places_within(self, planes: Floats, spheres: Floats, quadrics: QuadricTable) -> NeighbourPlaces | None:
        """Compute the places of records; None where these are larger than the units."""
        places, most = self._places(planes, spheres, quadrics)
        return places if max(most) <= 1.0 else None


@dataclass(frozen=True)
class NeighbourPlaces:
    """The places of planes, spheres and quadrics, by their rows."""

    planes: Floats
    spheres: Floats
    quadrics: Floats

    @cached_property
    def marks(self) -> tuple[Marks, Marks, Marks]:
        """For each place its bucket, one of 65,536 parts of a unit."""
        return _bucket(self.planes), _bucket(self.spheres), _bucket(self.quadrics)

    @classmethod
    def of_buckets(cls, planes: Floats, spheres: Floats, quadrics: Floats, *marks: Marks) -> NeighbourPlaces:
        """Build places with known buckets."""
        places = cls(planes, spheres, quadrics)
        vars(places)["marks"] = marks
        return places


def find_neighbours(places: Floats, marks: Marks, new: Floats) -> Longs:
    """Return the rows of places so close to a new one that the surfaces may be equal.

    `marks` are the buckets of `places`: most rows are rejected by them alone.
    """
    if not len(places) or not len(new):
        return np.zeros(0, np.int64)
    marked = np.zeros(_BUCKETS, bool)
    # Also the buckets on both sides of a border: places may differ by 2 * CLOSENESS.
    for off in (-1.0, 0.0, 1.0):
        marked[_bucket(new + 2 * off * CLOSENESS)] = True
    rows = np.flatnonzero(marked.take(marks))
    ordered = np.sort(new)
    low = np.searchsorted(ordered, places[rows] - 2 * CLOSENESS, side="left")
    high = np.searchsorted(ordered, places[rows] + 2 * CLOSENESS, side="right")
    return rows[low < high]


def _bucket(places: Floats) -> Marks:
    """Return the bucket of each place; any bucket for NaN."""
    # uint16 wraps places below 0 and beyond the unit: equal places still share a bucket.
    with np.errstate(invalid="ignore"):
        return (places * _BUCKETS).astype(np.int64).astype(np.uint16)


def surface_columns(tables: Tables) -> RecordColumns:
    """Return the surface records of a scene."""
    return tables.planes, tables.spheres, QuadricTable(tables.quadrics, tables.quadric_forms)


def _sample(records: RecordColumns) -> RecordColumns:
    """Take about `_SOME` records of each table, spread over it."""
    planes, spheres, quadrics = records
    every = [slice(None, None, max(1, len(table) // _SOME)) for table in records]
    return (
        np.ascontiguousarray(planes[every[0]]), np.ascontiguousarray(spheres[every[1]]), quadrics.select(every[2]),
    )  # fmt: skip


def _unit(length: float) -> float:
    """Return a unit with room for longer lengths."""
    return _ROOM * length if 0 < length < math.inf else 1.0


def _fits(length: float) -> bool:
    """Return whether a unit fits a length that was measured in it."""
    return length == 0.0 or _FITS[0] <= length <= _FITS[1]


def _rows(table: Floats) -> Ints:
    return np.arange(len(table), dtype=np.int32)


def _middle(*anchors: Floats) -> Point:
    """Return the mean of some points."""
    count = sum(map(len, anchors))
    x, y, z = (sum(part.sum(axis=0) for part in anchors) / count).tolist() if count else (0.0, 0.0, 0.0)
    return x, y, z
