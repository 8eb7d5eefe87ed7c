"""A scene as plain JSON for the page: tables, materials, lights, camera and bodies; and answers about its rays.

The tables have rows of their own for every body: the shaders know no shared rows. `check_limits` refuses scenes beyond
what every browser with WebGL 2 can be expected to hold.
"""

from __future__ import annotations

import base64
import math
from collections.abc import Collection, Mapping
from typing import Any

import numpy as np
import numpy.typing as npt

from .._util.arrays import FloatArray, Vector, dot_rows, row_ends, row_lengths
from .._util.validation import check_number, check_vector
from ..geometry.labels import body_material_table
from ..kernels import tables as table
from ..kernels.body.uv import maps_of_faces
from ..kernels.bvh.walk import FEW, ROWS
from ..kernels.faces import cell_faces, plane_faces
from ..kernels.programs import leaves_of_programs, row_of_leaf, rows_of_programs
from ..kernels.tables import Ints, Tables, length
from ..materials.material import DEFAULT_MATERIAL
from ..queries.hits import Hits
from ..render.bsdf.material_table import CHECKER_SPACE, CHECKER_UV, PLAIN
from ..render.camera import Camera, EquirectangularCamera, FisheyeCamera, OrthographicCamera, fit_lights
from ..render.lights.light_tables import ShadingTables, lower_shading_tables
from ..scene.scene import Scene

MOST_BYTES = 256 << 20
"""The largest size of all tables together, as the page holds them."""
MOST_GATES = 1024
"""The largest number of gates in the Boolean program of one body: the shader has a counter for each along a ray."""


def check_limits(tables: Mapping[str, Any]) -> None:
    """Raise ValueError for tables that are too large for the page, with the limit. The page checks its own GPU."""
    size = sum(array.size * max(4, array.itemsize) for array in tables.values())  # the page holds signs as integers
    if size > MOST_BYTES:
        raise ValueError(
            f"view: this scene's tables take {size / 2**20:,.0f} MiB, "
            f"a page holds at most {MOST_BYTES / 2**20:,.0f} MiB"
        )
    gates = int(np.diff(tables["program_gate"]).max(initial=0))
    if gates > MOST_GATES:
        raise ValueError(
            f"view: a body is a Boolean combination of {gates:,} nested steps, the shader counts at most {MOST_GATES:,}"
        )


# --- Tables without shared rows


def expand_tables(tables: Tables) -> dict[str, npt.NDArray[Any]]:
    """Return the columns that differ from those of `tables`: leaves, gates, maps of faces, and trees of few leaves."""
    columns = _trees(tables)
    if len(tables.program_shifts):
        columns |= expand_programs(tables)
    if len(tables.cell_likes):
        columns |= expand_faces(tables)
    if len(tables.body_maps):
        columns["face_maps"] = maps_of_faces(tables)
    return columns


def expand_programs(tables: Tables) -> dict[str, npt.NDArray[Any]]:
    """Return the leaves and gates of every program, without shared rows."""
    rows, (leaf_of, leaves) = rows_of_programs(tables), leaves_of_programs(tables)
    gates = np.diff(tables.program_gate)[rows]
    first = row_ends(gates)
    shift = first[:-1] - tables.program_gate[rows]
    of_gates, of_leaves = np.repeat(shift, gates), np.repeat(shift, leaves)
    gate = np.arange(first[-1], dtype=np.int32) - of_gates
    programs = np.repeat(np.arange(len(rows)), leaves)
    begins = row_ends(leaves)
    number = np.repeat(leaf_of - begins[:-1], leaves) + np.arange(len(programs), dtype=np.int32)
    leaf = row_of_leaf(tables, programs, number)
    parent = tables.gate_parent[gate]
    return dict(
        program_leaf=begins,
        program_gate=first,
        leaf_cell=number,
        leaf_gate=tables.leaf_gate[leaf] + of_leaves,
        leaf_negated=tables.leaf_negated[leaf],
        leaf_sense=tables.leaf_sense[leaf],
        gate_parent=np.where(parent < 0, parent, parent + of_gates),
        gate_need=tables.gate_need[gate],
        gate_negated=tables.gate_negated[gate],
        gate_start=tables.gate_start[gate],
    )


