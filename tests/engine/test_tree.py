"""The trees: every entry is in them once and within its boxes, for any shape and any number of threads that build them."""

import math

import numpy as np
import pytest

import conicoid as co
from benchmarks.comparison.scenes import core_xml
from conicoid.geometry.instances import InstanceList
from conicoid.io.openmc.universe_block import BlockBodies

from ..samples import deep
from ..thread_counts import on_threads
from .nodes import Nodes

# --- The trees: every entry is in them once and within its boxes, for any shape and any number of threads that build
# them


def balls(count, seed=0, size=0.5):
    random = np.random.default_rng(seed)
    return random.uniform(-1, 1, (count, 3)), size / max(count, 1) ** (1 / 3) * random.uniform(0.5, 1, count)


def nearest(centers, radii, origins, directions):
    """Return the first crossings of unit rays with balls, each with all, by the textbook's formula."""
    result = np.full(len(origins), math.inf)
    for center, radius in zip(centers, radii, strict=True):
        apart = origins - center
        half, power = (apart * directions).sum(axis=1), (apart**2).sum(axis=1) - radius**2
        square = half * half - power
        root = np.sqrt(np.maximum(square, 0))
        t = np.where(-half - root > 0, -half - root, -half + root)
        result = np.where((square > 0) & (t > 0), np.minimum(result, t), result)
    return result


def rays(count, seed=1):
    random = np.random.default_rng(seed)
    directions = random.normal(size=(count, 3))
    return random.uniform(-2, 2, (count, 3)), directions / np.linalg.norm(directions, axis=1, keepdims=True)


SCENES = {
    "none": (np.zeros((0, 3)), np.zeros(0)),
    "one": (np.zeros((1, 3)), np.ones(1)),
    "two": balls(2),
    "five": balls(5),
    "hundred": balls(100),
    "thousands": balls(3000),
    "one center": (np.zeros((500, 3)), np.linspace(0.1, 1, 500)),
    "the same ball": (np.ones((100, 3)), np.ones(100)),
    "on a line": (np.linspace((-1, -1, 0), (1, 1, 0), 300), np.full(300, 0.01)),
    "on a plane": (balls(300)[0] * (1, 1, 0), np.full(300, 0.02)),
    "each ten times the last": (10.0 ** -np.arange(60)[:, None] * (1, 0.3, 0.2), 10.0 ** -np.arange(60) * 0.1),
    "far away": (balls(200)[0] + (1e9, 0, 0), balls(200)[1]),
    "a dense place": (balls(2000)[0] * np.where(np.arange(2000)[:, None] < 1000, 1, 1e-12), np.full(2000, 1e-13)),
    "huge": (balls(50)[0] * 1e99, balls(50)[1] * 1e99),
    # Of these, one thread builds parts: by cells of a grid, but for wide balls, and again where most are in one cell
    "many, some wide": (balls(12_000)[0], np.where(np.arange(12_000) % 50 == 0, 0.3, 0.01)),
    "many on a line": (np.linspace((-1, -1, 0), (1, 1, 0), 10_000), np.full(10_000, 1e-4)),
    "many at one place": (np.ones((8193, 3)), np.full(8193, 0.5)),
    "many, one far away": (np.where(np.arange(9000)[:, None] == 7, 1e99, balls(9000)[0]), np.full(9000, 1e-3)),
    "halves of halves": (2.0 ** -(np.arange(9000)[:, None] % 320) * (1, 0, 1), np.full(9000, 1e-99)),
    "each a little nearer": (0.99 ** np.arange(20_000)[:, None] * (1, 0.3, 0.2), 0.99 ** np.arange(20_000) * 1e-3),
}


@pytest.mark.parametrize("name", SCENES)
def test_every_entry_stands_in_one_leaf_within_the_boxes_over_it(name):
    Nodes(co.Scene([co.Spheres(*SCENES[name])])).check()


@pytest.mark.parametrize("name", ["one", "two", "five", "hundred", "one center", "on a line", "on a plane"])
def test_hits_equal_those_of_each_ball_alone(name):
    centers, radii = SCENES[name]
    origins, directions = rays(3000)
    found = co.Scene([co.Spheres(centers, radii)]).first_hit(origins, directions).t
    expected = nearest(centers, radii, origins, directions)
    assert np.isfinite(expected).any()
    # All but the rays that graze, by the textbook's formula
    same = np.isfinite(found) == np.isfinite(expected)
    both = np.isfinite(found) & np.isfinite(expected)
    same[both] = np.abs(found[both] - expected[both]) < 1e-9
    assert same.mean() > 0.999


