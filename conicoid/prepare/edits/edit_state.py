"""The state that the next edit of a scene needs."""

from __future__ import annotations

from dataclasses import KW_ONLY, dataclass, field
from typing import Any

from .buffer_pool import PoolMemory
from .neighbour_index import NeighbourFrame, NeighbourPlaces


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
