"""Planes, balls, quadrics, loops and boxes on a ray."""

from __future__ import annotations

import numpy as np

from conicoid._jit.decorators import inline

from . import table as engine
from .case import Case
from .inputs import COUNT, FEW, RAY, directions, exact_rays, rays, records, starting
from .table import ITS_CODE, OWN_BEAM, POLYGON_FIRST, QuadricLimits, Ray, SphereRecord, line_of, on_stack


@inline
def ray_of(x, k):
    """Return the ray of records k to k + 2."""
    at = 4 * k
    return Ray(
        x[at], x[at + 1], x[at + 2], x[at + 4], x[at + 5], x[at + 6], x[at + 3], x[at + 7], np.int64(x[at + 8])
    )  # fmt: skip


def _surfaces(scene, *kinds: int):
    return np.flatnonzero(np.isin(scene.scene._prepared.lowered.tables.surface_kind, kinds))


def rays_and_surface(kinds: tuple[int, ...], some_rays, count: int = COUNT):
    def inputs(scene, rng):
        surface = rng.choice(_surfaces(scene, *kinds), count)
        return records(count, *starting(rng, some_rays(rng, count), surface), surface)

    return inputs


def normalized(world, scratch, x, out):
    out[0], out[1], out[2] = engine.normalize(x[0], x[1], x[2])


def _vectors(scene, rng):
    vectors = directions(rng, FEW) * 10.0 ** rng.uniform(-15, 15, (FEW, 1))
    vectors[:4] = [(0, 0, 0), (1e-25, 0, 0), (0, 1e25, 1e25), (0, 0, -2)]
    return records(FEW, vectors)


@inline
def _put_roots(out, roots):
    low, high, outside, crosses, _ = roots
    out[0], out[1] = outside, crosses
    if crosses:
        out[2], out[3] = low, high


PUT_ROOTS = "put(r.outside); put(r.crosses); if (r.crosses) { put(r.low); put(r.high); }"


def roots_of(world, scratch, x, out):
    _put_roots(out, engine.roots_of(x[0], x[1], x[2], x[1] * x[1] - x[0] * x[2], x[3], False))


def _quadratics(scene, rng):
    """Return quadratics with every sign, and zero in every place."""
    values = rng.normal(size=(COUNT, 4)) * 10.0 ** rng.uniform(-3, 3, (COUNT, 4))
    return records(COUNT, values * (rng.random((COUNT, 4)) > 0.15))


def _short_quadratics(scene, rng):
    """Return a (t - u)(t - v) and b (t - u), with touches."""
    a, u, v = rng.choice([-2, -1, 0, 0, 1, 2], FEW), rng.integers(-3, 4, FEW), rng.integers(-3, 4, FEW)
    b, c = np.where(a == 0, rng.integers(-2, 3, FEW), -a * (u + v) / 2), np.where(a == 0, u, a * u * v)
    return records(FEW, np.column_stack([a, b, c, rng.integers(-2, 3, FEW)]))


def curved_roots(world, scratch, x, out):
    ray = ray_of(x, 0)
    _put_roots(out, engine.curved_roots(world.geometry, np.int64(x[12]), ray, engine.span_inverse(ray)))


def sphere_roots(world, scratch, x, out):
    ray, sphere = ray_of(x, 0), SphereRecord(x[12], x[13], x[14], x[15])
    _put_roots(out, engine.sphere_roots(sphere, line_of(ray), engine.span_inverse(ray), x[9] > 0.5))


def _balls(scene, rng):
    """Return balls of radii from 1e-6 to 1e6, from near and from far; rays graze them and start on them."""
    o, d, start = rays(rng, COUNT)
    size = 10.0 ** rng.uniform(-6, 6, (COUNT, 1))
    center = rng.uniform(-1, 1, (COUNT, 3)) * rng.choice([0, 1, 30], (COUNT, 1)) * size
    radius = size * rng.uniform(0.1, 1, (COUNT, 1))
    starts = np.column_stack([start, rng.random(COUNT) < 0.3])
    return records(
        COUNT, np.column_stack([o[:, :3] * size + center, o[:, 3]]), d, starts, np.column_stack([center, radius])
    )


QUADRIC_GLSL = "Quadric q = load_quadric(integer4(SURFACE, int(given(3).x)).y);"


def quadric_roots(world, scratch, x, out):
    ray, surface = ray_of(x, 0), np.int64(x[12])
    row = engine.integer(world.geometry, engine.SURFACE_ROW, surface)
    quadric, limits = engine.load_quadric(world.geometry, row), QuadricLimits(0.0, 0.0)
    inverse = engine.span_inverse(ray)
    _put_roots(out, engine.quadric_roots(quadric, limits, line_of(ray), inverse, surface == ray.start))


