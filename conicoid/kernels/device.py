"""Queries by the threads of a GPU: each takes rays or points begin, begin + step, ..., one at a time.

`native/ptx.py` compiles these functions to PTX, and the kernels of `ROWS`. Tests run the same code on the CPU and
compare it with the kernels there. No extension holds it. Nothing here allocates: scratch memory is local to a thread
and of a fixed size (`SIZES`), or a part of arrays for all threads.
"""

from __future__ import annotations

import math
from typing import NamedTuple

from .._jit.decorators import helper, inline
from .._util.validation import BELOW_ROUNDING, LARGEST, SMALLEST
from . import tables as table
from .body.crossing_rows import BODY, ENTER, EXIT, BodyRows, put_rows, scale_rows, sort_rows_in_place
from .body.entry import entry_crossings, entry_nearness
from .body.hit import DOUBTFUL, Hit, no_hit
from .body.membership import entry_holds, point_ray
from .body.scratch import EVENT, LEAF_COUNT, TIME, Scratch
from .bvh.culling import hit_balls, lowest_bit
from .bvh.walk import (
    FEW,
    OWN_BEAM,
    leaf_at,
    leaf_item,
    leaf_range,
    next_leaf,
    push_roots,
    put_beam,
    scene_tree,
    way_size,
)
from .closest.safety import bound_of_point
from .crossings import ROUNDING_OVERLAP, length_of
from .first_hits import HitBuffers, first_crossing, put_hit
from .programs import forget_program
from .ray import DEAD, RayArrays, load_ray, scale_ray, span_inverse
from .surface.exact_crossing import OPEN, RoundingRest
from .surface.interval import is_open
from .tables import REGION, Floats, Geometry, Ints, Longs, Signs, integer, whole


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
            "time": max(TIME * events, self.gates),
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


PICTURE = "render_"
"""How the names of functions of pictures begin (render/device_pictures.py)."""


def local_sizes(function: str) -> tuple[str, ...]:
    """Return the sizes of local memory for which a function has kernels. Those of pictures are large: one is enough."""
    return ("few",) if function.startswith(PICTURE) else tuple(SIZES)


def size_name(needed: ScratchSize, function: str = "") -> str:
    """Return the name of the first size of a function's kernels that is enough."""
    return next((name for name in local_sizes(function) if SIZES[name].holds(needed)), SHARED)


@inline
def _open_scratch(scratch: Scratch) -> None:
    """Make scratch memory, which is not initialised, ready for the first ray."""
    forget_program(scratch.counts)
    scratch.found_leaves[LEAF_COUNT] = -1


@inline
def _hit_of_ray(geometry: Geometry, rays: RayArrays, scratch: Scratch, i: int, any_hit: bool) -> Hit:
    """Return the first hit of a ray, or any."""
    ray = load_ray(rays, i)
    return no_hit() if ray.start == DEAD else first_crossing(geometry, scratch, ray, scratch.nothing, any_hit)


def first_hits(geometry: Geometry, rays: RayArrays, found: HitBuffers, scratch: Scratch, begin: int, step: int) -> None:
    """Write the first hits of rays begin, begin + step, ..., as `trace_first_alone` does."""
    _open_scratch(scratch)
    i = begin
    while i < len(rays.origins):
        put_hit(_hit_of_ray(geometry, rays, scratch, i, False), i, found)
        i += step


def any_hits(geometry: Geometry, rays: RayArrays, result: Signs, scratch: Scratch, begin: int, step: int) -> None:
    """Write 1 for rays begin, begin + step, ... that have a crossing, else 0; plus DOUBTFUL if that is in doubt."""
    _open_scratch(scratch)
    i = begin
    while i < len(rays.origins):
        hit = _hit_of_ray(geometry, rays, scratch, i, True)
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


def wall_bounds(
    geometry: Geometry, points: Floats, reach: Floats, bounds: Floats, scratch: Scratch, begin: int, step: int
) -> None:
    """Write for points begin, begin + step, ... what `bounds_of_points` does."""
    i = begin
    while i < len(points):
        x, y, z = points[i, 0], points[i, 1], points[i, 2]
        bounds[i] = bound_of_point(geometry, scratch.way, scratch.time, x, y, z, reach[i])
        i += step


# Spans and crossings: counted first, written second

