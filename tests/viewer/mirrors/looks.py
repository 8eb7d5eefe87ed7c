"""Cameras, maps, materials, media, lights and reflectances."""

from __future__ import annotations

import numpy as np

from . import table as engine
from .case import Case
from .cells import tables_of
from .inputs import COUNT, FEW, directions, records
from .worlds import LENS

SIZE = (640, 480)
_DEEPER = 2.0**-13 - 2.0**-20
"""The depth below a surface at which the shader reads patterns in space, as a share of a cube's side."""


def _materials(scene):
    return scene.python.look.materials


def normalized_columns(v):
    return np.float32(v / np.linalg.norm(v, axis=1, keepdims=True)).astype(float)


def camera_ray(world, scratch, x, out):
    out[0], out[1], out[2], out[3], out[4], out[5] = engine.camera_ray(world.lens, x[0], x[1], SIZE[0], SIZE[1])


def turns(world, scratch, x, out):
    out[0] = engine.turns(x[0], x[1])


def _angles(scene, rng):
    points = rng.normal(size=(FEW, 2)) * (rng.random((FEW, 2)) > 0.1)
    return records(FEW, points)


def _faces(scene, rng):
    """Return (body, face, surface), a face of each body; the surface is the ball's where the body is one of many."""
    tables = tables_of(scene)
    body = rng.integers(0, len(tables.body_face), COUNT)
    firsts = np.append(np.unique(tables.body_face[tables.body_face >= 0]), len(tables.face_maps))
    first = tables.body_face[body]
    count = np.where(first >= 0, firsts[np.minimum(np.searchsorted(firsts, first) + 1, len(firsts) - 1)] - first, 1)
    face = rng.integers(0, 1 << 30, COUNT) % np.maximum(count, 1)
    return np.column_stack([body, face, np.where(first < 0, tables.entry_index[body], 0)])


def _points_of_faces(scene, rng):
    return records(COUNT, rng.normal(size=(COUNT, 3)), _faces(scene, rng), directions(rng, COUNT))


def _points_of_patterns(scene, rng):
    """Return points, half of them on the side of a cube of the pattern, with the normal along one of its edges."""
    points, materials = _points_of_faces(scene, rng), _materials(scene)
    scales = materials.rows["scale"][materials.row_of[points[:, 1, 0].astype(int)]]
    axis, rows = rng.integers(0, 3, COUNT), np.arange(COUNT)
    on_side = (rng.random(COUNT) < 0.5) & (scales[rows, axis] > 0)
    cubes = rng.integers(-4, 5, COUNT) * scales[rows, axis]
    points[on_side, 0, axis[on_side]] = cubes[on_side]
    points[on_side, 2, :3] = (np.eye(3)[axis] * rng.choice([-1, 1], (COUNT, 1)))[on_side]
    return points


def uv_at(world, scratch, x, out):
    body, face, surface = np.int64(x[4]), np.int64(x[5]), np.int64(x[6])
    out[0], out[1] = engine.uv_at(world.geometry, body, face, surface, x[0], x[1], x[2])


def material_row(world, scratch, x, out):
    out[0] = engine.material_row(world.geometry, world.look.materials, np.int64(x[4]), np.int64(x[5]))


def surface_color(world, scratch, x, out):
    body, face, surface, materials = np.int64(x[4]), np.int64(x[5]), np.int64(x[6]), world.look.materials
    row = materials.rows[engine.material_row(world.geometry, materials, body, face)]
    deeper = _DEEPER if row.pattern == engine.CHECKER_SPACE else 0.0
    px, py, pz = (
        x[0] - deeper * row.scale[0] * x[8],
        x[1] - deeper * row.scale[1] * x[9],
        x[2] - deeper * row.scale[2] * x[10],
    )
    sight = engine.SurfaceInteraction(0.0, body, surface, face, 1, -1, -1, px, py, pz, x[8], x[9], x[10])
    out[0], out[1], out[2] = engine.surface_color(world.geometry, materials, sight)


def is_even(world, scratch, x, out):
    out[0] = engine.is_even(x[0], x[1], x[2])


