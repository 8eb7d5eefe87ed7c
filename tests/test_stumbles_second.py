"""What a second trial of the package from its documentation stumbled on: right answers, or words that help."""

from __future__ import annotations

import copy
import math
import pickle
import warnings
from fractions import Fraction

import numpy as np
import pytest
from PIL import Image as Pillow

import conicoid as co
from conicoid.apps.checks.undefined_regions import _share_error
from conicoid.geometry.registry import REGISTRY
from conicoid.io.scene_file.scene_file import parse_scene

from .command_line import refused
from .contract.examples import examples_of

LEAD = co.metal("gray", name="lead", properties={"density": 11.35})
BALL = co.Sphere(1)
SCENE = co.Scene([co.Body(BALL, LEAD, "ball"), co.Body(co.Box((2, -1, -1), (4, 1, 1)), "blue", name="pillar")])
RAYS = co.Rays([(-5, 0, 0), (-5, 0, 9)], (1, 0, 0))
CAMERA = co.Camera((0, 0, 5), (0, 0, 0))
PIXELS = np.random.default_rng(3).random((4, 8, 3))
SCANS = {
    "parallel": co.ct.parallel([0, 30], 5, spacing=0.4),
    "parallel3d": co.ct.parallel3d([0, 30], 2, 5, spacing=0.4),
    "fan that ends in the ball": co.ct.fanflat([0, 30], 5, 3, 0.2, spacing=0.4),
    "fan before the ball": co.ct.fanflat([0, 30], 5, 3, -1.5, spacing=0.4),
    "cone": co.ct.cone([0, 30], 2, 5, 3, 2, spacing=0.4),
}


# --- the rays of a scan ---


@pytest.mark.parametrize("name", SCANS)
def test_every_query_of_the_rays_of_a_scan_goes_as_far_as_the_scan_says(name):
    """Lengths in a ball by hand: the chord, cut off at the source and the pixel, or whole for parallel rays."""
    scene, scan = co.Scene([BALL]), SCANS[name]
    rays = co.Rays.from_scan(scan)
    origins, directions = rays.made()
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


def test_an_interval_that_is_given_takes_the_place_of_that_of_a_scan():
    scene, rays = co.Scene([BALL]), co.Rays.from_scan(SCANS["parallel"])
    assert scene.lengths(rays)[0, 2, 0] == 2
    assert scene.lengths(rays, t_min=0)[0, 2, 0] == scene.lengths(rays, t_max=0.0)[0, 2, 0] == 1
    assert scene.lengths(rays.made())[0, 2, 0] == 1  # rays in arrays have no interval
    beyond = co.Rays.from_scan(SCANS["fan before the ball"])
    assert not scene.lengths(beyond).any()
    assert scene.lengths(beyond, t_max=math.inf).any()


# --- surroundings and pictures as light ---


@pytest.mark.parametrize("background", [co.Environment(PIXELS, 2, 30), co.materials.clear_sky((1, 0, 0.5), height=8)])
def test_scenes_with_surroundings_are_equal_to_what_comes_back_of_them(background, tmp_path):
    scene = co.Scene([BALL], background=background)
    scene.save(tmp_path / "s.yaml")
    for other in (co.load(tmp_path / "s.yaml"), pickle.loads(pickle.dumps(scene)), copy.deepcopy(scene)):
        assert other == scene
        assert hash(other.background) == hash(background)
    assert background not in (co.Environment(PIXELS, 2, 31), "white")


OVERLAPPING = co.Scene([BALL, co.Sphere(1, (0.5, 0, 0)), co.HalfSpace((0, 0, 1), -9)])
EQUAL = {
    "findings": lambda: co.check(OVERLAPPING, rays=1000),
    "finding": lambda: co.check(OVERLAPPING, rays=1000)[0],
    "measures": lambda: co.measure(BALL - co.Box((0, 0, 0), (1, 1, 1)), rays=100),
    "measures of a scene, one endless": lambda: co.measure(OVERLAPPING),
    "picture": lambda: SCENE.render(8, 6, samples=1, layers=True),
    "picture of numbers": lambda: co.Image([[1.0, math.nan], [math.inf, 0.0]], vmin=0),
    "developed picture": lambda: co.Image(PIXELS).developed(exposure=1, tone="agx"),
    "scan": lambda: co.ct.cone([0, 30], 2, 5, 3, 2),
    "rays of a scan": lambda: co.Rays.from_scan(co.ct.parallel([0, 30], 5)),
    "rays of a camera": lambda: co.Rays.from_camera(CAMERA, 4, 3),
    "bounds": lambda: OVERLAPPING.bounds,
    "surroundings": lambda: co.Environment(PIXELS),
}
OTHERS = {
    "finding": co.check(OVERLAPPING, rays=2000)[0],
    "measures": co.measure(BALL - co.Box((0, 0, 0), (1, 1, 1)), rays=100, seed=1),
    "picture": SCENE.render(8, 6, samples=1, layers=["depth"]),
    "developed picture": co.Image(PIXELS),
    "scan": co.ct.cone([0, 31], 2, 5, 3, 2),
    "rays of a camera": co.Rays.from_camera(CAMERA, 4, 4),
    "bounds": BALL.bounds,
}


