"""Which function of the shaders mirrors which of Python's; the only place of these tests that knows their names."""

# ruff: noqa: F401 - the cases take their names from here

from __future__ import annotations

from typing import Any, NamedTuple

from conicoid.engine.body.ball import ball_event
from conicoid.engine.body.boolean import (
    crossing,
    gather,
    inside_program_at,
    put_event,
    region_crossings,
    region_sides,
    sort_events,
    surface_of,
    turn_back,
)
from conicoid.engine.body.cell import cell_spans, place_face, slab_of
from conicoid.engine.body.entry import (
    crossed_face,
    crossings_of_spans,
    entry_crossings,
    entry_sides,
)
from conicoid.engine.body.gates import hold, new_counts, root_value, turn_leaf
from conicoid.engine.body.hit import comes_first
from conicoid.engine.body.media import media
from conicoid.engine.body.scratch import EVENT, LEAF, ON, PLACE, TIME
from conicoid.engine.body.sheet import polygon_crossings, sheet_crossings
from conicoid.engine.body.spans import Slab, clip_slab, compose_spans
from conicoid.engine.body.uv import turns, uv_at
from conicoid.engine.numbers.vectors import normalized
from conicoid.engine.ray import Ray, line_of, span_inverse
from conicoid.engine.single.first import blocked, resolved_first_crossing
from conicoid.engine.surface.interval import counts_in
from conicoid.engine.surface.loop import inside_loop, seen_along
from conicoid.engine.surface.nearness import Nearness
from conicoid.engine.surface.normal import normal_at
from conicoid.engine.surface.plane import plane_on_ray
from conicoid.engine.surface.quadric import (
    QuadricLimits,
    Sphere,
    quadric_gradient,
    quadric_roots,
    roots_of,
    sphere_roots,
)
from conicoid.engine.surface.records import curved_roots, is_curved, load_quadric, plane_crossing, plane_values
from conicoid.engine.tables import (
    BALL,
    CELL,
    ENTRY_INDEX,
    ENTRY_KIND,
    LEAF_CELL,
    LEAF_GATE,
    NODE_CHILDREN,
    POLYGON_FIRST,
    PROGRAM_LEAF,
    REGION,
    SHEET,
    SURFACE_ROW,
    integer,
)
from conicoid.engine.tree.leaf import leaf_range
from conicoid.engine.tree.walk import (
    ITS_CODE,
    OWN_BEAM,
    on_stack,
    push_met,
    push_node,
    push_roots,
    put_beam,
    reciprocal,
)
from conicoid.integrators.stack import FAINT, Pending, new_stack, push
from conicoid.integrators.whitted import first_noticed, opaque_reflectance
from conicoid.render.tiles import camera_ray
from conicoid.shading.background import background_color
from conicoid.shading.checker import is_even
from conicoid.shading.fresnel import dielectric
from conicoid.shading.lights import share, towards
from conicoid.shading.local import highlight, light_at, surface_color
from conicoid.shading.materials import CHECKER_SPACE, material_row
from conicoid.shading.media import absorbed, index_of, medium_of, unseen
from conicoid.shading.refract import refract
from conicoid.shading.shadow import wall_reflectance
from conicoid.shading.sight import ShadingPoint, Sight


class Mirror(NamedTuple):
    """What a function of the shaders mirrors, and the case that tries it, if that has another name."""

    python: tuple[Any, ...]
    case: str = ""


def mirror(*python: Any, case: str = "") -> Mirror:
    return Mirror(python, case)


