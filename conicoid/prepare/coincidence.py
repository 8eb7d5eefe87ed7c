"""Numbers by which surfaces that may be one lie side by side, for `surfaces`: one surface after the other.

A plane has four features, its unit normal and its offset about the middle of the scene; what is curved has the ten
coefficients about that, the largest of the second order being 1. Lengths are in a unit that fits the scene. The sign
is that by which the leading three, or six, lie before a direction. Where a surface lies in a direction through the
space of these features is its place there.
"""

from __future__ import annotations

import math
from collections.abc import Hashable, Iterable, Iterator, Sequence
from dataclasses import dataclass, field, replace
from fractions import Fraction
from typing import Any, Protocol, TypeAlias

import numpy as np
import numpy.typing as npt

from .._jit.decorators import inline, kernel
from .._util.arrays import dot_rows, unique_with_inverse
from ..geometry.surface import ORIGIN, UPRIGHT, Key, QuadricSurface, Surface
from ..kernels.tables import ANCHOR_SIZE, FORM_SIZE, PLANE, QUADRIC, SPHERE, Floats, Ints, Longs, Signs, whole_quadrics
from .pattern import row_blocks

Point: TypeAlias = tuple[float, float, float]
_Ten: TypeAlias = tuple[float, float, float, float, float, float, float, float, float, float]


@inline
def _signed_feature(before: float, place: float) -> float:
    """A place of features whose sign is that of what leads."""
    return -place if before < 0.0 else place


@kernel(planes="p 7", rows="n", along="4", leading="3", places="out n")
def put_places_of_planes(
    planes: Floats, rows: Ints, middle: Point, unit: float, along: Floats, leading: Floats, places: Floats
) -> float:
    """Where planes lie in a direction; returns the largest offset, in the unit."""
    most = 0.0
    for i in range(len(rows)):
        row = rows[i]
        if not 0 <= row < len(planes):
            continue
        x, y, z = planes[row, 0], planes[row, 1], planes[row, 2]
        size = math.sqrt(x * x + y * y + z * z)
        p, q, r = planes[row, 4] - middle[0], planes[row, 5] - middle[1], planes[row, 6] - middle[2]
        offset = (p * x + q * y + r * z - planes[row, 3]) / size / unit
        x, y, z = x / size, y / size, z / size
        most = abs(offset) if abs(offset) > most else most
        place = x * along[0] + y * along[1] + z * along[2] + offset * along[3]
        places[i] = _signed_feature(x * leading[0] + y * leading[1] + z * leading[2], place)
    return most


@inline
def _second_order(quadrics: Floats, row: int, i: int, j: int) -> float:
    """A coefficient of second order: the sum of s w w over the rows w of a quadric."""
    found = 0.0
    for k in range(3):
        found += quadrics[row, 12 + k] * quadrics[row, 3 + 3 * k + i] * quadrics[row, 3 + 3 * k + j]
    return found


@inline
def _quadric_coefficients(quadrics: Floats, row: int, middle: Point) -> _Ten:
    """Coefficients of x², y², z², xy, xz, yz, x, y, z (half of them), 1 about a point."""
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
    """`_of_quadric`"""
    p, q, r = spheres[row, 0] - middle[0], spheres[row, 1] - middle[1], spheres[row, 2] - middle[2]
    return 1.0, 1.0, 1.0, 0.0, 0.0, 0.0, -p, -q, -r, p * p + q * q + r * r - spheres[row, 3] * spheres[row, 3]


@inline
def _put_coefficients(
    kind: int, row: int, spheres: Floats, quadrics: Floats, middle: Point, found: Floats, at: int
) -> None:
    """The coefficients of what is curved, the largest of the second order 1; zeros where there is no such record."""
    numbers = 0.0, 0.0, 0.0, 0.0, 0.0, 0.0, 0.0, 0.0, 0.0, 0.0
    if kind == SPHERE:
        if 0 <= row < len(spheres):
            numbers = _ball_coefficients(spheres, row, middle)
    elif 0 <= row < len(quadrics):
        numbers = _quadric_coefficients(quadrics, row, middle)
    size = 0.0
    for k in range(10):
        found[at, k] = numbers[k]
        size = abs(numbers[k]) if k < 6 and abs(numbers[k]) > size else size
    size = size if size > 0.0 else 1.0
    for k in range(10):
        found[at, k] /= size


