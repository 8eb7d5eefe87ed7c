"""Lay out groups of bodies as the columns of `Tables`: every column of every body at once, in the order of the bodies.

`TablesBuilder` fills surfaces, cells, programs, sheets, polygons, faces, frames and entries. The tree and the limits
come later (`bvh/trees.py`, `error_limits.py`).
"""

from __future__ import annotations

from dataclasses import replace
from functools import cached_property
from typing import Any

import numpy as np

from .._jit.decorators import kernel
from .._util.records import row_ends, unique_first_with_inverse, unique_sorted, unique_with_inverse
from ..kernels.faces import as_bytes, cell_faces
from ..kernels.tables import (
    BALL,
    CELL,
    GROUP_SIZE,
    LINKS,
    MAP_SIZE,
    PLACE_SIZE,
    PLANE,
    POLYGON,
    QUADRIC,
    QUADRIC_SIZE,
    REGION,
    SHEET,
    SHIFT_SIZE,
    SPHERE,
    Floats,
    Ints,
    Longs,
    Signs,
    Tables,
    whole,
)
from ..kernels.threads import run_chunks
from .coincidence import (
    ExactSurfaces,
    InputSurfaces,
    RawSurfaces,
    SharedForm,
    SurfaceSubset,
    SurfaceTable,
    concatenate,
    merge_surfaces,
)  # fmt: skip
from .mmap_arrays import mapped_zeros, own_memory, trim_heap
from .pattern import (
    BOX_NUMBERS,
    FRAME_NUMBERS,
    SIZES,
    BodyGroup,
    BodyGroups,
    BodyPattern,
    BulkBalls,
    FactoredRows,
    Primitives,
    RowPlaces,
    RowTable,
    put_numbers,
    put_shifted_boxes,
    row_blocks,
)
from .surface_features import QuadricTable, Remainders


@kernel(ids="c", senses="c", rank="s", turned="s|0", numbers="out n", found="out n")
def put_ids(ids: Ints, senses: Signs, rank: Ints, turned: Signs, numbers: Ints, found: Signs) -> None:
    """Replace numbers of surfaces by the ids of their leads, and write their senses there; -1 and +1 for none.

    Where `rank` is empty, each surface leads itself.
    """
    for i in range(len(numbers)):
        number = whole(numbers[i])
        at = whole(-1) if len(rank) > 0 else number
        if 0 <= number < len(rank):
            at = whole(rank[number]) if rank[number] >= 0 else whole(-1 - rank[number])
        known = 0 <= at < len(ids)
        numbers[i], found[i] = (ids[at], senses[at]) if known else (-1, 1)
        if known and len(turned) > 0:
            found[i] *= turned[number]


@kernel(begin="n", x="n", y="n", z="n", shifts="3", model="m", rows="out p 4")
def put_program_shifts(
    begin: Ints, number: int, x: Ints, y: Ints, z: Ints, shifts: Longs, model: Ints, rows: Ints
) -> None:
    """Write the rows of `program_shifts` for a program of each body: places along the axes from `shifts` on, model."""
    for i in range(len(begin) if len(model) > 0 else 0):
        at, own = begin[i] + number, model[min(i, len(model) - 1)]
        if 0 <= at < len(rows):
            rows[at, 0], rows[at, 1], rows[at, 2] = x[i] + shifts[0], y[i] + shifts[1], z[i] + shifts[2]
            rows[at, 3] = own + number


@kernel(bodies="n", index="k n", places="out m 4")
def put_map_places(bodies: Ints, first: int, index: Ints, places: Ints) -> None:
    """Write rows of `body_maps`: the first face row, then the numbers from which rows of maps are found."""
    for i in range(len(bodies)):
        if 0 <= bodies[i] < len(places):
            places[bodies[i], 0] = first
            for k in range(min(len(index), 3)):
                places[bodies[i], 1 + k] = index[k, i]


