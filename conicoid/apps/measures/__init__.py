"""Volume, area, centroid and inertia of shapes: in closed form, or from exact chords."""

from __future__ import annotations

from typing import TYPE_CHECKING

from ..._util.lazy_names import lazy_names

_HOMES = {
    "Measures": ".measure",
    "SceneMeasures": ".measure",
}
"""Public name -> module that defines it."""

__all__ = sorted(_HOMES)  # pyright: ignore[reportUnsupportedDunderAll]

if TYPE_CHECKING:
    from .measure import Measures as Measures, SceneMeasures as SceneMeasures
else:  # type checkers would accept any name otherwise
    __getattr__, __dir__ = lazy_names(__name__, _HOMES)
