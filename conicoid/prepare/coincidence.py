"""Coincident surfaces: find the planes and quadrics that are equal, and build the scene-wide table with each once.

`InputSurfaces` lists once what translated copies share, so that it is never compared. Surfaces that may be equal have
nearly equal features (`surface_features.py`), and exact names decide among them. Three other places decide which
surfaces are equal, and none of them by other rules:

- `geometry/surface.py` gives a surface its exact name, `key`: equal surfaces have equal keys, up to the sign.
- `prepare/surface_names.py` names surfaces by their numbers before the first rotation (`name_surfaces`).
- `prepare/edits/surface_merge.py` and `prepare/edits/surface_classes.py` compare only new surfaces with the others
  after an edit; `prepare/edits/neighbour_index.py` finds the ones that are close.
"""

from __future__ import annotations

from collections.abc import Callable, Hashable, Iterator, Sequence
from dataclasses import replace
from fractions import Fraction
from typing import Any, Protocol, TypeAlias

import numpy as np
import numpy.typing as npt

from .._jit.decorators import inline, kernel
from .._util.arrays import dot_rows, unique_with_inverse
from .._util.records import dataclass
from ..geometry.surface import ORIGIN, UPRIGHT, Key, QuadricSurface, Surface
from ..kernels.tables import PLANE, QUADRIC, SPHERE, Floats, Ints, Longs, Signs
from ..kernels.threads import run_rows
from .mmap_arrays import mapped_zeros
from .pattern import BodyGroup, FactoredRows, Primitives, RowPlaces, put_numbers
from .pytree import positions_by_key
from .surface_features import CurvedFeatures, PlaneFeatures, QuadricTable, Remainders, coefficients, find_clusters
from .surface_names import FEWEST_SURFACES

# The surfaces of all bodies, grouped where equality is known without comparing records

_Anchors: TypeAlias = list[tuple[Floats, Ints]]
"""For each axis the distinct coordinates of anchors, and which of them each anchor has."""


@kernel(numbers="n", place="n", least="out p", lead="out s")
def put_least(numbers: Ints, place: Longs, least: Ints, lead: Ints) -> None:
    """Let the least number of all surfaces at a place lead them. `least` begins with numbers above all."""
    for i in range(len(numbers)):
        if 0 <= place[i] < len(least) and numbers[i] < least[place[i]]:
            least[place[i]] = numbers[i]
    for i in range(len(numbers)):
        if 0 <= place[i] < len(least) and 0 <= numbers[i] < len(lead):
            lead[numbers[i]] = least[place[i]]


@kernel(kinds="s", rank="out s", leads="out s", row="out s")
def number_leads(kinds: Ints, rank: Ints, leads: Ints, row: Ints) -> int:
    """Number the leads, and return how many there are. Writes them, and their numbers among the leads of their kind.

    `rank` names the lead of each surface; it becomes -1 - the number of a lead, for others the number of their lead.
    """
    count, planes, spheres = 0, 0, 0
    for i in range(len(rank)):
        if rank[i] == i:
            plane, sphere = kinds[i] == PLANE, kinds[i] == SPHERE
            leads[count], rank[i] = i, -1 - count
            row[count] = planes if plane else (spheres if sphere else count - planes - spheres)
            planes, spheres, count = planes + (1 if plane else 0), spheres + (1 if sphere else 0), count + 1
    for i in range(len(rank)):
        if 0 <= rank[i] < len(rank):
            rank[i] = -1 - rank[rank[i]]
    return count


@kernel(first="n", rank="s", which="out n")
def list_leads(first: Ints, number: int, rank: Ints, which: Ints) -> int:
    """List the bodies of a group in which a surface is a lead; return how many there are."""
    count = 0
    for i in range(len(first)):
        if 0 <= first[i] + number < len(rank) and rank[first[i] + number] < 0:
            which[count], count = i, count + 1
    return count