@kernel(kind="n", row="n", spheres="b 4", quadrics="q 19", found="out n 10")
def put_coefficients(kind: Signs, row: Ints, spheres: Floats, quadrics: Floats, middle: Point, found: Floats) -> None:
    """(n, 10) of x², y², z², xy, xz, yz, x, y, z (half of them), 1 about a point, the largest of the first six 1."""
    for i in range(len(kind)):
        _put_coefficients(kind[i], row[i], spheres, quadrics, middle, found, i)


@kernel(
    kind="n", row="n", spheres="b 4", quadrics="q 19", along="10", leading="6", room="out 1 10", places="out n",
)  # fmt: skip
def put_places_of_curved(
    kind: Signs, row: Ints, spheres: Floats, quadrics: Floats, middle: Point, unit: float, along: Floats,
    leading: Floats, room: Floats, places: Floats,
) -> float:  # fmt: skip
    """Where what is curved lies in a direction; returns the largest coefficient but those of second order, in lengths.

    room: for the coefficients of one.
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
        constant = room[0, 9] / unit / unit  # unit² may be beyond the floats
        length = math.sqrt(abs(constant))
        most = length if length > most else most
        places[i] = _signed_feature(before, place + constant * along[9])
    return most


@kernel(planes="p 7", rows="n", axes="out n", places="out n")
def put_across_axes(planes: Floats, rows: Ints, axes: Signs, places: Floats) -> None:
    """The axis that planes lie across, whose anchors lie on them, and where; -1 for others."""
    for i in range(len(rows)):
        axes[i], row = -1, rows[i]
        if not (0 <= row < len(planes) and planes[row, 3] == 0.0):
            continue
        for k in range(3):
            if planes[row, k] != 0.0 and planes[row, (k + 1) % 3] == 0.0 and planes[row, (k + 2) % 3] == 0.0:
                axes[i], places[i] = k, planes[row, 4 + k]


@inline
def _comes_before(planes: Floats, row: int, other: int) -> bool:
    """Does one record come before another, by the first number in which they differ?"""
    for k in range(7):
        if planes[row, k] != planes[other, k]:
            return planes[row, k] < planes[other, k]
    return False


@kernel(planes="p 7", rows="n", axes="n", places="n", order="n", first="out n")
def put_first_across_axes(planes: Floats, rows: Ints, axes: Signs, places: Floats, order: Longs, first: Longs) -> None:
    """For each plane the one across the same axis at the same place whose record comes first: by their positions.

    order: of the places, rising. Of equal records the one with the least position comes first.
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


# Quadrics as anchors and forms: what are one another moved share all numbers but those of their anchors.


@dataclass
class QuadricTable:
    """Two tables, as `Tables` has them. `quadrics[which]` are whole rows (n, 19), made when they are asked for."""

    rows: Floats  # (n, 4) anchor, row of the form
    forms: Floats  # (forms, 16)

    @classmethod
    def of(cls, anchors: Floats, forms: Floats) -> QuadricTable:
        """Those with a form each."""
        return cls(np.column_stack([anchors[:, :3], np.arange(len(anchors), dtype=np.float64)]), forms)

    @classmethod
    def empty(cls, form_of: Ints, forms: int) -> QuadricTable:
        """Room for those with these rows of so many forms."""
        rows = np.empty((len(form_of), ANCHOR_SIZE))
        rows[:, 3] = form_of
        return cls(rows, np.empty((forms, FORM_SIZE)))

    @property
    def form_of(self) -> Any:
        """(n,) the row of each one's form."""
        return self.rows[:, 3].astype(np.intp)

    def __len__(self) -> int:
        return len(self.rows)

    def __getitem__(self, which: Any) -> Floats:
        return whole_quadrics(self.rows[which], self.forms)

    def chosen(self, which: Any) -> QuadricTable:
        """Some of them; the table of forms stays."""
        return QuadricTable(self.rows[which], self.forms)

    def compact(self) -> tuple[QuadricTable, Any]:
        """The same without forms that nothing has, and which forms these are."""
        used, of = unique_with_inverse(self.form_of)
        rows = self.rows.copy()
        rows[:, 3] = of
        return QuadricTable(rows, self.forms[used]), used


