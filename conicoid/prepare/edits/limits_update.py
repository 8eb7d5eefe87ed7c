"""Update the limits of an edited scene: those of new bodies, and of surfaces whose uses changed."""

from __future__ import annotations

from abc import ABC, abstractmethod

import numpy as np
import numpy.typing as npt

from ..._util.arrays import unique_sorted, unique_with_inverse
from ..._util.dataclass import dataclass
from ...kernels.tables import BALL, PLANE, QUADRIC, Floats, Longs, Tables
from ..error_limits import (
    RecordTables,
    no_limits,
    program_limits,
    put_limits_of_planes,
    put_limits_of_quadrics,
    scene_size,
    weigh_all,
    with_limits,
)
from ..row_layout import CELLS, POLYGONS, SHEETS, RowLayout
from ..surface_features import Remainders
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
