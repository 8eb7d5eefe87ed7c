"""Splice the tables of two scenes: rows that stay are copied, and the numbers in them are shifted."""

from __future__ import annotations

from abc import ABC, abstractmethod
from typing import Any

import numpy as np

from ..._util.records import dataclass
from ...kernels.tables import PLANE, QUADRIC, SPHERE, Ints, Longs, Signs, Tables
from ..row_layout import (
    BALL_FRAMES,
    BALLS,
    BODIES,
    CELL_PLANES,
    CELLS,
    CORNERS,
    FACES,
    GATES,
    KINDS,
    LEAVES,
    MAP_ROWS,
    PLANES,
    POLYGONS,
    PROGRAMS,
    QUADRICS,
    SHEETS,
    SPHERES,
    SURFACES,
    RowLayout,
)
from .scene_splice import SceneSplice, SplicePieces
from .surface_merge import MergedSurfaces

PLAIN = {
    "planes": PLANES, "quadrics": QUADRICS, "quadric_forms": QUADRICS,
    "leaf_negated": LEAVES,
    "leaf_sense": LEAVES, "leaf_bounds": LEAVES, "gate_need": GATES, "gate_negated": GATES, "gate_start": GATES,
    "sheet_one_sided": SHEETS, "vertices": CORNERS, "ball_frames": BALL_FRAMES,
    "plane_limits": PLANES, "quadric_limits": QUADRICS, "cell_limits": CELLS, "program_limits": PROGRAMS,
    "sheet_limits": SHEETS, "polygon_limits": POLYGONS,
}  # fmt: skip
"""Columns without numbers of other rows, except those of forms in `quadrics`: each quadric has a form of its own."""
COUNTS = {
    "leaf_cell": (LEAVES, CELLS), "leaf_gate": (LEAVES, GATES), "gate_parent": (GATES, GATES),
    "sheet_program": (SHEETS, PROGRAMS), "polygon_program": (POLYGONS, PROGRAMS),
}  # fmt: skip
"""Columns of numbers of rows of another kind, or -1."""
BEGINS = {
    "cell_first": (CELLS, CELL_PLANES), "program_leaf": (PROGRAMS, LEAVES), "program_gate": (PROGRAMS, GATES),
    "polygon_first": (POLYGONS, CORNERS),
}  # fmt: skip
"""Columns of the first rows of another kind; one more item says where these end."""
SURFACE = {"cell_quadric": CELLS, "plane_surface": CELL_PLANES, "sheet_surface": SHEETS, "polygon_surface": POLYGONS}
SIDES = {"cell_face": "cell_quadric", "plane_face": "plane_surface", "sheet_side": "sheet_surface",
         "polygon_side": "polygon_surface"}  # fmt: skip
"""`SURFACE`: columns of surfaces. `SIDES`: columns of the sides of these, or of numbers with the signs of sides."""
AXES = {PLANE: PLANES, SPHERE: SPHERES, QUADRIC: QUADRICS}
ENTRIES = ("entry_kind", "entry_index", "body_face")
INSTANCE_COLUMNS = ("cell_likes", "program_row", "program_shifts", "shifts", "body_maps")
"""Columns of translated copies, which are not edited: other scenes have no rows in them."""
OTHERS = ("surface_kind", "surface_row", "spheres", "face_maps", "map_rows", *ENTRIES, *INSTANCE_COLUMNS)
TREES = ("node_boxes", "node_children", "tree_order", "tree_root", "roots", "tree_depth", "leaf_items", "extent",
         "cell_groups", "group_bounds", "group_planes")  # fmt: skip


def table_senses(senses: Signs | None, input_senses: Signs, chosen: Any) -> Signs:
    """Return the senses of some surfaces in the table; None for `senses` stands for the input senses."""
    if senses is not None:
        return senses[chosen]
    found = np.ones(len(chosen), np.int8)
    single = chosen < len(input_senses)
    found[single] = input_senses[chosen[single]]
    return found


@dataclass
class SurfaceNumbering:
    """New numbers for the surfaces in the tables of one of two scenes; None: shifted by pieces."""

    ids: Ints | None
    turned: Signs | None  # -1 where the surface is negated there; None: nowhere


