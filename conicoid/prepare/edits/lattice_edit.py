"""Edit a scene with instances: bodies exchanged for others, one after the other, at a cost of what differs.

The user is a loop that moves one body of a core of 400,000 pins: 23 ms to the next first hit in place of 2.6 s.

Tables of a scene with instances have room behind their rows. A new body is lowered by itself, and its rows go there.
The rows of the old body stay, but no entry names them, and its cells name no surface. It leaves its leaf of the tree;
the new one goes into a small second tree. Bodies, faces and surfaces have the numbers, and answers the bits, of a scene
that is prepared afresh. So surfaces are numbered anew by their leads (see `surface_classes.py`). Limits are widened, or
all computed again where the old body had set one of them; they are at least those of a fresh scene.

What does not fit is prepared afresh: the first body of a kind, to which the others are relative; a body whose surface
leads a class of many; scenes of balls, sheets, cells of many planes; tables without room.
"""

from __future__ import annotations

import dataclasses
import sys
from typing import Any

import numpy as np

from ..._util.records import dataclass
from ...geometry.instance_edits import InstanceOrigins
from ...geometry.instances import InstanceList, transform_offsets
from ...geometry.shape import Shape
from ...kernels.bvh.walk import FEW
from ...kernels.faces import cell_faces, plane_faces
from ...kernels.programs import gates_of_program, leaves_of_program
from ...kernels.tables import (
    BALL,
    CELL,
    GATES,
    HALT,
    LEAVES,
    PLANE,
    QUADRIC,
    REGION,
    SPHERE,
    STEPS,
    Floats,
    Geometry,
    Ints,
    Longs,
    Tables,
    line_array,
    places_of,
)
from ..body_collector import ExactBodySurfaces
from ..bvh.plane_groups import group_tables
from ..bvh.tree_patch import plant_entries, remove_from_leaf
from ..bvh.trees import SceneTrees
from ..error_limits import LimitMaxima, no_limits, program_limits
from ..instances import FEWEST_INSTANCES
from ..lower_shape import lower_shape
from ..lowering import ExactTables, InstanceShapes, LazyBounds, LoweredScene, lower
from ..pattern import SIZES, shift_boxes
from ..surface_features import Remainders
from ..tables_builder import WHICH_BITS
from .buffer_pool import BufferPool, EditState, OpenBuffer, PoolMemory, SceneBuffer, TableRows, UneditableError
from .limits_update import BodyCells, LatticeLimits, SurfaceReaches
from .neighbour_index import NeighbourFrame, NeighbourPlaces, find_neighbours, surface_columns

_MOST_MEMBERS = 16
"""Larger classes that lose their lead are not searched for another."""
_ROOM = 1 << 12
"""Rows of each table behind those of a scene of many bodies."""
_TABLES_OF_KINDS = {PLANE: "planes", SPHERE: "spheres", QUADRIC: "quadrics"}
_NAMES_OF_SURFACES = "cell_quadric", "plane_surface", "sheet_surface", "polygon_surface"


@dataclass(frozen=True)
class LatticeState(EditState):
    """What the next edit needs: the uses that limits come from, and what earlier edits have added."""

    maxima: LimitMaxima | None = None
    loose: dict[int, Floats] = dataclasses.field(default_factory=dict)  # entry of the small tree -> its box
    added: NeighbourPlaces | None = None  # places of surfaces behind those of `places`
    uses: dict[int, SurfaceReaches] = dataclasses.field(default_factory=dict)  # of entries of the small tree
    shared: tuple[int, int] = (0, 0)  # rows of limits of cells and programs of the scene that was prepared afresh

    @property
    def has_gaps(self) -> bool:
        return bool(self.loose)

    __reduce__ = EditState.__reduce__


def room_for_edits(buffers: list[OpenBuffer], tables: Tables) -> Geometry:
    """Allocate memory for tables of these shapes, with room behind each; append its buffer to a list."""
    rows = min(_ROOM, 64 + len(tables.entry_kind))
    places, integers, floats = places_of(tables, spare_rows=rows)
    buffers.append(OpenBuffer(SceneBuffer(np.zeros(integers, np.int32), line_array(floats))))
    return Geometry(places, *buffers[-1].arrays)