def expand_faces(tables: Tables) -> dict[str, npt.NDArray[Any]]:
    """Return the faces of every cell."""
    return dict(
        cell_face=cell_faces(tables, np.arange(len(tables.cell_quadric))),
        plane_face=plane_faces(tables, np.arange(len(tables.plane_surface))),
    )


def _trees(tables: Tables) -> dict[str, npt.NDArray[Any]]:
    """Return the trees of bodies over expanded leaves.

    Bodies of a few leaves have no tree; here each gets a tree of one leaf, and their places come last.
    """
    leaf_of, leaves = leaves_of_programs(tables)
    first = row_ends(leaves)
    few = np.flatnonzero((leaves > 0) & (leaves <= FEW))
    tree_leaves = _known_order(tables, leaf_of, leaves, first)
    if not len(few):
        return dict(tree_order=tree_leaves)
    root_counts = np.diff(tables.tree_root, prepend=np.zeros(len(first) + 1 - len(tables.tree_root), np.int32))
    # A body of a few leaves gets one root; those of other bodies keep their order
    root_counts[few] = 1
    ends = row_ends(root_counts)
    roots = np.zeros(ends[-1], np.int32)
    in_trees = np.ones(len(roots), bool)
    in_trees[ends[few]] = False
    roots[in_trees] = tables.roots
    places = len(tables.tree_order) + row_ends(leaves[few])
    roots[ends[few]] = -(places[:-1] << 4 | leaves[few]) - 1
    few_leaves = np.repeat(first[few] - places[:-1], leaves[few]) + np.arange(len(tables.tree_order), places[-1])
    order = np.concatenate([tree_leaves, few_leaves]).astype(np.int32)
    return dict(tree_root=ends, roots=roots, tree_order=order)


def _known_order(tables: Tables, leaf_of: Ints, leaves: Ints, first: Ints) -> Ints:
    """Return `Tables.tree_order` with the numbers of expanded leaves, those from `first` on, for shared leaves."""
    if not len(tables.program_shifts):
        return tables.tree_order
    renumbered = np.zeros(len(tables.cell_quadric), np.int32)
    cells = np.repeat(leaf_of - first[:-1], leaves) + np.arange(first[-1], dtype=np.int32)
    renumbered[cells] = np.arange(first[-1], dtype=np.int32)
    order, of_bodies = tables.tree_order.copy(), len(tables.tree_order) - len(tables.leaf_items) // ROWS
    order[:of_bodies] = renumbered[order[:of_bodies]]
    return order


# --- The data of a scene

ASPECT = 4 / 3
_UNUSED = {
    "leaf_bounds",
    "cell_likes",
    "program_row",
    "program_shifts",
    "shifts",
    "body_maps",
    "leaf_items",
    "cell_groups",
    "group_bounds",
    "group_planes",
    *(name for name in Tables._fields if name.endswith("_limits")),
}
_MOST_NAMED = 400
"""The largest number of entries with a row of their own in the list of the page."""


def pack_scene(scene: Scene) -> dict[str, Any]:
    """Return all data of a scene that the page needs; every array as base64 of little-endian float64 or int32.

    Raises ValueError for a scene that is too large for a browser, with the limit.
    """
    scene._close_gaps()
    camera = view_of(scene)
    lights = scene.lights or fit_lights(camera)
    look = look_of(scene, lights)
    low, high = scene.extent
    tables = {name: _array(scene, number) for number, name in enumerate(Tables._fields) if name not in _UNUSED}
    # The engine takes the tables with shared rows, see `engine_data`
    tables |= {name: column.ravel() for name, column in expand_tables(scene._prepared.lowered.tables).items()}
    check_limits(tables)
    return {
        "tables": {name: _encoded(array) for name, array in tables.items()},
        "look": look_data(look),
        "lights": [_light(record, light) for record, light in zip(look.lights, _directed(lights), strict=True)],
        "camera": camera_data(camera),
        "bounds": [low.tolist(), high.tolist()],
        "items": [_item(scene, i) for i in range(min(len(scene.bodies), _MOST_NAMED))],
        "item_count": len(scene.bodies),
        "body_item": _encoded(scene._prepared.lowered.body_item),
    }


