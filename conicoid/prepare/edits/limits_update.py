"""Update the limits of an edited scene: those of new bodies, and of surfaces whose uses changed.

The limits of most scenes are corrected where rows of tables came or went. Those of scenes with instances, whose rows
are shared, are corrected body by body.
"""

from __future__ import annotations

from abc import ABC, abstractmethod
from collections.abc import Mapping
from typing import Any, TypeAlias

import numpy as np
import numpy.typing as npt

from ..._util.arrays import unique_sorted, unique_with_inverse
from ..._util.records import dataclass
from ...kernels.programs import cells_of_leaves, leaves_of_program
from ...kernels.surface.doubt import KAPPA
from ...kernels.tables import BALL, CELL, PLANE, QUADRIC, REGION, SPHERE, Floats, Longs, Tables
from ..error_limits import (
    LimitMaxima,
    RecordTables,
    compute_limits,
    no_limits,
    program_limits,
    put_limits_of_planes,
    put_limits_of_quadrics,
    scene_size,
    size_of_records,
    weigh_all,
    with_limits,
)
from ..row_layout import CELLS, POLYGONS, SHEETS, RowLayout
from ..surface_features import Remainders
from .buffer_pool import TableRows, UneditableError
from .column_splice import ColumnSplice, TableFiller

Mask = npt.NDArray[np.bool_]


@dataclass
class SurfaceUses:
    """Pairs of a surface and a cell, sheet or polygon that it bounds, with the body.

    Sheets and polygons are numbered behind cells.
    """

    surfaces: Longs
    owners: Longs
    bodies: Longs


@dataclass
class LimitChanges:
    """The surfaces, and the cells, sheets and polygons, whose limits may change, and all uses of and by these."""

    surfaces: Mask
    owners: Mask
    uses: SurfaceUses