ROW_COLUMNS = 10
"""Of a row on a card: those of a span (body/crossing_rows.py), or the fewer of a crossing, and one for sorting."""


@helper
def _list_ray(
    geometry: Geometry, rays: RayArrays, scratch: Scratch, i: int, spans: bool, rows: Floats, first: int
) -> tuple[int, bool]:
    """Write the rows of a ray at rows[first:], sorted; return their number, and whether they are in doubt.

    Without any `rows` it counts. The walk comes to entries in any order, since the sort is by t and body.
    """
    unscaled = load_ray(rays, i)
    if unscaled.start == DEAD or not is_open(unscaled.t_min, unscaled.t_max):
        return 0, False
    ray, scale = scale_ray(unscaled)
    way, inverse, used, doubtful = scratch.way, span_inverse(ray), first, False
    put_beam(way, OWN_BEAM, ray)
    code, _, top = next_leaf(geometry, way, way, OWN_BEAM, push_roots(geometry, way, scene_tree(geometry)))
    while code != 0:
        begin, end = leaf_range(code)
        at, count = leaf_at(geometry, begin), end - begin
        for eight in range(0, count, 8):
            bits = hit_balls(geometry.floats, at + eight, count, count - eight, ray, inverse, ray.t_max)
            while bits != 0:
                item = leaf_item(geometry, at, count, eight + lowest_bit(bits))
                bits &= bits - 1
                if spans and item.kind > REGION:
                    continue
                crossings, inside, unsure = entry_crossings(geometry, scratch, item.entry, ray, 1 << 30)
                doubtful |= unsure
                if len(rows) == 0:
                    used += (crossings + (2 if inside else 1)) >> 1 if spans else crossings
                elif crossings > 0 or inside:
                    off = entry_nearness(geometry, item.entry, ray).off
                    met = BodyRows(crossings, inside, off, unsure)
                    used = put_rows(geometry, scratch, item.entry, met, ray, spans, rows, used)
        code, _, top = next_leaf(geometry, way, way, OWN_BEAM, top)
    if len(rows) > 0:
        doubtful |= sort_rows_in_place(rows, first, used, spans)
        scale_rows(rows, first, used, scale, unscaled, spans)
    return used - first, doubtful


def list_rows(
    geometry: Geometry, rays: RayArrays, spans: int, offsets: Longs, rows: Floats, counts: Ints, doubts: Signs,
    scratch: Scratch, begin: int, step: int,
) -> None:  # fmt: skip
    """Count the spans or crossings of rays begin, begin + step, ...; or write them, if there are `rows`.

    A doubtful ray has doubts[i] = 1, and none where they are counted. Ray i has the rows from offsets[i] - offsets[0]
    on, as many as were counted; one that turns out to be doubtful where they are sorted keeps its rows.
    """
    _open_scratch(scratch)
    i, counting = begin, len(rows) == 0
    while i < len(rays.origins):
        if counting or counts[i] > 0:
            first = 0 if counting else offsets[i] - offsets[0]
            found, unsure = _list_ray(geometry, rays, scratch, i, spans != 0, rows, first)
            counts[i], doubts[i] = 0 if counting and unsure else found, 1 if unsure else 0
        i += step


@inline
def _overlaps(rows: Floats, one: int, other: int) -> bool:
    """Return whether two spans have more in common than rounding explains (queries/overlaps.py); the first is `one`."""
    start, end = rows[other, ENTER], rows[one, EXIT]
    common = min(end, rows[other, EXIT]) - start
    return common > 0.0 and (common == math.inf or common > ROUNDING_OVERLAP * max(abs(start), abs(end)))