def view_of(scene: Scene) -> Camera | OrthographicCamera:
    """Return the camera of the scene, or one that fits.

    A camera that sees all around becomes a pinhole camera that looks the same way.
    """
    camera = scene.camera or scene.fitting_camera(ASPECT)
    if isinstance(camera, EquirectangularCamera | FisheyeCamera):
        return Camera(camera.position, camera.look_at, camera.up)
    if not isinstance(camera, Camera | OrthographicCamera):
        raise TypeError(f"view: camera must be a Camera or an OrthographicCamera, got {type(camera).__name__}")
    return camera


def look_of(scene: Scene, lights: Any) -> ShadingTables:
    """Return the tables of materials and lights."""
    lowered = scene._prepared.lowered
    distinct, sheets, place_of = body_material_table(scene.bodies, lowered.body_item)
    materials = [DEFAULT_MATERIAL if material is None else material for material in distinct]
    return lower_shading_tables(materials, sheets, place_of, lights, scene.background, lowered.face_paint)


def camera_data(camera: Camera | OrthographicCamera) -> dict[str, Any]:
    """Return a camera as its fields."""
    data = {"position": camera.position, "look_at": camera.look_at, "up": camera.up}
    if isinstance(camera, Camera):
        return data | {"field_of_view": camera.field_of_view}
    return data | {"height": camera.height}


def look_data(look: ShadingTables) -> dict[str, Any]:
    """Return eight rows of four numbers for each material, in the order of viewer/shaders/materials.glsl."""
    rows = look.materials.rows
    packed = np.zeros((len(rows), 8, 4))
    for out, row in zip(packed, rows, strict=True):
        columns = ("color", "second_color", "scale", "specular", "reflectivity", "transparency", "absorption")
        for k, name in enumerate(columns):
            out[k, :3] = row[name]  # the fourth number of each row is a scalar of its own, below
        numbers = ("pattern", "ambient", "diffuse", "shininess", "half_vector", "fresnel", "index", "transparent")
        for k, name in enumerate(numbers):
            out[k, 3] = row[name] if name != "pattern" or row[name] <= CHECKER_SPACE else PLAIN
    assert (CHECKER_UV, CHECKER_SPACE) == (1, 2), "the shader knows them by these numbers"
    return {
        "materials": _encoded(packed.ravel()),
        "row_of": _encoded(look.materials.row_of),
        "face_row": _encoded(look.materials.face_row),
        "opaque": _encoded(look.materials.opaque),
        "medium": _encoded(look.materials.medium),
        "any_transparent": look.materials.any_transparent,
        "ambient": look.ambient,
        "sky": look.background,
    }


def _directed(lights: Any) -> list[Any]:
    """Return the lights that have a place or a direction, which are those with a record."""
    return [light for light in lights if hasattr(light, "position") or hasattr(light, "direction")]


def _light(record: Any, light: Any) -> dict[str, Any]:
    """Return the record of a light; an infinite angle becomes null."""
    data: dict[str, Any] = {
        name: record[name].tolist() for name in ("parallel", "position", "axis", "intensity", "fades")
    }
    for name in ("outer", "inner"):
        data[name] = float(record[name]) if np.isfinite(record[name]) else None
    return data | {"radius": float(getattr(light, "radius", 0.0) or 0.0)}


def _item(scene: Scene, number: int) -> dict[str, Any]:
    """Return the row of an entry in the list of bodies."""
    body = scene.bodies[number]
    return {"name": body.name, "shape": type(body.shape).__name__, "sheet": body.shape.is_sheet}


def _array(scene: Scene, number: int) -> npt.NDArray[Any]:
    """Return a table as a flat array, from those that the kernels take."""
    geometry = scene._prepared.geometry
    start, count = int(geometry.places[number]), int(length(geometry, number))
    real = number in _REAL
    flat: npt.NDArray[Any] = geometry.floats if real else geometry.integers
    return flat[start : start + count]