def test_a_large_tree_is_the_same_on_any_number_of_threads():
    """There are more entries than one thread builds alone, a third of them in one place."""
    centers, radii = balls(60_000)
    centers[::3] = 0.25
    radii[::3] = np.linspace(0.001, 0.002, 20_000)

    def prepare():
        scene = co.Scene([co.Spheres(centers, radii)])
        assert scene.memory.primitives == 60_000
        return scene

    first, *others = on_threads(prepare, 1, 2, 5)
    for other in others:
        for one, two in zip(first._prepared.geometry, other._prepared.geometry, strict=True):
            assert one.tobytes() == two.tobytes()
    Nodes(first).check()


def test_a_large_tree_finds_the_hits_of_a_small_one():
    """The nearest hit of six parts of a large scene, each by itself, is the hit of the scene."""
    centers, radii = balls(30_000)
    origins, directions = rays(5000)
    parts = [co.Scene([co.Spheres(centers[k::6], radii[k::6])]).first_hit(origins, directions) for k in range(6)]
    whole = co.Scene([co.Spheres(centers, radii)]).first_hit(origins, directions)
    t = np.array([part.t for part in parts])
    body = np.array([np.where(part.body >= 0, 6 * part.body + k, -1) for k, part in enumerate(parts)])
    assert np.array_equal(whole.t, t.min(axis=0))
    assert np.array_equal(whole.body, body[t.argmin(axis=0), np.arange(5000)])


def test_centers_that_are_all_equal_are_halved():
    scene = co.Scene([co.Spheres(np.ones((40_000, 3)), np.linspace(1, 2, 40_000))])
    Nodes(scene).check()
    assert scene.first_hit((1, 1, 9), (0, 0, -1)).t == 6


ROUND = {
    "x": dict(yy=1, zz=1),
    "y": dict(xx=1, zz=1),
    "z": dict(xx=1, yy=1),
}


def endless_cylinder(axis, place, radius):
    """Return all points within radius of a line along an axis."""
    offset = np.array(place, dtype=float)
    offset["xyz".index(axis)] = 0.0
    return co.Quadric(coefficients=dict(ROUND[axis], constant=-(radius**2))).translate(tuple(offset))


def into_cylinder(axis, place, radius, origins, directions):
    """Return (enter, leave) of rays by the quadratic formula."""
    k = [i for i in range(3) if "xyz"[i] != axis]
    apart, along = origins[:, k] - np.array(place)[k], directions[:, k]
    a, b, c = (along**2).sum(axis=1), (along * apart).sum(axis=1), (apart**2).sum(axis=1) - radius**2
    root = np.sqrt(np.maximum(b * b - a * c, 0))
    return np.where(b * b > a * c, (-b - root) / a, math.inf), np.where(b * b > a * c, (-b + root) / a, math.inf)


@pytest.fixture(scope="module")
def endless():
    """Return cylinders without ends along each axis, balls, and planes across and oblique."""
    random = np.random.default_rng(5)
    cylinders = [("xyz"[i % 3], random.uniform(-9, 9, 3), random.uniform(0.1, 0.4)) for i in range(240)]
    items = [endless_cylinder(*cylinder) for cylinder in cylinders]
    extra = [co.Spheres(*balls(50, size=2)), co.HalfSpace((0, 0, 1), -30.0), co.HalfSpace((1, 2, 3), -300.0)]
    return cylinders, co.Scene([*items, *extra])


def test_bodies_endless_along_some_axes_are_in_trees(endless):
    """Bodies without ends along x, y and z each have a tree. Half-spaces are endless along all three."""
    cylinders, scene = endless
    nodes = Nodes(scene)
    nodes.check()
    assert sorted(nodes.beside()) == [len(cylinders) + 50, len(cylinders) + 51]
    assert len([root for root in nodes.roots if root >= 0]) == 4


def test_hits_of_endless_things_are_those_of_each_by_itself(endless):
    cylinders, scene = endless
    origins, directions = rays(4000)
    origins = origins * 5
    directions[:300] = np.eye(3)[np.arange(300) % 3] * np.where(np.arange(300)[:, None] % 2, 1, -1)
    with np.errstate(divide="ignore", invalid="ignore"):
        ends = np.array([into_cylinder(*cylinder, origins, directions) for cylinder in cylinders])
    t = np.where(ends > 0, ends, math.inf).min(axis=(0, 1))
    expected = np.minimum(t, nearest(*balls(50, size=2), origins, directions))
    for normal, offset in (((0, 0, 1), -30.0), ((1, 2, 3), -300.0)):
        with np.errstate(divide="ignore", invalid="ignore"):
            crossing = (offset - origins @ normal) / (directions @ np.array(normal))
        expected = np.where(crossing > 0, np.minimum(expected, crossing), expected)
    found = scene.first_hit(origins, directions)
    assert (found.t < math.inf).mean() > 0.9
    assert np.array_equal(np.isfinite(found.t), np.isfinite(expected))
    finite = np.isfinite(expected)
    assert np.allclose(found.t[finite], expected[finite], rtol=1e-9, atol=0)