def _places(scene, rng):
    return records(FEW, rng.normal(size=(FEW, 3)) * 5)


def _corners(scene, rng):
    return records(FEW, rng.integers(-8, 8, (FEW, 3)) / 2)


def medium_of(world, scratch, x, out):
    out[0] = engine.body_medium(world.look.materials, np.int64(x[0]))


def _bodies(scene, rng):
    return records(FEW, rng.integers(-1, len(_materials(scene).row_of), FEW))


def index_of(world, scratch, x, out):
    out[0] = engine.medium_index(world.look.materials, np.int64(x[0]))


def _media(scene, rng):
    return records(FEW, rng.integers(-1, len(_materials(scene).rows), FEW))


def unseen(world, scratch, x, out):
    out[0] = engine.is_invisible_wall(world.look.materials, np.int64(x[0]), np.int64(x[1]), np.int64(x[2]))


def _walls(scene, rng):
    """Return any body between any two media."""
    rows = len(_materials(scene).rows)
    return records(
        COUNT,
        np.column_stack([rng.integers(0, len(_materials(scene).row_of), COUNT), rng.integers(-1, rows, (COUNT, 2))]),
    )


def absorbed(world, scratch, x, out):
    out[0], out[1], out[2] = engine.absorb(world.look.materials, np.int64(x[4]), x[5], x[0], x[1], x[2])


def _ways(scene, rng):
    """Return short and long ways, none, and one without end."""
    length = rng.choice([0.0, -1.0, 0.3, 2.0, 1e30], FEW) * rng.uniform(0.5, 1, FEW)
    return records(
        FEW, rng.random((FEW, 3)), np.column_stack([rng.integers(-1, len(_materials(scene).rows), FEW), length])
    )


def background_color(world, scratch, x, out):
    out[0], out[1], out[2] = engine.background_color(world.look.background, x[0])


def _heights(scene, rng):
    return records(FEW, rng.choice([-1.0, 0.0, 1.0, 2.0, 3.0], FEW) * rng.uniform(-1, 1, FEW))


def dielectric(world, scratch, x, out):
    out[0] = engine.dielectric_fresnel(x[0], x[1], x[2])


def _cosines(scene, rng):
    cosines = rng.random((FEW, 2)) * (rng.random((FEW, 2)) > 0.1)
    cosines[:, 1] = np.where(rng.random(FEW) < 0.1, -1, cosines[:, 1])
    return records(FEW, np.column_stack([cosines, rng.uniform(0.4, 2.5, FEW)]))


def opaque_reflectance(world, scratch, x, out):
    out[0], out[1], out[2] = engine.opaque_reflectance(world.look.materials.rows[np.int64(x[0])], x[1])


def _rows_and_cosines(scene, rng):
    return records(FEW, np.column_stack([rng.integers(0, len(_materials(scene).rows), FEW), rng.random(FEW)]))


def refract(world, scratch, x, out):
    tx, ty, tz, cosine = engine.refract(x[0], x[1], x[2], x[4], x[5], x[6], x[3])
    out[0], out[1], out[2], out[3], out[4] = cosine < 0.0, tx, ty, tz, cosine


def _arriving(scene, rng):
    """Return directions against a normal, from grazing to straight, into denser and rarer media."""
    d, n = directions(rng, COUNT), directions(rng, COUNT)
    d = np.where((d * n).sum(axis=1, keepdims=True) > 0, -d, d)
    return records(COUNT, np.column_stack([d, rng.choice([0.5, 2 / 3, 1, 1.25, 2], COUNT)]), n)


def wall_reflectance(world, scratch, x, out):
    out[0] = engine.wall_reflectance(x[0], x[1], x[2])


def _wall_angles(scene, rng):
    return records(FEW, np.column_stack([rng.random(FEW) * 1.02, rng.choice([1.0, 1.25, 1.5], (FEW, 2))]))


def towards(world, scratch, x, out):
    out[0], out[1], out[2], out[3] = engine.light_direction(world.look.lights[np.int64(x[3])], x[0], x[1], x[2])


