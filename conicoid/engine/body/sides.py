"""What lies on both sides of a crossing, by the identity of its surface.

The rule is that of `media`, with which integrators find it: all crossings at one place act together, a transparent
solid counts before an opaque one, and among equals the body listed first. `media` compares t alone, which is enough for
rays that the fast formulas decide; here what is on the surface of the hit is at the hit, whatever its t, and what
rounding may have put on the other side of it is doubtful.
"""

from __future__ import annotations

from typing import Any, NamedTuple

from ...compiler.jit import helper, inline
from ..numbers.bits import next_above, next_below
from ..ray import Ray, with_limits
from ..tables import Geometry, Signs, whole
from .boolean import crossing
from .entry import collect, crossed_face, entry_crossings, entry_nearness, is_solid
from .media import first_listed
from .scratch import Scratch

BEFORE, AFTER, BLOCKER = 0, 1, 2
"""Rows of the sides of many hits."""
OPAQUE, CLEAR, PANE = 0, 1, 2
"""What a body is to light: opaque, a transparent solid, or a transparent sheet, which nothing is inside of."""
_EVERY = 1 << 30


class Sides(NamedTuple):
    """Bodies at a crossing, -1 for none: transparent ones and opaque ones just before and after it."""

    clear_before: Any  # int64, as the others
    clear_after: Any
    solid_before: Any
    solid_after: Any
    blocker: Any  # the first listed opaque body, sheets included, that is crossed there


@inline
def nothing_there() -> Sides:
    """The sides of a crossing where no body is known yet."""
    none: Any = whole(-1)
    return Sides(none, none, none, none, none)


@inline
def with_body(sides: Sides, body: int, kind: int, crossed: bool, was: bool, now: bool) -> Sides:
    """The sides with one body more, in the order of bodies: was the ray inside of it, is it now, is it crossed?"""
    first, last, solid_first, solid_last, blocker = sides
    if kind == CLEAR:
        first, last = first_listed(first, body, was), first_listed(last, body, now)
    elif kind == OPAQUE:
        solid_first, solid_last = first_listed(solid_first, body, was), first_listed(solid_last, body, now)
        blocker = first_listed(blocker, body, crossed)
    return Sides(first, last, solid_first, solid_last, blocker)


@inline
def before_of(sides: Sides) -> int:
    """The body that a ray is in before a crossing."""
    return sides.clear_before if sides.clear_before >= 0 else sides.solid_before


@inline
def after_of(sides: Sides) -> int:
    """The body that a ray is in after a crossing."""
    return sides.clear_after if sides.clear_after >= 0 else sides.solid_after


@inline
def around(ray: Ray, t: float, width: float) -> Ray:
    """A ray within t - width to t + width, and never nothing."""
    return with_limits(ray, next_below(t - width), next_above(t + width))


@helper
def sides_at(
    geometry: Geometry, scratch: Scratch, ray: Ray, t: float, surface: int, entry: int, kinds: Signs
) -> tuple[Sides, bool]:
    """(what is on both sides of the crossing at t of a ray with a surface, of an entry; is that doubtful).

    kinds[body]: OPAQUE, CLEAR or PANE. Relies on `scaled_ray`, and on `collect` listing entries in order of their
    bodies. Certain where, of every entry near t, at most one crossing is so near that rounding may have moved it past
    t, and it is one with the same surface.
    """
    off = entry_nearness(geometry, entry, ray).off
    sides, unsure = nothing_there(), False
    for k in range(collect(geometry, scratch, around(ray, t, 2.0 * off))):
        one = scratch.found[k]
        near = around(ray, t, 2.0 * (off + entry_nearness(geometry, one, ray).off))
        count, inside, doubtful = entry_crossings(geometry, scratch, one, near, _EVERY)
        unsure |= doubtful | (count > 1)
        if count > 0:
            _, place, sense, _ = crossing(scratch, 0)
            unsure |= crossed_face(geometry, whole(one), place, sense)[0] != surface
        body, solid = whole(one), is_solid(geometry, one)
        sides = with_body(sides, body, kinds[body], count > 0, inside, inside != (solid and count > 0))
    return sides, unsure
