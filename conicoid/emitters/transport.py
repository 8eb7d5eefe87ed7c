"""All about light in a scene that light transport needs, as kernels take it."""

from __future__ import annotations

from collections.abc import Sequence
from typing import NamedTuple

import numpy as np

from ..engine.tables import Ints
from ..scattering.albedo import Albedos, lower_albedos
from ..shading.look import Look
from ..shapes.background import Background
from ..shapes.background import Environment as Image
from ..shapes.body import Body
from .environment import Environment, lower_environment, mean_radiance
from .sources import Sources, lower_sources


class Transport(NamedTuple):
    """The look of a scene, with what is worked out of it."""

    look: Look
    albedos: Albedos
    sources: Sources
    surroundings: Environment
    shines: bool
    """May light be found by chance: does a body glow, or what lies around?"""


def lower_transport(look: Look, bodies: Sequence[Body], item_of: Ints, background: Background | None) -> Transport:
    """What light transport needs of a scene with a given look; item_of: the entry of each body."""
    pixels = background.radiance if isinstance(background, Image) else None
    mean = 0.0 if pixels is None else mean_radiance(pixels)
    sources = lower_sources(bodies, item_of, look, mean)
    around_all = np.array([*look.background, look.ambient])
    shines = bool((look.materials.rows["emission"] > 0).any() or (around_all > 0).any() or mean > 0)
    return Transport(look, lower_albedos(look.materials), sources, lower_environment(pixels), shines)