class TableColumns:
    """Columns of one table, filled group by group.

    `kinds` has one letter for each column: "b" for int8, "i" for int32.
    """

    def __init__(self, places: RowPlaces, kinds: str) -> None:
        self.places = places
        self.columns: list[Any] = [mapped_zeros(places.count, np.int8 if kind == "b" else np.int32) for kind in kinds]

    def put(self, group: BodyGroup, rows: Ints, shifts: dict[int, Ints]) -> None:
        """Write the rows of a pattern for each body of a group.

        `shifts` maps a column to the first row of each body in another table: numbers >= 0 in that column count from
        there. Bodies that share their rows have them written once.
        """
        first = self.places.of_group(group)
        shifts = {column: counted[: len(first)] for column, counted in shifts.items()}
        none = np.zeros(1, np.int32)
        for column, (values, numbers) in enumerate(zip(self.columns, rows.T.astype(np.int32, "C"), strict=True)):
            if values.dtype == np.int32:
                put_numbers(first, shifts.get(column, none), numbers, values)
                continue
            for some in row_blocks(len(first), len(rows)):
                values[first[some, None] + np.arange(len(rows))] = numbers

    def signed(self, column: int, senses: Signs) -> Any:
        """Multiply a column by senses in place, and return it."""
        values = self.columns[column]
        values *= senses
        return values


# Affine maps of bodies: from the world to uv of each face, and to a body's local coordinates
#
# Translated copies have few different rows of maps; each is in the table once.

WHICH_BITS = 3
"""Low bits of a number in `face_maps` of translated bodies: the column of `body_maps` that selects the row.

See `kernels/body/uv.py`.
"""


def build_face_maps(contents: BodyGroups, faces: RowPlaces) -> tuple[Ints, Ints, Floats]:
    """Build `Tables.face_maps`, `body_maps` and `map_rows`; rows of bodies with maps of their own come first, in order.

    `faces` gives the rows of `face_maps` of each body.
    """
    groups = contents.groups
    moved = [(group, group.rows) for group in groups if isinstance(group.rows, FactoredRows)]
    own = RowPlaces.of(
        contents, [0 if isinstance(each.rows, FactoredRows) else each.pattern.map_rows for each in groups]
    )
    if moved:
        own_counts = [0 if isinstance(each.rows, FactoredRows) else len(each.pattern.angular) for each in groups]
        faces = RowPlaces.of(contents, own_counts)
    maps, rows = mapped_zeros((faces.count, 3), np.int32), np.empty((own.count, MAP_SIZE))
    for group in groups:
        if isinstance(group.rows, FactoredRows):
            continue
        p, at = group.pattern, own.rows(group, group.pattern.map_rows)
        for some in row_blocks(len(group.bodies)):
            rows[at[some]] = group.rows[some, p.uv_at : p.bounds_at].reshape(*at[some].shape, MAP_SIZE)
        for some in row_blocks(len(group.bodies), len(p.angular)):
            found = (at[some] << WHICH_BITS if moved else at[some])[:, p.maps]
            found[:, p.angular != 0, 0] = -1 - found[:, p.angular != 0, 0]
            maps[faces.first[group.bodies[some], None] + np.arange(len(p.angular))] = found
    if not moved:
        return maps, mapped_zeros((0, PLACE_SIZE), np.int32), rows
    parts, tables, places = [maps], [rows], mapped_zeros((contents.body_count, PLACE_SIZE), np.int32)
    if faces.count:
        places[:, 0] = faces.first
    first, count = faces.count, own.count
    for group, moving in moved:
        p, which = group.pattern, _MapSources()
        numbers: list[Any] = []
        for table, index in _group_maps(moving, range(p.uv_at, p.bounds_at, MAP_SIZE)):
            numbers.append(count << WHICH_BITS | which.of(index))
            tables.append(table)
            count += len(table)
        parts.append(np.array(_number_map_rows(group, numbers), np.int32).reshape(-1, 3))
        index = np.concatenate([each for _, each in which.known]) if which.known else np.zeros(0, np.int32)
        put_map_places(group.bodies, first, index.reshape(-1, len(group.bodies)), places)
        first += len(p.angular)
    return concatenate(parts), places, concatenate(tables)


def _number_map_rows(group: BodyGroup, rows: Any) -> list[list[Any]]:
    """List the map rows of each face, given those of its body; an angular face has -1 - first instead of its first."""
    p = group.pattern
    found = [[rows[row] for row in mine] for mine in p.maps.tolist()]
    for face in np.flatnonzero(p.angular).tolist():
        found[face][0] = -1 - found[face][0]
    return found


