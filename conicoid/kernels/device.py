"""Queries by the threads of a GPU: each takes rays or points begin, begin + step, ..., one at a time.

`native/ptx.py` compiles these functions to PTX. Tests run the same code on the CPU and compare it with the kernels
there. No extension holds it. Nothing here allocates: scratch memory is local to a thread and of a fixed size (`SIZES`),
or a part of arrays for all threads.
"""

from __future__ import annotations

import math
from typing import NamedTuple

from .._jit.decorators import helper, inline
from . import tables as table
from .body.hit import DOUBTFUL, no_hit
from .body.membership import entry_holds, point_ray
from .body.scratch import EVENT, LEAF_COUNT, TIME, Scratch
from .bvh.walk import FEW, OWN_BEAM, leaf_range, next_leaf, push_roots, put_beam, scene_tree, way_size
from .first_hits import HitBuffers, first_crossing, put_hit
from .programs import forget_program
from .ray import DEAD, RayArrays, load_ray
from .surface.exact_crossing import OPEN, RoundingRest
from .tables import Floats, Geometry, Ints, Signs, integer, whole


class ScratchSize(NamedTuple):
    """The largest body and the highest stack of a walk for which scratch memory has room."""

    leaves: int
    gates: int
    depth: int

    @classmethod
    def needed(cls, geometry: Geometry) -> ScratchSize:
        """Return the size that a scene needs."""
        places = geometry.places
        depth = int(geometry.integers[int(places[table.TREE_DEPTH])])
        return cls(int(places[table.LEAVES]), int(places[table.GATES]), depth)

    @property
    def lengths(self) -> dict[str, int]:
        """The lengths of the arrays of `Scratch`; first hits and points need no list of entries, and no mask."""
        events = 4 * self.leaves + 4  # a leaf has at most two spans
        return {
            "time": TIME * events,
            "event": EVENT * events,
            "counts": self.gates + 2,
            "way": way_size(self.depth),
            "inner_way": way_size(self.depth if self.leaves > FEW else 0),  # fewer leaves have no tree
            "found": 0,
            "found_leaves": self.leaves + 1,
            "nothing": 0,
        }

    def holds(self, other: ScratchSize) -> bool:
        """Return whether scratch memory of this size is enough for another one."""
        return all(mine >= its for mine, its in zip(self, other, strict=True))


WIDTHS = dict(time=8, event=4, counts=4, way=8, inner_way=8, found=4, found_leaves=4, nothing=1)
"""Bytes of an element of the arrays of `Scratch`."""
DEPTH = 96
"""Of stacks in local memory: those of ten million balls take 70."""
SIZES = {"alone": ScratchSize(1, 1, DEPTH), "few": ScratchSize(8, 8, DEPTH), "many": ScratchSize(64, 64, DEPTH)}
"""Sizes of scratch memory that is local to a thread, the smallest first."""
SHARED = "any"
"""The name of the kernels whose scratch memory, of any size, is a part of arrays for all threads."""


def size_name(needed: ScratchSize) -> str:
    """Return the name of the first size that is enough."""
    return next((name for name, size in SIZES.items() if size.holds(needed)), SHARED)


@inline
def _open_scratch(scratch: Scratch) -> None:
    """Make scratch memory, which is not initialised, ready for the first ray."""
    forget_program(scratch.counts)
    scratch.found_leaves[LEAF_COUNT] = -1


def first_hits(geometry: Geometry, rays: RayArrays, found: HitBuffers, scratch: Scratch, begin: int, step: int) -> None:
    """Write the first hits of rays begin, begin + step, ..., as `trace_first_alone` does."""
    _open_scratch(scratch)
    i = begin
    while i < len(rays.origins):
        hit = no_hit()
        ray = load_ray(rays, i)
        if ray.start != DEAD:
            hit = first_crossing(geometry, scratch, ray, scratch.nothing, False)
        put_hit(hit, i, found)
        i += step


def any_hits(geometry: Geometry, rays: RayArrays, result: Signs, scratch: Scratch, begin: int, step: int) -> None:
    """Write 1 for rays begin, begin + step, ... that have a crossing, else 0; plus DOUBTFUL if that is in doubt."""
    _open_scratch(scratch)
    i = begin
    while i < len(rays.origins):
        hit = no_hit()
        ray = load_ray(rays, i)
        if ray.start != DEAD:
            hit = first_crossing(geometry, scratch, ray, scratch.nothing, True)
        result[i] = (1 if hit.body >= 0 else 0) + (DOUBTFUL if hit.unsure else 0)
        i += step


@helper
def _first_body(
    geometry: Geometry, rest: RoundingRest, scratch: Scratch, point: tuple[float, float, float], after: int
) -> tuple[int, int]:
    """Return the first body after a number that contains a point, or -1, and 1 if that is not certain.

    The walk comes to bodies in any order, and keeps the one with the least number that contains the point or may.
    """
    x, y, z = point
    first, undecided, way = whole(-1), 0, scratch.way
    if not (math.isfinite(x) and math.isfinite(y) and math.isfinite(z)):
        return whole(-1), 0
    put_beam(way, OWN_BEAM, point_ray(x, y, z))
    code, _, top = next_leaf(geometry, way, way, OWN_BEAM, push_roots(geometry, way, scene_tree(geometry)))
    while code != 0:
        start, end = leaf_range(code)
        for k in range(start, end):
            entry = integer(geometry, table.TREE_ORDER, k)
            if entry <= after or (first >= 0 and entry >= first):
                continue
            holds = entry_holds(geometry, rest, scratch, entry, x, y, z)
            if holds != 0:
                first, undecided = entry, 1 if holds == OPEN else 0
        code, _, top = next_leaf(geometry, way, way, OWN_BEAM, top)
    return (whole(-1) if undecided == 1 else first), undecided


def first_bodies(
    geometry: Geometry, rest: RoundingRest, points: Floats, after: Ints, bodies: Ints, undecided: Signs,
    scratch: Scratch, begin: int, step: int,
) -> None:  # fmt: skip
    """Write for points begin, begin + step, ... what `locate_packets` does."""
    _open_scratch(scratch)
    i = begin
    while i < len(points):
        place = points[i, 0], points[i, 1], points[i, 2]
        bodies[i], undecided[i] = _first_body(geometry, rest, scratch, place, whole(after[i if len(after) > 1 else 0]))
        i += step


FUNCTIONS = {
    first_hits: {"found": "out"},
    any_hits: {"result": "out n"},
    first_bodies: {"points": "n 3", "after": "n|1", "bodies": "out n", "undecided": "out n"},
}
"""What the threads of a GPU run, with the shapes of arguments as `kernel` declares them."""
