"""The state that the next edit of a scene needs, and whether entries can be exchanged in place.

An edit in place exchanges entries so that all other rows stay where they are.
"""

from __future__ import annotations

from dataclasses import KW_ONLY, dataclass, field
from typing import Any

import numpy as np

from ..error_limits import scene_size
from ..lowering import LoweredScene
from ..row_layout import SURFACES, RowLayout
from .buffer_pool import PoolMemory
from .neighbour_index import NeighbourFrame, NeighbourPlaces, surface_columns
from .pieces import SplicePieces, SpliceRuns


@dataclass(frozen=True)
class EditState:
    """Places by which near surfaces are found, the size that limits depend on, and the memory that may be reused.

    Stamps are unique in one process only, and the memory of a copy is its own: so pickles and copies drop the memory.
    Their edits start with new stamps, in new memory.
    """

    frame: NeighbourFrame | None = None
    places: NeighbourPlaces | None = None
    size: float | None = None
    memory: PoolMemory | None = None

    def __reduce__(self) -> tuple[Any, ...]:
        return EditState, (self.frame, self.places, self.size)


@dataclass(frozen=True)
class FullEditState(EditState):
    """An edit state in which everything is known."""

    frame: NeighbourFrame = field()  # no default: none of these may be left out
    places: NeighbourPlaces = field()
    size: float | None = field()
    _: KW_ONLY
    memory: PoolMemory

    __reduce__ = EditState.__reduce__


def keeps_rows(old: RowLayout, new: RowLayout, found: SpliceRuns, entries: int) -> bool:
    """Return whether each new entry has as many rows of every kind as the one that it replaces.

    Bulk balls exclude it.
    """
    if entries != len(old.first_body) - 1 or not new.which.all():
        return False
    fresh = np.array(found.fresh, np.int64)
    counts = np.diff(old.first_body)[fresh]
    if not np.array_equal(counts, np.diff(new.first_body)):
        return False
    if np.diff(old.first_frame)[fresh].any() or new.first_frame.any():
        return False
    firsts = np.repeat(old.first_body[fresh] - new.first_body[:-1], counts)
    which = old.which[firsts + np.arange(len(new.which))]
    rows = old.patterns.counts[which], new.patterns.counts[new.which]
    return bool(which.all() and np.array_equal(*rows))


def keeps_classes(old: RowLayout, new: RowLayout, pieces: SplicePieces) -> bool:
    """Return whether surfaces coincide with the same others as before, if new ones coincide with no others.

    That they coincide with no others is a separate question: see `surface_classes.neighbour_slots`. This function
    requires that

    - no surface of a removed entry coincided with one that stays;
    - no surface of a new entry coincides with one of another piece, before or behind it;
    - within each piece every new surface takes the record of the surface at the same place as that of the entry it
      replaces.

    Then `RowLayout.first` and `RowLayout.ids` stay unchanged. A class of equal surfaces is new, or stays, as a whole,
    and lies within one piece of the new entries: so the rows of its record shift as those of all its members. For the
    second condition nothing weaker suffices: a record of another piece has its number, and its row, shifted as that
    piece.
    """
    if old.first is None:  # every surface stood for itself
        return new.first is None
    fresh = np.zeros(len(old.first), bool)
    for source, rows, at, shift in pieces.moved(SURFACES, SURFACES):
        if source == 1:
            fresh[at] = True
            first = np.arange(rows.start, rows.stop) if new.first is None else new.first[rows]
            if (first < rows.start).any() or (first >= rows.stop).any():
                return False
            if not np.array_equal(old.first[at], first + shift):
                return False
    return bool((fresh[old.first] == fresh).all())


def complete_state(
    edit_state: EditState, old: LoweredScene, new: LoweredScene
) -> tuple[FullEditState, NeighbourPlaces]:
    """Complete the edit state of the old scene with all that an in-place edit needs.

    Return also the places of new surfaces.
    """
    frame, places, records = edit_state.frame, edit_state.places, surface_columns(new.tables)
    own = frame.places_within(*records) if frame is not None and places is not None else None
    if isinstance(edit_state, FullEditState) and own is not None:
        return edit_state, own
    assert old.layout is not None
    memory = edit_state.memory or PoolMemory.new(len(old.layout.first_body) - 1)
    if frame is None or places is None or own is None:
        frame, (places, own) = NeighbourFrame.of_scenes(surface_columns(old.tables), records)
    size = edit_state.size
    if size is None and not np.isfinite(old.boxes).all():
        size = scene_size(old.tables, old.boxes)
    return FullEditState(frame, places, size, memory=memory), own