def _group_maps(moving: FactoredRows, columns: range) -> list[tuple[Floats, Ints]]:
    """`FactoredRows.maps` of columns. Rows that depend on more than `_MapSources` can number are written per body."""
    found, which = [moving.maps(column) for column in columns], _MapSources()
    try:
        for _, index in found:
            which.of(index)
    except ValueError:
        own = np.arange(len(moving), dtype=np.int32)
        found = [(table[index], own) if index.any() else (table, index) for table, index in found]
    return found


class _MapSources:
    """Number the things that rows of maps depend on, as the columns of `body_maps` do."""

    def __init__(self) -> None:
        self.known: list[tuple[int, Ints]] = []

    def of(self, index: Ints) -> int:
        """Return the column of `body_maps` for this index of rows; 0 where all bodies have the first row.

        Raises ValueError for more than three different ones.
        """
        if not index.any():
            return 0
        for k, known in self.known:
            if known is index or np.array_equal(known, index):
                return k
        if len(self.known) == PLACE_SIZE - 1:
            raise ValueError("the maps of moved bodies depend on more than their places along three axes")
        self.known.append((len(self.known) + 1, index))
        return len(self.known)


def shares_frame(group: BodyGroup) -> bool:
    """Return whether all bodies of a group have the same local coordinates."""
    p = group.pattern
    return isinstance(group.rows, FactoredRows) and all(
        len(group.rows.maps(column)[0]) == 1 for column in range(p.frame_at, p.corners_at, MAP_SIZE)
    )


# Programs: leaves and gates of Boolean bodies
#
# Translated copies share how leaves feed gates, the gates, the boxes around leaves, the numbers of faces, and the
# limits: each is in the tables once.


def program_columns(contents: BodyGroups, programs: RowPlaces, cells: RowPlaces) -> dict[str, Any]:
    """Build the columns of programs, their leaves and gates (`kernels/programs.py`).

    `programs` and `cells` give the rows of each body.
    """
    alike, leaves, gates = (
        RowPlaces.of_copies(contents, [len(getattr(group.pattern, rows)) for group in contents.groups])
        for rows in ("programs", "leaves", "gates")
    )
    counts, leaf, gate = TableColumns(alike, "ii"), TableColumns(leaves, "iibb"), TableColumns(gates, "iibi")
    shares = any(map(_shares_topology, contents.groups))
    first = TableColumns(programs, "i")
    for group in contents.groups:
        p, first_cell, first_gate = group.pattern, cells.first[group.bodies], gates.of_group(group)
        counts.put(group, p.programs, {})
        leaf.put(group, p.leaves, {0: first_cell, 1: first_gate})
        gate.put(group, p.gates, {0: first_gate})
        if shares:
            first.put(group, _first_cells(p), {0: first_cell})
    row = row_ends(counts.columns[0])
    return dict(
        program_leaf=np.append(first.columns[0], np.int32(cells.count)) if shares else row,
        program_gate=row_ends(counts.columns[1]),
        program_row=row if shares else row[:0],
        leaf_cell=leaf.columns[0][:0] if shares else leaf.columns[0],
        leaf_gate=leaf.columns[1],
        leaf_negated=leaf.columns[2],
        leaf_sense=leaf.columns[3],
        gate_parent=gate.columns[0],
        gate_need=gate.columns[1],
        gate_negated=gate.columns[2],
        gate_start=gate.columns[3],
        **_leaf_bounds(contents, programs, leaves, alike),
    )


def _first_cells(pattern: BodyPattern) -> Ints:
    """Return the cell of the first leaf of each program, (programs, 1); any cell for a program without leaves.

    The other cells of a program follow it in order, which is asserted.
    """
    first = np.cumsum(pattern.programs[:, 0]) - pattern.programs[:, 0]
    cells = np.append(pattern.leaves[:, 0], 0)
    assert (cells[:-1] - np.repeat(cells[first] - first, pattern.programs[:, 0]) == np.arange(len(cells) - 1)).all()
    return cells[first][:, None]