def test_whole_lines_through_endless_things(endless):
    """t begins at -inf, and the spans of each cylinder are its two roots."""
    cylinders, scene = endless
    origins, directions = rays(200)
    spans = scene.spans(origins, directions, t_min=-math.inf)
    ends = np.array([into_cylinder(*cylinder, origins, directions) for cylinder in cylinders])
    ray = np.repeat(np.arange(200), np.diff(spans.offsets))
    of_cylinder = spans.body < len(cylinders)
    assert of_cylinder.sum() == np.isfinite(ends[:, 0]).sum()
    body, ray = spans.body[of_cylinder], ray[of_cylinder]
    assert np.allclose(spans.t_enter[of_cylinder], ends[body, 0, ray], rtol=1e-8, atol=1e-8)
    assert np.allclose(spans.t_exit[of_cylinder], ends[body, 1, ray], rtol=1e-8, atol=1e-8)


def pins(side):
    """Return a square lattice of endless pins."""
    places = [(x, y, 0.0) for y in range(side) for x in range(side)]
    return co.Scene([endless_cylinder("z", place, 0.3) for place in places])


def test_pins_are_located_by_few_nodes():
    """Sixteen times as many pins need two more halvings along each axis, hardly more than one level of eight children."""
    random = np.random.default_rng(3)
    mean = {}
    for side in (8, 32):
        scene = pins(side)
        points = random.uniform((-0.5, -0.5, -1e6), (side - 0.5, side - 0.5, 1e6), (500, 3))
        nearest_pin = np.rint(points[:, :2])
        inside = ((points[:, :2] - nearest_pin) ** 2).sum(axis=1) < 0.09
        expected = np.where(inside, nearest_pin[:, 0] + side * nearest_pin[:, 1], -1)
        assert np.array_equal(scene.body_at(points), expected)
        nodes = Nodes(scene)
        nodes.check()
        assert nodes.beside() == []
        mean[side] = np.mean([nodes.visits(point) for point in points])
    assert mean[32] < mean[8] + 2
    assert mean[32] < 4


def test_long_thin_bodies_across_each_other():
    """Boxes of turned rods overlap. The hits are still those of each rod by itself."""
    random = np.random.default_rng(9)
    starts, ends = random.uniform(-1, 1, (2, 150, 3))
    scene = co.Scene([co.Cylinder(tuple(a), tuple(b), 0.01) for a, b in zip(starts, ends, strict=True)])
    Nodes(scene).check()
    origins, directions = rays(1000)
    alone = np.array([co.Scene([body]).first_hit(origins, directions).t for body in scene.bodies])
    assert np.array_equal(scene.first_hit(origins, directions).t, alone.min(axis=0))


def test_bodies_of_many_leaves_have_trees_of_their_own():
    """A ray meets a union of balls where the balls are."""
    centers, radii = balls(60)
    union = co.Sphere(radii[0], tuple(centers[0]))
    for center, radius in zip(centers[1:], radii[1:], strict=True):
        union = union | co.Sphere(radius, tuple(center))
    origins, directions = rays(2000)
    outside = (((origins[:, None] - centers) ** 2).sum(axis=2) > radii**2).all(axis=1)
    found = co.Scene([union]).first_hit(origins[outside], directions[outside]).t
    assert np.array_equal(
        found, co.Scene([co.Spheres(centers, radii)]).first_hit(origins[outside], directions[outside]).t
    )


