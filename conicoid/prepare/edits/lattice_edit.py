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
import math
import sys
from typing import Any, TypeAlias

import numpy as np

from ..._util.arrays import unique_with_inverse
from ..._util.dataclass import dataclass
from ...geometry.instance_edits import InstanceOrigins
from ...geometry.instances import InstanceList, transform_offsets
from ...geometry.shape import Shape
from ...kernels.bvh.walk import FEW, ROUND, ROWS, WHO
from ...kernels.faces import cell_faces, plane_faces
from ...kernels.programs import cells_of_leaves, gates_of_program, leaves_of_program
from ...kernels.surface.doubt import KAPPA
from ...kernels.tables import (
    BALL,
    CELL,
    GATES,
    HALT,
    LEAVES,
    LENGTHS,
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
from ..bvh.builder import WIDTH, leaf_code
from ..bvh.leaf_items import put_items
from ..bvh.plane_groups import group_tables
from ..bvh.trees import COSTS, Forest, SceneTrees
from ..error_limits import (
    LimitMaxima,
    RecordTables,
    compute_limits,
    no_limits,
    program_limits,
    put_limits_of_planes,
    put_limits_of_quadrics,
    size_of_records,
    weigh_all,
)
from ..instances import FEWEST_INSTANCES
from ..lower_shape import lower_shape
from ..lowering import ExactTables, InstanceShapes, LazyBounds, LoweredScene, lower
from ..mmap_arrays import mapped_zeros
from ..pattern import SIZES, shift_boxes
from ..surface_features import Remainders
from ..tables_builder import WHICH_BITS
from .buffer_pool import BufferPool, EditState, OpenBuffer, PoolMemory, SceneBuffer
from .neighbour_index import NeighbourFrame, NeighbourPlaces, find_neighbours, surface_columns

MOST_EXCHANGED = 64
"""More bodies at a time are prepared afresh with all others."""
_MOST_MEMBERS = 16
"""Larger classes that lose their lead are not searched for another."""
_ROOM = 1 << 12
"""Rows of each table behind those of a scene of many bodies."""
_TABLES_OF_KINDS = {PLANE: "planes", SPHERE: "spheres", QUADRIC: "quadrics"}
_NAMES_OF_SURFACES = "cell_quadric", "plane_surface", "sheet_surface", "polygon_surface"
_NEAR = 1e-12
_Uses: TypeAlias = dict[tuple[int, int], Floats]
"""(kind, row of limits) of a surface -> its column in `LimitMaxima`, of one body alone."""


class _Afresh(Exception):
    """The edited scene must be prepared afresh."""


@dataclass(frozen=True)
class LatticeState(EditState):
    """What the next edit needs: the uses that limits come from, and what earlier edits have added."""

    maxima: LimitMaxima | None = None
    loose: dict[int, Floats] = dataclasses.field(default_factory=dict)  # entry of the small tree -> its box
    added: NeighbourPlaces | None = None  # places of surfaces behind those of `places`
    uses: dict[int, _Uses] = dataclasses.field(default_factory=dict)  # entry of the small tree -> reaches and the like
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


def exchanged_entries(old: InstanceList, new: InstanceList) -> list[int] | None:
    """Return the entries in which two lists differ; None where there are too many, or one has more entries."""
    if len(old) != len(new):
        return None
    its, mine = InstanceOrigins.of(old), InstanceOrigins.of(new)
    if its.base is not mine.base:
        return None
    places = np.flatnonzero((its.numbers != mine.numbers) | (mine.numbers < 0))
    some = places[: len(its.own) + len(mine.own) + MOST_EXCHANGED].tolist()
    found = [k for k in some if its.shape(int(its.numbers[k])) is not mine.shape(int(mine.numbers[k]))]
    return found if len(places) == len(some) and 0 < len(found) <= MOST_EXCHANGED else None


class _Rows:
    """Tables that grow: their rows by name, and their room."""

    def __init__(self, geometry: Geometry, tables: Tables) -> None:
        self.geometry = geometry
        self.shapes = {name: (k, *column.shape[1:]) for k, (name, column) in enumerate(tables._asdict().items())}
        self._real = [column.dtype == np.float64 for column in tables]
        ends = [
            np.append(np.sort(geometry.places[:LENGTHS][np.array(self._real) == real]), len(numbers))
            for real, numbers in ((False, geometry.integers), (True, geometry.floats))
        ]
        begins = geometry.places[:LENGTHS].tolist()
        self._room = [
            int(ends[r][np.searchsorted(ends[r], b, "right")]) - b for r, b in zip(self._real, begins, strict=True)
        ]

    def __getitem__(self, name: str) -> Any:
        return self.span(name, int(self.geometry.places[LENGTHS + self.shapes[name][0]]))

    def span(self, name: str, size: int) -> Any:
        """Return so many numbers of a table, in rows."""
        k, *row = self.shapes[name]
        if size > self._room[k]:
            raise _Afresh
        numbers: Any = self.geometry.floats if self._real[k] else self.geometry.integers
        begin = int(self.geometry.places[k])
        return numbers[begin : begin + size].reshape(-1, *row)

    def resize(self, name: str, rows: int) -> Any:
        """Set the number of rows of a table; return the table."""
        k, *row = self.shapes[name]
        found = self.span(name, rows * math.prod(row))
        self.geometry.places[LENGTHS + k] = found.size
        return found

    def append(self, name: str, rows: Any) -> int:
        """Append rows to a table; return the number of the first."""
        first = len(self[name])
        self.resize(name, first + len(rows))[first:] = rows
        return first

    def tables(self) -> Tables:
        """View all tables."""
        return Tables(**{name: self[name] for name in self.shapes})


@dataclass
class _OldBody:
    """A body that leaves: its cells, the places of their planes, its surfaces, and its slots begin..end."""

    shape: Shape
    cells: Longs
    planes: Longs
    owners: Longs  # the position in `cells` of the owner of each of `planes`
    begin: int
    end: int
    box: Floats
    alike: bool  # does it share rows with translated copies?

    def uses(self, rows: _Rows) -> tuple[Longs, Longs]:
        """Return (surface, position of the cell that it bounds) for each use of a surface."""
        quadrics = rows["cell_quadric"][self.cells]
        curved = np.flatnonzero(quadrics >= 0)
        found = np.concatenate([quadrics[curved], rows["plane_surface"][self.planes]])
        return found, np.concatenate([curved, self.owners])


class LatticeEdit:
    """Exchanges bodies of a scene with instances in tables that nobody else reads, or raises `_Afresh`."""

    def __init__(
        self, lowered: LoweredScene, geometry: Geometry, woods: SceneTrees, state: LatticeState, old: InstanceList,
        bodies: InstanceList, entries: list[int],
    ) -> None:  # fmt: skip
        assert state.maxima is not None
        assert isinstance(lowered.bounds, LazyBounds)
        self.lowered, self.old, self.bodies, self.woods, self.state = lowered, old, bodies, woods, state
        self.rows, self.rest, self.maxima = _Rows(geometry, lowered.tables), lowered.rest, state.maxima.copy()
        self.shapes = InstanceShapes(bodies, {entry: old.shape(entry) for entry in entries})
        self.exact: ExactBodySurfaces = lowered.exact.bodies.of(self.shapes)
        self.single, self.groups, self.loose = lowered.exact.single, list(lowered.bounds.groups), dict(state.loose)
        self.frames, self.body_frame, self.paint = [lowered.frames], lowered.body_frame.copy(), lowered.face_paint
        self.frame, self.places, self.added = state.frame, state.places, state.added
        self.weigh_anew, self.uses = False, dict(state.uses)
        balls = np.flatnonzero(self.rows["entry_kind"] == BALL)
        if not len(self.rows["cell_likes"]) or set(balls.tolist()) - set(self.loose) or sys.byteorder != "little":
            raise _Afresh
        for entry in entries:
            self._exchange(entry)
            del self.shapes.pending[entry]
        self._plant()

    def finished(self, memory: PoolMemory) -> tuple[LoweredScene, SceneTrees, LatticeState]:
        """Return the edited scene, its trees, and the state for the next edit."""
        bounds, tables = LazyBounds(self.bodies, self.groups), self.rows.tables()
        lowered = dataclasses.replace(
            self.lowered, tables=tables, bounds=bounds, frames=np.concatenate(self.frames), body_frame=self.body_frame,
            face_paint=self.paint, rest=self.rest, exact=ExactTables(self.exact, self.single),
        )  # fmt: skip
        if self.weigh_anew:
            self._weigh_base(bounds.boxes)
            bounds.release()
        state = LatticeState(
            self.frame,
            self.places,
            None,
            memory,
            maxima=self.maxima,
            loose=self.loose,
            added=self.added,
            uses=self.uses,
            shared=self.state.shared,
        )
        return lowered, self.woods, state

    def _exchange(self, entry: int) -> None:
        """Exchange one body."""
        new = lower((self.bodies[entry],))
        kind, cells = int(new.tables.entry_kind[0]), new.tables.cell_first
        boxes = np.isfinite(new.boxes).all()
        if (
            kind not in (BALL, CELL, REGION) or not (boxes or self.maxima.size) or len(new.frames) != 1
            or len(self.rows["cell_groups"]) or len(group_tables(np.diff(cells))["cell_groups"])
            or (kind == REGION and (len(new.tables.leaf_cell) > FEW or not len(self.rows["program_shifts"])))
        ):  # fmt: skip
            raise _Afresh
        old = self._take_out(entry)
        surfaces, flipped = self._exchange_surfaces(entry, old, new)
        self._append_body(entry, new, surfaces, flipped)
        self.groups.append((np.array([entry], np.int32), new.boxes))
        self.loose[entry] = new.boxes[0]

    # --- The old body

    def _take_out(self, entry: int) -> _OldBody:
        """Describe the old body, take it out of the tree and of the groups, and out of what limits hold for."""
        tables, first = self.rows.tables(), self.exact.first
        cells = self._cells_of(tables, entry)
        if tables.entry_kind[entry] == REGION:
            gates = gates_of_program(tables, int(tables.entry_index[entry]))
            self.rows.geometry.places[STEPS] -= len(cells) * len(gates)
        planes, owners = _planes_of(tables, cells)
        shape, begin = self.shapes[entry], int(first[entry])
        last = entry + 1 == len(first)
        end = begin + len(lower_shape(shape).pattern.kinds) if last else int(first[entry + 1])
        old = _OldBody(shape, cells, planes, owners, begin, end, *self._leave_group(entry, planes))
        if not np.isfinite(old.box).all():
            raise _Afresh
        if entry in self.loose:
            del self.loose[entry]
        else:
            self._leave_tree(entry)
        return old

    @staticmethod
    def _cells_of(tables: Tables, entry: int) -> Longs:
        """Return the cells of a body."""
        kind, index = int(tables.entry_kind[entry]), int(tables.entry_index[entry])
        if kind == REGION:
            return cells_of_leaves(tables, np.array(leaves_of_program(tables, index), np.int64))
        cells = np.flatnonzero(tables.cell_quadric == index) if kind == BALL else np.array([index])
        if kind not in (BALL, CELL) or len(cells) != 1:
            raise _Afresh
        return cells

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
            raise _Afresh
        origins = InstanceOrigins.of(self.old)
        base, mine, its = origins.base, *(int(origins.numbers[each]) for each in (entry, numbers[0]))
        away = np.array([[float(a - b) for a, b in zip(base.shifts.of(mine), base.shifts.of(its), strict=True)]])
        rows = self.rows["surface_row"][self.rows["plane_surface"][planes]]
        if (np.count_nonzero(self.rows["planes"][rows, :3], axis=1) > 1).any():
            # Records of slanted planes are those of the bodies nearest to a diagonal, which ends at the outmost ones
            index = base.shifts.index[:, origins.numbers[numbers]]
            if (index[:, i] == index.max(axis=1)).any() or len(numbers) % 8 == 0:
                raise _Afresh
        return shift_boxes(known, transform_offsets(away, base.motion(int(base.kinds[mine]))))[0], True

    def _leave_tree(self, entry: int) -> None:
        """Take an entry out of its leaf; boxes of nodes stay."""
        rows, woods = self.rows, self.woods
        base, order = int(woods.places[-1]), rows["tree_order"]
        place = base + int(np.flatnonzero(order[base : woods.main[1]] == entry)[0])
        children = rows["node_children"][: woods.main[0]].reshape(-1)
        # A leaf with this place begins at most 15 before
        near = np.flatnonzero((children >= leaf_code(place, 15)) & (children <= leaf_code(max(place - 15, 0), 0)))
        codes = -children[near] - 1
        near = near[(codes >> 4 <= place) & (place < (codes >> 4) + (codes & 15))]
        if len(near) != 1 or 4 * (woods.removals + 1) > len(order):
            raise _Afresh
        child = int(near[0])
        begin, count = (-int(children[child]) - 1) >> 4, (-int(children[child]) - 1) & 15
        at = ROWS * (begin - base)
        block = rows["leaf_items"][at : at + ROWS * count]
        items = block.reshape(ROWS, count).copy()
        mark = items[WHO, 0] % 1.0
        assert mark in (0.0, ROUND)
        items[WHO, 0] -= mark
        items = np.delete(items, place - begin, axis=1)
        items[WHO, :1] += mark
        block[:] = np.append(items.ravel(), np.zeros(ROWS))
        order[begin : begin + count] = np.append(np.delete(order[begin : begin + count], place - begin), -1)
        children[child] = leaf_code(begin, count - 1) if count > 1 else 0
        if count == 1:
            box = rows["node_boxes"][child // WIDTH, :, child % WIDTH]
            box[:3], box[3:] = np.inf, -np.inf
        self.woods = dataclasses.replace(woods, removals=woods.removals + 1)

    # --- Surfaces

    def _exchange_surfaces(self, entry: int, old: _OldBody, new: LoweredScene) -> tuple[Ints, Ints]:
        """Number the surfaces anew; return for each of the new body its number, and -1 where its sense is another's."""
        rows, single, more = self.rows, self.single, _slots(new) - (old.end - old.begin)
        surfaces, owners = old.uses(rows)
        ids = np.unique(surfaces)
        leads: dict[int, int] = {}  # surface that stays -> the slot that leads it now
        vanish: set[int] = set()
        for number in ids[(single[ids] >= old.begin) & (single[ids] < old.end)].tolist():
            slot = self._other_lead(number, old)
            if slot is None:
                vanish.add(number)
            else:
                leads[number] = slot + (more if slot >= old.end else 0)
        self._forget_uses(entry, old, surfaces, owners, vanish)
        equal = self._equal_surfaces(new, vanish)
        own, flipped = np.empty(len(new.exact.single), np.int32), np.ones(len(new.exact.single), np.int32)
        fresh = []
        for number, slot in enumerate((old.begin + new.exact.single).tolist()):
            if number not in equal:
                fresh.append((slot, number))
                continue
            known, flipped[number] = equal[number]
            lead = leads.get(known, int(single[known]) + (more if single[known] >= old.end else 0))
            mine, its = _record(new.tables, new.rest, number), _record(rows.tables(), self.rest, known)
            # The least record leads, of equal ones that of the first slot
            if (_rank(mine), slot) < (_rank(its), lead):
                leads[known] = slot
                if mine[1].tobytes() != its[1].tobytes():
                    self._replace_record(new, number, known, int(flipped[number]))
        rows["cell_quadric"][old.cells] = rows["plane_surface"][old.planes] = -1
        # What leads, by slots: (slot, kind, row, surface, surface of the new body)
        moved = [(slot, *self._kind_and_row(known), known, -1) for known, slot in leads.items()]
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

    def _kind_and_row(self, surface: int) -> tuple[int, int]:
        return int(self.rows["surface_kind"][surface]), int(self.rows["surface_row"][surface])

    def _other_lead(self, surface: int, old: _OldBody) -> int | None:
        """Return the slot that leads a surface without the old body; None where nobody else has the surface."""
        tables = self.rows.tables()
        kind, _ = self._kind_and_row(surface)
        if kind == PLANE:
            places = np.setdiff1d(np.flatnonzero(tables.plane_surface == surface), old.planes)
            cells = np.searchsorted(tables.cell_first, places.astype(np.int32), side="right") - 1
        else:
            cells = np.setdiff1d(np.flatnonzero(tables.cell_quadric == surface), old.cells)
        if not len(cells):
            return None
        known = _record(tables, self.rest, surface)
        if len(cells) > _MOST_MEMBERS or (kind == PLANE and np.count_nonzero(known[1][:3]) > 1):
            raise _Afresh
        key, found = self.exact.name(int(self.single[surface]))[0], []
        for body in {self._body_of(tables, cell) for cell in cells.tolist()}:
            part, first = lower_shape(self.shapes[body]), int(self.exact.first[body])
            for own, (its, column, sense) in enumerate(part.pattern.records):
                if (its == PLANE) == (kind == PLANE) and self.exact.name(first + own)[0] == key:
                    found.append(((its, np.array(part.row[column:sense])), first + own))
        lead, slot = min(found, key=lambda each: (_rank(each[0]), each[1]))
        if lead[0] != kind or lead[1].tobytes() != known[1].tobytes():
            raise _Afresh
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
            raise _Afresh
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
            self.maxima.extend(kind)
        if kind != QUADRIC:
            self.rest = dataclasses.replace(self.rest, **{name: np.concatenate([getattr(self.rest, name), lost])})
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
        self.maxima.extend(QUADRIC)
        lost = np.concatenate([self.rest.quadrics, new.rest.quadrics[form : form + 1]])
        self.rest = dataclasses.replace(self.rest, quadrics=lost)
        return record

    def _replace_record(self, new: LoweredScene, number: int, known: int, turned: int) -> None:
        """Let an equal surface of the new body give the record of a known one; all its uses are weighed again."""
        (kind, row), mine = self._kind_and_row(known), int(new.tables.surface_row[number])
        if turned < 0 or kind == SPHERE or kind != new.tables.surface_kind[number]:
            raise _Afresh
        if kind == QUADRIC:
            self.rows["quadrics"][row] = self._append_form(new, mine)
        else:
            self.rows["planes"][row] = new.tables.planes[mine]
            planes = self.rest.planes.copy()
            planes[row] = new.rest.planes[mine]
            self.rest = dataclasses.replace(self.rest, planes=planes)
        self.weigh_anew = True

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

    # --- Limits

    def _weigh(
        self, surfaces: Longs, owners: Longs, count: int, box: Floats
    ) -> tuple[Any, RecordTables, Floats, Floats]:
        """Weigh the uses of a body: (its surfaces, their records, the largest reach and the like, limits of cells)."""
        ids, at = unique_with_inverse(surfaces)
        tables = self.rows.tables()
        records = RecordTables.of(
            tables._replace(surface_kind=tables.surface_kind[ids], surface_row=tables.surface_row[ids]), self.rest
        )
        limits, most = no_limits(count), np.zeros((3, len(ids)))
        weigh_all(records, box[None], self.maxima.size or 1.0, (at, at, owners, np.zeros(len(at))), limits, most)
        return ids, records, most, limits

    def _forget_uses(self, entry: int, old: _OldBody, surfaces: Longs, owners: Longs, vanish: set[int]) -> None:
        """Take the uses of the old body back, or see whether it has set a limit: all are computed again then."""
        rows = self.rows
        ids, records, most, limits = self._weigh(surfaces, owners, len(old.cells), old.box)
        if self.uses.pop(entry, None) is not None:
            self._put_limits_of(ids, records)
            return
        self.weigh_anew |= bool(self.maxima.size and self._size(records, old.box) >= self.maxima.size)
        for k, surface in enumerate(ids.tolist()):
            kind, row = self._limit_row(surface)
            if kind == SPHERE or (surface in vanish and (kind == PLANE or not old.alike)):
                continue
            column = self.maxima.column(kind, row)
            # A kappa of its own depends on the reach, in quadrics with a rounded anchor
            self.weigh_anew |= bool(most[0, k] >= column[0] * (1 - _NEAR))
            self.weigh_anew |= bool(kind == QUADRIC and most[1, k] > KAPPA and most[1, k] >= column[1] * (1 - _NEAR))
        if old.alike:
            known = rows["cell_limits"][rows["cell_likes"][old.cells] >> 1]
            self.weigh_anew |= bool((limits[:, 0] >= known[:, 0] * (1 - _NEAR)).any())
            self.weigh_anew |= bool((limits[:, 1] <= known[:, 1] * (1 + _NEAR)).any())

    def _limit_row(self, surface: int) -> tuple[int, int]:
        """Return the kind of a surface and the row of its limits: that of a plane, or of the form of a quadric."""
        kind, row = self._kind_and_row(surface)
        return kind, int(self.rows["quadrics"][row, 3]) if kind == QUADRIC else row

    def _weigh_base(self, boxes: Floats) -> None:
        """Compute the limits from all bodies again: first without those of the small tree, which then widen them."""
        tables = self.rows.tables()
        kinds = tables.entry_kind.copy()
        kinds[list(self.loose)] = -1
        limits, self.maxima = compute_limits(tables._replace(entry_kind=kinds), boxes, self.rest)
        for name, count in zip(("plane", "quadric", "cell", "program"), (None, None, *self.state.shared), strict=True):
            getattr(tables, f"{name}_limits")[:count] = limits[f"{name}_limits"][:count]
        for entry in list(self.uses):
            cells = self._cells_of(tables, entry)
            planes, owners = _planes_of(tables, cells)
            old = _OldBody(self.shapes[entry], cells, planes, owners, 0, 0, self.loose[entry], False)
            self._use(entry, *old.uses(self.rows), len(cells), self.loose[entry])

    @staticmethod
    def _size(records: RecordTables, box: Floats) -> float:
        """Return the largest finite length of a body."""
        planes, quadrics = (records.row[records.kind == kind] for kind in (PLANE, QUADRIC))
        anchors = records.quadrics[quadrics].copy()
        forms = records.forms[anchors[:, 3].astype(np.intp)]
        return size_of_records(records.planes[planes], anchors, forms, np.ascontiguousarray(box[None]))

    def _use(self, entry: int, surfaces: Longs, owners: Longs, count: int, box: Floats) -> Floats:
        """Widen the limits of the surfaces of a body of the small tree; return those of its cells."""
        ids, records, most, limits = self._weigh(surfaces, owners, count, box)
        if self.maxima.size and self._size(records, box) > self.maxima.size:
            raise _Afresh
        self.uses[entry] = {self._limit_row(surface): most[:, k] for k, surface in enumerate(ids.tolist())}
        self._put_limits_of(ids, records)
        return limits

    def _put_limits_of(self, ids: Longs, records: RecordTables) -> None:
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
            limits = self._use(
                entry, np.concatenate([quadrics[used], surfaces[t.plane_surface]]), np.concatenate([used, owners]),
                count, new.boxes[0],
            )  # fmt: skip
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
            raise _Afresh
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
            raise _Afresh
        base = rows.append("map_rows", t.map_rows)
        angular = t.face_maps < 0
        maps = (np.where(angular, -1 - t.face_maps, t.face_maps) + base) << WHICH_BITS
        rows["body_maps"][entry] = rows.append("face_maps", np.where(angular, -1 - maps, maps)), 0, 0, 0

    # --- The tree

    def _plant(self) -> None:
        """Build the small tree over the new entries behind the large one."""
        rows, (nodes, places, roots), base = self.rows, self.woods.main, int(self.woods.places[-1])
        entries = np.array(sorted(self.loose), np.int32)
        if len(entries) > max(16.0, math.sqrt(len(self.bodies))):
            raise _Afresh
        # Only the boxes of these entries are read
        boxes = mapped_zeros((len(self.bodies), 6), np.float64, sparse=True)
        forest, order = Forest(nodes, places), rows["tree_order"]
        if len(entries):
            boxes[entries] = [self.loose[entry] for entry in entries.tolist()]
            if not np.isfinite(boxes[entries]).any(axis=1).all():
                raise _Afresh
            forest.add(boxes[entries], 0, COSTS[rows["entry_kind"][entries]])
        main = int(rows["tree_root"][-2])
        for code in rows["roots"][main:roots].tolist():
            if code < 0:  # entries without an end: their leaves are written again
                begin = (-code - 1) >> 4
                boxes[order[begin : begin + ((-code - 1) & 15)]] = [-np.inf] * 3 + [np.inf] * 3
        rows.resize("tree_order", places + len(entries))[places:] = entries[np.concatenate(forest.order)]
        rows.resize("leaf_items", ROWS * (places - base + len(entries)))
        children = np.concatenate(forest.children)
        rows.resize("node_children", nodes + len(children))[nodes:] = children
        rows.resize("node_boxes", nodes + len(children))
        forest.put_boxes(rows["node_boxes"][nodes:].reshape(-1), 0)
        rows.resize("roots", roots + len(forest.roots))[roots:] = forest.roots
        rows["tree_root"][-1] = roots + len(forest.roots)
        levels = max(self.woods.levels, forest.levels)
        stack = len(rows["roots"]) - main + WIDTH * (levels + 1)
        rows["tree_depth"][0] = max(self.woods.depth, stack)
        put_items(rows.geometry, boxes, base, [(WIDTH * nodes, WIDTH * (nodes + len(children)))])
        self.woods = dataclasses.replace(self.woods, loose=entries)


def _planes_of(tables: Tables, cells: Longs) -> tuple[Longs, Longs]:
    """Return the places of the planes of some cells, and for each the position of its cell among these."""
    ends = [np.arange(*tables.cell_first[cell : cell + 2].tolist()) for cell in cells.tolist()]
    owners = np.repeat(np.arange(len(cells)), [len(each) for each in ends])
    return np.concatenate(ends) if ends else owners, owners


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
    except _Afresh:
        return None
    memory = opened.memory(memory.stores, memory.stamps, 0)
    opened.close(memory, None)
    found, woods, state = edit.finished(memory)
    return found, geometry, woods, state
