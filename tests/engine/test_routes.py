"""Every route of a query gives the same bits: packets, tiles, streams, lists and single rays, of every kind of body."""

import functools
import math
from fractions import Fraction

import numpy as np
import pytest

import conicoid as co
from conicoid.kernels.first_hits import coherent_packets
from conicoid.queries.ray_queries import _packets, arrays_of

from ..reference.random_items import tree
from ..reference.random_shapes import generator
from ..reference.routes import in_doubt
from ..samples import deep
from ..thread_counts import on_threads

# --- Every route of a query gives the same bits: packets, streams, lists and single rays, of every kind of body


# --- A ray has the same answer to the bit in a packet and alone, in any order and on any number of threads


FIELDS = ("t", "body", "face", "surface", "entering")


@functools.cache
def crowded_scene(count=300):
    """Return a prepared scene: balls, cells with one or two spans, Booleans, sheets, and an unbounded body."""
    rng = np.random.default_rng(7)
    centers, size = rng.uniform(-1, 1, (count, 3)), 0.5 / count ** (1 / 3)
    items = []
    for i, center in enumerate(centers):
        turn = (rng.normal(size=3), rng.uniform(0, 360))
        kinds = (
            lambda: co.Ellipsoid((size, size / 2, size), z_range=(-size / 2, size)),
            lambda: co.Box((-size, -size, -size), (size, size, size)),
            lambda: co.DoubleCone(1.0, z_range=(-size, size)),
            lambda: co.OneSheetHyperboloid(9 / size**2, 9 / size**2, 4 / size**2, z_range=(-size, size)),
            lambda: co.Sphere(size) - co.Cylinder((0, 0, -size), (0, 0, size), size / 2),
            lambda: co.Cylinder((0, 0, -size), (0, 0, size), size, 0, 250, (1, 0, 0)),
        )
        items.append(kinds[i % len(kinds)]().rotate(*turn).translate(center))
    flat = np.array([(0, 0, 0), (1, 0, 0), (1, 1, 0), (0.5, 0.5, 0), (0, 1, 0)]) * 0.3
    return co.Scene(
        [
            co.Spheres(rng.uniform(-1, 1, (50, 3)), 0.05),
            *items,
            co.Disc((0.5, 0.5, -1.1), (0, 0.2, 1), 0.3),
            co.Polygon([tuple(p) for p in flat]).translate((-1, 0, -1.2)),
            co.Plane((0, 1, 0), -1.2),
        ]
    )


def camera(width):
    return co.Camera((0.1, -0.2, -4), (0, 0, 0), up=(0, 1, 0), field_of_view=42).rays(width, width)


def reordered(rays, order):
    """Return the same rays in another order, as a flat list. Those that start on a surface still do."""
    return rays[np.unravel_index(order, rays.shape)]


def assert_same(one, other, order):
    for field in FIELDS:
        assert np.array_equal(getattr(one, field).ravel()[order], getattr(other, field)), field


@pytest.mark.parametrize("width", [96, deep(1024)])
def test_packets_tiles_rows_and_single_rays_agree_to_the_bit(width):
    scene, rays = crowded_scene(), camera(width)
    shuffled = np.random.default_rng(1).permutation(width * width)
    hits = scene.first_hit(rays)
    assert 0.3 < (hits.body >= 0).mean() < 1
    assert_same(hits, scene.first_hit(reordered(rays, np.arange(width * width))), np.arange(width * width))
    assert_same(hits, scene.first_hit(reordered(rays, shuffled)), shuffled)
    assert np.array_equal(scene.occluded(rays), hits.t < np.inf)
    assert np.array_equal(scene.occluded(reordered(rays, shuffled)), (hits.t < np.inf).ravel()[shuffled])


@pytest.mark.parametrize("width", [96, deep(1024)])
def test_rays_that_start_on_surfaces_agree_too(width):
    scene = crowded_scene()
    hits = scene.first_hit(camera(width))
    towards = np.where((hits.body >= 0)[..., None], np.array([3.0, 5.0, -6.0]) - hits.point, 1.0)
    shadow = hits.spawn(towards)
    order = np.random.default_rng(2).permutation(width * width)
    lit = scene.first_hit(shadow, t_max=1)
    assert_same(lit, scene.first_hit(reordered(shadow, order), t_max=1), order)
    assert np.array_equal(scene.occluded(shadow, t_max=1), lit.t < np.inf)
    assert np.array_equal(scene.occluded(reordered(shadow, order), t_max=1), (lit.t < np.inf).ravel()[order])


