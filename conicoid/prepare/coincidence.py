"""Coincident surfaces: find the planes and quadrics that are equal, and build the scene-wide table with each once.

Every surface has features: a plane four, its unit normal and its offset about the middle of the scene; a curved surface
ten, the coefficients of its polynomial about that point, the largest of second order scaled to 1. Lengths are in a unit
that fits the scene. The sign is the one that gives the leading three (or six) features a positive component along a
fixed direction. The place of a surface is its component along a direction through the space of these features: equal
surfaces have nearly equal places. Exact names decide among the surfaces that are close.

Four other files decide which surfaces are equal, and none of them by other rules:

- `geometry/surface.py` gives a surface its exact name, `key`: equal surfaces have equal keys, up to the sign.
- `prepare/input_surfaces.py` lists once what translated copies share, so that it is never compared.
- `prepare/body_collector.py` names surfaces that share a rotation by their numbers before it (`names_before_rotation`).
- `prepare/edits/surface_merge.py` and `prepare/edits/surface_classes.py` compare only new surfaces with the others
  after an edit; `prepare/edits/neighbour_index.py` finds the ones that are close.
"""

from __future__ import annotations

import math
from collections.abc import Callable, Hashable, Iterable, Iterator, Sequence
from dataclasses import dataclass, field, replace
from fractions import Fraction
from typing import Any, Protocol, TypeAlias

import numpy as np
import numpy.typing as npt

from .._jit.decorators import inline, kernel
from .._util.arrays import dot_rows, ignore_fp_errors, unique_sorted, unique_with_inverse
from ..geometry.surface import ORIGIN, UPRIGHT, Key, QuadricSurface, Surface
from ..kernels.tables import ANCHOR_SIZE, FORM_SIZE, PLANE, QUADRIC, SPHERE, Floats, Ints, Longs, Signs, whole_quadrics
from .pattern import row_blocks

# Kernels: the places of surfaces, one after the other
Point: TypeAlias = tuple[float, float, float]
_Ten: TypeAlias = tuple[float, float, float, float, float, float, float, float, float, float]


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
    kind="n", row="n", spheres="b 4", quadrics="q 19", along="10", leading="6", room="out 1 10", places="out n",
)  # fmt: skip
def put_places_of_curved(
    kind: Signs, row: Ints, spheres: Floats, quadrics: Floats, middle: Point, unit: float, along: Floats,
    leading: Floats, room: Floats, places: Floats,
) -> float:  # fmt: skip
    """Write the places of curved surfaces along a direction.

    Return the largest of their linear and constant coefficients, as lengths in the unit. `room` holds the coefficients
    of one surface.
    """
    most = 0.0
    for i in range(len(kind)):
        _put_coefficients(kind[i], row[i], spheres, quadrics, middle, room, 0)
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


@kernel(planes="p 7", rows="n", axes="out n", places="out n")
def put_across_axes(planes: Floats, rows: Ints, axes: Signs, places: Floats) -> None:
    """Write for each plane the axis that it is perpendicular to and its coordinate there; axis -1 for all others.

    Only planes whose anchor lies exactly on them count.
    """
    for i in range(len(rows)):
        axes[i], row = -1, rows[i]
        if not (0 <= row < len(planes) and planes[row, 3] == 0.0):
            continue
        for k in range(3):
            # Such planes are compared by one exact float, without names; boxes have no others
            if planes[row, k] != 0.0 and planes[row, (k + 1) % 3] == 0.0 and planes[row, (k + 2) % 3] == 0.0:
                axes[i], places[i] = k, planes[row, 4 + k]


@inline
def _comes_before(planes: Floats, row: int, other: int) -> bool:
    """Return whether one record precedes another, by the first number in which they differ."""
    for k in range(7):
        if planes[row, k] != planes[other, k]:
            return planes[row, k] < planes[other, k]
    return False