@pytest.mark.parametrize("kind", EQUAL)
def test_what_is_found_twice_is_equal_and_so_are_copies(kind):
    one, other = EQUAL[kind](), EQUAL[kind]()
    for again in (other, pickle.loads(pickle.dumps(one)), copy.deepcopy(one)):
        assert (one == again) is True
        assert (one != again) is False
        if kind not in ("findings", "bounds"):
            assert hash(one) == hash(again)
    for different in (None, "x", OTHERS.get(kind, 3)):
        assert (one == different) is False


def test_bytes_and_pictures_are_surroundings_of_the_light_that_they_show(tmp_path):
    image = co.Image(PIXELS)
    np.testing.assert_allclose(co.Environment(image).pixels, PIXELS, rtol=1e-6)
    grey = np.full((2, 4, 3), 188, np.uint8)
    linear = ((188 / 255 + 0.055) / 1.055) ** 2.4  # IEC 61966-2-1
    np.testing.assert_allclose(co.Environment(grey).pixels, linear, rtol=1e-6)
    for suffix, error in ((".exr", 1e-6), (".png", 0.01)):
        image.save(tmp_path / f"sky{suffix}")
        read = co.Environment.of_file(tmp_path / f"sky{suffix}", rotation=30)
        assert read.rotation == 30
        assert np.abs(read.pixels - PIXELS).max() < error


@pytest.mark.parametrize("make", [co.Environment, co.materials.ImageTexture])
@pytest.mark.parametrize("kind", [np.int64, np.uint16, np.float64, np.float32])
def test_bytes_in_another_type_are_no_light(make, kind):
    board = np.arange(4 * 8 * 3).reshape(4, 8, 3).astype(kind)
    with pytest.raises(ValueError, match=r"up to 95 must be of uint8, sRGB bytes \(array.astype\('uint8'\)\)"):
        make(board)
    make(board.astype(np.uint8))
    make(np.where(board > 50, 20.0, 0.0))  # few whole numbers: a lamp, and not a picture


def test_a_texture_that_is_white_nearly_everywhere_is_warned_of():
    with pytest.warns(UserWarning, match="ImageTexture: most numbers of the array, up to .* are beyond 1"):
        co.materials.ImageTexture(255 * PIXELS)


@pytest.mark.parametrize("call", [
    lambda: co.Environment(PIXELS, rotation=math.pi / 2),
    lambda: co.materials.clear_sky() and co.Environment(PIXELS, 1, math.radians(30)),
])  # fmt: skip
def test_a_rotation_in_radians_is_warned_of(call):
    with pytest.warns(UserWarning, match="Environment: rotation must be in degrees, got"):
        call()


@pytest.mark.parametrize("make", [co.Environment, co.Environment.of_file])
def test_surroundings_are_read_from_files(make, tmp_path):
    co.Image(PIXELS).save(tmp_path / "sky.exr")
    assert make(tmp_path / "sky.exr") == make(str(tmp_path / "sky.exr")) == co.Environment(PIXELS.astype(np.float32))
    with pytest.raises(ValueError, match="^Environment: pixels: file is not an existing file: 'no.exr'$"):
        make("no.exr")


# --- numbers that mislead ---


def test_a_volume_that_is_estimated_has_an_error():
    scene = co.Scene([co.Body(co.Box((0, 0, 0), (1, 1, 1)), name="a")], domain=co.Box((0, 0, 0), (2, 1, 1)))
    for seed in range(3):
        (finding,) = co.check(scene, rays=20_000, seed=seed)
        assert finding.size_error > 0
        assert abs(finding.size - 1) < 5 * finding.size_error
        assert "± 0;" not in finding.message