@pytest.mark.parametrize("shape", [(1, 1), (7, 3), (8, 8), (9, 17), (1, 200), (200, 1)])
def test_pictures_of_any_size(shape):
    """Tiles over the edge of the picture hold idle lanes."""
    scene = co.Scene([co.Sphere(1)])
    y, x = np.meshgrid(*(np.linspace(-1.2, 1.2, n) for n in shape), indexing="ij")
    origins = np.stack([x, y, np.full_like(x, 5.0)], axis=-1)
    hits = scene.first_hit(origins, (0, 0, -1))
    inside = x * x + y * y < 1
    assert np.array_equal(hits.body >= 0, inside)
    expected = 5 - np.sqrt(1 - x[inside] ** 2 - y[inside] ** 2)
    assert np.allclose(hits.t[inside], expected, rtol=1e-14, atol=0)


def test_streams_without_any_ray():
    """Rays with directions of extreme length go one by one, so that none is left for the streams."""
    r = np.random.default_rng(4)
    origins, directions = r.uniform(-2, 2, (4096, 3)), r.normal(size=(4096, 3))
    scene, small = crowded_scene(), 2.0**-170
    hits, same = scene.first_hit(origins, directions), scene.first_hit(origins, directions * small)
    assert np.array_equal(hits.t, same.t * small)
    assert np.array_equal(hits.body, same.body)


def test_grazing_rays_in_no_order_are_settled():
    """The distance of these lines along axes from the center is the ball's radius, but for rounding.

    Pythagoras' theorem decides.
    """
    r = np.random.default_rng(5)
    count, angle = 8192, r.uniform(0, 2 * np.pi, 8192)
    axis, sign = r.integers(0, 3, count), r.choice([-1.0, 1.0], count)
    a, b = np.cos(angle), np.sin(angle)
    origins = np.stack([np.choose(axis, (-2.0 * sign, b, a)), np.choose(axis, (a, -2.0 * sign, b)),
                        np.choose(axis, (b, a, -2.0 * sign))], axis=-1)  # fmt: skip
    directions = np.eye(3)[axis] * sign[:, None]
    inside = np.array([Fraction(x) ** 2 + Fraction(y) ** 2 < 1 for x, y in zip(a.tolist(), b.tolist(), strict=True)])
    assert 0.2 < inside.mean() < 0.8
    scene = co.Scene([co.Sphere(1)])
    hits = scene.first_hit(origins, directions)
    assert in_doubt(scene, hits.rays).mean() > 0.9
    assert np.array_equal(hits.body >= 0, inside)
    assert np.array_equal(scene.occluded(origins, directions), inside)


# --- Each kind of body has the same answer to the bit on every route: in lanes, in a stream, by single rays


COUNT = 16
RED = co.Material((1, 0, 0))


def balls(rng, count, size, reach):
    return [co.Sphere(size, reach * rng.normal(size=3)) for _ in range(count)]


def bodies(kind, rng, s):
    """Return one body of a kind, about the origin, of size s."""
    box = co.Box((-s, -s, -s), (s, s, s))
    if kind.startswith("union of"):
        return co.Union(tuple(balls(rng, int(kind.split()[-1]), 0.5 * s, 0.5 * s)))
    return {
        "box with flush bores": lambda: (
            box
            - co.Cylinder((0, 0, -s), (0, 0, s), 0.5 * s)
            - co.Cylinder((-s, 0, 0), (s, 0, 0), 0.5 * s)
            - co.Cylinder((0, -s, 0), (0, s, 0), 0.5 * s)
        ),
        "nested": lambda: ((box & co.Sphere(1.2 * s)) - (co.Sphere(0.7 * s) - box.scale(0.5))) | co.Sphere(0.2 * s),
        "a & a - b | b": lambda: ((box & box) - co.Sphere(1.1 * s)) | (co.Sphere(1.1 * s) & box.translate((s, 0, 0))),
        "complement": lambda: ~(~box | co.Sphere(1.2 * s)) | ~(~co.Sphere(0.3 * s)),
        "shared faces": lambda: box | box.translate((2 * s, 0, 0)) | box.translate((0, 2 * s, 0)) - co.Sphere(s),
        "painted cut": lambda: box.painted(RED) - co.Sphere(1.2 * s).painted(RED),
        "wedge": lambda: co.Cylinder((0, 0, -s), (0, 0, s), s, 20, 250, (1, 0, 0)) - co.Sphere(0.5 * s),
        "two spans": lambda: co.OneSheetHyperboloid(9 / s**2, 9 / s**2, 4 / s**2, z_range=(-s, s)) & co.Sphere(s),
        "double cone": lambda: co.DoubleCone(1.0, z_range=(-s, s)) | co.Sphere(0.3 * s),
        "unbounded leaves": lambda: co.HalfSpace((0, 0, 1), 0.2 * s) & co.Sphere(s) - co.HalfSpace((1, 0, 0), -0.5 * s),
        "clipped sheet": lambda: co.Disc((0, 0, 0), (0, 0, 1), s) - co.Cylinder((0, 0, -s), (0, 0, s), 0.4 * s),
        "polygon in a ball": lambda: co.Polygon([(-s, -s, 0), (s, -s, 0), (0, s, 0)]) & co.Sphere(0.8 * s),
    }[kind]()


