"""All about light in a scene, as kernels take it."""

from __future__ import annotations

from collections.abc import Iterable, Mapping, Sequence
from typing import Annotated, NamedTuple

import numpy as np
import numpy.typing as npt

from ..compiler.shapes import shaped
from ..engine.tables import Ints
from ..shapes.background import Background
from ..shapes.light import Light
from ..shapes.material import Material
from .background import Colors, lower_background
from .lights import RECORD as LIGHT
from .lights import lower_lights
from .materials import Materials, lower_materials


@shaped(lights="*")
class Look(NamedTuple):
    """Materials, lights, the ambient light and the background."""

    materials: Materials
    lights: Annotated[npt.NDArray[np.void], LIGHT]
    ambient: tuple[float, float, float]
    background: Colors


def lower_look(
    materials: Sequence[Material], sheets: Sequence[bool], item_of: Ints,
    lights: Iterable[Light], background: Background | None, paints: Mapping[int, Material],
) -> Look:  # fmt: skip
    """The look of a scene: one material and one flag per entry, the entry of each numbered body, painted faces."""
    records, ambient = lower_lights(lights)
    return Look(lower_materials(materials, sheets, item_of, paints), records, ambient, lower_background(background))