@pytest.mark.parametrize("inside", [1, 100, 2048, 4095, 4096])
def test_the_error_of_a_share_is_that_of_the_beta_distribution(inside):
    a, b = inside + 1, 4096 - inside + 1
    variance = Fraction(a * b, (a + b) ** 2 * (a + b + 1))
    assert math.isclose(_share_error(inside), math.sqrt(variance), rel_tol=1e-12)


@pytest.mark.parametrize("scene", [co.Scene([BALL]), co.Scene([co.Body(BALL, "red")]), SCENE])
def test_a_property_that_no_material_has_is_an_error_whatever_stands_for_others(scene):
    for ask in (
        lambda: scene.line_integral("mu", RAYS, otherwise=0),
        lambda: scene.spans(RAYS).line_integral("mu", otherwise=0),
    ):
        with pytest.raises(ValueError, match="no material has a property 'mu'; properties: "):
            ask()


@pytest.mark.parametrize("values", ["mu", {}, np.zeros(0), np.zeros((0, 3))])
def test_an_empty_scene_has_line_integrals_of_zero(values):
    otherwise = dict(otherwise=0) if isinstance(values, (str, dict)) else {}
    assert not co.Scene([]).line_integral(values, RAYS, **otherwise).any()


@pytest.mark.parametrize("ask", [
    lambda hits: hits.material == "lead", lambda hits: hits.material[0] == "lead", lambda hits: LEAD != "lead",
    lambda hits: "lead" in [LEAD],
])  # fmt: skip
def test_a_material_that_is_compared_with_a_text_says_that_it_has_a_name(ask):
    with pytest.warns(UserWarning, match="a material equals no text, got 'lead': material.name == 'lead' compares"):
        ask(SCENE.first_hit(RAYS))
    with warnings.catch_warnings():
        warnings.simplefilter("error")
        assert copy.copy(LEAD) == LEAD
        assert LEAD not in (co.matte("red"), None, 3)


# --- words instead of Python's ---


def test_bounds_have_names():
    for thing in (BALL, SCENE, co.Spheres([(0, 0, 0)], [1])):
        low, high = thing.bounds
        assert np.array_equal(thing.bounds.low, low)
        assert np.array_equal(thing.bounds.high, high)
        assert isinstance(thing.bounds, tuple)
        assert repr(thing.bounds) == repr((low, high))
    with pytest.raises(AttributeError, match="has no attribute 'size': bounds.high - bounds.low is that"):
        _ = BALL.bounds.size
    with pytest.raises(AttributeError, match="has no attribute 'max': it is called high"):
        _ = SCENE.bounds.max


@pytest.mark.parametrize("name", sorted(REGISTRY))
def test_points_are_not_sought_in_shapes_by_in(name):
    with pytest.raises(TypeError, match=rf"^{name}: `in` means nothing here; .*contains\(points\)$"):
        assert (0, 0, 0) in examples_of(name)[0]
    with pytest.raises(TypeError, match=r"^Body: `in` means nothing here; .*co.Scene\(body\).contains"):
        assert (0, 0, 0) in co.Body(examples_of(name)[0])


IMAGE = SCENE.render(8, 6, samples=1, layers=["depth"])