def _leaf_bounds(contents: BodyGroups, programs: RowPlaces, leaves: RowPlaces, copies: RowPlaces) -> dict[str, Any]:
    """Build `Tables.leaf_bounds`, `program_shifts` and `shifts`.

    `programs` gives the programs of each body; `leaves` and `copies` its leaves and programs among the shared rows.
    """
    groups = [group for group in contents.groups if len(group.pattern.programs)]  # one may have no leaf, and has a row
    rows = mapped_zeros((leaves.count, BOX_NUMBERS), np.float64)
    program_shifts = mapped_zeros((programs.count if any(map(_shares_topology, groups)) else 0, SHIFT_SIZE), np.int32)
    shifts, shift = [np.zeros(min(1, len(program_shifts)))], 1
    for group in groups:
        p, first, x = group.pattern, leaves.of_group(group), np.zeros(len(group.bodies), np.int32)
        y, z, begins = x, x, [0, 0, 0]
        # One box that is large enough for each copy, about its own origin; the three shifts place it
        if isinstance(group.rows, FactoredRows) and len(p.leaves):
            rows[first[0] : first[0] + len(p.leaves)] = group.rows.around_all(p.bounds_at, len(p.leaves))
            x, y, z = group.rows.offsets.index
            for axis, values in enumerate(group.rows.offsets.values):
                begins[axis] = shift
                shifts.append(values)
                shift += len(values)
        else:
            for k in range(len(p.leaves)):
                at = p.bounds_at + BOX_NUMBERS * k
                rows[first + np.int32(k)] = group.rows[:, at : at + BOX_NUMBERS]
        begin, model = programs.first[group.bodies], copies.of_group(group)
        for k in range(len(p.programs) if len(program_shifts) else 0):
            put_program_shifts(begin, k, x, y, z, np.array(begins, np.int64), model, program_shifts)
    return dict(leaf_bounds=rows, program_shifts=program_shifts, shifts=concatenate(shifts))


def share_faces(contents: BodyGroups, cells: RowPlaces, faces: Ints, planes: Ints) -> dict[str, Ints]:
    """Build `Tables.cell_likes`, `cell_face`, `plane_face` from 1 + the numbers of all faces, signed by their sides."""
    if not any(isinstance(group.rows, FactoredRows) for group in contents.groups):
        return dict(cell_likes=faces[:0], cell_face=faces, plane_face=planes)
    alike = RowPlaces.of_copies(contents, [len(group.pattern.cells) for group in contents.groups])
    likes, column = mapped_zeros(cells.count, np.int32), np.zeros(alike.count, np.int32)
    for group in contents.groups:
        row, own = alike.of_group(group), np.abs(_sign_rows(group.pattern.cells)[:, 1])
        column[row[:, None] + np.arange(len(own))] = own
        put_numbers(cells.first[group.bodies], 2 * row, np.arange(0, 2 * len(own), 2, dtype=np.int32), likes)
    likes += faces < 0
    return dict(cell_likes=likes, cell_face=column, plane_face=as_bytes(planes))


def _shares_topology(group: BodyGroup) -> bool:
    """Return whether the bodies of a group are translated copies with leaves."""
    return isinstance(group.rows, FactoredRows) and len(group.pattern.leaves) > 0


# The builder

_CHUNK = 1 << 19  # numbers that fill a large page, so that no two threads touch one first


