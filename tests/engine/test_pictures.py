"""Pictures: crowds of small bodies, samples of a square, scan lines, to the bit of single rays."""

import functools
from fractions import Fraction

import numba
import numpy as np
import pytest

import conicoid as co
from conicoid.kernels.bvh.culling import lanes_in_ball, lanes_in_ball_from_one
from conicoid.kernels.packet.lanes import SIZE, close_lanes, put_ray
from conicoid.kernels.ray import Ray
from conicoid.queries import ray_queries as queries
from conicoid.queries.ray_queries import row_length
from conicoid.render import sampling

from ..compiled import compiled
from ..samples import many
from .test_routes import assert_same, camera, crowded_scene, reordered

# --- Packets with many small bodies before them meet these in pairs, other packets side by side: to the same bits


WIDTH = 128


@functools.cache
def field():
    """Return pipes on a square, one in a hundred closed by a ball, and a slab below all, prepared once."""
    solids = []
    for i in range(56):
        for j in range(56):
            foot, head = (i, j, 0.0), (i, j, 1.0 + 0.1 * ((3 * i + 5 * j) % 7))
            solid = co.Cylinder(foot, head, 0.4) - co.Cylinder((i, j, -0.1), (i, j, 2.0), 0.3)
            solids.append(solid | co.Sphere(0.35, (i, j, 1.2)) if (i + 56 * j) % 100 == 7 else solid)
    return co.Scene([*solids, co.Box((-1, -1, -1), (56, 56, -0.5)) - co.Sphere(2, (28, 28, -0.5))])


VIEWS = {
    "near": ((20, 20, 4.5), (20.2, 20.1, 0), 60),
    "far": ((27.5, 27.5, 125), (27.7, 27.6, 0), 24),
    "both": ((20.3, -1.5, 2.2), (20, 9, 0), 70),
}


def rays_of(view):
    origin, target, angle = VIEWS[view]
    up = (0, 1, 0) if view != "both" else (0, 0, 1)
    return co.Camera(origin, target, up=up, field_of_view=angle).rays(WIDTH, WIDTH)


@pytest.mark.parametrize("view", VIEWS)
def test_queries_agree_to_the_bit_in_any_order(view):
    scene, rays = field(), rays_of(view)
    hits, order = scene.first_hit(rays), np.random.default_rng(1).permutation(WIDTH * WIDTH)
    assert_same(hits, scene.first_hit(reordered(rays, order)), order)
    some = order[:60]
    assert_same(hits, scene.first_hit(reordered(rays, some)), some)
    assert np.array_equal(scene.occluded(rays), hits.hit)


# --- Packets of one square share the nodes that they see, and a common origin saves work: no hit is lost


sample_in_pixel = compiled(sampling.sample_in_pixel)


@numba.njit
def put_rays(lanes, origins, directions):
    for i in range(64):
        o, d = origins[i], directions[i]
        put_ray(lanes, i, Ray(o[0], o[1], o[2], d[0], d[1], d[2], 0.0, np.inf, np.int64(-1)))
    close_lanes(lanes, 64)


@numba.njit
def lanes_at(lanes, origins, directions, ball):
    put_rays(lanes, origins, directions)
    one = lanes_in_ball_from_one(lanes, ball[0], ball[1], ball[2], ball[3])
    return one, lanes_in_ball(lanes, ball[0], ball[1], ball[2], ball[3])


def is_met(origin, direction, ball):
    """Return, in fractions, whether |o + t d - c|² = r² has a root t >= 0, or the ray starts inside."""
    o, d, c = ([Fraction(x) for x in row] for row in (origin, direction, ball[:3]))
    r, p = Fraction(ball[3]), [a - b for a, b in zip(o, c, strict=True)]
    a, b, k = sum(x * x for x in d), sum(x * y for x, y in zip(p, d, strict=True)), sum(x * x for x in p) - r * r
    return k <= 0 or (b < 0 and b * b >= a * k)


