"""What is known of a scene that was edited, or that others were made from, for the next time."""

from __future__ import annotations

from dataclasses import KW_ONLY, dataclass, field
from typing import Any

from ...tables import Longs
from .near import Frame, Places
from .stores import Stores


@dataclass(frozen=True)
class Kept:
    """Numbers by which near surfaces are found, and the size that limits depend on."""

    frame: Frame | None = None
    places: Places | None = None
    size: float | None = None


@dataclass(frozen=True)
class Known(Kept):
    """The same; whose memory may be taken, and by which edit the rows of each entry were written: see `stores`.

    numbers: by which edit surfaces got the numbers that they have in the table.

    Stamps are told apart in one process alone, and a copy's memory is its own: so what is pickled, or copied, is only
    what `Kept` has. Edits of it begin with new stamps, and with nobody's memory.
    """

    frame: Frame = field()  # of these three none may be left out, as they may where nothing is known
    places: Places = field()
    size: float | None = field()
    _: KW_ONLY
    stores: Stores
    stamps: Longs
    numbers: int

    def __reduce__(self) -> tuple[Any, ...]:
        return Kept, (self.frame, self.places, self.size)
