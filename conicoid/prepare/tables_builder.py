"""Columns of tables that are filled group by group."""

from __future__ import annotations

from collections.abc import Sequence
from typing import Any

import numpy as np

from ..kernels.faces import as_bytes, cell_faces, deduplicate_rows
from ..kernels.programs import ALIKE
from ..kernels.tables import (
    BALL,
    CELL,
    MAP_SIZE,
    PLACE_SIZE,
    PLANE,
    POLYGON,
    QUADRIC,
    REGION,
    SHEET,
    SHIFT_SIZE,
    SPHERE,
    Floats,
    Ints,
    Signs,
    Tables,
)
from .coincidence import ExactSurfaces, QuadricTable, RawSurfaces, Remainders, SurfaceTable, concatenate, merge_surfaces
from .input_surfaces import InputSurfaces, LeadSurfaces, group_columns, shares_form
from .mmap_arrays import mapped_zeros, own_memory, trim_heap
from .pattern import (
    BOX_NUMBERS,
    FRAME_NUMBERS,
    SIZES,
    BodyGroup,
    BodyGroups,
    BodyPattern,
    FactoredRows,
    RowPlaces,
    row_blocks,
)


class TableColumns:
    """Columns of one table, which are filled group by group: "b" for those of small numbers, "i" for others."""

    def __init__(self, places: RowPlaces, kinds: str) -> None:
        self.places = places
        self.columns: list[Any] = [mapped_zeros(places.count, np.int8 if kind == "b" else np.int32) for kind in kinds]

    def put(self, group: BodyGroup, rows: Ints, shifts: dict[int, Ints]) -> None:
        """Rows of a pattern for each body of a group; numbers in some columns count on from a body's first one.

        Of bodies that have the rows in common they are written once.
        """
        first = self.places.first[group.bodies].astype(np.intp)
        if len(first) > 1 and first[0] == first[-1]:
            first, shifts = first[:1], {column: counted[:1] for column, counted in shifts.items()}
        for k, row in enumerate(rows.tolist()):
            at = first + k
            for column, (values, number) in enumerate(zip(self.columns, row, strict=True)):
                values[at] = shifts[column] + np.int32(number) if column in shifts and number >= 0 else number

    def signed(self, column: int, senses: Signs) -> Any:
        """A column of numbers with signs, each times a sense."""
        values = self.columns[column]
        values *= senses
        return values


def row_ends(counts: Ints) -> Ints:
    """Where each begins, and the last ends."""
    return np.concatenate([np.zeros(1, np.int32), np.cumsum(counts, dtype=np.int32)])


# Affine maps of bodies: those from the world to uv of each face, and those to a body's own coordinates.
#
# Rows of maps that are one another's are in the table once, of bodies that are one another moved.

_SHIFT = 3
"""Bits of a number of `face_maps` of moved bodies that say what its row depends on (`kernels/body/uv.py`)."""


def build_face_maps(contents: BodyGroups, faces: RowPlaces) -> tuple[Ints, Ints, Floats]:
    """`Tables.face_maps`, `body_maps`, `map_rows`: first the rows of bodies that have their own, in order.

    faces: which are whose.
    """
    groups = contents.groups
    moved = [(group, group.rows) for group in groups if isinstance(group.rows, FactoredRows)]
    own = RowPlaces.of(
        contents, [0 if isinstance(each.rows, FactoredRows) else each.pattern.map_rows for each in groups]
    )
    if moved:
        alone = [0 if isinstance(each.rows, FactoredRows) else len(each.pattern.angular) for each in groups]
        faces = RowPlaces.of(contents, alone)
    maps, rows = mapped_zeros((faces.count, 3), np.int32), np.empty((own.count, MAP_SIZE))
    for group in groups:
        if isinstance(group.rows, FactoredRows):
            continue
        p, at = group.pattern, own.rows(group, group.pattern.map_rows)
        for some in row_blocks(len(group.bodies)):
            rows[at[some]] = group.rows[some, p.uv_at : p.bounds_at].reshape(*at[some].shape, MAP_SIZE)
        for face, mine in enumerate(_number_map_rows(group, (at << _SHIFT if moved else at).T)):
            for k, number in enumerate(mine):
                maps[faces.first[group.bodies] + np.int32(face), k] = number
    if not moved:
        return maps, mapped_zeros((0, PLACE_SIZE), np.int32), rows
    parts, tables, places = [maps], [rows], mapped_zeros((contents.body_count, PLACE_SIZE), np.int32)
    places[:, 0] = faces.first
    first, count = faces.count, own.count
    for group, moving in moved:
        p, which = group.pattern, _MapSources()
        numbers: list[Any] = []
        for table, index in _group_maps(moving, range(p.uv_at, p.bounds_at, MAP_SIZE)):
            numbers.append(count << _SHIFT | which.of(index))
            tables.append(table)
            count += len(table)
        parts.append(np.array(_number_map_rows(group, numbers), np.int32).reshape(-1, 3))
        places[group.bodies, 0] = first
        first += len(p.angular)
        for k, index in which.known:
            places[group.bodies, k] = index
    return concatenate(parts), places, concatenate(tables)


