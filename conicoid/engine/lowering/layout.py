"""Groups of bodies laid out as tables: every column of every body at once, in the order of the bodies."""

from __future__ import annotations

from typing import Any

import numpy as np

from ..tables import BALL, CELL, PLANE, POLYGON, QUADRIC, REGION, SHEET, SPHERE, Floats, Ints, Signs, Tables
from .apart import apart, empty, give_back_of
from .given import Given, Leading, columns_of, has_form
from .leaf_bounds import bounds_of_leaves, likes_of_cells
from .maps import frames_of, maps_of_faces, shares_frame
from .pattern import BOX_NUMBERS, SIZES, Group
from .places import Contents, Places
from .quadrics import Quadrics
from .rows import blocks
from .surfaces import ExactSurfaces, Remainders, SurfaceArrays, Surfaces, end_to_end, finished

_CHUNK = 1 << 15


class Layout:
    """The columns of `Tables` but for the tree, from the contents of a scene."""

    def __init__(self, contents: Contents) -> None:
        self.contents, groups = contents, contents.groups
        patterns = [group.pattern for group in groups]

        def places(counts: Any) -> Places:
            return Places.of(contents, [counts(pattern) for pattern in patterns])

        self.surfaces = places(lambda p: len(p.kinds))
        self.cells, self.planes = places(lambda p: len(p.cells)), places(lambda p: len(p.planes))
        self.programs, self.leaves = places(lambda p: len(p.programs)), places(lambda p: len(p.leaves))
        self.gates, self.sheets = places(lambda p: len(p.gates)), places(lambda p: len(p.sheets))
        self.polygons, self.corners = places(lambda p: len(p.polygons)), places(lambda p: int(p.corners.sum()))
        self.faces = places(lambda p: len(p.angular))
        self.frames = Places.of(contents, [int(group.pattern.framed and not shares_frame(group)) for group in groups])

    def surface_columns(self, exact: ExactSurfaces) -> SurfaceArrays:
        """The table of surfaces, each once. `exact` gives the surfaces before they were rounded."""
        given = Given.of(self.contents.groups, self.surfaces)
        form_of, own = given.rows_of_forms(self.contents.groups, self.surfaces)
        quadrics = Quadrics.empty(form_of, own)
        counts = {PLANE: given.count(PLANE), SPHERE: given.count(SPHERE), QUADRIC: own}
        records = {kind: np.empty((counts[kind], SIZES[kind])) for kind in (PLANE, SPHERE)}
        # Of walls along the axes nothing is lost: memory that nobody writes to is never taken
        lost = {kind: np.zeros((count, SIZES[kind])) for kind, count in counts.items()}
        forms, rests_of_forms = [quadrics.forms], [lost[QUADRIC]]
        senses = np.ones(len(given.leads), np.int8)
        for group, number, mine, which in given.places_of(self.contents.groups, self.surfaces):
            kind, column, sense = group.pattern.records[number]
            size, formed = SIZES[kind], kind == QUADRIC and has_form(group, column)
            if formed and len(mine):
                forms.append(group.rows[:1, column + 3 : column + size])
                rests_of_forms.append(group.rows[:1, column + size : sense])
            for some in blocks(len(mine)):
                row: Any = given.row[mine[some]]
                senses[given.rank[mine[some]]] = columns_of(group, which, some, sense, sense + 1)[:, 0]
                if kind == QUADRIC:
                    quadrics.rows[row, :3] = columns_of(group, which, some, column, column + 3)
                    if formed:
                        continue
                    row = form_of[row]
                    quadrics.forms[row] = columns_of(group, which, some, column + 3, column + size)
                else:
                    records[kind][row] = columns_of(group, which, some, column, column + size)
                rests = columns_of(group, which, some, column + size, sense)
                if rests.any() or np.signbit(rests).any():
                    lost[kind][row] = rests
        quadrics = Quadrics(quadrics.rows, end_to_end(forms))
        rest = Remainders(lost[PLANE], lost[SPHERE], end_to_end(rests_of_forms))
        balls = [balls.spheres for balls in self.contents.balls]
        kinds = given.kinds[given.leads]
        known = Surfaces(
            kinds, senses, records[PLANE], records[SPHERE], quadrics, rest, balls, Leading(exact, given.leads),
            compact=len(given.leads) < len(given.lead),
        )  # fmt: skip
        return given.all_of(finished(known))

    def tables(self, surfaces: SurfaceArrays) -> tuple[Tables, Floats]:
        """The finished arrays (without trees and limits), and the entries' boxes (n, 6)."""
        columns = self._columns(surfaces)
        give_back_of(self.contents.body_count)
        entries, boxes = self._entries(surfaces)
        tables = Tables(
            surface_kind=apart(surfaces.kind), surface_row=apart(surfaces.row), planes=surfaces.planes,
            spheres=surfaces.spheres, quadrics=surfaces.quadrics.rows, quadric_forms=surfaces.quadrics.forms,
            **columns, **entries, **_to_come(),
        )  # fmt: skip
        return balls_direct(tables), boxes

    def _columns(self, surfaces: SurfaceArrays) -> dict[str, Any]:
        """Cells, programs, sheets and polygons."""
        cell, plane = _Columns(self.cells, "ibi"), _Columns(self.planes, "ibi")
        leaf, gate = _Columns(self.leaves, "iibb"), _Columns(self.gates, "iibi")
        program, sheet = _Columns(self.programs, "ii"), _Columns(self.sheets, "iibb")
        polygon, corners = _Columns(self.polygons, "ii"), np.zeros(self.polygons.count, np.int32)
        cell_first = empty(self.cells.count + 1, np.int32)  # first how many planes each has
        vertices = np.empty((self.corners.count, 3))
        for group in self.contents.groups:
            p = group.pattern
            surface, first_program, first_cell, first_gate = (
                each.first[group.bodies] for each in (self.surfaces, self.programs, self.cells, self.gates)
            )
            cell.put(group, p.cells, {0: surface})
            plane.put(group, p.planes, {0: surface})
            program.put(group, p.programs, {})
            leaf.put(group, p.leaves, {0: first_cell, 1: first_gate})
            gate.put(group, p.gates, {0: first_gate})
            sheet.put(group, p.sheets, {0: surface, 1: first_program})
            polygon.put(group, p.polygons, {0: surface, 1: first_program})
            for k, count in enumerate(p.cell_planes.tolist()):
                cell_first[1:][first_cell + np.int32(k)] = count
            corners[self.polygons.rows(group, len(p.polygons))] = p.corners
            count = int(p.corners.sum())
            vertices[self.corners.rows(group, count)] = group.rows[:, p.corners_at : p.corners_at + 3 * count].reshape(
                len(group.rows), -1, 3
            )
        bounds, program_shifts, shifts = bounds_of_leaves(self.contents, self.programs)
        ids_and_senses = [_resolved(surfaces, each.columns[0]) for each in (cell, plane, sheet, polygon)]
        (cell_quadric, cell_sense), (plane_surface, plane_sense) = ids_and_senses[:2]
        (sheet_surface, sheet_sense), (polygon_surface, polygon_sense) = ids_and_senses[2:]
        columns = dict(
            cell_quadric=cell_quadric,
            cell_likes=likes_of_cells(self.contents, self.cells),
            cell_side=cell.signs(1, cell_sense),
            cell_face=cell.columns[2],
            cell_first=np.cumsum(cell_first, out=cell_first),
            plane_surface=plane_surface,
            plane_side=plane.signs(1, plane_sense),
            plane_face=plane.columns[2],
            program_leaf=_ends(program.columns[0]),
            program_gate=_ends(program.columns[1]),
            leaf_cell=leaf.columns[0],
            leaf_gate=leaf.columns[1],
            leaf_negated=leaf.columns[2],
            leaf_sense=leaf.columns[3],
            leaf_bounds=bounds,
            program_shifts=program_shifts,
            shifts=shifts,
            gate_parent=gate.columns[0],
            gate_need=gate.columns[1],
            gate_negated=gate.columns[2],
            gate_start=gate.columns[3],
            sheet_surface=sheet_surface,
            sheet_program=sheet.columns[1],
            sheet_side=sheet.signs(2, sheet_sense),
            sheet_one_sided=sheet.columns[3],
            polygon_surface=polygon_surface,
            polygon_side=polygon_sense,
            polygon_first=_ends(corners),
            polygon_program=polygon.columns[1],
            vertices=vertices,
        )
        return {name: apart(column) for name, column in columns.items()}

    def _entries(self, surfaces: SurfaceArrays) -> tuple[dict[str, Any], Floats]:
        """The leaves of the scene's tree in the order of their bodies, and what bodies need besides; boxes."""
        contents = self.contents
        count = contents.body_count
        kind, index, body = empty(count, np.int8), empty(count, np.int32), empty(count, np.int32)
        body_face, boxes = empty(count, np.int32), empty((count, 6), np.float64)
        body[:] = np.arange(count, dtype=np.int32)
        of_kind = {CELL: self.cells, REGION: self.programs, SHEET: self.sheets, POLYGON: self.polygons}
        for group in contents.groups:
            p, bodies = group.pattern, group.bodies
            kind[bodies] = p.kind
            index[bodies] = of_kind[p.kind].first[bodies] + p.index
            body_face[bodies] = self.faces.first[bodies] if p.framed else group.ball_frame
            for some in blocks(len(bodies)):
                boxes[bodies[some]] = group.rows[some, p.box_at : p.box_at + BOX_NUMBERS]
        first = self.surfaces.count
        for balls in contents.balls:
            bodies = balls.bodies
            kind[bodies], body_face[bodies] = BALL, balls.frame
            index[bodies] = surfaces.ids[first : first + len(bodies)]
            boxes[bodies] = balls.boxes
            first += len(bodies)
        face_maps, body_maps, map_rows = maps_of_faces(contents, self.faces)
        columns = dict(
            entry_kind=kind,
            entry_index=index,
            entry_body=body,
            body_face=body_face,
            ball_frames=np.array(contents.ball_frames, dtype=np.float64).reshape(-1, 9),
            face_maps=apart(face_maps),
            body_maps=apart(body_maps),
            map_rows=map_rows,
        )
        return columns, boxes

    def frames_of_bodies(self) -> tuple[Floats, Ints]:
        """((n, 3, 4) world to own coordinates, (bodies,) row; -1 - k: about the ball's center, by ball frame k)."""
        frames, which = frames_of(self.contents.groups, self.frames)
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


