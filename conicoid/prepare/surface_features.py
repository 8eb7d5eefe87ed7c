"""Features of planes and quadrics: numbers that equal surfaces have in common, however their records are written.

A plane has four features, its unit normal and its offset about the middle of the scene; a curved surface ten, the
coefficients of its polynomial about that point, the largest of second order scaled to 1. Lengths are in a unit that
fits the scene. The sign is the one that gives the leading three (or six) features a positive component along a fixed
direction. The place of a surface is its component along a direction through the space of these features: equal surfaces
have nearly equal places. `find_clusters` finds the surfaces that may be equal by their places along two directions, and
then by places in pairs of floats with an error bound, which hold what rounding removed from the records.
"""

from __future__ import annotations

import math
from collections.abc import Iterator
from dataclasses import field, replace
from typing import Any, Protocol, TypeAlias

import numpy as np

from .._jit.decorators import inline, kernel
from .._util.arrays import unique_with_inverse
from .._util.records import dataclass
from ..kernels.numbers.double_double import (
    BoundedPair,
    bounded_pair,
    dot3,
    inner,
    minus,
    opposite,
    over,
    plus,
    times,
    times_float,
)
from ..kernels.tables import ANCHOR_SIZE, FORM_SIZE, SPHERE, Floats, Ints, Longs, Signs, whole_quadrics
from .pattern import row_blocks

Point: TypeAlias = tuple[float, float, float]
_Ten: TypeAlias = tuple[float, float, float, float, float, float, float, float, float, float]


# Records


@dataclass
class QuadricTable:
    """Two tables, as `Tables` has them. `quadrics[which]` assembles whole rows (n, 19) on demand."""

    rows: Floats  # (n, 4) anchor, row of the form
    forms: Floats  # (forms, 16)

    @classmethod
    def of(cls, anchors: Floats, forms: Floats) -> QuadricTable:
        """Build a table in which each quadric has a form of its own."""
        return cls(np.column_stack([anchors[:, :3], np.arange(len(anchors), dtype=np.float64)]), forms)

    @classmethod
    def empty(cls, form_of: Ints, forms: int) -> QuadricTable:
        """Allocate a table of quadrics with these rows among `forms` forms; only the form numbers are filled in."""
        rows = np.empty((len(form_of), ANCHOR_SIZE))
        rows[:, 3] = form_of
        return cls(rows, np.empty((forms, FORM_SIZE)))

    @property
    def form_of(self) -> Any:
        """(n,) the row of the form of each quadric."""
        return self.rows[:, 3].astype(np.intp)

    def __len__(self) -> int:
        return len(self.rows)

    def __getitem__(self, which: Any) -> Floats:
        return whole_quadrics(self.rows[which], self.forms)

    def select(self, which: Any) -> QuadricTable:
        """Select some quadrics; the table of forms is shared."""
        return QuadricTable(self.rows[which], self.forms)

    def compact(self) -> tuple[QuadricTable, Any]:
        """Return the table without unused forms, and the rows of the forms that remain."""
        used, of = unique_with_inverse(self.form_of)
        rows = self.rows.copy()
        rows[:, 3] = of
        return QuadricTable(rows, self.forms[used]), used


@dataclass
class Remainders:
    """What rounding removed from the numbers of each record: record plus remainder is exact to 2^-106."""

    planes: Floats
    spheres: Floats  # shorter than the table: bulk balls have no remainders
    quadrics: Floats  # (forms, 19): quadrics of one form share it (`QuadricTable.form_of`)
    vertices: Floats = field(default_factory=lambda: np.zeros((0, 3)))  # corners of polygons


# Places of surfaces along a direction, in floats


@inline
def _signed_feature(before: float, place: float) -> float:
    """Give a place the sign that makes the leading features positive."""
    return -place if before < 0.0 else place


