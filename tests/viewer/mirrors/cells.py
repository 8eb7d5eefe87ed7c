"""Cells on a ray, Boolean programs, and the events of their leaves."""

from __future__ import annotations

import math
from collections.abc import Callable
from typing import Any

import numpy as np

from conicoid._jit.decorators import inline

from . import table as engine
from .case import Case
from .inputs import COUNT, FEW, RAY, diagonal_rays, exact_rays, rays, records, starting
from .surfaces import ray_of, rays_and_surface
from .table import EVENT, LEAF, ON, PLACE, TIME, Nearness, PlaneSlab


def tables_of(scene: Any) -> Any:
    return scene.scene._prepared.lowered.tables


def _surfaces(tables: Any, of: str, number: int) -> Any:
    """Return the surfaces of a cell, a program or an entry."""
    if of == "cell_quadric":
        planes = tables.plane_surface[tables.cell_first[number] : tables.cell_first[number + 1]]
        return np.concatenate([planes, [s for s in tables.cell_quadric[number : number + 1] if s >= 0]])
    if of == "program_leaf":
        cells = tables.leaf_cell[tables.program_leaf[number] : tables.program_leaf[number + 1]]
        return np.concatenate([_surfaces(tables, "cell_quadric", cell) for cell in cells])
    kind, index = tables.entry_kind[number], tables.entry_index[number]
    if kind in (engine.CELL, engine.REGION):
        return _surfaces(tables, "cell_quadric" if kind == engine.CELL else "program_leaf", index)
    if kind == engine.BALL:
        return np.array([index])
    return (tables.sheet_surface if kind == engine.SHEET else tables.polygon_surface)[index : index + 1]


# Modes of the shader: `mode` of region_crossing and entry_crossing, and of traverse
FIRST, MEDIA, CHORDS, CLOSED = range(4)
NEAREST, BLOCKED, MEDIA_AT = range(3)


def with_number(of: str, some_rays: Any, mode: int = 0, count: int = COUNT, ends: int = 0) -> Any:
    """Return rays, the number of a row of a table, and a mode; a third of the rays start on a surface."""

    def inputs(scene: Any, rng: Any) -> Any:
        number = rng.integers(0, len(getattr(tables_of(scene), of)) - ends, count)
        own = [_surfaces(tables_of(scene), of, k) for k in range(len(getattr(tables_of(scene), of)) - ends)]
        rays_of_rows = starting(rng, some_rays(rng, count), [rng.choice(own[k]) for k in number])
        return records(count, *rays_of_rows, np.column_stack([number, np.full(count, mode)]))

    return inputs


def in_interval(find: Any, change: Callable[[Any], tuple[Any, Any]]) -> Any:
    """Return the rays of `find` in the intervals that `change` makes of their own, (count, 2)."""

    def inputs(scene: Any, rng: Any) -> Any:
        result = find(scene, rng)
        result[:, 0, 3], result[:, 1, 3] = change(result[:, :2, 3])
        return result

    return inputs


def place_face(world, scratch, x, out):
    out[0], out[1], out[2] = engine.place_face(world.geometry, np.int64(x[0]))


def _places(scene: Any, rng: Any) -> Any:
    tables = tables_of(scene)
    curved = -2 - np.flatnonzero(tables.cell_quadric >= 0)
    return records(FEW, rng.choice(np.concatenate([np.arange(len(tables.plane_surface)), curved]), FEW))


@inline
def _put_slab(out, slab):
    out[0] = slab.t_in < slab.t_out
    if slab.t_in < slab.t_out:
        out[1], out[2], out[3], out[4] = slab.place_in, slab.place_out, slab.t_in, slab.t_out


PUT_SLAB = """put(s.t_in < s.t_out);
if (s.t_in < s.t_out) { put(s.place_in); put(s.place_out); put(s.t_in); put(s.t_out); }"""
PLACE_IN, PLACE_OUT, NEW_PLACE = 3, 5, 7


@inline
def _given_slab(x):
    return PlaneSlab(x[0], x[1], np.int64(PLACE_IN), np.int64(PLACE_OUT))


def clip_slab(world, scratch, x, out):
    slab, _ = engine.clip_slab(_given_slab(x), x[4], x[5], x[6] > 0.5, np.int64(NEW_PLACE), 0.0)
    _put_slab(out, slab)