@kernel(planes="p 7", rows="n", axes="n", places="n", order="n", first="out n")
def put_first_across_axes(planes: Floats, rows: Ints, axes: Signs, places: Floats, order: Longs, first: Longs) -> None:
    """Write for each plane the first plane, by its record, across the same axis at the same place, as a position.

    `order` sorts the places in rising order. Among equal records the lowest position wins.
    """
    for i in range(len(rows)):
        first[i] = i
        if not (0 <= order[i] < len(rows) and 0 <= rows[i] < len(planes)):
            return
    begin = 0
    while begin < len(order):
        end = begin + 1
        while end < len(order) and places[order[end]] == places[order[begin]]:
            end += 1
        for axis in range(3 if end > begin + 1 else 0):
            best = -1
            for k in range(begin, end):
                i = order[k]
                if axes[i] == axis and (
                    best < 0 or _comes_before(planes, rows[i], rows[best])
                    or (i < best and not _comes_before(planes, rows[best], rows[i]))
                ):  # fmt: skip
                    best = i
            for k in range(begin, end):
                if axes[order[k]] == axis:
                    first[order[k]] = best
        begin = end


# Quadrics as anchors and forms: translated copies share all numbers but their anchors


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


@dataclass
class PlaneFeatures:
    """The features of some planes."""

    rows: Ints
    planes: Floats
    middle: Point
    unit: float = 1.0

    @classmethod
    def of(cls, rows: Ints, planes: Floats) -> PlaneFeatures:
        """Choose the middle and the unit that fit these planes."""
        found = cls(rows, planes, _point(planes[rows, 4:].mean(axis=0)))
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


@dataclass
class CurvedFeatures:
    """The features of some spheres and quadrics."""

    kinds: Signs
    rows: Ints
    spheres: Floats
    quadrics: QuadricTable
    middle: Point
    unit: float = 1.0

    @classmethod
    def of(cls, kinds: Signs, rows: Ints, spheres: Floats, quadrics: QuadricTable) -> CurvedFeatures:
        """Choose the middle and the unit that fit these surfaces."""
        ball = kinds == SPHERE
        anchors = np.concatenate([spheres[rows[ball], :3], quadrics.rows[rows[~ball], :3]])
        found = cls(kinds, rows, spheres, quadrics, _point(anchors.mean(axis=0)))
        return replace(found, unit=_unit(found._put(FIRST_DIRECTION, kinds, rows, np.empty(len(rows))), anchors))

    def _put(self, along: Floats, kinds: Signs, rows: Ints, found: Floats) -> float:
        most, room = 0.0, np.empty((1, 10))
        for some, own, quadrics in _in_blocks(kinds, rows, self.quadrics):
            largest = put_places_of_curved(
                kinds[some],
                own,
                self.spheres,
                quadrics,
                self.middle,
                self.unit,
                along,
                FIRST_DIRECTION[:6],
                room,
                found[some],
            )
            most = max(most, largest)
        return most

    def places(self, along: Floats, which: Any) -> Floats:
        """`SurfaceFeatures.places`"""
        found = np.empty(len(self.rows[which]))
        self._put(along, self.kinds[which], self.rows[which], found)
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


def find_clusters(members: Any, features: SurfaceFeatures) -> Iterable[Any]:
    """Yield groups of members whose features agree to about 1e-11 along one direction, and nearly along a second one.

    Among N members, N² 1e-11 pairs agree along one direction by chance; for millions of members these are more than can
    be named exactly. The unrelated second direction separates such pairs: it splits at gaps a thousand times as wide,
    which never part equal surfaces.
    """
    place = features.places(FIRST_DIRECTION, slice(None))
    ordered = np.sort(place)
    if not (np.diff(ordered) <= CLOSENESS).any():
        return
    order = np.argsort(place)
    near = np.diff(place[order]) <= CLOSENESS
    starts = np.flatnonzero(np.concatenate([[True], ~near]))
    sizes = np.diff(np.append(starts, len(order)))
    several = sizes > 1
    grouped = order[np.repeat(several, sizes)]
    across_all = features.places(SECOND_DIRECTION, grouped)
    ends = np.cumsum(sizes[several])
    for end, size in zip(ends.tolist(), sizes[several].tolist(), strict=True):
        group, across = grouped[end - size : end], across_all[end - size : end]
        sorted_ = np.argsort(across, kind="stable")
        for part in np.split(sorted_, 1 + np.flatnonzero(np.diff(across[sorted_]) > _SEPARATION)):
            if len(part) > 1:
                yield members[np.sort(group[part])]


# Clusters by the remainders as well: two rods with one axis, but for the rounding of the point where they meet, are
# close in float64. Their exact names take a millisecond each, and a molecule has one such pair for each bond.

_PAIR_CLOSENESS = 1e-24
"""`CLOSENESS` of places in pairs of floats: these have 53 bits more, so that its margin is wider."""
_FAR_SHARE = 2.0**-12
"""Share of the distance from the origin below which the unit of places does not shrink: rounding stays below 2^-90."""