@dataclass(frozen=True)
class CopiedSurface:
    """A surface of each body of a group of translated copies, and the bodies in which it is a lead."""

    rows: FactoredRows
    kind: int
    column: int  # of its record
    sense: int  # column of its sense, behind the record and what rounding removed from that
    leads: Ints
    bodies: Ints | None  # None: all of the group

    @property
    def shares_form(self) -> bool:
        """Return whether these are quadrics that differ in their anchors alone, and no anchor was rounded."""
        known = self.kind == QUADRIC and self.rows.forms.get(self.column) is not None
        return known and len(self.leads) > 0

    def columns(self, some: slice, first: int, last: int) -> Floats:
        """Return columns of some of the leads."""
        return self.rows.of(some if self.bodies is None else self.bodies[some], first, last)


@dataclass
class InputSurfaces:
    """The surfaces of all bodies in input order; each has a lead, a surface that it certainly equals."""

    kinds: Signs  # of the leads
    leads: Ints  # the surfaces that are their own lead, rising
    rank: Ints  # -1 - the number of a lead among the leads; for another surface the number of its lead
    row: Ints  # of each lead its number among the leads of its kind
    turned: Signs | None  # -1 where its record is its lead's negated; None where no record is
    copies: list[CopiedSurface]
    """In groups that are not of copies every surface is a lead, and has a form of its own."""

    @classmethod
    def of(cls, groups: Sequence[BodyGroup], places: RowPlaces) -> InputSurfaces:
        """Collect the surfaces of the bodies of all groups."""
        kinds, rank = np.empty(places.count, np.int32), np.arange(places.count, dtype=np.int32)
        for group in groups:
            first = places.first[group.bodies]
            put_numbers(first, np.zeros(1, np.int32), group.pattern.kinds, kinds)
            for number, (_, column, _) in enumerate(group.pattern.records):
                if isinstance(group.rows, FactoredRows) and column in group.rows.leads:
                    # The lead of a surface is that of the body which `leads` names
                    own = np.array([number], np.int32)
                    put_numbers(first, first[group.rows.leads[column]], own, rank[number:])
        senses: Signs | None = None
        for same in _group_by_form(groups, places):
            numbers = np.concatenate([part for part, _, _ in same])
            count, place = _number_anchors([anchors for _, anchors, _ in same])
            put_least(numbers, place, np.full(count, places.count, np.int32), rank)
            if len({sense for _, _, sense in same}) > 1:
                senses = np.ones(places.count, np.int8) if senses is None else senses
                for part, _, sense in same:
                    senses[part] = sense
        leads, row = np.empty(places.count, np.int32), np.empty(places.count, np.int32)
        count = number_leads(kinds, rank, leads, row)
        leads, row = leads[:count].copy(), row[:count].copy()
        turned = None if senses is None else senses * senses[leads][rank ^ (rank >> 31)]
        copies = list(_list_copies(groups, places, rank))
        return cls(kinds[leads].astype(np.int8), leads, rank, row, turned, copies)

    def count(self, kind: int) -> int:
        """Count the leads of a kind."""
        return int(np.count_nonzero(self.kinds == kind))

    def rows_of_forms(self) -> tuple[Ints, int]:
        """Return (for each quadric the row of its form and of its remainders, how many have rows of their own).

        Own rows come first, in order; then one for each form that a whole group shares.
        """
        form = np.full(self.count(QUADRIC), -1, np.int32)
        count = 0
        for copied in self.copies:
            if copied.shares_form:
                form[self.row[-1 - self.rank[copied.leads]]] = count
                count += 1
        own = form < 0
        rows = np.cumsum(own, dtype=np.int32) - np.int32(1)
        rows[~own] = form[~own] + np.int32(own.sum())
        return rows, int(own.sum())

    def expand(self, surfaces: SurfaceTable) -> SurfaceTable:
        """Expand a table of the leads to all input surfaces."""
        if len(self.leads) == len(self.rank):
            return surfaces
        return replace(surfaces, rank=self.rank, turned=self.turned, single=self.leads[surfaces.single])