_REAL = {
    table.PLANES, table.SPHERES, table.QUADRICS, table.QUADRIC_FORMS, table.VERTICES, table.BALL_FRAMES,
    table.MAP_ROWS, table.NODE_BOXES, table.EXTENT,
}  # fmt: skip


def _encoded(array: npt.NDArray[Any]) -> dict[str, str]:
    """Return an array as base64, with its type."""
    real = array.dtype.kind == "f"
    data = np.ascontiguousarray(array, "<f8" if real else "<i4").tobytes()
    return {"f8" if real else "i4": base64.b64encode(data).decode()}


# Answers of the exact engine about a ray of a page: the first hit, and all spans and crossings on the ray.
#
# `pick` takes hidden bodies and a section plane into account; `explain_pick` explains the ray with one body.

Interval = tuple[float, float]
MISTAKES = (ValueError, TypeError, LookupError, AttributeError, OverflowError, RecursionError)
"""Errors that an invalid request raises, here and in edits of numbers."""


def pick(scene: Scene, request: dict[str, Any]) -> dict[str, Any]:
    """Answer {origin, direction, hidden, section} with {found: null}, or with the hit and everything on the ray.

    Floats are exact. Raises ValueError for an invalid request.

    hidden: entries of the scene that the ray ignores. section: {normal, offset}; only the parts of solids in the
    half-space normal·x <= offset count.
    """
    origin, direction = (np.array(_vector(request, name)) for name in ("origin", "direction"))
    hidden = {int(item) for item in request.get("hidden") or ()}
    interval = _interval(request.get("section"), origin, direction)
    crossings = _crossings(scene, origin, direction, hidden, interval)
    spans, cuts = _spans(scene, origin, direction, hidden, interval)
    # A cut is visible only if no crossing precedes it
    cuts = [cut for cut in cuts if not crossings or cut["t"] <= crossings[0]["t"]]
    rest = {"spans": spans, "crossings": crossings}
    if cuts:
        return {"found": _cut(cuts[0], request["section"], origin, direction) | rest}
    if not crossings:
        return {"found": None}
    return {
        "found": _hit(scene, origin, direction, crossings[0], bool(hidden) or interval != (-math.inf, math.inf)) | rest
    }


def explain_pick(scene: Scene, request: dict[str, Any]) -> dict[str, Any]:
    """Answer {origin, direction, body} with {text}: the explanation of a ray with a body. Nothing is hidden here."""
    body = request.get("body")
    explanation = scene.explain(*(_vector(request, name) for name in ("origin", "direction")), body=int(body))  # type: ignore[arg-type]
    return {"text": explanation.text}


def name_of(scene: Scene, item: int) -> str:
    """Return the name of a body, or its shape and number, as the page shows it."""
    body = scene.bodies[item]
    return body.name or f"{type(body.shape).__name__} {item}"


def _vector(request: dict[str, Any], name: str) -> Vector:
    """Return a checked vector of a request; a direction must not be zero."""
    return check_vector("pick", name, request.get(name), nonzero=name == "direction")


def _interval(section: Any, origin: FloatArray, direction: FloatArray) -> Interval:
    """Return the interval of a ray in the half-space of a section."""
    if section is None:
        return -math.inf, math.inf
    normal = np.array(check_vector("section", "normal", section.get("normal"), nonzero=True))
    height = float(dot_rows(normal, origin)) - check_number("section", "offset", section.get("offset"))
    rate = float(dot_rows(normal, direction))
    if rate == 0.0:  # parallel to the plane: all of the ray or nothing
        return (-math.inf, math.inf) if height <= 0.0 else (math.inf, -math.inf)
    return (-height / rate, math.inf) if rate < 0.0 else (-math.inf, -height / rate)