class TablesBuilder:
    """Builds the columns of `Tables`, except the tree and the limits, from the groups of bodies of a scene."""

    def __init__(self, contents: BodyGroups) -> None:
        self.contents, groups = contents, contents.groups
        patterns = [group.pattern for group in groups]

        def places(counts: Any) -> RowPlaces:
            return RowPlaces.of(contents, [counts(pattern) for pattern in patterns])

        self.surfaces = places(lambda p: len(p.kinds))
        self.cells, self.planes = places(lambda p: len(p.cells)), places(lambda p: len(p.planes))
        self.programs, self.sheets = places(lambda p: len(p.programs)), places(lambda p: len(p.sheets))
        self.polygons, self.corners = places(lambda p: len(p.polygons)), places(lambda p: int(p.corners.sum()))
        self.faces = places(lambda p: len(p.angular))
        self.frames = RowPlaces.of(
            contents, [int(group.pattern.framed and not shares_frame(group)) for group in groups]
        )

    def surface_columns(self, exact: ExactSurfaces) -> SurfaceTable:
        """Build the table of surfaces, each once; `exact` gives the surfaces before they were rounded."""
        inputs = InputSurfaces.of(self.contents.groups, self.surfaces)
        form_of, own = inputs.rows_of_forms()
        quadrics = QuadricTable.empty(form_of, own)
        counts = {PLANE: inputs.count(PLANE), SPHERE: inputs.count(SPHERE), QUADRIC: own}
        records = {kind: np.empty((counts[kind], SIZES[kind])) for kind in (PLANE, SPHERE)}
        # Planes along the axes lose nothing: pages of zeros that nobody writes to take no memory.
        lost = {kind: np.zeros((count, SIZES[kind])) for kind, count in counts.items()}
        forms, rests_of_forms = [quadrics.forms], [lost[QUADRIC]]
        senses, repeated = np.ones(len(inputs.leads), np.int8), np.arange(len(inputs.leads))

        def put(kind: int, rank: Ints, found: Floats) -> None:
            """Write the columns of `found`: records of leads, rounding errors of these, senses."""
            row: Any = inputs.row[rank]
            size, senses[rank] = SIZES[kind], found[..., -1]
            if kind == QUADRIC:
                quadrics.rows[row, :3] = found[..., :3]
                row = form_of[row]
                quadrics.forms[row] = found[..., 3:size]
            else:
                records[kind][row] = found[..., :size]
            rests = found[..., size:-1]
            if rests.any() or np.signbit(rests).any():
                lost[kind][row] = rests

        for group in self.contents.groups:
            if isinstance(group.rows, FactoredRows):
                continue
            for number, before in _repeated_surfaces(group):
                begin = self.surfaces.first[group.bodies]
                repeated[-1 - inputs.rank[begin + number]] = -1 - inputs.rank[begin + before]
            every, bodies = np.array(group.pattern.records).reshape(-1, 3), self.surfaces.first[group.bodies, None]
            for kind, size in SIZES.items():
                numbers = np.flatnonzero(every[:, 0] == kind)
                columns = (every[numbers, 1, None] + np.arange(2 * size + 1)).reshape(-1)
                for some in row_blocks(len(bodies), len(columns)) if len(columns) else ():
                    found = group.rows[some, columns].reshape(-1, len(numbers), 2 * size + 1)
                    put(kind, -1 - inputs.rank[bodies[some] + numbers], found)
        for copied in inputs.copies:
            column, sense = copied.column, copied.sense
            if copied.shares_form:
                forms.append(copied.rows[:1, column + 3 : column + QUADRIC_SIZE])
                rests_of_forms.append(copied.rows[:1, column + QUADRIC_SIZE : sense])
            for some in row_blocks(len(copied.leads)):
                rank = -1 - inputs.rank[copied.leads[some]]
                if copied.shares_form:
                    quadrics.rows[inputs.row[rank], :3] = copied.columns(some, column, column + 3)
                    senses[rank] = copied.columns(some, sense, sense + 1)[:, 0]
                else:
                    put(copied.kind, rank, copied.columns(some, column, sense + 1))
        shared = [SharedForm.of(copied) for copied in inputs.copies if copied.shares_form]
        quadrics = QuadricTable(quadrics.rows, concatenate(forms))
        rest = Remainders(lost[PLANE], lost[SPHERE], concatenate(rests_of_forms))
        balls = [balls.spheres for balls in self.contents.balls]
        self._share_leaves(inputs, repeated)
        subset = SurfaceSubset(exact, inputs.leads, self._primitives_with)
        known = RawSurfaces(
            inputs.kinds, senses, records[PLANE], records[SPHERE], quadrics, rest, balls, subset,
            repeated, shared, compact=len(inputs.leads) < len(inputs.rank),
        )  # fmt: skip
        merged = merge_surfaces(known)
        subset.primitives = subset.list_primitives = None  # which would keep the inputs alive
        return inputs.expand(merged)

    def _share_leaves(self, inputs: InputSurfaces, repeated: Longs) -> None:
        """Let the first body that a primitive is a part of, such as a mother and its daughter, lead its surfaces."""
        if all(len(group.leaves) == len(group.bodies) for group in self.contents.groups if group.leaves):
            return
        leaves, leaf, number = self._listed_primitives
        surfaces = np.flatnonzero(leaf >= 0)
        first, which = unique_first_with_inverse(leaf[surfaces] + len(leaves) * number[surfaces].astype(np.int64))
        rank = -1 - inputs.rank[surfaces]
        repeated[rank] = repeated[rank[first]][which]

    @cached_property
    def _listed_primitives(self) -> Primitives:
        """The primitives of the bodies of all groups that list them."""
        return self._primitives([group for group in self.contents.groups if group.leaves and group.slots])

    def _primitives_with(self, surfaces: Longs) -> Primitives:
        """Return the primitives of all listed bodies, and of others that have some of these surfaces."""
        groups = [group for group in self.contents.groups if group.slots]
        others = [group for group in groups if not group.leaves]
        if not others:
            return self._listed_primitives
        bodies = unique_sorted(np.searchsorted(self.surfaces.first, surfaces, side="right") - 1)
        for group in others:
            some = np.flatnonzero(np.isin(group.bodies, bodies))
            groups.append(replace(group, bodies=group.bodies[some], leaves=group.list_leaves(some)))
        return self._primitives([group for group in groups if group.leaves])

    def _primitives(self, groups: list[BodyGroup]) -> Primitives:
        """Return the primitives of the bodies of some groups."""
        leaves = [leaf for group in groups for leaf in group.leaves]
        shape, steps = (unique_with_inverse(np.array([id(leaf[k]) for leaf in leaves]))[1] for k in range(2))
        first, which = unique_first_with_inverse(shape + len(leaves) * steps.astype(np.int64))
        leaf, number = np.full(self.surfaces.count, -1, np.int32), np.zeros(self.surfaces.count, np.int32)
        ends = np.cumsum([len(group.leaves) for group in groups])
        for group, own in zip(groups, np.split(which, ends), strict=False):
            part, numbers = np.array(group.slots).T
            at = self.surfaces.first[group.bodies][:, None] + np.arange(len(part))
            leaf[at], number[at] = own.reshape(len(group.bodies), -1)[:, part], numbers
        return Primitives([leaves[k] for k in first.tolist()], leaf, number)

    def tables(self, surfaces: SurfaceTable) -> tuple[Tables, Floats]:
        """Return the finished tables, without trees and limits, and the boxes of the entries (n, 6)."""
        columns = self._columns(surfaces)
        if any(isinstance(group.rows, FactoredRows) for group in self.contents.groups):  # no edit reads them
            surfaces.forget_numbers()
        trim_heap(self.contents.body_count)
        entries, boxes = self._entries(surfaces)
        tables = Tables(
            surface_kind=own_memory(surfaces.kind), surface_row=own_memory(surfaces.row), planes=surfaces.planes,
            spheres=surfaces.spheres, quadrics=surfaces.quadrics.rows, quadric_forms=surfaces.quadrics.forms,
            **columns, **entries, **_later_columns(),
        )  # fmt: skip
        return replace_ball_cells(tables), boxes

    def _columns(self, surfaces: SurfaceTable) -> dict[str, Any]:
        """Build the columns of cells, programs, sheets and polygons."""
        cell, plane = TableColumns(self.cells, "ii"), TableColumns(self.planes, "ii")
        sheet = TableColumns(self.sheets, "iibb")
        polygon, corners = TableColumns(self.polygons, "ii"), np.zeros(self.polygons.count, np.int32)
        cell_first = mapped_zeros(self.cells.count + 1, np.int32)  # counts of planes until the cumulative sum
        for group in self.contents.groups:
            p = group.pattern
            surface, first_program, first_cell = (
                each.first[group.bodies] for each in (self.surfaces, self.programs, self.cells)
            )
            cell.put(group, _sign_rows(p.cells), {0: surface})
            plane.put(group, _sign_rows(p.planes), {0: surface})
            sheet.put(group, p.sheets, {0: surface, 1: first_program})
            polygon.put(group, p.polygons, {0: surface, 1: first_program})
            put_numbers(first_cell, np.zeros(1, np.int32), p.cell_planes, cell_first[1:])
            corners[self.polygons.rows(group, len(p.polygons))] = p.corners
        ids_and_senses = [_resolve_surfaces(surfaces, each.columns[0]) for each in (cell, plane, sheet, polygon)]
        (cell_quadric, cell_sense), (plane_surface, plane_sense) = ids_and_senses[:2]
        (sheet_surface, sheet_sense), (polygon_surface, polygon_sense) = ids_and_senses[2:]
        columns = dict(
            cell_quadric=cell_quadric,
            **share_faces(self.contents, self.cells, cell.signed(1, cell_sense), plane.signed(1, plane_sense)),
            cell_first=np.cumsum(cell_first, out=cell_first),
            plane_surface=plane_surface,
            **program_columns(self.contents, self.programs, self.cells),
            sheet_surface=sheet_surface,
            sheet_program=sheet.columns[1],
            sheet_side=sheet.signed(2, sheet_sense),
            sheet_one_sided=sheet.columns[3],
            polygon_surface=polygon_surface,
            polygon_side=polygon_sense,
            polygon_first=row_ends(corners),
            polygon_program=polygon.columns[1],
            vertices=self.corner_numbers(0),
        )
        return {name: own_memory(column) for name, column in columns.items()}

    def _entries(self, surfaces: SurfaceTable) -> tuple[dict[str, Any], Floats]:
        """Build the entries of the scene's tree in the order of their bodies, with frames and maps; and their boxes."""
        contents = self.contents
        count = contents.body_count
        kind, index = mapped_zeros(count, np.int8), mapped_zeros(count, np.int32)
        body_face = mapped_zeros(count, np.int32)
        alone = [each.boxes for each in contents.balls if len(each.bodies) == count]
        boxes = alone[0] if alone else mapped_zeros((count, 6), np.float64)
        of_kind = {CELL: self.cells, REGION: self.programs, SHEET: self.sheets, POLYGON: self.polygons}
        for group in contents.groups:
            p, bodies = group.pattern, group.bodies
            kind[bodies] = p.kind
            index[bodies] = of_kind[p.kind].first[bodies] + p.index
            body_face[bodies] = self.faces.first[bodies] if p.framed else group.ball_frame
            if isinstance(group.rows, FactoredRows):
                box = group.rows.base[p.box_at : p.box_at + BOX_NUMBERS]
                put_shifted_boxes(box, bodies, group.rows.offsets, boxes)
                continue
            for some in row_blocks(len(bodies)):
                boxes[bodies[some]] = group.rows[some, p.box_at : p.box_at + BOX_NUMBERS]
        first = len(surfaces.ids) - sum(len(balls.bodies) for balls in contents.balls)
        for balls in contents.balls:
            ids = surfaces.ids[first : first + len(balls.bodies)]

            def enter(begin: int, end: int, balls: BulkBalls = balls, ids: Any = ids) -> None:
                """Write the entries of balls begin..end."""
                bodies = balls.part(begin, end)
                kind[bodies], body_face[bodies], index[bodies] = BALL, balls.frame, ids[begin:end]
                if boxes is not balls.boxes:
                    boxes[bodies] = balls.boxes[begin:end]

            run_chunks(enter, len(ids), _CHUNK)
            first += len(ids)
        face_maps, body_maps, map_rows = build_face_maps(contents, self.faces)
        columns = dict(
            entry_kind=kind,
            entry_index=index,
            body_face=body_face,
            ball_frames=np.array(contents.ball_frames, dtype=np.float64).reshape(-1, 9),
            face_maps=own_memory(face_maps),
            body_maps=own_memory(body_maps),
            map_rows=map_rows,
        )
        return columns, boxes

    def frames_of_bodies(self) -> tuple[Floats, Ints]:
        """Return maps from world to local coordinates (n, 3, 4), and the row of each body.

        Frames that a group shares follow behind those of bodies with a frame each. A negative row -1 - k stands for
        coordinates about the ball's center, with the axes of ball frame k.
        """
        first = self.frames.first
        rows, which = [np.empty((self.frames.count, FRAME_NUMBERS))], first.astype(np.int32)
        for group in self.contents.groups:
            p = group.pattern
            if not p.framed:
                which[group.bodies] = group.ball_frame
            elif shares_frame(group):
                which[group.bodies] = len(rows) - 1 + self.frames.count
                rows.append(group.rows[:1, p.frame_at : p.corners_at])
            else:
                rows[0][first[group.bodies]] = group.rows[:, p.frame_at : p.corners_at]
        for balls in self.contents.balls:
            which[balls.part(0, len(balls.bodies))] = balls.frame
        return concatenate(rows).reshape(-1, 3, 4), which

    def corner_numbers(self, part: int) -> Floats:
        """Return (n, 3) numbers of the corners of polygons: part 0 their places, 1 what rounding removed from these."""
        numbers = np.empty((self.corners.count, 3))
        for group in self.contents.groups:
            p, count = group.pattern, int(group.pattern.corners.sum())
            begin = p.corners_at + 3 * count * part
            found = group.rows[:, begin : begin + 3 * count].reshape(len(group.rows), -1, 3)
            numbers[self.corners.rows(group, count)] = found
        return numbers


