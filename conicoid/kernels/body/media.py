"""The media on both sides of a crossing."""

from __future__ import annotations

from typing import Any, NamedTuple

from ..._jit.decorators import helper, inline
from ..numbers.double_double import next_float_down, next_float_up
from ..ray import Ray, scale_ray, with_limits
from ..tables import Geometry, Signs, whole
from .boolean import read_crossing
from .entry import collect_entries, crossing_face, entry_crossings, entry_nearness, entry_sides, is_solid
from .scratch import Scratch


@inline
def first_body(found: int, body: int, is_there: bool) -> int:
    """The body that counts of those that are somewhere, asked in the order of the list: the first of them."""
    return body if is_there and found < 0 else found


@helper
def find_media(geometry: Geometry, scratch: Scratch, ray: Ray, t: float, is_medium: Signs) -> tuple[int, int]:
    """(before, after): the first body with is_medium[body] != 0 that the ray is in, just before and after t.

    -1 for none. All crossings at the same t act together. Relies on `collect` listing entries in order of
    their bodies, so that the body listed first has priority.
    """
    ray, scale = scale_ray(ray)
    t = t / scale
    here = with_limits(ray, t, t)
    before, after = -1, -1
    for k in range(collect_entries(geometry, scratch, here)):
        entry = scratch.found[k]
        body = entry
        if is_medium[body] == 0 or (before >= 0 and after >= 0):
            continue
        was_inside, is_inside = entry_sides(geometry, scratch, entry, here, t)
        before, after = first_body(before, body, was_inside), first_body(after, body, is_inside)
    return before, after


# What lies on both sides of a crossing, by the identity of its surface.
#
# The rule is that of `media`, with which integrators find it: all crossings at one place act together, a transparent
# solid counts before an opaque one, and among equals the body listed first. `media` compares t alone, which is enough
# for
# rays that the fast formulas decide; here what is on the surface of the hit is at the hit, whatever its t, and what
# rounding may have put on the other side of it is doubtful.

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
def no_sides() -> Sides:
    """The sides of a crossing where no body is known yet."""
    none: Any = whole(-1)
    return Sides(none, none, none, none, none)


@inline
def with_body(sides: Sides, body: int, kind: int, crossed: bool, was: bool, now: bool) -> Sides:
    """The sides with one body more, in the order of bodies: was the ray inside of it, is it now, is it crossed?"""
    first, last, solid_first, solid_last, blocker = sides
    if kind == CLEAR:
        first, last = first_body(first, body, was), first_body(last, body, now)
    elif kind == OPAQUE:
        solid_first, solid_last = first_body(solid_first, body, was), first_body(solid_last, body, now)
        blocker = first_body(blocker, body, crossed)
    return Sides(first, last, solid_first, solid_last, blocker)


@inline
def body_before(sides: Sides) -> int:
    """The body that a ray is in before a crossing."""
    return sides.clear_before if sides.clear_before >= 0 else sides.solid_before


@inline
def body_after(sides: Sides) -> int:
    """The body that a ray is in after a crossing."""
    return sides.clear_after if sides.clear_after >= 0 else sides.solid_after


@inline
def ray_about(ray: Ray, t: float, width: float) -> Ray:
    """A ray within t - width to t + width, and never nothing."""
    return with_limits(ray, next_float_down(t - width), next_float_up(t + width))


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
    sides, unsure = no_sides(), False
    for k in range(collect_entries(geometry, scratch, ray_about(ray, t, 2.0 * off))):
        one = scratch.found[k]
        near = ray_about(ray, t, 2.0 * (off + entry_nearness(geometry, one, ray).off))
        count, inside, doubtful = entry_crossings(geometry, scratch, one, near, _EVERY)
        unsure |= doubtful | (count > 1)
        if count > 0:
            _, place, sense, _ = read_crossing(scratch, 0)
            unsure |= crossing_face(geometry, whole(one), place, sense)[0] != surface
        body, solid = whole(one), is_solid(geometry, one)
        sides = with_body(sides, body, kinds[body], count > 0, inside, inside != (solid and count > 0))
    return sides, unsure