def _crossings(
    scene: Scene, origin: FloatArray, direction: FloatArray, hidden: Collection[int], interval: Interval
) -> list[dict[str, Any]]:
    """Return a row for each crossing with a visible body: sheets everywhere, solids inside the section."""
    crossings = scene.crossings(origin, direction)
    items = scene._prepared.lowered.body_item
    rows: list[dict[str, Any]] = []
    columns = crossings.t, crossings.t_error, crossings.body, crossings.face, crossings.surface, crossings.entering
    for t, error, body, face, surface, entering in zip(*columns, strict=True):
        item = int(items[body])
        # Sheets are not cut: a section keeps parts of solids only
        if item in hidden or not (scene.bodies[item].shape.is_sheet or interval[0] < t < interval[1]):
            continue
        row = {"t": float(t), "body": int(body), "face": int(face), "surface": int(surface), "entering": bool(entering)}
        rows.append(row | {"t_error": _finite(error), "name": name_of(scene, item)})
    return rows


def _spans(
    scene: Scene, origin: FloatArray, direction: FloatArray, hidden: Collection[int], interval: Interval
) -> tuple[list[dict[str, Any]], list[dict[str, Any]]]:
    """Return (spans, ends on the section plane in order along the ray)."""
    low, high = max(0.0, interval[0]), interval[1]
    if not low < high:
        return [], []
    result = scene.spans(origin, direction, t_min=low, t_max=high)
    spans: list[dict[str, Any]] = []
    cuts: list[dict[str, Any]] = []
    for enter, exit_, body, starts, ends in zip(
        result.t_enter, result.t_exit, result.body, result.enter_clipped, result.exit_clipped, strict=True
    ):
        item = int(scene._prepared.lowered.body_item[body])
        if item in hidden:
            continue
        name = name_of(scene, item)
        spans.append({"name": name, "body": int(body), "enter": _finite(enter), "exit": _finite(exit_)})
        if starts and enter == interval[0] > 0.0:
            cuts.append({"t": float(enter), "body": int(body), "name": name, "entering": True})
        if ends and exit_ == interval[1]:
            cuts.append({"t": float(exit_), "body": int(body), "name": name, "entering": False})
    return spans, sorted((cut for cut in cuts if math.isfinite(cut["t"])), key=lambda cut: cut["t"])


def _finite(t: float) -> float | None:
    """Return a float, or None for one that is not finite."""
    return float(t) if math.isfinite(t) else None


def _cut(cut: dict[str, Any], section: Any, origin: FloatArray, direction: FloatArray) -> dict[str, Any]:
    """Return the hit of a ray with the section plane."""
    normal = np.array(section["normal"], dtype=np.float64)
    point = origin + cut["t"] * direction
    return cut | {
        "face": None, "surface": None, "point": point.tolist(), "normal": (normal / row_lengths(normal)).tolist(),
        "uv": None,
    }  # fmt: skip


def _hit(
    scene: Scene, origin: FloatArray, direction: FloatArray, first: dict[str, Any], selected: bool
) -> dict[str, Any]:
    """Return the first hit; `selected`: `first` is the first visible crossing, which other crossings may precede."""
    t = first["t"]
    # Hidden crossings may come first, so the interval holds only the selected one
    limits = (math.nextafter(t, -math.inf), math.nextafter(t, math.inf)) if selected else (0.0, math.inf)
    hit = scene.first_hit(origin, direction, *limits)
    if hit.body != first["body"]:
        hit = _hit_of_one(scene, origin, direction, first)
    return {
        "name": first["name"], "t": t, "t_error": first["t_error"],
        "body": first["body"], "face": first["face"], "surface": first["surface"],
        "entering": first["entering"],
        "point": hit.point.tolist(), "normal": hit.normal.tolist(), "uv": hit.uv.tolist(),
    }  # fmt: skip


def _hit_of_one(scene: Scene, origin: FloatArray, direction: FloatArray, first: dict[str, Any]) -> Hits:
    """Return the hit of a crossing whose wall a hidden, earlier listed body shares: that body would win the tie."""
    one_body = Scene([scene.bodies[int(scene._prepared.lowered.body_item[first["body"]])]])
    times = one_body.crossings(origin, direction).t
    t = float(times[np.argmin(np.abs(times - first["t"]))])
    return one_body.first_hit(origin, direction, math.nextafter(t, -math.inf), math.nextafter(t, math.inf))