GIVEN_SLAB = f"Slab slab = Slab(given(0).x, given(0).y, {PLACE_IN}, {PLACE_OUT});"
CLIP_GLSL = f"""{GIVEN_SLAB} vec4 plane = given(1);
Slab s = clip_slab(slab, plane.x, plane.y, plane.z > 0.5, {NEW_PLACE}); {PUT_SLAB}"""


def _ends(rng: Any) -> Any:
    """Return (t_in, t_out) of slabs: short fractions, some infinite, some of them empty."""
    ends = rng.integers(-2, 3, (COUNT, 2)) / 2
    ends[:, 0] = np.where(rng.random(COUNT) < 0.2, -1e30, ends[:, 0])
    ends[:, 1] = np.where(rng.random(COUNT) < 0.2, 1e30, np.maximum(ends[:, 1], ends[:, 0]))
    return ends


def _slabs_and_planes(scene: Any, rng: Any) -> Any:
    """Return planes that the ray often crosses where the slab ends, or not at all."""
    height, rate = rng.integers(-2, 3, COUNT) / 2, rng.choice([-2.0, -1.0, 0.0, 1.0, 2.0], COUNT)
    return records(COUNT, _ends(rng), np.column_stack([height, rate, rng.random(COUNT) < 0.5]))


def slab_of(world, scratch, x, out):
    ray, sure = ray_of(x, 0), Nearness(0.0, math.inf)
    slab, _, _ = engine.slab_of(world.geometry, np.int64(x[12]), ray, engine.span_inverse(ray), sure)
    _put_slab(out, slab)


SLAB_GLSL = f"Slab s = slab_of(int(given(3).x), given_ray(0)); {PUT_SLAB}"

PUT_SPANS = """put(s.number);
put(s.number > 0 ? ivec2(s.place_in1, s.place_out1) : ivec2(0)); put(s.number > 1 ? ivec2(s.place_in2, s.place_out2) : ivec2(0));
put(s.number > 0 ? vec2(s.in1, s.out1) : vec2(0.0)); put(s.number > 1 ? vec2(s.in2, s.out2) : vec2(0.0));"""


def compose_spans(world, scratch, x, out):
    """Put spans: the first stands before the second, whether there is another or not."""
    found = engine.compose_spans(_given_slab(x), x[4], x[5], x[6] > 0.5, x[7] > 0.5, np.int64(NEW_PLACE))
    k = 0
    if found.some:
        out[1], out[2], out[5], out[6] = found.place_in1, found.place_out1, found.in1, found.out1
        k += 1
    if found.more:
        at, t = 1 + 2 * k, 5 + 2 * k
        out[at], out[at + 1], out[t], out[t + 1] = found.place_in2, found.place_out2, found.in2, found.out2
        k += 1
    out[0] = k


COMPOSE_GLSL = f"""{GIVEN_SLAB} vec4 roots = given(1);
CellSpans s = compose_spans(slab, roots.x, roots.y, roots.z > 0.5, roots.w > 0.5, {NEW_PLACE});
{PUT_SPANS}"""


def _slabs_and_roots(scene: Any, rng: Any) -> Any:
    """Return roots that are often the ends of the slab; some infinite, as those of planes; either none, or low < high."""
    low = np.where(rng.random(COUNT) < 0.1, -1e30, rng.integers(-3, 3, COUNT) / 2)
    high = np.where(rng.random(COUNT) < 0.1, 1e30, np.maximum(low, -2) + rng.integers(1, 5, COUNT) / 2)
    return records(COUNT, _ends(rng), np.column_stack([low, high, rng.random((COUNT, 2)) < [0.8, 0.5]]))


def cell_spans(world, scratch, x, out):
    ray = ray_of(x, 0)
    found = engine.cell_spans(world.geometry, np.int64(x[12]), ray, engine.span_inverse(ray))
    out[0] = found.number
    if found.number > 0:
        out[1], out[2], out[5], out[6] = found.place_in1, found.place_out1, found.in1, found.out1
    if found.number > 1:
        out[3], out[4], out[7], out[8] = found.place_in2, found.place_out2, found.in2, found.out2


CELL_GLSL = f"""Ray ray = given_ray(0);
CellSpans s = cell_spans(int(given(3).x), ray, 1.0 / dot(ray.d, ray.d));
{PUT_SPANS}"""