def _number_map_rows(group: BodyGroup, rows: Any) -> list[list[Any]]:
    """For each face the numbers of its rows, from those of the rows of its body; of angular ones -1 - the first."""
    p = group.pattern
    found = [[rows[row] for row in mine] for mine in p.maps.tolist()]
    for face in np.flatnonzero(p.angular).tolist():
        found[face][0] = -1 - found[face][0]
    return found


def _group_maps(moving: FactoredRows, columns: range) -> list[tuple[Floats, Ints]]:
    """`MovedRows.maps` of columns; rows that depend on more than `_Which` has numbers for are written out."""
    found, which = [moving.maps(column) for column in columns], _MapSources()
    try:
        for _, index in found:
            which.of(index)
    except ValueError:
        own = np.arange(len(moving), dtype=np.int32)
        found = [(table[index], own) if index.any() else (table, index) for table, index in found]
    return found


class _MapSources:
    """What the rows of maps depend on, by the numbers that `body_maps` has for it."""

    def __init__(self) -> None:
        self.known: list[tuple[int, Ints]] = []

    def of(self, index: Ints) -> int:
        """The number of what the rows depend on by which each body has this one; 0 where all have the first.

        Raises ValueError for more than three.
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
    """Have all bodies of a group the same own coordinates?"""
    p = group.pattern
    return isinstance(group.rows, FactoredRows) and all(
        len(group.rows.maps(column)[0]) == 1 for column in range(p.frame_at, p.corners_at, MAP_SIZE)
    )


def collect_frames(groups: Sequence[BodyGroup], frames: RowPlaces) -> tuple[Floats, Ints]:
    """((n, 3, 4) from the world to own coordinates, the row of each body), without those of bulk balls.

    frames: which rows are of bodies with one each; those that groups share come behind.
    """
    rows, which = [np.empty((frames.count, FRAME_NUMBERS))], frames.first.astype(np.int32)
    for group in groups:
        p = group.pattern
        if not p.framed:
            which[group.bodies] = group.ball_frame
        elif shares_frame(group):
            which[group.bodies] = len(rows) - 1 + frames.count
            rows.append(group.rows[:1, p.frame_at : p.corners_at])
        else:
            rows[0][frames.first[group.bodies]] = group.rows[:, p.frame_at : p.corners_at]
    return concatenate(rows).reshape(-1, 3, 4), which


# What cells and Boolean bodies have that are one another moved is in the tables once.
#
# That is how leaves feed gates, the gates, the boxes around leaves, the numbers of faces, and the limits.


def program_columns(contents: BodyGroups, programs: RowPlaces, cells: RowPlaces) -> dict[str, Any]:
    """The columns of programs, their leaves and gates (kernels/programs.py).

    programs, cells: where those of each body are.
    """
    alike, leaves, gates = (
        RowPlaces.alike(contents, [len(getattr(group.pattern, rows)) for group in contents.groups])
        for rows in ("programs", "leaves", "gates")
    )
    counts, leaf, gate = TableColumns(alike, "ii"), TableColumns(leaves, "iibb"), TableColumns(gates, "iibi")
    shares = any(map(_shares_topology, contents.groups))
    first = TableColumns(programs, "i")
    for group in contents.groups:
        p, first_cell, first_gate = group.pattern, cells.first[group.bodies], gates.first[group.bodies]
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
    """(programs, 1) the cell of the first leaf of each, any of one without leaves: the others follow behind it."""
    first = np.cumsum(pattern.programs[:, 0]) - pattern.programs[:, 0]
    cells = np.append(pattern.leaves[:, 0], 0)
    assert (cells[:-1] - np.repeat(cells[first] - first, pattern.programs[:, 0]) == np.arange(len(cells) - 1)).all()
    return cells[first][:, None]


def _leaf_bounds(contents: BodyGroups, programs: RowPlaces, leaves: RowPlaces, alike: RowPlaces) -> dict[str, Any]:
    """`Tables.leaf_bounds`, `program_shifts` and `shifts`.

    programs: where those of each body are; leaves, alike: where, in what programs have in common, its leaves are and
    its programs.
    """
    groups = [group for group in contents.groups if len(group.pattern.leaves)]
    rows = mapped_zeros((leaves.count, BOX_NUMBERS), np.float64)
    program_shifts = mapped_zeros((programs.count if any(map(_shares_topology, groups)) else 0, SHIFT_SIZE), np.int32)
    shifts, shift = [np.zeros(min(1, len(program_shifts)))], 1
    for group in groups:
        p, begin = group.pattern, programs.first[group.bodies]
        first = leaves.first[group.bodies]
        places: list[Any] = [0, 0, 0, alike.first[group.bodies]]
        if isinstance(group.rows, FactoredRows):
            rows[first[0] : first[0] + len(p.leaves)] = group.rows.around_all(p.bounds_at, len(p.leaves))
            for axis, values in enumerate(group.rows.away.values):
                places[axis] = group.rows.away.index[axis] + np.int32(shift)
                shifts.append(values)
                shift += len(values)
        else:
            for k in range(len(p.leaves)):
                at = p.bounds_at + BOX_NUMBERS * k
                rows[first + np.int32(k)] = group.rows[:, at : at + BOX_NUMBERS]
        for k in range(len(p.programs) if len(program_shifts) else 0):
            for column, place in enumerate(places):
                program_shifts[begin + np.int32(k), column] = place + np.int32(k if column == ALIKE else 0)
    return dict(leaf_bounds=rows, program_shifts=program_shifts, shifts=concatenate(shifts))


def share_faces(contents: BodyGroups, cells: RowPlaces, faces: Ints, planes: Ints) -> dict[str, Ints]:
    """`Tables.cell_likes`, `cell_face` and `plane_face`, from 1 + the numbers of all faces with their sides."""
    if not any(isinstance(group.rows, FactoredRows) for group in contents.groups):
        return dict(cell_likes=faces[:0], cell_face=faces, plane_face=planes)
    alike = RowPlaces.alike(contents, [len(group.pattern.cells) for group in contents.groups])
    likes = mapped_zeros(cells.count, np.int32)
    for group in contents.groups:
        for k in range(len(group.pattern.cells)):
            likes[cells.first[group.bodies] + np.int32(k)] = alike.first[group.bodies] + np.int32(k)
    likes, column = deduplicate_rows(likes, faces, alike.count)
    return dict(cell_likes=likes, cell_face=column, plane_face=as_bytes(planes))


def _shares_topology(group: BodyGroup) -> bool:
    """Are the bodies of a group one another moved, and have leaves?"""
    return isinstance(group.rows, FactoredRows) and len(group.pattern.leaves) > 0


# Groups of bodies laid out as tables: every column of every body at once, in the order of the bodies.

_CHUNK = 1 << 15


class TablesBuilder:
    """The columns of `Tables` but for the tree, from the contents of a scene."""

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
        """The table of surfaces, each once. `exact` gives the surfaces before they were rounded."""
        given = InputSurfaces.of(self.contents.groups, self.surfaces)
        form_of, own = given.rows_of_forms(self.contents.groups, self.surfaces)
        quadrics = QuadricTable.empty(form_of, own)
        counts = {PLANE: given.count(PLANE), SPHERE: given.count(SPHERE), QUADRIC: own}
        records = {kind: np.empty((counts[kind], SIZES[kind])) for kind in (PLANE, SPHERE)}
        # Of walls along the axes nothing is lost: memory that nobody writes to is never taken
        lost = {kind: np.zeros((count, SIZES[kind])) for kind, count in counts.items()}
        forms, rests_of_forms = [quadrics.forms], [lost[QUADRIC]]
        senses = np.ones(len(given.leads), np.int8)
        for group, number, mine, which in given.places_of(self.contents.groups, self.surfaces):
            kind, column, sense = group.pattern.records[number]
            size, formed = SIZES[kind], kind == QUADRIC and shares_form(group, column)
            if formed and len(mine):
                forms.append(group.rows[:1, column + 3 : column + size])
                rests_of_forms.append(group.rows[:1, column + size : sense])
            for some in row_blocks(len(mine)):
                row: Any = given.row[mine[some]]
                senses[given.rank[mine[some]]] = group_columns(group, which, some, sense, sense + 1)[:, 0]
                if kind == QUADRIC:
                    quadrics.rows[row, :3] = group_columns(group, which, some, column, column + 3)
                    if formed:
                        continue
                    row = form_of[row]
                    quadrics.forms[row] = group_columns(group, which, some, column + 3, column + size)
                else:
                    records[kind][row] = group_columns(group, which, some, column, column + size)
                rests = group_columns(group, which, some, column + size, sense)
                if rests.any() or np.signbit(rests).any():
                    lost[kind][row] = rests
        quadrics = QuadricTable(quadrics.rows, concatenate(forms))
        rest = Remainders(lost[PLANE], lost[SPHERE], concatenate(rests_of_forms))
        balls = [balls.spheres for balls in self.contents.balls]
        kinds = given.kinds[given.leads]
        known = RawSurfaces(
            kinds, senses, records[PLANE], records[SPHERE], quadrics, rest, balls, LeadSurfaces(exact, given.leads),
            compact=len(given.leads) < len(given.lead),
        )  # fmt: skip
        return given.all_of(merge_surfaces(known))

    def tables(self, surfaces: SurfaceTable) -> tuple[Tables, Floats]:
        """The finished arrays (without trees and limits), and the entries' boxes (n, 6)."""
        columns = self._columns(surfaces)
        if any(isinstance(group.rows, FactoredRows) for group in self.contents.groups):  # of which edits do not ask
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
        """Cells, programs, sheets and polygons."""
        cell, plane = TableColumns(self.cells, "ii"), TableColumns(self.planes, "ii")
        sheet = TableColumns(self.sheets, "iibb")
        polygon, corners = TableColumns(self.polygons, "ii"), np.zeros(self.polygons.count, np.int32)
        cell_first = mapped_zeros(self.cells.count + 1, np.int32)  # first how many planes each has
        vertices = np.empty((self.corners.count, 3))
        for group in self.contents.groups:
            p = group.pattern
            surface, first_program, first_cell = (
                each.first[group.bodies] for each in (self.surfaces, self.programs, self.cells)
            )
            cell.put(group, _sign_rows(p.cells), {0: surface})
            plane.put(group, _sign_rows(p.planes), {0: surface})
            sheet.put(group, p.sheets, {0: surface, 1: first_program})
            polygon.put(group, p.polygons, {0: surface, 1: first_program})
            for k, count in enumerate(p.cell_planes.tolist()):
                cell_first[1:][first_cell + np.int32(k)] = count
            corners[self.polygons.rows(group, len(p.polygons))] = p.corners
            count = int(p.corners.sum())
            vertices[self.corners.rows(group, count)] = group.rows[:, p.corners_at : p.corners_at + 3 * count].reshape(
                len(group.rows), -1, 3
            )
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
            vertices=vertices,
        )
        return {name: own_memory(column) for name, column in columns.items()}

    def _entries(self, surfaces: SurfaceTable) -> tuple[dict[str, Any], Floats]:
        """The leaves of the scene's tree in the order of their bodies, and what bodies need besides; boxes."""
        contents = self.contents
        count = contents.body_count
        kind, index = mapped_zeros(count, np.int8), mapped_zeros(count, np.int32)
        body_face, boxes = mapped_zeros(count, np.int32), mapped_zeros((count, 6), np.float64)
        of_kind = {CELL: self.cells, REGION: self.programs, SHEET: self.sheets, POLYGON: self.polygons}
        for group in contents.groups:
            p, bodies = group.pattern, group.bodies
            kind[bodies] = p.kind
            index[bodies] = of_kind[p.kind].first[bodies] + p.index
            body_face[bodies] = self.faces.first[bodies] if p.framed else group.ball_frame
            for some in row_blocks(len(bodies)):
                boxes[bodies[some]] = group.rows[some, p.box_at : p.box_at + BOX_NUMBERS]
        first = self.surfaces.count
        for balls in contents.balls:
            bodies = balls.bodies
            kind[bodies], body_face[bodies] = BALL, balls.frame
            index[bodies] = surfaces.ids[first : first + len(bodies)]
            boxes[bodies] = balls.boxes
            first += len(bodies)
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
        """((n, 3, 4) world to own coordinates, (bodies,) row; -1 - k: about the ball's center, by ball frame k)."""
        frames, which = collect_frames(self.contents.groups, self.frames)
        for balls in self.contents.balls:
            which[balls.bodies] = balls.frame
        return frames, which

    def lost_of_corners(self) -> Floats:
        """What rounding took from the corners of polygons, (n, 3)."""
        lost = np.empty((self.corners.count, 3))
        for group in self.contents.groups:
            p = group.pattern
            count = int(p.corners.sum())
            begin = p.corners_at + 3 * count
            lost[self.corners.rows(group, count)] = group.rows[:, begin : begin + 3 * count].reshape(
                len(group.rows), -1, 3
            )
        return lost