class TableFiller(ABC):
    """Fills tables from pieces of two scenes; subclasses supply surfaces and entries."""

    def __init__(
        self,
        splice: SceneSplice,
        pieces: SplicePieces,
        layout: RowLayout,
        numbers: tuple[SurfaceNumbering, SurfaceNumbering],
    ) -> None:
        """Prepare to fill.

        `layout` is that of the new scene; `numbers` renumber in it the surfaces of each of the two scenes.
        """
        self.splice, self.pieces, self.layout, self.numbers = splice, pieces, layout, numbers
        self.numbered_pieces = pieces  # the pieces in which surface numbers are written

    @property
    def ids(self) -> Ints | None:
        """The number in the table of each input surface; None if each keeps its own."""
        return self.layout.ids

    @abstractmethod
    def _put_surfaces(self, tables: Tables) -> None:
        """Write kinds and rows of the surfaces, and the spheres."""

    @abstractmethod
    def _put_entries(self, tables: Tables) -> None:
        """Write the entries that the tree holds."""

    def fill(self, tables: Tables) -> None:
        """Write all columns but those of the trees; a `LimitsUpdate` corrects the limits afterwards."""
        sides = [side.tables for side in self.splice.sides]
        for name, axis in PLAIN.items():
            self._copy(getattr(tables, name), axis, [getattr(side, name) for side in sides])
        self._count(tables.quadrics[:, 3], QUADRICS, QUADRICS, [side.quadrics[:, 3] for side in sides])
        for name, (axis, beside) in COUNTS.items():
            self._count(getattr(tables, name), axis, beside, [getattr(side, name) for side in sides])
        for name, (axis, beside) in BEGINS.items():
            column = getattr(tables, name)
            self._count(column[:-1], axis, beside, [getattr(side, name)[:-1] for side in sides])
            column[-1] = self.pieces.total[beside]
        for name, axis in SURFACE.items():
            self._refer(getattr(tables, name), axis, [getattr(side, name) for side in sides])
        for name, of in SIDES.items():
            self._turn(tables, name, of)
        self._put_maps(tables, sides)
        self._put_surfaces(tables)
        self._put_entries(tables)

    def _put_maps(self, tables: Tables, sides: list[Tables]) -> None:
        """Write the maps of faces."""
        self._copy(tables.map_rows, MAP_ROWS, [side.map_rows for side in sides])
        for source, faces, at, shift in self.pieces.moved(FACES, MAP_ROWS):
            rows = sides[source].face_maps[faces]
            tables.face_maps[at] = np.where(rows < 0, rows - shift, rows + shift) if shift else rows

    def _copy(self, column: Any, axis: int, sides: list[Any]) -> None:
        for source, rows, at in self.pieces.on(axis):
            column[at] = sides[source][rows]

    def _count(self, column: Any, axis: int, beside: int, sides: list[Any]) -> None:
        for source, rows, at, shift in self.pieces.moved(axis, beside):
            numbers = sides[source][rows]
            column[at] = np.where(numbers < 0, numbers, numbers + shift) if shift else numbers

    def _refer(self, column: Ints, axis: int, sides: list[Ints]) -> None:
        for source, rows, at, shift in self.numbered_pieces.moved(axis, SURFACES):
            numbers, ids = sides[source][rows], self.numbers[source].ids
            if ids is not None:
                np.take(ids, numbers, out=column[at], mode="wrap")  # -1 wraps to the last item, which is -1
            else:
                column[at] = np.where(numbers < 0, numbers, numbers + shift) if shift else numbers

    def _turn(self, tables: Tables, name: str, of: str) -> None:
        """Write the sides of surfaces that may have been negated."""
        column = getattr(tables, name)
        for source, rows, at in self.pieces.on(SURFACE[of]):
            side, turned = self.splice.sides[source].tables, self.numbers[source].turned
            column[at] = getattr(side, name)[rows]
            if turned is not None:
                column[at] *= turned[getattr(side, of)[rows]]

    def framed(self, column: Ints, beside: int, sides: list[Ints]) -> None:
        """Write a column of bodies with numbers of another kind, or -1 - k for frame k of bulk balls."""
        parts = zip(self.pieces.moved(BODIES, beside), self.pieces.moved(BODIES, BALL_FRAMES), strict=True)
        for (source, rows, at, shift), (_, _, _, frames) in parts:
            numbers = sides[source][rows]
            column[at] = np.where(numbers < 0, numbers - frames, numbers + shift) if shift or frames else numbers