def ball_event(world, scratch, x, out):
    ray, surface = ray_of(x, 0), np.int64(x[12])
    roots = engine.curved_roots(world.geometry, surface, ray, engine.span_inverse(ray))
    starts, sure = surface == ray.start, Nearness(0.0, math.inf)
    t, enters, _ = engine.ball_event(roots, starts, ray.t_min, ray.t_max, sure)
    if t < math.inf:
        out[0], out[1], out[2] = 1, enters, t


BALL_GLSL = """Ray ray = given_ray(0);
int surface = int(given(3).x);
tie_counts = false;
put_section(ray);
Crossing c = spans_crossing(ball_spans(surface, ray, 1.0 / dot(ray.d, ray.d)), ray, FIRST, surface);
if (c.found) { put(c.found); put(c.enters); put(c.t); }"""


def gates(world, scratch, x, out):
    """Put the truth of a program for leaves that the bits of two numbers turn on, and back."""
    geometry, program = world.geometry, np.int64(x[0])
    first = engine.integer(geometry, engine.PROGRAM_LEAF, program)
    last = engine.integer(geometry, engine.PROGRAM_LEAF, program + 1)
    on, off = np.int64(x[1]), np.int64(x[2])
    engine.hold_program(geometry, scratch.counts, program)
    out[0] = engine.root_value(geometry, scratch.counts, program)
    for leaf in range(first, last):
        if (on >> (leaf - first)) & 1:
            engine.turn_leaf(geometry, scratch.counts, program, leaf, True)
    out[1] = engine.root_value(geometry, scratch.counts, program)
    for leaf in range(first, last):
        if (on >> (leaf - first)) & (off >> (leaf - first)) & 1:
            engine.turn_leaf(geometry, scratch.counts, program, leaf, False)
    out[2] = engine.root_value(geometry, scratch.counts, program)
    for leaf in range(first, last):
        if (on >> (leaf - first)) & ~(off >> (leaf - first)) & 1:
            engine.turn_leaf(geometry, scratch.counts, program, leaf, False)


GATES_GLSL = """int program = int(given(0).x), on = int(given(0).y), off = int(given(0).z);
ivec4 row = integer4(PROGRAMS, program), after = integer4(PROGRAMS, program + 1);
int leaves = int(given(0).w);
start_gates(row.y, row.z);
put(root_value());
for (int k = 0; k < leaves; k++) if ((on >> k & 1) == 1) turn_leaf(integer4(LEAVES, row.x + k), true);
put(root_value());
for (int k = 0; k < leaves; k++) if ((on >> k & off >> k & 1) == 1) turn_leaf(integer4(LEAVES, row.x + k), false);
put(root_value());"""


def _bits(scene: Any, rng: Any) -> Any:
    program = rng.integers(0, len(tables_of(scene).program_leaf) - 1, COUNT)
    leaves = np.diff(tables_of(scene).program_leaf)[program]
    return records(COUNT, np.column_stack([program, rng.integers(0, 1 << 12, (COUNT, 2)), leaves]))


EVENTS_TRIED, EVENTS_KEPT = 24, 8


def put_event(world, scratch, x, out):
    """Put the events after a t and key, in order: the first ones' keys."""
    count, number = 0, 0
    for k in range(EVENTS_TRIED):
        count = engine.put_event(scratch, count, x[4 + k], k, k, 1)
    engine.sort_events(scratch, count)
    for k in range(count):
        t, leaf = scratch.time[TIME * k], scratch.event[EVENT * k + LEAF]
        if number < EVENTS_KEPT and (t > x[0] or (t == x[0] and 4 * leaf > x[1])):
            out[1 + number] = leaf
            number += 1
    out[0] = number


PUT_EVENT_GLSL = f"""taken_t = given(0).x; taken_key = int(given(0).y); event_count = 0;
for (int k = 0; k < {EVENTS_TRIED}; k++) put_event(given(1 + k / 4)[k % 4], 4 * k, k);
put(event_count);
for (int k = 0; k < event_count; k++) put(event_place[k]);"""


def _event_times(scene: Any, rng: Any) -> Any:
    times = rng.integers(-4, 8, (FEW, EVENTS_TRIED)) / 4
    taken = np.column_stack([rng.choice([-3.0, 0.0, 0.5], FEW), rng.integers(-1, 4 * EVENTS_TRIED, FEW)])
    return np.concatenate([records(FEW, taken), np.float32(times).reshape(FEW, -1, 4)], axis=1)


