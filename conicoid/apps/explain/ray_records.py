"""Intermediate numbers of the kernels for one ray: the data of `scene.explain`.

Nothing is computed here: each kernel calls the functions of the queries and writes their results into a row. All t are
those of the given ray. Other numbers, as a, b and c, are those of the traced ray: its direction is a power of two times
the given one if that is extremely long or short (`ray.scale_ray`).
"""

from __future__ import annotations

import math
from collections.abc import Sequence
from typing import Any

import numpy as np

from ..._jit.decorators import inline, kernel
from ...kernels import tables as table
from ...kernels.body.boolean import gather_events, inside_program_at, undo_events
from ...kernels.body.cell import CellSpans, cell_spans, slab_of
from ...kernels.body.hit import is_doubtful
from ...kernels.body.scratch import EVENT, LEAF, ON, PLACE, TIME, new_scratch
from ...kernels.bvh.culling import hit_balls, lowest_bit
from ...kernels.bvh.walk import (
    OWN_BEAM,
    leaf_at,
    leaf_ball,
    leaf_item,
    leaf_range,
    next_leaf,
    push_roots,
    put_beam,
    scene_tree,
)
from ...kernels.crossings import trace_rows_alone
from ...kernels.faces import cell_faces, numbers_of, plane_faces
from ...kernels.first_hits import HitBuffers, trace_first_alone
from ...kernels.numbers.double_double import difference_of_products
from ...kernels.programs import hold_program, root_count, root_value, turn_leaf
from ...kernels.ray import Ray, RayArrays, line_of, load_ray, scale_ray, span_inverse
from ...kernels.surface.doubt import STARTING
from ...kernels.surface.interval import is_open, nearness_of
from ...kernels.surface.plane import plain_plane, plane_on_ray
from ...kernels.surface.polygon_loop import inside_loop, project_row_vertex
from ...kernels.surface.quadric import careful_quadratic, least_of_sphere, quadratic_on_ray, sphere_on_ray
from ...kernels.surface.records import curved_roots, load_plane, load_quadric, load_sphere, plane_values, quadric_limits
from ...kernels.tables import PLANE, SPHERE, Floats, Geometry, Ints, Signs, integer, poll_halt, whole
from ...prepare.prepared_scene import PreparedScene
from ...queries.exact.doubtful_rays import limits_of_hits
from ...queries.ray_queries import arrays_of
from ...queries.rays import Rays

REACHED, IN_BALL = 1, 2
"""How far a ray gets with an entry: the walk reaches its leaf of the tree; the ray also hits the ball around it."""

# Columns of a curved surface on a ray
A, B, C, DISCRIMINANT, FOOT, CANCELS, LOW, HIGH, OUTSIDE, CROSSES, UNSURE, LEAST = range(12)
# Columns of a plane on a ray; CANCELS, CROSSES and UNSURE as of a curved surface
HEIGHT, RATE, T, PARALLEL = range(4)
SURFACE_COLUMNS = 12

# Columns of a cell: the slab of its planes, the number of its spans, two spans (t_in, t_out, place, place), doubt
SLAB_IN, SLAB_OUT, PLACE_IN, PLACE_OUT, NUMBER, SPANS, CELL_UNSURE, CELL_OFF, CELL_FAR = 0, 1, 2, 3, 4, 5, 13, 14, 15
CELL_COLUMNS = 16

# Columns of an event: t, leaf, place of the face, entered (1) or left (0), true inputs of the root, value of the body
EVENT_T, EVENT_LEAF, EVENT_PLACE, EVENT_ON, EVENT_COUNT, EVENT_INSIDE = range(6)
EVENT_COLUMNS = 6

# Columns of a corner in the view along the ray: u, v; of the edge that ends there: does v change sign, u v' - u' v
SEEN_U, SEEN_V, SEEN_CHANGES, SEEN_SIDE = range(4)
SEEN_COLUMNS = 4