@kernel(planes="p 7", rows="n", along="4", leading="3", places="out n")
def put_places_of_planes(
    planes: Floats, rows: Ints, middle: Point, unit: float, along: Floats, leading: Floats, places: Floats
) -> float:
    """Write the places of planes along a direction; return the largest offset, in the unit."""
    most = 0.0
    for i in range(len(rows)):
        row = rows[i]
        if not 0 <= row < len(planes):
            continue
        x, y, z = planes[row, 0], planes[row, 1], planes[row, 2]
        size = math.sqrt(x * x + y * y + z * z)
        # About the middle, offsets of near planes differ in digits that floats keep
        p, q, r = planes[row, 4] - middle[0], planes[row, 5] - middle[1], planes[row, 6] - middle[2]
        offset = (p * x + q * y + r * z - planes[row, 3]) / size / unit
        # Records are scaled by powers of two, which differ between equal planes; a unit normal does not
        x, y, z = x / size, y / size, z / size
        most = abs(offset) if abs(offset) > most else most
        place = x * along[0] + y * along[1] + z * along[2] + offset * along[3]
        places[i] = _signed_feature(x * leading[0] + y * leading[1] + z * leading[2], place)
    return most


@inline
def _second_order(quadrics: Floats, row: int, i: int, j: int) -> float:
    """Return a coefficient of second order: the sum of s w_i w_j over the rows w of a quadric, with squares s."""
    found = 0.0
    for k in range(3):
        found += quadrics[row, 12 + k] * quadrics[row, 3 + 3 * k + i] * quadrics[row, 3 + 3 * k + j]
    return found


@inline
def _quadric_coefficients(quadrics: Floats, row: int, middle: Point) -> _Ten:
    """Return the coefficients of x², y², z², xy, xz, yz, x, y, z, 1 about a point; those of xy to z are halved."""
    p, q, r = quadrics[row, 0] - middle[0], quadrics[row, 1] - middle[1], quadrics[row, 2] - middle[2]
    x = y = z = constant = 0.0
    for k in range(3):
        u, v, w = quadrics[row, 3 + 3 * k], quadrics[row, 4 + 3 * k], quadrics[row, 5 + 3 * k]
        square, linear, shift = quadrics[row, 12 + k], quadrics[row, 15 + k], -(u * p + v * q + w * r)
        slope = square * shift + linear
        x, y, z = x + u * slope, y + v * slope, z + w * slope
        constant += square * (shift * shift) + 2.0 * linear * shift
    return (
        _second_order(quadrics, row, 0, 0), _second_order(quadrics, row, 1, 1),
        _second_order(quadrics, row, 2, 2), _second_order(quadrics, row, 0, 1),
        _second_order(quadrics, row, 0, 2), _second_order(quadrics, row, 1, 2), x, y, z,
        constant - quadrics[row, 18],
    )  # fmt: skip


@inline
def _ball_coefficients(spheres: Floats, row: int, middle: Point) -> _Ten:
    """`_quadric_coefficients` of a sphere."""
    p, q, r = spheres[row, 0] - middle[0], spheres[row, 1] - middle[1], spheres[row, 2] - middle[2]
    return 1.0, 1.0, 1.0, 0.0, 0.0, 0.0, -p, -q, -r, p * p + q * q + r * r - spheres[row, 3] * spheres[row, 3]


@inline
def _put_coefficients(
    kind: int, row: int, spheres: Floats, quadrics: Floats, middle: Point, found: Floats, at: int
) -> None:
    """Write the coefficients of a curved surface, scaled so that the largest of second order is 1.

    Zeros without a record.
    """
    numbers = 0.0, 0.0, 0.0, 0.0, 0.0, 0.0, 0.0, 0.0, 0.0, 0.0
    if kind == SPHERE:
        if 0 <= row < len(spheres):
            numbers = _ball_coefficients(spheres, row, middle)
    elif 0 <= row < len(quadrics):
        numbers = _quadric_coefficients(quadrics, row, middle)
    size = 0.0
    for k in range(10):
        found[at, k] = numbers[k]
        # By the second order, which does not depend on where the surface lies
        size = abs(numbers[k]) if k < 6 and abs(numbers[k]) > size else size
    size = size if size > 0.0 else 1.0
    for k in range(10):
        found[at, k] /= size


