"""What is known of a scene that was edited, or that others were made from, for the next time."""

from __future__ import annotations

from dataclasses import KW_ONLY, dataclass, field
from typing import Any

from .near import Frame, Places
from .stores import Memory


@dataclass(frozen=True)
class Kept:
    """Numbers by which near surfaces are found, and the size that limits depend on; whose memory may be taken.

    Stamps are told apart in one process alone, and a copy's memory is its own: so what is pickled, or copied, has none.
    Edits of it begin with new stamps, and with nobody's memory.
    """

    frame: Frame | None = None
    places: Places | None = None
    size: float | None = None
    memory: Memory | None = None

    def __reduce__(self) -> tuple[Any, ...]:
        return Kept, (self.frame, self.places, self.size)


@dataclass(frozen=True)
class Known(Kept):
    """The same where all of it is known."""

    frame: Frame = field()  # of these none may be left out
    places: Places = field()
    size: float | None = field()
    _: KW_ONLY
    memory: Memory

    __reduce__ = Kept.__reduce__