def _repeated_surfaces(group: BodyGroup) -> list[tuple[int, int]]:
    """List (surface, earlier one) of a body that are equal: a recording computed the numbers of both once.

    The wall of a revolved edge that bounds several rings is in the cell of each.
    """
    if not isinstance(group.rows, RowTable):
        return []
    known: dict[tuple[int, bytes, bytes], int] = {}
    each = ((kind, slice(first, sense + 1)) for kind, first, sense in group.pattern.records)
    keys = [(kind, group.rows.table[own].tobytes(), group.rows.column[own].tobytes()) for kind, own in each]
    firsts = [known.setdefault(key, number) for number, key in enumerate(keys)]
    return [(number, first) for number, first in enumerate(firsts) if first < number]


def _sign_rows(rows: Ints) -> Ints:
    """Turn rows (surface, side, face) into (surface, side * (face + 1)); 1 for no surface (`kernels/faces.py`)."""
    return np.stack([rows[:, 0], np.where(rows[:, 0] < 0, 1, rows[:, 1] * (rows[:, 2] + 1))], axis=1)


def _resolve_surfaces(surfaces: SurfaceTable, numbers: Ints) -> tuple[Ints, Signs]:
    """Replace surface numbers, in place, by ids in the finished table; return these and the senses there. -1 stays."""
    senses = mapped_zeros(len(numbers), np.int8)
    rank = np.zeros(0, np.int32) if surfaces.rank is None else surfaces.rank
    turned = np.zeros(0, np.int8) if surfaces.turned is None else surfaces.turned
    put_ids(surfaces.ids, surfaces.senses, rank, turned, numbers, senses)
    return numbers, senses


