"""Rays that start on a surface: a thousand bounces, and along it."""

import itertools
from collections.abc import Callable
from fractions import Fraction

import numpy as np
import pytest

import conicoid as co

from ..reference.items import Item, combined
from ..reference.judge import holds
from ..reference.quadratics import Table
from ..reference.routes import in_doubt
from ..reference.solids import bodies
from ..reference.trace import Trace, distances

# --- Rays that start on a surface and run along it


@pytest.mark.parametrize("far", [1.0, 1e2, 1e4])
@pytest.mark.parametrize("route", ["alone", "flat", "square", "shuffled"])
def test_along_the_outermost_plane_of_many(route, far):
    """The rounded start is above or below the boxes' common lid, but the lid holds the ray: it runs through all boxes."""
    random = np.random.default_rng(5)
    ends = [(k + 0.25, k + 0.75) for k in range(20)]
    scene = co.Scene([co.Box((a, -1, -1), (b, 0.2, 1)) for a, b in ends])
    count = 4096
    target = np.stack([random.uniform(0.3, 0.7, count), np.full(count, 0.2), random.uniform(-0.5, 0.5, count)], axis=1)
    to = np.stack([random.uniform(-1, 1, count), -random.uniform(0.3, 1, count), random.uniform(-1, 1, count)], axis=1)
    hits = scene.first_hit(target - far * to, to)
    assert (hits.face == hits.face[0]).all()
    assert (hits.body == 0).all()
    height = hits.point[:, 1] - 0.2
    assert height.min() < 0 < height.max()
    along = np.stack([random.uniform(0.5, 2, count), np.zeros(count), random.uniform(-0.01, 0.01, count)], axis=1)
    if route == "alone":
        chosen = np.concatenate([np.argsort(height)[:30], np.argsort(height)[-30:]])
        answers = [(scene.first_hit(ray), scene.crossings(ray)) for ray in (hits.spawn(along)[i] for i in chosen)]
    else:
        order = random.permutation(count) if route == "shuffled" else np.arange(count)
        rays = hits.spawn(along)[order.reshape(64, 64) if route == "square" else order]
        answers, chosen = [(scene.first_hit(rays), scene.crossings(rays))], order
    wall = np.array([x for interval in ends for x in interval][1:])
    expected = (wall - hits.point[chosen, :1]) / along[chosen, :1]
    first = np.concatenate([np.ravel(hit.t) for hit, _ in answers])
    every = np.concatenate([np.ravel(crossing.t) for _, crossing in answers])
    assert np.allclose(first, expected[:, 0], rtol=1e-12)
    assert np.allclose(every.reshape(-1, len(wall)), expected, rtol=1e-12)


def exact(x: float) -> Fraction:
    return Fraction(float(x))


@pytest.mark.parametrize("distance", [1e7, 1.5e11, 1e14])
def test_points_of_a_far_source(distance):
    """The point lies on its surface by fractions, to the rounding of its own coordinates. Spawned rays run in walls."""
    random = np.random.default_rng(7)
    count = 300
    target = np.stack([random.uniform(-0.6, 0.6, count), random.uniform(-0.6, 0.6, count), np.ones(count)], axis=1)
    to = np.stack([*random.uniform(-0.4, 0.4, (2, count)), -random.uniform(0.5, 1, count)], axis=1)
    scenes = {
        "wall": (co.Box((-1, -1, 0), (1, 1, 1)), lambda p: p[2] - 1, 1),
        "ball": (co.Sphere(1.25), lambda p: sum(x * x for x in p) - Fraction(25, 16), 3),
        "cone": (
            co.Cone((0, 0, -2), (0, 0, 3), 2, 0),
            lambda p: p[0] ** 2 + p[1] ** 2 - (exact(0.4) * (3 - p[2])) ** 2,
            6,
        ),
    }
    for name, (shape, value, steepness) in scenes.items():
        scene = co.Scene([shape])
        hits = scene.first_hit(target - distance * to, to)
        same_face = hits.hit & (hits.face == hits.face[hits.hit][0])
        assert same_face.sum() > count / 2
        for point in hits.point[same_face].tolist():
            assert abs(value([exact(x) for x in point])) <= steepness * 2.0**-50, (name, point)
        crossings = scene.crossings(hits.rays)
        for point in crossings.point[crossings.face == hits.face[same_face][0]].tolist():
            assert abs(value([exact(x) for x in point])) <= steepness * 2.0**-50, (name, point)
        first = crossings.offsets[:-1][same_face]
        assert np.array_equal(crossings.point[first], hits.point[same_face])
        if name == "wall":
            assert (hits.point_error[same_face] < 1e-15).all()
            assert scene.first_hit(hits[same_face].spawn((1, 0, 0))).hit.all()


