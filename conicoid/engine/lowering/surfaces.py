"""The scene-wide table of surfaces: each distinct plane or quadric once.

Surfaces are rounded to float64 records; records that are equal to the bit, and that nothing was rounded in, are
one surface. Where records are merely close, the exact names (`key`, 3000-bit arithmetic) decide: surfaces written
twice, scaled, negated, or reached by different motions that are equal on paper become one. Which of
their records represents all, and so gives the anchor, does not depend on the order in which they were added.
"""

from __future__ import annotations

import math
from collections.abc import Iterable, Sequence
from dataclasses import dataclass, field, replace
from fractions import Fraction
from typing import Any, Protocol

import numpy as np
import numpy.typing as npt

from ...shapes.row_vectors import dot_rows, lengths
from ...shapes.surface import ORIGIN, UPRIGHT, Key, QuadricSurface, Surface
from ..tables import PLANE, QUADRIC, SPHERE, Floats, Ints, Signs

CLOSE = 1e-11
ALONG = 1.0 / np.sqrt([2.0, 3.0, 5.0, 7.0, 11.0, 13.0, 17.0, 19.0, 23.0, 29.0])
"""A direction in which surfaces of different rational coefficients have different places."""
ACROSS = 1.0 / np.sqrt([31.0, 37.0, 41.0, 43.0, 47.0, 53.0, 59.0, 61.0, 67.0, 71.0]) * np.tile([1.0, -1.0], 5)
"""Another such direction."""
_APART = 1000 * CLOSE
_NEARLY = 1e-6
_CHUNK = 1 << 13


@dataclass
class SurfaceArrays:
    """The finished table, and for each surface added its id and the sense it has there (+1 or -1)."""

    kind: Signs
    row: Ints
    planes: Floats
    spheres: Floats
    quadrics: Floats
    ids: Ints
    senses: Signs
    quadric_rest: Ints
    rest: Remainders
    single: Any  # (n,) of whole numbers, of the first of them, the number each came with; the others are bulk balls
    given: Surfaces
    first: Ints | None  # for each that was added the one whose record it takes; None where that is its own


@dataclass
class Remainders:
    """What rounding took from the numbers of each record: the exact number is the record's plus this, to 2^-106."""

    planes: Floats
    spheres: Floats  # shorter than the table: bulk balls have none
    quadrics: Floats  # whose row is whose is told by `quadric_rest`
    vertices: Floats = field(default_factory=lambda: np.zeros((0, 3)))  # of polygons


@dataclass
class Surfaces:
    """All surfaces that bodies were made of, bulk balls apart, as they came; `_first` finds which are the same."""

    kinds: Signs
    senses: Signs  # +1, or -1 where the record is the surface turned over
    planes: Floats
    spheres: Floats
    quadrics: Floats
    quadric_rest: Ints
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
            plain[self.kinds == kind] = whole[self.quadric_rest] if kind == QUADRIC else whole
        return plain


class ExactSurfaces(Protocol):
    """What surfaces were before they were rounded, by their numbers; worked out where it is asked for."""

    def __getitem__(self, index: int) -> Surface: ...

    def name(self, index: int) -> tuple[Key, int]:
        """The exact name of a surface, and its sense."""
        ...


def finished(surfaces: Surfaces) -> SurfaceArrays:
    """Number the distinct surfaces. ids and senses are ordered as they came, bulk balls after the rest."""
    return _Finish(surfaces).arrays()


