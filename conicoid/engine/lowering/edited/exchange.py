"""Scenes in which entries are exchanged for others with as many rows: a body that was moved, nearly always.

All other rows stay where they are, and as they are but for what is said of surfaces that are one with new ones, or were
one with some that are gone (`regrouped`). So the memory of a scene that is gone is taken (`stores`), and only the rows
of some entries are written: of those that are new, and of those in which that scene differs from the one before.
"""

from __future__ import annotations

import dataclasses
from collections.abc import Mapping, Sequence
from typing import Any

import numpy as np

from ....shapes.body import Body
from ...tables import BALL, Floats, Geometry, Longs, Tables, put_sizes, shared
from .. import ExactTables, Lowered
from ..contents import ShapesOf
from ..laid import BODIES, CORNERS, FRAMES, PLANES, QUADRICS, SPHERES, SURFACES, Laid
from ..surfaces import Remainders
from .columns import TREES
from .differing import Differing, LimitsOfExchanged
from .joined import Joined
from .kept import Kept, Known
from .near import Frame, Places, records_of
from .pieces import Pieces, Runs
from .regrouped import Regrouped, entries_of
from .stores import Claim, Memory, Opened, new_edit, restamped, stamped

_MOST = 128
"""So many pieces are written one by one; more are as well written all at once."""
BESIDE = {
    "boxes": BODIES, "frames": FRAMES, "planes": PLANES, "spheres": SPHERES, "quadrics": QUADRICS, "vertices": CORNERS,
    "place_of_planes": PLANES, "place_of_spheres": SPHERES, "place_of_quadrics": QUADRICS,
    "mark_of_planes": PLANES, "mark_of_spheres": SPHERES, "mark_of_quadrics": QUADRICS,
}  # fmt: skip
"""What a store has beside the tables, and what its rows are of."""
_PLACED = 1 << 18
"""So many surfaces have places from the beginning: ten bytes each, and a hundredth of the time that they take."""
_OF_SURFACES = "surface_kind", "surface_row"
"""Tables with as many rows as there are surfaces."""
_OF_FRAMES = "place", "mark"
"""How the names begin of what is relative to a frame (`near`)."""


def _beside(lowered: Lowered, places: Places) -> dict[str, Any]:
    """What a scene's store has beside the tables."""
    return dict(zip(BESIDE, (*_first_beside(lowered), *_of_places(places)), strict=True))


def _of_places(places: Places) -> tuple[Any, ...]:
    """Of these what is relative to a frame."""
    return places.planes, places.spheres, places.quadrics, *places.marks


def _raw_places(opened: Opened) -> Places:
    """Those that a store has, in arrays that do not say whether the scene is held."""
    return Places.marked(*(opened.raw(name) for name in BESIDE if name.startswith(_OF_FRAMES)))


def _first_beside(lowered: Lowered) -> tuple[Any, ...]:
    """Of these what it has though nothing was edited."""
    rest = lowered.rest
    return lowered.boxes, lowered.frames, rest.planes, rest.spheres, rest.quadrics, rest.vertices


def _with_beside(lowered: Lowered, tables: Tables, beside: Mapping[str, Any]) -> Lowered:
    rest = Remainders(beside["planes"], beside["spheres"], beside["quadrics"], beside["vertices"])
    return dataclasses.replace(lowered, tables=tables, around=beside["boxes"], frames=beside["frames"], rest=rest)


def in_store(lowered: Lowered, opened: Opened) -> tuple[Lowered, Kept]:
    """A scene that was prepared from the beginning, whose tables are in a store: all of it is, from now on.

    The arrays beside the tables are nobody's but its own. Places of surfaces are worked out, so that the first edit
    need not go over all of them, if they are not so many that memory for them matters more.
    """
    records, frame, places = records_of(lowered.tables), None, None
    beside: tuple[Any, ...] = _first_beside(lowered)
    if sum(len(table) for table in records) <= _PLACED:
        frame, (found,) = Frame.around(records)
        beside = *beside, *_of_places(found)
    for name, column in zip(BESIDE, beside, strict=False):
        whole = column.flags.writeable and not isinstance(column.base, np.ndarray)
        opened.put(name, column if whole else column.copy())
    if frame is not None:
        places = _raw_places(opened)
    assert lowered.laid is not None
    memory = Memory.new(len(lowered.laid.first_body) - 1)
    memory = opened.memory(memory.stores, memory.stamps, memory.numbers)
    opened.close(memory, frame)
    return _with_beside(lowered, lowered.tables, opened.beside), Kept(frame, places, memory=memory)