def _list_copies(groups: Sequence[BodyGroup], places: RowPlaces, rank: Ints) -> Iterator[CopiedSurface]:
    """Yield `InputSurfaces.copies`."""
    for group in groups:
        if isinstance(group.rows, FactoredRows):
            first = places.first[group.bodies]
            for number, record in enumerate(group.pattern.records):
                which = np.empty(len(first), np.int32)
                which = which[: list_leads(first, number, rank, which)].copy()
                every = len(which) == len(first)
                leads = (first if every else first[which]) + np.int32(number)
                yield CopiedSurface(group.rows, *record, leads, None if every else which)


def _group_by_form(groups: Sequence[BodyGroup], places: RowPlaces) -> list[list[tuple[Ints, _Anchors, int]]]:
    """List (numbers, anchors, senses) of surfaces that are equal exactly where their anchors are."""
    by_form: dict[Hashable, list[tuple[Ints, _Anchors, int]]] = {}
    for group in groups:
        if isinstance(group.rows, FactoredRows):
            first = places.first[group.bodies]
            for number, (_, column, sense) in enumerate(group.pattern.records):
                named = group.rows.name(column)
                if named is not None:
                    form, anchors = named
                    by_form.setdefault(form, []).append((first + number, anchors, int(group.rows.base[sense])))
    return list(by_form.values())


def _number_anchors(parts: Sequence[_Anchors]) -> tuple[int, npt.NDArray[np.int64]]:
    """Number the anchors so that equal anchors have equal numbers; return (count of numbers, number of each anchor)."""
    total = sum(len(part[0][1]) for part in parts)
    count, number = 1, np.zeros(total, np.int64)
    for axis in range(3):
        columns = [part[axis] for part in parts]
        values, place = unique_with_inverse(np.concatenate([values for values, _ in columns]))
        if len(values) == 1:
            continue
        ends = np.cumsum([len(values) for values, _ in columns])
        places = np.split(place, ends[:-1])
        index = np.concatenate([mine[which] for mine, (_, which) in zip(places, columns, strict=True)])
        count, number = count * len(values), number * len(values) + index
        # Compact the numbers so that the products above stay within int64.
        if count > 2 * total:
            values, number = unique_with_inverse(number)
            count, number = len(values), number.astype(np.int64)  # NumPy's indices have 32 bits in WebAssembly
    return count, number


@dataclass
class SurfaceSubset:
    """Some exact surfaces, renumbered from 0."""

    exact: ExactSurfaces
    numbers: Ints | Longs
    list_primitives: Callable[[Longs], Primitives] | None = None
    """Lists the primitives of all bodies, or at least of those with some surfaces."""
    primitives: Primitives | None = None
    """Those listed so far."""

    def __getitem__(self, index: int) -> Surface:
        return self.exact[int(self.numbers[index])]

    def name(self, index: int) -> tuple[Key, int]:
        """Return the exact name of a surface, and its sense."""
        return self.exact.name(int(self.numbers[index]), self.primitives)

    def known_names(self, surfaces: Longs, clusters: Longs) -> Longs:
        """`ExactSurfaces.known_names`"""
        numbers = self.numbers[surfaces].astype(np.int64)
        if self.list_primitives is not None and len(numbers) >= FEWEST_SURFACES:
            self.primitives = self.list_primitives(numbers)
        return self.exact.known_names(numbers, clusters, self.primitives)


# Copies of a curved surface: where no other form may give an equal one, different anchors do not, either

_DIFFERENT = 1e-9
"""Coefficients that differ by this share of the largest differ by more than rounding."""
_MOST_FORMS = 1 << 10