class ColumnSplice(TableFiller):
    """Fills the tables of a spliced scene."""

    def __init__(self, splice: SceneSplice, merged: MergedSurfaces) -> None:
        self.splice, self.merge_result = splice, merged
        self.leads = None if merged.first is None else np.flatnonzero(merged.first == np.arange(merged.count))
        ids = self._ids()
        numbers = self._numbers(ids, 0), self._numbers(ids, 1)
        super().__init__(splice, splice.pieces, self._build_layout(ids), numbers)

    def _build_layout(self, ids: Ints | None) -> RowLayout:
        """Build the layout of the new scene."""
        (old, new), merged = self.splice.layouts, self.merge_result
        patterns, numbers = old.patterns.union(new.patterns)
        which = self.splice.of_both(BODIES, old.which, numbers[new.which])
        bodies = self.splice.of_entries(old.first_body, new.first_body)
        frames = self.splice.of_entries(old.first_frame, new.first_frame)
        surfaces = merged.kinds, merged.input_senses, merged.senses, merged.first
        return RowLayout(patterns, which, bodies, frames, *surfaces, ids)

    @property
    def surfaces(self) -> int:
        """How many surfaces the table has."""
        return self.merge_result.count if self.leads is None else len(self.leads)

    @property
    def single(self) -> Longs:
        """See `ExactTables.single`."""
        single = int(self.pieces.total[SURFACES])
        return np.arange(single) if self.leads is None else self.leads[self.leads < single]

    def _ids(self) -> Ints | None:
        """Return the number in the table of each input surface; None where each is its own."""
        if self.leads is None or self.merge_result.first is None:
            return None
        number = np.zeros(self.merge_result.count, np.int32)
        number[self.leads] = np.arange(len(self.leads), dtype=np.int32)
        return number[self.merge_result.first]

    def _numbers(self, own: Ints | None, source: int) -> SurfaceNumbering:
        """Return the new numbers of the surfaces of one scene's table."""
        laid, numbers = self.splice.layouts[source], self.splice.numbers_of_surfaces(source)
        if own is None and laid.ids is None:
            return SurfaceNumbering(None, None)
        there = np.flatnonzero(numbers >= 0)
        before = there if laid.ids is None else laid.ids[there]
        count = len(numbers) if laid.ids is None else int(laid.ids.max(initial=-1)) + 1
        ids = np.full(count + 1, -1, np.int32)
        ids[before] = numbers[there] if own is None else own[numbers[there]]
        turned = np.ones(count + 1, np.int8)
        turned[before] = table_senses(laid.senses, laid.input_senses, there)
        turned[before] *= table_senses(self.merge_result.senses, self.merge_result.input_senses, numbers[there])
        return SurfaceNumbering(ids, None if (turned == 1).all() else turned)

    def sizes(self) -> dict[str, tuple[tuple[int, ...], Any]]:
        """Return shape and dtype of every column but those of the trees."""
        total, old = self.pieces.total.tolist(), self.splice.sides[0].tables
        axes = PLAIN | {name: axes[0] for name, axes in COUNTS.items()} | SURFACE
        axes |= {name: SURFACE[of] for name, of in SIDES.items()} | dict.fromkeys(ENTRIES, BODIES)
        counts = {name: total[axis] for name, axis in axes.items()}
        counts |= {name: total[axes[0]] + 1 for name, axes in BEGINS.items()}
        counts |= dict(surface_kind=self.surfaces, surface_row=self.surfaces, spheres=total[SPHERES] + total[BALLS])
        counts |= dict(face_maps=total[FACES], map_rows=total[MAP_ROWS], **dict.fromkeys(INSTANCE_COLUMNS, 0))
        return {
            name: ((count, *getattr(old, name).shape[1:]), getattr(old, name).dtype) for name, count in counts.items()
        }

    def _put_surfaces(self, tables: Tables) -> None:
        """Write kinds and rows of the surfaces, and the spheres, bulk balls last."""
        tables.spheres[:] = self.splice.of_spheres(*(side.tables.spheres for side in self.splice.sides))
        if self.leads is None and all(laid.first is None for laid in self.splice.layouts):
            self._move_surfaces(tables)
            return
        total = self.pieces.total
        kinds, count = self.merge_result.kinds, self.merge_result.count
        kind, row = np.full(count, SPHERE, np.int8), np.arange(count, dtype=np.int32)
        kind[: len(kinds)] = kinds
        for which in (PLANE, SPHERE, QUADRIC):
            mine = np.flatnonzero(kinds == which)
            row[mine] = np.arange(len(mine), dtype=np.int32)
        row[len(kinds) :] += np.int32(total[SPHERES] - total[SURFACES])
        tables.surface_kind[:] = kind if self.leads is None else kind[self.leads]
        tables.surface_row[:] = row if self.leads is None else row[self.leads]

    def _move_surfaces(self, tables: Tables) -> None:
        """Write kinds and rows where every surface stands for itself: those of both, rows of each kind shifted."""
        single, total = len(self.merge_result.kinds), self.pieces.total
        of_kinds = [self.pieces.moved(SURFACES, AXES[kind]) for kind in sorted(AXES)]
        for (source, rows, at, _), *others in zip(of_kinds[0], *of_kinds, strict=True):
            side = self.splice.sides[source].tables
            shifts = np.array([shift for *_, shift in others], np.int32)
            tables.surface_kind[at] = side.surface_kind[rows]
            tables.surface_row[at] = side.surface_row[rows]
            if shifts.any():
                tables.surface_row[at] += shifts[side.surface_kind[rows]]
        tables.surface_kind[single:] = SPHERE
        tables.surface_row[single:] = np.arange(total[SPHERES], len(tables.spheres), dtype=np.int32)

    def _put_entries(self, tables: Tables) -> None:
        """Write the entries; `replace_ball_cells` decides afterwards which cells are balls."""
        which = self.layout.which
        kind, index, _ = self.layout.patterns.entries[which].T.copy()
        for own, axis in KINDS.items():
            mine = np.flatnonzero(kind == own)
            if len(mine):
                index[mine] += self.layout.starts(axis)[mine]
        balls = np.flatnonzero(which == 0)
        numbers = np.arange(len(self.merge_result.kinds), self.merge_result.count)
        index[balls] = numbers if self.ids is None else self.ids[numbers]
        tables.entry_kind[:], tables.entry_index[:] = kind, index
        sides = [side.tables.body_face for side in self.splice.sides]
        self.framed(tables.body_face, FACES, sides)