class _Finish:
    """One run of `finished`."""

    def __init__(self, surfaces: Surfaces) -> None:
        self.given, self.exact = surfaces, surfaces.exact
        self.single, self.ball_count = len(surfaces.kinds), sum(map(len, surfaces.balls))

    def arrays(self) -> SurfaceArrays:
        """`finished`"""
        given, single = self.given, self.single
        kinds, planes, quadrics, rest = given.kinds, given.planes, given.quadrics, given.rest
        quadric_rest = given.quadric_rest
        all_spheres = end_to_end([given.spheres, *given.balls])
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
                _merge_equal(first, members[plain], table[plain])
        _merge_across_axes(first, np.flatnonzero((kind[:single] == PLANE) & is_plain[:single]), row, planes)
        senses = np.ones(count, np.int8)
        senses[:single] = given.senses
        self._merge_exact(first, senses, kind, row, planes, all_spheres, quadrics)
        # Number the representatives in the order they came
        leads = first == np.arange(count, dtype=np.int32)
        chosen = np.flatnonzero(leads[:single])
        if leads.all():
            return SurfaceArrays(
                kind, row, planes, all_spheres, quadrics, first, senses, quadric_rest, rest, chosen, given, None
            )
        number = np.cumsum(leads, dtype=np.int32) - np.int32(1)
        kind, row = kind[leads], row[leads]
        if given.compact:
            kept = {k: row[kind == k] for k in (PLANE, QUADRIC)}
            for k, rows in kept.items():
                row[kind == k] = np.arange(len(rows))
            planes, rest = planes[kept[PLANE]], replace(rest, planes=rest.planes[kept[PLANE]])
            if len(kept[QUADRIC]) < len(quadrics):
                quadrics = quadrics[kept[QUADRIC]]
                used, rows = np.unique(quadric_rest[kept[QUADRIC]], return_inverse=True)
                quadric_rest, rest = rows.astype(np.int32), replace(rest, quadrics=rest.quadrics[used])
        return SurfaceArrays(
            kind, row, planes, all_spheres, quadrics, number[first], senses, quadric_rest, rest, chosen, given, first
        )

    def _name(self, index: int, spheres: Floats, row: Ints) -> tuple[Key, int]:
        """The exact name of a surface, and its sense."""
        if index >= self.single:
            x, y, z, r = (float(v) for v in spheres[row[index]])
            return QuadricSurface((1.0, 1.0, 1.0), ORIGIN, Fraction(r) ** 2, UPRIGHT, (x, y, z)).key()
        return self.exact.name(index)

    def _merge_exact(
        self, first: Any, senses: Signs, kind: Signs, row: Ints, planes: Floats, spheres: Floats, quadrics: Floats
    ) -> None:
        """Among records that are close, let the exact names decide."""
        distinct = np.flatnonzero(first[: self.single] == np.arange(self.single))
        flat = kind[distinct] == PLANE
        clusters = list(_clusters(distinct[flat], _plane_features(planes[row[distinct[flat]]])))
        curved = distinct[~flat]
        if len(curved):  # bulk balls among themselves are equal to the bit or not at all
            curved = np.concatenate([curved, self._balls_near(curved, first, kind, row, spheres, quadrics)])
            clusters += _clusters(curved, _quadric_features(kind[curved], row[curved], spheres, quadrics))
        tables = {PLANE: planes, SPHERE: spheres, QUADRIC: quadrics}
        named: dict[int, tuple[int, int]] = {}
        for cluster in clusters:
            equal: dict[Any, list[tuple[int, int]]] = {}
            for index in cluster.tolist():
                key, sense = self._name(index, spheres, row)
                equal.setdefault(key, []).append((index, sense))
            for members in equal.values():
                # Which record represents them does not depend on the order in which they were added
                chosen, its_sense = min(members, key=lambda m: (kind[m[0]] != SPHERE, *tables[kind[m[0]]][row[m[0]]]))
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
        self, curved: Any, first: Any, kind: Signs, row: Ints, spheres: Floats, quadrics: Floats
    ) -> npt.NDArray[np.int64]:
        """Distinct bulk balls that may be one of some other surfaces, by a coordinate of their centers."""
        if self.ball_count == 0:
            return np.zeros(0, np.int64)
        single = self.single
        middle = spheres[:1, :3].mean(axis=0) if len(spheres) else np.zeros(3)
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


def end_to_end(parts: Sequence[npt.NDArray[Any]]) -> npt.NDArray[Any]:
    """Concatenated; no copy where all but one are empty."""
    filled = [part for part in parts if len(part)]
    return np.concatenate(filled) if len(filled) > 1 else (filled or parts)[0]


def _mixed(table: Floats) -> npt.NDArray[np.uint64]:
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


def _has_equal(table: Floats) -> bool:
    """Might two rows be equal?  In a large table without any, much faster than to look for them."""
    mixed = _mixed(table)
    mixed.sort()
    return bool((mixed[1:] == mixed[:-1]).any())


def _merge_equal(first: Any, members: Any, table: Floats) -> None:
    """Point each member at the earliest one with the same record to the bit (zeros of both signs alike)."""
    order = np.argsort(_mixed(table), kind="stable")
    same = np.zeros(len(order), bool)
    same[1:] = (table[order[1:]] == table[order[:-1]]).all(axis=1)
    head = np.maximum.accumulate(np.where(same, 0, np.arange(len(order))))
    first[members[order]] = members[order[head]]


def _merge_across_axes(first: Any, members: Any, row: Ints, planes: Floats) -> None:
    """Point planes that lie across an axis at the same place at the one whose record comes first in order.

    For planes that nothing was rounded in, and whose anchors lie on them. Their exact names would say the same.
    """
    members = members[first[members] == members]
    records = planes[row[members]]
    along = records[:, :3] != 0
    plain = (along.sum(axis=1) == 1) & (records[:, 3] == 0)
    members, records, axis = members[plain], records[plain], along[plain].argmax(axis=1)
    if len(members) < 2:
        return
    place = records[np.arange(len(records)), 4 + axis]
    order = np.lexsort((*records.T[::-1], place, axis))
    new = np.concatenate([[True], (np.diff(place[order]) != 0) | (np.diff(axis[order]) != 0)])
    first[members[order]] = members[order[np.maximum.accumulate(np.where(new, np.arange(len(order)), 0))]]
    first[:] = first[first]


def _plane_features(planes: Floats) -> Floats:
    """Unit normals and offsets about the middle of the scene, scaled to order one."""
    normals, over, anchors = planes[:, :3], planes[:, 3], planes[:, 4:]
    sizes = lengths(normals)
    center = anchors.mean(axis=0) if len(anchors) else np.zeros(3)
    offsets = ((anchors - center) * normals).sum(axis=1) - over
    return _scaled(np.column_stack([normals / sizes[:, None], offsets / sizes]), 3, (3,), ())


