"""What is known of a scene that was edited, or that others were made from, for the next time."""

from __future__ import annotations

from dataclasses import KW_ONLY, dataclass, field
from typing import Any

from .buffer_pool import PoolMemory
from .neighbour_index import NeighbourFrame, NeighbourPlaces


@dataclass(frozen=True)
class EditState:
    """Numbers by which near surfaces are found, and the size that limits depend on; whose memory may be taken.

    Stamps are told apart in one process alone, and a copy's memory is its own: so what is pickled, or copied, has none.
    Edits of it begin with new stamps, and with nobody's memory.
    """

    frame: NeighbourFrame | None = None
    places: NeighbourPlaces | None = None
    size: float | None = None
    memory: PoolMemory | None = None

    def __reduce__(self) -> tuple[Any, ...]:
        return EditState, (self.frame, self.places, self.size)


@dataclass(frozen=True)
class FullEditState(EditState):
    """The same where all of it is known."""

    frame: NeighbourFrame = field()  # of these none may be left out
    places: NeighbourPlaces = field()
    size: float | None = field()
    _: KW_ONLY
    memory: PoolMemory

    __reduce__ = EditState.__reduce__