KINDS = (
    *(f"union of {n}" for n in (2, 3, 8, 15, 16, 17, 40)),
    "box with flush bores", "nested", "a & a - b | b", "complement", "shared faces", "painted cut", "wedge",
    "two spans", "double cone", "unbounded leaves", "clipped sheet", "polygon in a ball",
)  # fmt: skip


@functools.cache
def scene_of(kind, depth=4):
    """Return a scene of bodies of a kind, prepared once for a process, with trees of so many levels at most."""
    rng = np.random.default_rng(len(kind))
    if kind == "trees":
        trees = [tree(generator("routes", seed), 1 + seed % depth).shape(co) for seed in range(COUNT)]
        return co.Scene([shape.scale(0.12).translate(rng.uniform(-1, 1, 3)) for shape in trees])
    placed = [
        bodies(kind, rng, 0.2).rotate(rng.normal(size=3), 360 * rng.random()).translate(rng.uniform(-1, 1, 3))
        for _ in range(COUNT - 4)
    ]
    # Some stay along the axes, so that rays run within faces and through edges
    upright = [bodies(kind, rng, 0.25).translate((0.5 * k - 1, 0.5, 1)) for k in range(4)]
    return co.Scene([*placed, *upright])


def scene_and_width(kind, large):
    """Return a scene of a kind, and the width of its pictures.

    Exact methods take milliseconds for a ray in trees of six levels.
    """
    if kind == "trees" and large:
        return scene_of(kind, 6), 20
    return scene_of(kind), 256 if large else 48


def rays_of(width):
    """Return rays of a camera, and rows of rays along the axes that meet faces, edges and corners."""
    camera = co.Camera((0.1, -0.2, -4), (0, 0, 0), up=(0, 1, 0), field_of_view=42).rays(width, width)
    x, y = np.meshgrid(np.linspace(-1.5, 1.5, width), np.linspace(-1.5, 1.5, width))
    grid = np.round(np.stack([x, y, np.full_like(x, -4.0)], axis=-1) * 16) / 16
    return camera, co.Rays(grid, np.broadcast_to([0.0, 0.0, 1.0], grid.shape))