def _quadric_features(kind: Signs, row: Ints, spheres: Floats, quadrics: Floats) -> Floats:
    """Coefficients about the middle of the scene, scaled to order one."""
    ball = kind == SPHERE
    anchors = np.concatenate([spheres[row[ball], :3], quadrics[row[~ball], :3]])
    middle = anchors.mean(axis=0) if len(anchors) else np.zeros(3)
    return _scaled(coefficients(kind, row, spheres, quadrics, middle), 6, (6, 7, 8), (9,))


def coefficients(kind: Signs, row: Ints, spheres: Floats, quadrics: Floats, middle: Floats) -> Floats:
    """(n, 10) of x², y², z², xy, xz, yz, x, y, z (half of them), 1 about a point, the largest of the first six 1."""
    result = np.empty((len(kind), 10))
    for begin in range(0, len(kind), _CHUNK):
        some = slice(begin, begin + _CHUNK)
        result[some] = _some_coefficients(kind[some], row[some], spheres, quadrics, middle)
    return result


def _some_coefficients(kind: Signs, row: Ints, spheres: Floats, quadrics: Floats, middle: Floats) -> Floats:
    """`coefficients` of a part of the surfaces."""
    count = len(kind)
    ball = kind == SPHERE
    anchors = np.empty((count, 3))
    anchors[ball], anchors[~ball] = spheres[row[ball], :3], quadrics[row[~ball], :3]
    p = anchors - middle
    result = np.zeros((count, 10))
    result[ball, :3] = 1.0
    result[ball, 6:9] = -p[ball]
    result[ball, 9] = (p[ball] ** 2).sum(axis=1) - spheres[row[ball], 3] ** 2
    if not ball.all():
        result[~ball] = _of_quadrics(np.ascontiguousarray(quadrics[row[~ball]].T), np.ascontiguousarray(p[~ball].T)).T
    size = np.abs(result[:, 0])
    for column in range(1, 6):
        np.maximum(size, np.abs(result[:, column]), out=size)
    return result / np.where(size > 0, size, 1.0)[:, None]


def _of_quadrics(q: Floats, p: Floats) -> Floats:
    """(10, n) of records, (19, n), whose anchors are at p, (3, n)."""
    result = np.empty((10, q.shape[1]))
    w, s, b = q[3:12].reshape(3, 3, -1), q[12:15], q[15:18]
    for row, (i, j) in enumerate(((0, 0), (1, 1), (2, 2), (0, 1), (0, 2), (1, 2))):
        result[row] = sum(s[k] * w[k, i] * w[k, j] for k in range(3))
    shift = [-(w[k, 0] * p[0] + w[k, 1] * p[1] + w[k, 2] * p[2]) for k in range(3)]
    along = [s[k] * shift[k] + b[k] for k in range(3)]
    for i in range(3):
        result[6 + i] = w[0, i] * along[0] + w[1, i] * along[1] + w[2, i] * along[2]
    x, y, z = (s[k] * shift[k] ** 2 + 2 * b[k] * shift[k] for k in range(3))
    result[9] = x + y + z - q[18]
    return result


def _scaled(features: Floats, leading: int, first_order: tuple[int, ...], second_order: tuple[int, ...]) -> Floats:
    """Fix the sign by the leading columns; divide lengths and squared lengths by the scene's own."""
    if not len(features):
        return features
    sign = np.sign(dot_rows(features[:, :leading], ALONG[:leading]))
    features *= np.where(sign == 0, 1.0, sign)[:, None]
    reach = np.abs(features[:, list(first_order)]).max()
    reach = max(reach, math.sqrt(np.abs(features[:, list(second_order)]).max())) if second_order else reach
    if reach > 0 and math.isfinite(reach):
        features[:, list(first_order)] /= reach
        features[:, list(second_order)] /= reach  # twice, as its square may be beyond float64
        features[:, list(second_order)] /= reach
    return features


def _clusters(members: Any, features: Floats) -> Iterable[Any]:
    """Groups of members whose features agree to about 1e-11 along `ALONG`, and nearly along another direction.

    Of N members N² 1e-11 agree along one direction by chance, which for millions are more than can be named exactly. A
    direction that has nothing to do with the first parts those, and none that are equal, by gaps a thousand times as
    wide.
    """
    if len(members) < 2:
        return
    place = dot_rows(features, ALONG[: features.shape[1]])
    order = np.argsort(place, kind="stable")
    near = np.diff(place[order]) <= CLOSE
    starts = np.flatnonzero(np.concatenate([[True], ~near]))
    ends = np.concatenate([starts[1:], [len(order)]])
    for start, end in zip(starts[ends - starts > 1], ends[ends - starts > 1], strict=True):
        group = order[start:end]
        across = dot_rows(features[group], ACROSS[: features.shape[1]])
        sorted_ = np.argsort(across, kind="stable")
        for part in np.split(sorted_, 1 + np.flatnonzero(np.diff(across[sorted_]) > _APART)):
            if len(part) > 1:
                yield members[group[np.sort(part)]]