def quadric_gradient(world, scratch, x, out):
    quadric = engine.load_quadric(world.geometry, engine.integer(world.geometry, engine.SURFACE_ROW, np.int64(x[4])))
    out[0], out[1], out[2] = engine.quadric_gradient(quadric, x[0], x[1], x[2])


def _points_and_surface(*kinds: int):
    def inputs(scene, rng):
        return records(COUNT, rng.normal(size=(COUNT, 3)), rng.choice(_surfaces(scene, *kinds), COUNT))

    return inputs


def normal_at(world, scratch, x, out):
    side = np.int64(x[3])
    out[0], out[1], out[2] = engine.normal_at(world.geometry, np.int64(x[4]), side, x[0], x[1], x[2])


def _points_of_normals(scene, rng):
    """Return points, among them a surface's own anchor, where the gradient of a cone vanishes."""
    surface = rng.choice(_surfaces(scene, 0, 1, 2), FEW)
    return records(FEW, np.column_stack([rng.normal(size=(FEW, 3)), rng.choice([-1, 1], FEW)]), surface)


def _apexes(scene, rng):
    """Return the middle of the cone about the origin, and points of faces."""
    surface = rng.choice(_surfaces(scene, 0, 2), FEW)
    point = rng.choice([0.0, 0.0, 1.0], (FEW, 3)) * (rng.random((FEW, 1)) < 0.5)
    return records(FEW, np.column_stack([point, rng.choice([-1, 1], FEW)]), surface)


def plane_crossing(world, scratch, x, out):
    ray = ray_of(x, 0)
    t, rate, _ = engine.plane_crossing(world.geometry, np.int64(x[12]), ray, engine.span_inverse(ray))
    out[0], out[1] = rate == 0.0, rate
    if rate != 0.0:
        out[2] = t


PLANE_GLSL = """vec2 c = plane_crossing(int(given(3).x), given_ray(0));
put(c.y == 0.0); put(c.y); put(c.y == 0.0 ? 0.0 : c.x);"""


def plane_values(world, scratch, x, out):
    ray = ray_of(x, 0)
    out[0], out[1], _ = engine.plane_values(world.geometry, np.int64(x[12]), ray, engine.span_inverse(ray))


def is_curved(world, scratch, x, out):
    out[0] = engine.is_curved(world.geometry, np.int64(x[0]))


def _all_surfaces(scene, rng):
    surfaces = _surfaces(scene, 0, 1, 2)
    return records(len(surfaces), surfaces)


def seen_along(world, scratch, x, out):
    u, v, _, _ = engine.project_vertex(np.int64(x[15]), x[12], x[13], x[14], ray_of(x, 0))
    out[0], out[1] = u, v


def _vertices(scene, rng):
    some_rays = rays(rng, COUNT)
    axis = np.abs(some_rays[1][:, :3]).argmax(axis=1)
    return records(COUNT, *some_rays, np.column_stack([rng.normal(size=(COUNT, 3)), axis]))


def inside_loop(world, scratch, x, out):
    polygon = np.int64(x[12])
    first = engine.integer(world.geometry, POLYGON_FIRST, polygon)
    last = engine.integer(world.geometry, POLYGON_FIRST, polygon + 1)
    inside, _ = engine.inside_loop(world.geometry, first, last, ray_of(x, 0))
    out[0] = inside


def _loops(some_rays):
    def inputs(scene, rng):
        return records(
            COUNT,
            *some_rays(rng, COUNT),
            rng.integers(0, len(scene.scene._prepared.lowered.tables.polygon_surface), COUNT),
        )

    return inputs


def push_node(world, scratch, x, out):
    """Put the children that the ray meets, as bits: in their boxes, and in boxes wider than the page makes them."""
    ray = ray_of(x, 0)
    for k in range(2):
        geometry = world.geometry if k == 0 else world.wide
        engine.put_beam(scratch.way, OWN_BEAM, ray)
        for j in range(engine.push_node(geometry, scratch.way, np.int64(x[12]), scratch.way, engine.OWN_BEAM, 0)):
            code = np.int64(scratch.way[on_stack(j) + ITS_CODE])
            for i in range(8):
                if engine.integer(geometry, engine.NODE_CHILDREN, 8 * np.int64(x[12]) + i) == code:
                    out[k] += 1 << i


PUSH_GLSL = """Ray ray = given_ray(0);
int node = int(given(3).x), bits = 0;
bool sorted = true;
stack_top = 0;
push_node(node, ray, reciprocal(ray.d), ray.t_min, ray.t_max);
for (int k = 0; k < stack_top; k++) {
    sorted = sorted && (k == 0 || stack_t[k - 1] >= stack_t[k]);
    for (int i = 0; i < 8; i++) if (integer4(CHILDREN, 2 * node + i / 4)[i % 4] == stack_code[k]) bits |= 1 << i;
}
put(bits); put(sorted);"""