@pytest.mark.parametrize(("call", "kind", "words"), [
    (lambda: LEAD["density"], TypeError, r"has no items: material.properties\['density'\] is"),
    (lambda: co.Box(1), TypeError, r"^Box: a box is given by two corners, Box\(low, high\), got one argument alone"),
    (lambda: co.Box(np.float64(2)), TypeError, r"^Box: a box is given by two corners"),
    (lambda: SCENE.replace("ball"), TypeError, r"got None; material= and name= change these alone$"),
    (lambda: SCENE.rays(-1, 48), ValueError, "^rays: width must be a whole number of pixels >= 1, got -1"),
    (lambda: CAMERA.rays(3, 0), ValueError, "^rays: height must be"),
    (lambda: CAMERA.project((0, 0, 0), 0, 1), ValueError, "^project: width must be"),
    (lambda: SCENE.render(0, 4), ValueError, "^render: width must be"),
    (lambda: SCENE.section("z", 0, width=0), ValueError, "^section: width must be"),
    (lambda: co.turntable(SCENE, "x.gif", width=0), ValueError, "^turntable: width must be"),
    (lambda: co.Rays.from_camera(CAMERA, 0, 1), ValueError, "^rays: width must be"),
    (lambda: SCENE.memory.cells, AttributeError, "it is called primitives"),
    (lambda: SCENE.memory.total, AttributeError, "memory.tables [+] memory.tree are all bytes"),
    (lambda: IMAGE.layers["body"], KeyError, r"rendered without 'body': scene.render\(layers=\['body'\]\) has it"),
    (lambda: IMAGE.layers["color"], KeyError, "no layer is called 'color': those are albedo, normal, depth"),
    (lambda: co.Image(PIXELS).layers["depth"], KeyError, "rendered without 'depth'"),
    (lambda: IMAGE.layers.depth, AttributeError, r"image.layers\['depth'\] is that"),
    (lambda: IMAGE * 2, TypeError, r"Image: pictures are no numbers: co.Image\(2 \* image.pixels\)"),
    (lambda: 0.5 * IMAGE, TypeError, "Image: pictures are no numbers"),
    (lambda: IMAGE - IMAGE, TypeError, "Image: pictures are no numbers"),
    (lambda: Pillow.fromarray(IMAGE), AttributeError, r"PIL.Image.fromarray\(np.asarray\(image\)\) is a picture of Pillow"),
    (lambda: IMAGE.to_bytes(), AttributeError, r"PIL.Image.fromarray\(np.asarray\(image\)\)"),
    (lambda: co.Spheres([(0, 0, 0)], [1]).single(3), IndexError, "Spheres.single: index must be at least 0 and below 1, got 3"),
    (lambda: co.Boxes([(0, 0, 0)], [(1, 1, 1)]).single(-1), IndexError, "Boxes.single: index must be at least 0 and below 1"),
    (lambda: co.Spheres([(0, 0, 0)], [1]).single("a"), TypeError, "Spheres.single: index must be a whole number, got 'a'"),
    (lambda: BALL.mirror("x"), AttributeError, r"sphere.scale\(\(-1, 1, 1\)\) is the mirror image"),
    (lambda: SCENE.info(), AttributeError, "`conicoid info scene.yaml` prints them"),
    (lambda: SCENE.query(RAYS), AttributeError, "scenes are asked by rays, scene.first_hit"),
    (lambda: CAMERA.moved((1, 0, 0)), AttributeError, r"dataclasses.replace\(camera, position=...\)"),
    (lambda: co.check(co.Scene([BALL, co.Sphere(2)]))[0].rays, AttributeError, "finding.origin and finding.direction"),
    (lambda: co.measure(SCENE).to_pandas(), AttributeError, "found.names, found.volume"),
    (lambda: RAYS.surface, AttributeError, "spawned rays know the surface"),
    (lambda: co.Rays.from_camera(CAMERA, 4, 3).directions, AttributeError, r"rays.made\(\).directions is that"),
    (lambda: co.Rays.from_scan(SCANS["cone"])[0], TypeError, r"rays.made\(\)\[...\]"),
    (lambda: [*co.Rays.from_camera(CAMERA, 4, 3)], TypeError, r"origins, directions = rays.made\(\)"),
    (lambda: co.parallel.Workers(), TypeError, r"^Workers\(\) missing executor; call it as Workers\(executor, "),
    (lambda: co.parallel.Workers(4, chunks=3), TypeError, r"has no argument 'chunks' \(did you mean chunk\?\)"),
    (lambda: next(SCENE.stream(RAYS, "line_integral", values="mu")), ValueError, "^line_integral: values: no property 'mu'"),
    (lambda: next(SCENE.stream(RAYS, values=[1])), TypeError, r"^Scene.first_hit\(\) has no argument 'values'"),
    (lambda: SCENE.stream(*RAYS), TypeError, "rays are one argument: stream"),
    (lambda: SCENE.stream(SCENE.first_hit(RAYS)), TypeError, "^stream: origins must be .* use its .rays"),
    (lambda: SCENE.stream(CAMERA), TypeError, r"^stream: .* \.rays\(width, height\)"),
    (lambda: SCENE.first_hit(CAMERA), TypeError, r"^first_hit: .* \.rays\(width, height\)"),
    (lambda: SCENE.lengths(SCANS["cone"]), TypeError, r"^lengths: .* co.Rays.from_scan\(geometry\) are its rays"),
    (lambda: SCENE.render(8, 6, progress=lambda done: None), TypeError,
     r"^render: progress must be called as progress\(done, count\); got the function <lambda>, which does not: too many"),
    (lambda: SCENE.render(8, 6, preview=lambda image, more: None), TypeError, r"must be called as preview\(image\)"),
    (lambda: co.measure(BALL - co.Box(), progress=lambda: None), TypeError, r"^measure: progress must be called as"),
    (lambda: SCENE.render(8, 6, camera="front"), TypeError, "camera must be a Camera, OrthographicCamera, EquirectangularCamera, FisheyeCamera or None"),
    (lambda: co.Scene([BALL], background=3), TypeError, "background must be a colour, a Sky, an Environment or None"),
    (lambda: SCENE.render(8, 6, workers=4), TypeError, r"executor=co.parallel.Processes\(count\)"),
    (lambda: SCENE.render(8, 6, tone="agx"), TypeError, r"has no argument 'tone': .* image.developed\(exposure, tone\)"),
    (lambda: SCENE.render(8, 6, denoise=True), TypeError, r"has no argument 'denoise': .* image.denoised\(\)"),
    (lambda: SCENE.section(axis="z", value=0), TypeError, r"did you mean plane\?.*did you mean at\?"),
    (lambda: co.Quadric(np.diag([1, 1, 1, -1])).classification.radius, AttributeError, "they are called semi_axes"),
    (lambda: SCENE.first_hit(RAYS).sort(), AttributeError, r"hits\[np.argsort\(hits.t\)\]"),
    (lambda: SCENE.first_hit(RAYS, threads=2), TypeError, r"threads are co.set_threads\(count\)"),
    (lambda: SCENE.occluded((0, 0, 0), target=(1, 0, 0)), TypeError, r"did you mean directions \(target - origins\)\?"),
    (lambda: SCENE.replace("ball", shape=co.Sphere(2)), TypeError, r"\(did you mean item\?\)"),
    (lambda: SCENE.bodies.pillar, AttributeError, r"scene\['pillar'\] is the one of that name"),
    (lambda: co.measure(SCENE)[0].name, AttributeError, r"co.measure\(scene\).names are those of bodies"),
    (lambda: co.measure(SCENE).sum(), AttributeError, r"found.volume.sum\(\) is that"),
    (lambda: co.measure(SCENE, "ball"), ValueError, r"measure\(scene\)\['ball'\]"),
    (lambda: (BALL - co.Box()).radius, AttributeError, r"difference.operands\[0\] is a shape that it is made of"),
    (lambda: (~BALL).radius, AttributeError, "complement.operand is a shape that it is made of"),
    (lambda: co.Quadric({"xx": 1}), ValueError, r"Quadric\(coefficients=\{...\}\) takes it"),
])  # fmt: skip
def test_what_is_reached_for_is_told_where_it_is(call, kind, words):
    with pytest.raises(kind, match=words):
        call()