def gather(world, scratch, x, out):
    """Put the first events, with their leaves and places."""
    count, _ = engine.gather_events(world.geometry, scratch, np.int64(x[12]), ray_of(x, 0))
    out[0] = min(count, 4)
    for k in range(min(count, 4)):
        at = EVENT * k
        out[1 + k], out[5 + k] = 2 * scratch.event[at + LEAF] + scratch.event[at + ON], scratch.event[at + PLACE]
        out[9 + k] = scratch.time[TIME * k]


GATHER_GLSL = """Ray ray = given_ray(0);
taken_t = -2.0 * FAR; taken_key = -1; stack_top = 0;
gather(int(given(3).x), ray, 1.0 / dot(ray.d, ray.d), ray.t_max);
int n = min(event_count, 4);
put(n);
for (int k = 0; k < 4; k++) put(k < n ? (event_key[k] >> 2) * 2 + 1 - (event_key[k] & 1) : 0);
for (int k = 0; k < 4; k++) put(k < n ? event_place[k] : 0);
for (int k = 0; k < 4; k++) put(k < n ? event_t[k] : 0.0);"""


def counts_in(world, scratch, x, out):
    out[0] = engine.counts_in(x[0], x[1] > 0.5, x[2], x[3])


def surface_of(world, scratch, x, out):
    out[0] = engine.surface_of(world.geometry, np.int64(x[0]), x[1])


def _moments(scene: Any, rng: Any) -> Any:
    """Return crossings and ends of intervals that are often equal, half of the crossings with the surface of the start."""
    times = rng.integers(-2, 3, (FEW, 3)) / 2
    return records(FEW, np.column_stack([times[:, 0], rng.random(FEW) < 0.5, times[:, 1:]]))


def _places_and_moments(scene: Any, rng: Any) -> Any:
    return records(FEW, np.column_stack([_places(scene, rng)[:, 0, 0], rng.choice([0.0, 0.5], FEW)]))


NUMBER = (*RAY, "----")


def both(glsl: str, python: Any, answers: int, whole: int, inputs: Any, exact: Any = exact_rays) -> Case:
    """Return a case of both worlds."""
    return Case(glsl, python, answers, inputs(rays), NUMBER, whole=whole, exact_inputs=inputs(exact))


def _cells(some_rays: Any) -> Any:
    return with_number("cell_quadric", some_rays)


CASES = {
    "place_face": Case("put(place_face(int(given(0).x)));", place_face, 3, _places, ("----",), whole=3),
    "clip_slab": Case(CLIP_GLSL, clip_slab, 5, _slabs_and_planes, ("----",) * 2, whole=3),
    "slab_of": both(SLAB_GLSL, slab_of, 5, 3, _cells, diagonal_rays),
    "compose_spans": Case(COMPOSE_GLSL, compose_spans, 9, _slabs_and_roots, ("----",) * 2, whole=5),
    "cell_spans": both(CELL_GLSL, cell_spans, 9, 5, _cells, diagonal_rays),
    "ball_spans": both(BALL_GLSL, ball_event, 3, 2, lambda some_rays: rays_and_surface((1,), some_rays)),
    "turn_leaf": Case(GATES_GLSL, gates, 3, _bits, ("----",), whole=3, exact_inputs=_bits),
    "put_event": Case(
        PUT_EVENT_GLSL, put_event, 1 + EVENTS_KEPT, _event_times, ("----",) * 7, whole=1 + EVENTS_KEPT, sizes={"EVENTS": EVENTS_KEPT}
    ),
    # From minus infinity: the shader also finds events before t_min, where the engine omits boxes
    "gather": both(
        GATHER_GLSL, gather, 13, 9,
        lambda some_rays: in_interval(with_number("program_leaf", some_rays, ends=1), lambda _: (-1e30, 1e30)),
    ),
    "counts_in": Case(
        "tie_counts = false; vec4 g = given(0); put(counts_in(g.x, g.y > 0.5, g.z, g.w));",
        counts_in, 1, _moments, ("----",), whole=1,
    ),
    "surface_of": Case("put(surface_of(int(given(0).x), given(0).y, NO_SURFACE));", surface_of, 1, _places_and_moments, ("----",), whole=1),
}  # fmt: skip