@kernel(kind="n", row="n", spheres="b 4", quadrics="q 19", found="out n 10")
def put_coefficients(kind: Signs, row: Ints, spheres: Floats, quadrics: Floats, middle: Point, found: Floats) -> None:
    """Write (n, 10) the coefficients of x², y², z², xy, xz, yz, x, y, z, 1 about a point; those of xy to z are halved.

    Each row is scaled so that the largest of the first six is 1.
    """
    for i in range(len(kind)):
        _put_coefficients(kind[i], row[i], spheres, quadrics, middle, found, i)


@kernel(
    kind="n", row="n", spheres="b 4", quadrics="q 4", forms="f 16", along="10", leading="6", whole="out 1 19",
    room="out 1 10", places="out n",
)  # fmt: skip
def put_places_of_curved(
    kind: Signs, row: Ints, spheres: Floats, quadrics: Floats, forms: Floats, middle: Point, unit: float, along: Floats,
    leading: Floats, whole: Floats, room: Floats, places: Floats,
) -> float:  # fmt: skip
    """Write the places of curved surfaces along a direction.

    Return the largest of their linear and constant coefficients, as lengths in the unit. `whole` holds the record of
    one quadric, `room` the coefficients of one surface.
    """
    most = 0.0
    for i in range(len(kind)):
        own = row[i]
        if kind[i] != SPHERE and 0 <= own < len(quadrics) and 0 <= quadrics[own, 3] < len(forms):
            form = int(quadrics[own, 3])
            for k in range(3):
                whole[0, k] = quadrics[own, k]
            for k in range(16):
                whole[0, 3 + k] = forms[form, k]
            own = 0
        _put_coefficients(kind[i], own, spheres, whole, middle, room, 0)
        before = place = 0.0
        for k in range(6):
            before += room[0, k] * leading[k]
            place += room[0, k] * along[k]
        for k in range(6, 9):
            part = room[0, k] / unit
            most = abs(part) if abs(part) > most else most
            place += part * along[k]
        constant = room[0, 9] / unit / unit  # unit² may overflow
        length = math.sqrt(abs(constant))
        most = length if length > most else most
        places[i] = _signed_feature(before, place + constant * along[9])
    return most


# The same places in pairs of floats with an error bound. Two rods that have one axis, but for the rounding of the point
# where they meet, have one place in floats. Their exact names take a millisecond each, and a molecule has such a pair
# for each bond.


@inline
def _bounded(records: Floats, rests: Floats, row: int, k: int) -> BoundedPair:
    """Return a number of a record with what rounding removed from it."""
    return bounded_pair(records[row, k], rests[row, k])


@inline
def _about(records: Floats, rests: Floats, row: int, k: int, middle: float, scale: float) -> BoundedPair:
    """Return a coordinate of a record about the middle, scaled."""
    return times_float(minus(_bounded(records, rests, row, k), bounded_pair(middle)), scale)


@inline
def _put_bounded(place: BoundedPair, pivot: BoundedPair, places: Floats, at: int) -> None:
    """Write a place divided by the number that becomes 1."""
    high, low, error = over(place, pivot)
    places[at, 0], places[at, 1], places[at, 2] = high, low, error


@kernel(planes="n 7", rests="n 7", pivots="n", along="4", places="out n 3")
def put_bounded_places_of_planes(
    planes: Floats, rests: Floats, pivots: Signs, middle: Point, scale: float, along: Floats, places: Floats
) -> None:
    """Write (high, low, error) the place of each plane along a direction, where a number of its normal is scaled to 1.

    `pivots` names that number; `scale` is a power of two by which lengths are multiplied.
    """
    for i in range(len(pivots)):
        x, y, z = _bounded(planes, rests, i, 0), _bounded(planes, rests, i, 1), _bounded(planes, rests, i, 2)
        p = _about(planes, rests, i, 4, middle[0], scale)
        q = _about(planes, rests, i, 5, middle[1], scale)
        r = _about(planes, rests, i, 6, middle[2], scale)
        offset = minus(inner(x, y, z, p, q, r), times_float(_bounded(planes, rests, i, 3), scale))
        place = plus(dot3(along[0], along[1], along[2], x, y, z), times_float(offset, along[3]))
        _put_bounded(place, x if pivots[i] == 0 else y if pivots[i] == 1 else z, places, i)