class LimitsUpdate(ABC):
    """Corrects the limits in tables that are otherwise finished."""

    def __init__(self, columns: TableFiller, tables: Tables, boxes: Floats, rest: Remainders) -> None:
        self.columns, self.tables, self.boxes, self.rest = columns, tables, boxes, rest
        self.layout: RowLayout = columns.layout
        counts = len(tables.cell_quadric), len(tables.sheet_surface), len(tables.polygon_surface)
        self.owners = np.cumsum([0, *counts])

    def put(self, before: float | None) -> float | None:
        """Write the limits; return the size of this scene, `before` being that of the scene before.

        None stands for the size of scenes whose bodies are all bounded: nothing depends on it.
        """
        size = None if bool(np.isfinite(self.boxes).all()) else scene_size(self.tables, self.boxes)
        # Every limit of an unbounded body depends on the size of the scene.
        if size is not None and before is not None and size != before:
            for name, column in with_limits(self.tables, self.boxes, self.rest)._asdict().items():
                if name.endswith("_limits"):
                    getattr(self.tables, name)[:] = column
            return size
        self._put(self._find_changes(), size or 1.0)
        return size

    @abstractmethod
    def _find_changes(self) -> LimitChanges:
        """Return what may have other limits than those in the tables."""

    @abstractmethod
    def _unread(self, kind: int) -> Longs:
        """Return the rows of records of a kind that have limits although another record represents them."""

    def _mark_owners(self, surfaces: Mask, owners: Mask) -> None:
        """Mark the cells, sheets and polygons that some surfaces bound."""
        tables, marked = self.tables, np.append(surfaces, False)  # the last item stands for no surface
        for kind, column in enumerate((tables.cell_quadric, tables.sheet_surface, tables.polygon_surface)):
            owners[self.owners[kind] : self.owners[kind + 1]] |= marked[column]
        owners[_owner(tables.cell_first, np.flatnonzero(marked[tables.plane_surface]))] = True

    def _uses(self, surfaces: Mask, owners: Mask) -> SurfaceUses:
        """Collect all uses of some surfaces, and by some owners."""
        tables, marked = self.tables, np.append(surfaces, False)  # the last item stands for no surface
        cells = np.flatnonzero(marked[tables.cell_quadric] | owners[: self.owners[1]])
        planes = marked[tables.plane_surface]
        own = np.flatnonzero(owners[: self.owners[1]])
        planes[_ranges(tables.cell_first, own)] = True
        others = [
            np.flatnonzero(marked[column] | owners[self.owners[kind] : self.owners[kind + 1]])
            for column, kind in ((tables.sheet_surface, 1), (tables.polygon_surface, 2))
        ]
        return self._of_rows(cells, np.flatnonzero(planes), *others)

    def _of_rows(self, cells: Longs, rows: Longs, sheets: Longs, polygons: Longs) -> SurfaceUses:
        """Collect the uses by cells of their quadrics, by cells of planes, by sheets and by polygons."""
        tables = self.tables
        cells = cells[tables.cell_quadric[cells] >= 0]
        found = [
            (tables.cell_quadric[cells], cells, CELLS),
            (tables.plane_surface[rows], _owner(tables.cell_first, rows), CELLS),
        ]
        found.append((tables.sheet_surface[sheets], sheets, SHEETS))
        found.append((tables.polygon_surface[polygons], polygons, POLYGONS))
        parts = []
        for kind, (of, owner, axis) in zip((0, 0, 1, 2), found, strict=True):
            body = np.searchsorted(self.layout.starts(axis), owner, side="right") - 1 if len(owner) else owner
            # Cells that are balls are traced without their cell: they need no limits.
            traced = tables.entry_kind[body] != BALL if axis == CELLS else np.ones(len(owner), bool)
            parts.append((of[traced], owner[traced] + self.owners[kind], body[traced]))
        return SurfaceUses(*(np.concatenate(each) for each in zip(*parts, strict=True)))

    def _put(self, changed: LimitChanges, size: float) -> None:
        tables, rest, surfaces, owners, uses = self.tables, self.rest, changed.surfaces, changed.owners, changed.uses
        surface, owner, users = uses.surfaces, uses.owners, uses.bodies
        records = RecordTables.of(tables, rest)
        (place, at_owner), (which, at_surface) = (unique_with_inverse(each) for each in (owner, surface))
        of_owners, most = no_limits(len(place)), np.zeros((3, len(which)))
        in_order = surface, at_surface, at_owner, users
        weigh_all(records, self.boxes, size, in_order, of_owners, most)
        for kind, column in enumerate((tables.cell_limits, tables.sheet_limits, tables.polygon_limits)):
            first, last = self.owners[kind], self.owners[kind + 1]
            column[owners[first:last]] = 0.0, np.inf
            mine = (place >= first) & (place < last)
            # Other owners were weighed only for the surfaces that they share: their own limits stay
            mine[mine] = owners[place[mine]]
            column[place[mine] - first] = of_owners[mine]
        self._put_programs(owners)
        for kind, column, put in (
            (PLANE, tables.plane_limits, put_limits_of_planes),
            (QUADRIC, tables.quadric_limits, put_limits_of_quadrics),
        ):
            column[self._unread(kind)] = 0.0
            mine = np.flatnonzero(surfaces[which] & (tables.surface_kind[which] == kind))
            put(records, which[mine].astype(np.int32), np.ascontiguousarray(most[:, mine]), column)

    def _put_programs(self, owners: Mask) -> None:
        """Update the programs of cells whose limits changed."""
        tables = self.tables
        leaves = np.flatnonzero(owners[tables.leaf_cell])
        programs = unique_sorted(_owner(tables.program_leaf, leaves))
        if not len(programs):
            return
        rows = _ranges(tables.program_leaf, programs)
        each = np.repeat(np.arange(len(programs)), np.diff(tables.program_leaf)[programs])
        tables.program_limits[programs] = program_limits(
            each, tables.cell_limits[tables.leaf_cell[rows]], len(programs)
        )


