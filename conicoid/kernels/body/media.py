"""The media on both sides of a crossing: by its t alone (`find_media`), or by the identity of its surface (`sides_at`).

The rule of both: all crossings at one place act together, a transparent solid counts before an opaque one, and among
equals the body listed first. The t alone is enough for rays that the fast formulas decide.
"""

from __future__ import annotations

from typing import Any, NamedTuple

from ..._jit.decorators import helper, inline
from .. import tables as table
from ..bvh.walk import OWN_BEAM, leaf_range, next_leaf, push_roots, put_beam, scene_tree
from ..numbers.double_double import next_float_down, next_float_up
from ..ray import Ray, scale_ray, with_limits
from ..tables import Geometry, Signs, integer, whole
from .boolean import read_crossing
from .entry import collect_entries, crossing_face, entry_crossings, entry_nearness, entry_sides, is_solid
from .scratch import Scratch


@inline
def first_body(found: int, body: int, is_there: bool) -> int:
    """Return the first body, in the order of the scene's list, that is there; `found` is the result so far, or -1."""
    return body if is_there and found < 0 else found


@helper
def find_media(geometry: Geometry, scratch: Scratch, ray: Ray, t: float, is_medium: Signs) -> tuple[int, int]:
    """Return (before, after): the first body with is_medium[body] != 0 that contains the ray just before and after t.

    -1 for none. All crossings at the same t act together. The walk comes to entries in any order, and keeps those with
    the least numbers: the body listed first has priority.
    """
    ray, scale = scale_ray(ray)
    # Exact, since the scale is a power of two
    t = t / scale
    # The interval of one point: boxes that hold it are found, no others
    here = with_limits(ray, t, t)
    before, after, way = whole(-1), whole(-1), scratch.way
    put_beam(way, OWN_BEAM, here)
    code, _, top = next_leaf(geometry, way, way, OWN_BEAM, push_roots(geometry, way, scene_tree(geometry)))
    while code != 0:
        first, last = leaf_range(code)
        for k in range(first, last):
            body = integer(geometry, table.TREE_ORDER, k)
            if is_medium[body] == 0 or (0 <= before < body and 0 <= after < body):
                continue
            was_inside, is_inside = entry_sides(geometry, scratch, body, here, t)
            before = body if was_inside and not 0 <= before < body else before
            after = body if is_inside and not 0 <= after < body else after
        code, _, top = next_leaf(geometry, way, way, OWN_BEAM, top)
    return before, after


# Both sides of a crossing, by the identity of its surface
#
# A crossing with the surface of the hit is at the hit, whatever its computed t. A crossing that rounding may have put
# on the other side of the hit makes the answer doubtful.

BEFORE, AFTER, BLOCKER = 0, 1, 2
"""Rows of the sides of many hits."""
OPAQUE, CLEAR, PANE = 0, 1, 2
"""Kinds of body to light: opaque, transparent solid, transparent sheet (which has no inside)."""
_EVERY = 1 << 30  # as a limit: no limit of crossings


class Sides(NamedTuple):
    """Bodies at a crossing, -1 for none: transparent ones and opaque ones just before and after it."""

    clear_before: Any  # int64, as the others
    clear_after: Any
    solid_before: Any
    solid_after: Any
    blocker: Any  # the first listed opaque body, sheets included, with a crossing there


@inline
def no_sides() -> Sides:
    """Return sides without any body."""
    none: Any = whole(-1)
    return Sides(none, none, none, none, none)


@inline
def with_body(sides: Sides, body: int, kind: int, crossed: bool, was: bool, now: bool) -> Sides:
    """Add a body to the sides, in the order of bodies: the ray crosses it, was inside before, is inside now."""
    first, last, solid_first, solid_last, blocker = sides
    if kind == CLEAR:
        first, last = first_body(first, body, was), first_body(last, body, now)
    elif kind == OPAQUE:
        solid_first, solid_last = first_body(solid_first, body, was), first_body(solid_last, body, now)
        blocker = first_body(blocker, body, crossed)
    return Sides(first, last, solid_first, solid_last, blocker)


@inline
def body_before(sides: Sides) -> int:
    """Return the body that contains the ray before a crossing, or -1."""
    return sides.clear_before if sides.clear_before >= 0 else sides.solid_before


@inline
def body_after(sides: Sides) -> int:
    """Return the body that contains the ray after a crossing, or -1."""
    return sides.clear_after if sides.clear_after >= 0 else sides.solid_after


@inline
def ray_about(ray: Ray, t: float, width: float) -> Ray:
    """Return the ray with the interval t - width to t + width, which is never empty."""
    return with_limits(ray, next_float_down(t - width), next_float_up(t + width))


@helper
def sides_at(
    geometry: Geometry, scratch: Scratch, ray: Ray, t: float, surface: int, entry: int, kinds: Signs
) -> tuple[Sides, bool]:
    """Return (sides of the crossing at t of a ray with a surface of an entry, doubtful).

    kinds[body] is OPAQUE, CLEAR or PANE. Relies on a ray from `scale_ray`, and on `collect_entries` listing entries in
    the order of their bodies. The answer is certain if every entry near t has at most one crossing so near that
    rounding may have moved it past t, and that crossing is with the same surface.
    """
    off = entry_nearness(geometry, entry, ray).off
    sides, unsure = no_sides(), False
    for k in range(collect_entries(geometry, scratch, ray_about(ray, t, 2.0 * off))):
        other = scratch.found[k]
        near = ray_about(ray, t, 2.0 * (off + entry_nearness(geometry, other, ray).off))
        count, inside, doubtful = entry_crossings(geometry, scratch, other, near, _EVERY)
        # Two crossings so near may lie on both sides of the hit, in either order
        unsure |= doubtful | (count > 1)
        if count > 0:
            _, place, sense, _ = read_crossing(scratch, 0)
            unsure |= crossing_face(geometry, whole(other), place, sense)[0] != surface
        body, solid = whole(other), is_solid(geometry, other)
        sides = with_body(sides, body, kinds[body], count > 0, inside, inside != (solid and count > 0))
    return sides, unsure