@kernel(i="0..n-1", reached="out entry_kind", balls="out entry_kind 4")
def record_walk(geometry: Geometry, rays: RayArrays, i: int, reached: Signs, balls: Floats) -> None:
    """Record how far ray i gets with every entry: 0, REACHED or IN_BALL, and the balls around the reached entries.

    It is the walk of `first_crossing`, but does not end at the first hit.
    """
    scratch = new_scratch(geometry)
    way = scratch.way
    ray, _ = scale_ray(load_ray(rays, i))
    if not is_open(ray.t_min, ray.t_max):
        return
    put_beam(way, OWN_BEAM, ray)
    inverse = span_inverse(ray)
    code, _, top = next_leaf(geometry, way, way, OWN_BEAM, push_roots(geometry, way, scene_tree(geometry)))
    while code != 0:
        first, last = leaf_range(code)
        at, count = leaf_at(geometry, first), last - first
        for k in range(count):
            entry, ball = leaf_item(geometry, at, count, k).entry, leaf_ball(geometry, at, count, k)
            reached[entry] = REACHED
            balls[entry, 0], balls[entry, 1], balls[entry, 2], balls[entry, 3] = ball
        # Eight balls are tested at once: a bit is set for each that the ray hits
        for eight in range(0, count, 8):
            bits = hit_balls(geometry.floats, at + eight, count, count - eight, ray, inverse, ray.t_max)
            while bits != 0:
                reached[leaf_item(geometry, at, count, eight + lowest_bit(bits)).entry] = IN_BALL
                bits &= bits - 1
        code, _, top = next_leaf(geometry, way, way, OWN_BEAM, top)


@inline
def _put_plane(geometry: Geometry, surface: int, ray: Ray, scale: float, rows: Floats, k: int) -> None:
    """Write the numbers of a plane on a ray into row k."""
    plane, inverse = load_plane(geometry, integer(geometry, table.SURFACE_ROW, surface)), span_inverse(ray)
    height, rate, unsure = plane_values(geometry, surface, ray, inverse)
    rows[k, HEIGHT], rows[k, RATE] = height, rate
    rows[k, T] = -height / rate * scale
    rows[k, PARALLEL] = 1.0 if plane_on_ray(plane, line_of(ray))[2] else 0.0
    rows[k, CANCELS] = 1.0 if plain_plane(plane, line_of(ray))[2] else 0.0
    rows[k, CROSSES], rows[k, UNSURE] = (1.0 if rate != 0.0 else 0.0), (1.0 if unsure else 0.0)


@inline
def _put_curved(geometry: Geometry, surface: int, ray: Ray, scale: float, rows: Floats, k: int) -> None:
    """Write the numbers of a sphere or quadric on a ray into row k."""
    row, starts, inverse = integer(geometry, table.SURFACE_ROW, surface), surface == ray.start, span_inverse(ray)
    cancels = False
    if integer(geometry, table.SURFACE_KIND, surface) == SPHERE:
        sphere = load_sphere(geometry, row)
        a, b, c, discriminant, foot = sphere_on_ray(sphere, line_of(ray), inverse, starts)
        least = least_of_sphere(sphere, starts)
    else:
        quadric, limits = load_quadric(geometry, row), quadric_limits(geometry, row)
        terms = quadratic_on_ray(quadric, line_of(ray), inverse, starts)
        cancels = terms.cancels
        if cancels:
            terms = careful_quadratic(quadric, line_of(ray), terms)
        a, b, foot = terms.a, terms.b, terms.foot
        # The root t = 0 of the surface that the ray starts on is removed: c = 0, and the discriminant is b²
        c, discriminant = (0.0 if starts else terms.c), (b * b if starts else terms.discriminant)
        least = limits.discriminant * STARTING if starts else limits.discriminant
    roots = curved_roots(geometry, surface, ray, inverse)
    rows[k, A], rows[k, B], rows[k, C], rows[k, DISCRIMINANT], rows[k, FOOT] = a, b, c, discriminant, foot
    rows[k, CANCELS], rows[k, LEAST] = (1.0 if cancels else 0.0), least / inverse
    rows[k, LOW], rows[k, HIGH] = roots.low * scale, roots.high * scale
    rows[k, OUTSIDE], rows[k, CROSSES] = (1.0 if roots.outside else 0.0), (1.0 if roots.crosses else 0.0)
    rows[k, UNSURE] = 1.0 if roots.unsure else 0.0


