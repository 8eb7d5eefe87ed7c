"""Groups of bodies laid out as tables: every column of every body at once, in the order of the bodies."""

from __future__ import annotations

from typing import Any

import numpy as np

from ..faces import cell_faces
from ..tables import BALL, CELL, PLANE, POLYGON, QUADRIC, REGION, SHEET, SPHERE, Floats, Ints, Signs, Tables
from .alike import columns_of_programs, shared_faces
from .apart import apart, empty, give_back_of
from .columns import Columns, ends_of
from .given import Given, Leading, columns_of, has_form
from .maps import frames_of, maps_of_faces, shares_frame
from .moved_rows import MovedRows
from .pattern import BOX_NUMBERS, SIZES
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
        self.programs, self.sheets = places(lambda p: len(p.programs)), places(lambda p: len(p.sheets))
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
        if any(isinstance(group.rows, MovedRows) for group in self.contents.groups):  # of which edits do not ask
            surfaces.forget_numbers()
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
        cell, plane = Columns(self.cells, "ii"), Columns(self.planes, "ii")
        sheet = Columns(self.sheets, "iibb")
        polygon, corners = Columns(self.polygons, "ii"), np.zeros(self.polygons.count, np.int32)
        cell_first = empty(self.cells.count + 1, np.int32)  # first how many planes each has
        vertices = np.empty((self.corners.count, 3))
        for group in self.contents.groups:
            p = group.pattern
            surface, first_program, first_cell = (
                each.first[group.bodies] for each in (self.surfaces, self.programs, self.cells)
            )
            cell.put(group, _signed(p.cells), {0: surface})
            plane.put(group, _signed(p.planes), {0: surface})
            sheet.put(group, p.sheets, {0: surface, 1: first_program})
            polygon.put(group, p.polygons, {0: surface, 1: first_program})
            for k, count in enumerate(p.cell_planes.tolist()):
                cell_first[1:][first_cell + np.int32(k)] = count
            corners[self.polygons.rows(group, len(p.polygons))] = p.corners
            count = int(p.corners.sum())
            vertices[self.corners.rows(group, count)] = group.rows[:, p.corners_at : p.corners_at + 3 * count].reshape(
                len(group.rows), -1, 3
            )
        ids_and_senses = [_resolved(surfaces, each.columns[0]) for each in (cell, plane, sheet, polygon)]
        (cell_quadric, cell_sense), (plane_surface, plane_sense) = ids_and_senses[:2]
        (sheet_surface, sheet_sense), (polygon_surface, polygon_sense) = ids_and_senses[2:]
        columns = dict(
            cell_quadric=cell_quadric,
            **shared_faces(self.contents, self.cells, cell.signed(1, cell_sense), plane.signed(1, plane_sense)),
            cell_first=np.cumsum(cell_first, out=cell_first),
            plane_surface=plane_surface,
            **columns_of_programs(self.contents, self.programs, self.cells),
            sheet_surface=sheet_surface,
            sheet_program=sheet.columns[1],
            sheet_side=sheet.signed(2, sheet_sense),
            sheet_one_sided=sheet.columns[3],
            polygon_surface=polygon_surface,
            polygon_side=polygon_sense,
            polygon_first=ends_of(corners),
            polygon_program=polygon.columns[1],
            vertices=vertices,
        )
        return {name: apart(column) for name, column in columns.items()}

    def _entries(self, surfaces: SurfaceArrays) -> tuple[dict[str, Any], Floats]:
        """The leaves of the scene's tree in the order of their bodies, and what bodies need besides; boxes."""
        contents = self.contents
        count = contents.body_count
        kind, index = empty(count, np.int8), empty(count, np.int32)
        body_face, boxes = empty(count, np.int32), empty((count, 6), np.float64)
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


def _signed(rows: Ints) -> Ints:
    """Rows of a surface, a side and a face as those of a surface and of both (engine/faces.py); 1 for no surface."""
    return np.stack([rows[:, 0], np.where(rows[:, 0] < 0, 1, rows[:, 1] * (rows[:, 2] + 1))], axis=1)


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
    ball = (quadric >= 0) & (cell_faces(tables, cells) == 1)
    ball &= np.diff(tables.cell_first)[cells] == 0
    ball[ball] = tables.surface_kind[quadric[ball]] == SPHERE
    kind[at[ball]], index[at[ball]] = BALL, quadric[ball]
    return tables._replace(entry_kind=kind, entry_index=index)
