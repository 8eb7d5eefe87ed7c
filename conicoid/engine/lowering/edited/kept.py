"""What is known of a scene that was edited, or that others were made from, for the next time."""

from __future__ import annotations

from dataclasses import KW_ONLY, dataclass

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
    """The same; whose memory may be taken, and by which edit the rows of each entry were written: see `stores`."""

    frame: Frame
    places: Places
    size: float | None
    _: KW_ONLY
    stores: Stores
    stamps: Longs
