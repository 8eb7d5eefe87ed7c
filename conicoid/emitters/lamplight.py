"""The look of a scene with the lamps in it, for integrators that ask every lamp at every point (Whitted's)."""

from __future__ import annotations

from collections.abc import Sequence
from typing import NamedTuple

from ..engine.tables import Ints
from ..shading.look import Look
from ..shapes.body import Body
from .sources import Sources, lower_lamps


class Lamplight(NamedTuple):
    """The look of a scene, and its lamps."""

    look: Look
    lamps: Sources


def lower_lamplight(look: Look, bodies: Sequence[Body], item_of: Ints) -> Lamplight:
    """The lamps of a scene with a given look; item_of: the entry of each body."""
    return Lamplight(look, lower_lamps(bodies, item_of, look))