# Surfaces whose records are so close that they may be one: `surfaces` lets their exact names decide.

CLOSENESS = 1e-11
FIRST_DIRECTION = 1.0 / np.sqrt([2.0, 3.0, 5.0, 7.0, 11.0, 13.0, 17.0, 19.0, 23.0, 29.0])
"""A direction in which surfaces of different rational coefficients have different places."""
SECOND_DIRECTION = 1.0 / np.sqrt([31.0, 37.0, 41.0, 43.0, 47.0, 53.0, 59.0, 61.0, 67.0, 71.0]) * np.tile([1.0, -1.0], 5)
"""Another such direction."""
_SEPARATION = 1000 * CLOSENESS
_ROUNDING_SHARE = 2.0**-12
"""Share of the largest coordinate: `CLOSE` of it is ten times as much as rounding takes from one."""


class SurfaceFeatures(Protocol):
    """What is known of surfaces that says where they lie side by side."""

    def places(self, along: Floats, which: Any, /) -> Floats:
        """Where some of them, or all for a slice, lie in a direction."""
        ...


@dataclass
class PlaneFeatures:
    """Some planes, by their features (`features`)."""

    rows: Ints
    planes: Floats
    middle: Point
    unit: float = 1.0

    @classmethod
    def of(cls, rows: Ints, planes: Floats) -> PlaneFeatures:
        """In the unit of the scene."""
        found = cls(rows, planes, _point(planes[rows, 4:].mean(axis=0)))
        most = put_places_of_planes(
            planes, rows, found.middle, 1.0, FIRST_DIRECTION[:4], FIRST_DIRECTION[:3], np.empty(len(rows))
        )
        return replace(found, unit=_unit(most, planes[rows, 4:]))

    def places(self, along: Floats, which: Any) -> Floats:
        """`Features.places`"""
        rows = self.rows[which]
        found = np.empty(len(rows))
        put_places_of_planes(self.planes, rows, self.middle, self.unit, along[:4], FIRST_DIRECTION[:3], found)
        return found


@dataclass
class CurvedFeatures:
    """What is curved, by its features."""

    kinds: Signs
    rows: Ints
    spheres: Floats
    quadrics: QuadricTable
    middle: Point
    unit: float = 1.0

    @classmethod
    def of(cls, kinds: Signs, rows: Ints, spheres: Floats, quadrics: QuadricTable) -> CurvedFeatures:
        """In the unit of the scene."""
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
    least = _ROUNDING_SHARE * float(np.abs(anchors).max(initial=0.0))
    found = max(most, least) if least < math.inf else most
    return found if 0 < found < math.inf else 1.0


def coefficients(kind: Signs, row: Ints, spheres: Floats, quadrics: QuadricTable | Floats, middle: Floats) -> Floats:
    """(n, 10) of x², y², z², xy, xz, yz, x, y, z (half of them), 1 about a point, the largest of the first six 1.

    quadrics: also as whole rows.
    """
    result = np.empty((len(kind), 10))
    for some, own, whole in _in_blocks(kind, row, quadrics):
        put_coefficients(kind[some], own, spheres, whole, _point(middle), result[some])
    return result