@dataclass(frozen=True)
class SharedForm:
    """A form that copies of a surface share, by name, and along each axis the coordinate that all anchors have."""

    name: Hashable
    places: tuple[float | None, ...]

    @classmethod
    def of(cls, copied: CopiedSurface) -> SharedForm:
        """Describe the form of a surface of copies that share it."""
        axes = [copied.rows.distinct(copied.column + axis)[0] for axis in range(3)]
        places = (float(values[0]) if (values == values[0]).all() else None for values in axes)
        return cls(copied.rows.forms[copied.column], tuple(places))


def settled_forms(forms: Floats, shared: Sequence[SharedForm], spheres: bool) -> npt.NDArray[np.bool_]:
    """Return the forms of surfaces that certainly differ from all of another name or another anchor.

    `shared` describes the last forms. A settled form is a sum of squares along axes less a constant: equal surfaces
    have that constant, these squares and, along these axes, the center in common.
    """
    settled, own = np.zeros(len(forms), bool), len(forms) - len(shared)
    if not shared or len(forms) > _MOST_FORMS:
        return settled
    count = len(forms)
    whole = np.concatenate([np.zeros((count, 3)), forms], axis=1)
    kinds, rows = np.full(count, QUADRIC, np.int8), np.arange(count, dtype=np.int32)
    numbers = coefficients(kinds, rows, np.zeros((0, 4)), whole, np.zeros(3))
    linear = numbers[:, 6:9].any(axis=1)
    bends = (forms[:, :9].reshape(-1, 3, 3) != 0) & (forms[:, 9:12] != 0)[:, :, None]
    plain = (bends.sum(axis=1) <= 1).all(axis=1) & (bends.sum(axis=2) <= 1).all(axis=1) & ~linear
    names: dict[Hashable, int] = {}
    name = np.array([-1] * own + [names.setdefault(form.name, len(names)) for form in shared])
    for row in np.flatnonzero(plain & (name >= 0)).tolist():
        near = name == -2
        for sign in (1.0, -1.0):
            away = np.abs(numbers - sign * numbers[row])
            level = linear | (away[:, 9] <= _DIFFERENT * np.maximum(np.abs(numbers[:, 9]), abs(numbers[row, 9])))
            near |= level & (away[:, :6].max(axis=1) <= _DIFFERENT)
        flat = np.flatnonzero(~bends[row].any(axis=0)).tolist()
        like = [form.places for form in shared if form.name == shared[row - own].name]
        known = all(places[axis] is not None and places[axis] == like[0][axis] for places in like for axis in flat)
        round_ = spheres and np.abs(numbers[row, :6] - (1, 1, 1, 0, 0, 0)).max() <= _DIFFERENT
        settled[row] = known and not round_ and bool((name[near] == name[row]).all())
    return settled


# Planes across an axis


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


# The scene-wide table of surfaces: each distinct plane or quadric once
#
# Surfaces are rounded to float64 records. Exact surfaces (nothing rounded) with records equal to the bit are one
# surface. Where records are merely close, the exact names (`key`, 3000-bit arithmetic) decide: surfaces written twice,
# scaled, negated, or reached by different motions that are equal on paper become one. The record that represents a
# class, and so its anchor, does not depend on the order in which the surfaces were added.

# Relative tolerance of the search for bulk balls that may equal another surface
_NEARLY = 1e-6
_CHUNK = 1 << 13


