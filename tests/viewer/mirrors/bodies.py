"""Regions, sheets, entries, and the walk through a scene."""

from __future__ import annotations

import numpy as np

from . import table as engine
from .case import Case
from .cells import BLOCKED, CHORDS, CLOSED, FIRST, MEDIA, MEDIA_AT, NEAREST, both, in_interval, with_number
from .inputs import FEW, records
from .surfaces import ray_of

ENTRY_GLSL = """Ray ray = given_ray(0);
ivec4 entry = integer4(ENTRIES, int(given(3).x));
int mode = int(given(3).y);
tie_counts = false; stack_top = 0;
put_section(ray);
Crossing c = entry_crossing(entry, ray, 1.0 / dot(ray.d, ray.d), mode);
if (mode == MEDIA) { put(c.before); put(c.after); }
else if (mode == CHORDS) put(c.chord);
else if (c.found) { put(1); put(crossed_face(entry, c.place, c.sense)); put(c.enters); put(c.t); }"""


def entry_crossing(world, scratch, x, out):
    """Put the first crossing of an entry: whether there is one, surface, face, side, whether the ray enters, t."""
    geometry, entry = world.geometry, np.int64(x[12])
    count, _, _ = engine.entry_crossings(geometry, scratch, entry, ray_of(x, 0), 1)
    if count > 0:
        t, place, sense, enters = engine.read_crossing(scratch, 0)
        surface, face, side = engine.crossing_face(geometry, entry, place, sense)
        out[0], out[1], out[2], out[3], out[4], out[5] = 1, surface, face, side, enters, t


def entry_sides(world, scratch, x, out):
    ray = ray_of(x, 0)
    out[0], out[1] = engine.entry_sides(world.geometry, scratch, np.int64(x[12]), ray, x[3])


def chords(world, scratch, x, out):
    """Put the length in (t_min, t_max) that a solid's crossings leave inside."""
    geometry, entry, ray = world.geometry, np.int64(x[12]), ray_of(x, 0)
    if engine.integer(geometry, engine.ENTRY_KIND, entry) > engine.REGION:
        return
    count, inside, _ = engine.entry_crossings(geometry, scratch, entry, ray, 1 << 20)
    t = x[3]
    for k in range(count):
        end, _, _, enters = engine.read_crossing(scratch, k)
        out[0] += 0.0 if enters else end - t
        t, inside = end, enters
    if inside and x[7] < 1e29:
        out[0] += x[7] - t


def _with_ends(some_rays):
    find = with_number("entry_kind", some_rays, CHORDS)

    def inputs(scene, rng):
        result = find(scene, rng)
        result[:, 1, 3] = np.minimum(result[:, 1, 3], result[:, 0, 3] + 8)
        result[:, 2, 0] = -1
        return result

    return inputs


def inside_program(world, scratch, x, out):
    out[0], _ = engine.inside_program_at(world.geometry, scratch, np.int64(x[12]), ray_of(x, 0), x[3])


def region_crossing(world, scratch, x, out):
    count, _, _ = engine.region_crossings(world.geometry, scratch, np.int64(x[12]), ray_of(x, 0), 1)
    if count > 0:
        t, place, sense, enters = engine.read_crossing(scratch, 0)
        out[0], out[1], out[2], out[3], out[4] = 1, place, sense, enters, t


REGION_GLSL = """Ray ray = given_ray(0);
int mode = int(given(3).y);
tie_counts = false; stack_top = 0;
put_section(ray);
Crossing c = region_crossing(int(given(3).x), ray, 1.0 / dot(ray.d, ray.d), mode);
if (mode == CLOSED) put(c.after);
else if (c.found) { put(1); put(c.place); put(c.sense); put(c.enters); put(c.t); }"""


def comes_first(world, scratch, x, out):
    """Put which of two crossings comes first, by t and body."""
    out[0] = engine.comes_first(x[0], np.int64(x[1]), x[2], np.int64(x[3]))


def _two_crossings(scene, rng):
    bodies = rng.permuted(np.tile(np.arange(4), (FEW, 1)), axis=1)[:, :2]
    times = rng.integers(0, 3, (FEW, 2)) / 2
    return records(FEW, np.column_stack([times[:, 0], bodies[:, 0], times[:, 1], bodies[:, 1]]))