def let_go(lowered: Lowered, geometry: Geometry, memory: Memory) -> Lowered:
    """The same in arrays that do not hold its memory: whoever reads them claims it (`Memory.claim`)."""
    store = memory.store
    if store is None:
        return lowered
    raw = shared(lowered.tables, geometry._replace(integers=store.integers, floats=store.floats))
    return _with_beside(lowered, raw, store.beside)


class Exchange:
    """A scene some of whose entries are exchanged, in the memory of one that is gone, or in new memory.

    Only where `exchangeable` says that this may be.
    """

    def __init__(
        self, joined: Joined, bodies: Sequence[Body], found: Runs, kept: Known, own: Places, classes: Regrouped,
        claim: Claim,
    ) -> None:  # fmt: skip
        """own: places of what is new. claim: of the memory that the old scene is in."""
        self.in_place = claim.opened is not None
        if self.in_place and classes.renumbered:
            joined = _numbers_apart(joined)
        old, new = joined.sides
        self._claim = claim  # while it is held nobody writes to the memory that is read
        self.joined, self.pieces, self.kept, self.classes = joined, joined.pieces, kept, classes
        self._bodies, self._fresh = bodies, found.fresh
        sides = _beside(old, kept.places), _beside(new, own)
        opened, some = claim.opened, self.pieces.only(1)
        if opened is None:
            opened, some = _taken(kept.memory, old.laid, self.pieces, found.fresh)
        if opened is not None:
            for name, column in sides[0].items():
                if name not in opened.beside or (opened.frame != kept.frame and name.startswith(_OF_FRAMES)):
                    opened.put(name, column.copy())
        beside = opened.beside if opened else {name: column.copy() for name, column in sides[0].items()}
        for name, axis in BESIDE.items():
            for source, rows, at in some.on(axis):
                beside[name][at] = sides[source][name][rows]
        self._opened, self._some, self._beside = opened, some, beside
        self._all_numbers = classes.renumbered or bool(opened and opened.numbers != kept.memory.numbers)
        self._laid = _exchanged(joined, classes)
        self.boxes: Floats = beside["boxes"]
        self.kinds = self._laid.patterns.entries[self._laid.which, 2]
        self.shapes: dict[str, Any] = {k: v for k, v in old.tables._asdict().items() if k not in TREES}
        for name in _OF_SURFACES:
            self.shapes[name] = np.broadcast_to(self.shapes[name].dtype.type(), classes.count)

    @property
    def keeps_items(self) -> bool:
        """Are items of leaves what they were, but for what is new? They name balls, and tell how large cells are."""
        if len(self.classes.bereft):
            return False
        return not (self.classes.renumbered and bool((self.joined.sides[0].tables.entry_kind == BALL).any()))

    def geometry(self, empty: Tables) -> Geometry:
        """Memory for tables of these shapes, in which all rows are but those that differ."""
        found = self._opened.geometry(empty) if self._opened else None
        if found is not None:
            return found
        self._some, self.in_place = self.pieces.only(1), False
        others = self._opened is not None  # what is beside is somebody's who comes later
        self._opened = Opened.new(empty)
        for name, column in self._beside.items():
            self._beside[name] = self._opened.put(name, column.copy() if others else column)
        self.boxes = self._beside["boxes"]
        made = self._opened.geometry(empty)
        assert made is not None
        tables, old = shared(empty, made), self.joined.sides[0].tables
        self._all_numbers = self.classes.renumbered
        for name in self.shapes:
            if not (self._all_numbers and name in _OF_SURFACES):
                getattr(tables, name)[...] = getattr(old, name)
        return made

    def fill(self, geometry: Geometry, tables: Tables) -> tuple[Lowered, Known]:
        """Write the tables where they differ; trees are left as they are."""
        joined, beside, kept, classes = self.joined, self._beside, self.kept, self.classes
        columns, (old, _) = Differing(joined, self._some, self._laid, classes, self._all_numbers), joined.sides
        columns.fill(tables)
        rest = Remainders(beside["planes"], beside["spheres"], beside["quadrics"], beside["vertices"])
        size = LimitsOfExchanged(columns, tables, self.boxes, rest).put(kept.size)
        put_sizes(geometry, tables)
        body_frame = old.body_frame.copy()
        columns.framed(body_frame, FRAMES, [side.body_frame for side in joined.sides])
        single = old.exact.single if classes.single is None else classes.single
        lowered = dataclasses.replace(
            old, tables=tables, around=self.boxes, frames=beside["frames"], body_frame=body_frame,
            face_paint=joined.paint(), rest=rest, laid=self._laid,
            exact=ExactTables(old.exact.bodies.of(ShapesOf(self._bodies)), single),
        )  # fmt: skip
        assert self._opened is not None
        numbers = new_edit() if classes.renumbered else kept.memory.numbers
        memory = self._opened.memory(kept.memory.stores, self._stamps(size == kept.size), numbers)
        return lowered, Known(kept.frame, _raw_places(self._opened), size, memory=memory)

    def _stamps(self, same_size: bool) -> Longs:
        """By which edit the rows of each entry were written: those of what is new, and of whatever is one with it."""
        if not same_size:
            return stamped(len(self.kept.memory.stamps))
        touched = entries_of(self._laid, self.classes.touched).tolist()
        return restamped(self.kept.memory.stamps, [*self._fresh, *touched])

    def close(self, kept: Kept) -> None:
        """All tables have been written, those of trees too; `kept` is what `fill` returned.

        Only from here on does the memory go to others when the scene is gone. That of one that is broken off before
        goes to nobody: what is in its rows is told by no stamps.
        """
        assert isinstance(kept, Known)
        assert self._opened is not None
        self._opened.close(kept.memory, kept.frame)