@kernel(i="0..n-1", surfaces="m", rows="out m 12")
def record_surfaces(geometry: Geometry, rays: RayArrays, i: int, surfaces: Ints, rows: Floats) -> None:
    """Record some surfaces on ray i, a row each."""
    ray, scale = scale_ray(load_ray(rays, i))
    for k in range(len(surfaces)):
        if integer(geometry, table.SURFACE_KIND, surfaces[k]) == PLANE:
            _put_plane(geometry, surfaces[k], ray, scale, rows, k)
        else:
            _put_curved(geometry, surfaces[k], ray, scale, rows, k)


@inline
def _put_spans(found: CellSpans, scale: float, rows: Floats, k: int) -> None:
    """Write the spans of a cell into row k."""
    rows[k, NUMBER], rows[k, CELL_UNSURE] = float(found.number), (1.0 if found.unsure else 0.0)
    rows[k, SPANS], rows[k, SPANS + 1] = found.in1 * scale, found.out1 * scale
    rows[k, SPANS + 2], rows[k, SPANS + 3] = float(found.place_in1), float(found.place_out1)
    rows[k, SPANS + 4], rows[k, SPANS + 5] = found.in2 * scale, found.out2 * scale
    rows[k, SPANS + 6], rows[k, SPANS + 7] = float(found.place_in2), float(found.place_out2)


@kernel(i="0..n-1", cells="m", rows="out m 16")
def record_cells(geometry: Geometry, rays: RayArrays, i: int, cells: Ints, rows: Floats) -> None:
    """Record some cells on ray i, a row each: the slab of their planes, and their spans."""
    ray, scale = scale_ray(load_ray(rays, i))
    inverse = span_inverse(ray)
    for k in range(len(cells)):
        cell = whole(cells[k])
        nearness = nearness_of(geometry, table.CELL_LIMITS, cell, ray, inverse)
        slab = slab_of(geometry, cell, ray, inverse, nearness)[0]
        rows[k, SLAB_IN], rows[k, SLAB_OUT] = slab.t_in * scale, slab.t_out * scale
        rows[k, PLACE_IN], rows[k, PLACE_OUT] = float(slab.place_in), float(slab.place_out)
        rows[k, CELL_OFF], rows[k, CELL_FAR] = nearness.off * scale, nearness.far * scale
        _put_spans(cell_spans(geometry, cell, ray, inverse), scale, rows, k)


