"""Results as values: shapes, joins, names, measures, and refraction, by independent formulas."""

import copy
import math
import pickle
from fractions import Fraction

import numpy as np
import pytest

import conicoid as co

RED, BLUE = co.matte("red", name="steel", properties={"density": 8.0}), co.matte("blue", name="steel")


SCENE = co.Scene([
    co.Body(co.Sphere(), RED, "car"), co.Body(co.Box((2, -1, -1), (3, 1, 1)), BLUE, "wall"),
    co.Spheres([(0, 0, 9), (0, 0, 12)], [1, 1]),
])  # fmt: skip


ORIGINS = np.stack(np.broadcast_arrays(np.linspace(-0.9, 3, 12).reshape(3, 4), 0.1, 20.0), axis=-1)


RAYS = co.Rays(ORIGINS, (0, 0, -1))


HITS, SPANS, CROSSINGS = SCENE.first_hit(RAYS), SCENE.spans(RAYS), SCENE.crossings(RAYS)


BALL, BOX = co.Sphere(), co.Box((2, 2, 2), (3, 3, 3))


CAMERA = co.Camera((0, 0, 5), (0, 0, 0))


STEEL = co.matte("red", name="steel", properties={"density": 7.8})


LEAD = co.metal("gray", name="lead", properties={"density": 11.35})


LEAD_SCENE = co.Scene([co.Body(BALL, LEAD, "ball"), co.Body(co.Box((2, -1, -1), (4, 1, 1)), "blue", name="pillar")])


LEAD_RAYS = co.Rays([(-5, 0, 0), (-5, 0, 9)], (1, 0, 0))


PIXELS = np.random.default_rng(3).random((4, 8, 3))


PILLARS = co.Scene([
    co.Body(co.Sphere(1), "red", "ball"), co.Body(co.Box((2, -1, -1), (4, 1, 1)), "blue", "pillar"),
])  # fmt: skip


# --- results of queries


def test_results_have_a_shape():
    assert HITS.shape == HITS.t.shape == SPANS.shape == CROSSINGS.shape == RAYS.shape == (3, 4)
    assert (HITS.ndim, HITS.size, RAYS.ndim, RAYS.size) == (2, 12, 2, 12)
    one = SCENE.first_hit((0, 0, 5), (0, 0, -1))
    assert (one.shape, one.ndim, one.size, one.rays.size) == ((), 0, 1, 1)
    assert SPANS.rays is SPANS[:].detached()._rays or SPANS.rays == RAYS
    assert repr(CROSSINGS) == f"Crossings(shape=(3, 4), {len(CROSSINGS.t)} crossings)"
    assert pickle.loads(pickle.dumps(SPANS)).shape == (3, 4)


def test_spans_are_indexed_over_all_rays():
    assert SPANS[6] == SCENE.spans(RAYS[1, 2])


@pytest.mark.parametrize("result", [HITS, HITS[0, 0], SPANS, CROSSINGS, RAYS])
def test_results_are_no_arrays(result):
    for use in (np.asarray, np.array, np.concatenate, np.isinf, np.mean, lambda x: np.float64(1) + x):
        with pytest.raises(TypeError):
            use(result)
    for use in (SCENE.contains, lambda x: co.refract(x, (0, 0, 1), 1.5), HITS.spawn):
        with pytest.raises(ValueError, match=rf"^\w+: \w+ must be .* got {type(result).__name__}\("):
            use(result)


@pytest.mark.parametrize(("low", "high"), [(5, 1), (np.inf, -np.inf), (np.full((3, 4), 30.0), 2), (19, 19)])
@pytest.mark.parametrize("query", [
    lambda **t: SCENE.first_hit(RAYS, **t).hit, lambda **t: SCENE.occluded(RAYS, **t), lambda **t: SCENE.crossings(RAYS, **t).body + 1,
    lambda **t: SCENE.lengths(RAYS, **t), lambda **t: SCENE.spans(RAYS, **t).lengths(), lambda **t: SCENE.line_integral([1] * 4, RAYS, **t),
])  # fmt: skip
def test_empty_interval_holds_nothing(query, low, high):
    """t_min is not below t_max."""
    assert not query(t_min=low, t_max=high).any()