@dataclass
class SurfaceTable:
    """The finished table of surfaces; for each input surface its id there and its sense (+1 or -1).

    With `rank`, that of `InputSurfaces`, ids and senses are those of leads.
    """

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
    rank: Ints | None = None
    turned: Signs | None = None  # -1 where an input surface is its lead negated; None where none is

    def forget_numbers(self) -> None:
        """Release the ids and senses of the input surfaces."""
        self.ids, self.senses, self.rank, self.turned = self.ids[:0].copy(), self.senses[:0].copy(), None, None


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
    exact: SurfaceSubset
    repeated: Longs | None = None
    """For each surface one that is equal because of how its body is made: itself, or an earlier one.

    Of the body, or of another that has the same primitive."""
    shared: Sequence[SharedForm] = ()
    """The last forms of quadrics."""
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

    def name(self, index: int, primitives: Primitives | None = None) -> tuple[Key, int]:
        """Return the exact name of a surface, and its sense."""
        ...

    def known_names(self, surfaces: Longs, clusters: Longs, primitives: Primitives | None) -> Longs:
        """Return numbers >= 0 that close surfaces have in common only if they are certainly equal; -1 for no number."""
        ...


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
        kind, row = mapped_zeros(count, np.int8), mapped_zeros(count, np.int32)
        kind[:single], kind[single:] = kinds, SPHERE
        every = np.arange(count, dtype=np.int32)
        np.add(every, np.int32(len(raw.spheres) - single), out=row)
        for k in (PLANE, SPHERE, QUADRIC):
            member = kinds == k
            row[:single][member] = every[: int(member.sum())]
        first = every.copy()
        if raw.repeated is not None:
            first[:single] = raw.repeated
        # Of those that are no bulk balls
        plain, alone = raw.plain, np.zeros(single, bool)
        is_fresh = plain & (first[:single] == every[:single])
        unique = settled_forms(quadrics.forms, raw.shared, len(all_spheres) > 0)
        if unique.any():
            alone[kinds == QUADRIC] = unique[quadrics.form_of]
            is_fresh &= ~alone
        for k, table in ((PLANE, planes), (SPHERE, all_spheres), (QUADRIC, quadrics)):
            members: Any = np.flatnonzero(kinds == k)
            fresh = is_fresh[members]
            members = members[fresh] if len(members) else every[:0]
            if k == SPHERE and self.ball_count:
                members = np.concatenate([members, every[single:]]) if len(members) else every[single:]
                fresh = np.concatenate([fresh, np.ones(self.ball_count, bool)])
            if not fresh.all():
                table = table.select(fresh) if isinstance(table, QuadricTable) else table[fresh]
            _merge_equal(first, members, table)
        if not np.array_equal(first, every):
            first = first[first]
        # Planes across the axes are compared without exact names, which take about a millisecond each.
        flat = np.flatnonzero((kinds == PLANE) & plain)
        settled = _merge_across_axes(first, flat, row, planes)
        senses = np.ones(count, np.int8)
        senses[:single] = raw.senses
        self._merge_exact(first, senses, kind, row, planes, all_spheres, quadrics, settled, alone)
        # Number the representatives in input order.
        leads = first == every
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
        alone: npt.NDArray[np.bool_],
    ) -> None:
        """Merge close records by their exact names.

        `settled` counts the planes that are already compared; quadrics that are `alone` certainly equal no other.
        """
        distinct = np.flatnonzero((first[: self.single] == np.arange(self.single)) & ~alone)
        is_flat, rest = kind[distinct] == PLANE, self.raw.rest
        flat, curved = distinct[is_flat], distinct[~is_flat]
        found = [find_clusters(flat, PlaneFeatures.of(row[flat], planes, rest.planes))] if len(flat) > settled else []
        if len(curved):  # bulk balls are equal to each other to the bit or not at all
            curved = np.concatenate([curved, self._balls_near(curved, first, kind, row, spheres, quadrics)])
            features = CurvedFeatures.of(kind[curved], row[curved], spheres, quadrics, rest.quadrics)
            found.append(find_clusters(curved, features))
        if not any(len(sizes) for _, sizes in found):
            return
        candidates, sizes = (np.concatenate(parts) for parts in zip(*found, strict=True))
        cluster, begin = np.repeat(np.arange(len(sizes)), sizes), np.cumsum(sizes) - sizes
        is_own = candidates < self.single
        names = -1 - np.arange(len(candidates))  # until a surface has a name, it has none in common with others
        known = self.exact.known_names(candidates[is_own], cluster[is_own])
        names[is_own] = np.where(known < 0, names[is_own], known)
        rank = _record_ranks(candidates, kind, row, {PLANE: planes, SPHERE: spheres, QUADRIC: quadrics})
        representative, turned = np.arange(len(first)), np.ones(len(first), np.int8)
        # The least record represents a class: this does not depend on the order of input.
        order = np.lexsort((candidates, rank, cluster))
        representative[candidates] = candidates[order[begin]][cluster]
        # Of most clusters, all surfaces have one name
        for number in np.flatnonzero(np.logical_or.reduceat(names != names[begin][cluster], begin)).tolist():
            own = slice(begin[number], begin[number] + sizes[number])
            ranks = dict(zip(candidates[own].tolist(), rank[own].tolist(), strict=True))
            equal: dict[Any, list[tuple[int, int]]] = {}
            for some in positions_by_key(names[own].tolist()).values():
                indices = candidates[own][some].tolist()
                key, sense = self._name(indices[0], spheres, row)
                equal.setdefault(key, []).extend((index, sense) for index in indices)
            for members in equal.values():
                lead, its_sense = min(members, key=lambda member: (ranks[member[0]], member[0]))
                for index, sense in members:
                    representative[index] = lead
                    turned[index] = 1 if kind[index] == PLANE else sense * its_sense
        # Redirect every surface that pointed at a merged one.
        senses *= turned[first]
        first[:] = representative[first]

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
        mixed, rows, columns = row_hashes(table.forms)[table.form_of], table.rows, 3
    else:
        mixed, rows, columns = np.zeros(len(table), np.uint64), table, table.shape[1]
    words = np.ascontiguousarray(rows).view(np.int64)
    run_rows(mix_rows, (words, columns), len(words), mixed.view(np.int64))
    return mixed