class _Pairs:
    """Sums of two float64 arrays, of about 106 bits."""

    def __init__(self, high: Any, low: Any = 0.0) -> None:
        self.high, self.low = high, low

    def __add__(self, other: _Pairs) -> _Pairs:
        high = self.high + other.high
        back = high - self.high
        low = (self.high - (high - back)) + (other.high - back) + (self.low + other.low)
        return _Pairs(high + low, low - ((high + low) - high))

    def __mul__(self, other: _Pairs) -> _Pairs:
        high = self.high * other.high
        a, b = _halves(self.high), _halves(other.high)
        low = ((a[0] * b[0] - high) + a[0] * b[1] + a[1] * b[0]) + a[1] * b[1]
        low = low + (self.high * other.low + self.low * other.high)
        return _Pairs(high + low, low - ((high + low) - high))

    def __neg__(self) -> _Pairs:
        return _Pairs(-self.high, -self.low)

    def __truediv__(self, other: _Pairs) -> _Pairs:
        first = _Pairs(self.high / other.high)
        rest = self + -(first * other)
        return first + _Pairs(rest.high / other.high)


def _halves(values: Any) -> tuple[Any, Any]:
    """Split floats into two of 26 bits (Veltkamp)."""
    high = values * 134217729.0
    high = high - (high - values)
    return high, values - high


def _plane_pairs(record: list[_Pairs], middle: Point, unit: float) -> list[_Pairs]:
    """Return the normal and the offset about a point of planes, in the unit."""
    (*normal, height), anchor = record[:4], record[4:]
    offset = -height
    for k in range(3):
        offset = offset + normal[k] * (anchor[k] + _Pairs(-middle[k]))
    return [*normal, offset * _Pairs(1 / unit)]


def _quadric_pairs(record: list[_Pairs], middle: Point, unit: float) -> list[_Pairs]:
    """Return the coefficients of `put_coefficients`, not scaled, about a point in the unit."""
    scale, zero = _Pairs(1 / unit), _Pairs(0.0)
    place = [(record[k] + _Pairs(-middle[k])) * scale for k in range(3)]
    second, first, constant = [zero] * 6, [zero] * 3, -record[18] * scale * scale
    for k in range(3):
        row, square, linear = record[3 + 3 * k : 6 + 3 * k], record[12 + k], record[15 + k] * scale
        shift = -(row[0] * place[0] + row[1] * place[1] + row[2] * place[2])
        slope = square * shift + linear
        for at, (i, j) in enumerate(((0, 0), (1, 1), (2, 2), (0, 1), (0, 2), (1, 2))):
            second[at] = second[at] + square * row[i] * row[j]
        first = [first[i] + row[i] * slope for i in range(3)]
        constant = constant + (slope + linear) * shift
    return [*second, *first, constant]


@ignore_fp_errors
def split_clusters(close: list[Any], records: Floats, rests: Floats) -> list[Any]:
    """Split clusters between members that certainly differ, in what rounding removed from their records, too.

    Parameters
    ----------
    close
        Clusters of surfaces, all planes or all quadrics.
    records, rests
        The records of all members, in their order, and their remainders.

    """
    is_flat = records.shape[1] == 7
    anchors = records[:, 4:] if is_flat else records[:, :3]
    middle = _point(anchors[0])
    # A power of two, which rounds nothing. Far from the origin the remainders of anchors are rounded, to 2^-106 of them
    size_of_all = max(float(np.abs(anchors - anchors[0]).max()), _FAR_SHARE * float(np.abs(anchors).max()), 1e-100)
    unit = 2.0 ** math.ceil(math.log2(size_of_all))
    columns = [_Pairs(high, low) for high, low in zip(records.T, rests.T, strict=True)]
    numbers = (_plane_pairs if is_flat else _quadric_pairs)(columns, middle, unit)
    sizes = np.array([len(cluster) for cluster in close])
    label, begin = np.repeat(np.arange(len(close)), sizes), np.cumsum(sizes) - sizes
    # The number of second order (of a plane, of its normal) that is largest in the first member becomes 1
    leading = np.abs([pairs.high for pairs in numbers[: 3 if is_flat else 6]])
    pivot = leading[:, begin].argmax(axis=0)[label]
    of_pivot = _Pairs(
        np.choose(pivot, [pairs.high for pairs in numbers[: len(leading)]]),
        np.choose(pivot, [pairs.low for pairs in numbers[: len(leading)]]),
    )
    place, size = _Pairs(np.zeros(len(label))), np.ones(len(label))
    for pairs, along in zip(numbers, FIRST_DIRECTION, strict=False):
        scaled = pairs / of_pivot
        place, size = place + scaled * _Pairs(along), np.maximum(size, np.abs(scaled.high))
    order = np.lexsort((place.low, place.high, label))
    step = np.diff(place.high[order]) + np.diff(place.low[order])
    apart = (step > _PAIR_CLOSENESS * size[order][1:]) | (np.diff(label[order]) > 0)
    members = np.concatenate(close)
    return [np.sort(members[part]) for part in np.split(order, 1 + np.flatnonzero(apart)) if len(part) > 1]