def test_scene_rays_without_a_camera():
    assert SCENE.camera is None
    assert SCENE.rays(8, 6) == SCENE.fitting_camera(8 / 6).rays(8, 6)
    camera = co.Camera((0, 0, 50), (0, 0, 0))
    assert SCENE.replace(camera=camera).rays(8, 6) == camera.rays(8, 6)


SCANS = {
    "parallel": co.ct.parallel([0, 30], 5, spacing=0.4),
    "parallel3d": co.ct.parallel3d([0, 30], 2, 5, spacing=0.4),
    "fan that ends in the ball": co.ct.fanflat([0, 30], 5, 3, 0.2, spacing=0.4),
    "fan before the ball": co.ct.fanflat([0, 30], 5, 3, -1.5, spacing=0.4),
    "cone": co.ct.cone([0, 30], 2, 5, 3, 2, spacing=0.4),
}


@pytest.mark.parametrize("name", SCANS)
def test_rays_of_a_scan_have_its_interval(name):
    """Lengths in a ball are by hand: the chord, cut off at the source and the pixel, or whole for parallel rays."""
    scene, scan = co.Scene([BALL]), SCANS[name]
    rays = co.Rays.from_scan(scan)
    origins, directions = rays.to_rays()
    a, b = (directions**2).sum(-1), (origins * directions).sum(-1)
    half = np.sqrt(np.maximum(b * b - a * ((origins**2).sum(-1) - 1), 0))
    first, last = (-math.inf, math.inf) if scan.is_parallel else (0.0, 1.0)
    ends = (np.clip((side * half - b) / a, first, last) for side in (-1, 1))
    chord = -np.subtract(*ends) * np.sqrt(a)
    assert chord.any() or name == "fan before the ball"
    np.testing.assert_allclose(scene.lengths(rays)[..., 0], chord, atol=1e-12)
    np.testing.assert_allclose(scene.spans(rays).lengths()[..., 0], chord, atol=1e-12)
    np.testing.assert_allclose(scene.line_integral([2.0], rays), 2 * chord, atol=1e-12)
    parts = scene.stream(rays, "line_integral", values=[1.0], chunk=3)
    np.testing.assert_allclose(np.concatenate([part.ravel() for part in parts]), chord.ravel(), atol=1e-12)
    np.testing.assert_array_equal(scene.line_integral([1.0], rays), co.ct.project(scene, scan, [1.0]))
    assert np.array_equal(scene.occluded(rays), np.isfinite(scene.first_hit(rays).t))
    if scan.is_parallel:
        assert (scene.first_hit(rays).t < 0).any()
        assert len(scene.crossings(rays).t) == 2 * (chord > 0).sum()


def test_given_interval_replaces_that_of_a_scan():
    scene, rays = co.Scene([BALL]), co.Rays.from_scan(SCANS["parallel"])
    assert scene.lengths(rays)[0, 2, 0] == 2
    assert scene.lengths(rays, t_min=0)[0, 2, 0] == scene.lengths(rays, t_max=0.0)[0, 2, 0] == 1
    assert scene.lengths(rays.to_rays())[0, 2, 0] == 1  # rays in arrays have no interval
    beyond = co.Rays.from_scan(SCANS["fan before the ball"])
    assert not scene.lengths(beyond).any()
    assert scene.lengths(beyond, t_max=math.inf).any()


@pytest.mark.parametrize("values", ["mu", {}, np.zeros(0), np.zeros((0, 3))])
def test_line_integral_of_an_empty_scene(values):
    otherwise = dict(otherwise=0) if isinstance(values, (str, dict)) else {}
    assert not co.Scene([]).line_integral(values, LEAD_RAYS, **otherwise).any()


OVERLAPPING = co.Scene([BALL, co.Sphere(1, (0.5, 0, 0)), co.HalfSpace((0, 0, 1), -9)])