def _numbers_apart(joined: Joined) -> Joined:
    """The same with all integers of the old tables in memory of their own."""
    old, new = joined.sides
    columns = {name: column.copy() for name, column in old.tables._asdict().items() if column.dtype != np.float64}
    return Joined((dataclasses.replace(old, tables=old.tables._replace(**columns)), new), joined.pieces)


def _taken(memory: Memory, laid: Laid, pieces: Pieces, fresh: list[int]) -> tuple[Opened | None, Pieces]:
    """The memory of a scene that is gone, if there is any, and what is to be written there; else what is new."""
    new, opened = pieces.only(1), memory.stores.take()
    if opened is None:
        return None, new
    other = memory.stamps != opened.stamps
    other[fresh] = False
    bounds = np.flatnonzero(np.diff(other, prepend=False, append=False))
    if len(bounds) > 2 * _MOST:
        bounds = np.array([0, len(other)])
    return opened, new.after_rows(laid.rows_up_to(bounds)) if len(bounds) else new


def _exchanged(joined: Joined, classes: Regrouped) -> Laid:
    """Which rows are whose: nothing but patterns, and what surfaces are, is other than it was."""
    (old, new), pieces = joined.laid, joined.pieces.only(1)
    patterns, numbers = old.patterns.joined(new.patterns)
    which, kinds, given = old.which.copy(), old.kinds.copy(), old.given.copy()
    for _, rows, at in pieces.on(BODIES):
        which[at] = numbers[new.which[rows]]
    for _, rows, at in pieces.on(SURFACES):
        kinds[at], given[at] = new.kinds[rows], new.given[rows]
    return dataclasses.replace(
        old, patterns=patterns, which=which, kinds=kinds, given=given, first=classes.first, senses=classes.senses,
        ids=classes.ids,
    )  # fmt: skip
