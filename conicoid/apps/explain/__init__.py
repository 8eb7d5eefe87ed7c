"""One ray explained as on a blackboard, `scene.explain`, and the surfaces of a scene, `scene.surface`.

The numbers are those of the kernels (`ray_records.py`); those of the lecture, beside them, come from exact arithmetic
and are rounded once.
"""

from __future__ import annotations

from typing import TYPE_CHECKING

from ..._util.lazy_names import lazy_names

_HOMES = {
    "Explanation": ".explanation",
    "SceneSurface": ".explanation",
}
"""Public name -> module that defines it."""

__all__ = sorted(_HOMES)  # pyright: ignore[reportUnsupportedDunderAll]

if TYPE_CHECKING:
    from .explanation import Explanation as Explanation, SceneSurface as SceneSurface
else:  # type checkers would accept any name otherwise
    __getattr__, __dir__ = lazy_names(__name__, _HOMES)