@kernel(i="0..n-1", program="0..program_leaf-2")
def record_sweep(geometry: Geometry, rays: RayArrays, i: int, program: int) -> Floats:
    """Return the ends of all leaves of a program on ray i in order, with the value of the program after each group.

    A group has equal t. The first row is the state before all events.
    """
    scratch = new_scratch(geometry)
    ray, scale = scale_ray(load_ray(rays, i))
    events, _ = gather_events(geometry, scratch, program, ray)
    rows = np.zeros((events + 1, EVENT_COLUMNS))
    done = 0
    hold_program(geometry, scratch.counts, program)
    # The state before all events
    rows[0, EVENT_T], rows[0, EVENT_LEAF], rows[0, EVENT_PLACE], rows[0, EVENT_ON] = -math.inf, -1.0, -1.0, 0.0
    rows[0, EVENT_COUNT] = float(root_count(geometry, scratch.counts, program))
    rows[0, EVENT_INSIDE] = 1.0 if root_value(geometry, scratch.counts, program) else 0.0
    while done < events and not poll_halt(geometry, done):
        first, t = done, scratch.time[TIME * done]
        # Events at one t act together
        while done < events and scratch.time[TIME * done] == t:
            at = EVENT * done
            turn_leaf(geometry, scratch.counts, program, scratch.event[at + LEAF], scratch.event[at + ON] == 1)
            done += 1
            rows[done, EVENT_T], rows[done, EVENT_LEAF] = t * scale, float(scratch.event[at + LEAF])
            rows[done, EVENT_PLACE] = float(scratch.event[at + PLACE])
            rows[done, EVENT_ON] = float(scratch.event[at + ON])
            rows[done, EVENT_COUNT] = float(root_count(geometry, scratch.counts, program))
        inside = root_value(geometry, scratch.counts, program)
        # The value after the last event of the group holds for all its rows
        for k in range(first, done):
            rows[k + 1, EVENT_INSIDE] = 1.0 if inside else 0.0
    undo_events(geometry, scratch, program, done)
    return rows


@kernel(i="0..n-1", program="0..program_leaf-2")
def record_clip(geometry: Geometry, rays: RayArrays, i: int, program: int, t: float) -> int:
    """Return 1 if the point of ray i at t lies in the solid that clips a sheet, else 0."""
    scratch = new_scratch(geometry)
    ray, scale = scale_ray(load_ray(rays, i))
    return 1 if inside_program_at(geometry, scratch, program, ray, t / scale)[0] else 0


@kernel(i="0..n-1", polygon="0..polygon_surface-1", seen="out m 4")
def record_loop(geometry: Geometry, rays: RayArrays, i: int, polygon: int, seen: Floats) -> int:
    """Return 1 if ray i passes within the outline of a polygon, else 0; record as many corners as `seen` has rows."""
    ray, _ = scale_ray(load_ray(rays, i))
    first, last = (
        integer(geometry, table.POLYGON_FIRST, polygon),
        integer(geometry, table.POLYGON_FIRST, polygon + 1),
    )
    # The projection of `inside_loop`, along the ray's longest axis
    dx, dy, dz = abs(ray.dx), abs(ray.dy), abs(ray.dz)
    axis = 2 if (dz >= dx) & (dz >= dy) else (0 if dx >= dy else 1)
    ua, va, _, _ = project_row_vertex(geometry, last - 1, axis, ray)
    for k in range(min(len(seen), last - first)):
        ub, vb, _, _ = project_row_vertex(geometry, first + k, axis, ray)
        seen[k, SEEN_U], seen[k, SEEN_V] = ub, vb
        seen[k, SEEN_CHANGES] = 1.0 if (va < 0.0) != (vb < 0.0) else 0.0
        seen[k, SEEN_SIDE] = difference_of_products(ua, vb, ub, va)
        ua, va = ub, vb
    return 1 if inside_loop(geometry, first, last, ray)[0] else 0


# The recorded numbers as Python values.