def resolved_first_crossing(world, scratch, x, out):
    ray = ray_of(x, 0)
    t, body, surface, face, side = engine.resolve_first_crossing(world.geometry, scratch, ray)
    out[0] = -1
    if body >= 0:
        out[0], out[1], out[2], out[3], out[4] = body, surface, face, side, t


TRAVERSE_GLSL = """int mode = int(given(3).y);
Hit h = traverse(given_ray(0), mode, 0x7fffffff);
if (mode == MEDIA_AT) put(h.media);
else if (mode == BLOCKED) put(h.body >= 0);
else {
    put(h.body);
    if (h.body >= 0) { put(h.surface); put(h.face); put(h.side); put(h.t); }
}"""


def media(world, scratch, x, out):
    out[0], out[1] = engine.find_media(world.geometry, scratch, ray_of(x, 0), x[3], world.look.materials.medium)


def blocked(world, scratch, x, out):
    out[0] = engine.is_blocked(world.geometry, scratch, ray_of(x, 0), world.look.materials.opaque)


def noticed(world, scratch, x, out):
    """Put the first wall that light notices: its hit, and the media before and after."""
    materials, ray = world.look.materials, ray_of(x, 0)
    crossed = engine.resolve_first_crossing(world.geometry, scratch, ray)
    crossed, before, after = engine.first_visible_wall(world.geometry, scratch, materials, ray, crossed)
    t, body, surface, face, side = crossed
    out[0] = -1
    if body >= 0:
        out[0], out[1], out[2], out[3], out[4], out[5], out[6] = body, surface, face, side, before, after, t


NOTICED_GLSL = """Ray ray = given_ray(0);
Hit hit;
bool looks = true;
for (int k = 0; k < 64; k++) {
    Hit h = traverse(ray, looks ? NOTICED : MEDIA_AT, 0x7fffffff);
    if (looks) {
        hit = h;
        if (h.body < 0) break;
        ray.t_min = h.t;
    } else {
        int before = medium_of(h.media.x), after = medium_of(h.media.y);
        if ((flags_of(hit.body) & MEDIUM) == 0 || !unseen(hit.body, before, after)) {
            put(hit.body); put(hit.surface); put(hit.face); put(hit.side); put(before); put(after); put(hit.t);
            break;
        }
    }
    looks = !looks;
}
if (hit.body < 0) put(-1);"""


def _programs(mode: int):
    return lambda some_rays: with_number("program_leaf", some_rays, mode, ends=1)


def _scene_rays(mode: int):
    return lambda some_rays: with_number("entry_kind", some_rays, mode, FEW)


CASES = {
    "region_crossing": both(REGION_GLSL, region_crossing, 5, 4, _programs(FIRST)),
    "region_crossing, closed": both(REGION_GLSL, inside_program, 1, 1, _programs(CLOSED)),
    "entry_crossing": both(ENTRY_GLSL, entry_crossing, 6, 5, lambda some_rays: with_number("entry_kind", some_rays, FIRST)),
    "entry_crossing, sides": both(
        # an interval that is a point, as in `media`
        ENTRY_GLSL, entry_sides, 2, 2,
        lambda some_rays: in_interval(with_number("entry_kind", some_rays, MEDIA), lambda ends: (ends[:, 0], ends[:, 0])),
    ),
    "entry_crossing, chords": both(ENTRY_GLSL, chords, 1, 0, _with_ends),
    "comes_first": Case(
        "vec4 g = given(0); put(comes_first(g.x, int(g.y), g.z, int(g.w)));", comes_first, 1, _two_crossings, ("----",), whole=1
    ),
    "traverse": both(TRAVERSE_GLSL, resolved_first_crossing, 5, 4, _scene_rays(NEAREST)),
    "traverse, media": both(TRAVERSE_GLSL, media, 2, 2, _scene_rays(MEDIA_AT)),
    "traverse, blocked": both(TRAVERSE_GLSL, blocked, 1, 1, _scene_rays(BLOCKED)),
}  # fmt: skip
DEAR_CASES = {
    "traverse, noticed": both(
        NOTICED_GLSL,
        noticed,
        7,
        6,
        lambda some_rays: in_interval(with_number("entry_kind", some_rays, count=FEW), lambda _: (0, 1e30)),
    )
}
"""Up to 64 walks for each input."""