@pytest.mark.parametrize("far", [1.0, 1e3, 1e7])
def test_rays_of_one_origin_hit_balls_that_they_graze(far):
    """The radius of each ball is the distance of one of the rays, but for some last digits."""
    rng, hits, left_out, count = np.random.default_rng(8), 0, 0, many(40, 150)
    for _ in range(count):
        origin = rng.uniform(-1, 1, 3) * far
        way = rng.normal(size=3)
        directions = (way / np.linalg.norm(way) + rng.uniform(-0.05, 0.05, (64, 3))) * rng.uniform(0.5, 2, (64, 1))
        middle = origin + directions[5] * rng.uniform(0.5, 2) * far + rng.normal(size=3) * 0.02 * far
        apart = np.linalg.norm(np.cross(middle - origin, directions[5])) / np.linalg.norm(directions[5])
        ball = [*middle.tolist(), float(apart * (1 + rng.choice([0, 1e-15, -1e-15, 1e-9])))]
        one, other = lanes_at(np.empty(SIZE), np.broadcast_to(origin, (64, 3)), directions, np.array(ball))
        lanes = [is_met(origin.tolist(), d, ball) for d in directions.tolist()]
        assert all(one >> i & 1 for i in range(64) if lanes[i])
        hits += sum(lanes)
        left_out += sum(1 for i in range(64) if not one >> i & 1)
        assert abs((one & (2**64 - 1)).bit_count() - (other & (2**64 - 1)).bit_count()) <= 2
    assert hits > 3 * count
    assert left_out > 6 * count


def scene_of(kind):
    rng = np.random.default_rng(3)
    if kind == "balls":
        return co.Scene([co.Spheres(rng.uniform(-1, 1, (2000, 3)), rng.uniform(0.01, 0.06, 2000))])
    shapes = [
        co.Box(low, low + 0.08) if k % 2 else co.Cylinder(low, low + (0.1, 0.05, 0.02), 0.03)
        for k, low in enumerate(rng.uniform(-1, 1, (300, 3)))
    ]
    return co.Scene([*shapes, co.Box((-2, -2, 1), (2, 2, 1.1)) - co.Sphere(0.5, (0, 0, 1))])


@pytest.mark.parametrize("bodies", ["balls", "others"])
def test_samples_of_a_picture_hit_as_single_rays_do(bodies):
    """The normals in a picture by a pinhole are the means of the normals at first hits of the same rays."""
    width, height, count, seed, eye, scene = 64, 48, 9, 3, (0.1, 0.2, -3.0), scene_of(bodies)
    camera = co.Camera(eye, (0.1, 0.2, 1), up=(0, 1, 0), field_of_view=40)
    pixels = scene.render(width, height, count, integrator="normals", seed=seed, camera=camera).pixels
    x, y = (part.ravel() for part in np.meshgrid(np.arange(width), np.arange(height)))
    places = np.array([[sample_in_pixel(seed, pixel, k, count) for k in range(count)] for pixel in range(len(x))])
    middles = camera.rays(width, height).directions
    middles = middles / middles[..., 2:]  # on a plane across the view, where pixels are equally wide
    right, down = middles[0, 1] - middles[0, 0], middles[1, 0] - middles[0, 0]
    steps = [axis[:, None] + places[..., k] - 0.5 for k, axis in enumerate((x, y))]
    hits = scene.first_hit(eye, middles[0, 0] + steps[0][..., None] * right + steps[1][..., None] * down)
    expected = np.where(np.isnan(hits.normal), 0, 0.5 + 0.5 * hits.normal).mean(axis=1)
    assert np.abs(pixels.reshape(-1, 3) - expected).max() < 1e-6
    assert 0.5 < np.isfinite(hits.t).mean() < 1


# --- The rows of a picture in a flat list of rays; a list without rows, or a wrong guess, changes no hit


@pytest.fixture(scope="module")
def scene():
    return crowded_scene()


def perspective(width, height):
    return co.Camera((0.1, -0.2, -4), (0, 0, 0), up=(0, 1, 0), field_of_view=42).rays(width, height)


def flat(rays, order=None):
    origins, directions = (part.reshape(-1, 3) for part in rays)
    return co.Rays(origins, directions) if order is None else co.Rays(origins[order], directions[order])


@pytest.mark.parametrize(("width", "height"), [(128, 128), (131, 127), (33, 500), (300, 60)])
def test_rows_of_a_camera_are_found(width, height):
    assert row_length(flat(perspective(width, height))) == width


@pytest.mark.parametrize(("width", "height"), [(150, 140), (2048, 8)])
def test_rows_of_parallel_rays_are_found_in_their_origins(width, height):
    y, x = np.meshgrid(np.arange(height), np.arange(width), indexing="ij")
    origins = np.stack([x, y, np.full_like(x, 5)], axis=-1).reshape(-1, 3)
    assert row_length(co.Rays(origins, (0, 0, -1))) == width


def test_rows_of_rays_that_are_not_in_the_middle_of_their_pixels_are_found():
    r = np.random.default_rng(0)
    y, x = np.meshgrid(np.arange(160), np.arange(200), indexing="ij")
    places = np.stack([x, y], axis=-1) + r.uniform(-0.5, 0.5, (160, 200, 2))
    directions = np.concatenate([places / 100 - 1, np.ones((160, 200, 1))], axis=-1).reshape(-1, 3)
    assert row_length(co.Rays((0, 0, 0), directions)) == 200