def first_state(opened: OpenBuffer, maxima: LimitMaxima, tables: Tables) -> LatticeState:
    """Return the state of a freshly prepared scene, whose memory is in a buffer."""
    memory = opened.memory(BufferPool(), np.zeros(0, np.int64), 0)
    opened.close(memory, None)
    return LatticeState(memory=memory, maxima=maxima, shared=(len(tables.cell_limits), len(tables.program_limits)))


def without_memory(lowered: LoweredScene) -> LoweredScene:
    """Return the scene with the shapes of its tables alone."""
    shapes: list[Any] = [np.broadcast_to(column.dtype.type(), column.shape) for column in lowered.tables]
    return dataclasses.replace(lowered, tables=Tables(*shapes))


@dataclass
class _OldBody:
    """A body that leaves: its shape, its cells, and its slots begin..end."""

    shape: Shape
    body: BodyCells
    begin: int
    end: int
    box: Floats
    alike: bool  # does it share rows with translated copies?


class LatticeEdit:
    """Exchanges bodies of a scene with instances in tables that nobody else reads, or raises `UneditableError`."""

    def __init__(
        self, lowered: LoweredScene, geometry: Geometry, woods: SceneTrees, state: LatticeState, old: InstanceList,
        bodies: InstanceList, entries: list[int],
    ) -> None:  # fmt: skip
        assert state.maxima is not None
        assert isinstance(lowered.bounds, LazyBounds)
        self.lowered, self.old, self.bodies, self.woods, self.state = lowered, old, bodies, woods, state
        self.rows = TableRows(geometry, lowered.tables, lowered.rest)
        self.limits = LatticeLimits(self.rows, state.maxima.copy(), dict(state.uses), state.shared)
        self.shapes = InstanceShapes(bodies, {entry: old.shape(entry) for entry in entries})
        self.exact: ExactBodySurfaces = lowered.exact.bodies.of(self.shapes)
        self.single, self.groups, self.loose = lowered.exact.single, list(lowered.bounds.groups), dict(state.loose)
        self.frames, self.body_frame, self.paint = [lowered.frames], lowered.body_frame.copy(), lowered.face_paint
        self.frame, self.places, self.added = state.frame, state.places, state.added
        balls = np.flatnonzero(self.rows["entry_kind"] == BALL)
        if not len(self.rows["cell_likes"]) or set(balls.tolist()) - set(self.loose) or sys.byteorder != "little":
            raise UneditableError
        for entry in entries:
            self._exchange(entry)
            del self.shapes.pending[entry]
        self.woods = plant_entries(self.rows, self.woods, self.loose, len(bodies))

    def finished(self, memory: PoolMemory) -> tuple[LoweredScene, SceneTrees, LatticeState]:
        """Return the edited scene, its trees, and the state for the next edit."""
        bounds, tables = LazyBounds(self.bodies, self.groups), self.rows.tables()
        lowered = dataclasses.replace(
            self.lowered, tables=tables, bounds=bounds, frames=np.concatenate(self.frames), body_frame=self.body_frame,
            face_paint=self.paint, rest=self.rows.rest, exact=ExactTables(self.exact, self.single),
        )  # fmt: skip
        if self.limits.are_invalid:
            self.limits.compute_all(bounds.boxes, self.loose)
            bounds.release()
        state = LatticeState(
            self.frame,
            self.places,
            None,
            memory,
            maxima=self.limits.maxima,
            loose=self.loose,
            added=self.added,
            uses=self.limits.uses,
            shared=self.state.shared,
        )
        return lowered, self.woods, state

    def _exchange(self, entry: int) -> None:
        """Exchange one body."""
        new = lower((self.bodies[entry],))
        kind, cells = int(new.tables.entry_kind[0]), new.tables.cell_first
        boxes = np.isfinite(new.boxes).all()
        if (
            kind not in (BALL, CELL, REGION) or not (boxes or self.limits.maxima.size) or len(new.frames) != 1
            or len(self.rows["cell_groups"]) or len(group_tables(np.diff(cells))["cell_groups"])
            or (kind == REGION and (len(new.tables.leaf_cell) > FEW or not len(self.rows["program_shifts"])))
        ):  # fmt: skip
            raise UneditableError
        old = self._take_out(entry)
        surfaces, flipped = self._exchange_surfaces(entry, old, new)
        self._append_body(entry, new, surfaces, flipped)
        self.groups.append((np.array([entry], np.int32), new.boxes))
        self.loose[entry] = new.boxes[0]

    # --- The old body

    def _take_out(self, entry: int) -> _OldBody:
        """Describe the old body, take it out of the tree and of the groups, and out of what limits hold for."""
        tables, first = self.rows.tables(), self.exact.first
        body = BodyCells.of(tables, entry)
        if tables.entry_kind[entry] == REGION:
            gates = gates_of_program(tables, int(tables.entry_index[entry]))
            self.rows.geometry.places[STEPS] -= len(body.cells) * len(gates)
        shape, begin = self.shapes[entry], int(first[entry])
        last = entry + 1 == len(first)
        end = begin + len(lower_shape(shape).pattern.kinds) if last else int(first[entry + 1])
        old = _OldBody(shape, body, begin, end, *self._leave_group(entry, body.planes))
        if not np.isfinite(old.box).all():
            raise UneditableError
        if entry in self.loose:
            del self.loose[entry]
        else:
            self.woods = remove_from_leaf(self.rows, self.woods, entry)
        return old

    def _leave_group(self, entry: int, planes: Longs) -> tuple[Floats, bool]:
        """Take an entry out of its group of bodies; return its box, and whether the group are translated copies."""
        # Numbers of a group need not rise: bodies of edits stand in the order of the edits
        found = ((k, np.flatnonzero(numbers == np.int32(entry))) for k, (numbers, _) in enumerate(self.groups))
        k, i = next((k, int(places[0])) for k, places in found if len(places))
        numbers, known = self.groups[k]
        alike, others = known.ndim == 1, np.delete(numbers, i)
        self.groups[k] = others, known if alike else np.delete(known, i, axis=0)
        if not len(others):
            del self.groups[k]
        if not alike:
            return known[i], False
        # All others are relative to the first, and few of a kind are lowered one by one
        if i == 0 or len(numbers) <= FEWEST_INSTANCES:
            raise UneditableError
        origins = InstanceOrigins.of(self.old)
        base, mine, its = origins.base, *(int(origins.numbers[each]) for each in (entry, numbers[0]))
        away = np.array([[float(a - b) for a, b in zip(base.shifts.of(mine), base.shifts.of(its), strict=True)]])
        rows = self.rows["surface_row"][self.rows["plane_surface"][planes]]
        if (np.count_nonzero(self.rows["planes"][rows, :3], axis=1) > 1).any():
            # Records of slanted planes are those of the bodies nearest to a diagonal, which ends at the outmost ones
            index = base.shifts.index[:, origins.numbers[numbers]]
            if (index[:, i] == index.max(axis=1)).any() or len(numbers) % 8 == 0:
                raise UneditableError
        return shift_boxes(known, transform_offsets(away, base.motion(int(base.kinds[mine]))))[0], True

    # --- Surfaces

    def _exchange_surfaces(self, entry: int, old: _OldBody, new: LoweredScene) -> tuple[Ints, Ints]:
        """Number the surfaces anew; return for each of the new body its number, and -1 where its sense is another's."""
        rows, single, more = self.rows, self.single, _slots(new) - (old.end - old.begin)
        uses = old.body.uses(rows)
        ids = np.unique(uses[0])
        leads: dict[int, int] = {}  # surface that stays -> the slot that leads it now
        vanish: set[int] = set()
        for number in ids[(single[ids] >= old.begin) & (single[ids] < old.end)].tolist():
            slot = self._other_lead(number, old)
            if slot is None:
                vanish.add(number)
            else:
                leads[number] = slot + (more if slot >= old.end else 0)
        self.limits.remove_uses(entry, uses, old.body, old.box, old.alike, vanish)
        equal = self._equal_surfaces(new, vanish)
        own, flipped = np.empty(len(new.exact.single), np.int32), np.ones(len(new.exact.single), np.int32)
        fresh = []
        for number, slot in enumerate((old.begin + new.exact.single).tolist()):
            if number not in equal:
                fresh.append((slot, number))
                continue
            known, flipped[number] = equal[number]
            lead = leads.get(known, int(single[known]) + (more if single[known] >= old.end else 0))
            mine, its = _record(new.tables, new.rest, number), _record(rows.tables(), self.rows.rest, known)
            # The least record leads, of equal ones that of the first slot
            if (_rank(mine), slot) < (_rank(its), lead):
                leads[known] = slot
                if mine[1].tobytes() != its[1].tobytes():
                    self._replace_record(new, number, known, int(flipped[number]))
        rows["cell_quadric"][old.body.cells] = rows["plane_surface"][old.body.planes] = -1
        # What leads, by slots: (slot, kind, row, surface, surface of the new body)
        moved = [(slot, *self.rows.kind_and_row(known), known, -1) for known, slot in leads.items()]
        moved += [(slot, *self._append_surface(new, number), -1, number) for slot, number in fresh]
        onto = self._renumber(sorted({*vanish, *leads}), sorted(moved), old.end, more)
        for number, (known, _) in equal.items():
            own[number] = onto[known]
        for place, (*_, number) in zip(self._inserted.tolist(), sorted(moved), strict=True):
            if number >= 0:
                own[number] = place
        if more:
            first = self.exact.first.copy()
            first[entry + 1 :] += more
            self.exact = self.exact.of(self.shapes, first)
        return own, flipped

    def _other_lead(self, surface: int, old: _OldBody) -> int | None:
        """Return the slot that leads a surface without the old body; None where nobody else has the surface."""
        tables = self.rows.tables()
        kind, _ = self.rows.kind_and_row(surface)
        if kind == PLANE:
            places = np.setdiff1d(np.flatnonzero(tables.plane_surface == surface), old.body.planes)
            cells = np.searchsorted(tables.cell_first, places.astype(np.int32), side="right") - 1
        else:
            cells = np.setdiff1d(np.flatnonzero(tables.cell_quadric == surface), old.body.cells)
        if not len(cells):
            return None
        known = _record(tables, self.rows.rest, surface)
        if len(cells) > _MOST_MEMBERS or (kind == PLANE and np.count_nonzero(known[1][:3]) > 1):
            raise UneditableError
        key, found = self.exact.name(int(self.single[surface]))[0], []
        for body in {self._body_of(tables, cell) for cell in cells.tolist()}:
            part, first = lower_shape(self.shapes[body]), int(self.exact.first[body])
            for own, (its, column, sense) in enumerate(part.pattern.records):
                if (its == PLANE) == (kind == PLANE) and self.exact.name(first + own)[0] == key:
                    found.append(((its, np.array(part.row[column:sense])), first + own))
        lead, slot = min(found, key=lambda each: (_rank(each[0]), each[1]))
        if lead[0] != kind or lead[1].tobytes() != known[1].tobytes():
            raise UneditableError
        return slot

    @staticmethod
    def _body_of(tables: Tables, cell: int) -> int:
        """Return the body of a cell."""
        leaf = cell
        if len(tables.leaf_cell):
            leaf = int(next(iter(np.flatnonzero(tables.leaf_cell == cell)), -1))
        program = int(np.searchsorted(tables.program_leaf, np.int32(leaf), side="right")) - 1
        within = 0 <= program < len(tables.program_leaf) - 1 and leaf in leaves_of_program(tables, program)
        kind, index = (REGION, program) if within else (CELL, cell)
        found = np.flatnonzero((tables.entry_index == index) & (tables.entry_kind == kind))
        if len(found) != 1:
            raise UneditableError
        return int(found[0])

    def _equal_surfaces(self, new: LoweredScene, vanish: set[int]) -> dict[int, tuple[int, int]]:
        """Map surfaces of the new body to (equal surface that stays, -1 where it has the other sense)."""
        records, rows = surface_columns(new.tables), self.rows
        own = self.frame.places_within(*records) if self.frame is not None else None
        if own is None or self.frame is None or self.places is None or self.added is None:
            self.frame, (self.places, own) = NeighbourFrame.of_scenes(surface_columns(rows.tables()), records)
            self.added = NeighbourPlaces(*(np.zeros(0) for _ in range(3)))
        own_curved = np.concatenate([own.spheres, own.quadrics])
        names = {}
        for number, slot in enumerate(new.exact.single.tolist()):
            key, sense = new.exact.bodies.name(slot)
            names[bool(new.tables.surface_kind[number] == PLANE), key] = number, sense
        equal: dict[int, tuple[int, int]] = {}
        for kind, name in enumerate(("planes", "spheres", "quadrics")):
            wanted, before = own.planes if kind == PLANE else own_curved, getattr(self.places, name)
            for places, first in ((self.places, 0), (self.added, len(before))):
                near = first + find_neighbours(getattr(places, name), places.marks[kind], wanted)
                for row in near.tolist():
                    found = np.flatnonzero(rows["surface_row"] == row)
                    for known in found[rows["surface_kind"][found] == kind].tolist():
                        key, sense = self.exact.name(int(self.single[known]))
                        if known not in vanish and (kind == PLANE, key) in names:
                            number, its = names[kind == PLANE, key]
                            equal[number] = known, 1 if kind == PLANE else sense * its
        # Rows of surfaces that are not appended stay unused: places of all are kept
        self._own_places = own
        return equal

    def _append_surface(self, new: LoweredScene, number: int) -> tuple[int, int]:
        """Append the record of a surface of the new body; return its kind and row."""
        kind, row = int(new.tables.surface_kind[number]), int(new.tables.surface_row[number])
        name = _TABLES_OF_KINDS[kind]
        record, lost = getattr(new.tables, name)[row : row + 1], getattr(new.rest, name)[row : row + 1]
        if kind == QUADRIC:
            record = self._append_form(new, row)
        elif kind == PLANE:
            self.rows.append("plane_limits", np.zeros((1, 2)))
            self.limits.maxima.extend(kind)
        if kind != QUADRIC:
            self.rows.append_rest(name, lost)
        assert self.added is not None
        place = getattr(self._own_places, name)[row : row + 1]
        self.added = dataclasses.replace(self.added, **{name: np.concatenate([getattr(self.added, name), place])})
        return kind, self.rows.append(name, record)

    def _append_form(self, new: LoweredScene, row: int) -> Floats:
        """Append the form of a quadric of the new body; return its anchor and the row of the form."""
        record = new.tables.quadrics[row : row + 1].copy()
        form = int(record[0, 3])
        record[0, 3] = self.rows.append("quadric_forms", new.tables.quadric_forms[form : form + 1])
        self.rows.append("quadric_limits", np.zeros((1, 2)))
        self.limits.maxima.extend(QUADRIC)
        self.rows.append_rest("quadrics", new.rest.quadrics[form : form + 1])
        return record

    def _replace_record(self, new: LoweredScene, number: int, known: int, turned: int) -> None:
        """Let an equal surface of the new body give the record of a known one; all its uses are weighed again."""
        (kind, row), mine = self.rows.kind_and_row(known), int(new.tables.surface_row[number])
        if turned < 0 or kind == SPHERE or kind != new.tables.surface_kind[number]:
            raise UneditableError
        if kind == QUADRIC:
            self.rows["quadrics"][row] = self._append_form(new, mine)
        else:
            self.rows["planes"][row] = new.tables.planes[mine]
            planes = self.rows.rest.planes.copy()
            planes[row] = new.rest.planes[mine]
            self.rows.rest = dataclasses.replace(self.rows.rest, planes=planes)
        self.limits.are_invalid = True

    def _renumber(
        self, removed: list[int], inserted: list[tuple[int, int, int, int, int]], end: int, more: int
    ) -> Ints:
        """Number the surfaces by their leads; return for each its new number, -1 for one that is gone, and at the end.

        `inserted`: (slot, kind, row, its number before or -1, ...), by slots.
        """
        rows, single, count, slots = self.rows, self.single, len(self.single), [slot for slot, *_ in inserted]
        onto = np.arange(count + 1, dtype=np.int32)
        onto[count] = -1
        self._inserted = np.zeros(0, np.int64)
        if not (removed or inserted or more):
            return onto
        # Outside of lo:hi nothing changes where as many surfaces come as go
        at = np.searchsorted(single, slots)
        lo, hi = int(min([*removed, *at, *([np.searchsorted(single, end)] if more else [])])), count
        if len(removed) == len(inserted) and not more:
            hi = min(count, int(max([*removed, *at])) + 1)
        kept = np.delete(np.arange(lo, hi), np.array(removed, np.int64) - lo)
        leads = single[kept]
        leads += more * (leads >= end)
        at = np.searchsorted(leads, slots)
        self._inserted = lo + at + np.arange(len(at))
        onto[removed] = -1
        onto[kept] = np.delete(np.arange(lo, hi - len(removed) + len(inserted)), self._inserted - lo)
        for place, (_, _, _, known, _) in zip(self._inserted.tolist(), inserted, strict=True):
            if known >= 0:
                onto[known] = place
        leads = np.insert(leads, at, slots)
        if hi < count and np.array_equal(leads, single[lo:hi]):
            leads = single[lo:hi]
        else:
            self.single = np.concatenate([single[:lo], leads, single[hi:]])
        for which, name in enumerate(("surface_kind", "surface_row"), start=1):
            column = np.insert(rows[name][kept], at, [each[which] for each in inserted])
            if len(leads) != hi - lo:
                rows.resize(name, len(self.single))
            rows[name][lo : lo + len(column)] = column
        # A surface with another lead may have another number where all others keep theirs
        staying = np.concatenate([kept, np.array([known for *_, known, _ in inserted if known >= 0], np.int64)])
        if (onto[staying] != staying).any():
            for name in _NAMES_OF_SURFACES:
                np.take(onto, rows[name], out=rows[name], mode="wrap")
            balls = np.array([each for each in self.loose if rows["entry_kind"][each] == BALL], np.int64)
            rows["entry_index"][balls] = onto[rows["entry_index"][balls]]
        return onto

    # --- The new body

    def _append_body(self, entry: int, new: LoweredScene, surfaces: Ints, flipped: Ints) -> None:
        """Append the cells, the program and the faces of a new body, with limits, and make it the entry's."""
        t, rows = new.tables, self.rows
        curved, count = t.cell_quadric >= 0, len(t.cell_quadric)
        quadrics = np.where(curved, surfaces[t.cell_quadric], -1)
        faces = cell_faces(t, np.arange(count)) * np.where(curved, flipped[t.cell_quadric], 1)
        cell = rows.append("cell_quadric", quadrics)
        place = rows.append("plane_surface", surfaces[t.plane_surface])
        self._append_plane_faces(place, plane_faces(t, np.arange(len(t.plane_surface))))
        rows.append("cell_first", place + t.cell_first[1:])
        like = rows.append("cell_face", np.abs(faces))
        rows.append("cell_likes", 2 * (like + np.arange(count)) + (faces < 0))
        kind, index = int(t.entry_kind[0]), int(t.entry_index[0])
        limits = no_limits(count)
        if kind != BALL:
            used = np.flatnonzero(curved)
            owners = np.repeat(np.arange(count), np.diff(t.cell_first))
            uses = np.concatenate([quadrics[used], surfaces[t.plane_surface]]), np.concatenate([used, owners])
            limits = self.limits.add_uses(entry, uses, count, new.boxes[0])
        rows.append("cell_limits", limits)
        if kind == REGION:
            index = self._append_program(t, cell, limits)
        else:
            index = int(surfaces[index]) if kind == BALL else cell + index
        self._append_faces(entry, new)
        rows["entry_kind"][entry], rows["entry_index"][entry] = kind, index
        self.body_frame[entry] = sum(map(len, self.frames))
        self.frames.append(new.frames)

    def _append_plane_faces(self, place: int, faces: Ints) -> None:
        """Append the faces of planes, four to an integer where those before are."""
        rows = self.rows
        if len(rows["plane_face"]) == place:
            rows.append("plane_face", faces)
            return
        if np.abs(faces).max(initial=0) > 127:
            raise UneditableError
        packed = rows.resize("plane_face", -(-(place + len(faces)) // 4))
        packed.view(np.int8)[place : place + len(faces)] = faces

    def _append_program(self, t: Tables, cell: int, limits: Floats) -> int:
        """Append a program; return its number."""
        rows, places = self.rows, self.rows.geometry.places
        program = len(rows["program_leaf"]) - 1
        leaves, gates = len(t.leaf_cell), len(t.gate_parent)
        rows["program_leaf"][-1] = cell + int(t.leaf_cell[0]) if leaves else cell
        rows.append("program_leaf", [len(rows["cell_quadric"])])
        gate = rows.append("gate_parent", t.gate_parent)
        parents = rows["gate_parent"][gate:]
        parents[parents >= 0] += gate
        for name in ("gate_need", "gate_negated", "gate_start", "leaf_negated", "leaf_sense", "leaf_bounds"):
            rows.append(name, getattr(t, name))
        rows.append("leaf_gate", t.leaf_gate + gate)
        model = rows.append("program_limits", program_limits(np.zeros(leaves, np.int32), limits[t.leaf_cell], 1))
        rows.append("program_gate", [gate + gates])
        rows.append("program_row", [int(rows["program_row"][-1]) + leaves])
        rows.append("program_shifts", [[0, 0, 0, model]])
        places[STEPS] += leaves * gates
        places[LEAVES], places[GATES] = max(places[LEAVES], leaves), max(places[GATES], gates)
        return program

    def _append_faces(self, entry: int, new: LoweredScene) -> None:
        """Append the maps of faces; rows of later bodies' faces move, as many as the faces are more."""
        t, rows = new.tables, self.rows
        first = int(rows["body_face"][entry])
        if entry + 1 < len(rows["body_face"]):
            end = int(rows["body_face"][entry + 1])
            more = len(t.face_maps) - (end - first)
            if more:
                rows["body_face"][entry + 1 :] += more
            self.paint = {
                k + (more if k >= end else 0): paint for k, paint in self.paint.items() if not first <= k < end
            }
        else:
            self.paint = {k: paint for k, paint in self.paint.items() if k < first}
        self.paint |= {first + face: paint for face, paint in new.face_paint.items()}
        if not len(rows["body_maps"]):
            raise UneditableError
        base = rows.append("map_rows", t.map_rows)
        angular = t.face_maps < 0
        maps = (np.where(angular, -1 - t.face_maps, t.face_maps) + base) << WHICH_BITS
        rows["body_maps"][entry] = rows.append("face_maps", np.where(angular, -1 - maps, maps)), 0, 0, 0


def _slots(lowered: LoweredScene) -> int:
    """Return how many surfaces the bodies of a scene came with."""
    assert lowered.layout is not None
    return len(lowered.layout.kinds)


def _record(tables: Tables, rest: Remainders, surface: int) -> tuple[int, Floats]:
    """Return the kind of a surface, and its record with what rounding removed."""
    kind, row = int(tables.surface_kind[surface]), int(tables.surface_row[surface])
    if kind == QUADRIC:
        return kind, np.concatenate([tables.whole_quadrics([row])[0], rest.quadrics[int(tables.quadrics[row, 3])]])
    name = _TABLES_OF_KINDS[kind]
    return kind, np.concatenate([getattr(tables, name)[row], getattr(rest, name)[row]])


def _rank(record: tuple[int, Floats]) -> tuple[Any, ...]:
    """Return what decides which of equal surfaces leads: the least comes first."""
    kind, numbers = record
    return kind != SPHERE, *numbers[: SIZES[kind]].tolist()


def edit_lattice(
    lowered: LoweredScene, places: Longs, woods: SceneTrees, state: LatticeState, old: InstanceList,
    bodies: InstanceList, entries: list[int],
) -> tuple[LoweredScene, Geometry, SceneTrees, LatticeState] | None:  # fmt: skip
    """Edit a scene with instances.

    Parameters
    ----------
    lowered, places, woods, state : LoweredScene, Longs, SceneTrees, LatticeState
        The scene before; nothing else that reads its memory may be held by the caller.
    old, bodies : InstanceList
        Its bodies, and those of the edited scene.
    entries : list[int]
        Where they differ.

    Returns
    -------
    tuple[LoweredScene, Geometry, SceneTrees, LatticeState] or None
        None where the scene must be prepared afresh.
    """
    memory = state.memory
    claim = memory.claim() if memory is not None else None
    if memory is None or memory.store is None or claim is None:
        return None
    opened = claim.buffer
    if opened is None:  # somebody reads the scene before
        floats = line_array(len(memory.store.floats))
        floats[:] = memory.store.floats
        opened = OpenBuffer(SceneBuffer(memory.store.integers.copy(), floats))
    geometry = Geometry(places.copy(), *opened.arrays)
    geometry.places[HALT] = 0
    try:
        edit = LatticeEdit(lowered, geometry, woods, state, old, bodies, entries)
    except UneditableError:
        return None
    memory = opened.memory(memory.stores, memory.stamps, 0)
    opened.close(memory, None)
    found, woods, state = edit.finished(memory)
    return found, geometry, woods, state