class _Columns:
    """Columns of one table, which are filled group by group: "b" for those of small numbers, "i" for others."""

    def __init__(self, places: Places, kinds: str) -> None:
        self.places = places
        self.columns: list[Any] = [empty(places.count, np.int8 if kind == "b" else np.int32) for kind in kinds]

    def put(self, group: Group, rows: Ints, shifts: dict[int, Ints]) -> None:
        """Rows of a pattern for each body of a group; numbers in some columns count on from a body's first one."""
        first = self.places.first[group.bodies].astype(np.intp)
        for k, row in enumerate(rows.tolist()):
            at = first + k
            for column, (values, number) in enumerate(zip(self.columns, row, strict=True)):
                values[at] = shifts[column] + np.int32(number) if column in shifts and number >= 0 else number

    def signs(self, column: int, senses: Signs) -> Signs:
        """A column of signs, each times a sense."""
        values: Signs = self.columns[column]
        values *= senses
        return values


def _ends(counts: Ints) -> Ints:
    """Where each begins, and the last ends."""
    return np.concatenate([np.zeros(1, np.int32), np.cumsum(counts, dtype=np.int32)])


def _resolved(surfaces: SurfaceArrays, numbers: Ints) -> tuple[Ints, Signs]:
    """(ids, senses) in the finished table of surfaces as they were added, which they take the place of; -1 stays."""
    senses = empty(len(numbers), np.int8)
    if not len(surfaces.ids):
        senses.fill(1)
        return numbers, senses
    for begin in range(0, len(numbers), _CHUNK):
        some = slice(begin, begin + _CHUNK)
        missing, known = numbers[some] < 0, np.maximum(numbers[some], 0)
        numbers[some] = np.where(missing, np.int32(-1), surfaces.ids[known])
        senses[some] = np.where(missing, np.int8(1), surfaces.senses[known])
    return numbers, senses


def _to_come() -> dict[str, Any]:
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


def balls_direct(tables: Tables) -> Tables:
    """Cells that are nothing but a sphere become balls, which are traced without their cell."""
    at = np.flatnonzero(tables.entry_kind == CELL)
    if not len(at):
        return tables
    kind, index = tables.entry_kind.copy(), tables.entry_index.copy()
    cells = index[at]
    quadric = tables.cell_quadric[cells]
    ball = (quadric >= 0) & (tables.cell_side[cells] > 0) & (tables.cell_face[cells] == 0)
    ball &= np.diff(tables.cell_first)[cells] == 0
    ball[ball] = tables.surface_kind[quadric[ball]] == SPHERE
    kind[at[ball]], index[at[ball]] = BALL, quadric[ball]
    return tables._replace(entry_kind=kind, entry_index=index)