@kernel(quadrics="n 19", rests="n 19", pivots="n", along="10", places="out n 3")
def put_bounded_places_of_quadrics(
    quadrics: Floats, rests: Floats, pivots: Signs, middle: Point, scale: float, along: Floats, places: Floats
) -> None:
    """`put_bounded_places_of_planes` for quadrics; a coefficient of second order, x² to yz, is scaled to 1."""
    zero = bounded_pair(0.0)
    for i in range(len(pivots)):
        p = _about(quadrics, rests, i, 0, middle[0], scale)
        q = _about(quadrics, rests, i, 1, middle[1], scale)
        r = _about(quadrics, rests, i, 2, middle[2], scale)
        xx = yy = zz = xy = xz = yz = x = y = z = zero
        constant = times_float(times_float(opposite(_bounded(quadrics, rests, i, 18)), scale), scale)
        for k in range(3):
            u = _bounded(quadrics, rests, i, 3 + 3 * k)
            v = _bounded(quadrics, rests, i, 4 + 3 * k)
            w = _bounded(quadrics, rests, i, 5 + 3 * k)
            square = _bounded(quadrics, rests, i, 12 + k)
            linear = times_float(_bounded(quadrics, rests, i, 15 + k), scale)
            shift = opposite(inner(u, v, w, p, q, r))
            slope = plus(times(square, shift), linear)
            su, sv, sw = times(square, u), times(square, v), times(square, w)
            xx, yy, zz = plus(xx, times(su, u)), plus(yy, times(sv, v)), plus(zz, times(sw, w))
            xy, xz, yz = plus(xy, times(su, v)), plus(xz, times(su, w)), plus(yz, times(sv, w))
            x, y, z = plus(x, times(u, slope)), plus(y, times(v, slope)), plus(z, times(w, slope))
            constant = plus(constant, times(plus(slope, linear), shift))
        place = plus(dot3(along[0], along[1], along[2], xx, yy, zz), dot3(along[3], along[4], along[5], xy, xz, yz))
        place = plus(plus(place, dot3(along[6], along[7], along[8], x, y, z)), times_float(constant, along[9]))
        pivot = xx if pivots[i] == 0 else yy if pivots[i] == 1 else zz
        pivot = xy if pivots[i] == 3 else xz if pivots[i] == 4 else yz if pivots[i] == 5 else pivot
        _put_bounded(place, pivot, places, i)


# Clusters of surfaces whose records are so close that they may be one; their exact names decide later

# Places of equal surfaces differ by rounding alone, and agree to this.
CLOSENESS = 1e-11
FIRST_DIRECTION = 1.0 / np.sqrt([2.0, 3.0, 5.0, 7.0, 11.0, 13.0, 17.0, 19.0, 23.0, 29.0])
"""A direction in which surfaces with different rational coefficients have different places."""
SECOND_DIRECTION = 1.0 / np.sqrt([31.0, 37.0, 41.0, 43.0, 47.0, 53.0, 59.0, 61.0, 67.0, 71.0]) * np.tile([1.0, -1.0], 5)
"""Another such direction."""
# Places along the second direction separate clusters only at gaps a thousand times as wide as `CLOSENESS`.
_SEPARATION = 1000 * CLOSENESS
_ROUNDING_SHARE = 2.0**-12
"""Share of the largest coordinate: `CLOSENESS` times it is ten times what rounding removes from a coordinate."""


class SurfaceFeatures(Protocol):
    """Surfaces with features, which have places along directions."""

    def places(self, along: Floats, which: Any, /) -> Floats:
        """Return the places of some surfaces (all for a slice) along a direction."""
        ...

    def bounded_places(self, which: Longs, leads: Longs, /) -> Floats:
        """Return (n, 3) the places (high, low, error) of some surfaces along `FIRST_DIRECTION`.

        Features are scaled so that one of them is 1, the largest that the leading surface of each has.
        """
        ...