EQUAL = {
    "findings": lambda: co.check(OVERLAPPING, rays=1000),
    "finding": lambda: co.check(OVERLAPPING, rays=1000)[0],
    "measures": lambda: co.measure(BALL - co.Box((0, 0, 0), (1, 1, 1)), rays=100),
    "measures of a scene, one endless": lambda: co.measure(OVERLAPPING),
    "picture": lambda: LEAD_SCENE.render(8, 6, samples=1, layers=True),
    "picture of numbers": lambda: co.Image([[1.0, math.nan], [math.inf, 0.0]], vmin=0),
    "developed picture": lambda: co.Image(PIXELS).developed(exposure=1, tone="agx"),
    "scan": lambda: co.ct.cone([0, 30], 2, 5, 3, 2),
    "rays of a scan": lambda: co.Rays.from_scan(co.ct.parallel([0, 30], 5)),
    "rays of a camera": lambda: co.Rays.from_camera(CAMERA, 4, 3),
    "bounds": lambda: OVERLAPPING.bounds,
    "surroundings": lambda: co.Environment(PIXELS),
    "slice": lambda: PILLARS.slice("z", pixels=8),
    "voxels": lambda: PILLARS.voxels(shape=4),
    "shares of voxels": lambda: PILLARS.voxels(shape=4, fractions="material"),
    "parameters": lambda: co.parameters(PILLARS),
}


UNHASHABLE = {"findings", "bounds", "slice", "voxels", "shares of voxels", "parameters"}


RAISED = PILLARS.moved("ball", (0, 0, 0.5))
OTHERS = {
    "finding": co.check(OVERLAPPING, rays=2000)[0],
    "measures": co.measure(BALL - co.Box((0, 0, 0), (1, 1, 1)), rays=100, seed=1),
    "picture": LEAD_SCENE.render(8, 6, samples=1, layers=["depth"]),
    "developed picture": co.Image(PIXELS),
    "scan": co.ct.cone([0, 31], 2, 5, 3, 2),
    "rays of a camera": co.Rays.from_camera(CAMERA, 4, 4),
    "bounds": BALL.bounds,
    "slice": RAISED.slice("z", pixels=8),
    "voxels": RAISED.voxels(shape=4),
    "shares of voxels": RAISED.voxels(shape=4, fractions="material"),
    "parameters": co.parameters(RAISED),
}


@pytest.mark.parametrize("kind", EQUAL)
def test_equal_results_and_copies(kind):
    one, other = EQUAL[kind](), EQUAL[kind]()
    for again in (other, pickle.loads(pickle.dumps(one)), copy.deepcopy(one)):
        assert (one == again) is True
        assert (one != again) is False
        if kind not in UNHASHABLE:
            assert hash(one) == hash(again)
    for different in (None, "x", OTHERS.get(kind, 3)):
        assert (one == different) is False


@pytest.mark.parametrize("chunk", [None, 7, 1])
@pytest.mark.parametrize(
    "make",
    [
        lambda camera: camera.rays(8, 6),
        lambda camera: co.Rays.from_camera(camera, 8, 6),
        lambda camera: camera.rays(8, 6)[2],
    ],
)
def test_stream_writes_hits_of_a_picture(make, chunk, tmp_path):
    """The file's header had eight times the size of its arrays, and no program could read it."""
    rays = make(co.Camera((4, -9, 2), (2, 0, 0)))
    PILLARS.stream(rays, out=tmp_path / "hits.npz", chunk=chunk)
    found = co.Hits.load(tmp_path / "hits.npz")
    assert found == PILLARS.first_hit(rays).detached()
    assert PILLARS.stream(rays, out=tmp_path / "hits.csv", chunk=chunk) == found.size
    assert np.genfromtxt(tmp_path / "hits.csv", delimiter=",", names=True)["t"].tolist() == found.t.ravel().tolist()


PAIR = co.Scene([co.Body(BALL, co.matte("red", name="steel"), "ball"), BOX])
PAIR_RAYS = co.Rays([(0, 0, 5), (0.1, 0, 5)], (0, 0, -1))
PAIR_HITS = PAIR.first_hit(PAIR_RAYS)


