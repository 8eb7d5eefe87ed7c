"""Pictures on an emulated GPU: the bits of the CPU, in pieces, and the parts that stay on the CPU."""

import numpy as np
import pytest

import conicoid as co
from conicoid.queries import device_choice, nvidia_driver
from conicoid.render import device_pictures
from conicoid.render.camera_rays import lower_view
from conicoid.render.exposure import lower_scene_light, make_job
from conicoid.render.integrators import INTEGRATORS, whitted
from conicoid.render.integrators.samples import Settings
from native import ptx

from ..emulation import Card, device_kernels, ptx_of
from ..engine.test_routes import crowded_scene
from ..interruptions import Interruption
from ..samples import deep, marked, sampled

WIDTH, HEIGHT = 45, 37
"""Width and height, which both end within a square and a tile."""


@pytest.fixture(scope="module")
def kernels():
    return device_kernels("pictures")


@pytest.fixture
def card(kernels, monkeypatch):
    """Return the card of this process, which takes pictures in small pieces."""
    emulated = Card(kernels)
    monkeypatch.setattr(nvidia_driver, "NvidiaDriver", lambda: emulated)
    monkeypatch.setattr(device_choice, "_devices", {})
    monkeypatch.setattr(device_pictures, "_CHUNK", 500)
    monkeypatch.setattr(device_pictures, "_FIRST", 3 * 1024)
    monkeypatch.setattr(device_pictures, "_MOST", 6 * 1024)
    yield emulated
    emulated.check()


def same_pictures(card, scene, integrator, samples=2, **options):
    """Assert that both devices render the same picture; return it."""
    options = dict(width=WIDTH, height=HEIGHT, samples=samples, integrator=integrator) | options
    expected = scene.render(**options, device="cpu")
    before = len(card.launches)
    found = scene.render(**options, device="cuda")
    used = {name for name, _ in card.launches[before:] if not name.startswith("render_albedo")}
    assert {name.rpartition("_")[0] for name in used} <= {f"render_{INTEGRATORS[integrator].module}"}
    assert len(card.launches) > before
    assert found.pixels.tobytes() == expected.pixels.tobytes()
    assert found.noise == expected.noise
    hidden = integrator == "albedo" and "fog(" in repr(scene.materials)
    assert hidden or expected.pixels.std() > 0.005  # not an empty picture; fog about all has no albedo
    return found


