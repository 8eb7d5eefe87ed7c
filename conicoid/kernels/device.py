"""Queries by the threads of a GPU: each takes rays or points begin, begin + step, ..., one at a time.

`native/ptx.py` compiles these functions to PTX, and the kernels of `ROWS`. Tests run the same code on the CPU and
compare it with the kernels there. No extension holds it. Nothing here allocates: scratch memory is local to a thread
and of a fixed size (`SIZES`), or a part of arrays for all threads.
"""

from __future__ import annotations

import math
from typing import Any, NamedTuple, TypeAlias

import numpy as np
import numpy.typing as npt

from .._jit.decorators import helper, inline
from .._util.validation import BELOW_ROUNDING, LARGEST, SMALLEST
from . import tables as table
from .body.crossing_rows import (
    BODY,
    ENTER,
    ENTER_CLIPPED,
    ENTER_SURFACE,
    ENTERS,
    EXIT,
    EXIT_CLIPPED,
    EXIT_SURFACE,
    FACE,
    SURFACE,
    BodyRows,
    T,
    put_rows,
    scale_rows,
    sort_rows_in_place,
)
from .body.entry import ball_crossings, cell_crossings, entry_crossings, entry_nearness
from .body.hit import DOUBTFUL, is_doubtful
from .body.membership import entry_holds, point_ray
from .body.scratch import EVENT, LEAF_COUNT, TIME, Scratch
from .bvh.culling import lowest_bit
from .bvh.walk import (
    FEW,
    OWN_BEAM,
    LeafItem,
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
from .crossings import ROUNDING_OVERLAP, CrossingColumns, SpanColumns, length_of
from .device_walk import (
    first_on_card,
    next_items,
    place_count,
    push_short_roots,
    ray_grid,
    ray_of_place,
    shorten_nodes,
    take_next,
    walk_end,
)
from .first_hits import HitBuffers, put_hit
from .programs import forget_program
from .ray import DEAD, Ray, RayArrays, load_ray, scale_ray, span_inverse
from .surface.exact_crossing import OPEN, RoundingRest
from .surface.interval import is_open
from .tables import BALL, CELL, POLYGON, REGION, Floats, Geometry, Ints, Longs, Signs, integer, length, whole

Singles: TypeAlias = npt.NDArray[np.float32]


class ScratchSize(NamedTuple):
    """The largest body and the highest stack of a walk for which scratch memory has room."""

    leaves: int
    gates: int
    depth: int
    kinds: int = POLYGON  # the largest kind of an entry

    @classmethod
    def needed(cls, geometry: Geometry) -> ScratchSize:
        """Return the size that a scene needs."""
        places = geometry.places
        depth = int(geometry.integers[int(places[table.TREE_DEPTH])])
        first, bodies = int(places[table.ENTRY_KIND]), int(length(geometry, table.ENTRY_KIND))
        kinds = int(geometry.integers[first : first + bodies].max(initial=BALL))
        return cls(int(places[table.LEAVES]), int(places[table.GATES]), depth, kinds)

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
SIZES = {
    "balls": ScratchSize(1, 1, DEPTH, BALL),
    "cells": ScratchSize(1, 1, DEPTH, CELL),
    "few": ScratchSize(8, 8, DEPTH),
    "many": ScratchSize(64, 64, DEPTH),
}
"""Sizes of scratch memory that is local to a thread, the smallest first.

The first two are of functions that take `kinds` (`BY_KIND`): their code leaves other bodies out. A GPU waits for code
that does not fit its cache (half of the time of Booleans, by its counters), so less code is faster."""
SHARED = "any"
"""The name of the kernels whose scratch memory, of any size, is a part of arrays for all threads."""


PICTURE = "render_"
"""How the names of functions of pictures begin (render/device_pictures.py)."""


def sizes_of(function: str) -> tuple[str, ...]:
    """Return the names of the sizes for which a function has kernels, the smallest first."""
    if function.startswith(PICTURE):  # their kernels are large: one size of local memory is enough
        return "few", SHARED
    return (*SIZES, SHARED) if function in BY_KIND else (*[*SIZES][2:], SHARED)


def size_name(function: str, needed: ScratchSize) -> str:
    """Return the name of the first size of a function that is enough."""
    return next((name for name in sizes_of(function)[:-1] if SIZES[name].holds(needed)), SHARED)


@inline
def _open_scratch(scratch: Scratch) -> None:
    """Make scratch memory, which is not initialised, ready for the first ray."""
    forget_program(scratch.counts)
    scratch.found_leaves[LEAF_COUNT] = -1


def first_hits(
    geometry: Geometry, nodes: Longs, kinds: int, width: int, rays: RayArrays, found: HitBuffers, scratch: Scratch,
    begin: int, step: int,
) -> None:  # fmt: skip
    """Write the first hits of rays begin, begin + step, ..., as `trace_first_alone` does.

    kinds: the largest kind of an entry of the scene. width: of the picture that the rays make, or 0.
    """
    _open_scratch(scratch)
    k, count = begin, len(rays.origins)
    while k < place_count(width, count):
        i = ray_of_place(k, width, count)
        if i >= 0:
            put_hit(first_on_card(geometry, nodes, kinds, scratch, load_ray(rays, i), False), i, found)
        k += step


def any_hits(
    geometry: Geometry, nodes: Longs, kinds: int, width: int, rays: RayArrays, result: Signs, scratch: Scratch,
    begin: int, step: int,
) -> None:  # fmt: skip
    """Write 1 for rays begin, begin + step, ... that have a crossing, else 0; plus DOUBTFUL if that is in doubt."""
    _open_scratch(scratch)
    k, count = begin, len(rays.origins)
    while k < place_count(width, count):
        i = ray_of_place(k, width, count)
        if i >= 0:
            hit = first_on_card(geometry, nodes, kinds, scratch, load_ray(rays, i), True)
            result[i] = (1 if hit.body >= 0 else 0) + (DOUBTFUL if hit.unsure else 0)
        k += step


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
    """`locate_packets` for the points begin, begin + step, ..."""
    _open_scratch(scratch)
    i = begin
    while i < len(points):
        place = points[i, 0], points[i, 1], points[i, 2]
        bodies[i], undecided[i] = _first_body(geometry, rest, scratch, place, whole(after[i if len(after) > 1 else 0]))
        i += step


def wall_bounds(
    geometry: Geometry, points: Floats, reach: Floats, bounds: Floats, scratch: Scratch, begin: int, step: int
) -> None:
    """`bounds_of_points` for the points begin, begin + step, ..."""
    i = begin
    while i < len(points):
        x, y, z = points[i, 0], points[i, 1], points[i, 2]
        most = reach[i if len(reach) > 1 else 0]
        bounds[i] = bound_of_point(geometry, scratch.way, scratch.time, x, y, z, most)
        i += step


# Spans and crossings: counted first, written second

ROW_COLUMNS = 10
"""Of a row on a card: those of a span (body/crossing_rows.py), or the fewer of a crossing, and one for sorting."""


@inline
def _item_crossings(
    geometry: Geometry, scratch: Scratch, kinds: int, item: LeafItem, ray: Ray
) -> tuple[int, bool, bool]:
    """`entry_crossings` of an item whose kind is at most `kinds`."""
    if kinds == BALL or item.kind == BALL:
        return ball_crossings(geometry, scratch, item.index, ray)
    if kinds == CELL or item.kind == CELL:
        return cell_crossings(geometry, scratch, item.index, ray)
    return entry_crossings(geometry, scratch, item.entry, ray, 1 << 30)


@helper
def _list_ray(
    geometry: Geometry, nodes: Longs, kinds: int, unscaled: Ray, scratch: Scratch, spans: bool, rows: Floats, first: int
) -> tuple[int, bool]:
    """Write the rows of a ray at rows[first:], sorted; return their number, and whether they are in doubt.

    Without any `rows` it counts. The walk comes to entries in any order, since the sort is by t and body.
    """
    if unscaled.start == DEAD or not is_open(unscaled.t_min, unscaled.t_max):
        return 0, False
    ray, scale = scale_ray(unscaled)
    way, inverse, grid, used, doubtful = scratch.way, span_inverse(ray), ray_grid(geometry, ray), first, False
    last = walk_end(ray.t_max, grid.unit)
    code, top = take_next(way, push_short_roots(geometry, way), last)
    while True:
        code, bits, top = next_items(geometry, nodes, way, ray, grid, inverse, last, ray.t_max, code, top)
        if code == 0:
            break
        begin, after = leaf_range(code)
        at, size = leaf_at(geometry, begin), after - begin
        while bits != 0:
            item = leaf_item(geometry, at, size, lowest_bit(bits))
            bits &= bits - 1
            if spans and item.kind > REGION:
                continue
            crossings, inside, unsure = _item_crossings(geometry, scratch, kinds, item, ray)
            doubtful |= unsure
            if len(rows) == 0:
                used += (crossings + (2 if inside else 1)) >> 1 if spans else crossings
            elif crossings > 0 or inside:
                off = entry_nearness(geometry, item.entry, ray).off
                its = BodyRows(crossings, inside, off, unsure)
                used = put_rows(geometry, scratch, item.entry, its, ray, spans, rows, used)
        code, top = take_next(way, top, last)
    if len(rows) > 0:
        doubtful |= sort_rows_in_place(rows, first, used, spans)
        scale_rows(rows, first, used, scale, unscaled, spans)
    return used - first, doubtful


def list_rows(
    geometry: Geometry, nodes: Longs, kinds: int, width: int, rays: RayArrays, spans: int, offsets: Longs, rows: Floats,
    counts: Ints, doubts: Signs, scratch: Scratch, begin: int, step: int,
) -> None:  # fmt: skip
    """Count the spans or crossings of rays begin, begin + step, ...; or write them, if there are `rows`.

    A doubtful ray has doubts[i] = 1, and none where they are counted. Ray i has the rows from offsets[i] - offsets[0]
    on, as many as were counted; one that turns out to be doubtful where they are sorted keeps its rows.
    """
    _open_scratch(scratch)
    k, count, counting = begin, len(rays.origins), len(rows) == 0
    while k < place_count(width, count):
        i = ray_of_place(k, width, count)
        if i >= 0 and (counting or counts[i] > 0):
            first = 0 if counting else offsets[i] - offsets[0]
            found, unsure = _list_ray(geometry, nodes, kinds, load_ray(rays, i), scratch, spans != 0, rows, first)
            counts[i], doubts[i] = 0 if counting and unsure else found, 1 if unsure else 0
        k += step


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


MARKED = 4096
"""Hits for which one mark says whether one of them is doubtful."""


def mark_doubtful(turn: Signs, marks: Signs, begin: int, step: int) -> None:
    """Set marks[i / MARKED] for doubtful hits begin, begin + step, ..."""
    i = begin
    while i < len(turn):
        if is_doubtful(turn[i]):
            marks[i // MARKED] = 1
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


@inline
def _copy_vectors(
    source: Any, lengths: Longs, steps: Longs, first: int, vectors: Floats, begin: int, step: int
) -> None:
    """Copy vectors begin, begin + step, ..., whose first number is source[first] where all axes begin."""
    i = begin
    while i < len(vectors):
        at, rest = first, i
        for axis in range(len(lengths) - 1, -1, -1):
            at += rest % lengths[axis] * steps[axis]
            rest //= lengths[axis]
        for k in range(3):
            vectors[i, k] = float(source[at + k * steps[len(lengths)]])
        i += step


def copy_vectors(
    source: Floats, lengths: Longs, steps: Longs, first: int, vectors: Floats, begin: int, step: int
) -> None:  # fmt: skip
    """Copy vectors begin, begin + step, ... of an array (*lengths, 3) whose numbers are `steps` apart."""
    _copy_vectors(source, lengths, steps, first, vectors, begin, step)


def copy_single_vectors(
    source: Singles, lengths: Longs, steps: Longs, first: int, vectors: Floats, begin: int, step: int
) -> None:  # fmt: skip
    """`copy_vectors` of float32."""
    _copy_vectors(source, lengths, steps, first, vectors, begin, step)


def start_rays(
    bodies: Ints, surfaces: Ints, directions: Floats, starts: Ints, bad: Signs, begin: int, step: int
) -> None:  # fmt: skip
    """Write the surfaces on which rays begin, begin + step, ... start: ray i on hit i, modulo the number of hits.

    bad[0] = 1 if a direction of a hit cannot be traced. Nobody looks at those of misses, which may be NaN.
    """
    i = begin
    while i < len(starts):
        hit, zeros = i % len(bodies), 0
        starts[i] = surfaces[hit] if bodies[hit] >= 0 else whole(DEAD)
        for k in range(3):
            size = abs(directions[i, k])
            zeros += 1 if size == 0.0 else 0
            if bodies[hit] >= 0 and size != 0.0 and not SMALLEST <= size <= LARGEST:
                bad[0] = 1
        if bodies[hit] >= 0 and zeros == 3:
            bad[0] = 1
        i += step


SUMMED = 64
"""Counts that a thread adds up: two lines of a cache."""


def add_counts(counts: Ints, sums: Longs, offsets: Longs, begin: int, step: int) -> None:
    """Write the sums of `SUMMED` counts each; or, if there are `offsets`, these, from the sum of all counts before."""
    i, counting = begin, len(offsets) == 0
    while i < len(sums):
        total = whole(0) if counting else sums[i]
        for k in range(i * SUMMED, min((i + 1) * SUMMED, len(counts) + 1)):
            if not counting:
                offsets[k] = total
            total += counts[k] if k < len(counts) else 0
        if counting:
            sums[i] = total
        i += step


def put_span_rows(
    first: Longs, counts: Ints, rows: Floats, places: Longs, columns: SpanColumns, begin: int, step: int
) -> None:  # fmt: skip
    """Write the rows of rays begin, begin + step, ..., from first[i] on, to columns from places[i] on."""
    t_enter, t_exit, body, clipped, surfaces = columns
    i = begin
    while i < len(counts):
        for k in range(counts[i]):
            row, at = first[i] + k, places[i] + k
            # + 0.0 as in `put_spans`
            t_enter[at], body[at], t_exit[at] = rows[row, ENTER] + 0.0, rows[row, BODY], rows[row, EXIT] + 0.0
            clipped[0, at], clipped[1, at] = rows[row, ENTER_CLIPPED] != 0.0, rows[row, EXIT_CLIPPED] != 0.0
            surfaces[0, at], surfaces[1, at] = rows[row, ENTER_SURFACE], rows[row, EXIT_SURFACE]
        i += step


def put_crossing_rows(
    first: Longs, counts: Ints, rows: Floats, places: Longs, columns: CrossingColumns, begin: int, step: int
) -> None:  # fmt: skip
    """`put_span_rows` of crossings."""
    t, body, face, surface, entering = columns
    i = begin
    while i < len(counts):
        for k in range(counts[i]):
            row, at = first[i] + k, places[i] + k
            t[at], body[at], face[at] = rows[row, T] + 0.0, rows[row, BODY], rows[row, FACE]
            surface[at], entering[at] = rows[row, SURFACE], rows[row, ENTERS] != 0.0
        i += step


def sign_distances(
    bodies: Ints, reach: Floats, distance: Floats, lower: Floats, error: Floats, begin: int, step: int
) -> None:  # fmt: skip
    """`distance_bounds` of the bounds in `lower`, for the points begin, begin + step, ..."""
    i = begin
    while i < len(bodies):
        bound, most = lower[i], reach[i if len(reach) > 1 else 0]
        beyond = not bound < math.inf
        distance[i] = -bound if bodies[i] >= 0 else bound
        lower[i], error[i] = most if beyond else bound, 0.0 if beyond and most == math.inf else math.inf
        i += step


FUNCTIONS = {
    shorten_nodes: {"nodes": "out * 16"},
    first_hits: {"nodes": "* 16", "found": "out"},
    any_hits: {"nodes": "* 16", "result": "out n"},
    first_bodies: {"points": "n 3", "after": "n|1", "bodies": "out n", "undecided": "out n"},
    wall_bounds: {"points": "n 3", "reach": "n|1", "bounds": "out n"},
    list_rows: {"nodes": "* 16", "offsets": "n+1", "rows": "out * 10", "counts": "out n", "doubts": "out n"},
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
    mark_doubtful: {"turn": "n", "marks": "out *"},
    copy_rows: {"source": "*", "target": "out *", "which": "n"},
    copy_vectors: {"source": "*", "lengths": "*", "steps": "*", "vectors": "out n 3"},
    copy_single_vectors: {"source": "*", "lengths": "*", "steps": "*", "vectors": "out n 3"},
    start_rays: {"bodies": "*", "surfaces": "*", "directions": "n 3", "starts": "out n", "bad": "out 1"},
    add_counts: {"counts": "*", "sums": "out n", "offsets": "out *"},
    put_span_rows: {"first": "n", "counts": "n", "rows": "* 10", "places": "n", "columns": "out"},
    put_crossing_rows: {"first": "n", "counts": "n", "rows": "* 10", "places": "n", "columns": "out"},
    sign_distances: {
        "bodies": "n",
        "reach": "n|1",
        "distance": "out n",
        "lower": "out n",
        "error": "out n",
    },
}
"""The functions that the threads of a GPU run, with the shapes of arguments as `kernel` declares them."""
BY_KIND = frozenset(each.__name__ for each in FUNCTIONS if "kinds" in each.__annotations__)
"""Functions that take the largest kind of an entry, and short nodes."""
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