def _later_columns() -> dict[str, Any]:
    """Return empty columns for what later steps fill in: the tree and the limits."""
    return dict(
        node_boxes=np.zeros((0, 6, 8)),
        node_children=np.zeros((0, 8), np.int32),
        tree_order=np.zeros(0, np.int32),
        tree_root=np.zeros(0, np.int32),
        roots=np.zeros(0, np.int32),
        tree_depth=np.zeros(1, np.int32),
        leaf_items=np.zeros(0),
        extent=np.zeros(5),
        cell_groups=np.zeros(0, np.int32),
        group_bounds=np.zeros((0, GROUP_SIZE)),
        group_planes=np.zeros((0, LINKS), np.int32),
        plane_limits=np.zeros((0, 2)),
        quadric_limits=np.zeros((0, 2)),
        cell_limits=np.zeros((0, 2)),
        program_limits=np.zeros((0, 2)),
        sheet_limits=np.zeros((0, 2)),
        polygon_limits=np.zeros((0, 2)),
    )


def replace_ball_cells(tables: Tables) -> Tables:
    """Turn cells that are a single sphere into balls, which are traced without their cell."""
    at = np.flatnonzero(tables.entry_kind == CELL)
    if not len(at):
        return tables
    kind, index = tables.entry_kind.copy(), tables.entry_index.copy()
    cells = index[at]
    quadric = tables.cell_quadric[cells]
    ball = (quadric >= 0) & (cell_faces(tables, cells) == 1)
    ball &= np.diff(tables.cell_first)[cells] == 0
    ball[ball] = tables.surface_kind[quadric[ball]] == SPHERE
    kind[at[ball]], index[at[ball]] = BALL, quadric[ball]
    return tables._replace(entry_kind=kind, entry_index=index)