def share(world, scratch, x, out):
    out[0] = engine.light_share(world.look.lights[np.int64(x[3])], x[0], x[1], x[2], x[4])


def highlight(world, scratch, x, out):
    row = world.look.materials.rows[np.int64(x[3])]
    point = engine.ShadingPoint(0.0, 0.0, 0.0, x[8], x[9], x[10], x[4], x[5], x[6])
    out[0] = engine.highlight(row, x[0], x[1], x[2], point)


def light_at(world, scratch, x, out):
    light, row = world.look.lights[np.int64(x[3])], world.look.materials.rows[np.int64(x[7])]
    point = engine.ShadingPoint(x[0], x[1], x[2], x[4], x[5], x[6], x[8], x[9], x[10])
    lx, ly, lz, end, cosine, shine, part = engine.evaluate_light(light, row, point)
    out[0], out[1], out[2], out[3], out[4] = part > 0.0, lx, ly, lz, end
    if part > 0.0:
        out[5], out[6], out[7] = cosine, shine, part


def _lit(scene, rng):
    """Return (point, light), (normal, material), direction to the eye; half of the points near the axis of a light."""
    lights, materials = scene.python.look.lights, _materials(scene)
    light = rng.integers(0, len(lights), COUNT)
    near = (
        lights["position"][light]
        + rng.uniform(0.5, 6, (COUNT, 1)) * lights["axis"][light]
        + rng.normal(size=(COUNT, 3))
    )
    point = np.where(rng.random((COUNT, 1)) < 0.5, near, rng.normal(size=(COUNT, 3)) * 2)
    to_light = normalized_columns(
        np.where(lights["parallel"][light][:, None] == 1, -lights["axis"][light], lights["position"][light] - point)
    )
    normal = normalized_columns(to_light + directions(rng, COUNT) * rng.choice([0.0, 0.3, 2.0], (COUNT, 1)))
    mirrored = 2 * (to_light * normal).sum(axis=1, keepdims=True) * normal - to_light
    eye = normalized_columns(mirrored + directions(rng, COUNT) * rng.choice([0.05, 0.3, 2.0], (COUNT, 1)))
    row = rng.integers(0, len(materials.rows), COUNT)
    return point, light, normal, row, eye, to_light


def _light_and_point(scene, rng):
    point, light, normal, row, eye, _ = _lit(scene, rng)
    return records(COUNT, np.column_stack([point, light]), np.column_stack([normal, row]), eye)


def _light_and_direction(scene, rng):
    _, light, _, _, _, to_light = _lit(scene, rng)
    return records(COUNT, np.column_stack([to_light, light]), rng.uniform(0.5, 9, COUNT))


def _material_and_directions(scene, rng):
    _, _, normal, row, eye, to_light = _lit(scene, rng)
    return records(COUNT, np.column_stack([to_light, row]), eye, normal)


def push(world, scratch, x, out):
    """Put how many rays wait after a push of two, and the weight of the last."""
    one = engine.PendingRay(0.0, 0.0, 0.0, 0.0, 0.0, 1.0, x[0], x[1], x[2], 5, 1, 2)
    other = engine.PendingRay(0.0, 0.0, 0.0, 0.0, 0.0, 1.0, x[4], x[5], x[6], 5, 1, 2)
    size = engine.push(world.stack, engine.push(world.stack, 0, one), other)
    out[0] = size
    if size > 0:
        out[1], out[2], out[3] = (
            world.stack.floats[size - 1, 6],
            world.stack.floats[size - 1, 7],
            world.stack.floats[size - 1, 8],
        )


PUSH_GLSL = """ray_count = 0;
for (int k = 0; k < 2; k++) push(Pending(vec3(0.0), vec3(0.0, 0.0, 1.0), given(k).xyz, 5, 1, 2));
put(ray_count);
if (ray_count > 0) put(rays[ray_count - 1].weight);"""


def _weights(scene, rng):
    """Return weights about the smallest that the integrator follows, and it."""
    weights = 2.0**-12 * rng.choice([0.0, 0.5, 1.0, 1.5], (FEW, 8))
    return records(FEW, weights[:, :3], weights[:, 4:7])