@pytest.mark.parametrize("kind", [*KINDS, "trees"])
@pytest.mark.parametrize("large", [False, deep(True)], ids=["small", "large"])
def test_every_route_agrees_to_the_bit(kind, large):
    (scene, width), singles = scene_and_width(kind, large), 50
    for rays in rays_of(width):
        order = np.random.default_rng(1).permutation(width * width)
        hits = scene.first_hit(rays)
        assert (hits.body >= 0).any()
        shuffled = reordered(rays, order)
        again = scene.first_hit(shuffled)
        assert_same(hits, again, order)
        some = hits.body.ravel()[order] >= 0
        assert np.array_equal(hits.normal.reshape(-1, 3)[order][some], again.normal[some])
        assert np.array_equal(scene.occluded(rays), hits.t < np.inf)
        assert np.array_equal(scene.occluded(shuffled), again.t < np.inf)
        for k in range(0, width * width, width * width // singles):
            one = scene.first_hit(shuffled[k])
            for field in FIELDS:
                assert getattr(one, field) == getattr(again, field)[k], field


@pytest.mark.parametrize("length", [1.0, 1e-100])
def test_rays_that_begin_just_before_a_wall_of_their_origin_cross_it_at_plus_zero(length):
    """t is 0, never -0.0, on every route. t_min = -1e-250 is before the wall, for any short direction."""
    box = co.Box((-1, -1, -1), (1, 1, 1))
    for shape in (
        box, box - co.Sphere(0.5), co.HalfSpace((0, 0, 1), 1), co.Cylinder((0, 0, -1), (0, 0, 1), 1),
        co.Cone((0, 0, -1), (0, 0, 1), 2, 1), co.RegularPrism(4, 3, (-1, 1)), co.Disc((0, 0, 1), (0, 0, 1), 2),
        co.Union(tuple(box.scale((s, s, 1)) for s in np.linspace(0.5, 1, 20))),
    ):  # fmt: skip
        scene = co.Scene([shape])
        for way in ((0, 0, -1), (1, -1, 1)):
            packet = co.Rays(np.tile((0.125, 0.25, 1.0), (3, 1)), length * np.tile(way, (3, 1)))
            away = co.Rays((0.125, 0.25, 7.0), length * np.random.default_rng(2).choice((-1.0, 1.0), (2048, 3)))
            # Together, alone, alone by the short call, and beside rays without order
            for rays in (packet, packet[0], packet[0], co.Rays.concatenate([packet[:1], away])):
                hits, rows = scene.first_hit(rays, t_min=-1e-250), scene.crossings(rays, t_min=-1e-250)
                spans = scene.spans(rays, t_min=-1e-250)
                assert hits.t.ravel()[0] == 0 == rows.t[0], (shape, way)
                for t in (hits.t, rows.t, spans.t_enter, spans.t_exit):
                    assert not np.signbit(t[t == 0]).any(), (shape, way)


# --- Spans and crossings are the same to the bit, whether rays go in packets or by themselves


SPANS = ("t_enter", "t_exit", "body", "enter_clipped", "exit_clipped", "t_enter_error", "t_exit_error")
CROSSINGS = ("t", "body", "face", "surface", "entering", "t_error")
QUERIES = (("spans", SPANS), ("crossings", CROSSINGS))


def grid_rays(width):
    """Return rays of a camera at a part of a scene, and rows of parallel rays that meet faces, edges and corners."""
    camera = co.Camera((0.1, -0.2, -4), (0, 0, 0), up=(0, 1, 0), field_of_view=16).rays(width, width)
    x, y = np.meshgrid(np.arange(width) / 64 - 0.5, np.arange(width) / 64)
    grid = np.stack([x, y, np.full_like(x, -4.0)], axis=-1)
    return camera, co.Rays(grid, (0.0, 0.0, 1.0))


def share_of_packets(scene, rays, t_min=0.0):
    """Return the share of packets that are coherent, and so are traced as packets."""
    width, packets = _packets(rays)
    found = coherent_packets(
        scene._prepared.geometry, arrays_of("spans", scene._prepared, rays, t_min, math.inf), width, packets, packets
    )
    return found / packets


def rows_of(found, name, order):
    """Return a column in the order of some rays."""
    column, offsets = getattr(found, name), found.offsets
    return np.concatenate([column[offsets[i] : offsets[i + 1]] for i in order])


def assert_same_rows(query, names, scene, rays, t_min=0.0, t_max=math.inf):
    """Assert that packets have the rows of single rays, which are the same rays in no order.

    Return the rows of packets.
    """
    count = len(rays.origins.reshape(-1, 3))
    order = np.random.default_rng(1).permutation(count)
    flat = (np.broadcast_to(t, rays.shape).ravel()[order] for t in (t_min, t_max))
    packets, single = getattr(scene, query)(rays, None, t_min, t_max), reordered(rays, order)
    alone = getattr(scene, query)(single, None, *flat)
    assert np.array_equal(np.diff(packets.offsets)[order], np.diff(alone.offsets))
    for name in names:
        assert np.array_equal(rows_of(packets, name, order), getattr(alone, name)), name
    return packets


@pytest.mark.parametrize(("query", "names"), QUERIES)
@pytest.mark.parametrize("kind", [*KINDS, "trees"])
@pytest.mark.parametrize("large", [False, deep(True)], ids=["small", "large"])
def test_every_kind_of_body(kind, query, names, large):
    scene, width = scene_and_width(kind, large)
    for rays in grid_rays(width // 2 if "trees" in kind else width):
        assert share_of_packets(scene, rays) > 0.8
        found = assert_same_rows(query, names, scene, rays)
        assert len(found.body) > 0 or scene.bodies[0].shape.is_sheet


@pytest.mark.parametrize("kind", [*KINDS, "trees"])
@pytest.mark.parametrize("large", [False, deep(True)], ids=["small", "large"])
def test_parallel_lines(kind, large):
    """Lines begin before their origins. Parallel ones go in packets, for first hits too."""
    scene, width = scene_and_width(kind, large)
    rays = grid_rays(width)[1]
    middle = co.Rays(rays.origins + [0, 0, 4], rays.directions)
    for t_min in (-math.inf, -0.7):
        assert share_of_packets(scene, middle, t_min) > 0.9
        found = assert_same_rows("crossings", CROSSINGS[:-1], scene, middle, t_min)
        assert_same_rows("spans", SPANS[:-2], scene, middle, t_min)
        hits = scene.first_hit(middle, None, t_min)
        some = np.diff(found.offsets) > 0
        assert np.array_equal(some, hits.body.ravel() >= 0)
        for name in ("t", "body", "face", "surface", "entering"):
            assert np.array_equal(getattr(found, name)[found.offsets[:-1][some]], getattr(hits, name).ravel()[some])
        assert np.array_equal(scene.occluded(middle, None, t_min), hits.body >= 0)
    assert share_of_packets(scene, grid_rays(width)[0], -0.7) == 0


@pytest.mark.parametrize(("query", "names"), QUERIES)
def test_intervals(query, names):
    """Ends of an interval cut spans, and some intervals are empty."""
    scene, rays = crowded_scene(), grid_rays(96)[0]
    assert share_of_packets(scene, rays) > 0.9
    random = np.random.default_rng(5)
    whole = assert_same_rows(query, names, scene, rays)
    low, high = random.uniform(0, 6, (2, *rays.shape))
    part = assert_same_rows(query, names, scene, rays, low, high)
    assert 0 < len(part.body) < len(whole.body)
    assert assert_same_rows(query, names, scene, rays, 3.5, 4.5).offsets[-1] < len(whole.body)
    if query == "spans":
        assert part.enter_clipped.any()
        assert part.exit_clipped.any()


@pytest.mark.parametrize(("query", "names"), QUERIES)
def test_rays_that_start_on_surfaces(query, names):
    scene = co.Scene(
        [co.Sphere(2), co.Box((-1, -1, 3), (1, 1, 4)), co.Sphere(1, (0, 0, 6)) - co.Sphere(0.9, (0, 0, 6))]
    )
    x, y = np.meshgrid(np.linspace(-0.9, 0.9, 64), np.linspace(-0.9, 0.9, 64))
    hits = scene.first_hit(np.stack([x, y, np.full_like(x, -4.0)], axis=-1), (0, 0, 1))
    assert share_of_packets(scene, hits.spawn((0.0, 0.1, 1.0))) > 0.9
    for direction in ((0.0, 0.1, 1.0), (0.0, 0.1, -1.0)):
        assert_same_rows(query, names, scene, hits.spawn(direction))


@pytest.mark.parametrize("shape", [(1, 1), (7, 3), (8, 8), (9, 17), (1, 200), (200, 1), (33, 70)])
def test_lists_of_pictures_of_any_size(shape):
    """Concentric balls of radius 1, 2, .., 40: a ray at distance b from the center is in each for 2 sqrt(r² - b²)."""
    scene = co.Scene([co.Sphere(float(r)) for r in range(1, 41)])
    y, x = np.meshgrid(*(np.linspace(-5.6, 8.3, n) for n in shape), indexing="ij")
    origins = np.stack([x, y, np.full_like(x, 64.0)], axis=-1)
    spans = scene.spans(origins, (0, 0, -1))
    height = np.sqrt(np.maximum(np.arange(1, 41) ** 2 - (x * x + y * y)[..., None], 0))
    assert np.allclose(spans.lengths(), 2 * height, rtol=1e-12, atol=1e-6)
    assert np.array_equal(np.diff(spans.offsets), (height > 0).sum(axis=-1).ravel())
    for first, last in zip(spans.offsets[:-1], spans.offsets[1:], strict=True):
        assert (np.diff(spans.t_enter[first:last]) > 0).all()
        assert (np.diff(spans.body[first:last]) < 0).all()


@pytest.mark.parametrize("threads", [1, 2, 5])
def test_any_number_of_threads(threads):
    scene, rays = crowded_scene(), grid_rays(64)[0]
    expected, (spans,) = scene.spans(rays), on_threads(lambda: scene.spans(rays), threads)
    for name in ("offsets", *SPANS):
        assert np.array_equal(getattr(spans, name), getattr(expected, name))


# --- Tiles of pictures with more bodies than they can hold, or deeper than the one before: the same hits


def deep_scene():
    """Return 20,000 balls in a long corridor, and parallel rays along it.

    One tile sees all of them, more than it can hold.
    """
    rng = np.random.default_rng(1)
    scene = co.Scene([co.Spheres(rng.uniform(0, 1, (20_000, 3)) * (1, 1, 100), np.full(20_000, 0.006))])
    x, y = np.meshgrid((np.arange(32) + 0.5) / 32, (np.arange(32) + 0.5) / 32)
    origins = np.stack([x, y, np.full_like(x, -1.0)], axis=-1)
    return scene, co.Rays(origins, np.broadcast_to((0.0, 0.0, 1.0), origins.shape).copy())


def test_hits_are_the_same_where_a_tile_holds_nodes():
    scene, rays = deep_scene()
    order = np.random.default_rng(2).permutation(1024)
    together = scene.first_hit(rays)
    apart = scene.first_hit(rays.origins.reshape(-1, 3)[order], rays.directions.reshape(-1, 3)[order])
    assert np.array_equal(together.t.ravel()[order], apart.t)
    assert 0.3 < np.isfinite(apart.t).mean() < 1.0


def test_hits_are_the_same_where_a_tile_sees_further_than_the_one_before():
    """A wall with slots stands before a deep lattice.

    Some tiles end at the wall, and others beside them see through it.
    """
    x, y, z = (part.ravel() for part in np.meshgrid(np.arange(40.0), np.arange(20.0), np.arange(40.0)))
    slots = [co.Box((a, -9, -3), (a + 1.0, 9, -2)) for a in (-7.3, 0.4, 6.8)]
    wall = co.Box((-40, -20, -3), (40, 20, -2)) - slots[0] - slots[1] - slots[2]
    scene = co.Scene([co.Spheres(np.stack([x - 19.5, y - 9.5, z + 4.0], axis=1), np.full(len(x), 0.35)), wall])
    rays = co.Camera((0.3, 0.2, -30), (0, 0, 0), up=(0, 1, 0), field_of_view=34).rays(288, 96)
    order = np.random.default_rng(3).permutation(288 * 96)
    together, apart = scene.first_hit(rays), scene.first_hit(rays[np.unravel_index(order, rays.shape)])
    for field in ("t", "body", "face", "surface", "entering"):
        assert np.array_equal(getattr(together, field).ravel()[order], getattr(apart, field)), field
    visible = np.isin(np.arange(32_001), together.body)
    assert visible[:-1].sum() > 300, "balls through the slots"
    assert 0.5 < (together.body == 32_000).mean() < 0.95


@pytest.mark.parametrize("exponent", [-300, -270, -200, 200, 300])
def test_small_and_large_scenes_are_hit_alike(exponent):
    """In a scene of another size rays hit the same points. The ball around a sheared body of 1e-80 left out its tips."""
    scene, size = co.Scene([SHEARED]), 2.0**exponent
    resized = co.Scene([SHEARED.scale(size)])
    ends = np.random.default_rng(1).uniform(-4, 4, (2, 2000, 3))
    here, there = scene.first_hit(ends[0], ends[1] - ends[0]), resized.first_hit(ends[0] * size, ends[1] - ends[0])
    assert 0.2 < here.hit.mean() < 0.8
    assert np.array_equal(here.hit, there.hit)
    assert np.allclose(here.t[here.hit] * size, there.t[there.hit], rtol=1e-12, atol=0)


SHEARED = co.Ellipsoid((1.8, 1.1, 1.9)).transform(
    [[1.167, 0.258, 0.291, 0], [-0.125, 1.356, 0.225, 0], [0.048, 0.391, 1.66, 0], [0, 0, 0, 1]]
)