def _in_blocks(kind: Signs, row: Ints, quadrics: QuadricTable | Floats) -> Iterator[tuple[slice, Ints, Floats]]:
    """Some of what is curved at a time: (which, their rows, the whole rows of quadrics among them, numbered anew)."""
    for some in row_blocks(len(kind)):
        own, which = row[some].copy(), np.flatnonzero(kind[some] != SPHERE)
        whole = quadrics[own[which]]
        own[which] = np.arange(len(which), dtype=np.int32)
        yield some, own, whole


def find_clusters(members: Any, features: SurfaceFeatures) -> Iterable[Any]:
    """Groups of members whose features agree to about 1e-11 along `ALONG`, and nearly along another direction.

    Of N members N² 1e-11 agree along one direction by chance, which for millions are more than can be named exactly. A
    direction that has nothing to do with the first parts those, and none that are equal, by gaps a thousand times as
    wide.
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


# The scene-wide table of surfaces: each distinct plane or quadric once.
#
# Surfaces are rounded to float64 records; records that are equal to the bit, and that nothing was rounded in, are
# one surface. Where records are merely close, the exact names (`key`, 3000-bit arithmetic) decide: surfaces written
# twice, scaled, negated, or reached by different motions that are equal on paper become one. Which of
# their records represents all, and so gives the anchor, does not depend on the order in which they were added.

_NEARLY = 1e-6
_CHUNK = 1 << 13


@dataclass
class SurfaceTable:
    """The finished table, and for each surface added its id and the sense it has there (+1 or -1)."""

    kind: Signs
    row: Ints
    planes: Floats
    spheres: Floats
    quadrics: QuadricTable
    ids: Ints
    senses: Signs
    rest: Remainders
    single: Any  # (n,) of whole numbers, of the first of them, the number each came with; the others are bulk balls
    given: RawSurfaces
    first: Ints | None  # for each that was added the one whose record it takes; None where that is its own

    def forget_numbers(self) -> None:
        """Keep no longer which of the table each surface is that was added."""
        self.ids, self.senses = self.ids[:0].copy(), self.senses[:0].copy()


@dataclass
class Remainders:
    """What rounding took from the numbers of each record: the exact number is the record's plus this, to 2^-106."""

    planes: Floats
    spheres: Floats  # shorter than the table: bulk balls have none
    quadrics: Floats  # of the numbers of those that have one form (`Quadrics.form_of`)
    vertices: Floats = field(default_factory=lambda: np.zeros((0, 3)))  # of polygons


@dataclass
class RawSurfaces:
    """All surfaces that bodies were made of, bulk balls apart, as they came; `_first` finds which are the same."""

    kinds: Signs
    senses: Signs  # +1, or -1 where the record is the surface turned over
    planes: Floats
    spheres: Floats
    quadrics: QuadricTable
    rest: Remainders
    balls: list[Floats]
    exact: ExactSurfaces
    compact: bool = False
    """Are rows of planes and quadrics to go for which another stands? Scenes that are edited keep them."""

    @property
    def plain(self) -> npt.NDArray[np.bool_]:
        """From which of them nothing was rounded: those are equal where their records are."""
        plain = np.empty(len(self.kinds), bool)
        for kind, lost in ((PLANE, self.rest.planes), (SPHERE, self.rest.spheres), (QUADRIC, self.rest.quadrics)):
            whole = ~(lost != 0.0).any(axis=1)
            plain[self.kinds == kind] = whole[self.quadrics.form_of] if kind == QUADRIC else whole
        return plain


class ExactSurfaces(Protocol):
    """What surfaces were before they were rounded, by their numbers; worked out where it is asked for."""

    def __getitem__(self, index: int) -> Surface: ...

    def name(self, index: int) -> tuple[Key, int]:
        """The exact name of a surface, and its sense."""
        ...

    def said(self, indices: Longs) -> dict[int, Hashable]:
        """What is equal for surfaces that are surely one, of those of which that is seen."""
        ...


def exact_names_at(exact: ExactSurfaces, numbers: Ints | Longs, indices: Longs) -> dict[int, Hashable]:
    """`ExactSurfaces.said` for surfaces that have other numbers there: `numbers[indices]`."""
    there = numbers[indices].astype(np.int64)
    known = exact.said(there)
    pairs = zip(indices.tolist(), there.tolist(), strict=True)
    return {index: known[number] for index, number in pairs if number in known}