@pytest.mark.parametrize(
    ("answer", "message"),
    [
        (
            PAIR.first_hit((0, 0, 5), (0, 0, -1)),
            "Hits(body 0 'ball', t=4.0, point=(0.0, 0.0, 1.0), normal=(0.0, 0.0, 1.0), face=0, entering=True)",
        ),
        (
            PAIR_HITS[0].detached(),
            "Hits(body 0 'ball', t=4.0, point=(0.0, 0.0, 1.0), normal=(0.0, 0.0, 1.0), face=0, entering=True)",
        ),
        (PAIR.first_hit((9, 9, 9), (0, 0, 1)), "Hits(a miss, t=inf)"),
        (PAIR_RAYS[0], "Rays((0.0, 0.0, 5.0), (0.0, 0.0, -1.0))"),
        (PAIR.spans((0, 0, 5), (0, 0, -1)), "Spans(shape=(), 1 span: body 0 'ball' [4.0, 6.0])"),
        (PAIR.spans((2.5, 2.5, 0), (0, 0, 2)), "Spans(shape=(), 1 span: body 1 [1.0, 1.5])"),
        (
            PAIR.crossings((0, 0, 5), (0, 0, -1)),
            "Crossings(shape=(), 2 crossings: body 0 'ball' t=4.0, body 0 'ball' t=6.0)",
        ),
        (PAIR.spans((9, 9, 9), (0, 0, 1)), "Spans(shape=(), 0 spans)"),
        (PAIR_HITS, "Hits(shape=(2,), 2 of 2 rays hit)"),
    ],
)
def test_repr_of_results(answer, message):
    assert repr(answer) == message


# --- scenes and shapes


@pytest.mark.parametrize(("change", "expected"), [
    (lambda scene: scene.replace("ball", material="green")["ball"], co.Body(co.Sphere(), "green", "ball")),
    (lambda scene: scene.replace(1, name="cube")["cube"], co.Body(co.Box(), "blue", "cube")),
    (lambda scene: scene.replace("box", name=None, material=None).bodies[1], co.Body(co.Box())),
    (lambda scene: scene.replace("box", co.Body(co.Sphere(2), "white"))["box"], co.Body(co.Sphere(2), "white", "box")),
    (lambda scene: scene.replace("box", co.Sphere(2), name="big")["big"], co.Body(co.Sphere(2), "blue", "big")),
])  # fmt: skip
def test_scene_replace_in_part(change, expected):
    assert change(co.Scene([co.Body(co.Sphere(), "red", "ball"), co.Body(co.Box(), "blue", "box")])) == expected


def test_bodies_index_by_name_in_a_lattice(tmp_path):
    (tmp_path / "g.xml").write_text("""<geometry>
      <surface id="1" type="z-cylinder" coeffs="0 0 0.4"/>
      <surface id="9" type="sphere" coeffs="0 0 0 9" boundary="vacuum"/>
      <cell id="1" universe="1" material="1" region="-1"/><cell id="2" universe="1" material="2" region="1"/>
      <lattice id="5" dimension="3 3" lower_left="-1.5 -1.5" pitch="1 1" universes="1 1 1 1 1 1 1 1 1"/>
      <cell id="4" fill="5" region="-9"/></geometry>""")
    scene = co.load(tmp_path / "g.xml")
    for number in range(len(scene)):
        body = scene.body(number)
        assert scene.bodies.index(body) == scene.bodies.index(body.name) == number
    with pytest.raises(KeyError, match="no body named 'cell 7'"):
        scene.bodies.index("cell 7")
    with pytest.raises(ValueError, match="is none of them"):
        scene.bodies.index(PILLARS["ball"])


TRACK = co.scene.BodyTrack("ball", times=(0, 1), translate=((0, 0, 0), (2, 0, 0)))


def test_scene_refuses_a_track_of_no_body(tmp_path):
    """`load` refused the file that `save` wrote of it."""
    with pytest.raises(KeyError, match=r"Scene: animation\[0\]: no body named 'ball'"):
        co.Scene([co.Sphere()], animation=TRACK)
    moving = PILLARS.replace(animation=TRACK)
    for change in (lambda: moving.without("ball"), lambda: moving.replace("ball", name="disc")):
        with pytest.raises(KeyError, match=r"Scene: animation\[0\]: no body named 'ball'"):
            change()
    assert moving.replace(animation=None).without("ball").body_count == 1
    co.save(moving, tmp_path / "moving.yaml")
    assert co.load(tmp_path / "moving.yaml") == moving