def _between(expected, found):
    """Check that all of the former are pushed, none outside of the latter, and the nearest on top."""
    least, most, bits = expected[:, 0].astype(int), expected[:, 1].astype(int), found[:, 0].astype(int)
    return (least & ~bits == 0) & (bits & ~most == 0) & (found[:, 1] == 1)


def _nodes(some_rays):
    def inputs(scene, rng):
        nodes, (o, d, start) = len(scene.scene._prepared.lowered.tables.node_children), some_rays(rng, COUNT)
        d[:, 3] = np.minimum(d[:, 3], 1e4)  # t of a box without end beside a parallel ray is not a real number
        return records(COUNT, o, d, start, rng.integers(0, nodes, COUNT))

    return inputs


def leaf_range(world, scratch, x, out):
    out[0], out[1] = engine.leaf_range(np.int64(x[0]))


def _leaves(scene, rng):
    first, count = rng.integers(0, 1 << 18, FEW), rng.integers(0, 16, FEW)
    return records(FEW, -(first << 4 | count) - 1)


CASES = {
    "normalized": Case("put(normalized(given(0).xyz));", normalized, 3, _vectors, ("vvv-",)),
    "roots_of": Case(
        "vec4 g = given(0); Roots r = roots_of(g.x, g.y, g.z, g.y * g.y - g.x * g.z, g.w);" + PUT_ROOTS,
        roots_of, 4, _quadratics, ("ssss",), whole=2, exact_inputs=_short_quadratics,
    ),
    "sphere_roots": Case(
        "Ray ray = given_ray(0); Roots r = sphere_roots(given(3), ray, 1.0 / dot(ray.d, ray.d), given(2).y > 0.5);" + PUT_ROOTS,
        sphere_roots, 4, _balls, (*RAY, "vvvs"), whole=2,
    ),
    "quadric_roots": Case(
        f"Ray ray = given_ray(0); {QUADRIC_GLSL} Roots r = quadric_roots(q, ray, 1.0 / dot(ray.d, ray.d), ray.start == int(given(3).x)); {PUT_ROOTS}",
        quadric_roots, 4, rays_and_surface((2,), rays), (*RAY, "----"), whole=2,
        exact_inputs=rays_and_surface((2,), exact_rays),
    ),
    "curved_roots": Case(
        f"Ray ray = given_ray(0); Roots r = curved_roots(int(given(3).x), ray, 1.0 / dot(ray.d, ray.d)); {PUT_ROOTS}",
        curved_roots, 4, rays_and_surface((1, 2), rays), (*RAY, "----"), whole=2,
        exact_inputs=rays_and_surface((1, 2), exact_rays),
    ),
    "quadric_gradient": Case(
        QUADRIC_GLSL.replace("given(3)", "given(1)") + "put(quadric_gradient(q, given(0).xyz));",
        quadric_gradient, 3, _points_and_surface(2), ("vvv-", "----"),
    ),
    "normal_at": Case(
        "put(normal_at(int(given(1).x), int(given(0).w), given(0).xyz));",
        normal_at, 3, _points_of_normals, ("vvv-", "----"), exact_inputs=_apexes,
    ),
    "plane_values": Case(
        "put(plane_values(int(given(3).x), given_ray(0)));", plane_values, 2, rays_and_surface((0,), rays), (*RAY, "----"),
        exact_inputs=rays_and_surface((0,), exact_rays),
    ),
    "plane_crossing": Case(
        PLANE_GLSL, plane_crossing, 3, rays_and_surface((0,), rays), (*RAY, "----"), whole=1,
        exact_inputs=rays_and_surface((0,), exact_rays),
    ),
    "is_curved": Case("put(is_curved(int(given(0).x)));", is_curved, 1, _all_surfaces, ("----",), whole=1, exact_inputs=_all_surfaces),
    "seen_along": Case("put(seen_along(int(given(3).w), given(3).xyz, given_ray(0)));", seen_along, 2, _vertices, (*RAY, "vvv-")),
    "inside_loop": Case(
        "ivec4 p = integer4(POLYGONS, int(given(3).x)); put(inside_loop(p.z, p.w, given_ray(0)));",
        inside_loop, 1, _loops(rays), (*RAY, "----"), whole=1, exact_inputs=_loops(exact_rays),
    ),
    "push_node": Case(PUSH_GLSL, push_node, 2, _nodes(rays), agrees=_between, exact_inputs=_nodes(exact_rays)),
    "leaf_range": Case("put(leaf_range(int(given(0).x)));", leaf_range, 2, _leaves, ("----",), whole=2),
}  # fmt: skip
