"""The facade: `Scene`, and the functions that make scenes from files and molecules, and films of scenes."""

from __future__ import annotations

from typing import TYPE_CHECKING

from .._util.lazy_names import lazy_names

_HOMES = {
    "BodyTrack": "..geometry.tracks",
    "CameraTrack": "..geometry.tracks",
    "LightTrack": "..geometry.tracks",
    "Molecule": ".molecules",
}
"""Public name -> module that defines it."""

__all__ = sorted(_HOMES)  # pyright: ignore[reportUnsupportedDunderAll]

if TYPE_CHECKING:
    from ..geometry.tracks import BodyTrack as BodyTrack, CameraTrack as CameraTrack, LightTrack as LightTrack
    from .molecules import Molecule as Molecule
else:  # type checkers would accept any name otherwise
    __getattr__, __dir__ = lazy_names(__name__, _HOMES)