def test_rotate_and_scale_about_a_point():
    turned = BOX.rotate("z", 90, about=(2, 2, 0))
    assert turned == BOX.translate((-2, -2, 0)).rotate("z", 90).translate((2, 2, 0))
    # (x, y) goes to (2 - (y - 2), 2 + (x - 2)): x from 1 to 2, y from 2 to 3, to the bit
    assert [end.tolist() for end in turned.bounds] == [[1, 2, 2], [2, 3, 3]]
    assert [end.tolist() for end in BOX.scale(2, about=(3, 3, 3)).bounds] == [[1, 1, 1], [3, 3, 3]]
    point = np.array((0.1, 0.2, 0.3))
    assert co.Sphere(0.5, tuple(point)).rotate((1, 1, 1), 77, about=point).bounds[0] == pytest.approx(point - 0.5)
    body = co.Body(BOX, "red", "box")
    assert body.rotate("z", 90, about=(2, 2, 0)) == co.Body(turned, "red", "box")
    assert body.translate((1, 0, 0)).scale(2).transform(np.eye(4)).name == "box"
    for wrong in ((1, 2), "x", (math.nan, 0, 0)):
        with pytest.raises(ValueError, match=r"^rotate: about(\[0\])? must be"):
            BALL.rotate("z", 1, about=wrong)


@pytest.mark.parametrize(
    ("material", "message"),
    [
        (co.Material(), "Material()"),
        (co.matte("red"), "matte(color='red')"),
        (co.Material("red"), "Material(color='red')"),
        (co.glass(1.5, name="crown"), "glass(refractive_index=1.5, name='crown')"),
        (co.metal("gold", reflectivity=0.7), "metal(color='gold', reflectivity=0.7)"),
        (co.mirror(), "mirror()"),
        (co.lacquer(properties={"mu": 2}), "lacquer(properties={'mu': 2})"),
        (co.phong(specular=0.25), "phong(specular=0.25)"),
        (co.materials.gold(), "gold()"),
        (co.materials.conductor(roughness=0.2), "conductor(roughness=0.2)"),
    ],
)
def test_repr_of_materials(material, message):
    assert repr(material) == message
    names = {name: getattr(co, name) for name in ("matte", "glass", "metal", "Material")}
    assert eval(message, vars(co) | vars(co.materials) | names) == material


@pytest.mark.parametrize("turn", [lambda s: s, lambda s: s.translate((0.5, -1, 0.1)), lambda s: s.rotate("z", 90)])
def test_bounds_that_are_zero(turn):
    balls = turn(co.Spheres([(1, 0.5, 2), (3, 0.5, 2)], [1, 0.5]))
    low, high = co.Scene([balls, co.Body(turn(co.Sphere(0.5, (0.5, 0.5, 0.5))))]).bounds
    assert not any(0 < abs(end) < 1e-300 for end in (*low, *high))
    low, high = co.Spheres([(1, 2, 3)], [1]).bounds
    assert (low.tolist(), high.tolist()) == ([0, 1, 2], [2, 3, 4])


def test_bounds_of_balls_are_tight():

    random = np.random.default_rng(3)
    centers, radii, shift = random.normal(size=(200, 3)), random.random(200) + 1e-9, (0.1, 1e-17, -3e8)
    low, high = co.Spheres(centers, radii).translate(shift).bounds
    for i in range(3):
        ends = [
            (Fraction(c) + Fraction(shift[i]), Fraction(r))
            for c, r in zip(centers[:, i].tolist(), radii.tolist(), strict=True)
        ]
        most, least = max(c + r for c, r in ends), min(c - r for c, r in ends)
        assert Fraction(np.nextafter(high[i], -np.inf).item()) < most <= Fraction(high[i].item())
        assert Fraction(low[i].item()) <= least < Fraction(np.nextafter(low[i], np.inf).item())


def test_repr_of_a_moved_shape_makes_it():
    names = {name: getattr(co, name) for name in ("Sphere", "Box", "Cylinder", "Disc")}
    disc = co.Disc((0, 0, 0), (0, 0, 1), 1)
    for shape in (
        co.Sphere(1.5).translate((1, 2, 3)), co.Box().rotate("z", 30).scale((1, 2, 3)),
        co.Cylinder((0, 0, 0), (0, 0, 1), 2).transform([(1, 0, 0, 2), (0, 1, 0, 0), (0, 0, 1, 0), (0, 0, 0, 1)]),
        disc.rotate((1, 1, 0), 45.5).translate((0, 0, 1e-9)),
        (disc.rotate("x", 20) & co.Sphere(1)).rotate("y", 10), disc - co.Box(),
    ):  # fmt: skip
        assert eval(repr(shape), names) == shape
    long = co.Sphere()
    for _ in range(30):
        long = long.translate((0, 0, 1))
    assert len(repr(long)) < 500
    assert " ... 22 more moves ... " in repr(long)