def sum_spans(
    directions: Floats, offsets: Longs, rows: Floats, places: Ints, weights: Floats, width: int, groups: int,
    total: Floats, crossed: Signs, begin: int, step: int,
) -> None:  # fmt: skip
    """Sum up the spans of rays begin, begin + step, ...: `width` numbers each, as `integrate_spans` does.

    places: of the sums of each body, or its row of weights. Without any `weights` the sums are lengths.
    crossed: whether spans overlap that count; of one place, if `groups` is not 0.
    """
    i = begin
    while i < len(directions):
        for k in range(i * width, (i + 1) * width):
            total[k] = 0.0
        length = length_of(directions[i, 0], directions[i, 1], directions[i, 2])
        first, last, reach = offsets[i] - offsets[0], whole(-1), -math.inf
        crossed[i] = 0
        for row in range(first, offsets[i + 1] - offsets[0]):
            place, counts = whole(places[whole(rows[row, BODY])]), len(weights) == 0
            chord = (rows[row, EXIT] - rows[row, ENTER]) * length
            if counts:
                total[i * width + place] += chord
            else:
                for k in range(width):
                    weight = weights[place * width + k]
                    if weight != 0.0:
                        total[i * width + k] += weight * chord
                        counts = True
            if not counts:
                continue
            if reach > rows[row, ENTER]:
                # With groups each earlier span of the place, else the one that ends last
                one = last if groups == 0 else row - 1
                while one >= first and crossed[i] == 0:
                    if (groups == 0 or places[whole(rows[one, BODY])] == place) and _overlaps(rows, one, row):
                        crossed[i] = 1
                    one = first - 1 if groups == 0 else one - 1
            if rows[row, EXIT] >= reach:
                last, reach = row, rows[row, EXIT]
        i += step


# For arrays that live on a card


def check_points(points: Floats, bad: Signs, begin: int, step: int) -> None:
    """Set bad[0] if a coordinate of points begin, begin + step, ... is not finite or beyond the domain."""
    i = begin
    while i < len(points):
        for k in range(3):
            if not abs(points[i, k]) <= LARGEST:
                bad[0] = 1
        i += step


def clear_negligible(vectors: Floats, begin: int, step: int) -> None:
    """`zero_negligible` of vectors begin, begin + step, ..., in place."""
    i = begin
    while i < len(vectors):
        most = max(abs(vectors[i, 0]), max(abs(vectors[i, 1]), abs(vectors[i, 2])))
        for k in range(3):
            if abs(vectors[i, k]) < SMALLEST and abs(vectors[i, k]) <= BELOW_ROUNDING * most:
                vectors[i, k] = 0.0
        i += step


def are_bodies(bodies: Ints, result: Signs, begin: int, step: int) -> None:
    """Write 1 for numbers begin, begin + step, ... that are those of bodies, else 0."""
    i = begin
    while i < len(bodies):
        result[i] = 1 if bodies[i] >= 0 else 0
        i += step


def are_entries(turn: Signs, result: Signs, begin: int, step: int) -> None:
    """Write 1 for certain hits begin, begin + step, ... that enter a body, else 0."""
    i = begin
    while i < len(turn):
        result[i] = 1 if turn[i] == 2 or turn[i] == -2 else 0
        i += step


def copy_rows(source: Signs, target: Signs, which: Longs, width: int, back: int, begin: int, step: int) -> None:
    """Copy rows of `width` bytes: which[begin], which[begin + step], ... of the source, or back to these places."""
    i = begin
    while i < len(which):
        there, here = width * which[i], width * i
        for k in range(width):
            if back != 0:
                target[there + k] = source[here + k]
            else:
                target[here + k] = source[there + k]
        i += step


FUNCTIONS = {
    first_hits: {"found": "out"},
    any_hits: {"result": "out n"},
    first_bodies: {"points": "n 3", "after": "n|1", "bodies": "out n", "undecided": "out n"},
    wall_bounds: {"points": "n 3", "reach": "n", "bounds": "out n"},
    list_rows: {"offsets": "n+1", "rows": "out * 10", "counts": "out n", "doubts": "out n"},
    sum_spans: {
        "directions": "n 3",
        "offsets": "n+1",
        "rows": "* 10",
        "places": "*",
        "weights": "*",
        "total": "out *",
        "crossed": "out n",
    },
    check_points: {"points": "n 3", "bad": "out 1"},
    clear_negligible: {"vectors": "out n 3"},
    are_bodies: {"bodies": "n", "result": "out n"},
    are_entries: {"turn": "n", "result": "out n"},
    copy_rows: {"source": "*", "target": "out *", "which": "n"},
}
"""What the threads of a GPU run, with the shapes of arguments as `kernel` declares them."""
ROWS = {
    "check_rays": "hit_fields",
    "faces_of": "hit_fields",
    "hit_points": "hit_fields",
    "normals_of": "hit_fields",
    "uvs_of": "hit_fields",
    "refine_points": "exact.error_bounds",
}
"""Kernels of the CPU, by their modules in `queries`, that a thread runs on one row each."""
EACH = "each"
"""In place of a size: of functions without scratch memory."""