@pytest.mark.parametrize("route", ["shuffled", "square", "alone"])
def test_the_other_side_of_a_far_ball(route):
    """The interval surrounds a reported crossing on every route, because culling allows for a start beside the ball."""
    random = np.random.default_rng(3)
    count, center = 4096, np.array([2.3e9, -1.7e8, 1.9e9])
    scene = co.Scene([co.Spheres(center + random.uniform(-3000, 3000, (6, 3)), random.uniform(2000, 5000, 6))])
    to = random.normal(size=(count, 3))
    hits = scene.first_hit(center - 1e4 * to / np.linalg.norm(to, axis=1, keepdims=True), to)
    hits = hits[hits.hit]
    along = random.normal(size=(hits.size, 3))
    along -= (
        (1 - random.choice([0.01, 0.1, 1.0], (hits.size, 1)))
        * (along * hits.normal).sum(axis=1, keepdims=True)
        * hits.normal
    )
    rays = hits.spawn(along)
    side = int(np.sqrt(hits.size))
    chosen = (
        rays[np.arange(side * side).reshape(side, side)]
        if route == "square"
        else rays[:60]
        if route == "alone"
        else rays
    )
    every = scene.crossings(chosen)
    last = every.offsets[1:] - 1
    some = np.diff(every.offsets) > 0
    t = np.where(some, every.t[np.maximum(last, 0)], 1.0).reshape(chosen.shape)
    some = some.reshape(chosen.shape)
    assert some.mean() > 0.5
    low, high = np.nextafter(t, 0), np.nextafter(t, np.inf)
    if route == "alone":
        found = [scene.first_hit(chosen[i], t_min=low[i], t_max=high[i]).t for i in range(60)]
    else:
        found = scene.first_hit(chosen, t_min=low, t_max=high).t
    assert np.array_equal(np.asarray(found)[some], t[some])


@pytest.mark.parametrize("degrees", [17.3, 30.0, 45.0])
def test_along_a_face_from_its_edge(degrees: float) -> None:
    """An edge that rounding puts at t = 0 is in doubt on all routes, because the ray starts on the face alone."""
    rng = np.random.default_rng(0)
    scene = co.Scene([co.RegularPrism(4, 1.0, (-1.0, 1.0)).rotate((0, 0, 1), degrees).translate((2.0, 0.3, 0.0))])
    around = rng.normal(size=(400, 3)) * (1, 1, 0)
    sides = scene.first_hit((2.0, 0.3, 0.0) + 9.0 * around, -around).point
    sides = np.concatenate([sides, np.nextafter(sides, -9.0), np.nextafter(sides, 9.0)])
    hits = scene.first_hit(sides * (1, 1, 0) + (0, 0, 9.0), (0, 0, -1))
    rays = hits.spawn(rng.normal(size=(1200, 3)) * (1, 1, 0))[hits.hit]
    together = scene.first_hit(rays)
    order = rng.permutation(np.resize(np.arange(rays.size), 9000))
    assert in_doubt(scene, rays).any()
    assert together.t[:300].tolist() == [scene.first_hit(rays[k]).t for k in range(300)]
    assert np.array_equal(scene.first_hit(rays[order]).t, together.t[order])