@dataclass
class PlaneFeatures:
    """The features of some planes."""

    rows: Ints
    planes: Floats
    rests: Floats
    middle: Point
    unit: float = 1.0

    @classmethod
    def of(cls, rows: Ints, planes: Floats, rests: Floats) -> PlaneFeatures:
        """Choose the middle and the unit that fit these planes; `rests` are the remainders of all planes."""
        found = cls(rows, planes, rests, _point(planes[rows, 4:].mean(axis=0)))
        most = put_places_of_planes(
            planes, rows, found.middle, 1.0, FIRST_DIRECTION[:4], FIRST_DIRECTION[:3], np.empty(len(rows))
        )
        return replace(found, unit=_unit(most, planes[rows, 4:]))

    def places(self, along: Floats, which: Any) -> Floats:
        """`SurfaceFeatures.places`"""
        rows = self.rows[which]
        found = np.empty(len(rows))
        put_places_of_planes(self.planes, rows, self.middle, self.unit, along[:4], FIRST_DIRECTION[:3], found)
        return found

    def bounded_places(self, which: Longs, leads: Longs) -> Floats:
        """`SurfaceFeatures.bounded_places`"""
        rows, found = self.rows[which], np.empty((len(which), 3))
        pivots = np.abs(self.planes[self.rows[leads], :3]).argmax(axis=1).astype(np.int8)
        put_bounded_places_of_planes(
            self.planes[rows], self.rests[rows], pivots, self.middle, _scale(self.unit), FIRST_DIRECTION[:4], found
        )
        return found


@dataclass
class CurvedFeatures:
    """The features of some spheres and quadrics."""

    kinds: Signs
    rows: Ints
    spheres: Floats
    quadrics: QuadricTable
    rests: Floats
    middle: Point
    unit: float = 1.0

    @classmethod
    def of(cls, kinds: Signs, rows: Ints, spheres: Floats, quadrics: QuadricTable, rests: Floats) -> CurvedFeatures:
        """Choose the middle and the unit that fit these surfaces; `rests` are the remainders of all forms."""
        ball = kinds == SPHERE
        anchors = np.concatenate([spheres[rows[ball], :3], quadrics.rows[rows[~ball], :3]])
        found = cls(kinds, rows, spheres, quadrics, rests, _point(anchors.mean(axis=0)))
        return replace(found, unit=_unit(found._put(FIRST_DIRECTION, kinds, rows, np.empty(len(rows))), anchors))

    def _put(self, along: Floats, kinds: Signs, rows: Ints, found: Floats) -> float:
        quadrics, forms = np.ascontiguousarray(self.quadrics.rows), np.ascontiguousarray(self.quadrics.forms)
        return put_places_of_curved(
            kinds, rows, self.spheres, quadrics, forms, self.middle, self.unit, along,
            FIRST_DIRECTION[:6], np.empty((1, 19)), np.empty((1, 10)), found,
        )  # fmt: skip

    def places(self, along: Floats, which: Any) -> Floats:
        """`SurfaceFeatures.places`"""
        found = np.empty(len(self.rows[which]))
        self._put(along, self.kinds[which], self.rows[which], found)
        return found

    def bounded_places(self, which: Longs, leads: Longs) -> Floats:
        """`SurfaceFeatures.bounded_places`; nothing is certain of a sphere, whose error is infinite."""
        numbers = coefficients(self.kinds[leads], self.rows[leads], self.spheres, self.quadrics, np.array(self.middle))
        pivots = np.abs(numbers[:, :6]).argmax(axis=1).astype(np.int8)
        found = np.tile((0.0, 0.0, math.inf), (len(which), 1))
        own = self.kinds[which] != SPHERE
        rows, places = self.rows[which][own], found[own]
        rests = self.rests[self.quadrics.form_of[rows]]
        put_bounded_places_of_quadrics(
            self.quadrics[rows], rests, pivots[own], self.middle, _scale(self.unit), FIRST_DIRECTION, places
        )
        found[own] = places
        return found


def _point(numbers: Floats) -> Point:
    x, y, z = numbers.tolist()
    return x, y, z


def _unit(most: float, anchors: Floats) -> float:
    """Return the unit that makes the largest length 1, or less where that length may be rounding noise about zero.

    Planes that are all equal have no offset about their middle but the rounding of their anchors.
    """
    least = _ROUNDING_SHARE * float(np.abs(anchors).max(initial=0.0))
    found = max(most, least) if least < math.inf else most
    return found if 0 < found < math.inf else 1.0


