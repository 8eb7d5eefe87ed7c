"""The scene-wide table of surfaces: each distinct plane or quadric once.

Surfaces are rounded to float64 records; records that are equal to the bit, and that nothing was rounded in, are
one surface. Where records are merely close, the exact names (`key`, 3000-bit arithmetic) decide: surfaces written
twice, scaled, negated, or reached by different motions that are equal on paper become one. Which of
their records represents all, and so gives the anchor, does not depend on the order in which they were added.
"""

from __future__ import annotations

from collections.abc import Hashable, Sequence
from dataclasses import dataclass, field, replace
from fractions import Fraction
from typing import Any, Protocol

import numpy as np
import numpy.typing as npt

from ...shapes.row_vectors import dot_rows
from ...shapes.surface import ORIGIN, UPRIGHT, Key, QuadricSurface, Surface
from ..tables import PLANE, QUADRIC, SPHERE, Floats, Ints, Longs, Signs
from .clusters import Curved, Flat, clusters, coefficients
from .features import put_across_axes, put_first_across_axes
from .quadrics import Quadrics

_NEARLY = 1e-6
_CHUNK = 1 << 13


@dataclass
class SurfaceArrays:
    """The finished table, and for each surface added its id and the sense it has there (+1 or -1)."""

    kind: Signs
    row: Ints
    planes: Floats
    spheres: Floats
    quadrics: Quadrics
    ids: Ints
    senses: Signs
    rest: Remainders
    single: Any  # (n,) of whole numbers, of the first of them, the number each came with; the others are bulk balls
    given: Surfaces
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
class Surfaces:
    """All surfaces that bodies were made of, bulk balls apart, as they came; `_first` finds which are the same."""

    kinds: Signs
    senses: Signs  # +1, or -1 where the record is the surface turned over
    planes: Floats
    spheres: Floats
    quadrics: Quadrics
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


def said_of(exact: ExactSurfaces, numbers: Ints | Longs, indices: Longs) -> dict[int, Hashable]:
    """`ExactSurfaces.said` for surfaces that have other numbers there: `numbers[indices]`."""
    there = numbers[indices].astype(np.int64)
    known = exact.said(there)
    pairs = zip(indices.tolist(), there.tolist(), strict=True)
    return {index: known[number] for index, number in pairs if number in known}


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
                some = table.chosen(plain) if isinstance(table, Quadrics) else table[plain]
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
            return SurfaceArrays(kind, row, planes, all_spheres, quadrics, first, senses, rest, chosen, given, None)
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
        return SurfaceArrays(
            kind, row, planes, all_spheres, quadrics, number[first], senses, rest, chosen, given, first
        )

    def _name(self, index: int, spheres: Floats, row: Ints) -> tuple[Key, int]:
        """The exact name of a surface, and its sense."""
        if index >= self.single:
            x, y, z, r = (float(v) for v in spheres[row[index]])
            return QuadricSurface((1.0, 1.0, 1.0), ORIGIN, Fraction(r) ** 2, UPRIGHT, (x, y, z)).key()
        return self.exact.name(index)

    def _merge_exact(
        self, first: Any, senses: Signs, kind: Signs, row: Ints, planes: Floats, spheres: Floats, quadrics: Quadrics,
        settled: int,
    ) -> None:  # fmt: skip
        """Among records that are close, let the exact names decide; of so many planes it is settled which are one."""
        distinct = np.flatnonzero(first[: self.single] == np.arange(self.single))
        is_flat = kind[distinct] == PLANE
        flat, curved = distinct[is_flat], distinct[~is_flat]
        close = list(clusters(flat, Flat.of(row[flat], planes))) if len(flat) > settled else []
        if len(curved):  # bulk balls among themselves are equal to the bit or not at all
            curved = np.concatenate([curved, self._balls_near(curved, first, kind, row, spheres, quadrics)])
            close += clusters(curved, Curved.of(kind[curved], row[curved], spheres, quadrics))
        tables: dict[int, Floats | Quadrics] = {PLANE: planes, SPHERE: spheres, QUADRIC: quadrics}

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
        self, curved: Any, first: Any, kind: Signs, row: Ints, spheres: Floats, quadrics: Quadrics
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


def end_to_end(parts: Sequence[npt.NDArray[Any]]) -> npt.NDArray[Any]:
    """Concatenated; no copy where all but one are empty."""
    filled = [part for part in parts if len(part)]
    return np.concatenate(filled) if len(filled) > 1 else (filled or parts)[0]


def _mixed(table: Floats | Quadrics) -> npt.NDArray[np.uint64]:
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


def _has_equal(table: Floats | Quadrics) -> bool:
    """Might two rows be equal?  In a large table without any, much faster than to look for them."""
    mixed = _mixed(table)
    mixed.sort()
    return bool((mixed[1:] == mixed[:-1]).any())


def _merge_equal(first: Any, members: Any, table: Floats | Quadrics) -> None:
    """Point each member at the earliest one with the same record to the bit (zeros of both signs alike)."""
    order = np.argsort(_mixed(table), kind="stable")
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