MIRRORS = {
    "normalized": mirror(normalized),
    "roots_of": mirror(roots_of),
    "sphere_roots": mirror(sphere_roots),
    "load_quadric": mirror(load_quadric, case="quadric_roots"),
    "quadric_roots": mirror(quadric_roots),
    "quadric_gradient": mirror(quadric_gradient),
    "curved_roots": mirror(curved_roots),
    "is_curved": mirror(is_curved),
    "plane_height": mirror(plane_on_ray, case="plane_values"),
    "plane_values": mirror(plane_values),
    "zero_of": mirror(plane_crossing, clip_slab, case="clip_slab"),
    "plane_crossing": mirror(plane_crossing),
    "clip_slab": mirror(clip_slab),
    "slab_of": mirror(slab_of),
    "compose_spans": mirror(compose_spans),
    "cell_spans": mirror(cell_spans),
    "ball_spans": mirror(ball_event),
    "place_face": mirror(place_face),
    "seen_along": mirror(seen_along),
    "inside_loop": mirror(inside_loop),
    "reciprocal": mirror(reciprocal, case="push_node"),
    "push_one": mirror(push_met, case="push_node"),
    "push_node": mirror(push_node),
    "push_roots": mirror(push_roots, case="traverse"),
    "leaf_range": mirror(leaf_range),
    "start_gates": mirror(new_counts, turn_back, case="turn_leaf"),
    "root_value": mirror(root_value, case="turn_leaf"),
    "turn_leaf": mirror(turn_leaf),
    "is_after": mirror(sort_events, case="put_event"),
    "put_event": mirror(put_event, sort_events),
    "gather": mirror(gather),
    "counts_in": mirror(counts_in),
    "surface_of": mirror(surface_of),
    "spans_crossing": mirror(crossings_of_spans, entry_sides, case="entry_crossing"),
    "region_crossing": mirror(region_crossings, region_sides, inside_program_at),
    "sheet_of": mirror(sheet_crossings, polygon_crossings, case="entry_crossing"),
    "entry_crossing": mirror(entry_crossings, entry_sides, sheet_crossings, polygon_crossings),
    "crossed_face": mirror(crossed_face, case="entry_crossing"),
    "comes_first": mirror(comes_first),
    "traverse": mirror(resolved_first_crossing, media, blocked),
    "rank_of": mirror(first_noticed, case="traverse, noticed"),
    "normal_at": mirror(normal_at),
    "turns": mirror(turns),
    "uv_at": mirror(uv_at),
    "material_row": mirror(material_row),
    "is_even": mirror(is_even),
    "surface_color": mirror(surface_color),
    "medium_of": mirror(medium_of),
    "index_of": mirror(index_of),
    "unseen": mirror(unseen),
    "absorption_of": mirror(unseen, case="unseen"),
    "absorbed": mirror(absorbed),
    "background_color": mirror(background_color),
    "dielectric": mirror(dielectric),
    "opaque_reflectance": mirror(opaque_reflectance),
    "refracted": mirror(refract),
    "wall_reflectance": mirror(wall_reflectance),
    "towards": mirror(towards),
    "share": mirror(share),
    "highlight": mirror(highlight),
    "light_at": mirror(light_at),
    "push": mirror(push),
    "camera_ray": mirror(camera_ray),
}
"""Function of the shaders -> functions of Python."""

READS = "reads records of a texture, as it is tried with every function that needs them"
PAGE = "of the page alone: the engine draws no section plane, no tint and no soft shadow"
MADE = "makes a structure"
SHOWN = "compared by pictures: Whitted's method, whose calls are steps of one loop here"
NO_MIRROR = {
    "real4": READS,
    "record": READS,
    "integer4": READS,
    "number_and_side": READS,
    "flags_of": READS,
    "load_material": READS,
    "load_light": READS,
    "own": "W v of a quadric, which Python writes out; tried with quadric_roots and quadric_gradient",
    "no_crossing": MADE,
    "at_crossing": MADE,
    "put_section": PAGE,
    "noise": PAGE,
    "noise_in_ball": PAGE,
    "on_surface": "puts a point back on its plane, which it leaves in single precision only",
    "whitted_radiance": SHOWN,
    "main": "of a pixel",
}
"""Function of the shaders -> why it mirrors none."""

OTHER_NAMES = {
    "ball_spans": "both ends, as a section plane may cut the first; Python takes the first that counts",
    "refracted": "`refract` is built into GLSL",
    "entry_crossing": "one, the first; Python lists them",
    "region_crossing": "one, the first; Python lists them",
    "spans_crossing": "one, the first; Python lists them",
    "traverse": "three of Python's in one, so that the walk is compiled once",
}
"""Why a function is called otherwise than all that it mirrors; but for those that are a part of a Python function."""


def python_name(function: Any) -> str:
    """Where a function stands: module and name, without the package's."""
    plain = getattr(function, "py_func", function)
    return f"{plain.__module__.removeprefix('conicoid.')}.{plain.__name__}"
