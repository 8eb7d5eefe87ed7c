"""Slices of a scene by a plane, with exact outlines, and scenes as voxels."""

from __future__ import annotations

from typing import TYPE_CHECKING

from ..._util.lazy_names import lazy_names

_HOMES = {
    "Outline": ".outline",
    "Slice": ".slice",
    "Voxels": ".voxels",
}
"""Public name -> module that defines it."""

__all__ = sorted(_HOMES)  # pyright: ignore[reportUnsupportedDunderAll]

if TYPE_CHECKING:
    from .outline import Outline as Outline
    from .slice import Slice as Slice
    from .voxels import Voxels as Voxels
else:  # type checkers would accept any name otherwise
    __getattr__, __dir__ = lazy_names(__name__, _HOMES)