class SpliceLimits(LimitsUpdate):
    """Limits of a spliced scene, in which surfaces may be used in other places than before."""

    columns: ColumnSplice

    def __init__(self, columns: ColumnSplice, tables: Tables, boxes: Floats, rest: Remainders) -> None:
        super().__init__(columns, tables, boxes, rest)

    def put(self, before: float | None) -> float | None:
        """`LimitsUpdate.put`; computes the size of a scene before that was never edited."""
        old = self.columns.splice.sides[0]
        if before is None and not np.isfinite(old.boxes).all():
            before = scene_size(old.tables, old.boxes)
        return super().put(before)

    def _find_changes(self) -> LimitChanges:
        surfaces, owners = self._marked()
        return LimitChanges(surfaces, owners, self._uses(surfaces, owners))

    def _marked(self) -> tuple[Mask, Mask]:
        """Mark surfaces with other uses than before, and cells, sheets and polygons that need a check of their own."""
        columns, pieces = self.columns, self.columns.pieces
        surfaces, owners = np.zeros(columns.surfaces, bool), np.zeros(int(self.owners[-1]), bool)
        for source, side in enumerate(columns.splice.sides):
            numbers = columns.splice.numbers_of_surfaces(source)
            ids, laid = columns.numbers[source].ids, side.layout
            if source == 1:
                new = numbers[numbers >= 0]
                surfaces[new if columns.ids is None else columns.ids[new]] = True
                continue
            gone = np.flatnonzero(numbers < 0)
            surface_ids = gone if laid.ids is None else laid.ids[gone]
            if ids is None:
                continue  # each surface of that side stands for itself: nobody else used them
            left = ids[surface_ids]
            surfaces[left[left >= 0]] = True
            surfaces[self._of_other_records()] = True
        first = [pieces.on(axis) for axis in (CELLS, SHEETS, POLYGONS)]
        for kind, parts in enumerate(first):
            for source, _, at in parts:
                if source == 1:
                    owners[self.owners[kind] + at.start : self.owners[kind] + at.stop] = True
        moved = np.zeros(columns.surfaces, bool)
        moved[self._of_other_records()] = True
        if moved.any():
            self._mark_owners(moved, owners)
            surfaces |= moved
        return surfaces, owners

    def _of_other_records(self) -> Longs:
        """Find surfaces of the scene before that another record represents now."""
        columns, laid = self.columns, self.columns.splice.layouts[0]
        if columns.leads is None and laid.first is None:
            return np.zeros(0, np.int64)
        numbers = columns.splice.numbers_of_surfaces(0)
        there = np.flatnonzero(numbers >= 0)
        before = there if laid.first is None else laid.first[there]
        now = numbers[there] if columns.merge_result.first is None else columns.merge_result.first[numbers[there]]
        other = numbers[before] != now
        found = now[other]
        return unique_sorted(found if columns.ids is None else columns.ids[found]).astype(np.int64)

    def _unread(self, kind: int) -> Longs:
        """Return the rows of records of a kind that others represent."""
        first, kinds = self.columns.merge_result.first, self.columns.merge_result.kinds
        if first is None:
            return np.zeros(0, np.int64)
        members = np.flatnonzero(kinds == kind)
        return np.flatnonzero(first[members] != members)


def _owner(first: npt.NDArray[np.int32], rows: Longs) -> Longs:
    """Return the owners of rows, given where the rows of each owner begin."""
    return np.searchsorted(first, rows, side="right") - 1


def _ranges(first: npt.NDArray[np.int32], which: Longs) -> Longs:
    """Return all rows of some owners, given where the rows of each owner begin."""
    parts = [np.arange(first[one], first[one + 1]) for one in which.tolist()]
    return np.concatenate(parts) if parts else np.zeros(0, np.int64)


# Scenes with instances


SurfaceReaches: TypeAlias = dict[tuple[int, int], Floats]
"""(kind, row of limits) of a surface -> its column in `LimitMaxima`, of one body alone."""
Uses: TypeAlias = tuple[Longs, Longs]
"""Surfaces, and for each the position of the cell that it bounds among those of a body."""
_NEAR = 1e-12


@dataclass
class BodyCells:
    """The cells of a body, the places of their planes, and for each of these the position of its cell."""

    cells: Longs
    planes: Longs
    owners: Longs

    @classmethod
    def of(cls, tables: Tables, entry: int) -> BodyCells:
        """Find the cells of an entry."""
        kind, index = int(tables.entry_kind[entry]), int(tables.entry_index[entry])
        if kind == REGION:
            cells = cells_of_leaves(tables, np.array(leaves_of_program(tables, index), np.int64))
        else:
            cells = np.flatnonzero(tables.cell_quadric == index) if kind == BALL else np.array([index])
            if kind not in (BALL, CELL) or len(cells) != 1:
                raise UneditableError
        counts = tables.cell_first[cells + 1] - tables.cell_first[cells]
        return cls(cells, _ranges(tables.cell_first, cells), np.repeat(np.arange(len(cells)), counts))

    def uses(self, rows: TableRows) -> Uses:
        """List all uses of surfaces by the body."""
        quadrics = rows["cell_quadric"][self.cells]
        curved = np.flatnonzero(quadrics >= 0)
        found = np.concatenate([quadrics[curved], rows["plane_surface"][self.planes]])
        return found, np.concatenate([curved, self.owners])


