"""Which function of the shaders mirrors which of Python's; no other file of these tests has their names."""

# ruff: noqa: F401 - the cases take their names from here

from __future__ import annotations

from typing import Any, NamedTuple

from conicoid.kernels.body.boolean import (
    deciding_event,
    gather_events,
    inside_program_at,
    put_event,
    read_crossing,
    region_crossings,
    region_sides,
    sort_events,
    surface_of,
    undo_events,
)
from conicoid.kernels.body.cell import PlaneSlab, cell_spans, clip_slab, compose_spans, place_face, slab_of
from conicoid.kernels.body.entry import (
    crossing_face,
    crossings_of_spans,
    entry_crossings,
    entry_sides,
    polygon_crossings,
    sheet_crossings,
)
from conicoid.kernels.body.hit import ball_event, comes_first
from conicoid.kernels.body.media import find_media
from conicoid.kernels.body.scratch import EVENT, LEAF, ON, PLACE, TIME
from conicoid.kernels.body.uv import turns, uv_at
from conicoid.kernels.bvh.walk import (
    ITS_CODE,
    OWN_BEAM,
    leaf_range,
    on_stack,
    push_children,
    push_node,
    push_roots,
    put_beam,
    reciprocal,
)
from conicoid.kernels.first_hits import is_blocked, resolve_first_crossing
from conicoid.kernels.numbers.vectors import normalize
from conicoid.kernels.programs import hold_program, leaf_decides, new_counts, root_value, turn_leaf
from conicoid.kernels.ray import Ray, line_of, span_inverse
from conicoid.kernels.surface.interval import Nearness, counts_in
from conicoid.kernels.surface.plane import plane_on_ray
from conicoid.kernels.surface.polygon_loop import inside_loop, project_vertex
from conicoid.kernels.surface.quadric import (
    QuadricLimits,
    SphereRecord,
    quadric_gradient,
    quadric_roots,
    roots_of,
    sphere_roots,
)
from conicoid.kernels.surface.records import (
    curved_roots,
    is_curved,
    load_quadric,
    normal_at,
    plane_crossing,
    plane_values,
)
from conicoid.kernels.tables import (
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
from conicoid.render.bsdf.dielectric import wall_reflectance
from conicoid.render.bsdf.layered import opaque_reflectance
from conicoid.render.bsdf.material_table import CHECKER_SPACE, is_even, material_row
from conicoid.render.bsdf.medium import absorb, body_medium, is_invisible_wall, medium_index
from conicoid.render.bsdf.microfacet import dielectric_fresnel, refract
from conicoid.render.integrators.whitted import FAINT, PendingRay, first_visible_wall, new_stack, push
from conicoid.render.interaction import ShadingPoint, SurfaceInteraction
from conicoid.render.lights.direct_light import evaluate_light, highlight, surface_color
from conicoid.render.lights.environment import background_color
from conicoid.render.lights.light_tables import light_direction, light_share
from conicoid.render.tiles import camera_ray


class Mirror(NamedTuple):
    """The mirror of a function of the shaders, and its case if that has another name."""

    python: tuple[Any, ...]
    case: str = ""


def mirror(*python: Any, case: str = "") -> Mirror:
    return Mirror(python, case)


MIRRORS = {
    "normalized": mirror(normalize),
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
    "seen_along": mirror(project_vertex),
    "inside_loop": mirror(inside_loop),
    "reciprocal": mirror(reciprocal, case="push_node"),
    "push_one": mirror(push_children, case="push_node"),
    "push_node": mirror(push_node),
    "push_roots": mirror(push_roots, case="traverse"),
    "leaf_range": mirror(leaf_range),
    "start_gates": mirror(new_counts, undo_events, case="turn_leaf"),
    "root_value": mirror(root_value, case="turn_leaf"),
    "turn_leaf": mirror(turn_leaf),
    "leaf_decides": mirror(leaf_decides, case="region_crossing"),
    "is_after": mirror(sort_events, case="put_event"),
    "put_event": mirror(put_event, sort_events),
    "gather": mirror(gather_events),
    "deciders": mirror(deciding_event, case="region_crossing"),
    "deciding_face": mirror(deciding_event, case="region_crossing"),
    "counts_in": mirror(counts_in),
    "surface_of": mirror(surface_of),
    "spans_crossing": mirror(crossings_of_spans, entry_sides, case="entry_crossing"),
    "region_crossing": mirror(region_crossings, region_sides, inside_program_at),
    "sheet_of": mirror(sheet_crossings, polygon_crossings, case="entry_crossing"),
    "entry_crossing": mirror(entry_crossings, entry_sides, sheet_crossings, polygon_crossings),
    "crossed_face": mirror(crossing_face, case="entry_crossing"),
    "comes_first": mirror(comes_first),
    "traverse": mirror(resolve_first_crossing, find_media, is_blocked),
    "rank_of": mirror(first_visible_wall, case="traverse, noticed"),
    "normal_at": mirror(normal_at),
    "turns": mirror(turns),
    "uv_at": mirror(uv_at),
    "material_row": mirror(material_row),
    "is_even": mirror(is_even),
    "surface_color": mirror(surface_color),
    "medium_of": mirror(body_medium),
    "index_of": mirror(medium_index),
    "unseen": mirror(is_invisible_wall),
    "absorption_of": mirror(is_invisible_wall, case="unseen"),
    "absorbed": mirror(absorb),
    "background_color": mirror(background_color),
    "dielectric": mirror(dielectric_fresnel),
    "opaque_reflectance": mirror(opaque_reflectance),
    "refracted": mirror(refract),
    "wall_reflectance": mirror(wall_reflectance),
    "towards": mirror(light_direction),
    "share": mirror(light_share),
    "highlight": mirror(highlight),
    "light_at": mirror(evaluate_light),
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
"""Function of the shaders -> the reason why it mirrors none."""

OTHER_NAMES = {
    "normalized": "GLSL has a normalize of its own",
    "seen_along": "shorter in shaders",
    "gather": "shorter in shaders",
    "medium_of": "shorter in shaders",
    "index_of": "shorter in shaders",
    "unseen": "shorter in shaders",
    "absorbed": "shorter in shaders",
    "dielectric": "shorter in shaders",
    "towards": "shorter in shaders",
    "share": "shorter in shaders",
    "light_at": "shorter in shaders",
    "ball_spans": "both ends, as a section plane may cut the first; Python takes the first that counts",
    "refracted": "`refract` is built into GLSL",
    "entry_crossing": "one, the first; Python lists them",
    "region_crossing": "one, the first; Python lists them",
    "spans_crossing": "one, the first; Python lists them",
    "traverse": "three of Python's in one, so that the walk is compiled once",
}
"""Why a function's name differs from all that it mirrors, but for parts of a Python function."""


def python_name(function: Any) -> str:
    """Return the place of a function: module and name, without the package's."""
    plain = getattr(function, "py_func", function)
    return f"{plain.__module__.removeprefix('conicoid.')}.{plain.__name__}"
