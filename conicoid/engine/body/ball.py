"""A ball on a ray."""

from __future__ import annotations

import math

from ...compiler.jit import inline
from ..surface.interval import at_start, counts_in
from ..surface.nearness import Nearness
from ..surface.quadric import Roots


@inline
def ball_event(roots: Roots, starts: bool, t_min: float, t_max: float, nearness: Nearness) -> tuple[float, bool, bool]:
    """(t of the first crossing of a ball within the interval, is it entered there, doubtful); t = inf for none.

    Without branches, so that single rays, the lanes of packets and the pairs of streams all call it. Relies on
    roots.low < roots.high where the ray crosses; `doubtful` is set wherever rounding, by `nearness`, might change t
    from one root to the other or to inf.
    """
    low, high, _, crosses, unsure = roots
    enters = crosses & counts_in(low, starts, t_min, t_max)
    leaves = crosses & counts_in(high, starts, t_min, t_max)
    near = at_start(low, starts, t_min, nearness.off) | at_start(high, starts, t_min, nearness.off)
    t = low if enters else (high if leaves else math.inf)
    return t, enters, unsure | (crosses & near) | (nearness.far < 0.0)