def ball(k, material, radius=0.45):
    """Return the k-th ball in a row of nine."""
    return co.Body(co.Sphere(radius, (k % 3 - 1, k // 3 - 1, 0.1 * (k % 2))), material)


NOISE = co.materials.Noise((0, 0, 0), (1, 1, 1), scale=0.2)
PICTURE = co.materials.ImageTexture(np.random.default_rng(5).uniform(0.2, 1, (9, 16, 3)))
SLOPES = co.materials.ImageTexture(np.random.default_rng(6).uniform(0.3, 0.7, (9, 16, 3)) + (0, 0, 0.3), data=True)
CAMERA = co.Camera((1.5, -4, 3.5), (0, 0, 0), field_of_view=45)
FLOOR = co.Body(co.Box((-4, -4, -1), (4, 4, -0.6)), co.Material(co.Checker(scale=0.7, space=True)))
LIGHTS = [
    co.AmbientLight(0.2),
    co.PointLight((3, -2, 4), 0.5),
    co.PointLight((-3, -2, 4), 8.0, falloff="inverse_square"),
    co.DirectionalLight((0.3, 0.5, -1), (0.3, 0.2, 0.1)),
    co.SpotLight((0, -3, 4), (0, 3, -4), angle=25, soft_edge=10, intensity=0.6),
]


def materials(lights=()):
    """Return nine balls of different surfaces."""
    kinds = [
        co.phong((0.8, 0.2, 0.1)), co.metal(), co.glass(absorption=(0.1, 0.5, 0.9)), co.materials.gold(0.2), co.plastic("teal", 1.5, 0.1),
        co.glass(1.6, roughness=0.15, dispersion=0.02), co.Material(PICTURE, roughness=NOISE, bump=NOISE, bump_height=0.1),
        co.Material(PICTURE, normal=SLOPES, specular=0.5, reflectivity=0.3, fresnel=True), co.materials.silver(NOISE),
    ]  # fmt: skip
    pane = co.Body(co.Disc((0, -1.8, 0.4), (0, 1, 0.2), 0.7), co.glass())
    return co.Scene([FLOOR, pane, *(ball(k, kind) for k, kind in enumerate(kinds))], lights, CAMERA)


def lamps(background=(0.02, 0.03, 0.05)):
    """Return lamps of all kinds over matte, coated and clear bodies."""
    glow, corners = co.glow((3, 2.5, 2)), [(-2, -1, 2), (-1, -1.2, 2.2), (-1, 0, 2), (-2, 0, 2)]
    bodies = [
        FLOOR, ball(0, co.matte((0.7, 0.5, 0.3))), ball(4, co.plastic("white")), ball(8, co.glass()), ball(2, co.metal()),
        co.Body(co.Sphere(0.3, (0, 1, 1.5)), glow), co.Body(co.Disc((1, -1, 2), (0, 0, -1), 0.5), glow),
        co.Body(co.Cylinder((-1, 2, 0.5), (1, 2, 0.5), 0.1), glow), co.Body(co.Polygon([corners[k] for k in (0, 3, 2)]), glow),
    ]  # fmt: skip
    return co.Scene(bodies, camera=CAMERA, background=background)


def liquids():
    """Return media in media, coincident walls, and fog around all."""
    cup = co.Cylinder((0, 0, -0.6), (0, 0, 0.8), 0.9) - co.Cylinder((0, 0, -0.4), (0, 0, 0.9), 0.7)
    water = co.Cylinder((0, 0, -0.4), (0, 0, 0.4), 0.7)
    bodies = [
        FLOOR, co.Body(cup, co.glass()), co.Body(water, co.glass(1.33, absorption=(0.6, 0.2, 0.05))),
        co.Body(co.Sphere(0.3, (0, 0, 0)), co.glass(1.33, absorption=(0.6, 0.2, 0.05))),
        co.Body(co.Sphere(0.4, (1.6, 0, 0)), co.matte("red")), co.Body(co.Box((-3, -3, -0.6), (3, 3, 3)), co.fog(0.15, 0.02, 0.4)),
    ]  # fmt: skip
    return co.Scene(bodies, LIGHTS, CAMERA)


def sky():
    """Return an image of the surroundings as the only light."""
    image = np.random.default_rng(7).uniform(0, 1, (8, 16, 3)) ** 4
    return lamps(co.Environment(image)).replace(lights=[])


def carved():
    """Return a Boolean body of forty leaves."""
    r = np.random.default_rng(40)
    holes = [co.Sphere(0.3).translate(r.uniform(-1.1, 1.1, 3)) for _ in range(39)]
    body = co.Body(co.Difference([co.Box((-1, -1, -1), (1, 1, 1)), *holes]), co.lacquer("orange"))
    return co.Scene([body, co.Sphere(0.2)], LIGHTS, CAMERA)


SCENES = {
    "crowd": lambda: crowded_scene().replace(camera=co.Camera((0.1, -0.2, -4), (0, 0, 0), up=(0, 1, 0)), lights=LIGHTS),
    "materials": lambda: materials(LIGHTS),
    "fitted lights": materials,
    "lamps": lamps,
    "liquids": liquids,
    "sky": sky,
    "carved": carved,
}


@pytest.mark.parametrize("integrator", ["whitted", "path", *map(deep, ("direct", "occlusion", "normals", "albedo"))])
@pytest.mark.parametrize("name", SCENES)
def test_pictures_are_those_of_the_cpu(card, name, integrator):
    same_pictures(card, SCENES[name](), integrator)
    sizes = {name.rpartition("_")[2] for name, _ in card.launches}
    assert sizes == {"any" if name == "carved" else "few"}


def test_all_integrators(card):
    for integrator in INTEGRATORS:
        same_pictures(card, materials(LIGHTS), integrator, 2)


@pytest.mark.parametrize("form", ["box", "mitchell", "gaussian"])
@pytest.mark.parametrize(
    "view",
    sampled(
        [
            co.Camera((1.5, -4, 3.5), (0, 0, 0), field_of_view=45, aperture=0.3, focus_distance=5.0, blades=5),
            co.Camera((1.5, -4, 3.5), (0, 0, 0), field_of_view=45, aperture=0.3),
            co.OrthographicCamera((1.5, -4, 3.5), (0, 0, 0), height=4),
            co.FisheyeCamera((0, 0, 1.5), (0, 1, 1)),
            co.EquirectangularCamera((0, 0, 1.5), (0, 1, 1)),
        ],
        3,
    ),
)
def test_cameras_and_filters(card, view, form):
    same_pictures(card, lamps(), "path", 3, camera=view, filter=form)
    same_pictures(card, lamps(), "whitted", 3, camera=view, filter=form)


def test_passes_layers_and_groups(card):
    scene, images, steps = lamps(), [], []
    found = same_pictures(
        card, scene, "path", 40, noise=0.08, layers=["albedo", "samples", "error"], groups={"sky": ["background"]},
        preview=lambda image: images.append(image.noise), progress=lambda *step: steps.append(step),
    )  # fmt: skip
    assert len(images) > 3
    assert steps[0][0] > 0
    assert steps[-1] == (steps[-1][1] // 40 * found.layers["samples"].max(), steps[-1][1])
    assert {name for name, _ in card.launches} == {"render_path_few", "render_albedo_few"}
    expected = scene.render(WIDTH, HEIGHT, 40, "path", noise=0.08, layers=["albedo", "samples", "error"], device="cpu")
    assert expected.layers["samples"].min() < 40  # squares have different numbers
    for layer, values in expected.layers.items():
        assert found.layers[layer].tobytes() == values.tobytes(), layer


def test_a_shutter(card):
    tracks = co.scene.BodyTrack("ball", (0, 1), translate=((0, 0, 0), (1, 0, 0)))
    scene = co.Scene([FLOOR, co.Body(co.Sphere(0.5), co.metal(), "ball")], LIGHTS, CAMERA, animation=tracks)
    for integrator in ("whitted", "path"):
        same_pictures(card, scene, integrator, 6, shutter=(0, 1), times=3)


def interrupt(card, monkeypatch, at):
    """Let Ctrl-C come at one of the checks for finished work."""
    monkeypatch.setattr(card, "is_done", Interruption(at, card.is_done))


@pytest.mark.parametrize("at", [5, 150, 400])
def test_ctrl_c_loses_no_whole_sample(card, monkeypatch, tmp_path, at):
    """The CPU or the card computes the rest, to the same bits."""
    scene, options = lamps(), dict(width=70, height=70, samples=20, integrator="path", resume=tmp_path / "film")
    expected = scene.render(**options | dict(resume=None), device="cpu")
    with monkeypatch.context() as once:
        interrupt(card, once, at)
        with pytest.raises(KeyboardInterrupt):
            scene.render(**options, device="cuda")
    found = scene.render(**options, device="cuda" if at == 150 else "cpu")
    assert found.pixels.tobytes() == expected.pixels.tobytes()


def test_progress_may_query_the_card(card):
    """The card is free between two pieces."""
    answers = []

    def progress(done, count):
        if not answers:
            answers.append(materials().render(WIDTH, HEIGHT, 1, "normals", device="cuda"))

    crowded_scene().render(WIDTH, HEIGHT, 2, "whitted", progress=progress, device="cuda")
    assert answers[0].pixels.any()


def test_pictures_equal_those_of_the_cpu(card, monkeypatch):
    """Deep trees of mirrored rays, many lights, and bodies beyond the card's memory have the same pictures."""
    lights = [co.PointLight((k, -3, 4), 0.02) for k in range(whitted.MOST_LIGHTS + 1)]
    for scene, depth in ((materials(LIGHTS), whitted.MOST_TURNS + 1), (materials(lights), 2)):
        options = dict(width=20, height=15, samples=4, integrator="whitted", depth=depth)
        assert scene.render(**options, device="cuda") == scene.render(**options)
        assert card.launches == []
    card._size = sum(map(len, card._rooms.values())) + (1 << 20)
    assert carved().render(20, 15, 4, device="cuda") == carved().render(20, 15, 4)
    assert card.launches == []


def test_which_device_renders(card, monkeypatch):
    scene = crowded_scene()
    monkeypatch.setenv("CONICOID_DEVICE", "cuda")
    scene.render(20, 12, 4)
    assert card.launches == []  # few rays
    scene.render(40, 30, 1, "normals")
    assert {name for name, _ in card.launches} == {"render_normals_few"}
    with pytest.raises(TypeError, match="render: device must be left out where workers compute"):
        scene.render(40, 30, executor=object(), device="cuda")
    with pytest.raises(ValueError, match="render: device must be 'cpu' or 'cuda', got 'gpu'"):
        scene.render(40, 30, device="gpu")


@pytest.mark.parametrize(
    "integrator", [name for name in INTEGRATORS if device_pictures._has_radiance(INTEGRATORS[name].module)]
)
def test_constants_are_those_that_kernels_take(integrator):
    """There are as many numbers as the entry has, in its order: floats where it takes floats."""
    scene, kind = materials(LIGHTS), INTEGRATORS[integrator]
    job = make_job(scene, 20, 15, 4, integrator, 0, 5, None)
    settings = Settings(4, 0, 5, lower_scene_light(scene, job.view, integrator))
    numbers = [*device_pictures._flatten(lower_view(job.view, job.filter)), *device_pictures._flatten(settings)]
    count = sum(len(each) if isinstance(each, tuple) else 1 for each in numbers)
    geometry, size, rest = 5, 4, 6  # rest: three arrays with their lengths
    assert count + geometry + size + rest == ptx.parameter_count(f"render_{kind.module}_few")
    leaves = ptx.LEAVES["pictures"][f"render_{kind.module}"]
    values = [each for record in (lower_view(job.view, job.filter), settings) for each in flat(record)]
    kinds = [each.kind for each in leaves if each.name.startswith(("view.", "settings.")) and each.kind not in "()"]
    assert [{"array": np.ndarray, "float": float, "int": int, "bool": bool, "none": type(None)}[k] for k in kinds] == [
        np.ndarray if isinstance(value, np.ndarray) else type(value) for value in values
    ]


def flat(value):
    """Return the leaves of a tuple."""
    return [leaf for each in value for leaf in flat(each)] if isinstance(value, tuple) else [value]


@pytest.mark.parametrize("name", marked((name, name == "render_occlusion_few") for name in ptx.PARTS["pictures"]))
def test_ptx_of_pictures(name):
    """Each build of a wheel makes all kernels; this is the quickest one."""
    assert f".entry {name}(" in ptx_of(name, "pictures")
