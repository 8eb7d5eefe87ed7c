"""May entries of a scene be exchanged for others, so that all other rows stay where they are?"""

from __future__ import annotations

import numpy as np

from ..error_limits import scene_size
from ..lowering import LoweredScene
from ..row_layout import SURFACES, RowLayout
from .buffer_pool import PoolMemory
from .edit_state import EditState, FullEditState
from .neighbour_index import NeighbourFrame, NeighbourPlaces, surface_columns
from .pieces import SplicePieces, SpliceRuns


def keeps_rows(old: RowLayout, new: RowLayout, found: SpliceRuns, entries: int) -> bool:
    """Has each new entry as many rows of every kind as that in whose place it comes? Bulk balls have none of these."""
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
    """Are the same surfaces one with the same others as before, where new ones are one with no others?

    That they are not is another question: see `regrouped.near_slots`. What this asks is that

    - no surface of what is gone was one with a surface that stays;
    - no surface of what is new is one with a surface of another piece, before or behind it;
    - within each piece every new surface takes the record of the one of the same place as that in whose place it comes.

    Then `Laid.first` and `Laid.ids` stay what they are. What is one surface is new, or stays, as a whole, and lies
    within one piece of what is new: so the rows of its record grow by what those of all its members grow by. Nothing
    less would do for the second: a record of another piece has its number, and its row, by how that piece moves.
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


def complete_state(kept: EditState, old: LoweredScene, new: LoweredScene) -> tuple[FullEditState, NeighbourPlaces]:
    """What is known of the old scene, with what exchanges of its entries for new ones need; places of the new ones."""
    frame, places, records = kept.frame, kept.places, surface_columns(new.tables)
    own = frame.places_within(*records) if frame is not None and places is not None else None
    if isinstance(kept, FullEditState) and own is not None:
        return kept, own
    assert old.laid is not None
    memory = kept.memory or PoolMemory.new(len(old.laid.first_body) - 1)
    if frame is None or places is None or own is None:
        frame, (places, own) = NeighbourFrame.around(surface_columns(old.tables), records)
    size = kept.size
    if size is None and not np.isfinite(old.boxes).all():
        size = scene_size(old.tables, old.boxes)
    return FullEditState(frame, places, size, memory=memory), own
