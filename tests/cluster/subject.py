"""A scene and rays that take every route, with all their queries."""

import numpy as np

import conicoid as co

VALUES = [[1.0, 2.0], [0.5, 0.25], [3.0, 1.0], [0.125, 7.0]]


def scene():
    """Return four bodies that overlap. The first rays of `rays` only touch the ball."""
    return co.Scene([
        co.Body(co.Sphere(1), name="ball", material=co.matte("red")),
        co.Body(co.Box() - co.Sphere(1.2), name="corners"),
        co.Cylinder((0, 0, -2), (0, 0, 2), 0.3),
        co.Sphere(0.5, (1.1, 0, 0)),
    ])  # fmt: skip


def large_scene(count=5000):
    """Return a scene whose recipe has more bytes than travel with each task."""
    rng = np.random.default_rng(3)
    return co.Scene([co.Spheres(rng.normal(size=(count, 3)), 0.02)])


def rays(*shape):
    rng = np.random.default_rng(len(shape))
    origins = 4 * rng.normal(size=(*shape, 3))
    directions = 0.3 * rng.normal(size=origins.shape) - origins
    flat = origins.reshape(-1, 3), directions.reshape(-1, 3)
    flat[0][:3], flat[1][:3] = (1, 0, 5), (0, 0, -1)
    return co.Rays(origins, directions)


def answers(scene, rays, **options):
    """Return the answers of every query of rays and points, by name."""
    ends = np.linspace(3, 9, rays.size).reshape(rays.shape)
    points = np.clip(rays.origins, -1, 1)
    some = points.reshape(-1, 3)[:60]
    at, nearest = scene.bodies_at(some, **options), scene.distance(some, exact=True, **options)
    voxels = scene.voxels(((-1, -1, -1), (1, 1, 1)), (4, 5, 6), fractions="body", **options)
    return {
        "first_hit": scene.first_hit(rays, **options),
        "first_hit to ends": scene.first_hit(rays, None, -1, ends, **options),
        "occluded": scene.occluded(rays, None, 0, ends, **options),
        "spans": scene.spans(rays, **options),
        "crossings": scene.crossings(rays, None, 0, ends, **options),
        "lengths": scene.lengths(rays, by="material", **options),
        "line_integral": scene.line_integral(VALUES, rays, **options),
        "contains": scene.contains(points, **options),
        "body_at": scene.body_at(points, **options),
        "bodies_at": at.body,
        "bodies_at, counts": at.counts,
        "distance": np.column_stack([nearest.distance, nearest.lower, nearest.error, nearest.point, nearest.surface]),
        "fractions": np.stack([voxels.fractions, voxels.bounds]),
    }


def same(one, other):
    """Return whether two answers are equal to the bit in all fields."""
    if isinstance(one, np.ndarray | np.generic):
        return one.shape == other.shape and one.dtype == other.dtype and np.array_equal(one, other)
    return one == other and one.rays == other.rays


def differences(local, far):
    """Return the names of the answers that differ."""
    return [name for name in local if not same(local[name], far[name])]