class RayRecording:
    """The numbers of the kernels for a single ray in (t_min, t_max)."""

    def __init__(self, scene: PreparedScene, ray: Rays, t_min: Any, t_max: Any) -> None:
        self.scene, self.tables = scene, scene.lowered.tables
        self.arrays: RayArrays = arrays_of("explain", scene, ray, t_min, t_max)
        self.start = int(self.arrays.starts[0])
        self.t_min, self.t_max = float(self.arrays.t_min[0]), float(self.arrays.t_max[0])
        x, y, z = self.arrays.directions[0].tolist()
        # The scale depends on the direction alone
        whole = Ray(0.0, 0.0, 0.0, x, y, z, t_min=0.0, t_max=1.0, start=-1)
        self.scale = float(scale_ray(whole)[1])
        """t of the given ray are so many times those of the traced one: a power of two, 1 for usual directions."""

    def walk(self) -> tuple[Any, Any]:
        """Return how far the ray gets with every entry (n,), and the balls (n, 4) around those that it reaches."""
        count = len(self.tables.entry_kind)
        reached, balls = np.zeros(count, np.int8), np.full((count, 4), np.nan)
        record_walk(self.scene.geometry, self.arrays, 0, reached, balls)
        return reached, balls

    def surface(self, surface: int) -> Any:
        """Return the row of a surface."""
        rows = np.zeros((1, SURFACE_COLUMNS))
        record_surfaces(self.scene.geometry, self.arrays, 0, np.array([surface], np.int32), rows)
        return rows[0]

    def cell(self, cell: int) -> Any:
        """Return the row of a cell."""
        rows = np.zeros((1, CELL_COLUMNS))
        record_cells(self.scene.geometry, self.arrays, 0, np.array([cell], np.int32), rows)
        return rows[0]

    def sweep(self, program: int) -> Any:
        """Return the events of a program, after a row with the state before them."""
        return record_sweep(self.scene.geometry, self.arrays, 0, program)

    def holds(self, program: int, t: float) -> bool:
        """Return True if the point at t is in the solid that clips a sheet."""
        return bool(record_clip(self.scene.geometry, self.arrays, 0, program, t))

    def loop(self, polygon: int) -> tuple[bool, Any]:
        """Return (whether the ray passes within an outline, its corners in the view along the ray)."""
        first = self.tables.polygon_first
        seen = np.zeros((int(first[polygon + 1] - first[polygon]), SEEN_COLUMNS))
        return bool(record_loop(self.scene.geometry, self.arrays, 0, polygon, seen)), seen

    def is_first_doubtful(self, hit: Any) -> bool:
        """Return True if the float formulas leave the first hit, which is known, in doubt."""
        geometry, limits, found = self.scene.geometry, np.empty(1), HitBuffers.new(1)
        # As far as the hit and its error: surfaces beyond cannot make it doubtful
        limits_of_hits(geometry, self.arrays, hit._buffers.t, hit._buffers.entry, limits)
        trace_first_alone(geometry, self.arrays._replace(t_max=limits), 0, 1, found)
        return bool(is_doubtful(found.turn[0]))

    def is_doubtful(self) -> bool:
        """Return True if the float formulas leave anything along the ray in doubt."""
        counts, doubts = np.zeros(1, np.int32), np.zeros(1, np.int8)
        trace_rows_alone(self.scene.geometry, self.arrays, False, 0, 1, counts, doubts)
        return bool(doubts[0])

    def face_at(self, place: int) -> tuple[int, int]:
        """Return (surface, face number) of a place; (-1, -1) at infinity.

        A place is the row of a plane, or -2 - the cell for its quadric.
        """
        tables = self.tables
        if place == -1:
            return -1, -1
        if place < 0:
            return int(tables.cell_quadric[-2 - place]), int(numbers_of(cell_faces(tables, -2 - place)))
        return int(tables.plane_surface[place]), int(numbers_of(plane_faces(tables, place)))

    def counts(self, t: float, surface: int) -> bool:
        """Return True for a crossing within the interval but not at the ray's start (`kernels/surface/interval.py`)."""
        return self.t_min < t < self.t_max and not self.is_start(t, surface)

    def is_start(self, t: float, surface: int) -> bool:
        """Return True if a crossing is the one that the ray starts on."""
        return t == 0.0 and surface == self.start >= 0

    def ends(self, cell: Any) -> Sequence[tuple[float, int, float, int]]:
        """Return the spans of a cell's row: (t_in, place, t_out, place) each."""
        at = SPANS
        found = [(cell[at], int(cell[at + 2]), cell[at + 1], int(cell[at + 3]))]
        found.append((cell[at + 4], int(cell[at + 6]), cell[at + 5], int(cell[at + 7])))
        return [(float(a), p, float(b), q) for a, p, b, q in found[: int(cell[NUMBER])]]
