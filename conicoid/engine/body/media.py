"""The media on both sides of a crossing."""

from __future__ import annotations

from ...compiler.jit import helper, inline
from ..ray import Ray, scaled_ray, with_limits
from ..tables import Geometry, Signs
from .entry import collect, entry_sides
from .scratch import Scratch


@inline
def first_listed(found: int, body: int, is_there: bool) -> int:
    """The body that counts of those that are somewhere, asked in the order of the list: the first of them."""
    return body if is_there and found < 0 else found


@helper
def media(geometry: Geometry, scratch: Scratch, ray: Ray, t: float, is_medium: Signs) -> tuple[int, int]:
    """(before, after): the first body with is_medium[body] != 0 that the ray is in, just before and after t.

    -1 for none. All crossings at the same t act together. Relies on `collect` listing entries in order of
    their bodies, so that the body listed first has priority.
    """
    ray, scale = scaled_ray(ray)
    t = t / scale
    here = with_limits(ray, t, t)
    before, after = -1, -1
    for k in range(collect(geometry, scratch, here)):
        entry = scratch.found[k]
        body = entry
        if is_medium[body] == 0 or (before >= 0 and after >= 0):
            continue
        was_inside, is_inside = entry_sides(geometry, scratch, entry, here, t)
        before, after = first_listed(before, body, was_inside), first_listed(after, body, is_inside)
    return before, after
