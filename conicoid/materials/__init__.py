"""Materials, textures, glasses, lights and backgrounds: data only.

The names of `co.materials` are loaded on first use.
"""

from __future__ import annotations

from typing import TYPE_CHECKING

from .._util.lazy_names import lazy_names

_HOMES = {
    "AIR": ".material",
    "Brick": ".texture",
    "GLASS": ".material",
    "Gradient": ".texture",
    "ImageTexture": ".texture",
    "Noise": ".texture",
    "VACUUM": ".material",
    "WATER": ".material",
    "Wood": ".texture",
    "aluminium": ".presets",
    "clear_sky": ".light",
    "conductor": ".presets",
    "copper": ".presets",
    "gold": ".presets",
    "iron": ".presets",
    "silver": ".presets",
}
"""Public name -> module that defines it."""

__all__ = sorted(_HOMES)  # pyright: ignore[reportUnsupportedDunderAll]

if TYPE_CHECKING:
    from .light import clear_sky as clear_sky
    from .material import AIR as AIR, GLASS as GLASS, VACUUM as VACUUM, WATER as WATER
    from .presets import (
        aluminium as aluminium,
        conductor as conductor,
        copper as copper,
        gold as gold,
        iron as iron,
        silver as silver,
    )
    from .texture import (
        Brick as Brick,
        Gradient as Gradient,
        ImageTexture as ImageTexture,
        Noise as Noise,
        Wood as Wood,
    )
else:  # type checkers would accept any name otherwise
    __getattr__, __dir__ = lazy_names(__name__, _HOMES)