# The scene-wide table of surfaces: each distinct plane or quadric once
#
# Surfaces are rounded to float64 records. Exact surfaces (nothing rounded) with records equal to the bit are one
# surface. Where records are merely close, the exact names (`key`, 3000-bit arithmetic) decide: surfaces written twice,
# scaled, negated, or reached by different motions that are equal on paper become one. The record that represents a
# class, and so its anchor, does not depend on the order in which the surfaces were added.

# Relative tolerance of the search for bulk balls that may equal another surface
_NEARLY = 1e-6
_FEWEST_CLUSTERS = 16
"""For fewer clusters exact names are as quick."""
_CHUNK = 1 << 13


@dataclass
class SurfaceTable:
    """The finished table of surfaces; for each input surface its id there and its sense (+1 or -1)."""

    kind: Signs
    row: Ints
    planes: Floats
    spheres: Floats
    quadrics: QuadricTable
    ids: Ints
    senses: Signs
    rest: Remainders
    single: Any  # (n,) integers: the input number of each of the first surfaces of the table; the others are bulk balls
    raw: RawSurfaces
    first: Ints | None  # for each input surface the one whose record represents it; None where each represents itself

    def forget_numbers(self) -> None:
        """Release the ids and senses of the input surfaces."""
        self.ids, self.senses = self.ids[:0].copy(), self.senses[:0].copy()


@dataclass
class Remainders:
    """What rounding removed from the numbers of each record: record plus remainder is exact to 2^-106."""

    planes: Floats
    spheres: Floats  # shorter than the table: bulk balls have no remainders
    quadrics: Floats  # (forms, 19): quadrics of one form share it (`QuadricTable.form_of`)
    vertices: Floats = field(default_factory=lambda: np.zeros((0, 3)))  # corners of polygons


@dataclass
class RawSurfaces:
    """The surfaces of all bodies, bulk balls apart, in input order, before equal ones are merged."""

    kinds: Signs
    senses: Signs  # +1, or -1 where the record is the negated surface
    planes: Floats
    spheres: Floats
    quadrics: QuadricTable
    rest: Remainders
    balls: list[Floats]
    exact: ExactSurfaces
    repeated: Longs | None = None
    """For each surface one that is equal because of how its body is made: itself, or an earlier one of the body."""
    compact: bool = False
    """Drop the rows of planes and quadrics that another row represents? Scenes that may be edited keep them."""

    @property
    def plain(self) -> npt.NDArray[np.bool_]:
        """(n,) whether nothing was rounded in each record: such surfaces are equal exactly where their records are."""
        plain = np.empty(len(self.kinds), bool)
        for kind, lost in ((PLANE, self.rest.planes), (SPHERE, self.rest.spheres), (QUADRIC, self.rest.quadrics)):
            whole = ~(lost != 0.0).any(axis=1)
            plain[self.kinds == kind] = whole[self.quadrics.form_of] if kind == QUADRIC else whole
        return plain


class ExactSurfaces(Protocol):
    """Exact surfaces by number, computed on demand."""

    def __getitem__(self, index: int) -> Surface: ...

    def name(self, index: int) -> tuple[Key, int]:
        """Return the exact name of a surface, and its sense."""
        ...

    def known_names(self, indices: Longs) -> dict[int, Hashable]:
        """Return keys that are equal only for surfaces that are certainly equal.

        Surfaces without such a key are left out.
        """
        ...

    def leaf_names(self, indices: Longs) -> dict[int, Hashable]:
        """`known_names` by the primitives that surfaces belong to."""
        ...