def merge_surfaces(surfaces: RawSurfaces) -> SurfaceTable:
    """Number the distinct surfaces. ids and senses are ordered as they came, bulk balls after the rest."""
    return _SurfaceMerger(surfaces).arrays()


class _SurfaceMerger:
    """One run of `finished`."""

    def __init__(self, surfaces: RawSurfaces) -> None:
        self.given, self.exact = surfaces, surfaces.exact
        self.single, self.ball_count = len(surfaces.kinds), sum(map(len, surfaces.balls))

    def arrays(self) -> SurfaceTable:
        """`finished`"""
        given, single = self.given, self.single
        kinds, planes, quadrics, rest = given.kinds, given.planes, given.quadrics, given.rest
        all_spheres = concatenate([given.spheres, *given.balls])
        count = single + self.ball_count
        kind, row = np.full(count, SPHERE, np.int8), np.arange(count, dtype=np.int32)
        kind[:single] = kinds
        row[single:] += np.int32(len(given.spheres) - single)
        for k in (PLANE, SPHERE, QUADRIC):
            member = kinds == k
            row[:single][member] = np.arange(member.sum())
        first = np.arange(count, dtype=np.int32)
        is_plain = np.ones(count, bool)
        is_plain[:single] = given.plain
        for k, table in ((PLANE, planes), (SPHERE, all_spheres), (QUADRIC, quadrics)):
            if _has_equal(table):
                members = np.flatnonzero(kind == k)
                plain = is_plain[members]
                some = table.chosen(plain) if isinstance(table, QuadricTable) else table[plain]
                _merge_equal(first, members[plain], some)
        flat = np.flatnonzero((kind[:single] == PLANE) & is_plain[:single])
        settled = _merge_across_axes(first, flat, row, planes)
        senses = np.ones(count, np.int8)
        senses[:single] = given.senses
        self._merge_exact(first, senses, kind, row, planes, all_spheres, quadrics, settled)
        # Number the representatives in the order they came
        leads = first == np.arange(count, dtype=np.int32)
        chosen = np.flatnonzero(leads[:single])
        if leads.all():
            return SurfaceTable(kind, row, planes, all_spheres, quadrics, first, senses, rest, chosen, given, None)
        number = np.cumsum(leads, dtype=np.int32) - np.int32(1)
        kind, row = kind[leads], row[leads]
        if given.compact:
            kept = {k: row[kind == k] for k in (PLANE, QUADRIC)}
            for k, rows in kept.items():
                row[kind == k] = np.arange(len(rows))
            planes, rest = planes[kept[PLANE]], replace(rest, planes=rest.planes[kept[PLANE]])
            if len(kept[QUADRIC]) < len(quadrics):
                quadrics, used = quadrics.chosen(kept[QUADRIC]).compact()
                rest = replace(rest, quadrics=rest.quadrics[used])
        return SurfaceTable(kind, row, planes, all_spheres, quadrics, number[first], senses, rest, chosen, given, first)

    def _name(self, index: int, spheres: Floats, row: Ints) -> tuple[Key, int]:
        """The exact name of a surface, and its sense."""
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
        """Among records that are close, let the exact names decide; of so many planes it is settled which are one."""
        distinct = np.flatnonzero(first[: self.single] == np.arange(self.single))
        is_flat = kind[distinct] == PLANE
        flat, curved = distinct[is_flat], distinct[~is_flat]
        close = list(find_clusters(flat, PlaneFeatures.of(row[flat], planes))) if len(flat) > settled else []
        if len(curved):  # bulk balls among themselves are equal to the bit or not at all
            curved = np.concatenate([curved, self._balls_near(curved, first, kind, row, spheres, quadrics)])
            close += find_clusters(curved, CurvedFeatures.of(kind[curved], row[curved], spheres, quadrics))
        tables: dict[int, Floats | QuadricTable] = {PLANE: planes, SPHERE: spheres, QUADRIC: quadrics}

        def record(index: int) -> tuple[bool, Floats]:
            at = int(row[index])
            return kind[index] != SPHERE, *tables[kind[index]][at : at + 1][0]

        asked = np.concatenate(close) if close else np.zeros(0, np.int64)
        said = self.exact.said(asked[asked < self.single])
        named: dict[int, tuple[int, int]] = {}
        for cluster in close:
            same: dict[Any, list[int]] = {}
            for index in cluster.tolist():
                same.setdefault(said.get(index, index), []).append(index)
            equal: dict[Any, list[tuple[int, int]]] = {}
            for some in same.values():
                key, sense = self._name(some[0], spheres, row) if len(same) > 1 else (None, 1)
                equal.setdefault(key, []).extend((index, sense) for index in some)
            for members in equal.values():
                # Which record represents them does not depend on the order in which they were added
                chosen, its_sense = min(members, key=lambda m: record(m[0]))
                for index, sense in members:
                    named[index] = (chosen, 1 if kind[index] == PLANE else sense * its_sense)
        if named:
            merged = np.fromiter(named, np.int64, len(named))
            found = np.array([named[index] for index in named])
            representative, turned = np.arange(len(first)), np.ones(len(first), np.int8)
            representative[merged], turned[merged] = found[:, 0], found[:, 1]
            senses *= turned[first]
            first[:] = representative[first]

    def _balls_near(
        self, curved: Any, first: Any, kind: Signs, row: Ints, spheres: Floats, quadrics: QuadricTable
    ) -> npt.NDArray[np.int64]:
        """Distinct bulk balls that may be one of some other surfaces, by a coordinate of their centers."""
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
        distinct: npt.NDArray[np.int64] = found[first[found] == found]
        return distinct