CASES = {
    "camera_ray": Case(
        f"Ray r = camera_ray(vec2(given(0).x, {SIZE[1]}.0 - given(0).y)); put(r.o); put(r.d);", camera_ray, 6, lambda scene, rng: records(FEW, rng.uniform(0, 1, (FEW, 2)) * SIZE), ("ss--",),
        view={"lens": LENS.tolist(), "size": SIZE, "section": None},
    ),
    "turns": Case("put(turns(given(0).x, given(0).y));", turns, 1, _angles, ("ss--",), exact_inputs=lambda scene, rng: records(FEW, rng.integers(-1, 2, (FEW, 2)))),
    "uv_at": Case(
        "put(uv_at(int(given(1).x), int(given(1).y), int(given(1).z), given(0).xyz));",
        uv_at, 2, _points_of_faces, ("vvv-", "----", "----"),
    ),
    "material_row": Case("put(material_row(int(given(1).x), int(given(1).y)));", material_row, 1, _points_of_faces, ("----",) * 3, whole=1),
    "surface_color": Case(
        """int body = int(given(1).x), face = int(given(1).y);
Material m = load_material(material_row(body, face));
put(surface_color(m, body, face, int(given(1).z), given(0).xyz, given(2).xyz));""",
        surface_color, 3, _points_of_patterns, ("vvv-", "----", "vvv-"),
    ),
    "is_even": Case("put(is_even(given(0).xyz));", is_even, 1, _places, ("sss-",), whole=1, exact_inputs=_corners),
    "medium_of": Case("put(medium_of(int(given(0).x)));", medium_of, 1, _bodies, ("----",), whole=1),
    "index_of": Case("put(index_of(int(given(0).x)));", index_of, 1, _media, ("----",)),
    "unseen": Case("ivec3 g = ivec3(given(0).xyz); put(unseen(g.x, g.y, g.z));", unseen, 1, _walls, ("----",), whole=1),
    "absorbed": Case("put(absorbed(int(given(1).x), given(1).y, given(0).xyz));", absorbed, 3, _ways, ("sss-", "-s--")),
    "background_color": Case("put(background_color(given(0).x));", background_color, 3, _heights, ("s---",)),
    "dielectric": Case("put(dielectric(given(0).x, given(0).y, given(0).z));", dielectric, 1, _cosines, ("s-s-",)),
    "opaque_reflectance": Case(
        "put(opaque_reflectance(load_material(int(given(0).x)), given(0).y));", opaque_reflectance, 3, _rows_and_cosines, ("-s--",)
    ),
    "refracted": Case(
        "vec4 r = refracted(given(0).xyz, given(1).xyz, given(0).w); put(r.w < 0.0); put(r);", refract, 5, _arriving, ("vvvs", "vvv-"), whole=1
    ),
    "wall_reflectance": Case("put(wall_reflectance(given(0).x, given(0).y, given(0).z));", wall_reflectance, 1, _wall_angles, ("sss-",)),
    "towards": Case("put(towards(load_light(int(given(0).w)), given(0).xyz));", towards, 4, _light_and_point, ("vvv-", "----", "----")),
    "share": Case("put(share(load_light(int(given(0).w)), given(0).xyz, given(1).x));", share, 1, _light_and_direction, ("vvv-", "s---")),
    "highlight": Case(
        "put(highlight(load_material(int(given(0).w)), given(0).xyz, given(1).xyz, given(2).xyz));",
        highlight, 1, _material_and_directions, ("vvv-", "vvv-", "vvv-"),
    ),
    "light_at": Case(
        """Arrival a = light_at(load_light(int(given(0).w)), load_material(int(given(1).w)), given(0).xyz, given(1).xyz, given(2).xyz);
put(a.share > 0.0); put(a.l); put(a.end);
if (a.share > 0.0) { put(a.cosine); put(a.shine); put(a.share); }""",
        light_at, 8, _light_and_point, ("vvv-", "vvv-", "vvv-"), whole=1,
    ),
    "push": Case(PUSH_GLSL, push, 4, _weights, ("----", "----"), whole=1),
}  # fmt: skip
