"""The queries of one ray that other kernels build on: the nearest crossing, any crossing of some bodies."""

from __future__ import annotations

from ...compiler.jit import helper, inline
from ..body.hit import Crossed, Hit, no_hit, resolved, scaled_hit, within
from ..body.meet import meet
from ..body.scratch import Scratch
from ..culling import LAST, balls_met, lowest_bit
from ..ray import Ray, scaled_ray, span_inverse
from ..surface.interval import is_open
from ..tables import Geometry, Signs
from ..tree.leaf import leaf_at, leaf_ball, leaf_item, leaf_range
from ..tree.walk import OWN_BEAM, next_leaf, push_roots, put_beam, scene_tree


@helper
def first_crossing(geometry: Geometry, scratch: Scratch, ray: Ray, blocks: Signs, any_hit: bool) -> Hit:
    """The nearest crossing of bodies with blocks[body] != 0 (of all, if `blocks` is empty), or any one of them.

    Traverses the tree, the nearest box first. The beam ends at `within(best)`, so that what is culled can neither be
    nearer nor make the order doubtful. `any_hit` is an early out at the first crossing.
    """
    best = no_hit()
    if not is_open(ray.t_min, ray.t_max):
        return best
    ray, scale = scaled_ray(ray)
    some = len(blocks) > 0
    way = scratch.way
    put_beam(way, OWN_BEAM, ray)
    inverse = span_inverse(ray)
    code, _, top = next_leaf(geometry, way, way, OWN_BEAM, push_roots(geometry, way, scene_tree(geometry)))
    while code != 0:
        first, last = leaf_range(code)
        at, count = leaf_at(geometry, first), last - first
        for eight in range(0, count, 8):
            end = min(ray.t_max, within(best))
            bits = balls_met(geometry.floats, at + eight, count, count - eight, ray, inverse, end)
            while bits != 0:
                k = eight + lowest_bit(bits)
                bits &= bits - 1
                item = leaf_item(geometry, at, count, k)
                if some and blocks[item.body] == 0:
                    continue
                best = meet(geometry, scratch, item, leaf_ball(geometry, at, count, k), ray, inverse, best)
                if any_hit and best.body >= 0:
                    return scaled_hit(best, scale)
        way[OWN_BEAM + LAST] = min(ray.t_max, within(best))
        code, _, top = next_leaf(geometry, way, way, OWN_BEAM, top)
    return scaled_hit(best, scale)


@inline
def resolved_first_crossing(geometry: Geometry, scratch: Scratch, ray: Ray) -> Crossed:
    """The first crossing of all bodies in (t_min, t_max), as it is reported."""
    return resolved(geometry, first_crossing(geometry, scratch, ray, scratch.nothing, False))


@inline
def blocked(geometry: Geometry, scratch: Scratch, ray: Ray, blocks: Signs) -> bool:
    """Is there any crossing in (t_min, t_max) of a body with blocks[body] != 0 (int8 over bodies)?"""
    return first_crossing(geometry, scratch, ray, blocks, True).body >= 0
