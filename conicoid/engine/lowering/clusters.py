"""Surfaces whose records are so close that they may be one: `surfaces` lets their exact names decide."""

from __future__ import annotations

import math
from collections.abc import Iterable, Iterator
from dataclasses import dataclass, replace
from typing import Any, Protocol

import numpy as np

from ..tables import SPHERE, Floats, Ints, Signs
from .features import Point, put_coefficients, put_places_of_curved, put_places_of_planes
from .quadrics import Quadrics
from .rows import blocks

CLOSE = 1e-11
ALONG = 1.0 / np.sqrt([2.0, 3.0, 5.0, 7.0, 11.0, 13.0, 17.0, 19.0, 23.0, 29.0])
"""A direction in which surfaces of different rational coefficients have different places."""
ACROSS = 1.0 / np.sqrt([31.0, 37.0, 41.0, 43.0, 47.0, 53.0, 59.0, 61.0, 67.0, 71.0]) * np.tile([1.0, -1.0], 5)
"""Another such direction."""
_APART = 1000 * CLOSE
_ROUNDED = 2.0**-12
"""Share of the largest coordinate: `CLOSE` of it is ten times as much as rounding takes from one."""


class Features(Protocol):
    """What is known of surfaces that says where they lie side by side."""

    def places(self, along: Floats, which: Any, /) -> Floats:
        """Where some of them, or all for a slice, lie in a direction."""
        ...


@dataclass
class Flat:
    """Some planes, by their features (`features`)."""

    rows: Ints
    planes: Floats
    middle: Point
    unit: float = 1.0

    @classmethod
    def of(cls, rows: Ints, planes: Floats) -> Flat:
        """In the unit of the scene."""
        found = cls(rows, planes, _point(planes[rows, 4:].mean(axis=0)))
        most = put_places_of_planes(planes, rows, found.middle, 1.0, ALONG[:4], ALONG[:3], np.empty(len(rows)))
        return replace(found, unit=_unit(most, planes[rows, 4:]))

    def places(self, along: Floats, which: Any) -> Floats:
        """`Features.places`"""
        rows = self.rows[which]
        found = np.empty(len(rows))
        put_places_of_planes(self.planes, rows, self.middle, self.unit, along[:4], ALONG[:3], found)
        return found


@dataclass
class Curved:
    """What is curved, by its features."""

    kinds: Signs
    rows: Ints
    spheres: Floats
    quadrics: Quadrics
    middle: Point
    unit: float = 1.0

    @classmethod
    def of(cls, kinds: Signs, rows: Ints, spheres: Floats, quadrics: Quadrics) -> Curved:
        """In the unit of the scene."""
        ball = kinds == SPHERE
        anchors = np.concatenate([spheres[rows[ball], :3], quadrics.rows[rows[~ball], :3]])
        found = cls(kinds, rows, spheres, quadrics, _point(anchors.mean(axis=0)))
        return replace(found, unit=_unit(found._put(ALONG, kinds, rows, np.empty(len(rows))), anchors))

    def _put(self, along: Floats, kinds: Signs, rows: Ints, found: Floats) -> float:
        most, room = 0.0, np.empty((1, 10))
        for some, own, quadrics in _in_blocks(kinds, rows, self.quadrics):
            largest = put_places_of_curved(
                kinds[some], own, self.spheres, quadrics, self.middle, self.unit, along, ALONG[:6], room, found[some]
            )
            most = max(most, largest)
        return most

    def places(self, along: Floats, which: Any) -> Floats:
        """`Features.places`"""
        found = np.empty(len(self.rows[which]))
        self._put(along, self.kinds[which], self.rows[which], found)
        return found


def _point(numbers: Floats) -> Point:
    x, y, z = numbers.tolist()
    return x, y, z


def _unit(most: float, anchors: Floats) -> float:
    """What the largest length is measured in, so that it is 1, or less where it may be what rounding left of nothing.

    Planes that are all one have no offset about their middle but by the rounding of their anchors.
    """
    least = _ROUNDED * float(np.abs(anchors).max(initial=0.0))
    found = max(most, least) if least < math.inf else most
    return found if 0 < found < math.inf else 1.0


def coefficients(kind: Signs, row: Ints, spheres: Floats, quadrics: Quadrics | Floats, middle: Floats) -> Floats:
    """(n, 10) of x², y², z², xy, xz, yz, x, y, z (half of them), 1 about a point, the largest of the first six 1.

    quadrics: also as whole rows.
    """
    result = np.empty((len(kind), 10))
    for some, own, whole in _in_blocks(kind, row, quadrics):
        put_coefficients(kind[some], own, spheres, whole, _point(middle), result[some])
    return result


def _in_blocks(kind: Signs, row: Ints, quadrics: Quadrics | Floats) -> Iterator[tuple[slice, Ints, Floats]]:
    """Some of what is curved at a time: (which, their rows, the whole rows of quadrics among them, numbered anew)."""
    for some in blocks(len(kind)):
        own, which = row[some].copy(), np.flatnonzero(kind[some] != SPHERE)
        whole = quadrics[own[which]]
        own[which] = np.arange(len(which), dtype=np.int32)
        yield some, own, whole


def clusters(members: Any, features: Features) -> Iterable[Any]:
    """Groups of members whose features agree to about 1e-11 along `ALONG`, and nearly along another direction.

    Of N members N² 1e-11 agree along one direction by chance, which for millions are more than can be named exactly. A
    direction that has nothing to do with the first parts those, and none that are equal, by gaps a thousand times as
    wide.
    """
    place = features.places(ALONG, slice(None))
    ordered = np.sort(place)
    if not (np.diff(ordered) <= CLOSE).any():
        return
    order = np.argsort(place)
    near = np.diff(place[order]) <= CLOSE
    starts = np.flatnonzero(np.concatenate([[True], ~near]))
    sizes = np.diff(np.append(starts, len(order)))
    several = sizes > 1
    grouped = order[np.repeat(several, sizes)]
    across_all = features.places(ACROSS, grouped)
    ends = np.cumsum(sizes[several])
    for end, size in zip(ends.tolist(), sizes[several].tolist(), strict=True):
        group, across = grouped[end - size : end], across_all[end - size : end]
        sorted_ = np.argsort(across, kind="stable")
        for part in np.split(sorted_, 1 + np.flatnonzero(np.diff(across[sorted_]) > _APART)):
            if len(part) > 1:
                yield members[np.sort(group[part])]