def _sign_rows(rows: Ints) -> Ints:
    """Rows of a surface, a side and a face as those of a surface and of both (kernels/faces.py); 1 for no surface."""
    return np.stack([rows[:, 0], np.where(rows[:, 0] < 0, 1, rows[:, 1] * (rows[:, 2] + 1))], axis=1)


def _resolve_surfaces(surfaces: SurfaceTable, numbers: Ints) -> tuple[Ints, Signs]:
    """(ids, senses) in the finished table of surfaces as they were added, which they take the place of; -1 stays."""
    senses = mapped_zeros(len(numbers), np.int8)
    if not len(surfaces.ids):
        senses.fill(1)
        return numbers, senses
    for begin in range(0, len(numbers), _CHUNK):
        some = slice(begin, begin + _CHUNK)
        missing, known = numbers[some] < 0, np.maximum(numbers[some], 0)
        numbers[some] = np.where(missing, np.int32(-1), surfaces.ids[known])
        senses[some] = np.where(missing, np.int8(1), surfaces.senses[known])
    return numbers, senses


def _later_columns() -> dict[str, Any]:
    """What later steps fill in: the tree and the limits."""
    return dict(
        node_boxes=np.zeros((0, 6, 8)),
        node_children=np.zeros((0, 8), np.int32),
        tree_order=np.zeros(0, np.int32),
        tree_root=np.zeros(0, np.int32),
        roots=np.zeros(0, np.int32),
        tree_depth=np.zeros(1, np.int32),
        leaf_items=np.zeros(0),
        extent=np.zeros(5),
        plane_limits=np.zeros((0, 2)),
        quadric_limits=np.zeros((0, 2)),
        cell_limits=np.zeros((0, 2)),
        program_limits=np.zeros((0, 2)),
        sheet_limits=np.zeros((0, 2)),
        polygon_limits=np.zeros((0, 2)),
    )


def replace_ball_cells(tables: Tables) -> Tables:
    """Cells that are nothing but a sphere become balls, which are traced without their cell."""
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