def names_at(
    known: Callable[[Longs], dict[int, Hashable]], numbers: Ints | Longs, indices: Longs
) -> dict[int, Hashable]:
    """Return what one of the methods of `ExactSurfaces` knows of surfaces with other numbers: `numbers[indices]`."""
    there = numbers[indices].astype(np.int64)
    names = known(there)
    pairs = zip(indices.tolist(), there.tolist(), strict=True)
    return {index: names[number] for index, number in pairs if number in names}


def merge_surfaces(surfaces: RawSurfaces) -> SurfaceTable:
    """Build the table of distinct surfaces.

    Ids and senses are in input order, bulk balls after the rest.
    """
    return _SurfaceMerger(surfaces).arrays()


class _SurfaceMerger:
    """One run of `merge_surfaces`."""

    def __init__(self, surfaces: RawSurfaces) -> None:
        self.raw, self.exact = surfaces, surfaces.exact
        self.single, self.ball_count = len(surfaces.kinds), sum(map(len, surfaces.balls))

    def arrays(self) -> SurfaceTable:
        """Run the merge: equal records, planes across axes, then exact names."""
        raw, single = self.raw, self.single
        kinds, planes, quadrics, rest = raw.kinds, raw.planes, raw.quadrics, raw.rest
        all_spheres = concatenate([raw.spheres, *raw.balls])
        count = single + self.ball_count
        kind, row = np.full(count, SPHERE, np.int8), np.arange(count, dtype=np.int32)
        kind[:single] = kinds
        row[single:] += np.int32(len(raw.spheres) - single)
        for k in (PLANE, SPHERE, QUADRIC):
            member = kinds == k
            row[:single][member] = np.arange(member.sum())
        first = np.arange(count, dtype=np.int32)
        if raw.repeated is not None:
            first[:single] = raw.repeated
        is_plain, is_fresh = np.ones(count, bool), first == np.arange(count, dtype=np.int32)
        is_plain[:single] = raw.plain
        for k, table in ((PLANE, planes), (SPHERE, all_spheres), (QUADRIC, quadrics)):
            if _has_equal(table):
                members = np.flatnonzero(kind == k)
                fresh, plain = is_fresh[members], is_plain[members]
                _merge_equal(first, members[fresh & plain], _rows_of(table, fresh & plain))
                if (fresh & ~plain).any():
                    self._merge_leaves(first, members[fresh & ~plain], _rows_of(table, fresh & ~plain))
        first = first[first]
        # Planes across the axes are compared without exact names, which take about a millisecond each.
        flat = np.flatnonzero((kind[:single] == PLANE) & is_plain[:single])
        settled = _merge_across_axes(first, flat, row, planes)
        senses = np.ones(count, np.int8)
        senses[:single] = raw.senses
        self._merge_exact(first, senses, kind, row, planes, all_spheres, quadrics, settled)
        # Number the representatives in input order.
        leads = first == np.arange(count, dtype=np.int32)
        chosen = np.flatnonzero(leads[:single])
        if leads.all():
            return SurfaceTable(kind, row, planes, all_spheres, quadrics, first, senses, rest, chosen, raw, None)
        number = np.cumsum(leads, dtype=np.int32) - np.int32(1)
        kind, row = kind[leads], row[leads]
        if raw.compact:
            rows_of = {k: row[kind == k] for k in (PLANE, QUADRIC)}
            for k, rows in rows_of.items():
                row[kind == k] = np.arange(len(rows))
            planes, rest = planes[rows_of[PLANE]], replace(rest, planes=rest.planes[rows_of[PLANE]])
            if len(rows_of[QUADRIC]) < len(quadrics):
                quadrics, used = quadrics.select(rows_of[QUADRIC]).compact()
                rest = replace(rest, quadrics=rest.quadrics[used])
        return SurfaceTable(kind, row, planes, all_spheres, quadrics, number[first], senses, rest, chosen, raw, first)

    def _merge_leaves(self, first: Any, members: Longs, table: Floats | QuadricTable) -> None:
        """Point each member to the earliest one with an equal record that is the same surface of an equal primitive."""
        heads = np.arange(len(first))
        _merge_equal(heads, members, table)
        copies = members[heads[members] != members]
        names = self.exact.leaf_names(unique_sorted(copies, heads[copies])) if len(copies) else {}
        for copy, lead in zip(copies.tolist(), heads[copies].tolist(), strict=True):
            if copy in names and names[copy] == names.get(lead):
                first[copy] = lead

    def _name(self, index: int, spheres: Floats, row: Ints) -> tuple[Key, int]:
        """Return the exact name of a surface or bulk ball, and its sense."""
        if index >= self.single:
            x, y, z, r = (float(v) for v in spheres[row[index]])
            return QuadricSurface((1.0, 1.0, 1.0), ORIGIN, Fraction(r) ** 2, UPRIGHT, (x, y, z)).key()
        return self.exact.name(index)

    def _merge_exact(
        self,
        first: Any,
        senses: Signs,
        kind: Signs,
        row: Ints,
        planes: Floats,
        spheres: Floats,
        quadrics: QuadricTable,
        settled: int,
    ) -> None:
        """Merge close records by their exact names; `settled` counts the planes that are already compared."""
        distinct = np.flatnonzero(first[: self.single] == np.arange(self.single))
        is_flat = kind[distinct] == PLANE
        flat, curved = distinct[is_flat], distinct[~is_flat]
        close = list(find_clusters(flat, PlaneFeatures.of(row[flat], planes))) if len(flat) > settled else []
        if len(curved):  # bulk balls are equal to each other to the bit or not at all
            curved = np.concatenate([curved, self._balls_near(curved, first, kind, row, spheres, quadrics)])
            close += find_clusters(curved, CurvedFeatures.of(kind[curved], row[curved], spheres, quadrics))
        close = self._split(close, kind, row, planes, quadrics)
        tables: dict[int, Floats | QuadricTable] = {PLANE: planes, SPHERE: spheres, QUADRIC: quadrics}

        def record(index: int) -> tuple[bool, Floats]:
            at = int(row[index])
            return kind[index] != SPHERE, *tables[kind[index]][at : at + 1][0]

        candidates = np.concatenate(close) if close else np.zeros(0, np.int64)
        known_names = self.exact.known_names(candidates[candidates < self.single])
        representatives: dict[int, tuple[int, int]] = {}
        for cluster in close:
            same: dict[Any, list[int]] = {}
            for index in cluster.tolist():
                same.setdefault(known_names.get(index, index), []).append(index)
            equal: dict[Any, list[tuple[int, int]]] = {}
            for some in same.values():
                key, sense = self._name(some[0], spheres, row) if len(same) > 1 else (None, 1)
                equal.setdefault(key, []).extend((index, sense) for index in some)
            for members in equal.values():
                # The least record represents the class: this does not depend on the order of input.
                lead, its_sense = min(members, key=lambda m: record(m[0]))
                for index, sense in members:
                    representatives[index] = (lead, 1 if kind[index] == PLANE else sense * its_sense)
        if representatives:
            # Redirect every surface that pointed at a merged one.
            merged = np.fromiter(representatives, np.int64, len(representatives))
            found = np.array([representatives[index] for index in representatives])
            representative, turned = np.arange(len(first)), np.ones(len(first), np.int8)
            representative[merged], turned[merged] = found[:, 0], found[:, 1]
            senses *= turned[first]
            first[:] = representative[first]

    def _split(self, close: list[Any], kind: Signs, row: Ints, planes: Floats, quadrics: QuadricTable) -> list[Any]:
        """Split clusters by `split_clusters`, where there are enough; those with spheres stay whole."""
        if len(close) < _FEWEST_CLUSTERS:
            return close
        rest, result = self.raw.rest, []
        by_kind: dict[int, list[Any]] = {PLANE: [], QUADRIC: [], SPHERE: []}
        for cluster in close:
            kinds = set(kind[cluster].tolist())
            by_kind[kinds.pop() if len(kinds) == 1 else SPHERE].append(cluster)
        for one, table, lost in ((PLANE, planes, rest.planes), (QUADRIC, quadrics, rest.quadrics)):
            if some := by_kind[one]:
                rows = row[np.concatenate(some)]
                rests = lost[rows if one == PLANE else quadrics.form_of[rows]]
                result += split_clusters(some, table[rows], rests)
        return result + by_kind[SPHERE]

    def _balls_near(
        self, curved: Any, first: Any, kind: Signs, row: Ints, spheres: Floats, quadrics: QuadricTable
    ) -> npt.NDArray[np.int64]:
        """Return the distinct bulk balls that may equal another surface, found by one coordinate of their centers."""
        if self.ball_count == 0:
            return np.zeros(0, np.int64)
        single = self.single
        middle = spheres[:1, :3].mean(axis=0)
        numbers = coefficients(kind[curved], row[curved], spheres, quadrics, middle)
        round_ = np.abs(numbers[:, :6] - (1, 1, 1, 0, 0, 0)).max(axis=1) < _NEARLY
        if not round_.any():
            return np.zeros(0, np.int64)
        across = np.random.default_rng(20261123).normal(size=3)
        own = np.sort(-dot_rows(numbers[round_, 6:9], across))
        balls = spheres[len(spheres) - self.ball_count :]
        others = np.concatenate(
            [dot_rows(balls[a : a + _CHUNK, :3] - middle, across) for a in range(0, len(balls), _CHUNK)]
        )
        reach = _NEARLY * max(float(np.abs(others).max()), float(np.abs(own).max()))
        near = np.searchsorted(own, others - reach) < np.searchsorted(own, others + reach, side="right")
        found = single + np.flatnonzero(near)
        return found[first[found] == found]