class LatticeLimits:
    """Limits of a scene with instances: those by the bodies of its large tree, widened by those of the small one."""

    def __init__(
        self, rows: TableRows, maxima: LimitMaxima, uses: dict[int, SurfaceReaches], shared: tuple[int, int]
    ) -> None:
        """`uses` and `shared` are those of `LatticeState`."""
        self.rows, self.maxima, self.uses, self.shared = rows, maxima, uses, shared
        self.are_invalid = False  # they must be computed from all bodies again

    def remove_uses(self, entry: int, uses: Uses, body: BodyCells, box: Floats, alike: bool, vanish: set[int]) -> None:
        """Take the uses of a body back, or see whether it has set a limit.

        `alike` bodies share rows with translated copies; the surfaces `vanish` are those of the body alone.
        """
        rows = self.rows
        ids, records, most, limits = self._weigh(uses, len(body.cells), box)
        if self.uses.pop(entry, None) is not None:
            self._put(ids, records)
            return
        self.are_invalid |= bool(self.maxima.size and _largest(records, box) >= self.maxima.size)
        for k, surface in enumerate(ids.tolist()):
            kind, row = self._limit_row(surface)
            if kind == SPHERE or (surface in vanish and (kind == PLANE or not alike)):
                continue
            column = self.maxima.column(kind, row)
            # A kappa of its own depends on the reach, in quadrics with a rounded anchor
            self.are_invalid |= bool(most[0, k] >= column[0] * (1 - _NEAR))
            self.are_invalid |= bool(kind == QUADRIC and most[1, k] > KAPPA and most[1, k] >= column[1] * (1 - _NEAR))
        if alike:
            known = rows["cell_limits"][rows["cell_likes"][body.cells] >> 1]
            self.are_invalid |= bool((limits[:, 0] >= known[:, 0] * (1 - _NEAR)).any())
            self.are_invalid |= bool((limits[:, 1] <= known[:, 1] * (1 + _NEAR)).any())

    def add_uses(self, entry: int, uses: Uses, count: int, box: Floats) -> Floats:
        """Widen the limits of the surfaces of a body of the small tree; return those of its cells."""
        ids, records, most, limits = self._weigh(uses, count, box)
        if self.maxima.size and _largest(records, box) > self.maxima.size:
            raise UneditableError
        self.uses[entry] = {self._limit_row(surface): most[:, k] for k, surface in enumerate(ids.tolist())}
        self._put(ids, records)
        return limits

    def compute_all(self, boxes: Floats, loose: Mapping[int, Floats]) -> None:
        """Compute the limits from all bodies again: first without those of the small tree, which then widen them."""
        tables = self.rows.tables()
        kinds = tables.entry_kind.copy()
        kinds[list(loose)] = -1
        limits, self.maxima = compute_limits(tables._replace(entry_kind=kinds), boxes, self.rows.rest)
        for name, count in zip(("plane", "quadric", "cell", "program"), (None, None, *self.shared), strict=True):
            getattr(tables, f"{name}_limits")[:count] = limits[f"{name}_limits"][:count]
        for entry in list(self.uses):
            body = BodyCells.of(tables, entry)
            self.add_uses(entry, body.uses(self.rows), len(body.cells), loose[entry])

    def _weigh(self, uses: Uses, count: int, box: Floats) -> tuple[Any, RecordTables, Floats, Floats]:
        """Weigh the uses of a body: (its surfaces, their records, the largest reach and the like, limits of cells)."""
        surfaces, owners = uses
        ids, at = unique_with_inverse(surfaces)
        tables = self.rows.tables()
        records = RecordTables.of(
            tables._replace(surface_kind=tables.surface_kind[ids], surface_row=tables.surface_row[ids]), self.rows.rest
        )
        limits, most = no_limits(count), np.zeros((3, len(ids)))
        weigh_all(records, box[None], self.maxima.size or 1.0, (at, at, owners, np.zeros(len(at))), limits, most)
        return ids, records, most, limits

    def _limit_row(self, surface: int) -> tuple[int, int]:
        """Return the kind of a surface and the row of its limits: that of a plane, or of the form of a quadric."""
        kind, row = self.rows.kind_and_row(surface)
        return kind, int(self.rows["quadrics"][row, 3]) if kind == QUADRIC else row

    def _put(self, ids: Longs, records: RecordTables) -> None:
        """Write the limits of surfaces, from the uses by the bodies of both trees."""
        most = np.zeros((3, len(ids)))
        for k, surface in enumerate(ids.tolist()):
            kind, row = self._limit_row(surface)
            if kind != SPHERE:
                columns = [uses[kind, row] for uses in self.uses.values() if (kind, row) in uses]
                most[:, k] = np.max([self.maxima.column(kind, row), *columns], axis=0)
        every = np.arange(len(ids), dtype=np.int32)
        put_limits_of_planes(records, every, most, self.rows["plane_limits"])
        put_limits_of_quadrics(records, every, most, self.rows["quadric_limits"])


def _largest(records: RecordTables, box: Floats) -> float:
    """Return the largest finite length of a body."""
    planes, quadrics = (records.row[records.kind == kind] for kind in (PLANE, QUADRIC))
    anchors = records.quadrics[quadrics].copy()
    forms = records.forms[anchors[:, 3].astype(np.intp)]
    return size_of_records(records.planes[planes], anchors, forms, np.ascontiguousarray(box[None]))