def edits_of_a_core(path):
    """Return a core of 16 assemblies as it is, and with bodies moved, removed, and added between others."""
    core = co.load_openmc(path)
    yield core
    count = len(core.bodies)
    yield core.moved(count // 2, (0.01, 0.02, 0)).moved(0, (0, 0, 0.5)).without([count // 3, count - 1])
    yield core.added([co.Sphere(0.1, (0, 0, 200))], before=count // 2 + 9)
    yield core.without([0])
    yield co.Scene(core.bodies[::-1])
    yield co.Scene([core.bodies[k] for k in np.random.default_rng(0).permutation(count).tolist()])


@pytest.mark.parametrize("turned", [deep(""), "0 0 30"])
def test_assemblies_share_the_order_of_their_tree(turned, tmp_path, monkeypatch):
    path = tmp_path / "geometry.xml"
    path.write_text(core_xml(4, pins=5, turned=turned))
    scenes = list(edits_of_a_core(path))
    assert [len(scene.bodies.blocks()) for scene in scenes] == [16, 16, 16, 16, 16, 0]
    assert [len({form for _, _, form in scene.bodies.blocks()}) for scene in scenes[:5]] == [1, 4, 2, 2, 16]
    rng = np.random.default_rng(1)
    origins, directions = rng.uniform(-15, 15, (2000, 3)), rng.normal(size=(2000, 3))
    found = []
    for scene in scenes:
        Nodes(scene).check()
        found.append(scene.first_hit(origins, directions))
    monkeypatch.setattr(InstanceList, "blocks", lambda bodies: [])
    monkeypatch.setattr(BlockBodies, "blocks", lambda bodies: [])
    for scene, hits in zip(edits_of_a_core(path), found, strict=True):
        expected = scene.first_hit(origins, directions)
        assert np.array_equal(hits.t, expected.t)
        assert np.array_equal(hits.body, expected.body)


# --- Many bodies: the tree loses none of them, and rays in common walls belong to one side


def mixed(count, seed):
    """Return small shapes of many kinds at random places, some of them unbounded."""
    random = np.random.default_rng(seed)
    kinds = [
        lambda: co.Sphere(0.5), lambda: co.Box((-0.4, -0.3, -0.5), (0.3, 0.5, 0.2)), lambda: co.Cylinder((0, 0, -0.5), (0, 0, 0.5), 0.3),
        lambda: co.Cone((0, 0, 0), (0, 0, 1), 0.5, 0.1), lambda: co.EllipticParaboloid(2, 1, (0, 0.7)), lambda: co.OneSheetHyperboloid(9, 9, 4, (-0.5, 0.5)),
        lambda: co.Sphere(0.5) - co.Box((0, 0, 0), (1, 1, 1)), lambda: co.Polygon([(0, 0, 0), (0.9, 0, 0), (0.2, 0.2, 0), (0, 0.9, 0)]),
        lambda: co.Disc((0, 0, 0), (1, 1, 1), 0.5), lambda: co.Triangle((0, 0, 0), (1, 0, 0), (0, 1, 0)), lambda: co.TwoSheetHyperboloid(4, 4, 9, (-0.8, 0.8)),
    ]  # fmt: skip
    shapes = []
    for i in range(count):
        axis, place = random.normal(size=3), random.uniform(-6, 6, 3)
        shapes.append(kinds[i % len(kinds)]().rotate(axis, random.uniform(0, 360)).translate(place))
    return [
        *shapes,
        co.Plane((0, 0, 1), -7),
        co.HalfSpace((0, 1, 0.2), -8),
        co.EllipticCylinder(4, 4).translate((1, 1, 0)),
    ]


def test_a_crowd_is_the_union_of_its_members():
    """A scene of 200 bodies answers as its members do one by one."""
    shapes = mixed(200, 12)
    random = np.random.default_rng(13)
    origins, directions = random.uniform(-9, 9, (600, 3)), random.normal(size=(600, 3))
    whole = co.Scene(shapes)
    alone = [co.Scene([shape]) for shape in shapes]
    t = np.array([scene.first_hit(origins, directions).t for scene in alone])
    hits = whole.first_hit(origins, directions)
    assert np.array_equal(hits.t, t.min(axis=0))
    hit = np.isfinite(hits.t)
    assert np.array_equal(hits.body[hit], t.argmin(axis=0)[hit])
    counts = np.array([np.diff(scene.crossings(origins, directions).offsets) for scene in alone])
    assert np.array_equal(np.diff(whole.crossings(origins, directions).offsets), counts.sum(axis=0))
    lengths = whole.spans(origins, directions, t_min=-50, t_max=50).lengths()
    one_by_one = np.stack([s.spans(origins, directions, t_min=-50, t_max=50).lengths()[:, 0] for s in alone], axis=1)
    assert np.array_equal(lengths, one_by_one)
    contained = np.array([scene.contains(origins) for scene in alone])
    assert np.array_equal(whole.body_at(origins), np.where(contained.any(axis=0), contained.argmax(axis=0), -1))
