"""A crossing and the interval of its ray, which is open at both ends.

`starts` says everywhere: the crossing is one with the surface on which the ray starts. At t = 0 that is the start
itself, which never counts.
"""

from __future__ import annotations

from ...compiler.jit import inline


@inline
def counts_in(t: float, starts: bool, t_min: float, t_max: float) -> bool:
    """Is a crossing within (t_min, t_max), and not the one that the ray starts on?"""
    return (t_min < t) & (t < t_max) & ((t != 0.0) | (not starts))


@inline
def left_out(t: float, starts: bool, t_min: float, t_max: float) -> bool:
    """Is a crossing the one that the ray starts on, and within an interval that begins before it?

    Then a body counts before it as it does beyond, so that crossings and spans go together.
    """
    return (t_min < t) & (t < t_max) & (t == 0.0) & starts


@inline
def at_start(t: float, starts: bool, t_min: float, off: float) -> bool:
    """Might rounding have taken a crossing to the other side of the ray's origin? Not the one that it starts on.

    Other ends of the interval are compared with t as it is reported, so that what is reported lies within them; there
    is nothing to doubt about those.
    """
    return (abs(t) <= off) & (t_min <= off) & ((t != 0.0) | (not starts))