@kernel(words="n c", columns="0..c", begin="0..end", end="0..n", mixed="out n")
def mix_rows(words: Longs, columns: int, begin: int, end: int, mixed: Longs) -> None:
    """Mix the bits of the first columns of rows begin..end into their hashes."""
    for i in range(begin, end):
        found = np.uint64(mixed[i])
        for k in range(columns):
            # The bits of -0.0 count as those of 0.0
            word = np.uint64(words[i, k])
            found ^= word if word != _NEGATIVE_ZERO else np.uint64(0)
            found *= _MIXER
            found ^= found >> np.uint64(29)
        mixed[i] = np.int64(found)


_NEGATIVE_ZERO, _MIXER = np.uint64(1 << 63), np.uint64(0x9E3779B97F4A7C15)


def _record_ranks(surfaces: Longs, kind: Signs, row: Ints, tables: dict[int, Floats | QuadricTable]) -> Longs:
    """Rank surfaces by their records, spheres before other quadrics; equal records have equal ranks."""
    ranks = np.empty(len(surfaces), np.int64)
    for own, table in tables.items():
        some = np.flatnonzero(kind[surfaces] == own)
        records = table[row[surfaces[some]]]
        order = np.lexsort(records.T[::-1])
        changes = (records[order[1:]] != records[order[:-1]]).any(axis=1)
        ranks[some[order[:1]]], ranks[some[order[1:]]] = 0, np.cumsum(changes)
        ranks[some] += (own != SPHERE) * len(surfaces)
    return ranks


def _merge_equal(first: Any, members: Any, table: Floats | QuadricTable) -> None:
    """Point each member at the earliest one with a record equal to the bit, zeros of both signs alike."""
    hashes = row_hashes(table)
    known = np.sort(hashes)
    # Most tables have no equal rows, and numbers are sorted several times as fast as places
    if not (known[1:] == known[:-1]).any():
        return
    order = np.argsort(hashes, kind="stable")
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
    put_first_across_axes(planes, row[members], axes, places, np.argsort(places).astype(np.int64), least)
    others = np.flatnonzero(least != np.arange(len(members)))
    if len(others):
        first[members[others]] = members[least[others]]
        first[:] = first[first]
    return len(members) - len(others)