def test_bounds_have_names():
    for instance in (BALL, LEAD_SCENE, co.Spheres([(0, 0, 0)], [1])):
        low, high = instance.bounds
        assert np.array_equal(instance.bounds.low, low)
        assert np.array_equal(instance.bounds.high, high)
        assert isinstance(instance.bounds, tuple)
        assert repr(instance.bounds) == repr((low, high))
    with pytest.raises(AttributeError, match="has no attribute 'max': did you mean high"):
        _ = LEAD_SCENE.bounds.max


# --- measures and checks


def test_material_name_stands_for_all_that_have_it():
    """Columns, and `by_material`, have one place for each different material. A name stands for all of that name."""
    assert SCENE.materials == SPANS.materials == (RED, BLUE, None)
    columns = SPANS.lengths(by="material")
    assert np.array_equal(SCENE.lengths(RAYS, by="material"), columns)
    by_name = SPANS.line_integral({"steel": 1}, otherwise=0)
    assert np.allclose(by_name, columns[..., 0] + columns[..., 1], rtol=1e-15)
    found = co.measure(SCENE)
    assert math.isclose(found["steel"].volume, found.by_material[0].volume + found.by_material[1].volume)
    titles = [line.split("  ")[0] for line in str(found).splitlines()[1:4]]
    assert titles == ["material 'steel' of body 0", "material 'steel' of body 1", "no material"]


def test_measures_by_name():
    found = co.measure(SCENE)
    assert found["car"] is found[0]
    assert found["wall"].volume == 4
    with pytest.raises(KeyError, match="no material and no body is called 'cra'; names: .*did you mean 'car'"):
        found["cra"]
    water = co.matte(name="water")
    both = co.Scene([co.Body(co.Box(), water, "water"), co.Body(co.Sphere(), water)])
    with pytest.raises(KeyError, match="both a material and a body are called 'water'"):
        co.measure(both)["water"]
    assert co.measure(co.Scene(both.bodies[:1]))["water"].volume == 8


def test_check_names_omitted_checks(tmp_path):
    found = co.check(co.Sphere(), rays=500)
    assert found == []
    assert found.omissions == ("undefined regions (the scene has no domain for its bodies to fill)",)
    assert repr(found).startswith("Findings([], not looked for: undefined regions (the scene has no domain")
    assert str(found).splitlines() == ["nothing found", f"not looked for: {found.omissions[0]}"]
    assert pickle.loads(pickle.dumps(found)).omissions == found.omissions
    assert copy.copy(found).omissions == found.omissions
    none = co.check(co.Scene([], domain=co.Sphere() & co.Sphere(1, (5, 0, 0))), rays=500)
    assert none.omissions == ("undefined regions (the scene's domain is empty)",)
    whole = co.check(co.Scene(co.Sphere(), domain=co.Sphere()), rays=500)
    assert (whole, whole.omissions, repr(whole)) == ([], (), "Findings([])")
    assert isinstance(whole, co.checks.Findings)


def test_estimated_volume_has_an_error():
    scene = co.Scene([co.Body(co.Box((0, 0, 0), (1, 1, 1)), name="a")], domain=co.Box((0, 0, 0), (2, 1, 1)))
    for seed in range(3):
        (finding,) = co.check(scene, rays=5_000, seed=seed)
        assert finding.size_error > 0
        assert abs(finding.size - 1) < 5 * finding.size_error
        assert "± 0;" not in finding.message


# --- pictures and surroundings


@pytest.mark.parametrize("background", [co.Environment(PIXELS, 2, 30), co.materials.clear_sky((1, 0, 0.5), height=8)])
def test_scene_with_surroundings_comes_back(background, tmp_path):
    scene = co.Scene([BALL], background=background)
    scene.save(tmp_path / "s.yaml")
    for other in (co.load(tmp_path / "s.yaml"), pickle.loads(pickle.dumps(scene)), copy.deepcopy(scene)):
        assert other == scene
        assert hash(other.background) == hash(background)
    assert background not in (co.Environment(PIXELS, 2, 31), "white")