def serpentine(rays):
    """Return the rays with every second row from right to left."""
    order = np.arange(rays.shape[0] * rays.shape[1]).reshape(rays.shape)
    order[1::2] = order[1::2, ::-1]
    return flat(rays, order.ravel())


def ragged(rays):
    """Return rows of a picture and rows of half their length, one behind the other."""
    rows = [row if i % 2 else row[: len(row) // 2] for i, row in enumerate(np.arange(rays.shape[0] * rays.shape[1])
            .reshape(rays.shape))]  # fmt: skip
    return flat(rays, np.concatenate(rows))


PICTURE = perspective(256, 128)
OTHERS = {
    "none": lambda: co.Rays(np.zeros((0, 3)), np.zeros((0, 3))),
    "one": lambda: co.Rays((0, 0, -4), (0, 0, 1)),
    "few": lambda: flat(perspective(63, 64)),
    "one row": lambda: flat(perspective(1 << 14, 1)),
    "all the same": lambda: co.Rays(np.zeros((1 << 14, 3)), (0, 0, 1)),
    "in no order": lambda: flat(PICTURE, np.random.default_rng(0).permutation(256 * 128)),
    "rows in no order": lambda: flat(
        PICTURE, np.arange(256 * 128).reshape(128, 256)[np.random.default_rng(0).permutation(128)].ravel()
    ),
    "from the middle of a row": lambda: flat(PICTURE, np.arange(100, 256 * 100 + 100)),
    "an incomplete row": lambda: flat(PICTURE, np.arange(256 * 100 + 7)),
    "serpentine": lambda: serpentine(PICTURE),
    "ragged": lambda: ragged(PICTURE),
    "narrow": lambda: flat(perspective(16, 2048)),
}


@pytest.mark.parametrize("name", OTHERS)
def test_rays_out_of_scan_order_have_no_rows(name):
    assert row_length(OTHERS[name]()) == 0


@pytest.mark.parametrize("name", ["none", "one", "one row", "from the middle of a row", "serpentine", "ragged"])
def test_lists_without_rows_have_the_hits_of_their_rays(scene, name):
    rays = OTHERS[name]()
    hits = scene.first_hit(rays)
    some = np.arange(hits.t.size)[:: max(1, hits.t.size // 50)]
    assert_same(hits, scene.first_hit(*(part.reshape(-1, 3)[some] for part in rays)), some)
    assert np.array_equal(scene.occluded(rays), np.isfinite(hits.t))


@pytest.mark.parametrize(("width", "height"), [(131, 127), (129, 128)])
def test_a_flat_picture_has_the_hits_of_a_picture(scene, width, height):
    rays = perspective(width, height)
    hits, count = scene.first_hit(rays), width * height
    assert_same(hits, scene.first_hit(flat(rays)), np.arange(count))
    shuffled = np.random.default_rng(1).permutation(count)
    assert_same(hits, scene.first_hit(flat(rays, shuffled)), shuffled)
    assert np.array_equal(scene.occluded(flat(rays)), np.isfinite(hits.t).ravel())


@pytest.mark.parametrize("guess", [32, 64, 127, 12 * 127])
def test_a_wrong_guess_changes_nothing(scene, monkeypatch, guess):
    rays = flat(perspective(127, 192))
    hits, order = scene.first_hit(rays), np.arange(127 * 192)
    monkeypatch.setattr(queries, "row_length", lambda rays: guess)
    assert_same(hits, scene.first_hit(rays), order)
    assert np.array_equal(scene.occluded(rays), np.isfinite(hits.t))


@pytest.mark.parametrize("shape", [(3, 40, 24), (4, 10, 10), (4, 200, 3), (200, 2), (2, 200)])
def test_arrays_of_any_shape_have_the_hits_of_their_rays(scene, shape):
    """There are several pictures one behind the other, several rays for each pixel, several lines."""
    rays, count = camera(64), int(np.prod(shape))
    some = np.random.default_rng(2).choice(64 * 64, count, replace=False)
    hits, all_hits = scene.first_hit(*(x.reshape(-1, 3)[some].reshape(*shape, 3) for x in rays)), scene.first_hit(rays)
    assert hits.t.shape == shape
    for field in ("t", "body", "face", "surface"):
        assert np.array_equal(getattr(all_hits, field).ravel()[some], getattr(hits, field).ravel()), field