def concatenate(parts: Sequence[npt.NDArray[Any]]) -> npt.NDArray[Any]:
    """Concatenate arrays; no copy where at most one has rows."""
    non_empty = [part for part in parts if len(part)]
    return np.concatenate(non_empty) if len(non_empty) > 1 else (non_empty or parts)[0]


def row_hashes(table: Floats | QuadricTable) -> npt.NDArray[np.uint64]:
    """Hash each row to uint64; equal rows, zeros of both signs alike, have equal hashes."""
    if isinstance(table, QuadricTable):  # copies share forms, which are hashed once
        return _mix_rows(row_hashes(table.forms)[table.form_of], table.rows[:, :3])
    return _mix_rows(np.zeros(len(table), np.uint64), table)


def _mix_rows(mixed: npt.NDArray[np.uint64], table: Floats) -> npt.NDArray[np.uint64]:
    """Mix each row of a table into its hash, in place."""
    for begin in range(0, len(table), _CHUNK):
        words = (table[begin : begin + _CHUNK] + 0.0).view(np.uint64)
        part = mixed[begin : begin + _CHUNK]
        for column in range(words.shape[1]):
            part ^= words[:, column]
            part *= np.uint64(0x9E3779B97F4A7C15)
            part ^= part >> np.uint64(29)
    return mixed