def test_environment_of_bytes_and_pictures(tmp_path):
    pytest.importorskip("OpenEXR")
    image = co.Image(PIXELS)
    np.testing.assert_allclose(co.Environment(image).pixels, PIXELS, rtol=1e-6)
    grey = np.full((2, 4, 3), 188, np.uint8)
    linear = ((188 / 255 + 0.055) / 1.055) ** 2.4  # IEC 61966-2-1
    np.testing.assert_allclose(co.Environment(grey).pixels, linear, rtol=1e-6)
    for suffix, error in ((".exr", 1e-6), (".png", 0.01)):
        image.save(tmp_path / f"sky{suffix}")
        read = co.Environment(tmp_path / f"sky{suffix}", rotation=30)
        assert read.rotation == 30
        assert np.abs(read.pixels - PIXELS).max() < error


def test_environment_of_files(tmp_path):
    pytest.importorskip("OpenEXR")
    co.Image(PIXELS).save(tmp_path / "sky.exr")
    named = co.Environment(str(tmp_path / "sky.exr"))
    assert co.Environment(tmp_path / "sky.exr") == named == co.Environment(PIXELS.astype(np.float32))
    with pytest.raises(ValueError, match="^Environment: pixels: file is not an existing file: 'no.exr'$"):
        co.Environment("no.exr")


# --- light at a wavelength


BK7 = co.optics.glass("N-BK7")


WAVES = 0.45, 0.5875618, 0.65


def index_by_tracing(scene, wavelength):
    """Return the index of the first medium, from `trace_paths`."""
    paths = co.optics.trace_paths(scene, co.Rays([(1, 0, -5)], (0, 0, 1)), depth=1, wavelength=wavelength)
    return float(paths.index[(paths.level == 1) & ~paths.mirrored][0])


@pytest.mark.parametrize("wavelength", WAVES)
@pytest.mark.parametrize(
    ("glass", "index"),
    [
        (co.glass(1.5, dispersion=0.01), lambda w: 1.5 + 0.01 * (1 / w**2 - 1 / 0.5875618**2)),
        (co.glass(co.optics.Cauchy([1.47, 0.01])), lambda w: 1.47 + 0.01 / w**2),
        (co.glass("N-BK7"), BK7),
        (co.glass(1.5 + 1e-3j), lambda w: 1.5),
        (co.glass(lambda w: 1.4 + 0.1 * w), lambda w: 1.4 + 0.1 * w),
    ],
)
def test_trace_paths_and_focal_length_use_one_index(glass, index, wavelength):
    """A ball's focal length is n D / (4 (n - 1)). `trace_paths` ignored a glass's `dispersion`."""
    scene, n = co.Scene([co.Body(co.Sphere(10, (0, 0, 10)), glass)]), float(index(wavelength))
    assert math.isclose(index_by_tracing(scene, wavelength), n, rel_tol=1e-14)
    assert math.isclose(co.optics.focal_length(scene, wavelength), 20 * n / (4 * (n - 1)), rel_tol=1e-9)


@pytest.mark.parametrize("medium", ["N-SF11", co.glass("N-SF11"), (1.78472, 25.68), co.glass(1.7, dispersion=0.012)])
@pytest.mark.parametrize("wavelength", WAVES)
def test_scene_of_a_prescription_has_its_glass(medium, wavelength):
    lens = co.optics.prescription([(50, 5, medium, 20), (-50, None)], aperture=5)
    n = index_by_tracing(lens.scene, wavelength)
    if "N-SF11" in str(medium):
        assert math.isclose(n, co.optics.glass("N-SF11")(wavelength), rel_tol=1e-14)
    lensmaker = (n - 1) * (2 / 50 - (n - 1) * 5 / (n * 50**2))
    assert math.isclose(co.optics.focal_length(lens, wavelength) * lensmaker, 1, rel_tol=1e-9)
    assert math.isclose(co.optics.focal_length(lens.scene, wavelength) * lensmaker, 1, rel_tol=1e-9)


def test_doublet_of_glasses_by_name():
    by_name = co.Doublet((62.8, -45.7, -128.2), (4, 2.5), 25.4, ("N-BK7", co.optics.glass("SF5")))
    assert [material.refractive_index for material in by_name.materials] == ["N-BK7", co.optics.glass("SF5")]
    with pytest.raises(ValueError, match="N-BK77"):
        co.Doublet((62.8, -45.7, -128.2), (4, 2.5), 25.4, ("N-BK77", 1.7))