def test_functions_that_python_knows_nothing_of_may_tell_of_progress():
    for progress in (print, lambda *numbers: None, lambda done, count: None, lambda done, count, more=0: None):
        co.Scene([BALL]).prepare(progress)


def test_packages_are_listed_with_the_public_names():
    assert {"ct", "parallel", "Scene"} <= set(dir(co))


# --- files and the command line ---


@pytest.mark.parametrize(("text", "words"), [
    ("bodies: [{shape: {Sphere: {}}}]\nbackground: Sky", "must be a mapping, {Sky: {...}}, got the bare word 'Sky'"),
    ("materials: {a: {metal: {}, properties: {density: 3}}}\nbodies: [{shape: {Sphere: {}}, material: a}]",
     "properties goes among its fields, {metal: {properties: ...}}"),
    ("bodies: [{shape: {Sphere: {}, name: c, material: red}}]", "name and material of a body stand beside `shape:`"),
    ("bodies: [{shape: {Sphere: {}}}]\nbackground: {Environment: {pixels: sky.exr}}", "is not an existing file: 'sky.exr' beside the scene"),
])  # fmt: skip
def test_things_in_the_wrong_place_of_a_file_are_told_of_the_right_one(text, words):
    with pytest.raises(co.SceneFileError) as error:
        parse_scene(text, "x.yaml")
    assert words in str(error.value)


def test_the_command_line_does_not_speak_of_python(tmp_path):
    SCENE.save(tmp_path / "s.yaml")
    np.save(tmp_path / "r.npy", [[-5, 0, 0, 1, 0, 0.0]])
    files = tmp_path / "s.yaml", tmp_path / "r.npy", "-o"
    told = refused("lengths", *files, tmp_path / "x.csv", "--value", "ball=1", "--otherwise", "0")
    assert "no material is called 'ball'; materials: 'lead'" in told
    assert "array" not in told
    assert "None" not in refused("lengths", *files, tmp_path / "x.csv", "--overlaps", "no")
    assert "written as .npz, .csv, .parquet or .zarr" in refused("trace", *files, tmp_path / "x.txt")
    assert "written as .npz or .csv" in refused("lengths", *files, tmp_path / "x.txt")