def _rows_of(table: Floats | QuadricTable, some: npt.NDArray[np.bool_]) -> Floats | QuadricTable:
    """Return some rows of a table."""
    return table.select(some) if isinstance(table, QuadricTable) else table[some]


def _has_equal(table: Floats | QuadricTable) -> bool:
    """Return whether two rows may be equal: in a large table without equal rows much faster than a full comparison."""
    mixed = row_hashes(table)
    mixed.sort()
    return bool((mixed[1:] == mixed[:-1]).any())


def _merge_equal(first: Any, members: Any, table: Floats | QuadricTable) -> None:
    """Point each member at the earliest one with a record equal to the bit, zeros of both signs alike."""
    order = np.argsort(row_hashes(table), kind="stable")
    same = np.zeros(len(order), bool)
    for begin in range(1, len(order), _CHUNK):
        rows = table[order[begin - 1 : begin + _CHUNK]]
        same[begin : begin + _CHUNK] = (rows[1:] == rows[:-1]).all(axis=1)
    head = np.maximum.accumulate(np.where(same, 0, np.arange(len(order))))
    first[members[order]] = members[order[head]]


def _merge_across_axes(first: Any, members: Any, row: Ints, planes: Floats) -> int:
    """Point planes across one axis at one place at the plane whose record comes first in order.

    `members` are planes from which nothing was rounded and whose anchors lie on them, so that their exact names would
    give the same. Return how many of the leading planes are settled so.
    """
    members = members[first[members] == members]
    axes, places = np.empty(len(members), np.int8), np.empty(len(members))
    put_across_axes(planes, row[members], axes, places)
    across = axes >= 0
    if not across.all():
        members, axes, places = members[across], axes[across], places[across]
    least = np.empty(len(members), np.int64)
    put_first_across_axes(planes, row[members], axes, places, np.argsort(places), least)
    others = np.flatnonzero(least != np.arange(len(members)))
    if len(others):
        first[members[others]] = members[least[others]]
        first[:] = first[first]
    return len(members) - len(others)