# --- A thousand bounces: never out, never back at the start, always on the surface, at any scale and place


N, BOUNCES, SOME, EVERY = 40, 1000, 10, 50
Vector = tuple[float, float, float]


def ball(s: float, at: Vector) -> Item:
    return Item("Sphere", {"radius": s, "center": at})


def lens(s: float, at: Vector) -> Item:
    """Return two balls of radius s with centers 1.2 s apart."""
    return combined("Intersection", *(ball(s, (at[0], at[1], at[2] + z * s)) for z in (-0.6, 0.6)))


def carved(s: float, at: Vector) -> Item:
    """Return a box less a ball, with a rod."""

    def near(*x: float) -> Vector:
        return (at[0] + s * x[0], at[1] + s * x[1], at[2] + s * x[2])

    box = Item("Box", {"low": near(-0.5, -0.6, -0.4), "high": near(0.5, 0.6, 0.4)})
    rod = Item("Cylinder", {"start": near(-0.8, 0, 0), "end": near(0.8, 0.1, 0.05), "radius": 0.2 * s})
    return combined("Union", combined("Difference", box, ball(0.35 * s, near(0.5, 0.6, 0.4))), rod)


BODIES: dict[str, Callable[[float, Vector], Item]] = {"ball": ball, "lens": lens, "carved": carved}
SCALES = [1e-9, 1e-6, 1e-3, 1.0, 1e3, 1e6, 1e9]


SAMPLE = ("ball", 1e-9, 0.0), ("lens", 1e9, 1e6), ("carved", 1.0, 1e6)
CONFIGURATIONS = [
    pytest.param(*one, marks=[] if one in SAMPLE else [pytest.mark.deep])
    for one in itertools.product(BODIES, SCALES, (0.0, 1e6))
]


@pytest.mark.parametrize(("name", "scale", "away"), CONFIGURATIONS)
def test_a_thousand_bounces(name: str, scale: float, away: float) -> None:
    at = tuple(float(x) for x in scale * away * np.array([0.48, -0.6, 0.64]))
    item = BODIES[name](scale, at)
    table = Table(bodies([item]))
    scene = co.Scene([item.shape(co)])
    random = np.random.default_rng(7)
    d = random.normal(size=(N, 3))
    target = np.asarray(at) + 0.15 * scale * random.uniform(-1, 1, (N, 3))
    hits = scene.first_hit(target - 5 * scale * d / np.linalg.norm(d, axis=1, keepdims=True), d)
    assert hits.entering.all()
    inward, total = co.refract(hits.rays.directions, hits.normal, 1 / 1.5)
    assert not total.any()
    for step in range(BOUNCES):
        rays, start = hits.spawn(inward), surfaces(table, hits)
        hits = scene.first_hit(rays)
        assert np.isfinite(hits.t).all(), f"{np.isinf(hits.t).sum()} rays escape at bounce {step}"
        assert (hits.t > 0).all(), f"back at the start at bounce {step}"
        assert not hits.entering.any(), f"entered at bounce {step}"
        if step % SOME == 0:
            beside = (distances(table, hits.point, surfaces(table, hits)) / hits.point_error).max()
            assert beside <= 1, f"{beside} bounds beside the surface at bounce {step}"
        if step % EVERY == 0:
            trace_exactly(table, start, hits)
        inward = co.reflect(rays.directions, hits.normal)


def surfaces(table: Table, hits) -> np.ndarray:
    return np.array([table.faces[0][face] for face in hits.face.tolist()])


def trace_exactly(table: Table, start: np.ndarray, hits) -> None:
    found = Trace(table, hits.rays.origins, hits.rays.directions, start).crossings.ahead()
    assert (np.diff(found.offsets) > 0).all()
    first = found.offsets[:-1]
    assert (found.entering[first] == hits.entering).all()
    assert (found.face[first] == hits.face).all()
    for root, t, error in zip(found.roots[first], hits.t.tolist(), hits.t_error.tolist(), strict=True):
        assert holds(root, t, error)