def concatenate(parts: Sequence[npt.NDArray[Any]]) -> npt.NDArray[Any]:
    """Concatenated; no copy where all but one are empty."""
    filled = [part for part in parts if len(part)]
    return np.concatenate(filled) if len(filled) > 1 else (filled or parts)[0]


def _row_hashes(table: Floats | QuadricTable) -> npt.NDArray[np.uint64]:
    """A number for each row, equal for equal rows (zeros of both signs alike)."""
    mixed = np.zeros(len(table), np.uint64)
    for begin in range(0, len(table), _CHUNK):
        words = (table[begin : begin + _CHUNK] + 0.0).view(np.uint64)
        part = mixed[begin : begin + _CHUNK]
        for column in range(words.shape[1]):
            part ^= words[:, column]
            part *= np.uint64(0x9E3779B97F4A7C15)
            part ^= part >> np.uint64(29)
    return mixed


def _has_equal(table: Floats | QuadricTable) -> bool:
    """Might two rows be equal?  In a large table without any, much faster than to look for them."""
    mixed = _row_hashes(table)
    mixed.sort()
    return bool((mixed[1:] == mixed[:-1]).any())


def _merge_equal(first: Any, members: Any, table: Floats | QuadricTable) -> None:
    """Point each member at the earliest one with the same record to the bit (zeros of both signs alike)."""
    order = np.argsort(_row_hashes(table), kind="stable")
    same = np.zeros(len(order), bool)
    for begin in range(1, len(order), _CHUNK):
        rows = table[order[begin - 1 : begin + _CHUNK]]
        same[begin : begin + _CHUNK] = (rows[1:] == rows[:-1]).all(axis=1)
    head = np.maximum.accumulate(np.where(same, 0, np.arange(len(order))))
    first[members[order]] = members[order[head]]


def _merge_across_axes(first: Any, members: Any, row: Ints, planes: Floats) -> int:
    """Point planes that lie across an axis at the same place at the one whose record comes first in order.

    For planes that nothing was rounded in, and whose anchors lie on them. Their exact names would say the same. Returns
    how many of those that lead have been settled so.
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