def _scale(unit: float) -> float:
    """Return a power of two near 1 / unit, which rounds nothing."""
    return 2.0 ** min(max(-math.frexp(unit)[1], -1000), 1000)


def coefficients(kind: Signs, row: Ints, spheres: Floats, quadrics: QuadricTable | Floats, middle: Floats) -> Floats:
    """Return (n, 10) the coefficients of x², y², z², xy, xz, yz, x, y, z, 1 about a point; those of xy to z are halved.

    Each row is scaled so that the largest of the first six is 1. `quadrics` may also be an array of whole rows.
    """
    result = np.empty((len(kind), 10))
    for some, own, whole in _in_blocks(kind, row, quadrics):
        put_coefficients(kind[some], own, spheres, whole, _point(middle), result[some])
    return result


def _in_blocks(kind: Signs, row: Ints, quadrics: QuadricTable | Floats) -> Iterator[tuple[slice, Ints, Floats]]:
    """Yield blocks of curved surfaces: (which, their rows, whole rows of the quadrics among them, renumbered)."""
    for some in row_blocks(len(kind)):
        own, which = row[some].copy(), np.flatnonzero(kind[some] != SPHERE)
        whole = quadrics[own[which]]
        own[which] = np.arange(len(which), dtype=np.int32)
        yield some, own, whole


def find_clusters(members: Any, features: SurfaceFeatures) -> tuple[Longs, Longs]:
    """Return groups of members that may be equal: (the members of one group after the other, the sizes of the groups).

    Their features agree to about 1e-11 along one direction, and nearly along a second one. Among N members, N² 1e-11
    pairs agree along one direction by chance; for millions of members these are more than can be named exactly. The
    unrelated second direction separates such pairs: it splits at gaps a thousand times as wide, which never part equal
    surfaces. Members that certainly differ by what rounding removed from their records are separated last.
    """
    place = features.places(FIRST_DIRECTION, slice(None))
    ordered = np.sort(place)
    if not (np.diff(ordered) <= CLOSENESS).any():
        return members[:0], np.zeros(0, np.int64)
    order = np.argsort(place)
    near = np.diff(place[order]) <= CLOSENESS
    starts = np.flatnonzero(np.concatenate([[True], ~near]))
    sizes = np.diff(np.append(starts, len(order)))
    several = sizes > 1
    grouped = order[np.repeat(several, sizes)]
    label = np.repeat(np.arange(several.sum()), sizes[several])
    across = features.places(SECOND_DIRECTION, grouped)
    grouped, sizes = _split(grouped, label, across[:, None], np.full(len(grouped), _SEPARATION))
    if not len(sizes):
        return members[:0], sizes
    begin, label = np.cumsum(sizes) - sizes, np.repeat(np.arange(len(sizes)), sizes)
    bounded = features.bounded_places(grouped, grouped[begin][label])
    # Beyond the range of floats nothing is certain
    bounded[~np.isfinite(bounded).all(axis=1)] = 0.0, 0.0, math.inf
    # Two places certainly differ where they lie farther apart than both errors, and the rounding of their difference
    errors = np.maximum.reduceat(bounded[:, 2] + 2.0**-100 * np.abs(bounded[:, 0]), begin)[label]
    grouped, sizes = _split(grouped, label, bounded[:, :2], 2.0001 * errors)
    return members[grouped], sizes


def _split(which: Longs, label: Longs, places: Floats, gaps: Floats) -> tuple[Longs, Longs]:
    """Split groups, which `label` numbers, at gaps between their places (sums); return sorted parts of several."""
    order = np.lexsort((*places.T[::-1], label))
    steps = np.diff(places[order], axis=0).sum(axis=1)
    apart = (steps > gaps[order][1:]) | (np.diff(label[order]) > 0)
    part = np.cumsum(np.concatenate([[False], apart]))
    sizes = np.bincount(part)
    several = sizes[part] > 1
    found = which[order[several]]
    return found[np.lexsort((found, part[several]))], sizes[sizes > 1]
