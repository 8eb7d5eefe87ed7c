"""A crossing and the interval of its ray, which is open at both ends.

`starts` says everywhere: the crossing is one with the surface on which the ray starts. At t = 0 that is the start
itself, which never counts.
"""

from __future__ import annotations

from ...compiler.jit import inline


@inline
def is_open(t_min: float, t_max: float) -> bool:
    """Is there anything between the ends of an interval? Not where one is NaN, or they are out of order."""
    return t_min < t_max


@inline
def has_begun(t: float, t_min: float) -> bool:
    """Does a crossing lie beyond the beginning of its interval? What lies there was passed before."""
    return t_min < t


@inline
def has_not_ended(t: float, t_max: float) -> bool:
    """Does a crossing lie before the end of its interval?"""
    return t < t_max


@inline
def is_within(t: float, t_min: float, t_max: float) -> bool:
    """Is t within (t_min, t_max)?"""
    return has_begun(t, t_min) & has_not_ended(t, t_max)


@inline
def may_overlap(t_in: float, t_out: float, t_min: float, t_max: float, off: float) -> bool:
    """Might a span have any of an interval, where rounding may have moved each of its ends by `off`?"""
    t_out += off
    return (t_in <= t_out) & (t_min <= t_out) & (t_in <= t_max + off)


@inline
def counts_in(t: float, starts: bool, t_min: float, t_max: float) -> bool:
    """Is a crossing within (t_min, t_max), and not the one that the ray starts on?

    The lanes of a packet may say that none is: one that starts on a surface begins at t = 0 or later (`load.ordinary`).
    """
    return is_within(t, t_min, t_max) & ((t != 0.0) | (not starts))


@inline
def left_out(t: float, starts: bool, t_min: float, t_max: float) -> bool:
    """Is a crossing the one that the ray starts on, and within an interval that begins before it?

    Then a body counts before it as it does beyond, so that crossings and spans go together.
    """
    return is_within(t, t_min, t_max) & (t == 0.0) & starts


@inline
def at_start(t: float, starts: bool, t_min: float, off: float) -> bool:
    """Might rounding have taken a crossing to the other side of the ray's origin? Not the one that it starts on.

    Other ends of the interval are compared with t as it is reported, so that what is reported lies within them; there
    is nothing to doubt about those.
    """
    return (abs(t) <= off) & (t_min <= off) & ((t != 0.0) | (not starts))
