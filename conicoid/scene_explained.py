"""One ray worked out, and what a surface is: the questions of a scene that are answered in words."""

from __future__ import annotations

import math
from typing import TYPE_CHECKING, Any

from .scene_parts import as_index
from .shapes.calm import calm
from .shapes.validate import shown

if TYPE_CHECKING:
    from .engine.lowering import Lowered
    from .explain.explanation import Explanation
    from .explain.surfaces import SceneSurface


class Explained:
    """What can be asked about `lowered`, the scene as arrays."""

    @property
    def lowered(self) -> Lowered:
        """Built on first use."""
        raise NotImplementedError

    @calm
    def explain(
        self, origin: Any, direction: Any = None, t_min: float = 0.0, t_max: float = math.inf, *, body: Any = None
    ) -> Explanation:
        """One ray worked out as on a blackboard: what every body does with it, and why.

        origin, direction: (3,) each; or a `Rays` of one ray, which may know the surface that it starts on.
        t_min, t_max: the open interval, as for `first_hit`.
        body: the number or name of the only one to work out; by default all are.

        The numbers are the kernels' own, to the bit; those of the lecture stand beside them, with their source. Print
        it for the text; a notebook shows it with its figure. Raises ValueError for several rays.
        """
        from .explain.explain import explain

        return explain(self, origin, direction, t_min, t_max, body)  # type: ignore[arg-type]

    @calm
    def surface(self, number: Any) -> SceneSurface:
        """The surface of a `number`, as `hits.surface` tells it: its equation, its kind, and whose faces it makes.

        Raises TypeError for what is no integer, IndexError for -1, a miss, and other numbers that there are not.
        """
        from .explain.surfaces import surface_of

        index, count = as_index(number), len(self.lowered.tables.surface_kind)
        if index is None:
            raise TypeError(f"surface: number must be one integer, got {shown(number)}; scene.surface(int(k)) for each")
        if not 0 <= index < count:
            miss = "; -1 stands for a miss" if index == -1 else ""
            raise IndexError(f"surface: number must be at least 0 and below {count}, got {index}{miss}")
        return surface_of(self, index)  # type: ignore[arg-type]
