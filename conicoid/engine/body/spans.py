"""The spans of a cell from the crossings of its faces: rules without branches, for single rays and for lanes alike.

A cell lies between planes and inside, or outside, of at most one quadric. The planes leave one span of a ray, from t_in
to t_out; the quadric's roots low < high leave what is between them, or what is before and after. Every end has the
place of the face on which it lies (see cell.py). A contact of zero length is no span.
"""

from __future__ import annotations

import math
from typing import Any, NamedTuple

from ...compiler.jit import choose, inline
from ..surface.interval import at_start
from ..surface.nearness import Nearness, beyond, near


class Slab(NamedTuple):
    """What the planes so far leave of a ray: t_in to t_out, each with the place of its face; empty if t_in >= t_out."""

    t_in: float
    t_out: float
    place_in: Any
    place_out: Any


class Composed(NamedTuple):
    """Two spans, of which there is `some` first, and `more`: a second."""

    in1: float
    out1: float
    place_in1: Any
    place_out1: Any
    in2: float
    out2: float
    place_in2: Any
    place_out2: Any
    some: bool
    more: bool


@inline
def clip_slab(slab: Slab, height: float, rate: float, inner: bool, place: Any, off: float) -> tuple[Slab, bool]:
    """(the slab cut by one more plane, might rounding have changed the order of two planes?)

    Along the ray the plane's value is height + rate t; `inner`: the cell is where that is negative, else where it is
    positive. A ray within a plane is treated as if the plane lay an infinitesimal further along its normal. Keeps t_in
    the largest t of the planes that are entered, t_out the least of those that are left, each with its plane's place;
    an empty slab stays empty.
    """
    t, parallel = -height / rate, rate == 0.0
    outside = parallel & ((height <= 0.0) != inner)
    enters, leaves = ((rate < 0.0) == inner) & (not parallel), ((rate < 0.0) != inner) & (not parallel)
    close = abs(t - choose(enters, slab.t_in, slab.t_out)) <= off
    later, sooner = enters & (t > slab.t_in), leaves & (t < slab.t_out)
    t_in = choose(outside, math.inf, choose(later, t, slab.t_in))
    t_out = choose(outside, -math.inf, choose(sooner, t, slab.t_out))
    place_in, place_out = place if later else slab.place_in, place if sooner else slab.place_out
    return Slab(t_in, t_out, place_in, place_out), close


@inline
def compose_spans(slab: Slab, low: float, high: float, crosses: bool, outside: bool, curved: Any) -> Composed:
    """The spans that a quadric leaves of a slab: `outside` of its roots, or between them; `curved` is its place.

    Where the ray does not cross it, all of the slab is left if `outside`, else nothing. Relies on low < high where it
    crosses. What comes out is in order, of positive length, and within the slab.
    """
    t_in, t_out, place_in, place_out = slab
    between, beside = crosses & (not outside), crosses & outside
    by_low = between & (low >= t_in)
    in1, place_in1 = low if by_low else t_in, curved if by_low else place_in
    by_root = (between & (high <= t_out)) | (beside & (low <= t_out))
    out1, place_out1 = (high if between else low) if by_root else t_out, curved if by_root else place_out
    some = (in1 < out1) & (crosses | outside)
    in2, place_in2 = high if high >= t_in else t_in, curved if high >= t_in else place_in
    more = beside & (in2 < t_out) & (t_in < t_out)
    return Composed(in1, out1, place_in1, place_out1, in2, t_out, place_in2, place_out, some, more)


@inline
def spans_at_start(spans: Composed, starts: bool, t_min: float, off: float) -> bool:
    """Might rounding have taken an end of the spans to the other side of the ray's origin (`at_start`)?"""
    first = at_start(spans.in1, starts, t_min, off) | at_start(spans.out1, starts, t_min, off)
    second = at_start(spans.in2, starts, t_min, off) | at_start(spans.out2, starts, t_min, off)
    return (spans.some & first) | (spans.more & second)


@inline
def spans_unsure(
    slab: Slab, low: float, high: float, crosses: bool, unsure: bool, t_min: float, t_max: float, nearness: Nearness
) -> bool:
    """Might rounding change the spans of a cell within a ray's interval?

    `unsure`: it might change the order of two planes, or the roots of the quadric. A slab that is
    certainly empty, or certainly outside of the interval, is not doubtful, whatever else is close.
    """
    t_in, t_out = slab.t_in, slab.t_out
    close = near(low, t_in, nearness) | near(low, t_out, nearness)
    close |= near(high, t_in, nearness) | near(high, t_out, nearness)
    close |= beyond(low, nearness) | beyond(high, nearness)  # on which side, then, is not certain either
    begins = (t_in < t_max) | near(t_in, t_max, nearness)
    ends = (t_out > t_min) | near(t_out, t_min, nearness)
    touches = near(t_in, t_out, nearness)
    return (unsure | touches | (close & crosses)) & begins & ends & ((t_in < t_out) | touches)
